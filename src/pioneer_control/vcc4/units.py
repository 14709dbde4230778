"""Angles, zoom and speeds of the cameras: units and limits (camera sheet 2, 4).

A camera counts angles in steps of 0.1125 degrees from its home. As it stands upright, pan grows to the right and tilt
grows upwards.
"""

import math
from typing import Dict, NamedTuple, Tuple

COUNT_DEG = 0.1125
"""Degrees of one count of pan and tilt. A speed of 1 is this angle a second."""
ZERO = 0x8000
"""What is added to a count on the wire, so that home is 8000 (hex)."""
ZOOM_MOST = 1960
"""The zoom step at the tele end; 0 is the wide end. Steps are neither degrees nor a factor."""

WIDE_DEG, TELE_DEG = 45.0, 3.0
"""Usual horizontal fields of view (degrees) at both ends of the zoom. Nobody publishes them."""

Range = Tuple[int, int]


class CameraModel(NamedTuple):
    """What a model can do. Ranges are least and most, in counts.

    Attributes:
        pan, tilt: where software sends it. A little less than the mechanics allow.
        pan_mechanics, tilt_mechanics: where its mechanics end.
        tilt_at_power_on: its movable range of tilt, until another one is set.
        pan_speed, tilt_speed: speeds (counts a second).
        product: what it answers when it is asked which product it is. That of the VC-C4 is not confirmed.
        has_lamp: it has an infrared filter, an infrared lamp and an electronic zoom.
    """

    pan: Range = (-871, 871)
    tilt: Range = (-267, 782)
    pan_mechanics: Range = (-889, 889)
    tilt_mechanics: Range = (-267, 800)
    tilt_at_power_on: Range = (-267, 267)
    pan_speed: Range = (8, 800)
    tilt_speed: Range = (8, 622)
    product: str = "VCC4 "
    has_lamp: bool = False


CAMERA_MODELS: Dict[str, CameraModel] = {
    "vcc4": CameraModel(),
    "vcc50i": CameraModel(product="C50i ", has_lamp=True),
}
"""The models by the names of the parameter `ptz`."""


def count_of(degrees: float) -> int:
    """Return the count that is nearest to an angle (degrees, finite)."""
    return round(degrees / COUNT_DEG)


def degrees_of(count: int) -> float:
    """Return the angle (degrees) of a count."""
    return count * COUNT_DEG


def field_of_view(zoom: float, wide_deg: float = WIDE_DEG, tele_deg: float = TELE_DEG) -> float:
    """Return the horizontal field of view (rad) at a zoom step: equal steps narrow it by equal factors.

    Nobody knows the true curve.
    """
    return math.radians(wide_deg * (tele_deg / wide_deg) ** (zoom / ZOOM_MOST))

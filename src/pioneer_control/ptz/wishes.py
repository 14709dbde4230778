"""What a program wants of a camera now, and what is known of the camera: two notes that the conversation looks at."""

from dataclasses import dataclass, field
from typing import Dict, NamedTuple, Optional, Tuple

from .settings import Cabling


class CameraMove(NamedTuple):
    """A command that turns the camera, or zooms. Each wish is an object of its own: it may equal the one before."""

    name: str
    values: Tuple[int, ...] = ()


@dataclass
class Wishes:
    """What is still to be said to the camera. Of each kind the newest counts.

    Attributes:
        stop: stop pan, tilt and zoom. It goes before all others.
        moves: where to look, and the zoom: each by the question that asks how far the camera is.
        off: switch it off.
    """

    stop: bool = False
    moves: Dict[str, CameraMove] = field(default_factory=dict)
    off: bool = False


@dataclass
class KnownCamera:
    """What is known of the camera. Counts are the camera's own.

    Attributes:
        cabling: whether it answers; AUTO while that is not known.
        has_power: whether it is on. None: not known.
        position: pan, tilt as it says, or as it was told when it never says anything. None: not known.
        zoom: its zoom step, in the same way.
        position_at: time (s) of the position.
        last_error: what went wrong last, for people; empty: nothing.
        watched: what may still move: by the question for it the last answer, None if it was not asked yet.
    """

    cabling: Cabling
    has_power: Optional[bool] = None
    position: Optional[Tuple[int, int]] = None
    zoom: Optional[int] = None
    position_at: float = 0.0
    last_error: str = ""
    watched: Dict[str, Optional[Tuple[int, ...]]] = field(default_factory=dict)

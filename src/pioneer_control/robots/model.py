"""The values of one robot model, in SI units and in the frame base_link.

Factors that turn units of the wire into millimetres and radians have the unit in their names. Everything else is in
metres, radians and seconds.

Source: REP 103 (x forward, y left, counter-clockwise positive).
"""

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Optional, Tuple

Point = Tuple[float, float]

ARRAY_SIZE = 8          # transducers are wired in arrays of eight, by number (ARCOS manual)
GRIP_STATE_FIRST = frozenset(["AROS", "ARCOS", "AmigoSH"])


class Transducer(NamedTuple):
    """One sonar transducer: its number on the wire and where it sits and looks (m, rad, base_link)."""

    number: int
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class GripperShape:
    """The Pioneer 2/3 gripper: lengths in m, times in s, distances of beams ahead of the palm."""

    paddle_start: float
    paddle_length: float
    paddle_thickness: float
    opening: float
    close_time: float
    lift_height: float
    lift_speed: float
    inner_beam: float
    outer_beam: float
    grasp_time: float
    min_object: float
    max_object: float

    @property
    def reach(self) -> float:
        """Distance (m) from the front of the body to the tips of the paddles."""
        return self.paddle_start + self.paddle_length

    @property
    def width(self) -> float:
        """Width (m) over the outsides of the fully open paddles."""
        return self.opening + 2 * self.paddle_thickness


@dataclass(frozen=True)
class RobotModel:
    """One row of the model table.

    ``sonar`` holds the transducers that are fitted, in the order of their numbers; numbers may have gaps.
    ``angle_rad_per_unit`` is the exact fraction of a turn, not a rounded number from a parameter file. ``wheel_radius``
    is None where it is not known.
    """

    subtype: str
    firmware_family: str
    length_front: float
    length_rear: float
    width: float
    max_linear: float
    max_angular: float
    angle_units_per_rev: int
    dist_mm_per_unit: float
    vel_mm_s_per_unit: float
    range_mm_per_unit: float
    diff_rad_per_mm: float
    vel2_mm_s_per_unit: float
    sonar: Tuple[Transducer, ...]
    front_bumpers: int
    rear_bumpers: int
    battery_class: int
    can_carry_gripper: bool
    gripper: GripperShape
    wheel_radius: Optional[float] = None

    @property
    def angle_rad_per_unit(self) -> float:
        """One unit of THPOS in rad."""
        return 2 * math.pi / self.angle_units_per_rev

    @property
    def sonar_count(self) -> int:
        """Highest fitted transducer number plus one: the length of a list indexed by number."""
        return 1 + max((transducer.number for transducer in self.sonar), default=-1)

    @property
    def grip_state_first(self) -> bool:
        """Whether the gripper's state is the first of the two bytes after the sonar of a SIP."""
        return self.firmware_family in GRIP_STATE_FIRST

    @functools.lru_cache(maxsize=None)
    def outline(self, gripper: bool = False) -> Tuple[Point, ...]:
        """Outline of the body from above (m), counter-clockwise from the rear right corner.

        Args:
            gripper: include the open paddles.
        """
        front, rear, side = self.length_front, -self.length_rear, self.width / 2
        if not gripper:
            return ((rear, -side), (front, -side), (front, side), (rear, side))
        tip, paddles = front + self.gripper.reach, min(self.gripper.width / 2, side)
        return ((rear, -side), (front, -side), (front, -paddles), (tip, -paddles), (tip, paddles), (front, paddles),
                (front, side), (rear, side))

    @functools.lru_cache(maxsize=None)
    def with_arrays(self, front: bool, rear: bool) -> "RobotModel":
        """This model without the sonar arrays that are not fitted (CONFIGpac says it: FrontSonar, RearSonar)."""
        return replace(self, sonar=tuple(
            each for each in self.sonar if (front if self._array_looks_ahead(each) else rear)))

    def _array_looks_ahead(self, transducer: Transducer) -> bool:
        """Whether most of the array of a transducer looks ahead. An AmigoBot's only array does; two of it look back."""
        array = [each for each in self.sonar if each.number // ARRAY_SIZE == transducer.number // ARRAY_SIZE]
        return sum(math.cos(each.heading) for each in array) > -1e-9

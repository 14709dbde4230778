"""The properties of one robot model: size, limits, sonar and gripper, in the frame base_link.

Values are in metres, radians and seconds. Only the factors that convert raw values from the robot have other units;
their names contain the unit, for example ``dist_mm_per_unit``.

Source: REP 103 (x forward, y left, counter-clockwise positive).
"""

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Optional, Tuple

Point = Tuple[float, float]

ARRAY_SIZE = 8          # transducers are wired in arrays of eight, by number (ARCOS manual)
HALF_CONE = math.radians(12.5)
"""Half the opening angle (rad) of the cone in which a transducer hears."""
SONAR_HEIGHT = 0.17
"""The height (m) of the transducers above the floor on a Pioneer 3. We use it for the sonar frames of all models."""
GRIP_STATE_FIRST = frozenset(["AROS", "ARCOS", "AmigoSH"])


class Transducer(NamedTuple):
    """One sonar transducer: its number in the protocol, and its position and direction (m, rad, base_link)."""

    number: int
    x: float
    y: float
    heading: float


class LaserPlace(NamedTuple):
    """Where a laser range finder is mounted (m, base_link; its first ray of a symmetric scan looks to the right).

    Attributes:
        x, y: where its mirror is. It looks ahead.
        z: how high its mirror is. None if that is not known: it is measured on the robot.
        upside_down: whether it hangs. Then it measures from left to right.
    """

    x: float
    y: float
    z: Optional[float] = None
    upside_down: bool = False


@dataclass(frozen=True)
class BodyShape:
    """How a robot looks in pictures (m; base_link). All of it is by eye; only pictures use it.

    The hull is below and the deck above the ring of sonar transducers. A tower has a second deck with a ring of its
    own. ``height``, ``clearance`` (the underside of the hull), ``ring`` (bottom and top) and ``tower`` (its top; 0
    without one) are heights above the floor. ``overhang`` is from the front of the deck to the front of the hull.
    ``axles`` are the places (x) of the pairs of wheels, and ``castors`` those of the castors. ``upper_arrays`` are the
    sonar arrays in the tower (0 has the transducers 0 to 7).
    """

    height: float
    clearance: float
    ring: Tuple[float, ...]
    overhang: float
    wheel_radius: float
    wheel_width: float
    wheels_inside: bool
    axles: Tuple[float, ...]
    castors: Tuple[float, ...]
    castor_radius: float
    tower: float
    upper_arrays: Tuple[int, ...]


@dataclass(frozen=True)
class GripperShape:
    """The Pioneer 2/3 gripper: lengths in m, times in s, speed in m/s.

    The palm is where the paddles begin. ``paddle_start`` is the distance from the front of the body to the palm.
    ``inner_beam`` and ``outer_beam`` are the distances from the palm to the light beams between the paddles.
    """

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
        """The distance (m) from the front of the body to the tips of the paddles."""
        return self.paddle_start + self.paddle_length

    @property
    def width(self) -> float:
        """The width (m) of the fully open gripper, from the outside of one paddle to the outside of the other."""
        return self.opening + 2 * self.paddle_thickness


@dataclass(frozen=True)
class RobotModel:
    """The properties of one robot model: one entry of the table of models (m, rad, s; base_link).

    ``length_front`` and ``length_rear`` begin at the centre of rotation. ``sonar`` holds the fitted transducers in the
    order of their numbers, which may have gaps. ``wheel_radius`` is None when it is not known, and so is ``laser``, the
    place of the first laser, if one is fitted. ``shape`` is for pictures only.

    The last three correct what one robot measures: ``turn_factor`` is how far it turns for each turn that it counts,
    ``curve_rad_per_m`` how far it turns besides for each metre ahead, and ``gyro_factor`` how far it turns for each
    turn that its gyro measures, where the client reads the gyro.
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
    shape: BodyShape
    wheel_radius: Optional[float] = None
    laser: Optional[LaserPlace] = None
    turn_factor: float = 1.0
    curve_rad_per_m: float = 0.0
    gyro_factor: float = 1.0

    @property
    def angle_rad_per_unit(self) -> float:
        """The size (rad) of one unit of THPOS, the raw heading in a SIP."""
        return 2 * math.pi / self.angle_units_per_rev

    @property
    def sonar_count(self) -> int:
        """The length of a list of ranges whose index is the transducer number: the highest fitted number plus one."""
        return 1 + max((transducer.number for transducer in self.sonar), default=-1)

    @property
    def grip_state_first(self) -> bool:
        """Whether the state of the gripper is the first of the two bytes that follow the sonar readings in a SIP."""
        return self.firmware_family in GRIP_STATE_FIRST

    @functools.lru_cache(maxsize=None)
    def outline(self, gripper: bool = False) -> Tuple[Point, ...]:
        """Return the corners (x, y) of the robot seen from above (m, base_link).

        They are counter-clockwise and begin at the rear right. ``gripper``: include the open paddles of the gripper.
        """
        front, rear, side = self.length_front, -self.length_rear, self.width / 2
        if not gripper:
            return ((rear, -side), (front, -side), (front, side), (rear, side))
        tip, paddles = front + self.gripper.reach, min(self.gripper.width / 2, side)
        return ((rear, -side), (front, -side), (front, -paddles), (tip, -paddles), (tip, paddles), (front, paddles),
                (front, side), (rear, side))

    @functools.lru_cache(maxsize=None)
    def with_arrays(self, front: bool, rear: bool) -> "RobotModel":
        """Return a copy of this model that has only the fitted sonar arrays.

        Args:
            front: the front array is fitted (FrontSonar in the CONFIGpac of the robot).
            rear: the rear array is fitted (RearSonar in the CONFIGpac).
        """
        return replace(self, sonar=tuple(
            each for each in self.sonar if (front if self._array_looks_ahead(each) else rear)))

    def _array_looks_ahead(self, transducer: Transducer) -> bool:
        """Return whether the sonar array of a transducer looks mainly forward.

        The single array of an AmigoBot counts as looking forward, although two of its eight transducers look back.
        """
        array = [each for each in self.sonar if each.number // ARRAY_SIZE == transducer.number // ARRAY_SIZE]
        return sum(math.cos(each.heading) for each in array) > -1e-9

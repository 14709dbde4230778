"""The joints of an arm: their names, and what the arm reports of them as values in rad, m and seconds (arm sheet 15).

The gripper is a joint whose value is the opening between its fingers (m), from closed at its lowest tick to open at its
highest: nobody has measured how wide it is in between, so this is linear.
"""

import math
from typing import Dict, List, NamedTuple, Tuple

from .. import p2os

GRIPPER = "arm_gripper_joint"
JOINT_NAMES = ("arm_base_joint", "arm_shoulder_joint", "arm_elbow_joint", "arm_roll_joint", "arm_wrist_joint", GRIPPER)
"""Names in the order of the servos 1 to 6."""
SIGNS = (1, -1, -1, -1, -1)
"""Whether an angle of ``kinematics`` grows with the ticks of its servo (1) or against them (-1). Sheet 15 and 16."""
GRIPPER_OPENING = 0.054
"""Opening (m) of an open gripper. Sheet 16."""
FASTEST_MS, SLOWEST_MS = 1, 127
"""Range of a servo's speed (ms per tick). Sheet 14."""
TICK_LINE_MS = 2
"""Time (ms) that the line to the servos needs for a tick of each joint that moves. Sheet 14."""


class JointSettings(NamedTuple):
    """What the user says of one joint. The gripper has only a speed."""

    max_speed: float
    """Highest speed (rad/s; m/s of the gripper)."""
    sign: int = 1
    """-1 if the joint of this arm turns the other way than `SIGNS` has it."""
    offset: float = 0.0
    """Angle (rad) of the joint when its servo is at its centre."""
    lower: float = -math.inf
    upper: float = math.inf
    """Limits (rad) besides those of the arm."""


class Joint(NamedTuple):
    """One joint of an arm that was found. Values are rad, of the gripper m."""

    name: str
    number: int
    """Number of its servo, from 1."""
    home: int
    minimum: int
    maximum: int
    """Positions (ticks)."""
    zero: float
    """Tick at which the value is 0."""
    unit: float
    """Change of the value with one tick; negative if the value falls."""
    lower: float
    upper: float
    """Limits of the value: those of the servo and of the user."""
    fastest_ms: int
    """Shortest time of a tick (ms) within the user's speed."""

    @property
    def is_gripper(self) -> bool:
        """Whether it is the gripper."""
        return self.name == GRIPPER

    @property
    def unit_name(self) -> str:
        """Unit of the value."""
        return "m" if self.is_gripper else "rad"

    def value(self, tick: int) -> float:
        """Return the value at a position (ticks)."""
        return (tick - self.zero) * self.unit + 0.0     # no -0.0

    def tick(self, value: float) -> int:
        """Return the position (ticks) nearest to a finite value. It is within the servo's range and the limits."""
        wanted = round(max(self.lower, min(self.upper, value)) / self.unit + self.zero)
        return max(self.minimum, min(self.maximum, wanted))

    def allows(self, value: float) -> bool:
        """Return whether a value is within the limits, give or take half a tick, to which all values are rounded."""
        return self.lower - abs(self.unit) / 2.0 <= value <= self.upper + abs(self.unit) / 2.0

    def speed(self, speed_ms: int) -> float:
        """Return the speed (rad/s, m/s) of a servo that takes ``speed_ms`` for a tick."""
        return 1000.0 * abs(self.unit) / max(FASTEST_MS, speed_ms)


class FoundJoints(NamedTuple):
    """The joints of an arm that can be used, and what is wrong with the others."""

    joints: Dict[str, Joint]
    """By name, in the order of the servos."""
    problems: List[str]


def find_joints(info: p2os.ArmInfo, settings: Tuple[JointSettings, ...]) -> FoundJoints:
    """Return the joints that an arm reports, as far as its numbers make sense.

    Args:
        info: what the arm reports. Joints after the sixth do not count.
        settings: what the user says of each of the six joints.
    """
    found = FoundJoints({}, [])
    for number, (name, reported, given) in enumerate(zip(JOINT_NAMES, info.joints, settings), 1):
        if reported.minimum >= reported.maximum:
            found.problems.append("%s is left alone: the arm reports the range %d to %d ticks of it"
                                  % (name, reported.minimum, reported.maximum))
        elif name != GRIPPER and not reported.ticks_per_90_deg:
            found.problems.append("%s is left alone: the arm reports 0 ticks for 90 degrees of it" % name)
        else:
            joint = _joint(name, number, reported, given)
            if joint.lower < joint.upper:
                found.joints[name] = joint
            else:
                found.problems.append("%s is left alone: its own range and that of the parameters have nothing in"
                                      " common" % name)
    return found


def _joint(name: str, number: int, reported: p2os.ArmJoint, given: JointSettings) -> Joint:
    if name == GRIPPER:
        zero, unit = float(reported.minimum), GRIPPER_OPENING / (reported.maximum - reported.minimum)
    else:
        unit = given.sign * SIGNS[number - 1] * math.pi / 2.0 / reported.ticks_per_90_deg
        zero = reported.centre - given.offset / unit
    ends = sorted(((reported.minimum - zero) * unit, (reported.maximum - zero) * unit))
    fastest = math.ceil(1000.0 * abs(unit) / given.max_speed - 1e-9)
    return Joint(name, number, reported.home, reported.minimum, reported.maximum, zero, unit,
                 max(ends[0], given.lower), min(ends[1], given.upper), max(FASTEST_MS, min(SLOWEST_MS, fastest)))

"""Odometry without rounding errors: 15-bit counts are summed as exact integers, and scaled once to a pose in metres.

The robot counts x and y in its own units. Its counters have 15 bits and wrap. The client sums the steps between two
packets as integers. A lost packet does no harm, as long as the robot moves less than half the range until the next
packet (16 m on a p3dx-sh, 8 m on a p3dx) and turns less than half a turn.

The odometry frame belongs to the client and starts at zero. The robot's own frame starts anew with every OPEN. So the
first packet after OPEN only ties the robot's frame to the last pose in the odometry frame. A robot that was left open
when the link was lost still counts in its previous frame. A reset is a new tie, too. The client never sends SETO: a SIP
that is under way at that time would look like a jump.

Source: protocol sheet 4.3.
"""

import math
from typing import Optional, Tuple

from ..p2os import COUNT_RANGE, wrapped

FASTEST = 5.0, 10.0         # m/s, rad/s: more than any robot does
SLACK = 0.5, 0.5            # m, rad: allowed in addition, because late packets arrive together


class Odometry:
    """Pose in the odometry frame, from the raw x, y and heading of successive SIPs.

    Args:
        mm_per_count: one count of x or y in mm.
        units_per_turn: units of the raw heading in a full turn.

    Attributes:
        x_counts, y_counts, heading_units: sums of all steps since the first packet, in the robot's own units and frame.
        travel: sum of all driving straight ahead since the first packet (m); driving backwards is negative.
    """

    def __init__(self, mm_per_count: float, units_per_turn: int) -> None:
        self.x_counts = 0
        self.y_counts = 0
        self.heading_units = 0
        self.travel = 0.0
        self._mm_per_count = mm_per_count
        self._units_per_turn = units_per_turn
        self._rad_per_unit = 2 * math.pi / units_per_turn
        self._raw = (0, 0, 0)
        self._doubted: Optional[Tuple[int, int, int]] = None
        self._tied = False
        self._tie(0.0, 0.0, 0.0)

    def update(self, x_raw: int, y_raw: int, heading_raw: int, seconds: float = math.inf) -> bool:
        """Take the raw position and heading of the next SIP. Returns whether they are possible.

        A bad line can change a packet so that its checksum is still right. Such a packet often shows a motion that is
        too fast for any robot. It is ignored. But when the next packet agrees with the ignored one, the robot's own
        frame has changed. Then the pose goes on from its last value.

        Args:
            x_raw, y_raw, heading_raw: as received, in the robot's units; signed or unsigned.
            seconds: time (s) since the previous SIP.
        """
        if self._tied:
            forward, left, turn = self._steps(self._raw, x_raw, y_raw, heading_raw)
            if not self._possible(forward, left, turn, seconds):
                doubted, self._doubted = self._doubted, (x_raw, y_raw, heading_raw)
                if doubted is None or not self._possible(*self._steps(doubted, x_raw, y_raw, heading_raw), seconds):
                    return False
                self.rebase()
                return self.update(x_raw, y_raw, heading_raw)
            self._doubted = None
            self.x_counts += forward
            self.y_counts += left
            self.heading_units += turn
            half_way = (self._raw[2] + turn / 2) * self._rad_per_unit
            self.travel += (forward * math.cos(half_way) + left * math.sin(half_way)) * self._mm_per_count / 1000
            self._raw = (x_raw, y_raw, heading_raw)
        else:
            pose = self.pose
            self._raw = (x_raw, y_raw, heading_raw)
            self._tie(*pose)
            self._tied, self._doubted = True, None
        return True

    def _steps(self, raw: Tuple[int, int, int], x_raw: int, y_raw: int, heading_raw: int) -> Tuple[int, int, int]:
        """Return the steps from ``raw`` to these numbers: along x, along y, turned (robot's units, robot's frame)."""
        return (
            wrapped(x_raw - raw[0], COUNT_RANGE),
            wrapped(y_raw - raw[1], COUNT_RANGE),
            wrapped(heading_raw - raw[2], self._units_per_turn))

    def _possible(self, forward: int, left: int, turn: int, seconds: float) -> bool:
        """Return whether a robot can make these steps in ``seconds``."""
        metres = (abs(forward) + abs(left)) * self._mm_per_count / 1000
        turned = abs(turn) * self._rad_per_unit
        return metres <= FASTEST[0] * seconds + SLACK[0] and turned <= FASTEST[1] * seconds + SLACK[1]

    @property
    def turned(self) -> float:
        """Sum of all turning since the first packet (rad, counter-clockwise positive)."""
        return self.heading_units * self._rad_per_unit

    def fits(self, mm_per_count: float, units_per_turn: int, correction: Tuple[float, float] = (1.0, 0.0)) -> bool:
        """Return whether this odometry uses these units, so that it can go on with another connection.

        ``correction``: that of a CorrectedOdometry. This odometry corrects nothing: (1, 0).
        """
        return (self._mm_per_count, self._units_per_turn) == (mm_per_count, units_per_turn) and correction == (1.0, 0.0)

    def rebase(self) -> None:
        """Take the next packet as the beginning of a new robot frame. The pose does not change."""
        self._tied = False

    def reset(self) -> None:
        """Set the present pose to zero: x 0, y 0, heading 0."""
        self._tie(0.0, 0.0, 0.0)

    @property
    def pose(self) -> Tuple[float, float, float]:
        """Pose in the odometry frame: x, y (m), heading (rad, counter-clockwise, -pi <= heading <= pi)."""
        x_counts, y_counts, units = self._tie_counts
        x_tie, y_tie, heading_tie = self._tie_pose
        forward = (self.x_counts - x_counts) * self._mm_per_count / 1000
        left = (self.y_counts - y_counts) * self._mm_per_count / 1000
        heading = heading_tie + wrapped(self.heading_units - units, self._units_per_turn) * self._rad_per_unit
        return (
            x_tie + self._cosine * forward - self._sine * left,
            y_tie + self._sine * forward + self._cosine * left,
            math.remainder(heading, 2 * math.pi),
        )

    def _tie(self, x: float, y: float, heading: float) -> None:
        """Declare that the counts of the last packet mean this pose (m, m, rad) in the odometry frame."""
        self._tie_counts = (self.x_counts, self.y_counts, self.heading_units)
        self._tie_pose = (x, y, heading)
        rotation = heading - wrapped(self._raw[2], self._units_per_turn) * self._rad_per_unit
        self._cosine, self._sine = math.cos(rotation), math.sin(rotation)

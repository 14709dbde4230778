"""Hears the scans of a laser (`scan`), and says whether they are of use: a robot goes on by sonar alone without them.

Scans come up to 75 times a second. A few of them are enough, and only these are read.
"""

from time import monotonic
from typing import Any, Callable, NamedTuple, Optional, Tuple

import rospy

from ...errors import UsageError
from ...floor_poses import Pose
from ..navigator import kind_of
from ..senses import OLD_SCAN, Senses
from ..values import is_blind
from .messages import mount_of, sweep_of

SILENT = 1.0
"""Time (s) without a scan after which people are told."""
AHEAD = 0.3
"""A scan that is newer than the newest packet by more (s) has another clock."""


class LaserState(NamedTuple):
    """What people are told of the laser, and whether something is wrong with it."""

    text: str
    trouble: bool


NO_LASER = LaserState("none", False)
"""No scan has come."""


class LaserWatch:
    """The scans of one robot.

    Args:
        senses: takes what the laser measured.
        place_of: returns the transform of a frame on the robot; raises UsageError if nobody says it.
    """

    def __init__(self, senses: Senses, place_of: Callable[[str], Any]):
        self._senses, self._place_of = senses, place_of
        self._frame, self._mount = "", (Pose(0.0, 0.0, 0.0), False)
        self._came_at: Optional[float] = None       # monotonic
        self._refusal = ""      # why the newest scan is of no use
        self._is_blind = False
        self._said = kind_of(NO_LASER.text)

    def hear(self, message: Any, offset: float) -> None:
        """Take a scan. `offset` (s) makes steady times of stamps. One that makes no sense is left out, and told."""
        self._came_at = monotonic()
        if self._senses.wants_sweep(message.header.stamp.to_sec() + offset):
            try:
                mount, upside_down = self._where(message.header.frame_id.lstrip("/"))
                sweep = sweep_of(message, mount, upside_down, offset)
                self._senses.hear_sweep(sweep)
                self._refusal, self._is_blind = "", is_blind(sweep.ranges)
            except UsageError as error:
                self._refusal = str(error)

    def _where(self, frame: str) -> Tuple[Pose, bool]:
        """Return pose and whether it is upside down, of a laser with a frame. In a crowd nobody hears tf: then it is
        where it was.
        """
        if not frame:
            raise UsageError("its header has no frame")
        try:
            self._mount, self._frame = mount_of(self._place_of(frame)), frame
        except UsageError:
            if frame != self._frame:
                raise
        return self._mount

    def state(self, by_laser: bool, makes_map: bool) -> LaserState:
        """Return what to tell. `by_laser`: the robot uses the laser now. `makes_map`: it makes a map, by sonar alone.
        """
        if self._came_at is None:
            return NO_LASER
        silent, age = monotonic() - self._came_at, self._senses.scan_age
        if silent > SILENT:
            return LaserState("no scan for %.1f s: it goes on by sonar alone" % silent, True)
        if self._refusal:
            return LaserState("not used: %s" % self._refusal, True)
        if makes_map:
            return LaserState("not used while a map is made", False)
        if age is not None and not -AHEAD <= age <= OLD_SCAN:
            return LaserState("not used: its scans are %.1f s %s than what the robot tells: do the clocks of two"
                              " computers differ?" % (abs(age), "older" if age > 0.0 else "newer"), True)
        if self._is_blind and not by_laser:
            return LaserState("not used: it sees next to nothing. Is it covered or dazzled, or is all too far away?",
                              True)
        return LaserState("used", False) if by_laser else LaserState("not used yet", False)

    def say(self, state: LaserState) -> None:
        """Log a state that is news."""
        kind = kind_of(state.text)
        if kind != self._said and state.text != "not used yet":
            self._said = kind
            (rospy.logwarn if state.trouble else rospy.loginfo)("laser: %s", state.text)

"""What the arm is told to do. Each order is an object that sends its packets step by step, and knows when it is done.

An order gets the status of the arm when it begins, with each status packet, and when it is due. A new order ends it,
and the joints are stopped in between. Times are monotonic (s). Waiting times are from the arm sheet, 14 and 18.
"""

import math
from typing import Mapping, Optional, Sequence, Tuple

from ..p2os import encode_command
from .joints import Joint
from .motion import Segment
from .status import ArmStatus

ALL_JOINTS = 255
"""Number that means all joints, in ARM_HOME and ARM_STOP. Sheet 20."""
STOP = encode_command("ARM_STOP", ALL_JOINTS)
CONFIRM_TIME = 2.0
"""Longest time (s) until a status shows that the power is on, or that the link is back."""
SHAKE_TIME = 2.0
"""Time (s) for which the arm may shake after power-on."""
INIT_TIME = 0.8
"""Time (s) for which the arm obeys nothing after ARM_INIT."""
HOME_TIME = 20.0
"""Longest time (s) that the way home takes: about 210 ticks at the slowest safe speed that we think of."""
LATE = 2.0
"""Time (s) after its computed end at which a segment of a motion has failed."""

Packets = Tuple[bytes, ...]


class ArmOrder:
    """Base of all orders.

    Attributes:
        due: time at which `look` must be called, whatever the arm says; infinity for never.
        problem: why it has failed; empty if it was carried out; None as long as it is under way.
    """

    name = "order"
    """What it is, for people."""
    condition = "at work"
    """Condition of an arm that carries it out."""

    def __init__(self) -> None:
        self.due = math.inf
        self.problem: Optional[str] = None

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Return the first packets. ``status`` is what the arm said last."""
        raise NotImplementedError

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Return the next packets, after a status or when it is due."""
        raise NotImplementedError

    @property
    def under_way(self) -> bool:
        """Whether it is neither done nor failed."""
        return self.problem is None

    def end(self, problem: str = "") -> Packets:
        """End the order: as done, or as failed for a reason. Return no packets."""
        self.problem, self.due = problem, math.inf
        return ()


class ServoPowerOn(ArmOrder):
    """Speeds and timers first, then power; then wait until the arm has shaken (sheet 18)."""

    name, condition = "power on", "powering on"

    def __init__(self, preparation: Packets) -> None:
        super().__init__()
        self._preparation = preparation
        self._seen = False

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Send the preparation, and ARM_POWER."""
        if status.powered:
            return self.end()
        self.due = now + CONFIRM_TIME
        return (*self._preparation, encode_command("ARM_POWER", 1))

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Wait for the power, then for its time. If it never shows, tell the arm to park: the power may still come."""
        if status.powered and not self._seen:
            self._seen, self.due = True, now + SHAKE_TIME
        elif self._seen and not status.powered:
            return self.end("the servo power went off again")
        elif now >= self.due and self._seen:
            return self.end()
        elif now >= self.due:
            self.end("the arm did not confirm within %.0f s that its servo power is on" % CONFIRM_TIME)
            return (encode_command("ARM_PARK"),)
        return ()


class Home(ArmOrder):
    """All joints go home at the arm's own safe speed, the gripper, too."""

    name, condition = "home", "homing"

    def __init__(self, joints: Mapping[str, Joint]) -> None:
        super().__init__()
        self._home = {joint.number: joint.home for joint in joints.values()}

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Send ARM_HOME."""
        self.due = now + HOME_TIME
        return (encode_command("ARM_HOME", ALL_JOINTS),)

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Wait until all joints are there."""
        if not status.powered:
            return self.end("the servo power is off")
        if all(status.ticks[number - 1] == home for number, home in self._home.items()) and not any(status.moving):
            return self.end()
        return self.end("the arm was not home after %.0f s" % HOME_TIME) if now >= self.due else ()


class Park(ArmOrder):
    """Stop, go home, power off: the only safe end.

    Args:
        comes_on: whether the power may come on yet, because it was ordered just now.
    """

    name, condition = "park", "parking"

    def __init__(self, comes_on: bool = False) -> None:
        super().__init__()
        self._comes_on = comes_on
        self._is_off_from = 0.0     # when a status without power counts

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Send ARM_STOP and ARM_PARK."""
        if not status.powered and not self._comes_on:
            return self.end()
        self._is_off_from, self.due = now + CONFIRM_TIME * self._comes_on, now + HOME_TIME
        return STOP, encode_command("ARM_PARK")

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Wait until the power is off."""
        if not status.powered and now >= self._is_off_from:
            return self.end()
        return self.end("the servo power was still on after %.0f s" % HOME_TIME) if now >= self.due else ()


class Init(ArmOrder):
    """A warm reset: the server looks for the arm's controller anew. Only without power, because it drops the arm."""

    name, condition = "init", "resetting"

    def __init__(self, preparation: Packets) -> None:
        super().__init__()
        self._preparation = preparation
        self._asleep_until = -math.inf

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Send ARM_INIT."""
        self._asleep_until, self.due = now + INIT_TIME, now + INIT_TIME + CONFIRM_TIME
        return (encode_command("ARM_INIT"),)

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Wait until the reset is over and the arm is linked. Then its speeds are as at power-on: set them again."""
        if now < self._asleep_until:
            return ()
        if status.linked:
            self.end()
            return self._preparation
        return self.end("the arm's controller does not answer: is the arm's switch on, and its cable in?"
                        ) if now >= self.due else ()


class JointMotion(ArmOrder):
    """A motion through several positions. A segment begins when all joints have arrived, and not before its time."""

    name, condition = "motion", "moving"

    def __init__(self, segments: Sequence[Segment], joints: Mapping[str, Joint]) -> None:
        super().__init__()
        self._left = list(segments)
        self._names = {joint.number: joint.name for joint in joints.values()}
        self._begun = self._segment_begun = 0.0

    def begin(self, status: ArmStatus, now: float) -> Packets:
        """Send the first segment."""
        self._begun = now
        return self._send(now)

    def look(self, status: ArmStatus, now: float) -> Packets:
        """Send the next segment when the present one is over."""
        if not status.powered:
            return self.end("the servo power is off")
        segment = self._left[0]
        missing = [number for number, goal in segment.goals.items() if status.ticks[number - 1] != goal]
        if missing and now >= self._segment_begun + segment.lasts + LATE:
            self.end("%s did not arrive in time" % ", ".join(self._names[number] for number in missing))
            return (STOP,)
        if missing:
            self.due = self._segment_begun + segment.lasts + LATE
        elif now >= self._begun + segment.ends or len(self._left) == 1:
            self._left.pop(0)
            return self._send(now) if self._left else self.end()
        else:
            self.due = self._begun + segment.ends
        return ()

    def _send(self, now: float) -> Packets:
        segment = self._left[0]
        self._segment_begun = now
        self.due = now + segment.lasts + LATE
        speeds = tuple(encode_command("ARM_SPEED", number, speed) for number, speed in segment.speeds.items())
        return (*speeds, *(encode_command("ARM_POS", number, goal) for number, goal in segment.goals.items()))

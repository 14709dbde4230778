"""The phases of a session with an arm, each an object with what exists only then: no link, asking, no arm, or an arm.

They write packets and notices into the session's `ArmOutput`. Times are monotonic (s).
"""

import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

from .. import p2os
from ..p2os import encode_command
from .joints import GRIPPER, JointSettings, find_joints
from .orders import STOP, ArmOrder, Packets, ServoPowerOn
from .status import ArmStatus, StatusReader
from .timers import ArmTimers

ASK = encode_command("ARM_STATUS", 2), encode_command("ARM_INFO")
"""Status, continuously, and information. Asked once: asking again might count as a command for the arm's timer."""
ASK_AGAIN, GIVE_UP = 1.0, 2.0
"""Time (s) after which the arm is asked once more what it is, and after which there is none. Sheet 18: 2 s."""
STALE = 1.0
"""Age (s) at which a status is too old: the arm sends ten a second."""
ORDER_PAUSE = 0.2
"""Shortest time (s) between two orders. Of orders that come faster, the newest waits, and others are dropped: one order
is up to 14 packets, and a stop must never wait behind many of them. A stop does not wait."""
STOP_PAUSE = 0.1
"""Time (s) after a stop in which another one, with nothing between, is not sent."""


class ArmSettings(NamedTuple):
    """What the user says of an arm."""

    joints: Tuple[JointSettings, ...]
    """Of each of the six joints."""
    layout: Optional[str] = None
    """Layout of its status, "A" or "M"; None to find it out."""
    autopark: int = 600
    """Time (s) without a command after which the arm parks. It is its only watchdog: not 0."""
    grippark: int = 300
    """Time (s) after which a closed gripper opens, and drops what it holds."""
    largest_step: float = 1.6
    """Farthest that a joint may move from one point of a motion to the next (rad)."""


class Notice(NamedTuple):
    """Something to tell the user, once."""

    text: str
    is_warning: bool = True


class ArmOutput:
    """What a session gives back: packets for the robot, and notices for the user."""

    def __init__(self) -> None:
        self.packets: List[bytes] = []
        self.notices: List[Notice] = []

    def say(self, text: str, is_warning: bool = True) -> None:
        """Tell the user something."""
        self.notices.append(Notice(text, is_warning))


class Away:
    """There is no link to the robot."""

    due = math.inf
    condition = "no link"
    text = "there is no link to the robot"


class Absent:
    """There is no arm, for the reason ``text``."""

    due = math.inf
    condition = "none"

    def __init__(self, text: str, output: ArmOutput) -> None:
        self.text = text
        output.packets.append(encode_command("ARM_STATUS", 0))
        output.say("there is no arm: %s" % text)


class Asking:
    """The robot is connected, and the arm is asked what it is.

    Attributes:
        reader: reads its status.
        info: what it is. None as long as it did not say.
        is_unclear: whether its status packets, which come, cannot be read for want of their layout.
        text: the condition for people.
    """

    condition = "looking"

    def __init__(self, layout: Optional[str], output: ArmOutput, now: float) -> None:
        self.reader = StatusReader(layout)
        self.info: Optional[p2os.ArmInfo] = None
        self.is_unclear = False
        self.text = "asking whether there is an arm"
        self._output = output
        self._asked_again = False
        self._heard = now
        self._unread: Optional[p2os.Arm] = None     # the last status packet, if it could mean two things
        self.due = now + ASK_AGAIN
        output.packets += ASK

    def read(self, packet: p2os.Arm, now: float) -> Optional[ArmStatus]:
        """Return what a status packet means. None if it could mean two things."""
        self._heard = now
        status = self.reader.read(packet)
        self._unread = packet if status is None else None
        return status

    def why_absent(self, now: float) -> Optional[str]:
        """Do what is due. Return why there is no arm; None while there may be one."""
        self.due = now + GIVE_UP - ASK_AGAIN
        if not self._asked_again:
            self._asked_again = True
            self._output.packets += ASK
        elif self.info is None:
            return "the robot did not say within %.0f s that it has an arm" % GIVE_UP
        elif now - self._heard >= STALE:
            return "the arm sent no status within %.0f s" % GIVE_UP
        elif self._unread is not None and not self.is_unclear:
            self.is_unclear = True
            self.text = ("the arm's status packets (%02X %02X) do not tell their layout: it moves, or the parameter"
                         " arm_layout must say it (A or M)" % (self._unread.status_bits, self._unread.motion_bits))
            self._output.say(self.text)
        return None


class Fitted:
    """There is an arm.

    Attributes:
        version: of the arm's server.
        joints: the joints that can be used, by name.
        problems: why other joints cannot be used.
        reader: reads its status.
        status: what the arm said last, at time ``heard`` (s).
        order: the newest order that has begun. None if there was none.
        silent: whether the arm has stopped to send its status.
        timers: what moves it by itself.
    """

    def __init__(self, info: p2os.ArmInfo, settings: ArmSettings, reader: StatusReader, status: ArmStatus,
                 output: ArmOutput, now: float) -> None:
        self.version = info.version
        self.joints, self.problems = find_joints(info, settings.joints)
        self.reader = reader
        self.status, self.heard, self.silent = status, now, False
        self.timers = ArmTimers(settings.autopark, settings.grippark, self.joints.get(GRIPPER), now)
        self.timers.saw(status, now)
        self.order: Optional[ArmOrder] = None
        self._settings = settings
        self._output = output
        self._waiting: Optional[ArmOrder] = None    # begins at _free_at
        self._free_at = now
        self._sent: Packets = ()                    # last, at _sent_at
        self._sent_at = now
        self._ask_at = math.inf                     # while it is silent: when to ask it again

    @property
    def due(self) -> float:
        """When `tick` must be called."""
        return min(self.order.due if self.order is not None else math.inf,
                   self._free_at if self._waiting is not None else math.inf,
                   self.timers.due, self._ask_at if self.silent else self.heard + STALE)

    @property
    def present_order(self) -> Optional[ArmOrder]:
        """The order that waits or is under way. None without one."""
        return self._waiting or (self.order if self.order is not None and self.order.under_way else None)

    @property
    def comes_on(self) -> bool:
        """Whether power was ordered, and the arm has not shown it yet."""
        return isinstance(self.order, ServoPowerOn) and self.order.under_way and not self.status.powered

    @property
    def condition(self) -> str:
        """One word or two for programs; docs/arm.md has the list."""
        if self.silent:
            return "silent"
        order = self.present_order
        if order is not None:
            return order.condition
        if not self.status.linked:
            return "not connected"
        if not self.status.powered:
            return "off"
        return "homing" if self.status.homing else "moving" if any(self.status.moving) else "on"

    @property
    def text(self) -> str:
        """The condition for people."""
        return {
            "silent": "it has stopped sending its status",
            "not connected": "its controller does not answer: is its switch on, and its cable in? Then: arm/init",
            "off": "found, without servo power",
            "powering on": "servo power comes on: it jumps to its home position and may shake",
            "resetting": "a warm reset: its controller is looked for",
            "on": "servo power is on",
        }.get(self.condition, "servo power is on, and it is %s" % self.condition)

    @property
    def preparation(self) -> Packets:
        """The packets that set the timers, and a slow speed of each joint."""
        return (encode_command("ARM_AUTOPARK", self._settings.autopark),
                encode_command("ARM_GRIPPARK", self._settings.grippark),
                *(encode_command("ARM_SPEED", joint.number, joint.fastest_ms) for joint in self.joints.values()))

    def saw(self, status: ArmStatus, now: float) -> None:
        """Take a status."""
        before, self.status, self.heard = self.status, status, now
        if self.silent:
            self.silent = False
            self._output.say("the arm sends its status again", False)
        self.timers.saw(status, now)
        if self.present_order is None and before.linked and not status.linked:
            self._output.say("the arm's controller does not answer any more: is its switch off?")
        elif self.present_order is None and before.powered and not status.powered:
            self._output.say("the servo power of the arm went off by itself: it has parked, or was switched off")
        self._look(now)

    def tick(self, now: float) -> None:
        """Do what time makes due."""
        if not self.silent and now >= self.heard + STALE:
            self._fall_silent(now)
        elif self.silent and now >= self._ask_at:
            self._ask(now)
        if self._waiting is not None and now >= self._free_at:
            self._begin_waiting(now)
        elif self.order is not None and now >= self.order.due:
            self._look(now)
        for warning in self.timers.warnings(now):
            self._output.say(warning)

    def begin(self, order: ArmOrder, now: float) -> ArmOrder:
        """Begin an order, or let it wait for its turn. Others that wait or are under way end."""
        if self._waiting is not None:
            self._waiting.end("%s took its place" % order.name)
        self._waiting = order
        if now >= self._free_at:
            self._begin_waiting(now)
        return order

    def stop(self, reason: str, now: float) -> None:
        """Stop all joints. Orders that wait or are under way end for this reason."""
        self.end_orders(reason)
        self.send((STOP,), now)

    def end_orders(self, reason: str) -> None:
        """End what waits and what is under way, for this reason. The joints do not stop by that."""
        for order in (self._waiting, self.order):
            if order is not None and order.under_way:
                order.end(reason)
        self._waiting = None

    def send(self, packets: Sequence[bytes], now: float) -> None:
        """Send commands to the arm. A stop just after a stop is left out."""
        repeated = tuple(packets) == self._sent == (STOP,) and now < self._sent_at + STOP_PAUSE
        if packets and not repeated:
            self.timers.commanded(now)
            self._sent, self._sent_at = tuple(packets), now
            self._output.packets += packets

    def _begin_waiting(self, now: float) -> None:
        order, self._waiting = self._waiting, None
        assert order is not None
        if self.order is not None and self.order.under_way:
            self.order.end("%s took its place" % order.name)
            self.send((STOP,), now)
        self.order, self._free_at = order, now + ORDER_PAUSE
        self.send(order.begin(self.status, now), now)

    def _look(self, now: float) -> None:
        order = self.order
        if order is not None and order.under_way:
            self.send(order.look(self.status, now), now)
            if order.problem:
                self._output.say("arm: %s failed: %s" % (order.name, order.problem))

    def _fall_silent(self, now: float) -> None:
        self.silent = True
        self._output.say("the arm has stopped sending its status; it is told to stop")
        self.stop("the arm has stopped sending its status", now)
        self._ask(now)

    def _ask(self, now: float) -> None:
        self._ask_at = now + GIVE_UP
        self._output.packets.append(ASK[0])

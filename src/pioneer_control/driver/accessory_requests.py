"""Obeys requests for the robot's accessories: sounds, outputs, a joystick at its own port, docks.

Threads of rospy call these methods. The tables in `requests` have their topics and services.
"""

import rospy

from ..client import Accessories, Robot, SteeredRobot
from ..errors import NotConfirmedError, PioneerError, RefusedError, UsageError
from ..msg import Sounds
from .parameters import BY_HAND

DOCKED = "dock"
"""The lock that is set while the robot takes power in a dock: nobody is to drive away with it."""
OUTPUT_TIMEOUT = 2.0
"""The time (s) that the robot has to show its outputs."""
POWER_TIMEOUT = 5.0
"""The time (s) that the robot has to show that it takes power in a dock, or that it let go."""


class AccessoryRequests:
    """Obeys what is asked of the accessories of one robot. Each method raises PioneerError when it does not.

    Methods of services return the text of the answer.
    """

    def __init__(self, robot: Robot, steered: SteeredRobot) -> None:
        self._steered = steered
        self._accessories = Accessories(robot)

    def say(self, message: Sounds) -> None:
        """Obey the topic say: play the notes."""
        durations, tones = list(message.durations), list(message.tones)
        if len(durations) != len(tones):
            raise UsageError("say refused: there are %d durations and %d tones" % (len(durations), len(tones)))
        try:
            self._accessories.say(list(zip(durations, tones)))
        except UsageError as error:
            raise UsageError("say refused: %s" % error) from None

    def set_outputs(self, mask: int, states: int) -> str:
        """Set digital outputs, and wait until the robot shows them."""
        self._accessories.set_outputs(mask, states, OUTPUT_TIMEOUT)
        return "the outputs 0x%02x are 0x%02x" % (mask, states)

    def let_joystick_drive(self, on: bool) -> str:
        """Let a joystick at the robot's own port drive it, as a person who has the helm, or end that."""
        if not on:
            self._accessories.allow_joystick(False)
            return "no joystick drives the robot"
        self._steered.take(BY_HAND, "the joystick of the robot", lambda: self._accessories.allow_joystick(True))
        return "a joystick at the robot's port may drive it; the robot does not say whether it does"

    def dock(self) -> str:
        """Take power in the dock, and lock the robot while it does."""
        self._accessories.check_dock()
        before = self._steered.state().locks
        for lock in before:
            if lock != DOCKED:
                raise RefusedError("dock refused: %s is set" % lock)
        self._steered.lock(DOCKED)
        try:
            self._accessories.dock(POWER_TIMEOUT)
        except PioneerError as error:
            if DOCKED not in before or isinstance(error, NotConfirmedError):    # else it is still in the dock
                self._steered.unlock(DOCKED)
            raise
        return "the robot takes power, and stands until undock"

    def warning_at_start(self) -> str:
        """Return a warning if the robot is perhaps in a dock, as an earlier driver left it; else an empty text."""
        if DOCKED in self._steered.state().locks or not self._accessories.may_be_docked:
            return ""
        return ("the robot has power from a charger: if it stands in a dock, let it go before it drives: rosservice"
                " call %s" % rospy.resolve_name("undock"))

    def undock(self) -> str:
        """Let go of the dock, and unlock the robot when it has let go."""
        self._accessories.undock(POWER_TIMEOUT)
        self._steered.unlock(DOCKED)
        return "the robot has let go of the dock, and may move"

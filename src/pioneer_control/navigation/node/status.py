"""Publishes on /diagnostics how navigation is (REP 107): once a second, and when the level changes."""

from typing import Optional, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..navigator import State
from ..pilot import PilotStep
from .laser_watch import NO_LASER, LaserState

PERIOD = 1.0
"""Time (s) between two messages, as long as the level stays."""
LATE = 0.1
"""The robot reacts so much (s) later than usual when people are told of it."""


class StatusReport:
    """Publishes the diagnostics of one navigation node."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)
        self._name = "%s: Navigation" % rospy.get_name().lstrip("/")
        self._told: Tuple[Optional[int], float] = None, 0.0

    def publish(self, step: PilotStep, tf_trouble: str, laser: LaserState, now: float) -> None:
        """Publish what a step, `tf_trouble` and the laser say, if it is time. `now` is monotonic (s)."""
        level, text = judged(step, tf_trouble, laser)
        before, told_at = self._told
        if level == before and now - told_at < PERIOD:
            return
        self._told = level, now
        values = [KeyValue("state", step.state.value), KeyValue("reason", step.reason),
                  KeyValue("laser", laser.text)]
        if step.where is not None:
            pose = step.where.pose
            values += [KeyValue("x (m)", "%.3f" % pose.x), KeyValue("y (m)", "%.3f" % pose.y),
                       KeyValue("heading (rad)", "%.3f" % pose.heading)]
        self._publisher.publish(DiagnosticArray(
            Header(stamp=rospy.Time.now()), [DiagnosticStatus(level, self._name, text, "", values)]))


def late_text(late: float) -> str:
    """Return for people that the robot reacts later (s) than usual."""
    return ("packets were answered up to %.1f s later than usual: this computer or the line is too slow, or the sonar"
            " was silent; the robot drives slower near anything" % late)


def judged(step: PilotStep, tf_trouble: str = "", laser: LaserState = NO_LASER) -> Tuple[int, str]:
    """Return the level of a step and its text: a warning while the robot is lost, waits, or has given up, while
    somebody else tells tf where it is, while it reacts late, and while its laser is of no use.
    """
    if step.where is not None and not step.where.sure:
        return DiagnosticStatus.WARN, step.where.reason
    if step.state in (State.WAITING, State.FAILED):
        return DiagnosticStatus.WARN, "%s: %s" % (step.state.value, step.reason)
    if tf_trouble:
        return DiagnosticStatus.WARN, tf_trouble
    if step.late > LATE:
        return DiagnosticStatus.WARN, late_text(step.late)
    if laser.trouble:
        return DiagnosticStatus.WARN, "laser: %s" % laser.text
    return DiagnosticStatus.OK, "%s: %s" % (step.state.value, step.reason)

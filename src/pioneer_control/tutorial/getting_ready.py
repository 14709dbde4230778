"""Waits until the driver of a robot is there, and all that a program needs has been heard; says what is missing."""

from typing import List

import rospy

from ..errors import NoAnswerError
from .commander import Commander
from .reports import Reports, Stopwatch


def wait_until_ready(prefix: str, reports: Reports, commander: Commander, timeout: float) -> None:
    """Wait until the driver subscribes to the command topics, and each topic of the robot has sent a message.

    Args:
        prefix: what the names of the robot's topics begin with.
        reports: what is heard of the robot.
        commander: publishes commands to it.
        timeout: the longest time to wait [s].

    Raises:
        NoAnswerError: a subscriber or a message did not come. The error message names the topics, and what to do.
    """
    def missing() -> List[str]:
        return missing_topics(prefix, reports, commander)

    passed = Stopwatch()
    if not rospy.get_time():
        rospy.loginfo("waiting for the time on /clock: use_sim_time is set")
    if not reports.wait(lambda: not missing(), timeout) and passed() < timeout:
        rospy.logwarn("ROS time stands or is slow (use_sim_time is set): waiting on for %s", ", ".join(missing()))
    if not reports.wait(lambda: not missing(), timeout - passed(), passed):
        raise NoAnswerError("after %.0f s still no %s. %s" % (
            timeout, ", ".join(missing()), advice(prefix, reports, commander)))


def missing_topics(prefix: str, reports: Reports, commander: Commander) -> List[str]:
    """Return the names of the topics that have no subscriber or no message yet, for people."""
    heard = reports.heard
    return commander.unheard() + [name for name, there in (
        ("/clock", rospy.rostime.is_wallclock() or rospy.get_time()),
        (prefix + "robot_info", heard.robot),
        (prefix + "pose", heard.pose),
        (prefix + "motor_state", heard.motors is not None),
        (prefix + "sonar (is use_sonar on?)", heard.ranges),
        (prefix + "gripper_state", heard.grip or not heard.has_gripper),
    ) if not there]


def advice(prefix: str, reports: Reports, commander: Commander) -> str:
    """Return what the user can do about the missing topics, in one or two sentences."""
    if missing_topics(prefix, reports, commander) == [prefix + "robot_info"]:
        return (
            "A driver runs, but not this package's: it tells neither the robot's outline nor where its sonars "
            "look. Name the model, and both come from a table: _model:=p3dx-sh, or Pioneer(model=...) in a program "
            "of your own. python3 -m pioneer_control.robots lists the models")
    if not commander.unheard() and not reports.heard.pose:
        return "A driver listens, but has told nothing of its robot. Has it a link? Its log says why not"
    return (
        "Does the driver run (roslaunch pioneer_control pioneer.launch sim:=true, or with the port of your robot), "
        "and in this namespace?")

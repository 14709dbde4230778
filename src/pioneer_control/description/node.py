"""The ROS node ``description``: it describes the robot that is there, and becomes its robot_state_publisher.

*Subscribes*
``robot_info`` (RobotInfo): which robot it is, and what is fitted to it; not if the parameter ``model`` says it.

*Sets* the parameter ``robot_description`` in its namespace: the URDF.

*Parameters*: see `DescriptionParameters`. docs/models.md describes them.

The model of a real robot is known only when it has connected. robot_state_publisher wants its URDF when it starts, so
this program starts it then, in its own place.
"""

import contextlib
import os
import sys
import threading
from dataclasses import dataclass, replace
from typing import List, Optional, Tuple

import rosgraph
import roslib.packages
import rospy

from ..errors import ParameterError, PioneerError
from ..msg import RobotInfo
from ..parameters import AutoSwitch, Switch, Text, check, parameter
from ..robots import RobotModel, find_model
from ..ros_node import NO_ANSWER, init_node, is_at_work
from .parts import Parts
from .urdf import describe

PUBLISHER = "robot_state_publisher"
REMIND = 10.0
"""The time (s) without a robot after which the user is told what this node waits for."""
POLL = 0.2      # s
PATIENCE = 3.0
"""The time (s) that another robot_state_publisher has to answer."""


@dataclass(frozen=True)
class DescriptionParameters:
    """The checked private parameters of the node."""

    model: str = parameter("", Text(empty=True), "the robot's model; empty: what robot_info says")
    models_file: str = parameter("", Text(empty=True), "file with your own calibration of models; empty: none")
    gripper: Optional[bool] = parameter(None, AutoSwitch(), "does it carry a gripper? auto: what robot_info says, or"
                                        " with a model given, whether that can carry one")
    laser: bool = parameter(False, Switch(), "it carries a laser, where its model has it")
    ptz: bool = parameter(False, Switch(), "it carries a Canon VC-C4 camera")
    arm: bool = parameter(False, Switch(), "it carries a Pioneer Arm")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "put before the name of every link")


def fitted(parameters: DescriptionParameters, info: Optional[RobotInfo]) -> Tuple[RobotModel, Parts]:
    """Return the model to describe, with the transducers that are fitted, and the parts that it carries.

    Args:
        parameters: what the user said.
        info: what the robot said. None if the user gave the model.

    Raises:
        UsageError: there is no such model.
    """
    subtype = parameters.model if info is None else info.subtype
    model = find_model(subtype, parameters.models_file or None)
    has_gripper = model.can_carry_gripper if info is None else info.has_gripper
    if info is not None:
        model = replace(model, sonar=tuple(each for each in model.sonar if each.number in info.sonar_numbers))
    gripper = has_gripper if parameters.gripper is None else parameters.gripper
    return model, Parts(gripper, parameters.laser, parameters.ptz, parameters.arm)


def main() -> int:
    """Describe the robot, then become its robot_state_publisher. Return 0 after a shutdown, or if the robot has one
    already; 2 after a wrong parameter.
    """
    name = rosgraph.names.make_caller_id(PUBLISHER).rstrip("/")
    with contextlib.suppress(*NO_ANSWER):       # no master: init_node waits for it
        if is_at_work(name, PATIENCE):      # a second one would end it, and both can end each other
            print("%s runs already, and goes on: the robot is described as it was started" % name)
            return 0
    init_node(PUBLISHER)
    try:
        parameters, unknown = check(DescriptionParameters, rospy.get_param("~", {}))
        for name in unknown:
            rospy.logwarn("~%s has no effect: it is not a parameter of this node", name)
        info = None if parameters.model else _wait_for_robot()
        if rospy.is_shutdown():
            return 0
        model, parts = fitted(parameters, info)
        rospy.set_param("robot_description", describe(model, parts, parameters.frame_prefix))
    except PioneerError as error:
        advice = " (The master keeps old parameters until you type: rosparam delete %s)" % rospy.get_name()
        rospy.logfatal("%s%s", error, advice if isinstance(error, ParameterError) else "")
        return 2
    return _become(model.subtype)


def _wait_for_robot() -> Optional[RobotInfo]:
    """Wait for robot_info and return it. None when ROS shuts down meanwhile."""
    heard: List[RobotInfo] = []
    told = threading.Event()

    def hear(info: RobotInfo) -> None:
        heard.append(info)
        told.set()

    subscriber = rospy.Subscriber("robot_info", RobotInfo, hear)
    waited = 0.0
    while not told.wait(POLL) and not rospy.is_shutdown():
        waited += POLL
        if waited > REMIND:
            waited = -float("inf")      # once
            rospy.logwarn("nobody has said on %s what robot it is; if nobody will, give the model: model:=p3dx-sh",
                          subscriber.resolved_name)
    subscriber.unregister()
    return heard[0] if heard else None


def _become(subtype: str) -> int:
    """Replace this program by robot_state_publisher, with the same name and remappings."""
    programs = roslib.packages.find_node(PUBLISHER, PUBLISHER)
    if not programs:
        rospy.logfatal("robot_state_publisher is not installed: sudo apt-get install ros-robot-state-publisher (Debian)"
                       " or ros-noetic-robot-state-publisher (Ubuntu)")
        return 2
    rospy.loginfo("robot_description is that of a %s", subtype)
    rospy.signal_shutdown("robot_state_publisher takes over this name")
    os.execv(programs[0], [PUBLISHER] + sys.argv[1:])
    raise AssertionError("execv returns only with an error, which it raises")

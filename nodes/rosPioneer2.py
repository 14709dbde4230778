#!/usr/bin/python3
"""The tutorial's advanced node: wander, pick, wander, pick. It logs what it does and why.

    rosrun pioneer_control rosPioneer2.py [NAMESPACE] [_duration:=20] [_speed:=0.1] [_seed:=1] [_stop_at_can:=true]

NAMESPACE is the namespace of the robot (default: pioneer). The class Parameters lists all parameters (_NAME:=VALUE).
"""

import sys
from dataclasses import dataclass
from typing import Optional, Tuple

import pioneer_control.interrupt  # noqa: F401  # from here on Ctrl-C is no error
import rospy

from pioneer_control.errors import ParameterError, PioneerError
from pioneer_control.parameters import Number, Numbers, Switch, Text, Whole, check, parameter
from pioneer_control.ros_node import init_node, name_for, sleep
from pioneer_control.tutorial.pioneer import Pioneer

STAMPS = Numbers(None, 0.0, 2.0 ** 32)


@dataclass(frozen=True)
class Parameters:
    duration: float = parameter(20.0, Number(0.1, 86400.0), "time of each wander", "s")
    speed: float = parameter(0.1, Number(0.01, 0.5), "speed of the wander", "m/s")
    seed: Optional[int] = parameter(None, Whole(), "of what chance decides; None: the clock's")
    stop_at_can: bool = parameter(True, Switch(), "whether what stands between the paddles ends a wander")
    model: str = parameter("", Text(empty=True), "of the robot, where the driver does not tell it on robot_info")
    gripper: bool = parameter(False, Switch(), "with model: is a gripper fitted?")
    begin_at: Tuple[float, ...] = parameter((), STAMPS, "for a re-run: stamp of the first decision of each wander", "s")
    end_at: Tuple[float, ...] = parameter((), STAMPS, "for a re-run: stamp of the last one; no can ends a wander", "s")


def run(robot, given):
    """Wander and pick, twice. If the gripper already holds a can, first take it to another place and put it down."""
    picked = 0
    for _ in range(2):
        if robot.holding:
            robot.wander(given.duration / 4)
            robot.put_down()
        robot.wander(given.duration, stop_at_can=given.stop_at_can)
        robot.stop()
        sleep(2)
        held = robot.holding
        picked += robot.pick() and not held
        sleep(2)
    way = "its wheels stalled %d times" % robot.stalls if robot.stalls else "nothing held it on its way"
    rospy.loginfo("the end: %.1f m driven, %d of 2 picks got something, %s", robot.driven, picked, way)


def main():
    namespace = (rospy.myargv()[1:] or ["pioneer"])[0]
    init_node(name_for("rosPioneer2", namespace))
    try:
        given, _ = check(Parameters, rospy.get_param("~", {}))
        with Pioneer(
                namespace, speed=given.speed, seed=given.seed, model=given.model, gripper=given.gripper,
                begin_at=given.begin_at, end_at=given.end_at) as robot:
            run(robot, given)
    except ParameterError as error:
        rospy.logerr("%s (What an earlier start was given stays until: rosparam delete %s)", error, rospy.get_name())
        return 1
    except PioneerError as error:
        rospy.logerr("%s", error)
        return 1
    except rospy.ROSInterruptException:
        pass  # Ctrl-C or rosnode kill: the robot has stopped already
    return 0


if __name__ == "__main__":
    sys.exit(main())

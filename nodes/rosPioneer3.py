#!/usr/bin/python3
"""The tutorial's last node: carry cans to a named place of the map, and come home.

    rosrun pioneer_control rosPioneer3.py [NAMESPACE] [_place:=depot] [_home:=home] [_cans:=1] [_seed:=1]

Navigation must run: roslaunch pioneer_control navigate.launch sim:=true. NAMESPACE is the namespace of the robot
(default: pioneer). The class Parameters lists all parameters (_NAME:=VALUE).
"""

import sys
from dataclasses import dataclass
from typing import Optional

import pioneer_control.interrupt  # noqa: F401  # from here on Ctrl-C is no error
import rospy

from pioneer_control.errors import ParameterError, PioneerError
from pioneer_control.parameters import Number, Text, Whole, check, parameter
from pioneer_control.ros_node import init_node, name_for
from pioneer_control.tutorial.pioneer import Pioneer


@dataclass(frozen=True)
class Parameters:
    place: str = parameter("depot", Text(), "where the cans go: a named place of the map")
    home: str = parameter("home", Text(), "where the robot goes at the end: a named place of the map")
    cans: int = parameter(1, Whole(0, 100), "how many cans it carries there")
    duration: float = parameter(120.0, Number(0.1, 86400.0), "longest time to look for one can", "s")
    speed: float = parameter(0.1, Number(0.01, 0.5), "speed while it looks for cans", "m/s")
    seed: Optional[int] = parameter(None, Whole(), "of what chance decides; None: the clock's")


def deliver(robot, given):
    """Look for a can, pick it up and bring it to the place. Return whether a can was brought."""
    robot.wander(given.duration)
    if not robot.pick() or not robot.go_to(given.place):
        return False
    return robot.put_down()


def run(robot, given):
    """Bring the cans, and go home."""
    brought = sum(deliver(robot, given) for _ in range(given.cans))
    at_home = robot.go_to(given.home)
    rospy.loginfo("the end: %d of %d cans brought to %s, %s", brought, given.cans, given.place,
                  "home again" if at_home else "not at home")


def main():
    namespace = (rospy.myargv()[1:] or ["pioneer"])[0]
    init_node(name_for("rosPioneer3", namespace))
    try:
        given, _ = check(Parameters, rospy.get_param("~", {}))
        with Pioneer(namespace, speed=given.speed, seed=given.seed) as robot:
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

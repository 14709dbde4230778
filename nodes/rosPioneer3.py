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
from pioneer_control.floor_poses import compose, relative
from pioneer_control.parameters import Number, Text, Whole, check, parameter
from pioneer_control.ros_node import init_node, name_for
from pioneer_control.tutorial.pioneer import Pioneer


@dataclass(frozen=True)
class Parameters:
    place: str = parameter("depot", Text(), "where the cans go: a named place of the map")
    home: str = parameter("home", Text(), "where the robot goes at the end: a place; without a home, where it began")
    cans: int = parameter(1, Whole(0, 100), "how many cans it carries there")
    duration: float = parameter(120.0, Number(0.1, 86400.0), "longest time to look for one can", "s")
    speed: float = parameter(0.1, Number(0.01, 0.5), "speed while it looks for cans", "m/s")
    seed: Optional[int] = parameter(None, Whole(), "of what chance decides; None: the clock's")


def home_of(robot, name, began):
    """Return where to come back to, as `go_to` takes it: the place or, on a map without a home, where the robot was
    when its odometry began so. None while it does not know where it is.
    """
    if name in robot.navigation.places():
        return (name,)
    here = robot.where()
    return here and compose(here, relative(robot.pose, began))


def run(robot, given):
    """Bring the cans, and go home. Raises UsageError before the robot moves if no place has a name."""
    for name in [given.place] + [given.home] * (given.home != "home"):
        robot.navigation.goal_of(name, None, None)
    began, home, brought = robot.pose, None, 0
    for _ in range(given.cans):
        robot.wander(given.duration)
        held = robot.pick()
        home = home or home_of(robot, given.home, began)
        brought += bool(held and robot.go_to(given.place) and robot.put_down())
    home = home or home_of(robot, given.home, began)
    at_home = home is not None and robot.go_to(*home)
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

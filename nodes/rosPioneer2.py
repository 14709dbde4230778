#!/usr/bin/python3
"""The tutorial's advanced node: wander, pick, wander, pick. It tells what it does and why.

    rosrun pioneer_control rosPioneer2.py [NAMESPACE] [_duration:=20] [_speed:=0.1] [_seed:=1] [_stop_at_can:=true]

NAMESPACE is the robot's, pioneer if not given; duration [s] of each wander; speed [m/s]; the same seed makes the same choices; with
stop_at_can a wander ends early when something stands between the paddles. To decide again on what a bag holds, it is told as begin_at
and end_at the stamps [s] of the first and the last message on decision of each wander, as lists.
"""

import sys
from dataclasses import dataclass
from typing import Optional, Tuple

import pioneer_control.interrupt  # noqa: F401: Ctrl-C is no error from here on
import rospy

from pioneer_control.errors import ParameterError, PioneerError
from pioneer_control.parameters import Number, Numbers, Switch, Whole, check, parameter
from pioneer_control.ros_node import init_node, sleep
from pioneer_control.tutorial.pioneer import Pioneer

STAMPS = Numbers(None, 0.0, 2.0 ** 32)


@dataclass(frozen=True)
class Parameters:
    duration: float = parameter(20.0, Number(0.1, 86400.0), "time of each wander", "s")
    speed: float = parameter(0.1, Number(0.01, 0.5), "speed of the wander", "m/s")
    seed: Optional[int] = parameter(None, Whole(), "of what chance decides; None: the clock's")
    stop_at_can: bool = parameter(True, Switch(), "whether what stands between the paddles ends a wander")
    begin_at: Tuple[float, ...] = parameter((), STAMPS, "for a re-run: a wander decides on nothing before its stamp", "s")
    end_at: Tuple[float, ...] = parameter((), STAMPS, "for a re-run: a wander decides on nothing after its stamp, and no can ends it", "s")


def run(namespace):
    given, _ = check(Parameters, rospy.get_param("~", {}))
    with Pioneer(namespace, speed=given.speed, seed=given.seed, begin_at=given.begin_at, end_at=given.end_at) as robot:
        for _ in range(2):
            robot.wander(given.duration, stop_at_can=given.stop_at_can)
            robot.stop()
            sleep(2)
            robot.pick()
            sleep(2)


def main():
    init_node("rosPioneer2")
    arguments = rospy.myargv()[1:]
    try:
        run(arguments[0] if arguments else "pioneer")
    except ParameterError as error:
        rospy.logerr("%s (What an earlier start was given stays until: rosparam delete %s)", error, rospy.get_name())
        return 1
    except PioneerError as error:
        rospy.logerr("%s", error)
        return 1
    except rospy.ROSInterruptException:
        pass  # Ctrl-C or rosnode kill: the robot stands already
    return 0


if __name__ == "__main__":
    sys.exit(main())

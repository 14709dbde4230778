"""Robots and snapshots for the tests of the tutorial's decisions: real shapes, and the ranges that a test sets."""

import math

from pioneer_control.floor_poses import Pose
from pioneer_control.robots import find_model
from pioneer_control.tutorial.snapshot import RobotShape, Snapshot

NO_ECHO = 5.0


def shape(name="p3dx-sh", gripper=False, rear_sonar=True):
    """Return the shape of a model, as RobotInfo describes it."""
    model = find_model(name)
    return RobotShape(model.with_arrays(front=True, rear=rear_sonar).sonar, model.outline(gripper))


def snapshot(ranges=None, robot=None, *, everything_else=NO_ECHO, time=100.0, age=0.0, pose=(0.0, 0.0, 0.0), **more):
    """Return a snapshot with the ranges {number: m} of some sonars. All others have the range `everything_else`."""
    robot = robot or shape()
    heard = [everything_else] * robot.sonar_count
    for number, distance in (ranges or {}).items():
        heard[number] = distance
    return Snapshot(time, age, Pose(*pose), tuple(heard), robot, **more)


def beside(robot, number):
    """Return the range of a sonar to something that just touches the robot's turning circle, on the sonar's axis [m].
    """
    each = next(each for each in robot.transducers if each.number == number)
    along = each.x * math.cos(each.heading) + each.y * math.sin(each.heading)
    across_squared = each.x ** 2 + each.y ** 2 - along ** 2
    return math.sqrt(robot.outline.reach ** 2 - across_squared) - along

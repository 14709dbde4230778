"""Bring three cans to the dock, one after the other.

    python3 cans.py socket://localhost:8101
"""

import math
import sys

from pioneer_control.client import Robot
from pioneer_control.p2os import GripperCommand

# Where each can stands, and on which line it is brought into the dock (m from the start: x ahead, y to the left).
TRIPS = [((1.4, 0.0), 0.0),
         ((1.2, 0.9), 0.4),
         ((1.2, -0.9), -0.4)]
REACH = 0.7                     # m: begin to look for a can so far before it


def drive_to(robot, x, y):
    """Turn towards the point (x, y), drive there, and stop."""
    distance = 1
    while distance > 0.03:
        state = robot.wait_for_state()
        distance = math.hypot(x - state.x, y - state.y)
        direction = math.atan2(y - state.y, x - state.x)
        error = math.remainder(direction - state.heading, 2 * math.pi)
        if abs(error) > 0.3:                            # the point is not ahead: turn on the spot
            speed = 0
        else:                                           # drive, and slow down in the last half metre
            speed = min(0.4, 0.05 + distance)
        robot.set_velocity(speed, max(-1, min(1, 2 * error)))
    robot.stop()


def turn_to(robot, heading):
    """Turn on the spot until the robot looks along this heading (rad)."""
    error = 1
    while abs(error) > 0.02:
        error = math.remainder(heading - robot.wait_for_state().heading, 2 * math.pi)
        robot.set_velocity(0, max(-1, min(1, 2 * error)))
    robot.stop()


def back_to(robot, x):
    """Drive backwards, straight on, until x is less than this."""
    while robot.wait_for_state().x > x:
        robot.set_velocity(-0.3, 0)
    robot.stop()


def use_gripper(robot, command):
    """Let paddles or lift move, and wait until they have stopped."""
    robot.gripper(command)
    for _ in range(5):                                  # half a second, until they surely move
        state = robot.wait_for_state()
    while state.gripper.paddles_moving or state.gripper.lift_moving:
        state = robot.wait_for_state()


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    use_gripper(robot, GripperCommand.OPEN)
    use_gripper(robot, GripperCommand.LIFT_DOWN)
    for (x, y), line in TRIPS:
        drive_to(robot, x - REACH, y)
        turn_to(robot, 0)
        while not robot.wait_for_state().gripper.inner_beam:    # until the can is between the paddles
            robot.set_velocity(0.1, 0)
        robot.stop()
        use_gripper(robot, GripperCommand.CLOSE)

        drive_to(robot, 2.1, line)
        drive_to(robot, 2.5, line)
        use_gripper(robot, GripperCommand.OPEN)
        print("The can of", x, y, "is in the dock")
        back_to(robot, 2.0)

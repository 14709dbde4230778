"""Bring three cans to the dock, one after the other.

    python3 cans.py socket://localhost:8101
"""

import math
import sys

from pioneer_control.client import GripperCommand, Robot

# Where each can stands, and on which line it is brought into the dock (m from the start: x ahead, y to the left).
TRIPS = [((1.4, 0), 0), ((1.2, 0.9), 0.4), ((1.2, -0.9), -0.4)]


def turn_to(robot, heading):
    """Turn on the spot until the robot looks along this heading (rad)."""
    error = 1
    while abs(error) > 0.02:
        state = robot.wait_for_state()
        error = math.remainder(heading - state.heading, 2 * math.pi)
        robot.set_velocity(0, max(-1, min(1, 2 * error)))
    robot.stop()


def drive_to(robot, x, y):
    """Turn to the point (x, y), drive there, and stop."""
    state = robot.wait_for_state()
    turn_to(robot, math.atan2(y - state.y, x - state.x))
    ahead = 1
    while ahead > 0.02:
        state = robot.wait_for_state()
        error = math.remainder(math.atan2(y - state.y, x - state.x) - state.heading, 2 * math.pi)
        ahead = math.hypot(x - state.x, y - state.y) * math.cos(error)
        robot.set_velocity(min(0.5, 0.1 + 0.5 * ahead), error)     # slow in the last metre; steer to the point
    robot.stop()


def use_gripper(robot, command):
    """Let the paddles or the lift move, and wait until they stand."""
    robot.gripper(command)
    for _ in range(5):                                          # half a second: they surely have begun
        state = robot.wait_for_state()
    while state.gripper.paddles_moving or state.gripper.lift_moving:
        state = robot.wait_for_state()


def fetch(robot, x, y):
    """Drive to the can at (x, y), and take it between the paddles."""
    drive_to(robot, x - 0.6, y)
    turn_to(robot, 0)
    while not robot.wait_for_state().gripper.inner_beam:        # until the can breaks the beam
        robot.set_velocity(0.1, 0)
    robot.stop()
    use_gripper(robot, GripperCommand.CLOSE)


def leave(robot, line):
    """Drive into the dock at y = line, put the can down there, and back out."""
    drive_to(robot, 2.1, line)
    drive_to(robot, 2.5, line)
    use_gripper(robot, GripperCommand.OPEN)
    while robot.wait_for_state().x > 2.1:
        robot.set_velocity(-0.3, 0)
    robot.stop()


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    use_gripper(robot, GripperCommand.OPEN)
    use_gripper(robot, GripperCommand.LIFT_DOWN)
    for (x, y), line in TRIPS:
        fetch(robot, x, y)
        leave(robot, line)
        print("The can of", x, y, "is in the dock")

"""Drive a square: to each of its corners, and back to where you began.

    python3 square.py socket://localhost:8101
"""

import math
import sys

from pioneer_control.client import Robot

CORNERS = [(2, 0), (2, 2), (0, 2), (0, 0)]      # m from the start: x ahead, y to the left


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


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    for x, y in CORNERS:
        drive_to(robot, x, y)
        print("I am at the corner", x, y)

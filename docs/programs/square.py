"""Drive a square: to each of its corners, and back to where you began.

    python3 square.py socket://localhost:8101
"""

import math
import sys

from pioneer_control.client import Robot

CORNERS = [(2, 0), (2, 2), (0, 2), (0, 0)]      # m from the start: x ahead, y to the left


def direction_to(state, x, y):
    """Return how far to the left the point (x, y) is (rad), seen from the robot; negative: to the right."""
    return math.remainder(math.atan2(y - state.y, x - state.x) - state.heading, 2 * math.pi)


def drive_to(robot, x, y):
    """Turn on the spot to the point (x, y), drive there, and stop."""
    error = 1
    while abs(error) > 0.02:
        error = direction_to(robot.wait_for_state(), x, y)
        robot.set_velocity(0, max(-1, min(1, 2 * error)))

    ahead = 1
    while ahead > 0.02:
        state = robot.wait_for_state()
        error = direction_to(state, x, y)
        ahead = math.hypot(x - state.x, y - state.y) * math.cos(error)
        robot.set_velocity(min(0.5, 0.05 + 0.5 * ahead), error)     # slow down in the last metre
    robot.stop()


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    for x, y in CORNERS:
        drive_to(robot, x, y)
        print("I am at the corner", x, y)

"""Find the way out of the maze: keep the left hand on the wall.

    python3 maze.py socket://localhost:8101

The maze is made of squares. In the middle of each the robot stands still, and its sonars look where there is no wall.
It takes the first way that is free: left, ahead, right, and back if there is no other.
"""

import math
import sys

from pioneer_control.client import Robot

SQUARE = 1.2                    # m: how long a square is
FREE = 0.8                      # m: a wall of the square in which the robot stands is nearer than this
EXIT = 4.8, 4.8                 # m from the start: x ahead, y to the left
QUARTER = math.pi / 2           # rad: a quarter of a turn


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


def find_way(robot):
    """Look round, and return how far the robot has to turn to the left (rad) to take the next way."""
    for _ in range(5):                                  # until each sonar has measured here
        sonar = robot.wait_for_state().sonar
    if sonar[0].range > FREE:
        return QUARTER
    if min(sonar[3].range, sonar[4].range) > FREE:
        return 0
    if sonar[7].range > FREE:
        return -QUARTER
    return 2 * QUARTER


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    x, y, heading = 0, 0, 0                             # the middle of the square, and where the robot looks
    while math.hypot(EXIT[0] - x, EXIT[1] - y) > SQUARE / 2:
        heading += find_way(robot)
        x += SQUARE * math.cos(heading)
        y += SQUARE * math.sin(heading)
        drive_to(robot, x, y)
    print("I am out of the maze")

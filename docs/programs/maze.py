"""Find the way out of the maze: the left hand stays on the wall.

    python3 maze.py socket://localhost:8101

The maze is made of squares of 1.2 m. In the middle of each the robot looks with its sonars where there is no wall, and
takes the first way that is free: left, ahead, right, back.
"""

import math
import sys

from pioneer_control.client import Robot

SQUARE = 1.2                    # m: how wide the ways are
EXIT = 4.8, 4.8                 # m from the start: x ahead, y to the left
FREE = 0.8                      # m: a wall of this square is nearer than this
QUARTER = math.pi / 2           # rad: a quarter of a turn


def turn_to(robot, heading):
    """Turn on the spot until the robot looks along this heading (rad)."""
    error = 1
    while abs(error) > 0.02:
        error = math.remainder(heading - robot.wait_for_state().heading, 2 * math.pi)
        robot.set_velocity(0, max(-1, min(1, 2 * error)))
    robot.stop()


def drive_to(robot, x, y):
    """Drive to the point (x, y), which is ahead, and stop."""
    distance = 1
    while distance > 0.03:
        state = robot.wait_for_state()
        distance = math.hypot(x - state.x, y - state.y)
        direction = math.atan2(y - state.y, x - state.x)
        error = math.remainder(direction - state.heading, 2 * math.pi)
        robot.set_velocity(min(0.5, 0.05 + distance), max(-1, min(1, 2 * error)))
    robot.stop()


def is_free(state, *sonars):
    """Return whether none of these sonars sees a wall of this square."""
    return all(state.sonar[sonar].range > FREE for sonar in sonars)


def look(robot):
    """Stand until each sonar has measured here, and return where a way is free: how far to turn (rad) to take it."""
    for _ in range(5):
        state = robot.wait_for_state()
    if is_free(state, 0, 15):
        return QUARTER
    if is_free(state, 3, 4):
        return 0
    if is_free(state, 7, 8):
        return -QUARTER
    return 2 * QUARTER


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    x, y, heading = 0, 0, 0                             # the middle of the square, and where the robot looks
    while math.hypot(EXIT[0] - x, EXIT[1] - y) > SQUARE / 2:
        heading += look(robot)
        turn_to(robot, heading)
        x += SQUARE * math.cos(heading)
        y += SQUARE * math.sin(heading)
        drive_to(robot, x, y)
    print("I am out of the maze")

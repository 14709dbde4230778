"""Sweep the floor of a room: row by row, there and back.

    python3 sweep.py socket://localhost:8101

The robot stands in a corner of the room, and looks along the first row. The other rows are on its left.
"""

import math
import sys

from pioneer_control.client import Robot

ROW = 0.45                      # m: from one row to the next
NEAR = 0.27                     # m: so near to a wall the robot can still turn
QUARTER = math.pi / 2           # rad: a quarter of a turn


def room_ahead(state):
    """Return how far it is to the nearest thing ahead (m)."""
    return min(state.sonar[3].range, state.sonar[4].range)


def turn_to(robot, heading):
    """Turn on the spot until the robot looks along this heading (rad)."""
    error = 1
    while abs(error) > 0.02:
        state = robot.wait_for_state()
        error = math.remainder(heading - state.heading, 2 * math.pi)
        robot.set_velocity(0, max(-1, min(1, 2 * error)))
    robot.stop()


def drive_ahead(robot, heading, way):
    """Drive along this heading (rad), so far (m), or until something is near."""
    begin = robot.wait_for_state()
    left = 1
    while left > 0.02:
        state = robot.wait_for_state()
        driven = math.hypot(state.x - begin.x, state.y - begin.y)
        left = min(way - driven, room_ahead(state) - NEAR)
        error = math.remainder(heading - state.heading, 2 * math.pi)
        robot.set_velocity(min(0.5, 0.1 + 0.5 * left), error)
    robot.stop()


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    state = robot.wait_for_state()
    while None in state.sonar:                  # until each sonar has measured once
        state = robot.wait_for_state()

    heading = 0                                 # of the first row
    while True:
        drive_ahead(robot, heading, 10)         # the row: until the wall
        turn_to(robot, QUARTER)
        for _ in range(5):                      # until the sonars have measured here
            state = robot.wait_for_state()
        if room_ahead(state) < NEAR + ROW / 2:
            break                               # there is no room for another row
        drive_ahead(robot, QUARTER, ROW)
        heading = math.pi - heading             # back: 0, 180 degrees, 0, ...
        turn_to(robot, heading)
    print("The floor is swept")

"""Drive to the goal, and go round whatever stands in the way.

    python3 goal.py socket://localhost:8101

The robot steers to the goal. It does not turn to a side where something is near. When something is ahead, it turns on
the spot, to the side that has more room, until the way is free.
"""

import math
import sys

from pioneer_control.client import Robot

GOAL = 4.5, 0.5                 # m from the start: x ahead, y to the left


def room(state, *sonars):
    """Return how far it is to the nearest thing that these sonars see (m)."""
    return min(state.sonar[number].range for number in sonars)


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    state = robot.wait_for_state()
    while None in state.sonar:                          # until each sonar has measured once
        state = robot.wait_for_state()

    distance = 1
    while distance > 0.1:
        state = robot.wait_for_state()
        distance = math.hypot(GOAL[0] - state.x, GOAL[1] - state.y)
        direction = math.atan2(GOAL[1] - state.y, GOAL[0] - state.x)
        turn = math.remainder(direction - state.heading, 2 * math.pi)
        left = room(state, 0, 1, 15)                    # the sonars count from the left, clockwise: 0 looks to the
        right = room(state, 6, 7, 8)                    # left, 3 and 4 ahead, 7 to the right, 11 and 12 back
        ahead = room(state, 2, 3, 4, 5)

        speed = min(0.4, 0.05 + 0.5 * distance)
        if ahead < 0.5:                                 # something is in the way
            speed = 0
            turn = 0.6 if room(state, 0, 1, 2, 3) > room(state, 4, 5, 6, 7) else -0.6
        elif left < 0.4:                                # something is on the left
            turn = min(turn, left - 0.35)
        elif right < 0.4:
            turn = max(turn, 0.35 - right)
        robot.set_velocity(speed, max(-0.6, min(0.6, turn)))
    robot.stop()
    print("I am at the goal")

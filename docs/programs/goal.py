"""Drive to the goal, and go round whatever stands in the way.

    python3 goal.py socket://localhost:8101

Eight sonars look to the front and to the sides. The robot drives to where one of them sees room, and of all these
directions takes the one that is next to the direction of the goal.
"""

import math
import sys

from pioneer_control.client import Robot

GOAL = 4.5, 0.5                                     # m from the start: x ahead, y to the left
ANGLES = [90, 50, 30, 10, -10, -30, -50, -90]       # degrees to the left: where the sonars 0 to 7 look
ROOM = 0.9                                          # m: so much room a direction needs


def has_room(state, sonar, way):
    """Return whether the robot can drive where this sonar looks: nothing is near there, and nothing beside it."""
    beside = state.sonar[max(0, sonar - 1):sonar + 2]
    return state.sonar[sonar].range > min(ROOM, way) and min(echo.range for echo in beside) > 0.5


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    state = robot.wait_for_state()
    while None in state.sonar:                      # until each sonar has measured once
        state = robot.wait_for_state()

    way = 1
    while way > 0.1:
        state = robot.wait_for_state()
        way = math.hypot(GOAL[0] - state.x, GOAL[1] - state.y)
        direction = math.atan2(GOAL[1] - state.y, GOAL[0] - state.x)
        turn = math.remainder(direction - state.heading, 2 * math.pi)

        free = [math.radians(ANGLES[sonar]) for sonar in range(8) if has_room(state, sonar, way)]
        if free:
            turn = min(free, key=lambda angle: abs(angle - turn))
        ahead = min(state.sonar[3].range, state.sonar[4].range)
        speed = min(0.4, 0.1 + 0.5 * way, max(0, ahead - 0.35))
        if not free or abs(turn) > 1:               # no way ahead: turn on the spot
            speed = 0
        robot.set_velocity(speed, max(-0.8, min(0.8, turn)))
    robot.stop()
    print("I am at the goal")

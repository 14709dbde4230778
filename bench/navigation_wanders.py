"""Wanders of bench/navigation.py, which do not depend on navigation: what a robot sensed, and where it was.

A wander is the same for the same arguments, so several parts of a bench can use one.
"""

import random
from typing import List, NamedTuple, Optional

from navigation_cases import case
from simulated_robot import CYCLE, SimulatedRobot

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import GridMap
from pioneer_control.navigation.expected_ranges import standing_room
from pioneer_control.navigation.values import Sensing
from pioneer_control.robots import Transducer
from pioneer_control.tutorial.wander import Memory, wander

MAP_RESOLUTION = 0.05
ROOM_TO_PUT = 0.45  # m from any wall: where a robot can be put down
FARTHER = 1.5  # m: it is carried at least as far


class Wandering(NamedTuple):
    """What to record. `carried_at`: time (s) at which the robot is put somewhere else; None: never. `laser`: whether it
    has one.
    """

    seed: int
    minutes: float
    specular_deg: float = 40.0
    speed: float = 0.4
    carried_at: Optional[float] = None
    laser: bool = False


class Wander(NamedTuple):
    """What a robot sensed in a world, and where it was at the end of each `Sensing`."""

    what: Wandering
    world: str
    model: str
    grid_map: GridMap
    transducers: List[Transducer]
    sensings: List[Sensing]
    truth: List[Pose]


def recorded(what: Wandering) -> Wander:
    """Let the robot of a seed wander, and record it."""
    its_case = case(what.seed, what.specular_deg)
    robot = SimulatedRobot(its_case.setup._replace(laser=what.laser), its_case.world, what.seed)
    grid_map = map_of(its_case.world)
    memory = Memory(seed=what.seed, speed=what.speed)
    sensings: List[Sensing] = []
    truth: List[Pose] = []
    carried = False
    while robot.firmware.time < what.minutes * 60.0 - CYCLE / 2:
        sensing, snapshot = robot.sense_both()
        sensings.append(sensing)
        truth.append(Pose(*robot.firmware.true_pose))
        if what.carried_at is not None and not carried and sensing.time >= what.carried_at:
            carried = True
            robot.firmware.hardware.carry(elsewhere(grid_map, truth[-1], what.seed))
        command, memory = wander(snapshot, memory)
        robot.command(command.linear, command.angular)
    return Wander(what, its_case.world.name, its_case.setup.model, grid_map, list(robot.shape.transducers), sensings,
                  truth)


def map_of(world) -> GridMap:
    """Return the map of a world, as map_server would give it."""
    cells, origin = world.occupancy(MAP_RESOLUTION)
    return GridMap(cells, MAP_RESOLUTION, origin)


def elsewhere(grid_map: GridMap, pose: Pose, seed: int) -> Pose:
    """Return where a seed carries a robot that is at `pose`."""
    luck = random.Random("carried %s" % seed)
    places = [place for place in standing_room(grid_map, ROOM_TO_PUT)
              if abs(place[0] - pose.x) + abs(place[1] - pose.y) > FARTHER]
    x, y = luck.choice(places)
    return Pose(float(x), float(y), luck.uniform(-3.14, 3.14))

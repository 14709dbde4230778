"""The world and the true state of its robots and cans as plain values, which fit into JSON.

Lengths are in metres, angles in radians, speeds in m/s and rad/s, times in simulated seconds, coordinates in the map
frame. Robots, cans and places are numbered from 1, in the order of their lists. docs/simulator.md has the table of all
values.
"""

import json
import math
from typing import Any, Dict, List, Optional, Sequence, Tuple

from ..firmware import Firmware
from ..line import LineSimulation
from ..line.pace import Pace
from ..simulation import Simulation
from ..tasks import Referee
from ..world import Can, World
from ..world.poses import Pose
from ..world.world import MarkedPlace

DIGITS = 4
"""Digits behind the point of all numbers in a line: tenths of a millimetre, and ten-thousandths of a radian."""
NONE = -1
"""The number of the robot that holds a can, or of the place in which it stands, if there is none."""

Message = Dict[str, Any]
"""One JSON object: plain values by their names."""


def world_of(simulation: Simulation, urls: Sequence[Optional[str]], referee: Referee) -> Message:
    """Return what changes only when another task is chosen: the part of the world that is in use, and the robots in it.

    Args:
        simulation: the robots and their world.
        urls: URL of the TCP port of each robot. None for a robot that has no TCP port.
        referee: knows which part of the world is in use.
    """
    world = referee.ground.world
    return {"world": {
        "name": world.name,
        "bounds": world.bounds,
        "walls": world.walls.tolist(),
        "posts": world.posts.tolist(),
        "boxes": world.boxes,
        "unmapped": {"walls": [wall for each in world.unmapped for wall in each.walls],
                     "posts": [post for each in world.unmapped for post in each.posts]},
        "cans": [(can.radius, can.height) for can in world.cans],
        "starts": [_wrapped(pose) for pose in world.starts],
        "docks": [_wrapped(pose) for pose in world.docks],
        "goals": {name: _wrapped(pose) for name, pose in world.goals.items()},
        "places": [_place(place) for place in world.places],
        "tasks": referee.tasks,
        "robots": [{
            "name": robot.name, "model": robot.model.subtype, "url": url,
            "start": _wrapped(start), "outline": robot.model.outline(robot.gripper is not None),
        } for robot, url, start in zip(simulation.robots, urls, referee.carrier.starts)],
    }}


def truth_of(simulation: Simulation, lines: LineSimulation, pace: Pace, referee: Referee) -> Message:
    """Return the present state of everything that changes."""
    holders = {id(robot.gripper): number for number, robot in enumerate(simulation.robots, 1)
               if robot.gripper is not None}
    return {"truth": {
        "time": lines.time,
        "speed": pace.speed,
        "paused": pace.paused,
        "late_answers": pace.late_answers,
        "robots": [(*_wrapped(robot.true_pose), *robot.velocity, robot.hardware.body.blocked)
                   for robot in simulation.robots],
        "origins": [_wrapped(robot.hardware.odometry.origin) for robot in simulation.robots],
        "grippers": [_gripper(robot) for robot in simulation.robots],
        "contacts": [robot.contacts for robot in simulation.robots],
        "touched_by_people": [robot.touched_by_people for robot in simulation.robots],
        "driven": [robot.hardware.body.driven for robot in simulation.robots],
        "stop_buttons": [robot.hardware.motors.stop_button for robot in simulation.robots],
        "cans": [(*can_place(can), holders.get(id(can.held_by), NONE), marked_place(referee.ground.world, can))
                 for can in simulation.world.cans],
        "people": [(*person.pose[:2], person.reach) for person in simulation.people],
        "faults": [str(fault) for fault in lines.faults.on],
        "task": referee.told,
    }}


def can_place(can: Can) -> Tuple[float, float, float]:
    """Return x, y and height above the floor (m, map frame) of a can. The height is 0 while no gripper holds it."""
    return can.x, can.y, 0.0 if can.held_by is None else can.held_by.height


def marked_place(world: World, can: Can) -> int:
    """Return the number (from 1) of the first place in which a can stands. `NONE` if it stands in none, or is held."""
    found = (number for number, place in enumerate(world.places, 1) if place.contains(can.x, can.y))
    return NONE if can.held_by is not None else next(found, NONE)


def line_of(message: Message) -> bytes:
    """Return a message as one line: JSON in ASCII, with rounded numbers and a newline."""
    return json.dumps(_rounded(message), separators=(",", ":")).encode("ascii") + b"\n"


def _place(place: MarkedPlace) -> Message:
    told = {"name": place.name, "centre": (place.x, place.y)}
    return {**told, "diameter": place.size[0]} if len(place.size) == 1 else {**told, "size": place.size}


def _gripper(robot: Firmware) -> Optional[List[float]]:
    """Return the distance between the paddles and their height (m). None without a gripper."""
    return None if robot.gripper is None else [robot.gripper.opening, robot.gripper.height]


def _wrapped(pose: Pose) -> Pose:
    """Return a pose with its heading between -pi and pi."""
    x, y, heading = pose
    return x, y, math.remainder(heading, 2.0 * math.pi)


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, DIGITS)
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, (list, tuple)) else value

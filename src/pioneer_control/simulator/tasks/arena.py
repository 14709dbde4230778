"""Many floors in one world: a base world, and beside it a copy of the arena of each task for each robot.

So nothing is started anew when a task is chosen: robots are carried to their copies, and cans are put out.
"""

import math
from typing import Dict, NamedTuple, Sequence

from ..carrier import Home, homes_of
from ..world import Can, World
from ..world.poses import Point, Pose
from ..world.world import MarkedPlace
from .task import Task

GAP = 1.0
"""Least distance (m) between two arenas. The corners of the copies are at whole metres from the arena's own."""


class Ground(NamedTuple):
    """The part of the world that is in use: the base world, or all copies of one arena.

    Attributes:
        world: walls, posts, boxes, cans and places that are in use.
        starts: the pose (m, rad; map frame) at which each robot starts there.
        cans: the cans that are in use, each with its first place. Those of the first robot's arena come first.
        offsets: where the origin of each robot's arena lies (m, map frame). Empty for the base world.
    """

    world: World
    starts: Sequence[Pose]
    cans: Sequence[Home]
    offsets: Sequence[Point] = ()


class Grounds:
    """The base world and the arenas of all tasks, in one world.

    Args:
        base: the base world.
        starts: the poses (m, rad; map frame) at which the robots start in the base world.
        tasks: the tasks. Without any, the world is the base world itself.

    Attributes:
        tasks: the tasks, by name, in their order.
        parts: the base world (by the name "") and the copies of the arena of each task, by its name.
    """

    def __init__(self, base: World, starts: Sequence[Pose], tasks: Sequence[Task] = ()):
        self.tasks: Dict[str, Task] = {task.name: task for task in tasks}
        self.parts: Dict[str, Ground] = {"": Ground(base, starts, homes_of(base.cans))}
        corner_x, corner_y = base.bounds[2] + GAP, base.bounds[1]
        for task in tasks:
            ground = self.parts[task.name] = _copies(task.arena, len(starts), corner_x, corner_y)
            corner_x = ground.world.bounds[2] + GAP
        self.world = base
        """All parts in one world, with the cans of the base world."""
        if tasks:
            self.world = _joined(base, starts, [ground.world for ground in self.parts.values()])
            self.world.cans = list(base.cans)


def _copies(arena: World, count: int, corner_x: float, corner_y: float) -> Ground:
    """Return `count` copies of an arena in rows, to the right of and above a corner (m, map frame)."""
    low_x, low_y, high_x, high_y = arena.bounds
    columns = math.ceil(math.sqrt(count))
    wide, high = math.ceil(high_x - low_x + GAP), math.ceil(high_y - low_y + GAP)
    first_x, first_y = math.ceil(corner_x - low_x), math.ceil(corner_y - low_y)
    offsets = [(float(first_x + number % columns * wide), float(first_y + number // columns * high))
               for number in range(count)]
    moved = [_moved(arena, *offset) for offset in offsets]
    starts = [pose for copy in moved for pose in copy.starts]
    world = _joined(arena, starts, moved)
    return Ground(world, starts, homes_of(world.cans), offsets)


def _moved(world: World, right: float, up: float) -> World:
    """Return a copy of a world that lies elsewhere (m). It has cans of its own, and no goals."""
    return World(
        world.name,
        walls=[(x1 + right, y1 + up, x2 + right, y2 + up) for x1, y1, x2, y2 in world.walls.tolist()],
        posts=[(x + right, y + up, radius) for x, y, radius in world.posts.tolist()],
        cans=[Can(can.x + right, can.y + up, can.radius, can.height) for can in world.cans],
        starts=[(x + right, y + up, heading) for x, y, heading in world.starts],
        docks=[(x + right, y + up, heading) for x, y, heading in world.docks],
        boxes=[[(x + right, y + up) for x, y in box] for box in world.boxes],
        places=[MarkedPlace(place.name, place.x + right, place.y + up, place.size) for place in world.places],
        materials=world.materials)


def _joined(first: World, starts: Sequence[Pose], worlds: Sequence[World]) -> World:
    """Return all worlds in one, with the name and the goals of `first`. They share their `Can` objects with it."""
    return World(
        first.name,
        walls=[wall for world in worlds for wall in world.walls.tolist()],
        posts=[post for world in worlds for post in world.posts.tolist()],
        cans=[can for world in worlds for can in world.cans],
        starts=starts,
        docks=[dock for world in worlds for dock in world.docks],
        goals=first.goals,
        skipped=first.skipped,
        boxes=[box for world in worlds for box in world.boxes],
        places=[place for world in worlds for place in world.places],
        unmapped=first.unmapped, walks=first.walks,
        materials=[*(each for world in worlds for each in world.materials[:len(world.walls)]),
                   *(each for world in worlds for each in world.materials[len(world.walls):])])

"""Draws an office from a seed: rooms on both sides of a corridor, with doors, desks, cupboards and chairs.

Lengths are in metres. The office lies along x, with a corner at the origin.
"""

import math
import random
from typing import List, NamedTuple, Tuple

from .furnishing import Furnishing, box, chair, post
from .poses import Point, Wall, closed
from .world import START_CLEARANCE, Furniture, World

LENGTHS, WIDTHS = (10.0, 22.0), (8.0, 16.0)
CORRIDORS, DOORS = (1.6, 2.4), (0.8, 1.0)
"""Least and greatest length and width of an office, width of its corridor, and width of its doors."""
ROOMS = (3.0, 4.8)
"""Least and greatest mean width of the rooms on one side of the corridor."""
SHARES = (0.45, 0.55)
"""Share of the width beside the corridor that the rooms on its first side have."""
FRAME = 0.15
"""Least distance from a door to the corner of its room."""
DOOR_WAY = 0.65
"""Distance around the middle of a door that is kept free of furniture."""
BETWEEN_ROOMS = 0.25
"""Probability of a door from a room to the next one on the same side."""
GAP = 0.02
"""Distance between a piece of furniture and the wall behind it."""
SIDES = (0.0, math.pi / 2.0, math.pi, -math.pi / 2.0)
"""The directions (rad) into a room from its four walls: left, lower, right, upper."""


class OfficeRoom(NamedTuple):
    """A room by its bounds (m)."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float


class Office(NamedTuple):
    """An office as it is drawn: walls, posts ``(x, y, radius)``, a start, and corners of the furniture that is filled.
    """

    walls: List[Wall]
    posts: List[Tuple[float, float, float]]
    start: Point
    boxes: List[Tuple[Point, ...]]


class _Plan:
    """The walls and rooms of an office without furniture, drawn from a seed.

    Attributes:
        walls: the walls.
        rooms: the rooms.
        doors: the middles of the doors.
        corridor: the bounds of the corridor.
    """

    def __init__(self, rng: random.Random):
        length, width, corridor = rng.uniform(*LENGTHS), rng.uniform(*WIDTHS), rng.uniform(*CORRIDORS)
        begin = (width - corridor) * rng.uniform(*SHARES)
        self.walls: List[Wall] = closed([(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)])
        self.rooms: List[OfficeRoom] = []
        self.doors: List[Point] = []
        self.corridor = OfficeRoom(0.0, begin, length, begin + corridor)
        self._add_row(rng, length, 0.0, begin, begin)
        self._add_row(rng, length, begin + corridor, width, begin + corridor)

    def _add_row(self, rng: random.Random, length: float, low_y: float, high_y: float, to_corridor: float) -> None:
        """Add a row of rooms. `to_corridor` is the y of its wall to the corridor."""
        count = max(2, round(length / rng.uniform(*ROOMS)))
        pitch = length / count
        cuts = [0.0, *(pitch * (number + rng.uniform(-0.15, 0.15)) for number in range(1, count)), length]
        for low_x, high_x in zip(cuts, cuts[1:]):
            self.rooms.append(OfficeRoom(low_x, low_y, high_x, high_y))
            door = _door(rng, low_x, high_x)
            self.doors.append(((door[0] + door[1]) / 2.0, to_corridor))
            self.walls += [(low_x, to_corridor, door[0], to_corridor), (door[1], to_corridor, high_x, to_corridor)]
        for x in cuts[1:-1]:
            if rng.random() < BETWEEN_ROOMS:
                door = _door(rng, low_y, high_y)
                self.doors.append((x, (door[0] + door[1]) / 2.0))
                self.walls += [(x, low_y, x, door[0]), (x, door[1], x, high_y)]
            else:
                self.walls.append((x, low_y, x, high_y))


def office(rng: random.Random) -> Office:
    """Return an office. All its rooms can be reached from the start by a robot 0.5 m wide."""
    plan = _Plan(rng)
    low_x, low_y, high_x, high_y = plan.corridor
    start = rng.uniform(low_x + 1.0, high_x - 1.0), (low_y + high_y) / 2.0
    kept = [(*door, DOOR_WAY) for door in plan.doors] + [(*start, START_CLEARANCE + 0.1)]
    furnishing = Furnishing(World("office", plan.walls, starts=[(*start, 0.0)]), kept)
    for room in plan.rooms:
        for _ in range(rng.randint(1, 3)):
            _add_desk(rng, room, furnishing)
        for _ in range(rng.randint(0, 2)):
            furnishing.put(_against_a_wall(rng, room, (rng.uniform(0.8, 1.2), rng.uniform(0.4, 0.5))))
        if rng.random() < 0.3:
            furnishing.put(post(_somewhere(rng, room), rng.uniform(0.12, 0.2)))
    for _ in range(rng.randint(0, 3)):
        furnishing.put(_against_a_wall(rng, plan.corridor, (rng.uniform(0.8, 1.2), rng.uniform(0.35, 0.45))))
    return Office(
        plan.walls + [wall for obstacle in furnishing.obstacles for wall in obstacle.walls],
        [leg for obstacle in furnishing.obstacles for leg in obstacle.posts], start,
        [obstacle.corners for obstacle in furnishing.obstacles if obstacle.corners])


def _door(rng: random.Random, low: float, high: float) -> Tuple[float, float]:
    """Return begin and end of a door in a wall from `low` to `high` (m along the wall)."""
    width = rng.uniform(*DOORS)
    begin = rng.uniform(low + FRAME, high - FRAME - width)
    return begin, begin + width


def _add_desk(rng: random.Random, room: OfficeRoom, furnishing: Furnishing) -> None:
    """Put a desk against a wall of the room or into it, with a chair before it. Nothing is put where there is no room.
    """
    size = rng.uniform(1.2, 1.6), rng.uniform(0.7, 0.8)
    if rng.random() < 0.75:
        desk = _against_a_wall(rng, room, size)
    else:
        desk = box(_somewhere(rng, room), size, rng.uniform(-math.pi, math.pi))
    if furnishing.put(desk):
        front = [(first + second) / 2.0 for first, second in zip(desk.corners[2], desk.corners[3])]
        back = [(first + second) / 2.0 for first, second in zip(*desk.corners[:2])]
        share = 1.0 + rng.uniform(0.25, 0.5) / size[1]
        place = back[0] + share * (front[0] - back[0]), back[1] + share * (front[1] - back[1])
        furnishing.put(chair(place, rng.uniform(0.36, 0.44), rng.uniform(-math.pi, math.pi)))


def _against_a_wall(rng: random.Random, room: OfficeRoom, size: Point) -> Furniture:
    """Return a box with its back to a wall of the room. `size` is its width along the wall and its depth."""
    into = rng.choice(SIDES)
    across = into in (SIDES[0], SIDES[2])    # the wall is along y
    low, high = (room.low_y, room.high_y) if across else (room.low_x, room.high_x)
    along = rng.uniform(low + GAP + size[0] / 2.0, high - GAP - size[0] / 2.0)
    off = GAP + size[1] / 2.0
    x, y = {SIDES[0]: (room.low_x + off, along), SIDES[1]: (along, room.low_y + off),
            SIDES[2]: (room.high_x - off, along), SIDES[3]: (along, room.high_y - off)}[into]
    return box((x, y), size, into - math.pi / 2.0)


def _somewhere(rng: random.Random, room: OfficeRoom) -> Point:
    """Return a place in the room, away from its walls."""
    return rng.uniform(room.low_x + 0.5, room.high_x - 0.5), rng.uniform(room.low_y + 0.5, room.high_y - 0.5)

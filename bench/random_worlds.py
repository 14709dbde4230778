"""Worlds drawn from a seed: hard but fair floors for benchmarks and tests.

Every world is closed and turned by an angle of its own, so that nothing lies along the axes. It has one start, where
any of the robots has room to turn and from where there is room to go.
"""

import math
import random
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from free_space import room

from pioneer_control.errors import WorldError
from pioneer_control.simulator.world.poses import Point, Wall, box_walls, closed, compose, unit
from pioneer_control.simulator.world.world import START_CLEARANCE, World

START_ROOM = 2.0
"""Least room (m, see `free_space.room`) that a start has."""


class Floor(NamedTuple):
    """A world as it is drawn, before it is turned: walls, posts (x, y, radius), and where a robot may start."""

    walls: List[Wall]
    posts: List[Tuple[float, float, float]]
    start: Point


def random_world(seed: int, kind: Optional[str] = None) -> World:
    """Return the world of a seed. It is always the same for the same seed and kind.

    Args:
        kind: one of `KINDS`; None takes them in turn, so that a row of seeds has all of them.

    Raises:
        WorldError: for another kind.
    """
    kind = sorted(KINDS)[seed % len(KINDS)] if kind is None else kind
    if kind not in KINDS:
        raise WorldError("no kind of random world is called %r; known: %s" % (kind, ", ".join(sorted(KINDS))))
    rng = random.Random(seed)
    while True:
        world = _turned(KINDS[kind](rng), rng.uniform(-math.pi, math.pi), rng.uniform(-math.pi, math.pi),
                        "%s-%s" % (kind, seed))
        x, y, _ = world.starts[0]
        if world.clearance(x, y) >= START_CLEARANCE and room(world, x, y) >= START_ROOM:
            return world


def _turned(floor: Floor, angle: float, heading: float, name: str) -> World:
    def turned(x: float, y: float) -> Point:
        return compose((0.0, 0.0, angle), (x, y, 0.0))[:2]

    return World(
        name,
        walls=[turned(x1, y1) + turned(x2, y2) for x1, y1, x2, y2 in floor.walls],
        posts=[turned(x, y) + (radius,) for x, y, radius in floor.posts],
        starts=[turned(*floor.start) + (heading,)],
    )


def corridors(rng: random.Random) -> Floor:
    """Return a maze of corridors 1.1 to 1.9 m wide. It has a few more doors than it needs, so that some ways lead
    round.
    """
    xs = _steps(rng, rng.randint(4, 6), 1.1, 1.9)
    ys = _steps(rng, rng.randint(4, 6), 1.1, 1.9)
    columns, rows = len(xs) - 1, len(ys) - 1
    doors = _spanning_doors(rng, columns, rows)
    walls = closed([(0.0, 0.0), (xs[-1], 0.0), (xs[-1], ys[-1]), (0.0, ys[-1])])
    for column in range(columns):
        for row in range(rows):
            for other, wall in (
                ((column + 1, row), (xs[column + 1], ys[row], xs[column + 1], ys[row + 1])),
                ((column, row + 1), (xs[column], ys[row + 1], xs[column + 1], ys[row + 1])),
            ):
                inside = other[0] < columns and other[1] < rows
                if inside and ((column, row), other) not in doors and rng.random() > 0.15:
                    walls.append(wall)
    column, row = rng.randrange(columns), rng.randrange(rows)
    return Floor(walls, [], ((xs[column] + xs[column + 1]) / 2.0, (ys[row] + ys[row + 1]) / 2.0))


def _spanning_doors(rng: random.Random, columns: int, rows: int) -> set:
    """Doors between neighbouring cells, as pairs in growing order, that join all cells:
    a walk that backs up when it is stuck.
    """
    walk, seen, doors = [(0, 0)], {(0, 0)}, set()
    while walk:
        column, row = walk[-1]
        sides = ((column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1))
        fresh = [cell for cell in sides if cell not in seen and 0 <= cell[0] < columns and 0 <= cell[1] < rows]
        if fresh:
            cell = rng.choice(fresh)
            doors.add((min(walk[-1], cell), max(walk[-1], cell)))
            seen.add(cell)
            walk.append(cell)
        else:
            walk.pop()
    return doors


def clutter(rng: random.Random) -> Floor:
    """Return a room full of boxes, small and large, at all angles."""
    width, depth = rng.uniform(6.0, 10.0), rng.uniform(6.0, 10.0)
    start = _away_from_walls(rng, width, depth)
    walls = closed([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
    for _ in range(rng.randint(10, 22)):
        length, breadth = rng.uniform(0.15, 1.4), rng.uniform(0.15, 0.8)
        inset = math.sqrt(length * length + breadth * breadth) / 2.0
        x, y = rng.uniform(inset, width - inset), rng.uniform(inset, depth - inset)
        walls += box_walls((x, y), (length, breadth), rng.uniform(-math.pi, math.pi))
    return Floor(walls, [], start)


def corners(rng: random.Random) -> Floor:
    """Return a room with a jagged outline and a few free wedges."""
    count = rng.randint(6, 11)
    outline = []
    for number in range(count):
        angle = 2.0 * math.pi * (number + rng.uniform(-0.35, 0.35)) / count
        distance = rng.uniform(4.0, 6.5) if number % 2 else rng.uniform(1.7, 3.6)
        outline.append(_ahead((0.0, 0.0), angle, distance))
    walls = closed(outline)
    for _ in range(rng.randint(1, 3)):
        angle, distance = rng.uniform(-math.pi, math.pi), rng.uniform(1.2, 2.2)
        tip = _ahead((0.0, 0.0), angle, distance)
        opening, side, arm = rng.uniform(0.35, 1.3), rng.uniform(-math.pi, math.pi), rng.uniform(0.5, 1.3)
        for way in (side - opening / 2.0, side + opening / 2.0):
            walls.append(tip + _ahead(tip, way, arm))
    return Floor(walls, [], (0.0, 0.0))


def dead_ends(rng: random.Random) -> Floor:
    """Return a hall with alcoves on both sides, some of them narrowing. Every way except along the hall ends at a wall.
    """
    length, width = rng.uniform(7.0, 11.0), rng.uniform(1.3, 2.2)
    below = _alcoves(rng, length)
    above = _alcoves(rng, length)
    outline = [(x, -y) for x, y in below] + [(x, width + y) for x, y in reversed(above)]
    return Floor(closed(outline), [], (rng.uniform(1.0, length - 1.0), width / 2.0))


def _alcoves(rng: random.Random, length: float) -> List[Point]:
    """Return one side of a hall from x = 0 to `length`, as corners (x, depth)."""
    side: List[Point] = [(0.0, 0.0)]
    x = rng.uniform(0.2, 1.5)
    while True:
        mouth, depth = rng.uniform(1.1, 1.8), rng.uniform(0.8, 3.0)
        if x + mouth > length - 0.2:
            return side + [(length, 0.0)]
        narrowing = mouth * rng.choice((0.0, 0.0, 0.25, 0.45))
        side += [(x, 0.0), (x + narrowing, depth), (x + mouth - narrowing, depth), (x + mouth, 0.0)]
        x += mouth + rng.uniform(0.3, 1.6)


def poles(rng: random.Random) -> Floor:
    """Return a bare room with poles of 5 to 30 cm, single and in rows. A robot may or may not fit through a row."""
    width, depth = rng.uniform(5.5, 9.0), rng.uniform(5.5, 9.0)
    start = _away_from_walls(rng, width, depth)
    posts = []
    for _ in range(rng.randint(10, 24)):
        posts.append((rng.uniform(0.2, width - 0.2), rng.uniform(0.2, depth - 0.2),
                      rng.choice((0.025, 0.025, 0.05, 0.15))))
    for _ in range(rng.randint(0, 2)):
        x, y = rng.uniform(1.0, width - 1.0), rng.uniform(1.0, depth - 1.0)
        angle, gap = rng.uniform(-math.pi, math.pi), rng.uniform(0.3, 1.2)
        for number in range(rng.randint(3, 5)):
            posts.append((*_ahead((x, y), angle, number * gap), 0.025))
    inside = [post for post in posts if 0.1 < post[0] < width - 0.1 and 0.1 < post[1] < depth - 0.1]
    return Floor(closed([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]), inside, start)


KINDS: Dict[str, Callable[[random.Random], Floor]] = {
    function.__name__: function for function in (corridors, clutter, corners, dead_ends, poles)
}


def _ahead(point: Point, angle: float, distance: float) -> Point:
    """Return the point at a distance from another one in a direction (rad)."""
    cosine, sine = unit(angle)
    return point[0] + distance * cosine, point[1] + distance * sine


def _away_from_walls(rng: random.Random, width: float, depth: float) -> Point:
    return rng.uniform(0.8, width - 0.8), rng.uniform(0.8, depth - 0.8)


def _steps(rng: random.Random, count: int, least: float, most: float) -> List[float]:
    """Return positions from 0 on, with `count` random distances between them."""
    positions = [0.0]
    for _ in range(count):
        positions.append(positions[-1] + rng.uniform(least, most))
    return positions

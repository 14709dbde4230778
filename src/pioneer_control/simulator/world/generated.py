"""Draws worlds from seeds: hard but fair floors for tests and benchmarks, and offices.

The same kind and seed give the same world for ever, because published results and recorded runs name them. Every world
is closed and turned by an angle of its own, so that nothing lies along the axes. It has one start, where any of the
robots has room to turn and from where there is room to go.
"""

import math
import random
import re
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

from ...errors import WorldError
from .free_space import room
from .furnishing import PASSAGE, PASSAGE_OF_PEOPLE, Furnishing, box, post
from .offices import office
from .poses import Point, Wall, box_walls, closed, compose, unit
from .world import START_CLEARANCE, Walk, World

START_ROOM = 2.0
"""Least room (m, see `free_space.room`) that a start has."""


class DrawnFloor(NamedTuple):
    """A world as it is drawn, before it is turned: walls, posts (x, y, radius), where a robot may start, and the
    corners of each filled box, whose sides are among the walls.
    """

    walls: List[Wall]
    posts: List[Tuple[float, float, float]]
    start: Point
    boxes: Sequence[Sequence[Point]] = ()


def random_world(seed: int, kind: Optional[str] = None, kinds: Sequence[str] = ()) -> World:
    """Return the world of a seed. It is always the same for the same seed and kind.

    Args:
        seed: a whole number from 0 to `LARGEST_SEED`.
        kind: one of `KINDS`. If None, the seed decides.
        kinds: the kinds that are taken in turn, so that a row of seeds has all of them. `IN_TURN` if empty.

    Raises:
        WorldError: there is no such kind, or the seed is not legal.
    """
    if kind is None:
        kinds = kinds or IN_TURN
        kind = kinds[seed % len(kinds)]
    if kind not in KINDS:
        raise WorldError("no kind of generated world is called %r; known: %s" % (kind, ", ".join(sorted(KINDS))))
    if not 0 <= seed <= LARGEST_SEED:
        raise WorldError("world %s-%s: seed %s is not legal: give a whole number from 0 to %s"
                         % (kind, seed, seed, LARGEST_SEED))
    rng = random.Random(seed)
    while True:
        world = _turned(KINDS[kind](rng), rng.uniform(-math.pi, math.pi), rng.uniform(-math.pi, math.pi),
                        "%s-%s" % (kind, seed))
        x, y, _ = world.starts[0]
        if world.clearance(x, y) >= START_CLEARANCE and room(world, x, y) >= START_ROOM:
            return world


def named_world(name: str) -> Optional[World]:
    """Return the generated world with a name of the form KIND-SEED, such as ``offices-7``. None for other names.

    Raises:
        WorldError: the kind is known, but the seed is not legal.
    """
    kind, hyphen, seed = name.partition("-")
    if kind not in KINDS or not hyphen:
        return None
    if not re.fullmatch("[0-9]{1,%d}" % len(str(LARGEST_SEED)), seed):
        raise WorldError("world %s: seed %r is not legal: give a whole number from 0 to %s, such as %s-7"
                         % (name, seed, LARGEST_SEED, kind))
    return random_world(int(seed), kind)


def with_unmapped(world: World, count: int, seed: int) -> World:
    """Return a copy of a world with boxes and posts that are on no map, at random places on its free floor.

    They cut off no floor: a robot 0.5 m wide gets everywhere where it got before, and so do people. They keep away from
    starts, docks and goals. There are fewer than `count` if the floor has no room for more.
    """
    rng = random.Random("unmapped %s" % seed)
    kept = [(x, y, START_CLEARANCE + 0.1) for x, y, _ in (*world.starts, *world.docks, *world.goals.values())]
    furnishing = Furnishing(world, kept, (PASSAGE, PASSAGE_OF_PEOPLE))
    for _ in range(TRIES * count):
        free = furnishing.reached()
        if len(furnishing.obstacles) == count or not len(free):
            break
        x, y = free[int(rng.random() * len(free))].tolist()
        angle = rng.uniform(-math.pi, math.pi)
        furnishing.put(box((x, y), (rng.uniform(0.25, 0.6), rng.uniform(0.2, 0.4)), angle) if rng.random() < 0.6
                       else post((x, y), rng.uniform(0.05, 0.15)))
    return world.changed(unmapped=[*world.unmapped, *furnishing.obstacles])


def with_walkers(world: World, count: int, seed: int) -> World:
    """Return a copy of a world in which `count` more people walk to random places, and look where they go."""
    rng = random.Random("walkers %s" % seed)
    return world.changed(walks=[*world.walks, *(Walk(seed=rng.getrandbits(31)) for _ in range(count))])


def _turned(floor: DrawnFloor, angle: float, heading: float, name: str) -> World:
    def turned(x: float, y: float) -> Point:
        return compose((0.0, 0.0, angle), (x, y, 0.0))[:2]

    return World(
        name,
        walls=[turned(x1, y1) + turned(x2, y2) for x1, y1, x2, y2 in floor.walls],
        posts=[turned(x, y) + (radius,) for x, y, radius in floor.posts],
        starts=[turned(*floor.start) + (heading,)],
        boxes=[[turned(x, y) for x, y in corners] for corners in floor.boxes],
    )


def corridors(rng: random.Random) -> DrawnFloor:
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
    return DrawnFloor(walls, [], ((xs[column] + xs[column + 1]) / 2.0, (ys[row] + ys[row + 1]) / 2.0))


def _spanning_doors(rng: random.Random, columns: int, rows: int) -> Set[Tuple[Tuple[int, int], Tuple[int, int]]]:
    """Doors between neighbouring cells, as pairs in growing order, that join all cells:
    a walk that backs up when it is stuck.
    """
    walk, seen = [(0, 0)], {(0, 0)}
    doors: Set[Tuple[Tuple[int, int], Tuple[int, int]]] = set()
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


def clutter(rng: random.Random) -> DrawnFloor:
    """Return a room full of boxes, small and large, at all angles."""
    width, depth = rng.uniform(6.0, 10.0), rng.uniform(6.0, 10.0)
    start = _away_from_walls(rng, width, depth)
    walls = closed([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
    for _ in range(rng.randint(10, 22)):
        length, breadth = rng.uniform(0.15, 1.4), rng.uniform(0.15, 0.8)
        inset = math.sqrt(length * length + breadth * breadth) / 2.0
        x, y = rng.uniform(inset, width - inset), rng.uniform(inset, depth - inset)
        walls += box_walls((x, y), (length, breadth), rng.uniform(-math.pi, math.pi))
    return DrawnFloor(walls, [], start)


def corners(rng: random.Random) -> DrawnFloor:
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
    return DrawnFloor(walls, [], (0.0, 0.0))


def dead_ends(rng: random.Random) -> DrawnFloor:
    """Return a hall with alcoves on both sides, some of them narrowing. Every way except along the hall ends at a wall.
    """
    length, width = rng.uniform(7.0, 11.0), rng.uniform(1.3, 2.2)
    below = _alcoves(rng, length)
    above = _alcoves(rng, length)
    outline = [(x, -y) for x, y in below] + [(x, width + y) for x, y in reversed(above)]
    return DrawnFloor(closed(outline), [], (rng.uniform(1.0, length - 1.0), width / 2.0))


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


def poles(rng: random.Random) -> DrawnFloor:
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
    return DrawnFloor(closed([(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]), inside, start)


def offices(rng: random.Random) -> DrawnFloor:
    """Return an office: rooms on both sides of a corridor, with furniture. See `offices.office`."""
    return DrawnFloor(*office(rng))


KINDS: Dict[str, Callable[[random.Random], DrawnFloor]] = {
    function.__name__: function for function in (corridors, clutter, corners, dead_ends, poles, offices)
}
"""Functions that draw a floor, by kind."""
IN_TURN = ("clutter", "corners", "corridors", "dead_ends", "poles")
"""The kinds that seeds take in turn when none is named: those of bench/wander.md."""
LARGEST_SEED = 999999999
TRIES = 20
"""How many places are tried for each obstacle that is on no map, at most."""


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

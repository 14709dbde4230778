"""Pushing of cans: a robot pushes aside the cans on the floor that it touches. Only walls and other robots jam a can.

Blocks are rectangles parallel to the axes of base_link (m). The positions of cans are in the map frame (m).
"""

import math
from typing import Callable, List, Optional, Sequence, Set

from .geometry import TOUCH, Block
from .poses import Point, Pose, compose, hypot, relative
from .world import Can, World

ROUNDS = 200
"""Number of rounds of pushes after which a can counts as jammed. A can in a narrow wedge needs many small pushes."""
PUSHED_FAR = 2.0
"""Distance (m) around a pushing robot. Only other robots within this distance can stop the pushed cans."""
STILL = 1e-7
"""Distance (m). Cans that are this near to their places of two rounds before are only pushed back and forth."""
PROBE = 1e-3
"""Distance (m) on either side of a can at which wall clearance is measured, to find the direction away from a wall."""


def cans_near(world: World, pose: Pose, reach: float) -> List[Can]:
    """Return the cans on the floor that have a point within `reach` (m) of the middle of a robot at `pose`."""
    x, y, _ = pose
    beside = [can for can in world.cans if -reach - can.radius < can.x - x < reach + can.radius]
    return [can for can in beside if can.held_by is None and hypot(can.x - x, can.y - y) < reach + can.radius]


def make_way(
    world: World, pose: Pose, blocks_for: Callable[[float], Sequence[Block]], held: Sequence[Can], reach: float,
) -> bool:
    """Push cans out of the way of a robot at `pose`. Pushed cans push other cans.

    Args:
        world: world whose cans are moved.
        pose: pose of the robot (m, rad; map frame).
        blocks_for: function that returns the rectangles of the robot (m, base_link) that push a can of a given radius.
        held: cans in the gripper, which push the cans on the floor.
        reach: largest distance (m) from the middle of the robot at which a part of it can touch a can.

    Returns:
        True when there is a place for every can. False when a can is jammed against a wall or another robot; then no
        can was moved.
    """
    near = cans_near(world, pose, reach)
    if not near:
        return True
    standing = [can for can in world.cans if can.held_by is None]
    known = set(map(id, near))
    pending = [key for key, can in enumerate(standing) if id(can) in known]
    places = [(can.x, can.y) for can in standing]
    moved: Set[int] = set()
    history: List[List[Point]] = []
    for _ in range(ROUNDS):
        changed: Set[int] = set()
        for key in pending:
            radius = standing[key].radius
            place = _off_robot(pose, blocks_for(radius), held, places[key], radius)
            if place is None and key in moved:
                place = (_off_walls(world, places[key], radius)
                         or _off_other_robots(world, pose, places[key], radius))
            if place is not None:
                places[key] = place
                changed.add(key)
                changed |= _shove_others(key, standing, places)
        if not changed:
            for key in moved:
                standing[key].x, standing[key].y = places[key]
            return True
        moved |= changed
        pending = sorted(changed.union(pending))
        if len(history) == 2 and _same(history.pop(0), places):
            return False
        history.append(list(places))
    return False


def _same(before: List[Point], now: List[Point]) -> bool:
    return all(abs(x1 - x2) < STILL and abs(y1 - y2) < STILL for (x1, y1), (x2, y2) in zip(before, now))


def _shove_others(key: int, cans: Sequence[Can], places: List[Point]) -> Set[int]:
    """Push every can that overlaps can number `key` straight away from that can.

    Args:
        key: index of the pushing can in `cans` and `places`.
        cans: all cans on the floor.
        places: their middles (m, map frame). The places of pushed cans are changed.

    Returns:
        The indices of the cans that were pushed.
    """
    shoved = set()
    radius, (x, y) = cans[key].radius, places[key]
    for other, (other_x, other_y) in enumerate(places):
        reach = radius + cans[other].radius
        beside = -reach < other_x - x < reach and other != key      # of many cans, most are farther away
        place = _pushed_off(other_x, other_y, x, y, reach) if beside else None
        if place is not None:
            places[other] = place
            shoved.add(other)
    return shoved


def _pushed_off(x: float, y: float, from_x: float, from_y: float, reach: float) -> Optional[Point]:
    """Move the point (x, y) straight away from the point (from_x, from_y), to the distance `reach`.

    Returns:
        The new point, or None when the distance is `reach` or more already.
    """
    away_x, away_y = x - from_x, y - from_y
    distance = math.sqrt(away_x * away_x + away_y * away_y)
    if distance > reach - TOUCH:
        return None
    if distance == 0.0:
        return from_x + reach, from_y
    return from_x + away_x * reach / distance, from_y + away_y * reach / distance


def _off_walls(world: World, place: Point, radius: float) -> Optional[Point]:
    """Return where a can that overlaps a wall is pushed to, away from the wall. None when it overlaps no wall.

    `place` is the middle of the can (m, map frame), and `radius` its radius (m).
    """
    x, y = place
    square = ((x - radius, y - radius), (x + radius, y - radius), (x + radius, y + radius), (x - radius, y + radius))
    if not world.touches(square):  # cheaper than `clearance`, and mostly enough
        return None
    clearance = world.clearance(x, y)
    if clearance > radius - TOUCH:
        return None
    slope_x = world.clearance(x + PROBE, y) - world.clearance(x - PROBE, y)
    slope_y = world.clearance(x, y + PROBE) - world.clearance(x, y - PROBE)
    steepness = math.sqrt(slope_x * slope_x + slope_y * slope_y)
    if steepness == 0.0:
        return x + radius, y
    step = (radius - clearance) / steepness
    return x + slope_x * step, y + slope_y * step


def _off_other_robots(world: World, pose: Pose, place: Point, radius: float) -> Optional[Point]:
    """Return where a can is pushed to that overlaps a robot other than the one at `pose`. None when it overlaps none.

    The other robot does not move.
    """
    others = [body for body in world.crowd.near(pose[0], pose[1], PUSHED_FAR) if body.pose != pose]
    pushed = (_off_robot(body.pose, (body.box,), (), place, radius) for body in others)
    return next(filter(None, pushed), None)


def _off_robot(
    pose: Pose, blocks: Sequence[Block], held: Sequence[Can], place: Point, radius: float,
) -> Optional[Point]:
    """Return where the robot at `pose` pushes a can that overlaps its blocks or a can that it holds.

    Args:
        pose: pose of the robot (m, rad; map frame).
        blocks: rectangles of the robot (m, base_link).
        held: cans that the robot holds.
        place: middle of the pushed can (m, map frame).
        radius: radius of the pushed can (m).

    Returns:
        The new middle of the can (m, map frame). None when the can overlaps no block and no held can.
    """
    x, y, _ = relative(pose, (place[0], place[1], 0.0))
    moved: Optional[Point] = None
    for block in blocks:
        away = block.push(x, y, radius)
        if away is not None:
            x, y = away
            moved = compose(pose, (x, y, 0.0))[:2]
    for can in held:
        moved = _pushed_off(*(moved or place), can.x, can.y, radius + can.radius) or moved
    return moved

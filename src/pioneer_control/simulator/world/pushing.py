"""Cans give way: a robot pushes aside what stands on the floor. Cans jam only against walls and other robots.

Blocks are rectangles along the axes of the robot's own frame (m, base_link); cans stand in the map frame.
"""

import math
from typing import Callable, List, Optional, Sequence, Set

from .geometry import TOUCH, Block
from .poses import Point, Pose, compose, hypot, relative
from .world import Can, World

ROUNDS = 200
"""After so many rounds of pushes a can counts as jammed. To slide out of a narrow wedge takes many small pushes."""
PUSHED_FAR = 2.0
"""No can that a robot pushes reaches another robot farther away (m) than this."""
STILL = 1e-7
"""Cans that come back this near (m) to where they were two rounds ago are only pushed to and fro."""
PROBE = 1e-3
"""How far apart (m) the clearance of a wall is probed to find which way leads away from it."""


def cans_near(world: World, pose: Pose, reach: float) -> List[Can]:
    """The cans standing so near a robot that something `reach` from its middle could meet them."""
    x, y, _ = pose
    beside = [can for can in world.cans if -reach - can.radius < can.x - x < reach + can.radius]
    return [can for can in beside if can.held_by is None and hypot(can.x - x, can.y - y) < reach + can.radius]


def make_way(
    world: World, pose: Pose, blocks_for: Callable[[float], Sequence[Block]], held: Sequence[Can], reach: float,
) -> bool:
    """Push cans out of the way of a robot at `pose`, and whatever they push out of theirs.

    Args:
        blocks_for: the blocks that a can of a given radius meets.
        held: cans in the gripper that push others as they go.
        reach: how far from the middle of the robot anything of it can meet a can.

    Returns:
        True when every can found a place; False when one is jammed against a wall or another robot. Then none was
        moved.
    """
    near = cans_near(world, pose, reach)
    if not near:
        return True
    standing = [can for can in world.cans if can.held_by is None]
    pending = [key for key, can in enumerate(standing) if any(can is other for other in near)]
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
    """Move every can that overlaps number `key` straight away from it, and return the numbers of those."""
    shoved = set()
    x, y = places[key]
    for other, (other_x, other_y) in enumerate(places):
        reach = cans[key].radius + cans[other].radius
        place = _pushed_off(other_x, other_y, x, y, reach) if other != key else None
        if place is not None:
            places[other] = place
            shoved.add(other)
    return shoved


def _pushed_off(x: float, y: float, from_x: float, from_y: float, reach: float) -> Optional[Point]:
    """The new place of a point nearer than `reach` to another one: straight away from it; None for any other."""
    away_x, away_y = x - from_x, y - from_y
    distance = math.sqrt(away_x * away_x + away_y * away_y)
    if distance > reach - TOUCH:
        return None
    if distance == 0.0:
        return from_x + reach, from_y
    return from_x + away_x * reach / distance, from_y + away_y * reach / distance


def _off_walls(world: World, place: Point, radius: float) -> Optional[Point]:
    """The new place of a can that overlaps a wall: away from the wall; None for any other can."""
    x, y = place
    square = ((x - radius, y - radius), (x + radius, y - radius), (x + radius, y + radius), (x - radius, y + radius))
    if not world.touches(square):  # cheaper than to ask how far the walls are, and mostly enough
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
    """The new place of a can that overlaps a robot other than the one at `pose`; None for any other can.

    That robot does not give way.
    """
    others = [body for body in world.crowd.near(pose[0], pose[1], PUSHED_FAR) if body.pose != pose]
    pushed = (_off_robot(body.pose, (body.box,), (), place, radius) for body in others)
    return next(filter(None, pushed), None)


def _off_robot(
    pose: Pose, blocks: Sequence[Block], held: Sequence[Can], place: Point, radius: float,
) -> Optional[Point]:
    """The new place of a can that overlaps the robot at `pose`: its blocks, or a can that it holds; None for any other
    can.
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

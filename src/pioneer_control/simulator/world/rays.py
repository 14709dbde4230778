"""Where rays of light end in a world: at the nearest wall, post or body, how far away, and at which slant.

A ray meets what sonar detects: walls, posts, people and the bodies of robots. Cans are lower than the sonar plane, and
lasers sit higher than that. The world does not know any other height, nor glass.

Lengths are in metres, all coordinates in the map frame. Distances are computed with ``+ - * / sqrt`` and comparisons
only, as in `echoes`.
"""

import itertools
from typing import NamedTuple, Optional, Tuple

import numpy as np

from .crowd import Obstacle
from .echoes import SECTORS, SECTORS_PER_RADIAN, SQUARE, Ear, Earshot, Surroundings
from .geometry import Array

_SPREAD = 1e-3  # rad: rounding may put a ray this far beside its sector
_ROOM = 0.25     # m: all rays that begin so near (x and y) to the first one use its square of floor
_CRACK = 1e-9   # m: walls count as this much longer, so that no ray slips through a corner


class LightRays(NamedTuple):
    """Some rays: where each begins (m, map frame), and the unit vector of its direction. All are arrays (n)."""

    x: Array
    y: Array
    to_x: Array
    to_y: Array

    def part(self, some: slice) -> "LightRays":
        """Return some of these rays."""
        return LightRays(*(column[some] for column in self))


class RayEnds(NamedTuple):
    """Where rays end. All are arrays (n).

    Attributes:
        distance: length of each ray (m); infinite if it meets nothing.
        cosine: cosine of the angle between the ray and the normal of the surface; 0 if it meets nothing.
        on_body: whether it ends at a person or a robot.
    """

    distance: Array
    cosine: Array
    on_body: Array


class RayCaster(Ear):
    """Computes where rays end in one world.

    Args:
        world: the world, with all bodies in it.
        maximum: longest ray (m).
    """

    def __init__(self, world: Surroundings, maximum: float):
        super().__init__(world, _SPREAD, maximum)

    def cast(self, rays: LightRays, carrier: Optional[Obstacle] = None) -> RayEnds:
        """Return where rays end. They should be sorted by direction, which saves time.

        Args:
            rays: at least one ray.
            carrier: the body from which the rays come. They do not meet it.
        """
        distance, cosine = np.full(len(rays.x), np.inf), np.zeros(len(rays.x))
        sectors = np.floor(np.arctan2(rays.to_y, rays.to_x) * SECTORS_PER_RADIAN).astype(int) % SECTORS
        squares = [np.floor(np.where(np.abs(along - along[0]) <= _ROOM, along[0], along) / SQUARE).astype(int)
                   for along in (rays.x, rays.y)]
        begin = 0
        for (column, row, sector), same in itertools.groupby(zip(*(each.tolist() for each in (*squares, sectors)))):
            some = slice(begin, begin + len(list(same)))
            begin = some.stop
            packed = self._earshot(column, row)[sector]
            if packed:
                distance[some], cosine[some] = _nearest(rays.part(some), np.frombuffer(packed).reshape(-1, 6))
        bodies = [candidate for body in self._world.crowd.near(float(rays.x[0]), float(rays.y[0]), self._maximum,
                                                               carrier)
                  if body is not carrier for candidate in body.candidates]
        on_body = np.zeros(len(rays.x), dtype=bool)
        if bodies:
            body_distance, body_cosine = _nearest(rays, np.array(bodies))
            on_body = body_distance < distance
            distance = np.where(on_body, body_distance, distance)
            cosine = np.where(on_body, body_cosine, cosine)
        too_far = distance > self._maximum
        distance[too_far], cosine[too_far], on_body[too_far] = np.inf, 0.0, False
        return RayEnds(distance, cosine, on_body)

    def _listen(self, column: int, row: int) -> Earshot:
        """Compute what rays can meet that begin in this square of floor, or not farther than `_ROOM` from it."""
        x, y, spread = (column + 0.5) * SQUARE, (row + 0.5) * SQUARE, SQUARE * 0.7072 + _ROOM * 1.4143
        solids = self._solids.within(x, y, self._maximum + spread)
        return Earshot(solids, x, y, spread, self._rights, self._lefts) if len(solids) else self._silence


def _nearest(rays: LightRays, candidates: Array) -> Tuple[Array, Array]:
    """Return distance and cosine of the nearest end of each ray at any candidate (rows of six numbers, `Candidate`)."""
    is_wall = candidates[:, 5] >= 0.0
    parts = [meet(rays, candidates[chosen, 1:].T)
             for meet, chosen in ((_wall_ends, is_wall), (_post_ends, ~is_wall)) if chosen.any()]
    distances, cosines = (np.concatenate(each, axis=1) for each in zip(*parts))
    nearest = distances.argmin(axis=1)[:, None]
    distance = np.take_along_axis(distances, nearest, axis=1)[:, 0]
    cosine = np.take_along_axis(cosines, nearest, axis=1)[:, 0]
    return distance, np.where(np.isfinite(distance), cosine, 0.0)


def _wall_ends(rays: LightRays, walls: Array) -> Tuple[Array, Array]:
    """Return distances and cosines of all rays at all walls, arrays (rays, walls). A distance is infinite if the ray
    does not meet the wall.
    """
    x, y, to_x, to_y = (column[:, None] for column in rays)
    start_x, start_y, along_x, along_y, length = walls
    start_x, start_y = start_x - x, start_y - y
    across = to_x * along_y - to_y * along_x
    with np.errstate(divide="ignore", invalid="ignore"):    # a ray along a wall does not meet it
        distance = (start_x * along_y - start_y * along_x) / across
        place = (start_x * to_y - start_y * to_x) / across
    meets = (distance >= 0.0) & (place >= -_CRACK) & (place <= length + _CRACK)
    return np.where(meets, distance, np.inf), np.abs(across)


def _post_ends(rays: LightRays, posts: Array) -> Tuple[Array, Array]:
    """Return distances and cosines of all rays at all posts, as `_wall_ends`. Inside a post the distance is 0."""
    x, y, to_x, to_y = (column[:, None] for column in rays)
    middle_x, middle_y, radius = posts[:3]
    middle_x, middle_y = middle_x - x, middle_y - y
    ahead, aside = to_x * middle_x + to_y * middle_y, to_x * middle_y - to_y * middle_x
    depth = np.sqrt(np.maximum(radius * radius - aside * aside, 0.0))
    inside = middle_x * middle_x + middle_y * middle_y <= radius * radius
    meets = inside | ((np.abs(aside) <= radius) & (ahead > 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):    # the end of a wall may be a post of no radius
        cosine = np.where(radius > 0.0, depth / radius, 1.0)
    return np.where(meets, np.where(inside, 0.0, ahead - depth), np.inf), cosine

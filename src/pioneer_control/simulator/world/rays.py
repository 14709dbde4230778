"""Where rays of light end in a world: at the nearest wall, post or body, how far away, at which slant, and at what.

A ray meets what sonar detects: walls, posts, people and the bodies of robots. Cans are lower than the sonar plane, and
lasers sit higher than that. The world does not know any other height.

Lengths are in metres, all coordinates in the map frame. Distances are computed with ``+ - * / sqrt`` and comparisons
only, as in `echoes`.

To save time, all rays are computed together. What a ray may meet is looked up by the square of floor in which it begins
and the sector of directions to which it belongs; the result is a long list of pairs of a ray and a wall or post.
"""

import functools
import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from .crowd import Obstacle
from .echoes import SQUARE, Surroundings, audible
from .geometry import Array, Solids
from .poses import unit

SECTORS = 128
"""Number of equal sectors of directions into which walls and posts are sorted."""
SECTORS_PER_RADIAN = SECTORS / (2.0 * math.pi)
NEAR = 8.0
"""Distance (m) within which walls and posts are looked at first. Only rays that meet nothing there look farther."""
MOST_SQUARES = 512
"""Squares of floor for which the walls and posts that rays can meet are kept in memory."""

_SPREAD = 1e-3  # rad: rounding may put a ray this far beside its sector
_ROOM = 0.25     # m: all rays that begin so near (x and y) to the first one use its square of floor
_SPARE = 1e-6   # m: added so that rounding does not drop a solid at the border of a sector
_CRACK = 1e-9   # m: walls count as this much longer, so that no ray slips through a corner


class LightRays(NamedTuple):
    """Some rays: where each begins (m, map frame), and the unit vector of its direction. All are arrays (n)."""

    x: Array
    y: Array
    to_x: Array
    to_y: Array

    def some(self, which: Array) -> "LightRays":
        """Return the rays with these indices."""
        return LightRays(*(column[which] for column in self))


class RayEnds(NamedTuple):
    """Where rays end. All are arrays (n).

    Attributes:
        distance: length of each ray (m); infinite if it meets nothing.
        normal_x, normal_y: unit vector square to the surface, to either side; 0 if it meets nothing.
        material: the `Material` of the surface; PLAIN if it meets nothing.
    """

    distance: Array
    normal_x: Array
    normal_y: Array
    material: Array


class _Meetings(NamedTuple):
    """Rays that meet something, a row for each. One ray may be in several rows. All are arrays."""

    ray: Array
    distance: Array
    normal_x: Array
    normal_y: Array
    material: Array


class _Lists(NamedTuple):
    """Several lists of indices in one array.

    Attributes:
        begin: where each list begins in `entries`, and the end of the last one.
        entries: all lists, one behind the other.
    """

    begin: Array
    entries: Array

    def pairs(self, keys: Array) -> Tuple[Array, Array]:
        """Return each entry of the list of each key, with the index of the key, as two arrays."""
        begin = self.begin[keys]
        counts = self.begin[keys + 1] - begin
        ends = counts.cumsum()
        place = np.repeat(begin - (ends - counts), counts) + np.arange(ends[-1])
        return np.repeat(np.arange(len(keys)), counts), self.entries[place]


def _lists(chosen: Array) -> _Lists:
    """Return the indices of the columns that are True in each row."""
    return _Lists(np.concatenate(([0], chosen.sum(axis=1).cumsum())), np.nonzero(chosen)[1].astype(np.int32))


class _View(NamedTuple):
    """Walls and posts that rays may meet, by the rays' keys.

    Attributes:
        walls: (5, n), see `Solids.frames`.
        posts: (3, m): x, y, radius.
        materials: of the walls, then of the posts.
        by_key: indices of walls, by key; and indices of posts, by key.
    """

    walls: Array
    posts: Array
    materials: Array
    by_key: Tuple[_Lists, _Lists]

    def meetings(self, rays: LightRays, keys: Array) -> List[_Meetings]:
        """Return where rays with these keys meet walls, and where they meet posts."""
        found = []
        walls, posts = self.by_key
        if len(walls.entries):
            found.append(self._at_walls(rays, *walls.pairs(keys)))
        if len(posts.entries):
            found.append(self._at_posts(rays, *posts.pairs(keys)))
        return found

    def _at_walls(self, rays: LightRays, ray: Array, wall: Array) -> _Meetings:
        x, y, to_x, to_y = rays.some(ray)
        start_x, start_y, along_x, along_y, length = (column[wall] for column in self.walls)
        start_x, start_y = start_x - x, start_y - y
        across = to_x * along_y - to_y * along_x
        with np.errstate(divide="ignore", invalid="ignore"):    # a ray along a wall does not meet it
            distance = (start_x * along_y - start_y * along_x) / across
            place = (start_x * to_y - start_y * to_x) / across
            meets = np.flatnonzero((distance >= 0.0) & (place >= -_CRACK) & (place <= length + _CRACK))
        return _Meetings(ray[meets], distance[meets], -along_y[meets], along_x[meets], self.materials[wall[meets]])

    def _at_posts(self, rays: LightRays, ray: Array, post: Array) -> _Meetings:
        """Inside a post the distance is 0, and the normal is along the ray."""
        x, y, to_x, to_y = rays.some(ray)
        middle_x, middle_y, radius = (column[post] for column in self.posts)
        middle_x, middle_y = middle_x - x, middle_y - y
        ahead, aside = to_x * middle_x + to_y * middle_y, to_x * middle_y - to_y * middle_x
        inside = middle_x * middle_x + middle_y * middle_y <= radius * radius
        meets = np.flatnonzero(inside | ((np.abs(aside) <= radius) & (ahead > 0.0)))
        ray, ahead, aside, radius, inside = (each[meets] for each in (ray, ahead, aside, radius, inside))
        to_x, to_y = to_x[meets], to_y[meets]
        depth = np.sqrt(np.maximum(radius * radius - aside * aside, 0.0))
        cosine, sine = np.where(inside, 1.0, depth / radius), np.where(inside, 0.0, aside / radius)
        return _Meetings(ray, np.where(inside, 0.0, ahead - depth), to_x * cosine - to_y * sine,
                         to_y * cosine + to_x * sine, self.materials[len(self.walls[0]) + post[meets]])


class RayCaster:
    """Computes where rays end in one world.

    Args:
        world: the world, with all bodies in it.
        maximum: longest ray (m).
    """

    def __init__(self, world: Surroundings, maximum: float):
        self._world, self._maximum = world, maximum
        borders = [2.0 * math.pi / SECTORS * key for key in range(SECTORS)]
        self._rights = np.array([unit(border - _SPREAD) for border in borders])
        self._lefts = np.array([unit(border + 2.0 * math.pi / SECTORS + _SPREAD) for border in borders])
        self._views = functools.lru_cache(MOST_SQUARES)(self._look)

    def cast(self, rays: LightRays, carrier: Optional[Obstacle] = None) -> RayEnds:
        """Return where rays end.

        Args:
            rays: at least one ray.
            carrier: the body from which the rays come. They do not meet it.
        """
        ends = RayEnds(np.full(len(rays.x), np.inf), np.zeros(len(rays.x)), np.zeros(len(rays.x)),
                       np.zeros(len(rays.x), dtype=int))
        sectors = np.floor(np.arctan2(rays.to_y, rays.to_x) * SECTORS_PER_RADIAN).astype(int) % SECTORS
        columns, rows = (np.floor(np.where(np.abs(along - along[0]) <= _ROOM, along[0], along) / SQUARE).astype(int)
                         for along in (rays.x, rays.y))
        for square in sorted(set(zip(columns.tolist(), rows.tolist()))):
            still = np.flatnonzero((columns == square[0]) & (rows == square[1]))
            for view in self._views(*square):
                if len(still):
                    _keep_nearest(ends, still, view.meetings(rays.some(still), sectors[still]))
                    still = still[ends.distance[still] > NEAR]
        self._meet_bodies(ends, rays, sectors, carrier)
        too_far = np.flatnonzero(~(ends.distance <= self._maximum))
        for column, nothing in zip(ends, (np.inf, 0.0, 0.0, 0)):
            column[too_far] = nothing
        return ends

    def _meet_bodies(self, ends: RayEnds, rays: LightRays, sectors: Array, carrier: Optional[Obstacle]) -> None:
        """Let rays end at bodies that are nearer than what they have met."""
        first_x, first_y = float(rays.x[0]), float(rays.y[0])
        bodies = [body for body in self._world.crowd.near(first_x, first_y, self._maximum, carrier)
                  if body is not carrier]
        if not bodies:
            return
        discs = Solids(np.empty((0, 4)), np.array([(*body.pose[:2], body.reach) for body in bodies]))
        spread = float((np.abs(rays.x - first_x) + np.abs(rays.y - first_y)).max()) + _SPARE
        ray, number = _lists(audible(discs, first_x, first_y, spread, self._rights, self._lefts)).pairs(sectors)
        x, y, to_x, to_y = rays.some(ray)
        middle_x, middle_y, reach = (column[number] for column in discs.posts.T)
        middle_x, middle_y = middle_x - x, middle_y - y
        ahead, aside = to_x * middle_x + to_y * middle_y, to_x * middle_y - to_y * middle_x
        may = np.flatnonzero((np.abs(aside) <= reach) & (ahead >= -reach) & (ahead - reach < ends.distance[ray]))
        if len(may):
            numbers, keys = np.unique(number[may], return_inverse=True)
            view = _view_of_bodies([bodies[each] for each in numbers.tolist()])
            _keep_nearest(ends, ray[may], view.meetings(rays.some(ray[may]), keys))

    def _look(self, column: int, row: int) -> List[_View]:
        """Return what rays can meet that begin in this square of floor, or not farther than `_ROOM` from it: first the
        near walls and posts, then the others. The keys are sectors.
        """
        x, y, spread = (column + 0.5) * SQUARE, (row + 0.5) * SQUARE, SQUARE * 0.7072 + _ROOM * 1.4143 + _SPARE
        solids = self._world.solids.within(x, y, self._maximum + spread)
        walls, posts = solids.distances(np.array(x), np.array(y))
        near = walls <= NEAR + spread, posts <= NEAR + spread
        parts = [solids.some(*near), solids.some(*(~each for each in near))]
        return [self._view(part, x, y, spread) for part in parts if len(part)]

    def _view(self, solids: Solids, x: float, y: float, spread: float) -> _View:
        """Return walls and posts by the sectors in which rays may meet them from near (x, y)."""
        met = audible(solids, x, y, spread, self._rights, self._lefts)
        count = len(solids.walls)
        return _View(solids.frames, solids.posts.T, solids.materials, (_lists(met[:, :count]), _lists(met[:, count:])))


def _view_of_bodies(bodies: Sequence[Obstacle]) -> _View:
    """Return the sides of bodies by the index of their body."""
    rows = [(*candidate[1:], number, body.material) for number, body in enumerate(bodies)
            for candidate in body.candidates]
    table = np.array(sorted(rows, key=lambda row: row[4] < 0.0)).T      # walls first, and posts behind them
    count = int((table[4] >= 0.0).sum())
    belongs = np.arange(len(bodies))[:, None] == table[5]
    return _View(table[:5, :count], table[:3, count:], table[6].astype(int),
                 (_lists(belongs[:, :count]), _lists(belongs[:, count:])))


def _keep_nearest(ends: RayEnds, rays: Array, found: Sequence[_Meetings]) -> None:
    """Let rays end where they meet something first, if they did not end before.

    Args:
        ends: the ends so far, which change.
        rays: index in `ends` of each ray that `found` counts.
        found: what rays meet.
    """
    if not found:
        return
    ray, *columns = (np.concatenate(each) for each in zip(*found))
    ray = rays[ray]
    order = np.lexsort((columns[0], ray))
    ray = ray[order]
    is_first = np.ones(len(ray), dtype=bool)
    is_first[1:] = ray[1:] != ray[:-1]
    chosen, ray = order[is_first], ray[is_first]
    nearer = columns[0][chosen] < ends.distance[ray]
    for end, column in zip(ends, columns):
        end[ray[nearer]] = column[chosen[nearer]]

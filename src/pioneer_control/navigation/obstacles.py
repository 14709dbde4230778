"""Remembers echoes: what the sonar heard lately that is on no map, and the walls of the map that it heard.

An echo comes from somewhere on an arc across the cone. Is a part of this arc near a wall of the map, the echo comes
from there. If not, something is there that is on no map, anywhere on the arc. It is remembered until echoes that
end farther away have passed it a few times while the robot is near, or until its time is over. Silence forgets nothing:
a slanting wall gives no echo and is still there.

A laser sees things where sonar is deaf, but only at its own height: what is lower or higher, and glass, sonar alone
tells. So each of the two forgets only what it has told itself. Where a ray of a laser ends that the map does not
explain, something is there, and a ray that ends farther away has passed it.

Places are kept in the frame of odometry, so that they stay right when the robot's pose on the map is corrected. Only
what stood still is kept longer, on the map (`standing_obstacles`).
"""

import math
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from ..floor_poses import Pose, between, compose
from ..maps.grid_map import GridMap
from ..robots import HALF_CONE
from .chassis import Chassis, distance_outside
from .frames import into, out_of, turned, wrapped_angles
from .laser_rays import rays_of
from .sonar_grid import SonarBeams
from .standing_obstacles import StandingObstacles
from .tuned import ObstacleNumbers
from .values import Scan, Sensing

Array = Any     # of numpy

_ACROSS = np.array([-0.9, -0.45, 0.0, 0.45, 0.9]) * HALF_CONE
_THROUGH = 0.7 * HALF_CONE
_FIRINGS_KEPT = 40      # with an echo
_LOOKS_KEPT = 250       # with or without: of five or ten seconds
_SLOW = 0.1     # m/s: a faster robot hears one place after another of what stands beside it
_GAP = math.radians(3.0)    # between two rays that are farther apart, something else may be in the way
_NEVER = -10 ** 9       # so often passed: no echo can make up for it


class Places(NamedTuple):
    """Places where something was heard: x and y (m), time of the last echo (s), whether the map explains it, and the
    time (s) at which the place is forgotten. `since` (s): from then on echoes came from about here, at most
    `ObstacleNumbers.same_place` from `from_x`, `from_y` (m). What walks leaves this place, and its `since` is new.
    `came`: an echo of some seconds before had passed here, so something has come. Without, it may always have been
    here, or it has come from where nothing had been heard. `came_up`: it came while the robot stood. `seen`: a laser
    tells of it, not sonar.
    """

    x: Array
    y: Array
    time: Array
    mapped: Array
    until: Array
    since: Array
    from_x: Array
    from_y: Array
    came: Array
    came_up: Array
    seen: Array

    def chosen(self, which: Array) -> "Places":
        """Return some of them: those that are true in an array of bools."""
        return Places(*(each[which] for each in self))


class _Echo(NamedTuple):
    """An echo: the pose of the transducer (m, rad; odometry), the range (m) and the time (s) of the firing."""

    x: float
    y: float
    heading: float
    range: float
    time: float


def _columns(echoes: List[_Echo]) -> Array:
    """Return the fields of echoes, each as a column with a row for each echo."""
    return np.array(echoes).reshape(-1, 5).T[:, :, np.newaxis]


class Obstacles:
    """The memory of echoes of one robot."""

    def __init__(self, chassis: Chassis, grid_map: GridMap, clearance: Array, tuned: ObstacleNumbers,
                 makes_map: bool = False):
        """Begin without echoes.

        Args:
            chassis: the robot.
            grid_map: the map.
            clearance: distance (m) of each of its cells to the nearest that is not free, see `planning.DrivableFloor`.
            tuned: the numbers of this file.
            makes_map: the robot makes this map, which is wrong by some centimetres. So it does not tell from which part
                of its arc an echo comes.
        """
        self._depth = math.inf if makes_map else tuned.explained_depth
        self._outline, self._makes_map = chassis.outline, makes_map
        self._transducers = {each.number: each for each in chassis.transducers}
        self._map, self._clearance, self._tuned = grid_map, clearance, tuned
        self._standing = StandingObstacles(tuned)
        self._before: Optional[Sensing] = None
        self._slow = True
        self._fired: Dict[int, float] = {}
        self._free = _columns([])       # of the last echoes
        self._looks = _columns([])      # of the last firings, also without an echo
        self.forget()

    def use_map(self, grid_map: GridMap, clearance: Array) -> None:
        """Go on with a newer map. For the arguments see `__init__`."""
        self._map, self._clearance = grid_map, clearance
        self._standing.forget()

    def forget(self) -> None:
        """Forget all echoes."""
        self._standing.forget()
        self._free = self._looks = _columns([])
        none = np.zeros(0)
        no = np.zeros(0, dtype=bool)
        self._places = Places(none, none, none, no, none, none, none, none, no, no, no)
        self._passed = np.zeros(0, dtype=int)

    def live(self, since: float) -> List[int]:
        """Return the numbers of the transducers that have fired at or after a time (s)."""
        return [number for number, time in self._fired.items() if time >= since]

    def heard(self) -> Places:
        """Return what is remembered, in the frame of odometry."""
        return self._places

    def unmapped(self, pose: Pose, stands: bool = False) -> Array:
        """Return the places (m, map frame) of what is remembered and on no map, as an array (number, 2).

        Args:
            pose: where the robot is (map frame).
            stands: only what has proved to stand still.
        """
        assert self._before is not None
        places = self._places.chosen(~self._places.mapped)
        if stands:
            places = places.chosen(places.time - places.since >= self._tuned.proves_still)
        return np.column_stack(out_of(pose, *into(self._before.odometry, places.x, places.y)))

    def note_standing(self, pose: Pose, now: float) -> Array:
        """Note what stands still, and forget what echoes have passed since. Return what stood away from the robot.

        Args:
            pose: where the robot is (map frame).
            now: the time (s).

        Returns:
            Places, as an array (number, 2) of x and y (m, map frame).
        """
        assert self._before is not None
        standing = self._standing
        standing.keep(~self._seen_free(*out_of(self._before.odometry, *into(pose, *standing.places.T))))
        standing.remember(self.unmapped(pose, stands=True), pose, now)
        return standing.places

    def looks(self) -> SonarBeams:
        """Return the last firings, also without an echo, in the frame of odometry."""
        return SonarBeams(*self._looks[:4, :, 0])

    def add(self, places_x: Array, places_y: Array, time: float) -> None:
        """Remember places (m, frame of odometry) of which the robot knows by something else than an echo.

        Sonar does not hear what is there, so echoes from behind it do not forget it.
        """
        self._put(places_x, places_y, np.full(len(places_x), time), np.zeros(len(places_x), dtype=bool),
                  np.full(len(places_x), time + self._tuned.felt), np.full(len(places_x), self._tuned.same_place),
                  np.zeros(len(places_x), dtype=bool))
        self._passed[len(self._passed) - len(places_x):] = _NEVER

    def explained(self, x: Array, y: Array, far: Array) -> Array:
        """Return which places (m, map frame) are so near to a wall of the map that an echo from this far (m) is its."""
        return self._explains(self._room(x, y), far)

    def _explains(self, room: Array, far: Array) -> Array:
        """Return whether the map explains echoes from this far (m) at places that are so far (m) from its walls."""
        return room < self._tuned.explained + self._tuned.explained_share * far

    def _room(self, x: Array, y: Array) -> Array:
        """Return how far (m) places (m, map frame) are from the nearest cell of the map that is not free."""
        row, column = self._map.cell(x, y)
        rows, columns = self._clearance.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return np.where(inside, self._clearance[np.where(inside, row, 0), np.where(inside, column, 0)], 0.0)

    def hear(self, sensing: Sensing, where: Optional[Pose]) -> None:
        """Take in the firings of one packet.

        Args:
            sensing: what the robot sensed.
            where: its pose on the map at that time; None when it is not sure. Then the map explains nothing, and what
                stood on it is forgotten: the robot may have been elsewhere.
        """
        self._keep_what_is_beside(sensing)
        self._keep(sensing.time < self._places.until)
        if where is None:
            self._standing.forget()
        heard: List[_Echo] = []
        silent: List[_Echo] = []
        for firing in sensing.firings:
            transducer = self._transducers.get(firing.number)
            if transducer is not None:
                self._fired[firing.number] = firing.time
                if firing.range > 0.0:
                    eye = compose(self._pose_at(sensing, firing.time),
                                  Pose(transducer.x, transducer.y, transducer.heading))
                    (heard if math.isfinite(firing.range) else silent).append(_Echo(*eye, firing.range, firing.time))
        before, self._before = self._before, sensing
        self._slow = before is None or math.hypot(
            sensing.odometry.x - before.odometry.x, sensing.odometry.y - before.odometry.y) < _SLOW * (
                sensing.time - before.time)
        self._looks = np.concatenate((self._looks, _columns(heard + silent)), axis=1)[:, -_LOOKS_KEPT:]
        if heard:
            echoes = _columns(heard)
            self._see_through(echoes)
            self._free = np.concatenate((self._free, echoes), axis=1)[:, -_FIRINGS_KEPT:]
            near = echoes[3, :, 0] < self._tuned.heard_to
            if near.any():
                self._hear_near(sensing, echoes[:, near], where)
        if sensing.scan is not None and not self._makes_map:
            self._see(sensing.scan, sensing, where)

    def _hear_near(self, sensing: Sensing, echoes: Array, where: Optional[Pose]) -> None:
        eye_x, eye_y, heading, far, time = echoes
        x, y = eye_x + far * np.cos(heading + _ACROSS), eye_y + far * np.sin(heading + _ACROSS)
        explained = np.zeros(x.shape, dtype=bool)
        if where is not None:
            room = self._room(*out_of(where, *into(sensing.odometry, x, y)))
            # A wall returns the echo from where the arc is nearest to it.
            returned = room < room.min(axis=1, keepdims=True) + self._depth
            explained = self._explains(room, far) & returned
        by_map = explained.any(axis=1, keepdims=True)
        kept = np.where(np.abs(_ACROSS) < 0.4 * HALF_CONE, self._tuned.kept, self._tuned.kept_aside)
        until = time + np.where(by_map, self._tuned.kept_known, kept)
        which = explained
        if not by_map.all():
            left = ~self._seen_free(x, y)
            which = np.where(by_map, explained, left | ~left.any(axis=1, keepdims=True))
        same = self._tuned.same_place
        if self._slow:
            same = np.minimum(same, self._tuned.same_place_near + self._tuned.same_place_share * far)
        came = self._was_free(eye_x + far * np.cos(heading), eye_y + far * np.sin(heading))
        self._put(x[which], y[which], np.broadcast_to(time, x.shape)[which], explained[which], until[which],
                  np.broadcast_to(same, x.shape)[which], np.broadcast_to(came, x.shape)[which])

    def _see(self, scan: Scan, sensing: Sensing, where: Optional[Pose]) -> None:
        """Take in a scan: forget what its rays pass, and remember where they end that the map does not explain."""
        rays, tuned = rays_of(scan, scan.odometry), self._tuned
        x, y = rays.x + rays.range * np.cos(rays.heading), rays.y + rays.range * np.sin(rays.heading)
        eye = compose(scan.odometry, scan.mount)
        self._see_past(rays.heading, rays.range, eye)
        # One ray alone, between the edge of a thing and what is behind it, measures neither.
        beside = np.hypot(np.diff(x), np.diff(y)) < tuned.seen_beside
        near = (rays.range < tuned.heard_to) & (np.append(beside, False) | np.append(False, beside))
        near &= distance_outside(self._outline, *into(scan.odometry, x, y)) > tuned.seen_itself
        if where is not None:
            near &= ~self._on_a_wall(x, y, sensing.odometry, where)
            told = self._places.seen.copy()
            if told.any():      # by a robot that was not sure where it was
                told[told] = self._on_a_wall(self._places.x[told], self._places.y[told], sensing.odometry, where)
                self._keep(~told)
        _, one = np.unique(self._cell_of(x[near], y[near]), return_index=True)
        x, y, far = x[near][one], y[near][one], rays.range[near][one]
        if not len(x):
            return
        same = np.full(len(x), tuned.same_place)
        if self._slow:
            same = np.minimum(same, tuned.same_place_near + tuned.same_place_share * far)
        self._put(x, y, np.full(len(x), scan.time), np.zeros(len(x), dtype=bool),
                  np.full(len(x), scan.time + tuned.kept), same, self._was_free(x, y), seen=True)

    def _on_a_wall(self, x: Array, y: Array, odometry: Pose, where: Pose) -> Array:
        """Return which places (m, odometry) the map explains, for a robot with a pose by odometry, and one on the map.
        """
        x, y = into(odometry, x, y)
        return self._explains(self._room(*out_of(where, x, y)), np.hypot(x, y))

    def _see_past(self, heading: Array, far: Array, eye: Pose) -> None:
        """Note which places that a laser told are passed by rays of a scan; forget those that were passed often enough.

        Args:
            heading: where each ray looked (rad), rising or falling.
            far: where it ended (m).
            eye: where the laser was (m, odometry).
        """
        told = self._places.seen
        if len(heading) < 2 or not told.any():
            return
        x, y = self._places.x[told] - eye.x, self._places.y[told] - eye.y
        order = 1 if heading[-1] > heading[0] else -1
        middle = (heading[0] + heading[-1]) / 2.0
        bearing = middle + wrapped_angles(np.arctan2(y, x) - middle)
        after = np.searchsorted(heading[::order], bearing).clip(1, len(heading) - 1)
        right, left = heading[::order][after - 1], heading[::order][after]
        nearest = np.minimum(far[::order][after - 1], far[::order][after])
        passed = (bearing >= right) & (bearing <= left) & (left - right < _GAP) & (
            np.hypot(x, y) < np.minimum(nearest - self._tuned.seen_through, self._tuned.heard_to))
        if passed.any():
            self._passed = self._passed.copy()
            self._passed[told] += passed
            self._keep(self._passed < self._tuned.passes)

    def _was_free(self, x: Array, y: Array) -> Array:
        """Return which places (m, odometry) echoes of the last seconds have passed. Silence tells nothing."""
        echoes = self._looks[:, np.isfinite(self._looks[3, :, 0])]
        return self._passing(echoes, x.ravel(), y.ravel()).any(axis=0).reshape(x.shape)

    def _seen_free(self, x: Array, y: Array) -> Array:
        """Return which places (m, odometry) the last echoes have passed: nothing is there."""
        return self._passing(self._free, x.ravel(), y.ravel()).any(axis=0).reshape(x.shape)

    def _passing(self, echoes: Array, x: Array, y: Array) -> Array:
        """Return which echoes have passed which places: an array of bools with a row for each echo.

        An echo says nothing of a place farther away than `heard_to`: a smooth wall may stand between.
        """
        eye_x, eye_y, heading, far, _ = echoes
        along, aside = turned(x - eye_x, y - eye_y, -heading)
        return (np.abs(aside) < along * math.tan(_THROUGH)) & (
            np.hypot(along, aside) < np.minimum(far - self._tuned.seen_through, self._tuned.heard_to))

    def _put(self, x: Array, y: Array, time: Array, mapped: Array, until: Array, same: Array, came: Array,
             seen: bool = False) -> None:
        old = self._places
        again = (old.seen == seen) & (self._cell_of(old.x, old.y)[:, np.newaxis] == self._cell_of(x, y)).any(axis=1)
        since, from_x, from_y, came, came_up = self._stands_since(x, y, time, came, same)
        new = Places(x, y, time, mapped, until, since, from_x, from_y, came, came_up, np.full(len(x), seen))
        self._places = Places(*(np.append(*columns) for columns in zip(old.chosen(~again), new)))
        self._passed = np.append(self._passed[~again], np.zeros(len(x), dtype=int))

    def _cell_of(self, x: Array, y: Array) -> Array:
        """Return a number of the cell of each place, the same for places of one cell."""
        return np.floor(x / self._tuned.cell) * 1e7 + np.floor(y / self._tuned.cell)

    def _stands_since(self, x: Array, y: Array, time: Array, came: Array, near: Array) -> Tuple[Array, ...]:
        """Return all from `since` to `came_up` of new places: of the oldest place that each may still be.

        A place that is none of the old ones has its own. `near`: so far (m) each may be from where that began.
        """
        old = self._places.chosen(time.max() - self._places.time < self._tuned.proves_still)
        if not len(old.x):
            return time, x, y, came, came & self._slow
        same = np.hypot(x[:, np.newaxis] - old.from_x, y[:, np.newaxis] - old.from_y) < near[:, np.newaxis]
        since = np.where(same, old.since, np.inf)
        oldest, row = since.argmin(axis=1), np.arange(len(x))
        known = same.any(axis=1)
        return (np.where(known, since[row, oldest], time), np.where(known, old.from_x[oldest], x),
                np.where(known, old.from_y[oldest], y), np.where(known, old.came[oldest], came),
                np.where(known, old.came_up[oldest], came & self._slow))

    def _see_through(self, echoes: Array) -> None:
        """Note which places echoes from farther away have passed, and forget those that were passed often enough."""
        passed = self._passing(echoes, self._places.x, self._places.y).sum(axis=0) * ~self._places.seen
        if passed.any():
            self._passed = self._passed + passed
            self._keep(self._passed < self._tuned.passes)

    def _keep_what_is_beside(self, sensing: Sensing) -> None:
        """What is beside a robot that stands ages no more, for `kept_beside` at most.

        It may be where no transducer looks, and the robot would turn or back into it. The ends of an arc, which are
        kept for less than `kept`, do age: there it rather is not.
        """
        places, before, tuned = self._places, self._before, self._tuned
        if before is None or not self._slow:
            return
        beside = ~places.mapped & (places.until - places.time >= tuned.kept) & (
            np.hypot(places.x - sensing.odometry.x, places.y - sensing.odometry.y) < tuned.away)
        longer = np.minimum(places.until + (sensing.time - before.time), places.time + tuned.kept_beside)
        self._places = places._replace(until=np.where(beside, np.maximum(places.until, longer), places.until))

    def _keep(self, which: Array) -> None:
        if not which.all():
            self._places, self._passed = self._places.chosen(which), self._passed[which]

    def _pose_at(self, sensing: Sensing, time: float) -> Pose:
        """Return the pose (odometry) at the time (s) of a firing, between the last two packets."""
        before = self._before
        if before is None or not before.time < sensing.time:
            return sensing.odometry
        share = min(1.0, max(0.0, (time - before.time) / (sensing.time - before.time)))
        return between(before.odometry, sensing.odometry, share)


def edge_cells(clearance: Array) -> Array:
    """Return which cells are not free and touch a free one: the faces of walls, as an array of bools.

    For the argument see `Obstacles`.
    """
    free = np.pad(clearance > 0.0, 1)
    beside = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
    return beside & (clearance <= 0.0)


def cells_near(grid_map: GridMap, edges: Array, pose: Pose, reach: float, half: float) -> Tuple[Array, Array]:
    """Return the faces of walls near a pose (map frame), as points (m, robot's frame).

    Args:
        grid_map: the map.
        edges: which of its cells are such faces.
        pose: the pose.
        reach: about so near (m).
        half: a wall may be so far (m) from the middle of its cell, to all four sides. The point is the nearest one.
    """
    (low_row, low_column), (high_row, high_column) = (
        [int(each) for each in grid_map.cell(pose.x + side * reach, pose.y + side * reach)] for side in (-1.0, 1.0))
    low_row, low_column = max(0, low_row), max(0, low_column)
    window = edges[low_row:max(0, high_row + 1), low_column:max(0, high_column + 1)]
    row, column = np.divmod(np.flatnonzero(window), max(1, window.shape[1]))    # far quicker than np.nonzero
    x, y = grid_map.middle(row + low_row, column + low_column)
    return into(pose, x + np.clip(pose.x - x, -half, half), y + np.clip(pose.y - y, -half, half))

"""Remembers echoes: what the sonar heard lately that is on no map, and the walls of the map that it heard.

An echo comes from somewhere on an arc across the cone. Is a part of this arc near a wall of the map, the echo comes
from there. If not, something is there that is on no map, anywhere on the arc. It is remembered until echoes from
farther away have passed it a few times, or until its time is over. Silence forgets nothing: a slanting wall gives no
echo and is still there.

Places are kept in the frame of odometry, so that they stay right when the robot's pose on the map is corrected.
"""

import collections
import math
from typing import Any, Deque, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from ..floor_poses import Pose, compose, wrapped
from ..maps.grid_map import GridMap
from ..robots import HALF_CONE
from .chassis import Chassis
from .frames import into, out_of
from .tuned import ObstacleNumbers
from .values import Firing, Sensing

Array = Any     # of numpy

_ACROSS = np.array([-0.9, -0.45, 0.0, 0.45, 0.9]) * HALF_CONE
_THROUGH = 0.7 * HALF_CONE
_FIRINGS_KEPT = 40
_NEVER = -10 ** 9       # so often passed: no echo can make up for it


class Places(NamedTuple):
    """Places where something was heard: x and y (m), time of the last echo (s), whether the map explains it, and the
    time (s) at which the place is forgotten. `since` (s): from then on echoes came from about here, at most
    `ObstacleNumbers.same_place` from `from_x`, `from_y` (m). What walks leaves this place, and its `since` is new.
    """

    x: Array
    y: Array
    time: Array
    mapped: Array
    until: Array
    since: Array
    from_x: Array
    from_y: Array

    def chosen(self, which: Array) -> "Places":
        """Return some of them: those that are true in an array of bools."""
        return Places(*(each[which] for each in self))


class Obstacles:
    """The memory of echoes of one robot."""

    def __init__(self, chassis: Chassis, grid_map: GridMap, clearance: Array, tuned: ObstacleNumbers):
        """Begin without echoes.

        Args:
            chassis: the robot.
            grid_map: the map.
            clearance: distance (m) of each of its cells to the nearest that is not free, see `planning.DrivableFloor`.
            tuned: the numbers of this file.
        """
        self._transducers = {each.number: each for each in chassis.transducers}
        self._map, self._clearance, self._tuned = grid_map, clearance, tuned
        self._before: Optional[Sensing] = None
        self._fired: Dict[int, float] = {}
        self._free: Deque[Tuple[Pose, float]] = collections.deque(maxlen=_FIRINGS_KEPT)  # eye, and how far it saw
        self.forget()

    def use_map(self, grid_map: GridMap, clearance: Array) -> None:
        """Go on with a newer map. For the arguments see the class."""
        self._map, self._clearance = grid_map, clearance

    def forget(self) -> None:
        """Forget all echoes."""
        self._free.clear()
        none = np.zeros(0)
        self._places = Places(none, none, none, np.zeros(0, dtype=bool), none, none, none, none)
        self._passed = np.zeros(0, dtype=int)

    def live(self, since: float) -> List[int]:
        """Return the numbers of the transducers that have fired at or after a time (s)."""
        return [number for number, time in self._fired.items() if time >= since]

    def heard(self) -> Places:
        """Return what is remembered, in the frame of odometry."""
        return self._places

    def add(self, places_x: Array, places_y: Array, time: float) -> None:
        """Remember places (m, frame of odometry) of which the robot knows by something else than an echo.

        Sonar does not hear what is there, so echoes from behind it do not forget it.
        """
        self._put(places_x, places_y, time, np.zeros(len(places_x), dtype=bool),
                  np.full(len(places_x), time + self._tuned.felt))
        self._passed[len(self._passed) - len(places_x):] = _NEVER

    def hear(self, sensing: Sensing, where: Optional[Pose]) -> None:
        """Take in the firings of one packet.

        Args:
            sensing: what the robot sensed.
            where: its pose on the map at that time; None when it is not sure. Then the map explains nothing.
        """
        self._drop_old(sensing.time)
        for firing in sensing.firings:
            transducer = self._transducers.get(firing.number)
            if transducer is not None:
                self._fired[firing.number] = firing.time
                at = self._pose_at(sensing, firing.time)
                eye = compose(at, Pose(transducer.x, transducer.y, transducer.heading))
                if math.isfinite(firing.range) and firing.range > 0.0:
                    self._see_through(eye, firing.range)
                    self._free.append((eye, firing.range))
                    if firing.range < self._tuned.heard_to:
                        self._hear_one(sensing, firing, eye, where)
        self._before = sensing

    def _hear_one(self, sensing: Sensing, firing: Firing, eye: Pose, where: Optional[Pose]) -> None:
        x, y = out_of(eye, firing.range * np.cos(_ACROSS), firing.range * np.sin(_ACROSS))
        explained = np.zeros(len(x), dtype=bool)
        until = firing.time + np.where(np.abs(_ACROSS) < 0.4 * HALF_CONE, self._tuned.kept, self._tuned.kept_aside)
        if where is not None:
            near = self._tuned.explained + self._tuned.explained_share * firing.range
            on_map = out_of(where, *into(sensing.odometry, x, y))
            row, column = self._map.cell(*on_map)
            rows, columns = self._clearance.shape
            inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
            room = np.where(inside, self._clearance[np.where(inside, row, 0), np.where(inside, column, 0)], 0.0)
            explained = room < near
        if explained.any():
            x, y, explained = x[explained], y[explained], explained[explained]
            until = np.full(len(x), firing.time + self._tuned.kept_known)
        else:
            left = ~self._seen_free(x, y)
            if left.any():
                x, y, until, explained = x[left], y[left], until[left], explained[left]
        self._put(x, y, firing.time, explained, until)

    def _seen_free(self, x: Array, y: Array) -> Array:
        """Return which places the last echoes have passed: the part of an arc that is left has the obstacle."""
        eye_x, eye_y, heading, seen = np.array([(*eye, far) for eye, far in self._free]).T[:, :, np.newaxis]
        along = (x - eye_x) * np.cos(heading) + (y - eye_y) * np.sin(heading)
        aside = np.abs((y - eye_y) * np.cos(heading) - (x - eye_x) * np.sin(heading))
        passed = (along > 0) & (aside < along * math.tan(_THROUGH)) & (
            np.hypot(x - eye_x, y - eye_y) < seen - self._tuned.seen_through)
        return np.asarray(passed.any(axis=0))

    def _put(self, x: Array, y: Array, time: float, mapped: Array, until: Array) -> None:
        cell = self._tuned.cell
        known = set(zip(np.floor(x / cell).astype(int).tolist(), np.floor(y / cell).astype(int).tolist()))
        old = self._places
        again = np.array([pair in known for pair in zip(np.floor(old.x / cell).astype(int).tolist(),
                                                        np.floor(old.y / cell).astype(int).tolist())], dtype=bool)
        new = Places(x, y, np.full(len(x), time), mapped, until, *self._stands_since(x, y, time))
        self._places = Places(*(np.append(*columns) for columns in zip(old.chosen(~again), new)))
        self._passed = np.append(self._passed[~again], np.zeros(len(x), dtype=int))

    def _stands_since(self, x: Array, y: Array, time: float) -> Tuple[Array, Array, Array]:
        """Return `since`, `from_x` and `from_y` of new places: those of the oldest place that each may still be."""
        old = self._places.chosen(time - self._places.time < self._tuned.proves_still)
        if not len(old.x):
            return np.full(len(x), time), x, y
        same = np.hypot(x[:, np.newaxis] - old.from_x, y[:, np.newaxis] - old.from_y) < self._tuned.same_place
        since = np.where(same, old.since, np.inf)
        oldest, row = since.argmin(axis=1), np.arange(len(x))
        known = same.any(axis=1)
        return (np.where(known, since[row, oldest], time), np.where(known, old.from_x[oldest], x),
                np.where(known, old.from_y[oldest], y))

    def _see_through(self, eye: Pose, heard_range: float) -> None:
        """Note which places an echo from farther away has passed, and forget those that were passed often enough."""
        x, y = into(eye, self._places.x, self._places.y)
        passed = (x > 0) & (np.hypot(x, y) < heard_range - self._tuned.seen_through)
        passed &= np.abs(y) < x * math.tan(_THROUGH)
        if passed.any():
            self._passed = self._passed + passed
            self._keep(self._passed < self._tuned.passes)

    def _drop_old(self, now: float) -> None:
        self._keep(now < self._places.until)

    def _keep(self, which: Array) -> None:
        if not which.all():
            self._places, self._passed = self._places.chosen(which), self._passed[which]

    def _pose_at(self, sensing: Sensing, time: float) -> Pose:
        """Return the pose (odometry) at the time (s) of a firing, between the last two packets."""
        before = self._before
        if before is None or not before.time < sensing.time:
            return sensing.odometry
        share = min(1.0, max(0.0, (time - before.time) / (sensing.time - before.time)))
        start, end = before.odometry, sensing.odometry
        return Pose(start.x + (end.x - start.x) * share, start.y + (end.y - start.y) * share,
                    wrapped(start.heading + wrapped(end.heading - start.heading) * share))


def edge_cells(grid_map: GridMap, clearance: Array) -> Array:
    """Return which cells of a map are not free and touch a free one: the faces of walls, as an array of bools."""
    free = np.pad(clearance > 0.0, 1)
    beside = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
    return beside & (clearance <= 0.0)


def cells_near(grid_map: GridMap, edges: Array, pose: Pose, reach: float) -> Tuple[Array, Array]:
    """Return the middles (m, robot's frame) of the faces of walls within about `reach` (m) of a pose (map frame)."""
    (low_row, low_column), (high_row, high_column) = (
        [int(each) for each in grid_map.cell(pose.x + side * reach, pose.y + side * reach)] for side in (-1.0, 1.0))
    low_row, low_column = max(0, low_row), max(0, low_column)
    row, column = np.nonzero(edges[low_row:max(0, high_row + 1), low_column:max(0, high_column + 1)])
    return into(pose, *grid_map.middle(row + low_row, column + low_column))

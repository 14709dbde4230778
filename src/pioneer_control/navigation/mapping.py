"""Makes a map while a robot with sonar drives, by odometry and by the map itself: `Mapper`.

The path is cut into stretches of a metre. When one ends, it is looked for on the map that the others made
(`scan_match`); the straight walls beside it tell its heading, where walls are square (`wall_directions`). What was
found, and what odometry measured, are the measurements of a `pose_graph`; its solution moves all stretches, also old
ones, and tells the lasting errors of the wheels. Stretches that moved are drawn anew (`sonar_grid`). All are looked for
again and again, in turn: the first were found on a map that was still thin, and this also closes loops. The work is
done a costly step at each packet, so that none takes long. There is no chance in it: a map made twice of the same data
is the same.
"""

import math
from typing import Any, Iterator, List, Optional, Sequence

import numpy as np

from ..floor_poses import Pose, compose, relative, wrapped
from ..maps import GridMap
from ..robots import Transducer
from .frames import wrapped_angles
from .pose_graph import Between, MeasuredBy, PoseGraph
from .scan_match import Match, match, wall_points
from .sonar_grid import SonarBeams, SonarGrid, Votes
from .stretch import Ears, Stretch
from .tuned import MapNumbers, MapperNumbers, MatchNumbers, WallNumbers
from .values import Sensing
from .wall_directions import wall_directions
from .wheel_motion import WheelBias
from .wheel_motion import path as wheel_path

Array = Any     # of numpy

_BIAS_STEP = 1e-4
_MARGIN = 1.0
"""Unknown floor (m) round the map, so that a robot may be sent there."""
_DREW = 0.05
"""A stretch that has fewer votes for a wall did not draw it."""
_EDGE = 0.8
"""From this share of the window on, a stretch was found at its edge."""
_REDRAWN = 3
"""Stretches that are drawn anew in one packet: each takes a tenth of what finding one takes."""
_ROUNDS = 3
"""Steps in which the graph is solved after a stretch was found."""
_FEWEST_HITS = 3
"""Fewer readings do not tie a stretch to another."""


class _Drawn:
    """A stretch, and how it is drawn at present."""

    def __init__(self, stretch: Stretch) -> None:
        self.stretch = stretch
        self.votes: List[Votes] = []
        self.count = 0
        self.pose = Pose(0.0, 0.0, 0.0)
        self.beams: Optional[SonarBeams] = None


class Mapper:
    """Map and pose of a robot that drives.

    Args:
        transducers: the sonar of the robot.
        map_numbers, match_numbers, wall_numbers, numbers: what was tuned.
        pose: where the robot is at the first packet (map frame).
        corrects: whether the map may correct the odometry.

    Attributes:
        pose: present pose (map frame).
    """

    def __init__(self, transducers: Sequence[Transducer], map_numbers: MapNumbers = MapNumbers(),
                 match_numbers: MatchNumbers = MatchNumbers(), wall_numbers: WallNumbers = WallNumbers(),
                 numbers: MapperNumbers = MapperNumbers(), pose: Pose = Pose(0.0, 0.0, 0.0),
                 corrects: bool = True) -> None:
        self.pose = pose
        self._numbers, self._match_numbers, self._wall_numbers = numbers, match_numbers, wall_numbers
        self._corrects = corrects
        self._grid = SonarGrid(map_numbers)
        spread = numbers.distance_bias, numbers.turning_bias, numbers.veer_bias, numbers.size_error
        self._graph = PoseGraph(pose, spread, numbers.doubt, wall_numbers)
        self._ears = Ears(transducers)
        self._drawn: List[_Drawn] = []
        self._odometry: Optional[Pose] = None
        self._way = self._turned = 0.0
        self._next = 0
        self._ended: List[int] = []
        self._work = self._worker()

    def update(self, sensing: Sensing, rests: bool = False) -> Pose:
        """Go on with one packet, and return the pose (map frame) at its time.

        Args:
            sensing: the packet.
            rests: whether the map is corrected later: the caller has other work in this packet.
        """
        before, self._odometry = self._odometry, sensing.odometry
        if before is None:
            self._drawn.append(_Drawn(Stretch(sensing.time, self._ears)))
            self._drawn[0].pose = self.pose
            return self.pose
        present = self._drawn[-1]
        stretch, numbers = present.stretch, self._numbers
        stretch.add(before, sensing, self._way + stretch.way, self._turned + stretch.turned)
        # Where a stretch lies is not known until the one before it was found.
        if stretch.heard_count - present.count >= numbers.batch and not self._ended:
            self._draw_on()
        if stretch.way + numbers.turn_counts * stretch.turned > numbers.stretch:
            self._end_stretch(sensing.time)
        if not rests:
            next(self._work)
        last = len(self._drawn) - 1
        self.pose = compose(self._graph.pose(last), self._drawn[last].stretch.end(self._graph.bias))
        return self.pose

    @property
    def bias(self) -> WheelBias:
        """The lasting errors of the wheels, as far as they are known."""
        return self._graph.bias

    def path(self) -> Array:
        """Return where the robot was at each packet, by all that is known now: array (n, 3) of x, y (m), heading (rad;
        map frame).
        """
        if not self._drawn:
            return np.array([self.pose])
        steps = [each.stretch.steps for each in self._drawn]
        counts = np.array([len(each) + 1 for each in steps])
        number = np.repeat(np.arange(len(steps)), counts)
        begin = np.cumsum(counts - 1) - (counts - 1)
        # All at once along the wheels' path; a stretch's poses are those relative to the one at its begin.
        way = wheel_path(np.concatenate(steps), self._graph.bias)
        off = way[np.arange(len(number)) - number] - way[begin[number]]
        turned = self._graph.poses[number, 2] - way[begin[number], 2]
        cosine, sine = np.cos(turned), np.sin(turned)
        poses = self._graph.poses[number] + np.stack((
            off[:, 0] * cosine - off[:, 1] * sine, off[:, 0] * sine + off[:, 1] * cosine, off[:, 2]), axis=1)
        return np.delete(poses, np.cumsum(counts)[:-1] - 1, axis=0)    # one ends where the next one begins

    def grid_map(self) -> GridMap:
        """Return the map as it is now, with unknown cells round it and round the robot. Nothing changes by asking."""
        grid = self._grid.copy()
        for votes in self._not_drawn():
            grid.add(votes)
        return grid.grid_map(self.pose.x, self.pose.y, _MARGIN)

    def finish(self) -> None:
        """Look for the stretches that ended last, and draw all where they are known to lie now."""
        for number in self._ended:
            for _ in self._look(number, 1.0):
                pass
        for number in range(len(self._drawn)):
            self._redraw(number)
        self._ended, self._work = [], self._worker()

    def _draw_on(self) -> None:
        """Draw what the present stretch has heard and was not yet drawn."""
        present = self._drawn[-1]
        for votes in self._not_drawn():
            self._grid.add(votes)
            present.votes.append(votes)
        present.count = present.stretch.heard_count

    def _not_drawn(self) -> List[Votes]:
        """Return the votes of what was heard since the last drawing, if there are any."""
        present = self._drawn[-1] if self._drawn else None
        if present is None or present.stretch.heard_count <= present.count:
            return []
        return [self._grid.votes(present.stretch.beams(self._graph.bias, present.count).moved(*present.pose))]

    def _end_stretch(self, time: float) -> None:
        """End the present stretch, and begin the next one. The one that ended will be looked for on the map."""
        number = len(self._drawn) - 1
        stretch = self._drawn[number].stretch
        self._way += stretch.way
        self._turned += stretch.turned
        self._graph.add_node(compose(self._graph.pose(number), stretch.end(self._graph.bias)))
        self._graph.add(self._by_odometry(number))
        self._drawn.append(_Drawn(Stretch(time, self._ears)))
        self._drawn[-1].pose = self._graph.pose(number + 1)
        self._ended.append(number)

    def _worker(self) -> Iterator[None]:
        """Correct the map without end, a costly step at each packet.

        Stretches that ended come first; then those that moved since they were drawn, the farthest one first; then each
        in turn is looked for again: all that was drawn meanwhile tells better where it lies.
        """
        while True:
            worst = self._moved()
            if self._ended:
                yield from self._look(self._ended[0], 1.0)
                self._ended.pop(0)
                self._drawn[-1].pose = self._graph.pose(len(self._drawn) - 1)
            elif worst is not None:
                for _ in range(_REDRAWN):
                    self._redraw(worst)
                    worst = self._moved()
                    if worst is None:
                        break
                yield
            elif len(self._drawn) > 1:
                self._next = (self._next + 1) % (len(self._drawn) - 1)
                yield from self._look(self._next, self._numbers.again)
            else:
                yield

    def _moved(self) -> Optional[int]:
        """Return the number of the stretch that moved most since it was drawn, if it moved far enough."""
        off = np.abs(self._graph.poses - np.array([each.pose for each in self._drawn]))
        off[:, 2] = np.abs(wrapped_angles(off[:, 2]))
        moved = np.hypot(off[:, 0], off[:, 1]) / self._numbers.redrawn + off[:, 2] / self._numbers.redrawn_turn
        worst = int(moved.argmax())
        return worst if moved[worst] > 1.0 else None

    def _by_odometry(self, number: int) -> Between:
        """Return what odometry measured from the begin of a stretch to its end."""
        stretch, numbers = self._drawn[number].stretch, self._numbers
        plain = np.array(stretch.end(WheelBias()))
        columns = []
        for bias in WheelBias(turning=_BIAS_STEP), WheelBias(veer=_BIAS_STEP):
            change = np.array(stretch.end(bias)) - plain
            change[2] = math.remainder(change[2], 2.0 * math.pi)
            columns.append(change / _BIAS_STEP)
        root_way = math.sqrt(stretch.way + 0.01)
        turn = numbers.roll_turn * root_way + numbers.turn_turn * stretch.turned + 0.001
        along = numbers.roll * root_way + 0.002
        aside = along + 0.5 * turn * stretch.way
        return Between(number, number + 1, Pose(*plain), np.diag((1.0 / along, 1.0 / aside, 1.0 / turn)),
                       MeasuredBy.WHEELS, np.array(columns).T)

    def _look(self, number: int, share: float) -> Iterator[None]:
        """Find a stretch on what the others drew, let the graph know, and draw it there: a costly step at a time.

        Args:
            number: of the stretch.
            share: of the window in which it is looked for. When it is found at the edge, it is looked for again in the
                whole window round that place: it may be farther away.
        """
        numbers = self._numbers
        beams = self._readings(number)
        if self._corrects and len(beams.x) >= numbers.least_count:
            pose, reach, turn = self._graph.pose(number), share * numbers.window, share * numbers.window_turn
            found = self._match(number, beams, pose, reach, turn)
            yield
            if found and _at_edge(pose, found.pose, reach, turn):
                found = self._match(number, beams, found.pose, numbers.window, numbers.window_turn) or found
                yield
            self._graph.set_walls(number, wall_directions(self._heard_lately(number), self._wall_numbers))
            if found:
                self._graph.untie(number)
                self._tie(number, found, number in self._ended)
                yield
                for _ in range(_ROUNDS):
                    self._graph.solve(1)
                    yield
        self._redraw(number)
        yield

    def _readings(self, number: int) -> SonarBeams:
        """Return the echoes by which a stretch is found, relative to its begin."""
        beams = self._drawn[number].stretch.beams(self._graph.bias)
        index = np.nonzero(beams.range < self._match_numbers.reach)[0]
        index = index[::max(1, math.ceil(len(index) / self._numbers.most_readings))]
        return beams.chosen(index)

    def _heard_lately(self, number: int) -> SonarBeams:
        """Return what a stretch heard, and those before it, relative to its begin by the wheels.

        A robot with few transducers, or one that turns often, hears too little of a wall in one stretch to tell its
        direction.
        """
        pose, heard = Pose(0.0, 0.0, 0.0), []
        for each in range(number, max(-1, number - int(self._wall_numbers.stretches)), -1):
            stretch = self._drawn[each].stretch
            if each < number:
                pose = compose(pose, relative(stretch.end(self._graph.bias), Pose(0.0, 0.0, 0.0)))
            heard.append(stretch.beams(self._graph.bias).moved(*pose))
        return SonarBeams(*map(np.concatenate, zip(*heard)))

    def _match(self, number: int, beams: SonarBeams, pose: Pose, reach: float, turn: float) -> Optional[Match]:
        """Look for the readings of a stretch near a pose on what the others drew; None where too little is known."""
        margin = reach + self._match_numbers.reach + 0.3
        at = beams.moved(*pose)
        odds, row, column = self._grid.window((at.x.min() - margin, at.y.min() - margin),
                                              (at.x.max() + margin, at.y.max() + margin), self._drawn[number].votes)
        walls = wall_points(odds, row, column, self._grid.numbers.resolution, self._match_numbers.wall)
        found = match(walls, beams, pose, reach, turn, self._match_numbers) if len(walls) else None
        numbers = self._numbers
        if found is None or found.said < numbers.least_count or found.fit < numbers.least_fit:
            return None
        return found

    def _tie(self, number: int, found: Match, first: bool) -> None:
        """Tell the graph where a stretch was found relative to those that drew the walls that it heard.

        Each wall belongs to the stretch that drew most of it. So each reading counts once, and tells only about the
        stretch whose wall it heard. What the first look tells counts a little for ever: later ones do not tell the size
        of the map.
        """
        votes = np.array([_support(each.votes, found.hits, self._grid.numbers.resolution) for each in self._drawn])
        owner = np.where(votes.max(axis=0) > _DREW, votes.argmax(axis=0), number)
        counts = np.bincount(owner, minlength=len(self._drawn))
        counts[number] = 0
        for other in np.argsort(-counts, kind="stable")[:int(self._numbers.contributors)]:
            if counts[other] >= _FEWEST_HITS:
                tie = self._tied(int(other), number, found, owner == other)
                self._graph.add(tie)
                if first:
                    root = tie.root / self._numbers.found_first
                    self._graph.add(tie._replace(root=root, measured_by=MeasuredBy.FIRST_LOOK))

    def _tied(self, other: int, number: int, found: Match, which: Array) -> Between:
        """Return where some readings of a stretch have it, relative to the other one whose walls they heard."""
        numbers = self._numbers
        pose, information = found.alone(which)
        slack = np.diag((numbers.slack ** 2, numbers.slack ** 2, numbers.slack_turn ** 2))
        information = np.linalg.solve(np.eye(3) + information @ slack, information)
        begin = self._graph.pose(other)
        cosine, sine = math.cos(begin.heading), math.sin(begin.heading)
        turned = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        values, vectors = np.linalg.eigh(turned @ information @ turned.T)
        root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        return Between(other, number, relative(begin, pose), root, MeasuredBy.LOOK)

    def _erase(self, number: int) -> None:
        """Take a stretch off the map."""
        for votes in self._drawn[number].votes:
            self._grid.add(votes, -1)
        self._drawn[number].votes = []

    def _redraw(self, number: int) -> None:
        """Draw a stretch anew where the graph has it now."""
        self._erase(number)
        drawn = self._drawn[number]
        drawn.pose, drawn.count = self._graph.pose(number), drawn.stretch.heard_count
        if drawn.count:
            votes = self._grid.votes(drawn.stretch.beams(self._graph.bias).moved(*drawn.pose))
            self._grid.add(votes)
            drawn.votes = [votes]


def _at_edge(guess: Pose, pose: Pose, reach: float, turn: float) -> bool:
    """Return whether a pose lies at the edge of the window round the guess: then it may be beyond."""
    off_x, off_y, off_heading = np.abs((pose.x - guess.x, pose.y - guess.y, wrapped(pose.heading - guess.heading)))
    return bool(max(off_x, off_y) > _EDGE * reach or off_heading > _EDGE * turn)


def _support(votes: Sequence[Votes], points: Array, resolution: float) -> Array:
    """Return how much votes have for walls at some points (m)."""
    total = np.zeros(len(points))
    for each in votes:
        column = np.floor(points[:, 0] / resolution).astype(int) - each.column
        row = np.floor(points[:, 1] / resolution).astype(int) - each.row
        rows, columns = each.occupied.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        total[inside] += each.occupied[row[inside], column[inside]]
    return total

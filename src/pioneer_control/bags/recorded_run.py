"""The class `Run`: what one robot did, as numpy arrays in SI units. `run.read_run` reads a Run from a bag.

All times are times (s) at which the recorder received a message. Only odometry is required. Other data that are not in
the bag are empty or None. A Run stays small however long the recording is: a row of a path or of values is kept only if
it differs from the row kept before (by 1 cm, 1 degree, ...), and an echo only if it is new.
"""

from types import MappingProxyType
from typing import Any, Mapping, NamedTuple, Optional, Tuple

import numpy as np

ECHO_GRID = 0.01  # m
SAME_PLACE = 0.1  # m: the corners of two maps of one frame are nearer
ERROR_EVERY = 0.5  # s between two times at which navigation is compared with the truth
PADDLE_MIDDLE = 0.05  # m from the tips of the paddles back to the point where they grip
USUAL_REACH = 0.3  # m from the origin to each side, for a robot with an unknown outline

Pose = Tuple[float, float, float]  # x, y (m), heading (rad, counter-clockwise)


class Track(NamedTuple):
    """The poses of a robot over time: arrays of the same length, in s, m, m and rad.

    The heading is counter-clockwise and does not jump from pi to -pi.
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    heading: np.ndarray

    @property
    def length(self) -> float:
        """The length of the path (m)."""
        return float(np.hypot(np.diff(self.x), np.diff(self.y)).sum())

    def pose(self, index: int) -> Pose:
        """The pose at an index of the arrays: 0 is the first pose, -1 the last."""
        return float(self.x[index]), float(self.y[index]), float(self.heading[index])

    def at(self, times: np.ndarray) -> "Track":
        """Return the track at other times (s), by linear interpolation.

        Before its first time the track has its first pose, and after its last time its last pose.
        """
        times = np.asarray(times, dtype=float)
        return Track(times, *(np.interp(times, self.time, values) for values in (self.x, self.y, self.heading)))

    def seen_from(self, origin: Pose) -> "Track":
        """Transform the track to another frame. `origin` is the pose of the track's present frame in the other one."""
        x, y = placed(origin, self.x, self.y)
        return Track(self.time, x, y, self.heading + origin[2])


class Echoes(NamedTuple):
    """The echoes of the sonar, without repeated readings: arrays of the same length.

    They hold the time (s), the number of the transducer, and the range (m) of each echo.
    """

    time: np.ndarray
    number: np.ndarray
    range: np.ndarray


class Velocities(NamedTuple):
    """Measured or commanded velocities over time: arrays of the same length.

    They hold the time (s), the speed forward (m/s), and the speed counter-clockwise (rad/s).
    """

    time: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


class Series(NamedTuple):
    """A value over time: arrays of the same length. Each value holds from its time (s) to the next time."""

    time: np.ndarray
    value: np.ndarray


class Span(NamedTuple):
    """A state that lasted from begin to end (s). `what` names the state, for example "both wheels" or "front 2, 3"."""

    begin: float
    end: float
    what: str


WARNING, ERROR = 1, 2  # levels of diagnostic_msgs


class Report(NamedTuple):
    """A warning or an error in a recording.

    `time` is in s. `level` is WARNING or ERROR. `who` is a diagnostics task ("Link") or a node ("/pioneer/p2os").
    `what` is the text.
    """

    time: float
    level: int
    who: str
    what: str


class GripperEvent(NamedTuple):
    """What the paddles of the gripper did at a time (s): "picked up", "put down" or "closed on nothing"."""

    time: float
    what: str


class Look(NamedTuple):
    """Where a camera looked from begin to end (s): the direction in base_link (rad, counter-clockwise) and the width of
    its view (rad).
    """

    begin: float
    end: float
    bearing: float
    width: float


class CanPath(NamedTuple):
    """The positions of a can over time: arrays of the same length, in s, m, m and m (height above the floor)."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    height: np.ndarray


class Map(NamedTuple):
    """An occupancy grid.

    Attributes:
        cells: array of shape (rows, columns), the bottom row first. 0 is free, 100 is occupied, -1 is unknown.
        resolution: side of a cell (m).
        origin: pose of the corner of cell (0, 0) (m, rad; map frame).
    """

    cells: np.ndarray
    resolution: float
    origin: Pose

    def covers_the_same(self, other: "Map") -> bool:
        """Return whether another map has the same corners. Their cells may differ in size."""
        corners = [(each.origin[0], each.origin[1], each.cells.shape[1] * each.resolution,
                    each.cells.shape[0] * each.resolution) for each in (self, other)]
        return bool(np.allclose(*corners, rtol=0.0, atol=SAME_PLACE))


EXPLORED = "explored"  # end of a goal that the robot chose itself, whatever became of it


class Goal(NamedTuple):
    """A goal that navigation had from a time (s) on, in the map (m).

    `end` says what became of it: "reached", "failed", "cancelled", "replaced" by another, or "under way" at the end;
    EXPLORED: the robot chose it itself, to make its map.
    """

    time: float
    x: float
    y: float
    end: str


class Navigated(NamedTuple):
    """What the navigation of a robot said. All places are in its map.

    Attributes:
        track: where it believed to be.
        states: when it drove to a goal, and when it waited on its way.
        unsure: when it did not know where it was.
        plans: some of its plans: arrays of x and y (m).
        clouds: where it might be, now and then: arrays of x, y (m) and heading (rad).
        goals: where it was sent.
        sure_from: the first time (s) at which it knew where it was; None: never.
    """

    track: Track
    states: Tuple[Span, ...] = ()
    unsure: Tuple[Span, ...] = ()
    plans: Tuple[np.ndarray, ...] = ()
    clouds: Tuple[np.ndarray, ...] = ()
    goals: Tuple[Goal, ...] = ()
    sure_from: Optional[float] = None

    def is_sure(self, times: np.ndarray) -> np.ndarray:
        """Return for times (s) whether it knew where it was."""
        sure = np.ones(len(times), dtype=bool)
        for begin, end, _ in self.unsure:
            sure &= (times < begin) | (times >= end)
        return sure

    @property
    def sure_track(self) -> Optional[Track]:
        """Where it knew to be. None if it never knew for as long as two poses."""
        sure = self.is_sure(self.track.time)
        return Track(*(values[sure] for values in self.track)) if np.count_nonzero(sure) > 1 else None


_NOTHING = np.empty(0)


class Run(NamedTuple):
    """What one robot did. Poses are in the frame of its odometry, unless a comment names another frame."""

    path: str  # of the bag, or of its first part
    robot: str  # namespace without slashes at its ends; empty for a robot at the root
    odometry: Track
    truth: Optional[Track]  # the true path in the frame of the simulated world
    sonar: Echoes
    gripper: Tuple[GripperEvent, ...]
    cans: Tuple[CanPath, ...]  # in the frame of the simulated world
    map: Optional[Map]
    model: str = ""  # subtype, empty when no robot_info was recorded
    world: str = ""  # name of the simulated world, empty when none was recorded
    footprint: np.ndarray = np.empty((0, 2))  # (k, 2) outline in base_link, m; k = 0 when unknown
    transducers: Mapping[int, Pose] = MappingProxyType({})  # pose in base_link, by number of the transducer
    commanded: Velocities = Velocities(_NOTHING, _NOTHING, _NOTHING)  # of programs and persons
    measured: Velocities = Velocities(_NOTHING, _NOTHING, _NOTHING)  # from the odometry
    battery: Series = Series(_NOTHING, _NOTHING)  # V
    motors: Series = Series(_NOTHING, _NOTHING)  # 0 off, 1 on
    e_stop: Series = Series(_NOTHING, _NOTHING)  # 1 while the STOP button is pressed
    stalls: Tuple[Span, ...] = ()
    bumps: Tuple[Span, ...] = ()
    faults: Tuple[Report, ...] = ()  # of this robot, and of nodes that belong to no robot
    gaps: Tuple[Span, ...] = ()  # when a periodic topic had no messages; what: name of the topic
    doings: Tuple[Span, ...] = ()  # what a wandering program did: "driving", "turning"
    looks: Tuple[Look, ...] = ()  # of the camera, where it has one that turns
    navigation: Optional[Navigated] = None
    map_made: bool = False  # the robot made the map meanwhile; then the map begins where the robot began
    own_frame: bool = False  # the frame of the map is not that of the simulated world
    notes: str = ""  # the recorder's description of the recording (YAML)
    damage: str = ""  # what could not be read from the bag, in sentences; empty if all could be read

    @property
    def duration(self) -> float:
        """The time (s) from the first odometry pose to the last."""
        return float(self.odometry.time[-1] - self.odometry.time[0])

    @property
    def grip(self) -> float:
        """The x coordinate (m, base_link) of the point where the paddles grip."""
        return float(self.footprint[:, 0].max() if len(self.footprint) else USUAL_REACH) - PADDLE_MIDDLE

    @property
    def reach(self) -> float:
        """The largest distance (m) from the origin of base_link to the outline of the robot."""
        return float(np.hypot(*self.footprint.T).max() if len(self.footprint) else USUAL_REACH)

    @property
    def odometry_origin(self) -> Pose:
        """The pose of the odometry frame in the map, so that the odometry begins on the true path.

        Without a true path it begins where navigation was first sure to be. Zero without both.
        """
        if self.truth_in_map is not None:
            return laid_on(self.odometry, self.truth_in_map)
        if self.navigation is not None:
            return laid_on(self.odometry, self.navigation.track, self.navigation.sure_from or 0.0)
        return (0.0, 0.0, 0.0)

    @property
    def true_frame(self) -> Pose:
        """The pose of the frame of the true path and of the cans, in the frame of `map`.

        A map that a robot made has a frame of its own: there the true path begins where the robot was first sure to be.
        """
        if self.truth is None or self.navigation is None or not (self.map_made or self.own_frame):
            return (0.0, 0.0, 0.0)
        return laid_on(self.truth, self.navigation.track, self.navigation.sure_from or 0.0)

    @property
    def truth_in_map(self) -> Optional[Track]:
        """The true path, in the frame of `map`."""
        return None if self.truth is None else self.truth.seen_from(self.true_frame)

    @property
    def cans_in_map(self) -> Tuple[CanPath, ...]:
        """The cans, in the frame of `map`."""
        frame = self.true_frame
        return tuple(CanPath(can.time, *placed(frame, can.x, can.y), can.height) for can in self.cans)

    def navigation_errors(self) -> Tuple[np.ndarray, np.ndarray]:
        """Return how far navigation was off (m; rad, without sign), while it said that it knew where it was.

        Empty without a true path or navigation.
        """
        if self.truth_in_map is None or self.navigation is None:
            return np.empty(0), np.empty(0)
        times = np.arange(max(self.truth_in_map.time[0], self.navigation.track.time[0]),
                          min(self.truth_in_map.time[-1], self.navigation.track.time[-1]), ERROR_EVERY)
        times = times[self.navigation.is_sure(times)]
        true, believed = self.truth_in_map.at(times), self.navigation.track.at(times)
        turned = np.abs((believed.heading - true.heading + np.pi) % (2.0 * np.pi) - np.pi)
        return np.hypot(believed.x - true.x, believed.y - true.y), turned

    def echoes(self, track: Optional[Track] = None) -> np.ndarray:
        """Return the points (m) where the sonar had echoes: an array of shape (n, 2). They are in the frame of the
        track that places them: of the odometry, if no other is given. Another one is that of navigation, which places
        only what was heard while it knew where it was.

        At most one point is kept in each square of 1 cm. Empty if the poses of the transducers are not known.
        """
        fitted = np.isin(self.sonar.number, list(self.transducers))
        if track is not None and self.navigation is not None:
            fitted &= self.navigation.is_sure(self.sonar.time)
        if not fitted.any():
            return np.empty((0, 2))
        time, number, reach = (values[fitted] for values in self.sonar)
        looks = np.array([self.transducers[n] for n in number.astype(int)])
        robot = (track or self.odometry).at(time)
        hit = looks[:, 0] + reach * np.cos(looks[:, 2]), looks[:, 1] + reach * np.sin(looks[:, 2])
        points = np.column_stack(placed((robot.x, robot.y, robot.heading), *hit))
        _, first = np.unique(np.round(points / ECHO_GRID).astype(int), axis=0, return_index=True)
        return points[np.sort(first)]


def laid_on(track: Track, other: Track, after: float = -np.inf) -> Pose:
    """Return the pose of a track's frame in the frame of another track, so that both are at the same pose at the first
    time (s) that both have, but not before `after`.
    """
    start = np.array([max(track.time[0], other.time[0], after)])
    return chained(other.at(start).pose(0), inverted(track.at(start).pose(0)))


def placed(pose: Any, x: Any, y: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Transform points from a child frame to its parent frame.

    Args:
        pose: pose of the child frame in the parent frame (x, y in m, heading in rad). The parts may be arrays.
        x: x coordinates of the points in the child frame (m), a number or an array.
        y: y coordinates of the points in the child frame (m), a number or an array.

    Returns:
        The x and y coordinates of the points in the parent frame (m).
    """
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y


def chained(first: Pose, then: Pose) -> Pose:
    """Compose two poses. `first` is the pose of a child frame in its parent frame, `then` a pose in the child frame.

    Returns the pose `then` in the parent frame.
    """
    x, y = placed(first, then[0], then[1])
    return float(x), float(y), first[2] + then[2]


def inverted(pose: Pose) -> Pose:
    """Invert a transform. `pose` is the pose of a child frame in its parent frame.

    Returns the pose of the parent frame in the child frame.
    """
    x, y = placed((0.0, 0.0, -pose[2]), -pose[0], -pose[1])
    return float(x), float(y), -pose[2]

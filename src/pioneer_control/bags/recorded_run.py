"""What one robot did, as numpy arrays in SI units, on the recorder's clock: a :class:`Run`. `run.read_run` reads it.

Only odometry is required. Whatever else is not in a bag is empty or ``None``. A Run stays small however long the run
was: a row of a path or of values is kept where it differs from the row kept before (by 1 cm, 1 degree, ...), and an
echo where it is new.
"""

from types import MappingProxyType
from typing import Any, Mapping, NamedTuple, Optional, Tuple

import numpy as np

ECHO_GRID = 0.01  # m
PADDLE_MIDDLE = 0.05  # m behind the paddles' tips: where they grip
USUAL_REACH = 0.3  # m to all sides, of a robot whose outline is not known

Pose = Tuple[float, float, float]  # x, y (m), heading (rad, counter-clockwise)


class Track(NamedTuple):
    """Where a robot was: arrays of the same length; s, m, m, rad. The heading does not jump at half a turn."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    heading: np.ndarray

    @property
    def length(self) -> float:
        """The way driven, in m."""
        return float(np.hypot(np.diff(self.x), np.diff(self.y)).sum())

    def pose(self, index: int) -> Pose:
        """The pose at an index: 0 is the first, -1 the last."""
        return float(self.x[index]), float(self.y[index]), float(self.heading[index])

    def at(self, times: np.ndarray) -> "Track":
        """The track at other times: on straight lines in between, held still before its first and after its last."""
        times = np.asarray(times, dtype=float)
        return Track(times, *(np.interp(times, self.time, values) for values in (self.x, self.y, self.heading)))

    def seen_from(self, origin: Pose) -> "Track":
        """The track in the frame in which its own frame lies at `origin`."""
        x, y = placed(origin, self.x, self.y)
        return Track(self.time, x, y, self.heading + origin[2])


class Echoes(NamedTuple):
    """New echoes of the sonar: arrays of the same length; s, the transducer's number, m."""

    time: np.ndarray
    number: np.ndarray
    range: np.ndarray


class Velocities(NamedTuple):
    """How fast a robot was or was to be: arrays of the same length; s, m/s forward, rad/s counter-clockwise."""

    time: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


class Series(NamedTuple):
    """A value over time: arrays of the same length. Each value holds from its time (s) to the next time."""

    time: np.ndarray
    value: np.ndarray


class Span(NamedTuple):
    """Something that lasted, from begin to end (s): "both wheels", "front 2, 3"."""

    begin: float
    end: float
    what: str


WARNING, ERROR = 1, 2  # levels of diagnostic_msgs


class Report(NamedTuple):
    """A warning or an error: its time (s), its level, who reports it ("Link", "/pioneer/p2os"), and in which words."""

    time: float
    level: int
    who: str
    what: str


class GripperEvent(NamedTuple):
    """Something the paddles did: time in s, and "picked up", "put down" or "closed on nothing"."""

    time: float
    what: str


class CanPath(NamedTuple):
    """Where a can was: arrays of the same length; s, m, m, and how high it was lifted (m)."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    height: np.ndarray


class Map(NamedTuple):
    """An occupancy grid.

    Attributes:
        cells: (rows, columns), bottom-up: 0 free to 100 occupied, -1 unknown.
        resolution: m.
        origin: pose of the corner of cell (0, 0).
    """

    cells: np.ndarray
    resolution: float
    origin: Pose


_NOTHING = np.empty(0)


class Run(NamedTuple):
    """What one robot did, in the frame of its odometry unless said otherwise."""

    path: str  # of the bag, or of its first part
    robot: str  # namespace without slashes at its ends; empty for a robot at the root
    odometry: Track
    truth: Optional[Track]  # in the frame of the map
    sonar: Echoes
    gripper: Tuple[GripperEvent, ...]
    cans: Tuple[CanPath, ...]  # in the frame of the map
    map: Optional[Map]
    model: str = ""  # subtype, empty when no robot_info was recorded
    world: str = ""  # name of the simulated world, empty when none was recorded
    footprint: np.ndarray = np.empty((0, 2))  # (k, 2) outline in base_link, m; k = 0 when unknown
    transducers: Mapping[int, Pose] = MappingProxyType({})  # by sonar number, in base_link
    commanded: Velocities = Velocities(_NOTHING, _NOTHING, _NOTHING)  # cmd_vel
    measured: Velocities = Velocities(_NOTHING, _NOTHING, _NOTHING)  # the odometry's
    battery: Series = Series(_NOTHING, _NOTHING)  # V
    motors: Series = Series(_NOTHING, _NOTHING)  # 0 off, 1 on
    e_stop: Series = Series(_NOTHING, _NOTHING)  # 1 while the STOP button is pressed
    stalls: Tuple[Span, ...] = ()
    bumps: Tuple[Span, ...] = ()
    faults: Tuple[Report, ...] = ()  # of this robot, and of nodes that belong to no robot
    gaps: Tuple[Span, ...] = ()  # when a topic was silent that should not be; what: its name
    doings: Tuple[Span, ...] = ()  # what a wandering program was about: "driving", "turning"
    notes: str = ""  # how the recording describes itself (YAML)
    damage: str = ""  # what of the bag could not be read; empty when all was

    @property
    def duration(self) -> float:
        """Seconds from the first pose to the last."""
        return float(self.odometry.time[-1] - self.odometry.time[0])

    @property
    def grip(self) -> float:
        """How far ahead of the robot's middle the paddles grip, m."""
        return float(self.footprint[:, 0].max() if len(self.footprint) else USUAL_REACH) - PADDLE_MIDDLE

    @property
    def reach(self) -> float:
        """How far the robot reaches around its middle, m."""
        return float(np.hypot(*self.footprint.T).max() if len(self.footprint) else USUAL_REACH)

    @property
    def odometry_origin(self) -> Pose:
        """Where the odometry's frame lies in the map when both tracks begin together. Zero without a true path."""
        if self.truth is None:
            return (0.0, 0.0, 0.0)
        # One track may begin before the other: this is the first moment that both have.
        start = np.array([max(self.truth.time[0], self.odometry.time[0])])
        return chained(self.truth.at(start).pose(0), inverted(self.odometry.at(start).pose(0)))

    def echoes(self) -> np.ndarray:
        """Where the sonar heard something: points (n, 2) in the odometry's frame, m; one in each square of 1 cm."""
        fitted = np.isin(self.sonar.number, list(self.transducers))
        if not fitted.any():
            return np.empty((0, 2))
        time, number, reach = (values[fitted] for values in self.sonar)
        looks = np.array([self.transducers[n] for n in number.astype(int)])
        robot = self.odometry.at(time)
        hit = looks[:, 0] + reach * np.cos(looks[:, 2]), looks[:, 1] + reach * np.sin(looks[:, 2])
        points = np.column_stack(placed((robot.x, robot.y, robot.heading), *hit))
        _, first = np.unique(np.round(points / ECHO_GRID).astype(int), axis=0, return_index=True)
        return points[np.sort(first)]


def placed(pose: Any, x: Any, y: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Points x, y in the frame that lies at a pose, as the frame sees them in which that pose is. All may be arrays."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y


def chained(first: Pose, then: Pose) -> Pose:
    """The pose `then`, which is in the frame that lies at `first`, as the frame sees it in which `first` is."""
    x, y = placed(first, then[0], then[1])
    return float(x), float(y), first[2] + then[2]


def inverted(pose: Pose) -> Pose:
    """The pose of the outer frame, seen from the frame that lies at this pose in it."""
    x, y = placed((0.0, 0.0, -pose[2]), -pose[0], -pose[1])
    return float(x), float(y), -pose[2]

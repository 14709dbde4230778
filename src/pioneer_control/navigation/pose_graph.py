"""Poses that agree best with all that was measured between them: a pose graph.

It also estimates the lasting errors of the wheels: what odometry measured between two poses depends on these. A pose
that was looked for again and again tells the map's shape, but not its size: readings fit walls that are a little too
far apart as well as true ones. So by how much the map is too large is one more unknown. The wheels tell the size, and
where each pose was found first.

Solved by Gauss-Newton with sparse matrices. A measurement that disagrees with all others counts little (Cauchy's
weight). Where five of the walls that were heard, and half of all, are square to each other, the nodes are turned so
that these walls face one way, or square to it; which way that is, is one more unknown. Where they are not, what was
found on the map counts less.
"""

import enum
from typing import Any, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from ..floor_poses import Pose
from .frames import wrapped_angles
from .tuned import WallNumbers
from .wall_directions import WallDirection, square_walls
from .wheel_motion import WheelBias

Array = Any     # of numpy

_DECIMALS = 7
"""To which solutions are rounded (m, rad)."""


class MeasuredBy(enum.IntEnum):
    """What measured a pose. On the map it may be entirely wrong."""

    WHEELS = 0      # by odometry: too short by as much as the wheels measure too little
    FIRST_LOOK = 1  # found on the map for the first time
    LOOK = 2        # found on the map: too large by as much as the map; the next look takes its place


class Between(NamedTuple):
    """A measured pose of one node relative to another.

    Attributes:
        first, second: numbers of the nodes.
        pose: pose of the second relative to the first.
        root: matrix W (3 x 3) with W^T W = inverse of the covariance (m, m, rad).
        measured_by: what measured it.
        by_bias: matrix (3 x 2): how the measured pose changes with the turning and the veer of the wheels' bias. Zero
            if it was found on the map.
    """

    first: int
    second: int
    pose: Pose
    root: Array
    measured_by: MeasuredBy
    by_bias: Array = np.zeros((3, 2))


_MEASURED = np.dtype([("first", int), ("second", int), ("pose", float, 3), ("root", float, (3, 3)),
                      ("measured_by", int), ("by_bias", float, (3, 2))])
"""`Between`, as a table has it: it is solved many times between two changes."""
_WALL = np.dtype([("node", int), ("heading", float), ("deviation", float)])
_SHARED = 5
"""Unknowns that all nodes share: the wheels' bias (3), the map's error of size, and the direction of square walls."""


class PoseGraph:
    """Poses (nodes) and what was measured between them. The first node does not move.

    Args:
        pose: of the first node.
        spread: standard deviations that are expected: of the wheels' bias (share, share, rad/m), and of the map's size
            (share).
        doubt: a measurement on the map that is off by this many standard deviations counts half.
        wall_numbers: which walls are held square.

    Attributes:
        poses: of all nodes, array (n, 3).
        bias: of the wheels.
    """

    def __init__(self, pose: Pose, spread: Tuple[float, float, float, float], doubt: float,
                 wall_numbers: WallNumbers = WallNumbers()) -> None:
        self.poses = np.array([pose], dtype=float)
        self.bias = WheelBias()
        self._size_error = 0.0   # the share by which the map is too large
        self._spread, self._doubt, self._wall_numbers = np.array(spread), doubt, wall_numbers
        self._measured, self._walls = np.zeros(0, _MEASURED), np.zeros(0, _WALL)

    def add_node(self, pose: Pose) -> int:
        """Add a node where it is assumed to be, and return its number."""
        self.poses = np.vstack((self.poses, pose))
        return len(self.poses) - 1

    def add(self, between: Between) -> None:
        """Add a measurement."""
        self._measured = np.concatenate((self._measured, np.array([tuple(between)], _MEASURED)))

    def untie(self, second: int) -> None:
        """Forget the last look for a node, before it is looked for anew."""
        table = self._measured
        self._measured = table[(table["measured_by"] != MeasuredBy.LOOK) | (table["second"] != second)]

    def set_walls(self, node: int, walls: Sequence[WallDirection]) -> None:
        """Take the directions (rad, relative to the node) of the walls that were heard at a node, instead of those that
        it had.
        """
        rows = np.array([(node, *each) for each in walls], _WALL)
        self._walls = np.concatenate((self._walls[self._walls["node"] != node], rows))

    def pose(self, number: int) -> Pose:
        """Return the pose of a node."""
        return Pose(*map(float, self.poses[number]))

    def solve(self, rounds: int = 3) -> None:
        """Move the nodes to where the measurements want them."""
        if len(self.poses) < 2:
            return
        columns = tuple(self._measured[name] for name in _MEASURED.names)
        for _ in range(rounds):
            self._step(*columns)
        # The last bits depend on how a library of linear algebra was built and loaded. The same data give the same map.
        self.poses = np.round(self.poses, _DECIMALS)
        self.bias = WheelBias(*(round(float(each), _DECIMALS) for each in self.bias))
        self._size_error = round(self._size_error, _DECIMALS)

    def _step(self, first: Array, second: Array, measured: Array, root: Array, measured_by: Array,
              by_bias: Array) -> None:
        """Make one step of Gauss-Newton."""
        error, blocks = self._linear(first, second, measured, root, measured_by, by_bias)
        node, off, walls_weight = self._square()
        # A stretch is found on what its neighbours drew, and errs as they do: it confirms a bend that is not there, and
        # an error of the wheels that they do not have. Where no walls hold the headings, odometry is trusted more.
        few = len(self._walls) < self._wall_numbers.least_walls
        trust = 1.0 if few or len(node) else self._wall_numbers.ties_alone
        found = trust / (1.0 + (error ** 2).sum(axis=1) / self._doubt ** 2)
        weight = np.where(measured_by == MeasuredBy.WHEELS, 1.0, found) ** 0.5
        blocks *= weight[:, None, None]
        error *= weight[:, None]
        expected = np.array((*self.bias, self._size_error))
        shared = 3 * len(self.poses)
        place = np.concatenate((3 * first[:, None] + np.arange(3), 3 * second[:, None] + np.arange(3),
                                np.tile(shared + np.arange(len(expected)), (len(first), 1))), axis=1)
        row = np.broadcast_to((3 * np.arange(len(first)))[:, None, None] + np.arange(3)[:, None], blocks.shape)
        column = np.broadcast_to(place[:, None], blocks.shape)
        # Below these the errors that are expected of wheels and size; the walls; and their direction, which may be any.
        held = 3 * len(first) + np.arange(_SHARED)
        walls_row = held[-1] + 1 + np.arange(len(node))
        row = np.concatenate((row.ravel(), held, walls_row, walls_row))
        column = np.concatenate((column.ravel(), shared + np.arange(_SHARED), 3 * node + 2,
                                 np.full(len(node), shared + _SHARED - 1)))
        value = np.concatenate((blocks.ravel(), 1.0 / self._spread, (1.0,), walls_weight, -walls_weight))
        error = np.concatenate((error.ravel(), expected / self._spread, (0.0,), off * walls_weight))
        # Without the first three columns: the first node stays.
        slope = coo_matrix((value, (row, column)), shape=(len(error), shared + _SHARED)).tocsc()[:, 3:]
        # The matrix is symmetric and positive: said so, it is factorized several times as fast.
        factors = splu((slope.T @ slope).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                       options={"SymmetricMode": True})
        step = -factors.solve(slope.T @ error)
        self.poses[1:] += step[:-_SHARED].reshape(-1, 3)
        *bias, self._size_error = map(float, expected + step[-_SHARED:-1])
        self.bias = WheelBias(*bias)

    def _linear(self, first: Array, second: Array, measured: Array, root: Array, measured_by: Array,
                by_bias: Array) -> Tuple[Array, Array]:
        """Return by how many standard deviations the measurements are off, array (n, 3), and how that changes with both
        poses (3 each), the bias of the wheels (3), and the map's error of size, array (n, 3, 10).
        """
        heading, way = self.poses[first, 2], self.poses[second] - self.poses[first]
        cosine, sine = np.cos(heading), np.sin(heading)
        ahead, aside = cosine * way[:, 0] + sine * way[:, 1], cosine * way[:, 1] - sine * way[:, 0]
        # What errs in size changes the way, not what was measured: else all would shrink, as errors shrink with it.
        size = np.array((1.0 / (1.0 + self.bias.distance), 1.0, 1.0 + self._size_error))[measured_by]
        error = np.stack((size * ahead, size * aside, way[:, 2]), axis=1)
        error -= measured + np.einsum("nij,j->ni", by_bias, np.array((self.bias.turning, self.bias.veer)))
        error[:, 2] = wrapped_angles(error[:, 2])
        slope = np.zeros((len(first), 3, 10))
        slope[:, 0, 3] = slope[:, 1, 4] = size * cosine
        slope[:, 0, 4], slope[:, 1, 3], slope[:, 2, 5] = size * sine, -size * sine, 1.0
        slope[:, :, :3] = -slope[:, :, 3:6]
        slope[:, 0, 2], slope[:, 1, 2] = size * aside, -size * ahead
        by_distance = np.where(measured_by == MeasuredBy.WHEELS, -size ** 2, 0.0)
        by_size_error = np.where(measured_by == MeasuredBy.LOOK, 1.0, 0.0)
        slope[:, 0, 6], slope[:, 1, 6] = by_distance * ahead, by_distance * aside
        slope[:, :, 7:9] = -by_bias
        slope[:, 0, 9], slope[:, 1, 9] = by_size_error * ahead, by_size_error * aside
        return np.einsum("nij,nj->ni", root, error), np.einsum("nij,njk->nik", root, slope)

    def _square(self) -> Tuple[Array, Array, Array]:
        """Return of the walls that are square to each other the nodes, how far they are off (rad), and their weights.
        """
        walls = self._walls
        square = square_walls(self.poses[walls["node"], 2] + walls["heading"], walls["deviation"], self._wall_numbers)
        if square is None:
            return np.zeros(0, int), np.zeros(0), np.zeros(0)
        return walls["node"][square.which], square.off, square.weights

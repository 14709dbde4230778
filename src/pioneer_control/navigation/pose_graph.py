"""Poses that agree best with all that was measured between them: a pose graph.

It also estimates the lasting errors of the wheels: what odometry measured between two poses depends on these. Solved by
Gauss-Newton with sparse matrices. A measurement that disagrees with all others counts little (Cauchy's weight). Where
five of the walls that were heard, and half of all, are square to each other, the nodes are turned so that these walls
face one way, or square to it; which way that is, is one more unknown. Where they are not, doubted measurements count
less.
"""

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


class Between(NamedTuple):
    """A measured pose of one node relative to another.

    Attributes:
        first, second: numbers of the nodes.
        pose: pose of the second relative to the first.
        root: matrix W (3 x 3) with W^T W = inverse of the covariance (m, m, rad).
        by_bias: matrix (3 x 3): how the measured pose changes with the bias of the wheels. Zero if it does not.
        doubted: whether it may be entirely wrong.
    """

    first: int
    second: int
    pose: Pose
    root: Array
    by_bias: Array
    doubted: bool


_MEASURED = np.dtype([("first", int), ("second", int), ("pose", float, 3), ("root", float, (3, 3)),
                      ("by_bias", float, (3, 3)), ("doubted", bool)])
"""`Between`, as a table has it: it is solved many times between two changes."""
_WALL = np.dtype([("node", int), ("heading", float), ("deviation", float)])
_SHARED = 4
"""Unknowns that all nodes share: the three of the wheels' bias, and the direction that square walls face."""


class PoseGraph:
    """Poses (nodes) and what was measured between them. The first node does not move.

    Args:
        pose: of the first node.
        spread: standard deviations of the wheels' bias that are expected: share, share, rad/m.
        doubt: a doubted measurement that is off by this many standard deviations counts half.
        wall_numbers: which walls are held square.

    Attributes:
        poses: of all nodes, array (n, 3).
        bias: of the wheels.
    """

    def __init__(self, pose: Pose, spread: Tuple[float, float, float], doubt: float,
                 wall_numbers: WallNumbers = WallNumbers()) -> None:
        self.poses = np.array([pose], dtype=float)
        self.bias = WheelBias()
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
        """Forget the doubted measurements of a node relative to others, before it is measured anew."""
        table = self._measured
        self._measured = table[~(table["doubted"] & (table["second"] == second))]

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

    def _step(self, first: Array, second: Array, measured: Array, root: Array, by_bias: Array, doubted: Array) -> None:
        """Make one step of Gauss-Newton."""
        error, blocks = self._linear(first, second, measured, root, by_bias)
        node, off, walls_weight = self._square()
        # A stretch is found on what its neighbours drew, and errs as they do: it confirms a bend that is not there, and
        # an error of the wheels that they do not have. Where no walls hold the headings, odometry is trusted more.
        few = len(self._walls) < self._wall_numbers.least_walls
        trust = 1.0 if few or len(node) else self._wall_numbers.ties_alone
        weight = np.where(doubted, trust / (1.0 + (error ** 2).sum(axis=1) / self._doubt ** 2), 1.0) ** 0.5
        blocks *= weight[:, None, None, None]
        error *= weight[:, None]
        bias = np.array(self.bias)
        shared = 3 * len(self.poses)
        place = np.stack((3 * first, 3 * second, np.full(len(first), shared)), axis=1)
        row = np.broadcast_to((3 * np.arange(len(first)))[:, None, None, None] + np.arange(3)[:, None], blocks.shape)
        column = np.broadcast_to(place[:, :, None, None] + np.arange(3), blocks.shape)
        # Below these the bias that is expected; the walls; and the direction that these face, which may be any.
        held = 3 * len(first) + np.arange(_SHARED)
        walls_row = held[-1] + 1 + np.arange(len(node))
        row = np.concatenate((row.ravel(), held, walls_row, walls_row))
        column = np.concatenate((column.ravel(), shared + np.arange(_SHARED), 3 * node + 2,
                                 np.full(len(node), shared + _SHARED - 1)))
        value = np.concatenate((blocks.ravel(), 1.0 / self._spread, (1.0,), walls_weight, -walls_weight))
        error = np.concatenate((error.ravel(), bias / self._spread, (0.0,), off * walls_weight))
        # Without the first three columns: the first node stays.
        slope = coo_matrix((value, (row, column)), shape=(len(error), shared + _SHARED)).tocsc()[:, 3:]
        # The matrix is symmetric and positive: said so, it is factorized several times as fast.
        factors = splu((slope.T @ slope).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                       options={"SymmetricMode": True})
        step = -factors.solve(slope.T @ error)
        self.poses[1:] += step[:-_SHARED].reshape(-1, 3)
        self.bias = WheelBias(*(bias + step[-_SHARED:-1]))

    def _linear(self, first: Array, second: Array, measured: Array, root: Array, by_bias: Array) -> Tuple[Array, Array]:
        """Return by how many standard deviations the measurements are off, array (n, 3), and how that changes with the
        poses of both nodes and with the bias of the wheels, array (n, 3 of these, 3, 3).
        """
        start, way = self.poses[first], self.poses[second] - self.poses[first]
        cosine, sine = np.cos(start[:, 2]), np.sin(start[:, 2])
        error = np.empty_like(measured)
        expected = measured + np.einsum("nij,j->ni", by_bias, np.array(self.bias))
        error[:, 0] = cosine * way[:, 0] + sine * way[:, 1] - expected[:, 0]
        error[:, 1] = -sine * way[:, 0] + cosine * way[:, 1] - expected[:, 1]
        error[:, 2] = wrapped_angles(way[:, 2] - expected[:, 2])
        by_second, by_first = np.zeros((len(first), 3, 3)), np.zeros((len(first), 3, 3))
        by_second[:, 0, 0] = by_second[:, 1, 1] = cosine
        by_second[:, 0, 1], by_second[:, 1, 0], by_second[:, 2, 2] = sine, -sine, 1.0
        by_first[:] = -by_second
        by_first[:, 0, 2] = -sine * way[:, 0] + cosine * way[:, 1]
        by_first[:, 1, 2] = -cosine * way[:, 0] - sine * way[:, 1]
        blocks = np.stack([np.einsum("nij,njk->nik", root, each) for each in (by_first, by_second, -by_bias)], axis=1)
        return np.einsum("nij,nj->ni", root, error), blocks

    def _square(self) -> Tuple[Array, Array, Array]:
        """Return of the walls that are square to each other the nodes, how far they are off (rad), and their weights.
        """
        walls = self._walls
        square = square_walls(self.poses[walls["node"], 2] + walls["heading"], walls["deviation"], self._wall_numbers)
        if square is None:
            return np.zeros(0, int), np.zeros(0), np.zeros(0)
        return walls["node"][square.which], square.off, square.weights

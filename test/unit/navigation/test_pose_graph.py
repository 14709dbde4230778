"""Poses that agree with what was measured between them."""

import math

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose, compose, relative
from pioneer_control.navigation.pose_graph import Between, MeasuredBy, PoseGraph
from pioneer_control.navigation.tuned import WallNumbers
from pioneer_control.navigation.wall_directions import WallDirection

TRUSTING = WallNumbers(ties_alone=1.0)
"""Places that were found count in full, also where no walls are held square."""


def square(bend=0.0, by_bias=np.zeros((3, 2))):
    """A way round a square, 8 steps of 1 m; odometry turns too far by `bend` (rad) each."""
    truth, graph = [Pose(0.0, 0.0, 0.0)], PoseGraph(Pose(0.0, 0.0, 0.0), (0.1, 0.1, 0.1, 0.1), 3.0, TRUSTING)
    for number in range(8):
        step = Pose(1.0, 0.0, math.pi / 2 if number % 2 else 0.0)
        truth.append(compose(truth[-1], step))
        wrong = step._replace(heading=step.heading + bend)
        graph.add_node(compose(graph.pose(number), wrong))
        graph.add(Between(number, number + 1, wrong, np.diag((50.0, 50.0, 20.0)), MeasuredBy.WHEELS, by_bias))
    return graph, truth


def worst(graph, truth):
    return max(math.hypot(*(graph.poses[number, :2] - pose[:2])) for number, pose in enumerate(truth))


def closing(truth, first, second, wrong=Pose(0.0, 0.0, 0.0)):
    return Between(first, second, compose(relative(truth[first], truth[second]), wrong),
                   np.diag((50.0, 50.0, 50.0)), MeasuredBy.LOOK)


def test_a_loop_that_closes_takes_the_error_out():
    graph, truth = square(0.05)
    before = worst(graph, truth)
    graph.add(closing(truth, 0, 8))
    graph.solve(10)
    assert before > 0.5
    assert worst(graph, truth) < 0.3 * before
    assert graph.pose(0) == Pose(0.0, 0.0, 0.0)


def test_what_lasts_is_put_on_the_wheels():
    by_veer = np.zeros((3, 2))
    by_veer[2, 1] = 1.0
    graph, truth = square(0.05, by_veer)
    graph.add(closing(truth, 0, 8))
    graph.solve(10)
    assert graph.bias.veer == pytest.approx(-0.05, abs=0.005)
    assert worst(graph, truth) < 0.1


def test_a_false_closing_among_true_ones_counts_little():
    graph, truth = square()
    for first in range(5):
        graph.add(closing(truth, first, first + 4))
    graph.add(closing(truth, 0, 8, Pose(1.5, 0.5, 0.5)))
    graph.solve(10)
    assert worst(graph, truth) < 0.05


def test_what_is_untied_counts_no_more():
    graph, truth = square(0.05)
    graph.add(closing(truth, 0, 8))
    graph.untie(8)
    before = graph.poses.copy()
    graph.solve(10)
    assert graph.poses == pytest.approx(before)


def way(size_error, measured, measured_by=MeasuredBy.LOOK):
    """Return a solved graph of a way of 40 steps that are 1 m each by odometry, with what was found on the map.

    Args:
        size_error: the share by which the map is expected to be too large or too small.
        measured: the length of a metre on the map, for each way from a node to one that is one to four steps on.
        measured_by: whether that was found first.
    """
    graph = PoseGraph(Pose(0.0, 0.0, 0.0), (0.03, 0.05, 0.012, size_error), 3.0, TRUSTING)
    for number in range(40):
        graph.add_node(Pose(number + 1.0, 0.0, 0.0))
        graph.add(Between(number, number + 1, Pose(1.0, 0.0, 0.0), np.diag((100.0, 100.0, 100.0)), MeasuredBy.WHEELS))
    measurements = iter(measured)
    for apart in (1, 2, 3, 4):
        for first in range(40 - apart + 1):
            graph.add(Between(first, first + apart, Pose(apart * next(measurements), 0.0, 0.0),
                              np.diag((50.0, 50.0, 50.0)), measured_by))
    graph.solve(20)
    return graph


def test_the_wheels_tell_the_size_of_a_map_that_is_too_large():
    """All that was found on a map that is 2 % too large measures 2 % too much."""
    assert way(0.1, [1.02] * 160).pose(40).x == pytest.approx(40.0, rel=0.002)
    assert way(0.0001, [1.02] * 160).pose(40).x == pytest.approx(40.8, rel=0.002)     # it may not err


def test_the_first_look_tells_the_size_and_that_the_wheels_are_too_small():
    graph = way(0.1, [1.02] * 160, MeasuredBy.FIRST_LOOK)
    assert graph.pose(40).x == pytest.approx(40.8, rel=0.002)
    assert graph.bias.distance == pytest.approx(0.02, abs=0.002)


def test_errors_of_what_was_found_on_the_map_do_not_make_it_smaller():
    """A smaller map would have smaller errors; so errors are told by the size that the map has."""
    noise = np.random.default_rng(3).normal(1.0, 0.03, 160)
    assert way(1.0, noise).pose(40).x == pytest.approx(40.0, rel=0.001)


def test_the_first_look_is_not_untied():
    graph, truth = square(0.05)
    graph.add(closing(truth, 0, 8)._replace(measured_by=MeasuredBy.FIRST_LOOK))
    graph.untie(8)
    before = worst(graph, truth)
    graph.solve(10)
    assert worst(graph, truth) < 0.3 * before


def test_without_measurements_nothing_moves():
    graph = PoseGraph(Pose(1.0, 2.0, 0.5), (0.1, 0.1, 0.1, 0.1), 3.0)
    graph.solve()
    assert graph.pose(0) == Pose(1.0, 2.0, 0.5)


def test_its_steps_may_be_made_one_at_a_time():
    """So the solution of a large graph is spread over packets."""
    graphs = [square(0.05) for _ in range(2)]
    for graph, truth in graphs:
        graph.add(closing(truth, 0, 8))
    graphs[0][0].solve(3)
    for _ in range(3):
        graphs[1][0].solve(1)
    assert graphs[1][0].poses == pytest.approx(graphs[0][0].poses, abs=1e-5)


WALLS = (WallDirection(0.3, 0.01), WallDirection(0.3 - math.pi / 2, 0.01))


def test_walls_that_are_square_keep_a_way_straight():
    wrong = Pose(1.0, 0.0, 0.05)
    plain, held = (PoseGraph(Pose(0.0, 0.0, 0.0), (0.1, 0.1, 0.1, 0.1), 3.0) for _ in range(2))
    for graph in (plain, held):
        for number in range(12):
            if graph is held:
                graph.set_walls(number, WALLS)
            graph.add_node(compose(graph.pose(number), wrong))
            graph.add(Between(number, number + 1, wrong, np.diag((50.0, 50.0, 20.0)), MeasuredBy.WHEELS))
            graph.solve(2)
    assert abs(plain.poses[-1, 1]) > 2.0
    assert abs(held.poses[-1, 1]) < 0.3


def slanting(node):
    """Walls that face anywhere, one at each node."""
    return [WallDirection(0.7 * node * node, 0.01)]


def bent_by_ties(walls, numbers):
    """Return how far (rad) a straight way is bent by ties to neighbours that all err alike; odometry does not."""
    step, wrong = Pose(1.0, 0.0, 0.0), Pose(2.0, 0.0, 0.08)
    by_veer = np.zeros((3, 2))
    by_veer[2, 1] = 1.0
    graph = PoseGraph(Pose(0.0, 0.0, 0.0), (0.03, 0.05, 0.012, 0.1), 3.0, numbers)
    for number in range(12):
        graph.set_walls(number, walls(number))
        graph.add_node(compose(graph.pose(number), step))
        graph.add(Between(number, number + 1, step, np.diag((150.0, 150.0, 150.0)), MeasuredBy.WHEELS, by_veer))
        if number:
            graph.add(Between(number - 1, number + 1, wrong, np.diag((50.0, 50.0, 50.0)), MeasuredBy.LOOK))
    graph.solve(10)
    return abs(graph.pose(12).heading)


def test_where_no_walls_hold_the_headings_odometry_is_trusted_more():
    plain = bent_by_ties(slanting, TRUSTING)
    assert plain > 0.2
    assert bent_by_ties(slanting, WallNumbers()) < 0.3 * plain


@pytest.mark.parametrize("walls", [lambda node: WALLS, lambda node: slanting(node) if node < 4 else []],
                         ids=["square", "few"])
def test_where_walls_hold_them_or_are_too_few_to_tell_a_place_that_was_found_counts_in_full(walls):
    assert bent_by_ties(walls, WallNumbers()) == pytest.approx(bent_by_ties(walls, TRUSTING))


def test_walls_that_are_not_square_change_nothing():
    graph, _ = square(0.05)
    before = graph.poses.copy()
    for node in range(9):
        graph.set_walls(node, [WallDirection(0.7 * node * node, 0.01)])
    graph.solve(3)
    assert graph.poses == pytest.approx(before, abs=1e-6)


def test_the_walls_of_a_node_take_the_place_of_those_before():
    graph, _ = square(0.05)
    before = graph.poses.copy()
    for walls in (WALLS, ()):
        for node in range(9):
            graph.set_walls(node, walls)
    graph.solve(3)
    assert graph.poses == pytest.approx(before, abs=1e-6)

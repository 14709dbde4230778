"""Where the gripper is: the table of the arm sheet, 16, a second way to compute it, and there and back."""

import math
import random

import pytest

from pioneer_control.arm.kinematics import PIONEER_ARM, ArmShape, forward, inverse
from pioneer_control.errors import UsageError

# Angles t1..t5 (deg), position (m), approach: as the sheet prints them.
TABLE = [
    ((0, 0, 0, 0, 0), (0.4797, 0, 0), (1, 0, 0)),
    ((0, 90, 0, 0, 0), (0.0688, 0, 0.4110), (0, 0, 1)),
    ((0, 90, -90, 0, 0), (0.3197, 0, 0.1600), (1, 0, 0)),
    ((90, 0, 0, 0, 0), (0, 0.4797, 0), (0, 1, 0)),
    ((30, 45, -60, 0, -30), (0.3421, 0.1975, -0.0026), (0.6124, 0.3536, -0.7071)),
    ((30, 45, -60, 40, -30), (0.3269, 0.2307, 0.0102), (0.4779, 0.6470, -0.5941)),
    ((0, 80, -90, 0, 0), (0.3437, 0, 0.1140), (0.9848, 0, -0.1736)),
]
QUARTER = math.pi / 2.0


def radians(degrees):
    return tuple(map(math.radians, degrees))


def random_angles(draw, roll=QUARTER):
    return tuple(draw.uniform(-math.pi, math.pi) for _ in range(3)) + (draw.uniform(-roll, roll), draw.uniform(-3, 3))


@pytest.mark.parametrize("degrees, position, approach", TABLE)
def test_the_table_of_the_sheet(degrees, position, approach):
    found = forward(radians(degrees))
    assert found.position == pytest.approx(position, abs=6e-5)
    assert found.approach == pytest.approx(approach, abs=6e-5)


def by_denavit_hartenberg(angles, shape):
    """Return position and approach by the sheet's rows (a, alpha, d, theta), with products of matrices."""
    t1, t2, t3, t4, t5 = angles
    rows = [(shape.base, QUARTER, 0.0, t1), (shape.upper_arm, 0.0, 0.0, t2), (0.0, QUARTER, 0.0, t3 + QUARTER),
            (0.0, -QUARTER, shape.forearm, t4), (0.0, QUARTER, 0.0, t5), (0.0, 0.0, shape.hand, 0.0)]
    frame = [[float(row == column) for column in range(4)] for row in range(4)]
    for a, alpha, d, theta in rows:
        c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        link = [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]]
        frame = [[sum(frame[row][each] * link[each][column] for each in range(4)) for column in range(4)]
                 for row in range(4)]
    return [row[3] for row in frame[:3]], [row[2] for row in frame[:3]]


def test_another_way_gives_the_same():
    draw = random.Random(1)
    for _ in range(500):
        angles, shape = random_angles(draw, math.pi), ArmShape(*(draw.uniform(0.01, 0.5) for _ in range(4)))
        found, (position, approach) = forward(angles, shape), by_denavit_hartenberg(angles, shape)
        assert found.position == pytest.approx(position, abs=1e-12)
        assert found.approach == pytest.approx(approach, abs=1e-12)


def test_up_is_square_to_the_approach_and_turns_with_the_roll():
    draw = random.Random(2)
    for _ in range(200):
        found = forward(random_angles(draw))
        assert sum(a * b for a, b in zip(found.approach, found.up)) == pytest.approx(0.0, abs=1e-12)
        assert math.hypot(math.hypot(*found.up[:2]), found.up[2]) == pytest.approx(1.0)
    assert forward((0, 0, 0, 0, 0)).up == pytest.approx((0, 0, 1))
    assert forward((0, 0, 0, QUARTER, 0)).up == pytest.approx((0, -1, 0), abs=1e-12)


def test_there_and_back():
    """Each solution leads to the place, and the angles that the place was made of are among them."""
    draw = random.Random(3)
    for _ in range(1000):
        angles = random_angles(draw)
        wanted = forward(angles)
        solutions = inverse(wanted.position, wanted.approach)
        assert 1 <= len(solutions) <= 4
        for solution in solutions:
            found = forward(solution)
            assert found.position == pytest.approx(wanted.position, abs=1e-9)
            assert found.approach == pytest.approx(wanted.approach, abs=1e-9)
            assert abs(solution[3]) <= QUARTER + 1e-9
        assert min(max(abs(math.remainder(a - b, 2 * math.pi)) for a, b in zip(solution, angles))
                   for solution in solutions) < 1e-6


@pytest.mark.parametrize("degrees", [row[0] for row in TABLE])
def test_the_table_backwards(degrees):
    found = forward(radians(degrees))
    # the length of the approach does not matter
    solutions = inverse(found.position, tuple(7.0 * value for value in found.approach))
    assert any(solution == pytest.approx(radians(degrees), abs=1e-6) for solution in solutions)


def test_a_place_within_reach_has_four_ways():
    solutions = inverse((0.1, 0.02, 0.1), (0.0, 0.0, -1.0))
    assert len(set(solutions)) == 4
    assert len({round(solution[0], 6) for solution in solutions}) == 2      # to it, and half a turn away
    assert len(inverse((0.3, 0.02, 0.1), (1.0, 0.0, -1.0))) == 2            # too far for the arm on its back


@pytest.mark.parametrize("position, approach, problem", [
    ((0.6, 0.0, 0.0), (1.0, 0.0, 0.0), r"does not reach \(0.600, 0.000, 0.000\) so: its wrist would be 0.418 m"),
    ((0.4798, 0.0, 0.0), (1.0, 0.0, 0.0), "does not reach"),
    ((0.0, 0.0, 0.5), (0.0, 0.0, 1.0), "its wrist would be 0.393 m from the shoulder, and it can be 0.022 to 0.298 m"),
    ((math.nan, 0.0, 0.0), (1.0, 0.0, 0.0), "must be finite"),
    ((0.3, 0.0, 0.0), (math.inf, 0.0, 0.0), "must be finite"),
    ((0.3, 0.0, 0.0), (0.0, 0.0, 0.0), "must be finite"),
])
def test_what_cannot_be(position, approach, problem):
    with pytest.raises(UsageError, match=problem):
        inverse(position, approach)


def test_stretched_out_is_the_end_of_the_reach():
    assert PIONEER_ARM.reach == pytest.approx(0.47971)
    found = forward(inverse((PIONEER_ARM.reach, 0, 0), (1, 0, 0))[0])
    assert found.position == pytest.approx((0.47971, 0, 0), abs=1e-6)

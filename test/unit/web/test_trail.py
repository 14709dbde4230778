"""The way that a robot went: not denser than needed, not longer than told, and never a line across a jump."""

from pioneer_control.web.trail import JUMP, MOST_POINTS, SPACING, Trail


def test_points_are_apart_and_oldest_first():
    trail = Trail()
    for step in range(100):
        trail.go(step * SPACING / 3.9, 0.0)
    gaps = [after[0] - before[0] for before, after in zip(trail.points, trail.points[1:])]
    assert trail.points[0] == [0.0, 0.0] and min(gaps) > SPACING - 0.002 and max(gaps) < 1.3 * SPACING


def test_it_never_grows_beyond_its_length():
    trail = Trail()
    for step in range(3 * MOST_POINTS):
        trail.go(step * SPACING * 1.01, 0.0)
    assert len(trail.points) == MOST_POINTS and trail.points[0][0] > MOST_POINTS * SPACING


def test_a_pose_that_was_set_begins_anew():
    trail = Trail([[0.0, 0.0], [0.5, 0.0]])
    trail.go(0.6, 0.0)
    assert len(trail.points) == 3
    trail.go(0.6 + 1.1 * JUMP, 0.0)
    assert len(trail.points) == 1


def test_a_robot_that_stands_adds_nothing():
    trail = Trail()
    for _ in range(10):
        trail.go(1.0, 1.0)
    assert trail.points == [[1.0, 1.0]]

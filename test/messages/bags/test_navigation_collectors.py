"""What navigation said in a bag: where it believed to be, plans, clouds, goals and their ends, and its map."""

import bag_factory as make
import numpy as np
import pytest
from geometry_msgs.msg import Pose2D, PoseArray, PoseStamped
from nav_msgs.msg import Path

from pioneer_control.bags.navigation_collectors import MOST_CLOUDS, MOST_PLANS, MOST_POSES
from pioneer_control.bags.run import read_run
from pioneer_control.msg import Navigation


def said(at, x=0.0, state="driving", goal=(5.0, 1.0), sure=True, reason=""):
    message = Navigation(state=state, reason=reason, sure=sure, pose=Pose2D(x, 1.0, 0.0),
                         goal=[Pose2D(*goal, 0.0)] if goal else [])
    return "/pioneer/navigation", message, 1000.0 + at


def plan(at, *points):
    poses = [PoseStamped() for _ in points]
    for each, (x, y) in zip(poses, points):
        each.pose.position.x, each.pose.position.y, each.pose.orientation.w = x, y, 1.0
    return "/pioneer/plan", Path(poses=poses), 1000.0 + at


def cloud(at, count):
    message = make.cans(*((0.01 * n, 1.0, 0.0) for n in range(count)))
    for each in message.poses:
        each.orientation.w = 1.0
    return "/pioneer/particlecloud", message, 1000.0 + at


@pytest.fixture
def run_of(tmp_path):
    """Write messages to the bag of a robot that drives, and read its run."""
    def read(*messages, seconds=10):
        driven = [entry for entry in make.driven(seconds=seconds) if not entry[0].endswith("map")]
        given = sorted([*driven, *messages], key=lambda entry: entry[2])
        return read_run(make.write_bag(tmp_path / "run.bag", given))
    return read


def test_without_navigation_there_is_none(run_of):
    assert run_of().navigation is None and not run_of().map_made


def test_where_it_believed_to_be_and_when_it_knew(run_of):
    found = run_of(*(said(0.1 * n, 0.1 * n, sure=n >= 20) for n in range(100))).navigation
    assert found.track.x[-1] == pytest.approx(9.9) and found.track.length == pytest.approx(9.9)
    assert found.sure_from == pytest.approx(1002.0)
    (span,) = found.unsure
    assert (span.begin, span.end) == pytest.approx((1000.0, 1002.0))
    assert found.is_sure(np.array([1001.0, 1003.0])).tolist() == [False, True]


def test_goals_and_what_became_of_them(run_of):
    found = run_of(said(0, state="idle", goal=None), said(1), said(2), said(3, state="reached", goal=None),
                   said(4, goal=(6.0, 1.0)), said(5, goal=(7.0, 1.0)), said(6, state="failed", goal=None),
                   said(7), said(8, state="idle", goal=None), said(9)).navigation
    assert [(goal.x, goal.end) for goal in found.goals] == [
        (5.0, "reached"), (6.0, "replaced"), (7.0, "failed"), (5.0, "cancelled"), (5.0, "under way")]
    assert [(span.begin - 1000.0, span.end - 1000.0) for span in found.states] == [
        (1.0, 3.0), (4.0, 6.0), (7.0, 8.0), (9.0, 9.0)]


def test_goals_that_it_chose_itself_to_make_its_map(run_of):
    found = run_of(said(0, state="idle", goal=None), said(1, reason="exploring: to look round"), said(2),
                   said(3, goal=(6.0, 1.0), reason="exploring: home"), said(4, state="failed", goal=None),
                   said(5, goal=(7.0, 1.0), reason="on the way"), said(6, state="reached", goal=None)).navigation
    assert [(goal.x, goal.end) for goal in found.goals] == [(5.0, "explored"), (6.0, "explored"), (7.0, "reached")]


def test_plans_and_clouds_are_kept_now_and_then_and_the_first_to_a_goal_always(run_of):
    found = run_of(said(0), plan(0.1, (0, 0), (5, 1)), plan(1, (1, 0), (5, 1)), said(2, goal=(6.0, 1.0)),
                   plan(2.1, (2, 0), (6, 1)), plan(3), plan(8, (3, 0), (6, 1)), cloud(1, 200), cloud(2, 3)).navigation
    assert [points[0].tolist() for points in found.plans] == [[0.0, 0.0], [2.0, 0.0], [3.0, 0.0]]
    (poses,) = found.clouds
    assert MOST_POSES / 2 < len(poses) <= MOST_POSES


def test_of_a_long_run_not_more_is_kept(run_of):
    messages = [entry for n in range(3000) for entry in (plan(10.0 * n, (n, 0), (n + 1, 0)), cloud(10.0 * n, 2))]
    found = run_of(said(0), *messages, seconds=1).navigation
    assert MOST_PLANS / 4 < len(found.plans) <= MOST_PLANS and MOST_CLOUDS / 4 < len(found.clouds) <= MOST_CLOUDS
    assert found.plans[-1][0][0] > 2000


def test_places_that_make_no_sense_are_counted_and_left_out(run_of):
    run = run_of(said(0), said(1, x=float("nan")), said(2, goal=(float("inf"), 0.0)), plan(3, (float("nan"), 0)),
                 ("/pioneer/particlecloud", PoseArray(), 1004.0))
    assert "2 messages on /pioneer/navigation" in run.damage and "1 message on /pioneer/plan" in run.damage
    assert np.isfinite(run.navigation.track.x).all() and run.navigation.clouds == run.navigation.plans == ()


def test_a_map_that_is_made_and_one_that_is_only_said_again(run_of):
    small, large = ("/pioneer/map", make.room(4.0, 4.0)), ("/pioneer/map", make.room(5.0, 4.0))
    assert not run_of(said(0), (*small, 1001.0), (*small, 1002.0)).map_made
    run = run_of(said(0), (*small, 1001.0), (*large, 1002.0))
    assert run.map_made and run.map.cells.shape == (82, 102)


def test_the_true_map_is_taken_only_where_there_is_no_other(tmp_path):
    driven = [entry for entry in make.driven() if not entry[0].endswith("map")]
    true = ("/pioneer/truth/map", make.room(5.0, 4.0), 1000.0)
    assert read_run(make.write_bag(tmp_path / "a.bag", [*driven, true])).map.cells.shape == (82, 102)
    both = [*driven, true, ("/pioneer/map", make.room(4.0, 4.0), 1000.0)]
    run = read_run(make.write_bag(tmp_path / "b.bag", both))
    assert run.map.cells.shape == (82, 82) and run.own_frame, "this is no map of the world's frame"
    same = [*driven, true, ("/pioneer/map", make.room(5.0, 4.0), 1000.0)]
    assert not read_run(make.write_bag(tmp_path / "c.bag", same)).own_frame

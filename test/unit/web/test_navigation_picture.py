"""What navigation tells becomes texts of the page: not too often, not too much, and silence is said."""

import math
from types import SimpleNamespace as Of

import pytest

from pioneer_control.web.from_messages import RobotPicture, WorldPicture, shared_name
from pioneer_control.web.navigation_picture import EVERY, LIVES, MOST_POINTS, MOST_POSES, NavigationPicture


def pose2d(x, y, theta=0.0):
    return Of(x=x, y=y, theta=theta)


def state(state="driving", reason="2.0 m to go", sure=True, unsure="", pose=(1.0, 2.0, 0.5), goal=(3.0, 1.5, 0.0)):
    return Of(header=Of(frame_id="map"), state=state, reason=reason, sure=sure, unsure_because=unsure,
              pose=pose2d(*pose), goal=[pose2d(*goal)] if goal else [])


def pose(x, y, heading=0.0):
    return Of(position=Of(x=x, y=y, z=0.0),
              orientation=Of(x=0.0, y=0.0, z=math.sin(heading / 2), w=math.cos(heading / 2)))


def cloud(*poses):
    return Of(poses=[pose(*each) for each in poses])


def path(*points):
    return Of(poses=[Of(pose=pose(*each)) for each in points])


@pytest.fixture
def picture():
    return NavigationPicture(7)


def told(picture, now):
    return dict(picture.changes(now))


def test_without_navigation_nothing_is_told(picture):
    assert told(picture, 0.0) == {} and not picture.lives(0.0)


def test_what_it_does_and_knows(picture):
    picture.take_state(state(), 0.0)
    assert told(picture, 0.0) == {"navigation": {
        "robot": 7, "state": "driving", "reason": "2.0 m to go", "sure": True, "unsure": "", "pose": [1.0, 2.0, 0.5],
        "goal": [3.0, 1.5, 0.0]}}
    assert told(picture, 10.0)["navigation"]["state"] == "silent"


def test_a_change_is_told_once_and_not_too_often(picture):
    picture.take_state(state(), 0.0)
    assert told(picture, 0.0) and not told(picture, 1.0)
    picture.take_state(state(reason="1.9 m to go"), 1.0)
    assert told(picture, 1.0)["navigation"]["reason"] == "1.9 m to go"
    picture.take_state(state(reason="1.8 m to go"), 1.1)
    assert not told(picture, 1.1)
    assert told(picture, 1.0 + EVERY["navigation"])["navigation"]["reason"] == "1.8 m to go"


def test_plan_cloud_and_places(picture):
    picture.take_plan(path((0, 0), (1.006, 0), (1, 1)), 0.0)
    picture.take_cloud(cloud((1, 2, 0.5), (1.1, 2, -0.5)), 0.0)
    picture.take_places(Of(names=["kitchen", "x" * 50], poses=[pose2d(4, 1, 1.57), pose2d(0, 0)]), 0.0)
    found = told(picture, 0.0)
    assert found["plan"] == {"robot": 7, "points": [[0.0, 0.0], [1.01, 0.0], [1.0, 1.0]]}
    assert found["cloud"] == {"robot": 7, "poses": [[1.0, 2.0, 0.5], [1.1, 2.0, -0.5]]}
    assert found["places"]["places"] == [["kitchen", 4.0, 1.0, 1.57], ["x" * 40, 0.0, 0.0, 0.0]]
    picture.take_plan(path(), 0.0)
    assert told(picture, 1.0) == {"plan": {"robot": 7, "points": []}}


def test_of_very_much_some_is_told_with_the_end_of_the_plan(picture):
    picture.take_plan(path(*((n, 0) for n in range(1999))), 0.0)
    picture.take_cloud(cloud(*((n, 0) for n in range(1999))), 0.0)
    found = told(picture, 0.0)
    assert MOST_POINTS / 2 < len(found["plan"]["points"]) <= MOST_POINTS
    assert found["plan"]["points"][-1] == [1998.0, 0.0]
    assert MOST_POSES / 2 < len(found["cloud"]["poses"]) <= MOST_POSES


def test_silence_is_said_and_nothing_old_is_shown(picture):
    picture.take_state(state(), 0.0)
    picture.take_plan(path((0, 0), (1, 0)), 0.0)
    picture.take_cloud(cloud((1, 2)), 0.0)
    picture.take_places(Of(names=["kitchen"], poses=[pose2d(4, 1)]), 0.0)
    told(picture, 0.0)
    assert told(picture, LIVES - 0.1) == {}
    found = told(picture, LIVES)
    assert found["navigation"]["state"] == "silent" and "does it run" in found["navigation"]["reason"]
    assert found["navigation"]["goal"] is None and not found["navigation"]["sure"]
    assert found["plan"]["points"] == found["cloud"]["poses"] == [] and "places" not in found
    picture.take_state(state(), 5.0)
    assert told(picture, 5.0)["navigation"]["state"] == "driving"


@pytest.mark.parametrize("wrong", [
    lambda picture: picture.take_state(state(pose=(math.nan, 0.0, 0.0)), 0.0),
    lambda picture: picture.take_state(state(goal=(math.inf, 0.0, 0.0)), 0.0),
    lambda picture: picture.take_plan(path((0, 0), (math.nan, 0)), 0.0),
    lambda picture: picture.take_cloud(cloud((0, math.inf)), 0.0),
    lambda picture: picture.take_places(Of(names=["a"], poses=[pose2d(0, math.nan)]), 0.0)])
def test_what_is_not_finite_is_refused_and_not_told(picture, wrong):
    with pytest.raises(ValueError, match="not finite"):
        wrong(picture)
    assert told(picture, 0.0) == {}


def test_what_happens_is_news_once(picture):
    picture.take_state(state("idle", "", goal=None), 0.0)
    assert picture.news == []
    picture.take_state(state("driving", "3.0 m to go"), 0.1)
    picture.take_state(state("driving", "2.9 m to go"), 0.2)
    picture.take_state(state("waiting", "I do not know where I am", sure=False, unsure="all looks alike"), 0.3)
    picture.take_state(state("failed", "gave up", sure=True), 0.4)
    picture.take_state(state("driving", "driving"), 0.5)
    assert picture.news == ["navigation: driving: 3.0 m to go", "navigation: waiting: I do not know where I am",
                            "it knows where it is", "navigation: driving"]


# What it means for the robot and the world


def odometry(x, y, frame="odom"):
    return Of(header=Of(frame_id=frame), pose=Of(pose=pose(x, y)),
              twist=Of(twist=Of(linear=Of(x=0.0), angular=Of(z=0.0))))


def goal(x, y):
    return Of(header=Of(frame_id="map"), pose=pose(x, y))


def test_its_goal_is_the_goal_of_the_robot_until_there_is_none():
    robot = RobotPicture(1, "pioneer")
    robot.take("move_base_simple/goal", goal(9, 9), 0.0)
    assert robot.navigation.goal == ("map", 9, 9)
    robot.take("navigation", state(goal=(3.0, 1.5, 0.0)), 1.0)
    assert robot.navigation.goal == ("map", 3.0, 1.5)
    robot.take("move_base_simple/goal", goal(9, 9), 1.1)
    assert robot.navigation.goal == ("map", 3.0, 1.5), "navigation says what becomes of it"
    robot.take("navigation", state("reached", goal=None), 2.0)
    assert robot.navigation.goal is None
    assert [each.text for each in robot.happened] == ["navigation: reached: 2.0 m to go"]


def test_the_hidden_truth_places_nothing():
    robot = RobotPicture(1, "pioneer")
    robot.take("pose", odometry(0, 0), 0.0)
    robot.take("ground_truth", odometry(3, 4, "truth"), 0.0)
    assert robot.simulated and robot.origin is None
    robot.take("ground_truth", odometry(3, 4, "map"), 0.0)
    assert robot.origin == (3, 4, 0)


def test_the_true_map_is_not_the_map_of_navigation():
    kind = "nav_msgs/OccupancyGrid"
    assert shared_name("/map", kind) == shared_name("/pioneer/map", kind) == "map"
    assert shared_name("/pioneer/truth/map", kind) == shared_name("/truth/map", kind) == ""
    assert shared_name("/pioneer/map", "std_msgs/String") == shared_name("/pioneer/costmap", kind) == ""


def transform(x, y):
    return Of(transforms=[Of(header=Of(frame_id="map"), child_frame_id="odom", transform=Of(
        translation=Of(x=x, y=y), rotation=Of(x=0.0, y=0.0, z=0.0, w=1.0)))])


def test_where_it_is_in_the_map_is_told_when_that_moves_it():
    robot, world = RobotPicture(1, "pioneer"), WorldPicture()
    robot.take("pose", odometry(5, 0), 0.0)
    world.take("tf", transform(1.0, 2.0), 0.0)
    assert world.changes([robot]) == [("origins", {"1": [1.0, 2.0, 0.0]})]
    world.take("tf", transform(1.003, 2.0), 0.1)
    assert world.changes([robot]) == []
    world.take("tf", transform(1.006, 2.0), 0.2)
    assert world.changes([robot]) == [("origins", {"1": [1.006, 2.0, 0.0]})], "steps that are too small add up"


def grid(width, height):
    return Of(data=[0] * (width * height), info=Of(width=width, height=height, resolution=0.05, origin=Of(
        position=Of(x=0.0, y=0.0), orientation=Of(x=0.0, y=0.0, z=0.0, w=1.0))))


def test_a_large_map_that_is_made_is_shown_seldom_and_its_newest_state():
    world = WorldPicture(cells_a_second=100.0)
    for now in range(5):        # 400 cells: every 4 s
        world.take("map", grid(20, 20 + now) if now else grid(20, 20), float(now))
        heights = [value["grid"]["height"] for _, value in world.changes([])]
        assert heights == {0: [20], 4: [24]}.get(now, [])
    world.take("map", grid(1, 1), 5.0)
    assert world.changes([]) == []
    world.take("tf", transform(0.0, 0.0), 20.0)
    assert [value["grid"]["height"] for _, value in world.changes([])] == [1], "the last one is not forgotten"

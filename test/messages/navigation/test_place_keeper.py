"""The named places, without a master: requests are handed to the keeper."""

import threading
import time
import types

import pytest
import rospy
from geometry_msgs.msg import Pose2D
from rospy import Time

from pioneer_control.floor_poses import Pose
from pioneer_control.maps.goals_file import read_goals, write_goals
from pioneer_control.navigation.node import place_keeper
from pioneer_control.navigation.node.map_files import load_floor_map
from pioneer_control.navigation.node.navigation_node import NavigationNode
from pioneer_control.srv import SavePlaceRequest


class Told:
    """A topic of rospy's."""

    def __init__(self, *arguments, **options):
        self.messages = []

    def publish(self, message):
        self.messages.append(message)


@pytest.fixture
def keeper(monkeypatch, tmp_path):
    monkeypatch.setattr(rospy, "Publisher", Told)
    monkeypatch.setattr(Time, "now", lambda: Time(7))
    return place_keeper.PlaceKeeper(None, str(tmp_path / "lab.yaml"), "map", lambda: Pose(1.0, 2.0, 0.5))


def test_two_places_that_are_saved_at_once_are_both_kept(keeper, monkeypatch, tmp_path):
    def write_slowly(places, path):
        time.sleep(0.05)
        write_goals(places, path)

    monkeypatch.setattr(place_keeper, "write_goals", write_slowly)
    answers, node = [], types.SimpleNamespace(_lock=threading.RLock())
    serve = NavigationNode._locked(node, keeper.serve)      # as the node does
    threads = [threading.Thread(target=lambda name=name: answers.append(
        serve(SavePlaceRequest(name=name, here=True)))) for name in ("door", "desk")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [each.success for each in answers] == [True, True]
    assert set(keeper.places) == set(read_goals(tmp_path / "lab.goals.yaml")) == {"door", "desk"}
    assert set(keeper._topic.messages[-1].names) == {"door", "desk"}


def keeper_on(floor):
    return place_keeper.PlaceKeeper(floor, "office", "map", lambda: Pose(1.0, 2.0, 0.5))


def test_it_says_where_a_place_is(keeper, tmp_path):
    """Who forgets `here` saves the origin."""
    here, there = (keeper.serve(SavePlaceRequest(name="desk", here=here)).message for here in (True, False))
    file = tmp_path / "lab.goals.yaml"
    assert here == "desk is saved at x 1.00, y 2.00, 29 degrees, in %s" % file
    assert there == "desk is saved at x 0.00, y 0.00, 0 degrees, in %s" % file


def test_a_place_beyond_the_map_is_refused(keeper):
    on_map = keeper_on(load_floor_map("office"))
    answer = on_map.serve(SavePlaceRequest(name="desk", pose=Pose2D(200.0, 3.0, 0.0)))
    assert not answer.success and "(200, 3) lies outside of the map, which has x from" in answer.message
    assert "desk" not in on_map.places
    answer = on_map.serve(SavePlaceRequest(name="desk", pose=Pose2D(2.0, 3.0, 0.0)))
    assert answer.success and "until navigation ends: no file of a map is there to keep it" in answer.message


def test_what_cannot_be_written_is_not_kept(keeper, tmp_path):
    (tmp_path / "lab.goals.yaml").mkdir()
    answer = keeper.serve(SavePlaceRequest(name="door", here=True))
    assert not answer.success and "cannot be written" in answer.message and keeper.places == {}

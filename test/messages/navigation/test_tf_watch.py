"""What navigation hears of tf, without a master: messages are handed to it."""

import math
import types

import pytest
import rospy
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rospy import Time
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from pioneer_control.errors import UsageError
from pioneer_control.navigation.node import tf_watch


class Subscriber:
    """A subscriber of rospy's, to as many publishers as a test says."""

    publishers = 1

    def __init__(self, topic, kind, hear, argument, queue_size):
        self.topic, self.hear, self.argument, self.is_there = topic, hear, argument, True
        self.impl = types.SimpleNamespace(connections=[])

    def get_num_connections(self):
        return self.publishers

    def unregister(self):
        self.is_there = False


@pytest.fixture
def now():
    """Return the ROS time and the real time (s), both for a test to change."""
    return {"ros": 5.0, "real": 1000.0}


@pytest.fixture
def watch(monkeypatch, now):
    monkeypatch.setattr(rospy, "Subscriber", Subscriber)
    monkeypatch.setattr(tf_watch, "monotonic", lambda: now["real"])
    return tf_watch.TfWatch("odom", "base_link", now=lambda: now["ros"])


def tell(watch, who, parent, frame, x, static=False, stamp=5):
    message = TFMessage([TransformStamped(Header(frame_id=parent, stamp=Time(stamp)), frame, Transform(
        Vector3(x, 0.0, 0.0), Quaternion(0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))))])
    message._connection_header = {"callerid": who}
    if static:
        watch._subscribers[1].impl.connections.append(types.SimpleNamespace(callerid_pub=who, done=False))
    watch._hear(message, static)


def test_a_frame_is_where_tf_says(watch):
    tell(watch, "/a", "map", "odom", 2.0)
    tell(watch, "/b", "odom", "camera", 1.0, static=True)
    assert watch.pose("camera", "map") == pytest.approx((2.0, 1.0, math.pi))
    assert watch.trouble() == ""


@pytest.mark.parametrize("back", [3, 30])
def test_when_time_jumps_back_older_transforms_count_no_more(watch, now, back):
    now["ros"] = 100.0
    tell(watch, "/a", "map", "odom", 2.0, stamp=100)
    tell(watch, "/b", "odom", "camera", 1.0, static=True)
    now["ros"] -= back
    tell(watch, "/a", "map", "odom", 3.0, stamp=100)        # who sent it had not heard of the jump
    with pytest.raises(UsageError, match="nobody says where its frame 'odom' is"):
        watch.pose("odom", "map")
    now["real"] += tf_watch.SETTLING
    tell(watch, "/a", "map", "odom", 7.0, stamp=100 - back)
    assert watch.pose("odom", "map").x == pytest.approx(7.0)
    assert watch.pose("camera", "map")[:2] == pytest.approx((7.0, 1.0)), "what is static stays"


def test_a_frame_that_nobody_tells_is_named(watch):
    with pytest.raises(UsageError, match="nobody says where its frame 'camera' is in 'map'"):
        watch.pose("camera", "map")


def test_two_who_tell_of_one_frame_are_named(watch):
    for who in ("/b", "/a"):
        tell(watch, who, "map", "odom", 2.0)
    assert "odom: /a and /b" in watch.trouble()
    with pytest.raises(UsageError, match="nobody knows for sure"):
        watch.pose("odom", "map")


@pytest.mark.parametrize("end", [
    lambda connections: setattr(connections[0], "done", True), lambda connections: connections.clear()])
def test_who_told_a_static_frame_counts_until_it_ends(watch, now, end):
    tell(watch, "/a", "map", "odom", 2.0)
    tell(watch, "/b", "map", "odom", 2.0, static=True)
    now["real"] += 1.0
    assert "odom: /a and /b" in watch.trouble()
    end(watch._subscribers[1].impl.connections)
    assert watch.trouble() == ""


@pytest.mark.parametrize("publishers, stays", [(0, True), (12, True), (13, False)])
def test_a_crowd_is_left(watch, monkeypatch, publishers, stays):
    monkeypatch.setattr(rospy, "loginfo", lambda *words: None)
    subscribers = list(watch._subscribers)
    for who in ("/a", "/b"):
        tell(watch, who, "map", "odom", 2.0)
    monkeypatch.setattr(Subscriber, "publishers", publishers)
    for _ in range(2):
        watch.leave_a_crowd()
    assert [each.is_there for each in subscribers] == [stays, stays]
    assert (watch.trouble() != "") == stays, "what was heard before is forgotten"
    with pytest.raises(UsageError, match="nobody knows for sure" if stays else "more than 12 nodes .* in 'map'"):
        watch.pose("odom", "map")

"""What navigation says of the stamps of a robot's messages, without a master."""

import contextlib
import re
import threading

import pytest
from nav_msgs.msg import Odometry
from rospy import Time
from std_msgs.msg import Header

from pioneer_control.msg import SonarArray
from pioneer_control.navigation.navigator import SLOW_LINE
from pioneer_control.navigation.node import hearing


@pytest.fixture
def hear(monkeypatch):
    """Return what the log says, and how late each message was, of messages with stamps (s) and times of coming (s)."""

    def heard(*messages):
        lines, late, now = [], [], [0.0]
        monkeypatch.setattr(hearing, "monotonic", lambda: now[0])
        monkeypatch.setattr(hearing.rospy, "get_time", lambda: now[0])
        monkeypatch.setattr(hearing.rospy, "logwarn", lambda text, *values: lines.append(text % values))
        robot = hearing.Hearing([0], threading.Lock(), lambda sensed: None)
        for stamp, now[0] in messages:
            robot._hear_sonar(SonarArray(header=Header(stamp=Time.from_sec(stamp)), ranges=[1.0]))
            late.append(round(robot.readiness.late, 6))
        return [line.split(" in ")[0] for line in lines], late

    return heard


@pytest.fixture
def told(hear):
    """Return what the log says, see `hear`."""
    return lambda *messages: hear(*messages)[0]


def test_a_jump_of_time_is_said_once_for_a_while(told):
    assert told((100.0, 10.0), (100.1, 10.1), (90.0, 10.2), (90.1, 10.3), (80.0, 10.4)) == ["time jumps by -10.2 s"]
    assert len(told((100.0, 10.0), (90.0, 10.1), (90.1, 20.2), (80.0, 20.3))) == 2


def test_a_long_jump_is_said_also_just_after_a_short_one(told):
    assert told((500.0, 10.0), (499.7, 10.1), (0.0, 10.2)) == ["time jumps by -0.4 s", "time jumps by -499.8 s"]


def test_steady_stamps_are_no_jump(told):
    assert told(*((100.0 + 0.1 * number, 10.0 + 0.1 * number) for number in range(20))) == []


def test_a_message_is_late_beside_the_quickest_whatever_the_clocks_say(hear):
    assert hear((100.0, 10.0), (100.1, 10.1), (100.2, 10.5), (100.6, 10.6)) == ([], [0.0, 0.0, 0.3, 0.0])


def test_after_a_jump_of_time_nothing_is_late(hear):
    assert hear((100.0, 10.0), (90.0, 10.1), (90.1, 10.2))[1] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("needed, on_the_way", [
    (0.004, 0.004), (0.09, 0.09), (-0.5, SLOW_LINE), (3.0, SLOW_LINE)])
def test_how_long_a_message_is_on_the_way_is_believed_unless_clocks_differ(monkeypatch, needed, on_the_way):
    """Stamps say that it came so long (s) after it was sent."""
    now = [10.0]
    monkeypatch.setattr(hearing.rospy, "get_time", lambda: now[0])
    robot = hearing.Hearing([0], threading.Lock(), lambda sensed: None)
    assert robot.readiness.on_the_way == SLOW_LINE
    for late in (0.0, 0.3, 0.01):
        now[0] += 0.1
        robot._hear_sonar(SonarArray(header=Header(stamp=Time.from_sec(now[0] - needed - late)), ranges=[1.0]))
    assert robot.readiness.on_the_way == pytest.approx(on_the_way)


@pytest.mark.parametrize("goes_on, named", [
    ("pose", "no sonar of the robot for 0.9 s: is it off?"), ("sonar", "no pose of the robot for 0.9 s"),
    ("", "neither sonar nor pose of the robot for 0.9 s"), ("old stamps", "time stands still: .* for 0.9 s")])
def test_what_a_silent_robot_does_not_tell_is_named(monkeypatch, goes_on, named):
    now = [0.0]
    monkeypatch.setattr(hearing, "monotonic", lambda: now[0])
    monkeypatch.setattr(hearing.rospy, "get_time", lambda: now[0])
    robot = hearing.Hearing([0], threading.Lock(), lambda sensed: None)
    for step in range(20):
        now[0] = 0.1 * step
        header = Header(stamp=Time.from_sec(100.0 + (1.0 if step > 10 and goes_on == "old stamps" else now[0])))
        if step <= 10 or goes_on in ("sonar", "old stamps"):
            robot._hear_sonar(SonarArray(header=header, ranges=[1.0]))
        if step <= 10 or goes_on in ("pose", "old stamps"):
            pose = Odometry(header=header)
            pose.pose.pose.orientation.w = 1.0
            robot._hear_pose(pose)
    assert re.match(named, robot.silence(0.9))


@pytest.mark.parametrize("ended", [True, False])
def test_a_closed_topic_is_an_error_only_before_the_end(monkeypatch, ended):
    def answer(message):
        raise hearing.rospy.ROSException("publish() to a closed topic")

    monkeypatch.setattr(hearing.rospy, "is_shutdown", lambda: ended)
    robot = hearing.Hearing([0], threading.Lock(), lambda sensed: None)
    with contextlib.nullcontext() if ended else pytest.raises(hearing.rospy.ROSException):
        robot._take(None, answer)

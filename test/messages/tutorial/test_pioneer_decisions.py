"""The class Pioneer without a master: what it decides depends on the messages alone, what it commands also on when they come."""

import random
import threading
import time

import pytest
import rospy
from geometry_msgs.msg import Point32, Polygon, Pose2D
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry

from pioneer_control.errors import NoAnswerError, RefusedError, UsageError
from pioneer_control.message_values import quaternion_of
from pioneer_control.msg import MotorState, RobotInfo, SonarArray
from pioneer_control.robots import find_model
from pioneer_control.tutorial import pioneer
from pioneer_control.tutorial.pioneer import Pioneer, WanderEnd

LIMIT = 40.0        # s: generous; nothing waits that long
FIRST = 1_700_000_000
STEP = 100_000_001  # ns
DURATION = 3.0      # s: of 30 sonar messages
MODEL = find_model("p3dx-sh")
STOP = (0.0, 0.0)


class Graph:
    """Stands in for rospy: keeps what is published, and hands out what a test says that others publish."""

    def __init__(self):
        self.published, self.callbacks, self.queues = [], {}, {}
        self.changed = threading.Condition()

    def publisher(self, name, kind, queue_size):
        graph = self

        class Publisher:
            resolved_name = "/" + name

            def get_num_connections(self):
                return 1

            def publish(self, message):
                with graph.changed:
                    graph.published.append((name, message))
                    graph.changed.notify_all()

        self.queues[name] = queue_size
        return Publisher()

    def subscriber(self, name, kind, callback, queue_size=None):
        self.callbacks[name] = callback
        self.queues[name] = queue_size

    def hand_out(self, name, message):
        self.callbacks["r/" + name](message)

    def of(self, name):
        return [message for topic, message in self.published if topic == "r/" + name]

    def wait(self, condition):
        with self.changed:
            assert self.changed.wait_for(condition, LIMIT)

    def commands(self):
        return [(each.linear.x, each.angular.z) for each in self.of("cmd_vel")]

    def log(self):
        """What is to be the same whenever the same messages come."""
        return [(str(each.header.stamp), each.wander, each.seed, each.speed, each.linear, each.angular, each.reason) for each in self.of("decision")]


@pytest.fixture(scope="module")
def ros():
    """rospy's own, as far as Pioneer needs it, without a node."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pioneer.rospy, "on_shutdown", lambda hook: None)
        patch.setattr(pioneer.rospy, "is_shutdown", lambda: False)
        patch.setattr(pioneer.rospy, "loginfo", lambda *_: None)
        rospy.rostime.set_rostime_initialized(True)
        rospy.rostime.switch_to_wallclock()
        yield patch


@pytest.fixture
def started(ros):
    """Makes a graph and a Pioneer "r" in it that knows its robot, whose motors are on."""
    robots = []

    def start(**more):
        graph = Graph()
        ros.setattr(pioneer.rospy, "Publisher", graph.publisher)
        ros.setattr(pioneer.rospy, "Subscriber", graph.subscriber)
        robot = Pioneer("r", **{"seed": 4, **more})
        robots.append(robot)
        graph.hand_out("robot_info", RobotInfo(
            sonar_numbers=[each.number for each in MODEL.sonar], sonar_poses=[Pose2D(each.x, each.y, each.heading) for each in MODEL.sonar],
            footprint=Polygon([Point32(x, y, 0) for x, y in MODEL.outline(False)])))
        graph.hand_out("motor_state", MotorState(1))
        return graph, robot

    yield start
    for robot in robots:
        robot.close()


def stamp(number):
    return rospy.Time(FIRST, number * STEP)


def messages(count=32, seed=1):
    """A robot that lives: (pose, sonar) for each packet. The last is beyond DURATION."""
    chance, heading, packets = random.Random(seed), 0.0, []
    for number in range(count):
        heading += chance.uniform(-0.04, 0.04)
        ranges = [chance.uniform(0.6, 5.0) for _ in range(16)]
        pose, sonar = Odometry(), SonarArray(ranges=ranges, ranges_count=16)
        pose.header.stamp = sonar.header.stamp = stamp(number)
        pose.pose.pose.orientation.z, pose.pose.pose.orientation.w = quaternion_of(heading)[2:]
        packets.append((pose, sonar))
    return packets


def wander_on(graph, robot, packets, **more):
    """All of it there before the wander begins: the log."""
    for pose, sonar in packets:
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)
    assert robot.wander(DURATION, **more) is WanderEnd.TIME_UP
    robot.close()
    return graph.log()


@pytest.fixture(scope="module")
def packets():
    return messages()


@pytest.fixture
def wanted(started, packets):
    """The log of a run in which every message is there before the first is looked at."""
    log = wander_on(*started(begin_at=[stamp(0).to_sec()]), packets)
    assert [each[0] for each in log] == [str(stamp(number)) for number in range(30)] and len({each[4:] for each in log}) > 4
    return log


def run_beside(graph, robot, feed):
    """Wander while `feed` hands out messages: how it ended, and the log."""
    ends = []
    program = threading.Thread(target=lambda: ends.append(robot.wander(DURATION)), daemon=True)
    program.start()
    feed()
    program.join(LIMIT)
    robot.close()
    assert ends, "the wander does not end"
    return ends[0], graph.log()


def test_one_decision_for_each_sonar_message_by_queues_that_lose_none(started, packets, wanted):
    graph, _ = started()
    assert {name: size for name, size in graph.queues.items() if not size} == {"r/pose": None, "r/sonar": None, "r/decision": 0}
    assert [each[1:4] for each in wanted] == [(1, 4, 0.1)] * 30
    assert wander_on(*started(begin_at=[stamp(0).to_sec()]), messages(seed=2)) != wanted


def test_message_by_message_as_live(started, packets, wanted):
    graph, robot = started(begin_at=[stamp(0).to_sec()])

    def feed():
        for number, (pose, sonar) in enumerate(packets):
            graph.wait(lambda: len(graph.of("decision")) >= min(number, 30))
            graph.hand_out("pose", pose)
            graph.hand_out("sonar", sonar)

    assert run_beside(graph, robot, feed) == (WanderEnd.TIME_UP, wanted)
    told = [each[4:6] for each in wanted]
    assert [each for each in graph.commands() if each != STOP] == [each for each in told if each != STOP] and graph.commands()[-1] == STOP


def test_only_the_newest_decision_is_commanded_after_a_hold_up(started, packets, wanted):
    graph, robot = started(begin_at=[stamp(0).to_sec()])
    given = packets[:20]
    for pose, sonar in given:
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)

    def feed():
        graph.wait(lambda: len(graph.of("decision")) == 20)
        first.extend(graph.commands())
        for pose, sonar in packets[20:]:
            graph.hand_out("sonar", sonar)
            graph.hand_out("pose", pose)

    first = []
    assert run_beside(graph, robot, feed) == (WanderEnd.TIME_UP, wanted)
    assert first == [wanted[19][4:6]]


@settings(max_examples=25)
@given(order=st.permutations(["pose"] * 32 + ["sonar"] * 32), waits=st.sets(st.integers(0, 63), max_size=8))
def test_whatever_the_timing_the_log_is_the_same(started, packets, wanted, order, waits):
    """The topics interleaved in any way, and the feeder held up until all that can be decided on is decided."""
    graph, robot = started(begin_at=[stamp(0).to_sec()])

    def feed():
        sent = {"pose": 0, "sonar": 0}
        for place, topic in enumerate(order):
            graph.hand_out(topic, packets[sent[topic]][topic == "sonar"])
            sent[topic] += 1
            if place in waits:
                graph.wait(lambda: len(graph.of("decision")) >= min(30, *sent.values()))

    assert run_beside(graph, robot, feed) == (WanderEnd.TIME_UP, wanted)


def test_old_data_stop_the_robot_and_are_not_remembered(started, packets, wanted):
    graph, robot = started(begin_at=[stamp(0).to_sec()])

    def feed():
        for number, (pose, sonar) in enumerate(packets):
            graph.hand_out("pose", pose)
            graph.hand_out("sonar", sonar)
            if number == 12:
                graph.wait(lambda: len(graph.of("decision")) == 13 and graph.commands()[-1] == STOP)

    assert wanted[12][4:6] != STOP
    assert run_beside(graph, robot, feed) == (WanderEnd.TIME_UP, wanted)


def test_nobody_drives_on_while_time_stands_still(started, packets):
    """A live driver under a paused clock: news come, but their stamps do not move on."""
    graph, robot = started()

    def feed():
        pose, sonar = packets[0]
        give_up_at = time.monotonic() + LIMIT
        while not (graph.commands() and graph.commands()[-1] == STOP):
            graph.hand_out("pose", pose)
            graph.hand_out("sonar", sonar)
            time.sleep(0.02)
            assert time.monotonic() < give_up_at, "it drives on"
        pose.header.stamp = sonar.header.stamp = stamp(40)
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)

    assert run_beside(graph, robot, feed)[0] is WanderEnd.TIME_UP
    assert any(each != STOP for each in graph.commands())


def test_a_robot_that_falls_silent_ends_the_wander_in_time(started, packets):
    """By the time of ROS, and nothing drives meanwhile."""
    graph, robot = started(begin_at=[stamp(0).to_sec()])
    for pose, sonar in packets[:5]:
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)
    assert robot.wander(1.0) is WanderEnd.TIME_UP
    robot.close()
    assert len(graph.log()) == 5 and graph.commands()[-1] == STOP


def test_an_own_program_begins_with_what_comes_next(started, packets):
    graph, robot = started()
    for pose, sonar in packets[:5]:
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)

    def feed():
        while robot._seen:      # the wander has not begun
            time.sleep(0.001)
        for pose, sonar in messages(40)[5:]:
            graph.hand_out("pose", pose)
            graph.hand_out("sonar", sonar)

    end, log = run_beside(graph, robot, feed)
    assert end is WanderEnd.TIME_UP and [each[0] for each in log] == [str(stamp(number)) for number in range(5, 35)]


def test_before_the_robot_has_told_what_it_is_nothing_is_decided(started):
    graph, robot = started()
    with pytest.raises(NoAnswerError):
        robot.wander(DURATION)
    assert graph.log() == graph.commands() == []


def test_motors_that_are_off_end_the_wander(started, packets):
    graph, robot = started(begin_at=[stamp(0).to_sec()])
    graph.hand_out("motor_state", MotorState(0))
    with pytest.raises(RefusedError):
        wander_on(graph, robot, packets[:5])
    robot.close()
    assert graph.commands() == []


def test_a_second_wander_of_a_re_run_loses_nothing_though_it_comes_late(started):
    graph, robot = started(begin_at=[stamp(0).to_sec(), stamp(35).to_sec()], end_at=[stamp(12).to_sec(), stamp(40).to_sec()])
    for pose, sonar in messages(80):
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)
    assert robot.wander(DURATION) is WanderEnd.AT_CAN
    assert robot.wander(DURATION) is WanderEnd.AT_CAN
    robot.close()
    assert [(each[0], each[1]) for each in graph.log()] == [
        (str(stamp(number)), 1) for number in range(13)] + [(str(stamp(number)), 2) for number in range(35, 41)]


@pytest.mark.parametrize("seed", ["four", 1.5, 2 ** 63, -2 ** 63 - 1])
def test_a_seed_that_no_message_can_hold_is_refused(started, seed):
    with pytest.raises(UsageError, match="seed is .*whole number"):
        started(seed=seed)


@pytest.mark.parametrize("seed", [0, -2 ** 63, 2 ** 63 - 1, True])
def test_any_other_seed_will_do(started, packets, seed):
    log = wander_on(*started(seed=seed, begin_at=[stamp(0).to_sec()]), packets[:2] + messages(40)[38:])
    assert {each[2] for each in log} == {seed}


def test_time_that_passed_is_the_shorter_of_real_and_of_ros_time(ros, monkeypatch):
    now = {"real": 5.0, "ros": 100.0}
    monkeypatch.setattr(pioneer.time, "monotonic", lambda: now["real"])
    monkeypatch.setattr(pioneer.rospy, "get_time", lambda: now["ros"])
    passed, told = pioneer.Passed(), []
    for real, ros_time in ((6.0, 110.0), (7.0, 110.0), (20.0, 110.0), (20.0, 113.0), (21.0, 3.0), (30.0, 4.0)):
        now.update(real=real, ros=ros_time)
        told.append(passed())
    assert told == [1.0, 2.0, 10.0, 13.0, 13.0, 14.0]


def test_no_clock_is_among_what_is_missing(started, monkeypatch):
    graph, robot = started()
    assert "/clock" not in robot._missing()
    monkeypatch.setattr(pioneer.rospy.rostime, "is_wallclock", lambda: False)
    monkeypatch.setattr(pioneer.rospy, "get_time", lambda: 0.0)
    assert robot._missing()[0] == "/clock"

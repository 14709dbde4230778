"""The class Pioneer without a master. Its decisions depend on the messages alone. Its commands also depend on when the
messages come.
"""

import random
import socket
import threading
import time

import pytest
import rospy
from geometry_msgs.msg import Point32, Polygon, Pose2D
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from pioneer_control.errors import NoAnswerError, RefusedError, UnknownModelError, UsageError
from pioneer_control.message_values import GripStatus, LiftStatus, quaternion_of
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState, RobotInfo, SonarArray, Stall
from pioneer_control.robots import find_model
from pioneer_control.tutorial import commander, following, pioneer, reports
from pioneer_control.tutorial.getting_ready import missing_topics
from pioneer_control.tutorial.pioneer import Pioneer, WanderEnd

LIMIT = 40.0        # s: generous; nothing waits that long
FIRST = 1_700_000_000
STEP = 100_000_001  # ns
DURATION = 3.0      # s: of 30 sonar messages
MODEL = find_model("p3dx-sh")
STOP = (0.0, 0.0)


class Graph:
    """A stand-in for rospy. It keeps what is published, and delivers what a test publishes for others."""

    def __init__(self):
        self.published, self.callbacks, self.queues, self.log_lines = [], {}, {}, []
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

    def said(self, level):
        """A stand-in for rospy.loginfo and the like."""
        return lambda text, *values: self.log_lines.append((level, text % values if values else text))

    def lines(self):
        return [text for _, text in self.log_lines]

    def of(self, name):
        return [message for topic, message in self.published if topic == "r/" + name]

    def wait(self, condition):
        with self.changed:
            assert self.changed.wait_for(condition, LIMIT)

    def commands(self):
        return [(each.linear.x, each.angular.z) for each in self.of("cmd_vel")]

    def log(self):
        """Return what must be the same whenever the same messages come."""
        return [
            (str(each.header.stamp), each.wander, each.seed, each.speed, each.linear, each.angular, each.reason)
            for each in self.of("decision")]


@pytest.fixture(scope="module")
def ros():
    """Replace the parts of rospy that Pioneer needs, without a node."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pioneer.rospy, "on_shutdown", lambda hook: None)
        patch.setattr(pioneer.rospy, "is_shutdown", lambda: False)
        rospy.rostime.set_rostime_initialized(True)
        rospy.rostime.switch_to_wallclock()
        yield patch


@pytest.fixture
def started(ros):
    """Make a graph and a Pioneer "r" in it, whose motors are on. With `info`, the Pioneer receives robot_info. Without
    it, `gripper` is an argument of the Pioneer.
    """
    robots = []

    def start(info=True, gripper=False, **more):
        graph = Graph()
        for level in ("loginfo", "logwarn"):
            ros.setattr(pioneer.rospy, level, graph.said(level))
        ros.setattr(pioneer.rospy, "Publisher", graph.publisher)
        ros.setattr(pioneer.rospy, "Subscriber", graph.subscriber)
        robot = Pioneer("r", **{"seed": 4, **({} if info else {"gripper": gripper}), **more})
        robots.append(robot)
        if info:
            graph.hand_out("robot_info", RobotInfo(
                has_gripper=gripper, sonar_numbers=[each.number for each in MODEL.sonar],
                sonar_poses=[Pose2D(each.x, each.y, each.heading) for each in MODEL.sonar],
                footprint=Polygon([Point32(x, y, 0) for x, y in MODEL.outline(False)])))
        graph.hand_out("motor_state", MotorState(1))
        return graph, robot

    yield start
    for robot in robots:
        robot.close()


def stamp(number):
    return rospy.Time(FIRST, number * STEP)


def messages(count=32, seed=1):
    """Return (pose, sonar) for each packet of a robot with random headings and ranges. With 32 packets, the last one is
    later than DURATION.
    """
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
    """Return the log of a wander for which all messages are there before it begins."""
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
    """Return the log of a run in which every message is there before the first one is used."""
    log = wander_on(*started(begin_at=[stamp(0).to_sec()]), packets)
    assert [each[0] for each in log] == [str(stamp(number)) for number in range(30)]
    assert len({each[4:] for each in log}) > 4
    return log


def run_beside(graph, robot, feed):
    """Wander while `feed` delivers messages. Returns how it ended, and the log."""
    ends = []
    program = threading.Thread(target=lambda: ends.append(robot.wander(DURATION)), daemon=True)
    program.start()
    feed()
    program.join(LIMIT)
    robot.close()
    assert ends, "the wander does not end"
    return ends[0], graph.log()


def test_a_program_that_is_no_node_is_told_how_to_become_one(ros):
    rospy.rostime.set_rostime_initialized(False)
    try:
        with pytest.raises(UsageError, match=r'call init_node\("my_robot"\), from pioneer_control.ros_node'):
            Pioneer("r")
    finally:
        rospy.rostime.set_rostime_initialized(True)


@pytest.mark.parametrize("namespace", ["my robot", "1a", "a//b"])
def test_a_name_that_ros_does_not_know_is_refused(ros, namespace):
    with pytest.raises(UsageError, match="the namespace of the robot is '%s': give letters" % namespace):
        Pioneer(namespace)


def test_one_decision_for_each_sonar_message_by_queues_that_lose_none(started, packets, wanted):
    graph, _ = started()
    unbounded = {name: size for name, size in graph.queues.items() if not size}
    assert unbounded == {"r/pose": None, "r/sonar": None, "r/stall": None, "r/decision": 0}
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
    assert [each for each in graph.commands() if each != STOP] == [each for each in told if each != STOP]
    assert graph.commands()[-1] == STOP


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
    """The topics are interleaved in any way. At some places, the feeder waits until all decisions that are possible
    have been made.
    """
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
    """A live driver under a paused clock: messages come, but their stamps do not advance."""
    graph, robot = started()

    def feed():
        pose, sonar = messages(1)[0]
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
    """The wander ends when its duration in ROS time is over. Its last command is a stop."""
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
        while robot._reports.sights:      # the wander has not begun
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
    begin_at, end_at = [stamp(0).to_sec(), stamp(35).to_sec()], [stamp(12).to_sec(), stamp(40).to_sec()]
    graph, robot = started(begin_at=begin_at, end_at=end_at)
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
    passed, told = reports.Stopwatch(), []
    for real, ros_time in ((6.0, 110.0), (7.0, 110.0), (20.0, 110.0), (20.0, 113.0), (21.0, 3.0), (30.0, 4.0)):
        now.update(real=real, ros=ros_time)
        told.append(passed())
    assert told == [1.0, 2.0, 10.0, 13.0, 13.0, 14.0]


def test_no_clock_is_among_what_is_missing(started, monkeypatch):
    graph, robot = started()
    assert "/clock" not in missing_topics("r/", robot._reports, robot._commander)
    monkeypatch.setattr(pioneer.rospy.rostime, "is_wallclock", lambda: False)
    monkeypatch.setattr(pioneer.rospy, "get_time", lambda: 0.0)
    assert missing_topics("r/", robot._reports, robot._commander)[0] == "/clock"


# A driver that does not tell what robot it drives

def test_without_robot_info_it_says_what_is_missing_and_what_stands_in_for_it(started, packets):
    graph, robot = started(info=False)
    for topic, message in zip(("pose", "sonar"), packets[0]):
        graph.hand_out(topic, message)
    with pytest.raises(NoAnswerError) as error:
        robot.wait_until_ready(0.05)
    assert str(error.value).startswith("after 0 s still no r/robot_info. A driver runs")
    assert "_model:=p3dx-sh" in str(error.value)


def test_with_a_model_it_decides_as_with_robot_info(started, packets, monkeypatch):
    monkeypatch.setattr(commander, "listeners", lambda timeout: {})
    graph, robot = started(info=False, model="p3dx-sh", begin_at=[stamp(0).to_sec()])
    for topic, message in zip(("pose", "sonar"), packets[0]):
        graph.hand_out(topic, message)
    robot.wait_until_ready(0.05)
    assert not robot.has_gripper
    tips = max(x for x, _ in MODEL.outline(True))
    assert robot.snapshot().robot.outline.front == tips, "a gripper that may be there takes room"
    assert len(wander_on(graph, robot, packets[1:])) == 30


def test_what_the_robot_says_of_itself_counts_more_than_the_model(started, packets):
    graph, robot = started(model="amigo-sh")
    for topic, message in zip(("pose", "sonar"), packets[0]):
        graph.hand_out(topic, message)
    assert len(robot.snapshot().robot.transducers) == 16


def test_a_model_that_nobody_knows_is_said_before_anything_is_advertised(started):
    with pytest.raises(UnknownModelError, match="p3dx"):
        started(model="p3xd-sh")


def test_a_driver_without_a_link_is_told_from_one_that_does_not_run(started):
    graph, robot = started(info=False)
    with pytest.raises(NoAnswerError, match="A driver listens, but has told nothing of its robot. Has it a link"):
        robot.wait_until_ready(0.05)


# A master that hangs

def test_a_master_that_hangs_holds_up_neither_the_start_nor_what_is_heard(started, packets, monkeypatch):
    graph, robot = started()
    for topic, message in zip(("pose", "sonar"), packets[0]):
        graph.hand_out(topic, message)
    monkeypatch.setattr(pioneer, "LISTENERS_TIMEOUT", 1.0)
    with socket.socket() as hanging:
        hanging.bind(("localhost", 0))
        hanging.listen(5)
        monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:%d" % hanging.getsockname()[1])
        starting = threading.Thread(target=robot.wait_until_ready, daemon=True)
        starting.start()
        hanging.accept()        # it asks
        graph.hand_out("motor_state", MotorState(0))
        assert starting.is_alive() and not robot._reports.heard.motors, "what is heard waited for the master"
        starting.join(LIMIT)
        assert not starting.is_alive()


# Why the motors are off

def why_it_does_not_drive(graph, robot):
    graph.hand_out("motor_state", MotorState(0))
    with pytest.raises(RefusedError) as error:
        robot.drive(0.1, 0.0)
    return str(error.value)


def hear_first_packet(graph, packets):
    for topic, message in zip(("pose", "sonar"), packets[0]):
        graph.hand_out(topic, message)


def test_a_pressed_stop_button_is_named(started, packets):
    graph, robot = started()
    hear_first_packet(graph, packets)
    graph.hand_out("e_stop", Bool(True))
    assert "its STOP button is pressed" in why_it_does_not_drive(graph, robot)


def test_a_link_that_is_down_is_named_and_no_stop_button(started, packets, monkeypatch):
    graph, robot = started()
    hear_first_packet(graph, packets)
    now = time.monotonic()
    monkeypatch.setattr(pioneer.time, "monotonic", lambda: now + 3.0)
    why = why_it_does_not_drive(graph, robot)
    assert "the link to the robot is down, it told nothing for 3.0 s" in why and "STOP" not in why


def test_a_link_that_was_down_is_named_and_no_stop_button(started, packets, monkeypatch):
    graph, robot = started()
    hear_first_packet(graph, packets)
    now = time.monotonic()
    monkeypatch.setattr(pioneer.time, "monotonic", lambda: now + 3.0)
    graph.hand_out("motor_state", MotorState(0))
    hear_first_packet(graph, packets[1:])
    why = why_it_does_not_drive(graph, robot)
    assert "the link to the robot was down for 3.0 s" in why and "STOP" not in why
    graph.hand_out("motor_state", MotorState(1))
    assert "the link" not in why_it_does_not_drive(graph, robot), "that was before somebody switched them on again"


def test_nothing_known_it_asks_for_the_stop_button(started, packets):
    graph, robot = started()
    hear_first_packet(graph, packets)
    assert "was its STOP button pressed?" in why_it_does_not_drive(graph, robot)


# Stalls, the way, and what is told

def test_a_stall_stops_the_wander_and_is_counted_and_told(started):
    graph, robot = started(begin_at=[stamp(0).to_sec()])
    for number, (pose, sonar) in enumerate(messages()):
        stalled = 5 <= number < 8
        graph.hand_out("stall", Stall(sonar.header, stalled, stalled))
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", sonar)
    assert robot.wander(DURATION) is WanderEnd.TIME_UP
    robot.close()
    assert [number for number, each in enumerate(graph.log()) if "wheels stall" in each[6]] == list(range(5, 17))
    assert robot.stalls == 1


def test_how_far_it_went_is_the_sum_of_its_steps_without_a_reset(started):
    graph, robot = started()
    for x, y in ((1.0, 1.0), (1.2, 1.0), (1.2, 1.1), (0.0, 0.0), (0.1, 0.0)):
        pose = Odometry()
        pose.pose.pose.position.x, pose.pose.pose.position.y = x, y
        graph.hand_out("pose", pose)
    assert robot.driven == pytest.approx(0.4)


def test_each_kind_of_reason_is_told_when_it_begins_and_again_while_it_lasts(started, monkeypatch):
    graph, _ = started()
    narrator, now = following.Narrator(), time.monotonic()
    reasons = (
        (0, "driving: 3 m"), (1, "driving: 2 m"), (2, "halting: x"), (3, "driving: 1 m"), (19, "driving: 5 m"))
    for later, reason in reasons:
        monkeypatch.setattr(following.time, "monotonic", lambda: now + later)
        narrator.tell(reason)
    assert graph.lines() == ["driving: 3 m", "halting: x", "driving: 1 m", "driving: 5 m"]


# The gripper

HOLDING = GripperState(GripState(GripStatus.CLOSED, 0, True, True, True, True), LiftState(LiftStatus.IDLE, 0, 1.0))


def holding(started, packets, **room_behind):
    """Return a robot that holds something. Its sonars see five metres in all directions, unless the test sets other
    ranges.
    """
    graph, robot = started(gripper=True)
    hear_first_packet(graph, packets)
    ranges = [5.0] * 16
    for name, distance in room_behind.items():
        ranges[int(name[1:])] = distance
    graph.hand_out("sonar", SonarArray(packets[1][1].header, 16, ranges))
    graph.hand_out("gripper_state", HOLDING)
    return graph, robot


def test_what_is_held_already_is_neither_put_down_nor_called_picked(started, packets):
    graph, robot = holding(started, packets)
    assert robot.holding and robot.pick()
    assert graph.lines() == ["no pick: an object is held already"] and graph.of("gripper_control") == []


def test_nothing_is_put_down_where_it_could_not_be_left(started, packets):
    graph, robot = holding(started, packets, s11=0.3, s12=0.3)
    assert not robot.put_down()
    assert graph.lines() == ["keeps what it holds: sonars see no room behind, to leave it"]
    assert graph.of("gripper_control") == []


def test_it_backs_away_from_what_it_put_down(started, packets):
    graph, robot = holding(started, packets)
    ended = []
    program = threading.Thread(target=lambda: ended.append((robot.put_down(), robot.wander(DURATION))), daemon=True)
    program.start()
    graph.wait(lambda: graph.of("gripper_control"))
    put_down = GripperState(GripState(GripStatus.OPEN, 0, True, True, False, False), LiftState(LiftStatus.IDLE, 0, 0.0))
    graph.hand_out("gripper_state", put_down)
    feed = iter(messages(2000)[100:])
    while program.is_alive():
        pose, sonar = next(feed)
        graph.hand_out("pose", pose)
        graph.hand_out("sonar", SonarArray(sonar.header, 16, [5.0] * 16))
        time.sleep(0.002)
    assert ended == [(True, WanderEnd.TIME_UP)]
    graph.wait(lambda: graph.of("decision"))
    assert graph.of("decision")[0].reason.startswith("backing off: ")


def test_nothing_held_nothing_put_down(started, packets):
    graph, robot = started(gripper=True)
    hear_first_packet(graph, packets)
    assert not robot.put_down() and graph.of("gripper_control") == []


def test_a_step_of_the_gripper_fails_loudly_when_the_link_is_down(started, packets, monkeypatch):
    graph, robot = holding(started, packets)
    monkeypatch.setattr(pioneer, "STEP_TIMEOUT", 0.0)
    monkeypatch.setattr(pioneer, "SILENCE", 0.0)
    monkeypatch.setattr(reports, "LINK_LOST", 0.0)
    with pytest.raises(NoAnswerError, match="the gripper did not open: the link to the robot is down"):
        robot.gripper_open()

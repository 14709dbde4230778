"""Which topics are advertised for which robot. No message is made for a topic without a subscriber."""

import dataclasses
import math
import threading
import time
from time import monotonic

import pytest
import rospy

from pioneer_control import p2os
from pioneer_control.client import PacketReceived
from pioneer_control.driver import conversions, prompt, publications
from pioneer_control.driver.parameters import DriverParameters

from robot_reports import (
    DRIVING, GRIPPER_SWITCHES, GYRO, IO, OLD, STALLED, STATE, identity_of, packet_of, received, state_of)

ALWAYS = {"pose", "/tf", "motor_state", "e_stop", "stall", "battery_state", "battery", "dio", "aio", "robot_info"}
SONAR = {"sonar", "sonar_ranges", "sonar_points", "/tf_static"}
LIMIT = 30.0        # s: generous; nothing waits that long


class Publisher:
    """A publisher whose number of subscribers the test sets."""

    def __init__(self, name, message_class, subscriber_listener, queue_size, latch=False, tcp_nodelay=False):
        self.name, self.message_class, self.latch, self.tcp_nodelay = name, message_class, latch, tcp_nodelay
        self.listener, self.listeners = subscriber_listener, 0
        self.published = []
        Publisher.all[name] = self

    def get_num_connections(self):
        return self.listeners

    def publish(self, message):
        assert isinstance(message, (self.message_class, prompt.PromptMessage))
        self.published.append(received(message, self.message_class))    # it is written at once

    def unregister(self):
        del Publisher.all[self.name]


@pytest.fixture
def topics(monkeypatch):
    """Return the publishers that are advertised, by name."""
    Publisher.all = {}
    monkeypatch.setattr(publications.rospy, "Publisher", Publisher)
    monkeypatch.setattr(publications.rospy.Time, "now", lambda: rospy.Time(1000))
    monkeypatch.setattr(publications, "ros_time", lambda: 1000.0)
    return Publisher.all


@pytest.fixture
def requested():
    return []


@pytest.fixture
def driver(topics, requested):
    return publications.Publications(DriverParameters(), lambda kind, on: requested.append((kind, on)))


def listen(topics, *names):
    for name in names or topics:
        topics[name].listeners = 1
        topics[name].listener.peer_subscribe(name, None, None)


def leave(topic):
    topic.listeners = 0
    topic.listener.peer_unsubscribe(topic.name, 0)


def test_no_message_is_held_back_until_the_one_before_is_acknowledged(driver):
    driver.identity(identity_of("p3dx-sh"))
    assert all(publisher.tcp_nodelay for publisher in Publisher.all.values())


def test_the_pose_leaves_a_little_before_the_other_messages_of_its_packet(driver, topics, monkeypatch):
    waits = []

    def sleep(seconds):
        waits.append((seconds, {name for name, topic in topics.items() if topic.published}))

    monkeypatch.setattr(publications, "sleep", sleep)
    listen(topics)
    driver.state(STATE)
    assert waits == [(prompt.POSE_AHEAD, {"pose"})]
    assert topics["/tf"].published


def test_it_closes_while_somebody_waits_for_a_master_that_hangs(topics, monkeypatch):
    driver = publications.Publications(DriverParameters(), lambda kind, on: None)
    hangs, answers, closed = threading.Event(), threading.Event(), threading.Event()

    def advertise(*args, **options):
        hangs.set()
        answers.wait()
        return Publisher(*args, **options)

    def close():
        driver.close()
        closed.set()

    monkeypatch.setattr(publications.rospy, "Publisher", advertise)
    welcome = threading.Thread(target=driver.identity, args=(identity_of("p3dx-sh"),), daemon=True)
    welcome.start()
    assert hangs.wait(LIMIT)
    threading.Thread(target=close, daemon=True).start()
    in_time = closed.wait(LIMIT)
    answers.set()
    welcome.join(LIMIT)
    assert in_time and not topics["robot_info"].published


def test_what_every_robot_feeds_is_there_before_the_first_one(driver, topics):
    assert set(topics) == ALWAYS
    assert {name for name, topic in topics.items() if topic.latch} == {"e_stop", "robot_info"}


def test_publish_tf_false_leaves_tf_to_others_but_not_the_frames_of_the_sonar(topics, requested):
    driver = publications.Publications(DriverParameters(publish_tf=False), requested.append)
    driver.identity(identity_of())
    assert "/tf" not in topics and "/tf_static" in topics


ON_REQUEST = {"io", "encoders", "joystick"}


@pytest.mark.parametrize("identity, more", [
    (identity_of("p3dx-sh"), SONAR | ON_REQUEST | {"joint_states"}),
    (identity_of("p3dx-sh", gripper=True), SONAR | ON_REQUEST | {"joint_states", "gripper_state"}),
    (identity_of("peoplebot-sh"), SONAR | ON_REQUEST | {"joint_states", "bumpers"}),
    (identity_of("p3dx-sh", has_gyro=1), SONAR | ON_REQUEST | {"joint_states", "imu", "calibration"}),
    (identity_of("p3dx-sh", has_gyro=2), SONAR | ON_REQUEST | {"joint_states", "calibration"}),
    (identity_of("p2dx"), SONAR | {"io", "encoders"}),      # nobody knows its wheels, and it has no JOYSTICKpac
    (identity_of("pion1m"), SONAR),                         # PSOS has none of these packets
    (identity_of("wheelchair-sh"), ON_REQUEST | {"bumpers"}),
])
def test_a_robot_has_the_topics_that_it_can_feed(driver, topics, identity, more):
    driver.identity(identity)
    assert set(topics) - ALWAYS == more


def test_another_robot_brings_its_own_topics_and_takes_those_of_the_one_before(driver, topics):
    driver.identity(identity_of("peoplebot-sh", gripper=True))
    assert {"bumpers", "gripper_state"} <= set(topics)
    driver.identity(identity_of("amigo-sh", name="other"))
    assert not {"bumpers", "gripper_state"} & set(topics) and "sonar" in topics
    driver.identity(identity_of("p3dx-sh", name="third", gripper=True))
    assert "gripper_state" in topics


def test_nothing_is_made_for_nobody(driver, topics, monkeypatch):
    driver.identity(identity_of("peoplebot-sh", gripper=True, has_gyro=1))
    for module, name in ((prompt, "sin"), (prompt, "ranges"), (publications, "Header"), (publications, "MotorState"),
                         (publications, "DIO"), (publications, "AIO")):
        monkeypatch.setattr(module, name, None)     # calling it would raise
    for name, function in list(vars(conversions).items()):
        if callable(function) and getattr(function, "__module__", "") == conversions.__name__:
            monkeypatch.setattr(conversions, name, None)
    monkeypatch.setattr(driver._gripper, "message", None)
    monkeypatch.setattr(driver._gyro, "rate", None)
    driver.state(dataclasses.replace(STATE, compass=1.0))
    driver.event(PacketReceived(packet_of(IO), 100.0, 99.9))
    driver.event(PacketReceived(packet_of(GYRO), 100.0, 99.9))
    for topic in ("stall", "motor_state", "dio", "aio", "pose", "/tf", "sonar"):
        with pytest.raises(TypeError):
            listen(topics, topic)
            driver.state(STATE)
        leave(topics[topic])


def newest(driver, topics, state):
    """Return the messages that are made from this state, by topic."""
    listen(topics)
    for topic in topics.values():
        topic.published.clear()
    driver.state(state)
    return {name: topic.published[-1] for name, topic in topics.items() if topic.published}


def test_motors_battery_and_inputs(driver, topics):
    messages = newest(driver, topics, STATE)
    assert messages["motor_state"].state == 1
    battery, inputs, analog = (messages[name] for name in ("battery_state", "dio", "aio"))
    assert battery.voltage == pytest.approx(12.8) and battery.header.frame_id == "base_link"
    assert (inputs.count, inputs.bits) == (8, 0xF0) and (analog.voltages_count, list(analog.voltages)) == (1, [2.5])
    assert newest(driver, topics, dataclasses.replace(STATE, motors_enabled=False))["motor_state"].state == 0


def test_what_firmware_does_not_report_is_not_made_up(driver, topics):
    messages = newest(driver, topics, dataclasses.replace(STATE, digital_in=None, analog_voltage=None))
    assert "pose" in messages and not {"dio", "aio"} & set(messages)


def test_bumpers_stall_and_stop_button(driver, topics, monkeypatch):
    monkeypatch.setattr(publications, "monotonic", lambda: 100.5)
    identity = identity_of("peoplebot-sh", front_bumpers=5, rear_bumpers=5)
    driver.identity(identity)
    driving = dataclasses.replace(state_of(DRIVING, identity), sent_time=99.25)
    message = newest(driver, topics, driving)["bumpers"]
    assert (message.front, message.rear) == ([True] + [False] * 4, [False] * 5)
    assert message.header.stamp == rospy.Time(998, 750000000)
    stalled = state_of(STALLED, identity)
    assert newest(driver, topics, stalled)["e_stop"].data and not newest(driver, topics, driving)["e_stop"].data
    only_right = dataclasses.replace(driving, right_stall=True)
    for state, expected in ((driving, (False, False)), (stalled, (True, True)), (only_right, (False, True))):
        message = newest(driver, topics, state)["stall"]
        assert (message.left, message.right) == expected and message.header.frame_id == "base_link"


def test_all_messages_of_a_packet_have_the_stamp_of_its_sending(driver, topics, monkeypatch):
    monkeypatch.setattr(publications, "monotonic", lambda: 100.5)
    identity = identity_of("peoplebot-sh", gripper=True)
    driver.identity(identity)
    driver.state(dataclasses.replace(state_of(DRIVING, identity), sent_time=99.25, compass=1.0))
    listen(topics)
    driver.state(dataclasses.replace(state_of(DRIVING, identity), sent_time=99.25, compass=1.0))
    messages = [
        message for name, topic in topics.items() if name not in ("robot_info", "/tf_static")
        for message in topic.published]
    stamped = [message for message in messages if hasattr(message, "header")] + topics["/tf"].published[0].transforms
    assert {message.header.stamp for message in stamped} == {rospy.Time(998, 750000000)}
    assert {name for name, topic in topics.items() if topic.published} == set(topics) - ON_REQUEST
    assert len(topics["sonar_ranges"].published) == 2


def test_a_clock_that_jumps_while_a_packet_is_read_does_not_tear_it_apart(driver, topics, monkeypatch):
    listen(topics)
    monkeypatch.setattr(publications, "monotonic", lambda: 3.0)
    now = iter((1000.0, 2000.0, 3000.0, 4000.0))
    monkeypatch.setattr(publications, "ros_time", lambda: next(now))
    for sent_time in (1.0, 2.0):
        driver.state(dataclasses.replace(STATE, sent_time=sent_time))
    first, second = (message.header.stamp for message in topics["pose"].published)
    assert second - first > rospy.Duration(900)
    assert [message.header.stamp for message in topics["stall"].published] == [first, second]


def test_stamps_work_before_simulated_time_begins(driver, topics, monkeypatch):
    monkeypatch.setattr(publications, "ros_time", lambda: 0.0)
    listen(topics, "pose")
    driver.state(dataclasses.replace(STATE, sent_time=monotonic() - 1.0))
    assert topics["pose"].published[0].header.stamp == rospy.Time(0)


def test_the_time_of_ros_is_that_of_the_clock_unless_it_is_simulated(monkeypatch):
    before = time.time()
    assert before <= publications.ros_time() <= time.time()
    monkeypatch.setattr(publications, "is_wallclock", lambda: False)
    monkeypatch.setattr(publications.rospy, "get_time", lambda: 12.5)
    assert publications.ros_time() == 12.5


def test_no_latched_message_has_the_stamp_that_the_next_packet_changes(driver, topics, monkeypatch):
    kept = []
    monkeypatch.setattr(Publisher, "publish", lambda self, message: kept.append(message) if self.latch else None)
    driver.identity(identity_of())
    driver.state(STATE)
    headers = [message.header for message in kept if getattr(message, "header", None)]
    assert kept and not any(header.stamp is driver._stamp for header in headers)


def test_the_stop_button_is_said_once_per_change_and_kept(driver, topics):
    driver.identity(identity_of())
    for pressed in (False, False, True, True, False):
        driver.state(dataclasses.replace(STATE, stop_button=pressed))
    assert [message.data for message in topics["e_stop"].published] == [False, True, False]


def test_what_the_robot_is_is_said_once_per_connection(driver, topics):
    for number in (1, 2):
        driver.identity(identity_of())
        driver.state(state_of(DRIVING))
        assert len(topics["robot_info"].published) == 1
        assert len(topics["/tf_static"].published) == 1
    driver.identity(identity_of("amigo-sh"))
    assert len(topics["robot_info"].published) == 2 and len(topics["/tf_static"].published[-1].transforms) == 8


def test_ports_and_gyro_are_asked_for_while_somebody_listens(driver, topics, requested):
    driver.identity(identity_of(has_gyro=1))
    driver.state(STATE)
    assert requested == []
    listen(topics, "io", "imu")
    driver.state(STATE)
    driver.state(STATE)
    assert sorted(requested) == [("gyro", True), ("io", True)]
    leave(topics["io"])
    driver.state(STATE)
    assert requested[2:] == [("io", False)]


def test_ports_and_gyro_are_published_when_their_packets_come(driver, topics):
    driver.identity(identity_of(has_gyro=1))
    listen(topics, "io", "imu")
    driver.state(dataclasses.replace(STATE, linear=0.0, angular=0.0))
    driver.event(PacketReceived(packet_of(IO), 100.0, 99.9))
    driver.event(PacketReceived(packet_of(GYRO), 100.0, 99.9))
    driver.event(PacketReceived(p2os.Gyro(()), 100.0, 99.9))
    assert len(topics["io"].published) == len(topics["imu"].published) == 1
    assert topics["imu"].published[0].angular_velocity.z == pytest.approx(0.0)


def test_what_a_gyro_reads_at_rest_is_not_carried_over_to_another_robot(driver, topics):
    standing, moving = (dataclasses.replace(STATE, linear=linear, angular=0.0) for linear in (0.0, 0.2))
    for name in "one", "other":
        driver.identity(identity_of(name=name, has_gyro=1))
        listen(topics, "imu")
        for state in (standing, moving) if name == "one" else (moving,):
            driver.state(state)
            driver.event(PacketReceived(p2os.Gyro((p2os.GyroReading(520, 0),)), 100.0, 99.9))
    at_rest, learned, unlearned = (message.angular_velocity.z for message in topics["imu"].published)
    assert at_rest == learned == 0.0 and unlearned < 0.0


def test_switches_of_a_p2os_gripper_on_the_general_port_are_asked_for(driver, topics, requested):
    identity = identity_of("p2dx", has_gripper=2)
    driver.identity(identity)
    listen(topics, "gripper_state")
    floating = state_of(OLD, identity)
    assert floating.gripper.inner_beam
    driver.state(floating)
    assert requested == [("gripper", True)]
    driver.event(PacketReceived(packet_of(GRIPPER_SWITCHES, False), 100.0, 99.9))
    driver.state(floating)
    assert [message.grip.inner_beam for message in topics["gripper_state"].published] == [True, False]


def test_other_grippers_need_no_asking(driver, topics, requested):
    driver.identity(identity_of(has_gripper=2))
    listen(topics, "gripper_state")
    driver.state(state_of(DRIVING, identity_of(has_gripper=2)))
    assert requested == [] and topics["gripper_state"].published[0].grip.state == 1


def test_a_compass_is_advertised_once_it_speaks_and_stays_through_north(driver, topics):
    driver.identity(identity_of())
    driver.state(STATE)
    assert "compass" not in topics
    driver.state(dataclasses.replace(STATE, compass=1.0))
    listen(topics, "compass")
    driver.state(dataclasses.replace(STATE, compass=None))
    driver.identity(identity_of())
    driver.state(dataclasses.replace(STATE, compass=1.5))
    assert len(topics["compass"].published) == 1
    driver.identity(identity_of(name="other"))
    assert "compass" not in topics


def test_sonar_that_is_off_says_nothing(driver, topics):
    driver.identity(identity_of())
    listen(topics)
    driver.state(dataclasses.replace(state_of(DRIVING), sonar_enabled=False, sonar=(None,) * 16))
    assert not any(topics[name].published for name in ("sonar", "sonar_ranges", "sonar_points"))


@pytest.mark.parametrize("sonar_no_echo, expected", [("inf", math.inf), ("max", 5.0)])
def test_the_parameter_sonar_no_echo(topics, requested, sonar_no_echo, expected):
    driver = publications.Publications(DriverParameters(sonar_no_echo=sonar_no_echo), requested.append)
    driver.identity(identity_of())
    listen(topics, "sonar_ranges")
    state = state_of(DRIVING)
    driver.state(dataclasses.replace(state, sonar=(state.sonar[3]._replace(range=5.0),) + state.sonar[1:3]))
    assert [message.range for message in topics["sonar_ranges"].published] == [expected]


@pytest.mark.parametrize("broken", [1, 0])
def test_the_parameter_beam_polarity(topics, requested, broken):
    driver = publications.Publications(DriverParameters(beam_polarity=broken), requested.append)
    identity = identity_of(has_gripper=1)
    driver.identity(identity)
    listen(topics, "gripper_state")
    driver.state(state_of(DRIVING, identity))       # its beams read 0
    assert topics["gripper_state"].published[0].grip.inner_beam is (broken == 0)


@pytest.mark.parametrize("given, frames", [
    ({}, {"odom", "base_link", "sonar_3"}),
    ({"frame_prefix": "two/"}, {"two/odom", "two/base_link", "two/sonar_3"}),
    ({"odom_frame_id": "wheels", "base_link_frame_id": "body"}, {"wheels", "body", "sonar_3"}),
])
def test_the_parameters_of_frames(topics, requested, given, frames):
    driver = publications.Publications(DriverParameters(**given), requested.append)
    driver.identity(identity_of())
    listen(topics, "pose", "/tf", "sonar", "sonar_ranges", "sonar_points", "battery", "stall")
    driver.state(state_of(DRIVING))
    pose, transform = topics["pose"].published[0], topics["/tf"].published[0].transforms[0]
    assert (pose.header.frame_id, pose.child_frame_id) == (transform.header.frame_id, transform.child_frame_id)
    static = topics["/tf_static"].published[0].transforms
    assert {transform.header.frame_id for transform in static} == {pose.child_frame_id}
    named = {
        message.header.frame_id for name in ("pose", "sonar", "sonar_points", "battery", "stall")
        for message in topics[name].published}
    assert named | {topics["sonar_ranges"].published[0].header.frame_id} == frames
    assert topics["sonar_ranges"].published[0].header.frame_id in {transform.child_frame_id for transform in static}


def test_the_robots_own_calibration_is_told_when_it_changes(driver, topics):
    driver.identity(identity_of("p3dx-sh", ticks_per_mm=128, rev_count=16570, drift_factor=-3, has_gyro=1))
    driver.identity(identity_of("p3dx-sh", ticks_per_mm=128, rev_count=16570, drift_factor=-3, has_gyro=1))
    driver.identity(identity_of("p3dx-sh", ticks_per_mm=125, rev_count=16570, drift_factor=-3, has_gyro=1))
    told = [(each.ticks_mm, each.rev_count, each.drift_factor, each.gyro) for each in topics["calibration"].published]
    assert told == [(128, 16570, -3, 1), (125, 16570, -3, 1)] and topics["calibration"].latch


def test_what_the_robot_does_not_report_of_its_calibration_is_not_known(driver, topics):
    driver.identity(identity_of("p3dx-sh", rev_count=16570))
    told, = topics["calibration"].published
    assert (told.ticks_mm, told.rev_count, told.drift_factor, told.gyro) == (0, 16570, -0x8000, 0)

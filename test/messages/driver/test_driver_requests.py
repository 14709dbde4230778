"""What the driver does for messages on topics and calls of services: on the robot's wire, in the answer, in the log.
The whole driver runs, in simulated time.
"""

import math
import re
import threading

import pytest
import rospy
from bottle import Bottle
from dynamic_reconfigure.msg import BoolParameter, Config, DoubleParameter, IntParameter
from geometry_msgs.msg import Twist, Vector3
from rospy import ServiceException
from std_srvs.srv import SetBool

from pioneer_control.client.line import Line
from pioneer_control.driver.parameters import LIVE, DriverParameters
from pioneer_control.driver.reconfigure import decode, description, encode, values_of
from pioneer_control.driver.requests import SERVICES, TOPICS, Requests
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState, WheelVelocities

MOTORS = [service.name for service in SERVICES if "motors" in service.name]


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: Bottle(monkeypatch, script, **options)


def ask(bottle, service, *values):
    """Call a service that waits for the robot, from a thread of its own as rospy does.

    Returns:
        (whether it worked, text)
    """
    answers = []

    def call():
        try:
            answer = bottle.call(service, *values)
            answers.append((getattr(answer, "success", True), getattr(answer, "message", "")))
        except ServiceException as error:
            answers.append((False, str(error)))

    thread = threading.Thread(target=call)
    thread.start()
    while thread.is_alive():
        thread.join(0.02)       # real time, so that the robot's does not run away
        yield 0.05
    return answers[0]


def ask_for_motors(bottle, service, on=True):
    return ask(bottle, service, *([on] if service == "set_motors" else []))


def twist(linear, angular=0.0):
    return Twist(Vector3(linear, 0, 0), Vector3(0, 0, angular))


# Services

@pytest.mark.parametrize("service", ["set_motors", "enable_motors"])
def test_motors_go_on_when_asked_and_the_answer_says_so(run, service):
    def script(bottle):
        bottle.answer = yield from ask_for_motors(bottle, service)
        bottle.on = bottle.firmware.motors_enabled

    bottle = run(script)
    assert bottle.answer[0] and bottle.on
    assert bottle.says("motors are on")


@pytest.mark.parametrize("service", ["set_motors", "disable_motors"])
def test_motors_go_off_when_asked(run, service):
    def script(bottle):
        yield from ask_for_motors(bottle, "set_motors")
        bottle.answer = yield from ask_for_motors(bottle, service, False)
        bottle.on = bottle.firmware.motors_enabled

    bottle = run(script)
    assert bottle.answer[0] and not bottle.on


@pytest.mark.parametrize("service", ["set_motors", "enable_motors"])
@pytest.mark.parametrize("befall, reason", [
    (lambda bottle: bottle.firmware.press_stop_button(True), "the STOP button is pressed; release it and ask again"),
    (lambda bottle: bottle.deaf_to.add("ENABLE"), "did not confirm it in time"),
    (lambda bottle: bottle.unplug(), "cable"),
])
def test_motors_that_stay_off_have_a_reason(run, service, befall, reason):
    def script(bottle):
        befall(bottle)
        yield 0.3
        bottle.answer = yield from ask_for_motors(bottle, service)
        bottle.on = bottle.firmware.motors_enabled

    bottle = run(script)
    assert not bottle.answer[0] and reason in bottle.answer[1] and not bottle.on


def test_the_types_of_services_that_motors_have_are_those_of_both_worlds():
    assert {service.name: service.kind is SetBool for service in SERVICES if service.name in MOTORS} == {
        "set_motors": True, "enable_motors": False, "disable_motors": False}


def test_odometry_begins_anew_and_a_link_that_is_down_is_the_reason_why_not(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(20):
            bottle.send("cmd_vel", twist(0.3))
            yield 0.1
        yield 2.0
        bottle.far = bottle.messages("pose")[-1].pose.pose.position.x
        bottle.answer = bottle.call("reset_odometry")
        yield 0.2
        bottle.near = bottle.messages("pose")[-1].pose.pose.position.x
        bottle.unplug()
        yield 0.1
        bottle.refusal = bottle.call("reset_odometry")

    bottle = run(script)
    assert bottle.far > 0.3 and bottle.near == 0.0 and bottle.answer.success
    assert not bottle.refusal.success and "cable" in bottle.refusal.message


# Motors at the start

def reconnect(bottle):
    bottle.unplug(for_a_moment=True)
    yield 3.0


def restart(bottle):
    bottle.firmware.restart()
    yield 3.0


def tap_stop_button(bottle):
    bottle.firmware.press_stop_button(True)
    yield 0.5
    bottle.firmware.press_stop_button(False)
    yield 3.0


@pytest.mark.parametrize("befall, reconnects", [(reconnect, 1), (restart, 1), (tap_stop_button, 0)])
def test_enable_motors_on_start_counts_once_and_is_said(run, befall, reconnects):
    def script(bottle):
        yield 0.5
        bottle.first = bottle.firmware.motors_enabled
        yield from befall(bottle)
        bottle.second = bottle.firmware.motors_enabled, bottle.robot.link.reconnects

    bottle = run(script, enable_motors_on_start=True)
    assert bottle.first and bottle.second == (False, reconnects)
    assert sum("enable_motors_on_start" in text for _, text in bottle.said) == 1


@pytest.mark.parametrize("befall", [reconnect, restart])
def test_enable_motors_on_start_has_counted_also_when_the_robot_did_not_obey(run, befall):
    def script(bottle):
        yield from befall(bottle)
        bottle.deaf_to.clear()
        yield 3.0
        bottle.on = bottle.firmware.motors_enabled, bottle.robot.link.reconnects

    bottle = run(script, before=lambda bottle: bottle.deaf_to.add("ENABLE"), enable_motors_on_start=True)
    assert bottle.on == (False, 1)
    assert sum("enable_motors_on_start is set" in text for _, text in bottle.said) == 1


def test_enable_motors_on_start_says_why_not(run):
    def script(bottle):
        yield 0.5
        bottle.on = bottle.firmware.motors_enabled
        bottle.firmware.press_stop_button(False)
        yield 1.0
        bottle.later = bottle.firmware.motors_enabled

    bottle = run(script, before=lambda bottle: bottle.firmware.press_stop_button(True), enable_motors_on_start=True)
    assert not bottle.on and not bottle.later
    assert bottle.says("motors stay off: the STOP button is pressed")


def test_enable_motors_on_start_counts_for_no_later_connection_when_listeners_hear_of_the_first_too_late(run):
    """A master that hangs while topics are advertised delays the listeners. Meanwhile the link goes on, and may already
    be another connection.
    """
    held_up = pytest.MonkeyPatch()

    def script(bottle):
        bottle.unplug(for_a_moment=True)
        yield 3.0
        held_up.undo()
        bottle.node._requests.connected()
        yield 3.0
        bottle.on = bottle.firmware.motors_enabled, bottle.robot.link.reconnects, bottle.commands("ENABLE")

    bottle = run(script, before=lambda bottle: held_up.setattr(Requests, "connected", lambda requests: None),
                 enable_motors_on_start=True)
    assert bottle.on[:2] == (False, 1) and {value for _, value in bottle.on[2]} == {0}
    assert bottle.says("enable_motors_on_start counts no more")


# Velocities

def test_wheel_velocities_drive_each_side_and_the_last_commander_wins(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(10):
            bottle.send("cmd_wheels", WheelVelocities(0.2, 0.1))
            yield 0.1
        bottle.curve = bottle.firmware.velocity
        for _ in range(30):
            bottle.send("cmd_vel", twist(0.1))
            yield 0.1
        bottle.straight = bottle.firmware.velocity
        yield 2.0
        bottle.silent = bottle.firmware.velocity

    bottle = run(script)
    assert {value for _, value in bottle.commands("VEL2")} == {0x0A05}      # 200 and 100 mm/s in steps of 20
    assert bottle.curve[0] > 0.1 and bottle.curve[1] < -0.1
    assert bottle.straight == (0.1, 0.0)
    assert bottle.silent == (0.0, 0.0) and bottle.says("no velocity came for 0.6 s")


def test_as_many_velocities_may_wait_as_the_line_takes_in_a_row():
    """The line takes the velocities that go at once, and one that waits. If fewer may wait in rospy, rospy drops one
    that would be sent. If more may wait, old ones go first.
    """
    written = []
    line = Line(None, ())
    line.to_send = written
    for _ in range(10):
        line.velocity(0.0, b"VEL", b"RVEL")
    assert [topic.queue for topic in TOPICS if topic.name in ("cmd_vel", "cmd_wheels")] == 2 * [len(written) + 1]


def test_velocities_that_come_in_a_bunch_reach_the_robot_as_many_as_may_wait(run):
    waiting, = (topic.queue for topic in TOPICS if topic.name == "cmd_vel")
    bunch = [0.1 + number / 100 for number in range(waiting)]
    assert len(bunch) > 1

    def script(bottle):
        yield 0.5       # what it is told at the beginning has the line before
        for linear in bunch:
            bottle.send("cmd_vel", twist(linear))
        yield 0.1

    bottle = run(script, port="socket://robot:1")      # TCP: at 9600 baud only one of them would go
    expected = [round(linear * 1000) for linear in bunch]
    assert [value for _, value in bottle.commands("VEL") if value][:waiting] == expected


def test_wheels_fall_silent_as_the_robot_does(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.send("cmd_wheels", WheelVelocities(0.2, 0.2))
        yield 0.55
        bottle.driving = bottle.firmware.velocity
        yield 1.5
        bottle.silent = bottle.firmware.velocity

    bottle = run(script)
    assert bottle.driving[0] > 0.1 and bottle.silent == (0.0, 0.0)


@pytest.mark.parametrize("topic, message, says", [
    ("cmd_vel", twist(math.nan), "cmd_vel refused: linear.x is nan"),
    ("cmd_wheels", WheelVelocities(0.1, math.nan), "cmd_wheels refused: right is nan"),
    ("cmd_wheels", WheelVelocities(-math.inf, 0), "left is -inf")])
def test_what_is_no_number_moves_nothing(run, topic, message, says):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.send(topic, message)
        yield 0.5
        bottle.velocity = bottle.firmware.velocity

    bottle = run(script)
    assert bottle.says(says) and bottle.velocity == (0.0, 0.0)
    assert {value for _, value in bottle.commands("VEL", "RVEL", "VEL2")} == {0}


@pytest.mark.parametrize("topic, message", [
    ("cmd_vel", twist(0.2)), ("cmd_wheels", WheelVelocities(0.2, 0.2)), ("cmd_motor_state", MotorState(1)),
    ("gripper_control", GripperState(GripState(state=2), LiftState()))])
@pytest.mark.parametrize("player", ["/play_1795", "/renamed"])
def test_what_a_bag_plays_is_refused_on_every_topic(run, topic, message, player):
    def script(bottle):
        bottle.is_offered = lambda service, timeout: service == "/renamed/pause_playback"
        bottle.send(topic, message)
        yield 0.5

    bottle = run(script, caller=player)
    assert bottle.says("%s refused: it is played back from a bag" % topic)
    refused = {("VEL", 200), ("VEL2", 0x0A0A), ("ENABLE", 1), ("GRIPPER", 2)}
    assert not refused & {(name, value) for _, name, value in bottle.heard}


# Who sent it: the master says whether a node plays a bag under another name

COMMANDS = {
    "cmd_vel": (twist(0.3), twist(0.0), ("VEL", 300)),
    "cmd_wheels": (WheelVelocities(0.2, 0.2), WheelVelocities(0.0, 0.0), ("VEL2", 0x0A0A)),
    "cmd_motor_state": (MotorState(1), MotorState(0), ("ENABLE", 1)),
    "gripper_control": (
        GripperState(GripState(state=2), LiftState()), GripperState(GripState(state=3), LiftState(state=6)),
        ("GRIPPER", 2)),
}
"""{topic: what moves, what stops, what the robot hears of the former}"""


def send_for_a_while(bottle, topic, message):
    for _ in range(5):
        bottle.send(topic, message)
        yield 0.1


def heard(bottle, command):
    return command in [(name, value) for _, name, value in bottle.heard]


@pytest.mark.parametrize("topic", COMMANDS)
@pytest.mark.parametrize("plays", [True, False])
def test_whom_nobody_knows_is_refused_until_a_master_that_was_gone_is_back(run, topic, plays):
    move, _, moves = COMMANDS[topic]

    def script(bottle):
        bottle.is_offered = lambda service, timeout: None
        yield from send_for_a_while(bottle, topic, move)
        bottle.early = heard(bottle, moves)
        bottle.is_offered = lambda service, timeout: plays and service == "/somebody/pause_playback"
        yield from send_for_a_while(bottle, topic, move)

    bottle = run(script)
    assert bottle.says("%s refused: the ROS master does not say in time whether /somebody plays a bag" % topic)
    assert not bottle.early and heard(bottle, moves) is not plays
    assert bottle.says("%s refused: it is played back from a bag" % topic) is plays


@pytest.mark.parametrize("topic", COMMANDS)
def test_a_player_with_the_name_of_a_program_that_was_there_is_refused(run, topic):
    move, stop, moves = COMMANDS[topic]

    def script(bottle):
        yield from send_for_a_while(bottle, topic, stop)
        bottle.is_offered = lambda service, timeout: service == "/wanderer/pause_playback"
        bottle.connect_anew()
        yield from send_for_a_while(bottle, topic, move)

    bottle = run(script, caller="/wanderer")
    assert bottle.says("%s refused: it is played back from a bag" % topic) and not heard(bottle, moves)


@pytest.mark.parametrize("topic", COMMANDS)
def test_what_only_stops_is_obeyed_from_whomever_it_comes(run, topic):
    def script(bottle):
        bottle.is_offered = lambda service, timeout: None
        yield 0.5
        bottle.heard.clear()
        bottle.send(topic, COMMANDS[topic][1])
        bottle.obeyed = [name for _, name, _ in bottle.heard if name in ("STOP", "VEL", "ENABLE", "GRIPPER")]
        yield 0.1

    bottle = run(script)
    assert bottle.obeyed and "refused" not in bottle.warned


@pytest.mark.parametrize("message", [
    twist(0.0, 0.1), WheelVelocities(0.0, 0.1), MotorState(2), GripperState(GripState(state=3), LiftState(state=4)),
    GripperState(GripState(state=1), LiftState(state=6))])
def test_what_does_more_than_stop_is_not(message):
    topic = next(topic for topic in TOPICS if isinstance(message, topic.message))
    assert not topic.stops(message)


@pytest.mark.parametrize("held_up, obeyed", [(0.2, True), (5.0, False)])
@pytest.mark.parametrize("topic", COMMANDS)
def test_what_a_master_held_up_is_too_old_and_so_may_be_what_waited_behind_it(run, topic, held_up, obeyed):
    move, _, moves = COMMANDS[topic]

    def script(bottle):
        def is_offered(service, timeout):
            bottle.asked += 1
            bottle.now += held_up       # for whatever reason: its publisher wanted it then
            return False if obeyed else None

        bottle.asked, bottle.is_offered = 0, is_offered
        for _ in range(10):
            bottle.send(topic, move)
        yield 0.1

    bottle = run(script)
    assert heard(bottle, moves) is obeyed and bottle.asked == 1
    assert bottle.says("%s refused" % topic) is not obeyed


def test_an_answer_that_comes_too_late_counts_for_the_next_one(run):
    def script(bottle):
        def is_offered(service, timeout):
            bottle.now += 5.0
            return False

        bottle.is_offered = is_offered
        bottle.send("cmd_vel", twist(0.3))
        bottle.late = heard(bottle, ("VEL", 300))
        bottle.send("cmd_vel", twist(0.3))
        bottle.next = heard(bottle, ("VEL", 300))
        yield 0.1

    bottle = run(script)
    assert (bottle.late, bottle.next) == (False, True)


# The gripper

def test_pressure_and_carry_go_out_right_before_their_values(run):
    def script(bottle):
        bottle.send("gripper_control", GripperState(GripState(state=16, dir=10), LiftState(state=17, dir=-50)))
        yield 0.5

    assert [(name, value) for _, name, value in run(script).heard if name.startswith("GRIPPER")] == [
        ("GRIPPER", 16), ("GRIPPERVAL", 10), ("GRIPPER", 17), ("GRIPPERVAL", -50)]


def test_a_value_that_means_nothing_sends_nothing(run):
    def script(bottle):
        bottle.send("gripper_control", GripperState(GripState(state=2), LiftState(state=17)))
        yield 0.5

    bottle = run(script)
    assert bottle.says("lift.state 17 needs lift.dir") and bottle.commands("GRIPPER", "GRIPPERVAL") == []


# dynamic_reconfigure

def test_what_may_change_is_described_by_the_table():
    told = description()
    defaults, least, most = decode(told.dflt), decode(told.min), decode(told.max)
    assert set(defaults) == set(least) == set(most) == set(LIVE) == {row.name for row in told.groups[0].parameters}
    for row in told.groups[0].parameters:
        assert row.type == {int: "int", float: "double"}[type(LIVE[row.name].default)]
        assert LIVE[row.name].metadata["meaning"] in row.description
        assert least[row.name] <= defaults[row.name] <= most[row.name]
    assert (least["max_xdecel"], most["max_xdecel"], least["bumpstall"], most["bumpstall"]) == (-10.0, 10.0, -1, 3)


def test_what_cannot_change_in_a_running_driver_is_not_live():
    assert {"port", "pulse", "enable_motors_on_start", "accept_replay", "frame_prefix"} & set(LIVE) == set()


def test_a_change_is_published_kept_and_told_to_the_log_and_the_robots_description(run):
    def script(bottle):
        bottle.answer = bottle.call("~set_parameters", encode({"max_xspeed": 0.25, "rot_kp": 55}))
        yield 2.0

    bottle = run(script)
    wanted = dict(values_of(DriverParameters()), max_xspeed=0.25, rot_kp=55)
    assert decode(bottle.answer.config) == decode(bottle.messages("~parameter_updates")[-1]) == wanted
    assert bottle.set_parameters == {"~max_xspeed": 0.25, "~rot_kp": 55}
    assert bottle.says("~max_xspeed: 0.5 -> 0.25") and bottle.says("~rot_kp 40 -> 55")
    assert bottle.messages("robot_info")[-1].max_linear == 0.25 and bottle.messages("robot_info")[0].max_linear == 0.5


def test_a_change_without_a_master_is_a_change_all_the_same_and_is_said(run, monkeypatch):
    def refuse(name, value):
        raise ConnectionRefusedError(111, "Connection refused")

    def script(bottle):
        monkeypatch.setattr(rospy, "set_param", refuse)
        bottle.answer = bottle.call("~set_parameters", encode({"max_xspeed": 0.25, "rot_kp": 55}))
        yield 2.0

    bottle = run(script)
    wanted = dict(values_of(DriverParameters()), max_xspeed=0.25, rot_kp=55)
    assert decode(bottle.answer.config) == decode(bottle.messages("~parameter_updates")[-1]) == wanted
    assert bottle.says("~rot_kp is 55 until this driver ends")


def test_back_at_the_robots_own_it_has_that_again(run):
    def script(bottle):
        bottle.call("~set_parameters", encode({"rot_kp": 55}))
        yield 2.0
        bottle.call("~set_parameters", encode({"rot_kp": -1}))
        yield 2.0
        bottle.kept = bottle.firmware.settings["rotation_kp"]

    bottle = run(script)
    assert bottle.kept == 40 and bottle.says("~rot_kp 55 -> 40")


def test_a_change_without_a_link_holds_for_the_next_one(run):
    def script(bottle):
        bottle.unplug()
        yield 0.1
        bottle.call("~set_parameters", encode({"max_xspeed": 0.25, "rot_kp": 55}))
        bottle.plug_in()
        yield 5.0
        bottle.kept = bottle.firmware.settings["rotation_kp"]

    bottle = run(script)
    assert bottle.messages("robot_info")[-1].max_linear == 0.25 and bottle.kept == 55


def test_the_sonar_stays_as_it_was_told_when_the_link_comes_back(run):
    def script(bottle):
        bottle.robot.set_sonar(False)
        yield 0.5
        bottle.unplug(for_a_moment=True)
        yield 3.0
        bottle.on = bottle.robot.state.sonar_enabled, bottle.robot.link.reconnects

    assert run(script).on == (False, 1)


def laser_switches(bottle):
    return [value & 0xFF for _, name, value in bottle.heard if name in ("TIMER", "POWER_LRF")]


@pytest.mark.parametrize("options, wishes, told", [
    (dict(), [], []),
    (dict(), [True], [1, 1]),           # told, and again after the reconnect
    (dict(), [True, False], [1, 0, 0]),
    (dict(laser_power=True), [], [1, 1]),
    (dict(laser_power=True), [False], [1, 0, 0]),
])
def test_the_laser_has_power_only_when_somebody_asks_for_it(run, options, wishes, told):
    def script(bottle):
        yield 0.5
        for wish in wishes:
            said_yes, text = yield from ask(bottle, "set_laser_power", wish)
            assert said_yes and "does not say whether" in text
            yield 0.3
        bottle.unplug(for_a_moment=True)
        while not bottle.robot.link.reconnects:
            yield 0.1
        yield 1.0

    assert laser_switches(run(script, **options)) == told


def test_without_a_link_the_laser_gets_no_power_later(run):
    def script(bottle):
        bottle.unplug()
        yield 1.0
        bottle.answer = yield from ask(bottle, "set_laser_power", True)
        bottle.plug_in()
        yield 4.0

    bottle = run(script)
    assert not bottle.answer[0] and "no such port" in bottle.answer[1] and laser_switches(bottle) == []


def test_a_time_out_that_is_made_shorter_holds_at_once(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.call("~set_parameters", encode({"cmd_vel_timeout": 2.0}))
        bottle.send("cmd_vel", twist(0.3))
        yield 0.7
        bottle.call("~set_parameters", encode({"cmd_vel_timeout": 0.3}))
        bottle.silent_from = bottle.now
        yield 0.1
        bottle.stopped = [time for time, name, _ in bottle.heard if name == "STOP" and time >= bottle.silent_from]

    bottle = run(script)
    assert bottle.stopped and bottle.stopped[0] - bottle.silent_from < 0.02


@pytest.mark.parametrize("config, says", [
    (Config(doubles=[DoubleParameter("max_xspeed", 3.5)]),
     r"~max_xspeed = 3.5 is not legal: give a number from 0.01 to 3 \(m/s\)"),
    (Config(doubles=[DoubleParameter("cmd_vel_timeout", 0.0)]),
     "~cmd_vel_timeout = 0.0 is not legal: give a number from 0.1 to 2"),
    (Config(doubles=[DoubleParameter("max_yawspeed", math.nan)]), "~max_yawspeed = nan is not legal"),
    (Config(ints=[IntParameter("bumpstall", 4)]), "~bumpstall = 4 is not legal"),
    (Config(doubles=[DoubleParameter("pulse", 1.0)]), "~pulse cannot change while the driver runs"),
    (Config(ints=[IntParameter("bumpstal", 1)]), "~bumpstal cannot change"),
    (Config(bools=[BoolParameter("accept_replay", True)]), "~accept_replay cannot change"),
    (Config(doubles=[DoubleParameter("max_xspeed", 0.2), DoubleParameter("max_yawspeed", 99.0)]),
     "~max_yawspeed = 99.0 is not legal"),
])
def test_what_is_not_legal_changes_nothing_at_all(run, config, says):
    def script(bottle):
        with pytest.raises(ServiceException, match=says):
            bottle.call("~set_parameters", config)
        yield 0.5
        bottle.finished = True

    bottle = run(script)
    assert bottle.finished and re.search(says, bottle.warned)
    assert len(bottle.messages("~parameter_updates")) == 1 and bottle.set_parameters == {}
    assert bottle.messages("robot_info")[-1].max_linear == 0.5

"""The texts of diagnostics: every level of every task names the fault, and nothing is reported when all is well."""

import pathlib
from dataclasses import dataclass, fields
from types import SimpleNamespace
from typing import Any, Optional, Tuple

import pytest
import yaml

from pioneer_control.client import (
    BaudFound, CommandTimedOut, HelmState, LineSpeed, LinkCounts, LinkDown, MotionCleared, Ready, Unmoved)
from pioneer_control.client.fault_flags import FAULTS, Level
from pioneer_control.client.health import JUDGED, NO_HARDWARE, TASKS, WINDOW, Facts, Health, LinkWindow, Recent, find
from pioneer_control.errors import LinkLostError
from pioneer_control.p2os import ChargeState, FaultFlags, Flags

AGGREGATOR = (pathlib.Path(__file__).resolve().parents[3] / "config" / "diagnostics.yaml").read_text(encoding="utf-8")
OK, WARN, ERROR, STALE = Level
ENABLE = "rosservice call /pioneer/set_motors true"
STATE_TASKS = [task for task in TASKS if task != "Link"]
COUNTS = LinkCounts(100, 0, 0, 0, 0, 0, 0, 0, None)


@dataclass(frozen=True)
class State:
    """The fields of a RobotState that diagnostics use. All is well in it."""

    battery_voltage: float = 12.5
    left_stall: bool = False
    right_stall: bool = False
    stop_button: bool = False
    motors_enabled: bool = True
    front_bumpers: Tuple[bool, ...] = ()
    rear_bumpers: Tuple[bool, ...] = ()
    flags: Flags = Flags(0)
    fault_flags: Optional[FaultFlags] = None
    charge_state: Any = None
    temperature: Optional[float] = None
    state_of_charge: Optional[float] = None
    time: float = 0.0
    moving: bool = False


def identity(battery_class=12, name="sim_0001", **config):
    fields = dict(
        low_battery_dv=115, shutdown_dv=110, sip_cycle_ms=100, charge_low_percent=None, charge_shutdown_percent=None,
        high_temperature_shutdown_c=-128)
    fields.update(config)
    cycle = (fields["sip_cycle_ms"] or 100) / 1000
    return SimpleNamespace(
        name=name, subtype="p3dx-sh", firmware="2.9", serial=None, model=SimpleNamespace(battery_class=battery_class),
        sip_cycle=cycle, config=SimpleNamespace(**fields))


def facts(state=State(), robot=None, **others):
    well = Facts("/dev/ttyUSB0", ENABLE, "9600", no_link=None, identity=robot or identity(), state=state, counts=COUNTS)
    return well._replace(**others)


def found(task, robot=None, **state):
    return find(task, facts(State(**state), robot))


@pytest.mark.parametrize("task", TASKS)
def test_all_well_is_ok_and_says_something(task):
    finding = find(task, facts())
    assert finding.level is OK and finding.message


@pytest.mark.parametrize("task", STATE_TASKS)
def test_without_a_link_nothing_is_known_of_the_robot(task):
    for unknown in (facts(no_link="cable"), facts(state=None)):
        finding = find(task, unknown)
        assert (finding.level, finding.values) == (STALE, {}) and "no link" in finding.message


@pytest.mark.parametrize("task", TASKS)
def test_a_robot_that_never_sent_its_configuration_is_judged_all_the_same(task):
    old = identity()
    old.config = None
    assert find(task, facts(State(temperature=40.0, state_of_charge=0.5), old)).level is OK
    if task == "Battery":
        assert find(task, facts(State(battery_voltage=11.4), old)).level is WARN


# --- Link ---

def test_no_link_says_why():
    finding = find("Link", facts(no_link="/dev/ttyUSB0: no such port", state=None))
    assert finding == (ERROR, "no link: /dev/ttyUSB0: no such port", finding.values)


def test_before_the_first_attempt_has_failed_it_is_still_looking():
    finding = find("Link", Facts("/dev/ttyUSB0", ENABLE, "9600"))
    assert finding.level is ERROR and "still looking" in finding.message


@pytest.mark.parametrize("packets, bad, stray, level, words", [
    (40, 0, 0, OK, "connected, 10.0 packets a second"),
    (37, 0, 0, OK, "9.2 packets"),
    (35, 0, 0, OK, "8.8 packets"),     # the 36th may be about to come
    (34, 0, 0, WARN, "only 8.5 of 10.0 packets a second arrive"),
    (0, 0, 0, WARN, "only 0.0 of 10.0"),
    (39, 1, 0, WARN, "1 packets with a bad checksum and 0 stray bytes within 4 s: check cable and plugs"),
    (40, 0, 7, WARN, "0 packets with a bad checksum and 7 stray bytes"),
    (20, 3, 9, WARN,
     "only 5.0 of 10.0 packets a second arrive: check cable, radio and the computer's load; 3 packets with"),
])
def test_the_line_is_judged_by_what_came_lately(packets, bad, stray, level, words):
    finding = find("Link", facts(recent=Recent(4.0, packets, bad, stray, 0, 0)))
    assert finding.level is level and words in finding.message


@pytest.mark.parametrize("packets, level", [(10, OK), (9, OK), (8, WARN)])
def test_a_young_line_is_not_blamed_for_the_packet_that_is_about_to_come(packets, level):
    assert find("Link", facts(recent=Recent(1.01, packets, 0, 0, 0, 0))).level is level


def test_the_rate_is_measured_against_the_robots_own_cycle():
    fast = identity(sip_cycle_ms=20)
    assert find("Link", facts(robot=fast, recent=Recent(4.0, 200, 0, 0, 0, 0))).level is OK
    assert "only 10.0 of 50.0" in find("Link", facts(robot=fast, recent=Recent(4.0, 40, 0, 0, 0, 0))).message


def test_a_young_link_is_not_judged():
    assert find("Link", facts(recent=None))[:2] == (OK, "connected")


@pytest.mark.parametrize("questions, unanswered, level", [
    (20, 0, OK), (20, 3, OK), (20, 4, WARN), (5, 1, OK), (5, 2, WARN), (1, 1, OK), (2, 2, WARN)])
def test_questions_that_are_not_answered_are_a_fault_of_the_link_but_for_one(questions, unanswered, level):
    finding = find("Link", facts(recent=Recent(4.0, 40, 0, 0, questions, unanswered)))
    assert finding.level is level
    complaint = "%d of %d questions within 4 s were not answered" % (unanswered, questions)
    assert level is OK or finding.message.startswith(complaint)


def test_of_a_line_that_is_bad_both_ways_both_are_said():
    message = find("Link", facts(recent=Recent(4.0, 40, 1, 0, 20, 10))).message
    assert "1 packets with a bad checksum" in message and "10 of 20 questions" in message


def test_that_all_questions_were_answered_is_said():
    values = dict(find("Link", facts(counts=COUNTS._replace(questions=400))).values)
    assert values["Questions without an answer"] == "0 of 400"


def test_without_an_answer_yet_nothing_is_said_of_lost_ones():
    values = dict(find("Link", facts()).values)
    assert values["Questions without an answer"] == "not known: none was asked, or none answered"


def test_the_links_values_tell_port_counts_and_last_error():
    counts, recent = LinkCounts(100, 2, 30, 4, 5, 400, 7, 6, "cable"), Recent(4.0, 40, 0, 0, 0, 0)
    values = dict(find("Link", facts(counts=counts, recent=recent)).values)
    assert values["Port"] == "/dev/ttyUSB0" and values["Baud"] == "9600" and values["Packets a second"] == "10.0"
    expected = {
        "Packets": "100", "Bad checksums": "2", "Stray bytes": "30", "Packets nobody understands": "4",
        "Readings of unknown sonar": "5", "Questions without an answer": "7 of 400",
        "Reconnects": "6", "Last error": "cable", "Robot": "sim_0001", "Firmware": "2.9"}
    assert {key: values[key] for key in expected} == expected
    assert "Baud" not in dict(find("Link", facts(baud=None)).values)


# --- Battery ---

@pytest.mark.parametrize("volts, level, words", [
    (11.5, OK, "11.5 V"),
    (11.4, WARN, "battery low: 11.4 V, the alarm level is 11.5 V; charge it"),
    (11.0, WARN, "battery low"),
    (10.9, ERROR, "nearly empty: 10.9 V, the robot switches itself off at 11.0 V; charge it"),
])
def test_the_battery_is_judged_by_the_robots_own_levels(volts, level, words):
    finding = found("Battery", battery_voltage=volts)
    assert finding.level is level and words in finding.message


def test_a_24_v_robot_has_levels_of_its_own():
    robot = identity(24, low_battery_dv=None, shutdown_dv=None)
    assert [found("Battery", robot, battery_voltage=volts).level for volts in (23.1, 22.9, 21.9)] == [OK, WARN, ERROR]


@pytest.mark.parametrize("charge_state, flags, charger, ok", [
    (ChargeState.NOT_CHARGING, 0, "not charging", "12.5 V"),
    (ChargeState.BULK, 0, "charging (bulk)", "12.5 V, charging (bulk)"),
    (3, 0, "charging (float)", "12.5 V, charging (float)"),
    (ChargeState.UNKNOWN, 0, "not reported", "12.5 V"),
    (77, 0, "not reported", "12.5 V"),
    (None, 0, "not reported", "12.5 V"),
    (None, Flags.CHARGER_POWER, "on its charger", "12.5 V, on its charger"),
])
def test_charging_is_told(charge_state, flags, charger, ok):
    finding = found("Battery", charge_state=charge_state, flags=Flags(flags))
    assert finding[:2] == (OK, ok) and dict(finding.values)["Charger"] == charger


def test_an_empty_battery_on_its_charger_is_no_error_and_needs_no_advice():
    finding = found("Battery", battery_voltage=10.5, charge_state=ChargeState.BULK)
    assert finding.level is WARN and "it is on its charger" in finding.message and "charge it" not in finding.message


@pytest.mark.parametrize("share, charge_state, level", [
    (0.5, 0, OK), (0.19, 0, WARN), (0.04, 0, ERROR), (0.04, 1, WARN)])
def test_a_state_of_charge_is_judged_by_the_robots_own_levels(share, charge_state, level):
    robot = identity(charge_low_percent=20, charge_shutdown_percent=5)
    finding = found("Battery", robot, state_of_charge=share, charge_state=charge_state)
    assert finding.level is level and dict(finding.values)["State of charge (%)"] == "%.0f" % (share * 100)
    assert level is OK or "%.0f %% of its charge is left" % (share * 100) in finding.message


# --- Motors, stall, bumpers, temperature ---

def test_motors_off_are_no_fault_but_how_to_switch_them_on_is_said():
    assert found("Motors")[:2] == (OK, "motors are on")
    assert found("Motors", motors_enabled=False)[:2] == (OK, "motors are off; to switch them on: " + ENABLE)


def test_the_stop_button_is_named_and_what_to_do():
    finding = found("Motors", stop_button=True, motors_enabled=False, flags=Flags.STOP_BUTTON | Flags.E_STALL)
    assert finding[:2] == (WARN, "the STOP button is pressed: motors are off; release it, then " + ENABLE)
    assert dict(finding.values)["STOP button"] == "pressed"


def test_an_emergency_stop_without_the_button_is_named_too():
    finding = found("Motors", motors_enabled=False, flags=Flags.E_STALL)
    assert finding.level is WARN and "an emergency stop holds the wheels" in finding.message


def test_a_stalled_wheel_is_named_and_the_stop_button_is_no_stall():
    assert found("Stall", left_stall=True)[:2] == (WARN, "the left wheel is stalled: something holds the robot")
    assert "the left and the right wheels are" in found("Stall", left_stall=True, right_stall=True).message
    assert found("Stall", left_stall=True, right_stall=True, stop_button=True).level is OK


def test_a_pressed_bumper_is_named_by_its_segment():
    finding = found("Bumpers", front_bumpers=(False, True, True, False, False), rear_bumpers=(False,) * 5)
    assert finding[:2] == (WARN, "the front bumper is pressed (segment 2 and 3 of 5): drive away from what touches it")
    assert list(finding.values.items()) == [("Front", "pressed: 2, 3"), ("Rear", "free")]
    assert "rear bumper is pressed (segment 1 of 1)" in found("Bumpers", rear_bumpers=(True,)).message


def test_free_bumpers_and_no_bumpers_are_told_apart():
    assert found("Bumpers", front_bumpers=(False,) * 5)[:2] == (OK, "free")
    assert found("Bumpers")[:2] == (OK, "no bumpers are fitted")


@pytest.mark.parametrize("degrees, level", [(-20.0, OK), (54.0, OK), (55.0, WARN), (59.0, WARN), (60.0, ERROR)])
def test_a_temperature_is_judged_by_the_robots_own_limit(degrees, level):
    finding = found("Temperature", identity(high_temperature_shutdown_c=60), temperature=degrees)
    assert finding.level is level and "%.0f deg C" % degrees in finding.message
    assert level is OK or "switches itself off at 60 deg C: let it cool down" in finding.message


@pytest.mark.parametrize("limit", [-128, None])
def test_without_a_limit_every_temperature_will_do(limit):
    assert found("Temperature", identity(high_temperature_shutdown_c=limit), temperature=90.0)[:2] == (OK, "90 deg C")


def test_a_robot_without_a_thermometer_may_still_say_that_it_is_too_hot():
    assert found("Temperature")[:2] == (OK, "this robot reports none")
    for said in (dict(flags=Flags.HIGH_TEMPERATURE), dict(fault_flags=FaultFlags.HIGH_TEMPERATURE),
                 dict(flags=Flags.HIGH_TEMPERATURE, fault_flags=FaultFlags.HIGH_TEMPERATURE)):
        assert found("Temperature", **said)[:2] == (ERROR, "the robot says it is too hot: let it cool down")


# --- The robot's own faults ---

def test_every_fault_flag_has_a_task_and_words_but_the_one_that_is_no_fault():
    assert set(FaultFlags) - set(FAULTS) == {FaultFlags.LASER_POWER}
    assert {task for task, _, _ in FAULTS.values()} <= set(STATE_TASKS)


@pytest.mark.parametrize("flag", FAULTS, ids=lambda flag: flag.name)
def test_a_fault_shows_in_its_task_and_nowhere_else(flag):
    for task in STATE_TASKS:
        finding = found(task, fault_flags=flag | FaultFlags.LASER_POWER)
        if task == FAULTS[flag][0]:
            assert finding[:2] == FAULTS[flag][1:] and finding.level in (WARN, ERROR)
        else:
            assert finding.level is OK


def test_the_worst_comes_first_and_nothing_is_left_out():
    finding = found("Motors", stop_button=True, fault_flags=FaultFlags.ENCODER_FAILURE | FaultFlags.GYRO_FAULT)
    assert finding.level is ERROR and finding.message.startswith("a wheel encoder fails")
    assert "gyro" in finding.message and "STOP button" in finding.message


# --- The window ---

def counted(sips, bad=0, stray=0, reconnects=0, questions=0, unanswered=0):
    return LinkCounts(sips, bad, stray, 0, 0, questions, unanswered, reconnects, None)


def test_the_window_is_silent_within_its_first_second_and_then_counts_what_came():
    window = LinkWindow()
    assert window.recent(100.0, counted(50, 3, 200)) is None and window.recent(100.9, counted(59, 3, 200)) is None
    assert window.recent(101.0, counted(60, 4, 207, questions=5, unanswered=2)) == (1.0, 10, 1, 7, 5, 2)


def test_the_window_forgets():
    window = LinkWindow()
    for second in range(20):
        recent = window.recent(100.0 + second, counted(10 * second, bad=1 if second > 5 else 0))
        assert second == 0 or recent.packets == 10 * recent.seconds <= 10 * WINDOW
        assert second == 0 or recent.bad_checksums == (1 if 5 < second < 6 + WINDOW else 0)


def test_the_window_keeps_few_samples_however_often_it_is_asked():
    window = LinkWindow()
    for step in range(10000):
        recent = window.recent(step * 0.01, counted(step))
    assert len(window._samples) < 12 and WINDOW <= recent.seconds < WINDOW + 1


def test_a_window_that_nobody_looked_through_for_long_begins_anew():
    window = LinkWindow()
    window.recent(0.0, counted(0))
    assert window.recent(5.0, counted(50)) is not None
    assert window.recent(500.0, counted(4000, bad=300)) is None, "what was then is not lately"
    assert window.recent(501.0, counted(4010, bad=300)) == (1.0, 10, 0, 0, 0, 0)


def test_a_new_link_begins_anew():
    window = LinkWindow()
    window.recent(0.0, counted(0)), window.recent(5.0, counted(50))
    assert window.recent(60.0, counted(50, 9, 900, reconnects=1)) is None
    assert window.recent(61.0, counted(60, 9, 900, reconnects=1)) == (1.0, 10, 0, 0, 0, 0)


# --- Health ---

@pytest.fixture
def health():
    return Health("/dev/ttyUSB0", 9600, ENABLE)


def levels(health, now=0.0, counts=COUNTS):
    return {task: finding.level for task, finding in health.report(now, counts).items()}


def test_without_a_robot_the_link_is_the_error_and_the_rest_is_stale(health):
    assert levels(health) == dict(dict.fromkeys(TASKS, STALE), Link=ERROR)
    assert health.hardware_id == NO_HARDWARE


def test_a_state_is_judged_anew_when_anything_in_it_changed_that_a_finding_reads():
    """`State` above has exactly the fields that findings read. A finding that reads another field fails in every test
    here.
    """
    assert sorted([*JUDGED, "time", "moving"]) == sorted(field.name for field in fields(State))


def test_with_a_robot_all_is_well_under_its_name(health):
    health.event(Ready(identity()))
    health.state(State())
    assert levels(health) == dict.fromkeys(TASKS, OK)
    assert health.hardware_id == "sim_0001"


def test_a_lost_link_takes_everything_with_it_but_the_name_and_back(health):
    health.event(Ready(identity()))
    health.state(State())
    health.event(LinkDown(LinkLostError("the robot has fallen silent"), 0.2))
    assert levels(health) == dict(dict.fromkeys(TASKS, STALE), Link=ERROR)
    assert health.report(0.0, COUNTS)["Link"].message == "no link: the robot has fallen silent"
    assert health.hardware_id == "sim_0001"
    health.event(Ready(identity()))
    assert levels(health)["Battery"] is STALE       # what was true before the link was lost may not be true now
    health.state(State())
    assert levels(health) == dict.fromkeys(TASKS, OK)


def test_only_a_change_of_a_level_is_worth_a_report_at_once(health):
    health.event(Ready(identity()))
    assert health.state(State())
    assert not health.state(State()) and not health.state(State(motors_enabled=False, battery_voltage=12.1))
    assert health.state(State(stop_button=True)) and not health.state(State(stop_button=True)) and health.state(State())
    assert health.event(LinkDown(LinkLostError("cable"), 0.2))
    assert not health.event(LinkDown(LinkLostError("still"), 0.5))
    health.event(Ready(identity()))
    assert health.state(State())


def test_the_first_failure_to_connect_is_worth_one_too(health):
    assert health.event(LinkDown(LinkLostError("no such port"), 0.2))
    assert not health.event(LinkDown(LinkLostError("no such port"), 0.5))


def test_events_leave_their_traces_in_the_values(health):
    health.event(BaudFound(38400))
    health.event(Ready(identity()))
    health.state(State())
    report = health.report(0.0, COUNTS)
    assert dict(report["Link"].values)["Baud"] == "38400"
    assert dict(report["Motors"].values)["Stopped by itself last"] == "never"
    problem = "no answer at 38400 baud"
    for speed, told in ((LineSpeed(9600, problem), "9600 (%s)" % problem), (LineSpeed(115200, ""), "115200")):
        health.event(speed)
        assert dict(health.report(0.0, COUNTS)["Link"].values)["Baud"] == told
    health.event(MotionCleared("the STOP button is pressed"))
    assert dict(health.report(0.0, COUNTS)["Motors"].values)["Stopped by itself last"] == "the STOP button is pressed"
    health.event(CommandTimedOut(0.6))
    assert dict(health.report(0.0, COUNTS)["Motors"].values)["Stopped by itself last"] == "no velocity came for 0.6 s"


def test_motors_that_the_robot_took_away_are_named_until_they_are_on_again(health):
    health.event(Ready(identity()))
    health.state(State())
    health.state(State(motors_enabled=False))
    assert levels(health)["Motors"] is OK       # somebody may have asked for that
    assert health.event(MotionCleared("the robot switched its motors off"))
    assert not health.state(State(motors_enabled=False))
    finding = health.report(0.0, COUNTS)["Motors"]
    advice = "the robot took its motors away (STOP or MOTORS button, a fault): see why, then " + ENABLE
    assert finding[:2] == (WARN, advice)
    assert health.state(State()) and levels(health)["Motors"] is OK


def test_a_robot_that_does_not_move_is_named_until_it_does(health):
    health.event(Ready(identity()))
    health.state(State())
    assert health.event(Unmoved(2.04)) and not health.state(State())
    finding = health.report(0.0, COUNTS)["Motors"]
    assert finding.level is WARN
    assert finding.message.startswith("told to drive, the robot has not moved for 2 s: does it hear?")
    assert health.state(State(moving=True)) and levels(health)["Motors"] is OK


@pytest.mark.parametrize(
    "told", [MotionCleared("the STOP button is pressed"), Unmoved(2.0)], ids=lambda event: type(event).__name__)
def test_a_new_link_knows_nothing_of_the_motors_of_the_one_before(health, told):
    for event in (Ready(identity()), told, LinkDown(LinkLostError("cable"), 0.2), Ready(identity())):
        health.event(event)
    health.state(State(motors_enabled=False))
    assert levels(health)["Motors"] is OK


@pytest.mark.parametrize("cycle_ms, times, lost", [
    (100, (5.0, 5.1, 5.2), 0), (100, (5.0, 5.13, 5.19, 5.3), 0), (100, (5.0, 5.2), 1), (100, (5.0, 5.1, 5.6), 4),
    (20, (5.0, 5.02, 5.1), 3), (100, (5.0, 5.3, 5.3, 5.3, 5.4), 0)])
def test_packets_that_do_not_come_are_counted_and_those_that_come_late_are_not(health, cycle_ms, times, lost):
    health.event(Ready(identity(sip_cycle_ms=cycle_ms)))
    for time in times:
        health.state(State(time=time))
    assert dict(health.report(6.0, COUNTS)["Link"].values)["Packets of this link that got lost"] == str(lost)
    health.event(Ready(identity()))
    health.state(State(time=100.0))
    assert dict(health.report(101.0, COUNTS)["Link"].values)["Packets of this link that got lost"] == "0"


def test_noise_while_connecting_is_not_held_against_the_link(health):
    health.report(0.0, COUNTS)
    health.event(Ready(identity()))
    health.state(State())
    assert levels(health, 3.0, counted(1, bad=5, stray=4000))["Link"] is OK
    assert levels(health, 4.0, counted(11, bad=5, stray=4000))["Link"] is OK
    assert levels(health, 5.0, counted(21, bad=6, stray=4000))["Link"] is WARN


# --- The aggregator's file ---

def fits(text, robot):
    """Return whether a file for the aggregator names exactly what the driver publishes, and knows navigation.

    A name is the node without its first slash, a colon, and the task.
    """
    analyzer = yaml.safe_load(text.replace("$(arg robot)", robot))
    names = ["%s/p2os: %s" % (robot, task) for task in TASKS]
    of_navigation = "%s/navigation: " % robot
    have_prefix = (analyzer["startswith"] == of_navigation in analyzer["remove_prefix"]
                   and all(name.startswith(tuple(analyzer["remove_prefix"])) for name in names))
    return sorted(analyzer["expected"]) == sorted(names) and have_prefix


@pytest.mark.parametrize("robot", ["pioneer", "fleet/left"])
def test_the_aggregators_file_fits_the_driver(robot):
    assert fits(AGGREGATOR, robot)


@pytest.mark.parametrize("old, new", [
    ("p2os: Link", "p2os: Line"),
    ('  - "$(arg robot)/p2os: Bumpers"\n', ""),
    ('  - "$(arg robot)/p2os: Stall"\n', '  - "$(arg robot)/p2os: Stall"\n  - "$(arg robot)/p2os: Arm"\n'),
    ("/p2os: ", "/driver: "), ('startswith: "$(arg robot)/navigation: "', 'startswith: "navigation"'),
    (', "$(arg robot)/navigation: "]', "]"),
])
def test_a_name_too_few_too_many_or_misspelt_does_not(old, new):
    assert old in AGGREGATOR and not fits(AGGREGATOR.replace(old, new), "pioneer")


@pytest.mark.parametrize("helm, level, text", [
    (HelmState(), OK, "nobody commands"),
    (HelmState("cmd_vel", "/wander"), OK, "cmd_vel commands (/wander)"),
    (HelmState("teleop/cmd_vel", "/joy", "teleop/cmd_vel"), OK, "a person commands on teleop/cmd_vel (/joy)"),
    (HelmState("", "/joy", "teleop/cmd_vel"), OK, "a person has the helm; release it"),
    (HelmState("", "/joy", "teleop/cmd_vel", ("stop_all",)), WARN, "the lock is set; take it away"),
    (HelmState(locks=("another",)), WARN, "another is set"),
])
def test_who_commands_is_said(helm, level, text):
    told = {"stop_all": "the lock is set; take it away", "teleop/cmd_vel": "a person has the helm; release it"}
    health = Health("/dev/ttyUSB0", 9600, ENABLE, told)
    health.event(Ready(identity()))
    health.state(State())
    finding = health.report(0.0, COUNTS, helm)["Helm"]
    assert (finding.level, finding.message) == (level, text)
    assert finding.values["Locks"] == (", ".join(helm.locks) or "none")
    assert finding.values["Programs"] == ("locked out" if helm.holder else "may command")

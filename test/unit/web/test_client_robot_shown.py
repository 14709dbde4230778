"""A robot of the client library as the page shows it: frame, entry and status, with the words of diagnostics."""

import json
import math

import pytest

from pioneer_control.client import CommandTimedOut, LinkDown, MotionCleared, MotorsAnswered, Ready, SonarRange, Unmoved
from pioneer_control.client.fault_flags import Level
from pioneer_control.client.gripper import read_gripper
from pioneer_control.client.health import TASKS, Finding
from pioneer_control.client.identity import RobotIdentity
from pioneer_control.client.state import RobotState
from pioneer_control.errors import LinkLostError, RefusedError
from pioneer_control.p2os import ChargeState, Flags, GripperCommand, GripState
from pioneer_control.robots import find_model
from pioneer_control.web.client_robot import (
    COMMANDS, ClientRobot, entry_of, frame_of, gripper_bits, sentence_of, status_of)
from pioneer_control.web.frames import FrameFlags, GripperBits, RobotFrame, encode_frame
from pioneer_control.web.orders import GRIPPER_COMMANDS
from pioneer_control.web.program_line import INPUT as PROGRAM

MODEL = find_model("p3dx-sh")
STATE = RobotState(
    time=10.0, sent_time=10.0, x=1.5, y=-0.5, heading=0.1, linear=0.2, angular=-0.3, wheel_velocities=(0.2, 0.2),
    wheel_angles=None, x_counts=0, y_counts=0, motors_enabled=False, stop_button=False, left_stall=False,
    right_stall=False, front_bumpers=(), rear_bumpers=(), battery_voltage=12.62, sonar=(), sonar_enabled=False,
    gripper=None, digital_in=0, digital_out=0, analog_port=0, analog_voltage=None, flags=Flags(0), fault_flags=None,
    compass=None, charge_state=None, temperature=None, state_of_charge=None)
WELL = {task: Finding(Level.OK, "fine", {}) for task in TASKS}


def changed(**values):
    return RobotState(**dict(vars(STATE), **values))


def test_the_values_of_a_frame():
    assert frame_of(7, STATE, 10.25, True, False) == RobotFrame(
        7, 10250, 0.25, 1.5, -0.5, 0.1, 0.2, -0.3, int(FrameFlags.LINK), 0, ())


@pytest.mark.parametrize("values, flag", [
    (dict(motors_enabled=True), FrameFlags.MOTORS), (dict(stop_button=True), FrameFlags.STOP_BUTTON),
    (dict(left_stall=True), FrameFlags.LEFT_STALL), (dict(right_stall=True), FrameFlags.RIGHT_STALL),
    (dict(front_bumpers=(False, True)), FrameFlags.FRONT_BUMPER), (dict(rear_bumpers=(True,)), FrameFlags.REAR_BUMPER),
    (dict(front_bumpers=(False,), rear_bumpers=(False,)), 0), (dict(sonar_enabled=True), FrameFlags.SONAR),
    (dict(charge_state=ChargeState.BULK), FrameFlags.CHARGING), (dict(charge_state=ChargeState.NOT_CHARGING), 0),
    (dict(flags=Flags.CHARGER_POWER), FrameFlags.CHARGING)])
def test_flags(values, flag):
    assert frame_of(1, changed(**values), 10.0, False, False).flags == flag


def test_link_and_lock_are_flags():
    assert frame_of(1, STATE, 10.0, False, True).flags == FrameFlags.LOCKED
    assert frame_of(1, STATE, 10.0, True, False).flags == FrameFlags.LINK


def test_sonar_without_an_echo_not_heard_and_too_old():
    sonar = (SonarRange(1.25, 9.0), SonarRange(5.0, 9.0), None, SonarRange(1.25, 7.9))
    frame = frame_of(1, changed(sonar=sonar), 10.0, True, False)
    assert frame.sonar == (1.25, math.inf, None, None)
    assert encode_frame(frame)[-4:] == bytes([62, 251, 255, 255])


def test_gripper_bits():
    assert gripper_bits(None) == 0
    inner = 4       # the inner beam, broken
    assert gripper_bits(read_gripper(GripState.OPEN | GripState.LIFT_DOWN, 0)) == (
        GripperBits.FITTED | GripperBits.PADDLES_OPEN | GripperBits.LIFT_DOWN)
    holding = gripper_bits(read_gripper(GripState.CLOSED | GripState.LIFT_UP | GripState.MOVING, inner))
    assert holding & GripperBits.PADDLES_CLOSED and holding & GripperBits.LIFT_UP and holding & GripperBits.HOLDS
    assert holding & GripperBits.PADDLES_MOVING and not holding & GripperBits.LIFT_MOVING


def test_every_gripper_command_of_the_page_is_one_of_the_robots():
    assert set(COMMANDS) == set(GRIPPER_COMMANDS)
    assert COMMANDS["up"] is GripperCommand.LIFT_UP and COMMANDS["stop"] is GripperCommand.HALT


def test_the_entry_of_a_robot():
    identity = RobotIdentity("sim_0007", "Pioneer", "p3dx-sh", None, None, MODEL, True, 0.5, 1.75)
    entry = entry_of(7, "socket://127.0.0.1:8107", identity, True)
    assert (entry["robot"], entry["name"], entry["model"], entry["simulated"]) == (7, "sim_0007", "p3dx-sh", True)
    assert len(entry["outline"]) == 8 and len(entry["sonar"]) == 16 and len(entry["sonar"][0]) == 3
    assert entry["max_linear"] == 0.5 and entry["gripper"] is True
    json.dumps(entry, allow_nan=False)


def test_transducers_have_the_places_of_their_numbers():
    identity = RobotIdentity("", "Pioneer", "x", None, None, MODEL.with_arrays(False, True), False, 0.5, 1.75)
    entry = entry_of(1, "/dev/ttyUSB0", identity, False)
    assert entry["sonar"][:8] == [None] * 8 and None not in entry["sonar"][8:] and entry["name"] == "/dev/ttyUSB0"
    assert len(entry["outline"]) == 4


def test_a_robot_that_nobody_knows_yet():
    entry = entry_of(1, "/dev/ttyUSB0", None, False)
    assert (entry["name"], entry["model"], entry["outline"], entry["sonar"]) == ("/dev/ttyUSB0", "", [], [])


def test_the_status_has_the_words_of_diagnostics():
    findings = dict(WELL, Stall=Finding(Level.WARN, "the left wheel is stalled", {}),
                    Battery=Finding(Level.ERROR, "battery nearly empty", {}))
    status = status_of(1, findings, STATE, None, {"bad_checksums": 3})
    assert status == {
        "robot": 1, "link": "ok", "battery": {"volts": 12.6, "charge": None, "level": "error"},
        "faults": [{"level": "error", "task": "Battery", "text": "battery nearly empty"},
                   {"level": "warn", "task": "Stall", "text": "the left wheel is stalled"}],
        "decision": None, "counts": {"bad_checksums": 3}}


def test_a_lost_link_says_why_and_nothing_old_is_a_fault():
    findings = dict.fromkeys(TASKS, Finding(Level.STALE, "not known", {}))
    status = status_of(1, dict(findings, Link=Finding(Level.ERROR, "no link: silent", {})), None, "silent", {})
    assert status["link"] == "looking for the robot" and status["lost"] == "silent" and status["battery"] is None
    assert [fault["task"] for fault in status["faults"]] == ["Link"]


@pytest.mark.parametrize("event, level, words", [
    (LinkDown(LinkLostError("cable pulled"), 0.2), "error", "cable pulled"),
    (MotionCleared("STOP button"), "warn", "STOP button"), (Unmoved(2.0), "warn", "2 s"),
    (CommandTimedOut(0.5), "warn", "0.5 s")])
def test_events_are_told(event, level, words):
    told = sentence_of(event)
    assert told[0] == level and words in told[1]


class Outside:
    """A feed, and the stage of a robot."""

    def __init__(self):
        self.frames, self.changes, self.told = [], [], []

    def frame(self, frame):
        self.frames.append(frame)

    def changed(self, robot):
        self.changes.append(robot)

    def tell(self, robot, level, text, viewers=None):
        self.told.append((level, text, viewers))


def test_the_pose_at_which_a_session_began_and_no_frame_before_the_page_knows_the_robot():
    outside = Outside()
    robot = ClientRobot(1, "socket://127.0.0.1:1", outside, outside)
    ready = Ready(RobotIdentity("a", "Pioneer", "p3dx-sh", None, None, MODEL, True, 0.5, 1.75))
    for x, sessions in ((0.0, 1), (1.5, 2)):
        robot._on_event(ready)
        robot._on_state(changed(x=x, y=0.0, heading=0.2))
        robot._on_state(changed(x=x + 0.5, y=0.0, heading=0.4))
        assert robot.base == (x, 0.0, 0.2)
    assert outside.frames == []
    robot.introduced = True
    robot._on_state(changed(x=2.0))
    assert len(outside.frames) == 1


def test_who_may_command_in_the_words_of_the_page():
    """A program drives, a person takes over and locks it out, and gives it back; a lock is before all."""
    outside = Outside()
    robot = ClientRobot(1, "socket://127.0.0.1:1", outside, outside)
    robot.robot.set_velocity = lambda *_: None      # it has no link
    assert robot.programs == "none" and robot.locks == ()
    robot.has_programs = True
    assert robot.programs == "free"
    robot.steered.set_velocity(PROGRAM, 0.1, 0.0)
    assert robot.programs == "driving"
    robot.drive(0.1, 0.0)
    assert robot.programs == "locked out"
    with pytest.raises(RefusedError, match="a person has the helm"):
        robot.steered.set_velocity(PROGRAM, 0.1, 0.0)
    robot.release()
    robot.lock()
    assert robot.locks == ("stop",) and outside.changes
    for drive in (robot.drive, lambda *velocity: robot.steered.set_velocity(PROGRAM, *velocity)):
        with pytest.raises(RefusedError, match="unlock it first"):
            drive(0.1, 0.0)
    robot.unlock()
    assert robot.programs == "free" and robot.locks == ()
    robot.take()
    assert robot.programs == "locked out"


def test_what_happens_is_told_once_and_motors_that_stay_off_only_to_who_asked():
    outside = Outside()
    robot = ClientRobot(1, "socket://127.0.0.1:1", outside, outside)
    for _ in range(3):
        robot._on_event(LinkDown(LinkLostError("cable pulled"), 0.2))
    assert outside.told == [("error", "cable pulled", None)]
    robot.asked = 7
    robot._on_event(MotorsAnswered(True, True, RefusedError("STOP button")))
    assert outside.told[1:] == [("error", "STOP button", [7])]
    robot._on_event(MotorsAnswered(True, True, None))
    assert len(outside.told) == 2

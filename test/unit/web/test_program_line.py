"""The robot's side of the line to a program: bytes in, bytes out, and what reaches the robot."""

from types import SimpleNamespace

import pytest

from pioneer_control import p2os
from pioneer_control.client import HelmState
from pioneer_control.errors import LinkLostError, RefusedError
from pioneer_control.p2os import Flags, Frame, FrameDecoder, GripperCommand, decode_packet, encode_command
from pioneer_control.robots import find_model
from pioneer_control.web.program_line import INPUT, PASSED_ON, RENEW, WATCHDOG, ProgramLine

SYNC = [bytes.fromhex(data) for data in ("FAFB03000000", "FAFB03010001", "FAFB03020002")]      # protocol 2.1
OPEN, CLOSE, PULSE = (encode_command(name) for name in ("OPEN", "CLOSE", "PULSE"))


class Robot:
    """Takes note of what reaches the robot. It is its own SteeredRobot."""

    def __init__(self):
        self.told, self.ready, self.use_sonar, self.error, self.holder = [], True, True, None, ""
        self.identity = SimpleNamespace(name="sim_0007", type="Pioneer", subtype="p3dx-sh", model=find_model("p3dx-sh"))

    def state(self):
        return HelmState(holder=self.holder)

    def __getattr__(self, name):
        def told(*values):
            if self.error is not None:
                raise self.error
            self.told.append((name, *values))
        return told

    def set_sonar(self, on):
        self.use_sonar = on
        self.told.append(("set_sonar", on))

    def take(self):
        told, self.told = self.told, []
        return told


@pytest.fixture
def robot():
    return Robot()


@pytest.fixture
def said():
    return []


@pytest.fixture
def line(robot, said):
    return ProgramLine(robot, robot, "Ada", said.append)


@pytest.fixture
def open_line(line, robot):
    line.receive(b"".join(SYNC) + OPEN, 0.0)
    line.data_to_send()
    robot.take()
    return line


def sip(**values):
    """Return the frame of a SIP."""
    made = p2os.Sip(0x32, **dict(dict(
        x_counts=0, y_counts=0, heading_units=0, left_velocity_units=0, right_velocity_units=0, battery_dv=125,
        left_stall_bits=0, right_stall_bits=0, control_units=0, flags=0, compass=0, sonar=()), **values))
    frame, = FrameDecoder().feed(p2os.encode_packet(made))
    return frame


def heard(line):
    """Return the packets that the program gets."""
    return [decode_packet(frame) for frame in FrameDecoder().feed(line.data_to_send())]


def speed(linear, angular=0.0):
    return "set_velocity", INPUT, pytest.approx(linear), pytest.approx(angular, abs=1e-6), "Ada"


# The handshake

def test_each_sync_is_echoed_and_the_last_tells_the_name(line):
    answers = []
    for packet in SYNC:
        line.receive(packet, 0.0)
        answers.append(line.data_to_send())
    assert answers[:2] == SYNC[:2]
    assert answers[2].hex() == "fafb1c02" + b"sim_0007\0Pioneer\0p3dx-sh\0".hex() + answers[2][-2:].hex()


@pytest.mark.parametrize("numbers, answered", [
    ([1], []), ([2], []), ([0, 2], [0]), ([0, 0, 1], [0, 0, 1]), ([0, 1, 1], [0, 1]), ([0, 1, 0, 1], [0, 1, 0, 1]),
    ([7, 0], [0])])
def test_a_packet_out_of_order_begins_the_handshake_anew(line, numbers, answered):
    for number in numbers:
        line.receive(p2os.encode_frame(number), 0.0)
    assert [packet.number for packet in heard(line)] == answered


@pytest.mark.parametrize("ready", [False, None])
def test_without_the_robot_there_is_silence(line, robot, ready):
    if ready is None:
        robot.identity = None
    else:
        robot.ready = False
    line.receive(SYNC[0], 0.0)
    assert line.data_to_send() == b""


def test_the_session_begins_with_open_and_ends_with_close(line):
    line.receive(b"".join(SYNC), 0.0)
    line.data_to_send()
    line.report(sip())
    assert line.data_to_send() == b""
    line.receive(OPEN, 0.0)
    line.report(sip())
    assert len(heard(line)) == 1
    line.receive(CLOSE, 0.0)
    line.report(sip())
    assert line.data_to_send() == b"" and not line.is_open
    line.receive(SYNC[0], 0.0)
    assert line.data_to_send() == SYNC[0]


def test_bytes_come_in_any_pieces_and_noise_is_skipped(line):
    for byte in b"\x00\xfa" + b"".join(SYNC) + b"\xfa\xfb\xff" + b"noise" * 60 + OPEN:
        line.receive(bytes([byte]), 0.0)
    assert line.is_open


# What the program gets

def test_packets_come_as_the_robot_sent_them(open_line):
    frame = Frame(0x90, bytes(range(8)))
    open_line.report(frame)
    assert open_line.data_to_send() == p2os.encode_frame(0x90, bytes(range(8)))


def test_motors_are_shown_on_only_when_this_program_asked_for_them(open_line):
    on = sip(flags=Flags.MOTORS_ENABLED | Flags.SONAR_1, x_counts=77)
    open_line.report(on)
    shown, = heard(open_line)
    assert shown.flags == Flags.SONAR_1 and shown.x_counts == 77
    open_line.receive(encode_command("ENABLE", 1), 0.0)
    open_line.report(on)
    assert open_line.data_to_send() == p2os.encode_frame(on.id, on.data)
    open_line.receive(encode_command("ENABLE", 0), 0.0)
    open_line.report(on)
    assert heard(open_line)[0].flags == Flags.SONAR_1


def test_after_the_stop_button_motors_must_be_asked_for_anew(open_line):
    open_line.receive(encode_command("ENABLE", 1), 0.0)
    open_line.report(sip(flags=Flags.STOP_BUTTON))
    open_line.report(sip(flags=Flags.MOTORS_ENABLED))
    assert [packet.flags for packet in heard(open_line)] == [Flags.STOP_BUTTON, 0]


def test_config_is_what_the_robot_said_before(line, robot):
    frame, = FrameDecoder().feed(p2os.encode_frame(0x20, b"Pioneer\0p3dx-sh\0123\0" + bytes(60)))
    line.report(frame)
    line.receive(b"".join(SYNC) + OPEN, 0.0)
    line.data_to_send()
    line.receive(encode_command("CONFIG", 1), 0.0)
    assert line.data_to_send() == p2os.encode_frame(frame.id, frame.data) and robot.take() == []


def test_a_config_that_nobody_knows_is_asked_for(open_line, robot):
    open_line.receive(encode_command("CONFIG", 1), 0.0)
    assert robot.take() == [("send", encode_command("CONFIG", 1))]


# What reaches the robot

def test_velocities_of_one_piece_are_one_command(open_line, robot):
    open_line.receive(encode_command("VEL", 200) + encode_command("RVEL", -90), 1.0)
    assert robot.take() == [speed(0.2, -1.570796)]
    open_line.receive(encode_command("VEL", -100), 1.1)       # the turn stays, as on a robot
    assert robot.take() == [speed(-0.1, -1.570796)]
    open_line.receive(encode_command("STOP"), 1.2)
    assert robot.take() == [speed(0.0)]


def test_wheels(open_line, robot):
    open_line.receive(encode_command("VEL2", -5, 10), 1.0)
    assert robot.take() == [("set_wheel_velocities", INPUT, pytest.approx(-0.1), pytest.approx(0.2), "Ada")]
    open_line.receive(encode_command("RVEL", 0), 1.1)         # RVEL takes over from VEL2
    assert robot.take() == [speed(0.0)]


def test_a_velocity_is_renewed_while_the_program_is_heard_and_no_longer(open_line, robot, said):
    open_line.receive(encode_command("VEL", 200), 1.0)
    assert open_line.due == 1.0 + RENEW
    open_line.tick(1.0 + RENEW - 0.01)
    assert len(robot.take()) == 1
    open_line.tick(1.0 + RENEW)
    assert robot.take() == [speed(0.2)]
    open_line.receive(PULSE, 1.5)
    open_line.tick(1.5 + WATCHDOG - 0.01)
    assert robot.take() == [speed(0.2)]
    open_line.tick(1.5 + WATCHDOG)
    assert robot.take() == [speed(0.0)] and "not been heard" in said[-1]
    open_line.tick(9.0)
    assert robot.take() == [] and open_line.due == float("inf")


def test_a_velocity_that_the_helm_refuses_is_forgotten(open_line, robot, said):
    robot.error = RefusedError("program refused: a person has the helm")
    open_line.receive(encode_command("VEL", 200), 1.0)
    assert said == ["program refused: a person has the helm"]
    robot.error = None
    open_line.tick(2.0)
    assert robot.take() == []
    open_line.receive(encode_command("VEL", 200), 2.1)
    assert robot.take() == [speed(0.2)]


def test_a_stop_that_the_helm_refuses_says_nothing(open_line, robot, said):
    robot.error = RefusedError("program refused: a person has the helm")
    open_line.receive(encode_command("STOP"), 1.0)
    assert said == []


def test_what_comes_before_open_moves_nothing(line, robot):
    line.receive(b"".join(SYNC), 0.0)
    for command in (encode_command("VEL", 200), encode_command("ENABLE", 1), encode_command("GRIPPER", 1),
                    encode_command("VEL2", 9, 9), encode_command("SONAR", 0), encode_command("DIGOUT", 255, 255)):
        line.receive(command, 0.0)
    assert robot.take() == []


@pytest.mark.parametrize("name, value", [
    ("MOVE", 1000), ("HEAD", 90), ("DHEAD", 90), ("ROTATE", 50), ("SETA", 100), ("SETV", 2000), ("SETO", None),
    ("RESET", None), ("MAINTENANCE", None), ("HOSTBAUD", 4), ("TICKSMM", 1), ("POWER_PC", 0), ("ARM_POWER", 1)])
def test_what_others_would_feel_is_refused_and_said(open_line, robot, said, name, value):
    open_line.receive(encode_command(name, *([] if value is None else [value])), 0.0)
    assert robot.take() == [] and said == ["%s refused: a program that shares a robot may not do that" % name]


@pytest.mark.parametrize("name", ["VEL", "RVEL", "VEL2", "ENABLE", "GRIPPER", "GRIPPERVAL", "SONAR", "STOP", "OPEN"])
def test_an_argument_of_another_kind_is_no_number(open_line, robot, said, name):
    open_line.receive(p2os.encode_frame(p2os.COMMANDS[name].number, b"\x2b\x03abc"), 0.0)
    assert {each[0] for each in robot.take()} <= {"set_velocity", "set_sonar"} and "b'" not in "".join(said)


def test_an_unknown_command_is_refused(open_line, robot, said):
    open_line.receive(p2os.encode_frame(200, b"\x3b\x01\x00"), 0.0)
    assert robot.take() == [] and said == ["COMMAND_200 refused: a program that shares a robot may not do that"]


def test_requests_and_outputs_are_passed_on(open_line, robot):
    packet = encode_command("DIGOUT", 3, 1)
    open_line.receive(packet, 0.0)
    assert robot.take() == [("send", packet)]
    assert not PASSED_ON & {"VEL", "RVEL", "VEL2", "MOVE", "ENABLE", "GRIPPER", "RESET"}


def test_the_gripper_goes_through_the_helm_with_its_value(open_line, robot, said):
    open_line.receive(encode_command("GRIPPER", 1), 0.0)
    open_line.receive(encode_command("GRIPPERVAL", -20) + encode_command("GRIPPER", 17), 0.0)
    open_line.receive(encode_command("GRIPPER", 15), 0.0)
    open_line.receive(p2os.encode_frame(33, b"\x3b\x63\x00"), 0.0)
    assert robot.take() == [("move_gripper", INPUT, [(GripperCommand(number), value)], stops, "Ada")
                            for number, value, stops in ((1, None, False), (17, -20, False), (15, None, True))]
    assert said == ["GRIPPER 99 refused: it is no command"]


@pytest.mark.parametrize("end", [lambda line: line.end(), lambda line: line.receive(CLOSE, 2.0)])
def test_the_end_stops_at_once_and_takes_back_what_was_switched(open_line, robot, end):
    open_line.receive(encode_command("ENABLE", 1) + encode_command("SONAR", 0) + encode_command("VEL", 200), 1.0)
    robot.take()
    end(open_line)
    assert robot.take() == [speed(0.0), ("request_motors", False), ("set_sonar", True)]
    assert not open_line.is_open
    open_line.tick(9.0)
    open_line.end()
    assert robot.take() == []


def test_the_end_leaves_the_motors_to_a_person_who_has_the_helm(open_line, robot):
    open_line.receive(encode_command("ENABLE", 1), 1.0)
    robot.holder = "person"
    robot.take()
    open_line.end()
    assert robot.take() == []


def test_motors_that_this_program_never_asked_for_stay_as_they_are(open_line, robot):
    """The client of this package begins each session with motors off."""
    open_line.receive(encode_command("ENABLE", 0), 1.0)
    assert robot.take() == []


def test_without_a_link_the_end_is_quiet(open_line, robot):
    open_line.receive(encode_command("ENABLE", 1) + encode_command("VEL", 200), 1.0)
    robot.error = LinkLostError("cable")
    open_line.end()
    assert not open_line.is_open

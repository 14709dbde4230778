"""The handshake: from a port in an unknown state to a robot that has sent its name."""

import inspect
import math
import random
import re

import pytest

from pioneer_control import p2os
from pioneer_control.client import Robot, handshake
from pioneer_control.client.events import BaudFound, Ready
from pioneer_control.client.handshake import (
    CLOSES, CLOSES_IF_HEARD, DRAIN, LISTEN, QUIET, RATES, SYNC_TIMEOUT, SYNC_TRIES, TCP_TRIES, TCP_TRY_WITH_SYNC1)
from pioneer_control.client.line import GAP
from pioneer_control.client.phases import BEFORE_OPEN, CONFIG_TIMEOUT, Opening
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.errors import LinkLostError, NoAnswerError, UnknownModelError

from fake_robot import OPEN, STEP, SYNCED, WAITING, Bench, FakeRobot
from strict_robot import StrictRobot

CLOSE, SYNC0 = bytes.fromhex("FAFB03020002"), bytes.fromhex("FAFB03000000")


def first_write(bench):
    return next(iter(bench.writes.items()))


def on_serial(robot=None, baud=9600, **settings):
    """Return a bench with a serial line at the speed of the robot."""
    robot = robot or FakeRobot()
    robot.baud = baud
    return Bench(robot, rates=(baud,), **settings)


def left_open(robot):
    """Make the robot open, and stopped by its watchdog. Any packet but CLOSE makes it drive again."""
    robot.open()
    robot.motors, robot.set_point["VEL"], robot.watchdog_expired = True, 300, True
    return robot


def on_line(line, robot=None):
    return Bench(robot) if line == "TCP" else on_serial(robot)


LINES = pytest.mark.parametrize("line", ["TCP", "serial"])


@LINES
def test_listens_for_two_sip_cycles_before_it_says_anything(line):
    time, (data,) = first_write(on_line(line).until_ready())
    assert 0.2 <= time <= 0.31
    assert data == (SYNC0 if line == "TCP" else CLOSE)


def test_on_tcp_a_silent_robot_hears_sync0_and_nothing_before_it():
    """This holds byte for byte: for a robot that waits, any packet is a step of the handshake."""
    bench = Bench().until_ready()
    written = b"".join(data for written in bench.writes.values() for data in written)
    assert written.startswith(bytes.fromhex("FAFB03000000 FAFB03010001 FAFB03020002 FAFB03010001 FAFB031D001D"))


def test_on_tcp_a_silent_robot_hears_no_close_at_any_try_but_when_the_client_hangs_up():
    robot = FakeRobot()
    robot.deaf = lambda heard: True
    bench = Bench(robot)
    bench.run_until(lambda: bench.finished)
    tries = ["PULSE"] * (TCP_TRY_WITH_SYNC1 + 1) + ["OPEN"] + ["PULSE"] * (TCP_TRIES - TCP_TRY_WITH_SYNC1 - 1)
    assert robot.names() == tries + ["CLOSE"] * CLOSES
    assert len(tries) < 10, "the vendor's simulator hangs up after ten packets"
    assert {heard.time for heard in robot.heard[len(tries):]} == {bench.now}


@pytest.mark.parametrize("ends", ["in vain", "closed by its user"])
def test_on_tcp_an_open_robot_that_hears_and_is_not_heard_does_not_drive_on(ends):
    """As over a radio that works in only one direction. With each attempt, SYNC0 would make the robot drive again."""
    robot = left_open(FakeRobot())
    robot.mute = lambda packet: True
    bench = Bench(robot)
    bench.run_until(lambda: robot.revived)
    if ends == "closed by its user":
        bench.close()
    bench.run_until(lambda: bench.finished)
    bench.run(0.1)
    assert robot.phase == WAITING and not robot.moving and not robot.motors


class Delayed:
    """Another robot behind a line that delays everything by ``delay`` s in each direction."""

    def __init__(self, robot, delay):
        self.robot, self.delay = robot, delay
        self.baud, self.noisy = None, ()
        self._to_robot, self._to_client = [], []

    def names(self):
        return [heard[-2] for heard in self.robot.heard]

    def receive(self, data, now):
        self._to_robot.append((now + self.delay, data))

    def advance(self, now):
        while self._to_robot and self._to_robot[0][0] <= now:
            self.robot.receive(self._to_robot.pop(0)[1], now)
        self._to_client.append((now + self.delay, self.robot.advance(now)))
        arrived = b""
        while self._to_client[0][0] <= now:
            arrived += self._to_client.pop(0)[1]
            if not self._to_client:
                break
        return arrived


@pytest.mark.parametrize("echo_after", [0.0, 0.2, 0.24, 0.26, 0.3, 0.35, 0.4, 0.45])
@pytest.mark.parametrize("kind", ["TCP", "serial", "strict on TCP"])
def test_a_robot_that_answers_late_is_connected_at_the_first_attempt(kind, echo_after):
    robot = StrictRobot() if kind == "strict on TCP" else FakeRobot()
    Bench(Delayed(robot, echo_after / 2), rates=(9600,) if kind == "serial" else ()).until_ready()
    assert kind != "strict on TCP" or robot.hang_ups == 0


def test_on_serial_a_robot_that_seems_silent_is_closed_all_the_same_before_it_is_synced():
    """A robot whose packets were all lost would take SYNC0 for a sign of life. CLOSE is sent no faster than a robot
    accepts commands, and nothing is sent before it.
    """
    robot = FakeRobot()
    bench = on_serial(robot).until_ready()
    assert robot.names()[:CLOSES + 3] == ["CLOSE"] * CLOSES + ["PULSE", "OPEN", "CLOSE"]
    times = [time for time, written in bench.writes.items() for data in written][:CLOSES]
    assert all(later - time >= GAP - 1e-9 for time, later in zip(times, times[1:])) and times[-1] < 0.32
    assert CLOSES + 3 < 10, "the vendor's simulator hangs up after ten packets"
    assert bench.writes[times[-1]] == [CLOSE + SYNC0], "in one write: its cable may be put back at this very moment"


def test_how_often_close_is_said_leaves_a_robot_alone_that_takes_it_for_sync2():
    assert CLOSES % 2 == 0 and CLOSES_IF_HEARD % 2 == 1 and CLOSES_IF_HEARD >= CLOSES


class AnswersInAnyOrder(FakeRobot):
    """As the vendor's simulator does. Before the session it takes CLOSE for SYNC2, and a SYNC1 right after it for OPEN.
    """

    last = 0

    def _take(self, heard, number, now):
        if self.phase != WAITING:
            super()._take(heard, number, now)
        elif (self.last, number) == (2, 1):
            self.open(now)
        else:
            self.send(p2os.SyncEcho(number) if number < 2 else p2os.SyncReply("fake", "Pioneer", self.subtype))
        self.last = number


def test_a_robot_that_answers_each_of_them_is_synced_at_the_first_try():
    bench = on_serial(AnswersInAnyOrder()).until_ready()
    assert bench.robot.names()[:CLOSES + 4] == ["CLOSE"] * CLOSES + ["PULSE", "OPEN", "CLOSE", "OPEN"]
    assert bench.now < 0.65


@pytest.mark.parametrize("arrives", range(CLOSES))
def test_any_one_of_them_is_enough(arrives):
    robot, closes = left_open(FakeRobot()), []
    robot.mute = lambda packet: isinstance(packet, p2os.Sip) and robot.phase == OPEN and bench.now < LISTEN
    robot.deaf = lambda heard: heard.name == "CLOSE" and len(closes) < arrives and not closes.append(heard)
    bench = on_serial(robot)
    bench.until_ready()
    assert not robot.revived and robot.names()[:arrives + 1] == ["CLOSE"] * (arrives + 1)


def test_a_waiting_robot_is_synced_opened_and_stopped_before_anything_else():
    bench = Bench().until_ready()
    heard = bench.robot.heard[:9]
    assert [each.name for each in heard] == ["PULSE", "OPEN", "CLOSE", "OPEN", "STOP", "VEL", "RVEL", "ENABLE", "SONAR"]
    assert [each.value for each in heard[5:]] == [0, 0, 0, 1]
    assert bench.now < 0.6


def test_the_next_sync_waits_for_the_echo():
    robot = FakeRobot()
    robot.mute = lambda packet: isinstance(packet, p2os.SyncEcho)
    bench = Bench(robot)
    bench.run(0.4)
    assert robot.names() == ["PULSE"]


@LINES
def test_a_robot_left_open_and_driving_gets_close_first_and_never_moves_again(line):
    robot = left_open(FakeRobot())
    bench = on_line(line, robot).until_ready()
    time, (data,) = first_write(bench)
    assert data == CLOSE and time < 0.15
    assert not robot.revived and not robot.motors and not robot.moving
    assert bench.now < 1.0


def test_a_robot_with_the_longest_sip_cycle_is_heard_before_it_is_spoken_to():
    robot = left_open(FakeRobot())
    robot._next_sip = 0.255
    Bench(robot).until_ready()
    assert robot.names()[0] == "CLOSE" and not robot.revived


def test_a_robot_that_does_not_close_is_named_as_such_and_never_opened():
    robot = FakeRobot()
    robot.open()
    robot.deaf = lambda heard: heard.name == "CLOSE"
    bench = Bench(robot)
    bench.run_until(lambda: bench.finished, limit=20.0)
    assert "does not obey CLOSE" in str(bench.session.error) and "OPEN" not in robot.names()


def with_motors_on(robot, by_itself):
    """The robot's motors are on, although nobody asked for it."""
    send = robot.send

    def switch_on_and_send(packet):
        robot.motors = robot.motors or by_itself()
        send(packet)

    robot.send = switch_on_and_send


def test_a_robot_is_ready_only_once_its_motors_are_off():
    robot = FakeRobot()
    robot.deaf = lambda heard: heard.name == "ENABLE" and heard.time < 1.0
    with_motors_on(robot, lambda: bench.now < 0.6)
    bench = Bench(robot)
    bench.until_ready()
    assert bench.now > 1.0 and not robot.motors and not bench.states[0].motors_enabled


def test_a_robot_whose_motors_stay_on_is_closed_again():
    robot = FakeRobot()
    robot.deaf = lambda heard: heard.name == "ENABLE"
    with_motors_on(robot, lambda: True)
    bench = Bench(robot)
    bench.run_until(lambda: bench.finished)
    assert "does not switch its motors off" in str(bench.session.error)
    bench.step()
    assert robot.phase == WAITING


def test_close_is_repeated_while_packets_still_come():
    robot = FakeRobot()
    robot.open()
    robot.deaf = lambda heard: robot.names().count("CLOSE") <= 2 * CLOSES_IF_HEARD
    Bench(robot).until_ready()
    assert robot.names()[:3 * CLOSES_IF_HEARD + 1] == ["CLOSE"] * 3 * CLOSES_IF_HEARD + ["PULSE"]


def test_an_open_robot_of_which_only_noise_arrives_gets_close_before_sync():
    robot = FakeRobot()
    robot.open()
    bench = Bench(robot, to_client=lambda data: data[:-1] + b"\x00" if len(data) > 12 else data)
    bench.run_until(lambda: robot.phase == WAITING)
    assert set(robot.names()) == {"CLOSE"}


@LINES
def test_a_robot_that_was_synced_but_never_opened_is_dislodged(line):
    robot = FakeRobot()
    robot.phase = SYNCED
    bench = on_line(line, robot).until_ready()
    assert bench.now < 2.0
    first = ["PULSE", "PULSE", "PULSE", "OPEN", "CLOSE"]
    assert line == "serial" or robot.names()[:5] == first, "CLOSE once it is heard"


@pytest.mark.parametrize("lost", [p2os.SyncEcho(0), p2os.SyncEcho(1), p2os.SyncReply("fake", "Pioneer", "p3dx-sh")])
def test_a_lost_echo_costs_one_try(lost):
    robot, dropped = FakeRobot(), []
    robot.mute = lambda packet: packet == lost and not dropped and not dropped.append(packet)
    bench = Bench(robot).until_ready()
    assert dropped and bench.now < 2.0


@LINES
@pytest.mark.parametrize("wrong", [
    p2os.SyncEcho(1), p2os.Reset(0xFF, b""), p2os.SyncReply("other", "Pioneer", "p3at-sh")])
def test_an_answer_with_the_wrong_number_is_none(wrong, line):
    robot, swapped = FakeRobot(), []

    def swap(packet):
        if packet == p2os.SyncEcho(0) and not swapped:
            swapped.append(packet)
            robot.send(wrong)
            return True
        return False

    robot.mute = swap
    bench = on_line(line, robot).until_ready()
    tries = 2 if line == "serial" else 3
    assert robot.names().count("PULSE") == tries, "this robot says nothing to a SYNC0 out of turn"
    assert bench.session.connected.identity.name == "fake"


@pytest.mark.parametrize("again", [False, True])
def test_on_serial_no_sync_is_the_first_that_a_robot_hears_whose_cable_is_put_back(again):
    robot = FakeRobot()
    bench = on_serial(robot)
    if again:
        bench.until_ready()
        robot.deaf = robot.mute = lambda packet: True
        bench.run_until(lambda: bench.finished)
        bench.session = Session("fake", (9600,), Settings(), bench.now, bench.session.phase.odometry)
    else:
        robot.deaf = robot.mute = lambda packet: True
        bench.run(0.4)          # the first try is under way
    robot.heard.clear()
    bench.run_until(lambda: "PULSE" in robot.names())
    at = robot.names().index("PULSE")
    assert robot.names()[at - 1] == "CLOSE" and robot.heard[at - 1].time == robot.heard[at].time, "in one write"


def test_late_echoes_of_an_earlier_try_do_no_harm():
    robot = FakeRobot()
    robot.mute = lambda packet: (
        isinstance(packet, p2os.SyncEcho) and packet.number == 1 and (robot.send(p2os.SyncEcho(0)) or False))
    Bench(robot).until_ready()


@LINES
def test_a_sip_in_answer_to_sync0_is_answered_with_close_at_once(line):
    robot = left_open(FakeRobot())
    robot.deaf = lambda heard: line == "serial" and heard.name == "CLOSE" and "PULSE" not in robot.names()
    robot.mute = lambda packet: robot.phase == OPEN and "PULSE" not in robot.names()
    bench = on_line(line, robot).until_ready()
    at = robot.names().index("PULSE")
    assert robot.names()[at:at + 1 + CLOSES_IF_HEARD] == ["PULSE"] + ["CLOSE"] * CLOSES_IF_HEARD and not robot.moving
    assert robot.heard[at + 1].time - robot.heard[at].time < 0.11
    assert bench.now < 1.3


@pytest.mark.parametrize("tenths", range(3, 24))
def test_on_tcp_an_open_robot_that_is_heard_late_is_closed_at_whichever_packet_finds_it(tenths):
    """This holds for the very last packet, too: no attempt ends while the robot still drives because of it."""
    robot = left_open(FakeRobot())
    robot.mute = lambda packet: robot.phase == OPEN and bench.now < tenths / 10
    robot.deaf = lambda heard: heard.time < tenths / 10
    bench = Bench(robot)
    bench.until_ready() if tenths < 20 else bench.run_until(lambda: bench.finished or bench.session.connected)
    obeyed = [heard for heard in robot.heard if heard.time >= tenths / 10]
    if "CLOSE" in [heard.name for heard in obeyed]:
        closed = next(heard.time for heard in obeyed if heard.name == "CLOSE")
        assert closed - obeyed[0].time < 0.11 and not robot.moving


@LINES
@pytest.mark.parametrize("reached", ["waiting", "opened by a CLOSE", "dead", "SYNC0", "SYNC1"])
def test_a_strict_robot_is_connected_whatever_it_heard_before(line, reached):
    """On TCP each new connection finds the robot waiting. On a pseudo-terminal the robot stays in the state that it has
    reached.
    """
    before = {"waiting": "", "opened by a CLOSE": "FAFB03020002", "dead": "FAFB031D001D", "SYNC0": "FAFB03000000",
              "SYNC1": "FAFB03000000 FAFB03010001"}[reached]
    robot = StrictRobot(tcp=line == "TCP")
    robot.receive(bytes.fromhex(before), 0.0)
    if line == "TCP":
        robot.new_connection(0.0)
    del robot.heard[:]
    del robot.echoes[:]
    bench = Bench(as_on_bench(robot), rates=() if line == "TCP" else (9600,)).until_ready()
    assert not robot.echoes and robot.open and bench.session.connected.identity.name == "MobileSim"
    first = [("PULSE", None), ("OPEN", None), ("CLOSE", None)]
    assert line == "serial" or robot.hang_ups == 0 and robot.heard[:3] == first
    assert bench.now < 1.5
    bench.close()
    bench.run_until(lambda: bench.finished)
    bench.run(0.2)
    assert not robot.open


@pytest.mark.parametrize("seed", range(40))
def test_a_strict_robot_on_a_pseudo_terminal_is_connected_whatever_it_heard_in_any_order(seed):
    chance, robot = random.Random(seed), StrictRobot(tcp=False)
    heard = [p2os.encode_frame(number) for number in range(3)] + [
        p2os.encode_command("STOP"), p2os.encode_command("VEL", 100), p2os.encode_command("ENABLE", 1),
        b"\xFA\xFB\x06\x0B", b"noise"]
    for _ in range(chance.randrange(12)):
        robot.receive(chance.choice(heard), 0.0)
    robot.advance(0.0)
    del robot.echoes[:]
    bench = Bench(as_on_bench(robot), rates=(9600,)).until_ready()
    assert bench.now < 1.5 and not robot.echoes


def as_on_bench(robot):
    """Add what a bench needs to a robot."""
    robot.baud, robot.noisy, robot.names = None, (), lambda: [name for name, _ in robot.heard]
    return robot


def test_nobody_on_tcp():
    robot = FakeRobot()
    robot.deaf = lambda heard: True
    bench = Bench(robot)
    assert bench.run_until(lambda: bench.finished) < 4.0
    assert isinstance(bench.session.error, NoAnswerError) and isinstance(bench.session.error, TimeoutError)
    assert "over TCP" in str(bench.session.error) and "sim:=true" in str(bench.session.error)


def test_nobody_on_a_serial_port_all_rates_are_tried_in_a_bounded_time():
    robot = FakeRobot()
    robot.deaf = lambda heard: True
    bench = Bench(robot, rates=RATES)
    rates = []
    while not bench.finished:
        bench.step()
        if bench.baud not in rates:
            rates.append(bench.baud)
    assert rates == [9600, 38400, 19200, 115200, 57600]
    assert bench.now < 6.0
    assert "9600, 38400, 19200, 115200, 57600 baud" in str(bench.session.error)


@pytest.mark.parametrize("baud", RATES)
def test_a_robot_at_any_speed_is_found(baud):
    robot = FakeRobot()
    robot.baud = baud
    bench = Bench(robot, rates=RATES).until_ready()
    assert bench.now < 6.0 and bench.session.line.baud == baud
    assert baud == 9600 or bench.event(BaudFound) == BaudFound(baud)


@pytest.mark.parametrize("baud", RATES)
def test_a_robot_left_open_at_any_speed_is_found_and_never_revived(baud):
    robot = FakeRobot()
    robot.baud = baud
    left_open(robot)
    bench = Bench(robot, rates=RATES).until_ready()
    assert bench.now < 3.5 and not robot.revived and not robot.motors


# How long it takes at the latest, from the constants; the docstring says the same.

CLOSED = DRAIN + QUIET
LONGEST_CYCLE = 0.255
# How long a speed is tried ...
SILENT = LISTEN + SYNC_TRIES * SYNC_TIMEOUT                     # ... at which nothing is heard
NOISY = LISTEN + CLOSED                                         # ... at which a streaming robot sounds like noise
RAISED = LONGEST_CYCLE + CLOSED + SYNC_TRIES * SYNC_TIMEOUT     # ... at which a robot obeys CLOSE, and is gone
NOBODY_ON_TCP = LISTEN + (TCP_TRIES + 1) * SYNC_TIMEOUT
OPENED = BEFORE_OPEN + CONFIG_TIMEOUT
WRONG = len(RATES) - 1
BOUNDS = {
    "waits": (LISTEN + OPENED, WRONG * SILENT + LISTEN + OPENED),
    "streams": (LONGEST_CYCLE + CLOSED + OPENED, WRONG * NOISY + LONGEST_CYCLE + CLOSED + OPENED),
    "raised": (NOISY + RAISED + LISTEN + OPENED, WRONG * NOISY + RAISED + (WRONG - 1) * SILENT + LISTEN + OPENED),
    "not there": (SILENT, len(RATES) * SILENT),
}
SLACK = 40 * STEP   # each wait ends up to a step of the bench's clock late


def time_until_ready(given, own, raised=None, streams=False):
    robot = FakeRobot()
    robot.config = None
    robot.baud = raised or own
    robot.own_baud = own
    if streams:
        left_open(robot)
    bench = Bench(robot, rates=tuple(dict.fromkeys(given + RATES))).until_ready()
    assert bench.session.connected.own_baud == own and not robot.revived and not robot.motors
    return bench.now


def test_the_docstring_says_what_the_constants_do():
    table = handshake.__doc__
    lines = [line for line in table.splitlines() if re.match(r"(waits|was left|is not)", line)]
    rows = [[float(number) for number in re.findall(r"([0-9.]+) s", line)] for line in lines]
    expected = [[math.ceil(10 * bound - 1e-6) / 10 for bound in bounds] for bounds in BOUNDS.values()]
    assert [row[:2] for row in rows] == expected
    assert rows[3][2] == math.ceil(10 * NOBODY_ON_TCP) / 10


@pytest.mark.parametrize("kind, streams", [("waits", False), ("streams", True)])
def test_a_wrong_speed_costs_a_bounded_time(kind, streams):
    known, any_of_five = BOUNDS[kind]
    times = {(given, own): time_until_ready((given,), own, streams=streams) for given in RATES for own in RATES}
    assert max(times[rate, rate] for rate in RATES) < known + SLACK
    assert 0.9 * any_of_five < max(times.values()) < any_of_five + SLACK, "and the bound is not idle"


def test_a_robot_left_at_a_raised_speed_costs_a_bounded_time():
    known, any_of_five = BOUNDS["raised"]
    pairs = [(own, raised) for own in RATES for raised in RATES if own != raised]
    assert max(time_until_ready((own, raised), own, raised, streams=True) for own, raised in pairs) < known + SLACK
    times = [time_until_ready((given,), own, raised, streams=True) for given in RATES for own, raised in pairs]
    assert 0.9 * any_of_five < max(times) < any_of_five + SLACK
    assert any_of_five < inspect.signature(Robot.wait_until_ready).parameters["timeout"].default


@pytest.mark.parametrize("rates", [RATES, ()])
def test_nobody_is_known_to_be_nobody_in_a_bounded_time(rates):
    robot = FakeRobot()
    robot.deaf = lambda heard: True
    bench = Bench(robot, rates=rates)
    bound = BOUNDS["not there"][1] if rates else NOBODY_ON_TCP
    assert 0.9 * bound < bench.run_until(lambda: bench.finished) < bound + SLACK


def test_bytes_that_make_no_packets_are_mentioned():
    robot = FakeRobot()
    robot.baud = 1200
    robot.open()
    bench = Bench(robot, rates=RATES)
    bench.run_until(lambda: bench.finished)
    assert "bytes came that make no packet" in str(bench.session.error)


def test_an_unknown_subtype_is_said_loudly_and_the_robot_left_waiting():
    robot = FakeRobot()
    robot.subtype = "p3dx-shh"
    bench = Bench(robot)
    bench.run_until(lambda: bench.finished)
    assert isinstance(bench.session.error, UnknownModelError)
    for word in ("'fake'", "p3dx-shh", "p3dx-sh", "model"):
        assert word in str(bench.session.error)
    assert robot.names() == ["PULSE", "OPEN", "CLOSE", "CLOSE"] and robot.phase == WAITING


def test_an_explicit_model_overrides_an_unknown_subtype():
    robot = FakeRobot()
    robot.subtype = "made-here"
    bench = Bench(robot, model="p3at-sh").until_ready()
    identity = bench.session.connected.identity
    assert identity.model.subtype == "p3at-sh" and identity.subtype == "made-here"


def test_the_subtype_is_compared_without_regard_to_case():
    robot = FakeRobot()
    robot.subtype = "P3DX-SH"
    assert Bench(robot).until_ready().session.connected.identity.model.subtype == "p3dx-sh"


def test_open_and_config_are_repeated_until_answered():
    robot, lost = FakeRobot(), []
    robot.deaf = lambda heard: (
        heard.name in ("OPEN", "CONFIG") and robot.phase == SYNCED and len(lost) < 2 and not lost.append(heard))
    bench = Bench(robot).until_ready()
    assert bench.session.connected.identity.firmware == "2.9"


def test_firmware_without_configpac_is_ready_after_a_second():
    robot = FakeRobot()
    robot.config = None
    bench = Bench(robot).until_ready()
    assert 1.2 < bench.now < 1.8
    identity = bench.event(Ready).identity
    assert identity.firmware is None and not identity.has_gripper and identity.max_linear == identity.model.max_linear
    assert [heard.value for heard in robot.heard if heard.name == "CONFIG"] == [1] * robot.names().count("CONFIG")
    assert 4 <= robot.names().count("CONFIG") <= 6


def test_a_robot_that_opens_but_sends_no_sips_is_no_answer():
    robot = FakeRobot()
    robot.mute = lambda packet: isinstance(packet, p2os.Sip)
    bench = Bench(robot)
    bench.run_until(lambda: bench.finished)
    assert isinstance(bench.session.error, NoAnswerError) and "sends no packets" in str(bench.session.error)
    assert robot.phase == WAITING


def test_a_controller_that_restarts_while_opening():
    robot = FakeRobot()
    robot.mute = lambda packet: isinstance(packet, p2os.Sip)
    bench = Bench(robot)
    bench.run_until(lambda: isinstance(bench.session.phase, Opening))
    robot.send(p2os.Reset(0xFF, b""))
    bench.run_until(lambda: bench.finished)
    assert isinstance(bench.session.error, LinkLostError) and "restarted" in str(bench.session.error)


def test_sonar_stays_off_when_not_wanted():
    bench = Bench(use_sonar=False).until_ready()
    assert [heard.value for heard in bench.robot.heard if heard.name == "SONAR"] == [0]

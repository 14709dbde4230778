"""The fault matrix: a client's session drives a simulated robot over a line with every kind of fault, in simulated
time.

A row of FAULTS says what goes wrong and for how long, which diagnostics task must name it, at which level and in which
words, and whether the link is lost. Each row runs twice: the user goes on commanding during the fault, or stops
commanding when it begins.

The Judge in bench/faulty_link.py checks every step of every row. test_the_matrix() checks what must hold before, during
and after a fault: no other task reports a problem, and at the end all tasks are OK.
"""

import itertools
import math
import random
import re
import sys
from pathlib import Path
from typing import Callable, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from faulty_link import COMMAND_TIMEOUT, REACTION, STEP, WATCHDOG, Diagnosis, Rig, Said, Velocity, lost, packets_in

from pioneer_control import p2os
from pioneer_control.client.events import BaudFound, CommandTimedOut, LinkDown, MotionCleared
from pioneer_control.client.fault_flags import Level

DRIVE = Velocity(0.3, 0.2)
# s after the end of any fault until the robot is ready again: a try at every line speed, and a pause before it
RECOVERY = 12.0
BAUD_BOUND = 8.0        # s within which a robot at any line speed is ready


# Spoilt packets

def lose(share: float) -> Callable[[bytes], Sequence[bytes]]:
    """Lose this share of the packets."""
    chance = random.Random(1)
    return lambda packet: () if chance.random() < share else (packet,)


class EachForm:
    """Every second SIP arrives spoilt, each time in the next of all spoilt forms. ``count`` is the number of forms."""

    def __init__(self, forms: Callable[[bytes], Iterator[Sequence[bytes]]]) -> None:
        self.count = 0
        self.finished = False
        self._forms = forms
        self._spoil = False

    def __call__(self, packet: bytes) -> Sequence[bytes]:
        if packet[3] not in (p2os.STOPPED, p2os.MOVING) or self.finished:
            return (packet,)
        self._spoil = not self._spoil
        if not self._spoil:
            return (packet,)
        form = next(itertools.islice(self._forms(packet), self.count, None), None)
        self.count += 1
        self.finished = form is None
        return (packet,) if form is None else form


def flipped_bits(packet):
    """Yield every form of the packet with one bit wrong."""
    for at in range(len(packet)):
        for bit in range(8):
            yield (packet[:at] + bytes([packet[at] ^ 1 << bit]) + packet[at + 1:],)


def junk_everywhere(packet):
    """Yield the packet with extra bytes at every place. The extra bytes look like a packet, or like the begin or the
    end of one.
    """
    for junk in (b"\x00", b"\xFA", b"\xFA\xFB", b"\xFA\xFB\xFF", b"\xFA\xFB\x02", p2os.encode_frame(0x32, b"short"),
                 bytes(range(240, 256)) * 3):
        for at in range(len(packet) + 1):
            yield (packet[:at] + junk + packet[at:],)


def wrong_checksums(packet):
    """Yield the packet with wrong checksums: swapped, off by one, or a fixed value."""
    body, (high, low) = packet[:-2], packet[-2:]
    for wrong in ((low, high), (high, low ^ 1), (high ^ 1, low), (0, 0), (255, 255)):
        if wrong != (high, low):
            yield (body + bytes(wrong),)


def truncated(packet):
    """Yield, for every place, only the beginning of the packet, only its end, and the packet without one byte."""
    for at in range(1, len(packet)):
        yield (packet[:at],)
        yield (packet[at:],)
        yield (packet[:at - 1] + packet[at:],)


def split(packet):
    """Yield the packet cut in two pieces at every place, and cut into single bytes."""
    for at in range(1, len(packet)):
        yield (packet[:at], packet[at:])
    yield tuple(packet[at:at + 1] for at in range(len(packet)))


def glue(count: int) -> Callable[[bytes], Sequence[bytes]]:
    """Keep so many SIPs and the packets between them, and send them in one piece."""
    kept: List[bytes] = []

    def fault(packet):
        kept.append(packet)
        if sum(each[3] in (p2os.STOPPED, p2os.MOVING) for each in kept) < count:
            return ()
        together = b"".join(kept)
        kept.clear()
        return (together,)

    return fault


def noise(packet: bytes) -> Sequence[bytes]:
    """Nothing arrives but noise."""
    return (bytes(byte ^ 0x5A for byte in packet),)


# What befalls a rig: each of these begins, lasts while the generator is at its yield, and ends

def on_the_way_back(make_fault):
    def befall(rig):
        rig.to_client.fault = make_fault()
        yield
    return befall


def on_the_way_there(make_fault):
    def befall(rig):
        rig.judge.lossy = True
        rig.to_robot.fault = make_fault()
        yield
    return befall


def both_ways(make_fault):
    def befall(rig):
        rig.judge.lossy = True
        rig.to_robot.fault, rig.to_client.fault = make_fault(), make_fault()
        yield
    return befall


def nothing(rig):
    yield


def late(befall, seconds):
    """Return the same fault, but tell the Judge that packets may come up to ``seconds`` late."""
    def wrapped(rig):
        rig.judge.late = seconds
        yield from befall(rig)
    return wrapped


def just_after_a_report(befall):
    """The same, but the fault begins right after diagnostics were published, which happens once a second."""
    def wrapped(rig):
        said = rig.diagnosis.now
        rig.run_until(lambda: rig.diagnosis.now is not said)
        yield from befall(rig)
    return wrapped


def forms(generator):
    """Return a fault that lasts until every spoilt form of a SIP has arrived once."""
    def befall(rig):
        each = rig.to_client.fault = EachForm(generator)
        rig.run_until(lambda: each.finished, limit=1000.0)
        yield
    return befall


def delayed(seconds):
    def befall(rig):
        rig.to_robot.delay = rig.to_client.delay = seconds
        rig.judge.lossy = True
        yield
    return befall


def cable_pulled(rig):
    rig.judge.lossy = True
    rig.pull()
    yield


def controller_restarts(rig):
    rig.firmware.restart()
    yield


def power_cycled(rig):
    rig.firmware.close_session()
    yield


def stop_button(rig):
    rig.firmware.press_stop_button(True)
    yield
    rig.firmware.press_stop_button(False)


def driven_against_a_wall(rig):
    rig.commanding = rig.commanding and Velocity(0.3, 0.0)
    rig.firmware.hardware.body.move = lambda distance, turn: False
    yield
    del rig.firmware.hardware.body.move


def low_battery(volts):
    def befall(rig):
        rig.firmware.hardware.battery.pretend(volts)
        yield
        rig.firmware.hardware.battery.pretend(0.0)
    return befall


def flood_of_commands(rig):
    rig.commands_per_step = 1000 * STEP
    before = rig.judge.bytes_written
    yield
    baud = rig.to_robot.baud or 115200
    assert rig.judge.bytes_written - before < 10.5 * baud / 10, "no more than the line carries"
    rig.commands_per_step = 10 * STEP


# How diagnostics name it

class Told(NamedTuple):
    """What a task must say in its message or values while the fault lasts. With ``driving``, only if the user goes on
    commanding.
    """

    task: str
    level: Level
    words: str
    """a regular expression"""
    driving: bool = False


def link(level, words, driving=False):
    return (Told("Link", level, words, driving),)


DAMAGED = link(Level.WARN, "[1-9][0-9]* packets with a bad checksum")
STRAY = link(Level.WARN, "[1-9][0-9]* stray bytes")
FEWER = link(Level.WARN, "only [0-9.]+ of 10.0 packets a second arrive")
LOST = link(Level.OK, "got lost: [1-9]")
SILENT = link(Level.ERROR, "no link: .*silent")
PULLED = link(Level.ERROR, "no link: .*line broke")
NO_PORT = PULLED + link(Level.ERROR, "no link: .*no such port")
TAKEN = (Told("Motors", Level.WARN, "took its motors away"),)
DEAF = (Told("Motors", Level.WARN, "has not moved for 2 s: does it hear?", driving=True),)
UNANSWERED = "[1-9][0-9]* of [0-9]+ questions within 4 s were not answered"
# one that stands is asked nothing (client.link_check)
FEW_UNHEARD = link(Level.OK, "without an answer: [1-9]", driving=True)
SOME_UNHEARD = link(Level.WARN, UNANSWERED, driving=True)
UNHEARD = link(Level.WARN, UNANSWERED)
HARMLESS = ()


# m: nothing; while it came to rest; for 2 s besides, until it was told to stop or its watchdog did
ROUNDED, COASTED, DROVE_ON = 0.002, 0.05, 0.75


class Row(NamedTuple):
    """A fault: what befalls the rig, for how many s, what diagnostics say, the line speed (None: TCP),
    whether the link is lost, and of how much of
    the robot's way (m) its pose may know nothing then: how far it got unheard before it was closed, or after.
    """

    befall: Callable[[Rig], Iterator[None]]
    seconds: float
    told: Tuple[Told, ...]
    baud: Optional[int] = None
    ends_link: bool = False
    unheard: float = ROUNDED


def is_closed_first(way, seconds):
    """Return whether a robot that the client did not hear for so long gets a CLOSE before the client hears a SIP from
    it again.

    It always does if it receives our packets. If it does not receive them, it may happen by chance.
    """
    return way is on_the_way_back or seconds < 60.0


FAULTS = {
    "none": Row(nothing, 5.0, HARMLESS),
    "none, at 9600 baud": Row(nothing, 5.0, HARMLESS, baud=9600),
    "junk at every position of a SIP": Row(
        forms(junk_everywhere), 1.0, DAMAGED + STRAY + link(Level.WARN, "nobody understands: [1-9]")),
    "every bit of a SIP flipped": Row(forms(flipped_bits), 1.0, DAMAGED + STRAY),
    "bad checksums": Row(forms(wrong_checksums), 1.0, DAMAGED + STRAY),
    "truncated at every position": Row(forms(truncated), 1.0, STRAY),
    "split at every position": Row(forms(split), 1.0, HARMLESS),
    "three packets glued": Row(late(on_the_way_back(lambda: glue(3)), 0.3), 10.0, HARMLESS),
    "ten packets glued": Row(just_after_a_report(late(on_the_way_back(lambda: glue(10)), 1.0)), 20.0, HARMLESS),
    "all SIPs are noise": Row(on_the_way_back(lambda: noise), 10.0, SILENT, ends_link=True, unheard=DROVE_ON),
    "all commands are noise": Row(on_the_way_there(lambda: noise), 10.0, DEAF + UNHEARD),
    **{"%g %% of the packets %s lost" % (100 * share, name): Row(
        way(lambda share=share: lose(share)), 100.0 if share < 0.1 else 30.0, told)
       for share, unheard, seen in ((0.01, FEW_UNHEARD, LOST), (0.2, SOME_UNHEARD, FEWER), (0.5, SOME_UNHEARD, FEWER))
       for way, name, told in (
           (on_the_way_there, "to the robot", unheard), (on_the_way_back, "to the client", seen),
           (both_ways, "either way", seen))},
    **{"%g s of silence %s" % (seconds, name): Row(
        way(lambda: lost), seconds, told, ends_link=told is SILENT,
        unheard=DROVE_ON if told is SILENT and is_closed_first(way, seconds) else ROUNDED)
       for seconds, to_it, from_it in ((0.5, UNHEARD, FEWER), (3.0, UNHEARD, SILENT), (60.0, DEAF + UNHEARD, SILENT))
       for way, name, told in (
           (on_the_way_there, "to the robot", to_it), (on_the_way_back, "to the client", from_it),
           (both_ways, "either way", from_it))},
    "late by 0.3 s either way": Row(late(delayed(0.3), 0.3), 10.0, FEWER),     # none for 0.3 s, at the beginning
    "cable pulled and put back at once": Row(cable_pulled, 0.1, PULLED, ends_link=True, unheard=COASTED),
    "cable pulled and put back": Row(cable_pulled, 5.0, NO_PORT, ends_link=True),     # it stands by then
    "cable pulled and put back, serial": Row(cable_pulled, 5.0, NO_PORT, baud=9600, ends_link=True),
    "controller restarts": Row(controller_restarts, 1.0, link(Level.ERROR, "no link: .*restarted"), ends_link=True,
                               unheard=COASTED),
    "power cycled without a notice": Row(power_cycled, 3.0, SILENT, ends_link=True, unheard=COASTED),
    "STOP button pressed and released": Row(
        stop_button, 3.0, (Told("Motors", Level.WARN, "the STOP button is pressed"),) + TAKEN),
    "STOP button tapped between two SIPs": Row(stop_button, 0.05, TAKEN),
    "driven against a wall": Row(driven_against_a_wall, 5.0,
                                 (Told("Stall", Level.WARN, "wheels are stalled", driving=True),)),
    "battery low": Row(
        low_battery(11.4), 3.0, (Told("Battery", Level.WARN, "11.4 V, the alarm level is 11.5 V; charge it"),)),
    "battery empty": Row(low_battery(10.9), 3.0, (Told("Battery", Level.ERROR, "nearly empty: 10.9 V"),) + TAKEN),
    "1000 velocities per second": Row(flood_of_commands, 10.0, HARMLESS),
    "1000 velocities per second at 9600 baud": Row(flood_of_commands, 10.0, HARMLESS, baud=9600),
}


def complaints(row, said, goes_on):
    """Return what diagnostics did not say about a fault although they should, and what they said wrongly."""
    missing = [told for told in row.told if (goes_on or not told.driving) and not any(
        (one.task, one.level) == told[:2] and re.search(told.words, one.message + "; " + one.values) for one in said)]
    worst = {told.task: told.level for told in row.told}
    wrong = [one for one in said
             if not (row.ends_link if one.level == Level.STALE else one.level <= worst.get(one.task, Level.OK))]
    return ["not named: %s" % (told,) for told in missing] + ["named, but not there: %s" % (one,) for one in wrong]


def well(rig):
    """Return whether all tasks are OK."""
    return bool(rig.diagnosis.now) and all(said.level == Level.OK for said in rig.diagnosis.now)


def at_rest(rig):
    return rig.firmware.velocity == (0.0, 0.0)


def driving(rig):
    rig.run_until(lambda: rig.ready)
    rig.switch_motors_on()
    rig.commanding = DRIVE
    rig.run_until(lambda: rig.firmware.velocity == pytest.approx(DRIVE, rel=0.1))
    return rig


@pytest.mark.parametrize("goes_on", [True, False], ids=["the user goes on", "the user falls silent"])
@pytest.mark.parametrize("name", sorted(FAULTS))
def test_the_matrix(name, goes_on):
    row = FAULTS[name]
    rig = driving(Rig(baud=(row.baud, row.baud) if row.baud else None, seed=len(name)))
    assert well(rig), rig.diagnosis.now
    rig.diagnosis.said.clear()
    if not goes_on:
        rig.commanding = None
    for _ in row.befall(rig):
        rig.run(row.seconds)
    rig.mend()
    rig.run_until(lambda: rig.ready, RECOVERY)
    rig.run(1.0)
    rig.commanding = None
    rig.run_until(lambda: at_rest(rig) and rig.state is not None,
                  COMMAND_TIMEOUT + REACTION + 1.0 + WATCHDOG * row.ends_link)
    assert bool(rig.heard(LinkDown)) == row.ends_link
    assert rig.heard(CommandTimedOut) or row.ends_link or rig.heard(MotionCleared)
    rig.judge.lossy = False
    pose = rig.firmware.true_pose
    rig.run(5.0)
    assert rig.firmware.true_pose == pose, "nothing moves until it is told to"
    assert not rig.judge.wrongs
    assert math.dist(rig.firmware.true_pose[:2], (rig.state.x, rig.state.y)) < row.unheard
    if not row.ends_link:
        assert (rig.state.x_counts, rig.state.y_counts) == rig.firmware.internal_counts, "not one count is lost"
    driving(rig)
    rig.run_until(lambda: well(rig), Diagnosis.PERIOD + STEP)
    assert complaints(row, rig.diagnosis.said, goes_on) == []
    rig.session.close(rig.now)
    rig.run_until(lambda: rig.session is None, 1.0)
    assert not rig.firmware.motors_enabled
    assert not rig.judge.wrongs


@pytest.mark.parametrize("row, said, complaint", [
    ("cable pulled and put back at once", ("Link", Level.ERROR, "no link: silent", ""), "not named"),
    ("STOP button tapped between two SIPs", ("Motors", Level.OK, "it took its motors away", ""), "not named"),
    ("1 % of the packets to the client lost", ("Link", Level.OK, "", "got lost: 0"), "not named"),
    ("none", ("Battery", Level.WARN, "battery low", ""), "named, but not there"),
    ("none", ("Stall", Level.STALE, "no link", ""), "named, but not there"),
    ("battery low", ("Battery", Level.ERROR, "11.4 V, the alarm level is 11.5 V; charge it", ""),
     "named, but not there"),
])
def test_a_fault_that_is_not_named_is_seen_and_so_is_a_false_alarm(row, said, complaint):
    assert any(text.startswith(complaint) for text in complaints(FAULTS[row], {Said(*said)}, goes_on=True))


@pytest.mark.parametrize("seed", range(10))
def test_half_of_all_packets_lost_in_ten_other_ways(seed):
    rig = driving(Rig(seed=seed))
    rig.judge.lossy = True
    rig.to_robot.fault = rig.to_client.fault = lambda packet: (packet,) if rig.chance.random() < 0.5 else ()
    rig.run(20.0)
    rig.commanding = None
    rig.run(20.0)
    assert at_rest(rig) and not rig.judge.wrongs


@pytest.mark.parametrize("seed", range(40))
def test_what_revives_a_robot_after_a_silence_is_a_stop_whatever_is_lost(seed):
    """Every stop was lost. When the line carries packets again, it still loses most of them. The robot still remembers
    its set points.
    """
    rig = driving(Rig(seed=seed))
    rig.judge.lossy = True
    rig.to_robot.fault = lost
    rig.commanding = None
    rig.run_until(lambda: at_rest(rig))
    rig.run(rig.chance.uniform(0.0, 2.0))
    pose = rig.firmware.true_pose
    rig.to_robot.fault = lambda packet: (packet,) if rig.chance.random() < 0.3 else ()
    rig.run(10.0)
    assert rig.firmware.true_pose == pose and not rig.judge.wrongs


@pytest.mark.parametrize("baud, farthest", [(9600, 0.0), (None, 0.015)])
def test_a_line_that_comes_back_at_any_moment_revives_nothing(baud, farthest):
    """The robot is still open and remembers its set points. On a serial line, CLOSE must be the first packet of the
    handshake that it hears. On TCP (a bridge whose other cable was out) it may hear SYNC0 first. The SIP that answers
    SYNC0 makes the client send CLOSE at once. ``farthest`` is in m and rad.
    """
    rig = driving(Rig(baud=baud and (baud, baud)))
    rig.judge.lossy = True
    for tenths in range(60):
        rig.to_robot.fault = rig.to_client.fault = lost
        rig.commanding = None
        rig.run_until(lambda: at_rest(rig))
        rig.run(4.0 + tenths / 10 + tenths % 10 / 100)
        pose = rig.firmware.true_pose
        rig.mend()
        rig.run_until(lambda: rig.ready)
        assert math.dist(rig.firmware.true_pose, pose) <= farthest, tenths
        driving(rig)
    assert all(farthest and "it moves" in wrong for wrong in rig.judge.wrongs), rig.judge.wrongs


@pytest.mark.parametrize("down_for", [0.0, 0.7, 2.5, 30.0])
@pytest.mark.parametrize("baud", [None, 9600])
def test_a_robot_left_open_and_driving_by_a_killed_driver(baud, down_for):
    rig = driving(Rig(baud=baud and (baud, baud)))
    rig.commanding = None
    left = rig.firmware.true_pose
    rig.kill(down_for)
    assert rig.run_until(lambda: rig.ready, down_for + 20.0) < down_for + 2.0
    assert not rig.firmware.motors_enabled and at_rest(rig)
    pose = rig.firmware.true_pose
    assert pose != left
    rig.run(5.0)
    assert rig.firmware.true_pose == pose and not rig.judge.wrongs


@pytest.mark.parametrize("left_open", [False, True], ids=["waiting", "left open and driving"])
@pytest.mark.parametrize("robots", p2os.BAUD_RATES)
@pytest.mark.parametrize("given", p2os.BAUD_RATES)
def test_a_robot_at_any_line_speed_is_found_in_a_bounded_time(given, robots, left_open):
    """Bytes that were sent at another speed arrive as a different number of bytes."""
    rig = Rig(baud=(robots, robots) if left_open else (given, robots), seed=given + robots)
    if left_open:
        driving(rig)
        rig.commanding = None
        rig.to_robot.baud = given
        rig.kill()
    assert rig.run_until(lambda: rig.ready) < BAUD_BOUND
    assert [event.baud for event in rig.heard(BaudFound)] == ([robots] if robots != given else [])
    assert at_rest(rig) and not rig.firmware.motors_enabled
    pose = rig.firmware.true_pose
    rig.run(3.0)
    assert rig.firmware.true_pose == pose
    driving(rig)
    assert well(rig) and ("Baud: %d;" % robots) in rig.diagnosis.now[0].values
    assert not rig.judge.wrongs


# That nothing was wrong would mean nothing if nothing could be.

def breaks_the_dead_man(rig):
    rig.session.connected.drive.command_timeout = 60.0
    rig.commanding = None
    rig.run(1.0)


def commands_by_itself(rig):
    rig.commanding = None
    rig.run(3.0)
    rig.session.connected.drive.set_velocity(0.1, 0.0, rig.now)


def switches_motors_on_by_itself(rig):
    rig.session.connected.command(rig.now, p2os.encode_command("ENABLE", 1))


def robot_switches_motors_on_by_itself(rig):
    rig.firmware.press_stop_button(True)
    rig.run(0.5)
    rig.firmware.press_stop_button(False)
    rig.firmware.hardware.motors.enable()


def coasts(rig):
    rig.commanding = None
    rig.firmware.hardware.drives.linear.limits.fall = 0.01
    rig.run(5.0)


def pose_jumps(rig):
    rig.session.phase.odometry.x_counts += 200


def pose_turns(rig):
    rig.session.phase.odometry.heading_units += 200


def queue_builds_up(rig):
    for _ in range(50):
        rig.session.line.say(p2os.encode_command("PULSE"))


@pytest.mark.parametrize("misdeed, said", [
    (breaks_the_dead_man, "no zero velocity on the wire"),
    (commands_by_itself, "a velocity that nobody wants any more"),
    (switches_motors_on_by_itself, "motors switched on by itself"),
    (robot_switches_motors_on_by_itself, "motors are on, and nobody asked"),
    (coasts, "it moves"),
    (pose_jumps, "the pose jumps"),
    (pose_turns, "the pose jumps"),
    (queue_builds_up, "bytes wait in the line"),
])
def test_the_judge_sees(misdeed, said):
    rig = driving(Rig(baud=(9600, 9600)))
    assert not rig.judge.wrongs
    misdeed(rig)
    rig.run(0.5)
    assert any(said in wrong for wrong in rig.judge.wrongs), rig.judge.wrongs


def test_every_spoilt_form_is_one():
    """No form is equal to the packet that was sent, except the pieces of a split packet. There are as many forms as
    their names say.
    """
    sip = next(packets_in(p2os.encode_frame(p2os.STOPPED, bytes(range(60)))))
    for forms_of, count in ((flipped_bits, 8 * len(sip)), (junk_everywhere, 7 * (len(sip) + 1)),
                            (truncated, 3 * (len(sip) - 1)), (split, len(sip))):
        made = [b"".join(pieces) for pieces in forms_of(sip)]
        assert len(made) == count and (forms_of is split) == (sip in made)

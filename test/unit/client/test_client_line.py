"""Pace, one waiting velocity, and stops that overtake."""

import pytest

from pioneer_control.client.line import GAP, Line
from pioneer_control.client.link_check import QUESTION, LinkCheck

NINE = b"123456789"


def line_to(written, baud, revival):
    """Return a line, and a list with all that it sends."""
    line = Line(baud, revival)
    line.to_send = written
    return line


@pytest.fixture
def written():
    return []


@pytest.fixture
def line(written):
    return line_to(written, None, (b"stop",))


@pytest.fixture
def busy(line, written):
    """Return a line that has just sent as many velocities in a row as it may."""
    for _ in range(2):
        line.velocity(0.0, b"vel", b"rvel")
    assert len(written) == 2 and line.busy(0.0) and line.due == float("inf")
    written.clear()
    return line


def test_an_idle_line_writes_at_once_and_in_one_piece(line, written):
    line.velocity(0.0, b"vel", b"rvel")
    assert written == [b"velrvel"]


def test_of_the_velocities_that_wait_the_latest_wins(busy, written):
    for number in range(4):
        busy.velocity(0.001 * number, b"%d" % number, b"")
    busy.tick(busy.due)
    assert written == [b"3"]
    busy.tick(1.0)
    assert written == [b"3"] and busy.due == float("inf")


def test_all_that_waits_is_flushed_in_its_order(busy, written):
    busy.velocity(0.0, b"vel")
    busy.command(0.0, b"one")
    busy.command(0.0, b"two")
    busy.flush(0.0, b"mark")
    assert written == [b"one", b"vel", b"two", b"mark"] and busy.due == float("inf")


@pytest.mark.parametrize("baud", [None, 115200])
@pytest.mark.parametrize("held_up", [0.010, 0.015, 0.020])
def test_velocities_that_come_in_a_bunch_on_a_fast_line_all_go(written, held_up, baud):
    """A velocity comes every 10 ms, but some come ``held_up`` s late. Each velocity is sent, in order.

    The robot needs 8 ms for each velocity, or 12 ms with a question. One velocity may be sent early.
    """
    line, check = line_to(written, baud, ()), LinkCheck(0.1, lambda count: 0.0)
    times = [number / 100 for number in range(300)]
    for number, time in enumerate(times):
        if number % 50 in (10, 11, 12):
            time = max(time, times[number // 50 * 50 + 10] + held_up)
        line.tick(time)
        line.velocity(time, b"%8d " % number, NINE, companion=check.question)
        if b"".join(written).count(QUESTION) > check.questions:
            check.saw_answer()
    line.tick(9.9)
    assert [int(data[:9]) for data in written] == list(range(300)) and b"".join(written).count(QUESTION) > 15


@pytest.mark.parametrize("baud, at_once", [(None, 2), (115200, 2), (57600, 2), (38400, 1), (9600, 1)])
def test_two_velocities_go_at_once_if_the_line_carries_both_in_7_ms(baud, at_once):
    written = []
    line = line_to(written, baud, ())
    for _ in range(5):
        line.velocity(0.0, NINE, NINE)
    assert len(written) == at_once


def test_a_stop_behind_a_bunch_is_among_six_commands_in_a_row(line, written):
    """ARIA sends six commands in a row, too (protocol sheet 13). So even a robot that takes no more than six commands
    at once gets the stop.
    """
    for _ in range(5):
        line.velocity(0.0, b"V", b"R", companion=lambda now: () if written else (b"Q",))
    line.stop(0.0, b"S")
    assert b"".join(written) == b"VRQVRS"


def test_what_is_ahead_of_a_line_is_carried_within_7_ms():
    line = line_to([], 38400, ())
    for _ in range(2):
        line.velocity(0.0, NINE, NINE)
    assert line.due == pytest.approx(2 * line.transfer_time(18) - 0.007)


def test_nothing_is_ahead_of_a_slow_line():
    line = line_to([], 9600, ())
    for _ in range(2):
        line.velocity(0.0, NINE, NINE)
    assert line.due == line.transfer_time(18)


def test_commands_are_never_ahead_of_the_pace_nor_velocities_that_wait_behind_one(line, written):
    line.velocity(0.0, b"1", b"")
    line.command(0.0, b"command")
    line.velocity(0.0, b"2", b"")
    assert written == [b"1"]
    line.tick(1.999 * GAP)
    assert written == [b"1"]
    line.tick(2 * GAP)
    assert written == [b"1", b"command", b"2"]


def test_a_flood_of_velocities_keeps_the_pace_on_average(line, written):
    for millisecond in range(1000):
        line.velocity(millisecond / 1000, b"vel", b"rvel")
    assert 120 <= len(written) <= 1 / (2 * GAP) + 2


def test_commands_keep_their_order_and_the_pace(line, written):
    for name in (b"a", b"b", b"c"):
        line.command(0.0, name)
    assert written == [b"a"] and line.due == GAP
    line.tick(GAP * 0.9)
    assert written == [b"a"]
    line.tick(GAP)
    line.tick(GAP)
    assert written == [b"a", b"b"]


def test_neither_a_flood_of_commands_nor_one_of_velocities_holds_up_the_other(busy, written):
    for number in range(4):
        busy.command(0.0, b"command")
    for millisecond in range(70):
        busy.velocity(millisecond / 1000, b"%d" % millisecond)
    assert written[:8] == [b"command", b"16", b"command", b"24", b"command", b"32", b"command", b"41"]
    most = (0.070 - 0.016) / GAP + 4
    assert len(written) <= most, "all of it at the pace of the line, but for the velocities that may be ahead"


def test_a_stop_overtakes_and_what_it_overtook_is_forgotten(busy, written):
    busy.velocity(0.001, b"second", b"")
    busy.command(0.001, b"command")
    busy.stop(0.002, b"halt")
    assert written == [b"halt"]
    for now in (0.1, 0.2, 0.3):
        busy.tick(now)
    assert written == [b"halt", b"command"]


def test_a_flood_of_stops_goes_at_the_pace_of_the_line():
    written = []
    line = line_to(written, 9600, ())
    for millisecond in range(1000):
        line.stop(millisecond / 1000, b"x" * 24)
        line.tick(millisecond / 1000)
    assert len(written) <= 42


def test_a_stop_that_is_said_again_goes_at_once_on_an_idle_line_too(line, written):
    line.stop(0.0, b"halt")
    line.stop(GAP, b"halt")
    assert written == [b"halt", b"halt"]


def test_a_stop_that_is_said_again_does_not_pile_up_on_a_slow_line():
    written = []
    line = line_to(written, 9600, ())
    line.stop(0.0, NINE, NINE)
    line.stop(0.010, NINE, NINE)
    assert len(written) == 1
    line.tick(line.due)
    assert len(written) == 2


def test_a_velocity_after_a_stop_and_a_stop_after_that(busy, written):
    busy.stop(0.0, b"halt")
    busy.velocity(0.001, b"go")
    busy.stop(0.002, b"halt")
    busy.tick(1.0)
    assert written == [b"halt", b"halt"]


def test_a_stop_right_after_a_velocity_that_followed_a_stop_goes_at_once(busy, written):
    busy.stop(0.0, b"halt")
    busy.velocity(0.001, b"go")
    went_at = busy.due
    busy.tick(went_at)
    busy.stop(went_at + GAP, b"halt")
    assert written == [b"halt", b"go", b"halt"]


def test_9600_baud_carries_53_pairs_a_second():
    written = []
    line = line_to(written, 9600, ())
    for millisecond in range(1000):
        line.velocity(millisecond / 1000, NINE, NINE)
    assert 50 <= len(written) <= 54


def test_100_pairs_a_second_all_go_out_on_a_fast_line(line, written):
    for centisecond in range(100):
        line.velocity(centisecond / 100, NINE, NINE)
    assert len(written) == 100


def test_after_a_long_silence_the_revival_goes_first(line, written):
    line.watchdog = 2.0
    line.command(0.0, b"a")
    line.command(1.9, b"b")
    line.command(4.0, b"c")
    assert written[1:] == [b"b", b"stopc"]


def test_a_velocity_that_waits_too_long_is_forgotten_and_a_stop_never_is(busy, written):
    busy.velocity(0.0, b"V", until=0.5)
    busy.tick(0.5)
    assert written == [] and busy.due == float("inf")
    busy.velocity(0.6, b"W", until=1.1)
    busy.stop(0.6, b"S")
    busy.stop(0.6, b"T")
    busy.tick(9.0)
    assert written == [b"W", b"S", b"T"]


def test_one_command_that_waits_can_be_withdrawn(line, written):
    for packet in (b"A", b"B", b"C", b"B"):
        line.command(0.0, packet)
    line.withdraw(b"B")
    for tenth in range(1, 10):
        line.tick(tenth / 10)
    assert written == [b"A", b"C"]


def test_what_waits_can_be_dropped(busy, written):
    for name in (b"a", b"b"):
        busy.command(0.0, name)
    busy.velocity(0.0, b"v")
    assert busy.waiting == 2
    busy.drop()
    busy.tick(1.0)
    assert written == [] and busy.waiting == 0

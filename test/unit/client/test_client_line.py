"""Pace, one pending velocity, and stops that overtake."""

import pytest

from pioneer_control.client.line import GAP, Line

NINE = b"123456789"


@pytest.fixture
def written():
    return []


@pytest.fixture
def line(written):
    return Line(written.append, None, (b"stop",))


def test_an_idle_line_writes_at_once_and_in_one_piece(line, written):
    line.velocity(0.0, b"vel", b"rvel")
    assert written == [b"velrvel"]


def test_of_the_velocities_that_wait_the_latest_wins(line, written):
    for number in range(5):
        line.velocity(0.001 * number, b"%d" % number, b"")
    line.tick(line.due)
    assert written == [b"0", b"4"]
    line.tick(1.0)
    assert written == [b"0", b"4"] and line.due == float("inf")


def test_commands_keep_their_order_and_the_pace(line, written):
    for name in (b"a", b"b", b"c"):
        line.command(0.0, name)
    assert written == [b"a"] and line.due == GAP
    line.tick(GAP * 0.9)
    assert written == [b"a"]
    line.tick(GAP)
    line.tick(GAP)
    assert written == [b"a", b"b"]


def test_neither_a_flood_of_commands_nor_one_of_velocities_holds_up_the_other(line, written):
    for number in range(4):
        line.command(0.0, b"command")
    for millisecond in range(40):
        line.velocity(millisecond / 1000, b"%d" % millisecond)
    assert written.count(b"command") == 4 and len(written) == 10
    assert written[:4] == [b"command", b"4", b"command", b"12"]


def test_a_stop_overtakes_and_what_it_overtook_is_forgotten(line, written):
    line.velocity(0.0, b"first", b"")
    line.velocity(0.001, b"second", b"")
    line.command(0.001, b"command")
    line.stop(0.002, b"halt")
    assert written == [b"first", b"halt"]
    for now in (0.1, 0.2, 0.3):
        line.tick(now)
    assert written == [b"first", b"halt", b"command"]


def test_a_flood_of_stops_goes_at_the_pace_of_the_line():
    written = []
    line = Line(lambda data: written.append(data), 9600, ())
    for millisecond in range(1000):
        line.stop(millisecond / 1000, b"x" * 24)
        line.tick(millisecond / 1000)
    assert len(written) <= 42


def test_a_velocity_after_a_stop_and_a_stop_after_that(line, written):
    line.stop(0.0, b"halt")
    line.velocity(0.001, b"go")
    line.stop(0.002, b"halt")
    line.tick(1.0)
    assert written == [b"halt", b"halt"]


def test_a_stop_right_after_a_velocity_that_followed_a_stop_goes_at_once(line, written):
    line.stop(0.0, b"halt")
    line.velocity(0.001, b"go")
    line.tick(line.due)
    line.stop(2 * GAP - 0.001, b"halt")
    assert written == [b"halt", b"go", b"halt"]


def test_9600_baud_carries_53_pairs_a_second():
    written = []
    line = Line(written.append, 9600, ())
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


def test_a_velocity_that_waits_too_long_is_forgotten_and_a_stop_never_is(line, written):
    line.command(0.0, b"A")
    line.velocity(0.0, b"V", until=0.5)
    line.tick(0.5)
    assert written == [b"A"] and line.due == float("inf")
    line.velocity(0.6, b"W", until=1.1)
    line.stop(0.6, b"S")
    line.stop(0.6, b"T")
    line.tick(9.0)
    assert written == [b"A", b"W", b"S", b"T"]


def test_one_command_that_waits_can_be_withdrawn(line, written):
    for packet in (b"A", b"B", b"C", b"B"):
        line.command(0.0, packet)
    line.withdraw(b"B")
    for tenth in range(1, 10):
        line.tick(tenth / 10)
    assert written == [b"A", b"C"]


def test_what_waits_can_be_dropped(line, written):
    for name in (b"a", b"b", b"c"):
        line.command(0.0, name)
    line.velocity(0.0, b"v")
    assert line.waiting == 2
    line.drop()
    line.tick(1.0)
    assert written == [b"a"] and line.waiting == 0

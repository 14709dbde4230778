"""How much later than usual a robot reacts: of packets that come late, or not at all, by clocks that may be apart."""

import pytest

from pioneer_control.navigation.lateness import COMPARED, EXPECTED, USUAL, Delay, Lately, Lateness


def test_the_greatest_of_the_last_seconds():
    lately = Lately(3.0)
    assert [lately.most(number, now) for now, number in enumerate([1.0, 5.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0])] == [
        1.0, 5.0, 5.0, 5.0, 5.0, 3.0, 3.0, 0.0]


def test_numbers_of_a_time_that_has_not_come_do_not_count():
    lately = Lately(3.0)
    assert lately.most(9.0, 100.0) == 9.0 and lately.most(1.0, 50.0) == 1.0


@pytest.mark.parametrize("apart", [0.0, 1000.0, -1000.0])
def test_clocks_that_are_apart_make_no_delay(apart):
    delay = Delay()
    found = [delay.of(0.1 * k, 0.1 * k + apart + late) for k, late in enumerate([0.02, 0.01, 0.3, 0.01])]
    assert found == pytest.approx([0.0, 0.0, 0.29, 0.0]) and delay.least == pytest.approx(apart + 0.01)


def test_a_clock_that_is_set_makes_a_delay_for_some_seconds():
    delay = Delay()
    delay.of(0.0, 0.0)
    assert delay.of(1.0, 1.7) == pytest.approx(0.7)
    assert delay.of(2.0 + COMPARED, 2.7 + COMPARED) == 0.0


def late(lateness, time, now):
    lateness.note(time, now)
    return lateness.late


def test_packets_in_time_are_not_late():
    lateness = Lateness()
    assert {late(lateness, 0.1 * k, 0.1 * k + 0.02) for k in range(50)} == {0.0}


def test_a_packet_that_does_not_come_and_one_that_comes_late_make_the_robot_late():
    missed, slow = Lateness(), Lateness()
    missed.note(0.0, 0.0)
    assert late(missed, 0.3, 0.3) == pytest.approx(0.3 - USUAL)
    slow.note(0.0, 0.0)
    assert late(slow, 0.1, 0.3) == pytest.approx(0.3 + 0.2 - USUAL)     # to here, and back


def test_what_was_late_is_expected_to_be_late_again_for_some_seconds():
    lateness = Lateness()
    lateness.note(0.0, 0.0)
    first = late(lateness, 0.5, 0.5)
    found = {round(0.5 + 0.1 * k, 1): late(lateness, 0.5 + 0.1 * k, 0.5 + 0.1 * k) for k in range(1, 50)}
    assert {time for time, each in found.items() if each} == {
        time for time in found if time <= 0.5 + EXPECTED} and set(found.values()) == {0.0, first}


def test_time_that_jumps_back_is_not_late():
    lateness = Lateness()
    lateness.note(1000.0, 1000.0)
    assert late(lateness, 5.0, 5.0) == 0.0

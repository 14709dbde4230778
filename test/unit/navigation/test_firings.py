"""When each sonar fired."""

import math

import pytest

from pioneer_control.navigation.firings import timed


def test_an_array_fires_one_transducer_after_the_other_and_both_arrays_at_once():
    firings = timed([(0, 1.0), (8, 2.0), (1, 1.5), (9, 5.0), (2, 3.0)], packet_time=7.0)
    assert [firing.number for firing in firings] == [0, 8, 1, 9, 2]
    assert [firing.time for firing in firings] == pytest.approx([6.90, 6.94, 6.94, 6.98, 6.98])


def test_the_longest_range_is_no_echo():
    assert [firing.range for firing in timed([(0, 4.999), (1, 5.0), (2, 5.2)], 0.0)] == [4.999, math.inf, math.inf]


def test_a_packet_without_sonar():
    assert timed([], 1.0) == ()

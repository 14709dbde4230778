"""The text form of times and durations."""

import numpy as np
import pytest

from pioneer_control.bags.pages.timeline import Timeline, how_long, spread


@pytest.mark.parametrize(
    "span, moment, written",
    [
        (2.0, 0.5, "0.5 s"), (9.0, 7.0, "7 s"), (80.0, 67.6, "68 s"), (199.0, 0.0, "0 s"), (300.0, 125.4, "2:05"),
        (7000.0, 6000.0, "100:00"),
        (9000.0, 4325.0, "1:12:05"),
    ],
)  # fmt: skip
def test_a_moment(span, moment, written):
    assert Timeline(1e9, 1e9 + span).write(1e9 + moment) == written


@pytest.mark.parametrize("span", [0.0, 0.05, 1.0, 2.0, 13.0, 80.0, 200.0, 3600.0, 86400.0, 1e7])
@pytest.mark.parametrize("most", [5, 12])
def test_ticks_are_few_and_round_and_none_is_written_like_another(span, most):
    line = Timeline(1e9, 1e9 + span)
    ticks = line.ticks(most)
    assert 1 <= len(ticks) <= most + 1 and ticks[0] == 1e9
    assert len({line.number(tick) for tick in ticks}) == len(ticks)
    if span >= 1.0:
        assert len(ticks) >= 2 and np.ptp(np.diff(ticks)) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("seconds, written", [
    (0.0, "0 s"),
    (7.46, "7.5 s"),
    (78.2, "78 s"),
    (725.0, "12 min 5 s"),
    (11520.0, "3 h 12 min"),
])
def test_a_length_of_time(seconds, written):
    assert how_long(seconds) == written


class TestSpread:
    def test_what_is_far_apart_stays(self):
        assert spread([1.0, 5.0, 9.0], 1.0, 0.0, 10.0) == [1.0, 5.0, 9.0]

    def test_what_is_near_moves_on(self):
        assert spread([1.0, 1.2, 1.4], 1.0, 0.0, 10.0) == pytest.approx([1.0, 2.0, 3.0])

    def test_nothing_leaves(self):
        assert spread([-1.0, 9.9, 10.0, 11.0], 1.0, 0.0, 10.0) == pytest.approx([0.0, 8.0, 9.0, 10.0])

    def test_too_many_share_what_there_is(self):
        assert spread([5.0] * 5, 4.0, 0.0, 8.0) == pytest.approx([0.0, 2.0, 4.0, 6.0, 8.0])

    def test_none(self):
        assert spread([], 1.0, 0.0, 10.0) == []

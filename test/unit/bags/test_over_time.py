"""The rows and curves of what is shown over time, before they are drawn."""

import numpy as np
import pytest

import run_factory as make
from pioneer_control.bags.pages import over_time
from pioneer_control.bags.pages.incidents import incidents
from pioneer_control.bags.recorded_run import GripperEvent, Report, Span
from pioneer_control.bags.pages.sheet import Sheet
from pioneer_control.bags.pages.timeline import Timeline

LINE = Timeline(make.BEGIN, make.BEGIN + 20.0)


def rows(run, line=LINE):
    """Return the lanes by name. Their times are counted from the begin of the run."""
    lanes = over_time.lanes(run, incidents(run), line)
    return {lane.name: lane._replace(spans=tuple((begin - make.BEGIN, end - make.BEGIN) for begin, end in lane.spans))
            for lane in lanes}


def test_nothing_known_nothing_shown():
    assert rows(make.run()) == {} and over_time.curves(make.run()) == []


def test_what_never_was_is_no_row_but_for_the_motors():
    assert set(rows(make.run(motors=make.series((0, 0)), e_stop=make.series((0, 0))))) == {"motors on"}


def test_on_until_the_end():
    found = rows(make.run(motors=make.series((0, 0), (5, 1), (8, 0), (15, 1))))
    assert found["motors on"].spans == ((5.0, 8.0), (15.0, 20.0))


def test_the_gripper_holds_from_pick_to_put():
    events = [GripperEvent(make.BEGIN + time, what)
              for time, what in ((2, "closed on nothing"), (5, "picked up"), (9, "put down"))]
    lane = rows(make.run(gripper=tuple(events)))["gripper"]
    assert lane.spans == ((5.0, 9.0),) and [words for _, words, _ in lane.badges] == ["1", "2", "3"]


def test_too_many_events_have_no_numbers():
    many = tuple(GripperEvent(make.BEGIN + n / 10, "closed on nothing") for n in range(over_time.BADGES + 1))
    assert "gripper" not in rows(make.run(gripper=many)) or not rows(make.run(gripper=many))["gripper"].badges


def test_errors_and_warnings_have_rows_of_their_own():
    found = rows(make.run(faults=(Report(make.BEGIN + 1, 1, "", "slow"), Report(make.BEGIN + 2, 2, "", "gone"))))
    assert [words for _, words, _ in found["warnings"].badges + found["errors"].badges] == ["A", "B"]


def test_each_thing_that_a_program_was_about_has_a_row():
    spans = (1, 5, "driving"), (5, 8, "turning"), (8, 9, "driving"), (9, 9, "no reason")
    doings = tuple(Span(make.BEGIN + begin, make.BEGIN + end, what) for begin, end, what in spans)
    found = rows(make.run(doings=doings))
    assert found["decided: driving"].spans == ((1.0, 5.0), (8.0, 9.0))
    assert found["decided: turning"].spans == ((5.0, 8.0),)
    assert found["decided: no reason"].spans == ((9.0, 9.0),)


def test_no_more_than_the_commonest_of_them():
    assert len([name for name in rows(make.full(make.track(20.0), times=30))
                if name.startswith("decided")]) == over_time.DOINGS


class TestPacked:
    def packed(self, *spans):
        shifted = [Span(make.BEGIN + begin, make.BEGIN + end, what) for begin, end, what in spans]
        lanes = over_time.packed("made", "#000000", shifted, LINE, 10.0)
        return [([round(begin - make.BEGIN) for begin, _ in lane.spans], [what for _, what in lane.words])
                for lane in lanes]

    def test_one_after_the_other_share_a_row(self):
        assert self.packed((1, 2, "stall"), (5, 6, "cable")) == [([1, 5], ["stall", "cable"])]

    def test_at_once_they_do_not(self):
        assert self.packed((1, 6, "stall"), (5, 8, "cable")) == [([1], ["stall"]), ([5], ["cable"])]

    def test_nor_when_their_words_would_touch(self):
        assert len(self.packed((1, 1.1, "a word much longer than its span"), (2, 2.1, "b"))) == 2

    def test_words_stay_on_the_page(self):
        (lane,) = over_time.packed("made", "#000000", [Span(LINE.end - 1, LINE.end, "as long as this")], LINE, 10.0)
        assert lane.words[0][0] < LINE.end - 1

    def test_of_very_many_the_last_have_no_words_and_are_there(self):
        found = self.packed(*[(1 + n / 10, 15, "stall") for n in range(9)])
        assert len(found) == over_time.ROWS
        assert sum(len(begins) for begins, _ in found) == 9
        assert sum(len(words) for _, words in found) == over_time.ROWS


@pytest.mark.parametrize("low, high", [
    (-0.1, 0.1),
    (-0.01, 0.11),
    (12.5, 13.5),
    (10.9, 13.1),
    (0.0, 0.1),
    (-3e4, 5.0),
    (-1.0, 24.0),
])
@pytest.mark.parametrize("name, height", [("forward", over_time.CURVE), ("battery", over_time.BATTERY)])
def test_values_on_an_axis_are_round_and_few_and_inside(low, high, name, height):
    axes = Sheet(2.0).axes(1.0, 0.5, 5.0, height)
    values = np.array([low, high])
    over_time.draw_curves(axes, over_time.Curves(name, height, ((values, values, {}),), 1e-9, False), 5.0)
    over_time.draw_time(axes, LINE, 5, None)    # it chooses the size of the numbers
    (bottom, top), ticks = axes.get_ylim(), axes.get_yticks()
    ticks = ticks[(ticks >= bottom) & (ticks <= top)]
    assert 1 <= len(ticks) <= height / over_time.VALUES_APART
    assert np.allclose(ticks, [float("%.6g" % tick) for tick in ticks], atol=1e-9)
    beyond = axes.yaxis.get_tightbbox(axes.figure.canvas.get_renderer())
    frame = axes.get_window_extent()
    least = max(frame.y0 - beyond.y0, beyond.y1 - frame.y1) / axes.figure.dpi
    assert least < over_time.BETWEEN / 2, "numbers of two strips do not touch"


def test_what_was_not_heard_of_is_not_drawn():
    of = make.track(20.0)
    of = type(of)(*(values[(of.time < make.BEGIN + 4.05) | (of.time > make.BEGIN + 5.95)] for values in of))
    gaps = Span(make.BEGIN + 4.0, make.BEGIN + 6.0,
                "/pioneer/pose"), Span(make.BEGIN + 9.0, make.BEGIN + 10.0, "/pioneer/sonar")
    forward = over_time.curves(make.run(of, measured=make.velocities(of), gaps=gaps))[0]
    ((time, value, _),) = forward.lines
    assert time[np.isnan(value)] - make.BEGIN == pytest.approx([5.0]) and (np.diff(time) >= 0).all()


def test_a_gap_takes_nothing_else_of_a_curve_that_hardly_changes():
    battery = make.series((0, 13.0), (20, 13.0))
    gaps = tuple(Span(make.BEGIN + 4.0, make.BEGIN + 6.0, "/pioneer/%s" % name)
                 for name in ("battery", "battery_state"))
    (strip,) = over_time.curves(make.run(battery=battery, gaps=gaps))
    ((time, value, _),) = strip.lines
    assert (time - make.BEGIN).tolist() == [0.0, 4.0, 5.0, 6.0, 20.0]
    assert np.isnan(value).tolist() == [False, False, True, False, False]


def test_a_gap_before_the_first_value_or_after_the_last_changes_nothing():
    battery = make.series((5, 13.0), (15, 13.0))
    gaps = Span(make.BEGIN, make.BEGIN + 5.0, "/battery"), Span(make.BEGIN + 15.0, make.BEGIN + 20.0, "/battery")
    assert len(over_time.curves(make.run(battery=battery, gaps=gaps))[0].lines[0][0]) == 2


def test_when_it_drove_to_goals_waited_and_was_not_sure():
    found = rows(make.run(navigation=make.navigated(make.track(20.0))))
    assert found["drives to a goal"].spans == ((0.0, 10.0),) and found["waits"].spans == ((1.0, 2.0),)
    assert found["not sure where"].spans == ((0.0, 5.0),)
    sure = make.navigated(make.track(20.0), states=(), unsure=())
    assert not set(rows(make.run(navigation=sure))) & {"drives to a goal", "waits", "not sure where"}

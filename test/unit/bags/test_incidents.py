"""The texts about faults and gaps on a page."""

import pytest

import run_factory as make
from pioneer_control.bags.pages.incidents import incidents, made, silences
from pioneer_control.bags.recorded_run import Report, Span


def said(*faults):
    """Return (letter, level, times, words) of faults (time, level, who, what)."""
    return [tuple(each) for each in incidents(make.run(faults=tuple(Report(*fault) for fault in faults)))]


class TestIncidents:
    def test_in_order_of_time(self):
        found = said((2.0, 1, "Link", "slow"), (1.0, 2, "/pioneer/p2os", "gone"))
        assert found == [("A", 2, (1.0,), "p2os: gone"), ("B", 1, (2.0,), "Link: slow")]

    def test_the_same_again_is_one(self):
        found = said((1.0, 1, "Battery", "low: 11.2 V"), (9.0, 1, "Battery", "low: 11.0 V"))
        assert found == [("A", 1, (1.0, 9.0), "Battery: low: 11.2 V")]

    def test_what_a_node_and_its_diagnostics_say_happened_once(self):
        both = [
            (1.0, 2, "Link", "no link: the robot is silent"),
            (1.001, 1, "/pioneer/p2os", "the robot is silent (trying again)"),
        ]
        assert said(*both) == [("A", 2, (1.0,), "Link: no link: the robot is silent")]

    @pytest.mark.parametrize("longer", ["no link: the robot is silent", "the robot is silent; is it switched on?"])
    def test_whichever_says_more_and_whichever_came_first(self, longer):
        short = "the robot is silent"
        assert said((1.0, 2, "Link", longer), (1.5, 1, "/p2os", short)) == [("A", 2, (1.0,), "Link: %s" % longer)]
        assert said((1.0, 1, "/p2os", short), (1.5, 2, "Link", longer)) == [("A", 2, (1.0,), "p2os: %s" % short)]

    def test_what_is_said_again_and_again_without_a_pause_happened_once(self):
        found = said(*((time, 1, "Link", "slow") for time in (1.0, 2.0, 3.0, 4.001)))
        assert found == [("A", 1, (1.0, 4.001), "Link: slow")]

    def test_others_are_not(self):
        assert len(said((1.0, 1, "Link", "slow"), (1.0, 1, "Battery", "low"))) == 2

    def test_letters_go_to_errors_first(self):
        faults = [Report(float(n), 2 if n == 3 else 1, "", "abcd"[n]) for n in range(4)]
        found = incidents(make.run(faults=tuple(faults)), listed=2)
        assert [(each.letter, each.words) for each in found] == [("A", "a"), ("", "b"), ("", "c"), ("B", "d")]

    def test_what_was_asked_for_is_no_fault(self):
        assert said((1.0, 1, "/pioneer/simulator", "simulated 3.041 s: fault begins: stall")) == []

    def test_a_driver_that_has_just_begun_to_look_for_its_robot_is_no_fault(self):
        assert said((make.BEGIN - 1.0, 2, "Link", "no link")) == []
        assert len(said((make.BEGIN - 20.0, 2, "Link", "no link"), (make.BEGIN + 1.0, 2, "Battery", "empty"))) == 2


class TestMade:
    def made(self, *faults):
        reports = [Report(time, 1, "/sim", "simulated 1.0 s: %s" % what) for time, what in faults]
        return [tuple(each) for each in made(reports, 99.0)]

    def test_from_begin_to_end(self):
        assert self.made((1.0, "fault begins: stall"), (4.0, "fault ends: stall")) == [(1.0, 4.0, "stall")]

    def test_until_the_end_where_nobody_mended_it(self):
        assert self.made((1.0, "fault begins: stall"), (4.0, "fault ends: loss 0.1")) == [(1.0, 99.0, "stall")]

    def test_twice(self):
        asked = [
            (1.0, "fault begins: stall"),
            (2.0, "fault ends: stall"),
            (3.0, "fault begins: stall"),
            (4.0, "fault ends: stall"),
        ]
        assert self.made(*asked) == [(1.0, 2.0, "stall"), (3.0, 4.0, "stall")]

    def test_of_two_at_a_time_the_first_ends_first(self):
        asked = (1.0, "fault begins: stall"), (2.0, "fault begins: stall"), (3.0, "fault ends: stall")
        assert self.made(*asked) == [(1.0, 3.0, "stall"), (2.0, 99.0, "stall")]


class TestSilences:
    def test_those_at_once_are_one(self):
        gaps = Span(1.0, 4.0, "/pioneer/pose"), Span(1.2, 4.5, "/pioneer/sonar"), Span(6.0, 7.0, "/pioneer/pose")
        assert [tuple(each) for each in silences(gaps)] == [(1.0, 4.5, "pose, sonar"), (6.0, 7.0, "pose")]

    def test_one_within_another_makes_it_no_shorter(self):
        found = silences([Span(1.0, 9.0, "/pose"), Span(2.0, 3.0, "/sonar")])
        assert [tuple(each) for each in found] == [(1.0, 9.0, "pose, sonar")]

    def test_two_with_a_message_between_are_two(self):
        found = silences([Span(1.0, 4.0, "/pose"), Span(4.0, 7.0, "/pose")])
        assert [tuple(each) for each in found] == [(1.0, 4.0, "pose"), (4.0, 7.0, "pose")]

    def test_of_many_topics_the_first_are_named(self):
        assert silences([Span(1.0, 2.0, "/p/%s" % name) for name in "abcdef"])[0].what == "a, b, c and 3 more"
        assert silences([Span(1.0, 2.0, "/p/%s" % name) for name in "abcd"])[0].what == "a, b, c and 1 more"
        assert silences([Span(1.0, 2.0, "/%s/pose" % robot) for robot in "abcd"])[0].what == "pose"

    def test_none(self):
        assert silences([]) == ()

"""What viewers get and when: the whole picture first, batches, acknowledgements, limits, and never growing memory."""

import json
import math

import pytest

from pioneer_control.errors import UsageError
from pioneer_control.web import fleet as fleet_module
from pioneer_control.web.backend import Person
from pioneer_control.web.fleet import (
    ACKNOWLEDGE, BATCH, MOST_MESSAGES, MOST_NAMES, MOST_SAID, MOST_VIEWERS, TOO_MANY, TOO_SLOW, Fleet)
from pioneer_control.web.frames import RobotFrame, encode_frame, read_frames, stamp_of


def frame(robot=1, now=0.0, x=0.0):
    return encode_frame(RobotFrame(robot, stamp_of(now), x=x))


def person(number=1, visitor=None, teacher=False):
    return Person(number, visitor or "visitor%09d" % number, "", teacher)


def robots(*numbers):
    return [{"robot": number} for number in numbers]


class Show:
    """A fleet with a clock, and what each viewer got: texts as dictionaries, binary messages as lists of frames."""

    def __init__(self, *viewers):
        self.fleet = Fleet("lab")
        self.now = 100.0
        self.stuck = set()
        for number in viewers:
            assert self.fleet.arrive(number, person(number), self.now) is None

    def round(self):
        """Return what each viewer gets now."""
        got = {}
        for number, messages in self.fleet.round(self.now, lambda number: number not in self.stuck):
            got[number] = [json.loads(each) if isinstance(each, str) else read_frames(each) for each in messages]
        return got

    def frame(self, robot=1, x=0.0):
        self.fleet.frame(frame(robot, self.now, x))

    def acknowledge(self, number, stamp=None):
        self.fleet.drawn(number, stamp_of(self.now) if stamp is None else stamp, self.now)


def kinds(messages):
    return [next(iter(each)) if isinstance(each, dict) else "frames" for each in messages]


def test_on_arrival_the_complete_picture_in_order():
    show = Show()
    show.fleet.text("world", None)
    show.fleet.text("robots", robots(1, 2))
    show.fleet.text("status", {"robot": 1}, 1)
    show.fleet.text("helm", {"robot": 2, "you": False}, 2)
    show.frame(1, 0.5)
    show.frame(2)
    show.fleet.arrive(7, person(7, teacher=True), show.now)
    assert show.fleet.wait(show.now) <= 0
    messages = show.round()[7]
    assert kinds(messages) == ["hello", "robots", "world", "status", "helm", "trail", "trail", "frames"]
    assert messages[0] == {"hello": {"title": "lab", "kind": "live", "teacher": True, "you": ""}}
    assert messages[5] == {"trail": {"robot": 1, "points": [[0.5, 0.0]]}}
    assert [each.robot for each in messages[-1]] == [1, 2]
    assert show.round() == {} and show.fleet.wait(show.now) == math.inf


def test_a_frame_after_a_pause_goes_at_once_and_then_batches():
    show = Show(1)
    show.round()
    show.now += 1.0
    show.frame(1)
    assert show.fleet.wait(show.now) <= 0 and len(show.round()[1][0]) == 1
    show.acknowledge(1)
    show.now += 0.001
    show.frame(1)
    show.frame(2)
    show.frame(2, x=1.0)
    assert show.fleet.wait(show.now) == pytest.approx(BATCH - 0.001) and show.round() == {}
    show.now += BATCH
    assert show.fleet.wait(show.now) <= 0
    got, = show.round()[1]
    assert [(each.robot, each.x) for each in got] == [(1, 0.0), (2, 1.0)]     # the newest of each


def test_without_drawn_nothing_more_and_then_the_newest():
    show = Show(1, 2)
    show.round()
    got = 0
    for _ in range(100):
        show.now += BATCH
        show.frame(1, x=show.now)
        show.acknowledge(2)
        result = show.round()
        got += 1 in result
        assert 2 in result
    assert ACKNOWLEDGE / BATCH <= got <= ACKNOWLEDGE / BATCH + 2
    assert len(show.fleet.viewers[1].unanswered) <= got
    show.acknowledge(1)
    assert show.fleet.wait(show.now) <= 0
    newest, = show.round()[1]
    assert len(newest) == 1 and newest[0].x == pytest.approx(show.now, abs=0.001)


def test_texts_come_also_to_who_does_not_draw():
    show = Show(1)
    for _ in range(100):
        show.now += BATCH
        show.frame()
        show.round()
    show.fleet.text("helm", {"robot": 1}, 1)
    assert kinds(show.round()[1]) == ["helm"]


def test_an_old_acknowledgement_is_none_of_the_newest():
    show = Show(1)
    show.frame()
    first = stamp_of(show.now)
    show.round()
    show.now += 0.3
    show.frame()
    show.round()
    show.acknowledge(1, first)
    show.now += 0.3
    show.frame()
    assert 1 in show.round()        # the second batch is 0.3 s old
    show.now += 0.3
    show.frame()
    assert show.round() == {}       # and now 0.6 s


def test_acknowledgements_go_round_with_the_stamps():
    show = Show(1)
    show.now = 2 ** 32 / 1000 - 0.01
    show.frame()
    show.round()
    show.now += 0.03
    show.frame()
    show.round()
    show.acknowledge(1)
    assert not show.fleet.viewers[1].unanswered


def last_stamp(got):
    """Return what a page acknowledges: the stamp of the last frame that it got."""
    return got[1][-1][-1].stamp


def test_the_last_frame_of_a_batch_is_the_one_that_is_waited_for():
    show = Show(1)
    show.round()
    for robot, stamp in ((1, 100.0), (2, 100.01), (1, 100.02)):
        show.fleet.frame(frame(robot, stamp))
    show.acknowledge(1, last_stamp(show.round()))
    show.now += 2 * ACKNOWLEDGE
    show.frame()
    assert 1 in show.round()


def test_a_batch_with_a_stamp_that_was_drawn_already_is_not_waited_for():
    show = Show(1)
    show.frame(1)
    stamp = last_stamp(show.round())
    show.acknowledge(1, stamp)
    show.now += BATCH
    show.fleet.frame(frame(2, 100.0))
    assert last_stamp(show.round()) == stamp        # and a page does not tell the same twice
    show.now += 2 * ACKNOWLEDGE
    show.frame()
    assert 1 in show.round()


def test_a_batch_with_an_older_stamp_acknowledges_the_one_before():
    show = Show(1)
    show.round()
    show.fleet.frame(frame(1, 100.02))
    show.round()
    show.now += BATCH
    show.fleet.frame(frame(2, 100.01))
    show.acknowledge(1, last_stamp(show.round()))
    assert not show.fleet.viewers[1].unanswered


def test_a_stuck_viewer_delays_nobody_and_gets_the_newest_of_each_later():
    show = Show(1, 2)
    show.round()
    show.stuck = {1}
    for step in range(1000):
        show.now += BATCH
        show.frame(1, x=step / 100)
        show.fleet.text("status", {"robot": 1, "step": step}, 1)
        show.acknowledge(2)
        assert list(show.round()) == [2]
    viewer = show.fleet.viewers[1]
    assert len(viewer.texts) == 1 and len(viewer.unanswered) <= 1 and not viewer.said
    show.stuck = set()
    status, newest = show.round()[1]
    assert status == {"status": {"robot": 1, "step": 999}} and [each.x for each in newest] == [9.99]


def test_who_reads_too_slowly_for_what_is_said_is_sent_away():
    show = Show(1, 2)
    show.round()
    show.stuck = {1}
    for step in range(MOST_SAID + 5):
        show.fleet.said("info", "sentence %d" % step)
        show.round()
    farewells = show.fleet.farewells()
    assert list(farewells) == [1] and farewells[1].code == TOO_SLOW and farewells[1].reason
    assert len(show.fleet.viewers[1].said) == MOST_SAID and show.fleet.farewells() == {}


def test_the_same_sentence_is_said_once_a_second():
    show = Show(1, 2)
    show.round()
    for _ in range(20):
        show.fleet.said("error", "refused", 1, [1], show.now)
        show.now += 0.05
    assert show.round() == {1: [{"said": {"robot": 1, "level": "error", "text": "refused"}}]}
    show.now += 1.0
    show.fleet.said("error", "refused", 1, [1, 99], show.now)
    assert list(show.round()) == [1]
    for step in range(3 * MOST_SAID):
        show.fleet.said("error", "no %d" % step, 1, [1], show.now)
    assert len(show.fleet.viewers[1].told) == MOST_SAID


def test_only_who_has_the_seat_reads_you():
    show = Show(1, 2)
    show.fleet.text("helm", {"robot": 1, "you": False}, 1, person(2).visitor)
    got = show.round()
    assert got[1][-1] == {"helm": {"robot": 1, "you": False}} and got[2][-1] == {"helm": {"robot": 1, "you": True}}
    assert person(2).visitor not in json.dumps(got)


def test_robots_come_and_go():
    show = Show(1)
    show.fleet.text("robots", robots(1, 2))
    show.frame(1)
    show.frame(2)
    show.fleet.text("helm", {"robot": 2}, 2)
    assert kinds(show.round()[1]) == ["hello", "robots", "trail", "trail", "helm", "frames"]
    show.fleet.text("robots", robots(2, 3))
    assert kinds(show.round()[1]) == ["robots", "trail"]
    show.fleet.text("robots", robots(3))
    show.round()
    show.fleet.arrive(2, person(2), show.now)
    assert kinds(show.round()[2]) == ["hello", "robots", "trail"]     # nothing of robots that went


def test_a_trail_that_the_owner_kept_goes_on():
    show = Show()
    show.fleet.text("robots", robots(1))
    show.fleet.text("trail", [[0.0, 0.0], [0.1, 0.0]], 1)
    show.frame(1, 0.2)
    show.fleet.arrive(1, person(1), show.now)
    trail = [each for each in show.round()[1] if "trail" in each]
    assert trail == [{"trail": {"robot": 1, "points": [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]}}]


def test_the_61st_viewer_is_sent_away():
    show = Show(*range(1, MOST_VIEWERS + 1))
    farewell = show.fleet.arrive(99, person(99), show.now)
    assert farewell.code == TOO_MANY and "60" in farewell.reason
    show.fleet.leave(1)
    assert show.fleet.arrive(99, person(99), show.now) is None


def test_a_hundred_messages_a_second():
    show = Show(1, 2)
    assert all(show.fleet.hears(1, show.now) is None for _ in range(MOST_MESSAGES))
    assert show.fleet.hears(1, show.now).code == TOO_MANY and show.fleet.hears(2, show.now) is None
    for _ in range(500):
        show.now += 1 / 99.0
        assert show.fleet.hears(2, show.now) is None
    show.now += 3600.0
    assert sum(show.fleet.hears(2, show.now) is None for _ in range(1000)) == MOST_MESSAGES


def test_a_name_is_kept_for_the_next_visit_and_names_do_not_grow():
    show = Show(1)
    show.fleet.name(1, "Ada")
    assert show.fleet.viewers[1].person.name == "Ada"
    show.fleet.leave(1)
    show.fleet.arrive(2, person(2, person(1).visitor), show.now)
    assert show.round()[2][0]["hello"]["you"] == "Ada"
    for number in range(10, 10 + 2 * MOST_NAMES):
        show.fleet.arrive(number, person(number), show.now)
        show.fleet.name(number, "N")
        show.fleet.leave(number)
    assert len(show.fleet._names) == MOST_NAMES


def test_who_left_gets_nothing():
    show = Show(1, 2)
    show.fleet.leave(1)
    show.fleet.leave(1)
    show.fleet.text("world", None)
    assert list(show.round()) == [2]


def test_what_is_no_frame_or_no_json():
    show = Show(1)
    with pytest.raises(UsageError):
        show.fleet.frame(b"123")
    with pytest.raises(UsageError, match="status"):
        show.fleet.text("status", {"robot": 1, "volts": math.nan}, 1)


def test_sixty_viewers_share_their_batches(monkeypatch):
    """The bytes of a batch are put together once, not once for each viewer."""
    show = Show(*range(1, MOST_VIEWERS + 1))
    show.round()
    made = []
    join = fleet_module.frames_message
    monkeypatch.setattr(fleet_module, "frames_message", lambda frames: made.append(1) or join(frames))
    show.now += 1.0
    for robot in range(30):
        show.frame(robot)
    assert len(show.round()) == MOST_VIEWERS and len(made) == 1


def test_a_recording_is_given_whole_to_each_viewer_once_whenever_it_comes():
    fleet = Fleet("run.bag", "recording")
    fleet.whole(b"\x03first")
    fleet.arrive(1, Person(1, "v" * 16), 0.0)
    got = dict(fleet.round(0.0, lambda number: True))
    assert json.loads(got[1][0])["hello"]["kind"] == "recording" and got[1][-1] == b"\x03first"
    fleet.whole(b"\x02second")
    assert fleet.wait(0.1) <= 0
    assert dict(fleet.round(0.1, lambda number: True)) == {1: [b"\x02second"]}
    fleet.arrive(2, Person(2, "w" * 16), 0.2)
    assert dict(fleet.round(0.2, lambda number: True))[2][1:] == [b"\x03first", b"\x02second"]
    assert dict(fleet.round(0.3, lambda number: True)) == {}


def told(messages, kind):
    return [each[kind] for each in messages if kind in each]


def test_a_text_for_few_goes_before_one_for_all_and_nobody_else_sees_it():
    show = Show(1, 2)
    show.fleet.arrive(3, person(3, teacher=True), show.now)
    show.fleet.text("join", True)
    show.fleet.text("join", False, to="teachers")
    show.fleet.text("program", {"robot": 1, "key": "secret"}, 1, to=person(1).visitor)
    show.fleet.text("program", {"robot": 1, "key": "secret"}, 1, to="teachers")
    got = show.round()
    assert [told(got[each], "join") for each in (1, 2, 3)] == [[True], [True], [False]]
    assert [len(told(got[each], "program")) for each in (1, 2, 3)] == [1, 0, 1]
    show.fleet.text("join", False, to=person(1).visitor)
    assert told(show.round()[1], "join") == [False]
    show.fleet.leave(1)
    show.fleet.arrive(4, person(4, person(1).visitor), show.now)       # a reload
    show.fleet.arrive(5, person(5), show.now)
    got = show.round()
    assert told(got[4], "join") == [False] and told(got[4], "program")[0]["key"] == "secret"
    assert told(got[5], "join") == [True] and "secret" not in str(got[5])
    show.fleet.text("join", None, to=person(1).visitor)
    show.fleet.text("program", None, 1, to=person(1).visitor)
    got = show.round()
    assert kinds(got[4]) == ["join"] and told(got[4], "join") == [True] and 5 not in got


def test_students_with_a_robot_and_teachers_come_in_also_when_all_pages_are_open():
    show = Show(*range(1, MOST_VIEWERS + 1))
    show.fleet.text("mine", {"robot": 1}, to=person(77).visitor)
    assert show.fleet.arrive(99, person(99), show.now).code == TOO_MANY
    assert show.fleet.arrive(100, person(100, teacher=True), show.now) is None
    own = [show.fleet.arrive(200 + tab, person(200 + tab, person(77).visitor), show.now) for tab in range(5)]
    assert own[:4] == [None] * 4 and own[4].code == TOO_MANY

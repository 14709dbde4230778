"""Sonar messages are joined with the poses of the same stamp. It does not matter which topic is faster, or what gets
lost.
"""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pioneer_control.floor_poses import Pose
from pioneer_control.tutorial.sights import JUMP_BACK, KEPT, Sights

SECOND = 10 ** 9
FIRST = 1_700_000_000 * SECOND


def pose_of(number):
    return Pose(float(number), 0.0, 0.0)


def seen(events):
    """Give events to Sights: ("pose" or "sonar", stamp [tenths of a second after FIRST, or None]).

    Returns (stamp, number of the pose, number of the sonar message). Messages are numbered in their order on their
    topic.
    """
    sights, counts, found = Sights(), {"pose": 0, "sonar": 0}, []
    for place, (topic, stamp) in enumerate(events):
        number, nanoseconds = counts[topic], 0 if stamp is None else FIRST + round(stamp * SECOND / 10)
        counts[topic] += 1
        if topic == "pose":
            new = sights.add_pose(nanoseconds, pose_of(number), FIRST + place * SECOND)
        else:
            new = sights.add_sonar(nanoseconds, (float(number),))
        found += [((sight.stamp - FIRST) * 10 / SECOND, int(sight.pose.x), int(sight.ranges[0])) for sight in new]
    return found


def both(*stamps):
    return [event for stamp in stamps for event in (("pose", stamp), ("sonar", stamp))]


def test_the_pose_of_the_same_stamp_whichever_comes_first():
    assert seen(both(1, 2)) == [(1, 0, 0), (2, 1, 1)]
    mixed = [("sonar", 1), ("pose", 1), ("pose", 2), ("pose", 3), ("sonar", 2), ("sonar", 3)]
    assert seen(mixed) == [(1, 0, 0), (2, 1, 1), (3, 2, 2)]


def test_it_is_seen_as_soon_as_both_are_there():
    assert seen([("sonar", 1), ("sonar", 2)]) == [] == seen([("pose", 1), ("pose", 2)])
    assert seen([("sonar", 1), ("sonar", 2), ("pose", 1)]) == [(1, 0, 0)]


def test_where_the_pose_is_missing_the_last_before_it_serves_and_tells_its_age():
    events = both(1) + [("sonar", 2), ("pose", 3), ("sonar", 3)]
    assert seen(events) == [(1, 0, 0), (2, 0, 1), (3, 1, 2)]
    assert seen(events[:3]) == [(1, 0, 0)]     # it may still come
    sights = Sights()
    assert [sight.pose_age for stamp in (1, 2) for sight in sights.add_pose(stamp * SECOND, pose_of(0), 0)] == []
    assert [sight.pose_age for sight in sights.add_sonar(3 * SECOND // 2, ())] == [0.5]
    assert [sight.pose_age for sight in sights.add_sonar(2 * SECOND, ())] == [0.0]


def test_a_pose_without_sonar_is_passed_over():
    assert seen([("pose", 1), ("pose", 2), ("pose", 3), ("sonar", 3)]) == [(3, 2, 0)]


def test_nothing_is_seen_before_the_first_pose():
    assert seen([("sonar", 1), ("sonar", 2), ("pose", 2), ("sonar", 3), ("pose", 3)]) == [(2, 0, 1), (3, 1, 2)]
    assert seen([("sonar", None), ("pose", 1)]) == []


def test_equal_stamps_one_after_the_other_belong_together_in_their_order():
    """The clock is coarse, and two packets come between two ticks."""
    assert seen([("sonar", 1), ("sonar", 1), ("pose", 1), ("pose", 1)]) == [(1, 0, 0), (1, 1, 1)] == seen(both(1, 1))


def test_stamps_that_go_back_a_little_are_no_jump():
    """ROS time is paused, and the stamp is that time minus the age of the packet."""
    assert seen(both(5, 4.99, 5.01, 4.98)) == [(5, 0, 0), (4.99, 1, 1), (5.01, 2, 2), (4.98, 3, 3)]
    assert seen(both(5) + [("sonar", 4.99), ("pose", 5.1), ("sonar", 5.1)])[1:] == [(4.99, 0, 1), (5.1, 1, 2)]
    sights = Sights()
    found = [
        *sights.add_pose(5 * SECOND, pose_of(0), 0), *sights.add_sonar(5 * SECOND, ()),
        *sights.add_sonar(5 * SECOND - 10 ** 6, ()), *sights.add_pose(6 * SECOND, pose_of(1), 0)]
    assert [sight.pose_age for sight in found] == [0.0, 0.0], "a pose is never older than it is"


@pytest.mark.parametrize("back", [4.99, 5 - 10])
def test_going_back_on_one_topic_by_no_more_than_a_second_is_no_jump_of_it(back):
    events = both(5) + [("pose", back), ("sonar", 30), ("pose", 10), ("pose", 30)]
    assert seen(events) == [(5, 0, 0), (30, 3, 1)]


@pytest.mark.parametrize("events", [
    both(100, 101, 0, 1),
    [("sonar", 100), ("sonar", 101), ("sonar", 0), ("pose", 100), ("pose", 101), ("sonar", 1), ("pose", 0),
     ("pose", 1)],
    [("pose", 100), ("pose", 101), ("pose", 0), ("pose", 1), ("sonar", 100), ("sonar", 101), ("sonar", 0),
     ("sonar", 1)],
])
def test_time_jumps_back_on_one_topic_before_the_other(events):
    assert seen(events) == [(100, 0, 0), (101, 1, 1), (0, 2, 2), (1, 3, 3)]


def test_time_jumps_back_where_a_message_of_the_other_topic_is_missing():
    before = both(100) + [("pose", 102), ("sonar", 0), ("pose", 0)]
    assert seen(before) == [(100, 0, 0), (0, 2, 1)], "it does not wait for the last pose of before"
    before = both(100) + [("sonar", 102), ("pose", 0)]
    assert seen(before) == [(100, 0, 0), (102, 0, 1)], "nor does the pose of the last sonar message come any more"


def test_a_pose_that_is_seconds_newer_ends_the_waiting():
    assert seen(both(0) + [("sonar", 10), ("pose", 30)]) == [(0, 0, 0), (10, 0, 1)]


def test_after_a_jump_back_no_pose_of_before_serves():
    events = [("pose", 100), ("sonar", 100), ("sonar", 0), ("pose", 1), ("sonar", 1)]
    assert seen(events) == [(100, 0, 0), (1, 1, 2)]


def test_a_jump_back_that_one_topic_does_not_show_ends_nothing():
    """A bag of one second is played in a loop. Its sonar begins later than its pose."""
    times = [
        ("pose", 0), ("pose", 11), ("sonar", 2), ("sonar", 11), ("pose", 0), ("sonar", 2), ("pose", 11), ("sonar", 11)]
    assert len(seen(times * 5)) > 10


def stalls_seen(events):
    """Take events of ("pose", "sonar", "stall" or "free", tenth of a second). Returns (tenth of a sonar message,
    stalled at that time?).
    """
    sights, found = Sights(), []
    for topic, tenth in events:
        stamp = FIRST + round(tenth * SECOND / 10)
        if topic in ("stall", "free"):
            new = sights.add_stall(stamp, topic == "stall")
        else:
            new = sights.add_pose(stamp, pose_of(0), 0) if topic == "pose" else sights.add_sonar(stamp, (5.0,))
        found += [((sight.stamp - FIRST) * 10 / SECOND, sight.stalled) for sight in new]
    return found


def test_a_stall_belongs_to_the_sonar_message_of_its_stamp():
    """Any of the three may come last."""
    for order in itertools.permutations([("pose", 2), ("sonar", 2), ("stall", 2)]):
        assert stalls_seen([("free", 1), *order, ("free", 3), ("pose", 3), ("sonar", 3)]) == [(2, True), (3, False)]


def test_a_robot_that_tells_of_stalls_is_waited_for():
    assert stalls_seen([("free", 1), ("pose", 2), ("sonar", 2)]) == []
    assert stalls_seen([("free", 1), ("pose", 2), ("sonar", 2), ("stall", 3)]) == [(2, False)], "its own got lost"


def test_a_driver_that_tells_of_no_stalls_is_not():
    assert stalls_seen([("pose", 1), ("sonar", 1), ("pose", 2), ("sonar", 2)]) == [(1, False), (2, False)]


def test_nor_is_one_that_has_told_of_none_for_long():
    events = [("stall", 1)] + [event for tenth in range(2, 130) for event in (("pose", tenth), ("sonar", tenth))]
    found = stalls_seen(events)
    assert len(found) == 128 and not any(stalled for tenth, stalled in found if tenth > 11)


def test_without_stamps_it_is_the_newest_pose_and_its_arrival():
    assert seen([("pose", None), ("sonar", None), ("pose", None), ("sonar", None)]) == [(0, 0, 0), (20, 1, 1)]
    assert seen([("pose", 1), ("sonar", None), ("pose", 2), ("sonar", None)]) == [(1, 0, 0), (2, 1, 1)]


def test_it_keeps_no_more_than_it_is_told_to():
    sights = Sights()
    assert list(sights.add_pose(1, pose_of(0), 0)) == []
    for number in range(KEPT + 5):
        assert list(sights.add_sonar(number + 2, ())) == []
    seen_stamps = [sight.stamp for sight in sights.add_pose(KEPT + 100, pose_of(1), 0)]
    assert seen_stamps == list(range(7, KEPT + 7)), "the oldest are dropped"


TENTH = SECOND // 10
STEPS = st.lists(st.sampled_from([-3 * JUMP_BACK, 0, TENTH, TENTH, TENTH, SECOND]), min_size=1, max_size=30)


@given(STEPS, st.data())
def test_which_topic_is_faster_changes_nothing(steps, data):
    """Any messages, some of them lost, in any order that keeps the order of each topic."""
    stamps = [FIRST + sum(steps[:count]) for count in range(len(steps))]
    lost = data.draw(st.sets(st.tuples(st.sampled_from(["pose", "sonar"]), st.integers(1, len(steps)))))
    topics = {
        topic: [stamp for number, stamp in enumerate(stamps) if (topic, number) not in lost]
        for topic in ("pose", "sonar")}
    last = stamps[-1] + 100 * SECOND     # so that nothing waits at the end
    topics = {topic: messages + [last] for topic, messages in topics.items()}

    def deliver(order):
        sights, found = Sights(), []
        waiting = {topic: list(messages) for topic, messages in topics.items()}
        for topic in order:
            stamp = waiting[topic].pop(0)
            count = float(len(waiting[topic]))
            if topic == "pose":
                found += sights.add_pose(stamp, Pose(count, 0, 0), 0)
            else:
                found += sights.add_sonar(stamp, (count,))
        return found

    in_turn = [topic for topic, messages in topics.items() for _ in messages]
    assert deliver(data.draw(st.permutations(in_turn))) == deliver(in_turn) == deliver(in_turn[::-1])

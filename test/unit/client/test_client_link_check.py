"""Questions that are sent with velocities, and what their answers tell about the line."""

import pytest
from fake_robot import SIP_CYCLE, Bench, FakeRobot, config
from hypothesis import given
from hypothesis import strategies as st

from pioneer_control import p2os
from pioneer_control.client import PacketReceived
from pioneer_control.client.drive import STOP
from pioneer_control.client.link_check import ANSWERED_WITHIN, EVERY, QUESTION, SILENCE, TOO_MANY, TRIES, LinkCheck

VEL_200, RVEL_0 = bytes.fromhex("FAFB060B3BC800D33B"), bytes.fromhex("FAFB06153B0000153B")


def questions(bench):
    return [heard.time for heard in bench.robot.heard if heard[1:] == ("ENCODER", 1)]


def counts(bench):
    return bench.session.counts.questions, bench.session.counts.unanswered


def received(bench):
    return [event.packet for event in bench.events if isinstance(event, PacketReceived)]


def go_on(bench, seconds):
    """Command velocities at 10 Hz."""
    for _ in range(round(seconds * 10)):
        bench.drive(0.2, 0.0)
        bench.run(0.1)


# The questions

def test_a_velocity_takes_a_question_along_in_one_write():
    bench = Bench().until_driving()
    bench.run(0.5)
    bench.writes.clear()
    bench.drive(0.2, 0.0)
    assert QUESTION == bytes.fromhex("FAFB06133B0100143B")
    assert bench.writes == {bench.now: [VEL_200 + RVEL_0 + QUESTION]}


def test_so_do_wheels():
    bench = Bench().until_driving()
    bench.run(0.5)
    bench.writes.clear()
    bench.session.connected.drive.set_wheel_velocities(0.2, 0.2, bench.now)
    bench.act()
    assert bench.writes == {bench.now: [bytes.fromhex("FAFB06203B0A0A2A45") + QUESTION]}


@pytest.mark.parametrize("hertz", [1, 5, 10, 100])
def test_it_asks_about_five_times_a_second_however_often_velocities_come(hertz):
    bench = Bench(command_timeout=2.0).until_driving()
    bench.robot.heard.clear()
    for _ in range(4 * hertz):
        bench.drive(0.2, 0.0)
        bench.run(1 / hertz)
    assert 16 <= len(questions(bench)) <= 4 / EVERY + 1


@pytest.mark.parametrize("rates", [(), (9600,)])
def test_a_question_never_goes_alone_nor_with_a_stop_nor_to_a_robot_that_stands(rates):
    bench = Bench(rates=rates).until_driving()
    for _ in range(3):
        for _ in range(30):             # faster than 9600 baud carries
            bench.drive(0.2, 0.0)
            bench.step()
        for _ in range(4):              # stops that wait for the line, too
            bench.session.connected.drive.stop(bench.now)
            bench.step()
        bench.run(3.0)
    writes = [write for at_once in bench.writes.values() for write in at_once if QUESTION in write]
    assert len(writes) >= 3 and all(write == VEL_200 + RVEL_0 + QUESTION for write in writes)
    asked = questions(bench)
    heard_last = {heard.name for heard in bench.robot.heard if heard.time > bench.now - 2.0}
    assert heard_last <= {"STOP"}, "a robot that stands hears STOP alone"
    assert bench.now - asked[-1] > 2.5


def test_after_a_pause_in_which_the_watchdog_may_have_stopped_it_the_stop_goes_first():
    bench = Bench(pulse=0.0).until_driving()
    bench.run(5.0)
    bench.writes.clear()
    bench.drive(0.2, 0.0)
    assert list(bench.writes.values()) == [[b"".join(STOP) + VEL_200 + RVEL_0 + QUESTION]]


def test_nobody_is_asked_who_shall_not_be():
    for bench in (Bench(link_check=False), Bench(data=frozenset({"encoder"})), Bench(model="pion1m")):
        go_on(bench.until_driving(), 2.0)
        assert questions(bench) == [] and counts(bench) == (0, 0)


# The answers

def test_all_are_answered_on_a_good_line_and_nobody_else_hears_of_it():
    bench = Bench().until_driving()
    go_on(bench, 10.0)
    bench.run(ANSWERED_WITHIN)
    asked, unanswered = counts(bench)
    assert asked == len(questions(bench)) > 45 and unanswered == 0
    assert received(bench) == []


def test_a_program_that_wants_encoders_gets_each_of_them():
    bench = Bench(data=frozenset({"encoder"})).until_driving()
    go_on(bench, 2.0)
    assert len(received(bench)) > 15 and set(received(bench)) == {p2os.Encoder(0, 0)} and counts(bench) == (0, 0)


def test_so_does_one_that_wants_them_in_the_midst_of_driving_until_it_wants_no_more():
    bench = Bench().until_driving()
    go_on(bench, 1.0)
    bench.want("encoder", True)
    go_on(bench, 2.0)
    came = len(received(bench))
    bench.want("encoder", False)
    go_on(bench, 2.0)
    bench.run(ANSWERED_WITHIN)
    assert came > 15 and len(received(bench)) <= came + 1
    assert counts(bench)[0] > 10 and counts(bench)[1] == 0


@pytest.mark.parametrize("lost", ["question", "answer"])
def test_one_that_is_lost_is_counted_while_it_drives_on(lost):
    bench = Bench().until_driving()
    go_on(bench, 1.0)
    before = len(questions(bench))
    deaf, mute = bench.robot.deaf, bench.robot.mute
    if lost == "question":
        bench.robot.deaf = lambda heard: heard.name == "ENCODER"
    else:
        bench.robot.mute = lambda packet: isinstance(packet, p2os.Encoder)
    while len(questions(bench)) < before + 1:
        go_on(bench, 0.1)
    bench.run(SIP_CYCLE)
    bench.robot.deaf, bench.robot.mute = deaf, mute
    go_on(bench, ANSWERED_WITHIN + 0.1)
    assert counts(bench)[1] == 1
    go_on(bench, 3.0)
    assert counts(bench)[1] == 1


def test_a_stop_leaves_no_question_open_for_ever():
    bench = Bench().until_driving()
    go_on(bench, 1.0)
    bench.robot.deaf = lambda heard: heard.name == "ENCODER"
    go_on(bench, 0.5)
    bench.session.connected.drive.stop(bench.now)
    bench.run(ANSWERED_WITHIN + 0.1)
    assert counts(bench)[1] in (2, 3) and bench.session.connected.link_check.due == float("inf")


def test_a_robot_that_never_answers_is_left_in_peace_and_counts_as_nothing():
    robot = FakeRobot()
    robot.deaf = lambda heard: heard.name == "ENCODER"
    bench = Bench(robot).until_driving()
    go_on(bench, 10.0)
    assert TRIES < len(questions(bench)) <= TRIES + 2 and counts(bench) == (0, 0)


def test_a_line_that_carried_nothing_at_the_beginning_is_asked_about_again():
    bench = Bench()
    bench.robot.deaf = lambda heard: heard.name == "ENCODER"
    go_on(bench.until_driving(), 5.0)
    bench.robot.deaf = lambda heard: False
    go_on(bench, 10.0)
    asked, unanswered = counts(bench)
    assert asked > 20 and unanswered >= TRIES


@pytest.mark.parametrize("cycle, rates, every", [
    (20, (), EVERY), (100, (), EVERY), (250, (), 0.375), (100, (115200,), EVERY), (100, (9600,), 0.486)])
def test_it_asks_seldom_enough_for_a_slow_robot_and_a_slow_line(cycle, rates, every):
    """It asks once in a SIP cycle at most, because two questions in one cycle may get one answer. Answers take 3 % of
    the line at most, so that other packets have room.
    """
    robot = FakeRobot()
    robot.config = config(sip_cycle_ms=cycle)
    bench = Bench(robot, rates=rates).until_driving()
    bench.robot.heard.clear()
    for _ in range(1000):
        bench.drive(0.2, 0.0)
        bench.run(0.01)
    assert 10 / every * 0.85 < len(questions(bench)) <= 10 / every + 1


def test_a_robot_whose_first_answers_are_lost_counts_from_the_beginning():
    bench = Bench()
    bench.robot.deaf = lambda heard: heard.name == "ENCODER" and len(questions(bench)) <= 4
    go_on(bench.until_driving(), 4.0)
    asked, unanswered = counts(bench)
    assert unanswered == 4 and asked > 15


def test_a_robot_that_answers_for_ever_is_silenced_once_and_not_asked_again():
    robot = FakeRobot()
    robot.streams_encoders = True
    bench = Bench(robot).until_driving()
    go_on(bench, 10.0)
    told = [heard.value for heard in robot.heard if heard.name == "ENCODER"]
    assert told[-1] == 0 and told.count(0) == 1 and len(told) < 2 * TOO_MANY + 4
    came = len(received(bench))
    go_on(bench, 2.0)
    assert came == len(received(bench))
    silence = [write for at_once in bench.writes.values() for write in at_once if SILENCE in write]
    assert silence == [VEL_200 + RVEL_0 + SILENCE], "that does not go alone either"


def test_no_other_packet_stands_for_an_answer_or_is_kept_from_who_listens():
    bench = Bench().until_driving()
    go_on(bench, 1.0)
    bench.robot.deaf = lambda heard: heard.name == "ENCODER"
    for _ in range(20):
        bench.robot.send(p2os.IO((1,), (2,), (3,)))
        go_on(bench, 0.1)
    assert len(received(bench)) == 20
    bench.run(ANSWERED_WITHIN)
    assert counts(bench)[1] > 8


def test_whoever_runs_a_session_is_woken_when_an_answer_is_overdue():
    bench = Bench(pulse=0.0).until_driving()
    bench.robot.deaf = lambda heard: heard.name == "ENCODER"
    go_on(bench, 0.5)
    bench.session.connected.drive.stop(bench.now)
    bench.run(0.5)
    assert bench.session.wake_at == bench.session.connected.link_check.due < float("inf")


def test_one_that_did_not_hear_that_is_told_again():
    robot = FakeRobot()
    robot.streams_encoders = True
    robot.deaf = lambda heard: heard[1:] == ("ENCODER", 0) and robot.names().count("ENCODER") < 2 * TOO_MANY + 10
    bench = Bench(robot).until_driving()
    go_on(bench, 30.0)
    told = [heard.value for heard in robot.heard if heard.name == "ENCODER"]
    came = len(received(bench))
    go_on(bench, 2.0)
    assert told.count(0) > 1 and 1 not in told[told.index(0):] and came == len(received(bench))


def test_an_answer_that_nobody_asked_for_is_a_packet_like_any_other():
    bench = Bench().until_driving()
    go_on(bench, 1.0)
    bench.session.connected.drive.stop(bench.now)
    bench.run(1.0)
    bench.robot.send(p2os.Encoder(7, 8))
    bench.run(0.1)
    assert bench.event(PacketReceived).packet == p2os.Encoder(7, 8)


# Alone

def test_it_asks_again_as_soon_as_it_may_and_no_sooner():
    check = LinkCheck(SIP_CYCLE / 2, lambda count: 0.0)
    assert check.question(0.0) == (QUESTION,)
    assert check.question(0.99 * EVERY) == () and check.question(EVERY) == (QUESTION,)


def test_an_answer_that_takes_more_than_a_second_is_one():
    """On a slow line the robot sends its SIPs first."""
    check = LinkCheck(SIP_CYCLE, lambda count: 0.0)
    for second in range(0, 20, 2):
        check.question(second)
        check.tick(second + 1.4)
        assert check.saw_answer()
    assert (check.questions, check.unanswered) == (10, 0)


def test_what_is_lost_is_counted_in_time_while_a_newer_question_is_open():
    check = LinkCheck(SIP_CYCLE, lambda count: 0.0)
    check.question(0.0)
    assert check.saw_answer()
    check.question(1.0)     # this is lost
    check.question(2.0)
    assert check.questions == 1 and check.due == 1.0 + ANSWERED_WITHIN
    check.tick(check.due)
    assert (check.questions, check.unanswered) == (2, 1) and check.due == 2.0 + ANSWERED_WITHIN


def test_a_few_answers_that_nobody_asked_for_do_not_end_the_questions_and_ten_do():
    for count, what_goes in ((9, QUESTION), (10, SILENCE)):
        check = LinkCheck(SIP_CYCLE, lambda count: 0.0)
        assert not any([check.saw_answer() for _ in range(count)])
        assert check.question(0.0) == (what_goes,)


@given(st.lists(st.booleans(), min_size=1, max_size=60))
def test_it_counts_exactly_what_is_lost_where_answers_come_before_the_next_question(lost):
    check, now = LinkCheck(SIP_CYCLE, lambda count: 0.0), 0.0
    for is_lost in [False] + lost:
        assert check.question(now) == (QUESTION,)
        if not is_lost:
            assert check.saw_answer()
        now += EVERY + 1e-6
        check.tick(now)
    check.tick(now + ANSWERED_WITHIN)
    assert (check.questions, check.unanswered) == (len(lost) + 1, sum(lost)) and check.due == float("inf")


@pytest.mark.parametrize("late", [0.3, 0.7, 1.4])
def test_answers_that_are_late_count_as_lost_only_at_the_beginning(late):
    """Nobody can know which question an answer belongs to. So on a slow line the first answers count as lost, and later
    ones do not.
    """
    check, asked, now, answers_at = LinkCheck(SIP_CYCLE, lambda count: 0.0), 0, 0.0, []
    while now < 60.0:
        if check.question(now):
            asked += 1
            answers_at.append(now + late)
        while answers_at and answers_at[0] <= now:
            answers_at.pop(0)
            check.saw_answer()
        check.tick(now)
        now += 0.1
    assert late / 0.2 - 1 <= check.unanswered <= late / 0.2 + 1 and asked > 250

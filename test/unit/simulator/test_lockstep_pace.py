"""A pace in lockstep: when simulated time stands, when it goes on, and which answers are late."""

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.p2os import encode_command
from pioneer_control.simulator.line.lockstep import Lockstep
from pioneer_control.simulator.line.pace import Pace

MARK, VELOCITY, OPEN = encode_command("PULSE"), encode_command("VEL", 200), encode_command("OPEN")
SIP = bytes.fromhex("FAFB2E320000000000000000000082000000000600000400"
                    "4C0C08620301E10309E003110500F000820000000000009E41")
NEXT = 100000           # microseconds, of the next SIP


@pytest.fixture
def pace():
    """Return a pace in lockstep that waits 1 s, at the real time 10 s."""
    pace = Lockstep(1.0, 2.0, 0)
    assert pace.due_us(10.0, NEXT) == 0
    return pace


@pytest.fixture
def waiting(pace):
    """Return such a pace whose client has opened its session at 10 s."""
    pace.client_sent(MARK, False, 10.0)     # before a session it is SYNC0
    pace.client_sent(OPEN, True, 10.0)
    return pace


def test_time_stands_until_somebody_comes(pace):
    assert pace.rest(NEXT) is None and pace.due_us(1e6, NEXT) == 0 and pace.due_us(2e6, NEXT) == 0
    assert pace.late_answers == 0


def test_time_stands_after_open_until_the_mark(waiting):
    waiting.client_sent(VELOCITY, True, 10.3)
    assert waiting.due_us(10.5, NEXT) == 0 and waiting.rest(NEXT) == pytest.approx(0.5)
    waiting.client_sent(VELOCITY + MARK[:2], True, 10.6)
    assert waiting.due_us(10.6, NEXT) == 0
    waiting.client_sent(MARK[2:], True, 10.6)
    assert waiting.rest(NEXT) == 0.0 and waiting.due_us(10.6, NEXT) == NEXT


def test_time_goes_on_at_once_until_the_next_sip(waiting):
    waiting.client_sent(MARK, True, 10.1)
    assert waiting.due_us(10.1, 40000) == 40000, "something else is due before"
    waiting.client_got(encode_command("ENCODER", 1), 10.1)
    assert waiting.due_us(10.1, NEXT) == NEXT
    waiting.client_got(SIP[:20], 10.1)
    assert waiting.due_us(10.1, NEXT + 1) == NEXT + 1
    waiting.client_got(SIP[20:], 10.1)
    assert waiting.due_us(10.1, 2 * NEXT) == waiting.due_us(11.0, 2 * NEXT) == NEXT + 1 and waiting.late_answers == 0


def test_nobody_waits_for_the_answer_to_a_damaged_sip(waiting):
    waiting.client_sent(MARK, True, 10.1)
    waiting.client_got(SIP[:-1] + bytes([SIP[-1] ^ 1]), 10.1)
    assert waiting.due_us(10.1, NEXT) == NEXT


def test_without_an_answer_time_passes_at_its_pace_until_there_is_one(waiting):
    assert waiting.due_us(11.1, NEXT) == 0 and waiting.late_answers == 0, "it may have come meanwhile"
    assert waiting.due_us(11.1, NEXT) == 0 and waiting.late_answers == 1
    assert waiting.due_us(11.15, NEXT) == pytest.approx(NEXT, abs=1) and waiting.rest(2 * NEXT) == pytest.approx(0.05)
    waiting.client_got(SIP, 11.15)
    assert waiting.due_us(11.2, 2 * NEXT) == pytest.approx(2 * NEXT, abs=1), "it waits for no further answer"
    waiting.client_sent(MARK, True, 11.2)
    assert waiting.due_us(11.2, 3 * NEXT) == 3 * NEXT
    waiting.client_got(SIP, 11.2)
    assert waiting.due_us(12.1, 4 * NEXT) == 3 * NEXT and waiting.late_answers == 1


def test_an_answer_is_not_late_because_the_simulator_was_held_up(waiting):
    assert waiting.due_us(50.0, NEXT) == 0
    waiting.client_sent(MARK, True, 50.0)       # it had come long ago, and is read only now
    assert waiting.due_us(50.0, NEXT) == NEXT and waiting.late_answers == 0


def test_a_robot_that_falls_silent_is_not_hurried_for_ever(waiting):
    waiting.client_sent(MARK, True, 10.0)
    assert waiting.due_us(11.0, NEXT) == NEXT
    assert waiting.due_us(11.0, 2 * NEXT) == NEXT and waiting.due_us(11.05, 2 * NEXT) == pytest.approx(2 * NEXT, abs=1)
    assert waiting.late_answers == 0
    waiting.client_got(SIP, 11.05)
    assert waiting.due_us(11.5, 3 * NEXT) == pytest.approx(2 * NEXT, abs=1), "it waits again"


def test_a_handshake_that_gets_no_answer_lets_time_pass(pace):
    pace.client_sent(MARK, False, 20.0)
    pace.client_sent(MARK, False, 20.9)
    assert pace.due_us(21.8, NEXT) == pace.due_us(21.9, NEXT) == pace.due_us(21.9, NEXT) == 0
    assert pace.due_us(21.95, NEXT) == pytest.approx(NEXT, abs=1) and pace.late_answers == 0


def test_time_stands_when_the_session_has_ended(waiting):
    waiting.client_sent(MARK, True, 10.0)
    waiting.client_sent(encode_command("CLOSE"), False, 10.0)
    waiting.session_ended()
    assert waiting.due_us(1e6, NEXT) == waiting.due_us(2e6, NEXT) == 0
    assert waiting.rest(NEXT) is None and waiting.late_answers == 0


def test_a_pause_holds_it_too(waiting):
    waiting.client_sent(MARK, True, 10.0)
    waiting.paused = True
    assert waiting.due_us(10.1, NEXT) == 0 and waiting.rest(NEXT) is None
    waiting.paused = False
    assert waiting.rest(NEXT) == 0.0 and waiting.due_us(10.2, NEXT) == NEXT


@pytest.mark.parametrize("limit", [0.0, -1.0, 0.049, 3601.0, float("nan"), float("inf")])
def test_a_senseless_limit(limit):
    with pytest.raises(ParameterError, match="lockstep .* is not legal: give a number of seconds from 0.05 to 3600"):
        Lockstep(limit, 1.0, 0)


def test_another_pace_waits_for_nobody():
    pace = Pace(1.0, 0)
    pace.due_us(10.0)
    pace.client_sent(OPEN, True, 10.0)
    pace.client_got(SIP, 10.0)
    pace.session_ended()
    assert pace.due_us(10.1, 5 * NEXT) == pytest.approx(NEXT, abs=1) and pace.late_answers is None

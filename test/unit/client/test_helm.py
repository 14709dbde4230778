"""Who may command: priorities, time-outs, a person who never hands back by silence, and locks. Time is an argument."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pioneer_control.client.helm import Helm, HelmState, VelocityInput

PROGRAM, OTHER, PERSON = "cmd_vel", "cmd_wheels", "teleop/cmd_vel"
INPUTS = {PROGRAM: VelocityInput(10, 0.6), OTHER: VelocityInput(10, 0.6), PERSON: VelocityInput(100, 0.5, True)}


@pytest.fixture
def helm():
    return Helm(INPUTS)


def test_at_first_everybody_may_and_nobody_does(helm):
    assert [helm.obstacle(name, 0.0) for name in INPUTS] == [None, None, None]
    assert helm.state(0.0) == HelmState()
    assert helm.changes_at(0.0) == math.inf


def test_a_program_commands_until_its_time_out(helm):
    helm.command(PROGRAM, 1.0, "/wander")
    assert helm.state(1.59) == HelmState(PROGRAM, "/wander")
    assert helm.changes_at(1.2) == 1.6
    assert helm.state(1.6) == HelmState()


def test_of_two_programs_the_newest_counts_and_neither_is_refused(helm):
    helm.command(PROGRAM, 1.0, "/a")
    helm.command(OTHER, 1.1, "/b")
    assert helm.state(1.2).commander == OTHER
    helm.command(PROGRAM, 1.2, "/a")
    assert helm.state(1.3).commander == PROGRAM
    assert helm.obstacle(OTHER, 1.3) is helm.obstacle(PROGRAM, 1.3) is None


def test_a_person_takes_over_at_once(helm):
    helm.command(PROGRAM, 1.0, "/wander")
    assert helm.takes_over(PERSON, 1.1)
    assert helm.obstacle(PERSON, 1.1) is None
    helm.command(PERSON, 1.1, "/joystick")
    assert helm.state(1.1) == HelmState(PERSON, "/joystick", PERSON)
    assert helm.obstacle(PROGRAM, 1.1) == helm.obstacle(OTHER, 1.1) == PERSON


def test_silence_never_hands_back(helm):
    helm.command(PERSON, 1.0, "/joystick")
    for later in (1.6, 100.0, 1e9):
        assert helm.state(later) == HelmState("", "/joystick", PERSON)
        assert helm.obstacle(PROGRAM, later) == PERSON
    helm.release()
    assert helm.obstacle(PROGRAM, 1.0) is None
    assert helm.state(1.0) == HelmState()


def test_a_person_who_drives_on_has_the_helm_again_after_a_release(helm):
    helm.command(PERSON, 1.0)
    helm.release()
    helm.command(PERSON, 1.1)
    assert helm.obstacle(PROGRAM, 9.0) == PERSON


def test_an_input_that_does_not_keep_the_helm_hands_back_by_silence():
    """As twist_mux does for all its inputs."""
    helm = Helm({"low": VelocityInput(1, 0.5), "high": VelocityInput(2, 0.3)})
    helm.command("high", 1.0)
    assert helm.obstacle("low", 1.29) == "high"
    assert helm.obstacle("low", 1.3) is None


def test_a_lock_is_in_everybodys_way_and_is_named(helm):
    helm.command(PERSON, 1.0, "/joystick")
    helm.lock("stop_all")
    assert [helm.obstacle(name, 1.0) for name in INPUTS] == ["stop_all"] * 3
    assert helm.state(1.0) == HelmState("", "/joystick", PERSON, ("stop_all",))


def test_what_was_commanded_before_a_lock_counts_no_more_after_it(helm):
    helm.command(PROGRAM, 1.0, "/wander")
    helm.lock("stop_all")
    helm.unlock("stop_all")
    assert helm.state(1.1) == HelmState()
    assert helm.obstacle(PROGRAM, 1.1) is None


def test_who_had_the_helm_before_a_lock_has_it_after_it(helm):
    helm.command(PERSON, 1.0, "/joystick")
    helm.lock("stop_all")
    helm.unlock("stop_all")
    assert helm.state(1.1) == HelmState("", "/joystick", PERSON)
    assert helm.obstacle(PROGRAM, 1.1) == PERSON


def test_each_lock_is_taken_away_by_its_own_name(helm):
    helm.lock("b")
    helm.lock("a")
    helm.unlock("a")
    assert helm.obstacle(PERSON, 0.0) == "b"
    helm.unlock("never set")
    assert helm.state(0.0).locks == ("b",)


def test_a_time_out_can_change(helm):
    helm.command(PROGRAM, 1.0)
    helm.set_timeout(PROGRAM, 0.1)
    assert helm.timeout(PROGRAM) == 0.1 and helm.timeout(OTHER) == 0.6
    assert helm.state(1.2).commander == ""


STEPS = st.lists(st.tuples(
    st.floats(0.0, 1.0), st.sampled_from(["command", "release", "lock", "unlock"]), st.sampled_from(list(INPUTS))))


@given(STEPS)
def test_whatever_happens_nobody_below_the_holder_and_nobody_under_a_lock_may_command(steps):
    helm, now, holder, locked = Helm(INPUTS), 0.0, "", False
    for pause, what, name in steps:
        now += pause
        if what == "command" and helm.obstacle(name, now) is None:
            helm.command(name, now)
            holder = PERSON if name == PERSON else holder
        elif what == "release":
            helm.release()
            holder = ""
        elif what != "command":
            (helm.lock if what == "lock" else helm.unlock)("stop_all")
            locked = what == "lock"
        state = helm.state(now)
        assert state.holder == holder and bool(state.locks) == locked
        assert (helm.obstacle(PROGRAM, now) is None) == (not holder and not locked)
        assert (helm.obstacle(PERSON, now) is None) == (not locked)
        assert not (locked and state.commander) and not (holder and state.commander in (PROGRAM, OTHER))

"""The meaning of the gripper's reports."""

import pytest

from pioneer_control.message_values import GripStatus, LiftStatus
from pioneer_control.tutorial.pick import CLOSE, LOWER, OPEN, PICK, RAISE, Outcome, holds, judge
from pioneer_control.tutorial.snapshot import Grip, Lift

DOWN, UP = Lift(LiftStatus.IDLE, 0, 0.0), Lift(LiftStatus.IDLE, 0, 1.0)
GOING_UP = Lift(LiftStatus.MOVING, 1, 0.0)
NOWHERE = Lift(LiftStatus.STALLED, 0, 0.0)


def paddles(state, *, inner=False, outer=False, left=False, right=False, direction=0):
    return Grip(state, direction, inner, outer, left, right)


OPENED = paddles(GripStatus.OPEN)
CLOSED_ON_NOTHING = paddles(GripStatus.CLOSED)
CLOSED_ON_A_CAN = paddles(GripStatus.CLOSED, inner=True, left=True, right=True)
CLOSING = paddles(GripStatus.MOVING, direction=-1)


@pytest.mark.parametrize("step, grip, lift", [
    (LOWER, OPENED, DOWN), (OPEN, OPENED, UP), (CLOSE, CLOSED_ON_NOTHING, DOWN), (RAISE, OPENED, UP),
    (CLOSE, CLOSED_ON_A_CAN, DOWN)])
def test_where_it_is_already_nothing_is_commanded(step, grip, lift):
    assert judge(step, grip, lift, commanded=False) is Outcome.ALREADY_THERE


@pytest.mark.parametrize("step, grip, lift", [
    (LOWER, OPENED, UP), (LOWER, OPENED, GOING_UP), (LOWER, OPENED, NOWHERE), (RAISE, OPENED, GOING_UP),
    (RAISE, OPENED, NOWHERE), (OPEN, CLOSING, DOWN), (OPEN, paddles(GripStatus.BETWEEN), DOWN),
    (OPEN, paddles(GripStatus.ERROR), DOWN), (CLOSE, CLOSING, DOWN),
    (CLOSE, paddles(GripStatus.MOVING, left=True, right=True, inner=True), DOWN)])
@pytest.mark.parametrize("commanded", [False, True])
def test_elsewhere_and_on_the_way_a_step_goes_on(step, grip, lift, commanded):
    """Row 24: the original slept five seconds, and took a contact for "open"."""
    assert judge(step, grip, lift, commanded) is None


def test_a_close_tells_an_object_from_nothing():
    assert judge(CLOSE, CLOSED_ON_A_CAN, DOWN, commanded=True) is Outcome.GRIPPED
    assert judge(CLOSE, CLOSED_ON_NOTHING, DOWN, commanded=True) is Outcome.DONE


def test_other_steps_are_done_when_they_are_there():
    assert judge(RAISE, CLOSED_ON_A_CAN, UP, commanded=True) is Outcome.DONE


@pytest.mark.parametrize("step", PICK)
def test_a_robot_without_a_gripper_says_so(step):
    assert judge(step, None, None, commanded=False) is Outcome.NO_GRIPPER
    assert not Outcome.NO_GRIPPER.succeeded and not Outcome.TIMED_OUT.succeeded


@pytest.mark.parametrize("held, grip", [
    (True, CLOSED_ON_A_CAN),
    (True, paddles(GripStatus.CLOSED, outer=True, left=True, right=True)),
    (False, CLOSED_ON_NOTHING),
    (False, paddles(GripStatus.CLOSED, left=True, right=True)),
    (False, paddles(GripStatus.CLOSED, inner=True, outer=True)),
    (False, paddles(GripStatus.CLOSED, inner=True, left=True)),
    (False, paddles(GripStatus.CLOSED, inner=True, right=True)),
    (False, paddles(GripStatus.MOVING, inner=True, left=True, right=True)),
    (False, paddles(GripStatus.OPEN, inner=True, left=True, right=True)),
    (False, None),
])
def test_held_is_closed_felt_by_both_paddles_and_seen_by_a_beam(held, grip):
    """Row 26: the original did not report whether it held anything."""
    assert holds(grip) is held


def test_the_pick_is_the_tutorials():
    assert PICK == (LOWER, OPEN, CLOSE, RAISE)


@pytest.mark.parametrize("step, grip, lift", [(LOWER, 3, 5), (OPEN, 1, 6), (CLOSE, 2, 6), (RAISE, 3, 4)])
def test_each_step_commands_one_part_and_stops_the_other(step, grip, lift):
    assert (step.grip, step.lift) == (grip, lift)

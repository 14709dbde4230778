"""The meaning of values in messages."""

import math

import pytest

from pioneer_control.message_values import GripCommand, LiftCommand, LiftStatus, heading_of, quaternion_of
from pioneer_control.p2os import GripperCommand


@pytest.mark.parametrize("degrees", [0, 1, -1, 90, -90, 135, 179.9, -179.9, 180, 270, 361])
def test_a_heading_is_right_whichever_way_it_turns(degrees):
    """Row 14 of the tutorial's corrections: the original gave a message to a function that needs a sequence."""
    difference = heading_of(*quaternion_of(math.radians(degrees))) - math.radians(degrees)
    assert math.remainder(difference, 2 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_headings_jump_from_pi_to_minus_pi_and_nowhere_else():
    before, after = (math.radians(degrees) / 2 for degrees in (179.9, 180.1))
    assert heading_of(0, 0, math.sin(before), math.cos(before)) == pytest.approx(math.radians(179.9))
    assert heading_of(0, 0, math.sin(after), math.cos(after)) == pytest.approx(math.radians(-179.9))


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0)])
def test_a_robot_that_tilts_has_not_turned(axis):
    sine, cosine = math.sin(0.1), math.cos(0.1)
    assert heading_of(*(sine * part for part in axis), cosine) == pytest.approx(0.0)
    assert quaternion_of(math.pi / 2) == pytest.approx((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))


def test_commands_are_the_robots_own_and_no_status():
    """Row 25 of the tutorial's corrections: the original used 1 to 6 with one meaning for commands and another for
    status.
    """
    assert [int(each) for each in GripCommand] == [
        GripperCommand.OPEN, GripperCommand.CLOSE, GripperCommand.STOP,
        GripperCommand.STORE, GripperCommand.DEPLOY, GripperCommand.HALT, GripperCommand.PRESSURE]
    assert [int(each) for each in LiftCommand] == [
        GripperCommand.LIFT_UP, GripperCommand.LIFT_DOWN, GripperCommand.LIFT_STOP, GripperCommand.CARRY]
    assert not set(map(int, LiftCommand)) & set(map(int, LiftStatus))

"""Which incoming messages are obeyed, and which are refused with what words."""

import math

import pytest
from geometry_msgs.msg import Twist, Vector3

from pioneer_control.driver.commands import check_twist, gripper_commands, is_replayed, motors_wanted
from pioneer_control.errors import UsageError
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState
from pioneer_control.p2os import GripperCommand


def gripper(grip, lift):
    return GripperState(GripState(state=grip), LiftState(state=lift))


@pytest.mark.parametrize(
    "grip, lift, expected",
    [
        (1, 0, [GripperCommand.OPEN]),
        (2, 6, [GripperCommand.CLOSE, GripperCommand.LIFT_STOP]),
        (3, 4, [GripperCommand.STOP, GripperCommand.LIFT_UP]),
        (0, 5, [GripperCommand.LIFT_DOWN]),
        (0, 0, []),
    ],
)
def test_gripper_numbers_become_commands_paddles_first(grip, lift, expected):
    assert gripper_commands(gripper(grip, lift)) == expected


@pytest.mark.parametrize("grip, lift, says", [(1, 1, "lift.state 1 is a status"), (2, 2, "status"), (0, 3, "status"),
                                              (4, 4, "grip.state is 4"), (257, 0, "grip.state is 257"), (16, 0, "grip.state is 16"),
                                              (1, 7, "lift.state is 7"), (0, -4, "lift.state is -4")])
def test_gripper_numbers_that_mean_nothing_refuse_the_whole_message(grip, lift, says):
    with pytest.raises(UsageError, match=says):
        gripper_commands(gripper(grip, lift))


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("part", ["linear", "angular"])
@pytest.mark.parametrize("axis", "xyz")
def test_a_velocity_that_is_not_finite_is_refused_by_name(part, axis, number):
    twist = Twist()
    setattr(getattr(twist, part), axis, number)
    with pytest.raises(UsageError, match=r"%s\.%s is %s" % (part, axis, number)):
        check_twist(twist)


def test_a_finite_velocity_passes():
    check_twist(Twist(Vector3(65.6, 0, 0), Vector3(0, 0, -9)))


def test_motor_states_are_one_and_zero():
    assert motors_wanted(MotorState(1)) is True and motors_wanted(MotorState(0)) is False
    for state in (2, -1, 256):
        with pytest.raises(UsageError, match="state is %d" % state):
            motors_wanted(MotorState(state))


@pytest.mark.parametrize("caller, replayed", [("/play_1795", True), ("/pioneer/play_1795", True), ("/player", False), ("/play_ground/teleop", False), ("", False)])
def test_a_replayed_message_is_known_by_its_caller(caller, replayed):
    message = Twist()
    message._connection_header = {"callerid": caller}
    assert is_replayed(message) is replayed


def test_a_message_without_a_connection_is_live():
    assert not is_replayed(Twist())

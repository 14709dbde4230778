"""Which incoming messages the driver obeys, and how it refuses the others."""

import math

import pytest
from geometry_msgs.msg import Twist, Vector3

from pioneer_control.driver.commands import gripper_orders, motors_wanted
from pioneer_control.driver.requests import check_finite
from pioneer_control.driver.senders import is_player
from pioneer_control.errors import UsageError
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState, WheelVelocities
from pioneer_control.p2os import GripperCommand


def gripper(grip, lift, grip_dir=0, lift_dir=0):
    return GripperState(GripState(state=grip, dir=grip_dir), LiftState(state=lift, dir=lift_dir))


@pytest.mark.parametrize(
    "grip, lift, expected",
    [
        (1, 0, [GripperCommand.OPEN]),
        (2, 6, [GripperCommand.CLOSE, GripperCommand.LIFT_STOP]),
        (3, 4, [GripperCommand.STOP, GripperCommand.LIFT_UP]),
        (0, 5, [GripperCommand.LIFT_DOWN]),
        (0, 0, []),
        (7, 0, [GripperCommand.STORE]),
        (8, 0, [GripperCommand.DEPLOY]),
        (15, 0, [GripperCommand.HALT]),
    ],
)
def test_gripper_numbers_become_commands_paddles_first(grip, lift, expected):
    """p2os ignores dir for commands without a value, and so do we."""
    orders = [(command, None) for command in expected]
    assert gripper_orders(gripper(grip, lift)) == gripper_orders(gripper(grip, lift, 1, -1)) == orders


@pytest.mark.parametrize("message, expected", [
    (gripper(16, 0, 10), [(GripperCommand.PRESSURE, 10)]),
    (gripper(0, 17, 0, -50), [(GripperCommand.CARRY, -50)]),
    (gripper(16, 17, 100, 255), [(GripperCommand.PRESSURE, 100), (GripperCommand.CARRY, 255)]),
    (gripper(2, 17, 0, 1), [(GripperCommand.CLOSE, None), (GripperCommand.CARRY, 1)]),
])
def test_pressure_and_carry_take_their_value_from_dir(message, expected):
    assert gripper_orders(message) == expected


@pytest.mark.parametrize("message, says", [
    (gripper(16, 0), r"grip.state 16 needs grip.dir in 1\.\.100 .* it is 0"),
    (gripper(16, 0, -1), "it is -1"), (gripper(16, 0, 101), "it is 101"),
    (gripper(0, 17), r"lift.state 17 needs lift.dir in -255\.\.255 .* it is 0"),
    (gripper(1, 17, 0, 256), "it is 256"), (gripper(1, 17, 0, -256), "it is -256"),
    (gripper(7, 4), "grip.state 7 moves the lift too"), (gripper(15, 17, 0, 5), "lift.state must be 0, not 17"),
])
def test_a_value_that_means_nothing_refuses_the_whole_message(message, says):
    with pytest.raises(UsageError, match=says):
        gripper_orders(message)


@pytest.mark.parametrize("grip, lift, says", [
    (1, 1, "lift.state 1 is a status"), (2, 2, "status"), (0, 3, "status"),
    (4, 4, "grip.state is 4"), (9, 0, "grip.state is 9"), (17, 0, "grip.state is 17"), (257, 0, "grip.state is 257"),
    (0, -4, "lift.state is -4"), (1, 7, "lift.state is 7"), (1, 16, "lift.state is 16"),
])
def test_gripper_numbers_that_mean_nothing_refuse_the_whole_message(grip, lift, says):
    with pytest.raises(UsageError, match=says):
        gripper_orders(gripper(grip, lift))


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("part", ["linear", "angular"])
@pytest.mark.parametrize("axis", "xyz")
def test_a_velocity_that_is_not_finite_is_refused_by_name(part, axis, number):
    twist = Twist()
    setattr(getattr(twist, part), axis, number)
    with pytest.raises(UsageError, match=r"%s\.%s is %s" % (part, axis, number)):
        check_finite("cmd_vel", twist)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_wheel_velocity_that_is_not_finite_is_refused_by_name(side, number):
    with pytest.raises(UsageError, match="cmd_wheels refused: %s is %s" % (side, number)):
        check_finite("cmd_wheels", WheelVelocities(**{side: number}))


def test_a_finite_velocity_passes():
    check_finite("cmd_wheels", WheelVelocities(-65.6, 0.1))
    check_finite("cmd_vel", Twist(Vector3(65.6, 0, 0), Vector3(0, 0, -9)))


def test_motor_states_are_one_and_zero():
    assert motors_wanted(MotorState(1)) is True and motors_wanted(MotorState(0)) is False
    for state in (2, -1, 256):
        with pytest.raises(UsageError, match="state is %d" % state):
            motors_wanted(MotorState(state))


@pytest.mark.parametrize("caller, replayed", [
    ("/play_1795", True), ("/pioneer/play_1795", True), ("/player", False),
    ("/play_ground/teleop", False), ("", False)])
def test_a_replayed_message_is_known_by_its_caller(caller, replayed):
    assert is_player(caller) is replayed

"""State to messages: every field, by hand-made states with known numbers."""

import dataclasses
import math

import pytest
import rospy

from pioneer_control import client
from pioneer_control.client.identity import RobotIdentity
from pioneer_control.driver import conversions
from pioneer_control.p2os import Flags
from pioneer_control.robots import find_model

STAMP = rospy.Time(12, 340000000)
STATE = client.RobotState(
    time=100.0, sent_time=99.96, x=1.5, y=-0.25, heading=math.pi / 2, linear=0.2, angular=-0.1, wheel_velocities=(0.22, 0.18),
    wheel_angles=(3.0, -2.0), x_counts=1500, y_counts=-250, motors_enabled=True,
    stop_button=False, left_stall=False, right_stall=False, front_bumpers=(), rear_bumpers=(), battery_voltage=12.8,
    sonar=(client.SonarRange(1.5, 99.9), client.SonarRange(5.0, 99.0), client.SonarRange(0.8, 97.9), None, client.SonarRange(5.4, 100.0)),
    sonar_enabled=True, gripper=None, digital_in=0xF0, digital_out=0, analog_port=5, analog_voltage=2.5, flags=Flags(7), fault_flags=None,
    compass=None, charge_state=None, temperature=None, state_of_charge=None,
)
READING = client.GripperReading(*[False] * 12)


def gripper_message(reporter=None, **true):
    return (reporter or conversions.GripperReporter()).message(dataclasses.replace(READING, **true))


def test_odometry_carries_pose_twist_frames_and_stamp():
    message = conversions.odometry(STATE, STAMP, "two/odom", "two/base_link")
    assert (message.header.stamp, message.header.frame_id, message.child_frame_id) == (STAMP, "two/odom", "two/base_link")
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    assert (position.x, position.y, position.z) == (1.5, -0.25, 0.0)
    assert (orientation.x, orientation.y) == (0.0, 0.0)
    assert (orientation.z, orientation.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (0.2, -0.1)


def test_a_standing_robot_is_surer_of_its_speed_than_a_moving_one():
    still = dataclasses.replace(STATE, linear=0.0, angular=0.0)
    moving, standing = (conversions.odometry(state, STAMP, "odom", "base_link").twist.covariance for state in (STATE, still))
    assert len(moving) == 36 and all(moving[i] > 0 for i in (0, 7, 35)) and standing[0] < moving[0] and standing[35] < moving[35]


def test_the_transform_says_what_the_pose_says():
    pose = conversions.odometry(STATE, STAMP, "odom", "base_link")
    message = conversions.transform(pose)
    assert (message.header.stamp, message.header.frame_id, message.child_frame_id) == (STAMP, "odom", "base_link")
    assert (message.transform.translation.x, message.transform.translation.y) == (1.5, -0.25)
    assert message.transform.rotation == pose.pose.pose.orientation


def test_sonar_ranges_expire_to_zero_and_end_at_no_echo():
    message = conversions.sonar_array(STATE, STAMP, "base_link")
    assert message.ranges == [1.5, 5.0, 0.0, 0.0, 5.0], "heard, no echo, too old, never heard, beyond"
    assert (message.ranges_count, message.header.stamp, message.header.frame_id) == (5, STAMP, "base_link")


@pytest.mark.parametrize(
    "true, state, direction",
    [
        ({}, 0, 0),
        ({"paddles_open": True}, 1, 0),
        ({"paddles_closed": True}, 2, 0),
        ({"paddles_moving": True}, 3, 0),
        ({"paddles_moving": True, "paddles_open": True}, 3, 1),
        ({"paddles_moving": True, "paddles_closed": True}, 3, -1),
        ({"paddles_error": True}, 4, 0),
    ],
)
def test_grip_state(true, state, direction):
    message = gripper_message(**true)
    assert (message.grip.state, message.grip.dir) == (state, direction)


def test_beams_and_contacts():
    message = gripper_message(inner_beam=True, left_contact=True).grip
    assert (message.inner_beam, message.outer_beam, message.left_contact, message.right_contact) == (True, False, True, False)


def test_the_lift_reports_its_last_end_while_it_moves():
    reporter = conversions.GripperReporter()
    seen = []
    for true in ({}, {"lift_up": True}, {"lift_moving": True, "lift_down": True}, {"lift_moving": True}, {"lift_down": True}, {"lift_moving": True, "lift_up": True}):
        lift = gripper_message(reporter, **true).lift
        seen.append((lift.state, lift.dir, lift.position))
    assert seen == [(3, 0, 0.0), (1, 0, 1.0), (2, -1, 1.0), (2, 0, 1.0), (1, 0, 0.0), (2, 1, 0.0)]


def test_motors_battery_and_inputs():
    assert conversions.motor_state(STATE).state == 1
    assert conversions.motor_state(dataclasses.replace(STATE, motors_enabled=False)).state == 0
    battery = conversions.battery_state(STATE, STAMP, "base_link")
    assert battery.voltage == pytest.approx(12.8) and battery.header.frame_id == "base_link"
    inputs, analog = conversions.digital_inputs(STATE), conversions.analog_input(STATE)
    assert (inputs.count, inputs.bits) == (8, 0xF0) and (analog.voltages_count, list(analog.voltages)) == (1, [2.5])


def test_what_firmware_does_not_report_is_not_made_up():
    older = dataclasses.replace(STATE, digital_in=None, analog_voltage=None)
    assert conversions.digital_inputs(older) is None and conversions.analog_input(older) is None


def test_robot_info_describes_the_robot():
    identity = RobotIdentity("Fred", "Pioneer", "p3dx-sh", None, None, find_model("p3dx-sh").with_arrays(True, False), True, 0.5, 1.0)
    message = conversions.robot_info(identity, STAMP, "base_link")
    assert (message.name, message.type, message.subtype, message.firmware) == ("Fred", "Pioneer", "p3dx-sh", "")
    assert (message.max_linear, message.max_angular, message.has_gripper) == (0.5, 1.0, True)
    assert message.sonar_numbers == list(range(8)) and message.sonar_poses[1].x == pytest.approx(0.114)
    assert math.degrees(message.sonar_poses[1].theta) == pytest.approx(50)
    assert max(point.x for point in message.footprint.points) == pytest.approx(0.35)

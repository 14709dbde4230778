"""States to messages. Every field is checked with states made by hand."""

import dataclasses
import math

import pytest
from geometry_msgs.msg import (
    Point, Pose, PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist, TwistWithCovariance, Vector3)
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from pioneer_control.driver import conversions, prompt
from pioneer_control.driver.parameters import DriverParameters
from pioneer_control.msg import SonarArray
from pioneer_control.p2os import ChargeState, Flags
from sensor_msgs.msg import BatteryState as Battery

from robot_reports import (
    IO, OLD, READING, STALLED, STAMP, STATE, identity_of, odometry_of, packet_of, received, state_of, written)


def gripper_message(reporter=None, **true):
    reading, reporter = dataclasses.replace(READING, **true), reporter or conversions.GripperReporter()
    reporter.saw(reading)
    return reporter.message(reading)


def test_odometry_carries_pose_twist_frames_and_stamp():
    message = odometry_of(STATE, STAMP, "two/odom", "two/base_link")
    assert message.header.stamp == STAMP
    assert (message.header.frame_id, message.child_frame_id) == ("two/odom", "two/base_link")
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    assert (position.x, position.y, position.z) == (1.5, -0.25, 0.0)
    assert (orientation.x, orientation.y) == (0.0, 0.0)
    assert (orientation.z, orientation.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (0.2, -0.1)


STILL = dataclasses.replace(STATE, linear=0.0, angular=0.0)


def test_a_standing_robot_is_surer_of_its_speed_than_a_moving_one():
    moving, standing = (odometry_of(state).twist.covariance for state in (STATE, STILL))
    assert len(moving) == 36 and all(moving[i] > 0 for i in (0, 7, 35))
    assert standing[0] < moving[0] and standing[35] < moving[35]


@pytest.mark.parametrize("what", ["pose", "twist"])
@pytest.mark.parametrize("how, state", [
    ("moving", STATE), ("still", STILL), ("moving", dataclasses.replace(STILL, angular=0.01))])
def test_each_covariance_parameter_is_the_diagonal_of_its_message(what, how, state):
    parameters = DriverParameters(**{"%s_covariance_%s" % (what, how): (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)})
    message = odometry_of(state, parameters=parameters)
    covariance = getattr(message, what).covariance
    assert [covariance[7 * axis] for axis in range(6)] == [1, 2, 3, 4, 5, 6]
    assert sum(covariance) == 21 and len(covariance) == 36
    other = message.twist if what == "pose" else message.pose
    assert other.covariance[0] < 0.01, "the other parameters are untouched"


def test_the_transform_says_what_the_pose_says():
    pose = odometry_of(STATE)
    message, = received(conversions.transform(STATE, STAMP, "odom", "base_link"), TFMessage).transforms
    assert (message.header.stamp, message.header.frame_id, message.child_frame_id) == (STAMP, "odom", "base_link")
    translation, position = message.transform.translation, pose.pose.pose.position
    assert (translation.x, translation.y, translation.z) == (position.x, position.y, position.z)
    assert message.transform.rotation == pose.pose.pose.orientation


@pytest.mark.parametrize("count", [0, 3, 5])
def test_the_sonar_has_a_range_for_each_transducer(count):
    plain = SonarArray(Header(stamp=STAMP, frame_id="zwei/ödom"), count, [1.5, 5.0, 0.0, 0.0, 5.0][:count])
    state = dataclasses.replace(STATE, sonar=STATE.sonar[:count])
    assert written(conversions.sonar(state, STAMP, "zwei/ödom"), 7) == written(plain, 7)


def test_a_pose_is_written_as_the_message_that_it_stands_for():
    parameters = DriverParameters(pose_covariance_moving=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    message = prompt.PoseMessage("zwei/ödom", "zwei/base_link", conversions.covariances(parameters))
    for heading in (-3.0, 0.0, 1.0):
        state = dataclasses.replace(STATE, heading=heading)
        place = Pose(Point(1.5, -0.25, 0.0), Quaternion(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2)))
        header, child = Header(stamp=STAMP, frame_id="zwei/ödom"), "zwei/base_link"
        pose = PoseWithCovariance(place, conversions.diagonal((1.0, 2.0, 3.0, 4.0, 5.0, 6.0)))
        speed = Twist(Vector3(0.2, 0.0, 0.0), Vector3(0.0, 0.0, -0.1))
        twist = TwistWithCovariance(speed, conversions.diagonal(parameters.twist_covariance_moving))
        plain = Odometry(header, child, pose, twist)
        assert written(message.of(state, STAMP), 7) == written(plain, 7)
        header.seq = 0      # nobody counts what is inside
        plain = TFMessage([TransformStamped(header, child, Transform(Vector3(1.5, -0.25, 0.0), place.orientation))])
        assert written(conversions.transform(state, STAMP, "zwei/ödom", "zwei/base_link"), 7) == written(plain, 7)


def test_joint_states_of_the_wheels():
    message = conversions.joint_states(STATE, STAMP, 0.1)
    assert (message.header.stamp, message.name) == (STAMP, ["left_wheel_joint", "right_wheel_joint"])
    assert message.position == [3.0, -2.0] and message.velocity == pytest.approx([2.2, 1.8]) and message.effort == []


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
    assert (message.inner_beam, message.outer_beam) == (True, False)
    assert (message.left_contact, message.right_contact) == (True, False)


@pytest.mark.parametrize("broken, expected", [(1, (True, False)), (0, (False, True))])
def test_the_parameter_beam_polarity_says_which_beam_is_broken(broken, expected):
    reporter = conversions.GripperReporter(DriverParameters(beam_polarity=broken).beam_polarity)
    message = gripper_message(reporter, inner_beam=True, left_contact=True).grip
    assert (message.inner_beam, message.outer_beam) == expected
    assert (message.left_contact, message.right_contact) == (True, False), "contacts have no polarity"


def test_an_end_of_the_lift_is_remembered_though_nobody_listened():
    reporter = conversions.GripperReporter()
    reporter.saw(dataclasses.replace(READING, lift_up=True))
    assert gripper_message(reporter, lift_moving=True).lift.position == 1.0


def test_the_lift_reports_its_last_end_while_it_moves():
    reporter = conversions.GripperReporter()
    seen = []
    one_after_another = [
        (), ("lift_up",), ("lift_moving", "lift_down"), ("lift_moving",), ("lift_down",), ("lift_moving", "lift_up")]
    for true in one_after_another:
        lift = gripper_message(reporter, **dict.fromkeys(true, True)).lift
        seen.append((lift.state, lift.dir, lift.position))
    assert seen == [(3, 0, 0.0), (1, 0, 1.0), (2, -1, 1.0), (2, 0, 1.0), (1, 0, 0.0), (2, 1, 0.0)]


@pytest.mark.parametrize(
    "charge_state, flags, status",
    [
        (None, 0, Battery.POWER_SUPPLY_STATUS_UNKNOWN),
        (ChargeState.UNKNOWN, 0, Battery.POWER_SUPPLY_STATUS_UNKNOWN),
        (77, 0, Battery.POWER_SUPPLY_STATUS_UNKNOWN),
        (ChargeState.NOT_CHARGING, 0, Battery.POWER_SUPPLY_STATUS_DISCHARGING),
        (ChargeState.NOT_CHARGING, Flags.CHARGER_POWER, Battery.POWER_SUPPLY_STATUS_NOT_CHARGING),
        (ChargeState.BULK, 0, Battery.POWER_SUPPLY_STATUS_CHARGING),
        (ChargeState.OVERCHARGE, Flags.CHARGER_POWER, Battery.POWER_SUPPLY_STATUS_CHARGING),
        (ChargeState.BALANCE, 0, Battery.POWER_SUPPLY_STATUS_CHARGING),
        (ChargeState.FLOAT, Flags.CHARGER_POWER, Battery.POWER_SUPPLY_STATUS_FULL),
    ],
)
def test_battery_says_what_the_charger_does(charge_state, flags, status):
    state = dataclasses.replace(STATE, charge_state=charge_state, flags=Flags(flags))
    assert conversions.battery(state, STAMP, "base_link").power_supply_status == status


def test_battery_of_a_24_v_robot_on_its_charger():
    message = conversions.battery(state_of(STALLED, identity_of("powerbot-sh")), STAMP, "base_link")
    assert message.voltage == pytest.approx(25.3)
    assert message.power_supply_status == Battery.POWER_SUPPLY_STATUS_CHARGING
    assert message.present and (message.header.stamp, message.header.frame_id) == (STAMP, "base_link")


def test_battery_makes_nothing_up():
    message = conversions.battery(state_of(OLD, identity_of("p2dx")), STAMP, "base_link")
    assert message.voltage == pytest.approx(13.0) and message.power_supply_status == Battery.POWER_SUPPLY_STATUS_UNKNOWN
    nothing = (
        message.percentage, message.current, message.charge, message.capacity, message.design_capacity,
        message.temperature)
    assert all(map(math.isnan, nothing))
    assert (message.power_supply_health, message.power_supply_technology, list(message.cell_voltage)) == (0, 0, [])
    assert conversions.battery(dataclasses.replace(STATE, state_of_charge=0.87), STAMP, "base_link").percentage == 0.87


@pytest.mark.parametrize("analog, volts", [
    ((0, 512, 1023, 2047, 300), (0.0, 1.2506, 2.4988, 5.0, 0.7328)),        # AROS: 2047 is 5 V
    ((0, 512, 1023) + (0,) * 6, (0.0, 2.5024, 5.0) + (0.0,) * 6),           # ARCOS: 1023 is 5 V
    ((), ()),
])
def test_ports_have_all_that_an_iopac_has(analog, volts):
    packet = packet_of(IO)
    assert packet.analog == (0, 512, 1023, 2047, 300)
    message = conversions.ports(dataclasses.replace(packet, analog=analog), STAMP, "base_link")
    assert (list(message.digital_in), list(message.digital_out)) == ([0xF0, 0, 0, 0x0F], [5])
    assert list(message.analog) == pytest.approx(volts, abs=1e-4) and message.header.stamp == STAMP


def test_a_gyro_tells_its_rate_and_nothing_else():
    message = conversions.turn_rate(-0.5, STAMP, "base_link")
    assert (message.angular_velocity.x, message.angular_velocity.y, message.angular_velocity.z) == (0.0, 0.0, -0.5)
    assert (message.orientation_covariance[0], message.linear_acceleration_covariance[0]) == (-1, -1)
    assert message.angular_velocity_covariance[0] > 1e5 > message.angular_velocity_covariance[8] > 0
    assert (message.header.stamp, message.header.frame_id) == (STAMP, "base_link")


@pytest.mark.parametrize("clockwise_from_north, from_east", [(0, 90), (90, 0), (180, -90), (270, 180), (358, 92)])
def test_a_compass_becomes_a_heading_by_rep_103(clockwise_from_north, from_east):
    state = dataclasses.replace(STATE, compass=math.radians(clockwise_from_north))
    message = conversions.compass(state, STAMP, "base_link")
    heading = 2 * math.atan2(message.orientation.z, message.orientation.w)
    assert math.remainder(heading - math.radians(from_east), 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert message.orientation_covariance[0] > 1e5 > message.orientation_covariance[8] > 0
    assert (message.angular_velocity_covariance[0], message.linear_acceleration_covariance[0]) == (-1, -1)


def test_robot_info_describes_the_robot():
    identity = dataclasses.replace(identity_of(name="Fred", gripper=True), max_linear=0.5, max_angular=1.0)
    identity = dataclasses.replace(identity, model=identity.model.with_arrays(True, False))
    message = conversions.robot_info(identity, STAMP, "base_link")
    assert (message.name, message.type, message.subtype, message.firmware) == ("Fred", "Pioneer", "p3dx-sh", "")
    assert (message.max_linear, message.max_angular, message.has_gripper) == (0.5, 1.0, True)
    assert message.sonar_numbers == list(range(8)) and message.sonar_poses[1].x == pytest.approx(0.114)
    assert math.degrees(message.sonar_poses[1].theta) == pytest.approx(50)
    assert max(point.x for point in message.footprint.points) == pytest.approx(0.35)

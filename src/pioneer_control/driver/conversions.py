"""Pure functions that convert the state of the robot to ROS messages. `stamp` is a rospy.Time, the time of the packet.

Units and axes are as in REP 103. Our own messages use the encoding of the ROS package p2os, so that old programs and
old bags still work with them. The frames of the sonar transducers are in `standard_messages`.
"""

import math
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import sensor_msgs.msg
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2, Range
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from .. import p2os, standard_messages
from ..client import GripperReading, RobotIdentity, RobotState
from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, LiftStatus, quaternion_of
from ..msg import IO, Calibration, GripperState, GripState, LiftState, RobotInfo, SonarArray
from ..robots import Transducer
from .parameters import UNKNOWN, DriverParameters

SONAR_LIFETIME = 2.0
"""The age (s) at which a sonar reading is too old to publish. A full round of a sonar array takes 0.32 s."""
WHEEL_JOINTS = ("left_wheel_joint", "right_wheel_joint")
"""The names of the wheel joints in the URDF that `description` makes: left, right."""
COMPASS_VARIANCE = 0.01
"""The variance (rad^2) of a compass heading. A floor can bend the earth's magnetic field by some degrees."""
GYRO_VARIANCE = 1e-4
"""The variance ((rad/s)^2) of a turn rate from the gyro."""
UNKNOWN_DRIFT = -0x8000
"""DriftFactor in a Calibration message of a robot that does not report it."""
NOT_MEASURED = [-1.0] + [0.0] * 8
"""The covariance for a field of sensor_msgs/Imu that is not measured (REP 145)."""

_Power = sensor_msgs.msg.BatteryState
POWER_SUPPLY_STATUS: Dict[Optional[int], int] = {
    p2os.ChargeState.NOT_CHARGING: _Power.POWER_SUPPLY_STATUS_DISCHARGING,
    p2os.ChargeState.BULK: _Power.POWER_SUPPLY_STATUS_CHARGING,
    p2os.ChargeState.OVERCHARGE: _Power.POWER_SUPPLY_STATUS_CHARGING,
    p2os.ChargeState.FLOAT: _Power.POWER_SUPPLY_STATUS_FULL,
    p2os.ChargeState.BALANCE: _Power.POWER_SUPPLY_STATUS_CHARGING,
}
"""From the state of the charger to power_supply_status of sensor_msgs/BatteryState. Other states mean unknown."""
ANALOG_FULL_SCALE = {5: 2047, 9: 1023}
"""From the number of analog inputs in an IOpac to the raw value for 5 V. AROS has 5 inputs, ARCOS 9 (protocol 5.5)."""


class Covariances(NamedTuple):
    """The covariances of nav_msgs/Odometry: row-major 6 x 6 matrices for x, y, z, roll, pitch, yaw."""

    pose: Tuple[float, ...]
    twist: Tuple[float, ...]


def diagonal(variances: Sequence[float]) -> Tuple[float, ...]:
    """Return a row-major covariance matrix that has these variances on its diagonal, and 0 elsewhere."""
    return tuple(variance if row == column else 0.0
                 for row, variance in enumerate(variances) for column in range(len(variances)))


def covariances(parameters: DriverParameters) -> Dict[bool, Covariances]:
    """Return the covariances of odometry from the parameters: True is for a moving robot, False for a standing one."""
    return {
        True: Covariances(diagonal(parameters.pose_covariance_moving), diagonal(parameters.twist_covariance_moving)),
        False: Covariances(diagonal(parameters.pose_covariance_still), diagonal(parameters.twist_covariance_still)),
    }


def odometry(state: RobotState, stamp: Any, odom_frame: str, base_link_frame: str, covariance: Covariances) -> Odometry:
    """Return the message for the topic ``pose``: pose in the odom frame (m, rad), twist in base_link (m/s, rad/s)."""
    message = Odometry(header=Header(stamp=stamp, frame_id=odom_frame), child_frame_id=base_link_frame)
    message.pose.pose = Pose(Point(state.x, state.y, 0.0), Quaternion(*quaternion_of(state.heading)))
    message.twist.twist.linear.x, message.twist.twist.angular.z = state.linear, state.angular
    message.pose.covariance, message.twist.covariance = covariance
    return message


def transform(state: RobotState, stamp: Any, odom_frame: str, base_link_frame: str) -> TFMessage:
    """Return the transform odom -> base_link for /tf: the same pose as in `odometry` (m, rad)."""
    return TFMessage([TransformStamped(
        Header(stamp=stamp, frame_id=odom_frame), base_link_frame,
        Transform(Vector3(state.x, state.y, 0.0), Quaternion(*quaternion_of(state.heading))))])


def ranges(state: RobotState) -> List[float]:
    """Return the ranges (m) for the topic ``sonar``, by transducer number.

    The range is NO_ECHO when there was no echo. It is NOT_HEARD when the last reading is older than SONAR_LIFETIME, or
    when there is none.
    """
    oldest = state.time - SONAR_LIFETIME
    return [NOT_HEARD if reading is None or reading.time < oldest else min(reading.range, NO_ECHO)
            for reading in state.sonar]


def sonar(state: RobotState, stamp: Any, base_link_frame: str) -> SonarArray:
    """Return the message for the topic ``sonar``: see `ranges`."""
    found = ranges(state)
    return SonarArray(Header(stamp=stamp, frame_id=base_link_frame), len(found), found)


def sonar_ranges(state: RobotState, stamp: Any, frame_prefix: str, no_echo: float) -> List[Range]:
    """Return one sensor_msgs/Range message for each sonar reading in this packet.

    ``no_echo`` is the range (m) to publish when there was no echo: infinity (REP 117), or NO_ECHO.
    """
    return [
        standard_messages.sonar_range(number, reading.range, stamp, frame_prefix, no_echo)
        for number, reading in enumerate(state.sonar)
        if reading is not None and reading.time == state.time
    ]


def sonar_points(state: RobotState, stamp: Any, base_link_frame: str, transducers: Iterable[Transducer]) -> PointCloud2:
    """Return a point cloud with the newest echo of each transducer, in base_link at the time of this packet (m).

    A transducer adds no point when it measured no echo, or when its last reading is older than SONAR_LIFETIME.
    """
    oldest = state.time - SONAR_LIFETIME
    heard = ((transducer, state.sonar[transducer.number]) for transducer in transducers)
    return standard_messages.sonar_points(
        [standard_messages.echo_place(transducer, reading.range, state.time - reading.time, state.linear, state.angular)
         for transducer, reading in heard
         if reading is not None and reading.time >= oldest and reading.range < NO_ECHO],
        stamp, base_link_frame)


def joint_states(state: RobotState, stamp: Any, wheel_radius: float) -> sensor_msgs.msg.JointState:
    """Return the angles (rad) and the angular velocities (rad/s) of both wheels. ``wheel_radius`` is in m."""
    return sensor_msgs.msg.JointState(
        header=Header(stamp=stamp),
        name=list(WHEEL_JOINTS),
        position=list(state.wheel_angles or ()),
        velocity=[velocity / wheel_radius for velocity in state.wheel_velocities],
    )


class GripperReporter:
    """Converts gripper readings to gripper_state messages.

    It remembers the last end position of the lift (up or down), because the message has this position also while the
    lift moves.

    Args:
        broken_beam: the value of the bit of a light beam (0 or 1) when an object breaks the beam.
    """

    def __init__(self, broken_beam: int = 1) -> None:
        self._beams_inverted = not broken_beam
        self._position = 0.0

    def saw(self, reading: GripperReading) -> None:
        """Update the remembered end position of the lift. Call this with every reading, also without a subscriber."""
        if not reading.lift_moving and (reading.lift_up or reading.lift_down):
            self._position = float(reading.lift_up)

    def message(self, reading: GripperReading) -> GripperState:
        """Return the message for a reading. Call `saw` with the reading first. Numbers: GripStatus, LiftStatus."""
        grip = next(status for status, is_so in (
            (GripStatus.ERROR, reading.paddles_error),
            (GripStatus.MOVING, reading.paddles_moving),
            (GripStatus.OPEN, reading.paddles_open),
            (GripStatus.CLOSED, reading.paddles_closed),
            (GripStatus.BETWEEN, True),
        ) if is_so)
        lift = next(status for status, is_so in (
            (LiftStatus.MOVING, reading.lift_moving),
            (LiftStatus.STALLED, reading.lift_error),
            (LiftStatus.IDLE, reading.lift_up or reading.lift_down),
            (LiftStatus.STALLED, True),
        ) if is_so)
        grip_direction = reading.paddles_open - reading.paddles_closed if grip == GripStatus.MOVING else 0
        lift_direction = reading.lift_up - reading.lift_down if lift == LiftStatus.MOVING else 0
        beams = (beam != self._beams_inverted for beam in (reading.inner_beam, reading.outer_beam))
        return GripperState(GripState(grip, grip_direction, *beams, reading.left_contact, reading.right_contact),
                            LiftState(lift, lift_direction, self._position))


def battery(state: RobotState, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.BatteryState:
    """Return the message for the topic ``battery``: voltage (V), state of charge (0 to 1) and state of the charger.

    Values that the robot does not report are NaN.
    """
    status = POWER_SUPPLY_STATUS.get(state.charge_state, _Power.POWER_SUPPLY_STATUS_UNKNOWN)
    if status == _Power.POWER_SUPPLY_STATUS_DISCHARGING and state.flags & p2os.Flags.CHARGER_POWER:
        status = _Power.POWER_SUPPLY_STATUS_NOT_CHARGING
    return standard_messages.battery(state.battery_voltage, stamp, base_link_frame,
                                     math.nan if state.state_of_charge is None else state.state_of_charge, status)


def ports(packet: p2os.IO, stamp: Any, base_link_frame: str) -> IO:
    """Return the message for the topic ``io``: the digital ports of an IOpac as bits, and its analog inputs in V."""
    volts = 5.0 / ANALOG_FULL_SCALE.get(len(packet.analog), 1023)
    return IO(Header(stamp=stamp, frame_id=base_link_frame), packet.digital_in, packet.digital_out,
              [value * volts for value in packet.analog])


def joystick(packet: p2os.Joystick, stamp: Any) -> sensor_msgs.msg.Joy:
    """Return the message for the topic ``joystick``: a joystick at the robot's own port.

    Axes: to the left, forward (-1 to 1, 0 in the middle), and throttle (0 to 1). Buttons: 1, 2.
    """
    middle = 512.0
    x, y = ((value - middle) / middle for value in (packet.x, packet.y))
    return sensor_msgs.msg.Joy(
        header=Header(stamp=stamp), axes=[max(-1.0, min(1.0, -x)), max(-1.0, min(1.0, y)),
                                          min(1.0, packet.throttle / (2 * middle))],
        buttons=[packet.button_1, packet.button_2])


def turn_rate(rate: float, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.Imu:
    """Return an Imu message with only the turn rate of the gyro (rad/s, counter-clockwise)."""
    return _imu(stamp, base_link_frame, angular_velocity=Vector3(0.0, 0.0, rate),
                angular_velocity_covariance=diagonal((UNKNOWN, UNKNOWN, GYRO_VARIANCE)))


def compass(state: RobotState, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.Imu:
    """Return an Imu message with only the heading of the compass.

    As REP 103 says, the heading is counter-clockwise from (magnetic) east. The compass itself measures it clockwise
    from north.
    """
    heading = math.remainder(math.pi / 2 - (state.compass or 0.0), 2 * math.pi)
    return _imu(stamp, base_link_frame, orientation=Quaternion(*quaternion_of(heading)),
                orientation_covariance=diagonal((UNKNOWN, UNKNOWN, COMPASS_VARIANCE)))


def _imu(stamp: Any, base_link_frame: str, **measured: Any) -> sensor_msgs.msg.Imu:
    """Return an Imu message with the ``measured`` fields. The covariances of all other fields mean "not measured"."""
    nothing = dict(orientation=Quaternion(0.0, 0.0, 0.0, 1.0), orientation_covariance=NOT_MEASURED,
                   angular_velocity_covariance=NOT_MEASURED, linear_acceleration_covariance=NOT_MEASURED)
    return sensor_msgs.msg.Imu(header=Header(stamp=stamp, frame_id=base_link_frame), **{**nothing, **measured})


def robot_info(identity: RobotIdentity, stamp: Any, base_link_frame: str) -> RobotInfo:
    """Return the message for the topic ``robot_info``.

    It has the name, the model and the limits of the robot, the poses of its transducers and its outline (m, rad;
    base_link).
    """
    message = standard_messages.robot_info(identity.model, identity.has_gripper, stamp, base_link_frame)
    message.name, message.type, message.subtype = identity.name, identity.type, identity.subtype
    message.firmware = identity.firmware or ""
    message.max_linear, message.max_angular = identity.max_linear, identity.max_angular
    return message


def calibration_numbers(identity: RobotIdentity) -> Tuple[int, int, int, int]:
    """Return TicksMM, RevCount, DriftFactor and the kind of gyro, as the topic ``calibration`` tells them."""
    config = identity.config
    assert config is not None
    return (config.ticks_per_mm or 0, config.rev_count or 0,
            UNKNOWN_DRIFT if config.drift_factor is None else config.drift_factor, config.has_gyro or 0)


def calibration(identity: RobotIdentity, stamp: Any) -> Calibration:
    """Return the message for the topic ``calibration``: what the robot itself reports of its calibration."""
    return Calibration(Header(stamp=stamp), *calibration_numbers(identity))

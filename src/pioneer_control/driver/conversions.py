"""Robot state to ROS messages: pure functions; all messages of one packet carry one stamp. Frames of the transducers
are in `standard_messages`.

Units and axes are those of REP 103; the encoding of the frozen messages is that of p2os, so that its peers and bags go
on working.
"""

import math
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import sensor_msgs.msg
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2, Range
from std_msgs.msg import Bool, Header
from tf2_msgs.msg import TFMessage

from .. import p2os, standard_messages
from ..client import GripperReading, RobotIdentity, RobotState
from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, LiftStatus, quaternion_of
from ..msg import (AIO, DIO, IO, BatteryState, Bumpers, GripperState, GripState, LiftState, MotorState, RobotInfo,
                   SonarArray, Stall)
from ..robots import Transducer
from .parameters import UNKNOWN, DriverParameters

SONAR_LIFETIME = 2.0
"""Age (s) at which a reading expires; a full round of an array takes 0.32 s."""
WHEEL_JOINTS = ("left_wheel_joint", "right_wheel_joint")
"""Names in urdf/, the left one first."""
COMPASS_VARIANCE = 0.01
"""rad^2: a floor bends the earth's field by some degrees."""
GYRO_VARIANCE = 1e-4
"""(rad/s)^2"""
NOT_MEASURED = [-1.0] + [0.0] * 8
"""Covariance that tells that a field of an Imu means nothing (REP 145)."""

_Power = sensor_msgs.msg.BatteryState
POWER_SUPPLY_STATUS: Dict[Optional[int], int] = {
    p2os.ChargeState.NOT_CHARGING: _Power.POWER_SUPPLY_STATUS_DISCHARGING,
    p2os.ChargeState.BULK: _Power.POWER_SUPPLY_STATUS_CHARGING,
    p2os.ChargeState.OVERCHARGE: _Power.POWER_SUPPLY_STATUS_CHARGING,
    p2os.ChargeState.FLOAT: _Power.POWER_SUPPLY_STATUS_FULL,
    p2os.ChargeState.BALANCE: _Power.POWER_SUPPLY_STATUS_CHARGING,
}
"""What the charger does, as sensor_msgs/BatteryState says it; the rest is unknown."""
ANALOG_FULL_SCALE = {5: 2047, 9: 1023}
"""What 5 V are in an IOpac with so many analog inputs: AROS has 5, ARCOS 9 (protocol 5.5)."""


class Covariances(NamedTuple):
    """Row-major 6 x 6, of x, y, z, roll, pitch, yaw."""

    pose: Tuple[float, ...]
    twist: Tuple[float, ...]


def diagonal(variances: Sequence[float]) -> Tuple[float, ...]:
    """A covariance, row-major, of numbers that do not depend on each other."""
    size = len(variances)
    return tuple(variances[row] if row == column else 0.0 for row in range(size) for column in range(size))


def covariances(parameters: DriverParameters) -> Dict[bool, Covariances]:
    """What goes into odometry while the robot moves (True) and while it stands (False)."""
    return {
        True: Covariances(diagonal(parameters.pose_covariance_moving), diagonal(parameters.twist_covariance_moving)),
        False: Covariances(diagonal(parameters.pose_covariance_still), diagonal(parameters.twist_covariance_still)),
    }


def odometry(state: RobotState, stamp: Any, odom_frame: str, base_link_frame: str, covariance: Covariances) -> Odometry:
    """Pose in the odometry frame (m, rad), twist in base_link (m/s, rad/s)."""
    message = Odometry(header=Header(stamp=stamp, frame_id=odom_frame), child_frame_id=base_link_frame)
    message.pose.pose = Pose(Point(state.x, state.y, 0.0), Quaternion(*quaternion_of(state.heading)))
    message.twist.twist.linear.x, message.twist.twist.angular.z = state.linear, state.angular
    message.pose.covariance, message.twist.covariance = covariance
    return message


def transform(state: RobotState, stamp: Any, odom_frame: str, base_link_frame: str) -> TFMessage:
    """Odometry frame -> base_link, the same as the pose (m, rad)."""
    return TFMessage([TransformStamped(
        Header(stamp=stamp, frame_id=odom_frame), base_link_frame,
        Transform(Vector3(state.x, state.y, 0.0), Quaternion(*quaternion_of(state.heading))))])


def sonar(state: RobotState, stamp: Any, base_link_frame: str) -> SonarArray:
    """Ranges (m) by sonar number."""
    ranges = ranges_by_number(state)
    return SonarArray(Header(stamp=stamp, frame_id=base_link_frame), len(ranges), ranges)


def ranges_by_number(state: RobotState) -> List[float]:
    """Ranges (m) by sonar number; NO_ECHO where nothing is in sight, NOT_HEARD where the last reading has expired."""
    oldest = state.time - SONAR_LIFETIME
    return [NOT_HEARD if reading is None or reading.time < oldest else min(reading.range, NO_ECHO)
            for reading in state.sonar]


def sonar_ranges(state: RobotState, stamp: Any, frame_prefix: str, no_echo: float) -> List[Range]:
    """One message for each transducer of which this packet brought a range.

    ``no_echo`` (m) is the range where nothing is in sight: infinity (REP 117), or NO_ECHO.
    """
    return [
        standard_messages.sonar_range(number, reading.range, stamp, frame_prefix, no_echo)
        for number, reading in enumerate(state.sonar)
        if reading is not None and reading.time == state.time
    ]


def sonar_points(state: RobotState, stamp: Any, base_link_frame: str, transducers: Iterable[Transducer]) -> PointCloud2:
    """The newest echo of each transducer as a point (m) in base_link, where the robot stands now.

    A transducer that hears no echo, or was not heard lately, has no point.
    """
    oldest = state.time - SONAR_LIFETIME
    heard = ((transducer, state.sonar[transducer.number]) for transducer in transducers)
    return standard_messages.sonar_points(
        [standard_messages.echo_place(transducer, reading.range, state.time - reading.time, state.linear, state.angular)
         for transducer, reading in heard
         if reading is not None and reading.time >= oldest and reading.range < NO_ECHO],
        stamp, base_link_frame)


def joint_states(state: RobotState, stamp: Any, wheel_radius: float) -> sensor_msgs.msg.JointState:
    """How far (rad) the wheels have turned, and how fast (rad/s) they turn. The wheels' radius (m) must be known."""
    return sensor_msgs.msg.JointState(
        header=Header(stamp=stamp),
        name=list(WHEEL_JOINTS),
        position=list(state.wheel_angles or ()),
        velocity=[velocity / wheel_radius for velocity in state.wheel_velocities],
    )


class GripperReporter:
    """Turns readings into gripper_state. Remembers the lift's last end position, which a moving lift goes on reporting.

    Args:
        broken_beam: what the bit of a beam reads when something breaks it.
    """

    def __init__(self, broken_beam: int = 1) -> None:
        self._beams_inverted = not broken_beam
        self._position = 0.0

    def saw(self, reading: GripperReading) -> None:
        """Remember a reading, whether somebody wants to hear of it or not."""
        if not reading.lift_moving and (reading.lift_up or reading.lift_down):
            self._position = float(reading.lift_up)

    def message(self, reading: GripperReading) -> GripperState:
        """The reading, seen last, in the encoding of p2os (GripStatus, LiftStatus)."""
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


def motor_state(state: RobotState) -> MotorState:
    """1 when the motors are on, else 0."""
    return MotorState(int(state.motors_enabled))


def battery_state(state: RobotState, stamp: Any, base_link_frame: str) -> BatteryState:
    """Battery voltage (V)."""
    return BatteryState(Header(stamp=stamp, frame_id=base_link_frame), state.battery_voltage)


def battery(state: RobotState, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.BatteryState:
    """Voltage (V), state of charge (0 to 1) where the robot reports it, and what the charger does.

    What the robot does not measure is NaN.
    """
    status = POWER_SUPPLY_STATUS.get(state.charge_state, _Power.POWER_SUPPLY_STATUS_UNKNOWN)
    if status == _Power.POWER_SUPPLY_STATUS_DISCHARGING and state.flags & p2os.Flags.CHARGER_POWER:
        status = _Power.POWER_SUPPLY_STATUS_NOT_CHARGING
    return standard_messages.battery(state.battery_voltage, stamp, base_link_frame,
                                     math.nan if state.state_of_charge is None else state.state_of_charge, status)


def bumpers(state: RobotState, stamp: Any, base_link_frame: str) -> Bumpers:
    """Pressed or not, segment by segment."""
    return Bumpers(Header(stamp=stamp, frame_id=base_link_frame), list(state.front_bumpers), list(state.rear_bumpers))


def stall(state: RobotState, stamp: Any, base_link_frame: str) -> Stall:
    """Which wheels are stalled."""
    return Stall(Header(stamp=stamp, frame_id=base_link_frame), state.left_stall, state.right_stall)


def e_stop(state: RobotState) -> Bool:
    """Whether the STOP button is pressed."""
    return Bool(state.stop_button)


def digital_inputs(state: RobotState) -> Optional[DIO]:
    """The eight user inputs; None from firmware that does not report them."""
    return None if state.digital_in is None else DIO(8, state.digital_in)


def analog_input(state: RobotState) -> Optional[AIO]:
    """The selected analog input (V); None from firmware that does not report it."""
    return None if state.analog_voltage is None else AIO(1, [state.analog_voltage])


def ports(packet: p2os.IO, stamp: Any, base_link_frame: str) -> IO:
    """Every port of an IOpac: digital ones as they came, analog ones in V."""
    volts = 5.0 / ANALOG_FULL_SCALE.get(len(packet.analog), 1023)
    return IO(Header(stamp=stamp, frame_id=base_link_frame), packet.digital_in, packet.digital_out,
              [value * volts for value in packet.analog])


def turn_rate(rate: float, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.Imu:
    """What a gyro tells: the turn rate (rad/s), and nothing else."""
    return _imu(stamp, base_link_frame, angular_velocity=Vector3(0.0, 0.0, rate),
                angular_velocity_covariance=diagonal((UNKNOWN, UNKNOWN, GYRO_VARIANCE)))


def compass(state: RobotState, stamp: Any, base_link_frame: str) -> sensor_msgs.msg.Imu:
    """What a compass tells: the heading, by REP 103 from magnetic east counter-clockwise.

    The compass itself counts from north, clockwise.
    """
    heading = math.remainder(math.pi / 2 - (state.compass or 0.0), 2 * math.pi)
    return _imu(stamp, base_link_frame, orientation=Quaternion(*quaternion_of(heading)),
                orientation_covariance=diagonal((UNKNOWN, UNKNOWN, COMPASS_VARIANCE)))


def _imu(stamp: Any, base_link_frame: str, **measured: Any) -> sensor_msgs.msg.Imu:
    """A message with the fields that are measured; the others say that they mean nothing."""
    nothing = dict(orientation=Quaternion(0.0, 0.0, 0.0, 1.0), orientation_covariance=NOT_MEASURED,
                   angular_velocity_covariance=NOT_MEASURED, linear_acceleration_covariance=NOT_MEASURED)
    return sensor_msgs.msg.Imu(header=Header(stamp=stamp, frame_id=base_link_frame), **{**nothing, **measured})


def robot_info(identity: RobotIdentity, stamp: Any, base_link_frame: str) -> RobotInfo:
    """What the robot is: name, model, limits, where its transducers look and what its outline is (m, rad, base_link).
    """
    message = standard_messages.robot_info(identity.model, identity.has_gripper, stamp, base_link_frame)
    message.name, message.type, message.subtype = identity.name, identity.type, identity.subtype
    message.firmware = identity.firmware or ""
    message.max_linear, message.max_angular = identity.max_linear, identity.max_angular
    return message

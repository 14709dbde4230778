"""Robot state to ROS messages: pure functions; all messages of one packet carry one stamp.

Units and axes are those of REP 103; the encoding of the frozen messages is that of p2os, so that its peers and bags go on working.
"""

from typing import Optional, Tuple

from geometry_msgs.msg import Point, Point32, Pose2D, Quaternion, TransformStamped
from nav_msgs.msg import Odometry

from ..client import GripperReading, RobotIdentity, RobotState
from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, LiftStatus, quaternion_of
from ..msg import AIO, DIO, BatteryState, GripperState, GripState, LiftState, MotorState, RobotInfo, SonarArray

SONAR_LIFETIME = 2.0
"""Age (s) at which a reading expires; a full round of an array takes 0.32 s."""

UNKNOWN = 1e6
# Variances of x, y, z, roll, pitch, yaw. A standing robot knows that it stands; odometry of a moving one drifts.
POSE_VARIANCES = (1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2)
TWIST_VARIANCES_MOVING = (1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2)
TWIST_VARIANCES_STILL = (1e-6, 1e-6, UNKNOWN, UNKNOWN, UNKNOWN, 1e-6)


def diagonal(variances: Tuple[float, ...]) -> Tuple[float, ...]:
    """The six variances as a row-major 6 x 6 covariance."""
    return tuple(variances[row] if row == column else 0.0 for row in range(6) for column in range(6))


POSE_COVARIANCE = diagonal(POSE_VARIANCES)
TWIST_COVARIANCES = {True: diagonal(TWIST_VARIANCES_MOVING), False: diagonal(TWIST_VARIANCES_STILL)}


def odometry(state: RobotState, stamp, odom_frame: str, base_link_frame: str) -> Odometry:
    """Pose in the odometry frame, twist in base_link, with variances for a robot that moves or stands."""
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id = odom_frame
    message.child_frame_id = base_link_frame
    message.pose.pose.position = Point(state.x, state.y, 0.0)
    message.pose.pose.orientation = Quaternion(*quaternion_of(state.heading))
    message.pose.covariance = POSE_COVARIANCE
    message.twist.twist.linear.x = state.linear
    message.twist.twist.angular.z = state.angular
    message.twist.covariance = TWIST_COVARIANCES[bool(state.linear or state.angular)]
    return message


def transform(pose: Odometry) -> TransformStamped:
    """The transform odometry frame -> base_link that says the same as a `pose` message."""
    message = TransformStamped(header=pose.header, child_frame_id=pose.child_frame_id)
    position = pose.pose.pose.position
    message.transform.translation.x, message.transform.translation.y = position.x, position.y
    message.transform.rotation = pose.pose.pose.orientation
    return message


def sonar_array(state: RobotState, stamp, base_link_frame: str) -> SonarArray:
    """Ranges (m) by sonar number; NO_ECHO where nothing is in sight, NOT_HEARD where the last reading has expired."""
    ranges = [_range(reading, state.time) for reading in state.sonar]
    message = SonarArray(ranges_count=len(ranges), ranges=ranges)
    message.header.stamp, message.header.frame_id = stamp, base_link_frame
    return message


def _range(reading, now: float) -> float:
    if reading is None or now - reading.time > SONAR_LIFETIME:
        return NOT_HEARD
    return min(reading.range, NO_ECHO)


class GripperReporter:
    """Turns readings into gripper_state. Remembers the lift's last end position, which a moving lift goes on reporting."""

    def __init__(self) -> None:
        self._position = 0.0

    def message(self, reading: GripperReading) -> GripperState:
        """The reading in the encoding of p2os (GripStatus, LiftStatus)."""
        return GripperState(self._grip(reading), self._lift(reading))

    def _grip(self, reading: GripperReading) -> GripState:
        if reading.paddles_error:
            state = GripStatus.ERROR
        elif reading.paddles_moving:
            state = GripStatus.MOVING
        else:
            at_rest = GripStatus.CLOSED if reading.paddles_closed else GripStatus.BETWEEN
            state = GripStatus.OPEN if reading.paddles_open else at_rest
        direction = reading.paddles_open - reading.paddles_closed if state == GripStatus.MOVING else 0
        return GripState(state, direction, reading.inner_beam, reading.outer_beam, reading.left_contact, reading.right_contact)

    def _lift(self, reading: GripperReading) -> LiftState:
        at_an_end = reading.lift_up or reading.lift_down
        if reading.lift_moving:
            state = LiftStatus.MOVING
        else:
            state = LiftStatus.IDLE if at_an_end and not reading.lift_error else LiftStatus.STALLED
            self._position = float(reading.lift_up) if at_an_end else self._position
        direction = reading.lift_up - reading.lift_down if state == LiftStatus.MOVING else 0
        return LiftState(state, direction, self._position)


def motor_state(state: RobotState) -> MotorState:
    """1 when the motors are on, else 0."""
    return MotorState(int(state.motors_enabled))


def battery_state(state: RobotState, stamp, base_link_frame: str) -> BatteryState:
    """Battery voltage (V)."""
    message = BatteryState(voltage=state.battery_voltage)
    message.header.stamp, message.header.frame_id = stamp, base_link_frame
    return message


def digital_inputs(state: RobotState) -> Optional[DIO]:
    """The eight user inputs; None from firmware that does not report them."""
    return None if state.digital_in is None else DIO(8, state.digital_in)


def analog_input(state: RobotState) -> Optional[AIO]:
    """The selected analog input (V); None from firmware that does not report it."""
    return None if state.analog_voltage is None else AIO(1, [state.analog_voltage])


def robot_info(identity: RobotIdentity, stamp, base_link_frame: str) -> RobotInfo:
    """What the robot is: name, model, limits, where its transducers look and what its outline is (m, rad, base_link)."""
    model = identity.model
    message = RobotInfo(
        name=identity.name,
        type=identity.type,
        subtype=identity.subtype,
        firmware=identity.firmware or "",
        max_linear=identity.max_linear,
        max_angular=identity.max_angular,
        has_gripper=identity.has_gripper,
        sonar_numbers=[transducer.number for transducer in model.sonar],
        sonar_poses=[Pose2D(transducer.x, transducer.y, transducer.heading) for transducer in model.sonar],
    )
    message.footprint.points = [Point32(x, y, 0.0) for x, y in model.outline(identity.has_gripper)]
    message.header.stamp, message.header.frame_id = stamp, base_link_frame
    return message

"""All parameters of the driver node, in the dataclass `DriverParameters`.

Each field is one private parameter, with its default, the legal values, the unit and the meaning.
"""

import math
from dataclasses import dataclass, fields, replace
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

from ..arm.joints import JointSettings
from ..arm.phases import ArmSettings
from ..arm.status import LAYOUTS
from ..client import Tuning, VelocityInput
from ..errors import ParameterError
from ..p2os import BAUD_RATES
from ..parameters import (AutoSwitch, Choice, Number, Numbers, Rate, Signs, Switch, Text, Whole, Wholes, check,
                          check_old, parameter)
from ..ptz import Cabling, CameraSettings
from ..ptz.view import Place3
from ..vcc4 import CAMERA_MODELS, TELE_DEG, WIDE_DEG, count_of

GAIN = Whole(-1, 65535)
NO_DRIFT_GIVEN = -32768
PROGRAM, PERSON = 10, 100
"""The priorities of velocity inputs: of those of programs, and of that of a person."""
BY_HAND = "teleop/cmd_vel"
"""The topic of a person who drives by hand."""
UNKNOWN = 1e6   # variance of a value that wheels cannot measure
VARIANCES = Numbers(6, 0.0, 1e9)
Variances = Tuple[float, float, float, float, float, float]     # of x, y, z (m^2), roll, pitch, yaw (rad^2)

WITHOUT_EFFECT = {
    **dict.fromkeys("use_tcp tcp_remote_host tcp_remote_port".split(),
                    "give the address as the port: port:=socket://host:8101"),
    **dict.fromkeys("radio joystick direct_wheel_vel_control".split(), "it never had one in p2os either"),
    **dict.fromkeys("bumpers_frame sonar_frame".split(),
                    "bumpers are in the robot's frame, each transducer has its own"),
    **dict.fromkeys("lat_accel lat_decel".split(), "no robot is driven sideways"),
    "trans_accel": "it is called max_xaccel here",
    "trans_decel": "it is called max_xdecel here",
    "rot_accel": "it is called max_yawaccel here",
    "rot_decel": "it is called max_yawdecel here",
}
"""Parameters of p2os and ROSARIA that have no effect in this driver, and the text of the warning for each of them."""

TUNING = {
    "max_xaccel": "max_linear_acceleration",
    "max_xdecel": "max_linear_deceleration",
    "max_yawaccel": "max_angular_acceleration",
    "max_yawdecel": "max_angular_deceleration",
    "rot_kp": "rotation_kp",
    "rot_kv": "rotation_kv",
    "rot_ki": "rotation_ki",
    "trans_kp": "translation_kp",
    "trans_kv": "translation_kv",
    "trans_ki": "translation_ki",
    "bumpstall": "bump_stall",
    "ticks_mm": "ticks_mm",
    "drift_factor": "drift_factor",
    "rev_count": "rev_count",
    "sonar_cycle": "sonar_cycle",
    "sonar_polling": "sonar_polling",
}
"""The parameters that the driver sets in the robot itself: from our name to the name in client.Tuning.

When a parameter has its default value, the robot keeps its own value.
"""


FIVE = 5    # joints of an arm, without its gripper
ANY_ANGLE = 3.2
"""Limit (rad) that no joint of an arm reaches."""
ANGLES = Numbers(FIVE, -ANY_ANGLE, ANY_ANGLE)


class PlaceOrNone(NamedTuple):
    """Checks a parameter that says where something stands: x, y, z (m, base_link), or an empty text for nowhere."""

    legal: str = "three numbers, as a list: x, y, z; or an empty text"

    def accept(self, value: Any) -> Optional[Place3]:
        """Return the place, or None for an empty text. Raise ValueError if the value is neither."""
        if isinstance(value, str):
            if not value.strip():
                return None
            value = [float(word) for word in value.strip("[] ").split(",")]
        return Place3(*Numbers(3, -1e3, 1e3).accept(value))


@dataclass(frozen=True)
class DriverParameters:
    """The checked private parameters of the driver. Many names are those of the ROS package p2os."""

    port: str = parameter("/dev/ttyUSB0", Text(), "serial device, socket://host:port, or ws://host:port/path#key=KEY")
    baud: int = parameter(9600, Choice(BAUD_RATES), "line speed tried first, the others follow", "baud")
    host_baud: int = parameter(0, Choice((0,) + BAUD_RATES), "line speed to change to once connected; 0: none", "baud")
    model: str = parameter("", Text(empty=True), "robot model to assume; empty: what the robot says it is")
    models_file: str = parameter("", Text(empty=True), "file with your own calibration of models; empty: none")
    gripper: Optional[bool] = parameter(None, AutoSwitch(), "is a gripper fitted? auto: what the robot says")
    beam_polarity: int = parameter(1, Choice((0, 1)), "what the gripper's beams read when something breaks them")
    pulse: float = parameter(1.0, Number(-1.0, 1.5), "time between signs of life to the robot; 0 or less: none", "s")
    link_check: bool = parameter(
        True, Switch(), "ask the robot a few times a second while it is driven, to see whether commands arrive")
    use_sonar: bool = parameter(True, Switch(), "sonar on; false: off, and no sonar topic is fed")
    laser_power: bool = parameter(False, Switch(), "the robot gives its laser power at each connection; false: leave it"
                                  " as it is")
    max_xspeed: float = parameter(0.5, Number(0.01, 3.0), "no forward or backward command goes beyond", "m/s",
                                  live=True)
    max_yawspeed: float = parameter(1.745, Number(0.02, 6.3), "no turn goes beyond", "rad/s", live=True)
    cmd_vel_timeout: float = parameter(0.6, Number(0.1, 2.0), "a velocity older than this means stop", "s", live=True)
    teleop_timeout: float = parameter(
        0.5, Number(0.1, 2.0), "a person's velocity older than this, or than cmd_vel_timeout, means stop", "s",
        live=True)
    max_xaccel: float = parameter(0.0, Rate(0.01, 10.0), "acceleration; 0: the robot's own", "m/s^2", live=True)
    max_xdecel: float = parameter(0.0, Rate(0.1, 10.0, signed=True), "deceleration, any sign; 0: the robot's own",
                                  "m/s^2", live=True)
    max_yawaccel: float = parameter(0.0, Rate(0.1, 20.0), "acceleration of turns; 0: the robot's own", "rad/s^2",
                                    live=True)
    max_yawdecel: float = parameter(0.0, Rate(0.2, 20.0, signed=True),
                                    "deceleration of turns, any sign; 0: the robot's own", "rad/s^2", live=True)
    rot_kp: int = parameter(-1, GAIN, "rotation PID, proportional; -1: the robot's own", live=True)
    rot_kv: int = parameter(-1, GAIN, "rotation PID, derivative; -1: the robot's own", live=True)
    rot_ki: int = parameter(-1, GAIN, "rotation PID, integral; -1: the robot's own", live=True)
    trans_kp: int = parameter(-1, GAIN, "translation PID, proportional; -1: the robot's own", live=True)
    trans_kv: int = parameter(-1, GAIN, "translation PID, derivative; -1: the robot's own", live=True)
    trans_ki: int = parameter(-1, GAIN, "translation PID, integral; -1: the robot's own", live=True)
    bumpstall: int = parameter(-1, Whole(-1, 3),
                               "bumpers that stall: 0 none, 1 front, 2 rear, 3 both; -1: the robot's own", live=True)
    ticks_mm: int = parameter(0, Whole(0, 65535), "calibration TicksMM; 0: the robot's own", "1/mm", live=True)
    drift_factor: int = parameter(NO_DRIFT_GIVEN, Whole(NO_DRIFT_GIVEN, 32767),
                                  "calibration DriftFactor; -32768: the robot's own", live=True)
    rev_count: int = parameter(0, Whole(0, 65535), "calibration RevCount; 0: the robot's own", "1/turn", live=True)
    sonar_cycle: float = parameter(0.0, Rate(0.002, 0.12), "time between two firings of each sonar array; 0: the"
                                   " robot's own", "s", live=True)
    sonar_polling: Tuple[int, ...] = parameter((), Wholes(0, 31), "order in which sonars fire, by number; empty: the"
                                               " robot's own")
    enable_motors_on_start: bool = parameter(False, Switch(),
                                             "motors on when the robot is found for the first time, with nobody asking")
    accept_replay: bool = parameter(False, Switch(), "obey commands that `rosbag play` publishes")
    odom_frame_id: str = parameter("odom", Text(slash=False), "frame of the pose")
    base_link_frame_id: str = parameter("base_link", Text(slash=False), "frame of the robot")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "put before every frame name, e.g. robot2/")
    publish_tf: bool = parameter(True, Switch(), "publish the transform odom -> base_link")
    publish_wire: bool = parameter(False, Switch(), "publish every byte of the robot's line, both ways, on wire")
    sonar_no_echo: str = parameter("inf", Choice(("inf", "max")),
                                   "range in sonar_ranges when nothing is in sight: inf or max")
    ptz: str = parameter("none", Choice(("none", *CAMERA_MODELS)), "camera that turns; it is switched on and"
                         " initialised when the robot is found")
    ptz_port: str = parameter("aux1", Text(), "where the camera is: aux1 to aux3 of the robot, a serial device, or"
                              " socket://host:port")
    ptz_cabling: str = parameter("auto", Choice(tuple(each.value for each in Cabling)), "whether the camera's answers"
                                 " arrive; auto: find out")
    ptz_inverted: bool = parameter(False, Switch(), "the camera hangs upside down")
    ptz_power_off_at_end: bool = parameter(False, Switch(), "the camera goes home and is switched off when the driver"
                                           " ends")
    ptz_pan_speed: float = parameter(1.57, Number(0.016, 1.571), "speed of the camera to the sides", "rad/s")
    ptz_tilt_speed: float = parameter(1.204, Number(0.016, 1.221), "speed of the camera up and down", "rad/s")
    ptz_place: Optional[Place3] = parameter(None, PlaceOrNone(), "where the camera stands: tf from base_link_frame_id"
                                            " to ptz_base_link and camera; empty: no tf", "m")
    ptz_fov_wide: float = parameter(WIDE_DEG, Number(1.0, 120.0), "horizontal field of view at zoom 0, for ptz_view",
                                    "deg")
    ptz_fov_tele: float = parameter(TELE_DEG, Number(0.1, 120.0), "horizontal field of view at zoom 1960", "deg")
    use_arm: bool = parameter(False, Switch(), "there is a Pioneer Arm; it gets no power before somebody asks")
    arm_layout: str = parameter("auto", Choice(("auto", *LAYOUTS)), "layout of its status packets; auto: find out")
    arm_signs: Tuple[int, ...] = parameter(
        (1,) * FIVE, Signs(FIVE), "-1 for each joint that turns the other way: base, shoulder, elbow, roll, wrist")
    arm_offsets: Tuple[float, ...] = parameter(
        (0.0,) * FIVE, ANGLES, "angle of each joint when its servo is at its centre", "rad")
    arm_lower: Tuple[float, ...] = parameter(
        (-ANY_ANGLE,) * FIVE, ANGLES, "lower limit of each joint, besides the arm's own", "rad")
    arm_upper: Tuple[float, ...] = parameter(
        (ANY_ANGLE,) * FIVE, ANGLES, "upper limit of each joint, besides the arm's own", "rad")
    arm_max_speeds: Tuple[float, ...] = parameter(
        (0.5,) * FIVE, Numbers(FIVE, 0.12, 2.0), "highest speed of each joint", "rad/s")
    arm_gripper_speed: float = parameter(0.02, Number(0.004, 0.2), "highest speed of the arm's gripper", "m/s")
    arm_max_step: float = parameter(
        1.6, Number(0.05, 6.3), "farthest that a joint may move from one point of a motion to the next", "rad")
    arm_autopark: int = parameter(
        600, Whole(60, 65535), "time without a command after which the arm parks by itself", "s")
    arm_grippark: int = parameter(
        300, Whole(60, 65535), "time after which a closed gripper of the arm opens by itself", "s")
    pose_covariance_moving: Variances = parameter((1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2), VARIANCES,
                                                  "of pose, while the robot moves")
    pose_covariance_still: Variances = parameter((1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2), VARIANCES,
                                                 "of pose, while it stands")
    twist_covariance_moving: Variances = parameter((1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2), VARIANCES,
                                                   "of twist, while the robot moves")
    twist_covariance_still: Variances = parameter((1e-6, 1e-6, UNKNOWN, UNKNOWN, UNKNOWN, 1e-6), VARIANCES,
                                                  "of twist, while it stands")

    @property
    def inputs(self) -> Dict[str, VelocityInput]:
        """The topics by which velocities come: programs have one priority, and a person is above them."""
        program = VelocityInput(PROGRAM, self.cmd_vel_timeout)
        person = VelocityInput(PERSON, min(self.teleop_timeout, self.cmd_vel_timeout), keeps_helm=True)
        return {"cmd_vel": program, "cmd_wheels": program, BY_HAND: person}

    @property
    def tuning(self) -> Tuning:
        """The values to set in the robot itself. None for a value that the robot keeps."""
        return Tuning(**{name: getattr(self, ours) for ours, name in TUNING.items()
                         if getattr(self, ours) != getattr(DriverParameters, ours)})

    @property
    def camera(self) -> Optional[CameraSettings]:
        """The settings of the camera. None without one."""
        if self.ptz == "none":
            return None
        speeds = (count_of(math.degrees(speed)) for speed in (self.ptz_pan_speed, self.ptz_tilt_speed))
        return CameraSettings(self.ptz, Cabling(self.ptz_cabling), self.ptz_inverted, self.ptz_power_off_at_end,
                              *speeds)

    @property
    def arm(self) -> Optional[ArmSettings]:
        """The settings of the arm. None without one."""
        if not self.use_arm:
            return None
        joints = map(JointSettings, self.arm_max_speeds, self.arm_signs, self.arm_offsets, self.arm_lower,
                     self.arm_upper)
        return ArmSettings((*joints, JointSettings(self.arm_gripper_speed)),
                           None if self.arm_layout == "auto" else self.arm_layout, self.arm_autopark,
                           self.arm_grippark, self.arm_max_step)

    @property
    def odom_frame(self) -> str:
        """The full name of the odom frame, with the prefix."""
        return self.frame_prefix + self.odom_frame_id

    @property
    def base_link_frame(self) -> str:
        """The full name of the frame base_link, with the prefix."""
        return self.frame_prefix + self.base_link_frame_id


LIVE = {entry.name: entry for entry in fields(DriverParameters) if entry.metadata["live"]}
"""The fields of the parameters that may change while the driver runs, by name."""


def changed(parameters: DriverParameters, wanted: Mapping[str, Any]) -> DriverParameters:
    """Return a copy of the parameters with the values in ``wanted``.

    Raises:
        ParameterError: a value is not legal, or a parameter may not change while the driver runs.
    """
    fixed = sorted(set(wanted) - set(LIVE))
    if fixed:
        raise ParameterError("~%s cannot change while the driver runs" % ", ~".join(fixed))
    accepted, _ = check(DriverParameters, wanted)
    return replace(parameters, **{name: getattr(accepted, name) for name in wanted})


def check_parameters(given: Mapping[str, Any]) -> Tuple[DriverParameters, List[str]]:
    """Check the private parameters of the driver.

    Args:
        given: names and values from the parameter server.

    Returns:
        The parameters; and a warning for each given name that has no effect.

    Raises:
        ParameterError: a value is not legal, or an unknown name is similar to a known name.
    """
    return check_old(DriverParameters, given, WITHOUT_EFFECT)

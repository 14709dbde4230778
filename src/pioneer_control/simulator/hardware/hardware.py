"""The robot below its firmware: drives, body, gripper, sonar, battery and STOP button, moved together in fixed steps.

SI units; knows no packets. `Hardware.step` is the only place where simulated time passes for them.
"""

import math
from dataclasses import replace
from typing import Callable, List, Optional, Set, Tuple

from ...errors import ParameterError
from ...robots import RobotModel
from .accessories import AuxPort, RateGyro, JoystickState
from .battery import BatteryPack
from .body import Body
from ..world.poses import along_arc
from .docks import dock_at
from .ramps import Channel, Limits
from ..world.trigonometry import Heading
from ..world.geometry import Pose
from .gripper import ParallelGripper
from .pushing import Block, make_way
from .robot_numbers import DriveNumbers, RobotNumbers
from .sonar import Sonar
from .wheel_errors import WheelErrors

ARRIVED = 0.0005
"""How near (m or rad) to its goal a set distance or turn counts as done."""
ENCODERS_ONLY, FUSED, GYRO_ONLY = 0, 1, 2
"""What the heading of a robot that reads its gyro itself is made of (protocol 3.2, GYRO)."""
NO_E_STALL = frozenset(["PSOS", "P2OS", "AmigOS"])
"""Families of firmware whose motors stay on when the STOP button is pressed, until E_STALL says otherwise (protocol 3.6)."""
TRUE_WHEELS = frozenset(["PSOS", "P2OS", "AmigOS", "AROS"])
"""Families whose VEL2 controls each wheel by itself; the others make translation and rotation of it (protocol section 7)."""
BUMPER_DEPTH = 0.02
"""How far (m) the bumper segments stand out from the body."""

SETTINGS = dict(
    rotation_kp=40, rotation_kv=20, rotation_ki=0, translation_kp=40, translation_kv=30, translation_ki=0, drift_factor=0, rev_count=16570,
    gyro_cw=0, gyro_ccw=0, aux1_baud=0, aux2_baud=0, aux3_baud=0,
)
"""What a client may set besides limits, as at power-on, by its name in CONFIGpac; ``ticks_per_mm`` is among the simulator's numbers."""


class Hardware:
    """One robot standing in a world.

    :param model: its model (`RobotModel`), arrays that are not fitted already taken out.
    :param world: the `World` it stands in.
    :param pose: where (x, y, heading; map frame).
    :param gripper: whether it has one.
    :param numbers: the simulator's numbers.
    :param noise: of the sonar ranges (m).
    :param seed: of that noise, and of the wheels' slip and noise.
    :raises ParameterError: the model cannot carry a gripper, or the robot does not fit where it is to stand.
    """

    def __init__(self, model: RobotModel, world, pose: Pose, gripper: bool, numbers: RobotNumbers, noise: float, seed: int):
        if gripper and not model.can_carry_gripper:
            raise ParameterError("the model %s cannot carry a gripper: leave it out or choose another model" % model.subtype)
        self.model = model
        self.world = world
        self._numbers = numbers
        self._block = Block(-model.length_rear, model.length_front, -model.width / 2.0, model.width / 2.0)
        self.body = Body(world, model.outline(gripper), pose, model.outline())
        if self.body.touches(model.outline(gripper)):
            x, y, _ = pose
            raise ParameterError(
                "the %s would stand in a wall, a post or another robot at x %g, y %g of the world %r:"
                " choose another world, place or model" % (model.subtype, x, y, world.name))
        self.gripper: Optional[ParallelGripper] = None
        if gripper:
            self.gripper = ParallelGripper(model.gripper, numbers.gripper, world, model.length_front, self._block)
        self.sonar = Sonar(model.sonar, numbers.sonar, world, noise, seed, self.body)
        self._wheel_errors = WheelErrors(numbers.wheels, 1000.0 * model.diff_rad_per_mm, seed)
        self.battery = BatteryPack(numbers.battery, model.battery_class)
        self.motors_enabled = False
        self.held = False
        """Whether something holds the wheels, so that they stall when driven."""
        self.charger = False
        """Whether a charger is plugged in."""
        self.gyro_drift = 0.0
        """How much faster (rad/s, + counter-clockwise) the gyro turns than the robot does."""
        self.on_power_up: Callable[[], None] = lambda: None
        """What the firmware does when the power comes back."""
        self._stop_button = False
        self.gyro_kind: int = numbers.gyro.kind
        """As CONFIGpac says it: 0 none, 1 read by the client, 2 by the robot."""
        self.gyro = RateGyro(numbers.gyro) if self.gyro_kind == 1 else None
        self.has_compass = numbers.compass.fitted
        self.joystick: Optional[JoystickState] = None
        """What is plugged in to drive by hand."""
        self.aux = (AuxPort(), AuxPort(), AuxPort())
        """Auxiliary serial ports 1, 2 and 3."""
        self.analog_volts: List[float] = [0.0] * 8
        """What is on the analog inputs, 0 to 5 V."""
        self._wheels: Optional[Tuple[Channel, Channel]] = None
        self.digital_out = 0
        self._left_mm = 0.0
        self._right_mm = 0.0
        self.left_stalled = False
        self.right_stalled = False
        self._pressed_s = 0.0
        self._rest_s = 0.0
        linear, angular = limits_of(numbers.drive, model)
        self.linear = Channel(linear, ARRIVED)
        self.angular = Channel(angular, ARRIVED)
        self.reset_parameters()
        self.reset_odometry()

    def power_cycle(self) -> None:
        """Off and on again: as `restart`, and the firmware has to boot."""
        self.restart()
        self.on_power_up()

    def restart(self) -> None:
        """Motors off, everything as after power-on but for what has a place in the world: body, gripper, battery, cans."""
        self.disable_motors()
        self.linear.speed = self.angular.speed = 0.0
        self._left_mm = self._right_mm = 0.0
        self._pressed_s = self._rest_s = 0.0
        self.left_stalled = self.right_stalled = False
        self.digital_out = 0
        self.battery.pretend(0.0)
        self.sonar.switch(False, 0)
        if self.gripper is not None:
            self.gripper.stop()
            self.gripper.lift_stop()
        self.reset_parameters()
        self.reset_odometry()

    def reset_parameters(self) -> None:
        """Limits, sonar sequence and safety settings as they are at power-on."""
        self.linear.limits, self.angular.limits = limits_of(self._numbers.drive, self.model)
        self.settings = dict(SETTINGS, ticks_per_mm=self._numbers.drive.encoder_ticks_per_mm)
        self.sonar.reset()
        self.stop_button_stalls = self.model.firmware_family not in NO_E_STALL
        self.joystick_drives = self._joystick_drove = False
        self.gyro_mode = FUSED
        self.compass_on = True
        self.sounds_on = True
        self.docking = False
        self.stops_when_docked = False
        for port in self.aux:
            port.reset()
        self.bump_stall_front = True
        self.bump_stall_rear = True
        self.analog_port = 5

    # -- odometry

    def reset_odometry(self) -> None:
        """The present pose becomes the origin of the odometry: the pose (m, rad; heading not wrapped) as the robot adds it up from then on."""
        self.origin = self.body.pose
        self._heading = Heading()
        self.odometry: Pose = (0.0, 0.0, 0.0)

    @property
    def heading_goal(self) -> float:
        """The heading (rad, odometry) the robot is turning to; its heading while it is not turning to one."""
        return self.odometry[2] + (self.angular.remaining or 0.0)

    @property
    def wheel_speeds(self) -> Tuple[float, float]:
        """Speeds (m/s) of the left and the right wheels."""
        difference = self.angular.speed / self.model.diff_rad_per_mm / 1000.0
        return self.linear.speed - difference, self.linear.speed + difference

    @property
    def wheel_ticks(self) -> Tuple[int, int]:
        """Encoder ticks of the left and the right wheels since power-on."""
        per_mm = self._numbers.drive.encoder_ticks_per_mm
        return round(self._left_mm * per_mm), round(self._right_mm * per_mm)

    # -- driving

    def turn_wheels(self, left: float, right: float) -> None:
        """Turn the left and the right wheels at these speeds (m/s), until `leave_wheels`."""
        if self.model.firmware_family in TRUE_WHEELS:
            if self._wheels is None:
                self._wheels = (self._wheel(self.wheel_speeds[0]), self._wheel(self.wheel_speeds[1]))
            for wheel, speed in zip(self._wheels, (left, right)):
                wheel.limits = self._wheel_limits()
                wheel.set_speed(speed)
        else:
            self.linear.set_speed((left + right) / 2.0)
            self.angular.set_speed((right - left) / 2.0 * 1000.0 * self.model.diff_rad_per_mm)

    def leave_wheels(self) -> None:
        """Translation and rotation are controlled again, from what the wheels do."""
        self._wheels = None

    def _wheel(self, speed: float) -> Channel:
        wheel = Channel(self._wheel_limits(), ARRIVED)
        wheel.speed = speed
        return wheel

    def _wheel_limits(self) -> Limits:
        return replace(self.linear.limits, limit=self.linear.limits.top, back_limit=None)

    # -- motors

    def enable_motors(self) -> None:
        """Switch the motors on, unless a pressed STOP button or an empty battery forbids it."""
        if not self.e_stalled and not self.battery.is_empty:
            self.motors_enabled = True

    def disable_motors(self) -> None:
        """Take the power from the motors; set points are forgotten."""
        self.motors_enabled = False
        self._wheels = None
        self.linear.emergency_stop()
        self.angular.emergency_stop()

    def press_motors_button(self) -> None:
        """Press the MOTORS button: it switches the motors on, if they may be, or off."""
        if self.motors_enabled:
            self.disable_motors()
        else:
            self.enable_motors()

    @property
    def stop_button(self) -> bool:
        """Whether the STOP button is pressed. Pressing it takes the power from the motors, letting it go does not give it back."""
        return self._stop_button

    @stop_button.setter
    def stop_button(self, pressed: bool) -> None:
        self._stop_button = pressed
        if self.e_stalled:
            self.disable_motors()

    def set_stop_button_stalls(self, stalls: bool) -> None:
        """Whether the STOP button takes the power from the motors, from now on and if it is pressed already."""
        self.stop_button_stalls = stalls
        if self.e_stalled:
            self.disable_motors()

    @property
    def e_stalled(self) -> bool:
        """Whether the STOP button keeps the motors off."""
        return self.stop_button and self.stop_button_stalls

    @property
    def dead_transducers(self) -> Set[int]:
        """Numbers (from 0) of the sonar transducers that hear nothing."""
        return self.sonar.dead

    @dead_transducers.setter
    def dead_transducers(self, numbers: Set[int]) -> None:
        self.sonar.dead = set(numbers)

    @property
    def gripper_stuck(self) -> bool:
        """Whether something keeps the gripper from moving; without one, never."""
        return self.gripper is not None and self.gripper.stuck

    @gripper_stuck.setter
    def gripper_stuck(self, stuck: bool) -> None:
        if self.gripper is not None:
            self.gripper.stuck = stuck

    @property
    def moving(self) -> bool:
        """Whether the robot moves."""
        return self.linear.speed != 0.0 or self.angular.speed != 0.0

    # -- time

    def step(self, now_us: int, paused: bool) -> None:
        """Advance one physics step, which ends at `now_us`. `paused`: the watchdog keeps the drives at zero."""
        step_us = self._numbers.physics.step_us
        dt = step_us * 1e-6
        heading = self.body.pose[2]
        if self.joystick is not None or self._joystick_drove:
            self._drive_by_hand()
        if self.motors_enabled and self.battery.is_empty:
            self.disable_motors()
        if self._rest_s > 0.0:
            self._rest(dt)
        elif self.linear.driven or self.angular.driven or self._pressed_s or self._wheels:
            self._drive(dt, paused)
        elif self.gyro_drift and self.gyro_kind == 2 and self.gyro_mode == GYRO_ONLY:
            self.odometry = along_arc(self.odometry, 0.0, self.gyro_drift * dt)
        if self.gripper is not None:
            self.gripper.step(dt, self.body.pose)
        if self.gyro is not None:
            self.gyro.step(now_us, step_us, self.body.pose[2] - heading + self.gyro_drift * dt)
        self.sonar.step(now_us, self.body.pose)
        self._charge()
        self.battery.step(step_us, self.moving)

    def _charge(self) -> None:
        """See whether a charger feeds the battery: one that is plugged in, or a dock of the world that it stands in and asks for power."""
        charging = self.charger
        if self.docking and not charging:
            numbers = self._numbers.battery
            charging = dock_at(self.body.pose, self.world.docks, numbers.dock_distance, math.radians(numbers.dock_angle_deg)) is not None
        if charging and not self.battery.charging and self.stops_when_docked:
            self.linear.set_speed(0.0)
            self.angular.set_speed(0.0)
            self.leave_wheels()
        self.battery.charging = charging

    def _drive_by_hand(self) -> None:
        """While its first button is pressed a joystick drives; let go, the robot stops."""
        pressed = self.joystick is not None and self.joystick.button_1 and self.joystick_drives and self.motors_enabled
        if pressed or self._joystick_drove:
            numbers = self._numbers.joystick
            forward, leftward = (self.joystick.forward, self.joystick.leftward) if pressed else (0.0, 0.0)
            self.leave_wheels()
            self.linear.set_speed(forward * numbers.linear_mm_s / 1000.0)
            self.angular.set_speed(leftward * math.radians(numbers.angular_deg_s))
        self._joystick_drove = pressed

    def _step_drives(self, dt: float, paused: bool) -> Tuple[float, float]:
        """Distance and turn of a step, as the drives would have it."""
        if self._wheels is None:
            return self.linear.step(dt, paused), self.angular.step(dt, paused)
        left, right = (wheel.step(dt, paused) for wheel in self._wheels)
        per_metre = 1000.0 * self.model.diff_rad_per_mm
        self.linear.speed = (self._wheels[0].speed + self._wheels[1].speed) / 2.0
        self.angular.speed = (self._wheels[1].speed - self._wheels[0].speed) / 2.0 * per_metre
        return (left + right) / 2.0, (right - left) / 2.0 * per_metre

    def _drive(self, dt: float, paused: bool) -> None:
        distance, turn = self._step_drives(dt, paused)
        turned = self._turned(distance, turn)
        if abs(turned[0]) > self.model.max_linear * dt or abs(turned[1]) > self.model.max_angular * dt:
            distance, turn = self._slowed(distance, turn, turned, dt)
            turned = self._turned(distance, turn)
        really = self._wheel_errors.moved(*turned)
        if not distance and not turn:
            self.body.blocked = False
            self._pressed_s = 0.0
        elif not self.held and self._moved(*really):
            self._pressed_s = 0.0
            self.odometry = along_arc(self.odometry, distance, self._felt(turn, really[1], dt), self._heading.unit)
            self._count_wheels(*turned)
        else:
            self.linear.blocked(distance)
            self.angular.blocked(turn)
            for wheel in self._wheels or ():
                wheel.blocked(0.0)
            self._pressed_s += dt
            if self._pressed_s >= self._numbers.drive.stall_time - 1e-9 or self._bumped(distance):
                self._stall(distance, turn)

    def _turned(self, distance: float, turn: float) -> Tuple[float, float]:
        """How far the wheels turn when the firmware, which counts ticks of the encoders, takes it for `distance` and `turn`."""
        return (
            distance * self.settings["ticks_per_mm"] / self._numbers.drive.encoder_ticks_per_mm,
            turn * self.settings["rev_count"] / SETTINGS["rev_count"],
        )

    def _slowed(self, distance: float, turn: float, turned: Tuple[float, float], dt: float) -> Tuple[float, float]:
        """As much of `distance` and `turn` as the motors can do in a step, whatever calibration makes `turned` of them."""
        ahead, round_ = self.model.max_linear * dt, self.model.max_angular * dt
        return distance * min(1.0, ahead / (abs(turned[0]) or ahead)), turn * min(1.0, round_ / (abs(turned[1]) or round_))

    def _felt(self, turn: float, really: float, dt: float) -> float:
        """The turn of a step as the robot adds it up: by its wheels, or by a gyro that it reads itself."""
        if self.gyro_kind == 2 and self.gyro_mode != ENCODERS_ONLY:
            return really + self.gyro_drift * dt
        return turn

    def _moved(self, distance: float, turn: float) -> bool:
        """Move the body, pushing cans aside; False when walls or a jammed can keep it where it is."""
        before = self.body.pose
        if not self.body.move(distance, turn):
            return False
        if self._make_way(self.body.pose):
            return True
        self.body.place(before)
        self._make_way(before)
        return False

    def _make_way(self, pose: Pose) -> bool:
        if not self.world.cans:
            return True
        if self.gripper is not None:
            return self.gripper.make_way(pose)
        return make_way(self.world, pose, lambda radius: (self._block,), (), self._block.reach)

    def _count_wheels(self, distance: float, turn: float) -> None:
        difference_mm = turn / self.model.diff_rad_per_mm
        self._left_mm += distance * 1000.0 - difference_mm
        self._right_mm += distance * 1000.0 + difference_mm

    def _stall(self, distance: float, turn: float) -> None:
        """The drives give up for a moment, and report which wheels they could not turn."""
        difference = turn / self.model.diff_rad_per_mm / 1000.0
        self.left_stalled = distance - difference != 0.0
        self.right_stalled = distance + difference != 0.0
        self._pressed_s = 0.0
        self._rest_s = self._numbers.drive.stall_recovery

    def _rest(self, dt: float) -> None:
        self._rest_s -= dt
        if self._rest_s <= 1e-9:
            self._rest_s = 0.0
            self.left_stalled = self.right_stalled = False

    # -- bumpers

    def bumper_bits(self) -> Tuple[int, int]:
        """Pressed segments of the front and of the rear bumper; bit 0 is the left one in front, the right one behind."""
        return self._pressed(self.model.front_bumpers, True), self._pressed(self.model.rear_bumpers, False)

    def _pressed(self, count: int, front: bool) -> int:
        if not count or not self.body.blocked:
            return 0
        width = self.model.width / count
        near, far = (self.model.length_front, self.model.length_front + BUMPER_DEPTH) if front else (
            -self.model.length_rear, -self.model.length_rear - BUMPER_DEPTH)
        side = 1.0 if front else -1.0
        bits = 0
        for segment in range(count):
            left = side * (self.model.width / 2.0 - segment * width)
            right = left - side * width
            if self.body.touches(((near, left), (near, right), (far, right), (far, left))):
                bits |= 1 << segment
        return bits

    def _bumped(self, distance: float) -> bool:
        """Whether a bumper that stalls the wheels is pressed on the side that the robot drives to."""
        front, rear = self.bumper_bits()
        if distance > 0.0:
            return self.bump_stall_front and front != 0
        return distance < 0.0 and self.bump_stall_rear and rear != 0


def limits_of(numbers: DriveNumbers, model: RobotModel) -> Tuple[Limits, Limits]:
    """Limits of translation (m/s, m/s^2) and of rotation (rad/s, rad/s^2) at power-on."""
    linear_top = min(numbers.linear_top_mm_s / 1000.0, model.max_linear)
    angular_top = min(math.radians(numbers.angular_top_deg_s), model.max_angular)
    return (
        Limits(
            limit=min(numbers.linear_limit_mm_s / 1000.0, linear_top),
            top=linear_top,
            rise=numbers.linear_acceleration_mm_s2 / 1000.0,
            fall=numbers.linear_deceleration_mm_s2 / 1000.0,
            rate_top=numbers.linear_acceleration_top_mm_s2 / 1000.0,
        ),
        Limits(
            limit=min(math.radians(numbers.angular_limit_deg_s), angular_top),
            top=angular_top,
            rise=math.radians(numbers.angular_acceleration_deg_s2),
            fall=math.radians(numbers.angular_deceleration_deg_s2),
            rate_top=math.radians(numbers.angular_acceleration_top_deg_s2),
        ),
    )

"""The robot below its firmware: all its devices, moved together in fixed steps.

SI units; knows no packets. `Hardware.step` is the only place where simulated time passes for them.
"""

from typing import List, Optional, Protocol

from ...errors import ParameterError
from ...robots import RobotModel
from ..world.poses import Pose
from ..world.world import World
from .accessories import GYRO_OF_CLIENT, AuxPort, Compass, JoystickDrive, JoystickState, RateGyro, UserPorts
from .battery import BatteryPack, Charger
from .body import Body, BumperRing
from .drives import Drives, MotorPower, Stall
from .gripper import ParallelGripper
from .robot_numbers import RobotNumbers
from .sonar import Sonar
from .wheels import DeadReckoning, WheelErrors, Wheels


class Device(Protocol):
    """Something with parameters that a client may change."""

    def reset(self) -> None:
        """Take the parameters of power-on."""


class Hardware:
    """One robot standing in a world.

    Args:
        model: its model, arrays that are not fitted already taken out.
        world: where it stands.
        pose: x, y, heading (m, rad; map frame).
        gripper: whether it has one.
        numbers: the simulator's numbers.
        noise: of the sonar ranges (m).
        seed: of that noise, and of the wheels' slip and noise.

    Attributes:
        gripper: None without one.
        model: as the argument.
        joystick: what is plugged in to drive by hand, None at first.
        aux: auxiliary serial ports 1, 2 and 3.

    Raises:
        ParameterError: the model cannot carry a gripper, or the robot does not fit where it is to stand.
    """

    def __init__(
        self, model: RobotModel, world: World, pose: Pose, gripper: bool, numbers: RobotNumbers,
        noise: float, seed: int,
    ):
        if gripper and not model.can_carry_gripper:
            raise ParameterError("the model %s cannot carry a gripper: leave it out or choose another model"
                                 % model.subtype)
        self.body = Body(world, model.outline(gripper), pose, model.outline())
        if self.body.touches(model.outline(gripper)):
            raise ParameterError(
                "the %s would stand in a wall, a post or another robot at x %g, y %g of the world %r:"
                " choose another world, place or model" % (model.subtype, pose[0], pose[1], world.name))
        self.gripper = ParallelGripper(
            model.gripper, numbers.gripper, world, model.length_front, self.body.box) if gripper else None
        self.sonar = Sonar(model.sonar, numbers.sonar, world, noise, seed, self.body)
        self.battery = BatteryPack(numbers.battery, model.battery_class)
        self.charger = Charger(numbers.battery, world.docks)
        self.drives = Drives(model, numbers.drive)
        self.motors = MotorPower(self.drives, self.battery, model.firmware_family)
        self.stall = Stall(numbers.drive)
        self.wheels = Wheels(model, numbers.drive.encoder_ticks_per_mm)
        self.bumpers = BumperRing(model, self.body)
        self.reset_odometry()
        self.gyro = RateGyro(numbers.gyro)
        self.compass = Compass(numbers.compass)
        self.joystick: Optional[JoystickState] = None
        self.ports = UserPorts()
        self.aux = (AuxPort(), AuxPort(), AuxPort())
        self._joystick_drive = JoystickDrive(numbers.joystick, self.drives)
        self._wheel_errors = WheelErrors(numbers.wheels, 1000.0 * model.diff_rad_per_mm, seed)
        self._step_us = numbers.physics.step_us
        self.model = model

    def restart(self) -> None:
        """Restart as at power-on, motors off. Body, gripper, battery and cans stay as they are."""
        self.motors.disable()
        self.drives.restart()
        self.stall.clear()
        self.wheels.restart()
        self.ports.digital_out = 0
        self.battery.pretend(0.0)
        self.sonar.switch(False, 0)
        if self.gripper is not None:
            self.gripper.halt()
        self.reset_parameters()
        self.reset_odometry()

    def reset_parameters(self) -> None:
        """Set limits, calibration, sonar sequence, safety settings and modes to those of power-on."""
        devices: List[Device] = [
            self.drives, self.motors, self.wheels, self.bumpers, self.sonar, self.gyro, self.compass, self.charger,
            self._joystick_drive, self.ports, *self.aux]
        for device in devices:
            device.reset()

    def reset_odometry(self) -> None:
        """Make the present pose the origin of the odometry."""
        self.odometry = DeadReckoning(self.body.pose)

    @property
    def heading_goal(self) -> float:
        """The heading (rad, odometry) the robot is turning to; its heading while it is not turning to one."""
        return self.odometry.pose[2] + (self.drives.angular.remaining or 0.0)

    def allow_joystick(self, allowed: bool) -> None:
        """Let a joystick drive the robot, or not."""
        self._joystick_drive.allowed = allowed

    def jam_gripper(self, stuck: bool) -> None:
        """Keep the gripper, if there is one, from moving, or let it move again."""
        if self.gripper is not None:
            self.gripper.stuck = stuck

    # -- time

    def step(self, now_us: int, paused: bool) -> None:
        """Advance one physics step, which ends at `now_us`. `paused`: the watchdog keeps the drives at zero."""
        dt = self._step_us * 1e-6
        heading = self.body.pose[2]
        if self.joystick is not None or self._joystick_drive.drove:
            self._joystick_drive.step(self.joystick, self.motors.enabled)
        if self.motors.enabled and self.battery.is_empty:
            self.motors.disable()
        if self.stall.rest_s > 0.0:
            self.stall.rest(dt)
        elif self.drives.driven or self.stall.pressed_s > 0.0:
            self._drive(dt, paused)
        elif self.gyro.turns_alone:
            self.odometry.add(0.0, self.gyro.drift * dt)
        if self.gripper is not None:
            self.gripper.step(dt, self.body.pose)
        if self.gyro.kind == GYRO_OF_CLIENT:
            self.gyro.step(now_us, self._step_us, self.body.pose[2] - heading)
        self.sonar.step(now_us, self.body.pose)
        if self.charger.plugged_in or self.charger.asks_dock or self.battery.charging:
            self._charge()
        self.battery.step(self._step_us, self.drives.moving)

    def _drive(self, dt: float, paused: bool) -> None:
        """Let the drives turn the wheels, unless something holds them or stands in the way."""
        (distance, turn), turned = self.wheels.turn(*self.drives.step(dt, paused), dt)
        really = self._wheel_errors.moved(*turned)
        if not distance and not turn:
            self.body.blocked = False
            self.stall.pressed_s = 0.0
        elif not self.stall.held and self._move(*really):
            self.stall.pressed_s = 0.0
            self.odometry.add(distance, self.gyro.heading_change(turn, really[1], dt))
            self.wheels.count(*turned)
        else:
            self.drives.blocked(distance, turn)
            difference = turn / self.model.diff_rad_per_mm / 1000.0
            left, right = distance - difference, distance + difference
            self.stall.press(dt, self.bumpers.stall(distance), left != 0.0, right != 0.0)

    def _move(self, distance: float, turn: float) -> bool:
        """Move the body, pushing cans aside; False when walls or a jammed can keep it where it is."""
        before = self.body.pose
        if not self.body.move(distance, turn):
            return False
        pusher = self.gripper or self.body
        if pusher.make_way(self.body.pose):
            return True
        self.body.place(before)
        pusher.make_way(before)
        return False

    def _charge(self) -> None:
        """Let a charger feed the battery. The robot stops in a dock where it was told to."""
        charging = self.charger.feeds(self.body.pose)
        if charging and not self.battery.charging and self.charger.stops_in_dock:
            self.drives.set_speeds(0.0, 0.0)
        self.battery.charging = charging

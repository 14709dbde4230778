"""The hardware of one simulated robot, without its firmware: all devices, which move together in fixed time steps.

All values are in SI units. This file does not depend on packets. Only `Hardware.step` lets simulated time pass for the
devices.
"""

from typing import Optional

from ...errors import ParameterError
from ...robots import RobotModel
from ..world.poses import Pose
from ..world.world import World
from .accessories import GYRO_OF_CLIENT, AuxPort, Compass, JoystickDrive, JoystickState, RateGyro, UserPorts
from .arm import PioneerArm
from .battery import BatteryPack, Charger
from .body import Body, BumperRing
from .camera import SimulatedCamera
from .drives import Drives, MotorPower, Stall
from .gripper import ParallelGripper
from .robot_numbers import ArmNumbers, RobotNumbers
from .sonar import Sonar
from .wheels import DeadReckoning, WheelErrors, Wheels


class Hardware:
    """All hardware of one robot in a world.

    Args:
        model: model of the robot, without the sonar arrays that are not fitted.
        world: world in which the robot stands.
        pose: start pose (m, rad; map frame).
        gripper: whether the robot has a gripper.
        numbers: parameters of the simulated robot.
        noise: largest random error of a sonar range (m).
        seed: seed of the sonar noise, and of the wheels' slip and noise.

    Attributes:
        gripper: the gripper. None if the robot has no gripper.
        model: as the argument.
        joystick: state of the joystick that is plugged into the robot. None if there is no joystick.
        aux: auxiliary serial ports 1, 2 and 3.

    Raises:
        ParameterError: the model cannot carry a gripper, or the robot would overlap an obstacle at its start pose.
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
        """Restart the robot as at power-on, with motors off. Its pose, gripper, cans and battery charge do not change.
        """
        self.motors.disable()
        self.drives.restart()
        self.stall.clear()
        self.wheels.restart()
        self.ports.digital_out = 0
        self.battery.pretend(0.0)
        self.sonar.switch(False, 0)
        if self.gripper is not None:
            self.gripper.halt()
        for port in self.aux:
            if port.joined is not None:
                port.joined.restart()
        self.reset_parameters()
        self.reset_odometry()

    def reset_parameters(self) -> None:
        """Set limits, calibration, sonar sequence, safety settings and modes to their power-on values."""
        for reset in (
                self.drives.reset, self.motors.reset, self.wheels.reset, self.bumpers.reset, self.sonar.reset,
                self.gyro.reset, self.compass.reset, self.charger.reset, self._joystick_drive.reset, self.ports.reset,
                *(port.reset for port in self.aux)):
            reset()

    def reset_odometry(self) -> None:
        """Make the present pose the origin of the odometry."""
        self.odometry = DeadReckoning(self.body.pose)

    def carry(self, pose: Pose) -> None:
        """Put the robot at `pose` (m, rad; map frame), as if a person carried it there. Held cans come along.

        It stands there, and all set points are dropped. The pose of its odometry stays as it is.
        """
        self.body.carry(pose)
        self.odometry.carry(pose)
        self.drives.emergency_stop()
        self.drives.restart()
        self.stall.clear()
        if self.gripper is not None:
            self.gripper.carry(pose)

    def touched_by_person(self) -> None:
        """Count that a person walked into the robot: as a contact of the robot while it moves, else apart."""
        if self.drives.moving:
            self.body.contacts += 1
        else:
            self.body.touched_by_people += 1

    @property
    def heading_goal(self) -> float:
        """The heading (rad, odometry frame) to which the robot turns. Its present heading while it has no such goal."""
        return self.odometry.pose[2] + (self.drives.angular.remaining or 0.0)

    @property
    def arm(self) -> Optional[PioneerArm]:
        """The arm. None if the robot has no arm."""
        return next((port.joined for port in self.aux if isinstance(port.joined, PioneerArm)), None)

    def join_arm(self, numbers: ArmNumbers) -> None:
        """Fit an arm. Raises ParameterError when there is a device at its auxiliary port already."""
        self.aux[numbers.aux - 1].join(PioneerArm(numbers), numbers.aux)

    def switch_arm(self, on: bool) -> None:
        """Turn the switch of the arm on or off. Without an arm, do nothing."""
        if self.arm is not None:
            self.arm.switch(on)

    def supply_camera(self, on: bool) -> None:
        """Give a camera at an auxiliary port power, or none. Without such a camera, do nothing."""
        for port in self.aux:
            if isinstance(port.joined, SimulatedCamera):
                port.joined.supply(on)

    def allow_joystick(self, allowed: bool) -> None:
        """Set whether a joystick may drive the robot."""
        self._joystick_drive.allowed = allowed

    def jam_gripper(self, stuck: bool) -> None:
        """Block the gripper if `stuck`, or let it move again. Without a gripper, do nothing."""
        if self.gripper is not None:
            self.gripper.stuck = stuck

    # -- time

    def step(self, now_us: int, paused: bool) -> None:
        """Advance all devices by one physics step.

        Args:
            now_us: simulated time at the end of the step (microseconds).
            paused: whether the watchdog keeps the drives at speed zero.
        """
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
        for port in self.aux:
            if port.joined is not None:
                port.joined.step(now_us)

    def _drive(self, dt: float, paused: bool) -> None:
        """Drive for `dt` seconds. If the wheels are held or an obstacle blocks the robot, let the wheels press instead.

        `paused` is whether the watchdog keeps the drives at speed zero.
        """
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
        """Move the body by a distance (m) and a turn (rad), and push cans out of its way.

        Returns:
            False when an obstacle or a jammed can keeps the body at its place.
        """
        before = self.body.pose
        if not self.body.move(distance, turn):
            return False
        pusher = self.gripper or self.body
        if pusher.make_way(self.body.pose):
            self.body.driven += abs(distance)
            return True
        self.body.place(before)
        pusher.make_way(before)
        return False

    def _charge(self) -> None:
        """Update whether the battery is charged. If charging starts and `Charger.stops_in_dock`, stop the robot."""
        charging = self.charger.feeds(self.body.pose)
        if charging and not self.battery.charging and self.charger.stops_in_dock:
            self.drives.set_speeds(0.0, 0.0)
        self.battery.charging = charging

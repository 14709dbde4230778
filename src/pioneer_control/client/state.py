"""Turns one SIP into one RobotState: converts the units of the packet to SI units."""

import math
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from .. import p2os
from ..p2os import Flags
from ..wire_fields import made
from .gripper import GripperReading, read_gripper, read_pioneer_1_gripper
from .identity import RobotIdentity
from .odometry import Odometry

NO_TEMPERATURE = (-128, -127)
NO_ECHO = 5.0           # m: the range that the firmware reports when there is no echo
LARGEST_COMPASS = 180   # units of 2 degrees; 0 and what is larger mean that there is no compass
ARRAYS = Flags.SONAR_1 | Flags.SONAR_2 | Flags.SONAR_3 | Flags.SONAR_4
STATUS = itemgetter(
    "flags", "left_stall_bits", "right_stall_bits", "battery_dv", "battery_x10_dv", "compass", "grip_state",
    "digital_in", "digital_out", "analog_port",
    "charge_state", "fault_flags", "temperature_c", "state_of_charge_percent")
"""Gets the fields of a SIP that rarely change: no position, no velocity, no sonar."""


class SonarRange(NamedTuple):
    """The newest reading of one sonar: its range (m; NO_ECHO without an echo), and when it arrived (monotonic, s)."""

    range: float
    time: float


@dataclass(frozen=True)
class RobotState:
    """Everything that the robot reported in one SIP, in SI units, with one stamp.

    The pose is in the odometry frame. Velocities are in base_link (REP 103: x forward, y left, counter-clockwise
    positive). A field that older firmware does not send is None.
    """

    time: float
    """Monotonic time (s) at which the whole packet had arrived."""
    sent_time: float
    """Monotonic time (s) at which the robot began to send the packet: ``time`` minus the time that the serial line took
    to carry it. On TCP it is the same as ``time``.
    """
    x: float
    """m, in the odometry frame."""
    y: float
    """m, in the odometry frame."""
    heading: float
    """rad, -pi..pi, counter-clockwise positive, in the odometry frame."""
    linear: float
    """Measured velocity, m/s, forward positive."""
    angular: float
    """Measured turn rate, rad/s, counter-clockwise positive."""
    wheel_velocities: Tuple[float, float]
    """Measured velocities of left and right wheel, m/s, forward positive."""
    wheel_angles: Optional[Tuple[float, float]]
    """Angles of left and right wheel since the first packet, rad, forward positive. None for a model whose wheel radius
    is not known.
    """
    x_counts: int
    """Exact sum of all steps of the robot's own x since the first packet, in the robot's units."""
    y_counts: int
    motors_enabled: bool
    stop_button: bool
    left_stall: bool
    right_stall: bool
    front_bumpers: Tuple[bool, ...]
    """Whether each bumper segment is pressed, in the order of the bits. ARIA counts them from the left."""
    rear_bumpers: Tuple[bool, ...]
    battery_voltage: float
    """Real voltage (V): about 25 V on a robot with 24 V."""
    sonar: Tuple[Optional[SonarRange], ...]
    """The newest readings, by sonar number; None for a sonar without any reading yet."""
    sonar_enabled: bool
    gripper: Optional[GripperReading]
    """None when the robot has no gripper."""
    digital_in: Optional[int]
    digital_out: Optional[int]
    analog_port: Optional[int]
    analog_voltage: Optional[float]
    """Voltage of the analog input, 0..5 V."""
    flags: p2os.Flags
    fault_flags: Optional[p2os.FaultFlags]
    compass: Optional[float]
    """Heading of the compass in steps of 2 degrees (rad, 0..2 pi, its own sense of rotation). None without a compass.
    """
    charge_state: Optional[int]
    temperature: Optional[float]
    """Degrees Celsius; None when the robot does not report it."""
    state_of_charge: Optional[float]
    """Charge of the battery, 0..1; None when the robot does not report it."""

    @property
    def moving(self) -> bool:
        """Whether the robot reports a velocity other than zero."""
        return bool(self.linear or self.angular)


class StateReader:
    """Turns the SIPs of one robot into states. It keeps the odometry and older sonar readings, which no SIP has."""

    def __init__(self, identity: RobotIdentity, odometry: Odometry) -> None:
        self.odometry = odometry
        self.unknown_sonar = 0
        """Number of sonar readings with a number that the model does not have."""
        self._sonar: List[Optional[SonarRange]] = []
        self._read_at = -math.inf
        self.follow(identity)

    def follow(self, identity: RobotIdentity) -> None:
        """Use a new identity of the robot.

        The list of sonar readings never becomes shorter, because a listener may still have the old model with more
        sonars.
        """
        self.identity = identity
        self._sonar += [None] * (identity.model.sonar_count - len(self._sonar))
        self._mm_per_range_unit = identity.model.range_mm_per_unit
        self._fitted = frozenset(transducer.number for transducer in identity.model.sonar)
        self._said: Optional[Tuple[Any, ...]] = None
        self._status: Dict[str, Any] = {}

    def read(self, sip: p2os.Sip, time: float, sent_time: float) -> Optional[RobotState]:
        """Return the state after this SIP; None for a SIP with an impossible position (see Odometry.update).

        Call it once for each SIP, in order.

        Args:
            sip: the next SIP.
            time: when the whole SIP had arrived (monotonic, s).
            sent_time: when the robot began to send it (monotonic, s).
        """
        odometry, model = self.odometry, self.identity.model
        if not odometry.update(sip.x_counts, sip.y_counts, sip.heading_units, time - self._read_at):
            return None
        self._read_at = time
        self._take_sonar(sip, time)
        said = STATUS(vars(sip))
        if said != self._said:      # rarely
            self._said, self._status = said, self._read_status(sip)
        x, y, heading = odometry.pose
        m_s_per_unit = model.vel_mm_s_per_unit / 1000
        left, right = sip.left_velocity_units * m_s_per_unit, sip.right_velocity_units * m_s_per_unit
        # Firmware without ROTVEL: calculate the turn rate from the difference of the wheels.
        if sip.rotation_velocity_ddeg_s is None:
            angular = (right - left) / 2 * 1000 * model.diff_rad_per_mm
        else:
            angular = math.radians(sip.rotation_velocity_ddeg_s / 10)
        linear = (left + right) / 2
        angular = angular * model.turn_factor + linear * model.curve_rad_per_m
        state: RobotState = made(RobotState, {
            **self._status,
            "time": time,
            "sent_time": sent_time,
            "x": x,
            "y": y,
            "heading": heading,
            "linear": linear,
            "angular": angular,
            "wheel_velocities": (left, right),
            "wheel_angles": self._wheel_angles(),
            "x_counts": odometry.x_counts,
            "y_counts": odometry.y_counts,
            "sonar": tuple(self._sonar),
            "analog_voltage": None if sip.analog is None else sip.analog * 5 / 255,
        })
        return state

    def _read_status(self, sip: p2os.Sip) -> Dict[str, Any]:
        """Return the fields of a RobotState that are nearly always the same as in the previous SIP."""
        model, flags, faults = self.identity.model, p2os.Flags(sip.flags), sip.fault_flags
        return dict(
            motors_enabled=bool(flags & p2os.Flags.MOTORS_ENABLED),
            stop_button=bool(flags & p2os.Flags.STOP_BUTTON),
            left_stall=bool(sip.left_stall_bits & 1),
            right_stall=bool(sip.right_stall_bits & 1),
            front_bumpers=_segments(sip.right_stall_bits, model.front_bumpers),
            rear_bumpers=_segments(sip.left_stall_bits, model.rear_bumpers),
            battery_voltage=_battery(sip, model.battery_class),
            sonar_enabled=bool(flags & ARRAYS),
            gripper=self._gripper(sip),
            digital_in=sip.digital_in,
            digital_out=sip.digital_out,
            analog_port=sip.analog_port,
            flags=flags,
            fault_flags=None if faults is None else p2os.FaultFlags(faults),
            compass=math.radians(2 * sip.compass) if 0 < sip.compass <= LARGEST_COMPASS else None,
            charge_state=sip.charge_state,
            temperature=None if sip.temperature_c is None or sip.temperature_c in NO_TEMPERATURE
            else float(sip.temperature_c),
            state_of_charge=sip.state_of_charge_percent / 100 if sip.state_of_charge_percent else None,
        )

    def _wheel_angles(self) -> Optional[Tuple[float, float]]:
        """Return the angles of left and right wheel (rad), made from the odometry; None without a wheel radius."""
        model, odometry = self.identity.model, self.odometry
        if model.wheel_radius is None:
            return None
        half_difference = odometry.turned / model.diff_rad_per_mm / 1000
        left, right = odometry.travel - half_difference, odometry.travel + half_difference
        return left / model.wheel_radius, right / model.wheel_radius

    def _take_sonar(self, sip: p2os.Sip, time: float) -> None:
        mm_per_unit, fitted, sonar = self._mm_per_range_unit, self._fitted, self._sonar
        for number, range_units in sip.sonar:
            if number in fitted:
                sonar[number] = SonarRange(range_units * mm_per_unit / 1000, time)
            else:
                self.unknown_sonar += 1

    def _gripper(self, sip: p2os.Sip) -> Optional[GripperReading]:
        if not self.identity.has_gripper or sip.grip_state is None or sip.digital_in is None:
            return None
        if self.identity.model.firmware_family == "PSOS":
            return read_pioneer_1_gripper(sip.digital_in)
        return read_gripper(sip.grip_state, sip.digital_in)


def _segments(bits: int, count: int) -> Tuple[bool, ...]:
    """Return whether each of ``count`` bumper segments is pressed. Their bits begin at bit 1; there are seven bits."""
    return tuple(bool(bits & (2 << segment)) for segment in range(min(count, 7)))


def _battery(sip: p2os.Sip, battery_class: int) -> float:
    """Return the real battery voltage (V): BATTERYX10 if the robot sends it, else BATTERY.

    The robot scales BATTERY to a system of 12 V. ``battery_class`` is the nominal voltage of this robot (V).
    """
    if sip.battery_x10_dv:
        return sip.battery_x10_dv / 10
    return sip.battery_dv / 10 * battery_class / 12

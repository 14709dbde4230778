"""From one SIP to one RobotState: the only place where units of the wire become SI."""

import math
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from .. import p2os
from ..p2os import Flags
from ..p2os.fields import made
from .gripper import GripperReading, read_gripper, read_pioneer_1_gripper
from .identity import RobotIdentity
from .odometry import Odometry

NO_TEMPERATURE = (-128, -127)
NO_ECHO = 5.0           # m: what the firmware says for no echo
LARGEST_COMPASS = 180   # units of 2 degrees; 0 and what is larger mean that there is no compass
ARRAYS = Flags.SONAR_1 | Flags.SONAR_2 | Flags.SONAR_3 | Flags.SONAR_4
STATUS = attrgetter(
    "flags", "left_stall_bits", "right_stall_bits", "battery_dv", "battery_x10_dv", "compass", "grip_state",
    "digital_in", "digital_out", "analog_port",
    "charge_state", "fault_flags", "temperature_c", "state_of_charge_percent")
"""What of a SIP says how the robot is, and not where or how fast."""


class SonarRange(NamedTuple):
    """The newest reading of one transducer: range (m; NO_ECHO when nothing is in sight) and monotonic time heard (s).
    """

    range: float
    time: float


@dataclass(frozen=True)
class RobotState:
    """All that the robot reported in one SIP, in SI units; one stamp for all of it. A field that older firmware does
    not send is None.

    Poses are in the odometry frame, velocities in base_link (REP 103: x forward, y left, counter-clockwise positive).
    """

    time: float
    """Monotonic time (s) at which the packet was whole."""
    sent_time: float
    """... at which the robot began to send it: ``time`` without what the serial line took to carry the whole packet; on
    TCP the same as ``time``
    """
    x: float
    """m"""
    y: float
    """m"""
    heading: float
    """rad, -pi..pi"""
    linear: float
    """m/s forward, as measured by the wheels"""
    angular: float
    """rad/s counter-clockwise"""
    wheel_velocities: Tuple[float, float]
    """left, right, m/s forward"""
    wheel_angles: Optional[Tuple[float, float]]
    """left, right, rad forward, summed since the first packet; None for a model whose wheel radius nobody knows"""
    x_counts: int
    """exact sum of the robot's own x since the first packet, in its units"""
    y_counts: int
    motors_enabled: bool
    stop_button: bool
    left_stall: bool
    right_stall: bool
    front_bumpers: Tuple[bool, ...]
    """pressed or not, in the order of the bits; ARIA counts them from the left"""
    rear_bumpers: Tuple[bool, ...]
    battery_voltage: float
    """V, real (24 V robots say about 25)"""
    sonar: Tuple[Optional[SonarRange], ...]
    """by sonar number; None for one that was never heard"""
    sonar_enabled: bool
    gripper: Optional[GripperReading]
    """None when no gripper is fitted"""
    digital_in: Optional[int]
    digital_out: Optional[int]
    analog_port: Optional[int]
    analog_voltage: Optional[float]
    """V, 0..5"""
    flags: p2os.Flags
    fault_flags: Optional[p2os.FaultFlags]
    compass: Optional[float]
    """rad, 0..2 pi in the compass's own sense, to 2 degrees; None without a compass"""
    charge_state: Optional[int]
    temperature: Optional[float]
    """degrees Celsius"""
    state_of_charge: Optional[float]
    """0..1"""

    @property
    def moving(self) -> bool:
        """Whether the wheels report any speed."""
        return bool(self.linear or self.angular)


class StateReader:
    """Turns the SIPs of one robot into states. It remembers what one SIP does not have: odometry and older sonar
    readings.
    """

    def __init__(self, identity: RobotIdentity, odometry: Odometry) -> None:
        self.odometry = odometry
        self.unknown_sonar = 0
        """Readings of transducers that the model does not have."""
        self._sonar: List[Optional[SonarRange]] = []
        self._read_at = -math.inf
        self.follow(identity)

    def follow(self, identity: RobotIdentity) -> None:
        """Use a new identity of the robot.

        The list of sonar readings never becomes shorter: a listener that has the old model still looks for all of them.
        """
        self.identity = identity
        self._sonar += [None] * (identity.model.sonar_count - len(self._sonar))
        self._mm_per_range_unit = identity.model.range_mm_per_unit
        self._fitted = frozenset(transducer.number for transducer in identity.model.sonar)
        self._said: Optional[Tuple[Any, ...]] = None
        self._status: Dict[str, Any] = {}

    def read(self, sip: p2os.Sip, time: float, sent_time: float) -> Optional[RobotState]:
        """The state after this SIP, which was whole at ``time`` and begun at ``sent_time`` (monotonic, s). Once for
        each.

        None for one that nobody can believe: it would have the robot where it cannot be (Odometry.update).
        """
        odometry, model = self.odometry, self.identity.model
        if not odometry.update(sip.x_counts, sip.y_counts, sip.heading_units, time - self._read_at):
            return None
        self._read_at = time
        self._take_sonar(sip, time)
        said = STATUS(sip)
        if said != self._said:      # hardly ever
            self._said, self._status = said, self._read_status(sip)
        x, y, heading = odometry.pose
        m_s_per_unit = model.vel_mm_s_per_unit / 1000
        left, right = sip.left_velocity_units * m_s_per_unit, sip.right_velocity_units * m_s_per_unit
        # Firmware without ROTVEL leaves it to the difference of the wheels.
        if sip.rotation_velocity_ddeg_s is None:
            angular = (right - left) / 2 * 1000 * model.diff_rad_per_mm
        else:
            angular = math.radians(sip.rotation_velocity_ddeg_s / 10)
        state: RobotState = made(RobotState, {
            "time": time,
            "sent_time": sent_time,
            "x": x,
            "y": y,
            "heading": heading,
            "linear": (left + right) / 2,
            "angular": angular,
            "wheel_velocities": (left, right),
            "wheel_angles": self._wheel_angles(),
            "x_counts": odometry.x_counts,
            "y_counts": odometry.y_counts,
            "sonar": tuple(self._sonar),
            "analog_voltage": None if sip.analog is None else sip.analog * 5 / 255,
            **self._status,
        })
        return state

    def _read_status(self, sip: p2os.Sip) -> Dict[str, Any]:
        """The fields that are nearly always the same as in the SIP before."""
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
        """Left and right (rad), by the robot's own odometry: it is made of the same wheels."""
        model, odometry = self.identity.model, self.odometry
        if model.wheel_radius is None:
            return None
        half_difference = odometry.turned / model.diff_rad_per_mm / 1000
        left, right = odometry.travel - half_difference, odometry.travel + half_difference
        return left / model.wheel_radius, right / model.wheel_radius

    def _take_sonar(self, sip: p2os.Sip, time: float) -> None:
        mm_per_unit, fitted, sonar = self._mm_per_range_unit, self._fitted, self._sonar
        for reading in sip.sonar:
            number = reading.number
            if number in fitted:
                sonar[number] = SonarRange(reading.range_units * mm_per_unit / 1000, time)
            else:
                self.unknown_sonar += 1

    def _gripper(self, sip: p2os.Sip) -> Optional[GripperReading]:
        if not self.identity.has_gripper or sip.grip_state is None or sip.digital_in is None:
            return None
        if self.identity.model.firmware_family == "PSOS":
            return read_pioneer_1_gripper(sip.digital_in)
        return read_gripper(sip.grip_state, sip.digital_in)


def _segments(bits: int, count: int) -> Tuple[bool, ...]:
    """Bumper segments from bit 1 on; there are seven bits for them."""
    return tuple(bool(bits & (2 << segment)) for segment in range(min(count, 7)))


def _battery(sip: p2os.Sip, battery_class: int) -> float:
    """Real voltage: BATTERYX10 when sent, else BATTERY, which counts as if every robot had 12 V."""
    if sip.battery_x10_dv:
        return sip.battery_x10_dv / 10
    return sip.battery_dv / 10 * battery_class / 12

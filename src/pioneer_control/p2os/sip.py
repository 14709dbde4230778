"""The standard SIP: what the robot reports of itself ten times a second (protocol sheet 4)."""

from dataclasses import dataclass
from typing import NamedTuple, Optional, Tuple

from ..wire_fields import BYTE, INT8, INT16, UINT16, UINT32, Many, Record, later, wire
from .flags import ChargeState, DigitalIn, FaultFlags, Flags, Flags3, GripState, StallBits

STOPPED, MOVING = 0x32, 0x33
"""Frame ids of a SIP of a robot that stands or moves.

They are only a hint: the velocities in the SIP are more reliable. PSOS sends 0x31 when its motors have no power.
"""
COUNT_RANGE = 0x8000
"""The number of counts at which x and y of a SIP wrap (protocol sheet 4.3)."""


class SonarReading(NamedTuple):
    """One reading of a sonar since the last SIP."""

    number: int = wire(BYTE, "", "sonar number, from 0")
    range_units: int = wire(UINT16, "", "range: * range factor = mm; the greatest (about 5000) means no echo")


@dataclass(frozen=True)
class Sip:
    """Standard server information packet, ids 0x30..0x34.

    Older firmware sends a shorter packet. Then the last fields, from `grip_state` on, are None. The packet of P2OS and
    AROS ends with `digital_out`, that of AmigoSH with `charge_state`, that of ARCOS with `fault_flags`. PSOS, P2OS and
    AmigOS send `analog_port` before `grip_state`. `x_counts` and `y_counts` are not unwrapped: only their low 15 bits
    have a meaning, and they wrap.
    """

    type_id: int
    x_counts: int = wire(UINT16, "", "x, 15 bits (mask 0x7FFF), wraps: difference * distance factor = mm, forward")
    y_counts: int = wire(UINT16, "", "y, 15 bits as x, wraps: difference * distance factor = mm, to the left")
    heading_units: int = wire(INT16, "360/4096 deg", "heading, + counter-clockwise (Pioneer 1: 360/1024 deg)")
    left_velocity_units: int = wire(INT16, "", "left wheel: * velocity factor = mm/s")
    right_velocity_units: int = wire(INT16, "", "right wheel: * velocity factor = mm/s")
    battery_dv: int = wire(BYTE, "0.1 V", "battery, scaled to a 12 V system")
    left_stall_bits: int = wire(BYTE.of(StallBits), "", "left wheel stalled, rear bumper segments")
    right_stall_bits: int = wire(BYTE.of(StallBits), "", "right wheel stalled, front bumper segments")
    control_units: int = wire(INT16, "360/4096 deg", "heading set point")
    flags: int = wire(UINT16.of(Flags), "", "motors, sonar, STOP button, ...")
    compass: int = wire(BYTE, "2 deg", "compass; 0, 181 and 255 mean none")
    sonar: Tuple[SonarReading, ...] = wire(Many(Record(SonarReading)), "", "heard since the last SIP; later ones win")
    grip_state: Optional[int] = later(BYTE.of(GripState), "", "gripper as its server sees it")
    analog_port: Optional[int] = later(BYTE, "", "analog port that is selected")
    analog: Optional[int] = later(BYTE, "5/255 V", "the selected analog input")
    digital_in: Optional[int] = later(BYTE.of(DigitalIn), "", "user inputs, as a gripper uses them")
    digital_out: Optional[int] = later(BYTE, "", "user outputs, one bit each")
    battery_x10_dv: Optional[int] = later(UINT16, "0.1 V", "battery, real voltage")
    charge_state: Optional[int] = later(BYTE.of(ChargeState), "", "what the charger does")
    rotation_velocity_ddeg_s: Optional[int] = later(INT16, "0.1 deg/s", "rotation, + counter-clockwise")
    fault_flags: Optional[int] = later(UINT16.of(FaultFlags), "", "faults")
    lateral_velocity_mm_s: Optional[int] = later(INT16, "mm/s", "sideways, + left (Seekur)")
    temperature_c: Optional[int] = later(INT8, "deg C", "temperature; -128 and -127 mean none")
    state_of_charge_percent: Optional[int] = later(BYTE, "%", "state of charge; 0 means not provided")
    controller_time_us: Optional[int] = later(UINT32, "us", "time of the controller (Pioneer LX)")
    flags3: Optional[int] = later(UINT32.of(Flags3), "", "more flags (Pioneer LX)")

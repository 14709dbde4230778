"""Bits and numbers with a name: what single bits of a packet mean, and the sub-commands of the gripper.

`IntFlag` values are integers: ``sip.flags & Flags.MOTORS_ENABLED`` works, unknown bits are kept.
"""

from enum import IntEnum, IntFlag


class Flags(IntFlag):
    """FLAGS of the standard SIP (protocol 4.1)."""

    MOTORS_ENABLED = 1 << 0
    SONAR_1 = 1 << 1
    SONAR_2 = 1 << 2
    SONAR_3 = 1 << 3
    SONAR_4 = 1 << 4
    STOP_BUTTON = 1 << 5
    E_STALL = 1 << 6
    FAR_LEDGE = 1 << 7
    NEAR_LEDGE = 1 << 8
    JOYSTICK_BUTTON = 1 << 9
    CHARGER_POWER = 1 << 10
    HIGH_TEMPERATURE = 1 << 11


class FaultFlags(IntFlag):
    """FAULTFLAGS of the standard SIP, later ARCOS (protocol 4.2)."""

    LASER_POWER = 1 << 0
    HIGH_TEMPERATURE = 1 << 1
    POWER_BOARD_ERROR = 1 << 2
    UNDERVOLTAGE = 1 << 3
    GYRO_FAULT = 1 << 4
    BATTERY_OVER_TEMPERATURE = 1 << 5
    BATTERY_BALANCE_NEEDED = 1 << 6
    ENCODER_DEGRADATION = 1 << 7
    ENCODER_FAILURE = 1 << 8
    DRIVE_FAULT = 1 << 9
    E_STOP_MISMATCH = 1 << 10
    E_STOP_SAFETY_FAULT = 1 << 11
    SPEED_ZONE_FAULT = 1 << 12
    UNKNOWN_SAFETY_FAULT = 1 << 13
    REVERSE_SPEED_EXCEEDED = 1 << 14
    JOYSTICK_WITH_SAFETY_OFF = 1 << 15


class Flags3(IntFlag):
    """FLAGS3 of the standard SIP, Pioneer LX (protocol 4.2)."""

    JOYSTICK_OVERRIDE = 1 << 0
    AMPLIFIER_ERROR = 1 << 1
    SILENT_E_STOP = 1 << 2
    LASER_SAFETY_ERROR = 1 << 3
    ROTATION_LOOP_DISABLED = 1 << 4
    ROTATION_INTEGRATOR_SATURATED = 1 << 5


class StallBits(IntFlag):
    """One byte of STALL/BUMP: its wheel, and the pressed bumper segments (left wheel: rear; right wheel: front)."""

    STALLED = 1 << 0
    BUMPER_1 = 1 << 1
    BUMPER_2 = 1 << 2
    BUMPER_3 = 1 << 3
    BUMPER_4 = 1 << 4
    BUMPER_5 = 1 << 5
    BUMPER_6 = 1 << 6
    BUMPER_7 = 1 << 7


class GripState(IntFlag):
    """GRIP_STATE (protocol 6.2). Neither or both of open and closed (of up and down): in between, or not known."""

    OPEN = 1 << 0
    CLOSED = 1 << 1
    MOVING = 1 << 2
    ERROR = 1 << 3
    LIFT_UP = 1 << 4
    LIFT_DOWN = 1 << 5
    LIFT_MOVING = 1 << 6
    LIFT_ERROR = 1 << 7


class DigitalIn(IntFlag):
    """User digital inputs as a gripper there drives them (protocol 6.4); any other wiring gives them another meaning.

    A set bit means what its name says. With nothing connected all float high: both beams look broken.
    """

    PADDLES_NOT_OPEN = 1 << 0
    LIFT_BETWEEN = 1 << 1
    OUTER_BEAM_BROKEN = 1 << 2
    INNER_BEAM_BROKEN = 1 << 3
    LEFT_CONTACT_FREE = 1 << 4
    RIGHT_CONTACT_FREE = 1 << 5
    INPUT_6 = 1 << 6
    INPUT_7 = 1 << 7


class GripperSwitches(IntFlag):
    """State byte of GRIPPERpac as P2OS fills it (protocol 6.3). AROS and ARCOS send a `GripState` there instead."""

    PADDLES_NOT_OPEN = 1 << 0
    LIFT_BETWEEN = 1 << 1
    OUTER_BEAM = 1 << 2
    INNER_BEAM = 1 << 3
    LEFT_CONTACT_FREE = 1 << 4
    RIGHT_CONTACT_FREE = 1 << 5
    LIFT_MOVING = 1 << 6
    PADDLES_MOVING = 1 << 7


class ChargeState(IntEnum):
    """CHARGE STATE of the standard SIP (protocol 4)."""

    NOT_CHARGING = 0
    BULK = 1
    OVERCHARGE = 2
    FLOAT = 3
    BALANCE = 4
    UNKNOWN = 255


class GripperCommand(IntEnum):
    """Arguments of the GRIPPER command (protocol 6.1). PRESSURE and CARRY need a GRIPPERVAL right behind them."""

    OPEN = 1
    CLOSE = 2
    STOP = 3
    LIFT_UP = 4
    LIFT_DOWN = 5
    LIFT_STOP = 6
    STORE = 7
    DEPLOY = 8
    HALT = 15
    PRESSURE = 16
    CARRY = 17


GRIPPER_VALUES = {GripperCommand.PRESSURE: (1, 100), GripperCommand.CARRY: (-255, 255)}
"""Least and greatest GRIPPERVAL (20 ms) behind a sub-command that needs one; never 0."""

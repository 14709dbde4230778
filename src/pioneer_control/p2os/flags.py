"""Names of bits and numbers in packets, and of the gripper commands.

`IntFlag` values are integers: ``sip.flags & Flags.MOTORS_ENABLED`` works, and unknown bits are kept. Each list of names
begins with the lowest bit.
"""

from enum import IntEnum, IntFlag

Flags = IntFlag("Flags", [
    "MOTORS_ENABLED",              # bit 0
    "SONAR_1",
    "SONAR_2",
    "SONAR_3",
    "SONAR_4",                     # bit 4
    "STOP_BUTTON",
    "E_STALL",
    "FAR_LEDGE",
    "NEAR_LEDGE",                  # bit 8
    "JOYSTICK_BUTTON",
    "CHARGER_POWER",
    "HIGH_TEMPERATURE",
])
"""Bits of FLAGS in the standard SIP (protocol sheet 4.1)."""

FaultFlags = IntFlag("FaultFlags", [
    "LASER_POWER",                 # bit 0
    "HIGH_TEMPERATURE",
    "POWER_BOARD_ERROR",
    "UNDERVOLTAGE",
    "GYRO_FAULT",                  # bit 4
    "BATTERY_OVER_TEMPERATURE",
    "BATTERY_BALANCE_NEEDED",
    "ENCODER_DEGRADATION",
    "ENCODER_FAILURE",             # bit 8
    "DRIVE_FAULT",
    "E_STOP_MISMATCH",
    "E_STOP_SAFETY_FAULT",
    "SPEED_ZONE_FAULT",            # bit 12
    "UNKNOWN_SAFETY_FAULT",
    "REVERSE_SPEED_EXCEEDED",
    "JOYSTICK_WITH_SAFETY_OFF",
])
"""Bits of FAULTFLAGS in the standard SIP of later ARCOS firmware (protocol sheet 4.2)."""

Flags3 = IntFlag("Flags3", [
    "JOYSTICK_OVERRIDE",           # bit 0
    "AMPLIFIER_ERROR",
    "SILENT_E_STOP",
    "LASER_SAFETY_ERROR",
    "ROTATION_LOOP_DISABLED",      # bit 4
    "ROTATION_INTEGRATOR_SATURATED",
])
"""Bits of FLAGS3 in the standard SIP of a Pioneer LX (protocol sheet 4.2)."""

StallBits = IntFlag("StallBits", [
    "STALLED",                     # bit 0
    "BUMPER_1",
    "BUMPER_2",
    "BUMPER_3",
    "BUMPER_4",                    # bit 4
    "BUMPER_5",
    "BUMPER_6",
    "BUMPER_7",
])
"""Bits of one byte of STALL/BUMP in the standard SIP: a stalled wheel, and pressed bumper segments.

The left byte has the left wheel and the rear bumper. The right byte has the right wheel and the front bumper.
"""

GripState = IntFlag("GripState", [
    "OPEN",                        # bit 0
    "CLOSED",
    "MOVING",
    "ERROR",
    "LIFT_UP",                     # bit 4
    "LIFT_DOWN",
    "LIFT_MOVING",
    "LIFT_ERROR",
])
"""Bits of GRIP_STATE in the standard SIP (protocol sheet 6.2).

When neither or both of OPEN and CLOSED are set, the paddles are in between, or their position is unknown. The same is
true of the lift with LIFT_UP and LIFT_DOWN.
"""

DigitalIn = IntFlag("DigitalIn", [
    "PADDLES_NOT_OPEN",            # bit 0
    "LIFT_BETWEEN",
    "OUTER_BEAM_BROKEN",
    "INNER_BEAM_BROKEN",
    "LEFT_CONTACT_FREE",           # bit 4
    "RIGHT_CONTACT_FREE",
    "INPUT_6",
    "INPUT_7",
])
"""Bits of the user digital inputs when a gripper is connected to them (protocol sheet 6.4).

Another wiring gives them another meaning. A set bit means what its name says. When nothing is connected, all inputs are
high, and both beams seem to be broken.
"""

GripperSwitches = IntFlag("GripperSwitches", [
    "PADDLES_NOT_OPEN",            # bit 0
    "LIFT_BETWEEN",
    "OUTER_BEAM",
    "INNER_BEAM",
    "LEFT_CONTACT_FREE",           # bit 4
    "RIGHT_CONTACT_FREE",
    "LIFT_MOVING",
    "PADDLES_MOVING",
])
"""Bits of the state byte in GRIPPERpac of P2OS (protocol sheet 6.3). AROS and ARCOS send a `GripState` instead."""


ChargeState = IntEnum("ChargeState", {
    "NOT_CHARGING": 0,
    "BULK": 1,
    "OVERCHARGE": 2,
    "FLOAT": 3,
    "BALANCE": 4,
    "UNKNOWN": 255,
})
"""Values of CHARGE STATE in the standard SIP (protocol sheet 4)."""

GripperCommand = IntEnum("GripperCommand", {
    "OPEN": 1,
    "CLOSE": 2,
    "STOP": 3,
    "LIFT_UP": 4,
    "LIFT_DOWN": 5,
    "LIFT_STOP": 6,
    "STORE": 7,
    "DEPLOY": 8,
    "HALT": 15,
    "PRESSURE": 16,
    "CARRY": 17,
})
"""Arguments of the GRIPPER command (protocol sheet 6.1). PRESSURE and CARRY need a GRIPPERVAL right behind them."""

GRIPPER_VALUES = {GripperCommand.PRESSURE: (1, 100), GripperCommand.CARRY: (-255, 255)}
"""The least and the greatest GRIPPERVAL (units of 20 ms) of the gripper commands that need one. 0 is not legal."""

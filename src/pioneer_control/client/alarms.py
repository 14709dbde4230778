"""The texts of alarms about a robot that both warnings and diagnostics use, and the battery levels that they need.

The functions are pure.
"""

from typing import NamedTuple, Optional

from .identity import RobotIdentity
from .state import RobotState

LOW_BATTERY_12_V = 11.5
"""The alarm level (V) for a 12 V robot that does not report its own level (LowBattery in the CONFIGpac)."""
EMPTY_BATTERY_12_V = 11.0
"""The voltage (V) at which a 12 V robot switches itself off, unless it reports its own level (ShutdownVolts)."""


class BatteryLevels(NamedTuple):
    """Two levels of the battery (V): below `low` there is a warning, below `empty` the robot switches itself off."""

    low: float
    empty: float


def battery_levels(identity: RobotIdentity) -> BatteryLevels:
    """Return the battery levels that the robot reports, or the usual levels for a battery of this voltage."""
    config, volts_of_class = identity.config, identity.model.battery_class / 12
    low_dv, shutdown_dv = (None, None) if config is None else (config.low_battery_dv, config.shutdown_dv)

    def level(reported_dv: Optional[int], usual_12_v: float) -> float:
        volts = reported_dv / 10 if reported_dv else usual_12_v * volts_of_class
        # Some 24 V robots report the level of a 12 V battery.
        return volts * volts_of_class if volts < 8 * volts_of_class else volts

    low = level(low_dv, LOW_BATTERY_12_V)
    return BatteryLevels(low, min(low, level(shutdown_dv, EMPTY_BATTERY_12_V)))


def low_battery(voltage: float, levels: BatteryLevels) -> str:
    """Return the warning text about a battery with a low ``voltage`` (V). The text also names the alarm level."""
    return "battery low: %.1f V, the alarm level is %.1f V" % (voltage, levels.low)


def stalled_wheels(state: RobotState) -> str:
    """Return the warning about stalled wheels. Empty when no wheel is stalled, or when the STOP button is pressed."""
    if state.stop_button or not (state.left_stall or state.right_stall):
        return ""
    stalled = [name for name, stall in (("left", state.left_stall), ("right", state.right_stall)) if stall]
    return "the %s wheel%s stalled: something holds the robot" % (
        " and the ".join(stalled), "s are" if len(stalled) > 1 else " is")


def stop_button_pressed(how_to_enable: str) -> str:
    """Return the warning about a pressed STOP button. ``how_to_enable``: the command that switches the motors on."""
    return "the STOP button is pressed: motors are off; release it, then %s" % how_to_enable


def unmoved(age: float) -> str:
    """Return the warning about a robot that got a velocity with motors on, but has not moved for ``age`` seconds."""
    return ("told to drive, the robot has not moved for %.0f s: does it hear? check the wire to it; "
            "then what holds its wheels" % age)

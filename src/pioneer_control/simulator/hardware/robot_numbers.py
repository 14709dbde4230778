"""The parameters of the simulated robot, from ``robot.yaml`` and, optionally, from a file of the user."""

import functools
import os
from dataclasses import dataclass
from typing import Any, Dict, Optional, Tuple, get_type_hints

from ...errors import ParameterError
from ...p2os import BAUD_RATES
from ..world.yaml_nodes import read_values

LEGAL = {
    "gyro.kind": (0, 2),
    "wheels.larger": (-0.5, 0.5),
    "wheels.right_larger": (-0.5, 0.5),
    "wheels.wider_apart": (-0.5, 0.5),
    "wheels.slip": (0, 0.9),
    "wheels.noise": (0, 0.1),
    "sonar.maximum": (0.2, 30),
    "sonar.cone_deg": (1, 90),
    "sonar.specular_deg": (1, 90),
    "sonar.noise": (0, 1),
}
"""Smallest and largest legal values of some numbers. All other numbers must be above 0."""
OWN_FILE = os.path.join(os.path.dirname(os.path.dirname(__file__)), "robot.yaml")


@dataclass(frozen=True)
class PhysicsNumbers:
    """Section ``physics`` of ``robot.yaml``."""

    step_us: int


@dataclass(frozen=True)
class SessionNumbers:
    """Section ``session`` of ``robot.yaml``."""

    sip_cycle_ms: int
    watchdog_ms: int
    host_baud: int
    autobaud: int
    firmware_version: str
    serial: str
    boot_time: float


@dataclass(frozen=True)
class GyroNumbers:
    """Section ``gyro`` of ``robot.yaml``."""

    kind: int
    scaler: float
    centre: int
    temperature: int


@dataclass(frozen=True)
class CompassNumbers:
    """Section ``compass`` of ``robot.yaml``."""

    fitted: bool
    horizontal_field: float
    vertical_field: float
    temperature_c: float


@dataclass(frozen=True)
class JoystickNumbers:
    """Section ``joystick`` of ``robot.yaml``."""

    linear_mm_s: int
    angular_deg_s: int


@dataclass(frozen=True)
class DriveNumbers:
    """Section ``drive`` of ``robot.yaml``."""

    linear_limit_mm_s: int
    linear_top_mm_s: int
    linear_acceleration_mm_s2: int
    linear_deceleration_mm_s2: int
    linear_acceleration_top_mm_s2: int
    angular_limit_deg_s: int
    angular_top_deg_s: int
    angular_acceleration_deg_s2: int
    angular_deceleration_deg_s2: int
    angular_acceleration_top_deg_s2: int
    stall_time: float
    stall_recovery: float
    encoder_ticks_per_mm: int


@dataclass(frozen=True)
class WheelNumbers:
    """Section ``wheels`` of ``robot.yaml``."""

    larger: float
    right_larger: float
    wider_apart: float
    slip: float
    noise: float


@dataclass(frozen=True)
class SonarNumbers:
    """Section ``sonar`` of ``robot.yaml``."""

    minimum: float
    maximum: float
    cone_deg: float
    specular_deg: float
    cycle_ms: int
    noise: float


@dataclass(frozen=True)
class GripperNumbers:
    """Section ``gripper`` of ``robot.yaml``."""

    fitted_by_default: Tuple[str, ...]
    open_at_power_on: bool
    lift_up_at_power_on: bool
    reach_height: float
    jam_time: float


@dataclass(frozen=True)
class BatteryNumbers:
    """Section ``battery`` of ``robot.yaml``."""

    full: float
    standing_fall_per_min: float
    driving_fall_per_min: float
    charging_rise_per_min: float
    overcharge: float
    dock_distance: float
    dock_angle_deg: float
    alarm: float
    shutdown: float


@dataclass(frozen=True)
class RobotNumbers:
    """All sections of ``robot.yaml``. Comments in that file explain each number."""

    physics: PhysicsNumbers
    session: SessionNumbers
    gyro: GyroNumbers
    compass: CompassNumbers
    joystick: JoystickNumbers
    drive: DriveNumbers
    wheels: WheelNumbers
    sonar: SonarNumbers
    gripper: GripperNumbers
    battery: BatteryNumbers


def load_numbers(override_file: Optional[str] = None) -> RobotNumbers:
    """Return the simulator's numbers. Values in `override_file` replace the values of ``robot.yaml``.

    Raises:
        ParameterError: a file cannot be read or is not YAML, a name is unknown, or a value is not legal or has a
            different type than in ``robot.yaml``. The message names the file and the entry.
    """
    values = _read(OWN_FILE)
    if override_file is not None:
        for section, entries in _read(override_file).items():
            if section not in values:
                raise ParameterError("%s: no section %r; there are %s" % (override_file, section, ", ".join(values)))
            for name, value in entries.items():
                values[section][name] = _checked(override_file, section, name, value, values[section])
    values["gripper"]["fitted_by_default"] = tuple(values["gripper"]["fitted_by_default"])
    return RobotNumbers(**{name: kind(**values[name]) for name, kind in get_type_hints(RobotNumbers).items()})


@functools.lru_cache(maxsize=None)
def standard_numbers() -> RobotNumbers:
    """Return the numbers of ``robot.yaml``, which is read only once."""
    return load_numbers()


def _read(path: str) -> Dict[str, Dict[str, Any]]:
    values = read_values(path)
    if not isinstance(values, dict) or not all(isinstance(entries, dict) for entries in values.values()):
        raise ParameterError("%s: expected sections of 'name: value', as in %s" % (path, OWN_FILE))
    return values


def _checked(path: str, section: str, name: str, value: Any, known: Dict[str, Any]) -> Any:
    if name not in known:
        raise ParameterError("%s: no number %s.%s; there are %s" % (path, section, name, ", ".join(known)))
    own, limits = known[name], LEGAL.get("%s.%s" % (section, name))
    wanted = (int, float) if isinstance(own, float) else (type(own),)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not isinstance(value, wanted) or isinstance(value, bool) != isinstance(own, bool):
        problem = "wanted something like %r" % own
    elif is_number and limits is not None and not limits[0] <= value <= limits[1]:
        problem = "legal: from %g to %g" % limits
    elif is_number and limits is None and not 0 < value < float("inf"):
        problem = "wanted a positive number"
    elif name == "host_baud" and value not in BAUD_RATES:
        problem = "legal: %s" % ", ".join(map(str, BAUD_RATES))
    else:
        return value
    raise ParameterError("%s: %s.%s is %r, %s" % (path, section, name, value, problem))

"""The parameters of the simulated robot: from ``robot.yaml``, drawn as of a real robot, and from a file of the user."""

import copy
import functools
import math
import os
import random
from dataclasses import dataclass, replace
from typing import Any, Dict, Mapping, NamedTuple, Optional, Tuple, get_type_hints

from ...errors import ParameterError
from ...p2os import BAUD_RATES
from ...parameters import Choice, Number, Numbers, Switch, Text, Whole
from ...maps.yaml_nodes import read_values


class Subtypes(NamedTuple):
    """Checks a list of robot models, given by their subtypes."""

    legal: str = "a list of texts"

    def accept(self, value: Any) -> Tuple[str, ...]:
        """Return the subtypes. Raise ValueError if the value is not a list of texts."""
        return tuple(Text().accept(each) for each in (value if isinstance(value, list) else [None]))


class WholeList(NamedTuple):
    """Checks a list of ``length`` whole numbers, each in [low, high]."""

    length: int
    low: int
    high: int

    @property
    def legal(self) -> str:
        """The description of the legal lists, for people."""
        return "a list of %d whole numbers from %d to %d" % self

    def accept(self, value: Any) -> Tuple[int, ...]:
        """Return the numbers. Raise ValueError if the value is not such a list."""
        if not isinstance(value, list) or len(value) != self.length:
            raise ValueError
        return tuple(map(Whole(self.low, self.high).accept, value))


TICKS = WholeList(6, 0, 255)


class Curve(NamedTuple):
    """Checks a list of two or more pairs of numbers: x, which grows from pair to pair, and y. None is negative."""

    legal: str = "a list of two or more pairs of numbers from 0 up, the first numbers in increasing order"

    def accept(self, value: Any) -> Tuple[Tuple[float, float], ...]:
        """Return the pairs. Raise ValueError if the value is no such list."""
        pairs = [Numbers(2, 0.0, math.inf).accept(each) for each in (value if isinstance(value, list) else [])]
        if len(pairs) < 2 or any(before[0] >= after[0] for before, after in zip(pairs, pairs[1:])):
            raise ValueError
        return tuple((x, y) for x, y in pairs)


class Odd(NamedTuple):
    """Checks an odd number."""

    legal: str = "an odd number from 1 to 9"

    def accept(self, value: Any) -> int:
        """Return the number. Raise ValueError if it is not odd, or too large."""
        number: int = Whole(1, 9).accept(value)
        if number % 2 == 0:
            raise ValueError
        return number


SHARE = Number(0, 1)
LEGAL: Mapping[str, Any] = {
    "session.host_baud": Choice(tuple(BAUD_RATES)),
    "gyro.kind": Whole(0, 2),
    "gyro.larger": Number(-0.5, 0.5),
    "wheels.larger": Number(-0.5, 0.5),
    "wheels.right_larger": Number(-0.5, 0.5),
    "wheels.wider_apart": Number(-0.5, 0.5),
    "wheels.slip": Number(0, 0.9),
    "wheels.left_slip": Number(0, 0.9),
    "wheels.noise": Number(0, 0.1),
    "sonar.maximum": Number(0.2, 30),
    "sonar.cone_deg": Whole(1, 90),
    "sonar.specular_deg": Whole(1, 90),
    "sonar.noise": Number(0, 1),
    "arm.layout": Choice(("A", "M")),
    "arm.aux": Whole(1, 3),
    "arm.speed_ms": WholeList(6, 1, 127),
    "arm.safe_speed_ms": Whole(1, 127),
    "arm.autopark_s": Whole(0, 65535),
    "arm.grippark_s": Whole(0, 65535),
    **dict.fromkeys(("arm.home", "arm.minimum", "arm.centre", "arm.maximum", "arm.ticks_per_90_deg"), TICKS),
    "laser.bias": Number(0, 1),
    "laser.noise": Number(0, 1),
    "laser.spot": Number(0, 1),
    "laser.spot_growth": Number(0, 0.1),
    "laser.rays": Odd(),
    "laser.together": Number(0, 10),
    "laser.pulse": Number(0, 10),
    "laser.stray": SHARE,
    "laser.stray_depth": Number(0, 10),
    "laser.needed_reflectivity": Curve(),
    "laser.farthest": Number(0.1, 80),
    "laser.wall_reflectivity": Number(0, 100),
    "laser.dark_reflectivity": Number(0, 100),
    "laser.glass_reflectivity": Number(0, 100),
    "laser.glass_angle_deg": Number(0, 90),
    "laser.reflector_reflectivity": Number(0, 100),
    "laser.body_reflectivity": Number(0, 100),
    "laser.dazzle_distance": Number(0, 80),
    "laser.dazzle_share": SHARE,
}
"""Checks of some values. The type of the value in ``robot.yaml`` decides the check of all others; see `LEGAL_BY_TYPE`.
"""
LEGAL_BY_TYPE: Mapping[type, Any] = {
    bool: Switch(), int: Whole(1), float: Number(1e-6), str: Text(), list: Subtypes()}
REAL_RANGES: Mapping[str, float] = {"larger": 0.03, "right_larger": 0.006, "wider_apart": 0.05}
"""How far each of these numbers of a real robot's wheels may be from 0, to either side."""
REAL_WHEELS: Mapping[str, float] = {"slip": 0.03, "noise": 0.004}
"""The other numbers of a real robot's wheels."""
REAL_SONAR: Mapping[str, float] = {"noise": 0.02, "specular_deg": 40}
"""The numbers of a real robot's sonar. Smooth walls, which lose more, have a ``specular_deg`` of 20."""
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
    larger: float
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
    left_slip: float
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
class LaserNumbers:
    """Section ``laser`` of ``robot.yaml``."""

    bias: float
    noise: float
    skew: bool
    spot: float
    spot_growth: float
    rays: int
    together: float
    pulse: float
    stray: float
    stray_depth: float
    needed_reflectivity: Tuple[Tuple[float, float], ...]
    farthest: float
    wall_reflectivity: float
    dark_reflectivity: float
    glass_reflectivity: float
    glass_angle_deg: float
    reflector_reflectivity: float
    body_reflectivity: float
    dazzle_distance: float
    dazzle_share: float


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
class ArmNumbers:
    """Section ``arm`` of ``robot.yaml``. Lists have one value for each joint."""

    layout: str
    aux: int
    version: str
    linked_at_power_on: bool
    speed_ms: Tuple[int, ...]
    home: Tuple[int, ...]
    minimum: Tuple[int, ...]
    centre: Tuple[int, ...]
    maximum: Tuple[int, ...]
    ticks_per_90_deg: Tuple[int, ...]
    safe_speed_ms: int
    autopark_s: int
    grippark_s: int


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
    laser: LaserNumbers
    gripper: GripperNumbers
    battery: BatteryNumbers
    arm: ArmNumbers


def load_numbers(override_file: Optional[str] = None, real_seed: Optional[int] = None) -> RobotNumbers:
    """Return the simulator's numbers. Values in `override_file` replace all others.

    Args:
        override_file: path of a file of the user. None if there is none.
        real_seed: seed of the errors of wheels and sonar; see `real_numbers`. None for those of ``robot.yaml``.

    Raises:
        ParameterError: a file cannot be read or is not YAML, a name is unknown, or a value is not legal or has a
            different type than in ``robot.yaml``. The message names the file and the entry.
    """
    values = copy.deepcopy(_own_values())
    for section, real in (_real_values(real_seed) if real_seed is not None else {}).items():
        values[section].update(real)
    if override_file is not None:
        for section, entries in _read(override_file).items():
            if section not in values:
                raise ParameterError("%s: no section %r; there are %s" % (override_file, section, ", ".join(values)))
            for name, value in entries.items():
                values[section][name] = _checked(override_file, section, name, value, values[section])
    return RobotNumbers(**{name: kind(**_with_tuples(values[name]))
                           for name, kind in get_type_hints(RobotNumbers).items()})


def _with_tuples(entries: Mapping[str, Any]) -> Dict[str, Any]:
    """Return a section with tuples in place of its lists: nobody can change them."""
    return {name: _as_tuple(value) for name, value in entries.items()}


def _as_tuple(value: Any) -> Any:
    """Return a list, and the lists in it, as tuples; all else as it is."""
    return tuple(map(_as_tuple, value)) if isinstance(value, (list, tuple)) else value


@functools.lru_cache(maxsize=None)
def standard_numbers() -> RobotNumbers:
    """Return the numbers of ``robot.yaml``, which is read only once."""
    return load_numbers()


def real_numbers(numbers: RobotNumbers, seed: int) -> RobotNumbers:
    """Return numbers with wheels and sonar that err as those of a real robot. The same seed gives the same errors.

    Each robot's wheels differ in their own way from what its firmware assumes; `REAL_RANGES` says how far. The other
    errors are the same for all robots.
    """
    real = _real_values(seed)
    return replace(numbers, wheels=replace(numbers.wheels, **real["wheels"]),
                   sonar=replace(numbers.sonar, **real["sonar"]))


def _real_values(seed: int) -> Dict[str, Dict[str, Any]]:
    """Return the numbers of a real robot that differ from ``robot.yaml``, by section and name."""
    rng = random.Random("real %s" % seed)
    drawn = {name: rng.uniform(-most, most) for name, most in REAL_RANGES.items()}
    return {"wheels": {**drawn, **REAL_WHEELS}, "sonar": dict(REAL_SONAR)}


@functools.lru_cache(maxsize=None)
def _own_values() -> Dict[str, Dict[str, Any]]:
    """Return the values of ``robot.yaml``, which is read only once. Do not change them."""
    return _read(OWN_FILE)


def _read(path: str) -> Dict[str, Dict[str, Any]]:
    values = read_values(path)
    if not isinstance(values, dict) or not all(isinstance(entries, dict) for entries in values.values()):
        raise ParameterError("%s: expected sections of 'name: value', as in %s" % (path, OWN_FILE))
    return values


def _checked(path: str, section: str, name: str, value: Any, known: Dict[str, Any]) -> Any:
    if name not in known:
        raise ParameterError("%s: no number %s.%s; there are %s" % (path, section, name, ", ".join(known)))
    check = LEGAL.get("%s.%s" % (section, name)) or LEGAL_BY_TYPE[type(known[name])]
    try:
        return check.accept(value)
    except ValueError:
        raise ParameterError(
            "%s: %s.%s is %r: give %s" % (path, section, name, value, check.legal)) from None

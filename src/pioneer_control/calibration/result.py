"""The numbers of a models file, and those of the robot itself, from the factors that were found.

The driver corrects what the robot counts by its models file, and calibration corrects what the driver says. So the new
numbers of the file are its old ones with the factors on top. A robot that is told its own numbers (TicksMM, RevCount)
counts otherwise from then on; whole numbers leave a rest, and the file corrects that.

TicksMM is in whole ticks: on a robot with 128 a step is 0.8 %, 2 cm in 5 m at worst. RevCount is as fine as any tape.
"""

import math
import os
from typing import Any, Dict, NamedTuple, Optional

import yaml

from ..client.tuning import ROWS
from ..errors import UsageError
from ..robots import RobotModel
from ..robots.table import load_table
from ..whole_file import writing
from .estimate import Estimate
from .tracks import Factors

DIGITS = {"dist_mm_per_unit": 6, "vel_mm_s_per_unit": 6, "diff_rad_per_mm": 6, "turn_factor": 5, "curve_deg_per_m": 4,
          "gyro_factor": 5}
"""The keys of a models file that are calibrated, and with how many significant digits they are written."""


class OwnNumbers(NamedTuple):
    """The robot's own numbers, as it reports them; None where it does not report one."""

    ticks_mm: Optional[int] = None
    rev_count: Optional[int] = None
    drift_factor: Optional[int] = None


def of_counts(factors: Factors, model: RobotModel) -> Factors:
    """Return the factors of what the robot counts, from those of what a driver with this model says of it.

    ``distance`` is in mm for a unit, as in the file.
    """
    return Factors(factors.distance * model.dist_mm_per_unit, factors.turn * model.turn_factor,
                   factors.curve + factors.turn * model.curve_rad_per_m / factors.distance)


def of_driver(counted: Factors, model: RobotModel) -> Factors:
    """Return the factors of what a driver with this model says, from those of what the robot counts: see `of_counts`.
    """
    distance, turn = counted.distance / model.dist_mm_per_unit, counted.turn / model.turn_factor
    return Factors(distance, turn, counted.curve - turn * model.curve_rad_per_m / distance)


def numbers_to_tell(counted: Factors, nominal: RobotModel, own: OwnNumbers,
                    drift_unit: Optional[float] = None) -> Dict[str, int]:
    """Return the robot's own numbers that it should have, by the names of the driver's parameters.

    Args:
        counted: factors of what the robot counts, as of `of_counts`.
        nominal: the model without any calibration.
        own: the numbers that it has.
        drift_unit: turn (rad, left positive) in each metre that one unit of DriftFactor adds. No document tells it.

    Raises:
        ParameterError: a number is beyond what the robot can be told. The message names it, and what is legal.
    """
    new: Dict[str, int] = {}
    if own.ticks_mm:
        new["ticks_mm"] = round(own.ticks_mm * nominal.dist_mm_per_unit / counted.distance)
    if own.rev_count:
        new["rev_count"] = round(own.rev_count / counted.turn)
    if own.drift_factor is not None and drift_unit:
        new["drift_factor"] = own.drift_factor - round(counted.curve / drift_unit)
    for name, value in new.items():
        ROWS[name].check(name, value)
    return new


def after_telling(counted: Factors, own: OwnNumbers, new: Dict[str, int],
                  drift_unit: Optional[float] = None) -> Factors:
    """Return the factors of what the robot counts when it has been told new numbers: the rest."""
    now = own._replace(**new)
    drift = (now.drift_factor or 0) - (own.drift_factor or 0)
    return Factors(counted.distance * _ratio(now.ticks_mm, own.ticks_mm),
                   counted.turn * _ratio(now.rev_count, own.rev_count), counted.curve + drift * (drift_unit or 0.0))


def _ratio(new: Optional[int], old: Optional[int]) -> float:
    return new / old if new and old else 1.0


def values_of_file(counted: Factors, rest: Factors, model: RobotModel, found: Estimate) -> Dict[str, float]:
    """Return the calibrated values of a model, by their keys in a models file.

    Args:
        counted: factors of what the robot counted in the runs.
        rest: factors of what it counts now; the same unless it has been told new numbers.
        model: the model of the driver in the runs.
        found: the estimate.
    """
    wheels = counted.distance / model.dist_mm_per_unit
    values = {
        "dist_mm_per_unit": rest.distance,
        "vel_mm_s_per_unit": model.vel_mm_s_per_unit * rest.distance / model.dist_mm_per_unit,
        # turn as the robot counts it, for a real way of the wheels
        "diff_rad_per_mm": model.diff_rad_per_mm * (counted.turn / rest.turn) / wheels,
        "turn_factor": rest.turn,
        "curve_deg_per_m": math.degrees(rest.curve),
        "gyro_factor": model.gyro_factor * (1.0 if found.gyro is None else found.gyro),
    }
    return {name: float("%.*g" % (DIGITS[name], value)) for name, value in values.items()}


def check_new_file(path: str) -> None:
    """Check that a models file can be written, by trying. Raises UsageError: it is there already, or cannot."""
    try:
        open(path, "x", encoding="utf-8").close()
        os.remove(path)
    except FileExistsError:
        raise UsageError("%s is there already, and is not overwritten: give another name (--file), or move it"
                         % path) from None
    except OSError as error:
        raise UsageError("%r cannot be written: %s. Give another name (--file)" % (path, error.strerror)) from None


def write_models_file(path: str, name: str, values: Dict[str, float], before: str = "", head: str = "") -> None:
    """Write a models file with the calibrated values of one model. It is read back, so that it is right.

    Args:
        path: must not be there yet.
        name: of the model.
        values: by their keys.
        before: the models file that the driver used. What it has besides stays. Empty: none.
        head: lines for the head of the file.

    Raises:
        UsageError: the file is there already, or cannot be written, or would not be legal.
    """
    check_new_file(path)
    content: Dict[str, Any] = {}
    if before:
        try:
            with open(before, encoding="utf-8") as file:
                content = yaml.safe_load(file) or {}
        except (OSError, yaml.YAMLError) as error:
            raise UsageError("models file %s cannot be read: %s" % (before, error)) from error
    models = content.setdefault("models", {})
    models[name] = dict(models.get(name) or {}, **values)
    try:
        with writing(path) as part:
            with open(part, "w", encoding="utf-8") as file:
                file.write("".join("# %s\n" % line if line else "#\n" for line in head.splitlines()))
                yaml.safe_dump(content, file, default_flow_style=None, sort_keys=False, width=120)
            load_table(part).find(name)
    except OSError as error:        # a disk that is full
        raise UsageError("%s cannot be written: %s" % (path, error.strerror)) from error

"""``python3 -m pioneer_control.robots [FILE]`` prints all models as the Markdown table that is in docs/models.md."""

import argparse
import math
import sys
from typing import Callable, Dict, List, Optional

from ..errors import UsageError
from .model import LaserPlace, RobotModel
from .table import load_table


def laser_cell(laser: Optional[LaserPlace]) -> str:
    """Return the cell of a laser's place: x, y, and z where it is known."""
    if laser is None:
        return "-"
    place = ", ".join("%g" % each for each in (laser.x, laser.y, laser.z) if each is not None)
    return place + ", upside down" * laser.upside_down


COLUMNS: Dict[str, Callable[[RobotModel], str]] = {
    "model": lambda model: "`%s`" % model.subtype,
    "firmware": lambda model: model.firmware_family,
    "speed (m/s)": lambda model: "%g" % model.max_linear,
    "turn (deg/s)": lambda model: "%g" % math.degrees(model.max_angular),
    "front, rear (m)": lambda model: "%g, %g" % (model.length_front, model.length_rear),
    "width (m)": lambda model: "%g" % model.width,
    "sonar": lambda model: "%d" % len(model.sonar),
    "bumpers": lambda model: "%d + %d" % (model.front_bumpers, model.rear_bumpers),
    "gripper": lambda model: "yes" if model.can_carry_gripper else "no",
    "battery (V)": lambda model: "%d" % model.battery_class,
    "dist": lambda model: "%g" % model.dist_mm_per_unit,
    "vel": lambda model: "%g" % model.vel_mm_s_per_unit,
    "range": lambda model: "%g" % model.range_mm_per_unit,
    "diff": lambda model: "%.6g" % model.diff_rad_per_mm,
    "laser (m)": lambda model: laser_cell(model.laser),
    "wheel (mm)": lambda model: "%g" % (model.wheel_radius * 1000) if model.wheel_radius else "?",
}
"""The columns of the printed table: from the heading of a column to a function that returns the cell of a model."""


def table(models: Dict[str, RobotModel]) -> List[str]:
    """Return the lines of the Markdown table: the heading, then one line for each model in the order of the file."""
    rows = [list(COLUMNS), ["---"] * len(COLUMNS)]
    rows += [[text(model) for text in COLUMNS.values()] for model in models.values()]
    return ["|" + "|".join(row) + "|" if "---" in row else "| " + " | ".join(row) + " |" for row in rows]


def main(arguments: Optional[List[str]] = None) -> int:
    """Print the table of models and return exit code 0. With a wrong models file the program ends with exit code 2."""
    parser = argparse.ArgumentParser(prog="python3 -m pioneer_control.robots",
                                     description="Print all robot models as a table in Markdown.")
    parser.add_argument("file", metavar="FILE", nargs="?", help="a models file that overrides or adds models")
    try:
        print("\n".join(table(load_table(parser.parse_args(arguments).file).models)))
    except UsageError as error:
        parser.error(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())

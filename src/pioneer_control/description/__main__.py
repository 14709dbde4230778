"""Prints the URDF of a robot: ``rosrun pioneer_control describe p3dx-sh [--gripper] [--laser] [--ptz] [--arm]``."""

import argparse
import sys
from typing import List, Optional

from ..errors import UsageError
from ..robots import load_table
from .parts import Parts
from .urdf import describe

PARTS = {"gripper": "the gripper", "laser": "a laser", "ptz": "a Canon VC-C4 camera", "arm": "a Pioneer Arm"}


def main(arguments: Optional[List[str]] = None) -> int:
    """Print the URDF of a model and return exit code 0. With wrong arguments the program ends with exit code 2."""
    parser = argparse.ArgumentParser(prog="describe", description="Print the URDF of a robot.")
    parser.add_argument("model", nargs="?", help="the robot's subtype, as it announces it: p3dx-sh")
    for part, meaning in PARTS.items():
        parser.add_argument("--" + part, action="store_true", help="it carries %s" % meaning)
    parser.add_argument("--prefix", default="", help="put before the name of every link")
    parser.add_argument("--models-file", help="your own models")
    parser.add_argument("--picture", metavar="FILE", help="draw all models on one sheet instead")
    given = parser.parse_args(arguments)
    try:
        table = load_table(given.models_file)
        if given.picture:
            from .picture import draw       # matplotlib takes a second
            draw(table.models.values(), given.picture)
        elif given.model is None:
            parser.error("which robot? known: %s" % ", ".join(sorted(table.models)))
        else:
            parts = Parts(**{part: getattr(given, part) for part in PARTS})
            sys.stdout.write(describe(table.find(given.model), parts, given.prefix))
    except UsageError as error:
        parser.error(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())

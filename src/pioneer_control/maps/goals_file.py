"""The places that people name on a map: a small YAML file beside it, ``lab.goals.yaml`` beside ``lab.yaml``::

    goals:
      - {name: kitchen, position_m: [3.0, 1.5], heading_deg: 90}

The section is that of our own worlds.
"""

import math
from pathlib import Path
from typing import Dict, Mapping

import yaml

from ..errors import WorldError
from ..floor_poses import Pose
from ..parameters import Number, Numbers, Text
from ..whole_file import writing
from .yaml_nodes import FARTHEST, NodeReader, compose

ENDING = ".goals.yaml"
"""How the name of such a file ends."""
NEEDS = {"name": Text(), "position_m": Numbers(2, -FARTHEST, FARTHEST), "heading_deg": Number(-math.inf)}
"""Keys of a place."""


def goals_file(map_file: str) -> Path:
    """Return the path of the file with the places of a map."""
    return Path(map_file).with_suffix(ENDING)


def read_goals(path: Path) -> Dict[str, Pose]:
    """Return the places of a file by name: x, y (m) and heading (rad) in the map frame.

    Raises:
        WorldError: the file cannot be read or is not legal. The message names the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError("file of places %s cannot be read: %s" % (path, error)) from error
    root = compose(path, text, _GoalsReader.kind)
    return _GoalsReader(path).read(root) if root is not None else {}


def write_goals(goals: Mapping[str, Pose], path: Path) -> None:
    """Write places into a file, completely or not at all.

    Raises:
        WorldError: the file cannot be written.
    """
    # float: YAML knows no numbers of numpy, which the pose of a robot may have
    rows = [{"name": name, "position_m": [round(float(pose.x), 3), round(float(pose.y), 3)],
             "heading_deg": round(math.degrees(pose.heading), 1)} for name, pose in goals.items()]
    try:
        with writing(str(path)) as part:
            Path(part).write_text(yaml.safe_dump({"goals": rows}, allow_unicode=True, sort_keys=False),
                                  encoding="utf-8")
    except (OSError, ValueError) as error:
        raise WorldError("file of places %s cannot be written: %s"
                         % (path, getattr(error, "strerror", None) or error)) from error


class _GoalsReader(NodeReader):
    """Reads the YAML file of the places."""

    kind = "file of places"

    def read(self, root: yaml.Node) -> Dict[str, Pose]:
        """Return the places. `root` is the root node of the file."""
        goals: Dict[str, Pose] = self.mapping(root, "a file of places", {"goals": self.goals})["goals"]
        return goals

    def goals(self, node: yaml.Node) -> Dict[str, Pose]:
        """Return the places of the section `goals`."""
        found: Dict[str, Pose] = {}
        for entry, goal in self.mappings(node, "goals", "a goal", NEEDS):
            if goal["name"] in found:
                self.fail(entry, "there are two goals named %r; names must differ" % goal["name"])
            x, y = goal["position_m"]
            found[goal["name"]] = Pose(x, y, math.radians(goal["heading_deg"]))
        return found

"""Worlds in the package's own form: a YAML file of walls, furniture, cans and poses.

`loading.load_world` has its keys.
"""

import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import yaml

from ...errors import WorldError
from .geometry import Point, Pose
from .shapes import Wall, box_walls
from .world import SONAR_PLANE, Can, World, begin_at
from .yaml_nodes import NodeReader, Read


def read_world_file(path: Path, root: Optional[yaml.Node], load_map: Callable[[Path], World]) -> World:
    """The world of a file.

    Args:
        root: of its nodes.
        load_map: reads the map of another kind that the file may name.
    """
    return _WorldReader(path, load_map).world(root)


class _WorldReader(NodeReader):
    """One method for each section and kind of entry."""

    def __init__(self, path: Path, load_map: Callable[[Path], World]):
        super().__init__(path)
        self._load_map = load_map

    def world(self, root: Optional[yaml.Node]) -> World:
        if root is None:
            raise WorldError("world file %s is empty; it needs at least 'starts'" % self.path)
        sections = self.mapping(root, "a world", needs={"starts": self.starts}, may={
            "description": self.text, "map": self.map, "walls": self.walls, "boxes": self.boxes, "posts": self.posts,
            "cans": self.cans,
            "docks": self.docks, "goals": self.goals,
        })
        below = sections.get("map")
        return World(
            name=self.path.stem,
            walls=(below.walls.tolist() if below else []) + sections.get("walls", []) + sections.get("boxes", []),
            posts=sections.get("posts", []),
            cans=sections.get("cans", []),
            starts=sections["starts"],
            docks=(below.docks if below else []) + sections.get("docks", []),
            goals={**(below.goals if below else {}), **sections.get("goals", {})},
            skipped=[sentence for sentence in below.skipped if not sentence.endswith(begin_at(below.starts[0]))]
            if below else (),
        )

    def walls(self, node: yaml.Node) -> List[Wall]:
        segments = []
        for entry in self.items(node, "walls"):
            wall = self.mapping(entry, "a wall", needs={"corners_m": self.corners}, may={"closed": self.boolean})
            corners = wall["corners_m"] + (wall["corners_m"][:1] if wall.get("closed") else [])
            for first, second in zip(corners, corners[1:]):
                if first == second:
                    self.fail(entry, "a wall from %s to itself; corners that follow each other must differ"
                              % list(first))
                segments.append(first + second)
        return segments

    def boxes(self, node: yaml.Node) -> List[Wall]:
        segments: List[Wall] = []
        for entry in self.items(node, "boxes"):
            needs = {"centre_m": self.point, "size_m": self.size}
            box = self.mapping(entry, "a box", needs, may={"angle_deg": self.number})
            segments += box_walls(box["centre_m"], box["size_m"], math.radians(box.get("angle_deg", 0.0)))
        return segments

    def posts(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        needs = {"centre_m": self.point, "diameter_m": self.positive}
        posts = [self.mapping(entry, "a post", needs=needs) for entry in self.items(node, "posts")]
        return [post["centre_m"] + (post["diameter_m"] / 2.0,) for post in posts]

    def cans(self, node: yaml.Node) -> List[Can]:
        sizes = {"diameter_m": self.positive, "height_m": self.can_height}
        cans = []
        for entry in self.items(node, "cans"):
            can = self.mapping(entry, "a can", needs={"centre_m": self.point}, may=sizes)
            own = {"radius": can["diameter_m"] / 2.0} if "diameter_m" in can else {}
            own.update({"height": can["height_m"]} if "height_m" in can else {})
            cans.append(Can(*can["centre_m"], **own))
        return cans

    def poses(self, node: yaml.Node, what: str, **more: Read) -> List[Dict[str, Any]]:
        """Entries with a `pose`, each with its node and with what else it `needs`."""
        needs = {**more, "position_m": self.point, "heading_deg": self.number}
        entries: List[Dict[str, Any]] = []
        for entry in self.items(node, "%ss" % what.split()[1]):
            values = self.mapping(entry, what, needs)
            pose = values["position_m"] + (math.radians(values["heading_deg"]),)
            entries.append({**values, "node": entry, "pose": pose})
        return entries

    def starts(self, node: yaml.Node) -> List[Pose]:
        starts = [start["pose"] for start in self.poses(node, "a start")]
        if not starts:
            self.fail(node, "starts is empty; a robot has to stand somewhere")
        return starts

    def docks(self, node: yaml.Node) -> List[Pose]:
        return [dock["pose"] for dock in self.poses(node, "a dock")]

    def goals(self, node: yaml.Node) -> Dict[str, Pose]:
        goals: Dict[str, Pose] = {}
        for goal in self.poses(node, "a goal", name=self.text):
            if goal["name"] in goals:
                self.fail(goal["node"], "there are two goals named %r; names must differ" % goal["name"])
            goals[goal["name"]] = goal["pose"]
        return goals

    def map(self, node: yaml.Node) -> World:
        try:
            return self._load_map(self.path.parent / self.text(node))
        except WorldError as error:
            self.fail(node, "map: %s" % error)

    def corners(self, node: yaml.Node) -> List[Point]:
        corners = [self.point(entry) for entry in self.items(node, "corners_m")]
        if len(corners) < 2:
            self.fail(node, "corners_m needs two points or more, [[x, y], [x, y], ...]")
        return corners

    def can_height(self, node: yaml.Node) -> float:
        value = self.positive(node)
        if value >= SONAR_PLANE:
            self.fail(node, "a can must be lower than the sonar, %s m, not %g; a post is what the sonar sees"
                      % (SONAR_PLANE, value))
        return value

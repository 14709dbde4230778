"""Worlds in the package's own form: a YAML file of walls, furniture, cans and poses.

`world_loader.load_world` has its keys.
"""

import math
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import yaml

from ...errors import WorldError
from .poses import Pose, Wall, box_walls
from .world import SONAR_PLANE, Can, World, begin_at
from .yaml_nodes import NodeReader


class WorldReader(NodeReader):
    """Reads a world file: one method for each section and kind of entry.

    Args:
        path: of the file.
        load_map: reads the map of another kind that the file may name.
    """

    def __init__(self, path: Path, load_map: Callable[[Path], World]):
        super().__init__(path)
        self._load_map = load_map
        self._placed = {"position_m": self.point, "heading_deg": self.number}

    def world(self, root: Optional[yaml.Node]) -> World:
        """The world of the file, from the root of its nodes."""
        if root is None:
            raise WorldError("world file %s is empty; it needs at least 'starts'" % self.path)
        sections = self.mapping(root, "a world", needs={"starts": self.starts}, may={
            "description": self.text, "map": self.map, "walls": self.walls, "boxes": self.boxes, "posts": self.posts,
            "cans": self.cans, "docks": self.docks, "goals": self.goals,
        })
        below = sections.get("map") or World("nothing")
        return World(
            name=self.path.stem,
            walls=below.walls.tolist() + sections.get("walls", []) + sections.get("boxes", []),
            posts=sections.get("posts", []),
            cans=sections.get("cans", []),
            starts=sections["starts"],
            docks=below.docks + sections.get("docks", []),
            goals={**below.goals, **sections.get("goals", {})},
            skipped=[sentence for sentence in below.skipped if not sentence.endswith(begin_at(below.starts[0]))],
        )

    def walls(self, node: yaml.Node) -> List[Wall]:
        """The segments of section `walls`."""
        segments = []
        needs, may = {"corners_m": self.corners}, {"closed": self.boolean}
        for entry, wall in self.mappings(node, "walls", "a wall", needs, may):
            corners = wall["corners_m"] + (wall["corners_m"][:1] if wall.get("closed") else [])
            for first, second in zip(corners, corners[1:]):
                if first == second:
                    self.fail(entry, "a wall from %s to itself; corners that follow each other must differ"
                              % list(first))
                segments.append(first + second)
        return segments

    def boxes(self, node: yaml.Node) -> List[Wall]:
        """Section `boxes`: four walls for each."""
        needs, may = {"centre_m": self.point, "size_m": self.size}, {"angle_deg": self.number}
        return [wall for _, box in self.mappings(node, "boxes", "a box", needs, may)
                for wall in box_walls(box["centre_m"], box["size_m"], math.radians(box.get("angle_deg", 0.0)))]

    def posts(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        """Section `posts`: x, y and radius (m) of each."""
        needs = {"centre_m": self.point, "diameter_m": self.positive}
        return [post["centre_m"] + (post["diameter_m"] / 2.0,)
                for _, post in self.mappings(node, "posts", "a post", needs)]

    def cans(self, node: yaml.Node) -> List[Can]:
        """Section `cans`."""
        sizes = {"diameter_m": self.positive, "height_m": self.can_height}
        cans = self.mappings(node, "cans", "a can", {"centre_m": self.point}, sizes)
        return [Can(can["centre_m"][0], can["centre_m"][1], can.get("diameter_m", 2.0 * Can.radius) / 2.0,
                    can.get("height_m", Can.height)) for _, can in cans]

    def starts(self, node: yaml.Node) -> List[Pose]:
        """Section `starts`, which has at least one."""
        starts = [_pose(start) for _, start in self.mappings(node, "starts", "a start", self._placed)]
        if not starts:
            self.fail(node, "starts is empty; a robot has to stand somewhere")
        return starts

    def docks(self, node: yaml.Node) -> List[Pose]:
        """Section `docks`."""
        return [_pose(dock) for _, dock in self.mappings(node, "docks", "a dock", self._placed)]

    def goals(self, node: yaml.Node) -> Dict[str, Pose]:
        """Section `goals`: poses by name."""
        goals: Dict[str, Pose] = {}
        for entry, goal in self.mappings(node, "goals", "a goal", {"name": self.text, **self._placed}):
            if goal["name"] in goals:
                self.fail(entry, "there are two goals named %r; names must differ" % goal["name"])
            goals[goal["name"]] = _pose(goal)
        return goals

    def map(self, node: yaml.Node) -> World:
        """The world of the map that `map` names. Its path counts from this file."""
        try:
            return self._load_map(self.path.parent / self.text(node))
        except WorldError as error:
            self.fail(node, "map: %s" % error)

    def corners(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        """The points along a wall, two or more."""
        corners = [self.point(entry) for entry in self.items(node, "corners_m")]
        if len(corners) < 2:
            self.fail(node, "corners_m needs two points or more, [[x, y], [x, y], ...]")
        return corners

    def can_height(self, node: yaml.Node) -> float:
        """A height (m) below the plane of the sonar."""
        self.positive(node)
        return self.legal_number(
            node, lambda value: value < SONAR_PLANE,
            "a can must be lower than the sonar, %s m, not %%g; a post is what the sonar sees" % SONAR_PLANE)


def _pose(entry: Dict[str, Any]) -> Pose:
    """The pose that an entry of `starts`, `docks` or `goals` gives."""
    x, y = entry["position_m"]
    return x, y, math.radians(entry["heading_deg"])

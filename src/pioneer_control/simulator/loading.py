"""Reads worlds from YAML files, strictly: what the file does not say exactly is an error with its line."""

import difflib
import math
from pathlib import Path
from typing import Any, Callable, Dict, List, NoReturn, Optional, Tuple, Union

import yaml

from ..errors import WorldError
from .exact import cos, sin
from .world import SONAR_PLANE, Can, World

GALLERY = Path(__file__).parent / "worlds"

Point = Tuple[float, float]


def known_worlds() -> List[str]:
    """Names of the worlds that come with the package."""
    return sorted(path.stem for path in GALLERY.glob("*.yaml"))


def load_world(name_or_path: Union[str, Path]) -> World:
    """A world of the package by its name, or any world file by its path (a `/` in it, or ending in `.yaml` or `.yml`).

    The file is a YAML mapping; metres and degrees, as the keys say; x and y of the map frame; angles count counter-clockwise
    from x. Every section but `starts` may be left out::

        description: One line for people.
        walls:                                # thin walls along a line of two corners or more
          - {corners_m: [[0, 0], [8, 0], [8, 6]]}
          - {corners_m: [[2, 2], [3, 2], [3, 3]], closed: true}
        boxes:                                # furniture: four walls
          - {centre_m: [1, 5], size_m: [0.8, 0.4], angle_deg: 30}     # size along x and y before turning; angle_deg 0 if left out
        posts:                                # columns, legs: taller than the sonar plane, like all of the above
          - {centre_m: [5, 3], diameter_m: 0.05}
        cans:                                 # what the gripper picks up: too low for the sonar
          - {centre_m: [2.2, 1], diameter_m: 0.066, height_m: 0.115}  # sizes as here if left out
        starts:                               # where a robot stands at first; the first is the default
          - {position_m: [1, 1], heading_deg: 0}

    :raises WorldError: names the file, the line, and what is legal there.
    """
    path = _find(name_or_path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"world file {path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
        line = f", line {mark.line + 1}" if mark else ""
        raise WorldError(f"world file {path}{line}: not YAML: {problem or ' '.join(str(error).split())}") from error
    return _Reader(path).world(root)


def _find(name_or_path: Union[str, Path]) -> Path:
    name = str(name_or_path)
    if "/" in name or name.endswith((".yaml", ".yml")):
        if not Path(name).is_file():
            raise WorldError(f"world file {name} does not exist; worlds known by name: {', '.join(known_worlds())}")
        return Path(name)
    if name not in known_worlds():
        near = difflib.get_close_matches(name, known_worlds(), n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise WorldError(f"no world named {name!r}; {hint}known: {', '.join(known_worlds())}; or give the path of a .yaml file")
    return GALLERY / f"{name}.yaml"


class _Reader:
    """Turns the nodes of one parsed file, which know their lines, into a world."""

    def __init__(self, path: Path):
        self._path = path

    def fail(self, node: yaml.Node, message: str) -> NoReturn:
        raise WorldError(f"world file {self._path}, line {node.start_mark.line + 1}: {message}")

    def world(self, root: Optional[yaml.Node]) -> World:
        if root is None:
            raise WorldError(f"world file {self._path} is empty; it needs at least 'starts'")
        sections = self.mapping(root, "a world", needs={"starts": self.starts}, may={
            "description": self.text, "walls": self.walls, "boxes": self.boxes, "posts": self.posts, "cans": self.cans,
        })
        return World(
            name=self._path.stem,
            walls=sections.get("walls", []) + sections.get("boxes", []),
            posts=sections.get("posts", []),
            cans=sections.get("cans", []),
            starts=sections["starts"],
        )

    def walls(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        segments = []
        for entry in self.items(node, "walls"):
            wall = self.mapping(entry, "a wall", needs={"corners_m": self.corners}, may={"closed": self.boolean})
            corners = wall["corners_m"] + (wall["corners_m"][:1] if wall.get("closed") else [])
            for first, second in zip(corners, corners[1:]):
                if first == second:
                    self.fail(entry, f"a wall from {list(first)} to itself; corners that follow each other must differ")
                segments.append(first + second)
        return segments

    def boxes(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        segments = []
        for entry in self.items(node, "boxes"):
            box = self.mapping(entry, "a box", needs={"centre_m": self.point, "size_m": self.size}, may={"angle_deg": self.number})
            segments += box_walls(*box["centre_m"], *box["size_m"], math.radians(box.get("angle_deg", 0.0)))
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

    def starts(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        needs = {"position_m": self.point, "heading_deg": self.number}
        starts = [self.mapping(entry, "a start", needs=needs) for entry in self.items(node, "starts")]
        if not starts:
            self.fail(node, "starts is empty; a robot has to stand somewhere")
        return [start["position_m"] + (math.radians(start["heading_deg"]),) for start in starts]

    def mapping(
        self, node: yaml.Node, what: str, needs: Dict[str, Callable], may: Optional[Dict[str, Callable]] = None
    ) -> Dict[str, Any]:
        """The values of a mapping that has all the keys of `needs` and perhaps some of `may`, each read by its function."""
        legal = {**needs, **(may or {})}
        if not isinstance(node, yaml.MappingNode):
            self.fail(node, f"{what} must be a mapping with the keys {', '.join(legal)}")
        values: Dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = key_node.value
            if not isinstance(key_node, yaml.ScalarNode):
                self.fail(key_node, f"keys must be plain words; known: {', '.join(legal)}")
            if key not in legal:
                near = difflib.get_close_matches(key, legal, n=1)
                hint = f"; did you mean {near[0]!r}?" if near else f"; known: {', '.join(legal)}"
                self.fail(key_node, f"{what} has no {key!r}{hint}")
            if key in values:
                self.fail(key_node, f"{what} has {key!r} twice")
            values[key] = legal[key](value_node)
        missing = [key for key in needs if key not in values]
        if missing:
            self.fail(node, f"{what} needs {' and '.join(missing)}")
        return values

    def items(self, node: yaml.Node, what: str) -> List[yaml.Node]:
        if not isinstance(node, yaml.SequenceNode):
            self.fail(node, f"{what} must be a list")
        return node.value

    def corners(self, node: yaml.Node) -> List[Point]:
        corners = [self.point(entry) for entry in self.items(node, "corners_m")]
        if len(corners) < 2:
            self.fail(node, "corners_m needs two points or more, [[x, y], [x, y], ...]")
        return corners

    def point(self, node: yaml.Node) -> Point:
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != 2:
            self.fail(node, "a point must be two numbers, [x, y]")
        return self.number(node.value[0]), self.number(node.value[1])

    def size(self, node: yaml.Node) -> Point:
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != 2:
            self.fail(node, "a size must be two numbers above 0, [along x, along y]")
        return self.positive(node.value[0]), self.positive(node.value[1])

    def number(self, node: yaml.Node) -> float:
        try:
            value = float(node.value) if node.tag in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float") else math.nan
        except ValueError:  # YAML's own spellings, such as 0x10 and 1:30
            value = math.nan
        if not math.isfinite(value):
            given = repr(node.value) if isinstance(node, yaml.ScalarNode) else "a list or mapping"
            self.fail(node, f"a finite number is needed here, not {given}")
        return value

    def positive(self, node: yaml.Node) -> float:
        value = self.number(node)
        if value <= 0.0:
            self.fail(node, f"must be above 0, not {value:g}")
        return value

    def can_height(self, node: yaml.Node) -> float:
        value = self.positive(node)
        if value >= SONAR_PLANE:
            self.fail(node, f"a can must be lower than the sonar, {SONAR_PLANE} m, not {value:g}; a post is what the sonar sees")
        return value

    def boolean(self, node: yaml.Node) -> bool:
        if node.tag != "tag:yaml.org,2002:bool":
            self.fail(node, "true or false is needed here")
        return node.value.lower() in ("true", "yes", "on")

    def text(self, node: yaml.Node) -> str:
        if node.tag != "tag:yaml.org,2002:str":
            self.fail(node, "text is needed here")
        return node.value


def box_walls(x: float, y: float, length: float, width: float, angle: float) -> List[Tuple[float, ...]]:
    """The four walls of a box: its middle, its sides along x and y before it is turned by `angle`."""
    forward = (cos(angle) * length / 2.0, sin(angle) * length / 2.0)
    left = (-sin(angle) * width / 2.0, cos(angle) * width / 2.0)
    corners = [
        (x + ahead * forward[0] + aside * left[0], y + ahead * forward[1] + aside * left[1])
        for ahead, aside in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return [first + second for first, second in zip(corners, corners[1:] + corners[:1])]

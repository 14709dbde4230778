"""Loads worlds by name or from files in three formats: our own, maps of ROS's map_server, and maps of ARIA.

Our own format is a YAML file of walls, furniture, cans and poses. `load_world` documents its keys.
"""

import math
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Union

import yaml

from ...errors import WorldError
from ...maps.ros_map import RosMapReader
from ...maps.yaml_nodes import LENGTH, NodeReader, Read, compose
from ...parameters import Choice, Number, Numbers, Switch, Text, Whole, nearest
from .aria_map import FIRST_LINE, AriaMap
from .generated import KINDS, named_world
from .materials import BUILT, Material
from .poses import Pose, Wall, box_corners
from .ros_map import world_of_map
from .world import SONAR_PLANE, Can, Furniture, MarkedPlace, Walk, World, begin_at

GALLERY = Path(__file__).parents[1] / "worlds"
ENDINGS = (".yaml", ".yml", ".map")
PICTURES = (".pgm", ".png")
POINT, ANGLE = Numbers(2, -math.inf, math.inf), Number(-math.inf)
PLACED = {"position_m": POINT, "heading_deg": ANGLE}
"""Keys of a pose."""
MATERIAL: Dict[str, Read] = {"material": Choice(tuple(BUILT))}
"""Key of what a wall, a box or a post is made of."""


def known_worlds() -> List[str]:
    """Return the sorted names of the worlds that come with the package."""
    return sorted(path.stem for path in GALLERY.glob("*.yaml"))


def load_world(name_or_path: Union[str, Path]) -> World:
    """Return a world of the package or a generated world by its name, or load a world from a file by its path.

    A generated world is named by kind and seed, such as ``offices-7``; see `generated`. An argument that has a `/` in
    it, or ends in one of `ENDINGS` or `PICTURES`, is a path. The content of the file decides how it is read:

    * a text whose first line is ``2D-Map``: see `aria_map`;
    * a YAML mapping with the key ``image``: see `ros_map`;
    * any other text: as the package's own format.

    The package's own format is a YAML mapping. Its keys name the units, metres or degrees. Coordinates are in the map
    frame; angles are counter-clockwise from the x axis. Every section except `starts` may be left out::

        description: One line for people.
        map: lab.yaml                         # adds walls, docks, goals of a map of another kind; path from this file
        walls:                                # thin walls along a line of two corners or more
          - {corners_m: [[0, 0], [8, 0], [8, 6]]}
          - {corners_m: [[2, 2], [3, 2], [3, 3]], closed: true}
        boxes:                                # furniture: four walls
          - {centre_m: [1, 5], size_m: [0.8, 0.4], angle_deg: 30}     # size before turning; angle 0 if left out
        posts:                                # cylinders: columns, legs; taller than the sonar, as walls and boxes are
          - {centre_m: [5, 3], diameter_m: 0.05, material: dark}    # for lasers: also glass, mirror, reflector, plain
        cans:                                 # objects that the gripper picks up: too low for the sonar
          - {centre_m: [2.2, 1], diameter_m: 0.066, height_m: 0.115}  # default sizes
        starts:                               # where robots stand at first: the first robot at the first start
          - {position_m: [1, 1], heading_deg: 0}
        docks:                                # the pose of a robot while it charges
          - {position_m: [0.4, 1], heading_deg: 180}
        goals:                                # places by name
          - {name: window, position_m: [7, 5], heading_deg: 90}
        places:                               # areas by name, into which cans are brought: rectangles and discs
          - {name: depot, centre_m: [6, 1], size_m: [1.5, 1]}
          - {name: hole, centre_m: [1, 4], diameter_m: 0.5}
        unmapped:                             # solid and heard like boxes and posts, but on no map
          boxes:
            - {centre_m: [4, 2], size_m: [0.4, 0.3], angle_deg: 20}
          posts:
            - {centre_m: [5, 5], diameter_m: 0.2}
        walkers:                              # people who walk: to and fro along a path, or to random places by a seed
          - {path_m: [[1, 3], [6, 3]], speed_m_s: 0.8, pause_s: 1, blind: true}   # blind: walks into robots
          - {seed: 3}                         # 0.5 m/s, pauses of 2 s, and does not walk into robots

    `World.skipped` lists the entries of a map of another kind that are not part of its world.

    Raises:
        WorldError: the world does not exist, or its file cannot be read or is not legal. For an illegal value, the
            message names the file, the line, the value, and the legal values.
    """
    return named_world(str(name_or_path)) or _read(_find(name_or_path), of_any_kind=True)


def _read(path: Path, of_any_kind: bool = False) -> World:
    """Load the world of a map of ARIA or map_server. If `of_any_kind`, the file may also have our own format."""
    text = _text(path)
    if path.suffix == ".map" or text.split("\n", 1)[0].strip() == FIRST_LINE:
        return AriaMap(path).world(text)
    root = compose(path, text)
    if isinstance(root, yaml.MappingNode) and any(key.value == "image" for key, _ in root.value):
        return world_of_map(RosMapReader(path), root)
    if of_any_kind:
        return _WorldReader(path).world(root)
    raise WorldError("%s is neither an ARIA map (first line %s) nor one of map_server (YAML with the key image)"
                     % (path, FIRST_LINE))


def _text(path: Path) -> str:
    """Return the text of a file, which must be UTF-8.

    In a ``.map`` file, bytes that are not UTF-8 are replaced, because names in ARIA maps may have another encoding.
    """
    try:
        return path.read_text(encoding="utf-8", errors="replace" if path.suffix == ".map" else "strict")
    except (OSError, UnicodeDecodeError) as error:
        hint = "; of a picture, give the YAML file beside it" if path.suffix in PICTURES else ""
        raise WorldError("file %s cannot be read: %s%s"
                         % (path, getattr(error, "strerror", None) or error, hint)) from error


def _find(name_or_path: Union[str, Path]) -> Path:
    name = str(name_or_path)
    if "/" in name or name.endswith(ENDINGS + PICTURES):
        path = Path(name)
        if not path.is_file():
            below = "" if path.is_absolute() else " below %s" % Path.cwd()
            what = "is a directory" if path.is_dir() else "does not exist" + below
            raise WorldError("file %s %s; worlds known by name: %s" % (name, what, ", ".join(known_worlds())))
        return path
    if name not in known_worlds():
        near = nearest(name, known_worlds())
        hint = "did you mean %r? " % near if near else ""
        raise WorldError("no world named %r; %sknown: %s; or KIND-SEED, such as offices-7, with one of the kinds %s;"
                         " or give the path of a file (.yaml, .map)"
                         % (name, hint, ", ".join(known_worlds()), ", ".join(sorted(KINDS))))
    return GALLERY / ("%s.yaml" % name)


class _WorldReader(NodeReader):
    """Reads a world file in the package's own format, with one method for each section and kind of entry.

    Args:
        path: path of the file.
    """

    def world(self, root: Optional[yaml.Node]) -> World:
        """Return the world of the file. `root` is the root node of its YAML, None for an empty file.

        Raises:
            WorldError: the file is empty or not legal.
        """
        if root is None:
            raise WorldError("world file %s is empty; it needs at least 'starts'" % self.path)
        sections = self.mapping(root, "a world", needs={"starts": self.starts}, may={
            "description": Text(), "map": self.map, "walls": self.walls, "boxes": self.boxes, "posts": self.posts,
            "cans": self.cans, "docks": self.docks, "goals": self.goals, "places": self.places,
            "unmapped": self.unmapped, "walkers": self.walkers,
        })
        below = sections.get("map") or World("nothing")
        boxes, posts = sections.get("boxes", []), sections.get("posts", [])
        walls = [(wall, Material(made_of)) for wall, made_of in zip(below.walls.tolist(), below.materials)]
        walls += sections.get("walls", []) + [(wall, box.material) for box in boxes for wall in box.walls]
        return World(
            name=self.path.stem,
            walls=[wall for wall, _ in walls],
            posts=[each for post in posts for each in post.posts],
            cans=sections.get("cans", []),
            starts=sections["starts"],
            docks=below.docks + sections.get("docks", []),
            goals={**below.goals, **sections.get("goals", {})},
            skipped=[sentence for sentence in below.skipped if not sentence.endswith(begin_at(below.starts[0]))],
            boxes=below.boxes + [box.corners for box in boxes],
            places=sections.get("places", []),
            unmapped=sections.get("unmapped", []),
            walks=sections.get("walkers", []),
            materials=[made_of for _, made_of in walls] + [post.material for post in posts],
        )

    def walls(self, node: yaml.Node) -> List[Tuple[Wall, Material]]:
        """Return the segments (m) of section `walls`, with their materials."""
        segments = []
        may: Dict[str, Read] = {"closed": Switch(), **MATERIAL}
        for entry, wall in self.mappings(node, "walls", "a wall", {"corners_m": self.corners}, may):
            corners = wall["corners_m"] + (wall["corners_m"][:1] if wall.get("closed") else [])
            for first, second in zip(corners, corners[1:]):
                if first == second:
                    self.fail(entry, "a wall from %s to itself; corners that follow each other must differ"
                              % list(first))
                segments.append((first + second, _material(wall)))
        return segments

    def boxes(self, node: yaml.Node) -> List[Furniture]:
        """Return the boxes of section `boxes`."""
        needs = {"centre_m": POINT, "size_m": Numbers(2, LENGTH.low, math.inf)}
        boxes = self.mappings(node, "boxes", "a box", needs, {"angle_deg": ANGLE, **MATERIAL})
        return [Furniture(tuple(box_corners(box["centre_m"], box["size_m"], math.radians(box.get("angle_deg", 0.0)))),
                          material=_material(box)) for _, box in boxes]

    def posts(self, node: yaml.Node) -> List[Furniture]:
        """Return the posts of section `posts`, each alone."""
        posts = self.mappings(node, "posts", "a post", {"centre_m": POINT, "diameter_m": LENGTH}, MATERIAL)
        return [Furniture(posts=(post["centre_m"] + (post["diameter_m"] / 2.0,),), material=_material(post))
                for _, post in posts]

    def cans(self, node: yaml.Node) -> List[Can]:
        """Return the cans of section `cans`."""
        sizes = {"diameter_m": LENGTH, "height_m": self.can_height}
        cans = self.mappings(node, "cans", "a can", {"centre_m": POINT}, sizes)
        return [Can(can["centre_m"][0], can["centre_m"][1], can.get("diameter_m", 2.0 * Can.radius) / 2.0,
                    can.get("height_m", Can.height)) for _, can in cans]

    def starts(self, node: yaml.Node) -> List[Pose]:
        """Return the poses (m, rad) of section `starts`, which must not be empty."""
        starts = [_pose(start) for _, start in self.mappings(node, "starts", "a start", PLACED)]
        if not starts:
            self.fail(node, "starts is empty; a robot has to stand somewhere")
        return starts

    def docks(self, node: yaml.Node) -> List[Pose]:
        """Return the poses (m, rad) of section `docks`."""
        return [_pose(dock) for _, dock in self.mappings(node, "docks", "a dock", PLACED)]

    def goals(self, node: yaml.Node) -> Dict[str, Pose]:
        """Return the poses (m, rad) of section `goals`, by name."""
        goals: Dict[str, Pose] = {}
        for entry, goal in self.mappings(node, "goals", "a goal", {"name": Text(), **PLACED}):
            if goal["name"] in goals:
                self.fail(entry, "there are two goals named %r; names must differ" % goal["name"])
            goals[goal["name"]] = _pose(goal)
        return goals

    def places(self, node: yaml.Node) -> List[MarkedPlace]:
        """Return the places of section `places`, in the order of the file."""
        places: Dict[str, MarkedPlace] = {}
        may = {"size_m": Numbers(2, LENGTH.low, math.inf), "diameter_m": LENGTH}
        for entry, place in self.mappings(node, "places", "a place", {"name": Text(), "centre_m": POINT}, may):
            if place["name"] in places:
                self.fail(entry, "there are two places named %r; names must differ" % place["name"])
            if ("size_m" in place) == ("diameter_m" in place):
                self.fail(entry, "a place needs either size_m, of a rectangle, or diameter_m, of a disc")
            x, y = place["centre_m"]
            places[place["name"]] = MarkedPlace(place["name"], x, y, place.get("size_m") or (place["diameter_m"],))
        return list(places.values())

    def unmapped(self, node: yaml.Node) -> List[Furniture]:
        """Return the obstacles of section `unmapped`."""
        found = self.mapping(node, "the section unmapped", needs={}, may={"boxes": self.boxes, "posts": self.posts})
        obstacles: List[Furniture] = found.get("boxes", []) + found.get("posts", [])
        return obstacles

    def walkers(self, node: yaml.Node) -> List[Walk]:
        """Return how the people of section `walkers` walk."""
        may = {"path_m": self.path_points, "seed": Whole(), "speed_m_s": Number(0.01, 3.0),
               "pause_s": Number(0.0, 3600.0), "blind": Switch()}
        walks = []
        for entry, walker in self.mappings(node, "walkers", "a walker", {}, may):
            if ("path_m" in walker) == ("seed" in walker):
                self.fail(entry, "a walker needs either path_m, to walk to and fro, or seed, to walk to random places")
            names = {"path_m": "path", "speed_m_s": "speed", "pause_s": "pause"}
            walks.append(Walk(**{names.get(key, key): value for key, value in walker.items()}))
        return walks

    def map(self, node: yaml.Node) -> World:
        """Load the map that the key `map` names, and return its world. The path is relative to this world file."""
        try:
            return _read(self.path.parent / self.checked("map", node, Text()))
        except WorldError as error:
            self.fail(node, "map: %s" % error)

    def corners(self, node: yaml.Node) -> List[Tuple[float, ...]]:
        """Return the corners (m) of a wall, two or more."""
        return self._points(node, "corners_m")

    def path_points(self, node: yaml.Node) -> Tuple[Tuple[float, ...], ...]:
        """Return the corners (m) of a walker's path, two or more."""
        return tuple(self._points(node, "path_m"))

    def _points(self, node: yaml.Node, key: str) -> List[Tuple[float, ...]]:
        points = [self.checked("a point of %s" % key, entry, POINT) for entry in self.items(node, key)]
        if len(points) < 2:
            self.fail(node, "%s needs two points or more, [[x, y], [x, y], ...]" % key)
        return points

    def can_height(self, node: yaml.Node) -> float:
        """Return the height (m) of a can, which must be below the sonar plane."""
        height: float = self.checked("height_m", node, LENGTH)
        if height >= SONAR_PLANE:
            self.fail(node, "a can must be lower than the sonar, %s m, not %g; a post is what the sonar sees"
                      % (SONAR_PLANE, height))
        return height


def _material(entry: Dict[str, Any]) -> Material:
    """Return what an entry of `walls`, `boxes` or `posts` is made of."""
    return BUILT[entry.get("material", "plain")]


def _pose(entry: Dict[str, Any]) -> Pose:
    """Return the pose (m, rad) of an entry of `starts`, `docks` or `goals`."""
    x, y = entry["position_m"]
    return x, y, math.radians(entry["heading_deg"])

"""Worlds by name or from files: of the package's own form, maps of ROS's map_server, and ARIA's maps."""

import difflib
from pathlib import Path
from typing import List, Union

import yaml

from ...errors import WorldError
from .aria_map import FIRST_LINE, AriaMap
from .ros_map import MapReader
from .world import World
from .world_file import WorldReader
from .yaml_nodes import compose

GALLERY = Path(__file__).parents[1] / "worlds"
ENDINGS = (".yaml", ".yml", ".map")
PICTURES = (".pgm", ".png")


def known_worlds() -> List[str]:
    """Names of the worlds that come with the package."""
    return sorted(path.stem for path in GALLERY.glob("*.yaml"))


def load_world(name_or_path: Union[str, Path]) -> World:
    """A world of the package by its name, or of a file by its path: a `/` in it, or ending in one of `ENDINGS`.

    What a file holds decides how it is read:

    * a text whose first line is ``2D-Map`` as `aria_map` says;
    * a YAML mapping with the key ``image`` as `ros_map` says;
    * any other as the package's own form.

    That form is a YAML mapping: metres and degrees, as the keys say; x and y of the map frame; angles count
    counter-clockwise from x. Every section but `starts` may be left out::

        description: One line for people.
        map: lab.yaml                         # walls, docks and goals of a map of another kind, beside this file
        walls:                                # thin walls along a line of two corners or more
          - {corners_m: [[0, 0], [8, 0], [8, 6]]}
          - {corners_m: [[2, 2], [3, 2], [3, 3]], closed: true}
        boxes:                                # furniture: four walls
          - {centre_m: [1, 5], size_m: [0.8, 0.4], angle_deg: 30}     # size before turning; angle_deg: else 0
        posts:                                # cylinders: columns, legs; sonar sees them, and all of the above
          - {centre_m: [5, 3], diameter_m: 0.05}
        cans:                                 # what the gripper picks up: too low for the sonar
          - {centre_m: [2.2, 1], diameter_m: 0.066, height_m: 0.115}  # sizes as here if left out
        starts:                               # where robots stand at first: the first robot at the first start
          - {position_m: [1, 1], heading_deg: 0}
        docks:                                # the pose of a robot while it charges
          - {position_m: [0.4, 1], heading_deg: 180}
        goals:                                # places by name
          - {name: window, position_m: [7, 5], heading_deg: 90}

    `World.skipped` tells what is in a map of another kind and is left out of its world.

    Raises:
        WorldError: names the file, the line, the value, and what is legal there.
    """
    return _read(_find(name_or_path), of_any_kind=True)


def _read(path: Path, of_any_kind: bool = False) -> World:
    """The world of a map of ARIA or of map_server; `of_any_kind`: or of a file of the package's own form."""
    text = _text(path)
    if path.suffix == ".map" or text.split("\n", 1)[0].strip() == FIRST_LINE:
        return AriaMap(path).world(text)
    root = compose(path, text)
    if isinstance(root, yaml.MappingNode) and any(key.value == "image" for key, _ in root.value):
        return MapReader(path).world(root)
    if of_any_kind:
        return WorldReader(path, load_map=_read).world(root)
    raise WorldError("%s is neither an ARIA map (first line %s) nor one of map_server (YAML with the key image)"
                     % (path, FIRST_LINE))


def _text(path: Path) -> str:
    """All of a file. Only names in an ARIA map may be of another encoding: their letters are replaced."""
    try:
        return path.read_text(encoding="utf-8", errors="replace" if path.suffix == ".map" else "strict")
    except (OSError, UnicodeDecodeError) as error:
        hint = "; of a picture, give the YAML file beside it" if path.suffix in PICTURES else ""
        raise WorldError("world file %s cannot be read: %s%s"
                         % (path, getattr(error, "strerror", None) or error, hint)) from error


def _find(name_or_path: Union[str, Path]) -> Path:
    name = str(name_or_path)
    if "/" in name or name.endswith(ENDINGS + PICTURES):
        path = Path(name)
        if not path.is_file():
            below = "" if path.is_absolute() else " below %s" % Path.cwd()
            what = "is a directory" if path.is_dir() else "does not exist" + below
            raise WorldError("world file %s %s; worlds known by name: %s" % (name, what, ", ".join(known_worlds())))
        return path
    if name not in known_worlds():
        near = difflib.get_close_matches(name, known_worlds(), n=1)
        hint = "did you mean %r? " % near[0] if near else ""
        raise WorldError("no world named %r; %sknown: %s; or give the path of a file (.yaml, .map)"
                         % (name, hint, ", ".join(known_worlds())))
    return GALLERY / ("%s.yaml" % name)

"""Loads a map to navigate on, with its named places, from any file that the simulator can load as a world.

Maps of map_server are taken cell by cell. ARIA's maps and worlds are drawn into cells of 5 cm; the floor that can be
reached from a start is free.
"""

from dataclasses import replace
from pathlib import Path
from typing import Optional, Tuple

import yaml

from ...errors import WorldError
from ...floor_poses import Pose
from ...maps.floor_map import FloorMap, Line
from ...maps.goals_file import goals_file, read_goals
from ...maps.grid_map import FREE, GridMap
from ...maps.ros_map import RosMapReader
from ...maps.yaml_nodes import compose
from ...simulator.world import World, load_world

RESOLUTION = 0.05
"""Side (m) of a cell of a map that is drawn from lines."""
MOST_AREA = 100000.0
"""Largest area (square metres) of a map that is drawn from lines: 40 million cells."""


def load_floor_map(name_or_path: str) -> FloorMap:
    """Return the map of a file, or of a world of the package by its name.

    When there is a `goals_file` beside the file, its places alone count, so that a place which was forgotten stays so.

    Raises:
        WorldError: the file cannot be read or is not legal; the message names file, line and what is legal. Or no cell
            of the map is free.
    """
    path = Path(name_or_path)
    found = _of_map_server(path) if path.suffix in (".yaml", ".yml") and path.is_file() else None
    if found is None:
        found = floor_map_of(load_world(name_or_path))
    if not (found.grid.cells == FREE).any():
        raise WorldError("map %s: no cell is free: a robot has to stand somewhere" % name_or_path)
    beside = goals_file(name_or_path)
    return replace(found, goals=read_goals(beside)) if path.is_file() and beside.exists() else found


def floor_map_of(world: World) -> FloorMap:
    """Return the map of a world.

    Raises:
        WorldError: the world is too large.
    """
    low_x, low_y, high_x, high_y = world.bounds
    width, height = high_x - low_x, high_y - low_y
    if (width + 1.0) * (height + 1.0) > MOST_AREA:
        raise WorldError("map %s: walls, starts and places lie %g m by %g m apart; at most %g square metres are legal"
                         % (world.name, width, height, MOST_AREA))
    cells, origin = world.occupancy(RESOLUTION)
    lines: Tuple[Line, ...] = tuple((x1, y1, x2, y2) for x1, y1, x2, y2 in world.forbidden.tolist())
    return FloorMap(world.name, GridMap(cells, RESOLUTION, origin),
                    {name: Pose(*pose) for name, pose in world.goals.items()},
                    tuple(Pose(*start) for start in world.starts), lines)


def _of_map_server(path: Path) -> Optional[FloorMap]:
    """Return the map of a YAML file of map_server; None for a YAML file of another kind."""
    try:
        root = compose(path, path.read_text(encoding="utf-8"), RosMapReader.kind)
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError("map %s cannot be read: %s" % (path, error)) from error
    if not isinstance(root, yaml.MappingNode) or not any(key.value == "image" for key, _ in root.value):
        return None
    return FloorMap(path.stem, RosMapReader(path).read(root).grid_map())

"""Reads and writes maps of ROS's map_server. A map is a YAML file and an image (PGM or PNG).

A cell is occupied when its occupancy is above ``occupied_thresh``, and free when its occupancy is below
``free_thresh``. All other cells are unknown.
"""

import math
from pathlib import Path
from typing import List, NamedTuple, Tuple, Union

import numpy as np
import yaml

from ..errors import WorldError
from ..parameters import Choice, Number, Numbers, Text
from ..whole_file import writing
from .goals_file import ENDING
from .grid_map import FREE, OCCUPIED, UNKNOWN, Array, GridMap
from .yaml_nodes import FARTHEST, LENGTH, NodeReader

RESOLUTION = Number(LENGTH.low, 10.0)
"""Legal sides of a cell (m)."""
FORMATS = ("PPM", "PNG")
"""Image formats that can be read, by their names in Pillow. Pillow's PPM includes PGM."""
OCCUPIED_ABOVE, FREE_BELOW = 0.65, 0.196
"""Thresholds that are written with a map: those that map_server itself writes."""
GREY = {OCCUPIED: 0, FREE: 254, UNKNOWN: 205}
"""Grey value of each value of a cell in an image that is written: those that map_server itself writes."""


class RosMap(NamedTuple):
    """A map as its file has it.

    `occupancy` is an array (rows of increasing y, columns of increasing x) from 0 to 1, NaN where nothing is known.
    `resolution` is the side of a cell (m), `origin` the pose (m, rad; map frame) of the lower left corner.
    `occupied_above` and `free_below` are its thresholds. `skipped` has one sentence for each key that means nothing.
    """

    occupancy: Array
    resolution: float
    origin: Tuple[float, float, float]
    occupied_above: float
    free_below: float
    skipped: List[str]

    @property
    def cells(self) -> Array:
        """An int8 array of `OCCUPIED`, `FREE` and `UNKNOWN`, in the frame of the image: not turned by `origin`."""
        cells = np.full(self.occupancy.shape, UNKNOWN, dtype=np.int8)
        cells[self.occupancy < self.free_below] = FREE
        cells[self.occupancy > self.occupied_above] = OCCUPIED
        return cells

    def grid_map(self) -> GridMap:
        """Return the map as a grid along the axes. A turned image is drawn anew, each cell with its nearest value."""
        x, y, heading = self.origin
        upright = GridMap(self.cells, self.resolution, (0.0, 0.0))
        if not heading:
            return GridMap(upright.cells, self.resolution, (x, y))
        cosine, sine = math.cos(heading), math.sin(heading)
        _, _, width, height = upright.bounds
        ends = np.array([(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)])
        turned = ends @ np.array([(cosine, sine), (-sine, cosine)])
        low, size = turned.min(axis=0), np.ptp(turned, axis=0)
        columns, rows = np.ceil(size / self.resolution - 1e-6).astype(int)     # rounding adds no cell
        blank = GridMap(np.zeros((rows, columns), dtype=np.int8), self.resolution, (float(low[0]), float(low[1])))
        at_x, at_y = blank.middle(*np.indices((rows, columns)))
        cells = upright.at(at_x * cosine + at_y * sine, at_y * cosine - at_x * sine)
        return GridMap(cells.astype(np.int8), self.resolution, (x + float(low[0]), y + float(low[1])))


class RosMapReader(NodeReader):
    """Reads the YAML file of a map and its image."""

    kind = "map"

    def read(self, root: yaml.Node) -> RosMap:
        """Return the map. `root` is the root node of its YAML file.

        Raises:
            WorldError: the file or its image is not legal.
        """
        others: List[yaml.Node] = []
        needs = {"image": self.image, "resolution": RESOLUTION, "origin": Numbers(3, -FARTHEST, FARTHEST),
                 "occupied_thresh": Number(0.0, 1.0), "free_thresh": Number(0.0, 1.0), "negate": Choice((0, 1))}
        values = self.mapping(root, "a map", needs, may={"mode": Choice(("trinary", "scale", "raw"))}, others=others)
        if values["free_thresh"] >= values["occupied_thresh"]:
            self.fail(root, "free_thresh %g must be below occupied_thresh %g"
                      % (values["free_thresh"], values["occupied_thresh"]))
        return RosMap(
            _occupancy(values["image"], bool(values["negate"]), values.get("mode") == "raw")[::-1],
            values["resolution"], values["origin"], values["occupied_thresh"], values["free_thresh"],
            ["line %s: %r, which means nothing here" % (key.start_mark.line + 1, key.value) for key in others])

    def image(self, node: yaml.Node) -> Array:
        """Read the image that `node` names, and return its grey values from 0 to 255.

        The result is an array (rows from the top, columns). It is NaN where the image is transparent.
        """
        from PIL import Image  # imported here, because nothing else needs it

        path = self.path.parent / self.checked("image", node, Text())
        try:
            with Image.open(path) as image:
                if image.format not in FORMATS:
                    self.fail(node, "image %s is a %s; it must be a PGM or a PNG" % (path, image.format))
                if image.mode.startswith("I"):  # 16 bits
                    return np.asarray(image, dtype=float) / 257.0
                pixels = np.asarray(image.convert("RGBA"), dtype=float)
        except WorldError:
            raise
        except Exception as error:  # for a broken file Pillow raises many kinds of exceptions
            self.fail(node, "image %s cannot be read: %s" % (path, getattr(error, "strerror", None) or error))
        return np.where(pixels[:, :, 3] > 0, (pixels[:, :, 0] + pixels[:, :, 1] + pixels[:, :, 2]) / 3.0, math.nan)


def _occupancy(grey: Array, negate: bool, raw: bool) -> Array:
    """Return the occupancy of every cell from 0 to 1, NaN where it is unknown.

    Args:
        grey: grey values of the image, 0 to 255, NaN where unknown.
        negate: light cells are occupied. If False, dark cells are occupied. Not used for `raw`.
        raw: grey values from 0 to 100 are the occupancy in percent; higher values are unknown.
    """
    if raw:
        return np.where(grey <= 100.0, grey / 100.0, math.nan)
    return grey / 255.0 if negate else (255.0 - grey) / 255.0


def check_map_file(path: Path) -> None:
    """Check that a map can have this name. Raises WorldError if it does not end in .yaml, or is one of places."""
    if path.suffix != ".yaml":
        raise WorldError("map file %s: its name must end in .yaml" % path)
    if path.name.endswith(ENDING):
        raise WorldError("map file %s: its name must not end in %s: so ends the file of places of another map"
                         % (path, ENDING))


def write_ros_map(grid_map: GridMap, path: Union[str, Path]) -> None:
    """Write a map as map_server reads it: the YAML file `path`, and beside it an image (PGM) of the same name.

    Each file is written completely or not at all.

    Raises:
        WorldError: `path` does not end in .yaml, is the name of a file of places, or a file cannot be written.
    """
    path = Path(path)
    check_map_file(path)
    image = path.with_suffix(".pgm")
    grey = np.full(grid_map.cells.shape, GREY[UNKNOWN], dtype=np.uint8)
    for value in (FREE, OCCUPIED):
        grey[grid_map.cells == value] = GREY[value]
    rows, columns = grey.shape
    x, y = grid_map.origin
    # Quoted, for a name may hold what YAML takes for its own.
    name = yaml.safe_dump(image.name, default_style='"', allow_unicode=True, width=10000).strip()
    try:
        for each in (path, image):
            if each.is_dir():
                raise WorldError("map file %s cannot be written: %s is a directory" % (path, each))
        with writing(str(image)) as part:
            Path(part).write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + grey[::-1].tobytes())
        with writing(str(path)) as part:
            Path(part).write_text(
                "image: %s\nresolution: %r\norigin: [%r, %r, 0.0]\nnegate: 0\noccupied_thresh: %s\nfree_thresh: %s\n"
                % (name, grid_map.resolution, x, y, OCCUPIED_ABOVE, FREE_BELOW), encoding="utf-8")
    except (OSError, ValueError) as error:      # ValueError: a name that no file can have
        raise WorldError("map file %s cannot be written: %s"
                         % (path, getattr(error, "strerror", None) or error)) from error

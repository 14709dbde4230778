"""Loads maps of ROS's map_server as worlds. A map is a YAML file and an image (PGM or PNG).

A cell is a wall when its occupancy is above ``occupied_thresh``, and free when its occupancy is below ``free_thresh``.
All other cells are unknown and hold no walls. The borders of the walls become few long segments (see `grids.borders`).
These maps have no start. The robot starts at the origin of the map frame if there is room, else at the most spacious
free place.
"""

import math
from typing import List

import numpy as np
import yaml

from ...errors import WorldError
from ...parameters import Choice, Number, Numbers, Text
from .geometry import Array
from .grids import borders, roomiest
from .poses import placed, relative
from .world import START_CLEARANCE, World, begin_at
from .yaml_nodes import LENGTH, NodeReader

FORMATS = ("PPM", "PNG")
"""Image formats that can be read, by their names in Pillow. Pillow's PPM includes PGM."""


class MapReader(NodeReader):
    """Reads the YAML file of a map and its image, and makes a world of them."""

    def world(self, root: yaml.Node) -> World:
        """Return the world of the map. `root` is the root node of its YAML file.

        Raises:
            WorldError: the file or its image is not legal, or no cell is free.
        """
        others: List[yaml.Node] = []
        needs = {"image": self.image, "resolution": LENGTH, "origin": Numbers(3, -math.inf, math.inf),
                 "occupied_thresh": Number(0.0, 1.0), "free_thresh": Number(0.0, 1.0), "negate": Choice((0, 1))}
        values = self.mapping(root, "a map", needs, may={"mode": Choice(("trinary", "scale", "raw"))}, others=others)
        if values["free_thresh"] >= values["occupied_thresh"]:
            self.fail(root, "free_thresh %g must be below occupied_thresh %g"
                      % (values["free_thresh"], values["occupied_thresh"]))
        occupancy = _occupancy(values["image"], bool(values["negate"]), values.get("mode") == "raw")[::-1]
        side, origin = values["resolution"], values["origin"]
        wanted_x, wanted_y, _ = relative(origin, (0.0, 0.0, 0.0))
        start = roomiest(occupancy < values["free_thresh"], (wanted_x / side, wanted_y / side), START_CLEARANCE / side)
        if start is None:
            self.fail(root, "no cell of the map is free: a robot has to stand somewhere")
        walls = np.array(borders(occupancy > values["occupied_thresh"])).reshape(-1, 2) * side
        (x, y), *ends = placed([(start[0] * side, start[1] * side), *walls.tolist()], origin)
        beginning = x, y, 0.0
        skipped = ["line %s: %r, which means nothing here" % (key.start_mark.line + 1, key.value) for key in others]
        return World(
            name=self.path.stem,
            walls=[first + second for first, second in zip(ends[::2], ends[1::2])],
            starts=[beginning],
            skipped=[*skipped, "no start in a map of this kind: %s" % begin_at(beginning)],
        )

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

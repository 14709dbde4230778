"""Saves the map that a robot makes when navigation ends. No ROS: its log has ended by then."""

import itertools
import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Callable, Mapping, Optional

from ...errors import UsageError, WorldError
from ...floor_poses import Pose, relative
from ...maps import GridMap, write_ros_map
from ...maps.goals_file import goals_file, write_goals

DRIVEN = 0.05
"""Way (m) or turn (rad) by the wheels from where it began, after which a robot has driven."""


def write_map(grid: GridMap, places: Mapping[str, Pose], file: str) -> None:
    """Write a map as map_server reads it, and its places beside it, if it has any. Raises WorldError if it cannot."""
    write_ros_map(grid, file)
    if places:
        write_goals(places, goals_file(file))


def keep_older(file: str) -> str:
    """Keep a map that has this file already, as a whole map: of ``lab.yaml`` as ``lab.1.yaml``, the next as ``lab.2``.

    Returns:
        The file in which the older map is kept now too; empty if there is none.

    Raises:
        OSError: it cannot be kept.
    """
    old = Path(file)
    beside = ".pgm", ".goals.yaml"      # what a new map replaces too
    if not old.exists():
        return ""
    kept = next(each for each in (old.with_suffix(".%d.yaml" % number) for number in itertools.count(1))
                if not any(each.with_suffix(suffix).exists() for suffix in (".yaml", *beside)))
    for suffix in beside:
        if old.with_suffix(suffix).exists():
            shutil.copy2(str(old.with_suffix(suffix)), str(kept.with_suffix(suffix)))
    text = old.read_bytes()
    image = re.search(rb"^image:[ \t]*[\"']?(.*?)[\"']?[ \t\r]*$", text, re.MULTILINE)
    if image and os.path.abspath(old.parent / os.fsdecode(image.group(1))) == os.path.abspath(old.with_suffix(".pgm")):
        text = text[:image.start(1)] + os.fsencode(kept.with_suffix(".pgm").name) + text[image.end(1):]
    kept.write_bytes(text)
    return str(kept)


class MapSaver:
    """Saves a map at the end, if the robot has driven.

    Args:
        file: the YAML file of the map.

    Raises:
        UsageError: nothing can be written there.
    """

    def __init__(self, file: str):
        self._file, folder = file, Path(file).parent
        self._begin: Optional[Pose] = None      # by the wheels
        self._has_driven = False
        if Path(file).is_dir():
            raise UsageError("~save_to is %r: that is a directory; give the name of a file in it" % file)
        try:
            tempfile.TemporaryFile(dir=str(folder)).close()
        except OSError as error:
            raise UsageError("~save_to is %r: no file can be written in the directory %s: %s" % (
                file, os.path.abspath(folder), error.strerror)) from error

    def hear(self, odometry: Pose) -> None:
        """Take the pose of the robot by its wheels."""
        if self._begin is None:
            self._begin = odometry
        self._has_driven = self._has_driven or any(abs(each) > DRIVEN for each in relative(odometry, self._begin))

    def save(self, grid: Callable[[], GridMap], places: Mapping[str, Pose]) -> str:
        """Save the map, and return for people where. If it cannot be written there, the temporary directory gets it.

        A robot that has not driven knows nearly nothing: then nothing is written.

        Args:
            grid: returns the map.
            places: its named places.
        """
        if not self._has_driven:
            return "no map is saved in %s: the robot has not driven" % self._file
        made = grid()
        try:
            kept = keep_older(self._file)
            if kept and not places:
                goals_file(self._file).unlink(missing_ok=True)      # those of the older map
            write_map(made, places, self._file)
        except OSError as error:
            why = "the older map in %s cannot be kept: %s" % (self._file, error.strerror)
            return self._elsewhere(made, places, why)
        except WorldError as error:
            return self._elsewhere(made, places, str(error))
        return "the map is saved in %s%s" % (self._file, "; the one before is kept in %s" % kept if kept else "")

    def _elsewhere(self, grid: GridMap, places: Mapping[str, Pose], why: str) -> str:
        try:
            file = os.path.join(tempfile.mkdtemp(prefix="pioneer-map-"), Path(self._file).name)
            write_map(grid, places, file)
        except (OSError, WorldError) as error:
            return "%s; THE MAP IS LOST: %s" % (why, error)
        return "%s; IT IS SAVED IN %s" % (why, file)

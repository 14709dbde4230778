"""Saves maps with their places: the one that a robot makes, when navigation ends. No ROS: its log has ended by then."""

import itertools
import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Callable, Mapping, Optional

import yaml

from ...errors import UsageError, WorldError
from ...floor_poses import Pose, relative
from ...maps import GridMap, write_ros_map
from ...maps.goals_file import ENDING, goals_file, write_goals
from ...maps.ros_map import check_map_file

DRIVEN = 0.05
"""Way (m) or turn (rad) by the wheels from where it began, after which a robot has driven."""


FILES = ".yaml", ".pgm", ENDING
"""How the names of the files of one map end: the file that map_server is given, its image, and the places."""


def write_map(grid: GridMap, places: Mapping[str, Pose], file: str, replaces: bool = False) -> str:
    """Write a map as map_server reads it, and its places beside it.

    Args:
        grid: the map.
        places: its named places.
        file: its YAML file.
        replaces: a map that is there is replaced. If False, it is kept too: see `keep_older`.

    Returns:
        Where it is saved, and where the older one is kept, for people.

    Raises:
        WorldError: it cannot be written, or the older one cannot be kept.
    """
    check_map_file(Path(file))
    try:
        kept = "" if replaces else keep_older(Path(file))
    except OSError as error:
        raise WorldError("the older map in %s cannot be kept: %s" % (file, error.strerror)) from error
    write_ros_map(grid, file)
    if places or goals_file(file).exists():     # those of another map do not stay beside it
        write_goals(places, goals_file(file))
    return "saved in %s%s" % (file, "; the one before is kept in %s" % kept if kept else "")


def keep_older(old: Path) -> str:
    """Keep a map that has this file already, as a whole map: of ``lab.yaml`` as ``lab.1.yaml``, the next as ``lab.2``.

    Returns:
        The file in which it is kept now too; empty if there is none. If only its places are there, it is theirs.

    Raises:
        OSError: it cannot be kept.
    """
    there = [suffix for suffix in FILES if old.with_suffix(suffix).is_file()]
    if not there:
        return ""
    kept = next(each for each in (old.with_suffix(".%d.yaml" % number) for number in itertools.count(1))
                if not any(each.with_suffix(suffix).exists() for suffix in FILES))
    for suffix in there:
        shutil.copy2(str(old.with_suffix(suffix)), str(kept.with_suffix(suffix)))
    if ".yaml" in there:
        kept.write_bytes(_with_image(old.read_bytes(), old, kept))
    return str(kept.with_suffix(there[0]))


def _with_image(content: bytes, old: Path, kept: Path) -> bytes:
    """Return the content of the file of a map with the image that is kept, if it has the one that is replaced."""
    try:
        values = yaml.safe_load(content)
        image = os.path.abspath(old.parent / values["image"])
    except (yaml.YAMLError, TypeError, KeyError):       # no map
        return content
    if image != os.path.abspath(old.with_suffix(".pgm")):
        return content
    values = {"image": kept.with_suffix(".pgm").name}
    line = yaml.safe_dump(values, default_style='"', allow_unicode=True, width=10000).partition(": ")[2].encode()
    return re.sub(rb"^(image\s*:\s).*$", lambda found: found.group(1) + line.strip(), content, 1, re.MULTILINE)


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
            return "the map is %s" % write_map(made, places, self._file)
        except WorldError as error:
            return self._elsewhere(made, places, str(error))

    def _elsewhere(self, grid: GridMap, places: Mapping[str, Pose], why: str) -> str:
        try:
            file = os.path.join(tempfile.mkdtemp(prefix="pioneer-map-"), "map.yaml")
            write_map(grid, places, file)
        except (OSError, WorldError) as error:
            return "%s; THE MAP IS LOST: %s" % (why, error)
        return "%s; IT IS SAVED IN %s" % (why, file)

"""Saves the map that a robot makes when navigation ends. No ROS: its log has ended by then."""

import os
import tempfile
from pathlib import Path
from typing import Callable, Mapping

from ...errors import UsageError, WorldError
from ...floor_poses import Pose
from ...maps import GridMap, write_ros_map
from ...maps.goals_file import goals_file, write_goals


def write_map(grid: GridMap, places: Mapping[str, Pose], file: str) -> None:
    """Write a map as map_server reads it, and its places beside it, if it has any. Raises WorldError if it cannot."""
    write_ros_map(grid, file)
    if places:
        write_goals(places, goals_file(file))


class MapSaver:
    """Saves a map at the end.

    Args:
        file: the YAML file of the map.

    Raises:
        UsageError: nothing can be written there.
    """

    def __init__(self, file: str):
        self._file, folder = file, Path(file).parent
        if Path(file).is_dir():
            raise UsageError("~save_to is %r: that is a directory; give the name of a file in it" % file)
        try:
            tempfile.TemporaryFile(dir=str(folder)).close()
        except OSError as error:
            raise UsageError("~save_to is %r: no file can be written in the directory %s: %s" % (
                file, os.path.abspath(folder), error.strerror)) from error

    def save(self, grid: Callable[[], GridMap], places: Mapping[str, Pose]) -> str:
        """Save the map, and return for people where. If it cannot be written there, the temporary directory gets it.

        Args:
            grid: returns the map.
            places: its named places.
        """
        made = grid()
        try:
            write_map(made, places, self._file)
        except WorldError as error:
            return self._elsewhere(made, places, str(error))
        return "the map is saved in %s" % self._file

    def _elsewhere(self, grid: GridMap, places: Mapping[str, Pose], why: str) -> str:
        try:
            file = os.path.join(tempfile.mkdtemp(prefix="pioneer-map-"), Path(self._file).name)
            write_map(grid, places, file)
        except (OSError, WorldError) as error:
            return "%s; THE MAP IS LOST: %s" % (why, error)
        return "%s; IT IS SAVED IN %s" % (why, file)

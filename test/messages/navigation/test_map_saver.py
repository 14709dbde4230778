"""The map that a robot makes is saved when navigation ends, whatever became of the place for it."""

import tempfile

import numpy as np
import pytest

from pioneer_control.errors import UsageError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, GridMap
from pioneer_control.navigation.map_files import load_floor_map
from pioneer_control.navigation.node.map_saver import MapSaver

DOOR = {"door": Pose(0.5, 0.5, 0.0)}


def grid_of(side):
    return GridMap(np.full((side, side), FREE, dtype=np.int8), 0.05, (0.0, 0.0))


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the temporary directory that the saver may use."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_a_map_and_its_places_are_saved(tmp_path):
    file = str(tmp_path / "lab.yaml")
    assert MapSaver(file).save(lambda: grid_of(20), DOOR) == "the map is saved in %s" % file
    saved = load_floor_map(file)
    assert saved.grid == grid_of(20) and saved.goals == DOOR


def test_where_nothing_can_be_written_is_said_at_the_start(tmp_path):
    (tmp_path / "taken.yaml").mkdir()
    (tmp_path / "file").write_text("")
    for file, named in ((tmp_path / "nowhere" / "lab.yaml", "nowhere: No such file"),
                        (tmp_path / "taken.yaml", "that is a directory"),
                        (tmp_path / "file" / "lab.yaml", "Not a directory")):
        with pytest.raises(UsageError, match=named):
            MapSaver(str(file))
    assert len(list(tmp_path.iterdir())) == 2, "trying leaves nothing behind"


def test_what_cannot_be_written_at_the_end_is_kept_elsewhere(tmp_path, temporary):
    folder = tmp_path / "stick"
    folder.mkdir()
    saver = MapSaver(str(folder / "lab.yaml"))
    folder.rmdir()      # somebody pulls it out
    said = saver.save(lambda: grid_of(20), DOOR)
    assert "stick/lab.yaml cannot be written: No such file" in said and "\n" not in said
    saved = load_floor_map(said.rpartition(" ")[2])
    assert said.rpartition(" ")[2].startswith(str(temporary))
    assert saved.grid == grid_of(20) and saved.goals == DOOR


def test_a_map_that_can_be_saved_nowhere_is_said_to_be_lost(tmp_path, temporary):
    saver = MapSaver(str(tmp_path / "lab.yaml"))
    (tmp_path / "lab.pgm").mkdir()
    temporary.rmdir()
    said = saver.save(lambda: grid_of(20), {})
    assert "lab.yaml cannot be written" in said and "THE MAP IS LOST" in said and "\n" not in said

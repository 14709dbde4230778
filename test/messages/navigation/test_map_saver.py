"""The map that a robot makes is saved when navigation ends, whatever became of the place for it."""

import tempfile
import types

import numpy as np
import pytest
import rospy

from pioneer_control.errors import UsageError, WorldError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, GridMap
from pioneer_control.navigation.node.map_files import load_floor_map
from pioneer_control.navigation.node.map_saver import MapSaver, write_map
from pioneer_control.navigation.node.navigation_node import NavigationNode
from pioneer_control.srv import SaveMapRequest

START = Pose(3.0, -1.0, 3.1)
DOOR = {"door": Pose(0.5, 0.5, 0.0)}


def grid_of(side):
    return GridMap(np.full((side, side), FREE, dtype=np.int8), 0.05, (0.0, 0.0))


def saver_of(file, *odometry):
    """Return a saver that has heard of a robot: by default of one that has driven 1 m."""
    saver = MapSaver(str(file))
    for pose in odometry or (START, START._replace(x=2.0)):
        saver.hear(pose)
    return saver


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the temporary directory that the saver may use."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def test_a_map_and_its_places_are_saved(tmp_path):
    file = str(tmp_path / "lab.yaml")
    assert saver_of(file).save(lambda: grid_of(20), DOOR) == "the map is saved in %s" % file
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
    saver = saver_of(folder / "lab.yaml")
    folder.rmdir()      # somebody pulls it out
    said = saver.save(lambda: grid_of(20), DOOR)
    assert "stick/lab.yaml cannot be written: No such file" in said and "\n" not in said
    saved = load_floor_map(said.rpartition(" ")[2])
    assert said.rpartition(" ")[2].startswith(str(temporary))
    assert saved.grid == grid_of(20) and saved.goals == DOOR


def test_a_map_that_can_be_saved_nowhere_is_said_to_be_lost(tmp_path, temporary):
    saver = saver_of(tmp_path / "lab.yaml")
    (tmp_path / "lab.pgm").mkdir()
    temporary.rmdir()
    said = saver.save(lambda: grid_of(20), {})
    assert "lab.yaml cannot be written" in said and "THE MAP IS LOST" in said and "\n" not in said


@pytest.mark.parametrize("odometry", [(), (START, START._replace(x=3.02, heading=-3.17))])
def test_of_a_robot_that_has_not_driven_no_map_is_saved(tmp_path, odometry):
    file = tmp_path / "lab.yaml"
    file.write_text("of yesterday")
    saver = MapSaver(str(file))
    for pose in odometry:
        saver.hear(pose)
    assert saver.save(lambda: grid_of(20), {}) == "no map is saved in %s: the robot has not driven" % file
    assert file.read_text() == "of yesterday"


@pytest.mark.parametrize("way", [(START._replace(y=-1.2), START), (START._replace(heading=-3.0),)])
def test_a_way_there_and_back_or_a_turn_is_enough(tmp_path, way):
    assert "is saved" in saver_of(tmp_path / "lab.yaml", START, *way).save(lambda: grid_of(20), {})


@pytest.mark.parametrize("image", ["", """image: '{0}/the "lab" \\ hall.pgm'  # drawn"""])
def test_older_maps_are_kept_whole(tmp_path, image):
    file = tmp_path / 'the "lab" \\ hall.yaml'
    for side, places in ((20, DOOR), (30, {}), (40, DOOR)):
        said = saver_of(file).save(lambda side=side: grid_of(side), places)
        first, _, others = file.read_text().partition("\n")
        file.write_text("%s\n%s" % (image.format(tmp_path) or first, others))
    assert said == "the map is saved in %s; the one before is kept in %s" % (file, file.with_suffix(".2.yaml"))
    for name, side, places in ((".1.yaml", 20, DOOR), (".2.yaml", 30, {}), (".yaml", 40, DOOR)):
        kept = load_floor_map(str(file.with_suffix(name)))
        assert kept.grid == grid_of(side) and kept.goals == places, name


def test_an_older_map_with_another_image_keeps_it(tmp_path):
    file = tmp_path / "lab.yaml"
    saver_of(file).save(lambda: grid_of(20), {})
    (tmp_path / "lab.pgm").rename(tmp_path / "scan.pgm")
    file.write_text(file.read_text().replace("lab.pgm", "scan.pgm"))
    saver_of(file).save(lambda: grid_of(30), {})
    assert load_floor_map(str(tmp_path / "lab.1.yaml")).grid == grid_of(20)


def test_an_older_map_that_cannot_be_kept_is_not_touched(tmp_path, temporary, monkeypatch):
    def full(source, target):
        raise OSError(28, "No space left on device")

    file = tmp_path / "lab.yaml"
    saver_of(file).save(lambda: grid_of(20), DOOR)
    monkeypatch.setattr("shutil.copy2", full)
    said = saver_of(file).save(lambda: grid_of(30), {})
    assert "cannot be kept: No space left" in said and load_floor_map(said.rpartition(" ")[2]).grid == grid_of(30)
    assert load_floor_map(str(file)).grid == grid_of(20) and load_floor_map(str(file)).goals == DOOR


def test_places_of_another_map_do_not_stay_beside_a_new_one(tmp_path):
    file = tmp_path / "lab.yaml"
    write_map(grid_of(20), DOOR, str(file))
    file.unlink()
    (tmp_path / "lab.pgm").unlink()
    said = write_map(grid_of(30), {}, str(file))
    assert said == "saved in %s; the one before is kept in %s" % (file, tmp_path / "lab.1.goals.yaml")
    assert load_floor_map(str(file)).goals == {}
    write_map(grid_of(40), {}, str(tmp_path / "lab.1.yaml"), replaces=True)
    assert load_floor_map(str(tmp_path / "lab.1.yaml")).goals == {}
    write_map(grid_of(50), {}, str(tmp_path / "hall.yaml"))
    assert not (tmp_path / "hall.goals.yaml").exists(), "without places none is needed"


def test_a_name_that_no_map_can_have_touches_nothing(tmp_path):
    file = tmp_path / "lab.goals.yaml"
    file.write_text("goals: []")
    with pytest.raises(WorldError, match="must not end in"):
        write_map(grid_of(20), {}, str(file))
    assert list(tmp_path.iterdir()) == [file]


def test_the_service_keeps_an_older_map_but_not_its_own_of_before(tmp_path, monkeypatch):
    monkeypatch.setattr(rospy, "loginfo", lambda *line: None)
    file = tmp_path / "lab.yaml"
    write_map(grid_of(20), DOOR, str(file))
    node = types.SimpleNamespace(_pilot=types.SimpleNamespace(), _keeper=types.SimpleNamespace(places={}),
                                 _written=set())
    for side in (30, 40):
        node._pilot.grid = grid_of(side)
        answer = NavigationNode._save_map(node, SaveMapRequest(str(file)))
        assert answer.success
    assert answer.message == "saved in %s" % file
    monkeypatch.chdir(tmp_path)         # who asks cannot see in which directory navigation works
    assert NavigationNode._save_map(node, SaveMapRequest("lab.yaml")).message == answer.message
    older, newer = load_floor_map(str(tmp_path / "lab.1.yaml")), load_floor_map(str(file))
    assert (older.grid, older.goals) == (grid_of(20), DOOR) and (newer.grid, newer.goals) == (grid_of(40), {})
    assert not (tmp_path / "lab.2.yaml").exists()

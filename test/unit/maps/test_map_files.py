"""Maps that are written, read again, and read from files of other programs; and the places that people name."""

import math

import numpy as np
import pytest

from pioneer_control.errors import UsageError, WorldError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, FloorMap, GridMap, write_ros_map
from pioneer_control.maps.goals_file import goals_file, read_goals, write_goals
from pioneer_control.navigation.map_files import load_floor_map

CELLS = np.array([[FREE, OCCUPIED, UNKNOWN, FREE], [FREE, FREE, FREE, OCCUPIED]], dtype=np.int8)
MAP = GridMap(CELLS, 0.05, (-1.25, 2.5))


def written(tmp_path, grid_map=MAP):
    path = tmp_path / "lab.yaml"
    write_ros_map(grid_map, path)
    return path


def test_a_map_comes_back_as_it_was_written(tmp_path):
    read = load_floor_map(str(written(tmp_path)))
    assert read == FloorMap("lab", MAP)


def test_the_image_is_that_of_map_server(tmp_path):
    written(tmp_path)
    assert (tmp_path / "lab.pgm").read_bytes() == b"P5\n4 2\n255\n" + bytes([254, 254, 254, 0, 254, 0, 205, 254])
    assert "origin: [-1.25, 2.5, 0.0]" in (tmp_path / "lab.yaml").read_text()


def test_a_turned_map_is_drawn_anew(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace("2.5, 0.0]", "2.5, %r]" % (math.pi / 2)))
    grid = load_floor_map(str(path)).grid
    assert grid.cells.tolist() == [[FREE, FREE], [FREE, OCCUPIED], [FREE, UNKNOWN], [OCCUPIED, FREE]]
    assert grid.origin == pytest.approx((-1.35, 2.5))


@pytest.mark.parametrize("change, named", [
    (("resolution: 0.05", "resolution: 0"), "resolution is 0"), (("lab.pgm", "gone.pgm"), "gone.pgm cannot be read"),
    (("free_thresh: 0.196", "free_thresh: 0.7"), "must be below occupied_thresh"),
])
def test_a_broken_map_is_named(tmp_path, change, named):
    path = written(tmp_path)
    path.write_text(path.read_text().replace(*change))
    with pytest.raises(WorldError, match=named):
        load_floor_map(str(path))


def test_a_map_that_cannot_be_written_is_named_and_leaves_nothing(tmp_path):
    with pytest.raises(WorldError, match="must end in .yaml"):
        write_ros_map(MAP, tmp_path / "lab.pgm")
    with pytest.raises(WorldError, match="cannot be written"):
        write_ros_map(MAP, tmp_path / "none" / "lab.yaml")
    assert list(tmp_path.iterdir()) == []


def test_a_world_of_the_package_is_a_map_with_its_goals():
    office = load_floor_map("office")
    assert office.name == "office" and office.grid.resolution == 0.05
    x, y, _ = office.starts[0]
    assert office.grid.at(x, y) == FREE and (office.grid.cells == OCCUPIED).any()


def test_an_aria_map_has_goals_and_lines_that_nobody_crosses(tmp_path):
    path = tmp_path / "lab.map"
    path.write_text("\n".join([
        "2D-Map", 'Cairn: RobotHome 1000 1000 0 "" ICON "home"',
        'Cairn: GoalWithHeading 4000 1000 90 "" ICON "kitchen"',
        'Cairn: ForbiddenLine 0 0 0 "" ICON "" 2000 500 2000 1500',
        'Cairn: ForbiddenArea 0 0 0 "" ICON "" 3000 200 3500 700',
        "LINES", "0 0 5000 0", "5000 0 5000 2000", "5000 2000 0 2000", "0 2000 0 0"]))
    floor = load_floor_map(str(path))
    assert floor.goal("kitchen") == pytest.approx((4.0, 1.0, math.pi / 2))
    assert floor.starts == (Pose(1.0, 1.0, 0.0),)
    drivable = floor.drivable()
    for x, y in ((2.0, 1.0), (3.0, 0.5), (3.25, 0.7)):
        assert floor.grid.at(x, y) == FREE and drivable.at(x, y) == OCCUPIED
    assert drivable.at(2.0, 0.3) == FREE


def test_places_are_kept_beside_a_map(tmp_path):
    path = written(tmp_path)
    assert goals_file(str(path)) == tmp_path / "lab.goals.yaml"
    write_goals({"kitchen": Pose(1.5, -2.0, math.pi / 2), "Tür": Pose(0.0, 0.0, 0.0)}, goals_file(str(path)))
    assert load_floor_map(str(path)).goals == {
        "kitchen": pytest.approx(Pose(1.5, -2.0, math.pi / 2)), "Tür": Pose(0.0, 0.0, 0.0)}


def test_an_unknown_place_is_named_with_those_that_there_are():
    floor = FloorMap("lab", MAP, {"kitchen": Pose(1.0, 2.0, 0.0)})
    with pytest.raises(UsageError, match="no place named 'kitchn' on the map lab; did you mean 'kitchen'?"):
        floor.goal("kitchn")
    with pytest.raises(UsageError, match="known: none"):
        FloorMap("lab", MAP).goal("kitchen")


@pytest.mark.parametrize("text, named", [
    ("goals: [{name: a, position_m: [1], heading_deg: 0}]", "line 1: position_m"),
    ("goals:\n- {name: a, position_m: [1, 2], heading_deg: 0}\n- {name: a, position_m: [1, 2], heading_deg: 0}",
     "line 3: there are two goals named 'a'"),
    ("kitchen: 3", "has no 'kitchen'"), ("goals: {", "not YAML"),
])
def test_a_broken_file_of_places_is_named(tmp_path, text, named):
    (tmp_path / "a.goals.yaml").write_text(text)
    with pytest.raises(WorldError, match=named):
        read_goals(tmp_path / "a.goals.yaml")

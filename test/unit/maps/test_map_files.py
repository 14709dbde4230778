"""Maps that are written, read again, and read from files of other programs; and the places that people name."""

import math

import numpy as np
import pytest

from pioneer_control.errors import UsageError, WorldError
from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, UNKNOWN, FloorMap, GridMap, write_ros_map
from pioneer_control.maps.goals_file import goals_file, read_goals, write_goals
from pioneer_control.maps.grid_map import FORBIDDEN
from pioneer_control.navigation.node.map_files import load_floor_map

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


@pytest.mark.parametrize("name", [
    "c #d", "e: f", "[x]", "'q'", '"r"', "new\nline", "007", "no", "Tür", "back\\slash", "*s", "a.b", "\x7f\u2028",
    "😀", "long " * 40])
def test_a_map_of_any_name_comes_back(tmp_path, name):
    path = tmp_path / (name + ".yaml")
    write_ros_map(MAP, path)
    assert load_floor_map(str(path)).grid == MAP
    assert path.read_text().startswith('image: "')


def test_a_turned_map_is_drawn_anew(tmp_path):
    path = written(tmp_path)
    path.write_text(path.read_text().replace("2.5, 0.0]", "2.5, %r]" % (math.pi / 2)))
    grid = load_floor_map(str(path)).grid
    assert grid.cells.tolist() == [[FREE, FREE], [FREE, OCCUPIED], [FREE, UNKNOWN], [OCCUPIED, FREE]]
    assert grid.origin == pytest.approx((-1.35, 2.5))


@pytest.mark.parametrize("change, named", [
    (("resolution: 0.05", "resolution: 0"), "resolution is 0"), (("lab.pgm", "gone.pgm"), "gone.pgm cannot be read"),
    (("free_thresh: 0.196", "free_thresh: 0.7"), "must be below occupied_thresh"),
    (("resolution: 0.05", "resolution: 1e30"), "map .*lab.yaml, line 2: resolution is 1e.30; it must be .* to 10"),
    (("resolution: 0.05", "resolution: 1e999"), "resolution is inf"), (("2.5, 0", "1e300, 0"), "line 3: origin is"),
    (("resolution: 0.05", "resolution: '5e-2'"), "resolution is '5e-2'"),
    (("negate: 0", "negate: }"), "^map .*not YAML"),
    (("free_thresh: 0.196", "free_thresh: 0.0"), "no cell is free"),
])
def test_a_broken_map_is_named(tmp_path, change, named):
    path = written(tmp_path)
    path.write_text(path.read_text().replace(*change))
    with pytest.raises(WorldError, match=named):
        load_floor_map(str(path))


@pytest.mark.parametrize("as_text", ["5e-2", "5E-2", "+.5e-1", "5.e-2"])
def test_numbers_are_read_as_map_server_reads_them(tmp_path, as_text):
    path = written(tmp_path)
    path.write_text(path.read_text().replace("0.05", as_text).replace("-1.25", "-125e-2"))
    assert load_floor_map(str(path)).grid == MAP


@pytest.mark.parametrize("taken", ["lab.yaml", "lab.pgm"])
def test_a_folder_is_not_written_over_and_nothing_is_left(tmp_path, taken):
    (tmp_path / taken).mkdir()
    with pytest.raises(WorldError, match="%s is a directory" % taken):
        write_ros_map(MAP, tmp_path / "lab.yaml")
    assert [path.name for path in tmp_path.iterdir()] == [taken]


@pytest.mark.parametrize("name", ["a\0b.yaml", "\ud800.yaml", "x" * 300 + ".yaml"])
def test_a_name_that_no_file_can_have_is_refused(tmp_path, name):
    with pytest.raises(WorldError, match="cannot be written"):
        write_ros_map(MAP, tmp_path / name)
    with pytest.raises(WorldError, match="cannot be written"):
        write_goals({}, goals_file(str(tmp_path / name)))
    assert list(tmp_path.iterdir()) == []


def test_a_map_is_not_written_over_the_places_of_another(tmp_path):
    with pytest.raises(WorldError, match="lab.goals.yaml: its name must not end in .goals.yaml"):
        write_ros_map(MAP, tmp_path / "lab.goals.yaml")


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
        assert floor.grid.at(x, y) == FREE and drivable.at(x, y) == FORBIDDEN
    assert drivable.at(2.0, 0.3) == FREE


def test_places_are_kept_beside_a_map(tmp_path):
    path = written(tmp_path)
    assert goals_file(str(path)) == tmp_path / "lab.goals.yaml"
    write_goals({"kitchen": Pose(1.5, -2.0, math.pi / 2), "Tür": Pose(0.0, 0.0, 0.0)}, goals_file(str(path)))
    assert load_floor_map(str(path)).goals == {
        "kitchen": pytest.approx(Pose(1.5, -2.0, math.pi / 2)), "Tür": Pose(0.0, 0.0, 0.0)}


def test_a_place_of_numpys_numbers_is_kept(tmp_path):
    path = tmp_path / "lab.goals.yaml"
    write_goals({"desk": Pose(*np.array([1.5, -2.0, 0.0]))}, path)
    assert read_goals(path) == {"desk": Pose(1.5, -2.0, 0.0)}


def test_a_forgotten_place_does_not_come_back(tmp_path):
    """The file of places holds all of them, also those of the map, as soon as one was saved or forgotten."""
    path = tmp_path / "lab.map"
    path.write_text("\n".join([
        "2D-Map", 'Cairn: Goal 1000 1000 0 "" ICON "near"', 'Cairn: Goal 4000 1000 0 "" ICON "far"', "LINES",
        "0 0 5000 0", "5000 0 5000 2000", "5000 2000 0 2000", "0 2000 0 0"]))
    floor = load_floor_map(str(path))
    assert list(floor.goals) == ["near", "far"]
    write_goals({"far": floor.goals["far"]}, goals_file(str(path)))
    assert list(load_floor_map(str(path)).goals) == ["far"]
    write_goals({}, goals_file(str(path)))
    assert load_floor_map(str(path)).goals == {}


@pytest.mark.parametrize("line, named", [
    ('Cairn: Goal 1e300 0 0 "" ICON "k"\nLINES', "map .*lab.map, line 2: '1e300 0 0': numbers from -1e.07 to 1e.07"),
    ("LINES\n0 0 1e12 1e12", "map .*lab.map, line 3: '0 0 1e12 1e12'"),
    ("LINES\n0 0 1e7 1e7", "lie 10000 m by 10000 m apart; at most 100000 square metres are legal"),
    ('Cairn: RobotHome 0 0 0 "" ICON "in the wall"\nLINES', "no cell is free"),
])
def test_an_aria_map_too_large_or_without_floor_is_named(tmp_path, line, named):
    path = tmp_path / "lab.map"
    path.write_text("2D-Map\n%s\n0 0 5000 0\n5000 0 5000 2000\n5000 2000 0 2000\n0 2000 0 0\n" % line)
    with pytest.raises(WorldError, match=named):
        load_floor_map(str(path))


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
    ("kitchen: 3", "has no 'kitchen'"), ("goals: {", "^file of places .*not YAML"),
    ("goals: [{name: a, position_m: [1e300, 0], heading_deg: 0}]", "^file of places .*line 1: position_m is .*1e.06"),
])
def test_a_broken_file_of_places_is_named(tmp_path, text, named):
    (tmp_path / "a.goals.yaml").write_text(text)
    with pytest.raises(WorldError, match=named):
        read_goals(tmp_path / "a.goals.yaml")

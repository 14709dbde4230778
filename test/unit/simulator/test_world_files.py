"""World files: those of the package, their form, and the errors of wrong files."""

import math
import os

import pytest

from robot_on_bench import heard
from pioneer_control.errors import WorldError
from pioneer_control.robots import find_model, load_table
from pioneer_control.simulator.world import World, known_worlds, load_world
from pioneer_control.simulator.world.free_space import room
from pioneer_control.simulator.world.materials import Material
from pioneer_control.simulator.world.world import Furniture, MarkedPlace, Walk

EVERYTHING = """\
description: All there can be.
walls:
  - {corners_m: [[0, 0], [4, 0], [4, 3]]}
  - {corners_m: [[0, 0], [1, 0], [1, 1]], closed: true}
boxes:
  - {centre_m: [2, 1], size_m: [2, 1]}
  - {centre_m: [0, 0], size_m: [2, 2], angle_deg: 45}
posts:
  - {centre_m: [3, 2.5], diameter_m: 0.05}
cans:
  - {centre_m: [1, 1]}
  - {centre_m: [1, 2], diameter_m: 0.1, height_m: 0.05}
starts:
  - {position_m: [1, 2], heading_deg: 90}
  - {position_m: [3, 1], heading_deg: -180}
docks:
  - {position_m: [0.5, 2.5], heading_deg: 180}
goals:
  - {name: window, position_m: [2, 2.5], heading_deg: 90}
  - {name: door, position_m: [2.5, 0], heading_deg: 0}
places:
  - {name: depot, centre_m: [2, 1], size_m: [1, 0.5]}
  - {name: hole, centre_m: [3, 2], diameter_m: 0.4}
unmapped:
  boxes:
    - {centre_m: [1, 2.5], size_m: [0.4, 0.2]}
  posts:
    - {centre_m: [2, 2], diameter_m: 0.2}
walkers:
  - {path_m: [[1, 2], [3, 2], [3, 1]], speed_m_s: 0.8, pause_s: 1, blind: true}
  - {seed: 3}
"""


def written(tmp_path, text):
    path = tmp_path / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def placed(outline, pose):
    x, y, heading = pose
    cosine, sine = math.cos(heading), math.sin(heading)
    return [(x + px * cosine - py * sine, y + px * sine + py * cosine) for px, py in outline]


def test_every_section_and_key(tmp_path):
    world = load_world(written(tmp_path, EVERYTHING))
    assert world.name == "own"
    assert world.walls[:5].tolist() == [[0, 0, 4, 0], [4, 0, 4, 3], [0, 0, 1, 0], [1, 0, 1, 1], [1, 1, 0, 0]]
    assert world.walls[5:9].tolist() == [[1, .5, 3, .5], [3, .5, 3, 1.5], [3, 1.5, 1, 1.5], [1, 1.5, 1, .5]]
    diagonal = math.sqrt(2.0)
    assert [len(box) for box in world.boxes] == [4, 4]
    assert world.boxes[0] == ((1, .5), (3, .5), (3, 1.5), (1, 1.5))
    assert world.walls[9] == pytest.approx([0.0, -diagonal, diagonal, 0.0], abs=1e-12)
    assert world.posts.tolist() == [[3.0, 2.5, 0.025]]
    assert [(can.x, can.y, can.radius, can.height, can.held_by) for can in world.cans] == [
        (1.0, 1.0, 0.033, 0.115, None), (1.0, 2.0, 0.05, 0.05, None)]
    assert world.starts == [(1.0, 2.0, math.pi / 2), (3.0, 1.0, -math.pi)]
    assert world.docks == [(0.5, 2.5, math.pi)]
    assert world.goals == {"window": (2.0, 2.5, math.pi / 2), "door": (2.5, 0.0, 0.0)}
    assert world.places == [MarkedPlace("depot", 2.0, 1.0, (1.0, 0.5)), MarkedPlace("hole", 3.0, 2.0, (0.4,))]
    assert world.with_start((0.0, 0.0, 0.0)).places == world.places
    assert world.unmapped == [Furniture(corners=((0.8, 2.4), (1.2, 2.4), (1.2, 2.6), (0.8, 2.6))),
                              Furniture(posts=((2.0, 2.0, 0.1),))]
    assert len(world.solids) == len(world.walls) + 4 + len(world.posts) + 1
    assert world.walks == [Walk(((1.0, 2.0), (3.0, 2.0), (3.0, 1.0)), speed=0.8, pause=1.0, blind=True), Walk(seed=3)]
    assert world.with_start((0.0, 0.0, 0.0)).walks == world.walks
    assert world.skipped == ()
    assert world.bounds == pytest.approx((-diagonal, -diagonal, 4.0, 3.0))


def test_what_things_are_made_of(tmp_path):
    path = tmp_path / "hall.yaml"
    path.write_text("""
starts: [{position_m: [0, 0], heading_deg: 0}]
walls:
  - {corners_m: [[2, 0], [3, 0], [3, 1]], material: glass}
  - {corners_m: [[4, 0], [5, 0]]}
boxes: [{centre_m: [7, 0], size_m: [1, 1], material: mirror}]
posts: [{centre_m: [0, 3], diameter_m: 0.2, material: reflector}]
unmapped: {posts: [{centre_m: [0, 4], diameter_m: 0.2, material: dark}], boxes: []}
""")
    world = load_world(path)
    glass, mirror, reflector = Material.GLASS, Material.MIRROR, Material.REFLECTOR
    assert world.materials == [glass, glass, Material.PLAIN, *[mirror] * 4, reflector]
    assert world.solids.materials.tolist() == [*world.materials, Material.DARK]
    path.write_text(START + "walls: [{corners_m: [[0, 0], [1, 0]], material: robot}]\n")
    with pytest.raises(WorldError, match="material is 'robot'; it must be one of plain, dark, glass, mirror"):
        load_world(path)


def test_only_a_start_is_needed(tmp_path):
    world = load_world(str(written(tmp_path, "starts: [{position_m: [1, 2], heading_deg: 0}]")))
    assert len(world.walls) == len(world.posts) == len(world.cans) == len(world.docks) == len(world.goals) == 0


START = "starts: [{position_m: [0, 0], heading_deg: 0}]\n"


@pytest.mark.parametrize("text, message", [
    ("", "is empty; it needs at least 'starts'"),
    ("just words", "line 1: a world must be a mapping with the keys starts, description, map, walls"),
    (START + "walls:\n  - [1, 2\n", "line 4: not YAML: expected ',' or ']'"),
    (START + "walls: \x07\n", "not YAML: .*special characters"),
    (START + "--- \n", "line 2: not YAML: but found another document"),
    ("posts: []\n", "line 1: a world needs starts"),
    ("starts: []\n", "line 1: starts is empty; a robot has to stand somewhere"),
    ("starts: [{position_m: [0, 0]}]\n", "line 1: a start needs heading_deg"),
    (START + "wals: []\n", "line 2: a world has no 'wals'; did you mean 'walls'?"),
    (START + "xyzzy: 1\n", "line 2: a world has no 'xyzzy'; known: starts, description"),
    (START + "[1, 2]: 1\n", "line 2: keys must be plain words"),
    (START + START, "line 2: a world has 'starts' twice"),
    (START + "description: [1]\n", r"line 2: description is \[1\]; it must be a text, not empty"),
    (START + "unmapped: [1]\n", "line 2: the section unmapped must be a mapping with the keys boxes, posts"),
    (START + "unmapped: {cans: []}\n", "line 2: the section unmapped has no 'cans'"),
    (START + "walkers:\n  - {speed_m_s: 1}\n", "line 3: a walker needs either path_m, .* or seed"),
    (START + "walkers:\n  - {seed: 1, path_m: [[0, 0], [1, 1]]}\n", "line 3: a walker needs either path_m.* or seed"),
    (START + "walkers:\n  - {path_m: [[0, 0]]}\n", "line 3: path_m needs two points or more"),
    (START + "walkers:\n  - {seed: 1, speed_m_s: 0}\n", "speed_m_s is 0; it must be a number from 0.01 to 3"),
    (START + "walls: 3\n", "line 2: walls must be a list"),
    (START + "walls:\n  - [[0, 0], [1, 1]]\n", "line 3: a wall must be a mapping with the keys corners_m, closed"),
    (START + "walls:\n  - {corners_m: [[0, 0]]}\n", "line 3: corners_m needs two points or more"),
    (START + "walls:\n  - {corners_m: [[0, 0], [1]]}\n",
     r"line 3: a point of corners_m is \[1\]; it must be 2 numbers, as a list"),
    (START + "walls:\n  - {corners_m: [[0, 0], [1, 1], [1, 1]]}\n", "line 3: a wall from .* to itself"),
    (START + "walls:\n  - {corners_m: [[0, 0], [1, 1]], closed: 1}\n", "line 3: closed is 1; it must be true or false"),
    (START + "boxes:\n  - {centre_m: [0, 0], size_m: [1, 0]}\n",
     r"line 3: size_m is \[1, 0\]; it must be 2 numbers from 0.0001 up, as a list"),
    (START + "boxes:\n  - {centre_m: [0, 0], size_m: 1}\n",
     "line 3: size_m is 1; it must be 2 numbers from 0.0001 up, as a list"),
    (START + "boxes:\n  - {centre: [0, 0], size_m: [1, 1]}\n",
     "line 3: a box has no 'centre'; did you mean 'centre_m'?"),
    (START + "posts:\n  - {centre_m: [0, 0], diameter_m: -1}\n",
     "line 3: diameter_m is -1; it must be a number from 0.0001 up"),
    (START + "posts:\n  - {centre_m: [0, zero], diameter_m: 1}\n",
     r"line 3: centre_m is \[0, 'zero'\]; it must be 2 numbers, as a list"),
    (START + "posts:\n  - {centre_m: [0, '1'], diameter_m: 1}\n",
     r"line 3: centre_m is \[0, '1'\]; it must be 2 numbers, as a list"),
    (START + "posts:\n  - {centre_m: [0, .nan], diameter_m: 1}\n",
     r"line 3: centre_m is \[0, nan\]; it must be 2 numbers, as a list"),
    (START + "posts:\n  - {centre_m: [0, true], diameter_m: 1}\n",
     r"line 3: centre_m is \[0, True\]; it must be 2 numbers, as a list"),
    (START + "posts:\n  - {centre_m: [0, 0], diameter_m: !!int broad}\n",
     "line 3: diameter_m is 'broad'; it must be a number from 0.0001 up"),
    (START + "posts:\n  - {centre_m: [0, 0], diameter_m: !diameter 1}\n",
     "line 3: diameter_m is '1'; it must be a number from 0.0001 up"),
    (START + "posts:\n  - {centre_m: [0, 0], diameter_m: 1%s}\n" % (400 * "0"),
     "line 3: diameter_m is 1000"),
    (START + "posts:\n  - {centre_m: [0, [1]], diameter_m: 1}\n",
     r"line 3: centre_m is \[0, \[1\]\]; it must be 2 numbers, as a list"),
    (START + "docks:\n  - {position_m: [0, 0]}\n", "line 3: a dock needs heading_deg"),
    (START + "docks: 1\n", "line 2: docks must be a list"),
    (START + "goals:\n  - {position_m: [0, 0], heading_deg: 0}\n", "line 3: a goal needs name"),
    (START + "goals:\n  - {name: 5, position_m: [0, 0], heading_deg: 0}\n",
     "line 3: name is 5; it must be a text, not empty"),
    (START + "goals:\n" + 2 * "  - {name: a, position_m: [0, 0], heading_deg: 0}\n",
     "line 4: there are two goals named 'a'; names must differ"),
    (START + "places:\n  - {name: a, centre_m: [0, 0]}\n",
     "line 3: a place needs either size_m, of a rectangle, or diameter_m, of a disc"),
    (START + "places:\n  - {name: a, centre_m: [0, 0], size_m: [1, 1], diameter_m: 1}\n",
     "line 3: a place needs either size_m, of a rectangle, or diameter_m, of a disc"),
    (START + "places:\n  - {centre_m: [0, 0], diameter_m: 1}\n", "line 3: a place needs name"),
    (START + "places:\n" + 2 * "  - {name: a, centre_m: [0, 0], diameter_m: 1}\n",
     "line 4: there are two places named 'a'; names must differ"),
    (START + "cans:\n  - {centre_m: [0, 0], height_m: 0.2}\n",
     "line 3: a can must be lower than the sonar, 0.17 m, not 0.2"),
])
def test_wrong_files_are_told_the_line_and_what_is_legal(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(WorldError, match=message) as raised:
        load_world(path)
    assert str(path) in str(raised.value) and "\n" not in str(raised.value)


def test_numbers_in_all_plain_forms(tmp_path):
    text = "starts: [{position_m: [-1.5e+1, 1_0], heading_deg: 0}, {position_m: [0x10, .5], heading_deg: 0}]"
    assert load_world(written(tmp_path, text)).starts == [(-15.0, 10.0, 0.0), (16.0, 0.5, 0.0)]


def test_unknown_name_lists_the_known_ones():
    names = "cans, classroom, clutter, corridor, empty, maze, office, table, tutorial"
    with pytest.raises(WorldError, match=r"no world named 'tutoral'; did you mean 'tutorial'\?.*%s" % names):
        load_world("tutoral")
    with pytest.raises(WorldError, match="no world named 'xyzzy'; known: cans"):
        load_world("xyzzy")


@pytest.mark.parametrize("name", ["no/such/file", "missing.yaml", "missing.yml", "missing.map"])
def test_missing_file(name):
    with pytest.raises(WorldError, match="file %s does not exist below .*tutorial" % name):
        load_world(name)


def test_file_that_is_no_text(tmp_path):
    path = tmp_path / "picture.yaml"
    path.write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(WorldError, match="picture.yaml cannot be read"):
        load_world(path)


def test_folder_instead_of_a_file(tmp_path):
    with pytest.raises(WorldError, match="is a directory"):
        load_world(os.path.join(str(tmp_path), ""))


def test_picture_instead_of_its_map(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.png").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(WorldError, match="lab.png cannot be read.*give the YAML file beside it"):
        load_world("lab.png")


def test_the_gallery_is_complete():
    assert known_worlds() == [
        "cans", "classroom", "clutter", "corridor", "empty", "maze", "office", "table", "tutorial"]


@pytest.mark.parametrize("name", known_worlds())
def test_gallery_worlds_have_free_starts_for_every_robot(name):
    world = load_world(name)
    assert world.name == name
    for model in load_table().models.values():
        for pose in world.starts:
            outline = placed(model.outline(gripper=model.can_carry_gripper), pose)
            assert not world.touches(outline), (model.subtype, pose)
            for can in world.cans:
                assert not World("can", posts=[(can.x, can.y, can.radius)]).touches(outline), (model.subtype, pose, can)


@pytest.mark.parametrize("name", known_worlds())
def test_gallery_docks_and_goals_have_room_for_a_pioneer(name):
    world = load_world(name)
    for model in map(find_model, ("p3dx-sh", "p3at-sh", "peoplebot-sh", "amigo-sh")):
        for pose in [*world.docks, *world.goals.values()]:
            outline = model.outline(gripper=model.can_carry_gripper)
            assert not world.touches(placed(outline, pose)), (model.subtype, pose)


@pytest.mark.parametrize("name", [name for name in known_worlds() if name != "empty"])
def test_gallery_worlds_have_room_and_reachable_cans(name):
    world = load_world(name)
    for x, y, _ in world.starts:
        assert room(world, x, y) > 1.5
    for can in world.cans:
        assert world.clearance(can.x, can.y) > can.radius


def test_tutorial_has_a_can_straight_ahead_with_a_clear_way_to_it():
    world = load_world("tutorial")
    x, y, heading = world.starts[0]
    ahead, aside = math.cos(heading), math.sin(heading)
    from_start = [((can.x - x) * ahead + (can.y - y) * aside, (can.y - y) * ahead - (can.x - x) * aside)
                  for can in world.cans]
    assert any(1.0 <= distance <= 1.5 and abs(offset) < 0.02 for distance, offset in from_start)
    assert heard(world, x, y, heading) > 2.5

"""ARIA's .map files as worlds: the meaning of each kind of line, and the errors of wrong files."""

import math

import pytest

from robot_on_bench import heard
from pioneer_control.errors import WorldError
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.world.materials import Material

GOLDEN = """\
2D-Map
MinPos: -2000 -1000
MaxPos: 6000 3000
NumPoints: 3
PointsAreSorted: true
Resolution: 50
LineMinPos: -2000 -1000
LineMaxPos: 6000 3000
NumLines: 2
LinesAreSorted: true
MapInfo: Whatever "it says"
Robot: not known
Cairn: RobotHome 1000 500 90 "" ICON "home"
Cairn: RobotHome 2000 500 -180 "" ICON ""
Cairn: Goal 3000 1000 0 "" ICON "copier"
Cairn: GoalWithHeading 4000 1000 45.5 "" ICON "Bob's desk"
Cairn: Dock 5000 0 180 "" ICON "charger"
Cairn: DockLynx 5000 1000 0 "" ICON ""
Cairn: Sim.BoxObstacle 0 0 0 "" ICON "crate" 3000 2000 3500 2500
Cairn: Sim.BoxObstacle 0 0 90 "" ICON "turned" 1000 0 2000 500
Cairn: Reflector 0 0 0 "" ICON "" 0 2000 1000 2000
Cairn: ForbiddenLine 0 0 0 "" ICON "" 0 0 1000 1000
Cairn: ForbiddenLine 0 0 0 "" ICON "" 0 0 1000 2000
Cairn: Label 10 20 0 "" ICON "here
LINES
-2000 -1000 6000 -1000
6000 -1000 6000 3000.5
7000 7000 7000 7000
DATA
1000 1000
1050 1000
1100 1000
"""


def written(tmp_path, text, name="own.map"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_what_each_line_becomes(tmp_path):
    world = load_world(written(tmp_path, GOLDEN))
    assert world.name == "own"
    assert world.walls[:2].tolist() == [[-2.0, -1.0, 6.0, -1.0], [6.0, -1.0, 6.0, 3.0005]]
    box = [[3.0, 2.0, 3.5, 2.0], [3.5, 2.0, 3.5, 2.5], [3.5, 2.5, 3.0, 2.5], [3.0, 2.5, 3.0, 2.0]]
    assert world.walls[2:6].tolist() == box
    turned = [[0, 1, 0, 2], [0, 2, -.5, 2], [-.5, 2, -.5, 1], [-.5, 1, 0, 1]]      # about the origin of the map
    assert [pytest.approx(wall, abs=1e-12) for wall in turned] == world.walls[6:10].tolist()
    assert world.walls[10:].tolist() == [[0.0, 2.0, 1.0, 2.0]]
    assert world.starts == [(1.0, 0.5, math.pi / 2), (2.0, 0.5, -math.pi)]
    assert world.docks == [(5.0, 0.0, math.pi), (5.0, 1.0, 0.0)]
    assert world.goals == {"copier": (3.0, 1.0, 0.0), "Bob's desk": (4.0, 1.0, math.radians(45.5))}
    assert len(world.posts) == len(world.cans) == 0


def test_what_was_skipped_is_said(tmp_path):
    world = load_world(written(tmp_path, GOLDEN))
    assert world.forbidden.tolist() == [[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 2.0]]
    assert world.skipped == (
        "Robot:, line 12", "Label, line 24", "a line without length, line 28",
        "3 points: lines alone make the walls")


def points_along(x1, y1, x2, y2, step):
    count = int(math.hypot(x2 - x1, y2 - y1) / step)
    return "".join("%.0f %.0f\n" % (x1 + (x2 - x1) * k / count, y1 + (y2 - y1) * k / count) for k in range(count + 1))


def test_points_make_walls_where_there_are_no_lines(tmp_path):
    """A scanned room of 6 by 4 m. Its inside has four walls, within twice the resolution of the scan."""
    corners = [(0, 0), (6000, 0), (6000, 4000), (0, 4000), (0, 0)]
    points = "".join(points_along(*first, *second, 50) for first, second in zip(corners, corners[1:]))
    header = "2D-Map\nResolution: 50\nCairn: RobotHome 3000 2000 0 \"\" ICON \"\"\nDATA:\n"
    world = load_world(written(tmp_path, header + points))
    assert world.skipped == () and len(world.walls) == 8                # inside and outside
    for heading, expected in ((0.0, 3.0), (math.pi / 2, 2.0), (math.pi, 3.0), (-math.pi / 2, 2.0)):
        assert heard(world, 3.0, 2.0, heading, 0.2) == pytest.approx(expected, abs=0.101)


def test_a_slanted_scan_is_one_wall_without_gaps(tmp_path):
    """The distance between points is a little more than the stated resolution."""
    world = load_world(written(tmp_path, "2D-Map\nResolution: 20\nDATA\n" + points_along(0, 0, 8000, 3000, 25)))
    assert len(world.walls) <= 10
    for share in range(1, 80):
        x, y = 8.0 * share / 80.0, 3.0 * share / 80.0
        assert world.clearance(x, y) < 0.06


def test_sections_in_either_spelling_and_any_order(tmp_path):
    world = load_world(written(tmp_path, "2D-Map\n\nDATA:\n0 0\nLINES:\n0 0 1000 0\n\n"))
    assert world.walls.tolist() == [[0, 0, 1, 0]]


def test_a_map_is_known_by_its_first_line_too(tmp_path):
    world = load_world(written(tmp_path, "2D-Map\r\nLINES\r\n0 0 1000 0\r\n", "map.txt"))
    assert world.walls.tolist() == [[0, 0, 1, 0]]


def test_names_of_another_encoding_do_no_harm(tmp_path):
    path = tmp_path / "own.map"
    path.write_bytes('2D-Map\nCairn: Goal 1 2 0 "" ICON "Büro"\n'.encode("latin-1"))
    assert list(load_world(path).goals) == ["B\ufffdro"]


def test_goals_without_a_name_of_their_own(tmp_path):
    goal = 'Cairn: Goal {} 0 0 "" ICON "{}"\n'
    goals = goal.format(1000, "") + goal.format(2000, "desk") + goal.format(3000, "desk")
    world = load_world(written(tmp_path, "2D-Map\n" + goals))
    assert world.goals == {"goal 1": (1.0, 0.0, 0.0), "desk": (2.0, 0.0, 0.0)}
    assert "another goal named 'desk', line 4" in world.skipped


ROOM = "2D-Map\nLINES\n{0} {0} {1} {0}\n{1} {0} {1} {1}\n{1} {1} {0} {1}\n{0} {1} {0} {0}\n"


def test_without_a_home_the_robot_starts_at_the_origin(tmp_path):
    world = load_world(written(tmp_path, ROOM.format(-1000, 3000)))
    assert world.starts == [(0.0, 0.0, 0.0)]
    assert world.skipped == ("no RobotHome in the map: robots begin at x 0.00, y 0.00",)


def test_or_where_there_is_room(tmp_path):
    (start,) = load_world(written(tmp_path, ROOM.format(-100, 3900))).starts
    assert start == pytest.approx((1.9, 1.9, 0.0), abs=0.11)


@pytest.mark.parametrize("size", [0, 900])
def test_or_outside_when_there_is_none(tmp_path, size):
    world = load_world(written(tmp_path, "2D-Map\nLINES\n0 0 900 %s\n900 0 0 %s\n0 0 900 0\n" % (size, size)))
    assert world.starts == [(-1.0, -1.0, 0.0)]


def test_even_in_a_map_of_nothing(tmp_path):
    assert load_world(written(tmp_path, "2D-Map\n")).starts == [(0.0, 0.0, 0.0)]


BOX = 'Cairn: Sim.BoxObstacle 0 0 0 "" ICON "" '


@pytest.mark.parametrize("text, message", [
    ("", "line 1: the first line of an ARIA map must be 2D-Map, not ''"),
    ("2D-Mop\n", "line 1: the first line of an ARIA map must be 2D-Map, not '2D-Mop'"),
    ("2D-Map\nsome words\n", "line 2: expected 'Key: value', LINES or DATA, not 'some words'"),
    ("2D-Map\nResolution: fine\n", "line 2: expected Resolution: mm, one number above 0, not ' fine'"),
    ("2D-Map\nResolution: 0\n", "line 2: Resolution must be above 0 mm, not 0"),
    ("2D-Map\nLINES\n1 2 3\n", "line 3: expected four numbers, x1 y1 x2 y2 .mm., under LINES, not '1 2 3'"),
    ("2D-Map\nLINES\n1 2 3 4\n1 2 3 x\n", "line 4: expected four numbers, .* not '1 2 3 x'"),
    ("2D-Map\nLINES\n1 2 3 nan\n", "line 3: expected four numbers, .* not '1 2 3 nan'"),
    ("2D-Map\nDATA\n1 2\n1 2 3\n", "line 4: expected two numbers, x y .mm., under DATA, not '1 2 3'"),
    ("2D-Map\nDATA\n1 inf\n", "line 3: expected two numbers, .* not '1 inf'"),
    ("2D-Map\nDATA\n0 0\n1e7 0\n",
     "points lie 10000.2 m by 0.2 m apart; with Resolution 100 mm at most 2000 m are legal"),
    ("2D-Map\nCairn: Goal 1 2 0 home\n", r"line 2: expected Cairn: TYPE x y theta .* not 'Cairn: Goal 1 2 0 home'"),
    ('2D-Map\nCairn: Goal 1 two 0 "" ICON "home"\n',
     "line 2: expected x y theta .mm, degrees. in Cairn: .*, not '1 two 0'"),
    ("2D-Map\n" + BOX + "\n", "line 2: expected x1 y1 x2 y2 .mm. at the end of a Sim.BoxObstacle, not ''"),
    ("2D-Map\n" + BOX + "1 2 3\n", "line 2: expected x1 y1 x2 y2 .* not '1 2 3'"),
    ("2D-Map\n" + BOX + "1 2 1 2\n", "line 2: a Sim.BoxObstacle from 1 2 to itself; its corners must differ"),
    ('2D-Map\nCairn: Reflector 0 0 0 "" ICON "" 1 2 1 2\n', "line 2: a Reflector from 1 2 to itself"),
])
def test_wrong_files_are_told_the_line_and_what_is_legal(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(WorldError, match=message) as raised:
        load_world(path)
    assert str(path) in str(raised.value) and "\n" not in str(raised.value)


def test_boxes_are_known_as_such_and_reflectors_are_not(tmp_path):
    path = tmp_path / "crates.map"
    reflector = 'Cairn: Reflector 0 0 0 "" ICON "" 0 0 1000 0\n'
    path.write_text("2D-Map\n" + BOX + "1000 1000 2000 3000\n" + BOX + "0 0 0 500\n" + reflector)
    world = load_world(path)
    assert world.boxes == [((1.0, 1.0), (2.0, 1.0), (2.0, 3.0), (1.0, 3.0))] and len(world.walls) == 4 + 2 + 1
    assert world.materials == [Material.PLAIN] * 6 + [Material.REFLECTOR]
    assert world.with_start((0.0, 0.0, 0.0)).boxes == world.boxes

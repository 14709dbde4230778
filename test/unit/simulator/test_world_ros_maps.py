"""Maps of ROS's map_server as worlds: cells, origin, thresholds, modes, formats, and the errors of wrong files."""

import math

import numpy as np
import pytest
from PIL import Image

from pioneer_control.errors import WorldError
from pioneer_control.simulator.world import load_world

VALUES = {
    "image": "cells.pgm", "resolution": 0.5, "origin": [0, 0, 0],
    "occupied_thresh": 0.65, "free_thresh": 0.196, "negate": 0,
}
ROOM = np.full((12, 20), 254, dtype=np.uint8)    # 10 by 6 m in cells of 0.5 m, walls around, a block at the upper left
ROOM[[0, -1]] = ROOM[:, [0, -1]] = ROOM[2:4, 2:6] = 0


def written(tmp_path, cells=ROOM, picture=None, **values):
    """Return a map of these cells, row 0 on top. Other values replace those of `VALUES`. A value of None is left out.
    """
    values = {**VALUES, **values}
    if cells is not None:
        (Image.fromarray(cells) if picture is None else picture).save(str(tmp_path / values["image"]))
    path = tmp_path / "lab.yaml"
    path.write_text("".join("%s: %s\n" % (key, value) for key, value in values.items() if value is not None))
    return path


def test_cells_become_few_walls_at_the_right_places(tmp_path):
    world = load_world(written(tmp_path))
    assert world.name == "lab" and len(world.walls) == 12               # outside, inside and the block
    assert sorted(world.walls[:4].ravel()) == sorted([0, 0, 10, 0, 10, 0, 10, 6, 10, 6, 0, 6, 0, 6, 0, 0])
    assert world.clearance(5.0, 3.0) == pytest.approx(math.hypot(2.0, 1.0))     # to the block's corner at 3, 4
    assert world.clearance(5.0, 0.5) == 0.0 and world.clearance(9.5, 3.0) == 0.0
    assert world.clearance(1.0, 4.5) == pytest.approx(0.0) and world.touches([(1.2, 4.5), (0.8, 4.6), (0.8, 4.4)])


def test_the_origin_is_the_pose_of_the_lower_left_corner(tmp_path):
    world = load_world(written(tmp_path, origin=[-2.0, 1.0, math.pi / 2]))
    assert world.bounds == pytest.approx((-8.0, 1.0, -2.0, 11.0))
    here = load_world(written(tmp_path))
    x, y = 5.0, 3.0
    assert world.clearance(-2.0 - y, 1.0 + x) == pytest.approx(here.clearance(x, y))


@pytest.mark.parametrize("origin, start", [
    ([-8.0, -2.0, 0], (0.0, 0.0)),                       # there is room at the map's origin
    ([-8.0, -0.6, 0], (-8.0 + 5.5, -0.6 + 3.0)),       # there is not
    ([8.0, 0.0, 0], (8.0 + 5.5, 3.0)),                 # it lies outside
    ([2.0, -8.0, math.pi / 2], (0.0, 0.0)),
])
def test_a_start_where_there_is_room(tmp_path, origin, start):
    world = load_world(written(tmp_path, origin=origin))
    assert world.starts == [pytest.approx((*start, 0.0), abs=1e-9)] and world.clearance(*world.starts[0][:2]) >= 0.55
    assert world.skipped[-1].startswith("no start in a map of this kind: robots begin at x ")


@pytest.mark.parametrize("value, settings, wall", [
    (89, {}, True),         # (255 - 89) / 255 = 0.651
    (90, {}, False),
    (205, {}, False),       # map_saver writes this where nothing is known
    (165, {"negate": 1}, False),
    (166, {"negate": 1}, True),
    (126, {"occupied_thresh": 0.5}, True),
    (128, {"occupied_thresh": 0.5}, False),
    (100, {"mode": "raw"}, True),
    (66, {"mode": "raw"}, True),
    (65, {"mode": "raw"}, False),
    (255, {"mode": "raw"}, False),
    (0, {"mode": "scale"}, True),
    (0, {"mode": "trinary"}, True),
])
def test_thresholds_negation_and_modes(tmp_path, value, settings, wall):
    free = 0 if "negate" in settings or settings.get("mode") == "raw" else 255
    cells = np.full((9, 9), free, dtype=np.uint8)
    cells[4, 4] = value
    assert len(load_world(written(tmp_path, cells, **settings)).walls) == (4 if wall else 0)


def test_starts_are_free_not_only_unknown(tmp_path):
    cells = np.full((9, 30), 205, dtype=np.uint8)
    cells[2:6, 20:24] = 254
    assert load_world(written(tmp_path, cells)).starts == [(11.0, 2.5, 0.0)]


@pytest.mark.parametrize("name, mode", [
    ("cells.pgm", "L"),
    ("cells.png", "L"),
    ("cells.png", "RGB"),
    ("cells.png", "RGBA"),
    ("cells.png", "LA"),
    ("cells.png", "P"),
    ("cells.png", "1"),
])
def test_formats(tmp_path, name, mode):
    expected = load_world(written(tmp_path)).walls.tolist()
    picture = Image.fromarray(ROOM).convert(mode)
    assert load_world(written(tmp_path, picture=picture, image=name)).walls.tolist() == expected


def test_sixteen_bits(tmp_path):
    expected = load_world(written(tmp_path)).walls.tolist()
    deep = Image.fromarray(ROOM.astype(np.uint16) * 257)
    assert load_world(written(tmp_path, picture=deep, image="cells.png")).walls.tolist() == expected


def test_the_bytes_of_a_pgm_as_map_saver_writes_them(tmp_path):
    path = written(tmp_path, cells=None)
    header = b"P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n3 3\n255\n"
    (tmp_path / "cells.pgm").write_bytes(header + bytes([254, 254, 254, 254, 0, 254, 205, 254, 254]))
    walls = [[.5, .5, 1, .5], [1, .5, 1, 1], [1, 1, .5, 1], [.5, 1, .5, .5]]
    assert sorted(load_world(path).walls.tolist()) == sorted(walls)


def test_what_is_transparent_is_unknown(tmp_path):
    cells = np.full((9, 9, 4), 255, dtype=np.uint8)
    cells[2, 2] = (0, 0, 0, 255)
    cells[6, 6] = (0, 0, 0, 0)
    assert len(load_world(written(tmp_path, cells, image="cells.png")).walls) == 4


def test_other_keys_are_skipped_and_said(tmp_path):
    assert load_world(written(tmp_path, lanes=[1, 2])).skipped[0] == "line 7: 'lanes', which means nothing here"


def test_a_large_map_is_few_walls(tmp_path):
    """A measured building of 40 by 30 m, turned and rough."""
    y, x = np.mgrid[0:600, 0:800]
    ahead, aside = 0.96 * x + 0.28 * y - 300.0, 0.96 * y - 0.28 * x + 200.0
    rough = np.random.RandomState(1).randint(0, 2, (600, 800))
    walls = ((ahead % 250 < 4 + rough) & (aside % 250 > 40)) | (aside % 250 < 4 + rough)
    world = load_world(written(tmp_path, np.where(walls, 0, 254).astype(np.uint8), resolution=0.05))
    edges = (walls[1:] != walls[:-1]).sum() + (walls[:, 1:] != walls[:, :-1]).sum()
    assert edges > 10000 and len(world.walls) < edges / 10


@pytest.mark.parametrize("values, message", [
    ({"resolution": None, "negate": None}, "line 1: a map needs resolution and negate"),
    ({"resolution": 0}, "line 2: resolution is 0; it must be a number from 0.0001 to 10"),
    ({"resolution": "fine"}, "line 2: resolution is 'fine'; it must be a number from 0.0001 to 10"),
    ({"origin": [1, 2]}, r"line 3: origin is \[1, 2\]; it must be 3 numbers from -1e.06 to 1e.06, as a list"),
    ({"origin": [1, 2, ".nan"]}, r"line 3: origin is \[1, 2, '.nan'\]; it must be 3 numbers from -1e.06 to 1e.06"),
    ({"occupied_thresh": 65}, "line 4: occupied_thresh is 65; it must be a number from 0 to 1"),
    ({"free_thresh": -0.1}, "line 5: free_thresh is -0.1; it must be a number from 0 to 1"),
    ({"free_thresh": 0.65}, "line 1: free_thresh 0.65 must be below occupied_thresh 0.65"),
    ({"negate": 2}, "line 6: negate is 2; it must be one of 0, 1"),
    ({"mode": "binary"}, "line 7: mode is 'binary'; it must be one of trinary, scale, raw"),
    ({"image": "[]", "cells": None}, r"line 1: image is \[\]; it must be a text, not empty"),
    ({"image": "none.pgm", "cells": None}, "line 1: image .*none.pgm cannot be read: No such file"),
    ({"image": "lab.yaml", "cells": None}, "line 1: image .*lab.yaml cannot be read: cannot identify image file"),
    ({"image": "cells.bmp"}, "line 1: image .*cells.bmp is a BMP; it must be a PGM or a PNG"),
    ({"cells": np.zeros((4, 4), dtype=np.uint8)}, "line 1: no cell of the map is free"),
])
def test_wrong_files_are_told_the_line_and_what_is_legal(tmp_path, values, message):
    path = written(tmp_path, **values)
    with pytest.raises(WorldError, match=message) as raised:
        load_world(path)
    assert str(path) in str(raised.value) and "\n" not in str(raised.value)


def test_an_image_that_ends_early(tmp_path):
    path = written(tmp_path, cells=None)
    (tmp_path / "cells.pgm").write_bytes(b"P5\n30 30\n255\n" + bytes(10))
    with pytest.raises(WorldError, match="line 1: image .* cannot be read"):
        load_world(path)


def test_the_image_instead_of_the_yaml_file(tmp_path):
    written(tmp_path)
    with pytest.raises(WorldError, match="cells.pgm cannot be read: .*; of a picture, give the YAML file beside it"):
        load_world(tmp_path / "cells.pgm")


OWN = "map: {}\nstarts: [{{position_m: [6, 2], heading_deg: 0}}]\nposts: [{{centre_m: [8, 4], diameter_m: 0.1}}]\n"


def own(tmp_path, name):
    path = tmp_path / "own.yaml"
    path.write_text(OWN.format(name) + "goals: [{name: desk, position_m: [1, 1], heading_deg: 0}]\n")
    return path


def test_a_world_of_our_own_over_a_map(tmp_path):
    written(tmp_path)
    world = load_world(own(tmp_path, "lab.yaml"))
    assert (world.name, len(world.walls), len(world.posts), world.starts) == ("own", 12, 1, [(6.0, 2.0, 0.0)])
    assert world.skipped == ()   # nothing of the start that the map has not: the world says its own


def test_goals_and_docks_of_the_map_stay(tmp_path):
    (tmp_path / "lab.map").write_text(
        '2D-Map\nCairn: Dock 1000 0 0 "" ICON ""\nCairn: Goal 0 0 0 "" ICON "door"\nCairn: Label\n')
    world = load_world(own(tmp_path, "lab.map"))
    assert world.docks == [(1.0, 0.0, 0.0)] and sorted(world.goals) == ["desk", "door"]
    assert "Label, line 4" in world.skipped


@pytest.mark.parametrize("name, message", [
    ("own.yaml", "line 1: map: .*own.yaml is neither an ARIA map .first line 2D-Map. nor one of map_server"),
    ("none.map", "line 1: map: file .*none.map cannot be read: No such file"),
    ("[]", r"line 1: map is \[\]; it must be a text, not empty"),
])
def test_a_wrong_map_under_a_world(tmp_path, name, message):
    with pytest.raises(WorldError, match=message):
        load_world(own(tmp_path, name))

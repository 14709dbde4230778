"""Pictures of worlds: they show everything of a world of any size, and errors are reported."""

import sys

import numpy as np
import pytest

from pioneer_control.errors import UsageError
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import Can, World, load_world
from pioneer_control.simulator.picture import draw_world, figure, main


def words(page):
    """Return all texts of a figure."""
    return [text.get_text() for text in page.texts + page.axes[0].texts]


def test_all_that_a_world_has_is_named():
    told = words(figure(load_world("office")))
    summary = "20 × 12 m  ·  160 walls  ·  15 posts  ·  8 cans"
    assert {"office", "start 1", "start 4", "dock", "kitchen", summary} <= set(told)
    assert "start" in words(figure(load_world("empty")))


def test_many_starts_have_only_their_numbers():
    told = words(figure(load_world("classroom")))
    assert {"1", "30", "ring", "depot", "west corner"} <= set(told) and not [text for text in told if "start" in text]


def test_walls_lie_where_they_are():
    world = load_world("maze")
    (walls,) = figure(world).axes[0].collections
    assert np.array_equal(np.array(walls.get_segments()).reshape(-1, 4), world.walls)


def test_what_a_laser_sees_in_another_way_has_a_colour_and_its_name():
    world = World("glass", walls=[(0, 0, 4, 0), (0, 3, 4, 3)], posts=[(2, 1, 0.1)], materials=[2, 0, 1])
    axes = figure(world).axes[0]
    (walls,), posts = axes.collections, axes.patches
    glass, plain = walls.get_colors()[:, :3].tolist()
    assert [round(255 * part) for part in glass] == [0x56, 0xb4, 0xe9] and plain != glass
    assert [round(255 * part) for part in posts[0].get_facecolor()[:3]] == [0x8c, 0x5a, 0x2b], "dark"
    assert axes.get_legend_handles_labels()[1][:2] == ["dark", "glass"]
    assert "glass" not in figure(load_world("tutorial")).axes[0].get_legend_handles_labels()[1]


def test_robots_instead_of_starts():
    model = find_model("p3dx-sh")
    page = figure(load_world("tutorial"), [(model.outline(True), (1.6, 3.0, 0.0)), (model.outline(), (6.3, 2.9, 1.0))])
    outlines = [patch.get_xy() for patch in page.axes[0].patches if len(getattr(patch, "_path", ())) in (5, 9)]
    assert "start 1" not in words(page)
    nose_x = 1.6 + max(x for x, _ in model.outline(True))
    assert any(outline[:, 0].max() == pytest.approx(nose_x) for outline in outlines)


@pytest.mark.parametrize("size, ending", [(0.3, "png"), (4000.0, "svg"), (30.0, "pdf")])
def test_any_size_and_format(tmp_path, size, ending):
    path = tmp_path / ("own.%s" % ending)
    walls = [(0, 0, size, 0), (size, 0, size, size / 9)]
    draw_world(World("own", walls=walls, cans=[Can(0.0, 1.0)], starts=[(0.0, 0.1, 0.0)]), str(path))
    assert path.read_bytes()[:5] in (b"\x89PNG\r", b"<?xml", b"%PDF-")


def test_the_command(tmp_path, capsys):
    path = tmp_path / "mine.map"
    path.write_text("2D-Map\nCairn: Label\nLINES\n0 0 1000 0\n")
    assert main([str(path), "-o", str(tmp_path / "mine.png"), "--robots", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[::2] == ["skipped: Label, line 2", str(tmp_path / "mine.png")]
    assert (tmp_path / "mine.png").stat().st_size > 3000


def test_the_image_of_a_map_is_not_drawn_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.map").write_text("2D-Map\nLINES\n0 0 1000 0\n")
    (tmp_path / "lab.png").write_bytes(b"precious")
    assert main(["lab.map"]) == 0
    assert (tmp_path / "lab.png").read_bytes() == b"precious" and (tmp_path / "world-lab.png").stat().st_size > 3000


@pytest.mark.parametrize("arguments, message", [
    (["tutoral"], "did you mean 'tutorial'"),
    (["empty", "-o", "empty.bmp"], "empty.bmp: a picture's name ends in .png, .pdf, .svg"),
    (["empty", "--model", "p4"], "p4"),
    (["tutorial", "--robots", "500"], "has room for"),
    (["empty", "-o", "no/such/folder/empty.png"],
     "cannot write no/such/folder/empty.png: there is no directory no/such/folder"),
])
def test_mistakes_are_told(arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


def test_without_matplotlib(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["empty"]) == 2
    assert "pictures need matplotlib" in capsys.readouterr().err


def test_no_other_formats():
    with pytest.raises(UsageError, match="ends in .png"):
        draw_world(World("own"), "own.bmp")

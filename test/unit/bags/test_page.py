"""Pages of runs of every kind: all that is written can be read, and lies on a sheet of A4. Drawn from runs made by hand."""

import itertools
import re

import numpy as np
import pytest

import run_factory as make
from pioneer_control.bags.pages import page, side_by_side
from pioneer_control.bags.pages.sheet import HEIGHT, RIGHT, WIDTH, Sheet
from pioneer_control.errors import UsageError

STILL = make.track(30.0)._replace(**{name: np.zeros(301) for name in ("x", "y", "heading")})
RUNS = {
    "only odometry": make.run(),
    "two seconds": make.full(make.track(2.0), times=1),
    "a minute": make.full(make.track(60.0)),
    "hours, with much to tell": make.full(make.track(3 * 3600.0, step=1.0), times=200),
    "never moved": make.run(STILL, measured=make.velocities(STILL), motors=make.series((0, 0))),
    "a single pose": make.run(make.run().odometry._replace(**{name: np.array([1.0]) for name in ("time", "x", "y", "heading")})),
    "a long way ahead": make.run(make.track(60.0), measured=make.velocities(make.track(60.0))),
    "a long way to the left": make.full(make.track(60.0, towards=np.pi / 2)),
    "without outline and names": make.run(footprint=np.empty((0, 2)), model="", robot=""),
    "with words that are no words": make.run(robot="a$b$c\n" * 30, faults=make.full(make.track(9.0)).faults[:2]),
}


def boxes(sheet):
    """What is written on a sheet: (words, box in inches) of the sheet's own texts, and of the axes'."""
    def box(text):
        found = text.get_window_extent(sheet.canvas.get_renderer())
        return np.array([found.x0, found.y0, found.x1, found.y1]) / sheet.dpi

    sheet.canvas.draw()
    own = [(text.get_text(), box(text)) for text in sheet.texts if text.get_text().strip()]
    axes = [text for each in sheet.axes for axis in (each.xaxis, each.yaxis) for text in [axis.label] + shown_ticks(axis)]
    return own, [(text.get_text(), box(text)) for text in axes if text.get_text()]


def shown_ticks(axis):
    """The numbers at an axis; matplotlib keeps some more for what is out of sight."""
    low, high = sorted(axis.get_view_interval())
    return [text for place, text in zip(axis.get_majorticklocs(), axis.get_ticklabels()) if low <= place <= high]


def overlapping(written):
    """Pairs of words that lie on each other."""
    pairs = itertools.combinations(written, 2)
    return [(one, two) for (one, a), (two, b) in pairs if (np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]) > 0.01).all()]


@pytest.mark.parametrize("name", RUNS)
def test_everything_lies_on_a_sheet_and_nothing_on_each_other(name):
    sheet = page.figure(RUNS[name])
    width, height = sheet.get_size_inches()
    assert width == WIDTH and height <= HEIGHT + 0.01
    own, of_axes = boxes(sheet)
    assert overlapping(own) == []
    assert [words for words, (left, low, right, high) in own + of_axes if left < 0 or low < 0 or right > width or high > height] == []
    frames = [each.get_position().extents * np.tile([width, height], 2) for each in sheet.axes]
    assert overlapping([(str(number), frame) for number, frame in enumerate(frames)]) == []
    assert all(frame[2] < RIGHT + 0.01 for frame in frames)


def test_words_on_each_other_are_seen():
    sheet = Sheet(2.0)
    for left in (1.0, 1.1, 3.0):
        sheet.text(left, 1.0, "words")
    assert overlapping(boxes(sheet.figure)[0]) == [("words", "words")]


def test_a_long_text_ends_in_dots_before_it_leaves_its_room():
    sheet = Sheet(2.0)
    text = sheet.text(1.0, 1.0, make.LONG_TEXT, room=2.0)
    assert sheet.wide(text) <= 2.0 and text.get_text().endswith("…") and len(text.get_text()) > 20


def test_the_head_has_the_figures_and_says_what_is_damaged():
    words = " ".join(words for words, _ in boxes(page.figure(RUNS["a minute"]))[0])
    for figure in ("60 s", "12.0 m driven", "odometry 0 cm off", "2 errors", "3 warnings", "5 gaps in the data", "damaged: it was not closed"):
        assert figure in words


def strip(sheet, name):
    """The axes of a strip."""
    return next(axes for axes in sheet.axes if axes.get_ylabel().startswith(name))


def test_commanded_and_measured_lie_on_one_axis_of_time():
    sheet = page.figure(RUNS["a minute"])
    for name in ("forward", "turn left"):
        assert [line.get_label() for line in strip(sheet, name).lines[:2]] == ["commanded", "measured"]
    assert len({axes.get_xlim() for axes in sheet.axes[1:]}) == 1


def test_gaps_are_shaded_through_all_strips():
    shaded = page.figure(RUNS["a minute"])
    plain = page.figure(RUNS["a minute"]._replace(gaps=()))
    for name in ("forward", "turn left", "battery"):
        assert len(strip(shaded, name).patches) == len(strip(plain, name).patches) + 5


class TestComparison:
    def compare(self, *runs):
        return side_by_side.figure(runs)

    def table(self, sheet):
        return [words for words, _ in boxes(sheet)[0]]

    def test_everything_lies_on_a_sheet(self):
        chosen = [RUNS[name]._replace(path="%s.bag" % name) for name in list(RUNS)[: side_by_side.MOST]]
        sheet = self.compare(*chosen)
        own, of_axes = boxes(sheet)
        assert sheet.get_size_inches()[1] <= HEIGHT + 0.01 and overlapping(own) == []
        assert all(left >= 0 and low >= 0 and right <= WIDTH for _, (left, low, right, high) in own + of_axes)

    def test_figures(self):
        slow = make.run(make.track(20.0, speed=0.1), path="slow.bag", damage="cut off")
        words = self.table(self.compare(make.run(path="first.bag"), slow))
        assert {"first", "slow (damaged)", "20 s", "4.00 m", "0.20 m/s", "2.00 m", "0.10 m/s"} <= set(words)
        assert any(re.fullmatch(r"1\.\d\d m, \+0°", text) for text in words)

    @pytest.mark.parametrize("models, title", [(("p3dx", "p3dx"), "2 runs of 2 robots: a, b (p3dx)"), (("p3dx", "p3at"), "2 runs of 2 robots: a (p3dx), b (p3at)"),
                                               (("", ""), "2 runs of 2 robots: a, b")])
    def test_what_all_are_is_said_once(self, models, title):
        runs = [make.run(robot=robot, model=model) for robot, model in zip("ab", models)]
        assert self.table(self.compare(*runs))[0] == title

    def test_the_map_is_drawn_only_where_all_were_in_it(self):
        here = RUNS["a minute"]
        sheets = [self.compare(here, other) for other in (here, here._replace(world="maze"), here._replace(truth=None))]
        assert [len(sheet.axes[0].images) for sheet in sheets] == [1, 0, 0]
        titles = [self.table(sheet)[0] for sheet in sheets]
        assert titles[0].endswith("in tutorial") and titles[1].endswith("in 2 worlds: tutorial, maze")

    def test_the_true_paths_are_compared_only_where_all_are_known(self):
        with_truth = RUNS["a minute"]
        assert side_by_side.compared([with_truth, with_truth])[0].track is with_truth.truth
        assert side_by_side.compared([with_truth, make.run()])[0].track is with_truth.odometry

    def test_different_robots_are_named(self):
        assert "2 robots" in " ".join(self.table(self.compare(make.run(), make.run(model="amigo-sh"))))

    @pytest.mark.parametrize(
        "runs, names",
        [
            ([("a/x.bag", "p"), ("a/y.bag.active", "p")], ["x", "y"]),
            ([("a/x.bag", "p"), ("b/x.bag", "p")], ["a/x", "b/x"]),
            ([("x.bag", "alice"), ("x.bag", "bob")], ["x alice", "x bob"]),
        ],
    )
    def test_names_tell_apart(self, runs, names):
        assert side_by_side.names([make.run(path=path, robot=robot) for path, robot in runs]) == names

    def test_too_many(self):
        with pytest.raises(UsageError, match="8 runs are too many.*up to 7"):
            side_by_side.compared([make.run()] * 8)


@pytest.mark.parametrize(
    "notes, says",
    [
        ("", ""),
        ("{a: [", ""),
        ("recording: {}\nparameters: {}", ""),
        ("{recording: {}, parameters: {}, versions: {pioneer_control: 0.1.0, system: Debian}}", "recorded with pioneer_control 0.1.0, Debian"),
        ("{recording: {}, parameters: {}, versions: {commit: abcdef01234567}}", "recorded with commit abcdef0123"),
    ],
)
def test_with_what_a_run_was_recorded(notes, says):
    assert page.recorded_with(notes) == says


def test_a_robot_that_backs_off_looks_one_way_and_goes_the_other():
    backwards = make.track(60.0, speed=-0.2, bend=0.0)
    axes = page.figure(make.run(backwards)).axes[0]
    strokes = [line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 2 and line.get_label().startswith("_") and line.get_linewidth() < 2]
    assert strokes and all(end > begin for begin, end in strokes)
    arrows = axes.collections[0].get_paths()
    assert arrows and all(np.argmin(arrow.vertices[:4, 0]) == 0 for arrow in arrows), "the tip is the first point"


def test_hours_on_one_way_leave_it_to_be_seen():
    there_and_back = make.track(60.0)
    long = type(there_and_back)(*(np.tile(values, 50) for values in there_and_back))._replace(time=make.BEGIN + np.arange(50 * 601) * 0.1)
    count = [len(page.figure(make.run(each)).axes[0].collections[0].get_paths()) for each in (there_and_back, long)]
    assert count[1] < 4 * count[0]


def test_runs_can_be_told_apart_without_colours():
    styles = [(str(look["linestyle"]), look["linewidth"] > 2) for look in side_by_side.LOOKS]
    assert len(set(styles)) == len(styles)

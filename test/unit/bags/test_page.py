"""Pages of runs of every kind, made by hand. All text can be read, and lies on a sheet of A4."""

import itertools
import re

import numpy as np
import pytest

import run_factory as make
from pioneer_control.bags.pages import from_above, page, side_by_side
from pioneer_control.bags.pages.sheet import HEIGHT, RIGHT, WIDTH, Sheet
from pioneer_control.bags.recorded_run import CanPath, Echoes, Goal, Map, Report, Span
from pioneer_control.errors import UsageError

STILL = make.track(30.0)._replace(**{name: np.zeros(301) for name in ("x", "y", "heading")})
RUNS = {
    "only odometry": make.run(),
    "two seconds": make.full(make.track(2.0), times=1),
    "a minute": make.full(make.track(60.0)),
    "hours, with much to tell": make.full(make.track(3 * 3600.0, step=1.0), times=200),
    "never moved": make.run(STILL, measured=make.velocities(STILL), motors=make.series((0, 0))),
    "a single pose": make.run(
        make.run().odometry._replace(**{name: np.array([1.0]) for name in ("time", "x", "y", "heading")})),
    "a long way ahead": make.run(make.track(60.0), measured=make.velocities(make.track(60.0))),
    "a long way to the left": make.full(make.track(60.0, towards=np.pi / 2)),
    "with navigation": make.full(make.track(60.0))._replace(navigation=make.navigated(make.track(60.0))),
    "with navigation, a long way ahead": make.run(make.track(60.0), navigation=make.navigated(make.track(60.0))),
    "with navigation, a long way to the left": make.full(make.track(60.0, towards=np.pi / 2))._replace(
        navigation=make.navigated(make.track(60.0, towards=np.pi / 2)), map_made=True),
    "without outline and names": make.run(footprint=np.empty((0, 2)), model="", robot=""),
    "with words that are no words": make.run(robot="a$b$c\n" * 30, faults=make.full(make.track(9.0)).faults[:2]),
}


def boxes(sheet):
    """Return the texts on a sheet: (words, box in inches) of the sheet's own texts, and of the texts of its axes."""
    def box(text):
        found = text.get_window_extent(sheet.canvas.get_renderer())
        return np.array([found.x0, found.y0, found.x1, found.y1]) / sheet.dpi

    sheet.canvas.draw()
    own = [(text.get_text(), box(text)) for text in sheet.texts if text.get_text().strip()]
    axes = [text for each in sheet.axes for axis in (each.xaxis, each.yaxis)
            for text in [axis.label] + shown_ticks(axis)]
    return own, [(text.get_text(), box(text)) for text in axes if text.get_text()]


def shown_ticks(axis):
    """Return the numbers at an axis. matplotlib has some more numbers that are not visible."""
    low, high = sorted(axis.get_view_interval())
    return [text for place, text in zip(axis.get_majorticklocs(), axis.get_ticklabels()) if low <= place <= high]


def overlapping(written):
    """Return pairs of words whose boxes overlap."""
    pairs = itertools.combinations(written, 2)
    return [(one, two) for (one, a), (two, b) in pairs
            if (np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]) > 0.01).all()]


@pytest.mark.parametrize("name", RUNS)
def test_everything_lies_on_a_sheet_and_nothing_on_each_other(name):
    sheet = page.figure(RUNS[name])
    width, height = sheet.get_size_inches()
    assert width == WIDTH and height <= HEIGHT + 0.01
    own, of_axes = boxes(sheet)
    assert overlapping(own) == []
    assert [words for words, (left, low, right, high) in own + of_axes if left < 0 or low < 0 or right > width
            or high > height] == []
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
    for figure in ("60 s", "12.0 m driven", "odometry exact: ideal wheels", "2 errors", "3 warnings",
                   "5 gaps in the data", "damaged: it was not closed"):
        assert figure in words


def test_odometry_that_errs_is_said_in_centimetres():
    true = make.track(60.0)
    view = from_above.view_of(make.run(true, truth=true._replace(x=true.x * 1.01)))
    assert any(re.fullmatch(r"odometry [1-9]\d* cm off at the end", figure)
               for figure in page.summary(view.run, view, ()))
    assert "as the robot's odometry has it" in page.summary(make.run(), from_above.view_of(make.run()), ())


def test_a_long_text_of_a_fault_is_wrapped():
    words = make.LONG_TEXT + ": " + " ".join("word%s" % number for number in range(12))
    written = [words for words, _ in boxes(page.figure(make.run(faults=(Report(make.BEGIN + 1.0, 2, "", words),))))[0]]
    whole = " ".join(written)
    assert words in whole and not any(line.endswith("…") for line in written if line in words)


def test_a_text_without_end_ends_in_dots_after_some_lines():
    sheet = page.figure(make.run(faults=(Report(make.BEGIN + 1.0, 2, "", make.LONG_TEXT * 9),)))
    written = [words for words, _ in boxes(sheet)[0]]
    lines = [line for line in written if line.rstrip("…") in make.LONG_TEXT * 9 and len(line) > 40]
    assert len(lines) == page.LINES and lines[-1].endswith("…")


class TestEchoesBesideTheirWalls:
    # from -1.8 to 4.2 m
    ROOM = Map(np.pad(np.zeros((60, 60), dtype=np.int8), 2, constant_values=100), 0.1, (-2.0, -2.0, 0.0))

    def beside(self, *points, **fields):
        track = make.track(1.0)
        view = from_above.view_of(make.run(track, truth=track, map=self.ROOM, **fields))
        return from_above.beside_things(view._replace(echoes=np.array(points))).tolist()

    def test_at_a_wall_or_not(self):
        points = (4.25, 1.0), (4.1, 1.0), (3.9, 1.0), (1.0, -1.9), (1.0, 1.0), (99.0, 0.0)
        assert self.beside(*points) == [False, False, True, False, True, True]

    def test_a_can_is_a_thing_wherever_it_was(self):
        can = CanPath(np.array([0.0, 1.0]), np.array([1.0, 2.0]), np.array([1.0, 1.0]), np.zeros(2))
        assert self.beside((1.05, 1.0), (2.0, 1.0), (1.5, 1.0), cans=(can,)) == [False, False, True]

    def test_a_map_that_is_turned(self):
        track = make.track(1.0)
        view = from_above.view_of(make.run(track, truth=track, map=self.ROOM._replace(origin=(2.0, -2.0, np.pi / 2))))
        view = view._replace(echoes=np.array([(-4.1, 1.0), (-3.0, 1.0)]))
        assert from_above.beside_things(view).tolist() == [False, True]

    def test_without_a_map_nobody_knows(self):
        view = from_above.view_of(RUNS["a long way ahead"])
        assert from_above.beside_things(view._replace(echoes=np.ones((3, 2)))).tolist() == [False] * 3

    def test_the_page_explains_them(self):
        words = [words for words, _ in boxes(page.figure(RUNS["a minute"]))[0]]
        assert page.ECHO_NOTE % "Odometry" in words
        assert not [words for words, _ in boxes(page.figure(make.run()))[0] if "places the echoes" in words]
        words = [words for words, _ in boxes(page.figure(RUNS["with navigation"]))[0]]
        assert page.ECHO_NOTE % "Navigation" in words


class TestCans:
    def run(self, *paths, **fields):
        track = make.track(20.0)
        return make.run(track, truth=track,
                        cans=tuple(CanPath(make.BEGIN + np.array(time), *(np.array(each) for each in path))
                                   for time, *path in paths), **fields)

    def test_a_pushed_can_is_said_and_its_way_is_in_the_legend(self):
        sheet = page.figure(self.run(((0, 1), (9, 9), (9, 9), (0, 0)),
                                     ((0, 8, 8.1, 8.2), (1.0, 1.0, 1.1, 1.31), (0, 0, 0, 0), (0, 0, 0, 0))))
        assert "can 2 pushed 0.31 m at 8 s" in [words for words, _ in boxes(sheet)[0]]
        assert "way of a can" in [text.get_text() for text in sheet.legends[0].get_texts()]
        assert "can 2" in [text.get_text() for text in sheet.axes[0].texts]

    def test_cans_that_stay_are_not(self):
        sheet = page.figure(self.run(((0, 1), (1, 1), (1, 1), (0, 0))))
        assert not any("pushed" in words for words, _ in boxes(sheet)[0])
        assert "way of a can" not in [text.get_text() for text in sheet.legends[0].get_texts()]


def strip(sheet, name):
    """Return the axes of a strip."""
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

    @pytest.mark.parametrize("models, title", [
        (("p3dx", "p3dx"), "2 runs of 2 robots: a, b (p3dx)"),
        (("p3dx", "p3at"), "2 runs of 2 robots: a (p3dx), b (p3at)"),
        (("", ""), "2 runs of 2 robots: a, b"),
    ])
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
        ("{recording: {}, parameters: {}, versions: {pioneer_control: 0.1.0, system: Debian}}",
         "recorded with pioneer_control 0.1.0, Debian"),
        ("{recording: {}, parameters: {}, versions: {commit: abcdef01234567}}", "recorded with commit abcdef0123"),
    ],
)
def test_with_what_a_run_was_recorded(notes, says):
    assert page.recorded_with(notes) == says


def test_a_robot_that_backs_off_looks_one_way_and_goes_the_other():
    backwards = make.track(60.0, speed=-0.2, bend=0.0)
    axes = page.figure(make.run(backwards)).axes[0]
    strokes = [line.get_xdata() for line in axes.lines if len(line.get_xdata()) == 2
               and line.get_label().startswith("_") and line.get_linewidth() < 2]
    assert strokes and all(end > begin for begin, end in strokes)
    arrows = axes.collections[0].get_paths()
    assert arrows and all(np.argmin(arrow.vertices[:4, 0]) == 0 for arrow in arrows), "the tip is the first point"


def test_hours_on_one_way_leave_it_to_be_seen():
    there_and_back = make.track(60.0)
    long = type(there_and_back)(*(np.tile(values, 50) for values in there_and_back))
    long = long._replace(time=make.BEGIN + np.arange(50 * 601) * 0.1)
    count = [len(page.figure(make.run(each)).axes[0].collections[0].get_paths()) for each in (there_and_back, long)]
    assert count[1] < 4 * count[0]


def test_runs_can_be_told_apart_without_colours():
    styles = [(str(look["linestyle"]), look["linewidth"] > 2) for look in side_by_side.LOOKS]
    assert len(set(styles)) == len(styles)


class TestShortNames:
    @pytest.mark.parametrize("long, short", [
        (["one", "two"], ["one", "two"]),
        (["tutorial_2026-11-22-08-39-28_seed_1", "tutorial_2026-11-22-08-39-28_seed_12"],
         ["…11-22-08-39-28_seed_1", "…11-22-08-39-28_seed_12"]),
        (["tutorial_2026-11-22-08-39-28", "tutorial_2026-11-22-09-02-11"],
         ["…2026-11-22-08-39-28", "…2026-11-22-09-02-11"]),
        (["alice_in_a_very_long_corridor_with_cans", "bob_in_a_very_long_corridor_with_cans"],
         ["alice_in_a_v…or_with_cans", "bob_in_a_ver…or_with_cans"]),
    ])
    def test_they_say_what_differs(self, long, short):
        assert side_by_side.shortened(long) == short

    @pytest.mark.parametrize("long", [
        ["x%s_%s" % (number, "a" * 20 + str(number) + "b" * 20) for number in range(3)],
        ["a" * 20 + str(number) + "b" * 20 + end for number in range(3) for end in "xy"],
    ])
    def test_no_two_are_alike_and_none_is_longer_than_its_room(self, long):
        short = side_by_side.shortened(long)
        assert len(set(short)) == len(long) and max(map(len, short)) <= side_by_side.LONGEST_NAME

    def test_they_are_in_the_table(self):
        runs = [make.run(path="tutorial_2026-11-22-08-39-28-seed-%s.bag" % seed) for seed in (1, 2)]
        words = [words for words, _ in boxes(side_by_side.figure(runs))[0]]
        assert {"…11-22-08-39-28-seed-1", "…11-22-08-39-28-seed-2"} <= set(words)


class TestNavigation:
    TRUE = make.track(60.0)

    def run(self, **fields):
        return make.run(self.TRUE, **{**dict(truth=self.TRUE, navigation=make.navigated(self.TRUE)), **fields})

    def test_the_head_says_how_well_it_navigated(self):
        assert page.navigated(self.run()) == [
            "Navigation: 1 of 3 goals reached", "15 s not sure where it was",
            "while sure 10 cm and 0.0° off (95 %: 10 cm, 0.0°)"]
        assert page.navigated(make.run()) == []
        still = make.navigated(self.TRUE, goals=(), unsure=())
        assert page.navigated(self.run(truth=None, navigation=still)) == ["Navigation: no goal"]

    def test_an_exploration_has_no_count_of_goals(self):
        chosen = tuple(Goal(make.BEGIN + n, n, 1.0, "explored") for n in range(3))
        sent = Goal(make.BEGIN + 9, 1.0, 1.0, "reached")
        for goals, words in ((chosen, "explored"), ((*chosen, sent), "explored, 1 of 1 goals reached")):
            run = self.run(navigation=make.navigated(self.TRUE, goals=goals))
            assert page.navigated(run)[0] == "Navigation: " + words

    def test_only_what_it_was_sure_of_counts(self):
        jump = self.TRUE._replace(x=self.TRUE.x + np.where(self.TRUE.time < make.BEGIN + 14.0, 5.0, 0.0))
        off, _ = self.run(navigation=make.navigated(self.TRUE, track=jump)).navigation_errors()
        assert off.max() < 1e-9
        off, _ = self.run(navigation=make.navigated(self.TRUE, track=jump, unsure=())).navigation_errors()
        assert off.max() == pytest.approx(5.0)

    def test_a_map_that_it_made_begins_with_it(self):
        there = self.TRUE.seen_from((3.0, 4.0, 1.0))
        can = CanPath(there.time[:1], there.x[50:51], there.y[50:51], np.zeros(1))
        run = self.run(truth=there, navigation=make.navigated(self.TRUE, off=0.0), map_made=True, cans=(can,))
        assert (run.cans_in_map[0].x[0], run.cans_in_map[0].y[0]) == pytest.approx((self.TRUE.x[50], self.TRUE.y[50]))
        assert run.navigation_errors()[0].max() < 1e-6
        assert "on the map that it made; the true path is laid on where it was first sure" in page.navigated(run)
        assert self.run(truth=there, navigation=make.navigated(self.TRUE, off=0.0)).navigation_errors()[0].min() > 1.0

    def test_a_saved_map_of_its_own_frame_begins_where_the_robot_was_first_sure(self):
        there = self.TRUE.seen_from((3.0, 4.0, 1.0))
        lost = self.TRUE._replace(x=self.TRUE.x + np.where(self.TRUE.time < make.BEGIN + 14.0, 5.0, 0.0))
        run = self.run(truth=there, navigation=make.navigated(self.TRUE, track=lost), own_frame=True)
        assert run.navigation_errors()[0].max() < 1e-6
        assert page.navigated(run)[-1] == (
            "on a map with a frame of its own; the true path is laid on where it was first sure")

    def test_without_truth_it_shows_where_it_believed_to_be(self):
        view = from_above.view_of(self.run(truth=None, map=TestEchoesBesideTheirWalls.ROOM))
        assert view.path.time[0] >= make.BEGIN + 15.0 and view.walls is not None, "while it was sure"
        assert set(view.path.y) <= set(view.run.navigation.track.y)
        assert "as navigation has it" in page.summary(view.run, view, ())
        at = view.run.navigation.sure_from
        assert view.odometry.at([at]).pose(0) == pytest.approx(view.path.at([at]).pose(0)), "odometry begins when sure"

    def test_where_it_only_guessed_to_be_is_no_way_and_places_no_echo(self):
        guess = self.TRUE._replace(x=self.TRUE.x + np.where(self.TRUE.time < make.BEGIN + 14.0, 50.0, 0.0))
        heard = Echoes(self.TRUE.time, np.zeros(len(self.TRUE.time)), np.ones(len(self.TRUE.time)))
        run = self.run(truth=None, sonar=heard, transducers={0: (0.0, 0.0, 0.0)},
                       navigation=make.navigated(self.TRUE, track=guess))
        view = from_above.view_of(run)
        assert page.summary(run, view, ())[1] == "%.1f m driven" % run.odometry.length
        assert view.path.x.max() < 40.0 and len(view.echoes) and view.echoes[:, 0].max() < 40.0
        lost = self.run(truth=None, navigation=make.navigated(
            self.TRUE, unsure=(Span(make.BEGIN, make.BEGIN + 61.0, ""),), sure_from=None))
        assert from_above.view_of(lost).path is not None and page.figure(lost)

    def test_signs_of_all_that_is_drawn(self):
        sheet = page.figure(self.run())
        shown = [text.get_text() for text in sheet.legends[0].get_texts()]
        goals = ("goal reached", "goal failed", "goal replaced")
        for sign in ("true path", "believed", "not sure", "plan", "cloud", *goals):
            assert shown.count(sign) == 1

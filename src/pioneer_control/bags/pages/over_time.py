"""Draw a run over time: strips of curves (velocities, battery) and lanes (states, events) above one axis of time."""

from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ...pictures import BEYOND, BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, SKY, VERMILLION, draw_grid
from ..navigation_collectors import DRIVES, UNSURE, WAITS
from ..recorded_run import ERROR, WARNING, Run, Series, Span, Velocities
from .from_above import BADGES, EVENT
from .incidents import Incident, made, silences
from .sheet import RIGHT, Sheet, plain
from .timeline import Timeline, spread

CURVE, BATTERY, LANE = 0.7, 0.4, 0.19  # inches: heights
BETWEEN = 0.09  # inches between two strips
NAMES = 1.15  # inches from the left edge of the sheet: room for the names of the strips
TICKS_APART = 0.65  # inches between two times on the axis
LEAST_SPEED, LEAST_VOLTS = 0.1, 1.0  # m/s or rad/s, V: the shortest range of an axis, so that noise looks small
BADGES_APART, VALUES_APART = 0.17, 0.12  # inches between two badges, and between two numbers on an axis of values
# drawn in steps, because a command holds until the next one
COMMANDED = dict(label="commanded", color=ORANGE, linewidth=3.0, alpha=0.7, drawstyle="steps-post")
MEASURED = dict(label="measured", color=BLUE, linewidth=1.0)  # thin and dark over wide and light
VOLTAGE = dict(color=INK, linewidth=1.0)
DOINGS = 5  # the largest number of lanes for what a program decided and navigation did
SAID = {ERROR: "errors", WARNING: "warnings"}
SAID_COLOUR = {ERROR: VERMILLION, WARNING: ORANGE}
BROKEN, SILENT, SILENCE = "made to fail", "no data", "#b4b4b4"
ROWS, LETTER = 3, 0.053  # the largest number of lanes of one kind; inches: the width of a letter on them

Look = Dict[str, Any]
"""Properties of a matplotlib line."""


class Lane(NamedTuple):
    """A row of spans of time (s), with badges and texts on it."""

    name: str
    colour: str
    hatch: str
    spans: Tuple[Tuple[float, float], ...]
    badges: Tuple[Tuple[float, str, str], ...] = ()  # of each badge: its time (s), its text and its colour
    words: Tuple[Tuple[float, str], ...] = ()  # of each text: the time (s) of its left end, and the text


class Curves(NamedTuple):
    """A strip of lines."""

    name: str
    height: float  # inches
    lines: Tuple[Tuple[np.ndarray, np.ndarray, Look], ...]  # of each line: times (s), values, and how it is drawn
    least: float  # the shortest range of the axis, in the unit of the values
    zero: bool  # whether the axis shows zero


def ink_on(colour: str) -> str:
    """Return a colour for letters that can be read on this colour."""
    return INK if colour == ORANGE else "white"


def curves(run: Run) -> List[Curves]:
    """Return the strips of a run: its velocities and its battery, as far as they are known."""
    time, volts = broken(run.battery, run.gaps, "battery", "battery_state")
    battery = Curves("battery\n(V)", BATTERY, ((time, volts, VOLTAGE),), LEAST_VOLTS, False)
    return velocities([(run.commanded, COMMANDED), (measured(run), MEASURED)]) + [battery] * bool(len(time))


def measured(run: Run) -> Velocities:
    """Return the measured velocities, with NaN where the bag has a gap."""
    return Velocities(*broken(run.measured, run.gaps, "pose", "odom"))


def broken(lines: Sequence[np.ndarray], gaps: Sequence[Span], *topics: str) -> List[np.ndarray]:
    """Add NaN in each gap of the data, so that no line is drawn across it.

    Args:
        lines: an array of times (s), and arrays of values at these times.
        gaps: the gaps of all topics.
        topics: the last names of the topics whose gaps count.

    Returns:
        The longer arrays.
    """
    time = lines[0]
    silent = [gap for gap in silences([gap for gap in gaps if gap.what.rsplit("/", 1)[-1] in topics])
              if len(time) and time[0] < gap.begin < gap.end < time[-1]]
    if not silent:
        return list(lines)
    places = [np.searchsorted(time, gap.end) for gap in silent for _ in range(3)]
    edges = np.array([(gap.begin, (gap.begin + gap.end) / 2, gap.end) for gap in silent]).reshape(-1)
    values = (np.where(np.arange(len(edges)) % 3 == 1, np.nan, np.interp(edges, time, line)) for line in lines[1:])
    return [np.insert(line, places, new) for line, new in zip(lines, (edges, *values))]


def velocities(each: Sequence[Tuple[Velocities, Look]]) -> List[Curves]:
    """Return two strips, forward and turn, with velocities and their looks. Empty if there are no velocities."""
    some = [(v, look) for v, look in each if len(v.time)]
    return [
        Curves("forward\n(m/s)", CURVE, tuple((v.time, v.linear, look) for v, look in some), LEAST_SPEED, True),
        Curves("turn left\n(rad/s)", CURVE, tuple((v.time, v.angular, look) for v, look in some), LEAST_SPEED, True),
    ] * bool(some)


def lanes(run: Run, wrong: Sequence[Incident], timeline: Timeline, inches: float = RIGHT - NAMES) -> List[Lane]:
    """Return the lanes of a run. What never happened has no lane.

    The motors always have a lane if the bag contains their state.

    Args:
        run: the run.
        wrong: the warnings and errors of the run.
        timeline: the timeline of the run.
        inches: the width of the lanes.
    """
    end = timeline.end
    held_by = tuple((event.time, str(number), EVENT[event.what]) for number, event in enumerate(run.gripper, 1))
    spans = [
        Lane("motors on", GREEN, "", on(run.motors, end)),
        *navigation_lanes(run),
        Lane("STOP button", VERMILLION, "////", on(run.e_stop, end)),
        Lane("stalled", PURPLE, "xxxx", tuple((span.begin, span.end) for span in run.stalls)),
        Lane("bumped", INK, "....", tuple((span.begin, span.end) for span in run.bumps)),
        Lane("gripper", SKY, "", held(run, end), held_by if len(held_by) <= BADGES else ()),
    ]
    return [
        *[lane for lane in spans if lane.spans or lane.badges or (lane.name == "motors on" and len(run.motors.time))],
        *doings(run),
        *[lane for lane in (_said(level, wrong) for level in SAID) if lane.spans],
        *packed(BROKEN, PURPLE, made(run.faults, end), timeline, inches),
        *packed(SILENT, SILENCE, silences(run.gaps), timeline, inches),
    ]


def navigation_lanes(run: Run) -> List[Lane]:
    """Return the lanes of a robot that navigates: when it drove to a goal and when it waited, and when it was not sure
    where it was.
    """
    if run.navigation is None:
        return []

    def lane(what: str, colour: str, hatch: str, spans: Sequence[Span]) -> Lane:
        return Lane(what, colour, hatch, tuple((span.begin, span.end) for span in spans if span.what == what))

    return [lane(DRIVES, BLUE, "", run.navigation.states), lane(WAITS, ORANGE, "////", run.navigation.states),
            lane(UNSURE, VERMILLION, "xxxx", run.navigation.unsure)]


def packed(name: str, colour: str, spans: Sequence[Span], timeline: Timeline, inches: float) -> List[Lane]:
    """Put spans with texts on as few lanes as possible, so that they do not overlap.

    There are at most `ROWS` lanes. When they are full, more spans are put on the last lane, without a text.
    """
    rows = [Lane("" if row else name, colour, "", ()) for row in range(ROWS)]
    ends = [timeline.begin] * ROWS
    for span in sorted(spans):
        wide = LETTER * len(span.what) * timeline.span / inches
        begin = max(min(span.begin, timeline.end - wide), timeline.begin)
        free = [row for row, end in enumerate(ends) if end <= begin]
        row = free[0] if free else ROWS - 1
        rows[row] = rows[row]._replace(spans=(*rows[row].spans, (span.begin, span.end)),
                                       words=(*rows[row].words, *[(begin, span.what)] * bool(free)))
        ends[row] = max(ends[row], span.end, begin + wide)
    return [row for row in rows if row.spans]


def on(series: Series, end: float) -> Tuple[Tuple[float, float], ...]:
    """Return the spans of time (s) in which a value is not zero. The last value holds until `end` (s)."""
    time = np.append(series.time, max([end, *series.time[-1:]]))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], series.value != 0, [0]))))
    return tuple((float(time[begin]), float(time[until])) for begin, until in zip(edges[::2], edges[1::2]))


def held(run: Run, end: float) -> Tuple[Tuple[float, float], ...]:
    """Return the spans of time (s) in which the gripper held something that it had picked up in the run."""
    changes = [(event.time, event.what == "picked up") for event in run.gripper]
    return on(Series(*np.array(changes, dtype=float).reshape(-1, 2).T), end)


def doings(run: Run) -> List[Lane]:
    """Return a lane for each of the commonest decisions of a program: "driving", "turning", ..."""
    most = DOINGS - len(navigation_lanes(run))
    spans: Dict[str, List[Tuple[float, float]]] = {}
    for begin, end, what in run.doings:
        spans.setdefault(what, []).append((begin, end))
    commonest = sorted(spans, key=lambda what: -sum(end - begin for begin, end in spans[what]))[:most]
    return [Lane("decided: " + what, FAINT, "", tuple(spans[what])) for what in spans if what in commonest]


def _said(level: int, wrong: Sequence[Incident]) -> Lane:
    """Return the lane of all warnings or all errors, with a letter at the first report of each incident."""
    mine = [each for each in wrong if each.level == level]
    return Lane(SAID[level], SAID_COLOUR[level], "", tuple((time, time) for each in mine for time in each.times),
                tuple((each.times[0], each.letter, SAID_COLOUR[level]) for each in mine if each.letter))


def height(shown: Sequence[Curves], lanes: int) -> float:
    """Return the height (inches) of strips and of a number of lanes, without the axis of time."""
    return sum(each.height + BETWEEN for each in shown) + LANE * lanes


def draw(sheet: Sheet, left: float, top: float, shown: Sequence[Curves], rows: Sequence[Lane], timeline: Timeline,
         since: str = "the start") -> None:
    """Draw strips under each other, and the axis of time below the last strip.

    Args:
        sheet: the sheet to draw on.
        left: the left end of the axes (inches).
        top: the upper end of the first strip (inches).
        shown: the strips of curves.
        rows: the lanes, which are drawn below the curves.
        timeline: the timeline of the axis.
        since: when the time is zero, in words.
    """
    width = RIGHT - left
    drawn = []
    for each in shown:
        drawn.append(sheet.axes(left, top, width, each.height))
        draw_curves(drawn[-1], each, width)
        top += each.height + BETWEEN
    if rows:
        drawn.append(sheet.axes(left, top, width, LANE * len(rows)))
        draw_lanes(drawn[-1], rows, timeline, width)
    for axes in drawn:
        draw_time(axes, timeline, int(width / TICKS_APART),
                  "time since %s (%s)" % (since, timeline.unit) if axes is drawn[-1] else None)
        for begin, end in (span for lane in rows if lane.colour == SILENCE for span in lane.spans):
            axes.axvspan(begin, end, color=BEYOND, linewidth=0, zorder=0)
    labelled = [axes for axes in drawn if any(axes.get_legend_handles_labels())]
    if labelled:
        labelled[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=2, frameon=False, fontsize=7.5,
                           borderaxespad=0.1, handlelength=2.2, columnspacing=1.4)


def draw_curves(axes: Any, strip: Curves, width: float) -> None:
    """Draw the lines of one strip. `width` is the width of the strip (inches)."""
    from matplotlib.ticker import MaxNLocator

    for time, value, look in strip.lines:
        axes.plot(time, value, **look)
    values = np.concatenate([*(value[np.isfinite(value)] for _, value, _ in strip.lines), [0.0] * strip.zero])
    low, high = (values.min(), values.max()) if len(values) else (0.0, 0.0)
    missing = max(strip.least - (high - low), 0.0)
    low, high = (low, high + missing) if strip.zero and low >= 0.0 else (low - missing / 2, high + missing / 2)
    low, high = low - 0.12 * (high - low), high + 0.12 * (high - low)
    axes.set_ylim(low, high)
    # the outermost numbers are left out: they would touch those of the next strip
    axes.yaxis.set_major_locator(MaxNLocator(int(strip.height / VALUES_APART), steps=(1, 2, 5, 10), prune="both"))
    if strip.zero:
        axes.axhline(0.0, color=FAINT, linewidth=0.6, zorder=1)
    axes.set_ylabel(strip.name, rotation=0, ha="right", va="center", multialignment="right", fontsize=7.5, color=INK)
    axes.yaxis.set_label_coords(-0.42 / width, 0.5)


def draw_lanes(axes: Any, rows: Sequence[Lane], timeline: Timeline, width: float) -> None:
    """Draw lanes from the top down, with their names at the left. `width` is the width of the axes (inches)."""
    for number, lane in enumerate(rows):
        middle = len(rows) - 0.5 - number
        look = dict(facecolor="white", hatch=lane.hatch) if lane.hatch else dict(facecolor=lane.colour)
        axes.broken_barh([(begin, end - begin) for begin, end in lane.spans], (middle - 0.3, 0.6),
                         edgecolor=lane.colour, linewidth=0.8, zorder=3, **look)
        badges = sorted(lane.badges)
        places = spread([time for time, _, _ in badges], BADGES_APART * timeline.span / width, timeline.begin,
                        timeline.end)
        for (_, words, colour), place in zip(badges, places):
            axes.text(place, middle, words, ha="center", va="center", color=ink_on(colour), fontsize=6.5,
                      fontweight="bold", zorder=5, bbox=dict(boxstyle="circle,pad=0.18", facecolor=colour,
                                                             edgecolor="white", linewidth=0.5))
        for time, words in lane.words:
            axes.text(time, middle, " " + plain(words), va="center", color=INK, fontsize=6.5, zorder=5)
        if number and lane.name:
            axes.axhline(middle + 0.5, color=BEYOND, linewidth=0.5, zorder=1)
    axes.set(ylim=(0, len(rows)), yticks=len(rows) - 0.5 - np.arange(len(rows)))
    axes.set_yticklabels([plain(lane.name) for lane in rows], fontsize=7.5, color=INK)


def draw_time(axes: Any, timeline: Timeline, most: int, name: Optional[str]) -> None:
    """Draw the frame of a strip, and its axis of time.

    Args:
        axes: the axes of the strip.
        timeline: the timeline of the axis.
        most: the largest number of steps on the axis.
        name: the name of the axis. None: no name and no times are written.
    """
    ticks = timeline.ticks(most)
    axes.set(xlim=(timeline.begin, timeline.begin + timeline.span), xticks=ticks,
             xticklabels=[timeline.number(tick) for tick in ticks] if name else [])
    draw_grid(axes, "x")
    axes.tick_params(axis="x", colors=INK, labelsize=7.5, length=2 if name else 0)
    axes.tick_params(axis="y", labelsize=7, length=0 if axes.get_ylabel() == "" else 2, color=FAINT)
    axes.set_xlabel(name or "", fontsize=7.5, color=INK, labelpad=1)

"""Draw the report of one run on one page: figures, the view from above, strips over time, and what went wrong."""

import os
from datetime import datetime, timezone
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ...errors import UsageError
from ...pictures import FAINT, INK, VERMILLION, draw_frame
from ..compare import pushes
from ..recorded_run import ERROR, EXPLORED, WARNING, Run
from ..recording.description import description_of
from . import from_above, over_time
from .incidents import Incident, incidents, silences
from .sheet import BODY, BOTTOM, HEIGHT, LEFT, RIGHT, SMALL, TOP, Sheet
from .timeline import Timeline, how_long

GAP, AXIS = 0.28, 0.36  # inches above the map for its scale bar; inches below the map and the strips for their axes
LINE, EVENT_LINE = 0.175, 0.22  # inches from one line of text to the next, without and with badges
LEAST_MAP, LARGEST_SCALE = 2.4, 2.5  # inches: the lowest map; inches on paper for each metre
BESIDE = 1.9  # inches: the width of a legend beside the map
# a map with a larger ratio of height to width has the strips beside it, and is at most WIDEST inches wide
NARROW, WIDEST = 1.6, 3.2
SIGNS, EVENTS_LISTED = 7, 8  # the largest numbers of signs and of events in a legend
OF_NAVIGATION = 7  # the largest number of signs that a robot has more if it navigates
MANY = -1  # stands for more events of the gripper than badges: they have signs in the legend, and no numbers
EVENTS_BESIDE = {7: 4, 2: 2, 1: 1}  # columns of events in a legend, by its columns of signs
FULL, FEWEST = 20, 4  # the largest number of lanes and lines of text together; lines of text that are always allowed
LINES = 3  # the largest number of lines of one text
WORDS = LEFT + 1.15  # inches: the left end of the text of a fault, behind its letter and time
REAL = 1e8  # s: a later time is a date. Simulated times are earlier
# how versions are written, by their names in the description of a recording
VERSIONS = {"pioneer_control": "pioneer_control %s", "rospy": "rospy %s", "python": "python %s",
            "commit": "commit %.10s", "system": "%s"}
EXACT = 0.01  # m: odometry with a smaller error at the end is called exact
ECHO_NOTE = ("* A sonar hears in a cone, and its echo is drawn in the cone's middle: a wall that is met slantwise also "
             "shows beside itself. %s places the echoes.")


class Plan(NamedTuple):
    """The places of the parts of a page: inches from its upper left corner."""

    height: float  # of the page
    map: Tuple[float, float, float, float]  # left, top, width, height
    legend: Tuple[float, float, int]  # left, top, columns
    strips: Tuple[float, float]  # left of their axes, top
    list: float  # top


def figure(run: Run, title: Optional[str] = None) -> Any:
    """Draw the report of a run, and return the matplotlib Figure.

    Args:
        run: the run.
        title: the title of the page. None: the names of the robot, the model and the world.
    """
    view, timeline, probe = from_above.view_of(run), timeline_of(run), Sheet(1.0)
    shown = over_time.curves(run)
    lanes = len(over_time.lanes(run, (), timeline))
    wrong, words = _listed(run, max(FULL - lanes, FEWEST), probe)
    lines = sum(map(len, words.values())) + (not all(each.letter for each in wrong))
    lanes += len({each.level for each in wrong})
    pushed = ", ".join("can %s pushed %.2f m at %s" % (push.can, push.distance, timeline.write(push.time))
                       for push in pushes(run))
    said: List[Tuple[str, Dict[str, Any]]] = [
        (", ".join(navigated(run)), dict(color=INK)),
        (pushed, dict(color=INK)),
        ("This recording is damaged: " + run.damage if run.damage else "", dict(color=VERMILLION, fontweight="bold")),
    ]
    head = [(line, look) for text, look in said for line in probe.lines(text, RIGHT - LEFT, LINES, **look) if text]

    events = min(len(run.gripper), EVENTS_LISTED) if len(run.gripper) <= from_above.BADGES else MANY
    signs = SIGNS + OF_NAVIGATION * (run.navigation is not None) + bool(run.looks)
    where = plan(view.high - view.low, TOP + 0.62 + LINE * len(head) + GAP, over_time.height(shown, lanes), lines,
                 events, signs)

    sheet = Sheet(where.height)
    _write_head(sheet, run, timeline, title, summary(run, view, wrong))
    for number, (line, look) in enumerate(head, 1):
        sheet.text(LEFT, TOP + 0.43 + LINE * number, line, **look)
    axes = sheet.axes(*where.map)
    from_above.draw(axes, view, timeline, where.map[2])
    draw_frame(axes, float(view.low[0]), float(view.high[0]))
    _write_legend(sheet, axes, run, timeline, *where.legend)
    over_time.draw(sheet, *where.strips, shown, over_time.lanes(run, wrong, timeline, RIGHT - where.strips[0]),
                   timeline)
    _write_wrong(sheet, where.list, wrong, words, timeline)
    echoes = ECHO_NOTE % ("Odometry" if run.navigation is None else "Navigation") if len(view.echoes) else ""
    for above, note in ((0.29, echoes), (0.16, recorded_with(run.notes))):
        sheet.text(LEFT, where.height - above, note, room=RIGHT - LEFT, size=6, color=FAINT)
    return sheet.figure


def _listed(run: Run, room: int, probe: Sheet) -> Tuple[Tuple[Incident, ...], Dict[str, List[str]]]:
    """Return what went wrong, and by letter the lines of its text.

    Args:
        run: the run.
        room: how many lines there may be. As many incidents get a letter as have room.
        probe: a sheet on which texts are measured.
    """
    for number in range(room, 0, -1):
        wrong = incidents(run, number)
        words = {each.letter: probe.lines(each.words, RIGHT - WORDS, LINES, SMALL) for each in wrong if each.letter}
        if sum(map(len, words.values())) <= room:
            break
    return wrong, words


def plan(span: np.ndarray, head: float, strips_high: float, lines: int, events: int, signs: int = SIGNS) -> Plan:
    """Lay out a page.

    Args:
        span: the width and the height of the view from above (m).
        head: the height of the head (inches).
        strips_high: the height of the strips (inches).
        lines: the number of lines of text below the strips.
        events: the number of events in the legend, or `MANY`.
        signs: the largest number of signs in the legend.
    """
    below = (strips_high + AXIS + 0.1) * bool(strips_high)
    listed = (lines * LINE + 0.12) * bool(lines)
    if span[1] > NARROW * span[0]:
        width, height = min(WIDEST / span[0], (HEIGHT - head - AXIS - listed - BOTTOM) / span[1], LARGEST_SCALE) * span
        left = LEFT + width + over_time.NAMES - 0.15
        end = max(head + height + AXIS, head + below + legend_height(events, 2, signs))
        return Plan(end + listed + BOTTOM, (LEFT, head, width, height), (left, head + below, 2), (left, head), end)
    room = HEIGHT - head - AXIS - below - listed - BOTTOM
    # inches for each metre of the map: with the legend beside it, and with the legend below it
    beside = min((RIGHT - LEFT - BESIDE) / span[0], max(room, LEAST_MAP) / span[1], LARGEST_SCALE)
    alone = min((RIGHT - LEFT) / span[0], (room - legend_height(events, 7, signs)) / span[1], LARGEST_SCALE)
    if beside >= alone and legend_height(events, 1, signs) <= max(room, LEAST_MAP) + AXIS:
        width, height = beside * span
        legend, top = (LEFT + width + 0.15, head, 1), max(head + height + AXIS, head + legend_height(events, 1, signs))
    else:
        width, height = alone * span
        legend, top = (LEFT, head + height + AXIS, 7), head + height + AXIS + legend_height(events, 7, signs)
    return Plan(top + below + listed + BOTTOM, (LEFT, head, width, height), legend, (over_time.NAMES, top + 0.1),
                top + below)


def legend_height(events: int, columns: int, signs: int = SIGNS) -> float:
    """Return the height (inches) of a legend with this number of events, or `MANY`, and of columns of signs."""
    signs += len(from_above.EVENT) * (events == MANY)
    return -(-signs // columns) * LINE + (0.06 + EVENT_LINE * -(-events // EVENTS_BESIDE[columns])) * (events > 0)


def timeline_of(run: Run) -> Timeline:
    """Return the timeline from the earliest to the latest time in the data of a run."""
    times = np.concatenate([
        run.odometry.time, run.commanded.time, run.measured.time, run.battery.time, run.sonar.time, run.motors.time,
        run.e_stop.time, [each.time for each in run.faults], [end for gap in run.gaps for end in (gap.begin, gap.end)]])
    return Timeline(float(times.min()), float(times.max()))


def _write_head(sheet: Sheet, run: Run, timeline: Timeline, title: Optional[str], figures: Sequence[str]) -> None:
    """Write the title, the name of the file, the date, and the figures."""
    model, world = (" (%s)" % run.model) * bool(run.model), (" in %s" % run.world) * bool(run.world)
    sheet.text(LEFT, TOP + 0.1, title or (run.robot or "robot") + model + world, room=RIGHT - LEFT - 2.4, size=15,
               fontweight="bold")
    sheet.text(RIGHT, TOP + 0.02, os.path.basename(run.path), room=2.3, size=SMALL, color=FAINT, ha="right")
    if timeline.begin > REAL:
        began = datetime.fromtimestamp(timeline.begin, timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
        sheet.text(RIGHT, TOP + 0.17, began, size=SMALL, color=FAINT, ha="right")
    sheet.text(LEFT, TOP + 0.43, "   ·   ".join(figures), room=RIGHT - LEFT, size=BODY)


def recorded_with(notes: str) -> str:
    """Return in words with which versions a run was recorded. Empty if `notes` is no description of a recording."""
    try:
        versions = description_of(notes).versions
    except UsageError:
        return ""
    known = [form % versions[name] for name, form in VERSIONS.items() if name in versions]
    return "recorded with " + ", ".join(known) if known else ""


def summary(run: Run, view: from_above.TopView, wrong: Sequence[Incident]) -> List[str]:
    """Return the figures of a run in words: its duration, its length, its error, and its errors, warnings and gaps."""
    off = np.hypot(view.odometry.x[-1] - view.path.x[-1], view.odometry.y[-1] - view.path.y[-1])
    odometry = "odometry exact: ideal wheels" if off < EXACT else "odometry %.0f cm off at the end" % (100 * off)
    way = (run.truth or run.odometry).length    # navigation may find itself elsewhere: that is no way
    errors, warnings = (sum(len(each.times) for each in wrong if each.level == level) for level in (ERROR, WARNING))
    counts = {"error%s": errors, "warning%s": warnings, "gap%s in the data": len(silences(run.gaps))}
    return [
        how_long(run.duration),
        ("%.1f m driven" if way < 100 else "%.0f m driven") % way,
        odometry if run.truth is not None else
        "as navigation has it" if run.navigation is not None else "as the robot's odometry has it",
        *["%s %s" % (count, what % ("s" * (count > 1))) for what, count in counts.items() if count],
    ]


def navigated(run: Run) -> List[str]:
    """Return in words how a robot navigated: its goals, how long it was not sure where it was, how far it was off while
    it was, and whose map it has. Empty for a robot that does not navigate.
    """
    said = run.navigation
    if said is None:
        return []
    off, turned = run.navigation_errors()
    unsure = sum(span.end - span.begin for span in said.unsure)
    sent = [goal.end for goal in said.goals if goal.end != EXPLORED]
    goals = ["explored"] if len(sent) < len(said.goals) else []
    if sent or not goals:
        goals.append("%d of %d goals reached" % (sent.count("reached"), len(sent)) if sent else "no goal")
    accuracy = "while sure %.0f cm and %.1f° off (95 %%: %.0f cm, %.1f°)" % (
        *(scale * np.percentile(values, share) for share in (50, 95) for scale, values in
          ((100.0, off), (np.degrees(1.0), turned))),) if len(off) else ""
    frame = (["on the map that it made"] if run.map_made else
             ["on a map with a frame of its own"] if run.own_frame else [])
    if frame and run.truth is not None:
        frame.append("the true path is laid on where it was first sure")
    return [words for words in (
        "Navigation: " + ", ".join(goals),
        "%s not sure where it was" % how_long(unsure) if unsure else "", accuracy,
        "; ".join(frame)) if words]


def _write_legend(sheet: Sheet, axes: Any, run: Run, timeline: Timeline, left: float, top: float, columns: int) -> None:
    """Write the signs of the view from above, and what the numbers of the gripper mean.

    Args:
        sheet: the sheet to write on.
        axes: the axes of the view from above.
        run: the run.
        timeline: the timeline of the run.
        left, top: the place of the upper left corner (inches).
        columns: the number of columns of signs.
    """
    shown = {label: handle for handle, label in zip(*axes.get_legend_handles_labels())
             if not label.startswith("robot at")}
    legend = sheet.figure.legend(
        shown.values(), shown.keys(), loc="upper left", bbox_to_anchor=sheet.at(left, top), borderaxespad=0,
        borderpad=0, ncol=columns, frameon=False, fontsize=SMALL, handlelength=1.8, columnspacing=1.2,
        handletextpad=0.5)
    for line in legend.get_lines():
        line.set_markersize(max(line.get_markersize(), 5))  # the dot of an echo is too small to be seen alone
    if len(run.gripper) > from_above.BADGES:
        return
    top += -(-len(shown) // columns) * LINE + 0.1
    for number, event in enumerate(run.gripper[:EVENTS_LISTED], 1):
        row, column = divmod(number - 1, EVENTS_BESIDE[columns])
        x, y = left + 0.1 + column * (RIGHT - left) / EVENTS_BESIDE[columns], top + row * EVENT_LINE
        _badge(sheet, x, y, str(number), from_above.EVENT[event.what])
        sheet.text(x + 0.16, y, "%s at %s" % (event.what, timeline.write(event.time)), size=SMALL)


def _badge(sheet: Sheet, left: float, middle: float, words: str, colour: str) -> None:
    """Draw a badge as in the drawings. Its explanation stands behind it."""
    sheet.text(left, middle, words, size=6.5, color=over_time.ink_on(colour), fontweight="bold", ha="center",
               bbox=dict(boxstyle="circle,pad=0.18", facecolor=colour, edgecolor="none"))


def _write_wrong(sheet: Sheet, top: float, wrong: Sequence[Incident], words: Dict[str, List[str]],
                 timeline: Timeline) -> None:
    """Write under the strips what the letters mean. `top` is in inches, `words` has the lines of text by letter."""
    row = top + LINE / 2
    for each in wrong:
        if each.letter:
            _badge(sheet, LEFT + 0.1, row, each.letter, over_time.SAID_COLOUR[each.level])
            time = timeline.write(each.times[0]) + (", %s×" % len(each.times) if len(each.times) > 1 else "")
            sheet.text(LEFT + 0.27, row, time, room=WORDS - LEFT - 0.3, size=SMALL, color=FAINT)
            for line in words[each.letter]:
                sheet.text(WORDS, row, line, room=RIGHT - WORDS, size=SMALL)
                row += LINE
    more = sum(len(each.times) for each in wrong if not each.letter)
    if more:
        sheet.text(LEFT + 0.27, row, "and %s more, without a letter" % more, size=SMALL, color=FAINT)

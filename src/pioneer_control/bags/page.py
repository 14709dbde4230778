"""The report of one run on one page, A4 wide: figures, the view from above, strips over time, and what went wrong."""

import os
from datetime import datetime, timezone
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from pioneer_control.bags import from_above, strips
from pioneer_control.bags.from_above import EVENT, View
from pioneer_control.bags.incidents import ERROR, WARNING, Incident, incidents, silences
from pioneer_control.bags.paper import BODY, BOTTOM, HEIGHT, LEFT, RIGHT, SMALL, TOP, Paper
from pioneer_control.bags.run import Run
from pioneer_control.bags.timeline import Timeline, how_long
from pioneer_control.pictures import FAINT, INK, ORANGE, VERMILLION, draw_frame

AXIS = 0.36  # inches below the map and below the strips for their axes
LINE = 0.175  # inches from one line of text to the next
LEAST_MAP, LARGEST_SCALE = 2.6, 2.5  # inches high; inches on paper for each metre
BESIDE = 1.9  # inches: a map that leaves so much has its legend beside it
EVENTS_LISTED = 8
MUCH, SQUEEZED = 12, 0.75  # lanes and lines of text from which on curves are lower, so that the map need not be; and how much lower
REAL = 1e8  # s: a clock beyond that is not that of a simulation


def figure(run: Run, title: Optional[str] = None):
    """The matplotlib Figure of a run."""
    view, timeline = from_above.view_of(run), timeline_of(run)
    wrong = incidents(run.faults)
    shown, rows = strips.curves(run), strips.lanes(run, wrong, timeline)
    listed = [each for each in wrong if each.letter]

    probe = Paper(1.0)
    damage = probe.lines(f"This recording is damaged: {run.damage}", RIGHT - LEFT, BODY) if run.damage else []
    head = 0.62 + LINE * len(damage)
    if len(rows) + len(listed) > MUCH:
        shown = [each._replace(height=SQUEEZED * each.height) for each in shown]
    below = (strips.height(shown, rows) + AXIS + 0.1) * bool(shown or rows) + (LINE * (len(listed) + 1 + (len(wrong) > len(listed)))) * bool(wrong)
    width, height, beside = _map_size(view, HEIGHT - TOP - head - 0.28 - AXIS - _legend_height(run) - below - BOTTOM)
    legend = 0.0 if beside else _legend_height(run)

    paper = Paper(TOP + head + 0.28 + height + AXIS + legend + below + BOTTOM)
    _write_head(paper, run, view, timeline, title, wrong, damage)
    top = TOP + head + 0.28
    axes = paper.axes(LEFT, top, width, height)
    from_above.draw(axes, view, timeline, width)
    draw_frame(axes, view.low[0], view.high[0])
    _write_legend(paper, axes, run, timeline, *((LEFT + width + 0.15, top, 1) if beside else (LEFT, top + height + AXIS, 6)))
    top += height + AXIS + legend
    if shown or rows:
        strips.draw(paper, top + 0.1, shown, rows, timeline)
        top += 0.1 + strips.height(shown, rows) + AXIS
    _write_wrong(paper, top, wrong, timeline)
    return paper.figure


def timeline_of(run: Run) -> Timeline:
    """From the first thing that is known of a run to the last."""
    times = [run.odometry.time, run.commanded.time, run.measured.time, run.battery.time, run.sonar.time]
    ends = [float(time[end]) for time in times if len(time) for end in (0, -1)]
    return Timeline(min(ends), max(ends))


def _map_size(view: View, room: float) -> Tuple[float, float, bool]:
    """Inches for the view from above, of which so many are free in height; whether there is room for its legend beside it."""
    span = view.high - view.low
    scale = min((RIGHT - LEFT) / span[0], max(room, LEAST_MAP) / span[1], LARGEST_SCALE)
    width, height = scale * span
    return width, height, width < RIGHT - LEFT - BESIDE


def _legend_height(run: Run) -> float:
    """Inches that the legend takes below the map."""
    return 0.2 + 0.24 * -(-min(len(run.gripper), EVENTS_LISTED) // 4)


def _write_head(paper: Paper, run: Run, view: View, timeline: Timeline, title: Optional[str], wrong: Sequence[Incident], damage: Sequence[str]) -> None:
    """Title, when and from which file, figures, and in red what is damaged."""
    robot = run.robot or "robot"
    named = title or robot + (f" ({run.model})" if run.model else "") + (f" in {run.world}" if run.world else "")
    paper.text(LEFT, TOP + 0.1, named, room=RIGHT - LEFT - 2.4, size=15, fontweight="bold")
    began = datetime.fromtimestamp(timeline.begin, timezone.utc).strftime("%Y-%m-%d %H:%M UTC") if timeline.begin > REAL else ""
    paper.text(RIGHT, TOP + 0.02, os.path.basename(run.path), room=2.3, size=SMALL, color=FAINT, ha="right")
    paper.text(RIGHT, TOP + 0.17, began, size=SMALL, color=FAINT, ha="right")
    paper.text(LEFT, TOP + 0.43, "   ·   ".join(summary(run, view, wrong)), room=RIGHT - LEFT, size=BODY)
    for number, line in enumerate(damage):
        paper.text(LEFT, TOP + 0.43 + LINE * (number + 1), line, size=BODY, color=VERMILLION, fontweight="bold")


def summary(run: Run, view: View, wrong: Sequence[Incident]) -> List[str]:
    """The figures of a run."""
    parts = [how_long(run.duration), f"{view.path.length:.1f} m driven"]
    if run.truth is not None:
        end = view.odometry.pose(-1)
        parts.append(f"odometry {100 * np.hypot(end[0] - view.path.x[-1], end[1] - view.path.y[-1]):.0f} cm off at the end")
    else:
        parts.append("as the robot's odometry has it")
    said = [(sum(len(each.times) for each in wrong if each.level == level), what) for level, what in ((ERROR, "error"), (WARNING, "warning"))]
    for count, what in said + [(len(silences(run.gaps)), "gap")]:
        parts += [f"{count} {what}{'s' * (count > 1)}" + " in the data" * (what == "gap")] if count else []
    return parts


def _write_legend(paper: Paper, axes, run: Run, timeline: Timeline, left: float, top: float, columns: int) -> None:
    """Signs of the view from above, and what the gripper's numbers mean."""
    shown = {label: handle for handle, label in zip(*axes.get_legend_handles_labels()) if not label.startswith("robot at")}
    legend = paper.figure.legend(
        shown.values(), shown.keys(), loc="upper left", bbox_to_anchor=paper.at(left, top), borderaxespad=0, borderpad=0, ncol=columns,
        frameon=False, fontsize=SMALL, handlelength=2.2, columnspacing=1.6, handletextpad=0.6,
    )  # fmt: skip
    for line in legend.get_lines():
        line.set_markersize(max(line.get_markersize(), 5))  # an echo's dot is too small to be seen alone
    top += 0.31 if columns > 1 else LINE * len(shown) + 0.12
    for number, event in enumerate(run.gripper[:EVENTS_LISTED], 1):
        row, column = divmod(number - 1, 4 if columns > 1 else 1)
        x, y = left + 0.1 + column * (RIGHT - LEFT) / 4, top + row * 0.24
        _badge(paper, x, y, str(number), EVENT[event.what])
        paper.text(x + 0.16, y, f"{event.what} at {timeline.write(event.time)}", size=SMALL)


def _badge(paper: Paper, left: float, middle: float, words: str, colour: str) -> None:
    """A sign as the drawings have it, beside its explanation."""
    badge = dict(boxstyle="circle,pad=0.18", facecolor=colour, edgecolor="none")
    paper.text(left, middle, words, size=6.5, color=INK if colour == ORANGE else "white", fontweight="bold", ha="center", bbox=badge)


def _write_wrong(paper: Paper, top: float, wrong: Sequence[Incident], timeline: Timeline) -> None:
    """Under the strips: what the letters mean."""
    for each in (each for each in wrong if each.letter):
        top += LINE
        _badge(paper, LEFT + 0.1, top, each.letter, strips.SAID_COLOUR[each.level])
        when = timeline.write(each.times[0]) + (f", {len(each.times)}×" if len(each.times) > 1 else "")
        paper.text(LEFT + 0.27, top, when, size=SMALL, color=FAINT)
        paper.text(strips.NAMES + 0.3, top, each.words, room=RIGHT - strips.NAMES - 0.3, size=SMALL)
    more = sum(len(each.times) for each in wrong if not each.letter)
    if more:
        paper.text(LEFT + 0.27, top + LINE, f"and {more} more, which have no letter", size=SMALL, color=FAINT)

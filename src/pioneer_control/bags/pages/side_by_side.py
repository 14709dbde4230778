"""Compare several runs on one page: their paths on one drawing, a table, and velocities and distances over time."""

import os
import re
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ...errors import UsageError
from ...pictures import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, SKY, VERMILLION, draw_frame
from ..command_line import stem
from ..compare import deviation, distance_between, driven, first_movement, from_its_start
from ..recorded_run import Map, Run, Track
from . import from_above, over_time
from .incidents import incidents
from .sheet import BOTTOM, HEIGHT, LEFT, MORE, RIGHT, SMALL, TOP, Sheet
from .timeline import Timeline, how_long

# Colour and line style of each run. The line of the first run is wide, and lies under the others.
LOOKS = (
    dict(color=BLUE, linewidth=3.2, alpha=0.55, linestyle="-"),
    dict(color=VERMILLION, linewidth=1.3, linestyle=(0, (5, 2))),
    dict(color=INK, linewidth=1.3, linestyle=(0, (1, 1.5))),
    dict(color=GREEN, linewidth=1.3, linestyle="-"),
    dict(color=PURPLE, linewidth=1.6, linestyle=(0, (7, 2, 1, 2))),
    dict(color=ORANGE, linewidth=1.6, linestyle=(0, (3, 1))),
    dict(color=SKY, linewidth=1.6, linestyle=(0, (4, 1, 1, 1, 1, 1))),
)
MOST = len(LOOKS)

AXIS, ROW = 0.36, 0.2  # inches
LARGEST_SCALE = 2.5  # inches on paper for each metre
FEWEST_METRES = 0.1  # m: the shortest axis of distances
LONGEST_NAME = 25  # letters of a name in the table
COLUMNS = ("time", "way", "mean speed", "stops", "faults", "farthest from first", "at the end")
ENDS = (3.35, 4.0, 4.8, 5.25, 5.7, 6.85, 7.92)  # inches from the left edge of the sheet to the right end of each column


class Compared(NamedTuple):
    """A run that is compared with others."""

    name: str
    run: Run
    track: Track  # the true path if the true paths of all runs are known, else the path of the odometry


def compared(runs: Sequence[Run]) -> Tuple[Compared, ...]:
    """Choose the name and the track of each run.

    Raises:
        UsageError: there are too many runs for a page.
    """
    check_number(len(runs))
    true = [run.truth for run in runs if run.truth is not None]
    tracks = true if len(true) == len(runs) else [run.odometry for run in runs]
    return tuple(map(Compared, shortened(names(runs)), runs, tracks))


def check_number(runs: int) -> None:
    """Raise UsageError if this number of runs is too large for a page."""
    if runs > MOST:
        raise UsageError("%s runs are too many to be told apart on one page; compare up to %s" % (runs, MOST))


def names(runs: Sequence[Run]) -> List[str]:
    """Return the names of the files without their ending. If two are equal, the robot or the folder is added."""
    files = [stem(os.path.basename(run.path)) for run in runs]
    if len(set(files)) == len(files):
        return files
    if len({(run.path, run.robot) for run in runs}) == len(runs) == len({run.robot for run in runs}):
        return [("%s %s" % (file, run.robot)).strip() for file, run in zip(files, runs)]
    return [os.path.join(os.path.basename(os.path.dirname(os.path.abspath(run.path))), file)
            for file, run in zip(files, runs)]


def shortened(long: Sequence[str]) -> List[str]:
    """Shorten names to at most `LONGEST_NAME` letters. Names that differ still differ afterwards."""
    if max(map(len, long)) <= LONGEST_NAME:
        return list(long)
    alike = os.path.commonprefix(list(long))
    words = [0, *(found.end() for found in re.finditer("[-_./ ]", alike))]  # where words begin
    begin = next((word for word in words if max(map(len, long)) - word < LONGEST_NAME), words[-1])
    rest = [MORE * (begin > 0) + name[begin:] for name in long]
    half = (LONGEST_NAME - 1) // 2
    short = [name if len(name) <= LONGEST_NAME else name[:LONGEST_NAME - 1 - half] + MORE + name[-half:]
             for name in rest]
    if len(set(short)) == len(set(long)):
        return short
    return ["%s: %s" % (number, name[3:]) for number, name in enumerate(short, 1)]


def figure(runs: Sequence[Run], title: Optional[str] = None) -> Any:
    """Draw a comparison of runs, and return the matplotlib Figure.

    Args:
        runs: the runs. All are compared with the first.
        title: the title of the page. None: a title made from the runs.

    Raises:
        UsageError: there are too many runs for a page.
    """
    rows = compared(runs)
    laid = [from_its_start(row.track).seen_from(rows[0].track.pose(0)) for row in rows]
    walls = (runs[0].map if all(run.truth is not None for run in runs) and len({run.world for run in runs}) == 1
             else None)
    low, high = from_above.extent(laid, np.empty((0, 2)), walls, max(run.reach for run in runs))
    shown = _curves(rows)

    head, table = 0.78, ROW * (len(rows) + 1) + 0.2
    below = table + over_time.height(shown, 0) + AXIS
    room = HEIGHT - TOP - head - AXIS - below - BOTTOM
    width, height = min((RIGHT - LEFT) / (high - low)[0], room / (high - low)[1], LARGEST_SCALE) * (high - low)

    sheet = Sheet(TOP + head + height + AXIS + below + BOTTOM)
    _write_head(sheet, rows, title)
    axes = sheet.axes(LEFT, TOP + head, width, height)
    _draw_paths(axes, laid, walls, low, high, width)
    draw_frame(axes, float(low[0]), float(high[0]))
    _write_table(sheet, TOP + head + height + AXIS + ROW / 2, rows)
    over_time.draw(sheet, over_time.NAMES, TOP + head + height + AXIS + table, shown, (),
                   Timeline(0.0, max(float(track.time[-1]) for track in laid)), "each began to move")
    return sheet.figure


def _curves(rows: Sequence[Compared]) -> List[over_time.Curves]:
    """Return the strips: velocities, and distances from the first run, over the time since each robot began to move."""
    measured = [over_time.measured(row.run) for row in rows]
    shifted = [(each._replace(time=each.time - first_movement(row.track)), look)
               for each, row, look in zip(measured, rows, LOOKS)]
    apart = tuple((*distance_between(rows[0].track, row.track), look) for row, look in zip(rows[1:], LOOKS[1:]))
    return [*over_time.velocities(shifted),
            over_time.Curves("from first\n(m)", over_time.CURVE, apart, FEWEST_METRES, True)]


def _write_head(sheet: Sheet, rows: Sequence[Compared], title: Optional[str]) -> None:
    """Write the title, and how the paths are compared."""
    models = [row.run.model for row in rows]
    same = " (%s)" % models[0] if len(set(models)) == 1 and models[0] else ""   # said once, behind the names
    own = ["" if same or not model else " (%s)" % model for model in models]
    robots = list(dict.fromkeys((row.run.robot or "robot") + model for row, model in zip(rows, own)))
    worlds = list(dict.fromkeys(row.run.world for row in rows if row.run.world))
    of = (robots[0] if len(robots) == 1 else "%s robots: %s" % (len(robots), ", ".join(robots))) + same
    if worlds:
        of += " in %s" % worlds[0] if len(worlds) == 1 else " in %s worlds: %s" % (len(worlds), ", ".join(worlds))
    sheet.text(LEFT, TOP + 0.1, title or "%s runs of %s" % (len(rows), of), room=RIGHT - LEFT, size=15,
               fontweight="bold")
    paths = "True paths" if rows[0].track is rows[0].run.truth else "Paths as the robots' odometry has them"
    sheet.text(LEFT, TOP + 0.39, paths + ", laid so that all begin together: at the same place, heading, and moment of "
               "the first movement", room=RIGHT - LEFT, size=SMALL)


def _draw_paths(axes: Any, laid: Sequence[Track], walls: Optional[Map], low: np.ndarray, high: np.ndarray,
                inches: float) -> None:
    """Draw all paths, with a mark at the end of each. `inches` is the width of the axes."""
    from_above.draw_map(axes, walls, low, high)
    for number, (track, look) in enumerate(zip(laid, LOOKS)):
        axes.plot(track.x, track.y, zorder=3, **look)
        axes.plot(*track.pose(-1)[:2], "s", color=look["color"], markersize=5.5 if number else 9,
                  markeredgecolor="white", markeredgewidth=0.8, zorder=6)
    axes.plot(*laid[0].pose(0)[:2], "o", color="white", markeredgecolor=INK, markersize=6, zorder=6)
    from_above.draw_arrows(axes, laid[0], (high - low)[0] / inches)


def _write_table(sheet: Sheet, top: float, rows: Sequence[Compared]) -> None:
    """Write the table: for each run its line as in the drawing, its name and its figures. `top` is in inches."""
    from matplotlib.lines import Line2D

    for name, end in zip(COLUMNS, ENDS):
        sheet.text(end, top, name, size=SMALL, color=FAINT, ha="right")
    for row, look in zip(rows, LOOKS):
        top += ROW
        (left, middle), (right, _) = sheet.at(LEFT, top), sheet.at(LEFT + 0.35, top)
        sheet.figure.add_artist(Line2D([left, right], [middle, middle], **look))
        sheet.text(LEFT + 0.45, top, row.name + " (damaged)" * bool(row.run.damage), room=ENDS[0] - LEFT - 1.1)
        for words, end in zip(figures(rows[0], row), ENDS):
            sheet.text(end, top, words, ha="right")


def figures(first: Compared, row: Compared) -> Tuple[str, ...]:
    """Return the texts in the table for a run, by `COLUMNS`. The first run is not compared with itself."""
    way, apart = driven(row.track), deviation(first.track, row.track)
    faults = sum(len(each.times) for each in incidents(row.run))
    own = how_long(way.time), "%.2f m" % way.length, "%.2f m/s" % way.mean_speed, str(way.stops), str(faults)
    at_end = "%s, %+d°" % (length(apart.at_end), round(np.degrees(apart.turn_at_end)))
    return own if row is first else (*own, length(apart.maximum), at_end.replace("-", "−"))


def length(metres: float) -> str:
    """Return a distance in words, in cm below one metre."""
    return "%.1f cm" % (100 * metres) if metres < 1.0 else "%.2f m" % metres

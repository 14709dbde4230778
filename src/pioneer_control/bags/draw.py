"""Draw a recorded run as one picture: where the robot went, what it heard, what it picked up.

``python3 -m pioneer_control.bags.draw RUN.bag`` writes RUN.png beside the bag; ``-o`` names another file (.pdf and .svg
work too). Colours are Okabe and Ito's, which stay apart for colour-blind eyes and in grey print.
"""

import argparse
import os
import sys
from typing import List, Optional, Sequence, Tuple

import numpy as np

from pioneer_control.bags.run import Map, Run, Track, placed, read_run
from pioneer_control.errors import PioneerError
from pioneer_control.pictures import BEYOND, FAINT, FLOOR, INK, WALL, draw_frame, write

TRUE_PATH, ODOMETRY, ECHO = "#0072b2", "#d55e00", "#56b4e9"
CAN_BEFORE, CAN_AFTER = "#000000", "#e69f00"
EVENT = {"picked up": "#009e73", "put down": "#cc79a7", "closed on nothing": "#767676"}

CAN_RADIUS = 0.033  # m
PADDLE_MIDDLE = 0.05  # m behind the tips: where the paddles grip
ARROW_EVERY = 0.7  # m of way between two arrows
LABEL_EVERY = 10.0  # s between two times written beside the path
LABEL_APART = 0.45  # m: no two of them nearer than this
MOST = 0.4  # share of a map: a run that saw more of it is drawn with the whole map
EVENTS_LISTED = 8
SHORT_SIDE, LONG_SIDE = 4.5, 11.0  # inches, of the drawing itself


def draw_run(run: Run, output: str, title: Optional[str] = None) -> None:
    """Write the picture of a run to a file; see `pictures.write`."""
    write(lambda: figure(run, title), output, dpi=160)


def figure(run: Run, title: Optional[str] = None):
    """The matplotlib Figure of a run, in the map's frame if the true path is known, else in the odometry's."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # here: it takes a second to load
    from matplotlib.figure import Figure

    odometry = run.odometry.seen_from(run.odometry_origin)
    path = odometry if run.truth is None else run.truth
    echoes = np.column_stack(placed(run.odometry_origin, *run.echoes().T))
    walls = run.map if run.truth is not None else None

    low, high = _extent(run, (odometry, path), echoes, walls)
    width, height = _size(high - low)
    page = Figure(figsize=(width + 0.9, height + 2.3), facecolor="white")
    FigureCanvasAgg(page)
    axes = page.add_axes([0.6 / (width + 0.9), 1.35 / (height + 2.3), width / (width + 0.9), height / (height + 2.3)])
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")

    if walls is not None:
        _draw_map(axes, walls)
    axes.plot(*echoes.T, ".", color=ECHO, markersize=2.5, alpha=0.6, zorder=2, label="sonar echo")
    _draw_tracks(axes, run, path, odometry)
    if run.truth is not None:
        _draw_cans(axes, run.cans)
    _draw_robot(axes, run.footprint, path.pose(0), "start", alpha=0.15)
    _draw_robot(axes, run.footprint, path.pose(-1), "end", alpha=0.45)
    _draw_gripper(axes, run, path)
    _draw_times(axes, path)
    draw_frame(axes, low[0], high[0])
    _write_texts(page, axes, run, path, title)
    return page


def _extent(run: Run, tracks: Sequence[Track], echoes: np.ndarray, walls: Optional[Map]) -> Tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of what is to be seen, m, with a margin: where the robot was and heard something.

    A map is shown whole, unless that would leave most of the page to where the robot never was.
    """
    reach = np.hypot(*run.footprint.T).max() if len(run.footprint) else 0.3
    points = [np.column_stack((track.x + side, track.y + side)) for track in tracks for side in (-reach, reach)]
    points = np.concatenate(points + [echoes])
    if walls is not None:
        row, column = np.nonzero(walls.cells >= 50)
        corners = [placed(walls.origin, (column + d) * walls.resolution, (row + d) * walls.resolution) for d in (0, 1)]
        everything = np.concatenate([points] + [np.column_stack(corner) for corner in corners])
        if np.ptp(points, axis=0).prod() > MOST * np.ptp(everything, axis=0).prod():
            points = everything
    margin = 0.02 * np.ptp(points, axis=0).max() + 0.05
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def _size(span: np.ndarray) -> np.ndarray:
    """Inches for a drawing of so many metres: its longer side fixed, its shorter one never too thin for the legend."""
    return np.maximum(LONG_SIDE * span / span.max(), SHORT_SIDE)


def _draw_map(axes, walls: Map) -> None:
    """Walls, posts and boxes, from the occupancy grid."""
    from matplotlib.colors import to_rgb
    from matplotlib.transforms import Affine2D

    shades = np.where(walls.cells[..., None] >= 50, to_rgb(WALL), np.where(walls.cells[..., None] < 0, to_rgb(BEYOND), to_rgb(FLOOR)))
    rows, columns = walls.cells.shape
    image = axes.imshow(
        shades, origin="lower", interpolation="nearest", zorder=0,
        extent=(0, columns * walls.resolution, 0, rows * walls.resolution),
    )  # fmt: skip
    x, y, turn = walls.origin
    limits = axes.get_xlim(), axes.get_ylim()
    image.set_transform(Affine2D().rotate(turn).translate(x, y) + axes.transData)
    axes.set(xlim=limits[0], ylim=limits[1])


def _draw_tracks(axes, run: Run, path: Track, odometry: Track) -> None:
    """The true path under the odometry's, with arrows that say which way."""
    from matplotlib.collections import PolyCollection

    if run.truth is not None:
        axes.plot(path.x, path.y, color=TRUE_PATH, linewidth=4.0, alpha=0.55, zorder=3, label="true path", solid_capstyle="round")
    axes.plot(odometry.x, odometry.y, color=ODOMETRY, linewidth=1.4, linestyle=(0, (5, 2)), zorder=4, label="odometry")
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(path.x), np.diff(path.y)))))
    marks = np.arange(ARROW_EVERY / 2, way[-1], ARROW_EVERY)
    at = path.at(np.interp(marks, way, path.time))
    ahead = path.at(at.time + 0.3)
    course = np.arctan2(ahead.y - at.y, ahead.x - at.x)  # the way it moves, which is not its heading when it backs off
    arrow = np.array([(0.07, 0.0), (-0.05, 0.06), (-0.02, 0.0), (-0.05, -0.06)])
    shapes = [np.column_stack(placed(pose, *arrow.T)) for pose in zip(at.x, at.y, course)]
    axes.add_collection(PolyCollection(shapes, facecolor=INK, edgecolor="white", linewidth=0.4, zorder=5))


def _draw_cans(axes, cans: Sequence[np.ndarray]) -> None:
    """Cans where they were first and last, and an arrow from one to the other for those that were moved."""
    from matplotlib.patches import Circle

    if not cans or not len(cans[0]):
        return
    before, after = cans[0], cans[-1]
    dots = dict(linestyle="none", marker="o")  # large enough to be found; in a large drawing the circles to scale are larger
    axes.plot(*before[:, :2].T, **dots, markersize=9, markerfacecolor="none", markeredgecolor=CAN_BEFORE, label="can before", zorder=6.6)
    axes.plot(*after[:, :2].T, **dots, markersize=6, color=CAN_AFTER, markeredgecolor=INK, markeredgewidth=0.5, label="can after", zorder=6)
    for x, y, _ in after:
        axes.add_patch(Circle((x, y), CAN_RADIUS, facecolor=CAN_AFTER, edgecolor=INK, linewidth=0.4, zorder=6))
    for (x, y, _), (to_x, to_y, _) in zip(before, after):
        if np.hypot(to_x - x, to_y - y) > 0.15:
            arrow = dict(arrowstyle="->", color=CAN_AFTER, linewidth=1.2, linestyle=":", shrinkA=6, shrinkB=5)
            axes.annotate("", (to_x, to_y), (x, y), arrowprops=arrow, zorder=5)


def _draw_robot(axes, footprint: np.ndarray, pose, name: str, alpha: float) -> None:
    """The outline of the robot, to scale, its heading, and a name."""
    from matplotlib.patches import Polygon

    if len(footprint):
        outline = np.column_stack(placed(pose, *footprint.T))
        axes.add_patch(Polygon(outline, facecolor=FAINT, alpha=alpha, edgecolor="none", zorder=2.5))
        axes.add_patch(Polygon(outline, facecolor="none", edgecolor=INK, linewidth=1.0, zorder=6, label=f"robot at {name}"))
    nose = np.array([(0.16, 0.0), (0.02, 0.08), (0.02, -0.08)])
    axes.add_patch(Polygon(np.column_stack(placed(pose, *nose.T)), facecolor=INK, edgecolor="white", linewidth=0.6, zorder=7))
    x, y = placed(pose, -0.16, 0.0)
    axes.text(x, y, name, ha="center", va="center", fontsize=8, color=INK, zorder=8, bbox=_PAPER)


_PAPER = dict(boxstyle="round,pad=0.15", facecolor="white", edgecolor="none", alpha=0.8)


def _draw_gripper(axes, run: Run, path: Track) -> None:
    """A numbered badge where the paddles did something; the list below the drawing says what."""
    tip = run.footprint[:, 0].max() if len(run.footprint) else 0.3
    taken: List[Tuple[float, float]] = []
    for number, event in enumerate(run.gripper, 1):
        robot = path.at(np.array([event.time])).pose(0)
        x, y = placed(robot, tip - PADDLE_MIDDLE, 0.0)
        near = sum(np.hypot(x - other_x, y - other_y) < 0.6 for other_x, other_y in taken)
        taken.append((x, y))
        angle = robot[2] + np.pi / 2 * (-1) ** near * (1 - 0.25 * (near // 2))  # left, right, left ahead, ... of the paddles
        axes.annotate(
            str(number), (x, y), (34 * np.cos(angle), 34 * np.sin(angle)), textcoords="offset points", ha="center", va="center",
            color="white", fontsize=9, fontweight="bold", zorder=10, annotation_clip=False,
            bbox=dict(boxstyle="circle,pad=0.25", facecolor=EVENT[event.what], edgecolor="white"),
            arrowprops=dict(arrowstyle="-", color=EVENT[event.what], linewidth=1.4, shrinkA=0, shrinkB=0),
        )  # fmt: skip


def _draw_times(axes, path: Track) -> None:
    """Seconds since the start, beside the path."""
    shown = [path.pose(0), path.pose(-1)]
    begin = path.time[0]
    for seconds in np.arange(LABEL_EVERY, path.time[-1] - begin, LABEL_EVERY):
        x, y, heading = path.at(np.array([begin + seconds])).pose(0)
        if any(np.hypot(x - other[0], y - other[1]) < LABEL_APART for other in shown):
            continue
        shown.append((x, y, heading))
        axes.plot(x, y, "o", color="white", markeredgecolor=INK, markersize=4, zorder=7)
        side = 9 * np.array([-np.sin(heading), np.cos(heading)])
        axes.annotate(
            f"{seconds:.0f} s", (x, y), side * (1.6, 1.0), textcoords="offset points", ha="center", va="center",
            fontsize=7.5, color=INK, zorder=8, bbox=_PAPER,
        )  # fmt: skip


def _write_texts(page, axes, run: Run, path: Track, title: Optional[str]) -> None:
    """Title above; legend and gripper events below."""
    width, height = page.get_size_inches()
    left = 0.6 / width
    robot = run.robot or "robot"
    named = title or robot + (f" ({run.model})" if run.model else "") + (f" in {run.world}" if run.world else "")
    page.text(left, 1 - 0.32 / height, named, fontsize=17, fontweight="bold", color=INK, va="center")
    page.text(left, 1 - 0.66 / height, _summary(run, path), fontsize=10.5, color=INK, va="center")
    shown = {label: handle for handle, label in zip(*axes.get_legend_handles_labels()) if not label.startswith("robot at")}
    legend = page.legend(
        shown.values(), shown.keys(), loc="upper left", bbox_to_anchor=(left, 0.92 / height), borderaxespad=0, ncol=6,
        frameon=False, fontsize=9, handlelength=2.2, columnspacing=1.8, handletextpad=0.6,
    )  # fmt: skip
    for line in legend.get_lines():
        line.set_markersize(max(line.get_markersize(), 6))  # an echo's dot is too small to be seen alone
    begin = run.odometry.time[0]
    for number, event in enumerate(run.gripper[:EVENTS_LISTED], 1):
        x, y = left + 0.1 / width + (number - 1) % 4 * 2.6 / width, (0.5 - (number - 1) // 4 * 0.24) / height
        badge = dict(boxstyle="circle,pad=0.2", facecolor=EVENT[event.what], edgecolor="none")
        page.text(x, y, str(number), color="white", fontsize=8, fontweight="bold", ha="center", va="center", bbox=badge)
        page.text(x + 0.16 / width, y, f"{event.what} at {event.time - begin:.0f} s", fontsize=9, color=INK, va="center")


def _summary(run: Run, path: Track) -> str:
    """The second line of the title."""
    parts = [f"{run.duration:.0f} s", f"{path.length:.1f} m driven"]
    if run.truth is not None:
        end = run.odometry.seen_from(run.odometry_origin).pose(-1)
        parts.append(f"odometry {100 * np.hypot(end[0] - path.x[-1], end[1] - path.y[-1]):.0f} cm off at the end")
    else:
        parts.append("as the robot's odometry has it")
    return "  ·  ".join(parts)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Draw a bag; 0 when the picture is written, 2 when there is nothing to draw."""
    parser = argparse.ArgumentParser(prog="draw", description="Draw the run of a robot that a bag holds, as one picture.")
    parser.add_argument("bag", help="what rosbag record wrote")
    parser.add_argument("-o", "--output", help="the picture to write: .png, .pdf or .svg (default: beside the bag, .png)")
    parser.add_argument("--robot", help="namespace of the robot, when the bag holds several")
    parser.add_argument("--title", help="instead of the robot's and the world's name")
    options = parser.parse_args(arguments)
    output = options.output or os.path.splitext(options.bag)[0] + ".png"
    try:
        draw_run(read_run(options.bag, options.robot), output, options.title)
    except (PioneerError, OSError, ImportError) as error:
        print(f"draw: {error}", file=sys.stderr)
        return 2
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

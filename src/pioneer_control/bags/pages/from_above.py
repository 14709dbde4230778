"""Draw a run from above: the path with headings and times, sonar echoes, the map, the cans, what a camera saw, and the
gripper's events.

Sizes in points and inches are sizes on the page. Sizes in m are drawn to scale.
"""

from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ...pictures import BEYOND, BLUE, FAINT, FLOOR, GREEN, INK, ORANGE, PURPLE, SKY, VERMILLION, WALL
from ..recorded_run import Map, Navigated, Pose, Run, Track, inverted, placed
from .timeline import Timeline

CAN_BEFORE, CAN_AFTER = "#000000", ORANGE
EVENT = {"picked up": GREEN, "put down": PURPLE, "closed on nothing": "#767676"}
MARKERS = {"picked up": "^", "put down": "v", "closed on nothing": "s"}
LABEL_BOX = dict(boxstyle="round,pad=0.12", facecolor="white", edgecolor="none", alpha=0.8)

CAN_RADIUS = 0.033  # m
CAN_MOVED = 0.05  # m: a can that moved farther is drawn with its path
NEAR_A_WALL = 0.12  # m: an echo that is farther from all walls is drawn as an echo beside its wall
LONGEST_NOSE = 0.16  # m: the greatest length of the triangle that shows a heading
MOST = 0.4  # share of the map: if the robot saw more, the whole map is drawn
FEWEST_METRES = 1.0  # m: the least width and height of the view, so that a robot that never moved does not fill it

ARROW, ARROW_EVERY = 0.1, 0.7  # inches: the length of an arrow, and the way between two arrows
STROKE = 0.11  # inches: the length of a stroke from a dot in the direction of the robot's heading
FAN, FAN_STEPS = 0.55, 9  # inches: the length of the fan that a camera sees; corners of its end
TIMES, TIMES_APART = 12, 0.36  # the largest number of times beside the path; inches between two of them
TICK = 0.05  # inches: the length of the stroke that shows a heading in a cloud
ENDED = {"reached": ("*", 9.0), "failed": ("X", 6.5)}  # of goals: sign and size; other goals are stars that are empty
NAMES_APART = 0.3  # inches: if start and end are nearer to each other, one name is written for both
BADGES = 24  # the largest number of badges on the drawing: more would hide it


class TopView(NamedTuple):
    """What is drawn of a run, in m.

    The frame is that of the map if the true path is known or the robot navigates, else that of the odometry.
    """

    run: Run
    path: Track  # the true path if it is known; else where navigation knew to be, or the path of the odometry
    odometry: Track
    echoes: np.ndarray  # (n, 2)
    walls: Optional[Map]
    low: np.ndarray  # (2,), the lower left corner of the view
    high: np.ndarray  # (2,), the upper right corner of the view


def view_of(run: Run) -> TopView:
    """Return what is to be drawn of a run."""
    odometry = run.odometry.seen_from(run.odometry_origin)
    truth, believed = run.truth_in_map, run.navigation.track if run.navigation else None
    path = truth or (run.navigation and run.navigation.sure_track) or odometry
    if believed is None:
        echoes = np.column_stack(placed(run.odometry_origin, *run.echoes().T))
    else:
        echoes = run.echoes(believed)
    walls = run.map if truth is not None or believed is not None else None
    # How far odometry strays is not worth the room where navigation corrects it.
    shown = (path,) if believed is not None else (odometry, path)
    return TopView(run, path, odometry, echoes, walls, *extent(shown, echoes, walls, run.reach))


def extent(tracks: Sequence[Track], echoes: np.ndarray, walls: Optional[Map],
           reach: float) -> Tuple[np.ndarray, np.ndarray]:
    """Return the lower left and the upper right corner (m) of a view of tracks and echoes, with a margin.

    The view has the whole map, unless most of the page would show places where no robot was.

    Args:
        tracks: the tracks of the robots.
        echoes: the points (n, 2) of their echoes (m).
        walls: the map. None: no map is drawn.
        reach: the largest distance from the middle of a robot to its outline (m).
    """
    points = np.concatenate([echoes, *(np.column_stack((track.x + side, track.y + side))
                                       for track in tracks for side in (-reach, reach))])
    if walls is not None:
        row, column = np.nonzero(walls.cells >= 50)
        corners = [placed(walls.origin, (column + d) * walls.resolution, (row + d) * walls.resolution) for d in (0, 1)]
        everything = np.concatenate([points] + [np.column_stack(corner) for corner in corners])
        if np.ptp(points, axis=0).prod() > MOST * np.ptp(everything, axis=0).prod():
            points = everything
    size = np.ptp(points, axis=0)
    margin = np.maximum(0.02 * size.max() + 0.05, (FEWEST_METRES - size) / 2)
    return points.min(axis=0) - margin, points.max(axis=0) + margin


def beside_things(view: TopView) -> np.ndarray:
    """Return for each echo whether it is far from all things on the map, as an array of bool (n,).

    Far means: more than `NEAR_A_WALL` from all walls, and more than twice as far from all cans. All are False if there
    is no map.
    """
    points = view.echoes
    if view.walls is None or not len(points):
        return np.zeros(len(points), dtype=bool)
    on_map = placed(inverted(view.walls.origin), *points.T)
    cells = np.floor(np.column_stack(on_map) / view.walls.resolution).astype(int)
    inside = ((cells >= 0) & (cells < view.walls.cells.shape[::-1])).all(axis=1)
    column, row = cells[inside].T
    reach = int(np.ceil(NEAR_A_WALL / view.walls.resolution))  # cells
    walls = np.pad(view.walls.cells >= 50, reach)
    beside = np.ones(len(points), dtype=bool)
    beside[inside] = ~np.any([walls[row + up, column + right] for up in range(2 * reach + 1)
                              for right in range(2 * reach + 1)], axis=0)
    for can in view.run.cans_in_map:
        for x, y in set(zip(np.round(can.x, 1), np.round(can.y, 1))):
            beside &= np.hypot(points[:, 0] - x, points[:, 1] - y) > 2 * NEAR_A_WALL
    return beside


def draw(axes: Any, view: TopView, timeline: Timeline, inches: float) -> None:
    """Draw a run. `inches` is the width of the axes."""
    scale = (view.high - view.low)[0] / inches  # m for each inch on the page
    draw_map(axes, view.walls, view.low, view.high)
    if view.run.truth is not None:
        axes.plot(view.path.x, view.path.y, color=BLUE, linewidth=3.4, alpha=0.55, zorder=3, label="true path",
                  solid_capstyle="round")
    axes.plot(view.odometry.x, view.odometry.y, color=VERMILLION, linewidth=1.2, zorder=4, label="odometry",
              linestyle="-" if view.path is view.odometry else (0, (5, 2)))
    if view.run.navigation is not None:
        _draw_navigation(axes, view.run.navigation, scale)
    draw_arrows(axes, view.path, scale)
    _draw_echoes(axes, view)
    if view.run.truth is not None:
        _draw_cans(axes, view)
    _draw_looks(axes, view, scale)
    _draw_robots(axes, view, scale)
    _draw_gripper(axes, view)
    _draw_times(axes, view.path, timeline, scale)


def draw_map(axes: Any, walls: Optional[Map], low: np.ndarray, high: np.ndarray) -> None:
    """Draw the map, and set the limits of the axes.

    Args:
        axes: the matplotlib axes to draw on.
        walls: the map. None: only the limits are set.
        low, high: the lower left and the upper right corner of the view (m).
    """
    from matplotlib.colors import to_rgb
    from matplotlib.transforms import Affine2D

    if walls is not None:
        cells = walls.cells[..., None]
        shades = np.where(cells >= 50, to_rgb(WALL), np.where(cells < 0, to_rgb(BEYOND), to_rgb(FLOOR)))
        rows, columns = walls.cells.shape
        image = axes.imshow(shades, origin="lower", interpolation="nearest", zorder=0,
                            extent=(0, columns * walls.resolution, 0, rows * walls.resolution))
        x, y, turn = walls.origin
        image.set_transform(Affine2D().rotate(turn).translate(x, y) + axes.transData)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")


def draw_arrows(axes: Any, path: Track, scale: float) -> None:
    """Draw arrows along a path. They point where the robot went, also when it went backwards.

    There is at most one arrow in each small square of the drawing.

    Args:
        axes: the matplotlib axes to draw on.
        path: the path.
        scale: how many m an inch on the page shows.
    """
    from matplotlib.collections import PolyCollection

    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(path.x), np.diff(path.y)))))
    marks = np.arange(ARROW_EVERY * scale / 2, way[-1], ARROW_EVERY * scale)
    behind, ahead = (path.at(np.interp(marks + d * ARROW * scale / 2, way, path.time)) for d in (-1, 1))
    course = np.arctan2(ahead.y - behind.y, ahead.x - behind.x)
    middle = (behind.x + ahead.x) / 2, (behind.y + ahead.y) / 2
    cells = np.floor(np.column_stack(middle) / (ARROW_EVERY * scale / 2))
    _, first = np.unique(cells, axis=0, return_index=True)  # one arrow in each square
    arrow = ARROW * scale * np.array([(0.6, 0.0), (-0.4, 0.5), (-0.15, 0.0), (-0.4, -0.5)])
    shapes = [np.column_stack(placed(pose, *arrow.T)) for pose in np.column_stack((*middle, course))[first]]
    axes.add_collection(PolyCollection(shapes, facecolor=INK, edgecolor="white", linewidth=0.4, zorder=5))


def _draw_navigation(axes: Any, said: Navigated, scale: float) -> None:
    """Draw where navigation believed to be, and where it was not sure, its plans and goals, and its cloud now and then.
    """
    sure = said.is_sure(said.track.time)
    line = np.where(sure, said.track.x, np.nan), np.where(sure, said.track.y, np.nan)
    axes.plot(*line, color=GREEN, linewidth=1.5, zorder=4.6, label="believed")
    if not sure.all():
        axes.plot(said.track.x[~sure], said.track.y[~sure], "x", color=INK, markersize=3.4, markeredgewidth=0.8,
                  zorder=4.7, label="not sure")
    for plan in said.plans:
        axes.plot(*plan.T, color=PURPLE, linewidth=1.0, linestyle=(0, (1, 1.2)), alpha=0.8, zorder=3.5, label="plan")
    for cloud in said.clouds:
        tips = cloud[:, :2] + TICK * scale * np.column_stack((np.cos(cloud[:, 2]), np.sin(cloud[:, 2])))
        strokes = np.stack((cloud[:, :2], tips, np.full_like(tips, np.nan)), axis=1).reshape(-1, 2)
        axes.plot(*strokes.T, color=ORANGE, linewidth=0.8, alpha=0.75, zorder=3.4, label="cloud")
    for goal in said.goals:
        sign, size = ENDED.get(goal.end, ("*", 9.0))
        axes.plot(goal.x, goal.y, sign, color=PURPLE if goal.end in ENDED else "white", markeredgecolor=INK,
                  markeredgewidth=0.6, markersize=size, zorder=8.5,
                  label="goal " + goal.end, linestyle="none")


def _draw_echoes(axes: Any, view: TopView) -> None:
    """Draw the echoes. Those beside their walls are paler."""
    beside = beside_things(view)
    for chosen, name, size, alpha in ((~beside, "sonar echo" if view.walls is not None else "sonar echo *", 2.0, 0.7),
                                      (beside, "echo beside its wall *", 1.3, 0.35)):
        if chosen.any():
            axes.plot(*view.echoes[chosen].T, ".", color=SKY, markersize=size, alpha=alpha, zorder=2, label=name,
                      rasterized=len(view.echoes) > 20000)


def _draw_cans(axes: Any, view: TopView) -> None:
    """Draw the cans at their first and last places, if any of them is in the view.

    A can that was moved is drawn with its path and its number.
    """
    from matplotlib.patches import Circle

    cans = view.run.cans_in_map
    before, after = (np.array([(can.x[end], can.y[end]) for can in cans]).reshape(-1, 2) for end in (0, -1))
    if not any(((view.low < place) & (place < view.high)).all() for place in (*before, *after)):
        return
    # these dots are large enough to be found; in a large drawing the circles to scale, below, are larger
    dots = dict(linestyle="none", marker="o")
    axes.plot(*before.T, **dots, markersize=7, markerfacecolor="none", markeredgecolor=CAN_BEFORE, label="can before",
              zorder=6.6)
    axes.plot(*after.T, **dots, markersize=4.5, color=CAN_AFTER, markeredgecolor=INK, markeredgewidth=0.5,
              label="can after", zorder=6)
    for number, (can, (x, y)) in enumerate(zip(cans, after), 1):
        axes.add_patch(Circle((x, y), CAN_RADIUS, facecolor=CAN_AFTER, edgecolor=INK, linewidth=0.4, zorder=6))
        if np.hypot(can.x - can.x[0], can.y - can.y[0]).max() > CAN_MOVED:
            axes.plot(can.x, can.y, ":", color=CAN_AFTER, linewidth=1.4, zorder=5.5, label="way of a can")
            axes.annotate("can %s" % number, (can.x[0], can.y[0]), (0, -9), textcoords="offset points", ha="center",
                          va="center", fontsize=6.5,
                          color=INK, zorder=8, bbox=LABEL_BOX)


def _draw_robots(axes: Any, view: TopView, scale: float) -> None:
    """Draw the robot to scale at the start and at the end. If they are near each other, both get one name."""
    start, end = view.path.pose(0), view.path.pose(-1)
    together = np.hypot(start[0] - end[0], start[1] - end[1]) < NAMES_APART * scale
    for pose, name, written, alpha in ((start, "start", "" if together else "start", 0.15),
                                       (end, "end", "start, end" if together else "end", 0.45)):
        if len(view.run.footprint):
            outline = placed(pose, *view.run.footprint.T)
            axes.fill(*outline, facecolor=FAINT, alpha=alpha, edgecolor="none", zorder=2.5)
            axes.fill(*outline, facecolor="none", edgecolor=INK, linewidth=1.0, zorder=6, label="robot at " + name)
        nose = min(LONGEST_NOSE, 0.15 * scale) * np.array([(1.0, 0.0), (0.1, 0.5), (0.1, -0.5)])
        axes.fill(*placed(pose, *nose.T), facecolor=INK, edgecolor="white", linewidth=0.6, zorder=7)
        if written:
            behind = -np.array([(9 + 2.2 * len(written)) * np.cos(pose[2]), 11 * np.sin(pose[2])])
            axes.annotate(written, pose[:2], behind, textcoords="offset points", ha="center", va="center", fontsize=7,
                          color=INK, zorder=8, bbox=LABEL_BOX)


def _draw_gripper(axes: Any, view: TopView) -> None:
    """Draw a badge with a number at each event of the gripper. If there are too many, draw signs without numbers."""
    events = view.run.gripper
    robot = view.path.at(np.array([event.time for event in events]))
    x, y = placed((robot.x, robot.y, robot.heading), view.run.grip, 0.0)
    if len(events) > BADGES:
        for what in sorted({event.what for event in events}):
            chosen = [number for number, event in enumerate(events) if event.what == what]
            axes.plot(x[chosen], y[chosen], MARKERS[what], color=EVENT[what], markeredgecolor="white",
                      markeredgewidth=0.4, markersize=5, zorder=9, label=what)
        return
    for number, event in enumerate(events):
        near = (np.hypot(x[:number] - x[number], y[:number] - y[number]) < 0.6).sum()
        # badges of events at one place lie to the left of the paddles, then to the right, then ahead on the left, ...
        angle = robot.heading[number] + np.pi / 2 * (-1) ** near * (1 - 0.25 * (near // 2))
        axes.annotate(
            str(number + 1), (x[number], y[number]), (26 * np.cos(angle), 26 * np.sin(angle)),
            textcoords="offset points", ha="center", va="center", color="white", fontsize=7, fontweight="bold",
            zorder=10, annotation_clip=False,
            bbox=dict(boxstyle="circle,pad=0.25", facecolor=EVENT[event.what], edgecolor="white"),
            arrowprops=dict(arrowstyle="-", color=EVENT[event.what], linewidth=1.2, shrinkA=0, shrinkB=0))


def _draw_looks(axes: Any, view: TopView, scale: float) -> None:
    """Draw what the camera saw, as a fan from where the robot was at the end of each look."""
    looks = view.run.looks
    robot = view.path.at(np.array([look.end for look in looks]))
    for look, pose in zip(looks, np.column_stack(robot[1:])):
        sides = look.bearing + np.linspace(-look.width / 2, look.width / 2, FAN_STEPS)
        fan = np.column_stack((np.cos(sides), np.sin(sides))) * FAN * scale
        x, y = placed(pose, *np.vstack(((0.0, 0.0), fan)).T)
        axes.fill(x, y, facecolor=PURPLE, alpha=0.16, edgecolor="none", zorder=2.6)
        axes.plot(np.append(x, x[0]), np.append(y, y[0]), color=PURPLE, linewidth=0.8, alpha=0.8, zorder=2.7,
                  label="camera's view")


def _draw_times(axes: Any, path: Track, timeline: Timeline, scale: float) -> None:
    """Write times beside the path, each with a dot at the place of the robot and a stroke that shows its heading."""
    shown: List[Pose] = [path.pose(0), path.pose(-1)]
    for time in timeline.ticks(TIMES)[1:]:
        x, y, heading = path.at(np.array([time])).pose(0)
        if time >= path.time[-1] or min(np.hypot(x - a, y - b) for a, b, _ in shown) < TIMES_APART * scale:
            continue
        shown.append((x, y, heading))
        ahead = placed((x, y, heading), STROKE * scale, 0.0)
        axes.plot([x, ahead[0]], [y, ahead[1]], color=INK, linewidth=1.6, solid_capstyle="butt", zorder=6.9)
        axes.plot(x, y, "o", color="white", markeredgecolor=INK, markersize=3.2, markeredgewidth=0.8, zorder=7)
        side = 8 * np.array([-np.sin(heading), np.cos(heading)])
        axes.annotate(timeline.write(time), (x, y), side * (1.6, 1.0), textcoords="offset points", ha="center",
                      va="center", fontsize=6.5, color=INK, zorder=8, bbox=LABEL_BOX)

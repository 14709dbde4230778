"""Draws a world as one picture: its walls, posts, cans, starts, docks, goals and places, and robots in it.

``python3 -m pioneer_control.simulator.picture WORLD`` writes world-WORLD.png. Option ``-o`` names another file, also
with ending .pdf or .svg. Options ``--model`` and ``--robots`` draw robots at their starts. No display is needed. The
colours are those of Okabe and Ito, as in `bags.draw`.
"""

import argparse
import math
import sys
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np

from ..errors import PioneerError
from ..maps import FREE, OCCUPIED
from ..pictures import BEYOND, FLOOR, INK, WALL, draw_frame, write
from ..robots import find_model
from .world import World, known_worlds, load_world, standing_places
from .world.geometry import Array
from .world.materials import Material
from .world.poses import Point, Pose

CAN, START, DOCK, GOAL, ROBOT = "#e69f00", "#009e73", "#0072b2", "#cc79a7", "#d55e00"
UNMAPPED = "#882255"  # obstacles that are on no map
SURFACES = {Material.PLAIN: WALL, Material.DARK: "#8c5a2b", Material.GLASS: "#56b4e9", Material.MIRROR: "#999999",
            Material.REFLECTOR: "#f0e442"}
LEAST_SPAN = 4.0  # m: width of the drawing of an empty world
WIDEST, HIGHEST, NARROWEST = 8.0, 5.5, 3.2  # inches: limits of the size of the drawing without its margins
CAN_DOT = 4.5  # points (1/72 inch): least diameter of a can in the drawing
DPI = 90
MANY_STARTS = 9  # with more starts, the drawing has no room for the word at each
CELLS = 900  # cells of the shading along the longer side of the drawing

Outline = Sequence[Point]
Standing = Tuple[Outline, Pose]


def draw_world(world: World, output: str, robots: Sequence[Standing] = (), title: Optional[str] = None) -> None:
    """Write the picture of a world to a file; see `pictures.write`.

    Args:
        world: the world.
        output: path of the file. Its ending decides the format.
        robots: outline (m, base_link) and pose (m, rad; map frame) of each robot to draw. If empty, starts are drawn.
        title: title of the picture, the name of the world if None.
    """
    write(lambda: figure(world, robots, title), output, DPI)


def figure(world: World, robots: Sequence[Standing] = (), title: Optional[str] = None) -> Any:
    """Return a matplotlib Figure of a world. For the arguments see `draw_world`."""
    from matplotlib.figure import Figure    # imported here, because it takes a second to load and may be missing

    low, high = _extent(world)
    width, height = np.maximum((high - low) * np.min((WIDEST, HIGHEST) / (high - low)), NARROWEST)
    page = Figure(figsize=(width + 0.8, height + 1.25), facecolor="white")
    axes = page.add_axes([0.55 / (width + 0.8), 0.6 / (height + 1.25), width / (width + 0.8), height / (height + 1.25)])
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    draw_floor(axes, world, (high - low).max() / CELLS)
    draw_solids(axes, world)
    draw_cans(axes, world)
    _draw_places(axes, world)
    _draw_goals(axes, world)
    _draw_docks(axes, world)
    if not robots:
        _draw_starts(axes, world)
    for outline, pose in robots:
        draw_robot(axes, outline, pose)
    _draw_ticks(axes, (high - low).max())
    draw_frame(axes, low[0], high[0])
    _write_texts(page, axes, world, title)
    return page


def _extent(world: World) -> Tuple[Array, Array]:
    """Return the lower left and the upper right corner of the drawing (m, map frame): the world with a margin."""
    low, high = np.array(world.bounds[:2]), np.array(world.bounds[2:])
    least = 0.0 if len(world.walls) else LEAST_SPAN
    margin = np.maximum(least - (high - low), 0.0) / 2.0 + 0.02 * (high - low).max() + 0.1
    return low - margin, high + margin


def draw_floor(axes: Any, world: World, resolution: float) -> None:
    """Shade the floor that cannot be reached from a start: outside the walls, and inside furniture.

    `resolution` is the side of a cell (m) of the shading.
    """
    from matplotlib.colors import ListedColormap

    resolution = max(resolution, 0.005)
    cells, (x, y) = world.occupancy(resolution, margin=0.5)
    rows, columns = cells.shape
    extent = (x, x + columns * resolution, y, y + rows * resolution)
    shades = np.where((cells == FREE) | (cells == OCCUPIED), 0, 1)
    axes.set_facecolor(BEYOND if shades[0].any() else FLOOR)  # in an open world, the floor goes on beyond the picture
    axes.imshow(shades, cmap=ListedColormap([FLOOR, BEYOND]), vmin=0, vmax=1, origin="lower", extent=extent,
                interpolation="nearest", zorder=0)


def draw_solids(axes: Any, world: World) -> None:
    """Draw the walls of a world as lines, and its posts to scale. What is on no map has another colour, and each
    material that a laser sees in another way, too.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    colours = [SURFACES[Material(material)] for material in world.materials]
    walls = list(zip(world.walls.tolist(), colours))
    walls += [(wall, UNMAPPED) for each in world.unmapped for wall in each.walls]
    if walls:
        axes.add_collection(LineCollection(
            [(wall[:2], wall[2:]) for wall, _ in walls], colors=[colour for _, colour in walls], linewidths=1.6,
            capstyle="round", zorder=3))
    posts = list(zip(world.posts.tolist(), colours[len(world.walls):]))
    for (x, y, radius), colour in posts + [(post, UNMAPPED) for each in world.unmapped for post in each.posts]:
        axes.add_patch(Circle((x, y), radius, facecolor=colour, edgecolor=colour, linewidth=1.2, zorder=3))
    for material in sorted(set(world.materials) - {Material.PLAIN}):
        axes.plot([], [], color=SURFACES[Material(material)], label=Material(material).name.lower())


def draw_cans(axes: Any, world: World) -> None:
    """Draw the cans of a world to scale, but not smaller than a visible dot."""
    from matplotlib.patches import Circle

    for number, can in enumerate(world.cans):
        dot = dict(color=CAN, markeredgecolor=INK, markeredgewidth=0.5, markersize=CAN_DOT, linestyle="none",
                   marker="o", zorder=4)
        axes.plot(can.x, can.y, **dot, label=None if number else "can")
        width = axes.get_position().width * axes.figure.get_figwidth()  # inches
        if 2.0 * can.radius > CAN_DOT / 72.0 * np.ptp(axes.get_xlim()) / width:
            axes.add_patch(Circle((can.x, can.y), can.radius, facecolor=CAN, edgecolor=INK, linewidth=0.5, zorder=4.1))


def _draw_arrow(axes: Any, pose: Pose, length: float, colour: str, zorder: float, **style: Any) -> None:
    """Draw an arrow head of `length` (m) whose middle is at `pose`, and which points along the heading of `pose`."""
    corners = (0.6, 0.0), (-0.4, 0.38), (-0.2, 0.0), (-0.4, -0.38)
    outline = [(length * x, length * y) for x, y in corners]
    axes.fill(*_placed(outline, pose).T, facecolor=colour, zorder=zorder, **style)


def _placed(outline: Outline, pose: Pose) -> Array:
    x, y, heading = pose
    points, cosine, sine = np.array(outline), math.cos(heading), math.sin(heading)
    return points @ ((cosine, sine), (-sine, cosine)) + (x, y)


def _size(axes: Any) -> float:
    """Return the length (m) of an arrow that is well visible in the drawing."""
    return float(0.045 * max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())))


_PAPER = dict(boxstyle="round,pad=0.12", facecolor="white", edgecolor="none", alpha=0.8)


def _label(axes: Any, pose: Pose, text: str, colour: str, points: float = 11.0) -> None:
    """Write a text below a pose, or above it if the arrow of the pose leads down. `points` is the distance (1/72 inch).
    """
    down = math.sin(pose[2]) < -0.3
    axes.annotate(text, pose[:2], (0, points if down else -points), textcoords="offset points", ha="center",
                  va="center", fontsize=8, color=colour,
                  zorder=7, bbox=_PAPER, annotation_clip=False)


def _draw_starts(axes: Any, world: World) -> None:
    """Draw the starts as arrows with their numbers. Many arrows are smaller, and the word "start" is left out."""
    many = len(world.starts) > MANY_STARTS
    text = "start" if len(world.starts) == 1 else "%s" if many else "start %s"
    for number, pose in enumerate(world.starts, 1):
        _draw_arrow(axes, pose, _size(axes) * (0.7 if many else 1.0), START, 6, edgecolor="white", linewidth=0.6)
        _label(axes, pose, text % number if "%" in text else text, START, 13.0 if many else 15.0)


def _draw_docks(axes: Any, world: World) -> None:
    """Draw each dock as a bracket in front of the robot that charges there. The bracket is open towards the robot."""
    for pose in world.docks:
        size = _size(axes)
        bracket = _placed(((-0.2 * size, 0.6 * size), (0.6 * size, 0.6 * size), (0.6 * size, -0.6 * size),
                           (-0.2 * size, -0.6 * size)), pose)
        axes.plot(*bracket.T, color=DOCK, linewidth=2.0, zorder=5, solid_joinstyle="miter")
        _draw_arrow(axes, pose, 0.7 * size, DOCK, 5, edgecolor="none")
        _label(axes, pose, "dock", DOCK, 23.0)


def _draw_places(axes: Any, world: World) -> None:
    """Draw the border of each place into which cans are brought, with its name."""
    from matplotlib.patches import Circle, Rectangle

    for place in world.places:
        middle, half = np.array((place.x, place.y)), np.array(place.size) / 2.0
        style = dict(facecolor=GOAL, edgecolor=GOAL, alpha=0.25, linewidth=1.2, linestyle="--", zorder=2)
        axes.add_patch(Circle(middle, half[0], **style) if len(half) == 1
                       else Rectangle(middle - half, *(2.0 * half), **style))
        axes.annotate(place.name, middle, ha="center", va="center", fontsize=8, color="#9c4f7c", zorder=3,
                      annotation_clip=False)


def _draw_goals(axes: Any, world: World) -> None:
    for name, pose in world.goals.items():
        axes.plot(*pose[:2], "o", markersize=13, color="none", markeredgecolor=GOAL, markeredgewidth=1.4, zorder=5)
        _draw_arrow(axes, pose, 0.6 * _size(axes), GOAL, 5, edgecolor="none")
        _label(axes, pose, name, "#9c4f7c", 14.0)


def draw_robot(axes: Any, outline: Outline, pose: Pose, colour: str = ROBOT) -> None:
    """Draw the outline of a robot (m, base_link) at `pose` (m, rad; map frame), with an arrow for its heading."""
    axes.fill(*_placed(outline, pose).T, facecolor=colour, edgecolor=colour, alpha=0.85, linewidth=0.8, zorder=6)
    _draw_arrow(axes, pose, 0.28, "white", 6, edgecolor="none")


def _draw_ticks(axes: Any, span: float) -> None:
    """Set the ticks of both axes a round number of metres apart, at most about a dozen over the longer side `span` (m).
    """
    from matplotlib.ticker import MultipleLocator

    step = min(step for step in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0) if step > span / 13.0 or step == 100.0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))


def _write_texts(page: Any, axes: Any, world: World, title: Optional[str]) -> None:
    """Write the title, and the size of the world and its numbers of walls, posts and cans, above the drawing."""
    width, height = page.get_size_inches()
    low_x, low_y, high_x, high_y = world.bounds
    solid = len(world.walls) or len(world.posts)
    size = "%.3g × %.3g m" % (high_x - low_x, high_y - low_y) if solid else "nothing, as far as anybody drives"
    counts = ((len(world.walls), "walls"), (len(world.posts), "posts"), (len(world.cans), "cans"))
    parts = [size, *("%s %s" % (count, what if count > 1 else what[:-1]) for count, what in counts if count)]
    page.text(0.55 / width, 1 - 0.22 / height, title or world.name, fontsize=15, fontweight="bold", color=INK,
              va="center")
    page.text(0.55 / width, 1 - 0.47 / height, "  ·  ".join(parts), fontsize=9.5, color=INK, va="center")
    if axes.get_legend_handles_labels()[0]:
        page.legend(loc="lower right", bbox_to_anchor=(1 - 0.2 / width, 0.0), frameon=False, fontsize=8.5, ncol=4,
                    handletextpad=0.2, columnspacing=1.2)


def main(arguments: Optional[List[str]] = None) -> int:
    """Run the command line, which draws a world.

    Returns:
        The exit code: 0 when the picture is written, 2 when an argument is not legal or the picture cannot be written.
    """
    parser = argparse.ArgumentParser(prog="python3 -m pioneer_control.simulator.picture",
                                     description="Draw a world of the simulated robot.",
                                     epilog="Worlds: %s." % ", ".join(known_worlds()))
    parser.add_argument("world", help="name of a world, or path of a world file (.yaml, .map)")
    parser.add_argument("-o", "--output", metavar="FILE", help="the picture (default: world-NAME.png)")
    parser.add_argument("--robots", type=int, metavar="N", default=0, help="draw so many robots where they start")
    parser.add_argument("--model", default="p3dx-sh", help="of these robots (default: %(default)s)")
    options = parser.parse_args(arguments)
    try:
        world, model = load_world(options.world), find_model(options.model)
        places = standing_places(world, model, options.robots) if options.robots else []
        output = options.output or "world-%s.png" % world.name    # not NAME.png, which may be the image of a map
        draw_world(world, output, [(model.outline(model.can_carry_gripper), pose) for pose in places])
    except PioneerError as error:
        print("picture: %s" % error, file=sys.stderr)
        return 2
    for skipped in world.skipped:
        print("skipped: %s" % skipped)
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Draws the URDF of all models on one sheet, each from above and from its right side: to look at, and for docs.

It draws what the URDF says, with all joints at 0, and the outline of the model around it. matplotlib is imported late.
"""

import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np

from ..pictures import FAINT, INK, VERMILLION, write
from ..robots import RobotModel
from .parts import Parts
from .urdf import describe

COLUMNS = 7
CELL = 2.2, 2.5     # inches
DPI = 100
SIDES = 16          # of the polygon that is drawn for a circle
BAR = 0.5           # m
FROM_ABOVE = 0.5    # opacity: the deck shows what is below it
EVERYTHING = "p3dx-sh"
"""The model that is drawn once more, with a camera and an arm."""

Frame = Tuple[Any, Any]
"""Rotation (3 x 3) and place (m) of a link in base_link."""


class Solid(NamedTuple):
    """A shape of a URDF: its link, its corners in base_link (m, one row each), and its colour."""

    link: str
    corners: Any
    colour: Tuple[float, ...]


def draw(models: Iterable[RobotModel], output: str) -> None:
    """Draw these models on one sheet, and write it to a file. Raises UsageError when it cannot be written."""
    write(lambda: _sheet(list(models)), output, DPI)


def solids(urdf: str) -> List[Solid]:
    """Return all shapes of a URDF, with all joints at 0."""
    root = ElementTree.fromstring(urdf)
    colours = {each.get("name"): _numbers(each.find("color"), "rgba") for each in root.findall("material")}
    frames = _frames(root)
    found = []
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            name = str(link.get("name"))
            rotation, place = _moved(frames[name], visual.find("origin"))
            material = visual.find("material")
            corners = _corners(visual) @ rotation.T + place
            found.append(Solid(name, corners, colours[None if material is None else material.get("name")]))
    return found


def _frames(root: ElementTree.Element) -> Dict[str, Frame]:
    """Return the frame of each link. Parents come before their children in our URDF."""
    frames: Dict[str, Frame] = {str(root.findall("link")[0].get("name")): (np.eye(3), np.zeros(3))}
    for joint in root.findall("joint"):
        parent, child = (str(_found(joint, each).get("link")) for each in ("parent", "child"))
        frames[child] = _moved(frames[parent], joint.find("origin"))
    return frames


def _found(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    found = element.find(tag)
    assert found is not None, "our URDF has one everywhere"
    return found


def _moved(frame: Frame, origin: Any) -> Frame:
    """Return the frame that an ``<origin>`` makes of a frame."""
    rotation, place = frame
    roll, pitch, yaw = _numbers(origin, "rpy") or (0.0, 0.0, 0.0)
    turned = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
    return rotation @ turned, place + rotation @ np.array(_numbers(origin, "xyz"))


def _about(axis: int, angle: float) -> Any:
    """Return the rotation by an angle (rad) about the x, y or z axis (0, 1, 2)."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.eye(3)
    rotation[first, first] = rotation[second, second] = math.cos(angle)
    rotation[second, first] = math.sin(angle)
    rotation[first, second] = -math.sin(angle)
    return rotation


def _numbers(element: Any, attribute: str) -> Tuple[float, ...]:
    return tuple(map(float, element.get(attribute, "").split()))


def _corners(visual: ElementTree.Element) -> Any:
    """Return the corners of a shape around its own middle (m): of a box, or of a prism for a cylinder."""
    shape = _found(visual, "geometry")[0]
    if shape.tag == "box":
        half = np.array(_numbers(shape, "size")) / 2.0
        return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    radius, half_length = float(shape.get("radius", "")), float(shape.get("length", "")) / 2.0
    angles = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    circle = np.column_stack([np.cos(angles), np.sin(angles)]) * radius
    return np.vstack([np.column_stack([circle, np.full(SIDES, z)]) for z in (-half_length, half_length)])


def _hull(points: Any) -> List[Tuple[float, float]]:
    """Return the convex hull of points in the plane, counter-clockwise."""
    ordered: List[Tuple[float, float]] = sorted((float(x), float(y)) for x, y in points)

    def chain(along: Iterable[Tuple[float, float]]) -> List[Tuple[float, float]]:
        kept: List[Tuple[float, float]] = []
        for x, y in along:
            while len(kept) > 1 and (kept[-1][0] - kept[-2][0]) * (y - kept[-2][1]) <= (
                    (kept[-1][1] - kept[-2][1]) * (x - kept[-2][0])):
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return chain(ordered) + chain(reversed(ordered))


def _cells(models: Sequence[RobotModel]) -> Iterator[Tuple[str, RobotModel, Parts]]:
    """Yield what to draw: each model with gripper and laser, where it has them, and one with everything."""
    for model in models:
        yield model.subtype, model, Parts(gripper=model.can_carry_gripper, laser=model.laser is not None)
        if model.subtype == EVERYTHING:
            yield "%s, camera, arm" % EVERYTHING, model, Parts(True, True, True, True)


def _sheet(models: Sequence[RobotModel]) -> Any:
    from matplotlib.figure import Figure    # imported here, because it takes a second to load and may be missing

    cells = list(_cells(models))
    rows = math.ceil(len(cells) / COLUMNS)
    page = Figure(figsize=(COLUMNS * CELL[0], rows * CELL[1]), facecolor="white")
    for number, (title, model, parts) in enumerate(cells):
        axes = page.add_subplot(rows, COLUMNS, number + 1)
        _draw_cell(axes, title, model, solids(describe(model, parts)), parts.gripper)
    page.subplots_adjust(0.005, 0.005, 0.995, 0.98, 0.02, 0.1)
    return page


def _draw_cell(axes: Any, title: str, model: RobotModel, shapes: Sequence[Solid], gripper: bool) -> None:
    """Draw one robot: from above, with its outline, and below that from its right side, on the floor."""
    floor = -model.width / 2 - 0.1 - max(shape.corners[:, 2].max() for shape in shapes)
    for shape in sorted(shapes, key=lambda each: float(each.corners[:, 2].max())):
        _draw_polygon(axes, _hull(shape.corners[:, :2]), shape.colour, FROM_ABOVE)
    for shape in sorted(shapes, key=lambda each: -float(each.corners[:, 1].min())):
        _draw_polygon(axes, _hull(shape.corners[:, (0, 2)] + (0.0, floor)), shape.colour)
    outline = model.outline(gripper)
    axes.plot(*zip(*outline, outline[0]), color=VERMILLION, linewidth=0.8, linestyle="--")
    right = model.length_front + 0.15
    axes.plot([-model.length_rear - 0.1, right], [floor, floor], color=FAINT, linewidth=0.6)
    axes.plot([right - BAR, right], [floor - 0.05] * 2, color=INK, linewidth=1.5, solid_capstyle="butt")
    axes.set_title(title, fontsize=7, color=INK, pad=2)
    axes.set_aspect("equal")
    axes.axis("off")


def _draw_polygon(axes: Any, corners: Sequence[Tuple[float, float]], colour: Tuple[float, ...],
                  alpha: float = 1.0) -> None:
    axes.fill(*zip(*corners), facecolor=colour, edgecolor=FAINT, linewidth=0.3, alpha=alpha)

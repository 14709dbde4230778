"""Writes the elements of a URDF. Lengths are in m, angles in rad; x forward, y left, z up.

Source: the URDF specification of ROS (wiki.ros.org/urdf/XML).
"""

import math
import xml.etree.ElementTree as ElementTree
from typing import Any, Iterable, NamedTuple, Optional, Tuple

Triple = Tuple[float, float, float]
LYING = (math.pi / 2, 0.0, 0.0)
"""The angles of a cylinder that lies: its axis is along y, as that of a wheel."""
COLOURS = {
    "red": "0.70 0.07 0.09 1",
    "black": "0.13 0.13 0.14 1",
    "grey": "0.55 0.56 0.58 1",
    "gold": "0.85 0.66 0.20 1",
    "blue": "0.20 0.30 0.55 1",
}


class Box(NamedTuple):
    """A box between two corners (the lower x, y, z, and the higher)."""

    low: Triple
    high: Triple
    colour: str


class Cylinder(NamedTuple):
    """A cylinder: its middle, radius, length, and the angles (roll, pitch, yaw) by which its axis is turned from z."""

    middle: Triple
    radius: float
    length: float
    colour: str
    angles: Triple = (0.0, 0.0, 0.0)


class LinkJoint(NamedTuple):
    """How a link hangs on its parent: where, how it is turned there (yaw), and how it moves.

    ``kind`` is fixed, continuous, revolute or prismatic. ``limits`` are the ends of its way (rad or m). ``mimic`` is
    the joint that it moves with.
    """

    name: str
    parent: str
    at: Triple
    yaw: float = 0.0
    kind: str = "fixed"
    axis: Triple = (0.0, 0.0, 1.0)
    limits: Optional[Tuple[float, float]] = None
    mimic: str = ""


class Urdf:
    """A URDF that grows link by link.

    Args:
        name: the name of the robot.
        prefix: what to put before the name of every link, for several robots in one graph. Joints have no prefix.
    """

    def __init__(self, name: str, prefix: str) -> None:
        self._root = ElementTree.Element("robot", name=name)
        self._prefix = prefix
        for colour, rgba in COLOURS.items():
            ElementTree.SubElement(_sub(self._root, "material", name=colour), "color", rgba=rgba)

    def link(self, name: str, visuals: Iterable[Any] = (), joint: Optional[LinkJoint] = None,
             collision: Optional[Box] = None) -> None:
        """Add a link, and its joint to the parent. The first link has no joint: the robot's frame."""
        link = _sub(self._root, "link", name=self._prefix + name)
        for shape in visuals:
            visual = _sub(link, "visual")
            _add_shape(visual, shape)
            _sub(visual, "material", name=shape.colour)
        if collision is not None:
            _add_shape(_sub(link, "collision"), collision)
        if joint is not None:
            self._join(name, joint)

    def _join(self, child: str, joint: LinkJoint) -> None:
        element = _sub(self._root, "joint", name=joint.name, type=joint.kind)
        _sub(element, "parent", link=self._prefix + joint.parent)
        _sub(element, "child", link=self._prefix + child)
        _sub(element, "origin", xyz=_text(joint.at), rpy=_text((0.0, 0.0, joint.yaw)))
        if joint.kind != "fixed":
            _sub(element, "axis", xyz=_text(joint.axis))
        if joint.limits is not None:
            low, high = joint.limits
            _sub(element, "limit", lower="%.4f" % low, upper="%.4f" % high, effort="10", velocity="2")
        if joint.mimic:
            _sub(element, "mimic", joint=joint.mimic)

    def text(self) -> str:
        """Return the URDF as a text."""
        _indent(self._root, "\n")
        return '<?xml version="1.0"?>\n%s\n' % ElementTree.tostring(self._root, encoding="unicode")


def _add_shape(parent: ElementTree.Element, shape: Any) -> None:
    if isinstance(shape, Box):
        middle = [(low + high) / 2 for low, high in zip(shape.low, shape.high)]
        _sub(parent, "origin", xyz=_text(middle))
        size = [high - low for low, high in zip(shape.low, shape.high)]
        _sub(_sub(parent, "geometry"), "box", size=_text(size))
    else:
        _sub(parent, "origin", xyz=_text(shape.middle), rpy=_text(shape.angles))
        _sub(_sub(parent, "geometry"), "cylinder", radius="%.4f" % shape.radius, length="%.4f" % shape.length)


def _sub(parent: ElementTree.Element, tag: str, /, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)


def _text(numbers: Iterable[float]) -> str:
    return " ".join("%.4f" % (number + 0.0) for number in numbers)     # + 0.0: no -0


def _indent(element: ElementTree.Element, line: str) -> None:
    """Begin a new line for each child of an element, further to the right than ``line``."""
    if len(element):
        element.text = line + "  "
        for child in element:
            _indent(child, line + "  ")
            child.tail = line + "  "
        element[-1].tail = line

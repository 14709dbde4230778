"""Makes the URDF of a robot from its model: body, wheels, castors, bumpers, sonar, and the parts that it carries.

``base_link`` is on the floor, between the wheels, x forward (REP 105). Length and width are the outline of the model,
and every transducer is where the driver's tf has it; heights, wheels and castors are by eye (`BodyShape`).
"""

import math
from typing import Iterable, Iterator, List, Tuple

from ..errors import UsageError
from ..robots import ARRAY_SIZE, SONAR_HEIGHT, RobotModel, Transducer
from .elements import LYING, Box, Cylinder, LinkJoint, Urdf
from .parts import Parts, add_arm, add_camera, add_gripper, add_laser

WHEEL_GAP, DECK_INSET = 0.005, 0.015
"""Distances (m), by eye: between hull and wheel; from the outside of a wheel to the edge of the deck above it."""
BUMPER_DEPTH, BUMPER_HEIGHT = 0.02, 0.05
RING_INSET, CORE_INSET = 0.004, 0.04
"""Distances (m), by eye: how far the discs stand out of their ring, and hull and deck out of what joins them."""
DISC_RADIUS, DISC_LENGTH = 0.018, 0.008
COLUMN_WIDTH = 0.2          # m, of a tower


def describe(model: RobotModel, parts: Parts = Parts(), prefix: str = "") -> str:
    """Return the URDF of a robot.

    Args:
        model: the robot, with the sonar arrays that it has.
        parts: what it carries.
        prefix: what to put before the name of every link: the driver's ``frame_prefix``.

    Raises:
        UsageError: the model cannot carry such a part, or where it sits is not known.
    """
    laser = model.laser
    if parts.gripper and not model.can_carry_gripper:
        raise UsageError("the model %s cannot carry a gripper" % model.subtype)
    if parts.laser and laser is None:
        raise UsageError("where the laser of the model %s sits is not known: give the key laser in a models file"
                         % model.subtype)
    urdf = Urdf(model.subtype, prefix)
    front, rear, side = model.length_front, -model.length_rear, model.width / 2
    urdf.link("base_link", _body(model), collision=Box(
        (rear, -side, model.shape.clearance), (front, side, model.shape.height), "red"))
    _add_wheels(urdf, model)
    _add_sonar(urdf, model)
    if parts.gripper:
        add_gripper(urdf, model)
    if parts.laser and laser is not None:
        add_laser(urdf, model, laser)
    if parts.ptz:
        add_camera(urdf, model, parts.laser)
    if parts.arm:
        add_arm(urdf, model)
    return urdf.text()


def _body(model: RobotModel) -> List[object]:
    """Return hull, ring, core, deck, bumpers, castors and tower: what belongs to ``base_link``."""
    shape = model.shape
    front, rear, side = model.length_front, -model.length_rear, model.width / 2
    hull = side if shape.wheels_inside else side - shape.wheel_width - WHEEL_GAP
    deck = side if shape.wheels_inside else side - DECK_INSET
    ring_low, ring_high = shape.ring
    lower, upper = _rings(model)
    body: List[object] = [
        Box((rear + shape.overhang, -hull, shape.clearance),
            (front - shape.overhang, hull, ring_low if lower else ring_high), "red"),
        Box((rear, -deck, ring_high), (front, deck, shape.height), "black"),
    ]
    body += _ring(model, lower, ring_low, ring_high)
    if lower:
        inset = shape.overhang + CORE_INSET
        half = min(hull, max(abs(transducer.y) for transducer in lower)) - CORE_INSET / 2
        body.append(Box((rear + inset, -half, ring_low), (front - inset, half, ring_high), "black"))
    low, high = shape.clearance, shape.clearance + BUMPER_HEIGHT
    if model.front_bumpers:
        body.append(Box((front - BUMPER_DEPTH, -hull, low), (front, hull, high), "black"))
    if model.rear_bumpers:
        body.append(Box((rear, -hull, low), (rear + BUMPER_DEPTH, hull, high), "black"))
    radius = shape.castor_radius
    body += [Cylinder((x, 0.0, radius), radius, 0.5 * radius, "black", LYING) for x in shape.castors]
    if shape.tower:
        body += _tower(model, upper, shape.height, shape.tower)
    return body


def _tower(model: RobotModel, ring: List[Transducer], bottom: float, top: float) -> Iterator[object]:
    """Yield the column, the ring and the upper deck of a tower."""
    half, west = COLUMN_WIDTH / 2, -model.length_rear + 0.03
    east, low, high = west + COLUMN_WIDTH, top - 0.1, top - 0.02
    yield Box((west, -half, bottom), (east, half, high), "red")
    yield from _ring(model, ring, low, high)
    ends = [west, east] + [transducer.x for transducer in ring]
    yield Box((max(min(ends), -model.length_rear), -half * 1.4, high),
              (min(max(ends), model.length_front), half * 1.4, top), "black")


def _rings(model: RobotModel) -> Tuple[List[Transducer], List[Transducer]]:
    """Return the transducers between hull and deck, and those in the tower."""
    rings: Tuple[List[Transducer], List[Transducer]] = ([], [])
    for transducer in model.sonar:
        rings[_is_upper(model, transducer)].append(transducer)
    return rings


def _is_upper(model: RobotModel, transducer: Transducer) -> bool:
    return transducer.number // ARRAY_SIZE in model.shape.upper_arrays


def _ring(model: RobotModel, transducers: Iterable[Transducer], low: float, high: float) -> List[Box]:
    """Return the black box that transducers sit on, within the outline; nothing without any."""
    places = [(transducer.x, transducer.y) for transducer in transducers]
    if not places:
        return []
    xs, ys = zip(*places)
    side = model.width / 2
    return [Box((max(min(xs) + RING_INSET, -model.length_rear), max(min(ys) + RING_INSET, -side), low),
                (min(max(xs) - RING_INSET, model.length_front), min(max(ys) - RING_INSET, side), high), "black")]


def _add_wheels(urdf: Urdf, model: RobotModel) -> None:
    """Add two wheels for each axle. They turn where the driver's joint_states say so: where their radius is known.

    The joints of the first axle have the names that joint_states have. Those of further axles go with them, as the
    belts of a robot with four wheels make them.
    """
    shape = model.shape
    radius, width = model.wheel_radius or shape.wheel_radius, shape.wheel_width
    inset = 2 * WHEEL_GAP if shape.wheels_inside else 0.0
    turns = "continuous" if model.wheel_radius else "fixed"
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for axle, x in enumerate(shape.axles):
            name = "%s_%swheel" % (side, "rear_" if axle else "")
            urdf.link(name, [
                Cylinder((0.0, 0.0, 0.0), radius, width - 0.004, "black", LYING),
                Cylinder((0.0, 0.0, 0.0), radius * 0.45, width, "grey", LYING),
            ], LinkJoint(name + "_joint", "base_link", (x, sign * (model.width / 2 - width / 2 - inset), radius),
                         kind=turns, axis=(0.0, 1.0, 0.0),
                         mimic="%s_wheel_joint" % side if axle and model.wheel_radius else ""))


def _add_sonar(urdf: Urdf, model: RobotModel) -> None:
    """Add a link for each transducer, named and placed as the driver's frame of it: x is the axis of its cone.

    It is drawn in its ring, which may be higher or lower than that frame: the frames of all models are equally high.
    """
    for transducer in model.sonar:
        top = model.shape.tower
        z = top - 0.06 if _is_upper(model, transducer) else sum(model.shape.ring) / 2
        name = "sonar_%d" % transducer.number
        disc = Cylinder((0.0, 0.0, z - SONAR_HEIGHT), DISC_RADIUS, DISC_LENGTH, "gold", (0.0, math.pi / 2, 0.0))
        urdf.link(name, [disc], LinkJoint(
            name + "_joint", "base_link", (transducer.x, transducer.y, SONAR_HEIGHT), transducer.heading))

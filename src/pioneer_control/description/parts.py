"""The parts that a robot may carry, as links of its URDF: gripper, laser, camera and arm.

Where a part is not fitted at a place that the table of models knows, the place is by eye: on the deck.
"""

import math
from typing import NamedTuple

from ..robots import LaserPlace, RobotModel
from .elements import LYING, Box, Cylinder, LinkJoint, Triple, Urdf

PADDLE_HEIGHT = 0.04
"""Height (m) of the paddles above the floor, with the lift down: by eye."""
LASER_SIZE, LASER_ABOVE = 0.155, 0.115
"""Side (m) of the housing of an LMS-200, and how high its mirror is above the deck that it stands on: by eye."""
CAMERA_ON_LASER = 0.21      # m: a camera stands on a laser, where there is one
PAN_LIMITS = math.radians(-98), math.radians(98)
TILT_LIMITS = math.radians(-88), math.radians(30)
"""Limits of the joints of the camera (rad): pan left positive; tilt down positive (camera sheet 4, Limits)."""
CAMERA_HEIGHT = 0.07
"""Height (m) of the tilt axis above `ptz_base_link`: by eye."""
ARM_X, SHOULDER_ABOVE = 0.105, 0.0815
"""Where the base axis of an arm is (m), and its shoulder above the deck: 0.3185 m above the floor on a Pioneer 2."""
BASE_TO_SHOULDER, UPPER_ARM, FOREARM, WRIST_TO_GRIPPER = 0.06875, 0.16, 0.13775, 0.11321
"""Lengths (m) of the arm (arm sheet 16)."""
GRIPPER_OPENING, GRIPPER_WIDTH, GRIPPER_HEIGHT = 0.054, 0.09, 0.041
JOINT_LIMITS = -math.pi / 2, math.pi / 2
ARM_THICKNESS = 0.04        # m, by eye


class Parts(NamedTuple):
    """Which parts a robot carries. What it has as its model (sonar, bumpers) is not among them."""

    gripper: bool = False
    laser: bool = False
    ptz: bool = False
    arm: bool = False


def add_gripper(urdf: Urdf, model: RobotModel) -> None:
    """Add the link ``gripper``, drawn open with the lift down. Its frame is at the front of the body."""
    shape, side = model.gripper, model.gripper.opening / 2
    palm, tip = shape.paddle_start, shape.reach
    outer = side + shape.paddle_thickness
    low, high = PADDLE_HEIGHT - 0.02, PADDLE_HEIGHT + 0.02
    urdf.link("gripper", [
        Box((-model.shape.overhang, -outer, low), (palm, outer, high + 0.05), "grey"),
        Box((palm, side, low), (tip, outer, high), "black"),
        Box((palm, -outer, low), (tip, -side, high), "black"),
    ], LinkJoint("gripper_joint", "base_link", (model.length_front, 0.0, 0.0)))


def add_laser(urdf: Urdf, model: RobotModel, laser: LaserPlace) -> None:
    """Add the link ``laser``: its frame is the same that the laser's node publishes for this model.

    Where nobody knows how high the laser is, the frame is on the floor, and the housing is drawn on the deck.
    """
    deck = model.shape.height
    mirror = deck + (-LASER_ABOVE if laser.upside_down else LASER_ABOVE) if laser.z is None else laser.z
    bottom = min(deck, mirror - 0.05) if not laser.upside_down else mirror - 0.05
    side = min(LASER_SIZE, mirror + 0.05 - bottom) / 2
    frame = laser.z or 0.0
    middle = mirror - frame
    urdf.link("laser", [
        Box((-side, -side, bottom - frame), (side, side, middle - 0.015), "blue"),
        Cylinder((0.0, 0.0, middle), side * 0.9, 0.03, "black"),
        Box((-side, -side, middle + 0.015), (side, side, middle + 0.05), "blue"),
    ], LinkJoint("laser_joint", "base_link", (laser.x, laser.y, frame)))


def add_camera(urdf: Urdf, model: RobotModel, on_laser: bool) -> None:
    """Add a Canon VC-C4: ``ptz_base_link``, its pan and tilt joints, and ``camera``, which looks along its x.

    Pan is about +z, left positive; tilt is about +y, down positive (camera sheet 9).
    """
    x = model.laser.x if on_laser and model.laser is not None else model.length_front / 2
    z = model.shape.height + (CAMERA_ON_LASER if on_laser else 0.0)
    urdf.link("ptz_base_link", [Cylinder((0.0, 0.0, 0.015), 0.05, 0.03, "black")],
              LinkJoint("ptz_base_joint", "base_link", (x, 0.0, z)))
    urdf.link("ptz_pan_link", [
        Box((-0.03, side - 0.005, 0.0), (0.03, side + 0.005, 0.06), "grey") for side in (-0.045, 0.045)
    ], LinkJoint("ptz_pan_joint", "ptz_base_link", (0.0, 0.0, 0.03), kind="revolute", limits=PAN_LIMITS))
    urdf.link("camera", [
        Box((-0.04, -0.038, -0.03), (0.04, 0.038, 0.03), "grey"),
        Cylinder((0.05, 0.0, 0.0), 0.022, 0.03, "black", (0.0, math.pi / 2, 0.0)),
    ], LinkJoint("ptz_tilt_joint", "ptz_pan_link", (0.0, 0.0, CAMERA_HEIGHT - 0.03), kind="revolute",
                 axis=(0.0, 1.0, 0.0), limits=TILT_LIMITS))


def add_arm(urdf: Urdf, model: RobotModel) -> None:
    """Add the Pioneer Arm: the chain of the arm sheet 16. All joints at 0 stretch it straight ahead, level.

    The joints are positive to the left (base), up (shoulder, elbow, wrist), right-handed about the forward axis
    (roll). ``arm_gripper_joint`` is the opening between the fingers (m).
    """
    deck, half = model.shape.height, ARM_THICKNESS / 2
    shoulder = deck + SHOULDER_ABOVE
    up = (0.0, -1.0, 0.0)

    def along(length: float) -> Box:
        return Box((0.0, -half, -half), (length, half, half), "grey")

    def turns(name: str, parent: str, length: float, axis: Triple) -> LinkJoint:
        return LinkJoint(name, parent, (length, 0.0, 0.0), kind="revolute", axis=axis, limits=JOINT_LIMITS)

    urdf.link("arm_base", [Cylinder((0.0, 0.0, (deck - shoulder - half) / 2), 0.06, SHOULDER_ABOVE - half, "black")],
              LinkJoint("arm_mount_joint", "base_link", (ARM_X, 0.0, shoulder)))
    urdf.link("arm_turret", [along(BASE_TO_SHOULDER)], turns("arm_base_joint", "arm_base", 0.0, (0.0, 0.0, 1.0)))
    urdf.link("arm_upper", [along(UPPER_ARM), Cylinder((0.0, 0.0, 0.0), 0.025, 0.06, "black", LYING)],
              turns("arm_shoulder_joint", "arm_turret", BASE_TO_SHOULDER, up))
    urdf.link("arm_forearm", [along(FOREARM), Cylinder((0.0, 0.0, 0.0), 0.025, 0.06, "black", LYING)],
              turns("arm_elbow_joint", "arm_upper", UPPER_ARM, up))
    urdf.link("arm_roll", [], turns("arm_roll_joint", "arm_forearm", FOREARM, (1.0, 0.0, 0.0)))
    palm = WRIST_TO_GRIPPER - 0.06
    width, opening, finger = GRIPPER_WIDTH / 2, GRIPPER_OPENING / 2, GRIPPER_HEIGHT / 2
    urdf.link("arm_hand", [
        Cylinder((0.0, 0.0, 0.0), 0.022, 0.05, "black", LYING),
        Box((0.0, -width, -finger), (palm, width, finger), "grey"),
        Box((palm, -width, -finger), (WRIST_TO_GRIPPER, -opening, finger), "black"),
    ], turns("arm_wrist_joint", "arm_roll", 0.0, up))
    urdf.link("arm_finger", [Box((0.0, 0.0, -finger), (0.06, width - opening, finger), "black")],
              LinkJoint("arm_gripper_joint", "arm_hand", (palm, -opening, 0.0), kind="prismatic", axis=(0.0, 1.0, 0.0),
                        limits=(0.0, GRIPPER_OPENING)))

"""The body of the robot in its world: where it stands, how it moves, what stops it, and which bumpers are pressed.

Lengths are in metres, angles in radians, poses in the map frame. This file does not depend on motors or packets.
"""

from typing import List, Optional, Sequence, Tuple

from ...robots import RobotModel
from ..world.crowd import Candidate, Obstacle
from ..world.geometry import Block, edges, outlines_meet
from ..world.materials import Material
from ..world.poses import Heading, Point, Pose, along_arc, hypot, placed, relative
from ..world.pushing import make_way
from ..world.world import World

SKINS = (0.5, 0.1, 0.02)
"""Margins (m) that are added to the body's outline in the collision test, largest first.

If the outline with a margin is free, the body can move as far as the margin before the next test.
"""
AWAY = 0.02
"""Distance (m) that the body must move away from an obstacle before another collision counts as a new contact."""
BUMPER_DEPTH = 0.02
"""Distance (m) from the body to the outer edge of its bumper segments."""


def box_round(outline: Sequence[Point], skin: float) -> Tuple[Point, ...]:
    """Return the corners of the bounding box of an outline, enlarged by `skin` (m) on all sides."""
    xs, ys = zip(*outline)
    low_x, high_x, low_y, high_y = min(xs) - skin, max(xs) + skin, min(ys) - skin, max(ys) + skin
    return (low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)


class Body:
    """A robot's body that moves through a world. Walls, posts and other robots stop it.

    Args:
        world: the world in which the body moves.
        outline: corners of the body (m, base_link).
        pose: start pose (m, rad; map frame).
        hull: corners of the part of the body that sonar can detect (m, base_link). The whole outline if None.

    Attributes:
        pose: present pose (m, rad; map frame).
        reach: largest distance (m) from the middle of the body to any of its points.
        box: rectangle with which the body pushes cans (m, base_link).
        contacts: how many times the body has run into an obstacle.
        touched_by_people: how many times a person has walked into the body while it stood.
        driven: distance (m) that the body has driven, forward and backward, without what it was carried.
        carried: how many times a person has carried the body somewhere else.
        material: what light finds at the body: a robot, or a robot with a laser that is on.
        blocked: whether an obstacle prevented the last step.
    """

    def __init__(self, world: World, outline: Sequence[Point], pose: Pose, hull: Optional[Sequence[Point]] = None):
        self._world = world
        self.material = Material.ROBOT
        self.carried = 0
        self.place(pose)
        self.begin_count()
        self._heading = Heading()
        self._outline, self._hull = tuple(outline), tuple(hull or outline)
        xs, ys = zip(*self._hull)
        self.box = Block(min(xs), max(xs), min(ys), max(ys))
        self._outlines = [(box_round(outline, skin), skin) for skin in SKINS] + [(tuple(outline), 0.0)]
        self.reach = max(hypot(x, y) for x, y in outline)
        self._tried = 0
        self._refused: Optional[Pose] = None
        self._contact_at: Optional[Pose] = None
        self._heard_at: Optional[Pose] = None
        self._candidates: List[Candidate] = []

    def place(self, pose: Pose) -> None:
        """Put the body at `pose` (m, rad; map frame), whatever stands there."""
        self.pose = (float(pose[0]), float(pose[1]), float(pose[2]))
        self._free = 0.0
        self.blocked = False
        self._world.crowd.moved(self)

    def begin_count(self) -> None:
        """Begin to count contacts, touches and the driven distance from zero."""
        self.contacts, self.touched_by_people, self.driven = 0, 0, 0.0

    def carry(self, pose: Pose) -> None:
        """Put the body at `pose` (m, rad; map frame). What it meets there next counts as a new contact."""
        self.place(pose)
        self.carried += 1
        self._contact_at = None

    def move(self, distance: float, turn: float) -> bool:
        """Drive an arc, unless the body would touch a wall, a post or another robot at its end.

        If the body would touch something, it stays where it is, and a contact is counted. A contact is counted only
        once until the body has moved away, not at each try.

        Args:
            distance: length of the arc (m), negative for backward.
            turn: angle of the arc (rad, counter-clockwise positive).

        Returns:
            Whether the body moved.
        """
        pose = along_arc(self.pose, distance, turn, self._heading.unit)
        swept = abs(distance) + self.reach * abs(turn)
        if swept < self._free:
            self._free -= swept
        elif not self._is_free(pose):
            return self._stopped()
        for body in self._world.crowd.near(pose[0], pose[1], self.reach, self):
            if body is not self and self.would_meet(body, pose):
                return self._stopped()
        self.pose = pose
        self.blocked = False
        if self._contact_at is not None and self._far_from(self._contact_at):
            self._contact_at = None
        if distance:
            self._world.crowd.moved(self)
        return True

    def would_meet(self, other: Obstacle, pose: Pose) -> bool:
        """Return whether this body would touch the `other` body if it stood at `pose` (map frame)."""
        x, y, together = pose[0] - other.pose[0], pose[1] - other.pose[1], self.reach + other.reach
        return x * x + y * y < together * together and outlines_meet(placed(self._outline, pose), other.outline)

    def _stopped(self) -> bool:
        self.contacts += self._contact_at is None
        self._contact_at = self.pose
        self.blocked = True
        return False

    def make_way(self, pose: Pose) -> bool:
        """Push cans out of the way of the body at `pose` (map frame).

        Returns:
            False when a can is jammed; then no can was moved. True in all other cases.
        """
        return not self._world.cans or make_way(self._world, pose, lambda radius: (self.box,), (), self.box.reach)

    @property
    def outline(self) -> List[Point]:
        """The corners of the body at its present pose (m, map frame)."""
        return placed(self._outline, self.pose)

    @property
    def candidates(self) -> List[Candidate]:
        """The edges of the body that sonar can detect, at its present pose."""
        if self._heard_at is not self.pose:
            self._heard_at = self.pose
            self._candidates = [(0.0, *edge) for edge in edges(placed(self._hull, self.pose))]
        return self._candidates

    def touches(self, polygon: Sequence[Point]) -> bool:
        """Return whether a polygon overlaps a wall, a post or another robot.

        The polygon is given in base_link (m) and placed at the present pose of the body.
        """
        corners = placed(polygon, self.pose)
        near = self._world.crowd.near(self.pose[0], self.pose[1], self.reach, self)
        return self._world.touches(corners) or any(
            outlines_meet(corners, body.outline) for body in near if body is not self)

    def _far_from(self, pose: Pose) -> bool:
        x, y, heading = relative(pose, self.pose)
        return hypot(x, y) + self.reach * abs(heading) > AWAY

    def _is_free(self, pose: Pose) -> bool:
        """Return whether the body touches no wall and no post at `pose` (map frame).

        If it is free, also store the distance that it can move from there without another test. For this, the outline
        is tested with the margins of `SKINS`, largest first. To save time, the first margin is at most one step larger
        than the margin that was free in the last test.
        """
        if pose == self._refused:  # the body still presses against the same obstacle
            return False
        for key in range(max(0, self._tried - 1), len(self._outlines)):
            outline, skin = self._outlines[key]
            if not self._world.touches(placed(outline, pose)):
                self._free, self._tried = skin, key
                return True
        self._refused, self._tried = pose, len(self._outlines)
        return False


class BumperRing:
    """The front bumper and the rear bumper of a robot.

    Attributes:
        front_stalls: whether a pressed front bumper stalls the wheels at once.
        rear_stalls: whether a pressed rear bumper stalls the wheels at once.
    """

    def __init__(self, model: RobotModel, body: Body):
        self._model, self._body = model, body
        self.reset()

    def reset(self) -> None:
        """Let both bumpers stall the wheels, as at power-on."""
        self.front_stalls = self.rear_stalls = True

    def bits(self) -> Tuple[int, int]:
        """Return the pressed segments of the front bumper and of the rear bumper, one bit for each segment.

        Bit 0 is the leftmost segment of the front bumper, and the rightmost segment of the rear bumper.
        """
        if not self._body.blocked:
            return 0, 0
        front, rear = self._model.length_front, -self._model.length_rear
        return self._pressed(self._model.front_bumpers, front, 1.0), self._pressed(self._model.rear_bumpers, rear, -1.0)

    def stall(self, distance: float) -> bool:
        """Return whether a bumper that stalls the wheels is pressed on the side to which the robot drives.

        `distance` (m) is positive for forward, negative for backward.
        """
        front, rear = self.bits()
        if distance > 0.0:
            return self.front_stalls and front != 0
        return distance < 0.0 and self.rear_stalls and rear != 0

    def _pressed(self, count: int, near: float, side: float) -> int:
        """Return the pressed segments of one bumper, one bit for each segment.

        Args:
            count: number of segments.
            near: x (m, base_link) of the end of the body, where the bumper begins.
            side: 1 for the front bumper, -1 for the rear bumper.
        """
        if not count:
            return 0
        width, far = self._model.width / count, near + side * BUMPER_DEPTH
        lefts = [side * (self._model.width / 2.0 - segment * width) for segment in range(count)]
        return sum(
            1 << segment for segment, left in enumerate(lefts)
            if self._body.touches(((near, left), (near, left - side * width), (far, left - side * width), (far, left))))

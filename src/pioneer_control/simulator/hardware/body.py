"""The body of the robot in its world: where it stands, how it moves, what stops it, and which bumpers are pressed.

Metres and radians in the map frame; knows neither motors nor packets.
"""

from typing import List, Optional, Sequence, Tuple

from ...robots import RobotModel
from ..world.crowd import Candidate, Obstacle
from ..world.geometry import Block, edges, outlines_meet
from ..world.poses import Heading, Point, Pose, along_arc, hypot, placed, relative
from ..world.pushing import make_way
from ..world.world import World

SKINS = (0.5, 0.1, 0.02)
"""How much larger than itself (m) the body is taken to be when asking how far it can go before the next question."""
AWAY = 0.02
"""A body that touched something has to go this far (m) away before touching again counts as another contact."""
BUMPER_DEPTH = 0.02
"""How far (m) the segments of the bumpers stand out from the body."""


def box_round(outline: Sequence[Point], skin: float) -> Tuple[Point, ...]:
    """The rectangle along the axes round an outline and all that is nearer to it than `skin`."""
    xs, ys = zip(*outline)
    low_x, high_x, low_y, high_y = min(xs) - skin, max(xs) + skin, min(ys) - skin, max(ys) + skin
    return (low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y)


class Body:
    """A solid outline that moves through `world` and is stopped by its walls and posts.

    Args:
        world: where it moves.
        outline: corners of the body in its own frame (m, base_link).
        pose: where it starts (map frame).
        hull: what of it is so tall that sonar sees it; all if None.

    Attributes:
        pose: where it stands (map frame).
        reach: no point of it is farther (m) from its middle.
        box: the rectangle that it is to a can (base_link).
        contacts: how often it has run into something.
        blocked: it could not take its last step.
    """

    def __init__(self, world: World, outline: Sequence[Point], pose: Pose, hull: Optional[Sequence[Point]] = None):
        self._world = world
        self.place(pose)
        self.contacts = 0
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
        """Put the body somewhere else, as if a person carried it there."""
        self.pose = (float(pose[0]), float(pose[1]), float(pose[2]))
        self._free = 0.0
        self.blocked = False
        self._world.crowd.moved(self)

    def move(self, distance: float, turn: float) -> bool:
        """Drive an arc. Where the body would touch something at its end, it stays, and a contact is counted.

        A contact counts once until the body has gone away from it, not once for each try.
        """
        pose = along_arc(self.pose, distance, turn, self._heading.unit)
        swept = abs(distance) + self.reach * abs(turn)
        if swept < self._free:
            self._free -= swept
        elif not self._is_free(pose):
            return self._stopped()
        for body in self._world.crowd.beside(pose[0], pose[1]):
            if body is not self and self._would_meet(body, pose):
                return self._stopped()
        self.pose = pose
        self.blocked = False
        if self._contact_at is not None and self._far_from(self._contact_at):
            self._contact_at = None
        if distance:
            self._world.crowd.moved(self)
        return True

    def _would_meet(self, other: Obstacle, pose: Pose) -> bool:
        """Whether the body at `pose` would touch another one."""
        x, y, together = pose[0] - other.pose[0], pose[1] - other.pose[1], self.reach + other.reach
        return x * x + y * y < together * together and outlines_meet(placed(self._outline, pose), other.outline)

    def _stopped(self) -> bool:
        self.contacts += self._contact_at is None
        self._contact_at = self.pose
        self.blocked = True
        return False

    def make_way(self, pose: Pose) -> bool:
        """Push cans aside for the body at `pose`; False when one is jammed, and nothing was moved."""
        return not self._world.cans or make_way(self._world, pose, lambda radius: (self.box,), (), self.box.reach)

    @property
    def outline(self) -> List[Point]:
        """Its corners where it stands now (map frame)."""
        return placed(self._outline, self.pose)

    @property
    def candidates(self) -> List[Candidate]:
        """What sonar can hear of it, where it stands now."""
        if self._heard_at is not self.pose:
            self._heard_at = self.pose
            self._candidates = [(0.0, *edge) for edge in edges(placed(self._hull, self.pose))]
        return self._candidates

    def touches(self, polygon: Sequence[Point]) -> bool:
        """Whether a polygon of the body's own frame, at its present pose, overlaps anything solid, other robots
        included.
        """
        corners = placed(polygon, self.pose)
        near = self._world.crowd.near(self.pose[0], self.pose[1], self.reach)
        return self._world.touches(corners) or any(
            outlines_meet(corners, body.outline) for body in near if body is not self)

    def _far_from(self, pose: Pose) -> bool:
        x, y, heading = relative(pose, self.pose)
        return hypot(x, y) + self.reach * abs(heading) > AWAY

    def _is_free(self, pose: Pose) -> bool:
        """Whether the body touches nothing at `pose`; if so, also finds how far it can go from there unasked.

        Asks for one skin more than last time at most, as walls come nearer and go away bit by bit.
        """
        if pose == self._refused:  # it presses on
            return False
        for key in range(max(0, self._tried - 1), len(self._outlines)):
            outline, skin = self._outlines[key]
            if not self._world.touches(placed(outline, pose)):
                self._free, self._tried = skin, key
                return True
        self._refused, self._tried = pose, len(self._outlines)
        return False


class BumperRing:
    """The bumpers in front and behind.

    Attributes:
        front_stalls, rear_stalls: whether they stop the wheels at once.
    """

    def __init__(self, model: RobotModel, body: Body):
        self._model, self._body = model, body
        self.reset()

    def reset(self) -> None:
        """Let all bumpers stall the wheels, as at power-on."""
        self.front_stalls = self.rear_stalls = True

    def bits(self) -> Tuple[int, int]:
        """Pressed segments of the front and of the rear bumper; bit 0 is the left one in front, the right one behind.
        """
        front, rear = self._model.length_front, -self._model.length_rear
        return self._pressed(self._model.front_bumpers, front, 1.0), self._pressed(self._model.rear_bumpers, rear, -1.0)

    def stall(self, distance: float) -> bool:
        """Whether a bumper that stalls the wheels is pressed on the side that the robot drives to."""
        front, rear = self.bits()
        if distance > 0.0:
            return self.front_stalls and front != 0
        return distance < 0.0 and self.rear_stalls and rear != 0

    def _pressed(self, count: int, near: float, side: float) -> int:
        """The bits of one bumper.

        Args:
            count: of its segments.
            near: x (m, base_link) where the body ends.
            side: 1 in front, -1 behind.
        """
        if not count or not self._body.blocked:
            return 0
        width, far = self._model.width / count, near + side * BUMPER_DEPTH
        lefts = [side * (self._model.width / 2.0 - segment * width) for segment in range(count)]
        return sum(
            1 << segment for segment, left in enumerate(lefts)
            if self._body.touches(((near, left), (near, left - side * width), (far, left - side * width), (far, left))))

"""The gripper: two parallel paddles on a lift, beams between them, contacts in them, and what they hold.

Metres and seconds; positions ahead of the palm and left of the middle, in the robot's own frame. Knows no packets.
"""

import math
from typing import List, Optional, Sequence, Tuple

from ...robots import GripperShape
from ..world.poses import compose, relative
from ..world.trigonometry import hypot
from ..world.geometry import Pose
from .pushing import Block, cans_near, make_way
from ..world.world import Can

TOLERANCE = 1e-4
"""A paddle this near (m) to a can presses on it."""


class ParallelGripper:
    """The gripper on the front of a robot's body.

    :param shape: its measures.
    :param numbers: the rest (`GripperNumbers`).
    :param world: whose cans it meets.
    :param front: where the body ends and the gripper begins (m ahead of base_link).
    :param body: the rectangle of the body behind it, which pushes cans too.
    """

    def __init__(self, shape: GripperShape, numbers, world, front: float, body: Block):
        self.shape = shape
        self.opening = shape.opening if numbers.open_at_power_on else 0.0
        self.height = shape.lift_height if numbers.lift_up_at_power_on else 0.0
        self.grasp_time = shape.grasp_time
        self.paddle_motion = 0
        self.lift_motion = 0
        self.lift_jammed = False
        self.paddles_jammed = False
        self.stuck = False
        """Whether something keeps paddles and lift from moving."""
        self.held: List[Can] = []
        self._held_at: List[Tuple[float, float]] = []
        self._felt = False, False
        self._world = world
        self._palm = front + shape.paddle_start
        self._reach = max(hypot(front + shape.reach, shape.width / 2.0), body.reach) + shape.max_object / 2.0
        self._reach_height = numbers.reach_height
        self._jam_time = numbers.jam_time
        self._body = body
        self._mount = Block(front, self._palm, -shape.width / 2.0, shape.width / 2.0)
        self._lift_goal = self.height
        self._pressing_s = 0.0
        self._stuck_for = 0.0

    # -- what it is told

    def open(self) -> None:
        """Open the paddles fully; what they held stays where it is."""
        if not self.stuck:
            self._release()
        self.paddles_jammed = False
        self.paddle_motion = 1 if self.opening < self.shape.opening else 0

    def close(self) -> None:
        """Close the paddles until they meet something or each other, and press on it for the grasp time."""
        self.paddles_jammed = False
        self.paddle_motion = min(self.paddle_motion, 0) if self.is_closed else -1

    def stop(self) -> None:
        """Stop the paddles; they no longer press on what they do not hold."""
        self.paddle_motion = 0
        self._felt = False, False

    def lift_to(self, height: float) -> None:
        """Raise or lower the paddles to `height` (m above the lowest), clipped to the travel of the lift."""
        self._lift_goal = max(0.0, min(self.shape.lift_height, height))
        self.lift_motion = (self._lift_goal > self.height) - (self._lift_goal < self.height)
        self.lift_jammed = False

    def lift_by(self, seconds: float) -> None:
        """Raise the paddles (lower them, when negative) for this long, relative to where they are."""
        self.lift_to(self.height + seconds * self.shape.lift_speed)

    def lift_stop(self) -> None:
        """Stop the lift where it is."""
        self._lift_goal = self.height
        self.lift_motion = 0

    # -- what it is

    @property
    def held_can(self) -> Optional[Can]:
        """The can it holds (the first of them, should it be several), None when it holds nothing."""
        return self.held[0] if self.held else None

    @property
    def is_open(self) -> bool:
        """Whether the paddles are fully open."""
        return self.opening >= self.shape.opening

    @property
    def is_closed(self) -> bool:
        """Whether the paddles are closed, on each other or on something."""
        return self.opening <= 0.0 or bool(self.held)

    @property
    def contacts(self) -> Tuple[bool, bool]:
        """Whether something presses on the left and on the right paddle: a can, or the other paddle.

        Closed paddles press on each other where they press on nothing else, so contacts alone do not show that something is held.

        Source: protocol sheet 6.4.
        """
        return (True, True) if self.is_closed else self._felt

    @property
    def is_up(self) -> bool:
        """Whether the lift is at its top."""
        return self.height >= self.shape.lift_height

    @property
    def is_down(self) -> bool:
        """Whether the lift is at its bottom."""
        return self.height <= 0.0

    @property
    def is_low(self) -> bool:
        """Whether the paddles are low enough to meet what stands on the floor."""
        return self.height <= self._reach_height

    def beams_broken(self, pose: Pose) -> Tuple[bool, bool]:
        """Whether something is in the inner and in the outer beam, for a robot at `pose`."""
        places = [(x, y, can.radius) for can, (x, y) in zip(self.held, self._held_at)]
        if self.is_low:
            places += [self._from_palm(can, pose) + (can.radius,) for can in cans_near(self._world, pose, self._reach)]
        if not places:
            return False, False
        half = self.opening / 2.0

        def broken(beam: float) -> bool:
            return any(
                abs(x - beam) < radius and abs(y) < half + math.sqrt((radius - x + beam) * (radius + x - beam))
                for x, y, radius in places
            )
        return half > 0.0 and broken(self.shape.inner_beam), half > 0.0 and broken(self.shape.outer_beam)

    def blocks_for(self, radius: float) -> Sequence[Block]:
        """The rectangles, body included, that a can of `radius` on the floor meets (m, base_link)."""
        if not self.is_low:
            return self._body, self._mount
        tip, half = self._palm + self.shape.paddle_length, self.opening / 2.0
        outside = half + self.shape.paddle_thickness
        if 2.0 * radius > self.opening + 1e-9:  # it does not fit between the paddles: they are one block to it
            return self._body, self._mount, Block(self._palm, tip, -outside, outside)
        return self._body, self._mount, Block(self._palm, tip, half, outside), Block(self._palm, tip, -outside, -half)

    # -- what happens

    def step(self, dt: float, pose: Pose) -> None:
        """Move paddles and lift for `dt` seconds on a robot at `pose`."""
        if self.stuck:
            self._strain(dt)
            return
        self._stuck_for = 0.0
        if self.held and self.paddle_motion > 0:
            self._release()
        if self.is_closed and self.paddle_motion < 0:
            self._press(dt)
        elif self.paddle_motion < 0:
            self._close_further(dt, pose)
        elif self.paddle_motion > 0:
            self._open_further(dt, pose)
        if self.lift_motion:
            self._lift_further(dt, pose)

    def _strain(self, dt: float) -> None:
        """Try to move what is stuck, for a while; then give up and show an error."""
        self._stuck_for = self._stuck_for + dt if self.paddle_motion or self.lift_motion else 0.0
        if self._stuck_for >= self._jam_time - 1e-9:
            self.paddles_jammed |= self.paddle_motion != 0
            self.lift_jammed |= self.lift_motion != 0
            self.paddle_motion = 0
            self.lift_stop()

    def make_way(self, pose: Pose) -> bool:
        """Push cans aside for a robot that goes to `pose`; False when one is jammed, and nothing was moved."""
        self.carry(pose)
        return make_way(self._world, pose, self.blocks_for, self.held if self.is_low else (), self._reach)

    def carry(self, pose: Pose) -> None:
        """What is held goes where the robot goes."""
        for can, (x, y) in zip(self.held, self._held_at):
            can.x, can.y, _ = compose(pose, (self._palm + x, y, 0.0))

    def _from_palm(self, can, pose: Pose) -> Tuple[float, float]:
        x, y, _ = relative(pose, (can.x, can.y, 0.0))
        return x - self._palm, y

    def _between(self, pose: Pose) -> List[Can]:
        """The cans that stand between the paddles: their middles are, and the paddles are low."""
        if not self.is_low:
            return []
        between = []
        for can in cans_near(self._world, pose, self._reach):
            x, y = self._from_palm(can, pose)
            graspable = self.shape.min_object <= 2.0 * can.radius <= self.shape.max_object
            if graspable and 0.0 < x <= self.shape.paddle_length and abs(y) < self.opening / 2.0:
                between.append(can)
        return between

    def _close_further(self, dt: float, pose: Pose) -> None:
        between = self._between(pose)
        before = self.opening
        widest = max((2.0 * can.radius for can in between), default=0.0)
        self.opening = max(widest, before - self.shape.opening / self.shape.close_time * dt, 0.0)
        jammed = not self.make_way(pose)
        if jammed:
            self.opening = before
        self._felt = self._feel(between, pose)
        if all(self._felt) and (jammed or self.opening <= widest):
            self._grasp([can for can in between if jammed or 2.0 * can.radius >= self.opening - TOLERANCE], pose)
        elif jammed:
            self.stop()
        self._pressing_s = self.grasp_time

    def _press(self, dt: float) -> None:
        """The motor runs on for the grasp time after the paddles have met what they press on."""
        self._pressing_s -= dt
        if self._pressing_s <= 1e-9:
            self.stop()

    def _feel(self, between: List[Can], pose: Pose) -> Tuple[bool, bool]:
        """Whether the left and the right paddle press on one of the cans between them."""
        half = self.opening / 2.0 - TOLERANCE
        sides = [(self._from_palm(can, pose)[1], can.radius) for can in between]
        return any(y + radius >= half for y, radius in sides), any(y - radius <= -half for y, radius in sides)

    def _grasp(self, cans: List[Can], pose: Pose) -> None:
        self.held = cans
        self._held_at = [self._from_palm(can, pose) for can in cans]
        for can in cans:
            can.held_by = self

    def _release(self) -> None:
        for can in self.held:
            can.held_by = None
        self.held, self._held_at = [], []
        self._felt = False, False

    def _open_further(self, dt: float, pose: Pose) -> None:
        before = self.opening
        self.opening = min(self.shape.opening, before + self.shape.opening / self.shape.close_time * dt)
        if not self.make_way(pose):
            self.opening = before
            self.paddle_motion = 0
        elif self.is_open:
            self.paddle_motion = 0

    def _lift_further(self, dt: float, pose: Pose) -> None:
        before = self.height
        way = self.shape.lift_speed * dt
        if abs(self._lift_goal - before) <= way:
            self.height, self.lift_motion = self._lift_goal, 0
        else:
            self.height = before + way * self.lift_motion
        if not self.make_way(pose):
            self.height, self.lift_motion, self.lift_jammed = before, 0, True

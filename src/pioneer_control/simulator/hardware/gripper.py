"""The gripper: two parallel paddles on a lift, beams between them, contacts in them, and what they hold.

Metres and seconds; positions ahead of the palm and left of the middle, in the robot's own frame. Knows no packets.
"""

import math
from typing import List, Optional, Sequence, Tuple

from ...robots import GripperShape
from ..world.geometry import Block
from ..world.poses import Pose, compose, hypot, relative
from ..world.pushing import cans_near, make_way
from ..world.world import Can, World
from .robot_numbers import GripperNumbers

TOLERANCE = 1e-4
"""A paddle this near (m) to a can presses on it."""

Seen = Tuple[Can, float, float]
"""A can, and where its middle is: ahead of the palm and left of the middle of the gripper (m)."""


class PaddleLift:
    """The lift that carries the paddles.

    Attributes:
        height: of the paddles (m above the lowest).
        goal: height that it moves to; its own height while it does not move.
        jammed: it was told to move and could not.
    """

    def __init__(self, shape: GripperShape, up: bool):
        self._shape = shape
        self.height = shape.lift_height if up else 0.0
        self.jammed = False
        self.goal = self.height

    @property
    def is_up(self) -> bool:
        """Whether it is at its top."""
        return self.height >= self._shape.lift_height

    @property
    def is_down(self) -> bool:
        """Whether it is at its bottom."""
        return self.height <= 0.0

    @property
    def motion(self) -> int:
        """1 up, -1 down, 0 none."""
        return (self.goal > self.height) - (self.goal < self.height)

    def move_to(self, height: float) -> None:
        """Raise or lower the paddles to `height` (m above the lowest), clipped to the travel of the lift."""
        self.goal = max(0.0, min(self._shape.lift_height, height))
        self.jammed = False

    def move_for(self, seconds: float) -> None:
        """Raise the paddles (lower them, when negative) for this long, from where they are."""
        self.move_to(self.height + seconds * self._shape.lift_speed)

    def stop(self) -> None:
        """Stop where it is."""
        self.goal = self.height

    def step(self, dt: float) -> None:
        """Move on for `dt` seconds."""
        way = self._shape.lift_speed * dt
        arrives = abs(self.goal - self.height) <= way
        self.height = self.goal if arrives else self.height + way * self.motion


class ParallelGripper:
    """The gripper on the front of a robot's body.

    Args:
        shape: its measures.
        numbers: the rest.
        world: whose cans it meets.
        front: where the body ends and the gripper begins (m ahead of base_link).
        body: the rectangle of the body behind it, which pushes cans too.

    Attributes:
        lift: carries the paddles.
        opening: between the paddles (m).
        grasp_time: for so long (s) the motor runs on after the paddles have met what they press on.
        paddle_motion: 1 outward, -1 inward, 0 none.
        paddles_jammed: the paddles were told to move and could not.
        stuck: something keeps paddles and lift from moving.
    """

    def __init__(self, shape: GripperShape, numbers: GripperNumbers, world: World, front: float, body: Block):
        self.shape = shape
        self.lift = PaddleLift(shape, numbers.lift_up_at_power_on)
        self.opening = shape.opening if numbers.open_at_power_on else 0.0
        self.grasp_time = shape.grasp_time
        self.paddle_motion = 0
        self.paddles_jammed = False
        self.stuck = False
        self._held: List[Seen] = []
        self._felt = False, False
        self._world, self._body = world, body
        self._palm = front + shape.paddle_start
        self._reach = max(hypot(front + shape.reach, shape.width / 2.0), body.reach) + shape.max_object / 2.0
        self._numbers = numbers
        self._mount = Block(front, self._palm, -shape.width / 2.0, shape.width / 2.0)
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

    def halt(self) -> None:
        """Stop paddles and lift."""
        self.stop()
        self.lift.stop()

    def store(self) -> None:
        """Close the paddles and raise the lift."""
        self.close()
        self.lift.move_to(self.shape.lift_height)

    def deploy(self) -> None:
        """Open the paddles and lower the lift."""
        self.open()
        self.lift.move_to(0.0)

    # -- what it is

    @property
    def height(self) -> float:
        """How high (m) the paddles and what they hold are lifted."""
        return self.lift.height

    @property
    def held(self) -> List[Can]:
        """The cans that it holds."""
        return [can for can, _, _ in self._held]

    @property
    def held_can(self) -> Optional[Can]:
        """The can that it holds, the first of several; None when it holds nothing."""
        return self._held[0][0] if self._held else None

    @property
    def is_open(self) -> bool:
        """Whether the paddles are fully open."""
        return self.opening >= self.shape.opening

    @property
    def is_closed(self) -> bool:
        """Whether the paddles are closed, on each other or on something."""
        return self.opening <= 0.0 or bool(self._held)

    @property
    def contacts(self) -> Tuple[bool, bool]:
        """Whether something presses on the left and on the right paddle: a can, or the other paddle.

        Closed paddles press on each other where they press on nothing else, so contacts alone do not show that
        something is held.

        Source: protocol sheet 6.4.
        """
        return (True, True) if self.is_closed else self._felt

    @property
    def is_low(self) -> bool:
        """Whether the paddles are low enough to meet what stands on the floor."""
        return self.height <= self._numbers.reach_height

    def beams_broken(self, pose: Pose) -> Tuple[bool, bool]:
        """Whether something is in the inner and in the outer beam, for a robot at `pose`."""
        seen = [*self._held, *self._near(pose)]
        half = self.opening / 2.0

        def broken(beam: float) -> bool:
            return half > 0.0 and any(
                abs(x - beam) < can.radius
                and abs(y) < half + math.sqrt((can.radius - x + beam) * (can.radius + x - beam))
                for can, x, y in seen
            )
        return broken(self.shape.inner_beam), broken(self.shape.outer_beam)

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
        if self._held and self.paddle_motion > 0:
            self._release()
        if self.is_closed and self.paddle_motion < 0:
            self._pressing_s -= dt
            if self._pressing_s <= 1e-9:
                self.stop()
        elif self.paddle_motion < 0:
            self._close_further(dt, pose)
        elif self.paddle_motion > 0:
            self._open_further(dt, pose)
        if self.lift.goal != self.lift.height:
            self._lift_further(dt, pose)

    def _strain(self, dt: float) -> None:
        """Try to move what is stuck, for a while; then give up and show an error."""
        self._stuck_for = self._stuck_for + dt if self.paddle_motion or self.lift.motion else 0.0
        if self._stuck_for >= self._numbers.jam_time - 1e-9:
            self.paddles_jammed |= self.paddle_motion != 0
            self.lift.jammed |= self.lift.motion != 0
            self.paddle_motion = 0
            self.lift.stop()

    def make_way(self, pose: Pose) -> bool:
        """Move what is held to a robot that goes to `pose`, and push cans aside.

        Returns:
            False when a can is jammed. Then none was pushed.
        """
        if not self._world.cans:
            return True
        for can, x, y in self._held:
            can.x, can.y, _ = compose(pose, (self._palm + x, y, 0.0))
        return make_way(self._world, pose, self.blocks_for, self.held if self.is_low else (), self._reach)

    def _see(self, can: Can, pose: Pose) -> Seen:
        x, y, _ = relative(pose, (can.x, can.y, 0.0))
        return can, x - self._palm, y

    def _near(self, pose: Pose) -> List[Seen]:
        """The cans that low paddles could meet; none while the paddles are higher."""
        return [self._see(can, pose) for can in cans_near(self._world, pose, self._reach)] if self.is_low else []

    def _close_further(self, dt: float, pose: Pose) -> None:
        shape, before = self.shape, self.opening
        between = [can for can, x, y in self._near(pose)
                   if shape.min_object <= 2.0 * can.radius <= shape.max_object
                   and 0.0 < x <= shape.paddle_length and abs(y) < before / 2.0]
        widest = max((2.0 * can.radius for can in between), default=0.0)
        self.opening = max(widest, before - shape.opening / shape.close_time * dt, 0.0)
        jammed = not self.make_way(pose)
        if jammed:
            self.opening = before
        half = self.opening / 2.0 - TOLERANCE
        seen = [self._see(can, pose) for can in between]
        self._felt = (any(y + can.radius >= half for can, _, y in seen),
                      any(y - can.radius <= -half for can, _, y in seen))
        if all(self._felt) and (jammed or self.opening <= widest):
            self._held = [each for each in seen if jammed or 2.0 * each[0].radius >= self.opening - TOLERANCE]
            for can in self.held:
                can.held_by = self
        elif jammed:
            self.stop()
        self._pressing_s = self.grasp_time

    def _release(self) -> None:
        for can in self.held:
            can.held_by = None
        self._held = []
        self._felt = False, False

    def _open_further(self, dt: float, pose: Pose) -> None:
        before = self.opening
        self.opening = min(self.shape.opening, before + self.shape.opening / self.shape.close_time * dt)
        jammed = not self.make_way(pose)
        if jammed:
            self.opening = before
        if jammed or self.is_open:
            self.paddle_motion = 0

    def _lift_further(self, dt: float, pose: Pose) -> None:
        before = self.lift.height
        self.lift.step(dt)
        if not self.make_way(pose):
            self.lift.height = before
            self.lift.jammed = True
            self.lift.stop()

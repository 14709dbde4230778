"""The gripper: two parallel paddles on a lift, with light beams between the paddles and contact switches in them.

Lengths are in metres, times in seconds. Positions are given ahead of the palm and left of the middle of the gripper.
This file does not depend on packets.
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
"""Largest distance (m) between a paddle and a can that the paddle presses on."""

Seen = Tuple[Can, float, float]
"""A can and the position (m) of its middle: ahead of the palm, and left of the middle of the gripper."""


class PaddleLift:
    """The lift that carries the paddles.

    Attributes:
        height: height of the paddles (m above their lowest position).
        goal: height to which the lift moves (m above the lowest position). Equal to `height` while it does not move.
        jammed: whether the lift was commanded to move and could not.
    """

    def __init__(self, shape: GripperShape, up: bool):
        self._shape = shape
        self.height = shape.lift_height if up else 0.0
        self.jammed = False
        self.goal = self.height

    @property
    def is_up(self) -> bool:
        """Whether the lift is at its top."""
        return self.height >= self._shape.lift_height

    @property
    def is_down(self) -> bool:
        """Whether the lift is at its bottom."""
        return self.height <= 0.0

    @property
    def motion(self) -> int:
        """The direction in which the lift moves: 1 up, -1 down, 0 when it does not move."""
        return (self.goal > self.height) - (self.goal < self.height)

    def move_to(self, height: float) -> None:
        """Raise or lower the paddles to `height` (m above the lowest position), clipped to the travel of the lift."""
        self.goal = max(0.0, min(self._shape.lift_height, height))
        self.jammed = False

    def move_for(self, seconds: float) -> None:
        """Raise the paddles for `seconds` from their present height, or lower them when `seconds` is negative."""
        self.move_to(self.height + seconds * self._shape.lift_speed)

    def stop(self) -> None:
        """Stop the lift at its present height."""
        self.goal = self.height

    def step(self, dt: float) -> None:
        """Move towards the goal for `dt` seconds."""
        way = self._shape.lift_speed * dt
        arrives = abs(self.goal - self.height) <= way
        self.height = self.goal if arrives else self.height + way * self.motion


class ParallelGripper:
    """The gripper on the front of a robot's body.

    Args:
        shape: dimensions and speeds, from the robot model.
        numbers: the other parameters, from ``robot.yaml``.
        world: world whose cans the gripper pushes and holds.
        front: x (m, base_link) where the body ends and the gripper begins.
        body: rectangle of the body behind the gripper (m, base_link), which pushes cans too.

    Attributes:
        shape: as the argument.
        lift: the lift that carries the paddles.
        opening: distance between the paddles (m).
        grasp_time: duration (s) for which the paddles press on after they have closed on something.
        paddle_motion: 1 while the paddles open, -1 while they close or press, 0 when they are off.
        paddles_jammed: whether the paddles were commanded to move and could not.
        stuck: whether a simulated fault keeps paddles and lift from moving.
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

    # -- commands

    def open(self) -> None:
        """Start to open the paddles fully, and release the held cans. A stuck gripper does not release them."""
        if not self.stuck:
            self.release()
        self.paddles_jammed = False
        self.paddle_motion = 1 if self.opening < self.shape.opening else 0

    def close(self) -> None:
        """Start to close the paddles. When they meet a can or each other, they press for the grasp time."""
        self.paddles_jammed = False
        self.paddle_motion = min(self.paddle_motion, 0) if self.is_closed else -1

    def stop(self) -> None:
        """Stop the paddles, and end the contacts with cans that they do not hold."""
        self.paddle_motion = 0
        self._felt = False, False

    def release(self) -> None:
        """Release the held cans where they are, as if a person took them out of the paddles."""
        for can in self.held:
            can.held_by = None
        self._held = []
        self._felt = False, False

    def halt(self) -> None:
        """Stop paddles and lift."""
        self.stop()
        self.lift.stop()

    def store(self) -> None:
        """Start to close the paddles and to raise the lift to its top."""
        self.close()
        self.lift.move_to(self.shape.lift_height)

    def deploy(self) -> None:
        """Start to open the paddles and to lower the lift to its bottom."""
        self.open()
        self.lift.move_to(0.0)

    # -- state

    @property
    def height(self) -> float:
        """The height (m above the lowest position) of the paddles and the cans that they hold."""
        return self.lift.height

    @property
    def held(self) -> List[Can]:
        """The cans that the gripper holds."""
        return [can for can, _, _ in self._held]

    @property
    def held_can(self) -> Optional[Can]:
        """The can that the gripper holds, or the first of several cans. None when it holds no can."""
        return self._held[0][0] if self._held else None

    @property
    def is_open(self) -> bool:
        """Whether the paddles are fully open."""
        return self.opening >= self.shape.opening

    @property
    def is_closed(self) -> bool:
        """Whether the paddles are closed, on each other or on a can that they hold."""
        return self.opening <= 0.0 or bool(self._held)

    @property
    def contacts(self) -> Tuple[bool, bool]:
        """Whether the left paddle and the right paddle report contact with a can or with the other paddle.

        Paddles that are closed without a can press on each other. So contacts alone do not prove that a can is held.

        Source: protocol sheet 6.4.
        """
        return (True, True) if self.is_closed else self._felt

    @property
    def is_low(self) -> bool:
        """Whether the paddles are low enough to touch cans on the floor."""
        return self.height <= self._numbers.reach_height

    def beams_broken(self, pose: Pose) -> Tuple[bool, bool]:
        """Return whether a can breaks the inner beam, and whether a can breaks the outer beam.

        `pose` is the pose of the robot (m, rad; map frame).
        """
        half = self.opening / 2.0
        seen = [*self._held, *self._near(pose)] if half > 0.0 else []
        if not seen:    # the usual case
            return False, False

        def broken(beam: float) -> bool:
            return any(
                abs(x - beam) < can.radius
                and abs(y) < half + math.sqrt((can.radius - x + beam) * (can.radius + x - beam))
                for can, x, y in seen
            )
        return broken(self.shape.inner_beam), broken(self.shape.outer_beam)

    def blocks_for(self, radius: float) -> Sequence[Block]:
        """Return the rectangles of body and gripper (m, base_link) that push a can of `radius` (m) on the floor."""
        if not self.is_low:
            return self._body, self._mount
        tip, half = self._palm + self.shape.paddle_length, self.opening / 2.0
        outside = half + self.shape.paddle_thickness
        if 2.0 * radius > self.opening + 1e-9:  # the can does not fit between the paddles, which then act as one block
            return self._body, self._mount, Block(self._palm, tip, -outside, outside)
        return self._body, self._mount, Block(self._palm, tip, half, outside), Block(self._palm, tip, -outside, -half)

    # -- motion

    def step(self, dt: float, pose: Pose) -> None:
        """Move paddles and lift for `dt` seconds on a robot at `pose` (m, rad; map frame)."""
        if self.stuck:
            self._strain(dt)
            return
        self._stuck_for = 0.0
        if self._held and self.paddle_motion > 0:
            self.release()
        if self.paddle_motion < 0 and self.is_closed:
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
        """Let stuck paddles and a stuck lift try to move for `dt` seconds. After the jam time, stop and mark as jammed.
        """
        self._stuck_for = self._stuck_for + dt if self.paddle_motion or self.lift.motion else 0.0
        if self._stuck_for >= self._numbers.jam_time - 1e-9:
            self.paddles_jammed |= self.paddle_motion != 0
            self.lift.jammed |= self.lift.motion != 0
            self.paddle_motion = 0
            self.lift.stop()

    def make_way(self, pose: Pose) -> bool:
        """Carry the held cans along with a robot that moves to `pose` (map frame), and push other cans out of the way.

        Returns:
            False when a can is jammed; then no can was pushed. True in all other cases.
        """
        if not self._world.cans:
            return True
        self.carry(pose)
        return make_way(self._world, pose, self.blocks_for, self.held if self.is_low else (), self._reach)

    def carry(self, pose: Pose) -> None:
        """Carry the held cans along with a robot that moves to `pose` (map frame)."""
        for can, x, y in self._held:
            can.x, can.y, _ = compose(pose, (self._palm + x, y, 0.0))

    def _see(self, can: Can, pose: Pose) -> Seen:
        x, y, _ = relative(pose, (can.x, can.y, 0.0))
        return can, x - self._palm, y

    def _near(self, pose: Pose) -> List[Seen]:
        """Return the cans near the gripper of a robot at `pose` (map frame). An empty list while the paddles are high.
        """
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

"""Puts robots and cans somewhere else, as a person in the room does. This file uses no ROS and no real time."""

from typing import Iterator, List, Sequence, Tuple

import numpy as np

from ..errors import ParameterError
from .simulation import Simulation
from .world import Can
from .world.geometry import Solids, is_inside
from .world.poses import Point, Pose, placed

Home = Tuple[Can, float, float]
"""A can, and the x and y (m, map frame) to which it returns."""


def homes_of(cans: Sequence[Can]) -> List[Home]:
    """Return each can with the place where it stands now."""
    return [(can, can.x, can.y) for can in cans]


class Carrier:
    """A person who carries robots and cans to other places. A robot that was carried stands there until its client
    commands a motion. Its odometry goes on from its present pose, because its wheels have not turned.

    Robots are numbered from 1, as in faults.

    Args:
        simulation: the robots and their world, before any time has passed: robots and cans that are reset return to
            where they are now.
    """

    def __init__(self, simulation: Simulation):
        self._world, self._robots, self._people = simulation.world, simulation.robots, simulation.people
        unmapped = [each.corners for each in simulation.world.unmapped if each.corners]
        self._boxes: Sequence[Sequence[Point]] = [*simulation.world.boxes, *unmapped]
        self._cans: Sequence[Home] = homes_of(simulation.world.cans)
        self.starts: Sequence[Pose] = [robot.true_pose for robot in simulation.robots]
        """The poses (m, rad; map frame) to which the robots return."""

    def put(self, number: int, pose: Pose) -> None:
        """Put a robot at `pose` (m, rad; map frame), with the cans that it holds.

        Raises:
            ParameterError: the robot would overlap something there. The message names all of it. Nothing has changed.
        """
        self._put(number, pose, "robot %d cannot stand at x %g, y %g, heading %g" % (number, *pose))

    def reset(self, number: int) -> None:
        """Put a robot back where it began, with the cans that it holds. Count its contacts and its way from zero.

        Raises:
            ParameterError: something else stands there. The message names all of it. Nothing has changed.
        """
        self._put(number, self.starts[number - 1], "robot %d cannot stand where it began" % number)
        self._robots[number - 1].hardware.body.begin_count()

    def reset_all(self) -> None:
        """Put all robots and cans back where they began. Grippers release what they hold. Count all from zero."""
        for robot, start in zip(self._robots, self.starts):
            if robot.gripper is not None:
                robot.gripper.release()
            robot.hardware.carry(start)
            robot.hardware.body.begin_count()
        for can, x, y in self._cans:
            can.x, can.y = x, y

    def settle(self, starts: Sequence[Pose], cans: Sequence[Home]) -> None:
        """Let robots and cans begin somewhere else: carry them there, and from now on back to there.

        Args:
            starts: the pose (m, rad; map frame) of each robot.
            cans: the cans that are in the world from now on. All others are taken away.
        """
        self.starts, self._cans = starts, cans
        self._world.cans[:] = [can for can, _, _ in cans]
        self.reset_all()

    def _put(self, number: int, pose: Pose, problem: str) -> None:
        """Put a robot at `pose`. If it would overlap something, raise a ParameterError that begins with `problem`."""
        robot = self._robots[number - 1]
        obstacles = list(self._obstacles(number, pose, placed(robot.model.outline(robot.gripper is not None), pose)))
        if obstacles:
            raise ParameterError("%s: in its way is %s" % (problem, ", ".join(obstacles)))
        robot.hardware.carry(pose)

    def _obstacles(self, number: int, pose: Pose, outline: Sequence[Point]) -> Iterator[str]:
        """Yield the names of all things that the `outline` (m, map frame) of a robot overlaps at `pose`."""
        if self._world.touches(outline):
            yield "a wall or a post"
        elif any(is_inside(*pose[:2], box) for box in self._boxes):
            yield "a box"
        body = self._robots[number - 1].hardware.body
        for other, robot in enumerate(self._robots, 1):
            if other != number and body.would_meet(robot.hardware.body, pose):
                yield "robot %d" % other
        if any(body.would_meet(person, pose) for person in self._people):
            yield "a person"
        for each, can in enumerate(self._world.cans, 1):
            disc = Solids(np.empty((0, 4)), np.array([[can.x, can.y, can.radius]]))
            if can.held_by is None and disc.overlap(outline, can.x, can.y, can.radius):
                yield "can %d" % each

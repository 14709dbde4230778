"""The helm of one robot of the client library: a velocity that lives for a time, and locks.

A stand-in: client.helm will replace it, which also knows programs that drive. Time (monotonic, s) is an argument.
"""

import math
from typing import Dict, Tuple

from ..client import Robot
from ..errors import RefusedError


class PlainHelm:
    """Lets one input drive a robot. There are no programs, so take() and release() change nothing.

    Attributes:
        locks: the names of all locks that are on, in the order in which they came.
        programs: whether programs may command, in the words of the page's protocol.
    """

    programs = "none"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._locks: Dict[str, None] = {}
        self._until = math.inf      # time of the stop; infinity while nobody drives

    @property
    def locks(self) -> Tuple[str, ...]:
        """The names of all locks that are on."""
        return tuple(self._locks)

    @property
    def due(self) -> float:
        """The time by which tick() must be called; infinity while nobody drives."""
        return self._until

    def drive(self, name: str, linear: float, angular: float, timeout: float, now: float) -> None:
        """Drive at m/s and rad/s for ``timeout`` s. ``name`` is the name of the input.

        Raises RefusedError while locked, and the errors of Robot.set_velocity().
        """
        if self._locks and (linear or angular):
            raise RefusedError("locked: %s" % ", ".join(self._locks))
        self._robot.set_velocity(linear, angular)
        self._until = now + timeout

    def stop(self) -> None:
        """End the velocity at once."""
        self._until = math.inf
        self._robot.stop()

    def take(self, name: str) -> None:
        """Lock all inputs but ``name`` out."""

    def release(self) -> None:
        """Let all inputs command again."""

    def lock(self, name: str) -> None:
        """Stop, and let nothing through until this lock is taken away."""
        self._locks[name] = None
        self.stop()

    def unlock(self, name: str) -> None:
        """Take a lock away. One that is not on is no error."""
        self._locks.pop(name, None)

    def tick(self, now: float) -> None:
        """Stop the robot if its velocity is too old."""
        if now >= self._until:
            self.stop()

"""Lets the commands of several inputs through to one robot, as far as the helm allows: the last place before the wire.

The driver and the server of the page use it. What may command is in `helm`; here the decision and the write are one
step, so that no command of a program reaches the robot after a person has taken over.
"""

import threading
from time import monotonic
from typing import Callable, Iterable, Mapping, Optional, Tuple

from ..errors import PioneerError, RefusedError, UsageError
from ..p2os import GripperCommand
from .helm import Helm, HelmState, VelocityInput
from .robot import Robot
from .tcp import LOCKSTEP, is_lockstep


class SteeredRobot:
    """A robot that several inputs command. Any thread may call any method.

    Every method that commands raises what the same method of Robot raises. Besides, it raises RefusedError when the
    helm does not let the command through: a lock is set, or an input of higher priority commands or has the helm. Then
    nothing changes. A command to stand still goes through a lock.

    Args:
        robot: the robot, not in lockstep: inputs are silent for a real time.
        inputs: all inputs by their names.
        obstacles: what to tell people when a lock or an input is in the way: sentences by its name.
        on_change: called when it changes who commands. It is called with a lock held, so it must only take note.

    Raises:
        UsageError: the robot is in lockstep.
    """

    def __init__(self, robot: Robot, inputs: Mapping[str, VelocityInput], obstacles: Mapping[str, str],
                 on_change: Callable[[], None] = lambda: None) -> None:
        if is_lockstep(robot.url):
            raise UsageError("%s: lockstep is for one program that uses the robot alone: leave out %s"
                             % (robot.url, LOCKSTEP))
        self._robot = robot
        self._helm = Helm(inputs)
        self._obstacles = obstacles
        self._on_change = on_change
        self._turn = threading.Lock()
        self._told = HelmState()

    def state(self) -> HelmState:
        """Return who commands now."""
        with self._turn:
            return self._helm.state(monotonic())

    def changes_in(self) -> float:
        """Return after how many seconds the present commander will be silent for too long; infinity without one."""
        with self._turn:
            now = monotonic()
            return self._helm.changes_at(now) - now

    def set_timeout(self, name: str, timeout: float) -> None:
        """Change the time (s) for which a velocity of an input is good. It counts from the next velocity on."""
        with self._turn:
            self._helm.set_timeout(name, timeout)

    def set_velocity(self, name: str, linear: float, angular: float, who: str = "") -> None:
        """Drive at these finite velocities (m/s, rad/s) until the time-out of the input ``name``.

        Args:
            name: the input by which the command came.
            linear, angular: as in Robot.set_velocity().
            who: who gave the command, for people.
        """
        with self._turn:
            self._pass(name, linear == 0.0 == angular, who)
            self._robot.set_velocity(linear, angular, self._helm.timeout(name))

    def set_wheel_velocities(self, name: str, left: float, right: float, who: str = "") -> None:
        """Drive the wheels at these finite velocities (m/s) until the time-out of the input ``name``."""
        with self._turn:
            self._pass(name, left == 0.0 == right, who)
            self._robot.set_wheel_velocities(left, right, self._helm.timeout(name))

    def move_gripper(self, name: str, orders: Iterable[Tuple[GripperCommand, Optional[int]]], stops: bool,
                     who: str = "") -> None:
        """Send gripper commands with their values: see Robot.gripper(). ``stops``: they start no movement.

        A person who moves the gripper takes over the robot, too: it stops when a program drives it.
        """
        with self._turn:
            if not stops and self._helm.keeps_helm(name):
                self._take(name, who)
            elif not stops:
                self._check(name, False, "gripper command")
            for command, value in orders:
                self._robot.gripper(command, value)

    def request_motors(self, on: bool, timeout: float = 2.0) -> Callable[[], None]:
        """Ask the robot to switch its motors on or off: see Robot.request_motors(). Only a lock is in the way of on."""
        with self._turn:
            if on:
                for lock in self._helm.state(monotonic()).locks:
                    raise self._refused("motors on", lock)
            return self._robot.request_motors(on, timeout)

    def take(self, name: str, who: str = "", begin: Callable[[], None] = lambda: None) -> None:
        """Take the helm for an input, without a velocity: the robot stops when an input of lower priority drives it.

        Then ``begin`` is called, before any lock can be set: a lock that comes later ends what it begins. If it raises
        PioneerError, whoever had the helm before still has it.
        """
        with self._turn:
            holder = self._helm.state(monotonic()).holder
            self._take(name, who)
            try:
                begin()
            except PioneerError:
                if not holder:
                    self._release()
                raise

    def release(self) -> str:
        """Take the helm from the input that has it, and return the name of that input. The robot stops first."""
        with self._turn:
            holder = self._helm.state(monotonic()).holder
            if holder:
                self._release()
            return holder

    def lock(self, name: str) -> None:
        """Set a lock: stop the robot and a gripper that moves, and let nothing else through until unlock().

        A request to switch the motors on that is still open is taken back. Motors that are on stay on.
        """
        with self._turn:
            was_set = name in self._helm.state(monotonic()).locks
            self._helm.lock(name)
            self._robot.stop()
            if was_set:
                return
            self._tell()
            state, identity = self._robot.state, self._robot.identity
            try:
                if identity is not None and identity.has_gripper:
                    self._robot.gripper(GripperCommand.HALT)
                if state is not None and not state.motors_enabled:
                    self._robot.request_motors(False)
            except PioneerError:    # no link: nothing moves by us, and each connection begins with a stop
                pass

    def unlock(self, name: str) -> None:
        """Take a lock away. Nothing moves by that, until an input commands anew."""
        with self._turn:
            self._helm.unlock(name)
            self._tell()

    def look(self) -> None:
        """Call on_change if the commander has been silent for too long meanwhile."""
        with self._turn:
            self._tell()

    def _release(self) -> None:
        self._robot.stop()
        self._helm.release()
        self._tell()

    def _take(self, name: str, who: str) -> None:
        takes_over = self._helm.takes_over(name, monotonic())
        self._pass(name, False, who)
        if takes_over:
            self._robot.stop()

    def _pass(self, name: str, stands: bool, who: str) -> None:
        """Take note of a velocity of an input. Raises RefusedError when it may not pass. ``stands``: it is a stop."""
        self._check(name, stands, name)
        self._helm.command(name, monotonic(), who)
        self._tell()

    def _check(self, name: str, stands: bool, what: str) -> None:
        now = monotonic()
        obstacle = self._helm.obstacle(name, now)
        if obstacle is not None and not (stands and obstacle in self._helm.state(now).locks):
            raise self._refused(what, obstacle)

    def _refused(self, what: str, obstacle: str) -> RefusedError:
        return RefusedError("%s refused: %s" % (what, self._obstacles.get(obstacle, "%s goes before" % obstacle)))

    def _tell(self) -> None:
        state = self._helm.state(monotonic())
        if state != self._told:
            self._told = state
            self._on_change()

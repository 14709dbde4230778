"""One world with any number of robots in one simulated time. Robots detect each other by sonar, and collide.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world import load_world
>>> simulation = Simulation(load_world("office"))
>>> first = simulation.add(find_model("p3dx-sh"))
>>> second = simulation.add(find_model("amigo-sh"), pose=(2.0, 3.0, 0.0))
>>> second.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> [sent.hex() for sent in simulation.advance(0.1)]
['', 'fafb03000000']

This file uses no threads, no sockets and no real time. The same bytes at the same simulated times always give the same
answers. It does not matter into how many calls the time is split.
"""

from dataclasses import replace
from typing import Any, Callable, List, Optional, Union

from ..errors import ParameterError
from ..robots import RobotModel
from .clock import NEVER_US, Clock
from .firmware import Firmware
from .hardware import load_numbers
from .world import World, random_places, standing_places
from .world.crowd import Crowd
from .world.generated import with_unmapped, with_walkers
from .world.people import people_of
from .world.poses import Pose

MOST_ROBOTS = 2000
"""Largest number of robots that the command line and the ROS node accept."""

RANDOM = "random"
"""Start of robots that stand at random places."""


class Simulation:
    """Robots that share one world and one simulated time.

    Each robot is a `Firmware`. Its method `receive` takes bytes of a client, but only this class may let time pass.

    Args:
        world: the world. No other simulation may use it from now on.

    Raises:
        WorldError: a person who walks in the world has no room for it.
    """

    def __init__(self, world: World):
        self.world = world
        world.crowd = Crowd()
        self.people = people_of(world)
        """The people who walk in the world."""
        for person in self.people:
            world.crowd.enter(person)
        self.clock = Clock()
        self.robots: List[Firmware] = []
        self._walked_us = 0
        self.next_step_us = NEVER_US
        self.on_step: List[Callable[[int], None]] = []
        """Functions that are called with the simulated time (microseconds) after each step of robots."""

    def add(self, model: RobotModel, pose: Optional[Pose] = None, **options: Any) -> Firmware:
        """Add a robot, which is switched on now.

        Args:
            model: model of the robot.
            pose: start pose (m, rad; map frame). The next start of the world if None.
            options: other arguments of `Firmware`.

        Raises:
            ParameterError: the robot would overlap an obstacle, the world has no start left, or `Firmware` raises it.
        """
        if pose is None:
            if len(self.robots) >= len(self.world.starts):
                raise ParameterError("the world %r has %s starts: say where robot %s is to stand"
                                     % (self.world.name, len(self.world.starts), len(self.robots) + 1))
            pose = self.world.starts[len(self.robots)]
        robot = Firmware(model, self.world, pose, clock=self.clock, **options)
        self.world.crowd.enter(robot.hardware.body)
        self.robots.append(robot)
        self.next_step_us = min(self.next_step_us, robot.next_step_us)
        return robot

    def advance(self, seconds: float) -> List[bytes]:
        """Let simulated time pass for all robots.

        Args:
            seconds: duration, at least 0. A fraction of a microsecond is kept, and added in the next call.

        Returns:
            The bytes that each robot has sent, in the order of `robots`.
        """
        self.run_to(self.clock.after(seconds))
        return [robot.take_sent() for robot in self.robots]

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass for all robots until `end_us` (microseconds).

        The method `take_sent` of each robot then returns the bytes that the robot has sent.
        """
        while self.next_step_us <= end_us:  # all robots finish one step before any robot begins the next step
            now_us = self.clock.now_us = self.next_step_us
            self.next_step_us = NEVER_US
            for robot in self.robots:
                if robot.next_step_us <= now_us:
                    robot.step()
                if robot.next_step_us < self.next_step_us:
                    self.next_step_us = robot.next_step_us
            if self.people:
                self._walk(now_us)
            for look in self.on_step:
                look(now_us)
        self.clock.now_us = end_us

    def _walk(self, now_us: int) -> None:
        """Let all people walk until `now_us` (microseconds), and count the touches of robots."""
        passed, self._walked_us = (now_us - self._walked_us) * 1e-6, now_us
        for person in self.people:
            for body in person.step(passed):
                for robot in self.robots:
                    if robot.hardware.body is body:
                        robot.hardware.touched_by_person()


def prepared(
    world: World, model: RobotModel, count: int, seed: int, start: Union[Pose, str, None] = None, unmapped: int = 0,
    walkers: int = 0,
) -> World:
    """Return a world with what the command line and the ROS node add to it.

    Args:
        world: the world. It is not changed.
        model: model of the robots.
        count: number of robots.
        seed: random seed of everything that is drawn here.
        start: pose (m, rad; map frame) of the first robot, or `RANDOM` for random poses of all robots. None for the
            starts of the world.
        unmapped: number of obstacles to add that are on no map.
        walkers: number of people to add who walk to random places.

    Raises:
        ParameterError: the world has no room for all robots.
    """
    if isinstance(start, str):      # RANDOM
        world = world.changed(starts=random_places(world, model, count, seed))
    elif start is not None:
        world = world.with_start(start)
    if unmapped:
        world = with_unmapped(world, unmapped, seed)
    return with_walkers(world, walkers, seed) if walkers else world


def simulate(
    world: World, model: RobotModel, count: int, name: Optional[str], seed: int, numbers_file: Optional[str] = None,
    real: bool = False, serial: Optional[str] = None, **options: Any,
) -> Simulation:
    """Return a simulation with robots of one model, for the command line and the ROS node.

    Args:
        world: world in which the robots stand.
        model: model of all robots.
        count: number of robots.
        name: name of a single robot. Several robots have this name with a number: ``NAME_0001``, ``NAME_0002`` and so
            on. If None, the names are ``sim_0001``, ``sim_0002`` and so on.
        seed: random seed of the first robot. Each next robot has the next seed.
        numbers_file: file that overrides numbers of ``robot.yaml``. None if there is none.
        real: whether wheels and sonar err as those of real robots, by the seed of each; see `hardware.real_numbers`.
        serial: serial number that all robots tell. That of the numbers if None.
        options: other arguments of `Firmware`.

    Raises:
        ParameterError: the world has no room for all robots, the file is not legal, or `Firmware` raises it.
    """
    simulation = Simulation(world)
    numbers = load_numbers(numbers_file)
    for number, pose in enumerate(standing_places(world, model, count)):
        called = name if name and count == 1 else "%s_%04d" % (name or "sim", number + 1)
        if real:
            numbers = load_numbers(numbers_file, seed + number)
        if serial is not None:
            numbers = replace(numbers, session=replace(numbers.session, serial=serial))
        simulation.add(model, pose, name=called, seed=seed + number, numbers=numbers, **options)
    return simulation

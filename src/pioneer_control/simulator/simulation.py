"""One world with any number of robots in one simulated time: they see each other with their sonar and bump into each
other.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world import load_world
>>> simulation = Simulation(load_world("office"))
>>> first = simulation.add(find_model("p3dx-sh"))
>>> second = simulation.add(find_model("amigo-sh"), pose=(2.0, 3.0, 0.0))
>>> second.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> [sent.hex() for sent in simulation.advance(0.1)]
['', 'fafb03000000']

No thread, clock or socket is in here: the same bytes at the same simulated times give the same answers however the
time is split.
"""

from typing import Any, List, Optional

from ..errors import ParameterError
from ..robots import RobotModel
from .clock import NEVER_US, Clock
from .firmware import Firmware
from .world import World, standing_places
from .world.crowd import Crowd
from .world.poses import Pose

MOST_ROBOTS = 2000
"""Most robots that can be asked for by number."""


class Simulation:
    """Robots that share a world. Each is a `Firmware`: give it bytes with `receive`, but let time pass here only.

    Args:
        world: the `World`, from now on this simulation's alone.
    """

    def __init__(self, world: World):
        self.world = world
        world.crowd = Crowd()
        self.clock = Clock()
        self.robots: List[Firmware] = []
        self.next_step_us = NEVER_US

    def add(self, model: RobotModel, pose: Optional[Pose] = None, **options: Any) -> Firmware:
        """Add a robot, switched on now.

        Args:
            model: which robot.
            pose: where it stands (x, y, heading; map frame); the world's next start if None.
            options: whatever else `Firmware` takes.

        Raises:
            ParameterError: it would stand in something, or the world has no start left.
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
        """Let simulated time pass for all.

        Args:
            seconds: from 0 up; microseconds count, fractions of them are carried over to the next call.

        Returns:
            What each robot sent meanwhile, in the order of `robots`.
        """
        self.run_to(self.clock.after(seconds))
        return [robot.take_sent() for robot in self.robots]

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass for all until `end_us`; what they send meanwhile is kept for their `take_sent`."""
        while self.next_step_us <= end_us:  # all take the step of one moment before any takes that of the next
            now_us = self.clock.now_us = self.next_step_us
            for robot in self.robots:
                if robot.next_step_us <= now_us:
                    robot.step()
            self.next_step_us = min([robot.next_step_us for robot in self.robots])
        self.clock.now_us = end_us


def simulate(world: World, model: RobotModel, count: int, name: Optional[str], seed: int, **options: Any) -> Simulation:
    """Robots of one model in a world, as the command line and the ROS node offer them.

    Args:
        name: of a robot alone; several are numbered, ``NAME_0001`` and up, ``sim_0001`` and up if None.
        seed: of the first one; each has another.
        options: whatever else `Firmware` takes.

    Raises:
        ParameterError: they cannot all stand there, or `Firmware` raises it.
    """
    simulation = Simulation(world)
    for number, pose in enumerate(standing_places(world, model, count)):
        called = name if name and count == 1 else "%s_%04d" % (name or "sim", number + 1)
        simulation.add(model, pose, name=called, seed=seed + number, **options)
    return simulation

"""Many robots that navigate in one world, without ROS: do they touch, also when their answers come late?

    python3 bench/navigation_crowd.py --seeds 1001-1002 --late 0 0.15 0.3 --answered 0.7

Each robot knows the map, finds its pose with its sonar, and drives from one place drawn by chance to the next. *late*
is the mean time from a packet to its answer, besides the usual 0.08 s: half of it before the answer is made,
half after. *answered* is the share of packets that are answered at all. So it is on a computer that has too much to do.
"""

import argparse
import random
import sys
from collections import Counter
from multiprocessing import Pool
from typing import List, NamedTuple, Tuple

from simulated_robot import Setup, SimulatedRobot
from navigation_cases import numbers_of, seeds_of
from navigation_drive import chassis_of, goals_of, set_accelerations

from pioneer_control.floor_poses import Pose
from pioneer_control.maps.floor_map import FloorMap
from pioneer_control.navigation.node.map_files import floor_map_of
from pioneer_control.navigation.navigator import Readiness, State
from pioneer_control.navigation.pilot import Pilot
from pioneer_control.navigation.senses import Senses
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import World, load_world, standing_places
from pioneer_control.simulator.world.crowd import Crowd

GOALS = 40      # among which each robot chooses
VERY_LATE = 0.02    # share of answers that take twice as long


class Crowded(NamedTuple):
    """What to run."""

    seed: int
    world: str
    model: str
    robots: int
    seconds: float
    late: float
    answered: float


class Member:
    """One robot among the others."""

    def __init__(self, what: Crowded, world: World, floor: FloorMap, number: int, start: Pose) -> None:
        seed = 1000 * what.seed + number
        self.robot = SimulatedRobot(Setup(what.model, numbers=numbers_of(seed, 40.0)), world, seed)
        self.robot.firmware.hardware.carry(start)
        world.crowd.enter(self.robot.firmware.hardware.body)
        chassis = chassis_of(self.robot)
        self.pilot = Pilot(floor, chassis, seed=seed)
        self.pilot.start_at(start)
        set_accelerations(self.robot, self.pilot.accelerations)
        self._what, self._luck = what, random.Random(seed)
        self._goals = goals_of(floor.grid, chassis, start[:2], GOALS, self._luck)
        self._senses = Senses([each.number for each in chassis.transducers])
        self._answers: List[Tuple[float, float, float]] = []    # when each reaches the robot (s), and its velocity
        self.states: Counter = Counter()
        self.reached = 0

    def step(self) -> None:
        """Let the robot live until its next packet, and tell it the newest answer that has come."""
        snapshot = self.robot.listen()
        if self._luck.random() < self._what.answered:
            self._senses.hear_sonar(snapshot.time, snapshot.ranges)
            late = self._luck.uniform(0.5, 1.5) * self._what.late * (1 + (self._luck.random() < VERY_LATE))
            for sensing in self._senses.hear_pose(snapshot.time, snapshot.pose):
                step = self.pilot.sense(sensing, Readiness(late=late / 2.0))
                self.states[step.state.value] += 1
                self.reached += step.state is State.REACHED
                self._answers.append((snapshot.time + late, *step.twist))
            if step.goal is None:
                self.pilot.go_to(self._luck.choice(self._goals))
        come = [answer for answer in self._answers if answer[0] <= snapshot.time + 1e-6]
        if come:
            self._answers = self._answers[len(come):]
            self.robot.command(*come[-1][1:])


def run(what: Crowded) -> str:
    """Return what became of one crowd, for people."""
    world, model = load_world(what.world), find_model(what.model)
    starts = standing_places(world, model, what.robots)
    world.crowd = Crowd()
    floor = floor_map_of(world)
    # The last one first: each begins at the first start, and is carried away.
    members = [Member(what, world, floor, number, Pose(*starts[number])) for number in reversed(range(what.robots))]
    while members[-1].robot.firmware.time < what.seconds:
        for member in members:
            member.step()
    states = sum((member.states for member in members), Counter())
    return "%s: %d contacts, %d goals reached, %s" % (
        what, sum(member.robot.firmware.contacts for member in members), sum(member.reached for member in members),
        ", ".join("%.0f %% %s" % (100.0 * count / sum(states.values()), state)
                  for state, count in states.most_common()))


def main() -> int:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1001-1002", help="first-last")
    parser.add_argument("--world", default="classroom")
    parser.add_argument("--model", default="p3dx-sh")
    parser.add_argument("--robots", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=100.0)
    parser.add_argument("--late", type=float, nargs="+", default=[0.0, 0.15, 0.3], help="s")
    parser.add_argument("--answered", type=float, default=0.7)
    options = parser.parse_args()
    cases = [Crowded(seed, options.world, options.model, options.robots, options.seconds, late, options.answered)
             for seed in seeds_of(options.seeds) for late in options.late]
    with Pool() as pool:
        for line in pool.imap_unordered(run, cases):
            print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

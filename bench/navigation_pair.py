"""Two robots that meet in a corridor: do they pass, or does one wait, and do they touch?

    python3 bench/navigation_pair.py --seeds 1000-1019

Each drives from one end of a corridor 2 m wide to the other end, with sonar and wheels that err, at 0.4 m/s.
"""

import argparse
import random
import sys
from typing import List, Tuple

from simulated_robot import CYCLE, Setup, SimulatedRobot
from navigation_cases import MODELS, numbers_of, seeds_of
from navigation_drive import TruePlace, chassis_of, set_accelerations
from navigation_wanders import map_of

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.navigator import Navigator, Readiness
from pioneer_control.simulator.world import World

LENGTH, WIDTH = 12.0, 2.0   # m
LONGEST = 240.0     # s


def run(seed: int) -> Tuple[List[str], int, float]:
    """Return how both ended, their contacts, and the time (s)."""
    luck = random.Random("pair %s" % seed)
    corners = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH)]
    starts = [(1.0, luck.uniform(0.7, 1.3), 0.0), (LENGTH - 1.0, luck.uniform(0.7, 1.3), 3.14)]
    world = World("corridor", [a + b for a, b in zip(corners, corners[1:] + corners[:1])], starts=starts)
    grid_map = map_of(world)
    robots, navigators = [], []
    for number in (1, 0):       # the second first, as each robot begins at the first start and is carried away
        setup = Setup(MODELS[(seed + number) % len(MODELS)], numbers=numbers_of(2 * seed + number, 40.0))
        robot = SimulatedRobot(setup, world, seed + number)
        robot.firmware.hardware.carry(starts[number])
        world.crowd.enter(robot.firmware.hardware.body)
        navigator = Navigator(grid_map, chassis_of(robot))
        set_accelerations(robot, navigator.acceleration_wanted)
        goal = starts[1 - number]
        refusal = navigator.go_to(goal[0], goal[1], None, 0.0)
        assert not refusal, refusal
        robots.append(robot)
        navigators.append(navigator)
    ends = ["", ""]
    time = 0.0
    while time < LONGEST and not all(ends):
        time += CYCLE
        for number, (robot, navigator) in enumerate(zip(robots, navigators)):
            sensing = robot.sense()
            decision = navigator.step(sensing, TruePlace(Pose(*robot.firmware.true_pose)), Readiness(), sensing.time)
            robot.command(*decision.twist)
            if not ends[number] and not decision.state.has_goal:
                ends[number] = decision.reason
    return ends, sum(robot.firmware.contacts for robot in robots), time


def main() -> int:
    """Run what the command line says; exit status 1 after a contact."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1000-1019", help="first-last")
    touched = 0
    for seed in seeds_of(parser.parse_args().seeds):
        ends, contacts, time = run(seed)
        touched += contacts
        print("seed %d: %s; %d contacts, %.0f s" % (seed, ends, contacts, time), flush=True)
    print("%d contacts" % touched)
    return int(touched > 0)


if __name__ == "__main__":
    sys.exit(main())

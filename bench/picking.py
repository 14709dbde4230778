#!/usr/bin/python3
"""How surely a can is picked, and whether "held" is ever said of nothing:
a simulated gripper, through the protocol, without ROS.

    python3 bench/picking.py            # 50 seeds; each draws where the can stands, once for each case

The steps of a pick and what they make of the gripper's reports are those of the package (`tutorial.pick`). The truth is
the simulated gripper's own. Exit status 1 when a can between the paddles was not picked, or something was said falsely.
"""

import argparse
import random
import sys
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from simulated_robot import Setup, SimulatedRobot

from pioneer_control.robots import find_model
from pioneer_control.simulator.world import Can, World
from pioneer_control.tutorial.pick import CLOSE, LOWER, OPEN, PICK, Outcome, Step, holds, judge

SETUP = Setup("p3dx-sh", gripper=True)
STEP_TIMEOUT = 10.0  # s
SPEED = 0.1  # m/s
LIFTED = 0.05  # m

MODEL = find_model(SETUP.model)
PALM = MODEL.length_front + MODEL.gripper.paddle_start  # m ahead of base_link
LENGTH, OPENING = MODEL.gripper.paddle_length, MODEL.gripper.opening
RADIUS = Can(0.0, 0.0).radius

Place = Tuple[float, float]


def between(chance: random.Random) -> Place:
    """Return a place between the open paddles [m]: how far ahead of the palm, and how far to the left of the middle
    (negative: to the right).
    """
    return chance.uniform(RADIUS, LENGTH), chance.uniform(-1, 1) * (OPENING / 2 - RADIUS)


def at_the_edge(chance: random.Random) -> Place:
    """Return a place at the tips of the paddles, half inside and half outside, or a place on a paddle."""
    if chance.random() < 0.5:
        return LENGTH + chance.uniform(-RADIUS, RADIUS), chance.uniform(-1, 1) * OPENING / 2
    return chance.uniform(RADIUS, LENGTH), chance.choice((-1, 1)) * (OPENING / 2 + chance.uniform(-RADIUS, RADIUS))


def out_of_reach(chance: random.Random) -> Place:
    """Return a place ahead of the tips."""
    return LENGTH + RADIUS + chance.uniform(0.005, 0.3), chance.uniform(-0.2, 0.2)


def ahead(chance: random.Random) -> Place:
    """Return a place some way ahead. The open paddles pass on both sides of it."""
    return chance.uniform(0.3, 0.8), chance.uniform(-1, 1) * (OPENING / 2 - RADIUS - 0.005)


def nowhere(_: random.Random) -> None:
    """Return no place: there is no can."""


def robot_with_can(place: Optional[Place], seed: int) -> SimulatedRobot:
    """A robot on an empty floor, a can at a place measured from its palm."""
    cans = [] if place is None else [Can(PALM + place[0], place[1])]
    return SimulatedRobot(SETUP, World("picking", cans=cans), seed)


def do(robot: SimulatedRobot, step: Step) -> Outcome:
    """One step of the gripper, as the Pioneer class does it."""
    snapshot = robot.listen()
    outcome = judge(step, snapshot.grip, snapshot.lift, commanded=False)
    if outcome is None:
        robot.command_gripper(step.grip, step.lift)
    end = robot.firmware.time + STEP_TIMEOUT
    while outcome is None and robot.firmware.time < end:
        snapshot = robot.listen()
        outcome = judge(step, snapshot.grip, snapshot.lift, commanded=True)
    return outcome or Outcome.TIMED_OUT


class Picked(NamedTuple):
    """The result of one pick: was a can between the paddles when they began to close, is one held and lifted, and did
    the pick report that it holds one?
    """

    between: bool
    held: bool
    said: bool
    timed_out: bool


def pick(robot: SimulatedRobot) -> Picked:
    """Lower, open, close, raise."""
    was_between = False
    outcomes = []
    for step in PICK:
        if step is CLOSE:
            was_between = stands_between(robot)
        outcomes.append(do(robot, step))
    gripper = robot.firmware.gripper
    held = gripper.held_can is not None and gripper.height > LIFTED
    return Picked(was_between, held, holds(robot.listen().grip), Outcome.TIMED_OUT in outcomes)


def stands_between(robot: SimulatedRobot) -> bool:
    """Return whether a can is completely between the paddles' faces, with its middle behind their tips. The robot is at
    the origin of its line, with heading 0.
    """
    x, y, _ = robot.firmware.true_pose
    return any(0 < can.x - x - PALM <= LENGTH and abs(can.y - y) + can.radius <= OPENING / 2
               for can in robot.firmware.world.cans)


def drive_up(robot: SimulatedRobot) -> None:
    """Drive forward with open, lowered paddles until the outer beam is broken, as at the end of a wander."""
    do(robot, OPEN)
    do(robot, LOWER)
    start = robot.firmware.time
    while not robot.listen().grip.outer and robot.firmware.time - start < 15:
        robot.command(SPEED, 0.0)
    robot.command(0.0, 0.0)
    for _ in range(10):
        robot.listen()


def close_above(robot: SimulatedRobot) -> None:
    """Close the paddles above the can. The pick then lowers the closed paddles onto it."""
    do(robot, CLOSE)


def pick_before(robot: SimulatedRobot) -> None:
    """Pick the can once. The pick that is measured then puts it down, because it lowers and opens first, and picks it
    again.
    """
    pick(robot)


def nothing_before(_: SimulatedRobot) -> None:
    """Do nothing before the pick."""


class Case(NamedTuple):
    """Where the can stands, and what happens before the pick."""

    place: Callable[[random.Random], Optional[Place]]
    before: Callable[[SimulatedRobot], None] = nothing_before


CASES: Dict[str, Case] = {
    "between the paddles": Case(between),
    "driven up to": Case(ahead, drive_up),
    "held already": Case(between, pick_before),
    "at the edge": Case(at_the_edge),
    "under closed paddles": Case(between, close_above),
    "out of reach": Case(out_of_reach),
    "no can": Case(nowhere),
}


def run(case: Case, seed: int) -> Picked:
    """The pick of one case, the can where the seed draws it."""
    robot = robot_with_can(case.place(random.Random(seed)), seed)
    case.before(robot)
    return pick(robot)


def report(results: Dict[str, List[Picked]]) -> str:
    """Return the table."""
    lines = ["%-22s%8s%14s%16s%8s%12s%14s%12s" % (
        "can", "picks", "between", "of these held", "held", "said held", "said falsely", "timed out")]
    for name, picks in results.items():
        lines.append("%-22s%8d%14d%16d%8d%12d%14d%12d" % (
            name, len(picks), sum(each.between for each in picks), sum(each.between and each.held for each in picks),
            sum(each.held for each in picks), sum(each.said for each in picks),
            sum(each.said != each.held for each in picks),
            sum(each.timed_out for each in picks)))
    return "\n".join(lines)


def main() -> int:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0-49", help="first-last (default: %(default)s)")
    first, last = (int(each) for each in parser.parse_args().seeds.split("-"))
    results = {name: [run(case, seed) for seed in range(first, last + 1)] for name, case in CASES.items()}
    print(report(results))
    picks = [each for some in results.values() for each in some]
    return int(any(each.said != each.held or each.between and not each.held for each in picks))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""How safe the wander is, and how far it gets: simulated robots in drawn worlds, through the protocol, without ROS.

    python3 bench/wander.py         # 200 worlds x 10 simulated minutes x 4 robots, our rule and the original one
    python3 bench/wander.py --seeds 0-9 --minutes 2 --rule ours
    python3 bench/wander.py --seeds 1000-1055 --minutes 6 --rule ours --kinds all --speed 0.25 --specular 40

Each robot is a `Firmware`: its standard packets are decoded and put together as the driver does, one decision is taken
per packet, and its command reaches the robot 80 ms later. Contacts are those of the body's true outline with walls and
posts. What the columns mean is printed below the table. bench/wander.md has what was measured, and on which seeds.
"""

import argparse
import math
import sys
from multiprocessing import Pool
from dataclasses import replace
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from simulated_robot import CYCLE, Setup, SimulatedRobot

from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.world import World, load_world, mirrors
from pioneer_control.simulator.world.free_space import gap_open, room
from pioneer_control.simulator.world.generated import IN_TURN, KINDS, random_world
from pioneer_control.tutorial.snapshot import Snapshot
from pioneer_control.tutorial.wander import SPEED, Memory, Move, wander

FORWARD = 0.02  # m/s: faster is "moving forward"
SPOT = 0.25  # m: a minute within this of one place is a minute on one spot
GAP = 1.0  # m: what is wider is a way out
ROOM = 1.5  # m: a world has room when a robot can get about farther than this
ENOUGH = 1.0  # m per minute: less is too little in a world with room
MEDIAN = 4.5  # m per minute: wanted of half the runs at least; 6 is the most possible
MOSTLY = 75.0  # %: the share of the time wanted forward
GALLERY = ("office", "maze", "corridor", "classroom")  # the worlds of the kind "gallery", in turn
SWATH = 0.25  # m: floor this near to the path counts as covered


SETUPS: Dict[str, Setup] = {
    "p3dx-sh, gripper": Setup("p3dx-sh", gripper=True),
    "p3dx-sh, gripper, no rear sonar": Setup("p3dx-sh", gripper=True, rear_sonar=False),
    "p3at-sh": Setup("p3at-sh"),
    "amigo-sh": Setup("amigo-sh"),
}


def our_rule(seed: int, speed: float) -> Callable[[Snapshot], Move]:
    """The package's wander, at a speed (m/s)."""
    memory = Memory(seed=seed, speed=speed)

    def decide(snapshot: Snapshot) -> Move:
        nonlocal memory
        command, memory = wander(snapshot, memory)
        return command

    return decide


def original_rule(seed: int, speed: float) -> Callable[[Snapshot], Move]:
    """The tutorial's wander as it was in 2012, with nothing mended but what would end it with an exception.

    It commands once a second; "turn back" is never reached; with nothing open beyond 2 m the last command stays. Its
    choice of sonars by number is kept; unlike the original it does accept robots without sixteen of them.
    """
    last = Move(0.0, 0.0, "nothing said yet")
    next_time = 0.0

    def decide(snapshot: Snapshot) -> Move:
        nonlocal last, next_time
        if snapshot.time < next_time or not any(snapshot.ranges):
            return last
        next_time = snapshot.time + 1.0
        farthest = max(snapshot.ranges[1:7])
        if farthest > 2:
            sonar = snapshot.ranges.index(farthest)
            if sonar in (3, 4):
                last = Move(speed, 0.0, "forward")
            else:
                last = Move(0.0, 0.1 if sonar < 3 else -0.1, "turn")
        return last

    return decide


RULES = {"ours": our_rule, "original": original_rule}


class Circumstances(NamedTuple):
    """What is equal for all runs of a table."""

    minutes: float
    speed: float = SPEED  #: m/s
    specular_deg: int = 90  #: sound that meets a wall at a greater angle than this to its normal bounces away
    kinds: Tuple[str, ...] = IN_TURN  #: of worlds, that seeds take in turn
    corners: float = mirrors.SCATTERED  #: m: how far ends and corners of slanting walls are heard


class Run(NamedTuple):
    """The result of one robot in one world."""

    setup: str
    rule: str
    seed: int
    world: str
    contacts: int
    distance: float  #: m
    forward: float  #: share of the time
    stuck_minutes: int
    has_room: bool
    area: float  #: m^2
    first_contact: Optional[Tuple[float, str, Tuple[float, float, float]]]  #: when, the reason of the command, where


def world_of(seed: int, kinds: Sequence[str]) -> World:
    """The world of a seed: of each kind in turn."""
    kind = kinds[seed % len(kinds)]
    return load_world(GALLERY[seed // len(kinds) % len(GALLERY)]) if kind == "gallery" else random_world(seed, kind)


def drive(setup: str, rule: str, seed: int, given: Circumstances) -> Run:
    """Let one robot wander in the world of a seed."""
    mirrors.SCATTERED = given.corners
    world, minutes = world_of(seed, given.kinds), given.minutes
    numbers = standard_numbers()
    numbers = replace(numbers, sonar=replace(numbers.sonar, specular_deg=given.specular_deg))
    robot = SimulatedRobot(SETUPS[setup]._replace(numbers=numbers), world, seed)
    decide = RULES[rule](seed, given.speed)
    path = [robot.firmware.true_pose]
    first_contact = None
    forward = 0
    while robot.firmware.time < minutes * 60 - CYCLE / 2:
        command = decide(robot.listen())
        robot.command(command.linear, command.angular)
        path.append(robot.firmware.true_pose)
        forward += robot.firmware.velocity[0] > FORWARD
        if first_contact is None and robot.firmware.contacts:
            first_contact = (robot.firmware.time, command.reason, path[-1])
    return Run(
        setup, rule, seed, world.name, robot.firmware.contacts, length(path), forward / (len(path) - 1),
        stuck_minutes(world, path),
        room(world, *path[0][:2]) > ROOM, covered(path), first_contact,
    )


def length(path) -> float:
    """Of a path of (x, y, ...) [m]."""
    return sum(math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(path, path[1:]))


def stuck_minutes(world, path) -> int:
    """Whole minutes spent within SPOT of one place from which a way wider than GAP leads out."""
    minute = round(60 / CYCLE)
    stuck = 0
    for start in range(0, len(path) - minute, minute):
        xs, ys = zip(*(pose[:2] for pose in path[start:start + minute]))
        x, y = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
        if all(math.hypot(px - x, py - y) <= SPOT for px, py in zip(xs, ys)) and gap_open(world, x, y, width=GAP):
            stuck += 1
    return stuck


def covered(path, cell: float = 0.1) -> float:
    """Area [m^2] of the floor within SWATH of the path, in cells of 0.1 m."""
    reach = math.ceil(SWATH / cell)
    near = [(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)
            if math.hypot(i, j) * cell <= SWATH]
    visited = {(round(x / cell), round(y / cell)) for x, y, _ in path}
    return len({(x + i, y + j) for x, y in visited for i, j in near}) * cell * cell


HEADINGS = ("contacts", "in worlds", "median m", "worst m", "forward %", "short", "stuck min", "area m2")
LEGEND = """
contacts   collisions of the body's true outline with walls or posts, and in how many worlds
median m, worst m   distance driven;  forward %%   share of the time at more than %(forward)g m/s ahead
short      worlds with room (more than %(room)g m across at 0.5 m clearance)
           in which it drove less than %(enough)g m per minute
stuck min  minutes within %(spot)g m of one spot from which a way wider than %(gap)g m leads out
area m2    floor within %(swath)g m of the path (mean)""" % dict(
    forward=FORWARD, room=ROOM, enough=ENOUGH, spot=SPOT, gap=GAP, swath=SWATH)


def summary(runs: List[Run], minutes: float) -> Tuple:
    """The figures of one row, in the order of HEADINGS."""
    distances = sorted(run.distance for run in runs)
    return (
        sum(run.contacts for run in runs), sum(run.contacts > 0 for run in runs), distances[len(distances) // 2],
        distances[0],
        100 * sum(run.forward for run in runs) / len(runs), sum(too_short(run, minutes) for run in runs),
        sum(run.stuck_minutes for run in runs), sum(run.area for run in runs) / len(runs),
    )


def satisfies(runs: List[Run], given: Circumstances) -> bool:
    """Is that what is wanted of a wander: no contact, no minute wasted, far enough at this speed, mostly forward?"""
    contacts, _, median, _, forward, short, stuck, _ = summary(runs, given.minutes)
    far = median >= MEDIAN * given.minutes * given.speed / SPEED
    return far and not (contacts or short or stuck) and forward >= MOSTLY


def too_short(run: Run, minutes: float) -> bool:
    """Did it get nowhere although there was room?"""
    return run.has_room and run.distance < ENOUGH * minutes


def report(runs: List[Run], minutes: float) -> str:
    """The table: one row per robot and rule."""
    lines = ["%-33s %-9s" % ("robot", "rule") + "".join("%11s" % heading for heading in HEADINGS)]
    for setup in SETUPS:
        for rule in RULES:
            mine = [run for run in runs if (run.setup, run.rule) == (setup, rule)]
            if mine:
                figures = ["%11d" % each if isinstance(each, int) else "%11.1f" % each
                           for each in summary(mine, minutes)]
                lines.append("%-33s %-9s" % (setup, rule) + "".join(figures))
    return "\n".join(lines)


def main() -> int:
    """Run what the command line says; exit status 1 when our rule misses what is wanted of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="200-399", help="first-last (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=10.0,
                        help="simulated minutes per world (default: %(default)s)")
    parser.add_argument("--rule", choices=["ours", "original", "both"], default="both")
    parser.add_argument("--robots", default="",
                        help="only the setup of this name, or those whose name starts so, several by ';'")
    parser.add_argument("--speed", type=float, default=SPEED, help="m/s (default: %(default)s, the tutorial's)")
    parser.add_argument("--specular", type=int, default=90, metavar="DEG",
                        help="sound that meets a wall at a greater angle than this bounces away (default: %(default)s)")
    parser.add_argument("--corners", type=float, default=mirrors.SCATTERED, metavar="M",
                        help="how far ends and corners of slanting walls are heard (default: %(default)s)")
    parser.add_argument("--kinds", default=",".join(IN_TURN),
                        help="kinds of worlds that seeds take in turn, with commas between them; gallery: %s; all:"
                             " those and all that are drawn (default: %%(default)s)" % ", ".join(GALLERY))
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    first, last = (int(each) for each in options.seeds.split("-"))
    rules = list(RULES) if options.rule == "both" else [options.rule]
    setups = [name for name in SETUPS for each in options.robots.split(";")
              if name == each or each not in SETUPS and name.startswith(each)]
    kinds = sorted(KINDS) + ["gallery"] if options.kinds == "all" else options.kinds.split(",")
    given = Circumstances(options.minutes, options.speed, options.specular, tuple(kinds),
                          options.corners)
    jobs = [(setup, rule, seed, given) for setup in setups for rule in rules
            for seed in range(first, last + 1)]
    runs: List[Run] = []
    with Pool(options.processes) as pool:
        for run in pool.imap_unordered(_drive, jobs):
            runs.append(run)
            if run.rule == "ours" and (run.contacts or run.stuck_minutes or too_short(run, options.minutes)):
                print(run, flush=True)
            elif len(runs) % 50 == 0:
                print("%d of %d runs" % (len(runs), len(jobs)), file=sys.stderr, flush=True)
    print("worlds of seeds %s, %g simulated minutes each, %g m/s, specular %d degrees, corners %g m, %s" % (
        options.seeds, options.minutes, options.speed, options.specular, options.corners, ", ".join(kinds)))
    print(report(runs, options.minutes))
    print(LEGEND)
    ours = [[run for run in runs if (run.setup, run.rule) == (setup, "ours")] for setup in setups]
    return int(not all(satisfies(some, given) for some in ours if some))


def _drive(job) -> Run:
    return drive(*job)


if __name__ == "__main__":
    sys.exit(main())

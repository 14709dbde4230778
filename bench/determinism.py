#!/usr/bin/env python3
"""Everything that four robots in the office send in an hour, as one hash:
the same on every computer, in every process, however time is split.

    python3 bench/determinism.py                        # an hour of simulated time: half a minute
    PYTHONHASHSEED=7 python3 bench/determinism.py --split 7

They drive, turn, bump into walls and each other, push and grip cans, and are asked for every packet there is, as one
seed draws it. test/unit/simulator/test_determinism.py holds a short run to a hash;
bench/simulator.md has that of an hour.
"""

import argparse
import hashlib
import pathlib
import random
import sys
import time
from typing import List, Tuple

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "src"))

from pioneer_control import p2os
from pioneer_control.robots import find_model
from pioneer_control.simulator.world import load_world, standing_places
from pioneer_control.simulator.simulation import Simulation

MODELS = ("p3dx-sh", "p3at-sh", "amigo-sh", "p2dx")
OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
COMMANDS = (    # and least and greatest of each value; those that drive come more often
    ("VEL", (-200, 500)), ("VEL", (100, 400)),
    ("RVEL", (-90, 90)), ("RVEL", (-30, 30)),
    ("VEL2", (-10, 25), (-10, 25)),
    ("MOVE", (-800, 1500)), ("DHEAD", (-180, 180)), ("HEAD", (0, 359)),
    ("SETV", (100, 800)), ("SETRV", (20, 150)), ("SETA", (100, 900)), ("SETRA", (30, 200)),
    ("GRIPPER", (1, 6)), ("GRIPPER", (1, 11)),
    ("DIGOUT", (0, 255), (0, 255)), ("ADSEL", (0, 7)),
    ("ENCODER", (0, 2)), ("IOREQUEST", (0, 2)), ("GRIPREQUEST", (0, 2)), ("BATTERYINFO", (0, 2)),
    ("SONARCYCLE", (20, 60)),
    ("CONFIG",), ("STOP",), ("E_STOP",), ("SETO",), ("ENABLE", (1, 1)),
)


def robots_in_the_office() -> Simulation:
    """One of each model, synchronised and opened."""
    world = load_world("office")
    simulation = Simulation(world)
    for seed, (name, pose) in enumerate(zip(MODELS, standing_places(world, find_model(MODELS[0]), len(MODELS)))):
        simulation.add(find_model(name), pose, seed=seed).receive(OPEN)
    return simulation


def command(rng: random.Random) -> bytes:
    """Return one of the commands, with values for it."""
    name, *ranges = COMMANDS[int(rng.random() * len(COMMANDS))]
    return p2os.encode_command(name, *(low + int(rng.random() * (high - low + 1)) for low, high in ranges))


def everything_sent(minutes: float, parts: int = 1, seed: int = 4) -> Tuple[str, List[int]]:
    """Return the hash of all that the robots send, and how often each of them hit something.

    Each tenth of a second passes in so many parts.
    """
    simulation, rng, total = robots_in_the_office(), random.Random(seed), hashlib.sha256()
    for _ in range(round(minutes * 600)):
        for robot in simulation.robots:
            if rng.random() < 0.2:
                robot.receive(command(rng))
        sent = [b""] * len(simulation.robots)
        for part in range(parts):
            sent = [before + now for before, now in zip(sent, simulation.advance(0.1 / parts))]
        for some in sent:
            total.update(some)
    return total.hexdigest(), [robot.contacts for robot in simulation.robots]


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0, help="of simulated time (default: %(default)s)")
    parser.add_argument("--split", type=int, default=1, metavar="N", help="let each tenth of a second pass in N parts")
    options = parser.parse_args()
    begin = time.process_time()
    digest, contacts = everything_sent(options.minutes, options.split)
    print("%s  %g minutes, contacts %s, %.1f s" % (digest, options.minutes, contacts, time.process_time() - begin))


if __name__ == "__main__":
    main()

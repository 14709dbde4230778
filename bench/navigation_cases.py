"""The cases of bench/navigation.py: which world, robot and luck belong to a seed.

Seeds 1000 to 1999 are for tuning. Seeds from 2000 on are for accepting: they are run once, 200 at a time.
"""

import random
from dataclasses import replace
from typing import List, NamedTuple

from simulated_robot import Setup

from pioneer_control.simulator.hardware.robot_numbers import RobotNumbers, standard_numbers
from pioneer_control.simulator.world import World, load_world
from pioneer_control.simulator.world.generated import KINDS, random_world

GALLERY = ("office", "maze", "corridor", "classroom")
MODELS = ("p3dx-sh", "p3at-sh", "amigo-sh")


class Case(NamedTuple):
    """What belongs to one seed."""

    seed: int
    world: World
    setup: Setup


def kinds() -> List[str]:
    """Return the kinds of worlds, in the order in which seeds take them."""
    return sorted(KINDS) + ["gallery"]


def case(seed: int, specular_deg: float = 40.0) -> Case:
    """Return the world, the robot and its errors of a seed. Kinds of worlds and models of robots come in turn."""
    kind = kinds()[seed % len(kinds())]
    number = seed // len(kinds())
    world = load_world(GALLERY[number % len(GALLERY)]) if kind == "gallery" else random_world(seed, kind)
    return Case(seed, world, Setup(MODELS[number % len(MODELS)], numbers=real_numbers(seed, specular_deg)))


def real_numbers(seed: int, specular_deg: float) -> RobotNumbers:
    """Return numbers of a robot whose wheels and sonar err as those of real ones do, drawn from a seed."""
    luck, numbers = random.Random("real %s" % seed), standard_numbers()
    return replace(
        numbers,
        wheels=replace(numbers.wheels, larger=luck.uniform(-0.03, 0.03), right_larger=luck.uniform(-0.006, 0.006),
                       wider_apart=luck.uniform(-0.05, 0.05), slip=0.03, noise=0.004),
        sonar=replace(numbers.sonar, noise=0.02, specular_deg=specular_deg))

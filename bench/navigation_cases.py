"""The cases of bench/navigation.py: which world, robot and luck belong to a seed.

Seeds 1000 to 1999 are for tuning. Seeds from 2000 on are for accepting: they are run once, 200 at a time.
"""

from dataclasses import replace
from typing import List, NamedTuple

from simulated_robot import Setup

from pioneer_control.simulator.hardware import RobotNumbers, real_numbers, standard_numbers
from pioneer_control.simulator.world import World, load_world
from pioneer_control.simulator.world.generated import KINDS, random_world

GALLERY = ("office", "maze", "corridor", "classroom")
MODELS = ("p3dx-sh", "p3at-sh", "amigo-sh")


class Case(NamedTuple):
    """What belongs to one seed."""

    seed: int
    world: World
    setup: Setup


def seeds_of(text: str) -> List[int]:
    """Return the seeds that a text names: one, first-last, or several of these by ','."""
    seeds: List[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def kinds() -> List[str]:
    """Return the kinds of worlds, in the order in which seeds take them."""
    return sorted(KINDS) + ["gallery"]


def case(seed: int, specular_deg: float = 40.0) -> Case:
    """Return the world, the robot and its errors of a seed. Kinds of worlds and models of robots come in turn."""
    kind = kinds()[seed % len(kinds())]
    number = seed // len(kinds())
    world = load_world(GALLERY[number % len(GALLERY)]) if kind == "gallery" else random_world(seed, kind)
    return Case(seed, world, Setup(MODELS[number % len(MODELS)], numbers=numbers_of(seed, specular_deg)))


def numbers_of(seed: int, specular_deg: float) -> RobotNumbers:
    """Return numbers of a robot whose wheels and sonar err as those of real ones do, with walls of a smoothness."""
    numbers = real_numbers(standard_numbers(), seed)
    return replace(numbers, sonar=replace(numbers.sonar, specular_deg=specular_deg))

"""What light meets: a laser sees some materials badly, or not at all. Sonar hears all of them alike."""

from enum import IntEnum
from typing import Dict


class Material(IntEnum):
    """What the surface of a wall, a post or a body is made of. How much light each returns, `LaserNumbers` says."""

    PLAIN = 0
    """A wall as usual."""
    DARK = 1
    """Black cloth, dark plastics: seen only when it is near."""
    GLASS = 2
    """A pane: light goes through, and comes back from it only squarely."""
    MIRROR = 3
    """Light is reflected, so that a laser sees what is before the mirror as if it was behind it."""
    REFLECTOR = 4
    """Retro-reflecting foil: bright from every side. Lasers mark its values."""
    ROBOT = 5
    """The body of a robot."""
    PERSON = 6
    """A person."""
    LASER = 7
    """The body of a robot with a laser that is on. Its light may dazzle another laser."""


BUILT: Dict[str, Material] = {
    material.name.lower(): material
    for material in (Material.PLAIN, Material.DARK, Material.GLASS, Material.MIRROR, Material.REFLECTOR)}
"""Materials of walls and posts, by the words that a world file has for them."""

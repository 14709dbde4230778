"""The floor that simulated robots stand on. Open ``world`` first: walls, posts, cans and poses, and all questions
about them.

``geometry``      outlines and points against walls and posts
``poses``         one pose seen from another, outlines where they stand; the same to the last bit on every computer
``echoes``        what sonar hears: the nearest point of anything solid in a cone
``crowd``         the bodies of robots, found by place; ``pushing``: how robots push cans
``grids``         what a grid of cells tells of a floor; ``start_poses``: where many robots can stand at first
``world_loader``  worlds by name or path: of our own form, or by ``ros_map`` or ``aria_map``; ``yaml_nodes`` reads YAML

Metres, radians, map frame (REP 103).
"""

from .start_poses import standing_places
from .world import Can, World
from .world_loader import known_worlds, load_world

__all__ = ["Can", "World", "known_worlds", "load_world", "standing_places"]

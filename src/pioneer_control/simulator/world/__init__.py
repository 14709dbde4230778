"""The floor that simulated robots stand on. Open ``world`` first: walls, posts, cans and poses, and all questions
about them.

``geometry``      tests and distances between outlines or points and walls or posts
``poses``         transforms of poses and outlines between frames, equal to the last bit on every computer
``echoes``        the range that sonar measures: the distance to the nearest point of anything solid in its cone
``mirrors``       the same among walls that return no echo to sound that meets them at a slant
``rays``          where rays of light end: at walls, posts and bodies; ``materials``: what light finds there
``crowd``         the bodies of robots, found by place; ``pushing``: how robots push cans
``generated``     draws worlds from seeds; ``offices``: one kind of them; ``furnishing``: puts obstacles on a floor
``people``        people who walk about
``free_space``    how much floor a robot can use
``grids``         borders and free areas of a grid of cells; ``start_poses``: where many robots can stand at first
``world_loader``  loads worlds of our own format; ``ros_map`` and ``aria_map``: other maps

Lengths are in metres, angles in radians, coordinates in the map frame (REP 103).
"""

from .start_poses import random_places, standing_places
from .world import Can, World
from .world_loader import known_worlds, load_world

__all__ = ["Can", "World", "known_worlds", "load_world", "random_places", "standing_places"]

"""Maps of a floor: the grid of cells that navigation and RViz use. No ROS, no robots.

``grid_map``  the grid, and which cell is where
"""

from .grid_map import FREE, OCCUPIED, UNKNOWN, GridMap

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "GridMap"]

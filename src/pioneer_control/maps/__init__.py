"""Maps of a floor: the grid of cells that navigation and RViz use. No ROS, no robots.

``grid_map``    the grid, and which cell is where
``floor_map``   a grid with named places and forbidden lines; ``goals_file``: places in a file beside the map
``ros_map``     reads and writes the files of ROS's map_server
``yaml_nodes``  reads YAML so that an error names the line
"""

from .floor_map import FloorMap
from .grid_map import FREE, OCCUPIED, UNKNOWN, GridMap
from .ros_map import write_ros_map

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "FloorMap", "GridMap", "write_ros_map"]

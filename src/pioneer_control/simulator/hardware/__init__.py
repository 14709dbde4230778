"""One robot below its firmware. Open ``hardware`` first: all devices of a robot, moved together in fixed steps."""

from .hardware import Hardware
from .robot_numbers import RobotNumbers, load_numbers, standard_numbers

__all__ = ["Hardware", "RobotNumbers", "load_numbers", "standard_numbers"]

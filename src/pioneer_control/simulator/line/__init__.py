"""The lines between robots and their clients. Open ``line_simulation`` first: robots with their lines in simulated
time.

``robot_link``     one robot with its line: what faults act on
``faults``         what can go wrong with a robot and its line, and when
``one_way``        one direction of a line: how long bytes take, and how they are lost or spoilt
``uart``           what a serial port hears of bytes that come at another speed
``server``         the same in real time; ``lines``: its TCP ports and pseudo-terminals
``line_recorder``  writes what goes over the lines to a file
"""

from .faults import Fault, fault_of, load_faults
from .line_recorder import LineRecorder
from .line_simulation import LineSimulation
from .server import Server

__all__ = ["Fault", "LineRecorder", "LineSimulation", "Server", "fault_of", "load_faults"]

"""The lines between robots and their clients. Open ``line_simulation`` first: robots with their lines in simulated
time.

``robot_link``     one robot with its line, on which faults act
``faults``         the faults that a robot and its line can have, and their times
``one_way``        one direction of a line: how long bytes take, and which bytes are lost or damaged
``uart``           the bytes that a serial port receives when the sender has another baud rate
``server``         runs robots and lines in real time; ``lines``: its TCP ports and pseudo-terminals
``lasers``         the lasers of robots, in the time of their robots, and their lines
``cameras``        the cameras of robots, at their auxiliary ports or on lines of their own
``pace``           how simulated time follows real time
``lockstep``       a pace that waits for the program at each SIP
``line_recorder``  records to a file all bytes that are sent over the lines
"""

from .cameras import CameraPorts, camera_ports
from .faults import Fault, fault_of, load_faults
from .lasers import LaserPorts, laser_ports
from .line_recorder import LineRecorder
from .line_simulation import LineSimulation
from .server import Server

__all__ = [
    "CameraPorts", "Fault", "LaserPorts", "LineRecorder", "LineSimulation", "Server", "camera_ports", "fault_of",
    "laser_ports", "load_faults",
]

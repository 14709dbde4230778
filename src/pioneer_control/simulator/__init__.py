"""The simulated robots: their world, their hardware, their firmware with the protocol P2OS, and the lines to clients.

The docstring of each subpackage names the file to open first. Code imports only from its own row or a lower row:

``truth``       the true state of the world for other programs, and their orders, at a socket
``tasks``       tasks for robots: their arenas, a referee who gives points, and a runner for programs
``played``      plays back a recorded robot, or recorded clients
``line``        TCP ports and pseudo-terminals for clients, faults, and the server in real time
``simulation``  several robots in one world and one simulated time
``firmware``    the robot's side of the protocol: sessions, commands, packets
``hardware``    drives, body, sonar, gripper, battery and accessories of one robot, in steps of simulated time
``lms200``      a laser of the kind LMS200: what it measures, and its side of its own protocol
``world``       walls, posts and cans; sonar ranges and collisions; world files and maps

``clock`` is the clock of the simulated time. ``carrier`` carries robots and cans to other places. ``node`` is the ROS
node, and the only file that uses ROS; ``parameters`` has its parameters. ``__main__`` is the command line without ROS.
``picture`` draws worlds. ``shoves`` reports the cans that robots push. This package does not import the client package:
tests would not find a mistake in shared code.
"""

from .firmware import Firmware, FirmwareState
from .line import Fault, LineSimulation, Server, fault_of
from .played import PlayedRobot
from .simulation import Simulation, simulate
from .world import Can, World, known_worlds, load_world

__all__ = [
    "Can", "Fault", "Firmware", "FirmwareState", "LineSimulation", "PlayedRobot", "Server", "Simulation", "World",
    "fault_of",
    "known_worlds", "load_world", "simulate",
]

"""The robot's side: a world, the hardware of robots in it, the firmware that speaks P2OS, and the lines to its clients.

Each room has a front that says what to open first. Imports go down this list, never up:

``played``      a recorded robot, or a recorded client, instead of a simulated one
``line``        what a client connects to: TCP port, pseudo-terminal, their faults, the server in real time
``simulation``  several robots in one world and one simulated time
``firmware``    the robot's side of the protocol: sessions, commands, packets
``hardware``    drives, body, sonar, gripper, battery and accessories of one robot, in steps of simulated time
``world``       walls, posts and cans; what sonar hears and what a body touches there; files and maps of worlds

``clock`` is the one simulated time. ``node`` is the ROS node, and alone knows ROS; ``parameters`` has its parameters.
``__main__`` is the command line without ROS, ``picture`` draws worlds, ``shoves`` tells which cans robots push.
Nothing here knows the client: a mistake that both shared would hide.
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

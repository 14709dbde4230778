"""The robot's side of the protocol, without I/O. Open ``firmware`` first: bytes of a client go in, bytes of the robot
come out.

``commanded_robot``  the robot as commands find it: hardware, session, and what it sends
``commands``         what each client command does
``reports``          what the robot tells its client
``robot_on_line``    what a line needs of a robot, simulated or played from a record
"""

from .firmware import Firmware
from .robot_on_line import FirmwareState, RobotOnLine

__all__ = ["Firmware", "FirmwareState", "RobotOnLine"]

"""The robot's side of the protocol, without I/O. Open ``firmware`` first: it receives the bytes of a client and
returns the bytes of the robot.

``commanded_robot``  the robot that commands act on: its hardware, its session, and the packets that it sends
``commands``         the effect of each client command
``laser_orders``     what a client asks of a laser over the robot's own line; ``line_laser``: its scans
``reports``          the packets that the robot sends to its client
``robot_on_line``    the interface between a line and a robot, which is simulated or played from a recording
"""

from .firmware import Firmware
from .robot_on_line import FirmwareState, RobotOnLine

__all__ = ["Firmware", "FirmwareState", "RobotOnLine"]

"""The robot's side of the protocol, without I/O. Open ``firmware`` first: bytes of a client go in, bytes of the robot
come out.

``commands``  what each client command does
``reports``   what the robot tells its client
"""

from .firmware import Firmware, FirmwareState

__all__ = ["Firmware", "FirmwareState"]

"""A simulated laser of the kind LMS200, without I/O. Open ``firmware`` first: it receives the bytes of a client, lets
simulated time pass, and returns the bytes of the laser.

``device``         what the laser is and knows: its EEPROM, its mode, its errors, and the scans that it measures
``answers``        what each request does, and which reply it gets
``serial_output``  the laser's bytes on their way to the client
``optics``         which distances the laser measures in a world
``ray_plans``      which rays make a scan, and when each is fired
``raw_values``     distances as the numbers in a telegram

The protocol itself, as tables of requests and replies, is the package ``pioneer_control.lms2xx``. Facts are from the
laser sheet, `[inv]` marks numbers that are invented here.
"""

from .device import FirmwareNumbers
from .firmware import LaserFirmware
from .optics import PERFECT, TYPICAL, Measured, Optics, PoseAt, moving, standing

__all__ = ["PERFECT", "TYPICAL", "FirmwareNumbers", "LaserFirmware", "Measured", "Optics", "PoseAt", "moving",
           "standing"]

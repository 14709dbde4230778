"""The computer's side of a camera that turns: a Canon VC-C4 or VC-C50i. `vcc4` is its protocol.

Open ``session`` first. Everything down to it uses no clock, no port and no ROS:

================  ==============================================================
``settings``      what a user asks of a camera, checked
``wishes``        what a program wants of it now, and what is known of it
``conversation``  what is said to a camera, and in which order
``session``       carries that out: bytes and time in, bytes and reports out
``view``          units and axes of ROS and of p2os; the frustum of its view
``health``        how the camera is, for the diagnostics
================  ==============================================================

Two files carry the bytes: ``aux_camera`` through an auxiliary port of the robot, as a device on the robot's line;
``camera_line`` through a port of the computer, with a thread.
"""

from .aux_camera import AUX_PORTS, AuxCamera, aux_port_of
from .camera_line import CameraLine
from .session import CameraPhase, CameraReport, CameraSession
from .settings import Cabling, CameraSettings

__all__ = ["AUX_PORTS", "AuxCamera", "Cabling", "CameraLine", "CameraPhase", "CameraReport", "CameraSession",
           "CameraSettings", "aux_port_of"]

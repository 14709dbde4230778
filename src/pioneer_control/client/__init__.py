"""The computer's side of a Pioneer: drive it from plain Python, without ROS.

::

    from pioneer_control.client import Robot

    with Robot("socket://localhost:8101") as robot:        # or "/dev/ttyUSB0"
        robot.enable_motors()
        robot.set_velocity(0.2, 0.0)                        # m/s, rad/s; again within 0.6 s, or it stops
        print(robot.wait_for_state())

Leaving the block in any way stops the robot, switches its motors off and closes the connection. ``python3 -m pioneer_control.client PORT``
prints what the robot is and moves nothing.

Open ``robot.py`` first, then ``session.py``. From the wire upwards:

================  ====================================================================================
``transport``     bytes through a serial port, a pty or TCP: the URL chooses
``line``          when bytes may go out: pace, one pending velocity, a stop overtakes
``script``        what is done step by step: the form of the next two
``handshake``     listen, sync, identify: from an unknown state to a robot that has said its name
``host_baud``     a faster serial line for one session, and back where that does not work
``drive``         velocities, dead man, motors: what to say until the robot does it
``link_check``    questions while it is driven, to see whether what is sent arrives
``data``          packets besides the SIP, asked for until they come
``velocities``    of the robot or of its wheels: limits, and units of the wire that are right on average
``tuning``        settings of the robot itself: the table of them, and what became of each
``tuner``         tells them, and asks the robot whether it took them
``session``       all of that for one connection, sans-I/O: bytes and time in, bytes and events out
``gyro``          readings of one that the client has to read to turn rates
``gripper``       what it is told, and what it reports
``identity``      what the robot says it is, joined with the table of models
``odometry``      15-bit counts to an exact pose
``state``         one SIP to one Motion and one RobotState in SI units
``settings``      what the user wants of a connection, checked once
``events``        what a listener hears besides motions and states
``robot``         the I/O thread around it, and the calls a program makes
================  ====================================================================================
"""

from .events import BaudFound, CommandTimedOut, Event, LineSpeed, LinkDown, MotionCleared, PacketReceived, Ready, Tuned, Unmoved
from .gripper import GripperReading
from .identity import RobotIdentity
from .robot import LinkCounts, Robot
from .state import NO_ECHO, Motion, RobotState, SonarRange
from .tuning import Change, Tuning

__all__ = [
    "NO_ECHO",
    "BaudFound",
    "Change",
    "CommandTimedOut",
    "Event",
    "GripperReading",
    "LineSpeed",
    "LinkCounts",
    "LinkDown",
    "Motion",
    "MotionCleared",
    "PacketReceived",
    "Ready",
    "Robot",
    "RobotIdentity",
    "RobotState",
    "SonarRange",
    "Tuned",
    "Tuning",
    "Unmoved",
]

"""The computer's side of a Pioneer: drive it from plain Python, without ROS.

::

    from pioneer_control.client import Robot

    with Robot("socket://localhost:8101") as robot:        # or "/dev/ttyUSB0"
        robot.enable_motors()
        robot.set_velocity(0.2, 0.0)                        # m/s, rad/s; again within 0.6 s, or it stops
        print(robot.wait_for_state())

Leaving the block in any way stops the robot, switches its motors off and closes the connection. ``python3 -m
pioneer_control.client PORT`` prints what the robot is and moves nothing.

Open ``robot.py`` first, then ``session.py`` and ``phases.py``. From the wire upwards:

=================  ====================================================================================
``transport``      bytes through a serial port, a pty or TCP: the URL chooses
``line``           when bytes may go out: pace, one pending velocity, a stop overtakes
``link``           what the phases of a connection share, their form, and how they end
``handshake``      listen, sync, identify: from an unknown state to a robot that has said its name
``host_baud``      a faster serial line, and back where that does not work
``drive``          velocities, dead man, motors: what to say until the robot does it
``velocities``     of the robot or of its wheels: limits, and units of the wire that are right on average
``link_check``     questions while it is driven, to see whether what is sent arrives
``data_requests``  packets besides the SIP, asked for until they come
``tuning``         settings of the robot itself: the table of them, and what became of each
``tuner``          tells them, and asks the robot whether it took them
``odometry``       15-bit counts to an exact pose
``gripper``        what it is told, and what it reports
``gyro``           readings of one that the client has to read to turn rates
``identity``       what the robot says it is, joined with the table of models
``state``          one SIP to one RobotState in SI units
``events``         what listeners are told: states, and all else that happens
``settings``       what the user wants of a connection, checked once
``phases``         the phases of a connection, each an object; the table of what follows what
``session``        one connection, sans-I/O: bytes and time in, bytes and events out
``threads``        the two threads that have port and time, and tell the listeners
``robot``          the calls that a program makes
=================  ====================================================================================

**How a connection lives.** A Session has a phase, and the phase has what is true in it: a connected robot has its
drive, odometry, tuner and so on, and no other phase has them. A phase returns an outcome when it is over; one table
(phases.TRANSITIONS) says what follows. A packet is decoded once, and a SIP becomes one RobotState. A session calls
nobody back in the midst of a change: its owner calls data_to_send() and events() after each other call.

**How the threads work.** There are two. One of them has the port: it reads, keeps the time and sends. While it tells
the listeners what there is to tell, it gives the port away, and the other thread takes the port when that lasts long. A
command is written by the thread that gives it, under the same lock. So a busy listener holds up the line for a moment
at most, and a busy program never: the dead man and every stop go on working.
"""

from .events import (BaudFound, CommandTimedOut, Event, LineSpeed, LinkDown, MotionCleared, MotorsAnswered,
                     PacketReceived, Ready, StatesMissed, Tuned,
                     Unmoved)
from .gripper import GripperReading
from .identity import RobotIdentity
from .robot import LinkCounts, Robot
from .state import NO_ECHO, RobotState, SonarRange
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
    "MotionCleared",
    "MotorsAnswered",
    "PacketReceived",
    "Ready",
    "Robot",
    "RobotIdentity",
    "RobotState",
    "SonarRange",
    "StatesMissed",
    "Tuned",
    "Tuning",
    "Unmoved",
]

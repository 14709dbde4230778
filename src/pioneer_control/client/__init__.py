"""The client library: drive a Pioneer from plain Python, without ROS.

::

    from pioneer_control.client import Robot

    with Robot("socket://localhost:8101") as robot:        # or "/dev/ttyUSB0", or "ws://host:8080/robot/7#key=KEY"
        robot.enable_motors()
        robot.set_velocity(0.2, 0.0)                        # m/s, rad/s; repeat it within 0.6 s, or the robot stops
        print(robot.wait_for_state())

When the block ends, also by an exception, the robot is stopped, its motors are switched off, and the connection is
closed. ``python3 -m pioneer_control.client PORT`` prints what the robot is and moves nothing.

Open ``robot.py`` first, then ``session.py`` and ``phases.py``. All files, from the wire upwards:

=================  ====================================================================================
``transport``      reads and writes bytes: what all kinds of ports have in common
``serial_port``    serial ports and ptys
``tcp``            ports on TCP
``web_socket``     ports on a WebSocket, whose server wants a key
``ports``          opens a port of the kind that its URL names
``line``           decides when packets are sent: keeps the pace, sends a stop first
``link``           what all phases of a connection share, and the outcomes that end a phase
``handshake``      the first phase: find the robot, synchronise, get its name
``host_baud``      changes to a faster serial line speed, and back when that fails
``drive``          velocities, dead man, motors: repeats a command until the robot obeys
``velocities``     converts velocities to whole units of the wire, within the limits
``link_check``     sends questions while the robot drives, and counts lost answers
``data_requests``  requests packets besides the SIP until they come
``tuning``         settings of the robot itself: their table, and the result of each
``tuner``          sends these settings, and checks that the robot took them
``odometry``       turns 15-bit counts into an exact pose
``corrected_odometry``  the same, with the factors of a calibrated robot
``gripper``        gripper commands and gripper readings
``gyro``           turns raw gyro readings into turn rates
``identity``       joins what the robot reports about itself with the table of models
``state``          turns one SIP into one RobotState in SI units
``events``         what listeners receive: states and all other events
``settings``       the user's settings of a connection, checked once
``phases``         the other phases of a connection, and the table of transitions
``lockstep``       phases of a connection to a simulated robot that waits for the program
``session``        one connection, sans-I/O: bytes and time in, bytes and events out
``threads``        two threads that own the port and the clock, and call the listeners
``robot``          the class Robot, which a program uses
``helm``           who may command: inputs with priorities and time-outs, and locks
``steered_robot``  a Robot that several inputs command, as far as the helm lets them
``laser_power``    the packet that switches the supply of a laser
``line_devices``   joins devices on the robot's line, a camera or an arm, with a Robot
``accessories``    sounds, outputs, a joystick at the robot's own port, docks
``alarms``         the texts of alarms, and the battery levels that they need
``fault_flags``    the table of what the fault flags of a robot mean in diagnostics
``health``         the diagnostics of a robot, as in REP 107: levels and texts
=================  ====================================================================================

**How a connection works.** A Session always has one phase. An object of the phase has what exists only in this phase:
for example only the phase Connected has a drive and a tuner. A phase returns an outcome when it is over. The table
phases.TRANSITIONS has the phase that follows. Each packet is decoded once, and each SIP becomes one RobotState. A
session makes no callbacks: its owner calls data_to_send() and events() after every other call.

**How the threads work.** There are two threads. One of them has the port: it reads, watches the clock and sends.
Before it calls the listeners, it releases the port. When the listeners take long, the other thread takes the port. A
command is written by the thread that calls Robot, under the same lock. So a slow listener delays the line for a moment
at most, and a busy program never does. The dead man and every stop keep working.
"""

from ..p2os import GripperCommand
from .accessories import Accessories
from .events import (BaudFound, CommandTimedOut, Event, LineSpeed, LinkDown, MotionCleared, MotorsAnswered,
                     PacketReceived, Ready, StatesMissed, Tuned,
                     Unmoved)
from .gripper import GripperReading
from .helm import HelmState, VelocityInput
from .identity import RobotIdentity
from .robot import LinkCounts, Robot
from .state import NO_ECHO, RobotState, SonarRange
from .steered_robot import SteeredRobot
from .tuning import Change, Tuning

__all__ = [
    "NO_ECHO",
    "Accessories",
    "BaudFound",
    "Change",
    "CommandTimedOut",
    "Event",
    "GripperCommand",
    "GripperReading",
    "HelmState",
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
    "SteeredRobot",
    "Tuned",
    "Tuning",
    "Unmoved",
    "VelocityInput",
]

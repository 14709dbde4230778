"""Pioneer robots from Python and ROS: the P2OS protocol, a client, a driver node, the tutorial, and a simulated robot.

Start reading at the folder that answers the question:

=============  ==========================================================================
``p2os``       the wire: bytes to typed packets and back (no I/O, no ROS)
``robots``     what differs between one model and another (one data file)
``client``     drive a robot from plain Python: serial port, pty or TCP
``driver``     the ROS node around the client
``simulator``  the robot's side: a world, a body, a firmware (ROS in its node only)
``tutorial``   the ``Pioneer`` class that wanders and picks
``bags``       runs recorded, replayed and drawn
=============  ==========================================================================

Below them all lie single files: ``errors`` (every exception), ``parameters`` (how a node checks its parameters),
``message_values`` (what the numbers in messages mean), ``standard_messages`` (sonar and battery in messages that other
packages know), ``ros_node`` (how a node begins and ends), ``interrupt`` (Ctrl-C without a traceback) and ``pictures``
(what all pictures from above share).

Importing this package loads none of them, neither rospy nor serial.
"""

__version__ = "0.1.0"

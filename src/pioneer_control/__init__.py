"""Pioneer robots from Python and ROS: the P2OS protocol, a client, a driver node, the tutorial, and a simulated robot.

The folders:

=============  ==========================================================================
``p2os``       the protocol: bytes to typed packets and back (no I/O, no ROS)
``lms2xx``     the protocol of SICK's LMS2xx lasers, in the same way
``laser``      finds such a laser, configures it, and hears its scans
``vcc4``       the protocol of Canon's cameras VC-C4 and VC-C50i, in the same way
``ptz``        starts such a camera, turns it, and knows where it looks
``arm``        the Pioneer Arm: finds it, what moves it, and where its gripper is (no ROS)
``robots``     the properties of each robot model, in one data file
``description`` the URDF of any model, for RViz and tf
``client``     drive a robot from plain Python over a serial port, TCP or a WebSocket
``driver``     the ROS node around the client
``simulator``  a simulated robot: world, body, firmware (only its node uses ROS)
``maps``       maps of a floor, and their files
``navigation`` where the robot is, what the map is, how it gets to a goal: with sonar alone
``tutorial``   the ``Pioneer`` class, which wanders and picks up cans
``teleop``     drive a robot by hand, with the keys of a terminal or a gamepad
``calibration``  what the wheels of a robot measure wrongly, with a tape measure
``bags``       record runs in bags, replay them and draw them
``web``        the page in a browser: see robots, and drive them by hand
``service``    a launch file that starts at boot, as a systemd service
=============  ==========================================================================

The files that the folders share: ``errors`` (every exception), ``wire_fields`` (packets read and written by tables),
``wire_words`` (the same for people), ``parameters`` (how a node checks its parameters), ``floor_poses`` (poses and
their transforms), ``message_values`` (what the numbers in messages mean), ``standard_messages`` (sonar and battery in
messages of standard packages), ``port_url`` (the URL of a robot's port, and its key), ``ros_node`` (how a node starts
and ends), ``diagnostics_thread`` (how a node says how its device is), ``prompt_connection`` (messages leave at once),
``interrupt`` (Ctrl-C without a traceback), ``console`` (the commands of the wheel), ``whole_file`` (write a file
completely or not at all) and ``pictures`` (what all pictures share).

``import pioneer_control`` alone loads none of these files and folders, and neither rospy nor serial.
"""

__version__ = "0.1.0"

"""The ROS node ``p2os_driver``: it connects to a robot, and offers topics and services, named as in the package p2os.

=========================  ====================================================================================
``node.py``                the node: connects the other files with one robot (docs/driver.md describes the node)
``parameters.py``          the table of all parameters and their legal values
``publications.py``        the table of all published topics, and the publishers
``conversions.py``         pure functions that convert the state of the robot to messages
``prompt.py``              publishes messages with less delay than rospy; you can skip it
``wire_topic.py``          publishes every byte on the line to the robot
``requests.py``            the tables of all subscribers and services, and the methods that obey them
``accessory_requests.py``  obeys requests for sounds, outputs, a joystick at the robot's own port, docks
``device_topics.py``       which devices on the robot have topics, and what the driver needs of each
``ptz_topics.py``          the topics and services of a camera that turns
``arm_topics.py``          the topics and services of a Pioneer Arm
``helm_topic.py``          publishes who may command
``commands.py``            checks messages to the motors and the gripper
``accelerations.py``       accelerations that a program borrows
``senders.py``             finds out whether `rosbag play` sent a command, which is refused then
``reconfigure.py``         dynamic_reconfigure: parameters that change while the driver runs
``notices.py``             the texts of warnings, and how often the user gets them
``diagnostics.py``         publishes the diagnostics, which `client.health` makes
=========================  ====================================================================================
"""

"""The computer's side of a SICK LMS2xx laser: finds it, configures it, and hears its scans. `lms2xx` is its protocol.

Open ``session`` first. Everything down to it uses no clock, no port and no ROS:

================  ==============================================================
``settings``      what a user asks of a laser, checked
``conversation``  what is said to a laser, and in which order
``session``       carries that out: bytes and time in, bytes and events out
``conversion``    a scan as the numbers of a sensor_msgs/LaserScan
``health``        how the laser is, for the diagnostics
``parameters``    the parameters of the node, as a table
================  ==============================================================

``line`` owns the port and the clock; ``byte_record`` writes down all its bytes, if a user wants it. ``node`` is the ROS
node.
"""

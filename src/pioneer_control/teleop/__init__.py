"""Drive a robot by hand without a browser: ``rosrun pioneer_control drive``, with the keys of a terminal or a gamepad.

===============  ==================================================================================
``hand.py``      pure: what the hand wants, and for how long; the limit of speed
``keys.py``      pure: bytes of a terminal to keys, and the table of what each key does
``gamepad.py``   pure: events of a gamepad to what the hand wants; opens and reads the device
``node.py``      the ROS node: publishes velocities, and shows the state of the robot in one line
===============  ==================================================================================

The driver decides who commands (``client/helm.py``). This program only publishes on ``teleop/cmd_vel``.
"""

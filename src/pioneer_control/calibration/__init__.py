"""Calibration with a tape measure: ``rosrun pioneer_control calibrate``.

A robot drives runs: straight lines, turns on the spot, squares both ways. Its odometry says where it went, a person
with a tape measure says where it is. What its wheels and its gyro measure wrongly follows from the difference.

=====================  =================================================================================
``tracks.py``          pure: what odometry measured in a run, and where the robot ends when it is corrected
``runs.py``            pure: the three kinds of run, their marks on robot and floor, and what the tape says
``estimate.py``        pure: the factors from all runs, how sure they are, and why a robot cannot be calibrated
``plan.py``            pure: which runs are driven, and the legs of each
``guide.py``           pure: drives the legs of a run by odometry: poses in, velocities out
``lookout.py``         pure: what the sonar sees in the way of a leg
``conversation.py``    the conversation with the person; person and robot are interfaces of a few methods
``words.py``           pure: its longer texts: instructions and results
``result.py``          pure: the numbers of a models file, and those of the robot itself
``pieces.py``          pure: finds the runs in the poses of a recording
``bag.py``             the same from a bag
``terminal.py``        the person at the terminal: questions, and the key that must be held
``node.py``            the program: the robot on ROS topics
=====================  =================================================================================

Source of the square: the bidirectional square-path method of J. Borenstein and L. Feng (UMBmark), in own words: a
square that is driven both ways tells apart wheels of different size, which bend its sides, from a wrong distance of the
wheels, which turns its corners. Here one least-squares estimate uses squares, lines and turns together.
"""

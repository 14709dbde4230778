"""The hardware of one simulated robot, without its firmware. Open ``hardware`` first: all devices of a robot, which
move together in fixed time steps.

``drives``         set points of translation, rotation and wheels, stalls, and motor power
``ramps``          how the drives follow their set points with limited acceleration
``wheels``         how far the wheels really turn, the encoder counts, and the odometry
``body``           where the robot stands in its world, how it moves, what stops it, and which bumpers are pressed
``sonar``          which transducer fires when, and which range it measures
``gripper``        two paddles on a lift, with beams and contacts
``battery``        battery voltage, charger and docks
``arm``            the Pioneer Arm: six servos and their server
``accessories``    gyro, compass, joystick, user inputs and outputs, serial ports
``camera``         a camera that turns, at a serial port
``robot_numbers``  the parameters of all these devices, from ``robot.yaml`` or a user's file
"""

from .hardware import Hardware
from .robot_numbers import LaserNumbers, RobotNumbers, load_numbers, real_numbers, standard_numbers

__all__ = ["Hardware", "LaserNumbers", "RobotNumbers", "load_numbers", "real_numbers", "standard_numbers"]

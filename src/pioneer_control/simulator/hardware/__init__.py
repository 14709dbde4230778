"""One robot below its firmware. Open ``hardware`` first: all devices of a robot, moved together in fixed steps.

``drives``         translation, rotation and wheels: what they are told, and when they give up
``ramps``          how the drives follow that: with limited acceleration
``wheels``         what the wheels really do, what their encoders count, and the pose added up from that
``body``           where the robot stands in its world, how it moves, what stops it, and which bumpers are pressed
``sonar``          which transducer fires when, and what it hears
``gripper``        paddles on a lift, with beams and contacts
``battery``        its voltage, and what feeds it
``accessories``    gyro, compass, joystick, user inputs and outputs, serial ports
``robot_numbers``  the numbers of all these, from ``robot.yaml`` or a user's file
"""

from .hardware import Hardware
from .robot_numbers import RobotNumbers, load_numbers, standard_numbers

__all__ = ["Hardware", "RobotNumbers", "load_numbers", "standard_numbers"]

"""The URDF of any robot of the table of models, with the parts that it carries: for RViz, and for tf of its parts.

``urdf.py``     makes the URDF of a model: its links, joints and shapes
``parts.py``    the parts that a robot may carry: gripper, laser, camera, arm
``elements.py``  writes the elements of a URDF: links, joints, boxes, cylinders
``node.py``     the ROS node that describes the robot of `robot_info`, and starts robot_state_publisher
``picture.py``  draws the URDF of all models on one sheet

``rosrun pioneer_control describe p3dx-sh`` prints the URDF of a model.
"""

from .parts import Parts
from .urdf import describe

__all__ = ["Parts", "describe"]

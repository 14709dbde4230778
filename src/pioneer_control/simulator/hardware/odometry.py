"""The robot's own pose, as it adds it up."""

from ..world.geometry import Pose
from ..world.poses import along_arc
from ..world.trigonometry import heading_unit


class DeadReckoning:
    """The pose that a robot adds up step by step.

    Attributes:
        origin: the true pose (m, rad; map frame) at which it was 0, 0, 0.
        pose: x, y (m) and heading (rad, not wrapped) since then.
    """

    def __init__(self, origin: Pose):
        self.reset(origin)

    def reset(self, origin: Pose) -> None:
        """Begin at 0, 0, 0 while the robot stands at `origin`."""
        self.origin = origin
        self._heading = heading_unit()
        self.pose: Pose = (0.0, 0.0, 0.0)

    def add(self, distance: float, turn: float) -> None:
        """Add a step: a distance (m) and a turn (rad), both even."""
        self.pose = along_arc(self.pose, distance, turn, self._heading)

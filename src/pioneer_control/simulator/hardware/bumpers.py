"""The bumpers: which of their segments are pressed, and which of them stall the wheels."""

from typing import Tuple

from ...robots import RobotModel
from .body import Body

DEPTH = 0.02
"""How far (m) the segments stand out from the body."""


class BumperRing:
    """The bumpers in front and behind.

    Attributes:
        front_stalls, rear_stalls: whether they stop the wheels at once.
    """

    def __init__(self, model: RobotModel, body: Body):
        self._model, self._body = model, body
        self.reset()

    def reset(self) -> None:
        """Let all bumpers stall the wheels, as at power-on."""
        self.front_stalls = self.rear_stalls = True

    def bits(self) -> Tuple[int, int]:
        """Pressed segments of the front and of the rear bumper; bit 0 is the left one in front, the right one behind.
        """
        front, rear = self._model.length_front, -self._model.length_rear
        return self._pressed(self._model.front_bumpers, front, 1.0), self._pressed(self._model.rear_bumpers, rear, -1.0)

    def stall(self, distance: float) -> bool:
        """Whether a bumper that stalls the wheels is pressed on the side that the robot drives to."""
        front, rear = self.bits()
        if distance > 0.0:
            return self.front_stalls and front != 0
        return distance < 0.0 and self.rear_stalls and rear != 0

    def _pressed(self, count: int, near: float, side: float) -> int:
        """The bits of one bumper.

        Args:
            count: of its segments.
            near: x (m, base_link) where the body ends.
            side: 1 in front, -1 behind.
        """
        if not count or not self._body.blocked:
            return 0
        width, far = self._model.width / count, near + side * DEPTH
        lefts = [side * (self._model.width / 2.0 - segment * width) for segment in range(count)]
        return sum(
            1 << segment for segment, left in enumerate(lefts)
            if self._body.touches(((near, left), (near, left - side * width), (far, left - side * width), (far, left))))

"""The way that a robot went lately, as points for the page. Pure."""

import math
from collections import deque
from typing import Deque, List, Sequence, Tuple

MOST_POINTS = 600
SPACING = 0.05      # m between two points
JUMP = 1.0          # m: a pose so far from the one before was not driven, but set: the way begins anew


class Trail:
    """The last MOST_POINTS places of one robot in the odometry frame (m), at least SPACING from each other."""

    def __init__(self, points: Sequence[Sequence[float]] = ()) -> None:
        self._points: Deque[Tuple[float, float]] = deque(((x, y) for x, y in points), MOST_POINTS)
        self._last = self._points[-1] if self._points else (math.nan, math.nan)

    def go(self, x: float, y: float) -> None:
        """Take the next pose (m). A place that is too near to the last point adds none."""
        if abs(x - self._last[0]) > JUMP or abs(y - self._last[1]) > JUMP:
            self._points.clear()
        self._last = (x, y)
        if not self._points or math.hypot(x - self._points[-1][0], y - self._points[-1][1]) >= SPACING:
            self._points.append(self._last)

    @property
    def points(self) -> List[List[float]]:
        """The points, oldest first: x and y in m, in whole mm."""
        return [[round(x, 3), round(y, 3)] for x, y in self._points]

"""Reports in sentences which cans the robots have pushed, how far, and from where to where. This file uses no ROS."""

from typing import Dict, List, NamedTuple, Sequence, Tuple

from .world import Can
from .world.poses import Point, hypot

REST = 1.0
"""Time (simulated s) without motion of a can after which its shove is over."""
SHORTEST = 0.01
"""Shortest distance (m) between the ends of a shove that is reported."""


class _Shove(NamedTuple):
    """A shove of a can that is not over yet.

    `begin` is where the can stood before (m, map frame), `robot` is the name of the robot that pushes the can, and
    `moved_at` is the simulated time of its last motion (s).
    """

    begin: Point
    robot: str
    moved_at: float


class ShoveWatch:
    """Watches the cans of a world, and reports each shove once, when the shove is over.

    Args:
        cans: the cans of the world. In the reports, their numbers count from 1.
    """

    def __init__(self, cans: Sequence[Can]):
        self._cans = cans
        self._places = [(can.x, can.y) for can in cans]
        self._shoves: Dict[int, _Shove] = {}

    def look(self, now: float, robots: Sequence[Tuple[str, Point]]) -> List[str]:
        """Compare the places of the cans with those of the last call. Call this regularly.

        Args:
            now: simulated time (s).
            robots: name and position (m, map frame) of each robot. The nearest robot counts as the one that pushes.

        Returns:
            A sentence for each shove that is over.
        """
        for number, can in enumerate(self._cans):
            before, place = self._places[number], (can.x, can.y)
            self._places[number] = place
            if can.held_by is not None:
                self._shoves.pop(number, None)
            elif place != before:
                nearest, _ = min(robots, key=lambda robot: _distance(robot[1], place))
                self._shoves[number] = self._shoves.get(number, _Shove(before, nearest, now))._replace(moved_at=now)
        return self._end([number for number, shove in self._shoves.items() if now - shove.moved_at >= REST])

    def finish(self) -> List[str]:
        """End all shoves that are not over yet, and return a sentence for each."""
        return self._end(list(self._shoves))

    def _end(self, numbers: List[int]) -> List[str]:
        """End the shoves of the cans with these numbers (from 0), and return a sentence for each that was long enough.
        """
        sentences = []
        for number in numbers:
            begin, robot, _ = self._shoves.pop(number)
            end = self._places[number]
            if _distance(begin, end) >= SHORTEST:
                sentences.append("%s pushed can %d by %.2f m, from x %.2f, y %.2f to x %.2f, y %.2f" % (
                    robot, number + 1, _distance(begin, end), *begin, *end))
        return sentences


def _distance(begin: Point, end: Point) -> float:
    return hypot(end[0] - begin[0], end[1] - begin[1])

"""Cans that robots push, told to people: which, how far, and from where to where. Knows no ROS."""

from typing import Dict, List, NamedTuple, Sequence, Tuple

from .world import Can
from .world.poses import Point, hypot

REST = 1.0
"""A shove is over when the can has stood still for so long (simulated s)."""
SHORTEST = 0.01
"""Shoves over less than this (m) are not told."""


class _Shove(NamedTuple):
    """A shove that goes on: where the can stood before, who pushes it, and when it last moved (s)."""

    begin: Point
    robot: str
    moved_at: float


class ShoveWatch:
    """Looks at the cans of a world now and then, and tells each shove once, when it is over.

    Args:
        cans: the cans; their numbers count from 1.
    """

    def __init__(self, cans: Sequence[Can]):
        self._cans = cans
        self._places = [(can.x, can.y) for can in cans]
        self._shoves: Dict[int, _Shove] = {}

    def look(self, now: float, robots: Sequence[Tuple[str, Point]]) -> List[str]:
        """Look at the cans.

        Args:
            now: simulated time (s).
            robots: name and place (m, map frame) of each robot; the nearest one has pushed.

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
        return self._told([number for number, shove in self._shoves.items() if now - shove.moved_at >= REST])

    def finish(self) -> List[str]:
        """Tell the shoves that are not over, too."""
        return self._told(list(self._shoves))

    def _told(self, numbers: List[int]) -> List[str]:
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

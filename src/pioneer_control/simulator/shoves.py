"""Cans that robots push, told to people: which, how far, and from where to where. Knows no ROS."""

from typing import Dict, List, NamedTuple, Sequence, Tuple

from .world.geometry import Point
from .world.trigonometry import hypot
from .world.world import Can

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
                begin, robot, _ = self._shoves.get(number) or _Shove(before, _nearest(robots, place), now)
                self._shoves[number] = _Shove(begin, robot, now)
        return self._told([number for number, shove in self._shoves.items() if now - shove.moved_at >= REST])

    def finish(self) -> List[str]:
        """Tell the shoves that are not over, too."""
        return self._told(list(self._shoves))

    def _told(self, numbers: List[int]) -> List[str]:
        sentences = []
        for number in numbers:
            (x, y), robot, _ = self._shoves.pop(number)
            to_x, to_y = self._places[number]
            far = hypot(to_x - x, to_y - y)
            if far >= SHORTEST:
                sentences.append("%s pushed can %d by %.2f m, from x %.2f, y %.2f to x %.2f, y %.2f" % (
                    robot, number + 1, far, x, y, to_x, to_y))
        return sentences


def _nearest(robots: Sequence[Tuple[str, Point]], place: Point) -> str:
    return min(robots, key=lambda robot: hypot(robot[1][0] - place[0], robot[1][1] - place[1]))[0]

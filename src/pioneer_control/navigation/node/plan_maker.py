"""The service ``move_base/make_plan``: the way between two poses, without driving."""

import math
from typing import Any, Callable, Iterator, List, Optional, Tuple

import rospy
from geometry_msgs.msg import Point as PointMessage
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import PoseStamped, Quaternion
from nav_msgs.srv import GetPlanResponse

from ...errors import PioneerError, RefusedError
from ...floor_poses import Pose
from ...maps import OCCUPIED, UNKNOWN, GridMap
from ..pilot import Pilot
from ..values import Point
from .messages import check_on_map, path_message, pose_of

MOST_TOLERANCE = 5.0
"""Farthest (m) from a goal that another place is looked for."""
RINGS, DIRECTIONS = 10, 16
"""Of how many circles round a goal, and places on each, one is taken instead of it."""


class PlanMaker:
    """Makes plans.

    Args:
        pilot: knows the map.
        frame: frame of the map.
        in_map: returns a pose of any frame (header, pose) in the frame of the map. It raises PioneerError if it cannot.
        here: returns where the robot is. It raises PioneerError with the reason when nobody knows.
    """

    def __init__(self, pilot: Pilot, frame: str, in_map: Callable[[Any, Pose], Pose], here: Callable[[], Pose]):
        self._pilot, self._frame, self._in_map, self._here = pilot, frame, in_map, here

    def serve(self, request: Any) -> GetPlanResponse:
        """Answer a request (GetPlan). Without a way the plan has no poses, and the log has the reason."""
        points: List[Point] = []
        heading = None
        try:
            start = self._start(request.start)
            goal, heading = self._place(request.goal)
            points = self._way(start, goal, request.tolerance)
        except PioneerError as error:
            rospy.logwarn("no plan: %s", error)
        return GetPlanResponse(path_message(points, self._frame, rospy.Time.now(), heading))

    def _start(self, message: PoseStamped) -> Pose:
        """Return where a plan begins. As in move_base, an empty message means where the robot is."""
        if not message.header.frame_id and message.pose.position == PointMessage() and (
                message.pose.orientation in (Quaternion(), Quaternion(w=1.0))):
            return self._here()
        start, _ = self._place(message)
        grid: GridMap = self._pilot.grid
        check_on_map(start, grid, "the start")
        cell = grid.at(start.x, start.y)
        if cell == OCCUPIED or (cell == UNKNOWN and not self._pilot.makes_map):
            raise RefusedError("the start (%.2f, %.2f) lies %s" % (
                start.x, start.y, "in a wall" if cell == OCCUPIED else "where the map is unknown"))
        return start

    def _place(self, message: PoseStamped) -> Tuple[Pose, Optional[float]]:
        """Return a pose in the frame of the map, and its heading if the message tells one."""
        told = message.pose
        is_told = told.orientation != Quaternion()
        pose = self._in_map(message.header, pose_of(
            told if is_told else PoseMessage(told.position, Quaternion(w=1.0))))
        return pose, pose.heading if is_told else None

    def _way(self, start: Pose, goal: Pose, tolerance: float) -> List[Point]:
        """Return the way to a goal, or to the nearest place within a tolerance (m) to which there is one."""
        try:
            return self._pilot.way(start, goal)
        except RefusedError as error:
            for near in _round(goal, tolerance):
                try:
                    return self._pilot.way(start, near)
                except RefusedError:
                    pass
            raise error


def _round(goal: Pose, tolerance: float) -> Iterator[Pose]:
    """Yield places within a tolerance (m) of a goal, nearest first."""
    reach = min(tolerance, MOST_TOLERANCE)
    for ring in range(1, RINGS + 1 if reach > 0.0 else 1):
        radius = reach * ring / RINGS
        for direction in range(DIRECTIONS):
            angle = 2.0 * math.pi * direction / DIRECTIONS
            yield Pose(goal.x + radius * math.cos(angle), goal.y + radius * math.sin(angle), goal.heading)

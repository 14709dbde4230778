"""The named places of the map: publishes them, and keeps those that somebody names in a file beside the map."""

from math import degrees
from typing import Any, Callable, Dict, Optional

import rospy

from ...errors import PioneerError, UsageError
from ...floor_poses import Pose
from ...maps import FloorMap
from ...maps.goals_file import goals_file, write_goals
from ...msg import Places
from ...parameters import nearest
from ...srv import SavePlaceResponse
from .messages import check_on_map, header_of, pose2d

HOME = "home"
"""The name of the place where exploring begins, as of the start on a map of the simulator."""


class PlaceKeeper:
    """The named places of one map.

    Args:
        floor: the map. None: the robot makes one.
        map_file: where it comes from: a file, or the name of a world, beside which nothing is kept.
        frame: frame of the map.
        here: returns where the robot stands. It raises PioneerError with the reason when nobody knows.
    """

    def __init__(self, floor: Optional[FloorMap], map_file: str, frame: str, here: Callable[[], Pose]):
        self.places: Dict[str, Pose] = dict(floor.goals) if floor else {}
        self._floor, self._frame, self._here = floor, frame, here
        self._file = goals_file(map_file) if map_file.endswith((".yaml", ".yml", ".map")) else None
        self._topic = rospy.Publisher("places", Places, queue_size=1, latch=True)
        self._tell()

    def place(self, name: str) -> Pose:
        """Return the place of a name. Raises UsageError with the names that there are."""
        if name not in self.places:
            near = nearest(name, self.places)
            raise UsageError("no place is named %r; %sknown: %s" % (
                name, "did you mean %r? " % near if near else "", self._known()))
        return self.places[name]

    def name_home(self, pose: Pose) -> None:
        """Name the place where exploring begins, if the map has no home yet."""
        if HOME not in self.places:
            self.places = dict(self.places, **{HOME: pose})
            self._tell()

    def _known(self) -> str:
        return ", ".join(map(repr, self.places)) or "none; the service save_place names one"

    def _tell(self) -> None:
        self._topic.publish(Places(header_of(self._frame, rospy.Time.now()), self._floor.name if self._floor else "",
                                   list(self.places), [pose2d(pose) for pose in self.places.values()]))

    def serve(self, request: Any) -> SavePlaceResponse:
        """Save or forget a place (SavePlace). One request at a time: each must have the change of the one before."""
        try:
            places = self._changed(request)
            if self._file is not None:
                write_goals(places, self._file)
            self.places = places
            self._tell()
        except PioneerError as error:
            return SavePlaceResponse(False, str(error))
        done = "%s is forgotten" % request.name if request.forget else "%s is saved at x %.2f, y %.2f, %.0f degrees" % (
            request.name, *places[request.name][:2], degrees(places[request.name].heading))
        return SavePlaceResponse(True, done + (
            ", in %s" % self._file if self._file else " until navigation ends: no file of a map is there to keep it"))

    def _changed(self, request: Any) -> Dict[str, Pose]:
        """Return the places with what a request changes."""
        if not request.name.strip():
            raise UsageError("a place needs a name")
        places = dict(self.places)
        if request.forget:
            self.place(request.name)
            del places[request.name]
        elif request.here:
            places[request.name] = self._here()
        else:
            pose = Pose(request.pose.x, request.pose.y, request.pose.theta)
            if not all(abs(number) < 1e6 for number in pose):
                raise UsageError("a place at %s: its numbers must be finite, and below a million" % (tuple(pose),))
            if self._floor is not None:
                check_on_map(pose, self._floor.grid, "the place")
            places[request.name] = pose
        return places

"""What persons at the page tell the navigation of a robot: by topics and a service, as any program does."""

import math
from time import monotonic
from typing import Any, Callable, Union

import rospy
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import (Point, Pose, Pose2D, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped,
                               Quaternion)
from std_msgs.msg import Header

from ..errors import RefusedError
from ..srv import SavePlace
from .from_messages import GOAL
from .navigation_picture import NavigationPicture
from .orders import CancelOrder, ForgetPlaceOrder, GoOrder, HereOrder, NavigationOrder, SavePlaceOrder

HERE_OFF = 0.25, 0.25, math.radians(15)
"""How far a person who shows on the map where a robot is may be off (m, m, rad; standard deviations)."""


class GraphNavigation:
    """The way to the navigation of one robot.

    Args:
        prefix: the namespace of the robot, with slashes at both ends.
        picture: what its navigation tells.
        call: calls a service of the robot, given by its name and type, with some values, and says what it answers if
            it fails. It returns at once.
    """

    def __init__(self, prefix: str, picture: NavigationPicture, call: Callable[..., None]) -> None:
        self._prefix, self._picture, self._call = prefix, picture, call
        self._goal = rospy.Publisher(prefix + GOAL, PoseStamped, queue_size=1)
        self._cancel = rospy.Publisher(prefix + "move_base/cancel", GoalID, queue_size=1)
        self._here = rospy.Publisher(prefix + "initialpose", PoseWithCovarianceStamped, queue_size=1)

    def unregister(self) -> None:
        """Publish no more."""
        for each in (self._goal, self._cancel, self._here):
            each.unregister()

    def navigate(self, order: NavigationOrder) -> None:
        """Pass an order on. Raises RefusedError when navigation does not run."""
        if not self._picture.lives(monotonic()):
            raise RefusedError("nothing comes on %snavigation: does navigation run?" % self._prefix)
        if isinstance(order, SavePlaceOrder):
            self._call("save_place", SavePlace, order.name, True, False, Pose2D())
        elif isinstance(order, ForgetPlaceOrder):
            self._call("save_place", SavePlace, order.name, False, True, Pose2D())
        elif isinstance(order, CancelOrder):
            self._cancel.publish(GoalID())      # without a name: every goal
        else:
            self._send(order)

    def _send(self, order: Union[GoOrder, HereOrder]) -> None:
        header = Header(stamp=rospy.Time.now(), frame_id=self._picture.frame)
        half = order.heading / 2.0
        pose = Pose(Point(order.x, order.y, 0.0), Quaternion(0.0, 0.0, math.sin(half), math.cos(half)))
        if isinstance(order, GoOrder):
            self._goal.publish(PoseStamped(header, pose))
            return
        covariance: Any = [0.0] * 36
        for row, off in zip((0, 1, 5), HERE_OFF):
            covariance[7 * row] = off ** 2
        self._here.publish(PoseWithCovarianceStamped(header, PoseWithCovariance(pose, covariance)))

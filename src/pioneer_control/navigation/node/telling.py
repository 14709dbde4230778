"""Publishes where the robot is, what navigation does and why, the cloud, the plan and the map."""

from time import monotonic
from typing import Any

import rospy
import tf2_ros
from geometry_msgs.msg import PolygonStamped, PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path

from ...msg import Navigation
from ..localisation import Where
from ..navigator import State, kind_of
from ..pilot import Pilot, PilotStep
from .laser_watch import NO_LASER
from .messages import (cloud_message, footprint_message, header_of, map_message, odom_on_map, path_message, pose2d,
                       pose_with_covariance)
from .parameters import NavigationParameters
from .status import LATE, StatusReport, late_text

PERIODS = {"cloud": 0.5, "plan": 0.5, "map": 1.0}
"""Times (s) between two messages of one kind: the cloud, the plan, and a map that is being made."""
LATE_PERIOD = 30.0
"""Time (s) between two lines of the log that the robot reacts late."""
JUMP_PERIOD = 10.0
"""The same, that odometry jumps: where two drivers tell the pose of one robot, it does so at each message."""
MOST_DRAWN = 500
"""Most poses in one cloud."""


class Telling:
    """The topics of one navigation.

    Args:
        pilot: what it does.
        parameters: parameters of the node.
        outline: corners of the robot (m; its own frame).

    Attributes:
        tf_trouble: who else tells tf where this robot is, for people; empty when nobody does.
        laser: what to tell of the laser.
    """

    def __init__(self, pilot: Pilot, parameters: NavigationParameters, outline: Any):
        def topic(name: str, kind: type, latch: bool = False) -> Any:
            return rospy.Publisher(name, kind, queue_size=1, latch=latch, tcp_nodelay=True)

        self._pilot, self._parameters, self._outline = pilot, parameters, outline
        self._frame = parameters.global_frame_id
        self._state = topic("navigation", Navigation)
        self._amcl_pose = topic("amcl_pose", PoseWithCovarianceStamped, latch=True)
        self._cloud = topic("particlecloud", PoseArray)
        self._plan = topic("plan", Path)
        self._footprint = topic("footprint", PolygonStamped)
        self._map = topic("map", OccupancyGrid, latch=True)
        self._metadata = topic("map_metadata", MapMetaData, latch=True)
        self._tf = tf2_ros.TransformBroadcaster()
        self._status = StatusReport()
        self._due = dict.fromkeys(PERIODS, 0.0)
        self._planned = False
        self.tf_trouble, self.laser = "", NO_LASER
        self._said: Any = None
        self._told: Any = None
        self.tell_map()

    def tell_map(self) -> None:
        """Publish the map."""
        self.map_message = map_message(self._pilot.grid, self._frame, rospy.Time.now())
        self._map.publish(self.map_message)
        self._metadata.publish(self.map_message.info)

    def has_said(self, state: State, reason: str) -> None:
        """The log has this state and its reason already: they are no news."""
        self._said = state, kind_of(reason)

    def tell(self, step: PilotStep, stamp: rospy.Time) -> None:
        """Publish what a step says, with the stamp of its packet, and log it when it is news."""
        if step.where is not None:
            self._tell_state(step, step.where, stamp)
            if stamp != self._told:     # while the robot is silent nothing is known anew
                self._told = stamp
                self._tell_where(step, step.where, stamp)
                if step.jumped:
                    rospy.logwarn_throttle(JUMP_PERIOD, "the robot's odometry jumps, as after reset_odometry;"
                                                        " navigation goes on as if it did not")
        if self._cloud.get_num_connections() and self._is_due("cloud"):
            self._cloud.publish(cloud_message(self._pilot.particles, MOST_DRAWN, self._frame, stamp))
        if (step.plan or self._planned) and self._plan.get_num_connections() and self._is_due("plan"):
            self._planned = bool(step.plan)
            self._plan.publish(path_message(step.plan, self._frame, stamp))
        if self._pilot.makes_map and self._is_due("map"):
            self.tell_map()
        self._status.publish(step, self.tf_trouble, self.laser, monotonic())
        if step.late > LATE:
            rospy.logwarn_throttle(LATE_PERIOD, late_text(step.late))
        said = step.state, kind_of(step.reason)     # the same with another number is no news
        if said != self._said:
            self._said = said
            (rospy.logwarn if step.state is State.FAILED else rospy.loginfo)("%s: %s", step.state.value, step.reason)

    def _tell_where(self, step: PilotStep, where: Where, stamp: Any) -> None:
        ahead = rospy.Duration.from_sec(self._parameters.transform_tolerance)
        self._tf.sendTransform(odom_on_map(where.pose, step.odometry, self._frame, self._parameters.odom_frame,
                                           stamp + ahead))
        self._amcl_pose.publish(pose_with_covariance(where.pose, where.covariance, self._frame, stamp))
        if self._footprint.get_num_connections():
            self._footprint.publish(footprint_message(self._outline, self._parameters.base_frame, stamp))

    def _tell_state(self, step: PilotStep, where: Where, stamp: Any) -> None:
        self._state.publish(Navigation(
            header_of(self._frame, stamp), step.state.value, step.reason, where.sure, where.reason, pose2d(where.pose),
            [pose2d(step.goal)] if step.goal else [], step.twist.linear, step.twist.angular))

    def _is_due(self, what: str) -> bool:
        now = monotonic()
        if now < self._due[what]:
            return False
        self._due[what] = now + PERIODS[what]
        return True

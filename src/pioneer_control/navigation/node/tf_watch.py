"""Hears tf: where frames are on the map, and whether somebody else publishes the frames of this robot.

Navigation drives by what its own robot tells, not by tf: another robot or another localisation with the same frames
does no harm to the way to a goal on the map. But who asks tf where the robot is gets two answers in turn.

In a crowd nobody can hear all of tf: of 30 robots, each would take what 60 nodes publish, ten times a second. That took
more time than to navigate. There goals must be in the frame of the map.
"""

import threading
from math import inf
from time import monotonic
from typing import Any, Callable, Dict, List, Set

import rospy
import tf2_ros
from tf2_msgs.msg import TFMessage

from ...errors import UsageError
from ...floor_poses import Pose
from ...ros_node import sender_of
from .messages import pose_of_transform

FORGOTTEN = 2.0
"""Time (s) after which somebody who published a frame publishes it no more."""
SETTLING = 0.5
"""Time (s) after ROS time has jumped back in which somebody may still send stamps of before."""
MOST_PUBLISHERS = 12
"""Most nodes that may publish tf: those of six robots."""


class TfWatch:
    """Knows where frames are, and who publishes those of this robot.

    Args:
        frames: the frames that one node alone may publish.
        now: returns the ROS time (s).
    """

    def __init__(self, *frames: str, now: Callable[[], float] = rospy.get_time):
        self._said: Dict[str, Dict[str, float]] = {frame: {} for frame in frames}     # by frame: who, and until when
        self._buffer = tf2_ros.Buffer(debug=False)
        self._now, self._newest, self._settled_at, self._lock = now, 0.0, 0.0, threading.Lock()
        self._subscribers = [rospy.Subscriber(topic, TFMessage, self._hear, is_static, queue_size=100)
                             for topic, is_static in (("/tf", False), ("/tf_static", True))]

    def _hear(self, message: Any, is_static: bool) -> None:
        keep = self._buffer.set_transform_static if is_static else self._keep
        who, until = sender_of(message), inf if is_static else monotonic() + FORGOTTEN
        for transform in message.transforms:
            keep(transform, who)
            publishers = self._said.get(transform.child_frame_id.lstrip("/"))
            if publishers is not None:
                publishers[who] = until

    def _keep(self, transform: Any, who: str) -> None:
        """Keep a transform that moves. When ROS time jumps back, older ones would count until it has caught up."""
        with self._lock:        # each publisher has a thread
            now = self._now()
            if now < self._newest:
                self._settled_at = monotonic() + SETTLING
                self._buffer.clear()        # static ones stay
            self._newest = now
            if monotonic() >= self._settled_at:
                self._buffer.set_transform(transform, who)

    def leave_a_crowd(self) -> None:
        """Hear no tf any more if too many nodes publish it, and say so."""
        count = self._subscribers[0].get_num_connections() if self._subscribers else 0
        if count > MOST_PUBLISHERS:
            subscribers, self._subscribers = self._subscribers, []
            for subscriber in subscribers:
                subscriber.unregister()
            self._said = {frame: {} for frame in self._said}
            rospy.loginfo("%d nodes publish tf: navigation hears it no more, and takes goals in the frame of the map"
                          " alone", count)

    def pose(self, frame: str, parent: str) -> Pose:
        """Return where a frame is in another one.

        Raises:
            UsageError: nobody says so, or several nodes, or navigation hears no tf.
        """
        if not self._subscribers:
            raise UsageError("more than %d nodes publish tf: navigation does not hear where its frame %r is; it must be"
                             " in %r" % (MOST_PUBLISHERS, frame, parent))
        trouble = self.trouble()
        if trouble:
            raise UsageError("where its frame %r is nobody knows for sure: %s" % (frame, trouble))
        return pose_of_transform(self.transform(frame, parent))

    def transform(self, frame: str, parent: str) -> Any:
        """Return where a frame is in another one, also where several nodes publish: the newest of them counts.

        Raises:
            UsageError: nobody says so.
        """
        try:
            return self._buffer.lookup_transform(parent, frame, rospy.Time(0)).transform
        except tf2_ros.TransformException:
            raise UsageError("nobody says where its frame %r is in %r" % (frame, parent)) from None

    def _tell_static(self) -> Set[str]:
        """Return the nodes that publish static transforms now. Each says them once: who has ended does not count."""
        topics = [subscriber.impl for subscriber in self._subscribers[-1:]]     # of rospy; None: just unregistered
        return {each.callerid_pub for topic in topics if topic is not None for each in topic.connections
                if not each.done}

    def trouble(self) -> str:
        """Return which frame several nodes publish, for people; empty when each has one publisher."""
        now, connected = monotonic(), self._tell_static()
        several: List[str] = []
        for frame, publishers in self._said.items():
            names = sorted(name for name, until in publishers.copy().items()
                           if until > now and (until < inf or name in connected))
            if len(names) > 1:
                several.append("%s: %s" % (frame, " and ".join(names)))
        if not several:
            return ""
        return ("several nodes tell tf where a frame is (%s): end all but one, or give each robot its frame_prefix;"
                " a simulator keeps the truth to itself with pioneer.launch hides_truth:=true" % "; ".join(several))

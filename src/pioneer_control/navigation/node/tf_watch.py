"""Looks whether somebody else publishes the frames of this robot: another robot, or another localisation.

Navigation drives by what its own robot tells, not by tf: the way to a goal on the map is not harmed. But who asks tf
where the robot is gets two answers in turn.
"""

from time import monotonic
from typing import Any, Dict, List

import rospy
from tf2_msgs.msg import TFMessage

FORGOTTEN = 2.0
"""Time (s) after which somebody who published a frame publishes it no more."""


class TfWatch:
    """Knows who publishes where some frames are.

    Args:
        frames: the frames that one node alone may publish.
    """

    def __init__(self, *frames: str):
        self._said: Dict[str, Dict[str, float]] = {frame: {} for frame in frames}     # by frame: who, and until when
        for topic, lasts in (("/tf", FORGOTTEN), ("/tf_static", float("inf"))):
            rospy.Subscriber(topic, TFMessage, self._hear, lasts, queue_size=100)

    def _hear(self, message: Any, lasts: float) -> None:
        for transform in message.transforms:
            publishers = self._said.get(transform.child_frame_id.lstrip("/"))
            if publishers is not None:
                publishers[message._connection_header["callerid"]] = monotonic() + lasts

    def trouble(self) -> str:
        """Return which frame several nodes publish, for people; empty when each has one publisher."""
        now = monotonic()
        several: List[str] = []
        for frame, publishers in self._said.items():
            names = sorted(name for name, until in publishers.copy().items() if until > now)
            if len(names) > 1:
                several.append("%s: %s" % (frame, " and ".join(names)))
        if not several:
            return ""
        return "several nodes tell tf where a frame is (%s): end all but one, or give each robot its frame_prefix" % (
            "; ".join(several))

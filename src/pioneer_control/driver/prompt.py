"""Publishes messages with less delay than rospy. You can skip this file: without it messages only leave later.

`prompt_connection` is the other half of it: how their bytes get to a subscriber.

* genpy makes and serializes a message field by field, and rospy checks each message and writes it to a buffer first.
  Here the pose, its transform and the sonar array are serialized with one `struct` call each, and go to the connections
  of the topic at once.
* A program that subscribes to several topics reads each of them in a thread of its own. When the messages of all topics
  come at once, these threads delay one another. So the pose leaves a little earlier than the others (POSE_AHEAD).

bench/driver_pieces.md has the measured gain of each. If the installed rospy is not as this file expects, the driver
publishes with rospy's own code.
"""

import struct
from contextlib import suppress
from math import cos, sin
from types import SimpleNamespace
from typing import Any, Callable, Dict, List

import rospy
import rospy.topics
from std_msgs.msg import Header

from ..client import RobotState, SonarRange
from .conversions import Covariances, ranges

POSE_AHEAD = 0.0003
"""The time (s) by which the pose leaves before the other messages that are made from the same SIP."""


class PromptMessage:
    """Base class: a fast replacement for the messages of one topic that are made from a state of the robot.

    The converter fills and returns the same object for each state, because rospy serializes a message at once.

    Args:
        frames: the names of the frames in the message. The first one is the frame of its header.
    """

    def __init__(self, *frames: str) -> None:
        self.header = Header(frame_id=frames[0])
        # ROS serializes a text as its length in bytes (4 bytes), then the text in UTF-8.
        names = [name.encode() for name in frames]
        self._frames = b"".join(struct.pack("<I%ds" % len(name), len(name), name) for name in names)

    def of(self, state: RobotState, stamp: Any) -> "PromptMessage":
        """Fill this message with a state of the robot and its stamp, and return the message."""
        self._state, self.header.stamp = state, stamp
        return self

    def serialized(self) -> bytes:
        """Return the serialized message, with the number that header.seq has now, if the message has a header."""
        raise NotImplementedError


class PoseMessage(PromptMessage):
    """Replaces nav_msgs/Odometry: pose in the odom frame (m, rad), twist in base_link (m/s, rad/s).

    Args:
        odom_frame: the name of the odom frame.
        base_link_frame: the name of the frame base_link.
        covariance: the covariances for a moving robot (True) and a standing robot (False).
    """

    def __init__(self, odom_frame: str, base_link_frame: str, covariance: Dict[bool, Covariances]) -> None:
        super().__init__(odom_frame, base_link_frame)
        self._covariance = {moves: (struct.pack("<36d", *each.pose), struct.pack("<36d", *each.twist))
                            for moves, each in covariance.items()}
        self._struct = struct.Struct("<3I%ds7d288s6d288s" % len(self._frames))

    def serialized(self) -> bytes:
        header, state = self.header, self._state
        half = state.heading / 2
        pose, twist = self._covariance[state.moving]
        return self._struct.pack(
            header.seq, header.stamp.secs, header.stamp.nsecs, self._frames,
            state.x, state.y, 0.0, 0.0, 0.0, sin(half), cos(half), pose,
            state.linear, 0.0, 0.0, 0.0, 0.0, state.angular, twist)


class TransformMessage(PromptMessage):
    """Replaces tf2_msgs/TFMessage with one transform: the pose of base_link in the odom frame (m, rad).

    Args:
        frames: the names of the odom frame and of the frame base_link.
    """

    def __init__(self, *frames: str) -> None:
        super().__init__(*frames)
        self._struct = struct.Struct("<4I%ds7d" % len(self._frames))

    def serialized(self) -> bytes:
        stamp, state = self.header.stamp, self._state
        half = state.heading / 2
        return self._struct.pack(       # one transform; nobody counts the header inside it
            1, 0, stamp.secs, stamp.nsecs, self._frames, state.x, state.y, 0.0, 0.0, 0.0, sin(half), cos(half))


class SonarMessage(PromptMessage):
    """Replaces SonarArray: the ranges (m) by transducer number, as in conversions.ranges.

    Args:
        frames: the name of the frame base_link.
    """

    def serialized(self) -> bytes:
        stamp, found = self.header.stamp, ranges(self._state)
        return struct.pack(
            "<3I%dsiI%dd" % (len(self._frames), len(found)),
            self.header.seq, stamp.secs, stamp.nsecs, self._frames, len(found), len(found), *found)


def publish(publisher: Any, message: Any) -> None:
    """Publish a message on the topic of a rospy.Publisher.

    A PromptMessage takes the same way as in rospy, but without its checks and its buffer. It goes nowhere when rospy
    has closed the topic, as it does at a shutdown.
    """
    topic: Any = getattr(publisher, "impl", None)
    if topic is None or not isinstance(message, PromptMessage):
        publisher.publish(message)
        return
    lock = topic.publock
    if lock is None:    # closed
        return
    with lock:
        topic.seq = message.header.seq = topic.seq + 1
        serialized = message.serialized()
        data = len(serialized).to_bytes(4, "little") + serialized
        topic.message_data_sent += len(data)
        for connection in topic.connections:
            try:
                connection.write_data(data)
            except Exception:       # any exception: the subscriber is gone
                with suppress(Exception):
                    connection.close()      # it takes itself off the topic


EXAMPLE: Any = SimpleNamespace(x=1.0, y=2.0, heading=0.5, linear=0.1, angular=0.2, moving=True, time=9.0,
                               sonar=(None, SonarRange(1.5, 8.9)))


def converter(prompt: PromptMessage, plain: Callable[[RobotState, Any], Any]) -> Callable[[RobotState, Any], Any]:
    """Return a function that converts a state of the robot and its stamp to a message.

    The message is ``prompt``. It is the ordinary ROS message, which ``plain`` makes, when a subscriber would not get
    exactly the same bytes for both.
    """
    with suppress(Exception):       # any exception: another version of rospy may raise anything
        ordinary = plain(EXAMPLE, rospy.Time(1, 2))
        if _sent(prompt.of(EXAMPLE, rospy.Time(1, 2)), type(ordinary)) == _sent(ordinary, type(ordinary)):
            return prompt.of
    return plain


def _sent(message: Any, kind: type) -> List[bytes]:
    """Return the bytes that a subscriber gets when this message is published on a topic of this type."""
    sent: List[bytes] = []
    topic = rospy.topics._PublisherImpl("/example", kind)
    topic.connections = [SimpleNamespace(write_data=sent.append)]
    publish(SimpleNamespace(impl=topic, publish=topic.publish), message)
    return sent

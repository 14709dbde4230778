"""What makes messages leave sooner. A reader of the driver can skip this file: without it all is the same, and a little
later.

* rospy hands each message to a thread per subscriber, and that thread has to wake up first. Here the thread that
  publishes writes to the socket itself, as far as that cannot hold it up.
* genpy visits each field of a message. Pose, transform and sonar write themselves in one go here.

bench/driver_pieces.md has what each of them gains. Where rospy is not as this file expects it, all goes rospy's own
way.
"""

import inspect
import io
import socket
import struct
import threading
from collections import deque
from functools import lru_cache
from math import cos, sin
from types import SimpleNamespace
from typing import Any, BinaryIO, Callable, Deque, Dict, NamedTuple, Optional, Sequence

import rospy
import rospy.msg
import rospy.topics
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from ..client import RobotState
from ..msg import SonarArray
from . import conversions
from .conversions import Covariances, ranges_by_number

EXPECTED = ["self", "connection", "queue_size"]
"""Arguments of what makes a connection to a subscriber."""


def send_promptly() -> bool:
    """Publish like this from now on, whatever the publisher: to be called before the first subscriber comes.

    Returns:
        Whether rospy is as expected. If not, nothing is changed.
    """
    own: Any = getattr(rospy.topics, "QueuedConnection", None)
    if not inspect.isclass(own) or list(inspect.signature(own.__init__).parameters) != EXPECTED:
        return False

    def connect(connection: Any, queue_size: int) -> Any:
        is_socket = isinstance(getattr(connection, "socket", None), socket.socket)
        return (PromptConnection if is_socket else own)(connection, queue_size)

    rospy.topics.QueuedConnection = connect
    return True


class PromptConnection:
    """A connection to one subscriber, in the place of rospy's QueuedConnection, and with its interface.

    The thread that publishes a message writes as much of it as the socket takes at once. What is left waits, and so
    does what is published meanwhile: the newest ``queue_size`` messages (0: all). A thread writes what waits. So a
    subscriber that does not read holds up nobody.

    Args:
        connection: rospy's connection; all else that is asked of this one is asked of it.
    """

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._connection = connection
        self._rest = b""                # of a message of which a part is written
        self._waiting: Deque[bytes] = deque(maxlen=queue_size or None)
        self._writing = False           # some thread writes a message
        self._error: Optional[Exception] = None
        self._lock = threading.RLock()      # reentrant, for signal handlers
        self._changed = threading.Condition(self._lock)
        connection.set_cleanup_callback(self._closed)
        threading.Thread(target=self._write_what_waits, name="waiting messages", daemon=True).start()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one message, or let it wait. Raises what went wrong with one before: rospy then drops the connection."""
        with self._lock:
            if self._error is not None:
                error, self._error = self._error, None
                raise error
            if self._rest or self._waiting or self._writing:
                self._waiting.append(data)
            else:
                self._writing = True        # a signal handler may publish in the midst of it
                self._rest = data[self._written_at_once(data):]
                self._writing = False
            if self._rest or self._waiting:
                self._changed.notify()
        return True

    def _written_at_once(self, data: bytes) -> int:
        """Write as many bytes as the socket takes at once; how many.

        A broken one takes none: the thread finds out, as rospy does.
        """
        try:
            count: int = self._connection.socket.send(data, socket.MSG_DONTWAIT)
        except (OSError, AttributeError):       # AttributeError: it is closed
            return 0
        self._connection.stat_bytes += count
        self._connection.stat_num_msg += 1
        return count

    def _closed(self, _: Any) -> None:
        with self._changed:
            self._changed.notify()

    def _has_work(self) -> bool:
        return bool(self._rest or self._waiting or self._connection.done)

    def _write_what_waits(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(self._has_work)
                if self._connection.done:
                    return
                data, self._rest = self._rest or self._waiting.popleft(), b""
                self._writing = True
            error = None
            try:
                self._connection.write_data(data)
            except Exception as raised:     # of any kind: it is raised when the next message is published
                error = raised
            with self._changed:
                self._writing, self._error = False, error or self._error


class PoseMessage:
    """A nav_msgs/Odometry: pose in the odometry frame, twist in base_link, with the covariances for a robot that moves
    or stands.
    """

    _type, _md5sum, _has_header = Odometry._type, Odometry._md5sum, True

    def __init__(self, odom_frame: str, base_link_frame: str, covariance: Dict[bool, Covariances]) -> None:
        self.header = Header(frame_id=odom_frame)
        self._frames = _string(odom_frame) + _string(base_link_frame)
        self._covariance = {moves: (_doubles(each.pose), _doubles(each.twist)) for moves, each in covariance.items()}
        self._struct = struct.Struct("<3I%ds7d288s6d288s" % len(self._frames))

    def of(self, state: RobotState, stamp: Any) -> "PoseMessage":
        """Say this from now on."""
        self._state, self.header.stamp = state, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it. rospy has counted it in the header before."""
        stamp, state = self.header.stamp, self._state
        half = state.heading / 2
        pose, twist = self._covariance[state.moving]
        buffer.write(self._struct.pack(
            self.header.seq, stamp.secs, stamp.nsecs, self._frames,
            state.x, state.y, 0.0, 0.0, 0.0, sin(half), cos(half), pose,
            state.linear, 0.0, 0.0, 0.0, 0.0, state.angular, twist))


class TransformMessage:
    """A tf2_msgs/TFMessage with one transform, odometry frame -> base_link, that says what the PoseMessage says."""

    _type, _md5sum = TFMessage._type, TFMessage._md5sum

    def __init__(self, odom_frame: str, base_link_frame: str) -> None:
        self._frames = _string(odom_frame) + _string(base_link_frame)
        self._struct = struct.Struct("<4I%ds7d" % len(self._frames))

    def of(self, state: RobotState, stamp: Any) -> "TransformMessage":
        """Say this from now on."""
        self._state, self._stamp = state, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it."""
        state, stamp = self._state, self._stamp
        half = state.heading / 2
        buffer.write(self._struct.pack(
            1, 0, stamp.secs, stamp.nsecs, self._frames, state.x, state.y, 0.0, 0.0, 0.0, sin(half), cos(half)))


class SonarMessage:
    """A SonarArray."""

    _type, _md5sum, _has_header = SonarArray._type, SonarArray._md5sum, True

    def __init__(self, base_link_frame: str) -> None:
        self.header = Header(frame_id=base_link_frame)
        self._frame = _string(base_link_frame)
        self._struct = lru_cache(maxsize=4)(lambda count: struct.Struct("<3I%dsiI%dd" % (len(self._frame), count)))

    def of(self, state: RobotState, stamp: Any) -> "SonarMessage":
        """Say this from now on."""
        self._state, self.header.stamp = state, stamp
        return self

    def serialize(self, buffer: BinaryIO) -> None:
        """Write it. rospy has counted it in the header before."""
        stamp, ranges = self.header.stamp, ranges_by_number(self._state)
        count = len(ranges)
        buffer.write(self._struct(count).pack(
            self.header.seq, stamp.secs, stamp.nsecs, self._frame, count, count, *ranges))


def _doubles(values: Sequence[float]) -> bytes:
    return struct.pack("<%dd" % len(values), *values)


def _string(text: str) -> bytes:
    """As ROS writes a string."""
    data = text.encode()
    return struct.pack("<I", len(data)) + data


class Converters(NamedTuple):
    """From a state and its stamp to what rospy publishes."""

    pose: Callable[[RobotState, Any], Any]
    transform: Callable[[RobotState, Any], Any]
    sonar: Callable[[RobotState, Any], Any]


KINDS = Converters(Odometry, TFMessage, SonarArray)
EXAMPLE: Any = SimpleNamespace(time=0.0, x=1.0, y=2.0, heading=0.5, linear=0.1, angular=0.2, moving=True, sonar=())


def converters(odom_frame: str, base_link_frame: str, covariance: Dict[bool, Covariances]) -> Converters:
    """To messages that write themselves, if rospy publishes them as it does ordinary ones; else to ordinary ones."""
    plain = Converters(
        lambda state, stamp: conversions.odometry(state, stamp, odom_frame, base_link_frame, covariance[state.moving]),
        lambda state, stamp: conversions.transform(state, stamp, odom_frame, base_link_frame),
        lambda state, stamp: conversions.sonar(state, stamp, base_link_frame))
    prompt = Converters(
        PoseMessage(odom_frame, base_link_frame, covariance).of,
        TransformMessage(odom_frame, base_link_frame).of,
        SonarMessage(base_link_frame).of)
    is_same = all(map(_is_published_as, KINDS, prompt, plain))
    return prompt if is_same else plain


def _is_published_as(kind: Any, prompt: Callable[[Any, Any], Any], plain: Callable[[Any, Any], Any]) -> bool:
    written = _published(kind, prompt(EXAMPLE, rospy.Time(1, 2)))
    return written is not None and written == _published(kind, plain(EXAMPLE, rospy.Time(1, 2)))


def _published(kind: type, message: Any) -> Optional[bytes]:
    """The bytes that rospy writes; None if it refuses the message, or does it in another way."""
    buffer = io.BytesIO()
    try:
        rospy.msg.serialize_message(buffer, 1, rospy.msg.args_kwds_to_message(kind, (message,), {}))
    except Exception:       # of any kind: nobody knows what rospy does then
        return None
    return buffer.getvalue()

"""Publishes messages from the thread that has them. You can skip this file: without it messages only leave later.

rospy passes each message to one thread for each subscriber, and this thread must wake up first. Here the thread that
publishes writes to the socket itself, if the socket takes the bytes at once. The nodes of devices with many messages
use this. bench/driver_pieces.md and bench/laser.md have the measured gain. If the installed rospy is not as this file
expects, messages go its own way.
"""

import inspect
import socket
import threading
from collections import deque
from typing import Any, Deque, Optional

import rospy.topics

EXPECTED = ["self", "connection", "queue_size"]
"""The arguments that the constructor of rospy's QueuedConnection must have."""


def send_promptly() -> bool:
    """Replace rospy's connection class with PromptConnection, for all publishers of this process.

    Call this before the first subscriber connects.

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
    """A connection to one subscriber that replaces rospy's QueuedConnection. It has the same interface.

    The thread that publishes a message writes as many bytes as the socket takes at once. The rest of the message waits,
    and later messages wait too. A second thread writes the waiting bytes. So a slow subscriber never blocks the thread
    that publishes.

    Args:
        connection: the connection of rospy. It gets all attribute requests that this class does not handle.
        queue_size: how many messages may wait; then the oldest is dropped. 0: no limit.
    """

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._connection = connection
        self._rest = b""                # the rest of a partly written message
        self._waiting: Deque[bytes] = deque(maxlen=queue_size or None)
        self._writing = False           # some thread writes a message
        self._error: Optional[Exception] = None
        self._lock = threading.RLock()      # reentrant, for signal handlers
        self._changed = threading.Condition(self._lock)
        connection.set_cleanup_callback(self._closed)
        threading.Thread(target=self._write_what_waits, name="waiting messages", daemon=True).start()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one serialized message, or put it into the queue.

        Raises the exception of an earlier write that failed. Then rospy closes the connection.
        """
        with self._lock:
            if self._error is not None:
                error, self._error = self._error, None
                raise error
            if self._rest or self._waiting or self._writing:
                self._waiting.append(data)
            else:
                self._writing = True        # a signal handler may publish during the next lines
                try:
                    count = self._connection.socket.send(data, socket.MSG_DONTWAIT)
                    self._connection.stat_bytes += count
                    self._connection.stat_num_msg += 1
                # The connection is broken or, with AttributeError, closed. The thread below gets the error then.
                except (OSError, AttributeError):
                    count = 0
                self._rest, self._writing = data[count:], False
            if self._rest or self._waiting:
                self._changed.notify()
        return True

    def _closed(self, _: Any) -> None:
        with self._changed:
            self._changed.notify()

    def _write_what_waits(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._rest or self._waiting or self._connection.done)
                if self._connection.done:
                    return
                data, self._rest = self._rest or self._waiting.popleft(), b""
                self._writing = True
            error = None
            try:
                self._connection.write_data(data)
            except Exception as raised:     # any exception: write_data raises it with the next message
                error = raised
            with self._changed:
                self._writing, self._error = False, error or self._error

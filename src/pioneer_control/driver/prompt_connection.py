"""Messages that leave at once. rospy hands each message to a thread per subscriber, and that thread has to wake up and to wait for its turn first:
0.1 to 0.2 ms, and as much work again as the message itself. Here whoever publishes writes to the socket, as long as that cannot hold him up.
"""

import select
import threading
from collections import deque
from typing import Any, Deque, Optional

import rospy.topics

LARGEST = 4096
"""Bytes of a message that is written by who publishes it: any buffer with room has as much. What is larger may wait in the midst of it."""


def send_promptly() -> None:
    """Publish like this from now on, whatever the publisher: to be called before the first subscriber comes."""
    rospy.topics.QueuedConnection = PromptConnection


class PromptConnection:
    """A connection to one subscriber, in the place of rospy's QueuedConnection, and with its interface.

    A message is written by the thread that publishes it while the socket has room, and nothing waits before it. A subscriber that does not read
    never holds up that thread: then messages wait, the newest ``queue_size`` of them (0: all), and a thread of their own writes them.

    Args:
        connection: rospy's Transport; all else that is asked of this one is asked of it.
    """

    def __init__(self, connection: Any, queue_size: int) -> None:
        self._connection = connection
        self._room = select.poll()  # true while a third of the socket's buffer is free
        self._room.register(connection.fileno(), select.POLLOUT)
        self._waiting: Deque[bytes] = deque(maxlen=queue_size or None)
        self._writing = False       # one message, whoever does it; without the lock, for rospy has its own, and closes a connection that breaks
        self._error: Optional[Exception] = None
        self._lock = threading.RLock()   # reentrant, for signal handlers
        self._changed = threading.Condition(self._lock)
        connection.set_cleanup_callback(self._closed)
        threading.Thread(target=self._write_what_waits, name="waiting messages", daemon=True).start()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send one message, or let it wait. Raises what went wrong with one before, or with this one: rospy then drops the connection."""
        with self._lock:
            if self._error is not None:
                error, self._error = self._error, None
                raise error
            if self._writing or self._waiting or len(data) > LARGEST or not self._room.poll(0):
                self._waiting.append(data)
                self._changed.notify()
                return True
            self._writing = True
        try:
            return self._connection.write_data(data)
        finally:
            with self._lock:
                self._writing = False
                if self._waiting:
                    self._changed.notify()

    def _closed(self, _: Any) -> None:
        with self._lock:
            self._changed.notify()

    def _write_what_waits(self) -> None:
        while True:
            with self._lock:
                self._changed.wait_for(lambda: self._waiting and not self._writing or self._connection.done)
                if self._connection.done:
                    return
                data, self._writing = self._waiting.popleft(), True
            error = None
            try:
                self._connection.write_data(data)
            except Exception as raised:     # whatever it is, it is for whoever publishes next
                error = raised
            with self._lock:
                self._writing, self._error = False, error or self._error

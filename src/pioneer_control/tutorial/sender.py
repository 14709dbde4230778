"""Publishing from a thread of its own, so that the robot can be stopped from inside a signal handler."""

import queue
import threading
import time
from typing import Any, Optional, Tuple

END_TIMEOUT = 1.0  #: s that `Sender.end` waits at most
REPEATS, REPEAT_AFTER = 5, 0.05  #: the last stop: how often, and s between


class Sender:
    """Publishes what it is given, in order. At its end it publishes a stop, if the last velocity was a movement.

    rospy runs shutdown hooks in the signal handler, on top of whatever the main thread was just doing. When that was
    publishing, the hook waits for ever for locks that the interrupted call holds. With a sender the main thread never
    publishes, and to give it a message takes no lock.

    Source: Python's documentation of `queue` (a SimpleQueue may be used in a signal handler).
    """

    def __init__(self, velocity: Any, stop: Any):
        """Begin with nothing to publish.

        Args:
            velocity: the publisher of movements.
            stop: its message for standing still.
        """
        self._velocity, self._stop = velocity, stop
        self._messages: "queue.SimpleQueue[Optional[Tuple[Any, Any]]]" = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="sender", daemon=True)
        self._thread.start()

    def send(self, publisher: Any, message: Any) -> None:
        """Publish a message soon. After `end` it is dropped."""
        self._messages.put((publisher, message))

    def end(self) -> None:
        """Publish what was given until now, then the stop, and nothing any more.

        Any thread and any signal handler may call it, more than once too.
        """
        self._messages.put(None)
        self._thread.join(END_TIMEOUT)

    def _run(self) -> None:
        last = self._stop
        for publisher, message in iter(self._messages.get, None):
            publisher.publish(message)
            last = message if publisher is self._velocity else last
        for _ in range(REPEATS if last != self._stop else 0):
            self._velocity.publish(self._stop)
            time.sleep(REPEAT_AFTER)
        time.sleep(REPEAT_AFTER)  # the process may end next: give the threads that send time to do it

"""Publishes messages in a separate thread, so that a signal handler can stop the robot safely."""

import queue
import threading
import time
from typing import Any, Optional, Tuple

END_TIMEOUT = 1.0  #: s, the longest time that `Sender.end` waits
REPEATS, REPEAT_AFTER = 5, 0.05  #: how often the final stop is published, and the time between two of them [s]


class Sender:
    """Publishes messages in a separate thread, in order. At the end it stops the robot, if the robot is driving.

    rospy runs shutdown hooks in the signal handler, which interrupts the main thread. If the main thread was just
    publishing, a hook that publishes waits for ever for a lock that the interrupted call holds. With a Sender the main
    thread never publishes. It only puts messages into a queue, which is safe in a signal handler.

    Source: Python's documentation of `queue` (a SimpleQueue may be used in a signal handler).
    """

    def __init__(self, velocity: Any, stop: Any):
        """Start the thread that publishes.

        Args:
            velocity: the publisher of velocity commands.
            stop: the message on `velocity` that stops the robot.
        """
        self._velocity, self._stop = velocity, stop
        self._messages: "queue.SimpleQueue[Optional[Tuple[Any, Any]]]" = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="sender", daemon=True)
        self._thread.start()

    def send(self, publisher: Any, message: Any) -> None:
        """Put a message into the queue: the thread publishes it soon. After `end` the message is dropped."""
        self._messages.put((publisher, message))

    def end(self) -> None:
        """Publish the messages in the queue, then a stop if the last velocity was not a stop, then nothing more.

        Any thread and any signal handler may call this method, also more than once. It waits at most END_TIMEOUT
        seconds.
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

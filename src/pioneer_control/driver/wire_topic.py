"""Publishes every byte to and from the robot on the topic `wire`, if the parameter publish_wire is true.

The threads that read and write the serial line only put the bytes into a queue. Another thread checks the queue every
50 ms and publishes the bytes. It is not woken for each write, because this would slow down the thread that writes.
"""

import threading
from collections import deque
from time import monotonic
from typing import Any, Deque, Tuple

import rospy

from ..msg import Wire
from . import publications
from .notices import Throttle

QUEUE = 1000
"""The queue size of the publisher. A slow subscriber misses the oldest messages, and sees a gap in header.seq."""
LONGEST = 2000
"""How many pieces (one read or write each) may wait to be published. On an idle line this is enough for minutes."""
PERIOD, IDLE = 0.05, 0.5
"""Seconds between two checks of the queue: PERIOD while the topic has a subscriber, IDLE while it has none."""
FIRST_LISTENER = 5.0
"""The longest time (s) that the first bytes wait for a subscriber. A recorder needs a moment to find a new topic."""


class WirePublisher(rospy.SubscribeListener):
    """Publishes the bytes that `tell` gets, in the same order, while the topic has a subscriber."""

    def __init__(self) -> None:
        # One piece for each read or write: its time (monotonic, s), whether it was a write, its bytes, and how many
        # pieces were dropped before it.
        self._pieces: Deque[Tuple[float, bool, bytes, int]] = deque()
        self._left_out = [0, 0]     # from and to the robot: each is counted by one thread at a time
        self._told_left_out = 0
        self._throttle = Throttle()
        self._ended = False
        self._look = threading.Event()      # set: check the queue at once
        self._publisher = rospy.Publisher("wire", Wire, self, tcp_nodelay=True, queue_size=QUEUE)
        threading.Thread(target=self._run, name="wire", daemon=True).start()

    def tell(self, to_robot: bool, data: bytes) -> None:
        """Put the bytes of one read or write into the queue. Never block. (The client calls this as on_wire.)

        When LONGEST pieces are in the queue, the new piece is dropped and counted.

        Args:
            to_robot: true for a write, false for a read.
            data: the bytes.
        """
        if len(self._pieces) >= LONGEST:
            self._left_out[to_robot] += 1
        elif not self._ended:
            self._pieces.append((monotonic(), to_robot, data, sum(self._left_out)))

    def close(self) -> None:
        """Publish the pieces in the queue, then end. Pieces that come from now on are ignored."""
        self._ended = True
        self._look.set()

    def peer_subscribe(self, *_: Any) -> None:
        """Wake up the thread that publishes. rospy calls this when a subscriber connects."""
        self._look.set()

    def _run(self) -> None:
        self._look.wait(0.0 if self._publisher.get_num_connections() else FIRST_LISTENER)
        try:
            last = False
            while not last:
                self._look.clear()
                last, listened = self._ended, self._publisher.get_num_connections() > 0
                for _ in range(len(self._pieces)):
                    piece = self._pieces.popleft()
                    if listened:
                        self._publish(*piece)
                self._look.wait(PERIOD if listened else IDLE)
        except rospy.ROSException:
            if not rospy.is_shutdown():     # then the topic is closed
                raise

    def _publish(self, time: float, to_robot: bool, data: bytes, left_out: int) -> None:
        message = Wire(to_robot=to_robot)
        message.header.stamp = rospy.Time.from_sec(max(0.0, publications.ros_time() - (monotonic() - time)))
        if left_out != self._told_left_out:
            if self._throttle.passes("left out", monotonic()):
                rospy.logwarn("ROS was too slow for all bytes of the line: %d pieces are missing in wire until now",
                              left_out)
            self._told_left_out = left_out
            self._publisher.publish(message)
        message.data = data
        self._publisher.publish(message)

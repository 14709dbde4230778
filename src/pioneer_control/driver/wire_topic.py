"""Out: every byte of the robot's line, both ways, on the topic `wire`, with the parameter publish_wire.

A thread that writes to the robot or reads from it only puts the bytes aside. A thread of its own looks for them every
50 ms, and publishes them. To wake that thread at each write would slow down the thread that writes.
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
"""So many messages may wait for one subscriber. Of more than these, the subscriber misses the oldest, and sees a gap in
the numbers (seq).
"""
LONGEST = 2000
"""So many pieces may wait to be published: minutes of an idle line."""
PERIOD, IDLE = 0.05, 0.5
"""Seconds between two looks, while somebody listens and while nobody does."""
FIRST_LISTENER = 5.0
"""The first bytes wait so many seconds, at most, for a recorder that runs already: it needs a moment to hear of a new
topic.
"""


class WirePublisher(rospy.SubscribeListener):
    """Publishes what `tell` is told, in that order, as long as somebody listens."""

    def __init__(self) -> None:
        # Bytes of one read or write: when it was (monotonic, s), whether it was a write, the bytes, and how many pieces
        # of both ways were left out until then.
        self._pieces: Deque[Tuple[float, bool, bytes, int]] = deque()
        self._left_out = [0, 0]     # from and to the robot: each is counted by one thread at a time
        self._told_left_out = 0
        self._throttle = Throttle()
        self._ended = False
        self._look = threading.Event()      # at once
        self._publisher = rospy.Publisher("wire", Wire, self, tcp_nodelay=True, queue_size=QUEUE)
        threading.Thread(target=self._run, name="wire", daemon=True).start()

    def tell(self, to_robot: bool, data: bytes) -> None:
        """Take bytes of the line (Robot's on_wire), and never wait.

        While LONGEST pieces wait to be published, further ones are left out, and counted.
        """
        if len(self._pieces) >= LONGEST:
            self._left_out[to_robot] += 1
        elif not self._ended:
            self._pieces.append((monotonic(), to_robot, data, sum(self._left_out)))

    def close(self) -> None:
        """Publish what was told, and nothing that is told from now on."""
        self._ended = True
        self._look.set()

    def peer_subscribe(self, *_: Any) -> None:
        """Called by rospy: somebody listens now."""
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

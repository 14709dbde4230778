"""Out: every byte of the robot's line, both ways, on the topic `wire`, with the parameter publish_wire.

Whoever writes to the robot or reads from it only puts the bytes into a queue; a thread of its own publishes them.
"""

import threading
from queue import SimpleQueue
from time import monotonic
from typing import NamedTuple, Optional

import rospy

from ..msg import Wire
from . import publications

QUEUE = 1000
"""Messages that wait for one subscriber; beyond them it misses the oldest, and sees that their numbers (seq) have a gap."""
LONGEST = 2000
"""Pieces that wait to be published: minutes of an idle line."""
FIRST_LISTENER = 5.0
"""Seconds, at most, for which the first bytes wait for a recorder that was there before: it needs a moment to hear of a new topic."""


class Piece(NamedTuple):
    """Bytes of one read or write, and how many pieces had been left out by then, of either way."""

    time: float
    to_robot: bool
    data: bytes
    left_out: int


class WirePublisher(rospy.SubscribeListener):
    """Publishes what `tell` is told, in that order, as long as somebody listens."""

    def __init__(self) -> None:
        self._pieces: "SimpleQueue[Optional[Piece]]" = SimpleQueue()
        self._left_out = [0, 0]     # from and to the robot: each is counted by one thread at a time
        self._heard = threading.Event()
        self._publisher = rospy.Publisher("wire", Wire, self, tcp_nodelay=True, queue_size=QUEUE)
        threading.Thread(target=self._run, name="wire", daemon=True).start()

    def tell(self, to_robot: bool, data: bytes) -> None:
        """Robot's on_wire: never waits. What finds the queue full is left out, and counted."""
        if self._pieces.qsize() < LONGEST:
            self._pieces.put(Piece(monotonic(), to_robot, data, sum(self._left_out)))
        else:
            self._left_out[to_robot] += 1

    def close(self) -> None:
        """Publish nothing that is told from now on."""
        self._pieces.put(None)

    def peer_subscribe(self, *_) -> None:
        """Called by rospy: somebody listens now."""
        self._heard.set()

    def _run(self) -> None:
        if not self._publisher.get_num_connections():
            self._heard.wait(FIRST_LISTENER)
        told = 0
        try:
            for piece in iter(self._pieces.get, None):
                if self._publisher.get_num_connections():
                    if piece.left_out != told:
                        rospy.logwarn("ROS was too slow for all bytes of the line: %d pieces are missing in wire", piece.left_out - told)
                        self._publish(piece._replace(data=b""))
                    self._publish(piece)
                told = piece.left_out
        except rospy.ROSException:
            if not rospy.is_shutdown():     # then the topic is closed
                raise

    def _publish(self, piece: Piece) -> None:
        message = Wire(to_robot=piece.to_robot, data=piece.data)
        message.header.stamp = rospy.Time.from_sec(max(0.0, publications.ros_time() - (monotonic() - piece.time)))
        self._publisher.publish(message)

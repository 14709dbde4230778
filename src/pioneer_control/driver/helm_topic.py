"""Publishes who may command the robot on the latched topic `helm`, at each change, whether there is a link or not.

A thread of its own publishes. So a subscriber that hangs delays no command, and a commander who falls silent is noticed
although no message comes.
"""

import threading

import rospy
from std_msgs.msg import Header

from ..client import HelmState, SteeredRobot
from ..msg import Helm

SHORTEST = 0.02
"""The shortest time (s) between two messages."""


class HelmPublisher:
    """Publishes the state of one helm. Create it, give `wake` to the SteeredRobot, then call `start`."""

    def __init__(self) -> None:
        self._changed = threading.Event()
        self._ended = threading.Event()
        self._publisher = rospy.Publisher("helm", Helm, tcp_nodelay=True, latch=True, queue_size=10)

    def wake(self) -> None:
        """Publish soon, because something has changed. Never blocks."""
        self._changed.set()

    def start(self, steered: SteeredRobot) -> None:
        """Publish the present state, and from now on each change."""
        threading.Thread(target=self._run, args=(steered,), name="helm", daemon=True).start()

    def close(self) -> None:
        """Publish nothing more."""
        self._ended.set()
        self._changed.set()

    def _run(self, steered: SteeredRobot) -> None:
        published = None
        try:
            while not self._ended.is_set():
                self._changed.clear()
                steered.look()
                state = steered.state()
                if state != published:
                    published = state
                    self._publisher.publish(helm_message(state))
                self._changed.wait(min(max(steered.changes_in(), SHORTEST), threading.TIMEOUT_MAX))
        except rospy.ROSException:
            if not rospy.is_shutdown():     # then the topic is closed
                raise


def helm_message(state: HelmState) -> Helm:
    """Return the message that shows a state of the helm."""
    return Helm(Header(stamp=rospy.Time.now()), state.commander, state.who, bool(state.holder), list(state.locks))

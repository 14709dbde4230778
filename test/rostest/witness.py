"""For all online tests: messages kept in order, and waiting for a condition instead of a time."""

import math
import threading
import time

import rospy

PATIENCE = 40.0
"""Seconds after which a test gives up waiting for what should happen at once."""


class Witness:
    """Keeps all messages of some topics, and wakes the threads that wait for a condition."""

    def __init__(self, topics):
        """`topics`: {topic: message class}."""
        self.changed = threading.Condition()
        self.seen = {topic: [] for topic in topics}
        self._subscribers = {topic: rospy.Subscriber(topic, kind, self._keep, topic) for topic, kind in topics.items()}

    def _keep(self, message, topic):
        with self.changed:
            self.seen[topic].append(message)
            self.changed.notify_all()

    def heard(self, topic):
        """Return whether somebody publishes a topic and is connected: nothing that it publishes now is lost."""
        return self._subscribers[topic].get_num_connections() > 0

    def last(self, topic):
        """Return the newest message of a topic. Waits for the first one."""
        self.wait("something on %s" % topic, lambda: self.seen[topic])
        return self.seen[topic][-1]

    def wait(self, what, condition):
        """Wait until the condition holds. Raises AssertionError that names what did not happen."""
        with self.changed:
            assert self.changed.wait_for(condition, PATIENCE), "not within %.0f s: %s" % (PATIENCE, what)

    def next(self, topic, count=1):
        """Wait for the `count`-th message of a topic from now on. It shows the effect of all that happened before."""
        with self.changed:
            wanted = len(self.seen[topic]) + count
        self.wait("%s more on %s" % (count, topic), lambda: len(self.seen[topic]) >= wanted)
        return self.seen[topic][wanted - 1]


def wait_until(what, condition):
    """Check a condition again and again until it holds. No message tells when it does. Raises AssertionError that names
    what did not happen.
    """
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "not within %.0f s: %s" % (PATIENCE, what)
        time.sleep(0.05)


def heading_of(pose):
    """Return the yaw (rad) of a geometry_msgs/Pose of a robot on the floor."""
    return 2 * math.atan2(pose.orientation.z, pose.orientation.w)

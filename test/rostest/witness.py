"""What the online tests share: messages kept as they come, and waiting for a condition instead of for a time."""

import math
import threading
import time

import rospy

PATIENCE = 40.0
"""Seconds after which a test gives up waiting for what should happen at once."""


class Witness:
    """Keeps all messages of some topics, and wakes those who wait for something to be true of them."""

    def __init__(self, topics):
        """`topics`: {topic: message class}."""
        self.changed = threading.Condition()
        self.seen = {topic: [] for topic in topics}
        self._subscribers = [rospy.Subscriber(topic, kind, self._keep, topic) for topic, kind in topics.items()]

    def _keep(self, message, topic):
        with self.changed:
            self.seen[topic].append(message)
            self.changed.notify_all()

    def last(self, topic):
        """The newest message of a topic; waits for the first."""
        self.wait("something on %s" % topic, lambda: self.seen[topic])
        return self.seen[topic][-1]

    def wait(self, what, condition):
        """Until the condition holds; AssertionError that says what did not happen."""
        with self.changed:
            assert self.changed.wait_for(condition, PATIENCE), "not within %.0f s: %s" % (PATIENCE, what)

    def next(self, topic, count=1):
        """The `count`-th message of a topic from now on: what happened before is in it."""
        with self.changed:
            wanted = len(self.seen[topic]) + count
        self.wait("%s more on %s" % (count, topic), lambda: len(self.seen[topic]) >= wanted)
        return self.seen[topic][wanted - 1]


def wait_until(what, condition):
    """Until a condition holds of which nothing tells when it changes; AssertionError that says what did not happen."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "not within %.0f s: %s" % (PATIENCE, what)
        time.sleep(0.05)


def heading_of(pose):
    """Yaw (rad) of a geometry_msgs/Pose of a robot on the floor."""
    return 2 * math.atan2(pose.orientation.z, pose.orientation.w)

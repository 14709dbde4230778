"""Simulated time that a test tells."""

import contextlib
import math
import threading
import time

import rospy
from rosgraph_msgs.msg import Clock

PERIOD = 0.01  # s between two messages on /clock


class Time:
    """Publishes the clock, `rate` times as fast as real time. While `rate` is None, no clock is published. `passed` is
    the time (s) that has passed, without jumps. When `passed` is `end`, time stands.
    """

    def __init__(self, rate=None):
        self.now, self.rate = 1000.0, rate
        self.passed, self.end = 0.0, math.inf
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            if self.rate is not None:
                step = max(0.0, min(PERIOD * self.rate, self.end - self.passed))
                self.passed += step
                self.now += step
                with contextlib.suppress(rospy.ROSException):   # ROS shuts down just now
                    self._publisher.publish(Clock(rospy.Time.from_sec(self.now)))

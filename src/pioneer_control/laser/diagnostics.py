"""Publishes how a laser is on /diagnostics, once a second and at once when it changes. `health` makes level and text.

It publishes only while the topic has a subscriber. The name of the status is ``NODE: Laser``, for example
``pioneer/laser: Laser``. A thread counts the seconds in real time, because ROS time can stand still or jump.
"""

import threading
from time import monotonic
from typing import Any, Callable

import diagnostic_updater
import rospy

from .health import LaserHealth
from .session import LaserCounts

PERIOD = 1.0
"""Time (s) between two reports when nothing changes."""
SHORTEST = 0.1
"""Shortest time (s) between two reports."""


class LaserDiagnostics:
    """Publishes the diagnostics of one laser.

    Args:
        port: its port, as the user gave it.
        counts: function that returns its counters.
    """

    def __init__(self, port: str, counts: Callable[[], LaserCounts]) -> None:
        self._health, self._counts = LaserHealth(port), counts
        self._wanted, self._ended = threading.Event(), threading.Event()

    def start(self) -> None:
        """Start the thread that publishes."""
        threading.Thread(target=self._run, name="diagnostics", daemon=True).start()

    def stop(self) -> None:
        """End the thread: publish nothing more."""
        self._ended.set()
        self._wanted.set()

    def event(self, event: Any) -> None:
        """Take an event of the line. Publish soon if it changes how the laser is. Never blocks."""
        if self._health.event(event):
            self._wanted.set()

    def _run(self) -> None:
        try:
            updater = diagnostic_updater.Updater()      # sends requests to the master: so not in __init__
            updater.add("Laser", self._fill)
            while not self._ended.is_set():
                self._wanted.clear()
                if updater.publisher.get_num_connections():
                    updater.setHardwareID(self._health.hardware_id)
                    updater.force_update()              # update() counts in ROS time
                    self._ended.wait(SHORTEST)
                self._wanted.wait(PERIOD - SHORTEST)
        except rospy.ROSException:
            if not rospy.is_shutdown():                 # then the topic is closed
                raise

    def _fill(self, status: Any) -> Any:
        """Fill the DiagnosticStatus and return it. diagnostic_updater calls this."""
        finding = self._health.report(monotonic(), self._counts())
        status.summary(int(finding.level), finding.message)
        for key, value in finding.values.items():
            status.add(key, value)
        return status

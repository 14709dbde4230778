"""Publishes how a device is on /diagnostics, once a second and at once when it changes. Nodes of devices share this.

It publishes only while the topic has a subscriber. The name of each status is ``NODE: TASK``, for example
``pioneer/p2os: Link`` or ``pioneer/laser: Laser``, so names of two robots differ. The thread counts the seconds in real
time, because ROS time can stand still, jump or run slower. ``launch/diagnostics.launch`` groups the tasks by robot on
/diagnostics_agg. (Debian has no package of rqt_robot_monitor, which shows them.)
"""

import threading
from functools import partial
from typing import Any, Callable, Iterable, Mapping

import diagnostic_updater
import rospy

PERIOD = 1.0
"""Seconds between two reports when nothing changes."""
SHORTEST = 0.1
"""The shortest time (s) between two reports when levels change often."""


class DiagnosticsThread:
    """Publishes the diagnostics of one device. None of its methods blocks.

    Args:
        tasks: names of the tasks, in the order of their statuses.
        report: function that returns a finding for each task: an object with a level, a message, and values by name.
            The thread calls it right before it publishes.
        hardware_id: function that returns which device it is.
    """

    def __init__(self, tasks: Iterable[str], report: Callable[[], Mapping[str, Any]],
                 hardware_id: Callable[[], str]) -> None:
        self._tasks, self._report, self._hardware_id = tuple(tasks), report, hardware_id
        self._findings: Mapping[str, Any] = {}
        self._wanted = threading.Event()    # a report, at once
        self._ended = threading.Event()

    def start(self) -> None:
        """Start the thread that publishes."""
        threading.Thread(target=self._run, name="diagnostics", daemon=True).start()

    def stop(self) -> None:
        """End the thread: publish nothing more."""
        self._ended.set()
        self._wanted.set()

    def wake(self) -> None:
        """Publish soon, because something has changed."""
        self._wanted.set()

    def _run(self) -> None:
        try:
            updater = diagnostic_updater.Updater()      # sends requests to the master: so not in __init__
            for task in self._tasks:
                updater.add(task, partial(self._fill, task))
            while not self._ended.is_set():
                self._wanted.clear()
                if updater.publisher.get_num_connections():
                    self._findings = self._report()
                    updater.setHardwareID(self._hardware_id())
                    updater.force_update()              # update() counts in ROS time
                    self._ended.wait(SHORTEST)
                self._wanted.wait(PERIOD - SHORTEST)
        except rospy.ROSException:
            if not rospy.is_shutdown():                 # then the topic is closed
                raise

    def _fill(self, task: str, status: Any) -> Any:
        """Fill the DiagnosticStatus of a task and return it. diagnostic_updater calls this."""
        finding = self._findings[task]
        status.summary(int(finding.level), finding.message)
        for key, value in finding.values.items():
            status.add(key, value)
        return status

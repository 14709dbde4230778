"""Publishes the diagnostics of the robot on /diagnostics, once a second and when a level changes.

It publishes only while the topic has a subscriber. `client.health` makes the texts and levels.

The name of each status is ``NODE: TASK``, for example ``pioneer/p2os: Link``, so names of two robots differ. The
hardware id is the name of the robot. A separate thread counts the seconds in real time, because ROS time can stand
still, jump or run slower. ``launch/diagnostics.launch`` groups the tasks by robot on /diagnostics_agg. (Debian has no
package of rqt_robot_monitor, which shows them.)
"""

import threading
from functools import partial
from time import monotonic
from typing import Any, Callable, Dict, Mapping

import diagnostic_updater
import rospy

from ..client import Event, HelmState, LinkCounts, RobotState
from ..client.health import TASKS, Finding, Health
from ..client.ports import is_serial

PERIOD = 1.0
"""Seconds between two reports when no level changes."""
SHORTEST = 0.1
"""The shortest time (s) between two reports when levels change often."""


class Diagnostics:
    """Publishes the diagnostics of one robot. Its methods never block the thread of the client that calls them.

    Args:
        port: the serial device or URL, as the user gave it, but without a key.
        baud: the line speed of a serial device.
        how_to_enable: the shell command that switches the motors on, for the texts.
        obstacles: what to tell people about a lock, and about an input that has the helm: sentences by its name.
        link: a function that returns the counters of the link.
        helm: a function that returns who may command.
    """

    def __init__(self, port: str, baud: int, how_to_enable: str, obstacles: Mapping[str, str],
                 link: Callable[[], LinkCounts], helm: Callable[[], HelmState]) -> None:
        self._health = Health(port, baud if is_serial(port) else None, how_to_enable, obstacles)
        self._link = link
        self._helm = helm
        self._findings: Dict[str, Finding] = {}
        self._wanted = threading.Event()    # a report, at once
        self._ended = threading.Event()

    def start(self) -> None:
        """Start the thread that publishes."""
        threading.Thread(target=self._run, name="diagnostics", daemon=True).start()

    def stop(self) -> None:
        """End the thread: publish nothing more."""
        self._ended.set()
        self._wanted.set()

    def state(self, state: RobotState) -> None:
        """Take a state of the robot (one for each SIP). Publish soon when a level changes."""
        if self._health.state(state):
            self._wanted.set()

    def event(self, event: Event) -> None:
        """Take an event of the link. Publish soon when a level changes."""
        if self._health.event(event):
            self._wanted.set()

    def wake(self) -> None:
        """Publish soon, because it has changed who may command. Never blocks."""
        self._wanted.set()

    def _run(self) -> None:
        try:
            updater = diagnostic_updater.Updater()      # sends requests to the master: so not in __init__
            for task in TASKS:
                updater.add(task, partial(self._fill, task))
            while not self._ended.is_set():
                self._wanted.clear()
                if updater.publisher.get_num_connections():
                    self._findings = self._health.report(monotonic(), self._link(), self._helm())
                    updater.setHardwareID(self._health.hardware_id)
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

"""Out: how well everything is, on /diagnostics, once a second and when a level changes. What is said is decided in `health`.

Names are those of diagnostic_updater, ``NODE: TASK`` (``pioneer/p2os: Link``), so two robots never share one; the id of the hardware is the robot's
name. A second is one of real time, also where the clock of ROS stands, jumps or runs slower: a thread of its own waits for it.
``launch/diagnostics.launch`` gathers the tasks of each robot under its name on /diagnostics_agg. (rqt_robot_monitor, to see them, is not in Debian.)
"""

import threading
from time import monotonic
from typing import Callable, Dict, Optional

import diagnostic_updater
import rospy

from ..client import Event, LinkCounts, RobotState
from .health import TASKS, Finding, Health

PERIOD = 1.0
"""Seconds between two reports."""
SHORTEST = 0.1
"""Seconds that always lie between them, however often a level changes."""


class Diagnostics:
    """Reports on one robot. It is told of it on the client's I/O thread, and never keeps that waiting.

    Args:
        port, baud, how_to_enable: as `Health` takes them.
        link: how well the line works.
    """

    def __init__(self, port: str, baud: Optional[int], how_to_enable: str, link: Callable[[], LinkCounts]) -> None:
        self._health = Health(port, baud, how_to_enable)
        self._link = link
        self._findings: Dict[str, Finding] = {}
        self._updater = diagnostic_updater.Updater()
        for task in TASKS:
            self._updater.add(task, self._filler(task))
        self._wanted = threading.Event()    # a report, at once
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="diagnostics", daemon=True)

    def start(self) -> None:
        """Begin to report."""
        self._thread.start()

    def stop(self) -> None:
        """No more reports."""
        self._ended.set()
        self._wanted.set()

    def state(self, state: RobotState) -> None:
        """Once per SIP."""
        if self._health.state(state):
            self._wanted.set()

    def event(self, event: Event) -> None:
        """What else happened on the link."""
        if self._health.event(event):
            self._wanted.set()

    def _run(self) -> None:
        while not self._ended.wait(SHORTEST):
            self._wanted.clear()
            try:
                self._report()
            except rospy.ROSException:      # ROS has shut down meanwhile: the topic is closed
                return
            self._wanted.wait(PERIOD - SHORTEST)

    def _report(self) -> None:
        self._findings = self._health.report(monotonic(), self._link())
        self._updater.setHardwareID(self._health.hardware_id)
        self._updater.force_update()        # update() counts in ROS time

    def _filler(self, task: str) -> Callable:
        def fill(status):
            finding = self._findings[task]
            status.summary(int(finding.level), finding.message)
            for key, value in finding.values:
                status.add(key, value)
            return status
        return fill

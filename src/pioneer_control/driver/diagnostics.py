"""Out: how well everything is, on /diagnostics, once a second and when a level changes, while somebody listens.

`health` decides what is said.

Names are those of diagnostic_updater, ``NODE: TASK`` (``pioneer/p2os: Link``), so two robots never share one. The id of
the hardware is the robot's name. Seconds are those of real time, also where the clock of ROS stands, jumps or runs
slower: a thread of its own counts them. ``launch/diagnostics.launch`` gathers the tasks of each robot under its name
on /diagnostics_agg. (rqt_robot_monitor, to see them, is not in Debian.)
"""

import threading
from functools import partial
from time import monotonic
from typing import Any, Callable, Dict

import diagnostic_updater
import rospy

from ..client import Event, LinkCounts, RobotState
from ..client.transport import tcp_address
from .health import TASKS, Finding, Health

PERIOD = 1.0
"""Seconds between two reports."""
SHORTEST = 0.1
"""Seconds, at least, between two reports, however often a level changes."""


class Diagnostics:
    """Reports on one robot. A thread of the client tells it of the robot, and never has to wait for it.

    Args:
        port: serial device or TCP address, as the user gave it.
        baud: line speed of a serial one.
        how_to_enable: the command that switches motors on, as the user would type it.
        link: how well the line works.
    """

    def __init__(self, port: str, baud: int, how_to_enable: str, link: Callable[[], LinkCounts]) -> None:
        self._health = Health(port, None if tcp_address(port) else baud, how_to_enable)
        self._link = link
        self._findings: Dict[str, Finding] = {}
        self._wanted = threading.Event()    # a report, at once
        self._ended = threading.Event()

    def start(self) -> None:
        """Begin to report."""
        threading.Thread(target=self._run, name="diagnostics", daemon=True).start()

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
        try:
            updater = diagnostic_updater.Updater()      # asks the master: not while the driver starts
            for task in TASKS:
                updater.add(task, partial(self._fill, task))
            while not self._ended.is_set():
                self._wanted.clear()
                if updater.publisher.get_num_connections():
                    self._findings = self._health.report(monotonic(), self._link())
                    updater.setHardwareID(self._health.hardware_id)
                    updater.force_update()              # update() counts in ROS time
                    self._ended.wait(SHORTEST)
                self._wanted.wait(PERIOD - SHORTEST)
        except rospy.ROSException:
            if not rospy.is_shutdown():                 # then the topic is closed
                raise

    def _fill(self, task: str, status: Any) -> Any:
        finding = self._findings[task]
        status.summary(int(finding.level), finding.message)
        for key, value in finding.values.items():
            status.add(key, value)
        return status

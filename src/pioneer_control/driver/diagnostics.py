"""The diagnostics of the robot: `client.health` makes texts and levels, and `diagnostics_thread` publishes them.

The hardware id is the name of the robot.
"""

from time import monotonic
from typing import Callable, Mapping

from ..client import Event, HelmState, LinkCounts, RobotState
from ..client.health import TASKS, Finding, Health
from ..client.ports import is_serial
from ..diagnostics_thread import DiagnosticsThread


class Diagnostics(DiagnosticsThread):
    """Publishes the diagnostics of one robot. Its methods never block the thread of the client that calls them.

    Args:
        port: the serial device or URL, as the user gave it, but without a key.
        baud: the line speed of a serial device.
        how_to_enable: the shell command that switches the motors on, for the texts.
        obstacles: what to tell people about a lock, and about an input that has the helm: sentences by its name.
        link: a function that returns the counters of the link.
        helm: a function that returns who may command.
        devices: tasks of devices on the robot: functions that return the finding, by the task.
    """

    def __init__(self, port: str, baud: int, how_to_enable: str, obstacles: Mapping[str, str],
                 link: Callable[[], LinkCounts], helm: Callable[[], HelmState],
                 devices: Mapping[str, Callable[[], Finding]] = {}) -> None:
        health = self._health = Health(port, baud if is_serial(port) else None, how_to_enable, obstacles)
        super().__init__(
            (*TASKS, *devices),
            lambda: {**health.report(monotonic(), link(), helm()), **{task: find() for task, find in devices.items()}},
            lambda: health.hardware_id)

    def state(self, state: RobotState) -> None:
        """Take a state of the robot (one for each SIP). Publish soon when a level changes."""
        if self._health.state(state):
            self.wake()

    def event(self, event: Event) -> None:
        """Take an event of the link. Publish soon when a level changes."""
        if self._health.event(event):
            self.wake()

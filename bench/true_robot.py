"""A simulated robot in a process of its own, and the truth about it: where it is, how fast, and since when it stands.

The truth comes every 0.1 s, so times are good to 0.1 s.
"""

import json
import os
import pathlib
import socket
import subprocess
import sys
import threading
import time
from typing import Callable, Optional, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[1]
STANDS = 0.002      # m/s, rad/s


class TrueRobot:
    """A simulated robot, and what is true of it.

    Args:
        path: for the socket of the truth.
        tcp: its TCP port.
        before: words before its command, such as those that enter a network namespace.
    """

    def __init__(self, path: str, tcp: int, before: Sequence[str] = ()) -> None:
        environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "src", os.environ.get("PYTHONPATH", "")))
        self._process = subprocess.Popen(
            [*before, sys.executable, "-m", "pioneer_control.simulator", "--world", "empty", "--tcp", str(tcp),
             "--truth", path], env=environment, stdout=subprocess.DEVNULL)
        self.speed, self.driven = 0.0, 0.0
        self._line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        wait_for("the simulated robot", lambda: self._line.connect_ex(path) == 0)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        with self._line.makefile("r", encoding="ascii") as lines:
            for line in lines:
                message = json.loads(line)
                if "truth" in message:
                    _, _, _, linear, angular, _ = message["truth"]["robots"][0]
                    self.speed, self.driven = max(abs(linear), abs(angular)), message["truth"]["driven"][0]

    @property
    def stands(self) -> bool:
        """Whether it stands."""
        return self.speed < STANDS

    def end(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.wait()


def wait_for(what: str, condition: Callable[[], bool], limit: float = 120.0) -> float:
    """Wait until a condition holds. Return how long that took (s). Raises TimeoutError."""
    begin = time.monotonic()
    while not condition():
        if time.monotonic() - begin > limit:
            raise TimeoutError("waited %.0f s for %s" % (limit, what))
        time.sleep(0.02)
    return time.monotonic() - begin


def output(*words: str, before: Sequence[str] = (), environment: Optional[dict] = None) -> str:
    """Return what a command prints, both streams."""
    return subprocess.run([*before, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True).stdout

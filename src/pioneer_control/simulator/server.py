"""Runs a `Firmware` in real time and connects it to clients: here, and in `lines`, are all sockets, terminals and clocks.

>>> with Server(firmware, tcp=0) as server:
...     print(server.url)
socket://127.0.0.1:41873
"""

import select
import threading
import time
from typing import List, Optional, Union

from ..errors import LinkError
from .firmware import Firmware, Session
from .lines import Line, PtyLine, TcpLine

STANDARD_PORT = 8101
"""The TCP port on which a Pioneer's clients expect a simulator (protocol 2.1)."""
PERIOD = 0.01
"""How often (s) the robot lives on when nobody calls."""
LONGEST_LAG = 0.25
"""Real time (s) that is made up for after a hold-up; what is beyond it never happens in the simulation."""
PATIENCE = 2.0
"""Silence (s) after which a client on one line gives way to a client on the other."""


class Server:
    """A simulated robot that clients can connect to, by TCP, by a pseudo-terminal, or by either.

    One client at a time. A client that ends its session with CLOSE makes room for the next at once; one that vanishes
    leaves the robot open and sending to nobody, as a pulled cable would.

    :param firmware: the robot. While the server runs, touch it only under `lock`.
    :param tcp: port of this machine (0: any free one), or ``"host:port"``; `STANDARD_PORT` if `pty` is not given either.
    :param pty: path of a link to be made to a pseudo-terminal.
    :raises PortError: a line cannot be opened.
    """

    def __init__(self, firmware: Firmware, tcp: Union[int, str, None] = None, pty: Optional[str] = None):
        if tcp is None and pty is None:
            tcp = STANDARD_PORT
        self.firmware = firmware
        self.lock = threading.RLock()
        self.url: Optional[str] = None
        self.pty_link = pty
        self._lines: List[Line] = []
        self._line: Optional[Line] = None
        self._heard = 0.0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulated robot", daemon=True)
        try:
            if tcp is not None:
                line = TcpLine(tcp)
                self._lines.append(line)
                self.url = line.url
            if pty is not None:
                self._lines.append(PtyLine(pty, firmware.baud))
        except LinkError:
            self._close_lines()
            raise

    def start(self) -> "Server":
        """Let the robot live."""
        self._thread.start()
        return self

    def stop(self, timeout: float = 2.0) -> None:
        """Switch the robot off, close its lines and wait, at most `timeout` seconds, until that is done."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout)
        else:
            self._close_lines()

    @property
    def running(self) -> bool:
        """Whether the robot lives."""
        return self._thread.is_alive()

    def __enter__(self) -> "Server":
        return self.start()

    def __exit__(self, *_) -> None:
        self.stop()

    def _run(self) -> None:
        last = time.monotonic()
        try:
            while not self._stopping.is_set():
                ready = select.select([file for line in self._lines for file in line.files()], [], [], PERIOD)[0]
                with self.lock:
                    now = time.monotonic()
                    self._write(self.firmware.advance(min(now - last, LONGEST_LAG)))
                    last = now
                    if ready:
                        self._listen(now)
                        self._write(self.firmware.advance(0.0))
        finally:
            self._close_lines()

    def _listen(self, now: float) -> None:
        for line in self._lines:
            line.baud = self.firmware.baud
            data = line.read(self._busy_elsewhere(line, now))
            if not data:
                continue
            closed_before = self.firmware.closed_sessions
            self._line, self._heard = line, now
            self.firmware.receive(data)
            if self.firmware.closed_sessions != closed_before and self.firmware.session is Session.WAITING:
                line.finish()

    def _busy_elsewhere(self, line: Line, now: float) -> bool:
        """Whether a client on another line is in the middle of a session."""
        elsewhere = self._line is not None and self._line is not line
        return elsewhere and self.firmware.session is not Session.WAITING and now - self._heard < PATIENCE

    def _write(self, data: bytes) -> None:
        if self._line is not None:
            self._line.baud = self.firmware.baud
            self._line.write(data)

    def _close_lines(self) -> None:
        while self._lines:
            self._lines.pop().close()

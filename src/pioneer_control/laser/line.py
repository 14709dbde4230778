"""The port of a laser: opens it, gives its bytes and the time to the session, and carries out what the session wants.

>>> from pioneer_control.laser.settings import LaserSettings
>>> line = LaserLine("socket://localhost:8102", LaserSettings(), tell=print)
>>> line.run()                              # until another thread calls line.end()

There is no thread in this file: `run` is the loop, and `tell` is called from it. A port that cannot be opened, or that
breaks, is opened again after a while, for as long as it takes.
"""

import math
import threading
import time
from typing import Any, Callable, Iterable, NamedTuple, Optional, Union

from ..client.ports import is_serial, open_transport
from ..client.transport import Transport
from ..errors import LinkError, LinkLostError
from ..lms2xx import PARTIAL_TIMEOUT
from .conversation import SetLineSpeed
from .session import Event, LaserSession
from .settings import LaserSettings

BACK_OFF = 1.0
"""Time (s) from a failed attempt to open the port to the next one."""
LOOKING = 6.0
"""Time (s) without a laser on an open port, after which that is told. A laser with power is found sooner."""
CLOSING = 3.0
"""Longest time (s) that the laser gets at the end, to be told to stop and to take its old speed. Mostly it takes 0.2 s,
and 3 s are the longest time that the laser sheet (1.2) gives for one answer."""
MUCH, MOST = 2048, 1 << 20
"""Numbers of bytes. `MUCH` bytes in one read are of more than one scan; about `MOST` are read together at most."""
FAST = 100000
"""Line speed (baud) above which bytes must be sent with pauses."""
BYTE_PAUSE = 60e-6
"""Pause (s) after each byte at such a speed: a laser needs 55 us, and drops a request after 6 ms (laser sheet 1.2)."""
WITHOUT_A_LASER = ("Without a laser: python3 -m pioneer_control.simulator --laser lms200 simulates one at"
                   " socket://localhost:8102; in ROS, simulator.launch with laser:=lms200")


class PortDown(NamedTuple):
    """The port cannot be opened; it is tried again. `reason` is for people."""

    reason: str


class StillLooking(NamedTuple):
    """The port is open, and no laser has answered yet. `reason` is for people."""

    reason: str


LineEvent = Union[Event, PortDown, StillLooking]


def open_laser_port(url: str, baud: int) -> Transport:
    """Open the port of a laser. Raises PortError that says why it does not open and what to do."""
    return open_transport(url, baud, advice=WITHOUT_A_LASER)


class LaserLine:
    """A laser's session on its port.

    Args:
        url: serial device, pseudo-terminal or ``socket://host:port``.
        settings: what is asked of the laser.
        tell: function that is called with each `LineEvent`.
        open_port: function that opens the port at a speed (baud).
        clock: function that returns the time (s); it never goes back.

    Attributes:
        url: as the argument.
        session: what is said to the laser, and the counters.
        ended: set when `run` has returned.
    """

    def __init__(self, url: str, settings: LaserSettings, tell: Callable[[LineEvent], None],
                 open_port: Callable[[str, int], Transport] = open_laser_port,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self.url = url
        self.ended = threading.Event()
        self._settings, self._tell, self._open_port, self._clock = settings, tell, open_port, clock
        self.session = LaserSession(settings, is_serial(url), clock())
        self._ending = threading.Event()
        self._lock = threading.Lock()       # held while the reader is woken, or its port closed
        self._transport: Optional[Transport] = None

    def end(self) -> None:
        """Let `run` return soon, after the laser was told to stop. Any thread may call this, any number of times."""
        self._ending.set()
        with self._lock:
            if self._transport is not None:
                self._transport.wake()

    def run(self) -> None:
        """Look for the laser, and listen to it, until `end` is called."""
        try:
            while not self._ending.is_set():
                self._keep_port()
        finally:
            self.ended.set()

    def _keep_port(self) -> None:
        """Open the port, and use it until it breaks or the end."""
        try:
            transport = self._open_port(self.url, self._settings.baud)
        except LinkError as error:
            self._tell(PortDown(str(error)))
            self._ending.wait(BACK_OFF)
            return
        with self._lock:
            self._transport = transport
        try:
            self._talk(transport)
        except LinkLostError as error:
            events = self.session.line_broke(str(error), self._clock())
            self._tell_all(() if self._ending.is_set() else events)
        finally:
            with self._lock:
                self._transport = None
                transport.close()

    def _talk(self, transport: Transport) -> None:
        """Talk with the laser until the end. Raises LinkLostError when the line breaks."""
        session, now = self.session, self._clock()
        look_until, end_at = now + LOOKING, None
        while not session.closed:
            if self._ending.is_set() and end_at is None:
                end_at = now + CLOSING
                session.close(now)
            elif end_at is not None and now >= end_at:
                return
            self._tell_all(session.tick(now))
            self._carry_out(transport, session.take_output())
            if session.info is not None:
                look_until = math.inf       # if it is lost, there is a better reason
            elif end_at is None and now >= look_until:
                look_until = math.inf
                self._tell(StillLooking("%s: no laser has answered yet; one that has just got power needs up to a"
                                        " minute" % self.url))
            data = self._read(transport, max(0.0, min(session.due - now, PARTIAL_TIMEOUT)))
            now = self._clock()
            if data:
                self._tell_all(session.receive(data, now))
                self._carry_out(transport, session.take_output())

    def _read(self, transport: Transport, timeout: float) -> bytes:
        """Return what the port has. The last byte of it is one that has just come, unless the line is idle.

        Much waits only when this computer did other things. Then there may be more than one read returns, and the
        session takes all bytes for as old as those behind them say.
        """
        data = more = transport.read(timeout)
        while len(more) >= MUCH and len(data) < MOST:
            more = transport.read(0.0)
            data += more
        return data

    def _tell_all(self, events: Iterable[LineEvent]) -> None:
        for event in events:
            self._tell(event)

    def _carry_out(self, transport: Transport, output: Iterable[Any]) -> None:
        for each in output:
            if isinstance(each, SetLineSpeed):
                transport.set_baud(each.baud)
            elif (transport.baud or 0) < FAST:
                transport.write(each)
            else:
                for byte in each:
                    transport.write(bytes((byte,)))
                    time.sleep(BYTE_PAUSE)

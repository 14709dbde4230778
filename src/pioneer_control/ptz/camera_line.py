"""A camera on a port of the computer: opens it, and carries bytes and time between it and the session.

It has the method `using` of `client.line_devices.LineDevices`, so whoever commands a camera need not know where it is.

>>> line = CameraLine("/dev/ttyS0", CameraSession(CameraSettings()), changed=lambda: None)
>>> line.start()
>>> with line.using() as now:
...     line.session.look(100, 0, now)

A port that cannot be opened, or that breaks, is opened again after a while, for as long as it takes.
"""

import contextlib
import threading
from time import monotonic
from typing import Callable, Iterator, Optional

from ..client.ports import open_transport
from ..client.transport import Transport
from ..errors import LinkError
from .session import CameraSession

BAUD = 9600
BACK_OFF = 1.0
"""Time (s) from a failure of the port to the next attempt."""
LONGEST_READ = 0.5
"""Time (s) after which the reader looks at the time again."""
WITHOUT_A_CAMERA = ("Without a camera: python3 -m pioneer_control.simulator --camera vcc4 --camera-port 8103 simulates"
                    " one at socket://localhost:8103")


def open_camera_port(url: str) -> Transport:
    """Open the port of a camera. Raises PortError that says why it does not open and what to do."""
    return open_transport(url, BAUD, advice=WITHOUT_A_CAMERA)


class CameraLine:
    """A camera's session on a port. Create it, then call `start`.

    Args:
        url: serial device, pseudo-terminal or ``socket://host:port``.
        session: what is said to the camera.
        changed: called after each call of a method of the session, with its state settled; it must return soon.
        open_port: function that opens the port.
    """

    def __init__(self, url: str, session: CameraSession, changed: Callable[[], None],
                 open_port: Callable[[str], Transport] = open_camera_port) -> None:
        self.session = session
        self._url, self._changed, self._open_port = url, changed, open_port
        self._turn = threading.Condition()
        self._closed = threading.Event()
        self._transport: Optional[Transport] = None
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> None:
        """Start the thread that opens the port and reads it."""
        self._thread.start()

    @contextlib.contextmanager
    def using(self) -> Iterator[float]:
        """Let the caller command the session in a ``with`` block, and send what it wants then. It gets the time (s)."""
        with self._turn:
            yield monotonic()
            self._send()
            if self._transport is not None:
                self._transport.wake()

    def end(self, timeout: float) -> bool:
        """Bring the camera to rest. Return whether it is, within ``timeout`` (s)."""
        with self.using() as now:
            self.session.end(now)
        with self._turn:
            return self._turn.wait_for(lambda: self.session.ended, timeout)

    def close(self) -> None:
        """End the thread, and close the port."""
        self._closed.set()
        with self._turn:
            if self._transport is not None:
                self._transport.wake()

    def _run(self) -> None:
        while not self._closed.is_set():
            try:
                self._talk()
            except LinkError as error:
                with self.using():
                    self.session.line_down(str(error))
                self._closed.wait(BACK_OFF)

    def _talk(self) -> None:
        """Open the port, and use it until it breaks or the end. Raises LinkError when it breaks."""
        transport = self._open_port(self._url)
        try:
            with self._turn:
                self._transport = transport
            with self.using() as now:
                self.session.line_up(now)
            while not self._closed.is_set():
                data = transport.read(max(0.0, min(self.session.due - monotonic(), LONGEST_READ)))
                with self._turn:
                    if data:
                        self.session.receive(data, monotonic())
                    self.session.tick(monotonic())
                    self._send()
        finally:
            with self._turn:
                self._transport = None
                transport.close()

    def _send(self) -> None:
        """Write what the session wants, tell that it changed, and wake whoever waits for its end."""
        exchanges = self.session.take_output()
        transport = self._transport
        if transport is not None:
            try:
                for exchange in exchanges:
                    transport.write(exchange.data)
            except LinkError:
                transport.wake()        # the reader finds that out, too
        self._changed()
        self._turn.notify_all()

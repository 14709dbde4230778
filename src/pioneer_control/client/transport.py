"""What all ports have in common: they read and write bytes, and any thread can wake the reader.

``ports`` opens a port of the kind that its URL names.
"""

import contextlib
import selectors
import socket
import time
from abc import ABC, abstractmethod
from typing import Any, Callable, Optional

from ..errors import LinkLostError

WRITE_TIMEOUT = 0.25            # s for a few dozen bytes: 25 ms at 9600 baud
READ_SIZE = 4096
NO_MORE_BYTES = "%s: takes no more bytes"


class Transport(ABC):
    """An open line to the robot. One thread at a time may read, and one may write. Any thread may wake the reader.

    Args:
        url: the port, for error messages.
        baud: the line speed of a serial port; None on any other port.

    Attributes:
        url: the port.
        baud: the present line speed; None if the port is not serial.
    """

    def __init__(self, url: str, baud: Optional[int]) -> None:
        self.url = url
        self.baud = baud

    @abstractmethod
    def read(self, timeout: float) -> bytes:
        """Return received bytes as soon as there are any. Returns no bytes after ``timeout`` s or after a wake().

        Raises LinkLostError when the line broke or the other side has closed it.
        """

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Write all of ``data``.

        Raises LinkLostError when the line broke, or does not take all bytes within WRITE_TIMEOUT.
        """

    @abstractmethod
    def wake(self) -> None:
        """Make a read() that waits return at once."""

    def set_baud(self, baud: int) -> None:
        """Change the line speed, and drop bytes that were received at the old speed. Does nothing without a speed.

        Raises LinkLostError when a serial port cannot change to this speed.
        """

    @abstractmethod
    def close(self) -> None:
        """Close the line. Bytes that were written before are still sent."""


class StreamTransport(Transport):
    """A line for whose bytes the operating system can wait: a socket everywhere, a serial port not on Windows.

    Args:
        url, baud: see Transport.
        port: the socket or the serial port. It never blocks. The transport closes it.
        receive: a function that reads so many bytes from the port at most.
        send: a function that writes bytes to the port, and returns how many it wrote.
    """

    def __init__(self, url: str, baud: Optional[int], port: Any, receive: Callable[[int], bytes],
                 send: Callable[[bytes], int]) -> None:
        super().__init__(url, baud)
        self._port = port
        self._send_bytes = send
        self._wake_reader, self._wake_writer = socket.socketpair()
        self._readable = selectors.DefaultSelector()
        for file, how in ((port, receive), (self._wake_reader, self._wake_reader.recv)):
            self._readable.register(file, selectors.EVENT_READ, how)
        self._wake_reader.setblocking(False)
        self._wake_writer.setblocking(False)

    def read(self, timeout: float) -> bytes:
        ready = [key for key, _ in self._readable.select(max(0.0, timeout))]
        ready.sort(key=lambda key: key.fileobj is not self._port)       # the port first: its bytes end this read, ...
        for key in ready:       # ... and a call of wake() then waits for the next one
            try:
                data: bytes = key.data(READ_SIZE)
            except BlockingIOError:
                continue
            except OSError as error:
                raise self._broken(error) from error
            if key.fileobj is self._port:
                if not data:
                    raise LinkLostError("%s: the other side closed the line: switched off, cable pulled, or another "
                                        "program is connected" % self.url)
                return data
        return b""

    def write(self, data: bytes) -> None:
        self._write_until(time.monotonic() + WRITE_TIMEOUT, data)

    def wake(self) -> None:
        with contextlib.suppress(BlockingIOError):      # full of calls that the reader has not noticed yet
            self._wake_writer.send(b"\0")

    def close(self) -> None:
        self._readable.close()
        with contextlib.suppress(OSError):      # an adapter that is unplugged may say so once more
            self._port.close()
        self._wake_reader.close()
        self._wake_writer.close()

    def _write_until(self, deadline: float, data: bytes) -> None:
        """Do what write() does, but until the time ``deadline`` (monotonic, s)."""
        while data:
            try:
                data = data[self._send_bytes(data):]
            except BlockingIOError:
                if not self._takes_more(deadline - time.monotonic()):
                    raise LinkLostError(NO_MORE_BYTES % self.url) from None
            except OSError as error:
                raise self._broken(error) from error

    def _takes_more(self, timeout: float) -> bool:
        """Wait until the port takes bytes, at most ``timeout`` s. Returns whether it does."""
        with selectors.DefaultSelector() as writable:
            writable.register(self._port, selectors.EVENT_WRITE)
            return timeout > 0 and bool(writable.select(timeout))

    def _broken(self, error: OSError) -> LinkLostError:
        return LinkLostError("%s: the line broke: %s" % (self.url, error.strerror or error))


def tap(transport: Transport, tell: Callable[[bool, bytes], None]) -> None:
    """Call ``tell(to_robot, data)`` with all bytes that are read or written from now on, in their order on the line.

    The thread that reads or writes makes the call. For written bytes the call comes right before the write. Otherwise
    the robot's answer could be reported before them.
    """
    read, write = transport.read, transport.write

    def told_read(timeout: float) -> bytes:
        data = read(timeout)
        if data:
            tell(False, data)
        return data

    def told_write(data: bytes) -> None:
        tell(True, data)
        write(data)

    vars(transport).update(read=told_read, write=told_write)

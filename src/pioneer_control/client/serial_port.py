"""Serial ports and ptys. Only this file uses pyserial, and imports it only when a serial port is opened.

pyserial opens and configures serial ports. After that, this file reads and writes the file descriptor of the port
directly, but on Windows, where a serial port has none.
"""

import contextlib
import errno
import os
import stat
import sys
import threading
import time
from functools import partial
from typing import Any

from ..errors import LinkLostError, PortError
from .transport import NO_MORE_BYTES, WRITE_TIMEOUT, StreamTransport, Transport

POLLED = sys.platform == "win32"
"""Whether the operating system cannot wait for the bytes of a serial port together with a wake()."""
SLICE = 0.02        # s that one read of a PolledSerialTransport waits: as long may a wake() take


def open_serial(path: str, baud: int, advice: str) -> Transport:
    """Open a serial port: 8N1, raw, no flow control, locked against a second program (protocol 2.1).

    Raises PortError that says why the port does not open and what to do. ``advice`` is for a user who has no such port.
    """
    try:
        import serial
    except ImportError as error:
        raise PortError("%s: a serial port needs pyserial (%s): pip install pyserial, or on Debian "
                        "apt install python3-serial" % (path, error)) from error
    try:
        port = serial.Serial(path, baudrate=baud, exclusive=True, timeout=SLICE if POLLED else 0,
                             write_timeout=WRITE_TIMEOUT if POLLED else None)
    except serial.SerialException as error:
        raise PortError(_why_not_open(path, error, advice)) from error
    except (ValueError, OverflowError) as error:
        raise PortError("%s: %s" % (path, error)) from error
    return PolledSerialTransport(path, port) if POLLED else SerialTransport(path, port)


class SerialTransport(StreamTransport):
    """A serial port or a pty.

    Args:
        path: the port, for error messages.
        port: an open serial.Serial with timeout 0. The transport closes it.
    """

    def __init__(self, path: str, port: Any) -> None:
        descriptor = port.fileno()
        super().__init__(path, port.baudrate, port, partial(os.read, descriptor), partial(os.write, descriptor))

    def set_baud(self, baud: int) -> None:
        change_baud(self.url, self._port, baud)
        self.baud = baud


class PolledSerialTransport(Transport):
    """A serial port on Windows, through the calls of pyserial alone. A wake() is noticed after SLICE s at most.

    It is tested on Linux, with ptys. Nobody has tried it on Windows yet.

    Args:
        path: the port, such as COM3, for error messages.
        port: an open serial.Serial with timeout SLICE and write_timeout WRITE_TIMEOUT. The transport closes it.
    """

    def __init__(self, path: str, port: Any) -> None:
        super().__init__(path, port.baudrate)
        self._port = port
        self._woken = threading.Event()

    def read(self, timeout: float) -> bytes:
        deadline = time.monotonic() + timeout
        try:
            data: bytes = self._port.read(self._port.in_waiting)
            while not data and not self._woken.is_set() and time.monotonic() < deadline:
                data = self._port.read(self._port.in_waiting or 1)
        except OSError as error:        # serial.SerialException is one
            raise LinkLostError("%s: the line broke: %s" % (self.url, error)) from error
        if not data:
            self._woken.clear()
        return data

    def write(self, data: bytes) -> None:
        from serial import SerialTimeoutException

        try:
            self._port.write(data)
        except SerialTimeoutException:
            raise LinkLostError(NO_MORE_BYTES % self.url) from None
        except OSError as error:
            raise LinkLostError("%s: the line broke: %s" % (self.url, error)) from error

    def wake(self) -> None:
        self._woken.set()

    def set_baud(self, baud: int) -> None:
        change_baud(self.url, self._port, baud)
        self.baud = baud

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._port.close()


def change_baud(path: str, port: Any, baud: int) -> None:
    """Change the speed of an open serial.Serial, and drop what it received. Raises LinkLostError if this fails."""
    try:
        port.baudrate = baud
        port.reset_input_buffer()
    # ValueError: a speed that this adapter does not have.
    except (OSError, ValueError) as error:
        raise LinkLostError("%s: cannot change to %d baud: %s" % (path, baud, error)) from error


def _why_not_open(path: str, error: OSError, advice: str) -> str:
    if POLLED:      # errors of Windows have no errno, but say why
        return "%s: %s. %s" % (path, error, _ports_here())
    import termios

    if error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ENXIO, errno.ENODEV):
        if os.path.isabs(path) and not path.startswith("/dev/"):
            return "%s: no such port. Does the simulated robot run that makes it?" % path
        return "%s: no such port. %s. %s" % (path, _ports_here(), advice)
    if error.errno in (errno.EACCES, errno.EPERM):
        return "%s: no permission. %s" % (path, _how_to_get_permission(path))
    if error.errno in (errno.EBUSY, errno.EAGAIN):
        return "%s: in use by another program (`fuser -v %s` shows which)" % (path, path)
    if isinstance(error.__context__, termios.error) or os.path.exists(path) and not stat.S_ISCHR(os.stat(path).st_mode):
        return "%s: not a serial port" % path
    return "%s: %s" % (path, error)


def _ports_here() -> str:
    from serial.tools import list_ports

    return "Serial ports of this machine: %s" % (", ".join(sorted(port.device for port in list_ports.comports())) or
                                                 "none")


def _how_to_get_permission(path: str) -> str:
    """Return a text for the user: which group may use the device, or that only its owner may use it."""
    import grp

    status = os.stat(path)
    if not status.st_mode & stat.S_IRGRP or not status.st_mode & stat.S_IWGRP:
        return "Only its owner may use it: %s" % stat.filemode(status.st_mode)
    try:
        group = grp.getgrgid(status.st_gid).gr_name
    except KeyError:
        group = str(status.st_gid)
    return "The group %s may use it: run `sudo usermod -a -G %s $USER`, then log out and in again" % (group, group)

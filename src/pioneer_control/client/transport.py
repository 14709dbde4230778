"""Reads and writes bytes through a serial port, a pty or TCP, as the URL says. Only this file uses pyserial.

pyserial opens and configures serial ports. After that, this file reads and writes the file descriptor of a serial port
or socket directly. The ``socket://`` of pyserial is not used, because nobody can interrupt its read(), and its close()
takes 0.3 s.
"""

import contextlib
import errno
import grp
import os
import re
import select
import socket
import stat
import termios
import time
from typing import Any, Callable, Optional, Tuple

import serial
from serial.tools import list_ports

from ..errors import LinkLostError, PortError

DEFAULT_TCP_PORT = 8101         # of simulators and serial-to-network bridges (protocol 2.1)
CONNECT_TIMEOUT = 3.0           # s
WRITE_TIMEOUT = 0.25            # s for a few dozen bytes: 25 ms at 9600 baud
DRAIN_TIMEOUT = 0.15            # s that close() leaves the other side of a socket to take the last bytes
READ_SIZE = 4096
WITHOUT_A_ROBOT = (
    "Without a robot: python3 -m pioneer_control.simulator --tcp %d simulates one; "
    "in ROS, pioneer.launch with sim:=true")

TCP_URL = re.compile(r"^(?P<scheme>(?:socket|tcp)://)?(?P<host>[^/:]+|\[[^\]]+\])(?::(?P<port>\d+))?(?(scheme)/?)$")


def tcp_address(url: str) -> Optional[Tuple[str, int]]:
    """Return host and port of ``socket://host:port``, ``tcp://host:port`` or ``host:port``; None for any other text.

    Without a port, ``socket://host`` and ``tcp://host`` mean DEFAULT_TCP_PORT.
    """
    match = TCP_URL.match(url)
    if match is None or not (match["scheme"] or match["port"]):
        return None
    return match["host"].strip("[]"), int(match["port"] or DEFAULT_TCP_PORT)


def open_transport(url: str, baud: int) -> "Transport":
    """Open ``/dev/ttyUSB0``, the path of a pty, or ``socket://host:port``. Only serial ports use ``baud``.

    Raises PortError that says why the port does not open and what to do.
    """
    address = tcp_address(url)
    if address is not None:
        return SocketTransport(url, _connect(url, *address), None)
    if url.isdigit():
        raise PortError(
            "cannot understand the port %r: for a robot on that TCP port of this machine give socket://localhost:%s"
            % (url, url))
    if "://" in url:
        raise PortError("cannot understand the port %r: give a path such as /dev/ttyUSB0, or socket://host:port" % url)
    return SerialTransport(url, _open_serial(url, baud), baud)


class Transport:
    """An open line to the robot. One thread at a time may read, and one may write. Any thread may wake the reader.

    Args:
        url: the port, for error messages.
        port: an open serial.Serial or socket that never blocks. The transport closes it.
        baud: the line speed of a serial port; None on TCP.

    Attributes:
        baud: the present line speed; None on TCP.
    """

    def __init__(self, url: str, port: Any, baud: Optional[int]) -> None:
        self.url = url
        self.baud = baud
        self._port = port
        self._descriptor = port.fileno()
        self._wake_reader, self._wake_writer = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(self._descriptor, select.POLLIN)
        self._readable.register(self._wake_reader, select.POLLIN)
        self._writable.register(self._descriptor, select.POLLOUT)

    def read(self, timeout: float) -> bytes:
        """Return received bytes as soon as there are any. Returns no bytes after ``timeout`` s or after a wake().

        Raises LinkLostError when the line broke or the other side has closed it.
        """
        for descriptor, _ in self._readable.poll(max(0.0, timeout) * 1000):
            try:
                data = os.read(descriptor, READ_SIZE)
            except BlockingIOError:
                continue
            except OSError as error:
                raise LinkLostError("%s: the line broke: %s" % (self.url, error.strerror)) from error
            if descriptor == self._descriptor:
                if not data:
                    raise LinkLostError("%s: the other side closed the line: switched off, cable pulled, or another "
                                        "program is connected" % self.url)
                return data
        return b""

    def write(self, data: bytes) -> None:
        """Write all of ``data``.

        Raises LinkLostError when the line broke, or does not take all bytes within WRITE_TIMEOUT.
        """
        deadline = time.monotonic() + WRITE_TIMEOUT
        while data:
            try:
                data = data[os.write(self._descriptor, data):]
            except BlockingIOError:
                if not self._writable.poll(max(0.0, deadline - time.monotonic()) * 1000):
                    raise LinkLostError("%s: takes no more bytes" % self.url) from None
            except OSError as error:
                raise LinkLostError("%s: the line broke: %s" % (self.url, error.strerror)) from error

    def wake(self) -> None:
        """Make a read() that waits return at once."""
        with contextlib.suppress(BlockingIOError):      # the pipe is full of calls that the reader has not noticed yet
            os.write(self._wake_writer, b"\0")

    def set_baud(self, baud: int) -> None:
        """Change the line speed, and drop bytes that were received at the old speed. Does nothing on TCP.

        Raises LinkLostError when a serial port cannot change to this speed.
        """

    def close(self) -> None:
        """Close the line. Bytes that were written before are still sent."""
        with contextlib.suppress(OSError):      # an adapter that is unplugged may say so once more
            self._port.close()
        os.close(self._wake_reader)
        os.close(self._wake_writer)


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


class SerialTransport(Transport):
    """A serial port or a pty."""

    def set_baud(self, baud: int) -> None:
        try:
            self._port.baudrate = baud
            self._port.reset_input_buffer()
        # ValueError: a speed that this adapter does not have.
        except (serial.SerialException, OSError, ValueError) as error:
            raise LinkLostError("%s: cannot change to %d baud: %s" % (self.url, baud, error)) from error
        self.baud = baud


class SocketTransport(Transport):
    """A TCP connection."""

    def close(self) -> None:
        """Close the connection, after the other side has taken all bytes or DRAIN_TIMEOUT has passed.

        First close only our direction, and read until the other side closes, too. A close with unread input would send
        RST and cancel our last bytes.
        """
        deadline = time.monotonic() + DRAIN_TIMEOUT
        with contextlib.suppress(OSError):      # LinkLostError is one: the other side is done
            self._port.shutdown(socket.SHUT_WR)
            while time.monotonic() < deadline:
                self.read(deadline - time.monotonic())
        super().close()


def _connect(url: str, host: str, port: int) -> socket.socket:
    """Return a TCP connection that never blocks, without Nagle's delay. Raises PortError with what to do."""
    if not 0 < port <= 65535:
        raise PortError("%s: there is no TCP port %d (legal: 1..65535)" % (url, port))
    try:
        connection = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        return connection
    except ConnectionRefusedError as error:
        raise PortError(
            "%s: connection refused: nothing listens on port %d of %s. %s"
            % (url, port, host, WITHOUT_A_ROBOT % port)
        ) from error
    except (socket.gaierror, UnicodeError) as error:
        raise PortError("%s: no such host: %s" % (url, getattr(error, "strerror", error))) from error
    except socket.timeout as error:
        raise PortError("%s: no answer from %s within %.0f s: is it switched on and in this network?"
                        % (url, host, CONNECT_TIMEOUT)) from error
    except OSError as error:
        raise PortError("%s: cannot connect: %s" % (url, error)) from error


def _open_serial(path: str, baud: int) -> serial.Serial:
    """Open a serial port: 8N1, raw, no flow control, locked against a second program (protocol 2.1).

    Raises PortError that says why the port does not open and what to do.
    """
    try:
        return serial.Serial(path, baudrate=baud, timeout=0, exclusive=True)
    except serial.SerialException as error:
        raise PortError(_why_not_open(path, error)) from error
    except (ValueError, OverflowError) as error:
        raise PortError("%s: %s" % (path, error)) from error


def _why_not_open(path: str, error: serial.SerialException) -> str:
    if error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ENXIO, errno.ENODEV):
        if os.path.isabs(path) and not path.startswith("/dev/"):
            return "%s: no such port. Does the simulated robot run that makes it?" % path
        ports = ", ".join(sorted(port.device for port in list_ports.comports())) or "none"
        return "%s: no such port. Serial ports of this machine: %s. %s" % (path, ports,
                                                                           WITHOUT_A_ROBOT % DEFAULT_TCP_PORT)
    if error.errno in (errno.EACCES, errno.EPERM):
        return "%s: no permission. %s" % (path, _how_to_get_permission(path))
    if error.errno in (errno.EBUSY, errno.EAGAIN):
        return "%s: in use by another program (`fuser -v %s` shows which)" % (path, path)
    if isinstance(error.__context__, termios.error) or os.path.exists(path) and not stat.S_ISCHR(os.stat(path).st_mode):
        return "%s: not a serial port" % path
    return "%s: %s" % (path, error)


def _how_to_get_permission(path: str) -> str:
    """Return a text for the user: which group may use the device, or that only its owner may use it."""
    status = os.stat(path)
    if not status.st_mode & stat.S_IRGRP or not status.st_mode & stat.S_IWGRP:
        return "Only its owner may use it: %s" % stat.filemode(status.st_mode)
    try:
        group = grp.getgrgid(status.st_gid).gr_name
    except KeyError:
        group = str(status.st_gid)
    return "The group %s may use it: run `sudo usermod -a -G %s $USER`, then log out and in again" % (group, group)

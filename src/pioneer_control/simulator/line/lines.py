"""The two kinds of lines to which a robot's client can connect: a TCP port and a pseudo-terminal.

A line has one client at a time. Its methods never block. Bytes that a client does not read in time are lost, oldest
first, as on a serial line.
"""

import collections
import errno
import os
import selectors
import socket
import struct
from abc import ABC, abstractmethod
from io import FileIO
from typing import Any, Deque, List, Optional, Sequence, Tuple, Union

from ...errors import PortError
from ...p2os import BAUD_RATES
from .uart import as_heard

try:
    import fcntl
    import termios
    import tty
except ImportError:     # there are no pseudo-terminals on Windows
    HAS_TERMINALS = False
else:
    HAS_TERMINALS = True

STANDARD_PORT = 8101
"""TCP port on which clients of a Pioneer expect a simulator (protocol 2.1)."""
UNREAD_LIMIT = 8 * 1024
"""Largest number of bytes that are buffered for a TCP client that does not read: about ten seconds of SIPs.

The kernel may buffer the same number of bytes.
"""
PTY_UNREAD_LIMIT = 1024
"""Number of unread bytes in a pseudo-terminal above which all of them are dropped: about one second of SIPs.

So a client that connects later receives no old SIPs.
"""
BACKLOG = 4
SELECTOR = getattr(selectors, "PollSelector", selectors.SelectSelector)
"""A selector that needs no open file of its own: there may be hundreds of lines. Windows has no PollSelector."""
CHUNK = 4096
ISPEED, OSPEED = 4, 5
"""Indices of the input speed and the output speed in the result of `termios.tcgetattr`."""
BAUD_RATE_OF = {getattr(termios, "B%s" % baud): baud
                for baud in (300, 600, 1200, 2400, 4800, *BAUD_RATES, 230400, 500000)
                if HAS_TERMINALS and hasattr(termios, "B%s" % baud)}
"""Baud rates by their constants in `termios`.

A client's baud rate that is not in this table is taken to be equal to the robot's.
"""

TCP_PROBLEMS = {
    errno.EADDRINUSE: "TCP port %(port)d is in use, perhaps by another simulator: stop that one, or choose another port"
                      " (0 takes any free one)",
    errno.EACCES: "TCP port %(port)d may not be opened by this user: choose one above 1023",
}
"""Error messages for common errors when a TCP port is opened, by errno."""


class _Line(ABC):
    """Base class of `TcpLine` and `PtyLine`.

    Attributes:
        baud: baud rate of the robot's end. A TCP port does not use it.
        plugged: whether the cable is plugged in.
        clients: number of clients that have connected to a TCP port. 0 for a pseudo-terminal, which cannot count them.
        finished: whether the client has ended its session. A TCP port then accepts another client, even if the present
            client does not disconnect.
    """

    def __init__(self, baud: int):
        self.baud = baud
        self.plugged = False
        self.clients = 0
        self.finished = False

    def plug(self, in_: bool) -> None:
        """Plug in the cable if `in_`, which opens the line. Else unplug it, which closes the line.

        Raises:
            PortError: the port or the terminal cannot be opened, or the link cannot be made.
        """
        if not in_:
            self.close()
        elif not self.plugged:
            self._open()
            self.plugged = True

    @abstractmethod
    def files(self) -> Sequence[Any]:
        """Return the files or sockets to wait for: when one of them is readable, `read` has work to do."""

    @abstractmethod
    def close(self) -> None:
        """Disconnect the client, and close the port or the terminal."""

    @abstractmethod
    def _open(self) -> None:
        """Open the port or the terminal."""


class TcpLine(_Line):
    """A TCP port that accepts one client at a time.

    Args:
        address: port number (0 for any free port) for clients on this machine, or ``"host:port"``.

    Attributes:
        host: host on which the port is open.
        port: number of the port.
        url: URL to which clients connect.
        client: socket of the present client. None without a client.

    Raises:
        PortError: the port cannot be opened. The message says what to do.
    """

    def __init__(self, address: Union[int, str]):
        super().__init__(0)
        self.host, self.port = host_and_port(address)
        self.client: Optional[socket.socket] = None
        self._unsent: Deque[bytes] = collections.deque()
        self.plug(True)
        self.url = "socket://%s:%d" % (self.host, self.port)

    client_baud: Optional[int] = None
    """Baud rate of the client's end: None, because a TCP port has no baud rate."""

    def files(self) -> List[socket.socket]:
        """Return the listening socket and the client's socket, as far as they are open."""
        return [file for file in (self._listener, self.client) if file is not None] if self.plugged else []

    def read(self, busy: bool) -> bytes:
        """Return the bytes that the client has sent since the last call.

        If the client has ended its session or disconnected, accept the next client.

        Args:
            busy: drop the bytes of the client, and accept no client.
        """
        another_waits = bool(self._waiting.select(0))   # what this client sent before the other came is here now
        data = self._receive()
        if another_waits and not data and self._welcome(busy):      # the last bytes of a client may end its session
            data = self._receive()
        if data:
            self.finished = False
        elif data is not None:
            self._dismiss()
        return b"" if busy else data or b""

    def write(self, data: bytes) -> None:
        """Send bytes to the client, if there is one. Bytes that it does not read in time are lost, oldest first.

        A client that has disconnected is dismissed by `read`, after its last bytes: they may be a CLOSE.
        """
        if self.client is None:
            return
        self._unsent.append(data)
        while sum(map(len, self._unsent)) > UNREAD_LIMIT and len(self._unsent) > 1:
            del self._unsent[1]     # the first may be half sent already
        try:
            while self._unsent:
                self._unsent[0] = self._unsent[0][self.client.send(self._unsent[0]):]
                if not self._unsent[0]:
                    self._unsent.popleft()
        except BlockingIOError:
            pass
        except OSError:     # it has disconnected
            self._unsent.clear()

    def close(self) -> None:
        """Disconnect the client and close the port. New connections are then refused."""
        self._dismiss()
        if self.plugged:
            self.plugged = False
            self._waiting.close()
            self._listener.close()

    def _open(self) -> None:
        try:
            self._listener = socket.create_server((self.host, self.port), backlog=BACKLOG)
        except OSError as error:
            problem = TCP_PROBLEMS.get(error.errno or 0, "cannot open TCP port %(port)d of %(host)s: %(why)s")
            raise PortError(problem % dict(port=self.port, host=self.host, why=error.strerror or error)) from error
        self._listener.setblocking(False)
        self._waiting = SELECTOR()
        self._waiting.register(self._listener, selectors.EVENT_READ)
        self.host, self.port = self._listener.getsockname()

    def _welcome(self, busy: bool) -> bool:
        """Accept the next client that waits for a connection.

        If the line is `busy`, or the present client has neither ended its session nor disconnected, the new client is
        disconnected.

        Returns:
            Whether a new client is connected.
        """
        try:
            client, _ = self._listener.accept()
        except OSError:     # no client, or it has disconnected
            return False
        if busy or not (self.finished or self._receive(socket.MSG_PEEK) == b""):
            client.close()
            return False
        self._dismiss()
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD_LIMIT)
        self.client = client
        self.clients += 1
        return True

    def _receive(self, flags: int = 0) -> Optional[bytes]:
        """Receive bytes from the client.

        Returns:
            The bytes. None if no bytes have arrived yet. Empty if there is no client, or the client has disconnected.
        """
        if self.client is None:
            return b""
        try:
            return self.client.recv(CHUNK, flags)
        except BlockingIOError:
            return None
        except OSError:
            return b""

    def _dismiss(self) -> None:
        if self.client is not None:
            self.client.close()
        self.client, self.finished = None, False
        self._unsent.clear()


class PtyLine(_Line):
    """A pseudo-terminal, with a symbolic link to it, so that clients find it under the same path at each start.

    Like a serial line, it garbles all bytes while its two ends have different baud rates.

    Args:
        link: path of the symbolic link. A link of an earlier simulator is replaced. Any other file there is an error.
        baud: baud rate of the robot's end, and of the client's end until a client sets another.
        unread_limit: number of unread bytes above which all of them are dropped.

    Raises:
        PortError: the link cannot be made, or this system has no pseudo-terminals. The message has the reason.
    """

    def __init__(self, link: str, baud: int = 9600, unread_limit: int = PTY_UNREAD_LIMIT):
        super().__init__(baud)
        self._unread_limit = unread_limit
        if not HAS_TERMINALS:
            raise PortError("cannot make %s: this system has no pseudo-terminals. Give a TCP port instead: --tcp %d,"
                            " and to the client socket://localhost:%d" % (link, STANDARD_PORT, STANDARD_PORT))
        self.link = link
        is_ours = os.path.islink(link) and (os.readlink(link).startswith("/dev/pts/") or not os.path.exists(link))
        if os.path.lexists(link) and not is_ours:
            raise PortError("%s exists and is not the link of a simulated robot: remove it or choose another path"
                            % link)
        self.plug(True)

    @property
    def client_baud(self) -> int:
        """The baud rate of the client's end, as the present client or an earlier client has set it."""
        return BAUD_RATE_OF.get(termios.tcgetattr(self._slave)[OSPEED], self.baud)

    @property
    def unread(self) -> int:
        """The number of bytes in the terminal that no client has read yet."""
        count, = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, bytes(struct.calcsize("i"))))
        return int(count)

    def files(self) -> List[FileIO]:
        """Return the robot's end of the terminal, if the cable is plugged in."""
        return [self._master] if self.plugged else []

    def read(self, busy: bool) -> bytes:
        """Return the bytes that clients have sent since the last call. If `busy`, drop them and return no bytes."""
        data = self._master.read(CHUNK) if self.plugged else None
        return b"" if busy or not data else as_heard(data, self.client_baud, self.baud)

    def write(self, data: bytes) -> None:
        """Send bytes to the client. If too many bytes are unread, drop all unread bytes first."""
        if self.plugged:
            if self.unread > self._unread_limit:
                termios.tcflush(self._slave, termios.TCIFLUSH)
            if self._master.write(as_heard(data, self.baud, self.client_baud)) is None:     # the terminal is full
                termios.tcflush(self._slave, termios.TCIFLUSH)

    def close(self) -> None:
        """Close the terminal, as if a USB adapter were unplugged. Remove the link if it still leads to the terminal."""
        if self.plugged:
            self.plugged = False
            if os.path.islink(self.link) and os.readlink(self.link) == self.device:
                os.unlink(self.link)
            self._close_files()

    def _open(self) -> None:
        # The client's end stays open here too, so that the terminal stays raw and alive between clients.
        self._master, self._slave = (FileIO(end, "r+") for end in os.openpty())
        os.set_blocking(self._master.fileno(), False)
        tty.setraw(self._slave.fileno())
        settings = termios.tcgetattr(self._slave)
        settings[ISPEED] = settings[OSPEED] = getattr(termios, "B%s" % self.baud)
        termios.tcsetattr(self._slave, termios.TCSANOW, settings)
        self.device = os.ttyname(self._slave.fileno())
        try:
            if os.path.islink(self.link):
                os.unlink(self.link)
            os.symlink(self.device, self.link)
        except OSError as error:
            self._close_files()
            raise PortError("cannot make the link %s: %s; choose another path" % (self.link, error.strerror)) from error

    def _close_files(self) -> None:
        self._master.close()
        self._slave.close()


ServedLine = Union[TcpLine, PtyLine]


def host_and_port(address: Union[int, str]) -> Tuple[str, int]:
    """Return host and port of a TCP address, which is a port number or ``"host:port"``.

    If the address has no host, the host is 127.0.0.1.

    Raises:
        PortError: the address is not legal.
    """
    host, _, port = str(address).rpartition(":")
    if not port.isdigit() or int(port) > 65535:
        raise PortError("%r is no TCP port: wanted 0 to 65535 (0 takes any free one), or host:port" % address)
    return host or "127.0.0.1", int(port)

"""The lines that a simulated robot can be reached by: a TCP port and a pseudo-terminal. Non-blocking, one client each.

A line never waits and never fills up: what a client does not read in time is lost, oldest first, as on a serial line.
"""

import collections
import errno
import fcntl
import os
import socket
import struct
import termios
import tty
from abc import ABC, abstractmethod
from io import FileIO
from typing import Any, Deque, List, Optional, Sequence, Tuple, Union

from ...errors import PortError
from ...p2os import BAUD_RATES
from .uart import as_heard

UNREAD_LIMIT = 8 * 1024
"""Bytes kept for a TCP client that does not read: about ten seconds of SIPs. The kernel may keep as much again."""
PTY_UNREAD_LIMIT = 1024
"""Bytes left in a pseudo-terminal that nobody reads: about a second of SIPs. A later client hears nothing older."""
BACKLOG = 4
CHUNK = 4096
ISPEED, OSPEED = 4, 5
"""Where `termios.tcgetattr` has the speeds."""
BAUD_RATE_OF = {getattr(termios, "B%s" % baud): baud for baud in (300, 600, 1200, 2400, 4800, *BAUD_RATES, 230400)}
"""Speeds (baud) of terminals, by the numbers that stand for them. Another speed of the client garbles nothing."""

TCP_PROBLEMS = {
    errno.EADDRINUSE: "TCP port %(port)d is in use, perhaps by another simulator: stop that one, or choose another port"
                      " (0 takes any free one)",
    errno.EACCES: "TCP port %(port)d may not be opened by this user: choose one above 1023",
}
"""What is told of errors that users meet."""


class _Line(ABC):
    """What a TCP port and a pseudo-terminal have in common.

    Attributes:
        baud: speed of the robot's end; a TCP port has none, and does not use it.
        plugged: whether the cable is in.
        clients: how many have come, where one can be told from the next.
        finished: the client has ended its session. At a TCP port another one is welcome then, whether or not this one
            hangs up.
    """

    def __init__(self, baud: int):
        self.baud = baud
        self.plugged = False
        self.clients = 0
        self.finished = False

    def plug(self, in_: bool) -> None:
        """Pull the cable out, or put it back: `close`, or open again.

        Raises:
            PortError: another program has the port now, or the link cannot be made.
        """
        if not in_:
            self.close()
        elif not self.plugged:
            self._open()
            self.plugged = True

    @abstractmethod
    def files(self) -> Sequence[Any]:
        """What to wait on for something to read."""

    @abstractmethod
    def close(self) -> None:
        """Hang up, and give the port or the terminal back."""

    @abstractmethod
    def _open(self) -> None:
        """Open the port or the terminal."""


class TcpLine(_Line):
    """A TCP port that welcomes one client at a time.

    Args:
        address: a port (0: any free one) that only this machine can reach, or ``"host:port"``.

    Attributes:
        host, port, url: where clients connect.
        client: the socket of the present client, None without one.

    Raises:
        PortError: the port cannot be opened; the message says what to do.
    """

    def __init__(self, address: Union[int, str]):
        super().__init__(0)
        self.host, self.port = host_and_port(address)
        self.client: Optional[socket.socket] = None
        self._unsent: Deque[bytes] = collections.deque()
        self.plug(True)
        self.url = "socket://%s:%d" % (self.host, self.port)

    client_baud: Optional[int] = None
    """A TCP port has no speed."""

    def files(self) -> List[socket.socket]:
        """What to wait on for something to read."""
        return [file for file in (self._listener, self.client) if file is not None] if self.plugged else []

    def read(self, busy: bool) -> bytes:
        """What the client sent since the last call.

        When this client has ended its session or hung up, the line welcomes the next one.

        Args:
            busy: throw away what the client sent, and welcome nobody.
        """
        data = self._receive()
        if not data and self._welcome(busy):    # not before the last bytes of this client, which may end its session
            data = self._receive()
        if data:
            self.finished = False
        elif data is not None:
            self._dismiss()
        return b"" if busy else data or b""

    def write(self, data: bytes) -> None:
        """Send to the client, if there is one. What it does not read in time is lost, oldest first."""
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
            return
        except OSError:
            self._dismiss()

    def close(self) -> None:
        """Hang up and give the port back. Who connects now is refused."""
        self._dismiss()
        if self.plugged:
            self.plugged = False
            self._listener.close()

    def _open(self) -> None:
        self._listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._listener.setblocking(False)
        try:
            self._listener.bind((self.host, self.port))
            self._listener.listen(BACKLOG)
        except OSError as error:
            self._listener.close()
            problem = TCP_PROBLEMS.get(error.errno or 0, "cannot open TCP port %(port)d of %(host)s: %(why)s")
            raise PortError(problem % dict(port=self.port, host=self.host, why=error.strerror or error)) from error
        self.host, self.port = self._listener.getsockname()

    def _welcome(self, busy: bool) -> bool:
        """Let the next client in, if there is one, or turn it away; whether it is in."""
        try:
            client, _ = self._listener.accept()
        except OSError:     # nobody, or gone again
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
        """The next bytes of the client.

        Returns:
            None if they have not come yet; empty if none will: the client has hung up, or there is none.
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
    """A pseudo-terminal, found under a link whose name stays the same from one start to the next.

    Like a serial line it garbles what goes through while its two ends have different speeds.

    Args:
        link: path of the link; a link that an earlier simulator left there is replaced, anything else is not touched.
        baud: speed of the robot's end; also that of the client's until a client sets it.

    Raises:
        PortError: the link cannot be made; the message says why.
    """

    def __init__(self, link: str, baud: int = 9600):
        super().__init__(baud)
        self.link = link
        is_ours = os.path.islink(link) and (os.readlink(link).startswith("/dev/pts/") or not os.path.exists(link))
        if os.path.lexists(link) and not is_ours:
            raise PortError("%s exists and is not the link of a simulated robot: remove it or choose another path"
                            % link)
        self.plug(True)

    @property
    def client_baud(self) -> int:
        """Speed of the client's end: what it was last set to, by this client or one before it."""
        return BAUD_RATE_OF.get(termios.tcgetattr(self._slave)[OSPEED], self.baud)

    @property
    def unread(self) -> int:
        """How many bytes wait in the terminal for somebody to read them."""
        count, = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, bytes(struct.calcsize("i"))))
        return int(count)

    def files(self) -> List[FileIO]:
        """What to wait on for something to read."""
        return [self._master] if self.plugged else []

    def read(self, busy: bool) -> bytes:
        """What clients sent since the last call; nothing when `busy`: then the line throws it away."""
        data = self._master.read(CHUNK) if self.plugged else None
        return b"" if busy or not data else as_heard(data, self.client_baud, self.baud)

    def write(self, data: bytes) -> None:
        """Send to the clients that have the terminal open. What nobody has read is lost when it is too much."""
        if self.plugged:
            if self.unread > PTY_UNREAD_LIMIT:
                termios.tcflush(self._slave, termios.TCIFLUSH)
            if self._master.write(as_heard(data, self.baud, self.client_baud)) is None:     # it is full
                termios.tcflush(self._slave, termios.TCIFLUSH)

    def close(self) -> None:
        """Remove the link, if it is still ours, and close the terminal, as when one pulls out a USB adapter."""
        if self.plugged:
            self.plugged = False
            if os.path.islink(self.link) and os.readlink(self.link) == self.device:
                os.unlink(self.link)
            self._close_files()

    def _open(self) -> None:
        # Our own hold on the client's end keeps the terminal raw and alive while clients come and go.
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
    """Host and port of a TCP address. An address without a host is one of this machine only.

    Raises:
        PortError: the text is not a TCP address.
    """
    host, _, port = str(address).rpartition(":")
    if not port.isdigit() or int(port) > 65535:
        raise PortError("%r is no TCP port: wanted 0 to 65535 (0 takes any free one), or host:port" % address)
    return host or "127.0.0.1", int(port)

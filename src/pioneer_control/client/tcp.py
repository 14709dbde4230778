"""Ports on TCP: ``socket://host:port``."""

import contextlib
import re
import socket
import time
from typing import Any, Optional, Tuple

from ..errors import PortError
from .transport import StreamTransport

DEFAULT_PORT = 8101             # of simulators and serial-to-network bridges (protocol 2.1)
CONNECT_TIMEOUT = 3.0           # s
DRAIN_TIMEOUT = 0.15            # s that close() leaves the other side to take the last bytes
WITHOUT_A_ROBOT = (
    "Without a robot: python3 -m pioneer_control.simulator --tcp %d simulates one; "
    "in ROS, pioneer.launch with sim:=true")

LOCKSTEP = "?lockstep"          # at the end of a URL: see the file lockstep
TCP_URL = re.compile(r"^(?P<scheme>(?:socket|tcp)://)?(?P<host>[^/:?]+|\[[^\]]+\])(?::(?P<port>\d+))?(?(scheme)/?)$")


def tcp_address(url: str) -> Optional[Tuple[str, int]]:
    """Return host and port of ``socket://host:port``, ``tcp://host:port`` or ``host:port``; None for any other text.

    Without a port, ``socket://host`` and ``tcp://host`` mean DEFAULT_PORT. Each may end with ``?lockstep``.
    """
    match = TCP_URL.match(url[:-len(LOCKSTEP)] if url.endswith(LOCKSTEP) else url)
    if match is None or not (match["scheme"] or match["port"]):
        return None
    return match["host"].strip("[]"), int(match["port"] or DEFAULT_PORT)


def is_lockstep(url: str) -> bool:
    """Return whether a URL asks for lockstep with a simulated robot: ``socket://host:port?lockstep``."""
    return url.endswith(LOCKSTEP) and tcp_address(url) is not None


class SocketTransport(StreamTransport):
    """A TCP connection.

    Args:
        url: the port, for error messages.
        connection: a connected socket that never blocks. The transport closes it.
    """

    def __init__(self, url: str, connection: Any) -> None:
        super().__init__(url, None, connection, connection.recv, connection.send)

    def close(self) -> None:
        """Close the connection, after the other side has taken all bytes or DRAIN_TIMEOUT has passed.

        First say that no more bytes follow, and read until the other side closes, too. A close with unread input would
        send RST and cancel our last bytes.
        """
        deadline = time.monotonic() + DRAIN_TIMEOUT
        with contextlib.suppress(OSError):      # LinkLostError is one: the other side is done
            self._say_end()
            while time.monotonic() < deadline:
                self.read(deadline - time.monotonic())
        super().close()

    def _say_end(self) -> None:
        self._port.shutdown(socket.SHUT_WR)


def connect(url: str, host: str, port: int, advice: str) -> socket.socket:
    """Return a TCP connection that never blocks, without Nagle's delay.

    Raises PortError with what to do. ``advice`` is for a user whose connection is refused.
    """
    if not 0 < port <= 65535:
        raise PortError("%s: there is no TCP port %d (legal: 1..65535)" % (url, port))
    try:
        connection = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        return connection
    except ConnectionRefusedError as error:
        raise PortError(
            "%s: connection refused: nothing listens on port %d of %s. %s" % (url, port, host, advice)
        ) from error
    except (socket.gaierror, UnicodeError) as error:
        raise PortError("%s: no such host: %s" % (url, getattr(error, "strerror", error))) from error
    except socket.timeout as error:
        raise PortError("%s: no answer from %s within %.0f s: is it switched on and in this network?"
                        % (url, host, CONNECT_TIMEOUT)) from error
    except OSError as error:
        raise PortError("%s: cannot connect: %s" % (url, error)) from error

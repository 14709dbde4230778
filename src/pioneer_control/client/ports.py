"""Opens a port of the kind that its URL names: a serial port, a pty, TCP, or a WebSocket."""

from typing import Optional

from ..errors import PortError
from ..port_url import is_web_socket
from .serial_port import open_serial
from .tcp import DEFAULT_PORT, LOCKSTEP, WITHOUT_A_ROBOT, SocketTransport, connect, tcp_address
from .transport import Transport
from .web_socket import open_web_socket


def is_serial(url: str) -> bool:
    """Return whether the port is a serial port or a pty, so that it has a line speed."""
    return tcp_address(url) is None and not is_web_socket(url)


def open_transport(url: str, baud: int, key: Optional[str] = None, advice: Optional[str] = None) -> Transport:
    """Open ``/dev/ttyUSB0``, the path of a pty, ``socket://host:port``, ``ws://host:port/path`` or ``wss://...``.

    ``socket://host:port?lockstep`` opens the same port as without ``?lockstep``.

    Args:
        url: the port, without a key.
        baud: the line speed of a serial port. No other port uses it.
        key: the key of a robot behind a WebSocket. No other port uses it.
        advice: a sentence for a user whose port is not there. If None, how to simulate a robot.

    Raises PortError that says why the port does not open and what to do.
    """
    address = tcp_address(url)
    if address is not None:
        return SocketTransport(url, connect(url, *address, advice or WITHOUT_A_ROBOT % address[1]))
    if is_web_socket(url):
        return open_web_socket(url, key or "")
    if url.isdigit():
        raise PortError(
            "cannot understand the port %r: for a robot on that TCP port of this machine give socket://localhost:%s"
            % (url, url))
    if "://" in url:
        raise PortError("cannot understand the port %r: give a path such as /dev/ttyUSB0, socket://host:port, or "
                        "ws://host:port/path" % url)
    if url.endswith(LOCKSTEP):
        raise PortError("cannot use lockstep on the port %r: it needs a simulated robot on TCP; give "
                        "socket://host:port%s" % (url, LOCKSTEP))
    return open_serial(url, baud, advice or WITHOUT_A_ROBOT % DEFAULT_PORT)

"""Opens a port of the kind that its URL names: a serial port, a pty, or TCP."""

from ..errors import PortError
from .serial_port import open_serial
from .tcp import WITHOUT_A_ROBOT, SocketTransport, connect, tcp_address
from .transport import Transport


def is_serial(url: str) -> bool:
    """Return whether the port is a serial port or a pty, so that it has a line speed."""
    return tcp_address(url) is None


def open_transport(url: str, baud: int) -> Transport:
    """Open ``/dev/ttyUSB0``, the path of a pty, or ``socket://host:port``. Only serial ports use ``baud``.

    Raises PortError that says why the port does not open and what to do.
    """
    address = tcp_address(url)
    if address is not None:
        return SocketTransport(url, connect(url, *address, WITHOUT_A_ROBOT % address[1]))
    if url.isdigit():
        raise PortError(
            "cannot understand the port %r: for a robot on that TCP port of this machine give socket://localhost:%s"
            % (url, url))
    if "://" in url:
        raise PortError("cannot understand the port %r: give a path such as /dev/ttyUSB0, or socket://host:port" % url)
    return open_serial(url, baud)

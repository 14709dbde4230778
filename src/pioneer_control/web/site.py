"""Where the page is served: the sockets that listen, the keys, and what the person at the terminal reads of them."""

import contextlib
import fcntl
import secrets
import socket
import struct
from typing import List, NamedTuple, Optional, Sequence

from ..errors import PioneerError
from .owner import Told

KEY = "PIONEER_WEB_KEY"
"""The variable of the environment that may give the page its key, for a program that starts the page and shows its
address itself.
"""
LOOPBACK, EVERYWHERE = ("127.0.0.1", "::1"), ("0.0.0.0", "::")
SIOCGIFADDR = 0x8915
"""What Linux is asked for the address of an interface."""
SHARED = """\
Every machine that reaches this one and has an address below can see the robots and drive them. What is sent is not
encrypted: share only in a network that you trust."""


class Site(NamedTuple):
    """The place of one page."""

    listening: List[socket.socket]
    told: Told
    teacher: str
    """The key of the person at this computer."""
    others: Optional[str]
    """The key of those who are no teachers; None if there are none."""
    shared: bool = False
    """Whether other computers may open the page."""

    @property
    def port(self) -> int:
        """The TCP port."""
        return int(self.listening[0].getsockname()[1])

    @property
    def address(self) -> str:
        """The page's address for the person at this computer, with the key in its fragment."""
        return "http://127.0.0.1:%d/#%s" % (self.port, self.teacher)

    @property
    def warning(self) -> str:
        """What to warn of at the start; empty where the page is for this computer only."""
        return SHARED if self.shared else ""

    @property
    def class_address(self) -> str:
        """The page's address for students, with the key in its fragment."""
        return "http://%s:%d/#%s" % (own_addresses()[0] if self.shared else "127.0.0.1", self.port, self.others)

    def welcome(self) -> List[str]:
        """Return what to print at the start."""
        if not self.shared:
            return ["The page:  %s" % self.address]
        return [*("For others:  http://%s:%d/#%s" % (host, self.port, self.others) for host in own_addresses()),
                "For you, the teacher:  %s" % self.address]

    def close(self) -> None:
        """Close the sockets."""
        for each in self.listening:
            each.close()


def open_site(title: str, port: int, share: bool, key: Optional[str] = None, is_class: bool = False) -> Site:
    """Listen on a TCP port, and make keys.

    Args:
        title: what the page is called.
        port: the port; 0 for any that is free.
        share: whether other computers may open the page.
        key: the key of the person at this computer. None: a new one.
        is_class: whether there are students: they have a key of their own also where all sit at this computer.

    Raises:
        PioneerError: the port is taken, or not allowed.
    """
    teacher, others = key or secrets.token_urlsafe(16), secrets.token_urlsafe(16) if share or is_class else None
    keys = {teacher: True, **({} if others is None else {others: False})}
    names = own_names() if share else ["localhost"]
    return Site(listen(EVERYWHERE if share else LOOPBACK, port), Told(keys, title, names), teacher, others, share)


def listen(hosts: Sequence[str], port: int) -> List[socket.socket]:
    """Return sockets that listen on one port of each host; the first decides which, if ``port`` is 0.

    A host but the first is left out where this machine does not have it (IPv6).

    Raises:
        PioneerError: the port is taken or not allowed. It says what to do.
    """
    sockets: List[socket.socket] = []
    for host in hosts:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            each = socket.socket(family, socket.SOCK_STREAM)
            sockets.append(each)
            each.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                each.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            each.bind((host, port))
            each.listen(128)
            each.setblocking(False)
        except (OSError, OverflowError) as error:
            if len(sockets) > 1:
                sockets.pop().close()
                continue
            for each in sockets:
                each.close()
            raise PioneerError(
                "port %d of %s: %s. Give another one, --port 0 for any that is free; `ss -ltnp` shows who has it"
                % (port, host, getattr(error, "strerror", None) or error)) from error
        port = sockets[0].getsockname()[1]
    return sockets


def own_names() -> List[str]:
    """Return the names by which browsers may call this machine."""
    name = socket.gethostname().lower()
    short = name.partition(".")[0]
    return sorted({"localhost", name, short, short + ".local"})


def own_addresses() -> List[str]:
    """Return the addresses of this machine in its networks, best first; its name if there is none."""
    found = []
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))     # sends nothing: only asks which address would be used
        found.append(probe.getsockname()[0])
    found += [address for _, interface in socket.if_nameindex() for address in addresses_of(interface)]
    return [each for each in dict.fromkeys(found) if not each.startswith("127.")] or [socket.gethostname()]


def addresses_of(interface: str) -> List[str]:
    """Return the IPv4 address of a network interface, or none. A network without a way to the internet has one, too."""
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker:
        answer = fcntl.ioctl(asker, SIOCGIFADDR, struct.pack("256s", interface.encode()))
        return [socket.inet_ntoa(answer[20:24])]
    return []

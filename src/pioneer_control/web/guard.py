"""Who may talk to the web server, and which files it has. Pure, but for reading the files once.

===============  ======================================================================================================
what             rule
===============  ======================================================================================================
Host             a literal address, or a name of this machine: a page of somebody else whose name was made to lead here
                 (DNS rebinding) has another name
Origin           if there is one, exactly the scheme and the Host of the request. Browsers always send it; programs need
                 not, because the key is needed anyway
key              compared in constant time with every key
rates            messages of a page, and messages, bytes and packets of a program: so many a second
files            those in the folder of the page when the server started, with a known ending; no other path exists
===============  ======================================================================================================
"""

import hmac
import ipaddress
import pathlib
from typing import Collection, Dict, Mapping, NamedTuple, Optional

NONSENSE, WRONG_KEY, NO_ROBOT, NO_WORDS, TOO_SLOW, REPLACED, TOO_MANY = 4400, 4401, 4404, 4408, 4409, 4409, 4429
"""Codes of the page's protocol with which a connection is closed."""

MIME_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".webmanifest": "application/manifest+json",
}
"""For each ending of a file of the page: its type. Other files are not served."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
                               "connect-src 'self'; base-uri 'none'; frame-ancestors 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
    "Server": "pioneer_control",
}
"""Headers of every answer."""


class Farewell(NamedTuple):
    """Why a connection is closed: a code of the page's protocol, and a reason for people."""

    code: int
    reason: str


class Allowance:
    """How much somebody may still send: so much a second, and at once as much as in a second.

    Args:
        per_second: how much.
        now: the present time (monotonic, s).
    """

    def __init__(self, per_second: float, now: float) -> None:
        self._per_second, self._left, self._at = per_second, float(per_second), now

    def spends(self, amount: float, now: float) -> bool:
        """Return whether so much more may come now (monotonic, s), and if so, count it."""
        self._left = min(self._per_second, self._left + (now - self._at) * self._per_second)
        self._at = now
        if self._left < amount:
            return False
        self._left -= amount
        return True


LONGEST_MESSAGE = 4096              # bytes of a message of a program
MOST_MESSAGES = 200                 # of a program in a second
MOST_BYTES = 65536                  # of a program in a second
MOST_PACKETS = 400                  # of a program in a second
HEAD = b"\xfa\xfb"                  # with which a packet begins


class ProgramLimits:
    """How much a program may send to a robot. ``now``: the present time (monotonic, s)."""

    def __init__(self, now: float) -> None:
        self._messages, self._bytes = Allowance(MOST_MESSAGES, now), Allowance(MOST_BYTES, now)
        self._packets = Allowance(MOST_PACKETS, now)

    def check(self, data: bytes, now: float) -> Optional[Farewell]:
        """Count a message. Returns a Farewell if it is too much."""
        if len(data) > LONGEST_MESSAGE:
            return Farewell(TOO_MANY, "a message has %d bytes; at most %d are legal" % (len(data), LONGEST_MESSAGE))
        if (self._messages.spends(1, now) and self._bytes.spends(len(data), now)
                and self._packets.spends(data.count(HEAD), now)):
            return None
        return Farewell(TOO_MANY, "this program sends more than %d messages, %d bytes or %d packets in a second"
                        % (MOST_MESSAGES, MOST_BYTES, MOST_PACKETS))


class PageFile(NamedTuple):
    """One file of the page: its type and its contents."""

    mime_type: str
    contents: bytes


def page_files(folder: pathlib.Path) -> Dict[str, PageFile]:
    """Return the files of the page by their paths ("/app.js"), also "/" for index.html. A link that leads out of the
    folder is left out.
    """
    inside, files = folder.resolve(), {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in MIME_TYPES and inside in path.resolve().parents:
            files["/" + path.relative_to(folder).as_posix()] = PageFile(MIME_TYPES[path.suffix], path.read_bytes())
    if "/index.html" in files:
        files["/"] = files["/index.html"]
    return files


def is_our_host(host: str, names: Collection[str]) -> bool:
    """Return whether the header Host (with or without a port) means this machine. ``names``: its names."""
    name, _, port = host.rpartition(":")
    if not name or not port.isdigit() or name.count(":") and not name.endswith("]"):
        name = host
    if name.startswith("[") and name.endswith("]"):
        name = name[1:-1]
    try:
        ipaddress.ip_address(name)
        return True
    except ValueError:
        return name.lower().rstrip(".") in names


def is_our_origin(origin: Optional[str], scheme: str, host: str) -> bool:
    """Return whether the header Origin (None: there is none) is that of a page from this server."""
    return origin is None or origin == "%s://%s" % (scheme, host)


def is_teachers(key: str, keys: Mapping[str, bool]) -> Optional[bool]:
    """Return whether a key is a teacher's; None for a wrong key. ``keys``: for each key whether it is a teacher's."""
    found = None
    for each, is_teacher in keys.items():
        if hmac.compare_digest(key.encode("utf-8", "surrogatepass"), each.encode()):
            found = is_teacher
    return found

"""The web server: passes pictures of robots from their owner to viewers, and orders back. It decides nothing.

It is a program of its own, started by the owner: ``python3 -m pioneer_control.web.server LINK SOCKETS [FOLDER]`` with
the numbers of inherited file descriptors. It ends when the owner closes its end of the link. `exchange` has the
messages of the link, `fleet` decides what viewers get, `guard` who may come.
"""

import asyncio
import collections
import itertools
import json
import logging
import pathlib
import resource
import socket
import sys
from time import monotonic
from types import TracebackType
from typing import Any, Counter, Dict, List, Optional, Type, Union

from tornado.httpserver import HTTPServer
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from ..errors import UsageError
from .backend import Person
from .exchange import (BEAT, BEAT_MESSAGE, BYTES, CAME, CLOSED, CONFIGURE, FRAME, GONE, JOIN, OPENED, ORDER,
                       PROGRAM_GONE, SAID, TEXT, WHOLE, Part, Unpacker, bytes_of, packed, packed_bytes, packed_json)
from .fleet import Fleet, Message
from .guard import (HEADERS, NO_WORDS, NONSENSE, TOO_SLOW, WRONG_KEY, Farewell, PageFile, ProgramLimits, is_our_host,
                    is_our_origin, is_teachers, page_files)
from .orders import DrawnOrder, NameOrder, PingOrder, first_words, order_of, program_key, read_message
from .wheels import all_wheels, package_files

PAGE = pathlib.Path(__file__).resolve().parent / "page"
FIRST_WORDS_WITHIN = 5.0    # s
MOST_WAITING = 200          # connections without first words
LONGEST_MESSAGE = 16384     # bytes that are read at all; those beyond 4 kB only to say so
LONGEST_REASON = 120        # bytes of the reason of a close
PING_EVERY, PONG_WITHIN = 5.0, 15.0     # s
MOST_UNREAD = 65536         # bytes for a program that the system does not take
PENALTY = 1.0               # s until a refusal is told to a program, so that none asks again and again
MOST_TO_OWNER = 2 ** 18     # bytes of orders that wait for the owner; more are dropped
LOG = logging.getLogger(__name__)


class Hub(asyncio.Protocol):
    """The middle of the server: the link to the owner, the fleet, and the connections of viewers."""

    def __init__(self) -> None:
        self.fleet = Fleet("")
        self.keys: Dict[str, bool] = {}
        self.hosts: List[str] = []
        self.waiting: Counter[Type["GuardedSocket"]] = collections.Counter()
        """Of each kind of connections those that were not accepted yet."""
        self.ready, self.ended = asyncio.Event(), asyncio.Event()
        self._unpacker = Unpacker()
        self._numbers = itertools.count(1)
        self._pages: Dict[int, "PageSocket"] = {}
        self._programs: Dict[int, "ProgramSocket"] = {}
        self._timer: Optional[asyncio.TimerHandle] = None
        self._link: Optional[asyncio.Transport] = None

    # The link to the owner

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the link, and begin to send beats."""
        assert isinstance(transport, asyncio.Transport)
        self._link = transport
        self._beat()

    def data_received(self, data: bytes) -> None:
        """Take what the owner says, and pass it on."""
        for part in self._unpacker.take(data):
            self._take(part)
        self.go()

    def connection_lost(self, error: Optional[Exception]) -> None:
        """End: the owner has ended, or wants no more of this server."""
        self.ended.set()

    def _take(self, part: Part) -> None:
        kind, contents = part
        if kind in (FRAME, WHOLE):
            (self.fleet.frame if kind == FRAME else self.fleet.whole)(contents)
            return
        if kind == BYTES:
            number, data = bytes_of(contents)
            if number in self._programs:
                self._programs[number].send_bytes(data)
            return
        value = json.loads(contents.decode())
        if kind == TEXT:
            self.fleet.text(value["kind"], value["value"], value["robot"], value["seat"], value.get("to", ""))
        elif kind == SAID:
            self.fleet.said(value["level"], value["text"], value["robot"], value["viewers"], monotonic())
        elif kind == CONFIGURE:
            self.keys, self.hosts = value["keys"], value["hosts"]
            self.fleet = Fleet(value["title"], value.get("kind", "live"))
            self.ready.set()
        elif kind in (OPENED, CLOSED) and value["program"] in self._programs:
            program = self._programs[value["program"]]
            if kind == OPENED:
                program.opened(value["robot"])
            else:
                program.dismiss(Farewell(value["code"], value["reason"]))

    def _beat(self) -> None:
        self._tell_owner(packed(BEAT_MESSAGE))
        self._round(monotonic())    # also for sockets that took nothing when there was something new
        asyncio.get_running_loop().call_later(BEAT, self._beat)

    def _tell_owner(self, message: bytes, must: bool = False) -> None:
        if self._link is not None and (must or self._link.get_write_buffer_size() < MOST_TO_OWNER):
            self._link.write(message)

    # Viewers

    def come(self, page: "PageSocket", message: Union[str, bytes]) -> Optional[int]:
        """Take the first words of a page. Returns the number of the viewer; None if it was sent away."""
        words = first_words(read_message(message))
        is_teacher = is_teachers(words.key, self.keys)
        if is_teacher is None:
            page.bye(Farewell(WRONG_KEY, "the key is wrong: open the whole address that the server printed, with # "
                                         "and the key at its end"))
            return None
        number = next(self._numbers)
        farewell = self.fleet.arrive(number, Person(number, words.visitor, "", is_teacher), monotonic())
        if farewell is not None:
            page.bye(farewell)
            return None
        self._pages[number] = page
        self._tell_owner(packed_json(CAME, list(self.fleet.viewers[number].person)))
        self.go()
        return number

    def hear(self, number: int, message: Union[str, bytes]) -> Optional[str]:
        """Take a message of a viewer. Returns what to answer at once.

        Raises UsageError for a message that makes no sense.
        """
        now = monotonic()
        farewell = self.fleet.hears(number, now)
        if farewell is not None:
            self._pages[number].bye(farewell)
            return None
        read = read_message(message)
        try:
            order = order_of(read)
        except UsageError as error:
            self.fleet.said("error", str(error), None, [number], now)
            self.go()
            return None
        if isinstance(order, PingOrder):
            return json.dumps({"pong": order.at})
        if isinstance(order, DrawnOrder):
            self.fleet.drawn(number, order.stamp, now)
            self.go()
            return None
        if isinstance(order, NameOrder):
            self.fleet.name(number, order.name)
        self._tell_owner(packed_json(ORDER, {"person": list(self.fleet.viewers[number].person), "message": read}))
        return None

    def leave(self, number: int) -> None:
        """Forget a viewer whose connection is gone, and tell the owner."""
        del self._pages[number]
        self.fleet.leave(number)
        self._tell_owner(packed_json(GONE, number), must=True)

    # Programs

    def join(self, program: "ProgramSocket", robot: Optional[int], key: str) -> int:
        """Ask the owner for a robot for a program. Returns the number of its connection."""
        number = next(self._numbers)
        self._programs[number] = program
        self._tell_owner(packed_json(JOIN, {"program": number, "robot": robot, "key": key}))
        return number

    def program_bytes(self, number: int, data: bytes) -> None:
        """Pass bytes of a program on."""
        self._tell_owner(packed_bytes(number, data))

    def program_gone(self, number: int) -> None:
        """Forget a program whose connection is gone, and tell the owner."""
        del self._programs[number]
        self._tell_owner(packed_json(PROGRAM_GONE, number), must=True)

    # What viewers get

    def go(self) -> None:
        """Give viewers what is new: now, or when the next batch is due."""
        now = monotonic()
        for number, farewell in self.fleet.farewells().items():
            self._pages[number].bye(farewell)
        wait = self.fleet.wait(now)
        if wait <= 0:
            self._round(now)
        elif wait <= 1 and self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(wait, self._timed)

    def _timed(self) -> None:
        self._timer = None
        self.go()

    def _round(self, now: float) -> None:
        for number, messages in list(self.fleet.round(now, lambda number: self._pages[number].can_take)):
            for message in messages:
                self._pages[number].send(message)


class DiscreetHandler(RequestHandler):
    """Logs what nobody expected, without the address of the request: somebody may have put a key there."""

    def log_exception(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                      trace: Optional[TracebackType]) -> None:
        """Log an error that is not one of HTTP."""
        if not isinstance(error, HTTPError):
            LOG.error("a request failed", exc_info=(kind, error, trace) if kind and error else None)


class PageHandler(DiscreetHandler):
    """Answers a request with a file of the page, or with 404. Only GET and HEAD."""

    def initialize(self, hub: Hub, files: Dict[str, PageFile]) -> None:
        """Take what tornado passes on from the application."""
        self.hub, self.files = hub, files

    def set_default_headers(self) -> None:
        """Set the headers that every answer has."""
        for name, value in HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        """Refuse a request that was meant for another machine. Raises HTTPError 421."""
        if not is_our_host(self.request.host, self.hub.hosts):
            raise HTTPError(421)

    def get(self) -> None:
        """Send the file. Raises HTTPError 404 when the page has no such file."""
        file = self.files.get(self.request.path)
        if file is None:
            raise HTTPError(404)
        self.set_header("Content-Type", file.mime_type)
        self.write(file.contents)

    def head(self) -> None:
        """Send the headers of get()."""
        self.get()

    def write_error(self, status_code: int, **_: Any) -> None:
        """Answer with one line of text that repeats nothing of the request."""
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("%d %s\n" % (status_code, self._reason))


class GuardedSocket(DiscreetHandler, WebSocketHandler):
    """A WebSocket that checks where it comes from, has to be accepted in time, and is closed with a reason.

    Attributes:
        number: the number of this connection in the hub; None as long as the hub does not know it.
    """

    def initialize(self, hub: Hub) -> None:
        """Take what tornado passes on from the application."""
        self.hub = hub
        self.number: Optional[int] = None
        self._timer: Optional[asyncio.TimerHandle] = None
        self._gone = False

    def prepare(self) -> None:
        """Refuse a request for another machine (421), one with a query: keys do not belong there (400), and too many
        connections that say nothing (503).
        """
        if not is_our_host(self.request.host, self.hub.hosts):
            raise HTTPError(421)
        if self.request.query:
            raise HTTPError(400)
        if self.hub.waiting[type(self)] >= MOST_WAITING:
            raise HTTPError(503)

    def check_origin(self, origin: str) -> bool:
        """Return whether the connection is from a page of this server. tornado asks only if there is an Origin."""
        return is_our_origin(origin, self.request.protocol, self.request.host)

    def open(self, *_: str, **__: str) -> None:
        """Wait for the first words."""
        self.set_nodelay(True)
        self.hub.waiting[type(self)] += 1
        self._timer = asyncio.get_running_loop().call_later(FIRST_WORDS_WITHIN, self.bye, Farewell(
            NO_WORDS, "nothing was said for %g s" % FIRST_WORDS_WITHIN))

    def on_message(self, message: Union[str, bytes]) -> None:
        """Take a message. One that makes no sense ends the connection."""
        if self._gone:
            return
        try:
            self.take(message)
        except UsageError as error:
            self.bye(Farewell(NONSENSE, str(error)))

    def take(self, message: Union[str, bytes]) -> None:
        """Do what a message says. Raises UsageError for what makes no sense."""
        raise NotImplementedError

    def leave(self, number: int) -> None:
        """Tell the hub that this connection is gone."""
        raise NotImplementedError

    def accepted(self) -> None:
        """Wait no more: the connection is accepted, or gone."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
            self.hub.waiting[type(self)] -= 1

    def on_close(self) -> None:
        """Forget the connection."""
        self._gone = True
        self.accepted()
        if self.number is not None:
            self.leave(self.number)
            self.number = None

    def bye(self, farewell: Farewell) -> None:
        """Close the connection with a code and a reason, and take nothing more from it."""
        if not self._gone:
            GuardedSocket.on_close(self)
            reason = farewell.reason.encode("utf-8", "replace")[:LONGEST_REASON].decode("utf-8", "ignore")
            self.close(farewell.code, reason)

    def send(self, message: Message) -> "Optional[asyncio.Future[None]]":
        """Send a message. Returns the future end of the write; None if the connection is gone."""
        try:
            sent = self.write_message(message, binary=isinstance(message, bytes))
        except WebSocketClosedError:
            return None
        sent.add_done_callback(_retrieve)
        return sent


class PageSocket(GuardedSocket):
    """The connection of one viewer."""

    def take(self, message: Union[str, bytes]) -> None:
        """Take a message of the page."""
        if self.number is None:
            self.accepted()
            self.number = self.hub.come(self, message)
        else:
            answer = self.hub.hear(self.number, message)
            if answer is not None:
                self.send(answer)

    def leave(self, number: int) -> None:
        """Forget the viewer."""
        self.hub.leave(number)

    @property
    def can_take(self) -> bool:
        """Whether the socket has taken all that was sent before."""
        stream = None if self.ws_connection is None else self.ws_connection.stream
        return stream is not None and not stream.writing()


class ProgramSocket(GuardedSocket):
    """The connection of a program that wants a robot: its key first, then bytes both ways."""

    def open(self, *names: str, **_: str) -> None:
        """Wait for the key. ``names``: what stands behind /robot/."""
        name, = names
        self._robot = int(name) if name.isascii() and name.isdigit() and len(name) <= 5 else None
        self._limits: Optional[ProgramLimits] = None    # from when it has the robot
        self._unread = 0        # bytes that the system has not taken yet
        super().open()

    def take(self, message: Union[str, bytes]) -> None:
        """Take the key, or bytes for the robot."""
        if self.number is None:
            self.number = self.hub.join(self, self._robot, program_key(read_message(message)))
            return
        if self._limits is None or isinstance(message, str):
            raise UsageError("say the key as text, wait for the answer, then send bytes of P2OS as binary messages")
        farewell = self._limits.check(message, monotonic())
        if farewell is None:
            self.hub.program_bytes(self.number, message)
        else:
            self.bye(farewell)

    def opened(self, name: str) -> None:
        """Tell the program that it has the robot of this name."""
        self.accepted()
        self._limits = ProgramLimits(monotonic())
        self.send(json.dumps({"robot": name}))

    def dismiss(self, farewell: Farewell) -> None:
        """Close the connection: at once if the program had the robot, else after PENALTY s."""
        if self._limits is not None:
            self.bye(farewell)
        else:
            asyncio.get_running_loop().call_later(PENALTY, self.bye, farewell)

    def send_bytes(self, data: bytes) -> None:
        """Send bytes of the robot. A program that does not read them is closed."""
        if self._unread + len(data) > MOST_UNREAD:
            self.bye(Farewell(TOO_SLOW, "this program does not read what its robot sends"))
            return
        sent = self.send(data)
        if sent is not None:
            self._unread += len(data)
            sent.add_done_callback(lambda _: self._taken(len(data)))

    def leave(self, number: int) -> None:
        """Forget the program."""
        self.hub.program_gone(number)

    def _taken(self, count: int) -> None:
        self._unread -= count


def _retrieve(sent: "asyncio.Future[None]") -> None:
    """Look at the result of a write: that a connection was closed meanwhile is no news."""
    if not sent.cancelled():
        sent.exception()


def application(hub: Hub, files: Dict[str, PageFile]) -> Application:
    """Return tornado's application: the page's files, and the WebSockets."""
    return Application(
        [("/page", PageSocket, dict(hub=hub)), ("/robot/(.*)", ProgramSocket, dict(hub=hub))],
        default_handler_class=PageHandler, default_handler_args=dict(hub=hub, files=files),
        log_function=lambda handler: None, websocket_max_message_size=LONGEST_MESSAGE,
        websocket_ping_interval=PING_EVERY, websocket_ping_timeout=PONG_WITHIN)


async def serve(link: socket.socket, sockets: List[socket.socket], folder: pathlib.Path) -> None:
    """Serve on these sockets until the owner closes the link."""
    hub = Hub()
    await asyncio.get_running_loop().create_connection(lambda: hub, sock=link)
    files = page_files(folder)
    wheels = asyncio.get_running_loop().run_in_executor(None, lambda: package_files(all_wheels()))
    wheels.add_done_callback(lambda made: files.update({**made.result(), **files}))
    await asyncio.wait([asyncio.ensure_future(each.wait()) for each in (hub.ready, hub.ended)],
                       return_when=asyncio.FIRST_COMPLETED)
    if not hub.ended.is_set():
        server = HTTPServer(application(hub, files), max_header_size=16384, max_body_size=1024,
                            idle_connection_timeout=30.0, body_timeout=5.0)
        server.add_sockets(sockets)
        await hub.ended.wait()


def main(arguments: List[str]) -> int:
    """Run the server with the descriptors that the owner gave. Returns the exit code 0 at the owner's end."""
    files, most_files = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most_files, most_files))    # many connections
    logging.basicConfig(format="web server: %(message)s", level=logging.ERROR)
    link = socket.socket(fileno=int(arguments[0]))
    sockets = [socket.socket(fileno=int(number)) for number in arguments[1].split(",")]
    for each in [link, *sockets]:
        each.setblocking(False)
    asyncio.run(serve(link, sockets, pathlib.Path(arguments[2]) if arguments[2:] else PAGE))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

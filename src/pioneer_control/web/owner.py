"""The process that owns the robots: their links, the seats, and the web server, which is its child.

The web server only passes on. It may be killed or stopped at any time: then every robot that a person drives is told to
stop at once, and a new server begins on the same port, because the listening sockets belong to this process. Both
speak over a stream socket (`exchange` has the table). When this process ends in any way, the server sees its end of the
socket closed, and ends too.
"""

import contextlib
import json
import math
import os
import selectors
import socket
import subprocess
import sys
import threading
from collections import deque
from time import monotonic
from typing import Any, Callable, Deque, Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, cast

from ..errors import PioneerError
from .backend import Everybody, PageRobot, Person, Rules
from .exchange import (BYTES, CAME, CONFIGURE, GONE, JOIN, ORDER, PROGRAM_GONE, READ_SIZE, WHOLE, Outbox, Part,
                       Unpacker, bytes_of, packed, packed_json)
from .orders import (HELM_ORDERS, CancelOrder, ForgetPlaceOrder, GoOrder, HelmOrder, HereOrder, MotorsOrder, NameOrder,
                     ReleaseOrder, SavePlaceOrder, SayOrder, StopOrder, TakeOrder, UnlockOrder, order_of)
from .programs import Programs
from .seats import HelmTold, Seats

SILENCE = 0.5           # s without a word of the server after which robots are stopped
PROGRAMS_LOST = 1.5     # s without a word after which programs have to connect again: what they said is too old
HUNG = 10.0             # s without a word after which the server is killed, and another one is started
STARTING = 60.0         # s that a server may need for its first word
BACK_OFF = (0.05, 2.0)  # s before a server that died is started again: at first, and at most
WELL = 10.0             # s that a server has lived when the next back-off begins with the first again
TICK = 0.05             # s between two looks at everything that depends on time
PATIENCE = 2.0          # s that the end of a server may take
SERVER_SILENT = "the server of the page did not answer for a moment: connect again"
SAID_OF: Mapping[type, str] = {
    StopOrder: "STOP", UnlockOrder: "unlocked", TakeOrder: "the helm was taken",
    ReleaseOrder: "the helm was given back to programs", GoOrder: "sent to a goal", CancelOrder: "called back",
    HereOrder: "told where it is", SavePlaceOrder: "asked to name the place",
    ForgetPlaceOrder: "asked to forget a place"}


class Told(NamedTuple):
    """How the server is started and what it is told first: see `exchange`, kind C."""

    keys: Mapping[str, bool]
    title: str
    hosts: Sequence[str]
    kind: str = "live"
    """"live" or "recording"."""


class ServerProcess:
    """The web server, while it lives: the child, and this side of its socket.

    Args:
        listening: the sockets that it serves.
        folder: where the page's files are; None for those of the package.
    """

    def __init__(self, listening: Sequence[socket.socket], folder: Optional[str]) -> None:
        self.end, theirs = socket.socketpair()
        with theirs:
            self.end.setblocking(False)
            command = [sys.executable, "-m", "pioneer_control.web.server", str(theirs.fileno()),
                       ",".join(str(each.fileno()) for each in listening)]
            path = os.pathsep.join(filter(None, [_source(), os.environ.get("PYTHONPATH")]))
            try:
                # A session of its own: Ctrl-C in the terminal is for the owner, which ends the server in its own time.
                self._process = subprocess.Popen(
                    command + ([] if folder is None else [folder]), stdin=subprocess.DEVNULL, start_new_session=True,
                    pass_fds=[theirs.fileno(), *(each.fileno() for each in listening)],
                    env=dict(os.environ, PYTHONPATH=path))
            except BaseException:
                self.end.close()
                raise
        self.unpacker = Unpacker()
        self.started = self.heard = monotonic()
        self.speaks = False

    @property
    def pid(self) -> int:
        """The id of the process."""
        return self._process.pid

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()

    def close(self) -> None:
        """Close the socket, which ends the server, and wait until it has ended. After PATIENCE s it is killed."""
        self.end.close()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _source() -> str:
    """Return the folder in which this package lies, for the search path of a child."""
    return os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Waker:
    """Ends the wait of the owner's loop. Any thread, and a signal handler, may call wake()."""

    def __init__(self, selector: selectors.BaseSelector) -> None:
        self.end, self._other = socket.socketpair()
        for each in (self.end, self._other):
            each.setblocking(False)
        selector.register(self.end, selectors.EVENT_READ)

    def wake(self) -> None:
        """End the present wait, or the next one."""
        with contextlib.suppress(OSError):      # full: it wakes anyway; closed: it has ended
            self._other.send(b"\0")

    def empty(self) -> None:
        """Forget all calls of wake()."""
        with contextlib.suppress(BlockingIOError):
            self.end.recv(READ_SIZE)

    def close(self) -> None:
        """Close both ends."""
        self.end.close()
        self._other.close()


class Restart:
    """When to start a server again: ever later, while servers die soon."""

    def __init__(self) -> None:
        self.at = -math.inf
        """Time (monotonic, s) from which a server may be started."""
        self._back_off = BACK_OFF[0]

    def died(self, started: float, now: float) -> None:
        """Take note that a server which was started then is gone."""
        self._back_off = BACK_OFF[0] if now - started > WELL else min(2 * self._back_off, BACK_OFF[1])
        self.at = now + self._back_off


class Owner:
    """Owns robots and the web server, and is the Stage of the robots. run() does all the work.

    Args:
        listening: sockets on which the server listens. They stay open when a server dies.
        told: what the server has to know.
        recording: binary messages that each viewer gets first: a recording for the page. Empty: robots are live.
        folder: where the page's files are; None for those of the package.
        say: called with warnings and errors for the person at the terminal.

    Attributes:
        outbox: the Feed of the robots.
        server: the present server; None for a moment, after one died.
        rules: who may drive which robot, and what else pages may order.
        programs: the programs that share the robots.
        look: called in each turn of the loop, about twenty times a second; it may call keep().
    """

    def __init__(self, listening: Sequence[socket.socket], told: Told, *, recording: Sequence[bytes] = (),
                 folder: Optional[str] = None, say: Callable[[str], None] = lambda sentence: None) -> None:
        self.outbox = Outbox()
        self.server: Optional[ServerProcess] = None
        self._robots: Dict[int, PageRobot] = {}
        self.rules: Rules = Everybody()
        self.programs = Programs(self.outbox)
        self._seats = Seats(lambda person, robot: self.rules.may(person, robot), lambda robot: self.rules.who(robot))
        self._make_server: Callable[[], ServerProcess] = lambda: ServerProcess(listening, folder)
        self._first = [packed_json(CONFIGURE, told._asdict()), *(packed(WHOLE, each) for each in recording)]
        self.look: Callable[[], None] = lambda: None
        self._say = say
        self._entries: Optional[List[Dict[str, Any]]] = None    # as they were told last
        self._helms: Dict[int, HelmTold] = {}       # as they were told last
        self._is_lost = True                        # robots were stopped because the server is silent
        self._restart = Restart()
        self._changed: Deque[PageRobot] = deque()
        self._show_at = -math.inf                   # time of the next look at what changes slowly
        self._selector = selectors.DefaultSelector()
        self._waker = Waker(self._selector)
        self._ends = threading.Event()
        self._runs = False

    def keep(self, robots: Iterable[PageRobot]) -> None:
        """Own these robots from now on, and no others: new ones are started, and others forgotten.

        Call it before run(), or from ``look``.
        """
        before, self._robots = self._robots, {robot.number: robot for robot in robots}
        for number in set(before) - set(self._robots):
            self._seats.remove(number)
            self._helms.pop(number, None)
        if self._runs:
            for number in set(self._robots) - set(before):
                self._robots[number].start()
        self._tell_robots()

    def run(self) -> None:
        """Serve until end(), then stop the robots, switch their motors off, and end the server.

        Raises:
            PioneerError: a setting of a robot is not legal.
        """
        try:
            self._runs = True
            self._tell_robots()
            for robot in self._robots.values():
                robot.start()
            while not self._ends.is_set():
                self._turn()
        finally:
            self._close()

    def end(self) -> None:
        """Let run() end soon. Any thread, and a signal handler, may call this."""
        self._ends.set()
        self.wake()

    def wake(self) -> None:
        """Let the next turn of the loop begin at once. Any thread may call this."""
        self._waker.wake()

    # One turn of the loop

    def _turn(self) -> None:
        now = monotonic()
        if self.server is None and now >= self._restart.at:
            self._start_server()
        for key, events in self._selector.select(max(0.0, min(TICK, self.programs.due - now))):
            if key.fileobj is self._waker.end:
                self._waker.empty()
            elif events & selectors.EVENT_READ:
                self._hear()
        now = monotonic()
        self._watch(now)
        self.programs.turn(now)
        if now >= self._show_at or self._changed:       # not with each packet of a robot
            self._show_at = now + TICK
            while self._changed:
                self._introduce(self._changed.popleft())
            self.look()
            self._show(now)
        self._send()

    def _hear(self) -> None:
        """Read what the server says, and do it."""
        server = self.server
        if server is None:
            return
        try:
            data = server.end.recv(READ_SIZE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._drop_server()
            return
        server.heard, server.speaks, self._is_lost = monotonic(), True, False
        try:
            for part in server.unpacker.take(data):
                self._obey(part)
        except (ValueError, TypeError, LookupError, AttributeError) as error:
            self._say("the web server said what makes no sense, and is replaced: %s" % error)
            self._drop_server()

    def _obey(self, part: Part) -> None:
        kind, contents = part
        if kind == BYTES:
            self.programs.receive(*bytes_of(contents), monotonic())
        elif kind == PROGRAM_GONE:
            self.programs.gone(int(contents))
        elif kind == JOIN:
            value = json.loads(contents.decode())
            self.programs.join(value["program"], value["robot"], value["key"], self.rules, monotonic())
        elif kind == CAME:
            self.rules.came(Person(*json.loads(contents.decode())))
        elif kind == GONE:
            self._seats.left(int(contents), monotonic())
            self.rules.left(int(contents))
        elif kind == ORDER:
            value = json.loads(contents.decode())
            person = self.rules.known(Person(*value["person"]))
            try:
                self._do(person, value["message"])
            except PioneerError as error:
                self.outbox.said("error", str(error), None, [person.viewer])

    def _do(self, person: Person, message: Dict[str, Any]) -> None:
        """Do what a message of a page orders. Raises UsageError for a message that is not legal."""
        order, now = order_of(message), monotonic()
        if isinstance(order, NameOrder):
            self._seats.rename(person)
        elif isinstance(order, SayOrder):
            if not person.teacher:
                raise PioneerError("only the teacher speaks to all")
            self.outbox.said("info", "%s: %s" % (person.name or "teacher", order.text))
        elif isinstance(order, HELM_ORDERS):
            self._command(person, cast(HelmOrder, order), now)
        else:
            self.rules.obey(person, order, now)
        self._show_helms(now)

    def _command(self, person: Person, order: HelmOrder, now: float) -> None:
        """Let the seats do an order about robots, and tell its person what was refused, and others what was done."""
        answers = self._seats.obey(person, order, now)
        for robot, reason in answers:
            self.outbox.said("error", reason, robot, [person.viewer])
        if answers:
            return
        if isinstance(order, MotorsOrder):
            self._robots[order.robot].asked = person.viewer
        elif type(order) in SAID_OF:
            sentence = SAID_OF[type(order)] + (", by %s" % person.name if person.name else "")
            robots = [order.robot] if isinstance(order.robot, int) else [
                robot for robot in self._robots if self.rules.may(person, robot)]
            if len(robots) == 1:
                self.outbox.said("info", sentence, robots[0], self.rules.viewers(robots[0]))
            elif robots:
                self.outbox.said("info", sentence)

    def _introduce(self, robot: PageRobot) -> None:
        """Take the shape and the limits of a robot that has changed."""
        if robot.number not in self._robots or not robot.limits[0]:
            return
        self._seats.add(robot.number, robot, *robot.limits)
        self._tell_robots()
        robot.introduced = True

    def _watch(self, now: float) -> None:
        """Stop the robots that persons drive when the server is silent, and replace a server that hangs."""
        server = self.server
        if server is None:
            return
        silent = now - server.heard
        if silent > SILENCE and not self._is_lost:
            self._is_lost = True
            self.halt()
        if silent > PROGRAMS_LOST:
            self.programs.lost(SERVER_SILENT)
        if silent > (HUNG if server.speaks else STARTING):
            server.kill()
            self._drop_server()

    def _show(self, now: float) -> None:
        for robot in self._robots.values():
            robot.repeat(now)
            status = robot.status(now)
            if status is not None:
                self.outbox.text("status", status, robot.number)
        self._show_helms(now)

    def _show_helms(self, now: float) -> None:
        for number in self._seats.robots:
            told = self._seats.told(number, now)
            if told != self._helms.get(number):
                self._helms[number] = told
                self.outbox.text("helm", told.value, number, told.seat)

    def _tell_robots(self) -> None:
        entries = [robot.entry for robot in self._robots.values()]
        if entries != self._entries:
            self._entries = entries
            for to, told in self.rules.entries(entries).items():
                self.outbox.text("robots", told, to=to)

    def _send(self) -> None:
        waits = self.outbox.flush()
        if self.server is not None:
            self._selector.modify(self.server.end, selectors.EVENT_READ | (selectors.EVENT_WRITE if waits else 0))

    # The server

    def _start_server(self) -> None:
        server = self.server = self._make_server()
        self._selector.register(server.end, selectors.EVENT_READ)
        self.rules.emptied()
        self.outbox.connect(server.end, self._first)
        for robot in self._robots.values():
            self.outbox.text("trail", robot.trail.points, robot.number)

    def _drop_server(self) -> None:
        """The server is gone: stop the robots at once, then reap it, and see when to start another one."""
        server, self.server = self.server, None
        now = monotonic()
        self._is_lost = True
        self._lose(now)
        if server is None:
            return
        self.outbox.disconnect()
        self._selector.unregister(server.end)
        server.kill()
        server.close()
        self._restart.died(server.started, now)

    def _lose(self, now: float) -> None:
        """Stop all that persons and programs drive: nobody hears them any more."""
        self._seats.lost(now)
        self.programs.lost(SERVER_SILENT)

    def _close(self) -> None:
        self._lose(monotonic())
        for robot in self._robots.values():
            robot.close(wait=False)     # all stop first
        for robot in self._robots.values():
            robot.close()
        if self.server is not None:
            self.outbox.disconnect()
            self._selector.unregister(self.server.end)
            self.server.close()
            self.server = None
        self._selector.close()
        self._waker.close()

    def vacate(self, robot: int) -> None:
        """Stop a robot, and free its seat: the person who had it may drive it no more."""
        self._seats.vacate(robot, monotonic())

    def halt(self, robot: Optional[int] = None) -> None:
        """Stop what persons and programs drive, of a robot or of all (None). It moves again when they command anew: a
        person must let go first.
        """
        self._seats.lost(monotonic(), robot)
        self.programs.halt(robot)

    # Other threads

    def changed(self, robot: PageRobot) -> None:
        """Take note that a robot has changed. See Stage.changed()."""
        self._changed.append(robot)
        self.wake()

    def tell(self, robot: PageRobot, level: str, text: str, viewers: Optional[Sequence[int]] = None) -> None:
        """Tell the page what happened to a robot. See Stage.tell()."""
        to = self.rules.viewers(robot.number) if viewers is None else viewers
        self.outbox.said(level, text, robot.number, to)
        if level != "info" and viewers is None and to != []:
            self._say(text)

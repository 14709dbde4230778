"""The socket at which other programs get the true state of the simulated world, and give orders.

It is a Unix domain socket, which only the user of the simulator can open. docs/simulator.md has its protocol. A thread
of its own serves all programs. It holds `Server.lock` only for the moment in which it copies the state or obeys an
order, so the robots do not wait for it.
"""

import contextlib
import os
import selectors
import socket
import stat
import threading
import time
from typing import Dict, Optional, Tuple

from ...errors import PortError
from ..line import Server
from ..simulation import Simulation
from ..tasks import Referee
from .orders import TOO_LONG, Orders
from .state import Message, line_of, truth_of, world_of
from .visit import LONGEST_LINE, Visit

PERIOD = 0.1
"""Least real time (s) between two states that a program gets, and duration of a turn for its orders."""
MOST_VISITS = 50
"""Largest number of programs that are connected at the same time."""
UNREAD_LIMIT = 16 * 1024
"""Number of bytes that the system may buffer for a program that does not read, so that it soon gets new states only."""


class TruthService:
    """Serves programs that connect to a Unix domain socket.

    Args:
        server: the server of the robots, before it runs.
        simulation: the robots of the server.
        path: path of the socket. A socket that a dead process has left there is replaced.
        referee: carries robots, and runs the tasks. If None, there are no tasks.

    Raises:
        PortError: the socket cannot be made. The message says what to do.
    """

    def __init__(self, server: Server, simulation: Simulation, path: str, referee: Optional[Referee] = None):
        self._server, self._simulation = server, simulation
        self._referee = referee or Referee(simulation)
        self._orders = Orders(simulation, server.simulation, server.pace, self._referee)
        self._urls = [berth.url for berth in server.berths]
        self._ground, self._greeting = self._referee.ground, self._world_line()
        self._state: Message = {}
        self._news = b""
        self._watched_by_others = server.watched
        self._visits: Dict[socket.socket, Visit] = {}
        self._path = path
        self._listener, self._inode = listen(path)
        self._wakers = socket.socketpair()      # a byte into the first one ends the thread's wait at the second one
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self._wakers[1], selectors.EVENT_READ)
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="truth", daemon=True)

    def start(self) -> "TruthService":
        """Start the thread that serves the programs, and return this service."""
        self._thread.start()
        return self

    def stop(self, timeout: float = 2.0) -> None:
        """Disconnect all programs, and remove the socket. Wait at most `timeout` seconds for the end of the thread."""
        if self._listener.fileno() < 0:
            return
        self._stopping.set()
        if self._thread.is_alive():
            self._wakers[0].send(b"!")
            self._thread.join(timeout)
        with contextlib.suppress(OSError):
            if os.lstat(self._path).st_ino == self._inode:      # not the socket of another process
                os.unlink(self._path)
        for file in (*self._visits, self._listener, *self._wakers):
            file.close()
        self._selector.close()

    def __enter__(self) -> "TruthService":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    # -- its thread

    def _run(self) -> None:
        due = time.monotonic()
        while not self._stopping.is_set():
            ready = self._selector.select(max(0.0, due - time.monotonic()) if self._visits else None)
            for key, _ in ready:
                if key.fileobj is self._listener:
                    self._welcome()
                elif key.data in self._visits:
                    self._listen(key.data)
                    self._talk(key.data)
            if self._visits and time.monotonic() >= due:
                due = time.monotonic() + PERIOD
                self._tell()

    def _welcome(self) -> None:
        """Accept a program, or turn it away if there are too many."""
        try:
            client, _ = self._listener.accept()
        except OSError:     # it has disconnected
            return
        client.setblocking(False)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD_LIMIT)
        if len(self._visits) >= MOST_VISITS:
            client.close()
            return
        self._visits[client] = Visit(self._greeting)
        self._selector.register(client, selectors.EVENT_READ, client)
        self._talk(client)

    def _tell(self) -> None:
        """Begin a turn: tell all programs the state if it has changed, and take their orders that wait."""
        with self._server.lock:
            self._server.watched = True
            state = truth_of(self._simulation, self._server.simulation, self._server.pace, self._referee)
        if state != self._state:
            self._state, self._news = state, line_of(state)
        for client, visit in list(self._visits.items()):
            visit.begin_turn()
            visit.tell(self._news)
            self._talk(client)

    def _listen(self, client: socket.socket) -> None:
        """Receive bytes of a program, if it has sent any and may do so. If it has disconnected, forget it."""
        visit = self._visits[client]
        if not visit.may_send:
            return
        try:
            data = client.recv(LONGEST_LINE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            visit.receive(data)
        else:
            self._dismiss(client)

    def _talk(self, client: socket.socket) -> None:
        """Obey the orders of a program whose turn it is, send what it can take, and wait for what comes next."""
        visit = self._visits.get(client)
        if visit is None:
            return
        while visit.has_order:
            visit.answer(self._answer(visit.take_order()))
        try:
            while visit.unsent:
                visit.sent(client.send(visit.unsent))
        except BlockingIOError:
            pass
        except OSError:
            self._dismiss(client)
            return
        # Neither of both is legal, too: then only the end of the connection is reported.
        wanted = selectors.EVENT_READ * visit.may_send | selectors.EVENT_WRITE * bool(visit.unsent)
        self._selector.modify(client, wanted, client)

    def _answer(self, line: Optional[bytes]) -> bytes:
        """Obey an order, and return the line that answers it. The robots wait only while it is carried out."""
        request = TOO_LONG if line is None else self._orders.read(line)
        with self._server.lock:
            answer = self._orders.answer(request)
        if answer["ok"]:
            self._server.wake()
        if self._referee.ground is not self._ground:
            self._ground, self._greeting = self._referee.ground, self._world_line()
            for visit in self._visits.values():
                visit.greet(self._greeting)
        return line_of(answer)

    def _world_line(self) -> bytes:
        return line_of(world_of(self._simulation, self._urls, self._referee))

    def _dismiss(self, client: socket.socket) -> None:
        """Forget a program that has disconnected."""
        self._selector.unregister(client)
        del self._visits[client]
        client.close()
        if not self._visits:
            with self._server.lock:
                self._server.watched = self._watched_by_others


def listen(path: str) -> Tuple[socket.socket, int]:
    """Return a Unix domain socket that listens at `path`, and the number of its file (inode).

    Only the user of this process can connect. A socket that a dead process has left there is replaced.

    Raises:
        PortError: the socket cannot be made. The message says what to do.
    """
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.setblocking(False)
    try:
        _remove_dead(path)
        listener.bind(path)
        os.chmod(path, stat.S_IRUSR | stat.S_IWUSR)     # before `listen`: until then nobody can connect
        listener.listen()
        return listener, os.lstat(path).st_ino
    except PortError:
        listener.close()
        raise
    except OSError as error:
        listener.close()
        why = error.strerror or error
        raise PortError("cannot make the socket %s: %s; choose another path" % (path, why)) from error


def _remove_dead(path: str) -> None:
    """Remove the socket at `path` if no process listens there.

    Raises:
        PortError: a process listens there, or the file is no socket.
        OSError: the file cannot be removed.
    """
    if not os.path.lexists(path):
        return
    if not stat.S_ISSOCK(os.lstat(path).st_mode):
        raise PortError("%s exists and is no socket: remove it or choose another path" % path)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.setblocking(False)
        try:
            probe.connect(path)
        except ConnectionRefusedError:
            os.unlink(path)
            return
        except BlockingIOError:     # so many wait there
            pass
    raise PortError("%s is the socket of another simulator: stop that one, or choose another path" % path)

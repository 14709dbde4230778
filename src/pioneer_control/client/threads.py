"""Two threads that keep the link to one robot, and call the listeners.

One of the threads has the port: it opens the port, reads, watches the clock, and sends what is due. When there are
events for the listeners, it releases the port, calls the listeners, and takes the port again. So no event has to wait
until another thread has woken up. The other thread tries every TURN seconds to take the port. This succeeds only while
listeners are called, and so most likely when a listener takes long. Then the two threads change places. So a listener
can delay the line for TURN seconds at most, whatever it does. Listeners are called one at a time, and in order.
"""

import threading
from dataclasses import replace
from time import monotonic
from typing import Any, Callable, Dict, List, Optional, Tuple

from ..errors import LinkError, LinkLostError, PioneerError
from .events import Event, LinkDown, PacketReceived, Ready, StatesMissed
from .handshake import RATES
from .identity import RobotIdentity
from .line import SetBaud
from .link import HostBaud
from .phases import Connected
from .ports import open_transport
from .session import Counts, Session
from .settings import Settings
from .state import RobotState
from .tcp import is_lockstep
from .transport import Transport, tap

BACK_OFF = 0.2                      # s before the next attempt to connect
CLOSE_TIMEOUT = 0.9                 # s that close() waits for the threads
# Events that may wait for the listeners. When there are more, the oldest states and packets are dropped.
MOST_WAITING = 100
# s between two tries to take the port. Each try takes about 0.07 ms. With 0.05 s here, the tries would take a tenth of
# all the time that the driver takes at ten SIPs a second.
TURN = 0.2


class Audience:
    """The listeners, and the events that wait for them. Any thread may call its methods."""

    def __init__(self) -> None:
        self.missed = 0
        """Number of states and packets that were dropped since the start, because the listeners were too slow."""
        self._listeners: Dict[bool, List[Callable[[Any], None]]] = {True: [], False: []}    # to states, to other events
        self._waiting: List[Event] = []
        self._missed_untold = 0
        self._telling = False
        self._lock = threading.Lock()

    def listen(self, on_state: Optional[Callable[[RobotState], None]],
               on_event: Optional[Callable[[Any], None]]) -> None:
        """Add a listener for states and a listener for other events. Listeners are called in the order of adding."""
        for is_state, listener in ((True, on_state), (False, on_event)):
            if listener is not None:
                self._listeners[is_state].append(listener)

    def put(self, events: List[Event]) -> None:
        """Add events (at least one) to those that wait for the listeners, and return at once.

        Of several LinkDown in a row only the newest waits. When too many events wait, the oldest states and packets are
        dropped.
        """
        with self._lock:
            if self._waiting and isinstance(self._waiting[-1], LinkDown) and isinstance(events[0], LinkDown):
                self._waiting.pop()
            self._waiting += events
            excess = len(self._waiting) - MOST_WAITING
            if excess > 0:
                stream = [event for event in self._waiting if isinstance(event, (RobotState, PacketReceived))][:excess]
                dropped = set(map(id, stream))
                self._waiting = [event for event in self._waiting if id(event) not in dropped]
                self.missed += len(stream)
                self._missed_untold += len(stream)

    def tell(self) -> None:
        """Call the listeners with all events that wait.

        If another thread does this already, return at once: the other thread takes these events, too. After a listener
        has raised an exception, no listener is called any more.
        """
        while True:
            with self._lock:
                if self._telling or not self._waiting:
                    return
                self._telling = True
                events, self._waiting = self._waiting, []
                if self._missed_untold:
                    events.insert(0, StatesMissed(self._missed_untold))
                    self._missed_untold = 0
            for event in events:
                for listener in self._listeners[isinstance(event, RobotState)]:
                    listener(event)
            with self._lock:
                self._telling = False


class Ending:
    """Whether something has ended. It is used as a threading.Event, but wait() takes half the processor time.

    Only one thread at a time may call set().
    """

    def __init__(self) -> None:
        self._goes_on = threading.Lock()    # held until set()
        self._goes_on.acquire()
        self._is_set = False

    def is_set(self) -> bool:
        """Return whether set() was called."""
        return self._is_set

    def set(self) -> None:
        """Say that it has ended, and wake all threads that wait. A second call has no effect."""
        if not self._is_set:
            self._is_set = True
            self._goes_on.release()

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Wait for set(), at most ``timeout`` s; None waits for ever. Returns whether set() was called."""
        if self._goes_on.acquire(timeout=-1 if timeout is None else max(0.0, timeout)):
            self._goes_on.release()     # for the other threads
        return self._is_set     # another thread may have held the lock for a moment


def opener(url: str, key: Optional[str],
           on_wire: Optional[Callable[[bool, bytes], None]]) -> Callable[[int], Transport]:
    """Return a function that opens the port at a line speed (baud). Nothing else knows the key.

    For ``key`` and ``on_wire`` see Robot.
    """
    def open_port(baud: int) -> Transport:
        transport = open_transport(url, baud, key)
        if on_wire is not None:
            tap(transport, on_wire)
        return transport

    return open_port


class Connection:
    """An open port and the session on it. The caller of any method must hold the lock of the link."""

    def __init__(self, transport: Transport, session: Session) -> None:
        self.transport = transport
        self.session = session
        self.is_open = True
        self.read_until = 0.0
        """Time (s, of the session) until which the reading thread waits for bytes; 0 while no thread reads."""

    def send(self) -> None:
        """Carry out the actions of the session: write bytes, change the line speed.

        If the line is broken, this ends the session with the error, and raises nothing.
        """
        if not self.is_open:    # the file descriptor may belong to another file by now
            return
        try:
            for action in self.session.data_to_send():
                if isinstance(action, SetBaud):
                    self.transport.set_baud(action.baud)
                else:
                    self.transport.write(action)
        except LinkLostError as error:
            self.session.fail(error)
        if self.read_until and (self.session.finished or self.session.wake_at < self.read_until):
            self.read_until = 0.0
            self.transport.wake()

    def give_up(self, error: LinkError) -> None:
        """End the session at once with this error, unless it is finished already."""
        if not self.session.finished:
            self.session.fail(error)
            self.send()


class LinkThreads:
    """The two threads of a link, and the data that they share with the program.

    For each command the program enters the link as a context: ``with link as robot: robot.drive.stop(now)``. The
    context has the lock, gives the connected robot, and writes the command at its end.

    Args:
        url: the port, without its key.
        baud, key, reconnect, on_wire: see Robot.
        settings: the user's settings, until change() is called.
        audience: the listeners.

    Attributes:
        changed: the condition to hold while using the other attributes. It is notified of every change.
        connection: the newest connection; None before the first one.
        identity: the newest identity of the robot; None before the first one.
        state: the newest state of the robot; None before the first one.
        error: why the last connection ended or could not begin; None if there is no such error.
        ended: set when no further attempt to connect will be made.
    """

    def __init__(self, url: str, baud: int, key: Optional[str], settings: Settings, audience: Audience,
                 reconnect: bool, on_wire: Optional[Callable[[bool, bytes], None]]) -> None:
        self.url = url
        self.settings = settings
        # reentrant: a signal handler may call close() while its thread holds the lock.
        self._lock = threading.RLock()
        self.changed = threading.Condition(self._lock)
        self.connection: Optional[Connection] = None
        self.identity: Optional[RobotIdentity] = None
        self.state: Optional[RobotState] = None
        self.error: Optional[BaseException] = None
        self.ended = Ending()
        self._baud = baud
        self._open_port = opener(url, key, on_wire)
        self._audience = audience
        self._reconnect = reconnect
        self._port = threading.Lock()       # held by the thread that has the port
        self._closing = False
        self._pause = 0.0       # s before the next attempt to connect
        self._past, self._reconnects = Counts(), -1
        self._host_baud = HostBaud(settings.host_baud)
        self._threads = [threading.Thread(target=self.run, name="pioneer %s %d" % (url, number), daemon=True)
                         for number in (1, 2)]

    # What the program does, on any thread

    def start(self) -> None:
        """Start the threads."""
        for thread in self._threads:
            thread.start()

    def close(self, wait: bool) -> None:
        """Stop the robot at once, and begin to close.

        With ``wait`` return when the port is closed, or after CLOSE_TIMEOUT.
        """
        with self.changed:
            self._closing = True
            if self.connection is not None:
                self.connection.session.close(monotonic())
                self.connection.send()
            self.changed.notify_all()
        if not wait:
            return
        deadline = monotonic() + CLOSE_TIMEOUT
        for thread in self._threads:
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(max(0.0, deadline - monotonic()))
        if self.connection is not None and not self.ended.is_set():
            with self.changed:
                self.connection.give_up(LinkLostError("%s: closed" % self.url))

    def change(self, **settings: Any) -> None:
        """Change these settings. Raises ParameterError for an illegal value. Then no setting is changed."""
        with self.changed:
            self.settings = replace(self.settings, **settings)
            if self.connection is not None:
                self.connection.session.use(self.settings, monotonic())
                self.connection.send()

    def now(self) -> float:
        """Return the present time (s) of the session, which in lockstep has a time of its own."""
        connection = self.connection
        return monotonic() if connection is None else connection.session.time(monotonic())

    def end_turn(self) -> None:
        """In lockstep, tell the robot that the program waits for the next state. The caller holds ``changed``."""
        connection, connected = self.connection, self.connected
        if connection is not None and connected is not None:
            connected.end_turn()
            connection.send()

    @property
    def connected(self) -> Optional[Connected]:
        """The phase Connected of the session while the robot obeys; None in any other phase, and without a session."""
        connection = self.connection
        return None if connection is None else connection.session.connected

    def __enter__(self) -> Connected:
        """Take the lock for one command, and return the connected robot. The end of the context writes the command.

        Without a connected robot it raises the error that says why, mostly a LinkError.
        """
        self._lock.acquire()
        connected = self.connected
        if connected is None:
            self._lock.release()
            raise self.failure(LinkLostError("%s: no link to the robot" % self.url))
        return connected

    def __exit__(self, kind: Optional[type], *_: object) -> None:
        """Write the command to the line, unless an exception has ended the context.

        Raises the error that has broken the line, if there is one.
        """
        try:
            connection = self.connection
            if kind is not None or connection is None:
                return
            connection.send()
            if connection.session.error is not None:    # the line broke just now
                raise connection.session.error
            # A signal handler may have closed the connection meanwhile. Its STOP went out before this command. So STOP,
            # motors off and CLOSE (the last words) go out again, behind this command.
            if self._closing and not connection.session.finished:
                connection.session.line.say(connection.session.phase.last_words)
                connection.send()
        finally:
            self._lock.release()

    def failure(self, otherwise: PioneerError) -> BaseException:
        """Return the error that a failed call raises: why there is no link, if this is known; else ``otherwise``.

        If a listener has raised an exception, this exception becomes the cause of ``otherwise``.
        """
        error = None if self.connected else self.error
        if isinstance(error, PioneerError):
            return type(error)(*error.args)
        if error is not None:
            otherwise.__cause__ = error
        elif self._closing:
            return LinkLostError("%s: closed" % self.url)
        return otherwise

    def counts(self) -> Tuple[Counts, int]:
        """Return the sums of the counters of all sessions, and how often the link came back."""
        with self.changed:
            present = Counts() if self.connection is None else self.connection.session.counts
            counts = Counts(*(past + now for past, now in zip(self._past, present)))
            return counts, max(0, self._reconnects)

    # What the threads do

    def run(self) -> None:
        """Keep the link and call the listeners, until the link has ended. Each of the two threads runs this."""
        try:
            while self._keep_link():
                self._audience.tell()
        except BaseException as error:      # most likely a listener has raised it; threading prints it
            with self.changed:
                self.error, self._closing = error, True
                self._threads = [thread for thread in self._threads if thread is not threading.current_thread()]
                if not self._threads:       # the other thread has failed, too
                    self.ended.set()
                self.changed.notify_all()
                if self.connection is not None:
                    self.connection.give_up(LinkLostError("%s: a listener failed" % self.url))
            raise

    def _keep_link(self) -> bool:
        """Wait for the port, and use it until there are events for the listeners. Returns False after the end."""
        while not self._port.acquire(blocking=False):
            self.ended.wait(TURN)
        try:
            while not self.ended.is_set():
                connection = self.connection
                events = self._connect() if connection is None or not connection.is_open else self._serve(connection)
                if events:
                    self._audience.put(events)
                    return True
        finally:
            self._port.release()
        return False

    def _connect(self) -> List[Event]:
        """Wait for the pause between attempts, open the port, and begin a session. Returns LinkDown if this fails."""
        with self.changed:
            self.changed.wait_for(lambda: self._closing, self._pause)
            if self._closing:
                self.ended.set()
                self.changed.notify_all()
                return []
        try:
            transport = self._open_port(self._baud)
        except PioneerError as error:
            return self._failed(error)
        with self.changed:
            self._past, _ = self.counts()
            odometry = None if self.connection is None else self.connection.session.phase.odometry
            session = Session(self.url, self._rates(transport), self.settings, monotonic(), odometry, self._host_baud,
                              is_lockstep(self.url))
            self.connection = Connection(transport, session)
        return []

    def _rates(self, transport: Transport) -> Tuple[int, ...]:
        """Return the line speeds (baud) to try, in this order; none if the line has no speed."""
        if transport.baud is None:
            return ()
        # a program that crashed may have left the robot at this speed.
        raised = () if self._host_baud.wanted is None else (self._host_baud.wanted,)
        return tuple(dict.fromkeys((transport.baud, *raised, *RATES)))

    def _serve(self, connection: Connection) -> List[Event]:
        """Wait until bytes arrive or something is due, and let the session handle it. Returns events for the listeners.
        """
        session = connection.session
        with self._lock:
            self.changed.notify_all()       # of the newest state; listeners got it first, without this delay
            due = connection.read_until = session.wake_at
        data, lost = b"", None
        try:
            data = connection.transport.read(0.0 if session.finished else due - session.time(monotonic()))
        except LinkLostError as error:
            lost = error
        with self._lock:
            connection.read_until = 0.0
            now = monotonic()
            if data:
                session.receive(data, now)
            if lost is not None:
                session.fail(lost)
            if self._closing:
                session.close(now)
            if session.time(now) >= due:    # what is due since then is done in the next round, which does not wait
                session.tick(now)
            connection.send()
            events = session.events()
            connection.is_open = not session.finished
            self._notice(connection, events)
        if not connection.is_open:
            connection.transport.close()
            if session.error is not None and not self._closing:
                events += self._failed(session.error)
        return events

    def _notice(self, connection: Connection, events: List[Event]) -> None:
        """Keep the newest state and identity for the program, and notify calls that wait for an event or the end."""
        for event in events:
            if isinstance(event, RobotState):
                self.state = event
                continue
            self._reconnects += isinstance(event, Ready)
            connected = connection.session.connected
            if connected is not None:
                self.identity, self._baud = connected.identity, connected.own_baud or self._baud
            self.changed.notify_all()
        if not connection.is_open:
            self.changed.notify_all()

    def _failed(self, error: PioneerError) -> List[Event]:
        """Keep the error that ended the link, and decide about another attempt. Returns the event LinkDown."""
        self.error, self._pause = error, BACK_OFF
        final = not self._reconnect or not isinstance(error, LinkError)
        if final:
            self._closing, self._pause = True, 0.0
        return [LinkDown(error, -1.0 if final else BACK_OFF)]

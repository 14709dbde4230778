"""The Robot class: a robot on a port, driven from plain Python. See the folder's docstring for the few lines that do it."""

import atexit
import contextlib
import sys
import threading
from dataclasses import replace
from time import monotonic
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from ..errors import LinkError, LinkLostError, NoAnswerError, PioneerError, RefusedError, UsageError
from ..p2os import GripperCommand, encode_command
from .data import DATA
from .events import Event, LineSpeed, LinkDown, Ready
from .gripper import gripper_packets
from .handshake import RATES
from .identity import RobotIdentity
from .session import Counts, Phase, Session, SetBaud, Told
from .settings import Settings
from .state import Motion, RobotState
from .transport import Transport, open_transport, tap
from .tuning import Tuning

BACK_OFF = 0.2                      # s before the next attempt to connect
CLOSE_TIMEOUT = 0.9                 # s that close() waits for the I/O thread
HOST_BAUD_BREAKS = 2                # times in a row that the link may break while its speed changes: once may be chance
HELD_UP = 0.1                       # s by which the guard may be later than an I/O thread that is not held up


class LinkCounts(NamedTuple):
    """How well the line works, counted since start()."""

    sips: int
    bad_checksums: int
    discarded_bytes: int
    unreadable: int
    """whole packets that nobody understands, or can believe: the robot would be where it cannot be"""
    unknown_sonar: int
    """readings of transducers that the model does not have"""
    questions: int
    """asked while velocities were sent (link_check), and answered or overdue; 0 of a robot that has answered none"""
    unanswered: int
    """of these, overdue: the question was lost on its way, or the answer on its way back"""
    reconnects: int
    last_error: Optional[str]


class Robot:
    """A Pioneer on a serial port, a pty or TCP.

    Args:
        url: ``/dev/ttyUSB0``, a pty's path, ``socket://host:port`` (``tcp://host:port`` and ``host:port`` are the same).
        baud: line speed of a serial port; the others are tried when nothing answers.
        model: use this model whatever the robot announces. Without it an unknown subtype is an error.
        models_file: a file of the user's that overrides values of the table of models.
        pulse: s between signs of life (PULSE; a stop while the robot shall stand) when nothing else is sent; 0 sends none, and then the robot's
            own watchdog stops it after 2 s.
        use_sonar: sonar on after connecting.
        command_timeout: s after which a velocity that nobody renewed means stop.
        max_linear, max_angular: limits in m/s, rad/s below the robot's own; None for just the robot's.
        has_gripper: None believes the robot (CONFIGpac).
        tuning: settings of the robot itself, sent after every connecting when it stands; see tune().
        on_motion: called with every Motion, otherwise as on_state, which follows: for what shall leave as soon as it can. It does not wait for the
            rest of its SIP to be read, unless an earlier SIP came in the same piece.
        on_state: called with every RobotState, on the I/O thread, no lock held. Be quick: nothing is read meanwhile; after 2 s of that the link
            counts as lost and the robot is stopped. A listener that raises ends the connection: the robot is stopped and closed, and the next
            command raises.
        on_event: called with every Event (client.events), likewise.
        on_wire: called with every piece of bytes: whether it goes to the robot, and they. In the order in which they go over the line, on the thread that
            writes or reads, which holds the lock while it writes: only put them aside.
        host_baud: line speed to change to once the robot is open, if it is a serial line and the robot can; else the one at which it was found
            stays. None for that one.
        link_check: while velocities are sent, ask the robot for its encoders a few times a second, only to count the answers: what gets lost on
            its way to the robot hardly shows otherwise. A program that requests "encoder" gets them all, and none are counted.
        reconnect: keep trying to get the link, for ever; else the first failure is final.
    """

    def __init__(
        self,
        url: str,
        *,
        baud: int = 9600,
        model: Optional[str] = None,
        models_file: Optional[str] = None,
        pulse: float = 1.0,
        use_sonar: bool = True,
        command_timeout: float = 0.6,
        max_linear: Optional[float] = None,
        max_angular: Optional[float] = None,
        has_gripper: Optional[bool] = None,
        tuning: Tuning = Tuning(),
        host_baud: Optional[int] = None,
        link_check: bool = True,
        reconnect: bool = False,
        on_motion: Optional[Callable[[Motion], None]] = None,
        on_state: Optional[Callable[[RobotState], None]] = None,
        on_event: Optional[Callable[[Event], None]] = None,
        on_wire: Optional[Callable[[bool, bytes], None]] = None,
    ) -> None:
        self.url = url
        self._baud = baud
        self._settings = Settings(
            model, models_file, pulse, use_sonar, command_timeout, max_linear, max_angular, has_gripper, tuning, host_baud, link_check)
        self._reconnect = reconnect
        self._tell_motion = on_motion or (lambda motion: None)
        self._tell_state = on_state or (lambda state: None)
        self._tell_event = on_event or (lambda event: None)
        self._on_wire = on_wire
        # Guards all below, and the order of writes. Reentrant, for a signal handler may call close() while its thread holds it. Released
        # before listeners run.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._alert = threading.Condition(self._lock)       # the guard is to look at once, not only when it meant to
        self._thread = threading.Thread(target=self._run, name="pioneer %s" % url, daemon=True)
        self._guard = threading.Thread(target=self._watch_over_listeners, name="pioneer %s guard" % url, daemon=True)
        self._telling = False           # a listener has the I/O thread
        self._closing = False
        self._transport: Optional[Transport] = None
        self._session: Optional[Session] = None
        self._identity: Optional[RobotIdentity] = None
        self._state: Optional[RobotState] = None
        self._states = 0
        self._wanted_data: Dict[str, bool] = {}
        self._reconnects = -1
        self._host_baud_breaks = 0
        self._past = Counts()
        self._error: Optional[BaseException] = None
        self._ended = threading.Event()     # the I/O thread will not do anything more
        self._reading_until = 0.0           # 0: the I/O thread does not wait

    def start(self) -> "Robot":
        """Start the I/O thread and return at once. Never enables the motors."""
        atexit.register(self.close)
        self._thread.start()
        self._guard.start()
        return self

    def close(self, wait: bool = True) -> None:
        """Stop the robot, motors off, CLOSE, port closed; within about a second, whatever the robot does. Can be called twice.

        Without ``wait`` only the stop is written when this returns; the rest follows: see wait_until_ended().
        """
        with self._lock:
            self._closing = True
            if self._session is not None:
                self._session.close(monotonic())
                self._try_act()
            self._wake()
            self._alert.notify()
            self._changed.notify_all()
        if not wait:
            return
        atexit.unregister(self.close)
        if self._thread is threading.current_thread() or not self._thread.is_alive():
            return
        self._thread.join(CLOSE_TIMEOUT)
        if self._thread.is_alive():     # a listener holds it up: the robot must not wait for that
            with self._lock:
                self._give_up(LinkLostError("%s: closed" % self.url))

    def __enter__(self) -> "Robot":
        """start() and wait_until_ready()."""
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(self.close)
            self.start()
            self.wait_until_ready()
            on_failure.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def wait_until_ready(self, timeout: float = 10.0) -> RobotIdentity:
        """Block until the robot has said what it is and its first state is there.

        Raises PortError, NoAnswerError or UnknownModelError with what to do.
        """
        with self._lock:
            self._changed.wait_for(lambda: self.ready or self._ended.is_set(), timeout)
            if self.ready:
                assert self._identity is not None
                return self._identity
            raise self._failure(NoAnswerError("%s: not ready within %.1f s" % (self.url, timeout)))

    def wait_for_state(self, timeout: float = 1.0) -> RobotState:
        """The next state that arrives. Raises LinkLostError when none comes within ``timeout`` s."""
        with self._lock:
            before = self._states
            self._changed.wait_for(lambda: self._states != before or self._ended.is_set(), timeout)
            if self._states == before:
                raise self._failure(LinkLostError("%s: no state within %.1f s" % (self.url, timeout)))
            assert self._state is not None
            return self._state

    def wait_until_ended(self, timeout: Optional[float] = None) -> bool:
        """Block until nothing more will be tried: closed, a failure that is final, or a listener that raised. Whether that came in time (s)."""
        return self._ended.wait(timeout)

    @property
    def ready(self) -> bool:
        """Whether commands reach the robot now."""
        session = self._session
        return session is not None and session.phase is Phase.READY

    @property
    def identity(self) -> Optional[RobotIdentity]:
        """What the robot is; None until it was ready for the first time."""
        return self._identity

    @property
    def state(self) -> Optional[RobotState]:
        """The newest state; None before the first."""
        return self._state

    @property
    def tuning(self) -> Tuning:
        """The settings that the robot is to have; ``tune(dataclasses.replace(robot.tuning, ...))`` changes some of them."""
        return self._settings.tuning

    @property
    def use_sonar(self) -> bool:
        """Whether the sonar is to be on after the next connecting."""
        return self._settings.use_sonar

    @use_sonar.setter
    def use_sonar(self, on: bool) -> None:
        with self._lock:
            self._settings = replace(self._settings, use_sonar=bool(on))

    @property
    def link(self) -> LinkCounts:
        """How well the line works."""
        with self._lock:
            counts = self._total()
            error = None if self._error is None else str(self._error)
            return LinkCounts(*counts, reconnects=max(0, self._reconnects), last_error=error)

    # Commands. Each is written before it returns if the line is idle.

    def set_velocity(self, linear: float, angular: float) -> None:
        """Drive at ``linear`` m/s (forward positive) and ``angular`` rad/s (counter-clockwise positive) until command_timeout.

        Clamped to the identity's limits. On an idle line the command is written before this returns.
        Raises UsageError on NaN and infinity (and sends nothing), LinkError (what stands in the way) without a link.
        """
        with self._lock:
            session = self._ready_session()
            session.drive.set_velocity(linear, angular, monotonic())
            self._act()

    def set_wheel_velocities(self, left: float, right: float) -> None:
        """Drive the left and the right wheels at these speeds (m/s, forward positive) until command_timeout; in steps of 20 mm/s, fair on average.

        Where a wheel or the robot as a whole would go beyond a limit, both are made smaller alike: the curve stays. Otherwise as set_velocity().
        """
        with self._lock:
            session = self._ready_session()
            session.drive.set_wheel_velocities(left, right, monotonic())
            self._act()

    def set_limits(self, max_linear: Optional[float], max_angular: Optional[float], command_timeout: float) -> None:
        """These three as the constructor takes them, from now on; a robot that drives faster is slowed down within 0.2 s.

        The identity with the new limits comes as the event Tuned. Raises ParameterError, and then all stays as it was.
        """
        with self._lock:
            self._settings = replace(self._settings, max_linear=max_linear, max_angular=max_angular, command_timeout=command_timeout)
            if self._session is not None:
                self._session.limit(self._settings)
                self._try_act()
            self._alert.notify()

    def tune(self, tuning: Tuning) -> None:
        """Settings of the robot itself from now on, instead of those of before: what differs is sent at once, and all of it after every connecting.

        What ``tuning`` leaves open and an earlier one did not goes back to what the robot had. Without a link all is kept for the next one.
        What the robot made of it comes as the event Tuned; it forgets it at the end of the session.
        """
        with self._lock:
            self._settings = replace(self._settings, tuning=tuning)
            if self._session is not None:
                self._session.tune(tuning, monotonic())
                self._try_act()

    def stop(self) -> None:
        """Stop, ahead of all that waits; repeated until the robot reports that it stands. No error without a link: a link begins with a stop."""
        with self._lock:
            if self.ready:
                self._session.drive.stop(monotonic())
                self._try_act()

    def enable_motors(self, timeout: float = 2.0) -> None:
        """Motors on; returns when the robot reports it.

        Raises RefusedError with the reason (STOP button), NotConfirmedError after ``timeout`` s, LinkError without a link.
        """
        self._switch_motors(True, timeout)

    def disable_motors(self, timeout: float = 2.0) -> None:
        """Stop, motors off; as enable_motors()."""
        self._switch_motors(False, timeout)

    def request_motors(self, on: bool, timeout: float = 2.0) -> Callable[[], None]:
        """Ask for the motors and return at once. Returns a function that waits for the answer, and raises as enable_motors() does."""
        with self._lock:
            request = self._ready_session().drive.request_motors(on, monotonic(), timeout)
            self._act()

        def wait() -> None:
            with self._lock:
                self._changed.wait_for(lambda: request.done)
            if request.error is not None:
                raise request.error

        return wait

    def set_sonar(self, on: bool) -> None:
        """Sonar on or off, after a reconnect too."""
        with self._lock:
            self._command(encode_command("SONAR", int(bool(on))))
            self.use_sonar = on

    def gripper(self, command: GripperCommand, value: Optional[int] = None) -> None:
        """One sub-command of the gripper; ``value`` for PRESSURE (1..100) and CARRY (-255..255), in units of 20 ms.

        Raises UsageError for a number that means nothing, RefusedError when no gripper is fitted.
        """
        packets = gripper_packets(command, value)
        with self._lock:
            if not self._ready_session().identity.has_gripper:
                raise RefusedError("%s: the robot reports no gripper" % self.url)
            self._command(*packets)

    def set_digital_out(self, mask: int, states: int) -> None:
        """Set the digital outputs whose bits are 1 in ``mask`` (0..255) to their bits in ``states``."""
        self._command(encode_command("DIGOUT", mask, states))

    def request_data(self, kind: str, on: bool = True) -> None:
        """Packets of this kind with every SIP, as PacketReceived events, or no more of them; asked for again after a reconnect.

        ``kind`` is one of data.DATA: "io", "gyro", "encoder", "battery", ... What the robot does not have never comes. Without a link it is
        asked for as soon as there is one. Raises UsageError for another kind.
        """
        if kind not in DATA:
            raise UsageError("there are no packets called %r; legal: %s" % (kind, ", ".join(DATA)))
        with self._lock:
            self._wanted_data[kind] = bool(on)
            if self.ready:
                self._session.data.request(kind, bool(on), monotonic())
                self._try_act()

    def reset_odometry(self) -> None:
        """The robot stands at (0, 0, 0) from the next state on."""
        with self._lock:
            self._ready_session().odometry.reset()

    def _switch_motors(self, on: bool, timeout: float) -> None:
        if self._thread is threading.current_thread():
            raise UsageError("motors cannot be switched from a listener: it runs on the thread that would hear the answer")
        self.request_motors(on, timeout)()

    def _command(self, *packets: bytes) -> None:
        with self._lock:
            self._ready_session().command(monotonic(), *packets)
            self._act()

    def _ready_session(self) -> Session:
        if not self.ready:
            raise self._failure(LinkLostError("%s: no link to the robot" % self.url))
        return self._session

    def _failure(self, otherwise: PioneerError) -> BaseException:
        """The error that stands in the way, as one that can be raised here."""
        error = None if self.ready else self._error
        if isinstance(error, PioneerError):
            return type(error)(*error.args)
        if error is not None:
            otherwise.__cause__ = error
        return otherwise

    # The line; the lock is held.

    def _act(self) -> None:
        """Carry out what the session wants done. Raises LinkLostError, and then the session is over."""
        if self._transport is None:
            return
        try:
            for action in self._session.take_actions():
                if isinstance(action, SetBaud):
                    self._transport.set_baud(action.baud)
                else:
                    self._transport.write(action)
        except LinkLostError as error:
            self._session.fail(error)
            raise
        finally:
            self._wake()

    def _try_act(self) -> None:
        """As _act(), where a dead line is no news for the caller."""
        try:
            self._act()
        except LinkLostError:
            pass

    def _wake(self) -> None:
        """Let the I/O thread look again when it would wait too long."""
        if self._reading_until and (self._session.phase is Phase.FINISHED or self._session.wake_at < self._reading_until):
            self._reading_until = 0.0
            self._transport.wake()

    def _give_up(self, error: LinkError) -> None:
        """End a session that is not finished without any further waiting."""
        if self._transport is not None and self._session.phase is not Phase.FINISHED:
            self._session.fail(error)
            self._try_act()

    def _total(self) -> Counts:
        session = self._session.counts if self._session is not None else Counts()
        return Counts(*(past + present for past, present in zip(self._past, session)))

    # The I/O thread

    def _run(self) -> None:
        try:
            while not self._closing:
                self._connect()
                error = self._error
                if self._closing or error is None:
                    break
                final = not self._reconnect or not isinstance(error, LinkError)
                self._tell([LinkDown(error, -1.0 if final else BACK_OFF)])
                if final:
                    break
                with self._lock:
                    self._changed.wait_for(lambda: self._closing, BACK_OFF)
        finally:
            if sys.exc_info()[1] is not None:
                self._error = sys.exc_info()[1]
            self._ended.set()
            with self._lock:
                self._alert.notify()
                self._changed.notify_all()

    def _connect(self) -> None:
        """One connection, from open to close; why it ended is in ``_error``."""
        try:
            transport = open_transport(self.url, self._baud)
        except PioneerError as error:
            self._error = error
            return
        if self._on_wire is not None:
            tap(transport, self._on_wire)
        rates: Tuple[int, ...] = ()
        if transport.baud is not None:
            first = (transport.baud,) + ((self._settings.host_baud,) if self._settings.host_baud else ())   # a crash may have left it at that
            rates = tuple(dict.fromkeys(first + RATES))
        previous = self._session.odometry if self._session is not None else None
        with self._lock:
            session = Session(self.url, rates, self._settings, previous, self._wanted_data)
            self._past = self._total()
            self._transport, self._session = transport, session
        try:
            self._serve(transport, session)
        finally:
            with self._lock:
                self._give_up(LinkLostError("%s: a listener failed" % self.url))
                self._transport, self._telling = None, False
                said = self._judge_host_baud(session)
            transport.close()
        self._tell(said)
        self._error = session.error or self._error

    def _judge_host_baud(self, session: Session) -> List[Event]:
        """Whether the next session may change its speed too; what there is to say if not."""
        self._host_baud_breaks = self._host_baud_breaks + session.host_baud.under_way if session.identity is None else 0
        wanted, broken = self._settings.host_baud, self._host_baud_breaks == HOST_BAUD_BREAKS
        if broken or session.host_baud.failed:
            self._settings = replace(self._settings, host_baud=None)
        problem = "the link broke %d times when its line was to change to %s baud; not tried again"
        return [LineSpeed(session.own_baud, problem % (HOST_BAUD_BREAKS, wanted))] if broken else []

    def _serve(self, transport: Transport, session: Session) -> None:
        """Read, tell, tick, act and tell, until the session is finished."""
        with self._lock:
            session.start(monotonic())
        while True:
            with self._lock:
                self._telling = False
                if session.phase is Phase.FINISHED:
                    return
                due = self._reading_until = session.wake_at
            data, lost = b"", None
            try:
                data = transport.read(due - monotonic())
            except LinkLostError as error:
                lost = error
            with self._lock:
                self._reading_until = 0.0
                motion = session.hear(data, monotonic()) if data else None
                self._telling = motion is not None
            if motion is not None:
                self._tell_motion(motion)
            with self._lock:
                now = monotonic()
                session.read_on()
                if lost is not None:
                    session.fail(lost)
                if self._closing:
                    session.close(now)
                if now >= due:      # what became due since then has its turn in the next round, which waits for nothing
                    session.tick(now)
                self._try_act()
                events = session.take_events()
                self._notice(session, events)
                self._telling = bool(events)
            self._tell(events)

    def _watch_over_listeners(self) -> None:
        """The guard thread: keeps time for the session, the dead man's above all, while a listener holds up the I/O thread."""
        with self._lock:
            while not self._ended.is_set():
                pause, session, now = HELD_UP, self._session, monotonic()
                if self._telling and self._transport is not None:
                    session.tick(now)
                    self._try_act()
                    self._changed.notify_all()
                elif self.ready:    # nothing is due before that; and a velocity that comes meanwhile is good for the time-out
                    pause += max(0.0, min(session.wake_at - now, self._settings.command_timeout))
                self._alert.wait(pause)

    def _notice(self, session: Session, events: List[Told]) -> None:
        """Keep what the properties show."""
        for event in events:
            if isinstance(event, RobotState):
                self._state = event
                self._states += 1
            elif isinstance(event, Ready):
                self._reconnects += 1
                self._baud = session.own_baud or self._baud
        self._identity = session.identity or self._identity
        if events or session.phase is Phase.FINISHED:
            self._changed.notify_all()

    def _tell(self, events: List[Told]) -> None:
        """Call the listeners; the lock is not held."""
        for event in events:
            if isinstance(event, RobotState):
                self._tell_state(event)
            elif isinstance(event, Motion):
                self._tell_motion(event)
            else:
                self._tell_event(event)

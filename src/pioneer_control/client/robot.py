"""The class Robot: drive a robot on a port from plain Python.

The docstring of the folder has an example.
"""

import atexit
import contextlib
import math
from time import monotonic
from typing import Any, Callable, Iterator, NamedTuple, Optional, Tuple

from ..errors import LinkLostError, NoAnswerError, PioneerError, RefusedError, UsageError
from ..p2os import GripperCommand, encode_command
from ..port_url import split_key
from .data_requests import DATA
from .gripper import gripper_packets
from .identity import RobotIdentity
from .lockstep import LONGEST_CYCLE
from .phases import Connected
from .settings import Settings
from .state import RobotState
from .tcp import is_lockstep
from .threads import Audience, LinkThreads
from .tuning import Tuning


class LinkCounts(NamedTuple):
    """Counters of the link since start(). They show how well the line works."""

    sips: int
    bad_checksums: int
    discarded_bytes: int
    unreadable: int
    """Whole packets that are unknown or malformed, or that show an impossible position."""
    unknown_sonar: int
    """Sonar readings with a number that the model does not have."""
    questions: int
    """Questions that were sent with velocities (link_check), and are answered or overdue; 0 until the first answer."""
    unanswered: int
    """Questions that are overdue: the question or its answer was lost."""
    reconnects: int
    last_error: Optional[str]
    missed: int = 0
    """States and packets that were dropped, because the listeners were too slow."""


class Robot:
    """A Pioneer on a serial port, a pty, TCP or a WebSocket.

    Args:
        url: ``/dev/ttyUSB0``, the path of a pty, ``socket://host:port`` (``tcp://host:port`` and ``host:port`` mean
            the same), or ``ws://host:port/path`` (``wss://...`` if encrypted), also with the key at its end:
            ``ws://host:port/path#key=KEY``. ``socket://host:port?lockstep``: a simulated robot waits for the program
            at each state, so that the same program does the same each time (docs/simulator.md).
        key: what a server on a WebSocket wants to know before it gives the robot. It is used instead of a key in the
            URL. It is in no message: the attribute ``url`` has no key.
        baud: line speed of a serial port. Other speeds are tried when nothing answers.
        model: use this model, whatever the robot announces. Without it an unknown subtype is an error.
        models_file: the user's file that overrides or adds entries in the table of models.
        pulse: time (s) after which a sign of life is sent when nothing else is sent. The sign of life is PULSE, or a
            stop while the robot is to stand. With 0 none is sent, and the robot's own watchdog stops it after 2 s.
        use_sonar: whether the sonar is switched on after connecting.
        command_timeout: the robot is stopped so many seconds after the last velocity command.
        max_linear, max_angular: limits in m/s, rad/s, which can only lower the robot's own limits; None for the robot's
            own limits.
        has_gripper: whether the robot has a gripper; None to believe the robot (CONFIGpac).
        tuning: settings of the robot itself. They are sent after each connecting, when the robot stands. See tune().
        on_state: called with every RobotState. Listeners are called one at a time, in order, on threads of the link,
            with no lock held. They may call all methods of this class, and may take long: commands still go out, and
            the line waits for a listener for 0.2 s at most. When the listeners are too slow, the oldest states and
            packets are dropped, and StatesMissed says how many. A listener that raises ends the connection: the robot
            is stopped and closed, and the next command raises.
        on_event: called with every other Event (client.events), in the same way as on_state.
        on_wire: called with all bytes as ``on_wire(to_robot, data)``, in their order on the line. The thread that reads
            or writes makes the call, and holds the lock while it writes. So on_wire must only store the bytes.
        host_baud: line speed to change to when the robot is open, if the line is serial and the robot can change its
            speed; else the line stays at the speed at which the robot was found. None to stay at this speed.
        link_check: whether to ask the robot for its encoders a few times a second while velocities are sent, only to
            count the answers. Without these questions nobody notices packets that get lost on the way to the robot.
            While a program requests "encoder", it gets all encoder packets, and no answers are counted.
        reconnect: True to try to connect again for ever; False to end after the first failure.
    """

    def __init__(
        self,
        url: str,
        *,
        key: Optional[str] = None,
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
        on_state: Optional[Callable[[RobotState], None]] = None,
        on_event: Optional[Callable[[Any], None]] = None,
        on_wire: Optional[Callable[[bool, bytes], None]] = None,
    ) -> None:
        self.url, key_in_url = split_key(url)
        settings = Settings(
            model, models_file, pulse, use_sonar, command_timeout, max_linear, max_angular, has_gripper, tuning,
            host_baud, link_check)
        self._audience = Audience()
        self._audience.listen(on_state, on_event)
        self._link = LinkThreads(self.url, baud, key_in_url if key is None else key, settings, self._audience,
                                 reconnect, on_wire)
        self._lockstep = is_lockstep(self.url)

    def listen(self, on_state: Optional[Callable[[RobotState], None]] = None,
               on_event: Optional[Callable[[Any], None]] = None) -> None:
        """Add listeners for states and for other events. They are called after the present listeners.

        Call it before start().
        """
        self._audience.listen(on_state, on_event)

    def start(self) -> "Robot":
        """Start to look for the robot on other threads, and return this object at once. Never enables the motors."""
        atexit.register(self.close)
        self._link.start()
        return self

    def close(self, wait: bool = True) -> None:
        """Stop the robot, switch its motors off, send CLOSE, and close the port. This takes about a second at most.

        It can be called twice. Without ``wait`` only the stop is written when this returns. The rest follows on other
        threads: see wait_until_ended().
        """
        self._link.close(wait)
        if wait:
            atexit.unregister(self.close)

    def __enter__(self) -> "Robot":
        """Call start() and wait_until_ready(). If this fails, close again."""
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(self.close)
            self.start()
            self.wait_until_ready()
            on_failure.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def wait_until_ready(self, timeout: float = 10.0) -> RobotIdentity:
        """Block until the robot is connected and has sent its first state. Returns its identity.

        Raises PortError, NoAnswerError (also after ``timeout`` s) or UnknownModelError with what to do.
        """
        link = self._link
        with link.changed:
            link.changed.wait_for(lambda: self.ready or link.ended.is_set(), timeout)
            if link.connected is not None:
                return link.connected.identity
            raise link.failure(NoAnswerError("%s: not ready within %.1f s" % (self.url, timeout)))

    def wait_for_state(self, timeout: float = 1.0) -> RobotState:
        """Wait for the next state, and return it. Raises LinkLostError when no state comes within ``timeout`` s.

        In lockstep this ends the program's turn: no simulated time passes before. ``timeout`` is 10 s at least, so that
        a slow computer makes no difference.
        """
        link = self._link
        if self._lockstep:
            timeout = max(timeout, LONGEST_CYCLE)
        with link.changed:
            before = link.state
            if self._lockstep:
                link.end_turn()
            link.changed.wait_for(lambda: link.state is not before or link.ended.is_set(), timeout)
            if link.state is None or link.state is before:
                raise link.failure(LinkLostError("%s: no state within %.1f s" % (self.url, timeout)))
            return link.state

    def wait_until_ended(self, timeout: Optional[float] = None) -> bool:
        """Block until the link has ended: after close(), after a final failure, or when a listener has raised.

        Returns False when the link has not ended within ``timeout`` s; None waits for ever.
        """
        return self._link.ended.wait(timeout)

    @property
    def ready(self) -> bool:
        """Whether the robot is connected, so that commands can be sent now."""
        return self._link.connected is not None

    @property
    def identity(self) -> Optional[RobotIdentity]:
        """Name, model and limits of the robot; None until the robot was ready for the first time."""
        return self._link.identity

    @property
    def state(self) -> Optional[RobotState]:
        """The newest state of the robot; None before the first state."""
        return self._link.state

    @property
    def tuning(self) -> Tuning:
        """The settings that the robot itself is to have.

        ``robot.tune(dataclasses.replace(robot.tuning, ...))`` changes some of these settings.
        """
        return self._link.settings.tuning

    @property
    def use_sonar(self) -> bool:
        """Whether the sonar is switched on after the next connecting. set_sonar() also switches it now."""
        return self._link.settings.use_sonar

    @use_sonar.setter
    def use_sonar(self, on: bool) -> None:
        self._link.change(use_sonar=bool(on))

    @property
    def link(self) -> LinkCounts:
        """Counters of the link, which show how well the line works."""
        counts, reconnects = self._link.counts()
        error = self._link.error
        return LinkCounts(*counts, reconnects, None if error is None else str(error), self._audience.missed)

    # Commands. Each is written before it returns if the line is idle.

    def set_velocity(self, linear: float, angular: float, timeout: float = math.inf) -> None:
        """Drive at these velocities until command_timeout: m/s, forward positive; rad/s, counter-clockwise positive.

        A shorter ``timeout`` (s) counts instead of command_timeout. The velocities are clamped to the limits of the
        identity. On an idle line the command is written before this returns. Raises UsageError for NaN and infinity,
        and then sends nothing. Raises LinkError when there is no link.
        """
        with self.using() as (robot, now):
            robot.drive.set_velocity(linear, angular, now, timeout)

    def set_wheel_velocities(self, left: float, right: float, timeout: float = math.inf) -> None:
        """Drive the left and the right wheels at these velocities (m/s, forward positive) until command_timeout.

        A shorter ``timeout`` (s) counts instead of command_timeout. The robot takes steps of 20 mm/s. The client
        changes between two steps, so that the average is right. Beyond a limit of a wheel or of the robot both
        velocities are made smaller by the same factor, so that the curve stays. Raises the same errors as
        set_velocity().
        """
        with self.using() as (robot, now):
            robot.drive.set_wheel_velocities(left, right, now, timeout)

    def set_limits(self, max_linear: Optional[float], max_angular: Optional[float], command_timeout: float) -> None:
        """Change the limits (m/s, rad/s; None for the robot's own limit) and the command time-out (s).

        A robot that drives faster is slowed down within 0.2 s. The event Tuned has the identity with the new limits.
        Raises ParameterError for an illegal value. Then nothing changes.
        """
        self._link.change(max_linear=max_linear, max_angular=max_angular, command_timeout=command_timeout)

    def tune(self, tuning: Tuning) -> None:
        """Replace the settings of the robot itself. Values that differ are sent at once.

        All values are sent again after each connecting, because the robot forgets them at the end of a session. A
        setting that is None now and was not None before goes back to the robot's own value. Without a link the values
        are kept for the next link. The event Tuned has the result.
        """
        self._link.change(tuning=tuning)

    def stop(self) -> None:
        """Stop the robot, ahead of all commands that wait. Repeat the stop until the robot reports that it stands.

        Without a link this does nothing and raises no error: every link begins with a stop.
        """
        with contextlib.suppress(PioneerError), self.using() as (robot, now):
            robot.drive.stop(now)

    def enable_motors(self, timeout: float = 2.0) -> None:
        """Switch the motors on. Returns when the robot reports that they are on.

        Raises RefusedError with the reason (STOP button), NotConfirmedError after ``timeout`` s, LinkError without a
        link.
        """
        self.request_motors(True, timeout)()

    def disable_motors(self, timeout: float = 2.0) -> None:
        """Stop the robot, and switch the motors off. Returns when the robot reports that they are off.

        Raises NotConfirmedError after ``timeout`` s, LinkError without a link.
        """
        self.request_motors(False, timeout)()

    def request_motors(self, on: bool, timeout: float = 2.0) -> Callable[[], None]:
        """Ask the robot to switch its motors on or off, and return at once. Raises LinkError without a link.

        Returns a function that waits for the result, and raises the same errors as enable_motors(). The result also
        comes as the event MotorsAnswered.
        """
        with self.using() as (robot, now):
            request = robot.drive.request_motors(on, now, timeout)

        def wait() -> None:
            while self._lockstep and not request.done:
                self.wait_for_state()
            with self._link.changed:
                self._link.changed.wait_for(lambda: request.done)
            if request.error is not None:
                raise request.error

        return wait

    def set_sonar(self, on: bool) -> None:
        """Switch the sonar on or off, now and after each reconnect. Raises LinkError without a link."""
        with self._link.changed:    # so that no reconnect comes in between
            self.send(encode_command("SONAR", int(bool(on))))
            self.use_sonar = on

    def gripper(self, command: GripperCommand, value: Optional[int] = None) -> None:
        """Send one gripper command. PRESSURE needs a ``value`` of 1..100, CARRY of -255..255, not 0 (units of 20 ms).

        Raises UsageError for an unknown command or an illegal value, RefusedError when the robot has no gripper,
        LinkError without a link.
        """
        packets = gripper_packets(command, value)
        with self.using() as (robot, now):
            if not robot.identity.has_gripper:
                raise RefusedError("%s: the robot reports no gripper" % self.url)
            robot.command(now, *packets, stops=command is GripperCommand.HALT)

    def set_digital_out(self, mask: int, states: int) -> None:
        """Set the digital outputs whose bits are 1 in ``mask`` (0..255) to their bits in ``states`` (0..255)."""
        self.send(encode_command("DIGOUT", mask, states))

    def request_data(self, kind: str, on: bool = True) -> None:
        """Ask for packets of this kind with every SIP; with ``on`` False stop them. They come as PacketReceived.

        ``kind`` is a key of data_requests.DATA: "io", "gyro", "encoder", "battery", ... Packets of a device that the
        robot does not have never come. Without a link, and after a reconnect, the robot is asked as soon as there is a
        link. Raises UsageError for an unknown kind.
        """
        if kind not in DATA:
            raise UsageError("there are no packets called %r; legal: %s" % (kind, ", ".join(DATA)))
        with self._link.changed:
            wanted = self._link.settings.data
            self._link.change(data=wanted | {kind} if on else wanted - {kind})

    def reset_odometry(self) -> None:
        """Set the pose to x 0, y 0, heading 0 from the next state on. Raises LinkError without a link."""
        with self.using() as (robot, _):
            robot.odometry.reset()

    def send(self, *packets: bytes, stops: bool = False) -> None:
        """Send whole packets as they are. Raises LinkError without a link. What moves the robot has methods above.

        Raises RefusedError when very many commands wait for the line, unless the packets ``stops`` something.
        """
        with self.using() as (robot, now):
            robot.command(now, *packets, stops=stops)

    @contextlib.contextmanager
    def using(self) -> Iterator[Tuple[Connected, float]]:
        """Let other files of this folder command the robot in a ``with`` block, whose end writes what was commanded.

        The block gets the connected robot and the time (s): monotonic, unless the robot is in lockstep. Raises
        LinkError without a link.
        """
        with self._link as robot:
            yield robot, self._link.now() if self._lockstep else monotonic()

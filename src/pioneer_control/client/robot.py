"""The Robot class: a robot on a port, driven from plain Python.

See the folder's docstring for the few lines that do it.
"""

import atexit
import contextlib
from time import monotonic
from typing import Any, Callable, NamedTuple, Optional

from ..errors import LinkLostError, NoAnswerError, PioneerError, RefusedError, UsageError
from ..p2os import GripperCommand, encode_command
from .data_requests import DATA
from .gripper import gripper_packets
from .identity import RobotIdentity
from .settings import Settings
from .state import RobotState
from .threads import Audience, LinkThreads
from .tuning import Tuning


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
    missed: int = 0
    """states and packets that were not told, because the listeners were too slow"""


class Robot:
    """A Pioneer on a serial port, a pty or TCP.

    Args:
        url: ``/dev/ttyUSB0``, a pty's path, ``socket://host:port`` (``tcp://host:port`` and ``host:port`` are the
            same).
        baud: line speed of a serial port; the others are tried when nothing answers.
        model: use this model whatever the robot announces. Without it an unknown subtype is an error.
        models_file: a file of the user's that overrides values of the table of models.
        pulse: s between signs of life (PULSE; a stop while the robot shall stand) when nothing else is sent; 0 sends
            none, and then the robot's own watchdog stops it after 2 s.
        use_sonar: sonar on after connecting.
        command_timeout: s after which a velocity that nobody renewed means stop.
        max_linear, max_angular: limits in m/s, rad/s below the robot's own; None for just the robot's.
        has_gripper: None believes the robot (CONFIGpac).
        tuning: settings of the robot itself, sent after every connecting when it stands; see tune().
        on_state: called with every RobotState. Listeners are called one at a time, in order, beside the program and
            with no lock held; they may call anything of this class, and may take their time: commands go out
            meanwhile, and the line waits for a listener for 0.2 s at most. To one that is too slow the oldest states
            and packets are not told; StatesMissed says how many. A listener that raises ends the connection: the robot
            is stopped and closed, and the next command raises.
        on_event: called with every Event (client.events) but the states, likewise.
        on_wire: called with every piece of bytes: whether it goes to the robot, and they. In the order in which they go
            over the line, on the thread that writes or reads, which holds the lock while it writes: only put them
            aside.
        host_baud: line speed to change to once the robot is open, if it is a serial line and the robot can; else the
            one at which it was found stays. None for that one.
        link_check: while velocities are sent, ask the robot for its encoders a few times a second, only to count the
            answers: what gets lost on its way to the robot hardly shows otherwise. A program that requests "encoder"
            gets them all, and none are counted.
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
        on_state: Optional[Callable[[RobotState], None]] = None,
        on_event: Optional[Callable[[Any], None]] = None,
        on_wire: Optional[Callable[[bool, bytes], None]] = None,
    ) -> None:
        self.url = url
        settings = Settings(
            model, models_file, pulse, use_sonar, command_timeout, max_linear, max_angular, has_gripper, tuning,
            host_baud, link_check)
        self._audience = Audience()
        self._audience.listen(on_state, on_event)
        self._link = LinkThreads(url, baud, settings, self._audience, reconnect, on_wire)

    def listen(self, on_state: Optional[Callable[[RobotState], None]] = None,
               on_event: Optional[Callable[[Any], None]] = None) -> None:
        """Add listeners, behind those that are there. Call it before start()."""
        self._audience.listen(on_state, on_event)

    def start(self) -> "Robot":
        """Start to look for the robot, on threads of its own, and return at once. Never enables the motors."""
        atexit.register(self.close)
        self._link.start()
        return self

    def close(self, wait: bool = True) -> None:
        """Stop the robot, motors off, CLOSE, port closed; within about a second, whatever the robot does. Can be called
        twice.

        Without ``wait`` only the stop is written when this returns; the rest follows: see wait_until_ended().
        """
        self._link.close(wait)
        if wait:
            atexit.unregister(self.close)

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
        link = self._link
        with link.changed:
            link.changed.wait_for(lambda: self.ready or link.ended.is_set(), timeout)
            if link.connected is not None:
                return link.connected.identity
            raise link.failure(NoAnswerError("%s: not ready within %.1f s" % (self.url, timeout)))

    def wait_for_state(self, timeout: float = 1.0) -> RobotState:
        """The next state that arrives. Raises LinkLostError when none comes within ``timeout`` s."""
        link = self._link
        with link.changed:
            before = link.state
            link.changed.wait_for(lambda: link.state is not before or link.ended.is_set(), timeout)
            if link.state is None or link.state is before:
                raise link.failure(LinkLostError("%s: no state within %.1f s" % (self.url, timeout)))
            return link.state

    def wait_until_ended(self, timeout: Optional[float] = None) -> bool:
        """Block until nothing more will be tried: closed, a failure that is final, or a listener that raised.

        Whether that came in time (s).
        """
        return self._link.ended.wait(timeout)

    @property
    def ready(self) -> bool:
        """Whether commands reach the robot now."""
        return self._link.connected is not None

    @property
    def identity(self) -> Optional[RobotIdentity]:
        """What the robot is; None until it was ready for the first time."""
        return self._link.identity

    @property
    def state(self) -> Optional[RobotState]:
        """The newest state; None before the first."""
        return self._link.state

    @property
    def tuning(self) -> Tuning:
        """The settings that the robot is to have; ``tune(dataclasses.replace(robot.tuning, ...))`` changes some of
        them.
        """
        return self._link.settings.tuning

    @property
    def use_sonar(self) -> bool:
        """Whether the sonar is to be on after the next connecting."""
        return self._link.settings.use_sonar

    @use_sonar.setter
    def use_sonar(self, on: bool) -> None:
        self._link.change(use_sonar=bool(on))

    @property
    def link(self) -> LinkCounts:
        """How well the line works."""
        counts, reconnects = self._link.counts()
        error = self._link.error
        return LinkCounts(*counts, reconnects, None if error is None else str(error), self._audience.missed)

    # Commands. Each is written before it returns if the line is idle.

    def set_velocity(self, linear: float, angular: float) -> None:
        """Drive at ``linear`` m/s (forward positive) and ``angular`` rad/s (counter-clockwise positive) until
        command_timeout.

        Clamped to the identity's limits. On an idle line the command is written before this returns.
        Raises UsageError on NaN and infinity (and sends nothing), LinkError (what stands in the way) without a link.
        """
        with self._link.commanding() as robot:
            robot.drive.set_velocity(linear, angular, monotonic())

    def set_wheel_velocities(self, left: float, right: float) -> None:
        """Drive the left and the right wheels at these speeds (m/s, forward positive) until command_timeout; in steps
        of 20 mm/s, fair on average.

        Where a wheel or the robot as a whole would go beyond a limit, both are made smaller alike: the curve stays.
        Otherwise as set_velocity().
        """
        with self._link.commanding() as robot:
            robot.drive.set_wheel_velocities(left, right, monotonic())

    def set_limits(self, max_linear: Optional[float], max_angular: Optional[float], command_timeout: float) -> None:
        """These three as the constructor takes them, from now on; a robot that drives faster is slowed down within 0.2
        s.

        The identity with the new limits comes as the event Tuned. Raises ParameterError, and then all stays as it was.
        """
        self._link.change(max_linear=max_linear, max_angular=max_angular, command_timeout=command_timeout)

    def tune(self, tuning: Tuning) -> None:
        """Settings of the robot itself from now on, instead of those of before: what differs is sent at once, and all
        of it after every connecting.

        What ``tuning`` leaves open and an earlier one did not goes back to what the robot had. Without a link all is
        kept for the next one. What the robot made of it comes as the event Tuned; it forgets it at the end of the
        session.
        """
        self._link.change(tuning=tuning)

    def stop(self) -> None:
        """Stop, ahead of all that waits; repeated until the robot reports that it stands.

        No error without a link: a link begins with a stop.
        """
        with contextlib.suppress(PioneerError), self._link.commanding() as robot:
            robot.drive.stop(monotonic())

    def enable_motors(self, timeout: float = 2.0) -> None:
        """Motors on; returns when the robot reports it.

        Raises RefusedError with the reason (STOP button), NotConfirmedError after ``timeout`` s, LinkError without a
        link.
        """
        self.request_motors(True, timeout)()

    def disable_motors(self, timeout: float = 2.0) -> None:
        """Stop, motors off; as enable_motors()."""
        self.request_motors(False, timeout)()

    def request_motors(self, on: bool, timeout: float = 2.0) -> Callable[[], None]:
        """Ask for the motors and return at once. Returns a function that waits for the answer, and raises as
        enable_motors() does.

        The answer comes as the event MotorsAnswered, too.
        """
        with self._link.commanding() as robot:
            request = robot.drive.request_motors(on, monotonic(), timeout)

        def wait() -> None:
            with self._link.changed:
                self._link.changed.wait_for(lambda: request.done)
            if request.error is not None:
                raise request.error

        return wait

    def set_sonar(self, on: bool) -> None:
        """Sonar on or off, after a reconnect too."""
        with self._link.changed:    # no reconnect comes in between
            self._command(encode_command("SONAR", int(bool(on))))
            self.use_sonar = on

    def gripper(self, command: GripperCommand, value: Optional[int] = None) -> None:
        """One sub-command of the gripper; ``value`` for PRESSURE (1..100) and CARRY (-255..255), in units of 20 ms.

        Raises UsageError for a number that means nothing, RefusedError when no gripper is fitted.
        """
        packets = gripper_packets(command, value)
        with self._link.commanding() as robot:
            if not robot.identity.has_gripper:
                raise RefusedError("%s: the robot reports no gripper" % self.url)
            robot.command(monotonic(), *packets)

    def set_digital_out(self, mask: int, states: int) -> None:
        """Set the digital outputs whose bits are 1 in ``mask`` (0..255) to their bits in ``states``."""
        self._command(encode_command("DIGOUT", mask, states))

    def request_data(self, kind: str, on: bool = True) -> None:
        """Packets of this kind with every SIP, as PacketReceived events, or no more of them; asked for again after a
        reconnect.

        ``kind`` is one of data_requests.DATA: "io", "gyro", "encoder", "battery", ... What the robot does not have
        never comes. Without a link it is asked for as soon as there is one. Raises UsageError for another kind.
        """
        if kind not in DATA:
            raise UsageError("there are no packets called %r; legal: %s" % (kind, ", ".join(DATA)))
        with self._link.changed:
            wanted = self._link.settings.data
            self._link.change(data=wanted | {kind} if on else wanted - {kind})

    def reset_odometry(self) -> None:
        """The robot stands at (0, 0, 0) from the next state on."""
        with self._link.commanding() as robot:
            robot.odometry.reset()

    def _command(self, *packets: bytes) -> None:
        with self._link.commanding() as robot:
            robot.command(monotonic(), *packets)

"""The phases of one connection, sans-I/O. Each phase is an object. The table TRANSITIONS has the phase that follows.

::

    Connecting ──Named──> Synced ──Recognised──> Opening ──Learned──> Connected
        │                   │                       │                     │
        │ Left, Failed      │ Left, Failed          │ Left                │ Left          (Failed: to Finished)
        v                   v                       v                     v
    Finished            Finished                 Closing  <───────────────┘  ──Gone, Failed──> Finished

The session gives packets and the time to the present phase. The phase writes to the line, and returns an outcome when
it is over. It changes no other phase. The first phase, Connecting, is in the file `handshake`.
"""

import math
from typing import Any, Callable, Dict, Optional, Tuple, Type, Union

from .. import p2os
from ..errors import NoAnswerError, RefusedError, UnknownModelError
from ..robots import find_model
from .data_requests import DataRequests
from .drive import MOTORS, STOP, Drive
from .events import BaudFound, PacketReceived, Ready, Tuned
from .handshake import CLOSE, Connecting
from .host_baud import stands, use_host_baud
from .identity import CONFIG, RobotIdentity, identify
from .line import LONGEST_QUEUE
from .link import Failed, Gone, Learned, Left, Link, Named, Outcome, Phase, Procedure, Recognised, SteppedPhase
from .link_check import LinkCheck
from .corrected_odometry import odometry_of
from .odometry import Odometry
from .settings import Settings
from .state import StateReader
from .tuner import Tuner

BEFORE_OPEN = 0.1       # s between the SYNC2 reply and OPEN, as other clients leave
ASK_AGAIN = 0.2         # s between repetitions of OPEN and CONFIG
CONFIG_TIMEOUT = 1.0    # s: firmware that has not answered CONFIG by then never will
OPEN_TIMEOUT = 3.0      # s for the first SIP
SILENCE = 2.0           # s without a SIP: the link is lost
WATCHDOG_MARGIN = 0.8   # factor on the robot's watchdog time, because of its clock and the delay of the line
STAND_TIMEOUT = 0.35    # s that a closing session gives the robot to come to rest
MOTORS_OFF = 0.05       # s between ENABLE 0 and CLOSE
CLOSE_TRIES = 3
SIP_CYCLE = 0.12        # s: a robot that sends nothing for that long is closed

PULSE = p2os.encode_command("PULSE")
OPEN = p2os.encode_command("OPEN")
LAST_WORDS = b"".join(STOP) + MOTORS[False] + CLOSE
"""Stop, motors off, CLOSE: what the robot must get when its connection ends at once."""


class Synced(SteppedPhase):
    """The robot has sent its name and is not open: find its model in the table.

    When the connection ends here, the robot needs a CLOSE. It ignores another SYNC before that.

    Attributes:
        reply: the SYNC2 reply of the robot.
        own_baud: the line speed at which the robot was found, and to which it returns at CLOSE; None on TCP.
    """

    last_words = CLOSE

    def __init__(self, link: Link, before: Connecting, named: Named) -> None:
        super().__init__(link, before.odometry)
        self.reply = named.reply
        self.own_baud = link.line.baud
        if self.own_baud is not None and self.own_baud != before.rates[0]:
            link.events.append(BaudFound(self.own_baud))

    def _steps(self) -> Procedure:
        reply, settings = self.reply, self._link.settings
        try:
            model = find_model(settings.model or reply.subtype, settings.models_file)
        except UnknownModelError as error:
            raise UnknownModelError("%s: the robot %r says it is %s %s: %s" % (
                self._link.url, reply.name, reply.type, reply.subtype, error)) from error
        yield from self._link.pause(BEFORE_OPEN)
        return Recognised(model)


class Opening(SteppedPhase):
    """Send OPEN, wait until the robot sends SIPs with its motors off, and get its CONFIGpac."""

    last_words = LAST_WORDS

    def __init__(self, link: Link, before: Synced, recognised: Recognised) -> None:
        super().__init__(link, before.odometry)
        self.reply, self.own_baud, self.model = before.reply, before.own_baud, recognised.model
        self._config: Optional[p2os.Config] = None
        # the newest SIP, with the times at which it was whole, and at which the robot began to send it
        self._newest: Optional[Tuple[p2os.Sip, float, float]] = None
        link.grip_state_first = recognised.model.grip_state_first

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        if isinstance(packet, p2os.Sip):
            self._newest = packet, self._link.now, sent_time
        elif isinstance(packet, p2os.Config):
            self._config = packet
        elif isinstance(packet, p2os.Reset):
            return Failed(self._link.lost("the robot's controller restarted"))
        return super().take(packet, sent_time)

    def _steps(self) -> Procedure:
        link = self._link
        if self.odometry is not None:
            self.odometry.rebase()      # OPEN begins a new frame
        for packets in ((OPEN,), STOP, (MOTORS[False],), (p2os.encode_command("SONAR", int(link.settings.use_sonar)),),
                        (CONFIG,)):
            link.line.command(link.now, *packets)
        opened_at = asked_at = link.now
        while (self._newest is None or self._newest[0].flags & p2os.Flags.MOTORS_ENABLED
               or self._config is None and link.now - opened_at < CONFIG_TIMEOUT):
            if link.now - opened_at >= OPEN_TIMEOUT:
                what = "sends no packets" if self._newest is None else "does not switch its motors off"
                raise NoAnswerError("%s: %s was opened, but %s" % (link.url, self.reply.name, what))
            if link.now >= asked_at + ASK_AGAIN:
                asked_at = link.now
                link.line.command(link.now, *((OPEN,) if self._newest is None else ()), MOTORS[False], CONFIG)
            yield asked_at + ASK_AGAIN
        link.events += yield from use_host_baud(link, self._config, self._newest[0])
        return Learned(self._config, *self._newest)


class Connected(Phase):
    """The robot sends SIPs and obeys commands.

    Attributes:
        identity: name, model and limits of the robot.
        own_baud: the line speed to which the robot returns at CLOSE; None on TCP.
        drive: sends velocities and motor commands.
        data: requests packets besides the SIP.
        tuner: sends settings of the robot itself.
        link_check: checks whether packets reach the robot.
        reader: turns the SIPs into states.
    """

    last_words = LAST_WORDS
    odometry: Odometry

    def __init__(self, link: Link, before: Opening, learned: Learned) -> None:
        model = before.model
        odometry = odometry_of(model, before.odometry)
        super().__init__(link, odometry)
        self.own_baud = before.own_baud
        self._reply, self._model, self._config = before.reply, model, learned.config
        self.identity = self._identify()
        link.line.watchdog = self.identity.watchdog * WATCHDOG_MARGIN
        self.link_check = LinkCheck(self.identity.sip_cycle, link.line.transfer_time)
        self.drive = Drive(link.line, self.identity, link.settings.command_timeout, link.events,
                           self.link_check.question)
        self.data = DataRequests(link.line, self.identity)
        self.tuner = Tuner(link, self.identity)
        self.reader = StateReader(self.identity, odometry)
        link.connected_counts = self.counts
        self.use(link.settings, link.now)
        link.events.append(Ready(self.identity))
        self._report(learned.sip, learned.time, learned.sent_time)

    def counts(self) -> Tuple[int, int, int]:
        """Return the numbers of unknown sonar readings, questions and unanswered questions, as in session.Counts."""
        return self.reader.unknown_sonar, self.link_check.questions, self.link_check.unanswered

    @property
    def due(self) -> float:
        return min(self.drive.due, self.data.due, self.tuner.due, self.link_check.due, self._link.last_sip + SILENCE,
                   self._pulse_at)

    def command(self, now: float, *packets: bytes, stops: bool = False) -> None:
        """Send packets that belong together. Raises RefusedError when LONGEST_QUEUE commands wait already.

        What ``stops`` something is never refused. While it waits for the line, it is there once, however often it is
        repeated.
        """
        if stops:
            self._link.line.withdraw(*packets)
        elif self._link.line.full:
            raise RefusedError("%s: the line is too slow for so many commands: %d wait already"
                               % (self._link.url, LONGEST_QUEUE))
        self._link.line.command(now, *packets)

    @property
    def waiting(self) -> int:
        """Number of commands that wait for the line."""
        return self._link.line.waiting

    def end_turn(self) -> None:
        """Tell a robot in lockstep that the program waits for the next state. Any other robot is told nothing."""

    def use(self, settings: Settings, now: float) -> None:
        before, self.identity = self.identity, self._identify()
        if self.identity != before:
            self.drive.follow(self.identity)
            self._link.events.append(Tuned((), self.identity))
        self.drive.command_timeout = settings.command_timeout
        if not self.tuner.waits_for_rest:
            self.tuner.tune(now)
        self.data.want(settings.data, now)
        self.link_check.asks = (
            settings.link_check and "encoder" not in settings.data
            and p2os.knows(self._model.firmware_family, "ENCODER"))

    def take(self, packet: Any, sent_time: float) -> Optional[Outcome]:
        link = self._link
        if isinstance(packet, p2os.Sip):
            self._report(packet, link.now, sent_time)
        elif isinstance(packet, p2os.Reset):
            return Failed(link.lost("the robot's controller restarted"))
        elif isinstance(packet, (p2os.UnknownPacket, p2os.MalformedPacket)):
            link.unreadable += 1
        elif not (isinstance(packet, p2os.Encoder) and self.link_check.saw_answer()):
            self.data.saw(packet, link.now)
            if isinstance(packet, p2os.Config):
                self._reconfigure(packet)
            link.events.append(PacketReceived(packet, link.now, sent_time))
        return None

    def tick(self, now: float) -> Optional[Outcome]:
        link = self._link
        self.drive.tick(now)
        self.data.tick(now)
        self.tuner.tick(now)
        self.link_check.tick(now)
        if now >= link.last_sip + SILENCE:
            return Failed(link.lost("the robot has fallen silent: no packet for %.1f s" % SILENCE))
        if now >= self._pulse_at and not link.line.waiting:
            link.line.command(now, *self._sign_of_life())
        return None

    def _report(self, sip: p2os.Sip, time: float, sent_time: float) -> None:
        state = self.reader.read(sip, time, sent_time)
        if state is None:
            self._link.unreadable += 1
        else:
            self._link.events.append(state)
            self.drive.saw(state)
            if self.tuner.waits_for_rest and not state.moving:
                self.tuner.tune(time)

    def _reconfigure(self, config: p2os.Config) -> None:
        """Take a new CONFIGpac. It may change the limits and the watchdog time."""
        self._config = config
        self.identity = identity = self._identify()
        self._link.line.watchdog = identity.watchdog * WATCHDOG_MARGIN
        self.drive.follow(identity)
        self.reader.follow(identity)
        self.tuner.saw_config(identity, self._link.now)

    def _identify(self) -> RobotIdentity:
        settings = self._link.settings
        return identify(self._reply, self._model, self._config, settings.max_linear, settings.max_angular,
                        settings.has_gripper)

    def _sign_of_life(self) -> Tuple[bytes, ...]:
        """Return the packets that keep the robot's watchdog from acting: PULSE while a velocity is wanted, else a stop.

        While the robot is to stand, PULSE could revive an old set point if the stop was lost. A robot that a joystick
        drives is at rest before.
        """
        if self.drive.wanted is not None or self.drive.joystick:
            return (PULSE,)
        return STOP[:1] if p2os.knows(self._model.firmware_family, "STOP") else STOP

    @property
    def _pulse_at(self) -> float:
        line, pulse = self._link.line, self._link.settings.pulse
        return max(line.last_sent + pulse, line.free_at) if pulse else math.inf


class Closing(SteppedPhase):
    """Stop the robot, give it a moment to come to rest, switch its motors off, and send CLOSE until it is silent."""

    last_words = LAST_WORDS

    def __init__(self, link: Link, before: Union[Opening, Connected], left: Left) -> None:
        super().__init__(link, before.odometry)
        self._standing = not isinstance(before, Connected) or before.drive.at_rest and not before.drive.joystick
        link.line.drop()
        if isinstance(before, Connected):
            before.drive.abandon(link.lost("closed"))
            if before.drive.joystick:       # else it would drive on against the stop
                before.drive.stop(link.now)

    def _steps(self) -> Procedure:
        link = self._link
        link.line.stop(link.now, *STOP)
        deadline = link.now + STAND_TIMEOUT
        while not self._standing and link.now < deadline:
            packet = yield deadline
            self._standing = isinstance(packet, p2os.Sip) and stands(packet)
        link.line.command(link.now, MOTORS[False])
        yield from link.pause(MOTORS_OFF)
        for _ in range(CLOSE_TRIES):
            link.line.command(link.now, CLOSE)
            closed_at = link.now
            yield from link.pause(SIP_CYCLE)
            if link.last_sip <= closed_at:
                break
        return Gone()


class Finished(Phase):
    """The connection is over. Nothing more is received.

    At the beginning this phase sends ``last_words`` of the previous phase, unless Closing has closed the robot.

    Attributes:
        error: why the connection ended; None when the user closed it.
    """

    def __init__(self, link: Link, before: Phase, outcome: Union[Left, Gone, Failed]) -> None:
        super().__init__(link, before.odometry)
        self.error = outcome.error if isinstance(outcome, Failed) and not isinstance(before, Closing) else None
        if isinstance(before, Connected):
            before.drive.abandon(outcome.error if isinstance(outcome, Failed) else link.lost("closed"))
        link.line.drop()
        if before.last_words and not isinstance(outcome, Gone):
            link.line.say(before.last_words)


TRANSITIONS: Dict[Tuple[Type[Phase], type], Callable[[Link, Any, Any], Phase]] = {
    (Connecting, Named): Synced,
    (Connecting, Left): Finished,
    (Connecting, Failed): Finished,
    (Synced, Recognised): Opening,
    (Synced, Left): Finished,
    (Synced, Failed): Finished,
    (Opening, Learned): Connected,
    (Opening, Left): Closing,
    (Opening, Failed): Finished,
    (Connected, Left): Closing,
    (Connected, Failed): Finished,
    (Closing, Gone): Finished,
    (Closing, Failed): Finished,
}
"""The next phase, by the present phase and the outcome that ends it. Other outcomes have no effect in a phase."""

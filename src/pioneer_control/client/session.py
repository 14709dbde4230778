"""One connection to one robot, sans-I/O: bytes and time go in, bytes and events come out.

::

    connecting ──> opening ──> ready ──> closing ──> finished
    (handshake)    (CONFIG,    (SIPs)    (stop,      (``error`` says why, None after close())
                   first SIP)            CLOSE)

Whoever runs a session calls receive() with what was read (or its halves, hear() and read_on()), tick() at ``wake_at`` at the latest, and after each
call of any kind carries out take_actions() in order and hands take_events() to the listeners. Nothing in here knows a clock, a thread or a port.
"""

import math
from dataclasses import replace
from enum import Enum
from types import MappingProxyType
from typing import Any, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from .. import p2os
from ..errors import LinkLostError, NoAnswerError, PioneerError, RefusedError, UnknownModelError
from ..robots import RobotModel, find_model
from .data import DataRequests
from .drive import MOTORS, STOP, Drive
from .events import BaudFound, Event, PacketReceived, Ready, Tuned
from .handshake import CLOSE, Handshake
from .host_baud import HostBaud, stands
from .identity import CONFIG, RobotIdentity, identify
from .line import LONGEST_QUEUE, Line, SetBaud
from .link_check import LinkCheck
from .odometry import Odometry
from .script import Script, pause
from .settings import Settings
from .state import Motion, StateReader
from .tuner import Tuner
from .tuning import Tuning

BEFORE_OPEN = 0.1       # s that clients are known to leave between the SYNC2 reply and OPEN
ASK_AGAIN = 0.2         # s between repetitions of OPEN and CONFIG
CONFIG_TIMEOUT = 1.0    # s: firmware that has not answered CONFIG by then never will
OPEN_TIMEOUT = 3.0      # s for the first SIP
SILENCE = 2.0           # s without a SIP: the link is lost
UNHEARD = 3.0           # s that a robot may have gone on for without a link: until its watchdog stops it, and a ramp
WATCHDOG_MARGIN = 0.8   # of the robot's watchdog: its clock and the line's delay are not ours
STAND_TIMEOUT = 0.35    # s that a closing session leaves the robot to come to rest
MOTORS_OFF = 0.05       # s between ENABLE 0 and CLOSE
CLOSE_TRIES = 3
SIP_CYCLE = 0.12        # s: a robot that sends nothing for that long is closed

PULSE = p2os.encode_command("PULSE")
OPEN = p2os.encode_command("OPEN")
LAST_WORDS = b"".join(STOP) + MOTORS[False] + CLOSE
"""For a link that has no time left for more."""


class Phase(Enum):
    """Where a session stands."""

    CONNECTING = "connecting"
    OPENING = "opening"
    READY = "ready"
    CLOSING = "closing"
    FINISHED = "finished"


Action = Union[bytes, SetBaud]
"""bytes are to be written in one piece."""
Told = Union[Motion, Event]
"""What listeners hear: of every SIP its Motion and then its RobotState, which is one, too; and the events."""


class Counts(NamedTuple):
    """Of one session."""

    sips: int = 0
    bad_checksums: int = 0
    discarded_bytes: int = 0
    unreadable: int = 0
    unknown_sonar: int = 0
    questions: int = 0
    unanswered: int = 0


class Session:
    """One connection, from its first byte to its last.

    Args:
        url: for error messages.
        rates: line speeds to try, the port's present one first; empty on TCP.
        settings: what the user wants.
        odometry: of the connection before, to be continued if this is the same kind of robot.
        wanted_data: kinds of packets to be asked for (data.DATA).
    """

    def __init__(
        self,
        url: str,
        rates: Tuple[int, ...],
        settings: Settings,
        odometry: Optional[Odometry] = None,
        wanted_data: Mapping[str, bool] = MappingProxyType({}),
    ) -> None:
        self.url = url
        self.phase = Phase.CONNECTING
        self.error: Optional[PioneerError] = None
        self.reply: Optional[p2os.SyncReply] = None
        self.identity: Optional[RobotIdentity] = None
        self.own_baud: Optional[int] = None
        """The line speed at which the robot was found, and to which it returns; None before that, and on TCP."""
        self.odometry = odometry
        self.drive: Optional[Drive] = None
        self.data: Optional[DataRequests] = None
        self.tuner: Optional[Tuner] = None
        self.link_check: Optional[LinkCheck] = None
        self._settings = settings
        self._wanted_data = wanted_data
        self._actions: List[Action] = []
        self._events: List[Told] = []
        self._line = Line(self._do, rates[0] if rates else None, STOP)
        self.host_baud = HostBaud(self._line, url, settings.host_baud, self._clock)
        self._handshake = Handshake(self._line, url, rates, self._clock, again=odometry is not None)
        self._decoder = p2os.FrameDecoder()
        self._unread: Iterator[Motion] = iter(())   # what was heard and is not read yet
        self._now = -math.inf
        self._last_byte = -math.inf
        self._last_sip = -math.inf
        self._sips = 0
        self._unreadable = 0
        self._model: Optional[RobotModel] = None
        self._config: Optional[p2os.Config] = None
        self._pending_sip: Optional[p2os.Sip] = None
        self._pending_times = (0.0, 0.0)
        self._reader: Optional[StateReader] = None
        self._script: Optional[Script] = None
        self._resume_at = math.inf

    @property
    def baud(self) -> Optional[int]:
        """The present line speed; None on TCP."""
        return self._line.baud

    @property
    def counts(self) -> Counts:
        """What the line brought."""
        counts = self._decoder.counts
        once_ready = (0, 0, 0) if self._reader is None else (self._reader.unknown_sonar, self.link_check.questions, self.link_check.unanswered)
        return Counts(self._sips, counts.bad_checksums + counts.bad_counts, counts.discarded_bytes, self._unreadable, *once_ready)

    @property
    def wake_at(self) -> float:
        """When tick() is to be called at the latest (monotonic, s); infinity once finished. After a tick always in the future."""
        if self.phase is Phase.FINISHED:
            return math.inf
        due = min(self._resume_at, self._line.due)
        if self._decoder.waiting:
            due = min(due, self._last_byte + p2os.PARTIAL_TIMEOUT)
        if self.phase is Phase.READY:
            due = min(due, self.drive.due, self.data.due, self.tuner.due, self.link_check.due, self._last_sip + SILENCE, self._pulse_at)
        return due

    def take_actions(self) -> List[Action]:
        """What is to be done on the line, in order; each only once."""
        actions = self._actions[:]
        self._actions.clear()
        return actions

    def take_events(self) -> List[Told]:
        """What the listeners are to hear, in order; each only once."""
        events = self._events[:]
        self._events.clear()
        return events

    def start(self, now: float) -> None:
        """Begin to listen. ``now`` is monotonic time in s, here and below."""
        self._now = now
        self._run(self._connect())

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes as they came, in any pieces."""
        motion = self.hear(data, now)
        if motion is not None:
            self._events.append(motion)
        self.read_on()

    def hear(self, data: bytes, now: float) -> Optional[Motion]:
        """The first half of receive(), up to the first Motion, which is to be told at once; then read_on(). Anything may be called in between."""
        self.read_on()
        self._now = self._last_byte = now
        self._unread = self._take(self._decoder.feed(data), now)
        motion = next(self._unread, None)
        if motion is not None and any(isinstance(event, Motion) for event in self._events):     # it became ready just now: that is told first
            self._events.append(motion)
            return None
        return motion

    def read_on(self) -> None:
        """The second half of receive()."""
        for motion in self._unread:
            self._events.append(motion)

    def tick(self, now: float) -> None:
        """Let time pass."""
        self._now = now
        self.read_on()      # first things first, also while a listener has what was heard
        if self._decoder.waiting and now >= self._last_byte + p2os.PARTIAL_TIMEOUT:
            self._unread = self._take(self._decoder.drop_partial(), now)
            self.read_on()
        if now >= self._resume_at:
            self._resume(None)
        if self.phase is Phase.READY:
            self.drive.tick(now)
            self.data.tick(now)
            self.tuner.tick(now)
            self.link_check.tick(now)
            if now >= self._last_sip + SILENCE:
                self.fail(LinkLostError("%s: the robot has fallen silent: no packet for %.1f s" % (self.url, SILENCE)))
            elif now >= self._pulse_at and not self._line.waiting:
                self._line.command(now, *self._sign_of_life())
        if self.phase is not Phase.FINISHED:
            self._line.tick(now)

    def command(self, now: float, *packets: bytes) -> None:
        """Send packets that belong together to a ready robot. Raises RefusedError when LONGEST_QUEUE others wait for the line."""
        if self._line.full:
            raise RefusedError("%s: the line is too slow for so many commands: %d wait already" % (self.url, LONGEST_QUEUE))
        self._line.command(now, *packets)

    def limit(self, settings: Settings) -> None:
        """Take the limits and the command time-out of these settings, from now on."""
        self._settings = settings
        if self.phase is Phase.READY:
            self.drive.command_timeout = settings.command_timeout
            self.drive.follow(self._identify())
            self._events.append(Tuned((), self.identity))

    def tune(self, tuning: Tuning, now: float) -> None:
        """Settings instead of those of before; a robot that is not ready hears of them when it is."""
        self._settings = replace(self._settings, tuning=tuning)
        if self.phase is Phase.READY:
            self.tuner.tune(tuning, now)

    def close(self, now: float) -> None:
        """Stop, motors off, CLOSE. A robot that was only listened to is told nothing."""
        self._now = now
        if self.phase in (Phase.OPENING, Phase.READY):
            self.phase = Phase.CLOSING
            self._abandon(LinkLostError("%s: closed" % self.url))
            self._line.drop()
            self._run(self._goodbye())
        elif self.phase is Phase.CONNECTING:
            self._finish(None)

    def fail(self, error: PioneerError) -> None:
        """The connection is over, for this reason. A robot that may still hear us is told to stop."""
        if self.phase is Phase.FINISHED:
            return
        if self.phase in (Phase.OPENING, Phase.READY, Phase.CLOSING):
            self._actions.append(LAST_WORDS)
        self._abandon(error)
        self._finish(error if self.phase is not Phase.CLOSING else None)

    def _sign_of_life(self) -> Tuple[bytes, ...]:
        """While the robot shall stand, a stop in one packet: whatever else came through alone would revive a set point whose stop was lost."""
        if not self.drive.shall_stand:
            return (PULSE,)
        return STOP[:1] if p2os.knows(self._model.firmware_family, "STOP") else STOP

    @property
    def _pulse_at(self) -> float:
        return max(self._line.last_sent + self._settings.pulse, self._line.free_at) if self._settings.pulse else math.inf

    def _do(self, action: Action) -> None:
        if isinstance(action, SetBaud):
            self._decoder.drop_partial()    # what came at the old speed
        self._actions.append(action)

    # Packets

    def _take(self, frames: List[p2os.Frame], heard_at: float) -> Iterator[Motion]:
        """Read all of them; yields the Motion of each SIP before the rest of it is read."""
        for frame in frames:
            times, motion = (heard_at, self._line.transfer_time(frame.length)), None
            sip = p2os.decode_motion(frame)
            if sip is not None:
                self._sips += 1
                self._last_sip = heard_at
                if self.phase is Phase.READY:
                    motion = self._reader.move(sip, *times)
                    if motion is None:
                        self._unreadable += 1
                    else:
                        yield motion
                elif self.phase is Phase.CONNECTING and self.odometry is not None and not self._handshake.said_its_name:
                    # it was left open, and went on counting
                    self.odometry.update(sip.x_counts, sip.y_counts, sip.heading_units, UNHEARD)
            packet = p2os.decode_packet(frame, self._model is None or self._model.grip_state_first)
            if sip is not None and self.phase is Phase.OPENING:
                self._pending_sip, self._pending_times = packet, times
            if self._script is not None:
                self._resume(packet)
            elif self.phase is Phase.READY:
                self._while_ready(packet, motion, *times)

    def _while_ready(self, packet: Any, motion: Optional[Motion], time: float, transfer_time: float) -> None:
        if isinstance(packet, p2os.Sip):
            if motion is not None:
                self._report(packet, motion)
        elif isinstance(packet, p2os.Reset):
            self.fail(LinkLostError("%s: the robot's controller restarted" % self.url))
        elif isinstance(packet, (p2os.UnknownPacket, p2os.MalformedPacket)):
            self._unreadable += 1
        elif not (isinstance(packet, p2os.Encoder) and self._checks_link and self.link_check.saw_answer()):
            self.data.saw(packet, time)
            if isinstance(packet, p2os.Config):
                self._reconfigure(packet)
            self._events.append(PacketReceived(packet, time, time - transfer_time))

    def _report(self, sip: p2os.Sip, motion: Motion) -> None:
        assert self._reader is not None and self.drive is not None
        state = self._reader.read(sip, motion)
        self._events.append(state)
        self.drive.saw(state)
        self.tuner.saw(state)

    def _reconfigure(self, config: p2os.Config) -> None:
        """The robot says again what it is: limits and watchdog may be others now."""
        self._config = config
        identity = self._identify()
        self._line.watchdog = identity.watchdog * WATCHDOG_MARGIN
        self.drive.follow(identity)
        self._reader.follow(identity)
        self.tuner.saw_config(identity, self._now)

    # Scripts

    def _run(self, script: Script) -> None:
        self._script = script
        self._resume(None)

    def _resume(self, packet: Any) -> None:
        script = self._script
        assert script is not None
        self._handshake.noise = self._decoder.counts.discarded_bytes
        self._handshake.packets += packet is not None
        try:
            self._resume_at = script.send(packet)
        except StopIteration:
            if self._script is script:
                self._script, self._resume_at = None, math.inf
        except PioneerError as error:
            self.fail(error)

    def _connect(self) -> Script:
        """Find the robot, open it, and learn what it is."""
        given = self.baud
        self.reply = yield from self._handshake.script()
        model = self._find_model(self.reply)
        self.own_baud = self.baud
        if self.baud != given:
            self._events.append(BaudFound(self.baud))
        self._model = model
        yield from pause(BEFORE_OPEN, self._clock)
        self.phase = Phase.OPENING
        if self.odometry is not None:
            self.odometry.rebase()      # OPEN begins a new frame
        for packets in ((OPEN,), STOP, (MOTORS[False],), (p2os.encode_command("SONAR", int(self._settings.use_sonar)),)):
            self._line.command(self._now, *packets)
        yield from self._learn()
        said = yield from self.host_baud.script(self._config, self._pending_sip)
        self._events += said
        self._become_ready(model)

    def _find_model(self, reply: p2os.SyncReply) -> RobotModel:
        try:
            return find_model(self._settings.model or reply.subtype, self._settings.models_file)
        except UnknownModelError as error:
            raise UnknownModelError("%s: the robot %r says it is %s %s: %s" % (self.url, reply.name, reply.type, reply.subtype, error)) from error

    def _learn(self) -> Script:
        """Wait for CONFIGpac, for as long as firmware may need that knows CONFIG, and for a SIP that says that the motors are off."""
        opened_at = asked_at = self._now
        self._line.command(self._now, CONFIG)
        while not self._motors_are_off or (self._config is None and self._now - opened_at < CONFIG_TIMEOUT):
            if self._now - opened_at >= OPEN_TIMEOUT:
                what = "sends no packets" if self._pending_sip is None else "does not switch its motors off"
                raise NoAnswerError("%s: %s was opened, but %s" % (self.url, self.reply.name, what))
            if self._now >= asked_at + ASK_AGAIN:
                asked_at = self._now
                self._line.command(self._now, *((OPEN,) if self._pending_sip is None else ()), MOTORS[False], CONFIG)
            packet = yield asked_at + ASK_AGAIN
            if isinstance(packet, p2os.Config):
                self._config = packet
            elif isinstance(packet, p2os.Reset):
                raise LinkLostError("%s: the robot's controller restarted" % self.url)

    @property
    def _motors_are_off(self) -> bool:
        return self._pending_sip is not None and not self._pending_sip.flags & p2os.Flags.MOTORS_ENABLED

    def _become_ready(self, model: RobotModel) -> None:
        identity = self._identify()
        if self.odometry is None or not self.odometry.fits(model.dist_mm_per_unit, model.angle_units_per_rev):
            self.odometry = Odometry(model.dist_mm_per_unit, model.angle_units_per_rev)
        self._line.watchdog = identity.watchdog * WATCHDOG_MARGIN
        self._reader = StateReader(identity, self.odometry)
        self.drive = Drive(self._line, identity, self._settings.command_timeout, self._events, self._question)
        self.data = DataRequests(self._line, identity, self._wanted_data, self._now)
        self.tuner = Tuner(self._line, identity, self._settings.tuning, self._events)
        self.link_check = LinkCheck(identity.sip_cycle, self._line.transfer_time)
        self.phase = Phase.READY
        self._events.append(Ready(identity))
        motion = self._reader.move(self._pending_sip, *self._pending_times)
        self._events.append(motion)
        self._report(self._pending_sip, motion)

    @property
    def _checks_link(self) -> bool:
        return self._settings.link_check and p2os.knows(self._model.firmware_family, "ENCODER") and not self.data.wants("encoder")

    def _question(self, now: float) -> Sequence[bytes]:
        """What goes with a velocity, to see whether it arrives."""
        return self.link_check.question(now) if self._checks_link else ()

    def _identify(self) -> RobotIdentity:
        settings = self._settings
        self.identity = identify(self.reply, self._model, self._config, settings.max_linear, settings.max_angular, settings.has_gripper)
        return self.identity

    def _goodbye(self) -> Script:
        """Stop, let it come to rest for a moment, motors off, CLOSE until it is silent."""
        self._line.stop(self._now, *STOP)
        deadline, standing = self._now + STAND_TIMEOUT, self.drive is None or self.drive.at_rest
        while not standing and self._now < deadline:
            packet = yield deadline
            standing = isinstance(packet, p2os.Sip) and stands(packet)
        self._line.command(self._now, MOTORS[False])
        yield from pause(MOTORS_OFF, self._clock)
        for _ in range(CLOSE_TRIES):
            self._line.command(self._now, CLOSE)
            closed_at = self._now
            yield from pause(SIP_CYCLE, self._clock)
            if self._last_sip <= closed_at:
                break
        self._finish(None)

    def _clock(self) -> float:
        return self._now

    def _abandon(self, error: PioneerError) -> None:
        if self.drive is not None:
            self.drive.abandon(error)

    def _finish(self, error: Optional[PioneerError]) -> None:
        if self.phase is Phase.CONNECTING and self.reply is not None:   # synced but not opened: it would ignore the next SYNC
            self._actions.append(CLOSE)
        self._line.drop()
        self.phase, self.error = Phase.FINISHED, error
        self._script, self._resume_at = None, math.inf

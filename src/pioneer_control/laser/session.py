"""The computer's side of a laser's line: bytes and time go in, bytes and events come out. No I/O, no clock, no thread.

What is said to a laser, and in which order, stands in `conversation`. This file carries it out: it sends a request,
sends it again when it was not heard, hands the reply back, and notices when a laser falls silent.
"""

import math
from typing import Any, Generator, List, NamedTuple, Optional, Sequence, Union

from ..lms2xx import (MESSAGES, METRES, PARTIAL_TIMEOUT, SPEEDS, WELL, Answer, ConfigurationWritten, MalformedMessage,
                      PowerOn, RawScan, Resetting, ScanReply, SetMode, Telegram, TelegramCounts, TelegramDecoder,
                      VariantSet, decode, encode, first_ray_before_first_byte, severity, time_on_line)
from .conversation import (Ask, LaserInfo, LaserSpeed, NoLaserError, Pause, SetLineSpeed, Step, asking, closing,
                           opening)
from .settings import LaserSettings

AFTER_NAK = 0.03        # s: so long a host waits before it sends a request again that came with a wrong CRC (sheet 1.2)
BACK_OFF = 1.0          # s from the end of one conversation to the beginning of the next
SILENT_SCANS = 5.0      # times the time from one scan to the next: a stream that is silent for longer has ended
SILENT_AT_LEAST = 1.0   # s
NOT_OURS = PowerOn, Resetting, VariantSet, ConfigurationWritten
"""Replies that change what the scans are. None of them is asked for while scans come."""
NOT_OURS_SAYS = "the laser begins anew, or another program has changed it"
SPEED_REQUESTS = [SetMode(speed.mode, b"") for speed in SPEEDS.values()]
ASK_AGAIN = 10.0        # s: a laser that sends scans is asked for its errors no sooner again, as its stream pauses then


class Measuring(NamedTuple):
    """The laser was found and configured, and its stream has begun."""

    info: LaserInfo


class ScanHeard(NamedTuple):
    """A scan.

    Attributes:
        scan: its values.
        info: of the laser.
        first_ray: when the laser fired the first ray (s, on the clock of `receive`).
        status: the laser's status byte.
    """

    scan: RawScan
    info: LaserInfo
    first_ray: float
    status: int


class LaserLost(NamedTuple):
    """There is no laser, or no more; the session looks for it again. `reason` is for people."""

    reason: str


Event = Union[Measuring, ScanHeard, LaserLost]


def fits(scan: RawScan, info: LaserInfo) -> bool:
    """Return whether a scan is one that this laser was told to send. Another program may have told it something else.
    """
    return len(scan.values) == info.variant.values and not scan.partial and scan.unit in METRES


class LaserCounts(NamedTuple):
    """Counters of a session, since it was made."""

    line: TelegramCounts
    scans: int
    malformed: int
    """Telegrams that arrived whole and make no sense, with scans that have another number of values than they should.
    """
    repeated: int
    """Requests that were sent again."""
    lost: int
    """How often a laser that measured was lost."""


class _Asked(NamedTuple):
    """When a laser that measures was last asked for its errors (s), and the severity that its status had then."""

    at: float
    severity: int


class LaserSession:
    """One laser on one line.

    Call `receive` with what was read, `tick` when `due` is over, and then carry out what `take_output` returns.
    """

    def __init__(self, settings: LaserSettings, has_speed: bool, now: float):
        """Begin to look for the laser.

        Args:
            settings: what is asked of it.
            has_speed: the line is a serial port or a pseudo-terminal, whose speed can be set; no socket.
            now: the time (s).
        """
        self._settings, self._has_speed = settings, has_speed
        self._decoder = TelegramDecoder(from_laser=True)
        self._output: List[Union[bytes, SetLineSpeed]] = []
        self._scans = self._malformed = self._repeated = self._lost = 0
        self._heard_at = now
        self._info: Optional[LaserInfo] = None
        self._asked: Optional[_Asked] = None    # None until the first scan
        self._laser_speeds: List[int] = []      # of the laser that was found (baud), the present one last
        self._conversation: Optional[Generator[Step, Any, Optional[LaserInfo]]] = None
        self._step: Optional[Step] = None
        self._tries = 0
        self.due = now
        """When `tick` must be called at the latest (s)."""
        self.closed = False
        """The laser was told to stop, or is gone: nothing more is to be done."""
        self._is_closing = False

    @property
    def counts(self) -> LaserCounts:
        """What was counted so far."""
        return LaserCounts(self._decoder.counts, self._scans, self._malformed, self._repeated, self._lost)

    @property
    def info(self) -> Optional[LaserInfo]:
        """The laser that measures now; None while there is none."""
        return self._info

    def take_output(self) -> List[Union[bytes, SetLineSpeed]]:
        """Return what is to be done now, in this order: write bytes, or set the speed of the port when all are sent."""
        output, self._output = self._output, []
        return output

    def receive(self, data: bytes, now: float) -> List[Event]:
        """Take in bytes that were read at some time (s), and return what they tell."""
        events: List[Event] = []
        self._heard_at = now
        found = self._decoder.feed(data)
        for each, end in zip(found, self._ends(found, now)):
            events += self._take_in(each, end, now)
        return events

    def _ends(self, found: Sequence[Union[Telegram, Answer]], now: float) -> List[float]:
        """Return when the last byte of each of these came (s), if the last byte of the line came just now.

        Before that one the line was busy all the time, but for the pauses of a stream, in which the laser measures.
        """
        if not found:
            return []
        info = self._info
        baud = self._settings.baud if info is None else info.baud
        scans_apart = 0.0 if info is None else info.scan_time
        ends: List[float] = []
        following = now - time_on_line(self._decoder.held_bytes, baud)      # when what comes next began
        for each in reversed(found):
            takes = time_on_line(each.length if isinstance(each, Telegram) else 1, baud)
            is_scan = isinstance(each, Telegram) and MESSAGES.get(each.command) is ScanReply
            pause = max(0.0, scans_apart - takes) if is_scan and following < now else 0.0
            ends.append(following - pause)
            following = ends[-1] - takes
        return ends[::-1]

    def tick(self, now: float) -> List[Event]:
        """Do what is due at some time (s)."""
        events: List[Event] = []
        if self._decoder.waiting and now - self._heard_at > PARTIAL_TIMEOUT:
            for each in self._decoder.drop_partial():
                events += self._take_in(each, now, now)
        if now < self.due or self.closed:
            return events
        if self._conversation is not None:
            return events + self._out_of_time(now)
        if self._info is not None:
            return events + self._fail(self._why_no_scans(now - self._heard_at), now)
        self._begin(opening(self._settings, self._has_speed), now)
        return events

    def close(self, now: float) -> None:
        """Tell the laser to stop, and to have the speed that it had before. Go on until `closed`.

        While it is just told another speed, nobody knows which one it has: its answer is waited for (`_do`).
        """
        self._info, self._is_closing = None, True
        if not (isinstance(self._step, Ask) and self._step.request in SPEED_REQUESTS):
            self._begin_closing(now)

    def _begin_closing(self, now: float) -> None:
        if self._laser_speeds:
            self._begin(closing(self._laser_speeds[0], self._laser_speeds[-1], self._has_speed), now)
        else:
            self._end()

    def line_broke(self, reason: str, now: float) -> List[Event]:
        """Begin anew on a new line, as the old one broke for some reason (for people)."""
        self._decoder.drop_partial()
        self._output.clear()
        return self._fail(reason, now)

    def _take_in(self, found: Union[Telegram, Answer], end: float, now: float) -> List[Event]:
        """Use an answer or a telegram whose last byte came at the time `end` (s)."""
        if isinstance(found, Answer):
            if isinstance(self._step, Ask) and found is Answer.NAK:
                self.due = min(self.due, now + AFTER_NAK)
            elif isinstance(self._step, Ask):
                self.due = max(self.due, now + self._step.heard)
                self._step = self._step._replace(heard=0.0)     # once: in noise there are many of these bytes
            return []
        message = decode(found)
        if isinstance(message, MalformedMessage):
            self._malformed += 1
            return []
        if isinstance(self._step, Ask) and isinstance(message, self._step.wanted):
            return self._go_on(message, now)
        if isinstance(message, ScanReply) and self._info is not None:
            if not fits(message.scan, self._info):
                self._malformed += 1
                return []
            return [self._scan(self._info, message.scan, found, end)]
        if isinstance(message, NOT_OURS) and self._info is not None and not self._is_closing:
            return self._fail(NOT_OURS_SAYS, now)
        return []

    def _scan(self, info: LaserInfo, scan: RawScan, telegram: Telegram, end: float) -> ScanHeard:
        """Use a scan whose last byte came at the time `end` (s)."""
        self._scans += 1
        status = WELL if telegram.status is None else telegram.status
        if self._conversation is None:
            self.due = end + self._silence(info)
            self._ask_for_errors(info, severity(status), end)
        first_byte = end - time_on_line(telegram.length, info.baud)
        return ScanHeard(scan, info, first_byte - first_ray_before_first_byte(info.variant), status)

    def _ask_for_errors(self, info: LaserInfo, told: int, now: float) -> None:
        """Ask the laser for its errors if its status tells another severity than when it was last asked."""
        if self._asked is None:
            self._asked = _Asked(-math.inf, told)
        elif told != self._asked.severity and now - self._asked.at >= ASK_AGAIN:
            self._asked = _Asked(now, told)
            self._begin(asking(info), now)

    def _silence(self, info: LaserInfo) -> float:
        """Return the time (s) without a scan after which a stream has ended."""
        return max(SILENT_AT_LEAST, SILENT_SCANS * info.scan_time)

    def _why_no_scans(self, silent: float) -> str:
        """Return why there are no scans, for people. `silent` is the time (s) since the last byte."""
        if silent < SILENT_AT_LEAST / 2.0:
            return "what comes is no scan: the cable, or another program has changed the speed of the laser"
        return "the laser is silent for %.1f s: its power, its cable or another program" % silent

    def _begin(self, conversation: Generator[Step, Any, Optional[LaserInfo]], now: float) -> None:
        self._conversation = conversation
        self._go_on(None, now)

    def _go_on(self, reply: Any, now: float) -> List[Event]:
        """Hand a reply to the conversation, and begin its next step."""
        conversation = self._conversation
        assert conversation is not None
        try:
            self._step = conversation.send(reply)
        except NoLaserError as error:
            return self._fail(str(error), now)
        except StopIteration as end:
            return self._over(end.value, now)
        self._tries = 0
        self._do(now)
        return []

    def _do(self, now: float) -> None:
        """Do the present step: once more, if it is a request that was not answered."""
        step = self._step
        if isinstance(step, SetLineSpeed):
            self._output.append(step)
            self.due = now
        elif isinstance(step, LaserSpeed):
            self._laser_speeds.append(step.baud)
            self.due = now
            if self._is_closing:
                self._begin_closing(now)
        elif isinstance(step, Pause):
            self.due = now + step.seconds
        elif isinstance(step, Ask):
            self._tries += 1
            self._output.append(encode(step.request))
            self.due = now + step.seconds

    def _out_of_time(self, now: float) -> List[Event]:
        step = self._step
        if isinstance(step, Ask) and self._tries < step.tries:
            self._repeated += 1
            self._do(now)
            return []
        return self._go_on(None, now)

    def _over(self, info: Optional[LaserInfo], now: float) -> List[Event]:
        """End a conversation: the laser measures, or told its errors, or was told to stop."""
        self._conversation = self._step = None
        if info is None:
            self._end()
            return []
        measured, self._info = self._info is not None, info
        self.due = now + self._silence(info)
        return [] if measured else [Measuring(info)]

    def _fail(self, reason: str, now: float) -> List[Event]:
        """End for now, and look for the laser again after a while."""
        self._lost += self._info is not None
        self._conversation = self._step = self._info = self._asked = None
        self._laser_speeds.clear()
        self.due = now + BACK_OFF
        if self._is_closing:
            self._end()
        return [LaserLost(reason)]

    def _end(self) -> None:
        """Do nothing more."""
        self._conversation = self._step = None
        self.closed, self.due = True, math.inf

"""The laser's side of its protocol, without I/O: it receives bytes, lets simulated time pass, and returns bytes.

>>> from pioneer_control.simulator.lms200 import Optics, standing
>>> from pioneer_control.simulator.world import load_world
>>> laser = LaserFirmware(Optics(load_world("empty")), standing((0.0, 0.0, 0.0)), FirmwareNumbers(boot=0.0))
>>> laser.advance(0.1)                                      # telegram 90: it is ready
b'\\x02\\x80\\x17\\x00\\x90LMS200;301063;V02.10 \\x10c^'
>>> laser.receive(bytes.fromhex("0200020020253508"))        # mode: on request
>>> laser.advance(0.1).hex()
'0602800300a00010160a'

This file uses no threads, no sockets and no real time. The same bytes at the same simulated times, with the same seed,
always give the same answer. It does not matter into how many calls the time is split.

How a request goes: when its last byte has come, it waits until all earlier ones are answered. Then the laser stops what
it streams, and sends ACK. When the time of `answers` has passed, it acts and sends the reply. When the reply has left,
it does what follows (a new speed, a reset), and takes the next request, or streams on.
"""

import random
from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import Callable, Deque, List, Optional, Union

from ...lms2xx import Answer, Mode, PartReply, PowerOn, ScanReply, Telegram, TelegramDecoder, decode, encode
from ..clock import NEVER_US, Clock
from .answers import AnswerOfLaser, AnswerRow, row_of
from .device import STREAMS, FirmwareNumbers, LaserDevice, Operation
from .optics import Optics, PoseAt
from .serial_output import SentBytes, SerialOutput

MOST_WAITING = 8
"""Number of requests that wait while the laser answers another one [inv]. It loses all further ones."""


@dataclass(frozen=True)
class _Work:
    """What the laser does next, and when (microseconds). It takes no request before."""

    due_us: int
    act: Callable[[], None]


class LaserFirmware:
    """A simulated laser with its serial line, but without I/O. It is switched on at the present time.

    Args:
        optics: what it measures with.
        pose_at: returns the pose of the laser (m, rad; map frame) at a simulated time (s).
        numbers: how it behaves.
        clock: clock of this laser alone: only the laser sets it. A new clock if None.
        address: its address, 0..127. It hears this one and 0.
        seed: seed of the requests that it misses.
        line_takes_time: whether its bytes take the time of a serial line. If not, they leave at once.
        fixed_baud: speed (baud) of its line, which then never changes, as behind a bridge to a network: the laser says
            that it takes another one, and stays. None: a client changes it.

    Attributes:
        numbers, clock: as the arguments.
        device: what the laser is and knows. A test may change its errors.
        ignored_bytes: number of bytes that came at another speed, or while the laser was not ready.
        missed_requests: number of requests that got no answer although they arrived whole.
    """

    def __init__(
        self, optics: Optics, pose_at: PoseAt, numbers: FirmwareNumbers = FirmwareNumbers(),
        clock: Optional[Clock] = None, address: int = 0, seed: Union[int, str] = 0, line_takes_time: bool = True,
        fixed_baud: Optional[int] = None,
    ):
        self.numbers, self.clock = numbers, clock or Clock()
        self.device = LaserDevice(optics, pose_at, self.clock, numbers, address, fixed_baud)
        self.ignored_bytes = self.missed_requests = 0
        self._chance = random.Random("laser line %s" % seed)
        self._output = SerialOutput(line_takes_time)
        self._forget()
        self.power_on()

    # -- power

    @property
    def baud(self) -> int:
        """The present speed of the serial line (baud). Off, or while it starts: that with which it will be ready."""
        return self.device.baud

    @property
    def is_ready(self) -> bool:
        """Whether the laser hears requests."""
        return self.device.operation is not None

    def power_on(self) -> None:
        """Switch the laser on. It hears nothing, until it sends telegram 90 after `FirmwareNumbers.boot` seconds.

        Nothing happens if it is on.
        """
        if self.is_ready or self._work is not None:
            return
        self.device.baud = self.device.power_on_baud
        self._plan(self.clock.now_us + round(self.numbers.boot * 1e6), self._become_ready)

    def power_off(self) -> None:
        """Switch the laser off at once. It keeps only its EEPROM."""
        self._forget()
        self.device.baud = self.device.power_on_baud

    def _forget(self) -> None:
        self.device.operation = None
        self._work: Optional[_Work] = None
        self._decoder = TelegramDecoder(from_laser=False)
        self._waiting: Deque[Telegram] = deque()
        self._last_byte_us = 0
        self._output.cut(self.clock.now_us)

    def _become_ready(self) -> None:
        now_us = self.clock.now_us
        self.device.operation = Operation(now_us, since_us=now_us)
        self._send(PowerOn(self.numbers.identity.encode("ascii")))
        self._plan(self._output.free_at_us(now_us), self._take_next)

    def _reset(self) -> None:
        self._forget()
        self.power_on()

    # -- bytes in

    def receive(self, data: bytes, baud: Optional[int] = None) -> None:
        """Receive bytes from the client, at the present simulated time. A telegram may be split over several calls.

        Args:
            data: any bytes.
            baud: speed at which they were sent. None over TCP or a pseudo-terminal, where there is none. Bytes of
                another speed than the laser's are noise: it understands nothing.
        """
        if not self.is_ready or baud not in (None, self.baud):
            self.ignored_bytes += len(data)
            self._decoder = TelegramDecoder(from_laser=False)
            return
        longest = self.numbers.longest_gap_elsewhere if baud is None else self.numbers.longest_gap
        if self._decoder.waiting and self.clock.now_us - self._last_byte_us > longest * 1e6:
            self._decoder = TelegramDecoder(from_laser=False)
        self._last_byte_us = self.clock.now_us
        for byte in data:
            self._hear(bytes((byte,)))

    def _hear(self, byte: bytes) -> None:
        """Receive one byte. A telegram with a wrong CRC gets NAK, and is forgotten whole: what looks like the start of
        another one inside it must not swallow the next request. Its address may be what is wrong, so it counts not.
        """
        wrong = self._decoder.counts.wrong_crcs
        found = self._decoder.feed(byte)
        for telegram in found:
            if isinstance(telegram, Telegram) and telegram.address in (0, self.device.address):
                self._accept(telegram)
        if not found and self._decoder.counts.wrong_crcs > wrong:
            self._decoder = TelegramDecoder(from_laser=False)
            self._stop_stream()
            self._output.put(bytes((Answer.NAK.value,)), self.baud, self.clock.now_us)

    def _accept(self, telegram: Telegram) -> None:
        """Take a request now, or let it wait."""
        misses = self._streams and self._chance.random() < self.numbers.missed
        if misses or len(self._waiting) >= MOST_WAITING:
            self.missed_requests += 1
            return
        self._waiting.append(telegram)
        if self._work is None:
            self._take_next()

    @property
    def _streams(self) -> bool:
        """Whether the laser streams, and nothing else."""
        operation = self.device.operation
        return self._work is None and operation is not None and operation.mode in STREAMS

    def _stop_stream(self) -> None:
        """Drop what has not left of a streamed scan. A reply is never dropped."""
        if self._work is None:
            self._output.cut(self.clock.now_us)

    # -- answers

    def _take_next(self) -> None:
        """Take the next request, if there is one."""
        self._work = None
        if self._waiting:
            self._stop_stream()
            self._output.put(bytes((Answer.ACK.value,)), self.baud, self.clock.now_us)
            request = decode(self._waiting.popleft())
            row = row_of(request)
            takes_us = round(getattr(self.numbers, row.takes) * 1e6)
            self._plan(self.clock.now_us + takes_us, partial(self._answer, row, request))

    def _answer(self, row: AnswerRow, request: object) -> None:
        assert self.device.operation is not None
        answer = row.act(self.device, self.device.operation, request)
        self._send(answer.reply)
        self._plan(self._output.free_at_us(self.clock.now_us), partial(self._follow, answer))

    def _follow(self, answer: AnswerOfLaser) -> None:
        """Do what follows a reply that has left."""
        if answer.resets:
            self._reset()
            return
        self.device.baud = self.device.fixed_baud or answer.new_baud or self.device.baud
        self._take_next()

    def _send(self, message: object) -> None:
        self._output.put(encode(message, self.device.status, self.device.address), self.baud, self.clock.now_us)

    def _plan(self, due_us: int, act: Callable[[], None]) -> None:
        self._work = _Work(due_us, act)

    # -- time

    def advance(self, seconds: float) -> bytes:
        """Let simulated time pass, for a laser that is alone on its clock.

        Args:
            seconds: duration, at least 0. A fraction of a microsecond is kept, and added in the next call.

        Returns:
            All bytes that have left since the last call. In a given time no more bytes leave than the line carries.
        """
        self.run_to(self.clock.after(seconds))
        return self.take_sent()

    def take_sent(self) -> bytes:
        """Return all bytes that have left since the last call."""
        return b"".join(sent.data for sent in self.take_sent_with_speeds())

    def take_sent_with_speeds(self) -> List[SentBytes]:
        """Return all bytes that have left since the last call, each piece with the speed at which it was sent."""
        return self._output.take(self.clock.now_us)

    @property
    def next_event_us(self) -> int:
        """The time of the laser's next action (microseconds); `NEVER_US` if it only waits for requests, or is off."""
        if self._work is not None:
            return self._work.due_us
        operation = self.device.operation
        return operation.next_turn_us(self.clock.now_us) if operation is not None else NEVER_US

    @property
    def sent_at_us(self) -> int:
        """The time (microseconds) at which all bytes that are on their way will have left; `NEVER_US` if none are."""
        free_us = self._output.free_at_us(self.clock.now_us)
        return free_us if free_us > self.clock.now_us else NEVER_US

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us` (microseconds)."""
        while self.next_event_us <= end_us:
            self.clock.now_us = self.next_event_us
            if self._work is not None:
                self._work.act()
            else:
                self._end_turn()
        self.clock.now_us = end_us

    def _end_turn(self) -> None:
        """Send the scan that is complete at the end of this turn. It is lost while the line is busy."""
        operation, now_us = self.device.operation, self.clock.now_us
        assert operation is not None
        turn = operation.turns_ended(now_us)
        turns = 1 if operation.mode == Mode.STREAM_OF_PARTIAL_SCANS else operation.variant.turns
        began_us = operation.turn_end_us(turn - turns)
        if turn % turns or began_us < operation.since_us or self._output.free_at_us(now_us) > now_us:
            return
        if operation.mode == Mode.STREAM_OF_PARTIAL_SCANS:
            self._send(ScanReply(self.device.partial_scan(operation, turn)))
        elif operation.mode == Mode.STREAM_OF_A_PART:
            scan = self.device.scan(operation, turn, operation.part)
            self._send(PartReply(operation.part.start + 1, operation.part.stop, scan))
        else:
            self._send(ScanReply(self.device.scan(operation, turn)))

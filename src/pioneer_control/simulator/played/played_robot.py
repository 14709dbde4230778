"""A robot that plays back a recording: it sends to a new client what the recorded robot sent. A `Server` can use it in
place of a `Firmware`.

The recording is played at its original speed. It waits for the client in only one case: where the recorded robot
answered SYNC0, SYNC1, SYNC2 or OPEN, the client must first send the same packet. So the client connects as often as
the recorded client did. When the client ends its session, playback continues after the end of the recorded session. If
the client sends other commands than the recorded client, this is reported once for each connection, but has no effect.

For the format of a recording see `p2os.recording`. This file uses no threads, no sockets and no real time.
"""

import itertools
from collections import Counter
from typing import Callable, Counter as CounterType, Dict, Iterable, List, NamedTuple, Optional

from ... import p2os
from ...errors import UsageError
from ...p2os import SYNC0, SYNC2, Frame, FrameDecoder, ReceivedCommand
from ...p2os.recording import Entry
from ..clock import NEVER_US, Clock
from ..firmware import FirmwareState, RobotOnLine

OPEN = 3
"""Number of the stage of a connection that follows SYNC0, SYNC1 and SYNC2."""
IDS = (0, 1, 2, 1)
"""Command numbers for which the stages SYNC0, SYNC1, SYNC2 and OPEN wait."""
HOST_BAUD = 9600
STEP_US = 5000
"""Longest time between two steps of a played robot (microseconds)."""


class RecordedStep(NamedTuple):
    """One step of a recording: bytes of the robot, or a command of its client, at a recorded time (microseconds)."""

    time_us: int
    data: bytes = b""
    command: Optional[ReceivedCommand] = None
    stage: Optional[int] = None
    """The stage SYNC0, SYNC1, SYNC2 or OPEN, if this is a command of the client that the robot answered.

    Playback waits here until the client sends the same command. None for all other steps.
    """

    @property
    def ends_session(self) -> bool:
        """Whether this step is a CLOSE with which the client ended its session.

        SYNC2 has the same command number as CLOSE, but it has a stage.
        """
        return self.stage is None and self.command is not None and self.command.name == "CLOSE"


class PlayedRobot(RobotOnLine):
    """A robot that plays back one robot of a recording.

    Args:
        entries: entries of the recording.
        robot: number of the robot in the recording (from 1).
        say: function that is called when the client differs from the recorded client, with the time in the recording
            (s) and a sentence.

    Raises:
        UsageError: the recording does not have this robot, or has no beginning of a connection with it.
    """

    line_takes_time = False
    """The line adds no delay, also on a terminal, because the recorded times already include the delay."""

    def __init__(
        self, entries: Iterable[Entry], robot: int = 1, say: Callable[[float, str], None] = lambda time, sentence: None,
    ):
        self.steps = steps_of(entries, robot)
        if not any(step.stage == OPEN for step in self.steps):
            raise UsageError("no connection begins in the record of robot %d: no client could connect to it. Recorder"
                             " first, then the driver" % robot)
        self._last = max(at for at, step in enumerate(self.steps) if step.data)
        super().__init__("robot %s" % robot, Clock(), HOST_BAUD)
        if self.steps[0].data:      # the recording begins in an open session
            self.session = FirmwareState.OPEN
        self._say = say
        self._at = 0
        self._lag_us = -self.steps[0].time_us       # simulated time minus recorded time
        self._decoder = FrameDecoder()
        self._end_reported = False
        # Commands of the recorded client that are to come in this connection; None after the client has differed.
        self._expected: Optional[List[ReceivedCommand]] = None
        self._counts: CounterType[str] = Counter()      # of each command: recorded minus received
        self.next_step_us = min(self.next_sip_us, STEP_US)

    @property
    def over(self) -> bool:
        """Whether the recording has no more bytes of the robot."""
        return self._at > self._last

    @property
    def next_sip_us(self) -> int:
        """The simulated time (microseconds) at which the robot next sends bytes without a request.

        `NEVER_US` while the playback waits for the client, or when the recording is over.
        """
        for at in range(self._at, len(self.steps)):
            if self.steps[at].stage is not None:
                break
            if self.steps[at].data:
                return self.steps[at].time_us + self._lag_us
        return NEVER_US

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us` (microseconds), and send the bytes that were recorded in this time."""
        while self._at < len(self.steps):
            step = self.steps[self._at]
            if step.stage is not None or step.time_us + self._lag_us > end_us:
                break
            self._sent.append(step.data)
            self._at += 1
        self.clock.now_us = end_us
        if self.over and not self._end_reported:
            self._end_reported = True
            self._report("the record is over: the robot says nothing more")
        self.next_step_us = min(self.next_sip_us, end_us + STEP_US)

    def receive(self, data: bytes) -> None:
        """Receive bytes from the client: connect it, or compare its commands with those of the recorded client."""
        for frame in self._decoder.feed(data):
            if self.session is FirmwareState.OPEN:
                self._compare(p2os.decode_command(frame))
            elif frame.id in IDS:
                self._connect(frame.id)
        self.run_to(self.clock.now_us)

    def close_session(self) -> None:
        """End the client's session, and continue the playback after the end of the recorded session.

        If no client has sent any packet yet, restart the playback at its beginning.
        """
        if not self._decoder.counts.frames:     # no client has sent a packet
            self._go_to(0)
            return
        self.session, self.baud = FirmwareState.WAITING, HOST_BAUD
        self.closed_sessions += 1
        # commands that came more or less often than in the recording
        counts = ["%s %+d" % (name, -count) for name, count in sorted(self._counts.items()) if count]
        if counts:
            self._report("in this connection the client sent, against that of the record: %s" % ", ".join(counts))
        self._counts.clear()
        ahead = [(at, self.steps[at]) for at in range(self._at, len(self.steps))]
        behind = (at + 1 if step.ends_session else at for at, step in ahead if step.ends_session or step.stage == SYNC0)
        self._go_to(next(behind, len(self.steps)))

    # -- the record

    def _go_to(self, at: int) -> None:
        """Continue the playback now, at step number `at`."""
        self._at = at
        self._lag_us = self.clock.now_us - self.steps[max(0, at - 1)].time_us

    def _connect(self, number: int) -> None:
        """Process SYNC0, SYNC1, SYNC2 or OPEN of the client. They are answered in the order of the recording.

        A packet out of order is not answered, with two exceptions. The client may restart the handshake with SYNC0. And
        the client may send OPEN directly after an answer to SYNC2, even if the recorded client sent more packets before
        its OPEN. Then the playback continues at the recorded OPEN.

        Args:
            number: command number of the packet.
        """
        stages = [(at, step.stage) for at, step in enumerate(self.steps) if step.stage is not None]
        before = [each for each in stages if each[0] < self._at]
        ahead = stages[len(before):]
        fits = bool(ahead) and number == IDS[ahead[0][1]]
        places: List[int] = []
        if fits:
            places = [ahead[0][0]]
        elif number == SYNC0 and ahead:
            places = [at for at, stage in before if stage == SYNC0][-1:]
        elif number == IDS[OPEN] and before and before[-1][1] == SYNC2:
            places = [at for at, stage in ahead if stage == OPEN]
        if not places:
            return
        at = places[0]
        if fits and number != SYNC0:
            self._sent += [step.data for step in self.steps[self._at:at]]
        self._go_to(at + 1)
        if self.steps[at].stage == OPEN:
            self.session = FirmwareState.OPEN
            connection = itertools.takewhile(
                lambda step: step.stage is None and not step.ends_session, self.steps[at + 1:])
            self._expected = [step.command for step in connection if step.command and not _is_question(step.command)]
            self._counts = Counter(command.name for command in self._expected)

    def _compare(self, command: ReceivedCommand) -> None:
        """Compare a command of an open session with the next recorded command, and report the first difference.

        CLOSE ends the session, and HOSTBAUD changes the baud rate.
        """
        if command.name == "CLOSE":
            self.close_session()
            return
        if _is_question(command):
            return
        if command.name == "HOSTBAUD" and isinstance(command.value, int) and 0 <= command.value < len(p2os.BAUD_RATES):
            self.baud = p2os.BAUD_RATES[command.value]
        self._counts[command.name] -= 1
        if self._expected is not None and (not self._expected or self._expected.pop(0) != command):
            self._expected = None
            told = command.name if command.value is None else "%s %s" % (command.name, str(command.value))
            self._report("here the client sends %s, and that of the record did not" % told)

    def _report(self, sentence: str) -> None:
        self._say((self.clock.now_us - self._lag_us) * 1e-6, sentence)


def steps_of(entries: Iterable[Entry], robot: int) -> List[RecordedStep]:
    """Return the steps of one robot in a recording. Commands that the robot answered during a handshake have a stage.

    Args:
        entries: entries of the recording.
        robot: number of the robot in the recording (from 1).

    Raises:
        UsageError: the recording has no bytes of this robot.
    """
    steps: List[RecordedStep] = []
    ears = {True: FrameDecoder(), False: FrameDecoder()}
    # The step with the client's last command for each stage. For OPEN: its first command after the answer to SYNC2.
    asked: Dict[Optional[int], int] = {}
    synced = False
    time_us = -NEVER_US
    for entry in [entry for entry in entries if entry.robot == robot and not entry.note]:
        time_us = max(time_us, round(entry.time * 1e6))     # if a clock jumped back, keep the order of the entries
        for frame in ears[entry.to_robot].feed(entry.data):
            stage = None if entry.to_robot else _stage_answered(frame)
            if entry.to_robot:
                if synced and frame.id == IDS[OPEN]:
                    asked.setdefault(OPEN, len(steps))
                if frame.id in IDS:
                    asked[frame.id] = len(steps)
                steps.append(RecordedStep(time_us, command=p2os.decode_command(frame)))
            elif stage in asked:
                steps[asked[stage]] = steps[asked[stage]]._replace(stage=stage)
                synced = stage == SYNC2
                asked.clear()
        if not entry.to_robot:
            steps.append(RecordedStep(time_us, entry.data))
    if not any(step.data for step in steps):
        raise UsageError("the record has nothing that a robot %s said" % robot)
    return steps


def _stage_answered(frame: Frame) -> Optional[int]:
    """Return the stage SYNC0, SYNC1, SYNC2 or OPEN that a packet of the robot answers. None for all other packets."""
    packet = p2os.decode_packet(frame)
    if isinstance(packet, p2os.SyncEcho):
        return packet.number
    return {p2os.SyncReply: SYNC2, p2os.Sip: OPEN}.get(type(packet))


def _is_question(command: ReceivedCommand) -> bool:
    """Return whether a command is ENCODER 1, with which a client checks the connection (see `client.link_check`).

    Such commands are not compared, because their times differ from run to run.
    """
    return command.name == "ENCODER" and command.value == 1

"""A recorded robot, for a `Server` in place of a `Firmware`: it says to a client of today what it said then.

The record is played at the pace at which it was made. It waits for the client in one case only: where the robot
answered to SYNC0, SYNC1, SYNC2 or OPEN, the client has to send the same first. So every connection of the record is one
of the client, too. When the client ends its session, the record goes on behind the end of the recorded session. Where
the client sends something else than the recorded client did, it is said once in each connection, and changes nothing.

The format of a record is in `p2os.recording`. No thread, clock of the computer or socket is in here.
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
"""The stage of a connection behind SYNC0, SYNC1 and SYNC2."""
IDS = (0, 1, 2, 1)
"""Of the command that each stage waits for."""
HOST_BAUD = 9600
STEP_US = 5000
"""At least this often it is looked whether something is due."""


class RecordedStep(NamedTuple):
    """Something of the record, microseconds after its beginning: bytes of the robot, or a packet of its client."""

    time_us: int
    data: bytes = b""
    command: Optional[ReceivedCommand] = None
    stage: Optional[int] = None
    """SYNC0, SYNC1, SYNC2 or OPEN, where the robot answered to that: the record waits here."""

    @property
    def ends_session(self) -> bool:
        """Whether the client ended its session here. A SYNC2 has the number of CLOSE, too."""
        return self.stage is None and self.command is not None and self.command.name == "CLOSE"


class PlayedRobot(RobotOnLine):
    """One robot of a record.

    Args:
        entries: of the record.
        robot: its number in there (from 1).
        say: told what the client does otherwise than that of the record: seconds of the record, and a sentence.

    Raises:
        UsageError: the record has no such robot, or no beginning of a connection, so that no client could connect.
    """

    line_takes_time = False
    """On a terminal, too: the record's times have it in them."""

    def __init__(
        self, entries: Iterable[Entry], robot: int = 1, say: Callable[[float, str], None] = lambda time, sentence: None,
    ):
        self.steps = steps_of(entries, robot)
        if not any(step.stage == OPEN for step in self.steps):
            raise UsageError("no connection begins in the record of robot %d: no client could connect to it. Recorder"
                             " first, then the driver" % robot)
        self._last = max(at for at, step in enumerate(self.steps) if step.data)
        super().__init__("robot %s" % robot, Clock(), HOST_BAUD)
        if self.steps[0].data:      # it was left open, and streams from the start
            self.session = FirmwareState.OPEN
        self._say = say
        self._at = 0
        self._lag_us = -self.steps[0].time_us       # how much later it is played
        self._decoder = FrameDecoder()
        self._over_told = False
        # Commands of the client, in this connection; None once it did otherwise.
        self._expected: Optional[List[ReceivedCommand]] = None
        self._counts: CounterType[str] = Counter()      # of commands: the record's less the client's
        self.next_step_us = min(self.next_sip_us, STEP_US)

    @property
    def over(self) -> bool:
        """Whether the record has nothing more that the robot said."""
        return self._at > self._last

    @property
    def next_sip_us(self) -> int:
        """When it next says something by itself; never while it waits for the client."""
        for at in range(self._at, len(self.steps)):
            if self.steps[at].stage is not None:
                break
            if self.steps[at].data:
                return self.steps[at].time_us + self._lag_us
        return NEVER_US

    def run_to(self, end_us: int) -> None:
        """Let time pass until `end_us`, and say what was said then meanwhile."""
        while self._at < len(self.steps):
            step = self.steps[self._at]
            if step.stage is not None or step.time_us + self._lag_us > end_us:
                break
            self._sent.append(step.data)
            self._at += 1
        self.clock.now_us = end_us
        if self.over and not self._over_told:
            self._over_told = True
            self._tell("the record is over: the robot says nothing more")
        self.next_step_us = min(self.next_sip_us, end_us + STEP_US)

    def receive(self, data: bytes) -> None:
        """Take bytes of the client."""
        for frame in self._decoder.feed(data):
            if self.session is FirmwareState.OPEN:
                self._compare(p2os.decode_command(frame))
            elif frame.id in IDS:
                self._connect(frame.id)
        self.run_to(self.clock.now_us)

    def close_session(self) -> None:
        """The client ended its session, or another one has come: go on behind the record's own end of it."""
        if not self._decoder.counts.frames:     # no client has said anything
            self._go_to(0)
            return
        self.session, self.baud = FirmwareState.WAITING, HOST_BAUD
        self.closed_sessions += 1
        # which commands came more or less often than in the record
        counts = ["%s %+d" % (name, -count) for name, count in sorted(self._counts.items()) if count]
        if counts:
            self._tell("in this connection the client sent, against that of the record: %s" % ", ".join(counts))
        self._counts.clear()
        ahead = [(at, self.steps[at]) for at in range(self._at, len(self.steps))]
        behind = (at + 1 if step.ends_session else at for at, step in ahead if step.ends_session or step.stage == SYNC0)
        self._go_to(next(behind, len(self.steps)))

    # -- the record

    def _go_to(self, at: int) -> None:
        """Go on with a step of the record now."""
        self._at = at
        self._lag_us = self.clock.now_us - self.steps[max(0, at - 1)].time_us

    def _connect(self, number: int) -> None:
        """Take SYNC0, SYNC1, SYNC2 or OPEN, in the order of the record. What is out of order is not answered, as then.

        Two things are let pass. The client may begin the connection again. And it may send OPEN after an answer to
        SYNC2 that the record's client had not heard: then the record goes on at the OPEN that came later.
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
        """Compare a command of an open session with the record's."""
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
            self._tell("here the client sends %s, and that of the record did not" % told)

    def _tell(self, sentence: str) -> None:
        self._say((self.clock.now_us - self._lag_us) * 1e-6, sentence)


def steps_of(entries: Iterable[Entry], robot: int) -> List[RecordedStep]:
    """The steps of one robot in a record, with the places where the robot answered to a connection.

    Raises:
        UsageError: it has nothing of it.
    """
    steps: List[RecordedStep] = []
    ears = {True: FrameDecoder(), False: FrameDecoder()}
    # The step in which the client last asked for each stage. For OPEN: in which it first did, once SYNC2 was answered.
    asked: Dict[Optional[int], int] = {}
    synced = False
    time_us = -NEVER_US
    for entry in [entry for entry in entries if entry.robot == robot and not entry.note]:
        time_us = max(time_us, round(entry.time * 1e6))     # the order counts where a clock jumped back
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
    """Which stage of a connection a packet of the robot answers; None for any other."""
    packet = p2os.decode_packet(frame)
    if isinstance(packet, p2os.SyncEcho):
        return packet.number
    return {p2os.SyncReply: SYNC2, p2os.Sip: OPEN}.get(type(packet))


def _is_question(command: ReceivedCommand) -> bool:
    """ENCODER 1: asked only to see whether it arrives (client.link_check), at moments that differ from run to run."""
    return command.name == "ENCODER" and command.value == 1

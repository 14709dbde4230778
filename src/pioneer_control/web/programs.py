"""The programs that share robots with persons: who gets which robot, and bytes both ways. Pure: time is an argument.

A program comes through the web server, over a WebSocket, with the key of one robot. `Programs` gives it a line to this
robot (`program_line`), which the helm goes before.

==========================  ===========================================================================================
what                        rule
==========================  ===========================================================================================
key                         one for each robot, made here. Only persons who may drive the robot are told it
two programs of one robot   the newer one has it, the older one is closed. Within SETTLES s the newer one is refused: so
                            two programs that both connect again and again do not take turns faster
server silent               what programs drive stops
server silent for long,     all lines end, at once
or gone
sentences for people        at most SENTENCES a second for each program
==========================  ===========================================================================================
"""

import functools
import hmac
import math
import secrets
from collections import deque
from typing import Callable, Deque, Dict, List, NamedTuple, Optional, Protocol

from ..p2os import Frame, FrameDecoder
from .backend import Rules
from .exchange import Outbox
from .guard import NO_ROBOT, REPLACED, WRONG_KEY, Allowance, Farewell

SETTLES = 1.0           # s after a program has got a robot in which no other one takes it
SENTENCES = 3           # a second
MOST_HEARD = 200        # pieces that a robot sent: many seconds
CONFIG = 0x20
"""The id of the packet CONFIGpac."""


class RobotSide(Protocol):
    """The robot's side of the line to a program: see program_line.ProgramLine."""

    def data_to_send(self) -> bytes:
        """Return the bytes for the program, and forget them."""

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes of the program."""

    def report(self, frame: Frame) -> None:
        """Take a packet of the robot."""

    def tick(self, now: float) -> None:
        """Do what is due."""

    @property
    def due(self) -> float:
        """Time by which tick() must be called."""

    def halt(self) -> None:
        """Stop what the program drives; it may command anew."""

    def end(self) -> None:
        """The program is gone."""


class Wire:
    """What a robot sends, on its way from the threads of its link to that of the owner.

    Args:
        wake: called when a program waits for this. Any thread calls it, with the lock of the link.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self.is_awaited = False
        """Whether a program waits for what the robot sends."""
        self.config: Optional[Frame] = None
        """The newest CONFIGpac."""
        self._wake = wake
        self._heard: Deque[bytes] = deque(maxlen=MOST_HEARD)
        self._decoder = FrameDecoder()

    def take(self, to_robot: bool, data: bytes) -> None:
        """Take bytes of the line, as Robot gives them to on_wire. Those to the robot are of no use here."""
        if not to_robot:
            self._heard.append(data)
            if self.is_awaited:
                self._wake()

    def frames(self) -> List[Frame]:
        """Return the packets that are new."""
        found: List[Frame] = []
        while self._heard:
            found += self._decoder.feed(self._heard.popleft())
        for frame in found:
            if frame.id == CONFIG:
                self.config = frame
        return found


class Program(NamedTuple):
    """A program that has a robot."""

    number: int
    """The number that the server gave its connection."""
    line: RobotSide
    since: float


class SharedRobot:
    """One robot for programs.

    Args:
        name: returns the robot's name.
        wire: has what the robot sends.
        open_line: makes the line to a program. Arguments: who it belongs to, and what takes sentences for people.
    """

    def __init__(self, name: Callable[[], str], wire: Wire,
                 open_line: Callable[[str, Callable[[str], None]], RobotSide]) -> None:
        self.name, self.wire, self.open_line = name, wire, open_line
        self.key = secrets.token_urlsafe(16)
        self.program: Optional[Program] = None


class Programs:
    """All programs, and the robots that they may have. One thread may use it.

    Args:
        outbox: the way to the server.
    """

    def __init__(self, outbox: Outbox) -> None:
        self._outbox = outbox
        self._shared: Dict[int, SharedRobot] = {}
        self._robots: Dict[int, int] = {}   # the robot of each program, by the number of its connection
        self._now = 0.0

    def add(self, robot: int, shared: SharedRobot, rules: Rules) -> None:
        """Let programs have a robot, and tell its key to those who may drive it."""
        self._shared[robot] = shared
        self.tell_key(robot, rules)

    def tell_key(self, robot: int, rules: Rules) -> None:
        """Tell the key of a robot to those who may drive it."""
        for to in rules.audience(robot):
            self._outbox.text("program", {"robot": robot, "path": "/robot/%d" % robot,
                                          "key": self._shared[robot].key}, robot, to=to)

    def change_key(self, robot: int) -> None:
        """Make a new key for a robot. A program with the old one loses the robot."""
        shared = self._shared[robot]
        shared.key = secrets.token_urlsafe(16)
        self._end(shared, Farewell(WRONG_KEY, "this robot has a new key: the page shows it to who may drive the robot"))

    # What the server says

    def join(self, number: int, robot: Optional[int], key: str, rules: Rules, now: float) -> None:
        """A program asks for a robot: give it, or say why not."""
        self._now = now
        shared = None if robot is None else self._shared.get(robot)
        if robot is None or shared is None:
            self._outbox.close_program(number, Farewell(NO_ROBOT, "there is no such robot; there are: %s" % (
                _ranges(list(self._shared)) or "none for programs")))
        elif not hmac.compare_digest(key.encode("utf-8", "surrogatepass"), shared.key.encode()):
            self._outbox.close_program(number, Farewell(
                WRONG_KEY, "the key of robot %d is another one: the page shows it to who may drive the robot" % robot))
        elif shared.program is not None and now - shared.program.since < SETTLES:
            self._outbox.close_program(number, Farewell(
                REPLACED, "another program has just got this robot: let only one run"))
        else:
            self._end(shared, Farewell(REPLACED, "another program has got this robot with the same key"))
            line = shared.open_line(rules.who(robot), self._rationed(functools.partial(self._say, robot, rules)))
            if shared.wire.config is not None:
                line.report(shared.wire.config)
            shared.program = Program(number, line, now)
            shared.wire.is_awaited = True
            self._robots[number] = robot
            self._outbox.open_program(number, shared.name())

    def receive(self, number: int, data: bytes, now: float) -> None:
        """Take bytes of a program. Those of a program whose line has ended are thrown away."""
        self._now = now
        if number in self._robots:
            program = self._shared[self._robots[number]].program
            if program is not None:
                program.line.receive(data, now)
                self._send(program)

    def gone(self, number: int) -> None:
        """The connection of a program is gone. An unknown one is no error."""
        if number in self._robots:
            self._end(self._shared[self._robots[number]], None)

    def halt(self, robot: Optional[int] = None) -> None:
        """Stop what programs drive, of a robot or of all (None): the server is silent, or the robots are carried. They
        may command anew.
        """
        for number, shared in self._shared.items():
            if shared.program is not None and robot in (None, number):
                shared.program.line.halt()

    def lost(self, reason: str) -> None:
        """End all lines: the server is gone, or as good as gone."""
        for shared in self._shared.values():
            self._end(shared, Farewell(NO_ROBOT, reason))

    # Each turn

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which turn() must be called."""
        return min((shared.program.line.due for shared in self._shared.values() if shared.program is not None),
                   default=math.inf)

    def turn(self, now: float) -> None:
        """Do what is due, and give programs what their robots sent."""
        self._now = now
        for shared in self._shared.values():
            frames, program = shared.wire.frames(), shared.program
            if program is None:
                continue
            for frame in frames:
                program.line.report(frame)
            program.line.tick(now)
            self._send(program)

    def _say(self, robot: int, rules: Rules, text: str) -> None:
        self._outbox.said("warn", text, robot, rules.viewers(robot))

    def _send(self, program: Program) -> None:
        data = program.line.data_to_send()
        if data:
            self._outbox.program_bytes(program.number, data)

    def _end(self, shared: SharedRobot, farewell: Optional[Farewell]) -> None:
        """End the program of a robot if there is one. ``farewell``: why; None when its connection is gone."""
        program, shared.program, shared.wire.is_awaited = shared.program, None, False
        if program is not None:
            program.line.end()
            del self._robots[program.number]
            if farewell is not None:
                self._outbox.close_program(program.number, farewell)

    def _rationed(self, say: Callable[[str], None]) -> Callable[[str], None]:
        """Return a function that says SENTENCES a second at most, and throws the others away."""
        allowance = Allowance(SENTENCES, self._now)

        def ration(text: str) -> None:
            if allowance.spends(1, self._now):
                say(text)
        return ration


def _ranges(numbers: List[int]) -> str:
    """Return whole numbers for people: "1 to 30", or "1, 3"."""
    low, high = min(numbers, default=0), max(numbers, default=-1)
    return "%d to %d" % (low, high) if len(numbers) == high - low + 1 > 2 else ", ".join(map(str, numbers))

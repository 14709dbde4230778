"""Programs that share robots: keys, one program a robot, the newest wins, and what is silent ends."""

import json
import math

import pytest

from pioneer_control.p2os import FrameDecoder, encode_frame
from pioneer_control.web.backend import Everybody
from pioneer_control.web.exchange import BYTES, CLOSED, OPENED, TEXT, Outbox, Unpacker, bytes_of
from pioneer_control.web.guard import MOST_BYTES, MOST_MESSAGES, MOST_PACKETS, Allowance, ProgramLimits
from pioneer_control.web.programs import SENTENCES, SETTLES, SharedRobot, Programs, Wire


class Pipe(Outbox):
    """The way to the server, which keeps what goes over it."""

    def __init__(self):
        super().__init__()
        self.closed, self.opened, self.data, self.keys, self.sentences = {}, {}, {}, [], []
        self.connect(self, [])
        self.unpacker = Unpacker()

    def send(self, data):
        for kind, contents in getattr(self, "unpacker", Unpacker()).take(data):
            if kind == BYTES:
                number, piece = bytes_of(contents)
                self.data[number] = self.data.get(number, b"") + piece
                continue
            value = json.loads(contents.decode())
            if kind == OPENED:
                self.opened[value["program"]] = value["robot"]
            elif kind == CLOSED:
                self.closed[value["program"]] = (value["code"], value["reason"])
            elif kind == TEXT and value["kind"] == "program":
                self.keys.append((value["to"], value["value"]))
            else:
                self.sentences.append(value)
        return len(data)


class FakeLine:
    """The robot's side of a line: it echoes, and says what it is told to refuse."""

    due = 7.0

    def __init__(self, who, say):
        self.who, self.say = who, say
        self.halted = False
        self.heard, self.frames, self.ended, self.ticks = b"", [], 0, []
        self._out = b""

    def data_to_send(self):
        data, self._out = self._out, b""
        return data

    def receive(self, data, now):
        self.heard += data
        self._out += data.upper()

    def report(self, frame):
        self.frames.append(frame.id)

    def tick(self, now):
        self.ticks.append(now)

    def halt(self):
        self.halted = True

    def end(self):
        self.ended += 1


class School:
    """Two robots, 7 and 8, their wires, and the lines that were opened."""

    def __init__(self):
        self.pipe, self.rules, self.lines, self.woken = Pipe(), Everybody(), [], []
        self.programs = Programs(self.pipe)
        self.wires = {number: Wire(lambda: self.woken.append(1)) for number in (7, 8)}
        for number, wire in self.wires.items():
            self.programs.add(number, SharedRobot(lambda: "rosie", wire, self._open), self.rules)
        self.keys = {value["robot"]: value["key"] for _, value in self.pipe.keys}

    def _open(self, who, say):
        self.lines.append(FakeLine(who, say))
        return self.lines[-1]

    def join(self, number, robot=7, key=None, now=100.0):
        self.programs.join(number, robot, self.keys.get(robot, "") if key is None else key, self.rules, now)


@pytest.fixture
def school():
    return School()


def test_keys_are_told_to_those_who_may_drive_and_differ(school):
    assert [(to, value["path"]) for to, value in school.pipe.keys] == [("", "/robot/7"), ("", "/robot/8")]
    assert school.keys[7] != school.keys[8] and len(school.keys[7]) > 20


def test_a_program_with_the_key_gets_bytes_both_ways(school):
    school.wires[7].take(False, encode_frame(0x20, b"config"))
    school.programs.turn(99.0)
    school.join(1)
    assert school.pipe.opened == {1: "rosie"} and school.lines[0].frames == [0x20]
    school.programs.receive(1, b"abc", 100.1)
    assert school.lines[0].heard == b"abc" and school.pipe.data == {1: b"ABC"}
    assert school.programs.due == 7.0
    school.wires[7].take(False, encode_frame(0x32, b"sip"))
    school.wires[7].take(True, encode_frame(0x33, b"to the robot"))
    assert school.woken == [1]
    school.programs.turn(100.2)
    assert school.lines[0].frames == [0x20, 0x32] and school.lines[0].ticks == [100.2]


def test_nobody_is_woken_without_a_program(school):
    school.wires[8].take(False, b"x")
    assert school.woken == [] and school.programs.due == math.inf


@pytest.mark.parametrize("robot", [None, 0, -1, 9, 99999])
def test_no_such_robot(school, robot):
    school.join(1, robot, school.keys[7])
    assert school.pipe.closed[1][0] == 4404 and "7, 8" in school.pipe.closed[1][1] and school.lines == []


@pytest.mark.parametrize("key", ["", "x", "é", "\ud800", "x" * 4000])
def test_a_wrong_key_and_that_of_another_robot(school, key):
    school.join(1, 7, key)
    school.join(2, 7, school.keys[8])
    for number in (1, 2):
        code, reason = school.pipe.closed[number]
        assert code == 4401 and "key" in reason and school.keys[7] not in reason
    assert school.lines == []


def test_the_newest_wins_once_the_older_one_has_settled(school):
    school.join(1)
    school.join(2, now=100.0 + SETTLES / 2)
    assert school.pipe.closed[2][0] == 4409 and school.lines[0].ended == 0
    school.join(3, now=100.0 + SETTLES)
    assert school.pipe.closed[1][0] == 4409 and school.lines[0].ended == 1 and 3 in school.pipe.opened
    school.programs.receive(1, b"late", 102.0)
    school.programs.gone(1)
    assert school.lines[1].heard == b"" and school.lines[1].ended == 0


def test_a_program_that_is_gone_ends_its_line_and_only_its_own(school):
    school.join(1, 7)
    school.join(2, 8)
    school.programs.gone(1)
    school.programs.gone(1)
    assert [line.ended for line in school.lines] == [1, 0] and school.pipe.closed == {}
    school.join(3, 7)       # at once: nobody has it
    assert 3 in school.pipe.opened


def test_a_silent_server_stops_all_and_then_ends_all(school):
    school.join(1, 7)
    school.join(2, 8)
    school.programs.halt(7)
    assert [line.halted for line in school.lines] == [True, False]
    school.programs.halt()
    assert all(line.halted and not line.ended for line in school.lines) and school.pipe.closed == {}
    school.programs.lost("silent")
    assert [line.ended for line in school.lines] == [1, 1] and set(school.pipe.closed) == {1, 2}
    school.programs.receive(1, b"abc", 101.0)
    assert school.lines[0].heard == b""


def test_a_new_key_ends_the_old_program(school):
    school.join(1)
    school.programs.change_key(7)
    assert school.pipe.closed[1][0] == 4401 and school.lines[0].ended == 1
    school.join(2, now=200.0)
    assert school.pipe.closed[2][0] == 4401
    school.programs.tell_key(7, school.rules)
    assert school.pipe.keys[-1][1]["key"] not in school.keys.values()


def test_sentences_are_rationed(school):
    school.join(1)
    for _ in range(100):
        school.lines[0].say("VEL refused")
    assert len(school.pipe.sentences) == SENTENCES and school.pipe.sentences[0]["text"] == "VEL refused"


def test_a_wire_without_a_reader_keeps_little(school):
    for _ in range(10000):
        school.wires[7].take(False, b"x" * 100)
    assert len(school.wires[7]._heard) <= 200


def test_allowances():
    allowance = Allowance(10, 0.0)
    assert all(allowance.spends(1, 0.0) for _ in range(10)) and not allowance.spends(1, 0.0)
    assert allowance.spends(5, 0.5) and not allowance.spends(1, 0.5)
    assert not allowance.spends(11, 1000.0)


@pytest.mark.parametrize("count, data", [
    (MOST_MESSAGES, b"x"), (MOST_BYTES // 4096, b"x" * 4096), (MOST_PACKETS // 100, b"\xfa\xfb\x03\0\0" * 100)])
def test_the_limits_of_a_program(count, data):
    limits = ProgramLimits(0.0)
    assert [limits.check(data, 0.0) for _ in range(count)] == [None] * count
    assert limits.check(data, 0.0).code == 4429
    assert limits.check(b"x", 1.0) is None
    assert "4097" in limits.check(b"x" * 4097, 1.0).reason


def test_a_decoder_of_its_own(school):
    """What is cut in pieces by the line is whole again for the program."""
    frame = encode_frame(0x32, b"abc")
    for at in range(len(frame)):
        school.wires[7].take(False, frame[at:at + 1])
    assert FrameDecoder().feed(frame) == school.wires[7].frames()

"""A record of a line, test/data/day.wire, is played in two ways.

When the record plays the robot, the client must report the same states and events as in the original run. When the
record plays the client, the simulated robot must answer as it did then. In the run a client connects, fetches a can,
drives backwards into a wall, gets lost and damaged packets, has a power cycle of the robot, and connects again.
`wire_log` made the record.
"""

import math
import re

import pytest
import wire_log
from real_time import until
from simulated_client import Life

from pioneer_control.client import Ready, Robot
from pioneer_control.p2os import FrameDecoder, decode_command, decode_packet, encode_command
from pioneer_control.p2os.recording import read_record
from pioneer_control.simulator.__main__ import main
from pioneer_control.simulator.played import PlayedRobot, compare, play_client
from pioneer_control.simulator.line import Server

RECORD = read_record(str(wire_log.RECORD))
THEN = wire_log.TOLD.read_text(encoding="utf-8").splitlines()


def changed(to_robot, number, at, value):
    """Return the record with one byte changed in one piece of one direction."""
    entries = list(RECORD)
    index = [index for index, entry in enumerate(entries) if entry.data and entry.to_robot == to_robot][number]
    data = bytearray(entries[index].data)
    assert data[at] != value
    data[at] = value
    entries[index] = entries[index]._replace(data=bytes(data))
    return entries


def said_instead(old, new):
    """Return the record with every packet `old` of the client replaced by `new`."""
    assert any(entry.to_robot and old in entry.data for entry in RECORD)
    return [entry._replace(data=entry.data.replace(old, new)) if entry.to_robot else entry for entry in RECORD]


def told(monkeypatch, record, script):
    """Return what the client reports of a played robot, and what the played robot says about the client."""
    differences = []
    life = Life(monkeypatch, script, PlayedRobot(record, say=lambda time, sentence: differences.append(sentence)),
                url="socket://robot:1")
    return wire_log.lines_of(life.told), differences


def waits(life):
    """A program that gives no commands and waits until the record is over."""
    yield from life.until(lambda: life.firmware.over)
    yield 0.1


def test_the_record_is_what_its_test_needs():
    entries = [entry for entry in RECORD if entry.data]
    heard, said = ([frame for entry in entries if entry.to_robot is way for frame in FrameDecoder().feed(entry.data)]
                   for way in (True, False))
    names = {decode_command(frame).name for frame in heard}
    assert {"VEL", "RVEL", "ENABLE", "GRIPPER", "STOP", "CLOSE"} <= names and len(said) > 150
    pressed = [line.split()[6] for line in THEN if " " in line and not line.startswith("Link")]
    assert any("1" in each[8:] for each in pressed), "a rear bumper"
    assert THEN[0] == "Ready" and THEN.count("Ready") == 2 and THEN.count("LinkDown LinkLostError") == 1
    assert any("loss" in entry.note for entry in RECORD)


# As the robot, into the client

def test_the_client_tells_the_same_states_and_events_again(monkeypatch):
    now, differences = told(monkeypatch, RECORD, wire_log.script)
    assert now == THEN


def test_so_it_does_when_nobody_commands_anything_and_the_difference_is_said(monkeypatch):
    now, differences = told(monkeypatch, RECORD, waits)
    assert now[:len(THEN)] == THEN      # it looks on a little longer
    assert differences[0].startswith("here the client sends STOP, and that of the record")
    assert ("in this connection the client sent, against that of the record: " in differences[1] and
            " VEL -" in differences[1])


def test_the_pose_goes_on_after_the_power_cycle(monkeypatch):
    robot_of_then = PlayedRobot(read_record(str(wire_log.RECORD)))
    life = Life(monkeypatch, waits, robot_of_then, url="socket://robot:1")
    places = [(state.x, state.y) for state in life.states]
    assert len(life.of(Ready)) == 2 and max(map(math.dist, places, places[1:])) < 0.2     # packets were lost


def test_the_example_in_the_document_is_code_that_is_tested():
    with open(wire_log.DATA.parents[1] / "docs" / "wire.md",
              encoding="utf-8") as document, open(__file__, encoding="utf-8") as source:
        example, = re.findall(r"^```python\n(.*?)^```", document.read(), re.MULTILINE | re.DOTALL)
        assert example in source.read()


@pytest.mark.parametrize("to_robot, number, at, value", [(False, 40, 10, 0x77), (False, 150, 5, 0x77)])
def test_a_byte_of_the_robot_that_is_another_is_noticed(monkeypatch, to_robot, number, at, value):
    now, _ = told(monkeypatch, changed(to_robot, number, at, value), wire_log.script)
    assert now != THEN


def test_a_command_that_is_another_is_noticed(monkeypatch):
    then = encode_command("GRIPPER", 5)
    _, usual = told(monkeypatch, RECORD, wire_log.script)
    _, differences = told(monkeypatch, said_instead(then, encode_command("GRIPPER", 4)), wire_log.script)
    assert not any("GRIPPER" in sentence or "ENCODER" in sentence for sentence in usual)
    assert "here the client sends GRIPPER 5, and that of the record did not" in differences


@pytest.mark.parametrize("value, is_named", [(1, False), (2, True)])
def test_questions_are_no_difference_and_a_wish_for_encoders_is_one(monkeypatch, value, is_named):
    _, differences = told(monkeypatch, said_instead(encode_command("GRIPPER", 5), encode_command("ENCODER", value)),
                          wire_log.script)
    assert "here the client sends GRIPPER 5, and that of the record did not" in differences
    assert any("ENCODER -" in sentence for sentence in differences) is is_named


@pytest.mark.parametrize("line", ["tcp", "pty"])
def test_a_server_plays_it_to_a_program(tmp_path, line):
    begin = [entry for entry in RECORD if entry.time < 2.5]
    said = [frame for entry in begin if not entry.to_robot for frame in FrameDecoder().feed(entry.data)]
    end = decode_packet(said[-1]).x_counts / 1000
    with Server(PlayedRobot(begin), tcp=0, pty=str(tmp_path / "line")) as server:
        states = []
        with Robot(server.url if line == "tcp" else server.pty_link, on_state=states.append) as robot:
            assert (robot.identity.subtype, robot.identity.firmware) == ("peoplebot-sh", "2.9")
            until(lambda: states and states[-1].x == end, "where the record ends")
    assert end > 0.0
    if line == "tcp":       # a terminal drops what is not read for a second
        lines = list(map(wire_log.line_of, states))
        first = THEN.index(lines[0])
        assert lines == THEN[first:first + len(lines)] and first < 4


# As the client, into the simulated robot

def answers_to(record, lines):
    """Return the differences between the answers of a simulated robot and the record."""
    found, = compare(RECORD, play_client(record, lines), [lines.robots[0].model])
    return found


def test_the_simulated_robot_says_the_same_byte_by_byte():
    found = answers_to(RECORD, wire_log.on_its_line())
    assert (found.same and found.first == "" and (found.apart, found.turned_apart) == (0.0, 0.0) and
            found.recorded == found.simulated > 150)
    assert str(found).endswith("the same, byte by byte")


def test_with_other_luck_on_the_line_it_obeys_to_nearly_the_same_path():
    found = answers_to(RECORD, wire_log.on_its_line(seed=wire_log.SEED + 1))
    assert not found.same and found.first and found.apart < 0.25, str(found)


def test_a_command_that_is_lost_leads_elsewhere():
    record = [entry for entry in RECORD
              if not (entry.to_robot and entry.time > 10.0 and encode_command("VEL", 250) in entry.data)]
    assert answers_to(record, wire_log.on_its_line()).apart > 0.5


@pytest.mark.parametrize("record", [
    said_instead(encode_command("VEL", -400), encode_command("VEL", -390)),
    said_instead(encode_command("GRIPPER", 2), encode_command("GRIPPER", 1)),
    RECORD[:-40]])
def test_what_the_client_says_otherwise_is_noticed(record):
    assert not answers_to(record, wire_log.on_its_line()).same


def test_the_command_line(tmp_path, capsys):
    arguments = ["--client", str(wire_log.RECORD), "--model", "peoplebot-sh", "--gripper", "--no-rear-sonar", "--world",
                 "cans", "--seed", "5"]
    faults = [word for fault in wire_log.FAULTS for word in ("--fault", fault)]
    copy = tmp_path / "copy.wire"
    assert main([*arguments, *faults, "--record", str(copy)]) == 0
    assert capsys.readouterr().out.endswith("says the same, byte by byte\n")
    assert copy.read_text() == wire_log.RECORD.read_text()
    assert main(arguments) == 1
    assert "the first that differ: Sip at 14." in capsys.readouterr().out

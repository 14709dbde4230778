"""The laser over the robot's own line: every example packet of the laser sheet, and values that do not fit."""

import pathlib

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as some

from golden import frame, wire
from pioneer_control import p2os
from pioneer_control.errors import EncodingError
from pioneer_control.p2os import OrderArgument
from pioneer_control.p2os.explain import explain

FILE = pathlib.Path(__file__).parents[2] / "data" / "simulated-laser-golden.yaml"
EXAMPLES = yaml.safe_load(FILE.read_text(encoding="utf-8"))["examples"]


def of(kind):
    """Return a mark for a test of the examples that have this key."""
    found = [example for example in EXAMPLES if kind in example]
    return pytest.mark.parametrize("example", found, ids=lambda example: example["bytes"][:26])


def values_of(words):
    return [bytes.fromhex(word) if isinstance(word, str) else word for word in words]


def test_no_example_is_lost():
    """Part 2 has 4 examples, 3.2 has 22, of which all differ, and 3.3 has 3."""
    kinds = [next(key for key in ("command", "order", "packet") if key in example) for example in EXAMPLES]
    assert [kinds.count(kind) for kind in ("command", "order", "packet")] == [4, 22, 3]
    assert len({wire(example) for example in EXAMPLES}) == len(EXAMPLES)
    seen = {example["order"][0] for example in EXAMPLES if "order" in example}
    assert seen == set(p2os.SIMULATOR_COMMANDS)


@of("bytes")
def test_frame(example):
    assert p2os.FrameDecoder().feed(wire(example)) == [frame(wire(example))]


@of("command")
def test_command(example):
    name, *values = example["command"]
    assert p2os.encode_command(name, *values) == wire(example)
    assert p2os.decode_command(frame(wire(example))).name == name


@of("order")
def test_order(example):
    name, *words = example["order"]
    values = values_of(words)
    assert p2os.encode_simulator_command(name, *values) == wire(example)
    order = p2os.decode_simulator_command(frame(wire(example)))
    assert (order.name, list(order.values)) == (name, values)
    assert order.number == p2os.SIMULATOR_COMMANDS[name].number == wire(example)[3]


@of("packet")
def test_packet(example):
    packet = p2os.decode_packet(frame(wire(example)))
    fields = {name: tuple(value) if isinstance(value, list) else value for name, value in example["fields"].items()}
    if "readings" in fields:
        fields["readings"] = tuple(p2os.LaserReading(*reading) for reading in fields["readings"])
    assert type(packet).__name__ == example["packet"] and vars(packet) == fields
    assert p2os.encode_packet(packet) == wire(example)


@of("packet")
def test_every_byte_is_read(example):
    data = frame(wire(example))
    for at in range(len(data.data)):
        changed = bytearray(data.data)
        changed[at] ^= 1
        assert p2os.decode_packet(p2os.Frame(data.id, bytes(changed))) != p2os.decode_packet(data), at


def test_a_laser_command_works_without_its_last_byte():
    bare = p2os.encode_simulator_command("SIM_LRF_SET_FOV_START", -90)
    assert len(bare) == 9
    assert p2os.decode_simulator_command(frame(bare)).values == (-90,)
    assert p2os.decode_simulator_command(frame(p2os.encode_simulator_command("SIM_CTRL", 6))).values == (6,)


@pytest.mark.parametrize("call, named", [
    (("SIM_LASER", 1), "no command of simulators is called 'SIM_LASER'"),
    (("SIM_RESET", 1), "SIM_RESET takes 0 values, not 1"),
    (("SIM_LRF_ENABLE",), "SIM_LRF_ENABLE takes 1 or 2 values, not 0"),
    (("SIM_SET_POSE", 1, 2), "SIM_SET_POSE takes 3 values, not 2"),
    (("SIM_LRF_SET_RES", 40000), "SIM_LRF_SET_RES: 40000 is out of range"),
    (("SIM_LRF_SET_RES", 1.0), "SIM_LRF_SET_RES: 1.0 is not an integer"),
    (("OLD_LASER_ENABLE", True), "True is not an integer"),
    (("SIM_LRF_ENABLE", 1, 256), "number of the laser: 256"),
    (("SIM_SET_POSE", 1, 2, 2 ** 31), "SIM_SET_POSE: 2147483648"),
    (("SIM_MESSAGE", "hi"), "SIM_MESSAGE: 'hi' is not bytes"),
    (("SIM_CTRL", 1, b"x" * 196), "length of the name: 196"),
])
def test_what_does_not_fit_is_refused_by_name(call, named):
    with pytest.raises(EncodingError, match=named):
        p2os.encode_simulator_command(*call)


@given(some.integers(0, 255), some.binary(max_size=20))
def test_nothing_is_too_strange_to_decode(number, data):
    order = p2os.decode_simulator_command(p2os.Frame(number, data))
    known = {command.number for command in p2os.SIMULATOR_COMMANDS.values()}
    assert (order is not None) == (number in known)
    if order is not None and order.values:
        again = frame(p2os.encode_simulator_command(order.name, *order.values)) if -32768 not in order.values else None
        assert again is None or p2os.decode_simulator_command(again) == order


@pytest.mark.parametrize("data", [b"", b"\x3B", b"\x3B\x01", b"\x2B\x01\x41", b"\x00\x01\x02", b"\x3B" + bytes(11)])
def test_a_broken_argument_is_none(data):
    for command in p2os.SIMULATOR_COMMANDS.values():
        long_enough = len(data) > 3 and command.argument is not OrderArgument.POSE
        if not (long_enough or data[:1] == b"\x2B" and command.argument is OrderArgument.STRING):
            assert p2os.decode_simulator_command(p2os.Frame(command.number, data)).values == (), command.name


def test_a_person_is_told_both_meanings():
    said = "\n".join(explain(bytes.fromhex("FA FB 06 24 1B 5A 00 7E 1B"), to_robot=True, from_robot=False))
    assert "GRIPPERVAL" in said and "(simulators: OLD_LASER_FIRST -90: deg, + left: angle of the first ray)" in said
    said = "\n".join(explain(bytes.fromhex("FA FB 07 E8 3B 5A 00 00 42 3B"), to_robot=True, from_robot=False))
    assert "no Pioneer knows" in said and "SIM_LRF_SET_FOV_END 90 0" in said

"""The table of commands, and values that do not fit it."""

import golden
import pytest

from pioneer_control import p2os
from pioneer_control.errors import EncodingError, UsageError
from pioneer_control.p2os.commands import COMMAND_NUMBERS, OTHER_MEANINGS, Argument

COMMANDS = list(p2os.COMMANDS.values())


def received(*data: int, id: int = 11) -> p2os.ReceivedCommand:
    """Return how a robot understands a frame of VEL (or `id`) with these bytes of data."""
    return p2os.decode_command(p2os.Frame(id, bytes(data)))


def extremes(command):
    """Return the least and the greatest legal values, as tuples."""
    if command.argument is Argument.NONE:
        return [()]
    if command.argument is Argument.STRING:
        return [(bytes(command.low),), (b"\xFA" * command.high,)]
    if command.argument is Argument.TWO_BYTES:
        return [command.low, command.high]
    return [(command.low,), (command.high,)]


def too_much(command):
    """Return values just out of range, as tuples."""
    if command.argument is Argument.STRING:
        return [(bytes(command.high + 1),)]
    if command.argument is Argument.TWO_BYTES:
        (low_1, low_2), (high_1, high_2) = command.low, command.high
        return [(low_1 - 1, low_2), (low_1, low_2 - 1), (high_1 + 1, high_2), (high_1, high_2 + 1)]
    return [(command.low - 1,), (command.high + 1,)]


def test_numbers_and_names_are_unique():
    assert len(COMMAND_NUMBERS) == len(p2os.COMMANDS) == 107
    assert all(0 <= command.number <= 255 for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_round_trip_of_the_extremes(command):
    for values in extremes(command):
        frame = golden.frame(p2os.encode_command(command.name, *values))
        number, name, value = p2os.decode_command(frame)
        assert (number, name) == (command.number, command.name)
        if command.argument is Argument.TWO_BYTES:
            assert [byte & 0xFF for byte in p2os.two_bytes(value)] == [byte & 0xFF for byte in values]
        else:
            assert value == (values[0] if values else None)


@pytest.mark.parametrize("command", [command for command in COMMANDS if command.argument is not Argument.NONE],
                         ids=lambda command: command.name)
def test_out_of_range_raises(command):
    for values in too_much(command):
        with pytest.raises(EncodingError) as error:
            p2os.encode_command(command.name, *values)
        assert str(error.value).startswith(command.name) and "is legal" in str(error.value)


@pytest.mark.parametrize("value", [1.0, float("nan"), float("inf"), True, None, "1", b"1", [1]], ids=repr)
def test_only_whole_numbers(value):
    with pytest.raises(EncodingError, match=r"VEL: .* is not an integer \(-32767..32767 is legal\)"):
        p2os.encode_command("VEL", value)
    with pytest.raises(EncodingError, match="DIGOUT, second value: .* is not an integer"):
        p2os.encode_command("DIGOUT", 1, value)


@pytest.mark.parametrize("value", ["hi", 3, None, [1, 2]], ids=repr)
def test_only_bytes(value):
    with pytest.raises(EncodingError, match="TTY2: .* is not bytes"):
        p2os.encode_command("TTY2", value)


def test_the_message_says_what_is_legal():
    with pytest.raises(UsageError) as error:
        p2os.encode_command("SONARCYCLE", 121)
    assert str(error.value) == "SONARCYCLE: 121 is out of range (2..120 is legal)"


@pytest.mark.parametrize("call", [("PULSE", 1), ("VEL",), ("VEL", 1, 2), ("VEL2", 1), ("TTY2",)], ids=repr)
def test_wrong_number_of_values(call):
    with pytest.raises(EncodingError, match=f"{call[0]} takes [012] values?, not {len(call) - 1}"):
        p2os.encode_command(*call)


def test_no_such_command():
    with pytest.raises(EncodingError, match="no command is called 'VELOCITY'"):
        p2os.encode_command("VELOCITY", 1)


def test_named_numbers_are_numbers():
    assert p2os.encode_command("GRIPPER", p2os.GripperCommand.LIFT_DOWN) == p2os.encode_command("GRIPPER", 5)


@pytest.mark.parametrize("name", ["OPEN", "CLOSE", "CONFIG", "E_STOP"])
def test_with_and_without_argument(name):
    bare, with_one = p2os.encode_command(name), p2os.encode_command(name, 1)
    assert (len(bare), len(with_one)) == (6, 9)
    assert p2os.decode_command(golden.frame(bare))[1:] == (name, None)
    assert p2os.decode_command(golden.frame(with_one))[1:] == (name, 1)


def test_sync_numbers_are_those_of_the_session():
    assert [p2os.encode_frame(sync) for sync in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2)] == \
        [p2os.encode_command(name) for name in ("PULSE", "OPEN", "CLOSE")]


def test_signs():
    assert received(0x1B, 0xC8, 0x00).value == -200
    assert received(0x3B, 0x38, 0xFF).value == -200, "two's complement, as some clients send it"
    assert received(0x1B, 0x00, 0x00).value == 0
    assert received(0x3B, 0xFF, 0xFF, id=6).value == 65535, "unsigned"
    assert received(0x3B, 0xFF, 0x7F).value == 32767
    assert received(0x3B, 0x00, 0x80).value == -32768


def test_sign_first_then_split():
    """A mask of FF and the states 05, as one signed word."""
    number, name, value = received(0x1B, 0xFB, 0x00, id=30)
    assert (name, value) == ("DIGOUT", -251)
    assert p2os.two_bytes(value) == p2os.two_bytes(0xFF05) == (-1, 5)
    assert p2os.two_bytes(-0x09F6) == p2os.two_bytes(0xF60A) == (-10, 10)


def test_strings_end_where_their_length_says():
    assert received(0x2B, 2, 0x68, 0x69, 0, id=42).value == b"hi", "a trailing NUL that does not count"
    assert received(0x2B, 9, 0x68, id=42).value == b"h", "cut"
    assert received(0x2B, 0, id=42).value == b""
    assert received(0x2B, id=42).value is None


@pytest.mark.parametrize("data", [[], [0x3B], [0x1B], [0x3B, 1], [0x00, 1, 2], [0xFF]], ids=repr)
def test_no_usable_argument(data):
    assert received(*data) == (11, "VEL", None)


def test_every_number_has_a_name():
    for number in range(256):
        assert received(0x3B, 1, 0, id=number).value == 1
    assert received(id=200) == (200, "COMMAND_200", None)


def test_the_pioneer_wins_where_others_use_its_number():
    others = [number for number, _, _ in OTHER_MEANINGS]
    others += [command.number for command in p2os.SIMULATOR_COMMANDS.values()]
    assert len(set(others)) == len(others), "each stands in one table"
    clashes = set(others) & set(COMMAND_NUMBERS)
    assert clashes == {35, 36, 37, 38, 57, 61, 62, 66, 67, 68, 90, 250}
    assert [received(id=number).name for number in (36, 37, 62)] == ["GRIPPERVAL", "GRIPREQUEST", "BATTERYINFO"]
    assert received(id=224).name == "COMMAND_224", "a simulator's own number"


@pytest.mark.parametrize("family, command, known", [
    ("PSOS", "STOP", False),
    ("P2OS", "STOP", True),
    ("AmigoSH", "STOP", True),
    ("MARCOS", "STOP", False),
    ("AmigOS", "IOREQUEST", False),
    ("P2OS", "IOREQUEST", True),
    ("AROS", "TICKSMM", False),
    ("ARCOS", "TICKSMM", True),
    ("PSOS", "VEL", True),
])
def test_who_knows_what(family, command, known):
    assert p2os.knows(family, command) is known

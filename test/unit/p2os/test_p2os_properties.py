"""What holds for all bytes and all values. hypothesis searches for counterexamples."""

from types import SimpleNamespace

from hypothesis import example, given
from hypothesis import strategies as some

from pioneer_control import p2os
from pioneer_control.errors import EncodingError
from pioneer_control.p2os.commands import Argument
from pioneer_control.p2os.explain import explain
from pioneer_control.wire_fields import Many, NumberField, Record, TooShort, read_fields, write_fields
from pioneer_control.wire_fields import rows as p2os_rows
from pioneer_control.p2os.packets import PACKETS, packet_rows

LONGEST = 3 + 0xFF
FRAMES = some.builds(p2os.encode_frame, some.integers(0, 255), some.binary(max_size=197))
NOISE = some.one_of(some.binary(max_size=40),
                    some.sampled_from([b"\xFA", b"\xFA\xFA", b"\xFA\xFB", b"\xFA\xFB\xFF", b"\xFA\xFB\x02"]))
STREAMS = some.lists(some.one_of(FRAMES, NOISE), max_size=8).map(b"".join)
COMMANDS = some.sampled_from(sorted(p2os.COMMANDS))
TABLES = list({id(table): table for packet_class, _ in PACKETS.values() for first in (True, False)
               for table in [packet_rows(packet_class, first)] if table}.values())
ALL_NUMBERS = [table for table in TABLES if all(
    isinstance(row.type, NumberField)
    or isinstance(row.type, Many) and isinstance(row.type.item, Record) and row.type.item.layout and not row.type.sized
    for row in table)]
"""Those of numbers, and of records of numbers."""


def cut(data, at):
    """Return the pieces of data between these places."""
    places = sorted({0, len(data), *(place % (len(data) + 1) for place in at)})
    return [data[begin:end] for begin, end in zip(places, places[1:])]


def all_frames(pieces):
    """Return the frames that a decoder finds in the pieces, and the decoder."""
    decoder = p2os.FrameDecoder()
    frames = []
    for piece in pieces:
        frames += decoder.feed(piece)
        assert len(decoder._held) < LONGEST
    return frames, decoder


@given(STREAMS, some.lists(some.integers(0), max_size=10))
@example(b"\xFA\xFB\xFF" + p2os.encode_frame(29), [])
def test_however_it_is_cut_a_stream_says_the_same(stream, places):
    whole, one = all_frames([stream])
    parts, other = all_frames(cut(stream, places))
    assert whole == parts and one.counts == other.counts and one._held == other._held


@given(STREAMS)
def test_every_byte_is_part_of_a_frame_or_counted_as_none(stream):
    frames, decoder = all_frames([stream])
    frames += decoder.drop_partial()
    assert not decoder.waiting
    assert sum(len(frame.data) + 6 for frame in frames) + decoder.counts.discarded_bytes == len(stream)
    assert decoder.counts.frames == len(frames)


@given(some.lists(FRAMES, min_size=1, max_size=4),
       some.lists(some.lists(some.integers(0, 0xF9), max_size=20).map(bytes), max_size=5))
def test_no_noise_without_a_header_hides_a_frame(sent, noises):
    noises += [b""] * (len(sent) + 1 - len(noises))
    frames, _ = all_frames([b"".join(noise + frame for noise, frame in zip(noises, sent))])
    assert [p2os.encode_frame(*frame) for frame in frames] == sent


@given(STREAMS, FRAMES)
def test_after_a_pause_a_frame_is_heard_whatever_came_before(stream, sent):
    _, decoder = all_frames([stream])
    decoder.drop_partial()
    assert [p2os.encode_frame(*frame) for frame in decoder.feed(sent)] == [sent]


@given(FRAMES, some.integers(0), some.integers(0, 7))
def test_one_wrong_bit_is_never_believed(sent, place, bit):
    at = place % len(sent)
    _, decoder = all_frames([sent[:at] + bytes([sent[at] ^ 1 << bit]) + sent[at + 1:]])
    decoder.drop_partial()
    assert decoder.counts.frames == 0 or at == 2, "with another count, another frame may be found inside"


@given(some.integers(0, 255), some.binary(max_size=250), some.booleans())
def test_any_frame_is_some_packet_and_goes_back_to_the_same_meaning(number, data, grip_state_first):
    packet = p2os.decode_packet(p2os.Frame(number, data), grip_state_first)
    try:
        again = p2os.encode_packet(packet, grip_state_first)
    except EncodingError:      # longer than anybody may send
        return
    assert p2os.decode_packet(p2os.Frame(again[3], again[4:-2]), grip_state_first) == packet


@given(some.integers(0, 255), some.binary(max_size=250))
def test_any_frame_is_some_command(number, data):
    command = p2os.decode_command(p2os.Frame(number, data))
    assert command.number == number and isinstance(command.value, (int, bytes, type(None)))


@given(some.data(), COMMANDS)
def test_every_command_arrives_as_it_was_meant(data, name):
    command = p2os.COMMANDS[name]
    values = ()
    if command.argument in (Argument.INT, Argument.UINT):
        values = (data.draw(some.integers(command.low, command.high)),)
    elif command.argument is Argument.STRING:
        values = (data.draw(some.binary(min_size=command.low, max_size=command.high)),)
    elif command.argument is Argument.TWO_BYTES:
        values = tuple(data.draw(some.integers(low, high)) for low, high in zip(command.low, command.high))
    encoded = p2os.encode_command(name, *values)
    received = p2os.decode_command(p2os.Frame(encoded[3], encoded[4:-2]))
    meant = values[0] if len(values) == 1 else None if not values else values
    got = tuple(byte & 0xFF for byte in p2os.two_bytes(received.value)) if len(values) == 2 else received.value
    assert received.name == name and got == (tuple(value & 0xFF for value in meant) if len(values) == 2 else meant)


@given(STREAMS)
def test_whatever_it_is_it_can_be_explained(stream):
    assert isinstance("\n".join(explain(stream)), str)


def read_field_by_field(table, data):
    """Do what read_fields() does, slowly. Returns the name of a missing field instead, if there is one."""
    values, at = dict.fromkeys(row.name for row in table), 0
    for row in table:
        try:
            values[row.name], at = row.type.read(data, at)
        except TooShort as short:
            return values if row.optional else "%s: %s" % (row.name, short)
    return values


def write_field_by_field(table, packet):
    """Do what write_fields() does, slowly."""
    values = [getattr(packet, row.name) for row in table]
    while values and values[-1] is None and table[len(values) - 1].optional:
        values.pop()
    name = type(packet).__name__
    return b"".join(row.type.write(value, "%s.%s" % (name, row.name)) for row, value in zip(table, values))


@given(some.data(), some.sampled_from(TABLES), some.binary(max_size=250))
def test_a_packet_is_read_in_one_go_as_field_by_field(data, table, raw):
    """Data may be cut off anywhere, may have more bytes behind them, and may have a count of records that are not all
    there.
    """
    raw = raw.ljust(data.draw(some.integers(0, 60)), b"\0")
    many = [index for index, row in enumerate(table) if isinstance(row.type, Many)]
    if table in ALL_NUMBERS and many and data.draw(some.booleans()):
        at, few = sum(row.type.size for row in table[:many[0]]), data.draw(some.integers(0, 12))
        raw = raw[:at] + bytes([few]) + raw[at + 1:] if at < len(raw) else raw
    try:
        in_one_go, _ = read_fields(table, raw)
    except TooShort as short:
        in_one_go = str(short)
    expected = read_field_by_field(table, raw)
    assert in_one_go == expected and list(in_one_go) == list(expected)


@given(some.data(), some.sampled_from(ALL_NUMBERS))
def test_a_packet_is_written_in_one_go_as_field_by_field(data, table):
    """Values may not fit, may be None, or may be of another type."""
    def number(row):
        if data.draw(some.integers(0, 9)):
            return data.draw(some.integers(row.type.low, row.type.high))
        wrong = [row.type.low - 1, row.type.high + 1, True, None, 1.0, "1", p2os.Flags(1)]
        return data.draw(some.one_of(some.sampled_from(wrong), some.integers()))

    def records(row):
        make, inner = row.type.item.record_class, p2os_rows(row.type.item.record_class)
        tuples = some.lists(some.builds(lambda: make(**{each.name: number(each) for each in inner})),
                            max_size=5).map(tuple)
        return data.draw(some.one_of(tuples, tuples, some.sampled_from([None, (), [], (1,), 3])))

    values = {row.name: records(row) if isinstance(row.type, Many) else number(row) for row in table}
    for name in list(values)[data.draw(some.integers(0, len(values))):]:
        values[name] = None
    packet = SimpleNamespace(**values)

    def written(way):
        try:
            return way()
        except EncodingError as error:
            return str(error)

    assert written(lambda: write_fields(table, packet)) == written(lambda: write_field_by_field(table, packet))

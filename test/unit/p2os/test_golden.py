"""Every example packet of the protocol sheet is framed, encoded, and read field by field."""

import golden
import pytest

from pioneer_control import p2os
from pioneer_control.p2os.packets import packet_rows

examples = pytest.mark.parametrize("example", golden.EXAMPLES, ids=golden.label)
commands = pytest.mark.parametrize("example", golden.COMMANDS, ids=golden.label)
packets = pytest.mark.parametrize("example", golden.PACKETS, ids=golden.label)


def test_no_example_is_lost():
    """The protocol sheet has 101 examples of packets of the robot, and 70 of devices (cameras and arm). Some are there
    twice.
    """
    places = [place for example in golden.EXAMPLES
              for place in str(example["where"]).replace("camera ", "camera-").replace("arm ", "arm-").split()]
    on_devices = [place for place in places if place.startswith(("camera", "arm"))]
    assert (len(places) - len(on_devices), len(on_devices)) == (101, 70)
    assert len({golden.wire(example) for example in golden.EXAMPLES}) == len(golden.EXAMPLES) == 158
    assert (len(golden.COMMANDS), len(golden.PACKETS)) == (120, 42), "four are both"
    assert len(golden.DATA["rejected"]) == 3


@examples
def test_frame(example):
    frame = golden.frame(golden.wire(example))
    assert p2os.FrameDecoder().feed(golden.wire(example)) == [frame]
    assert p2os.checksum(golden.wire(example)[3:-2]) == int.from_bytes(golden.wire(example)[-2:], "big")
    assert p2os.encode_frame(frame.id, frame.data) == golden.wire(example)


@commands
def test_command(example):
    name, *values = golden.command_values(example)
    encoded = p2os.encode_command(name, *values)
    assert (encoded == golden.wire(example)) == ("form" not in example)

    received = p2os.decode_command(golden.frame(golden.wire(example)))
    assert (received.number, received.name) == (p2os.COMMANDS[name].number, name)
    if len(values) == 2:
        assert [byte & 0xFF for byte in p2os.two_bytes(received.value)] == [value & 0xFF for value in values]
    else:
        assert received.value == (values[0] if values else None)


@packets
def test_packet(example):
    grip_state_first = example.get("order") != "port first"
    packet = p2os.decode_packet(golden.frame(golden.wire(example)), grip_state_first)
    assert type(packet).__name__ == example["packet"]
    assert set(vars(packet)) == set(example["fields"])
    names = {row.name: getattr(row.type, "names", None) for row in packet_rows(type(packet), grip_state_first)}
    for name, expected in example["fields"].items():
        assert golden.matches(getattr(packet, name), expected, names.get(name)), (name, getattr(packet, name), expected)
    assert p2os.encode_packet(packet, grip_state_first) == golden.wire(example)


@packets
def test_every_byte_is_read(example):
    """A changed byte anywhere in the data gives another packet. So every byte counts in the tests above."""
    grip_state_first = example.get("order") != "port first"
    frame = golden.frame(golden.wire(example))
    original = p2os.decode_packet(frame, grip_state_first)
    padding = range(2 + len("hello") + 1, 2 + 16) if isinstance(original, p2os.Playlist) else ()
    for at in set(range(len(frame.data))) - set(padding):
        changed = bytearray(frame.data)
        changed[at] ^= 1
        assert p2os.decode_packet(p2os.Frame(frame.id, bytes(changed)), grip_state_first) != original, at


@pytest.mark.parametrize("example", golden.DATA["rejected"], ids=golden.label)
def test_rejected(example):
    decoder = p2os.FrameDecoder()
    assert decoder.feed(golden.wire(example)) + decoder.drop_partial() == []
    assert getattr(decoder.counts, example["count"]) >= 1
    assert decoder.counts.discarded_bytes == len(golden.wire(example))


@pytest.mark.parametrize("example", golden.DATA["streams"], ids=golden.label)
def test_stream(example):
    decoder = p2os.FrameDecoder()
    found = decoder.feed(golden.wire(example))
    assert found == [golden.frame(bytes.fromhex(whole)) for whole in example["finds"]]
    assert decoder.counts.discarded_bytes == example["discarded_bytes"]

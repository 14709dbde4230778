"""Packets from the robot: what the golden bytes do not show."""

import dataclasses
import enum
import random

import golden
import pytest

from pioneer_control import p2os
from pioneer_control.errors import EncodingError
from pioneer_control.p2os import packets as tables
from pioneer_control.wire_fields import NumberField, Record, Rest, TextField, rows

SIP = p2os.decode_packet(golden.frame(golden.wire(golden.SIP)))
CONFIG = p2os.decode_packet(golden.frame(golden.wire(golden.CONFIG)))
CLASSES = sorted({row[0] for row in tables.PACKETS.values()}, key=lambda packet_class: packet_class.__name__)


def again(packet, **order):
    """Return `packet` after sending and receiving it."""
    return p2os.decode_packet(golden.frame(p2os.encode_packet(packet, **order)), **order)


def some(kind, draw):
    """Return a random legal value of a wire type."""
    if isinstance(kind, NumberField):
        value = draw.choice([kind.low, kind.high, 0, 1, draw.randint(kind.low, kind.high)])
        return kind.names(value) if kind.names and issubclass(kind.names, enum.IntFlag) else value
    if isinstance(kind, TextField):
        return "".join(draw.choice("p3dx ~é") for _ in range(draw.randrange(9)))
    if isinstance(kind, Rest):
        return bytes(draw.randrange(256) for _ in range(draw.randrange(9)))
    if isinstance(kind, Record):
        return kind.record_class(**{row.name: some(row.type, draw) for row in rows(kind.record_class)})
    number = kind.count if isinstance(kind.count, int) else draw.randrange(5)
    return tuple(some(kind.item, draw) for _ in range(number))


@pytest.mark.parametrize("grip_state_first", [True, False])
@pytest.mark.parametrize("id", tables.PACKETS)
def test_round_trip(id, grip_state_first):
    """Seeded values in every field, with all optional fields or only the first few."""
    draw = random.Random(id)
    packet_class, said_by_id = tables.PACKETS[id]
    table = tables.packet_rows(packet_class, grip_state_first)
    for _ in range(20):
        sent = draw.randint(sum(not row.optional for row in table), len(table))
        packet = packet_class(**said_by_id, **{row.name: some(row.type, draw) for row in table[:sent]})
        assert again(packet, grip_state_first=grip_state_first) == packet


@pytest.mark.parametrize("packet_class", CLASSES)
def test_every_field_has_a_row(packet_class):
    """Every field is in the table, or its value comes from the id of the frame."""
    said = {name for known, said_by_id in tables.PACKETS.values() if known is packet_class for name in said_by_id}
    assert [f.name for f in dataclasses.fields(packet_class)] == [*said, *(row.name for row in rows(packet_class))] \
        or packet_class is p2os.SyncEcho
    assert packet_class.__doc__ and not packet_class.__doc__.startswith(packet_class.__name__ + "(")


@pytest.mark.parametrize("example", golden.PACKETS, ids=golden.label)
def test_data_that_end_anywhere(example):
    """When the data are cut short, missing optional fields are None. A missing necessary field makes the packet
    malformed, and is named.
    """
    frame = golden.frame(golden.wire(example))
    whole = p2os.decode_packet(frame)
    for end in range(len(frame.data)):
        packet = p2os.decode_packet(frame._replace(data=frame.data[:end]))
        if isinstance(packet, p2os.MalformedPacket):
            assert packet.data == frame.data[:end] and packet.reason.partition(".")[0] in {c.__name__ for c in CLASSES}
        elif type(packet) is type(whole) and isinstance(packet, (p2os.Sip, p2os.Config)):
            for name, value in vars(packet).items():
                assert value in (getattr(whole, name), None) or isinstance(value, str)


@pytest.mark.parametrize("id", range(256))
def test_no_data_raises(id):
    draw = random.Random(id)
    for length in [0, 1, 2, 3] + [draw.randrange(253) for _ in range(30)]:
        frame = p2os.Frame(id, bytes(draw.randrange(256) for _ in range(length)))
        packet = p2os.decode_packet(frame, draw.random() < 0.5)
        assert type(packet) in CLASSES + [p2os.UnknownPacket, p2os.MalformedPacket]
        if isinstance(packet, (p2os.UnknownPacket, p2os.MalformedPacket)):
            assert (packet.id, packet.data) == frame


def test_malformed_says_why():
    packet = p2os.decode_packet(p2os.Frame(0x90, b"\1\2\3\4\5\6"))
    assert packet == p2os.MalformedPacket(0x90, b"\1\2\3\4\5\6", "Encoder.right_ticks: needs 4 bytes, 2 left")
    packet = p2os.decode_packet(p2os.Frame(0x98, b"\2\0\2\x78\0"))
    assert packet.reason == "Gyro.readings: item 2 of 2: rate: needs 2 bytes, 1 left"


@pytest.mark.parametrize("length, last", [
    (27, "digital_out"),
    (30, "charge_state"),
    (32, "rotation_velocity_ddeg_s"),
    (34, "fault_flags"),
    (38, "state_of_charge_percent"),
    (46, "flags3"),
])
def test_where_firmware_ends_its_sip(length, last):
    """The byte count without sonar depends on the last field that the firmware sends (protocol sheet 4)."""
    names = [row.name for row in rows(p2os.Sip)]
    later = names[names.index(last) + 1:]
    full = {"battery_x10_dv": 1, "charge_state": 1, "rotation_velocity_ddeg_s": -1, "fault_flags": 1,
            "lateral_velocity_mm_s": -1, "temperature_c": -128, "state_of_charge_percent": 1, "controller_time_us": 1,
            "flags3": 1}
    packet = dataclasses.replace(SIP, sonar=(), **{**full, **dict.fromkeys(set(later) & set(full))})
    encoded = p2os.encode_packet(packet)
    assert encoded[2] == length
    assert again(packet) == packet


def test_order_of_the_bytes_behind_the_sonars():
    """The first byte behind the sonars is the gripper state on ARCOS, and the analog port on P2OS."""
    start = 23 + 3 * len(SIP.sonar)
    assert p2os.encode_packet(SIP)[start:start + 2] == b"\x21\x05"
    older = p2os.encode_packet(SIP, grip_state_first=False)
    assert older[start:start + 2] == b"\x05\x21"
    assert p2os.decode_packet(golden.frame(older), grip_state_first=False) == SIP
    mistaken = p2os.decode_packet(golden.frame(older))
    assert (mistaken.grip_state, mistaken.analog_port) == (5, 0x21)


def test_bits_are_those_of_the_names_and_unknown_ones_stay():
    assert SIP.flags == p2os.Flags.MOTORS_ENABLED | p2os.Flags.SONAR_1 | p2os.Flags.SONAR_2
    assert not SIP.flags & p2os.Flags.STOP_BUTTON
    assert again(dataclasses.replace(SIP, flags=0x8001)).flags == 0x8001
    assert again(dataclasses.replace(SIP, charge_state=4)).charge_state == p2os.ChargeState.BALANCE
    assert again(dataclasses.replace(SIP, charge_state=77)).charge_state == 77


def test_config_types():
    """The type column of protocol 5.1, fields 1 to 67: s string, b byte, t signed, i int, j signed, I 32 bits."""
    column = "sss b iiiii s bbb iib iii b iiii iiiiiiiiiiii bb bbbb j bb ii s ii b iiiii i b i t i b ii s I j"
    column = column.replace(" ", "")
    kinds = {"b": "B", "t": "b", "i": "H", "j": "h", "I": "I"}
    assert len(column) == 67
    assert [getattr(row.type, "letter", "") for row in rows(p2os.Config)] == [kinds.get(kind, "") for kind in column]


def test_config_of_older_firmware():
    fields = [row.name for row in rows(p2os.Config)]
    for last in range(2, len(fields)):
        packet = dataclasses.replace(CONFIG, **{name: None for name in fields[last + 1:]})
        assert again(packet) == packet


def test_config_takes_garbage_behind_its_fields():
    full = dataclasses.replace(CONFIG, power_board_port=1, gyro_rate_limit=2, high_temperature_shutdown_c=-128,
                               power_bits=3, battery_type=2, charge_low_percent=20, charge_shutdown_percent=10,
                               bootloader_version="1.0", config_flags=8, gyro_firmware_version=-1)
    frame = golden.frame(p2os.encode_packet(full))
    assert p2os.decode_packet(frame._replace(data=frame.data + b"garbage\0")) == full


def test_a_text_without_its_nul_is_taken():
    reply = p2os.decode_packet(p2os.Frame(2, b"a\0Pioneer\0p3at-sh"))
    assert reply == p2os.SyncReply("a", "Pioneer", "p3at-sh")


def test_batteries_of_a_longer_record():
    packet = p2os.decode_packet(p2os.Frame(0xFA, b"\2\6" + b"\1\2\3\x50\x40\xFF" + b"\4\5\6\x30\x20\xFF"))
    assert packet.batteries == (p2os.Battery(1, 2, 3, 80, 64), p2os.Battery(4, 5, 6, 48, 32))
    assert isinstance(p2os.decode_packet(p2os.Frame(0xFA, b"\1\4\1\2\3\4\5")), p2os.MalformedPacket)


@pytest.mark.parametrize("changes, says", [
    ({"x_counts": 65536}, "Sip.x_counts: 65536 is out of range (0..65535 is legal)"),
    ({"x_counts": -1}, "Sip.x_counts: -1 is out of range (0..65535 is legal)"),
    ({"heading_units": 32768}, "Sip.heading_units: 32768 is out of range (-32768..32767 is legal)"),
    ({"battery_dv": 12.8}, "Sip.battery_dv: 12.8 is not an integer (0..255 is legal)"),
    ({"flags": True}, "Sip.flags: True is not an integer (0..65535 is legal)"),
    ({"sonar": 3}, "Sip.sonar: 3 is not a sequence"),
    ({"sonar": (5,)}, "Sip.sonar[0]: 5 is not a SonarReading"),
    ({"sonar": (p2os.SonarReading(1, -1),)}, "SonarReading.range_units: -1 is out of range (0..65535 is legal)"),
    ({"analog": None}, "Sip.analog: None is not an integer (0..255 is legal)"),
    ({"x_counts": None}, "Sip.x_counts: None is not an integer (0..65535 is legal)"),
])
def test_what_does_not_fit_a_sip(changes, says):
    with pytest.raises(EncodingError) as error:
        p2os.encode_packet(dataclasses.replace(SIP, **changes))
    assert str(error.value) == says


@pytest.mark.parametrize("packet, says", [
    (p2os.SyncReply("a\0b", "", ""), "NUL"),
    (p2os.SyncReply("\u20ac", "", ""), "Latin-1"),
    (p2os.SyncReply(b"a", "", ""), "Latin-1"),
    (p2os.SyncReply("a" * 200, "", ""), "too many"),
    (p2os.Playlist(1, 1, "a" * 17, 0, 0), "17 characters"),
    (p2os.Arm(0, 0, (1, 2, 3)), "3 items"),
    (p2os.IO((1,) * 256, (), ()), "how many: 256 is out of range"),
    (p2os.SerialAux(1, "text"), "is not bytes"),
    (p2os.SerialAux(4, b""), "no robot sends"),
    (p2os.Sip(0x35, *[getattr(SIP, row.name) for row in rows(p2os.Sip)]), "no robot sends"),
    (p2os.SyncEcho(3), "no robot sends"),
    ("STOP", "no robot sends"),
])
def test_what_does_not_fit(packet, says):
    with pytest.raises(EncodingError, match=says):
        p2os.encode_packet(packet)


def test_packets_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        SIP.x_counts = 0


def test_the_public_names_exist():
    assert len(p2os.__all__) == len(set(p2os.__all__))
    assert all(hasattr(p2os, name) for name in p2os.__all__)

"""Every example telegram of the laser sheet is framed, encoded, and read field by field."""

import dataclasses
import math
import pathlib
import re

import pytest
import yaml

from pioneer_control import lms2xx
from pioneer_control.wire_fields import rows

FILE = pathlib.Path(__file__).parents[2] / "data" / "lms2xx-golden.yaml"
DATA = yaml.safe_load(FILE.read_text())
EXAMPLES = DATA["examples"]


def wire(text) -> bytes:
    """Return the bytes of a text with words such as 02 and 00x58."""
    return b"".join(bytes.fromhex(byte) * int(count or 1) for byte, count in re.findall(r"(\w\w)(?:x(\d+))?\b", text))


def label(example) -> str:
    return "%s %s" % (example["message"], example["bytes"][:26])


examples = pytest.mark.parametrize("example", EXAMPLES, ids=label)
scans = pytest.mark.parametrize("example", [each for each in EXAMPLES if "ranges" in each], ids=label)


def telegram(data: bytes) -> lms2xx.Telegram:
    """Return the telegram in `data`, cut by hand."""
    assert data[0] == 2 and len(data) == int.from_bytes(data[2:4], "little") + 6
    if data[1] & 0x80:
        return lms2xx.Telegram(data[4], data[5:-3], data[-3], data[1] & 0x7F)
    return lms2xx.Telegram(data[4], data[5:-2], None, data[1])


def expected(example):
    """Return the message of an example, made from what the data file says."""
    fields = dict(example["fields"])
    for name, value in fields.items():
        if name in ("text", "parameters", "pairs"):
            fields[name] = value.encode("latin-1")
    if "configuration" in fields:
        changed = {name: (0,) * 5 if value == "zeros" else value for name, value in fields["configuration"].items()}
        fields["configuration"] = dataclasses.replace(lms2xx.FACTORY, **changed)
    if "scan" in fields:
        scan = dict(fields["scan"])
        indices = lms2xx.Indices(*scan.pop("indices")) if "indices" in scan else None
        fields["scan"] = lms2xx.RawScan(tuple(scan.pop("values")), indices=indices, **scan)
    message = getattr(lms2xx, example["message"])
    for row in rows(message):
        if row.name.startswith("reserved_"):
            fields.setdefault(row.name, (0,) * getattr(row.type, "count", 0))
    return message(**fields)


def test_no_example_is_lost():
    """The sheet has 55 whole telegrams, and five long ones of which it gives begin and CRC."""
    assert len({example["bytes"] for example in EXAMPLES}) == len(EXAMPLES) == 55
    assert len(DATA["long_scans"]) == 5 and len(DATA["rejected"]) == 3


@examples
def test_framing(example):
    data = wire(example["bytes"])
    found = lms2xx.TelegramDecoder(from_laser=bool(data[1] & 0x80)).feed(data)
    assert found == [telegram(data)]
    assert lms2xx.encode_telegram(found[0]) == data
    assert lms2xx.crc(data[:-2]) == int.from_bytes(data[-2:], "little")


@examples
def test_message(example):
    data, message = wire(example["bytes"]), expected(example)
    assert lms2xx.decode(telegram(data)) == message
    assert telegram(data).status == (example.get("status", 0x10) if data[1] & 0x80 else None)
    assert lms2xx.encode(message, example.get("status", lms2xx.WELL), example.get("address", 0)) == data


@examples
def test_every_byte_counts(example):
    """A changed byte of the data gives another message."""
    one = telegram(wire(example["bytes"]))
    original = lms2xx.decode(one)
    for at in range(len(one.data)):
        other = bytes((*one.data[:at], one.data[at] ^ 0x01, *one.data[at + 1:]))
        assert lms2xx.decode(one._replace(data=other)) != original, at


@pytest.mark.parametrize("long", DATA["long_scans"], ids=lambda long: "%(count)d unit %(unit)d" % long)
def test_long_scans(long):
    values = tuple(long.get("value", 1000 + index) for index in range(long["count"]))
    scan = lms2xx.RawScan(values, long["unit"], long.get("partial", False), long.get("quarter", 0))
    data = lms2xx.encode(lms2xx.ScanReply(scan))
    assert (data[:7], data[-2:]) == (wire(long["begins"]), wire(long["crc"]))
    [found] = lms2xx.TelegramDecoder(from_laser=True).feed(data)
    assert lms2xx.decode(found) == lms2xx.ScanReply(scan)


@pytest.mark.parametrize("example", DATA["rejected"], ids=lambda example: example["why"])
def test_misprints_are_no_telegrams(example):
    data = wire(example["bytes"])
    decoder = lms2xx.TelegramDecoder(from_laser=bool(data[1] & 0x80))
    found = decoder.feed(data) + decoder.drop_partial()
    assert [each for each in found if isinstance(each, lms2xx.Telegram)] == []
    assert decoder.counts.wrong_crcs >= 1
    assert decoder.counts.discarded_bytes + decoder.counts.answers == len(data)


@scans
def test_ranges(example):
    scan = lms2xx.decode(telegram(wire(example["bytes"]))).scan
    mode = lms2xx.MEASURING_MODES[example["measuring_mode"]]
    ranges = lms2xx.ranges_m(scan, mode).tolist()
    assert len(ranges) == len(example["ranges"])
    for found, wanted in zip(ranges, example["ranges"]):
        assert found == pytest.approx(wanted, nan_ok=True) or (math.isinf(wanted) and math.isinf(found))
    assert lms2xx.reflector_levels(scan, mode).tolist() == example.get("levels", [])


@pytest.mark.parametrize("mode, flags", [(0, 0), (0, 0x8000), (1, 0xE000), (3, 0xC000), (5, 0x8000)])
def test_rays_without_a_distance_are_counted_by_their_reason(mode, flags):
    full = 1 << lms2xx.MEASURING_MODES[mode].distance_bits
    values = [full + code | flags for code in (-1, -1, -2, -3, -5, -6, -9, -4, -7, -10)] + [1000]
    counts = lms2xx.codes_in(lms2xx.RawScan(tuple(values)), lms2xx.MEASURING_MODES[mode])
    assert counts == {"no echo came back": 2, "dazzled": 1, "overflow": 1, "too much noise": 1, "read error": 1,
                      "farther than it measures": 1}
    assert lms2xx.codes_in(lms2xx.RawScan((0xFFFF,)), lms2xx.MEASURING_MODES[0x0F]) == {}


@pytest.mark.parametrize("row", DATA["rates"], ids=lambda row: "%(angle)d %(step)d" % row)
def test_rates(row):
    variant = lms2xx.Variant(row["angle"], row["step"])
    assert lms2xx.scan_bytes(variant.values) == row["bytes"]
    assert 1.0 / (variant.turns * lms2xx.TURN_S) == pytest.approx(row["laser"])
    for baud, most in row["lines"].items():
        rate = 1.0 / lms2xx.scan_time(variant, baud)
        assert rate <= most + 0.05, "no line carries more than it can"
        # It sends only scans that it finished: fewer by less than one finished scan between two
        assert 1.0 / rate - 1.0 / most < variant.turns * lms2xx.TURN_S + 0.01


def test_the_rate_that_was_seen_on_a_real_laser():
    """An LMS200 at 38400 baud and half a degree sent 4.7 scans a second (sheet 1.8)."""
    assert 1.0 / lms2xx.scan_time(lms2xx.Variant(180, 50), 38400) == pytest.approx(4.7, abs=0.05)


def test_a_finer_step_by_100_degrees_alone():
    assert lms2xx.Variant(180, 25) not in lms2xx.VARIANTS and len(lms2xx.VARIANTS) == 5

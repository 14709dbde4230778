"""The golden packets of test/data/p2os-golden.yaml, ready for tests."""

import pathlib

import yaml

from pioneer_control import p2os

FILE = pathlib.Path(__file__).parents[2] / "data" / "p2os-golden.yaml"
DATA = yaml.safe_load(FILE.read_text())
EXAMPLES = DATA["examples"]
COMMANDS = [example for example in EXAMPLES if "command" in example]
PACKETS = [example for example in EXAMPLES if "packet" in example]
SIP = next(example for example in PACKETS if example["packet"] == "Sip")
CONFIG = next(example for example in PACKETS if example["packet"] == "Config")


def wire(example) -> bytes:
    """Return the bytes of an example."""
    return bytes.fromhex(example["bytes"])


def label(example) -> str:
    """Return the name of an example in a test report."""
    return f"{example['where']} {example['bytes'][:26]}" if "where" in example else example["meaning"]


def frame(data: bytes) -> p2os.Frame:
    """Return the frame in `data`, cut by hand. The tests of packets do not use the decoder of frames."""
    assert data[:2] == b"\xFA\xFB" and len(data) == data[2] + 3
    return p2os.Frame(data[3], data[4:-2])


def command_values(example) -> tuple:
    """Return name and values of a command. Strings are bytes."""
    name, *values = example["command"]
    return (name, *(bytes.fromhex(value) if isinstance(value, str) else value for value in values))


def matches(value, expected, names=None) -> bool:
    """Return whether a decoded value is the one in the data file: bits by `names`, bytes as hex, records as mappings.
    """
    if isinstance(value, int) and isinstance(expected, list):
        return value == sum(names[name] for name in expected)
    if isinstance(value, bytes):
        return value == bytes.fromhex(expected)
    if isinstance(value, tuple) and not isinstance(expected, dict):
        return len(value) == len(expected) and all(map(matches, value, expected))
    if isinstance(expected, dict):
        fields = value._asdict()
        return set(fields) == set(expected) and all(matches(fields[name], expected[name]) for name in fields)
    return value == expected

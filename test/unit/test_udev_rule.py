"""The udev rule that gives the robot's port its name. udev understands every line, and each does what the file says."""

import pathlib
import re

import pytest

from pioneer_control.laser.parameters import LaserParameters

ROOT = pathlib.Path(__file__).resolve().parents[2]
RULES = ROOT / "config" / "99-pioneer.rules"

TOKEN = re.compile(r'(?P<key>[A-Z]+)(?:\{(?P<attribute>\w+)\})?(?P<operator>==|!=|[+-]=|:=|=)"(?P<value>[^"]*)"')
MATCHES = {"ACTION", "SUBSYSTEM", "DRIVER", "ATTRS"}
SETS = {"SYMLINK": ("+=", "-="), "GROUP": ("=",), "MODE": ("=",), "ENV": ("=",), "ATTR": ("=",)}
WITH_ATTRIBUTE = {"ATTRS", "ATTR", "ENV"}


def tokens(line):
    """Return the parts of a rule. Raises ValueError for a rule that udev would reject, or that only compares or only
    sets.
    """
    found = []
    for part in line.split(","):
        token = TOKEN.fullmatch(part.strip())
        if token is None:
            raise ValueError("not key, operator, value: %s" % part)
        key, attribute, operator, value = token.group("key", "attribute", "operator", "value")
        if operator not in (("==",) if key in MATCHES else SETS.get(key, ())):
            raise ValueError("%s does not go with %s" % (key, operator))
        if (attribute is not None) != (key in WITH_ATTRIBUTE):
            raise ValueError("%s and its attribute %s" % (key, attribute))
        found.append((key if attribute is None else "%s{%s}" % (key, attribute), operator.strip("+=:") + value))
    if len(dict(found)) != len(found):
        raise ValueError("twice the same key: %s" % line)
    keys = {key.partition("{")[0] for key, _ in found}
    if not MATCHES & keys or not set(SETS) & keys:
        raise ValueError("compares or sets nothing: %s" % line)
    return dict(found)


def rules():
    return [tokens(line) for line in RULES.read_text(encoding="ascii").splitlines() if line and
            not line.startswith("#")]


def test_every_adapter_is_named_for_the_group_that_may_use_it():
    adapters = [rule for rule in rules() if rule["SUBSYSTEM"] == "tty" and "ATTRS{idVendor}" in rule]
    for rule in adapters:
        assert (rule["SYMLINK"], rule["GROUP"], rule["MODE"],
                rule["ENV{ID_MM_DEVICE_IGNORE}"]) == ("pioneer", "dialout", "0660", "1")
        assert (re.fullmatch("[0-9a-f]{4}", rule["ATTRS{idVendor}"]) and
                re.fullmatch("[0-9a-f]{4}", rule["ATTRS{idProduct}"]))
    ids = [(rule["ATTRS{idVendor}"], rule["ATTRS{idProduct}"]) for rule in adapters]
    assert len(set(ids)) == len(ids) and {("0403", "6001"), ("067b", "2303"), ("06cd", "0121")} <= set(ids)


def test_the_other_rule_only_hastens_ftdi_adapters():
    other, = (rule for rule in rules() if rule["SUBSYSTEM"] != "tty")
    assert other == {"ACTION": "add", "SUBSYSTEM": "usb-serial", "DRIVER": "ftdi_sio", "ATTR{latency_timer}": "1"}


def test_the_lasers_adapter_is_told_by_its_number_and_loses_the_robots_name():
    """The rules of the robot come before it, and may name it."""
    tty = [rule for rule in rules() if rule["SUBSYSTEM"] == "tty"]
    no_more, named = tty[-2:]
    number = named["ATTRS{serial}"]
    assert no_more == {"SUBSYSTEM": "tty", "ATTRS{serial}": number, "SYMLINK": "-pioneer"}
    assert named == {"SUBSYSTEM": "tty", "ATTRS{serial}": number, "SYMLINK": "lms200", "GROUP": "dialout",
                     "MODE": "0660", "ENV{ID_MM_DEVICE_IGNORE}": "1"}
    assert LaserParameters().port == "/dev/" + named["SYMLINK"]
    assert [rule for rule in rules() if "ATTRS{serial}" in rule] == [no_more, named]


def test_it_is_installed_with_the_package():
    assert re.search(r"install\(DIRECTORY [^)]*\bconfig\b", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))


@pytest.mark.parametrize("line", [
    'SUBSYSTEM=="tty", GROUP-="dialout"', 'SUBSYSTEM="tty", SYMLINK+="pioneer"', 'SUBSYSTEM=="tty", SYMLINK=="pioneer"',
    'SUBSYSTEM=="tty" SYMLINK+="pioneer"', "SUBSYSTEM==tty, MODE=0660",
    'SUBSYSTEM=="tty", ATTRS=="0403", SYMLINK+="pioneer"', 'SUBSYSTEM=="tty"', 'SYMLINK+="pioneer"',
    'SUBSYSTEM=="tty", SYMLINKS+="pioneer"',
    'SUBSYSTEM=="tty", GROUP{a}="dialout"', 'SUBSYSTEM=="tty", MODE="0660", MODE="0666"',
    'SUBSYSTEM=="tty", MODE="0660",', "",
])
def test_a_line_that_udev_would_not_take_is_none(line):
    with pytest.raises(ValueError):
        tokens(line)

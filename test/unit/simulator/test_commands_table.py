"""The table of commands. It has every command, old firmware lacks what the protocol sheet says, and the page for users
shows what the code does.
"""

import copy
import pathlib
import re

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.p2os import COMMANDS, UNKNOWN_TO, Argument
from pioneer_control.robots.table import FAMILIES
from pioneer_control.simulator.firmware.laser_orders import DOES
from pioneer_control.simulator.firmware.commands import HANDLERS, IGNORED, LETTERS
from pioneer_control.simulator.hardware import standard_numbers

PAGE = pathlib.Path(__file__).resolve().parents[3] / "docs" / "simulator-commands.md"
ONE_OF_EACH = {
    "PSOS": "pion1m", "P2OS": "p2dx", "AmigOS": "amigo", "AROS": "p3dx",
    "ARCOS": "p3dx-sh", "AmigoSH": "amigo-sh", "uARCS": "seekur", "MARCOS": "pioneer-lx",
}


COLUMNS = ("PSOS", "P2OS", "AmigOS", "AROS", "ARCOS")
"""Families that the page has a column for; AmigoSH, uARCS and MARCOS are as ARCOS."""


def documented():
    """Return the rows of the page, by number: number, name, whether each of `COLUMNS` obeys, and what it does or why
    nothing.
    """
    for command in sorted(COMMANDS.values()):
        handler = HANDLERS.get(command.name)
        if handler is None:
            known, does = ["-"] * len(COLUMNS), "ignored: %s" % IGNORED[command.name]
        else:
            known = ["yes" if handler.known_to(family) else "-" for family in COLUMNS]
            does = ("" if "yes" in known else "MARCOS only: ") + handler.does
        yield [str(command.number), command.name, *known, does]


def missing_rows(text):
    """Return the rows that the page must have and does not have."""
    lines = set(text.splitlines())
    return [row for row in documented() if "| %s |" % " | ".join(row) not in lines]


def test_every_command_is_obeyed_or_ignored_for_a_reason():
    assert set(HANDLERS) | set(IGNORED) == set(COMMANDS) and not set(HANDLERS) & set(IGNORED)
    assert set(LETTERS) == set(FAMILIES) == set(ONE_OF_EACH)


def test_the_page_shows_the_table():
    """When this fails, the message has the rows that docs/simulator-commands.md needs."""
    text = PAGE.read_text(encoding="utf-8")
    assert ["| %s |" % " | ".join(row) for row in missing_rows(text)] == []
    rows = [line for line in text.partition("## Commands")[2].partition("\nNumbers that only")[0].splitlines()
            if line.startswith("| ") and line.split("|")[1].strip().isdigit()]
    assert len(rows) == len(COMMANDS)


def test_a_row_that_lies_is_seen():
    assert len(missing_rows(PAGE.read_text(encoding="utf-8").replace("MOVE | - |", "MOVE | yes |"))) == 1


def missing_orders(text):
    """Return the rows of commands of simulators that the page must have and does not have."""
    rows = ["| %d | %s | %s |" % (order.number, name, DOES[name]) for name, order in p2os.SIMULATOR_COMMANDS.items()]
    return [row for row in rows if row not in text.splitlines()]


def test_the_page_shows_the_commands_of_simulators():
    text = PAGE.read_text(encoding="utf-8")
    assert missing_orders(text) == [] and set(DOES) == set(p2os.SIMULATOR_COMMANDS)
    assert len(missing_orders(text.replace("| 230 | SIM", "| 231 | SIM"))) == 1


def unknown_numbers(text):
    """Return `section.name` that the page names and robot.yaml does not have. `section.*` stands for all."""
    named = re.findall(r"`([a-z]+)\.([a-z_]+|\*)`", text)
    numbers = standard_numbers()

    def known(section, name):
        return hasattr(numbers, section) and (name == "*" or hasattr(getattr(numbers, section), name))

    return [names for names in named if not known(*names)]


def test_the_numbers_that_the_page_names_are_there():
    text = PAGE.read_text(encoding="utf-8")
    assert unknown_numbers(text) == [] and "`gyro.kind`" in text
    assert unknown_numbers(text.replace("gyro.kind", "gyro.type")) == [("gyro", "type")]


def test_it_agrees_with_what_clients_are_told_of_old_firmware():
    """A command that clients treat as unknown to a family is unknown to the simulated robot of this family, too. The
    test compares only PSOS, P2OS, AROS and ARCOS.
    """
    for name, families in UNKNOWN_TO.items():
        unknown_to = {family for family in FAMILIES if not HANDLERS[name].known_to(family)}
        assert unknown_to >= set(families) & {"PSOS", "P2OS", "AROS", "ARCOS"}, name


# What section 3 of the protocol notes says of each command in its column "fw", copied from there:
# S PSOS, P P2OS, A AROS, C ARCOS, G AmigOS.
SHEET = """
0 SPAC 1 SPAC 2 SPAC 3 SPAC 5 PAC 6 SPAC 7 SPAC 8 PAC 9 PAC 10 SPAC 11 SPAC
12 SPAC 13 SPAC 14 C 20 C 21 SPAC 22 PAC 23 PAC 29 PAC 32 SPAC 55 PAC
15 SPAC 17 AC 18 PAC 19 PAC 37 PAC 40 PAC 58 AC 62 C 91 PA
28 SPAC 30 SPAC 35 PAC 38 C 39 C 45 PAC 46 P 47 PAC 48 AC 68 AC 92 AC
44 PAC 56 PAC 82 PAC 83 PAC 84 PAC 85 PAC 86 PAC 87 PAC 88 PAC 89 C 93 C 250 C 253 C
"""


@pytest.mark.parametrize("number, letters", zip(*[iter(SHEET.split())] * 2))
def test_who_knows_a_command_is_as_the_protocol_says(number, letters):
    name, = (command.name for command in COMMANDS.values() if command.number == int(number))
    families = {"S": "PSOS", "P": "P2OS", "A": "AROS", "C": "ARCOS"}
    assert {letter for letter, family in families.items() if HANDLERS[name].known_to(family)} == set(letters)


def sensible(command):
    """Return a legal value for a command."""
    if command.argument is Argument.NONE:
        return ()
    if command.argument is Argument.STRING:
        return (b"\x01\x02",)
    return command.high if command.argument is Argument.TWO_BYTES else (max(1, min(command.high, 2)),)


@pytest.mark.parametrize("family, model", sorted(ONE_OF_EACH.items()))
def test_each_family_counts_what_it_knows_as_obeyed_and_all_else_as_unknown(family, model):
    bench = Bench(model).open(motors=False)
    for command in COMMANDS.values():
        if command.name in ("CLOSE", "RESET"):      # it would be over
            continue
        before = copy.copy(bench.robot.command_counts)
        bench.robot.receive(p2os.encode_command(command.name, *sensible(command)))
        after = bench.robot.command_counts
        known = command.name in HANDLERS and HANDLERS[command.name].known_to(family)
        assert after - before == {"obeyed" if known else "unknown": 1}, command.name
        bench.wait(0.02)
    assert bench.wait(1.0).sips


def test_a_command_without_the_value_it_needs_changes_nothing():
    bench = Bench().open()
    for name, handler in HANDLERS.items():
        if handler.value is not None and handler.known_to("ARCOS"):
            before = bench.robot.command_counts["senseless"]
            bench.robot.receive(p2os.encode_frame(COMMANDS[name].number))
            assert bench.robot.command_counts["senseless"] == before + 1, name

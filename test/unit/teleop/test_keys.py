"""Bytes of a terminal to keys."""

import pytest

from pioneer_control.teleop.keys import ACTIONS, BACKLOG, DRIVE, HELP, Keyboard


@pytest.mark.parametrize("data, keys", [
    (b"w", ["w"]), (b"W", ["w"]), (b" ", ["space"]), (b"\x1b[A", ["up"]), (b"\x1bOD", ["left"]),
    (b"\x1b[B\x1b[C", ["down", "right"]),
    (b"\x1b[15~", ["\x1b[15~"]), (b"\x1b[1;5A", ["\x1b[1;5a"]), (b"wa", ["w", "a"]), (b"", []), (b"\xff", ["\xff"]),
])
def test_keys(data, keys):
    assert Keyboard().keys(data) == keys


def test_an_arrow_may_come_in_pieces():
    keyboard = Keyboard()
    assert [keyboard.keys(piece) for piece in (b"w\x1b", b"[", b"A")] == [["w"], [], ["up"]]


def test_what_comes_in_a_heap_is_old_and_only_a_stop_in_it_counts():
    assert Keyboard().keys(b"w" * (BACKLOG - 1)) == ["w"] * (BACKLOG - 1)
    assert Keyboard().keys(b"w" * BACKLOG) == []
    assert Keyboard().keys(b"www w m www") == ["space"]
    assert Keyboard().keys(b"mmmmmmm") == []


def test_no_key_has_two_meanings_and_the_help_names_every_action():
    assert not set(DRIVE) & set(ACTIONS)
    assert all(action.words in HELP for action in ACTIONS.values())
    assert HELP % 0.6

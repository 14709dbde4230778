"""The lines to and from one program at the socket."""

import pytest

from pioneer_control.simulator.truth.visit import LONGEST_LINE, MOST_ANSWERS, ORDERS_IN_A_TURN, Visit


def orders(visit):
    """Take all orders that may be taken now."""
    taken = []
    while visit.has_order:
        taken.append(visit.take_order())
    return taken


def read(visit, size=1000):
    """Read everything that there is to send, as a program that reads pieces of this size."""
    data = b""
    while visit.unsent:
        data += visit.unsent[:size]
        visit.sent(min(size, len(visit.unsent)))
    return data


@pytest.mark.parametrize("pieces", [
    [b"one\ntwo\n"], [b"one", b"\ntw", b"o\n"], [bytes([byte]) for byte in b"one\ntwo\n"],
    [b"\n\none\n  \n\r\ntwo\nnot yet"]])
def test_lines_come_in_any_pieces(pieces):
    visit, taken = Visit(b""), []
    for piece in pieces:
        visit.receive(piece)
        taken += orders(visit)
    assert taken == [b"one", b"two"]


def test_a_line_that_is_too_long_is_skipped_to_its_end():
    visit = Visit(b"")
    visit.receive(b"x" * LONGEST_LINE + b"\n")
    assert orders(visit) == [b"x" * LONGEST_LINE]
    visit.receive(b"x" * LONGEST_LINE)
    for _ in range(100):
        visit.receive(b"y" * LONGEST_LINE)
        assert orders(visit) == [] and len(visit._part) == 0
    visit.receive(b"z\nnext\n")
    assert orders(visit) == [None, b"next"]


def test_not_all_orders_are_taken_in_one_turn():
    visit = Visit(b"")
    visit.receive(b"a\n" * (ORDERS_IN_A_TURN + 3))
    assert len(orders(visit)) == ORDERS_IN_A_TURN and not visit.may_send
    visit.begin_turn()
    assert len(orders(visit)) == 3 and visit.may_send


def test_no_order_is_taken_from_a_program_that_does_not_read():
    visit, answered = Visit(b"hello\n"), 0
    for _ in range(50):
        visit.begin_turn()
        if visit.may_send:
            visit.receive(b"a\n" * 30)
        for _ in orders(visit):
            visit.answer(b"%d\n" % answered)
            answered += 1
    assert answered < MOST_ANSWERS + ORDERS_IN_A_TURN and not visit.may_send
    assert read(visit).split() == [b"hello"] + [b"%d" % number for number in range(answered)]
    visit.begin_turn()
    assert orders(visit) != []


@pytest.mark.parametrize("size", [1, 3, 1000])
def test_the_greeting_comes_first_and_answers_come_before_news(size):
    visit = Visit(b"hello\n")
    visit.tell(b"news\n")
    visit.answer(b"answer\n")
    assert read(visit, size) == b"hello\nanswer\nnews\n"


@pytest.mark.parametrize("size", [1, 3, 1000])
def test_another_greeting_comes_before_the_state_that_belongs_to_it(size):
    visit = Visit(b"hello\n")
    read(visit, size)
    visit.tell(b"old\n")
    visit.greet(b"hi\n")
    visit.greet(b"hi again\n")
    visit.answer(b"answer\n")
    visit.tell(b"new\n")
    assert read(visit, size) == b"hi again\nanswer\nnew\n", "only the newest greeting, and no state from before it"
    visit.tell(b"new\n")
    visit.greet(b"hi\n")
    visit.tell(b"new\n")
    assert read(visit) == b"hi\nnew\n", "the same state again"


def test_who_reads_slowly_gets_whole_lines_and_only_the_newest_state():
    visit = Visit(b"hello\n")
    visit.sent(len(visit.unsent))
    for number in range(1000):
        visit.tell(b"state %d\n" % number)
        if number == 0:
            visit.sent(len(visit.unsent[:3]))
    assert read(visit) == b"te 0\nstate 999\n"


def test_the_same_state_is_not_told_twice():
    visit = Visit(b"hello\n")
    read(visit)
    for state in (b"a\n", b"a\n", b"b\n", b"a\n"):
        visit.tell(state)
        told = read(visit)
        visit.tell(state)
        assert read(visit) == b"" and told in (state, b"")
    assert told == b"a\n"

"""The conversation with one program that is connected to the simulator: its lines come in, ours go out.

This file uses no socket, no thread and no real time. Whatever the program sends, and however slowly it reads, the
memory for it stays small: of the worlds and states that it has not read, only the newest are kept.
"""

import collections
from typing import Deque, Optional

LONGEST_LINE = 64 * 1024
"""Largest number of bytes of a line from the program, without its newline. A longer line is skipped."""
ORDERS_IN_A_TURN = 20
"""Largest number of orders that are taken in one turn. The others wait, so that no program slows down the robots."""
MOST_ANSWERS = 100
"""Number of answers that the program has not read, from which no further order is taken."""


class Visit:
    """The lines from one program, and those to it.

    Args:
        greeting: the first line for the program.
    """

    def __init__(self, greeting: bytes):
        self._part = b""                # the beginning of a line whose end has not come
        self._too_long = False          # this line is skipped
        self._orders: Deque[Optional[bytes]] = collections.deque()
        self._orders_left = ORDERS_IN_A_TURN
        self._answers: Deque[bytes] = collections.deque()
        self._sending = b""
        self.greet(greeting)

    def begin_turn(self) -> None:
        """Begin another turn, in which `ORDERS_IN_A_TURN` may be taken."""
        self._orders_left = ORDERS_IN_A_TURN

    # -- from the program

    def receive(self, data: bytes) -> None:
        """Receive bytes from the program."""
        *ended, rest = data.split(b"\n")
        for piece in ended:
            self._add(piece)
            if self._too_long or self._part.strip():
                self._orders.append(None if self._too_long else self._part)
            self._part, self._too_long = b"", False
        self._add(rest)

    def _add(self, piece: bytes) -> None:
        self._too_long |= len(self._part) + len(piece) > LONGEST_LINE
        self._part = b"" if self._too_long else self._part + piece

    @property
    def may_send(self) -> bool:
        """Whether the program may send more, because all its orders are taken."""
        return not self._orders

    @property
    def has_order(self) -> bool:
        """Whether an order may be taken now: there is one, the turn allows it, and there are not many unread answers.
        """
        return bool(self._orders) and self._orders_left > 0 and len(self._answers) < MOST_ANSWERS

    def take_order(self) -> Optional[bytes]:
        """Return the line of the oldest order, and forget it. None for a line that was too long."""
        self._orders_left -= 1
        return self._orders.popleft()

    # -- to the program

    def greet(self, line: bytes) -> None:
        """Send a line that must come before all others, instead of an older one that still waits.

        A state that waits is dropped: it was of the world before.
        """
        self._greeting, self._told, self._news = line, b"", b""

    def answer(self, line: bytes) -> None:
        """Send a line that the program must get."""
        self._answers.append(line)

    def tell(self, news: bytes) -> None:
        """Send a line with the newest state, instead of an older one that still waits. Do not send the same twice."""
        if news != self._told:
            self._told = self._news = news

    @property
    def unsent(self) -> bytes:
        """The bytes to send now: one line, or the rest of one. Empty if there is nothing to send."""
        if not self._sending and self._greeting:
            self._sending, self._greeting = self._greeting, b""
        elif not self._sending and self._answers:
            self._sending = self._answers.popleft()
        elif not self._sending:
            self._sending, self._news = self._news, b""
        return self._sending

    def sent(self, count: int) -> None:
        """Note that the first `count` bytes of `unsent` have been sent."""
        self._sending = self._sending[count:]

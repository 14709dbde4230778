"""The person at the terminal: what is said, what is asked, and the key that must be held while the robot drives."""

import os
import select
import sys
import time
from typing import Any, Callable, ContextManager, List

from ..errors import PioneerError
from ..teleop.hand import STAND, KeyHand
from ..teleop.keys import DRIVE, Keyboard

HELD = DRIVE["w"]
"""What the key that is held means. The keys that mean it: w, and the arrow up."""
LOOK_AGAIN = 0.1
"""Time (s) between two looks whether the program is to end, while it waits for an answer."""
QUIET = 0.7
"""Time (s) without a key after which it is let go. A terminal repeats a held key after 0.6 s at most."""


class TerminalClosed(PioneerError):
    """There is nobody at the terminal any more, or the program ends."""


class HeldKey:
    """Whether the key that drives is held: bytes of a terminal in, time (monotonic, s) is an argument. Pure."""

    def __init__(self) -> None:
        self._keyboard, self._hand = Keyboard(), KeyHand()

    def take(self, data: bytes, now: float) -> None:
        """Take what was typed. Any other key lets go."""
        for key in self._keyboard.keys(data):
            if DRIVE.get(key) == HELD:
                self._hand.press(HELD, now)
            else:
                self._hand.let_go()

    def held(self, now: float) -> bool:
        """Return whether the key is held now."""
        return self._hand.wish(now) != STAND


class Terminal:
    """A terminal, or a pipe with the answers.

    Args:
        source: the file descriptor of what is typed.
        ended: returns whether the program is to end.
        each_key: a context in which a terminal tells each key at once; see teleop.
        screen: where to write.
    """

    def __init__(self, source: int, ended: Callable[[], bool], each_key: Callable[[int], ContextManager[None]],
                 screen: Any = sys.stdout) -> None:
        self._source, self._ended, self._screen = source, ended, screen
        self._each_key = each_key
        self._typed = b""

    def say(self, text: str) -> None:
        """Tell the person something."""
        self._screen.write(text + "\n")
        self._screen.flush()

    def ask(self, question: str) -> str:
        """Ask the person something. Return the answer, one line without its end.

        Raises:
            TerminalClosed: there is no answer any more.
        """
        self._screen.write(question)
        self._screen.flush()
        while b"\n" not in self._typed:
            self._typed += self._read(LOOK_AGAIN)
        line, self._typed = self._typed.split(b"\n", 1)
        if not os.isatty(self._source):
            self.say(line.decode(errors="replace"))
        return line.decode(errors="replace")

    def _read(self, timeout: float) -> bytes:
        """Return what was typed within a time (s).

        Raises:
            TerminalClosed: there is nobody any more.
        """
        if self._ended():
            raise TerminalClosed("the program ends")
        ready: List[Any] = select.select([self._source], [], [], timeout)[0]
        if not ready:
            return b""
        data = os.read(self._source, 4096)
        if not data:
            raise TerminalClosed("nobody answers: the terminal, or what was piped in, has ended")
        return data

    def hold(self, step: Callable[[bool, float], bool], period: float) -> None:
        """Call ``step`` again and again, until it returns False.

        Args:
            step: it gets whether the key is held, and the time (monotonic, s).
            period: the longest time (s) between two calls. Each key is a call, too.

        Raises:
            TerminalClosed: there is nobody any more.
        """
        key = HeldKey()
        self._typed = b""
        with self._each_key(self._source):
            while True:
                key.take(self._read(period), time.monotonic())
                now = time.monotonic()
                if not step(key.held(now), now):
                    break
            self.say("Let go of the key.")
            quiet_since = time.monotonic()
            # a key that is still held is no answer to what is asked next
            while time.monotonic() - quiet_since < QUIET:
                if self._read(QUIET / 4):
                    quiet_since = time.monotonic()

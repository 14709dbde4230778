"""What the keys of a terminal do: bytes to keys, and keys to wishes and actions. Pure."""

import re
from typing import Dict, List, NamedTuple

from .hand import Wish

BACKLOG = 4
"""So many keys in one piece were not pressed just now: the connection of the terminal was held up."""

DRIVE: Dict[str, Wish] = {
    "up": Wish(1, 0), "w": Wish(1, 0),
    "down": Wish(-1, 0), "s": Wish(-1, 0),
    "left": Wish(0, 1), "a": Wish(0, 1),
    "right": Wish(0, -1), "d": Wish(0, -1),
    "q": Wish(1, 0.5), "e": Wish(1, -0.5),
}
"""The keys that drive. A terminal tells only one held key, so q and e drive curves."""


class Action(NamedTuple):
    """What a key does besides driving: its name, and the words for the help."""

    name: str
    words: str


ACTIONS: Dict[str, Action] = {
    "space": Action("stop", "STOP: nothing moves until u"),
    "u": Action("unlock", "unlock after a STOP"),
    "m": Action("motors_on", "motors on"),
    "n": Action("motors_off", "motors off"),
    "+": Action("faster", "raise the speed limit"),
    "-": Action("slower", "lower it"),
    "o": Action("open", "open the gripper"),
    "c": Action("close", "close it"),
    "l": Action("up", "lift up"),
    "k": Action("down", "lift down"),
    "r": Action("release", "give the helm back to programs"),
}
"""The keys that act once. Each lets go of the keys that drive."""

SPECIAL = {b"\x1b[A": "up", b"\x1b[B": "down", b"\x1b[C": "right", b"\x1b[D": "left",
           b"\x1bOA": "up", b"\x1bOB": "down", b"\x1bOC": "right", b"\x1bOD": "left", b" ": "space"}
_KEY = re.compile(rb"\x1b[\[O][0-9;]*[A-Za-z~]|\x1b[\[O]?\Z|[\x00-\xff]", re.DOTALL)

HELP = """
  w or up     forward         q  e   forward in a curve
  s or down   backward        a  d, or left and right   turn
""" + "".join("  %-11s %s\n" % (key, action.words) for key, action in ACTIONS.items()) + """  Ctrl-C      end

Hold a key to drive: let go, and the robot stands within %.1f s.
"""


class Keyboard:
    """Splits the bytes of a terminal into keys. An arrow key is several bytes, which may come in two pieces."""

    def __init__(self) -> None:
        self._rest = b""

    def keys(self, data: bytes) -> List[str]:
        """Return the keys in a piece that was read at once, by the names in the tables; other keys by their character.

        When there are more than a hand presses at once (BACKLOG), they are old: only STOP counts then.
        """
        found = []
        pieces = _KEY.findall(self._rest + data)
        self._rest = pieces.pop() if pieces and pieces[-1] in (b"\x1b", b"\x1b[", b"\x1bO") else b""
        for piece in pieces:
            found.append(SPECIAL.get(piece, piece.decode("latin-1").lower()))
        return found if len(found) < BACKLOG else [key for key in found if key == "space"][:1]

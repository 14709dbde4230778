"""What each viewer gets, and when. Pure: no socket, no thread, and time (monotonic, s) is an argument.

A `Fleet` keeps the newest frame of each robot and the newest text of each kind. Whoever serves viewers calls it so::

    fleet.frame(frame)                    # or text() or said(): something new came
    if fleet.wait(now) <= 0:              # else call again after so many seconds
        for viewer, messages in fleet.round(now, can_take):
            ...                           # send each message: text (str) or binary (bytes)

Nothing here grows: of what a viewer has not got yet only the newest is kept, and a viewer that reads too slowly for
what is said is sent away.

==================  ===================================================================================================
frames              of all robots in one message, at most every BATCH s; a frame after a pause goes at once
no ``drawn``        for ACKNOWLEDGE s after a batch: no frames until it comes, then the newest
texts               at once; a viewer whose socket takes nothing gets later the newest of each kind
too many messages,  a Farewell: a code of the page's protocol, and the reason for people
viewers, ...
==================  ===================================================================================================
"""

import json
import math
from collections import OrderedDict, deque
from typing import Any, Callable, Deque, Dict, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple, Union

from ..errors import UsageError
from .backend import TEACHERS, Person
from .frames import STAMPS, frame_head, frames_message
from .guard import TOO_MANY, TOO_SLOW, Allowance, Farewell
from .trail import Trail

BATCH = 0.025           # s
ACKNOWLEDGE = 0.5       # s
MOST_UNANSWERED = 40    # batches of a viewer: twice as many as there are in ACKNOWLEDGE s
MOST_VIEWERS = 60
MOST_OWN = 4            # viewers of one student who has a robot, also beyond MOST_VIEWERS
MOST_MESSAGES = 100     # a second and viewer; so many at once
MOST_SAID = 100         # sentences that wait for one viewer
SAME_SENTENCE = 1.0     # s in which a viewer gets the same sentence only once
MOST_NAMES = 500        # of visitors, also of those who left
OF_ROBOTS = ("status", "helm", "trail", "program", "navigation", "plan", "cloud", "places")
"""Kinds of which each robot has its own text."""

Key = Tuple[str, Optional[int]]
Message = Union[str, bytes]


class SharedText(NamedTuple):
    """A text as all viewers get it, and as the one visitor gets it who has the seat."""

    text: str
    for_seat: str
    seat: str


class NewestFrame(NamedTuple):
    """The newest frame of a robot, and its number among all frames that came."""

    number: int
    frame: bytes
    stamp: int


class Viewer:
    """One connection of a page: who it is, what it has got, and what waits for it."""

    def __init__(self, person: Person, now: float) -> None:
        self.person = person
        self.seen = 0
        """Number of the newest frame that it was given."""
        self.unanswered: Deque[Tuple[int, float]] = deque()
        """Batches that were not acknowledged: the stamp of their last frame, and when they were given."""
        self.hello = ""
        """The first text, until it is given."""
        self.texts: Dict[Key, None] = {}
        """Kinds of texts of which the newest has to be given, in this order."""
        self.wholes = 0
        """How many messages of a recording it was given."""
        self.said: Deque[str] = deque()
        self.told: "OrderedDict[Tuple[Optional[int], str], float]" = OrderedDict()
        self.messages = Allowance(MOST_MESSAGES, now)

    def wants_frames(self, now: float) -> bool:
        """Return whether it acknowledged what it got, or still has time to."""
        return not self.unanswered or now - self.unanswered[0][1] <= ACKNOWLEDGE


class Fleet:
    """The newest picture of all robots, and the viewers who look at it. One thread may use it.

    Args:
        title: what the page shows as its title.
        kind: "live" or "recording".
    """

    def __init__(self, title: str, kind: str = "live") -> None:
        self.viewers: Dict[int, Viewer] = {}
        self._hello = {"title": title, "kind": kind}
        self._wholes: List[bytes] = []
        self._frames: Dict[int, NewestFrame] = {}
        self._texts: Dict[Key, Dict[str, SharedText]] = {}      # of each audience
        self._trails: Dict[int, Trail] = {}
        self._robots: Set[int] = set()
        self._count = 0             # of frames
        self._given = 0             # the count at the last batch
        self._batch_at = -math.inf  # time of the last batch
        self._fresh = False         # there are texts that a viewer has not got
        self._behind: Set[int] = set()      # viewers who acknowledged late, and may have frames again
        self._names: "OrderedDict[str, str]" = OrderedDict()
        self._farewells: Dict[int, Farewell] = {}

    # What is shown: the methods of a Feed

    def frame(self, frame: bytes) -> None:
        """Take the newest frame of a robot. Raises UsageError if it is not one whole frame."""
        head = frame_head(frame)
        self._count += 1
        self._frames[head.robot] = NewestFrame(self._count, frame, head.stamp)
        self._trails.setdefault(head.robot, Trail()).go(head.x, head.y)

    def whole(self, message: bytes) -> None:
        """Take a binary message of a recording, which each viewer gets, also those that arrive later."""
        self._wholes.append(message)
        self._fresh = True

    def text(self, kind: str, value: Any, robot: Optional[int] = None, seat: str = "", to: str = "") -> None:
        """Take the newest text of a kind, and give it to the viewers for whom it is. See Feed.text().

        "robots" is the list of all robots: what is kept of others is forgotten. "trail" is the way of a robot until
        now.
        """
        if kind == "trail" and robot is not None:
            self._trails[robot] = Trail(value)
        elif value is None and to:
            self._texts.get((kind, robot), {}).pop(to, None)
        else:
            plain = _text(kind, value)
            for_seat = _text(kind, dict(value, you=True)) if seat else plain
            self._texts.setdefault((kind, robot), {})[to] = SharedText(plain, for_seat, seat)
        self._tell((kind, robot), to)
        if kind == "robots":
            self._keep({entry["robot"] for entry in value})

    def said(self, level: str, text: str, robot: Optional[int] = None,
             viewers: Optional[Sequence[int]] = None, now: float = math.inf) -> None:
        """Tell some viewers, or all (None), a sentence. See Feed.said().

        A viewer gets the same sentence at most once in SAME_SENTENCE s of ``now``, if this is given. A viewer for whom
        MOST_SAID sentences wait gets a Farewell.
        """
        message = _text("said", {"robot": robot, "level": level, "text": text})
        for number in list(self.viewers) if viewers is None else viewers:
            viewer = self.viewers.get(number)
            if viewer is None or now - viewer.told.get((robot, text), -math.inf) < SAME_SENTENCE:
                continue
            if now < math.inf:
                viewer.told.pop((robot, text), None)
                viewer.told[robot, text] = now
                while len(viewer.told) > MOST_SAID:
                    viewer.told.popitem(last=False)
            if len(viewer.said) >= MOST_SAID:
                self._farewells[number] = Farewell(TOO_SLOW, "this page reads too slowly: too much waits for it")
            else:
                viewer.said.append(message)
                self._fresh = True

    # Viewers

    def arrive(self, number: int, person: Person, now: float) -> Optional[Farewell]:
        """Take a new viewer. It gets the whole picture with the next round. Returns a Farewell if there are too many.
        """
        if self._is_full_for(person):
            return Farewell(TOO_MANY, "%d pages are open already, and more are not served: close one" % MOST_VIEWERS)
        person = person._replace(name=self._names.get(person.visitor, ""))
        viewer = self.viewers[number] = Viewer(person, now)
        viewer.hello = _text("hello", dict(self._hello, teacher=person.teacher, you=person.name))
        first = [key for key in self._texts if key[0] == "robots"]
        trails: List[Key] = [("trail", robot) for robot in sorted(self._robots)]
        viewer.texts = dict.fromkeys(first + [key for key in self._texts if key not in first] + trails)
        self._fresh = True
        self._behind.add(number)
        return None

    def _is_full_for(self, person: Person) -> bool:
        """Return whether there are too many viewers for a person. Teachers, and those for whom there is a text of their
        own (students with a robot), come in also when others have opened all pages that there may be.
        """
        if person.teacher:
            return len([each for each in self.viewers.values() if each.person.teacher]) >= MOST_VIEWERS
        own = len([each for each in self.viewers.values() if each.person.visitor == person.visitor])
        is_expected = any(person.visitor in texts for texts in self._texts.values())
        return own >= MOST_OWN if is_expected else len(self.viewers) >= MOST_VIEWERS

    def leave(self, number: int) -> None:
        """Forget a viewer. An unknown number is no error."""
        self.viewers.pop(number, None)
        self._farewells.pop(number, None)
        self._behind.discard(number)

    def hears(self, number: int, now: float) -> Optional[Farewell]:
        """Count a message from a viewer. Returns a Farewell if there are too many."""
        if self.viewers[number].messages.spends(1, now):
            return None
        return Farewell(TOO_MANY, "this page sent more than %d messages in a second" % MOST_MESSAGES)

    def drawn(self, number: int, stamp: int, now: float) -> None:
        """Take the acknowledgement of a viewer: the newest frame on its screen has this stamp."""
        viewer = self.viewers[number]
        waited = not viewer.wants_frames(now)
        viewer.person = viewer.person._replace(drawn=stamp)
        # Stamps of several robots do not come quite in order: who has drawn a batch has drawn all before it, too.
        while any((stamp - each) % STAMPS < STAMPS // 2 for each, _ in viewer.unanswered):
            viewer.unanswered.popleft()
        if waited and viewer.wants_frames(now):
            self._behind.add(number)

    def name(self, number: int, name: str) -> None:
        """Take the name of a viewer. It is remembered for the next time that this visitor arrives."""
        viewer = self.viewers[number]
        viewer.person = viewer.person._replace(name=name)
        self._names.pop(viewer.person.visitor, None)
        self._names[viewer.person.visitor] = name
        while len(self._names) > MOST_NAMES:
            self._names.popitem(last=False)

    # What goes out

    def wait(self, now: float) -> float:
        """Return in how many seconds round() has something to give; 0 or less: now; infinity: not before more comes.
        """
        if self._fresh or self._behind or self._farewells:
            return 0.0
        return self._batch_at + BATCH - now if self._count > self._given and self.viewers else math.inf

    def round(self, now: float, can_take: Callable[[int], bool]) -> Iterator[Tuple[int, List[Message]]]:
        """Return for each viewer what to send to it now, in order. Viewers for whom there is nothing are left out.

        Args:
            now: the present time (monotonic, s).
            can_take: says whether the socket of a viewer takes more. If not, the newest waits for a later round: call
                round() again soon, also when nothing new comes.
        """
        is_batch = self._count > self._given and now - self._batch_at >= BATCH
        if is_batch:
            self._batch_at, self._given = now, self._count
        behind, self._behind, self._fresh = self._behind, set(), False
        batches: Dict[int, Tuple[bytes, int]] = {}
        for number, viewer in self.viewers.items():
            if not (is_batch or number in behind or viewer.hello or viewer.texts or viewer.said
                    or viewer.wholes < len(self._wholes)):
                continue
            if not can_take(number):
                continue
            messages = self._texts_for(viewer) + self._wholes[viewer.wholes:]
            viewer.wholes = len(self._wholes)
            # A viewer that could take nothing in the last round is behind the others.
            if (is_batch or number in behind or viewer.seen < self._given) and viewer.wants_frames(now):
                messages += self._frames_for(viewer, batches, now)
            if messages:
                yield number, messages

    def farewells(self) -> Dict[int, Farewell]:
        """Return the viewers that are to be sent away, and why. They stay until leave()."""
        farewells, self._farewells = self._farewells, {}
        return farewells

    def _texts_for(self, viewer: Viewer) -> List[Message]:
        texts: List[Message] = [viewer.hello] if viewer.hello else []
        for kind, robot in viewer.texts:
            if kind == "trail" and robot is not None:
                trail = self._trails.get(robot, Trail())
                texts.append(_text("trail", {"robot": robot, "points": trail.points}))
            else:
                shared = self._text_for(viewer.person, (kind, robot))
                if shared is not None:
                    texts.append(shared.for_seat if shared.seat == viewer.person.visitor else shared.text)
        texts += viewer.said
        viewer.hello = ""
        viewer.texts.clear()
        viewer.said.clear()
        return texts

    def _frames_for(self, viewer: Viewer, batches: Dict[int, Tuple[bytes, int]], now: float) -> List[Message]:
        """Return the frames that this viewer lacks, as one message. ``batches`` has messages for other viewers."""
        if viewer.seen not in batches:
            newer = sorted(each for each in self._frames.values() if each.number > viewer.seen)
            newest = newer[-1].stamp if newer else 0        # which the page acknowledges
            batches[viewer.seen] = (frames_message(each.frame for each in newer) if newer else b"", newest)
        message, stamp = batches[viewer.seen]
        viewer.seen = self._count
        if not message:
            return []
        if stamp == viewer.person.drawn:
            return [message]        # a page does not acknowledge the same stamp twice
        if len(viewer.unanswered) < MOST_UNANSWERED:
            viewer.unanswered.append((stamp, now))
        else:
            viewer.unanswered[-1] = (stamp, viewer.unanswered[-1][1])
        return [message]

    def _text_for(self, person: Person, key: Key) -> Optional[SharedText]:
        """Return the text of a kind for a person: of several the one that is for the fewest. None if there is none."""
        texts = self._texts.get(key, {})
        for audience in (person.visitor, TEACHERS if person.teacher else "", ""):
            if audience in texts:
                return texts[audience]
        return None

    def _tell(self, key: Key, to: str = "") -> None:
        for viewer in self.viewers.values():
            if to in ("", viewer.person.visitor) or to == TEACHERS and viewer.person.teacher:
                viewer.texts[key] = None
                self._fresh = True

    def _keep(self, robots: Set[int]) -> None:
        """Forget everything about other robots, and tell the way of those that are new."""
        for robot in set(self._frames) | set(self._trails):
            if robot not in robots:
                self._frames.pop(robot, None)
                self._trails.pop(robot, None)
        for key in [key for key in self._texts if key[0] in OF_ROBOTS and key[1] not in robots]:
            del self._texts[key]
        for robot in sorted(robots - self._robots):
            self._tell(("trail", robot))
        self._robots = robots


def _text(kind: str, value: Any) -> str:
    try:
        return json.dumps({kind: value}, separators=(",", ":"), allow_nan=False)
    except ValueError as error:
        raise UsageError("the text %r has a number that JSON does not know: %s" % (kind, error)) from error

"""What is said to a camera, and in which order: how it is started, how it is used, and how it is switched off.

A conversation is a generator. It yields one `Step` after the other: a command, or a pause. It gets back the `Reply` to
its command. `session` carries the steps out. (Camera sheet 5, 6.)
"""

import math
from itertools import cycle
from typing import Any, Callable, Collection, Generator, NamedTuple, Tuple, Union

from ..errors import LinkError
from ..vcc4 import AnswerKind, CameraStatus
from .settings import Cabling, CameraSettings
from .wishes import CameraMove, KnownCamera, Wishes

SETTLE = 0.3            # s that a camera which never answers gets after each command (sheet 1)
POWER_SETTLES = 4.5     # s after power on
INIT_SETTLES = 5.0      # s after the initialisation
FIRST_BACK_OFF, LONGEST_BACK_OFF = 0.1, 1.0     # s between two tries while it is busy
HELD_POLL = 0.2         # s between two looks whether it may turn again
PATIENCE = 10.0         # s for which it may be busy or starting
WATCHING = 0.25         # s between two questions while it moves. At the slowest speed it moves two counts meanwhile
POLLING = 2.0           # s between two questions while it rests

SILENCE = -1
"""`Reply.kind` when no answer came in time, though this camera answers."""
UNHEARD = -2
"""`Reply.kind` when the camera never answers: what it did is not known."""
OVERTAKEN = -3
"""`Reply.kind` when no answer came in time, and a stop waits: it goes first, and what the camera did is not known."""


class Say(NamedTuple):
    """Send a command, and wait for the answer.

    Attributes:
        name, values: the command.
        settles: how long to wait instead (s) if the camera never answers.
    """

    name: str
    values: Tuple[int, ...] = ()
    settles: float = SETTLE


class Hold(NamedTuple):
    """Wait. If `is_idle`, a wish ends it."""

    seconds: float
    is_idle: bool = False


class Reply(NamedTuple):
    """What came back.

    Attributes:
        kind: an `AnswerKind` or another first digit of the error byte, SILENCE, UNHEARD, or OVERTAKEN.
        values: the values that were asked for.
        time: when it came (s).
    """

    kind: int
    values: Tuple[Any, ...] = ()
    time: float = 0.0

    @property
    def is_well(self) -> bool:
        """Whether the camera accepted the command, as far as anybody can know."""
        return self.kind in (AnswerKind.ACCEPTED, UNHEARD, OVERTAKEN)


STOPS = {"ASK_POSITION": Say("STOP"), "ASK_ZOOM": Say("ZOOM_RUN", (0,))}
"""What stops pan and tilt, and the zoom: each by the question that asks how far it is."""
Step = Union[Say, Hold]
Conversation = Generator[Step, Any, None]

REASONS = {
    AnswerKind.BUSY: "it is busy",
    AnswerKind.UNKNOWN_COMMAND: "it does not know this command",
    AnswerKind.WRONG_VALUE: "out of its range",
    AnswerKind.WRONG_MODE: "it is off, has lost its power, or a person has its menu open",
    SILENCE: "it does not answer: its power, its cable, or the port",
}


NOT_NEEDED = (AnswerKind.WRONG_VALUE, AnswerKind.UNKNOWN_COMMAND)
"""How a camera may refuse what it can do without: a VC-C50i that hangs has another range of tilt (sheet 4)."""


class CameraError(LinkError):
    """The camera does not do what it must, so it is started anew after a while. The error message says why."""


def why(say: Say, kind: int) -> str:
    """Return why a command was not obeyed, for people."""
    command = " ".join([say.name, *map(str, say.values)])
    return "%s: %s" % (command, REASONS.get(kind, "error %X, which nobody has explained" % kind if kind >= 0 else ""))


def starting(settings: CameraSettings, camera: KnownCamera, held: Callable[[], bool]) -> Conversation:
    """Take control, give power, initialise, and set speeds and range: host, power, host, init, speeds, range.

    What a camera says is done already is left out: one that is on and initialised keeps looking where it looks. One
    that refuses the speeds or the range has its own: where it is within them it turns all the same.

    While it is ``held``, nothing turns it: it is stopped, and its initialisation waits.

    Raises:
        CameraError: the camera does not become ready.
    """
    camera.has_power = camera.position = camera.zoom = None
    camera.watched.clear()
    yield from _insist(Say("CONTROL", (0,)), camera)
    status = yield Say("ASK_LONG_STATUS") if camera.cabling is Cabling.TWO_WAY else Hold(0.0)
    knows = status.kind == AnswerKind.ACCEPTED
    if not knows or status.values[0] & CameraStatus.OFF:
        yield from _insist(Say("POWER", (1,), POWER_SETTLES), camera)
        yield from _insist(Say("CONTROL", (0,)), camera)
        knows = False
    camera.has_power = None if camera.cabling is Cabling.ONE_WAY else True
    if held():
        for stop in STOPS.values():
            yield stop
    if not knows or status.values[0] & CameraStatus.NEVER_INITIALISED:
        while held():
            yield Hold(HELD_POLL)
        yield from _insist(Say("INITIALISE", (0,), INIT_SETTLES), camera)
        camera.position = (0, 0)
        if camera.cabling is Cabling.TWO_WAY:
            yield from _insist(Say("STOP"), camera)     # it refuses this until it is initialised, and never else
    model = settings.camera_model
    for say in (Say("PAN_SPEED", (settings.pan_speed,)), Say("TILT_SPEED", (settings.tilt_speed,)),
                Say("TILT_RANGE", model.tilt)):
        yield from _insist(say, camera, NOT_NEEDED)
    if camera.cabling is Cabling.TWO_WAY:
        yield from _ask("ASK_POSITION", camera)
        yield from _ask("ASK_ZOOM", camera)
        camera.watched.update(ASK_POSITION=None)
    else:
        yield Say("ZOOM_TO", (0,))
        camera.zoom = 0


def serving(camera: KnownCamera, wishes: Wishes) -> Conversation:
    """Do what is wished, and ask a camera that answers where it looks. Return when it is to be switched off.

    Raises:
        CameraError: the camera does not answer, or is not ready any more.
    """
    questions = cycle(("ASK_POSITION", "ASK_ZOOM"))
    while not wishes.off:
        if wishes.stop:
            yield from _stop(camera, wishes)
        elif wishes.moves:
            yield from _move("ASK_POSITION" if "ASK_POSITION" in wishes.moves else "ASK_ZOOM", camera, wishes)
        elif camera.cabling is Cabling.ONE_WAY:
            yield Hold(math.inf, True)
        elif camera.watched:
            for name in list(camera.watched):
                yield from _watch(name, camera)
            yield Hold(WATCHING, True)
        else:
            yield Hold(POLLING, True)
            if wishes == Wishes():
                yield from _ask(next(questions), camera)


def switching_off(camera: KnownCamera, wishes: Wishes, held: Callable[[], bool]) -> Conversation:
    """Send it home, zoom out, and switch it off. It need not arrive before. One that is ``held`` is stopped instead.

    Raises:
        CameraError: the camera does not obey.
    """
    wishes.stop = False
    if not held():
        wishes.moves.update(ASK_POSITION=CameraMove("GO_TO", (0, 0)), ASK_ZOOM=CameraMove("ZOOM_TO", (0,)))
    for question, stop in STOPS.items():
        if held():
            yield stop
        else:
            yield from _move(question, camera, wishes)
    yield from _insist(Say("POWER", (0,)), camera)
    camera.has_power = None if camera.cabling is Cabling.ONE_WAY else False


def _stop(camera: KnownCamera, wishes: Wishes) -> Conversation:
    wishes.stop = False
    for stop in STOPS.values():
        yield from _insist(stop, camera)
    camera.watched.update(dict.fromkeys(STOPS))


def _move(question: str, camera: KnownCamera, wishes: Wishes) -> Conversation:
    """Turn to where it is wished, or zoom. While the camera moves it refuses another target: so it is stopped before.

    Whether a camera that never answers moves is not known: it is always stopped before.
    """
    back_off, stop = _BackOff(), STOPS[question]
    while question in wishes.moves and not wishes.stop and not wishes.off:
        if camera.cabling is Cabling.ONE_WAY:
            yield stop
        move = wishes.moves.get(question)
        if move is None:        # a stop came meanwhile
            return
        say = Say(*move)
        reply = yield say
        if reply.kind == AnswerKind.BUSY:
            yield from back_off.pause(say, camera, stop)
            continue
        if _is_done(say, reply, camera):
            camera.watched[question] = None
        if reply.kind == UNHEARD and question == "ASK_POSITION":
            camera.position = (say.values[0], say.values[1]) if say.values else (0, 0)
        elif reply.kind == UNHEARD:
            camera.zoom = say.values[0]
        if wishes.moves.get(question) is move:      # else there is a newer one, perhaps the same after a stop
            del wishes.moves[question]


def _is_done(say: Say, reply: Reply, camera: KnownCamera) -> bool:
    """Return whether a command was obeyed; note why not.

    Raises:
        CameraError: the camera does not answer, or is not ready.
    """
    if not reply.is_well:
        camera.last_error = why(say, reply.kind)
        if reply.kind in (SILENCE, AnswerKind.WRONG_MODE):
            raise CameraError(camera.last_error)
    return reply.is_well


def _insist(say: Say, camera: KnownCamera, bearable: Collection[int] = ()) -> Generator[Step, Any, Reply]:
    """Say it until the camera accepts it, or refuses it in a way that is bearable: that is noted. Return the reply.

    Raises:
        CameraError: it does not within `PATIENCE`.
    """
    back_off = _BackOff()
    while True:
        reply: Reply = yield say
        if reply.is_well:
            return reply
        if reply.kind not in (AnswerKind.BUSY, AnswerKind.WRONG_MODE):
            camera.last_error = why(say, reply.kind)
            if reply.kind in bearable:
                return reply
            raise CameraError(camera.last_error)
        yield from back_off.pause(say, camera, kind=reply.kind)


class _BackOff:
    """Pauses between tries of a command, longer and longer."""

    def __init__(self) -> None:
        self._waited, self._seconds = 0.0, FIRST_BACK_OFF

    def pause(self, say: Say, camera: KnownCamera, *first: Say, kind: int = AnswerKind.BUSY) -> Conversation:
        """Say something first, then wait. Raises CameraError when that was for `PATIENCE` in vain."""
        if self._waited >= PATIENCE:
            camera.last_error = "%s, for %.0f s" % (why(say, kind), PATIENCE)
            raise CameraError(camera.last_error)
        for each in first:
            yield each
        yield Hold(self._seconds)
        self._waited += self._seconds
        self._seconds = min(2.0 * self._seconds, LONGEST_BACK_OFF)


def _ask(name: str, camera: KnownCamera) -> Generator[Step, Any, Tuple[int, ...]]:
    """Ask where it looks, or its zoom; note and return the answer.

    Raises:
        CameraError: it does not say.
    """
    say = Say(name)
    reply = yield from _insist(say, camera) if camera.position is None or camera.zoom is None else _once(say, camera)
    values: Tuple[int, ...] = reply.values
    if name == "ASK_POSITION" and values:
        camera.position, camera.position_at = (values[0], values[1]), reply.time
    elif values:
        camera.zoom = values[0]
    return values


def _once(say: Say, camera: KnownCamera) -> Generator[Step, Any, Reply]:
    reply: Reply = yield say
    _is_done(say, reply, camera)
    return reply


def _watch(name: str, camera: KnownCamera) -> Conversation:
    """Ask what may still move. Two equal answers say that it rests."""
    before = camera.watched[name]
    now = yield from _ask(name, camera)
    if now and now == before:
        del camera.watched[name]
    else:
        camera.watched[name] = now

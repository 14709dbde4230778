"""The computer's side of a camera's line: bytes and time go in, bytes and reports come out. No I/O, no clock.

What is said to a camera, and in which order, stands in `conversation`. This file carries it out: it sends a command,
sends it again when no answer comes, finds out whether this camera answers at all, and starts it anew when it fails.
"""

import enum
import math
from typing import Callable, List, NamedTuple, Optional, Tuple

from ..errors import RefusedError
from ..vcc4 import (ANSWER_BEGIN, CAMERA_COMMANDS, SHORTEST_ANSWER, ZOOM_MOST, AnswerKind, CameraDecoder,
                    answer_values, decode_answer, encode_camera_command)
from ..vcc4.framing import ERROR_DIGITS
from .conversation import (OVERTAKEN, SILENCE, STOPS, UNHEARD, CameraError, Conversation, Reply, Say, Step, serving,
                           starting, switching_off)
from .settings import Cabling, CameraSettings
from .wishes import CameraMove, KnownCamera, Wishes

ANSWERS_WITHIN = 1.0
"""Time (s) for an answer: the camera promises it in 0.3 s, and the robot passes it on with one of its next packets."""
TRIES = 3
"""How often a command is sent that is not answered."""
FIRST_TRIES = 4
"""How often the first command is sent. If the camera answers none of these, it never answers (sheet 1)."""
AGAIN = 5.0
"""Time (s) from a failure to the next start."""


HELD = "; nothing may turn it now, so it is not initialised yet"
"""What is said of a camera that starts while it is held."""


class CameraPhase(enum.Enum):
    """What the session does."""

    NO_LINE = "no line"
    STARTING = "starting"
    READY = "ready"
    SWITCHING_OFF = "switching off"
    OFF = "off"
    FAILED = "failed"
    """It starts anew soon."""
    ENDED = "ended"


class Exchange(NamedTuple):
    """A command to send now.

    Attributes:
        data: its bytes.
        is_answered: whether the camera answers it. The first bytes of the answer are `SHORTEST_ANSWER`.
    """

    data: bytes
    is_answered: bool


UNHEARD_STOPS = [Exchange(encode_camera_command(say.name, *say.values), False) for say in STOPS.values()]
"""What stops a camera that need not answer."""


class CameraReport(NamedTuple):
    """What is known of the camera. Angles are counts of 0.1125 degrees as the world sees them: to the right, upwards.

    Attributes:
        phase: what the session does.
        cabling: whether the camera answers; AUTO while that is not known.
        pan, tilt, zoom: where it looks: as it said, or as it was told if it never answers. None: not known.
        position_at: the time (s) of pan and tilt.
        is_moving: it may move. Of a camera that never answers, that is not known, and false.
        has_power: None: not known.
        problem: why it is not ready, for people; empty if it is.
        last_error: what went wrong last; empty: nothing.
        answered_at: time (s) of its last answer. None: there was none.
        answers: how many there were.
        repeated: how many commands were sent again.
        stray_bytes: how many bytes made no answer.
    """

    phase: CameraPhase = CameraPhase.NO_LINE
    cabling: Cabling = Cabling.AUTO
    pan: Optional[int] = None
    tilt: Optional[int] = None
    zoom: Optional[int] = None
    position_at: float = 0.0
    is_moving: bool = False
    has_power: Optional[bool] = None
    problem: str = ""
    last_error: str = ""
    answered_at: Optional[float] = None
    answers: int = 0
    repeated: int = 0
    stray_bytes: int = 0

    @property
    def is_measured(self) -> bool:
        """Whether pan, tilt and zoom are what the camera says, not what it was told."""
        return self.cabling is Cabling.TWO_WAY and self.pan is not None


class CameraSession:
    """One camera on one line. ``now`` is monotonic time in s everywhere.

    Call `receive` with what was read, `tick` when `due` is over, and then send what `take_output` returns.

    Args:
        settings: what is asked of the camera.
        held: function that returns whether it must stand, whoever wishes what: then it is not initialised, and does not
            go home before it is switched off, as both turn it.
    """

    def __init__(self, settings: CameraSettings, held: Callable[[], bool] = lambda: False) -> None:
        self.settings, self._held = settings, held
        self.due = math.inf
        """When `tick` must be called at the latest (s)."""
        self.phase = CameraPhase.NO_LINE
        self._problem = "there is no line to it yet"
        self._camera = KnownCamera(settings.cabling)
        self._wishes = Wishes()
        self._commanded: Optional[Tuple[int, int]] = None
        self._zoom_commanded: Optional[int] = None
        self._conversation: Optional[Conversation] = None
        self._step: Optional[Step] = None
        self._tries = 0
        self._is_ending = False
        self._decoder = CameraDecoder(ANSWER_BEGIN)
        self._output: List[Exchange] = []
        self._answered_at: Optional[float] = None
        self._answers = self._repeated = 0

    # -- what a program wants

    @property
    def target(self) -> Tuple[int, int, int]:
        """Pan, tilt and zoom to which relative commands are added: as last commanded, else as they are; counts."""
        report = self.report
        pan, tilt = self._commanded or (report.pan or 0, report.tilt or 0)
        return pan, tilt, (report.zoom or 0) if self._zoom_commanded is None else self._zoom_commanded

    @property
    def ranges(self) -> Tuple[Tuple[int, int], Tuple[int, int]]:
        """Least and most of pan and tilt (counts, as the world sees them)."""
        model = self.settings.camera_model
        if self.settings.inverted:
            return (-model.pan[1], -model.pan[0]), (-model.tilt[1], -model.tilt[0])
        return model.pan, model.tilt

    def look(self, pan: int, tilt: int, now: float) -> None:
        """Turn to pan, tilt (counts, to the right and upwards); beyond the limits to them. The newest counts.

        Raises RefusedError, with the reason, when the camera is not ready and will not be at once.
        """
        self._check_ready("look")
        limits = self.ranges
        wanted = (max(limits[0][0], min(limits[0][1], pan)), max(limits[1][0], min(limits[1][1], tilt)))
        if wanted == self._commanded and (
                self._is_under_way("ASK_POSITION") or self._camera.position == self._turned(wanted)):
            return      # a program that repeats itself must not stop the camera each time
        self._commanded = wanted
        self._wishes.moves["ASK_POSITION"] = CameraMove("GO_TO", self._turned(wanted))
        self._wish(now)

    def zoom_to(self, zoom: int, now: float) -> None:
        """Go to a zoom step, 0 wide to 1960 tele; beyond to the ends. Raises RefusedError as `look` does."""
        self._check_ready("zoom")
        wanted = max(0, min(ZOOM_MOST, zoom))
        if wanted == self._zoom_commanded and (self._is_under_way("ASK_ZOOM") or self._camera.zoom == wanted):
            return
        self._zoom_commanded = wanted
        self._wishes.moves["ASK_ZOOM"] = CameraMove("ZOOM_TO", (wanted,))
        self._wish(now)

    def home(self, now: float) -> None:
        """Go to pan 0, tilt 0 at the camera's own speed. Raises RefusedError as `look` does."""
        self._check_ready("home")
        self._commanded = (0, 0)
        self._wishes.moves["ASK_POSITION"] = CameraMove("HOME")
        self._wish(now)

    def stop(self, now: float) -> None:
        """Stop pan, tilt and zoom, and forget where to go.

        A camera that has failed may turn all the same: it is told to stop at once, whether it answers or not. Raises
        RefusedError, with the reason, when the camera is off or being switched off, or has no line.
        """
        if self.phase is not CameraPhase.FAILED:
            self._check_ready("stop")
        if self.phase is not CameraPhase.READY:
            self._output += UNHEARD_STOPS
        if self.phase is CameraPhase.FAILED:
            return
        self._commanded = self._zoom_commanded = None
        self._wishes.stop = True
        self._wishes.moves.clear()
        self._wish(now)

    def power(self, on: bool, now: float) -> None:
        """Switch it on, and start it anew; or send it home and switch it off. Raises RefusedError without a line."""
        if self.phase in (CameraPhase.NO_LINE, CameraPhase.ENDED):
            raise RefusedError("camera, power refused: %s" % self._problem)
        if on:
            self._camera.cabling = self.settings.cabling
            self._start(now)
        elif self.phase is CameraPhase.READY:
            self._wishes.off = True
            self._wish(now)
        elif self.phase not in (CameraPhase.OFF, CameraPhase.SWITCHING_OFF):
            self._switch_off(now)

    # -- the line

    @property
    def ended(self) -> bool:
        """Whether the camera needs the line no more, after `end`."""
        return self.phase is CameraPhase.ENDED

    @property
    def answer_missing(self) -> int:
        """How many bytes of the awaited answer are still to come, as far as its first bytes tell; 0: none is awaited.
        """
        if not isinstance(self._step, Say) or self._camera.cabling is Cabling.ONE_WAY:
            return 0
        held, length = self._decoder.held, SHORTEST_ANSWER
        if len(held) >= ERROR_DIGITS.stop and held[ERROR_DIGITS].startswith(b"0"):     # the second digit is no refusal
            length += CAMERA_COMMANDS[self._step.name].answer_width
        return max(1, length - len(held))

    def line_up(self, now: float) -> None:
        """Begin: there is a line, for the first time or once more."""
        if not self._is_ending:
            self._camera.cabling = self.settings.cabling
            self._start(now)

    def line_down(self, reason: str) -> None:
        """Forget what waits for an answer: there is no line, for a reason (for people)."""
        self._leave(CameraPhase.ENDED if self._is_ending else CameraPhase.NO_LINE, reason)

    def end(self, now: float) -> None:
        """Switch the camera off, if it is to be so at the end; else stop it if it moves. Go on until `ended`."""
        self._is_ending = True
        if self.settings.power_off_at_end and self.phase not in (
                CameraPhase.NO_LINE, CameraPhase.OFF, CameraPhase.ENDED):
            self._switch_off(now)
        else:
            moves = self.report.is_moving
            self._leave(CameraPhase.ENDED, "the driver has ended")
            self._output += UNHEARD_STOPS if moves else ()

    @property
    def has_output(self) -> bool:
        """Whether `take_output` has something."""
        return bool(self._output)

    def take_output(self) -> List[Exchange]:
        """Return what is to be sent now, in this order."""
        output, self._output = self._output, []
        return output

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes of the camera, in pieces of any size."""
        for frame in self._decoder.feed(data):
            answer = decode_answer(frame)
            if answer is None:
                continue
            self._answered_at = now
            self._answers += 1
            if self.settings.cabling is Cabling.AUTO:
                self._camera.cabling = Cabling.TWO_WAY
            if isinstance(self._step, Say):
                values = answer_values(self._step.name, answer) if answer.kind == AnswerKind.ACCEPTED else ()
                if values is not None:      # else it answers an earlier command
                    self._advance(Reply(answer.kind, values, now), now)

    def tick(self, now: float) -> None:
        """Do what is due."""
        if now < self.due:
            return
        if self._conversation is None:
            self._start(now)
        elif not isinstance(self._step, Say) or self._camera.cabling is Cabling.ONE_WAY:
            self._advance(Reply(UNHEARD, (), now), now)
        elif self._wishes.stop and self.phase is CameraPhase.READY and self._step not in STOPS.values():
            self._advance(Reply(OVERTAKEN, (), now), now)       # it may be what turns the camera: never once more
        elif self._tries < (FIRST_TRIES if self._camera.cabling is Cabling.AUTO else TRIES):
            self._repeated += 1
            self._do(now)
        elif self._camera.cabling is Cabling.AUTO:
            self._camera.cabling = Cabling.ONE_WAY
            self._advance(Reply(UNHEARD, (), now), now)
        else:
            self._advance(Reply(SILENCE, (), now), now)

    @property
    def report(self) -> CameraReport:
        """What is known of the camera now."""
        camera = self._camera
        pan, tilt = (None, None) if camera.position is None else self._turned(camera.position)
        is_wanted = bool(camera.watched or self._wishes.moves)
        waits = HELD if self.phase is CameraPhase.STARTING and self._held() else ""
        return CameraReport(
            self.phase, camera.cabling, pan, tilt, camera.zoom, camera.position_at,
            is_wanted and self.phase is CameraPhase.READY and camera.cabling is Cabling.TWO_WAY, camera.has_power,
            "" if self.phase is CameraPhase.READY else self._problem + waits, camera.last_error,
            self._answered_at, self._answers, self._repeated, self._decoder.counts.discarded_bytes)

    # -- inside

    def _turned(self, angles: Tuple[int, int]) -> Tuple[int, int]:
        """Return pan, tilt of the world for the camera, and the other way round: a camera that hangs negates both."""
        return (-angles[0], -angles[1]) if self.settings.inverted else angles

    def _is_under_way(self, question: str) -> bool:
        return question in self._wishes.moves or question in self._camera.watched

    def _check_ready(self, what: str) -> None:
        if self.phase not in (CameraPhase.READY, CameraPhase.STARTING):
            raise RefusedError("camera, %s refused: %s" % (what, self._problem))

    def _wish(self, now: float) -> None:
        """Begin with a wish at once, if the conversation only waits for one."""
        if self._step is not None and not isinstance(self._step, Say) and self._step.is_idle:
            self._advance(Reply(UNHEARD, (), now), now)

    def _start(self, now: float) -> None:
        self._leave(CameraPhase.STARTING, "it is starting")
        self._begin(starting(self.settings, self._camera, self._held), now)

    def _switch_off(self, now: float) -> None:
        self._leave(CameraPhase.SWITCHING_OFF, "it is being switched off")
        self._begin(switching_off(self._camera, self._wishes, self._held), now)

    def _leave(self, phase: CameraPhase, problem: str) -> None:
        """End the present conversation, and forget all wishes."""
        self.phase, self._problem = phase, problem
        self._conversation = self._step = None
        self._commanded = self._zoom_commanded = None
        self._wishes = Wishes()
        self._camera.watched.clear()
        self._output.clear()
        self._decoder.drop_partial()
        self.due = math.inf

    def _begin(self, conversation: Conversation, now: float) -> None:
        self._conversation = conversation
        self._advance(None, now)

    def _advance(self, reply: Optional[Reply], now: float) -> None:
        """Hand a reply to the conversation, and begin its next step."""
        assert self._conversation is not None
        try:
            self._step = self._conversation.send(reply)
        except CameraError as error:
            self._fail(str(error), now)
        except StopIteration:
            self._over(now)
        else:
            self._tries = 0
            self._do(now)

    def _do(self, now: float) -> None:
        """Do the present step: once more, if it is a command that was not answered."""
        step = self._step
        if isinstance(step, Say):
            self._tries += 1
            is_answered = self._camera.cabling is not Cabling.ONE_WAY
            self._decoder.drop_partial()
            self._output.append(Exchange(encode_camera_command(step.name, *step.values), is_answered))
            self.due = now + (ANSWERS_WITHIN if is_answered else step.settles)
        elif step is not None:
            self.due = now + step.seconds

    def _over(self, now: float) -> None:
        """Go on after a conversation that came to its end."""
        if self.phase is CameraPhase.STARTING:
            self.phase = CameraPhase.READY
            self._begin(serving(self._camera, self._wishes), now)
        elif self.phase is CameraPhase.READY:
            self._switch_off(now)
        elif self._is_ending:
            self._leave(CameraPhase.ENDED, "the driver has ended")
        else:
            self._leave(CameraPhase.OFF, "it is switched off; the service ptz/power switches it on")

    def _fail(self, reason: str, now: float) -> None:
        """Start anew after a while; at the end, do nothing more."""
        if self._is_ending:
            self._leave(CameraPhase.ENDED, reason)
        elif self.phase is CameraPhase.SWITCHING_OFF or self._wishes.off:
            self._leave(CameraPhase.OFF, "it was to be switched off, but %s" % reason)
        else:
            self._leave(CameraPhase.FAILED, reason)
            self.due = now + AGAIN

"""A simulated camera: a Canon VC-C4 or VC-C50i at an auxiliary port of the robot, or on a line of its own.

It answers as the protocol says, after the time that a real one takes, and turns and zooms at its speeds. It looks into
the world, but takes no pictures. No sockets and no real time. (Camera sheet 3 to 6, 10.)
"""

from collections import deque
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, NamedTuple, Optional, Tuple

from ...vcc4 import (CAMERA_MODELS, COMMAND_BEGIN, ZOOM_MOST, AnswerKind, CameraDecoder, CameraOrder, CameraStatus,
                     decode_camera_command, encode_answer, encode_error)
from ...vcc4.commands import CAMERA_COMMANDS
from ..clock import NEVER_US
from .accessories import AuxPort

KINDS_OF_CAMERAS = tuple(CAMERA_MODELS)
CAMERA_CABLINGS = ("two_way", "one_way")
MICRO = 1000000
"""Positions are kept in millionths of a count or of a zoom step, so that steps of microseconds add up exactly."""
ALWAYS = frozenset(CAMERA_COMMANDS[name].number for name in ("CONTROL", "ASK_STATUS", "ASK_LONG_STATUS"))
"""Numbers of the commands that it obeys also in local mode, and while it is switched off."""
TURNS = frozenset(("HOME", "GO_TO", "RUN_RIGHT", "RUN_LEFT", "RUN_UP", "RUN_DOWN", "RUN_BOTH"))
"""Commands that need an initialised camera. Without it they start the initialisation by themselves."""
TARGETS = frozenset(("HOME", "GO_TO"))
"""Commands that it refuses while it turns."""
SIGN = {0: 0, 1: 1, 2: -1}
ZOOM_RUNS = {1: (0, 2), 2: (ZOOM_MOST, 2), 3: (0, 1), 4: (ZOOM_MOST, 1)}
"""Where the zoom goes, and the divisor of its speed, by the value of ZOOM_RUN."""
ELECTRONIC_ZOOMS = (1, 2, 4, 8, 12)
"""How many times a VC-C50i enlarges the picture by computing."""
COARSE = 153
"""Tenths of a fine zoom step in a coarse one."""


@dataclass(frozen=True)
class CameraNumbers:
    """How a camera behaves (camera sheet 10; mostly invented there). Times are in microseconds."""

    power_on_us: int = 4000000
    power_off_us: int = 2000000
    init_us: int = 3000000
    answer_us: int = 20000
    byte_us: int = 1000
    """For each byte of the command and of the answer: the line has 9600 baud."""
    zoom_speed: int = 980
    """Zoom steps a second."""
    home_speeds: Tuple[int, int] = (800, 622)
    """Counts a second of pan and tilt on the way home."""
    starts_ready: bool = False
    """It begins in host control and initialised, for clients that forgive nothing."""


STRICT = CameraNumbers()


class CameraFaults(NamedTuple):
    """What is wrong with a camera. A test, or a fault of the robot, changes it.

    Attributes:
        silent: no answer leaves it.
        busy: it is busy for ever.
        cut_us: time (microseconds) between the two halves of each answer.
        noise: bytes before each answer.
        menu_open: a person has its menu open.
        no_power: it has no power: see `SimulatedCamera.supply`.
    """

    silent: bool = False
    busy: bool = False
    cut_us: int = 0
    noise: bytes = b""
    menu_open: bool = False
    no_power: bool = False


class CameraAxis:
    """Pan, tilt or zoom: it goes straight to its target at its speed.

    Args:
        low, high: where it may go (counts, or zoom steps).
        speed: its speed (counts a second).
    """

    def __init__(self, low: int, high: int, speed: int) -> None:
        self.low, self.high, self.speed = low, high, speed
        self._at = self._target = 0

    @property
    def position(self) -> int:
        """Where it is: the nearest count."""
        return (self._at + MICRO // 2) // MICRO

    @property
    def is_moving(self) -> bool:
        """Whether it is not at its target."""
        return self._at != self._target

    @property
    def is_at_limit(self) -> bool:
        """Whether it is at an end of where it may go."""
        return self.position in (self.low, self.high)

    def go(self, target: int) -> None:
        """Begin to go to a target, or to the end that is before it."""
        self._target = max(self.low, min(self.high, target)) * MICRO

    def stop(self) -> None:
        """Stop at once."""
        self._target = self._at

    def jump(self, position: int) -> None:
        """Be at a position at once."""
        self._at = self._target = position * MICRO

    def step(self, duration_us: int, speed: Optional[int] = None) -> None:
        """Move for a time (microseconds), at another speed if one is given."""
        way = duration_us * (self.speed if speed is None else speed)
        self._at += max(-way, min(way, self._target - self._at))


class SimulatedCamera:
    """One camera.

    Args:
        kind: a key of `CAMERA_MODELS`.
        answers: whether its answers reach the client: two-way cabling.
        numbers: how it behaves.
        put: function that gets the bytes of its answers.

    Attributes:
        kind, numbers, put: as the arguments.
        answers: as the argument. A test may change it.
        faults: what is wrong with it.
        pan, tilt, zoom: its axes.
        is_on: whether it is on. It is off, and obeys only power-on, after somebody switched it off.
        is_local: whether its remote control has control, not the line.
        is_initialised: whether it knows where its ends are.
        orders: number of commands that it obeyed.
    """

    device_name = "a camera"

    def __init__(self, kind: str, answers: bool = True, numbers: CameraNumbers = STRICT,
                 put: Callable[[bytes], None] = lambda data: None) -> None:
        self.kind, self.answers, self.numbers, self.put = kind, answers, numbers, put
        self._model = CAMERA_MODELS[kind]
        self.faults = CameraFaults()
        self._decoder = CameraDecoder(COMMAND_BEGIN)
        self._now_us = 0
        self.restart()

    def restart(self) -> None:
        """Get power anew: on, in local mode, not initialised."""
        self._decoder.drop_partial()
        self._sent: Deque[Tuple[int, bytes]] = deque()
        self._set_up()
        self.is_on, self.is_local = True, not self.numbers.starts_ready
        self.is_initialised = self.numbers.starts_ready
        self.orders = 0

    def _set_up(self) -> None:
        """Have speeds and ranges as after power-on."""
        model = self._model
        self.pan = CameraAxis(*model.pan_mechanics, model.pan_speed[1])
        self.tilt = CameraAxis(*model.tilt_at_power_on, model.tilt_speed[1])
        self.zoom = CameraAxis(0, ZOOM_MOST, self.numbers.zoom_speed)
        self.is_initialised = self._goes_home = False
        self._power_changes_us = self._ready_us = self._now_us

    # -- what others may look at

    @property
    def is_changing_power(self) -> bool:
        """Whether it is just being switched on or off."""
        return self._now_us < self._power_changes_us

    @property
    def is_initialising(self) -> bool:
        """Whether it is looking for its ends."""
        return self._now_us < self._ready_us

    @property
    def is_turning(self) -> bool:
        """Whether pan or tilt moves."""
        return self.pan.is_moving or self.tilt.is_moving

    @property
    def status(self) -> CameraStatus:
        """The bits of its status."""
        bits = (
            (not self.is_initialised, CameraStatus.NEVER_INITIALISED), (not self.is_on, CameraStatus.OFF),
            (self.zoom.is_moving, CameraStatus.ZOOMING), (self.pan.is_at_limit, CameraStatus.PAN_AT_LIMIT),
            (self.pan.is_moving, CameraStatus.PANNING), (self.tilt.is_at_limit, CameraStatus.TILT_AT_LIMIT),
            (self.tilt.is_moving, CameraStatus.TILTING), (self.is_local, CameraStatus.LOCAL_MODE),
            (self.faults.menu_open, CameraStatus.MENU_OPEN))
        status = CameraStatus(0)
        for is_set, bit in bits:
            status |= bit if is_set else CameraStatus(0)
        return status

    def supply(self, on: bool) -> None:
        """Give it power, or none. Without it, it hears nothing, says nothing and stands; then it starts anew."""
        if on == self.faults.no_power:
            self.restart()
            self.fail(no_power=not on)

    def switch(self, on: bool) -> None:
        """Switch it on or off at once, as a person does with its remote control. It forgets its settings."""
        if on != self.is_on:
            self._set_up()
            self.is_on = on

    def fail(self, **faults: Any) -> None:
        """Change what is wrong with it: `CameraFaults` by name."""
        self.faults = self.faults._replace(**faults)

    # -- its line

    @property
    def next_us(self) -> int:
        """The time (microseconds) at which its next answer is due."""
        return self._sent[0][0] if self._sent else NEVER_US

    def join(self, port: AuxPort, number: int) -> None:
        """Be the device at an auxiliary port of a robot, AUX`number`.

        Raises:
            ParameterError: there is a device already.
        """
        port.join(self, number)
        port.device, self.put = self.device, port.put

    def device(self, data: bytes) -> bytes:
        """Take bytes of the client, as a device of an `AuxPort`. The answers come later: see `step`."""
        for frame in self._decoder.feed(data) if not self.faults.no_power else ():
            order = decode_camera_command(frame)
            if order is not None and order.camera == 0:
                self._send(self._answer(order), len(frame))
        return b""

    def step(self, now_us: int) -> None:
        """Let time pass until `now_us` (microseconds): move, and give out the answers that are due."""
        passed_us, self._now_us = now_us - self._now_us, now_us
        if self.faults.no_power:
            return
        if self.is_on and not self.is_changing_power:
            home = self.numbers.home_speeds if self._goes_home else (None, None)
            self.pan.step(passed_us, home[0])
            self.tilt.step(passed_us, home[1])
            self.zoom.step(passed_us)
            self._goes_home = self._goes_home and self.is_turning
        while self._sent and self._sent[0][0] <= now_us:
            self.put(self._sent.popleft()[1])

    def _send(self, answer: bytes, heard: int) -> None:
        """Send an answer after its time. ``heard``: number of bytes of the command."""
        numbers, faults = self.numbers, self.faults
        if not self.answers or faults.silent:
            return
        due_us = self._now_us + numbers.answer_us + numbers.byte_us * (heard + len(answer))
        if self._sent:
            due_us = max(due_us, self._sent[-1][0])
        half = len(answer) // 2 if faults.cut_us else len(answer)
        self._sent.append((due_us, faults.noise + answer[:half]))
        if faults.cut_us:
            self._sent.append((due_us + faults.cut_us, answer[half:]))

    # -- what it does

    def _answer(self, order: CameraOrder) -> bytes:
        """Obey a command, if it may be obeyed now, and return the answer."""
        error = self._obstacle(order)
        if error is not None:
            return encode_error(error)
        assert order.command is not None
        self.orders += 1
        name = order.command.name
        ACTS.get(name, _nothing)(self, *order.values)
        return encode_answer(name, *(ANSWERS[name](self) if order.command.answer else ()))

    def _obstacle(self, order: CameraOrder) -> Optional[AnswerKind]:
        """Return why a command is not obeyed: it checks the mode first, then the command, then value and busy."""
        name = "" if order.command is None else order.command.name
        if order.number not in ALWAYS and (self.is_local or not self.is_on and name != "POWER"):
            return AnswerKind.WRONG_MODE
        if order.number not in ALWAYS and name != "POWER" and self.is_changing_power or (
                name == "CONTROL" and self.faults.menu_open):
            return AnswerKind.WRONG_MODE
        if name in TURNS and not self.is_initialised:
            if not self.is_initialising:
                self.initialise(0)
            return AnswerKind.WRONG_MODE
        if order.command is None or order.command.needs_lamp and not self._model.has_lamp:
            is_known = any(row.number == order.number and (self._model.has_lamp or not row.needs_lamp)
                           for row in CAMERA_COMMANDS.values())
            return AnswerKind.WRONG_VALUE if is_known else AnswerKind.UNKNOWN_COMMAND
        if not order.is_legal or not self._is_in_range(name, order.values):
            return AnswerKind.WRONG_VALUE
        if self.faults.busy and not order.command.answer or self._is_busy(name):
            return AnswerKind.BUSY
        return None

    def _is_in_range(self, name: str, values: Tuple[int, ...]) -> bool:
        """Return whether values are in the movable range, or make one within the mechanics, or are there at all."""
        if name == "ELECTRONIC_ZOOM":
            return values[0] in ELECTRONIC_ZOOMS
        if name == "GO_TO":
            return self.pan.low <= values[0] <= self.pan.high and self.tilt.low <= values[1] <= self.tilt.high
        mechanics = {"PAN_RANGE": self._model.pan_mechanics, "TILT_RANGE": self._model.tilt_mechanics}.get(name)
        return mechanics is None or mechanics[0] <= values[0] <= values[1] <= mechanics[1]

    def _is_busy(self, name: str) -> bool:
        """Return whether it cannot obey a command just now."""
        if name == "POWER":
            return self.is_changing_power
        if name in TURNS or name in ("STOP", "INITIALISE"):
            return self.is_initialising or name in TARGETS and self.is_turning
        return name in ("ZOOM_TO", "COARSE_ZOOM") and self.zoom.is_moving

    def power(self, on: int) -> None:
        """Obey POWER. It is on or off at once, and takes its time until it obeys more."""
        if bool(on) != self.is_on:
            self.switch(bool(on))
            self._power_changes_us = self._now_us + (self.numbers.power_on_us if on else self.numbers.power_off_us)

    def control(self, local: int) -> None:
        """Obey CONTROL."""
        self.is_local = bool(local)

    def initialise(self, back: int) -> None:
        """Obey INITIALISE: it is at home, or back, after its time."""
        at = (self.pan.position, self.tilt.position) if back else (0, 0)
        self.pan.jump(at[0])
        self.tilt.jump(at[1])
        self.is_initialised = True
        self._ready_us = self._now_us + self.numbers.init_us

    def go_to(self, pan: int, tilt: int) -> None:
        """Obey GO_TO."""
        self.pan.go(pan)
        self.tilt.go(tilt)

    def go_home(self) -> None:
        """Obey HOME: at a fixed speed."""
        self.go_to(0, 0)
        self._goes_home = True

    def stop(self) -> None:
        """Obey STOP."""
        self.pan.stop()
        self.tilt.stop()

    def run(self, pan: int, tilt: int) -> None:
        """Run until a stop or the end of the range: where the signs of pan and tilt say; 0 stops an axis in RUN_BOTH.
        """
        for axis, sign in ((self.pan, pan), (self.tilt, tilt)):
            if sign:
                axis.go(axis.high if sign > 0 else axis.low)

    def run_both(self, pan: int, tilt: int) -> None:
        """Obey RUN_BOTH."""
        self.stop()
        self.run(SIGN[pan], SIGN[tilt])

    def run_zoom(self, how: int) -> None:
        """Obey ZOOM_RUN."""
        self.zoom.stop()
        if how:
            target, divisor = ZOOM_RUNS[how]
            self.zoom.speed = self.numbers.zoom_speed // divisor
            self.zoom.go(target)

    def zoom_to(self, step: int) -> None:
        """Obey ZOOM_TO."""
        self.zoom.speed = self.numbers.zoom_speed
        self.zoom.go(step)

    def zoom_coarsely(self, step: int) -> None:
        """Obey COARSE_ZOOM."""
        self.zoom_to(min(ZOOM_MOST, step * COARSE // 10))


def _nothing(camera: SimulatedCamera, *values: int) -> None:
    """Do nothing that can be seen: focus and lamps."""


def _set_range(axis: CameraAxis, low: int, high: int) -> None:
    axis.low, axis.high = low, high


ACTS: Dict[str, Callable[..., object]] = {
    "POWER": SimulatedCamera.power,
    "CONTROL": SimulatedCamera.control,
    "INITIALISE": SimulatedCamera.initialise,
    "HOME": SimulatedCamera.go_home,
    "GO_TO": SimulatedCamera.go_to,
    "STOP": SimulatedCamera.stop,
    "RUN_RIGHT": lambda camera: camera.run(1, 0),
    "RUN_LEFT": lambda camera: camera.run(-1, 0),
    "RUN_UP": lambda camera: camera.run(0, 1),
    "RUN_DOWN": lambda camera: camera.run(0, -1),
    "RUN_BOTH": SimulatedCamera.run_both,
    "PAN_SPEED": lambda camera, speed: setattr(camera.pan, "speed", speed),
    "TILT_SPEED": lambda camera, speed: setattr(camera.tilt, "speed", speed),
    "PAN_RANGE": lambda camera, low, high: _set_range(camera.pan, low, high),
    "TILT_RANGE": lambda camera, low, high: _set_range(camera.tilt, low, high),
    "ZOOM_TO": SimulatedCamera.zoom_to,
    "ZOOM_RUN": SimulatedCamera.run_zoom,
    "COARSE_ZOOM": SimulatedCamera.zoom_coarsely,
}
"""What a command does, by its name. Those that are not here do nothing that can be seen."""


def _limit(axis: str, end: int) -> Callable[[SimulatedCamera], Tuple[int]]:
    return lambda camera: (getattr(CAMERA_MODELS[camera.kind], axis)[end],)


ANSWERS: Dict[str, Callable[[SimulatedCamera], Tuple[object, ...]]] = {
    "ASK_POSITION": lambda camera: (camera.pan.position, camera.tilt.position),
    "ASK_PAN_SPEED": lambda camera: (camera.pan.speed,),
    "ASK_TILT_SPEED": lambda camera: (camera.tilt.speed,),
    "ASK_PAN_SPEED_LEAST": _limit("pan_speed", 0),
    "ASK_PAN_SPEED_MOST": _limit("pan_speed", 1),
    "ASK_TILT_SPEED_LEAST": _limit("tilt_speed", 0),
    "ASK_TILT_SPEED_MOST": _limit("tilt_speed", 1),
    "ASK_PAN_RANGE": lambda camera: (camera.pan.low, camera.pan.high),
    "ASK_TILT_RANGE": lambda camera: (camera.tilt.low, camera.tilt.high),
    "ASK_PAN_LEAST": _limit("pan_mechanics", 0),
    "ASK_PAN_MOST": _limit("pan_mechanics", 1),
    "ASK_TILT_LEAST": _limit("tilt_mechanics", 0),
    "ASK_TILT_MOST": _limit("tilt_mechanics", 1),
    "ASK_PAN_COUNT": lambda camera: (11250,),
    "ASK_TILT_COUNT": lambda camera: (11250,),
    "ASK_ZOOM": lambda camera: (camera.zoom.position,),
    "ASK_ZOOM_MOST": lambda camera: (ZOOM_MOST,),
    "ASK_ZOOM_SPEED": lambda camera: (7,),
    "ASK_COARSE_ZOOM": lambda camera: (round(camera.zoom.position * 10 / COARSE),),
    "ASK_STATUS": lambda camera: (int(camera.status) & 0xFFF,),
    "ASK_LONG_STATUS": lambda camera: (int(camera.status),),
    "ASK_PRODUCT": lambda camera: (CAMERA_MODELS[camera.kind].product,),
    "ASK_VERSION": lambda camera: ("V1-01",),
}
"""What it answers to a question, by the name of the command."""

"""What is said to a laser, and in which order: how it is found, configured and started, and how it is stopped.

A conversation is a generator. It yields one `Step` after the other: a request, a speed for the port, or a pause. It
gets back the reply to its request, or None when there was none in time. `session` carries the steps out.
"""

import math
from typing import Any, Generator, List, NamedTuple, Optional, Tuple, Type, Union

from ..errors import LinkError
from ..lms2xx import (MEASURING_MODES, METRES, SPEEDS, AskConfiguration, AskErrors, AskStatus, AskType, Availability,
                      Configuration, ConfigurationReply, ConfigurationWritten, DeviceError, ErrorsReply, Mode, ModeSet,
                      NotPossible, PowerOn, ScanReply, SetMode, SetVariant, StatusReply, TypeReply, Variant,
                      VariantSet, WriteConfiguration, farthest_m, scan_time)
from .settings import LaserSettings

# s: ACK, which a laser sends within 0.06 s (sheet 1.2). It may stand behind a scan that was cut, which is given up
# after `PARTIAL_TIMEOUT`.
HEARD_WITHIN = 0.3
ANSWERS_WITHIN = 1.0        # s: most requests
MODE_WITHIN = 3.0           # s: a change of the mode (sheet 1.2)
WRITE_WITHIN = 15.0         # s: to write the configuration
AFTER_NEW_SPEED = 0.25      # s until the laser listens at a new speed (sheet 1.9)
_INDICES = Availability.INDICES.value
TRIES = 3                   # while the mirror turns a request may be missed


class Ask(NamedTuple):
    """Send a request, and wait for a reply of one of some classes.

    Attributes:
        request: the request.
        wanted: the classes.
        seconds: how long to wait for the reply (s).
        tries: how often the request is sent at most.
        heard: how long to wait (s) after the laser has said that it heard the request, if that ends later.
    """

    request: Any
    wanted: Tuple[Type[Any], ...]
    seconds: float = ANSWERS_WITHIN
    tries: int = TRIES
    heard: float = 0.0


class SetLineSpeed(NamedTuple):
    """Set the speed of the port, once all bytes were sent."""

    baud: int


class LaserSpeed(NamedTuple):
    """Nothing is to be done: the laser sends at this speed from now on. The first one is that at which it was found."""

    baud: int


class Pause(NamedTuple):
    """Wait."""

    seconds: float


Step = Union[Ask, SetLineSpeed, LaserSpeed, Pause]
Conversation = Generator[Step, Any, Any]


class LaserInfo(NamedTuple):
    """What is known of a laser that measures.

    Attributes:
        type: what it calls itself, such as ``LMS200;301063;V02.10``.
        variant: how wide it looks, and how fine.
        configuration: what it keeps.
        baud: the speed at which it sends.
        found_baud: the speed at which it was found, and which it gets back at the end.
        remarks: what it does otherwise than it was asked, for people.
        errors: its errors when it was last asked for them, also old ones.
    """

    type: str
    variant: Variant
    configuration: Configuration
    baud: int
    found_baud: int
    remarks: Tuple[str, ...]
    errors: Tuple[DeviceError, ...] = ()

    @property
    def scan_time(self) -> float:
        """The time (s) from one scan of its stream to the next, as the speed of the line allows it."""
        return scan_time(self.variant, self.baud, bool(self.configuration.availability & _INDICES))

    @property
    def farthest_m(self) -> float:
        """The distance (m) that is just too far for it. NaN if it measures in a unit that nobody has explained."""
        unit = self.configuration.unit
        return farthest_m(MEASURING_MODES[self.configuration.measuring_mode], unit) if unit in METRES else math.nan


class NoLaserError(LinkError):
    """No laser answers, or it does not do what it must. The error message says what was tried."""


def opening(settings: LaserSettings, has_speed: bool) -> Conversation:
    """Find the laser, configure it, and start its stream. Returns its `LaserInfo`.

    Args:
        settings: what is asked of it.
        has_speed: whether the speed of the port can be set.

    Raises:
        NoLaserError: why there is no stream.
    """
    found = yield from _find(settings, has_speed)
    type_reply = yield from _need(AskType(), TypeReply)
    status = yield from _need(AskStatus(), StatusReply)
    baud = _speed_of(status, found)
    found_baud = baud
    yield LaserSpeed(baud)
    variant, remarks = yield from _set_variant(settings, Variant(status.angle_deg, status.step_hundredths))
    configuration, more = yield from _configure(settings)
    errors = yield from _ask_errors(())
    if has_speed and baud != settings.baud:
        yield from _change_speed(settings.baud)
        baud = settings.baud
    yield from _start()
    return LaserInfo(type_reply.text.decode("latin-1").strip(), variant, configuration, baud, found_baud,
                     tuple(remarks + more), errors)


def asking(info: LaserInfo) -> Conversation:
    """Ask a laser that sends scans for its errors. Returns what is known of it then.

    Its stream pauses for that, and goes on: at worst it is silent then, and is begun anew like any silent one.
    """
    errors = yield from _ask_errors(info.errors)
    return info._replace(errors=errors)


def closing(found_baud: int, baud: int, has_speed: bool) -> Conversation:
    """Stop the stream, and give the laser its old speed back. A laser that is gone is no error.

    Args:
        found_baud: the speed that it had.
        baud: the speed that it has.
        has_speed: whether the speed of the port can be set.
    """
    if has_speed:
        yield SetLineSpeed(baud)
    yield Ask(SetMode(Mode.ON_REQUEST, b""), (ModeSet,))
    if has_speed and baud != found_baud:
        yield Ask(SetMode(SPEEDS[found_baud].mode, b""), (ModeSet,))


def _find(settings: LaserSettings, has_speed: bool) -> Generator[Step, Any, Optional[int]]:
    """Return the speed (baud) at which the laser answers, and has stopped to send; None on a line without a speed.

    At first each speed is tried for a moment: a laser that is ready says at once that it heard something. A laser that
    sends scans at the right speed is found, too, though it misses requests. A laser whose power comes with the opening
    of the port is silent until it is ready. Later each speed is tried for longer: a laser that heard the request may
    take all of `MODE_WITHIN` to answer.
    """
    speeds: List[Optional[int]] = [None]
    if has_speed:
        speeds = [settings.baud, *(baud for baud in SPEEDS if baud != settings.baud)]
    rounds = max(1, round(settings.power_on / (2.0 * ANSWERS_WITHIN * len(speeds))))
    stop, found = SetMode(Mode.ON_REQUEST, b""), (ModeSet, ScanReply, PowerOn)
    quick, patient = Ask(stop, found, HEARD_WITHIN, 2, ANSWERS_WITHIN), Ask(stop, found, tries=2, heard=MODE_WITHIN)
    for ask in (quick, *[patient] * rounds):
        for baud in speeds:
            if baud is not None:
                yield SetLineSpeed(baud)
            heard = yield ask
            if isinstance(heard, ModeSet):
                return baud
            if heard is not None and (yield Ask(stop, (ModeSet,), MODE_WITHIN)) is not None:
                return baud
    at_speeds = " at %s baud" % ", ".join(map(str, speeds)) if has_speed else ""
    raise NoLaserError("no laser answers%s: is it on, and is it this port? A laser needs up to a minute until its red"
                       " and its yellow lamp are out" % at_speeds)


def _need(request: Any, wanted: Type[Any], seconds: float = ANSWERS_WITHIN, tries: int = TRIES) -> Conversation:
    """Send a request, and return the reply.

    Raises:
        NoLaserError: none came.
    """
    reply = yield Ask(request, (wanted, NotPossible), seconds, tries)
    if not isinstance(reply, wanted):
        raise NoLaserError("the laser %s %s" % (
            "refuses" if reply is not None else "does not answer", type(request).__name__))
    return reply


def _speed_of(status: StatusReply, found: Optional[int]) -> int:
    """Return the speed (baud) at which a laser sends: what it says itself, or else that at which it was found.

    The speed of the port may be none of the laser's: a pseudo-terminal takes every speed, and so may an adapter.

    Raises:
        NoLaserError: it says a speed that does not exist, and it was found on a line without a speed.
    """
    for baud, speed in SPEEDS.items():
        if speed.word == status.speed_word:
            return baud
    if found is not None:
        return found
    raise NoLaserError("the laser says that its line has the speed %04X, which none has" % status.speed_word)


def _set_variant(settings: LaserSettings, present: Variant) -> Generator[Step, Any, Tuple[Variant, List[str]]]:
    """Have the laser look as wide and as fine as it was asked; return how it does then, and a remark if it refused.

    It forgets this when it is switched off, so this is no matter of its EEPROM.

    Raises:
        NoLaserError: it says that it looks in a way in which none can. One client sends a step of 0 (laser sheet 1.9),
            and nobody knows what a laser makes of it.
    """
    wanted = Variant(settings.angle_deg or present.angle_deg, settings.step_hundredths or present.step_hundredths)
    now, accepted = present, True
    if wanted != present:
        reply = yield Ask(SetVariant(*wanted), (VariantSet, NotPossible))
        if reply is None:
            raise NoLaserError("the laser does not answer SetVariant")
        accepted = isinstance(reply, VariantSet) and bool(reply.accepted)
        if isinstance(reply, VariantSet):
            now = Variant(reply.angle_deg, reply.step_hundredths)
    if not now.is_possible:
        raise NoLaserError("the laser says that it looks %d degrees wide in steps of %.2f, which none can: give angle"
                           " and resolution, or take its power away for a moment" % (
                               now.angle_deg, now.step_hundredths / 100.0))
    if accepted and now == wanted:
        return now, []
    return now, ["it looks %d degrees wide in steps of %.2f: it refuses %d and %.2f" % (
        now.angle_deg, now.step_hundredths / 100.0, wanted.angle_deg, wanted.step_hundredths / 100.0)]


def _configure(settings: LaserSettings) -> Generator[Step, Any, Tuple[Configuration, List[str]]]:
    """Have the laser measure as it was asked; return what it keeps then, and a remark if that is not as asked.

    Raises:
        NoLaserError: its password is another, it refuses, or it measures no distances.
    """
    present = (yield from _need(AskConfiguration(), ConfigurationReply)).configuration
    asked = {"unit": settings.unit, "measuring_mode": settings.measuring_mode}
    other = {name: value for name, value in asked.items() if value is not None and value != getattr(present, name)}
    remarks = []
    if other and settings.writes:
        present = yield from _write(settings, present.changed(**other))
    elif other:
        remarks = ["its %s is %d, not %d as asked: that is written to its EEPROM only when it may be (write)" % (
            name.replace("_", " "), getattr(present, name), value) for name, value in other.items()]
    mode = MEASURING_MODES.get(present.measuring_mode)
    if mode is None or mode.is_strength:
        raise NoLaserError("the laser measures in mode %02X, %s: give another measuring_mode, and let it be written"
                           " (write)" % (present.measuring_mode, "the strength of echoes" if mode else
                                         "which nobody has explained"))
    return present, remarks


def _write(settings: LaserSettings, wanted: Configuration) -> Generator[Step, Any, Configuration]:
    """Write a configuration, and return it as the laser reads it back.

    Raises:
        NoLaserError: its password is another, or it keeps something else.
    """
    reply = yield from _need(SetMode(Mode.INSTALLATION, settings.password), ModeSet, MODE_WITHIN)
    if reply.result != 0:
        raise NoLaserError("the laser does not take the password %r, without which nothing is written" % (
            settings.password.decode("latin-1"),))
    yield from _need(WriteConfiguration(wanted), ConfigurationWritten, WRITE_WITHIN, tries=1)
    yield from _need(SetMode(Mode.ON_REQUEST, b""), ModeSet, MODE_WITHIN)
    kept: Configuration = (yield from _need(AskConfiguration(), ConfigurationReply)).configuration
    if kept != wanted:
        raise NoLaserError("the laser was told to keep unit %d and measuring mode %d, but keeps %d and %d" % (
            wanted.unit, wanted.measuring_mode, kept.unit, kept.measuring_mode))
    return kept


def _ask_errors(known: Tuple[DeviceError, ...]) -> Generator[Step, Any, Tuple[DeviceError, ...]]:
    """Return the errors of the laser, or those that are known already if it does not tell them."""
    reply = yield Ask(AskErrors(), (ErrorsReply, NotPossible))
    return tuple(reply.errors) if isinstance(reply, ErrorsReply) else known


def _change_speed(baud: int) -> Conversation:
    """Change the speed of the laser, then of the port, and see that the laser answers there.

    Raises:
        NoLaserError: it does not.
    """
    yield from _need(SetMode(SPEEDS[baud].mode, b""), ModeSet, MODE_WITHIN)
    yield LaserSpeed(baud)
    yield Pause(AFTER_NEW_SPEED)
    yield SetLineSpeed(baud)
    if (yield Ask(SetMode(Mode.ON_REQUEST, b""), (ModeSet,), heard=MODE_WITHIN)) is None:
        raise NoLaserError("the laser took %d baud, but does not answer there: this line may not carry it"
                           " (500000 needs RS-422)" % baud)


def _start() -> Conversation:
    """Start the stream.

    Raises:
        NoLaserError: the laser does not.
    """
    reply = yield Ask(SetMode(Mode.STREAM, b""), (ModeSet, ScanReply), MODE_WITHIN)
    if reply is None or (isinstance(reply, ModeSet) and reply.result != 0):
        raise NoLaserError("the laser does not begin to send scans")

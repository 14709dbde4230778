"""The numbers of all requests and replies, and how they become telegrams and come from them."""

from dataclasses import dataclass
from typing import Any, Dict

from ..errors import EncodingError
from ..wire_fields import TooShort, made, read_fields, rows, write_fields
from . import replies, requests
from .telegrams import ANSWERED, Telegram, encode_telegram

MESSAGES: Dict[int, Any] = {
    0x10: requests.ResetLaser,
    0x20: requests.SetMode,
    0x30: requests.AskScan,
    0x31: requests.AskStatus,
    0x32: requests.AskErrors,
    0x36: requests.AskMean,
    0x37: requests.AskValues,
    0x3A: requests.AskType,
    0x3B: requests.SetVariant,
    0x66: requests.KeepSpeed,
    0x74: requests.AskConfiguration,
    0x77: requests.WriteConfiguration,
    0x90: replies.PowerOn,
    0x91: replies.Resetting,
    0x92: replies.NotPossible,
    0xA0: replies.ModeSet,
    0xB0: replies.ScanReply,
    0xB1: replies.StatusReply,
    0xB2: replies.ErrorsReply,
    0xB7: replies.PartReply,
    0xBA: replies.TypeReply,
    0xBB: replies.VariantSet,
    0xE6: replies.SpeedKept,
    0xF4: replies.ConfigurationReply,
    0xF7: replies.ConfigurationWritten,
}
"""Each message by its number, which is the command of its telegram."""

NUMBERS: Dict[Any, int] = {message: number for number, message in MESSAGES.items()}

WELL = 0x10
"""The status byte of an ordinary laser that has nothing to say."""


@dataclass(frozen=True)
class UnknownMessage:
    """A telegram with a command that `MESSAGES` does not have."""

    command: int
    data: bytes


@dataclass(frozen=True)
class MalformedMessage:
    """A telegram with a known command, and data that are too short for it; `problem` says which."""

    command: int
    data: bytes
    problem: str


def decode(telegram: Telegram) -> Any:
    """Return the message of a telegram: an object of a class of `MESSAGES`, `UnknownMessage` or `MalformedMessage`.

    It never raises, whatever the data are. Data behind the last field of a message are ignored.
    """
    message = MESSAGES.get(telegram.command)
    if message is None:
        return UnknownMessage(telegram.command, telegram.data)
    try:
        return made(message, read_fields(rows(message), telegram.data)[0])
    except TooShort as short:
        return MalformedMessage(telegram.command, telegram.data, str(short))


def encode(message: Any, status: int = WELL, address: int = 0) -> bytes:
    """Return the bytes of the telegram of a message.

    Args:
        message: an object of a class of `MESSAGES`.
        status: of the laser. A request has none.
        address: of the laser.

    Raises:
        EncodingError: the object is no such message, or one of its values does not fit.
    """
    kind: Any = type(message)
    number = NUMBERS.get(kind)
    if number is None:
        raise EncodingError("%r is no message to or from a laser" % (message,))
    return encode_telegram(Telegram(number, write_fields(rows(kind), message),
                                    status if number >= ANSWERED else None, address))

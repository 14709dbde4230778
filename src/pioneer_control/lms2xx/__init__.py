"""The protocol of SICK's LMS2xx lasers: turns bytes into messages, and messages into bytes. No I/O, no clock, no ROS.

The lasers LMS200, 211, 220, 221 and 291 speak it on a serial line. `telegrams` draws a telegram byte by byte. ::

    bytes --TelegramDecoder--> Telegram --decode--> ScanReply, StatusReply, ...     from a laser
                                        --decode--> SetMode, AskStatus, ...         to a laser
    encode(SetMode(Mode.STREAM)) --> bytes

==================  =============================================================
``telegrams``       where telegrams begin and end, the CRC, the status byte
``requests``        the tables of all requests to a laser
``replies``         the tables of all its replies
``messages``        their numbers, and how they become telegrams and come from them
``configuration``   the table of what a laser keeps, and of its measuring modes
``scans``           a scan, and what its values mean in metres
``rates``           how fast a laser measures and sends, and when it fired a ray
``explain``         bytes of a line in words: ``python3 -m pioneer_control.lms2xx 02 00 02 00 20 24 34 08``
==================  =============================================================

The file `wire_fields` beside this folder reads and writes messages by their tables. All facts are those of the laser
sheet: SICK's telegram listing, and what programs that spoke with such lasers do.
"""

from .configuration import FACTORY, MEASURING_MODES, Availability, Configuration, MeasuringMode, Unit
from .messages import MESSAGES, WELL, MalformedMessage, UnknownMessage, decode, encode
from .rates import (RAY_S, TURN_S, VARIANTS, Variant, first_ray_before_first_byte, scan_bytes, scan_time,
                    time_on_line)
from .replies import (ConfigurationReply, ConfigurationWritten, DeviceError, ErrorsReply, ModeSet, NotPossible,
                      PartReply, PowerOn, Resetting, ScanReply, SpeedKept, StatusReply, TypeReply, VariantSet)
from .requests import (PASSWORD, SPEEDS, AskConfiguration, AskErrors, AskMean, AskScan, AskStatus, AskType, AskValues,
                       KeepSpeed, Mode, ResetLaser, ScanPart, SetMode, SetVariant, Speed, WriteConfiguration)
from .scans import CODES, DAZZLED, METRES, Indices, RawScan, codes_in, farthest_m, ranges_m, reflector_levels
from .telegrams import (LONGEST, PARTIAL_TIMEOUT, Answer, Severity, Status, Telegram, TelegramCounts, TelegramDecoder,
                        crc, encode_telegram, severity)

__all__ = [
    "LONGEST", "PARTIAL_TIMEOUT", "Answer", "Severity", "Status", "Telegram", "TelegramCounts", "TelegramDecoder",
    "crc", "encode_telegram", "severity",
    "MESSAGES", "WELL", "MalformedMessage", "UnknownMessage", "decode", "encode",
    "PASSWORD", "SPEEDS", "AskConfiguration", "AskErrors", "AskMean", "AskScan", "AskStatus", "AskType", "AskValues",
    "KeepSpeed", "Mode", "ResetLaser", "ScanPart", "SetMode", "SetVariant", "Speed", "WriteConfiguration",
    "ConfigurationReply", "ConfigurationWritten", "DeviceError", "ErrorsReply", "ModeSet", "NotPossible", "PartReply",
    "PowerOn", "Resetting", "ScanReply", "SpeedKept", "StatusReply", "TypeReply", "VariantSet",
    "FACTORY", "MEASURING_MODES", "Availability", "Configuration", "MeasuringMode", "Unit",
    "CODES", "DAZZLED", "METRES", "Indices", "RawScan", "codes_in", "farthest_m", "ranges_m", "reflector_levels",
    "RAY_S", "TURN_S", "VARIANTS", "Variant", "first_ray_before_first_byte", "scan_bytes", "scan_time",
    "time_on_line",
]

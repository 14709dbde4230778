"""Every exception this package raises on purpose, in one small tree, by whose fault it is.

::

    PioneerError
    ├── UsageError          our caller's: a value, a name or a file that makes no sense (also a ValueError)
    │   ├── EncodingError       a value that does not fit the wire
    │   ├── UnknownModelError   a robot model that no table knows
    │   ├── ParameterError      a parameter of the wrong type or out of its range
    │   └── WorldError          a world file that is missing or does not parse
    ├── LinkError           the line's: no port, no answer, no link any more (also a ConnectionError)
    │   ├── PortError           the port cannot be opened
    │   ├── NoAnswerError       nothing answers on it (also a TimeoutError)
    │   └── LinkLostError       it worked, and is gone
    └── RobotError          the robot's: it answers, but does not do what was asked
        ├── RefusedError        and it says why (STOP button pressed, ...)
        └── NotConfirmedError   and it never says it did (also a TimeoutError)

A message says what was tried, what came back, and what to do.
"""


class PioneerError(Exception):
    """Base of all errors of this package."""


class UsageError(PioneerError, ValueError):
    """The caller gave something that makes no sense; the message names it and what is legal."""


class EncodingError(UsageError):
    """A value does not fit the field of the protocol it was meant for."""


class UnknownModelError(UsageError):
    """No robot model of that name or subtype; the message lists what is near."""


class ParameterError(UsageError):
    """A parameter has the wrong type, is out of range, or is not known."""


class WorldError(UsageError):
    """A world does not exist or its file does not parse."""


class LinkError(PioneerError, ConnectionError):
    """The line to the robot is not there, silent, or gone."""


class PortError(LinkError):
    """The port cannot be opened: it does not exist, is in use, or may not be used by this user."""


class NoAnswerError(LinkError, TimeoutError):
    """The port opens, but nothing on it answers as a robot."""


class LinkLostError(LinkError):
    """The link worked and broke: cable, power, or the other side closed it."""


class RobotError(PioneerError):
    """The robot answers but does not do what was asked."""


class RefusedError(RobotError):
    """The robot will not do it, and reports the reason (for example a pressed STOP button)."""


class NotConfirmedError(RobotError, TimeoutError):
    """The robot was asked, again and again, and never reported that it did it."""

"""Every exception that this package raises on purpose. The branches of the tree show where the fault lies.

::

    PioneerError
    ├── UsageError          at the caller: a value, a name or a file that makes no sense (also a ValueError)
    │   ├── EncodingError       a value that does not fit its field of the protocol
    │   ├── UnknownModelError   a robot model that is not in the table of models
    │   ├── ParameterError      a parameter of the wrong type or out of its range
    │   └── WorldError          a world file that is missing or does not parse
    ├── LinkError           at the link to the robot (also a ConnectionError)
    │   ├── PortError           the port cannot be opened
    │   ├── NoAnswerError       the port is open, but no robot answers (also a TimeoutError)
    │   └── LinkLostError       the link worked, then it broke
    └── RobotError          at the robot: it answers, but does not do what it was asked to do
        ├── RefusedError        it refuses, and the reason is known (STOP button pressed, ...)
        ├── NotConfirmedError   it never confirms that it did it (also a TimeoutError)
        └── CalibrationError    its runs do not allow to calibrate it

The error message states what was tried, what came back, and what the user can do.
"""


class PioneerError(Exception):
    """The base class of all exceptions of this package."""


class UsageError(PioneerError, ValueError):
    """The caller gave a value, a name or a file that makes no sense. The error message names it, and what is legal."""


class EncodingError(UsageError):
    """A value does not fit into its field of the protocol."""


class UnknownModelError(UsageError):
    """The table has no robot model of this name or subtype. The error message lists models with similar names."""


class ParameterError(UsageError):
    """A parameter has the wrong type, is out of range, or does not exist."""


class WorldError(UsageError):
    """A world file of the simulator does not exist, or does not parse."""


class LinkError(PioneerError, ConnectionError):
    """There is no link to the robot: no port, no answer, or the link broke."""


class PortError(LinkError):
    """The port cannot be opened: it does not exist, is in use, or this user has no permission."""


class NoAnswerError(LinkError, TimeoutError):
    """The port is open, but no robot answers on it."""


class LinkLostError(LinkError):
    """The link worked, then it broke: the cable, the power, or the other side closed the connection."""


class RobotError(PioneerError):
    """The robot answers, but does not do what it was asked to do."""


class RefusedError(RobotError):
    """The robot refuses a request, and the reason is known (for example a pressed STOP button)."""


class NotConfirmedError(RobotError, TimeoutError):
    """The robot received a request several times, and never confirmed that it did what was asked."""


class CalibrationError(RobotError):
    """The runs of a robot do not allow to calibrate it: they contradict each other, or no wheel can be so wrong."""

"""What the user wants of a connection, checked once."""

import math
from dataclasses import dataclass
from typing import FrozenSet, Optional

from ..errors import ParameterError
from ..p2os import BAUD_RATES
from ..robots import find_model, load_table
from .tuning import Tuning


@dataclass(frozen=True)
class Settings:
    """See Robot for the meaning of each.

    Raises ParameterError that names the value and its legal range, UnknownModelError and UsageError for a model or a
    models file that is none.
    """

    model: Optional[str] = None
    models_file: Optional[str] = None
    pulse: float = 1.0
    use_sonar: bool = True
    command_timeout: float = 0.6
    max_linear: Optional[float] = None
    max_angular: Optional[float] = None
    has_gripper: Optional[bool] = None
    tuning: Tuning = Tuning()
    host_baud: Optional[int] = None
    link_check: bool = True
    data: FrozenSet[str] = frozenset()
    """Kinds of packets to be asked for (data_requests.DATA)."""

    def __post_init__(self) -> None:
        _check("pulse", self.pulse, self.pulse >= 0, "0 (none) or more seconds")
        _check("command_timeout", self.command_timeout, self.command_timeout > 0, "more than 0 s")
        for name in ("max_linear", "max_angular"):
            value = getattr(self, name)
            if value is not None:
                _check(name, value, value >= 0, "0 or more, or None for the robot's own limit")
        if self.host_baud is not None and self.host_baud not in BAUD_RATES:
            raise ParameterError("host_baud is %r; legal: %s, or None for the robot's own"
                                 % (self.host_baud, ", ".join(map(str, BAUD_RATES))))
        if self.model is not None:
            find_model(self.model, self.models_file)
        elif self.models_file is not None:
            load_table(self.models_file)


def _check(name: str, value: float, legal: bool, what: str) -> None:
    if not legal or not math.isfinite(value):
        raise ParameterError("%s is %r; legal: %s" % (name, value, what))

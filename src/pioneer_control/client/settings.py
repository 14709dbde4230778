"""The user's settings of a connection. They are checked when they are made."""

import math
from dataclasses import dataclass
from typing import FrozenSet, Optional

from ..errors import ParameterError
from ..p2os import BAUD_RATES
from ..robots import find_model, load_table
from .tuning import Tuning


@dataclass(frozen=True)
class Settings:
    """The settings of a connection. The class Robot explains each of them.

    Raises ParameterError with the value and its legal range, UnknownModelError for a model that no table has, and
    UsageError for a file that is not a models file.
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
    """Kinds of packets to request; data_requests.DATA has all kinds."""

    def __post_init__(self) -> None:
        limit = "0 or more, or None for the robot's own limit"
        checks = (
            ("pulse", 0 <= self.pulse < math.inf, "0 (none) or more seconds"),
            ("command_timeout", 0 < self.command_timeout < math.inf, "more than 0 s"),
            ("max_linear", self.max_linear is None or 0 <= self.max_linear < math.inf, limit),
            ("max_angular", self.max_angular is None or 0 <= self.max_angular < math.inf, limit),
            ("host_baud", self.host_baud is None or self.host_baud in BAUD_RATES,
             "%s, or None for the robot's own" % ", ".join(map(str, BAUD_RATES))),
        )
        for name, legal, what in checks:
            if not legal:
                raise ParameterError("%s is %r; legal: %s" % (name, getattr(self, name), what))
        if self.model is not None:
            find_model(self.model, self.models_file)
        elif self.models_file is not None:
            load_table(self.models_file)

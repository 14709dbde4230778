"""Who may command a robot: several inputs with priorities and time-outs, and locks. Pure: time is an argument.

The terms are those of twist_mux. One difference is for safety: an input of a person never hands the robot back by
silence. From its first command on, inputs of lower priority are locked out until somebody calls release(). Meanwhile a
silent person means that the robot stands.

>>> helm = Helm({"cmd_vel": VelocityInput(10, 0.6), "teleop/cmd_vel": VelocityInput(100, 0.5, keeps_helm=True)})
>>> helm.command("cmd_vel", 0.0, "/wander")
>>> helm.command("teleop/cmd_vel", 0.1, "/joystick")
>>> helm.obstacle("cmd_vel", 9.0)
'teleop/cmd_vel'
>>> helm.release()
>>> helm.obstacle("cmd_vel", 9.0) is None
True
"""

import math
from typing import Dict, Mapping, NamedTuple, Optional, Set, Tuple


class VelocityInput(NamedTuple):
    """One way by which velocities come to the robot."""

    priority: int
    """An input commands only while no input of higher priority does. Of two with the same, the newest command counts.
    """
    timeout: float
    """Time (s) after which a velocity of this input is too old: the robot stops, and lower inputs may command."""
    keeps_helm: bool = False
    """Whether inputs of lower priority stay locked out after the time-out, until Helm.release()."""


class HelmState(NamedTuple):
    """Who commands a robot, and who may not."""

    commander: str = ""
    """The input whose velocities the robot follows now. Empty: no input has commanded within its time-out."""
    who: str = ""
    """Who commanded last by that input, or by the input that has the helm: for people. Empty when nobody did."""
    holder: str = ""
    """The input that has the helm, also while it is silent. Inputs of lower priority are locked out. Empty: none."""
    locks: Tuple[str, ...] = ()
    """The names of the locks that are set. While there is one, the robot may only be told to stand."""


class _Heard(NamedTuple):
    """The newest command of an input: its time (monotonic, s), and who gave it."""

    time: float
    who: str


class Helm:
    """Decides which inputs may command. It sends nothing itself: `SteeredRobot` does.

    Args:
        inputs: all inputs by their names.
    """

    def __init__(self, inputs: Mapping[str, VelocityInput]) -> None:
        self._inputs = dict(inputs)
        self._heard: Dict[str, _Heard] = {}
        self._holder = ""
        self._locks: Set[str] = set()

    def timeout(self, name: str) -> float:
        """Return the time (s) for which a velocity of this input is good."""
        return self._inputs[name].timeout

    def set_timeout(self, name: str, timeout: float) -> None:
        """Change the time (s) for which a velocity of this input is good."""
        self._inputs[name] = self._inputs[name]._replace(timeout=timeout)

    def obstacle(self, name: str, now: float) -> Optional[str]:
        """Return why this input may not command now: the name of a lock, or of an input above it. None if it may."""
        if self._locks:
            return min(self._locks)
        mine = self._inputs[name].priority
        for other, above in self._inputs.items():
            if above.priority > mine and (other == self._holder or self._is_active(other, now)):
                return other
        return None

    def takes_over(self, name: str, now: float) -> bool:
        """Return whether another input commands now, which has a lower priority than this one."""
        commander = self._commander(now)
        return bool(commander) and self._inputs[name].priority > self._inputs[commander].priority

    def keeps_helm(self, name: str) -> bool:
        """Return whether this input is that of a person: inputs of lower priority stay locked out by it."""
        return self._inputs[name].keeps_helm

    def command(self, name: str, now: float, who: str = "") -> None:
        """Take note of a command by an input that may command: see obstacle()."""
        self._heard[name] = _Heard(now, who)
        if self._inputs[name].keeps_helm and (
                not self._holder or self._inputs[name].priority >= self._inputs[self._holder].priority):
            self._holder = name

    def release(self) -> None:
        """Take the helm from the input that has it. Inputs of lower priority may command at once."""
        self._heard.pop(self._holder, None)
        self._holder = ""

    def lock(self, name: str) -> None:
        """Set a lock. Until unlock() no input may command."""
        self._locks.add(name)

    def unlock(self, name: str) -> None:
        """Take a lock away. Commands from before count no more, and who had the helm still has it."""
        self._locks.discard(name)
        self._heard = {self._holder: self._heard[self._holder]._replace(time=-math.inf)} if self._holder else {}

    def state(self, now: float) -> HelmState:
        """Return who commands now (monotonic, s)."""
        commander = "" if self._locks else self._commander(now)
        speaker = self._heard.get(commander or self._holder)
        return HelmState(commander, speaker.who if speaker else "", self._holder, tuple(sorted(self._locks)))

    def changes_at(self, now: float) -> float:
        """Return when the present commander will be silent for too long (monotonic, s); infinity without one."""
        commander = self._commander(now)
        return self._heard[commander].time + self._inputs[commander].timeout if commander else math.inf

    def _is_active(self, name: str, now: float) -> bool:
        heard = self._heard.get(name)
        return heard is not None and now < heard.time + self._inputs[name].timeout

    def _commander(self, now: float) -> str:
        """Return the active input of the highest priority, of two equal ones the newest. Empty when none is active."""
        active = [name for name in self._inputs if self._is_active(name, now)]
        return max(active, key=lambda name: (self._inputs[name].priority, self._heard[name].time), default="")

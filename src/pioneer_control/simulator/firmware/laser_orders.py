"""What a client asks of the laser over the robot's own line, and when a command is meant for it (laser sheet 3.2).

Four commands of the laser have the numbers of other commands of a Pioneer: 35 ADSEL, 36 GRIPPERVAL, 37 GRIPREQUEST,
38 GYROCALCW. The sheet says how to tell them apart [inv]. The vendor's client sends 36, 37, 38, 35 in one burst, and
GRIPPERVAL is sent only right after GRIPPER. So:

* 36 is the laser's, unless a GRIPPER command that needs a value came right before it;
* of these four numbers, 37 is the laser's right after such a 36, 38 right after such a 37, and 35 with 0, 1 or 2 right
  after such a 38. Commands with other numbers may come between: a client drives, too, and from another thread;
* 35 with 0 is the laser's, too, while scans are sent.

All else goes to the robot, as without a laser. The commands 230 to 233 are always the laser's.
"""

from typing import Callable, Dict, NamedTuple, Optional

from ...p2os import Frame, GripperCommand, ReceivedCommand, decode_simulator_command

OFF, PLAIN_SCANS, EXTENDED_SCANS = 0, 1, 2
"""What scans are sent: none, packets 0x60, or packets 0x61."""
MOST_VALUES = 1441
"""Most values of a scan: a full turn in steps of 0.25 degrees [inv]."""


class FieldOfView(NamedTuple):
    """Which rays a scan has: from the angle `first_deg` to `last_deg` (0 is ahead, positive is left), with a step of so
    many hundredths of a degree.
    """

    first_deg: int = -90
    last_deg: int = 90
    step_hundredths: int = 100

    @property
    def values(self) -> int:
        """The number of rays."""
        return (self.last_deg - self.first_deg) * 100 // self.step_hundredths + 1

    @property
    def is_legal(self) -> bool:
        """Whether there are such rays, and not too many."""
        return (-360 <= self.first_deg <= self.last_deg <= self.first_deg + 360 <= 720 and self.step_hundredths > 0
                and self.values <= MOST_VALUES)


class LaserOrders:
    """What the client of one session has asked of the laser.

    Attributes:
        scans: `OFF`, `PLAIN_SCANS` or `EXTENDED_SCANS`.
        view: which rays a scan has.
    """

    def __init__(self) -> None:
        self.scans = OFF
        self.view = FieldOfView()
        self._asked = self.view     # the angles count only when the step has come
        self._before = ""           # name of the laser's command before, if nothing else with its numbers came since

    def takes(self, frame: Frame, previous: Optional[ReceivedCommand]) -> bool:
        """Do what a command says if it is meant for the laser, and return whether it is. Call this for each command.

        Args:
            frame: the command.
            previous: the command before it.
        """
        order = decode_simulator_command(frame)
        if order is None or order.name not in _ACTS:
            return False
        before, self._before = self._before, ""
        if not order.values:
            return False
        value = order.values[0]
        if order.name in _RIGHT_AFTER and not self._is_meant(order.name, value, before, previous):
            return False
        self._before = order.name
        _ACTS[order.name](self, value)
        return True

    def _is_meant(self, name: str, value: int, before: str, previous: Optional[ReceivedCommand]) -> bool:
        """Return whether a command with a number of another command is meant for the laser."""
        if name == "OLD_LASER_FIRST":
            return previous is None or previous.name != "GRIPPER" or previous.value not in _GRIPPER_WANTS_VALUE
        if name == "OLD_LASER_ENABLE" and value == OFF and self.scans != OFF:
            return True
        return before == _RIGHT_AFTER[name] and (name != "OLD_LASER_ENABLE" or OFF <= value <= EXTENDED_SCANS)

    def _first(self, deg: int) -> None:
        self._asked = self._asked._replace(first_deg=deg)

    def _last(self, deg: int) -> None:
        self._asked = self._asked._replace(last_deg=deg)

    def _step(self, hundredths: int) -> None:
        """Let the angles count from now on. If they make no sense, those before them stay."""
        self._asked = self._asked._replace(step_hundredths=hundredths)
        if self._asked.is_legal:
            self.view = self._asked

    def _enable(self, scans: int) -> None:
        if OFF <= scans <= EXTENDED_SCANS:
            self.scans = scans


_FIRST = "Angle of the first ray (degrees), positive to the left. It counts when the step comes."
_LAST = "Angle of the last ray (degrees). It counts when the step comes."
_STEP = ("Angle between two rays (hundredths of a degree), at most 1441 rays. The two angles count from now on, unless"
         " they make no sense together.")
_ENABLE = "1: one scan behind each SIP, in packets 0x60. 2: in packets 0x61. 0: no scans."
_BURST = " Only in the burst 36, 37, 38, 35, in which commands with other numbers may stand, too."
DOES: Dict[str, str] = {
    "OLD_LASER_ENABLE": _ENABLE + _BURST + " 0 also alone, while there are scans. Else it is ADSEL.",
    "OLD_LASER_FIRST": _FIRST + " Directly after GRIPPER 16 or 17 it is GRIPPERVAL.",
    "OLD_LASER_LAST": _LAST + _BURST + " Else it is GRIPREQUEST.",
    "OLD_LASER_STEP": _STEP + _BURST + " Else it is GYROCALCW.",
    "SIM_LRF_ENABLE": _ENABLE, "SIM_LRF_SET_FOV_START": _FIRST, "SIM_LRF_SET_FOV_END": _LAST, "SIM_LRF_SET_RES": _STEP,
    "SIM_SET_POSE": "ignored: who carries a robot is somebody in the room (order `put`, service `~carry`), no client",
    "SIM_RESET": "ignored: as SIM_SET_POSE (order `reset`)",
    "SIM_CTRL": "ignored: the world is that of the start",
    "SIM_STAT": "ignored: the truth has a socket of its own",
    "SIM_MESSAGE": "ignored: nobody is shown a message",
    "SIM_EXIT": "ignored: a client does not end the simulator, in which others may have robots",
}
"""What each command of simulators does to a robot with a laser over its line, for ``docs/simulator-commands.md``."""

_GRIPPER_WANTS_VALUE = (GripperCommand.PRESSURE, GripperCommand.CARRY)
_RIGHT_AFTER: Dict[str, str] = {
    "OLD_LASER_FIRST": "", "OLD_LASER_LAST": "OLD_LASER_FIRST", "OLD_LASER_STEP": "OLD_LASER_LAST",
    "OLD_LASER_ENABLE": "OLD_LASER_STEP"}
_ACTS: Dict[str, Callable[[LaserOrders, int], None]] = {
    "OLD_LASER_FIRST": LaserOrders._first, "SIM_LRF_SET_FOV_START": LaserOrders._first,
    "OLD_LASER_LAST": LaserOrders._last, "SIM_LRF_SET_FOV_END": LaserOrders._last,
    "OLD_LASER_STEP": LaserOrders._step, "SIM_LRF_SET_RES": LaserOrders._step,
    "OLD_LASER_ENABLE": LaserOrders._enable, "SIM_LRF_ENABLE": LaserOrders._enable,
}

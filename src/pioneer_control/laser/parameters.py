"""All parameters of the laser's node, in the dataclass `LaserParameters`: default, legal values, unit and meaning.

The names are those of sicktoolbox_wrapper, where it has them (laser sheet 4.3). This file uses no ROS.
"""

import math
from dataclasses import dataclass
from typing import Any, List, Mapping, NamedTuple, Optional, Tuple, Union

from ..errors import ParameterError
from ..lms2xx import MEASURING_MODES, PASSWORD, SPEEDS, Unit
from ..parameters import AutoSwitch, Choice, Number, Numbers, Switch, Text, check_old, parameter
from ..robots import find_model
from .settings import LaserSettings

KEEP = -1
"""Measuring mode that means: the one that the laser has."""
MODES = tuple(number for number, mode in MEASURING_MODES.items() if not mode.is_strength)
UNITS = {"": None, "cm": Unit.CENTIMETRES, "mm": Unit.MILLIMETRES}
WITHOUT_EFFECT = {
    "connect_delay": "a laser that has just got power is waited for (power_on)",
    **dict.fromkeys("desired_frequency min_frequency max_frequency frequency_tolerance window_size".split(),
                    "the diagnostics know how many scans the speed of the line allows"),
    **dict.fromkeys("min_acceptable_delay max_acceptable_delay".split(),
                    "the stamp is the time of the first ray: the time on the line is taken off"),
    "hardware_id": "the diagnostics name the laser as it names itself",
}
"""Parameters of sicktoolbox_wrapper that have no effect in this node, and the text of the warning for each of them."""

Coordinates = Tuple[float, float, float, float]


class Mounting(NamedTuple):
    """Checks a parameter that says where a laser sits: x, y, z, yaw (m, rad; base_link), or the subtype of a model."""

    legal: str = "four numbers, as a list: x, y, z, yaw; or a model of robots; or an empty text"

    def accept(self, value: Any) -> Union[Coordinates, str, None]:
        """Return the numbers, the subtype, or None for an empty text. Raise ValueError if the value is none of them."""
        if isinstance(value, str):
            text = value.strip()
            if not text.startswith("["):
                return text or None
            value = [float(word) for word in text.strip("[]").split(",")]
        x, y, z, yaw = Numbers(4, -1e3, 1e3).accept(value)
        return x, y, z, yaw


@dataclass(frozen=True)
class LaserParameters:
    """The checked private parameters of the laser's node. What a laser keeps is not touched unless it is asked for."""

    port: str = parameter("/dev/lms200", Text(), "serial device, or socket://host:port")
    baud: int = parameter(38400, Choice(tuple(SPEEDS)), "speed of a serial line while the laser measures; the laser is"
                          " found at any", "baud")
    angle: int = parameter(0, Choice((0, 100, 180)), "field of view; 0: leave it as it is", "deg")
    resolution: float = parameter(0.0, Choice((0.0, 0.25, 0.5, 1.0)), "angle between two rays; 0: leave it as it is",
                                  "deg")
    units: str = parameter("", Choice(tuple(UNITS)), "mm: ranges to 8 m; cm: to 80 m; empty: leave it as it is")
    measuring_mode: int = parameter(KEEP, Choice((KEEP, *MODES)), "what the bits of a value mean: docs/laser.md; -1:"
                                    " leave it as it is")
    write: bool = parameter(False, Switch(), "units and measuring_mode may be written to the laser's EEPROM, if they"
                            " differ; it lasts for a few thousand writes")
    password: str = parameter(PASSWORD.decode("ascii"), Text(), "the laser's password, eight characters; used only"
                              " to write")
    inverted: Optional[bool] = parameter(None, AutoSwitch(), "the laser hangs upside down; auto: as the model in place"
                                         " says, else not")
    place: Union[Coordinates, str, None] = parameter(
        None, Mounting(), "where the laser sits: tf from base_link_frame_id to frame_id; empty: no tf", "m, rad")
    models_file: str = parameter("", Text(empty=True), "file with your own models, for place; empty: none")
    base_link_frame_id: str = parameter("base_link", Text(slash=False), "frame of the robot")
    frame_id: str = parameter("laser", Text(slash=False), "frame of the scans")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "put before both frame names, e.g. robot2/")
    time_offset: float = parameter(0.0, Number(-10.0, 10.0), "added to each stamp", "s")
    no_echo: str = parameter("inf", Choice(("inf", "max")), "range where nothing is in sight: inf, or a little less"
                             " than range_max")
    record: str = parameter("", Text(empty=True), "file for every byte of the line, for a bug report; empty: none")
    power_on: float = parameter(65.0, Number(0.0, 600.0), "how long a laser may take from power on until it answers",
                                "s")

    @property
    def laser_frame(self) -> str:
        """The full name of the frame of the scans, with the prefix."""
        return self.frame_prefix + self.frame_id

    @property
    def base_frame(self) -> str:
        """The full name of the frame of the robot, with the prefix."""
        return self.frame_prefix + self.base_link_frame_id

    @property
    def settings(self) -> LaserSettings:
        """What is asked of the laser.

        Raises:
            ParameterError: no laser can have this.
        """
        return LaserSettings(
            baud=self.baud,
            angle_deg=self.angle or None,
            step_hundredths=round(self.resolution * 100.0) or None,
            unit=UNITS[self.units],
            measuring_mode=None if self.measuring_mode == KEEP else self.measuring_mode,
            writes=self.write,
            password=self.password.encode("latin-1", "replace"),
            power_on=self.power_on)

    @property
    def mounted(self) -> "Mounted":
        """Where the laser sits, and how.

        Raises:
            UsageError: the model in `place` is not known, or has no laser that is known.
        """
        if not isinstance(self.place, str):
            return Mounted(self.place, bool(self.inverted), False)
        laser = find_model(self.place, self.models_file or None).laser
        if laser is None:
            raise ParameterError("~place = %r: where the laser of this model sits is not known; give x, y, z, yaw as a"
                                 " list, or the key laser in a models file" % self.place)
        inverted = laser.upside_down if self.inverted is None else self.inverted
        return Mounted((laser.x, laser.y, laser.z or 0.0, 0.0), inverted, laser.z is None)


class Mounted(NamedTuple):
    """Where a laser sits, and how.

    Upside down is told once: by the transform base_link -> laser, if the node publishes it (roll is pi), or else by the
    order of the values, as sicktoolbox_wrapper does: then the user's own frame of the laser is upright.

    Attributes:
        place: x, y, z (m) and yaw (rad) of its frame in base_link. None: nobody has said it.
        inverted: it hangs upside down.
        height_is_missing: z is 0 because nobody knows it.
    """

    place: Optional[Coordinates]
    inverted: bool
    height_is_missing: bool

    @property
    def turns_values(self) -> bool:
        """Whether the values are put into the opposite order."""
        return self.inverted and self.place is None

    @property
    def rotation(self) -> Tuple[float, float, float, float]:
        """The quaternion x, y, z, w of its frame in base_link: a roll by pi if it hangs upside down, then the yaw."""
        half = (0.0 if self.place is None else self.place[3]) / 2.0
        c, s = math.cos(half), math.sin(half)
        return (c, s, 0.0, 0.0) if self.inverted else (0.0, 0.0, s, c)


def check_laser_parameters(given: Mapping[str, Any]) -> Tuple[LaserParameters, List[str]]:
    """Check the private parameters of the laser's node.

    Args:
        given: names and values from the parameter server.

    Returns:
        The parameters; and a warning for each given name that has no effect.

    Raises:
        UsageError: a value is not legal, an unknown name is similar to a known one, or values do not go together.
    """
    parameters, warnings = check_old(LaserParameters, given, WITHOUT_EFFECT)
    for each in ("settings", "mounted"):
        getattr(parameters, each)       # raises, if it makes no sense
    return parameters, warnings

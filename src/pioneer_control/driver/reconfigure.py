"""dynamic_reconfigure without a .cfg file: the table of parameters says what may change while the driver runs, and
within which bounds.

The server of dynamic_reconfigure itself moves a value that is out of range to the bound, and lets NaN pass. This one
refuses such values, and the log says why.
"""

import threading
from typing import Any, Callable, Dict, Mapping

import rospy
from dynamic_reconfigure.msg import (Config, ConfigDescription, DoubleParameter, Group, GroupState, IntParameter,
                                     ParamDescription)
from dynamic_reconfigure.srv import Reconfigure, ReconfigureRequest, ReconfigureResponse

from ..errors import PioneerError
from .parameters import LIVE, DriverParameters, changed

TYPES = {int: "int", float: "double"}
"""The types of values that may change, with their names in a description."""
GROUP = "Default"


def encode(values: Mapping[str, Any]) -> Config:
    """Parameters and their values as a message."""
    return Config(
        ints=[IntParameter(name, value) for name, value in values.items() if isinstance(value, int)],
        doubles=[DoubleParameter(name, value) for name, value in values.items() if isinstance(value, float)],
        groups=[GroupState(GROUP, True, 0, 0)])


def decode(config: Config) -> Dict[str, Any]:
    """The parameters in a message and their values, also of parameters that may not change."""
    return {entry.name: entry.value for entry in (*config.bools, *config.ints, *config.doubles, *config.strs)}


def description() -> ConfigDescription:
    """What may change, from the table."""
    defaults = values_of(DriverParameters())
    rows = []
    for name, value in defaults.items():
        row = LIVE[name].metadata
        meaning = "%(meaning)s (%(unit)s)" % row if row["unit"] else row["meaning"]
        rows.append(ParamDescription(name, TYPES[type(value)], 0, meaning, ""))
    least, most = (
        encode({name: type(value)(getattr(LIVE[name].metadata["kind"], bound)) for name, value in defaults.items()})
        for bound in ("low", "high"))
    return ConfigDescription(groups=[Group(GROUP, "", rows, 0, 0)], min=least, max=most, dflt=encode(defaults))


def values_of(parameters: DriverParameters) -> Dict[str, Any]:
    """The values that may change."""
    return {name: getattr(parameters, name) for name in LIVE}


class Reconfiguration:
    """The topics and the service of dynamic_reconfigure.

    Args:
        parameters: as they are.
        apply: is given the parameters as they shall be, and makes it so. When it raises PioneerError, nothing has
            changed, and the error is the answer to who asked.
    """

    def __init__(self, parameters: DriverParameters, apply: Callable[[DriverParameters], None]) -> None:
        self._parameters = parameters
        self._apply = apply
        self._lock = threading.Lock()
        rospy.Publisher("~parameter_descriptions", ConfigDescription, queue_size=1, latch=True).publish(description())
        self._updates = rospy.Publisher("~parameter_updates", Config, queue_size=1, latch=True)
        self._updates.publish(encode(values_of(parameters)))
        rospy.Service("~set_parameters", Reconfigure, self._set)

    def _set(self, request: ReconfigureRequest) -> ReconfigureResponse:
        with self._lock:
            try:
                wanted = changed(self._parameters, decode(request.config))
                self._apply(wanted)
            except PioneerError as error:
                rospy.logwarn("%s", error)      # the usual clients do not show what a service says
                raise rospy.ServiceException(str(error)) from None
            before, after = values_of(self._parameters), values_of(wanted)
            self._parameters = wanted
            self._updates.publish(encode(after))
            for name in (name for name in LIVE if after[name] != before[name]):
                rospy.loginfo("~%s: %s -> %s", name, before[name], after[name])
                self._keep(name, after[name])
        return ReconfigureResponse(encode(after))

    def _keep(self, name: str, value: Any) -> None:
        """Keep a value for the next start. When the master is gone, that is only logged: the robot obeys already."""
        try:
            rospy.set_param("~" + name, value)
        except OSError as error:
            rospy.logwarn("~%s is %s until this driver ends; the parameter server does not keep it: %s", name, value,
                          error)

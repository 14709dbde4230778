"""A server for dynamic_reconfigure that needs no .cfg file: it uses the table of parameters of the driver.

The standard server changes a value that is out of range to the limit, and accepts NaN. This server refuses such values,
and logs the reason.
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
"""The types of the parameters that may change, and their names in dynamic_reconfigure."""
GROUP = "Default"


def encode(values: Mapping[str, Any]) -> Config:
    """Return a Config message with these values by parameter name."""
    return Config(
        ints=[IntParameter(name, value) for name, value in values.items() if isinstance(value, int)],
        doubles=[DoubleParameter(name, value) for name, value in values.items() if isinstance(value, float)],
        groups=[GroupState(GROUP, True, 0, 0)])


def decode(config: Config) -> Dict[str, Any]:
    """Return all values in a Config message by parameter name, also of parameters that may not change."""
    return {entry.name: entry.value for entry in (*config.bools, *config.ints, *config.doubles, *config.strs)}


def description() -> ConfigDescription:
    """Return the message that describes the parameters that may change: type, meaning, limits and default."""
    defaults = values_of(DriverParameters())
    rows = [ParamDescription(name, TYPES[type(entry.default)], 0, entry.metadata["meaning"] + (
        " (%s)" % entry.metadata["unit"] if entry.metadata["unit"] else ""), "") for name, entry in LIVE.items()]
    least, most = (
        encode({name: type(value)(getattr(LIVE[name].metadata["kind"], bound)) for name, value in defaults.items()})
        for bound in ("low", "high"))
    return ConfigDescription(groups=[Group(GROUP, "", rows, 0, 0)], min=least, max=most, dflt=encode(defaults))


def values_of(parameters: DriverParameters) -> Dict[str, Any]:
    """Return the values of the parameters that may change while the driver runs, by name."""
    return {name: getattr(parameters, name) for name in LIVE}


class Reconfiguration:
    """The topics and the service of dynamic_reconfigure.

    Args:
        parameters: the current parameters.
        apply: a function that puts new parameters into effect. When it raises PioneerError, nothing changes, and the
            client of the service gets the error.
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
                rospy.logwarn("%s", error)      # the usual clients do not show the error of a service
                raise rospy.ServiceException(str(error)) from None
            before, after = values_of(self._parameters), values_of(wanted)
            self._parameters = wanted
            self._updates.publish(encode(after))
            for name in (name for name in LIVE if after[name] != before[name]):
                rospy.loginfo("~%s: %s -> %s", name, before[name], after[name])
                self._keep(name, after[name])
        return ReconfigureResponse(encode(after))

    def _keep(self, name: str, value: Any) -> None:
        """Write a value to the parameter server, for the next start. When this fails, only log it.

        The new value has been put into effect already.
        """
        try:
            rospy.set_param("~" + name, value)
        except OSError as error:
            rospy.logwarn("~%s is %s until this driver ends; the parameter server does not keep it: %s", name, value,
                          error)

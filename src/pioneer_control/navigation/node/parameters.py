"""The private parameters of the navigation node: their defaults, legal values and meanings. No ROS.

The tuned numbers of `tuned` are parameters too, each below the name of its part: ``~localisation/particles``.
"""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict, Mapping, NamedTuple, Optional, Tuple

from ...errors import ParameterError
from ...floor_poses import Pose
from ...maps.goals_file import ENDING
from ...parameters import Choice, Number, Numbers, Switch, Text, Whole, check, parameter
from ..tuned import NavigationNumbers


class PlaceOrNothing(NamedTuple):
    """Checks a parameter that is a pose (m, m, rad). An empty text means none."""

    legal: str = "three numbers, as a list: x, y, heading; or an empty text for none"

    def accept(self, value: Any) -> Optional[Pose]:
        """Return the pose, or None for an empty text. Raise ValueError if the value is neither."""
        if isinstance(value, str) and not value.strip():
            return None
        x, y, heading = Numbers(3, -1e6, 1e6).accept(value)
        return Pose(x, y, heading)


@dataclass(frozen=True)
class NavigationParameters:
    """The private parameters of the navigation node."""

    map: str = parameter("", Text(empty=True), "file of the map (map_server's .yaml, ARIA's .map), or name of a world;"
                                               " empty: the robot makes a map")
    save_to: str = parameter("", Text(empty=True), "file (.yaml) in which a map that is made is saved at the end")
    start: str = parameter("unknown", Choice(("home", "unknown")),
                           "home: the robot begins where the map has its start; unknown: it finds out where it is")
    initial_pose: Optional[Pose] = parameter(None, PlaceOrNothing(), "where the robot begins, if somebody knows",
                                             "m, m, rad")
    max_linear: float = parameter(0.4, Number(0.05, 0.75), "greatest speed to a goal", "m/s")
    max_angular: float = parameter(
        1.745, Number(0.1, 2.0), "greatest turn rate to a goal; while it makes a map 1.2 at most", "rad/s")
    use_laser: bool = parameter(True, Switch(), "use the scans of a laser, as soon as the topic scan has some")
    seed: int = parameter(0, Whole(0), "of what chance decides: particles are drawn")
    accept_replay: bool = parameter(False, Switch(), "obey goals that `rosbag play` publishes")
    global_frame_id: str = parameter("map", Text(slash=False), "frame of the map")
    odom_frame_id: str = parameter("odom", Text(slash=False), "frame of the robot's odometry")
    base_frame_id: str = parameter("base_link", Text(slash=False), "frame of the robot")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "put before the robot's frames")
    transform_tolerance: float = parameter(0.2, Number(0.0, 2.0), "how far ahead tf map -> odom is stamped",
                                           "s")

    @property
    def odom_frame(self) -> str:
        """The full name of the odom frame, with the prefix."""
        return self.frame_prefix + self.odom_frame_id

    @property
    def base_frame(self) -> str:
        """The full name of the frame of the robot, with the prefix."""
        return self.frame_prefix + self.base_frame_id


def check_parameters(given: Mapping[str, Any]) -> Tuple[NavigationParameters, NavigationNumbers]:
    """Check the private parameters of the node.

    Args:
        given: names and values from the parameter server.

    Returns:
        The parameters, and the tuned numbers.

    Raises:
        ParameterError: a value is not legal, or a name is unknown. The message names it, and what there is.
    """
    tuned: Dict[str, Any] = {}
    parts = {part: type(table) for part, table in NavigationNumbers()._asdict().items()}
    for part, table in parts.items():
        numbers = given.get(part, {})
        if not isinstance(numbers, Mapping):
            raise ParameterError("~%s is %r: it must have numbers below it, such as ~%s/%s"
                                 % (part, numbers, part, fields(table)[0].name))
        try:
            tuned[part], unknown = check(table, numbers)
        except ParameterError as error:
            raise ParameterError(str(error).replace("~", "~%s/" % part)) from None
        if unknown:
            raise ParameterError("unknown parameter ~%s/%s: there are %s" % (
                part, unknown[0], ", ".join(entry.name for entry in fields(table))))
    own = {name: value for name, value in given.items() if name not in parts}
    parameters, unknown = check(NavigationParameters, own)
    if unknown:
        known = ", ~".join([entry.name for entry in fields(NavigationParameters)] + list(parts))
        raise ParameterError("unknown parameter ~%s: there are ~%s" % (", ~".join(unknown), known))
    frames = parameters.global_frame_id, parameters.odom_frame, parameters.base_frame
    if len(set(frames)) < len(frames):
        raise ParameterError("~global_frame_id, ~odom_frame_id and ~base_frame_id, with ~frame_prefix, are %r, %r and"
                             " %r: they must differ" % frames)
    if parameters.map and parameters.save_to:
        raise ParameterError("~save_to is %r: a map is saved where one is made, without ~map" % parameters.save_to)
    if parameters.save_to and (Path(parameters.save_to).suffix != ".yaml" or parameters.save_to.endswith(ENDING)):
        raise ParameterError("~save_to is %r: the name of the file must end in .yaml, but not in %s"
                             % (parameters.save_to, ENDING))
    return parameters, NavigationNumbers(**tuned)

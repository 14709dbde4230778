"""The private parameters of the simulator's ROS node: their defaults, legal values and meanings.

This file uses no ROS.
"""

from dataclasses import dataclass, fields
from typing import Any, Mapping, NamedTuple, Optional, Union

from ..errors import ParameterError
from ..parameters import AutoSwitch, Choice, Number, Numbers, Switch, Text, Whole, check, parameter
from .hardware.arm import KINDS_OF_ARMS
from .line.cameras import AUX_OF_CAMERAS, CAMERA_CABLINGS, KINDS_OF_CAMERAS
from .line.lasers import KINDS_OF_LASERS
from .line.pace import SPEEDS
from .simulation import MOST_ROBOTS, RANDOM
from .world.poses import Pose


class TcpAddress(NamedTuple):
    """Checks a parameter that is a TCP address: a port number or ``"host:port"``. An empty text means no TCP port."""

    legal: str = "a port (0 for any free one), host:port, or an empty text for none"

    def accept(self, value: Any) -> Union[int, str, None]:
        """Return the value, or None for an empty text. Raise ValueError if the value is neither int nor str."""
        if isinstance(value, bool) or not isinstance(value, (int, str)):
            raise ValueError
        return None if value == "" else value


class Place(NamedTuple):
    """Checks a parameter that is a pose in the world (m, m, rad), as a list or as text. ``random`` is a random pose, an
    empty text the world's own start.
    """

    legal: str = "three numbers, as a list: x, y, heading; or random; or an empty text for the world's own"

    def accept(self, value: Any) -> Union[Pose, str, None]:
        """Return the pose, RANDOM, or None for an empty text. Raise ValueError if the value is none of them."""
        if isinstance(value, str):
            if value.strip() in ("", RANDOM):
                return value.strip() or None
            value = [float(word) for word in value.strip("[] ").split(",")]
        x, y, heading = Numbers(3, -1e6, 1e6).accept(value)
        return x, y, heading


@dataclass(frozen=True)
class SimulatorParameters:
    """The private parameters of the simulator's ROS node."""

    model: str = parameter("p3dx-sh", Text(), "robot model, by its subtype")
    world: str = parameter("tutorial", Text(), "name of a world, or path of a world file")
    start: Union[Pose, str, None] = parameter(
        None, Place(), "where the first robot stands at first; random: where all stand", "m, m, rad")
    unmapped: int = parameter(0, Whole(0, 100), "number of obstacles to add that are on no map, by the seed")
    walkers: int = parameter(0, Whole(0, 100), "number of people to add who walk about, by the seed")
    robots: int = parameter(1, Whole(1, MOST_ROBOTS), "number of robots in the world")
    tcp: Union[int, str, None] = parameter(None, TcpAddress(),
                                           "TCP port of the first robot; the other robots have the next ports")
    pty: str = parameter("", Text(empty=True),
                         "path of a link to a pseudo-terminal; several robots have their numbers behind the path;"
                         " empty for none")
    laser: str = parameter("none", Choice(("none", *KINDS_OF_LASERS)), "laser on each robot: lms200, on a line of its"
                           " own; line, over the robot's own line")
    laser_port: Union[int, str, None] = parameter(
        None, TcpAddress(), "TCP port of the first robot's laser; the others have the next ports; empty: the first port"
        " after those of the robots, or 8102")
    laser_pty: str = parameter("", Text(empty=True), "path of a link to a pseudo-terminal of the laser, instead of TCP;"
                               " empty for none")
    camera: str = parameter("none", Choice(("none", *KINDS_OF_CAMERAS)), "camera that turns on each robot, at an"
                            " auxiliary port of it")
    camera_aux: int = parameter(AUX_OF_CAMERAS, Choice((1, 2, 3)), "which auxiliary port")
    camera_cabling: str = parameter(CAMERA_CABLINGS[0], Choice(CAMERA_CABLINGS), "one_way: no answer of the camera"
                                    " arrives, as on many robots")
    camera_port: Union[int, str, None] = parameter(
        None, TcpAddress(), "TCP port for the first robot's camera, instead of an auxiliary port; the others have the"
        " next ports; empty for none")
    camera_pty: str = parameter("", Text(empty=True), "path of a link to a pseudo-terminal of the camera, instead of"
                                " that; empty for none")
    seed: int = parameter(0, Whole(), "random seed of sonar noise, wheel slip and damaged packets")
    speed: float = parameter(1.0, Number(*SPEEDS),
                             "simulated seconds per real second; if not 1, the node publishes /clock")
    fault: str = parameter("", Text(empty=True), "faults as text, with semicolons between them")
    faults_file: str = parameter("", Text(empty=True), "a YAML list of faults; empty for none")
    record: str = parameter("", Text(empty=True), "file for a record of the lines; empty for none")
    gripper: Optional[bool] = parameter(None, AutoSwitch(), "is a gripper fitted? auto: as usual for the model")
    arm: str = parameter("none", Choice(("none", *KINDS_OF_ARMS)), "arm on each robot, at the auxiliary port arm.aux of"
                         " robot.yaml")
    rear_sonar: bool = parameter(True, Switch(), "whether the rear sonar array is fitted")
    name: str = parameter("sim_0001", Text(), "name of the robot; several robots are sim_0001, sim_0002, ...")
    serial: str = parameter("", Text(empty=True), "serial number that the robots tell; SIM, with laser line: clients"
                            " that know simulators by it take that laser; empty: that of robot.yaml")
    models_file: str = parameter("", Text(empty=True),
                                 "a models file that overrides or adds robot models; empty for none")
    real: bool = parameter(False, Switch(), "whether wheels and sonar err as those of real robots, by the seed")
    numbers_file: str = parameter("", Text(empty=True), "a file that overrides numbers of robot.yaml; empty for none")
    map_frame: str = parameter("map", Text(slash=False), "frame of the world")
    map_tf: bool = parameter(True, Switch(), "publish tf from map_frame to odom; if not, to truth/base_link instead,"
                                             " so that another node may say where odom is")
    odom_frame_id: str = parameter("odom", Text(slash=False), "frame of the robot's odometry")
    base_link_frame_id: str = parameter("base_link", Text(slash=False), "frame of the robot")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "prefix of the robots' frames")


def check_parameters(given: Mapping[str, Any]) -> SimulatorParameters:
    """Check the parameters that a user has given, and return all parameters. Those not given have their defaults.

    Raises:
        ParameterError: a value is not legal, or a name is unknown.
    """
    parameters: SimulatorParameters
    parameters, unknown = check(SimulatorParameters, given)
    if unknown:
        known = ", ~".join(entry.name for entry in fields(SimulatorParameters))
        raise ParameterError("unknown parameter ~%s: there are ~%s" % (", ~".join(unknown), known))
    return parameters

"""Everything that can be set on the driver, in one table: a field is a private parameter of the node, with its default, what is
legal, its unit and what it does.
"""

from dataclasses import dataclass
from typing import Any, List, Mapping, Optional, Tuple

from ..parameters import AutoSwitch, Choice, Number, Switch, Text, check, parameter

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)

WITHOUT_EFFECT = {
    **dict.fromkeys((
        "bumpstall rot_kp rot_kv rot_ki trans_kp trans_kv trans_ki max_xaccel max_xdecel max_yawaccel max_yawdecel").split(),
        "it is known from p2os, but not supported yet"),
    **dict.fromkeys("use_tcp tcp_remote_host tcp_remote_port".split(), "give the address as the port: port:=socket://host:8101"),
    **dict.fromkeys("radio joystick direct_wheel_vel_control".split(), "it never had one in p2os either"),
}
"""Parameters of p2os that do nothing here, and what to say of them: named in a warning, never read."""


@dataclass(frozen=True)
class DriverParameters:
    """The driver's private parameters, checked. Names known from p2os are kept."""

    port: str = parameter("/dev/ttyUSB0", Text(), "serial device, or socket://host:port")
    baud: int = parameter(9600, Choice(BAUD_RATES), "line speed tried first, the others follow", "baud")
    model: str = parameter("", Text(empty=True), "robot model to assume; empty: what the robot says it is")
    models_file: str = parameter("", Text(empty=True), "file with your own calibration of models; empty: none")
    gripper: Optional[bool] = parameter(None, AutoSwitch(), "is a gripper fitted? auto: what the robot says")
    pulse: float = parameter(1.0, Number(-1.0, 1.5), "time between signs of life to the robot; 0 or less: none", "s")
    use_sonar: bool = parameter(True, Switch(), "sonar on; false: off, and no sonar topic is fed")
    max_xspeed: float = parameter(0.5, Number(0.01, 3.0), "no forward or backward command goes beyond", "m/s")
    max_yawspeed: float = parameter(1.745, Number(0.02, 6.3), "no turn goes beyond", "rad/s")
    cmd_vel_timeout: float = parameter(0.6, Number(0.1, 2.0), "a velocity older than this means stop", "s")
    accept_replay: bool = parameter(False, Switch(), "obey commands that `rosbag play` publishes")
    odom_frame_id: str = parameter("odom", Text(slash=False), "frame of the pose")
    base_link_frame_id: str = parameter("base_link", Text(slash=False), "frame of the robot")
    frame_prefix: str = parameter("", Text(empty=True, slash=False), "put before every frame name, e.g. robot2/")
    publish_tf: bool = parameter(True, Switch(), "publish the transform odom -> base_link")

    @property
    def odom_frame(self) -> str:
        """The odometry frame, prefix included."""
        return self.frame_prefix + self.odom_frame_id

    @property
    def base_link_frame(self) -> str:
        """The robot's frame, prefix included."""
        return self.frame_prefix + self.base_link_frame_id


def check_parameters(given: Mapping[str, Any]) -> Tuple[DriverParameters, List[str]]:
    """What the parameter server holds -> (parameters, warnings about names that have no effect).

    Raises ParameterError, as `parameters.check` does.
    """
    parameters, unknown = check(DriverParameters, {name: given[name] for name in given if name not in WITHOUT_EFFECT})
    foreign = {name: WITHOUT_EFFECT[name] for name in sorted(given) if name in WITHOUT_EFFECT}
    foreign.update(dict.fromkeys(unknown, "it is not a parameter of this driver"))
    return parameters, [f"~{name} has no effect: {why}" for name, why in foreign.items()]

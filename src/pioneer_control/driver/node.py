"""The driver node: a robot on a port, offered to ROS. All names are relative to the node's namespace (`pioneer` in pioneer.launch).

*Publishes*, once per packet of the robot (10 Hz), all with one stamp:

=================  ==============================  ==========================================================================
``pose``           nav_msgs/Odometry               odometry: pose in the odometry frame, twist in base_link
``sonar``          pioneer_control/SonarArray      m by sonar number; 5.0 no echo, 0.0 not heard for 2 s; while sonar is on
``gripper_state``  pioneer_control/GripperState    paddles, lift, beams, contacts; only when a gripper is fitted
``motor_state``    pioneer_control/MotorState      1 motors on, 0 off
``battery_state``  pioneer_control/BatteryState    V
``dio``, ``aio``   pioneer_control/DIO, AIO        user inputs, the selected analog input (V)
``robot_info``     pioneer_control/RobotInfo       latched, once per connection: what the robot is, has and measures
``/tf``                                            odometry frame -> base_link
=================  ==============================  ==========================================================================

*Subscribes*

===================  ============================  ==========================================================================
``cmd_vel``          geometry_msgs/Twist           linear.x (m/s) and angular.z (rad/s); goes stale after cmd_vel_timeout
``cmd_motor_state``  pioneer_control/MotorState    1 motors on, 0 off
``gripper_control``  pioneer_control/GripperState  grip.state 1 open, 2 close, 3 stop; lift.state 4 up, 5 down, 6 stop; 0 neither
===================  ============================  ==========================================================================

*Service* ``set_motors`` (std_srvs/SetBool): waits until the robot confirms, or says why it does not.

*Parameters* (private; legal ranges in `parameters.py`)

===========================  =======  =======  ============================  ========================================================================
name                         type     unit     default                       meaning
===========================  =======  =======  ============================  ========================================================================
``port``                     text              /dev/ttyUSB0                  serial device, or socket://host:port
``baud``                     integer  baud     9600                          line speed tried first, the others follow
``host_baud``                integer  baud     0                             line speed to change to once connected; 0: none
``model``                    text                                            robot model to assume; empty: what the robot says it is
``models_file``              text                                            file with your own calibration of models; empty: none
``gripper``                  text              auto                          is a gripper fitted? auto: what the robot says
``beam_polarity``            integer           1                             what the gripper's beams read when something breaks them
``pulse``                    number   s        1.0                           time between signs of life to the robot; 0 or less: none
``use_sonar``                bool              true                          sonar on; false: off, and no sonar topic is fed
``max_xspeed``               number   m/s      0.5                           no forward or backward command goes beyond
``max_yawspeed``             number   rad/s    1.745                         no turn goes beyond
``cmd_vel_timeout``          number   s        0.6                           a velocity older than this means stop
``max_xaccel``               number   m/s^2    0.0                           acceleration; 0: the robot's own
``max_xdecel``               number   m/s^2    0.0                           deceleration, with any sign; 0: the robot's own
``max_yawaccel``             number   rad/s^2  0.0                           acceleration of turns; 0: the robot's own
``max_yawdecel``             number   rad/s^2  0.0                           deceleration of turns, with any sign; 0: the robot's own
``rot_kp``                   integer           -1                            rotation PID, proportional; -1: the robot's own
``rot_kv``                   integer           -1                            rotation PID, derivative; -1: the robot's own
``rot_ki``                   integer           -1                            rotation PID, integral; -1: the robot's own
``trans_kp``                 integer           -1                            translation PID, proportional; -1: the robot's own
``trans_kv``                 integer           -1                            translation PID, derivative; -1: the robot's own
``trans_ki``                 integer           -1                            translation PID, integral; -1: the robot's own
``bumpstall``                integer           -1                            bumpers that stall: 0 none, 1 front, 2 rear, 3 both; -1: the robot's own
``ticks_mm``                 integer  1/mm     0                             calibration TicksMM; 0: the robot's own
``drift_factor``             integer           -32768                        calibration DriftFactor; -32768: the robot's own
``rev_count``                integer  1/turn   0                             calibration RevCount; 0: the robot's own
``enable_motors_on_start``   bool              false                         motors on when the robot is found for the first time, with nobody asking
``accept_replay``            bool              false                         obey commands that `rosbag play` publishes
``odom_frame_id``            text              odom                          frame of the pose
``base_link_frame_id``       text              base_link                     frame of the robot
``frame_prefix``             text                                            put before every frame name, e.g. robot2/
``publish_tf``               bool              true                          publish the transform odom -> base_link
``sonar_no_echo``            text              inf                           range in sonar_ranges when nothing is in sight: inf or max
``pose_covariance_moving``   list              0.001 0.001 1e6 1e6 1e6 0.01  of pose, while the robot moves
``pose_covariance_still``    list              0.001 0.001 1e6 1e6 1e6 0.01  of pose, while it stands
``twist_covariance_moving``  list              0.001 0.001 1e6 1e6 1e6 0.01  of twist, while the robot moves
``twist_covariance_still``   list              1e-6 1e-6 1e6 1e6 1e6 1e-6    of twist, while it stands
===========================  =======  =======  ============================  ========================================================================

Commands that `rosbag play` publishes are refused unless ``accept_replay`` is set. Motors are never switched on unless somebody asks. Every way
out stops the robot, switches its motors off and ends the session. All safety timers run in the client, on monotonic time.
"""

import sys
from time import monotonic

import rospy

from ..client import BaudFound, CommandTimedOut, LinkDown, MotionCleared, Ready, Robot, RobotState
from ..errors import ParameterError, PioneerError, PortError
from ..ros_node import init_node
from .notices import Notice, Throttle, Watch
from .parameters import DriverParameters, check_parameters
from .publications import Publications
from .requests import Requests

START_GRACE = 3.0
"""Seconds from the start in which a port that is not there yet is no news: a simulated robot starts beside its driver."""


class DriverNode:
    """Joins one Robot with the topics and the service. Call `run`."""

    def __init__(self, parameters: DriverParameters) -> None:
        self._parameters = parameters
        self._throttle = Throttle()
        self._watch = Watch(parameters.cmd_vel_timeout, "rosservice call %s true" % rospy.resolve_name("set_motors"))
        self._asked_to_end = False
        self._started = monotonic()
        self._publications = Publications(parameters)
        self._robot = Robot(
            parameters.port,
            baud=parameters.baud,
            model=parameters.model or None,
            models_file=parameters.models_file or None,
            pulse=max(0.0, parameters.pulse),
            use_sonar=parameters.use_sonar,
            command_timeout=parameters.cmd_vel_timeout,
            max_linear=parameters.max_xspeed,
            max_angular=parameters.max_yawspeed,
            has_gripper=parameters.gripper,
            reconnect=True,
            on_state=self._on_state,
            on_event=self._on_event,
        )
        self._requests = Requests(parameters, self._robot, self._watch, self._warn)

    def run(self) -> int:
        """Drive until ROS shuts down. Returns the exit code: 0, or 1 when the robot cannot be driven at all."""
        rospy.on_shutdown(self._end)
        rospy.loginfo("looking for a robot on %s", self._parameters.port)
        try:
            self._robot.start().wait_until_ended()
        finally:
            self._robot.close()
        link = self._robot.link
        rospy.loginfo("closed after %d packets, %d with a bad checksum, %d stray bytes, %d reconnects",
                      link.sips, link.bad_checksums, link.discarded_bytes, link.reconnects)
        return 0 if self._asked_to_end else 1

    def _end(self) -> None:
        """ROS shuts down (a signal, rosnode kill): stop first, whatever thread this is."""
        self._asked_to_end = True
        self._robot.close()

    # From the robot, on the client's I/O thread.

    def _on_state(self, state: RobotState) -> None:
        self._publications.state(state)
        self._warn(self._watch.state(state))

    def _on_event(self, event) -> None:
        if isinstance(event, Ready):
            self._welcome(event.identity)
        elif isinstance(event, LinkDown):
            self._link_down(event)
        elif isinstance(event, MotionCleared):
            rospy.logwarn("the robot stopped: %s; it stands until a new command", event.reason)
        elif isinstance(event, CommandTimedOut):
            self._warn([Notice("timed out", "the robot was stopped: no velocity came for %.1f s (cmd_vel_timeout)" % event.age)])
        elif isinstance(event, BaudFound):
            rospy.loginfo("the robot answers at %d baud; set the parameter baud to it for a faster start", event.baud)

    def _welcome(self, identity) -> None:
        self._watch.identified(identity)
        self._publications.identity(identity)
        rospy.loginfo(
            "connected to %s, a %s%s, %d sonar transducers, %s; motors are off",
            identity.name,
            identity.model.subtype,
            " with firmware %s" % identity.firmware if identity.firmware else "",
            len(identity.model.sonar),
            "with gripper" if identity.has_gripper else "no gripper",
        )

    def _link_down(self, event: LinkDown) -> None:
        if event.retry_in < 0:
            rospy.logfatal("%s", event.error)
        elif isinstance(event.error, PortError) and monotonic() - self._started < START_GRACE:
            rospy.logdebug("%s (trying again)", event.error)
        elif self._throttle.passes("link: %s" % event.error, monotonic()):
            rospy.logerr("%s (trying again until it works)", event.error)

    def _warn(self, notices) -> None:
        now = monotonic()
        for kind, text in notices:
            if self._throttle.passes(kind, now):
                rospy.logwarn("%s", text)


def main() -> int:
    """Run the node. Returns the exit code: 0 shut down, 1 the robot cannot be driven, 2 a parameter makes no sense."""
    init_node("p2os")
    try:
        parameters, warnings = check_parameters(rospy.get_param("~", {}))
        for warning in warnings:
            rospy.logwarn("%s", warning)
        node = DriverNode(parameters)
    except ParameterError as error:
        rospy.logfatal("%s (What an earlier start was given stays until: rosparam delete %s)", error, rospy.get_name())
        return 2
    except PioneerError as error:
        rospy.logfatal("%s", error)
        return 2
    return node.run()


if __name__ == "__main__":
    sys.exit(main())

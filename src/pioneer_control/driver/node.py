"""The driver node: a robot on a port, offered to ROS. All names are relative to the node's namespace (`pioneer` in pioneer.launch).

*Publishes*, once per packet of the robot (10 Hz), all with one stamp: when the robot sent it. What nobody listens to is not made, and a topic that
this robot cannot feed is not there.

=================  ============================  ==========================================================================================
``pose``           nav_msgs/Odometry             odometry: pose in the odometry frame, twist in base_link
``/tf``            tf2_msgs/TFMessage            odometry frame -> base_link, unless publish_tf is false
``sonar``          pioneer_control/SonarArray    m by sonar number; 5.0 no echo, 0.0 not heard for 2 s; while sonar is on
``sonar_ranges``   sensor_msgs/Range             one for each transducer that this packet brought; nothing in sight is +inf (sonar_no_echo)
``sonar_points``   sensor_msgs/PointCloud2       the newest echo of every transducer, in base_link as it stands now
``/tf_static``     tf2_msgs/TFMessage            latched: base_link -> sonar_0, sonar_1, ..., each x along its transducer's axis
``joint_states``   sensor_msgs/JointState        wheels: rad, rad/s; where the model's wheel radius is known
``motor_state``    pioneer_control/MotorState    1 motors on, 0 off
``e_stop``         std_msgs/Bool                 latched, on change: the STOP button is pressed
``stall``          pioneer_control/Stall         left, right wheel stalled
``bumpers``        pioneer_control/Bumpers       segments pressed; only of a robot with bumpers
``battery_state``  pioneer_control/BatteryState  V
``battery``        sensor_msgs/BatteryState      V, what the charger does, state of charge where the robot reports it, else NaN
``gripper_state``  pioneer_control/GripperState  paddles, lift, beams, contacts; only when a gripper is fitted
``dio``            pioneer_control/DIO           user inputs
``aio``            pioneer_control/AIO           the selected analog input (V)
``io``             pioneer_control/IO            every port, asked of the robot while somebody listens
``imu``            sensor_msgs/Imu               turn rate (rad/s) of a gyro that is not the robot's own business, asked for likewise
``compass``        sensor_msgs/Imu               heading as orientation: magnetic east is 0, counter-clockwise; once a compass has spoken
``robot_info``     pioneer_control/RobotInfo     latched, once per connection: what the robot is, has and measures
=================  ============================  ==========================================================================================

... and ``/diagnostics`` (diagnostic_msgs/DiagnosticArray), once a second of real time and when a level changes: Link, Battery, Motors, Stall,
Bumpers, Temperature; `health.py` says when each is what, ``launch/diagnostics.launch`` gathers them.

*Subscribes*

===================  ===============================  =======================================================================
``cmd_vel``          geometry_msgs/Twist              linear.x (m/s) and angular.z (rad/s); goes stale after cmd_vel_timeout
``cmd_wheels``       pioneer_control/WheelVelocities  m/s of each side, likewise; of cmd_vel and this, the last one counts
``cmd_motor_state``  pioneer_control/MotorState       1 motors on, 0 off
``gripper_control``  pioneer_control/GripperState     commands by number, see below; 0 leaves that part alone
===================  ===============================  =======================================================================

``gripper_control``: grip.state 1 open, 2 close, 3 stop; lift.state 4 up, 5 down, 6 stop; grip.state 7 store, 8 deploy, 15 halt move both, lift.state 0.
Times travel in ``dir``, which p2os ignores: grip.state 16 sets how long closing paddles go on squeezing (grip.dir 1..100, in 20 ms), lift.state 17
moves the lift for so long (lift.dir 1..255 up, -1..-255 down, in 20 ms).

*Services*: each waits until the robot shows it, or says why not (STOP button, stalled, no link, not confirmed in time)

==================  ================  ====================================================================================
``set_motors``      std_srvs/SetBool  motors on or off
``enable_motors``   std_srvs/Empty    on, as ROSARIA has it: why not is the text of the service's error
``disable_motors``  std_srvs/Empty    off
``set_sonar``       std_srvs/SetBool  sonar on or off
``reset_odometry``  std_srvs/Trigger  the next pose is 0, 0, 0
==================  ================  ====================================================================================

*dynamic_reconfigure*: limits, ramps, PID, bumpstall, calibration and cmd_vel_timeout change while the driver runs, within the ranges of `parameters.py`;
what is out of range is refused. What the robot made of it is said in the log, old -> new. Its own value comes back with a new start of the driver.

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

Commands that `rosbag play` publishes are refused unless ``accept_replay`` is set. Motors are never switched on unless somebody asks, be it
by ``enable_motors_on_start``, which counts once, for the first connection: never after a reconnect. Every way
out stops the robot, switches its motors off and ends the session. All safety timers run in the client, on monotonic time.
"""

import sys
from time import monotonic

import rospy

from ..client import BaudFound, CommandTimedOut, LinkDown, MotionCleared, PacketReceived, Ready, Robot, RobotState, Tuned
from ..errors import ParameterError, PioneerError, PortError
from ..ros_node import init_node
from .diagnostics import Diagnostics
from .notices import Notice, Throttle, Watch
from .parameters import TUNING, DriverParameters, check_parameters
from .publications import Publications
from .reconfigure import Reconfiguration
from .requests import Requests

START_GRACE = 3.0
"""Seconds from the start in which a port that is not there yet is no news: a simulated robot starts beside its driver."""


class DriverNode:
    """Joins one Robot with the topics and the service. Call `run`."""

    def __init__(self, parameters: DriverParameters) -> None:
        self._parameters = parameters
        self._throttle = Throttle()
        how_to_enable = "rosservice call %s true" % rospy.resolve_name("set_motors")
        self._watch = Watch(parameters.cmd_vel_timeout, how_to_enable)
        self._diagnostics = Diagnostics(parameters.port, parameters.baud, how_to_enable, lambda: self._robot.link)
        self._asked_to_end = False
        self._started = monotonic()
        self._publications = Publications(parameters, lambda kind, on: self._robot.request_data(kind, on))
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
            tuning=parameters.tuning,
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
            self._robot.start()
            self._diagnostics.start()
            Reconfiguration(self._parameters, self._reconfigure)
            self._robot.wait_until_ended()
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
        self._diagnostics.stop()

    def _reconfigure(self, parameters: DriverParameters) -> None:
        """Other values of what may change while the driver runs."""
        self._robot.set_limits(parameters.max_xspeed, parameters.max_yawspeed, parameters.cmd_vel_timeout)
        self._robot.tune(parameters.tuning)
        self._watch.cmd_vel_timeout = parameters.cmd_vel_timeout

    # From the robot, on the client's I/O thread.

    def _on_state(self, state: RobotState) -> None:
        self._publications.state(state)
        self._diagnostics.state(state)
        self._warn(self._watch.state(state))

    def _on_event(self, event) -> None:
        self._diagnostics.event(event)
        if isinstance(event, Ready):
            self._welcome(event.identity)
        elif isinstance(event, LinkDown):
            self._link_down(event)
        elif isinstance(event, MotionCleared):
            rospy.logwarn("the robot stopped: %s; it stands until a new command", event.reason)
        elif isinstance(event, CommandTimedOut):
            self._warn([Notice("timed out", "the robot was stopped: no velocity came for %.1f s (cmd_vel_timeout)" % event.age)])
        elif isinstance(event, PacketReceived):
            self._publications.packet(event)
        elif isinstance(event, Tuned):
            self._tuned(event)
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
        self._requests.connected()

    def _tuned(self, event: Tuned) -> None:
        names = {name: ours for ours, name in TUNING.items()}
        for change in event.changes:
            (rospy.logwarn if change.problem else rospy.loginfo)("~%s", change._replace(name=names[change.name]))
        self._publications.identity(event.identity)

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

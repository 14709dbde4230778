"""Publishes what the robot reports. One table describes all topics. Any thread may call the methods."""

import math
import threading
from time import monotonic, sleep, time
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Set, Tuple

import rospy
from nav_msgs.msg import Odometry
from rospy.rostime import is_wallclock
from sensor_msgs.msg import BatteryState as Battery
from sensor_msgs.msg import Imu, JointState, Joy, PointCloud2, Range
from std_msgs.msg import Bool, Header
from tf2_msgs.msg import TFMessage

from .. import p2os, standard_messages
from ..client import Event, PacketReceived, Ready, RobotIdentity, RobotState, Tuned
from ..client.gripper import is_on_general_io, with_switches
from ..client.gyro import GyroReader, is_for_client
from ..message_values import NO_ECHO
from ..msg import (AIO, DIO, IO, BatteryState, Bumpers, Calibration, Encoders, GripperState, MotorState, RobotInfo,
                   SonarArray, Stall)
from ..robots import RobotModel
from . import conversions
from .parameters import DriverParameters
from .prompt import POSE_AHEAD, PoseMessage, SonarMessage, TransformMessage, converter, publish

QUEUE = 10
CLOSE_TIMEOUT = 0.1
"""The longest time (s) that `Publications.close` waits until another thread has finished publishing."""


class PublishedTopic(NamedTuple):
    """One row of the table of topics: how to make and publish the messages of one topic."""

    name: str
    message: type
    source: type
    """The type of the object from which a message is made: RobotState, RobotIdentity, or a packet class of p2os."""
    convert: Callable[[Any, rospy.Time], Any]
    """Make a message, or a list of messages, from the source object and its stamp. None: publish nothing."""
    available_if: Optional[Callable[[RobotIdentity], Any]] = None
    """Whether a robot has the data for this topic. If not, the topic is not advertised.

    With None in place of a function, the topic is advertised for every robot, also before the first connection.
    """
    asks: Optional[Callable[[RobotIdentity], str]] = None
    """The kind of packets (client.data_requests.DATA) to request from the robot while the topic has a subscriber.

    Empty text: this robot sends the data without a request. None in place of a function: every robot does.
    """
    latch: Optional[Callable[[Any], Any]] = None
    """For a latched topic: a function that returns the part of the source object that the message shows.

    The topic is published whenever this part changes, also without a subscriber. A topic that is not latched (None) is
    published with each source object while it has a subscriber.
    """
    ahead: float = 0.0
    """The time (s) to wait after this message, before the messages of the next topics are made."""


class Publications(rospy.SubscribeListener):
    """All publishers of the driver for the data of the robot.

    Args:
        parameters: the parameters of the driver.
        request_data: the method Robot.request_data, which switches one kind of packets on or off.
    """

    def __init__(self, parameters: DriverParameters, request_data: Callable[[str, bool], None]) -> None:
        self._request_data = request_data
        self._topics = self._table(parameters)
        self._publishers: Dict[str, rospy.Publisher] = {}
        # Whether a subscriber has come or gone. Checking all publishers again for each packet would take longer than
        # all other work for the packet.
        self._listeners_changed = True
        # The topics to publish now, by their source: latched topics, and topics that have a subscriber.
        self._wanted: Dict[type, List[PublishedTopic]] = {}
        self._latched: Dict[str, Any] = {}
        self._requested: Set[str] = set()
        self._identity: Optional[RobotIdentity] = None
        self._has_compass = False
        self._standing = False
        self._gripper = conversions.GripperReporter(parameters.beam_polarity)
        self._switches: Optional[p2os.GripperSwitches] = None
        self._gyro = GyroReader()
        self._stamp = rospy.Time()      # of the newest state
        self._lock = threading.Lock()
        self._advertise()

    def _table(self, parameters: DriverParameters) -> Tuple[PublishedTopic, ...]:
        odom, base, prefix = parameters.odom_frame, parameters.base_link_frame, parameters.frame_prefix
        no_echo = math.inf if parameters.sonar_no_echo == "inf" else NO_ECHO
        covariance = conversions.covariances(parameters)
        pose = converter(PoseMessage(odom, base, covariance), lambda state, stamp: conversions.odometry(
            state, stamp, odom, base, covariance[state.moving]))
        transform = converter(TransformMessage(odom, base), lambda state, stamp: conversions.transform(
            state, stamp, odom, base))
        sonar = converter(SonarMessage(base), lambda state, stamp: conversions.sonar(state, stamp, base))

        def header(stamp: rospy.Time) -> Header:
            return Header(stamp=stamp, frame_id=base)

        def has_sonar(identity: RobotIdentity) -> Any:
            return identity.model.sonar

        return (
            PublishedTopic("pose", Odometry, RobotState, pose, ahead=POSE_AHEAD),
            *([PublishedTopic("/tf", TFMessage, RobotState, transform)] if parameters.publish_tf else []),
            PublishedTopic(
                "sonar", SonarArray, RobotState,
                lambda state, stamp: sonar(state, stamp) if state.sonar_enabled else None, has_sonar),
            PublishedTopic(
                "sonar_ranges", Range, RobotState,
                lambda state, stamp: conversions.sonar_ranges(state, stamp, prefix, no_echo), has_sonar),
            PublishedTopic(
                "sonar_points", PointCloud2, RobotState,
                lambda state, stamp: conversions.sonar_points(state, stamp, base, self._model.sonar)
                if state.sonar_enabled else None, has_sonar),
            PublishedTopic(
                "/tf_static", TFMessage, RobotIdentity,
                lambda identity, stamp: standard_messages.sonar_frames(identity.model.sonar, stamp, base, prefix),
                has_sonar, latch=lambda identity: identity),
            PublishedTopic(
                "joint_states", JointState, RobotState,
                lambda state, stamp: conversions.joint_states(state, stamp, self._model.wheel_radius or math.inf),
                lambda identity: identity.model.wheel_radius),
            PublishedTopic(
                "motor_state", MotorState, RobotState, lambda state, stamp: MotorState(int(state.motors_enabled))),
            PublishedTopic(
                "e_stop", Bool, RobotState, lambda state, stamp: Bool(state.stop_button),
                latch=lambda state: state.stop_button),
            PublishedTopic(
                "stall", Stall, RobotState,
                lambda state, stamp: Stall(header(stamp), state.left_stall, state.right_stall)),
            PublishedTopic(
                "bumpers", Bumpers, RobotState,
                lambda state, stamp: Bumpers(header(stamp), list(state.front_bumpers), list(state.rear_bumpers)),
                lambda identity: identity.model.front_bumpers or identity.model.rear_bumpers),
            PublishedTopic(
                "battery_state", BatteryState, RobotState,
                lambda state, stamp: BatteryState(header(stamp), state.battery_voltage)),
            PublishedTopic(
                "battery", Battery, RobotState, lambda state, stamp: conversions.battery(state, stamp, base)),
            PublishedTopic(
                "gripper_state", GripperState, RobotState, lambda state, stamp: self._gripper_state(state),
                lambda identity: identity.has_gripper,
                lambda identity: "gripper" if is_on_general_io(identity) else ""),
            PublishedTopic(
                "dio", DIO, RobotState,
                lambda state, stamp: None if state.digital_in is None else DIO(8, state.digital_in)),
            PublishedTopic(
                "aio", AIO, RobotState,
                lambda state, stamp: None if state.analog_voltage is None else AIO(1, [state.analog_voltage])),
            PublishedTopic(
                "io", IO, p2os.IO, lambda packet, stamp: conversions.ports(packet, stamp, base),
                lambda identity: p2os.knows(identity.model.firmware_family, "IOREQUEST"), lambda identity: "io"),
            PublishedTopic(
                "encoders", Encoders, p2os.Encoder,
                lambda packet, stamp: Encoders(header(stamp), packet.left_ticks, packet.right_ticks),
                lambda identity: p2os.knows(identity.model.firmware_family, "ENCODER"), lambda identity: "encoder"),
            PublishedTopic(
                "joystick", Joy, p2os.Joystick, lambda packet, stamp: conversions.joystick(packet, stamp),
                lambda identity: p2os.knows(identity.model.firmware_family, "JOYREQUEST"), lambda identity: "joystick"),
            PublishedTopic(
                "imu", Imu, p2os.Gyro, lambda packet, stamp: self._imu(packet, stamp, base),
                is_for_client, lambda identity: "gyro"),
            PublishedTopic(
                "compass", Imu, RobotState,
                lambda state, stamp: None if state.compass is None else conversions.compass(state, stamp, base),
                lambda identity: self._has_compass),
            PublishedTopic(
                "robot_info", RobotInfo, RobotIdentity,
                lambda identity, stamp: conversions.robot_info(identity, stamp, base), latch=lambda identity: identity),
            PublishedTopic(
                "calibration", Calibration, RobotIdentity,
                lambda identity, stamp: conversions.calibration(identity, stamp),
                lambda identity: identity.config is not None, latch=conversions.calibration_numbers),
        )

    def state(self, state: RobotState) -> None:
        """Publish the messages that are made from a state. The client calls this once for each SIP.

        All these messages have the same stamp.
        """
        with self._lock:
            if state.compass is not None and not self._has_compass:     # no other packet tells that there is one
                self._has_compass = True
                self._advertise()
            if state.gripper is not None:
                self._gripper.saw(state.gripper)
            self._publish(RobotState, state, stamped(self._stamp, state.sent_time))
            self._standing = not state.moving

    def event(self, event: Event) -> None:
        """Publish the messages that are made from an event: from a new identity, or from a packet that is not a SIP."""
        if isinstance(event, (Ready, Tuned)):
            self.identity(event.identity)
        elif isinstance(event, PacketReceived):
            with self._lock:
                if isinstance(event.packet, p2os.Gripper):
                    self._switches = p2os.GripperSwitches(event.packet.state)
                self._publish(type(event.packet), event.packet, stamped(rospy.Time(), event.sent_time))

    def identity(self, identity: RobotIdentity) -> None:
        """Take the identity of the connected robot, advertise its topics, and publish what depends on the identity."""
        with self._lock:
            if self._identity is None or self._identity.name != identity.name:
                self._has_compass, self._switches, self._gyro = False, None, GyroReader(identity.model.gyro_factor)
            self._identity = identity
            self._advertise()
            self._publish(RobotIdentity, identity, rospy.Time.now())

    def close(self) -> None:
        """Publish nothing from now on. The driver calls this when ROS shuts down, because ROS closes the topics then.

        It waits at most CLOSE_TIMEOUT seconds for the lock: another thread may hold the lock while it waits for a ROS
        master that hangs.
        """
        locked = self._lock.acquire(timeout=CLOSE_TIMEOUT)
        self._topics, self._wanted = (), {}
        if locked:
            self._lock.release()

    def peer_subscribe(self, *_: Any) -> None:
        """Note that a subscriber has connected or disconnected. rospy calls this in one of its threads."""
        self._listeners_changed = True

    peer_unsubscribe = peer_subscribe

    def _publish(self, source: type, value: Any, stamp: rospy.Time) -> None:
        if self._listeners_changed:
            self._look_who_listens()
        for topic in self._wanted.get(source, ()):
            if topic.latch is not None:
                latched = topic.latch(value)
                if self._latched.get(topic.name) == latched:
                    continue
                self._latched[topic.name] = latched
            messages = topic.convert(value, stamp)
            if messages is not None:
                for message in messages if isinstance(messages, list) else (messages,):
                    publish(self._publishers[topic.name], message)
                if topic.ahead:
                    sleep(topic.ahead)

    def _advertise(self) -> None:
        """Advertise the topics for which the robot has data, and unregister all others."""
        for topic in self._topics:
            available_if, identity = topic.available_if, self._identity
            wanted = available_if is None or identity is not None and bool(available_if(identity))
            if wanted and topic.name not in self._publishers:
                self._publishers[topic.name] = rospy.Publisher(
                    topic.name, topic.message, self, tcp_nodelay=True, latch=topic.latch is not None,
                    queue_size=QUEUE)
            elif not wanted and topic.name in self._publishers:
                self._publishers.pop(topic.name).unregister()
                self._latched.pop(topic.name, None)
        self._listeners_changed = True

    def _look_who_listens(self) -> None:
        """Find the topics that must be published now, and request exactly the packets that these topics need."""
        self._listeners_changed = False     # first: a subscriber that connects during this method sets it again
        self._wanted = {}
        asked = set()
        for topic in self._topics:
            publisher = self._publishers.get(topic.name)
            if publisher is None:
                continue
            listened = publisher.get_num_connections() > 0
            if listened or topic.latch is not None:
                self._wanted.setdefault(topic.source, []).append(topic)
            if listened and topic.asks is not None and self._identity is not None:
                asked.add(topic.asks(self._identity))
        asked.discard("")
        for kind in asked ^ self._requested:
            self._request_data(kind, kind in asked)
        self._requested = asked

    # Conversions that need more than the packet. They are called only when the identity of the robot is known.

    @property
    def _model(self) -> RobotModel:
        assert self._identity is not None
        return self._identity.model

    def _gripper_state(self, state: RobotState) -> Optional[GripperState]:
        if state.gripper is None:
            return None
        reading = state.gripper if self._switches is None else with_switches(state.gripper, self._switches)
        return self._gripper.message(reading)

    def _imu(self, packet: p2os.Gyro, stamp: rospy.Time, base_link_frame: str) -> Optional[Imu]:
        rate = self._gyro.rate(packet, self._standing)
        return None if rate is None else conversions.turn_rate(rate, stamp, base_link_frame)


def stamped(stamp: rospy.Time, moment: float) -> rospy.Time:
    """Set ``stamp`` to the ROS time of a recent ``moment`` (monotonic, s), and return it.

    The stamp is zero before simulated time begins.
    """
    seconds = max(0.0, ros_time() - (monotonic() - moment))
    stamp.secs = int(seconds)
    stamp.nsecs = int((seconds - stamp.secs) * 1e9)
    return stamp


def ros_time() -> float:
    """Return the ROS time (s) as a float. This is faster than rospy.Time.now()."""
    return time() if is_wallclock() else rospy.get_time()

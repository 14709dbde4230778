"""The topics and services of a Pioneer Arm. Without the parameter `use_arm` there are none of them.

What the arm does, and when, is in `arm.session`. This file only says what is wished, and publishes what is known.
Positions are rad, with the signs of `arm.kinematics`; of the gripper m.
"""

import contextlib
from time import monotonic
from typing import Callable, Iterator, List, Optional, Tuple

import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory

from ..arm.findings import finding
from ..arm.joints import GRIPPER
from ..arm.motion import Point
from ..arm.orders import HOME_TIME, ArmOrder
from ..arm.phases import ArmSettings, Fitted
from ..arm.session import ArmSession
from ..client import RobotState
from ..client.health import Finding
from ..client.line_devices import LineDevice, LineDevices
from ..errors import NotConfirmedError, PioneerError, UsageError
from ..msg import Arm
from .publications import QUEUE, stamped
from .requests import OfferedService, Requests, SubscribedTopic, unless_locked

STOP_BUTTON = "STOP button"
"""The hold that is set while the robot's STOP button is pressed."""
ANSWER_TIME = HOME_TIME + 5.0
"""The longest time (s) that a service waits for the arm. Each order ends sooner by itself."""


class ArmTopics:
    """The topics, services and diagnostics of an arm.

    Args:
        settings: what the parameters say of the arm.
        locks: a function that returns the names of the locks that are set. Then nothing moves.

    Attributes:
        session: the arm, as a device on the robot's line.
    """

    def __init__(self, settings: ArmSettings, locks: Callable[[], Tuple[str, ...]]) -> None:
        self.session = ArmSession(settings)
        self._locks = locks
        self._pressed = False       # the STOP button
        self._published = 0         # the number of the status that was published last
        self._told: Optional[Arm] = None
        self._joint_states = rospy.Publisher("joint_states", JointState, queue_size=QUEUE)
        self._state = rospy.Publisher("arm/state", Arm, latch=True, queue_size=QUEUE)

    @property
    def line_devices(self) -> List[LineDevice]:
        """The arm: a device on the robot's line."""
        return [self.session]

    def start(self, devices: LineDevices, requests: Requests) -> None:
        """Begin: see `DeviceTopics.start`."""
        self._devices = devices
        requests.offer(self, ARM_TOPICS, ARM_SERVICES, self._halt)

    @property
    def acts_at_end(self) -> bool:
        """Whether the arm has to park at the end, which takes time."""
        arm = self.session.phase
        return isinstance(arm, Fitted) and (arm.status.powered or arm.comes_on)

    def finding(self) -> Finding:
        """Return the finding of the arm for the diagnostics."""
        return finding(self.session, monotonic())

    def end(self, timeout: float) -> None:
        """Do nothing: the arm has no line of its own."""

    # What is known.

    def changed(self) -> None:
        """Publish what is new, and tell people what happened. It returns soon: `LineDevices` calls it with its lock."""
        for notice in self.session.take_notices():
            (rospy.logwarn if notice.is_warning else rospy.loginfo)("%s", notice.text)
        with contextlib.suppress(rospy.ROSException):       # at the end the topics are closed
            self._publish()

    def _publish(self) -> None:
        arm = self.session.phase
        if isinstance(arm, Fitted) and self.session.statuses != self._published:
            self._published = self.session.statuses
            stamp = stamped(rospy.Time(), arm.heard)
            self._joint_states.publish(JointState(Header(stamp=stamp), list(arm.joints), [
                joint.value(arm.status.ticks[joint.number - 1]) for joint in arm.joints.values()], [], []))
        message = state_message(self.session)
        if message != self._told:
            self._told = message
            self._state.publish(state_message(self.session, rospy.Time.now()))

    def state(self, state: RobotState) -> None:
        """Take a state of the robot: while its STOP button is pressed, the arm stands."""
        if state.stop_button != self._pressed:
            self._pressed = state.stop_button
            with self._devices.using() as now:
                if state.stop_button:
                    self.session.hold(STOP_BUTTON, "the STOP button of the robot is pressed", now)
                else:
                    self.session.release(STOP_BUTTON)

    # What is wished. Each method raises PioneerError with the reason when it is not obeyed.

    def follow(self, topic: str, message: JointTrajectory, sender: str) -> None:
        """Obey arm_controller/command: a motion of joints; without points it is a stop."""
        if not message.points:
            self.stop()
            return
        points = [Point(point.positions, point.time_from_start.to_sec()) for point in message.points]
        with self._commanding(topic) as now:
            self.session.move(message.joint_names, points, now)

    def grip(self, topic: str, message: Float64, sender: str) -> None:
        """Obey arm_gripper/command: the opening between the fingers (m)."""
        with self._commanding(topic) as now:
            self.session.move([GRIPPER], [Point([message.data], 0.0)], now)

    def power(self, on: bool) -> str:
        """Switch the servo power on, or park, and wait for it. Return the text of the answer."""
        return self._obeyed("arm/power", self.session.power_on, "servo power is on") if on else self.park()

    def park(self) -> str:
        """Move the arm home, switch its servo power off, and wait for it. Return the text of the answer."""
        return self._obeyed("arm/park", self.session.park, "the arm is parked, without servo power")

    def home(self) -> str:
        """Move the arm home, and wait for it. Return the text of the answer."""
        return self._obeyed("arm/home", self.session.home, "the arm is home")

    def init(self) -> str:
        """Make a warm reset, and wait for it. Return the text of the answer."""
        return self._obeyed("arm/init", self.session.init, "the arm is connected")

    def stop(self) -> str:
        """Stop the arm. Return the text of the answer."""
        with self._devices.using() as now:
            self.session.stop(now)
        return "the arm was told to stop"

    def _obeyed(self, what: str, begin: Callable[[float], ArmOrder], done: str) -> str:
        """Begin an order, and wait until it is done. Return the text for that."""
        with self._commanding(what) as now:
            order = begin(now)
        self._devices.wait_until(lambda: not order.under_way, ANSWER_TIME)
        if order.problem is None:
            raise NotConfirmedError("%s is still under way" % what)
        if order.problem:
            raise NotConfirmedError("%s failed: %s" % (what, order.problem))
        return done

    @contextlib.contextmanager
    def _commanding(self, what: str) -> Iterator[float]:
        with unless_locked(self._devices.using, self._locks, what) as now:
            try:
                yield now
            except UsageError as error:
                raise UsageError("%s refused: %s" % (what, error)) from None

    def _halt(self) -> None:
        """Stop the arm, because a lock was set. Where there is none, nothing moves by us."""
        with contextlib.suppress(PioneerError):
            self.stop()


def state_message(session: ArmSession, stamp: rospy.Time = rospy.Time()) -> Arm:
    """Return the message that shows the state of an arm."""
    arm, header = session.phase, Header(stamp=stamp)
    if not isinstance(arm, Fitted):
        return Arm(header=header, condition=arm.condition, text=arm.text)
    joints = arm.joints.values()
    return Arm(header, arm.condition, arm.text, arm.status.powered, any(arm.status.moving), arm.version,
               arm.reader.layout or "", [joint.name for joint in joints], [joint.lower for joint in joints],
               [joint.upper for joint in joints], [joint.speed(joint.fastest_ms) for joint in joints])


ARM_TOPICS = (
    SubscribedTopic("arm_controller/command", JointTrajectory, QUEUE, ArmTopics.follow,
                    lambda motion: not motion.points),
    SubscribedTopic("arm_gripper/command", Float64, QUEUE, ArmTopics.grip, lambda _: False),
)

ARM_SERVICES = (
    OfferedService("arm/power", SetBool, lambda arm, request: arm.power(request.data)),
    OfferedService("arm/home", Trigger, lambda arm, _: arm.home()),
    OfferedService("arm/park", Trigger, lambda arm, _: arm.park()),
    OfferedService("arm/stop", Trigger, lambda arm, _: arm.stop()),
    OfferedService("arm/init", Trigger, lambda arm, _: arm.init()),
)

ARM_PUBLISHED = (("joint_states", JointState), ("arm/state", Arm))
"""The topics that it publishes, with their types."""

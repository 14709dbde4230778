"""The driver node: it connects to one robot, and offers the robot's data and commands as topics and services.

The names of topics and services are relative to the namespace of the node (`pioneer` in pioneer.launch).

The interface is in tables: published topics in `publications`, subscribed topics and services in `requests`, parameters
in `parameters`, diagnostics in `client.health`. docs/driver.md describes all of them, with units, and the behaviour
after errors. Tests compare docs/driver.md with these tables.

Safety: Commands from `rosbag play` are refused unless ``accept_replay`` is set. The driver switches motors on only on
request. The parameter ``enable_motors_on_start`` is such a request, but only for the first connection, not after a
reconnect. Whenever the node ends, it stops the robot, switches the motors off and closes the connection. The timers for
safety are in the client and use monotonic time.
"""

import contextlib
import traceback
from time import monotonic
from typing import Any, Callable, Dict, Mapping, Tuple

import rospy

from ..client import (BaudFound, CommandTimedOut, LineSpeed, LinkDown, MotionCleared, MotorsAnswered, Ready, Robot,
                      StatesMissed, SteeredRobot, Tuned, Unmoved)
from ..client.alarms import unmoved
from ..client.line_devices import LineDevices
from ..errors import PioneerError, PortError
from ..port_url import without_key
from ..prompt_connection import send_promptly
from ..ros_node import START_GRACE, init_node, run_device
from .accelerations import BorrowedAccelerations
from .accessory_requests import DOCKED
from .device_topics import device_topics
from .diagnostics import Diagnostics
from .helm_topic import HelmPublisher
from .notices import Throttle, Watch
from .parameters import BY_HAND, TUNING, DriverParameters, check_parameters
from .publications import Publications
from .reconfigure import Reconfiguration
from .requests import STOP_ALL, Requests
from .wire_topic import WirePublisher

ENDING = "ending"
"""The lock that is set while devices on the robot come to rest at the end."""
WHEELS_STAND = 1.0
"""The longest time (s) that the wheels have to come to rest before these devices, and the motors to go off."""
DEVICES_REST = 9.0
"""The longest time (s) that these devices have: an arm parks. With all else at the end it is less than 15 s, after
which roslaunch kills a node."""


class DriverNode:
    """Connects one Robot with its topics, services, parameters and diagnostics. Create it, then call `run`."""

    def __init__(self, parameters: DriverParameters) -> None:
        self._parameters = parameters
        self._throttle = Throttle()
        how_to_enable = "rosservice call %s true" % rospy.resolve_name("set_motors")
        self._watch = Watch(parameters.cmd_vel_timeout, how_to_enable)
        obstacles = {
            STOP_ALL: "%s is set, and nothing may move; to take it away: rostopic pub -1 %s std_msgs/Bool false"
                      % (STOP_ALL, rospy.resolve_name(STOP_ALL)),
            ENDING: "the driver is about to end, and nothing may move",
            DOCKED: "the robot takes power in a dock; to let go and drive: rosservice call %s"
                    % rospy.resolve_name("undock"),
            BY_HAND: "a person has the helm (%s); programs may command again after: rosservice call %s"
                     % (BY_HAND, rospy.resolve_name("teleop/release")),
        }
        self._device_topics = device_topics(parameters, self._locks_of_devices)
        self._diagnostics = Diagnostics(without_key(parameters.port), parameters.baud, how_to_enable, obstacles,
                                        lambda: self._robot.link, lambda: self._steered.state(),
                                        {name: topics.finding for name, topics in self._device_topics.items()})
        self._asked_to_end = False
        self._started = monotonic()
        self._publications = Publications(parameters, lambda kind, on: self._robot.request_data(kind, on))
        self._wire = WirePublisher() if parameters.publish_wire else None
        self._robot = Robot(
            parameters.port,
            baud=parameters.baud,
            model=parameters.model or None,
            models_file=parameters.models_file or None,
            pulse=max(0.0, parameters.pulse),
            link_check=parameters.link_check,
            use_sonar=parameters.use_sonar,
            command_timeout=parameters.cmd_vel_timeout,
            max_linear=parameters.max_xspeed,
            max_angular=parameters.max_yawspeed,
            has_gripper=parameters.gripper,
            tuning=parameters.tuning,
            host_baud=parameters.host_baud or None,
            reconnect=True,
            on_wire=self._wire and self._wire.tell,
        )
        self._robot.listen(self._publications.state, self._publications.event)      # first, so that poses are not late
        self._robot.listen(self._diagnostics.state, self._diagnostics.event)
        self._robot.listen(lambda state: self._warn(self._watch.state(state)), self._on_event)
        self._helm = HelmPublisher()
        self._steered = SteeredRobot(self._robot, parameters.inputs, obstacles, self._who_commands_changed)
        self._borrowed = BorrowedAccelerations(parameters.tuning, self._robot.tune)
        self._robot.listen(lambda state: self._put_back_accelerations())
        self._requests = Requests(parameters, self._robot, self._steered, self._watch, self._borrowed, self._warn)
        self._devices = LineDevices(
            self._robot, [device for topics in self._device_topics.values() for device in topics.line_devices],
            self._devices_changed)
        for topics in self._device_topics.values():
            self._robot.listen(topics.state)
        # For each type of event of the link: the method that informs the user.
        self._reactions: Dict[type, Callable[[Any], None]] = {
            Ready: self._welcome,
            LinkDown: self._link_down,
            MotorsAnswered: self._requests.motors_answered,
            Tuned: self._tuned,
            LineSpeed: self._line_speed,
            BaudFound: lambda event: rospy.loginfo(
                "the robot answers at %d baud; set the parameter baud to it for a faster start", event.baud),
            MotionCleared: lambda event: self._warn({
                event.reason: "the robot stopped: %s; it stands until a new command" % event.reason}),
            CommandTimedOut: lambda event: self._warn({
                "timed out": "the robot was stopped: no velocity came for %.1f s (%s)" % (
                    event.age, "teleop_timeout" if self._steered.state().holder else "cmd_vel_timeout")}),
            Unmoved: lambda event: self._warn({"unmoved": unmoved(event.age)}),
            StatesMissed: lambda event: self._warn({
                "missed": "this computer is too slow: %d states and packets of the robot were not published"
                % event.number}),
        }

    def run(self) -> int:
        """Run the driver until ROS shuts down. Return the exit code.

        The exit code is 0, or 1 when the driver ended by itself, because it cannot drive this robot at all.
        """
        rospy.on_shutdown(self._end)
        if rospy.is_shutdown():     # then rospy does not call it any more
            self._end()
        rospy.loginfo("looking for a robot on %s", self._robot.url)
        try:
            for topics in self._device_topics.values():
                topics.start(self._devices, self._requests)
            self._robot.start()
            self._diagnostics.start()
            self._helm.start(self._steered)
            self._devices.start()
            Reconfiguration(self._parameters, self._reconfigure)
            self._robot.wait_until_ended()
        finally:
            self._robot.close()
        link = self._robot.link
        rospy.loginfo("closed after %d packets, %d with a bad checksum, %d stray bytes, %d reconnects",
                      link.sips, link.bad_checksums, link.discarded_bytes, link.reconnects)
        return 0 if self._asked_to_end else 1

    def _end(self) -> None:
        """Stop the robot and end the node. rospy calls this in any thread when ROS shuts down (a signal, rosnode kill).

        This method does not wait until the connection to the robot is closed. `run` does.
        """
        self._asked_to_end = True
        try:
            self._rest_devices()
        except Exception:       # whatever is wrong with a device: the robot is stopped and closed
            rospy.logerr("a device did not come to rest at the end: %s", traceback.format_exc())
        self._robot.close(wait=False)
        self._diagnostics.stop()
        self._publications.close()
        self._helm.close()
        if self._wire is not None:
            self._wire.close()

    def _rest_devices(self) -> None:
        """Bring devices on the robot to rest: first the wheels stand and the motors are off, then each has its time.

        Without a device that acts at the end, this does nothing and takes no time.
        """
        if not any(topics.acts_at_end for topics in self._device_topics.values()):
            return
        self._steered.lock(ENDING)
        with contextlib.suppress(PioneerError):     # no link: nothing moves by us
            until = monotonic() + WHEELS_STAND
            while self._robot.ready and self._robot.wait_for_state().moving and monotonic() < until:
                pass
            self._steered.request_motors(False, WHEELS_STAND)()
        until = monotonic() + DEVICES_REST
        self._devices.end(DEVICES_REST)
        for topics in self._device_topics.values():
            topics.end(max(0.0, until - monotonic()))
        self._devices.close()

    def _locks_of_devices(self) -> Tuple[str, ...]:
        """Return the locks that keep devices still, too: a robot in a dock may move them."""
        return tuple(lock for lock in self._steered.state().locks if lock != DOCKED)

    def _devices_changed(self) -> None:
        for topics in self._device_topics.values():
            topics.changed()

    def _reconfigure(self, parameters: DriverParameters) -> None:
        """Put new values into effect for the parameters that may change while the driver runs."""
        self._robot.set_limits(parameters.max_xspeed, parameters.max_yawspeed, parameters.cmd_vel_timeout)
        self._borrowed.change_own(parameters.tuning)
        for name, velocity_input in parameters.inputs.items():
            self._steered.set_timeout(name, velocity_input.timeout)
        self._watch.cmd_vel_timeout = parameters.cmd_vel_timeout

    def _put_back_accelerations(self) -> None:
        borrower = self._borrowed.tick(monotonic())
        if borrower:
            rospy.loginfo("no more commands from %s: the accelerations are as before", borrower)

    def _who_commands_changed(self) -> None:
        self._helm.wake()
        self._diagnostics.wake()

    # Reactions to events of the robot. A thread of the client calls these methods.

    def _on_event(self, event: Any) -> None:
        react = self._reactions.get(type(event))
        if react is not None:
            react(event)

    def _welcome(self, event: Ready) -> None:
        identity = event.identity
        self._watch.identified(identity)
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
            told = rospy.logdebug if self._borrowed.changes(change.name) else rospy.loginfo
            (rospy.logwarn if change.problem else told)("~%s", change._replace(name=names[change.name]))

    def _link_down(self, event: LinkDown) -> None:
        if event.retry_in < 0:
            rospy.logfatal("%s", event.error)
        elif isinstance(event.error, PortError) and monotonic() - self._started < START_GRACE:
            rospy.logdebug("%s (trying again)", event.error)
        elif self._throttle.passes("link: %s" % event.error, monotonic()):
            rospy.logerr("%s (trying again until it works)", event.error)

    def _line_speed(self, event: LineSpeed) -> None:
        problem = ": " + event.problem if event.problem else ""
        (rospy.logwarn if problem else rospy.loginfo)("the line runs at %d baud%s", event.baud, problem)

    def _warn(self, texts: Mapping[str, str]) -> None:
        """Log warnings, by kind. What was logged a short time ago, and an empty text, are not logged."""
        now = monotonic()
        for kind, text in texts.items():
            if text and self._throttle.passes(kind, now, text):
                rospy.logwarn("%s", text)


def main() -> int:
    """Run the node and return the exit code: 0 after a shutdown, 1 the robot cannot be driven, 2 a wrong parameter."""
    init_node("p2os")
    if not send_promptly():
        rospy.logdebug("this rospy is not as prompt_connection.py expects it: messages go its own way")
    return run_device(check_parameters, DriverNode)

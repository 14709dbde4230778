"""The topics and services of a camera that turns. Without the parameter `ptz` there are none of them.

``ptz_control`` and ``ptz_state`` are as in p2os: whole degrees, to the right and upwards. All else is in rad, with the
axes of ROS: see `ptz.view`. What a camera does, and when, is in `ptz.session`; this file only says what is wished, and
publishes what is known.
"""

import contextlib
import math
from time import monotonic
from typing import Any, Callable, ContextManager, List, Tuple

import rospy
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA, Header
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from ..client import RobotState
from ..client.health import Finding
from ..client.line_devices import LineDevice, LineDevices
from ..errors import RefusedError, UsageError
from ..msg import PTZState
from ..ptz import AuxCamera, CameraLine, CameraPhase, CameraReport, CameraSession, CameraSettings, aux_port_of
from ..ptz.health import find_camera
from ..ptz.view import ABOVE_FOOT, Place3, counts_of_joints, frustum, joints, orientation, whole_degrees
from ..vcc4 import ZOOM_MOST, count_of, field_of_view
from .parameters import DriverParameters
from .publications import QUEUE, stamped
from .requests import STOP_ALL, OfferedService, Requests, SubscribedTopic, unless_locked

JOINTS = ("ptz_pan_joint", "ptz_tilt_joint")
BASE_FRAME, CAMERA_FRAME = "ptz_base_link", "camera"
COLOUR = ColorRGBA(0.8, 0.47, 0.65, 1.0)
MOST_DEGREES = 1000
"""Degrees beyond which a number in ptz_control is as good as this one: int32 could overflow."""


class PtzTopics:
    """A camera's topics, services and diagnostics.

    Args:
        parameters: the parameters of the driver.
        settings: those of the camera.
        locks: function that returns the names of the locks that are set. Then nothing turns.

    Attributes:
        line_devices: the camera as a device on the robot's line, if it is there.
        line: the camera on a line of its own. None if it is a device on the robot's line.
    """

    def __init__(self, parameters: DriverParameters, settings: CameraSettings,
                 locks: Callable[[], Tuple[str, ...]]) -> None:
        self._parameters, self._locks = parameters, locks
        self._session = CameraSession(settings, lambda: STOP_ALL in locks())
        port = aux_port_of(parameters.ptz_port)
        self.line_devices: List[LineDevice] = [] if port is None else [AuxCamera(self._session, port)]
        self.line = CameraLine(parameters.ptz_port, self._session, self.changed) if port is None else None
        self._report = CameraReport()
        self._told = ""
        prefix = parameters.frame_prefix
        self._frames = parameters.base_link_frame, prefix + BASE_FRAME, prefix + CAMERA_FRAME
        self._published_at = -math.inf      # when the camera was at the place that was published last (s)
        self._state = rospy.Publisher("ptz_state", PTZState, queue_size=QUEUE)
        self._joint_states = rospy.Publisher("joint_states", JointState, queue_size=QUEUE)
        self._view = rospy.Publisher("ptz_view", Marker, queue_size=QUEUE)
        self._tf = None if parameters.ptz_place is None else rospy.Publisher("/tf", TFMessage, queue_size=QUEUE)

    def start(self, devices: LineDevices, requests: Requests) -> None:
        """Begin: see `DeviceTopics.start`."""
        self._using = devices.using if self.line is None else self.line.using
        if self.line is not None:
            self.line.start()
        requests.offer(self, PTZ_TOPICS, PTZ_SERVICES, self._halt)

    @property
    def acts_at_end(self) -> bool:
        """Whether the camera has something to do at the end, which takes time."""
        return self._session.settings.power_off_at_end or self._report.is_moving

    def end(self, timeout: float) -> None:
        """Bring a camera on a line of its own to rest, within ``timeout`` s, and close its line."""
        if self.line is not None:
            self.line.end(timeout)
            self.line.close()

    def finding(self) -> Finding:
        """Return the finding of the camera for the diagnostics."""
        return find_camera(self._report, self._parameters.ptz_port, monotonic())

    # -- what is known

    def changed(self) -> None:
        """Take note that the session may have changed, and tell people what happened. It must return soon."""
        report = self._report = self._session.report
        if self.line is None and report.phase is CameraPhase.NO_LINE:
            return      # the driver tells of the robot's own line
        told = report.problem or "ready"
        if told != self._told:
            self._told = told
            (rospy.logwarn if report.phase is CameraPhase.FAILED else rospy.loginfo)("camera: %s", told)

    def state(self, state: RobotState) -> None:
        """Publish where the camera looks. The driver calls this once for each SIP.

        While it moves, a place is published once, with the time at which the camera said it.
        """
        report = self._report
        if report.pan is None or report.tilt is None or report.phase is CameraPhase.NO_LINE:
            return
        if report.is_moving and report.position_at <= self._published_at:
            return
        self._published_at = report.position_at if report.is_moving else state.sent_time
        stamp = stamped(rospy.Time(), self._published_at)
        pan, tilt = joints(report.pan, report.tilt)
        zoom = report.zoom or 0
        if self._state.get_num_connections():
            self._state.publish(PTZState(whole_degrees(report.pan), whole_degrees(report.tilt), zoom, False))
        if self._joint_states.get_num_connections():
            self._joint_states.publish(JointState(Header(stamp=stamp), list(JOINTS), [pan, tilt], [], []))
        if self._tf is not None and self._parameters.ptz_place is not None:
            self._tf.publish(transforms(self._frames, self._parameters.ptz_place, pan, tilt, stamp))
        if self._view.get_num_connections():
            width = field_of_view(zoom, self._parameters.ptz_fov_wide, self._parameters.ptz_fov_tele)
            self._view.publish(view_marker(self._frames[2], width))

    # -- what is wished. Each method raises PioneerError with the reason when it does not obey.

    def control(self, topic: str, message: PTZState, sender: str) -> None:
        """Obey ptz_control: whole degrees and zoom steps; relative ones are added to the last targets."""
        with self._commanding(topic) as now:
            before = self._session.target if message.relative else (0, 0, 0)
            pan, tilt = (count + count_of(max(-MOST_DEGREES, min(MOST_DEGREES, degrees)))
                         for count, degrees in zip(before, (message.pan, message.tilt)))
            zoom = before[2] + max(-ZOOM_MOST, min(ZOOM_MOST, message.zoom))
            self._session.look(pan, tilt, now)
            self._session.zoom_to(zoom, now)

    def move_joints(self, topic: str, message: JointState, sender: str) -> None:
        """Obey ptz_joint_control: angles of one joint or both (rad); the other one keeps its target."""
        wanted = joint_targets(topic, message)
        with self._commanding(topic) as now:
            pan, tilt = joints(*self._session.target[:2])
            pan, tilt = wanted.get(JOINTS[0], pan), wanted.get(JOINTS[1], tilt)
            self._session.look(*counts_of_joints(pan, tilt), now)

    def home(self) -> str:
        """Send the camera home. Return the text of the answer."""
        with self._commanding("ptz/home") as now:
            self._session.home(now)
        return "the camera was told to go home"

    def stop(self) -> str:
        """Stop the camera. Return the text of the answer."""
        with self._using() as now:
            self._session.stop(now)
        return "the camera was told to stop"

    def power(self, on: bool) -> str:
        """Switch the camera on or off. Return the text of the answer: it takes a while."""
        with self._commanding("ptz/power") if on else self._using() as now:
            self._session.power(on, now)
        return "the camera is being switched %s" % ("on, and initialised" if on else "off")

    def _halt(self) -> None:
        """Stop the camera, because a lock was set. One that is not ready does not turn by us."""
        with contextlib.suppress(RefusedError):
            self.stop()

    def _commanding(self, what: str) -> ContextManager[float]:
        return unless_locked(self._using, self._locks, what)


def joint_targets(topic: str, message: JointState) -> Any:
    """Return the angles (rad) in a message by their joints.

    Raises:
        UsageError: it names another joint, or an angle is missing or not finite.
    """
    if not message.name or len(message.name) != len(message.position):
        raise UsageError("%s refused: %d names and %d positions; give one position (rad) for each of the names %s"
                         % (topic, len(message.name), len(message.position), " and ".join(JOINTS)))
    for name, angle in zip(message.name, message.position):
        if name not in JOINTS:
            raise UsageError("%s refused: no joint %r; there are %s" % (topic, name, " and ".join(JOINTS)))
        if not abs(angle) <= 2.0 * math.pi:
            raise UsageError("%s refused: %s is %s; legal: -2 pi to 2 pi (rad)" % (topic, name, angle))
    return dict(zip(message.name, message.position))


def transforms(frames: Tuple[str, str, str], place: Place3, pan: float, tilt: float, stamp: rospy.Time) -> TFMessage:
    """Return the transforms of a camera: base_link -> its foot -> what it looks along (x ahead).

    Args:
        frames: the names of the three frames.
        place: where its foot is (m, base_link).
        pan, tilt: angles of its joints (rad).
        stamp: the time.
    """
    base, foot, camera = frames
    return TFMessage([
        TransformStamped(Header(stamp=stamp, frame_id=base), foot,
                         Transform(Vector3(*place), Quaternion(0.0, 0.0, 0.0, 1.0))),
        TransformStamped(Header(stamp=stamp, frame_id=foot), camera,
                         Transform(Vector3(0.0, 0.0, ABOVE_FOOT), Quaternion(*orientation(pan, tilt))))])


def view_marker(frame: str, width: float) -> Marker:
    """Return the frustum of a view for RViz, in the frame of the camera. ``width``: field of view (rad)."""
    apex, *corners = (Point(*corner) for corner in frustum(width))
    lines: List[Point] = []
    for corner, following in zip(corners, corners[1:] + corners[:1]):
        lines += [apex, corner, corner, following]
    marker = Marker(header=Header(frame_id=frame), ns="ptz_view", type=Marker.LINE_LIST, action=Marker.ADD,
                    color=COLOUR, points=lines, frame_locked=True)
    marker.pose.orientation.w, marker.scale.x = 1.0, 0.01
    return marker


PTZ_TOPICS = (
    SubscribedTopic("ptz_control", PTZState, 1, PtzTopics.control, lambda _: False),
    SubscribedTopic("ptz_joint_control", JointState, 1, PtzTopics.move_joints, lambda _: False),
)

PTZ_SERVICES = (
    OfferedService("ptz/home", Trigger, lambda ptz, _: ptz.home()),
    OfferedService("ptz/stop", Trigger, lambda ptz, _: ptz.stop()),
    OfferedService("ptz/power", SetBool, lambda ptz, request: ptz.power(request.data)),
)

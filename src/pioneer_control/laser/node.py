"""The ROS node of a SICK LMS2xx laser: it finds the laser on its port, and publishes what it measures.

*Publishes*
``scan`` (sensor_msgs/LaserScan): each complete scan, counter-clockwise; the stamp is the time of its first ray;
``/diagnostics`` (diagnostic_msgs/DiagnosticArray): how the laser is, see `health`;
``/tf_static``: where the laser sits, base_link -> laser, if the parameter ``place`` says it.

*Parameters*: see `LaserParameters`. docs/laser.md describes all of it.

Whenever the node ends, it tells the laser to stop and to take the speed that it had before. Nothing else that the laser
keeps is changed, unless ``write`` is set.
"""

from time import monotonic
from typing import Any, Callable, Dict

import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from ..client.health import Finding
from ..diagnostics_thread import DiagnosticsThread
from ..prompt_connection import send_promptly
from ..ros_node import START_GRACE, init_node, run_device
from .byte_record import ByteRecord
from .conversation import LaserInfo
from .conversion import numbers_of
from .health import LaserHealth
from .line import CLOSING, LaserLine, PortDown, StillLooking, open_laser_port
from .parameters import Coordinates, LaserParameters, check_laser_parameters
from .session import LaserLost, Measuring, ScanHeard

PORT_CLOSES = 0.5
"""Time (s) that closing the port may take, after the laser was told to stop."""


class LaserNode:
    """Connects one laser with its topics and diagnostics. Create it, then call `run`."""

    def __init__(self, parameters: LaserParameters) -> None:
        self._parameters, self._mounted = parameters, parameters.mounted
        self._started = monotonic()
        self._trouble = ""
        self._scans = rospy.Publisher("scan", LaserScan, queue_size=10, tcp_nodelay=True)
        # One message for all scans: publish() makes bytes of it at once.
        self._scan = LaserScan(header=Header(frame_id=parameters.laser_frame))
        self._record = ByteRecord(parameters.record) if parameters.record else None
        open_port = open_laser_port if self._record is None else self._record.opener(open_laser_port)
        self._line = LaserLine(parameters.port, parameters.settings, self._on_event, open_port)
        self._health = LaserHealth(parameters.port)
        self._diagnostics = DiagnosticsThread(("Laser",), self._report, lambda: self._health.hardware_id)
        self._reactions: Dict[type, Callable[[Any], None]] = {
            ScanHeard: self._publish,
            Measuring: lambda event: self._welcome(event.info),
            LaserLost: lambda event: self._complain("%s: %s" % (parameters.port, event.reason)),
            PortDown: lambda event: self._port_down(event.reason),
            StillLooking: lambda event: self._say(event.reason),
        }

    def run(self) -> int:
        """Run until ROS shuts down, and return the exit code 0."""
        rospy.on_shutdown(self._end)
        if rospy.is_shutdown():     # then rospy does not call it any more
            self._end()
        rospy.loginfo("looking for a laser on %s", self._line.url)
        if self._mounted.place is not None:
            self._publish_place(self._mounted.place)
        self._diagnostics.start()
        try:
            self._line.run()
        finally:
            self._diagnostics.stop()
            if self._record is not None:
                self._record.close()
        counts = self._line.session.counts
        rospy.loginfo("closed after %d scans, %d wrong CRCs, %d stray bytes; the laser was lost %d times",
                      counts.scans, counts.line.wrong_crcs, counts.line.discarded_bytes, counts.lost)
        return 0

    def _end(self) -> None:
        """Tell the laser to stop. rospy calls this in any thread when ROS shuts down, and waits for it."""
        self._line.end()
        self._line.ended.wait(CLOSING + PORT_CLOSES)

    def _publish_place(self, place: Coordinates) -> None:
        """Publish the transform base_link -> laser. Of a laser that hangs upside down its z axis points down."""
        x, y, z, _ = place
        if self._mounted.height_is_missing:
            rospy.logwarn("how high the laser of a %s sits is not known: tf says 0; measure it and give place:=[%g, %g,"
                          " HEIGHT, 0]", self._parameters.place, x, y)
        self._broadcaster = tf2_ros.StaticTransformBroadcaster()
        self._broadcaster.sendTransform(TransformStamped(
            Header(stamp=rospy.Time.now(), frame_id=self._parameters.base_frame), self._parameters.laser_frame,
            Transform(Vector3(x, y, z), Quaternion(*self._mounted.rotation))))

    # Reactions to events of the line

    def _on_event(self, event: Any) -> None:
        self._reactions[type(event)](event)
        if self._health.event(event):
            self._diagnostics.wake()

    def _report(self) -> Dict[str, Finding]:
        """Return how the laser is. The thread of the diagnostics calls this."""
        return {"Laser": self._health.report(monotonic(), self._line.session.counts)}

    def _publish(self, event: ScanHeard) -> None:
        if rospy.core.is_shutdown_requested():      # the topic may be closed
            return
        numbers = numbers_of(event, self._mounted.turns_values, self._parameters.no_echo == "max")
        age = monotonic() - numbers.first_ray
        stamp = rospy.Time.from_sec(max(0.0, rospy.get_time() - age + self._parameters.time_offset))
        scan = self._scan
        scan.header.stamp = stamp
        scan.angle_min, scan.angle_max, scan.angle_increment = (
            numbers.angle_min, numbers.angle_max, numbers.angle_increment)
        scan.time_increment, scan.scan_time = numbers.time_increment, numbers.scan_time
        scan.range_min, scan.range_max = numbers.range_min, numbers.range_max
        scan.ranges, scan.intensities = numbers.ranges.tolist(), numbers.intensities.tolist()
        try:
            self._scans.publish(scan)
        except rospy.ROSException:
            if not rospy.core.is_shutdown_requested():
                raise

    def _welcome(self, info: LaserInfo) -> None:
        self._trouble = ""
        self._say(description(info))
        for remark in info.remarks:
            rospy.logwarn("the laser does not do all it was asked to: %s", remark)

    def _say(self, sentence: str) -> None:
        rospy.loginfo("%s", sentence)

    def _port_down(self, reason: str) -> None:
        if monotonic() - self._started < START_GRACE:
            rospy.logdebug("%s (trying again)", reason)
        else:
            self._complain(reason)

    def _complain(self, reason: str) -> None:
        """Log an error, but the same one only once until the laser is there again."""
        if reason != self._trouble:
            self._trouble = reason
            rospy.logerr("%s (trying again until it works)", reason)


def description(info: LaserInfo) -> str:
    """Return a sentence about a laser that measures."""
    speed = "%d baud" % info.baud
    if info.baud != info.found_baud:
        speed += " (found at %d, and gets that back at the end)" % info.found_baud
    return "%s measures at %s: %d degrees wide in steps of %.2f, to %g m, %.1f times a second" % (
        info.type, speed, info.variant.angle_deg, info.variant.step_hundredths / 100.0, info.farthest_m,
        1.0 / info.scan_time)


def main() -> int:
    """Run the node and return the exit code: 0 after a shutdown, 2 a wrong parameter."""
    init_node("laser")
    send_promptly()         # without a thread for each subscriber the node costs a fifth less
    return run_device(check_laser_parameters, LaserNode)

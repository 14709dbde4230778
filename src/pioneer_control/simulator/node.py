"""The simulated robot as a ROS node: its line for a driver, and the truth about its world for pictures and tests.

*Publishes* ``map`` (nav_msgs/OccupancyGrid, latched), ``ground_truth`` (nav_msgs/Odometry in the map's frame, 10 Hz), ``cans``
(geometry_msgs/PoseArray in the map's frame, latched, on change; z is how high a can is lifted, x of a pose points up, so that arrows
stand), ``world`` (std_msgs/String, latched: its name), tf map -> odom (true pose of the odometry's origin).
*Subscribes* ``stop_button`` (std_msgs/Bool): presses the robot's STOP button, or lets it go.
*Parameters*: `SimulatorParameters`.
"""

import math
import sys
import threading
from typing import List, Tuple

import rospy
import tf
from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion
from nav_msgs.msg import OccupancyGrid, Odometry
from std_msgs.msg import Bool, String

from ..errors import PioneerError
from ..message_values import quaternion_of
from ..robots import find_model
from ..ros_node import init_node
from .firmware import Firmware
from .loading import load_world
from .robot_numbers import load_numbers
from .parameters import SimulatorParameters, check_parameters
from .server import Server

PERIOD = 0.1
"""Seconds between two publications, of real time."""
MAP_RESOLUTION = 0.025
"""Side (m) of a cell of the map."""
UP = Quaternion(y=-math.sqrt(0.5), w=math.sqrt(0.5))
"""Turns the x axis upwards."""

CanPlaces = List[Tuple[float, float, float]]


def main() -> int:
    """Run the node. Returns the exit code: 0 shut down, 1 something failed, 2 a parameter makes no sense."""
    init_node("p2os_simulator")
    try:
        parameters = check_parameters(rospy.get_param("~", {}))
        firmware = Firmware(
            find_model(parameters.model, parameters.models_file or None),
            load_world(parameters.world),
            gripper=parameters.gripper,
            rear_sonar=parameters.rear_sonar,
            name=parameters.name,
            seed=parameters.seed,
            numbers=load_numbers(parameters.numbers_file or None),
        )
        server = Server(firmware, parameters.tcp, parameters.pty or None)
    except PioneerError as error:
        rospy.logfatal("%s", error)
        return 2 if isinstance(error, ValueError) else 1
    with server:
        places = " and ".join(place for place in (server.url, server.pty_link) if place)
        for skipped in firmware.world.skipped:
            rospy.loginfo("world file, skipped: %s", skipped)
        rospy.loginfo("a simulated %s stands in the world %s, at %s", firmware.model.subtype, firmware.world.name, places)
        return Node(server, parameters).run()


class Node:
    """Publishes what is true of the simulated robot behind `server`."""

    def __init__(self, server: Server, parameters: SimulatorParameters):
        self._server = server
        self._parameters = parameters
        self._stop = threading.Event()
        self._cans_told = None
        self._ground_truth = rospy.Publisher("ground_truth", Odometry, queue_size=10)
        self._cans = rospy.Publisher("cans", PoseArray, queue_size=1, latch=True)
        self._map = rospy.Publisher("map", OccupancyGrid, queue_size=1, latch=True)
        self._world = rospy.Publisher("world", String, queue_size=1, latch=True)
        self._tf = tf.TransformBroadcaster()
        self._map.publish(map_message(server.firmware.world, parameters.map_frame))
        self._world.publish(server.firmware.world.name)
        rospy.Subscriber("stop_button", Bool, self._press, queue_size=10)
        rospy.on_shutdown(self._stop.set)

    def run(self) -> int:
        """Publish until ROS shuts down (0) or the robot dies (1). Real time paces it, so that it also works under simulated time."""
        while not self._stop.wait(PERIOD):
            if not self._server.running:
                rospy.logfatal("the simulated robot died; its error stands above")
                return 1
            self._publish()
        return 0

    def _press(self, message: Bool) -> None:
        with self._server.lock:
            self._server.firmware.press_stop_button(message.data)

    def _publish(self) -> None:
        firmware = self._server.firmware
        with self._server.lock:
            pose, velocity, origin = firmware.true_pose, firmware.velocity, firmware.odometry_origin
            cans = can_places(firmware)
        now = rospy.Time.now()
        prefix, names = self._parameters.frame_prefix, self._parameters
        truth = Odometry()
        truth.header.stamp, truth.header.frame_id = now, names.map_frame
        truth.child_frame_id = prefix + names.base_link_frame_id
        truth.pose.pose = pose_message(*pose)
        truth.twist.twist.linear.x, truth.twist.twist.angular.z = velocity
        self._ground_truth.publish(truth)
        x, y, heading = origin
        self._tf.sendTransform((x, y, 0.0), quaternion_of(heading), now, prefix + names.odom_frame_id, names.map_frame)
        if cans != self._cans_told:
            self._cans_told = cans
            message = PoseArray(poses=[Pose(Point(*place), UP) for place in cans])
            message.header.stamp, message.header.frame_id = now, names.map_frame
            self._cans.publish(message)


def can_places(firmware: Firmware) -> CanPlaces:
    """Where every can of the world stands or hangs: x, y and how high it is lifted (m, map frame)."""
    lifted = firmware.gripper.height if firmware.gripper is not None else 0.0
    return [(can.x, can.y, 0.0 if can.held_by is None else lifted) for can in firmware.world.cans]


def map_message(world, frame: str) -> OccupancyGrid:
    """The world as a map."""
    cells, origin = world.occupancy(MAP_RESOLUTION)
    message = OccupancyGrid()
    message.header.frame_id = frame
    message.header.stamp = message.info.map_load_time = rospy.Time.now()
    message.info.resolution = MAP_RESOLUTION
    message.info.height, message.info.width = cells.shape
    message.info.origin = pose_message(origin[0], origin[1], 0.0)
    message.data = cells.reshape(-1).tolist()
    return message


def pose_message(x: float, y: float, heading: float) -> Pose:
    """A pose on the floor."""
    return Pose(Point(x, y, 0.0), Quaternion(*quaternion_of(heading)))


if __name__ == "__main__":
    sys.exit(main())

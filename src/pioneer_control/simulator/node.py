"""The ROS node of the simulator: runs simulated robots, opens lines for their drivers, publishes the true state of the
world, and has services for faults.

*Publishes*
``map`` (nav_msgs/OccupancyGrid, latched): the world as a map;
``world`` (std_msgs/String, latched): the name of the world;
``world_markers`` (visualization_msgs/MarkerArray, latched): walls and posts, also those that are on no map;
``markers`` (visualization_msgs/MarkerArray, 10 Hz): cans, people, grippers and outlines of the robots;
``cans`` (geometry_msgs/PoseArray in the map frame, latched, on change): poses of the cans; z is the height to which a
can is lifted, and the x axis of each pose points up, so that RViz draws upright arrows;
``ground_truth`` (nav_msgs/Odometry in the map frame, 10 Hz), for each robot: its true pose;
tf map -> odom, for each robot: the true pose of the origin of its odometry; if ``map_tf`` is false, the tf
map -> truth/base_link: the true pose of the robot itself;
``/clock`` (rosgraph_msgs/Clock), only when the speed is not 1.

*Subscribes* ``stop_button`` (std_msgs/Bool), for each robot: presses the robot's STOP button, or releases it.

If there are several robots, the topics and frames of each robot have the prefix ``robot1/``, ``robot2/`` and so on.

*Services* ``~add_fault`` (AddFault), ``~list_faults`` and ``~clear_faults`` (std_srvs/Trigger); ``~carry`` (Carry): a
robot is carried to another place; ``~pause`` (std_srvs/SetBool): simulated time stands, or passes again; ``~reset``
(std_srvs/Trigger): all robots and cans are carried back to where they began.

*Parameters*: see `SimulatorParameters`.

The node logs when a robot has pushed a can, and how far.
"""

import math
import sys
import threading
import time
from typing import Any, Iterable, List, Optional, Sequence, Tuple

import rospy
import tf
from geometry_msgs.msg import (
    Point, Pose, PoseArray, PoseWithCovariance, Quaternion, Twist, TwistWithCovariance, Vector3)
from nav_msgs.msg import MapMetaData, OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, ColorRGBA, Header, String
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse
from visualization_msgs.msg import Marker, MarkerArray

from ..errors import PioneerError
from ..message_values import quaternion_of
from ..robots import find_model
from ..ros_node import init_node
from ..srv import AddFault, AddFaultResponse, Carry, CarryResponse
from .firmware import Firmware
from .hardware.gripper import ParallelGripper
from .line import Server, camera_ports, fault_of, laser_ports, load_faults
from .line.lasers import ROBOTS_LINE
from .parameters import SimulatorParameters, check_parameters
from .shoves import ShoveWatch
from .simulation import Simulation, prepared, simulate
from .tasks import Referee
from .truth.orders import Orders, Request
from .truth.state import can_place
from .world import World, load_world
from .world.poses import compose

PERIOD = 0.1
"""Real time (s) between two publications of the state of the world."""
CLOSING = 1.0
"""Longest time (s) that the simulator serves on at its end, until its clients have closed their sessions."""
CLOCK_PERIODS = 0.001, 0.01
"""Shortest and longest real time (s) between two messages on /clock."""
CLOCK_STEP = 0.02
"""Simulated time (s) between two messages on /clock, if `CLOCK_PERIODS` allows it.

It is much shorter than the time between two SIPs (0.1 s), so that their stamps differ and are in order.
"""
MAP_RESOLUTION = 0.025
"""Side (m) of a cell of the published map."""
TRUE_BASE_FRAME = "truth/base_link"
"""Frame of the true pose of a robot, when another node says where its odometry began."""
UP = Quaternion(y=-math.sqrt(0.5), w=math.sqrt(0.5))
"""Orientation whose x axis points up."""
LEVEL = Quaternion(w=1.0)
WALL_HEIGHT = 0.3
"""Height (m) of walls and posts in the markers."""
PERSON_HEIGHT = 1.7
"""Height (m) of people in the markers."""
PADDLE_HEIGHT = 0.05
"""Height (m) of the paddles of a gripper in the markers."""
COLOURS = {
    "wall": ColorRGBA(0.45, 0.45, 0.5, 1.0), "post": ColorRGBA(0.35, 0.35, 0.4, 1.0),
    "unmapped": ColorRGBA(0.80, 0.47, 0.65, 1.0), "unmapped post": ColorRGBA(0.80, 0.47, 0.65, 1.0),
    "person": ColorRGBA(0.0, 0.62, 0.45, 0.7),
    "can": ColorRGBA(0.90, 0.62, 0.0, 1.0),
    "paddle": ColorRGBA(0.0, 0.45, 0.70, 1.0), "outline": ColorRGBA(0.0, 0.45, 0.70, 0.8),
}

CanPlaces = List[Tuple[float, float, float]]


def main() -> int:
    """Run the node.

    Returns:
        The exit code: 0 after ROS has shut down, 1 after a failure, 2 if a parameter is not legal.
    """
    init_node("p2os_simulator")
    try:
        parameters = check_parameters(rospy.get_param("~", {}))
        faults = [fault_of(words) for words in parameters.fault.split(";") if words.strip()]
        faults += load_faults(parameters.faults_file) if parameters.faults_file else []
        simulation = simulation_of(parameters)
        server = Server(
            simulation, parameters.tcp, parameters.pty or None, speed=parameters.speed, seed=parameters.seed,
            faults=faults, record=parameters.record or None,
            say=lambda sentence: rospy.logwarn("simulated %s", sentence),
            lasers=laser_ports(parameters.laser, parameters.laser_port, parameters.laser_pty or None),
            cameras=camera_ports(parameters.camera, parameters.camera_cabling, parameters.camera_aux,
                                 parameters.camera_port, parameters.camera_pty or None))
        orders = Orders(simulation, server.simulation, server.pace, Referee(simulation))
    except PioneerError as error:
        rospy.logfatal("%s", error)
        return 2 if isinstance(error, ValueError) else 1
    with server:
        for skipped in simulation.world.skipped:
            rospy.loginfo("world file, skipped: %s", skipped)
        for berth in server.berths:
            rospy.loginfo("a simulated %s stands in the world %s, at %s", parameters.model, simulation.world.name,
                          " and ".join(filter(None, (berth.url, berth.pty_link))))
        for laser in server.lasers:
            rospy.loginfo("its laser is at %s", laser.place)
        for camera in server.cameras:
            rospy.loginfo("its camera is at %s", camera.place)
        if server.open_to_others:
            rospy.logwarn("every machine that reaches this one can drive the simulated robots: the protocol knows no"
                          " password")
        return Node(server, simulation, orders, parameters).run()


def simulation_of(parameters: SimulatorParameters) -> Simulation:
    """Return the simulation, with world and robots, that the node's parameters describe.

    Raises:
        UsageError: a parameter is not legal.
    """
    model = find_model(parameters.model, parameters.models_file or None)
    world = prepared(load_world(parameters.world), model, parameters.robots, parameters.seed, parameters.start,
                     parameters.unmapped, parameters.walkers)
    return simulate(
        world, model, parameters.robots,
        parameters.name if parameters.robots == 1 else None, parameters.seed, gripper=parameters.gripper,
        arm=parameters.arm != "none", rear_sonar=parameters.rear_sonar, numbers_file=parameters.numbers_file or None,
        real=parameters.real, serial=parameters.serial or None, line_laser=parameters.laser == ROBOTS_LINE)


class RobotTruth:
    """Publishes the true pose and speed of one robot, and subscribes to its STOP button.

    Args:
        firmware: the robot.
        prefix: prefix of the robot's topics and frames, empty for a single robot.
        parameters: parameters of the node.
        lock: lock to hold while the robot is used.
    """

    def __init__(self, firmware: Firmware, prefix: str, parameters: SimulatorParameters, lock: Any):
        self._firmware = firmware
        self._lock = lock
        self._map_frame, self._map_tf = parameters.map_frame, parameters.map_tf
        self._odom_frame = parameters.frame_prefix + prefix + parameters.odom_frame_id
        self._true_frame = parameters.frame_prefix + prefix + TRUE_BASE_FRAME
        self._base_frame = parameters.frame_prefix + prefix + parameters.base_link_frame_id
        self._ground_truth = rospy.Publisher(prefix + "ground_truth", Odometry, queue_size=10)
        self._tf = tf.TransformBroadcaster()
        rospy.Subscriber(prefix + "stop_button", Bool, self._press, queue_size=10)

    def publish(self, now: rospy.Time) -> None:
        """Publish the true pose and speed of the robot, and its tf, with the stamp `now`."""
        with self._lock:
            pose, (speed, turn_rate) = self._firmware.true_pose, self._firmware.velocity
            origin = self._firmware.hardware.odometry.origin
        self._ground_truth.publish(Odometry(
            header=Header(stamp=now, frame_id=self._map_frame), child_frame_id=self._base_frame,
            pose=PoseWithCovariance(pose=pose_message(*pose)),
            twist=TwistWithCovariance(twist=Twist(linear=Vector3(x=speed), angular=Vector3(z=turn_rate)))))
        (x, y, heading), child = (origin, self._odom_frame) if self._map_tf else (pose, self._true_frame)
        self._tf.sendTransform((x, y, 0.0), quaternion_of(heading), now, child, self._map_frame)

    def _press(self, message: Bool) -> None:
        with self._lock:
            self._firmware.press_stop_button(message.data)


class Node:
    """Publishes the true state of the world and its robots, and offers services for faults, pauses and resets.

    Args:
        server: server that runs the robots.
        simulation: the simulated robots and their world.
        orders: what the services do.
        parameters: parameters of the node.
    """

    def __init__(self, server: Server, simulation: Simulation, orders: Orders, parameters: SimulatorParameters):
        self._server, self._simulation, self._orders = server, simulation, orders
        self._lines = server.simulation
        self._shoves = ShoveWatch(simulation.world.cans)
        server.watched = True
        self._frame = parameters.map_frame
        self._own_clock = parameters.speed != 1.0
        clock_period = min(max(CLOCK_STEP / parameters.speed, CLOCK_PERIODS[0]), CLOCK_PERIODS[1])
        self._period = clock_period if self._own_clock else PERIOD
        self._stop = threading.Event()
        self._cans_published: Optional[CanPlaces] = None
        self._epoch = time.time()
        robots = range(1, parameters.robots + 1)
        prefixes = ["robot%d/" % number for number in robots] if parameters.robots > 1 else [""]
        self._names = [prefix.rstrip("/") or "the robot" for prefix in prefixes]
        self._truths = [
            RobotTruth(robot, prefix, parameters, server.lock) for robot, prefix in zip(simulation.robots, prefixes)]
        self._cans = rospy.Publisher("cans", PoseArray, queue_size=1, latch=True)
        self._markers = rospy.Publisher("markers", MarkerArray, queue_size=1)
        world = simulation.world
        for topic, kind, message in (
                ("map", OccupancyGrid, map_message(world, self._frame)), ("world", String, String(world.name)),
                ("world_markers", MarkerArray, world_markers(world, self._frame))):
            rospy.Publisher(topic, kind, queue_size=1, latch=True).publish(message)     # rospy keeps the publisher
        if self._own_clock:
            self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
            if not rospy.get_param("/use_sim_time", False):
                rospy.logwarn("the speed is not 1: /clock is published; set /use_sim_time to true before other nodes"
                              " start, or they keep real time")
        rospy.Service("~add_fault", AddFault, self._add_fault)
        rospy.Service("~list_faults", Trigger, self._list_faults)
        rospy.Service("~clear_faults", Trigger, self._clear_faults)
        rospy.Service("~carry", Carry, self._carry)
        rospy.Service("~pause", SetBool, self._pause)
        rospy.Service("~reset", Trigger, self._reset)
        rospy.on_shutdown(self._stop.set)

    def run(self) -> int:
        """Publish until ROS shuts down or the server fails. The loop uses real time, so it also works with /clock.

        Returns:
            The exit code: 0 after ROS has shut down, 1 if the server has failed.
        """
        due = time.monotonic()
        while not self._stop.wait(self._period):
            if not self._server.running:
                rospy.logfatal("the simulated robots died; their error stands above")
                return 1
            if self._own_clock:
                self._clock.publish(self._now())
            if time.monotonic() >= due:
                due = time.monotonic() + PERIOD - CLOCK_PERIODS[1] / 2.0
                self._publish(self._now())
        for sentence in self._shoves.finish():
            rospy.loginfo("%s", sentence)
        self._let_clients_close()
        return 0

    def _let_clients_close(self) -> None:
        """Serve on for a moment, while a session is open: roslaunch ends all nodes at once, and the driver would take
        the loss of its line for an accident before it hears that it is to end.
        """
        end = time.monotonic() + CLOSING
        while self._has_sessions() and time.monotonic() < end:
            time.sleep(PERIOD / 2.0)

    def _has_sessions(self) -> bool:
        with self._server.lock:
            return any(robot.open_session is not None for robot in self._simulation.robots)

    def _now(self) -> rospy.Time:
        """Return the time for stamps: ROS time, or the simulated time if this node publishes /clock."""
        return rospy.Time.from_sec(self._epoch + self._lines.time) if self._own_clock else rospy.Time.now()

    def _publish(self, now: rospy.Time) -> None:
        for truth in self._truths:
            truth.publish(now)
        with self._server.lock:
            cans = [can_place(can) for can in self._simulation.world.cans]
            robots = [(name, robot.true_pose[:2]) for name, robot in zip(self._names, self._simulation.robots)]
            shoves = self._shoves.look(self._lines.time, robots)
        for sentence in shoves:
            rospy.loginfo("%s", sentence)
        if cans != self._cans_published:
            self._cans_published = cans
            self._cans.publish(PoseArray(
                Header(stamp=now, frame_id=self._frame), [Pose(Point(*place), UP) for place in cans]))
        if self._markers.get_num_connections():
            with self._server.lock:
                markers = moving_markers(self._simulation, self._frame)
            self._markers.publish(markers)

    # -- services

    def _order(self, name: str, **values: Any) -> Tuple[bool, str]:
        """Give an order, with legal values. Return whether it was obeyed, and a sentence about it."""
        with self._server.lock:
            answer = self._orders.answer(Request(None, name, values))
        self._server.wake()
        return answer["ok"], answer["text"]

    def _add_fault(self, request: Any) -> AddFaultResponse:
        return AddFaultResponse(*self._order("add_fault", fault=request.fault))

    def _list_faults(self, request: Any) -> TriggerResponse:
        with self._server.lock:
            return TriggerResponse(True, "; ".join(self._lines.faults.told(self._lines.clock.now_us)) or "none")

    def _clear_faults(self, request: Any) -> TriggerResponse:
        return TriggerResponse(*self._order("clear_faults"))

    def _carry(self, request: Any) -> CarryResponse:
        pose, robots = request.pose, len(self._simulation.robots)
        if request.robot > robots:
            return CarryResponse(False, "there is no robot %d: give a number from 1 to %d" % (request.robot, robots))
        place = pose.x, pose.y, pose.theta
        if not all(map(math.isfinite, place)):
            return CarryResponse(False, "x %g, y %g, heading %g is no place: give numbers" % place)
        return CarryResponse(*self._order("put", robot=request.robot or 1, pose=place))

    def _pause(self, request: Any) -> SetBoolResponse:
        return SetBoolResponse(*self._order("pause" if request.data else "go_on"))

    def _reset(self, request: Any) -> TriggerResponse:
        with self._server.lock:     # the cans that are carried back were not pushed
            done = self._order("reset")
            self._shoves = ShoveWatch(self._simulation.world.cans)
        return TriggerResponse(*done)


def map_message(world: World, frame: str) -> OccupancyGrid:
    """Return the world as an occupancy grid in the coordinate frame `frame`."""
    (cells, (x, y)), now = world.occupancy(MAP_RESOLUTION), rospy.Time.now()
    return OccupancyGrid(
        Header(stamp=now, frame_id=frame),
        MapMetaData(now, MAP_RESOLUTION, cells.shape[1], cells.shape[0], pose_message(x, y, 0.0)),
        cells.ravel().tolist())


def world_markers(world: World, frame: str) -> MarkerArray:
    """Return markers for walls (upright rectangles) and posts (cylinders), on a map or not, which never move."""
    unmapped = [wall for each in world.unmapped for wall in each.walls], [
        post for each in world.unmapped for post in each.posts]
    return MarkerArray([
        *wall_markers("wall", world.walls, frame), *post_markers("post", world.posts, frame),
        *wall_markers("unmapped", unmapped[0], frame), *post_markers("unmapped post", unmapped[1], frame)])


def wall_markers(kind: str, walls: Iterable[Sequence[float]], frame: str) -> List[Marker]:
    """Return one marker for all walls of a kind, as a list, which is empty if there is no wall."""
    upright = marker(frame, kind, 0, Marker.TRIANGLE_LIST, Pose(orientation=LEVEL), (1.0, 1.0, 1.0))
    for x1, y1, x2, y2 in walls:
        low, high = (Point(x1, y1, 0.0), Point(x2, y2, 0.0)), (Point(x1, y1, WALL_HEIGHT), Point(x2, y2, WALL_HEIGHT))
        upright.points += [low[0], low[1], high[1], low[0], high[1], high[0]]
    return [upright] * bool(upright.points)


def post_markers(kind: str, posts: Iterable[Sequence[float]], frame: str, height: float = WALL_HEIGHT) -> List[Marker]:
    """Return a marker for each post ``x, y, radius`` of a kind."""
    return [marker(frame, kind, number, Marker.CYLINDER, Pose(Point(x, y, height / 2.0), LEVEL),
                   (2.0 * radius, 2.0 * radius, height)) for number, (x, y, radius) in enumerate(posts)]


def moving_markers(simulation: Simulation, frame: str) -> MarkerArray:
    """Return markers for everything that moves: cans and people as cylinders, gripper paddles as boxes, and outlines of
    robots.
    """
    markers = [
        marker(frame, "can", number, Marker.CYLINDER, Pose(Point(x, y, z + can.height / 2.0), LEVEL),
               (2.0 * can.radius, 2.0 * can.radius, can.height))
        for number, (can, (x, y, z)) in enumerate((can, can_place(can)) for can in simulation.world.cans)]
    people = [(*person.pose[:2], person.reach) for person in simulation.people]
    markers += post_markers("person", people, frame, PERSON_HEIGHT)
    for number, robot in enumerate(simulation.robots):
        corners = [compose(robot.true_pose, (x, y, 0.0)) for x, y in robot.model.outline(False)]
        markers.append(marker(
            frame, "outline", number, Marker.LINE_STRIP, Pose(orientation=LEVEL), (0.01, 0.0, 0.0),
            [Point(x, y, 0.01) for x, y, _ in corners + corners[:1]]))
        if robot.gripper is not None:
            markers += paddle_markers(robot, robot.gripper, number, frame)
    return MarkerArray(markers)


def paddle_markers(robot: Firmware, gripper: ParallelGripper, number: int, frame: str) -> List[Marker]:
    """Return markers for the two paddles of a robot's gripper, at their present places.

    `number` is the number of the robot (from 0), from which the ids of the markers are made.
    """
    shape = gripper.shape
    ahead = robot.model.length_front + shape.paddle_start + shape.paddle_length / 2.0
    aside = (gripper.opening + shape.paddle_thickness) / 2.0
    poses = [pose_message(*compose(robot.true_pose, (ahead, side, 0.0)), gripper.height + PADDLE_HEIGHT / 2.0)
             for side in (aside, -aside)]
    size = shape.paddle_length, shape.paddle_thickness, PADDLE_HEIGHT
    return [marker(frame, "paddle", 2 * number + side, Marker.CUBE, pose, size) for side, pose in enumerate(poses)]


def marker(
    frame: str, kind: str, number: int, shape: int, pose: Pose, size: Tuple[float, float, float],
    points: Sequence[Point] = (),
) -> Marker:
    """Return one marker. It has no stamp, so that RViz uses the newest transform.

    Args:
        frame: coordinate frame of the marker.
        kind: namespace of the marker, and key of its colour in `COLOURS`.
        number: id of the marker within its namespace.
        shape: type of the marker, a constant of `Marker`.
        pose: pose of the marker.
        size: scale of the marker (m) along x, y and z.
        points: points of a line or a triangle list (m).
    """
    return Marker(header=Header(frame_id=frame), ns=kind, id=number, type=shape, action=Marker.ADD, pose=pose,
                  scale=Vector3(*size), color=COLOURS[kind], points=list(points))


def pose_message(x: float, y: float, heading: float, z: float = 0.0) -> Pose:
    """Return a Pose message from x, y (m), heading (rad) and height z (m), with roll and pitch 0."""
    return Pose(Point(x, y, z), Quaternion(*quaternion_of(heading)))


if __name__ == "__main__":
    sys.exit(main())

"""Bags for tests: messages of any package name with our definitions, runs of invented robots, and damaged bags."""

import functools
import math
import pathlib

import genpy
import genpy.dynamic
import rosbag
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point32, Pose, Pose2D, PoseArray, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Header, String

MESSAGES = pathlib.Path(__file__).resolve().parents[3] / "msg"
STANDARD = {"Header": Header, "geometry_msgs/Pose2D": Pose2D, "geometry_msgs/Point32": Point32}
SQUARE = [(0.36, -0.2), (0.36, 0.2), (-0.3, 0.2), (-0.3, -0.2)]


@functools.lru_cache(maxsize=None)
def message_class(name, package="pioneer_control"):
    """Return a message class with the definition of ours under any package's name, as an old bag has it."""
    text = (MESSAGES / ("%s.msg" % name)).read_text()
    parts = [text]
    for field in (line.split("#")[0].split() for line in text.splitlines()):
        kind = field[0].replace("[]", "") if field else ""
        if (MESSAGES / ("%s.msg" % kind)).exists():
            parts.append("MSG: %s/%s\n" % (package, kind) + (MESSAGES / ("%s.msg" % kind)).read_text())
        elif kind == "geometry_msgs/Polygon":
            parts += ["MSG: geometry_msgs/Polygon\nPoint32[] points",
                      "MSG: geometry_msgs/Point32\n" + Point32._full_text]
        elif kind in STANDARD:
            full = "std_msgs/Header" if kind == "Header" else kind
            parts.append("MSG: %s\n" % full + STANDARD[kind]._full_text)
    whole_name, definition = "%s/%s" % (package, name), ("\n" + "=" * 80 + "\n").join(parts)
    return genpy.dynamic.generate_dynamic(whole_name, definition)[whole_name]


def odometry(x, y, heading, frame="odom", linear=0.0, angular=0.0):
    """An Odometry message at a pose, with velocities (m/s, rad/s)."""
    message = Odometry()
    message.twist.twist.linear.x, message.twist.twist.angular.z = linear, angular
    message.header.frame_id = frame
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
    return message


def sonar(ranges, package="pioneer_control"):
    """A SonarArray message."""
    return message_class("SonarArray", package)(ranges_count=len(ranges), ranges=list(ranges))


def gripper(state, held, package="pioneer_control", pressed=None):
    """A GripperState message.

    Args:
        state: GripState.state.
        held: whether something is held.
        pressed: whether both paddles press; None: when something is held.
    """
    message = message_class("GripperState", package)()
    message.grip.state = state
    message.grip.left_contact = message.grip.right_contact = held if pressed is None else pressed
    message.grip.inner_beam = held
    return message


def ptz(pan, zoom, package="pioneer_control"):
    """A PTZState message (degrees to the right, zoom steps)."""
    return message_class("PTZState", package)(pan=pan, zoom=zoom)


def twist(linear, angular=0.0):
    """A Twist message: what cmd_vel takes (m/s, rad/s)."""
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    return message


def battery(voltage, package="pioneer_control"):
    """A BatteryState message of p2os's kind."""
    return message_class("BatteryState", package)(voltage=voltage)


def motors(state, package="pioneer_control"):
    """A MotorState message: 1 on, 0 off."""
    return message_class("MotorState", package)(state=state)


def stall(left, right):
    """A Stall message."""
    return message_class("Stall")(left=left, right=right)


def bumpers(front=(), rear=()):
    """A Bumpers message: whether each segment is pressed."""
    return message_class("Bumpers")(front=list(front), rear=list(rear))


def diagnostics(node="pioneer/p2os", **tasks):
    """A DiagnosticArray message of a driver: task=(level, text)."""
    return DiagnosticArray(status=[DiagnosticStatus(level=level, name="%s: %s" % (node, task), message=text)
                                   for task, (level, text) in tasks.items()])


def log(level, node, text):
    """A Log message of /rosout: Log.WARN, Log.ERROR, ..."""
    return Log(level=level, name=node, msg=text)


def decision(stamp, reason, wander=1, seed=0, speed=0.1, linear=0.1, angular=0.0):
    """A Decision message on the sonar message of a stamp (s)."""
    header = Header(stamp=genpy.Time.from_sec(stamp))
    return message_class("Decision")(
        header=header, wander=wander, seed=seed, speed=speed, linear=linear, angular=angular, reason=reason)


def robot_info(transducers):
    """A RobotInfo message of a square robot with transducers {number: (x, y, heading)}."""
    message = message_class("RobotInfo")(type="Pioneer", subtype="p3dx-sh", has_gripper=True)
    message.sonar_numbers = list(transducers)
    message.sonar_poses = [Pose2D(*pose) for pose in transducers.values()]
    message.footprint.points = [Point32(x, y, 0.0) for x, y in SQUARE]
    return message


def scans(name="pioneer", seconds=10, rate=5):
    """Yield (topic, message, seconds) of a laser on a robot. Some rays found nothing, some were dazzled."""
    for step in range(seconds * rate + 1):
        time = 1000.0 + step / rate
        ranges = [1.0 + 0.01 * index for index in range(179)] + [math.inf, math.nan]
        yield "/%s/scan" % name, LaserScan(
            Header(stamp=genpy.Time.from_sec(time - 0.1), frame_id="laser"), -math.pi / 2, math.pi / 2,
            math.radians(1.0), 0.0, 0.2, 0.05, 8.183, ranges, []), time


def cans(*positions):
    """A PoseArray message of cans at (x, y, height lifted)."""
    message = PoseArray()
    for x, y, z in positions:
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = x, y, z
        message.poses.append(pose)
    return message


def room(width, depth, resolution=0.05):
    """An OccupancyGrid message: walls round a rectangle whose inner lower left corner is at (0, 0)."""
    message = OccupancyGrid()
    columns, rows = round(width / resolution) + 2, round(depth / resolution) + 2
    message.info.resolution, message.info.width, message.info.height = resolution, columns, rows
    message.info.origin.position.x = message.info.origin.position.y = -resolution
    message.info.origin.orientation.w = 1.0
    wall, inside = [100] * columns, [100] + [0] * (columns - 2) + [100]
    message.data = wall + inside * (rows - 2) + wall
    return message


def write_bag(path, messages, compression="none", latched=()):
    """Write a bag of (topic, message, seconds). The topics in ``latched`` were published as latched."""
    with rosbag.Bag(str(path), "w", compression=compression) as bag:
        for topic, message, seconds in messages:
            header = dict(topic=topic, type=message._type, md5sum=message._md5sum,
                          message_definition=message._full_text)
            header["latching"] = "1" if topic in latched else "0"
            bag.write(topic, message, genpy.Time.from_sec(seconds), connection_header=header)
    return str(path)


def driven(start=(1.0, 1.0, 0.0), seconds=10, speed=0.1, name="pioneer", drift=0.0):
    """Yield (topic, message, seconds) of a robot that drives straight on in a room, picks up a can and puts it down.

    ``drift`` is how far (m) its odometry falls short for each metre driven.
    """
    topic = "/%s/%%s" % name if name else "/%s"
    begin = 1000.0
    yield topic % "robot_info", robot_info({0: (0.0, 0.1, math.pi / 2), 3: (0.2, 0.0, 0.0)}), begin
    yield topic % "map", room(8.0, 6.0), begin
    yield topic % "world", String("tutorial"), begin
    yield topic % "cans", cans((2.0, 1.0, 0.0), (5.0, 4.0, 0.0)), begin
    for step in range(seconds * 10 + 1):
        time, way = begin + 0.1 * step, 0.1 * step * speed
        x, y = start[0] + way * math.cos(start[2]), start[1] + way * math.sin(start[2])
        yield topic % "pose", odometry(way * (1 - drift), 0.0, 0.0, linear=speed * (1 - drift)), time
        yield topic % "ground_truth", odometry(x, y, start[2], "map"), time
        yield topic % "sonar", sonar([6.0 - 0.1 - y, 0.0, 5.0, min(8.0 - 0.2 - x, 5.0)]), time
        closed = seconds * 5 <= step < seconds * 8
        yield topic % "gripper_state", gripper(2 if closed else 1, closed), time
    yield topic % "cans", cans((x + 0.3, y, 0.0), (5.0, 4.0, 0.0)), time


def eventful(name="pioneer", seconds=20):
    """Yield (topic, message, seconds) of a `driven` robot that meets every kind of event that a Run has. The run begins
    at 1000 s.
    """
    topic, begin = "/%s/%%s" % name, 1000.0
    told = {topic % "pose", topic % "sonar", topic % "gripper_state"}
    yield from (entry for entry in driven(name=name, seconds=seconds) if entry[0] not in told
                or not begin + 6 < entry[2] < begin + 8)
    yield topic % "recording", String("robots: [%s]" % name), begin
    yield topic % "e_stop", Bool(False), begin
    yield topic % "e_stop", Bool(True), begin + 12
    yield topic % "e_stop", Bool(False), begin + 13
    yield "/rosout", log(Log.INFO, "/%s/p2os" % name, "connected"), begin
    yield "/rosout", log(Log.WARN, "/%s/simulator" % name, "simulated 6.000 s: fault begins: silence"), begin + 6
    yield "/rosout", log(Log.ERROR, "/%s/p2os" % name, "no link: nothing came for 1.5 s"), begin + 7.5
    for step in range(seconds * 10 + 1):
        time, since = begin + 0.1 * step, 0.1 * step
        silent = 6 < since < 8
        speed = 0.1 if since < seconds / 2 else 0.0
        yield topic % "cmd_vel", twist(speed, 0.2 * (since > seconds / 2)), time
        if silent:
            continue
        yield topic % "battery_state", battery(12.8 - 0.02 * since), time
        yield topic % "motor_state", motors(int(not 12 <= since < 15)), time
        yield topic % "stall", stall(10 <= since < 11, 10.5 <= since < 11), time
        yield topic % "bumpers", bumpers([False, 10 <= since < 11], [False]), time
        yield topic % "decision", decision(time, "forward" if since < 5 else "turning left: 0.3 m ahead"), time
    for since in range(seconds + 1):
        link = (2, "no link: silent") if since == 7 else (0, "connected")
        motor = (1, "the STOP button is pressed") if since == 12 else (0, "motors are on")
        yield "/diagnostics", diagnostics("%s/p2os" % name, Link=link, Motors=motor), begin + since + 0.05


def unclosed(path, messages, compression="none", chunk=4096):
    """Write (topic, message, seconds) to a bag like that of a killed recorder: without an index, and without the length
    of the last chunk. Returns its path.
    """
    writer = rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=chunk)
    for topic, message, seconds in messages:
        writer.write(topic, message, genpy.Time.from_sec(seconds))
    writer.flush = writer._stop_writing = lambda *_: None
    writer._file.flush()
    content = pathlib.Path(path).read_bytes()
    writer._file.close()
    writer._file = None
    pathlib.Path(path).write_bytes(content)
    return str(path)


def cut(path, length):
    """Cut a file off after so many bytes, or after a share of it (a float)."""
    content = pathlib.Path(path).read_bytes()
    pathlib.Path(path).write_bytes(content[:int(length * len(content)) if isinstance(length, float) else length])
    return str(path)


def overwritten(path, position, with_):
    """Overwrite some bytes of a file."""
    content = pathlib.Path(path).read_bytes()
    pathlib.Path(path).write_bytes(content[:position] + with_ + content[position + len(with_):])
    return str(path)

"""Converts the values of navigation to ROS messages, and back. Pure: no node, no clock."""

import math
from typing import Any, Iterable, Optional, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import (Point, Point32, Polygon, PolygonStamped, Pose2D, PoseArray, PoseStamped,
                               PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Transform, TransformStamped,
                               Vector3)
from geometry_msgs.msg import Pose as PoseMessage
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from std_msgs.msg import Header

from ...errors import UsageError
from ...floor_poses import Pose, compose, relative
from ...maps import GridMap
from ...message_values import heading_of, quaternion_of
from ...robots import Transducer
from ..values import LaserSweep
from ..values import Point as Place

LEAST_SPREAD = 0.05
"""Smallest standard deviation (m, rad) of a pose that somebody tells: nobody knows it more exactly."""
LEVEL = math.cos(math.radians(6.0))
"""Cosine of the angle by which a laser may lean: at 8 m its rays are then 0.8 m too high or too low."""
FARTHEST_MOUNT = 10.0
"""Farthest (m) that a laser may be from the middle of its robot: no robot is larger."""
FARTHEST_RANGE = 1000.0
"""A range (m) beyond this is none, whatever a scan says of its limits: no laser of a robot measures it."""
MOST_RAYS = 4000
"""Most ranges of a scan: more would take too long, and no laser of a robot has them."""
FULL_TURN = 2.0 * math.pi + 0.1
"""Widest scan (rad)."""
LONGEST_SCAN = 1.0
"""Longest time (s) from the first ray of a scan to its last."""
UPRIGHT = 0.1
"""How far the length of a quaternion may differ from 1; RViz and programs send unit quaternions."""


def pose_message(pose: Pose) -> PoseMessage:
    """Return a pose on the floor as a message."""
    return PoseMessage(Point(pose.x, pose.y, 0.0), Quaternion(*quaternion_of(pose.heading)))


def pose_of(message: PoseMessage) -> Pose:
    """Return a pose on the floor. Height, roll and pitch do not count.

    Raises:
        UsageError: a number is not finite, or the orientation is no rotation.
    """
    place, turn = message.position, message.orientation
    numbers = (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, numbers)):
        raise UsageError("a pose must have finite numbers, not (%s)" % ", ".join("%.4g" % each for each in numbers))
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)     # squares may overflow
    if abs(length - 1.0) > UPRIGHT:
        raise UsageError("the orientation (%g, %g, %g, %g) has the length %.3g: it must be a unit quaternion"
                         % (turn.x, turn.y, turn.z, turn.w, length))
    return Pose(place.x, place.y, heading_of(*(part / length for part in (turn.x, turn.y, turn.z, turn.w))))


def pose_of_transform(transform: Any) -> Pose:
    """Return where a geometry_msgs/Transform of tf places a frame on the floor."""
    turn = transform.rotation
    return Pose(transform.translation.x, transform.translation.y, heading_of(turn.x, turn.y, turn.z, turn.w))


def mount_of(transform: Any) -> Tuple[Pose, bool]:
    """Return where a geometry_msgs/Transform places a laser on its robot, and whether it is upside down there.

    A laser that is upside down, and says so in tf, measures clockwise.

    Raises:
        UsageError: it looks up or down: then it meets no walls, or the floor. Or its place is not on a robot.
    """
    turn, place = transform.rotation, transform.translation
    if not (math.isfinite(place.x) and math.isfinite(place.y)):
        raise UsageError("the place of the laser must be finite, not (%g, %g)" % (place.x, place.y))
    if math.hypot(place.x, place.y) > FARTHEST_MOUNT:
        raise UsageError("the place of the laser, (%g, %g), is more than %g m from its robot"
                         % (place.x, place.y, FARTHEST_MOUNT))
    up = 1.0 - 2.0 * (turn.x * turn.x + turn.y * turn.y)        # z of the laser's z axis
    if not abs(up) >= LEVEL:        # also if it is not a number
        raise UsageError("the laser leans by %.0f degrees: only one that looks along the floor is of use"
                         % math.degrees(math.acos(min(1.0, abs(up)))))
    ahead = (1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z), 2.0 * (turn.x * turn.y + turn.z * turn.w))
    return Pose(place.x, place.y, math.atan2(ahead[1], ahead[0])), bool(up < 0.0)


def sweep_of(message: Any, mount: Pose, upside_down: bool, offset: float) -> LaserSweep:
    """Return a sensor_msgs/LaserScan as what a laser measured. Ranges beyond its limits are none (REP 117).

    Args:
        message: the scan.
        mount: where the laser is on the robot.
        upside_down: it is upside down there.
        offset: what to add to its stamp for its time (s).

    Raises:
        UsageError: its numbers do not fit together, or are not finite.
    """
    ranges = np.asarray(message.ranges, dtype=np.float32)
    first, step, count = message.angle_min, message.angle_increment, len(ranges)
    numbers = {"angle_min": first, "angle_max": message.angle_max, "angle_increment": step,
               "time_increment": message.time_increment}
    for name, value in numbers.items():
        if not math.isfinite(value):
            raise UsageError("%s of a scan is %g: it must be a finite number" % (name, value))
    if not 2 <= count <= MOST_RAYS or not 0.0 < abs(step) * (count - 1) <= FULL_TURN:
        raise UsageError("a scan has %d ranges, %g rad apart: it must have 2 to %d, within one turn"
                         % (count, step, MOST_RAYS))
    if abs(first + (count - 1) * step - message.angle_max) > 1.5 * abs(step):
        raise UsageError("a scan has %d ranges, but from angle_min %.4g to angle_max %.4g in steps of %.4g there are %d"
                         % (count, first, message.angle_max, step, round((message.angle_max - first) / step) + 1))
    duration = message.time_increment * (count - 1)
    if not 0.0 <= duration <= LONGEST_SCAN:
        raise UsageError("a scan says that it took %.3g s (time_increment %.3g): from 0 to %g are legal"
                         % (duration, message.time_increment, LONGEST_SCAN))
    if not message.range_min < message.range_max:       # also if one is not a number
        raise UsageError("a scan has range_min %g and range_max %g: the second must be more"
                         % (message.range_min, message.range_max))
    with np.errstate(invalid="ignore"):
        ranges = np.where(ranges < max(message.range_min, 0.0), np.nan, ranges)
        ranges = np.where(ranges > min(message.range_max, FARTHEST_RANGE), np.inf, ranges)
    side = -1.0 if upside_down else 1.0
    return LaserSweep(message.header.stamp.to_sec() + offset, duration, mount, side * first, side * step, ranges)


def odom_on_map(pose: Pose, odometry: Pose, frame: str, odom_frame: str, stamp: Any) -> TransformStamped:
    """Return for tf where the frame of odometry is on the map, of a robot with a pose there and one by odometry."""
    origin = compose(pose, relative(odometry, Pose(0.0, 0.0, 0.0)))
    return TransformStamped(header_of(frame, stamp), odom_frame, Transform(
        Vector3(origin.x, origin.y, 0.0), Quaternion(*quaternion_of(origin.heading))))


def body_of(info: Any) -> Tuple[Tuple[Transducer, ...], Tuple[Place, ...]]:
    """Return the transducers of the robot that a RobotInfo tells of, and the corners (m; robot's frame) of its outline.
    """
    return (tuple(Transducer(number, pose.x, pose.y, pose.theta)
                  for number, pose in zip(info.sonar_numbers, info.sonar_poses)),
            tuple((corner.x, corner.y) for corner in info.footprint.points))


def pose2d(pose: Pose) -> Pose2D:
    """Return a pose on the floor as a Pose2D message."""
    return Pose2D(pose.x, pose.y, pose.heading)


def header_of(frame: str, stamp: Any) -> Header:
    """Return a header."""
    return Header(frame_id=frame, stamp=stamp)


def pose_with_covariance(pose: Pose, covariance: Any, frame: str, stamp: Any) -> PoseWithCovarianceStamped:
    """Return a pose and its covariance (3 x 3 array of x, y and heading; m, rad) as a message."""
    (xx, xy, xh), (yx, yy, yh), (hx, hy, hh) = covariance.tolist()
    whole = [xx, xy, 0.0, 0.0, 0.0, xh, yx, yy, 0.0, 0.0, 0.0, yh] + [0.0] * 18 + [hx, hy, 0.0, 0.0, 0.0, hh]
    return PoseWithCovarianceStamped(header_of(frame, stamp), PoseWithCovariance(pose_message(pose), whole))


def spread_of(covariance: Sequence[float]) -> Tuple[float, float]:
    """Return standard deviations of place (m) and heading (rad) of a message's covariance (36 numbers).

    They are `LEAST_SPREAD` at least, and half a turn at most.

    Raises:
        UsageError: a variance is negative or not finite.
    """
    variances = covariance[0], covariance[7], covariance[35]
    if not all(math.isfinite(variance) and variance >= 0.0 for variance in variances):
        raise UsageError("the variances (%.4g, %.4g, %.4g) must be finite, and 0 or more" % variances)
    place, heading = math.sqrt(max(variances[:2])), math.sqrt(variances[2])
    return max(LEAST_SPREAD, place), min(max(LEAST_SPREAD, heading), math.pi)


def check_on_map(pose: Pose, grid: GridMap, name: str) -> None:
    """Check that a pose lies within the bounds of a map. Raises UsageError with its `name` for people if not."""
    left, bottom, right, top = grid.bounds
    if not (left <= pose.x <= right and bottom <= pose.y <= top):
        raise UsageError("%s (%.4g, %.4g) lies outside of the map, which has x from %.2f to %.2f and y from %.2f to"
                         " %.2f" % (name, pose.x, pose.y, left, right, bottom, top))


def check_start(pose: Pose, spread: float, grid: GridMap) -> None:
    """Check that a robot may be where somebody says, with a standard deviation of the place (m).

    Raises:
        UsageError: that is not on the map, or tells nothing about where on the map.
    """
    check_on_map(pose, grid, "the place")
    left, bottom, right, top = grid.bounds
    size = math.hypot(right - left, top - bottom)
    if spread > size:
        raise UsageError("a standard deviation of %.4g m is more than the size of the map, %.1f m: the service"
                         " global_localization says that the robot may be anywhere" % (spread, size))


def cloud_message(particles: Any, most: int, frame: str, stamp: Any) -> PoseArray:
    """Return particles, an array (n, 3) of x, y (m) and heading (rad), as at most `most` poses.

    Of more, each second, third and so on is taken: RViz and the page stay quick, and bags small.
    """
    some = particles[::max(1, math.ceil(len(particles) / most))].tolist()
    return PoseArray(header_of(frame, stamp), [pose_message(Pose(*particle)) for particle in some])


def path_message(points: Iterable[Tuple[float, float]], frame: str, stamp: Any,
                 heading: Optional[float] = None) -> Path:
    """Return a path of points (m) as a message. Each pose heads to the next point, the last one to `heading` (rad)."""
    places = list(points)
    headings = [math.atan2(after[1] - before[1], after[0] - before[0]) for before, after in zip(places, places[1:])]
    last = [heading] if heading is not None else headings[-1:] or [0.0]
    poses = [Pose(x, y, ahead) for (x, y), ahead in zip(places, headings + last)]
    return Path(header_of(frame, stamp), [PoseStamped(header_of(frame, stamp), pose_message(pose)) for pose in poses])


def map_message(grid: GridMap, frame: str, stamp: Any) -> OccupancyGrid:
    """Return a map as a message."""
    rows, columns = grid.cells.shape
    return OccupancyGrid(
        header=header_of(frame, stamp),
        info=MapMetaData(map_load_time=stamp, resolution=grid.resolution, width=columns, height=rows,
                         origin=pose_message(Pose(grid.origin[0], grid.origin[1], 0.0))),
        data=grid.cells.ravel().tolist())


def footprint_message(outline: Iterable[Tuple[float, float]], frame: str, stamp: Any) -> PolygonStamped:
    """Return the outline of a robot, corners (m) in its own frame, as a message."""
    return PolygonStamped(header_of(frame, stamp), Polygon([Point32(x, y, 0.0) for x, y in outline]))

"""What navigation does with scans, and what it says of them, without a master."""

import pytest
from geometry_msgs.msg import Quaternion, Transform, Vector3
from rospy import Time
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from pioneer_control.errors import UsageError
from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.node import laser_watch
from pioneer_control.navigation.node.laser_watch import NO_LASER, LaserWatch
from pioneer_control.navigation.senses import Senses

LEVEL = Transform(Vector3(0.1, 0.0, 0.3), Quaternion(0.0, 0.0, 0.0, 1.0))
LEANS = Transform(Vector3(0.1, 0.0, 0.3), Quaternion(0.0, 0.7071, 0.0, 0.7071))


def scan(stamp, frame="laser", ranges=(1.0, 2.0, 3.0)):
    return LaserScan(header=Header(stamp=Time.from_sec(stamp), frame_id=frame), angle_min=-1.0, angle_max=1.0,
                     angle_increment=1.0, range_min=0.05, range_max=8.0, ranges=list(ranges))


class Robot:
    """A watch, and all around it."""

    def __init__(self, monkeypatch):
        self.now, self.frames, self.lines = 50.0, {"laser": LEVEL}, []
        monkeypatch.setattr(laser_watch, "monotonic", lambda: self.now)
        for level in ("logwarn", "loginfo"):
            monkeypatch.setattr(laser_watch.rospy, level, lambda text, *values: self.lines.append(text % values))
        self.senses = Senses([0])
        self.watch = LaserWatch(self.senses, self.place_of)
        self.packet(100.0)

    def place_of(self, frame):
        if frame not in self.frames:
            raise UsageError("nobody says where its frame %r is in 'base_link'" % frame)
        return self.frames[frame]

    def packet(self, time):
        self.senses.hear_sonar(time, [1.0])
        return self.senses.hear_pose(time, Pose(0.0, 0.0, 0.0))[0].scan

    def says(self, by_laser=True, makes_map=False):
        state = self.watch.state(by_laser, makes_map)
        self.watch.say(state)
        return state.text


@pytest.fixture
def robot(monkeypatch):
    return Robot(monkeypatch)


def test_without_a_laser_nothing_is_wrong(robot):
    assert robot.watch.state(False, False) == NO_LASER and not NO_LASER.trouble
    robot.says(False)
    assert not robot.lines


def test_scans_are_used_and_that_is_logged_once(robot):
    robot.watch.hear(scan(100.05, "/laser"), 0.0)       # tf2 has no names that begin with /
    assert robot.says(by_laser=False) == "not used yet"
    assert robot.packet(100.1).mount == pytest.approx((0.1, 0.0, 0.0))
    assert [robot.says(), robot.says()] == ["used", "used"] and robot.lines == ["laser: used"]


def test_when_scans_end_it_says_that_it_goes_on_by_sonar(robot):
    robot.watch.hear(scan(100.05), 0.0)
    robot.says()
    robot.now += 0.9
    assert robot.says() == "used"
    robot.now += 2.1
    assert robot.says(by_laser=False) == "no scan for 3.0 s: it goes on by sonar alone"
    assert robot.watch.state(False, False).trouble
    robot.now += 1.0
    robot.says(by_laser=False)
    robot.watch.hear(scan(104.0), 0.0)
    robot.says()
    assert [line.split(" for ")[0] for line in robot.lines] == ["laser: used", "laser: no scan", "laser: used"]


@pytest.mark.parametrize("frame, place, named", [
    ("camera", None, "nobody says where its frame 'camera' is"), ("", None, "no frame"),
    ("laser", LEANS, "leans by 90 degrees")])
def test_a_scan_whose_place_on_the_robot_is_not_known_is_left_out(robot, frame, place, named):
    if place is not None:
        robot.frames[frame] = place
    robot.watch.hear(scan(100.05, frame), 0.0)
    assert robot.packet(100.1) is None
    state = robot.watch.state(False, False)
    assert named in state.text and state.text.startswith("not used: ") and state.trouble


def test_a_scan_that_makes_no_sense_is_left_out_and_the_next_one_counts(robot):
    robot.watch.hear(scan(100.01, ranges=[1.0] * 9), 0.0)
    assert "9 ranges" in robot.says() and robot.packet(100.05) is None
    robot.watch.hear(scan(100.08), 0.0)
    assert robot.packet(100.1) is not None and robot.says() == "used"


def test_a_laser_that_sees_nothing_is_told(robot):
    for stamp in (99.9, 100.0):
        robot.watch.hear(scan(stamp, ranges=[float("nan")] * 3), 0.0)
    assert robot.says(by_laser=True) == "used", "a blind scan or two change nothing"
    assert robot.says(by_laser=False).startswith("not used: it sees next to nothing")
    assert robot.watch.state(False, False).trouble
    robot.watch.hear(scan(100.2), 0.0)
    assert robot.says(by_laser=False) == "not used yet"


def test_in_a_crowd_where_nobody_hears_tf_the_laser_is_where_it_was(robot):
    robot.watch.hear(scan(100.01), 0.0)
    robot.frames.clear()
    robot.watch.hear(scan(100.06), 0.0)
    assert robot.packet(100.1).mount == pytest.approx((0.1, 0.0, 0.0))
    robot.watch.hear(scan(100.2, "other"), 0.0)
    assert "'other'" in robot.says()


@pytest.mark.parametrize("stamp, named", [(95.0, "5.1 s older"), (200.0, "99.9 s newer")])
def test_stamps_of_another_clock_are_told(robot, stamp, named):
    robot.watch.hear(scan(stamp), 0.0)
    assert robot.packet(100.1) is None
    assert named in robot.says(by_laser=False) and "clocks" in robot.says(by_laser=False)


def test_scans_of_a_robot_whose_time_has_jumped_have_steady_times(robot):
    robot.watch.hear(scan(20.05), 80.0)
    assert robot.packet(100.1).time == pytest.approx(100.05)


def test_while_a_map_is_made_the_laser_is_not_used(robot):
    robot.watch.hear(scan(100.05), 0.0)
    state = robot.watch.state(False, True)
    assert state.text == "not used while a map is made" and not state.trouble

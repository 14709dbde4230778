"""Where a robot was, from a bag of p2os types: a simulated drive is written as an old bag, and located."""

import dataclasses
import math
import os
import re
import sys

import pytest
import rosbag
from genpy import Time
from geometry_msgs.msg import (PolygonStamped, PoseStamped, PoseWithCovarianceStamped, Quaternion, Transform,
                               TransformStamped)
from move_base_msgs.msg import MoveBaseActionGoal
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bags"))

import bag_factory as make

from pioneer_control import p2os
from pioneer_control.client.odometry import Odometry
from pioneer_control.floor_poses import Pose, compose
from pioneer_control.lms2xx import Variant
from pioneer_control.msg import Places
from pioneer_control.navigation.node import locate_bag
from pioneer_control.navigation.node.map_files import load_floor_map
from pioneer_control.navigation.node.messages import pose_of, pose_of_transform
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.lms200 import TYPICAL, Optics
from pioneer_control.simulator.lms200.ray_plans import complete_scan
from pioneer_control.simulator.world import load_world

MODEL = find_model("p3dx-sh")
LASER = Pose(0.02, 0.0, 0.0)
"""Where the laser sits (m, rad; base_link)."""
ROUND = [(0.25, 0.0)] * 60 + [(0.0, 30.0)] * 30 + [(0.25, 5.0)] * 60       # m/s and deg/s, 0.1 s each


@pytest.fixture(scope="module")
def old_bag(tmp_path_factory):
    """Return a bag of p2os with pose and sonar of a drive in the corridor, and the true pose at its end."""
    world = load_world("tutorial")
    firmware = Firmware(MODEL, world, world.starts[1], gripper=False)
    decoder, odometry = p2os.FrameDecoder(), Odometry(MODEL.dist_mm_per_unit, MODEL.angle_units_per_rev)
    for step in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2):
        firmware.receive(p2os.encode_frame(step))
    for command in (("OPEN",), ("ENABLE", 1), ("SONAR", 1)):
        firmware.receive(p2os.encode_command(*command))
    ranges, told, scan = [0.0] * 16, [], scanner(world)
    for linear, angular in ROUND:
        firmware.receive(p2os.encode_command("VEL", round(linear * 1000)))
        firmware.receive(p2os.encode_command("RVEL", round(angular)))
        for frame in decoder.feed(firmware.advance(0.1)):
            sip = p2os.decode_packet(frame)
            if not isinstance(sip, p2os.Sip):
                continue
            odometry.update(sip.x_counts, sip.y_counts, sip.heading_units)
            for reading in sip.sonar:
                ranges[reading.number] = reading.range_units * MODEL.range_mm_per_unit / 1000.0
            for topic, message in (("/old/pose", make.odometry(*odometry.pose)),
                                   ("/old/sonar", make.sonar(ranges, "p2os_msgs"))):
                message.header.stamp = Time.from_sec(1000.0 + firmware.time)
                told.append((topic, message, 1000.0 + firmware.time))
            told.append(("/old/scan", scan(Pose(*firmware.true_pose), 1000.0 + firmware.time), 1000.0 + firmware.time))
    path = make.write_bag(tmp_path_factory.mktemp("old") / "old.bag", told)
    return path, firmware.true_pose


def transform(parent, child):
    """Return a transform of then: it has no stamp, as those that are made have."""
    return TransformStamped(Header(frame_id=parent), child, Transform(rotation=Quaternion(0.0, 0.0, 0.0, 1.0)))


def scanner(world):
    """Return a function that returns the scan of a laser from a pose of the robot, at a time (s)."""
    optics, plan = Optics(world, dataclasses.replace(TYPICAL, bias=0.0), 1), complete_scan(Variant(180, 100))

    def scan(pose, time):
        mount = compose(pose, LASER)
        ranges = optics.measure(plan, time, lambda at: mount).distances
        return LaserScan(Header(stamp=Time.from_sec(time - 0.01), frame_id="laser"), plan.angles[0], plan.angles[-1],
                         math.radians(1.0), 0.0, 0.013, 0.05, 8.0, ranges.tolist(), [])

    return scan


def with_tf(path, target, *told):
    """Write a bag that has transforms, too: each a topic and a transform."""
    with rosbag.Bag(str(path)) as old, rosbag.Bag(str(target), "w") as new:
        for topic, message, time in old.read_messages():
            new.write(topic, message, time)
        for topic, transform in told:
            new.write(topic, TFMessage([transform]), time)
    return target


def run(*words):
    return locate_bag.main([str(word) for word in words])


def poses(path):
    with rosbag.Bag(str(path)) as bag:
        return [message for _, message, _ in bag.read_messages("/old/navigation")]


def test_an_old_bag_is_located_on_the_map(old_bag, tmp_path, capsys):
    path, truth = old_bag
    x, y, heading = load_world("tutorial").starts[1]
    assert run(path, tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh", "--start", x, y, heading) == 0
    told = poses(tmp_path / "new.bag")
    assert len(told) > 100 and told[-1].sure
    assert math.hypot(told[-1].pose.x - truth[0], told[-1].pose.y - truth[1]) < 0.15
    assert "sure of the pose in" in capsys.readouterr().out
    with rosbag.Bag(str(tmp_path / "new.bag")) as bag:
        frames = [message.transforms[0] for _, message, _ in bag.read_messages("/tf")]
        odometry = {message.header.stamp: message for _, message, _ in bag.read_messages("/old/pose")}
    assert [(each.header.frame_id, each.child_frame_id) for each in frames] == [("map", "odom")] * len(told)
    placed = compose(pose_of_transform(frames[-1].transform), pose_of(odometry[frames[-1].header.stamp].pose.pose))
    assert placed == pytest.approx((told[-1].pose.x, told[-1].pose.y, told[-1].pose.theta))
    with rosbag.Bag(str(tmp_path / "new.bag")) as bag:
        counts = {topic: info.message_count for topic, info in bag.get_type_and_topic_info().topics.items()}
        kinds = {topic: info.msg_type for topic, info in bag.get_type_and_topic_info().topics.items()}
    assert counts["/old/sonar"] == counts["/old/pose"] == counts["/old/navigation"] == counts["/old/amcl_pose"]
    assert counts["/old/map"] == 1 and counts["/old/particlecloud"] > 5
    assert counts["/old/robot_info"] == 1, "the report draws the robot and its echoes"
    assert kinds["/old/sonar"] == "p2os_msgs/SonarArray", "the old messages stay as they were"


def error_at_the_end(path, truth):
    """Return how far (m) the last pose that navigation told is from the true one."""
    told = poses(path)[-1].pose
    return math.hypot(told.x - truth[0], told.y - truth[1])


SEAT = transform("base_link", "seat"), transform("/seat", "/laser")     # over a frame between, and with old names
SEAT[1].transform.translation.x = LASER.x


@pytest.mark.parametrize("topics", [("/tf_static", "/tf_static"), ("/tf", "/tf_static")])
def test_scans_are_used_where_tf_says_where_the_laser_sits(old_bag, tmp_path, capsys, topics):
    path, truth = old_bag
    bag = with_tf(path, tmp_path / "scans.bag", *zip(topics, SEAT))
    where = "--map", "tutorial", "--model", "p3dx-sh"
    assert run(bag, tmp_path / "new.bag", *where) == 0
    said = capsys.readouterr()
    assert re.search(r"sure of the pose in \d\d %, by the laser in 9\d %", said.out) and "not used" not in said.err
    assert run(bag, tmp_path / "sonar.bag", *where, "--no-laser") == 0
    assert "by the laser" not in capsys.readouterr().out
    assert error_at_the_end(tmp_path / "new.bag", truth) < min(0.03, error_at_the_end(tmp_path / "sonar.bag", truth))


LEANING = transform("base_link", "laser")
LEANING.transform.rotation.y, LEANING.transform.rotation.w = math.sin(0.3), math.cos(0.3)


@pytest.mark.parametrize("told, reason", [
    ([], "nobody says in /tf or /tf_static where its frame 'laser' is in 'base_link'"),
    ([("/tf", transform("base_link", "seat"))], "where its frame 'laser' is"),
    ([("/other/tf", transform("base_link", "laser"))], "where its frame 'laser' is"),
    ([("/tf", LEANING)], "leans by 34 degrees"),
])
def test_scans_whose_laser_has_no_place_are_not_used_and_people_are_told(old_bag, tmp_path, capsys, told, reason):
    bag = with_tf(old_bag[0], tmp_path / "scans.bag", *told)
    assert run(bag, tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh") == 0
    said = capsys.readouterr()
    assert "the scans of the laser are not used: " in said.err and reason in said.err
    assert "by the laser" not in said.out and poses(tmp_path / "new.bag")[-1].sure


@pytest.mark.parametrize("name, value, reason", [
    ("angle_increment", 0.5, "a scan has 181 ranges, "),
    ("header", Header(stamp=Time(1001), frame_id="lidar"),
     "its frame is 'lidar', and that of the first scan was 'laser'"),
])
def test_scans_that_are_left_out_are_counted_and_people_are_told_why(old_bag, tmp_path, capsys, name, value, reason):
    bag, scans = with_tf(old_bag[0], tmp_path / "scans.bag", *zip(["/tf", "/tf"], SEAT)), 0
    with rosbag.Bag(str(bag)) as old, rosbag.Bag(str(tmp_path / "bad.bag"), "w") as new:
        for topic, message, time in old.read_messages():
            if topic == "/old/scan":
                scans += 1
                if scans > 2:
                    setattr(message, name, value)
            new.write(topic, message, time)
    assert run(tmp_path / "bad.bag", tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh") == 0
    assert "%d scans of the laser are not used; the first of them: %s" % (scans - 2, reason) in capsys.readouterr().err


def test_a_map_made_twice_of_a_bag_is_the_same(old_bag, tmp_path):
    for name in ("a", "b"):
        assert run(old_bag[0], tmp_path / (name + ".bag"), "--model", "p3dx-sh", "--save-map",
                   tmp_path / (name + ".yaml")) == 0
    first, second = (load_floor_map(str(tmp_path / (name + ".yaml"))).grid for name in ("a", "b"))
    assert first == second and (first.cells == 0).sum() * first.resolution ** 2 > 3.0


def test_an_older_map_of_that_name_is_kept(old_bag, tmp_path, capsys):
    (tmp_path / "lab.yaml").write_text("mine")
    assert run(old_bag[0], tmp_path / "new.bag", "--model", "p3dx-sh", "--save-map", tmp_path / "lab.yaml") == 0
    assert (tmp_path / "lab.1.yaml").read_text() == "mine" and "image" in (tmp_path / "lab.yaml").read_text()
    assert "the one before is kept in %s" % (tmp_path / "lab.1.yaml") in capsys.readouterr().out


@pytest.mark.parametrize("name, status, said", [
    ("lab.png", 2, "its name must end in .yaml"),
    ("nowhere/lab.yaml", 1, "cannot be written: No such file or directory; {} is written"),
])
def test_a_map_that_cannot_be_saved_is_told(old_bag, tmp_path, capsys, name, status, said):
    new = tmp_path / "new.bag"
    assert run(old_bag[0], new, "--model", "p3dx-sh", "--save-map", tmp_path / name) == status
    assert capsys.readouterr().err.endswith(said.format(new) + "\n")
    assert new.exists() == (status == 1), "a name that is not legal is told before the work"


def test_located_again_the_topics_are_made_anew(old_bag, tmp_path):
    run(old_bag[0], tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh")
    assert run(tmp_path / "new.bag", tmp_path / "again.bag", "--map", "tutorial", "--model", "p3dx-sh") == 0
    assert len(poses(tmp_path / "again.bag")) == len(poses(tmp_path / "new.bag"))
    with rosbag.Bag(str(tmp_path / "again.bag")) as bag:
        assert bag.get_message_count("/old/robot_info") == 1
        assert bag.get_message_count("/tf") == bag.get_message_count("/old/navigation")


def test_what_navigation_told_then_is_left_out(old_bag, tmp_path):
    path, bag = str(tmp_path / "then.bag"), rosbag.Bag(old_bag[0])
    with rosbag.Bag(path, "w") as then, bag:
        for topic, message, time in bag.read_messages():
            then.write(topic, message, time)
        for topic, message in (
                ("/old/plan", Path()), ("/old/places", Places()), ("/old/footprint", PolygonStamped()),
                ("/old/ground_truth", make.odometry(1.0, 2.0, 0.0)), ("/old/map", make.room(8.0, 6.0)),
                ("/old/move_base/goal", MoveBaseActionGoal()), ("/old/move_base_simple/goal", PoseStamped()),
                ("/old/initialpose", PoseWithCovarianceStamped()), ("/old/cmd_vel", make.twist(0.1)),
                ("/rosout", make.log(4, "/old/navigation", "lost")), ("/rosout", make.log(4, "/old/p2os", "slow")),
                ("/tf", TFMessage([transform("map", "odom"), transform("odom", "base_link")])),
                ("/tf", TFMessage([transform("map", "/odom")])), ("/tf", TFMessage([transform("map", "other/odom")])),
                ("/diagnostics", make.diagnostics("old/navigation", Navigation=(1, "lost"))),
                ("/diagnostics", make.diagnostics("old/p2os", Link=(1, "slow"))),
                ("/diagnostics", make.diagnostics("other/navigation", Navigation=(1, "lost")))):
            then.write(topic, message, time)
    assert run(path, tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh") == 0
    with rosbag.Bag(str(tmp_path / "new.bag")) as new:
        topics = new.get_type_and_topic_info().topics
        told = [each.name for _, message, _ in new.read_messages("/diagnostics") for each in message.status]
        (true,) = [message for _, message, _ in new.read_messages("/old/truth/map")]
        logged = [message.msg for _, message, _ in new.read_messages("/rosout")]
        frames = [each for _, message, _ in new.read_messages("/tf") for each in message.transforms]
    assert set(topics) == {"/diagnostics", "/rosout", "/tf"} | {"/old/" + name for name in (
        "pose", "sonar", "scan", "cmd_vel", "ground_truth", "truth/map", "map", "navigation", "amcl_pose",
        "particlecloud", "robot_info")}
    assert logged == ["slow"]
    assert [(each.header.frame_id, each.child_frame_id) for each in frames if not each.header.stamp] == [
        ("odom", "base_link"), ("map", "other/odom")]
    assert told == ["old/p2os: Link", "other/navigation: Navigation"]
    assert true.info.width == make.room(8.0, 6.0).info.width, "what was the map is that of the simulated world"
    assert topics["/old/map"].message_count == 1


@pytest.mark.parametrize("words, named", [
    (["--map", "tutorial"], "--model p3dx-sh"), (["--map", "tutoral", "--model", "p3dx-sh"], "did you mean 'tutorial'"),
    (["--map", "tutorial", "--model", "p9"], "p9"), (["--robot", "alice", "--model", "p3dx-sh"], "'alice' (old)"),
    (["--map", "tutorial", "--save-map", "x.yaml", "--model", "p3dx-sh"], "only without --map"),
])
def test_what_makes_no_sense_is_named_and_nothing_is_written(old_bag, tmp_path, capsys, words, named):
    assert run(old_bag[0], tmp_path / "new.bag", *words) == 2
    assert named in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_bag_that_is_there_is_kept(old_bag, tmp_path, capsys):
    (tmp_path / "new.bag").write_text("mine")
    assert run(old_bag[0], tmp_path / "new.bag", "--map", "tutorial", "--model", "p3dx-sh") == 2
    assert "exists already" in capsys.readouterr().err and (tmp_path / "new.bag").read_text() == "mine"

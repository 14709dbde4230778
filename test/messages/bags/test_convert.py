"""Bags of p2os are converted to bags with standard messages: new messages, kept messages, and damaged files."""

import dataclasses
import errno
import math
import pathlib
import subprocess
import sys

import genpy
import pytest
import rosbag
from geometry_msgs.msg import Pose, PoseArray, TransformStamped
from sensor_msgs.point_cloud2 import read_points
from std_msgs.msg import Header, String
from tf2_msgs.msg import TFMessage

import bag_factory as make
from old_messages import OLD_PACKAGES, VALUES, old_message, serialized
from pioneer_control import standard_messages
from pioneer_control.bags.converting import convert as command
from pioneer_control.bags.converting.convert import main
from pioneer_control.bags.converting.messages import (BEAMS, CONVERSIONS, DEFAULT, ROUND, SonarHistory, sonar_scan)
from pioneer_control.bags.reader import decode, read_bag
from pioneer_control.bags.writer import BagWriter
from pioneer_control.client import SonarRange
from pioneer_control.driver import conversions
from pioneer_control.msg import BatteryState
from pioneer_control.robots import find_model

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "driver"))

from robot_reports import STATE, identity_of, odometry_of, sonar_array_of

SONAR = find_model("p3dx-sh").sonar
ALL = tuple(CONVERSIONS)


def sonar_array(readings, package="p2os_msgs", frame="", stamp=0.0):
    """Return a SonarArray with 16 ranges. ``readings`` has {number of a transducer: range in m}. All others have no
    echo.
    """
    message = make.sonar([readings.get(number, 5.0) for number in range(16)], package)
    message.header.seq, message.header.frame_id, message.header.stamp = 7, frame, genpy.Time.from_sec(stamp)
    return message


def driven(package="p2os_msgs", frame="", begin=1000.0, name=""):
    """Yield (topic, message, seconds) of two seconds of a p2os robot that approaches a wall at 0.2 m/s."""
    for step in range(20):
        time = begin + step / 10
        pose = make.odometry(0.02 * step, 0.0, 0.0)
        pose.twist.twist.linear.x = 0.2
        yield "%s/pose" % name, pose, time
        sonar = sonar_array({3: 2.0 - 0.02 * step, 4: 2.0 - 0.02 * step, 7: 0.0}, package, frame)
        yield "%s/sonar" % name, sonar, time + 0.01
        yield "%s/battery_state" % name, make.message_class("BatteryState", package)(voltage=12.5), time + 0.02
        yield "%s/gripper_state" % name, make.gripper(1, False, package), time + 0.03
    yield "/others", String("kept"), time + 0.04


def read(path):
    """Return (topic, connection, bytes, time) of all messages."""
    reader = read_bag(str(path))
    return [tuple(message) for message in reader]


def made(path, topic):
    """Return the messages of a topic, with their times."""
    return [(decode(connection, data), time / 1e9) for found, connection, data, time in read(path) if found == topic]


@pytest.fixture
def bag(tmp_path):
    """Write messages to a bag and return its path."""
    return lambda messages, **options: make.write_bag(tmp_path / "old.bag", messages, **options)


@pytest.fixture
def converted(tmp_path, capsys):
    """Convert a bag. Returns the path of the new bag, the exit code, and the output."""
    def run(path, *arguments):
        code = main([str(path), str(tmp_path / "new.bag"), *arguments])
        said = capsys.readouterr()
        return str(tmp_path / "new.bag"), code, said.out + said.err
    return run


class TestKept:
    @pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
    def test_types_have_our_name_and_all_else_is_as_it_was(self, tmp_path, converted, compression):
        """Several publishers and types on one topic, latched messages, both old packages, ours, and an unknown type."""
        writer = BagWriter(str(tmp_path / "old.bag"), compression)
        messages = [old_message(name, package) for name in VALUES
                    for package in (*OLD_PACKAGES, "pioneer_control", "my_msgs")]
        messages += [String("said"), Header(frame_id="else")]
        connections = [writer.connect(topic, dict(
            callerid="/node_%s" % index, latching=str(index % 2), md5sum=message._md5sum,
            message_definition=message._full_text, topic=topic, type=message._type))
            for topic in ("/one", "/two") for index, message in enumerate(messages)]
        for count in range(3 * len(connections)):
            writer.write(connections[count % len(connections)], serialized(messages[count % len(messages)]),
                         10 ** 18 + count // 5)
        writer.close()
        path, code, said = converted(tmp_path / "old.bag", "types")
        assert code == 0 and "There was nothing" not in said
        before, after = read(tmp_path / "old.bag"), read(path)
        assert ([(topic, data, time) for topic, _, data, time in after]
                == [(topic, data, time) for topic, _, data, time in before])
        kinds = {"%s/%s" % (package, name): "pioneer_control/%s" % name for package in OLD_PACKAGES for name in VALUES}
        for (_, old, _, _), (_, new, _, _) in zip(before, after):
            assert new.type == kinds.get(old.type, old.type)
            same = set(old.header) - ({"type", "message_definition"} if old.type in kinds else set())
            assert {name: new.header[name] for name in same} == {name: old.header[name] for name in same}
            assert "pioneer_control" in new.type or new == old
        with rosbag.Bag(path) as bag:
            assert bag.get_compression_info().compression == compression

    def test_the_definition_is_the_messages_own(self, bag, converted):
        path, _, _ = converted(bag([("/grip", old_message("GripperState", "p2os_driver"), 1.0)]))
        (_, connection, data, _), = read(path)
        from pioneer_control import msg
        assert connection.definition == msg.GripperState._full_text and "p2os" not in connection.definition
        old = serialized(old_message("GripperState", "p2os_driver"))
        assert msg.GripperState().deserialize(data) == msg.GripperState().deserialize(old)

    def test_a_type_of_that_name_with_other_fields_is_left_alone(self, bag, converted):
        import genpy.dynamic
        other = genpy.dynamic.generate_dynamic("p2os_msgs/SonarArray", "int32 state\n")["p2os_msgs/SonarArray"](state=1)
        path, code, said = converted(bag([("/sonar", other, 1.0)]))
        found = [(topic, connection.type) for topic, connection, _, _ in read(path)]
        assert code == 0 and found == [("/sonar", "p2os_msgs/SonarArray")]
        assert "There was nothing to convert" in said

    def test_messages_that_contain_one_are_left_alone(self, bag, converted):
        import genpy.dynamic
        separator = "\n" + "=" * 80 + "\nMSG: p2os_msgs/MotorState\n"
        definition = "p2os_msgs/MotorState motors\n" + separator + "int32 state\n"
        mine = genpy.dynamic.generate_dynamic("my_msgs/Status", definition)["my_msgs/Status"]()
        path, _, _ = converted(bag([("/status", mine, 1.0)]))
        assert read(path)[0][1].definition == mine._full_text


class TestMade:
    def test_by_default_what_the_driver_offers_beside(self, bag, converted):
        old = bag(driven())
        path, code, said = converted(old, "--model", "p3dx-sh")
        assert code == 0
        new = {topic: connection.type for topic, connection, _, _ in read(path)}
        before = {topic: connection.type for topic, connection, _, _ in read(old)}
        added = {"/sonar_ranges", "/sonar_points", "/battery", "/tf_static", "/robot_info"}
        assert set(new) - set(before) == added and set(before) <= set(new)
        assert DEFAULT == ("types", "info", "ranges", "points", "battery")
        for line in ("renamed /sonar: 20 of p2os_msgs/SonarArray are pioneer_control/SonarArray",
                     "made    /battery: 20 of sensor_msgs/BatteryState from 20",
                     "made    /sonar_points: 20 of", "made    /tf_static: 1 of",
                     "kept    21 as they were, of /others, /pose"):
            assert line in said

    def test_what_is_made_says_what_the_driver_says(self, bag, converted):
        """The driver's conversions make messages from some states. From a bag with only their pose, sonar and
        battery_state, the converter makes the same sonar_ranges, sonar_points and battery as the driver.
        """
        states, heard = [], {}
        for step in range(12):
            time = 100.0 + step / 10
            for number in (step % 4, 8 + step % 4):     # their turn
                heard[number] = SonarRange(5.0 if step == 5 else 1.0 + 0.1 * number + 0.013 * step, time)
            sonar = tuple(heard.get(number) for number in range(16))
            states.append(dataclasses.replace(STATE, time=time, sonar=sonar, linear=0.3, angular=-0.5))
        stamps = [genpy.Time.from_sec(1000 + step / 10) for step in range(12)]
        messages = []
        for state, stamp in zip(states, stamps):
            for topic, message in (("pose", odometry_of(state, stamp, "two/odom", "two/base_link")),
                                   ("sonar", sonar_array_of(state, stamp, "two/base_link")),
                                   ("battery_state", BatteryState(Header(stamp=stamp, frame_id="two/base_link"),
                                                                  state.battery_voltage))):
                messages.append(("/two/%s" % topic, message, stamp.to_sec() + 0.001))
        path, _, _ = converted(bag(messages), "--model", "p3dx-sh", "points", "ranges", "battery")
        live = [reading for state, stamp in zip(states, stamps)
                for reading in conversions.sonar_ranges(state, stamp, "two/", math.inf)]
        ranges = [message for message, _ in made(path, "/two/sonar_ranges")]
        assert [serialized(message) for message in ranges] == [serialized(message) for message in live]
        clouds = [list(read_points(message)) for message, _ in made(path, "/two/sonar_points")]
        for state, stamp, cloud in zip(states, stamps, clouds):
            expected = list(read_points(conversions.sonar_points(state, stamp, "two/base_link", SONAR)))
            assert len(cloud) == len(expected)
            assert all(point == pytest.approx(other, abs=1e-5) for point, other in zip(cloud, expected))
        live = [conversions.battery(state, stamp, "two/base_link") for state, stamp in zip(states, stamps)]
        for (message, _), other in zip(made(path, "/two/battery"), live):
            other.power_supply_status = other.POWER_SUPPLY_STATUS_UNKNOWN      # battery_state does not tell
            assert serialized(message) == serialized(other)
        (frames, _), = made(path, "/tf_static")
        expected = standard_messages.sonar_frames(SONAR, stamps[0], "two/base_link", "two/")
        assert serialized(frames) == serialized(expected)

    def test_a_stamp_that_is_missing_is_the_bags_time_and_a_frame_that_is_missing_base_link(self, bag, converted):
        path, _, _ = converted(bag(driven()), "--model", "p3dx-sh")
        for topic, frame in (("/sonar_points", "base_link"), ("/battery", "base_link"), ("/sonar_ranges", None)):
            for message, time in made(path, topic):
                assert message.header.stamp.to_sec() == pytest.approx(time)
                assert frame is None or message.header.frame_id == frame
        assert {message.header.frame_id for message, _ in made(path, "/sonar_ranges")} == {
            "sonar_%s" % number for number in range(16) if number != 7}
        assert {message.header.seq for message, _ in made(path, "/sonar_ranges")} == {7}

    def test_a_stamp_and_a_frame_that_are_there_stay(self, bag, converted):
        path, _, _ = converted(bag([("/sonar", sonar_array({}, frame="/two/base_link", stamp=77.5), 1000.0)]),
                               "--model", "p3dx-sh")
        (cloud, _), = made(path, "/sonar_points")
        assert cloud.header.stamp.to_sec() == 77.5
        assert cloud.header.frame_id == "two/base_link", "tf2 knows no frame that begins with a slash"

    def test_publisher_latching_and_time_are_those_of_the_source(self, tmp_path, bag, converted):
        writer = BagWriter(str(tmp_path / "old.bag"))
        sonar = sonar_array({3: 1.0})
        fields = dict(type=sonar._type, md5sum=sonar._md5sum, message_definition=sonar._full_text, topic="/a/sonar",
                      callerid="/a/p2os", latching="0")
        writer.write(writer.connect("/a/sonar", fields), serialized(sonar), 123456789)
        writer.close()
        path, _, _ = converted(tmp_path / "old.bag", "--model", "p3dx-sh")
        found = {(topic, connection.caller, connection.latching, connection.header["topic"], time)
                 for topic, connection, _, time in read(path)}
        assert found == {(topic, "/a/p2os", topic in ("/tf_static", "/a/robot_info"), topic, 123456789)
                         for topic in ("/a/sonar", "/a/sonar_ranges", "/a/sonar_points", "/a/robot_info", "/tf_static")}

    @pytest.mark.parametrize("gripper", [False, True])
    def test_a_robot_of_a_model_says_so_as_the_driver_would(self, bag, converted, gripper):
        """The converter makes the robot_info that the driver would send, without what only the robot itself knows. Then
        the converted bag needs no --model any more.
        """
        path, code, said = converted(bag(driven(name="/alice")), "--model", "p2dx", "info",
                                     *(["--gripper"] if gripper else []), "--replace")
        (info, _), = made(path, "/alice/robot_info")
        live = conversions.robot_info(identity_of("p2dx", gripper=gripper), genpy.Time.from_sec(1000.01), "base_link")
        live.name = live.type = live.firmware = ""      # what the robot itself would tell
        assert serialized(info) == serialized(live) and (info.subtype, info.has_gripper) == ("p2dx", gripper)
        assert len(made(path, "/alice/sonar")) == 20, "nothing replaces it"
        assert main([path, path + "2", "points"]) == 0

    def test_odom_is_pose_byte_by_byte(self, bag, converted):
        path, code, said = converted(bag(driven()), "odom")
        pose, odom = ([(data, time) for topic, _, data, time in read(path) if topic == wanted]
                      for wanted in ("/pose", "/odom"))
        assert code == 0 and pose == odom and len(pose) == 20
        assert "made    /odom: 20 of nav_msgs/Odometry from 20 of /pose" in said

    def test_ground_truth_is_no_odom(self, bag, converted):
        path, _, said = converted(bag([("/ground_truth", make.odometry(0, 0, 0), 1.0)]), "odom")
        assert [topic for topic, *_ in read(path)] == ["/ground_truth"] and "There was nothing" in said

    def test_replaced(self, bag, converted):
        path, _, said = converted(bag(driven()), "battery", "odom", "--replace", "types")
        assert {topic for topic, *_ in read(path)} == {"/sonar", "/gripper_state", "/odom", "/battery", "/others"}
        assert "dropped /pose: 20, replaced" in said

    def test_a_robot_that_says_where_its_sonar_looks_needs_no_model(self, bag, converted):
        info = make.robot_info({3: (0.2, 0.0, 0.0), 4: (0.1, -0.1, -1.0)})
        messages = [*driven("pioneer_control", name="/alice"), ("/alice/robot_info", info, 1000.5)]
        path, code, said = converted(bag(messages), "points", "scan")
        cloud, _ = made(path, "/alice/sonar_points")[0]
        assert code == 0 and cloud.width == 2 and list(read_points(cloud))[0][:2] == pytest.approx((2.2, 0.0))
        assert "260 readings of transducers that the robot_info of the bag does not have were left out" in said

    def test_one_without_robot_info_beside_one_with(self, bag, converted):
        messages = [*driven("pioneer_control", name="/alice"),
                    ("/alice/robot_info", make.robot_info({3: (0.2, 0.0, 0.0)}), 1000.5), *driven(name="/bob")]
        old = bag(messages)
        path, code, said = converted(old, "points")
        assert code == 2 and "transducers of /bob/sonar look" in said
        path, code, said = converted(old, "points", "--model", "p3dx-sh")
        assert code == 0 and [made(path, "/%s/sonar_points" % name)[0][0].width for name in ("alice", "bob")] == [1, 2]

    def test_what_is_there_already_is_not_made_again(self, bag, converted):
        frames = TFMessage([TransformStamped(Header(), "sonar_%s" % number, None) for number in range(16)])
        messages = [*driven(), ("/battery", String("of somebody else"), 1000.0), ("/tf_static", frames, 1000.0)]
        path, _, said = converted(bag(messages), "--model", "p3dx-sh", "--replace")
        topics = [topic for topic, *_ in read(path)]
        assert (topics.count("/battery"), topics.count("/battery_state")) == (1, 20)
        assert (topics.count("/tf_static"), topics.count("/sonar")) == (1, 0)
        assert "/battery is in the bag already: it was not made" in said

    def test_frames_are_renamed_wherever_they_are(self, bag, converted):
        poses = PoseArray(Header(frame_id="odom"), [Pose()])
        tf = TFMessage([TransformStamped(Header(frame_id="odom"), "base_link", None),
                        TransformStamped(Header(frame_id="/map"), "/odom", None)])
        messages = [*driven(), ("/cans", poses, 1000.0), ("/tf", tf, 1000.0)]
        path, code, _ = converted(bag(messages), *ALL, "--model", "p3dx-sh", "--frame", "odom=one/odom", "--frame",
                                  "base_link=one/base_link")
        assert code == 0
        assert made(path, "/cans")[0][0].header.frame_id == "one/odom"
        renamed = [(each.header.frame_id, each.child_frame_id) for each in made(path, "/tf")[0][0].transforms]
        assert renamed == [("one/odom", "one/base_link"), ("/map", "one/odom")]
        assert made(path, "/odom")[0][0].header.frame_id == made(path, "/pose")[0][0].header.frame_id == "one/odom"
        assert made(path, "/sonar_scan")[0][0].header.frame_id == "one/base_link"
        assert {message.header.frame_id for message, _ in made(path, "/sonar_ranges")} == {
            "one/sonar_%s" % number for number in range(16) if number != 7}
        assert made(path, "/tf_static")[0][0].transforms[0].header.frame_id == "one/base_link"
        assert made(path, "/others")[0][0].data == "kept"

    def test_a_damaged_message_is_kept_and_nothing_made_of_it(self, tmp_path, converted):
        writer = BagWriter(str(tmp_path / "old.bag"))
        sonar = sonar_array({3: 1.0})
        header = dict(type=sonar._type, md5sum=sonar._md5sum, message_definition=sonar._full_text, topic="/sonar")
        connection = writer.connect("/sonar", header)
        writer.write(connection, serialized(sonar)[:20], 1)
        writer.write(connection, serialized(sonar), 2)
        writer.close()
        path, code, said = converted(tmp_path / "old.bag", "--model", "p3dx-sh", "--frame", "odom=other")
        assert code == 1 and "1 messages of /sonar are damaged" in said
        found = read(path)
        assert [(topic, len(data)) for topic, _, data, _ in found][0] == ("/sonar", 20)
        assert [topic for topic, *_ in found].count("/sonar_points") == 1


class TestSonar:
    def test_a_reading_is_new_when_it_changes_or_its_turn_has_come_again(self):
        history, left = SonarHistory(), SONAR[:2]
        ages = [[(reading.range, round(reading.age, 2)) for reading in history.readings(heard, left, time)]
                for heard, time in (([1.0, 2.0], 0.0), ([1.0, 1.9], 0.1), ([1.0, 1.9], 0.2), ([1.0, 1.9], ROUND),
                                    ([1.0, 1.8], 0.4))]
        assert ages == [[(1.0, 0), (2.0, 0)], [(1.0, 0.1), (1.9, 0)], [(1.0, 0.2), (1.9, 0.1)], [(1.0, 0), (1.9, 0.22)],
                        [(1.0, 0.08), (1.8, 0)]]

    @pytest.mark.parametrize("heard", [[0.0], [math.nan], [-1.0], []])
    def test_what_was_not_heard_is_no_reading(self, heard):
        assert SonarHistory().readings(heard, SONAR[:1], 0.0) == []

    def test_two_arrays_of_one_time_have_one_age(self):
        history = SonarHistory()
        history.readings([1.0], SONAR[:1], 0.0)
        assert [[reading.age for reading in history.readings([1.0], SONAR[:1], time)]
                for time in (0.1, 0.1)] == [[0.1], [0.1]]

    def test_what_is_heard_again_after_nothing_is_new(self):
        history = SonarHistory()
        heard = [history.readings([reading], SONAR[:1], time) for reading, time in ((1.0, 0.0), (0.0, 0.1), (1.0, 0.2))]
        assert [[reading.age for reading in each] for each in heard] == [[0.0], [], [0.0]]

    def test_time_that_jumps_back_begins_anew(self):
        history = SonarHistory()
        history.readings([1.0], SONAR[:1], 100.0)
        assert [reading.age for reading in history.readings([1.0], SONAR[:1], 50.0)] == [0.0]

    def test_scan(self):
        """There are echoes ahead and to the left, a sonar that looks behind has no echo, and to the right there is no
        reading.
        """
        scan = sonar_scan([(2.0, 0.0), (1.0, 0.0), (3.0, 0.0), (0.0, 1.5)], [SONAR[12]], SONAR, genpy.Time(1),
                          "base_link")
        angles = [scan.angle_min + index * scan.angle_increment for index in range(len(scan.ranges))]
        seen = {round(math.degrees(angle)): reading
                for angle, reading in zip(angles, scan.ranges) if not math.isnan(reading)}
        end_x = SONAR[12].x + 5 * math.cos(SONAR[12].heading)
        end_y = SONAR[12].y + 5 * math.sin(SONAR[12].heading)
        behind = math.degrees(math.atan2(end_y, end_x))
        assert seen == {0: 1.0, 90: 1.5, round(behind): math.inf}
        assert len(scan.ranges) == BEAMS and angles[-1] == pytest.approx(scan.angle_max)
        assert scan.range_max == pytest.approx(5.0 + math.hypot(0.255, 0.027))

    @pytest.mark.parametrize("degrees, beam",
                             [(180.0, 0), (-180.0, 0), (179.6, 0), (-179.4, 1), (0.4, 180), (0.6, 181), (-0.6, 179)])
    def test_an_echo_is_in_the_nearest_beam(self, degrees, beam):
        scan = sonar_scan([(2.0 * math.cos(math.radians(degrees)), 2.0 * math.sin(math.radians(degrees)))], [], SONAR,
                          genpy.Time(1), "base_link")
        assert [number for number, reading in enumerate(scan.ranges) if reading > 0] == [beam]

    def test_an_echo_counts_more_than_none(self):
        end = SONAR[0].x, SONAR[0].y + 5.0
        scan = sonar_scan([end], [SONAR[0]], SONAR, genpy.Time(1), "b")
        beam = [reading for reading in scan.ranges if not math.isnan(reading)]
        assert beam == [math.hypot(*end)]


class TestFiles:
    def test_arguments_that_make_no_sense(self, tmp_path, bag, converted):
        old = bag(driven())
        wrong = [
            (["sonar"], "'sonar' cannot be converted (legal: types, info, ranges, points, battery, scan, odom)"),
            (["--frame", "odom"], "--frame odom: not of the form OLD=NEW"),
            (["--frame", "=x"], "not of the form"),
            (["--gripper"], "--gripper says something of the robot that --model names: name it"),
            (["--gripper", "--model", "amigo-sh"], "--gripper: a model amigo-sh carries no gripper"),
            (["--model", "p3dx-hs"], "unknown robot model 'p3dx-hs' (near: p3dx-sh"),
            (["--model", "p3dx-sh", "--models-file", "/none"], "models file /none cannot be read"),
            ([], "does not say where the transducers of /sonar look"),
        ]
        for arguments, text in wrong:
            path, code, said = converted(old, *arguments)
            assert code == 2 and text in said and said.startswith("convert_bag: ") and not pathlib.Path(path).exists()
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["old.bag"]

    def test_files_that_make_no_sense(self, tmp_path, bag, capsys):
        old = bag(driven())
        (tmp_path / "there.bag").write_bytes(b"x")
        (tmp_path / "text.bag").write_bytes(b"hello")
        (tmp_path / "link.bag").symlink_to(old)
        wrong = [
            ("none.bag", "new.bag", "none.bag: no such file"),
            ("old.bag", "old.bag", "old.bag exists already"),
            ("old.bag", "link.bag", "link.bag exists already"),
            ("old.bag", "there.bag", "there.bag exists already"),
            ("old.bag", "none/new.bag", "none/new.bag cannot be written: No such file or directory"),
            ("text.bag", "new.bag", "text.bag is not a bag"),
            (".", "new.bag", "cannot be read"),
        ]
        for source, target, text in wrong:
            assert main([str(tmp_path / source), str(tmp_path / target), "types"]) == 2
            assert text in capsys.readouterr().err
        assert (tmp_path / "there.bag").read_bytes() == b"x" and not list(tmp_path.glob("new*"))

    def test_an_empty_bag(self, bag, converted):
        path, code, said = converted(bag([]))
        assert code == 0 and read(path) == [] and "There was nothing to convert" in said

    def test_a_bag_that_was_cut_off_as_far_as_it_goes(self, tmp_path, bag, converted):
        old = pathlib.Path(bag(driven()))
        whole = [(topic, data) for topic, _, data, _ in read(old)]
        with open(old, "r+b") as file:
            file.truncate(int(0.6 * old.stat().st_size))
        path, code, said = converted(old, "types")
        found = [(topic, data) for topic, _, data, _ in read(path)]
        assert code == 1 and "is missing" in said and "What could be read was converted" in said
        assert 10 < len(found) < len(whole) and found == whole[:len(found)]

    def test_a_bag_without_index(self, tmp_path, converted):
        path = str(tmp_path / "old.bag.active")
        writer = rosbag.Bag(path, "w", chunk_threshold=1)
        for topic, message, seconds in driven():
            writer.write(topic, message, genpy.Time.from_sec(seconds))
        writer._file.flush()
        new, code, said = converted(path, "--model", "p3dx-sh")
        writer.close()
        assert code == 1 and "was not closed" in said and len(made(new, "/sonar_points")) == 20

    @pytest.mark.parametrize("error, code, text", [
        (OSError(errno.ENOSPC, "No space left on device"), 2,
         "new.bag cannot be written: No space left on device. Nothing is left of it"),
        (KeyboardInterrupt(), 130, "interrupted; "),
    ])
    def test_what_ends_in_the_middle_leaves_nothing(self, monkeypatch, tmp_path, bag, converted, error, code, text):
        old, written = bag(driven()), []

        def write(self, connection, data, time):
            written.append(data)
            if len(written) > 10:
                raise error

        monkeypatch.setattr(command.BagWriter, "write", write)
        _, got, said = converted(old, "types")
        assert got == code and text in said and sorted(entry.name for entry in tmp_path.iterdir()) == ["old.bag"]

    def test_a_full_disk_when_the_last_is_written(self, monkeypatch, tmp_path, bag, converted):
        """A limit on the size of files takes the place of a full disk."""
        program = ("import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
                   "resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000));from "
                   "pioneer_control.bags.converting.convert import main; sys.exit(main(sys.argv[1:]))")
        done = subprocess.run([sys.executable, "-c", program, bag(driven()), str(tmp_path / "new.bag"), "types"],
                              stderr=subprocess.PIPE, text=True)
        assert done.returncode == 2 and "new.bag cannot be written: File too large" in done.stderr
        assert "Traceback" not in done.stderr
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["old.bag"]

    def test_it_appears_when_it_is_whole(self, monkeypatch, tmp_path, bag, converted):
        seen, close = [], BagWriter.close
        monkeypatch.setattr(command.BagWriter, "close",
                            lambda self: (seen.extend(sorted(entry.name for entry in tmp_path.iterdir())), close(self)))
        converted(bag(driven()), "types")
        assert seen == ["new.bag.part", "old.bag"]
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["new.bag", "old.bag"]

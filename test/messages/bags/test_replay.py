"""Replaying a bag: which topics are commands, where they go instead, and the arguments of `rosbag play`."""

import os
import pathlib
import xml.etree.ElementTree as ElementTree

import bag_factory as make
import pytest
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy

from pioneer_control.bags.replaying import commands, programs, replay
from pioneer_control.bags.command_line import bag_files
from pioneer_control.bags.reader import BagError
from pioneer_control.driver.ptz_topics import PTZ_TOPICS
from pioneer_control.driver.requests import TOPICS
from pioneer_control.errors import UsageError
from pioneer_control.msg import MotorState, WheelVelocities

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def bag(tmp_path):
    """Return a bag with two robots and a joystick."""
    told = [("/alice/cmd_vel", Twist(), 1.0), ("/bob/cmd_wheels", WheelVelocities(), 1.1),
            ("cmd_motor_state", MotorState(), 1.2),
            ("/joy", Joy(), 1.3), ("/base/velocity", Twist(), 1.4), ("/alice/pose", make.odometry(0, 0, 0), 1.5)]
    return make.write_bag(tmp_path / "told.bag", told)


class TestCommands:
    def test_all_that_a_driver_listens_to_goes_aside(self):
        topics = {"/%s/%s" % (robot, row.name): row.message._type for robot in ("alice", "bob") for row in TOPICS}
        wanted = {"/%s/%s:=/%s/recorded/%s" % (robot, row.name, robot, row.name) for robot in ("alice", "bob")
                  for row in TOPICS}
        assert len(TOPICS) >= 4
        assert {word for word in commands.player(["x.bag"], topics) if ":=" in word} == wanted

    @pytest.mark.parametrize("row", TOPICS + PTZ_TOPICS, ids=lambda row: row.name)
    def test_each_of_them_is_named(self, row):
        assert row.name in commands.COMMANDS and commands.is_command(row.name, "any/Type")

    def test_what_a_simulator_listens_to_goes_aside(self):
        assert commands.is_command("/robot1/stop_button", "std_msgs/Bool")

    def test_what_drives_is_a_command_whatever_it_is_called(self):
        assert commands.is_command("/base/velocity", "geometry_msgs/Twist")
        assert commands.is_command("/base/sides", "p2os_msgs/WheelVelocities")
        assert commands.is_command("/base/velocity", "geometry_msgs/TwistStamped")

    @pytest.mark.parametrize("topic", [
        "/pioneer/ptz_control",
        "/joy",
        "/move_base/goal",
        "/pioneer/arm/cancel",
        "initialpose",
    ])
    def test_what_other_nodes_would_do_something_by_is_a_command(self, topic):
        assert commands.is_command(topic, "any/Type")

    @pytest.mark.parametrize("topic, type_name", [
        ("/pioneer/pose", "nav_msgs/Odometry"), ("/pioneer/motor_state", "pioneer_control/MotorState"),
        ("/tf", "tf2_msgs/TFMessage"),
        ("/pioneer/gripper_state", "pioneer_control/GripperState"), ("/pioneer/decision", "pioneer_control/Decision")])
    def test_a_report_is_none(self, topic, type_name):
        assert not commands.is_command(topic, type_name)

    def test_aside(self):
        assert commands.aside("/pioneer/cmd_vel") == "/pioneer/recorded/cmd_vel"
        assert commands.aside("/fleet/bob/cmd_vel", "rerun") == "/fleet/bob/rerun/cmd_vel"
        assert commands.aside("cmd_vel") == "/recorded/cmd_vel", "of a robot at the root"


class TestPlayer:
    def test_every_command_of_every_robot_is_put_aside(self, bag):
        command = commands.player([bag], commands.recorded_topics([bag]), ["-r", "2"])
        assert command[:8] == ["rosrun", "rosbag", "play", "--clock", *commands.QUEUE, "-r", "2", bag]
        assert command[8:] == [
            "/alice/cmd_vel:=/alice/recorded/cmd_vel", "/base/velocity:=/base/recorded/velocity",
            "/bob/cmd_wheels:=/bob/recorded/cmd_wheels",
            "/cmd_motor_state:=/recorded/cmd_motor_state", "/joy:=/recorded/joy"]

    def test_a_clock_in_the_bag_stays_there(self, tmp_path):
        path = make.write_bag(tmp_path / "simulated.bag",
                              [("/clock", Clock(), 1.0), ("/pose", make.odometry(0, 0, 0), 1.0)])
        command = commands.player([path], commands.recorded_topics([path]))
        assert command == ["rosrun", "rosbag", "play", "--clock", *commands.QUEUE, "--topics", "/pose", "--bags", path]

    def test_commands_in_any_part_are_put_aside(self, tmp_path, bag):
        first = make.write_bag(tmp_path / "first.bag", [("/alice/pose", make.odometry(0, 0, 0), 0.5)])
        command = commands.player([first, bag], commands.recorded_topics([first, bag]))
        assert "/alice/cmd_vel:=/alice/recorded/cmd_vel" in command

    @pytest.mark.parametrize("word", [
        "--prefix=/live", "--prefix", "--pre", "-p", "-p/live", "-qp", "__ns:=live", "/alice/cmd_vel:=/live/velocity",
        "alice/cmd_vel:=/x",
        "base/velocity:=/x", "/alice/pose:=/live/cmd_vel", "pose:=cmd_motor_state", "cmd_motor_state:=/x"])
    def test_no_option_brings_commands_back_elsewhere(self, bag, word, capsys):
        topics = commands.recorded_topics([bag])
        with pytest.raises(UsageError, match="is not legal here.*comes back under recorded/"):
            commands.player([bag], topics, ["-r", "2", word, "/x"])
        assert replay.main(["look", bag, word, "/x"]) == 2
        assert word in capsys.readouterr().err

    @pytest.mark.parametrize("word", [
        "--pause", "-l", "-q", "-s", "30", "__name:=play_bag", "__log:=/tmp/x.log", "/alice/pose:=/alice/odom", "_x:=1",
    ])
    def test_others_do_not(self, bag, word):
        assert word in commands.player([bag], commands.recorded_topics([bag]), [word])


class TestFiles:
    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        for name in ("run_0.bag", "run_2.bag", "run_10.bag", "my run.bag", "odd'.bag"):
            (tmp_path / name).write_bytes(b"")
        monkeypatch.chdir(tmp_path)

    @pytest.mark.parametrize("given, files", [
        ("run_0.bag", ["run_0.bag"]), ("my run.bag", ["my run.bag"]),
        ("run_2.bag run_0.bag", ["run_2.bag", "run_0.bag"]), ("odd'.bag", ["odd'.bag"]),
        ("run_*.bag", ["run_0.bag", "run_2.bag", "run_10.bag"]),
        ("'my run.bag' run_0.bag", ["my run.bag", "run_0.bag"])])
    def test_one_or_several(self, folder, given, files):
        assert bag_files(given) == files

    @pytest.mark.parametrize("given", ["~/run_0.bag ~/run_2.bag", "~/run_0.bag"])
    def test_a_home_is_found(self, folder, tmp_path, monkeypatch, given):
        """The shell does not expand ~ behind bag:=."""
        monkeypatch.setenv("HOME", str(tmp_path))
        assert bag_files(given) == given.replace("~", str(tmp_path)).split()

    @pytest.mark.parametrize("given, named", [
        ("nothing.bag", "nothing.bag"), ("run_0.bag nothing.bag", "nothing.bag"), ("none_*.bag", r"none_\*.bag"),
        ("it's.bag", "it's.bag"),
        (" ", "no bag is named")])
    def test_one_that_is_not_there_is_named(self, folder, given, named):
        with pytest.raises(BagError, match=named):
            bag_files(given)


class TestBags:
    def test_topics_and_types(self, bag):
        assert commands.recorded_topics([bag])["/alice/cmd_vel"] == "geometry_msgs/Twist"

    @pytest.mark.parametrize("content, said", [(b"no bag at all", "is not a bag"), (b"", "is empty")])
    def test_what_is_none(self, tmp_path, content, said):
        path = tmp_path / "x.bag"
        path.write_bytes(content)
        with pytest.raises(BagError, match=said):
            commands.recorded_topics([str(path)])

    def test_a_recorder_that_was_killed(self, tmp_path, bag):
        with open(bag, "rb") as whole:
            content = whole.read()
        path = tmp_path / "x.bag.active"
        path.write_bytes(content.replace(b"index_pos=" + content.split(b"index_pos=")[1][:8], b"index_pos=" + bytes(8)))
        with pytest.raises(BagError, match="rosbag reindex"):
            commands.recorded_topics([str(path)])

    def test_an_empty_one(self, tmp_path):
        with pytest.raises(BagError, match="nothing in it"):
            commands.recorded_topics([make.write_bag(tmp_path / "empty.bag", [])])

    @pytest.mark.parametrize("topic", ["/pi$on/pose", "/a\x1b[31m/pose", "/a\nb", "/nul\0", "/%s", "/p\u00f6se", "1st"])
    def test_a_topic_that_ros_cannot_have(self, tmp_path, topic):
        messages = [("/pioneer/pose", make.odometry(0, 0, 0), 1.0), (topic, Twist(), 1.0)]
        path = make.write_bag(tmp_path / "odd.bag", messages)
        with pytest.raises(BagError, match="is no name of a topic.*rosbag filter"):
            commands.recorded_topics([path])

    def test_one_that_was_cut_off(self, bag):
        with pytest.raises(BagError, match="told.bag has no whole index.*rosbag reindex"):
            commands.recorded_topics([make.cut(bag, 0.99)])

    def test_a_directory(self, tmp_path):
        with pytest.raises(BagError, match=str(tmp_path)):
            commands.recorded_topics([str(tmp_path)])


class TestMain:
    @pytest.fixture(autouse=True)
    def nobody_else(self, monkeypatch):
        monkeypatch.setattr(programs, "possible_robots", lambda: [])

    @pytest.mark.parametrize("words, said", [
        (["look", "/nowhere/x.bag"], "/nowhere/x.bag: no such file"),
        (["rewind"], "'rewind': there are look, rerun, redrive")])
    def test_what_cannot_be_done_is_told_in_a_line(self, capsys, words, said):
        assert replay.main(words) == 2
        assert said in capsys.readouterr().err

    @pytest.mark.parametrize("words", [
        ["look", "bag:=x.bag"],
        ["redrive", "x.bag", "speed:=0.1"],
        ["rerun", "x.bag", "program:=mine"],
        ["way:=look"],
    ])
    def test_what_was_meant_for_roslaunch_is_refused(self, capsys, words):
        """Without this error, the argument would be ignored and the robot would drive at full speed."""
        assert replay.main(words) == 2
        assert "%s: this is the form for roslaunch" % words[-1] in capsys.readouterr().err

    def test_all_that_roslaunch_is_told_is_known(self):
        launch = ElementTree.parse(ROOT / "launch" / "replay.launch").getroot()
        arguments = [row.get("name") for row in launch.findall("arg") if "value" not in row.attrib]
        assert sorted(replay.LAUNCH_ARGUMENTS) == sorted(arguments)

    def test_looking_becomes_the_player(self, bag, monkeypatch):
        became = []
        monkeypatch.setattr(os, "execvp", lambda file, words: became.append(words))
        replay.main(["look", bag, "--picture=false", "-l", "__name:=play_bag"])
        (words,) = became
        assert words[:8] == ["rosrun", "rosbag", "play", "--clock", *commands.QUEUE, "-l", "__name:=play_bag", bag]

    def test_the_namespace_of_the_shell_is_not_the_bags(self, bag, monkeypatch):
        """A topic `cmd_vel` without a slash would belong to any program in that namespace."""
        namespaces = []
        monkeypatch.setenv("ROS_NAMESPACE", "/live")
        monkeypatch.setattr(os, "execvp", lambda file, words: namespaces.append(os.environ.get("ROS_NAMESPACE")))
        replay.main(["look", bag])
        assert namespaces == [None]

    @pytest.mark.parametrize("wanted", [True, False])
    def test_it_can_be_drawn_first(self, bag, monkeypatch, wanted):
        done = []
        monkeypatch.setattr(os, "execvp", lambda file, words: done.append("played"))
        monkeypatch.setattr(replay, "draw", lambda words: done.append(words))
        replay.main(["look", bag, "--picture=%s" % str(wanted).lower()])
        assert done == ([[bag, "--parts"]] if wanted else []) + ["played"]

    def test_robots_that_are_there_are_told(self, bag, monkeypatch, capsys):
        monkeypatch.setattr(os, "execvp", lambda file, words: None)
        replay.main(["look", bag])
        assert capsys.readouterr().err == ""
        monkeypatch.setattr(programs, "possible_robots", lambda: ["/alice/p2os (/alice/motor_state)"])
        replay.main(["look", bag])
        said = capsys.readouterr().err
        assert "/alice/p2os (/alice/motor_state) is on this master. No command of the bag reaches it" in said

    def test_no_master_is_told(self, bag, monkeypatch, capsys):
        def refuse():
            raise ConnectionRefusedError
        monkeypatch.setattr(programs, "possible_robots", refuse)
        assert replay.main(["look", bag]) == 2
        assert "there is no ROS master at" in capsys.readouterr().err

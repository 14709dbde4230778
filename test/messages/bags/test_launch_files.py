"""The content of the launch files, what describes the robot, and the RViz configuration. Nothing is started."""

import pathlib
import shlex
import xml.etree.ElementTree as ElementTree

import pytest
import yaml
from roslaunch.config import load_config_default

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.replaying import redrive, replay, rerun
from pioneer_control.description import Parts, describe
from pioneer_control.description.node import DescriptionParameters, fitted
from pioneer_control.driver.conversions import WHEEL_JOINTS
from pioneer_control.errors import UsageError
from pioneer_control.msg import RobotInfo
from pioneer_control.parameters import check
from pioneer_control.robots import find_model

ROOT = pathlib.Path(__file__).resolve().parents[3]
COMMANDS = "cmd_vel", "cmd_motor_state", "gripper_control"


def node(launch, *arguments):
    """Return the only node of a launch file."""
    (only,) = load_config_default([(str(ROOT / "launch" / launch), list(arguments))], None, verbose=False).nodes
    return only


class TestSimulator:
    @pytest.mark.parametrize("launch, arguments", [("simulator.launch", []), ("pioneer.launch", ["sim:=true"])])
    @pytest.mark.parametrize("place, entered", [("/my lab", "/my lab"), (None, ".")])
    def test_files_are_looked_for_where_the_command_is_typed_in(self, monkeypatch, launch, arguments, place, entered):
        monkeypatch.delenv("PWD") if place is None else monkeypatch.setenv("PWD", place)
        nodes = load_config_default([(str(ROOT / "launch" / launch), arguments)], None, verbose=False).nodes
        assert [shlex.split(each.launch_prefix)
                for each in nodes if each.type == "p2os_simulator"] == [["env", "--chdir=" + entered]]

    @pytest.mark.parametrize("ptz_port, number", [
        ("aux1", 1), ("aux2", 2), ("aux3", 3), ("/dev/ttyS1", 1), ("aux4", 1)])
    def test_the_camera_is_where_the_driver_looks_for_it(self, ptz_port, number):
        launch = (str(ROOT / "launch" / "pioneer.launch"), ["sim:=true", "ptz:=vcc4", "ptz_port:=" + ptz_port])
        params = load_config_default([launch], None, verbose=False).params
        assert params["/pioneer/simulator/camera_aux"].value == number
        assert params["/pioneer/p2os/ptz_port"].value == ptz_port


class TestReplay:
    def test_it_looks_unless_another_way_is_named(self):
        words = shlex.split(node("replay.launch", "bag:=/tmp/with space/x.bag", "options:=-r 2").args)
        assert words == ["look", "/tmp/with space/x.bag", "--picture=false", "-r", "2"]

    def test_the_driver_would_know_it_for_a_player(self):
        assert node("replay.launch", "bag:=/tmp/x.bag").name.startswith("play_")

    def test_looking_has_the_bags_time(self):
        launch = (str(ROOT / "launch" / "replay.launch"), ["bag:=/tmp/x.bag"])
        config = load_config_default([launch], None, verbose=False)
        assert config.params["/use_sim_time"].value is True

    def test_no_other_way_touches_everybodys_time(self):
        for way in ("rerun", "redrive", "rewind"):
            launch = (str(ROOT / "launch" / "replay.launch"), ["bag:=/tmp/x.bag", "way:=" + way])
            config = load_config_default([launch], None, verbose=False)
            assert "/use_sim_time" not in config.params

    @pytest.mark.parametrize("way, options", [("rerun", rerun.OPTIONS), ("redrive", redrive.OPTIONS)])
    def test_each_way_has_one_program_that_takes_the_arguments(self, way, options):
        words = shlex.split(node("replay.launch", "bag:=/tmp/with space/x.bag", "way:=" + way).args)
        parser = parser_of(way, "", options)
        given = parser.parse_args(words[1:])
        assert (words[0], given.bag) == (way, "/tmp/with space/x.bag")
        by_default = parser.parse_args([given.bag])
        assert vars(given) == vars(by_default), "what the launch file gives is what holds without it"

    def test_a_way_that_there_is_not_is_told(self, capsys):
        assert replay.main(shlex.split(node("replay.launch", "bag:=/tmp/x.bag", "way:=rewind").args)) == 2
        assert "'rewind': there are look, rerun, redrive" in capsys.readouterr().err


def test_the_wheels_of_a_description_are_those_of_joint_states():
    """As joint_states name them: else the wheels have no tf."""
    urdf = ElementTree.fromstring(describe(find_model("p3dx-sh")))
    turning = {joint.get("name"): joint.find("axis").get("xyz")
               for joint in urdf.findall("joint") if joint.get("type") != "fixed"}
    assert turning == dict.fromkeys(WHEEL_JOINTS, "0.0000 1.0000 0.0000")


class TestDescription:
    """What the node of description.launch describes, from what the robot says and what the user says."""

    @staticmethod
    def said(subtype="p3dx-sh", has_gripper=True, sonar_numbers=range(8)):
        return RobotInfo(subtype=subtype, has_gripper=has_gripper, sonar_numbers=list(sonar_numbers))

    def test_it_is_the_robot_that_is_there_with_what_is_fitted(self):
        model, parts = fitted(DescriptionParameters(), self.said())
        assert (model.subtype, len(model.sonar), parts) == ("p3dx-sh", 8, Parts(gripper=True))
        assert fitted(DescriptionParameters(), self.said(has_gripper=False))[1] == Parts()

    def test_a_model_that_is_given_has_what_it_can_have(self):
        model, parts = fitted(DescriptionParameters(model="P3DX-SH", ptz=True), None)
        assert (len(model.sonar), parts) == (16, Parts(gripper=True, ptz=True))
        assert fitted(DescriptionParameters(model="p3at-sh", laser=True, arm=True), None)[1] == Parts(
            laser=True, arm=True)

    def test_the_user_knows_better_whether_there_is_a_gripper(self):
        assert fitted(DescriptionParameters(gripper=False), self.said())[1] == Parts()
        assert fitted(DescriptionParameters(gripper=True), self.said(has_gripper=False))[1] == Parts(gripper=True)

    def test_a_model_that_nobody_knows_is_refused(self):
        with pytest.raises(UsageError, match="unknown robot model 'p9'"):
            fitted(DescriptionParameters(), self.said("p9"))

    @pytest.mark.parametrize("launch, arguments", [
        ("description.launch", []), ("view.launch", ["rviz:=false"]), ("pioneer.launch", ["description:=true"])])
    def test_each_launch_file_gives_what_the_node_takes(self, launch, arguments):
        config = load_config_default([(str(ROOT / "launch" / launch), arguments)], None, verbose=False)
        (found,) = [each for each in config.nodes if each.type == "description"]
        assert (found.namespace, found.name) == ("/pioneer/", "robot_state_publisher")
        given = {name.rpartition("/")[2]: param.value for name, param in config.params.items()
                 if name.startswith("/pioneer/robot_state_publisher/")}
        assert set(given) >= {"model", "gripper", "laser", "frame_prefix"}
        assert check(DescriptionParameters, given) == (DescriptionParameters(), [])

    @pytest.mark.parametrize("words, drawn", [
        (["ptz:=vcc4"], True), (["ptz:=vcc4", "ptz_place:=[0.1, 0, 0.3]"], False), ([], False)])
    def test_a_camera_has_one_place(self, words, drawn):
        launch = (str(ROOT / "launch" / "pioneer.launch"), ["description:=true"] + words)
        params = load_config_default([launch], None, verbose=False).params
        assert params["/pioneer/robot_state_publisher/ptz"].value is drawn

    def test_an_arm_is_drawn_where_there_is_one(self):
        launch = (str(ROOT / "launch" / "pioneer.launch"), ["description:=true", "arm:=pioneer_arm"])
        params = load_config_default([launch], None, verbose=False).params
        assert params["/pioneer/robot_state_publisher/arm"].value is True

    def test_another_robots_links_have_its_prefix(self):
        launch = (str(ROOT / "launch" / "view.launch"), ["robot:=two", "rviz:=false", "model:=amigo"])
        params = load_config_default([launch], None, verbose=False).params
        assert params["/two/robot_state_publisher/frame_prefix"].value == "two/"
        assert params["/two/robot_state_publisher/model"].value == "amigo"


def test_rviz_shows_the_topics_of_the_robot_in_whose_namespace_it_is():
    config = yaml.safe_load((ROOT / "config" / "pioneer.rviz").read_text())
    displays = config["Visualization Manager"]["Displays"]
    topics = {display[key] for display in displays for key in ("Topic", "Marker Topic") if key in display}
    assert topics == {"map", "world_markers", "pose", "ground_truth", "cans", "markers", "sonar_ranges", "sonar_points",
                      "particlecloud", "plan", "footprint", "ptz_view", "scan"}
    tools = {tool["Topic"] for tool in config["Visualization Manager"]["Tools"] if "Topic" in tool}
    assert tools == {"initialpose", "move_base_simple/goal"}

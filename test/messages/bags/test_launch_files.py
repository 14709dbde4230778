"""The content of the launch files, the URDF and the RViz configuration. Nothing is started."""

import pathlib
import shlex
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import yaml
from roslaunch.config import load_config_default

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.replaying import redrive, replay, rerun
from pioneer_control.driver.conversions import WHEEL_JOINTS
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


class TestShape:
    @pytest.fixture
    def urdf(self):
        return ElementTree.parse(ROOT / "urdf" / "pioneer3dx.urdf").getroot()

    @staticmethod
    def boxes(urdf, link):
        """Return (centre, size) of each box of a link, in the link's frame."""
        visuals = urdf.findall("link[@name='%s']/visual" % link)
        return [
            (np.fromstring(visual.find("origin").get("xyz"), sep=" "),
             np.fromstring(visual.find("geometry/box").get("size"), sep=" "))
            for visual in visuals
            if visual.find("geometry/box") is not None
        ]

    def test_everything_hangs_together_and_only_the_wheels_turn(self, urdf):
        joints = urdf.findall("joint")
        turning = {joint.get("name"): joint for joint in joints if joint.get("type") != "fixed"}
        assert set(turning) == set(WHEEL_JOINTS), "as joint_states name them: else the wheels have no tf"
        assert {(joint.get("type"), joint.find("axis").get("xyz"))
                for joint in turning.values()} == {("continuous", "0 1 0")}
        assert {joint.find("parent").get("link") for joint in joints} == {"base_link"}
        links = {link.get("name") for link in urdf.findall("link")}
        assert links == {"base_link"} | {joint.find("child").get("link") for joint in joints}

    def test_wheels_are_as_large_as_the_models_and_stand_on_the_floor_each_on_its_side(self, urdf):
        radius = find_model("p3dx-sh").wheel_radius
        sides = []
        for name in WHEEL_JOINTS:
            joint = urdf.find("joint[@name='%s']" % name)
            drawn = urdf.findall("link[@name='%s']/visual/geometry/cylinder" % joint.find("child").get("link"))
            _, y, z = map(float, joint.find("origin").get("xyz").split())
            assert (max(float(cylinder.get("radius")) for cylinder in drawn), z) == (radius, radius)
            sides.append(y)
        assert sides[0] > 0 > sides[1], "left, right"

    def test_length_is_the_models(self, urdf):
        model = find_model("p3dx-sh")
        ends = [centre[0] + side * size[0] / 2 for centre, size in self.boxes(urdf, "base_link") for side in (-1, 1)]
        assert (max(ends), min(ends)) == pytest.approx((model.length_front, -model.length_rear), abs=1e-3)

    def test_transducers_are_the_models(self, urdf):
        drawn = [
            np.fromstring(visual.find("origin").get("xyz"), sep=" ")[:2]
            for visual in urdf.findall("link[@name='sonar']/visual")
            if visual.find("material").get("name") == "gold"
        ]
        fitted = [(transducer.x, transducer.y) for transducer in find_model("p3dx-sh").sonar]
        assert np.array(drawn) == pytest.approx(np.array(fitted), abs=0.005)

    def test_paddles_are_open_as_wide_and_reach_as_far_as_the_models(self, urdf):
        model = find_model("p3dx-sh")
        gripper = model.gripper
        palm = float(urdf.find("joint[@name='gripper_joint']/origin").get("xyz").split()[0])
        left, right = (box for box in self.boxes(urdf, "gripper")
                       if box[1][0] == pytest.approx(gripper.paddle_length))
        assert palm + left[0][0] + left[1][0] / 2 == pytest.approx(model.length_front + gripper.reach)
        assert left[0][1] - right[0][1] - gripper.paddle_thickness == pytest.approx(gripper.opening)


def test_rviz_shows_the_topics_of_the_robot_in_whose_namespace_it_is():
    config = yaml.safe_load((ROOT / "config" / "pioneer.rviz").read_text())
    displays = config["Visualization Manager"]["Displays"]
    topics = {display[key] for display in displays for key in ("Topic", "Marker Topic") if key in display}
    assert topics == {"map", "world_markers", "pose", "ground_truth", "cans", "markers", "sonar_ranges", "sonar_points",
                      "particlecloud", "plan", "footprint", "ptz_view"}
    tools = {tool["Topic"] for tool in config["Visualization Manager"]["Tools"] if "Topic" in tool}
    assert tools == {"initialpose", "move_base_simple/goal"}

"""What a bag tells about a driven robot, and which simulated robot is made from it. The tests use bag files and no
master.
"""

from dataclasses import fields

import bag_factory as make
import genpy
import numpy as np
import pytest
import rosbag
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import String

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.replaying import redrive
from pioneer_control.bags.reader import BagError
from pioneer_control.bags.recording.description import Description, text_of
from pioneer_control.bags.replaying.redrive_schedule import BY_HAND, LEGAL_VALID, VALID, VELOCITIES
from pioneer_control.bags.replaying.rerun import SERVICES
from pioneer_control.bags.recorded_run import Track
from pioneer_control.driver import requests
from pioneer_control.driver.parameters import LIVE, DriverParameters
from pioneer_control.errors import UsageError
from pioneer_control.msg import GripperState, MotorState, WheelVelocities


def described(simulator, driver):
    parameters = {"pioneer": {"simulator": simulator, "p2os": driver}}
    return "/pioneer/recording", String(text_of(Description({"date": "today"}, {}, {}, parameters))), 1000.0


def told():
    yield "/pioneer/cmd_motor_state", MotorState(1), 1002.0
    yield "/pioneer/cmd_vel", Twist(), 1003.0
    yield "/pioneer/cmd_wheels", WheelVelocities(0.1, 0.1), 1004.0
    yield "/pioneer/gripper_control", GripperState(), 1005.0


@pytest.fixture
def bag(tmp_path):
    simulator = dict(world="office", model="p3at-sh", gripper="auto", rear_sonar=False, seed=99, pty="/tmp/x",
                     models_file="")
    driver = dict(cmd_vel_timeout=1.5, max_xspeed=0.3, port="/tmp/x", enable_motors_on_start=True)
    return make.write_bag(tmp_path / "run.bag", [described(simulator, driver), *make.driven((2.0, 3.0, 0.5)), *told()])


class TestWhatTheBagTells:
    def test_what_was_told_in_its_order(self, bag):
        recorded = redrive.RecordedDrive([bag])
        topics = [order.topic for order in recorded.told]
        assert topics == ["cmd_motor_state", "cmd_vel", "cmd_wheels", "gripper_control"]
        assert recorded.told[0].time == pytest.approx(1002.0) and recorded.valid == 1.5

    def test_which_robot_where(self, bag):
        recorded = redrive.RecordedDrive([bag])
        assert (recorded.robot, recorded.like["model"], recorded.like["gripper"]) == ("pioneer", "p3dx-sh", True)
        assert recorded.world == "office"
        # when it was told the first, not when the bag begins
        assert recorded.like["start"] == pytest.approx([2.0 + 0.2 * 0.8776, 3.0 + 0.2 * 0.4794, 0.5], abs=1e-3)

    def test_the_simulated_robot_is_made_of_that(self, bag):
        parameters = redrive.simulator_parameters(redrive.RecordedDrive([bag]), "", "", 5)
        assert parameters == dict(model="p3dx-sh", gripper=True, rear_sonar=False, models_file="", world="office",
                                  seed=5, numbers_file="", start=pytest.approx([2.175, 3.096, 0.5], abs=1e-3))

    def test_the_world_may_be_told_by_its_topic_alone(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", [described({}, {}), *make.driven(), *told()])
        assert redrive.RecordedDrive([path]).world == "tutorial"

    def test_a_world_that_is_named_counts_more(self, bag):
        assert redrive.simulator_parameters(redrive.RecordedDrive([bag]), "maze", "", 0)["world"] == "maze"

    def test_a_real_robots_bag_tells_neither_world_nor_place(self, tmp_path, capsys):
        told_only = [message for message in told()]
        path = make.write_bag(tmp_path / "real.bag", told_only)
        parameters = redrive.simulator_parameters(redrive.RecordedDrive([path]), "", "", 0)
        assert parameters == dict(world="empty", seed=0, numbers_file="")
        assert "does not tell what was round the robot" in capsys.readouterr().out

    def test_a_world_that_is_gone(self, tmp_path, capsys):
        path = make.write_bag(tmp_path / "run.bag", [described(dict(world="/nowhere/lab.yaml"), {}), *told()])
        assert redrive.known_world(redrive.RecordedDrive([path]).world) == "empty"
        assert "'/nowhere/lab.yaml' of the recording is not here" in capsys.readouterr().out

    def test_a_world_that_is_a_file(self, tmp_path):
        world = tmp_path / "lab.yaml"
        world.write_text("")
        path = make.write_bag(tmp_path / "run.bag", [described(dict(world=str(world)), {}), *told()])
        assert redrive.known_world(redrive.RecordedDrive([path]).world) == str(world)

    def test_nothing_was_told(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1))
        with pytest.raises(BagError, match="no robot was told anything in it"):
            redrive.RecordedDrive([path])

    def test_several_robots(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", [("/alice/cmd_vel", Twist(), 1.0), ("/bob/cmd_vel", Twist(), 1.0)])
        with pytest.raises(BagError, match="alice, bob. Choose one with robot:="):
            redrive.RecordedDrive([path])
        assert redrive.RecordedDrive([path], "bob").robot == "bob"


@pytest.mark.parametrize("strange", [TwistStamped(), String("forward"), MotorState(1)])
def test_what_is_somebody_elses_is_left_out(tmp_path, strange):
    """The messages are on topics with our names, but have other types."""
    others = [("/pioneer/%s" % name, strange, 1001.0)
              for name in ("cmd_vel", "gripper_control", "robot_info", "ground_truth")]
    with pytest.raises(BagError, match="no robot was told anything"):
        redrive.RecordedDrive([make.write_bag(tmp_path / "strange.bag", others)])
    path = make.write_bag(tmp_path / "mixed.bag", [*others, ("/pioneer/cmd_wheels", WheelVelocities(0.1, 0.2), 1002.0)])
    assert [order.message for order in redrive.RecordedDrive([path]).told] == [WheelVelocities(0.1, 0.2)]


def test_a_damaged_command_is_missing_and_told(tmp_path, capsys):
    path = str(tmp_path / "run.bag")
    with rosbag.Bag(path, "w") as bag:
        bag.write("/pioneer/cmd_vel", (Twist._type, bytes(7), Twist._md5sum, Twist), genpy.Time(1001), raw=True)
        bag.write("/pioneer/cmd_vel", make.twist(0.1), genpy.Time(1002))
    assert [order.message for order in redrive.RecordedDrive([path]).told] == [make.twist(0.1)]
    assert "1 message on /pioneer/cmd_vel could not be understood, and will be missing" in capsys.readouterr().out


class TestWhatIsAsked:
    @staticmethod
    def given(bag, *arguments):
        return redrive.Redrive(parser_of("", "", redrive.OPTIONS).parse_args([bag, *arguments]))

    @pytest.mark.parametrize("arguments, said", [
        (["--numbers-file=/x.yaml"], "/x.yaml: no such file"),
        (["--speed=0"], "speed: '0' is not legal: give a number from 0.05 to 1"),
        (["--speed=fast"], "speed: 'fast' is not legal"), (["--speed=nan"], "not legal"),
        (["--speed=1.1"], "from 0.05 to 1")])
    def test_what_makes_no_sense(self, bag, arguments, said):
        with pytest.raises(UsageError, match=said):
            self.given(bag, *arguments)

    @pytest.mark.parametrize("word", ["--into=real", "--port=/dev/ttyUSB0", "--motors=true"])
    def test_there_is_no_way_to_a_real_robot(self, word, capsys):
        """redrive offers no way to a real robot: nobody checks where recorded velocities lead."""
        with pytest.raises(SystemExit):
            parser_of("", "", redrive.OPTIONS).parse_args(["x.bag", word])
        assert "unrecognized arguments: " + word in capsys.readouterr().err

    @pytest.mark.parametrize("name", ["", "/", "//", "a b", "a//b", "1st", "~x"])
    def test_a_name_that_is_none(self, bag, name):
        """At the end, all parameters below the name are removed. For "/" these would be the parameters of all programs.
        """
        with pytest.raises(UsageError, match="--name .* is not legal"):
            self.given(bag, "--name=%s" % name)


class TestABagThatAsksForTooMuch:
    """Bags that no robot has driven, and bags whose driver limited the commanded velocities."""

    @staticmethod
    def asked(tmp_path, velocities, before=()):
        commands = []
        for number, (linear, angular) in enumerate(velocities):
            commands.append(("/pioneer/cmd_vel", make.twist(linear, angular), 1002.0 + 0.1 * number))
        return TestWhatIsAsked.given(make.write_bag(tmp_path / "run.bag", [*before, *commands]), "--speed=0.3")

    @pytest.mark.parametrize("linear, angular", [(float("nan"), 0.0), (float("inf"), 0.0), (0.1, float("nan"))])
    def test_what_is_no_number_is_not_told(self, tmp_path, linear, angular):
        asked = self.asked(tmp_path, [(linear, angular), (0.1, 0.0), (linear, angular)])
        assert {(round(order.message.linear.x, 9), order.message.angular.z)
                for order in asked._orders} == {(0.03, 0.0), (0.0, 0.0)}

    @pytest.mark.parametrize("timeout", [1e9, float("nan"), float("inf"), -1, 0, "long", None, [1]])
    def test_a_velocity_holds_no_longer_than_a_driver_lets_it(self, tmp_path, timeout):
        asked = self.asked(tmp_path, [(0.1, 0.0)], [described({}, dict(cmd_vel_timeout=timeout))])
        assert asked._recorded.valid == VALID and asked._orders[-1].time == pytest.approx(VALID / 0.3)

    @pytest.mark.parametrize("timeout", LEGAL_VALID)
    def test_but_as_long_as_the_recorded_one_did(self, tmp_path, timeout):
        asked = self.asked(tmp_path, [(0.1, 0.0)], [described({}, dict(cmd_vel_timeout=timeout))])
        assert asked._orders[-1].time == pytest.approx(timeout / 0.3)


class TestWhatIsKnownOfTheDriver:
    """These facts are written twice, because bags/ does not import the driver. Both places must agree."""

    def test_how_long_a_velocity_counts(self):
        row = LIVE["cmd_vel_timeout"]
        assert (row.default, (row.metadata["kind"].low, row.metadata["kind"].high)) == (VALID, LEGAL_VALID)

    def test_which_parameters_say_how_it_drives(self):
        same = {entry.name for entry in fields(DriverParameters) if entry.name.startswith(redrive.SAME_DRIVER)}
        assert same == {"cmd_vel_timeout", "max_xspeed", "max_yawspeed", "max_xaccel", "max_xdecel", "max_yawaccel",
                        "max_yawdecel"}

    def test_what_it_is_told(self):
        assert redrive.TOLD == {topic.name: topic.message for topic in requests.TOPICS}
        assert set(BY_HAND) == {name for name in redrive.TOLD if name.startswith("teleop/")}
        assert set(VELOCITIES) < set(redrive.TOLD)

    def test_what_it_is_asked(self):
        assert SERVICES == tuple(service.name for service in requests.SERVICES)


class TestTrimmed:
    track = Track(np.array([0.0, 10.0, 11.0]), np.array([0.0, 1.0, 3.0]), np.zeros(3), np.zeros(3))

    def test_it_begins_where_the_robot_was_just_then(self):
        """A run has only a few places of a robot that drives straight on."""
        assert redrive.trimmed(self.track, 5.0).time.tolist() == [5.0, 10.0, 11.0]
        assert redrive.trimmed(self.track, 5.0).x.tolist() == [0.5, 1.0, 3.0]

    @pytest.mark.parametrize("begin, left", [(-1.0, 3), (0.0, 3), (10.0, 2), (99.0, 1)])
    def test_at_the_ends(self, begin, left):
        assert len(redrive.trimmed(self.track, begin).x) == left

"""One run on topics: what is published while the key is held, let go, or something is in the way. Without a master."""

import math
import os
import re
from collections import deque

import pytest
import rosbag
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from pioneer_control.calibration import node as node_module
from pioneer_control.calibration.guide import Guide
from pioneer_control.calibration.node import REPEAT, UNMOVED, HeldDrive, parser, plan_given
from pioneer_control.calibration.plan import AheadLeg
from pioneer_control.calibration.result import numbers_to_tell
from pioneer_control.calibration.tracks import Factors
from pioneer_control.calibration.words import begin
from pioneer_control.errors import CalibrationError, UsageError
from pioneer_control.floor_poses import Pose
from pioneer_control.robots import find_model
from pioneer_control.tutorial.snapshot import RobotShape, Snapshot

MODEL = find_model("p3dx-sh")
SHAPE = RobotShape(MODEL.sonar, MODEL.outline())


class FakePioneer:
    """Takes note of what it is told, and sees what the test wants."""

    def __init__(self):
        self.told, self.time, self.ranges, self.age = [], 0.0, {}, 0.0

    def snapshot(self):
        heard = [self.ranges.get(number, 5.0) for number in range(SHAPE.sonar_count)]
        return Snapshot(self.time, self.age, Pose(0, 0, 0), tuple(heard), SHAPE)

    def enable_motors(self):
        self.told.append("motors")

    def drive(self, linear, angular):
        self.told.append(round(linear, 2))

    def stop(self):
        self.told.append("stop")

    def take(self):
        told, self.told = self.told, []
        return told


class HeldRun:
    """A run of 5 m, and time."""

    def __init__(self):
        self.pioneer, self.news, self.said, self.x = FakePioneer(), deque(), [], 0.0
        self.drive = HeldDrive(self.pioneer, self.news, Guide((AheadLeg(5.0),), Factors()), self)

    def say(self, text):
        self.said.append(text)

    def step(self, held, moved=0.02):
        """Let 0.1 s pass, in which a pose comes. Return what the robot was told."""
        self.pioneer.time += 0.1
        self.x += moved
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(self.pioneer.time)
        message.pose.pose.position.x, message.pose.pose.orientation.w = self.x, 1.0
        self.news.append(message)
        assert self.drive.step(held, self.pioneer.time)
        return self.pioneer.take()


@pytest.fixture
def run():
    return HeldRun()


def test_motors_come_first_and_only_when_the_key_is_held(run):
    assert run.step(False) == ["stop"]
    assert run.step(True) == ["motors"]         # the key may be let go meanwhile
    assert run.step(True) == [0.4]
    assert run.step(False) == ["stop"]
    assert run.step(True) == [0.4]


def test_between_two_poses_the_velocity_is_repeated_in_time(run):
    run.step(True), run.step(True)
    now = run.pioneer.time
    assert run.drive.step(True, now + REPEAT / 2) and run.pioneer.take() == []
    assert run.drive.step(True, now + REPEAT) and run.pioneer.take() == [0.4]


def test_it_stands_for_what_the_sonar_sees_and_says_so_once(run):
    run.step(True), run.step(True)
    run.pioneer.ranges = {3: 0.4}
    assert run.step(True) == ["stop"] and run.step(True) == ["stop"]
    assert len(run.said) == 1 and "the sonar sees something" in run.said[0]


def test_it_stands_when_the_robot_tells_nothing(run):
    run.step(True), run.step(True)
    run.pioneer.age = 0.7
    assert run.step(True) == ["stop"] and "has told nothing for 0.7 s" in run.said[0]


def test_a_robot_that_is_locked_is_explained(run):
    for _ in range(round(UNMOVED / 0.1) + 5):
        run.step(True, moved=0.0)
    assert len(run.said) == 1 and "stop_all" in run.said[0]
    run.step(True), run.step(True)
    assert len(run.said) == 1


def test_what_was_measured(run):
    for _ in range(10):
        rate = Imu()
        rate.header.stamp = rospy.Time.from_sec(run.pioneer.time)
        rate.angular_velocity.z = 0.5
        run.news.append(rate)
        run.step(True)
    assert run.drive.track.way == pytest.approx(0.18) and run.drive.track.gyro == pytest.approx(0.45)


@pytest.mark.parametrize("x", [math.nan, math.inf, 10.0])
def test_a_pose_that_is_none_ends_the_run(run, x):
    run.step(True)
    run.x = x
    with pytest.raises(CalibrationError):
        run.step(True, moved=0.0)


def test_what_was_told_before_the_run_does_not_count():
    news = deque(["old"])
    HeldDrive(FakePioneer(), news, Guide((), Factors()), None)
    assert not news


def test_the_plans_of_the_command_line():
    quick = plan_given(parser().parse_args(["--quick", "--line", "3"]))
    assert [each.turns for each in quick.runs] == [1, -1, 0] and len(quick.proof) == 1
    assert len(plan_given(parser().parse_args([])).runs) == 14


def test_help_and_beginning_say_the_same_time_for_a_quick_calibration():
    minutes = re.search(r"and (\d+ minutes)", begin(plan_given(parser().parse_args(["--quick"])).runs)).group(1)
    assert minutes in " ".join(parser().format_help().split())


def test_a_robot_that_does_not_take_its_numbers_costs_no_work():
    class Robot:
        def tell(self, new):
            raise node_module.NotConfirmedError("silent")

        def own_numbers(self):
            return node_module.OwnNumbers(125, 16570, 0)

    run = HeldRun()
    own = node_module.OwnNumbers(128, 16570, 0)
    new = {"ticks_mm": 125, "rev_count": 16000}
    assert node_module.told_by(run, Robot(), own, lambda: new) == {"ticks_mm": 125}
    assert "Not told: silent" in run.said[0]
    assert node_module.told_by(run, Robot(), own, dict) == {}


def test_a_number_that_no_robot_can_be_told_costs_no_work():
    class Robot:
        def own_numbers(self):
            return node_module.OwnNumbers(drift_factor=0)

    run = HeldRun()
    own, counted = node_module.OwnNumbers(drift_factor=0), Factors(1.0, 1.0, 0.02)
    assert node_module.told_by(run, Robot(), own, lambda: numbers_to_tell(counted, MODEL, own, 1e-8)) == {}
    assert "Not told: " in run.said[0] and "drift_factor is -2000000; legal: " in run.said[0]


def test_a_model_is_written_by_its_own_name_however_somebody_typed_it():
    given = parser().parse_args(["--bag", "x.bag", "--model", "P3DX-SH"])
    assert node_module.subject_of_bag("", given).model.subtype == "p3dx-sh"


class Answers:
    """A terminal with the same answer to everything but where the marks are."""

    def __init__(self, answer):
        self.answer, self.said = answer, []

    def say(self, text):
        self.said.append(text)

    def ask(self, question):
        return "" if "in cm? [" in question else self.answer


def bag_of_a_line(path):
    with rosbag.Bag(str(path), "w") as bag:
        for number, x in enumerate([0.0] * 60 + [0.04 * step for step in range(80)] + [3.2] * 60):
            message = Odometry()
            message.header.stamp = rospy.Time.from_sec(1.0 + 0.1 * number)
            message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
            bag.write("/pioneer/pose", message, message.header.stamp)
    return str(path)


def test_a_bag_whose_runs_are_all_passed_over_writes_no_file(tmp_path):
    given = parser().parse_args(["--bag", bag_of_a_line(tmp_path / "x.bag"), "--model", "p3dx-sh",
                                 "--file", str(tmp_path / "my file.yaml")])
    with pytest.raises(UsageError, match="all runs of .*x.bag were passed over"):
        node_module.on_bag(Answers("-"), given)
    assert [path.name for path in tmp_path.iterdir()] == ["x.bag"]
    person = Answers("322 1")
    node_module.on_bag(person, given)
    assert "models_file:='%s'" % (tmp_path / "my file.yaml") in person.said[-1]     # as a shell takes it


def test_a_bag_without_poses_says_so(tmp_path):
    with rosbag.Bag(str(tmp_path / "x.bag"), "w"):
        pass
    with pytest.raises(UsageError, match="has no poses of a robot: record its topic pose"):
        node_module.on_bag(Answers("-"), parser().parse_args(["--bag", str(tmp_path / "x.bag")]))


@pytest.mark.parametrize("options, said", [
    (["--model", "p3dx"], "--model counts with --bag only"), (["--drift-unit", "0.1"], "with --tell-robot only"),
    (["--models-file", "x"], "with --bag only"), (["--bag", "x", "--tell-robot"], "--tell-robot needs a robot"),
    (["--side", "-1"], "side is -1.0: give 0 or a number from 0.5 to 10"), (["--file", ""], "'' cannot be written"),
    (["--bag", ""], ": no such file")])
def test_options_that_would_be_ignored_are_refused(options, said, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["calibrate", *options])
    with open(os.devnull, encoding="utf-8") as none:
        monkeypatch.setattr("sys.stdin", none)
        assert node_module.main() != 0
    assert said in capsys.readouterr().err

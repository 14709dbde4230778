"""A bag becomes a recording for the page: each frame, text and mark is what was recorded, at its time."""

import base64
import json
import math
import zlib

import pytest
from bag_factory import (MESSAGES, cans, cut, decision, driven, eventful, message_class, odometry, sonar, unclosed,
                         write_bag)
from geometry_msgs.msg import Pose2D, PoseArray, PoseStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Path
from tf2_msgs.msg import TFMessage

from pioneer_control.bags.records import BagError
from pioneer_control.msg import Helm, Navigation, Places
from pioneer_control.web.columns import read_columns
from pioneer_control.web.frames import FrameFlags, GripperBits
from pioneer_control.web.recorded import GAP, read_recording


@pytest.fixture
def recorded(tmp_path):
    def read(messages, write=write_bag):
        return read_recording([write(tmp_path / "run.bag", messages)], "run.bag")
    return read


def frames(recording, robot=1):
    entry = next(each for each in recording.value["columns"] if each["robot"] == robot)
    number = recording.value["columns"].index(entry)
    return read_columns(recording.columns[number], entry["rows"], entry["sonar"]).frames


def texts(recording, kind):
    """Return (time, value) of all texts of a kind."""
    return [(at, text[kind]) for at, text in recording.value["messages"] if kind in text]


def marks(recording, kind):
    return [(mark["at"], mark["text"]) for mark in recording.value["marks"] if mark["kind"] == kind]


def test_each_pose_is_a_frame_with_what_came_with_it(recorded):
    found = frames(recorded(driven(seconds=10, speed=0.1)))
    assert [time for time, _ in found] == pytest.approx([0.1 * step for step in range(101)], abs=0.001)
    for step in (0, 50, 100):
        frame = found[step][1]
        assert (frame.x, frame.y, frame.linear) == pytest.approx((0.01 * step, 0.0, 0.1), abs=0.001)
        assert frame.flags & FrameFlags.LINK and frame.flags & FrameFlags.SONAR
        assert frame.sonar[0] == pytest.approx(4.9, abs=0.011) and frame.sonar[1:3] == (None, math.inf)
    assert found[60][1].gripper & GripperBits.PADDLES_CLOSED and found[60][1].gripper & GripperBits.HOLDS
    assert found[10][1].gripper & GripperBits.PADDLES_OPEN


def test_the_sonar_of_a_packet_belongs_to_its_pose(recorded):
    """It comes after the pose."""
    messages = [entry for step in range(5) for entry in (
        ("/p/pose", odometry(0.1 * step, 0, 0), 1000 + 0.1 * step),
        ("/p/sonar", sonar([0.5 + 0.1 * step]), 1000 + 0.1 * step + 0.001))]
    assert [frame.sonar[0] for _, frame in frames(recorded(messages))] == pytest.approx([0.5, 0.6, 0.7, 0.8, 0.9])


def test_the_world_the_robot_and_the_cans_are_told(recorded):
    recording = recorded(driven())
    (_, (robot,)), = texts(recording, "robots")
    assert (robot["name"], robot["model"], robot["gripper"]) == ("pioneer", "p3dx-sh", True)
    assert robot["outline"] == [[0.36, -0.2], [0.36, 0.2], [-0.3, 0.2], [-0.3, -0.2]]
    assert robot["sonar"] == [[0.0, 0.1, 1.5708], None, None, [0.2, 0.0, 0.0]]
    world = texts(recording, "world")[-1][1]
    assert world["name"] == "tutorial" and world["bounds"] == [-0.05, -0.05, 8.05, 6.05]
    cells = base64.b64decode(world["grid"]["cells"])
    assert len(cells) == world["grid"]["width"] * world["grid"]["height"] and set(cells) == {0, 1}
    assert texts(recording, "cans")[0][1] == [[2.0, 1.0, 0.0], [5.0, 4.0, 0.0]] and len(texts(recording, "cans")) == 2


def test_where_odometry_begins_is_seen_from_the_true_pose(recorded):
    recording = recorded(driven(start=(1.0, 2.0, math.pi / 2)))
    assert texts(recording, "origins") == [(0.0, {"1": [1.0, 2.0, 1.5708]})]


def test_tf_goes_before_the_true_pose(recorded):
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = "map", "odom"
    transform.transform.translation.x, transform.transform.rotation.w = 3.0, 1.0
    recording = recorded([*driven(), ("/tf", TFMessage([transform]), 1001.0)])
    assert texts(recording, "origins")[-1][1] == {"1": [3.0, 0.0, 0.0]}


def goal(frame, x, y, at):
    message = PoseStamped()
    message.header.frame_id, message.pose.position.x, message.pose.position.y = frame, x, y
    return "/move_base_simple/goal", message, at


def test_goals_are_shown_in_the_map(recorded):
    recording = recorded([*driven(start=(1.0, 2.0, math.pi / 2)), goal("map", 4.0, 5.0, 1001.0),
                          goal("odom", 1.0, 0.0, 1001.5), goal("map", math.nan, 0.0, 1001.6)])
    assert texts(recording, "goals") == [(1.0, {"1": [4.0, 5.0]}), (1.5, {"1": [1.0, 3.0]})]
    assert [robot["robot"] for robot in recording.value["columns"]] == [1], "a goal is no robot"


def navigated(at, name="pioneer", **fields):
    message = Navigation(**dict(dict(state="driving", sure=True, pose=Pose2D(1.0, 2.0, 0.0)), **fields))
    message.header.frame_id = "map"
    return "/%s/navigation" % name, message, at


def test_what_navigation_said_is_shown_at_its_time(recorded):
    path, cloud = Path(poses=[goal("map", 1.0, 2.0, 0)[1]]), cans((1.0, 2.0, 0.0))
    recording = recorded(sorted([
        *driven(), ("/pioneer/places", Places(names=["kitchen"], poses=[Pose2D(3.0, 1.0, 0.0)]), 999.0),
        navigated(1001.0, goal=[Pose2D(3.0, 1.0, 0.0)]), ("/pioneer/plan", path, 1001.1),
        ("/pioneer/particlecloud", cloud, 1001.2), ("/pioneer/particlecloud", PoseArray(), 1002.0),
        navigated(1003.0, state="reached", reason="there")], key=lambda entry: entry[2]))
    assert [(at, told["state"], told["goal"]) for at, told in texts(recording, "navigation")] == [
        (1.0, "driving", [3.0, 1.0, 0.0]), (3.0, "reached", None), (6.0, "silent", None)]
    assert texts(recording, "plan")[0] == (1.1, {"robot": 1, "points": [[1.0, 2.0]]})
    assert [(at, len(told["poses"])) for at, told in texts(recording, "cloud")] == [(1.2, 1), (3.2, 0)], "now and then"
    assert texts(recording, "places")[0][1]["places"] == [["kitchen", 3.0, 1.0, 0.0]]
    assert texts(recording, "goals")[-1][1] == {}
    assert "navigation: reached: there" in dict(map(reversed, marks(recording, "event")))


def test_topics_of_others_are_no_robots(recorded):
    recording = recorded([*driven(), ("/move_base/NavfnROS/plan", Path(), 1001.0),
                          ("/amcl/particlecloud", PoseArray(), 1001.0)])
    assert [robot["name"] for robot in texts(recording, "robots")[0][1]] == ["pioneer"]


def test_the_hidden_true_map_is_not_shown(recorded):
    recording = recorded([*driven(), ("/pioneer/truth/map", OccupancyGrid(), 1001.0)])
    assert len(texts(recording, "world")) == len(texts(recorded(driven()), "world"))


def test_faults_decisions_and_events_are_marks_at_their_time(recorded):
    recording = recorded(eventful(seconds=20))
    faults = marks(recording, "fault")
    assert (7.05, "Link: no link: silent") in faults and (12.05, "Motors: the STOP button is pressed") in faults
    assert any("no link: nothing came" in text for _, text in faults)
    assert [text for _, text in marks(recording, "decision")] == ["forward", "turning left: 0.3 m ahead"]
    events = dict((text, at) for at, text in marks(recording, "event"))
    assert events["STOP button pressed"] == 12.0 and events["motors off"] == 12.0
    assert events["the left wheel is stalled"] == 10.0
    assert [at for at, _ in faults] == sorted(at for at, _ in faults)


def test_the_status_changes_with_what_is_wrong(recorded):
    statuses = texts(recorded(eventful(seconds=20)), "status")
    wrong = [(at, [fault["task"] for fault in status["faults"]]) for at, status in statuses]
    assert any(at == pytest.approx(7.05, abs=0.6) and "Link" in tasks for at, tasks in wrong)
    assert wrong[-1][1] == []
    assert statuses[-1][1]["decision"] == {"doing": "turning left", "why": "0.3 m ahead"}
    assert statuses[-1][1]["battery"]["volts"] == pytest.approx(12.4, abs=0.05)


def test_a_silence_is_shown_as_a_lost_link(recorded):
    found = frames(recorded(eventful(seconds=20)))
    lost = [time for time, frame in found if not frame.flags & FrameFlags.LINK]
    assert lost == [pytest.approx(6.0 + GAP, abs=0.11)]


def test_several_robots_have_columns_of_their_own(recorded):
    messages = sorted([*driven(name="a"), *driven(name="b", speed=0.2)], key=lambda entry: entry[2])
    recording = recorded(messages)
    assert [robot["name"] for robot in texts(recording, "robots")[0][1]] == ["a", "b"]
    assert frames(recording, 1)[-1][1].x == pytest.approx(1.0) and frames(recording, 2)[-1][1].x == pytest.approx(2.0)


def test_it_begins_with_the_first_pose_and_knows_what_came_before(recorded):
    messages = [(topic, message, time - 5.0 if topic.endswith(("map", "robot_info")) else time)
                for topic, message, time in driven()]
    recording = recorded(sorted(messages, key=lambda entry: entry[2]))
    assert frames(recording)[0][0] == 0.0 and recording.value["duration"] == pytest.approx(10.0, abs=0.01)
    assert recording.value["start"] == pytest.approx(1000.0) and texts(recording, "world")[0][0] == 0.0


def test_who_had_the_helm_is_told(recorded):
    helm = [(Helm(), 1000.0), (Helm(commander="teleop/cmd_vel", node="/joy", programs_locked_out=True), 1002.0),
            (Helm(locks=["stop_all"]), 1004.0)]
    recording = recorded(sorted([*driven(), *(("/pioneer/helm", message, time) for message, time in helm)],
                                key=lambda entry: entry[2]))
    found = texts(recording, "helm")
    assert [(at, helm["commander"], helm["who"], helm["programs"], helm["locks"]) for at, helm in found] == [
        (0.0, "", "", "free", []), (2.0, "person", "joy", "locked out", []), (4.0, "", "", "free", ["stop_all"])]
    assert ("a person has the helm" in dict(map(reversed, marks(recording, "event"))))


@pytest.mark.parametrize("package", ["p2os_driver", "p2os_msgs"])
def test_a_bag_with_the_types_of_p2os(recorded, package):
    kind = {name: message_class(name, package) for name in ("SonarArray", "MotorState", "GripperState")}
    messages = [entry for step in range(50) for entry in (
        ("/pose", odometry(0.01 * step, 0, 0), 1000 + 0.1 * step),
        ("/sonar", kind["SonarArray"](ranges_count=2, ranges=[1.0, 5.0]), 1000 + 0.1 * step),
        ("/motor_state", kind["MotorState"](state=1), 1000 + 0.1 * step))]
    recording = recorded(messages)
    frame = frames(recording)[-1][1]
    assert frame.sonar == (1.0, math.inf) and frame.flags & FrameFlags.MOTORS
    (robot,) = texts(recording, "robots")[0][1]
    assert len(robot["outline"]) == 4 and robot["sonar"] == []


def test_a_bag_whose_recorder_was_killed(recorded):
    recording = recorded(driven(), write=unclosed)
    assert len(frames(recording)) > 50
    assert "it was not closed" in texts(recording, "said")[0][1]["text"]


def test_a_bag_that_was_cut_off_says_what_is_missing(tmp_path):
    path = write_bag(tmp_path / "run.bag", driven(seconds=60))
    recording = read_recording([cut(path, 0.6)], "run.bag")
    assert frames(recording) and texts(recording, "said")[0][1]["level"] == "warn"
    assert marks(recording, "fault")[0][0] == 0.0


def test_numbers_that_make_no_sense_are_left_out_and_said(recorded):
    messages = [*driven(seconds=2), ("/pioneer/pose", odometry(math.nan, 0, 0), 1003.0),
                ("/pioneer/pose", odometry(0.2, 0, 0), 1003.1)]
    recording = recorded(messages)
    assert "1 message on /pioneer/pose could not be understood." in [
        said["text"] for _, said in texts(recording, "said")]
    assert all(math.isfinite(frame.x) for _, frame in frames(recording))


def test_a_bag_without_a_robot_is_an_error(recorded):
    with pytest.raises(BagError, match="no pose of a robot"):
        recorded([("/cans", cans((0, 0, 0)), 1000.0)])


def test_the_packed_value_is_json_with_finite_numbers(recorded):
    recording = recorded(eventful())
    assert json.loads(zlib.decompress(recording.packed())) == recording.value
    assert recording.value["duration"] == pytest.approx(20.0, abs=0.01)


def test_ten_minutes_of_a_robot_that_decides_are_small(recorded):
    messages = [entry for entry in driven(seconds=600, speed=0.01)]
    for step in range(6000):
        time, reason = 1000 + 0.1 * step, "driving: %.1f m clear ahead" % (1 + step % 37 / 10)
        messages.append(("/pioneer/decision", decision(time, reason), time))
    recording = recorded(sorted(messages, key=lambda entry: entry[2]))
    assert len(recording.packed()) + len(recording.columns[0]) < 50_000


def test_the_definitions_are_those_of_this_package():
    assert (MESSAGES / "Helm.msg").exists()

"""Good and bad bags, read into arrays."""

import math

import numpy as np
import pytest
from std_msgs.msg import Header

import bag_factory as make
from pioneer_control.bags.reader import BagError
from pioneer_control.bags.collectors import gripper_events
from pioneer_control.bags.recorded_run import Track, chained, inverted, placed
from pioneer_control.bags.run import read_run

FROZEN = {  # from upstream-compatible bags: the md5 is what lets them play into our subscribers
    "SonarArray": "2984921c09aef26ad253c7629937a5bb",
    "GripperState": "300b38b2a4173deb725df02fa70fc70b",
}


@pytest.fixture
def bag(tmp_path):
    """Write messages to a bag and return its path."""
    return lambda messages: make.write_bag(tmp_path / "run.bag", messages)


def without(messages, *names):
    """Return the messages except those of topics with these last names."""
    return [entry for entry in messages if entry[0].rsplit("/", 1)[1] not in names]


@pytest.mark.parametrize("name, md5", FROZEN.items())
@pytest.mark.parametrize("package", ["pioneer_control", "p2os_msgs", "p2os_driver"])
def test_the_factory_makes_the_types_of_old_bags(name, md5, package):
    made = make.message_class(name, package)
    assert (made._type, made._md5sum) == ("%s/%s" % (package, name), md5)


class TestGeometry:
    def test_placed(self):
        assert placed((1.0, 2.0, math.pi / 2), 3.0, 0.5) == pytest.approx((0.5, 5.0))

    def test_inverted_undoes(self):
        pose = (1.0, -2.0, 2.5)
        assert chained(pose, inverted(pose)) == pytest.approx((0.0, 0.0, 0.0))

    def test_track_in_between_and_outside(self):
        track = Track(*np.array([[0, 1, 2], [0, 2, 2], [0, 0, 1], [0, 0, 1]], dtype=float))
        assert track.length == pytest.approx(3.0)
        assert track.at([-1.0, 0.5, 9.0]).x == pytest.approx([0.0, 1.0, 2.0])

    def test_track_seen_from(self):
        track = Track(*np.array([[0.0], [1.0], [0.0], [0.0]])).seen_from((0.0, 5.0, math.pi / 2))
        assert track.pose(0) == pytest.approx((0.0, 6.0, math.pi / 2))


class TestGripperEvents:
    OPEN, CLOSED, MOVING = 1, 2, 3

    def names(self, *states):
        return [event.what for event in gripper_events([(time, *state) for time, state in enumerate(states)])]

    def test_pick_and_put_down(self):
        states = [
            (self.OPEN, False),
            (self.MOVING, False),
            (self.MOVING, True),
            (self.CLOSED, True),
            (self.MOVING, False),
            (self.OPEN, False),
        ]
        assert self.names(*states) == ["picked up", "put down"]

    def test_time_of_the_event(self):
        assert gripper_events([(5.0, self.OPEN, False), (6.5, self.CLOSED, True)])[0].time == 6.5

    def test_closing_on_nothing(self):
        assert self.names((self.OPEN, False), (self.MOVING, False), (self.CLOSED, False)) == ["closed on nothing"]

    def test_touching_while_open_is_no_pick(self):
        assert self.names((self.OPEN, False), (self.OPEN, True), (self.OPEN, False)) == []

    def test_held_when_the_recording_begins(self):
        assert self.names((self.CLOSED, True), (self.CLOSED, True), (self.OPEN, False)) == ["put down"]

    def test_closed_when_the_recording_begins(self):
        assert self.names((self.CLOSED, False), (self.CLOSED, False)) == []


class TestReading:
    def test_everything(self, bag):
        run = read_run(bag(make.driven(drift=0.1)))
        assert (run.robot, run.model, run.world) == ("pioneer", "p3dx-sh", "tutorial")
        assert run.duration == pytest.approx(10.0)
        assert run.odometry.length == pytest.approx(0.9)
        assert run.truth.length == pytest.approx(1.0)
        assert run.odometry_origin == pytest.approx((1.0, 1.0, 0.0))
        assert run.footprint == pytest.approx(np.array(make.SQUARE))
        assert run.map.cells.shape == (122, 162) and run.map.cells[0, 0] == 100 and run.map.cells[5, 5] == 0
        assert [len(can.time) for can in run.cans] == [2, 2] and run.cans[1].x.tolist() == [5.0, 5.0]
        assert [(event.what, round(event.time)) for event in run.gripper] == [("picked up", 1005), ("put down", 1008)]

    def test_echoes_lie_where_the_walls_are(self, bag):
        run = read_run(bag(make.driven(start=(6.0, 1.0, 0.0))))
        echoes = np.column_stack(placed(run.odometry_origin, *run.echoes().T))
        assert echoes[:, 0].max() == pytest.approx(8.0)
        # The transducer at the side hears the same 4.9 m again and again; one echo, not a smear of repeated readings.
        assert len(run.sonar.time) == 102 and np.count_nonzero(np.isclose(echoes[:, 1], 6.0)) == 1
        assert len(echoes) == 2  # the wall ahead is one point however often it is heard

    def test_no_echo_and_not_heard_are_not_points(self, bag):
        messages = without(make.driven(seconds=1), "sonar")
        messages += [("/pioneer/sonar", make.sonar(ranges), 1000.5)
                     for ranges in ([5.0, 1.0, 1.0, 0.0], [0.0, 2.0, 2.0, 5.0])]
        assert len(read_run(bag(messages)).echoes()) == 0

    def test_heading_does_not_jump_at_half_a_turn(self, bag):
        headings = np.linspace(3.0, 3.4, 5)
        run = read_run(bag([("/pioneer/pose", make.odometry(0, 0, heading), 10.0 + i)
                            for i, heading in enumerate(headings)]))
        assert run.odometry.heading == pytest.approx(headings)

    def test_a_real_robots_bag_has_no_truth(self, bag):
        run = read_run(bag(without(make.driven(), "ground_truth", "map", "cans", "world", "gripper_state")))
        assert run.truth is None and run.map is None and run.cans == () and run.gripper == () and run.world == ""
        assert run.odometry_origin == (0.0, 0.0, 0.0)

    def test_without_robot_info_no_echo_has_a_place(self, bag):
        run = read_run(bag(without(make.driven(), "robot_info")))
        assert run.model == "" and run.footprint.shape == (0, 2) and run.echoes().shape == (0, 2)

    @pytest.mark.parametrize("x", [math.nan, math.inf, 1e300])
    def test_a_robot_info_of_no_sense_has_no_places(self, bag, x):
        messages = without(make.driven(seconds=1), "robot_info")
        messages.append(("/pioneer/robot_info", make.robot_info({0: (x, 0.0, 0.0)}), 1000.0))
        assert read_run(bag(messages)).echoes().shape == (0, 2)

    def test_sonar_messages_of_different_lengths(self, bag):
        messages = without(make.driven(seconds=1), "sonar")
        messages += [("/pioneer/sonar", make.sonar([1.0] * count), 1000.5) for count in (4, 0, 2)]
        assert read_run(bag(messages)).sonar.number.tolist() == [0, 1, 2, 3, 0, 1]

    @pytest.mark.parametrize("package", ["p2os_driver", "p2os_msgs"])
    def test_old_types(self, bag, package):
        messages = [
            ("/pose", make.odometry(0.0, 0.0, 0.0), 1.0),
            ("/sonar", make.sonar([1.0, 2.0], package), 1.0),
            ("/gripper_state", make.gripper(1, False, package), 1.0),
            ("/gripper_state", make.gripper(2, True, package), 2.0),
        ]
        run = read_run(bag(messages))
        assert run.robot == "" and run.sonar.range.tolist() == [1.0, 2.0] and run.gripper[0].what == "picked up"

    def test_paddles_that_press_on_each_other_hold_nothing(self, bag):
        messages = without(make.driven(seconds=1), "gripper_state") + [
            ("/pioneer/gripper_state", make.gripper(1, False), 1000.0),
            ("/pioneer/gripper_state", make.gripper(2, False, pressed=True), 1000.5),
            ("/pioneer/gripper_state", make.gripper(1, False), 1001.0),
        ]
        assert [event.what for event in read_run(bag(messages)).gripper] == ["closed on nothing"]

    def test_topics_of_our_names_but_other_types_are_left_alone(self, bag):
        messages = without(make.driven(seconds=1), "sonar") + [("/pioneer/sonar", Header(), 1000.5)]
        assert read_run(bag(messages)).sonar.range.shape == (0,)

    def test_a_map_of_everybody(self, bag):
        messages = without(make.driven(seconds=1), "map") + [("/map", make.room(2.0, 1.0), 1000.5)]
        assert read_run(bag(messages)).map.cells.shape == (22, 42)


class TestSeveralRobots:
    def both(self):
        return list(make.driven(seconds=1, name="alice")) + list(make.driven(seconds=2, name="bob"))

    def test_one_must_be_chosen(self, bag):
        with pytest.raises(BagError, match="2 robots: alice, bob"):
            read_run(bag(self.both()))

    def test_one_is_chosen(self, bag):
        assert read_run(bag(self.both()), "/bob").duration == pytest.approx(2.0)

    def test_one_that_is_not_there(self, bag):
        with pytest.raises(BagError, match="no robot 'carol'; it has: alice, bob"):
            read_run(bag(self.both()), "carol")


class TestBadBags:
    def test_no_such_file(self, tmp_path):
        with pytest.raises(BagError, match="no such file"):
            read_run(str(tmp_path / "missing.bag"))

    def test_a_directory(self, tmp_path):
        with pytest.raises(BagError, match="cannot be read: Is a directory"):
            read_run(str(tmp_path))

    def test_without_messages(self, bag):
        with pytest.raises(BagError, match="the bag is empty"):
            read_run(bag([]))

    def test_without_our_topics(self, bag):
        with pytest.raises(BagError, match="no odometry.*It has: /chatter"):
            read_run(bag([("/chatter", Header(), 1.0)]))

    @pytest.mark.parametrize("content", [b"", b"hello", b"#ROSBAG V2.0\n"])
    def test_not_a_bag(self, tmp_path, content):
        path = tmp_path / "x.bag"
        path.write_bytes(content)
        with pytest.raises(BagError, match="x.bag"):
            read_run(str(path))

    @pytest.mark.parametrize("share, seconds", [(0.5, 10.4), (0.9, 18.4)])
    def test_truncated(self, bag, share, seconds):
        run = read_run(make.cut(bag(make.driven(seconds=20)), share))
        assert run.duration == pytest.approx(seconds, abs=1.0)
        assert "is cut off after %.1f s, at" % run.duration in run.damage and "the rest is missing" in run.damage

    def test_truncated_in_the_index(self, bag):
        run = read_run(make.cut(bag(make.driven(seconds=20)), 0.98))
        assert run.duration == pytest.approx(20.0) and "all messages before it are there" in run.damage

    def test_truncated_before_its_first_pose(self, bag):
        with pytest.raises(BagError, match="no odometry.*cut off"):
            read_run(make.cut(bag(make.driven(seconds=2)), 6000))

    @pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
    def test_unindexed(self, tmp_path, compression):
        run = read_run(make.unclosed(tmp_path / "run.bag.active", make.driven(seconds=20), compression))
        assert run.duration > 15.0 and run.model == "p3dx-sh"
        assert "it was not closed and ends" in run.damage

    def test_damaged_in_the_middle(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", make.driven(seconds=2), compression="bz2")
        with open(path, "r+b") as file:
            file.seek(6000)
            file.write(b"damage" * 100)
        with pytest.raises(BagError, match="run.bag"):
            read_run(path)

"""The content of a Run from a bag in which everything happens, and from runs without end."""

import math

import genpy.dynamic
import numpy as np
import pytest
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool, Float64, Header, String

import bag_factory as make
from pioneer_control.bags import collectors
from pioneer_control.bags.collectors import (LOOKS, DecisionCollector, EchoCollector, SilenceCollector, SpanCollector,
                                             Thinned, doing, looks_of)
from pioneer_control.bags.reader import BagError
from pioneer_control.bags.recorded_run import Span
from pioneer_control.bags.run import TOPICS, read_run


@pytest.fixture
def run_of(tmp_path):
    """Write messages to a bag and read the run."""
    return lambda messages, **options: read_run(make.write_bag(tmp_path / "run.bag", messages), **options)


@pytest.fixture(scope="module")
def eventful(tmp_path_factory):
    return read_run(make.write_bag(tmp_path_factory.mktemp("bag") / "run.bag", make.eventful()))


def since(values):
    """Return the seconds since the begin of a made run."""
    return [round(float(value) - 1000.0, 1) for value in values]


class TestEverything:
    def test_commanded_steps_stay_steps(self, eventful):
        velocities = eventful.commanded
        assert since(velocities.time) == [0.0, 9.9, 10.0, 10.1, 20.0]
        assert velocities.linear == pytest.approx([0.1, 0.1, 0.0, 0.0, 0.0])
        assert velocities.angular == pytest.approx([0.0, 0.0, 0.0, 0.2, 0.2])

    def test_measured(self, eventful):
        assert eventful.measured.linear == pytest.approx([0.1, 0.1]) and since(eventful.measured.time) == [0.0, 20.0]

    def test_battery(self, eventful):
        assert eventful.battery.value[[0, -1]] == pytest.approx([12.8, 12.4], abs=1e-6)
        assert 5 < len(eventful.battery.time) < 40

    def test_switches_where_they_change(self, eventful):
        def changes(series):
            return [(time, value) for (time, value), before in zip(zip(since(series.time), series.value),
                                                                   [None, *series.value]) if value != before]

        assert changes(eventful.motors) == [(0.0, 1), (12.0, 0), (15.0, 1)]
        assert changes(eventful.e_stop) == [(0.0, 0), (12.0, 1), (13.0, 0)]
        assert len(eventful.motors.time) < 10

    def test_spans(self, eventful):
        assert [(since(span[:2]), span.what)
                for span in eventful.stalls] == [([10.0, 10.5], "left wheel"), ([10.5, 11.0], "both wheels")]
        assert [(since(span[:2]), span.what) for span in eventful.bumps] == [([10.0, 11.0], "front 2")]

    def test_faults(self, eventful):
        assert [(since([fault.time])[0], *fault[1:]) for fault in eventful.faults] == [
            (6.0, 1, "/pioneer/simulator", "simulated 6.000 s: fault begins: silence"),
            (7.0, 2, "Link", "no link: silent"),
            (7.5, 2, "/pioneer/p2os", "no link: nothing came for 1.5 s"),
            (12.0, 1, "Motors", "the STOP button is pressed")]

    def test_gaps(self, eventful):
        assert {gap.what.rsplit("/", 1)[1] for gap in eventful.gaps} == {
            "pose", "sonar", "gripper_state", "battery_state", "motor_state", "stall", "bumpers"}
        assert all(since(gap[:2]) == [6.0, 8.0] for gap in eventful.gaps)

    def test_what_a_program_was_about(self, eventful):
        assert [(since(span[:2]), span.what) for span in eventful.doings] == [
            ([0.0, 5.0], "forward"), ([5.0, 20.0], "turning")]

    def test_notes_and_damage(self, eventful):
        assert eventful.notes == "robots: [pioneer]" and eventful.damage == ""

    def test_of_a_bag_without_all_that_it_is_empty(self, run_of):
        run = run_of([("/pioneer/pose", make.odometry(0.1 * step, 0.0, 0.0), 1.0 + step) for step in range(3)])
        values = [run.commanded, run.battery, run.motors, run.e_stop, run.sonar]
        assert [len(each.time) for each in values] == [0] * 5
        assert run.stalls == run.bumps == run.faults == run.gaps == run.doings == ()
        assert run.notes == run.damage == ""


class TestFaults:
    POSE = [("/pioneer/pose", make.odometry(0.0, 0.0, 0.0), 1000.0)]

    def faults(self, run_of, *messages, **options):
        timed = [(*entry, 1000.0 + step) for step, entry in enumerate(messages)]
        return [(fault.level, fault.who, fault.what) for fault in run_of(self.POSE + timed, **options).faults]

    def test_diagnostics_count_when_their_level_changes(self, run_of):
        levels = [(1, "a"), (1, "b"), (2, "c"), (1, "d"), (0, "e"), (1, "f"), (3, "g")]
        messages = [("/diagnostics", make.diagnostics(Link=level)) for level in levels]
        expected = [(1, "Link", "a"), (2, "Link", "c"), (1, "Link", "d"), (1, "Link", "f")]
        assert self.faults(run_of, *messages) == expected

    def test_what_nodes_say_again_and_again_counts_once(self, run_of):
        messages = [("/rosout", make.log(level, node, text)) for level, node, text in (
            (Log.WARN, "/a", "x"), (Log.ERROR, "/b", "x"), (Log.WARN, "/a", "x"), (Log.FATAL, "/a", "y"),
            (Log.INFO, "/a", "z"))]
        assert self.faults(run_of, *messages) == [(1, "/a", "x"), (2, "/b", "x"), (2, "/a", "y")]

    def test_those_of_another_robot_are_its_own(self, run_of):
        messages = [("/rosout", make.log(Log.WARN, node, "x"))
                    for node in ("/pioneer/p2os", "/other/p2os", "/simulator", "/pioneer2/p2os")]
        messages += [("/diagnostics", make.diagnostics("other/p2os", Link=(2, "y"))),
                     ("/other/pose", make.odometry(0.0, 0.0, 0.0))]
        pioneer, other_robot = (self.faults(run_of, *messages, robot=name) for name in ("pioneer", "other"))
        assert [who for _, who, _ in pioneer] == ["/pioneer/p2os", "/simulator", "/pioneer2/p2os"]
        assert [who for _, who, _ in other_robot] == ["/other/p2os", "/simulator", "/pioneer2/p2os", "Link"]

    def test_too_many_are_counted(self, run_of, monkeypatch):
        monkeypatch.setattr(collectors, "TEXTS", 1)
        messages = [("/rosout", make.log(Log.WARN, "/a", str(number))) for number in range(15)]
        faults = self.faults(run_of, *messages)
        assert len(faults) == 11 and faults[-1] == (1, "", "and 5 more warnings and errors")


class TestGaps:
    def gaps(self, times, end, period=0.1):
        silence = SilenceCollector()
        for time in times:
            silence.add(time)
        return [(round(gap.begin, 3), round(gap.end, 3)) for gap in silence.gaps("/x", end)]

    REGULAR = [0.1 * step for step in range(20)]

    def test_none(self):
        assert self.gaps(self.REGULAR, 1.9) == []

    def test_one_in_between_and_one_at_the_end(self):
        assert self.gaps(self.REGULAR + [3.0 + time for time in self.REGULAR], 6.0) == [(1.9, 3.0), (4.9, 6.0)]

    def test_half_a_second_is_none(self):
        assert self.gaps(self.REGULAR + [2.39], 2.4) == []

    def test_of_a_slow_topic_three_periods_are_none(self):
        assert self.gaps([2.0 * step for step in range(20)] + [43.9], 44.0) == []
        assert self.gaps([2.0 * step for step in range(20)] + [44.1], 44.2) == [(38.0, 44.1)]

    def test_a_topic_that_came_a_few_times_has_no_period(self):
        assert self.gaps(self.REGULAR[:8] + [5.0], 9.0) == []

    def test_commands_may_be_silent(self, run_of):
        messages = [("/pioneer/pose", make.odometry(0.0, 0.0, 0.0), 1.0 + 0.1 * step) for step in range(100)]
        commands = [("/pioneer/cmd_vel", make.twist(0.1), 1.0 + 0.1 * step) for step in range(20)]
        assert run_of(messages + commands).gaps == ()


class TestOtherNames:
    def test_sensor_msgs_battery_where_there_is_no_battery_state(self, run_of):
        pose = [("/pioneer/pose", make.odometry(0.0, 0.0, 0.0), 1.0)]
        message = BatteryState(voltage=11.5)
        assert run_of(pose + [("/pioneer/battery", message, 1.0)]).battery.value == pytest.approx([11.5])
        both = [("/pioneer/battery", message, 1.0), ("/pioneer/battery_state", make.battery(12.5), 1.0)]
        assert run_of(pose + both).battery.value == pytest.approx([12.5])

    def test_odom_where_there_is_no_pose(self, run_of):
        run = run_of([("/odom", make.odometry(0.1 * step, 0.0, 0.0), 1.0 + step) for step in range(11)])
        assert run.robot == "" and run.odometry.length == pytest.approx(1.0)
        both = [("/odom", make.odometry(9.0, 0.0, 0.0), 1.0), ("/pose", make.odometry(1.0, 0.0, 0.0), 1.0)]
        assert run_of(both).odometry.x == pytest.approx([1.0])

    @pytest.mark.parametrize("package", ["p2os_driver", "p2os_msgs"])
    def test_a_whole_run_under_old_names(self, run_of, package):
        messages = [
            ("/pose", make.odometry(0.0, 0.0, 0.0), 1.0), ("/battery_state", make.battery(12.0, package), 1.0),
            ("/motor_state", make.motors(1, package), 1.0), ("/cmd_vel", make.twist(0.2), 1.0),
            ("/cmd_vel", make.twist(0.0), 2.0)]
        run = run_of(messages)
        assert run.battery.value == pytest.approx([12.0]) and run.motors.value.tolist() == [1]
        assert run.commanded.linear == pytest.approx([0.2, 0.0])


class TestRobots:
    def test_a_bag_of_another_kind_of_robot_says_what_it_has(self, run_of):
        said = r"no odometry of a robot .*It has: /base_scan \(std_msgs/Header\), /chatter \(std_msgs/String\)"
        with pytest.raises(BagError, match=said):
            run_of([("/base_scan", Header(), 1.0), ("/chatter", String("x"), 1.0)])

    def test_of_several_one_is_to_be_chosen_before_all_is_read(self, tmp_path):
        messages = list(make.driven(seconds=1, name="alice")) + list(make.driven(seconds=1, name="bob"))
        path, told = make.write_bag(tmp_path / "run.bag", messages), []
        with pytest.raises(BagError, match="2 robots: alice, bob. Choose one with --robot"):
            read_run(path, progress=lambda *done: told.append(done))
        assert told == []

    def test_so_it_is_in_a_bag_that_was_not_closed(self, tmp_path):
        messages = list(make.driven(seconds=5, name="alice")) + list(make.driven(seconds=5, name="bob"))
        path = make.unclosed(tmp_path / "run.bag.active", sorted(messages, key=lambda entry: entry[2]))
        with pytest.raises(BagError, match="2 robots: alice, bob. Choose one with --robot"):
            read_run(path)
        assert read_run(path, "bob").robot == "bob"

    def test_one_without_odometry_is_none(self, run_of):
        run = run_of(list(make.driven(seconds=1)) + [("/simulator/cans", make.cans((1.0, 1.0, 0.0)), 1000.0)])
        assert run.robot == "pioneer"


class TestShared:
    """Several simulated robots share one world, and one recording has one description."""

    def test_what_is_around_the_robot_counts_where_it_has_none_of_its_own(self, run_of):
        poses = [("/lab/%s/pose" % name, make.odometry(0.0, 0.0, 0.0), 1.0) for name in ("a", "b")]
        worlds = [("%s/world" % place, String(place), 1.0) for place in ("", "/lab", "/lab/b", "/other")]
        notes = [("/lab/a/recording", String("notes"), 1.0)]
        grid = [("/map", make.room(2.0, 1.0), 1.0)]
        for name, world in (("lab/a", "/lab"), ("lab/b", "/lab/b")):
            run = run_of(poses + worlds + notes + grid, robot=name)
            assert (run.world, run.notes, run.map.cells.shape) == (world, "notes", (22, 42))

    def test_what_is_the_robots_alone_is_not(self, run_of):
        poses = [("/lab/%s/pose" % name, make.odometry(0.0, 0.0, 0.0), 1.0) for name in ("a", "b")]
        run = run_of(poses + [("/lab/a/battery_state", make.battery(12.0), 1.0),
                              ("/lab/cmd_vel", make.twist(1.0), 1.0)], robot="lab/b")
        assert len(run.battery.time) == len(run.commanded.time) == 0


class TestParts:
    def test_they_are_one_run(self, tmp_path):
        messages, told = sorted(make.eventful(), key=lambda entry: entry[2]), []
        halves = messages[:len(messages) // 2], messages[len(messages) // 2:]
        paths = [make.write_bag(tmp_path / ("run_%s.bag" % part), half) for part, half in enumerate(halves)]
        run = read_run(paths, progress=lambda done, whole: told.append(done / whole))
        whole = read_run(make.write_bag(tmp_path / "whole.bag", messages))
        assert run.path == paths[0] and run.duration == pytest.approx(20.0) and told[-1] == 1.0
        assert run.odometry.x.tolist() == whole.odometry.x.tolist()
        assert run.gripper == whole.gripper and run.gaps == whole.gaps


class TestDamage:
    def test_messages_that_are_none_are_left_out(self, run_of):
        broken = make.odometry(math.nan, 0.0, 0.0)
        grid = make.room(1.0, 1.0)
        grid.data = grid.data[:-5]
        run = run_of([*make.driven(seconds=1), ("/pioneer/pose", broken, 1000.5), ("/pioneer/map", grid, 1000.7)])
        assert run.odometry.length == pytest.approx(0.1) and run.map.cells.shape == (122, 162)  # the one before
        assert "1 message on /pioneer/pose could not be understood." in run.damage and "/pioneer/map" in run.damage

    def test_a_flipped_length_in_a_message(self, tmp_path):
        path = make.write_bag(tmp_path / "run.bag", make.driven(seconds=1))
        frame = open(path, "rb").read().index(b"\x04\0\0\0odom")
        run = read_run(make.overwritten(path, frame, b"\xff\xff\xff\x7f"))
        assert run.duration == pytest.approx(0.9)
        assert "1 message on /pioneer/pose could not be understood." in run.damage


def other(name, package="pioneer_control", definition="int32 foo\n"):
    """Return a message that has one of our names, and another definition."""
    return genpy.dynamic.generate_dynamic("%s/%s" % (package, name), definition)["%s/%s" % (package, name)]()


class TestOtherFields:
    """Types with our names, and definitions of somebody else."""

    @pytest.mark.parametrize("definition", ["int32 foo\n", "\n".join("string %s" % field for field in (
        "header", "state", "data", "linear", "angular", "ranges", "voltage", "grip", "footprint", "poses", "info",
        "wander", "reason", "subtype", "front"))])
    @pytest.mark.parametrize("topic", sorted(set(TOPICS) - {"pose"}))
    def test_the_rest_is_read(self, tmp_path, topic, definition):
        strange = other(TOPICS[topic].type, definition=definition)
        messages = [("/x/%s" % topic, strange, 1000.5 + 0.1 * n) for n in range(3)]
        path = make.write_bag(tmp_path / "run.bag", [*make.driven(seconds=1), *messages])
        assert len(read_run(path, "pioneer").odometry.x)

    @pytest.mark.parametrize("name", ["cmd_vel", "sonar", "battery_state", "decision", "stall", "robot_info", "map",
                                      "cans", "world", "helm", "teleop/cmd_vel"])
    def test_of_the_robot_itself(self, run_of, name):
        strange = other(TOPICS[name].type)
        others = [message for message in make.driven(seconds=1) if not message[0].endswith(name)]
        run = run_of([*others, ("/pioneer/%s" % name, strange, 1000.5)])
        assert "1 message on /pioneer/%s could not be understood" % name in run.damage

    def test_of_the_pose(self, run_of):
        with pytest.raises(BagError, match="no message of the odometry"):
            run_of([("/pioneer/pose", other("Odometry", "nav_msgs"), 1000.0)])

    def test_an_array_that_fills_the_memory(self, run_of):
        """A definition may ask for more memory than a computer has. A message of this type is 4 bytes long."""
        small = other("Stall", definition="int32 a\n")
        small.__class__._full_text = "int32 a\nfloat64[99999999999] much\n"
        assert "could not be understood" in run_of([*make.driven(seconds=1), ("/pioneer/stall", small, 1000.5)]).damage


def helm(programs_locked_out):
    """Return a Helm message."""
    return make.message_class("Helm")(programs_locked_out=programs_locked_out)


class TestCommandsOfAPerson:
    """A program says 0.1 m/s, ten times a second. A person drives at 0.3 from 1 to 2 s, and gives back at 3 s."""

    POSES = [("/pioneer/pose", make.odometry(0, 0, 0), 1000.0), ("/pioneer/pose", make.odometry(1, 0, 0), 1004.0)]
    PROGRAM = [("/pioneer/cmd_vel", make.twist(0.1), 1000.01 + 0.1 * step) for step in range(40)]
    PERSON = [("/pioneer/teleop/cmd_vel", make.twist(0.3 if step < 10 else 0.0), 1001.0 + 0.1 * step)
              for step in range(11)]
    HELM = [("/pioneer/helm", helm(False), 1000.0), ("/pioneer/helm", helm(True), 1001.0),
            ("/pioneer/helm", helm(False), 1003.0)]

    def commanded(self, run_of, *messages):
        in_order = sorted(self.POSES + sum(messages, []), key=lambda message: message[2])
        return run_of(in_order).commanded

    def test_they_are_commanded_too(self, run_of):
        velocities = self.commanded(run_of, self.PERSON)
        assert since(velocities.time) == [1.0, 1.9, 2.0] and velocities.linear.tolist() == [0.3, 0.3, 0.0]

    def test_programs_that_were_locked_out_commanded_nothing(self, run_of):
        velocities = self.commanded(run_of, self.PROGRAM, self.PERSON, self.HELM)
        assert since(velocities.time) == [0.0, 0.9, 1.0, 1.9, 2.0, 3.0, 3.9]
        assert velocities.linear.tolist() == [0.1, 0.1, 0.3, 0.3, 0.0, 0.1, 0.1]

    def test_without_helm_all_count(self, run_of):
        velocities = self.commanded(run_of, self.PROGRAM, self.PERSON)
        assert 0.1 in velocities.linear[(velocities.time > 1001.0) & (velocities.time < 1002.0)]

    def test_other_robots_and_other_types_do_not_count(self, run_of):
        messages = self.PERSON + [("/pioneer/x/teleop/cmd_vel", make.twist(0.7), 1000.5),
                                  ("/teleop/cmd_vel", make.twist(0.8), 1000.5),
                                  ("/pioneer/helm", String("x"), 1000.6)]
        assert self.commanded(run_of, messages).linear.tolist() == [0.3, 0.3, 0.0]


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -1e300])
def test_velocities_that_are_none(run_of, number):
    poses = [message for message in make.driven(seconds=1) if message[0].endswith("pose")]
    run = run_of([*poses, ("/pioneer/cmd_vel", make.twist(number), 1000.5),
                  ("/pioneer/cmd_vel", make.twist(0.1, number), 1000.6),
                  ("/pioneer/cmd_vel", make.twist(0.1), 1000.7),
                  ("/pioneer/pose", make.odometry(0, 0, 0, linear=number), 1002.0)])
    assert run.commanded.linear.tolist() == [0.1] and np.isfinite(run.measured.linear).all()
    assert "2 messages on /pioneer/cmd_vel could not be understood" in run.damage


class TestBounded:
    """The size of what is kept of a run does not depend on its length."""

    @pytest.fixture(autouse=True)
    def few(self, monkeypatch):
        monkeypatch.setattr(collectors, "ROWS", 100)
        monkeypatch.setattr(collectors, "TEXTS", 10)
        monkeypatch.setattr(collectors, "SPANS", 10)

    def test_rows(self):
        rows = Thinned(lambda message: [message.data], 0.1)
        for step in range(10_000):
            rows.add(float(step), Float64(step * 0.2))
        time, value = rows.columns()
        assert len(time) <= 102 and (time[0], time[-1]) == (0.0, 9999.0) and value == pytest.approx(0.2 * time)

    def test_in_between_rows_are_within_the_tolerance(self):
        rows, times = Thinned(lambda message: [message.data], 0.1), np.arange(0.0, 10.0, 0.01)
        values = np.where(times < 5, 0.0, 1.0) + 0.05 * np.sin(20 * times)
        for time, value in zip(times, values):
            rows.add(time, Float64(value))
        kept = rows.columns()
        assert len(kept[0]) < 10 and abs(np.interp(times, *kept) - values).max() < 0.2

    def test_echoes(self):
        echoes = EchoCollector()
        for step in range(10_000):
            echoes.add(float(step), make.sonar([1.0 + step % 7 * 0.1, 2.0]))
        times = echoes.rows[::3]
        assert 40 < len(times) <= 102 and times[-1] > 9000

    def test_spans_keep_the_longest(self):
        spans = SpanCollector(lambda message: "left wheel" if message.left else "")
        for step in range(1000):
            spans.add(float(step), make.stall(step % 4 == 0 or 500 < step < 520, False))
        assert len(spans.spans) <= 20 and max(spans.spans, key=lambda span: span.end - span.begin)[:2] == (500.0, 521.0)
        assert spans.spans == sorted(spans.spans)

    def test_decisions(self):
        decisions = DecisionCollector(doing)
        for step in range(1001):
            decisions.add(float(step), make.decision(float(step), str(step)))
        assert len(decisions.spans) <= 20 and decisions.spans[-1] == (1000.0, 1000.0, "1000")

    def test_gaps(self):
        silence = SilenceCollector()
        for step in range(3000):
            silence.add(step * 0.1 + step // 50)
        gaps = silence.gaps("/x", 359.0)
        assert 10 <= len(gaps) <= 20 and {gap.what for gap in gaps} == {"/x"}
        assert all(gap.end - gap.begin == pytest.approx(1.1) for gap in gaps)


def test_a_span_lasts_until_its_words_change():
    spans = SpanCollector(lambda message: str(message.data or ""))
    for time, value in enumerate([False, True, True, False, True]):
        spans.add(float(time), Bool(value))
    assert spans.spans == [Span(1.0, 3.0, "True"), Span(4.0, 4.0, "True")]


def test_a_decision_holds_until_the_next_of_its_wander():
    decisions = DecisionCollector(doing)
    for time, reason in ((1, "driving: 2 m"), (3, "driving: 1 m"), (5, "turning left: x"), (8, "driving: 2 m"), (9, ""),
                         (15, "driving: 3"), (17, "driving: 3")):
        decisions.add(float(time), make.decision(0.0, reason, wander=1 + (time > 9)))
    assert decisions.spans == [(1.0, 5.0, "driving"), (5.0, 8.0, "turning"), (8.0, 9.0, "driving"),
                               (9.0, 9.0, "no reason"), (15.0, 17.0, "driving")]


class TestLooksOfACamera:
    """Where a camera looked, from rows of time, pan and zoom."""

    def test_each_direction_and_zoom_that_lasted_in_order_of_time(self):
        rows = [(0.0, 0, 0), (5.0, 0, 0), (5.1, 10, 0), (5.2, 20, 0), (5.3, 30, 0), (8.0, 30, 0), (8.1, 30, 1960),
                (9.2, 30, 1960)]
        looks = looks_of(rows)
        assert [(look.begin, look.end) for look in looks] == [(0.0, 5.0), (5.3, 8.0), (8.1, 9.2)]
        assert [round(math.degrees(look.bearing)) for look in looks] == [0, -30, -30]
        assert [round(math.degrees(look.width)) for look in looks] == [45, 45, 3]

    def test_of_many_the_longest(self):
        rows = [(10.0 * number + end * (1 + number), number, 0) for number in range(9) for end in (0, 1)]
        rows += [(100.0 + 20.0 * number + 10.0 * end, number, 0) for number in range(LOOKS) for end in (0, 1)]
        looks = looks_of(rows)
        assert len(looks) == LOOKS and looks[0].begin == 100.0 and list(looks) == sorted(looks)

    def test_without_a_camera_there_are_none(self):
        assert looks_of([]) == ()

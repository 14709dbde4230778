"""Recording without a master: what the launch file requests, which topics are kept, and how a recording describes
itself.
"""

import contextlib
import datetime
import io
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
import xmlrpc.client

import pytest
from roslaunch.config import load_config_default
from std_msgs.msg import String

from pioneer_control.bags.command_line import parser_of
from pioneer_control.bags.recording import attendant, description, start
from pioneer_control.bags.reader import decode, read_bag
from pioneer_control.bags.recording.plan import OPTIONS, RecordingPlan, plan_of
from pioneer_control.bags.recording.topics import groups_to_ask_for, load_list
from pioneer_control.bags.writer import BagWriter
from pioneer_control.driver import requests
from pioneer_control.driver.conversions import WHEEL_JOINTS
from pioneer_control.errors import UsageError

ROOT = pathlib.Path(__file__).resolve().parents[3]
NOW = datetime.datetime(2026, 11, 21, 18, 5, 9).timetuple()
DRAWN = ("pose sonar gripper_state motor_state battery_state e_stop stall bumpers robot_info ground_truth cans map "
         "world cmd_vel decision recording")
MADE = RecordingPlan(("a", "b"), ("/a/pose", "/b/pose", "/a/wire", "/tf"), ("/a/wire",), "/data/x", "lz4", ("", 0), 0)


def node(*arguments):
    """Return the recorder node of record.launch."""
    (only,) = load_config_default([(str(ROOT / "launch" / "record.launch"), list(arguments))], None,
                                  verbose=False).nodes
    return only


def recording(*arguments):
    return plan_of(parser_of("record", "", OPTIONS).parse_args(shlex.split(node(*arguments).args)), NOW)


class TestLaunchFile:
    def test_all_that_is_drawn_and_commanded_is_recorded(self):
        kept = set(recording().topics)
        assert {"/pioneer/%s" % name for name in DRAWN.split()} <= kept
        assert {"/pioneer/%s" % topic.name for topic in requests.TOPICS} <= kept
        assert {"/tf", "/tf_static", "/rosout", "/diagnostics", "/pioneer/recording"} <= kept
        assert WHEEL_JOINTS and "/pioneer/joint_states" in kept, "the wheels of a robot that is played back"

    def test_other_robots(self):
        assert (node("robot:=alice").namespace, node("robot:=alice").name) == ("/alice/", "recorder")
        assert recording("robot:=alice").robots == ("alice",)
        assert node("robots:=alice, bob").namespace == "/alice/"
        assert recording("robots:=alice bob").robots == ("alice", "bob")

    def test_files_are_looked_for_where_the_command_is_typed_in(self, monkeypatch):
        monkeypatch.setenv("PWD", "/my lab")
        assert shlex.split(node().launch_prefix) == ["env", "--chdir=/my lab"]

    def test_it_gives_what_holds_without_it(self):
        assert recording() == plan_of(parser_of("record", "", OPTIONS).parse_args([]), NOW)

    def test_all_that_can_be_said(self):
        made = recording("bag:=/data/my runs/x.bag", "split:=1h", "also:=wire packets", "compression:=bz2",
                         "keep_free:=1GB")
        assert (made.stem, made.split, made.compression,
                made.keep_free) == ("/data/my runs/x", ("duration", 3600), "bz2", 2 ** 30)
        assert set(made.asked_for) == {
            "/pioneer/wire", "/pioneer/io", "/pioneer/imu", "/pioneer/encoders", "/pioneer/joystick"}


class TestDocument:
    """docs/recording.md lists all arguments of record.launch, and all groups that `also:=` accepts."""

    text = (ROOT / "docs" / "recording.md").read_text(encoding="utf-8")

    def rows(self, head):
        """Return the names in the first column of the table that has this head."""
        table = self.text.split("| %s |" % head)[1].split("\n\n")[0]
        return [name for row in table.splitlines()[2:] for name in re.findall("`(.*?)`", row.split(" |")[0])]

    def test_arguments_are_those_of_the_launch_file(self):
        launch = ElementTree.parse(ROOT / "launch" / "record.launch").getroot()
        assert sorted(self.rows("argument")) == sorted(argument.get("name") for argument in launch.iter("arg"))

    def test_groups_are_those_that_can_be_asked_for(self):
        assert self.rows("`also:=`") == list(groups_to_ask_for(load_list(str(ROOT / "config" / "record.yaml"))))


class TestClosedTerminal:
    """A terminal that is closed sends SIGHUP to the recorder and to its attendant.

    The recorder ignores it, because it would be killed. The attendant tells the recorder to end, as Ctrl-C does.
    """

    @pytest.fixture
    def begun(self, tmp_path, monkeypatch):
        """Start a recorder until it has forked, with a given handler of SIGHUP. Returns the handlers of SIGHUP
        afterwards: (the recorder's, its attendant's).
        """

        def begun(before):
            found = []
            monkeypatch.chdir(tmp_path)
            monkeypatch.setattr(sys, "argv", ["record", "a"])
            monkeypatch.setenv("ROS_NAMESPACE", "/a")
            monkeypatch.setattr(start, "check_alone", lambda node: None)
            monkeypatch.setattr(os, "execvp", lambda *command: found.append(signal.getsignal(signal.SIGHUP)))
            monkeypatch.setattr(attendant, "attend", lambda *about: found.append(signal.getsignal(signal.SIGHUP)))
            usual = signal.signal(signal.SIGHUP, before)
            try:
                for child in (1, 0):
                    signal.signal(signal.SIGHUP, before)
                    monkeypatch.setattr(os, "fork", lambda: child)
                    with contextlib.suppress(SystemExit):
                        start.main()
            finally:
                signal.signal(signal.SIGHUP, usual)
            return found[0], found[-1]

        return begun

    def test_the_recorder_hears_nothing_of_it_and_is_told_to_end(self, begun, monkeypatch):
        recorder, attentive = begun(signal.SIG_DFL)
        told = []
        monkeypatch.setattr(os, "kill", lambda *what: told.append(what))
        attentive(signal.SIGHUP, None)
        assert recorder == signal.SIG_IGN and told == [(os.getpid(), signal.SIGINT)]

    def test_nohup_is_respected(self, begun):
        assert begun(signal.SIG_IGN) == (signal.SIG_IGN, signal.SIG_IGN)


class TestDescription:
    parameters = {
        "rosdistro": "noetic\n",
        "pioneer": {
            "p2os": {"port": "/dev/ttyUSB0", "gains": [1.0, 2], "on": True},
            "deep": {"er": {"seed": 7}},
        },
    }

    def made(self, **parameters):
        publishers = [["/a/pose", ["/a/p2os"]]]
        subscribers = [["/a/pose", ["/rviz"]], ["/a/cmd_vel", ["/a/p2os"]]]
        services = [["/a/set", ["/a/p2os"]]]
        nodes = description.nodes_of([publishers, subscribers, services])
        return description.Description({"robots": ["a"]}, {"python": "3.8"}, nodes, parameters or self.parameters)

    def test_comes_back_as_it_was(self):
        made = self.made()
        assert description.description_of(description.text_of(made)) == made
        assert made.nodes == {"/a/p2os": {"serves": ["/a/set"], "publishes": ["/a/pose"], "hears": ["/a/cmd_vel"]},
                              "/rviz": {"hears": ["/a/pose"]}}

    def test_parameters_of_a_node(self):
        made = self.made()
        assert made.parameters_of("/pioneer/p2os") == self.parameters["pioneer"]["p2os"]
        assert made.parameters_of("/pioneer/deep/er") == {"seed": 7}
        for name in ("/pioneer/p2os/port", "/pioneer/p2os/port/x", "/nobody"):
            assert made.parameters_of(name) == {}

    def test_the_text_is_for_people(self):
        text = description.text_of(self.made(owner="Zoë"))
        assert text.startswith("recording:") and "owner: Zoë" in text

    def test_the_key_of_a_port_is_left_out(self):
        made = self.made(pioneer={"p2os": {"port": "ws://teacher:8080/robot/7#key=sesame"}}, note="press # to answer")
        text = description.text_of(made)
        assert "sesame" not in text and "key" not in text
        assert description.description_of(text).parameters == {
            "pioneer": {"p2os": {"port": "ws://teacher:8080/robot/7"}}, "note": "press # to answer"}

    def test_what_a_text_leaves_empty_is_empty(self):
        made = description.description_of("recording: {robots: [a]}\nparameters:\n")
        assert made == ({"robots": ["a"]}, {}, {}, {}) and made.parameters_of("/a") == {}

    def test_the_masters_order_changes_nothing(self):
        states = [[[[topic, ["/a/p2os"]] for topic in topics], [], []] for topics in (["/b", "/a"], ["/a", "/b"])]
        assert [description.nodes_of(state) for state in states] == [{"/a/p2os": {"publishes": ["/a", "/b"]}}] * 2

    def test_its_date_is_the_same_wherever_it_is_read(self):
        date = attendant.Descriptions(MADE, print)._recording["date"]
        assert datetime.datetime.fromisoformat(date).utcoffset() is not None

    def test_what_only_the_parameter_server_knows_is_written_as_text(self):
        made = self.made(picture=xmlrpc.client.Binary(b"\x00\xff"), when=xmlrpc.client.DateTime("20261121T18:00:00"),
                         same=[self.parameters] * 2)
        back = description.description_of(description.text_of(made))
        assert isinstance(back.parameters["picture"], str) and isinstance(back.parameters["when"], str)
        assert back.parameters["same"] == [self.parameters] * 2

    @pytest.mark.parametrize("text", ["", "a picture", "{a: 1}", "{recording: {}", "parameters: {}", "recording: {}"])
    def test_another_text_is_none(self, text):
        with pytest.raises(UsageError, match="no description of a recording"):
            description.description_of(text)

    @pytest.mark.parametrize("parameters", ["a: &a [1]\n  b: [*a, *a, *a]", "a: " + "[" * 5000, "day: 2026-99-99"],
                             ids=["aliases", "deep", "date"])
    def test_texts_that_no_recorder_wrote(self, parameters):
        """Nine lines with aliases can become a thousand million values on the parameter server."""
        with pytest.raises(UsageError, match="no description of a recording"):
            description.description_of("recording: {}\nparameters:\n  %s\n" % parameters)

    def test_versions_name_the_package_and_what_it_runs_on(self, tmp_path):
        known = description.versions()
        assert {"pioneer_control", "rospy", "rosbag", "python", "system",
                "kernel"} <= set(known) and all(known.values())
        (tmp_path / "module.py").write_text("")
        assert "commit" not in description.versions(str(tmp_path / "module.py"))

    @pytest.mark.skipif(shutil.which("git") is None, reason="there is no git")
    def test_the_commit_of_a_file_and_whether_all_is_as_committed(self, tmp_path):
        def git(*arguments):
            who = "-c", "user.name=a", "-c", "user.email=a@b"
            command = ["git", "-C", str(tmp_path), *who, *arguments]
            return subprocess.run(command, check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout.strip()

        module, other = tmp_path / "module.py", tmp_path / "other.py"
        git("init", "--quiet")
        module.write_text("one")
        git("add", "module.py")
        git("commit", "--quiet", "-m", "one")
        other.write_text("of nobody's")
        commit = git("rev-parse", "HEAD")
        assert (description.commit_of(str(module)),
                description.commit_of(str(other))) == (commit, None), "what is not in the repository has no commit"
        module.write_text("two")
        assert description.commit_of(str(module)) == commit + " and changes"


class TestDescriptions:
    """When the description of a recording is published again."""

    @pytest.fixture
    def said(self):
        return []

    @pytest.fixture
    def descriptions(self, said):
        return attendant.Descriptions(MADE, said.append)

    STATE = [[["/a/pose", ["/a/p2os"]]], [], []]

    def test_once_as_long_as_nothing_changes(self, descriptions, said):
        for time in range(0, 300, 3):
            descriptions.look(float(time), self.STATE, {"a": 1})
        (text,) = said
        made = description.description_of(text)
        assert made.recording["robots"] == ["a", "b"]
        assert made.recording["topics"] == list(MADE.topics)
        assert made.parameters == {"a": 1}

    def test_again_when_a_parameter_or_a_node_is_another(self, descriptions, said):
        descriptions.look(0.0, self.STATE, {"a": 1})
        descriptions.look(10.0, self.STATE, {"a": 2})
        descriptions.look(20.0, [[["/a/pose", ["/a/p2os", "/b/p2os"]]], [], []], {"a": 2})
        assert [description.description_of(text).parameters for text in said] == [{"a": 1}, {"a": 2}, {"a": 2}]

    def test_what_flickers_fills_no_bag_but_its_last_state_is_said(self, descriptions, said):
        for time in range(0, 3600):
            descriptions.look(float(time), self.STATE, {"a": time})
        assert 10 < len(said) < 40
        descriptions.look(1e6, self.STATE, {"a": "last"})
        assert description.description_of(said[-1]).parameters == {"a": "last"}

    def test_again_in_each_part(self, descriptions, said):
        for time, parts in (0.0, 1), (1.0, 1), (2.0, 2), (3.0, 2), (4.0, 3):
            descriptions.look(time, self.STATE, {"a": 1}, parts)
        assert len(said) == 3 and len(set(said)) == 1


def part_begin(number):
    """Time (ns) at which a part of a recording begins."""
    return (100 + 100 * number) * 10 ** 9


@pytest.mark.parametrize("release", ["rosbag 1.15", "rosbag 1.17"])
class TestParts:
    """All parts together have exactly what was published.

    The reader leaves out what rosbag repeats in each part: the first message of each publisher that latches.
    """

    @pytest.fixture
    def write(self, tmp_path, release):
        """Write a part as this release of rosbag does.

        It has the messages that rosbag repeats, and (topic, text, publisher[, time in ns]), a second apart.
        """

        def connection(bag, topic, publisher, latching="1"):
            header = {"type": String._type, "md5sum": String._md5sum, "message_definition": String._full_text}
            if publisher:
                header.update(topic=topic, callerid=publisher, latching=latching)
            return bag.connect(topic, header)

        def write(number, repeated, *messages, plain=()):
            """Write a part. `repeated` has (topic, text, publisher), and `plain` has the topics that do not latch."""
            path = str(tmp_path / ("x_%d.bag" % number))
            bag, begin = BagWriter(path), part_begin(number)
            for topic, text, publisher in repeated:
                known = publisher if release == "rosbag 1.17" else ""
                bag.write(connection(bag, topic, known), self.serialized(text), begin)
            for count, (topic, text, publisher, *at) in enumerate(messages):
                time = at[0] if at else begin - 500 + count * 10 ** 9
                latching = "0" if topic in plain else "1"
                bag.write(connection(bag, topic, publisher, latching), self.serialized(text), time)
            bag.close()
            return path

        return write

    @staticmethod
    def serialized(text):
        written = io.BytesIO()
        String(text).serialize(written)
        return written.getvalue()

    @staticmethod
    def texts(*paths, topics=None):
        reader = read_bag(paths, lambda connection: topics is None or connection.topic in topics)
        return [decode(message.connection, message.data).data for message in reader]

    def test_what_is_repeated_is_no_news(self, write):
        repeated = [("/a", "one", "/p"), ("/a", "of another", "/q")]
        first = write(0, [], ("/a", "one", "/p"), ("/a", "two", "/p"), ("/a", "of another", "/q"))
        second = write(1, repeated, ("/a", "three", "/p"))
        third = write(2, repeated, ("/b", "many", "/p"), ("/a", "one", "/p"))
        assert self.texts(first, second, third) == ["one", "two", "of another", "three", "many", "one"]
        assert sorted(self.texts(second)) == ["of another", "one", "three"], "a part alone has it"

    def test_a_part_with_nothing_else(self, write):
        first = write(0, [], ("/a", "one", "/p"))
        assert self.texts(first, write(1, [("/a", "one", "/p")])) == ["one"]

    def test_the_publishers_name_does_not_matter_to_another_publisher(self, write):
        first = write(0, [], ("/a", "one", "/p"), ("/a", "two", "/q"))
        second = write(1, [], ("/a", "two", "/p"), ("/a", "one", "/q"))
        assert self.texts(first, second) == ["one", "two", "two", "one"]

    def test_what_the_first_part_repeats_of_itself_is_no_news(self, write):
        """A message that comes before rosbag has opened the file is in it twice, the earlier time behind the later one.
        This happens on a busy machine.
        """
        first = write(0, [("/a", "one", "/p")], ("/a", "one", "/p", part_begin(0) - 10 ** 9), ("/a", "one", "/p"),
                      ("/b", "one", "/p"))
        second = write(1, [("/a", "one", "/p")], ("/b", "two", "/p"))
        found = self.texts(first, second)
        assert found == ["one", "one", "one", "two"], "a second delivery is news, and so is another topic"

    def test_what_was_not_there_before_is_news(self, write):
        second = write(1, [("/a", "one", "/p"), ("/b", "two", "/p")], ("/a", "three", "/p"))
        third = write(2, [("/a", "one", "/p"), ("/b", "two", "/p")], ("/a", "four", "/p"))
        first = write(0, [], ("/b", "two", "/p"), ("/a", "other", "/p"))
        expected = ["two", "other", "one", "three"] + ["one"] + ["four"]
        assert sorted(self.texts(first, second, third)) == sorted(expected), "the first part has another one"

    def test_a_state_that_comes_back_is_news_wherever_it_does(self, write):
        first = write(0, [], ("/stop", "off", "/p"), ("/stop", "on", "/p"))
        without_repeats = write(1, [], ("/stop", "off", "/p"), ("/stop", "on", "/p"))
        second = write(2, [("/stop", "off", "/p")], ("/c", "x", "/p"), ("/stop", "off", "/p"))
        assert self.texts(first, without_repeats) == ["off", "on", "off", "on"]
        assert self.texts(first, second) == ["off", "on", "x", "off"]
        assert self.texts(first, without_repeats, topics=["/stop"]) == ["off", "on", "off", "on"]

    def test_what_does_not_latch_is_news(self, write):
        first = write(0, [], ("/a", "one", "/p"), plain=["/a"])
        assert self.texts(first, write(1, [], ("/a", "one", "/p"), plain=["/a"])) == ["one", "one"]

    def test_in_simulated_time_that_stands(self, write):
        """Everything has one time: the message before the repeated one, the repeated message, and the message after it.
        """
        first = write(0, [], ("/stop", "off", "/p"), ("/stop", "on", "/p"))
        second = write(1, [("/stop", "off", "/p")], ("/c", "x", "/p", part_begin(1)),
                       ("/stop", "off", "/p", part_begin(1)), plain=["/c"])
        assert self.texts(first, second) == ["off", "on", "x", "off"]

    @pytest.mark.parametrize("wanted", [["/stop"], ["/map"], ["/map", "/stop"], ["/c"]])
    def test_of_some_topics_and_over_several_chunks(self, write, wanted):
        repeated = [("/map", "m" * (1 << 20), "/m"), ("/other", "o" * (1 << 20), "/m"), ("/stop", "off", "/p")]
        first = write(0, [], *repeated, ("/stop", "on", "/p"))
        second = write(1, repeated, ("/c", "c" * (1 << 20), "/p"), ("/c", "d" * (1 << 20), "/p"),
                       ("/stop", "off", "/p"))
        texts = {"/stop": ["off", "on", "off"], "/map": ["m" * (1 << 20)], "/c": ["c" * (1 << 20), "d" * (1 << 20)]}
        expected = [text for topic in wanted for text in texts[topic]]
        assert sorted(self.texts(first, second, topics=wanted)) == sorted(expected)


class TestSilent:
    def texts(self, published):
        return list(attendant.silent(MADE, [[[topic, ["/node"]] for topic in published], [], []]))

    def test_nothing_to_say(self):
        assert self.texts(["/a/pose", "/b/pose", "/a/wire"]) == []

    def test_a_robot_that_nobody_has(self):
        (text,) = self.texts(["/a/pose", "/a/wire", "/pioneer/pose", "/b/recording"])
        assert "nothing is published under /b" in text and "There are: a, pioneer" in text

    def test_no_robot_at_all(self):
        assert "There is no robot at all yet" in self.texts([])[0]

    def test_what_was_asked_for_and_is_not_there(self):
        (text,) = self.texts(["/a/pose", "/b/pose"])
        assert "nothing publishes /a/wire" in text and "publish_wire" in text


class TestBegins:
    """Without a clock, the recorder waits and records nothing. Nobody may believe meanwhile that it records."""

    def told(self, monkeypatch, tmp_path, time, moments, appears=None):
        """Return whether recording began, and the warnings until then.

        The attendant looks ``moments`` times at most. The bag appears at the look with the number ``appears``.
        """
        monkeypatch.setattr(attendant, "BEGIN", 0.0)
        monkeypatch.setattr(attendant.rospy, "get_time", lambda: time)
        made, left, told = MADE._replace(stem=str(tmp_path / "x")), list(range(moments)), []
        monkeypatch.setattr(attendant.rospy, "logwarn", told.append)

        def goes_on():
            if left.pop(0) == appears:
                (tmp_path / "x.bag.active").write_bytes(b"")
            return bool(left)

        return attendant.begins(made, goes_on), told

    def test_without_a_clock_it_is_said_once(self, monkeypatch, tmp_path):
        began, (text,) = self.told(monkeypatch, tmp_path, 0.0, 9)
        assert not began and "nothing is recorded yet" in text and "rosparam set /use_sim_time false" in text

    def test_the_clock_comes_later(self, monkeypatch, tmp_path):
        began, told = self.told(monkeypatch, tmp_path, 0.0, 9, appears=5)
        assert began and len(told) == 1

    def test_it_is_only_slow(self, monkeypatch, tmp_path):
        assert self.told(monkeypatch, tmp_path, 1795290069.0, 9) == (True, [])


class TestLookingBack:
    @pytest.fixture
    def last_words(self, monkeypatch):
        """Return the severity and text of the last message about a plan, when the disk has so many free bytes."""

        def last_words(plan, free):
            said = []
            for name in ("info", "err"):
                monkeypatch.setattr(attendant.rospy, "log" + name,
                                    lambda text, *parts, name=name: said.append((name, text % parts)))
            attendant.last_words(plan, free)
            (words,) = said
            return words

        return last_words

    def made(self, tmp_path, *there):
        for name in there:
            (tmp_path / name).write_bytes(b"")
        return MADE._replace(stem=str(tmp_path / "x"), split=("size", 1) if "x_0.bag" in there else ("", 0))

    def test_a_bag_that_was_closed(self, tmp_path, last_words):
        severity, text = last_words(self.made(tmp_path, "x_0.bag", "x_1.bag"), 1)
        assert severity == "info" and text.endswith("x_1.bag is closed")

    def test_a_full_disk(self, tmp_path, last_words):
        severity, text = last_words(self.made(tmp_path, "x.bag"), 0)
        assert severity == "err" and "because the disk is full" in text and "x.bag is closed and whole" in text

    @pytest.mark.parametrize("free", [0, 1])
    def test_a_recorder_that_was_killed(self, tmp_path, last_words, free):
        severity, text = last_words(self.made(tmp_path, "x_0.bag", "x_1.bag.active"), free)
        assert severity == "err" and "was killed" in text and "x_1.bag.active" in text and "reindex" in text

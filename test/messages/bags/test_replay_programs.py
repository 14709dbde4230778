"""The bag that a re-run or a re-drive keeps, and programs that end. Only the test in which a master is killed starts a
master.
"""

import contextlib
import signal
import socket
import subprocess
import sys
import time
from unittest.mock import Mock

import genpy
import pytest
import rosbag
from geometry_msgs.msg import Twist

from pioneer_control.bags.command_line import free_name
from pioneer_control.bags.replaying import programs
from pioneer_control.bags.reader import decode, read_bag
from pioneer_control.errors import NoAnswerError, UsageError


class TestTopicRecorder:
    def test_what_it_is_given_is_in_the_bag_at_its_time(self, tmp_path):
        twist = Twist()
        twist.linear.x = 0.25
        with programs.TopicRecorder(str(tmp_path / "x.bag"), lambda: genpy.Time(7)) as recorder:
            recorder.write(twist, "/pioneer/cmd_vel")
        recorder.write(twist, "/pioneer/cmd_vel")     # too late
        ((topic, connection, data, nanoseconds),) = read_bag(recorder.path)
        assert (topic, nanoseconds, decode(connection, data)) == ("/pioneer/cmd_vel", 7 * 10 ** 9, twist)
        assert recorder.counts == {topic: 1} and recorder.newest[topic] is twist

    def test_what_it_hears_keeps_its_bytes_and_its_sender(self, tmp_path):
        senders = ["/somebody", "/another", "/somebody"]
        with programs.TopicRecorder(str(tmp_path / "x.bag"), lambda: genpy.Time(7)) as recorder:
            for number, sender in enumerate(senders):
                message = programs.rospy.AnyMsg()
                message._buff = bytes([number]) * 48
                message._connection_header = dict(
                    type=Twist._type, md5sum=Twist._md5sum, message_definition=Twist._full_text, callerid=sender,
                    topic="/rerun/cmd_vel")
                recorder.write(message, "/cmd_vel")
        kept = list(read_bag(recorder.path))
        assert [(entry.data, entry.connection.caller)
                for entry in kept] == [(bytes([number]) * 48, sender) for number, sender in enumerate(senders)]
        connections = {(entry.topic, entry.connection.type, entry.connection.header["topic"]) for entry in kept}
        assert connections == {("/cmd_vel", "geometry_msgs/Twist", "/cmd_vel")}
        with rosbag.Bag(recorder.path) as bag:
            assert [topic for topic, _, _ in bag.read_messages()] == ["/cmd_vel"] * 3

    def test_a_bag_with_nothing_in_it_is_not_left_behind(self, tmp_path):
        with programs.TopicRecorder(str(tmp_path / "x.bag"), lambda: genpy.Time(7)):
            pass
        assert list(tmp_path.iterdir()) == []

    def test_where_it_is_is_told_of_something_that_ended_before_it_was_done(self, tmp_path, capsys):
        for error in (None, OSError):
            path = str(tmp_path / ("%s.bag" % error))
            with contextlib.suppress(OSError), programs.TopicRecorder(path, lambda: genpy.Time(7)) as recorder:
                recorder.write(Twist(), "/pioneer/cmd_vel")
                if error:
                    raise error
        assert capsys.readouterr().out == "What happened until it ended is in %s\n" % recorder.path
        assert len(list(read_bag(recorder.path))) == 1

    def test_nothing_is_overwritten(self, tmp_path):
        (tmp_path / "x.bag").write_text("mine")
        with pytest.raises(UsageError, match="x.bag is there already"):
            programs.TopicRecorder(str(tmp_path / "x.bag"), lambda: genpy.Time(7))
        assert (tmp_path / "x.bag").read_text() == "mine"

    def test_a_place_where_there_can_be_none(self, tmp_path):
        with pytest.raises(UsageError, match="nowhere/x.bag cannot be written: No such file or directory"):
            programs.TopicRecorder(str(tmp_path / "nowhere" / "x.bag"), lambda: genpy.Time(7))


def test_names_that_are_free(tmp_path):
    bag = str(tmp_path / "run.bag")
    names = []
    for _ in range(3):
        names.append(free_name(bag, "rerun"))
        open(names[-1], "w").close()
    assert names == [str(tmp_path / name) for name in ("run-rerun.bag", "run-rerun-2.bag", "run-rerun-3.bag")]


KILL_THE_MASTER = """
import os, signal, subprocess, sys, time, rosgraph
from pioneer_control.bags.replaying import programs

master = subprocess.Popen(["rosmaster", "--core", "-p", sys.argv[1]])
os.environ["ROS_MASTER_URI"] = "http://localhost:" + sys.argv[1]
while not rosgraph.is_master_online():
    assert master.poll() is None
    time.sleep(0.05)

def run():
    assert programs.nodes() == ["/rerun"]
    master.kill()
    master.wait()
    programs.nodes()

try:
    sys.exit(programs.run_as_node("rerun", run))
finally:
    master.kill()
"""


class TestCarryOut:
    def test_a_master_that_ends_in_the_midst_is_told(self):
        with socket.create_server(("localhost", 0)) as free:
            port = str(free.getsockname()[1])
        done = subprocess.run([sys.executable, "-c", KILL_THE_MASTER, port], stderr=subprocess.PIPE,
                              universal_newlines=True)
        assert "rerun: there is no ROS master at http://localhost:%s: start roscore" % port in done.stderr
        assert "Traceback" not in done.stderr and done.returncode == 1

    def test_what_has_other_reasons_is_not_laid_on_the_master(self, monkeypatch):
        monkeypatch.setattr(programs, "become_node", lambda name: None)
        monkeypatch.setattr(programs.rosgraph, "is_master_online", lambda: True)
        with pytest.raises(OSError, match="disk full"):
            programs.run_as_node("rerun", Mock(side_effect=OSError("disk full")))

    @pytest.mark.parametrize("error, code", [
        (UsageError("why"), 2),
        (NoAnswerError("why"), 1),
        (programs.rospy.ROSException("why"), 1),
    ])
    def test_errors_are_sentences(self, monkeypatch, capsys, error, code):
        monkeypatch.setattr(programs, "become_node", lambda name: None)
        assert programs.run_as_node("rerun", Mock(side_effect=error)) == code
        assert capsys.readouterr().err == "rerun: why\n"


class TestPrograms:
    def test_one_that_hears_ctrl_c_ends_by_itself(self):
        with programs.running([sys.executable, "-c", "import time; print('x', flush=True); time.sleep(60)"],
                              quiet=True) as process:
            assert process.poll() is None
        assert process.poll() in (1, -signal.SIGINT)

    def test_one_that_does_not_is_killed(self, monkeypatch, tmp_path):
        monkeypatch.setattr(programs, "LAST_WORDS", (0.2, 0.2))
        ready = tmp_path / "ready"
        code = ("import signal, time; [signal.signal(n, signal.SIG_IGN) for n in (2, 15)]; open(%r, 'w'); "
                "time.sleep(60)" % str(ready))
        with programs.running([sys.executable, "-c", code]) as process:
            while not ready.exists():
                time.sleep(0.01)
        assert process.poll() == -signal.SIGKILL

    def test_one_that_has_ended_tells_its_code(self):
        with programs.running([sys.executable, "-c", "raise SystemExit(3)"]) as process:
            process.wait()
        assert process.poll() == 3

    def test_one_is_ended_whatever_happens(self):
        with pytest.raises(OSError), programs.running([sys.executable, "-c", "import time; time.sleep(60)"]) as process:
            raise OSError
        assert process.poll() is not None


class TestAlive:
    @pytest.mark.parametrize("publishers, subscribers, found", [
        ({"/a/motor_state": ["/a/p2os"], "/a/pose": ["/a/p2os"]}, {"/a/cmd_vel": ["/a/p2os"]},
         ["/a/p2os (/a/motor_state)"]),
        ({}, {"/base/cmd_vel": ["/base/driver"]}, ["/base/driver (/base/cmd_vel)"]),
        ({}, {"cmd_wheels": ["/x"]}, ["/x (cmd_wheels)"]),
        ({"/rosout": ["/y"]}, {"/a/pose": ["/rviz"], "/a/stop_button": ["/simulator"]}, []),
        ({}, {"/a/recorded/cmd_vel": ["/x"], "/a/rerun/cmd_vel": ["/rerun"]}, [])])
    def test_who_may_be_a_robot(self, monkeypatch, publishers, subscribers, found):
        monkeypatch.setattr(programs, "graph", lambda: (publishers, subscribers, {}))
        assert programs.possible_robots() == found

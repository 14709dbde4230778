"""What a node prints appears at once, also in a file and in a pipe."""

import io
import os
import subprocess
import sys

from pioneer_control import ros_node

SAY_AND_BREAK_OFF = """
import os, rospy
from pioneer_control import ros_node

rospy.init_node = lambda *_, **__: (print("said"), os._exit(0))     # nothing is sent at such an end
%s("x")
"""


def wrapped():
    """Return a stream, and the buffer behind it."""
    raw = io.BytesIO()
    return io.TextIOWrapper(raw, encoding="utf-8"), raw


def test_each_line_is_sent():
    stream, raw = wrapped()
    ros_node._send_each_line(stream)
    stream.write("one\ntw")
    assert raw.getvalue().startswith(b"one\n")
    stream.write("o\n")
    assert raw.getvalue() == b"one\ntwo\n"


def test_without_that_it_is_kept():
    stream, raw = wrapped()
    stream.write("one\n")
    assert raw.getvalue() == b""


def test_what_is_no_stream_of_a_program_stays_as_it_is():
    ros_node._send_each_line(None, io.StringIO())


def printed(init_node):
    """Return what a program prints into a pipe when its Python buffers its output."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    return subprocess.run([sys.executable, "-c", SAY_AND_BREAK_OFF % init_node], env=environment,
                          stdout=subprocess.PIPE, check=True).stdout


def test_a_node_sends_each_line():
    assert printed("ros_node.init_node") == b"said\n"


def test_rospy_alone_does_not():
    assert printed("rospy.init_node") == b""

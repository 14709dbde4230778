"""CONTRIBUTING.md names the files that one cmd_vel crosses to the wire, and one SIP to its messages."""

import os
import re
import sys
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist, Vector3

import pioneer_control
from pioneer_control.msg import MotorState
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world

from bottle import Bottle

ROOT = os.path.dirname(os.path.realpath(pioneer_control.driver.__file__))
PACKAGE = os.path.dirname(ROOT) + os.sep
# The files that a bottle does not run, since it has no port to read from or to write to.
BEFORE = {"cmd_vel": [], "SIP": ["client/transport.py", "client/threads.py"]}
BEHIND = {"cmd_vel": ["client/transport.py"], "SIP": []}
AT_MOST = {"cmd_vel": 11, "SIP": 13}     # files; of a SIP twelve, and driver/prompt.py, which can be skipped


class Trace:
    """The calls within the package from begin() to end()."""

    def __init__(self):
        self.calls = []     # (file of the caller, file, function)
        self.files = []     # in the order in which they are met

    def begin(self):
        sys.setprofile(self._look)

    def end(self):
        sys.setprofile(None)

    def _look(self, frame, event, _):
        if event == "call":
            file, caller = self._place(frame), frame.f_back
            while caller is not None and self._place(caller) is None:
                caller = caller.f_back
            if file is not None:
                self.calls.append((caller and self._place(caller), file, frame.f_code.co_name))
                if file not in self.files:
                    self.files.append(file)

    @staticmethod
    def _place(frame):
        file = os.path.realpath(frame.f_code.co_filename)
        return file[len(PACKAGE):] if file.startswith(PACKAGE) and "/simulator/" not in file else None


def drive(bottle):
    bottle.send("cmd_vel", Twist(Vector3(0.2, 0, 0), Vector3(0, 0, 0)))


def cmd_vel(bottle, path):
    path.begin()
    bottle.at_write = lambda data: path.end()
    drive(bottle)
    path.end()
    yield 0.1


def sip(bottle, path):
    bottle.listened = {"pose", "sonar"}
    bottle.node._publications._listeners_changed = True
    yield 0.1
    read, published = bottle.line.read, []

    def read_and_begin(timeout):
        path.end()
        data = read(timeout)
        if data and not published:
            path.calls, path.files = [], []
            path.begin()
        return data

    def publish(topic):
        published.append(topic)
        if topic == "sonar":
            path.end()

    bottle.line.read, bottle.at_publish = read_and_begin, publish
    yield 0.3
    assert published[:2] == ["pose", "sonar"]


@pytest.fixture(params=[cmd_vel, sip])
def followed(request, monkeypatch):
    """Return what is followed, and its path. The robot drives, and everything that happens only once has happened."""
    path = Trace()

    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(15):
            drive(bottle)
            yield 0.1
        yield from request.param(bottle, path)

    try:
        firmware = Firmware(find_model("p3dx-sh"), load_world("empty"), gripper=False)
        Bottle(monkeypatch, script, firmware, link_check=request.param is cmd_vel)
    finally:
        path.end()
    return {cmd_vel: "cmd_vel", sip: "SIP"}[request.param], path


def documented(what):
    text = (Path(PACKAGE).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    paragraph = re.search(r"^\* \*\*One `?%s`?\*\*(.*?)(?=^\* |^$)" % what, text, re.M | re.S)[1]
    return re.findall(r"`((?:[a-z_0-9]+/)?[a-z_0-9]+\.py)`", paragraph)


def test_a_reader_meets_these_files_in_this_order_and_no_others(followed):
    what, path = followed
    met = list(dict.fromkeys(BEFORE[what] + path.files + BEHIND[what]))
    assert met == documented(what) and len(met) <= AT_MOST[what]


def knows(caller, file):
    """Return whether a file uses something of another file by its name."""
    names = ["pioneer_control." + each[:-3].replace("/", ".") for each in (caller, file)]
    used = vars(sys.modules[names[0]]).values()
    return any(getattr(each, "__module__", None) == names[1] for each in used)


def test_no_call_climbs_back(followed):
    """Each call goes to a later file, or to a file that the caller uses by its name. So no call goes back through a
    callback.
    """
    what, path = followed
    order = documented(what)
    climbs = [(caller, file, name) for caller, file, name in path.calls[1:]
              if caller is not None and order.index(file) < order.index(caller) and not knows(caller, file)]
    assert climbs == []

"""The whole driver in a bottle: DriverNode, its client and a simulated robot in one thread and in simulated time.

There is no master, no socket and no waiting. Lists replace rospy's publishers, subscribers and services. The line moves
the clock.
"""

import inspect
import math
import sys
import types
from collections import defaultdict

import rospy

import pioneer_control.driver.node as node_module
from pioneer_control.client import Robot
from pioneer_control.client.threads import BACK_OFF
from pioneer_control.driver.parameters import check_parameters
from pioneer_control.errors import LinkLostError, PortError
from pioneer_control.p2os import FrameDecoder, decode_command, encode_frame
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world

from robot_reports import received

STEP = 0.005
START = 1000.0      # s: when the clocks begin, ROS's too
FOREVER = 60.0      # s: no script is that long


class Bottle:
    """One run of the driver.

    ``script`` is a generator function that gets this object. It yields the seconds to wait, looks at what happened, and
    acts through send(), call() and the firmware. It begins when the robot is ready. When it ends, ROS shuts down.
    """

    def __init__(self, monkeypatch, script, firmware=None, caller="/somebody", before=None, **given):
        self.firmware = firmware or Firmware(find_model("p3dx-sh"), load_world("empty"), gripper=True, noise=0.0)
        self.now = START
        self.published = defaultdict(list)      # topic: [(time, message)]
        self.said = []                          # (level, text)
        self.opened = []                        # (url, baud)
        self.keys = set()                       # with which it was opened
        self.heard = []                         # by the robot: (time, command, value)
        self.velocities = []                    # what it really does: (s since it was ready, (m/s, rad/s))
        self.line = None
        self.set_parameters = {}                # on the parameter server
        self.ready_at = None
        self.listened = None                    # topics that somebody listens to; None: all
        self.at_write = self.at_publish = lambda *_: None       # called at each
        self.deaf_to = set()                    # commands that do not reach the robot
        self.is_offered = lambda service, timeout: False    # what the master says; None: it does not
        self._plugged = True
        self._caller = caller
        self._connections = {}                  # {topic: header}
        self._topics, self._services = {}, {}
        self._script, self._resume_at = script, START
        self._ear = FrameDecoder()
        self._replace(monkeypatch)
        if before is not None:
            before(self)
        self.node = node_module.DriverNode(check_parameters(given)[0])
        self.exit_code = self.node.run()

    @property
    def robot(self):
        """The node's client."""
        return self.node._robot

    def send(self, topic, message):
        """Publish a command."""
        message._connection_header = self._connections.setdefault(topic, {"callerid": self._caller})
        self._topics[topic](message)

    def connect_anew(self):
        """The next messages come from another publisher of the same name."""
        self._connections.clear()

    def call(self, service, *values):
        """Call a service. Call a service that waits for the robot in a separate thread."""
        kind, handler = self._services[service]
        return handler(kind._request_class(*values))

    def unplug(self, for_a_moment=False):
        """Pull the cable. With ``for_a_moment``, the next attempt to open the port works again."""
        self._plugged = for_a_moment
        self.line.lost = True

    def plug_in(self):
        """Put the cable back."""
        self._plugged = True

    def open(self, url, baud, key):
        """Return the line to the robot. The client calls this instead of opening a port."""
        self.keys.add(key)
        if not self._plugged:
            for _ in range(round(BACK_OFF / STEP)):
                self.pass_time(STEP)
            raise PortError("%s: no such port, the cable is pulled" % url)
        return Line(self, url, baud)

    def messages(self, topic):
        """All messages of a topic."""
        return [message for _, message in self.published[topic]]

    def commands(self, *names):
        """Return (s since the robot was ready, value) of each command with one of these names that the robot got."""
        return [(time - self.ready_at, value) for time, name, value in self.heard if name in names]

    def says(self, text):
        """Return whether the log has a line with this text."""
        return any(text in line for _, line in self.said)

    @property
    def warned(self):
        """Return all warnings."""
        return "\n".join(text for level, text in self.said if level == "warn")

    # The world around the driver

    def _replace(self, monkeypatch):
        bottle = self

        class Publisher:
            def __init__(self, name, kind, *_, **__):
                self.name, self.kind = name, kind

            def publish(self, message):
                bottle.published[self.name].append((bottle.now, received(message, self.kind)))  # it is written at once
                bottle.at_publish(self.name)

            def get_num_connections(self):
                return int(bottle.listened is None or self.name in bottle.listened)

            def unregister(self):
                pass

        def log(level):
            return lambda text, *values: self.said.append((level, text % values if values else text))

        monkeypatch.setattr(rospy, "Publisher", Publisher)
        monkeypatch.setattr(
            rospy, "Subscriber", lambda name, kind, callback, **_: self._topics.update({name: callback}))
        monkeypatch.setattr(
            rospy, "Service", lambda name, kind, handler: self._services.update({name: (kind, handler)}))
        monkeypatch.setattr(
            "pioneer_control.driver.senders.is_offered", lambda service, timeout: self.is_offered(service, timeout))
        monkeypatch.setattr(rospy, "set_param", self.set_parameters.__setitem__)
        monkeypatch.setattr(rospy, "resolve_name", lambda name: "/" + name)
        monkeypatch.setattr(rospy, "on_shutdown", lambda hook: None)
        monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time.from_sec(self.now))
        monkeypatch.setattr("pioneer_control.driver.publications.ros_time", lambda: self.now)
        for level in ("debug", "info", "warn", "err", "fatal"):
            monkeypatch.setattr(rospy, "log" + level, log(level))
        for name, module in list(sys.modules.items()):
            if name.startswith("pioneer_control.") and hasattr(module, "monotonic"):
                monkeypatch.setattr(module, "monotonic", lambda: self.now)
        silent = "start", "stop", "state", "event", "identity", "wake", "close"
        quiet = types.SimpleNamespace(**dict.fromkeys(silent, lambda *_: None))
        # Each of these has a thread of its own, in real time.
        monkeypatch.setattr(node_module, "Diagnostics", lambda *_, **__: quiet, raising=False)
        monkeypatch.setattr(node_module, "HelmPublisher", lambda: quiet)
        monkeypatch.setattr("pioneer_control.client.threads.open_transport", self.open)
        # This is a wait in real time; open() makes up for it.
        monkeypatch.setattr("pioneer_control.client.threads.BACK_OFF", 0.0)
        monkeypatch.setattr(Robot, "start", lambda robot: robot)
        # This thread does what the robot's threads do.
        monkeypatch.setattr(Robot, "wait_until_ended", lambda robot, timeout=None: robot._link.run())

    def pass_time(self, seconds):
        """Let time pass for the robot, then for the script. Returns what the robot sent."""
        self.now += seconds
        assert self.now < START + FOREVER, "the script does not end; said: %s" % self.said
        sent = self.firmware.advance(seconds)
        if self.ready_at is None and self.says("connected to"):
            self.ready_at = self._resume_at = self.now
            self._script = self._script(self)
            assert inspect.isgenerator(self._script)
        if self.ready_at is not None:
            self.velocities.append((self.now - self.ready_at, self.firmware.velocity))
        if self.now >= self._resume_at - STEP / 2 and self.ready_at is not None:
            wait = next(self._script, None)
            self._resume_at = math.inf if wait is None else self.now + wait
            if wait is None:
                self.node._end()
        return sent

    def hear(self, data):
        """Give bytes to the robot."""
        for frame in self._ear.feed(data):
            command = decode_command(frame)
            if command.name not in self.deaf_to:
                self.heard.append((self.now, command.name, command.value))
                self.firmware.receive(encode_frame(frame.id, frame.data))


class Line:
    """A Transport of the client to the bottle's robot. It is a serial port unless it has an address. Time passes while
    the client waits on it.
    """

    def __init__(self, bottle, url, baud):
        self.url = url
        self.baud = None if "://" in url else baud
        self._bottle = bottle
        self.lost = False
        self._woken = False
        bottle.opened.append((url, self.baud))
        bottle.line = self

    def read(self, timeout):
        until = self._bottle.now + timeout
        data = self._bottle.pass_time(STEP)     # at least: a closing robot wakes its line at every turn
        while not data and not self._woken and self._bottle.now < until - STEP / 2:
            data = self._bottle.pass_time(STEP)
        self._woken = False
        if self.lost:
            raise LinkLostError("%s: the cable is pulled" % self.url)
        return data

    def write(self, data):
        self._bottle.at_write(data)
        if not self.lost:
            self._bottle.hear(data)

    def wake(self):
        self._woken = True

    def set_baud(self, baud):
        self.baud = baud

    def close(self):
        pass

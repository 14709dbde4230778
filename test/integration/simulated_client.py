"""The whole client, `Robot` with its back-off, and a simulated robot, in one thread and in simulated time.

Between them is a serial line or a TCP connection that can be broken.
"""

from pioneer_control.client import robot as robot_module
from pioneer_control.client import threads
from pioneer_control.client import Robot
from pioneer_control.client.state import RobotState
from pioneer_control.client.threads import BACK_OFF
from pioneer_control.errors import LinkLostError, PortError
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.line.uart import as_heard

STEP = 0.005
LIMIT = 60.0        # simulated s that nothing takes


class Life:
    """A client and a robot, and all that happens to them.

    ``script`` is a generator function that gets this object. It begins together with the client, yields the seconds to
    wait, and acts in between. When it ends, the client is closed. ``states`` and ``events`` have all that the listeners
    were told, and ``told`` has both in order. ``plugged`` is False while the port does not exist. ``carries`` is False
    while nothing gets through the cable.
    """

    def __init__(self, monkeypatch, script, firmware=None, url="/dev/robot", on_write=lambda data: None, **settings):
        self.firmware = firmware or Firmware(find_model("p3dx-sh"), load_world("empty"), noise=0.0)
        self.now = 0.0
        self.states, self.events, self.told = [], [], []
        self.plugged = self.carries = True
        self.on_write = on_write
        self.line = None
        self._script, self._resume_at = script(self), 0.0
        for module in (robot_module, threads):
            monkeypatch.setattr(module, "monotonic", lambda: self.now)
        monkeypatch.setattr(threads, "open_transport", self._open)
        monkeypatch.setattr(threads, "BACK_OFF", 0.0)       # a wait in real time; _open() makes up for it
        self.robot = Robot(url, reconnect=True, on_state=self._tell, on_event=self._tell, **settings)
        self.robot._link.run()      # what its threads do, in this one

    def of(self, kind):
        """Return the events of a type, oldest first."""
        return [event for event in self.events if isinstance(event, kind)]

    def until(self, condition, limit=LIMIT):
        """Wait until a condition holds. For use in a script."""
        end = self.now + limit
        while not condition():
            assert self.now < end, "not within %g s: %s" % (limit, self.events[-5:])
            yield STEP

    def pass_time(self, seconds):
        """Let time pass. Returns what the robot sent."""
        self.now += seconds
        sent = self.firmware.advance(seconds)
        if self._script is not None and self.now >= self._resume_at - STEP / 2:
            wait = next(self._script, None)
            if wait is None:
                self._script = None
                self.robot.close(wait=False)
            else:
                self._resume_at = self.now + wait
        return sent

    def _open(self, url, baud, key):
        for _ in range(round(BACK_OFF / STEP)):
            self.pass_time(STEP)
        if not self.plugged:
            raise PortError("%s: no such port" % url)
        self.line = Line(self, url, None if "://" in url else baud)
        return self.line

    def _tell(self, event):
        self.told.append(event)
        (self.states if isinstance(event, RobotState) else self.events).append(event)


class Line:
    """The client's Transport to the robot. Time passes while the client waits on it."""

    def __init__(self, life, url, baud):
        self.url, self.baud = url, baud
        self._life = life
        self._woken = False
        self._broken = False

    def read(self, timeout):
        life = self._life
        until = life.now + timeout
        sent = life.pass_time(STEP)     # at least: a closing robot wakes its line at every turn
        while not sent and not self._woken and life.now < until - STEP / 2:
            sent = life.pass_time(STEP)
        self._woken = False
        self._check()
        return as_heard(sent, life.firmware.baud, self.baud or life.firmware.baud) if life.carries else b""

    def write(self, data):
        self._check()
        self._life.on_write(data)
        if self._life.carries:
            self._life.firmware.receive(as_heard(data, self.baud or self._life.firmware.baud, self._life.firmware.baud))

    def set_baud(self, baud):
        self._check()
        self.baud = baud

    def wake(self):
        self._woken = True

    def close(self):
        pass

    def _check(self):
        self._broken = self._broken or not self._life.plugged
        if self._broken:
            raise LinkLostError("%s: the cable is pulled" % self.url)

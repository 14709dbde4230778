"""A session and a simulated robot in one simulated time. There is no thread and no clock, and the line loses nothing.
"""

from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.client.state import RobotState
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world

STEP = 0.02
LIMIT = 60.0        # simulated s that nothing takes


class Rig:
    """A session that is ready, with motors on unless the test wants them off. ``firmware`` is the robot, ``session`` is
    the client.
    """

    def __init__(self, subtype="p3dx-sh", world=None, pose=None, motors=True, **settings):
        self.firmware = Firmware(find_model(subtype), world or load_world("empty"), pose)
        self.now, self.state, self.events = 0.0, None, []
        self.session = Session(subtype, (), Settings(**settings), self.now)
        self.until(lambda: self.session.connected)
        if motors:
            request = self.drive.request_motors(True, self.now, 2.0)
            self.until(lambda: request.done)
            assert request.error is None

    @property
    def drive(self):
        return self.session.connected.drive

    def step(self):
        self._act()
        sent = self.firmware.advance(STEP)
        self.now += STEP
        if sent:
            self.session.receive(sent, self.now)
        self.session.tick(self.now)
        self._act()
        for event in self.session.events():
            if isinstance(event, RobotState):
                self.state = event
            else:
                self.events.append(event)

    def run(self, seconds, command=lambda: None):
        """Let time pass, and give a command before every step."""
        end = self.now + seconds - STEP / 2
        self.until(lambda: self.now >= end, command)

    def until(self, condition, command=lambda: None):
        """Return the seconds until a condition holds. A command is given before every step."""
        start = self.now
        while not condition():
            assert self.now - start < LIMIT, "not within %g s" % LIMIT
            command()
            self.step()
        return self.now - start

    def of(self, kind):
        """Return the events of a type, oldest first."""
        return [event for event in self.events if isinstance(event, kind)]

    def velocity(self, linear, angular):
        """Return a velocity command for run() and until()."""
        return lambda: self.drive.set_velocity(linear, angular, self.now)

    def wheels(self, left, right):
        """Return a command of wheel velocities for run() and until()."""
        return lambda: self.drive.set_wheel_velocities(left, right, self.now)

    def _act(self):
        for action in self.session.data_to_send():
            self.firmware.receive(action)

"""The client's odometry is equal to the counts of the simulated robot, to the last count, with wrapping counters and
with lost packets.
"""

import math
import random

import pytest

from pioneer_control import p2os
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.client.state import RobotState
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import load_world

STEP = 0.02
WRAP = 0x8000
LOST_IN_A_ROW = 5


class Drive:
    """A session and a firmware in one simulated time. Packets get lost five in a row."""

    def __init__(self, subtype, seed):
        self.chance = random.Random(seed)
        self.firmware = Firmware(find_model(subtype), load_world("empty"), seed=seed)
        self.now = 0.0
        self.session = Session(subtype, (), Settings(), self.now)
        self.to_lose = 0
        self.lost_rows = 0
        self.compared = 0
        self.start = None
        self.wraps = {(axis, way): 0 for axis in "xy" for way in ("up", "down")}
        self.counts = self.firmware.internal_counts

    def step(self):
        for action in self.session.data_to_send():
            self.firmware.receive(action)
        sent = self.firmware.advance(STEP)
        self.now += STEP
        self._note_wraps()
        if sent and not self._loses(sent):
            self.session.receive(sent, self.now)
        self.session.tick(self.now)
        for event in self.session.events():
            if isinstance(event, RobotState):
                self._compare(event)

    def steer(self, x, y):
        """Steer one step towards a point in the robot's own frame (m)."""
        state = self.state
        towards = math.remainder(math.atan2(y - state.y, x - state.x) - state.heading, 2 * math.pi)
        self.session.connected.drive.set_velocity(
            1.5 if abs(towards) < 0.3 else 0.1, max(-1.0, min(1.0, 2 * towards)), self.now)
        self.step()
        return math.hypot(x - self.state.x, y - self.state.y)

    def _loses(self, sent):
        if not self.session.connected:
            return False
        if not self.to_lose and self.chance.random() < 0.02:
            self.to_lose, self.lost_rows = LOST_IN_A_ROW, self.lost_rows + 1
        self.to_lose -= self.to_lose > 0
        return self.to_lose > 0

    def _compare(self, state):
        internal = self.firmware.internal_counts
        self.start = self.start or internal
        assert (state.x_counts, state.y_counts) == (internal[0] - self.start[0], internal[1] - self.start[1])
        self.state = state
        self.compared += 1

    def _note_wraps(self):
        counts = self.firmware.internal_counts
        for axis, before, after in zip("xy", self.counts, counts):
            if before // WRAP != after // WRAP:
                self.wraps[axis, "up" if after > before else "down"] += 1
        self.counts = counts


@pytest.mark.parametrize("subtype", ["p3dx-sh", "p3dx", "p2at"])
def test_counts_are_exact_across_wraps_and_lost_packets(subtype):
    drive = Drive(subtype, seed=3)
    while not drive.session.connected:
        drive.step()
    request = drive.session.connected.drive.request_motors(True, drive.now, 2.0)
    while not request.done:
        drive.step()
    drive.session.connected.command(drive.now, p2os.encode_command("SETV", 1500))
    for _ in range(150):        # back and forth across zero, where the counts wrap too
        command = drive.chance.uniform(-0.75, 0.75), drive.chance.uniform(-1.5, 1.5)
        for _ in range(drive.chance.randrange(5, 100)):
            drive.session.connected.drive.set_velocity(*command, drive.now)
            drive.step()
    far = WRAP * find_model(subtype).dist_mm_per_unit / 1000 + 1.5
    for target in ((far, far), (-2.0, -2.0), (-far, 2.0), (2.0, -far), (0.0, 0.0)):
        while drive.steer(*target) > 0.5:
            assert drive.now < 2000
    assert min(drive.wraps.values()) >= 2, drive.wraps
    assert drive.lost_rows > 20 and drive.compared > 1500
    model = find_model(subtype)
    assert drive.state.x == pytest.approx(drive.state.x_counts * model.dist_mm_per_unit / 1000, abs=1e-9)
    assert drive.state.y == pytest.approx(drive.state.y_counts * model.dist_mm_per_unit / 1000, abs=1e-9)

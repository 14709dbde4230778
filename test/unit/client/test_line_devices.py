"""LineDevices: the packets and the time that devices get, and what they send."""

import math
import threading
from time import monotonic

from pioneer_control.client.events import LinkDown, PacketReceived, Ready
from pioneer_control.client.line_devices import LineDevices
from pioneer_control.errors import LinkError, RefusedError
from pioneer_control.p2os import Encoder

LIMIT = 30.0


class FakeRobot:
    """A robot that keeps what is sent to it. ``linked`` is whether it has a link."""

    def __init__(self):
        self.sent, self.linked, self.full, self.tell = [], True, False, None

    def listen(self, on_state, on_event):
        self.tell = on_event

    def send(self, *packets, stops=False):
        if not self.linked:
            raise LinkError("there is no link")
        if self.full and not stops:
            raise RefusedError("the line is too slow")
        self.sent.extend(packets)


class FakeDevice:
    """A device that answers each packet and each tick, and ends ``rests`` ticks after it is told to."""

    stops = (b"stop",)

    def __init__(self, rests=0):
        self.calls, self.due, self.ended = [], math.inf, False
        self.commands, self.ticked, self._rests = [], threading.Event(), rests

    def connected(self, identity, now):
        self.calls.append(("connected", identity))

    def disconnected(self, now):
        self.calls.append("disconnected")

    def packet(self, packet, now):
        self.calls.append(packet)
        self.commands.append(b"answer")

    def tick(self, now):
        assert now >= self.due
        self.commands.append(b"tick")
        self._rests -= 1
        self.ended = self._rests <= 0
        self.due = math.inf if self.ended else now
        self.ticked.set()

    def end(self, now):
        self.ended = self._rests <= 0
        self.due = math.inf if self.ended else now

    def take_commands(self):
        commands, self.commands = self.commands, []
        return commands


def joined(*devices):
    robot, changes = FakeRobot(), []
    return robot, LineDevices(robot, devices, lambda: changes.append(True)), changes


def test_packets_and_the_state_of_the_link_come_to_each_device_and_its_answers_go_to_the_robot():
    device, other = FakeDevice(), FakeDevice()
    robot, _, changes = joined(device, other)
    robot.tell(Ready("who"))
    robot.tell(PacketReceived(Encoder(1, 2), 0.0, 0.0))
    robot.tell(LinkDown(LinkError("gone"), 1.0))
    robot.tell("another event")
    assert device.calls == other.calls == [("connected", "who"), Encoder(1, 2), "disconnected"]
    assert robot.sent == [b"answer", b"answer"] and len(changes) == 3


def test_without_a_link_what_a_device_sends_is_lost_and_nothing_is_raised():
    device = FakeDevice()
    robot, devices, _ = joined(device)
    robot.linked = False
    robot.tell(PacketReceived(Encoder(1, 2), 0.0, 0.0))
    with devices.using():
        device.commands.append(b"one")
    robot.linked = True
    with devices.using():
        device.commands.append(b"two")
    assert robot.sent == [b"two"]


def test_on_a_line_that_is_too_slow_for_more_a_stop_is_sent_all_the_same():
    device = FakeDevice()
    robot, devices, _ = joined(device)
    robot.full = True
    with devices.using():
        device.commands += [b"go", b"stop"]
    assert robot.sent == [b"stop"]


def test_a_device_is_ticked_when_it_says_so_also_when_that_changes():
    device = FakeDevice()
    robot, devices, _ = joined(device)
    devices.start()
    with devices.using() as now:
        device.due = now
    assert device.ticked.wait(LIMIT)
    with devices.using():
        assert robot.sent == [b"tick"]
    devices.close()


def test_the_end_waits_until_every_device_rests():
    quick, slow = FakeDevice(), FakeDevice(rests=3)
    robot, devices, _ = joined(quick, slow)
    devices.start()
    assert devices.end(LIMIT)
    assert robot.sent == [b"tick"] * 3
    devices.close()


def test_a_caller_waits_for_a_device():
    device = FakeDevice()
    robot, devices, _ = joined(device)
    told = threading.Timer(0.01, lambda: robot.tell(PacketReceived(Encoder(1, 2), 0.0, 0.0)))
    told.start()
    assert devices.wait_until(lambda: bool(device.calls), LIMIT)
    told.join()
    assert not devices.wait_until(lambda: len(device.calls) > 1, 0.01)


def test_the_end_does_not_wait_for_ever():
    stubborn = FakeDevice(rests=math.inf)
    stubborn.tick = lambda now: setattr(stubborn, "due", math.inf)
    _, devices, _ = joined(stubborn)
    devices.start()
    before = monotonic()
    assert not devices.end(0.05) and monotonic() - before >= 0.05
    devices.close()


def test_without_devices_there_is_no_thread_and_no_listener():
    robot, devices, _ = joined()
    devices.start()
    assert robot.tell is None and devices.end(0.0)
    devices.close()

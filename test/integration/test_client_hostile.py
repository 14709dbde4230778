"""What befalls a client at the worst moment: each in simulated time, and at every step of what it disturbs."""

import itertools

import pytest

from pioneer_control import p2os
from pioneer_control.client.events import LineSpeed, LinkDown, Ready
from pioneer_control.simulator.firmware import Session

from simulated_client import STEP, Life

OWN, FAST = 9600, 115200
FOUND = 8.2 + 2.2       # s in which a robot at any speed is found, after a try that was on its way already (client/handshake.py)
HOSTBAUD = p2os.encode_command("HOSTBAUD", p2os.BAUD_RATES.index(FAST))


# The line breaks while its speed changes

def pull_the_port(life, seconds):
    """As a USB adapter: the computer knows at once."""
    life.plugged = False
    yield seconds
    life.plugged = True


def pull_the_plug(life, seconds):
    """At the robot's end: nothing comes any more, and nobody says why."""
    life.carries = False
    yield seconds
    life.carries = True


@pytest.mark.parametrize("pull", [pull_the_port, pull_the_plug])
@pytest.mark.parametrize("seconds", [0.05, 3.0])
@pytest.mark.parametrize("steps", range(0, 60, 4))
def test_a_line_that_breaks_while_its_speed_changes(monkeypatch, pull, seconds, steps):
    written = []

    def script(life):
        yield from life.until(lambda: HOSTBAUD in written)
        yield steps * STEP
        yield from pull(life, seconds)
        yield from life.until(lambda: life.robot.ready, FOUND)
        life.found_after = life.now
        count = len(life.states)
        yield 2.0
        assert life.robot.ready and len(life.states) >= count + 19
        assert life.firmware.baud == life.line.baud and not life.firmware.motors_enabled

    life = Life(monkeypatch, script, host_baud=FAST, on_write=written.append)
    assert life.firmware.session is Session.WAITING and life.firmware.baud == OWN
    given_up = [event for event in life.of(LinkDown) if "not tried again" in str(event.error)]
    assert [speed.baud for speed in life.of(LineSpeed)][-1:] == ([] if given_up else [FAST]), "what breaks once breaks by chance"
    assert not given_up or pull is pull_the_plug and seconds > 1


def test_a_line_that_breaks_each_time_its_speed_changes_is_left_at_its_own_and_that_is_said(monkeypatch):
    def break_it(data):
        life.plugged = data != HOSTBAUD

    def script(this):
        nonlocal life
        life = this
        while not life.robot.ready:
            yield 0.1
            life.plugged = True
        yield 1.0

    life = None
    Life(monkeypatch, script, host_baud=FAST, on_write=break_it)
    assert len(life.of(LinkDown)) >= 2 and life.line.baud == OWN
    assert life.of(LineSpeed) == [LineSpeed(OWN, "the link broke 2 times when its line was to change to 115200 baud; not tried again")]
    assert [type(event) for event in life.events].index(Ready) > 0


def test_breaks_long_apart_are_chance(monkeypatch):
    """Each time the line had worked at the new speed in between."""
    def break_it(data):
        if data == HOSTBAUD and next(breaks):
            life.plugged = False

    def script(this):
        nonlocal life
        life = this
        for _ in range(3):
            while not life.robot.ready:
                yield 0.1
                life.plugged = True
            yield 1.0
            life.plugged = False
            yield 0.5
            life.plugged = True

    life, breaks = None, itertools.cycle((True, False))
    Life(monkeypatch, script, host_baud=FAST, on_write=break_it)
    assert life.of(LineSpeed) == [LineSpeed(FAST, "")] * 3

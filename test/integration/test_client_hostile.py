"""Bad things happen to a client at the worst moment. All tests run in simulated time. Several tests try many moments of
the procedure that they disturb.
"""

import itertools

import pytest

from pioneer_control import p2os
from pioneer_control.client import Tuning
from pioneer_control.client.events import LineSpeed, LinkDown, MotionCleared, Ready, Tuned
from pioneer_control.errors import PioneerError, RefusedError
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import load_world

from simulated_client import STEP, Life

OWN, FAST = 9600, 115200
# s in which a robot at any speed is found, after a try that was on its way already (client/handshake.py)
FOUND = 7.0 + 2.0
HOSTBAUD = p2os.encode_command("HOSTBAUD", p2os.BAUD_RATES.index(FAST))


def robot(subtype):
    return Firmware(find_model(subtype), load_world("empty"), gripper=False)


# The line breaks while its speed changes

def pull_the_port(life, seconds):
    """Pull a USB adapter: the computer notices at once."""
    life.plugged = False
    yield seconds
    life.plugged = True


def pull_the_plug(life, seconds):
    """Pull the cable at the robot: no packets come any more, and the computer gets no error."""
    life.carries = False
    yield seconds
    life.carries = True


@pytest.mark.parametrize("pull", [pull_the_port, pull_the_plug])
@pytest.mark.parametrize("seconds", [0.05, 3.0])
@pytest.mark.parametrize("steps", range(0, 60, 5))
def test_a_line_that_breaks_while_its_speed_changes(monkeypatch, pull, seconds, steps):
    written = []

    def script(life):
        yield from life.until(lambda: HOSTBAUD in written)
        yield steps * STEP
        yield from pull(life, seconds)
        yield from life.until(lambda: life.robot.ready, FOUND)
        count = len(life.states)
        yield 2.0
        assert life.robot.ready and len(life.states) >= count + 19
        assert life.firmware.baud == life.line.baud and not life.firmware.motors_enabled

    life = Life(monkeypatch, script, host_baud=FAST, on_write=written.append)
    assert life.firmware.session is FirmwareState.WAITING and life.firmware.baud == OWN
    given_up = [event for event in life.of(LinkDown) if "not tried again" in str(event.error)]
    last_speed = [speed.baud for speed in life.of(LineSpeed)][-1:]
    assert last_speed == ([] if given_up else [FAST]), "what breaks once breaks by chance"
    assert not given_up or pull is pull_the_plug and seconds > 1


def test_a_line_that_breaks_each_time_its_speed_changes_is_left_at_its_own_and_that_is_said(monkeypatch):
    def break_it(data):
        life.plugged = data != HOSTBAUD

    def script(this):
        nonlocal life
        life = this
        noticed = 0
        while not life.robot.ready:
            yield 0.1
            if len(life.of(LinkDown)) > noticed:
                noticed, life.plugged = len(life.of(LinkDown)), True
        yield 1.0

    life = None
    Life(monkeypatch, script, host_baud=FAST, on_write=break_it)
    assert len(life.of(LinkDown)) >= 2 and life.line.baud == OWN
    assert life.of(LineSpeed) == [
        LineSpeed(OWN, "the link broke 2 times when its line was to change to 115200 baud; not tried again")]
    assert [type(event) for event in life.events].index(Ready) > 0


def test_breaks_long_apart_are_chance(monkeypatch):
    """Between two breaks the line works at the new speed."""
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


# The controller restarts while settings are sent

TUNING = Tuning(max_linear_acceleration=0.4, max_linear_deceleration=0.35, rotation_kp=55, translation_ki=3)


@pytest.mark.parametrize("restart", ["restart", "close_session"], ids=["and says so", "without a word"])
@pytest.mark.parametrize("steps", range(0, 100, 9))
def test_a_controller_that_restarts_while_it_is_told_its_settings(monkeypatch, restart, steps):
    def script(life):
        yield from life.until(lambda: life.robot.ready)
        yield steps * STEP
        getattr(life.firmware, restart)()
        yield from life.until(lambda: life.of(LinkDown) and life.robot.ready)
        seen = len(life.of(Tuned))
        yield from life.until(lambda: len(life.of(Tuned)) > seen)
        config = life.robot.identity.config
        life.has = (config.translation_acceleration_mm_s2, config.translation_deceleration_mm_s2, config.rotation_kp,
                    config.translation_ki)

    life = Life(monkeypatch, script, tuning=TUNING)
    assert life.has == (400, 350, 55, 3)
    changes = {change.name: change for change in life.of(Tuned)[-1].changes}
    assert set(changes) == set(TUNING.values) and not any(change.problem for change in changes.values())
    assert changes["rotation_kp"].old == 40, "what it had itself, not what it was told before it restarted"


# Another robot at the same cable

@pytest.mark.parametrize("first, second", [
    ("p3dx-sh", "amigo-sh"),
    ("amigo-sh", "p3dx-sh"),
    ("p3at-sh", "pion1m"),
    ("pion1m", "peoplebot-sh"),
])
def test_another_model_after_a_reconnect_is_all_of_it_another(monkeypatch, first, second):
    def script(life):
        yield from life.until(lambda: life.robot.ready)
        wait = life.robot.request_motors(True)
        yield 0.5
        wait()
        for _ in range(20):
            life.robot.set_velocity(0.2, 0.3)
            yield 0.1
        life.far = life.states[-1]
        life.plugged = False
        yield 0.5
        life.firmware = robot(second)
        life.plugged = True
        yield from life.until(lambda: life.robot.ready)
        yield 1.0
        life.identity, life.last = life.robot.identity, life.states[-1]
        with pytest.raises(RefusedError):
            life.robot.gripper(p2os.GripperCommand.CLOSE)
        wait = life.robot.request_motors(True)
        yield 0.5
        wait()
        for _ in range(20):
            life.robot.set_velocity(9.0, 0.0)
            yield 0.1
        life.fastest = life.firmware.velocity[0]

    life = Life(monkeypatch, script, robot(first))
    assert life.far.x > 0.1 and life.identity.model.subtype == second
    assert len(life.last.sonar) == life.firmware.model.sonar_count
    assert (life.last.x == pytest.approx(0.0, abs=1e-9) or
            find_model(first).dist_mm_per_unit == find_model(second).dist_mm_per_unit)
    assert not life.last.motors_enabled and not life.last.moving
    assert 0.1 < life.fastest <= life.identity.max_linear + 1e-6


# Flags that flicker

def flicker(life, befall, seconds):
    """Change a flag of the robot with every SIP, while a user commands velocities and asks for the motors again and
    again. Returns the errors of the refused requests.
    """
    waits, refused = [], []
    for tenths in range(round(seconds * 10)):
        befall(life.firmware, bool(tenths % 2))
        life.robot.set_velocity(0.3, 0.0)
        if tenths % 10 == 5:
            waits.append(life.robot.request_motors(True))
        yield 0.1
    yield 3.0
    for wait in waits:
        try:
            wait()
        except PioneerError as error:
            refused.append(str(error))
    return refused


def motors_bit(firmware, on):
    firmware.hardware.motors.enabled = on


def stop_bit(firmware, on):
    firmware.press_stop_button(on)


@pytest.mark.parametrize("befall", [motors_bit, stop_bit])
def test_flags_that_flicker(monkeypatch, befall):
    written = []

    def script(life):
        yield from life.until(lambda: life.robot.ready)
        wait = life.robot.request_motors(True)
        yield 0.5
        wait()
        written.clear()
        life.refused = yield from flicker(life, befall, 10.0)
        life.commands = len(written)
        befall(life.firmware, False)
        life.firmware.press_stop_button(False)
        yield 1.0
        pose = life.firmware.true_pose
        assert not life.firmware.motors_enabled and not life.states[-1].motors_enabled
        yield 2.0
        assert life.firmware.true_pose == pose
        wait = life.robot.request_motors(True)
        yield 0.5
        wait()
        life.robot.set_velocity(0.3, 0.0)
        yield 0.5
        assert life.firmware.velocity[0] > 0.0

    life = Life(monkeypatch, script, on_write=written.append)
    assert life.commands < 13 * 40, "writes, in 13 s"
    assert len(life.of(MotionCleared)) <= 51

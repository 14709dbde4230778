"""Every setting of the robot has an effect on the simulated robot. test_a_setting_has_its_effect() compares a robot
with default settings and a robot with one changed setting.
"""

import math
import queue
from dataclasses import fields, replace

import pytest

from pioneer_control.client import Robot, Tuned, Tuning
from pioneer_control.client.tuning import ROWS
from pioneer_control.robots import find_model, load_table
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import World, load_world
from pioneer_control.simulator.line import Server

from client_lines import SpoiltLine
from real_time import LIMIT, keep_commanding
from simulated_time import Rig

WALL = (1.0, -2.0, 1.0, 2.0)


def speed(rig):
    return rig.firmware.velocity[0]


def turning(rig):
    return rig.firmware.velocity[1]


def seconds_to_go(rig):
    """Return the time (s) from rest to 0.3 m/s."""
    return rig.until(lambda: speed(rig) >= 0.3 - 1e-9, rig.velocity(0.3, 0.0))


def seconds_to_stop(rig):
    seconds_to_go(rig)
    rig.drive.stop(rig.now)
    return rig.until(lambda: speed(rig) == 0.0)


def seconds_to_turn(rig):
    """Return the time (s) from rest to 1 rad/s (57 deg/s on the wire)."""
    return rig.until(lambda: turning(rig) >= math.radians(57) - 1e-9, rig.velocity(0.0, 1.0))


def seconds_to_stop_turning(rig):
    seconds_to_turn(rig)
    rig.drive.stop(rig.now)
    return rig.until(lambda: turning(rig) == 0.0)


def gives_up_at_a_touch(rig):
    """Return whether the robot stalls as soon as it touches a wall, and not only after it has pressed for half a
    second.
    """
    rig.until(lambda: rig.firmware.hardware.body.blocked, rig.velocity(0.3, 0.0))
    return rig.until(lambda: rig.state.left_stall, rig.velocity(0.3, 0.0)) < 0.3


def metres_in_a_metre(rig):
    """Return how far (m) the robot really drives while it counts one metre."""
    start = rig.firmware.true_pose[0]
    rig.until(lambda: rig.state.x >= 1.0, rig.velocity(0.3, 0.0))
    return (rig.firmware.true_pose[0] - start) / rig.state.x


def turns_in_a_turn(rig):
    rig.until(lambda: rig.state.heading >= 1.5, rig.velocity(0.0, 0.5))
    rig.drive.stop(rig.now)
    rig.until(lambda: turning(rig) == 0.0)
    rig.run(0.3)
    return rig.firmware.true_pose[2] / rig.state.heading


def firings(rig):
    """Return the numbers of the sonars that report in half a second, in order, and drop what was before."""
    rig.firmware.hardware.sonar.take_readings(1)
    heard, end = [], rig.now + 0.5
    while rig.now < end:
        rig.run(0.1)
        heard += [number for number, reading in enumerate(rig.state.sonar)
                  if reading is not None and reading.time == rig.state.time]
    return heard


def tens_of_firings_in_half_a_second(rig):
    return round(len(firings(rig)) / 10)


def sonars_that_fire(rig):
    return len(set(firings(rig)))


def reported(field):
    """Return a function that gives one field of the CONFIGpac which the client has read from the robot."""
    return lambda rig: getattr(rig.session.connected.identity.config, field)


# A setting, what shows it, and what that is on a robot as it comes and on one that was told.
EFFECTS = {
    "max_linear_acceleration": (0.1, seconds_to_go, 1.0, 3.0),
    "max_linear_deceleration": (0.6, seconds_to_stop, 1.0, 0.5),
    "max_angular_acceleration": (math.radians(25), seconds_to_turn, 0.57, 2.28),
    "max_angular_deceleration": (math.radians(25), seconds_to_stop_turning, 0.57, 2.28),
    "rotation_kp": (41, reported("rotation_kp"), 40, 41),
    "rotation_kv": (21, reported("rotation_kv"), 20, 21),
    "rotation_ki": (1, reported("rotation_ki"), 0, 1),
    "translation_kp": (42, reported("translation_kp"), 40, 42),
    "translation_kv": (31, reported("translation_kv"), 30, 31),
    "translation_ki": (2, reported("translation_ki"), 0, 2),
    "bump_stall": (0, gives_up_at_a_touch, True, False),
    "ticks_mm": (64, metres_in_a_metre, 1.0, 0.5),
    "drift_factor": (-7, reported("drift_factor"), 0, -7),
    "rev_count": (33140, turns_in_a_turn, 1.0, 2.0),
    "sonar_cycle": (0.1, tens_of_firings_in_half_a_second, 5, 2),
    "sonar_polling": ((0, 8, 16, 24), sonars_that_fire, 32, 4),
}


def rig(**settings):
    """Return a robot with bumpers. It faces a wall 1 m ahead only if the test wants it to hit the wall."""
    world = World("wall", walls=[WALL]) if settings.pop("wall") else World("bare")
    return Rig("peoplebot-sh", world, (0.0, 0.0, 0.0), **settings)


def test_every_setting_has_an_effect_that_is_tested():
    assert set(EFFECTS) == {field.name for field in fields(Tuning)}


@pytest.mark.parametrize("name", EFFECTS)
def test_a_setting_has_its_effect(name):
    value, observed, as_it_comes, told = EFFECTS[name]
    wall = observed is gives_up_at_a_touch
    plain, tuned = rig(wall=wall), rig(wall=wall, tuning=Tuning(**{name: value}))
    tuned.until(lambda: tuned.of(Tuned))
    assert [change.problem for change in tuned.of(Tuned)[0].changes] == [""]
    assert observed(plain) == pytest.approx(as_it_comes, abs=0.05)
    assert observed(tuned) == pytest.approx(told, abs=0.05)
    assert plain.of(Tuned) == []


def test_what_is_set_at_run_time_has_its_effect_at_once_and_is_gone_after_close():
    run = rig(wall=False)
    tuning = Tuning(ticks_mm=64, max_linear_acceleration=0.1)
    run.session.use(replace(run.session._link.settings, tuning=tuning), run.now)
    run.until(lambda: run.of(Tuned))
    assert [(change.name, change.old, change.new) for change in run.of(Tuned)[0].changes] == [
        ("max_linear_acceleration", pytest.approx(0.3), pytest.approx(0.1)), ("ticks_mm", 128, 64)]
    assert seconds_to_go(run) == pytest.approx(3.0, abs=0.05)
    run.session.close(run.now)
    run.until(lambda: run.session.finished)
    hardware = run.firmware.hardware
    assert (hardware.wheels.ticks_per_mm, hardware.drives.linear.limits.rise) == (128, pytest.approx(0.3))


def test_what_is_beyond_the_robots_top_is_reported_as_not_taken():
    run = Rig(tuning=Tuning(max_linear_acceleration=5.0))
    run.until(lambda: run.of(Tuned))
    change, = run.of(Tuned)[0].changes
    assert change.new == pytest.approx(2.0) and "did not take it" in change.problem
    assert run.session.connected.identity.config.translation_acceleration_mm_s2 == 2000


@pytest.mark.parametrize(
    "subtype", sorted({model.firmware_family: name for name, model in sorted(load_table().models.items())}.values()))
def test_each_family_of_firmware_takes_what_it_knows_and_no_other_hears_of_it(subtype):
    sonar = [transducer.number for transducer in load_table().models[subtype].sonar]
    told = {name: value for name, (value, *_) in EFFECTS.items()}
    told["sonar_polling"] = tuple(sonar[:1]) or None
    run = Rig(subtype, tuning=Tuning(**told))
    run.until(lambda: run.of(Tuned))
    for change in run.of(Tuned)[0].changes:
        assert (change.new == pytest.approx(change.wanted) or change.name == "bump_stall" or
                change.name == "sonar_polling" and not change.problem or
                "firmware does not know" in change.problem), str(change)
    assert not run.firmware.unknown_commands & {row.command for row in ROWS.values()}


def test_a_robot_in_real_time_is_tuned_on_every_connect():
    heard = queue.Queue()

    def listener(event):
        if isinstance(event, Tuned):
            heard.put({change.name: (change.old, change.new, change.problem) for change in event.changes})

    firmware = Firmware(find_model("p3dx-sh"), load_world("empty"))
    with Server(firmware, tcp=0) as server, SpoiltLine(int(server.url.rsplit(":", 1)[1])) as line:
        with Robot(line.url, tuning=Tuning(ticks_mm=132), reconnect=True, on_event=listener) as robot:
            assert heard.get(timeout=LIMIT) == {"ticks_mm": (128, 132, "")}
            assert robot.identity.config.ticks_per_mm == 132 and robot.link.reconnects == 0
            robot.tune(replace(robot.tuning, rev_count=16600))
            assert heard.get(timeout=LIMIT) == {"rev_count": (16570, 16600, "")}
            assert robot.identity.config.rev_count == 16600 and robot.link.reconnects == 0
            line.cut()
            assert heard.get(timeout=LIMIT) == {"ticks_mm": (128, 132, ""), "rev_count": (16570, 16600, "")}
            assert robot.link.reconnects == 1
            robot.enable_motors()
            keep_commanding(robot, lambda: robot.set_wheel_velocities(0.1, 0.2),
                            lambda state: state.linear >= 0.1 and state.angular >= 0.2)

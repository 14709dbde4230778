"""Sounds: legal notes and their bytes. The joystick at the robot's own port: what ends it, and that nothing fights it.

What waits for the robot is tested with the driver: test/messages/driver/test_driver_accessories.py.
"""

import math

import pytest

from pioneer_control.client.accessories import say_packet
from pioneer_control.client.drive import REFRESH
from pioneer_control.client.line import LONGEST_QUEUE
from pioneer_control.client.phases import STAND_TIMEOUT
from pioneer_control.errors import RefusedError, UsageError
from pioneer_control.p2os import encode_command

from fake_robot import Bench


# Sounds: the bytes of the protocol's examples

@pytest.mark.parametrize("notes, golden", [
    ([(0.5, 69)], "FA FB 07 0F 2B 02 19 45 11 01"),
    ([(0.5, 69), (0.2, 0)], "FA FB 09 0F 2B 04 19 45 0A 00 58 4E"),
])
def test_notes_are_their_golden_bytes(notes, golden):
    assert say_packet(notes) == bytes.fromhex(golden)


@pytest.mark.parametrize("notes, says", [
    ([], "there are 0 notes (legal: 1 to 20)"), ([(0.1, 60)] * 21, "there are 21 notes"),
    ([(0.1, 60), (0.0, 60)], "note 1 lasts 0.0 s (legal: 0.02 to 5.1)"), ([(5.2, 60)], "note 0 lasts 5.2 s"),
    ([(-0.1, 60)], "lasts -0.1 s"), ([(math.nan, 60)], "lasts nan s"), ([(math.inf, 60)], "lasts inf s"),
    ([(0.1, 256)], "note 0 has tone 256 (legal: 0 to 255)"), ([(0.1, -1)], "tone -1"), ([(0.1, 60.5)], "tone 60.5"),
])
def test_notes_that_are_not_legal_are_named(notes, says):
    with pytest.raises(UsageError) as caught:
        say_packet(notes)
    assert says in str(caught.value)


def test_the_ends_of_the_range_are_legal():
    assert say_packet([(0.02, 0), (5.1, 255)])[6:10] == bytes([1, 0, 255, 255])
    assert len(say_packet([(0.1, 60)] * 20)) == 48


# The joystick

def allowed() -> Bench:
    """Return a robot with motors on, which a joystick may drive."""
    bench = Bench().until_ready()
    request = bench.session.connected.drive.request_motors(True, bench.now, 2.0)
    bench.run_until(lambda: request.done)
    bench.run(0.5)
    bench.robot.heard.clear()
    bench.session.connected.drive.allow_joystick(True, bench.now)
    bench.run(0.1)
    return bench


def told(bench):
    """Return what the robot was told of its joystick."""
    return [heard.value for heard in bench.robot.heard if heard.name == "JOYDRIVE"]


def moves_by_joystick(bench):
    bench.robot.set_point["VEL"] = 100
    bench.robot.heard.clear()
    bench.run(3.0)
    return bench.robot.moving


def test_a_robot_that_a_joystick_drives_is_kept_alive_and_not_stopped():
    bench = allowed()
    assert told(bench) == [1]
    assert moves_by_joystick(bench)
    assert set(bench.robot.names()) == {"PULSE"}


def test_without_it_a_robot_that_moves_by_itself_is_stopped():
    bench = allowed()
    bench.session.connected.drive.allow_joystick(False, bench.now)
    bench.run(0.2)
    assert told(bench) == [1, 0, 0, 0]
    assert not moves_by_joystick(bench) and "STOP" in bench.robot.names() and "PULSE" not in bench.robot.names()


@pytest.mark.parametrize("end", [
    lambda bench: bench.session.connected.drive.stop(bench.now),
    lambda bench: bench.drive(0.2, 0.0),
    lambda bench: bench.drive(0.0, 0.0),
    lambda bench: bench.session.connected.drive.set_wheel_velocities(0.1, 0.1, bench.now),
    lambda bench: bench.session.connected.drive.request_motors(False, bench.now, 2.0),
    lambda bench: bench.robot.press_stop_button(True),
], ids=["stop", "velocity", "zero", "wheels", "motors off", "STOP button"])
def test_every_command_to_move_or_stop_ends_it(end):
    bench = allowed()
    end(bench)
    bench.run(3 * REFRESH)
    assert told(bench) == [1, 0, 0, 0] and not bench.session.connected.drive.joystick


def test_at_the_end_it_is_forbidden_and_the_robot_stands_before_its_motors_go_off():
    bench = allowed()
    assert moves_by_joystick(bench)
    bench.robot.coasts = True       # it takes its time to stand
    bench.robot.heard.clear()
    bench.close()
    bench.run_until(lambda: bench.finished)
    names = bench.robot.names()
    assert names[0] == "STOP" and told(bench) == [0, 0, 0] and names.index("JOYDRIVE") < names.index("ENABLE")
    stopped, switched = (next(heard.time for heard in bench.robot.heard if heard.name == name)
                         for name in ("STOP", "ENABLE"))
    assert switched - stopped > 0.9 * STAND_TIMEOUT


def test_a_new_connection_begins_without_it():
    bench = allowed()
    assert bench.session.connected.drive.joystick
    assert not Bench().until_ready().session.connected.drive.joystick


def test_a_velocity_while_none_is_allowed_says_nothing_of_it():
    bench = Bench().until_driving()
    assert told(bench) == []


# A slow line

def test_what_stops_something_is_sent_though_very_many_commands_wait_and_waits_once():
    bench = Bench(rates=(9600,)).until_ready()
    connected = bench.session.connected
    halt = encode_command("GRIPPER", 15)
    with pytest.raises(RefusedError, match="the line is too slow for so many commands"):
        for _ in range(2 * LONGEST_QUEUE):
            connected.command(bench.now, say_packet([(0.1, 60)] * 20))
    waiting = connected.waiting
    for _ in range(10):
        connected.command(bench.now, halt, stops=True)
    assert connected.waiting == waiting + 1
    bench.run(3.0)
    assert bench.robot.names().count("GRIPPER") == 1

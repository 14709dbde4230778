"""Sounds, outputs, the joystick at the robot's own port, and docks, by topics and services of the driver: on the
simulated robot, in the answer, in the log.
"""

import math
import threading

import pytest
from bottle import Bottle
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool
from test_driver_requests import ask

from pioneer_control.client.accessories import has_power
from pioneer_control.driver import conversions
from pioneer_control.errors import LinkLostError
from pioneer_control.msg import MotorState, Sounds
from pioneer_control.p2os import Joystick
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware.accessories import JoystickState
from pioneer_control.simulator.world import World, load_world


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: Bottle(monkeypatch, script, **options)


def robot(subtype="p3dx-sh", world=None, pose=None, **more):
    return Firmware(find_model(subtype), world or load_world("empty"), pose, noise=0.0, **more)


# Sounds

def test_what_it_is_to_say_is_played(run):
    def script(bottle):
        bottle.send("say", Sounds([0.5, 0.02, 5.1], [69, 0, 255]))
        yield 0.3
        bottle.played = list(bottle.firmware.hardware.ports.speaker.played)

    assert run(script).played == [(pytest.approx(0.5), 69), (pytest.approx(0.02), 0), (pytest.approx(5.1), 255)]


@pytest.mark.parametrize("durations, tones, says", [
    ([0.5], [], "say refused: there are 1 durations and 0 tones"), ([], [], "say refused: there are 0 notes"),
    ([math.nan], [60], "say refused: note 0 lasts nan s"), ([0.001], [60], "legal: 0.02 to 5.1"),
    ([0.1] * 21, [60] * 21, "there are 21 notes (legal: 1 to 20)"),
])
def test_what_cannot_be_said_is_refused(run, durations, tones, says):
    def script(bottle):
        bottle.send("say", Sounds(durations, tones))
        yield 0.3

    bottle = run(script)
    assert says in bottle.warned and bottle.commands("SAY") == []


def test_a_bag_player_says_nothing(run):
    def script(bottle):
        bottle.send("say", Sounds([0.5], [69]))
        yield 0.3

    assert run(script, caller="/play_1795").commands("SAY") == []


def test_firmware_without_a_loudspeaker_is_named(run):
    def script(bottle):
        bottle.send("say", Sounds([0.5], [69]))
        yield 0.3

    bottle = run(script, firmware=robot("amigo"))
    assert "AmigOS firmware does not know SAY" in bottle.warned and bottle.commands("SAY") == []


# Outputs

def test_outputs_are_set_and_shown_and_others_stay(run):
    def script(bottle):
        bottle.first = yield from ask(bottle, "dio_out", 0x81, 0x81)
        bottle.second = yield from ask(bottle, "dio_out", 0x13, 0x12)
        bottle.outputs = bottle.firmware.hardware.ports.digital_out

    bottle = run(script, firmware=robot(gripper=False))
    assert bottle.first == (True, "the outputs 0x81 are 0x81") and bottle.second[0]
    assert bottle.outputs == 0x92


@pytest.mark.parametrize("gripper, mask, states, says", [
    (True, 0x12, 0x10, "the outputs 0x02 drive the gripper: use gripper_control"),
    (True, 0x08, 0x00, "drive the gripper"),
    (False, 0x01, 0x03, "states 0x03 has bits that mask 0x01 has not"),
])
def test_outputs_that_are_not_to_be_set_are_refused(run, gripper, mask, states, says):
    def script(bottle):
        bottle.answer = yield from ask(bottle, "dio_out", mask, states)

    bottle = run(script, firmware=robot(gripper=gripper))
    assert not bottle.answer[0] and says in bottle.answer[1] and bottle.commands("DIGOUT") == []


def test_outputs_beside_the_gripper_are_free(run):
    def script(bottle):
        bottle.answer = yield from ask(bottle, "dio_out", 0xF0, 0xA0)
        bottle.outputs = bottle.firmware.hardware.ports.digital_out

    bottle = run(script)
    assert bottle.answer[0] and bottle.outputs == 0xA0


def test_outputs_that_the_robot_does_not_show_are_an_error(run):
    def script(bottle):
        bottle.deaf_to.add("DIGOUT")
        bottle.answer = yield from ask(bottle, "dio_out", 0x80, 0x80)

    bottle = run(script)
    assert bottle.answer == (False, "told to set outputs 0x80 to 0x80, the robot did not show it within 2 s")


def test_a_command_that_was_lost_is_sent_again(run):
    def script(bottle):
        bottle.deaf_to.add("DIGOUT")

        def hear_again(name):
            if bottle.now > bottle.begun + 0.5:
                bottle.deaf_to.clear()

        bottle.begun, bottle.at_publish = bottle.now, hear_again
        bottle.answer = yield from ask(bottle, "dio_out", 0x80, 0x80)

    assert run(script).answer[0]


# Encoders and joystick as topics

def test_encoders_are_published_as_they_count(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(10):
            bottle.send("cmd_vel", Twist(Vector3(0.2, 0, 0), Vector3(0, 0, 0.5)))
            yield 0.1
        bottle.ticks = bottle.firmware.hardware.wheels.ticks
        yield 0.3

    bottle = run(script)
    first, last = bottle.messages("encoders")[0], bottle.messages("encoders")[-1]
    assert (first.left, first.right) == (0, 0) and first.header.frame_id == "base_link"
    assert last.right > last.left > 1000
    assert (last.left, last.right) >= tuple(bottle.ticks)


def test_nobody_asks_for_encoders_that_nobody_hears(run):
    def script(bottle):
        yield 1.0

    bottle = run(script, link_check=False, before=lambda bottle: setattr(bottle, "listened", {"pose"}))
    assert bottle.commands("ENCODER") == [] and bottle.commands("JOYREQUEST") == []


@pytest.mark.parametrize("packet, axes, buttons", [
    (Joystick(1, 0, 512, 700, 1023), (0.0, 188 / 512, 1023 / 1024), (1, 0)),       # sheet 5.9's example
    (Joystick(0, 1, 0, 1023, 0), (1.0, 511 / 512, 0.0), (0, 1)),
    (Joystick(0, 0, 65535, 0, 65535), (-1.0, -1.0, 1.0), (0, 0)),
])
def test_a_joystick_is_to_the_left_and_forward(packet, axes, buttons):
    message = conversions.joystick(packet, None)
    assert tuple(message.axes) == pytest.approx(axes) and tuple(message.buttons) == buttons


def test_the_joystick_of_the_robots_own_port_is_a_topic(run):
    def script(bottle):
        bottle.firmware.hardware.joystick = JoystickState(button_1=True, x=256, y=768)
        yield 0.5

    message = run(script).messages("joystick")[-1]
    assert isinstance(message, Joy) and list(message.axes)[:2] == [0.5, 0.5] and list(message.buttons) == [1, 0]


# Who drives by joystick

def push(bottle):
    """Plug in a joystick and push it forward, with its button pressed."""
    bottle.firmware.hardware.joystick = JoystickState(button_1=True, y=1023)


def moves(bottle, seconds=1.5):
    yield seconds
    return bottle.firmware.velocity[0] > 0.1


def test_a_joystick_drives_only_when_it_is_allowed_and_programs_wait(run):
    def script(bottle):
        push(bottle)
        bottle.send("cmd_motor_state", MotorState(1))
        bottle.before = yield from moves(bottle)
        bottle.answer = yield from ask(bottle, "set_joystick_drive", True)
        bottle.while_allowed = yield from moves(bottle)
        bottle.send("cmd_vel", Twist(Vector3(0.0, 0, 0), Vector3(0, 0, 0.5)))
        bottle.still = yield from moves(bottle)
        bottle.end = yield from ask(bottle, "set_joystick_drive", False)
        bottle.after = yield from moves(bottle, 4.0)    # it slows down from 0.75 m/s

    bottle = run(script)
    assert (bottle.before, bottle.while_allowed, bottle.still, bottle.after) == (False, True, True, False)
    assert bottle.answer[0] and bottle.end[0] and "a person has the helm" in bottle.warned


@pytest.mark.parametrize("end", [
    lambda bottle: bottle.send("stop_all", Bool(True)), lambda bottle: bottle.call("teleop/release"),
    lambda bottle: bottle.send("teleop/cmd_vel", Twist()), lambda bottle: bottle.send("cmd_motor_state", MotorState(0)),
    lambda bottle: bottle.unplug(for_a_moment=True),
], ids=["stop_all", "release", "a person", "motors", "a new connection"])
def test_what_ends_it(run, end):
    def script(bottle):
        push(bottle)
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        yield from ask(bottle, "set_joystick_drive", True)
        bottle.first = yield from moves(bottle)
        end(bottle)
        bottle.then = yield from moves(bottle, 4.0)
        bottle.send("stop_all", Bool(False))
        bottle.send("cmd_motor_state", MotorState(1))
        bottle.later = yield from moves(bottle)

    bottle = run(script)
    assert (bottle.first, bottle.then, bottle.later) == (True, False, False)


def test_a_joystick_does_not_take_over_a_robot_that_moves(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(10):
            bottle.send("cmd_vel", Twist(Vector3(0.3, 0, 0), Vector3()))
            yield 0.1
        bottle.answer = bottle.call("set_joystick_drive", True)
        yield 3.0
        bottle.again = yield from ask(bottle, "set_joystick_drive", True)

    bottle = run(script)
    assert not bottle.answer.success and bottle.answer.message == "the robot moves: ask again when it stands"
    assert bottle.again[0], "it was stopped meanwhile"


@pytest.mark.parametrize("befall, says", [
    (lambda bottle: bottle.send("stop_all", Bool(True)), "stop_all is set"),
    (lambda bottle: None, "the motors are off: switch them on first"),
    (lambda bottle: bottle.unplug(), "cable"),
])
def test_a_joystick_that_may_not_drive_has_a_reason_and_programs_keep_the_helm(run, befall, says):
    def script(bottle):
        befall(bottle)
        yield 0.3
        bottle.answer = yield from ask(bottle, "set_joystick_drive", True)
        bottle.holder = bottle.node._steered.state().holder

    bottle = run(script)
    assert not bottle.answer[0] and says in bottle.answer[1] and bottle.holder == ""
    assert bottle.commands("JOYDRIVE") == [] or all(value == 0 for _, value in bottle.commands("JOYDRIVE"))


def test_a_lock_that_is_set_while_a_joystick_gets_the_helm_ends_it(run):
    def script(bottle):
        push(bottle)
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        accessories = bottle.node._requests.accessories._accessories
        lock = threading.Thread(target=lambda: bottle.send("stop_all", Bool(True)))
        allow = accessories.allow_joystick

        def while_somebody_locks(on):
            lock.start()
            lock.join(0.2)      # it has to wait; else it is set, the robot stands, and the joystick drives nevertheless
            for _ in range(3):
                bottle.robot.wait_for_state()
            allow(on)

        accessories.allow_joystick = while_somebody_locks
        yield from ask(bottle, "set_joystick_drive", True)
        lock.join()
        bottle.drives = yield from moves(bottle)
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script)
    assert bottle.locks == ("stop_all",) and not bottle.drives


# Docks

DOCKED, BESIDE = (1.0, 1.0, 0.0), (1.5, 1.0, 0.0)


def in_world_with_dock(subtype="patrolbot-sh", pose=DOCKED):
    world = World("dock", walls=[(-5, -5, 5, -5)], docks=[DOCKED])
    return robot(subtype, world, pose)


@pytest.mark.parametrize("subtype", ["patrolbot-sh", "powerbot-sh", "powerbot"])
def test_a_robot_in_its_dock_takes_power_and_stands_until_it_lets_go(run, subtype):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        bottle.answer = yield from ask(bottle, "dock")
        bottle.charging = bottle.firmware.hardware.battery.charging
        bottle.send("cmd_vel", Twist(Vector3(0.2, 0, 0), Vector3()))
        yield 0.5
        bottle.stood = bottle.firmware.velocity[0]
        bottle.end = yield from ask(bottle, "undock")
        bottle.charging_then = bottle.firmware.hardware.battery.charging
        for _ in range(10):
            bottle.send("cmd_vel", Twist(Vector3(0.2, 0, 0), Vector3()))
            yield 0.1
        bottle.drove = bottle.firmware.velocity[0]

    bottle = run(script, firmware=in_world_with_dock(subtype))
    assert bottle.answer == (True, "the robot takes power, and stands until undock") and bottle.charging
    assert bottle.stood == 0.0 and "the robot takes power in a dock; to let go and drive: rosservice call /undock" in (
        bottle.warned)
    assert bottle.end[0] and not bottle.charging_then and bottle.drove > 0.1


def test_beside_the_dock_it_lets_go_again_and_may_drive(run):
    def script(bottle):
        bottle.answer = yield from ask(bottle, "dock")
        yield 0.3
        bottle.asks = bottle.firmware.hardware.charger.asks_dock
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script, firmware=in_world_with_dock(pose=BESIDE))
    assert not bottle.answer[0] and "it lets go again; does it stand in the dock?" in bottle.answer[1]
    assert not bottle.asks and bottle.locks == ()


def test_a_robot_that_still_shows_power_stays_locked(run):
    def script(bottle):
        yield from ask(bottle, "dock")
        bottle.firmware.hardware.charger.plug(True)
        bottle.answer = yield from ask(bottle, "undock")
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script, firmware=in_world_with_dock())
    assert bottle.answer == (False, "told to let go of the dock, the robot did not show it within 5 s")
    assert bottle.locks == ("dock",)


@pytest.mark.parametrize("asks, pose, warns", [(True, DOCKED, True), (False, DOCKED, False), (True, BESIDE, False)])
def test_a_driver_that_finds_its_robot_with_power_of_a_dock_says_what_to_do(run, asks, pose, warns):
    firmware = in_world_with_dock(pose=pose)
    firmware.hardware.charger.asks_dock = asks      # an earlier driver has asked for it

    def script(bottle):
        yield 0.5

    bottle = run(script, firmware=firmware)
    assert bottle.warned.count("if it stands in a dock, let it go before it drives: rosservice call /undock") == warns


def test_a_link_that_is_lost_before_the_driver_hears_of_it_does_not_end_the_driver(run):
    """While listeners are called, another thread has the line."""
    def lose_the_first_link(bottle):
        def at_publish(topic):
            if topic == "robot_info" and len(bottle.opened) == 1:
                bottle.line.lost = True
                bottle.robot._link.connection.give_up(LinkLostError("the cable is pulled"))

        bottle.at_publish = at_publish

    def script(bottle):
        yield 5.0
        bottle.is_ready = bottle.robot.ready

    bottle = run(script, firmware=in_world_with_dock(), before=lose_the_first_link)
    assert bottle.exit_code == 0 and bottle.is_ready and len(bottle.opened) == 2


def test_a_plugged_in_charger_of_a_robot_that_has_none_for_docks_is_no_reason_to_warn(run):
    firmware = robot()
    firmware.hardware.charger.plug(True)

    def script(bottle):
        yield 0.5
        bottle.charges = has_power(bottle.node._robot.state)

    bottle = run(script, firmware=firmware)
    assert bottle.charges and "stands in a dock" not in bottle.warned


@pytest.mark.parametrize("service", ["dock", "undock"])
@pytest.mark.parametrize("subtype, says", [
    ("p3dx-sh", "the robot reports no charger for docks (CONFIGpac)"),
    ("p2dx", "P2OS firmware does not know CHARGE"),
    ("pion1m", "PSOS firmware does not know CHARGE"),
])
def test_a_robot_without_a_charger_is_not_told_to_dock(run, service, subtype, says):
    def script(bottle):
        bottle.answer = yield from ask(bottle, service)
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script, firmware=robot(subtype))
    assert bottle.answer == (False, says) and bottle.commands("CHARGE") == [] and bottle.locks == ()


def test_a_robot_that_drives_is_not_told_to_dock_and_drives_on(run):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(10):
            bottle.send("cmd_vel", Twist(Vector3(-0.2, 0, 0), Vector3()))
            yield 0.1
        bottle.answer = bottle.call("dock")
        yield 0.1
        bottle.drives = bottle.firmware.velocity[0]

    bottle = run(script, firmware=in_world_with_dock())
    assert not bottle.answer.success and "the robot moves: dock when it stands in the dock" in bottle.answer.message
    assert bottle.drives < -0.1 and bottle.commands("CHARGE") == []


def test_a_robot_that_is_locked_moves_no_contact(run):
    def script(bottle):
        bottle.send("stop_all", Bool(True))
        bottle.answer = yield from ask(bottle, "dock")
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script, firmware=in_world_with_dock())
    assert bottle.answer == (False, "dock refused: stop_all is set") and bottle.commands("CHARGE") == []
    assert bottle.locks == ("stop_all",)


def test_a_robot_in_its_dock_that_is_told_to_dock_again_while_its_cable_is_pulled_stays_locked(run):
    def script(bottle):
        yield from ask(bottle, "dock")
        accessories = bottle.node._requests.accessories._accessories
        dock = accessories.dock

        def without_cable(timeout):
            bottle.unplug()
            dock(timeout)

        accessories.dock = without_cable
        bottle.answer = yield from ask(bottle, "dock")
        bottle.locks = bottle.node._steered.state().locks

    bottle = run(script, firmware=in_world_with_dock())
    assert not bottle.answer[0] and "cable" in bottle.answer[1] and bottle.locks == ("dock",)

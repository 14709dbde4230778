"""Every byte that the robot sends, in long and varied runs of every family of firmware.

The bytes are read by the protocol notes alone, and compared with the truth.
"""

import dataclasses
import math
import random
import struct

import pytest

from by_the_sheet import SIP_HEAD, bodies, command, decode, decode_all, framed

from pioneer_control.robots import find_model, load_table
from pioneer_control.simulator.hardware.accessories import JoystickState
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import load_numbers
from pioneer_control.simulator.world import Can, World

ROOM = 4.0      # half the side of the room, m
RUNS = [
    ("pion1m", None, 0),
    ("p2dx", True, 0),
    ("amigo", None, 0),
    ("p3dx", True, 1),
    ("p3dx-sh", True, 1),
    ("p3at-sh", None, 2),
    ("peoplebot-sh", None, 0),
    ("amigo-sh", None, 0),
    ("powerbot-sh", None, 0),
    ("seekur", None, 0),
    ("pioneer-lx", None, 0),
]
TOUR = b"".join([
    command(18, 1), command(70), command(91, 0), command(42, b"hello"), command(43, 5), command(58, 1), command(45, 3),
    *(command(number, 2) for number in (19, 37, 40, 62, 17, 71))])
"""Asks for everything."""


def room():
    """Return four walls, cans and a dock."""
    corners = [(-ROOM, -ROOM), (ROOM, -ROOM), (ROOM, ROOM), (-ROOM, ROOM)]
    walls = [first + second for first, second in zip(corners, corners[1:] + corners[:1])]
    return World("room", walls=walls, cans=[Can(0.6, 0.3), Can(1.5, -0.5), Can(-1.2, 0.4)], docks=[(0.0, 0.0, 0.0)])


def robot_of(name, gripper, gyro, seed=1):
    """Return a robot with all equipment that its model can have."""
    numbers = load_numbers()
    numbers = dataclasses.replace(
        numbers, gyro=dataclasses.replace(numbers.gyro, kind=gyro),
        compass=dataclasses.replace(numbers.compass, fitted=True))
    robot = Firmware(find_model(name), room(), (0.0, 0.0, 0.0), gripper=gripper, numbers=numbers, seed=seed, noise=0.0)
    robot.hardware.aux[0].device = lambda data: data[::-1]
    return robot


def whims(draw):
    """Return what a user may do to a robot: commands, and actions by hand."""
    number = draw.randrange
    return [
        lambda robot: robot.receive(command(4, 1)),
        lambda robot: robot.receive(command(4, 1) + command(11, number(-600, 600))),
        lambda robot: robot.receive(command(11, number(-600, 600)) + command(21, number(-90, 90))),
        lambda robot: robot.receive(command(21, number(-90, 90))),
        lambda robot: robot.receive(command(8, number(-900, 900))),
        lambda robot: robot.receive(command(12, number(-180, 180))),
        lambda robot: robot.receive(command(13, number(-270, 270)) + command(22, number(-30, 30))),
        lambda robot: robot.receive(command(32, number(-20, 20) << 8 | number(256))),
        lambda robot: robot.receive(command(29)), lambda robot: robot.receive(command(55)),
        lambda robot: robot.receive(command(7)),
        lambda robot: robot.receive(
            command(6, number(100, 1500)) + command(10, number(10, 300)) + command(5, number(-2500, 2500))),
        lambda robot: robot.receive(command(23, number(-400, 400))),
        lambda robot: robot.receive(command(28, number(32))), lambda robot: robot.receive(command(28, 1)),
        lambda robot: robot.receive(command(3, bytes(number(34) for _ in range(number(20))))),
        lambda robot: robot.receive(command(48, number(130))),
        lambda robot: robot.receive(command(30, draw.choice((1, -1)) * number(0x8000))),
        lambda robot: robot.receive(command(35, number(9))),
        lambda robot: robot.receive(command(18, 1)),
        lambda robot: robot.receive(command(draw.choice((19, 37, 40, 62, 17, 58, 71)), number(3))),
        lambda robot: robot.receive(command(45, number(8))),
        lambda robot: robot.receive(command(91, number(5))), lambda robot: robot.receive(command(92, number(2))),
        lambda robot: robot.receive(command(70)),
        lambda robot: robot.receive(command(33, draw.choice((1, 2, 3, 4, 5, 6, 7, 8, 15)))),
        lambda robot: robot.receive(command(33, 17) + command(36, number(-255, 256))),
        lambda robot: robot.receive(command(33, 16) + command(36, number(1, 101))),
        lambda robot: robot.receive(
            command(42, bytes(number(256) for _ in range(number(20)))) + command(43, number(1, 9))),
        lambda robot: robot.receive(command(44, number(4))), lambda robot: robot.receive(command(56, number(2))),
        lambda robot: robot.receive(command(46, number(3)) + command(68, number(2))),
        lambda robot: robot.receive(command(47, number(2))),
        lambda robot: robot.receive(command(draw.choice((82, 85, 88, 93)), number(1, 20000))),
        lambda robot: robot.receive(command(250, draw.choice((0, 0, 113, 125)))),
        lambda robot: robot.hardware.motors.press_stop_button(draw.random() < 0.2),
        lambda robot: setattr(robot.hardware.stall, "held", draw.random() < 0.2),
        lambda robot: setattr(robot.hardware.charger, "plugged_in", draw.random() < 0.5),
        lambda robot: setattr(robot.hardware.sonar, "dead", {number(16)}),
        lambda robot: robot.hardware.jam_gripper(draw.random() < 0.3),
        lambda robot: setattr(
            robot.hardware, "joystick",
            JoystickState(draw.random() < 0.3, draw.random() < 0.5, *(number(1024) for _ in range(3)))),
        lambda robot: robot.hardware.ports.analog_volts.__setitem__(number(8), draw.uniform(0.0, 5.0)),
        lambda robot: setattr(
            robot.hardware.battery, "voltage", draw.uniform(11.2, 13.0) * robot.hardware.battery.scale),
    ]


def units(value, unit):
    """Return a number in units of the wire."""
    return round(value / unit)


def true_sip(robot):
    """Return what the SIP of this moment must have, from the robot's parts."""
    hardware, model, battery, gripper = robot.hardware, robot.model, robot.hardware.battery, robot.gripper
    turn = model.angle_units_per_rev
    x, y, heading = hardware.odometry.pose
    goal = heading + (hardware.drives.angular.remaining or 0.0)
    linear, angular = robot.velocity
    difference = angular / model.diff_rad_per_mm
    front, rear = hardware.bumpers.bits()
    stalled = hardware.motors.stop_button and hardware.motors.stop_button_stalls
    north = (90.0 - math.degrees(robot.true_pose[2])) % 360.0
    joystick = hardware.joystick is not None and hardware.joystick.button_1
    firing = [array in hardware.sonar.firing for array in range(4)]
    flags = [
        robot.motors_enabled, *firing, hardware.motors.stop_button, stalled, False, False, joystick, battery.charging]
    return dict(
        x=units(x * 1000.0, model.dist_mm_per_unit) % 0x8000, y=units(y * 1000.0, model.dist_mm_per_unit) % 0x8000,
        th=(units(heading, 2.0 * math.pi / turn) + turn // 2) % turn - turn // 2,
        control=(units(goal, 2.0 * math.pi / turn) + turn // 2) % turn - turn // 2,
        lvel=units(linear * 1000.0 - difference, model.vel_mm_s_per_unit),
        rvel=units(linear * 1000.0 + difference, model.vel_mm_s_per_unit),
        battery=round(battery.voltage / battery.scale * 10.0), stall_low=(hardware.stall.left or stalled) + 2 * rear,
        stall_high=(hardware.stall.right or stalled) + 2 * front,
        flags=sum(bit << place for place, bit in enumerate(flags)),
        compass=(round(north / 2.0) or 180) if hardware.compass.on else 0, port=hardware.ports.analog_port,
        analog=round(hardware.ports.analog_volts[hardware.ports.analog_port] * 51.0), grip=true_grip(gripper),
        digin=true_digin(robot), digout=hardware.ports.digital_out,
        battery_x10=round(battery.voltage * 10.0), charge_state=battery.charge_state,
        rotvel=round(math.degrees(angular) * 10.0),
        fault=8 if battery.voltage / battery.scale < 11.5 else 0,
    )


def true_grip(gripper):
    """Return the true GRIP_STATE, section 6.2."""
    if gripper is None:
        return 0
    paddles, lift = gripper.paddle_motion, gripper.lift.motion
    bits = [
        paddles > 0 or gripper.is_open and not paddles,
        paddles < 0 or gripper.is_closed and not paddles,
        paddles != 0,
        gripper.paddles_jammed,
        lift > 0 or gripper.lift.is_up and not lift,
        lift < 0 or gripper.lift.is_down and not lift,
        lift != 0,
        gripper.lift.jammed,
    ]
    return sum(bool(bit) << place for place, bit in enumerate(bits))


def true_digin(robot):
    """Return the true DIGIN, section 6.4."""
    gripper = robot.gripper
    if gripper is None:
        return 0xFF
    inner, outer = gripper.beams_broken(robot.true_pose)
    between = 0.0 < gripper.height < gripper.shape.lift_height
    bits = [not gripper.is_open, between, outer, inner, *(not pressed for pressed in gripper.contacts), True, True]
    return sum(bool(bit) << place for place, bit in enumerate(bits))


def check_sip(packet, robot):
    """Check a SIP that was sent just now, field by field."""
    truth = true_sip(robot)
    for name, value in packet.values.items():
        if name == "sonar":
            check_sonar(value, robot)
        else:
            assert abs(value - truth[name]) <= (1 if name in CLOSE else 0), (name, value, truth[name])
    assert packet.id == (0x33 if robot.velocity != (0.0, 0.0) else 0x32)


# These may differ by one, because a rounding may fall either way.
CLOSE = ("x", "y", "th", "control", "lvel", "rvel", "battery", "battery_x10", "rotvel", "analog")
DEAD = set()


def check_sonar(readings, robot):
    """A range is no less than the distance from the transducer to the nearest wall, and no more than the distance to
    the wall straight ahead of it. The robot may have moved since the transducer fired.
    """
    fitted = {transducer.number: transducer for transducer in robot.model.sonar}
    assert len(readings) <= 55
    x, y, heading = robot.true_pose
    angular = robot.velocity[1]
    moved = 0.25 + 0.12 * abs(angular) * ROOM
    for number, units_far in readings:
        assert number in fitted
        far = units_far * robot.model.range_mm_per_unit / 1000.0
        _, ahead, aside, direction = fitted[number]
        cosine, sine = math.cos(heading), math.sin(heading)
        place_x, place_y = x + ahead * cosine - aside * sine, y + ahead * sine + aside * cosine
        clearance = ROOM - max(abs(place_x), abs(place_y))
        slopes = (place_x, math.cos(heading + direction)), (place_y, math.sin(heading + direction))
        along = [(ROOM - math.copysign(1.0, slope) * place) / abs(slope or 1e-9) for place, slope in slopes]
        assert 0.0999 <= far <= 5.0003
        # Some transducers stand out of the body, into a wall that it touches.
        if clearance > 0.0 and number not in robot.hardware.sonar.dead | DEAD:
            nearest, farthest = min(clearance, 5.0), max(0.1, min(min(along), 5.0))
            assert nearest - moved <= far <= farthest + moved, (number, far, clearance, along)


def check(packet, robot):
    """Check any packet that was sent just now."""
    hardware, values = robot.hardware, packet.values
    if packet.id in (0x32, 0x33):
        check_sip(packet, robot)
    elif packet.id == 0x90:
        assert (values["left"], values["right"]) == robot.hardware.wheels.ticks
    elif packet.id == 0xE0 and robot.gripper is None:
        assert set(values.values()) == {0}
    elif packet.id == 0xE0:
        moving = (robot.gripper.lift.motion != 0) << 6 | (robot.gripper.paddle_motion != 0) << 7
        switches = true_digin(robot) & 0x3F | moving
        state = switches if robot.model.firmware_family in ("PSOS", "P2OS", "AmigOS") else true_grip(robot.gripper)
        assert (values["has_gripper"], values["state"]) == (1, state)
        assert values["grasp_time"] == round(robot.gripper.grasp_time * 50.0)
    elif packet.id == 0xF0:
        front, rear = hardware.bumpers.bits()
        assert values["inputs"] == (true_digin(robot), 255 - front, 255 - rear, 255)
        assert values["outputs"] == (hardware.ports.digital_out,)
        older = robot.model.firmware_family in ("PSOS", "P2OS", "AmigOS", "AROS")
        ports, full = (range(1, 6), 2047) if older else (range(8), 1023)
        expected = tuple(round(hardware.ports.analog_volts[port] / 5.0 * full) for port in ports)
        assert values["analog"][:len(ports)] == expected
        assert len(values["analog"]) == len(ports) + (not older)
    elif packet.id == 0xFA:
        share = max(0.0, min(1.0, (hardware.battery.voltage / hardware.battery.scale - 11.0) / 2.0))
        assert values["batteries"] == [(0, 0, 0, round(share * 100.0), round(share * 100.0))]
    elif packet.id == 0xF8 and hardware.joystick is not None:
        stick = hardware.joystick
        assert tuple(values.values()) == (stick.button_1, stick.button_2, stick.x, stick.y, stick.throttle)
    elif packet.id == 0xC0:
        north = (90.0 - math.degrees(robot.true_pose[2])) % 360.0
        for degrees in (values["heading"] / 10.0, math.degrees(math.atan2(-values["mag_y"], values["mag_x"]))):
            assert abs(math.remainder(degrees - north, 360.0)) < 0.06
    elif packet.id == 0x20:
        check_config(values, robot)
    elif packet.id == 0x98:
        assert len(values["readings"]) <= 40 and all(temperature == 120 for _, temperature in values["readings"])


def check_config(values, robot):
    """Check CONFIGpac against the model, the limits and the equipment."""
    hardware, model = robot.hardware, robot.model
    linear, angular = hardware.drives.linear.limits, hardware.drives.angular.limits
    truth = dict(
        type="Pioneer", subtype=model.subtype, serial="0001", four_mots=0, rot_vel_top=round(math.degrees(angular.top)),
        trans_vel_top=round(linear.top * 1000), rot_acc_top=300, trans_acc_top=2000, pwm_max=500, name="sim_0001",
        sip_cycle=100, host_baud=0, has_gripper=int(robot.gripper is not None), low_battery=115,
        watchdog=2000, p2mpacs=0, joy_vel=750, joy_rvel=50,
        rot_vel_max=round(math.degrees(angular.limit)), trans_vel_max=round(linear.limit * 1000),
        rot_acc=round(math.degrees(angular.rise)), rot_decel=round(math.degrees(angular.fall)),
        trans_acc=round(linear.rise * 1000), trans_decel=round(linear.fall * 1000),
        front_bumps=model.front_bumpers, rear_bumps=model.rear_bumpers,
        charger=2 if model.subtype == "powerbot-sh" else 1,
        sonar_cycle=hardware.sonar.cycle_us // 1000, auto_baud=2, has_gyro=hardware.gyro.kind,
        ticks_mm=hardware.wheels.ticks_per_mm, rev_count=hardware.wheels.rev_count,
        rot_kp=robot.settings["rotation_kp"], trans_kp=robot.settings["translation_kp"],
        shutdown_volts=110, version="2.9")
    for name in truth.keys() & values.keys():
        assert values[name] == truth[name], name
    # A client refuses zeros.
    assert min(values[name] for name in values if name.endswith(("_top", "_max")) and not name.startswith("lat")) > 0


def live(robot, seconds, seed, look):
    """Let a robot live with random commands, and give each packet to `look` in the step in which it was sent.

    Returns: All bytes that the robot sent.
    """
    draw = random.Random(seed)
    robot.receive(command(0) + command(1) + command(2) + command(1, 1) + command(4, 1) + TOUR)
    doings = whims(draw)
    stream = b""
    for step in range(round(seconds * 50)):
        sent = robot.advance(0.02)
        for body in bodies(sent):
            look(decode(body, robot.model.firmware_family), robot)
        stream += sent
        if step % 3 == 0:
            DEAD.clear()
            DEAD.update(robot.hardware.sonar.dead)
            draw.choice(doings)(robot)
        if step % 50 == 0:
            robot.receive(command(0))
    return stream


@pytest.mark.parametrize("name, gripper, gyro", RUNS)
def test_every_byte_has_its_meaning_and_is_true(name, gripper, gyro):
    robot = robot_of(name, gripper, gyro)
    stream = live(robot, 30.0, seed=5, look=check)
    packets = decode_all(stream, robot.model.firmware_family)
    assert [packet.id for packet in packets[:3]] == [0, 1, 2]
    assert packets[2].values == {"name": "sim_0001", "class": "Pioneer", "subclass": name}
    assert sum(packet.id in (0x32, 0x33) for packet in packets) == 300
    older = {0x20, 0x90, 0xE0, 0xF0, 0xC0, 0xD0, 0xA0, 0xA1, 0xB0}
    later = {0x20, 0x90, 0xE0, 0xF0, 0xC0, 0xF8, 0xA0, 0xA1, 0xB0, 0xFA}
    families = {"PSOS": set(), "P2OS": older, "AmigOS": older, "AROS": older | {0xF8}}
    wanted = families.get(robot.model.firmware_family, later)
    assert {packet.id for packet in packets} - {0, 1, 2, 0x32, 0x33} == wanted | ({0x98} if gyro == 1 else set())


def test_every_model_says_a_little_and_all_of_it_decodes():
    for name in load_table().models:
        robot = robot_of(name, None, 0)
        stream = live(robot, 2.0, seed=2, look=lambda packet, robot: None)
        assert len(decode_all(stream, robot.model.firmware_family)) > 20


# It sees what is wrong

def said():
    """Return what a robot sends in a second, as bytes."""
    return live(robot_of("p3dx-sh", True, 1), 1.0, seed=5, look=lambda packet, robot: None)


def test_no_changed_byte_goes_unseen():
    stream = said()[:400]
    stream = b"".join(framed(body) for body in bodies_until_broken(stream))
    assert len(stream) > 300
    for at in range(len(stream)):
        for change in (0x01, 0x80):
            with pytest.raises(AssertionError):
                decode_all(stream[:at] + bytes([stream[at] ^ change]) + stream[at + 1:], "ARCOS")


def bodies_until_broken(stream):
    """Return the whole packets at the front of a stream that was cut."""
    found = []
    while len(stream) > 3 and len(stream) >= stream[2] + 3:
        end = stream[2] + 3
        found += bodies(stream[:end])
        stream = stream[end:]
    return found


def test_a_missing_or_an_additional_byte_is_seen_in_every_packet():
    for body in bodies(said()):
        if body[0] not in (0, 1, 0xB0):
            for wrong in (body[:-1], body + b"\0"):
                with pytest.raises(AssertionError):
                    decode(wrong, "ARCOS")


@pytest.mark.parametrize("family", ["P2OS", "AROS", "AmigoSH"])
def test_the_packets_of_another_family_are_seen(family):
    with pytest.raises(AssertionError):
        decode_all(said(), family)


def test_no_untrue_bit_of_a_sip_goes_unseen():
    """Each bit is changed, and the checksum made right. Then the comparison with the truth must find the change."""
    robot = robot_of("p3dx-sh", True, 0)
    robot.receive(command(0) + command(1) + command(2) + command(1))
    robot.advance(0.08)
    body, = bodies(robot.advance(0.02))
    check(decode(body, "ARCOS"), robot)
    unseen = []
    for at in range(len(body)):
        for bit in range(8):
            try:
                check(decode(body[:at] + bytes([body[at] ^ 1 << bit]) + body[at + 1:], "ARCOS"), robot)
            except AssertionError:
                continue
            unseen.append((at, bit))
    begin = 1 + sum(map(struct.calcsize, (SIP_HEAD + " n B").split()[1::2]))
    # Ranges are checked only as far as a cone has bounds; test_firmware_sensors.py checks their order and values.
    sonar = range(begin, begin + 3 * 4)
    assert not any(bit for at, bit in unseen if at not in sonar)
    assert len([at for at, _ in unseen if at not in sonar]) == len(CLOSE)       # what a rounding may change

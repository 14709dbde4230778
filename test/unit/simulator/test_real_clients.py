"""What real client programs do, byte for byte, in simulated time.

The protocol sheet describes what they do (sections 2, 8 and 13). Bytes go in by `Firmware.receive` and come out of
`Firmware.advance`. They are made and read by the tables of the sheet, without the package's own codec.
"""

import dataclasses
import math

import pytest

from by_the_sheet import Packet, bodies, command, decode, framed

from pioneer_control.robots import find_model
from pioneer_control.simulator.hardware.accessories import JoystickState
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import load_numbers
from pioneer_control.simulator.world import Can, World

PULSE, OPEN, CLOSE = command(0), command(1, 1), command(2, 1)
SIPS = (0x32, 0x33)
EMPTY = ((0.0, 0.0, 0.0),)


class Client:
    """A program that talks to a robot, and the packets that it heard."""

    def __init__(self, model="p3dx-sh", world=None, **options):
        self.model = find_model(model)
        self.robot = Firmware(self.model, world or World("hall", starts=EMPTY), (0.0, 0.0, 0.0), **options)
        self.heard = []
        self.time = 0.0

    def say(self, *packets):
        """Send packets, each with one write."""
        for packet in packets:
            self.robot.receive(packet)
        return self

    def wait(self, seconds, repeat=(), every=0.5):
        """Listen for so long, and repeat some packets."""
        for step in range(round(seconds / 0.01)):
            if repeat and step % round(every / 0.01) == 0:
                self.say(*repeat)
            self.heard += [decode(body, self.model.firmware_family) for body in bodies(self.robot.advance(0.01))]
            self.time += 0.01
        return self

    def ask(self, packet, number, limit=1.0):
        """Repeat one packet until a packet of a kind comes. Returns this packet, or None."""
        before = len(self.heard)
        for _ in range(round(limit / 0.2)):
            self.say(packet)
            for _ in range(20):
                self.wait(0.01)
                found = [each for each in self.heard[before:] if each.id == number]
                if found:
                    return found[0]
        return None

    def connect(self):
        """Connect as the vendor's client does: each SYNC waits for its echo. When a SIP answers, it sends CLOSE and
        begins again.
        """
        self.say(b"WMS2\r")
        for _ in range(50):
            number = 0
            while number < 3:
                answer = self.answer_to_sync(number)
                if answer is None or answer.id != number:
                    if answer is not None and answer.id == 0x32:
                        self.say(command(2)).wait(0.1)
                    break
                number += 1
            else:
                self.names = answer.values
                return self.wait(0.1).say(OPEN).wait(0.02)
        raise AssertionError("no connection")

    def answer_to_sync(self, number):
        """Return the first packet within a second of a SYNC."""
        before = len(self.heard)
        self.say(command(number))
        for _ in range(100):
            self.wait(0.01)
            if len(self.heard) > before:
                return self.heard[before]
        return None

    def prepare(self):
        """Do what follows the connection: ask for the configuration, the battery, and the robot's own limits and
        accelerations.
        """
        self.config = self.ask(command(18, 1), 0x20).values
        self.say(command(62, 1)).wait(0.2)
        config = self.config
        return self.say(
            command(6, config["trans_vel_max"]), command(5, config["trans_acc"]), command(5, -config["trans_decel"]),
            command(10, config["rot_vel_max"]), command(23, config["rot_acc"]), command(23, -config["rot_decel"]))

    def disconnect(self):
        """End as the client does: motors off, then CLOSE."""
        return self.say(command(4, 0)).wait(0.1).say(CLOSE).wait(0.1)

    @property
    def sips(self):
        """Return all SIPs."""
        return [packet.values for packet in self.heard if packet.id in SIPS]

    @property
    def sip(self):
        """Return the newest SIP."""
        return self.sips[-1]

    def of(self, number):
        """Return all packets of a kind, as values."""
        return [packet.values for packet in self.heard if packet.id == number]

    @property
    def pose(self):
        """Return x, y in mm and the heading in degrees, of the newest SIP."""
        x, y = (((self.sip[name] + 0x4000) % 0x8000 - 0x4000) * self.model.dist_mm_per_unit for name in ("x", "y"))
        return x, y, self.sip["th"] * 360.0 / self.model.angle_units_per_rev


def driving(model="p3dx-sh", **options):
    """Return a client that is connected, with motors on."""
    return Client(model, **options).connect().prepare().say(command(4, 1)).wait(0.2)


# Connecting

FIVE = ["p3dx-sh", "p3at-sh", "peoplebot-sh", "amigo-sh", "p2dx"]


@pytest.mark.parametrize("model", FIVE)
def test_connect_and_identify(model):
    client = Client(model, name="lab_3").connect()
    assert client.names == {"name": "lab_3", "class": "Pioneer", "subclass": model}
    client.wait(3.0, [PULSE])
    assert len(client.sips) == 30 and not client.sip["flags"] & 1
    assert (client.sip["x"], client.sip["y"], client.sip["th"]) == (0, 0, 0)
    assert {packet.id for packet in client.heard} == {0, 1, 2, 0x32}


def test_the_answer_to_sync_is_as_the_notes_write_it():
    client = Client(name="p3dx_0001")
    client.say(bytes.fromhex("FAFB03000000"))
    assert client.robot.advance(0.02) == bytes.fromhex("FAFB03000000")
    client.say(bytes.fromhex("FAFB03010001"))
    assert client.robot.advance(0.02) == bytes.fromhex("FAFB03010001")
    client.say(bytes.fromhex("FAFB03020002"))
    name = "FAFB1D02703364785F303030310050696F6E65657200703364782D7368006B93"
    assert client.robot.advance(0.02) == bytes.fromhex(name)


COMMON = dict(
    type="Pioneer", serial="0001", four_mots=0, rot_acc_top=300, trans_acc_top=2000, pwm_max=500, name="sim_0001",
    sip_cycle=100, host_baud=0, aux1_baud=0, front_sonar=1, low_battery=115, rev_count=16570, watchdog=2000,
    p2mpacs=0, stall_val=200, stall_count=100, joy_vel=750, joy_rvel=50, rot_vel_max=100, trans_vel_max=750,
    rot_acc=100, rot_decel=100, rot_kp=40, rot_kv=20, rot_ki=0,
    trans_acc=300, trans_decel=300, trans_kp=40, trans_kv=30, trans_ki=0)
LATER = dict(
    charger=0, sonar_cycle=40, auto_baud=2, has_gyro=0, drift_factor=0, aux2_baud=0, aux3_baud=0, ticks_mm=128,
    shutdown_volts=110, version="2.9")
ARCOS = dict(
    gyro_cw=0, gyro_ccw=0, kinematics_delay=0, lat_vel_top=0, lat_acc_top=0, lat_vel_max=0, lat_acc=0, lat_decel=0,
    charge_threshold=0)


@pytest.mark.parametrize("model, own", [
    ("p3dx-sh", dict(
        trans_vel_top=1500, rot_vel_top=360, has_gripper=1, rear_sonar=1, front_bumps=0, rear_bumps=0,
        **LATER, **ARCOS)),
    ("p3at-sh", dict(
        trans_vel_top=1200, rot_vel_top=300, has_gripper=0, rear_sonar=1, front_bumps=0, rear_bumps=0,
        **LATER, **ARCOS)),
    ("peoplebot-sh", dict(
        trans_vel_top=1500, rot_vel_top=360, has_gripper=0, rear_sonar=1, front_bumps=5, rear_bumps=5,
        **LATER, **ARCOS)),
    ("amigo-sh", dict(
        trans_vel_top=1000, rot_vel_top=300, has_gripper=0, rear_sonar=0, front_bumps=0, rear_bumps=0, **LATER)),
    ("p2dx", dict(trans_vel_top=1500, rot_vel_top=360, has_gripper=0, rear_sonar=1)),
])
def test_configuration_field_by_field(model, own):
    assert Client(model).connect().prepare().config == dict(COMMON, subtype=model, **own)


def test_configuration_is_answered_once_for_each_question():
    client = Client().connect().say(command(18, 1), command(18), command(18, -1)).wait(0.5)
    assert len(client.of(0x20)) == 3


# Driving: ends where it should, within 2 %

@pytest.mark.parametrize("model", FIVE)
@pytest.mark.parametrize("far", [1000, -300, 250, -1000])
def test_move_arrives_also_backward(model, far):
    client = driving(model).say(command(8, far)).wait(7.0, [PULSE])
    assert client.pose[0] == pytest.approx(far, rel=0.02)
    assert client.robot.true_pose[0] * 1000.0 == pytest.approx(far, rel=0.02)
    assert abs(client.pose[1]) < 5 and client.sip["lvel"] == client.sip["rvel"] == 0


@pytest.mark.parametrize("model", FIVE)
@pytest.mark.parametrize("goal", [90, -90, 175, 10])
def test_head_arrives(model, goal):
    client = driving(model).wait(6.0, [command(12, goal)], every=0.1)
    assert client.pose[2] == pytest.approx(goal, rel=0.02)
    assert math.degrees(client.robot.true_pose[2]) == pytest.approx(goal, rel=0.02)
    client.wait(6.0, [command(12, 0)], every=0.1)
    assert abs(client.pose[2]) < 1.0


@pytest.mark.parametrize("angle", [45, -45, 180, -270])
def test_dhead_turns_by_that_much(angle):
    client = driving().say(command(13, angle)).wait(6.0, [PULSE])
    assert math.degrees(client.robot.true_pose[2]) == pytest.approx(angle, rel=0.02)


@pytest.mark.parametrize("model", FIVE)
def test_a_velocity_repeated_every_half_second(model):
    client = driving(model).wait(3.0, [command(11, 200)])
    start = client.pose[0]
    client.wait(5.0, [command(11, 200)])
    assert client.pose[0] - start == pytest.approx(1000, rel=0.02)
    velocity_units = (client.sip["lvel"] + client.sip["rvel"]) / 2
    assert velocity_units * client.model.vel_mm_s_per_unit == pytest.approx(200, rel=0.02)
    client.wait(1.5, [command(11, 0)])
    assert client.sip["lvel"] == 0 and client.robot.velocity[0] == 0.0


@pytest.mark.parametrize("model", FIVE)
@pytest.mark.parametrize("rate", [30, -30])
def test_a_rotation_repeated_every_half_second(model, rate):
    client = driving(model).wait(2.0, [command(21, rate)])
    start = client.robot.true_pose[2]
    client.wait(5.0, [command(21, rate)])
    assert math.degrees(client.robot.true_pose[2] - start) == pytest.approx(5 * rate, rel=0.02)
    difference_mm_s = (client.sip["rvel"] - client.sip["lvel"]) / 2 * client.model.vel_mm_s_per_unit
    turning_rad_s = difference_mm_s * client.model.diff_rad_per_mm
    assert math.degrees(turning_rad_s) == pytest.approx(rate, rel=0.03)      # whole mm/s
    assert client.sip.get("rotvel", 10 * rate) == pytest.approx(10 * rate, rel=0.02)


@pytest.mark.parametrize("model", FIVE)
@pytest.mark.parametrize("value, left, right", [
    (0x0A0A, 200, 200), (0xF60A, -200, 200), (-0x09F6, -200, 200), (0x0AF6, 200, -200), (0x050A, 100, 200)])
def test_wheel_velocities_as_both_clients_write_them(model, value, left, right):
    client = driving(model).say(command(10, 200)).wait(3.0, [command(32, value)])
    wheels = tuple(client.sip[name] * client.model.vel_mm_s_per_unit for name in ("lvel", "rvel"))
    assert wheels == (pytest.approx(left, abs=3), pytest.approx(right, abs=3))


def test_before_arcos_wheel_velocities_have_no_limit_of_turning():
    def turning(model):
        client = driving(model).say(command(10, 20)).wait(3.0, [command(32, 0xF60A)])
        return math.degrees(client.robot.velocity[1])
    assert turning("p3dx-sh") == pytest.approx(20.0) and turning("p3dx") == pytest.approx(math.degrees(200 * 0.0056))


def test_an_arc_and_a_square():
    client = driving().wait(2.0, [command(11, 200), command(21, 20)])
    x, y, heading = client.robot.true_pose
    client.wait(18.0, [command(11, 200), command(21, 20)])
    assert math.degrees(client.robot.true_pose[2] - heading) == pytest.approx(360, rel=0.02)
    assert math.hypot(client.robot.true_pose[0] - x, client.robot.true_pose[1] - y) < 0.02
    client = driving()
    for _ in range(4):
        client.say(command(8, 500)).wait(4.0, [PULSE]).say(command(13, 90)).wait(3.0, [PULSE])
    assert math.hypot(*client.robot.true_pose[:2]) < 0.01
    assert math.degrees(client.robot.true_pose[2]) == pytest.approx(360, rel=0.02)


def test_limits_and_ramps_as_told():
    client = driving().say(command(6, 300), command(5, 1000), command(5, -500)).wait(0.5, [command(11, 900)])
    assert client.robot.velocity[0] == pytest.approx(0.3)
    client.say(command(11, 0)).wait(0.32)
    assert client.robot.velocity[0] == pytest.approx(0.15, abs=0.011)
    client.say(command(10, 40), command(23, 80)).wait(0.52, [command(21, 90)])
    assert math.degrees(client.robot.velocity[1]) == pytest.approx(40.0, abs=1.7)


def test_limits_of_one_turning_direction():
    client = driving().say(command(14, -20), command(20, 60)).wait(3.0, [command(21, 90)])
    assert math.degrees(client.robot.velocity[1]) == pytest.approx(60.0)
    client.wait(3.0, [command(21, -90)])
    assert math.degrees(client.robot.velocity[1]) == pytest.approx(-20.0)
    client.say(command(10, 50)).wait(3.0, [command(21, -90)])
    assert math.degrees(client.robot.velocity[1]) == pytest.approx(-50.0)


def test_motors_off_stop_and_emergency_stop():
    client = Client().connect().wait(1.0, [command(11, 200)])
    assert client.robot.velocity == (0.0, 0.0)
    client.say(command(4, 1)).wait(2.0, [command(11, 400)])
    assert client.sip["flags"] & 1 and client.robot.velocity[0] == pytest.approx(0.4)
    client.say(command(55, 1)).wait(0.25)
    assert client.robot.velocity[0] == 0.0
    client.wait(1.0, [PULSE])
    assert client.robot.velocity[0] == 0.0
    client.wait(1.0, [command(11, 200)]).say(command(29)).wait(0.3)
    assert 0.0 < client.robot.velocity[0] < 0.2
    client.wait(0.6).say(command(4, 0)).wait(0.2)
    assert not client.sip["flags"] & 1


def test_the_pose_after_seto_both_ways_of_writing_it():
    for seto in ("FAFB03070007", "FAFB04073B073B"):
        client = driving().say(command(8, 400)).wait(4.0, [PULSE]).say(bytes.fromhex(seto)).wait(0.2)
        assert client.pose == (0, 0, 0)
        steps = [abs(after["x"] - before["x"]) for before, after in zip(client.sips, client.sips[1:])]
        assert max(steps) <= 4096       # a greater one would be taken for a wrap


def test_silence_stops_it_and_any_packet_revives_it():
    client = driving().wait(2.0, [command(11, 300)]).wait(4.0)
    assert client.robot.velocity[0] == 0.0 and client.sip["flags"] & 1
    sips = len(client.sips)
    assert len(client.wait(1.0).sips) == sips + 10
    assert client.say(PULSE).wait(1.2).robot.velocity[0] == pytest.approx(0.3)


# Gripper, as the vendor's gripper class and as p2os read it

def beams(sip):
    """Return whether the inner and outer beams are broken, and whether the left and right contacts are pressed."""
    return bool(sip["digin"] & 8), bool(sip["digin"] & 4), not sip["digin"] & 16, not sip["digin"] & 32


@pytest.mark.parametrize("model, gripper", [("p3dx-sh", None), ("p3dx", True), ("p2dx", True), ("peoplebot-sh", True)])
def test_the_gripper_takes_a_can(model, gripper):
    front = find_model(model).length_front
    client = driving(model, world=World("can", cans=[Can(front + 0.04 + 0.03, 0.0)]), gripper=gripper)
    kind = client.ask(command(37, 2), 0xE0).values["has_gripper"]
    client.say(command(37, 0)).wait(0.5)
    told = len(client.of(0xE0))
    assert kind == 1 and len(client.wait(1.0).of(0xE0)) == told         # zero means stop, and is not answered
    assert client.sip["grip"] == 0x11 and not client.sip["digin"] & 0x03
    assert beams(client.sip) == (False, False, False, False)
    client.say(command(33, 5)).wait(0.5)
    assert client.sip["grip"] == 0x61 and client.sip["digin"] & 2       # lift moving, downward; between its limits
    client.wait(4.0, [PULSE])
    assert client.sip["grip"] == 0x21 and not client.sip["digin"] & 2 and beams(client.sip)[0]
    client.say(command(33, 2)).wait(0.5)
    assert client.sip["grip"] == 0x26 and client.sip["digin"] & 1
    client.wait(3.0, [PULSE])
    assert client.sip["grip"] == 0x22 and beams(client.sip) == (True, False, True, True)
    client.say(command(33, 4)).wait(4.5, [PULSE])
    assert client.sip["grip"] == 0x12 and client.robot.gripper.held_can is not None
    client.say(command(33, 8)).wait(5.0, [PULSE])
    assert client.sip["grip"] == 0x21 and beams(client.sip)[2:] == (False, False)


@pytest.mark.parametrize("model, gripper", [("p3dx-sh", None), ("p3dx", True), ("p2dx", True), ("peoplebot-sh", True)])
def test_the_gripper_closes_on_nothing_and_shows_it_as_clients_wait_for_it(model, gripper):
    """The vendor's gripper class reads 0 in bits 4 and 5 of DIGIN as closed paddles, with or without a can between."""
    client = driving(model, gripper=gripper).say(command(33, 5)).wait(4.5, [PULSE]).say(command(33, 2)).wait(2.0)
    assert client.sip["grip"] == 0x26 and beams(client.sip) == (False, False, False, False)
    client.wait(1.0, [PULSE])
    assert client.sip["grip"] == 0x22 and beams(client.sip) == (False, False, True, True)
    client.say(command(33, 4)).wait(4.5, [PULSE])
    assert client.sip["grip"] == 0x12 and beams(client.sip) == (False, False, True, True)
    client.say(command(33, 1)).wait(0.2)
    assert client.sip["grip"] == 0x15 and beams(client.sip) == (False, False, False, False)


@pytest.mark.parametrize("stop, state", [(3, 0x10), (15, 0x10)])
def test_the_paddles_stop_in_between(stop, state):
    client = driving().say(command(33, 2)).wait(1.0).say(command(33, stop)).wait(0.3)
    assert client.sip["grip"] == state and 0.0 < client.robot.gripper.opening < client.robot.gripper.shape.opening


def test_sub_commands_that_mean_nothing_and_a_robot_without_gripper():
    client = driving()
    for number in (0, 9, 14, 18, -1, 255):
        client.say(command(33, number))
    assert client.wait(1.0).sip["grip"] == 0x11
    client = driving(gripper=False).say(command(33, 2)).wait(1.0)
    assert (client.sip["grip"], client.sip["digin"]) == (0, 255)
    assert client.ask(command(37, 1), 0xE0).values["has_gripper"] == 0


# Inputs, outputs, encoders, sonar, battery

def test_outputs_by_mask_as_one_signed_word():
    client = Client().connect().say(command(30, -251)).wait(0.2)                # mask FF, states 05
    assert client.sip["digout"] == 0x05
    client.say(command(30, 0x0501)).wait(0.2)
    assert client.sip["digout"] == 0x01                                         # bit 0 set again, bit 2 cleared
    client.say(command(30, 0x0101)).wait(0.2)
    assert client.sip["digout"] == 0x01                                         # set, not toggled
    assert client.ask(command(40, 1), 0xF0).values["outputs"] == (1,)


@pytest.mark.parametrize("model, analog", [("p3dx-sh", 9), ("p3dx", 5), ("p2dx", 5), ("amigo-sh", 9)])
def test_inputs(model, analog):
    client = Client(model, gripper=False if model == "p3dx-sh" else None).connect()
    values = client.ask(command(40, 1), 0xF0).values
    assert values["inputs"] == (255, 255, 255, 255) and len(values["analog"]) == analog
    client.robot.hardware.ports.analog_volts[2] = 2.5
    client.say(command(35, 2)).wait(0.2)
    assert (client.sip["port"], client.sip["analog"]) == (2, 128)


@pytest.mark.parametrize("number, packet", [(19, 0x90), (37, 0xE0), (40, 0xF0), (62, 0xFA), (17, 0xF8)])
def test_requests_once_continuous_and_stopped(number, packet):
    client = Client().connect().say(command(number, 1)).wait(0.5)
    assert len(client.of(packet)) == 1
    assert len(client.say(command(number, 2)).wait(1.0).of(packet)) == 11
    assert len(client.say(command(number, 0)).wait(1.0).of(packet)) == 11
    # It stops, however often it is told to.
    assert len(client.wait(1.0, [command(number, 0)], every=0.01).of(packet)) == 11
    client.say(command(number, 2)).wait(0.3).disconnect()
    told = len(client.of(packet))
    assert len(client.connect().wait(1.0).of(packet)) == told                           # nor is it remembered


def test_encoders_count_the_wheels():
    client = driving().say(command(8, 1000)).wait(6.0, [PULSE])
    assert client.ask(command(19, 1), 0x90).values == {"left": 128000, "right": 128000}
    client.say(command(8, -2000)).wait(9.0, [PULSE])
    ticks = pytest.approx(-128000, rel=0.01)
    assert client.ask(command(19, 1), 0x90).values == {"left": ticks, "right": ticks}


@pytest.mark.parametrize("model, count", [
    ("p3dx-sh", 16),
    ("p3at-sh", 16),
    ("peoplebot-sh", 32),
    ("amigo-sh", 8),
    ("p2dx", 16),
])
def test_sonar_runs_after_open_and_every_transducer_is_heard(model, count):
    client = Client(model, world=World("wall", walls=[(2.0, -9.0, 2.0, 9.0)]), noise=0.0).connect().wait(0.6)
    heard = [number for sip in client.sips for number, _ in sip["sonar"]]
    assert set(heard) == set(range(count))
    assert all(len(sip["sonar"]) <= 3 * (count // 8) for sip in client.sips)            # a few in each SIP
    ranges = {number: units * client.model.range_mm_per_unit for sip in client.sips for number, units in sip["sonar"]}
    front = min(client.model.sonar, key=lambda transducer: abs(transducer.heading))
    assert ranges[front.number] == pytest.approx((2.0 - front.x) * 1000.0, rel=0.02)
    assert max(ranges.values()) == pytest.approx(5000, abs=1)                            # no echo


def test_sonar_off_and_on_all_and_by_array():
    client = Client().connect().say(command(28, 0)).wait(0.5)
    assert client.sip["sonar"] == [] and not client.sip["flags"] & 0x1E
    client.say(command(28, 1)).wait(0.5)
    assert client.sip["sonar"] and client.sip["flags"] & 0x1E == 0x06
    client.say(command(28, 0x04)).wait(0.5)     # array 2 off
    assert client.sip["flags"] & 0x1E == 0x02 and all(number < 8 for number, _ in client.sip["sonar"])
    client.say(command(28, 0x05)).wait(0.5)
    assert client.sip["flags"] & 0x1E == 0x06


def test_a_firing_sequence_of_its_own():
    client = Client().connect().say(bytes.fromhex("FAFB09032B0401020102092F")).wait(1.0)      # 1, 2, 1, 2
    heard = [number for sip in client.sips[2:] for number, _ in sip["sonar"]]
    assert {number for number in heard if number < 8} == {0, 1}
    assert {number for number in heard if number >= 8} == set(range(8, 16))
    client.say(command(3, b"")).wait(0.3)
    assert client.sip["sonar"] == []


def test_battery():
    client = Client().connect()
    assert client.ask(command(62, 1), 0xFA).values == {"batteries": [(0, 0, 0, 100, 100)]}
    assert (client.sip["battery"], client.sip["battery_x10"]) == (130, 130)
    assert (client.sip["charge_state"], client.sip["fault"]) == (0, 0)
    client.say(bytes.fromhex("FAFB06FA3B73006D3B")).wait(0.2)       # 11.5 V
    assert client.sip["battery"] == 115
    client.say(command(250, 112)).wait(0.2)
    assert client.sip["fault"] == 8 and client.ask(command(62, 1), 0xFA).values == {"batteries": [(0, 0, 0, 10, 10)]}
    assert client.say(command(250, 0)).wait(0.2).sip["battery"] == 130


# Strings of odd length, pass-through, sounds

@pytest.mark.parametrize("length", range(9))
def test_strings_of_any_length(length):
    client = Client().connect()
    client.robot.hardware.aux[0].device = lambda data: data.upper()
    text = b"abcdefghi"[:length]
    client.say(command(42, text), command(43, max(1, length))).wait(0.3)
    assert [packet["bytes"] for packet in client.of(0xB0)] == ([text.upper()] if length else [])
    assert client.say(command(15, text)).wait(0.2).sip and client.robot.decoder.counts.bad_checksums == 0


def test_a_string_with_an_uncounted_nul_and_packets_in_pieces():
    client = Client().connect()
    client.robot.hardware.aux[1].device = lambda data: data
    packet = command(66, b"hello")
    body = packet[3:-2] + b"\0"
    whole = framed(body) + command(67, 5)
    for at in range(len(whole)):
        client.say(whole[at:at + 1]).wait(0.01)
    assert [values["bytes"] for values in client.wait(0.2).of(0xB8)] == [b"hello"]


def test_aux_collects_and_flushes():
    client = Client().connect()
    port = client.robot.hardware.aux[0]
    port.put(b"stale")
    client.say(command(43, 0)).wait(0.1)
    port.put(b"fresh")
    client.say(command(43, 8)).wait(0.3)
    assert client.of(0xB0) == []
    port.put(b" bytes")
    assert [values["bytes"] for values in client.wait(0.2).of(0xB0)] == [b"fresh by"]


def test_playlists():
    assert Client("p2dx").connect().ask(command(91, 0), 0xD0) == Packet(0xD0, {})
    client = Client("amigo").connect().say(command(92, 0)).say(command(91, 0)).wait(0.3)
    first, *others = client.of(0xD0)
    assert first["sound"] == 3 == len(others) + 1 and first["on"] == 0 and first["name"].rstrip(b"\0") == b"~greetings"
    assert Client().connect().ask(command(91, 0), 0xD0) is None


# Reconnecting

def test_twenty_polite_reconnects():
    client = Client()
    for count in range(20):
        begin = client.time
        client.connect().prepare().say(command(4, 1)).wait(0.5, [command(11, 200)])
        assert client.sip["flags"] & 1 and client.time - begin < 1.2
        client.disconnect()
        assert not client.robot.motors_enabled and client.robot.closed_sessions == count + 1
        told = len(client.heard)
        assert len(client.wait(0.5).heard) == told
    assert client.robot.velocity == (0.0, 0.0)


def test_twenty_rude_reconnects():
    """The program is killed while the robot drives. The next program begins when the watchdog has stopped the robot.
    Its first packet is a SYNC0.
    """
    client = Client()
    for _ in range(20):
        client.connect().prepare().say(command(4, 1)).wait(0.5, [command(21, 30)])
        client.say(command(21, 0)).wait(0.5).wait(2.5)
        begin = client.time
        client.connect()
        assert client.time - begin < 1.0
        assert not client.wait(0.2).sip["flags"] & 1
        client.say(command(2)).wait(0.1)


def test_an_open_robot_gives_sips_for_a_sync_and_close_dislodges_it():
    client = Client().connect().wait(0.5)
    assert client.answer_to_sync(0).id == 0x32
    client.say(command(2)).wait(0.15)
    assert client.answer_to_sync(0).id == 0


def test_p2os_at_its_start_hears_a_packet_for_each_it_sends():
    client = Client()
    for number in (0, 1, 2):
        assert client.answer_to_sync(number).id == number
        client.wait(0.2)
    client.say(command(1)).wait(0.1).say(command(0))
    camera = (command(42, b"\x90\x30"), command(43, 6), command(43, 0))
    for packet in (command(28, 0), command(5, 300), command(44, 3), bytes.fromhex("FAFB04073B073B"), *camera):
        heard = len(client.heard)
        client.say(packet).wait(0.15)
        assert len(client.heard) > heard
    assert client.sip["sonar"] == []


# Docking

def test_a_robot_charges_at_a_dock_after_charge():
    client = driving(world=World("dock", docks=[(1.0, 0.0, 0.0)]))
    assert client.config["charger"] == 1
    client.robot.hardware.battery.voltage = 12.0
    client.say(command(68, 1)).wait(0.3)
    assert (client.sip["charge_state"], client.sip["flags"] >> 10 & 1) == (0, 0)        # not there yet
    client.say(command(8, 1000)).wait(5.0, [PULSE])
    assert (client.sip["charge_state"], client.sip["flags"] >> 10 & 1) == (1, 1)
    before = client.robot.hardware.battery.voltage
    client.wait(60.0, [PULSE])
    assert client.robot.hardware.battery.voltage > before + 0.04
    client.say(command(68, 0)).wait(0.3)
    assert (client.sip["charge_state"], client.sip["flags"] >> 10 & 1) == (0, 0)
    client.say(command(68, 1)).wait(0.2).say(command(8, -500)).wait(4.0, [PULSE])
    assert client.sip["charge_state"] == 0                                               # driven away


def test_p2os_docks_and_stops_when_it_senses_power():
    client = driving("p2dx", world=World("dock", docks=[(1.0, 0.0, 0.0)]))
    client.say(command(46, 2)).wait(8.0, [command(0)], every=0.5)
    client.say(command(11, 100)).wait(12.0, [PULSE])
    assert client.robot.velocity[0] == 0.0 and abs(client.robot.true_pose[0] - 0.92) < 0.03
    assert client.sip["flags"] >> 10 & 1


# Gyro, compass, joystick

def fitted(model="p3dx-sh", **sections):
    """Return a robot with other numbers: section=dict(name=value)."""
    numbers = load_numbers()
    changed = {
        section: dataclasses.replace(getattr(numbers, section), **values) for section, values in sections.items()}
    return driving(model, numbers=dataclasses.replace(numbers, **changed))


def turned_by(readings):
    """Return the degrees that the vendor's client gets by adding up readings."""
    return sum(-(reading - 512) * (5 / 1023) * (300 / 2.5) * 1.626 * 0.025 for reading, _ in readings)


def test_a_gyro_for_the_client_sums_to_the_turn_and_drifts_when_faulty():
    client = fitted(gyro=dict(kind=1))
    assert client.config["has_gyro"] == 1
    client.say(command(58, 1)).wait(0.3).say(command(13, 90)).wait(4.0, [PULSE])
    packets = client.of(0x98)
    assert [len(packet["readings"]) for packet in packets[2:]] == [4] * (len(packets) - 2)
    assert turned_by(sum((packet["readings"] for packet in packets), [])) == pytest.approx(90, rel=0.02)
    assert client.heard[-2].id == 0x98 and client.heard[-1].id in SIPS                   # it comes before the SIP
    client.robot.hardware.gyro.drift = math.radians(2.0)
    before = len(packets)
    client.wait(10.0, [PULSE])
    readings = sum((packet["readings"] for packet in client.of(0x98)[before:]), [])
    assert turned_by(readings) == pytest.approx(20, rel=0.02)
    client.say(command(58, 0)).wait(0.3)
    told = len(client.of(0x98))
    assert len(client.wait(0.5).of(0x98)) == told


@pytest.mark.parametrize("mode, standing, turning", [(0, 0.0, 0.0), (1, 0.0, 1.0), (2, 1.0, 1.0)])
def test_a_gyro_in_the_robot_makes_its_heading(mode, standing, turning):
    client = fitted(gyro=dict(kind=2)).say(command(58, mode))
    client.robot.hardware.gyro.drift = math.radians(2.0)

    def error():
        return math.degrees(client.robot.hardware.odometry.pose[2] - client.robot.true_pose[2])
    client.wait(5.0, [PULSE])
    assert error() == pytest.approx(10.0 * standing, abs=0.2)
    before = error()
    client.wait(5.0, [command(21, 20)])
    assert error() - before == pytest.approx(10.0 * turning, abs=0.3)


def test_a_compass():
    client = fitted(compass=dict(fitted=True))
    assert client.sip["compass"] * 2 == 90                                               # east
    client.say(command(13, 45)).wait(3.0, [PULSE])
    values = client.ask(command(45, 2), 0xC0).values
    assert client.sip["compass"] * 2 == pytest.approx(45, abs=1) and values["heading"] == pytest.approx(450, abs=2)
    assert values["error"] == 0
    told = len(client.of(0xC0))
    assert len(client.say(command(45, 3)).wait(1.0).of(0xC0)) == told + 10
    client.say(command(45, 0)).wait(0.3)
    assert client.sip["compass"] == 0 and len(client.wait(0.5).of(0xC0)) <= told + 11
    assert driving().ask(command(45, 2), 0xC0) is None


def test_a_joystick_drives_when_it_may():
    client = driving()
    assert client.ask(command(17, 1), 0xF8).values == {"button1": 0, "button2": 0, "x": 512, "y": 512, "throttle": 512}
    client.robot.hardware.joystick = JoystickState(button_1=True, y=768)
    client.wait(1.0, [PULSE])
    assert client.robot.velocity[0] == 0.0 and client.sip["flags"] >> 9 & 1
    client.say(command(47, 1)).wait(3.0, [PULSE])
    assert client.robot.velocity[0] == pytest.approx(0.375)
    client.robot.hardware.joystick.button_1 = False
    client.wait(2.0, [PULSE])
    assert client.robot.velocity[0] == 0.0


# A laser over the robot's own line, as the vendor's client takes it (laser sheet 2, 3.1 to 3.3)

class ScanTaker:
    """What the vendor's client makes of packets: scans, each with the pose of the SIP before it.

    It reads no angle from a packet: value i lies at first + i * step.
    """

    def __init__(self, first, last, step):
        self.degrees = [first + index * step for index in range(round((last - first) / step) + 1)]
        self.scans = []
        self._sip, self._values = None, []

    def take(self, packet):
        if packet.id in SIPS:
            assert len(self._values) in (0, len(self.degrees)), "a SIP amidst a scan"
            self._sip = packet.values
        elif packet.id in (0x60, 0x61):
            values = packet.values
            assert values["total"] == len(self.degrees) and len(values["readings"]) <= 32
            if values["first"] == 0:
                self._values, self._pose = [], self._sip
            assert values["first"] == len(self._values), "values in order, and none is missing"
            self._values += values["readings"]
            if len(self._values) == len(self.degrees):
                self.scans.append((self._pose, list(self._values)))

    def ahead(self, number):
        """Return the range straight ahead (mm) in a scan."""
        return self.scans[number][1][self.degrees.index(0)][0]


def simulated(tmp_path, world, **options):
    """Return a client that knows from the serial number that its robot is simulated, and has asked for its laser."""
    path = tmp_path / "mine.yaml"
    path.write_text("session: {serial: SIM}\nlaser: {bias: 0, noise: 0}")
    client = Client(world=world, line_laser=True, numbers=load_numbers(str(path)), **options).connect().prepare()
    assert client.config["serial"].upper() == "SIM" and client.names["name"] != "MobileSim"
    return client.say(command(31, 0x0B01)).wait(0.25)


WALL_AHEAD = World("hall", walls=[(6.0, -30.0, 6.0, 30.0)], starts=EMPTY)


@pytest.mark.parametrize("first, last, step, hundredths", [
    (-90, 90, 1, 100), (-90, 90, 0.5, 50), (-50, 50, 1, 100), (-135, 135, 0.5, 50), (-120, 120, 1, 100)])
def test_the_vendors_client_takes_a_simulated_laser(tmp_path, first, last, step, hundredths):
    client = simulated(tmp_path, WALL_AHEAD)
    taker, before, began = ScanTaker(first, last, step), len(client.heard), client.time
    client.robot.receive(command(36, first) + command(37, last) + command(38, hundredths) + command(35, 2))
    while not taker.scans:
        assert client.time - began < 30.0, "the client gives up"
        client.wait(0.1)
        for packet in client.heard[before:]:
            taker.take(packet)
        before = len(client.heard)
    assert client.time - began < 0.35
    client.say(command(4, 1), command(11, 300)).wait(2.4, [PULSE])
    for packet in client.heard[before:]:
        taker.take(packet)
    assert len(taker.scans) in (24, 25)
    for number, (sip, values) in enumerate(taker.scans):
        x = (sip["x"] + 0x4000) % 0x8000 - 0x4000
        assert taker.ahead(number) == pytest.approx(6000 - 21 - x * client.model.dist_mm_per_unit, abs=8)
        assert all(told == 32767 or 0 < told < 20000 for told, _ in values), "more than any client takes, or a wall"
    assert taker.ahead(-1) < taker.ahead(0) - 400, "it drove"
    client.disconnect()
    heard = len(client.heard)
    assert len(client.wait(1.0).heard) == heard, "CLOSE ends the scans, too"


def test_it_takes_plain_scans_as_answer_too_and_its_gripper_works(tmp_path):
    client = simulated(tmp_path, WALL_AHEAD, gripper=True)
    taker, before = ScanTaker(-90, 90, 1), len(client.heard)
    client.robot.receive(command(36, -90) + command(37, 90) + command(38, 100) + command(35, 1))
    client.wait(0.5).say(command(33, 16), command(36, 30)).wait(0.2).say(command(37, 1)).wait(0.5)
    for packet in client.heard[before:]:
        taker.take(packet)
    assert len(taker.scans) in (11, 12, 13) and len(client.of(0xE0)) == 1
    assert client.of(0xE0)[0]["grasp_time"] == 30


def test_a_client_of_the_newer_numbers(tmp_path):
    """230 to 233 with the number of the laser behind the integer, in any order before the step."""
    client = simulated(tmp_path, WALL_AHEAD)
    new = {number: framed(command(number, value)[3:-2] + b"\0")
           for number, value in ((231, -90), (232, 90), (233, 50), (230, 2), (239, 0))}
    taker, before = ScanTaker(-90, 90, 0.5), len(client.heard)
    client.say(new[230], new[232], new[231], PULSE, new[233]).wait(1.0)
    client.say(new[239], framed(b"\xE1"), command(237, 2), command(238, b"hi")).wait(1.0)
    for packet in client.heard[before:]:
        if packet.values.get("total", 361) == 361:
            taker.take(packet)
    assert len(taker.scans) >= 19


def test_a_client_that_takes_the_robot_for_a_real_one_finds_a_real_one():
    """Serial number 0001: it opens a serial port for the laser, and sends no laser command here."""
    client = Client(world=WALL_AHEAD, line_laser=True).connect().prepare()
    assert client.config["serial"] == "0001"
    client.wait(1.0, [PULSE])
    assert client.of(0x60) == client.of(0x61) == []

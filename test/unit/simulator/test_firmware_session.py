"""Synchronising, opening, closing, and what the line may do to all of them."""

import random
import struct

import pytest

from robot_on_bench import Bench

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model, load_table
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import World

SYNC_REPLY = bytes.fromhex("FAFB1C0273696D5F303030310050696F6E65657200703364782D7368002D9A")


def test_sync_is_echoed_and_answered_with_names():
    bench = Bench().sync(0, 1, 2)
    assert bench.raw == bytes.fromhex("FAFB03000000" "FAFB03010001") + SYNC_REPLY
    assert bench.packets[2] == p2os.SyncReply("sim_0001", "Pioneer", "p3dx-sh")


def test_a_robot_that_was_not_opened_says_nothing():
    bench = Bench().sync(0, 1, 2)
    said = len(bench.raw)
    bench.send("PULSE").send("CONFIG").wait(5.0)
    assert len(bench.raw) == said and bench.robot.session is FirmwareState.SYNCED


@pytest.mark.parametrize("numbers, answered", [
    ((1,), ()),
    ((2,), ()),
    ((7,), ()),
    ((0, 2), (0,)),
    ((0, 2, 1), (0,)),
    ((0, 33, 1), (0,)),
    ((0, 0, 1), (0, 0, 1)),
    ((0, 1, 1), (0, 1)),
    ((0, 1, 1, 2), (0, 1)),
    ((0, 1, 0, 1, 2), (0, 1, 0, 1, 2)),
])
def test_out_of_order_starts_again(numbers, answered):
    bench = Bench().sync(*numbers)
    assert tuple(frame.id for frame in p2os.FrameDecoder().feed(bench.raw)) == answered


def test_garbage_before_sync_is_harmless():
    bench = Bench()
    bench.robot.receive(b"WMS2\r" + bytes([0xFA, 0xFB, 0x00, 0xFA, 0xFA]))
    bench.wait(0.3).sync(0, 1, 2)
    assert bench.robot.session is FirmwareState.SYNCED


def test_half_a_packet_is_forgotten_after_a_while():
    bench = Bench()
    bench.robot.receive(bytes.fromhex("FAFB20"))
    bench.sync(0)
    assert bench.raw == b""
    bench.wait(0.15)
    assert bench.raw == bytes.fromhex("FAFB03000000")


@pytest.mark.parametrize("packet", ["FAFB03010001", "FAFB06013B0100023B"])
def test_open_with_and_without_argument(packet):
    bench = Bench().sync(0, 1, 2)
    bench.robot.receive(bytes.fromhex(packet))
    bench.wait(1.0)
    assert len(bench.sips) == 10 and bench.robot.session is FirmwareState.OPEN


@pytest.mark.parametrize("packet", ["FAFB03020002", "FAFB06023B0100033B"])
def test_close_ends_it_and_the_next_client_is_welcome(packet):
    bench = Bench().open().send("SETV", 300).send("VEL", 200).send("ENCODER", 2).wait(1.0)
    bench.robot.receive(bytes.fromhex(packet))
    bench.wait(0.0)
    sips = len(bench.sips)
    bench.wait(3.0)
    assert len(bench.sips) == sips and not bench.robot.motors_enabled
    assert bench.robot.velocity == (0.0, 0.0) and bench.robot.closed_sessions == 1
    bench.open(motors=False).send("CONFIG").wait(1.0)
    assert bench.of(p2os.Config)[-1].translation_velocity_max_mm_s == 750
    assert not bench.sip.flags & p2os.Flags.MOTORS_ENABLED and (bench.sip.x_counts, bench.sip.heading_units) == (0, 0)
    encoders = len(bench.of(p2os.Encoder))
    assert len(bench.wait(0.5).of(p2os.Encoder)) == encoders


def test_close_dislodges_a_robot_that_was_not_opened():
    bench = Bench().sync(0, 1, 2).send("CLOSE").wait(0.1).sync(0)
    assert bench.packets[-1] == p2os.SyncEcho(0)


def test_sync_to_an_open_robot_is_a_pulse():
    bench = Bench().open().wait(0.5)
    before = len(bench.packets)
    bench.sync(0).wait(0.1)
    assert [type(packet) for packet in bench.packets[before:]] == [p2os.Sip]
    bench.sync(1).wait(0.1)
    assert bench.robot.session is FirmwareState.OPEN
    bench.sync(2)
    assert bench.robot.session is FirmwareState.WAITING


def test_reset_says_so_and_waits():
    bench = Bench().open().wait(0.5).send("RESET").wait(0.1)
    assert bench.packets[-1] == p2os.Reset(0xFF, b"") and bench.robot.session is FirmwareState.WAITING


def test_reset_is_like_power_on():
    bench = Bench().open().send("DIGOUT", 0xFF, 0x05).send("BATTEST", 120).send("MOVE", 100)
    bench.wait(2.0, alive=True).send("RESET").wait(0.1)
    where = bench.robot.true_pose
    bench.open().send("ENCODER", 1).wait(0.2)
    assert bench.of(p2os.Encoder)[-1] == p2os.Encoder(0, 0)
    assert (bench.sip.digital_out, bench.sip.battery_dv) == (0, 130)
    assert bench.robot.true_pose == where and where[0] == pytest.approx(0.1)


def test_unknown_and_senseless_commands_are_counted_and_ignored():
    bench = Bench().open()
    frames = (200, b""), (11, b""), (11, b"\x2B\x02hi"), (255, b"")
    bench.robot.receive(b"".join(p2os.encode_frame(number, data) for number, data in frames))
    bench.wait(0.2)
    counts = bench.robot.command_counts
    assert (counts["unknown"], counts["senseless"]) == (2, 2) and bench.robot.velocity == (0.0, 0.0)


def test_noise_on_the_line_is_counted_and_the_robot_still_drives():
    bench = Bench().open()
    damaged, noise = bytes.fromhex("FAFB060B3BC800D33A"), bytes.fromhex("00FA12FA")
    bench.robot.receive(damaged + noise + p2os.encode_command("VEL", 200))
    bench.wait(1.0)
    assert bench.sip.left_velocity_units == 200
    assert bench.robot.decoder.counts.bad_checksums == 1 and bench.robot.decoder.counts.discarded_bytes > 0


def test_it_obeys_the_good_half_of_what_comes():
    draw = random.Random(4)
    bench = Bench().open()
    for count in range(300):
        packet = bytearray(p2os.encode_command("VEL", 100 + count % 2))
        packet[draw.randrange(3, len(packet))] ^= 1 << draw.randrange(8)
        bench.robot.receive(bytes(packet))
        bench.send("VEL", 200).wait(0.05)
    assert bench.robot.velocity[0] == 0.2
    assert bench.robot.command_counts["obeyed"] == 301 and bench.robot.decoder.counts.bad_checksums >= 300


def test_config_tells_what_is_fitted_and_allowed():
    config = Bench(name="ada", rear_sonar=False).open().send("CONFIG").wait(0.0).of(p2os.Config)[0]
    assert (config.type, config.subtype, config.name) == ("Pioneer", "p3dx-sh", "ada")
    assert config.serial.upper() != "SIM"
    assert (config.has_gripper, config.front_sonar, config.rear_sonar) == (1, 1, 0)
    assert (config.rotation_velocity_top_deg_s, config.translation_velocity_top_mm_s) == (360, 1500)
    assert (config.rotation_acceleration_top_deg_s2, config.translation_acceleration_top_mm_s2) == (300, 2000)
    assert (config.rotation_velocity_max_deg_s, config.translation_velocity_max_mm_s) == (100, 750)
    assert (config.watchdog_ms, config.sip_cycle_ms, config.sonar_cycle_ms) == (2000, 100, 40)
    assert (config.low_battery_dv, config.shutdown_dv, config.firmware_version) == (115, 110, "2.9")


@pytest.mark.parametrize("model, rear, told", [
    ("peoplebot-sh", True, (1, 1)),
    ("peoplebot-sh", False, (1, 0)),
    ("amigo-sh", True, (1, 0)),
])
def test_config_tells_front_from_rear_by_where_the_arrays_look(model, rear, told):
    config = Bench(model, rear_sonar=rear).open().send("CONFIG").wait(0.0).of(p2os.Config)[0]
    assert (config.front_sonar, config.rear_sonar) == told


@pytest.mark.parametrize("model, last, missing", [
    ("p2at", "translation_ki", "front_bumpers"),
    ("p3dx", "has_gyro", "drift_factor"),
    ("amigo-sh", "firmware_version", "gyro_cw"),
    ("p3at-sh", "charge_threshold", "power_board_port"),
])
def test_config_ends_where_the_firmware_family_ends_it(model, last, missing):
    config = Bench(model).open().send("CONFIG").wait(0.0).of(p2os.Config)[0]
    assert getattr(config, last) is not None and getattr(config, missing) is None


@pytest.mark.parametrize("model, over", [
    ("p2at", 27), ("p3dx", 27), ("amigo", 27), ("amigo-sh", 30), ("p3dx-sh", 34), ("peoplebot-sh", 34),
])
def test_sips_end_where_the_firmware_family_ends_them(model, over):
    bench = Bench(model).open().wait(1.0)
    for frame, sip in zip(p2os.FrameDecoder().feed(bench.raw)[-10:], bench.sips[-10:]):
        assert len(frame.data) + 3 == over + 3 * len(sip.sonar)


@pytest.mark.parametrize("model, first, second", [("p2at", 5, 0), ("p3dx-sh", 0x11, 5), ("p3dx", 0, 5)])
def test_order_of_gripper_and_port(model, first, second):
    bench = Bench(model).open().wait(0.1)
    frame = p2os.FrameDecoder().feed(bench.raw)[-1]
    after_sonar = 19 + 3 * frame.data[18]
    assert (frame.data[after_sonar], frame.data[after_sonar + 1]) == (first, second)


def test_a_sip_byte_by_byte():
    """The bytes are decoded with struct alone. This test and the codec share nothing."""
    bench = Bench("p3dx-sh", World("wall", walls=[(2.0, -9.0, 2.0, 9.0)])).open()
    bench.send("VEL", 200).send("RVEL", -20).wait(2.0)
    frame = p2os.FrameDecoder().feed(bench.raw)[-1]
    head = struct.unpack_from("<HHhhhBBBhHBB", frame.data)
    x, y, heading, left, right, battery, low, high, control, flags, compass, n = head
    assert frame.id == 0x33
    robot_x, robot_y, robot_heading = bench.robot.true_pose
    assert (x, y) == (round(robot_x * 1000), round(robot_y * 1000) & 0x7FFF) and y > 30000
    assert heading == round(robot_heading / 6.283185307179586 * 4096) and -2048 <= heading < 0
    assert (left + right) / 2 == 200
    assert (right - left) / 2 * 0.0056 * 57.29578 == pytest.approx(-20, abs=0.4)
    assert (battery, low, high, flags, compass) == (130, 0, 0, 0b111, 0)
    assert n == len(bench.sip.sonar) and n in (4, 6)
    tail = frame.data[18 + 1 + 3 * n:]
    assert struct.unpack("<BBBBBHBhH", tail) == (0x11, 5, 0, 0xF0, 0, 130, 0, -200, 0)


@pytest.mark.parametrize("name", sorted(load_table().models))
def test_every_model_opens_and_streams(name):
    bench = Bench(name).open().send("CONFIG").send("VEL", 100).wait(1.0)
    told = [config.subtype for config in bench.of(p2os.Config)]
    assert len(bench.sips) == 10
    assert told == ([] if bench.model.firmware_family == "PSOS" else [name])     # PSOS knows no CONFIGpac
    assert bench.sip.left_velocity_units == pytest.approx(100 / find_model(name).vel_mm_s_per_unit, abs=0.6)


@pytest.mark.parametrize("name", sorted(load_table().models))
def test_every_model_at_its_fastest_fits_the_wire(name):
    bench = Bench(name).open().send("SETV", 9999).send("SETRV", 9999).send("SETA", 9999).send("SETRA", 9999)
    bench.send("VEL", 9999).send("RVEL", -9999).wait(1.9)
    linear, angular = bench.robot.hardware.drives.linear, bench.robot.hardware.drives.angular
    assert (linear.speed, angular.speed) == (linear.limits.top, -angular.limits.top)
    difference = angular.limits.top / bench.model.diff_rad_per_mm
    left_mm_s = linear.limits.top * 1000 + difference
    assert bench.sip.left_velocity_units == round(left_mm_s / bench.model.vel_mm_s_per_unit)


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="amigo-sh cannot carry a gripper"):
        Firmware(find_model("amigo-sh"), World("x"), gripper=True)
    with pytest.raises(ParameterError, match="would stand in a wall"):
        Firmware(find_model("p3dx-sh"), World("x", walls=[(0.3, -1, 0.3, 1)]))
    with pytest.raises(ParameterError, match="noise"):
        Firmware(find_model("amigo-sh"), World("x"), noise=-0.1)


# -- the same bytes at the same times: the same answer

def play(split, seed=3, noise=0.01, commands=120):
    """Return everything that the robot sent. It gets random commands at fixed times. `split` says how the time between
    them is cut.
    """
    draw = random.Random(11)
    box = World("box", walls=[(-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2)])
    bench = Bench(world=box, noise=noise, seed=seed).open()
    for _ in range(commands):
        name, value = draw.choice([
            ("VEL", 300), ("VEL", -250), ("RVEL", 60), ("RVEL", -45), ("STOP", None), ("DHEAD", 90),
            ("GRIPPER", 2), ("GRIPPER", 5)])
        bench.send(name, *([] if value is None else [value]))
        left_us = draw.randrange(1000, 400000)
        while left_us > 0:
            part_us = min(left_us, split(left_us))
            bench.wait(part_us * 1e-6)
            left_us -= part_us
    return bench.raw, bench.robot.true_pose


def test_the_split_of_time_changes_nothing():
    whole = play(lambda left: left)
    cut = random.Random(2)
    assert play(lambda left: 7001) == whole
    assert play(lambda left: cut.randrange(1, 50000)) == whole


def test_a_seed_gives_the_same_run_and_another_seed_another_one():
    assert play(lambda left: left, commands=20) == play(lambda left: left, commands=20)
    assert play(lambda left: left, commands=20)[0] != play(lambda left: left, commands=20, seed=4)[0]


def test_fractions_of_microseconds_add_up():
    bench = Bench().open()
    for _ in range(300):
        bench.wait(1 / 30)
    assert bench.robot.clock.now_us == 10 * 10 ** 6 and len(bench.sips) == 100


# -- fuzz

def test_random_bytes_never_upset_it():
    draw = random.Random(1)
    bench = Bench().open()
    for _ in range(400):
        bench.robot.receive(bytes(draw.randrange(256) for _ in range(draw.randrange(60))))
        bench.wait(draw.choice([0.0, 0.01, 0.13]))
    assert bench.robot.decoder.counts.discarded_bytes > 0


def test_random_commands_never_upset_it():
    draw = random.Random(2)
    world = World("box", walls=[(-3, -3, 3, -3), (3, -3, 3, 3), (3, 3, -3, 3), (-3, 3, -3, -3)])
    bench = Bench(world=world).open()
    for _ in range(3000):
        number, kind = draw.randrange(256), draw.choice(b"\x3B\x1B\x2B")
        if number in (2, 253):  # it would be over
            continue
        value = draw.choice([0, 1, 2, 100, draw.randrange(65536)])
        data = draw.choice([b"", bytes([kind]), bytes([kind]) + struct.pack("<H", value), bytes([kind, 3, 1, 2, 3])])
        bench.robot.receive(p2os.encode_frame(number, data))
        bench.wait(draw.choice([0.0, 0.003, 0.03]))
    assert bench.robot.session is FirmwareState.OPEN
    assert not bench.robot.hardware.body.touches(bench.model.outline(True))

"""The laser over the robot's own line: what is meant for it, what it sends, and what it leaves as it is."""

import math

import numpy as np
import pytest

from laser_on_bench import ROOM, to_wall
from robot_on_bench import Bench
from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.firmware.laser_orders import FieldOfView, LaserOrders
from pioneer_control.simulator.firmware.line_laser import LineLaser
from pioneer_control.simulator.hardware import load_numbers
from pioneer_control.simulator.line import LineSimulation
from pioneer_control.simulator.simulation import Simulation, simulate
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.materials import Material
from pioneer_control.simulator.world.world import Walk

START = "FAFB0624 1B5A007E1B FAFB0625 3B5A007F3B FAFB0626 3B64008A3B FAFB0623 3B0200253B"
"""The vendor's client: 36 -90, 37 90, 38 100, 35 2."""
PLAIN_START = START.replace("3B0200253B", "3B0100243B")
CENTRE = (-0.021, 0.0, 0.0)
"""Where a p3dx-sh stands when its laser is at the origin of `ROOM`."""


def numbers(tmp_path, text="laser: {bias: 0, noise: 0, spot: 0, spot_growth: 0, rays: 1, dazzle_share: 0}"):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return load_numbers(str(path))


@pytest.fixture
def bench(tmp_path):
    return Bench(world=ROOM, pose=CENTRE, line_laser=True, numbers=numbers(tmp_path), gripper=True).open()


def say(bench, text, seconds=0.1):
    """Send bytes, and return the packets that come."""
    before = len(bench.packets)
    bench.robot.receive(bytes.fromhex(text))
    bench.wait(seconds)
    return bench.packets[before:]


def scan_of(packets):
    """Return the one scan in packets with all its values in order, as the vendor's client takes it."""
    found = [each for each in packets if isinstance(each, (p2os.SimulatedLaser, p2os.SimulatedLaserExtended))]
    values = []
    for each in found:
        assert each.first == len(values) and each.total == found[0].total
        values += each.ranges_mm if isinstance(each, p2os.SimulatedLaser) else each.readings
    assert len(values) == found[0].total
    return values


# -- what is sent

def test_one_scan_comes_right_behind_every_sip(bench):
    packets = say(bench, START, 1.0)
    kinds = [type(each) for each in packets]
    assert kinds == ([p2os.Sip] + [p2os.SimulatedLaserExtended] * 6) * 10
    for at in range(0, 70, 7):
        found = scan_of(packets[at:at + 7])
        assert [len(each.readings) for each in packets[at + 1:at + 7]] == [32] * 5 + [21]
        wanted = [round(1000.0 * to_wall(math.radians(deg))) for deg in range(-90, 91)]
        assert [each.range_mm for each in found] == pytest.approx(wanted, abs=1)
        assert {(each.reflectance, each.reserved) for each in found} == {(0, 0)}


def test_sizes_of_the_packets(bench):
    say(bench, START, 0.02)
    sizes = [each[2] + 3 for each in frames(bench.robot, 0.1)][1:]
    assert sizes == [173] * 5 + [118]
    say(bench, PLAIN_START, 0.02)
    sizes = [each[2] + 3 for each in frames(bench.robot, 0.1)][1:]
    assert sizes == [81] * 5 + [59]


def frames(robot, seconds):
    data, found = robot.advance(seconds), []
    while data:
        found.append(data[:data[2] + 3])
        data = data[data[2] + 3:]
    return found


def test_plain_scans_have_the_pose_of_the_odometry(bench):
    bench.robot.hardware.odometry.carry((-0.021, 0.0, 0.0))
    packets = say(bench, PLAIN_START, 0.1)
    assert {(each.x, each.y, each.heading) for each in packets[1:]} == {(0, 0, 0)}
    assert scan_of(packets)[90] == 4000
    bench.robot.hardware.odometry.add(40.0, math.radians(190.0))
    packets = [each for each in say(bench, "FAFB03000000", 0.1) if isinstance(each, p2os.SimulatedLaser)]
    assert packets[0].heading == -170 and -32768 <= packets[0].x < 32768


def test_no_echo_and_too_far_are_more_than_any_client_takes(tmp_path):
    for far, told in ((32.0, 32000), (33.0, 32767), (70.0, 32767), (90.0, 32767)):
        world = World("hall", walls=[(far, -9.0, far, 9.0)], materials=[Material.REFLECTOR])
        bench = Bench(world=world, pose=CENTRE, line_laser=True, numbers=numbers(tmp_path)).open()
        scan = scan_of(say(bench, START))
        assert scan[90].range_mm == told and scan[0].range_mm == 32767
        assert scan[90].reflectance == (32 if far < 80.0 else 0) and scan[0].reflectance == 0


def test_people_and_robots_are_seen_and_the_robot_itself_is_not():
    world = World("floor", starts=[(0, 0, 0), (3, 0, 0)], walks=[Walk(path=((0.0, 5.0), (0.0, 6.0)), blind=True)])
    simulation = Simulation(world)
    first, _ = (simulation.add(find_model("p3dx-sh"), line_laser=True) for _ in range(2))
    first.receive(b"".join(map(p2os.encode_frame, (0, 1, 2, 1))) + bytes.fromhex(START))
    packets = [p2os.decode_packet(each) for each in p2os.FrameDecoder().feed(simulation.advance(0.1)[0])]
    scan = scan_of(packets)
    assert scan[90].range_mm == pytest.approx(2680, abs=40) and scan[180].range_mm == pytest.approx(4750, abs=100)
    assert sum(each.range_mm < 2000 for each in scan) == 0


def test_a_laser_upside_down_gives_the_usual_order(tmp_path):
    model = find_model("patrolbot-sh")
    assert model.laser.upside_down
    bench = Bench("patrolbot-sh", ROOM, (-model.laser.x, 0.0, 0.0), line_laser=True, numbers=numbers(tmp_path)).open()
    scan = scan_of(say(bench, START))
    assert (scan[0].range_mm, scan[180].range_mm) == (3000, 5000), "right, then left"


def test_the_scan_is_of_the_moment_of_its_sip(tmp_path):
    """While it drives, the last ray is of the moment of the SIP; without skew all are."""
    wall = World("wall", walls=[(4.0, -50.0, 4.0, 50.0)])
    for skew in ("true", "false"):
        text = ("laser: {bias: 0, noise: 0, spot: 0, spot_growth: 0, rays: 1, skew: %s,"
                " needed_reflectivity: [[0, 0], [1, 0]]}")
        bench = Bench(world=wall, pose=CENTRE, line_laser=True, numbers=numbers(tmp_path, text % skew)).open()
        bench.send("VEL", 500).wait(2.0)
        say(bench, START, 0.1)
        sent = frames(bench.robot, 0.1)
        scan = scan_of([p2os.decode_packet(p2os.FrameDecoder().feed(each)[0]) for each in sent])
        x, speed = bench.robot.true_pose[0] + 0.021, bench.robot.velocity[0]
        assert speed == pytest.approx(0.5)
        for at in (60, 90, 120):
            ago = (180 - at) / 360.0 * 40.0 / 3000.0 if skew == "true" else 0.0
            wanted = (4.0 - x + speed * ago) / math.cos(math.radians(at - 90.0))
            assert scan[at].range_mm == pytest.approx(1000.0 * wanted, abs=0.6)


def test_who_was_carried_says_so_once(bench):
    assert [each.flags for each in say(bench, START, 0.1)[1:]] == [0] * 6
    bench.robot.hardware.carry((0.5, 0.0, 1.0))
    assert [each.flags for each in say(bench, "FAFB03000000", 0.1)[1:]] == [1] + [0] * 5
    assert [each.flags for each in say(bench, "FAFB03000000", 0.1)[1:]] == [0] * 6


def test_seeds(tmp_path):
    def scan(seed):
        return scan_of(say(Bench(world=ROOM, pose=CENTRE, line_laser=True, seed=seed).open(), START))
    assert scan(1) == scan(1) != scan(2)
    spread = np.std([each.range_mm for each in scan(1)[85:96]])
    assert 1.0 < spread < 15.0


# -- which rays

@pytest.mark.parametrize("first, last, step, count", [
    (-90, 90, 100, 181), (-90, 90, 50, 361), (-50, 50, 25, 401), (-135, 135, 50, 541), (-120, 120, 100, 241),
    (0, 0, 100, 1), (-180, 180, 25, 1441), (-90, 90, 700, 26), (90, 270, 100, 181)])
def test_fields_of_view(bench, first, last, step, count):
    for name, value in (("SIM_LRF_SET_FOV_START", first), ("SIM_LRF_SET_FOV_END", last), ("SIM_LRF_SET_RES", step),
                        ("SIM_LRF_ENABLE", 2)):
        bench.robot.receive(p2os.encode_simulator_command(name, value, 0))
    scan = scan_of(bench.wait(0.1).packets)
    assert len(scan) == count
    for at in (0, count // 2, count - 1):
        angle = math.radians(first + at * step / 100.0)
        assert scan[at].range_mm == pytest.approx(1000.0 * to_wall(angle), abs=1)


@pytest.mark.parametrize("first, last, step", [
    (90, -90, 100), (-90, 90, 0), (-90, 90, -100), (-200, 200, 100), (-180, 180, 20), (-32767, 32767, 1),
    (-400, -300, 100)])
def test_angles_that_make_no_sense_leave_those_before(bench, first, last, step):
    for name, value in (("SIM_LRF_SET_FOV_START", first), ("SIM_LRF_SET_FOV_END", last), ("SIM_LRF_SET_RES", step),
                        ("SIM_LRF_ENABLE", 1)):
        bench.robot.receive(p2os.encode_simulator_command(name, value))
    assert len(scan_of(bench.wait(0.1).packets)) == 181


def test_angles_count_when_the_step_comes(bench):
    say(bench, START)
    bench.robot.receive(p2os.encode_simulator_command("SIM_LRF_SET_FOV_START", 0, 0))
    assert len(scan_of(say(bench, "FAFB03000000"))) == 181
    bench.robot.receive(p2os.encode_simulator_command("SIM_LRF_SET_RES", 100, 0))
    assert len(scan_of(say(bench, "FAFB03000000"))) == 91


def test_off_and_on_and_the_end_of_a_session(bench):
    assert len(say(bench, START)) == 7
    assert [type(each) for each in say(bench, "FAFB0623 3B0000233B")] == [p2os.Sip], "35 0"
    bench.robot.receive(p2os.encode_simulator_command("SIM_LRF_ENABLE", 1))
    assert type(say(bench, "FAFB03000000")[1]) is p2os.SimulatedLaser
    for wrong in (3, -1, 256):
        bench.robot.receive(p2os.encode_simulator_command("SIM_LRF_ENABLE", wrong))
    assert type(say(bench, "FAFB03000000")[1]) is p2os.SimulatedLaser
    bench.robot.receive(p2os.encode_simulator_command("SIM_LRF_ENABLE", 0, 7))
    assert len(say(bench, "FAFB03000000")) == 1
    say(bench, START)
    bench.send("CLOSE")
    bench.wait(0.2)
    bench.packets.clear()
    assert {type(each) for each in bench.open().wait(0.5).packets} == {p2os.SyncEcho, p2os.SyncReply, p2os.Sip}


# -- the numbers of other commands

def orders_of(*commands):
    """Return which of some commands the laser takes, and its orders at the end."""
    orders, taken, previous = LaserOrders(), [], None
    for data in commands:
        frame = p2os.FrameDecoder().feed(data)[0]
        taken.append(orders.takes(frame, previous))
        previous = p2os.decode_command(frame)
    return taken, orders


def pioneer(name, *values):
    return p2os.encode_command(name, *values)


def laser(name, *values):
    return p2os.encode_simulator_command("OLD_LASER_" + name, *values)


BURST = [laser("FIRST", -50), laser("LAST", 50), laser("STEP", 50), laser("ENABLE", 1)]


def test_the_burst_of_the_vendors_client():
    taken, orders = orders_of(*BURST)
    assert taken == [True] * 4 and (orders.view, orders.scans) == (FieldOfView(-50, 50, 50), 1)


@pytest.mark.parametrize("commands, taken", [
    ([pioneer("GRIPPER", 16), pioneer("GRIPPERVAL", 50)], [False, False]),
    ([pioneer("GRIPPER", 17), pioneer("GRIPPERVAL", -50)], [False, False]),
    ([pioneer("GRIPPER", 17), pioneer("GRIPPERVAL", -50), pioneer("GRIPREQUEST", 2)], [False] * 3),
    ([pioneer("GRIPPER", 1), *BURST], [False] + [True] * 4),
    ([pioneer("GRIPREQUEST", 1)], [False]), ([pioneer("GYROCALCW", 700)], [False]), ([pioneer("ADSEL", 2)], [False]),
    ([pioneer("ADSEL", 0)], [False]), ([BURST[0], pioneer("PULSE"), BURST[1]], [True, False, True]),
    ([BURST[0], BURST[2]], [True, False]), ([*BURST[:3], pioneer("ADSEL", 4)], [True] * 3 + [False]),
    ([*BURST, pioneer("ADSEL", 2)], [True] * 4 + [False]),
    ([*BURST, pioneer("PULSE"), laser("ENABLE", 0)], [True] * 4 + [False, True]),
    ([*BURST[:3], laser("ENABLE", 0), laser("ENABLE", 0)], [True] * 4 + [False]),
    ([*BURST[:2], pioneer("PULSE"), pioneer("VEL", 100), *BURST[2:]], [True, True, False, False, True, True]),
    ([BURST[0], p2os.encode_frame(37), *BURST[1:]], [True, False, False, False, False]),
    ([BURST[0], pioneer("GRIPPER", 17), pioneer("GRIPPERVAL", -50), pioneer("GRIPREQUEST", 1)],
     [True, False, False, False]),
    ([p2os.encode_frame(36)], [False]), ([pioneer("VEL", 100)], [False]),
    ([p2os.encode_simulator_command("SIM_RESET"), p2os.encode_simulator_command("SIM_EXIT", 0)], [False] * 2),
])
def test_what_is_meant_for_the_laser(commands, taken):
    assert orders_of(*commands)[0] == taken


def test_a_gripper_works_beside_the_laser(bench):
    say(bench, START)
    gripper = bench.robot.gripper
    bench.send("GRIPPER", 16).send("GRIPPERVAL", 30)
    assert gripper.grasp_time == pytest.approx(0.6)
    bench.send("GRIPPER", 17).send("GRIPPERVAL", -50)
    assert gripper.lift.goal < gripper.lift.height, "down"
    assert p2os.Gripper in {type(each) for each in say(bench, pioneer("GRIPREQUEST", 1).hex())}
    bench.send("ADSEL", 3).send("GYROCALCW", 700)
    assert bench.robot.hardware.ports.analog_port == 3 and bench.robot.settings["gyro_cw"] == 700
    assert len(scan_of(say(bench, "FAFB03000000"))) == 181


def test_other_orders_of_simulators_do_no_harm(bench):
    say(bench, START)
    before = bench.robot.true_pose
    for name, values in (("SIM_SET_POSE", (1000, 0, 90)), ("SIM_RESET", ()), ("SIM_CTRL", (1, b"my.map")),
                         ("SIM_STAT", (2,)), ("SIM_MESSAGE", (b"hi",)), ("SIM_EXIT", (0,))):
        bench.robot.receive(p2os.encode_simulator_command(name, *values))
    packets = say(bench, "FAFB03000000")
    assert [type(each) for each in packets] == [p2os.Sip] + [p2os.SimulatedLaserExtended] * 6
    assert bench.robot.true_pose == before


# -- only when the user asks for it

def test_without_it_the_robot_is_what_it_was(tmp_path):
    """Byte for byte, whatever a client says."""
    said = []
    for kind in ({}, {"line_laser": True}):
        bench = Bench(world=ROOM, pose=CENTRE, gripper=True, **kind).open()
        bench.send("CONFIG").send("GRIPREQUEST", 2).send("ADSEL", 1).wait(1.0)
        said.append(bench.raw)
    assert said[0] == said[1], "a laser that nobody asks for is silent, and announces nothing"
    bench = Bench(world=ROOM, pose=CENTRE, gripper=True).open()
    assert {type(each) for each in say(bench, START, 0.5)} == {p2os.Sip, p2os.Gripper}
    for name in ("SIM_LRF_SET_FOV_START", "SIM_LRF_SET_RES", "SIM_LRF_ENABLE"):
        bench.robot.receive(p2os.encode_simulator_command(name, 1, 0))
    assert bench.robot.unknown_commands == {"COMMAND_230", "COMMAND_231", "COMMAND_233"}


def test_the_serial_number_of_a_simulator():
    simulation = simulate(World("hall"), find_model("p3dx-sh"), 1, None, 0, serial="SIM", line_laser=True)
    robot = simulation.robots[0]
    robot.receive(b"".join(map(p2os.encode_frame, (0, 1, 2, 1))) + p2os.encode_command("CONFIG"))
    [config] = [packet for packet in map(p2os.decode_packet, p2os.FrameDecoder().feed(simulation.advance(0.1)[0]))
                if isinstance(packet, p2os.Config)]
    assert (config.serial, config.name) == ("SIM", "sim_0001")


@pytest.mark.parametrize("serial", ["SIM", "sim", "Sim"])
def test_who_says_he_is_a_simulator_needs_the_laser(serial):
    with pytest.raises(ParameterError, match="serial number %s, clients take a laser .* add that laser" % serial):
        simulate(World("hall"), find_model("p3dx-sh"), 1, None, 0, serial=serial)


def test_who_has_the_name_of_a_simulator_needs_the_laser_too():
    """The vendor's client knows a simulator by its name, too (laser sheet 3.1)."""
    with pytest.raises(ParameterError, match="name MobileSim, clients take a laser .* add that laser .* another name"):
        simulate(World("hall"), find_model("p3dx-sh"), 1, "MobileSim", 0)
    assert simulate(World("hall"), find_model("p3dx-sh"), 1, "MobileSim", 0, line_laser=True).robots[0].line_laser
    assert simulate(World("hall"), find_model("p3dx-sh"), 1, "mobile", 0).robots[0].line_laser is None


# -- over a serial line

def on_a_line(baud, start, seconds=4.0):
    """Return the packets that come over a serial line, their times, and what was said."""
    said = []
    robot = Firmware(find_model("p3dx-sh"), ROOM, CENTRE, line_laser=True)
    lines = LineSimulation(robot, say=lambda time, sentence: said.append(sentence))
    robot.baud = baud
    decoder, packets = p2os.FrameDecoder(), []
    for data in [*map(p2os.encode_frame, (0, 1, 2, 1)), bytes.fromhex(start)]:
        lines.send(0, data, baud)
        for arrival in lines.advance(0.05):
            decoder.feed(arrival.data)
    for arrival in lines.advance(seconds):
        packets += [(arrival.time_us, p2os.decode_packet(frame)) for frame in decoder.feed(arrival.data)]
    assert decoder.counts.discarded_bytes == 0
    return packets, said


@pytest.mark.parametrize("baud, start, rate", [
    (115200, START, 10.0), (57600, PLAIN_START, 10.0), (57600, START, 5.0), (38400, PLAIN_START, 5.0),
    (38400, START, 2.0), (19200, PLAIN_START, 10 / 6), (19200, START, 0.0), (9600, PLAIN_START, 0.0)])
def test_scans_never_displace_a_sip_and_are_never_cut(baud, start, rate):
    packets, said = on_a_line(baud, start)
    sips = [time for time, packet in packets if isinstance(packet, p2os.Sip)]
    assert len(sips) in (39, 40) and np.diff(sips) == pytest.approx(100000, abs=30000)
    scans = [packet for _, packet in packets if not isinstance(packet, (p2os.Sip, p2os.SyncReply, p2os.SyncEcho))]
    begins = [at for at, packet in enumerate(scans) if packet.first == 0] + [len(scans)]
    assert len(begins) - 1 == pytest.approx(4.0 * rate, abs=1.1)
    for begin, end in zip(begins[:-2], begins[1:]):
        scan_of(scans[begin:end])
    assert len(said) == (0 if rate else 1)
    if not rate:
        assert "robot 1: at %d baud there is no time for scans of its laser beside the SIPs" % baud in said[0]


def test_half_a_scan_does_not_outlive_its_session():
    robot = Firmware(find_model("p3dx-sh"), ROOM, CENTRE, line_laser=True)
    lines = LineSimulation(robot)
    robot.baud = 38400
    for data in [*map(p2os.encode_frame, (0, 1, 2, 1)), bytes.fromhex(START)]:
        lines.send(0, data, 38400)
        lines.advance(0.05)
    lines.advance(0.15)
    assert lines.links[0].scan
    lines.send(0, p2os.encode_command("CLOSE"), 38400)
    lines.advance(0.2)
    assert not lines.links[0].scan and lines.advance(1.0) == []


def test_the_laser_knows_where_it_sits():
    robot = Firmware(find_model("p3at-sh"), World("hall"), line_laser=True)
    assert isinstance(robot.line_laser, LineLaser)
    assert robot.line_laser._pose_at(0.0) == (0.125, 0.0, 0.0)

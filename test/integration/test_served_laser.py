"""The line of a laser and the served simulated laser, joined in real time, over TCP and over a pseudo-terminal."""

import contextlib
import math
import os
import socket
import threading

import pytest
import serial

from pioneer_control import lms2xx, p2os
from pioneer_control.errors import ParameterError, PortError
from pioneer_control.laser import line as line_file
from pioneer_control.laser import session as session_file
from pioneer_control.laser.conversion import numbers_of
from pioneer_control.laser.line import LaserLine, PortDown
from pioneer_control.laser.session import LaserLost, Measuring, ScanHeard
from pioneer_control.laser.settings import LaserSettings
from pioneer_control.robots import find_model
from pioneer_control.simulator import Simulation, load_world, simulate
from pioneer_control.simulator.line import LaserPorts, Server, fault_of
from pioneer_control.simulator.lms200 import PERFECT, FirmwareNumbers
from pioneer_control.simulator.world.materials import Material

from client_lines import SpoiltLine
from real_time import LIMIT, until

QUICK = FirmwareNumbers(boot=0.1)
DROPS_AFTER = 0.1
"""Seconds without a byte after which the vendor's client drops a telegram that is not whole. Laser sheet 1.2."""


@pytest.fixture(autouse=True)
def no_long_waits(monkeypatch):
    """A port is opened again, and a laser looked for again, after a moment."""
    monkeypatch.setattr(line_file, "BACK_OFF", 0.1)
    monkeypatch.setattr(session_file, "BACK_OFF", 0.1)


class Listener:
    """A LaserLine that runs in a thread, and what it has told."""

    def __init__(self, url, **settings):
        self.events = []
        self.line = LaserLine(url, LaserSettings(**settings), self.events.append)
        self._thread = threading.Thread(target=self.line.run, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.end()

    def end(self):
        self.line.end()
        assert self.line.ended.wait(LIMIT)
        self._thread.join(LIMIT)

    def told(self, kind):
        return [event for event in list(self.events) if isinstance(event, kind)]

    def wait_for(self, kind, count=1):
        until(lambda: len(self.told(kind)) >= count, "%d of %s" % (count, kind.__name__))
        return self.told(kind)[count - 1]


def served(world="tutorial", model="p3dx-sh", robots=1, start=None, pty=None, faults=(), **options):
    """Return a server of robots with lasers."""
    world = load_world(world)
    world = world if start is None else world.with_start(start)
    simulation = simulate(world, find_model(model), robots, None, 0)
    options.setdefault("tcp", 0)
    return Server(simulation, faults=faults, lasers=LaserPorts(pty=pty, optics=PERFECT, numbers=QUICK), **options)


def test_over_tcp_it_measures_the_room_from_where_the_laser_sits():
    with served(start=(2.0, 1.5, math.pi / 2.0)) as server, Listener(server.lasers[0].place, angle_deg=180,
                                                                     step_hundredths=100) as listener:
        heard = listener.wait_for(ScanHeard)
        numbers = numbers_of(heard)
        assert heard.info.baud == 500000 and numbers.range_max == pytest.approx(8.183)
        # The room begins at x = 0. The laser looks along y, 21 mm before the middle of the robot: left is the wall.
        assert numbers.ranges[180] == pytest.approx(2.0, abs=0.002)
        angle = numbers.angle_min + 170 * numbers.angle_increment
        assert numbers.ranges[170] == pytest.approx(2.0 / math.sin(angle), abs=0.002)
        laser = server.lasers[0].laser
        listener.end()
        until(lambda: laser.device.operation.mode == lms2xx.Mode.ON_REQUEST, "it was told to stop")


def test_a_laser_upside_down_sees_the_same_room():
    scans = []
    for model, inverted in (("p3dx-sh", False), ("patrolbot-sh", True)):
        with served(model=model, start=(3.0, 2.0, 0.4)) as server, Listener(
                server.lasers[0].place, step_hundredths=50) as listener:
            scans.append(numbers_of(listener.wait_for(ScanHeard), inverted))
    near = [(one, other) for one, other in zip(scans[0].ranges.tolist(), scans[1].ranges.tolist()) if one < 3.0]
    assert len(near) > 50
    # One sits 16 mm before the other.
    assert sorted(abs(one - other) for one, other in near)[len(near) // 2] < 0.02


def test_over_a_pseudo_terminal_with_its_speeds(tmp_path):
    link = str(tmp_path / "laser")
    with served(pty=link) as server:
        laser = server.lasers[0].laser
        with Listener(link, baud=38400) as listener:
            heard = listener.wait_for(ScanHeard, 3)
            assert (heard.info.found_baud, heard.info.baud, laser.baud) == (9600, 38400, 38400)
            times = [scan.first_ray for scan in listener.told(ScanHeard)]
            assert all(later > earlier for earlier, later in zip(times, times[1:]))
        until(lambda: laser.baud == 9600, "it has its old speed")
        with Listener(link, baud=500000) as listener:
            assert listener.wait_for(ScanHeard, 20).info.baud == 500000
            assert listener.line.session.counts.line.wrong_crcs == 0
        until(lambda: laser.baud == 9600, "it has its old speed")
    assert not os.path.lexists(link)


def test_the_robots_own_line_is_as_it_was():
    """The robot on its own port, and the laser on another."""
    with served(robots=2) as server:
        places = [berth.url for berth in server.berths] + [laser.place for laser in server.lasers]
        assert len(set(places)) == 4
        with Listener(places[2]) as first, Listener(places[3]) as second:
            first.wait_for(ScanHeard)
            second.wait_for(ScanHeard)
            assert all(robot.open_session is None for robot in server.simulation.robots)


def test_a_robot_whose_laser_is_on_may_dazzle_another():
    with served(faults=[fault_of("power from 0.5 to 1.5")]) as server:
        body, laser = server.simulation.robots[0].hardware.body, server.lasers[0].laser
        until(lambda: body.material is Material.LASER, "it is ready")
        until(lambda: not laser.is_ready and body.material is Material.ROBOT, "it has no power")
        until(lambda: body.material is Material.LASER, "it has power again")


def test_it_sees_another_robot_that_comes():
    with served("empty", robots=2) as server:
        first, second = server.simulation.robots
        with Listener(server.lasers[0].place, angle_deg=180, step_hundredths=100) as listener:
            listener.wait_for(ScanHeard)
            with server.lock:
                x, y, heading = first.true_pose
                second.hardware.body.carry((x + 1.5 * math.cos(heading), y + 1.5 * math.sin(heading), heading))
            # Its rear is 0.301 m behind its middle, and the laser 0.021 m before the middle of the first one.
            until(lambda: abs(numbers_of(listener.told(ScanHeard)[-1]).ranges[90] - 1.178) < 0.002, "the other robot")


def test_scans_follow_their_robot():
    with served(start=(2.0, 3.0, 0.0)) as server, Listener(
            server.lasers[0].place, angle_deg=180, step_hundredths=100) as listener:
        listener.wait_for(ScanHeard)
        with server.lock:
            server.simulation.robots[0].hardware.body.carry((2.0, 3.0, math.pi / 2.0))
        count = len(listener.told(ScanHeard))
        listener.wait_for(ScanHeard, count + 5)
        assert numbers_of(listener.told(ScanHeard)[-1]).ranges[180] == pytest.approx(2.0, abs=0.002)


def test_a_cut_line_comes_back():
    with served() as server, SpoiltLine(int(server.lasers[0].place.rpartition(":")[2])) as line, Listener(
            line.url) as listener:
        listener.wait_for(ScanHeard)
        line.cut()
        assert "closed the line" in listener.wait_for(LaserLost).reason
        listener.wait_for(Measuring, 2)
        scans = len(listener.told(ScanHeard))
        listener.wait_for(ScanHeard, scans + 2)


@pytest.mark.parametrize("fails", ["power", "laser"])
def test_the_laser_has_the_power_of_its_robot_until_its_supply_fails(fails):
    with served(faults=[fault_of(fails + " from 1 to 2")]) as server, Listener(server.lasers[0].place) as listener:
        listener.wait_for(ScanHeard)
        assert "silent" in listener.wait_for(LaserLost).reason
        listener.wait_for(Measuring, 2)


def test_a_pseudo_terminal_that_is_not_there_yet(tmp_path):
    link = str(tmp_path / "laser")
    with Listener(link, baud=9600) as listener:
        assert "no such port" in listener.wait_for(PortDown).reason
        with served(pty=link):
            listener.wait_for(ScanHeard)


def test_a_pseudo_terminal_that_another_program_has(tmp_path):
    link = str(tmp_path / "laser")
    with served(pty=link):
        other = serial.Serial(link, exclusive=True)
        with Listener(link, baud=9600) as listener:
            assert "in use by another program" in listener.wait_for(PortDown).reason
            other.close()
            listener.wait_for(ScanHeard)


def test_a_second_client_is_refused_and_does_no_harm():
    with served() as server, Listener(server.lasers[0].place) as first:
        first.wait_for(ScanHeard)
        with Listener(server.lasers[0].place) as second:
            second.wait_for(LaserLost)
        scans = len(first.told(ScanHeard))
        first.wait_for(ScanHeard, scans + 2)
        assert first.told(LaserLost) == []


def test_a_client_that_asks_for_another_speed_over_tcp_leaves_the_next_one_a_fast_laser():
    """The vendor's client ends with the speed of 9600, also over TCP, where there is no speed."""
    with served() as server, Listener(server.lasers[0].place) as listener:
        listener.wait_for(ScanHeard)
        listener.end()
        laser = server.lasers[0].laser
        with server.lock:
            laser.receive(lms2xx.encode(lms2xx.SetMode(lms2xx.SPEEDS[9600].mode, b"")))
        until(lambda: laser.next_event_us > laser.clock.now_us and not laser._waiting and laser._work is None, "done")
        assert laser.baud == 500000
        with Listener(server.lasers[0].place) as again:
            assert again.wait_for(Measuring).info.baud == 500000


def next_messages(client, decoder):
    """Return what a laser says next. A scan that it broke off, to answer, is dropped as the vendor's client does it."""
    try:
        found = decoder.feed(client.recv(4096))
    except socket.timeout:
        found = decoder.drop_partial()
    return [lms2xx.decode(each) for each in found if isinstance(each, lms2xx.Telegram)]


def test_the_conversation_of_the_vendors_client():
    """As recorded (laser sheet 1.9, 1.10): it resets the laser, waits until that is ready, and configures it."""
    telegrams = {
        "reset": "02 00 01 00 10 34 12", "variant": "02 00 05 00 3B B4 00 00 00 5F 2D",
        "installation": "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5",
        "configuration": "02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02%s 5B 51" % (" 00" * 21),
        "stream": "02 00 02 00 20 24 34 08", "stop": "02 00 02 00 20 25 35 08", "slow": "02 00 02 00 20 42 52 08"}
    answers = [("reset", lms2xx.Resetting), (None, lms2xx.PowerOn), ("variant", lms2xx.VariantSet),
               ("installation", lms2xx.ModeSet), ("configuration", lms2xx.ConfigurationWritten),
               ("stream", lms2xx.ModeSet), (None, lms2xx.ScanReply), ("stop", lms2xx.ModeSet), ("slow", lms2xx.ModeSet)]
    with served() as server:
        host, _, port = server.lasers[0].place[len("socket://"):].rpartition(":")
        until(lambda: server.lasers[0].laser.is_ready, "ready")
        decoder, heard = lms2xx.TelegramDecoder(from_laser=True), []
        with socket.create_connection((host, int(port)), LIMIT) as client:
            client.settimeout(DROPS_AFTER)
            for name, kind in answers:
                if name is not None:
                    client.sendall(bytes.fromhex(telegrams[name]))
                until(lambda: heard.extend(next_messages(client, decoder))
                      or any(isinstance(each, kind) for each in heard), kind.__name__)
                # What came before counts no more: the laser may have said just before that it is ready.
                heard = heard[[isinstance(each, kind) for each in heard].index(True) + 1:]
        device = server.lasers[0].laser.device
        assert (device.eeprom.configuration.measuring_mode, device.baud) == (5, 500000)
        with Listener(server.lasers[0].place) as listener:
            assert numbers_of(listener.wait_for(ScanHeard)).range_max == pytest.approx(32.759)


def test_there_are_no_lasers_in_lockstep():
    with pytest.raises(ParameterError, match="lasers"):
        served(lockstep=1.0)


def test_a_port_that_is_taken(tmp_path):
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(served())
        port = int(server.lasers[0].place.rpartition(":")[2])
        simulation = simulate(load_world("tutorial"), find_model("p3dx-sh"), 1, None, 0)
        with pytest.raises(PortError, match="TCP port %d is in use" % port):
            Server(simulation, tcp=0, lasers=LaserPorts(tcp=port))


def test_a_simulation_may_have_no_lasers():
    simulation = Simulation(load_world("tutorial"))
    simulation.add(find_model("amigo-sh"))
    with Server(simulation, tcp=0) as server:
        assert server.lasers == []


# -- scans over the robot's own line

BURST = bytes.fromhex("FAFB06241B5A007E1B FAFB06253B5A007F3B FAFB06263B64008A3B FAFB06233B0200253B")
"""What the vendor's client sends at once (laser sheet 3.2): 36 -90, 37 90, 38 100, 35 2."""


def heard_from(client, decoder, wanted):
    """Return packets from a socket, until one is `wanted`."""
    packets = []
    while not any(isinstance(each, wanted) for each in packets):
        packets += [p2os.decode_packet(frame) for frame in decoder.feed(client.recv(4096))]
    return packets


def test_scans_over_the_robots_line_come_glued_to_its_sips():
    simulation = simulate(load_world("tutorial"), find_model("p3dx-sh"), 2, None, 0, serial="SIM", line_laser=True)
    with Server(simulation, tcp=0) as server:
        port = int(server.berths[1].url.rpartition(":")[2])
        decoder = p2os.FrameDecoder()
        with socket.create_connection(("127.0.0.1", port), LIMIT) as client:
            for number in (0, 1, 2):
                client.sendall(p2os.encode_frame(number))
                heard_from(client, decoder, p2os.SyncReply if number == 2 else p2os.SyncEcho)
            client.sendall(p2os.encode_frame(1) + p2os.encode_command("CONFIG"))
            [config] = [each for each in heard_from(client, decoder, p2os.Config) if isinstance(each, p2os.Config)]
            assert config.serial == "SIM"
            client.sendall(BURST)
            packets = heard_from(client, decoder, p2os.SimulatedLaserExtended)
            while sum(isinstance(each, p2os.SimulatedLaserExtended) for each in packets) < 30:
                packets += heard_from(client, decoder, p2os.SimulatedLaserExtended)
            assert decoder.counts.discarded_bytes == 0
        firsts = [getattr(each, "first", "sip") for each in packets]
        firsts = firsts[firsts.index(0):]
        assert firsts[:14] == [0, 32, 64, 96, 128, 160, "sip"] * 2
        assert simulation.robots[0].open_session is None, "the other robot has a line of its own"


def test_over_a_pseudo_terminal_too_slow_for_it_the_server_says_so(tmp_path):
    link, said = str(tmp_path / "robot"), []
    simulation = simulate(load_world("tutorial"), find_model("p3dx-sh"), 1, None, 0, line_laser=True)
    with Server(simulation, pty=link, say=said.append), open(link, "r+b", buffering=0) as client:
        for number in (0, 1, 2, 1):
            client.write(p2os.encode_frame(number))
            client.read(1)
        client.write(BURST)
        until(lambda: said, "it says so")
        assert "robot 1: at 9600 baud there is no time for scans of its laser beside the SIPs" in said[0]

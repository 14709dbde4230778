#!/usr/bin/env python3
"""What simulated robots cost: alone in each world, many in one world, in small and large worlds, served over TCP with
clients attached, and with lasers.

    python3 bench/simulator.py                       # everything, ten minutes; prints the tables of bench/simulator.md
    python3 bench/simulator.py alone --seconds 20    # one part, shorter: alone, crowd, worlds, served, lasers, lms200

All robots drive and turn away from what their front sonar hears, 16 transducers firing; each gets two commands every
tenth of a second. Figures are time of the processor, not of a clock:
the median of several runs, and the least and greatest of them.
"""

import argparse
import math
import os
import pathlib
import random
import resource
import selectors
import socket
import statistics
import subprocess
import sys
import time
from typing import Dict, List, Sequence

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "src"))

from pioneer_control import lms2xx, p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.line.lasers import PoseHistory
from pioneer_control.simulator.lms200 import TYPICAL, FirmwareNumbers, LaserFirmware, Optics
from pioneer_control.simulator.world import World, known_worlds, load_world
from pioneer_control.simulator.simulation import Simulation

MODEL = find_model("p3dx-sh")
OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
GO = p2os.encode_command("VEL", 200) + p2os.encode_command("RVEL", 0)
TURN = p2os.encode_command("VEL", 0) + p2os.encode_command("RVEL", 30)
NEAR_MM = 700
CROWDS = (1, 10, 100, 500)
CROWDED_WALLS = 2500
SIZES = (10, 1000, 100000)
VENDOR = {1: 0.27, 10: 0.12}
"""Seconds of processor time for a robot and minute that the vendor's simulator took, by how many robots there were."""


class Driver:
    """The computer's side of one robot: turns away from what is near ahead."""

    def __init__(self):
        self._decoder = p2os.FrameDecoder()
        self._ranges: Dict[int, int] = {}
        self.sips = 0

    def answer(self, data: bytes) -> bytes:
        """The next commands, after these bytes of the robot."""
        for frame in self._decoder.feed(data):
            packet = p2os.decode_packet(frame)
            if isinstance(packet, p2os.Sip):
                self.sips += 1
                self._ranges.update((reading.number, reading.range_units) for reading in packet.sonar)
        return TURN if min((self._ranges.get(number, 5000) for number in range(1, 7))) < NEAR_MM else GO


class Herd:
    """Robots with their drivers. Only the time of the robots counts."""

    def __init__(self, robots: Simulation, opening: bytes = OPEN):
        self.robots = robots
        self._drivers = [Driver() for _ in robots.robots]
        for robot in robots.robots:
            robot.receive(opening)

    def drive(self, seconds: float) -> float:
        """Let some simulated seconds pass. Returns the processor time (s) of the robots."""
        spent = 0.0
        commands = [GO] * len(self._drivers)
        for _ in range(round(seconds * 10)):
            begin = time.process_time()
            for robot, command in zip(self.robots.robots, commands):
                robot.receive(command)
            sent = self.robots.advance(0.1)
            spent += time.process_time() - begin
            commands = [driver.answer(data) for driver, data in zip(self._drivers, sent)]
        return spent


def floor(count: int, rng: random.Random, spacing: float = 2.0) -> World:
    """Return a square floor with `count` walls: four around it, and inside one of 1 to 2 m for every 4 square metres.
    """
    side = spacing * math.sqrt(count)
    walls = [(0.0, 0.0, side, 0.0), (side, 0.0, side, side), (side, side, 0.0, side), (0.0, side, 0.0, 0.0)]
    while len(walls) < count:
        x, y = rng.uniform(0, side), rng.uniform(0, side)
        angle, length = rng.uniform(-math.pi, math.pi), rng.uniform(1.0, 2.0)
        walls.append((x, y, x + length * math.cos(angle), y + length * math.sin(angle)))
    return World("%s walls" % count, walls)


def herd(world: World, count: int, rng: random.Random, opening: bytes = OPEN, **options) -> Herd:
    """Return so many robots at random places of a world."""
    robots = Simulation(world)
    low_x, low_y, high_x, high_y = world.bounds
    while len(robots.robots) < count:
        place = rng.uniform(low_x, high_x), rng.uniform(low_y, high_y), rng.uniform(-3.0, 3.0)
        try:
            robots.add(MODEL, place, seed=len(robots.robots), **options)
        except ParameterError:      # something stands there
            continue
    return Herd(robots, opening)


def spread(values: Sequence[float], form: str) -> str:
    """Return the median, and the least and greatest value."""
    return "%s (%s to %s)" % tuple(format(value, form)
                                   for value in (statistics.median(values), min(values), max(values)))


def table(*head: str) -> None:
    """Begin a table."""
    print("\n| " + " | ".join(head) + " |\n|" + "---|" * len(head), flush=True)


def row(*cells: str) -> None:
    """Print one row of the table."""
    print("| " + " | ".join(cells) + " |", flush=True)


def alone(seconds: float, runs: int) -> None:
    """Measure one robot in each world of the gallery."""
    table("world", "simulated seconds per second of the processor", "processor seconds a minute", "contacts")
    for name in known_worlds():
        robots = Simulation(load_world(name))
        robot = robots.add(MODEL)
        one = Herd(robots)
        one.drive(10.0)
        spent = [one.drive(seconds) for _ in range(runs)]
        row(name, spread([seconds / each for each in spent], ".0f"),
            spread([each * 60.0 / seconds for each in spent], ".3f"), str(robot.contacts))


def crowd(seconds: float, runs: int) -> None:
    """Measure one to five hundred robots in the same world."""
    table("robots", "processor ms for a robot and simulated second", "processor seconds for a robot and minute",
          "vendor's", "robots per core")
    for count in CROWDS:
        rng = random.Random(1)
        many = herd(floor(CROWDED_WALLS, rng), count, rng)
        share = seconds * max(0.02, 1.0 / count) if count > 10 else seconds
        many.drive(5.0)
        each = [many.drive(share) / share / count for _ in range(runs)]
        vendor = "%.2f" % (VENDOR[count]) if count in VENDOR else ""
        row(str(count), spread([one * 1e3 for one in each], ".2f"), spread([one * 60.0 for one in each], ".3f"), vendor,
            "%.0f" % (1.0 / statistics.median(each)))


def worlds(seconds: float, runs: int) -> None:
    """Measure three robots in worlds of ten to a hundred thousand walls."""
    table("walls", "processor ms for a robot and simulated second", "to make the world (s)")
    for count in SIZES:
        begin = time.process_time()
        world = floor(count, random.Random(2))
        made = time.process_time() - begin
        few = herd(world, 3, random.Random(3), gripper=False)
        few.drive(5.0)
        row(str(count), spread([few.drive(seconds) / seconds / 3 * 1e3 for _ in range(runs)], ".2f"), "%.2f" % made)


# -- lasers

LASERED = (1, 10, 100)
SCANS = OPEN + b"".join(p2os.encode_simulator_command(name, value) for name, value in (
    ("SIM_LRF_SET_FOV_START", -90), ("SIM_LRF_SET_FOV_END", 90), ("SIM_LRF_SET_RES", 100), ("SIM_LRF_ENABLE", 2)))


def lasers(seconds: float, runs: int) -> None:
    """Measure robots that all scan 181 values ten times a second, over their own lines."""
    table("robots", "ms for a robot and simulated second, no scans", "with 10 scans of 181 values", "robots per core")
    for count in LASERED:
        each = {}
        for opening in (OPEN, SCANS):
            rng = random.Random(1)
            many = herd(floor(CROWDED_WALLS, rng), count, rng, opening, line_laser=True)
            share = max(1.0, seconds / count)
            many.drive(5.0)
            each[opening] = [many.drive(share) / share / count for _ in range(runs)]
        without, with_scans = each.values()
        row(str(count), spread([one * 1e3 for one in without], ".2f"), spread([one * 1e3 for one in with_scans], ".2f"),
            "%.0f" % (1.0 / statistics.median(with_scans)))
    table("world", "robots", "simulated seconds per second of the processor, with 10 scans of 181 values")
    for name in known_worlds():
        robots = Simulation(load_world(name))
        robots.add(MODEL, line_laser=True)
        one = Herd(robots, SCANS)
        one.drive(5.0)
        row(name, "1", spread([seconds / one.drive(seconds) for _ in range(runs)], ".0f"))


def lms200(seconds: float, runs: int) -> None:
    """Measure a robot that drives through the office with an LMS200 on a line of its own, at each speed."""
    table("line (baud)", "values", "scans a simulated second", "simulated seconds per second of the processor")
    for baud, step in ((38400, 100), (500000, 100), (500000, 50)):
        robots = Simulation(load_world("office"))
        robot = robots.add(MODEL)
        history = PoseHistory(robot, 0)
        robots.on_step.append(history.note)
        laser = LaserFirmware(Optics(robots.world, TYPICAL, 1, robot.hardware.body), history.pose_at,
                              FirmwareNumbers(boot=0.0), fixed_baud=baud)
        one = Herd(robots)
        one.drive(0.1)
        laser.run_to(robots.clock.now_us)       # now it is ready
        for request in (lms2xx.SetVariant(180, step), lms2xx.SetMode(lms2xx.Mode.STREAM, b"")):
            laser.receive(lms2xx.encode(request))
        figures = []
        for _ in range(runs + 1):
            scans, spent = laser.device.operation.scans_sent, 0.0
            for _ in range(round(seconds)):
                spent += one.drive(1.0)
                begin = time.process_time()
                laser.run_to(robots.clock.now_us)
                laser.take_sent()
                spent += time.process_time() - begin
            figures.append((seconds / spent, (laser.device.operation.scans_sent - scans) / seconds))
        paces, rates = zip(*figures[1:])
        row(str(baud), "181" if step == 100 else "361", "%.1f" % statistics.median(rates), spread(paces, ".0f"))


# -- served: robots in a process of their own

SERVER = """
import sys, time, random
sys.path[:0] = {path!r}
import simulator as bench
from pioneer_control.simulator.line import Server
rng = random.Random(1)
many = bench.herd(bench.floor(bench.CROWDED_WALLS, rng), {count}, rng).robots
for robot in many.robots:
    robot.close_session()
with Server(many, tcp=0) as server:
    print(*(berth.url.rpartition(":")[2] for berth in server.berths), flush=True)
    for _ in sys.stdin:
        print(time.process_time(), many.clock.now_us * 1e-6, bench.memory(), flush=True)
"""


def memory() -> float:
    """The memory that this process takes at present (MB)."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


class Client:
    """A socket to a robot, and its driver."""

    def __init__(self, port: int):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.sendall(OPEN)
        self.driver = Driver()

    def serve(self) -> None:
        """Answer the packets that have come."""
        self.socket.sendall(self.driver.answer(self.socket.recv(4096)))


def served(seconds: float, runs: int) -> None:
    """Measure robots in real time, each with a client that answers every SIP."""
    table("robots", "processor ms for a robot and second, all of the server's", "robots per core", "of real time",
          "SIPs of those due", "memory (MB)")
    for count in CROWDS:
        path = [str(pathlib.Path(__file__).parent), sys.path[0]]
        with subprocess.Popen(
                [sys.executable, "-c", SERVER.format(path=path, count=count)],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True) as server:
            clients = [Client(int(port)) for port in server.stdout.readline().split()]
            figures = [_served_run(server, clients, seconds) for _ in range(runs + 1)][1:]      # the first one warms up
            server.stdin.close()
        spent, lived, heard, used = zip(*figures)
        each = [one / passed / count for one, passed in zip(spent, lived)]
        row(str(count), spread([one * 1e3 for one in each], ".2f"), "%.0f" % (1.0 / statistics.median(each)),
            spread([one / seconds for one in lived], ".3f"),
            spread([one / (seconds * 10 * count) for one in heard], ".3f"), "%.0f" % (max(used)))


def _served_run(server: subprocess.Popen, clients: List[Client], seconds: float):
    """Return processor time of the server, simulated time and SIPs in some real seconds, and its memory (MB)."""
    def ask():
        server.stdin.write("\n")
        server.stdin.flush()
        return [float(word) for word in server.stdout.readline().split()]

    with selectors.DefaultSelector() as selector:
        for client in clients:
            selector.register(client.socket, selectors.EVENT_READ, client)
        before, sips = ask(), sum(client.driver.sips for client in clients)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for key, _ in selector.select(0.1):
                key.data.serve()
        after = ask()
    return after[0] - before[0], after[1] - before[1], sum(client.driver.sips for client in clients) - sips, after[2]


PARTS = {"alone": (alone, 60.0, 7), "crowd": (crowd, 60.0, 5), "worlds": (worlds, 20.0, 5), "served": (served, 10.0, 5),
         "lasers": (lasers, 20.0, 5), "lms200": (lms200, 10.0, 5)}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="what to measure (default: everything)")
    parser.add_argument("--seconds", type=float, help="simulated seconds of a run")
    parser.add_argument("--runs", type=int, help="how many runs of each")
    options = parser.parse_args()
    print("Python %s, %s cores, load %.1f" % (sys.version.split()[0], os.cpu_count(), os.getloadavg()[0]))
    for name in options.parts or PARTS:
        measure, seconds, runs = PARTS[name]
        measure(options.seconds or seconds, options.runs or runs)


if __name__ == "__main__":
    main()

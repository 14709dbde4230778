#!/usr/bin/python3
"""What the driver of a laser makes of the simulated laser: scans a second, ranges, stamps, start, processor time.

    ./pioneer shell /usr/bin/python3 bench/laser.py             # four minutes; writes bench/laser.md
    ./pioneer shell /usr/bin/python3 bench/laser.py --quick     # one minute; writes nothing

The first two tables are in simulated time (bench/laser_rig.py), so each run gives the same numbers. The others are in
real time, over pseudo-terminals; on a machine that does other work too, they are upper bounds: give the program a
priority then, with ``chrt -r 5`` before it.

`floor` is a loop that only reads: ``port.read(port.in_waiting or 1)`` of pyserial, on a laser that was set up before.
`line` is what the node runs on its port, without ROS: telegrams, CRC, session, stamps. `node` is the whole node with
one subscriber of scan. All have a laser of their own, in one simulator, and run at the same time. Processor time is
that of all threads of a process, for each scan that came, times 37.5 scans a second.

Exit status 1 when a limit is exceeded.
"""

import argparse
import atexit
import bisect
import contextlib
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from laser_rig import HERE, LaserRig, Script

from pioneer_control import lms2xx
from pioneer_control.laser.conversion import numbers_of
from pioneer_control.laser.session import Measuring, ScanHeard
from pioneer_control.robots import find_model
from pioneer_control.simulator import load_world, simulate
from pioneer_control.simulator.line import LaserPorts, Server
from pioneer_control.simulator.lms200 import PERFECT, TYPICAL, FirmwareNumbers
from pioneer_control.simulator.world import World

RESULTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "laser.md")
SPEEDS = sorted(lms2xx.SPEEDS)
WIDTH, DEPTH = 7.0, 4.0
ROOM = World("room", walls=[(0, 0, WIDTH, 0), (WIDTH, 0, WIDTH, DEPTH), (WIDTH, DEPTH, 0, DEPTH), (0, DEPTH, 0, 0)])
NOISY = replace(TYPICAL, spot=0.0, spot_growth=0.0, rays=1)
"""A laser with the errors of an LMS200, but for those of a spot that lies on two surfaces: these are as large as a step
between them."""
NOISE_SIGMAS = 4.0      # a normal error is larger once in 16000 values
LATENCY = 0.001         # s between two reads, in simulated time: an adapter for USB, told to be quick
FASTEST = lms2xx.Variant(180, 50)
RATE = 37.5
MOST_RATIO, MOST_RANGE_ERROR, MOST_STAMP_ERROR = 3.0, 0.01, 0.005


class Limits:
    """Collects the limits that are exceeded."""

    def __init__(self) -> None:
        self.exceeded: List[str] = []

    def check(self, what: str, value: float, most: float) -> str:
        """Return whether a limit is kept, as a word."""
        if value <= most:
            return "kept"
        self.exceeded.append("%s: %g, at most %g" % (what, value, most))
        return "EXCEEDED"


# Simulated time

def to_wall(angle: float) -> float:
    """Return the distance (m) from `HERE` to the wall of `ROOM` in a direction, by paper and pencil."""
    x, y, heading = HERE
    c, s = math.cos(heading + angle), math.sin(heading + angle)
    return min(((WIDTH if c > 0.0 else 0.0) - x) / c if abs(c) > 1e-9 else math.inf,
               ((DEPTH if s > 0.0 else 0.0) - y) / s if abs(s) > 1e-9 else math.inf)


def run(seconds: float, **options) -> LaserRig:
    """Return a rig whose laser has measured for some time."""
    def script(rig: LaserRig) -> Script:
        yield from rig.until(Measuring)
        yield seconds

    return LaserRig(world=ROOM, turn_rate=0.0, **options).play(script)


def range_errors(rig: LaserRig) -> List[float]:
    """Return the errors (m) of all ranges of the last three scans."""
    errors = []
    for heard in rig.told(ScanHeard)[-3:]:
        numbers = numbers_of(heard)
        errors += [far - to_wall(numbers.angle_min + index * numbers.angle_increment)
                   for index, far in enumerate(numbers.ranges.tolist()) if math.isfinite(far)]
    return errors


def rates(limits: Limits) -> Iterator[str]:
    """The table of all speeds, angles, steps and units."""
    yield ("| degrees, step | unit | baud | scans/s | line's arithmetic | worst stamp, ms | limit, ms |"
           " worst range, mm | with noise, mm | limit, mm | |")
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    for variant in lms2xx.VARIANTS:
        for unit, name in ((lms2xx.Unit.MILLIMETRES, "mm"), (lms2xx.Unit.CENTIMETRES, "cm")):
            for baud in SPEEDS:
                period, byte = lms2xx.scan_time(variant, baud), lms2xx.time_on_line(1, baud)
                asks = dict(baud=baud, angle_deg=variant.angle_deg, step_hundredths=variant.step_hundredths, unit=unit,
                            writes=True, step=min(LATENCY, byte) if baud < 500000 else LATENCY)
                rig = run(max(2.0, 6.0 * period), **asks)
                times = [scan.first_ray for scan in rig.told(ScanHeard)]
                rate = (len(times) - 1) / (times[-1] - times[0])
                worst = max(map(abs, range_errors(rig)))
                noisy = run(4.0 * period, optics=NOISY, **asks)
                noise = max(map(abs, range_errors(noisy)))
                bias = TYPICAL.bias + NOISE_SIGMAS * TYPICAL.noise
                what = "%d, %.2f, %s, %d baud" % (
                    variant.angle_deg, variant.step_hundredths / 100.0, name, baud)
                most_stamp = MOST_STAMP_ERROR if baud == 500000 else byte
                verdicts = {
                    limits.check(what + ": scans a second off by", abs(rate * period - 1.0), 0.01),
                    limits.check(what + ": stamp", rig.judge.worst, most_stamp + 2e-6),
                    limits.check(what + ": range", worst, MOST_RANGE_ERROR),
                    limits.check(what + ": range with noise", noise, MOST_RANGE_ERROR + bias)}
                yield "| %d, %.2f | %s | %d | %.2f | %.2f | %.2f | %.2f | %.1f | %.1f | %.0f | %s |" % (
                    variant.angle_deg, variant.step_hundredths / 100.0, name, baud, rate, 1.0 / period,
                    1e3 * rig.judge.worst, 1e3 * most_stamp, 1e3 * worst, 1e3 * noise,
                    1e3 * (MOST_RANGE_ERROR + bias), min(verdicts))


class Start(NamedTuple):
    """A start: time (s) to the first scan, and how much of it the laser itself took, to answer and to measure."""

    total: float
    laser: float


def start(found: int, baud: int, streams: bool) -> Start:
    """Measure the start with a laser that has some speed (baud), and perhaps streams."""
    rig = LaserRig(world=ROOM, baud=baud, step=LATENCY)
    rig.laser.run_to(100000)
    rig.now, rig.laser.device.baud = 0.1, found
    if streams:
        rig.laser.device.operation.mode = lms2xx.Mode.STREAM
    asked: List[Tuple[float, bool]] = []    # when something was asked, and whether at the laser's speed
    heard: List[float] = []
    carry = rig.carry

    def carry_and_note(data: bytes, speed: int) -> None:
        asked.append((rig.now, speed == rig.laser.baud))
        carry(data, speed)

    def script(rig: LaserRig) -> Script:
        while not rig.told(ScanHeard):
            if rig.port is not None and rig.port.waiting:
                heard.append(rig.now)
            yield rig.step / 2.0

    rig.carry = carry_and_note      # type: ignore[method-assign]
    begin = rig.now
    rig.play(script)
    end = rig.events[[isinstance(event, ScanHeard) for _, event in rig.events].index(True)][0]
    laser = 0.0
    times = [at for at, _ in asked if at < end] + [end]
    for (at, right), following in zip(asked, times[1:]):
        after = [time for time in heard if at < time <= following + LATENCY]
        if right and after:
            laser += (end if following == end else max(after)) - at
    return Start(end - begin, min(laser, end - begin))


def starts() -> Iterator[str]:
    """The table of starts."""
    yield "| it is at | wanted | it streams | to the first scan, s | of it the laser, s | search and pauses, s |"
    yield "|---|---|---|---|---|---|"
    for found in SPEEDS:
        for baud in SPEEDS:
            for streams in (False, True):
                if found == 9600 or (found == baud and streams) or (found == 500000 and baud == 38400):
                    took = start(found, baud, streams)
                    yield "| %d | %d | %s | %.2f | %.2f | %.2f |" % (
                        found, baud, "yes" if streams else "no", took.total, took.laser, took.total - took.laser)


# Real time

LINE = """
import sys
from pioneer_control.laser.line import LaserLine
from pioneer_control.laser.session import ScanHeard
from pioneer_control.laser.settings import LaserSettings
def tell(event):
    if isinstance(event, ScanHeard):
        print(event.first_ray)
LaserLine(sys.argv[1], LaserSettings(baud=int(sys.argv[2]), angle_deg=int(sys.argv[3]),
                                     step_hundredths=int(sys.argv[4])), tell).run()
"""
ANSWER = 10     # bytes: ACK, and the reply to a change of the mode
FLOOR = """
import sys
import serial
from pioneer_control import lms2xx
port = serial.Serial(sys.argv[1], 9600, timeout=9)
port.reset_input_buffer()
port.write(lms2xx.encode(lms2xx.SetMode(lms2xx.Mode.BAUD_500000, b"")))
assert len(port.read(%d)) == %d
port.baudrate = 500000
port.write(lms2xx.encode(lms2xx.SetMode(lms2xx.Mode.STREAM, b"")))
count = 0
while True:
    count += len(port.read(port.in_waiting or 1))
""" % (ANSWER, ANSWER)


def stamps_over_pty(variant: lms2xx.Variant, baud: int, seconds: float) -> List[float]:
    """Return the errors (s) of the stamps of another process, against the times at which the simulated laser fired."""
    with tempfile.TemporaryDirectory() as folder:
        link = os.path.join(folder, "laser")
        world = load_world("tutorial").with_start((2.0, 1.5, math.pi / 2.0))
        server = Server(simulate(world, find_model("p3dx-sh"), 1, None, 0), tcp=0, lasers=LaserPorts(
            pty=link, optics=PERFECT, numbers=FirmwareNumbers(boot=0.1)))
        device, fired = server.lasers[0].laser.device, []
        measure = device.scan

        def scan(operation, last_turn, values=slice(None)):
            # The real time of simulated time, as the server's pace has it at this moment.
            ahead = operation.turn_end_us(last_turn - operation.variant.turns) - server.pace._due_us
            fired.append(server.pace._looked + ahead * 1e-6)
            return measure(operation, last_turn, values)

        device.scan = scan
        with server:
            listener = subprocess.Popen([sys.executable, "-u", "-c", LINE, link, str(baud), str(variant.angle_deg),
                                         str(variant.step_hundredths)], stdout=subprocess.PIPE, text=True)
            time.sleep(3.0 + seconds)
            listener.kill()
            stamps = [float(line) for line in listener.communicate()[0].splitlines() if line.strip()]
    fired.sort()
    errors = []
    for stamp in stamps[1:]:
        at = bisect.bisect(fired, stamp)
        errors.append(min((stamp - each for each in fired[max(0, at - 1):at + 1]), key=abs))
    return errors


def real_stamps(seconds: float) -> Iterator[str]:
    """The table of stamps over pseudo-terminals."""
    yield "| degrees, step | baud | scans | median, ms | 95 %, ms | worst, ms |"
    yield "|---|---|---|---|---|---|"
    for variant, baud in [*((variant, 500000) for variant in lms2xx.VARIANTS), (FASTEST, 38400), (FASTEST, 9600)]:
        errors = sorted(abs(1e3 * error) for error in stamps_over_pty(variant, baud, seconds))
        yield "| %d, %.2f | %d | %d | %.2f | %.2f | %.2f |" % (
            variant.angle_deg, variant.step_hundredths / 100.0, baud, len(errors), statistics.median(errors),
            errors[int(0.95 * (len(errors) - 1))], errors[-1])


def cpu_of(process: subprocess.Popen) -> float:
    """Return the processor time of a process so far (s)."""
    return time.clock_gettime(~process.pid << 3 | 2)    # the clock that clock_getcpuclockid(3) returns


def scans_read(process: subprocess.Popen) -> float:
    """Return how many scans' bytes a process has read so far. Sockets of rospy do not count as read."""
    with open("/proc/%d/io" % process.pid) as file:
        return int(file.readline().split()[1]) / lms2xx.scan_bytes(FASTEST.values)


@contextlib.contextmanager
def programs() -> Iterator[Dict[str, subprocess.Popen]]:
    """Run a simulator with three lasers, and floor, line and node on them."""
    from driver import master

    with tempfile.TemporaryDirectory() as folder, master(), contextlib.ExitStack() as ends:
        def begin(*command: str, **options) -> subprocess.Popen:
            process = subprocess.Popen([sys.executable, *command], stdout=subprocess.DEVNULL, **options)
            ends.callback(process.wait)
            ends.callback(process.kill)
            atexit.register(process.kill)
            return process

        link = os.path.join(folder, "laser")
        begin("-m", "pioneer_control.simulator", "--laser", "lms200", "--robots", "3", "--laser-pty", link, "--tcp",
              "127.0.0.1:18300")
        while not os.path.lexists(link + "3"):
            time.sleep(0.1)
        time.sleep(2.0)
        nodes = os.path.join(os.path.dirname(RESULTS), "..", "nodes")
        yield {
            "floor": begin("-c", FLOOR, link + "1"),
            "line": begin("-c", LINE, link + "2", "500000", "180", "50"),
            "node": begin(os.path.join(nodes, "laser"), "_port:=" + link + "3", "_baud:=500000", "_angle:=180",
                          "_resolution:=0.5"),
        }


def processor_times(rounds: int, seconds: float) -> List[Dict[str, float]]:
    """Return the processor time of each program (s a minute, at `RATE` scans a second) in each round."""
    import rospy
    from sensor_msgs.msg import LaserScan

    with programs() as running:
        rospy.init_node("bench", disable_signals=True)
        count = [0]

        def came(message: LaserScan) -> None:
            count[0] += 1

        rospy.Subscriber("scan", LaserScan, came, queue_size=10, tcp_nodelay=True)
        while count[0] < 50:
            time.sleep(0.1)
        found = []
        for _ in range(rounds):
            before = {name: (cpu_of(process), scans_read(process)) for name, process in running.items()}
            time.sleep(seconds)
            found.append({name: (cpu_of(process) - before[name][0]) / max(1.0, scans_read(process) - before[name][1])
                          * RATE * 60.0 for name, process in running.items()})
    return found


def costs(limits: Limits, rounds: int, seconds: float) -> Iterator[str]:
    """The table of processor times."""
    found = processor_times(rounds, seconds)
    yield "| program | s a minute | x floor: median | least to greatest of a round | |"
    yield "|---|---|---|---|---|"
    for name in ("floor", "line", "node"):
        ratios = sorted(each[name] / each["floor"] for each in found)
        verdict = limits.check("processor time of the %s" % name, statistics.median(ratios), MOST_RATIO)
        yield "| %s | %.2f | %.2f | %.2f to %.2f | %s |" % (
            name, statistics.median(each[name] for each in found), statistics.median(ratios), ratios[0], ratios[-1],
            "" if name == "floor" else verdict)


INTRO = """# What `bench/laser.py` measured

Written by the program. Python %s, %d cores, load average %.1f before the start. **The laser is a simulated one**:
nobody has tried the driver on a real one yet.

"""


def report(limits: Limits, quick: bool) -> str:
    """Return all tables as text."""
    parts: Sequence[Tuple[str, str, Iterator[str]]] = (
        ("Speeds, angles, steps, units", "In simulated time, with %.0f ms between two reads of the port (less at slower"
         " speeds: one byte). A stamp is compared with the time at which the first ray was fired, a range with the"
         " distance by paper and pencil, in an empty room: with a laser without errors, and with the noise of an LMS200"
         " (a constant error of up to %.0f mm and a normal one of %.0f mm; the limit is 10 mm, the constant error and"
         " %.0f sigma)." % (1e3 * LATENCY, 1e3 * TYPICAL.bias, 1e3 * TYPICAL.noise, NOISE_SIGMAS), rates(limits)),
        ("Start", "In simulated time, from the opening of the port to the first scan. What the laser takes is from each"
         " request that it heard to the end of its answer, and from the start of its stream to the end of the first"
         " scan; its answers take as long as the simulated laser's, which a real one may not. The rest is the search"
         " for its speed, and the 0.25 s that it is given after a change of the speed.", starts()),
        ("Stamps in real time", "Over a pseudo-terminal, by a process of its own; the truth is the simulated laser's."
         " No limit is checked here: on a busy machine the process of the laser itself is late.",
         real_stamps(3.0 if quick else 10.0)),
        ("Processor time", "At %.1f scans of %d values a second, over pseudo-terminals; %s." % (
            RATE, FASTEST.values, "see the head of the program"), costs(limits, 3 if quick else 9, 6.0)))
    text = INTRO % (platform.python_version(), os.cpu_count() or 0, os.getloadavg()[0])
    for head, words, table in parts:
        text += "## %s\n\n%s\n\n%s\n\n" % (head, words, "\n".join(table))
    return text.rstrip() + "\n"


def main() -> int:
    """Measure, print, and write the results. Returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="shorter, and write nothing")
    options = parser.parse_args()
    limits = Limits()
    text = report(limits, options.quick)
    print(text)
    if not options.quick:
        with open(RESULTS, "w", encoding="utf-8") as file:
            file.write(text)
    print("\n".join(limits.exceeded))
    return 1 if limits.exceeded else 0


if __name__ == "__main__":
    sys.exit(main())

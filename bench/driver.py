#!/usr/bin/python3
"""How fast the driver is and what it costs, side by side with the least a rospy node can do on the same bytes:
the floor, bench/relay_node.py.

    ./pioneer shell /usr/bin/python3 bench/driver.py            # eight minutes; writes bench/driver.md
    ./pioneer shell /usr/bin/python3 bench/driver.py --quick    # one minute; writes nothing
    ./pioneer shell /usr/bin/python3 bench/driver.py --pieces   # six minutes; writes bench/driver_pieces.md: the driver
                                                                # with and without each piece of driver/prompt.py

`floor` publishes one topic; `floor3`, a second floor for what publishing costs, the three that are subscribed here of
the driver: pose, sonar, tf. Each node has a robot of its own (bench/scripted_robot.py, a pty) and the same commander
and subscriber, in this process; a ROS master is started for the run. They take turns: SIPs and commands of one go out a
third of a cycle after those of another, so that all meet the same machine in the same state.
Commands drift slowly against the SIPs, and so meet every phase of the cycle.

A time begins right before the write of a SIP or the publish() of a command, and ends when the subscriber's callback is
called or the robot has read the last byte of RVEL. On a machine that does other work too, all figures are upper bounds;
the ratios to the floor say more. The same code differs from one start of the processes to the next: where the median
ratio to the floor was 1.15, that of single starts was 0.96 to 1.37. So all nodes are started anew for each round, and a
median is the median of the medians of the rounds. A real line of 9600 baud adds 1.04 ms for each byte, and so about 0.3
s to the start.

Exit status 1 when a limit is exceeded.
"""

import argparse
import atexit
import bisect
import contextlib
import itertools
import math
import os
import platform
import signal
import socket
import subprocess
import sys
import threading
import time
from time import monotonic
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from relay_node import SIP_LENGTH
from scripted_robot import Record, ScriptedRobot
from std_srvs.srv import SetBool

from pioneer_control import p2os

HERE = os.path.dirname(os.path.abspath(__file__))
RESULTS = os.path.join(HERE, "driver.md")
PIECES_RESULTS = os.path.join(HERE, "driver_pieces.md")
# s in each phase, of each round. The last round shows whether memory grows.
DRIVES = 6 * (10.0,) + (60.0,)
ROUNDS, PIECES_DRIVE = 5, 20.0      # of --pieces: rounds, and s in each phase
NODES = {"floor": [sys.executable, os.path.join(HERE, "relay_node.py"), "{port}"],
         "floor3": [sys.executable, os.path.join(HERE, "relay_node.py"), "{port}", "three"],
         "ours": [sys.executable, os.path.join(HERE, "..", "nodes", "p2os_driver"), "_port:={port}"]}
PIECES = {name: [sys.executable, os.path.join(HERE, "driver_without.py"), name, "_port:={port}"]
          for name in ("plain_connection", "plain_messages", "plain_order", "plain_all")}
"""Further nodes: the driver without a piece, or without all of them."""
ENOUGH = 115200         # baud: 9600 carries 53 pairs of VEL and RVEL a second
DRIFT = 1.013           # commands come so much more often than said
SLOWEST, FASTEST = 100, 499     # mm/s: each command of a second has a speed of its own, to be known by on the wire
PATIENCE = 20.0         # s for what should take one


class Phase(NamedTuple):
    """Some time of driving."""

    cycle: float
    """s between SIPs"""
    rate: float
    """Hz of cmd_vel"""

    def __str__(self) -> str:
        return "SIPs every %.0f ms, cmd_vel at %g Hz" % (self.cycle * 1000, self.rate)


SLOW, FAST, MANY = PHASES = (Phase(0.1, 10), Phase(0.02, 10), Phase(0.1, 100))


class Usage(NamedTuple):
    """The processor time and memory of a process."""

    cpu: float
    """s a minute"""
    rss: float
    """MiB, at the end"""
    growth: float
    """MiB, meanwhile"""


class Drive(NamedTuple):
    """What was measured of one node in one phase. Times in ms."""

    pose: List[float]
    """from a SIP to its Odometry"""
    command: List[float]
    """from a cmd_vel to the complete command"""
    arrived: float
    """share of the commands"""
    usage: Usage


# Processes

class Node:
    """A node that is measured: its process, and the topics it has."""

    def __init__(self, name: str, port: str, *arguments: str) -> None:
        command = [part.format(port=port) for part in NODES[name]] + ["__ns:=/" + name, *arguments]
        self.started = monotonic()
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        atexit.register(self.process.kill)      # when the bench fails; one that has ended gets nothing

    def cpu(self) -> float:
        """Processor time so far (s), of all threads."""
        return time.clock_gettime(~self.process.pid << 3 | 2)      # the clock that clock_getcpuclockid(3) returns

    def rss(self) -> float:
        """Resident memory (MiB)."""
        with open("/proc/%d/statm" % self.process.pid) as statm:
            return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2 ** 20

    def end(self, how: int) -> int:
        """Send a signal and wait. Returns the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(PATIENCE)


@contextlib.contextmanager
def master():
    """Run a ROS master of our own, as long as the block lasts."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % port, ROS_HOSTNAME="localhost")
    process = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        while not rosgraph.is_master_online():
            time.sleep(0.05)
        yield
    finally:
        process.terminate()
        process.wait()


# What a user of the nodes has: subscribers, and a commander

class Poses:
    """The arrival times of each Odometry of a node."""

    def __init__(self, name: str) -> None:
        self.heard: List[Tuple[int, float]] = []     # number (the publisher counts), time
        self._changed = threading.Condition()
        rospy.Subscriber("/%s/pose" % name, Odometry, self._take)

    def _take(self, message: Odometry) -> None:
        now = monotonic()
        with self._changed:
            self.heard.append((message.header.seq, now))
            self._changed.notify_all()

    def forget(self) -> None:
        """Begin anew."""
        self.heard = []

    def first(self) -> float:
        """Return the time of the first Odometry since forget(). Waits for it."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.heard, PATIENCE):
                raise SystemExit("no Odometry within %.0f s" % PATIENCE)
            return self.heard[0][1]


class Commander:
    """Publishes cmd_vel to one or more nodes in turn, from a thread of its own, while the `with` block lasts.

    When this process is late by more than a cycle, the missed commands are left out, as with rospy.Rate. So no commands
    come in a bunch.
    """

    def __init__(self, publishers: Dict[str, rospy.Publisher], rate: float,
                 speeds: Sequence[int] = range(SLOWEST, FASTEST + 1)) -> None:
        self.sent: Dict[str, List[Tuple[float, int]]] = {name: [] for name in publishers}     # time, mm/s
        self._publishers, self._speeds = publishers, speeds
        self._period = 1 / rate / DRIFT / len(publishers)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        due = monotonic()
        for number in range(sys.maxsize):
            for name, publisher in self._publishers.items():
                due += self._period
                if monotonic() > due + self._period * len(self._publishers):
                    due = monotonic()
                if self._ended.wait(max(0.0, due - monotonic())):
                    return
                twist, speed = Twist(), self._speeds[number % len(self._speeds)]
                twist.linear.x = speed / 1000
                self.sent[name].append((monotonic(), speed))
                publisher.publish(twist)

    def __enter__(self) -> "Commander":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()


def is_driver(name: str) -> bool:
    """Return whether a node is the driver, whole or without a piece. Otherwise it is a floor."""
    return not name.startswith("floor")


class Bench:
    """The robots, and what a user of their nodes has."""

    def __init__(self) -> None:
        self.robots = {name: ScriptedRobot(turn / len(NODES), is_open=not is_driver(name))
                       for turn, name in enumerate(NODES)}

    def connect(self) -> None:
        """Join the graph. Start the robots before: they are forks of this process."""
        rospy.init_node("bench", disable_signals=True)
        self.poses = {name: Poses(name) for name in NODES}
        self.publishers = {name: rospy.Publisher("/%s/cmd_vel" % name, Twist, queue_size=10, tcp_nodelay=True)
                           for name in NODES}
        for topic in ["/%s/sonar" % name for name in NODES if name != "floor"] + ["/tf"]:
            rospy.Subscriber(topic, rospy.AnyMsg, lambda message: None)

    def start(self, name: str, *arguments: str) -> Tuple[Node, float]:
        """Start a node. Returns it, and the time (s) until its first Odometry."""
        self.poses[name].forget()
        node = Node(name, self.robots[name].port, *arguments)
        return node, self.poses[name].first() - node.started

    def until_driving(self, name: str = "ours") -> None:
        """Switch the motors on. Returns when the node has subscribed to our cmd_vel."""
        rospy.wait_for_service("/%s/set_motors" % name, PATIENCE)
        assert rospy.ServiceProxy("/%s/set_motors" % name, SetBool)(True).success
        deadline = monotonic() + PATIENCE
        while not self.publishers[name].get_num_connections() and monotonic() < deadline:
            time.sleep(0.01)

    def driving(self, name: str) -> Commander:
        """Return a Commander that drives one node at 0.2 m/s."""
        return Commander({name: self.publishers[name]}, 10, (200,))


# What is measured

def drive(bench: Bench, seconds: float) -> Dict[Tuple[str, Phase], Drive]:
    """Measure latencies and costs of all nodes side by side, in all phases."""
    for robot in bench.robots.values():
        robot.set_cycle(SLOW.cycle)
    nodes = {name: bench.start(name, *(["_baud:=%d" % ENOUGH] if is_driver(name) else []))[0] for name in NODES}
    for name in filter(is_driver, NODES):
        bench.until_driving(name)
    found = {}
    for phase in PHASES:
        print(phase, flush=True)
        for robot in bench.robots.values():
            robot.set_cycle(phase.cycle)
        with Commander(bench.publishers, phase.rate):
            time.sleep(2.0)     # what is done once is done
        for name in NODES:
            bench.robots[name].record()
            bench.poses[name].forget()
        before = {name: (monotonic(), node.cpu(), node.rss()) for name, node in nodes.items()}
        with Commander(bench.publishers, phase.rate) as commander:
            time.sleep(seconds)
        after = {name: (monotonic(), node.cpu(), node.rss()) for name, node in nodes.items()}
        time.sleep(0.1)
        for name, robot in bench.robots.items():
            # in this order: each has its SIP in the record
            heard, record = bench.poses[name].heard[:], robot.record()
            wall, cpu, growth = (new - old for new, old in zip(after[name], before[name]))
            commands, arrived = command_latencies(commander.sent[name], record)
            usage = Usage(cpu / wall * 60, after[name][2], growth)
            found[name, phase] = Drive(pose_latencies(heard, record), commands, arrived, usage)
    for name, node in nodes.items():
        node.end(signal.SIGINT if is_driver(name) else signal.SIGKILL)
    return found


def pose_latencies(heard: List[Tuple[int, float]], record: Record) -> List[float]:
    """Return the times (ms) from each SIP to its Odometry.

    Both are counted, but they do not begin with the same number: no Odometry comes before its SIP. The offset is found
    anew for each second. Otherwise a single SIP that a node did not take would make all later ones look late.
    """
    sent, found = record.sent, []
    for _, second in itertools.groupby((each for each in heard if each[1] > sent[0] + 1.0), lambda each: int(each[1])):
        latest = [(number, now, bisect.bisect_right(sent, now) - 1) for number, now in second]
        offset = min(index - number for number, _, index in latest)
        found += [(now - sent[number + offset]) * 1000 for number, now, _ in latest]
    return found


def command_latencies(sent: List[Tuple[float, int]], record: Record) -> Tuple[List[float], float]:
    """Return the times (ms) from each command to the last byte of its RVEL on the wire, and the share of commands that
    arrived.
    """
    written = []    # time, mm/s
    decoder, speed = p2os.FrameDecoder(), None
    for now, data in record.heard:
        for command in map(p2os.decode_command, decoder.feed(data)):
            if command.name == "VEL":
                speed = command.value
            elif command.name == "RVEL":
                written.append((now, speed))
    times, at = [], 0
    for published, speed in sent:
        found = next((index for index in range(at, len(written)) if written[index][1] == speed and
                      written[index][0] > published), None)
        if found is not None and written[found][0] < published + 1.0:
            times.append((written[found][0] - published) * 1000)
            at = found + 1
    return times, len(times) / len(sent)


def start_times(bench: Bench, times: int) -> Dict[str, List[float]]:
    """Return the times (s) from the start of a process to its first Odometry: the floor; ours, robot waiting; ours,
    robot left open by a killed driver.
    """
    found: Dict[str, List[float]] = {"floor": [], "waiting": [], "left open": []}
    for _ in range(times):
        print("start", flush=True)
        node, seconds = bench.start("floor")
        found["floor"].append(seconds)
        node.end(signal.SIGKILL)
        node, seconds = bench.start("ours")
        found["waiting"].append(seconds)
        bench.until_driving()
        with bench.driving("ours"):
            time.sleep(1.0)
            node.end(signal.SIGKILL)
        node, seconds = bench.start("ours")
        found["left open"].append(seconds)
        node.end(signal.SIGINT)
    return found


def ends(bench: Bench, how: int, times: int) -> Tuple[List[float], List[float]]:
    """Send a signal to a driver that drives. Returns the times to a zero velocity on the wire (ms), and to its clean
    exit (s, infinite if not clean).
    """
    zeros, exits = [], []
    for _ in range(times):
        print(signal.Signals(how).name, flush=True)
        node, _ = bench.start("ours")
        bench.until_driving()
        with bench.driving("ours"):
            time.sleep(1.0)
            bench.robots["ours"].record()
            asked = monotonic()
            status = node.end(how)
            exits.append(monotonic() - asked if status == 0 else math.inf)
        record = bench.robots["ours"].record()
        commands = heard_after(asked, record)
        zeros.append(next(((now - asked) * 1000 for now, name, value in commands if name == "STOP" or
                           (name, value) == ("VEL", 0)), math.inf))
        if [name for _, name, _ in commands][-1:] != ["CLOSE"]:
            exits[-1] = math.inf
    return zeros, exits


def heard_after(then: float, record: Record) -> List[Tuple[float, str, Optional[int]]]:
    """Return the commands that a robot got after a time: when, name, value."""
    decoder = p2os.FrameDecoder()
    commands = [(now, command.name, command.value) for now, data in record.heard
                for command in map(p2os.decode_command, decoder.feed(data))]
    return [command for command in commands if command[0] > then]


# What is said of it

class Row(NamedTuple):
    """One limit."""

    what: str
    limit: str
    floor: str
    ours: str
    kept: bool


def share(values: Sequence[float], percent: float) -> float:
    """Return the value that `percent` % of the values do not exceed (nearest rank)."""
    ordered = sorted(values) or [math.nan]
    return ordered[max(0, math.ceil(len(ordered) * percent / 100) - 1)]


def median(values: Sequence[float]) -> float:
    return share(values, 50)


Rounds = Dict[Tuple[str, Phase], List[Drive]]
"""By node and phase: what was measured in each round."""


def typical(rounds: List[Drive], figure: Callable[[Drive], float]) -> float:
    """Return the median of a figure over the rounds."""
    return median([figure(each) for each in rounds])


def pooled(rounds: List[Drive], times: Callable[[Drive], List[float]]) -> List[float]:
    """Return the times of all rounds."""
    return [each for drive in rounds for each in times(drive)]


def rows(drives: Rounds, starts: Dict[str, List[float]],
         signals: Dict[str, Tuple[List[float], List[float]]]) -> List[Row]:
    """Return the limits, and whether each was kept."""
    def compared(what: str, phase: Phase, figure: Callable[[Drive], float], form: str, factor: float) -> Row:
        floor, ours = typical(drives["floor", phase], figure), typical(drives["ours", phase], figure)
        ratios = [figure(ours) / figure(floor) for ours, floor in zip(drives["ours", phase], drives["floor", phase])]
        return Row(what, "%g x floor" % factor, form % floor,
                   (form + " (%.2f x; %.2f to %.2f)") % (ours, ours / floor, min(ratios), max(ratios)),
                   ours <= factor * floor)

    def within(what: str, limit: float, form: str, ours: float, floor: str = "") -> Row:
        return Row(what, form % limit, floor, form % ours, ours <= limit)

    found = []
    for phase in (SLOW, FAST):
        what = "SIP to Odometry, %.0f ms cycle: " % (phase.cycle * 1000)
        found += [compared(what + "median", phase, lambda each: median(each.pose), "%.2f ms", 1.2),
                  within(what + "p99", 5.0, "%.2f ms", share(pooled(drives["ours", phase], lambda each: each.pose), 99),
                         "%.2f ms" % share(pooled(drives["floor", phase], lambda each: each.pose), 99))]
    for phase in (SLOW, MANY):
        what = "cmd_vel to wire, %g Hz: " % phase.rate
        arrived = {name: 100 * min(each.arrived for each in drives[name, phase]) for name in NODES}
        found += [compared(what + "median", phase, lambda each: median(each.command), "%.2f ms", 1.5),
                  Row(what + "commands that arrive", "100 %", "%.1f %%" % arrived["floor"], "%.1f %%" % arrived["ours"],
                      arrived["ours"] == 100)]
    found += [within("process start to first pose, robot waiting: worst", 1.0, "%.2f s", max(starts["waiting"]),
                     "%.2f s" % max(starts["floor"])),
              within("the same, robot left open by a killed driver: worst", 2.0, "%.2f s", max(starts["left open"]))]
    for name, (zeros, exits) in signals.items():
        found += [within("%s while driving to zero velocity on the wire: worst" % name, 50.0, "%.0f ms", max(zeros)),
                  within("%s to clean exit: worst" % name, 1.0, "%.2f s", max(exits))]
    cpu = [typical(drives[name, SLOW], lambda each: each.usage.cpu) for name in ("floor3", "ours")]
    growth = sum(drives["ours", phase][-1].usage.growth for phase in PHASES)
    return found + [
        compared("CPU a minute, 10 Hz, pose, sonar, tf subscribed", SLOW, lambda each: each.usage.cpu, "%.2f s", 1.9),
        Row("the same against three topics, for comparison", "-", "%.2f s" % cpu[0],
            "%.2f s (%.2f x)" % (cpu[1], cpu[1] / cpu[0]), True),
        compared("memory", MANY, lambda each: each.usage.rss, "%.1f MiB", 1.3),
        Row("growth of memory over all phases", "none (below 0.5 MiB)", "", "%.2f MiB" % growth, growth < 0.5),
    ]


def report(limits: List[Row], drives: Rounds, starts: Dict[str, List[float]],
           signals: Dict[str, Tuple[List[float], List[float]]], load: float) -> str:
    """Return the text of bench/driver.md."""
    lines = [
        "# What `bench/driver.py` measured", "",
        "Written by the program. Python %s, %d cores, load average %.1f before the start; %s s in each phase of "
        "driving, with all nodes"
        % (platform.python_version(), os.cpu_count() or 1, load, ", ".join("%.0f" % each for each in DRIVES)),
        "started anew before each; SIPs of %d bytes. Medians, CPU and memory: the median of these rounds. The floor is"
        % SIP_LENGTH,
        "`bench/relay_node.py`, measured at the same time. In brackets: the ratio of these medians, and the least and",
        "the greatest ratio of one round. On a machine that does other work too, figures are upper bounds.", "",
        "| what | limit | floor | ours | |", "|---|---|---|---|---|",
        *("| %s | %s | %s | %s | %s |" % (row[:4] + (
            "**exceeded**" if not row.kept else "" if row.limit == "-" else "kept",)) for row in limits), "",
        "| ms | node | n | median | p95 | p99 | worst |", "|---|---|---|---|---|---|---|",
    ]
    for what, of in (("SIP to Odometry", lambda each: each.pose), ("cmd_vel to wire", lambda each: each.command)):
        for phase in PHASES:
            for name in NODES:
                values = pooled(drives[name, phase], of)
                figures = (len(values), typical(drives[name, phase], lambda each: median(of(each))),
                           share(values, 95), share(values, 99), max(values, default=math.nan))
                lines.append("| %s; %s | %s | %d | %.2f | %.2f | %.2f | %.2f |" % (what, phase, name, *figures))
    lines += ["", "| driving | node | CPU, s a minute | memory, MiB | growth, MiB |", "|---|---|---|---|---|"]
    for phase in PHASES:
        for name in NODES:
            rounds = drives[name, phase]
            lines.append("| %s | %s | %.2f | %.1f | %.2f |" % (
                phase, name, typical(rounds, lambda each: each.usage.cpu), typical(rounds, lambda each: each.usage.rss),
                rounds[-1].usage.growth))
    lines += ["", "| once | n | median | worst |", "|---|---|---|---|"]
    once = [("start to first pose, %s (s)" % name, "%.2f", values) for name, values in starts.items()]
    for name, (zeros, exits) in signals.items():
        once += [("%s to zero velocity (ms)" % name, "%.1f", zeros), ("%s to exit (s)" % name, "%.2f", exits)]
    lines += ["| %s | %d | %s | %s |" % (what, len(values), form % median(values), form % max(values))
              for what, form, values in once]
    return "\n".join(lines) + "\n"


def pieces(seconds: float, load: float) -> str:
    """Return the text of bench/driver_pieces.md: medians of the floor, of the driver, and of the driver without each
    piece.
    """
    lines = [
        "# What each piece of driver/prompt.py gains", "",
        "Written by `bench/driver.py --pieces`. Python %s, %d cores, load average %.1f before the start;"
        % (platform.python_version(), os.cpu_count() or 1, load),
        "%d rounds of %.0f s in each phase, all nodes side by side. A cell is the median from SIP to Odometry in that"
        % (ROUNDS, seconds),
        "round, as a multiple of that of the whole driver (`ours`, in ms).",
        "", "| phase | round | ours, ms | %s |" % " | ".join(name for name in NODES if name != "ours"),
        "|---|---|---|%s" % ("---|" * (len(NODES) - 1))]
    bench = Bench()
    bench.connect()
    gains: Dict[str, List[float]] = {name: [] for name in NODES}
    for number in range(1, ROUNDS + 1):
        drives = drive(bench, seconds)
        for phase in PHASES:
            medians = {name: median(drives[name, phase].pose) for name in NODES}
            for name in NODES:
                gains[name].append(medians[name] / medians["ours"])
            lines.append("| %s | %d | %.3f | %s |" % (phase, number, medians["ours"], " | ".join(
                "%.2f" % gains[name][-1] for name in NODES if name != "ours")))
    lines += ["| median of all | | | %s |" % " | ".join(
        "%.2f" % median(gains[name]) for name in NODES if name != "ours"), "",
        "A piece that gains less than 0.05 goes. So went giving way after each message (sched_yield): 0.94 to 1.02",
        "without it. Telling the pose before the rest of its packet was read gained 0.28 (100 ms) and 0.23 (20 ms),",
        "and went all the same: each SIP was decoded twice for it."]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Measure, print, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true",
                        help="10 s of each phase, each start and end twice; writes no file")
    parser.add_argument("--pieces", action="store_true",
                        help="only the driver with and without each piece of driver/prompt.py")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    if options.pieces:
        NODES.update(PIECES)
        with master():
            text = pieces(PIECES_DRIVE, load)
        print(text)
        with open(PIECES_RESULTS, "w", encoding="utf-8") as file:
            file.write(text)
        return 0
    with master():
        bench = Bench()
        bench.connect()
        rounds = [drive(bench, seconds) for seconds in ((10.0,) if options.quick else DRIVES)]
        drives = {key: [each[key] for each in rounds] for key in rounds[0]}
        times = 2 if options.quick else 5
        starts = start_times(bench, times)
        signals = {number.name: ends(bench, number, times) for number in (signal.SIGINT, signal.SIGTERM)}
    limits = rows(drives, starts, signals)
    text = report(limits, drives, starts, signals, load)
    print(text)
    if not options.quick:
        with open(RESULTS, "w", encoding="utf-8") as file:
            file.write(text)
    return int(not all(row.kept for row in limits))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""What recording a robot costs: processor time of the recorder and of the driver beside it, and the size of the bag,
by what is recorded and how.

    ./pioneer shell /usr/bin/python3 bench/recording.py            # ten minutes; writes bench/recording.md
    ./pioneer shell /usr/bin/python3 bench/recording.py --quick    # two minutes; writes nothing

A simulated robot drives circles, told so ten times a second; a ROS master of its own. One recorder after the other
records it, each twice, the second time in the opposite order. What all are compared with is in the same run: `rosbag
record -a`, everything and uncompressed. Processor time (of user and kernel) is what the processes themselves took;
another load on the machine makes it somewhat larger, for all alike.
"""

import argparse
import contextlib
import os
import platform
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from time import monotonic
from typing import Dict, Iterator, List, NamedTuple, Optional, Tuple

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import SetBool

from pioneer_control.bags.reader import read_bag
from pioneer_control.bags.recording.plan import MB
from pioneer_control.bags.recording.topics import load_list, topics_of

HERE = os.path.dirname(os.path.abspath(__file__))
RESULTS = os.path.join(HERE, "recording.md")
NODES = os.path.join(HERE, "..", "nodes")
ROBOT = "pioneer"
SETTLE = 4.0
"""s from the start of a recorder in which it connects; not measured."""
PATIENCE = 20.0
EVERYDAY = topics_of(load_list(), [ROBOT])


class Way(NamedTuple):
    """One way to record. `command` is without the bag. None records nothing."""

    name: str
    command: Optional[Tuple[str, ...]]
    wire: bool = False
    """with a driver that publishes the wire"""


def ours(*options: str) -> Tuple[str, ...]:
    return (sys.executable, os.path.join(NODES, "record"), ROBOT, *options, "--bag")


def plain(*options: str) -> Tuple[str, ...]:
    return ("rosrun", "rosbag", "record", *options, "-O")


REFERENCE = Way("everything, uncompressed: `rosbag record -a`", plain("-a"))
NOBODY, NOBODY_WIRE = Way("no recorder", None), Way("no recorder, `publish_wire` on", None, True)
WAYS = (
    NOBODY,
    REFERENCE,
    Way("everyday, lz4: `record.launch`", ours()),
    Way("everyday, bz2", ours("--compression=bz2")),
    Way("everyday, uncompressed", ours("--compression=none")),
    Way("everyday and `also:=packets`, lz4", ours("--also=packets")),
    Way("everyday and `also:=rviz`, lz4", ours("--also=rviz")),
    NOBODY_WIRE,
    Way("everyday and `also:=wire`, lz4", ours("--also=wire"), True),
)


CHUNKS = 64, 768
"""kB that are compressed together: ours, and rosbag's own."""
SHORT, LONG = 15.0, 105.0


class Cost(NamedTuple):
    """The cost of one way: processor time (s a minute), and file size (MB an hour)."""

    recorder: float
    attendant: float
    driver: float
    size: float


def cpu(process: int) -> float:
    """Return the processor time (s) of a process so far."""
    with open("/proc/%d/stat" % process) as stat:
        fields = stat.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children(process: int) -> List[int]:
    """Return the processes that a process has started."""
    with open("/proc/%d/task/%d/children" % (process, process)) as file:
        return [int(word) for word in file.read().split()]


def until(what: str, condition) -> None:
    """Wait until a condition holds."""
    end = monotonic() + PATIENCE
    while not condition():
        if monotonic() > end:
            raise SystemExit("not within %.0f s: %s" % (PATIENCE, what))
        time.sleep(0.05)


@contextlib.contextmanager
def running(*command: str) -> Iterator[subprocess.Popen]:
    """Run a program. At the end it gets Ctrl-C, or is killed if that has no effect."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        yield process
    finally:
        for how in signal.SIGINT, signal.SIGKILL:
            with contextlib.suppress(ProcessLookupError, subprocess.TimeoutExpired):
                os.killpg(process.pid, how)
                process.wait(PATIENCE)
                break


@contextlib.contextmanager
def master() -> Iterator[None]:
    """Run a ROS master of our own, and what belongs to it."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % port, ROS_HOSTNAME="localhost")
    # where SIGINT is ignored, as in the background, it ends with force
    with running("rosmaster", "--core", "-p", str(port)):
        until("a master", rosgraph.is_master_online)
        with running("rosrun", "rosout", "rosout"):
            yield


@contextlib.contextmanager
def robot(folder: str, wire: bool) -> Iterator[int]:
    """Run a simulated robot and its driver, which drives circles. Gives the driver's process."""
    line = os.path.join(folder, "line")
    namespace = "__ns:=/" + ROBOT
    ended = threading.Event()

    def command() -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = 0.2, 0.5
        while not ended.wait(0.1):
            publisher.publish(twist)

    simulator = sys.executable, os.path.join(
        NODES, "p2os_simulator"), namespace, "__name:=simulator", "_pty:=" + line, "_world:=tutorial"
    driver = sys.executable, os.path.join(
        NODES, "p2os_driver"), namespace, "__name:=p2os", "_port:=" + line, "_publish_wire:=%s" % str(wire).lower()
    with running(*simulator), running(*driver) as process:
        publisher = rospy.Publisher("/%s/cmd_vel" % ROBOT, Twist, queue_size=1)
        rospy.wait_for_service("/%s/set_motors" % ROBOT, PATIENCE)
        until("motors on", lambda: rospy.ServiceProxy("/%s/set_motors" % ROBOT, SetBool)(True).success)
        commander = threading.Thread(target=command)
        commander.start()
        try:
            time.sleep(3.0)
            yield process.pid
        finally:
            ended.set()
            commander.join()


def growth(path: str, seconds: float) -> float:
    """Return how fast (MB an hour) a file grows, between the first and the last growth within so many seconds.

    The file grows by whole chunks, so the chunks must be small.
    """
    seen: List[Tuple[float, int]] = []
    end = monotonic() + seconds
    while monotonic() < end:
        size = os.path.getsize(path) if path and os.path.exists(path) else 0
        if not seen or size != seen[-1][1]:
            seen.append((monotonic(), size))
        time.sleep(0.05)
    (first, small), (last, large) = seen[min(1, len(seen) - 1)], seen[-1]
    return (large - small) / MB / (last - first) * 3600 if last > first else 0.0


def measure(way: Way, folder: str, driver: int, seconds: float) -> Cost:
    """Measure one recorder, for so many seconds after it has settled."""
    if way.command is None:
        before, start = cpu(driver), monotonic()
        time.sleep(seconds)
        return Cost(0.0, 0.0, (cpu(driver) - before) / (monotonic() - start) * 60, 0.0)
    bag = tempfile.mktemp(suffix=".bag", dir=folder)
    with running(*way.command, bag) as recorder:
        time.sleep(SETTLE)
        processes = [recorder.pid, driver, *children(recorder.pid)]
        before, start = [cpu(process) for process in processes], monotonic()
        size = growth(bag + ".active", seconds)
        used = [(cpu(process) - old) / (monotonic() - start) * 60 for process, old in zip(processes, before)]
    os.remove(bag)
    return Cost(used[0], sum(used[2:]), used[1], size)


def chunks(folder: str) -> Dict[int, Tuple[float, float]]:
    """Measure each size of a chunk.

    Returns: By kB of a chunk: MB an hour, and the seconds that kill -9 loses. The MB an hour are the difference of two
    bags of different lengths, so that what every bag has does not count.
    """
    with contextlib.ExitStack() as long:
        with contextlib.ExitStack() as short:
            def start(stack: contextlib.ExitStack, name: str, size: int) -> subprocess.Popen:
                command = plain("--lz4", "--tcpnodelay", "--chunksize=%d" % size, *EVERYDAY)
                path = os.path.join(folder, "%s_%d.bag" % (name, size))
                return stack.enter_context(running(*command, path, "__name:=%s_%d" % (name, size)))

            killed = {size: start(long, "killed", size) for size in CHUNKS}
            for size in CHUNKS:
                start(short, "short", size)
                start(long, "long", size)
            time.sleep(SHORT)
        time.sleep(LONG - SHORT)
        for process in killed.values():
            process.kill()
        end = time.time()
    sizes = {size: [os.path.getsize(os.path.join(folder, "%s_%d.bag" % (name, size))) for name in ("short", "long")]
             for size in CHUNKS}
    left = {size: read_bag(os.path.join(folder, "killed_%d.bag.active" % size)) for size in CHUNKS}
    last = {size: max((message.time for message in messages), default=0) for size, messages in left.items()}
    return {size: ((sizes[size][1] - sizes[size][0]) / MB / (LONG - SHORT) * 3600, end - last[size] / 1e9)
            for size in CHUNKS}


def report(costs: Dict[Way, Cost], chunked: Dict[int, Tuple[float, float]], seconds: float, load: float) -> str:
    """The text of bench/recording.md."""
    reference = costs[REFERENCE]
    lines = [
        "# What `bench/recording.py` measured", "",
        "Written by the program. Python %s, %d cores, load average %.1f before the start; %.0f s of each. A simulated "
        "p3dx-sh drives circles, with"
        % (platform.python_version(), os.cpu_count() or 1, load, seconds),
        "ten packets and ten commands a second; everyday is what `record.launch` keeps, "
        "[config/record.yaml](../config/record.yaml). Ratios are to",
        "`rosbag record -a` of the same run. The attendant publishes the recording's description.",
        "",
        "| recorded | bag, MB an hour | | recorder, s of CPU a minute | | attendant, s a minute | driver, s a minute "
        "| more than with no recorder |",
        "|---|---|---|---|---|---|---|---|"]
    for way in WAYS:
        cost, alone = costs[way], costs[NOBODY_WIRE if way.wire else NOBODY]
        if way.command is None:
            lines.append("| %s | | | | | | %.2f | |" % (way.name, cost.driver))
        else:
            lines.append("| %s | %.1f | %.2f x | %.2f | %.2f x | %s | %.2f | %+.2f |" % (
                way.name, cost.size, cost.size / reference.size, cost.recorder, cost.recorder / reference.recorder,
                "%.2f" % cost.attendant if sys.executable in way.command else "", cost.driver,
                cost.driver - alone.driver))
    if chunked:
        lines += ["", "| everyday, lz4, in chunks of | bag, MB an hour | lost at the end by `kill -9`, this time |",
                  "|---|---|---|"]
        lines += ["| %d kB%s | %.1f | %.1f s |" % (size, "" if size == CHUNKS[0] else ", rosbag's own", *chunked[size])
                  for size in CHUNKS]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure, print, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="5 s of each, once; writes no file")
    quick = parser.parse_args().quick
    seconds, rounds, load = 5.0 if quick else 20.0, 1 if quick else 2, os.getloadavg()[0]
    found: Dict[Way, List[Cost]] = {way: [] for way in WAYS}
    with master(), tempfile.TemporaryDirectory() as folder:
        rospy.init_node("bench", disable_signals=True)
        for wire in (False, True):
            with robot(folder, wire) as driver:
                ways = [way for way in WAYS if way.wire == wire]
                for way in (ways + ways[::-1])[:rounds * len(ways)]:
                    found[way].append(measure(way, folder, driver, seconds))
                    print("%s: %s" % (way.name, found[way][-1]), flush=True)
        with robot(folder, False):
            chunked = {} if quick else chunks(folder)
    costs = {way: Cost(*(sum(values) / len(values) for values in zip(*each))) for way, each in found.items()}
    text = report(costs, chunked, seconds * rounds, load)
    print(text)
    if not quick:
        with open(RESULTS, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()

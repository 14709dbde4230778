#!/usr/bin/python3
"""Drives a robot for a day with a fault every few seconds. Does memory grow? Does anything go wrong?

    python3 bench/soak.py               # 24 simulated hours, a session and a simulated robot, as fast as they go
    python3 bench/soak.py --hours 1 --seed 7
    python3 bench/soak.py --real 60     # 60 real minutes: both nodes, a master of their own, a bad line that is cut

A line per simulated hour (or real minute) shows what was done and what the process holds. Exit status 1 when something
was wrong, or memory, threads or file descriptors grew after the first tenth. bench/soak.md has the measurements.
"""

import argparse
import contextlib
import gc
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional

from faulty_link import STEP, Rig, Velocity, lost

HERE = os.path.dirname(os.path.abspath(__file__))
RECOVERY = 15.0         # simulated s after its repair, at most, until the link is ready again
GROWTH = 1.05           # factor by which memory may exceed that after the first tenth
PAUSE = 3.0             # simulated s after a fault; from then on a stop must arrive at once


# 24 hours in simulated time

def lose(share: float) -> Callable[[Rig], None]:
    """Lose this share of the packets in both directions."""
    def begin(rig: Rig) -> None:
        rig.to_robot.fault = rig.to_client.fault = lambda packet: (packet,) if rig.chance.random() >= share else ()
    return begin


def spoil(rig: Rig) -> None:
    """Change, drop or add one byte of many packets."""
    def fault(packet: bytes) -> List[bytes]:
        at, kind = rig.chance.randrange(len(packet)), rig.chance.randrange(8)
        if kind == 0:
            return [packet[:at] + bytes([packet[at] ^ 1 << rig.chance.randrange(8)]) + packet[at + 1:]]
        if kind == 1:
            return [packet[:at] + packet[at + 1:]]
        if kind == 2:
            return [packet[:at] + bytes([rig.chance.choice((0, 0x32, 0xFA, 0xFB, 0xFF))]) + packet[at:]]
        if kind == 3:
            return [packet[:at], packet[at:]]
        return [packet]
    rig.to_robot.fault = rig.to_client.fault = fault


def silence(rig: Rig) -> None:
    """Let nothing pass, in one direction or in both."""
    which = rig.chance.randrange(3)
    if which != 0:
        rig.to_robot.fault = lost
    if which != 1:
        rig.to_client.fault = lost


def late(rig: Rig) -> None:
    """Delay everything."""
    rig.to_robot.delay = rig.to_client.delay = 0.2


def pull(rig: Rig) -> None:
    """Pull the cable."""
    if rig.session is not None:
        rig.pull()
    rig.plugged = False


def press(rig: Rig) -> None:
    """Press the STOP button."""
    rig.firmware.press_stop_button(True)


FAULTS: Dict[str, Callable[[Rig], None]] = {
    "1 % lost": lose(0.01), "20 % lost": lose(0.2), "50 % lost": lose(0.5), "spoilt": spoil, "silence": silence,
    "late": late, "pulled": pull,
    "restart": lambda rig: rig.firmware.restart(), "power cycle": lambda rig: rig.firmware.close_session(),
    "killed": lambda rig: rig.kill(rig.chance.uniform(0.0, 5.0)), "STOP button": press,
}


class Day:
    """A user who drives again and again, and the faults that happen to the robot and its line."""

    def __init__(self, seed: int, baud: Optional[int]) -> None:
        self.rig = Rig(baud=(baud, baud) if baud else None, seed=seed)
        self.chance = random.Random(seed + 1)
        self.faults: Dict[str, int] = dict.fromkeys(FAULTS, 0)
        self.reconnects = self.commands = 0

    def live(self, hours: float) -> None:
        """Again and again: drive a while, begin a fault, end it, and check that the robot recovers."""
        rig, end = self.rig, self.rig.now + 3600 * hours
        while rig.now < end:
            for _ in range(self.chance.randrange(1, 6)):
                self.drive()
            name = self.chance.choice(sorted(FAULTS))
            self.faults[name] += 1
            rig.judge.lossy, rig.judge.late = True, 0.3
            FAULTS[name](rig)
            for _ in range(self.chance.randrange(1, 4)):
                self.drive()
            rig.mend()
            rig.firmware.press_stop_button(False)
            rig.firmware.hardware.battery.pretend(12.8)     # it stays charged; a restart forgets that
            try:
                rig.run_until(lambda: rig.ready, RECOVERY)
            except AssertionError as error:
                rig.judge.wrong("no recovery from %r: %s" % (name, error))
            rig.commanding = None
            rig.run(PAUSE)
            rig.judge.lossy, rig.judge.late = False, 0.0

    def drive(self) -> None:
        """Command a random velocity, or none, at a random rate for a random time."""
        rig, chance = self.rig, self.chance
        if rig.ready and rig.state is not None and not rig.state.motors_enabled:
            rig.request_motors(True)
        velocity = Velocity(chance.uniform(-0.5, 0.5), chance.uniform(-1.0, 1.0))
        rig.commanding = chance.choice((None, Velocity(0.0, 0.0), *[velocity] * 4))
        rig.commands_per_step = chance.choice((1.5, 10, 10, 10, 100)) * STEP
        rig.run(chance.choice((0.2, 1.0, 3.0, 8.0)))


def resident_kb(process: int) -> int:
    """Resident memory of a process."""
    with open("/proc/%d/status" % process) as status:
        return int(next(line for line in status if line.startswith("VmRSS")).split()[1])


def grown(values: List[int]) -> bool:
    """Return whether the last values exceed those after the first tenth."""
    begin = len(values) // 10
    return max(values[-max(1, len(values) // 10):]) > GROWTH * max(values[begin:begin + max(1, len(values) // 5)])


def soak(hours: float, seed: int, baud: Optional[int]) -> int:
    """Soak session and robot in this process, in simulated time. Returns the exit status."""
    day, start, memory, objects = Day(seed, baud), time.monotonic(), [], []
    slices = max(10, round(hours))
    print("%6s %7s %9s %8s %9s %7s %9s %9s %9s %8s %8s %7s" % (
        "hour", "real s", "states", "faults", "km", "turns", "bad sums", "stray B", "unread", "RSS kB", "objects",
        "wrong"))
    for number in range(slices):
        day.live(hours / slices)
        gc.collect()
        memory.append(resident_kb(os.getpid()))
        objects.append(len(gc.get_objects()))
        counts, judge = day.rig.counts, day.rig.judge
        print("%6.1f %7.0f %9d %8d %9.2f %7d %9d %9d %9d %8d %8d %7d" % (
            day.rig.now / 3600, time.monotonic() - start, day.rig.states, sum(day.faults.values()),
            judge.distance / 1000,
            judge.turned / 6.2832, counts.bad_checksums, counts.discarded_bytes, counts.unreadable, memory[-1],
            objects[-1],
            len(judge.wrongs)), flush=True)
    print("faults: %s" % ", ".join("%d %s" % (count, name) for name, count in day.faults.items()))
    for wrong in day.rig.judge.wrongs:
        print("WRONG", wrong)
    growing = [name for name, values in (("memory", memory), ("objects", objects)) if grown(values)]
    print("grew: %s" % (", ".join(growing) or "nothing"))
    return int(bool(day.rig.judge.wrongs or growing))


# Real time, real nodes

class Node(NamedTuple):
    """A process that the soak observes."""

    name: str
    process: subprocess.Popen

    def holds(self) -> Dict[str, int]:
        """Its memory (kB), and the numbers of its threads and open files."""
        folder = "/proc/%d" % self.process.pid
        return {"kB": resident_kb(self.process.pid), "threads": len(os.listdir(folder + "/task")),
                "files": len(os.listdir(folder + "/fd"))}


@contextlib.contextmanager
def running(name: str, *command: str) -> Iterator[Node]:
    """Start a process, and interrupt it at the end."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            yield Node(name, process)
        finally:
            process.send_signal(signal.SIGINT)


def free_port() -> int:
    """A TCP port of this machine that nobody uses."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def node_program(name: str) -> str:
    """The file of a node. With rosrun we would watch rosrun instead of the node."""
    return os.path.join(HERE, "..", "nodes", name)


def wait_for(port: int) -> None:
    """Wait until a program listens at a port: a node needs its master to read its parameters."""
    while True:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        time.sleep(0.1)


def soak_real(minutes: float, seed: int) -> int:
    """Soak both nodes under a master, in real time. Returns the exit status."""
    sys.path.insert(0, os.path.join(HERE, "..", "test", "integration"))
    from client_lines import SpoiltLine
    master, port = free_port(), free_port()
    os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % master, ROS_HOSTNAME="127.0.0.1",
                      ROS_HOME=tempfile.mkdtemp(prefix="pioneer-soak"))
    with contextlib.ExitStack() as stack:
        stack.enter_context(running("master", "roscore", "-p", str(master)))
        wait_for(master)
        robot = running("simulator", "/usr/bin/python3", node_program("p2os_simulator"), "__ns:=soak", "_world:=empty",
                        "_tcp:=%d" % port)
        nodes = [stack.enter_context(robot)]
        wait_for(port)
        line = stack.enter_context(SpoiltLine(port, seed=seed))
        nodes.append(stack.enter_context(running(
            "driver", "/usr/bin/python3", node_program("p2os_driver"), "__ns:=soak", "_port:=%s" % line.url)))
        return watch(nodes, line, minutes, random.Random(seed))


def watch(nodes: List[Node], line, minutes: float, chance: random.Random) -> int:
    """Drive, spoil and cut the line, and print once a minute what the nodes hold. Returns the exit status."""
    import rospy
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    from std_srvs.srv import SetBool
    rospy.init_node("soak", disable_signals=True)
    poses: List[int] = [0]
    rospy.Subscriber("/soak/pose", Odometry, lambda pose: poses.__setitem__(0, poses[0] + 1))
    velocity = rospy.Publisher("/soak/cmd_vel", Twist, queue_size=1)
    motors = rospy.ServiceProxy("/soak/set_motors", SetBool)
    rospy.wait_for_service("/soak/set_motors")
    start, cuts, table = time.monotonic(), 0, {node.name: [] for node in nodes}
    usages = "   ".join("%s: kB, threads, files" % node.name for node in nodes)
    print("%6s %7s %7s %5s   %s" % ("minute", "poses", "spoilt", "cuts", usages))
    ended = threading.Event()
    while time.monotonic() - start < 60 * minutes:
        twist = Twist()
        twist.linear.x, twist.angular.z = chance.uniform(-0.4, 0.4), chance.uniform(-0.8, 0.8)
        line.spoil = chance.choice((0.0, 0.0, 0.01, 0.2, 0.5))
        for _ in range(chance.randrange(5, 100)):
            velocity.publish(twist)
            ended.wait(0.1)
        line.spoil = 0.0
        if chance.random() < 0.1:
            line.cut()
            cuts += 1
        with contextlib.suppress(rospy.ServiceException):
            motors(True)
        rows = len(table["driver"])
        if time.monotonic() - start >= 60 * (rows + 1):
            if any(node.process.poll() is not None for node in nodes):
                break
            for node in nodes:
                table[node.name].append(node.holds())
            print("%6d %7d %7d %5d   %s" % (rows + 1, poses[0], line.spoilt, cuts, "   ".join(
                "%6d %3d %3d" % tuple(table[node.name][-1].values()) for node in nodes)), flush=True)
    growing = ["%s of the %s" % (what, name) for name, rows in table.items() for what in (rows[0] if rows else ())
               if grown([row[what] for row in rows])]
    dead = [node.name for node in nodes if node.process.poll() is not None]
    print("grew: %s; died: %s" % (", ".join(growing) or "nothing", ", ".join(dead) or "nobody"))
    return int(bool(growing or dead))


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hours", type=float, default=24.0, help="simulated (default: %(default)s)")
    parser.add_argument("--baud", type=int, help="line speed (default: TCP)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--real", type=float, metavar="MINUTES", help="the real nodes, in real time")
    options = parser.parse_args()
    return soak_real(options.real, options.seed) if options.real else soak(options.hours, options.seed, options.baud)


if __name__ == "__main__":
    sys.exit(main())

"""Many robots that navigate in one world at real time: what share of it is kept, and which programs take how much.

    ./pioneer shell python3 bench/navigation_many.py --robots 5 10 30 --seconds 60

One simulator serves all robots. Each robot has its own driver and its own navigation, as with ``navigate.launch``, and
drives from one place drawn by chance to the next. *Handled* is the share of sonar packets due that navigation answered;
*late* is how long after its packet an answer was heard here. Processor time is that of all processes of a kind.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool

from pioneer_control.msg import Navigation  # before the modules of the bench, which look for the sources alone
from pioneer_control.floor_poses import Pose
from pioneer_control.maps.grid_map import GridMap
from pioneer_control.navigation.node.map_files import load_floor_map
from pioneer_control.navigation.node.messages import header_of, pose_message

from navigation_wire import Truth, end, ros_master, until

CYCLE = 0.1     # s, between two packets of a robot
ROOM = 0.45     # m, from a goal to the next wall
SETTLING = 15.0     # s of driving before it is measured
TICKS = os.sysconf("SC_CLK_TCK")
NODES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "nodes")


class Robot:
    """One robot, with its driver and its navigation. It gets a new goal whenever it has none."""

    def __init__(self, number: int, url: str, start, goals, log) -> None:
        self.name, self._goals, self._luck = "robot%d" % number, goals, random.Random(number)
        self.late, self.states, self._sent_at, self.state = [], Counter(), 0.0, ""
        place = ["__ns:=" + self.name, "_frame_prefix:=" + self.name + "/"]
        self._driver = [os.path.join(NODES, "p2os_driver"), "_port:=" + url, "__name:=p2os", *place]
        self._navigation = [
            os.path.join(NODES, "navigate"), "__name:=navigation", "_map:=" + goals.world, "_seed:=%d" % number,
            "_initial_pose:=[%f, %f, %f]" % tuple(start), *place]
        self._log, self.processes = log, {}

    def start(self) -> None:
        """Start driver and navigation, and switch the motors on."""
        for kind, command in (("driver", self._driver), ("navigation", self._navigation)):
            self.processes[kind] = subprocess.Popen(command, stdout=self._log, stderr=self._log)
        rospy.wait_for_service(self.name + "/set_motors", 60.0)
        motors = rospy.ServiceProxy(self.name + "/set_motors", SetBool)
        until("motors are on", lambda: motors(True).success)
        self._goal = rospy.Publisher(self.name + "/move_base_simple/goal", PoseStamped, queue_size=1)
        rospy.Subscriber(self.name + "/navigation", Navigation, self._hear, queue_size=10, tcp_nodelay=True)
        until("navigation", lambda: self.states and self._goal.get_num_connections())

    def _hear(self, message) -> None:
        self.late.append(time.time() - message.header.stamp.to_sec())
        self.state = message.state
        self.states[message.state] += 1

    def keep_going(self) -> None:
        """Send a new goal, if it has none."""
        if self.state not in ("driving", "waiting") and time.monotonic() > self._sent_at + 1.0:
            self._sent_at = time.monotonic()
            goal = pose_message(self._goals.one(self._luck))
            self._goal.publish(PoseStamped(header_of("map", rospy.Time.now()), goal))


class Goals:
    """Places of a world where a robot can stand."""

    def __init__(self, world: str) -> None:
        self.world = world
        self._grid: GridMap = load_floor_map(world).grid
        free = self._grid.cells == 0
        near = int(ROOM / self._grid.resolution)
        for axis in (0, 1):
            free = np.all([np.roll(free, shift, axis) for shift in range(-near, near + 1)], axis=0)
        self._squares = np.argwhere(free)

    def one(self, luck: random.Random) -> Pose:
        """Return one of them."""
        row, column = luck.choice(self._squares)
        x, y = self._grid.middle(row, column)
        return Pose(float(x), float(y), luck.uniform(-3.1, 3.1))


def processor_seconds(pid: int) -> float:
    """Return the processor time (s) that a process took until now."""
    with open("/proc/%d/stat" % pid, encoding="ascii") as stat:
        fields = stat.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def memory(pid: int) -> float:
    """Return the memory (MB) of a process that no other has."""
    with open("/proc/%d/smaps_rollup" % pid, encoding="ascii") as rollup:
        return sum(int(line.split()[1]) for line in rollup if line.startswith("Private")) / 1024


def measure(count: int, options, folder: str) -> None:
    """Print what so many robots take."""
    path, log = os.path.join(folder, "truth-%d" % count), open(os.path.join(folder, "log-%d" % count), "w")
    simulator = subprocess.Popen(
        [sys.executable, "-m", "pioneer_control.simulator", "--world", options.world, "--robots", str(count), "--real",
         "--tcp", "0", "--truth", path], stdout=log, stderr=log)
    robots = []
    try:
        until("the simulator's truth", lambda: os.path.exists(path))
        truth = Truth(path)
        until("the world", lambda: truth.state)
        goals = Goals(options.world)
        for number in range(count):
            pose = truth.state["robots"][number][:3]
            robots.append(Robot(number + 1, truth.world["robots"][number]["url"], pose, goals, log))
            robots[-1].start()
        kinds = {"simulator": [simulator.pid]}
        for kind in ("driver", "navigation"):
            kinds[kind] = [robot.processes[kind].pid for robot in robots]
        keep_going(robots, SETTLING)
        for robot in robots:
            robot.late.clear()
            robot.states.clear()
        contacts = sum(truth.state["contacts"])
        simulated, began = truth.state["time"], time.monotonic()
        before = {kind: sum(map(processor_seconds, pids)) for kind, pids in kinds.items()}
        own, idle = time.process_time(), idle_seconds()
        keep_going(robots, options.seconds)
        took, simulated = time.monotonic() - began, truth.state["time"] - simulated
        states = sum((robot.states for robot in robots), Counter())
        late = np.concatenate([robot.late for robot in robots]) if states else [np.nan]
        print("%d robots in %s, %.0f s: simulated / real time %.3f; handled %.1f %% of packets; late %.0f ms (median), "
              "%.0f ms (95 %%), %.0f ms (99.9 %%); %d contacts; of the time %s" % (
                  count, options.world, took, simulated / took, 100 * sum(states.values()) * CYCLE / took / count,
                  *(1000 * np.percentile(late, [50, 95, 99.9])), sum(truth.state["contacts"]) - contacts,
                  ", ".join("%.0f %% %s" % (100 * share / sum(states.values()), state)
                            for state, share in states.most_common())))
        print("  processor time, of one core: %s; bench %.0f %%; idle %.0f %% of all cores; memory: %s" % (
            ", ".join("%s %.0f %%" % (kind, 100 * (sum(map(processor_seconds, pids)) - before[kind]) / took)
                      for kind, pids in kinds.items()), 100 * (time.process_time() - own) / took,
            100 * (idle_seconds() - idle) / took,
            ", ".join("%s %.0f MB" % (kind, sum(map(memory, pids)) / len(pids)) for kind, pids in kinds.items())),
            flush=True)
    finally:
        processes = [process for robot in robots for process in robot.processes.values()]
        for process in processes:
            process.send_signal(signal.SIGINT)
        for process in [*processes, simulator]:
            end(process)


def keep_going(robots, seconds: float) -> None:
    """Let all robots drive for a time (s)."""
    until_then = time.monotonic() + seconds
    while time.monotonic() < until_then:
        for robot in robots:
            robot.keep_going()
        time.sleep(0.2)


def idle_seconds() -> float:
    """Return for how long (s) all cores together were idle until now."""
    with open("/proc/stat", encoding="ascii") as stat:
        fields = stat.readline().split()
    return (int(fields[4]) + int(fields[5])) / TICKS / os.cpu_count()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=[5, 10, 30])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--world", default="classroom")
    options = parser.parse_args()
    with ros_master("navigation_many") as folder:
        for count in options.robots:
            measure(count, options, folder)


if __name__ == "__main__":
    main()

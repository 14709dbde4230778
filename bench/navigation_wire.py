"""Drives to goals as a user has it: simulator, driver and navigation are processes of their own, in real time.

    ./pioneer shell python3 bench/navigation_wire.py --seeds 1000-1004 --goals 5 --walkers 1

Each seed is the world, the robot and the goals of the part "drive" of bench/navigation.py; its simulator is started
from the command line, and ``navigate.launch port:=...`` joins it over TCP. Goals go to move_base's action. What is true
comes from the simulator's own socket, which ROS does not see.

With ``--faults`` the robot drives between two places of the office, and each kind of fault hits it on the way.
"""

import argparse
import contextlib
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from typing import Iterator

import actionlib
import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from geometry_msgs.msg import Pose as PoseMessage
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import Header
from std_srvs.srv import SetBool

from pioneer_control.msg import Navigation  # before the modules of the bench, which look for the sources alone
from pioneer_control.floor_poses import wrapped

from navigation_cases import case, seeds_of
from navigation_drive import prepared

PATIENCE = 60.0  # s, for what should happen at once
LONGEST = 300.0  # s, for one goal
WRONG = 0.5  # m: a robot that is sure is wrong when it is farther off
FAULT_TIME = 8.0  # s, how long a fault lasts
FAULTS = ("loss 0.2", "loss 0.6", "flips 0.01", "splits 0.5", "delay 0.3", "delay 2", "silence", "cable", "power",
          "stop_button", "stall", "battery 10.5", "transducer 3", "gyro 20", "gripper", "charger", "carry 9.0 6.0 90")


class Truth:
    """The world, and what the simulator last said is true of it."""

    def __init__(self, path: str) -> None:
        self.world, self.state = None, None
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.connect(path)
        threading.Thread(target=self._read, daemon=True).start()

    def order(self, **order) -> None:
        """Give an order: docs/simulator.md has them all."""
        self._socket.sendall(json.dumps(order).encode() + b"\n")

    def _read(self) -> None:
        for line in self._socket.makefile(encoding="utf-8"):
            message = json.loads(line)
            self.world = message.get("world", self.world)
            if "truth" in message:
                self.state = message["truth"]

    @property
    def pose(self):
        """x, y (m), heading (rad)."""
        return self.state["robots"][0][:3]


def until(what: str, condition):
    """Wait for a condition. Raises RuntimeError that names what did not happen."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError("not within %.0f s: %s" % (PATIENCE, what))
        time.sleep(0.05)


def end(process: subprocess.Popen) -> None:
    """End a process as Ctrl-C does."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(30.0)
    except subprocess.TimeoutExpired:
        process.kill()


@contextlib.contextmanager
def ros_master(node: str) -> Iterator[str]:
    """Run a roscore on a free port for a ``with`` block. The block gets a folder for logs; it is the node `node`."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port = probe.getsockname()[1]
    os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % port
    folder = tempfile.mkdtemp(prefix=node + "-")
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until("a master", lambda: not subprocess.call(["rosparam", "list"], stdout=subprocess.DEVNULL,
                                                      stderr=subprocess.DEVNULL))
        rospy.init_node(node, disable_signals=True)
        yield folder
    finally:
        end(core)
        print("logs: " + folder)


class Run:
    """A simulated robot that navigates, in processes of their own, and what it says."""

    def __init__(self, seed: int, world: str, model: str, options, folder: str) -> None:
        self.name = "%d %s %s" % (seed, world, model)
        self.said, self.told = None, []
        self._listener, self._processes = None, []
        path = os.path.join(folder, "truth-%d" % seed)
        self._start([sys.executable, "-m", "pioneer_control.simulator", "--world", world, "--model", model, "--real",
                     "--seed", str(seed), "--unmapped", str(seed % 4), "--walkers", str(options.walkers), "--tcp", "0",
                     "--truth", path], os.devnull)
        try:
            until("the simulator's truth", lambda: os.path.exists(path))
            self.truth = Truth(path)
            until("the world", lambda: self.truth.state)
            self._start(["roslaunch", "pioneer_control", "navigate.launch", "map:=" + world, "start:=home",
                         "port:=" + self.truth.world["robots"][0]["url"]], os.path.join(folder, "launch-%d.log" % seed))
            self._listener = rospy.Subscriber("pioneer/navigation", Navigation, self._hear)
            self._client = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
            until("move_base's action", lambda: self._client.wait_for_server(rospy.Duration(1)))
            rospy.wait_for_service("pioneer/set_motors", PATIENCE)
            self.set_motors_on()
        except BaseException:
            self.end()
            raise

    def _start(self, command, log: str) -> None:
        with open(log, "w", encoding="utf-8") as stream:
            self._processes.append(subprocess.Popen(command, stdout=stream, stderr=subprocess.STDOUT))

    def end(self) -> None:
        """End the processes, the last one first."""
        if self._listener is not None:
            self._listener.unregister()
        for process in reversed(self._processes):
            end(process)

    def set_motors_on(self) -> None:
        """Switch the motors on, as soon as the driver can."""
        motors = rospy.ServiceProxy("pioneer/set_motors", SetBool)
        until("motors are on", lambda: motors(True).success)

    def drive_all(self, goals) -> None:
        """Drive to goals, one after the other."""
        for number, goal in enumerate(goals):
            self._drive(number, goal)
        print("%s: wrong while sure %.1f s at most" % (self.name, self._longest_wrong()), flush=True)

    def drive_with_fault(self, fault: str, goal) -> None:
        """Drive to a goal, and let a fault begin when it drives. Print when it stood, why, and whether it arrived."""
        self.send(goal)
        until("it drives", lambda: abs(self.truth.state["robots"][0][3]) > 0.25)
        began, contacts = time.monotonic(), self.truth.state["contacts"][0]
        self.truth.order(order="add_fault", fault="%s to %.3f" % (fault, self.truth.state["time"] + FAULT_TIME))
        stood, reasons = None, {}
        while time.monotonic() < began + FAULT_TIME:
            if stood is None and abs(self.truth.state["robots"][0][3]) < 0.001:
                stood = time.monotonic() - began
            words = self.said.reason
            if not words.endswith("to go"):
                reasons.setdefault(re.sub(r"\d[\d.]*", "", words), words)   # the first of those alike but for numbers
            time.sleep(0.02)
        self.truth.order(order="clear_faults")
        self.set_motors_on()
        for again in range(3):
            if self._client.wait_for_result(rospy.Duration(LONGEST)) and (
                    self._client.get_state() == GoalStatus.SUCCEEDED):
                break
            reasons[again] = "goal ended: " + self._client.get_goal_status_text()
            self.send(goal)
        else:
            again = "NOT"
        print("| `%s` | %s | %s | %s | %d |" % (
            fault, "drives on" if stood is None else "stands after %.1f s" % stood, "; ".join(reasons.values()),
            {0: "arrives", "NOT": "does NOT arrive"}.get(again, "arrives, sent again"),
            self.truth.state["contacts"][0] - contacts), flush=True)

    def send(self, goal) -> None:
        """Send a goal (x, y in m, heading in rad)."""
        x, y, heading = goal
        self._client.send_goal(MoveBaseGoal(PoseStamped(Header(frame_id="map", stamp=rospy.Time.now()), PoseMessage(
            Point(x, y, 0.0), Quaternion(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))))))

    def _hear(self, message) -> None:
        self.said = message
        state = self.truth.state
        if state:
            x, y, _ = self.truth.pose
            self.told.append((time.monotonic(), message.sure, math.hypot(message.pose.x - x, message.pose.y - y)))

    def _longest_wrong(self) -> float:
        longest, since = 0.0, None
        for when, sure, off in self.told:
            since = (since or when) if sure and off > WRONG else None
            longest = max(longest, when - since if since else 0.0)
        return longest

    def _drive(self, number, goal) -> None:
        x, y, heading = goal
        before, begin = self.truth.state, time.monotonic()
        self.send(goal)
        done = self._client.wait_for_result(rospy.Duration(LONGEST))
        if not done:
            self._client.cancel_goal()
        took, here, after = time.monotonic() - begin, self.truth.pose, self.truth.state
        sure_off = [off for when, sure, off in self.told if when > begin and sure]
        contacts = after["contacts"][0] - before["contacts"][0]
        touches = after["touched_by_people"][0] - before["touched_by_people"][0]
        reached = done and self._client.get_state() == GoalStatus.SUCCEEDED
        print("%s goal %d: %s in %.0f s, %d contacts, %d touches by people, off at the end %.3f m %.1f deg, "
              "on the way %.3f m (median), %.3f m (95 %%)%s" % (
                  self.name, number, "reached" if reached else "NOT reached", took, contacts, touches,
                  math.hypot(here[0] - x, here[1] - y), abs(math.degrees(wrapped(here[2] - heading))),
                  *(np.percentile(sure_off, [50, 95]) if sure_off else (math.nan, math.nan)),
                  "" if reached else ": " + self._client.get_goal_status_text()), flush=True)


def drive_with_faults(options, folder: str) -> None:
    """Print a table: each fault, and what it did to a robot that drove between two places of the office."""
    run = Run(0, "office", "p3dx-sh", options, folder)
    try:
        places = [run.truth.world["goals"][name] for name in ("kitchen", "sofa")]
        for number, fault in enumerate(FAULTS):
            run.drive_with_fault(fault, places[number % 2])
    finally:
        run.end()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1000-1004")
    parser.add_argument("--goals", type=int, default=5)
    parser.add_argument("--walkers", type=int, default=0)
    parser.add_argument("--faults", action="store_true", help="hit by each fault on the way, instead of --seeds")
    options = parser.parse_args()
    with ros_master("navigation_wire") as folder:
        if options.faults:
            drive_with_faults(options, folder)
            return
        for seed in seeds_of(options.seeds):
            its = case(seed)
            _, _, goals, _ = prepared(its, options.goals)
            run = Run(seed, its.world.name, its.setup.model, options, folder)
            try:
                run.drive_all(goals)
            finally:
                run.end()


if __name__ == "__main__":
    main()

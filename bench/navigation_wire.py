"""Drives to goals as a user has it: simulator, driver and navigation are processes of their own, in real time.

    ./pioneer shell python3 bench/navigation_wire.py --seeds 1000-1004 --goals 5 --walkers 1

Each seed is the world, the robot and the goals of bench/navigation_drive.py; its simulator is started from the command
line, and ``navigate.launch port:=...`` joins it over TCP. Goals go to move_base's action. What is true comes from the
simulator's own socket, which ROS does not see.
"""

import argparse
import json
import math
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

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
from pioneer_control.maps import GridMap
from pioneer_control.navigation.chassis import Chassis

from navigation_cases import case
from navigation_drive import SPEED, TURN_RATE, goals_of
from simulated_robot import SimulatedRobot

PATIENCE = 60.0  # s, for what should happen at once
LONGEST = 300.0  # s, for one goal
WRONG = 0.5  # m: a robot that is sure is wrong when it is farther off


class Truth:
    """What the simulator says is true, newest first; `trail` has (real time, x, y) of all of it."""

    def __init__(self, path: str) -> None:
        self.world, self.state, self.trail = None, None, []
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.connect(path)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in self._socket.makefile(encoding="utf-8"):
            message = json.loads(line)
            self.world = message.get("world", self.world)
            if "truth" in message:
                self.state = message["truth"]
                self.trail.append((time.monotonic(), *self.state["robots"][0][:2]))

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


def world_name(seed: int) -> str:
    """Return the name by which the command line knows the world of a seed."""
    name = case(seed).world.name
    return name if re.search(r"-\d+$", name) or name in ("office", "maze", "corridor", "classroom") else "%s-%d" % (
        name, seed)


def goals_for(seed: int, count: int):
    """Return the goals of a seed, as bench/navigation_drive.py has them."""
    its = case(seed)
    cells, origin = its.world.occupancy(0.05)
    probe = SimulatedRobot(its.setup, its.world, seed)
    chassis = Chassis(tuple(probe.shape.transducers), tuple(probe.model.outline(its.setup.gripper)), SPEED, TURN_RATE)
    return goals_of(GridMap(cells, 0.05, origin), chassis, its.world.starts[0][:2], count,
                    random.Random("drive %s" % seed)), its.setup.model


class Run:
    """One seed: its processes, and what came of its goals."""

    def __init__(self, seed: int, options, folder: str) -> None:
        goals, model = goals_for(seed, options.goals)
        name, path = world_name(seed), os.path.join(folder, "truth-%d" % seed)
        simulator = subprocess.Popen(
            [sys.executable, "-m", "pioneer_control.simulator", "--world", name, "--model", model, "--real", "--seed",
             str(seed), "--unmapped", str(seed % 4), "--walkers", str(options.walkers), "--tcp", "0", "--truth", path],
            stdout=subprocess.DEVNULL)
        launch = None
        try:
            until("the simulator's truth", lambda: os.path.exists(path))
            self.truth = Truth(path)
            until("the world", lambda: self.truth.state)
            with open(os.path.join(folder, "launch-%d.log" % seed), "w", encoding="utf-8") as log:
                launch = subprocess.Popen(
                    ["roslaunch", "pioneer_control", "navigate.launch", "port:=" + self.truth.world["robots"][0]["url"],
                     "map:=" + name, "start:=home"], stdout=log, stderr=subprocess.STDOUT)
            self.told = []
            listener = rospy.Subscriber("pioneer/navigation", Navigation, self._hear)
            client = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
            until("move_base's action", lambda: client.wait_for_server(rospy.Duration(1)))
            rospy.wait_for_service("pioneer/set_motors", PATIENCE)
            motors = rospy.ServiceProxy("pioneer/set_motors", SetBool)
            until("motors are on", lambda: motors(True).success)
            for number, goal in enumerate(goals):
                self._drive(client, seed, name, model, number, goal)
            print("%d %s %s: wrong while sure %.1f s at most" % (
                seed, name, model, self._longest_wrong()), flush=True)
            listener.unregister()
        finally:
            if launch is not None:
                end(launch)
            end(simulator)

    def _hear(self, message) -> None:
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

    def _drive(self, client, seed, name, model, number, goal) -> None:
        x, y, heading = goal
        before, begin = self.truth.state, time.monotonic()
        client.send_goal(MoveBaseGoal(PoseStamped(Header(frame_id="map", stamp=rospy.Time.now()), PoseMessage(
            Point(x, y, 0.0), Quaternion(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))))))
        done = client.wait_for_result(rospy.Duration(LONGEST))
        if not done:
            client.cancel_goal()
        took, here, after = time.monotonic() - begin, self.truth.pose, self.truth.state
        sure_off = [off for when, sure, off in self.told if when > begin and sure]
        contacts = after["contacts"][0] - before["contacts"][0]
        touches = after["touched_by_people"][0] - before["touched_by_people"][0]
        reached = done and client.get_state() == GoalStatus.SUCCEEDED
        print("%d %s %s goal %d: %s in %.0f s, %d contacts, %d touches by people, off at the end %.3f m %.1f deg, "
              "on the way %.3f m (median), %.3f m (95 %%)%s" % (
                  seed, name, model, number, "reached" if reached else "NOT reached", took, contacts, touches,
                  math.hypot(here[0] - x, here[1] - y), abs(math.degrees(wrapped(here[2] - heading))),
                  *(np.percentile(sure_off, [50, 95]) if sure_off else (math.nan, math.nan)),
                  "" if reached else ": " + client.get_goal_status_text()), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1000-1004")
    parser.add_argument("--goals", type=int, default=5)
    parser.add_argument("--walkers", type=int, default=0)
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port = probe.getsockname()[1]
    os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % port
    folder = tempfile.mkdtemp(prefix="navigation-wire-")
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until("a master", lambda: not subprocess.call(["rosparam", "list"], stdout=subprocess.DEVNULL,
                                                      stderr=subprocess.DEVNULL))
        rospy.init_node("navigation_wire", disable_signals=True)
        for seed in range(int(first), int(last or first) + 1):
            Run(seed, options, folder)
    finally:
        end(core)
    print("logs of roslaunch: " + folder)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""What it costs to publish every byte of the line (parameter publish_wire of the driver),
side by side with a driver that does not.

    ./pioneer shell /usr/bin/python3 bench/wire.py      # a minute and a half; prints the table of bench/wire.md

Three drivers, each with a robot of its own, take turns as in bench/driver.py: `off`, `on` with nobody who listens to
wire, and `heard`, whose wire this process takes. Each has a subscriber of pose and of sonar.
Processor time is that of all threads of a driver's process.
"""

import glob
import signal
import sys
import time
from typing import Dict, List, NamedTuple

import rospy
from driver import (ENOUGH, FAST, MANY, NODES, PATIENCE, SLOW, Commander, Node, Phase, Poses, ScriptedRobot,
                    command_latencies, master, median,
                    pose_latencies)
from geometry_msgs.msg import Twist
from std_srvs.srv import SetBool

SECONDS = 24.0      # of each phase
PUBLISHES = {"off": "false", "on": "true", "heard": "true"}


class Cost(NamedTuple):
    """Of one driver in one phase."""

    pose: List[float]
    """ms from a SIP to its Odometry"""
    command: List[float]
    """ms from a cmd_vel to the complete command"""
    cpu: float
    """s a minute"""


def processor_time(node: Node) -> float:
    """s that all threads of a process have run."""
    total = 0
    for path in glob.glob("/proc/%d/task/*/schedstat" % node.process.pid):
        with open(path) as file:
            total += int(file.read().split()[0])
    return total / 1e9


def measure() -> Dict[str, Dict[Phase, Cost]]:
    """All drivers in all phases."""
    robots = {name: ScriptedRobot(turn / len(PUBLISHES), is_open=False) for turn, name in enumerate(PUBLISHES)}
    rospy.init_node("bench", disable_signals=True)
    poses = {name: Poses(name) for name in PUBLISHES}
    publishers = {name: rospy.Publisher("/%s/cmd_vel" % name, Twist, queue_size=1, tcp_nodelay=True)
                  for name in PUBLISHES}
    for topic in ["/%s/sonar" % name for name in PUBLISHES] + ["/heard/wire"]:
        rospy.Subscriber(topic, rospy.AnyMsg, lambda message: None)
    nodes = {}
    for name, publishes in PUBLISHES.items():
        NODES[name] = NODES["ours"]
        nodes[name] = Node(name, robots[name].port, "_baud:=%d" % ENOUGH, "_publish_wire:=" + publishes)
        poses[name].first()
        rospy.wait_for_service("/%s/set_motors" % name, PATIENCE)
        assert rospy.ServiceProxy("/%s/set_motors" % name, SetBool)(True).success
    found: Dict[str, Dict[Phase, Cost]] = {name: {} for name in PUBLISHES}
    for phase in (SLOW, FAST, MANY):
        for robot in robots.values():
            robot.set_cycle(phase.cycle)
        with Commander(publishers, phase.rate):
            time.sleep(2.0)
        for name in PUBLISHES:
            robots[name].record()
            poses[name].forget()
        before, begin = {name: processor_time(node) for name, node in nodes.items()}, time.monotonic()
        with Commander(publishers, phase.rate) as commander:
            time.sleep(SECONDS)
        after, wall = {name: processor_time(node) for name, node in nodes.items()}, time.monotonic() - begin
        time.sleep(0.1)
        for name, robot in robots.items():
            record = robot.record()
            commands, _ = command_latencies(commander.sent[name], record)
            cpu_s_per_min = (after[name] - before[name]) / wall * 60
            found[name][phase] = Cost(pose_latencies(poses[name].heard, record), commands, cpu_s_per_min)
    for node in nodes.values():
        node.end(signal.SIGINT)
    return found


def main() -> int:
    """Print the table."""
    with master():
        found = measure()
    print("| | off | on, nobody listens | on, and heard |\n|---|---|---|---|")
    for what, of, form in (("processor time a minute", lambda cost: cost.cpu, "%.2f s"),
                           ("SIP to Odometry, median", lambda cost: median(cost.pose), "%.2f ms"),
                           ("cmd_vel to the line, median", lambda cost: median(cost.command), "%.2f ms")):
        for phase in (SLOW, FAST, MANY):
            off, *others = (of(found[name][phase]) for name in PUBLISHES)
            columns = [form % off] + [(form + " (%.2f x)") % (other, other / off) for other in others]
            print("| %s; %s | %s |" % (what, phase, " | ".join(columns)))
    return 0


if __name__ == "__main__":
    sys.exit(main())

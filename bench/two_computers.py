#!/usr/bin/python3
"""A robot's computer and a desk, with a cable between them that is pulled: when does the robot stop, and come back?

    as root, in ./pioneer shell, with openssh-server, python3-paramiko and iproute2 installed:
    python3 bench/two_computers.py [--repeat 3] [--outages 5 30]

Both are network namespaces, with a bridge between them. Pulled in the bridge, neither sees its own cable come loose,
as with radio. bench/two_computers.md has a run.
"""

import argparse
import os
import pathlib
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from typing import Dict, List, Optional, Sequence

from true_robot import ROOT, TrueRobot, output, wait_for

ADDRESSES = {"desk": "10.77.0.1", "robot1": "10.77.0.2"}
AIR = "pioneer-air"     # the namespace of the bridge
SPEED, RATE, PORT = 0.3, 10.0, 8171
PROGRAM = """
import sys, time, rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
rospy.init_node("program", disable_signals=True)
rospy.Subscriber("pose", Odometry, lambda _: print("pose", time.monotonic(), flush=True), queue_size=1)
publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1)
twist = Twist()
twist.linear.x = float(sys.argv[1])
while True:
    publisher.publish(twist)
    time.sleep(1 / float(sys.argv[2]))
"""


class Computer:
    """A computer: a network namespace, and what runs in it."""

    def __init__(self, name: str) -> None:
        self.name, self._started = name, []     # type: str, List[subprocess.Popen]
        self.words = ["ip", "netns", "exec", self.namespace]

    @property
    def namespace(self) -> str:
        """The name of its namespace."""
        return "pioneer-" + self.name

    def environment(self, master: str) -> Dict[str, str]:
        """The environment of its programs, with the master on a computer."""
        found = {name: value for name, value in os.environ.items() if name not in ("ROS_IP", "ROS_NAMESPACE")}
        return dict(found, ROS_MASTER_URI="http://%s:11311" % master, ROS_HOSTNAME=self.name, PYTHONUNBUFFERED="1")

    def start(self, *words: str, environment: Optional[Dict[str, str]] = None, out=subprocess.DEVNULL):
        """Start a program. Return its process."""
        self._started.append(subprocess.Popen([*self.words, *words], env=environment, stdout=out, stderr=out,
                                              universal_newlines=True))
        return self._started[-1]

    def end(self) -> None:
        """End what was started, the newest first."""
        for process in reversed(self._started):
            process.send_signal(signal.SIGINT)
            try:
                process.wait(15.0)
            except subprocess.TimeoutExpired:
                process.kill()
        self._started.clear()


class Program:
    """A program that drives, on a computer. It notes when it heard of the robot."""

    def __init__(self, computer: Computer, master: str, namespace: str, speed: float = SPEED) -> None:
        environment = dict(computer.environment(master), ROS_NAMESPACE=namespace)
        self.process = computer.start(sys.executable, "-c", PROGRAM, str(speed), str(RATE), environment=environment,
                                      out=subprocess.PIPE)
        self.heard = 0.0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in self.process.stdout:
            if line.startswith("pose "):
                self.heard = float(line.split()[1])

    def end(self) -> None:
        """Kill it: it says no last word."""
        self.process.kill()
        self.process.wait()


def build() -> None:
    """Make the network. Each computer finds the others by name."""
    output("ip", "netns", "add", AIR)
    run("ip", "-n", AIR, "link", "add", "air", "type", "bridge")
    run("ip", "-n", AIR, "link", "set", "air", "up")
    hosts = "127.0.0.1 localhost\n" + "".join("%s %s\n" % (at, name) for name, at in ADDRESSES.items())
    for name, address in ADDRESSES.items():
        namespace = Computer(name).namespace
        folder = pathlib.Path("/etc/netns") / namespace
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "hosts").write_text(hosts)
        output("ip", "netns", "add", namespace)
        run("ip", "link", "add", "eth0", "netns", namespace, "type", "veth", "peer", "name", name, "netns", AIR)
        run("ip", "-n", namespace, "addr", "add", address + "/24", "dev", "eth0")
        for where, link in ((namespace, "lo"), (namespace, "eth0"), (AIR, name)):
            run("ip", "-n", where, "link", "set", link, "up")
    plug()


def remove() -> None:
    """Remove the network."""
    for name in (*map(lambda name: Computer(name).namespace, ADDRESSES), AIR):
        output("ip", "netns", "del", name)
        shutil.rmtree("/etc/netns/" + name, ignore_errors=True)


def run(*words: str) -> None:
    subprocess.run(words, check=True)


def plug() -> None:
    """Put the cable back."""
    for name in ADDRESSES:
        run("ip", "-n", AIR, "link", "set", name, "master", "air")


def pull() -> float:
    """Pull the cable. Return when (monotonic, s)."""
    run("ip", "-n", AIR, "link", "set", "desk", "nomaster")
    return time.monotonic()


class Row:
    """Measured values under names."""

    def __init__(self) -> None:
        self._values: Dict[str, List[float]] = {}

    def add(self, **values: float) -> None:
        """Add a value under each name."""
        for name, value in values.items():
            self._values.setdefault(name, []).append(value)

    def __str__(self) -> str:
        return "; ".join("%s %.2f (%.2f to %.2f)" % (name.replace("_", " "), statistics.median(values), min(values),
                                                     max(values)) for name, values in self._values.items())


def measure(robot: TrueRobot, desk: Computer, master: str, namespace: str, outages: Sequence[float],
            repeat: int) -> None:
    """Pull the cable while a program on the desk drives, with the program alive and killed meanwhile, and print."""
    for outage in outages:
        row = Row()
        program = Program(desk, master, namespace)
        for _ in range(repeat):
            wait_for("the robot to drive", lambda: robot.speed > 0.9 * SPEED)
            driven, begin = robot.driven, pull()
            stands = wait_for("a stop", lambda: robot.stands)
            on_way = robot.driven - driven
            time.sleep(max(0.0, outage - (time.monotonic() - begin)))
            crept, plugged = robot.driven - driven - on_way, time.monotonic()
            plug()
            wait_for("news", lambda: program.heard > plugged)
            heard = program.heard - plugged
            wait_for("the robot to drive", lambda: robot.speed > 0.5 * SPEED)
            row.add(stands_after_s=stands, drove_on_m=on_way, later_m=crept, pose_at_desk_again_s=heard,
                    drives_again_s=time.monotonic() - plugged)
            time.sleep(3.0)
        program.end()
        print("  %g s, the program goes on: %s" % (outage, row), flush=True)
    row = Row()
    for _ in range(repeat):
        program = Program(desk, master, namespace)
        wait_for("the robot to drive", lambda: robot.speed > 0.9 * SPEED)
        pull()
        wait_for("a stop", lambda: robot.stands)
        time.sleep(2.0)
        program.end()
        driven = robot.driven
        plug()
        time.sleep(20.0)        # until TCP has tried again
        row.add(moved_by_old_commands_m=robot.driven - driven)
    print("  some seconds, the program is killed meanwhile: %s" % row, flush=True)


def motors_on(computer: Computer, master: str, namespace: str) -> None:
    """Switch the motors on."""
    environment = computer.environment(master)
    wait_for("motors", lambda: "success: True" in output(
        "rosservice", "call", "/%s/set_motors" % namespace, "true", before=computer.words, environment=environment))


def serve_ssh(computer: Computer, folder: pathlib.Path) -> Dict[str, str]:
    """Start an sshd on a computer. Return the environment in which roslaunch may log in there."""
    loader = folder / "pioneer-env"
    loader.write_text((ROOT / "config" / "pioneer-env").read_text().replace(
        "~/catkin_ws/devel/setup.bash", os.environ["CMAKE_PREFIX_PATH"].split(":")[0] + "/setup.bash").replace(
            "$(hostname)", computer.name))
    loader.chmod(0o755)
    home, keys = folder / "home", folder / "keys"
    (home / ".ssh").mkdir(parents=True)
    keys.mkdir()
    for name in (str(keys / "host"), str(home / ".ssh" / "id_rsa")):
        run("ssh-keygen", "-q", "-t", "rsa", "-N", "", "-f", name)
    shutil.copy(str(home / ".ssh" / "id_rsa.pub"), str(keys / "authorized"))
    (home / ".ssh" / "known_hosts").write_text("%s %s" % (computer.name, (keys / "host.pub").read_text()))
    (keys / "sshd_config").write_text(
        "HostKey %s\nAuthorizedKeysFile %s\nStrictModes no\nPidFile none\nUsePAM no\nPermitRootLogin yes\n"
        % (keys / "host", keys / "authorized"))
    pathlib.Path("/run/sshd").mkdir(exist_ok=True)
    computer.start("/usr/sbin/sshd", "-D", "-e", "-f", str(keys / "sshd_config"))
    return {"HOME": str(home), "USER": "root", "LOADER": str(loader)}


def main() -> None:
    """Run the bench."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--outages", type=float, nargs="+", default=[5.0, 30.0])
    parser.add_argument("--sysctl", nargs="*", default=[], metavar="NAME=VALUE", help="set on both computers")
    options = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp())
    desk, robot1 = Computer("desk"), Computer("robot1")
    robot = None
    log_path = folder / "roslaunch.log"
    log = open(str(log_path), "w")
    build()
    for computer in (desk, robot1) if options.sysctl else ():
        print(output("sysctl", "-w", *options.sysctl, before=computer.words), end="")
    try:
        robot = TrueRobot(str(folder / "truth"), PORT, robot1.words)
        print("master and driver on the robot's computer, the program on the desk; the cable is pulled for", flush=True)
        robot1.start("roslaunch", "pioneer_control", "pioneer.launch", "port:=socket://localhost:%d" % PORT,
                     environment=robot1.environment("robot1"), out=log)
        motors_on(robot1, "robot1", "pioneer")
        measure(robot, desk, "robot1", "pioneer", options.outages, options.repeat)
        robot1.end()

        print("master and roslaunch on the desk, the driver by <machine> on the robot's computer", flush=True)
        access = serve_ssh(robot1, folder)
        desk.start("roslaunch", "pioneer_control", "fleet_machines.launch", "robots:=robot1", "user:=root",
                   "loader:=" + access["LOADER"], "port:=socket://localhost:%d" % PORT,
                   environment=dict(desk.environment("desk"), **access), out=log)
        motors_on(desk, "desk", "robot1")
        measure(robot, desk, "desk", "robot1", options.outages, options.repeat)
    except TimeoutError:
        print(*log_path.read_text().splitlines()[-20:], sep="\n")
        raise
    finally:
        desk.end()
        robot1.end()
        if robot is not None:
            robot.end()
        remove()


if __name__ == "__main__":
    main()

"""Send recorded commands to a simulated robot, and compare its path with the recorded one: ``replay redrive FILE.bag``.

The simulated robot gets the model, the world and the start pose of the recorded robot, as far as the bag contains them.
This program starts the simulator and a driver in a namespace of their own, and ends them after the drive. It records
the drive in a new bag, compares the two paths, and draws them.
"""

import argparse
import contextlib
import os
import subprocess
import threading
import time
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from std_srvs.srv import SetBool

from ...errors import PioneerError, UsageError
from ...message_values import heading_of
from ...msg import Helm, MotorState, RobotInfo
from ..command_line import bag_files, free_name, number, parser_of, say, stem
from ..compare import deviation
from ..draw import draw_runs
from ..records import BagError
from ..recorded_run import Track
from ..recording.topics import NAME, load_list, topics_of
from ..run import read_run
from .commands import TOLD, read_commands
from .programs import INTERVAL, Interrupted, TopicRecorder, nodes, restore_parameter, run_as_node, running, wait_until
from .redrive_schedule import LEGAL_VALID, VALID, HelmThen, Order, obeyed, schedule

NEEDED = {"pose": Odometry, "motor_state": MotorState, "robot_info": RobotInfo, "ground_truth": Odometry}
"""Topics of the simulated robot, with their message classes. The re-drive begins after a message on each of them."""
WORLDS = os.path.join(os.path.dirname(__file__), "..", "..", "simulator", "worlds")
SAME_ROBOT = "model", "models_file", "gripper", "rear_sonar"
"""Parameters of the recorded simulator that the new simulator gets too."""
SAME_DRIVER = "cmd_vel_timeout", "max_"
"""The new driver gets all parameters of the recorded driver whose names begin with one of these words."""
SLOWEST = 0.05
"""The least legal value of --speed, as a share of the recorded speeds."""
ON = 1
"""The value of MotorState.state when the motors are on."""
STOPS, STOP_AGAIN = 5, 0.05
"""How many times the final stop is published, and the time after each (s)."""
SERVICE_PATIENCE = 120.0
"""How long to wait for the service set_motors, and then for the motors to be on (s)."""
STANDS = 0.005
"""The robot stands when it is slower than this value (m/s and rad/s)."""


OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(help="the bag; or, in quotes, the parts of one recording or a pattern for them"),
    "--robot": dict(default="", help="namespace of the recorded robot (default: the only one that received commands)"),
    "--speed": dict(default="", metavar="K", help="K times as fast, so the drive lasts 1/K as long (default: 1)"),
    "--world": dict(default="", help="world of the simulated robot (default: the recorded world)"),
    "--numbers-file": dict(default="", metavar="FILE",
                           help="numbers of the simulated robot, for example errors of its wheels (default: none)"),
    "--seed": dict(type=int, default=0, help="seed of the simulated robot (default: %(default)s)"),
    "--name": dict(default="redrive", help="namespace of the simulated robot (default: %(default)s)"),
    "--output": dict(default="", metavar="NEW.bag", help="the bag to write (default: beside the old bag)"),
}
"""The command-line options of ``replay redrive``, with the arguments of argparse for each."""


class RecordedDrive:
    """The commands to a recorded robot, and the parameters for a simulator and a driver like the recorded ones.

    Args:
        files: one bag, or all parts of one recording.
        robot: the namespace of the robot. Empty: the only robot in the bag that received commands.

    Attributes:
        robot: the namespace of the robot.
        told: the recorded commands in order of time. The times are those in the bag (s).
        world: the name or the file of the recorded world. Empty if the bag does not contain it.
        like: parameters for a simulator like the recorded robot. ``start`` is the true pose of the recorded robot at
            its first command: x, y (m), heading (rad).
        driver: parameters for a driver that drives like the recorded driver.
        valid: the recorded driver's cmd_vel_timeout (s). The default if the bag contains no legal value.

    Raises:
        BagError: the robot received no commands. Or `robot` is empty, and several robots received commands.
    """

    def __init__(self, files: Sequence[str], robot: str = "") -> None:
        found = read_commands(files, robot, TOLD, {"robot_info": RobotInfo, "world": String, "ground_truth": Odometry,
                                                   "helm": Helm})
        self.robot = found.robot
        helm = [HelmThen(when, message.programs_locked_out, bool(message.locks))
                for when, message in found.messages.get("helm", [])]
        self.told = sorted(obeyed((Order(when, name, message) for name in TOLD
                                   for when, message in found.messages.get(name, [])), helm, Twist()),
                           key=lambda order: order.time)
        simulator, driver = (found.parameters_of("%s/%s" % (found.robot, node)) for node in ("simulator", "p2os"))
        info, world, truths = found.newest("robot_info"), found.newest("world"), found.messages.get("ground_truth")
        self.world = str(simulator.get("world") or world and world.data or "")
        self.like = {name: simulator[name] for name in SAME_ROBOT if name in simulator}
        if info:
            self.like.update(gripper=info.has_gripper, **({"model": info.subtype} if info.subtype else {}))
        if truths:
            self.like["start"] = _place(truths, self.told[0].time)
        self.driver = {name: driver[name] for name in driver if name.startswith(SAME_DRIVER)}
        valid: Any = driver.get("cmd_vel_timeout")
        is_legal = isinstance(valid, (int, float)) and LEGAL_VALID[0] <= valid <= LEGAL_VALID[1]
        self.valid = float(valid) if is_legal else VALID


def _place(truths: Sequence[Tuple[float, Any]], begin: float) -> List[float]:
    """Return the true pose of the robot at the time `begin` (s): x, y (m), heading (rad).

    Args:
        truths: (time in s, Odometry) in order of time, at least one.
        begin: the newest message up to this time counts. If all messages are later, the first one counts.
    """
    message = ([message for when, message in truths if when <= begin] or [truths[0][1]])[-1]
    position, turn = message.pose.pose.position, message.pose.pose.orientation
    return [position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w)]


def simulator_parameters(recorded: RecordedDrive, world: str, numbers_file: str, seed: int) -> Dict[str, Any]:
    """Return the parameters for a simulated robot like the recorded one, as far as the bag contains them.

    Args:
        recorded: the recorded robot.
        world: the name or the file of a world. Empty: the recorded world.
        numbers_file: a file with errors of the simulated robot, for example of its wheels. Empty: none.
        seed: the seed of the simulator.
    """
    return dict(recorded.like, world=world or known_world(recorded.world), seed=seed,
                numbers_file=numbers_file and os.path.abspath(os.path.expanduser(numbers_file)))


def known_world(named: str) -> str:
    """Return the recorded world if it still exists on this computer. If not, print so and return "empty".

    Args:
        named: the name or the file of the recorded world. Empty if the bag does not contain it.
    """
    if os.path.isfile(os.path.join(WORLDS, named + ".yaml")) or "/" in named and os.path.isfile(named):
        return named
    say("The world %r of the recording is not here: there is nothing round the robot now. Give its file with "
        "world:=FILE." % named if named else
        "The bag does not tell what was round the robot: there is nothing round it now. Give a world with world:=NAME.")
    return "empty"


class Redrive:
    """One re-drive: it sends recorded commands to a simulated robot. Call `run`.

    Args:
        given: the parsed command line.

    Raises:
        UsageError: the bag or an option is not usable. Nothing has been started then.
    """

    def __init__(self, given: argparse.Namespace) -> None:
        self._given = given
        self._files = bag_files(given.bag)
        self._recorded = RecordedDrive(self._files, given.robot)
        self._factor = number("speed", given.speed or "1", SLOWEST, 1.0)
        self._orders = schedule(self._recorded.told, self._factor, self._recorded.valid)
        if given.numbers_file and not os.path.isfile(os.path.expanduser(given.numbers_file)):
            raise UsageError("numbers_file:=%s: no such file" % given.numbers_file)
        self._name = "/" + given.name.strip("/")
        if not NAME.fullmatch(self._name[1:]):      # all parameters below it are removed at the end
            raise UsageError("--name %r is not legal: give the name of a namespace, such as redrive" % given.name)
        self._silent = False
        self._publishing = threading.Lock()

    def run(self) -> int:
        """Start the simulated robot, send it the recorded commands, and compare its path with the recorded one.

        Returns:
            The exit code 0.

        Raises:
            PioneerError: the re-drive could not begin, or ended early.
        """
        self._refuse_a_shared_name()
        self._bag = TopicRecorder(self._given.output or free_name(self._files[0], "redrive"), rospy.Time.now)
        self._publishers = {name: rospy.Publisher("%s/%s" % (self._name, name), kind, queue_size=10)
                            for name, kind in TOLD.items()}
        for topic in topics_of(load_list(), [self._name.strip("/")]):
            name = topic[len(self._name) + 1:]
            if topic.startswith(self._name + "/") and name not in TOLD:
                rospy.Subscriber(topic, NEEDED.get(name, rospy.AnyMsg), self._bag.write, topic)
        rospy.on_shutdown(self._stop)
        with contextlib.ExitStack() as at_end:
            at_end.callback(restore_parameter, self._name, None)
            at_end.enter_context(self._bag)
            robot = self._start_robot(at_end)
            at_end.callback(self._stop)
            self._switch_motors_on(robot)
            self._drive(robot)
            wait_until("the robot to stand", self._stands, robot)
        self._compare()
        return 0

    # Before anything moves

    def _refuse_a_shared_name(self) -> None:
        """Raise UsageError when the ROS master has simulated time, or nodes in the namespace of the re-driven robot."""
        if rospy.get_param("/use_sim_time", False):
            raise UsageError("this master has simulated time (/use_sim_time), perhaps of an earlier replay. When none "
                             "goes on: rosparam set /use_sim_time false")
        there = [node for node in nodes() if node.startswith(self._name + "/")]
        if there:
            raise UsageError("%s is there already: end it (rosnode cleanup, if it was killed), or take another name "
                             "for the re-driven robot with --name" % ", ".join(there))

    def _start_robot(self, at_end: contextlib.ExitStack) -> Sequence[subprocess.Popen]:
        """Start the simulator and its driver, and wait until the driver is ready for commands.

        Args:
            at_end: gets what ends the two programs.

        Returns:
            The processes of the simulator and of the driver.

        Raises:
            NoAnswerError: a program ended, or was not ready in time.
        """
        recorded, given = self._recorded, self._given
        line, prefix = "/tmp/pioneer_redrive_%s" % os.getpid(), self._name.strip("/") + "/"
        simulator = simulator_parameters(recorded, given.world, given.numbers_file, given.seed)
        x, y, heading = simulator.get("start") or (0.0, 0.0, 0.0)
        where = " at x %.2f m, y %.2f m, %.0f degrees" % (x, y, np.degrees(heading)) if "start" in simulator else ""
        say("A simulated %s in the world %r%s is told what %s in %s was told: for %.0f s, as %s."
            % (simulator.get("model", "robot"), simulator["world"], where, recorded.robot or "the robot",
               self._files[0], max([order.time for order in self._orders], default=0.0), self._name))
        rospy.set_param(self._name + "/simulator", dict(simulator, pty=line, frame_prefix=prefix))
        rospy.set_param(self._name + "/p2os", dict(recorded.driver, port=line, frame_prefix=prefix))
        started = [at_end.enter_context(running(["rosrun", "pioneer_control", program, "__name:=" + name], self._name))
                   for program, name in (("p2os_simulator", "simulator"), ("p2os_driver", "p2os"))]
        wait_until("the robot (%s)" % ", ".join(NEEDED), lambda: all(self._newest(name) for name in NEEDED), started)
        wait_until("its driver to listen",
                   lambda: all(each.get_num_connections() for each in self._publishers.values()), started)
        return started

    def _switch_motors_on(self, robot: Sequence[subprocess.Popen]) -> None:
        service = self._name + "/set_motors"
        rospy.wait_for_service(service, SERVICE_PATIENCE)
        answer = rospy.ServiceProxy(service, SetBool)(True)
        if not answer.success:
            raise UsageError("the motors do not go on: %s" % answer.message)
        wait_until("the motors to be on", lambda: self._newest("motor_state").state == ON, robot, SERVICE_PATIENCE)

    def _newest(self, name: str) -> Any:
        """Return the newest message on a topic of the simulated robot. None before the first message.

        `name` is the last name of the topic.
        """
        return self._bag.newest.get("%s/%s" % (self._name, name))

    # Moving

    def _drive(self, robot: Sequence[subprocess.Popen]) -> None:
        """Send every command when it is due.

        Args:
            robot: the processes of the simulator and of the driver.

        Raises:
            Interrupted: this node must end.
            UsageError: the simulator or the driver has ended.
        """
        begin = time.monotonic()
        for order in self._orders:
            while time.monotonic() < begin + order.time:
                if rospy.is_shutdown():
                    raise Interrupted("ended before it was done; the robot was stopped")
                if any(process.poll() is not None for process in robot):
                    raise UsageError("the robot is gone: the last lines of its programs above say why")
                time.sleep(max(0.0, min(begin + order.time - time.monotonic(), INTERVAL)))
            self._give(order)

    def _give(self, order: Order) -> None:
        with self._publishing:
            if not self._silent:
                self._publishers[order.topic].publish(order.message)
                self._bag.write(order.message, "%s/%s" % (self._name, order.topic))

    def _stop(self) -> None:
        """Publish a stop several times, and then no more commands. Any thread may call this, also more than once."""
        with self._publishing:
            for _ in range(0 if self._silent else STOPS):   # the process may end next: give rospy time to send
                self._publishers["cmd_vel"].publish(Twist())
                time.sleep(STOP_AGAIN)
            self._silent = True

    def _stands(self) -> bool:
        twist = self._newest("pose").twist.twist
        return abs(twist.linear.x) < STANDS and abs(twist.angular.z) < STANDS

    # Afterwards

    def _compare(self) -> None:
        """Print how far the new path is from the recorded one, and draw both paths in one picture."""
        path = self._bag.path
        try:
            recorded = read_run(self._files, self._recorded.robot or None)
        except BagError as error:
            say("\nIt was driven, and there is nothing to compare it with: %s\nbag      %s" % (error, path))
            return
        begin = self._recorded.told[0].time
        recorded = recorded._replace(odometry=trimmed(recorded.odometry, begin),
                                     truth=recorded.truth and trimmed(recorded.truth, begin))
        driven = read_run(path, self._name.strip("/"))
        where, before, after = "where it truly was", recorded.truth, driven.truth
        if before is None or after is None:
            where, before, after = "as each one's odometry has it", recorded.odometry, driven.odometry
        apart = deviation(before, after._replace(time=after.time * self._factor))
        say("\nThe recorded path is %.2f m long, the new one %.2f m (%s).\nThey are %.1f cm apart on average, "
            "%.1f cm at most, %.1f cm and %+.1f degrees at the end.\nbag      %s"
            % (before.length, after.length, where, 100 * apart.mean, 100 * apart.maximum, 100 * apart.at_end,
               np.degrees(apart.turn_at_end), path))
        picture, slower = stem(path) + ".png", " at %g of the speed" % self._factor if self._factor != 1.0 else ""
        try:
            draw_runs([recorded, driven], picture,
                      "%s, driven again%s" % (os.path.basename(stem(self._files[0])), slower))
            say("picture  %s" % picture)
        except (PioneerError, OSError, ImportError) as error:
            say("There is no picture: %s" % error)


def trimmed(track: Track, begin: float) -> Track:
    """Return the part of a track after a moment. It begins with the interpolated pose of the robot at this moment.

    Args:
        track: the whole track.
        begin: the moment (s).
    """
    begin = min(max(begin, float(track.time[0])), float(track.time[-1]))
    return track.at(np.append(begin, track.time[track.time > begin]))


def main(arguments: Sequence[str]) -> int:
    """Run ``replay redrive``.

    Args:
        arguments: the words of the command line after ``redrive``.

    Returns:
        The exit code. 0: the robot received all commands. 1: the re-drive ended early. 2: it could not begin, or the
        simulator or the driver ended.

    Raises:
        UsageError: the bag or an option is not usable, or the node cannot start.
    """
    given = parser_of("replay redrive", "Send the recorded commands to a simulated robot, and compare the paths.",
                      OPTIONS).parse_args(arguments)
    return run_as_node("redrive", Redrive(given).run)

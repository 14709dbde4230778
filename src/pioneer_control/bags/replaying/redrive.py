"""Tell another robot what the recorded one was told, and see how far it gets from there: ``rosrun pioneer_control replay redrive FILE.bag``.

The other robot is a simulated one, of the model, in the world and at the place the bag tells of; or with ``--into real --port PORT`` a real one,
slower. Its driver is started here, in a namespace of its own, and ends here. What it did is kept in a bag, compared and drawn.
"""

import argparse
import os
import re
import subprocess
import threading
import time
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import String
from std_srvs.srv import SetBool

from ...errors import PioneerError, UsageError
from ...message_values import heading_of
from ...msg import GripperState, MotorState, RobotInfo, WheelVelocities
from ..compare import deviation
from ..draw import draw_comparison
from ..names import stem
from ..reader import BagError
from ..recording.description import Description
from ..recording.topics import load_list, topics_of
from ..run import Track, read_run
from .redrive_schedule import LEGAL_VALID, OTHERS, VALID, VELOCITIES, Order, duration, fastest, schedule
from .replay import bag_files, number, yes_or_no
from .stage import Interrupted, Keeper, Programs, alive, carry_out, explain_roslaunch, free_name, nodes, put_back, say, say_what_is_kept, wait_until
from .told import read_told

KINDS = {"cmd_vel": Twist, "cmd_wheels": WheelVelocities, "cmd_motor_state": MotorState, "gripper_control": GripperState}
WORLDS = Path(__file__).parents[2] / "simulator" / "worlds"
SAME_ROBOT = "model", "models_file", "gripper", "rear_sonar"
"""Parameters of a recorded simulator that a re-drive's gets, too."""
SAME_DRIVER = "cmd_vel_timeout", "max_"
"""What the names of those of a recorded driver begin with."""
SPEEDS = {"sim": (0.05, 1.0, 1.0), "real": (0.05, 0.5, 0.3)}
"""Share of the recorded speeds: least, most, and what it is if nobody says."""
ANNOUNCED = 3.0  # s from saying that a real robot will move until it does
ON = 1  # MotorState.state
STOPS, STOP_AGAIN = 5, 0.05  # the last stop: how often, and s between
MOTORS_PATIENCE = 120.0  # s for somebody to switch on the motors of a real robot
LIMITS = 0.5, 1.745  # m/s, rad/s: a driver's defaults, of max_xspeed and max_yawspeed
LEGAL_LIMITS = (0.01, 3.0), (0.02, 6.3)  # what they may be
SILENT = 2.5  # s without a pose of a real robot: its link is lost
HELD_UP = 1.0  # s by which this program may be late; a real robot has stood meanwhile, and is not where the next order belongs
STANDS = 0.005  # m/s and rad/s


class Recorded(NamedTuple):
    """What a bag tells of a robot that was driven."""

    robot: str  # namespace
    told: List[Order]
    begin: float  # s, when it was told the first
    model: str
    has_gripper: Optional[bool]
    world: str
    start: Optional[Sequence[float]]  # where it truly stood when it was told the first: x, y, heading; m, rad
    simulator: Dict[str, Any]  # parameters
    driver: Dict[str, Any]
    limits: Sequence[float] = LIMITS  # m/s, rad/s: the most that its driver passed on

    @property
    def valid(self) -> float:
        """s for which its driver took a velocity."""
        return _legal(self.driver.get("cmd_vel_timeout"), LEGAL_VALID, VALID)


def read_recorded(files: Sequence[str], robot: str = "") -> Recorded:
    """Read what a robot was told. Raises BagError as `read_told` does."""
    told = read_told(files, robot, KINDS, {"robot_info": RobotInfo, "world": String, "ground_truth": Odometry})
    parts = told.messages
    orders = sorted((Order(when, name, message) for name in KINDS for when, message in parts.get(name, [])), key=lambda order: order.time)
    begin = orders[0].time
    description = next(told.descriptions(), Description({}, {}, {}, {}))
    info = parts["robot_info"][-1][1] if parts.get("robot_info") else None
    driver = description.parameters_of("%s/p2os" % told.robot)
    told_limits = (info.max_linear, info.max_angular) if info else (driver.get("max_xspeed"), driver.get("max_yawspeed"))
    limits = [_legal(*each) for each in zip(told_limits, LEGAL_LIMITS, LIMITS)]
    return Recorded(
        told.robot, orders, begin, info.subtype if info else "", info.has_gripper if info else None,
        parts["world"][-1][1].data if parts.get("world") else "", _start(parts.get("ground_truth", []), begin),
        description.parameters_of("%s/simulator" % told.robot), driver, limits)


def _start(truths: list, begin: float) -> Optional[Sequence[float]]:
    """Where the robot stood last before a time, or first after it."""
    before = [message for when, message in truths if when <= begin]
    if not truths:
        return None
    pose = (before[-1] if before else truths[0][1]).pose.pose
    turn = pose.orientation
    return [pose.position.x, pose.position.y, heading_of(turn.x, turn.y, turn.z, turn.w)]


def simulator_parameters(recorded: Recorded, world: str, numbers_file: str, seed: int) -> Dict[str, Any]:
    """What the simulated robot is to be: as the recorded one, as far as the bag tells."""
    parameters = {name: recorded.simulator[name] for name in SAME_ROBOT if name in recorded.simulator}
    if recorded.model:
        parameters["model"] = recorded.model
    if recorded.has_gripper is not None:
        parameters["gripper"] = recorded.has_gripper
    parameters["world"] = world or known_world(recorded)
    if recorded.start is not None:
        parameters["start"] = list(recorded.start)
    return dict(parameters, seed=seed, numbers_file=os.path.abspath(os.path.expanduser(numbers_file)) if numbers_file else "")


def known_world(recorded: Recorded) -> str:
    """The world of the recorded robot if it is still there, else the empty one; says so."""
    named = str(recorded.simulator.get("world") or recorded.world)
    if (WORLDS / ("%s.yaml" % named)).is_file() or "/" in named and os.path.isfile(named):
        return named
    if named:
        say("The world %r of the recording is not here: there is nothing round the robot now. Give its file with world:=FILE." % named)
    else:
        say("The bag does not tell what was round the robot: there is nothing round it now. Give a world with world:=NAME.")
    return "empty"


class Redrive:
    """One re-drive. Call `run`."""

    def __init__(self, given: argparse.Namespace) -> None:
        """Raises UsageError for what makes no sense, before anything is started."""
        self._given = given
        self._real = given.into == "real"
        self._files = bag_files(given.bag)
        self._recorded = read_recorded(self._files, given.robot)
        least, most, usual = SPEEDS[given.into]
        self._factor = usual if given.speed == "" else number("speed", given.speed, least, most)
        told = [order for order in self._recorded.told if not (self._real and order.topic == "cmd_motor_state" and order.message.state == ON)]
        self._orders = schedule(told, self._factor, self._recorded.valid)
        if self._real and not given.port:
            raise UsageError("into:=real needs the robot's port, too: port:=/dev/ttyUSB0")
        if given.port and not self._real:
            raise UsageError("port is of a real robot: give into:=real, too, if that is what shall move")
        if given.numbers_file and not os.path.isfile(os.path.expanduser(given.numbers_file)):
            raise UsageError("numbers_file:=%s: no such file" % given.numbers_file)
        if not any(order.topic in VELOCITIES + OTHERS for order in self._orders):
            raise UsageError("there is nothing in the bag that a real robot would be told")
        self._name = "/" + given.name.strip("/")
        if not re.fullmatch("(/[A-Za-z][A-Za-z0-9_]*)+", self._name):   # all below it is the re-drive's own, and removed at its end
            raise UsageError("--name %r is not legal: give the name of a namespace, such as redrive" % given.name)
        self._programs = Programs()
        self._silent = False
        self._newest_pose: Any = None
        self._newest_pose_at = time.monotonic()
        self._publishing = threading.Lock()

    def run(self) -> int:
        """Drive. Returns the exit code: 0 driven to the end and compared."""
        self._look_round()
        keeper = Keeper(self._given.output or free_name(self._files[0], "redrive"), rospy.Time.now)
        own = [topic for topic in topics_of(load_list(), [self._name.strip("/")]) if topic.startswith(self._name + "/")]
        kinds = {"pose": Odometry, "motor_state": MotorState, "robot_info": RobotInfo}
        self._publishers = {name: rospy.Publisher("%s/%s" % (self._name, name), kind, queue_size=10) for name, kind in KINDS.items()}
        for topic in own:
            name = topic[len(self._name) + 1:]
            if name not in KINDS:
                keeper.hear(topic, kinds.get(name, rospy.AnyMsg))
        rospy.on_shutdown(self._stop)
        self._keeper = keeper
        try:
            robot = self._start_robot()
            self._switch_motors_on(robot)
            self._drive(robot)
            wait_until("the robot to stand", self._stands, robot)
        except BaseException:
            say_what_is_kept(keeper)
            raise
        finally:
            self._stop()
            self._programs.end_all()
            keeper.close()
            put_back(self._name, None)
        self._tell(keeper.path)
        return 0

    # Before anything moves

    def _look_round(self) -> None:
        """Nobody else may be at work where this is going to be, and with a real robot nowhere on this master."""
        if rospy.get_param("/use_sim_time", False):
            raise UsageError("this master has simulated time (/use_sim_time), perhaps of an earlier replay. When none goes on: rosparam set /use_sim_time false")
        there = [node for node in nodes() if node.startswith(self._name + "/")]
        if there:
            raise UsageError("%s is there already: end it (rosnode cleanup, if it was killed), or take another name for the re-driven robot with --name" % ", ".join(there))
        others = alive()
        if self._real and others:
            raise UsageError("%s is on this master: a real robot is re-driven with nobody else at work. End that first, or take a master "
                             "of its own (export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others))

    def _start_robot(self) -> Sequence[subprocess.Popen]:
        """The driver, and the robot if it is simulated; returns what must not end."""
        recorded, given = self._recorded, self._given
        driver: Dict[str, Any] = {} if self._real else {
            name: value for name, value in recorded.driver.items() if name.startswith(SAME_DRIVER)}
        driver["frame_prefix"] = self._name.strip("/") + "/"
        started = []
        if self._real:
            driver["port"] = given.port
            driver["max_xspeed"], driver["max_yawspeed"] = self._limits()
            say("A REAL robot on %s is going to move as the one in %s did: for %.0f s, at %g of "
                "the recorded speeds, which is %.2f m/s at most. Nothing looks where it goes. Ctrl-C stops it." % (given.port, self._files[0], duration(self._orders), self._factor, driver["max_xspeed"]))
        else:
            line = "/tmp/pioneer_redrive_%s" % os.getpid()
            simulator = dict(simulator_parameters(recorded, given.world, given.numbers_file, given.seed), pty=line, frame_prefix=driver["frame_prefix"])
            driver["port"] = line
            rospy.set_param(self._name + "/simulator", simulator)
            started.append(self._programs.start(["rosrun", "pioneer_control", "p2os_simulator", "__name:=simulator"], self._name))
            x, y, heading = simulator.get("start") or (0.0, 0.0, 0.0)
            where = " at x %.2f m, y %.2f m, %.0f degrees" % (x, y, np.degrees(heading)) if "start" in simulator else ""
            say("A simulated %s in the world %r%s is told what %s in "
                "%s was told: for %.0f s, as %s." % (simulator.get("model", "robot"), simulator["world"], where, recorded.robot or "the robot", self._files[0], duration(self._orders), self._name))
        rospy.set_param(self._name + "/p2os", driver)
        started.append(self._programs.start(["rosrun", "pioneer_control", "p2os_driver", "__name:=p2os"], self._name))
        needed = ["pose", "motor_state", "robot_info"] + ([] if self._real else ["ground_truth"])
        wait_until("the robot (%s)" % ", ".join(needed), lambda: all(self._newest(name) for name in needed), started)
        wait_until("its driver to listen", lambda: all(publisher.get_num_connections() for publisher in self._publishers.values()), started)
        return started

    def _limits(self) -> List[float]:
        """What the driver of a real robot passes on at most: as much slower than the recorded driver did as all else is. A bag may ask for more."""
        linear, angular = (self._factor * limit for limit in self._recorded.limits)
        return [max(legal[0], limit) for limit, legal in zip((min(linear, fastest(self._orders)), angular), LEGAL_LIMITS)]

    def _switch_motors_on(self, robot: Sequence[subprocess.Popen]) -> None:
        """Of a simulated robot; of a real one only if that was asked for. Else somebody else has to."""
        service = self._name + "/set_motors"
        if self._real and self._given.motors:
            say("The motors go on in %.0f s." % ANNOUNCED)
            end = time.monotonic() + ANNOUNCED
            wait_until("the moment", lambda: time.monotonic() > end, robot)
        if not self._real or self._given.motors:
            rospy.wait_for_service(service, MOTORS_PATIENCE)
            answer = rospy.ServiceProxy(service, SetBool)(True)
            if not answer.success:
                raise UsageError("the motors do not go on: %s" % answer.message)
        else:
            say("The motors are off. When everybody is out of the way: rosservice call %s true   (motors:=true does it from here)" % service)
        wait_until("the motors to be on", lambda: self._newest("motor_state").state == ON, robot, MOTORS_PATIENCE)

    def _newest(self, name: str) -> Any:
        return self._keeper.newest.get("%s/%s" % (self._name, name))

    # Moving

    def _drive(self, robot: Sequence[subprocess.Popen]) -> None:
        """Give every order when it is due."""
        begin = time.monotonic()
        for order in self._orders:
            while time.monotonic() < begin + order.time:
                time.sleep(max(0.0, min(begin + order.time - time.monotonic(), 0.05)))
                self._check(robot, begin + order.time)
            self._check(robot, begin + order.time)
            self._give(order)

    def _check(self, robot: Sequence[subprocess.Popen], due: float) -> None:
        """Raises when it must not go on. ``due``: when the next order is, or was, monotonic."""
        if rospy.is_shutdown():
            raise Interrupted("ended before it was done; the robot was stopped")
        if any(process.poll() is not None for process in robot):
            raise UsageError("the robot is gone: why, its programs say above")
        late = time.monotonic() - due
        if self._real and late > HELD_UP:
            raise UsageError("this program was held up for %.1f s: the robot stands, and is not where it should be by now; it ends here" % late)
        if self._real and self._newest("motor_state").state != ON:
            raise UsageError("the motors went off (was the STOP button pressed?): it ends here, and nothing switches them on again")
        if self._real and self._silence() > SILENT:
            raise UsageError("the robot has fallen silent: it ends here. Why, its driver says above")

    def _silence(self) -> float:
        """Seconds since its newest pose."""
        pose = self._newest("pose")
        if pose is not self._newest_pose:
            self._newest_pose, self._newest_pose_at = pose, time.monotonic()
        return time.monotonic() - self._newest_pose_at

    def _give(self, order: Order) -> None:
        with self._publishing:
            if self._silent:
                return
            self._publishers[order.topic].publish(order.message)
        self._keeper.write("%s/%s" % (self._name, order.topic), order.message)

    def _stop(self) -> None:
        """Stand, and be told nothing any more, whoever asks for it, and however often."""
        with self._publishing:
            if self._silent:
                return
            self._silent = True
            for _ in range(STOPS):  # the end may come next: give what sends it time to do it
                self._publishers["cmd_vel"].publish(Twist())
                time.sleep(STOP_AGAIN)

    def _stands(self) -> bool:
        twist = self._newest("pose").twist.twist
        return abs(twist.linear.x) < STANDS and abs(twist.angular.z) < STANDS

    # Afterwards

    def _tell(self, path: str) -> None:
        """How far it came from the recorded path, in words and as a picture."""
        try:
            recorded = read_run(self._files, self._recorded.robot or None)
        except BagError as error:
            say("\nIt was driven, and there is nothing to compare it with: %s\nbag      %s" % (error, path))
            explain_roslaunch()
            return
        recorded = recorded._replace(**{name: track and trimmed(track, self._recorded.begin)
                                        for name, track in (("truth", recorded.truth), ("odometry", recorded.odometry))})
        driven = read_run(path, self._name.strip("/"))
        where, before, after = "where it truly was", recorded.truth, driven.truth
        if before is None or after is None:
            where, before, after = "as each one's odometry has it", recorded.odometry, driven.odometry
        after = after._replace(time=after.time * self._factor)
        apart = deviation(before, after)
        say("\nThe recorded path is %.2f m long, the new one %.2f m (%s).\n"
            "They are %.1f cm apart on average, %.1f cm at most, %.1f cm and "
            "%+.1f degrees at the end.\nbag      %s" % (before.length, after.length, where, 100 * apart.mean, 100 * apart.maximum, 100 * apart.at_end, np.degrees(apart.turn_at_end), path))
        picture, slower = stem(path) + ".png", " at %g of the speed" % self._factor if self._factor != 1.0 else ""
        try:
            draw_comparison([recorded, driven], picture, "%s, driven again" % os.path.basename(stem(self._files[0])) + slower)
            say("picture  %s" % picture)
        except (PioneerError, OSError, ImportError) as error:
            say("There is no picture: %s" % error)
        explain_roslaunch()


def trimmed(track: Track, begin: float) -> Track:
    """A track from a moment on, s: from where the robot was just then, however few of its places are kept."""
    begin = min(max(begin, float(track.time[0])), float(track.time[-1]))
    return track.at(np.concatenate(([begin], track.time[track.time > begin])))


def _legal(value: Any, legal: Sequence[float], otherwise: float) -> float:
    """A number that a driver takes; any other value of a bag was not its."""
    return float(value) if isinstance(value, (int, float)) and legal[0] <= value <= legal[1] else otherwise


def parser() -> argparse.ArgumentParser:
    """The command line; replay.launch has arguments of the same names."""
    result = argparse.ArgumentParser(prog="replay redrive", description="Tell another robot what the recorded one was told, and compare.")
    add = result.add_argument
    add("bag", help="the bag; several, or a pattern, in quotes: the parts of one recording")
    add("--robot", default="", help="namespace of the recorded robot (default: the only one that was told something)")
    add("--into", choices=sorted(SPEEDS), default="sim", help="a simulated robot, or a real one (default: %(default)s)")
    add("--port", default="", help="of the real robot")
    add("--speed", default="", metavar="K", help="so many times as fast, and as much longer (default: 1, into a real robot 0.3)")
    add("--motors", type=yes_or_no, default=False, metavar="true|false", help="of a real robot: switch them on (default: wait until somebody does)")
    add("--world", default="", help="of the simulated robot (default: as the bag tells)")
    add("--numbers-file", default="", help="of the simulated robot: errors of its wheels, for example (default: none)")
    add("--seed", type=int, default=0, help="of the simulated robot (default: %(default)s)")
    add("--name", default="redrive", help="namespace of the re-driven robot (default: %(default)s)")
    add("--output", default="", metavar="NEW.bag", help="where what it does is kept (default: beside the bag)")
    return result


def main(arguments: Sequence[str]) -> int:
    """Run it. Returns the exit code: 0 driven to the end and compared, 1 ended before, 2 it cannot be done as asked."""
    return carry_out("redrive", Redrive(parser().parse_args(arguments)).run)

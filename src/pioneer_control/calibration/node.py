"""The program: ``rosrun pioneer_control calibrate [ROBOT] [--file my_robots.yaml] [--tell-robot] [--bag RUNS.bag]``.

It talks topics only, like any user's program: pose, sonar, robot_info and imu in, cmd_vel and cmd_motor_state out. The
driver stops the robot when nothing comes for ``cmd_vel_timeout``: so a terminal that is cut off, or this program
killed, means that the robot stands.
"""

import argparse
import math
import os
import shlex
import sys
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from ..errors import CalibrationError, NoAnswerError, NotConfirmedError, PioneerError, UsageError
from ..floor_poses import Pose
from ..message_values import heading_of
from ..msg import Calibration, MotorState, RobotInfo
from ..robots import RobotModel, find_model
from ..ros_node import init_node, name_for
from ..teleop.node import each_key, publish
from ..tutorial.pioneer import Pioneer
from . import words
from .bag import runs_of_bag
from .conversation import Conversation, ask_marks, ask_tape
from .estimate import Estimate, check
from .guide import STAND, Guide
from .lookout import Lookout
from .pieces import in_words
from .plan import Leg, RunPlan, plan_of
from .result import (OwnNumbers, after_telling, check_new_file, numbers_to_tell, of_counts, of_driver, values_of_file,
                     write_models_file)
from .runs import RunKind, RobotMarks, TapedRun, name_of, whole_turns
from .terminal import Terminal, TerminalClosed
from .tracks import Factors, OdometryTrack, TrackRecorder

PERIOD = 0.05
"""The longest time (s) between two looks at keys, poses and sonar."""
REPEAT = 0.1
"""Time (s) between two publications of the same velocity."""
PATIENCE = 15.0
"""The longest wait (s) for what the driver has to tell."""
TOLD_PATIENCE = 5.0
"""The longest wait (s) until the robot reports new numbers of its own."""
UNMOVED = 2.0
"""Time (s) after which a robot that is told to drive, and does not move, must be locked."""
LOCKED = ("it is told to drive, and does not. Is stop_all set, or has a person the helm? rostopic echo -n 1 .../helm"
          " says it")
SKIP = "-"


class Subject(NamedTuple):
    """The robot that is calibrated, as a driver knows it.

    Attributes:
        model: with the models file that the driver uses.
        models_file: that file; empty: none.
    """

    model: RobotModel
    models_file: str

    @property
    def rad_per_metre(self) -> float:
        """Turn (rad) when each right wheel rolls 1 m forward and each left wheel 1 m back."""
        return 1000.0 * self.model.diff_rad_per_mm

    @property
    def marks(self) -> RobotMarks:
        """Where the marks are likely to be: at the ends of the body."""
        return RobotMarks(self.model.length_front, self.model.length_front + self.model.length_rear)

    @property
    def nominal(self) -> RobotModel:
        """The model without a calibration."""
        try:
            return find_model(self.model.subtype)
        except PioneerError:        # a model of the user's own
            return self.model


class RobotOnTopics:
    """The robot, for the conversation: it drives while the key is held.

    Args:
        namespace: of its topics.
        terminal: the person's.
    """

    def __init__(self, namespace: str, terminal: Terminal) -> None:
        self._pioneer = Pioneer(namespace)
        prefix = namespace.rstrip("/") + "/"
        self._terminal = terminal
        self._news: Deque[Any] = deque()
        self._latest: Dict[type, Any] = {}
        self._motors = rospy.Publisher(prefix + "cmd_motor_state", MotorState, queue_size=1)
        for topic, kind in (("robot_info", RobotInfo), ("calibration", Calibration)):
            rospy.Subscriber(prefix + topic, kind, self._keep, kind, queue_size=1)
        rospy.Subscriber(prefix + "pose", Odometry, self._news.append)
        rospy.Subscriber(prefix + "imu", Imu, self._news.append)
        self._pioneer.wait_until_ready()

    def _keep(self, message: Any, kind: type) -> None:
        self._latest[kind] = message

    def drive(self, legs: Sequence[Leg], factors: Factors) -> OdometryTrack:
        """Drive the legs of a run while the key is held. See `conversation.DrivenRobot`."""
        self._terminal.say("Hold w (or the arrow up) until it says that the run is done.")
        drive = HeldDrive(self._pioneer, self._news, Guide(legs, factors), self._terminal)
        try:
            self._terminal.hold(drive.step, PERIOD)
        finally:
            self._pioneer.stop()
            publish(self._motors, MotorState(state=0))      # so that it can be pushed
        return drive.track

    def info(self) -> RobotInfo:
        """Return the newest robot_info. Raises NoAnswerError."""
        return self._wait(RobotInfo, "robot_info")

    def own_numbers(self) -> OwnNumbers:
        """Return what the robot reports of its own calibration; nothing if it does not."""
        try:
            told = self._wait(Calibration, "calibration", 2.0)
        except NoAnswerError:
            return OwnNumbers()
        # of a robot that uses its gyro for its heading, RevCount decides little
        return OwnNumbers(told.ticks_mm or None, told.rev_count if told.rev_count and told.gyro < 2 else None,
                          told.drift_factor if told.drift_factor > -0x8000 else None)

    def _wait(self, kind: type, topic: str, patience: float = PATIENCE) -> Any:
        end = time.monotonic() + patience
        while kind not in self._latest:
            if time.monotonic() > end or rospy.is_shutdown():
                raise NoAnswerError("%s has not come within %.0f s: does a p2os_driver of this package run?" % (
                    topic, patience))
            time.sleep(PERIOD)
        return self._latest[kind]

    def tell(self, new: Dict[str, int]) -> None:
        """Tell the robot its own numbers through the driver's parameters, and wait until it reports them.

        Raises:
            NotConfirmedError: it does not.
        """
        from dynamic_reconfigure.client import Client       # needed only here

        driver = self._latest[Calibration]._connection_header["callerid"]
        try:
            Client(driver, timeout=TOLD_PATIENCE).update_configuration(new)
        except Exception as error:      # dynamic_reconfigure raises several, and bare ones
            raise NotConfirmedError("%s did not take %s: %s" % (driver, new, error)) from error
        end = time.monotonic() + TOLD_PATIENCE
        while any(getattr(self._latest[Calibration], name) != value for name, value in new.items()):
            if time.monotonic() > end:
                raise NotConfirmedError("the robot does not report %s after %.0f s: the driver's log says why" % (
                    new, TOLD_PATIENCE))
            time.sleep(PERIOD)


class HeldDrive:
    """One run: keys, poses and sonar to velocities. `step` is called again and again.

    Args:
        pioneer: the robot.
        news: poses and turn rates since the last look, oldest first. They are taken from it.
        guide: of the run.
        terminal: the person's.
    """

    def __init__(self, pioneer: Pioneer, news: Deque[Any], guide: Guide, terminal: Terminal) -> None:
        self._pioneer, self._news, self._guide, self._terminal = pioneer, news, guide, terminal
        self._recorder, self._lookout = TrackRecorder(), Lookout()
        self._wanted = STAND
        self._said = ""
        self._motors_on = False
        self._publish_at, self._moved_at = -math.inf, math.inf
        news.clear()

    @property
    def track(self) -> OdometryTrack:
        """What was measured."""
        return self._recorder.track

    def step(self, held: bool, now: float) -> bool:
        """Look, and tell the robot what to do. Return whether the run goes on.

        Args:
            held: whether the key is held.
            now: time (monotonic, s).
        """
        fresh = self._take_news()
        if self._guide.done:
            return False
        why_not = self._lookout.why_not(self._pioneer.snapshot(), self._guide.leg)
        drives = held and not why_not
        if not drives or self._wanted == STAND or self._guide.moves:
            self._moved_at = now
        self._say(why_not or (LOCKED if now - self._moved_at > UNMOVED else "") if held else "")
        if not drives:
            self._pioneer.stop()
        elif not self._motors_on:       # that takes a while: then look again before it drives
            self._pioneer.enable_motors()
            self._motors_on = True
        elif fresh or now >= self._publish_at:
            self._pioneer.drive(*self._wanted)
            self._publish_at = now + REPEAT
        return True

    def _take_news(self) -> bool:
        """Take poses and turn rates. Return whether there was a pose."""
        fresh = False
        while self._news:
            message = self._news.popleft()
            stamp = message.header.stamp.to_sec()
            if isinstance(message, Imu):
                self._recorder.rate(stamp, message.angular_velocity.z)
                continue
            place, turn = message.pose.pose.position, message.pose.pose.orientation
            pose = Pose(place.x, place.y, heading_of(turn.x, turn.y, turn.z, turn.w))
            self._recorder.pose(pose)
            self._wanted, fresh = self._guide.step(pose, stamp), True
        return fresh

    def _say(self, why_not: str) -> None:
        if why_not and not self._said:
            self._terminal.say("It stands: %s. It goes on by itself when that is over." % why_not)
        self._said = why_not


def subject_on_topics(robot: RobotOnTopics) -> Subject:
    """Return the robot that a driver has.

    Raises:
        PioneerError: nobody tells, or its models file cannot be read here.
    """
    info = robot.info()
    driver = info._connection_header["callerid"]
    name = rospy.get_param(driver + "/model", "") or info.subtype
    file = rospy.get_param(driver + "/models_file", "")
    return Subject(find_model(name, file or None), file)


def subject_of_bag(subtype: str, given: argparse.Namespace) -> Subject:
    """Return the robot of a bag. Raises UsageError: nobody says which model it is."""
    name = given.model or subtype
    if not name:
        raise UsageError("%s does not say which robot it is (it has no robot_info): name its model, --model p3dx-sh for"
                         " example" % given.bag)
    return Subject(find_model(name, given.models_file or None), given.models_file)


def runs_from_bag(terminal: Terminal, given: argparse.Namespace) -> Tuple[Subject, List[TapedRun]]:
    """Return the robot of a bag, and its runs with what the person reads from the tape, or has noted.

    Raises:
        PioneerError: the bag cannot be used.
    """
    recorded = runs_of_bag(given.bag, given.robot)
    subject = subject_of_bag(recorded.subtype, given)
    if recorded.damage:
        terminal.say("Of this bag not everything can be read: %s" % recorded.damage)
    if not recorded.pieces:
        raise UsageError("%s has no run: no line of 1 m, no turn on the spot, no square, with a rest of 5 s before"
                         " and after" % given.bag)
    terminal.say("%d runs look like one. What was none is passed over with %s." % (len(recorded.pieces), SKIP))
    marks, runs = ask_marks(terminal, subject.marks), []
    for number, piece in enumerate(recorded.pieces, 1):
        terminal.say("\nRun %d, %s, %s." % (number, name_of(piece.kind, piece.turns), in_words(piece)))
        turns = piece.turns
        if piece.kind is RunKind.TURN:
            counted = ask_turns(terminal, piece.turns)
            if counted is None:
                continue
            turns = counted
        tape = ask_tape(terminal, words.READ[piece.kind], piece.kind, marks, skip=SKIP)
        if tape is not None:
            runs.append(TapedRun(piece.kind, turns, piece.track, tape, marks))
    if not runs:
        raise UsageError("all runs of %s were passed over: there is nothing to calibrate with" % given.bag)
    return subject, runs


def ask_turns(terminal: Terminal, likely: int) -> Optional[int]:
    """Ask how many whole turns a run had, until it is legal. None: it was no run."""
    while True:
        answer = terminal.ask("How many whole turns were meant (left positive, right negative)? [%d] " % likely)
        if answer.strip() == SKIP:
            return None
        try:
            return whole_turns(answer, likely)
        except UsageError as error:
            terminal.say("%s." % error)


def plan_given(given: argparse.Namespace) -> RunPlan:
    """Return the plan of the command line. Raises UsageError."""
    if given.quick:
        plan = plan_of(given.line, 0.0, 1)
        return RunPlan(plan.runs[:2] + plan.runs[-1:], plan.proof[:1])
    return plan_of(given.line, given.side, given.repeats)


def keep(terminal: Terminal, subject: Subject, found: Estimate, given: argparse.Namespace, rest: Factors,
         new: Dict[str, int]) -> None:
    """Write the models file, and say what it is for."""
    counted = of_counts(found.factors, subject.model)
    head = words.head_of_file(found, subject.rad_per_metre, ["%s: %d" % each for each in new.items()],
                              time.strftime("%Y-%m-%d"))
    values = values_of_file(counted, rest, subject.model, found)
    terminal.say("\nmodels: {%s: %s}" % (subject.model.subtype, values))    # also when the file cannot be written
    write_models_file(given.file, subject.model.subtype, values, subject.models_file, head)
    terminal.say("\nWritten: %s. Use it from now on:\n  roslaunch pioneer_control pioneer.launch models_file:=%s" % (
        given.file, shlex.quote(os.path.abspath(given.file))))


def on_topics(terminal: Terminal, given: argparse.Namespace) -> None:
    """Lead through a calibration. Raises PioneerError."""
    plan = plan_given(given)
    robot = RobotOnTopics(given.robot, terminal)
    subject = subject_on_topics(robot)
    conversation = Conversation(terminal, robot, plan, subject.rad_per_metre)
    marks = conversation.begin(subject.marks)
    found = conversation.calibrate(marks)
    counted, own, new = of_counts(found.factors, subject.model), robot.own_numbers(), {}
    drift_unit = None if given.drift_unit is None else math.radians(given.drift_unit)
    if given.tell_robot:
        new = told_by(terminal, robot, own, lambda: numbers_to_tell(counted, subject.nominal, own, drift_unit))
        changes = ["%s %d -> %d" % (name, getattr(own, name), value) for name, value in new.items()]
        terminal.say("\nTold the robot: %s. It forgets them when the driver ends: give them to the driver as"
                     " parameters." % (", ".join(changes) or "nothing"))
    rest = after_telling(counted, own, new, drift_unit)
    keep(terminal, subject, found, given, rest, new)
    counts = Factors(rest.distance / counted.distance, rest.turn / counted.turn)
    terminal.say(conversation.prove(marks, of_driver(rest, subject.model), counts))


def told_by(terminal: Terminal, robot: RobotOnTopics, own: OwnNumbers,
            wanted: Callable[[], Dict[str, int]]) -> Dict[str, int]:
    """Tell the robot its new numbers, and return those that it has taken. If it takes none, no work is lost.

    ``wanted`` returns the numbers, or raises a PioneerError: no robot can be told such a number.
    """
    new: Dict[str, int] = {}
    try:
        new = wanted()
        if not new:
            terminal.say("\nThe robot reports no numbers of its own that it could be told: the file has all.")
            return {}
        robot.tell(new)
    except PioneerError as error:
        terminal.say("\nNot told: %s. The file has what the robot does not." % error)
        now = robot.own_numbers()
        return {name: getattr(now, name) for name in new if getattr(now, name) != getattr(own, name)}
    return new


def on_bag(terminal: Terminal, given: argparse.Namespace) -> None:
    """Calibrate from a bag. Raises PioneerError."""
    subject, runs = runs_from_bag(terminal, given)
    found = check(runs, subject.rad_per_metre)
    terminal.say("\n" + words.result(found, subject.rad_per_metre))
    keep(terminal, subject, found, given, of_counts(found.factors, subject.model), {})


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(prog="calibrate", description="Calibrate a robot with a tape measure.")
    made.add_argument("robot", nargs="?", default="pioneer", help="namespace of the robot (default: %(default)s)")
    made.add_argument("--file", default="my_robots.yaml", metavar="NEW.yaml",
                      help="models file that is written; must not be there yet (default: %(default)s)")
    made.add_argument("--line", type=float, default=5.0, metavar="M", help="length of the line (default: %(default)s)")
    made.add_argument("--side", type=float, default=2.0, metavar="M",
                      help="side of the squares; 0: no squares (default: %(default)s)")
    made.add_argument("--repeats", type=int, default=2, metavar="N",
                      help="how often all is driven (default: %(default)s)")
    made.add_argument("--quick", action="store_true", help="one turn each way and one line: 7 minutes, and less sure")
    made.add_argument("--tell-robot", action="store_true",
                      help="tell the robot its own TicksMM and RevCount, too; the file has the rest")
    made.add_argument("--drift-unit", type=float, metavar="DEG_M",
                      help="with --tell-robot, to tell DriftFactor: degrees to the left in each metre that one unit"
                           " of it adds on this robot")
    made.add_argument("--bag", metavar="RUNS.bag", help="read the runs from a bag; ask for what the tape said")
    made.add_argument("--model", default="", help="with --bag: model of the robot, if the bag does not tell it")
    made.add_argument("--models-file", default="", metavar="FILE",
                      help="with --bag: the models file that the driver used when it was recorded")
    return made


def main() -> int:
    """Run the program. Return the exit code: 0 calibrated, 1 not calibrated, 2 a wrong argument."""
    given = parser().parse_args(rospy.myargv()[1:])
    source = sys.stdin.fileno()
    try:
        check_new_file(given.file)
        plan_given(given)
        if given.drift_unit is not None and not 1e-9 < abs(given.drift_unit) < 1.0:
            raise UsageError("--drift-unit is %g: give degrees in each metre, from -1 to 1, not 0" % given.drift_unit)
        for option, value, needed in (("--model", given.model, "--bag"), ("--models-file", given.models_file, "--bag"),
                                      ("--drift-unit", given.drift_unit, "--tell-robot")):
            if value and not getattr(given, needed.strip("-").replace("-", "_")):
                raise UsageError("%s counts with %s only" % (option, needed))
        if given.bag is not None and given.tell_robot:
            raise UsageError("--tell-robot needs a robot: with --bag there is none")
        if given.bag is None and not os.isatty(source):
            raise UsageError("there is no terminal to read keys from: a person has to hold a key while it drives")
    except UsageError as error:
        print("calibrate: %s" % error, file=sys.stderr)
        return 2
    try:
        if given.bag is not None:
            on_bag(Terminal(source, lambda: False, each_key), given)
        else:
            init_node(name_for("calibrate", given.robot))
            on_topics(Terminal(source, rospy.is_shutdown, each_key), given)
    except CalibrationError as error:
        print("\n%s." % error)
        return 1
    except rospy.ROSInterruptException:
        print("\nThe robot stands: the program ends. Nothing more is written.")
        return 1
    except TerminalClosed as error:
        print("\nThe robot stands: %s. Nothing more is written." % error)
        return 1
    except PioneerError as error:
        print("calibrate: %s" % error, file=sys.stderr)
        return 1
    return 0

"""Play a bag to a program, and compare its commands with the recorded commands: ``replay rerun FILE.bag``.

``rosbag play`` publishes the bag with its own clock, and the recorded commands under ``recorded/``. The program
publishes its commands under ``rerun/``. So no robot receives any of these commands. The program gets the parameters
that it had in the recorded run, as far as the bag contains them.
"""

import argparse
import contextlib
import math
import os
import shlex
import subprocess
import time
from typing import Any, Dict, List, Sequence

import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool

from ...errors import UsageError
from ...msg import Decision
from ..command_line import bag_files, check_alone, free_name, number, parser_of, say
from .commands import RERUN, TOLD, absolute, aside, player, read_commands, recorded_topics
from .programs import (PATIENCE, Interrupted, TopicRecorder, connected, graph, possible_robots,
                       restore_parameter, run_as_node, running, wait_until)
from .redrive_schedule import VELOCITIES
from .rerun_compare import Verdict, judge_decisions, judge_others, judge_velocities, velocities_of

KINDS = {"decision": Decision, **TOLD}
"""The topics that a re-run compares, decisions and commands: message class by the topic's last name."""
SERVICES = ("set_motors", "enable_motors", "disable_motors", "set_sonar", "set_laser_power", "reset_odometry",
            "dio_out", "set_joystick_drive", "dock", "undock", "teleop/release")
"""Services of a driver. They get other names for the program, so that it cannot call those of a real driver."""
PLAYER = "/play_rerun"
SETTLED = 1.0
"""When the program has made no new subscription for this time (s), it is taken as ready."""
WAITS_FOR_TIME = 5.0
"""A time in s. The program may subscribe to /clock, but to no topic of the bag, for so long.

Then it probably waits for ROS time to run, and the bag is started.
"""
QUIET = 10.0
"""When the program publishes no command for this time after the end of the bag (s), the re-run ends."""
LAST_WORD = 0.5
"""A shorter time than `QUIET` (s), for a program that has published as many decisions as the bag contains."""


OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(help="the bag; or, in quotes, the parts of one recording or a pattern for them"),
    "--robot": dict(default="", help="namespace of the robot (default: the only one that received commands)"),
    "--package": dict(default="pioneer_control", help="package of the program (default: %(default)s)"),
    "--program": dict(default="rosPioneer2.py", help="name of the program for rosrun (default: %(default)s)"),
    "--args": dict(default="", help="arguments of the program, as one text (default: none; for rosPioneer2.py the "
                   "robot)"),
    "--options": dict(default="", help="options of rosbag play, as one text: '-r 2'"),
    "--enough": dict(default="0.95", metavar="SHARE",
                     help="share of the time for which velocities must be alike, if the program publishes no decisions "
                     "(default: %(default)s)"),
    "--output": dict(default="", metavar="NEW.bag", help="the bag to write (default: beside the old bag)"),
}
"""The command-line options of ``replay rerun``, with the arguments of argparse for each."""


def decided(decisions: Sequence[Any]) -> Dict[str, Any]:
    """Return the parameters with which a Pioneer makes the recorded decisions again.

    ``seed`` is the recorded seed. ``begin_at`` and ``end_at`` are the times of the first and the last decision of each
    wander (s).

    Args:
        decisions: the recorded Decision messages, in their order.
    """
    stamps: Dict[int, List[float]] = {}
    for decision in decisions:
        stamps.setdefault(decision.wander, []).append(decision.header.stamp.to_sec())
    parameters: Dict[str, Any] = {"begin_at": [min(each) for each in stamps.values()],
                                  "end_at": [max(each) for each in stamps.values()]}
    if decisions and abs(decisions[0].seed) < 2 ** 31:  # the parameter server takes only 32 bits
        parameters["seed"] = decisions[0].seed
    return parameters


def compare(live: Dict[str, list], again: Dict[str, list], enough: float) -> Verdict:
    """Compare the commands of the program in the re-run with the recorded ones.

    If the bag contains decisions, only the decisions count. If not, velocities and gripper commands count. Commands on
    cmd_motor_state are reported, but never count: a program sends them only when the motors are not yet on.

    Args:
        live: the recorded commands: lists of (time in s, message) by the topic's last name.
        again: the commands in the re-run, in the same form.
        enough: the share of the time for which the velocities must be alike (0 to 1).
    """
    verdicts = {name: _verdict(name, live.get(name, []), again.get(name, []), enough)
                for name in KINDS if live.get(name) or again.get(name)}
    same = (verdicts["decision"].same if live.get("decision")
            else all(verdict.same for name, verdict in verdicts.items() if name != "cmd_motor_state"))
    return Verdict(same, [sentence for verdict in verdicts.values() for sentence in verdict.sentences])


def _verdict(name: str, before: Sequence[Any], now: Sequence[Any], enough: float) -> Verdict:
    """Compare the commands on one topic.

    Args:
        name: the last name of the topic.
        before: the recorded commands, (time in s, message).
        now: the commands in the re-run, (time in s, message).
        enough: the share of the time for which velocities must be alike (0 to 1).
    """
    if name in VELOCITIES:
        return judge_velocities(name, velocities_of(before), velocities_of(now), enough)
    messages = [message for _, message in before], [message for _, message in now]
    if name != "decision":
        return judge_others(name, *messages)
    # the bag may have no decisions: then there is nothing to compare with
    return judge_decisions(*messages) if before else Verdict(
        True, ["no decisions live, %s in the re-run: what was commanded counts." % len(now)])


class Rerun:
    """One re-run: it plays a bag to a program, and compares the commands. Call `run`.

    Args:
        given: the parsed command line.

    Raises:
        UsageError: the bag or an option is not usable. Nothing has been started then.
    """

    def __init__(self, given: argparse.Namespace) -> None:
        if {"-l", "--loop"} & set(shlex.split(given.options)):
            raise UsageError("a program hears the bag once in a re-run: leave -l out of the options")
        self._given = given
        self._enough = number("enough", given.enough, 0.0, 1.0)
        self._files = bag_files(given.bag)
        self._topics = recorded_topics(self._files)
        self._live = read_commands(self._files, given.robot, KINDS)
        # when the bag does not contain the name of the node, the program's name is used
        self._node = next((self._live.senders[name] for name in KINDS if self._live.senders.get(name)),
                          "/" + os.path.splitext(os.path.basename(given.program))[0])
        self._parameters = self._live.parameters_of(self._node)
        self._robot = "/" + self._live.robot if self._live.robot else ""
        self._decisions = [message for _, message in self._live.messages.get("decision", [])]
        self._time = rospy.Time.from_sec(self._live.begin)

    def run(self) -> int:
        """Start the program, play the bag to it, and compare its commands with the recorded ones.

        Returns:
            The exit code. 0: the commands are the same. 1: they are not.

        Raises:
            PioneerError: the re-run could not begin, or ended early.
        """
        check_alone(self._node)
        self._look_out()
        recorder = TopicRecorder(self._given.output or free_name(self._files[0], "rerun"), lambda: self._time)
        # this node has started without simulated time, so its own clock does not follow /clock
        rospy.Subscriber("/clock", Clock, self._hear_clock, queue_size=1)
        for name, kind in KINDS.items():
            topic = "%s/%s" % (self._robot, name)
            rospy.Subscriber(aside(topic, RERUN), kind, recorder.write, topic)
        with contextlib.ExitStack() as at_end:
            for name in ("/use_sim_time", self._node):
                at_end.callback(restore_parameter, name, rospy.get_param(name, None))
            at_end.enter_context(recorder)
            rospy.set_param("/use_sim_time", True)
            rospy.set_param(self._node, dict(self._parameters, **decided(self._decisions)))
            self._play(recorder, at_end)
        return self._judge(recorder)

    def _hear_clock(self, message: Clock) -> None:
        self._time = message.clock

    def _look_out(self) -> None:
        """Raise UsageError when a robot is on the ROS master, before or during the re-run.

        A program that ignores remappings would command this robot.
        """
        others = [other for other in possible_robots() if other.split()[0] not in (PLAYER, self._node)]
        if others:
            raise UsageError("%s is on this master: the program could reach it, and what it reports would mix with the "
                             "bag. End that first, or take a master of its own "
                             "(export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others))

    def _play(self, recorder: TopicRecorder, at_end: contextlib.ExitStack) -> None:
        """Start ``rosbag play`` and the program, play the bag when they are connected, and wait for the last command.

        Args:
            recorder: records the commands of the program.
            at_end: gets what ends the two processes.
        """
        given = self._given
        own = ["%s %s" % each for each in sorted(self._parameters.items()) if not isinstance(each[1], dict)]
        told = (" with %s." % ", ".join(own) if self._parameters else
                "; the bag does not tell which parameters it had, and it gets none.")
        say("%s hears %s as %s%s" % (given.program, " ".join(self._files), self._node, told))
        command = player(self._files, self._topics, ["--pause", "--quiet", *shlex.split(given.options)])
        bag = at_end.enter_context(running([*command, "__name:=" + PLAYER[1:]], quiet=True))
        rospy.wait_for_service(PLAYER + "/pause_playback", PATIENCE)
        namespace, _, name = self._node.rpartition("/")
        ours = (given.package, given.program) == ("pioneer_control", "rosPioneer2.py")
        arguments = shlex.split(given.args) if given.args else [self._live.robot] if ours else []
        out_of_reach = ["%s/%s" % (self._robot, each) for each in (*KINDS, *SERVICES)]
        elsewhere = ["%s:=%s" % (topic, aside(topic, RERUN)) for topic in out_of_reach]
        command = ["rosrun", given.package, given.program, *arguments, *elsewhere, "__name:=" + name]
        program = at_end.enter_context(running(command, namespace or "/"))
        self._wait_for_subscribers(program, bag)
        rospy.ServiceProxy(PLAYER + "/pause_playback", SetBool)(False)
        self._wait_for_end(bag, program, recorder)

    def _wait_for_subscribers(self, program: subprocess.Popen, bag: subprocess.Popen) -> None:
        """Wait until the program has made all its subscriptions, or seems to wait for ROS time to run.

        Args:
            program: the process of the program.
            bag: the process of ``rosbag play``.
        """
        played = {absolute(topic) for topic in self._topics}
        before: Any = None
        since = time.monotonic()

        def ready() -> bool:
            nonlocal before, since
            heard = {topic for topic, names in graph()[1].items() if self._node in names}
            if heard != before:
                before, since = heard, time.monotonic()
            unchanged = time.monotonic() - since
            if heard & played:
                return unchanged > SETTLED and connected(PLAYER, self._node, heard)
            return bool(heard) and unchanged > WAITS_FOR_TIME

        wait_until("%s to be there" % self._given.program, ready, [program, bag], watch=self._look_out)

    def _wait_for_end(self, bag: subprocess.Popen, program: subprocess.Popen, recorder: TopicRecorder) -> None:
        """Wait until the bag has been played, and the program has published its last command.

        Args:
            bag: the process of ``rosbag play``.
            program: the process of the program.
            recorder: records the commands of the program.
        """
        wait_until("the bag to be over", lambda: bag.poll() is not None, patience=math.inf, watch=self._look_out,
                   is_done="the bag was over")
        ended = time.monotonic()

        def has_ended() -> bool:
            all_said = 0 < len(self._decisions) <= recorder.counts[self._robot + "/decision"]
            quiet = time.monotonic() - max(recorder.heard_at, ended)
            return program.poll() is not None or quiet > (LAST_WORD if all_said else QUIET)

        with contextlib.suppress(Interrupted):      # the commands up to then are compared
            wait_until("its last word", has_ended, patience=math.inf, watch=self._look_out)
        if program.poll():
            say("%s ended with exit code %s." % (self._given.program, program.poll()))

    def _judge(self, recorder: TopicRecorder) -> int:
        """Compare the commands, and print the result. Return the exit code: 0 if the commands are the same, else 1."""
        again = read_commands([recorder.path], self._live.robot, KINDS).messages if recorder.counts else {}
        verdict = compare(self._live.messages, again, self._enough)
        same = "THE SAME on the bag as" if verdict.same else "SOMETHING ELSE on the bag than"
        commands = same + " beside the robot" if again else "NOTHING on the bag"
        say("\n" + "\n".join([*verdict.sentences, "%s commands %s." % (self._given.program, commands),
                              *["bag      %s" % recorder.path] * bool(again)]))
        return 0 if verdict.same else 1


def main(arguments: Sequence[str]) -> int:
    """Run ``replay rerun``.

    Args:
        arguments: the words of the command line after ``rerun``.

    Returns:
        The exit code. 0: the program sent the same commands. 1: it sent others, or the re-run ended early. 2: the ROS
        master or the bag does not allow the re-run.

    Raises:
        UsageError: the bag or an option is not usable, or the node cannot start.
    """
    given = parser_of("replay rerun",
                      "Play a bag to a program, and compare its commands with the recorded commands.",
                      OPTIONS).parse_args(arguments)
    return run_as_node("rerun", Rerun(given).run)

"""Let a program hear the bag, and compare what it commands with what it commanded then: ``replay rerun FILE.bag``.

The bag is played with its own clock. The commands in it come back under ``recorded/``; what the program commands goes
under ``rerun/``. Neither reaches a robot. The program gets the parameters that it had, as far as the bag tells.
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
from ..command_line import bag_files, free_name, number, parser_of, say
from .commands import RERUN, TOLD, absolute, aside, player, read_commands, recorded_topics
from .programs import (PATIENCE, Interrupted, TopicRecorder, connected, graph, nodes, possible_robots,
                       restore_parameter, run_as_node, running, wait_until)
from .redrive_schedule import VELOCITIES
from .rerun_compare import Verdict, judge_decisions, judge_others, judge_velocities, velocities_of

KINDS = {"decision": Decision, **TOLD}
"""What a program commands, and why: message by the topic's last name."""
SERVICES = "set_motors", "enable_motors", "disable_motors", "set_sonar", "reset_odometry"
"""Services of a driver. The program does not reach those of a driver that is alive."""
PLAYER = "/play_rerun"
LOOK_OUT = 0.3
"""s between two looks for robots that have come."""
SETTLED = 1.0
"""s in which the program subscribes to no more topics. Then it listens to all it is going to listen to."""
WAITS_FOR_TIME = 5.0
"""s in which the program listens to the clock alone. Then it wants to see the time go on first."""
QUIET = 10.0
"""s without a word from the program. Then it has nothing more to say."""
LAST_WORD = 0.5
"""s without a word from a program that has made as many decisions as are in the bag."""


OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(help="the bag; several, or a pattern, in quotes: the parts of one recording"),
    "--robot": dict(default="", help="namespace of the robot (default: the only one that was commanded something)"),
    "--package": dict(default="pioneer_control", help="of the program (default: %(default)s)"),
    "--program": dict(default="rosPioneer2.py", help="as rosrun knows it (default: %(default)s)"),
    "--args": dict(default="", help="of the program, in one text (default: none; of rosPioneer2.py the robot)"),
    "--options": dict(default="", help="of rosbag play, in one text: '-r 2'"),
    "--enough": dict(default="0.95", metavar="SHARE",
                     help="of the time that commands must be alike, of a program without decisions (default: "
                     "%(default)s)"),
    "--output": dict(default="", metavar="NEW.bag", help="where what it commands is kept (default: beside the bag)"),
}
"""Of the command line; replay.launch has arguments of the same names."""


def decided(decisions: Sequence[Any]) -> Dict[str, Any]:
    """Parameters with which a Pioneer decides the same again.

    They are the seed, and when (s) each wander decided first and last.

    Args:
        decisions: messages, in their order.
    """
    stamps: Dict[int, List[float]] = {}
    for decision in decisions:
        stamps.setdefault(decision.wander, []).append(decision.header.stamp.to_sec())
    parameters: Dict[str, Any] = {"begin_at": [min(each) for each in stamps.values()],
                                  "end_at": [max(each) for each in stamps.values()]}
    if decisions and abs(decisions[0].seed) < 2 ** 31:  # the parameter server takes no more
        parameters["seed"] = decisions[0].seed
    return parameters


def compare(live: Dict[str, list], again: Dict[str, list], enough: float) -> Verdict:
    """Compare everything that was commanded. Decisions count. Where there are none, velocities and gripper do.

    Whether a program asks for the motors depends on whether they are on already. So that is told, but does not count.

    Args:
        live: what was commanded beside the robot: (s, message) by the topic's last name.
        again: likewise, on the bag.
        enough: share of the time for which velocities must be alike.
    """
    verdicts = {name: _verdict(name, live.get(name, []), again.get(name, []), enough)
                for name in KINDS if live.get(name) or again.get(name)}
    same = (verdicts["decision"].same if live.get("decision")
            else all(verdict.same for name, verdict in verdicts.items() if name != "cmd_motor_state"))
    return Verdict(same, [sentence for verdict in verdicts.values() for sentence in verdict.sentences])


def _verdict(name: str, before: Sequence[Any], now: Sequence[Any], enough: float) -> Verdict:
    """Compare what was commanded on one topic; the arguments are as those of `compare`."""
    if name in VELOCITIES:
        return judge_velocities(name, velocities_of(before), velocities_of(now), enough)
    messages = [message for _, message in before], [message for _, message in now]
    if name != "decision":
        return judge_others(name, *messages)
    # recorded without decisions, or by another program: there is nothing to compare with
    return judge_decisions(*messages) if before else Verdict(
        True, ["no decisions live, %s in the re-run: what was commanded counts." % len(now)])


class Rerun:
    """One re-run. Call `run`.

    Args:
        given: the command line.

    Raises:
        UsageError: the command line makes no sense. Nothing is started yet.
    """

    def __init__(self, given: argparse.Namespace) -> None:
        if {"-l", "--loop"} & set(shlex.split(given.options)):
            raise UsageError("a program hears the bag once in a re-run: leave -l out of the options")
        self._given = given
        self._enough = number("enough", given.enough, 0.0, 1.0)
        self._files = bag_files(given.bag)
        self._topics = recorded_topics(self._files)
        self._live = read_commands(self._files, given.robot, KINDS)
        # where the bag does not say who commanded, the program's name is the node's
        self._node = next((self._live.senders[name] for name in KINDS if self._live.senders.get(name)),
                          "/" + os.path.splitext(os.path.basename(given.program))[0])
        self._parameters = self._live.parameters_of(self._node)
        self._robot = "/" + self._live.robot if self._live.robot else ""
        self._decisions = [message for _, message in self._live.messages.get("decision", [])]
        self._time = rospy.Time.from_sec(self._live.begin)
        self._looked_out = 0.0

    def run(self) -> int:
        """Let the program hear the bag.

        Returns:
            The exit code: 0 it commands the same again, 1 it does not.
        """
        self._refuse_company()
        recorder = TopicRecorder(self._given.output or free_name(self._files[0], "rerun"), lambda: self._time)
        # this node began with the time of day, and keeps it
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

    def _refuse_company(self) -> None:
        """Refuse a node of the program's name, and robots on this master: the program must hear the bag alone."""
        if self._node in nodes():
            raise UsageError("%s is running: a program of that name was recorded, and would end it. End it first"
                             % self._node)
        others = possible_robots()
        if others:
            raise UsageError("%s is on this master: the program could reach it, and what it reports would mix with the "
                             "bag. End that first, or take a master of its own "
                             "(export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others))

    def _look_out(self) -> None:
        """End the re-run when a robot comes meanwhile: a program that ignores remappings would command it.

        Raises:
            UsageError: a robot has come.
        """
        if time.monotonic() - self._looked_out < LOOK_OUT:
            return
        self._looked_out = time.monotonic()
        others = [other for other in possible_robots() if other.split()[0] not in (PLAYER, self._node)]
        if others:
            raise UsageError("%s has come to this master: the program could reach it, so the re-run ends here"
                             % ", ".join(others))

    def _play(self, recorder: TopicRecorder, at_end: contextlib.ExitStack) -> None:
        """Start everything, and let the bag run when all is connected.

        Args:
            recorder: hears what the program commands.
            at_end: ends what is started.
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
        """Wait until the program listens to all it is going to, or seems to wait for the time to go on."""
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
        """Wait until the bag is over and the program has said all it has to say."""
        wait_until("the bag to be over", lambda: bag.poll() is not None, patience=math.inf, watch=self._look_out,
                   is_done="the bag was over")
        ended = time.monotonic()

        def has_ended() -> bool:
            all_said = 0 < len(self._decisions) <= recorder.counts[self._robot + "/decision"]
            quiet = time.monotonic() - max(recorder.heard_at, ended)
            return program.poll() is not None or quiet > (LAST_WORD if all_said else QUIET)

        with contextlib.suppress(Interrupted):      # what it has said until then is judged
            wait_until("its last word", has_ended, patience=math.inf, watch=self._look_out)
        if program.poll():
            say("%s ended with exit code %s." % (self._given.program, program.poll()))

    def _judge(self, recorder: TopicRecorder) -> int:
        """Say the verdict in plain sentences; returns the exit code."""
        again = read_commands([recorder.path], self._live.robot, KINDS).messages if recorder.counts else {}
        verdict = compare(self._live.messages, again, self._enough)
        same = "THE SAME on the bag as" if verdict.same else "SOMETHING ELSE on the bag than"
        commands = same + " beside the robot" if again else "NOTHING on the bag"
        say("\n" + "\n".join([*verdict.sentences, "%s commands %s." % (self._given.program, commands),
                              *["bag      %s" % recorder.path] * bool(again)]))
        return 0 if verdict.same else 1


def main(arguments: Sequence[str]) -> int:
    """Run it.

    Returns:
        The exit code: 0 it commands the same, 1 something else, 2 it cannot be done as asked.
    """
    given = parser_of("replay rerun",
                      "Let a program hear the bag, and compare what it commands with what it commanded then.",
                      OPTIONS).parse_args(arguments)
    return run_as_node("rerun", Rerun(given).run)

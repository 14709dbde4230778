"""Bring a run back, in one of three ways: ``rosrun pioneer_control replay WAY FILE.bag``, or ``launch/replay.launch``.

===========  ================================================================================================================
``look``     all of the bag comes back, with its own clock and no driver; what commanded comes back under ``recorded/``
``rerun``    a program hears the bag, and what it commands is compared with what was commanded (`rerun`)
``redrive``  what was commanded is commanded again, to a simulated robot, or to a real one when somebody insists (`redrive`)
===========  ================================================================================================================

In none of them does a command of the bag reach anything that was there before.
"""

import argparse
import glob
import os
import re
import shlex
import sys
from typing import Dict, List, Mapping, Optional, Sequence

from ...errors import PioneerError, UsageError
from ..command_line import refuse_launch_arguments
from ..draw import main as draw
from ..names import in_order
from ..reader import BagError, read_bag

RECORDED, RERUN = ASIDE = "recorded", "rerun"
"""Under these names, in the namespace where they would be, commands of a bag come back, and those of a program that hears it go."""

COMMANDS = {
    "cmd_vel": "drives",
    "cmd_wheels": "drives each side",
    "cmd_motor_state": "switches the motors on",
    "gripper_control": "moves the gripper",
    "stop_button": "presses the STOP button of a simulated robot, and lets it go",
    "ptz_control": "moves a camera",
    "joy": "a joystick: who listens to it drives",
    "goal": "sends a navigation, or an arm, on its way",
    "cancel": "ends that",
    "initialpose": "tells a navigation where it is",
}
"""Last names of topics on which something alive would do what it was told once, and what it would do."""

COMMAND_TYPES = "Twist", "TwistStamped", "WheelVelocities"
"""Last names of types of messages that drive, whatever their topic is called."""

WAYS = "look", "rerun", "redrive"

LAUNCH_ARGUMENTS = ("bag", "way", "robot", "rviz", "picture", "frame", "options", "package", "program", "args", "into", "port", "speed", "motors", "world",
                    "numbers_file", "seed")
"""Those of replay.launch."""

QUEUE = ["--queue=100000"]
"""For rosbag play: so many messages may wait on a topic. Who is held up for a moment misses none."""

REMAPPING = re.compile(r"[\w~/]+:=")
"""How a name begins that ROS takes from a command line."""

NAME = re.compile("[A-Za-z/][A-Za-z0-9_/]*")
"""What ROS takes for the name of a topic."""

PREFIX = re.compile(r"--pr|-\w*p")
"""How rosbag play's option --prefix begins, and -p."""


def is_command(topic: str, type_name: str) -> bool:
    """Whether something alive may do what comes on a topic."""
    return topic.rpartition("/")[2] in COMMANDS or type_name.rpartition("/")[2] in COMMAND_TYPES


def aside(topic: str, folder: str = RECORDED) -> str:
    """A topic's name where nothing alive listens: ``/pioneer/cmd_vel`` becomes ``/pioneer/recorded/cmd_vel``."""
    namespace, _, name = absolute(topic).rpartition("/")
    return "%s/%s/%s" % (namespace, folder, name)


def absolute(topic: str) -> str:
    """A topic's whole name; a bag may have it without the slash."""
    return topic if topic.startswith("/") else "/" + topic


def remappings(topics: Mapping[str, str]) -> List[str]:
    """What a player of these topics ({topic: type}) is to be told, so that no command reaches what listens for it."""
    return ["%s:=%s" % (topic, aside(topic)) for topic in sorted({absolute(topic) for topic in topics if is_command(topic, topics[topic])})]


def player(files: Sequence[str], topics: Mapping[str, str], options: Sequence[str] = ()) -> List[str]:
    """The command that plays bags with their own clock: in order of time, parts of one recording or several.

    Raises UsageError for options that would bring commands back elsewhere than under `RECORDED`.
    """
    _check_names(options, topics)
    command = ["rosrun", "rosbag", "play", "--clock", *QUEUE, *options]
    if "/clock" in topics:      # recorded from somebody who made time himself: two clocks would fight
        return command + ["--topics", *sorted(set(topics) - {"/clock"}), "--bags", *files, *remappings(topics)]
    return command + [*files, *remappings(topics)]


def _check_names(options: Sequence[str], topics: Mapping[str, str]) -> None:
    """Whether nothing in the options gives the bag's topics other names than those that were thought of."""
    commands = {absolute(topic) for topic in topics if is_command(topic, topics[topic])}
    for word in options:
        source, given, target = word.partition(":=")
        renamed = bool(REMAPPING.match(word)) and (absolute(source) in commands or is_command(target, ""))
        if renamed or PREFIX.match(word) or source == "__ns" and given:
            raise UsageError("%s is not legal here: what commanded comes back under %s/ in its own namespace, and nowhere else" % (word, RECORDED))


def bag_files(given: str) -> List[str]:
    """The files that a text names: one, several between spaces, or a pattern such as ``run_*.bag``. Raises BagError if one is not there."""
    if os.path.exists(os.path.expanduser(given)):
        return [os.path.expanduser(given)]
    try:
        words = shlex.split(given)
    except ValueError:
        words = [given]
    files: List[str] = []
    for word in map(os.path.expanduser, words):     # no shell does it in bag:=~/FILE.bag
        found = [word] if os.path.exists(word) else in_order(glob.glob(word))
        if not found:
            raise BagError("%s: no such file" % word + ("" if os.path.isabs(word) else " in %s" % os.getcwd()))
        files += found
    if not files:
        raise BagError("no bag is named: give its file, bag:=FILE.bag")
    return files


def recorded_topics(files: Sequence[str]) -> Dict[str, str]:
    """{topic: type} of bags. Raises BagError for what `rosbag play` would not play."""
    import rosbag

    connections = read_bag(files, lambda connection: False).connections     # says what is no bag at all
    for path in files:
        try:
            rosbag.Bag(path, skip_index=True).close()
        except rosbag.ROSBagUnindexedException:
            raise BagError(
                "%s has no index: its recorder is still running or was killed, or it was cut off. When it has ended: rosbag reindex %s" % (path, path)) from None
        except (rosbag.ROSBagException, OSError, EOFError, ValueError) as error:
            raise BagError("%s is damaged: %s. This makes what is left of it a bag again: rosbag reindex %s" % (path, error, path)) from None
    odd = sorted({connection.topic for connection in connections if not NAME.fullmatch(connection.topic)})
    if odd:
        raise BagError("%s: %r is no name of a topic, and rosbag play takes none of the bag: leave it out with rosbag filter" % (" ".join(files), odd[0]))
    if not connections:
        raise BagError("%s: there is nothing in it" % " ".join(files))
    return {connection.topic: connection.type for connection in connections}


def warn_of_robots() -> None:
    """What a robot on this master reports would mix with the bag. Raises UsageError where there is no master: a player would wait for one for ever."""
    from .stage import alive, no_master     # here: it needs all of rospy

    try:
        others = alive()
    except OSError:
        raise no_master() from None
    if others:
        print("replay: %s is on this master. No command of the bag reaches it, but what it reports mixes with the bag: a replay is better "
              "done on a master of its own (export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others), file=sys.stderr)


def yes_or_no(text: str) -> bool:
    """As launch files write it. Raises ArgumentTypeError for anything else."""
    if text.lower() not in ("true", "false"):
        raise argparse.ArgumentTypeError("%r is not legal: give true or false" % text)
    return text.lower() == "true"


def number(name: str, text: str, low: float, high: float) -> float:
    """What was given for an option. Raises UsageError when it is no number from ``low`` to ``high``."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not low <= value <= high:
        raise UsageError("%s: %r is not legal: give a number from %g to %g" % (name, text, low, high))
    return value


def look(arguments: Sequence[str], ros: Sequence[str]) -> int:
    """Become a `rosbag play` that commands nothing."""
    parser = argparse.ArgumentParser(prog="replay look", description="Play a bag back, its commands aside.", allow_abbrev=False,
                                     epilog="Whatever else is given goes to rosbag play: -r 2, -s 30, -l, ...")
    parser.add_argument("bag", help="the bag; several, or a pattern, in quotes: the parts of one recording")
    parser.add_argument("--picture", type=yes_or_no, default=False, metavar="true|false", help="draw it first (default: false)")
    given, options = parser.parse_known_args(arguments)
    files = bag_files(given.bag)
    command = player(files, recorded_topics(files), [*options, *ros])
    if given.picture:
        draw([*files, "--parts"])
    warn_of_robots()
    sys.stdout.flush()
    os.environ.pop("ROS_NAMESPACE", None)   # names in the bag may be without a slash: they are not below the namespace of this shell
    os.execvp(command[0], command)


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Replay in the way that is named. Returns the exit code: 0 done, 1 it came out otherwise, 2 it cannot be done as asked."""
    words = list(sys.argv[1:] if argv is None else argv)
    ros = [word for word in words if REMAPPING.match(word)]     # names and remappings that roslaunch gives every node
    way, *arguments = [word for word in words if not REMAPPING.match(word)] or ["-h"]
    try:
        refuse_launch_arguments(ros, LAUNCH_ARGUMENTS)
        if way == "look":
            return look(arguments, ros)
        if way == "rerun":
            from .rerun import main as rerun
            return rerun(arguments)
        if way == "redrive":
            from .redrive import main as redrive
            return redrive(arguments)
        if way in ("-h", "--help"):
            print("usage: replay {%s} FILE.bag ...   (replay WAY --help tells more)\n\n%s" % (",".join(WAYS), __doc__))
            return 0
        raise UsageError("no way to replay is called %r: there are %s" % (way, ", ".join(WAYS)))
    except PioneerError as error:
        print("replay: %s" % error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())

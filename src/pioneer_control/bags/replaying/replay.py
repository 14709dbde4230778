"""Replay a recorded run in one of three ways: ``rosrun pioneer_control replay WAY FILE.bag``, or ``replay.launch``.

===========  =================================================================================================
``look``     plays the whole bag with its own clock and without a robot. Its commands come under ``recorded/``
``rerun``    plays the bag to a program, and compares the commands of the program with the recorded commands
``redrive``  sends the recorded commands to a simulated robot, and compares its path with the recorded path
===========  =================================================================================================

No command of the bag reaches a node that ran before.
"""

import importlib
import os
import sys
from typing import Any, Dict, Optional, Sequence

from ...errors import PioneerError, UsageError
from ..command_line import bag_files, no_master, parser_of, refuse_launch_arguments
from ..draw import main as draw
from .commands import REMAPPING, player, recorded_topics

WAYS = "look", "rerun", "redrive"

LAUNCH_ARGUMENTS = ("bag", "way", "robot", "rviz", "picture", "frame", "model", "options", "package", "program",
                    "args", "speed", "world", "numbers_file", "seed")
"""The names of the arguments of launch/replay.launch. `main` refuses words such as ``speed:=0.5`` on its command line.
"""


LOOK_OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(help="the bag; or, in quotes, the parts of one recording or a pattern for them"),
    "--picture": dict(type=str.lower, choices=("true", "false"), default="false",
                      help="draw the bag first (default: %(default)s)"),
}
"""The command-line options of ``replay look``, with the arguments of argparse for each."""


def warn_of_robots() -> None:
    """Print a warning when robots are on this ROS master, because their messages mix with those of the bag.

    Raises:
        UsageError: no ROS master answers. ``rosbag play`` would wait for a master without end.
    """
    from . import programs      # imported only here, because it needs rospy

    try:
        others = programs.possible_robots()
    except OSError:
        raise no_master() from None
    if others:
        print("replay: %s is on this master. No command of the bag reaches it, but what it reports mixes with the bag: "
              "a replay is better done on a master of its own "
              "(export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others), file=sys.stderr)


def look(arguments: Sequence[str], ros: Sequence[str]) -> int:
    """Replace this process by a ``rosbag play`` that publishes the commands of the bag only under ``recorded/``.

    The function does not return.

    Args:
        arguments: the words of the command line after ``look``.
        ros: the words of the command line that are remappings (``name:=value``). ``rosbag play`` gets them.

    Raises:
        UsageError: the bag or an option is not usable, or no ROS master answers.
    """
    given, options = parser_of(
        "replay look", "Play a bag. Its commands come under recorded/.", LOOK_OPTIONS, allow_abbrev=False,
        epilog="All other options go to rosbag play: -r 2, -s 30, -l, ...").parse_known_args(arguments)
    files = bag_files(given.bag)
    command = player(files, recorded_topics(files), [*options, *ros])
    if given.picture == "true":
        draw([*files, "--parts"])
    warn_of_robots()
    sys.stdout.flush()
    os.environ.pop("ROS_NAMESPACE", None)   # it would change topic names without a slash
    os.execvp(command[0], command)


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Replay a bag in the way that the command line names: look, rerun or redrive.

    Args:
        argv: the words of the command line. None: those of this process.

    Returns:
        The exit code. 0: done. 1: a re-run gave other commands, or a re-run or re-drive ended early. 2: the command
        line, the bag or the state of the ROS master does not allow the replay.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    ros = [word for word in words if REMAPPING.match(word)]     # name:=value, as roslaunch gives to each node
    way, *arguments = [word for word in words if not REMAPPING.match(word)] or ["-h"]
    try:
        refuse_launch_arguments(ros, LAUNCH_ARGUMENTS)
        if way == "look":
            return look(arguments, ros)
        if way in WAYS:     # imported only here, because each needs rospy
            return int(importlib.import_module("." + way, __package__).main(arguments))
        if way in ("-h", "--help"):
            print("usage: replay {%s} FILE.bag ...   (replay WAY --help tells more)\n\n%s" % (",".join(WAYS), __doc__))
            return 0
        raise UsageError("no way to replay is called %r: there are %s" % (way, ", ".join(WAYS)))
    except PioneerError as error:
        print("replay: %s" % error, file=sys.stderr)
        return 2

"""Bring a run back, in one of three ways: ``rosrun pioneer_control replay WAY FILE.bag``, or ``launch/replay.launch``.

===========  ===============================================================================================
``look``     all of the bag comes back, with its own clock and no driver; its commands under ``recorded/``
``rerun``    a program hears the bag, and what it commands is compared with what was commanded then
``redrive``  a simulated robot is told what the recorded robot was told, and their paths are compared
===========  ===============================================================================================

No command of the bag reaches a node that was there before.
"""

import importlib
import os
import sys
from typing import Any, Dict, Optional, Sequence

from ...errors import PioneerError, UsageError
from ..command_line import bag_files, parser_of, refuse_launch_arguments, yes_or_no
from ..draw import main as draw
from .commands import REMAPPING, player, recorded_topics

WAYS = "look", "rerun", "redrive"

LAUNCH_ARGUMENTS = ("bag", "way", "robot", "rviz", "picture", "frame", "options", "package", "program", "args", "speed",
                    "world", "numbers_file", "seed")
"""Those of replay.launch."""


LOOK_OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(help="the bag; several, or a pattern, in quotes: the parts of one recording"),
    "--picture": dict(type=yes_or_no, default=False, metavar="true|false", help="draw it first (default: false)"),
}
"""Of the command line, to look."""


def warn_of_robots() -> None:
    """Say which robots are on this master: what they report would mix with the bag.

    Raises:
        UsageError: there is no master. A player would wait for one for ever.
    """
    from . import programs      # here: it needs all of rospy

    try:
        others = programs.possible_robots()
    except OSError:
        raise programs.no_master() from None
    if others:
        print("replay: %s is on this master. No command of the bag reaches it, but what it reports mixes with the bag: "
              "a replay is better done on a master of its own "
              "(export ROS_MASTER_URI=http://localhost:11411)" % ", ".join(others), file=sys.stderr)


def look(arguments: Sequence[str], ros: Sequence[str]) -> int:
    """Become a ``rosbag play`` that commands nothing.

    Args:
        arguments: of the command line.
        ros: words of it that are for ROS.
    """
    given, options = parser_of(
        "replay look", "Play a bag back, its commands aside.", LOOK_OPTIONS, allow_abbrev=False,
        epilog="Whatever else is given goes to rosbag play: -r 2, -s 30, -l, ...").parse_known_args(arguments)
    files = bag_files(given.bag)
    command = player(files, recorded_topics(files), [*options, *ros])
    if given.picture:
        draw([*files, "--parts"])
    warn_of_robots()
    sys.stdout.flush()
    os.environ.pop("ROS_NAMESPACE", None)   # names in the bag without a slash are not below the namespace of this shell
    os.execvp(command[0], command)


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Replay in the way that is named.

    Returns:
        The exit code: 0 done, 1 it came out otherwise, 2 it cannot be done as asked.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    ros = [word for word in words if REMAPPING.match(word)]     # names and remappings that roslaunch gives every node
    way, *arguments = [word for word in words if not REMAPPING.match(word)] or ["-h"]
    try:
        refuse_launch_arguments(ros, LAUNCH_ARGUMENTS)
        if way == "look":
            return look(arguments, ros)
        if way in WAYS:     # each needs all of rospy
            return int(importlib.import_module("." + way, __package__).main(arguments))
        if way in ("-h", "--help"):
            print("usage: replay {%s} FILE.bag ...   (replay WAY --help tells more)\n\n%s" % (",".join(WAYS), __doc__))
            return 0
        raise UsageError("no way to replay is called %r: there are %s" % (way, ", ".join(WAYS)))
    except PioneerError as error:
        print("replay: %s" % error, file=sys.stderr)
        return 2

"""Words on a command line that were meant for a launch file."""

from typing import Iterable

from ..errors import UsageError


def refuse_launch_arguments(words: Iterable[str], names: Iterable[str]) -> None:
    """``speed:=0.5`` behind ``rosrun`` is to ROS the new name of a topic, and would silently do nothing. `names`: those of the arguments.

    Raises:
        UsageError: one of the words is that.
    """
    for word in words:
        if word.partition(":=")[0] in names:
            raise UsageError("%s: this is how roslaunch is told; --help says how it is said here" % word)

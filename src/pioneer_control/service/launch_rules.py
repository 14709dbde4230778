"""What a launch file may not do when nobody looks on, and what the end of its programs means. Pure.
"""

import difflib
from typing import Any, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

OK, CRASHED, WRONG = 0, 1, 2
"""Exit codes: ended because somebody wanted it; starting again may help; it would not, for a value is wrong."""
SWITCH = "enable_motors_on_start"
MOVERS = ("rosPioneer1.py", "rosPioneer2.py", "rosPioneer3.py")
"""Nodes of this package that switch the motors on when they start, and drive."""


class LaunchedNode(NamedTuple):
    """A node of a launch file."""

    package: str
    type: str
    arguments: str
    """what its attribute ``args`` says"""


def _leaves(name: str, value: Any) -> Iterator[Tuple[str, Any]]:
    """Yield the names and values of all parameters in a value of the parameter server, which may be a tree."""
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _leaves("%s/%s" % (name, key), part)
    else:
        yield name, value


def refusals(nodes: Iterable[LaunchedNode], parameters: Mapping[str, Any]) -> List[str]:
    """Return why a launch file may not run at boot: all that switches motors on with nobody asking. Empty: it may.

    Args:
        nodes: its nodes.
        parameters: its parameters, by their full names.
    """
    found = ["%s is %r: a robot that starts at boot keeps its motors off until somebody asks. Leave it out" % leaf
             for name, value in sorted(parameters.items()) for leaf in _leaves(name, value)
             if leaf[0].rpartition("/")[2] == SWITCH and leaf[1] is not False]
    for node in nodes:
        if "_%s:=" % SWITCH in node.arguments:
            found.append("%s gets _%s as an argument: motors stay off until somebody asks. Leave it out"
                         % (node.type, SWITCH))
        if node.package == "pioneer_control" and node.type in MOVERS:
            found.append("%s switches the motors on and drives as soon as it starts. Start it by hand" % node.type)
    return found


def strangers(nodes: Iterable[LaunchedNode]) -> List[str]:
    """Return the nodes of other packages, as package/type: whether they ask for motors is not known here."""
    known = ("pioneer_control", "robot_state_publisher", "diagnostic_aggregator", "rosbag", "tf", "tf2_ros")
    return sorted({"%s/%s" % (node.package, node.type) for node in nodes if node.package not in known})


def unknown_arguments(given: Sequence[str], known: Iterable[str]) -> List[str]:
    """Return what is wrong with arguments (NAME:=VALUE) of a launch file, in words. roslaunch would ignore them.

    Args:
        given: the arguments.
        known: the names of all arguments of the launch file.
    """
    known, found = sorted(known), []
    for argument in given:
        name = argument.partition(":=")[0]
        near = difflib.get_close_matches(name, known, 1)
        if name not in known:
            found.append("the launch file has no argument %r%s" % (
                name, "; did you mean %s?" % near[0] if near else "; it has: %s" % (", ".join(known) or "none")))
    return found


class Death(NamedTuple):
    """The end of a program that roslaunch did not end itself."""

    required: bool
    exit_code: Optional[int]
    """negative: the number of a signal. None: it was never seen alive"""


def exit_code_of(deaths: Sequence[Death]) -> int:
    """Return the exit code of a run, from all deaths in it. Those of required nodes count; without any, all do."""
    codes = [death.exit_code for death in deaths if death.required] or [death.exit_code for death in deaths]
    if WRONG in codes:
        return WRONG
    return CRASHED if any(code != OK for code in codes) else OK

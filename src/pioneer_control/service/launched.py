"""Checks a launch file with roslaunch's own reader, and runs it as roslaunch does, with an exit code that says how it
ended. roslaunch itself exits with 0 also when a required node has died (seen with roslaunch 1.15.15).
"""

import contextlib
import http.client
import os
import pathlib
import shutil
import sys
import time
from typing import List, NamedTuple, Optional, Sequence

import rosgraph
import rospkg
import roslaunch
import roslaunch.arg_dump
import roslaunch.config
import roslaunch.core
import roslaunch.parent
import roslaunch.pmon
import roslaunch.rlutil
from roslaunch.core import RLException

from ..errors import UsageError
from .launch_rules import (CRASHED, OK, SWITCH, WRONG, Death, LaunchedNode, exit_code_of, refusals, strangers,
                           unknown_arguments)

KEPT_RUNS = 50
"""How many runs of the past keep their logs."""
PATIENCE = 10.0
"""Seconds of waiting for a master before it is told."""
SAID_EVERY = 60.0
"""Seconds between two lines that tell of waiting for a master."""


class Launch(NamedTuple):
    """A launch file that may run at boot."""

    file: str
    arguments: Sequence[str]
    others: Sequence[str]
    """its nodes of other packages: see `launch_rules.strangers`"""


def checked(words: Sequence[str]) -> Launch:
    """Return the launch file that the words of a command line name, checked.

    Raises:
        UsageError: there is no such file, it has mistakes, arguments that it does not know, or switches motors on by
            itself.
    """
    arguments = [word for word in words if ":=" in word]
    try:
        file, *more = roslaunch.rlutil.resolve_launch_arguments([word for word in words if ":=" not in word]) or [""]
        if not file or more:
            raise UsageError("give one launch file: [PACKAGE] FILE [NAME:=VALUE ...]; %r makes no sense"
                             % " ".join(more or words))
        wrong = unknown_arguments(arguments, roslaunch.arg_dump.get_args([(file, arguments)]))
        if wrong:
            raise UsageError("%s: %s" % (file, "; ".join(wrong)))
        config = roslaunch.config.load_config_default([(file, arguments)], None, verbose=False,
                                                      assign_machines=False)
    except (RLException, rospkg.ResourceNotFound) as error:
        raise UsageError("roslaunch %s: %s" % (" ".join(words), error)) from None
    if config.config_errors:
        raise UsageError("%s: %s" % (file, "; ".join(config.config_errors)))
    nodes = [LaunchedNode(node.package, node.type, node.args or "") for node in config.nodes]
    dangers = refusals(nodes, {name: parameter.value for name, parameter in config.params.items()})
    if dangers:
        raise UsageError("%s may not run at boot: %s" % (file, "; ".join(dangers)))
    return Launch(os.path.abspath(file), arguments, strangers(nodes))


class _Undertaker(roslaunch.pmon.ProcessListener):  # type: ignore[misc]  # ROS has no types
    """Notes each program that roslaunch's process monitor finds dead."""

    def __init__(self, monitor: roslaunch.pmon.ProcessMonitor) -> None:
        self.deaths: List[Death] = []
        self._monitor = monitor

    def process_died(self, process_name: str, exit_code: Optional[int]) -> None:
        """Note a death. The process monitor calls this in its own thread."""
        process = self._monitor.get_process(process_name)
        self.deaths.append(Death(process is not None and process.required, exit_code))


def run(launch: Launch) -> int:
    """Run a launch file until it ends, or SIGINT or SIGTERM comes. Return the exit code: see `launch_rules`.

    Raises:
        UsageError: a parameter at the master would switch motors on.
    """
    run_id = wait_for_master()
    check_server()
    roslaunch.configure_logging(run_id)
    prune(pathlib.Path(rospkg.get_log_dir()), KEPT_RUNS)
    parent = roslaunch.parent.ROSLaunchParent(run_id, [(launch.file, launch.arguments)])
    # The parent takes listeners only after its nodes have started: one that dies at once would go unseen.
    parent.pm = roslaunch.pmon.start_process_monitor()
    undertaker = _Undertaker(parent.pm)
    parent.pm.add_process_listener(undertaker)
    try:
        parent.start()
        parent.spin()
    except RLException as error:
        print("service: %s" % error, file=sys.stderr)
        return CRASHED
    finally:
        parent.shutdown()
    return exit_code_of(undertaker.deaths)


def wait_for_master() -> str:
    """Wait until the ROS master answers, and has its run id. Return that id.

    The master may start just now, or run on a computer that is not on yet. It answers before roscore gives it the id; a
    roslaunch that comes in between would be refused for having another one.
    """
    master, say_again = roslaunch.core.Master(), time.monotonic() + PATIENCE
    while True:
        with contextlib.suppress(OSError, http.client.HTTPException, rosgraph.MasterException):
            if master.is_running():
                return str(rosgraph.Master("/service").getParam("/run_id"))
        if time.monotonic() >= say_again:
            print("service: waiting for the ROS master at %s: does it run, and is it reached from here?" % master.uri,
                  flush=True)
            say_again = time.monotonic() + SAID_EVERY
        time.sleep(0.2)


def check_server() -> None:
    """Raise UsageError if a parameter that somebody has set at the master would switch motors on."""
    server = rosgraph.Master("/service")
    names = [name for name in server.getParamNames() if name.endswith("/" + SWITCH)]
    dangers = refusals([], {name: server.getParam(name) for name in names})
    if dangers:
        raise UsageError("at the master %s, %s (rosparam delete)" % (server.master_uri, "; ".join(dangers)))


def prune(folder: pathlib.Path, kept: int) -> None:
    """Remove the logs of all runs but the newest ``kept`` from a folder of logs, which has a folder for each run."""
    runs = [path for path in folder.iterdir() if path.is_dir() and not path.is_symlink()] if folder.is_dir() else []
    for path in sorted(runs, key=lambda path: path.stat().st_mtime, reverse=True)[kept:]:
        shutil.rmtree(path, ignore_errors=True)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the launch file of the command line. With ``--check``, only check it, and print nodes of other packages.

    Returns the exit code: 0 ended by somebody, 1 a program crashed, 2 a wrong parameter or launch file.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    only_check = words[:1] == ["--check"]
    try:
        launch = checked(words[1:] if only_check else words)
        if not only_check:
            return run(launch)
    except UsageError as error:
        print("service: %s" % error, file=sys.stderr)
        return WRONG
    print(*launch.others, sep="\n", end="\n" if launch.others else "")
    return OK

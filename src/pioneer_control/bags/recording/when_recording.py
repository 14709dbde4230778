"""Start a program only when its recorder has subscribed, so that the bag has all messages of the program.

In a launch file, give the ``<node>`` of the program the attribute
``launch-prefix="rosrun pioneer_control when_recording /pioneer/recorder"``.
"""

import os
import sys
import time
from typing import Sequence

PATIENCE = 15.0  # s: the longest wait; a recorder needs less than 1 s
INTERVAL = 0.05  # s between two requests to the master


def subscribed(recorder: str, state: Sequence) -> bool:
    """Return whether a recorder subscribes to any topic except /clock.

    Args:
        recorder: the full name of the recorder's node.
        state: the value that the ROS master's getSystemState() returned.
    """
    return any(recorder in nodes for topic, nodes in state[1] if topic != "/clock")


def main(arguments: Sequence[str]) -> None:
    """Wait until a recorder has subscribed, then replace this process by a program.

    After `PATIENCE` seconds without a recorder it prints a warning and starts the program too.

    Args:
        arguments: RECORDER PROGRAM [ARGUMENT ...], where RECORDER is the full name of the recorder's node.
    """
    if len(arguments) < 2:
        sys.exit("usage: when_recording RECORDER PROGRAM [ARGUMENT ...]")
    import rosgraph

    recorder, command = arguments[0], arguments[1:]
    master = rosgraph.Master("/when_recording")
    for _ in range(round(PATIENCE / INTERVAL)):
        if subscribed(recorder, master.getSystemState()):
            break
        time.sleep(INTERVAL)
    else:
        print("when_recording: no recorder %s after %.0f s; the run goes unrecorded" % (recorder, PATIENCE),
              file=sys.stderr)
    os.execv(command[0], list(command))

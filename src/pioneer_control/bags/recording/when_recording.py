"""Lets a program begin when its recorder listens, so that a bag holds the run from its first message on.

``launch-prefix="rosrun pioneer_control when_recording /pioneer/recorder"`` on a ``<node>`` does it in a launch file.
"""

import os
import sys
import time
from typing import Sequence

PATIENCE = 15.0  # s; a recorder is there in a fraction of one
INTERVAL = 0.05  # s between two questions


def subscribed(recorder: str, state: Sequence) -> bool:
    """Whether a node subscribes to anything but the clock, by what a ROS master's getSystemState() returns."""
    return any(recorder in nodes for topic, nodes in state[1] if topic != "/clock")


def main(arguments: Sequence[str]) -> None:
    """Become a program once a recorder subscribes. After `PATIENCE` without a recorder, say so and become it too.

    Args:
        arguments: RECORDER PROGRAM [ARGUMENT ...].
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

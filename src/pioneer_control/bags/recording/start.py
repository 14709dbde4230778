"""The command ``record``: it checks its arguments, starts the attendant, and replaces itself by ``rosbag record``.

The process becomes rosbag (exec), so rosbag itself handles Ctrl-C and ``rosnode kill``, and closes the bag. The file
`plan` decides what is recorded in which file.
"""

import os
import shutil
import signal
import sys
import time
from typing import NoReturn

from ...errors import UsageError
from ..command_line import check_alone, parser_of, refuse_launch_arguments
from .plan import OPTIONS, check_place, left_behind, plan_of


def main() -> NoReturn:
    """Check the command line, start the attendant in a second process, and replace this process by rosbag.

    After an error it writes the error to stderr and exits with status 1.
    """
    own = [argument for argument in sys.argv[1:] if ":=" not in argument]
    mapped = [argument for argument in sys.argv[1:] if ":=" in argument]
    try:
        arguments = parser_of(
            "record",
            "Record robots: all topics of config/record.yaml, into one bag. Ctrl-C ends it and closes the bag.",
            OPTIONS).parse_args(own)
        refuse_launch_arguments(mapped, vars(arguments))
        plan = plan_of(arguments, time.localtime())
        if not os.path.isdir(plan.folder):
            raise UsageError("there is no directory %s: make it first (mkdir -p '%s')" % (plan.folder, plan.folder))
        check_place(plan, shutil.disk_usage(plan.folder).free)
        namespace = os.environ.setdefault("ROS_NAMESPACE", "/" + plan.robots[0])
        name = next((argument[len("__name:="):] for argument in mapped if argument.startswith("__name:=")), "recorder")
        # rospy reads sys.argv when it is imported. __name is left out: an attendant with the recorder's name would
        # end the recorder.
        sys.argv = sys.argv[:1] + [argument for argument in mapped if not argument.startswith("__")]
        check_alone("/" + ("%s/%s" % (namespace.strip("/"), name)).strip("/"))
    except UsageError as error:
        sys.exit("record: %s" % error)
    recorder = os.getpid()
    sys.stdout.flush()
    attentive = signal.getsignal(signal.SIGHUP) == signal.SIG_DFL
    if attentive:
        # When the terminal is closed, SIGHUP would kill rosbag before it closes its bag. So rosbag ignores SIGHUP, and
        # the attendant sends it SIGINT instead.
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    if os.fork() == 0:
        if attentive:
            signal.signal(signal.SIGHUP, lambda *_: os.kill(recorder, signal.SIGINT))
        from .attendant import attend

        attend(plan, recorder, name + "_notes", left_behind(plan.folder, time.time()))
        sys.exit(0)
    os.execvp("rosrun", [*plan.command, "__name:=" + name,
                         *(argument for argument in mapped if not argument.startswith("__name:="))])

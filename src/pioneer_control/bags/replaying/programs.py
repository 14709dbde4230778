"""What a re-run and a re-drive need of ROS.

It is their node, programs that they start and end, what the master knows, and the new bag of what they hear and say.
"""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
from typing import Any, Callable, Counter, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import rosgraph
import rospy

from ...errors import NoAnswerError, PioneerError, UsageError
from ...ros_node import NO_ANSWER, init_node, is_at_work, peer
from ..command_line import say
from ..writer import BagWriter, serialized
from .commands import ASIDE, TOLD, absolute

PATIENCE = 30.0
"""s until programs must be there; the slowest machine needs a few."""
MASTER_PATIENCE = 5.0
"""s for an answer of the master, or of a node."""
INTERVAL = 0.05
"""s between two looks."""
LAST_WORDS = 10.0, 5.0
"""s that a program has after Ctrl-C, and then after SIGTERM. Then it is killed."""
DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of prctl(2)"""


class Interrupted(PioneerError):
    """Ctrl-C, or another request to end."""


def no_master() -> UsageError:
    """What to say where no master answers."""
    return UsageError("there is no ROS master at %s: start roscore, or use roslaunch pioneer_control replay.launch"
                      % rosgraph.get_master_uri())


def become_node(name: str) -> None:
    """Become a node of this name, or of that given with ``__name:=``.

    Raises:
        UsageError: there is no master, or a node of that name is at work. This node would end it.
    """
    name = next((word[len("__name:="):] for word in reversed(sys.argv) if word.startswith("__name:=")), name)
    try:
        if is_at_work("/" + name, MASTER_PATIENCE):
            raise UsageError("/%s is at work on this master already: end it first, or give this one another name with "
                             "__name:=" % name)
    except NO_ANSWER:
        raise no_master() from None
    init_node(name)


def run_as_node(name: str, run: Callable[[], int]) -> int:
    """Become a node and run something.

    Where roslaunch started this program, a line says that what roslaunch then writes in red is no error.

    Args:
        name: of the node.
        run: gives the exit code.

    Returns:
        The exit code: that of `run`; 1 it ended before, 2 it cannot be done as asked.
    """
    become_node(name)
    try:
        code = run()
        if any(word.startswith("__log:=") for word in sys.argv):
            say("(roslaunch now says in red that a required process has died: it means that this is done.)\n")
        return code
    except (PioneerError, rospy.ROSException, rospy.ServiceException) as error:
        reason, code = error, 2 if isinstance(error, UsageError) else 1
    except (*NO_ANSWER, rosgraph.MasterException):
        if rosgraph.is_master_online():
            raise
        reason, code = no_master(), 1   # it has ended
    print("%s: %s" % (name, reason), file=sys.stderr, flush=True)
    return code


@contextlib.contextmanager
def running(command: Sequence[str], namespace: str = "/", quiet: bool = False) -> Iterator[subprocess.Popen]:
    """Run a program for as long as the ``with`` block takes. At its end the program is ended, however that came.

    It is ended as by Ctrl-C, and harder if that does not help.

    Args:
        command: the program and its arguments.
        namespace: for its relative names.
        quiet: whether its output is left out.
    """
    libc = ctypes.CDLL(None)  # here: nothing may be loaded in the child
    process = subprocess.Popen(
        list(command), env=dict(os.environ, ROS_NAMESPACE=namespace), stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL if quiet else None,
        start_new_session=True,  # Ctrl-C is for this program, which ends them in their order
        preexec_fn=lambda: libc.prctl(DIE_WITH_PARENT, signal.SIGINT))
    try:
        yield process
    finally:
        for number, patience in zip((signal.SIGINT, signal.SIGTERM), LAST_WORDS):
            if process.poll() is None:
                process.send_signal(number)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(patience)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def wait_until(what: str, condition: Callable[[], Any], needed: Sequence[subprocess.Popen] = (),
               patience: float = PATIENCE, watch: Callable[[], None] = lambda: None,
               is_done: str = "it was done") -> None:
    """Wait until a condition holds.

    Args:
        what: the condition in words.
        condition: is asked again and again.
        needed: programs that must not end meanwhile.
        patience: s.
        watch: called again and again meanwhile; may raise an error.
        is_done: what has not come about when this node ends, in words.

    Raises:
        NoAnswerError: the condition did not come to hold, or a needed program ended.
        Interrupted: this node is to end.
    """
    end = time.monotonic() + patience
    while not condition():
        if rospy.is_shutdown():
            raise Interrupted("ended before " + is_done)
        codes = [process.poll() for process in needed if process.poll() is not None]
        if codes:
            raise NoAnswerError("waited for %s, but a program that is needed for it has ended (exit code %s); its "
                                "last lines above say why" % (what, codes[0]))
        if time.monotonic() > end:
            raise NoAnswerError("waited %.0f s in vain for %s" % (patience, what))
        watch()
        time.sleep(INTERVAL)


def graph() -> Tuple[Dict[str, List[str]], ...]:
    """Publishers and subscribers by topic, and servers by service, as the master knows them now."""
    return tuple(dict(part) for part in rosgraph.Master(rospy.get_name()).getSystemState())


def nodes() -> List[str]:
    """Whole names of all nodes that the master knows."""
    return sorted({node for part in graph() for names in part.values() for node in names})


def possible_robots() -> List[str]:
    """Nodes that report motors or listen to commands, each with such a topic: each may be a robot, or move one.

    Commands that a replay puts aside move no robot.
    """
    publishers, subscribers, _ = graph()
    told = {topic: names for topic, names in subscribers.items()
            if topic.split("/")[-1] in TOLD and absolute(topic).split("/")[-2] not in ASIDE}
    reported = {topic: names for topic, names in publishers.items() if topic.split("/")[-1] == "motor_state"}
    found = {node: topic for topic, names in sorted([*reported.items(), *told.items()]) for node in names}
    return ["%s (%s)" % each for each in sorted(found.items())]


def connected(sender: str, listener: str, topics: Iterable[str]) -> bool:
    """Whether a node is connected to another one.

    Args:
        sender: whole name of the node that publishes.
        listener: whole name of the node that listens.
        topics: whole names. Those that the sender publishes must all be connected.
    """
    published = {topic for topic, names in graph()[0].items() if sender in names}
    node = peer(rosgraph.Master(rospy.get_name()).lookupNode(sender), MASTER_PATIENCE)
    _, _, connections = node.getBusInfo(rospy.get_name())
    return published & set(topics) <= {entry[4] for entry in connections if entry[1] == listener and entry[2] == "o"}


def restore_parameter(name: str, value: Any) -> None:
    """Set a parameter to the value that it had before; None: it was not set."""
    # the master has ended, too, or the parameter is not there to be deleted
    with contextlib.suppress(OSError, KeyError, rosgraph.MasterException):
        if value is not None:
            rospy.set_param(name, value)
        else:
            rospy.delete_param(name)


class TopicRecorder(contextlib.AbstractContextManager):
    """Writes messages of topics, and others that it is given, into a new bag.

    ``with`` closes the bag at the end. It says where the bag is if that was not reached.

    Args:
        path: of the bag.
        now: the time that a message gets.

    Attributes:
        path: of the bag.
        newest: the newest message of each topic.
        counts: how many messages of each topic are written.
        heard_at: when the last message came; s, of the monotonic clock.

    Raises:
        UsageError: there is such a file already, or it cannot be written.
    """

    def __init__(self, path: str, now: Callable[[], rospy.Time]) -> None:
        if os.path.exists(path):
            raise UsageError("%s is there already: name another output" % path)
        try:
            self._writer: Optional[BagWriter] = BagWriter(path)
        except OSError as error:
            raise UsageError("%s cannot be written: %s" % (path, error.strerror or error)) from None
        self._connections: Dict[Tuple[str, Optional[str]], int] = {}     # by topic and publisher
        self.path, self._now = path, now
        self.newest: Dict[str, Any] = {}
        self.counts: Counter[str] = Counter()
        self.heard_at = time.monotonic()
        self._lock = threading.Lock()

    def write(self, message: Any, topic: str) -> None:
        """Write a message with the present time; one that was heard, with what its connection said of it.

        It can be the callback of a subscriber.

        Args:
            message: of any type.
            topic: under which it is written.
        """
        header = getattr(message, "_connection_header", None) or dict(
            type=message._type, md5sum=message._md5sum, message_definition=message._full_text)
        sender = topic, header.get("callerid")
        with self._lock:
            if self._writer is None:
                return
            if sender not in self._connections:
                self._connections[sender] = self._writer.connect(topic, dict(header, topic=topic))
            self._writer.write(self._connections[sender], serialized(message), self._now().to_nsec())
            self.newest[topic] = message
            self.counts[topic] += 1
            self.heard_at = time.monotonic()

    def __exit__(self, kind: Any, *about: Any) -> None:
        """Close the bag, and remove it where nothing is in it. What comes later is dropped."""
        if kind is not None and self.counts:
            say("What happened until it ended is in %s" % self.path)
        with self._lock:
            if self._writer is not None:
                self._writer.close()
            self._writer = None
        if not self.counts:
            os.remove(self.path)

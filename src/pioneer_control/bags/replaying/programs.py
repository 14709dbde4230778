"""What a re-run and a re-drive share: their ROS node, programs that they start, the ROS master, and their new bag."""

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
from ...ros_node import NO_ANSWER, init_node, peer
from ..command_line import MASTER_PATIENCE, check_alone, no_master, say
from ..writer import BagWriter, serialized
from .commands import ASIDE, TOLD, robot_and_name

PATIENCE = 30.0
"""How long to wait for programs to be ready (s). On the slowest machine they need a few seconds."""
INTERVAL = 0.1
"""The usual time between two checks of a condition (s)."""
LAST_WORDS = 10.0, 5.0
"""How long a program has to end after SIGINT, and then after SIGTERM (s). Then it gets SIGKILL."""
DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of prctl(2): the kernel sends a signal to a process when its parent ends."""


class Interrupted(PioneerError):
    """This node must end before it is done: the user pressed Ctrl-C, or ROS shut the node down."""


def become_node(name: str) -> None:
    """Start the ROS node of this process. ``__name:=`` on the command line replaces `name`.

    Raises:
        UsageError: the ROS master does not answer, or a node of this name runs already. The new node would end it.
    """
    name = next((word[len("__name:="):] for word in reversed(sys.argv) if word.startswith("__name:=")), name)
    check_alone("/" + name)
    init_node(name)


def run_as_node(name: str, run: Callable[[], int]) -> int:
    """Start the ROS node of this process, call `run`, and print its error if it raises one.

    If roslaunch started this program, also print that the red message of roslaunch at the end is no error.

    Args:
        name: the name of the node.
        run: the work. It returns an exit code.

    Returns:
        The exit code: the value that `run` returns, 2 if it raises UsageError, and 1 after other errors.

    Raises:
        UsageError: the ROS master does not answer, or a node of this name runs already.
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
        reason, code = no_master(), 1   # the ROS master has ended
    print("%s: %s" % (name, reason), file=sys.stderr, flush=True)
    return code


@contextlib.contextmanager
def running(command: Sequence[str], namespace: str = "/", quiet: bool = False) -> Iterator[subprocess.Popen]:
    """Run a program as long as the ``with`` block lasts. ``with ... as`` gives the process.

    At the end of the block the program gets SIGINT. If it does not end, it gets SIGTERM and then SIGKILL. The program
    also gets SIGINT when this process is killed.

    Args:
        command: the program and its arguments.
        namespace: the ROS namespace of the program.
        quiet: whether the standard output of the program is thrown away.
    """
    libc = ctypes.CDLL(None)  # here, because the child process may not load a library before it runs the program
    process = subprocess.Popen(
        list(command), env=dict(os.environ, ROS_NAMESPACE=namespace), stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL if quiet else None,
        start_new_session=True,  # Ctrl-C reaches only this process, which then ends its programs one by one
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
    """Wait until a condition is true.

    Args:
        what: what we wait for, in words for an error message.
        condition: returns whether the condition is true. It is called again and again.
        needed: processes that must not end while we wait.
        patience: how long to wait (s).
        watch: called again and again while we wait. An exception from it ends the wait.
        is_done: words for the message "ended before ..." of Interrupted.

    Raises:
        NoAnswerError: the condition was not true in time, or one of the needed processes ended.
        Interrupted: this node must end.
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
    """Return three dictionaries of the ROS master: publishers by topic, subscribers by topic, and servers by service.

    Publishers, subscribers and servers are full names of nodes.
    """
    return tuple(dict(part) for part in rosgraph.Master(rospy.get_name()).getSystemState())


def nodes() -> List[str]:
    """Return the full names of all nodes that the ROS master knows."""
    return sorted({node for part in graph() for names in part.values() for node in names})


def possible_robots() -> List[str]:
    """Return the nodes that may be a robot or may move one, each with a topic: "/pioneer/p2os (/pioneer/cmd_vel)".

    Such a node publishes motor_state, or subscribes to commands. Command topics under ``recorded/`` and ``rerun/`` do
    not count, because no robot subscribes to them.
    """
    publishers, subscribers, _ = graph()
    told = {topic: names for topic, names in subscribers.items()
            if robot_and_name(topic)[1] in TOLD and robot_and_name(topic)[0].split("/")[-1] not in ASIDE}
    reported = {topic: names for topic, names in publishers.items() if topic.split("/")[-1] == "motor_state"}
    found = {node: topic for topic, names in [*sorted(told.items()), *sorted(reported.items())] for node in names}
    return ["%s (%s)" % each for each in sorted(found.items())]


def connected(sender: str, listener: str, topics: Iterable[str]) -> bool:
    """Return whether a publishing node has connections to a subscribing node for all of some topics.

    Args:
        sender: the full name of the publishing node.
        listener: the full name of the subscribing node.
        topics: full names of topics. Topics that the sender does not publish are ignored.
    """
    published = {topic for topic, names in graph()[0].items() if sender in names}
    node = peer(rosgraph.Master(rospy.get_name()).lookupNode(sender), MASTER_PATIENCE)
    _, _, connections = node.getBusInfo(rospy.get_name())
    return published & set(topics) <= {entry[4] for entry in connections if entry[1] == listener and entry[2] == "o"}


def restore_parameter(name: str, value: Any) -> None:
    """Set a ROS parameter back to an earlier value. None means that the parameter was not set, so it is deleted."""
    # these errors mean: the ROS master has ended too, or the parameter does not exist
    with contextlib.suppress(OSError, KeyError, rosgraph.MasterException):
        if value is not None:
            rospy.set_param(name, value)
        else:
            rospy.delete_param(name)


class TopicRecorder(contextlib.AbstractContextManager):
    """Writes messages into a new bag. Its method `write` can be the callback of subscribers.

    Use it in a ``with`` block, which closes the bag at its end. When the block ends with an exception and the bag has
    messages, the path of the bag is printed.

    Args:
        path: the path of the new bag.
        now: returns the time to record with a message.

    Attributes:
        path: the path of the bag.
        newest: the newest message by topic.
        counts: the number of written messages by topic.
        heard_at: when the newest message was written (s, ``time.monotonic()``).

    Raises:
        UsageError: the file exists already, or cannot be written.
    """

    def __init__(self, path: str, now: Callable[[], rospy.Time]) -> None:
        if os.path.exists(path):
            raise UsageError("%s is there already: name another output" % path)
        try:
            self._writer: Optional[BagWriter] = BagWriter(path)
        except OSError as error:
            raise UsageError("%s cannot be written: %s" % (path, error.strerror or error)) from None
        self._connections: Dict[Tuple[str, Optional[str]], int] = {}     # connection number by topic and publisher
        self.path, self._now = path, now
        self.newest: Dict[str, Any] = {}
        self.counts: Counter[str] = Counter()
        self.heard_at = time.monotonic()
        self._lock = threading.Lock()

    def write(self, message: Any, topic: str) -> None:
        """Write a message into the bag with the present time. Any thread may call this.

        A received message keeps the header of its connection, with the name of its publisher. After the bag is closed,
        messages are ignored.

        Args:
            message: a message of any type.
            topic: the topic in the bag.
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
        """Close the bag, and delete it if it has no messages. Messages that come later are ignored."""
        if kind is not None and self.counts:
            say("What happened until it ended is in %s" % self.path)
        with self._lock:
            if self._writer is not None:
                self._writer.close()
            self._writer = None
        if not self.counts:
            os.remove(self.path)

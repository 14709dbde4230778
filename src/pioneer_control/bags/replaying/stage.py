"""What a re-run and a re-drive both stand on: their node, the bag they keep, the programs they start and end, and who is there already."""

import ctypes
import io
import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple
from xmlrpc.client import ServerProxy

import genpy
import rosgraph
import rospy

from ...errors import NoAnswerError, PioneerError, UsageError
from ...ros_node import NO_ANSWER, init_node, is_at_work
from ..names import stem
from ..writer import BagWriter
from .redrive_schedule import OTHERS, VELOCITIES
from .replay import ASIDE

PATIENCE = 30.0  # s: for programs to be there; the slowest machine needs few of them
MASTER_PATIENCE = 5.0  # s for an answer of the master
INTERVAL = 0.05  # s between two looks
LAST_WORDS = 10.0, 5.0  # s after Ctrl-C, and after SIGTERM, until a program is killed
DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


def begin(name: str) -> None:
    """Become a node. Raises UsageError where there is no master, or one of that name is at work: it would end that."""
    named = [word[len("__name:="):] for word in sys.argv if word.startswith("__name:=")]
    name = (named or [name])[-1]
    try:
        if is_at_work("/" + name, MASTER_PATIENCE):
            raise UsageError("/%s is at work on this master already: end it first, or give this one another name with __name:=" % name)
    except NO_ANSWER:
        raise no_master() from None
    init_node(name)


def no_master() -> UsageError:
    """What to say where none answers."""
    return UsageError("there is no ROS master at %s: start roscore, or use roslaunch pioneer_control replay.launch" % rosgraph.get_master_uri())


def carry_out(name: str, run: Callable[[], int]) -> int:
    """Become a node and run. Returns the exit code of that; 1 it ended before, 2 it cannot be done as asked."""
    begin(name)
    try:
        return run()
    except (PioneerError, rospy.ROSException, rospy.ServiceException) as error:
        reason, code = error, 2 if isinstance(error, UsageError) else 1
    except (*NO_ANSWER, rosgraph.MasterException):
        if rosgraph.is_master_online():
            raise
        reason, code = no_master(), 1   # it has ended
    print("%s: %s" % (name, reason), file=sys.stderr, flush=True)
    return code


class Keeper:
    """Writes into a new bag what it hears, and what it is given."""

    def __init__(self, path: str, now: Callable[[], genpy.Time]) -> None:
        """``now``: when what is heard was heard. Raises UsageError when there can be no such bag."""
        if os.path.exists(path):
            raise UsageError("%s is there already: name another output" % path)
        try:
            self._writer: Optional[BagWriter] = BagWriter(path)
        except OSError as error:
            raise UsageError("%s cannot be written: %s" % (path, error.strerror or error)) from None
        self._connections: Dict[Tuple[str, Optional[str]], int] = {}     # by topic and publisher
        self.path = path
        self.newest: Dict[str, Any] = {}
        self.counts: Dict[str, int] = {}
        self.heard_at = time.monotonic()
        self._now = now
        self._lock = threading.Lock()
        self._subscribers: List[rospy.Subscriber] = []

    def hear(self, topic: str, kind: type = rospy.AnyMsg, kept_as: Optional[str] = None) -> rospy.Subscriber:
        """Keep every message of a topic from now on, under another name if wanted."""
        subscriber = rospy.Subscriber(topic, kind, self._take, kept_as or topic)
        self._subscribers.append(subscriber)
        return subscriber

    def _take(self, message: Any, topic: str) -> None:
        self._keep(topic, message, message._connection_header)

    def write(self, topic: str, message: genpy.Message) -> None:
        """Keep a message, as of now."""
        self._keep(topic, message, dict(type=message._type, md5sum=message._md5sum, message_definition=message._full_text))

    def _keep(self, topic: str, message: Any, header: Mapping[str, str]) -> None:
        """``header``: the connection's by which it came."""
        data = io.BytesIO()
        message.serialize(data)
        sender = topic, header.get("callerid")
        with self._lock:
            if self._writer is None:
                return
            if sender not in self._connections:
                self._connections[sender] = self._writer.connect(topic, dict(header, topic=topic))
            self._writer.write(self._connections[sender], data.getvalue(), self._now().to_nsec())
            self.newest[topic] = message
            self.counts[topic] = self.counts.get(topic, 0) + 1
            self.heard_at = time.monotonic()

    def close(self) -> None:
        """Close the bag; what comes now is dropped. A bag in which there is nothing is no bag. May be called twice."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers = []
        with self._lock:
            writer, self._writer = self._writer, None
            if writer is not None:
                writer.close()
                if not self.counts:
                    os.remove(self.path)


def say_what_is_kept(keeper: Keeper) -> None:
    """Of something that ended before it was done."""
    if keeper.counts:
        say("What happened until it ended is in %s" % keeper.path)


class Programs:
    """Programs that are started for a while. They end in order, however this one does."""

    def __init__(self) -> None:
        self._running: List[subprocess.Popen] = []

    def start(self, command: Sequence[str], namespace: str = "/", quiet: bool = False) -> subprocess.Popen:
        """Start one, with relative names below a namespace."""
        libc = ctypes.CDLL(None)  # here: nothing may be loaded in the child
        process = subprocess.Popen(
            list(command), env=dict(os.environ, ROS_NAMESPACE=namespace), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL if quiet else None,
            start_new_session=True,  # Ctrl-C is for us: they end when it is their turn
            preexec_fn=lambda: libc.prctl(DIE_WITH_PARENT, signal.SIGINT))
        self._running.append(process)
        return process

    def end(self, process: subprocess.Popen) -> int:
        """Ctrl-C for one, and wait for it; harder means for one that does not end. Its exit code."""
        for number, patience in zip((signal.SIGINT, signal.SIGTERM), LAST_WORDS):
            if process.poll() is None:
                process.send_signal(number)
                try:
                    process.wait(patience)
                except subprocess.TimeoutExpired:
                    pass
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        return process.wait()

    def end_all(self) -> None:
        """The last one first."""
        while self._running:
            self.end(self._running.pop())


class Interrupted(PioneerError):
    """Ctrl-C, or another end that was asked for."""


def wait_until(what: str, condition: Callable[[], Any], needed: Sequence[subprocess.Popen] = (), patience: float = PATIENCE) -> None:
    """Until a condition holds. Raises NoAnswerError in time, or when a program ends that is needed for it, and Interrupted."""
    end = time.monotonic() + patience
    while not condition():
        if rospy.is_shutdown():
            raise Interrupted("ended before it was done")
        for process in needed:
            if process.poll() is not None:
                raise NoAnswerError("waited for %s, but a program that is needed for it has ended (exit code %s); why, it says above" % (what, process.poll()))
        if time.monotonic() > end:
            raise NoAnswerError("waited %.0f s in vain for %s" % (patience, what))
        time.sleep(INTERVAL)


def graph() -> SimpleNamespace:
    """Who publishes and who hears what: {topic: [nodes]} each; as the master knows it now."""
    publishers, subscribers, services = rosgraph.Master(rospy.get_name()).getSystemState()
    return SimpleNamespace(publishers=dict(publishers), subscribers=dict(subscribers), services=dict(services))


def nodes() -> List[str]:
    """All nodes there are."""
    now = graph()
    return sorted({node for part in (now.publishers, now.subscribers, now.services) for names in part.values() for node in names})


def alive() -> List[str]:
    """Who could be a robot, or move one: nodes that listen to commands, or report motors; each with a topic that tells."""
    now = graph()
    found = [(node, topic) for topic, names in now.publishers.items() if topic.rpartition("/")[2] == "motor_state" for node in names]
    found += [(node, topic) for topic, names in now.subscribers.items() if _commands(topic) for node in names]
    return ["%s (%s)" % (node, topic) for node, topic in sorted(dict(sorted(found)).items())]


def _commands(topic: str) -> bool:
    """Whether who listens to a topic may be moved by it: what is played back or run again lies aside."""
    *_, folder, name = ["", *topic.split("/")]
    return name in VELOCITIES + OTHERS and folder not in ASIDE


def connected(sender: str, listener: str, topics: Iterable[str]) -> bool:
    """Whether a node has a connection to another on each of some topics, as far as it publishes them."""
    published = {topic for topic, names in graph().publishers.items() if sender in names}
    address = rosgraph.Master(rospy.get_name()).lookupNode(sender)
    _, _, connections = ServerProxy(address).getBusInfo(rospy.get_name())
    return published & set(topics) <= {entry[4] for entry in connections if entry[1] == listener and entry[2] == "o"}


def put_back(name: str, value: Any) -> None:
    """A parameter as it was; None: there was none."""
    try:
        if value is not None:
            rospy.set_param(name, value)
        elif rospy.has_param(name):
            rospy.delete_param(name)
    except (OSError, KeyError, rosgraph.MasterException):
        pass  # the master has ended, too


def free_name(bag: str, what: str) -> str:
    """A file that is not there yet, beside a bag: RUN-redrive.bag, or RUN-redrive-2.bag, ..."""
    beside = "%s-%s" % (stem(bag), what)
    number, path = 1, beside + ".bag"
    while os.path.exists(path):
        number, path = number + 1, "%s-%s.bag" % (beside, number + 1)
    return path


def say(sentence: str) -> None:
    """For whoever looks on: at once, and between the lines that others print."""
    print(sentence, flush=True)


def explain_roslaunch() -> None:
    """What it prints at the end of a required node looks worse than it is."""
    if any(word.startswith("__log:=") for word in sys.argv):
        say("(roslaunch now says in red that a required process has died: it means that this is done.)\n")

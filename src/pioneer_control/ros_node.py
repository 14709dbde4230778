"""How each of our nodes begins, ends at a signal, and asks the ROS master.

A master may hang: then it takes connections, but never answers.
"""

import atexit
import contextlib
import http.client
import io
import logging
import logging.handlers
import os
import queue
import re
import signal
import sys
import threading
import types
import xmlrpc.client
from typing import Any, Dict, Iterator, List, Optional

import rosgraph
import rospy
from rospy.impl.rosout import RosOutHandler
from rospy.impl.tcpros_base import init_tcpros_server

MASTER_PATIENCE = 0.5
"""Seconds, after the program's own shutdown hooks, that the end of a node waits for the master to take notice."""
MAIN_PATIENCE = 0.4
"""Seconds after that in which the main thread must come to its end, when the master did not answer."""
WAITING_CONNECTIONS = 128
"""Connections to a node that may wait to be taken."""


def init_node(name: str) -> None:
    """As rospy.init_node, but a signal (Ctrl-C, SIGTERM, a closed terminal) ends the node in a thread of its own.

    rospy's own handlers run the shutdown in the main thread, on top of what it was just doing. Then they wait for ever
    for locks that it holds: even `rospy.loginfo` takes one while it talks with the master (seen with 1.15.15).
    ``nohup`` is respected.

    A signal that comes while this function runs ends the program here, with code 0. A master that hangs holds up
    neither the end of a node nor a thread that logs something.
    """
    _send_each_line(sys.stdout, sys.stderr)
    # Each entry asks to end, and says why. It takes no lock, so that a signal handler may use it.
    asked: "queue.SimpleQueue[str]" = queue.SimpleQueue()
    hooks_ran, over, ended = threading.Event(), threading.Event(), threading.Event()
    signals: List[int] = []
    log = logging.handlers.QueueListener(queue.SimpleQueue())
    log.start()

    def follow_hooks(reason: str) -> None:
        hooks_ran.set()
        log.stop()          # when all is published

    def end() -> None:
        shutdown = threading.Thread(target=rospy.signal_shutdown, args=(asked.get(),), daemon=True)
        shutdown.start()
        hooks_ran.wait()
        shutdown.join(MASTER_PATIENCE)
        ended.set()
        if not rospy.is_shutdown() and not over.wait(MAIN_PATIENCE):
            sys.stdout.flush()
            os._exit(0)     # the main thread, too, waits for the master, and nothing wakes it

    def on_signal(number: int, frame: Any) -> None:
        signals.append(number)
        asked.put("signal %d" % number)

    def at_exit() -> None:
        over.set()
        asked.put("the program has ended")
        ended.wait()

    rospy.core.add_preshutdown_hook(follow_hooks)   # before those of rospy that tell the master
    threading.Thread(target=end, name="signals", daemon=True).start()
    atexit.register(at_exit)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, on_signal)
    try:
        rospy.init_node(name, disable_signals=True)
    except Exception:
        if not signals and not rospy.core.is_shutdown_requested():
            raise
    if signals or rospy.core.is_shutdown_requested():
        sys.exit(0)
    _raise_listen_backlog()
    _publish_log_in_thread_of(log)


def _send_each_line(*streams: Any) -> None:
    """Let a file or a pipe have each line at once, not at the end of the program. Other streams stay as they are."""
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(line_buffering=True)


def _raise_listen_backlog() -> None:
    """Let many connections wait until rospy takes them. It allows five, and a recorder opens thirty at once.

    The others would try again only a second later.
    """
    server = init_tcpros_server()
    server.start_server()       # unless it runs already
    with contextlib.suppress(OSError):      # the node has ended meanwhile
        server.tcp_ros_server.server_sock.listen(WAITING_CONNECTIONS)


def _publish_log_in_thread_of(listener: logging.handlers.QueueListener) -> None:
    """Let the listener's thread publish what is logged on /rosout: rospy asks the master with each line.

    That thread does not take the lock of rospy's handler, because the end of the program waits for it.
    """
    logger = logging.getLogger("rosout")
    handlers = [handler for handler in logger.handlers if isinstance(handler, RosOutHandler)]
    # The listener calls handle() and nothing else.
    listener.handlers = tuple(types.SimpleNamespace(handle=handler.emit)    # type: ignore[misc]
                              for handler in handlers)
    for handler in handlers:
        logger.removeHandler(handler)
        logger.addHandler(logging.handlers.QueueHandler(listener.queue))


def wait_for_clock() -> None:
    """Return once ROS time goes on. Raises ROSInterruptException when ROS shuts down.

    Simulated time may not have begun, or may be paused. Then the log says what this node waits for.
    """
    if not rospy.rostime.is_wallclock():
        rospy.loginfo("waiting for the time on /clock to go on (use_sim_time is set)")
        sleep(1e-9)


def sleep(duration: float) -> None:
    """As rospy.sleep (s), but it begins again when time jumps back, where rospy's raises an exception.

    Raises ROSInterruptException when ROS shuts down.
    """
    while True:
        with contextlib.suppress(rospy.ROSTimeMovedBackwardsException):
            return rospy.sleep(duration)


def ticks(rate: float, duration: float) -> Iterator[None]:
    """Yields `rate` times a second for `duration` seconds of ROS time, or until ROS shuts down.

    It yields nothing while time is paused, and not more often when time jumps back: a robot that is driven at each tick
    drives no farther then.
    """
    pace = rospy.Rate(rate, reset=True)
    for _ in range(round(rate * duration)):
        if rospy.is_shutdown():
            return
        yield
        pace.sleep()


NO_ANSWER = OSError, http.client.HTTPException, xmlrpc.client.Error
"""Errors of a question to a master or a node that is not there, or hangs."""


class ImpatientTransport(xmlrpc.client.Transport):
    """An XML-RPC transport that waits ``timeout`` s for each piece of an answer, and then raises OSError."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """A connection with this time-out."""
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


def peer(address: str, timeout: float) -> Any:
    """The master or node at an XML-RPC address. To be asked in a ``with`` block; each answer may take ``timeout`` s.

    A question raises one of NO_ANSWER when there is no answer. With rospy it would wait for ever.
    """
    return xmlrpc.client.ServerProxy(address, transport=ImpatientTransport(timeout))


def is_offered(service: str, timeout: float) -> Optional[bool]:
    """Whether some node offers a service (its full name); None when the master does not say within ``timeout`` s."""
    with contextlib.suppress(*NO_ANSWER), peer(rosgraph.get_master_uri(), timeout) as master:
        return bool(master.lookupService(rospy.get_caller_id(), service)[0] == 1)
    return None


def listeners(timeout: float) -> Dict[str, List[str]]:
    """By topic, the nodes that listen to it; empty when the master does not say within ``timeout`` s."""
    with contextlib.suppress(*NO_ANSWER), peer(rosgraph.get_master_uri(), timeout) as master:
        _, _, (_, subscribers, _) = master.getSystemState(rospy.get_caller_id())
        return dict(subscribers)
    return {}


def name_for(program: str, robot: str) -> str:
    """A name for a node of one robot: programs of several robots run on one master, and two of one robot do not.

    ROS ends a node when another takes its name. So the program that is started last has the robot.
    """
    robot = re.sub(r"\W", "_", robot.strip("/"))
    return program if robot == "pioneer" else "%s_%s" % (program, robot)


def is_at_work(node: str, timeout: float) -> bool:
    """Whether a node (its full name) is there and answers; each question may take ``timeout`` s.

    Raises one of NO_ANSWER when the master does not answer.
    """
    with peer(rosgraph.get_master_uri(), timeout) as master:
        code, _, address = master.lookupNode(rospy.get_caller_id(), node)
    if code == 1:
        with contextlib.suppress(*NO_ANSWER), peer(address, timeout) as known:      # no answer: it was killed
            return bool(known.getPid(rospy.get_caller_id())[0] == 1)
    return False

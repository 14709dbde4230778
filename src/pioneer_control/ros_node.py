"""How every node of ours begins, ends at a signal, and asks a master that may hang: it takes connections, but never answers."""

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
    """rospy.init_node, and a signal (Ctrl-C, SIGTERM, a closed terminal) ends the node as ``rosnode kill`` does: beside the main thread.

    rospy's own handlers run the shutdown on top of whatever the main thread was just doing, and then wait for ever for locks that
    it holds: those of its talk with the master, which even `rospy.loginfo` takes (seen with 1.15.15). ``nohup`` is respected.

    A signal that comes while this function runs ends the program here, with code 0. A master that hangs keeps no node from its end, nor who logs
    something.
    """
    _send_each_line(sys.stdout, sys.stderr)
    asked: "queue.SimpleQueue[str]" = queue.SimpleQueue()   # to end, and why; takes no lock: it may be used in a signal handler
    hooks_ran, over, ended = threading.Event(), threading.Event(), threading.Event()
    signals = []
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

    def hear(number: int, frame: Any) -> None:
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
            signal.signal(number, hear)
    try:
        rospy.init_node(name, disable_signals=True)
    except Exception:
        if not signals and not rospy.core.is_shutdown_requested():
            raise
    if signals or rospy.core.is_shutdown_requested():
        sys.exit(0)
    _let_many_connect()
    _publish_log_by(log)


def _send_each_line(*streams: Any) -> None:
    """A file or a pipe has each line when it is said, not when the program ends. What stands in their place (None, a test's) stays as it is."""
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(line_buffering=True)


def _let_many_connect() -> None:
    """A recorder comes for thirty topics at once. rospy lets five connections wait to be taken: the others would try again only a second later."""
    server = init_tcpros_server()
    server.start_server()       # where none runs yet
    with contextlib.suppress(OSError):      # the end came first
        server.tcp_ros_server.server_sock.listen(WAITING_CONNECTIONS)


def _publish_log_by(listener: logging.handlers.QueueListener) -> None:
    """rospy asks the master with every line that is logged, and publishes it on /rosout: let that be the work of the listener's thread.

    It does so without the lock of rospy's handler: the end of the program waits for that.
    """
    logger = logging.getLogger("rosout")
    handlers = [handler for handler in logger.handlers if isinstance(handler, RosOutHandler)]
    listener.handlers = [types.SimpleNamespace(handle=handler.emit) for handler in handlers]
    for handler in handlers:
        logger.removeHandler(handler)
        logger.addHandler(logging.handlers.QueueHandler(listener.queue))


def wait_for_clock() -> None:
    """Return once ROS time goes on. Raises ROSInterruptException when ROS shuts down.

    Where it is simulated this says what is waited for: nobody may tell it yet, or it may be paused.
    """
    if not rospy.rostime.is_wallclock():
        rospy.loginfo("waiting for the time on /clock to go on (use_sim_time is set)")
        sleep(1e-9)


def sleep(duration: float) -> None:
    """rospy.sleep (s), which is begun again when time jumps back; rospy's raises then. Raises ROSInterruptException when ROS shuts down."""
    while True:
        try:
            return rospy.sleep(duration)
        except rospy.ROSTimeMovedBackwardsException:
            pass


def ticks(rate: float, duration: float) -> Iterator[None]:
    """Yields `rate` times a second for `duration` seconds of ROS time, or until ROS shuts down.

    Not while time is paused, and no oftener when it jumps back: who drives by it drives no farther.
    """
    pace = rospy.Rate(rate, reset=True)
    for _ in range(round(rate * duration)):
        if rospy.is_shutdown():
            return
        yield
        pace.sleep()


NO_ANSWER = OSError, http.client.HTTPException, xmlrpc.client.Error
"""What it raises to ask a master or a node that is not there, or hangs."""


class Impatient(xmlrpc.client.Transport):
    """Waits so many seconds for each piece of an answer; then it raises OSError."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


def is_offered(service: str, timeout: float) -> Optional[bool]:
    """Whether some node offers a service (its full name); None when the master does not say within ``timeout`` s. rospy would wait for ever."""
    try:
        with xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=Impatient(timeout)) as master:
            code, _, _ = master.lookupService(rospy.get_caller_id(), service)
    except NO_ANSWER:
        return None
    return code == 1


def listeners(timeout: float) -> Dict[str, List[str]]:
    """The nodes that listen to each topic, as the master knows; none when it does not say within ``timeout`` s."""
    try:
        with xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=Impatient(timeout)) as master:
            _, _, (_, subscribers, _) = master.getSystemState(rospy.get_caller_id())
    except NO_ANSWER:
        return {}
    return dict(subscribers)


def name_for(program: str, robot: str) -> str:
    """A name for a node of one robot: programs of several robots run on one master, and two of one robot do not.

    ROS ends a node when another takes its name. So the program that is started last has the robot.
    """
    robot = re.sub(r"\W", "_", robot.strip("/"))
    return program if robot == "pioneer" else "%s_%s" % (program, robot)


def is_at_work(node: str, timeout: float) -> bool:
    """Whether a node (its full name) is there and answers; each question may take ``timeout`` s. Raises one of NO_ANSWER when the master does not."""
    with xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), transport=Impatient(timeout)) as master:
        code, _, address = master.lookupNode(rospy.get_caller_id(), node)
    if code != 1:
        return False
    try:
        with xmlrpc.client.ServerProxy(address, transport=Impatient(timeout)) as known:
            return known.getPid(rospy.get_caller_id())[0] == 1
    except NO_ANSWER:
        return False    # it was killed

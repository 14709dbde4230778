"""How each node of this package starts, ends at a signal, and sends requests to the ROS master.

A master may hang: it accepts connections, but never answers. The functions here do not wait for ever in this case.
"""

import atexit
import contextlib
import errno
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
import time
import traceback
import types
import xmlrpc.client
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Tuple

import rosgraph
import rospy
from rospy.impl.rosout import RosOutHandler
from rospy.impl.tcpros_base import TCPServer, init_tcpros_server

from . import interrupt  # noqa: F401  # Ctrl-C ends a program without a traceback
from .errors import ParameterError, PioneerError

MASTER_PATIENCE = 0.5
"""Seconds that a node waits for the master when it ends. The time begins after the program's own shutdown hooks."""
MAIN_PATIENCE = 0.4
"""Seconds that the main thread has to end after MASTER_PATIENCE, when the master does not answer."""
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
"""The signals that end a node."""
START_GRACE = 3.0
"""The time (s) after the start of a device's node in which a missing port is not logged as an error. A simulated device
may start at the same time, and its port may appear a little later.
"""
WAITING_CONNECTIONS = 128
"""The length of the listen queue: how many connections to a node may wait until rospy accepts them."""


def init_node(name: str) -> None:
    """Do what rospy.init_node does, but shut down in a separate thread after a signal.

    The signals are SIGINT (Ctrl-C), SIGTERM and SIGHUP (a closed terminal; ignored under ``nohup``).

    The signal handler of rospy runs the shutdown in the main thread, in the middle of other work of this thread. There
    it can wait for ever for a lock that the main thread itself holds. Even `rospy.loginfo` holds a lock while it sends
    a request to the master (seen with rospy 1.15.15).

    The main thread also cannot take the signal itself. Python runs a handler there, but not while the thread waits for
    a lock. So a signal that comes in the moment before this wait would be lost. But Python writes the number of a
    signal to a pipe at once, in whatever thread it comes. A separate thread reads it there.

    A signal that comes while this function runs ends the program with exit code 0. A master that does not answer
    delays neither the end of the node nor a thread that logs something.
    """
    _send_each_line(sys.stdout, sys.stderr)
    _forgive_a_server_that_begins_late()
    handled = [number for number in SIGNALS if number != signal.SIGHUP or signal.getsignal(number) == signal.SIG_DFL]
    # Each byte is the number of a signal, or 0 when the program has ended.
    asked, ask = os.pipe()
    os.set_blocking(ask, False)
    hooks_ran, started, unregistered, over, ended = (threading.Event() for _ in range(5))
    signals: List[int] = []
    log = logging.handlers.QueueListener(queue.SimpleQueue())
    log.start()

    def follow_hooks(reason: str) -> None:
        hooks_ran.set()
        log.stop()          # when all is published

    def end() -> None:
        number = os.read(asked, 1)[0]
        while number not in (0, *handled):      # the program has a handler of its own for this one
            number = os.read(asked, 1)[0]
        reason = "signal %d" % number if number else "the program has ended"
        shutdown = threading.Thread(target=rospy.signal_shutdown, args=(reason,), daemon=True)
        shutdown.start()
        hooks_ran.wait()
        deadline = time.monotonic() + MASTER_PATIENCE
        shutdown.join(MASTER_PATIENCE)
        if started.is_set():    # another thread may be shutting down (rosnode kill): rospy does not wait for it
            unregistered.wait(max(0.0, deadline - time.monotonic()))
        ended.set()
        if not rospy.is_shutdown() and not over.wait(MAIN_PATIENCE):
            sys.stdout.flush()
            os._exit(0)     # the main thread waits for the master too, and nothing can wake it

    def on_signal(number: int, frame: Any) -> None:
        signals.append(number)

    def at_exit() -> None:
        over.set()
        os.write(ask, b"\0")
        ended.wait()

    rospy.core.add_preshutdown_hook(follow_hooks)   # runs before rospy's own hooks, which send requests to the master
    threading.Thread(target=end, name="signals", daemon=True).start()
    atexit.register(at_exit)
    signal.set_wakeup_fd(ask, warn_on_full_buffer=False)
    for number in handled:
        signal.signal(number, on_signal)
    try:
        rospy.init_node(name, disable_signals=True)
    except Exception:
        if not signals and not rospy.core.is_shutdown_requested():
            raise
    if signals or rospy.core.is_shutdown_requested():
        sys.exit(0)
    rospy.core.add_shutdown_hook(lambda reason: unregistered.set())     # runs after rospy's own hooks
    started.set()
    _raise_listen_backlog()
    _publish_log_in_thread_of(log)


def _send_each_line(*streams: Any) -> None:
    """Make text streams write each line at once, also to a file or a pipe. Other streams stay as they are."""
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(line_buffering=True)


def _forgive_a_server_that_begins_late() -> None:
    """Report no error when rospy's server finds its socket closed while the node ends.

    Its thread may begin only after the shutdown that a signal started. Then it takes back the mark that tells it that
    the socket is closed on purpose (seen with rospy 1.15.15).
    """
    report = threading.excepthook

    def report_others(failure: Any) -> None:
        closed = isinstance(failure.exc_value, OSError) and failure.exc_value.errno == errno.EBADF
        of_server = any(frame.f_code is TCPServer.run.__code__ for frame, _ in traceback.walk_tb(failure.exc_traceback))
        if not (closed and of_server and rospy.core.is_shutdown_requested()):
            report(failure)

    threading.excepthook = report_others


def _raise_listen_backlog() -> None:
    """Let WAITING_CONNECTIONS connections wait until rospy accepts them.

    rospy lets five wait, but a recorder opens thirty at once. The rest of them would try again only a second later.
    """
    server = init_tcpros_server()
    server.start_server()       # unless it runs already
    with contextlib.suppress(OSError):      # the node has ended meanwhile
        server.tcp_ros_server.server_sock.listen(WAITING_CONNECTIONS)


def _publish_log_in_thread_of(listener: logging.handlers.QueueListener) -> None:
    """Publish log messages to /rosout in the thread of ``listener``, not in the thread that logs.

    rospy sends a request to the master for each log message, so a master that hangs would block the thread that logs.
    The thread of the listener does not take the lock of rospy's log handler, because the end of the program waits for
    that lock.
    """
    logger = logging.getLogger("rosout")
    handlers = [handler for handler in logger.handlers if isinstance(handler, RosOutHandler)]
    # The listener calls handle() and nothing else.
    emitters: Any = tuple(types.SimpleNamespace(handle=handler.emit) for handler in handlers)
    listener.handlers = emitters
    for handler in handlers:
        logger.removeHandler(handler)
        logger.addHandler(logging.handlers.QueueHandler(listener.queue))


def run_device(check: Callable[[Mapping[str, Any]], Tuple[Any, List[str]]], make: Callable[[Any], Any]) -> int:
    """Run the node of a device, after `init_node`.

    Args:
        check: function that checks the private parameters, and returns them with warnings.
        make: function that makes the node of these parameters: an object with a method `run`.

    Returns:
        The exit code: what `run` returns, or 2 after a PioneerError of `check` or `make`, such as a wrong parameter.
    """
    try:
        parameters, warnings = check(rospy.get_param("~", {}))
        for warning in warnings:
            rospy.logwarn("%s", warning)
        node = make(parameters)
    except PioneerError as error:
        advice = " (The master keeps old parameters until you type: rosparam delete %s)" % rospy.get_name()
        rospy.logfatal("%s%s", error, advice if isinstance(error, ParameterError) else "")
        return 2
    return int(node.run())


def wait_for_clock() -> None:
    """Wait until ROS time runs. Raises ROSInterruptException when ROS shuts down.

    Real time always runs. Simulated time (/clock) may not have started, or may be paused; then the node logs that it
    waits.
    """
    if not rospy.rostime.is_wallclock():
        rospy.loginfo("waiting for the time on /clock to go on (use_sim_time is set)")
        sleep(1e-9)


def sleep(duration: float) -> None:
    """Sleep for ``duration`` seconds of ROS time. When time jumps back, the sleep starts again.

    (`rospy.sleep` raises an exception when time jumps back.) Raises ROSInterruptException when ROS shuts down.
    """
    while True:
        with contextlib.suppress(rospy.ROSTimeMovedBackwardsException):
            return rospy.sleep(duration)


def ticks(rate: float, duration: float) -> Iterator[None]:
    """Yield `rate` times a second for `duration` seconds of ROS time, or until ROS shuts down.

    There are never more than `rate` * `duration` ticks: none while time is paused, and no extra ticks when time jumps
    back. So a robot that gets a command at each tick does not drive farther than planned.
    """
    pace = rospy.Rate(rate, reset=True)
    for _ in range(round(rate * duration)):
        if rospy.is_shutdown():
            return
        yield
        pace.sleep()


NO_ANSWER = OSError, http.client.HTTPException, xmlrpc.client.Error
"""The exceptions that an XML-RPC request raises when the ROS master or node does not run, or hangs."""


class ImpatientTransport(xmlrpc.client.Transport):
    """An XML-RPC transport with a time-out: it raises OSError when no data arrive for ``timeout`` seconds."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return a connection to ``host`` that has the time-out of this transport."""
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


def peer(address: str, timeout: float) -> Any:
    """Return an XML-RPC proxy for the ROS master or node at ``address`` (a URI). Use it in a ``with`` block.

    A request raises one of NO_ANSWER when no answer comes within ``timeout`` seconds. rospy's proxies wait for ever.
    """
    return xmlrpc.client.ServerProxy(address, transport=ImpatientTransport(timeout))


def is_offered(service: str, timeout: float) -> Optional[bool]:
    """Return whether a node offers ``service`` (a full name). None when the master does not answer in ``timeout`` s."""
    with contextlib.suppress(*NO_ANSWER), peer(rosgraph.get_master_uri(), timeout) as master:
        return bool(master.lookupService(rospy.get_caller_id(), service)[0] == 1)
    return None


def sender_of(message: Any) -> str:
    """Return the name of the node that sent a message. Empty if rospy did not receive it from one."""
    return str((getattr(message, "_connection_header", None) or {}).get("callerid", ""))


def is_player(node: str) -> bool:
    """Return whether a node has the default name of `rosbag play`: play_<time>, in any namespace."""
    return node.rpartition("/")[2].startswith("play_")


def bag_player(message: Any, timeout: float = 0.3) -> Optional[bool]:
    """Return whether a bag player (`rosbag play`) sent a message: by its name, or because it offers pause_playback.

    None when the master does not answer in ``timeout`` seconds.
    """
    node = sender_of(message)
    return is_player(node) or is_offered(node + "/pause_playback", timeout)


def listeners(timeout: float) -> Dict[str, List[str]]:
    """Return for each topic the names of its subscriber nodes. Empty if the master does not answer in ``timeout`` s."""
    with contextlib.suppress(*NO_ANSWER), peer(rosgraph.get_master_uri(), timeout) as master:
        _, _, (_, subscribers, _) = master.getSystemState(rospy.get_caller_id())
        return dict(subscribers)
    return {}


def name_for(program: str, robot: str) -> str:
    """Return the node name for ``program`` when it controls ``robot`` (the namespace of the robot).

    Each robot gets its own node name, so programs for several robots can run with one master. But when the same program
    is started twice for one robot, ROS ends the first one, because a new node took its name.
    """
    robot = re.sub(r"\W", "_", robot.strip("/"))
    return program if robot == "pioneer" else "%s_%s" % (program, robot)


def is_at_work(node: str, timeout: float) -> bool:
    """Return whether ``node`` (a full name) runs and answers within ``timeout`` seconds.

    Raises one of NO_ANSWER when the master does not answer within ``timeout`` seconds.
    """
    with peer(rosgraph.get_master_uri(), timeout) as master:
        code, _, address = master.lookupNode(rospy.get_caller_id(), node)
    if code == 1:
        with contextlib.suppress(*NO_ANSWER), peer(address, timeout) as known:      # no answer: the node was killed
            return bool(known.getPid(rospy.get_caller_id())[0] == 1)
    return False

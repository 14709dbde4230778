"""How every node of ours begins, and ends at a signal."""

import queue
import signal
import threading

import rospy


def init_node(name: str) -> None:
    """rospy.init_node, and a signal (Ctrl-C, SIGTERM, a closed terminal) ends the node as ``rosnode kill`` does: beside the main thread.

    rospy's own handlers run the shutdown on top of whatever the main thread was just doing, and then wait for ever for locks that
    it holds: those of its talk with the master, which even `rospy.loginfo` takes (seen with 1.15.15). ``nohup`` is respected.
    """
    rospy.init_node(name, disable_signals=True)
    signals = queue.SimpleQueue()  # takes no lock: it may be used in a signal handler

    def end():
        reason = "signal %d" % signals.get()
        threading.Thread(target=rospy.signal_shutdown, args=(reason,), daemon=False).start()  # Python waits for its end

    threading.Thread(target=end, name="signals", daemon=True).start()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, lambda number, frame: signals.put(number))

"""The end of a node that another thread has begun, as `rosnode kill` does."""

import subprocess
import sys

END = """
import threading, time, rospy
from pioneer_control import ros_node

def unregister(reason):         # as a hook of rospy's own, which asks a slow master
    time.sleep(0.2)
    print("unregistered")

rospy.init_node = lambda *_, **__: rospy.core.add_shutdown_hook(unregister)
ros_node._raise_listen_backlog = ros_node._publish_log_in_thread_of = lambda *_: None
ros_node.init_node("x")
threading.Thread(target=rospy.signal_shutdown, args=("rosnode kill",), daemon=True).start()
while not rospy.core.is_shutdown_requested():
    time.sleep(0.01)
"""


def test_a_node_that_is_killed_by_name_tells_the_master_before_it_ends():
    done = subprocess.run([sys.executable, "-c", END], stdout=subprocess.PIPE, universal_newlines=True, check=True)
    assert done.stdout == "unregistered\n"

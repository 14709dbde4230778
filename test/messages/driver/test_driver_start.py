"""Which modules a start of the driver loads. Loading takes half of the time to the first pose, and loaded modules stay
in memory.
"""

import subprocess
import sys

NOT_NEEDED = {"actionlib", "matplotlib", "PyKDL", "serial", "tf", "tf2_py", "tf2_ros", "visualization_msgs",
              "websocket", "pioneer_control.bags", "pioneer_control.simulator", "pioneer_control.tutorial"}


def loaded_by(module):
    """Return the modules in memory after one module was imported in a new Python process."""
    code = "import sys, %s; print(*sys.modules)" % module
    return set(subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True).stdout.decode().split())


def test_the_driver_loads_nothing_that_it_does_not_use():
    loaded = loaded_by("pioneer_control.driver.node")
    assert {"rospy", "pioneer_control.client"} <= loaded
    assert not loaded & NOT_NEEDED


def test_what_is_loaded_is_seen():
    assert {"tf2_ros", "tf2_py", "actionlib"} <= loaded_by("tf2_ros")

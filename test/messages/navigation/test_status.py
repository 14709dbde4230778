"""What the diagnostics say of navigation."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.localisation import Where
from pioneer_control.navigation.navigator import State
from pioneer_control.navigation.node.laser_watch import LaserState
from pioneer_control.navigation.node.status import judged
from pioneer_control.navigation.pilot import NOTHING_YET

SURE = Where(1.0, Pose(0.0, 0.0, 0.0), True, np.eye(3), "")
DRIVES = NOTHING_YET._replace(where=SURE, state=State.DRIVING, reason="on the way")


def test_a_robot_on_its_way_is_well():
    assert judged(DRIVES) == (DiagnosticStatus.OK, "driving: on the way")


@pytest.mark.parametrize("step, tf_trouble, named", [
    (DRIVES._replace(where=SURE._replace(sure=False, reason="lost")), "", "lost"),
    (DRIVES._replace(state=State.WAITING, reason="motor power is off"), "", "waiting: motor power is off"),
    (DRIVES._replace(state=State.FAILED, reason="no way"), "", "failed: no way"),
    (DRIVES, "several nodes", "several nodes"),
    (DRIVES._replace(late=0.3), "", "0.3 s later than usual"),
])
def test_what_is_not_well_is_a_warning_with_its_reason(step, tf_trouble, named):
    level, text = judged(step, tf_trouble)
    assert level == DiagnosticStatus.WARN and named in text


def test_a_little_late_is_no_warning():
    assert judged(DRIVES._replace(late=0.05))[0] == DiagnosticStatus.OK


def test_a_laser_that_is_of_no_use_is_a_warning_but_what_else_is_not_well_comes_first():
    silent = LaserState("no scan for 3.0 s", True)
    assert judged(DRIVES, "", silent) == (DiagnosticStatus.WARN, "laser: no scan for 3.0 s")
    assert judged(DRIVES._replace(state=State.FAILED, reason="no way"), "", silent)[1] == "failed: no way"
    assert judged(DRIVES, "", LaserState("used", False)) == (DiagnosticStatus.OK, "driving: on the way")

"""Where the lasers of robots are, and on which ports. No port is opened that is not wanted."""

import math

import pytest

from pioneer_control import lms2xx
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.clock import NEVER_US
from pioneer_control.simulator.firmware.line_laser import laser_place
from pioneer_control.simulator.line import lasers
from pioneer_control.simulator.line.lasers import LaserPorts, PoseHistory, laser_ports
from pioneer_control.simulator.lms200 import PERFECT, FirmwareNumbers, LaserFirmware, Optics, standing
from pioneer_control.simulator.world import World


class StandInRobot:
    true_pose, velocity = (0.0, 0.0, 0.0), (0.0, 0.0)


def test_poses_of_the_past():
    robot = StandInRobot()
    history = PoseHistory(robot, 0)
    for step in range(1, 101):
        robot.true_pose = (0.01 * step, 0.0, 0.02 * step)
        history.note(step * 20000)
    assert history.pose_at(1.5) == pytest.approx((0.75, 0.0, 1.5))
    assert history.pose_at(1.51) == pytest.approx((0.755, 0.0, 1.51))
    assert history.pose_at(0.0)[0] == pytest.approx(0.5), "the oldest that is kept"


def test_a_pose_after_the_last_step_goes_on_with_the_present_speed():
    robot = StandInRobot()
    history = PoseHistory(robot, 0)
    robot.true_pose, robot.velocity = (1.0, 2.0, math.pi / 2.0), (0.5, 0.0)
    history.note(20000)
    assert history.pose_at(0.03) == pytest.approx((1.0, 2.005, math.pi / 2.0))


@pytest.mark.parametrize("ports, robots, robots_tcp, wanted", [
    (LaserPorts(), 1, 8101, ["127.0.0.1:8102"]), (LaserPorts(), 2, 8101, ["127.0.0.1:8103", "127.0.0.1:8104"]),
    (LaserPorts(), 1, None, ["127.0.0.1:8102"]), (LaserPorts(), 1, "0.0.0.0:9000", ["0.0.0.0:9001"]),
    (LaserPorts(), 2, 0, ["127.0.0.1:0", "127.0.0.1:0"]),
    (LaserPorts(tcp=7000), 2, 8101, ["127.0.0.1:7000", "127.0.0.1:7001"]),
    (LaserPorts(tcp=0), 1, 8101, ["127.0.0.1:0"]), (LaserPorts(tcp="0.0.0.0:70"), 1, None, ["0.0.0.0:70"]),
])
def test_ports(monkeypatch, ports, robots, robots_tcp, wanted):
    monkeypatch.setattr(lasers, "TcpLine", lambda address: address)
    assert [ports.line_of(number, robots, robots_tcp) for number in range(robots)] == wanted


def test_links(monkeypatch):
    monkeypatch.setattr(lasers, "PtyLine", lambda link, unread_limit: (link, unread_limit > 2 * 812))
    assert LaserPorts(pty="/tmp/pioneer_laser").line_of(0, 1, 8101) == ("/tmp/pioneer_laser", True)
    assert LaserPorts(pty="/tmp/pioneer_laser").line_of(1, 2, 8101) == ("/tmp/pioneer_laser2", True)


def test_what_the_user_says():
    assert laser_ports("none", None, None) is laser_ports("line", None, None) is None
    assert laser_ports("lms200", 8105, None) == LaserPorts(tcp=8105)
    assert laser_ports("lms200", None, "/tmp/pioneer_laser") == LaserPorts(pty="/tmp/pioneer_laser")


@pytest.mark.parametrize("given, message", [
    (("none", 8102, None), "no laser: give laser lms200"),
    (("none", None, "/tmp/pioneer_laser"), "/tmp/pioneer_laser is given"),
    (("line", 8102, None), "no laser: give laser lms200, too, which has a line of its own"),
    (("lms200", 8102, "/tmp/pioneer_laser"), "not both"),
])
def test_what_makes_no_sense(given, message):
    with pytest.raises(ParameterError, match=message):
        laser_ports(*given)


def test_behind_a_bridge_the_speed_stays():
    optics = Optics(World("hall"), PERFECT)
    laser = LaserFirmware(optics, standing((0.0, 0.0, 0.0)), FirmwareNumbers(boot=0.0), fixed_baud=500000)
    laser.advance(0.1)
    laser.receive(lms2xx.encode(lms2xx.SetMode(lms2xx.SPEEDS[9600].mode, b"")))
    assert laser.advance(0.2) == b"\x06" + lms2xx.encode(lms2xx.ModeSet(0)) and laser.baud == 500000
    laser.power_off()
    assert laser.baud == 500000 and laser.sent_at_us == NEVER_US
    laser.power_on()
    laser.run_to(laser.clock.now_us)
    assert laser.sent_at_us == laser.clock.now_us + 29 * 20, "telegram 90 has 29 bytes"


def test_any_model_may_have_one_also_where_nobody_knows_its_place():
    assert laser_place(find_model("p3dx-sh")) == find_model("p3dx-sh").laser
    assert find_model("amigo-sh").laser is None and laser_place(find_model("amigo-sh"))[:2] == (0.0, 0.0)

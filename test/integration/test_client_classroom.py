"""Robot on a WebSocket: a real server of robots (tornado) between the client and the simulated robot."""

import re
import subprocess
import sys
import threading
import traceback

import pytest

from pioneer_control.client import LinkDown, Ready, Robot
from pioneer_control.errors import LinkLostError, PortError
from pioneer_control.p2os import encode_command
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.world import load_world

from real_time import LIMIT, keep_commanding, until
from robot_server import KEY, KEY_IN_URL, REFUSAL, RobotServer


@pytest.fixture
def simulator():
    with Server(Firmware(find_model("p3dx-sh"), load_world("empty"), name="rosie"), tcp=0) as running:
        yield running


@pytest.fixture
def school(simulator):
    with RobotServer(int(simulator.url.rpartition(":")[2])) as running:
        yield running


def drive_and_stop(robot):
    robot.enable_motors()
    begin = robot.state.x
    keep_commanding(robot, lambda: robot.set_velocity(0.3, 0.0), lambda state: state.x > begin + 0.2)
    keep_commanding(robot, robot.stop, lambda state: not state.linear)


@pytest.mark.parametrize("halves", [False, True], ids=["whole frames", "halves"])
def test_it_drives_and_stops_and_leaves_the_robot_closed(school, simulator, halves):
    school.halves = halves
    with Robot(school.url, key=KEY) as robot:
        assert robot.identity.name == "rosie"
        drive_and_stop(robot)
    assert robot.link.bad_checksums == robot.link.discarded_bytes == 0
    until(lambda: simulator.firmware.session is FirmwareState.WAITING, "closed")
    assert simulator.firmware.true_pose[0] > 0.15 and not simulator.firmware.motors_enabled


def test_the_robot_hears_nothing_before_sync0_as_on_tcp(school):
    with Robot(school.url + "#key=" + KEY_IN_URL):
        pass
    assert school.heard[0] == encode_command("PULSE"), "the same bytes as SYNC0"
    assert school.heard[-1].endswith(encode_command("CLOSE"))


def told(error):
    return "".join(traceback.format_exception(type(error), error, error.__traceback__)) + repr(error)


@pytest.mark.parametrize("key", ["wrong " + KEY, KEY.upper(), ""])
def test_a_refusal_is_an_error_with_the_reason_of_the_server(school, key):
    with pytest.raises(PortError, match=re.escape(school.url + ": the server refuses: " + REFUSAL[1])) as raised:
        with Robot(school.url, key=key):
            pass
    assert not key or key not in told(raised.value)
    assert school.connections == 0


def test_a_path_without_a_robot(school):
    with pytest.raises(PortError, match="/robot/8: .*HTTP status 404"):
        with Robot(school.url[:-1] + "8", key=KEY):
            pass


def test_a_key_is_in_no_message_of_a_robot_that_had_one(school):
    threads = []
    with Robot(school.url + "#key=" + KEY_IN_URL) as robot:
        threads = [thread.name for thread in threading.enumerate()]
        school.close(4408, "the lesson is over: %s" % KEY)
        assert robot.wait_until_ended(LIMIT)
        with pytest.raises(LinkLostError, match=re.escape(school.url) + ".*lesson is over") as raised:
            robot.set_velocity(0.1, 0.0)
    said = told(raised.value) + robot.link.last_error + robot.url + " ".join(threads)
    assert KEY not in said and KEY_IN_URL not in said


@pytest.mark.parametrize("harm", ["close", "garbage", "half a frame"])
def test_a_lost_connection_is_made_again_and_the_robot_drives_on(school, harm):
    events = []
    robot = Robot(school.url, key=KEY, reconnect=True, on_event=events.append).start()
    robot.wait_until_ready(LIMIT)
    if harm == "close":
        school.close(1012, "restart")
    else:
        school.spoil(b"\xff\x01" + bytes(5) if harm == "garbage" else b"\x82\x7e\xff\xff")
    until(lambda: any(isinstance(event, LinkDown) for event in events), "lost")
    until(lambda: sum(isinstance(event, Ready) for event in events) == 2, "ready again")
    drive_and_stop(robot)
    robot.close()
    assert robot.link.reconnects == 1 and school.connections >= 2


def test_a_robot_that_is_gone_is_a_lost_link(school, simulator):
    with Robot(school.url, key=KEY) as robot:
        simulator.stop()
        assert robot.wait_until_ended(LIMIT)
        with pytest.raises(LinkLostError, match="the robot is gone"):
            robot.wait_for_state()


def test_the_report_on_the_command_line_shows_no_key(school):
    def run(url):
        return subprocess.run([sys.executable, "-m", "pioneer_control.client", url], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=LIMIT)

    good, bad = run(school.url + "#key=" + KEY_IN_URL), run(school.url + "#key=wrong-key")
    assert good.returncode == 0 and "p3dx-sh" in good.stdout and good.stdout.split()[1] == school.url
    assert bad.returncode == 1 and REFUSAL[1] in bad.stderr and len(bad.stderr.splitlines()) == 1
    said = good.stdout + good.stderr + bad.stdout + bad.stderr
    assert not any(key in said for key in (KEY, KEY_IN_URL, "wrong-key"))

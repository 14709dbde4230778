"""Driving from the page: what the robot hears, and that it stands when anything between it and the hand is gone.

Figures are printed (pytest -s). Bounds hold on a busy machine.
"""

import json
import os
import signal
import socket
import time

import pytest

from pioneer_control.web.frames import stamp_age

from web_site import PERIOD, Viewer, freeze, signal_server, site_with_robot
from real_time import until

SAFE = 0.6      # s until a robot is told to stand, whatever died
BUSY = 0.4      # s that a busy machine of two cores may add
HALT = ("GRIPPER", 15)      # STOP halts the gripper, too


@pytest.fixture
def all_of_it(tmp_path):
    with site_with_robot(tmp_path) as everything:
        yield everything


def driving(viewer, robot, heard):
    """Let a viewer hold a key until the robot really moves. A hand that was on a key before has let go."""
    viewer.switch_motors_on()
    viewer.drive(forward=0.0)
    viewer.obeys = True         # a hand that a busy machine made late
    viewer.hold()
    until(lambda: robot.firmware.velocity[0] > 0.1, "it drives: %s" % viewer.texts[-3:])
    viewer.obeys = False
    assert heard.moves(0.0)


def stands(robot):
    return robot.firmware.velocity == (0.0, 0.0)


def told_to_stand(heard, since, what):
    """Wait until the robot is told to stand. Returns after how many seconds, and checks that only zeros follow."""
    until(lambda: heard.stops(since), "%s: the robot is told to stand" % what)
    after = heard.stops(since)[0] - since
    print("%s: zero on the wire after %.3f s" % (what, after))
    assert all(at < heard.stops(since)[0] for at in heard.moves(since))
    return after


def test_first_picture_drive_and_release(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        frame = viewer.picture()
        print("first picture %.2f s after the start, with a robot that waits" % (time.monotonic() - site.began))
        assert viewer.texts[0] == ("hello", {"title": robot.url, "kind": "live", "teacher": True, "you": ""})
        assert frame.flags & 1 and not frame.flags & 2 and viewer.newest("robots")[0]["model"] == "p3dx-sh"
        driving(viewer, robot, heard)
        limit = viewer.newest("helm")["limit"][0]
        assert limit == 0.2 and robot.firmware.velocity[0] <= 0.21
        assert viewer.newest("helm")["you"] and viewer.newest("helm")["commander"] == "person"
        viewer.let_go()
        time.sleep(0.06)        # the last velocity of the hand is out
        released = time.monotonic()
        viewer.drive(forward=0.0)
        assert told_to_stand(heard, released, "released") < 0.3
        until(lambda: stands(robot), "it stands")
        assert heard.moves(released) == []
    assert "Traceback" not in site.errors


def test_the_hand_gone_without_a_word_stops_in_time(all_of_it):
    """The page's main thread is busy, or the network carries nothing: no velocity comes, and no zero either."""
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        driving(viewer, robot, heard)
        viewer.let_go()
        assert told_to_stand(heard, time.monotonic(), "silent viewer") < SAFE + BUSY


def test_a_viewer_that_vanishes_stops_at_once(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer, Viewer(site, visitor="other0123456789ab") as other:
        driving(viewer, robot, heard)
        viewer.let_go()
        time.sleep(0.06)
        gone = time.monotonic()
        viewer.socket.sock.shutdown(socket.SHUT_RDWR)
        assert told_to_stand(heard, gone, "vanished viewer") < SAFE + BUSY
        until(lambda: stands(robot), "it stands")
        until(lambda: other.newest("helm")["commander"] == "", "the seat is free")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_web_server_stops_the_robot_and_comes_back(all_of_it, number):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        driving(viewer, robot, heard)
        pid, at = signal_server(site, number)
        assert told_to_stand(heard, at, "killed web server") < SAFE + BUSY
    until(lambda: site.server_pid() not in (None, pid), "another server runs")
    with Viewer(site) as viewer:     # the same port, the same key
        viewer.picture()
        print("the picture is back %.2f s after the kill" % (time.monotonic() - at))
        assert viewer.newest("trail")["points"] != [] and viewer.newest("robots")[0]["model"] == "p3dx-sh"
        assert heard.moves(at + SAFE + BUSY) == []
        driving(viewer, robot, heard)


def test_a_stopped_web_server_stops_the_robot_and_what_it_queued_moves_nothing(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        driving(viewer, robot, heard)
        pid, at = freeze(site)
        assert told_to_stand(heard, at, "stopped web server") < SAFE + BUSY
        until(lambda: stands(robot), "it stands")       # the hand is on the key all the time
        time.sleep(1.0)
        viewer.let_go()
        going_on = time.monotonic()
        os.kill(pid, signal.SIGCONT)
        until(lambda: viewer.said("let go"), "the queued velocities are refused: %s" % viewer.texts[-3:])
        stamp = viewer.frames[1].stamp
        until(lambda: viewer.frames[1].stamp != stamp, "the picture goes on")
        assert heard.moves(going_on) == [] and stands(robot)
        driving(viewer, robot, heard)


def test_an_unlock_that_waited_in_a_stopped_server_is_refused(all_of_it):
    """Also orders without a stamp do not come late: they count with the picture on the screen."""
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        viewer.switch_motors_on()
        stopped = time.monotonic()
        viewer.do("stop", robot=1)
        until(lambda: viewer.frames[1].flags & 256, "locked")
        until(lambda: heard.stops(stopped), "the robot has heard all that was said before: ENABLE may be said twice")
        pid, at = freeze(site)
        time.sleep(0.3)         # what was under way has been drawn
        stamp = viewer.frames[1].stamp
        until(lambda: stamp_age(stamp, time.monotonic()) > 2.2, "the picture is old")
        for do in ("unlock", "take", "release"):
            viewer.do(do, robot=1)
        viewer.do("gripper", robot=1, command="close")
        os.kill(pid, signal.SIGCONT)
        until(lambda: viewer.said("picture was more than 2 s old"), "refused")
        until(lambda: viewer.frames[1].stamp != stamp, "the picture goes on")
        viewer.do("ping", at=1)
        until(lambda: viewer.of("pong"), "all was heard")
        assert viewer.frames[1].flags & 256 and viewer.newest("helm")["locks"] == ["stop"]
        assert not [each for each in heard.since(at) if each[1] in ("GRIPPER", "ENABLE") and each[1:] != HALT]


def test_a_server_that_is_stopped_for_good_is_replaced(tmp_path):
    with site_with_robot(tmp_path, HUNG=2.0) as (site, _, _):
        with Viewer(site) as viewer:
            viewer.picture()
            pid, _ = freeze(site)
            until(lambda: site.server_pid() not in (None, pid), "another server runs")
        with Viewer(site) as viewer:
            viewer.picture()


def test_one_seat_and_anybody_may_stop(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as ada, Viewer(site, visitor="other0123456789ab") as bob:
        ada.do("name", name="Ada")
        driving(ada, robot, heard)
        bob.picture()
        bob.drive(forward=-1.0)
        until(lambda: bob.said("Ada drives this robot now"), "Bob is refused")
        assert bob.newest("helm")["who"] == "Ada" and not bob.newest("helm")["you"]
        pressed = time.monotonic()
        bob.do("stop", robot=1)
        assert told_to_stand(heard, pressed, "stopped by another viewer") < SAFE
        until(lambda: ada.said("locked"), "Ada is told why")
        assert ada.newest("helm")["locks"] == ["stop"]
        until(lambda: ada.frames[1].flags & 256, "the frame says locked")
        bob.do("unlock", robot="all")
        until(lambda: ada.said("let go"), "Ada must let go first")
        assert [at for at in heard.moves(pressed) if at > heard.stops(pressed)[0]] == []
        ada.let_go()
        time.sleep(2 * PERIOD)      # the hand is off the key
        ada.drive(forward=0.0)
        again = time.monotonic()
        ada.obeys = True
        ada.hold()
        until(lambda: heard.moves(again), "Ada drives again")
        texts = [each for _, each in bob.texts]
        assert "visitor0123456789" not in str(texts)


def test_the_picture_that_drives_must_be_fresh(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        viewer.switch_motors_on()
        old = viewer.frames[1].stamp - 450
        for forward in (1.0, -1.0):
            viewer.drive(forward=forward, stamp=old % 2 ** 32)
        until(lambda: viewer.said("picture was more than 0.4 s old"), "refused")
        viewer.do("drive", robot=-1, forward=1.0, turn=0.0, stamp=viewer.frames[1].stamp)
        until(lambda: viewer.said("robot is -1"), "refused too")
        viewer.do("drive", robot=9, forward=1.0, turn=0.0, stamp=viewer.frames[1].stamp)
        until(lambda: viewer.said("there is no robot 9"), "refused too")
        assert heard.moves(0.0) == []


def test_limit_gripper_and_motors(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        viewer.switch_motors_on()
        viewer.do("limit", robot=1, linear=0.4)
        until(lambda: viewer.newest("helm")["limit"][0] == 0.4, "the limit is told")
        viewer.hold()
        until(lambda: robot.firmware.velocity[0] > 0.3, "faster than before")
        viewer.do("gripper", robot=1, command="close")
        until(lambda: [each for each in heard.all if each[1] == "GRIPPER"], "the gripper is told")
        viewer.let_go()
        viewer.do("motors", robot=1, on=False)
        until(lambda: not viewer.frames[1].flags & 2, "motors are off")
        until(lambda: stands(robot), "it stands")


def test_a_robot_that_falls_silent_is_seen_and_comes_back(all_of_it):
    site, robot, heard = all_of_it
    with Viewer(site) as viewer:
        viewer.picture()
        robot.lock.acquire()        # the robot's world stands still
        try:
            until(lambda: viewer.frames[1].age > 0.5, "the picture is known to be old")
            until(lambda: not viewer.frames[1].flags & 1, "the link is lost")
            until(lambda: viewer.newest("status")["link"] != "ok", "and the page is told")
            assert viewer.newest("status")["lost"] and viewer.newest("status")["faults"]
        finally:
            robot.lock.release()
        until(lambda: viewer.frames[1].flags & 1 and viewer.frames[1].age < 0.3, "the link is back")
        until(lambda: viewer.newest("status")["link"] == "ok", "and the page is told")


def test_the_map_of_a_simulator(tmp_path):
    """The simulator's socket of the truth, here held by the test, may come after the page."""
    path = str(tmp_path / "truth")
    with site_with_robot(tmp_path, "--truth", path) as (site, robot, heard), Viewer(site) as viewer:
        viewer.picture()
        world = {"name": "lab", "bounds": [0, 0, 4, 4], "walls": [], "boxes": [], "posts": [], "cans": [[0.03, 0.1]],
                 "places": [],
                 "robots": [{"url": robot.url}]}
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(path)
            listener.listen(1)
            simulator, _ = listener.accept()
            with simulator:
                truth = {"robots": [[1.0, 2.0, 0.5, 0.0, 0.0, False]], "origins": [[1.0, 2.0, 0.5]],
                         "cans": [[1.0, 1.0, 0.0, -1]]}
                for message in ({"world": world}, {"truth": truth}):
                    simulator.sendall(json.dumps(message).encode() + b"\n")
                until(lambda: viewer.newest("origins") == {"1": [1.0, 2.0, 0.5]}, "where the odometry begins")
                until(lambda: viewer.newest("cans") == [[1.0, 1.0, 0.0]], "the cans")
        with Viewer(site, visitor="later0123456789ab") as later:
            until(lambda: later.newest("world"), "the map, also after the simulator is gone")
            assert later.newest("world")["can"] == {"radius": 0.03} and later.newest("robots")[0]["simulated"]

"""One robot's whole navigation: it goes where it is sent, with a simulated robot in a small world."""

import math

import numpy as np
import pytest

from pioneer_control import p2os
from pioneer_control.client.odometry import Odometry
from pioneer_control.errors import RefusedError
from pioneer_control.floor_poses import Pose, compose
from pioneer_control.maps import FREE, UNKNOWN
from pioneer_control.navigation.chassis import Chassis
from pioneer_control.navigation.exploring import Explorer
from pioneer_control.navigation.firings import timed
from pioneer_control.navigation.node.map_files import floor_map_of
from pioneer_control.navigation.mapping import Mapper
from pioneer_control.navigation.navigator import Navigator, Readiness, State
from pioneer_control.navigation.pilot import HOME_TRIES, OwnMap, Pilot
from pioneer_control.navigation.pose_graph import PoseGraph
from pioneer_control.navigation.steady_odometry import SteadyOdometry
from pioneer_control.navigation.tuned import NavigationNumbers
from pioneer_control.navigation.values import Sensing
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.poses import box_walls, closed

MODEL = find_model("p3dx-sh")
ROOM = closed([(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (2.0, 4.0), (2.0, 5.0), (0.0, 5.0)]) + box_walls(
    (3.5, 1.4), (0.6, 0.8), 0.0)
SMALL_ROOM = closed([(0.0, 0.0), (4.5, 0.0), (4.5, 2.5), (0.0, 2.5)])
START = (1.0, 1.0, 0.5)


class Drive:
    """A pilot and its simulated robot."""

    def __init__(self, with_map=True, walls=ROOM):
        world = World("room", walls, starts=[START])
        self.firmware = Firmware(MODEL, world, gripper=False)
        self.pilot = Pilot(floor_map_of(world) if with_map else None,
                           Chassis(MODEL.sonar, MODEL.outline(False), 0.4, 1.6), seed=1)
        self._decoder, self._odometry = p2os.FrameDecoder(), Odometry(
            MODEL.dist_mm_per_unit, MODEL.angle_units_per_rev)
        self._steady = SteadyOdometry()
        for step in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2):
            self.firmware.receive(p2os.encode_frame(step))
        for command in (("OPEN",), ("ENABLE", 1), ("SONAR", 1), ("SETA", 500), ("SETA", -800), ("SETRA", 172),
                        ("SETRA", -172)):
            self.firmware.receive(p2os.encode_command(*command))

    def step(self, readiness=Readiness()):
        """Let one packet come, and do what the pilot says."""
        sip = None
        while not isinstance(sip, p2os.Sip):
            for frame in self._decoder.feed(self.firmware.advance(0.02)):
                sip = p2os.decode_packet(frame)
        self._odometry.update(sip.x_counts, sip.y_counts, sip.heading_units)
        heard = [(each.number, each.range_units * MODEL.range_mm_per_unit / 1000.0) for each in sip.sonar]
        odometry = self._steady.of(Pose(*self._odometry.pose), self.firmware.time)
        step = self.pilot.sense(Sensing(self.firmware.time, odometry, timed(heard, self.firmware.time),
                                        self._steady.origin), readiness)
        self.firmware.receive(p2os.encode_command("VEL", round(step.twist.linear * 1000)))
        self.firmware.receive(p2os.encode_command("RVEL", round(math.degrees(step.twist.angular))))
        return step

    def resets_on_its_way(self):
        """Go on until the robot drives 1 m from where it began, and reset its odometry: the next pose is 0, 0, 0."""
        while not (self.step().twist.linear > 0.2 and self.off(Pose(*START)) > 1.0):
            assert self.firmware.time < 60.0 and not self.pilot.step.jumped, self.pilot.step
        self._odometry = Odometry(MODEL.dist_mm_per_unit, MODEL.angle_units_per_rev)
        self.firmware.hardware.reset_odometry()

    def until(self, *states, most=120.0):
        """Go on until the pilot is in one of some states, at most for some simulated seconds. Return the last step."""
        end = self.firmware.time + most
        while True:
            step = self.step()
            if step.state in states:
                return step
            assert self.firmware.time < end, step

    def off(self, goal):
        x, y, _ = self.firmware.true_pose
        return math.hypot(goal.x - x, goal.y - y)


@pytest.fixture
def drive():
    drive = Drive()
    drive.pilot.start_at(Pose(*START), 0.05, 0.05)
    drive.step()
    return drive


def test_it_goes_where_it_is_sent_round_what_is_in_its_way(drive):
    goal = Pose(5.2, 1.4, 1.0)
    assert drive.pilot.go_to(goal) == ""
    step = drive.step()
    assert step.goal == goal and len(step.plan) > 2
    assert drive.until(State.REACHED, State.FAILED).state is State.REACHED
    assert drive.off(goal) < 0.15 and drive.firmware.contacts == 0
    assert abs(drive.firmware.true_pose[2] - 1.0) < 0.15
    assert drive.step().goal is None


@pytest.mark.parametrize("goal", [Pose(3.5, 1.4, 0.0), Pose(99.0, 0.0, 0.0), Pose(math.nan, 1.0, 0.0),
                                  Pose(1.0, 1.0, math.inf)])
def test_a_goal_that_makes_no_sense_is_refused_and_nothing_moves(drive, goal):
    assert drive.pilot.go_to(goal) != ""
    for _ in range(10):
        assert drive.step().twist == (0.0, 0.0)


def test_on_its_way_its_odometry_is_reset(drive):
    goal = Pose(5.2, 1.4, 1.0)
    drive.pilot.go_to(goal)
    drive.resets_on_its_way()
    step = drive.step()
    assert step.jumped and step.odometry == pytest.approx((0.0, 0.0, 0.0), abs=0.05), "it says what the wheels tell"
    assert step.twist.linear > 0.2 and drive.off(step.where.pose) < 0.1
    assert drive.until(State.REACHED, State.FAILED).state is State.REACHED
    assert drive.off(goal) < 0.15 and drive.firmware.contacts == 0


def test_while_it_makes_a_map_its_odometry_is_reset():
    drive = Drive(with_map=False)
    drive.step()
    drive.pilot.explore(True)
    drive.resets_on_its_way()
    assert [drive.step().jumped for _ in range(30)] == [True] + [False] * 29
    assert drive.off(compose(Pose(*START), drive.pilot.step.where.pose)) < 0.15


def test_cancelled_it_stands(drive):
    drive.pilot.go_to(Pose(5.2, 1.4, 1.0))
    while not drive.step().twist.linear > 0.2:
        pass
    drive.pilot.cancel()
    step = drive.step()
    assert (step.state, step.twist, step.goal, step.plan) == (State.IDLE, (0.0, 0.0), None, [])


def test_what_is_refused_changes_nothing(drive):
    goal = Pose(5.2, 1.4, 1.0)
    drive.pilot.go_to(goal)
    drive.step()
    assert "in a wall" in drive.pilot.go_to(Pose(0.0, 0.0, 0.0))
    assert "there is a map" in drive.pilot.explore(True)
    assert drive.pilot.explore(False) == ""     # it does not explore
    assert drive.step().goal == goal
    drive.until(State.REACHED)
    assert drive.off(goal) < 0.1


def test_while_it_explores_a_bad_goal_and_a_second_order_change_nothing_and_an_end_ends_it():
    drive = Drive(with_map=False)
    drive.step()
    assert drive.pilot.explore(True) == "" and drive.pilot.explores
    drive.until(State.DRIVING)
    assert "outside" in drive.pilot.go_to(Pose(99.0, 0.0, 0.0))
    assert drive.pilot.explore(True) == "" and drive.step().state is State.DRIVING and drive.pilot.explores
    assert drive.pilot.explore(False) == "" and not drive.pilot.explores
    assert drive.step().state is State.IDLE


def test_on_packets_that_are_heard_too_late_it_stands(drive):
    assert drive.pilot.go_to(Pose(5.0, 3.0, 0.0)) == ""
    step = drive.step(Readiness(late=0.7))
    assert (step.state, step.twist.linear, step.reason) == (State.WAITING, 0.0, "what the robot sensed is 0.7 s old")
    assert drive.until(State.REACHED).state is State.REACHED


def test_without_news_of_the_robot_it_stands(drive):
    drive.pilot.go_to(Pose(5.2, 1.4, 1.0))
    drive.step()
    silent = drive.pilot.silent(0.7)
    assert (silent.state, silent.twist) == (State.WAITING, (0.0, 0.0)) and "0.7 s" in silent.reason
    assert drive.until(State.REACHED).state is State.REACHED


def test_it_does_not_drive_while_it_does_not_know_where_it_is():
    drive = Drive()
    drive.step()
    assert drive.pilot.go_to(Pose(5.2, 1.4, 1.0)) == ""
    for _ in range(30):
        step = drive.step()
        assert step.state is State.WAITING and step.twist.linear == 0.0
    assert "I do not know where I am" in step.reason


def test_a_way_is_told_without_driving(drive):
    points = drive.pilot.way(Pose(1.0, 1.0, 0.0), Pose(5.2, 1.4, 0.0))
    assert math.hypot(points[-1][0] - 5.2, points[-1][1] - 1.4) < 0.2
    with pytest.raises(RefusedError):
        drive.pilot.way(Pose(1.0, 1.0, 0.0), Pose(99.0, 0.0, 0.0))


def test_it_explores_a_room_without_a_map_and_comes_home():
    drive = Drive(with_map=False, walls=SMALL_ROOM)
    for _ in range(5):
        drive.step()
    assert drive.pilot.explore(True) == ""
    step = drive.until(State.REACHED, State.FAILED, most=600.0)
    for step in (step, drive.step(), drive.step()):
        assert (step.state, step.reason) == (State.REACHED, "explored, home again")
    assert drive.off(Pose(*START)) < 0.4 and drive.firmware.contacts == 0
    grid = drive.pilot.grid
    assert (grid.cells == 0).sum() * grid.resolution ** 2 > 8.0


def test_it_explores_on_from_its_way_home_once_it_got_away_from_where_it_was_jammed(monkeypatch):
    homes, choose = [], Explorer.next

    def noted(explorer, *asked):
        goal = choose(explorer, *asked)
        if goal is not None and explorer.homeward:
            homes.append(goal)
            explorer._jam = Pose(99.0, 99.0, 0.0) if len(homes) <= HOME_TRIES else None    # it is not there
        return goal
    monkeypatch.setattr(Explorer, "next", noted)
    drive = Drive(with_map=False, walls=SMALL_ROOM)
    drive.step()
    drive.pilot.explore(True)
    step = drive.until(State.REACHED, State.FAILED, most=600.0)
    assert (step.state, step.reason) == (State.REACHED, "explored, home again")
    assert len(homes) == HOME_TRIES + 1, "none of these was a try that failed"


def test_a_robot_that_explores_knows_where_it_has_driven(monkeypatch):
    paths, choose = [], Explorer.next

    def noted(explorer, grid_map, pose, time, path):
        paths.append(path)
        assert path[-1] == pytest.approx(pose[:2], abs=0.02)
        return choose(explorer, grid_map, pose, time, path)
    monkeypatch.setattr(Explorer, "next", noted)
    drive = Drive(with_map=False, walls=SMALL_ROOM)
    drive.step()
    drive.pilot.explore(True)
    drive.until(State.REACHED, State.FAILED, most=600.0)
    assert len(paths) > 4 and np.ptp(paths[-1], axis=0).max() > 1.0


def test_exploring_ends_when_somebody_wants_it_and_a_known_map_needs_none(drive):
    assert "there is a map" in drive.pilot.explore(True)
    own = Drive(with_map=False)
    assert "nothing heard" in own.pilot.explore(True)
    own.step()
    own.pilot.explore(True)
    own.step()
    assert own.pilot.explore(False) == ""
    assert own.step().state is State.IDLE
    with pytest.raises(RefusedError):
        own.pilot.start_at(Pose(0.0, 0.0, 0.0))
    with pytest.raises(RefusedError):
        own.pilot.start_anywhere()


@pytest.mark.parametrize("with_map, fastest", [(True, 1.6), (False, 1.2)])
def test_a_robot_that_makes_its_map_turns_slower_so_that_it_hears_meanwhile(with_map, fastest):
    drive = Drive(with_map)
    if with_map:
        drive.pilot.start_at(Pose(*START), 0.1, 0.05)
    for _ in range(20):
        drive.step()
    here = drive.pilot.step.where.pose
    assert drive.pilot.go_to(here._replace(heading=here.heading + 3.0)) == ""
    rates = [abs(drive.step().twist.angular) for _ in range(40)]
    assert max(rates) == pytest.approx(fastest)


def test_on_its_own_map_the_robot_may_go_wherever_it_has_been():
    own = OwnMap(Chassis(MODEL.sonar, MODEL.outline(False), 0.4, 1.6), NavigationNumbers(), Pose(1.0, 2.0, 0.0))
    for number in range(31):
        own.sense(Sensing(0.1 * number, Pose(0.1 * number, 0.0, 0.0), ()))
    assert own.grid.at(2.5, 2.0) == UNKNOWN
    x = np.linspace(3.1, 4.0, 19)
    assert (own.drivable.at(x, 2.0 + 0.2) == FREE).all()
    assert (own.drivable.at(x, 2.0 + 0.5) == UNKNOWN).all()


def test_while_it_explores_no_packet_has_to_do_all_at_once(monkeypatch):
    """A new map, the plan on it, the choice of the next goal, the order to go there: each has packets of its own, in
    which the map is not corrected.
    """
    did, seen, together = [], set(), []
    for owner, name in ((Navigator, "use_map"), (Navigator, "_plan_anew"), (Explorer, "next"), (Navigator, "go_to"),
                        (Mapper, "_match"), (Mapper, "_tie"), (PoseGraph, "solve")):
        def noted(*arguments, _call=getattr(owner, name), _name=name, **more):
            did.append(_name)
            return _call(*arguments, **more)
        monkeypatch.setattr(owner, name, noted)
    drive = Drive(with_map=False, walls=SMALL_ROOM)
    drive.step()
    drive.pilot.explore(True)
    for _ in range(300):
        did.clear()
        drive.step()
        together += [tuple(did)] if len(did) > 1 else []
        seen.update(did)
    assert seen == {"use_map", "_plan_anew", "next", "go_to", "_match", "_tie", "solve"}
    assert len(together) <= 3, together

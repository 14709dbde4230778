"""The gripper holds what is between its paddles, and nothing else."""

import dataclasses
import math
import random

import pytest

from pioneer_control.robots import find_model
from pioneer_control.simulator.hardware.gripper import ParallelGripper
from pioneer_control.simulator.hardware import load_numbers
from pioneer_control.simulator.world.geometry import Block
from pioneer_control.simulator.world import Can, World

MODEL = find_model("p3dx-sh")
GRIPPER = MODEL.gripper
PALM = MODEL.length_front + GRIPPER.paddle_start
BODY = Block(-MODEL.length_rear, MODEL.length_front, -MODEL.width / 2, MODEL.width / 2)
DT = 0.02
PRESSED, FREE = (True, True), (False, False)


class Rig:
    """A gripper on a robot at the origin. The places of cans are given ahead of its palm and left of the middle."""

    def __init__(self, *cans, walls=(), radius=0.033, low=True, **numbers):
        self.world = World("rig", walls=walls, cans=[Can(PALM + x, y, radius) for x, y in cans])
        self.gripper = ParallelGripper(
            GRIPPER, dataclasses.replace(load_numbers().gripper, **numbers), self.world, MODEL.length_front, BODY)
        self.pose = (0.0, 0.0, 0.0)
        if low:
            self.do(lambda gripper: gripper.lift.move_to(0.0))

    def do(self, *actions, seconds=6.0):
        """Give the gripper a command and wait."""
        for action in actions:
            action(self.gripper)
        for _ in range(round(seconds / DT)):
            self.gripper.step(DT, self.pose)
        return self

    def go(self, pose, steps=200):
        """Drive the robot to a place in a straight line. It pushes cans."""
        start = self.pose
        for step in range(1, steps + 1):
            self.pose = tuple(a + (b - a) * step / steps for a, b in zip(start, pose))
            assert self.gripper.make_way(self.pose)
        return self

    @property
    def can(self):
        return self.world.cans[0]


def close(gripper):
    gripper.close()


def opened(gripper):
    gripper.open()


def up(gripper):
    gripper.lift.move_to(1.0)


def down(gripper):
    gripper.lift.move_to(0.0)


def test_at_power_on_open_and_up():
    gripper = Rig(low=False).gripper
    assert gripper.is_open and gripper.lift.is_up and not gripper.is_closed and not gripper.is_low


def test_it_takes_its_time():
    rig = Rig().do(close, seconds=2.4)
    assert rig.gripper.paddle_motion < 0 and not rig.gripper.is_closed
    rig.do(seconds=0.12)
    assert rig.gripper.is_closed and rig.gripper.paddle_motion < 0 and rig.gripper.held_can is None
    rig.do(seconds=rig.gripper.grasp_time)
    assert rig.gripper.is_closed and rig.gripper.paddle_motion == 0 and rig.gripper.held_can is None
    rig.do(up, seconds=3.4)
    assert rig.gripper.lift.motion > 0
    rig.do(seconds=0.2)
    assert rig.gripper.lift.is_up and rig.gripper.height == GRIPPER.lift_height


@pytest.mark.parametrize("x, y", [(0.05, 0.0), (0.034, 0.06), (0.08, -0.07), (0.099, 0.03)])
def test_a_can_between_the_paddles_is_held(x, y):
    rig = Rig((x, y)).do(close)
    assert rig.gripper.held_can is rig.can and rig.can.held_by is rig.gripper
    assert rig.gripper.contacts == PRESSED and rig.gripper.is_closed
    assert rig.gripper.opening == pytest.approx(0.066, abs=1e-6)
    assert rig.can.y == pytest.approx(0.0, abs=1e-4) and rig.can.x == pytest.approx(PALM + x)


@pytest.mark.parametrize("seed", range(50))
def test_wherever_it_stands_between_the_paddles_it_is_held(seed):
    draw = random.Random(seed)
    x, y = draw.uniform(0.0335, GRIPPER.paddle_length), draw.uniform(-1, 1) * (GRIPPER.opening / 2 - 0.034)
    rig = Rig((x, y)).do(close, seconds=3.0).do(up)
    assert rig.gripper.held_can is rig.can and rig.gripper.is_closed and rig.gripper.lift.is_up
    assert any(rig.gripper.beams_broken(rig.pose))


def test_the_paddles_report_closed_after_the_grasp_time():
    seconds = (0.21 - 0.066) / 0.084 + 0.9
    rig = Rig((0.05, 0.0)).do(lambda gripper: setattr(gripper, "grasp_time", 1.0), close, seconds=seconds)
    assert rig.gripper.held and rig.gripper.paddle_motion < 0
    assert rig.do(seconds=0.2).gripper.paddle_motion == 0


@pytest.mark.parametrize("x, y", [(0.12, 0.0), (0.14, 0.0), (0.05, 0.2), (0.3, 0.0)])
def test_a_can_not_between_the_paddles_is_never_held(x, y):
    rig = Rig((x, y)).do(close)
    assert rig.gripper.held_can is None and rig.can.held_by is None and rig.gripper.opening == 0.0
    assert rig.gripper.contacts == PRESSED and rig.gripper.beams_broken(rig.pose) == (False, False)


def test_paddles_that_meet_press_on_each_other_until_they_part():
    rig = Rig().do(close, seconds=2.4)
    assert rig.gripper.contacts == FREE
    rig.do(seconds=0.12)
    assert rig.gripper.contacts == PRESSED and rig.gripper.paddle_motion < 0
    rig.do(seconds=1.0).do(close, lambda gripper: gripper.stop(), up)
    assert rig.gripper.lift.is_up and rig.gripper.contacts == PRESSED and rig.gripper.paddle_motion == 0
    rig.do(opened, seconds=0.0)
    assert rig.gripper.contacts == PRESSED
    rig.do(seconds=DT)
    assert rig.gripper.contacts == FREE and rig.gripper.opening > 0.0


def test_closed_at_power_on_they_press_on_each_other():
    assert Rig(open_at_power_on=False).gripper.contacts == PRESSED


def test_told_to_close_again_they_press_no_longer_and_no_shorter():
    rig = Rig().do(close, seconds=2.54).do(close, seconds=0.1)
    assert rig.gripper.paddle_motion < 0
    assert rig.do(seconds=0.12).gripper.paddle_motion == 0


def test_told_to_close_while_something_keeps_them_closed_they_do_not_open_afterwards():
    rig = Rig().do(close)
    rig.gripper.stuck = True
    rig.do(opened, seconds=1.0).do(close, seconds=0.1)
    rig.gripper.stuck = False
    assert rig.do(seconds=1.0).gripper.is_closed and rig.gripper.contacts == PRESSED


def test_a_can_pushed_out_while_they_close_leaves_them_pressing_on_each_other():
    rig = Rig((0.05, 0.0)).do(close, seconds=0.8)
    rig.world.cans[0].x += 0.3
    rig.do()
    assert rig.gripper.held_can is None and rig.gripper.opening == 0.0
    assert rig.gripper.contacts == PRESSED and rig.gripper.beams_broken(rig.pose) == (False, False)


def test_a_can_that_only_one_paddle_pushes_is_felt_by_that_one():
    rig = Rig((0.05, -0.06)).do(close, seconds=0.9)
    assert rig.gripper.contacts == (False, True)
    rig.world.cans[0].x += 0.3
    assert rig.do(seconds=DT).gripper.contacts == FREE


def test_raised_paddles_close_above_a_can():
    rig = Rig((0.05, 0.0), low=False).do(close)
    assert rig.gripper.held_can is None and (rig.can.x, rig.can.y) == (PALM + 0.05, 0.0)


def test_closed_paddles_lowered_on_a_can_knock_it_aside():
    rig = Rig((0.05, 0.005), low=False).do(close).do(down)
    assert rig.gripper.lift.is_down and rig.gripper.held_can is None
    assert not any(rig.gripper.beams_broken(rig.pose))
    for block in rig.gripper.blocks_for(rig.can.radius):
        assert block.push(rig.can.x, rig.can.y, rig.can.radius) is None
    assert rig.do(opened).do(close).gripper.held_can is None


def test_a_held_can_is_carried_and_put_down_where_the_robot_stands():
    rig = Rig((0.05, 0.02)).do(close).do(up).go((1.0, 2.0, math.pi / 2))
    assert rig.can.x == pytest.approx(1.0, abs=1e-4) and rig.can.y == pytest.approx(2.0 + PALM + 0.05)
    rig.do(down).do(opened)
    assert rig.gripper.held_can is None and rig.can.held_by is None
    place = (rig.can.x, rig.can.y)
    rig.go((1.0, 1.0, math.pi / 2))
    assert (rig.can.x, rig.can.y) == place


def test_closing_again_on_what_is_held_changes_nothing():
    rig = Rig((0.05, 0.0)).do(close).do(close)
    assert rig.gripper.held_can is rig.can and rig.gripper.paddle_motion == 0


def test_stopped_halfway_nothing_is_held():
    rig = Rig((0.05, 0.08)).do(close, seconds=1.0)
    assert rig.gripper.contacts == (True, False)
    rig.do(lambda gripper: gripper.stop())
    assert rig.gripper.held_can is None and rig.gripper.contacts == FREE
    assert not rig.gripper.is_open and not rig.gripper.is_closed


def test_driving_on_takes_a_can_between_open_paddles_and_pushes_it_with_the_palm():
    rig = Rig((0.5, 0.03)).go((0.6, 0.0, 0.0))
    assert rig.can.x == pytest.approx(0.6 + PALM + 0.033, abs=1e-5)
    assert rig.gripper.beams_broken(rig.pose) == (True, False)
    assert rig.do(close).gripper.held_can is rig.can


def test_closed_paddles_push_a_can_ahead():
    rig = Rig((0.5, 0.0)).do(close).go((0.6, 0.0, 0.0))
    assert rig.can.x == pytest.approx(0.6 + PALM + 0.1 + 0.033, abs=1e-5)


def test_one_can_pushes_another():
    rig = Rig((0.2, 0.0), (0.3, 0.0)).do(close).go((0.3, 0.0, 0.0))
    first, second = rig.world.cans
    assert second.x - first.x == pytest.approx(0.066, abs=1e-5)


def test_a_can_against_a_wall_jams_and_stays():
    wall = (PALM + 0.3, -2.0, PALM + 0.3, 2.0)
    rig = Rig((0.2, 0.0), walls=[wall]).do(close)
    for step in range(400):
        pose = (step * 0.001, 0.0, 0.0)
        if not rig.gripper.make_way(pose):
            break
        rig.pose = pose
    assert rig.pose[0] == pytest.approx(0.3 - 0.1 - 0.066, abs=0.0015)
    assert rig.world.clearance(rig.can.x, rig.can.y) > 0.032


def test_a_can_slides_along_a_wall():
    wall = (-5.0, 0.04, 5.0, 0.04)
    rig = Rig((0.2, 0.0), walls=[wall]).do(close)
    rig.go((0.5, -0.06, -0.1))
    assert rig.world.clearance(rig.can.x, rig.can.y) > 0.033 - 1e-5


@pytest.mark.parametrize("x, beams", [
    (0.034, (True, False)),
    (0.055, (True, True)),
    (0.099, (False, True)),
    (0.14, (False, False)),
])
def test_beams(x, beams):
    rig = Rig((x, 0.0))
    assert rig.gripper.beams_broken(rig.pose) == beams


def test_raised_paddles_see_only_what_they_hold():
    rig = Rig((0.05, 0.0), (0.5, 0.0))
    rig.do(up)
    assert rig.gripper.beams_broken(rig.pose) == (False, False)
    rig.do(down).do(close).do(up)
    assert rig.gripper.beams_broken(rig.pose) == (True, True)


def test_two_cans_side_by_side_are_held_together():
    rig = Rig((0.06, 0.04), (0.06, -0.04)).do(close)
    assert len(rig.gripper.held) == 2 and rig.gripper.opening == pytest.approx(0.132, abs=0.004)


@pytest.mark.parametrize("radius, held", [(0.009, False), (0.011, True), (0.099, True), (0.1015, False)])
def test_only_objects_of_the_right_width_are_held(radius, held):
    rig = Rig((0.099, 0.0), radius=radius).do(close)
    assert bool(rig.gripper.held) is held


def test_carry_moves_the_lift_relative_and_stops_at_the_ends():
    rig = Rig().do(lambda gripper: gripper.lift.move_for(1.0))
    assert rig.gripper.height == pytest.approx(0.02)
    assert rig.do(lambda gripper: gripper.lift.move_for(-0.5)).gripper.height == pytest.approx(0.01)
    assert rig.do(lambda gripper: gripper.lift.move_for(99.0)).gripper.lift.is_up


def test_lift_stop_leaves_it_in_between():
    rig = Rig().do(up, seconds=1.0).do(lambda gripper: gripper.lift.stop())
    assert not rig.gripper.lift.is_up and not rig.gripper.lift.is_down and rig.gripper.lift.motion == 0


def test_whatever_it_is_told_it_holds_only_cans_between_its_paddles():
    draw = random.Random(5)
    for _ in range(40):
        rig = Rig(*[(draw.uniform(0.034, 0.3), draw.uniform(-0.2, 0.2)) for _ in range(3)])
        for _ in range(12):
            action = draw.choice([close, close, opened, up, down, lambda gripper: gripper.stop()])
            rig.do(action, seconds=draw.uniform(0.1, 4.0))
            for can in rig.gripper.held:
                x, y = can.x - PALM, can.y
                assert 0.0 < x <= GRIPPER.paddle_length and abs(y) + can.radius <= rig.gripper.opening / 2 + 2e-3
            assert (bool(rig.gripper.held) or rig.gripper.opening == 0.0) == (rig.gripper.contacts == PRESSED)
            if rig.gripper.contacts == PRESSED and (rig.gripper.lift.is_up or rig.gripper.lift.is_down):
                assert bool(rig.gripper.held) == any(rig.gripper.beams_broken(rig.pose)), "contacts and a beam: held"

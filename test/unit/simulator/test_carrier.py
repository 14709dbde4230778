"""Robots and cans that somebody carries to other places."""

import math

import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.carrier import Carrier
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import Can, World
from pioneer_control.simulator.world.poses import box_corners, closed, compose

MODEL = find_model("p3dx-sh")
OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
BOX = box_corners((6.0, 0.0), (2.0, 2.0), 0.0)


def hall(cans=(), starts=((0.0, 0.0, 0.0), (0.0, 2.0, 0.0))):
    """Return two robots with open sessions in a hall, and a carrier."""
    walls = [(-3.0, -3.0, -3.0, 5.0), *closed(BOX)]
    world = World("hall", walls, posts=[(3.0, 3.0, 0.2)], cans=cans, starts=starts, boxes=[BOX])
    simulation = Simulation(world)
    for _ in starts:
        simulation.add(MODEL, noise=0.0).receive(OPEN)
    return simulation, Carrier(simulation)


def send(simulation, number, name, *values):
    simulation.robots[number - 1].receive(p2os.encode_command(name, *values))


def wait(simulation, seconds):
    """Let time pass while every client stays in touch."""
    for _ in range(round(seconds * 10)):
        for number in range(1, len(simulation.robots) + 1):
            send(simulation, number, "PULSE")
        simulation.advance(0.1)


def driven():
    """Return two robots of which the first has driven a bend and still drives, and a carrier."""
    simulation, carrier = hall()
    send(simulation, 1, "VEL", 300)
    send(simulation, 1, "RVEL", 10)
    wait(simulation, 2.0)
    return simulation, carrier


def test_a_carried_robot_stands_and_its_odometry_goes_on():
    simulation, carrier = driven()
    robot = simulation.robots[0]
    odometry = robot.hardware.odometry.pose
    assert robot.velocity[0] > 0.0 and odometry[0] > 0.3
    carrier.put(1, (1.0, -1.0, 2.0))
    assert robot.true_pose == (1.0, -1.0, 2.0) and robot.velocity == (0.0, 0.0)
    assert robot.hardware.odometry.pose == odometry
    assert compose(robot.hardware.odometry.origin, odometry) == pytest.approx((1.0, -1.0, 2.0))
    wait(simulation, 1.0)
    assert robot.true_pose == (1.0, -1.0, 2.0), "no set point is left"
    assert robot.motors_enabled
    send(simulation, 1, "MOVE", 500)
    wait(simulation, 4.0)
    x, y, heading = robot.true_pose
    assert (x, y) == pytest.approx((1.0 + 0.5 * math.cos(2.0), -1.0 + 0.5 * math.sin(2.0)), abs=1e-3)
    assert compose(robot.hardware.odometry.origin, robot.hardware.odometry.pose) == pytest.approx(robot.true_pose)


def test_the_way_to_a_place_set_before_is_forgotten():
    simulation, carrier = hall()
    send(simulation, 1, "MOVE", 3000)
    wait(simulation, 1.0)
    carrier.put(1, (0.0, -1.0, 0.0))
    wait(simulation, 1.0)
    assert simulation.robots[0].true_pose == (0.0, -1.0, 0.0)


@pytest.mark.parametrize("pose, obstacle", [
    ((-2.9, 0.0, 0.0), "a wall or a post"),
    ((3.0, 3.0, 0.0), "a wall or a post"),
    ((6.0, 0.0, 0.0), "a box"),                     # all of the robot inside
    ((5.0, 0.0, 0.0), "a wall or a post"),          # the side of the box
    ((0.1, 1.9, 1.0), "robot 2"),
    ((1.0, -2.0, 0.0), "can 2"),
])
def test_where_something_stands_a_robot_cannot_be_put(pose, obstacle):
    simulation, carrier = hall(cans=[Can(2.0, 0.0), Can(1.1, -2.0)])
    send(simulation, 1, "VEL", 100)
    wait(simulation, 1.0)
    robot = simulation.robots[0]
    before = robot.true_pose, robot.velocity, robot.hardware.odometry.origin
    with pytest.raises(ParameterError) as error:
        carrier.put(1, pose)
    assert str(error.value) == "robot 1 cannot stand at x %g, y %g, heading %g: in its way is %s" % (*pose, obstacle)
    assert (robot.true_pose, robot.velocity, robot.hardware.odometry.origin) == before
    assert (simulation.world.cans[1].x, simulation.world.cans[1].y) == (1.1, -2.0)


def test_beside_something_a_robot_can_be_put():
    simulation, carrier = hall(cans=[Can(1.0, -2.0)])
    for pose in ((-2.5, 0.0, math.pi / 2), (4.5, 0.0, math.pi / 2), (0.0, 1.5, 0.0), (0.4, -2.0, 0.0)):
        carrier.put(1, pose)
        assert simulation.robots[0].true_pose == pose
    assert (simulation.world.cans[0].x, simulation.world.cans[0].y) == (1.0, -2.0)


def held_can():
    """Return two robots of which the first holds a can, and a carrier."""
    simulation, carrier = hall(cans=[Can(0.3, 0.0), Can(2.0, 2.0)])
    for action in (5, 2):   # lower the paddles, and close them
        send(simulation, 1, "GRIPPER", action)
        wait(simulation, 4.0)
    assert simulation.robots[0].gripper.held == simulation.world.cans[:1]
    return simulation, carrier


def test_a_held_can_comes_along():
    simulation, carrier = held_can()
    can = simulation.world.cans[0]
    ahead = can.x
    carrier.put(1, (1.0, -1.0, math.pi / 2))
    assert (can.x, can.y) == pytest.approx((1.0, -1.0 + ahead)) and can.held_by is simulation.robots[0].gripper
    carrier.reset(1)
    assert (can.x, can.y) == pytest.approx((ahead, 0.0)) and can.held_by is simulation.robots[0].gripper


def test_reset_of_one_leaves_all_others():
    simulation, carrier = driven()
    send(simulation, 2, "VEL", 200)
    wait(simulation, 1.0)
    second = simulation.robots[1].true_pose
    carrier.reset(1)
    assert simulation.robots[0].true_pose == (0.0, 0.0, 0.0)
    assert simulation.robots[1].true_pose == second and simulation.robots[1].velocity[0] > 0.0


def test_reset_of_one_moves_nothing_else_out_of_its_way():
    simulation, carrier = hall(cans=[Can(2.0, 0.0)])
    carrier.put(1, (2.0, -2.0, 0.0))
    carrier.put(2, (0.0, 0.1, 1.0))
    simulation.world.cans[0].x = 0.1
    with pytest.raises(ParameterError, match="robot 1 cannot stand where it began: in its way is robot 2, can 1"):
        carrier.reset(1)
    assert simulation.robots[0].true_pose == (2.0, -2.0, 0.0)


def test_reset_of_all_puts_everything_back():
    simulation, carrier = held_can()
    cans = list(simulation.world.cans)
    cans[1].x = 1.0
    carrier.put(1, (-1.0, -1.0, 0.0))
    carrier.put(2, (0.0, 0.0, 1.0))         # where the first one began
    carrier.put(1, (0.0, 2.0, -1.0))        # and the other way round
    carrier.reset_all()
    assert [robot.true_pose for robot in simulation.robots] == [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)]
    assert simulation.world.cans == cans
    assert [(can.x, can.y, can.held_by) for can in cans] == [(0.3, 0.0, None), (2.0, 2.0, None)]
    assert simulation.robots[0].gripper.held == []
    wait(simulation, 1.0)
    assert [robot.true_pose for robot in simulation.robots] == [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)]


def test_a_contact_after_the_robot_was_carried_is_a_new_one():
    simulation, carrier = hall()
    robot = simulation.robots[0]
    carrier.put(1, (-2.6, -1.0, math.pi))
    for count in (1, 2):
        send(simulation, 1, "VEL", 200)
        wait(simulation, 2.0)
        assert robot.contacts == count and robot.hardware.body.blocked
        carrier.put(1, robot.true_pose)
        assert not robot.hardware.body.blocked

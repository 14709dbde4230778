"""Several robots in one world and one time. They see each other, stop each other, and do not depend on how time is
split.
"""

import dataclasses
import math
import random

import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.world.crowd import Crowd
from pioneer_control.simulator.world import Can, World, load_world
from pioneer_control.simulator.hardware import load_numbers
from pioneer_control.simulator.simulation import Simulation, simulate

MODEL = find_model("p3dx-sh")
OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
TWO_STARTS = ((0.0, 0.0, 0.0), (2.0, 0.0, math.pi))


def sips(sent, decoder=None):
    """Return the SIPs in the bytes that a robot sent."""
    packets = [p2os.decode_packet(frame) for frame in (decoder or p2os.FrameDecoder()).feed(sent)]
    return [packet for packet in packets if isinstance(packet, p2os.Sip)]


def two_robots(world=None, **options):
    simulation = Simulation(world or World("two", starts=TWO_STARTS))
    for _ in range(2):
        simulation.add(MODEL, noise=0.0, gripper=False, **options).receive(OPEN)
    return simulation


def ranges(sent):
    """Return the last range (mm) of every transducer in some bytes."""
    return {reading.number: reading.range_units for sip in sips(sent) for reading in sip.sonar}


def test_robots_stand_on_the_starts_in_turn():
    assert [robot.true_pose for robot in two_robots().robots] == list(TWO_STARTS)


def test_robots_see_each_other():
    simulation = two_robots()
    sent = simulation.advance(1.0)
    gap = 2000.0 - 2 * 1000.0 * max(transducer.x for transducer in MODEL.sonar if abs(transducer.heading) < 0.2)
    nose = {number: distance for number, distance in ranges(sent[0]).items() if number in (3, 4)}
    foremost = max(transducer.x for transducer in MODEL.sonar if abs(transducer.heading) < 0.2)
    beyond_sensor = 1000.0 * (MODEL.length_front - foremost)
    assert nose == pytest.approx({3: gap - beyond_sensor, 4: gap - beyond_sensor}, abs=2.0)
    assert ranges(sent[0]) == ranges(sent[1])     # they face each other


def test_a_robot_alone_sees_nothing_of_itself():
    simulation = Simulation(World("alone"))
    robot = simulation.add(MODEL, noise=0.0)
    robot.receive(OPEN)
    assert set(ranges(simulation.advance(1.0)[0]).values()) == {5000}


def test_a_robot_is_stopped_by_another_and_not_by_where_it_was():
    simulation = two_robots()
    first, second = simulation.robots
    for _ in range(50):
        first.receive(p2os.encode_command("VEL", 400))
        simulation.advance(0.1)
    touching = 2.0 - 2 * MODEL.length_front
    assert touching - 0.02 < first.true_pose[0] <= touching and first.contacts == 1 and second.contacts == 0
    for _ in range(30):
        first.receive(p2os.encode_command("VEL", 200))
        second.receive(p2os.encode_command("VEL", -400))
        simulation.advance(0.1)
    assert first.true_pose[0] > touching + 0.2


def test_a_robot_cannot_start_in_another():
    simulation = two_robots()
    with pytest.raises(ParameterError, match="another robot at x 0.3, y 0"):
        simulation.add(MODEL, (0.3, 0.0, 1.0))
    assert len(simulation.robots) == 2
    simulation.add(MODEL, (0.3, 2.0, 1.0))


def wander(simulation, seconds, slices, seed):
    """Return all bytes of some robots that get random commands ten times a second, while time passes in `slices`
    pieces.
    """
    rng = random.Random(seed)
    sent = [b""] * len(simulation.robots)
    for _ in range(round(seconds * 10)):
        for robot in simulation.robots:
            robot.receive(p2os.encode_command(rng.choice(["VEL", "RVEL"]), rng.randint(-100, 300)))
        for share in slices:
            sent = [before + now for before, now in zip(sent, simulation.advance(0.1 * share))]
    return sent


@pytest.mark.parametrize("slices", [[0.5, 0.5], [0.13, 0.29, 0.58], [0.05] * 20])
def test_the_same_bytes_however_time_is_split(slices):
    def simulation():
        robots = Simulation(load_world("cans"))
        x, y, heading = robots.world.starts[0]
        robots.add(MODEL, seed=1)
        robots.advance(0.007)             # the second one takes its steps between those of the first
        robots.add(MODEL, (x, y - 1.0, heading + 2.0), seed=2)
        for robot in robots.robots:
            robot.receive(OPEN)
        return robots
    assert wander(simulation(), 20.0, slices, 5) == wander(simulation(), 20.0, [1.0], 5)


def test_time_passes_without_robots():
    simulation = Simulation(World("nobody"))
    assert simulation.advance(1.0) == [] and simulation.clock.now_us == 1000000


def test_a_can_between_two_robots_is_jammed():
    simulation = two_robots(World("can between", starts=TWO_STARTS, cans=[Can(1.0, 0.0)]))
    first, second = simulation.robots
    for _ in range(60):
        first.receive(p2os.encode_command("VEL", 300))
        simulation.advance(0.1)
    can = simulation.world.cans[0]
    gap = second.true_pose[0] - first.true_pose[0] - 2 * MODEL.length_front
    assert 2 * can.radius - 1e-4 <= gap < 2 * can.radius + 0.02 and first.contacts == 0
    assert can.x == pytest.approx(first.true_pose[0] + MODEL.length_front + gap / 2, abs=0.02)
    assert abs(second.true_pose[0] - 2.0) < 1e-9


class Standing:
    """The part of a body that a crowd uses."""

    def __init__(self, pose, reach):
        self.pose, self.reach = pose, reach


@pytest.mark.parametrize("seed", range(5))
def test_a_crowd_knows_who_is_near_wherever_they_go(seed):
    rng, crowd, bodies, listed = random.Random(seed), Crowd(), [], 0
    for number in range(40):
        pose = (rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0), 0.0)
        body = Standing(pose, reach=0.2 + 0.02 * number)     # larger and larger
        bodies.append(body)
        crowd.enter(body)
        for each in bodies:
            each.pose = each.pose[0] + rng.uniform(-1.0, 1.0), each.pose[1] + rng.uniform(-1.0, 1.0), 0.0
            crowd.moved(each)
        x, y, reach = rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0), rng.choice([0.1, crowd.reach, 1.0, 5.0])
        near = crowd.near(x, y, reach)
        away = [math.hypot(each.pose[0] - x, each.pose[1] - y) for each in bodies]
        assert all(each in near for each, distance in zip(bodies, away) if distance <= reach + each.reach)
        listed += len(near)
    assert listed < 40 * 20, "not simply all of them"


def test_a_body_alone_has_nobody_near_but_others_find_it_where_it_went():
    crowd, body = Crowd(), Standing((0.0, 0.0, 0.0), reach=0.3)
    crowd.enter(body)
    body.pose = (50.0, 0.0, 0.0)
    crowd.moved(body)
    assert crowd.near(50.0, 0.0, 1.0, body) == []
    assert crowd.near(50.0, 0.0, 1.0) == [body] and crowd.near(0.0, 0.0, 1.0) == []
    other = Standing((50.5, 0.0, 0.0), reach=0.3)
    assert crowd.near(50.5, 0.0, 1.0, other) == [body], "also one that has not entered"
    crowd.enter(other)
    assert other in crowd.near(50.0, 0.0, 1.0, body)


def test_a_robot_larger_than_any_of_ours_is_minded_from_afar():
    large = dataclasses.replace(MODEL, length_front=3.0, length_rear=3.0)
    simulation = Simulation(World("two", starts=((0.0, 0.0, 0.0), (4.5, 0.0, math.pi / 2), (4.5, 5.0, 0.0))))
    small, _ = simulation.add(MODEL, noise=0.0, gripper=False), simulation.add(large, noise=0.0, gripper=False)
    simulation.add(MODEL, (-3.0, 2.8, -math.pi / 2), gripper=False)
    small.receive(OPEN)
    for _ in range(300):
        small.receive(p2os.encode_command("VEL", 300))
        simulation.advance(0.1)
    assert small.contacts == 1
    assert small.true_pose[0] == pytest.approx(4.5 - large.width / 2 - MODEL.length_front, abs=0.02)
    with pytest.raises(ParameterError, match="another robot"):
        simulation.add(MODEL, (4.5, 2.9, 0.0))


@pytest.mark.parametrize("count, name, called", [
    (1, None, ["sim_0001"]),
    (1, "Fred", ["Fred"]),
    (3, None, ["sim_0001", "sim_0002", "sim_0003"]),
    (2, "Fred", ["Fred_0001", "Fred_0002"]),
])
def test_no_two_robots_have_one_name(count, name, called):
    simulation = simulate(load_world("empty"), find_model("p3dx-sh"), count, name, 0)
    assert [robot.name for robot in simulation.robots] == called


def test_real_robots_each_have_wheels_of_their_own(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("wheels: {slip: 0.0}\n")
    simulation = simulate(load_world("office"), MODEL, 3, None, 5, numbers_file=str(path), real=True)
    wheels = [robot.numbers.wheels for robot in simulation.robots]
    assert len({each.larger for each in wheels}) == 3 and {each.slip for each in wheels} == {0.0}
    assert wheels[1].larger == load_numbers(None, 6).wheels.larger
    exact = simulate(load_world("office"), MODEL, 2, None, 5)
    assert [robot.numbers for robot in exact.robots] == 2 * [load_numbers()]

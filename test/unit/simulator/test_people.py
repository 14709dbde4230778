"""People who walk in a world: their ways, what they do at robots, and how touches are counted."""

import math
import random

import numpy as np
import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError, WorldError
from pioneer_control.robots import find_model
from pioneer_control.simulator.carrier import Carrier
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World, load_world
from pioneer_control.simulator.world.generated import with_walkers
from pioneer_control.simulator.world.people import LOOKS_AHEAD, PATIENCE, RADIUS, Footways
from pioneer_control.simulator.world.world import Walk

MODEL = find_model("p3dx-sh")
OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
TO_AND_FRO = Walk(path=((3.0, 0.0), (-3.0, 0.0)), speed=0.5, pause=1.0)


def hall(*walks, starts=((0.0, 2.0, 0.0),)):
    """Return a simulation of robots without grippers in a hall 8 by 6 m, in which people walk."""
    walls = [(-4.0, -3.0, 4.0, -3.0), (4.0, -3.0, 4.0, 3.0), (4.0, 3.0, -4.0, 3.0), (-4.0, 3.0, -4.0, -3.0)]
    simulation = Simulation(World("hall", walls, starts=starts, walks=walks))
    for _ in starts:
        simulation.add(MODEL, gripper=False, noise=0.0).receive(OPEN)
    return simulation


def wait(simulation, seconds, *command):
    """Let time pass while the client of the first robot says the same again and again. Return the person's places."""
    places = []
    for _ in range(round(seconds * 10)):
        simulation.robots[0].receive(p2os.encode_command(*(command or ("PULSE",))))
        simulation.advance(0.1)
        places.append(simulation.people[0].pose[:2])
    return places


def test_a_person_walks_to_and_fro_with_a_pause_at_each_end():
    simulation = hall(TO_AND_FRO)
    places = wait(simulation, 28.0)
    assert places[9] == pytest.approx((2.5, 0.0), abs=0.02) and places[119] == pytest.approx((-3.0, 0.0), abs=0.02)
    assert places[125] == places[121]                                   # 12 s of walking, 1 s of rest
    assert places[139] == pytest.approx((-2.5, 0.0), abs=0.05) and places[255] == pytest.approx((3.0, 0.0), abs=0.05)


def test_a_person_follows_the_corners_of_a_path():
    simulation = hall(Walk(path=((2.0, 0.0), (3.0, 0.0), (3.0, -2.0)), speed=1.0, pause=0.0))
    places = wait(simulation, 6.0)
    assert places[4] == pytest.approx((2.5, 0.0), abs=0.03) and places[19] == pytest.approx((3.0, -1.0), abs=0.03)
    assert places[39] == pytest.approx((3.0, -1.0), abs=0.05) and places[54] == pytest.approx((2.5, 0.0), abs=0.05)


def test_sonar_hears_a_person():
    simulation = hall(Walk(path=((3.0, 0.0), (1.5, 0.0)), speed=0.01), starts=((0.0, 0.0, 0.0),))
    sips = [p2os.decode_packet(frame) for frame in p2os.FrameDecoder().feed(simulation.advance(1.0)[0])]
    ranges = {each.number: each.range_units for sip in sips if isinstance(sip, p2os.Sip) for each in sip.sonar}
    ahead = MODEL.sonar[3]      # looks 10 degrees to the left
    nearest = math.hypot(3.0 - ahead.x, ahead.y) - RADIUS
    assert ranges[3] / 1000.0 == pytest.approx(nearest, abs=0.02)


def test_a_person_who_looks_waits_before_a_robot_then_goes_back():
    simulation = hall(TO_AND_FRO, starts=((0.0, 0.0, math.pi / 2.0),))
    places = wait(simulation, 15.0)
    nearest = min(x for x, _ in places)
    edge = MODEL.width / 2.0 + RADIUS
    assert edge < nearest < edge + LOOKS_AHEAD + 0.05
    assert places.count(places[places.index(min(places))]) >= PATIENCE * 10 - 1
    assert places[-1][0] > nearest + 0.8                                # went back
    assert simulation.robots[0].contacts == simulation.robots[0].touched_by_people == 0


def test_a_blind_person_touches_a_standing_robot_once_and_cannot_pass():
    simulation = hall(TO_AND_FRO._replace(blind=True), starts=((0.0, 0.0, math.pi / 2.0),))
    places = wait(simulation, 9.0)
    robot = simulation.robots[0]
    assert min(x for x, _ in places) == pytest.approx(MODEL.width / 2.0 + RADIUS, abs=0.02)
    assert (robot.contacts, robot.touched_by_people) == (0, 1)
    assert robot.true_pose[:2] == (0.0, 0.0)
    wait(simulation, 20.0)      # back to the other end, and here again
    assert (robot.contacts, robot.touched_by_people) == (0, 2)
    robot.hardware.body.begin_count()
    assert robot.touched_by_people == 0


def test_a_robot_that_drives_into_a_person_has_a_contact_and_stops():
    simulation = hall(Walk(path=((2.0, 0.0), (2.0, 0.1)), speed=0.01), starts=((0.0, 0.0, 0.0),))
    wait(simulation, 8.0, "VEL", 300)
    robot = simulation.robots[0]
    assert robot.true_pose[0] == pytest.approx(2.0 - RADIUS - MODEL.length_front, abs=0.04)
    assert robot.contacts == 1 and robot.touched_by_people == 0


def test_a_blind_person_who_walks_into_a_moving_robot_is_a_contact():
    simulation = hall(TO_AND_FRO._replace(blind=True), starts=((0.0, 0.0, math.pi / 2.0),))
    wait(simulation, 6.5, "RVEL", 1)    # it turns all the time, slowly
    assert simulation.robots[0].contacts >= 1 and simulation.robots[0].touched_by_people == 0


def test_nobody_is_carried_onto_a_person():
    simulation = hall(TO_AND_FRO)
    with pytest.raises(ParameterError, match="in its way is a person"):
        Carrier(simulation).put(1, (2.9, 0.0, 0.0))
    assert Carrier(simulation).put(1, (1.0, 0.0, 0.0)) is None


def test_random_walkers_get_about_and_touch_neither_walls_nor_robots():
    world = with_walkers(load_world("office"), 3, 5)
    simulation = Simulation(world)
    robot = simulation.add(MODEL)
    seen = []
    for _ in range(900):
        simulation.advance(0.1)
        seen.append([person.pose[:2] for person in simulation.people])
    assert min(world.clearance(x, y) for places in seen[::5] for x, y in places) >= RADIUS
    assert all(np.ptp([places[each] for places in seen], axis=0).max() > 2.0 for each in range(3))
    assert robot.contacts == robot.touched_by_people == 0
    steps = [math.dist(before[0], after[0]) for before, after in zip(seen, seen[1:])]
    assert max(steps) == pytest.approx(0.05, abs=0.001)


def walked(seed, parts):
    simulation = Simulation(with_walkers(load_world("offices-7"), 2, seed))
    simulation.add(MODEL, seed=1)
    for _ in range(200):
        for _ in range(parts):
            simulation.advance(0.1 / parts)
    return [person.pose for person in simulation.people]


def test_same_seed_same_ways_however_time_is_split():
    assert walked(1, 1) == walked(1, 7) != walked(2, 1)


def test_a_way_leads_round_walls():
    walls = [(-4.0, -3.0, 4.0, -3.0), (4.0, -3.0, 4.0, 3.0), (4.0, 3.0, -4.0, 3.0), (-4.0, 3.0, -4.0, -3.0),
             (0.0, -3.0, 0.0, 1.5)]
    world = World("two rooms", walls, starts=[(-2.0, 0.0, 0.0)])
    way = [(-2.0, 0.0), *Footways(world).way((-2.0, 0.0), (2.0, 0.0))]
    assert way[-1] == pytest.approx((2.0, 0.0), abs=0.1) and 3 <= len(way) <= 6
    for (x1, y1), (x2, y2) in zip(way, way[1:]):
        assert min(world.clearance(x1 + (x2 - x1) * share, y1 + (y2 - y1) * share)
                   for share in np.linspace(0.0, 1.0, 50)) >= RADIUS
    assert Footways(world).way((-2.0, 0.0), (-2.0, 0.0)) == [(-2.0, 0.0)]


def test_random_walkers_begin_away_from_the_starts_of_robots():
    world = load_world("office")
    rng = random.Random(1)
    places = [Footways(world).first_place(rng) for _ in range(5)]
    assert all(math.dist(place, start[:2]) >= 1.5 for place in places for start in world.starts)


def test_a_path_through_a_wall_is_refused():
    with pytest.raises(WorldError, match="world hall: walker 2 would touch a wall or a post at x 3.80, y 0.00: a person"
                                         " needs 0.25 m on each side"):
        hall(TO_AND_FRO, Walk(path=((0.0, 0.0), (4.5, 0.0))))


def test_where_nobody_can_walk():
    cell = [(-0.4, -0.4, 0.4, -0.4), (0.4, -0.4, 0.4, 0.4), (0.4, 0.4, -0.4, 0.4), (-0.4, 0.4, -0.4, -0.4)]
    with pytest.raises(WorldError, match="nobody can walk from a start"):
        Simulation(World("cell", [tuple(0.7 * end for end in wall) for wall in cell], walks=[Walk(seed=1)]))

"""World and robots as plain values, for other programs."""

import dataclasses
import json
import math

import pytest

from pioneer_control import p2os
from pioneer_control.robots import find_model
from pioneer_control.simulator.carrier import Carrier
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.line import LineSimulation, fault_of
from pioneer_control.simulator.line.pace import Pace
from pioneer_control.simulator.simulation import Simulation, simulate
from pioneer_control.simulator.tasks import Referee
from pioneer_control.simulator.truth.state import line_of, marked_place, truth_of, world_of
from pioneer_control.simulator.world import Can, World, load_world
from pioneer_control.simulator.world.poses import compose
from pioneer_control.simulator.world.world import Furniture, MarkedPlace, Walk

OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])


PLACES = [MarkedPlace("mat", 0.0, 0.0, (1.0, 0.4)), MarkedPlace("hole", 2.0, 2.0, (1.0,))]


class Stage:
    """A robot with a gripper and one without, 2 m ahead of it, and a can before each."""

    def __init__(self):
        world = World("stage", [(5.0, -1.0, 5.0, 1.0)], cans=[Can(0.3, 0.0), Can(2.5, 1.0)],
                      starts=[(0.0, 0.0, 0.0), (2.0, 0.0, 7.0)], places=PLACES)
        self.simulation = Simulation(world)
        for subtype in ("p3dx-sh", "amigo-sh"):
            self.simulation.add(find_model(subtype), noise=0.0).receive(OPEN)
        self.lines = LineSimulation(self.simulation)
        self.pace, self.referee = Pace(2.0, 0), Referee(self.simulation)

    def do(self, number, *command, seconds=0.0):
        """Send a command to a robot, and let time pass while the clients stay in touch."""
        self.lines.send(number - 1, p2os.encode_command(*command))
        for _ in range(round(seconds * 10)):
            for robot in (0, 1):
                self.lines.send(robot, p2os.encode_command("PULSE"))
            self.lines.advance(0.1)

    @property
    def truth(self):
        return truth_of(self.simulation, self.lines, self.pace, self.referee)["truth"]


def test_the_world_is_told_as_it_is():
    world = load_world("office")
    simulation = simulate(world, find_model("p3dx-sh"), 5, None, 0)
    urls = ["socket://127.0.0.1:%d" % (8101 + number) for number in range(4)] + [None]
    told = json.loads(line_of(world_of(simulation, urls, Referee(simulation))))["world"]
    assert (told["name"], told["bounds"]) == ("office", [0.0, 0.0, 20.0, 12.0])
    assert len(told["walls"]) == 160 and told["walls"][0] == [0.0, 0.0, 20.0, 0.0]
    assert len(told["posts"]) == 15 and told["posts"][0] == [1.2, 1.5, 0.15]
    assert len(told["boxes"]) == 35 and told["boxes"][0] == [[0.2, 0.0], [1.8, 0.0], [1.8, 0.8], [0.2, 0.8]]
    assert told["cans"] == [[0.033, 0.115]] * 8
    assert len(told["starts"]) == 4 and told["starts"][1] == [18.6, 6.0, round(math.pi, 4)]
    assert told["docks"] == [[11.4, 5.55, round(-math.pi / 2, 4)]]
    assert told["goals"]["kitchen"] == [3.7, 10.4, round(math.pi / 2, 4)]
    assert [robot["url"] for robot in told["robots"]] == urls
    assert (told["robots"][0]["name"], told["robots"][4]["name"]) == ("sim_0001", "sim_0005")
    assert {robot["model"] for robot in told["robots"]} == {"p3dx-sh"}
    assert told["robots"][0]["start"] == [1.0, 6.0, 0.0] and len(told["robots"][0]["outline"]) == 8


def test_places_are_told_and_headings_are_wrapped():
    stage = Stage()
    told = json.loads(line_of(world_of(stage.simulation, [None, None], stage.referee)))["world"]
    assert told["starts"][1][2] == told["robots"][1]["start"][2] == round(7.0 - 2.0 * math.pi, 4)
    assert told["places"] == [{"name": "mat", "centre": [0.0, 0.0], "size": [1.0, 0.4]},
                              {"name": "hole", "centre": [2.0, 2.0], "diameter": 1.0}]


def test_robots_at_rest():
    stage = Stage()
    assert stage.truth == {
        "time": 0.0, "speed": 2.0, "paused": False, "late_answers": None,
        "robots": [(0.0, 0.0, 0.0, 0.0, 0.0, False), (2.0, 0.0, pytest.approx(7.0 - 2.0 * math.pi), 0.0, 0.0, False)],
        "origins": [(0.0, 0.0, 0.0), (2.0, 0.0, pytest.approx(7.0 - 2.0 * math.pi))],
        "grippers": [[0.21, 0.07], None], "stop_buttons": [False, False],
        "contacts": [0, 0], "touched_by_people": [0, 0], "people": [], "driven": [0.0, 0.0],
        "cans": [(0.3, 0.0, 0.0, -1, 1), (2.5, 1.0, 0.0, -1, -1)], "faults": [], "task": None,
    }


def test_speed_and_pause_are_told():
    stage = Stage()
    stage.pace.speed, stage.pace.paused = 0.5, True
    assert (stage.truth["speed"], stage.truth["paused"]) == (0.5, True)


def test_a_robot_that_drives():
    stage = Stage()
    stage.do(2, "VEL", 200, seconds=1.0)
    stage.do(2, "RVEL", 20, seconds=1.0)
    x, y, heading, linear, angular, touching = stage.truth["robots"][1]
    assert math.hypot(x - 2.0, y) > 0.2 and (linear, angular) == pytest.approx((0.2, math.radians(20)))
    assert stage.truth["time"] == pytest.approx(2.0) and not touching
    robot = stage.simulation.robots[1]
    assert compose(stage.truth["origins"][1], robot.hardware.odometry.pose)[:2] == pytest.approx((x, y))
    stage.do(2, "SETO")
    assert stage.truth["origins"][1] == pytest.approx((x, y, heading))


def test_what_a_gripper_holds():
    stage = Stage()
    for action in (5, 2):   # lower the paddles, and close them
        stage.do(1, "GRIPPER", action, seconds=4.0)
    assert stage.truth["cans"] == [(pytest.approx(0.3, abs=0.01), 0.0, 0.0, 1, -1), (2.5, 1.0, 0.0, -1, -1)]
    assert stage.truth["grippers"][0] == pytest.approx([0.066, 0.0])
    stage.do(1, "GRIPPER", 4, seconds=4.0)
    assert stage.truth["cans"][0][2] == pytest.approx(0.07)


def test_who_touches_something():
    stage = Stage()
    stage.do(1, "VEL", 300, seconds=10.0)
    stage.do(1, "GRIPPER", 3)
    told = stage.truth["robots"]
    assert [robot[5] for robot in told] == [True, False], "the second one was run into"
    stage.do(1, "VEL", -100, seconds=1.0)
    assert not stage.truth["robots"][0][5]


def test_contacts_and_the_way_are_counted():
    stage = Stage()
    stage.do(2, "VEL", 200, seconds=2.0)
    stage.do(2, "VEL", -200, seconds=2.0)
    stage.do(2, "VEL", 0, seconds=1.0)
    assert stage.truth["contacts"] == [0, 0] and stage.truth["driven"] == [0.0, pytest.approx(0.7, abs=0.15)]
    for count in (1, 2):
        stage.do(1, "VEL", 300, seconds=10.0)
        assert stage.truth["contacts"] == [count, 0] and stage.truth["robots"][0][5]
        stage.do(1, "MOVE", -200, seconds=3.0)
        assert not stage.truth["robots"][0][5]
    before = stage.truth
    stage.do(1, "DHEAD", 90, seconds=3.0)
    carrier = Carrier(stage.simulation)
    carrier.put(1, (-1.0, -1.0, 0.0))
    assert stage.truth["driven"] == before["driven"] and stage.truth["contacts"] == before["contacts"], "only carried"
    carrier.reset(1)
    assert stage.truth["driven"] == [0.0, before["driven"][1]] and stage.truth["contacts"] == [0, 0]
    carrier.reset_all()
    assert stage.truth["driven"] == [0.0, 0.0]


def test_wheels_that_slip_do_not_count_for_the_true_way():
    numbers = standard_numbers()
    numbers = dataclasses.replace(numbers, wheels=dataclasses.replace(numbers.wheels, larger=0.1))
    simulation = Simulation(World("hall"))
    robot = simulation.add(find_model("p3dx-sh"), noise=0.0, numbers=numbers)
    robot.receive(OPEN + p2os.encode_command("MOVE", 300))
    simulation.advance(1.9)
    robot.receive(p2os.encode_command("PULSE"))
    simulation.advance(1.5)
    truth = truth_of(simulation, LineSimulation(simulation), Pace(1.0, 0), Referee(simulation))["truth"]
    assert truth["driven"] == [pytest.approx(robot.true_pose[0])]
    assert robot.true_pose[0] == pytest.approx(0.33, abs=1e-3) and robot.hardware.odometry.pose[0] < 0.31


def test_a_jammed_can_is_no_way_driven():
    """The robot presses a can against a wall, and stands."""
    world = World("jam", [(1.0, -1.0, 1.0, 1.0)], cans=[Can(0.9, 0.0)])
    simulation = Simulation(world)
    robot = simulation.add(find_model("p3dx-sh"), noise=0.0, gripper=False)
    robot.receive(OPEN)
    for _ in range(100):
        robot.receive(p2os.encode_command("VEL", 200))
        simulation.advance(0.1)
    assert robot.hardware.body.driven == pytest.approx(robot.true_pose[0]) and robot.true_pose[0] < 0.75


@pytest.mark.parametrize("x, y, place", [
    (0.0, 0.0, 1), (0.5, -0.2, 1), (0.51, 0.0, -1), (0.0, 0.21, -1), (2.0, 2.0, 2), (1.51, 2.0, 2), (2.4, 2.4, -1)])
def test_the_place_in_which_a_can_stands(x, y, place):
    stage = Stage()
    can = stage.simulation.world.cans[1]
    can.x, can.y = x, y
    assert stage.truth["cans"][1][4] == place
    can.held_by = stage.simulation.robots[0].gripper
    assert stage.truth["cans"][1][4] == -1, "a held can stands nowhere"


def test_the_first_of_two_places_counts():
    world = World("two", places=[MarkedPlace("a", 0.0, 0.0, (2.0,)), MarkedPlace("b", 0.0, 0.0, (9.0, 9.0))])
    assert [marked_place(world, Can(x, 0.0)) for x in (0.5, 2.0, 5.0)] == [1, 2, -1]


def test_stop_buttons_and_faults():
    stage = Stage()
    for words in ("stop_button robot 2", "loss 0.25 way to-robot to 5", "silence from 3"):
        stage.lines.faults.add(fault_of(words))
    stage.lines.advance(0.1)
    assert stage.truth["stop_buttons"] == [False, True]
    assert stage.truth["faults"] == ["stop_button robot 2", "loss 0.25 way to-robot"]


def test_a_line_is_short_and_plain():
    line = line_of({"a": [1.23456789, 2, None, True, "é\n"], "b": {"c": (0.00001, -5)}})
    assert line == b'{"a":[1.2346,2,null,true,"\\u00e9\\n"],"b":{"c":[0.0,-5]}}\n'


def test_thirty_robots_fit_into_a_few_kilobytes():
    simulation = simulate(load_world("classroom"), find_model("p3dx-sh"), 30, None, 0)
    assert len(line_of(truth_of(simulation, LineSimulation(simulation), Pace(1.0, 0), Referee(simulation)))) < 5000


def test_what_is_on_no_map_and_people_are_told_apart():
    world = World("hall", unmapped=[Furniture(((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))),
                                    Furniture(posts=((5.0, 5.0, 0.1),))], walks=[Walk(((-3.0, 0.0), (-5.0, 0.0)))])
    simulation = simulate(world, find_model("p3dx-sh"), 1, None, 0)
    referee = Referee(simulation)
    told = world_of(simulation, [None], referee)["world"]
    assert told["walls"] == told["posts"] == [] and told["unmapped"]["posts"] == [(5.0, 5.0, 0.1)]
    assert told["unmapped"]["walls"][0] == (1.0, 1.0, 2.0, 1.0) and len(told["unmapped"]["walls"]) == 4
    assert truth_of(simulation, LineSimulation(simulation), Pace(1.0, 0), referee)["truth"]["people"] == [
        (-3.0, 0.0, 0.25)]

"""What other programs order, and what they are answered."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pioneer_control import p2os
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import LineSimulation
from pioneer_control.simulator.line.pace import Pace
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.tasks import Grounds, Referee, load_tasks
from pioneer_control.simulator.truth.orders import LONGEST_WORDS, MOST_FAULTS, TOO_LONG, Orders
from pioneer_control.simulator.truth.state import line_of
from pioneer_control.simulator.world import Can, World

OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
STARTS = [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)]


class Desk:
    """Two robots, and what obeys orders."""

    def __init__(self, world=None, grounds=None):
        self.simulation = Simulation(
            world or World("desk", [(4.0, -3.0, 4.0, 3.0)], cans=[Can(1.0, -2.0)], starts=STARTS))
        for _ in STARTS:
            self.simulation.add(find_model("p3dx-sh")).receive(OPEN)
        self.lines, self.pace = LineSimulation(self.simulation), Pace(1.0, 0)
        self.referee = Referee(self.simulation, grounds)
        self.orders = Orders(self.simulation, self.lines, self.pace, self.referee)

    def answer(self, line):
        """Return the answer to a line, as the program reads it."""
        return json.loads(line_of(self.orders.answer(self.orders.read(line))))

    def order(self, order, **values):
        """Give an order, and return whether it was obeyed, and the text about it."""
        answer = self.answer(json.dumps({"id": 5, "order": order, **values}).encode())
        assert sorted(answer) == ["answer", "ok", "text"] and answer["answer"] == 5
        return answer["ok"], answer["text"]

    @property
    def poses(self):
        return [robot.true_pose for robot in self.simulation.robots]


@pytest.fixture
def desk():
    return Desk()


# -- what each order does

def test_pause_and_go_on(desk):
    desk.lines.advance(1.5)
    for _ in range(2):
        assert desk.order("pause") == (True, "simulated time stands at 1.500 s") and desk.pace.paused
    for _ in range(2):
        assert desk.order("go_on") == (True, "simulated time passes") and not desk.pace.paused


def test_speed(desk):
    assert desk.order("speed", speed=2.5) == (True, "2.5 simulated seconds in a real one") and desk.pace.speed == 2.5
    assert desk.order("speed", speed=100)[0] and desk.pace.speed == 100.0


def test_put_and_reset(desk):
    assert desk.order("put", robot=2, pose=[1, -1, 0.5]) == (True, "robot 2 is at x 1, y -1, heading 0.5")
    assert desk.poses == [STARTS[0], (1.0, -1.0, 0.5)]
    assert desk.order("put", robot=1, pose=[0.0, 2.0, -1.0])[0]
    ok, text = desk.order("reset", robot=2)
    assert not ok and text == "robot 2 cannot stand where it began: in its way is robot 1"
    assert desk.order("reset", robot=1) == (True, "robot 1 is where it began")
    assert desk.poses == [STARTS[0], (1.0, -1.0, 0.5)]
    desk.simulation.world.cans[0].x = 3.0
    assert desk.order("reset") == (True, "all robots and cans are where they began")
    assert desk.poses == STARTS and desk.simulation.world.cans[0].x == 1.0


def test_a_robot_is_not_put_into_something(desk):
    assert desk.order("put", robot=1, pose=[4, 0, 0]) == (
        False, "robot 1 cannot stand at x 4, y 0, heading 0: in its way is a wall or a post")
    assert desk.poses == STARTS


def test_the_stop_button_of_one_robot(desk):
    assert desk.order("stop_button", robot=2, pressed=True) == (True, "the STOP button of robot 2 is pressed")
    assert [robot.hardware.motors.stop_button for robot in desk.simulation.robots] == [False, True]
    assert desk.order("stop_button", robot=2, pressed=False) == (True, "the STOP button of robot 2 is released")
    assert not desk.simulation.robots[1].hardware.motors.stop_button


def test_faults(desk):
    desk.lines.advance(2.0)
    assert desk.order("add_fault", fault="loss 0.1 robot 2 to 30") == (True, "loss 0.1 robot 2: now, for 30 s")
    assert desk.order("add_fault", fault="battery 11.2 from 3") == (True, "battery 11.2: in 3 s, until it is cleared")
    desk.lines.advance(3.5)
    assert desk.lines.faults.told(0) == ["loss 0.1 robot 2", "battery 11.2"]
    assert desk.order("clear_faults") == (True, "2 ended") and desk.lines.faults.told(0) == []


def test_faults_are_not_too_many(desk):
    for _ in range(MOST_FAULTS):
        assert desk.order("add_fault", fault="delay 1 from 10")[0]
    assert desk.order("add_fault", fault="delay 1") == (False, "there are 100 faults already: clear them first")
    assert desk.order("clear_faults") == (True, "100 ended") and desk.order("add_fault", fault="delay 1")[0]


def test_tasks():
    base = World("hall", starts=STARTS)
    grounds = Grounds(base, STARTS, load_tasks())
    desk = Desk(grounds.world, grounds)
    assert desk.order("begin_task") == (False, "no task is chosen; there are square, goal, sweep, cans, maze")
    assert desk.order("task", name="cans") == (True, "the task cans is ready")
    assert len(desk.simulation.world.cans) == 6 and desk.poses == desk.referee.ground.starts
    assert desk.order("begin_task") == (True, "the task cans has begun")
    assert desk.order("begin_task") == (False, "the task runs already: end it first")
    assert desk.order("put", robot=2, pose=[*desk.referee.ground.offsets[1], 1.0])[0]
    assert desk.order("reset") == (True, "all robots and cans are where they began")
    assert desk.poses == desk.referee.ground.starts, "where they began in the task"
    assert desk.order("end_task") == (True, "the task cans is over")
    assert desk.order("task", name="") == (True, "all robots are back in hall")
    assert desk.simulation.world.cans == [] and desk.poses == STARTS


# -- orders that are not legal

@pytest.mark.parametrize("name, values, text", [
    ("puase", {}, 'no order "puase"; did you mean \'pause\'? there are pause, go_on, speed, reset, put, stop_button,'
                  " add_fault, clear_faults, task, begin_task, end_task"),
    (None, {}, "no order null; there are pause, "),
    (["pause"], {}, 'no order ["pause"]; there are pause, '),
    ("pause", {"now": 1}, 'pause has no "now"; there are id, order'),
    ("put", {"robots": 1}, "put has no \"robots\"; did you mean 'robot'? there are id, order, robot, pose"),
    ("task", {}, "task needs name: a text of 0 to 200 characters"),
    ("task", {"name": "square"}, "no task 'square'; there are no tasks: start the simulator with --tasks"),
    ("task", {"name": 1}, "name 1 is not legal: give a text of 0 to 200 characters"),
    ("task", {"name": "x" * 201}, "is not legal: give a text of 0 to 200 characters"),
    ("begin_task", {}, "no task is chosen; there are no tasks: start the simulator with --tasks"),
    ("end_task", {}, "no task is chosen; there are no tasks"),
    ("speed", {}, "speed needs speed: a number from 0.01 to 100"),
    ("speed", {"speed": 0}, "speed 0 is not legal: give a number from 0.01 to 100"),
    ("speed", {"speed": "2"}, 'speed "2" is not legal: give a number from 0.01 to 100'),
    ("speed", {"speed": True}, "speed true is not legal"),
    ("speed", {"speed": math.nan}, "speed NaN is not legal"),
    ("speed", {"speed": math.inf}, "speed Infinity is not legal"),
    ("speed", {"speed": 10 ** 400}, "speed 1000"),
    ("reset", {"robot": 0}, "robot 0 is not legal: give a whole number from 1 to 2"),
    ("reset", {"robot": -1}, "robot -1 is not legal: give a whole number from 1 to 2"),
    ("reset", {"robot": 3}, "robot 3 is not legal: give a whole number from 1 to 2"),
    ("reset", {"robot": 1.0}, "robot 1.0 is not legal"),
    ("reset", {"robot": None}, "robot null is not legal"),
    ("reset", {"robot": "all"}, 'robot "all" is not legal'),
    ("put", {"robot": 1}, "put needs pose: 3 numbers from -1e+06 to 1e+06, as a list"),
    ("put", {"robot": 1, "pose": [1, 2]}, "pose [1, 2] is not legal: give 3 numbers from -1e+06 to 1e+06, as a list"),
    ("put", {"robot": 1, "pose": [1, 2, math.nan]}, "pose [1, 2, NaN] is not legal"),
    ("put", {"robot": 1, "pose": [1, 2, 1e7]}, "pose [1, 2, 10000000.0] is not legal"),
    ("put", {"robot": 1, "pose": {"x": 1}}, "pose an object is not legal"),
    ("put", {"robot": 1, "pose": [[[1]]]}, "pose a list is not legal"),
    ("stop_button", {"robot": 1, "pressed": 1}, "pressed 1 is not legal: give true or false"),
    ("add_fault", {"fault": "los 0.1"}, "fault 'los 0.1': no kind 'los'; did you mean 'loss'?"),
    ("add_fault", {"fault": "cable robot 3"}, "fault 'cable robot 3': there is no robot 3; there are 1 to 2"),
    ("add_fault", {"fault": "battery 1" + 150 * "0"}, "value 1000"),
    ("add_fault", {"fault": ""}, 'fault "" is not legal: give a text of 1 to 200 characters'),
    ("add_fault", {"fault": "x" * 300}, "is not legal: give a text of 1 to 200 characters"),
    ("add_fault", {"fault": "\ud800 1"}, "no kind '\\ud800'"),
])
def test_what_is_not_legal_is_named_and_changes_nothing(desk, name, values, text):
    ok, told = desk.order(name, **values)
    assert not ok and text in told and len(told) < 4 * LONGEST_WORDS
    assert desk.poses == STARTS and not desk.pace.paused and desk.pace.speed == 1.0
    assert desk.lines.faults.told(0) == []


@pytest.mark.parametrize("line, text", [
    (b"pause", "this is not JSON in UTF-8 (Expecting value: line 1 column 1 (char 0)): send one JSON object in each"),
    (b'{"order": "pause"', "this is not JSON in UTF-8"),
    (b"\xff\xfe", "this is not JSON in UTF-8"),
    (b"[" * 60000, "this is not JSON in UTF-8"),
    (b"9" * 60000, ""),
    (b"[1, 2]", '[1, 2] is no order: send a JSON object, such as {"id": 1, "order": "pause"}'),
    (b"null", "null is no order"),
    (b'"' + b"x" * 1000 + b'"', "... is no order"),
    (b"{}", "no order null"),
])
def test_a_line_that_is_no_order(desk, line, text):
    answer = desk.answer(line)
    assert answer["answer"] is None and not answer["ok"] and text in answer["text"]
    assert len(answer["text"]) < 4 * LONGEST_WORDS


def test_a_line_that_was_too_long(desk):
    assert desk.orders.answer(TOO_LONG) == {
        "answer": None, "ok": False, "text": "a line has more than 65536 bytes: send shorter lines"}


@pytest.mark.parametrize("given", [0, -7, 2 ** 53, "a", "x" * 200, None])
def test_the_id_comes_back_also_with_what_went_wrong(desk, given):
    for order in ("go_on", "nonsense"):
        answer = desk.answer(json.dumps({"id": given, "order": order}).encode())
        assert answer["answer"] == given and answer["ok"] == (order == "go_on")


@pytest.mark.parametrize("given", [1.5, True, [], {}, "", "x" * 201, 2 ** 53 + 1])
def test_an_id_that_is_not_legal(desk, given):
    answer = desk.answer(json.dumps({"id": given, "order": "pause"}).encode())
    assert answer["answer"] is None and "id " in answer["text"] and not answer["ok"] and not desk.pace.paused


def test_an_order_needs_no_id(desk):
    assert desk.answer(b'{"order": "pause"}\r')["answer"] is None and desk.pace.paused


ROBUST = Desk()
NAMES = list(ROBUST.orders.table)
WORDS = st.sampled_from(["robot", "pose", "speed", "pressed", "fault", "order", "id", "x"])
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text()
    | st.sampled_from([*NAMES, 1, 2, "power to 1", "gyro 5", "battery 11"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text() | WORDS, inner, max_size=4), max_leaves=8)


@given(st.dictionaries(WORDS, VALUES), st.sampled_from(NAMES))
def test_whatever_is_ordered_is_answered(values, name):
    answer = ROBUST.answer(json.dumps({"order": name, **values}).encode())
    assert isinstance(answer["ok"], bool) and answer["text"]


@given(st.binary())
def test_whatever_bytes_come_are_answered(line):
    assert ROBUST.answer(line)["text"]

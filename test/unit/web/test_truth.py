"""The map of simulated robots: the simulator's lines as texts of the page, also after a robot connected anew."""

import json
import math
import socket

import pytest

from pioneer_control.errors import RefusedError
from pioneer_control.web.truth import LONGEST_LINE, MOST_ORDERS, Truth, TruthLine, origin_of

WORLD = {"name": "office", "bounds": [0, 0, 9, 6], "walls": [[0, 0, 9, 0]], "posts": [[1, 2, 0.1]],
         "boxes": [[[3, 3], [4, 3], [4, 4]]], "cans": [[0.03, 0.12]], "starts": [[1, 1, 0]], "docks": [], "goals": {},
         "places": [{"name": "dock", "centre": [1, 2], "size": [0.5, 1]},
                    {"name": "1", "centre": [3, 2], "diameter": 0.6}],
         "robots": [{"name": "a", "url": "socket://127.0.0.1:1"}, {"name": "b", "url": None},
                    {"name": "c", "url": "socket://127.0.0.1:3"}]}
NUMBERS = {3: 1, 1: 2}


def line(**message):
    return json.dumps(message).encode() + b"\n"


def truth_with(*cans, origins=((1, 1, 0.5), (2, 2, 0), (3, 3, 0))):
    return line(truth={"origins": list(origins), "cans": list(cans), "robots": [], "time": 1.0})


@pytest.fixture
def truth():
    return Truth(NUMBERS, lambda number: (0.0, 0.0, 0.0))


def test_world_origins_and_cans(truth):
    texts = dict(truth.receive(line(world=WORLD) + truth_with([1.0, 2.0, 0.0, -1], [3.0, 1.0, 0.07, 1])))
    assert texts == {
        "world": {"name": "office", "bounds": [0, 0, 9, 6], "walls": [[0, 0, 9, 0]], "posts": [[1, 2, 0.1]],
                  "boxes": [[[3, 3], [4, 3], [4, 4]]], "places": WORLD["places"], "can": {"radius": 0.03}},
        "origins": {"2": [1, 1, 0.5], "1": [3, 3, 0]}, "cans": [[1.0, 2.0, 0.0], [3.0, 1.0, 0.07]]}


def test_what_is_on_no_map_is_shown_with_the_rest(truth):
    unmapped = {"walls": [[5, 0, 6, 0]], "posts": [[7, 2, 0.1]]}
    shown = dict(truth.receive(line(world=dict(WORLD, unmapped=unmapped))))["world"]
    assert shown["walls"] == [[0, 0, 9, 0], [5, 0, 6, 0]] and shown["posts"] == [[1, 2, 0.1], [7, 2, 0.1]]
    assert shown["boxes"] == WORLD["boxes"]


def test_only_what_changed_is_told_and_any_pieces_do(truth):
    data = line(world=dict(WORLD, cans=[])) + truth_with() + truth_with() + line(answer=1, ok=True, text="")
    found = []
    for at in range(0, len(data), 7):
        found += truth.receive(data[at:at + 7])
    assert [kind for kind, _ in found] == ["world", "origins", "cans"] and "can" not in found[0][1]
    assert truth.receive(truth_with([0, 0, 0, -1])) == [("cans", [[0, 0, 0]])]


@pytest.mark.parametrize("origin", [(1.0, 2.0, 0.3), (-4.0, 0.5, 3.0)])
@pytest.mark.parametrize("base", [(0.0, 0.0, 0.0), (1.5, -0.5, 2.0), (0.2, 7.0, -3.0)])
def test_the_clients_odometry_goes_on_where_the_robots_begins_anew(origin, base):
    """A place in the robot's odometry is at the same place in the map as the client's pose for it."""
    def put(frame, pose):
        cos, sin = math.cos(frame[2]), math.sin(frame[2])
        return (frame[0] + cos * pose[0] - sin * pose[1], frame[1] + sin * pose[0] + cos * pose[1], frame[2] + pose[2])

    own = (0.7, -0.2, 0.4)
    there, shown = put(origin, own), put(origin_of(origin, base), put(base, own))
    assert shown[:2] == pytest.approx(there[:2], abs=0.001)
    assert math.remainder(shown[2] - there[2], 2 * math.pi) == pytest.approx(0, abs=0.001)


@pytest.mark.parametrize("data", [
    b"x\n", b'{"world": {}}\n', b'{"truth": {"origins": 1}}\n', b"\xff\n", b"1\n",
    b'{"truth": {"origins": [], "cans": [], "robots": [], "task": {"name": "square"}}}\n',
    b'{"truth": {"origins": [], "cans": [], "robots": [], "task": 1}}\n'])
def test_what_no_simulator_says(truth, data):
    with pytest.raises((ValueError, TypeError, LookupError)):
        truth.receive(data)


def test_a_line_without_an_end(truth):
    with pytest.raises(ValueError):
        truth.receive(b"x" * (LONGEST_LINE + 1))


class Told:
    """A feed that keeps texts."""

    def __init__(self):
        self.texts = []

    def text(self, kind, value):
        self.texts.append(kind)


def test_the_line_is_made_anew_when_it_breaks(tmp_path):
    path, feed, carried = str(tmp_path / "truth"), Told(), []
    watch = TruthLine(path, NUMBERS, lambda number: (0.0, 0.0, 0.0), feed, carried.append)
    watch.turn(0.0)         # nobody is there
    for now in (1.0, 3.0):
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(path)
            listener.listen(1)
            watch.turn(now)
            simulator, _ = listener.accept()
        with simulator:
            simulator.sendall(line(world=WORLD) + truth_with())
            watch.turn(now + 0.1)
        watch.turn(now + 0.2)       # it hung up
        (tmp_path / "truth").unlink()
    assert feed.texts == ["world", "origins", "cans"] * 2 and carried == []
    watch.close()


def test_time_and_faults(truth):
    texts = dict(truth.receive(line(world=WORLD) + line(truth={
        "origins": [], "cans": [], "robots": [], "paused": True, "speed": 2.0, "faults": ["loss 0.1"]})))
    assert texts["time"] == {"paused": True, "speed": 2.0} and texts["faults"] == ["loss 0.1"]


TASK = {"name": "square", "title": "Drive a square", "text": "Drive.", "state": "running", "clock": 3.5, "limit": 120.0}


def test_a_task_has_its_ranking_best_first_by_the_pages_numbers(truth):
    scores = [[12.5, "a corner"], [99.0, "robot b is not on the page"], [12.5, ""]]
    told = {"origins": [], "cans": [], "robots": []}
    texts = dict(truth.receive(line(world=dict(WORLD, tasks=[["square", "Drive a square"]]))
                               + line(truth=dict(told, task=dict(TASK, scores=scores)))))
    assert texts["tasks"] == [["square", "Drive a square"]] and "tasks" not in texts["world"]
    assert texts["task"] == dict(TASK, ranking=[{"robot": 1, "who": "", "points": 12.5, "note": ""},
                                                {"robot": 2, "who": "", "points": 12.5, "note": "a corner"}])
    scores[2] = [13.0, "two"]
    (kind, task), = truth.receive(line(truth=dict(told, task=dict(TASK, scores=scores[::-1]))))
    assert kind == "task" and [entry["robot"] for entry in task["ranking"]] == [2, 1]
    assert truth.receive(line(truth=dict(told, task=None))) == [("task", None)]


def test_another_floor_is_told_when_another_task_is_chosen(truth):
    before = dict(truth.receive(line(world=WORLD) + truth_with([1.0, 2.0, 0.0, -1])))
    floor = dict(WORLD, name="square", bounds=[20, 0, 60, 40], walls=[[20, 0, 26, 0]], cans=[], places=[])
    texts = dict(truth.receive(line(world=floor) + truth_with(origins=((21, 1, 0), (2, 2, 0), (3, 3, 0)))))
    assert texts["world"]["bounds"] == [20, 0, 60, 40] and "can" not in texts["world"]
    assert texts["cans"] == [] and texts["origins"]["2"] == [21, 1, 0]
    assert dict(truth.receive(line(world=WORLD)))["world"] == before["world"]


def test_who_was_carried_is_told_and_who_drove_is_not(truth):
    def robots(*places):
        return line(truth={"origins": [], "cans": [], "robots": [[x, y, 0.0, 0.1, 0.0, False] for x, y in places]})

    truth.receive(line(world=WORLD) + robots((0, 0), (0, 0), (0, 0)))
    truth.receive(robots((0.3, 0.3), (50, 0), (20, -1)))        # the second one is not on the page
    assert truth.carried == [1]
    truth.receive(robots((-0.5, 0.3), (50, 0), (20.5, -1)) + robots((0.2, 9.3), (50, 0), (20.5, -1)))
    assert truth.carried == [1, 2]


def test_orders_have_the_simulators_numbers_and_answers_come_back(tmp_path):
    path, feed, answers = str(tmp_path / "truth"), Told(), []
    watch = TruthLine(path, NUMBERS, lambda number: (0.0, 0.0, 0.0), feed)

    def order(name, robot=None, **values):
        watch.order(name, robot, values, lambda done, text: answers.append((done, text)))

    with pytest.raises(RefusedError, match="does not answer"):
        order("pause")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen(1)
        watch.turn(1.0)
        simulator, _ = listener.accept()
        with simulator, simulator.makefile("rb") as lines:
            simulator.sendall(line(world=WORLD))
            watch.turn(1.1)
            order("pause")
            order("reset", 1)
            order("add_fault", 2, fault="loss 0.1")
            with pytest.raises(RefusedError, match="robot 9 is not simulated"):
                order("reset", 9)
            heard = [json.loads(lines.readline().decode()) for _ in range(3)]
            assert heard == [{"order": "pause", "id": 1}, {"order": "reset", "robot": 3, "id": 2},
                             {"order": "add_fault", "fault": "loss 0.1 robot 1", "id": 3}]
            simulator.sendall(line(answer=3, ok=False, text="no") + line(answer=1, ok=True, text="yes")
                              + line(answer=77, ok=True, text="whose?"))
            watch.turn(1.2)
            assert answers == [(False, "no"), (True, "yes")]
            for _ in range(MOST_ORDERS - 1):
                order("pause")
            with pytest.raises(RefusedError):
                order("pause")
    watch.close()

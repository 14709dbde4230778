"""Who has begun a task, when it is over, and how many points each robot has."""

import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.simulation import simulate
from pioneer_control.simulator.tasks import Grounds, Referee, Task
from pioneer_control.simulator.tasks.scores import Rates
from pioneer_control.simulator.world import Can, World
from pioneer_control.simulator.world.world import MarkedPlace

OPEN = b"".join([p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)])
RATES = Rates(limit_s=20.0, quick_s=10.0, time_points=10.0, contact_points=5.0)
WALLS = [(-1.0, -1.0, 3.0, -1.0), (3.0, -1.0, 3.0, 1.0), (3.0, 1.0, -1.0, 1.0), (-1.0, 1.0, -1.0, -1.0)]


def task(name, rule, cans=()):
    arena = World(name, WALLS, cans=cans, places=[MarkedPlace("hut", 1.5, 0.0, (0.5,))])
    return Task(name, "The " + name, "Do it.", RATES, rule, arena)


def tasks():
    """Return a task to drive to a hut 1.5 m ahead, and one to push a can there."""
    return [task("run", {"name": "reach", "way_share": 0.5}), task("push", {"name": "cans"}, [Can(1.0, 0.0)])]


class Class:
    """Three robots in a hall, and the referee."""

    def __init__(self, count=3):
        base = World("hall", cans=[Can(5.0, 5.0)], starts=[(0.0, 2.0 * number, 1.0) for number in range(count)])
        grounds = Grounds(base, base.starts, tasks())
        self.simulation = simulate(grounds.world, find_model("p3dx-sh"), count, None, 0, noise=0.0)
        self.referee = Referee(self.simulation, grounds)
        for robot in self.simulation.robots:
            robot.receive(OPEN)

    def send(self, number, *command):
        self.simulation.robots[number - 1].receive(p2os.encode_command(*command))

    def wait(self, seconds, pieces=10):
        """Let time pass while all clients stay in touch."""
        for _ in range(round(seconds * 10)):
            for number in range(1, len(self.simulation.robots) + 1):
                self.send(number, "PULSE")
            for _ in range(pieces):
                self.simulation.advance(0.1 / pieces)

    def begin(self, name="run"):
        self.referee.choose(name)
        self.referee.begin()
        return self

    @property
    def poses(self):
        return [robot.true_pose for robot in self.simulation.robots]

    @property
    def state(self):
        return self.referee.told["state"]

    @property
    def clock(self):
        return self.referee.told["clock"]

    @property
    def scores(self):
        return self.referee.told["scores"]


def test_nothing_is_chosen_at_first():
    school = Class()
    assert school.referee.told is None and school.referee.ground.world.name == "hall"
    assert school.referee.tasks == [("run", "The run"), ("push", "The push")]


def test_a_chosen_task_is_ready():
    school = Class()
    assert school.referee.choose("run") == "the task run is ready"
    assert school.poses == school.referee.ground.starts and school.referee.ground.world.name == "run"
    assert school.referee.told == {
        "name": "run", "title": "The run", "text": "Do it.", "state": "ready", "clock": 0.0, "limit": 20.0,
        "scores": [[0.0, "has not moved"]] * 3}
    school.send(1, "VEL", 200)
    school.wait(2.0)
    assert school.state == "ready" and school.scores[0] == [0.0, "has not moved"], "nothing counts before the begin"


def test_back_to_the_world():
    school = Class()
    before = school.poses, list(school.simulation.world.cans)
    school.simulation.world.cans[0].x = 4.0
    school.referee.choose("push")
    assert len(school.simulation.world.cans) == 3
    assert school.referee.choose("") == "all robots are back in hall"
    assert (school.poses, school.simulation.world.cans) == before and school.referee.told is None
    assert school.simulation.world.cans[0].x == 5.0


def test_the_begin_carries_all_back_and_counts_from_zero():
    school = Class()
    school.referee.choose("push")
    school.send(1, "VEL", 300)
    school.send(2, "VEL", -300)
    school.wait(4.0)
    can, x, _ = school.referee.ground.cans[0]
    assert school.simulation.robots[1].contacts == 1 and can.x != x
    assert school.referee.begin() == "the task push has begun"
    assert school.poses == school.referee.ground.starts and school.simulation.robots[1].contacts == 0
    assert [(can.x, can.y) for can in school.simulation.world.cans] == [
        (x + 1.0, y) for x, y in school.referee.ground.offsets]
    school.wait(1.0)
    assert school.state == "running" and school.clock == 0.0, "carried robots stand"


def test_the_time_of_a_robot_begins_with_its_first_motion():
    school = Class().begin()
    school.wait(5.0)
    assert school.clock == 0.0
    school.send(1, "VEL", 300)
    school.wait(4.0)
    school.send(2, "VEL", 300)
    school.wait(5.0)
    assert school.clock == pytest.approx(9.0, abs=0.05)
    first, second, third = school.scores
    assert first == second == [100.0, first[1]] and third == [0.0, "has not moved"]
    assert first[1].startswith("at the hut, ") and second[1] == first[1], "the same time, though it began later"


def test_over_when_all_have_done_everything():
    school = Class().begin()
    for number in (1, 2, 3):
        school.send(number, "VEL", 200 * number)
    school.wait(10.0)
    assert school.state == "over" and 6.0 < school.clock < 8.0
    assert [score[0] for score in school.scores] == [100.0] * 3


def test_over_at_the_limit_and_nothing_counts_afterwards():
    school = Class().begin()
    school.wait(3.0)
    school.send(1, "VEL", 50)
    school.wait(20.5)
    assert school.state == "over" and school.clock == pytest.approx(20.0)
    scores = school.scores
    assert 0.0 < scores[0][0] < 45.0
    school.send(1, "VEL", 400)
    school.wait(3.0)
    assert school.scores == scores and school.clock == pytest.approx(20.0)


def test_over_when_nobody_moves():
    school = Class().begin()
    school.wait(19.9)
    assert school.state == "running"
    school.wait(0.2)
    assert school.state == "over" and school.clock == 0.0


def test_what_a_robot_does_when_it_has_done_everything_counts_no_more():
    school = Class().begin()
    school.send(1, "VEL", 300)
    school.wait(12.0)
    assert school.simulation.robots[0].contacts == 1, "it has run on into the wall"
    assert school.scores[0][0] == 100.0 and "contact" not in school.scores[0][1]


def test_ended_by_somebody_and_begun_again():
    school = Class().begin()
    school.send(1, "VEL", 300)
    school.wait(2.0)
    assert school.referee.end() == "the task run is over" and school.state == "over"
    assert school.scores[0][0] > 0.0
    school.referee.begin()
    assert school.state == "running" and school.scores == [[0.0, "has not moved"]] * 3


def test_the_last_moment_counts():
    """Also when the last sample is not due at the end."""
    school = Class().begin()
    school.send(1, "VEL", 300)
    school.wait(1.03)
    x, y = school.referee.ground.offsets[0]
    school.referee.carrier.put(1, (x + 1.5, y, 0.0))
    assert school.scores[0][0] < 50.0
    school.referee.end()
    assert school.scores[0] == [100.0, "at the hut, 1.0 s"]


def test_contacts_count_also_when_a_robot_was_carried_back_meanwhile():
    school = Class().begin()
    for count in (1, 2):
        school.send(1, "DHEAD", 90)
        school.wait(2.0)
        school.send(1, "VEL", 300)
        school.wait(4.0)
        assert school.scores[0][1].endswith("%d contact%s" % (count, "s" * (count > 1)))
        school.referee.carrier.reset(1)
        assert school.simulation.robots[0].contacts == 0


def test_cans_count_for_the_robot_of_their_arena():
    school = Class().begin("push")
    school.send(2, "VEL", 200)
    school.wait(6.0)
    school.send(2, "VEL", 0)
    school.wait(1.0)
    assert [score[1][:11] for score in school.scores] == ["has not mov", "1 of 1 cans", "has not mov"]
    assert school.simulation.world.cans[1].x != school.referee.ground.cans[1][1]


@pytest.mark.parametrize("act, problem", [
    (lambda referee: referee.choose("pusch"), "no task 'pusch'; did you mean 'push'? there are run, push"),
    (lambda referee: referee.choose("x" * 9), "no task 'xxxxxxxxx'; there are run, push"),
    (lambda referee: referee.begin(), "no task is chosen; there are run, push"),
    (lambda referee: referee.end(), "no task is chosen; there are run, push"),
    (lambda referee: referee.choose("run") and referee.end(), "the task does not run: begin it first"),
    (lambda referee: referee.choose("run") and referee.begin() and referee.begin(),
     "the task runs already: end it first"),
])
def test_what_is_refused(act, problem):
    with pytest.raises(ParameterError) as error:
        act(Class().referee)
    assert str(error.value) == problem


def test_without_tasks():
    simulation = simulate(World("hall"), find_model("p3dx-sh"), 1, None, 0)
    referee = Referee(simulation)
    assert referee.tasks == [] and referee.told is None
    with pytest.raises(ParameterError, match="no task 'run'; there are no tasks: start the simulator with --tasks"):
        referee.choose("run")
    assert referee.choose("") == "all robots are back in hall"


@pytest.mark.parametrize("wait, pieces", [(0.0, 10), (0.013, 1), (1.0071, 3)])
def test_the_same_motions_give_the_same_points(wait, pieces):
    """When the task begins, and into which pieces time is split, makes no difference."""
    school = Class(1)
    school.simulation.advance(wait)
    school.begin()
    school.send(1, "VEL", 110)
    school.wait(13.0, pieces)
    assert school.scores == [[98.4, "at the hut, 11.6 s"]]

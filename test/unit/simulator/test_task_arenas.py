"""Tasks and their arenas, and many copies of arenas in one world."""

import shutil

import pytest

from pioneer_control.errors import ParameterError, WorldError
from pioneer_control.robots import find_model
from pioneer_control.simulator.simulation import simulate
from pioneer_control.simulator.tasks import Grounds, load_tasks
from pioneer_control.simulator.tasks.task import HERE
from pioneer_control.simulator.world import load_world, standing_places

WALLS = "walls: [{corners_m: [[-1, -1], [3, -1], [3, 3], [-1, 3]], closed: true}]\n"
HUT = "places: [{name: hut, centre_m: [2, 0], diameter_m: 0.5}]\n"
START = "starts: [{position_m: [0, 0], heading_deg: 0}]\n"
RATES = "limit_s: 60, quick_s: 20, time_points: 10, contact_points: 5"


@pytest.fixture
def folder(tmp_path):
    """A folder with a task."""
    (tmp_path / "arenas").mkdir()
    (tmp_path / "arenas" / "hut.yaml").write_text(WALLS + HUT + START)
    (tmp_path / "tasks.yaml").write_text(
        "hut: {title: Go home, text: Drive to the hut., %s, rule: {name: reach, way_share: 0.5}}" % RATES)
    return tmp_path


def test_a_task_is_read(folder):
    task, = load_tasks(folder)
    assert (task.name, task.title, task.text) == ("hut", "Go home", "Drive to the hut.")
    assert task.rates == (60, 20, 10, 5) and task.begin().score == (0.0, "still 1.8 m to the hut")
    assert task.arena.places[0].name == "hut"


@pytest.mark.parametrize("file, old, new, error, problem", [
    ("arenas/hut.yaml", "3", "7", WorldError, "arena hut: it must not be larger than 6 by 6 m"),
    ("arenas/hut.yaml", START, "starts: [{position_m: [0, 0], heading_deg: 0}, {position_m: [1, 0], heading_deg: 0}]",
     WorldError, "and have one start"),
    ("arenas/hut.yaml", HUT, "", WorldError, "arena hut: its rule needs a place"),
    ("arenas/hut.yaml", "starts", "begins", WorldError, "hut.yaml, line 3: a world has no 'begins'"),
    ("tasks.yaml", "hut:", "hat:", WorldError, "hat.yaml does not exist"),
    ("tasks.yaml", "quick_s: 20", "quick_s: 60", ParameterError, "task hut: quick_s 60 is not legal: give less than"),
    ("tasks.yaml", "}}", "", ParameterError, "does not parse"),
])
def test_a_task_that_is_not_legal(folder, file, old, new, error, problem):
    path = folder / file
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(error, match=problem):
        load_tasks(folder)


def test_our_tasks_are_five_and_their_arenas_are_closed():
    tasks = load_tasks()
    assert [task.name for task in tasks] == ["square", "goal", "sweep", "cans", "maze"]
    for task in tasks:
        low_x, low_y, high_x, high_y = task.arena.bounds
        rim = {(low_x, low_y, high_x, low_y), (high_x, low_y, high_x, high_y), (high_x, high_y, low_x, high_y),
               (low_x, high_y, low_x, low_y)}
        assert rim <= set(map(tuple, task.arena.walls.tolist())), task.name
        assert task.begin().score.points == 0.0 and not task.begin().done
        assert task.title and task.text.endswith(".") and 0.0 < task.rates.quick_s < task.rates.limit_s


def test_every_arena_is_of_a_task():
    assert {path.stem for path in (HERE / "arenas").iterdir()} == {task.name for task in load_tasks()}


def grounds(count, base="office", tasks=None):
    world = load_world(base)
    starts = standing_places(world, find_model("p3dx-sh"), count)
    return Grounds(world, starts, load_tasks() if tasks is None else tasks)


@pytest.mark.parametrize("count", [1, 2, 7, 30])
def test_each_robot_has_a_copy_of_each_arena_and_no_two_overlap(count):
    made = grounds(count)
    boxes = [made.parts[""].world.bounds]
    for task in made.tasks.values():
        ground = made.parts[task.name]
        assert len(ground.starts) == len(ground.offsets) == count
        assert len(ground.cans) == len(ground.world.cans) == count * len(task.arena.cans)
        assert len(ground.world.walls) == count * len(task.arena.walls)
        low_x, low_y, high_x, high_y = task.arena.bounds
        boxes += [(low_x + x, low_y + y, high_x + x, high_y + y) for x, y in ground.offsets]
        assert [pose[:2] for pose in ground.starts] == [
            (x + task.arena.starts[0][0], y + task.arena.starts[0][1]) for x, y in ground.offsets]
    for number, (low_x, low_y, high_x, high_y) in enumerate(boxes):
        for other in boxes[:number]:
            assert (low_x >= other[2] + 0.99 or other[0] >= high_x + 0.99
                    or low_y >= other[3] + 0.99 or other[1] >= high_y + 0.99)


def test_the_base_world_stays_as_it_is():
    world, made = load_world("office"), grounds(5)
    assert made.world.walls[:len(world.walls)].tolist() == world.walls.tolist()
    assert made.world.name == "office" and made.world.goals == world.goals and made.world.cans == world.cans
    assert made.parts[""].world.bounds == world.bounds and made.parts[""].world.starts == world.starts
    assert made.world.starts == made.parts[""].starts and len(made.world.starts) == 5


def test_without_tasks_the_world_is_the_base_world():
    made = grounds(4, tasks=[])
    assert made.world is made.parts[""].world and list(made.parts) == [""]


def test_robots_hear_nothing_of_the_arenas():
    """The sonar of robots in the base world is the same with arenas and without."""
    def heard(world):
        simulation = simulate(world, find_model("p3dx-sh"), 3, None, 0)
        for robot in simulation.robots:
            robot.receive(bytes.fromhex("FAFB03000000FAFB03010001FAFB03020002FAFB03010001"))
        return simulation.advance(2.0)

    assert heard(grounds(3).world) == heard(load_world("office"))


def test_a_folder_of_tasks_is_a_copy(tmp_path):
    """Other people's tasks are read as ours."""
    shutil.copytree(HERE, tmp_path / "tasks")
    assert [task.title for task in load_tasks(tmp_path / "tasks")] == [task.title for task in load_tasks()]

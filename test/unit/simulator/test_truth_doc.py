"""docs/simulator.md is true about the socket for other programs."""

import json
import pathlib
import re

import pytest

from pioneer_control.robots import find_model
from pioneer_control.simulator.line import LineSimulation
from pioneer_control.simulator.line.pace import Pace
from pioneer_control.simulator.simulation import simulate
from pioneer_control.simulator.tasks import Grounds, Referee, load_tasks
from pioneer_control.simulator.truth import service, visit
from pioneer_control.simulator.truth.orders import Orders
from pioneer_control.simulator.truth.state import line_of, truth_of, world_of
from pioneer_control.simulator.world import World, load_world

TEXT = (pathlib.Path(__file__).resolve().parents[3] / "docs" / "simulator.md").read_text(encoding="utf-8")


def rows(head, text=TEXT):
    """Return the cells of the table that begins with a line of such a head."""
    table = text[text.index("| %s |" % head):].split("\n\n")[0]
    return [[cell.strip() for cell in line.strip("|").split(" |")] for line in table.splitlines()[2:]]


@pytest.fixture(scope="module")
def scene():
    simulation = simulate(load_world("classroom"), find_model("p3dx-sh"), 30, None, 0)
    lines, pace = LineSimulation(simulation), Pace(1.0, 0)
    referee = Referee(simulation)
    return simulation, lines, pace, referee, Orders(simulation, lines, pace, referee)


def names(cells):
    return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]


def test_everything_in_the_world_has_its_row(scene):
    told = json.loads(line_of(world_of(scene[0], [None] * 30, scene[3])))["world"]
    table = rows("in `world`")
    assert names(row[0] for row in table) == list(told)
    assert names([table[-1][1]]) == list(told["robots"][0])


def test_everything_in_the_truth_has_its_row(scene):
    assert names(row[0] for row in rows("in `truth`")) == list(truth_of(*scene[:4])["truth"])


def test_everything_in_a_task_has_its_row():
    base = World("hall")
    grounds = Grounds(base, base.starts, load_tasks())
    referee = Referee(simulate(grounds.world, find_model("p3dx-sh"), 1, None, 0), grounds)
    referee.choose("square")
    assert names(row[0] for row in rows("in `task`")) == list(referee.told)


def order_row(name, kind):
    """Return the row of an order."""
    values = ["`%s`: %s" % (key, value.legal) for key, value in kind.needs.items()]
    values += ["perhaps `%s`: %s" % (key, value.legal) for key, value in kind.may.items()]
    return ["`%s`" % name, "; ".join(values), kind.meaning]


def test_every_order_has_its_row(scene):
    """When this fails, the message has the rows that docs/simulator.md needs."""
    assert rows("order | values") == [order_row(name, kind) for name, kind in scene[4].table.items()]


def test_a_row_that_lies_is_seen():
    assert rows("order | values") != rows("order | values", TEXT.replace("from 0.01 to 100 |", "from 0 to 100 |"))


def test_the_example_of_an_order_is_answered_so(scene):
    order, answer = re.search(r'^(\{"id".*\})\n(\{"answer".*\})$', TEXT, re.MULTILINE).groups()
    orders = scene[4]
    assert orders.answer(orders.read(order.encode())) == json.loads(answer)


def test_numbers_in_sentences():
    for sentence in ("at most every %g s of real time" % service.PERIOD, "up to %d may" % service.MOST_VISITS,
                     "of at most %d kB" % (visit.LONGEST_LINE / 1024),
                     "More than %d orders of one program in %g s" % (visit.ORDERS_IN_A_TURN, service.PERIOD)):
        assert sentence in TEXT, sentence

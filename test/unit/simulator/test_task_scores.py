"""The rules of the tasks: samples in, points and a note out."""

import math

import pytest

from pioneer_control.errors import WorldError
from pioneer_control.simulator.tasks.floor import Floor
from pioneer_control.simulator.tasks.scores import BringCans, Marks, Rates, Reach, Sample, Sweep
from pioneer_control.simulator.world import Can, World
from pioneer_control.simulator.world.world import MarkedPlace

RATES = Rates(limit_s=100.0, quick_s=50.0, time_points=10.0, contact_points=5.0)
WALLS = [(-1.0, -1.0, 3.0, -1.0), (3.0, -1.0, 3.0, 3.0), (3.0, 3.0, -1.0, 3.0), (-1.0, 3.0, -1.0, -1.0)]
CORNERS = [MarkedPlace(name, x, y, (0.3,))
           for name, x, y in (("1", 2.0, 0.0), ("2", 2.0, 2.0), ("3", 0.0, 2.0), ("4", 0.0, 0.0))]


def arena(places=(), cans=(), walls=()):
    return World("arena", [*WALLS, *walls], places=places, cans=cans)


def drive(rule, path, seconds=40.0, contacts=0, pieces=50):
    """Let a robot drive along the corners of a path in so many seconds. Returns the rule."""
    legs = list(zip(path, path[1:]))
    for number in range(1, pieces * len(legs) + 1):
        (x1, y1), (x2, y2) = legs[(number - 1) // pieces]
        share = (number - 1) % pieces / pieces + 1.0 / pieces
        rule.take(Sample(seconds * number / pieces / len(legs), x1 + share * (x2 - x1), y1 + share * (y2 - y1),
                         contacts))
        if rule.done:
            break
    return rule


# -- what all rules have in common

def reach(**rates):
    return Reach(arena([MarkedPlace("hut", 2.0, 0.0, (0.5,))]), RATES._replace(**rates), way_share=0.5)


@pytest.mark.parametrize("seconds, points", [(20.0, 100.0), (55.0, 100.0), (85.0, 95.0), (200.0, 90.0)])
def test_points_for_the_time(seconds, points):
    """The robot is there after 7 of 8 parts of the time."""
    score = drive(reach(), [(0.0, 0.0), (2.0, 0.0)], seconds).score
    late = max(0.0, min(1.0, (seconds * 0.88 - 50.0) / 50.0))
    assert score.points == pytest.approx(100.0 - 10.0 * late, abs=0.05) == pytest.approx(points, abs=0.6)


@pytest.mark.parametrize("contacts, points, words", [
    (0, 100.0, "at the hut, 8.8 s"), (1, 95.0, "at the hut, 8.8 s, 1 contact"),
    (3, 85.0, "at the hut, 8.8 s, 3 contacts"), (50, 0.0, "at the hut, 8.8 s, 50 contacts")])
def test_contacts_cost_points_and_are_told(contacts, points, words):
    assert drive(reach(), [(0.0, 0.0), (2.0, 0.0)], 10.0, contacts).score == (points, words)


def test_no_points_for_the_time_before_all_is_done():
    rule = drive(reach(), [(0.0, 0.0), (1.6, 0.0)])
    assert not rule.done and 0.0 < rule.score.points < 45.0 and "s," not in rule.score.note


# -- marks

def marks(places=CORNERS):
    return Marks(arena(places), RATES, straight_share=0.1, crooked_m=0.3)


SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)]


def test_a_square_along_its_sides():
    rule = drive(marks(), SQUARE)
    assert rule.done and rule.score.points == 100.0
    assert rule.score.note == "4 of 4 marks, 0 cm beside the lines, 39.4 s"


def test_marks_count_in_their_order_only():
    rule = drive(marks(), SQUARE[::-1])
    assert not rule.done and rule.score.note.startswith("1 of 4 marks")
    assert 0.0 < rule.score.points < 25.0


def test_half_a_square_is_half_the_points():
    assert drive(marks(), SQUARE[:3]).score == (45.0, "2 of 4 marks, 0 cm beside the lines")


def test_crooked_lines_cost_points():
    bent = [(0.0, 0.0), (1.0, -0.4), (2.0, 0.0), (2.4, 1.0), (2.0, 2.0), (1.0, 2.4), (0.0, 2.0), (-0.4, 1.0),
            (0.0, 0.0)]
    score = drive(marks(), bent).score
    assert score.note.startswith("4 of 4 marks, 20 cm beside") and score.points == pytest.approx(94.0, abs=0.2)


def test_beside_a_mark_is_not_in_it():
    assert drive(marks(), [(0.0, 0.0), (1.84, 0.0)]).score.note == "0 of 4 marks, 0 cm beside the lines"


# -- reach

def test_the_way_counts_and_not_the_distance():
    """A wall with a gap at its end stands between start and hut."""
    place = [MarkedPlace("hut", 2.0, 0.0, (0.5,))]
    rule = Reach(arena(place, walls=[(1.0, -1.0, 1.0, 2.0)]), RATES, way_share=0.5)
    before_the_wall = drive(rule, [(0.0, 0.0), (0.7, 0.0)]).score
    assert before_the_wall.points < 5.0 and before_the_wall.note.startswith("still 5.0 m")
    at_the_gap = drive(rule, [(0.7, 0.0), (0.5, 2.0), (1.0, 2.5)]).score
    assert 15.0 < at_the_gap.points < 30.0
    back = drive(rule, [(1.0, 2.5), (0.0, 0.0)]).score
    assert back == at_the_gap, "the nearest counts"
    assert drive(rule, [(1.0, 2.5), (2.0, 2.0), (2.0, 0.0)]).score.points == 100.0


def test_a_robot_close_to_a_wall_or_carried_out_of_the_arena_is_still_scored():
    rule = reach()
    for place in ((-1.0, -1.0), (3.0, 3.0), (-50.0, 1.0), (1.0, 500.0)):
        rule.take(Sample(1.0, *place))
    assert rule.score.points == 0.0


# -- sweep

def sweep(walls=()):
    return Sweep(arena(walls=walls), RATES, enough=0.9, broom_m=0.3)


LANES = [(x, y) for row in range(8) for y in [-0.75 + row * 0.5]        # half a metre apart
         for x in ((-0.75, 2.75) if row % 2 == 0 else (2.75, -0.75))]


def test_the_whole_floor_swept():
    rule = drive(sweep(), LANES)
    assert rule.done and rule.score.points == 100.0 and rule.score.note.startswith("90 % of the floor, ")


def test_half_the_floor_is_half_the_points():
    score = drive(sweep(), LANES[:8]).score
    assert score.points == pytest.approx(50.0, abs=3.0) and score.note == "%.0f %% of the floor" % score.points


def test_the_same_floor_twice_counts_once():
    rule = drive(sweep(), LANES[:4])
    assert drive(rule, LANES[:4]).score == drive(sweep(), LANES[:4]).score


def test_floor_that_no_robot_reaches_need_not_be_swept():
    cut = [(1.0, -1.0, 1.0, 3.0)]
    rule = drive(sweep(cut), [(x, y) for x, y in ((-0.75, -0.75), (0.75, -0.75), (0.75, -0.25), (-0.75, -0.25))])
    whole = drive(sweep(), [(x, y) for x, y in ((-0.75, -0.75), (0.75, -0.75), (0.75, -0.25), (-0.75, -0.25))])
    assert rule.score.points > 1.8 * whole.score.points


# -- cans

def test_cans_in_the_dock():
    rule = BringCans(arena([MarkedPlace("dock", 2.0, 0.0, (0.8, 0.8))], [Can(0.0, 1.0)] * 3), RATES)
    rule.take(Sample(10.0, 0.0, 0.0, 0, [(2.0, 0.0), (1.0, 0.0), (2.3, 0.3)]))
    assert not rule.done and rule.score == (60.0, "2 of 3 cans")
    rule.take(Sample(11.0, 0.0, 0.0, 0, [(2.0, 0.0)]))
    assert rule.score == (30.0, "1 of 3 cans"), "a can that was taken out again"
    rule.take(Sample(12.0, 0.0, 0.0, 0, [(2.0, 0.0), (1.9, 0.0), (2.3, 0.3)]))
    assert rule.done and rule.score == (100.0, "3 of 3 cans, 12.0 s")


# -- arenas that do not fit

@pytest.mark.parametrize("make, problem", [
    (lambda: marks([]), "its rule needs a place"),
    (lambda: marks([CORNERS[0], CORNERS[0]]), "a mark is at the same place as the one before it"),
    (lambda: marks([CORNERS[3]]), "a mark is at the same place as the one before it"),
    (lambda: Reach(arena(), RATES, 0.5), "its rule needs a place"),
    (lambda: BringCans(arena(), RATES), "its rule needs a place"),
    (lambda: BringCans(arena(CORNERS), RATES), "its rule needs cans"),
    (lambda: Reach(arena([MarkedPlace("hut", 2.0, 0.0, (0.5,))], walls=[(1.0, -1.0, 1.0, 3.0)]), RATES, 0.5),
     "there is no way from the start to the place 'hut'"),
    (lambda: Reach(arena([MarkedPlace("hut", 0.0, 0.0, (0.5,))]), RATES, 0.5), "there is no way from the start"),
    (lambda: Sweep(arena(walls=[(0.1, -1.0, 0.1, 3.0)]), RATES, 0.9, 0.3), "a robot cannot move away from the start"),
])
def test_an_arena_without_what_the_rule_needs(make, problem):
    with pytest.raises(WorldError, match="arena arena: .*" + problem):
        make()


def test_the_length_of_ways():
    floor = Floor(arena())
    ways = floor.ways_to(MarkedPlace("hut", 2.0, 0.0, (0.2,)))
    assert ways[floor.cell(0.0, 0.0)] == pytest.approx(2.0, abs=0.11)
    assert ways[floor.cell(2.0, 2.0)] == pytest.approx(2.0, abs=0.11)
    assert ways[floor.cell(0.5, 1.5)] == pytest.approx(1.5 * math.sqrt(2.0), abs=0.1)
    assert ways[floor.cell(-0.95, 0.0)] == math.inf, "too close to the wall for the middle of a robot"

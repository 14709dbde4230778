"""When a pose may be trusted."""

from dataclasses import replace

import numpy as np
import pytest

from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.certainty import UNCONFIRMED, UNKNOWN, Certainty
from pioneer_control.navigation.measurement import Beams
from pioneer_control.navigation.pose_cloud import Spread
from pioneer_control.navigation.tuned import LocalisationNumbers

TUNED = LocalisationNumbers(usual_explained=0.8, told_explained=1.0)
MANY = 500.0        # spots


def spread(position=0.05, heading=0.05):
    return Spread(Pose(0.0, 0.0, 0.0), np.diag([position ** 2, position ** 2, heading ** 2]))


def hear(certainty, explained, way=0.04, count=5, first=0):
    """Let it hear some readings, each with another range and explained as told."""
    zeros = np.zeros(count)
    measured = np.arange(first, first + count * 20, 20)
    certainty.hear(Beams(zeros, zeros, zeros, measured, np.arange(count)), np.full(count, explained), way, way)


def sure():
    """Return a certainty that is sure, as after a start that a person told."""
    certainty = Certainty(TUNED)
    certainty.place(trusted=True)
    certainty.judge(spread())
    assert certainty.sure and not certainty.reason
    return certainty


@pytest.mark.parametrize("what, words", [
    (spread(position=0.4), "I may be 0.4 m off"), (spread(heading=0.5), "my heading may be 29 degrees off")])
def test_a_wide_cloud_is_not_sure(what, words):
    certainty = sure()
    certainty.judge(what)
    assert not certainty.sure and words in certainty.reason


@pytest.mark.parametrize("explained, way", [(1.0, 0.04), (1.0, 0.0), (0.0, 0.04)])
def test_what_a_person_said_is_sure_once_readings_fit_it(explained, way):
    certainty = Certainty(replace(TUNED, told_explained=0.7))
    for _ in range(2):
        certainty.place(trusted=True)
        hear(certainty, np.nan)     # no echo
        certainty.judge(spread())
        assert not certainty.sure and certainty.reason == UNKNOWN + UNCONFIRMED
        for _ in range(TUNED.standing_readings):    # also of a robot that stands
            hear(certainty, explained, way)
        certainty.judge(spread())
        assert certainty.sure == bool(explained)
        assert certainty.sure or "does not fit" in certainty.reason


def long_cloud(angle, along, across, heading=0.05):
    """Return a cloud that is long in a direction (rad)."""
    axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = axes @ np.diag([along ** 2, across ** 2]) @ axes.T
    covariance[2, 2] = heading ** 2
    return Spread(Pose(0.0, 0.0, 0.0), covariance)


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2, -1.2])
def test_a_long_and_narrow_cloud_lies_on_a_line(angle):
    cloud = long_cloud(angle, 0.6, 0.02)
    assert (cloud.position, cloud.across) == pytest.approx((0.6, 0.02))
    assert abs(np.sin(cloud.direction - angle)) < 1e-6
    certainty = sure()
    certainty.judge(cloud)
    assert certainty.on_a_line and not certainty.sure
    certainty.judge(spread())
    assert certainty.sure and not certainty.on_a_line


@pytest.mark.parametrize("cloud", [
    long_cloud(0.3, 0.6, 0.2), long_cloud(0.3, 0.6, 0.02, 0.4), long_cloud(0.3, 2.0, 0.02), spread(0.4)])
def test_a_cloud_that_is_wide_in_more_than_one_way_or_very_long_lies_on_no_line(cloud):
    certainty = sure()
    certainty.judge(cloud)
    assert not certainty.on_a_line and not certainty.sure


def test_a_robot_that_is_not_sure_of_its_place_for_other_reasons_is_on_no_line():
    certainty = Certainty(TUNED)
    certainty.judge(long_cloud(0.0, 0.6, 0.02))
    assert not certainty.on_a_line
    certainty.place(trusted=False)
    certainty.judge(long_cloud(0.0, 0.6, 0.02))
    assert not certainty.on_a_line
    certainty = sure()
    for _ in range(30):
        hear(certainty, 0.0)
    certainty.judge(long_cloud(0.0, 0.6, 0.02))
    assert certainty.doubts and not certainty.on_a_line


def test_readings_that_contradict_make_it_unsure_and_good_ones_sure_again():
    certainty = sure()
    for _ in range(25):
        hear(certainty, 0.0)
    certainty.judge(spread())
    assert not certainty.sure and "does not fit" in certainty.reason and certainty.doubts
    for _ in range(60):
        hear(certainty, 1.0)
    certainty.judge(spread())
    assert certainty.sure


def test_what_a_few_sensors_hear_of_a_robot_that_stands_does_not_make_it_unsure_however_often_they_hear_it():
    certainty = sure()
    hear(certainty, 1.0, count=16)
    for _ in range(1000):       # somebody has come, and stays in front of it
        hear(certainty, 0.0, way=0.0, count=2, first=500)
    certainty.judge(spread())
    assert certainty.sure


def test_what_most_sensors_hear_of_a_robot_that_stands_makes_it_unsure():
    certainty = sure()
    hear(certainty, 1.0, count=8)
    for _ in range(12):         # it was carried elsewhere: two of its eight sensors hear nothing there, one fits
        hear(certainty, np.array([np.nan, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, np.nan]), way=0.0, count=8, first=500)
    certainty.judge(spread())
    assert not certainty.sure


def test_the_share_from_which_a_pose_is_doubted():
    for share, expected in ((0.7, True), (0.4, False)):     # 0.8 of all echoes are usual: doubted below 0.56
        certainty = sure()
        mixed(certainty, share, 12)
        assert certainty.sure == expected, share
    certainty = sure()
    mixed(certainty, 0.6, 400)
    assert certainty.sure


def test_a_pose_is_doubted_as_soon_after_a_long_time_without_a_misfit():
    after = []
    for fits in (0, 300):
        certainty = sure()
        mixed(certainty, 1.0, fits)
        after.append(0)
        while certainty.sure:
            mixed(certainty, 0.2, 1)
            after[-1] += 1
    assert after[1] <= after[0]


def test_what_is_usual_before_it_is_learnt():
    certainty = Certainty(LocalisationNumbers())
    for share, expected in ((0.5, False), (0.55, True)):    # of 0.7, a place must explain three quarters: 0.525
        assert certainty.accepts(np.arange(100) < 100 * share) == expected, share


def test_a_way_without_an_explained_echo():
    certainty = sure()
    hear(certainty, np.nan, way=TUNED.blind_way + 0.1)
    certainty.judge(spread())
    assert "nothing that I heard" in certainty.reason


def test_a_place_that_was_just_found_must_prove_itself_on_a_way_and_be_unlike_others():
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    for _ in range(TUNED.sure_searches):
        certainty.judge(spread())
        assert "look like this one" in certainty.reason
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    certainty.judge(spread())
    assert "just found" in certainty.reason
    hear(certainty, 1.0, way=TUNED.sure_way + 0.1)
    certainty.compare(TUNED.rival_margin - 0.1, MANY)
    certainty.judge(spread())
    assert "look like this one" in certainty.reason
    for _ in range(TUNED.sure_searches):
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    certainty.judge(spread())
    assert certainty.sure
    certainty.compare(0.0, MANY)
    certainty.judge(spread())
    assert not certainty.sure


@pytest.mark.parametrize("spots, searches, sure", [
    (TUNED.enough_spots, TUNED.upheld_searches, True), (TUNED.enough_spots - 1.0, TUNED.upheld_searches, False),
    (TUNED.enough_spots, TUNED.upheld_searches - 1, False)])
def test_many_spots_that_no_other_place_explains_are_as_good_as_a_way(spots, searches, sure):
    """1015: carried between boxes, it could turn to and fro only. It was right for a minute, and not sure."""
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    for _ in range(searches):
        certainty.compare(2.0 * TUNED.rival_margin + 0.1, spots)
    certainty.judge(spread())
    assert certainty.sure == sure
    certainty.compare(0.1, 1.0)         # the newest readings alone tell of few spots: a robot that is sure stays so
    certainty.judge(spread())
    assert certainty.sure == sure
    certainty.place(trusted=False)      # somewhere else: what other searches said counts no more
    certainty.judge(spread())
    assert not certainty.sure


@pytest.mark.parametrize("one_place, better, sure", [
    (False, TUNED.rival_margin + 0.01, True), (True, TUNED.rival_margin + 0.01, False),
    (True, TUNED.rival_margin_on_the_spot + 0.01, True)])
def test_a_robot_that_has_only_turned_is_more_careful_about_places_that_look_alike(one_place, better, sure):
    """1052: in a corridor it was sure for a minute of the place that looks the other way."""
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    hear(certainty, 1.0, way=TUNED.sure_way + 0.1)
    for _ in range(TUNED.sure_searches):
        certainty.compare(better, MANY, one_place=one_place)
    certainty.judge(spread())
    assert certainty.sure == sure


@pytest.mark.parametrize("told, searches, one_place, settled", [
    (False, 2, True, True), (False, 1, True, False), (True, 2, True, False), (False, 2, False, False)])
def test_searches_settle_where_a_robot_is_that_has_only_turned_and_is_not_sure(told, searches, one_place, settled):
    """5224: one that drove was sure of a wrong place, as its cloud was put where a search said."""
    certainty = Certainty(TUNED)
    certainty.place(trusted=told)
    for _ in range(searches):
        certainty.compare(TUNED.rival_margin_on_the_spot + 0.1, MANY, one_place=one_place)
    assert not certainty.sure and certainty.settled == settled
    certainty.compare(TUNED.rival_margin_on_the_spot - 0.1, MANY, one_place=True)
    assert not certainty.settled


def test_searches_while_it_was_sure_and_those_about_another_place_settle_nothing():
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    hear(certainty, 1.0, way=TUNED.sure_way + 0.1)
    for _ in range(TUNED.sure_searches):
        certainty.compare(TUNED.rival_margin_on_the_spot + 0.1, MANY, one_place=True)
    certainty.judge(spread())
    assert certainty.sure
    for searches in range(2):
        for _ in range(searches):
            certainty.compare(TUNED.rival_margin + 0.1, MANY, one_place=True)
        certainty.doubt()
        assert not certainty.settled
        certainty.judge(spread())
        assert certainty.sure
    certainty.doubt()
    for forget in (lambda: certainty.lose("why"), lambda: certainty.place(trusted=False)):
        for _ in range(TUNED.upheld_searches - 1):
            certainty.compare(TUNED.rival_margin_on_the_spot + 0.1, MANY, one_place=True)
        assert certainty.settled
        forget()
        assert not certainty.settled


def test_a_pose_fits_until_a_reading_speaks_against_it_and_again_when_others_outweigh_that():
    certainty = sure()
    assert certainty.fits
    hear(certainty, 0.0, count=1)
    assert not certainty.fits and not certainty.suspects
    hear(certainty, 1.0)
    assert certainty.fits


@pytest.mark.parametrize("alone", [True, False])
def test_the_search_that_finds_a_place_and_none_like_it_counts(alone):
    certainty = Certainty(TUNED)
    certainty.place(trusted=False, alone=alone)
    hear(certainty, 1.0, way=TUNED.sure_way + 0.1)
    for _ in range(TUNED.sure_searches - 1):
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    certainty.judge(spread())
    assert certainty.sure == alone


def test_a_place_that_a_long_way_has_proven_stays_sure_where_others_look_alike():
    certainty = sure()
    certainty.compare(0.0, MANY)
    certainty.judge(spread())
    assert certainty.sure


def test_what_was_never_sure_is_not_proven_however_long_the_way():
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    for _ in range(30):         # other places look alike, so it is not sure
        hear(certainty, 1.0, way=TUNED.sure_way)
        certainty.judge(spread())
    assert not certainty.sure and not certainty.proven
    for _ in range(TUNED.sure_searches):
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    certainty.judge(spread())
    hear(certainty, 1.0, way=TUNED.proven_way)
    assert certainty.sure and certainty.proven


def test_a_guess_gives_way_to_what_is_a_little_better_and_a_proven_place_does_not_even_in_doubt():
    guess = Certainty(TUNED)
    guess.place(trusted=False)
    assert guess.margin == TUNED.margin_guessed < TUNED.margin < TUNED.margin_proven
    assert sure().margin == doubting().margin == TUNED.margin_proven
    for _ in range(TUNED.sure_searches):
        guess.compare(TUNED.rival_margin + 0.1, MANY)
    hear(guess, 1.0, way=TUNED.sure_way + 0.1)
    guess.judge(spread())
    assert guess.sure and guess.margin == TUNED.margin


def test_the_fewer_spots_were_heard_the_more_caution_there_is():
    least = TUNED.least_spots
    assert [sure().caution(spots) for spots in (3.0 * least, least, least / 1.5, 0.0)] == [1.0, 1.0, 1.5, 2.0]
    guess = Certainty(TUNED)
    guess.place(trusted=False)
    for spots, sure_of_it in ((least / 2.0, False), (least, True)):
        for _ in range(TUNED.sure_searches):
            guess.compare(TUNED.rival_margin + 0.1, spots)
        hear(guess, 1.0, way=TUNED.sure_way + 0.1)
        guess.judge(spread())
        assert guess.sure == sure_of_it


def test_a_doubt_may_be_raised_from_outside():
    """It lasts, though the next echo fits: until searches find no place that is better."""
    certainty = sure()
    certainty.compare(-1.2 * TUNED.margin_proven, TUNED.least_spots / 1.5)
    certainty.doubt()
    assert not certainty.sure and certainty.reason.endswith("other places look like this one")
    hear(certainty, 1.0, count=1)
    certainty.judge(spread())
    assert not certainty.sure and not certainty.on_a_line, "it may drive along no line"
    for _ in range(TUNED.sure_searches):
        certainty.compare(0.1, MANY)
    certainty.judge(spread())
    assert certainty.sure


def test_who_is_told_where_it_is_forgets_the_place_that_explained_more():
    certainty = sure()
    certainty.doubt()
    certainty.place(trusted=True)
    certainty.judge(long_cloud(0.0, 0.6, 0.02))
    assert not certainty.sure and certainty.on_a_line


def test_it_searches_the_less_often_the_better_the_place_is_proven():
    guess = Certainty(TUNED)
    assert guess.search_period == TUNED.period_unsure
    guess.place(trusted=False)
    for _ in range(TUNED.sure_searches):
        guess.compare(TUNED.rival_margin + 0.1, MANY)
    hear(guess, 1.0, way=TUNED.sure_way + 0.1)
    guess.judge(spread())
    assert guess.search_period == TUNED.period_sure
    hear(guess, 1.0, way=TUNED.proven_way)
    assert guess.search_period == TUNED.period_proven
    assert doubting().search_period == TUNED.period_unsure


def test_a_place_that_is_sure_stays_so_beside_one_that_looks_nearly_alike_but_not_beside_a_better_one():
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    for _ in range(TUNED.sure_searches):
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    hear(certainty, 1.0, way=TUNED.sure_way + 0.1)
    for better, expected in ((0.2, True), (0.02, True), (-0.02, False), (0.02, False)):
        certainty.judge(spread())
        certainty.compare(better, MANY)
        certainty.judge(spread())
        assert certainty.sure == expected, better


def test_instead_of_a_guess_a_place_is_accepted_that_explains_as_much_as_the_guess():
    half = np.array([1.0, 0.0])
    certainty = Certainty(TUNED)
    certainty.place(trusted=False)
    assert not certainty.accepts(half)
    for _ in range(25):
        hear(certainty, 0.0)
    assert certainty.accepts(half)
    assert not doubting().accepts(half)


def mixed(certainty, share, packets):
    """Let it hear packets of 10 readings, a share of which is explained."""
    for _ in range(packets):
        hear(certainty, 1.0, count=round(10 * share))
        hear(certainty, 0.0, count=10 - round(10 * share))
        certainty.judge(spread())


def test_what_is_usual_is_learnt():
    certainty = Certainty(replace(TUNED, usual_explained=0.9))
    certainty.place(trusted=True)
    certainty.judge(spread())
    for share in (0.8, 0.7, 0.6):       # an unusual world: reality is often elsewhere than on the map
        mixed(certainty, share, 400)
        assert certainty.sure
    mixed(certainty, 0.5, 100)
    assert certainty.sure


def test_a_little_too_few_explained_readings_make_it_unsure_after_a_while():
    certainty = sure()      # 0.8 of all echoes are usual
    mixed(certainty, 0.5, 15)
    assert certainty.sure
    mixed(certainty, 0.5, 30)
    assert not certainty.sure


def test_another_place_is_accepted_only_if_it_explains_as_much_as_is_usual():
    certainty = sure()      # 0.8 of all echoes are usual
    explained = np.array([1.0, 1.0, 0.0, np.nan])
    assert certainty.accepts(explained) and not certainty.accepts(np.array([1.0, 0.0, 0.0, np.nan]))
    assert not certainty.accepts(np.array([np.nan]))


def doubting():
    """Return a certainty that doubts a place that a person told: half of its echoes are of what is on no map."""
    certainty = sure()
    mixed(certainty, 0.5, 45)
    assert certainty.doubts and not certainty.sure
    return certainty


def test_a_doubted_place_is_upheld_when_no_search_finds_one_like_it():
    certainty = doubting()
    for number in range(TUNED.upheld_searches):
        certainty.judge(spread())
        assert not certainty.sure, "after %d searches" % number
        certainty.compare(0.05, MANY)
    certainty.judge(spread())
    assert certainty.sure
    mixed(certainty, 0.5, 30)
    assert certainty.sure


def test_a_better_place_elsewhere_or_echoes_that_hardly_fit_uphold_nothing():
    certainty = doubting()
    for _ in range(3):
        certainty.compare(0.05, MANY)
        certainty.compare(-0.05, MANY)
    certainty.judge(spread())
    assert not certainty.sure
    mixed(certainty, 0.2, 30)
    for _ in range(9):
        certainty.compare(0.05, MANY)
    certainty.judge(spread())
    assert not certainty.sure


def test_a_place_beside_that_looks_alike_must_be_told_apart_before_a_pose_is_sure():
    """5072: told where it was, beside a box on no map in a corridor, it was sure of a place 0.6 m farther on."""
    certainty = Certainty(TUNED)
    certainty.place(trusted=False, alone=True)
    certainty.compare(1.0, MANY)
    hear(certainty, 1.0, way=TUNED.sure_way)
    certainty.judge(spread())
    assert certainty.sure
    certainty.compare(1.0, MANY, 0.05)
    certainty.judge(spread())
    assert certainty.sure, "it was sure before"
    certainty.place(trusted=True)
    certainty.judge(spread(position=0.6))
    certainty.compare(1.0, MANY, 0.05)
    certainty.judge(spread())
    assert not certainty.sure and "other places look like this one" in certainty.reason
    for _ in range(TUNED.sure_searches):
        assert not certainty.sure
        certainty.compare(1.0, MANY, 0.1)
        certainty.judge(spread())
    assert certainty.sure


def test_the_longer_a_place_has_explained_the_readings_the_better_another_must_be():
    certainty, margins = Certainty(TUNED), []
    certainty.place(trusted=False)
    for _ in range(TUNED.sure_searches):
        certainty.compare(TUNED.rival_margin + 0.1, MANY)
    for _ in range(round((TUNED.proven_way + 0.2) / 0.1)):
        hear(certainty, 1.0, way=0.1)
        certainty.judge(spread())
        margins.append(certainty.margin)
    assert margins == sorted(margins)
    assert margins[0] < TUNED.margin < margins[-1] == TUNED.margin_proven
    rival = certainty.margin
    certainty.compare(-0.01, MANY)      # one that looks alike makes it unsure, unless it is proven; it is not believed
    assert certainty.margin == rival


def test_a_misfit_is_suspected_before_it_is_doubted():
    certainty = sure()
    assert not certainty.suspects
    while not certainty.suspects:
        hear(certainty, 0.0, count=1)
    assert certainty.sure and not certainty.doubts and certainty.search_period == TUNED.period_unsure
    while not certainty.doubts:
        hear(certainty, 0.0, count=1)
    certainty.judge(spread())
    assert not certainty.sure and not certainty.suspects


# Two senses

def test_when_another_sense_judges_what_was_missed_before_counts_no_more():
    certainty = sure()
    hear(certainty, 0.0, count=12)
    assert certainty.suspects
    certainty.change_sense()
    certainty.judge(spread())
    assert certainty.fits and not certainty.suspects and certainty.sure


def test_a_place_that_nothing_has_confirmed_yet_is_not_confirmed_by_another_sense():
    certainty = Certainty(replace(TUNED, told_explained=0.7))
    certainty.place(trusted=True)
    certainty.change_sense()
    certainty.judge(spread())
    assert not certainty.sure and certainty.reason == UNKNOWN + UNCONFIRMED


def test_a_usual_share_that_was_learnt_of_one_sense_says_nothing_of_another():
    certainty = sure()
    for _ in range(400):
        hear(certainty, 0.6)
    assert certainty.sure and certainty._usual < 0.75
    share = certainty.explained / certainty._usual
    certainty.change_sense()
    assert certainty._usual == TUNED.usual_explained
    assert certainty.explained == pytest.approx(share * TUNED.usual_explained)


@pytest.mark.parametrize("evidence, doubts", [(1.0, True), (0.2, False)])
def test_readings_of_which_many_come_at_once_may_count_less(evidence, doubts):
    certainty, zeros = sure(), np.zeros(40)
    certainty.hear(Beams(zeros, zeros, zeros, np.arange(0, 800, 20), np.arange(40)), np.zeros(40), 0.04, 0.04, evidence)
    assert certainty.doubts is doubts

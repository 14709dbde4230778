"""Accelerations that a program borrows, and that are put back when it falls silent."""

import math
from types import SimpleNamespace

import pytest

from pioneer_control.client.tuning import Tuning
from pioneer_control.driver.accelerations import LEGAL, LIFETIME, BorrowedAccelerations
from pioneer_control.errors import RefusedError, UsageError

OWN = Tuning(max_linear_acceleration=0.5, ticks_mm=130)


def wish(**values):
    return SimpleNamespace(**{**dict.fromkeys(LEGAL, 0.0), **values})


@pytest.fixture
def told():
    return []


@pytest.fixture
def borrowed(told):
    return BorrowedAccelerations(OWN, told.append)


def test_what_is_borrowed_goes_over_the_users_own_and_is_put_back(borrowed, told):
    assert borrowed.borrow(wish(linear_deceleration=0.8, angular_acceleration=2.0), "/navigation", 10.0)
    assert told == [Tuning(0.5, 0.8, 2.0, ticks_mm=130)]
    assert borrowed.tick(10.0 + LIFETIME - 0.01) == "" and len(told) == 1
    assert borrowed.tick(10.0 + LIFETIME) == "/navigation" and told[1:] == [OWN]
    assert borrowed.tick(10.0 + 2 * LIFETIME) == "" and len(told) == 2


def test_a_repeated_wish_lives_on_and_is_told_once(borrowed, told):
    for now in range(10):
        assert borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", float(now)) == (now == 0)
        assert borrowed.tick(now + 0.9) == ""
    assert len(told) == 1


def test_another_borrower_waits_until_the_first_is_silent(borrowed, told):
    borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", 0.0)
    with pytest.raises(RefusedError, match="/navigation has borrowed them"):
        borrowed.borrow(wish(linear_deceleration=0.9), "/other", 1.0)
    assert borrowed.borrow(wish(linear_deceleration=0.9), "/other", LIFETIME)
    assert told[-1].max_linear_deceleration == 0.9


def test_the_user_changes_own_settings_meanwhile(borrowed, told):
    borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", 0.0)
    new = Tuning(max_linear_acceleration=0.7)
    borrowed.change_own(new)
    assert told[-1] == Tuning(0.7, 0.8)
    borrowed.tick(LIFETIME)
    assert told[-1] == new


def test_it_says_which_settings_somebody_wished_and_which_the_user(borrowed):
    assert not borrowed.changes("max_linear_deceleration")
    borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", 0.0)
    borrowed.tick(LIFETIME)
    assert borrowed.changes("max_linear_deceleration") and not borrowed.changes("max_linear_acceleration")
    borrowed.change_own(OWN)
    assert not borrowed.changes("max_linear_deceleration")


@pytest.mark.parametrize("field, value", [
    ("linear_deceleration", 0.1), ("linear_deceleration", -0.8), ("linear_acceleration", math.nan),
    ("angular_acceleration", math.inf), ("angular_deceleration", 1.0), ("linear_acceleration", 99.0),
])
def test_what_is_not_legal_is_named_and_changes_nothing(borrowed, told, field, value):
    with pytest.raises(UsageError, match="%s is %s; legal: 0 or a number" % (field, value)):
        borrowed.borrow(wish(**{field: value}), "/navigation", 0.0)
    assert told == [] and borrowed.tick(9.0) == ""


def test_a_robot_that_refuses_is_told_again(told):
    answers = [UsageError("not now"), None]

    def tune(tuning):
        told.append(tuning)
        answer = answers.pop(0)
        if answer:
            raise answer

    borrowed = BorrowedAccelerations(OWN, tune)
    with pytest.raises(UsageError, match="not now"):
        borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", 0.0)
    assert borrowed.borrow(wish(linear_deceleration=0.8), "/navigation", 0.1) and len(told) == 2

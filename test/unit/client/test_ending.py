"""The end of a link: every thread that asks or waits learns of it, once and for all."""

import threading

from pioneer_control.client.threads import Ending

LIMIT = 20.0        # s for what happens at once


def test_nothing_has_ended_before():
    ending = Ending()
    assert not ending.is_set() and not ending.wait(0.0) and not ending.wait(-1.0)


def test_all_who_wait_are_woken_and_later_ones_need_not_wait():
    ending, woken = Ending(), []
    waiting = [threading.Thread(target=lambda: woken.append(ending.wait(LIMIT)), daemon=True) for _ in range(3)]
    for thread in waiting:
        thread.start()
    ending.set()
    ending.set()
    for thread in waiting:
        thread.join(LIMIT)
    assert woken == [True] * 3
    assert ending.is_set() and ending.wait() and ending.wait(0.0)


def test_who_does_not_wait_hears_of_it_while_another_thread_wakes_up():
    ending = Ending()
    ending.set()
    with ending._goes_on:
        assert ending.wait(0.0)

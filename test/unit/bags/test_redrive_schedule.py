"""Which commands another robot gets, and when. Pure, with made-up messages."""

import math
from types import SimpleNamespace

import pytest

from pioneer_control.bags.replaying.redrive_schedule import REFRESH, VALID, HelmThen, Order, obeyed, schedule, slowed


def twist(linear, angular=0.0):
    """Return a message with the fields of geometry_msgs/Twist."""
    return SimpleNamespace(linear=SimpleNamespace(x=linear, y=0.0, z=0.0),
                           angular=SimpleNamespace(x=0.0, y=0.0, z=angular))


def driven(times, linear=0.2):
    """Return one velocity at each of some times."""
    return [Order(time, "cmd_vel", twist(linear)) for time in times]


def velocity(order):
    return order.message.linear.x


def told_at(orders, time):
    """Return the velocity that is in effect at a time: the last one that was sent."""
    return velocity([order for order in orders if order.time <= time][-1])


class TestIntervals:
    def test_as_recorded_from_zero_on(self):
        times = [100.0, 100.1, 100.23, 100.3]
        orders = schedule(driven(times))
        assert [order.time for order in orders[:4]] == pytest.approx([0.0, 0.1, 0.23, 0.3])
        assert {velocity(order) for order in orders[:4]} == {0.2}

    def test_whatever_else_is_told_keeps_its_place(self):
        open_it, motors = object(), object()
        told = [Order(9.0, "cmd_motor_state", motors), *driven([10.0, 10.1]), Order(10.05, "gripper_control", open_it)]
        orders = schedule(told)
        assert [order.message for order in orders if order.topic != "cmd_vel"] == [motors, open_it]
        assert [order.time for order in orders if order.topic != "cmd_vel"] == pytest.approx([0.0, 1.05])

    def test_what_came_together_stays_in_its_order(self):
        told = [Order(1.0, "gripper_control", number) for number in range(5)]
        assert [order.message for order in schedule(told)] == [0, 1, 2, 3, 4]

    def test_a_recorder_may_have_them_in_another_order(self):
        assert [order.time for order in schedule(driven([2.0, 1.0]))][0] == 0.0

    def test_of_two_velocities_at_once_both_are_said_and_the_second_holds(self):
        orders = schedule(driven([1.0], 0.1) + driven([1.0], 0.3))
        assert [velocity(order) for order in orders[:2]] == [0.1, 0.3] and told_at(orders, 0.5) == 0.3

    @pytest.mark.parametrize("strange", [math.nan, math.inf, -math.inf])
    def test_what_is_no_number_is_left_out(self, strange):
        wheels = [Order(0.0, "cmd_wheels", SimpleNamespace(left=left, right=right))
                  for left, right in ((strange, 0.1), (0.1, strange))]
        twists = [Order(0.0, "cmd_vel", twist(strange, 0.1)), Order(0.0, "cmd_vel", twist(0.1, strange))]
        assert schedule(wheels + twists) == []

    def test_nothing_was_told(self):
        assert schedule([]) == []


class TestSlower:
    def test_slower_and_longer_so_that_the_path_stays(self):
        orders = schedule(driven([0.0, 0.1, 0.2]), factor=0.25)
        assert {velocity(order) for order in orders} == {0.05, 0.0}
        way = sum(velocity(one) * (other.time - one.time) for one, other in zip(orders, orders[1:]))
        assert way == pytest.approx(0.2 * (0.2 + VALID))
        assert orders[-1].time == pytest.approx((0.2 + VALID) / 0.25)

    def test_the_driver_never_takes_it_for_old(self):
        orders = schedule(driven([0.0, 0.5, 1.0]), factor=0.1)
        assert max(other.time - one.time for one, other in zip(orders, orders[1:])) <= REFRESH + 1e-9

    def test_what_was_recorded_is_not_touched(self):
        told = driven([0.0])
        schedule(told, factor=0.5)
        assert velocity(told[0]) == 0.2

    def test_wheels(self):
        assert vars(slowed(SimpleNamespace(left=0.2, right=-0.1), 0.5)) == {"left": 0.1, "right": -0.05}

    def test_turns(self):
        assert slowed(twist(0.2, 1.0), 0.5).angular.z == 0.5

    def test_in_every_direction(self):
        linear, angular = SimpleNamespace(x=0.2, y=0.4, z=0.6), SimpleNamespace(x=2.0, y=4.0, z=6.0)
        made = slowed(SimpleNamespace(linear=linear, angular=angular), 0.5)
        assert vars(made.linear) == {"x": 0.1, "y": 0.2, "z": 0.3}
        assert vars(made.angular) == {"x": 1.0, "y": 2.0, "z": 3.0}


class TestDeadman:
    """A velocity is in effect no longer than it was for the recorded robot."""

    @pytest.mark.parametrize("factor", [1.0, 0.25])
    def test_after_the_last_one_the_robot_is_stopped(self, factor):
        orders = schedule(driven([0.0, 0.1]), factor)
        assert velocity(orders[-1]) == 0.0
        assert orders[-1].time == pytest.approx((0.1 + VALID) / factor)
        assert all(velocity(order) != 0.0 for order in orders[:-1])

    @pytest.mark.parametrize("factor", [1.0, 0.25])
    def test_a_pause_is_a_pause(self, factor):
        orders = schedule(driven([0.0, 5.0]), factor)
        assert told_at(orders, (VALID - 0.01) / factor) == 0.2 * factor
        assert told_at(orders, (VALID + 0.01) / factor) == 0.0
        assert told_at(orders, 4.99 / factor) == 0.0
        assert told_at(orders, 5.01 / factor) == 0.2 * factor

    def test_one_that_is_just_in_time_is_no_pause(self):
        assert 0.0 not in [velocity(order) for order in schedule(driven([0.0, VALID]))[:-1]]

    @pytest.mark.parametrize("valid", [0.1, 2.0])
    def test_the_recorded_drivers_own_limit_counts(self, valid):
        orders = schedule(driven([0.0, 0.9 * valid, 2.5 * valid]), valid=valid)
        assert [order.time for order in orders if velocity(order) == 0.0] == pytest.approx([1.9 * valid, 3.5 * valid])

    def test_either_kind_of_velocity_ends_the_other(self):
        told = [Order(0.0, "cmd_vel", twist(0.2)), Order(0.3, "cmd_wheels", SimpleNamespace(left=0.0, right=0.0))]
        assert [order.topic for order in schedule(told) if order.time >= 0.3 - 1e-9][0] == "cmd_wheels"
        assert not [order for order in schedule(told) if order.topic == "cmd_vel" and order.time > 0.3]


class TestObeyed:
    """What a program was told is left out while a person had the helm, and what the person was told comes instead."""

    stop = twist(0.0)
    helm = [HelmThen(0.0, False, False), HelmThen(2.0, True, False), HelmThen(4.0, False, False),
            HelmThen(6.0, False, True), HelmThen(8.0, False, False)]

    def told(self, topic):
        return [Order(float(time), topic, time) for time in range(10)]

    def passed(self, topic, helm=helm):
        return [order.time for order in obeyed(self.told(topic), helm, self.stop)]

    @pytest.mark.parametrize("topic", ["cmd_vel", "cmd_wheels", "gripper_control"])
    def test_programs(self, topic):
        assert self.passed(topic) == [0, 1, 4, 5, 8, 9]

    def test_a_person(self):
        assert self.passed("teleop/cmd_vel") == [0, 1, 2, 3, 4, 5, 8, 9]
        assert {order.topic for order in obeyed(self.told("teleop/cmd_vel"), self.helm, self.stop)} == {"cmd_vel"}

    def test_motors_are_switched_by_anybody(self):
        assert self.passed("cmd_motor_state") == list(range(10))

    def test_a_lock_stops_and_its_end_moves_nothing(self):
        locks = [Order(time, "stop_all", SimpleNamespace(data=on)) for time, on in ((1.0, True), (2.0, False))]
        assert obeyed(locks, self.helm, self.stop) == [Order(1.0, "cmd_vel", self.stop)]

    def test_all_counts_in_a_bag_that_does_not_tell_who_had_the_helm(self):
        assert self.passed("cmd_vel", []) == list(range(10))

"""When to say what, so that another robot is told what the recorded one was told: in its order, at its intervals, slower if wanted. Pure.

A velocity counted for the recorded robot until the next one came, but no longer than `VALID`: then its driver stopped it. So it
does here. Slowed down by k, velocities are k times as fast and everything lasts 1/k as long, which keeps the path; a driver would take a
velocity that lasts so long for old, so it is said again and again, for as long as it counted and no longer.
"""

import copy
import math
from typing import Any, Iterable, Iterator, List, NamedTuple

VELOCITIES = "cmd_vel", "cmd_wheels"
OTHERS = "cmd_motor_state", "gripper_control"

VALID = 0.6  # s: the driver's default for cmd_vel_timeout
LEGAL_VALID = 0.1, 2.0  # s: what it may be
REFRESH = 0.2  # s between two times that one velocity is said


class Order(NamedTuple):
    """Something a robot is told: when (s from the first), on which topic (its last name), and the message."""

    time: float
    topic: str
    message: Any


def schedule(told: Iterable[Order], factor: float = 1.0, valid: float = VALID, refresh: float = REFRESH) -> List[Order]:
    """The orders to give, from time 0 on, of those that were recorded, in whatever order. ``factor`` is the k above, more than 0.

    Velocities that are no numbers are left out: a driver refuses them.
    """
    told = sorted((order for order in told if order.topic not in VELOCITIES or _is_finite(order.message)), key=lambda order: order.time)
    if not told:
        return []
    begin = told[0].time
    velocities = [order for order in told if order.topic in VELOCITIES]
    orders = [order._replace(time=(order.time - begin) / factor) for order in told if order.topic not in VELOCITIES]
    for order, following in zip(velocities, velocities[1:] + [None]):
        ends = order.time + valid if following is None else min(order.time + valid, following.time)
        said = Order((order.time - begin) / factor, order.topic, slowed(order.message, factor))
        orders += _repeated(said, (ends - begin) / factor, refresh)
        if following is None or following.time - order.time > valid:
            orders.append(Order((ends - begin) / factor, order.topic, slowed(order.message, 0.0)))
    return sorted(orders, key=lambda order: order.time)  # stable: what came together stays in its order


def slowed(message: Any, factor: float) -> Any:
    """A Twist or WheelVelocities, so many times as fast."""
    result = copy.deepcopy(message)
    if hasattr(result, "left"):
        result.left, result.right = factor * result.left, factor * result.right
        return result
    for part in (result.linear, result.angular):
        part.x, part.y, part.z = factor * part.x, factor * part.y, factor * part.z
    return result


def fastest(orders: Iterable[Order]) -> float:
    """The highest speed, m/s, that a robot is told; of a turn on the spot 0."""
    return max((_speed(order.message) for order in orders if order.topic in VELOCITIES), default=0.0)


def duration(orders: List[Order]) -> float:
    """Seconds from the first order to the last."""
    return orders[-1].time if orders else 0.0


def _repeated(order: Order, end: float, refresh: float) -> Iterator[Order]:
    """An order, and again until before it ends."""
    number = 0
    while number == 0 or order.time + number * refresh < end - 1e-9:
        yield order._replace(time=order.time + number * refresh)
        number += 1


def _is_finite(message: Any) -> bool:
    if hasattr(message, "left"):
        return math.isfinite(message.left) and math.isfinite(message.right)
    return all(math.isfinite(value) for part in (message.linear, message.angular) for value in (part.x, part.y, part.z))


def _speed(message: Any) -> float:
    return max(abs(message.left), abs(message.right)) if hasattr(message, "left") else abs(message.linear.x)

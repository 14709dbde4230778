"""When to say what, so that a robot is told what the recorded one was told, slower if wanted. Pure.

Order and intervals are the recorded ones. For the recorded robot a velocity held until the next one came, but no
longer than `VALID`: then its driver stopped it. The same holds here. With a factor k, velocities are k times as fast
and everything lasts 1/k as long, which keeps the path. A driver stops a robot when a velocity grows old, so each
velocity is repeated for as long as it holds, and no longer.
"""

import copy
import math
from typing import Any, Iterable, List, NamedTuple

VELOCITIES = "cmd_vel", "cmd_wheels"

VALID = 0.6
"""s: the driver's default for cmd_vel_timeout."""
LEGAL_VALID = 0.1, 2.0
"""s: the least and the greatest cmd_vel_timeout."""
REFRESH = 0.2
"""s between two repetitions of a velocity."""


class Order(NamedTuple):
    """Something that a robot is told."""

    time: float
    """when, s"""
    topic: str
    """its last name"""
    message: Any


def schedule(told: Iterable[Order], factor: float = 1.0, valid: float = VALID) -> List[Order]:
    """The orders to give, in order of time, from time 0 on.

    Velocities that are not finite numbers are left out: a driver refuses them.

    Args:
        told: recorded orders, in whatever order.
        factor: the k above, more than 0.
        valid: s for which a velocity holds.
    """
    told = sorted((order for order in told if order.topic not in VELOCITIES or _is_finite(order.message)),
                  key=lambda order: order.time)
    begin = told[0].time if told else 0.0
    velocities = [order for order in told if order.topic in VELOCITIES]
    orders = [order._replace(time=(order.time - begin) / factor) for order in told if order.topic not in VELOCITIES]
    for order, following in zip(velocities, velocities[1:] + [None]):
        ends = order.time + valid if following is None else min(order.time + valid, following.time)
        said = Order((order.time - begin) / factor, order.topic, slowed(order.message, factor))
        repeats = max(1, math.ceil(((ends - begin) / factor - 1e-9 - said.time) / REFRESH))
        orders += [said._replace(time=said.time + number * REFRESH) for number in range(repeats)]
        if following is None or following.time - order.time > valid:
            orders.append(Order((ends - begin) / factor, order.topic, slowed(order.message, 0.0)))
    return sorted(orders, key=lambda order: order.time)  # stable: what came together stays in its order


def slowed(message: Any, factor: float) -> Any:
    """A Twist or WheelVelocities that is `factor` times as fast as another."""
    result = copy.deepcopy(message)
    if hasattr(result, "left"):
        result.left, result.right = factor * result.left, factor * result.right
    else:
        for part in (result.linear, result.angular):
            part.x, part.y, part.z = factor * part.x, factor * part.y, factor * part.z
    return result


def _is_finite(message: Any) -> bool:
    """Whether all numbers of a Twist or WheelVelocities are finite."""
    numbers = ((message.left, message.right) if hasattr(message, "left") else
               [value for part in (message.linear, message.angular) for value in (part.x, part.y, part.z)])
    return all(map(math.isfinite, numbers))

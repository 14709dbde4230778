"""When a re-drive sends which command, so that a robot drives the recorded path, slower if wanted. Pure functions.

The commands keep their order and their intervals. The driver of the recorded robot obeyed a velocity until the next
one came, but no longer than its time-out (`VALID`): then it stopped the robot. The schedule stops the robot at the same
moments. With a speed factor k, velocities are k times as fast and intervals 1/k times as long, which keeps the path.
The driver of the simulated robot has a time-out too. So the schedule repeats each velocity for as long as it was valid.
"""

import copy
import math
from typing import Any, Iterable, List, NamedTuple, Sequence

VELOCITIES = "cmd_vel", "cmd_wheels"
BY_HAND = {"teleop/cmd_vel": "cmd_vel", "teleop/gripper_control": "gripper_control"}
"""The topics of a person, and the topics of a program on which a re-drive sends their commands."""
PROGRAMS = (*VELOCITIES, "gripper_control")
"""The topics from which programs are locked out while a person has the helm."""

VALID = 0.6
"""The driver's default for its parameter cmd_vel_timeout (s)."""
LEGAL_VALID = 0.1, 2.0
"""The least and the greatest legal value of the driver's parameter cmd_vel_timeout (s)."""
REFRESH = 0.2
"""The time between two repetitions of a velocity (s)."""


class HelmThen(NamedTuple):
    """Who might command from a moment on, as the recorded driver said."""

    time: float
    """The time in the bag (s)."""
    programs_locked_out: bool
    locked: bool


class Order(NamedTuple):
    """A command to a robot, with its time and its topic."""

    time: float
    """The time at which the command was recorded, or is to be sent (s)."""
    topic: str
    """The last name of the topic."""
    message: Any


def obeyed(told: Iterable[Order], helm: Sequence[HelmThen], stop: Any) -> List[Order]:
    """Return the commands that the recorded driver let through, as if one program had given them all.

    Commands of a person come on the topic of a program. Commands of programs that were locked out, and all under a
    lock but those for motors, are left out. A lock is a stop.

    Args:
        told: the recorded commands, in any order.
        helm: who might command, in order of time. Empty if the bag does not tell: then all commands count.
        stop: the message on cmd_vel that stops a robot.
    """
    passed = []
    for order in told:
        then = ([each for each in helm if each.time <= order.time] or [HelmThen(0.0, False, False)])[-1]
        if order.topic == "stop_all":
            passed += [Order(order.time, "cmd_vel", stop)] * bool(order.message.data)
        elif order.topic == "cmd_motor_state" or not (
                then.locked or then.programs_locked_out and order.topic in PROGRAMS):
            passed.append(order._replace(topic=BY_HAND.get(order.topic, order.topic)))
    return passed


def schedule(told: Iterable[Order], factor: float = 1.0, valid: float = VALID) -> List[Order]:
    """Return the commands that a re-drive sends, in order of time. The first one has the time 0 s.

    Velocities that are not finite numbers are left out, because a driver refuses them.

    Args:
        told: the recorded commands, in any order.
        factor: the speed factor, more than 0. 0.5 means half as fast, and twice as long.
        valid: the time for which the recorded driver obeyed a velocity (s).
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
    return sorted(orders, key=lambda order: order.time)  # stable: commands with equal times keep their order


def slowed(message: Any, factor: float) -> Any:
    """Return a copy of a Twist or WheelVelocities in which all velocities are multiplied by `factor`."""
    result = copy.deepcopy(message)
    if hasattr(result, "left"):
        result.left, result.right = factor * result.left, factor * result.right
    else:
        for part in (result.linear, result.angular):
            part.x, part.y, part.z = factor * part.x, factor * part.y, factor * part.z
    return result


def _is_finite(message: Any) -> bool:
    """Return whether all velocities in a Twist or WheelVelocities are finite numbers."""
    numbers = ((message.left, message.right) if hasattr(message, "left") else
               [value for part in (message.linear, message.angular) for value in (part.x, part.y, part.z)])
    return all(map(math.isfinite, numbers))

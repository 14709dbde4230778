"""The teacher's orders in the simulator's words (docs/simulator.md). Pure.

>>> simulator_order(ResetOrder(7))
('reset', 7, {})
"""

from typing import Any, Callable, Dict, Mapping, Optional, Tuple

from .orders import (ALL, BeginTaskOrder, ClearFaultsOrder, EndTaskOrder, FaultOrder, PauseOrder, ResetOrder,
                     RobotOrAll, SimulatorOrder, SpeedOrder, TaskOrder)

Words = Tuple[str, Optional[int], Dict[str, Any]]
"""The name of an order, the page's number of the robot that it is for (None: none, or all), and its other values."""


def simulator_order(order: SimulatorOrder) -> Words:
    """Return an order in the simulator's words."""
    return WORDS[type(order)](order)


def _one(robot: RobotOrAll) -> Optional[int]:
    return None if robot == ALL else int(robot)


WORDS: Mapping[type, Callable[[Any], Words]] = {
    PauseOrder: lambda order: ("pause" if order.on else "go_on", None, {}),
    SpeedOrder: lambda order: ("speed", None, {"speed": order.speed}),
    ResetOrder: lambda order: ("reset", _one(order.robot), {}),
    FaultOrder: lambda order: ("add_fault", _one(order.robot), {"fault": order.words}),
    ClearFaultsOrder: lambda order: ("clear_faults", None, {}),
    TaskOrder: lambda order: ("task", None, {"name": order.name}),
    BeginTaskOrder: lambda order: ("begin_task", None, {}),
    EndTaskOrder: lambda order: ("end_task", None, {}),
}
"""For each type of order, what says it in the simulator's words."""
CARRYING = (ResetOrder, TaskOrder, BeginTaskOrder)
"""The orders that carry robots to other places."""

"""The orders of other programs to the simulator: how they are written, what is legal, and what each of them does.

An order is one JSON object: ``{"id": 7, "order": "put", "robot": 2, "pose": [1.5, 2.0, 0.0]}``. This file uses no
socket, no thread and no real time.
"""

import json
from typing import Any, Callable, Dict, Iterable, Mapping, NamedTuple, Optional, Tuple, Union

from ...errors import ParameterError
from ...parameters import Number, Numbers, Switch, Text, Whole, nearest
from ..line import LineSimulation, fault_of
from ..line.pace import SPEEDS, Pace
from ..simulation import Simulation
from ..tasks import Referee
from ..world.poses import Pose
from .state import Message
from .visit import LONGEST_LINE

EXAMPLE = '{"id": 1, "order": "pause"}'
MOST_FAULTS = 100
"""Largest number of present and future faults. More of them would slow down all robots."""
LONGEST_WORDS = 200
"""Largest number of characters of a fault, of an id, and of a value in an error message."""
LARGEST_ID = 2 ** 53
"""Largest whole number that is legal as an id: beyond it, programs that use floating point would confuse two ids."""
FARTHEST = 1e6
"""Largest coordinate (m) and heading (rad) to which a robot can be put."""

Id = Union[int, str, None]


class ShortText(NamedTuple):
    """Checks a text that is not too long. It may be empty only if `empty`."""

    empty: bool = False

    @property
    def legal(self) -> str:
        """The description of the legal texts, for people."""
        return "a text of %d to %d characters" % (not self.empty, LONGEST_WORDS)

    def accept(self, value: Any) -> str:
        """Return the text unchanged. Raise ValueError if it is not legal."""
        text = Text(self.empty).accept(value)
        if len(text) > LONGEST_WORDS:
            raise ValueError
        return text


class OrderId(NamedTuple):
    """Checks the id of an order, which is repeated in the answer. None is legal: an order needs no id."""

    legal: str = "a whole number, or a text of 1 to %d characters" % LONGEST_WORDS

    def accept(self, value: Any) -> Id:
        """Return the id unchanged. Raise ValueError if it is not legal."""
        if isinstance(value, str):
            return ShortText().accept(value)
        return None if value is None else Whole(-LARGEST_ID, LARGEST_ID).accept(value)


class OrderKind(NamedTuple):
    """A kind of order: a row of the table `Orders.table`.

    `act` carries out the order, and returns a sentence about what it did. `meaning` tells people what it does. `needs`
    and `may` are the objects that check its values, by their names: those that must be given, and those that may be
    left out.
    """

    act: Callable[..., str]
    meaning: str
    needs: Mapping[str, Any] = {}
    may: Mapping[str, Any] = {}


class Request(NamedTuple):
    """An order that was read from a line. `problem` says why it is not legal, and is empty if it is legal."""

    id: Id
    name: str = ""
    values: Mapping[str, Any] = {}
    problem: str = ""


TOO_LONG = Request(None, problem="a line has more than %d bytes: send shorter lines" % LONGEST_LINE)
"""What is read from a line that is too long."""


class Orders:
    """Obeys the orders of other programs.

    Args:
        simulation: the robots and their world, before any time has passed.
        lines: the same robots, with their lines and faults.
        pace: the pace of the simulated time.
        referee: carries robots, and runs the tasks.
    """

    def __init__(self, simulation: Simulation, lines: LineSimulation, pace: Pace, referee: Referee):
        self._robots, self._lines, self._pace = simulation.robots, lines, pace
        self._carrier = referee.carrier
        self.table = self._table(referee)
        """All kinds of orders, by their names."""

    def _table(self, referee: Referee) -> Dict[str, OrderKind]:
        robot = {"robot": Whole(1, len(self._robots))}
        pose = {"pose": Numbers(3, -FARTHEST, FARTHEST)}
        return {
            "pause": OrderKind(self._pause, "simulated time stands still"),
            "go_on": OrderKind(self._go_on, "simulated time passes again"),
            "speed": OrderKind(self._set_speed, "simulated seconds in a real one", {"speed": Number(*SPEEDS)}),
            "reset": OrderKind(
                self._reset, "the robot is carried back to where it began, with the cans that it holds; without `robot`"
                " all robots and all cans are carried back", may=robot),
            "put": OrderKind(
                self._put, "the robot is carried to this pose (m, m, rad; map frame), unless it would overlap something"
                " there", {**robot, **pose}),
            "stop_button": OrderKind(
                self._press, "the robot's STOP button is pressed, or released", {**robot, "pressed": Switch()}),
            "add_fault": OrderKind(
                self._add_fault, "a fault in words, as after `--fault`; its times count from now",
                {"fault": ShortText()}),
            "clear_faults": OrderKind(self._clear_faults, "all faults end, also those to come"),
            "task": OrderKind(
                referee.choose, "a task is chosen, and ready: all robots are carried to their starts in its arena, and"
                " its cans are put out; with the name `\"\"` all robots and cans are carried back to the world",
                {"name": ShortText(empty=True)}),
            "begin_task": OrderKind(
                referee.begin, "the chosen task begins: robots and cans are carried to their starts again"),
            "end_task": OrderKind(referee.end, "the task that runs is over"),
        }

    def read(self, line: bytes) -> Request:
        """Read an order from a line, and check it. Only `answer` needs the robots."""
        try:
            given = json.loads(line.decode("utf-8"))
        except (ValueError, RecursionError) as error:
            return Request(None, problem="this is not JSON in UTF-8 (%s): send one JSON object in each line, such as %s"
                           % (clipped(str(error)), EXAMPLE))
        if not isinstance(given, dict):
            return Request(None, problem="%s is no order: send a JSON object, such as %s" % (shown(given), EXAMPLE))
        try:
            answer_to: Id = _accepted("id", given.pop("id", None), OrderId())
        except ParameterError as error:
            return Request(None, problem=str(error))
        try:
            return Request(answer_to, *self._checked(given))
        except ParameterError as error:
            return Request(answer_to, problem=str(error))

    def answer(self, request: Request) -> Message:
        """Carry out an order if it is legal, and return the answer to it."""
        problem = request.problem
        try:
            text = problem or self.table[request.name].act(**request.values)
        except ParameterError as error:
            text = problem = str(error)
        return {"answer": request.id, "ok": not problem, "text": clipped(text, 3 * LONGEST_WORDS)}

    def _checked(self, given: Mapping[str, Any]) -> Tuple[str, Dict[str, Any]]:
        """Return the name of an order and its values.

        Raises:
            ParameterError: the order is not legal.
        """
        name = given.get("order")
        if not isinstance(name, str) or name not in self.table:
            raise ParameterError("no order %s; %s" % (shown(name), _known(name, self.table)))
        order = self.table[name]
        legal = {**order.needs, **order.may}
        for key in given:
            if key != "order" and key not in legal:
                raise ParameterError("%s has no %s; %s" % (name, shown(key), _known(key, ["id", "order", *legal])))
        missing = [key for key in order.needs if key not in given]
        if missing:
            raise ParameterError("%s needs %s: %s" % (name, missing[0], order.needs[missing[0]].legal))
        return name, {key: _accepted(key, given[key], kind) for key, kind in legal.items() if key in given}

    # -- what each order does

    def _pause(self) -> str:
        self._pace.paused = True
        return "simulated time stands at %.3f s" % self._lines.time

    def _go_on(self) -> str:
        self._pace.paused = False
        return "simulated time passes"

    def _set_speed(self, speed: float) -> str:
        self._pace.speed = speed
        return "%g simulated seconds in a real one" % speed

    def _reset(self, robot: Optional[int] = None) -> str:
        if robot is None:
            self._carrier.reset_all()
            return "all robots and cans are where they began"
        self._carrier.reset(robot)
        return "robot %d is where it began" % robot

    def _put(self, robot: int, pose: Pose) -> str:
        self._carrier.put(robot, pose)
        return "robot %d is at x %g, y %g, heading %g" % (robot, *pose)

    def _press(self, robot: int, pressed: bool) -> str:
        self._robots[robot - 1].press_stop_button(pressed)
        return "the STOP button of robot %d is %s" % (robot, "pressed" if pressed else "released")

    def _add_fault(self, fault: str) -> str:
        faults = self._lines.faults
        if len(faults.told(0)) >= MOST_FAULTS:
            raise ParameterError("there are %d faults already: clear them first" % MOST_FAULTS)
        added = fault_of(fault)
        faults.add(added, self._lines.clock.now_us)
        return added.announcement

    def _clear_faults(self) -> str:
        return "%d ended" % self._lines.faults.clear(self._lines.clock.now_us)


def clipped(text: str, length: int = LONGEST_WORDS) -> str:
    """Return a text, or its beginning if it has more than `length` characters."""
    return text if len(text) <= length else text[:length] + "..."


def shown(value: Any) -> str:
    """Return a value for an error message, as it is written in JSON. What is long or deep is cut short."""
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list) and (len(value) > 9 or any(isinstance(each, (dict, list)) for each in value)):
        return "a list"
    return clipped(json.dumps(value))


def _accepted(name: str, value: Any, kind: Any) -> Any:
    """Return a value if it is legal.

    Raises:
        ParameterError: `kind`, an object that checks values, does not accept it.
    """
    try:
        return kind.accept(value)
    except ValueError:
        raise ParameterError("%s %s is not legal: give %s" % (name, shown(value), kind.legal)) from None


def _known(name: Any, known: Iterable[str]) -> str:
    """Return the known names for an error message about an unknown name."""
    near = nearest(name[:LONGEST_WORDS], known) if isinstance(name, str) else None
    return ("did you mean %r? " % near if near else "") + "there are " + ", ".join(known)

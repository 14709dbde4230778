"""What the simulator tells at its socket of the truth: world, cans, faults, tasks. Takes orders to it, too.

docs/simulator.md has the protocol of this socket.

`Truth` is pure: bytes in, texts of the page's protocol out. `TruthLine` has the socket.
"""

import contextlib
import itertools
import json
import math
import socket
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from ..errors import RefusedError
from .backend import Pose, TextFeed
from .trail import JUMP

RETRY = 0.5             # s between two attempts to connect
LONGEST_LINE = 2 ** 24  # bytes
READ_SIZE = 65536
MOST_ORDERS = 100       # that wait for answers


def origin_of(origin: Sequence[float], base: Pose) -> List[float]:
    """Return where in the map the odometry of a client begins.

    Args:
        origin: where in the map the robot's own odometry begins. It begins anew with each session of the robot.
        base: the client's pose at the begin of this session: its odometry goes on.
    """
    x, y, heading = origin
    back = heading - base[2]
    cos, sin = math.cos(back), math.sin(back)
    return [round(x - cos * base[0] + sin * base[1], 4), round(y - sin * base[0] - cos * base[1], 4),
            round(math.remainder(back, 2 * math.pi), 5)]


class Truth:
    """Reads the lines of the simulator, and makes texts of the page's protocol of them.

    Args:
        numbers: the page's numbers of the robots, by their TCP ports. Other robots are not shown.
        base: returns the pose at which the session of a robot began, by its number: see origin_of().
    """

    def __init__(self, numbers: Mapping[int, int], base: Callable[[int], Pose]) -> None:
        self._numbers, self._base = numbers, base
        self._data = b""
        self._robots: List[Optional[int]] = []      # for each robot of the simulator its number for the page
        self._told: Dict[str, Any] = {}
        self._places: List[Any] = []                # where the robots were before
        self.carried: List[int] = []
        """The page's numbers of robots that somebody has carried farther than JUMP."""
        self.answers: List[Tuple[Any, bool, str]] = []
        """Answers to orders that have come: the id of the order, whether it was done, a sentence."""

    def number_of(self, robot: int) -> Optional[int]:
        """Return the simulator's number of a robot of the page; None if it has none."""
        return self._robots.index(robot) + 1 if robot in self._robots else None

    def receive(self, data: bytes) -> List[Tuple[str, Any]]:
        """Take bytes of the simulator. Returns the texts that changed: kind and value.

        "tasks" is a list of name and title of all tasks. In "task" all robots of the page are ranked, without names.

        Raises:
            ValueError, TypeError, LookupError: this is not what a simulator says.
        """
        *lines, self._data = (self._data + data).split(b"\n")
        if len(self._data) > LONGEST_LINE:
            raise ValueError("a line is longer than %d bytes" % LONGEST_LINE)
        found: Dict[str, Any] = {}
        for line in lines:
            message = json.loads(line.decode())
            if "world" in message:
                found.update(self._take_world(message["world"]))
            elif "truth" in message:
                found.update(self._take_truth(message["truth"]))
            elif "answer" in message:
                self.answers.append((message["answer"], bool(message["ok"]), str(message["text"])))
        changed = [(kind, value) for kind, value in found.items()
                   if kind not in self._told or value != self._told[kind]]
        self._told.update(changed)
        return changed

    def _take_world(self, world: Mapping[str, Any]) -> Dict[str, Any]:
        ports = [(robot["url"] or "").rpartition(":")[2] for robot in world["robots"]]
        self._robots = [self._numbers.get(int(port)) if port else None for port in ports]
        shown = {name: world[name] for name in ("name", "bounds", "walls", "boxes", "posts", "places")}
        for kind, unmapped in world.get("unmapped", {}).items():
            shown[kind] = shown[kind] + unmapped
        can = {"can": {"radius": world["cans"][0][0]}} if world["cans"] else {}
        tasks = {"tasks": world["tasks"]} if "tasks" in world else {}
        return {"world": {**shown, **can}, **tasks}

    def _take_truth(self, truth: Mapping[str, Any]) -> Dict[str, Any]:
        time = {"time": {"paused": truth["paused"], "speed": truth["speed"]}} if "paused" in truth else {}
        faults = {"faults": truth["faults"]} if "faults" in truth else {}
        task = {"task": self._task_of(truth["task"])} if "task" in truth else {}
        self._see_carried(truth["robots"])
        return {
            **time, **faults, **task,
            "origins": {str(number): origin_of(origin, self._base(number))
                        for number, origin in zip(self._robots, truth["origins"]) if number is not None},
            "cans": [[round(each, 2) for each in can[:3]] for can in truth["cans"]],
        }

    def _see_carried(self, places: Sequence[Any]) -> None:
        """Compare the robots' true poses with those before."""
        self.carried += [number for number, (x, y, *_), (was_x, was_y, *_) in zip(self._robots, places, self._places)
                         if number is not None and math.hypot(x - was_x, y - was_y) > JUMP]
        self._places = list(places)

    def _task_of(self, task: Optional[Mapping[str, Any]]) -> Optional[Dict[str, Any]]:
        """Return the task with its ranking, best first."""
        if task is None:
            return None
        ranking = [{"robot": number, "who": "", "points": points, "note": note}
                   for number, (points, note) in zip(self._robots, task["scores"]) if number is not None]
        ranking.sort(key=lambda entry: (-entry["points"], entry["robot"]))
        shown = {name: task[name] for name in ("name", "title", "text", "state", "clock", "limit")}
        return {**shown, "ranking": ranking}


class TruthLine:
    """The connection to the socket of the truth, which is made anew when it breaks.

    Args:
        path: the path of the socket.
        numbers, base: see Truth.
        feed: takes the texts.
        carried: called with the number of a robot that somebody has carried.
    """

    def __init__(self, path: str, numbers: Mapping[int, int], base: Callable[[int], Pose], feed: TextFeed,
                 carried: Callable[[int], None] = lambda number: None) -> None:
        self._path, self._numbers, self._base, self._feed, self._carried = path, numbers, base, feed, carried
        self._truth = Truth(numbers, base)
        self._socket: Optional[socket.socket] = None
        self._retry_at = -math.inf
        self._orders: Dict[int, Callable[[bool, str], None]] = {}
        self._ids = itertools.count(1)

    def order(self, name: str, robot: Optional[int], values: Mapping[str, Any],
              answer: Callable[[bool, str], None]) -> None:
        """Send an order to the simulator: see docs/simulator.md.

        Args:
            name: the order.
            robot: the page's number of the robot that it is for; None for none, or all.
            values: its other values.
            answer: called by turn() with whether it was done, and a sentence for people.

        Raises:
            RefusedError: there is no simulator, it is not its robot, or too many orders wait.
        """
        number = None if robot is None else self._truth.number_of(robot)
        if self._socket is None or len(self._orders) >= MOST_ORDERS:
            raise RefusedError("the simulator does not answer: try again")
        if robot is not None and number is None:
            raise RefusedError("robot %d is not simulated" % robot)
        message = dict(values, order=name)
        if number is not None and name == "add_fault":
            message["fault"] = "%s robot %d" % (values["fault"], number)
        elif number is not None:
            message["robot"] = number
        message["id"] = next(self._ids)
        try:
            self._socket.sendall(json.dumps(message).encode() + b"\n")
        except OSError as error:        # also when it does not read
            self.close()
            raise RefusedError("the simulator does not answer: try again") from error
        self._orders[message["id"]] = answer

    def turn(self, now: float) -> None:
        """Connect if it is time to (monotonic, s), and read what has come. Never blocks, and raises nothing."""
        if self._socket is None:
            if now >= self._retry_at:
                self._retry_at = now + RETRY
                self._connect()
            return
        try:
            while True:
                data = self._socket.recv(READ_SIZE)
                if not data:
                    self.close()
                    return
                for kind, value in self._truth.receive(data):
                    self._feed.text(kind, value)
                while self._truth.carried:
                    self._carried(self._truth.carried.pop())
                while self._truth.answers:
                    number, done, sentence = self._truth.answers.pop(0)
                    self._orders.pop(number, _nobody_waits)(done, sentence)
        except BlockingIOError:
            pass
        except (OSError, ValueError, TypeError, LookupError):
            self.close()

    def close(self) -> None:
        """Close the connection. turn() makes another one."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
            self._orders.clear()

    def _connect(self) -> None:
        line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(line.close)
            line.setblocking(False)
            try:
                line.connect(self._path)
            except OSError:     # there is no simulator yet
                return
            on_failure.pop_all()
            self._socket, self._truth = line, Truth(self._numbers, self._base)


def _nobody_waits(done: bool, sentence: str) -> None:
    """Take the answer to an order whose sender is gone."""

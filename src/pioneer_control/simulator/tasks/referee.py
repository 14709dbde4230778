"""The referee: which task is chosen, who has begun, and how many points each robot has.

A task is `READY` when it is chosen, then `RUNNING`, then `OVER`. This file uses no real time: the referee looks after
the steps of the simulation, so that the same motions give the same points, whatever the splitting into calls.
"""

from typing import Any, Dict, List, Optional, Sequence, Tuple

from ...errors import ParameterError
from ...parameters import nearest
from ..carrier import Carrier
from ..clock import NEVER_US
from ..firmware import Firmware
from ..simulation import Simulation
from ..world import Can
from ..world.poses import Point
from .arena import Ground, Grounds
from .scores import Sample, Score
from .task import Task

READY, RUNNING, OVER = "ready", "running", "over"
PERIOD_US = 100000
"""Time (microseconds) between two samples of a robot."""
NOT_MOVED = Score(0.0, "has not moved")
"""Score of a robot before its first motion."""


class Attempt:
    """One robot at a task, from its start. Its time begins with its first motion.

    Args:
        task: the task.
        robot: the robot. It stands at its start.
        cans: the cans of its arena.
        offset: where the origin of its arena lies (m, map frame).

    Attributes:
        begun_us: simulated time (microseconds) of its first motion. `NEVER_US` before.
        done: whether the robot has done everything. Then nothing that it does counts any more.
    """

    def __init__(self, task: Task, robot: Firmware, cans: Sequence[Can], offset: Point):
        self._rule = task.begin()
        self._robot, self._cans, self._offset = robot, cans, offset
        self._start = robot.true_pose
        self._contacts = self._seen_contacts = 0
        self._next_us = self.begun_us = NEVER_US
        self.done = False

    @property
    def score(self) -> Score:
        """The points that the robot has at present."""
        return NOT_MOVED if self.begun_us == NEVER_US else self._rule.score

    def look(self, now_us: int) -> None:
        """Take a sample if one is due. Call this after each step of the robot, at its time (microseconds)."""
        if self.begun_us == NEVER_US and self._robot.hardware.body.pose != self._start:
            self.begun_us = now_us - self._robot.numbers.physics.step_us
            self._next_us = self.begun_us + PERIOD_US
        if now_us >= self._next_us:
            self._next_us += PERIOD_US
            self._take(now_us)

    def finish(self, now_us: int) -> None:
        """Take the last sample: what the robot has done until this time (microseconds) counts, and no more."""
        if self.begun_us != NEVER_US:
            self._take(now_us)

    def _take(self, now_us: int) -> None:
        if not self.done:
            self._rule.take(self._sample(now_us))
            self.done = self._rule.done

    def _sample(self, now_us: int) -> Sample:
        before, now = self._seen_contacts, self._robot.contacts
        self._contacts += now - before if now >= before else now    # somebody has carried it, and they count from 0
        self._seen_contacts = now
        x, y, _ = self._robot.true_pose
        right, up = self._offset
        return Sample((now_us - self.begun_us) * 1e-6, x - right, y - up, self._contacts,
                      [(can.x - right, can.y - up) for can in self._cans if can.held_by is None])


class Contest:
    """A chosen task: all robots, each in its copy of the arena.

    Args:
        task: the task.
        ground: the copies of its arena.
        robots: the robots. They stand at their starts.

    Attributes:
        task: as the argument.
        state: `READY`, `RUNNING` or `OVER`.
    """

    def __init__(self, task: Task, ground: Ground, robots: Sequence[Firmware]):
        self.task, self._limit_us = task, round(task.rates.limit_s * 1e6)
        each = len(task.arena.cans)
        self._attempts = [
            Attempt(task, robot, [can for can, _, _ in ground.cans[number * each:(number + 1) * each]], offset)
            for number, (robot, offset) in enumerate(zip(robots, ground.offsets))]
        self._clock_us, self._begun_us = 0, NEVER_US
        self.state = READY

    def begin(self, now_us: int) -> None:
        """Begin, at this simulated time (microseconds). The clock waits for the first motion of any robot.

        If no robot moves for the duration of the task, it is over, too.
        """
        self.state, self._begun_us = RUNNING, now_us

    def look(self, now_us: int) -> None:
        """Look at all robots after their steps at this simulated time (microseconds)."""
        if self.state != RUNNING:
            return
        for attempt in self._attempts:
            attempt.look(now_us)
        moved_us = min(attempt.begun_us for attempt in self._attempts)
        self._clock_us = max(0, now_us - moved_us)
        counted_from_us = self._begun_us if moved_us == NEVER_US else moved_us
        if now_us - counted_from_us >= self._limit_us or all(attempt.done for attempt in self._attempts):
            self.end(now_us)

    def end(self, now_us: int) -> None:
        """End at this simulated time (microseconds): no points change from now on."""
        for attempt in self._attempts:
            attempt.finish(now_us)
        self.state = OVER

    @property
    def scores(self) -> List[Score]:
        """The points of each robot at present."""
        return [attempt.score for attempt in self._attempts]

    @property
    def told(self) -> Dict[str, Any]:
        """Task, state, clock and points as plain values, which fit into JSON."""
        return {
            "name": self.task.name, "title": self.task.title, "text": self.task.text, "state": self.state,
            "clock": self._clock_us * 1e-6, "limit": self.task.rates.limit_s,
            "scores": [list(score) for score in self.scores],
        }


class Referee:
    """Carries robots to the arenas of tasks, and gives them points.

    Args:
        simulation: the robots in `Grounds.world`, before any time has passed.
        grounds: the base world and the arenas. If None, there are no tasks.

    Attributes:
        carrier: carries robots and cans in the part of the world that is in use.
        ground: the part of the world that is in use.
    """

    def __init__(self, simulation: Simulation, grounds: Optional[Grounds] = None):
        self.carrier = Carrier(simulation)
        self._simulation = simulation
        self._grounds = Grounds(simulation.world, self.carrier.starts) if grounds is None else grounds
        self.ground = self._grounds.parts[""]
        self._contest: Optional[Contest] = None
        if self._grounds.tasks:
            simulation.on_step.append(self._look)

    @property
    def contest(self) -> Contest:
        """The chosen task: ready, running or over.

        Raises:
            ParameterError: no task is chosen.
        """
        if self._contest is None:
            raise ParameterError("no task is chosen; %s" % self._known)
        return self._contest

    @property
    def tasks(self) -> List[Tuple[str, str]]:
        """Name and title of each task."""
        return [(task.name, task.title) for task in self._grounds.tasks.values()]

    @property
    def told(self) -> Optional[Dict[str, Any]]:
        """Task, state, clock and points as plain values. None while no task is chosen."""
        return None if self._contest is None else self._contest.told

    def choose(self, name: str) -> str:
        """Choose a task: carry all robots to their starts in its arena, and put out its cans. It is ready then.

        Args:
            name: name of the task. With "", no task is chosen, and all robots are carried back to the base world.

        Returns:
            A sentence for people.

        Raises:
            ParameterError: there is no such task. Nothing has changed.
        """
        if name not in self._grounds.parts:
            near = nearest(name, self._grounds.tasks)
            raise ParameterError("no task %r; %s%s" % (name, "did you mean %r? " % near if near else "", self._known))
        self.ground = self._grounds.parts[name]
        self.carrier.settle(self.ground.starts, self.ground.cans)
        self._contest = self._new_contest(self._grounds.tasks[name]) if name else None
        return "the task %s is ready" % name if name else "all robots are back in %s" % self.ground.world.name

    def begin(self) -> str:
        """Carry all robots and cans to their starts again, and begin the chosen task. Returns a sentence for people.

        Raises:
            ParameterError: no task is chosen, or it runs already. Nothing has changed.
        """
        task = self.contest.task
        if self.contest.state == RUNNING:
            raise ParameterError("the task runs already: end it first")
        self.carrier.reset_all()
        self._contest = self._new_contest(task)
        self._contest.begin(self._simulation.clock.now_us)
        return "the task %s has begun" % task.name

    def end(self) -> str:
        """End the running task. Returns a sentence for people.

        Raises:
            ParameterError: no task is chosen, or it does not run. Nothing has changed.
        """
        if self.contest.state != RUNNING:
            raise ParameterError("the task does not run: begin it first")
        self.contest.end(self._simulation.clock.now_us)
        return "the task %s is over" % self.contest.task.name

    def _new_contest(self, task: Task) -> Contest:
        return Contest(task, self.ground, self._simulation.robots)

    @property
    def _known(self) -> str:
        """Which tasks there are, for errors."""
        if not self._grounds.tasks:
            return "there are no tasks: start the simulator with --tasks"
        return "there are %s" % ", ".join(self._grounds.tasks)

    def _look(self, now_us: int) -> None:
        if self._contest is not None:
            self._contest.look(now_us)

"""The conversation with the person: what to do, what to read, what was found.

Person and robot are interfaces of a few methods: at the terminal and on ROS topics, or in a test.
"""

from typing import List, Optional, Protocol, Sequence

from ..errors import RobotError, UsageError
from . import words
from .estimate import STRANGE, Estimate, check, estimate, strangeness
from .plan import Leg, RunPlan, PlannedRun
from .runs import RunKind, RobotMarks, TapedRun, Tape, check_turned, mark_of, tape_of
from .tracks import Factors, OdometryTrack

AGAIN = "again"
"""What a person types to drive a run again."""


class Listener(Protocol):
    """The person: hears, and answers."""

    def say(self, text: str) -> None:
        """Tell the person something."""

    def ask(self, question: str) -> str:
        """Ask the person something. Return the answer, one line without its end."""


class DrivenRobot(Protocol):
    """The robot: it drives a run while the person holds a key."""

    def drive(self, legs: Sequence[Leg], factors: Factors) -> OdometryTrack:
        """Drive the legs of a run, as the robot is known to move. Return what odometry measured until it stands.

        Raises:
            RobotError: the robot does not drive, or its odometry cannot be used: the run has to be driven again.
        """


class Conversation:
    """Leads a person through a plan.

    Args:
        person: the person.
        robot: the robot.
        plan: what is driven.
        rad_per_metre: turn when each right wheel rolls 1 m forward and each left wheel 1 m back.

    Attributes:
        runs: the runs so far.
    """

    def __init__(self, person: Listener, robot: DrivenRobot, plan: RunPlan, rad_per_metre: float) -> None:
        self._person, self._robot, self._plan = person, robot, plan
        self._rad_per_metre = rad_per_metre
        self.runs: List[TapedRun] = []

    def begin(self, likely: RobotMarks) -> RobotMarks:
        """Say what is needed, and ask where the marks are. ``likely``: the marks of a robot of this model."""
        self._person.say(words.begin(self._plan.runs))
        return ask_marks(self._person, likely)

    def calibrate(self, marks: RobotMarks) -> Estimate:
        """Drive all runs, and return what they say.

        Raises:
            CalibrationError: this robot cannot be calibrated. The message says what was seen.
        """
        found = estimate((), self._rad_per_metre)
        for number, planned in enumerate(self._plan.runs, 1):
            self._person.say("\nRun %d of %d." % (number, len(self._plan.runs)))
            self.runs.append(self._run(planned, found.factors, marks, self.runs))
            found = check(self.runs, self._rad_per_metre)
        self._person.say("\n" + words.result(found, self._rad_per_metre))
        return found

    def prove(self, marks: RobotMarks, factors: Factors, counts: Factors) -> str:
        """Drive a few runs again. Return a table of what became better.

        Args:
            marks: of the robot.
            factors: of the calibration, for what the robot counts now.
            counts: how much way and turn the robot would have counted before it was told its own numbers, for each that
                it counts now. 1 and 1 if it was told nothing.
        """
        self._person.say("\nNow the same again, to see what became better.")
        runs = [self._run(planned, factors, marks, None) for planned in self._plan.proof]
        before = [run._replace(track=run.track.scaled(counts.distance, counts.turn)) for run in runs]
        return words.became_better(runs, before, factors)

    def _run(self, planned: PlannedRun, factors: Factors, marks: RobotMarks,
             others: Optional[Sequence[TapedRun]]) -> TapedRun:
        """Drive one run until it is accepted.

        Args:
            planned: the run.
            factors: of the robot, as it is known now.
            marks: of the robot.
            others: the runs that it should fit. None: none.
        """
        while True:
            self._person.say(words.put(planned))
            self._person.ask("Press Enter when it stands there. ")
            try:
                track = self._robot.drive(planned.legs, factors)
            except RobotError as error:      # also STOP pressed, or motors that do not come on
                self._person.say("%s." % error)
                continue
            tape = ask_tape(self._person, words.READ[planned.kind], planned.kind, marks)
            while tape is not None:
                run = TapedRun(planned.kind, planned.turns, track, tape, marks)
                if not others or strangeness(run, others, self._rad_per_metre) <= STRANGE:
                    return run
                predicted = words.numbers(run.kind, run.predicted(estimate(others, self._rad_per_metre).factors))
                said = tape
                tape = ask_tape(self._person, words.STRANGE % (words.numbers(run.kind, run.measured), predicted),
                                planned.kind, marks, said)
                if tape == said:
                    return run


def ask_tape(person: Listener, question: str, kind: RunKind, marks: RobotMarks, known: Optional[Tape] = None,
             skip: str = AGAIN) -> Optional[Tape]:
    """Ask for the two numbers of the tape until they are legal. None: the run does not count.

    Args:
        person: who is asked.
        question: what is asked.
        kind: of the run.
        marks: on the robot.
        known: what was said before; an empty answer means that it is right.
        skip: the answer that means that the run does not count.
    """
    while True:
        answer = person.ask(question).strip()
        if answer.lower() == skip:
            return None
        if known is not None and not answer:
            return known
        try:
            tape = tape_of(answer, kind)
            if kind is RunKind.TURN:
                check_turned(tape, marks)
            return tape
        except UsageError as error:
            person.say("%s." % error)


def ask_marks(person: Listener, likely: RobotMarks) -> RobotMarks:
    """Ask where the marks are on the robot, until the answers are legal."""
    values: List[float] = []
    for question, name, default in zip(words.marks_asked(likely), RobotMarks._fields, likely):
        while len(values) < RobotMarks._fields.index(name) + 1:
            try:
                values.append(mark_of(person.ask(question), name, default))
            except UsageError as error:
                person.say("%s." % error)
    return RobotMarks(*values)

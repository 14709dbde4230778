"""The conversation with a person who reads the tape, sometimes wrongly."""

import math
import os
import threading

import pytest

from made_runs import MARKS, RAD_PER_METRE, WRONG, run_of, track_of
from pioneer_control.calibration import terminal as terminal_file
from pioneer_control.calibration import words
from pioneer_control.calibration.conversation import Conversation, ask_marks
from pioneer_control.calibration.estimate import Estimate
from pioneer_control.calibration.plan import PlannedRun, RunPlan, line, plan_of, square, turns
from pioneer_control.calibration.runs import RobotMarks, RunKind
from pioneer_control.calibration.terminal import HeldKey, Terminal, TerminalClosed
from pioneer_control.calibration.tracks import Factors
from pioneer_control.errors import CalibrationError

SMALL = RunPlan((turns(1), turns(-1), line(5.0), line(5.0)), (line(5.0), turns(1)))


class ExactRobot:
    """A robot that drives each leg exactly by its odometry; its wheels have other factors each time if so wished."""

    def __init__(self, *factors, refuses=0):
        self.factors, self.refuses = list(factors), refuses
        self.driven = []
        self.guided_by = []

    def drive(self, legs, factors):
        if self.refuses:
            self.refuses -= 1
            raise CalibrationError("odometry jumped")
        self.driven.append(legs)
        self.guided_by.append(factors)
        return track_of(legs)

    @property
    def now(self):
        return self.factors[(len(self.driven) - 1) % len(self.factors)]


class Reader:
    """A person who reads the tape, and gives the answers in `instead` by the number of the question about a tape."""

    def __init__(self, robot, plan, instead=()):
        self.robot, self.plan, self.instead = robot, plan, dict(instead)
        self.heard, self.asked = [], 0

    def say(self, text):
        self.heard.append(text)

    def ask(self, question):
        self.heard.append(question)
        assert len(self.heard) < 500, "it asks for ever: %s" % question
        if "Two numbers" not in question and "Type the two" not in question:
            return ""
        self.asked += 1
        if self.asked in self.instead:
            return self.instead[self.asked]
        legs = self.robot.driven[-1]
        planned = next(each for each in self.plan.runs + self.plan.proof if each.legs == legs)
        return "%.2f %.2f" % tuple(100 * each for each in run_of(planned, self.robot.now).tape)


def talk(robot, plan=SMALL, instead=()):
    person = Reader(robot, plan, instead)
    return person, Conversation(person, robot, plan, RAD_PER_METRE)


def test_a_robot_is_calibrated_and_shows_what_became_better():
    person, conversation = talk(ExactRobot(WRONG))
    marks = conversation.begin(MARKS)
    found = conversation.calibrate(marks)
    assert marks == MARKS and found.factors == pytest.approx(WRONG, abs=2e-3)
    table = conversation.prove(marks, found.factors, Factors())
    assert "It became better." in table and "straight line" in table
    text = "\n".join(person.heard)
    assert "Run 4 of 4." in text and "7 m long" in text
    assert "drives      +1.9" in text or "drives      +2.0" in text


def test_it_drives_by_what_it_knows_by_then():
    robot = ExactRobot(WRONG)
    talk(robot)[1].calibrate(MARKS)
    assert robot.guided_by[0] == Factors() and robot.guided_by[-1].turn == pytest.approx(WRONG.turn, abs=2e-3)


def test_what_is_no_number_is_asked_again():
    person, conversation = talk(ExactRobot(WRONG), instead={1: "much", 2: "nan 1", 3: "40 -40"})
    conversation.calibrate(MARKS)
    text = "\n".join(person.heard)
    assert "'much' is not two numbers" in text and "front mark left is 'nan'" in text and "only 0.500 m apart" in text


def test_a_slip_of_the_pen_is_asked_again_and_mended():
    """4.9 for 490: the second line does not fit the first, and is typed anew."""
    person, conversation = talk(ExactRobot(WRONG), instead={4: "4.9 26"})
    found = conversation.calibrate(MARKS)
    assert found.factors == pytest.approx(WRONG, abs=2e-3)
    assert any("does not fit the runs before" in each for each in person.heard)


def test_a_run_is_driven_again():
    robot = ExactRobot(WRONG)
    person, conversation = talk(robot, instead={2: "again"})
    conversation.calibrate(MARKS)
    assert len(robot.driven) == 5 and len(conversation.runs) == 4


def test_a_run_whose_odometry_cannot_be_used_is_driven_again():
    person, conversation = talk(ExactRobot(WRONG, refuses=2))
    conversation.calibrate(MARKS)
    assert person.heard.count("odometry jumped.") == 2


def test_a_robot_that_errs_otherwise_each_time_cannot_be_calibrated():
    robot = ExactRobot(Factors(0.99, 0.95, 0.1), Factors(0.85, 0.85, 0.3), Factors(0.95, 0.92, 0.2))
    plan = plan_of()
    person = Reader(robot, plan, {})
    person_asks = person.ask
    person.ask = lambda question: "" if "Type the two" in question else person_asks(question)    # it is right
    with pytest.raises(CalibrationError, match="cannot be calibrated"):
        Conversation(person, robot, plan, RAD_PER_METRE).calibrate(MARKS)
    assert len(robot.driven) < len(plan.runs)       # it is told as soon as it is known


def test_worse_is_called_worse():
    robot = ExactRobot(WRONG)
    _, conversation = talk(robot)
    assert "It did not become better" in conversation.prove(MARKS, Factors(0.9, 0.9, -0.05), Factors())


def test_where_the_marks_are():
    robot = ExactRobot(WRONG)
    person = Reader(robot, SMALL)
    answers = iter(["x", "25", "-3", ""])
    person.ask = lambda question: next(answers)
    assert ask_marks(person, RobotMarks(0.21, 0.511)) == (0.25, 0.511)
    assert person.heard == ["front is 'x': give a number from 5 to 200, in cm.",
                            "apart is '-3': give a number from 10 to 300, in cm."]


@pytest.mark.parametrize("planned", [line(5.0), turns(-5), square(2.0, 1)])
def test_each_run_is_said_and_asked(planned: PlannedRun):
    assert "%" not in words.put(planned) and "%" not in words.READ[planned.kind]


def test_what_a_tape_says_in_words():
    assert words.numbers(RunKind.TURN, [math.pi]) == "180.0 degrees in all"
    assert words.numbers(RunKind.LINE, [5.0, -0.02]) == "500.0 cm ahead, -2.0 cm left"


# The terminal

def test_a_key_is_held_while_it_is_repeated():
    key = HeldKey()
    assert not key.held(0.0)
    key.take(b"w", 1.0)
    assert key.held(1.5) and not key.held(1.7)
    key.take(b"\x1b[A", 2.0)
    key.take(b"w", 2.4)
    assert key.held(2.6) and not key.held(2.7)


@pytest.mark.parametrize("other", [b"s", b" ", b"x", b"a"])
def test_any_other_key_lets_go(other):
    key = HeldKey()
    key.take(b"w", 1.0)
    key.take(other, 1.1)
    assert not key.held(1.1)


class EachKey:
    """Stands for the context in which a terminal tells each key."""

    entered = 0

    def __call__(self, source):
        return self

    def __enter__(self):
        EachKey.entered += 1

    def __exit__(self, *exception):
        pass


class Screen:
    def __init__(self):
        self.text = ""

    def write(self, text):
        self.text += text

    def flush(self):
        pass


@pytest.fixture
def piped(monkeypatch):
    """A terminal that reads a pipe, and the end into which a person types."""
    source, typed = os.pipe()
    screen = Screen()
    monkeypatch.setattr(terminal_file, "QUIET", 0.2)
    yield Terminal(source, lambda: False, EachKey(), screen), typed, screen
    for end in (source, typed):
        try:
            os.close(end)
        except OSError:
            pass


def test_answers_come_line_by_line(piped):
    terminal, typed, screen = piped
    os.write(typed, b"one\ntw")
    assert terminal.ask("first? ") == "one"
    os.write(typed, b"o\n")
    assert terminal.ask("second? ") == "two"
    assert screen.text == "first? one\nsecond? two\n"


def test_nobody_answers(piped):
    terminal, typed, _ = piped
    os.close(typed)
    with pytest.raises(TerminalClosed, match="nobody answers"):
        terminal.ask("first? ")


def test_the_program_ends_while_it_asks(piped):
    terminal, _, _ = piped
    terminal._ended = lambda: True
    with pytest.raises(TerminalClosed, match="the program ends"):
        terminal.ask("first? ")


def test_the_key_is_told_to_each_step_until_the_run_is_done(piped):
    terminal, typed, screen = piped
    seen = []

    def step(held, now):
        seen.append(held)
        if len(seen) == 1:
            os.write(typed, b"w")
        return not held

    terminal.hold(step, 0.01)
    assert seen[0] is False and seen[-1] is True and "Let go of the key" in screen.text and EachKey.entered


def test_a_key_that_is_still_held_at_the_end_is_no_answer(piped):
    terminal, typed, _ = piped
    pressed = threading.Event()

    def press():
        for _ in range(5):
            os.write(typed, b"w")
            pressed.wait(0.05)

    finger = threading.Thread(target=press)
    finger.start()
    terminal.hold(lambda held, now: False, 0.01)
    finger.join()
    os.write(typed, b"1.2 3\n")
    assert terminal.ask("? ") == "1.2 3"


@pytest.mark.parametrize("distance, turn, curve, wheels, apart, right", [
    (1.01, 1.05, 0.01, "its wheels are larger", "3.81 % closer together", "its right wheel is 0.36 % +- 0.04 larger"),
    (0.99, 0.95, -0.01, "its wheels are smaller", "4.21 % farther apart", "its right wheel is 0.39 % +- 0.04 smaller"),
])
def test_a_result_says_in_words_which_way_it_is_off(distance, turn, curve, wheels, apart, right):
    said = words.result(Estimate(Factors(distance, turn, curve), Factors(0.001, 0.001, 0.001), 1.0, None, 0.0), 5.3)
    assert wheels in said and apart in said and right in said

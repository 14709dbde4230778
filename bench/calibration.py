#!/usr/bin/python3
"""Calibrates simulated robots with a simulated person, in simulated time: see calibration.md.

    python3 bench/calibration.py                      # seeds 1000 to 1099
    python3 bench/calibration.py --seeds 7000-7099 --processes 2
    python3 bench/calibration.py --left-slip 0.5      # robots that cannot be calibrated

Each seed is a robot whose wheels are wrong. It is calibrated by the very conversation of ``rosrun pioneer_control
calibrate``; then a models file, and with --tell the robot's own numbers, are used for ten lines and ten turns.
"""

import argparse
import math
import os
import random
import re
import sys
import tempfile
from dataclasses import replace
from multiprocessing import Pool
from typing import List, NamedTuple, Sequence, Tuple

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src"))

from simulated_robot import Setup, SimulatedRobot

from pioneer_control import p2os
from pioneer_control.calibration import result
from pioneer_control.calibration.conversation import Conversation
from pioneer_control.calibration.guide import STAND, Guide
from pioneer_control.calibration.lookout import Lookout
from pioneer_control.calibration.plan import AheadLeg, TurnLeg, plan_of
from pioneer_control.calibration.runs import RobotMarks
from pioneer_control.calibration.tracks import Factors, TrackRecorder
from pioneer_control.client.corrected_odometry import odometry_of
from pioneer_control.errors import CalibrationError
from pioneer_control.floor_poses import Pose
from pioneer_control.robots import find_model
from pioneer_control.simulator.hardware.robot_numbers import standard_numbers
from pioneer_control.simulator.world.world import World

MODEL = "p3dx-sh"
LARGER, RIGHT_LARGER, WIDER_APART = 0.03, 0.01, 0.03
"""How wrong wheels are, at most, to either side."""
DRIVES, LINE, TURN = 10, 5.0, 2.0 * math.pi
PLACED, ALIGNED = 0.001, math.radians(0.3)
"""How exactly the person puts the robot on its marks, and along its line (standard deviations; m, rad)."""
ROUNDINGS = (0.001, 0.002, 0.005)
"""To what a person rounds what the tape says (m): each robot has a person of its own."""
EYE = 0.001
"""And how wrong the eye is (m, standard deviation)."""


class Calibrated(NamedTuple):
    """What became of one robot. Times in s, lengths in m, angles in rad."""

    seed: int
    driven: float
    refused: str
    misfit: float = math.nan
    length_off: float = math.nan
    turn_off: float = math.nan
    length_before: float = math.nan
    turn_before: float = math.nan
    touched: int = 0


class Bench(SimulatedRobot):
    """The robot under calibration: `drive` is what the node does, in simulated time."""

    def __init__(self, numbers, seed):
        super().__init__(Setup(MODEL, numbers=numbers), room(), seed)
        self.driven = 0.0

    def use(self, model) -> None:
        """Let odometry use a model from now on, as a driver that is started anew."""
        self._odometry = odometry_of(model)

    def drive(self, legs, factors):
        """Drive the legs of a run, and return its track."""
        began = self.firmware.time
        recorder, guide, lookout = TrackRecorder(), Guide(legs, factors), Lookout()
        while not guide.done:
            snapshot = self.listen()
            recorder.pose(snapshot.pose)
            velocity = guide.step(snapshot.pose, snapshot.time)
            if lookout.why_not(snapshot, guide.leg):
                velocity = STAND
            self.command(*velocity)
        self.driven += self.firmware.time - began
        return recorder.track

    def tell(self, new) -> None:
        """Tell the robot its own numbers."""
        for name, value in new.items():
            self.firmware.receive(p2os.encode_command({"ticks_mm": "TICKSMM", "rev_count": "REVCOUNT"}[name], value))


class SimulatedPerson:
    """Puts the robot on its line, and reads the tape."""

    def __init__(self, robot: Bench, marks: RobotMarks, rounding: float, luck: random.Random, heard: List[str]) -> None:
        self._robot, self._marks, self._rounding, self._luck, self._heard = robot, marks, rounding, luck, heard
        self._line = Pose(0.0, 0.0, 0.0)

    def say(self, text: str) -> None:
        self._heard.append(text)

    def ask(self, question: str) -> str:
        self._heard.append(question)
        if "Press Enter when" in question:
            self._put()
            return ""
        front, rear = self._mark(self._marks.front), self._mark(self._marks.front - self._marks.apart)
        if "does not fit" in question:
            return ""
        if "along the line" in question:
            return "%.1f %.1f" % (self._read(front.x - self._marks.front), self._read(front.y))
        if "rear mark?" in question:
            return "%.1f %.1f" % (self._read(front.y), self._read(rear.y))
        return ""       # where the marks are: as the model says

    def _put(self) -> None:
        """Put the robot on the line, nearly."""
        luck = self._luck.gauss
        self._robot.firmware.hardware.body.carry((luck(0, PLACED), luck(0, PLACED), luck(0, ALIGNED)))

    def _mark(self, ahead: float) -> Pose:
        x, y, heading = self._robot.firmware.true_pose
        return Pose(x + ahead * math.cos(heading), y + ahead * math.sin(heading), heading)

    def _read(self, metres: float) -> float:
        """Return what the person reads (cm)."""
        return 100.0 * self._rounding * round((metres + self._luck.gauss(0, EYE)) / self._rounding)


def room() -> World:
    """Return a room of 16 x 16 m."""
    corners = [(-8.0, -8.0), (8.0, -8.0), (8.0, 8.0), (-8.0, 8.0)]
    return World("room", walls=[(*one, *other) for one, other in zip(corners, corners[1:] + corners[:1])])


def robot_of(seed: int, left_slip: float) -> Bench:
    """Return the robot of a seed: wheels that are wrong, slip and noise as in docs/worlds.md."""
    luck = random.Random("calibration %d" % seed)
    numbers = standard_numbers()
    wheels = replace(numbers.wheels, larger=luck.uniform(-LARGER, LARGER),
                     right_larger=luck.uniform(-RIGHT_LARGER, RIGHT_LARGER),
                     wider_apart=luck.uniform(-WIDER_APART, WIDER_APART), slip=0.03, noise=0.004, left_slip=left_slip)
    sonar = replace(numbers.sonar, noise=0.02, specular_deg=40)
    return Bench(replace(numbers, wheels=wheels, sonar=sonar), seed)


def measured(robot: Bench) -> Tuple[float, float]:
    """Return the mean length (m) of drives of 5 m by odometry, less 5 m, and the mean turn, less 360 degrees (rad)."""
    lengths, turns = [], []
    for _ in range(DRIVES):
        robot.firmware.hardware.body.carry((0.0, 0.0, 0.0))
        robot.drive((AheadLeg(LINE),), Factors())
        lengths.append(math.hypot(*robot.firmware.true_pose[:2]) - LINE)
    for number in range(DRIVES):
        robot.firmware.hardware.body.carry((0.0, 0.0, 0.0))
        side = 1.0 if number % 2 else -1.0
        robot.drive((TurnLeg(side * TURN),), Factors())
        turns.append(side * robot.firmware.true_pose[2] - TURN)
    return sum(lengths) / DRIVES, sum(turns) / DRIVES


def calibrated(seed: int, options) -> Calibrated:
    """Calibrate one robot, and return what became of it."""
    model = find_model(MODEL)
    before = measured(robot_of(seed, options.left_slip)) if options.before else (math.nan, math.nan)
    robot = robot_of(seed, options.left_slip)
    marks = RobotMarks(model.length_front, model.length_front + model.length_rear)
    luck, heard = random.Random("person %d" % seed), []
    person = SimulatedPerson(robot, marks, luck.choice(ROUNDINGS), luck, heard)
    conversation = Conversation(person, robot, plan_of(repeats=options.repeats), 1000.0 * model.diff_rad_per_mm)
    try:
        found = conversation.calibrate(conversation.begin(marks))
    except CalibrationError as error:
        return Calibrated(seed, robot.driven, str(error))
    counted = result.of_counts(found.factors, model)
    own = result.OwnNumbers(128, 16570, 0)
    new = result.numbers_to_tell(counted, model, own) if options.tell else {}
    rest = result.after_telling(counted, own, new)
    robot.tell(new)
    if options.prove:
        counts = Factors(rest.distance / counted.distance, rest.turn / counted.turn)
        heard.append(conversation.prove(marks, result.of_driver(rest, model), counts))
    driven = robot.driven
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "my_robots.yaml")
        values = result.values_of_file(counted, rest, model, found)
        result.write_models_file(path, MODEL, values)
        robot.use(find_model(MODEL, path))
    length, turn = measured(robot)
    if options.verbose:
        print("\n".join(heard))
        print(values, new)
    return Calibrated(seed, driven, "", found.misfit, length, turn, *before, robot.firmware.contacts)


def seeds_of(text: str) -> Sequence[int]:
    """Return the seeds of a range such as 1000-1099."""
    match = re.fullmatch(r"(\d+)(?:-(\d+))?", text)
    if not match:
        raise argparse.ArgumentTypeError("%r is no range of seeds, such as 1000-1099" % text)
    return range(int(match.group(1)), int(match.group(2) or match.group(1)) + 1)


def at(values, share: float) -> float:
    """Return the value below which this share of values lies."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else math.nan


def report(robots: List[Calibrated]) -> str:
    """Return the figures of the issue's acceptance."""
    done = [each for each in robots if not each.refused]
    lines = ["%d robots: %d calibrated, %d told that they cannot be" % (
        len(robots), len(done), len(robots) - len(done))]
    for reason in sorted({re.sub(r"[\d.]+", "#", each.refused)[:100] for each in robots if each.refused}):
        lines.append("  %s..." % reason)
    if done:
        lengths, turns = [abs(each.length_off) for each in done], [abs(each.turn_off) for each in done]
        good = [each for each in done if abs(each.length_off) <= 0.02 and abs(math.degrees(each.turn_off)) <= 1.0]
        lines += [
            "both within 2 cm and 1 degree: %d" % len(good),
            "mean of 10 drives of 5 m, off by: median %.1f mm, 95 %% %.1f mm, worst %.1f mm" % tuple(
                1000 * at(lengths, share) for share in (0.5, 0.95, 1.0)),
            "mean of 10 turns of 360 degrees, off by: median %.2f, 95 %% %.2f, worst %.2f degrees" % tuple(
                math.degrees(at(turns, share)) for share in (0.5, 0.95, 1.0)),
            "before: median %.1f mm, worst %.1f mm; median %.1f, worst %.1f degrees" % (
                *(1000 * at([abs(each.length_before) for each in done], share) for share in (0.5, 1.0)),
                *(math.degrees(at([abs(each.turn_before) for each in done], share)) for share in (0.5, 1.0))),
            "misfit: median %.2f, least %.2f, most %.2f" % tuple(
                at([each.misfit for each in done], share) for share in (0.5, 0.0, 1.0)),
            "driven: median %.0f s, most %.0f s; contacts %d" % (
                at([each.driven for each in done], 0.5), max(each.driven for each in done),
                sum(each.touched for each in done)),
        ]
    else:
        lines.append("driven until then: median %.0f s" % at([each.driven for each in robots], 0.5))
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("1000-1099"))
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--left-slip", type=float, default=0.0)
    parser.add_argument("--tell", action="store_true", help="tell the robot its own numbers, too")
    parser.add_argument("--no-proof", dest="prove", action="store_false", help="do not drive again at the end")
    parser.add_argument("--before", action="store_true", help="also measure the robot before")
    parser.add_argument("--verbose", action="store_true", help="print the conversation")
    options = parser.parse_args()
    with Pool(options.processes) as pool:
        robots = pool.starmap(calibrated, [(seed, options) for seed in options.seeds], chunksize=1)
    print(report(robots))


if __name__ == "__main__":
    main()

"""The longer texts of the conversation: instructions, and results. Lengths are said in cm, angles in degrees."""

import math
from typing import List, Sequence

from .estimate import Estimate
from .guide import SPEED, TURN_RATE
from .plan import AheadLeg, PlannedRun
from .runs import RunKind, RobotMarks, TapedRun, name_of
from .tracks import Factors

BEGIN = """\
You need: an even floor as the robot is to drive on, %.0f m long and %.0f m wide; a tape measure, a ruler, sticky tape;
and %d minutes, about %d of them driving.

1. Stick a straight line on the floor, %.1f m long. The tape measure itself, stretched out, is a good line.
2. Stick a mark on the middle of the robot's front, and one on the middle of its rear: halfway between the wheels, low,
   so that you see where they stand over the line. A thread with a nut, hung from each, is best.

The robot drives only while you hold the key w (or the arrow up). Let go, and it stands. It stands too when its sonar
sees something in the way. Any other key lets go as well; Ctrl-C ends."""

PUT_ON_LINE = ("Put the robot at the beginning of the line: both marks over the line, the nose along it. Mark on the\n"
               "floor where its front mark is: that is 0. ")
PUT = {
    RunKind.LINE: PUT_ON_LINE + "It drives %s.",
    RunKind.SQUARE: PUT_ON_LINE + "It drives a %s.",
    RunKind.TURN: ("Put the robot in the middle of the line: both marks over the line, the nose along it.\n"
                   "It makes %s, and may end beside the line."),
}
TWO_NUMBERS = "\nTwo numbers in cm, to the mm if you can: "
READ = {
    RunKind.LINE: ("How far is the front mark now ahead of 0, along the line? And how far left of the line (right: -)?"
                   + TWO_NUMBERS),
    RunKind.SQUARE: ("How far is the front mark now ahead of 0, along the line (behind: -)? And how far left of the"
                     " line (right: -)?" + TWO_NUMBERS),
    RunKind.TURN: ("How far left of the line is the front mark (right: -)? And how far left is the rear mark?"
                   + TWO_NUMBERS),
}
STRANGE = ("%s by the tape does not fit the runs before: by odometry, corrected by them, it is %s.\n"
           "Was it bumped, or did a wheel slip? Type the two numbers again if they were wrong, \"again\" to drive\n"
           "this run again, or press Enter if they are right: ")


def begin(runs: Sequence[PlannedRun]) -> str:
    """Return what the person needs and does first."""
    ways = [(run.kind, leg.way) for run in runs for leg in run.legs if isinstance(leg, AheadLeg)]
    longest = max(way for _, way in ways)
    aside = max((way for kind, way in ways if kind is RunKind.SQUARE), default=0.0)     # to either side of the line
    minutes = math.ceil(driving_time(runs) / 60.0)
    return BEGIN % (longest + 2.0, 2.0 * aside + 2.0, minutes + 2 * len(runs), minutes, longest)


def driving_time(runs: Sequence[PlannedRun]) -> float:
    """Return about how long (s) some runs take to drive."""
    return sum(leg.way / SPEED + 3.0 if isinstance(leg, AheadLeg) else abs(leg.turn) / TURN_RATE + 2.5
               for run in runs for leg in run.legs)


def put(planned: PlannedRun) -> str:
    """Return where the robot is put for a run, and what it will drive."""
    if planned.kind is RunKind.LINE:
        leg = planned.legs[0]
        assert isinstance(leg, AheadLeg)
        return PUT[planned.kind] % ("%.1f m ahead" % leg.way)
    return PUT[planned.kind] % name_of(planned.kind, planned.turns)


def numbers(kind: RunKind, values: Sequence[float]) -> str:
    """Return what odometry or tape say of the end of a run, in words."""
    if kind is RunKind.TURN:
        return "%.1f degrees in all" % math.degrees(values[0])
    return "%.1f cm ahead, %.1f cm left" % (100.0 * values[0], 100.0 * values[1])


def result(found: Estimate, rad_per_metre: float) -> str:
    """Return what was found, with the standard deviation of each."""
    factors, off = found.factors, found.deviations
    rad = rad_per_metre * factors.turn / factors.distance
    right_larger = found.right_larger(rad_per_metre)
    lines = [
        "The robot, for what its odometry says (+- is one standard deviation):",
        "  drives     %+6.2f %% +- %.2f   its wheels are %s than assumed" % (
            100 * (factors.distance - 1), 100 * off.distance, "larger" if factors.distance >= 1 else "smaller"),
        "  turns      %+6.2f %% +- %.2f   so its wheels are %.2f %% %s than assumed" % (
            100 * (factors.turn - 1), 100 * off.turn, 100 * abs(found.wider_apart),
            "farther apart" if found.wider_apart >= 0 else "closer together"),
        "  bends      %+6.2f +- %.2f degrees left in each metre: its right wheel is %.2f %% +- %.2f %s" % (
            math.degrees(factors.curve), math.degrees(off.curve), 100 * abs(right_larger), 200 * off.curve / rad,
            "larger" if right_larger >= 0 else "smaller"),
    ]
    if found.gyro is not None:
        lines.append("  gyro       %+6.2f %% +- %.2f   turns %s than its gyro measures" % (
            100 * (found.gyro - 1), 100 * found.gyro_deviation, "farther" if found.gyro >= 1 else "less"))
    lines.append("The runs differ %.1f times as much as on the floor that was assumed." % math.sqrt(found.misfit))
    if not found.is_sure:
        lines.append("This is not very sure: more runs (--repeats), or a longer line, make it surer.")
    return "\n".join(lines)


def head_of_file(found: Estimate, rad_per_metre: float, told: Sequence[str], day: str) -> str:
    """Return the head of a models file."""
    text = "Calibrated with a tape measure, %s (rosrun pioneer_control calibrate).\n%s" % (
        day, result(found, rad_per_metre))
    if told:
        text += ("\nIt is right only while the robot has these numbers of its own (parameters of the driver): "
                 + ", ".join(told))
    return text


def became_better(runs: Sequence[TapedRun], before: Sequence[TapedRun], factors: Factors) -> str:
    """Return a table: how far odometry was off in the last runs, without the calibration and with it.

    Args:
        runs: the last runs.
        before: the same, as the robot would have counted without the calibration.
        factors: of the calibration, for what it counts now.
    """
    lines = ["Off at the end of a run, by odometry without the calibration -> with it:"]
    for run, old in zip(runs, before):
        was, now = old.predicted(Factors()) - old.measured, run.predicted(factors) - run.measured
        if run.kind is RunKind.TURN:
            lines.append("  %-34s %6.1f -> %5.1f degrees in a turn" % (
                run.name, math.degrees(was[0]) / abs(run.turns), math.degrees(now[0]) / abs(run.turns)))
        else:
            lines.append("  %-34s %6.1f -> %5.1f cm ahead, %6.1f -> %5.1f cm aside" % (
                run.name, 100 * was[0], 100 * now[0], 100 * was[1], 100 * now[1]))
    better = sum(_size(run, factors) for run in runs) <= sum(_size(old, Factors()) for old in before)
    lines.append("It became better." if better else
                 "It did not become better: drive the calibration again before you use this file.")
    return "\n".join(lines)


def _size(run: TapedRun, factors: Factors) -> float:
    """Return how far odometry is off at the end of a run, in m; 1 cm counts as much as 1 degree."""
    off = [float(each) for each in run.predicted(factors) - run.measured]
    if run.kind is RunKind.TURN:
        return abs(off[0]) / math.radians(100.0) / max(1, abs(run.turns))
    return math.hypot(*off)


def marks_asked(default: RobotMarks) -> List[str]:
    """Return the questions for the two marks; an empty answer is the default."""
    return ["\nHow far is the front mark ahead of the middle of the wheels, in cm? [%.1f] " % (100 * default.front),
            "How far are the front mark and the rear mark apart, in cm? [%.1f] " % (100 * default.apart)]

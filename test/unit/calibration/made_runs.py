"""Runs made by hand: what odometry would measure, and what the tape would say of a robot with known factors."""

import math

from pioneer_control.calibration.plan import AheadLeg
from pioneer_control.calibration.runs import RobotMarks, RunKind, Tape, TapedRun
from pioneer_control.calibration.tracks import Factors, OdometryTrack

MARKS = RobotMarks(0.2, 0.5)
RAD_PER_METRE = 5.6


def track_of(legs, gyro=None):
    """Return the track of legs that are driven exactly by odometry, in steps of 0.05 m or 0.05 rad."""
    ahead, turned = [], []
    for leg in legs:
        whole = leg.way if isinstance(leg, AheadLeg) else leg.turn
        steps = max(1, round(abs(whole) / 0.05))
        for _ in range(steps):
            ahead.append(whole / steps if isinstance(leg, AheadLeg) else 0.0)
            turned.append(0.0 if isinstance(leg, AheadLeg) else whole / steps)
    return OdometryTrack(ahead, turned, gyro)


def run_of(planned, factors, marks=MARKS, gyro=None, off=(0.0, 0.0)):
    """Return a planned run that a robot with these factors drove exactly by odometry, with its tape.

    ``off``: by how much the tape says more (m).
    """
    track = track_of(planned.legs, gyro)
    end = track.end(factors)
    if planned.kind is RunKind.TURN:
        beyond = end.heading - 2 * math.pi * planned.turns
        tape = marks.front * math.sin(beyond), (marks.front - marks.apart) * math.sin(beyond)
    else:
        tape = end.x + marks.front * (math.cos(end.heading) - 1), end.y + marks.front * math.sin(end.heading)
    return TapedRun(planned.kind, planned.turns, track, Tape(tape[0] + off[0], tape[1] + off[1]), marks)


WRONG = Factors(1.02, 1.03, 0.02)

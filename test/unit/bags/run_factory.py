"""Runs made by hand, for the tests of drawing: no bag, no ROS."""

import numpy as np

from pioneer_control.bags.navigation_collectors import DRIVES, UNSURE, WAITS
from pioneer_control.bags.recorded_run import (CanPath, Echoes, Goal, GripperEvent, Map, Navigated, Report, Run,
                                               Series, Span, Track, Velocities)

BEGIN = 1.8e9  # s
SQUARE = np.array([(0.36, -0.2), (0.36, 0.2), (-0.3, 0.2), (-0.3, -0.2)])
DOINGS = ("driving", "turning", "stopped", "backing", "halting", "asleep", "awake")
LONG_TEXT = ("the other side closed the line: switched off, cable pulled, or another program is connected, "
             "and this says it at great length")


def track(seconds, speed=0.2, towards=0.0, bend=0.05, step=0.1):
    """Return the track of a robot that drives in bends, at ``speed`` (m/s), around a heading ``towards`` (rad)."""
    time = np.arange(0.0, seconds + step / 2, step)
    heading = towards + np.sin(bend * np.arange(len(time)))
    x, y = (np.concatenate(([0.0], np.cumsum(speed * step * turned(heading[:-1])))) for turned in (np.cos, np.sin))
    return Track(BEGIN + time, x, y, heading)


def run(odometry=None, **fields):
    """Return a run that has odometry, and the other data that are given."""
    given = dict(
        path="run.bag", robot="pioneer", model="p3dx-sh", world="", footprint=SQUARE, transducers={}, truth=None,
        sonar=Echoes(*np.empty((3, 0))), gripper=(), cans=(), map=None,
    )  # fmt: skip
    return Run(odometry=track(20.0) if odometry is None else odometry, **{**given, **fields})


def velocities(of):
    """Return the measured velocities of a robot that drives a track."""
    passed = np.diff(of.time)
    return Velocities(of.time[1:], np.hypot(np.diff(of.x), np.diff(of.y)) / passed, np.diff(of.heading) / passed)


def series(*changes):
    """Return a series of (s since the begin, value)."""
    times, values = np.array(changes, dtype=float).T
    return Series(BEGIN + times, values)


def full(odometry, times=5):
    """Return a run that has all data. Most kinds of events happen so many times."""
    seconds = odometry.time[-1] - BEGIN
    moments = BEGIN + seconds * (np.arange(times) + 0.5) / times
    told = velocities(odometry)
    room = Map(np.pad(np.zeros((60, 60), dtype=np.int8), 2, constant_values=100), 0.1, (-2.0, -2.0, 0.0))
    return run(
        odometry, path="somewhere/a-bag-with-a-very-long-name-which-nobody-would-ever-type-by-hand.bag",
        world="tutorial", truth=odometry, map=room,
        transducers={0: (0.2, 0.0, 0.0)}, sonar=Echoes(moments, np.zeros(times), np.full(times, 1.5)),
        cans=(CanPath(odometry.time[[0, -1]], np.array([1.0, 2.0]), np.ones(2), np.zeros(2)),),
        gripper=tuple(GripperEvent(time, ("picked up", "put down", "closed on nothing")[n % 3])
                      for n, time in enumerate(moments)),
        commanded=told, measured=told, battery=series((0, 13.0), (seconds / 2, 11.0)),
        motors=series((0, 1), (seconds / 2, 0)), e_stop=series((1, 1), (2, 0)),
        stalls=tuple(Span(time, time + 1, "both wheels") for time in moments),
        bumps=(Span(moments[0], moments[0] + 1, "front 2"),),
        faults=tuple(Report(time, 1 + n % 2, "/pioneer/p2os", chr(ord("a") + n % 26) * 9 + LONG_TEXT)
                     for n, time in enumerate(moments))
        + tuple(Report(time, 1, "/pioneer/simulator", "simulated 1.0 s: fault begins: loss 0.4") for time in moments),
        gaps=tuple(Span(time, time + 1.0, "/pioneer/" + name) for time in moments
                   for name in ("pose", "sonar", "battery", "stall", "cans")),
        doings=tuple(Span(begin, end, DOINGS[n % len(DOINGS)])
                     for n, (begin, end) in enumerate(zip(moments, [*moments[1:], moments[-1]]))),
        damage="it was not closed and ends within a message after 56.8 s: its recorder was killed, or the disk was "
        "full. " * 2,
    )  # fmt: skip


def navigated(true, off=0.1, **fields):
    """Return what the navigation of a robot said that drove a track, and that believed to be off to the side (m)."""
    begin, seconds = true.time[0], true.time[-1] - true.time[0]
    unsure = Span(begin, begin + seconds / 4, UNSURE)
    said = Navigated(
        true._replace(y=true.y + off), (Span(begin, begin + seconds / 2, DRIVES), Span(begin + 1, begin + 2, WAITS)),
        (unsure,), (np.column_stack((true.x, true.y)),), (np.column_stack((true.x, true.y, true.heading))[:9],),
        (Goal(begin, 1.0, 1.0, "reached"), Goal(begin + 1, 2.0, 1.0, "failed"),
         Goal(begin + 2, 2.0, 2.0, "replaced")),
        begin + seconds / 4)
    return said._replace(**fields)

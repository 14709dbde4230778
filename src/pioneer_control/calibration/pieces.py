"""Finds the runs in the poses of a recording: what lies between two rests, and looks like a line, a turn or a square.

Lengths in m, angles in rad, times in s.
"""

import math
from typing import Iterable, Iterator, List, NamedTuple, Optional, Tuple

from ..errors import CalibrationError
from ..floor_poses import Pose, relative
from .runs import RunKind
from .tracks import OdometryTrack, TrackRecorder

REST = 5.0
"""Shortest rest (s). In the corners of a square, and where somebody let go, the robot stands for less."""
STILL, STILL_TURN = 0.0005, 0.0005
"""A robot that stands moves less (m, rad) from pose to pose."""
LEAST_LINE, MOST_BEND, STRAIGHT = 1.0, math.radians(40), 0.95
"""Shortest line (m); how far its heading may turn from that at its beginning (rad); and the least share of its way
that leads ahead: it does not go to and fro."""
LEAST_TURN, MOST_WAY = 0.8 * 2.0 * math.pi, 0.1
"""Least turn on the spot (rad), and the way (m) that it stays below in each turn."""
LEAST_SQUARE, OFF_SQUARE = 2.0, math.radians(60)
"""Shortest way of a square (m), and how far its turn may be from a whole one (rad)."""


class PoseOrRate(NamedTuple):
    """One pose of odometry, or one turn rate (rad/s) of the gyro, with its stamp (s)."""

    time: float
    pose: Optional[Pose] = None
    rate: float = 0.0


class RecordedRun(NamedTuple):
    """A run in a recording.

    Attributes:
        kind: what it looks like.
        turns: whole turns by odometry, left positive, as of `TapedRun`.
        track: what was measured.
        begin: when it begins: time since the recording began (s).
    """

    kind: RunKind
    turns: int
    track: OdometryTrack
    begin: float


def kind_of_track(track: OdometryTrack) -> Optional[Tuple[RunKind, int]]:
    """Return what a track looks like, and its whole turns; None if it is no run."""
    way, turn, whole = track.way, track.turn, 2.0 * math.pi
    bend = float(abs(track.path()[2]).max())
    if way >= LEAST_LINE and bend < MOST_BEND and abs(track.ahead.sum()) > STRAIGHT * way:
        return RunKind.LINE, 0
    if abs(turn) >= LEAST_TURN and way < MOST_WAY * (1.0 + abs(turn) / whole):
        return RunKind.TURN, int(round(turn / whole)) or int(math.copysign(1, turn))
    if way >= LEAST_SQUARE and abs(abs(turn) - whole) < OFF_SQUARE:
        return RunKind.SQUARE, 1 if turn > 0 else -1
    return None


def pieces(recorded: Iterable[PoseOrRate]) -> Iterator[RecordedRun]:
    """Yield the runs in a recording, in their order. What is no run is left out.

    ``recorded``: poses and turn rates of one robot in the order in which they came.
    """
    first: Optional[float] = None
    part: List[PoseOrRate] = []         # since the last rest
    last: Optional[Pose] = None
    moved_at, began = -math.inf, 0.0
    for each in recorded:
        first = each.time if first is None else first
        if each.pose is not None:
            if last is not None and _moves(last, each.pose):
                if each.time - moved_at > REST:
                    yield from _run_in(part, began - first)
                    part, began = _end_of_rest(part), each.time
                moved_at = each.time
            last = each.pose
        part.append(each)
    if first is not None:
        yield from _run_in(part, began - first)


def _end_of_rest(part: List[PoseOrRate]) -> List[PoseOrRate]:
    """Return the last two poses of a part, and the turn rates since: where the next run begins."""
    poses = [number for number, each in enumerate(part) if each.pose is not None]
    return part[poses[-2]:] if len(poses) > 1 else part


def _moves(last: Pose, pose: Pose) -> bool:
    step = relative(last, pose)
    return math.hypot(step.x, step.y) > STILL or abs(step.heading) > STILL_TURN


def _run_in(part: List[PoseOrRate], begin: float) -> Iterator[RecordedRun]:
    """Yield the run that a part of a recording is, if it is one. A part in which a pose jumps is none."""
    recorder = TrackRecorder()
    try:
        for each in part:
            if each.pose is not None:
                recorder.pose(each.pose)
            else:
                recorder.rate(each.time, each.rate)
    except CalibrationError:
        return
    track = recorder.track
    found = kind_of_track(track) if len(track.ahead) else None
    if found is not None:
        yield RecordedRun(*found, track, begin)


def in_words(run: RecordedRun) -> str:
    """Return when a run in a recording begins, and what it is by odometry."""
    return "after %d min %02d s: %.2f m, %.0f degrees by odometry" % (
        run.begin // 60, run.begin % 60, run.track.way, math.degrees(run.track.turn))

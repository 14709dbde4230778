"""The clients of a record, played to simulated robots, whose answers are compared with those of the recorded robots.

The bytes of the clients come to the robots at their recorded times, over lines that take no time, as TCP. For a record
of a simulated robot, the same robot, world, seed and faults give the same answers, byte by byte. A real robot answers
differently where the simulation is not exact. No thread, clock of the computer or socket is in here.

The format of a record is in `p2os.recording`.
"""

import math
from typing import Iterable, Iterator, List, NamedTuple, Tuple

from ... import p2os
from ...errors import UsageError
from ...p2os import FrameDecoder
from ...p2os.recording import Entry
from ...robots import RobotModel
from ..line import LineSimulation
from ..world.poses import hypot

SAME_MOMENT = 0.1
"""SIPs that are further apart (s) are not compared."""


class Packet(NamedTuple):
    """What a robot said, and when it was whole (s)."""

    time: float
    value: object


class Comparison(NamedTuple):
    """One robot of a record and the simulated one. Poses are the robots' own."""

    robot: int
    recorded: int
    """packets"""
    simulated: int
    same: bool
    """all bytes"""
    first: str
    """the first packets that differ, in words; empty if none do"""
    apart: float
    """m, at most"""
    turned_apart: float
    """rad, at most"""
    apart_at_end: float
    """m"""

    def __str__(self) -> str:
        if self.same:
            return "robot %d: %d packets, and the simulated robot says the same, byte by byte" % (
                self.robot, self.recorded)
        return (
            "robot %d: %d packets in the record, %d of the simulated robot;"
            " poses at most %.3f m and %.1f degrees apart, %.3f m at the end\n  the first that differ: %s" % (
                self.robot, self.recorded, self.simulated, self.apart, math.degrees(self.turned_apart),
                self.apart_at_end,
                self.first))


def play_client(entries: Iterable[Entry], lines: LineSimulation) -> List[Entry]:
    """Send the robots what the clients of a record sent.

    Returns:
        The record as it is now: what their clients wrote, and what these robots answer.

    Raises:
        UsageError: the record has more robots than there are.
    """
    made: List[Entry] = []

    def run_to(time_us: int) -> None:
        made.extend(Entry(arrival.time_us / 1e6, arrival.robot + 1, False, arrival.data)
                    for arrival in lines.run_to(time_us))

    for entry in entries:
        if entry.note:
            continue
        if entry.robot > len(lines.robots):
            raise UsageError("the record has a robot %s: let there be as many simulated ones" % entry.robot)
        time_us = max(lines.clock.now_us, round(entry.time * 1e6))
        run_to(time_us)
        if entry.to_robot:
            made.append(entry)
            lines.send(entry.robot - 1, entry.data)
            run_to(time_us)
    return made


def compare(recorded: List[Entry], simulated: List[Entry], models: List[RobotModel]) -> List[Comparison]:
    """Compare what the robots of a record said with what simulated ones answer to the same."""
    found = []
    for robot, model in enumerate(models, 1):
        said_then, said_now = [[entry for entry in entries if entry.robot == robot and not entry.to_robot]
                               for entries in (recorded, simulated)]
        same = b"".join(entry.data for entry in said_then) == b"".join(entry.data for entry in said_now)
        then, now = [[*_packets(entries, model)] for entries in (said_then, said_now)]
        ways, turns = zip(*_apart(then, now, model), (0.0, 0.0))
        found.append(Comparison(
            robot, len(then), len(now), same, _first(then, now) or ("" if same else "bytes of no packet"), max(ways),
            max(turns),
            ways[-2] if len(ways) > 1 else 0.0))
    return found


def _packets(entries: List[Entry], model: RobotModel) -> Iterator[Packet]:
    decoder = FrameDecoder()
    for entry in entries:
        for frame in decoder.feed(entry.data):
            yield Packet(entry.time, p2os.decode_packet(frame, model.grip_state_first))


def _first(then: List[Packet], now: List[Packet]) -> str:
    """The first packets that differ, in words."""
    for before, after in zip(then, now):
        if before.value != after.value:
            if not isinstance(after.value, type(before.value)):
                return "at %.3f s %s, simulated at %.3f s %s" % (before.time, _kind(before), after.time, _kind(after))
            simulated = vars(after.value)
            fields = ["%s %s, simulated %s" % (name, value, simulated[name])
                      for name, value in vars(before.value).items() if value != simulated[name]]
            return "%s at %.3f s: %s" % (_kind(before), before.time, "; ".join(fields))
    for rest, whose in ((then[len(now):], "the record"), (now[len(then):], "the simulated robot")):
        if rest:
            return "%s at %.3f s, only of %s" % (_kind(rest[0]), rest[0].time, whose)
    return ""


def _kind(packet: Packet) -> str:
    return type(packet.value).__name__


def _apart(then: List[Packet], now: List[Packet], model: RobotModel) -> Iterator[Tuple[float, float]]:
    """How far (m, rad) the poses of SIPs of the same moment lie apart."""
    sips = [(time, value) for time, value in now if isinstance(value, p2os.Sip)]
    at = 0
    for time, sip in then:
        if not isinstance(sip, p2os.Sip):
            continue
        while at + 1 < len(sips) and abs(sips[at + 1][0] - time) <= abs(sips[at][0] - time):
            at += 1
        if at < len(sips) and abs(sips[at][0] - time) <= SAME_MOMENT:
            other = sips[at][1]
            x = p2os.wrapped(sip.x_counts - other.x_counts, p2os.COUNT_RANGE) * model.dist_mm_per_unit / 1000
            y = p2os.wrapped(sip.y_counts - other.y_counts, p2os.COUNT_RANGE) * model.dist_mm_per_unit / 1000
            turn = p2os.wrapped(sip.heading_units - other.heading_units, model.angle_units_per_rev)
            yield hypot(x, y), abs(turn * model.angle_rad_per_unit)

"""The client's side of a recorded line, for simulated robots: they are told what the robots of then were told, and
their answers are compared.

The bytes of the clients of a record (`p2os.recording`) come to the robots at their recorded times, over lines that
take no time, as TCP. Of a
record that a simulated robot made, the same robot, world, seed and faults give the same answers, byte by byte; a real
robot's differ by what the
simulated one is not. No thread, clock or socket is in here.
"""

import math
from typing import Iterable, Iterator, List, NamedTuple, Tuple

from ... import p2os
from ...errors import UsageError
from ...p2os import FrameDecoder
from ...p2os.recording import Entry
from ...robots import RobotModel
from ..line.line_simulation import LineSimulation
from ..world.trigonometry import hypot

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
            return "robot %s: %s packets, and the simulated robot says the same, byte by byte" % (self.robot, self.recorded)
        apart = "poses at most %.3f m and %.1f degrees apart, %.3f m at the end" % (self.apart, math.degrees(self.turned_apart), self.apart_at_end)
        return ("robot %s: %s packets in the record, %s of the simulated robot; %s\n"
                "  the first that differ: %s" % (self.robot, self.recorded, self.simulated, apart, self.first))


def play_client(entries: Iterable[Entry], lines: LineSimulation) -> List[Entry]:
    """Tell the robots what the record's were told.

    Returns:
        The record as it is now: what their clients wrote, and what these robots answer.

    Raises:
        UsageError: the record has more robots than there are.
    """
    made: List[Entry] = []

    def run_to(time_us: int) -> None:
        for arrival in lines.run_to(time_us):
            made.append(Entry(arrival.time_us / 1e6, arrival.robot + 1, False, arrival.data))

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


def compare(recorded: Iterable[Entry], simulated: Iterable[Entry], models: List[RobotModel]) -> List[Comparison]:
    """What the robots of a record said against what simulated ones say to the same."""
    both = [list(recorded), list(simulated)]
    found = []
    for robot, model in enumerate(models, 1):
        bytes_of = [b"".join(entry.data for entry in entries if entry.robot == robot and not entry.to_robot) for entries in both]
        then, now = ([*_packets(entries, robot, model)] for entries in both)
        apart = [*_apart(then, now, model)]
        found.append(Comparison(
            robot, len(then), len(now), bytes_of[0] == bytes_of[1], _first(then, now) or ("" if bytes_of[0] == bytes_of[1] else "bytes of no packet"),
            max((way for way, _ in apart), default=0.0), max((turn for _, turn in apart), default=0.0), apart[-1][0] if apart else 0.0))
    return found


def _packets(entries: List[Entry], robot: int, model: RobotModel) -> Iterator[Packet]:
    ear = FrameDecoder()
    for entry in entries:
        if entry.robot == robot and not entry.to_robot:
            for frame in ear.feed(entry.data):
                yield Packet(entry.time, p2os.decode_packet(frame, model.grip_state_first))


def _first(then: List[Packet], now: List[Packet]) -> str:
    """The first packets that differ, in words."""
    for before, after in zip(then, now):
        if before.value != after.value:
            if type(before.value) is not type(after.value):
                return "at %.3f s %s, simulated at %.3f s %s" % (before.time, _kind(before), after.time, _kind(after))
            fields = ["%s %s, simulated %s" % (name, value, vars(after.value)[name]) for name, value in vars(before.value).items()
                      if value != vars(after.value)[name]]
            return "%s at %.3f s: %s" % (_kind(before), before.time, "; ".join(fields))
    for rest, whose in ((then[len(now):], "the record"), (now[len(then):], "the simulated robot")):
        if rest:
            return "%s at %.3f s, only of %s" % (_kind(rest[0]), rest[0].time, whose)
    return ""


def _kind(packet: Packet) -> str:
    return type(packet.value).__name__


def _apart(then: List[Packet], now: List[Packet], model: RobotModel) -> Iterator[Tuple[float, float]]:
    """How far (m, rad) the poses of SIPs of the same moment lie apart."""
    sips = [packet for packet in now if isinstance(packet.value, p2os.Sip)]
    at = 0
    for time, sip in then:
        if not isinstance(sip, p2os.Sip):
            continue
        while at + 1 < len(sips) and abs(sips[at + 1].time - time) <= abs(sips[at].time - time):
            at += 1
        if at < len(sips) and abs(sips[at].time - time) <= SAME_MOMENT:
            other = sips[at].value
            x, y = (p2os.wrapped(before - after, p2os.COUNT_RANGE) * model.dist_mm_per_unit / 1000
                    for before, after in ((sip.x_counts, other.x_counts), (sip.y_counts, other.y_counts)))
            turn = p2os.wrapped(sip.heading_units - other.heading_units, model.angle_units_per_rev) * model.angle_rad_per_unit
            yield hypot(x, y), abs(turn)

"""Sends the bytes of recorded clients to simulated robots, and compares the answers with the recorded answers.

The simulated robots receive the bytes at the recorded times, over lines without delay, like TCP. If the recorded robot
was a simulated robot, the same robot, world, seed and faults give exactly the same bytes. If it was a real robot, the
answers differ where the simulation is not exact. This file uses no threads, no sockets and no real time.

For the format of a recording see `p2os.recording`.
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
"""Largest time (s) between a recorded SIP and a simulated SIP whose poses are compared."""


class Packet(NamedTuple):
    """A packet that a robot sent, with the time of its last byte (s)."""

    time: float
    value: object


class Comparison(NamedTuple):
    """Differences between the answers of a recorded robot and of a simulated robot. Poses are odometry poses."""

    robot: int
    """Number of the robot, from 1."""
    recorded: int
    """Number of recorded packets."""
    simulated: int
    """Number of packets of the simulated robot."""
    same: bool
    """Whether all bytes are equal."""
    first: str
    """Description of the first packets that differ. Empty if all bytes are equal."""
    apart: float
    """Largest distance between the positions (m)."""
    turned_apart: float
    """Largest difference between the headings (rad)."""
    apart_at_end: float
    """Distance between the last positions (m)."""

    def __str__(self) -> str:
        if self.same:
            return "robot %d: %d packets, and the simulated robot says the same, byte by byte" % (
                self.robot, self.recorded)
        return (
            "robot %d: %d packets in the record, %d of the simulated robot;"
            " poses at most %.3f m and %.1f degrees apart, %.3f m at the end\n  the first that differ: %s" % (
                self.robot, self.recorded, self.simulated, self.apart, math.degrees(self.turned_apart),
                self.apart_at_end, self.first))


def play_client(entries: Iterable[Entry], lines: LineSimulation) -> List[Entry]:
    """Send the bytes of recorded clients to simulated robots.

    Args:
        entries: entries of the recording.
        lines: simulated robots with their lines.

    Returns:
        A new recording: the bytes of the recorded clients, and the answers of the simulated robots.

    Raises:
        UsageError: the recording has more robots than the simulation.
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
    """Compare the bytes of recorded robots with those of simulated robots. Return one comparison for each robot.

    Args:
        recorded: entries of the recording.
        simulated: result of `play_client`.
        models: models of the robots, in the order of their numbers.
    """
    found = []
    for robot, model in enumerate(models, 1):
        sent_then, sent_now = [
            [entry for entry in entries if entry.robot == robot and not entry.to_robot]
            for entries in (recorded, simulated)]
        same = b"".join(entry.data for entry in sent_then) == b"".join(entry.data for entry in sent_now)
        then, now = [[*_packets(entries, model)] for entries in (sent_then, sent_now)]
        ways, turns = zip(*_pose_differences(then, now, model), (0.0, 0.0))
        found.append(Comparison(
            robot, len(then), len(now), same,
            _first_difference(then, now) or ("" if same else "bytes of no packet"),
            max(ways), max(turns), ways[-2] if len(ways) > 1 else 0.0))
    return found


def _packets(entries: List[Entry], model: RobotModel) -> Iterator[Packet]:
    decoder = FrameDecoder()
    for entry in entries:
        for frame in decoder.feed(entry.data):
            yield Packet(entry.time, p2os.decode_packet(frame, model.grip_state_first))


def _first_difference(then: List[Packet], now: List[Packet]) -> str:
    """Describe the first packets that differ between the recording (`then`) and the simulation (`now`).

    Empty if all packets are equal.
    """
    for before, after in zip(then, now):
        if before.value != after.value:
            if not isinstance(after.value, type(before.value)):
                return "at %.3f s %s, simulated at %.3f s %s" % (
                    before.time, _type_name(before), after.time, _type_name(after))
            simulated = vars(after.value)
            fields = ["%s %s, simulated %s" % (name, value, simulated[name])
                      for name, value in vars(before.value).items() if value != simulated[name]]
            return "%s at %.3f s: %s" % (_type_name(before), before.time, "; ".join(fields))
    for rest, whose in ((then[len(now):], "the record"), (now[len(then):], "the simulated robot")):
        if rest:
            return "%s at %.3f s, only of %s" % (_type_name(rest[0]), rest[0].time, whose)
    return ""


def _type_name(packet: Packet) -> str:
    return type(packet.value).__name__


def _pose_differences(then: List[Packet], now: List[Packet], model: RobotModel) -> Iterator[Tuple[float, float]]:
    """Yield the distance (m) and the angle (rad) between the odometry poses of each two SIPs with nearly equal times.

    `then` are the recorded packets, `now` the simulated packets.
    """
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

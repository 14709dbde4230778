#!/usr/bin/python3
"""Sends random bytes and random commands to simulated robots. Needs no ROS and no clock.

    python3 bench/fuzz_firmware.py      # a million strings, a hundred thousand commands, as many to robots with lasers
    python3 bench/fuzz_firmware.py --strings 20000 --commands 2000 --laser 2000 --seed 7

Robots of every firmware family take turns. Strings are noise, pieces of packets, packets with a wrong bit, and packets
of random data. Commands are those of the protocol with any legal value, and unknown numbers with any argument. Robots
with a laser over their line get commands of simulators, too.
Simulated time passes between them. Again and again the program checks that the robot still answers CLOSE, the SYNC
sequence and OPEN, that it sends SIPs every 100 ms, that all it sent were whole packets, and that it stands in no wall.
Exit status 1 when a check fails: the printed seed and number of the string reproduce it.
"""

import argparse
import os
import random
import struct
import sys
import time
from typing import Callable, List, NamedTuple

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src")
sys.path.insert(0, SOURCE)

from pioneer_control import p2os
from pioneer_control.p2os import COMMANDS, Argument
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import Can, World

MODELS = ("p3dx-sh", "peoplebot-sh", "p3at-sh", "amigo-sh", "p3dx", "p2dx", "amigo", "pion1m", "powerbot-sh", "seekur",
          "pioneer-lx")
LOOK_EVERY = 500            # strings or commands between two checks
# In the second half. In the first half a world still stores what is near the places that a robot visits.
MOST_GROWTH_KB = 3000


class Wrong(Exception):
    """Something that must always hold does not hold."""


def must(holds: bool, what: str) -> None:
    """Raise Wrong unless the condition holds."""
    if not holds:
        raise Wrong(what)


class Counts(NamedTuple):
    """What a run did."""

    inputs: int
    seconds: float
    simulated: float
    packets: int
    obeyed: int
    growth_kb: int
    late_growth_kb: int


def robot_of(name: str, seed: int, laser: bool) -> Firmware:
    """A robot in a small room with cans, perhaps with a laser over its line. The newer models have an arm."""
    walls = [(-4, -4, 4, -4), (4, -4, 4, 4), (4, 4, -4, 4), (-4, 4, -4, -4)]
    world = World("room", walls=walls, cans=[Can(0.8, 0.3), Can(1.5, -0.5), Can(-1.4, 0.4)], docks=[(0.0, 0.0, 0.0)])
    return Firmware(find_model(name), world, (0.0, 0.0, 0.0), seed=seed, arm=name.endswith("-sh"), line_laser=laser)


class Subject:
    """A robot that gets the random input, and the packets that it sends."""

    def __init__(self, name: str, seed: int, laser: bool):
        self.robot = robot_of(name, seed, laser)
        self.decoder = p2os.FrameDecoder()
        self.packets = 0
        self.open()

    def wait(self, seconds: float) -> List[int]:
        """Let time pass. Returns the ids of the packets that the robot sent."""
        frames = self.decoder.feed(self.robot.advance(seconds))
        self.packets += len(frames)
        return [frame.id for frame in frames]

    def open(self) -> None:
        """Open a session, whatever happened before; the robot must answer each step."""
        self.wait(0.2)      # so that the robot forgets half a packet
        # twice: a robot that waits for SYNC2 takes the first for that, and only the second for CLOSE
        self.robot.receive(2 * p2os.encode_frame(2))
        self.wait(0.02)
        for number in (0, 1, 2):
            self.robot.receive(p2os.encode_frame(number))
            must(self.wait(0.02) == [number], "no answer to SYNC%d" % number)
        self.robot.receive(p2os.encode_frame(1))
        must(sum(id in (0x32, 0x33) for id in self.wait(0.5)) == 5, "no SIP every 100 ms")
        self.robot.receive(p2os.encode_command("ENABLE", 1))

    def look(self) -> None:
        """Check the robot, and that it sent nothing but whole packets. Then connect to it again."""
        counts = self.decoder.counts
        must(not self.decoder.waiting and not counts.discarded_bytes and not counts.bad_checksums,
             "said something that is no packet: %s" % (counts,))
        hardware = self.robot.hardware
        must(not hardware.body.touches(hardware.model.outline(self.robot.gripper is not None)), "stands in a wall")
        must(hardware.arm is None or all(servo.minimum <= servo.position <= servo.maximum
                                         for servo in hardware.arm.servos), "has its arm out of its range")
        must(len(self.robot.decoder._held) < 260, "holds %d bytes" % len(self.robot.decoder._held))
        must(self.robot.session in FirmwareState, "is in no state of a session")
        self.open()


def any_string(draw: random.Random) -> bytes:
    """Return noise, a piece of a packet, a packet with a wrong bit, or a packet of random data."""
    kind = draw.randrange(5)
    noise = draw.getrandbits(8 * 48).to_bytes(48, "little")[:draw.randrange(49)]
    if kind == 0:
        return noise
    if kind == 1:
        return b"\xFA\xFB" + noise
    packet = p2os.encode_frame(draw.randrange(256), noise[:draw.choice((0, 3, 3, 3, 7, 20))])
    if kind == 2:
        return packet[:draw.randrange(len(packet))]
    if kind == 3:
        at = draw.randrange(len(packet))
        return packet[:at] + bytes([packet[at] ^ 1 << draw.randrange(8)]) + packet[at + 1:]
    return packet


def any_command(draw: random.Random) -> bytes:
    """Return a command of the protocol with a legal value, often an extreme one, or sometimes an unknown number."""
    if draw.random() < 0.1:
        value = draw.choice((0, 1, 0x7FFF, 0xFFFF, draw.randrange(0x10000)))
        data = draw.choice((b"", b"\x3B" + struct.pack("<H", value), b"\x1B" + struct.pack("<H", value), b"\x2B\x03abc",
                            b"\x2B\xFFab"))
        return p2os.encode_frame(draw.randrange(256), data)
    command = draw.choice(ALL)
    if command.argument is Argument.NONE or command.optional and draw.random() < 0.5:
        return p2os.encode_command(command.name)
    if command.argument is Argument.STRING:
        length = draw.randint(command.low, command.high)
        return p2os.encode_command(command.name, bytes(draw.randrange(256) for _ in range(length)))
    if command.argument is Argument.TWO_BYTES:
        return p2os.encode_command(command.name,
                                   *(draw.randint(low, high) for low, high in zip(command.low, command.high)))
    low, high = command.low, command.high
    small = draw.randint(max(low, -400), min(high, 400))
    return p2os.encode_command(command.name, draw.choice((low, high, small, small, small, draw.randint(low, high))))


ALL = tuple(COMMANDS.values())


def any_order(draw: random.Random) -> bytes:
    """Return any command, or commands of simulators with any values, often those that start a laser."""
    if draw.random() < 0.3:
        return any_command(draw)
    if draw.random() < 0.4:
        steps = 10, 25, 50, 100, 700
        values = draw.randint(-200, 100), draw.randint(-100, 200), draw.choice(steps), draw.randrange(4)
        names = ("SIM_LRF_SET_FOV_START", "SIM_LRF_SET_FOV_END", "SIM_LRF_SET_RES", "SIM_LRF_ENABLE")
        names = names if draw.random() < 0.3 else (
            "OLD_LASER_FIRST", "OLD_LASER_LAST", "OLD_LASER_STEP", "OLD_LASER_ENABLE")
        return b"".join(p2os.encode_simulator_command(*each) for each in zip(names, values) if draw.random() < 0.95)
    command = draw.choice(tuple(p2os.SIMULATOR_COMMANDS.values()))
    noise = bytes(draw.randrange(256) for _ in range(draw.choice((0, 1, 2, 3, 4, 12, 20))))
    return p2os.encode_frame(command.number, draw.choice((b"", b"\x3B", b"\x1B", b"\x2B")) + noise)


def resident_kb() -> int:
    """Return the resident memory of this process (kB)."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def throw(make: Callable[[random.Random], bytes], number: int, seed: int, longest: float,
          look_every: int = LOOK_EVERY) -> Counts:
    """Send many inputs of a kind to robots of each model in turn, with up to `longest` simulated s between them. Orders
    of simulators go to robots that have a laser over their line.
    """
    draw = random.Random(seed)
    laser = make is any_order
    subjects = [Subject(name, seed, laser) for name in MODELS if not laser or find_model(name).laser is not None]
    begin, held = time.monotonic(), []
    for count in range(number):
        subject = subjects[count // look_every % len(subjects)]
        try:
            subject.robot.receive(make(draw))
            if draw.random() < 0.3:
                subject.wait(draw.random() * longest)
            if subject.robot.session is not FirmwareState.OPEN and draw.random() < 0.1:
                subject.open()
            if count % look_every == look_every - 1:
                subject.wait(0.2)
                subject.look()
        except Exception as error:      # any error is a finding
            raise Wrong("%s, seed %d, number %d: %s: %s" % (
                subject.robot.model.subtype, seed, count, type(error).__name__, error)) from error
        if count in (number // 10, number // 2):
            held.append(resident_kb())
    robots = [subject.robot for subject in subjects]
    return Counts(
        number, time.monotonic() - begin, sum(robot.time for robot in robots),
        sum(subject.packets for subject in subjects),
        sum(robot.command_counts["obeyed"] for robot in robots), held[1] - held[0], resident_kb() - held[1])


KINDS = {"strings": (any_string, 0.05), "commands": (any_command, 0.2), "laser": (any_order, 0.1)}


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--strings", type=int, default=1000000, help="random byte strings (default: %(default)s)")
    parser.add_argument("--commands", type=int, default=100000, help="random commands (default: %(default)s)")
    parser.add_argument("--laser", type=int, default=100000,
                        help="random commands to robots with a laser over their line (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for name, (make, longest) in KINDS.items():
        try:
            counts = throw(make, getattr(options, name), options.seed, longest)
            must(counts.late_growth_kb < MOST_GROWTH_KB,
                 "memory grew by %d KB in the second half" % counts.late_growth_kb)
        except Wrong as wrong:
            print("%s: FOUND %s" % (name, wrong))
            return 1
        print("%s: %d in %.0f s (%.0f per s), %.0f s simulated, %d packets, %d obeyed, "
              "memory %+d KB from a tenth to the half, %+d KB then" % (
                  name, counts.inputs, counts.seconds, counts.inputs / counts.seconds, counts.simulated,
                  counts.packets, counts.obeyed, *counts[-2:]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

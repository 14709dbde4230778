#!/usr/bin/python3
"""Throws random commands at the simulated arm, and random packets, calls and times at the arm's session.

    python3 bench/fuzz_arm.py                              # a million of each
    python3 bench/fuzz_arm.py --inputs 20000 --seed 7

Needs no ROS and no clock. After each command the servos must be in their range, and nothing may move without power.
After each packet, the session must not be due for ever, and must never have sent what drops the arm. The unit tests do
a small share of it. bench/fuzz_arm.md has what came out.
"""

import argparse
import math
import os
import random
import sys
import time
from collections import Counter

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src"))

from pioneer_control import p2os
from pioneer_control.arm.findings import finding
from pioneer_control.arm.joints import JOINT_NAMES, JointSettings
from pioneer_control.arm.motion import Point
from pioneer_control.arm.phases import ArmSettings
from pioneer_control.arm.session import ArmSession
from pioneer_control.errors import PioneerError
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import World

COMMANDS = sorted(command.number for command in p2os.COMMANDS.values() if command.name.startswith("ARM_"))
INIT, POWER, POS = (p2os.COMMANDS[name].number for name in ("ARM_INIT", "ARM_POWER", "ARM_POS"))
WEIGHTS = [{INIT: 0.05, POS: 10.0}.get(number, 1.0) for number in COMMANDS]
"""A reset takes 0.7 s, in which the arm obeys nothing: it is rare here."""


def any_command(rng):
    """Return a command to the arm with any argument, mostly one that makes sense."""
    number, = rng.choices(COMMANDS, WEIGHTS)
    kind = rng.randrange(10)
    if number == POWER and rng.random() < 0.8:
        return p2os.encode_command("ARM_POWER", 1)
    if kind == 0:
        return p2os.encode_frame(number, bytes(rng.randrange(256) for _ in range(rng.randrange(8))))
    value = rng.choice((0, 1, 2, 255, rng.randint(1, 6) << 8 | rng.randrange(256), rng.randint(1, 600),
                        rng.randint(0, 65535)))
    return p2os.encode_frame(number, bytes((0x1B if kind == 1 else 0x3B, value & 0xFF, value >> 8)))


def fuzz_simulated_arm(rng, inputs):
    """Return counts of what happened. Raises AssertionError when the arm is where it cannot be."""
    counts = Counter()
    robot = Firmware(find_model("p3dx-sh"), World("hall"), (0.0, 0.0, 0.0), arm=True, noise=0.0)
    for frame in (0, 1, 2, 1):
        robot.receive(p2os.encode_frame(frame))
    arm = robot.hardware.arm
    for _ in range(inputs):
        robot.receive(any_command(rng))
        if rng.random() < 0.001:
            arm.switch(rng.random() < 0.9)
        if rng.random() < 0.0005:
            rng.choice((robot.restart, robot.power_cycle, robot.close_session))()
            robot.advance(1.5)
            for frame in (0, 1, 2, 1):
                robot.receive(p2os.encode_frame(frame))
        robot.advance(rng.choice((0.0, 0.0, 0.02, 0.02, 0.02, 0.1, 0.3)))
        for servo in arm.servos:
            assert servo.minimum <= servo.position <= servo.maximum and 1 <= servo.speed_ms <= 127
        assert arm.powered or not any(arm.moving)
        counts["with power"] += arm.powered
        counts["moving"] += any(arm.moving)
    counts["drops"] = arm.drops
    return counts


def any_packet(rng):
    """Return a packet of a robot with an arm, or of one that talks nonsense."""
    if rng.random() < 0.8:
        bits = rng.choice(((2, 0), (3, 0), (0, 3), (0, 7), (3, 2), (0, 0), (rng.randrange(256), rng.randrange(256))))
        return p2os.Arm(*bits, tuple(rng.randrange(256) for _ in range(6)))
    joints = tuple(p2os.ArmJoint(*(rng.randrange(256) for _ in range(6))) for _ in range(rng.randrange(9)))
    return p2os.ArmInfo(rng.choice(("1.7", "1.7", "No arm", "")), joints)


def any_motion(rng):
    """Return names of joints, and points, mostly legal ones."""
    names = rng.sample(JOINT_NAMES, rng.randrange(1, 4)) if rng.random() < 0.9 else ["nobody"]
    odd = rng.random() < 0.1
    points = [Point([rng.choice((math.nan, math.inf, 9.0)) if odd else rng.uniform(0.0, 0.05) for _ in names],
                    rng.uniform(0.0, 0.5) + index) for index in range(rng.randrange(4))]
    return names, points


def fuzz_session(rng, inputs):
    """Return counts of what happened. Raises AssertionError when the session does what it never may."""
    counts = Counter()
    session, now = ArmSession(ArmSettings((JointSettings(0.5),) * 6)), 0.0
    for number in range(inputs):
        now += rng.choice((0.0, 0.01, 0.1, 1.0))
        what = rng.randrange(12)
        if what < 7:
            session.packet(any_packet(rng), now)
        elif what == 7 and rng.random() < 0.2:
            rng.choice((lambda: session.connected(None, now), lambda: session.disconnected(now)))()
        elif what < 10 and now >= session.due:
            session.tick(now)
            assert session.due > now, "due for ever"
        else:
            command = rng.choice((
                session.power_on, session.home, session.park, session.init, session.stop,
                lambda now: session.hold("button", "pressed", now), lambda now: session.release("button"),
                lambda now: session.move(*any_motion(rng), now)))
            try:
                command(now)
                counts["obeyed"] += 1
            except PioneerError:
                counts["refused"] += 1
        for packet in session.take_commands():
            frame, = p2os.FrameDecoder().feed(packet)
            sent = p2os.decode_command(frame)
            assert sent.name.startswith("ARM_") and (sent.name, sent.value) != ("ARM_POWER", 0), sent
            counts["sent"] += 1
        if number % 10 == 0:
            finding(session, now)
            counts["notices"] += len(session.take_notices())
        if number % 100000 == 99999:
            session.end(now)
            session = ArmSession(ArmSettings((JointSettings(0.5),) * 6))
    return counts


def main():
    """Run both, and print what came out."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=1000000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    for fuzz in (fuzz_simulated_arm, fuzz_session):
        begun = time.monotonic()
        counts = fuzz(random.Random(options.seed), options.inputs)
        print("%s: %d inputs, nothing raised; %s; %.0f s" % (
            fuzz.__name__, options.inputs, ", ".join("%s %d" % pair for pair in sorted(counts.items())),
            time.monotonic() - begun), flush=True)


if __name__ == "__main__":
    main()

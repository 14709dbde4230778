#!/usr/bin/python3
"""How fast the simulated robot lives: simulated seconds per second of the processor, for one robot that drives about.

    python3 bench/simulator.py                  # every world of the gallery, p3dx-sh with 16 sonars
    python3 bench/simulator.py --world office --minutes 10

The robot turns away from what its front sonar sees, as decoded from its packets; encoding commands and decoding packets count too.
bench/simulator.md has what was measured.
"""

import argparse
import os
import statistics
import sys
import time
from typing import List

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src"))

from pioneer_control import p2os
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.loading import known_worlds, load_world

OPEN = [p2os.encode_frame(number) for number in (0, 1, 2, 1)] + [p2os.encode_command("ENABLE", 1)]
NEAR_MM = 700
SLICE = 100  # SIPs measured at a time: on a machine that has other things to do, the best slice tells what this costs


def drive(robot: Firmware, minutes: float) -> List[float]:
    """Let the robot drive about for some simulated minutes; the seconds of processor time that each slice took."""
    decoder = p2os.FrameDecoder()
    ranges = {}
    for packet in OPEN:
        robot.receive(packet)
    times = []
    for _ in range(round(minutes * 600 / SLICE)):
        start = time.process_time()
        for _ in range(SLICE):
            for frame in decoder.feed(robot.advance(0.1)):
                packet = p2os.decode_packet(frame)
                if isinstance(packet, p2os.Sip):
                    ranges.update((reading.number, reading.range_units) for reading in packet.sonar)
            near = min(ranges.get(number, 5000) for number in range(1, 7)) < NEAR_MM
            robot.receive(p2os.encode_command("VEL", 0 if near else 200))
            robot.receive(p2os.encode_command("RVEL", 30 if near else 0))
        times.append(time.process_time() - start)
    return times


def main() -> None:
    """Measure and print a line for each world."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--world", action="append", help="world to drive in (default: all that have a name)")
    parser.add_argument("--model", default="p3dx-sh")
    parser.add_argument("--minutes", type=float, default=5.0, help="simulated minutes in each (default: %(default)s)")
    options = parser.parse_args()
    print("times real time:   best   median   (us of the best for 100 ms)   contacts")
    for name in options.world or known_worlds():
        robot = Firmware(find_model(options.model), load_world(name))
        times = drive(robot, options.minutes)
        best, median = (SLICE * 0.1 / seconds for seconds in (min(times), statistics.median(times)))
        print(f"{name:<16} {best:7.0f} {median:8.0f} {1e5 / best:20.0f} {robot.contacts:20}", flush=True)


if __name__ == "__main__":
    main()

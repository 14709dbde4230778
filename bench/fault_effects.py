#!/usr/bin/python3
"""Draws two pages of small pictures: what each fault of the simulated robot, and each error of its wheels and sonar,
does.

    python3 bench/fault_effects.py                      # writes docs/images/faults.png and docs/images/options.png
    python3 bench/fault_effects.py --seed 3 -o /tmp     # other random numbers, another folder

A simple client drives a round through a room by the robot's own odometry, in simulated time: once without and once with
the fault. It never gives up: after a silence it synchronises again, and when the robot says that its motors are off it
asks for them. That shows what a fault does. (A driver for a real robot must not do that.)
"""

import argparse
import dataclasses
import math
import os
import sys
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np
from PIL import Image

from pioneer_control import p2os
from pioneer_control.p2os import Flags
from pioneer_control.pictures import BEYOND, FAINT, INK
from pioneer_control.robots import find_model
from pioneer_control.simulator.line.faults import KINDS, fault_of
from pioneer_control.simulator.picture import DOCK, ROBOT, draw_robot, draw_solids
from pioneer_control.simulator.hardware import RobotNumbers, standard_numbers
from pioneer_control.simulator.world.poses import box_walls, closed
from pioneer_control.simulator.line import LineSimulation
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import Can, World

IMAGES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "docs", "images")
MODEL = find_model("p3dx-sh")
MOUNTS = {mounted.number: mounted for mounted in MODEL.sonar}
CORNERS = ((3.4, 0.0), (3.4, 2.5), (0.0, 2.5), (0.0, 0.0))  # m: corners of the round, which begins at the last one
NEAR = 0.15  # m: nearer than this, a corner counts as passed
SPEED = 400  # mm/s
MOST_TURN = 60  # deg/s
PERIOD = 0.1  # s between two commands
LONGEST = 90.0  # s: a client that takes longer never finishes
SILENCE = 2.5  # s without a packet: the client synchronises again
ANSWER = 1.5  # s to wait for an answer to that
TICK = 5.0  # s between two marks beside a path
SETTLE, GRASP, LIFT = 1.0, 4.0, 5.0  # s that a picking client stands, closes and lifts

FAULTS = (
    "loss 0.4 from 2", "flips 0.02 from 2", "splits 0.8 from 2", "delay 0.5 from 2", "silence from 8 to 14",
    "cable from 8 to 14", "power from 8 to 10",
    "stop_button from 8 to 13", "stall from 8 to 13", "battery 10.8 from 14 to 20", "transducer 3", "gyro 0.5",
    "gripper", "charger from 2", "carry 2.8 0.6 100 from 8",
)
"""One of each kind, in the order of the page."""
NOT_DRIVEN = {"arm", "laser", "camera"}
"""Kinds that change nothing of a round, because they need such a device."""
OPTIONS = (
    ("wheels", dict(larger=0.04)),
    ("wheels", dict(right_larger=0.006)),
    ("wheels", dict(wider_apart=0.05)),
    ("wheels", dict(slip=0.1)),
    ("wheels", dict(noise=0.01)),
    ("wheels", dict(left_slip=0.1)),
    ("sonar", dict(cone_deg=8)),
    ("sonar", dict(maximum=2.0)),
    ("sonar", dict(specular_deg=8)),
    ("sonar", dict(noise=0.1)),
)
"""One of each number of `robot.yaml` that makes wheels or sonar err."""


class Run(NamedTuple):
    """What happened in one round."""

    track: np.ndarray
    """(n, 3): the true pose every `PERIOD`."""
    odometry: np.ndarray
    """(m, 2): where the client believed that it was."""
    echoes: np.ndarray
    """(k, 2): echoes of the sonar, seen from the true pose."""
    can: Tuple[float, float]
    """Place of the can at the end."""
    arrived: Optional[float]
    """Seconds until the round was finished; None if it never was."""
    voltage: float


class Insistent:
    """The client that never gives up. It takes bytes and the time (s), and returns bytes.

    Args:
        picks: whether it picks up the can at the first corner.
    """

    def __init__(self, picks: bool):
        self.pose: Optional[Tuple[float, float, float]] = None
        self.believed: List[Tuple[float, float]] = []
        self.heard: List[Tuple[int, float]] = []
        self.arrived: Optional[float] = None
        self._corners = list(CORNERS)
        self._picks = picks
        self._decoder = p2os.FrameDecoder()
        self._heard_at = self._tried_at = -10.0
        self._origin = (0.0, 0.0, 0.0)
        self._motors_on = False
        self._standing_until = 0.0
        self._then: List[Tuple[float, int]] = []

    def tick(self, data: bytes, now: float) -> bytes:
        """Receive bytes, and return the answer to them."""
        out, self.heard = b"", []
        for frame in self._decoder.feed(data):
            packet = p2os.decode_packet(frame, MODEL.grip_state_first)
            if isinstance(packet, p2os.SyncEcho):
                out += p2os.encode_frame(packet.number + 1)
            elif isinstance(packet, p2os.SyncReply):
                self._origin = self.pose or self._origin  # the robot counts from zero again
                out += p2os.encode_command("OPEN") + p2os.encode_command("ENABLE", 1)
                if self._picks:
                    out += p2os.encode_command("GRIPPER", 5)
            elif isinstance(packet, p2os.Sip):
                self._heard_at = now
                self._take(packet)
        if now - self._heard_at <= SILENCE:
            return out + self._drive(now)
        if not out and now - self._tried_at >= ANSWER:
            out = p2os.encode_frame(p2os.SYNC0)
        if out:
            self._tried_at = now
        return out

    def _take(self, sip: p2os.Sip) -> None:
        x, y = (p2os.wrapped(count, p2os.COUNT_RANGE) * MODEL.dist_mm_per_unit / 1000.0
                for count in (sip.x_counts, sip.y_counts))
        origin_x, origin_y, heading = self._origin
        self.pose = (
            origin_x + x * math.cos(heading) - y * math.sin(heading),
            origin_y + x * math.sin(heading) + y * math.cos(heading),
            heading + sip.heading_units * MODEL.angle_rad_per_unit)
        self.believed.append(self.pose[:2])
        self._motors_on = bool(sip.flags & Flags.MOTORS_ENABLED)
        self.heard = [(reading.number, reading.range_units * MODEL.range_mm_per_unit / 1000.0) for reading in sip.sonar]

    def _drive(self, now: float) -> bytes:
        """Drive towards the next corner."""
        while self._then and self._then[0][0] <= now:
            return p2os.encode_command("GRIPPER", self._then.pop(0)[1])
        x, y, heading = self.pose
        if self._corners and math.hypot(self._corners[0][0] - x, self._corners[0][1] - y) < NEAR:
            del self._corners[0]
            if self._picks and len(self._corners) == len(CORNERS) - 1:
                self._then = [(now + SETTLE, 2), (now + SETTLE + GRASP, 4)]
                self._standing_until = now + SETTLE + GRASP + LIFT
            if not self._corners:
                self.arrived = now
        speed, turn = 0, 0
        if self._corners and now >= self._standing_until:
            corner_x, corner_y = self._corners[0]
            bearing = math.remainder(math.atan2(corner_y - y, corner_x - x) - heading, 2.0 * math.pi)
            speed = round(SPEED * max(0.0, math.cos(bearing)) ** 4)
            turn = round(max(-MOST_TURN, min(MOST_TURN, math.degrees(2.0 * bearing))))
        out = p2os.encode_command("VEL", speed) + p2os.encode_command("RVEL", turn)
        return out if self._motors_on or not self._corners else p2os.encode_command("ENABLE", 1) + out


def room(picks: bool) -> World:
    """Return the room with a block in its middle, and with a can if the client picks it."""
    walls = closed([(-0.9, -0.9), (4.4, -0.9), (4.4, 3.4), (-0.9, 3.4)]) + box_walls((1.7, 1.25), (1.6, 0.9), 0.0)
    return World("room", walls, posts=[(2.6, 3.1, 0.1)], cans=[Can(2.0, 0.0)] if picks else [])


def run(fault: Optional[str], numbers: RobotNumbers, seed: int, picks: bool) -> Run:
    """Drive one round."""
    simulation = Simulation(room(picks))
    firmware = simulation.add(MODEL, gripper=True, numbers=numbers, seed=seed)
    lines = LineSimulation(simulation, seed, [fault_of(fault)] if fault else [])
    client = Insistent(picks)
    track, echoes, data = [], [], b""
    while lines.time < LONGEST and (client.arrived is None or lines.time < client.arrived + 3.0):
        out = client.tick(data, lines.time)
        track.append(firmware.true_pose)
        echoes += [_echo(number, distance, track[-1]) for number, distance in client.heard if number in MOUNTS and
                   distance < numbers.sonar.maximum]
        if out:
            lines.send(0, out)
        data = b"".join(arrival.data for arrival in lines.advance(PERIOD))
    cans = firmware.world.cans
    return Run(np.array(track), np.array(client.believed), np.array(echoes).reshape(-1, 2),
               (cans[0].x, cans[0].y) if cans else (0.0, 0.0),
               client.arrived, firmware.hardware.battery.voltage)


def _echo(number: int, distance: float, pose: Tuple[float, float, float]) -> Tuple[float, float]:
    """Return the place from which the echo of a transducer seems to come."""
    mounted = MOUNTS[number]
    x, y = mounted.x + distance * math.cos(mounted.heading), mounted.y + distance * math.sin(mounted.heading)
    return pose[0] + x * math.cos(pose[2]) - y * math.sin(pose[2]), pose[1] + x * math.sin(pose[2]) + y * math.cos(
        pose[2])


class Panel(NamedTuple):
    """One small picture: what differs, and the run without and with it."""

    title: str
    plain: Run
    other: Run
    sonar: bool = False
    picks: bool = False
    voltage: bool = False


def fault_panels(seed: int) -> List[Panel]:
    """Return one panel for each kind of fault."""
    fused = dataclasses.replace(standard_numbers(), gyro=dataclasses.replace(standard_numbers().gyro, kind=2))
    plain: Dict[Tuple[bool, bool], Run] = {}
    panels = []
    for fault in FAULTS:
        kind = fault.split()[0]
        picks, numbers = kind == "gripper", fused if kind == "gyro" else standard_numbers()
        key = picks, kind == "gyro"
        if key not in plain:
            plain[key] = run(None, numbers, seed, picks)
        panels.append(Panel(fault, plain[key], run(fault, numbers, seed, picks), kind == "transducer", picks,
                            kind == "charger"))
    return panels


def option_panels(seed: int) -> List[Panel]:
    """Return one panel for each number that makes wheels or sonar err."""
    own = standard_numbers()
    plain = run(None, own, seed, False)
    panels = []
    for section, values in OPTIONS:
        numbers = dataclasses.replace(own, **{section: dataclasses.replace(getattr(own, section), **values)})
        (name, value), = values.items()
        panels.append(Panel("%s.%s %g" % (section, name, value), plain, run(None, numbers, seed, False),
                            section == "sonar"))
    return panels


def effect(panel: Panel) -> str:
    """Return the difference between the two runs, in figures."""
    plain, other = panel.plain, panel.other
    words = []
    if other.arrived is None:
        words.append("never round")
    elif abs(other.arrived - plain.arrived) >= 0.25:
        words.append("round after %.0f s, else %.0f s" % (other.arrived, plain.arrived))
    aside = max(np.hypot(*(plain.track[:, :2] - place).T).min() for place in other.track[:, :2])
    if aside >= 0.03:
        words.append("up to %.0f cm off the path" % (100 * aside))
    if panel.sonar:
        words.append("{} echoes, {:.0f} cm off walls; else {}, {:.0f} cm".format(*_heard(other), *_heard(plain)))
    if panel.picks:
        words.append("can {:.1f} m from where it should be".format(
            math.hypot(other.can[0] - plain.can[0], other.can[1] - plain.can[1])))
    if panel.voltage:
        words.append("%.2f V at the end, else %.2f V" % (other.voltage, plain.voltage))
    return ", ".join(words) or "no effect on the path"


def _heard(run_: Run) -> Tuple[int, float]:
    """Return how many echoes there are, and their mean distance (cm) from the nearest wall or post."""
    world = room(False)
    return len(run_.echoes), 100.0 * float(np.mean([world.clearance(x, y) for x, y in run_.echoes.tolist()]))


def draw(panels: List[Panel], columns: int, title: str, output: str) -> None:
    """Draw one page."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = math.ceil(len(panels) / columns)
    page = Figure(figsize=(3.3 * columns, 3.25 * rows + 0.9), facecolor="white")
    FigureCanvasAgg(page)
    for number, panel in enumerate(panels):
        axes = page.add_axes([(number % columns + 0.03) / columns,
                              (0.1 + 3.25 * (rows - 1 - number // columns)) / (3.25 * rows + 0.9),
                              0.94 / columns, 2.6 / (3.25 * rows + 0.9)])
        _draw_panel(axes, panel)
    height = 3.25 * rows + 0.9
    page.text(0.1 / (3.3 * columns), 1 - 0.27 / height, title, fontsize=15, fontweight="bold", color=INK, va="center")
    for label, colour, at in (("undisturbed", DOCK, 0.1), ("with it", ROBOT, 1.35),
                              ("where it believed to be", FAINT, 2.3)):
        page.text(at / (3.3 * columns), 1 - 0.58 / height, label, fontsize=10, color=colour, va="center",
                  fontweight="bold")
    page.text(4.5 / (3.3 * columns), 1 - 0.58 / height, "a dot every %g s; robot drawn where it ends" % TICK,
              fontsize=10, color=INK, va="center")
    page.savefig(output, dpi=75)
    with Image.open(output) as picture:
        small = picture.convert("RGB").quantize(64)
    small.save(output, optimize=True)


def _draw_panel(axes, panel: Panel) -> None:
    axes.set(xlim=(-1.0, 4.5), ylim=(-1.0, 3.5), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_color(BEYOND)
    draw_solids(axes, room(False))
    if panel.sonar:
        axes.plot(*panel.plain.echoes.T, ".", color=DOCK, markersize=2.2, alpha=0.5, zorder=2)
        axes.plot(*panel.other.echoes.T, ".", color=ROBOT, markersize=2.2, alpha=0.5, zorder=2)
    axes.plot(*panel.plain.track[:, :2].T, color=DOCK, linewidth=4.0, alpha=0.45, zorder=3.5, solid_capstyle="round")
    axes.plot(*panel.other.odometry.T, color=FAINT, linewidth=1.2, linestyle=(0, (4, 2)), zorder=4)
    axes.plot(*panel.other.track[:, :2].T, color=ROBOT, linewidth=1.5, zorder=5)
    axes.plot(*panel.other.track[:: round(TICK / PERIOD), :2].T, "o", color="white", markeredgecolor=ROBOT,
              markersize=4, zorder=6)
    draw_robot(axes, MODEL.outline(True), tuple(panel.other.track[-1]))
    if panel.picks:
        for run_, colour in ((panel.plain, DOCK), (panel.other, ROBOT)):
            axes.plot(*run_.can, "o", color=colour, markeredgecolor=INK, markersize=7, zorder=7)
    axes.text(0.0, 1.135, panel.title, transform=axes.transAxes, fontsize=11, fontweight="bold", color=INK)
    axes.text(0.0, 1.03, effect(panel), transform=axes.transAxes, fontsize=8.2, color=INK)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of all luck (default: %(default)s)")
    parser.add_argument("-o", "--output", default=IMAGES, metavar="FOLDER",
                        help="where the pictures go (default: docs/images)")
    options = parser.parse_args()
    missing = set(KINDS) - NOT_DRIVEN - {fault.split()[0] for fault in FAULTS}
    if missing:
        print("no picture for %s" % ", ".join(sorted(missing)), file=sys.stderr)
        return 1
    for name, panels, columns, title in (
        ("faults", fault_panels(options.seed), 5, "What each fault does to a run"),
        ("options", option_panels(options.seed), 3, "What errors of wheels and sonar do to a run"),
    ):
        for panel in panels:
            print("%28s %s" % (panel.title, effect(panel)))
        draw(panels, columns, title, os.path.join(options.output, "%s.png" % name))
    return 0


if __name__ == "__main__":
    sys.exit(main())

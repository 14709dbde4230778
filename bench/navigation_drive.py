"""The part "drive" of bench/navigation.py: how often a robot reaches goals, what it touches, and how long it takes.

Each seed is a world, a robot with wheels and sonar that err, up to three obstacles that are on no map, and goals one
after the other. People walk to and fro, and wait where the robot stands in the way; a touch of a robot that stands is
counted apart. Ideal is the shortest way of the map at full speed.
"""

import argparse
import functools
import math
import os
import random
import sys
import time
from multiprocessing import Pool
from typing import List, NamedTuple, Tuple

import numpy as np
from simulated_robot import CYCLE, SimulatedRobot
from navigation_cases import Case, case, seeds_of, with_gripper
from navigation_wanders import map_of

from pioneer_control import p2os
from pioneer_control.floor_poses import Pose, wrapped
from pioneer_control.maps.grid_map import GridMap
from pioneer_control.navigation.chassis import Chassis
from pioneer_control.navigation.frames import into
from pioneer_control.navigation.navigator import Decision, Navigator, Readiness, State
from pioneer_control.navigation.node.parameters import NavigationParameters
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import PlanningNumbers
from pioneer_control.simulator.world.generated import with_unmapped, with_walkers
from pioneer_control.simulator.world.people import people_of

_PARAMETERS = NavigationParameters()
SPEED, TURN_RATE = _PARAMETERS.max_linear, _PARAMETERS.max_angular     # m/s, rad/s: as the node drives
LONGEST = 300.0     # s, for one goal
WRONG = 0.5     # m: a robot that is sure and farther off than that is wrong
LONGEST_WRONG = 5.0     # s: no robot may be wrong for longer


class TruePlace(NamedTuple):
    """Where the robot truly is, as if localisation knew it."""

    pose: Pose
    sure: bool = True
    reason: str = ""
    line: Tuple[Pose, ...] = ()


class Leg(NamedTuple):
    """One goal: what became of it. Lengths in m, times in s, angles in rad."""

    seed: int
    world: str
    model: str
    number: int
    state: str
    reason: str
    contacts: int
    touches: int
    time: float
    way: float
    shortest: float
    off: float
    off_heading: float
    costs: Tuple[float, ...]
    unsure: float
    wrong: float
    contact: str


def goals_of(grid_map: GridMap, chassis: Chassis, start, count: int, luck: random.Random) -> List[Pose]:
    """Return goals where the robot can turn on the spot, and that can be reached."""
    floor = DrivableFloor(grid_map, chassis.half_width, PlanningNumbers())
    rows, columns = np.nonzero(floor.clearance >= chassis.reach + 0.1)
    picks = [(int(r), int(c)) for r, c in zip(rows, columns)]
    found: List[Pose] = []
    here = start
    for _ in range(3000):
        x, y = (float(each) for each in grid_map.middle(*luck.choice(picks)))
        if math.hypot(x - here[0], y - here[1]) > 1.5 and not floor.refusal(start, (x, y)):
            found.append(Pose(x, y, luck.uniform(-math.pi, math.pi)))
            here = (x, y)
            if len(found) == count:
                break
    return found


def set_accelerations(robot: SimulatedRobot, wanted) -> None:
    """Set the robot's accelerations, as the driver does when it is asked."""
    linear, braking, angular = round(wanted.linear * 1000), round(wanted.braking * 1000), round(
        math.degrees(wanted.angular))
    for command in (("SETA", linear), ("SETA", -braking), ("SETRA", angular), ("SETRA", -angular)):
        robot.firmware.receive(p2os.encode_command(*command))


def chassis_of(robot: SimulatedRobot, gripper: bool = False) -> Chassis:
    """Return a robot as navigation knows it."""
    return Chassis(tuple(robot.shape.transducers), tuple(robot.model.outline(gripper)), SPEED, TURN_RATE)


def prepared(its: Case, count: int) -> Tuple[GridMap, Chassis, List[Pose], random.Random]:
    """Return the map of a case, its robot, its goals, and the luck that goes on from there."""
    luck = random.Random("drive %s" % its.seed)
    grid_map = map_of(its.world)
    chassis = chassis_of(SimulatedRobot(its.setup, its.world, its.seed), its.setup.gripper)
    return grid_map, chassis, goals_of(grid_map, chassis, its.world.starts[0][:2], count, luck), luck


class Drive:
    """One robot on the way to its goals: its world, what it knows, and what became of it."""

    def __init__(self, seed: int, options):
        its = case(seed, options.specular)
        if options.gripper:
            its = with_gripper(its)
        self.seed, self.model, self.verbose = seed, its.setup.model, options.verbose
        self.grid_map, self.chassis, self.goals, luck = prepared(its, options.goals)
        kept = its.world.changed(goals={str(number): goal for number, goal in enumerate(self.goals)})
        self.world = with_walkers(with_unmapped(kept, luck.randint(0, 3), seed), options.walkers, seed)
        self.robot = SimulatedRobot(its.setup._replace(laser=options.laser), self.world, seed)
        self.world.crowd.enter(self.robot.firmware.hardware.body)     # so that people see it
        self.people = people_of(self.world)
        for person in self.people:
            self.world.crowd.enter(person)
        self.navigator = Navigator(self.grid_map, self.chassis)
        set_accelerations(self.robot, self.navigator.acceleration_wanted)
        self.locate = locator(options, self.grid_map, self.robot, seed)
        self.trail: List[Tuple[Pose, State]] = []
        sensing = self.robot.sense()
        self.time = sensing.time
        self.navigator.step(sensing, self.locate(sensing), Readiness(), self.time)

    def to(self, number: int, goal: Pose) -> Leg:
        """Drive to a goal, and return what became of it."""
        firmware, begin = self.robot.firmware, self.time
        contacts, touches = firmware.contacts, firmware.touched_by_people
        here = firmware.true_pose
        shortest = self.navigator.shortest(here[:2], goal[:2])
        refusal = self.navigator.go_to(goal.x, goal.y, goal.heading, begin)
        if refusal:
            print("seed %d: %s" % (self.seed, refusal))
        costs, way, unsure, wrong, longest_wrong, decision, contact = [], 0.0, 0.0, 0.0, 0.0, None, ""
        while self.time - begin < LONGEST:
            place, decision, cost = self.packet()
            costs.append(cost)
            truth = firmware.true_pose
            unsure += 0.0 if place.sure else CYCLE
            off = math.hypot(truth[0] - place.pose.x, truth[1] - place.pose.y)
            wrong = wrong + CYCLE if place.sure and off > WRONG else 0.0
            longest_wrong = max(longest_wrong, wrong)
            way += math.hypot(truth[0] - here[0], truth[1] - here[1])
            here = truth
            if not contact and firmware.contacts > contacts:
                contact = self._told(decision)
            if not decision.state.has_goal:
                break
        return Leg(self.seed, self.world.name, self.model, number, decision.state.value, decision.reason,
                   firmware.contacts - contacts, firmware.touched_by_people - touches, self.time - begin, way, shortest,
                   math.hypot(here[0] - goal.x, here[1] - goal.y), abs(wrapped(here[2] - goal.heading)), tuple(costs),
                   unsure, longest_wrong, contact)

    def packet(self):
        """Let people and robot move until the next packet, and answer it. Return place, decision and its cost (s)."""
        for person in self.people:
            for _ in person.step(CYCLE):
                self.robot.firmware.hardware.touched_by_person()
        sensing = self.robot.sense()
        self.time = sensing.time
        place = self.locate(sensing)
        began = time.process_time()
        decision = self.navigator.step(sensing, place, Readiness(), self.time)
        cost = time.process_time() - began
        self.robot.command(*decision.twist)
        truth = Pose(*self.robot.firmware.true_pose)
        self.trail.append((truth, decision.state))
        if self.verbose:
            print("%7.1f %5.2f %5.2f  %6.2f %6.2f %5.2f  %s: %s" % (
                self.time, *decision.twist, *truth, decision.state, decision.reason), self.robot.firmware.contacts,
                  file=sys.stderr)
        return place, decision, cost

    def _told(self, decision: Decision) -> str:
        """Return where the robot is now, what it was told, and where the people are (robot's frame), for people."""
        truth = Pose(*self.robot.firmware.true_pose)
        near = [tuple(round(float(each), 2) for each in into(truth, *person.pose[:2])) for person in self.people]
        return "at %.1f s %s, told (%.2f, %.2f), people at %s" % (
            self.time, tuple(round(each, 2) for each in truth), *decision.twist, near)


def run(seed: int, options) -> List[Leg]:
    """Drive to the goals of a seed."""
    drive = Drive(seed, options)
    legs = [drive.to(number, goal) for number, goal in enumerate(drive.goals)]
    if options.picture and (options.all_pictures or any(map(failed, legs))):
        draw(options.picture, drive, legs)
    return legs


def locator(options, grid_map, robot, seed):
    """Return the function that gives the place for each sensing."""
    if not options.localised:
        return lambda sensing: TruePlace(Pose(*robot.firmware.true_pose))
    from pioneer_control.navigation.localisation import Localisation
    luck = random.Random("start %s" % seed)
    truth = robot.firmware.true_pose
    start = Pose(truth[0] + luck.uniform(-0.3, 0.3), truth[1] + luck.uniform(-0.3, 0.3),
                 truth[2] + luck.uniform(-0.2, 0.2))
    localisation = Localisation(grid_map, robot.shape.transducers, seed=seed)
    localisation.known_start(start)
    return localisation.update


def draw(folder: str, drive: Drive, legs: List[Leg]) -> None:
    """Draw what happened into a picture."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(10, 10))
    low_x, low_y, high_x, high_y = drive.grid_map.bounds
    axes.imshow(np.where(drive.grid_map.cells == 100, 0, np.where(drive.grid_map.cells == 0, 255, 200)), origin="lower",
                extent=(low_x, high_x, low_y, high_y), cmap="gray", vmin=0, vmax=255)
    for obstacle in drive.world.unmapped:
        for x1, y1, x2, y2 in obstacle.walls:
            axes.plot([x1, x2], [y1, y2], "r-", linewidth=0.8)
        for x, y, radius in obstacle.posts:
            axes.add_patch(pyplot.Circle((x, y), radius, color="r", fill=False))
    xs, ys = zip(*[each[0][:2] for each in drive.trail])
    axes.plot(xs, ys, "b-", linewidth=0.7)
    for number, goal in enumerate(drive.goals):
        axes.annotate(str(number), goal[:2], color="g")
        axes.arrow(goal.x, goal.y, 0.3 * math.cos(goal.heading), 0.3 * math.sin(goal.heading), color="g", width=0.02)
    x, y, heading = drive.trail[-1][0]
    corners = [(x + a * math.cos(heading) - b * math.sin(heading), y + a * math.sin(heading) + b * math.cos(heading))
               for a, b in drive.chassis.outline]
    axes.add_patch(pyplot.Polygon(corners, fill=False, color="b"))
    axes.set_title("\n".join("%d: %s %s, %d contacts" % (leg.number, leg.state, leg.reason, leg.contacts)
                             for leg in legs), fontsize=8)
    axes.set_aspect("equal")
    os.makedirs(folder, exist_ok=True)
    figure.savefig(os.path.join(folder, "drive-%d.png" % drive.seed), dpi=80)
    pyplot.close(figure)


def at(values, share: float) -> float:
    """Return the value below which this share of values lies."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else math.nan


def report(legs: List[Leg]) -> str:
    """Return the rows of the issue's table."""
    there = [leg for leg in legs if leg.state == "reached"]
    costs = [cost * 1000 for leg in legs for cost in leg.costs]
    rows = [
        ("goals reached", "%d of %d = %.1f %%" % (len(there), len(legs), 100 * len(there) / max(1, len(legs)))),
        ("contacts; touches by walkers", "%d; %d" % (sum(leg.contacts for leg in legs),
                                                     sum(leg.touches for leg in legs))),
        ("time over ideal, median / 95 %", "%.2f / %.2f" % tuple(
            at([leg.time / (leg.shortest / SPEED) for leg in there], share) for share in (0.5, 0.95))),
        ("way over shortest, median / 95 %", "%.3f / %.3f" % tuple(
            at([leg.way / leg.shortest for leg in there], share) for share in (0.5, 0.95))),
        ("off at the end, median / 95 %", "%.3f / %.3f m; %.1f / %.1f deg" % (
            *(at([leg.off for leg in there], share) for share in (0.5, 0.95)),
            *(math.degrees(at([leg.off_heading for leg in there], share)) for share in (0.5, 0.95)))),
        ("cost of a step, mean / 99 % / worst", "%.2f / %.1f / %.1f ms" % (
            sum(costs) / max(1, len(costs)), at(costs, 0.99), max(costs, default=0.0))),
        ("unsure, share of the time", "%.2f %%" % (100 * sum(leg.unsure for leg in legs)
                                                   / max(1e-9, sum(leg.time for leg in legs)))),
        ("sure while %g m off, longest" % WRONG, "%.1f s; %d goals with more than %g s" % (
            max((leg.wrong for leg in legs), default=0.0), sum(leg.wrong > LONGEST_WRONG for leg in legs),
            LONGEST_WRONG)),
    ]
    return "\n".join("%-38s %s" % row for row in rows)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1041", help="first-last, or several by ',' (default: %(default)s)")
    parser.add_argument("--goals", type=int, default=3, help="in each world (default: %(default)s)")
    parser.add_argument("--walkers", type=int, default=0, help="people who walk in each world (default: %(default)s)")
    parser.add_argument("--localised", type=int, choices=[0, 1], default=1, help="0: the robot is told its true pose")
    parser.add_argument("--gripper", action="store_true", help="robots that can carry a gripper have one")
    parser.add_argument("--specular", type=float, default=40.0,
                        help="degrees beyond which a wall returns no echo (default: %(default)s)")
    parser.add_argument("--laser", action="store_true", help="the robot has a laser, too")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--picture", metavar="DIR", help="draw what failed into this folder")
    parser.add_argument("--all-pictures", action="store_true", help="draw all")
    parser.add_argument("--verbose", action="store_true", help="print each step")


def main(options: argparse.Namespace) -> int:
    """Run what the command line says. Return 0 if no goal `failed`, 1 if one did."""
    legs: List[Leg] = []
    began = time.perf_counter()
    with Pool(options.processes) as pool:
        for some in pool.imap(functools.partial(run, options=options), seeds_of(options.seeds)):
            legs += some
            for leg in filter(failed, some):
                print("seed %d (%s, %s) goal %d: %s after %.0f s: %s; wrong for %.1f s; %d contacts %s" % (
                    leg.seed, leg.world, leg.model, leg.number, leg.state, leg.time, leg.reason, leg.wrong,
                    leg.contacts, leg.contact), flush=True)
    print("seeds %s, %d goals, %d walkers, %s, s%g: %.0f s" % (
        options.seeds, options.goals, options.walkers, "localised" if options.localised else "true pose",
        options.specular, time.perf_counter() - began) + (", with a laser" if options.laser else ""))
    print(report(legs))
    return int(any(map(failed, legs)))


def failed(leg: Leg) -> bool:
    """Return whether a goal was not reached, or something was touched on the way, or the robot was wrong for long."""
    return leg.state != "reached" or leg.contacts > 0 or leg.wrong > LONGEST_WRONG

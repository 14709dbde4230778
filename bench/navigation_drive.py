"""Drives to goals: how often a robot gets there, what it touches, how long it takes, and what deciding costs.

    python3 bench/navigation_drive.py --seeds 1000-1041 --goals 5 --walkers 1 --picture /tmp/pioneer

Each seed is a world, a robot with wheels and sonar that err, up to three obstacles that are on no map, and goals one
after the other. A person walks to and fro, and waits where the robot stands in the way; a touch that the person's step
would make is counted apart. Ideal is the shortest way of the map at full speed.
"""

import argparse
import math
import os
import random
import sys
import time
from multiprocessing import Pool
from typing import List, NamedTuple, Tuple

import numpy as np
from navigation_cases import case
from simulated_robot import CYCLE, SimulatedRobot

from pioneer_control import p2os
from pioneer_control.floor_poses import Pose, wrapped
from pioneer_control.maps.grid_map import GridMap
from pioneer_control.navigation.chassis import Chassis
from pioneer_control.navigation.navigator import Navigator, Readiness, State
from pioneer_control.navigation.planning import DrivableFloor
from pioneer_control.navigation.tuned import PlanningNumbers
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.geometry import Block, outlines_meet
from pioneer_control.simulator.world.poses import box_walls

SPEED, TURN_RATE = 0.4, 1.2     # m/s, rad/s
LONGEST = 300.0     # s, for one goal
PERSON = 0.25       # m, radius
LOOKS_AHEAD = 0.4   # m, at which the person waits for a robot
WALKING = 0.5       # m/s


class TruePlace(NamedTuple):
    """Where the robot truly is, as if localisation knew it."""

    pose: Pose
    sure: bool = True
    reason: str = ""


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


class Walker:
    """A person who walks to and fro: a disc that sonar hears, and that waits before it would touch a robot."""

    def __init__(self, floor: DrivableFloor, places: List[Tuple[float, float]], world: World, luck: random.Random):
        self.reach, self.box = PERSON, Block(-PERSON, PERSON, -PERSON, PERSON)
        self._floor, self._places, self._luck, self._world = floor, places, luck, world
        x, y = luck.choice(places)
        self.pose = (x, y, 0.0)
        self._way: List[Tuple[float, float]] = []
        self._waited = 0.0
        self.touches, self._touching = 0, False
        world.crowd.enter(self)

    @property
    def outline(self):
        return [(self.pose[0] + PERSON * math.cos(k * math.pi / 6), self.pose[1] + PERSON * math.sin(k * math.pi / 6))
                for k in range(12)]

    @property
    def candidates(self):
        return [(0.0, self.pose[0], self.pose[1], PERSON, 0.0, -1.0)]

    def walk(self, seconds: float, robot) -> None:
        """Walk for some time. `robot`: the body of the robot."""
        if not self._way:
            self._way = self._floor.to(self._luck.choice(self._places)).points_from(self.pose[:2])[1:]
        before, left = self.pose, WALKING * seconds
        x, y = self.pose[:2]
        while self._way and left > 0.0:
            dx, dy = self._way[0][0] - x, self._way[0][1] - y
            step = min(left, math.hypot(dx, dy))
            if step == math.hypot(dx, dy):
                x, y = self._way.pop(0)
            else:
                x, y = x + dx * step / math.hypot(dx, dy), y + dy * step / math.hypot(dx, dy)
            left -= max(step, 1e-6)
        self.pose = (x, y, 0.0)
        touching = outlines_meet(robot.outline, self.outline)
        length = math.hypot(x - before[0], y - before[1])
        if length > 0.0:
            self.pose = (x + (x - before[0]) * LOOKS_AHEAD / length, y + (y - before[1]) * LOOKS_AHEAD / length, 0.0)
        seen = outlines_meet(robot.outline, self.outline)
        self.pose = (x, y, 0.0)
        if touching or seen:
            self.pose = before
            self._waited += seconds
            if self._waited > 3.0:
                self._way, self._waited = [], 0.0
        self.touches += touching and not self._touching
        self._touching = touching
        self._world.crowd.moved(self)


def with_obstacles(world: World, grid_map: GridMap, chassis: Chassis, keep_free, luck: random.Random) -> World:
    """Return a copy of a world with up to three boxes and posts more, which leave a way between some places."""
    walls, posts, placed = list(world.walls.tolist()), list(world.posts.tolist()), 0
    floor = DrivableFloor(grid_map, chassis.half_width, PlanningNumbers())
    for _ in range(30):
        row, column = luck.randrange(grid_map.cells.shape[0]), luck.randrange(grid_map.cells.shape[1])
        x, y = (float(each) for each in grid_map.middle(row, column))
        if floor.clearance[row, column] < 0.3 or min(math.hypot(x - a, y - b) for a, b in keep_free) < 0.9:
            continue
        if luck.random() < 0.5:
            added, more = [], [(x, y, luck.uniform(0.05, 0.15))]
        else:
            size = luck.uniform(0.2, 0.6), luck.uniform(0.2, 0.5)
            added, more = [list(each) for each in box_walls((x, y), size, luck.uniform(-3.0, 3.0))], []
        trial = World(world.name, walls + added, posts + more, starts=world.starts)
        cells, origin = trial.occupancy(grid_map.resolution)
        narrower = DrivableFloor(GridMap(cells, grid_map.resolution, origin), chassis.half_width + 0.08,
                                 PlanningNumbers())
        if all(not narrower.refusal(keep_free[0], place) for place in keep_free[1:]):
            walls, posts, placed = walls + added, posts + more, placed + 1
            if placed == 3:
                break
    return World(world.name, walls, posts, starts=world.starts, boxes=world.boxes)


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


def run(seed: int, options) -> List[Leg]:
    """Drive to the goals of a seed."""
    its = case(seed, options.specular)
    luck = random.Random("drive %s" % seed)
    cells, origin = its.world.occupancy(0.05)
    grid_map = GridMap(cells, 0.05, origin)
    probe = SimulatedRobot(its.setup, its.world, seed)
    chassis = Chassis(tuple(probe.shape.transducers), tuple(probe.model.outline(its.setup.gripper)), SPEED, TURN_RATE)
    start = its.world.starts[0]
    goals = goals_of(grid_map, chassis, start[:2], options.goals, luck)
    world = with_obstacles(its.world, grid_map, chassis, [start[:2]] + [goal[:2] for goal in goals], luck)
    robot = SimulatedRobot(its.setup, world, seed)
    walkers = []
    if options.walkers:
        whole = world.occupancy(0.05)
        floor = DrivableFloor(GridMap(whole[0], 0.05, whole[1]), PERSON, PlanningNumbers())
        rows, columns = np.nonzero(floor.clearance > PERSON + 0.1)
        picks = [tuple(float(e) for e in floor._map.middle(r, c)) for r, c in zip(rows, columns)]
        places = [each for each in luck.sample(picks, min(40, len(picks))) if not floor.refusal(goals[0][:2], each)]
        walkers = [Walker(floor, places, world, luck) for _ in range(options.walkers)]
    navigator = Navigator(grid_map, chassis)
    set_accelerations(robot, navigator.acceleration_wanted)
    locate = locator(options, grid_map, robot, seed)
    legs, trail = [], []
    body = robot.firmware.hardware.body
    sensing = robot.sense()
    place = locate(sensing)
    navigator.step(sensing, place, Readiness(), sensing.time)
    for number, goal in enumerate(goals):
        begin, before = sensing.time, (robot.firmware.contacts, sum(each.touches for each in walkers))
        here = robot.firmware.true_pose
        shortest = navigator.shortest(here[:2], goal[:2])
        refusal = navigator.go_to(goal.x, goal.y, goal.heading, sensing.time)
        if refusal:
            print("seed %d: %s" % (seed, refusal))
        costs, way, unsure, decision = [], 0.0, 0.0, None
        while sensing.time - begin < LONGEST:
            for walker in walkers:
                walker.walk(CYCLE, body)
            sensing = robot.sense()
            place = locate(sensing)
            unsure += 0.0 if place.sure else CYCLE
            began = time.perf_counter()
            decision = navigator.step(sensing, place, Readiness(), sensing.time)
            costs.append(time.perf_counter() - began)
            robot.command(*decision.twist)
            truth = robot.firmware.true_pose
            way += math.hypot(truth[0] - here[0], truth[1] - here[1])
            here = truth
            if options.verbose:
                print("%7.1f %5.2f %5.2f  %6.2f %6.2f %5.2f  %s: %s" % (
                    sensing.time, *decision.twist, *truth, decision.state, decision.reason), robot.firmware.contacts,
                      file=sys.stderr)
            trail.append((here, decision.state))
            if decision.state in (State.REACHED, State.FAILED):
                break
        legs.append(Leg(
            seed, world.name, its.setup.model, number, decision.state.value, decision.reason,
            robot.firmware.contacts - before[0], sum(each.touches for each in walkers) - before[1],
            sensing.time - begin, way, shortest, math.hypot(here[0] - goal.x, here[1] - goal.y),
            abs(wrapped(here[2] - goal.heading)), tuple(costs), unsure))
    bad = any(leg.state != "reached" or leg.contacts for leg in legs)
    if options.picture and (bad or options.all_pictures):
        draw(options.picture, seed, world, grid_map, trail, goals, navigator, chassis, legs)
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


def draw(folder, seed, world, grid_map, trail, goals, navigator, chassis, legs) -> None:
    """Draw what happened into a picture."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(10, 10))
    low_x, low_y, high_x, high_y = grid_map.bounds
    axes.imshow(np.where(grid_map.cells == 100, 0, np.where(grid_map.cells == 0, 255, 200)), origin="lower",
                extent=(low_x, high_x, low_y, high_y), cmap="gray", vmin=0, vmax=255)
    for x1, y1, x2, y2 in world.walls.tolist():
        axes.plot([x1, x2], [y1, y2], "r-", linewidth=0.8)
    for x, y, radius in world.posts.tolist():
        axes.add_patch(pyplot.Circle((x, y), radius, color="r", fill=False))
    xs, ys = zip(*[each[0][:2] for each in trail])
    axes.plot(xs, ys, "b-", linewidth=0.7)
    for number, goal in enumerate(goals):
        axes.annotate(str(number), goal[:2], color="g")
        axes.arrow(goal.x, goal.y, 0.3 * math.cos(goal.heading), 0.3 * math.sin(goal.heading), color="g", width=0.02)
    x, y, heading = trail[-1][0]
    corners = [(x + a * math.cos(heading) - b * math.sin(heading), y + a * math.sin(heading) + b * math.cos(heading))
               for a, b in chassis.outline]
    axes.add_patch(pyplot.Polygon(corners, fill=False, color="b"))
    axes.set_title("\n".join("%d: %s %s, %d contacts" % (leg.number, leg.state, leg.reason, leg.contacts)
                             for leg in legs), fontsize=8)
    axes.set_aspect("equal")
    os.makedirs(folder, exist_ok=True)
    figure.savefig(os.path.join(folder, "drive-%d.png" % seed), dpi=80)
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
    ]
    return "\n".join("%-38s %s" % row for row in rows)


def main() -> int:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1000-1041", help="first-last, or several by ','")
    parser.add_argument("--goals", type=int, default=5)
    parser.add_argument("--walkers", type=int, default=0, help="people who walk in each world")
    parser.add_argument("--localised", type=int, choices=[0, 1], default=0, help="0: the robot is told its true pose")
    parser.add_argument("--specular", type=int, default=40, help="degrees beyond which a wall gives no echo")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--picture", help="folder for pictures of what failed")
    parser.add_argument("--all-pictures", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    seeds: List[int] = []
    for part in options.seeds.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    legs: List[Leg] = []
    began = time.perf_counter()
    with Pool(options.processes) as pool:
        for some in pool.imap_unordered(_run, [(seed, options) for seed in seeds]):
            legs += some
            for leg in some:
                if leg.state != "reached" or leg.contacts:
                    print("seed %d (%s, %s) goal %d: %s after %.0f s: %s; %d contacts" % (
                        leg.seed, leg.world, leg.model, leg.number, leg.state, leg.time, leg.reason, leg.contacts),
                        flush=True)
    print("seeds %s, %d goals, %d walkers, %s, s%d: %.0f s" % (
        options.seeds, options.goals, options.walkers, "localised" if options.localised else "true pose",
        options.specular, time.perf_counter() - began))
    print(report(legs))
    return 0


def _run(job) -> List[Leg]:
    return run(*job)


if __name__ == "__main__":
    sys.exit(main())

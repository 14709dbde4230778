"""How much of a world a robot finds by itself: it goes where its map ends until all is known, then home.

It knows nothing but its sonar and its odometry, drives by its own map, and has calibrated wheels. Floor counts as
reachable where a disc as wide as the robot, with ROOM on each side, can come from the start.
"""

import argparse
import functools
import math
import os
import time
from multiprocessing import Pool
from typing import List, NamedTuple

import numpy as np
from navigation_cases import case
from navigation_drive import SPEED, TURN_RATE, TruePlace, set_accelerations
from navigation_map import Drive, MapRun, calibrated, draw, free_right, transducers, walls_found
from simulated_robot import SimulatedRobot

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, UNKNOWN, GridMap
from pioneer_control.navigation.chassis import Chassis
from pioneer_control.navigation.exploring import Explorer
from pioneer_control.navigation.mapping import Mapper
from pioneer_control.navigation.navigator import Navigator, Readiness, State
from pioneer_control.simulator.world.grids import flood

ROOM = 0.10  # m on each side of the robot
NEWER = 2.0  # s after which the navigator gets the newer map
HOME = 0.3  # m
LEARNT = 12  # unknown cells near a goal; with fewer there is nothing to learn any more


class Exploration(NamedTuple):
    """What became of one robot."""

    seed: int
    world: str
    model: str
    known: float  #: share of the reachable floor
    home: bool
    seconds: float
    way: float  #: m
    goals: int
    given_up: int
    contacts: int
    worst: float  #: m, greatest error of its pose
    found: float  #: share of the walls
    choosing_ms: float  #: at worst, to choose a goal
    ended: str


def explored(options: argparse.Namespace, seed: int) -> Exploration:
    """Let the robot of a seed explore."""
    its = calibrated(case(seed, options.specular))
    robot = SimulatedRobot(its.setup, its.world, seed)
    chassis = Chassis(transducers(its), tuple(robot.model.outline(its.setup.gripper)), SPEED, TURN_RATE)
    home = Pose(*robot.firmware.true_pose)
    mapper, explorer = Mapper(transducers(its), pose=home), Explorer(home, chassis.half_width + ROOM)
    sensing = robot.sense()
    mapper.update(sensing)
    navigator = Navigator(mapper.grid_map(), chassis, through_unknown=True)
    set_accelerations(robot, navigator.acceleration_wanted)
    drive, own = Drive(its, [], []), []
    goal, looking, goals, given_up, newer, choosing, ended = None, False, 0, 0, 0.0, 0.0, "out of time"
    while sensing.time < options.minutes * 60.0:
        decision = navigator.step(sensing, TruePlace(mapper.pose), Readiness(), sensing.time)
        robot.command(*decision.twist)
        sensing = robot.sense()
        own.append(mapper.update(sensing))
        drive.sensings.append(sensing)
        drive.poses.append(Pose(*robot.firmware.true_pose))
        if sensing.time >= newer:
            newer = sensing.time + NEWER
            navigator.use_map(mapper.grid_map())
        is_over = decision.state in (State.IDLE, State.REACHED, State.FAILED)
        if goal is not None and not is_over and not looking and sensing.time >= newer - 0.05:
            is_over = unknown_near(mapper.grid_map(), goal) < LEARNT
        if not is_over:
            continue
        if goal is not None and explorer.homeward:
            ended = "%s: %s" % (decision.state.value, decision.reason)
            break
        grid_map = mapper.grid_map()
        if goal is not None and not looking and unknown_near(grid_map, goal) >= LEARNT:
            explorer.give_up(goal)
            given_up += 1
        began = time.process_time()
        following = explorer.next(grid_map, mapper.pose)
        choosing = max(choosing, 1000.0 * (time.process_time() - began))
        goal, looking = following.pose, following.with_heading
        goals += 1
        navigator.use_map(grid_map)
        refusal = navigator.go_to(goal.x, goal.y, goal.heading if following.with_heading else None, sensing.time)
        if options.verbose:
            print("%6.1f s at (%.2f, %.2f): (%.2f, %.2f) %s %s" % (
                sensing.time, mapper.pose.x, mapper.pose.y, goal.x, goal.y, following.reason, refusal))
    mapper.finish()
    grid_map, end = mapper.grid_map(), robot.firmware.true_pose
    worst = max(math.hypot(a.x - b.x, a.y - b.y) for a, b in zip(own, drive.poses))
    found = float(walls_found(drive, grid_map).mean())
    if options.picture:
        os.makedirs(options.picture, exist_ok=True)
        run = MapRun("explored", seed, found, free_right(drive, grid_map), worst, 0.0, 0.0)
        draw(drive, [(run, grid_map, own)], os.path.join(options.picture, "explore-%d.png" % seed))
    way = sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in zip(drive.poses, drive.poses[1:]))
    return Exploration(
        seed, its.world.name, its.setup.model, known_share(drive, grid_map, home, chassis.half_width + ROOM),
        math.hypot(end[0] - home.x, end[1] - home.y) < HOME, sensing.time, way, goals, given_up,
        robot.firmware.contacts, worst, found, choosing, ended)


def unknown_near(grid_map: GridMap, goal: Pose, reach: float = 0.5) -> int:
    """Return how many unknown cells lie near a goal."""
    x, y = np.meshgrid(np.arange(goal.x - reach, goal.x + reach, grid_map.resolution),
                       np.arange(goal.y - reach, goal.y + reach, grid_map.resolution))
    return int((grid_map.at(x, y) == UNKNOWN).sum())


def known_share(drive: Drive, grid_map: GridMap, home: Pose, radius: float) -> float:
    """Return the share of the reachable floor that the map has as free."""
    low_x, low_y, high_x, high_y = drive.case.world.bounds
    column_x, row_y = np.arange(low_x, high_x, 0.05), np.arange(low_y, high_y, 0.05)
    floor = drive.case.world.clearances(column_x, row_y, 1.0) > radius
    start = np.hypot(column_x - home.x, row_y[:, None] - home.y) < 0.1
    rows, columns = np.nonzero(flood(start, floor))
    return float((grid_map.at(column_x[columns], row_y[rows]) == FREE).mean()) if len(rows) else 0.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1011", help="first-last (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=20.0, help="at most (default: %(default)s)")
    parser.add_argument("--specular", type=float, default=40.0, help="slant (deg) that loses walls (%(default)s)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: %(default)s)")
    parser.add_argument("--picture", help="folder for a picture of each seed")
    parser.add_argument("--verbose", action="store_true", help="print each goal")


def main(options: argparse.Namespace) -> int:
    """Run the part, and print its table."""
    first, _, last = options.seeds.partition("-")
    runs: List[Exploration] = []
    with Pool(options.jobs) as pool:
        seeds = range(int(first), int(last or first) + 1)
        for run in pool.imap(functools.partial(explored, options), seeds):
            runs.append(run)
            print("%-18s %-8s known %5.1f %%, %s, %4.0f s, %4.0f m, %d goals, %d given up, %d contacts, "
                  "pose %.2f m, walls %.0f %%, choosing %.0f ms; %s" % (
                      run.world, run.model, 100 * run.known, "home" if run.home else "NOT HOME", run.seconds, run.way,
                      run.goals, run.given_up, run.contacts, run.worst, 100 * run.found, run.choosing_ms, run.ended),
                  flush=True)
    print("known: mean %.1f %%, at 97 %% or more %d of %d; home %d of %d; contacts %d" % (
        100 * np.mean([run.known for run in runs]), sum(run.known >= 0.97 for run in runs), len(runs),
        sum(run.home for run in runs), len(runs), sum(run.contacts for run in runs)))
    return 0

"""How much of a world a robot finds by itself: it goes where its map ends until all is known, then home.

It knows nothing but its sonar and its odometry, drives by its own map, and has calibrated wheels. Floor counts as
reachable where a disc as wide as the robot, with ROOM on each side, can come from the start.
"""

import argparse
import functools
import gc
import math
import os
import time
from multiprocessing import Pool
from typing import List, NamedTuple

import numpy as np
from navigation_cases import case, seeds_of, with_gripper
from navigation_drive import chassis_of, set_accelerations
from navigation_map import Drive, MapRun, calibrated, draw, farthest_off, free_right, laid, walls_found
from simulated_robot import SimulatedRobot

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, GridMap
from pioneer_control.navigation.frames import into
from pioneer_control.navigation.navigator import Readiness
from pioneer_control.navigation.pilot import Pilot
from pioneer_control.simulator.world.grids import flood

ROOM = 0.10  # m on each side of the robot
HOME = 0.3  # m


class Exploration(NamedTuple):
    """What became of one robot."""

    seed: int
    world: str
    model: str
    known: float  #: share of the reachable floor, the map laid on the true one
    home: bool
    seconds: float
    way: float  #: m
    goals: int
    contacts: int
    worst: float  #: m, greatest error of its pose
    found: float  #: share of the walls, the map laid on the true one
    ms_mean: float  #: of a packet
    ms_worst: float
    ended: str


def explored(options: argparse.Namespace, seed: int) -> Exploration:
    """Let the robot of a seed explore."""
    its = calibrated(case(seed, options.specular))
    if options.gripper:
        its = with_gripper(its)
    robot = SimulatedRobot(its.setup, its.world, seed)
    chassis, home = chassis_of(robot, its.setup.gripper), Pose(*robot.firmware.true_pose)
    pilot = Pilot(None, chassis, start=home)
    step = pilot.sense(robot.sense(), Readiness())
    set_accelerations(robot, pilot.accelerations)
    pilot.explore(True)
    drive, own, costs = Drive(its, [], []), [], []
    goal, goals = None, 0
    while step.time < options.minutes * 60.0 and (step.time < 10.0 or step.state.has_goal):
        robot.command(*step.twist)
        sensing = robot.sense()
        began = time.process_time()
        step = pilot.sense(sensing, Readiness())
        costs.append(1000.0 * (time.process_time() - began))
        gc.freeze()     # what is recorded here is not the robot's: no packet pays for a search through it
        own.append(step.where.pose)
        drive.sensings.append(sensing)
        drive.poses.append(Pose(*robot.firmware.true_pose))
        if step.goal is not None and step.goal != goal:
            goal, goals = step.goal, goals + 1
            if options.verbose:
                print("%6.1f s at (%.2f, %.2f), %.2f m off: (%.2f, %.2f) %s" % (
                    step.time, *own[-1][:2], off(own[-1], drive.poses[-1]), goal.x, goal.y, step.reason))
    pilot.finish()
    grid_map, end = pilot.grid, drive.poses[-1]
    worst = farthest_off(own, drive.poses)
    motion = laid(own, drive.poses)
    found = float(walls_found(drive, grid_map, motion).mean())
    if options.picture:
        os.makedirs(options.picture, exist_ok=True)
        run = MapRun("explored", seed, found, found, free_right(drive, grid_map), worst, worst, 0.0, 0.0)
        draw(drive, [(run, grid_map, own)], os.path.join(options.picture, "explore-%d.png" % seed))
    way = sum(off(a, b) for a, b in zip(drive.poses, drive.poses[1:]))
    return Exploration(
        seed, its.world.name, its.setup.model, known_share(drive, grid_map, motion, home, chassis.half_width + ROOM),
        off(end, home) < HOME, step.time, way, goals, robot.firmware.contacts, worst, found,
        float(np.mean(costs)), max(costs), "%s: %s" % (step.state.value, step.reason))


def off(one: Pose, other: Pose) -> float:
    """Return the distance (m) of two poses."""
    return math.hypot(one.x - other.x, one.y - other.y)


def known_share(drive: Drive, grid_map: GridMap, motion: Pose, home: Pose, radius: float) -> float:
    """Return the share of the reachable floor that the map has as free when a motion lays it on the true one."""
    low_x, low_y, high_x, high_y = drive.case.world.bounds
    column_x, row_y = np.arange(low_x, high_x, 0.05), np.arange(low_y, high_y, 0.05)
    floor = drive.case.world.clearances(column_x, row_y, 1.0) > radius
    start = np.hypot(column_x - home.x, row_y[:, None] - home.y) < 0.1
    rows, columns = np.nonzero(flood(start, floor))
    x, y = into(motion, column_x[columns], row_y[rows])
    return float((grid_map.at(x, y) == FREE).mean()) if len(rows) else 0.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1011", help="first-last (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=60.0, help="at most (default: %(default)s)")
    parser.add_argument("--gripper", action="store_true", help="robots that can carry a gripper have one")
    parser.add_argument("--specular", type=float, default=40.0, help="slant (deg) that loses walls (%(default)s)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--picture", help="folder for a picture of each seed")
    parser.add_argument("--verbose", action="store_true", help="print each goal")


def main(options: argparse.Namespace) -> int:
    """Run the part, and print its table."""
    runs: List[Exploration] = []
    with Pool(options.processes) as pool:
        for run in pool.imap(functools.partial(explored, options), seeds_of(options.seeds)):
            runs.append(run)
            print("%-18s %-8s known %5.1f %%, %s, %4.0f s, %4.0f m, %d goals, %d contacts, "
                  "pose %.2f m, walls %.0f %%, %.1f ms a packet, at worst %.0f; %s" % (
                      run.world, run.model, 100 * run.known, "home" if run.home else "NOT HOME", run.seconds, run.way,
                      run.goals, run.contacts, run.worst, 100 * run.found, run.ms_mean, run.ms_worst, run.ended),
                  flush=True)
    print("known: mean %.1f %%, at 97 %% or more %d of %d; home %d of %d; contacts %d" % (
        100 * np.mean([run.known for run in runs]), sum(run.known >= 0.97 for run in runs), len(runs),
        sum(run.home for run in runs), len(runs), sum(run.contacts for run in runs)))
    return 0

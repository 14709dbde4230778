"""How good a map a robot with sonar makes while it wanders: by its true poses, by odometry alone, by its own poses.

Its wheels were calibrated: they keep a third of their errors, unless `--real` leaves them all. Walls count that were
within 2 m of the path with nothing in between; a wall is found when the map has one within 10 cm. "Laid on": when the
map is first moved and turned as a whole, so that its path lies on the true one. The robot's place and heading at its
start are a convention, and a map that is turned by a degree is as good.
"""

import argparse
import functools
import gc
import math
import os
import time
from dataclasses import replace
from multiprocessing import Pool
from typing import List, NamedTuple, Sequence, Tuple

import numpy as np
from navigation_cases import Case, case, seeds_of
from scipy.spatial import cKDTree
from simulated_robot import SimulatedRobot

from pioneer_control.floor_poses import Pose
from pioneer_control.maps import FREE, OCCUPIED, GridMap
from pioneer_control.navigation.frames import out_of
from pioneer_control.navigation.mapping import Mapper
from pioneer_control.navigation.values import Sensing
from pioneer_control.pictures import BLUE, GREEN, VERMILLION
from pioneer_control.robots import Transducer, find_model
from pioneer_control.simulator.world.grids import flood
from pioneer_control.tutorial.wander import Memory, wander

SPEED = 0.25  # m/s of the wander
NEAR = 2.0  # m: walls and floor so near to the path count
FOUND = 0.10  # m: a wall is found when the map has one so near
POSES = "true", "odometry", "own"
STAYS = Pose(0.0, 0.0, 0.0)
CALIBRATED = 1.0 / 3.0  # share of the errors of wheels that stays after a calibration


class Drive(NamedTuple):
    """What a robot sensed on its way, and its true pose at each packet."""

    case: Case
    sensings: List[Sensing]
    poses: List[Pose]


class MapRun(NamedTuple):
    """One map beside the truth."""

    poses: str  #: by which poses it was made
    seed: int
    found: float  #: share of the walls that were near enough to be seen
    found_laid_on: float  #: the same after the map was laid on the true one
    free_right: float  #: share of the map's free cells
    worst: float  #: m, greatest error of a pose in the finished map
    worst_driving: float  #: m, greatest error of a pose while the map was made
    ms_mean: float  #: of a packet
    ms_worst: float


def calibrated(the_case: Case) -> Case:
    """Return the case with wheels that were calibrated: with a third of the errors."""
    wheels = the_case.setup.numbers.wheels
    small = {name: getattr(wheels, name) * CALIBRATED
             for name in ("larger", "right_larger", "wider_apart", "slip", "noise")}
    numbers = replace(the_case.setup.numbers, wheels=replace(wheels, **small))
    return the_case._replace(setup=the_case.setup._replace(numbers=numbers))


def transducers(the_case: Case) -> Tuple[Transducer, ...]:
    """Return the transducers of the robot of a case."""
    return find_model(the_case.setup.model).with_arrays(front=True, rear=the_case.setup.rear_sonar).sonar


def wandered(the_case: Case, minutes: float) -> Drive:
    """Let the robot of a case wander, and return what it sensed."""
    robot = SimulatedRobot(the_case.setup, the_case.world, the_case.seed)
    memory = Memory(seed=the_case.seed, speed=SPEED)
    drive = Drive(the_case, [], [])
    while robot.firmware.time < minutes * 60.0:
        sensing, snapshot = robot.sense_both()
        drive.sensings.append(sensing)
        drive.poses.append(Pose(*robot.firmware.true_pose))
        move, memory = wander(snapshot, memory)
        robot.command(move.linear, move.angular)
    return drive


def mapped(drive: Drive, poses: str) -> Tuple[MapRun, GridMap, List[Pose]]:
    """Make a map of a drive.

    Args:
        poses: "true": the mapper is told the true poses; "odometry": those by the wheels; "own": it corrects these.
    """
    start = drive.poses[0]
    mapper = Mapper(transducers(drive.case), corrects=poses == "own", pose=start)
    own, times = [], []
    for sensing, true in zip(drive.sensings, drive.poses):
        begin = time.process_time()
        if poses == "true":
            sensing = sensing._replace(odometry=true)
        own.append(mapper.update(sensing))
        times.append(1000.0 * (time.process_time() - begin))
        gc.freeze()     # what is recorded here is not the robot's: no packet pays for a search through it
    mapper.finish()
    the_map = mapper.grid_map()
    path = [Pose(*each) for each in mapper.path()]
    found = walls_found(drive, the_map)
    laid_on = walls_found(drive, the_map, laid(path, drive.poses))
    run = MapRun(poses, drive.case.seed, float(found.mean()), float(laid_on.mean()), free_right(drive, the_map),
                 farthest_off(path, drive.poses), farthest_off(own, drive.poses), float(np.mean(times)), max(times))
    return run, the_map, path


def farthest_off(path: Sequence[Pose], true: Sequence[Pose]) -> float:
    """Return how far (m) a pose of a path is off at most."""
    assert len(path) == len(true), (len(path), len(true))
    return max(math.hypot(a.x - b.x, a.y - b.y) for a, b in zip(path, true))


def spread(values: Sequence[float]) -> Tuple[float, float, float]:
    """Return the median of some values, the one that 90 % do not exceed, and the greatest."""
    rising = sorted(values)
    return rising[len(rising) // 2], rising[min(len(rising) - 1, int(0.9 * len(rising)))], rising[-1]


def wall_points(world, spacing: float = 0.05) -> np.ndarray:
    """Return points on walls and on the rims of posts, as an array (n, 2)."""
    points = []
    for x1, y1, x2, y2 in world.walls:
        count = max(2, math.ceil(math.hypot(x2 - x1, y2 - y1) / spacing))
        share = (np.arange(count)[:, None] + 0.5) / count
        points.append(np.array((x1, y1)) + share * np.array((x2 - x1, y2 - y1)))
    for x, y, radius in world.posts:
        angle = np.linspace(0.0, 2.0 * math.pi, max(6, round(2.0 * math.pi * radius / spacing)), endpoint=False)
        points.append(np.stack((x + radius * np.cos(angle), y + radius * np.sin(angle)), axis=1))
    return np.concatenate(points)


def seen_points(drive: Drive) -> np.ndarray:
    """Return the points of walls and posts that were within NEAR of the path, with nothing in between."""
    points = wall_points(drive.case.world)
    walls, posts = drive.case.world.walls, drive.case.world.posts
    seen = np.zeros(len(points), dtype=bool)
    last = None
    for pose in drive.poses:
        if last is not None and math.hypot(pose.x - last.x, pose.y - last.y) < 0.2:
            continue
        last = pose
        todo = np.nonzero(~seen & (np.hypot(points[:, 0] - pose.x, points[:, 1] - pose.y) < NEAR))[0]
        if len(todo):
            seen[todo] = ~hidden(walls, posts, np.array(pose[:2]), points[todo])
    return points[seen]


def hidden(walls: np.ndarray, posts: np.ndarray, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return whether a wall or a post lies between a place and each of some points, as an array."""
    way = (points - eye) * 0.995  # not the wall of the point itself
    from_eye, along = walls[:, :2] - eye, walls[:, 2:] - walls[:, :2]
    cross = way[:, None, 0] * along[:, 1] - way[:, None, 1] * along[:, 0]
    cross = np.where(np.abs(cross) < 1e-12, 1e-12, cross)
    on_way = (from_eye[:, 0] * along[:, 1] - from_eye[:, 1] * along[:, 0]) / cross
    on_wall = (from_eye[:, 0] * way[:, None, 1] - from_eye[:, 1] * way[:, None, 0]) / cross
    covered = ((on_way > 0) & (on_way < 1) & (on_wall >= 0) & (on_wall <= 1)).any(axis=1)
    if len(posts):
        middle = posts[:, :2] - eye
        share = np.clip((way @ middle.T) / np.maximum((way ** 2).sum(axis=1), 1e-12)[:, None], 0.0, 1.0)
        nearest = share[:, :, None] * way[:, None, :] - middle
        covered |= (np.hypot(nearest[:, :, 0], nearest[:, :, 1]) < posts[:, 2] * 0.98).any(axis=1)
    return covered


def laid(own: Sequence[Pose], true: Sequence[Pose]) -> Pose:
    """Return the motion of a whole map that brings its path nearest to the true one."""
    own_xy, true_xy = (np.array([pose[:2] for pose in path]) for path in (own, true))
    own_middle, true_middle = own_xy.mean(axis=0), true_xy.mean(axis=0)
    a, b = own_xy - own_middle, true_xy - true_middle
    turn = math.atan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    x, y = out_of(Pose(0.0, 0.0, turn), *own_middle)
    return Pose(true_middle[0] - x, true_middle[1] - y, turn)


def walls_found(drive: Drive, the_map: GridMap, motion: Pose = STAYS) -> np.ndarray:
    """Return for each point of a wall that could be seen, whether the map, after a motion, has a wall within FOUND."""
    rows, columns = np.nonzero(the_map.cells == OCCUPIED)
    points = seen_points(drive)
    if not len(rows):
        return np.zeros(len(points), dtype=bool)
    x, y = out_of(motion, *the_map.middle(rows, columns))
    return cKDTree(np.stack((x, y), axis=1)).query(points)[0] <= FOUND


def free_right(drive: Drive, the_map: GridMap) -> float:
    """Return the share of the map's free cells that are floor: no wall in them, and the robot could get there."""
    world = drive.case.world
    fine = the_map.resolution / 2.0
    low_x, low_y, high_x, high_y = world.bounds
    column_x = np.arange(low_x - 0.5, high_x + 0.5, fine)
    row_y = np.arange(low_y - 0.5, high_y + 0.5, fine)
    floor = world.clearances(column_x, row_y, 0.1) > 0.75 * fine
    start = np.zeros_like(floor)
    start[round((drive.poses[0].y - row_y[0]) / fine), round((drive.poses[0].x - column_x[0]) / fine)] = True
    floor = flood(start, floor)
    rows, columns = np.nonzero(the_map.cells == FREE)
    x, y = the_map.middle(rows, columns)
    column = np.clip(np.round((x - column_x[0]) / fine).astype(int), 0, len(column_x) - 1)
    row = np.clip(np.round((y - row_y[0]) / fine).astype(int), 0, len(row_y) - 1)
    return float(floor[row, column].mean()) if len(rows) else 0.0


def draw(drive: Drive, runs: Sequence[Tuple[MapRun, GridMap, List[Pose]]], file: str) -> None:
    """Draw maps beside each other, with the true walls and the true path over each."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(8.0 * len(runs), 8.0))
    for number, (run, the_map, own) in enumerate(runs, 1):
        axes = figure.add_subplot(1, len(runs), number)
        low_x, low_y, high_x, high_y = the_map.bounds
        grey = np.where(the_map.cells == FREE, 255, np.where(the_map.cells == OCCUPIED, 0, 190))
        axes.imshow(grey, origin="lower", cmap="gray", vmin=0, vmax=255, extent=(low_x, high_x, low_y, high_y))
        for x1, y1, x2, y2 in drive.case.world.walls:
            axes.plot((x1, x2), (y1, y2), color=VERMILLION, linewidth=0.8)
        for x, y, radius in drive.case.world.posts:
            angle = np.linspace(0.0, 2.0 * math.pi, 20)
            axes.plot(x + radius * np.cos(angle), y + radius * np.sin(angle), color=VERMILLION, linewidth=0.8)
        axes.plot(*zip(*(pose[:2] for pose in drive.poses)), color=GREEN, linewidth=0.6)
        axes.plot(*zip(*(pose[:2] for pose in own)), color=BLUE, linewidth=0.6)
        axes.set_title("%s, %s: walls %.0f %%, free right %.1f %%, worst %.2f m" % (
            drive.case.world.name, run.poses, 100 * run.found, 100 * run.free_right, run.worst))
    figure.tight_layout()
    figure.savefig(file, dpi=60)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1011", help="first-last (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=6.0, help="of wandering (default: %(default)s)")
    parser.add_argument("--specular", type=float, default=40.0, help="slant (deg) that loses walls (%(default)s)")
    parser.add_argument("--real", action="store_true", help="leave all errors of the wheels")
    parser.add_argument("--poses", default=",".join(POSES), help="by which poses (default: %(default)s)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--picture", help="folder for a picture of each seed")


def main(options: argparse.Namespace) -> int:
    """Run the part, and print its table."""
    seeds = seeds_of(options.seeds)
    with Pool(options.processes) as pool:
        rows = pool.map(functools.partial(one_seed, options), seeds, chunksize=1)
    heads = ["%34s" % ("%s: walls laid on free worst" % each) for each in options.poses.split(",")]
    print("%-20s %-9s" % ("world", "model") + "".join(heads))
    for seed, runs in zip(seeds, rows):
        the_case = case(seed, options.specular)
        print("%-20s %-9s" % (the_case.world.name, the_case.setup.model) + "".join(
            "%17.1f %5.1f %5.1f %5.2f" % (100 * run.found, 100 * run.found_laid_on, 100 * run.free_right, run.worst)
            for run in runs))
    for runs in zip(*rows):
        worst, driving = spread([run.worst for run in runs]), spread([run.worst_driving for run in runs])
        print("%-9s walls found %.1f %%, laid on %.1f %%, free right %.2f %%, worst pose error median %.2f m, "
              "90 %% %.2f m, most %.2f m (while it drives %.2f, %.2f, %.2f m); %.2f ms a packet, at worst %.0f" % (
                  runs[0].poses, 100 * np.mean([run.found for run in runs]),
                  100 * np.mean([run.found_laid_on for run in runs]),
                  100 * np.mean([run.free_right for run in runs]), *worst, *driving,
                  np.mean([run.ms_mean for run in runs]), max(run.ms_worst for run in runs)))
    return 0


def one_seed(options: argparse.Namespace, seed: int) -> List[MapRun]:
    """Return the maps of a seed by each kind of poses."""
    the_case = case(seed, options.specular)
    drive = wandered(the_case if options.real else calibrated(the_case), options.minutes)
    results = [mapped(drive, poses) for poses in options.poses.split(",")]
    if options.picture:
        os.makedirs(options.picture, exist_ok=True)
        draw(drive, results, os.path.join(options.picture, "%d.png" % seed))
    return [run for run, _, _ in results]

"""The part "localise" of bench/navigation.py: does a robot know where it is?

It wanders, with wheels and sonar that err as real ones do. It is told its start (0.5 m and 20 degrees off), or not, or
it is carried somewhere else at half time.
"""

import argparse
import gc
import math
import os
import random
import time
from multiprocessing import Pool
from typing import List, NamedTuple, Optional

import numpy as np

from navigation_cases import seeds_of
from navigation_wanders import Wander, Wandering, recorded

from pioneer_control.floor_poses import Pose, compose, relative, wrapped
from pioneer_control.maps import OCCUPIED
from pioneer_control.navigation.localisation import Localisation, Where

STARTS = ("known", "unknown", "carried")
RIGHT_POSITION, RIGHT_HEADING = 0.5, math.radians(15.0)  # m, rad: a pose that is less off is right
MOSTLY = 0.9  # share of the last minute in which the pose is right: success
START_OFF, START_TURNED = 0.5, math.radians(20.0)  # m, rad: how wrong a known start is


class Run(NamedTuple):
    """How well one robot was localised. Errors (m, degrees) are those of the last minute."""

    seed: int
    world: str
    model: str
    success: bool
    position: np.ndarray
    heading: np.ndarray
    odometry_position: np.ndarray
    odometry_heading: np.ndarray
    known_after: float  #: s of driving from the start, or from being carried, until the pose is sure and right
    sure_but_off: float  #: s, the longest time
    unsure: float  #: share of the time after the first minute
    mean_cost: float  #: ms of the processor for each packet
    worst_cost: float
    begin_cost: float  #: s until localisation can begin


class Job(NamedTuple):
    """What to run."""

    what: Wandering
    start: str
    pictures: Optional[str]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1055", help="first-last (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=6.0, help="simulated (default: %(default)s)")
    parser.add_argument("--start", choices=STARTS + ("all",), default="all")
    parser.add_argument("--specular", type=float, default=40.0,
                        help="degrees beyond which a wall returns no echo (default: %(default)s)")
    parser.add_argument("--speed", type=float, default=0.4, help="of the wander, m/s (default: %(default)s)")
    parser.add_argument("--laser", action="store_true", help="the robot has a laser, too")
    parser.add_argument("--picture", metavar="DIR", help="draw each failure into this folder")
    parser.add_argument("--processes", type=int, default=2)


def main(options: argparse.Namespace) -> int:
    """Run what the command line says. Return 0 if no run failed, 1 if one did."""
    failures = 0
    print("seeds %s, %g minutes, %g m/s, walls are lost beyond %g degrees%s" % (
        options.seeds, options.minutes, options.speed, options.specular, ", with a laser" if options.laser else ""))
    print(HEAD)
    for start in STARTS if options.start == "all" else [options.start]:
        carried_at = options.minutes * 30.0 if start == "carried" else None
        jobs = [Job(Wandering(seed, options.minutes, options.specular, options.speed, carried_at, options.laser),
                    start,
                    options.picture) for seed in seeds_of(options.seeds)]
        with Pool(options.processes) as pool:
            runs = pool.map(run, jobs, chunksize=1)
        print(row(start, runs), flush=True)
        bad = [each for each in runs if failed(each)]
        for each in bad:
            print("    seed %d, %s, %s: right in the last minute %s, known after %.1f s, sure but off for %.1f s" % (
                each.seed, each.world, each.model, "yes" if each.success else "NO", each.known_after,
                each.sure_but_off), flush=True)
        failures += len(bad)
    return int(failures > 0)


def failed(result: Run) -> bool:
    """Return whether a run missed what is wanted of each."""
    return not result.success or result.sure_but_off > 5.0


HEAD = ("| start | success | position, heading: median / 95 % | odometry alone | 90 % know after (driving)"
        " | longest sure but off | unsure | mean / worst ms a packet | begins after |"
        "\n|---|---|---|---|---|---|---|---|---|")


def row(start: str, runs: List[Run]) -> str:
    """Return one row of the table."""
    good = [each for each in runs if each.success] or runs
    known = sorted(each.known_after for each in runs)
    return "| %s | %d of %d | %s | %s | %.1f s | %.1f s | %.1f %% | %.2f / %.0f | %.2f s |" % (
        start, sum(each.success for each in runs), len(runs),
        _errors([each.position for each in good], [each.heading for each in good]),
        _errors([each.odometry_position for each in good], [each.odometry_heading for each in good]),
        known[math.ceil(0.9 * len(known)) - 1], max(each.sure_but_off for each in runs),
        100.0 * np.mean([each.unsure for each in runs]), np.mean([each.mean_cost for each in runs]),
        max(each.worst_cost for each in runs), max(each.begin_cost for each in runs))


def _errors(positions: List[np.ndarray], headings: List[np.ndarray]) -> str:
    position, heading = np.concatenate(positions), np.concatenate(headings)
    return "%.3f / %.3f m, %.1f / %.1f degrees" % (
        np.median(position), np.quantile(position, 0.95), np.median(heading), np.quantile(heading, 0.95))


def run(job: Job) -> Run:
    """Localise one robot on its whole wander."""
    wander = recorded(job.what)
    begin = time.thread_time()
    localisation = Localisation(wander.grid_map, wander.transducers, seed=job.what.seed)
    begin_cost = time.thread_time() - begin
    if job.start != "unknown":
        localisation.known_start(roughly(wander.truth[0], job.what.seed))
    wheres, costs, clouds = [], [], []
    for sensing in wander.sensings:
        begin = time.thread_time()
        wheres.append(localisation.update(sensing))
        costs.append(1000.0 * (time.thread_time() - begin))
        gc.freeze()     # what is recorded here is not the robot's: no packet pays for a search through it
        if job.pictures and len(wheres) % 100 == 0:
            clouds.append(localisation.particles[::5].copy())
    result = judged(job, wander, wheres)._replace(
        mean_cost=float(np.mean(costs)), worst_cost=max(costs), begin_cost=begin_cost)
    if job.pictures and failed(result):
        draw(os.path.join(job.pictures, "%s-%d.png" % (job.start, job.what.seed)), wander, wheres, clouds)
    return result


def roughly(pose: Pose, seed: int) -> Pose:
    """Return the start that a person tells, who does not know it well."""
    luck = random.Random("start %s" % seed)
    to = luck.uniform(-math.pi, math.pi)
    return Pose(pose.x + START_OFF * math.cos(to), pose.y + START_OFF * math.sin(to),
                pose.heading + luck.choice((-1, 1)) * START_TURNED)


def judged(job: Job, wander: Wander, wheres: List[Where]) -> Run:
    """Compare where the robot believed to be with where it was."""
    times = np.array([where.time for where in wheres])
    position, heading = off([where.pose for where in wheres], wander.truth)
    sure = np.array([where.sure for where in wheres])
    right = (position < RIGHT_POSITION) & (heading < RIGHT_HEADING)
    last = times > times[-1] - 60.0
    carried_at = job.what.carried_at or 0.0
    driving = np.cumsum(moves(wander.truth) & (times > carried_at)) * (times[1] - times[0])
    known = driving[sure & right & (times > carried_at)]
    alone = by_odometry(wander, carried_at)
    return Run(
        wander.what.seed, wander.world, wander.model, bool(right[last].mean() >= MOSTLY), position[last],
        np.degrees(heading[last]), alone[0][last], np.degrees(alone[1][last]),
        float(known[0]) if len(known) else math.inf, longest(times, sure & (position > 0.5)),
        float(1.0 - sure[times > 60.0].mean()) if times[-1] > 60.0 else 0.0, 0.0, 0.0, 0.0)


def off(poses, truth):
    """Return how far poses are from the true ones: arrays of m and of rad."""
    position = np.array([math.hypot(one.x - other.x, one.y - other.y) for one, other in zip(poses, truth)])
    return position, np.array([abs(wrapped(one.heading - other.heading)) for one, other in zip(poses, truth)])


def moves(truth) -> np.ndarray:
    """Return for each pose whether the robot has moved since the last one."""
    step, turn = off(truth, truth[:1] + truth[:-1])
    return step + 0.3 * turn > 0.003


def by_odometry(wander: Wander, carried_at: float):
    """Return how far odometry alone is off that begins at the true pose, after the robot was carried again."""
    poses, origin, begun = [], None, False
    for sensing, truth in zip(wander.sensings, wander.truth):
        if origin is None or (carried_at and not begun and sensing.time > carried_at + 0.15):
            begun = origin is not None
            origin = truth, sensing.odometry
        poses.append(compose(origin[0], relative(origin[1], sensing.odometry)))
    return off(poses, wander.truth)


def longest(times: np.ndarray, holds: np.ndarray) -> float:
    """Return the longest time (s) for which something holds without a break."""
    best, since = 0.0, None
    for now, each in zip(times.tolist(), holds.tolist()):
        since = (now if since is None else since) if each else None
        best = max(best, now - since + 0.1) if since is not None else best
    return best


def draw(path: str, wander: Wander, wheres: List[Where], clouds: List[np.ndarray]) -> None:
    """Draw map, true path, believed path (grey where it was not sure) and cloud, every 10 s."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    os.makedirs(os.path.dirname(path), exist_ok=True)
    figure, axes = pyplot.subplots(figsize=(9, 9))
    low_x, low_y, high_x, high_y = wander.grid_map.bounds
    axes.imshow(wander.grid_map.cells == OCCUPIED, cmap="Greys", origin="lower", extent=(low_x, high_x, low_y, high_y))
    for cloud in clouds:
        axes.plot(cloud[:, 0], cloud[:, 1], ",", color="tab:orange", alpha=0.4)
    axes.plot([pose.x for pose in wander.truth], [pose.y for pose in wander.truth], color="tab:green", label="true")
    for sure, colour in ((False, "0.6"), (True, "tab:blue")):
        some = [where.pose for where in wheres if where.sure == sure]
        axes.plot([pose.x for pose in some], [pose.y for pose in some], ".", ms=2, color=colour,
                  label="believed, %s" % ("sure" if sure else "not sure"))
    axes.set_title("%s, %s, seed %d" % (wander.world, wander.model, wander.what.seed))
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=100)
    pyplot.close(figure)

"""The part "carried" of bench/navigation.py: a robot drives to a goal, and somebody carries it away.

It stands, says that it does not know where it is, and looks around as navigation decides. The part "localise" drives
robots on that were carried; here most of them only turn. Counted is the time from the carry until a robot is sure, and
right.
"""

import argparse
import functools
import itertools
import math
import random
from multiprocessing import Pool
from typing import Iterator, List, NamedTuple, Tuple

from simulated_robot import CYCLE
from navigation_cases import seeds_of
from navigation_drive import Drive, at
from navigation_localise import RIGHT_HEADING, RIGHT_POSITION
from navigation_wanders import elsewhere

from pioneer_control.floor_poses import Pose, wrapped
from pioneer_control.navigation.localisation import Where
from pioneer_control.simulator.world.poses import placed

DRIVES = 4.0, 12.0      # s: it has driven for so long when it is carried, at least and at most
LONGEST = 120.0     # s


class Carry(NamedTuple):
    """What became of one robot. Times in s from the carry on; `known` is infinite if it never found itself."""

    seed: int
    world: str
    model: str
    known: float
    wrong: float    #: the longest time for which it was sure while it was more than 0.5 m off
    contacts: int
    reason: str     #: of navigation, at the end


def run(seed: int, options: argparse.Namespace) -> Carry:
    """Carry the robot of a seed away."""
    drive, luck = Drive(seed, options), random.Random("carried while driving %s" % seed)
    goals = itertools.cycle(drive.goals)
    begin = drive.time + luck.uniform(*DRIVES)
    while drive.time < begin:
        step(drive, goals)
    drive.robot.firmware.hardware.carry(place_for(drive))
    begin, contacts, known, wrong, longest_wrong = drive.time, drive.robot.firmware.contacts, math.inf, 0.0, 0.0
    while math.isinf(known) and drive.time - begin < LONGEST:
        place, reason = step(drive, goals)
        truth = Pose(*drive.robot.firmware.true_pose)
        off = math.hypot(truth.x - place.pose.x, truth.y - place.pose.y)
        wrong = wrong + CYCLE if place.sure and off > RIGHT_POSITION else 0.0
        longest_wrong = max(longest_wrong, wrong)
        right = off < RIGHT_POSITION and abs(wrapped(truth.heading - place.pose.heading)) < RIGHT_HEADING
        if place.sure and right:
            known = drive.time - begin
    return Carry(seed, drive.world.name, drive.model, known, longest_wrong, drive.robot.firmware.contacts - contacts,
                 reason)


def step(drive: Drive, goals: Iterator[Pose]) -> Tuple[Where, str]:
    """Answer one packet, and send the robot to the next goal if it has none. Return where it believes to be, and why
    navigation does what it does.
    """
    place, decision, _ = drive.packet()
    if not decision.state.has_goal:
        goal = next(goals)
        drive.navigator.go_to(goal.x, goal.y, goal.heading, drive.time)
    return place, decision.reason


def place_for(drive: Drive) -> Pose:
    """Return where the robot is put: elsewhere on the floor, where it touches nothing and nobody is near."""
    here, outline = Pose(*drive.robot.firmware.true_pose), drive.chassis.outline
    places = (elsewhere(drive.grid_map, here, "%s %s" % (drive.seed, number)) for number in range(1000))
    return next(each for each in places if not drive.world.touches(placed(outline, each)) and all(
        math.hypot(each.x - person.pose[0], each.y - person.pose[1]) > 1.0 for person in drive.people))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    parser.add_argument("--seeds", default="1000-1041", help="first-last, or several by ',' (default: %(default)s)")
    parser.add_argument("--walkers", type=int, default=0, help="people who walk in each world (default: %(default)s)")
    parser.add_argument("--specular", type=float, default=40.0,
                        help="degrees beyond which a wall returns no echo (default: %(default)s)")
    parser.add_argument("--laser", action="store_true", help="the robot has a laser, too")
    parser.add_argument("--processes", type=int, default=2)
    parser.set_defaults(goals=3, gripper=False, verbose=False, localised=1)


def main(options: argparse.Namespace) -> int:
    """Run what the command line says. Return 0 if all robots found themselves without a contact, 1 if not."""
    with Pool(options.processes) as pool:
        carries = pool.map(functools.partial(run, options=options), seeds_of(options.seeds), chunksize=1)
    bad = [each for each in carries if each.contacts or each.wrong > 5.0 or math.isinf(each.known)]
    for each in bad:
        print("seed %d (%s, %s): known after %.1f s, sure but off for %.1f s, %d contacts: %s" % each)
    print("seeds %s, %d walkers, s%g%s" % (
        options.seeds, options.walkers, options.specular, ", with a laser" if options.laser else ""))
    print(report(carries))
    return int(bool(bad))


def report(carries: List[Carry]) -> str:
    """Return the rows of the table."""
    known = [each.known for each in carries]
    return "\n".join("%-38s %s" % row for row in (
        ("known again within %g s" % LONGEST, "%d of %d" % (sum(map(math.isfinite, known)), len(known))),
        ("known after, median / 75 % / 90 %", "%.1f / %.1f / %.1f s" % tuple(
            at(known, share) for share in (0.5, 0.75, 0.9))),
        ("sure while %g m off, longest" % RIGHT_POSITION, "%.1f s; %d with more than 5 s" % (
            max(each.wrong for each in carries), sum(each.wrong > 5.0 for each in carries))),
        ("contacts", "%d" % sum(each.contacts for each in carries))))

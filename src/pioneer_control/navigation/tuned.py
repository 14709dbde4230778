"""The numbers of navigation that were tuned by measurement, and what each of them does: one table for each part.

They were tuned with bench/navigation.py on its seeds 1000 to 1999. The tables in `NavigationNumbers` are parameters of
the node; `SensorNumbers` are not.
"""

from dataclasses import dataclass
from typing import NamedTuple, Tuple

from ..parameters import Number, Whole, parameter


class EchoShares(NamedTuple):
    """What becomes of the echo of a wall.

    Attributes:
        hit: share of readings near the expected range.
        long: share of longer readings: the wall bounces the sound away, and one behind it echoes.
        none: share without an echo: the wall bounces the sound away.
    """

    hit: float
    long: float
    none: float


@dataclass(frozen=True)
class SensorNumbers:
    """How measured ranges scatter about the ranges that a map lets expect. The shares are of readings with an expected
    range below the longest one; they are scaled to a sum of 1.
    """

    shares: Tuple[EchoShares, ...]
    """For each slant of a wall, see `expected_ranges.Beam`."""
    lost: int
    """Walls of this slant on often return no echo, so a longer reading tells nothing of whether a pose is right."""

    sigma: float = parameter(0.05, Number(0.001, 1.0), "standard deviation of a range at 0 m", "m")
    sigma_per_metre: float = parameter(0.015, Number(0.0, 0.5), "what each metre of range adds to it")
    short: float = parameter(0.06, Number(0.0, 1.0), "share of shorter readings: people, things that are on no map")
    random: float = parameter(0.03, Number(0.0, 1.0), "share of readings with any range")


SONAR_NUMBERS = SensorNumbers((EchoShares(0.9, 0.03, 0.03), EchoShares(0.75, 0.1, 0.12), EchoShares(0.5, 0.22, 0.25),
                               EchoShares(0.15, 0.4, 0.42)), lost=3)
"""Sonar of a Pioneer. The shares lie between what walls return that are lost beyond 20 degrees, and beyond 40."""


@dataclass(frozen=True)
class LaserSenseNumbers:
    """How a laser tells where the robot is (`laser_field`)."""

    rays: int = parameter(40, Whole(4, 2000), "so many rays of a scan are used, spread over it")
    sigma: float = parameter(
        0.06, Number(0.005, 1.0), "standard deviation of where a ray ends, from the middle of a wall's cell", "m")
    sigma_coarse: float = parameter(0.2, Number(0.005, 2.0), "the same for poses that are only roughly right", "m")
    anywhere: float = parameter(
        0.1, Number(0.001, 0.9), "share of rays that end anywhere: at people, at things that are on no map")
    worth: float = parameter(
        3.0, Number(0.01, 100.0), "a spot that a laser sees tells so many times more than one that sonar hears, where"
        " margins of `localisation` count")
    near: float = parameter(0.15, Number(0.01, 1.0), "a ray that ends so near to a wall of the map is explained", "m")
    weight: float = parameter(
        0.02, Number(0.0, 1.0), "share of a ray's log-likelihood that counts, as `localisation/weight`: rays of one"
        " scan err alike")
    evidence: float = parameter(
        0.2, Number(0.0, 1.0), "what a ray counts when readings are counted that the pose explains; a sonar reading"
        " counts 1")
    patience: float = parameter(
        1.0, Number(0.1, 60.0), "so long after the last scan the robot goes on by sonar alone", "s")


@dataclass(frozen=True)
class LocalisationNumbers:
    """Where the robot is."""

    map_bias: float = parameter(
        0.02, Number(-0.2, 0.2), "how much farther walls are than the cells of the map that they cover", "m")
    clearance: float = parameter(0.12, Number(0.0, 1.0), "the middle of the robot is never nearer to a wall", "m")

    particles: int = parameter(300, Whole(50, 20000), "poses in the cloud, while one place is likely")
    particles_searching: int = parameter(1200, Whole(50, 20000), "poses in the cloud, while several places are likely")
    roughening: float = parameter(
        0.03, Number(0.0, 0.2), "poses drawn anew scatter so about the old, while it turns on the spot, is not "
        "sure, and the cloud is wide", "m, rad")
    noise_way: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of a way of 1 m by the wheels; it grows with the root of the way",
        "m")
    noise_turn_of_way: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of the heading after a way of 1 m; it grows with the root", "rad")
    noise_turn: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of a turn of 1 rad by the wheels; it grows with the root", "rad")

    weight: float = parameter(
        0.2, Number(0.0, 1.0), "share of a reading's log-likelihood that counts: readings of one place err alike")
    full_way: float = parameter(
        0.04, Number(0.001, 1.0), "after such a way since the last readings they count fully; after a shorter one less",
        "m")
    first_look: float = parameter(
        2.0, Number(0.0, 5.0), "after a word of where the robot is, the first reading of each transducer counts so many"
        " times, if the robot stands")
    turn_as_way: float = parameter(0.3, Number(0.0, 5.0), "a turn of 1 rad counts as such a way", "m")
    looks_anew: float = parameter(0.15, Number(0.0, 2.0), "so far from its place a turn tells something new again", "m")
    turns_anew: float = parameter(12.6, Number(0.0, 1e3), "after so much turning it does so, too", "rad")

    remembered: int = parameter(800, Whole(50, 5000), "readings that a search compares poses with")
    least_readings: int = parameter(60, Whole(1, 5000), "readings in motion that a search needs, half of them echoes")
    kept_in_doubt: int = parameter(
        60, Whole(0, 5000), "when the pose stops to be sure, at most so many of the newest readings are kept: older"
        " ones may be of another place")
    poses_per_square_metre: float = parameter(
        150.0, Number(1.0, 10000.0), "random poses that a search begins with, for each square metre of free floor")
    least_poses: int = parameter(4000, Whole(100, 1000000), "it begins with at least so many")
    poses_per_step: int = parameter(8000, Whole(100, 1000000), "poses that a search compares in one update")
    period_sure: float = parameter(6.0, Number(0.1, 1000.0), "time between two searches while the pose is sure", "s")
    period_proven: float = parameter(
        20.0, Number(0.1, 1000.0), "the same when a long way has proven it, too: misfits tell sooner", "s")
    period_unsure: float = parameter(0.4, Number(0.1, 1000.0), "time between two searches while it is not", "s")
    margin: float = parameter(
        0.25, Number(0.0, 5.0), "a pose found by a search must explain each spot better than the cloud by this (a spot"
        " is a square in which readings end, see `measurement.SPOT`)")
    margin_proven: float = parameter(
        0.6, Number(0.0, 5.0), "the same when a long way has proven the pose, also in doubt: after a carry it is more")
    margin_guessed: float = parameter(
        0.08, Number(0.0, 5.0), "the same while the pose is not sure, and no long way has proven it")
    least_spots: float = parameter(
        90.0, Number(1.0, 5000.0), "with fewer spots than this, margins grow; with half as many, they are doubled")
    new_readings: int = parameter(
        15, Whole(0, 5000), "a search begins only after so many new readings: standing tells nothing new")
    place_explained: float = parameter(
        0.75, Number(0.0, 1.0), "a pose found must explain at least this share of the usual share of echoes")

    rival_margin: float = parameter(
        0.15, Number(-5.0, 5.0), "to become sure, the pose must explain each spot better than any elsewhere by this")
    rival_margin_on_the_spot: float = parameter(
        0.25, Number(-5.0, 5.0), "the same for a robot that has only turned: all that it heard errs alike")

    beside: float = parameter(3.0, Number(0.0, 100.0), "a place that is not farther from the pose is close by", "m")
    beside_margin: float = parameter(
        0.08, Number(-5.0, 5.0), "`rival_margin` for places close by, if the pose was told or a long way has proven it")
    sure_position: float = parameter(0.3, Number(0.01, 5.0), "greatest spread of the cloud to be sure", "m")
    sure_heading: float = parameter(0.25, Number(0.01, 3.0), "greatest spread of the headings to be sure", "rad")
    longest_line: float = parameter(
        1.2, Number(0.0, 5.0), "greatest spread of the cloud for the robot to be sure to be on a line", "m")
    sure_way: float = parameter(
        0.5, Number(0.0, 100.0), "way in motion with readings that the place explains, before it is sure", "m")
    enough_spots: float = parameter(
        63.0, Number(1.0, 5000.0), "so many spots are as good as that way, once `upheld_searches` found no place alike:"
        " a robot that can turn only a little")
    sure_searches: int = parameter(
        2, Whole(1, 100), "so many searches in a row must find no place that looks alike, before it is sure")
    upheld_searches: int = parameter(
        3, Whole(1, 100), "so many searches in a row in doubt that find no place alike uphold the pose")
    proven_way: float = parameter(
        6.0, Number(0.0, 100.0), "after such a way, places that look alike do not make it unsure any more", "m")
    unsure_explained: float = parameter(
        0.7, Number(0.0, 1.0), "a sure pose should explain more than this share of the usual share of echoes")
    unsure_missed: float = parameter(
        18.0, Number(1.0, 1000.0), "a pose is doubted when the echoes that it misses of that share add up to so many")
    suspect_missed: float = parameter(
        6.0, Number(1.0, 1000.0), "when they add up to so many, a search looks where the robot may have been carried")
    suspect_readings: int = parameter(
        120, Whole(10, 5000), "such a search compares poses with so many of the newest readings")
    standing_readings: int = parameter(
        12, Whole(1, 100), "so many readings of each sensor count once the robot has come to stand, or a range changes")
    sure_explained: float = parameter(
        0.8, Number(0.0, 1.0), "sure again when at least this share of the usual share is explained")
    told_explained: float = parameter(
        0.775, Number(0.0, 1.0), "a pose that somebody told begins as if it explained this share of the usual share;"
        " that is less than `sure_explained`, so some echoes must fit first")
    usual_explained: float = parameter(
        0.7, Number(0.0, 1.0), "the usual share of echoes that the true pose explains, before it is learnt")
    blind_way: float = parameter(2.0, Number(0.1, 100.0), "unsure after such a way without an explained echo", "m")
    explained_readings: int = parameter(
        60, Whole(5, 1000), "echoes over which the explained share is a mean")


@dataclass(frozen=True)
class PlanningNumbers:
    """Numbers of `planning`."""

    side: float = parameter(0.1, Number(0.02, 0.3), "side of the squares on which a way is found", "m")
    squeeze: float = parameter(0.045, Number(0, 1), "least distance of the robot's sides from a wall", "m")
    keep: float = parameter(0.075, Number(0, 1), "distance from a wall that is kept unless there is no other way", "m")
    berth: float = parameter(0.28, Number(0.01, 3), "so far beyond that distance a metre costs more", "m")
    near_cost: float = parameter(
        6.0, Number(0, 1000), "what a metre costs more at the distance that is kept; less farther away")
    squeeze_cost: float = parameter(8.0, Number(0, 1000), "what a metre nearer than that costs besides")
    obstacle_cost: float = parameter(40.0, Number(0, 10000), "what a metre through an obstacle costs that is on no map")
    off_the_floor: float = parameter(20.0, Number(1, 1000), "cost of a metre where the robot must not be at all")


@dataclass(frozen=True)
class ObstacleNumbers:
    """Numbers of `obstacles`."""

    heard_to: float = parameter(
        2.0, Number(0.5, 5), "an echo neither adds nor takes away an obstacle that is farther from the sonar", "m")
    cell: float = parameter(0.05, Number(0.01, 0.2), "echoes nearer to each other than about this are one", "m")
    explained: float = parameter(0.15, Number(0, 1), "an echo this near to a wall of the map comes from it", "m")
    explained_share: float = parameter(0.03, Number(0, 1), "what is added to that distance for each metre of range")
    explained_depth: float = parameter(
        0.03, Number(0, 1), "a wall's echo comes from the part of its arc that is nearest to the wall, and from what is"
        " so much farther", "m")
    kept: float = parameter(25.0, Number(1, 600), "time after which what is on no map is forgotten", "s")
    felt: float = parameter(60.0, Number(1, 600), "time for which a place is kept where the wheels stalled", "s")
    kept_aside: float = parameter(5.0, Number(0, 600), "`kept` for the two ends of an arc, where it rather is not", "s")
    kept_beside: float = parameter(
        60.0, Number(0, 3600), "what is nearer than `away` to a robot that stands is forgotten after this time", "s")
    kept_known: float = parameter(3.0, Number(0, 600), "time after which a wall's echo is forgotten", "s")
    kept_standing: float = parameter(
        120.0, Number(0, 3600), "time for which plans lead round what stood still, once it is not heard any more", "s")
    away: float = parameter(
        1.0, Number(0, 5), "they do so only farther than this from the robot's middle: nearer, it hears what is there",
        "m")
    young: float = parameter(1.5, Number(0, 60), "an echo younger than this may be of somebody who walks", "s")
    proves_still: float = parameter(2.0, Number(0, 60), "what was heard in one place for this time stands still", "s")
    proves_still_came: float = parameter(
        4.0, Number(0, 60), "the same for what came there while the robot stood: who waits at a robot walks on", "s")
    lost: float = parameter(
        2.5, Number(0, 60), "so long after it was last heard, what had not proved to stand still may be near", "s")
    same_place: float = parameter(0.2, Number(0.01, 1), "echoes so near to the first one are from one place", "m")
    same_place_near: float = parameter(
        0.05, Number(0.01, 1), "the same for an echo from 0 m; up to `same_place`, each metre of range adds to it", "m")
    same_place_share: float = parameter(0.25, Number(0, 2), "what each metre of range adds: it is of an arc")
    seen_through: float = parameter(0.2, Number(0.02, 2), "an echo from this much farther has passed an obstacle", "m")
    passes: int = parameter(2, Whole(1, 50), "so often an echo must pass an obstacle until it is forgotten")
    seen_beside: float = parameter(
        0.1, Number(0.01, 1), "the ray of a laser counts if one beside it ends so near", "m")
    seen_itself: float = parameter(
        0.03, Number(0, 1), "where a ray of a laser ends nearer to the robot's outline, it saw the robot itself", "m")


@dataclass(frozen=True)
class SuspicionNumbers:
    """Where walls may go on that no sonar hears, while a map is made (`suspected_walls`)."""

    near: float = parameter(0.8, Number(0.1, 2.0), "walls so near to the middle of the robot count", "m")
    reach: float = parameter(0.35, Number(0.0, 2.0), "so far a wall is suspected to go on; 0: not at all", "m")
    band: float = parameter(0.04, Number(0.01, 0.2), "a place belongs to a wall when it is so near to it", "m")
    least: int = parameter(6, Whole(3, 100), "places that must lie on a wall")
    span: float = parameter(0.2, Number(0.05, 2.0), "length on which they must lie", "m")
    square: float = parameter(0.35, Number(0.0, 1.5), "a beam that slants less meets a wall squarely", "rad")
    passed: float = parameter(0.15, Number(0.02, 2.0), "an echo from so far beyond it says that it has ended", "m")


@dataclass(frozen=True)
class SteeringNumbers:
    """Numbers of `steering`."""

    acceleration: float = parameter(0.7, Number(0.05, 5), "acceleration that is asked of the robot", "m/s^2")
    braking: float = parameter(0.8, Number(0.05, 5), "deceleration that is asked of the robot", "m/s^2")
    turn_acceleration: float = parameter(4.0, Number(0.1, 20), "angular acceleration and deceleration", "rad/s^2")
    margin: float = parameter(0.035, Number(0, 0.3), "distance that the outline keeps from everything", "m")
    margin_walking: float = parameter(0.1, Number(0, 0.5), "the same from what may walk", "m")
    reaction: float = parameter(0.45, Number(0, 2), "time from an obstacle to its echo, and to the brakes", "s")
    spare: float = parameter(0.04, Number(0, 0.5), "way that is left after braking", "m")
    walking: float = parameter(0.5, Number(0, 2), "speed at which a young echo may come nearer", "m/s")
    passing: float = parameter(
        0.2, Number(0.05, 2), "speed at which it may go by what is on no map and has stood still", "m/s")
    tight: float = parameter(
        0.15, Number(0.05, 2), "speed while it makes a map, where `margin_walking` is not free on both sides", "m/s")
    backward: float = parameter(0.15, Number(0, 1), "greatest speed backward", "m/s")
    horizon: float = parameter(1.5, Number(0.2, 5), "how far ahead in time a move is judged", "s")
    delay: float = parameter(0.15, Number(0, 1), "time until a command has an effect", "s")
    heading_weight: float = parameter(0.3, Number(0, 5), "what a radian off the best heading costs", "m")
    near_weight: float = parameter(0.5, Number(0, 10), "weight of the cost of the floor that a move passes")
    change_weight: float = parameter(0.02, Number(0, 5), "what a change of the turn rate costs", "m for each rad/s")
    reversal_weight: float = parameter(0.15, Number(0, 5), "what turning back on the spot costs", "m")
    impatience: float = parameter(0.3, Number(0, 10), "what standing costs more for each second without a way", "m")
    squeeze_after: float = parameter(4.0, Number(0, 600), "time without a way after which it keeps next to no distance",
                                     "s")
    retrace_narrower: float = parameter(0.04, Number(0, 0.2), "it counts as so much narrower on each side while it goes"
                                        " back over floor that it just drove", "m")
    dawdle_after: float = parameter(
        8.0, Number(0, 600), "time without a way after which slow moves cost more, and turning back on the spot", "s")
    most_dawdling: float = parameter(
        0.5, Number(0, 10), "what slow moves cost more at most, when all but standing", "m")
    turns_on: float = parameter(
        11.0, Number(1, 100), "turning back on the spot costs so many times as much then, while it makes a map")
    arrived: float = parameter(0.035, Number(0.005, 0.5), "distance from the goal that is good enough", "m")
    arrived_at_last: float = parameter(
        0.1, Number(0.005, 0.5), "distance from the goal that is good enough where it has no way on for a while", "m")
    arrived_heading: float = parameter(0.03, Number(0.005, 0.5), "heading off the goal's that is good enough", "rad")
    final_gain: float = parameter(2.0, Number(0.1, 5), "its speed there for each metre that is left", "1/s")
    final_turn_gain: float = parameter(5.0, Number(0.1, 20), "its turn rate there for each radian that is left", "1/s")
    final_turn_slowest: float = parameter(0.12, Number(0.01, 1), "its least turn rate there", "rad/s")
    final_turn_braking: float = parameter(0.7, Number(0.1, 1), "share of its angular deceleration that it uses there")
    answered: float = parameter(
        0.02, Number(0, 1), "time from the arrival of a packet to the effect of its answer", "s")
    final: float = parameter(0.6, Number(0.1, 2), "distance from which the robot aims at the goal itself", "m")


@dataclass(frozen=True)
class NavigatorNumbers:
    """Numbers of `navigator`."""

    better: float = parameter(
        0.8, Number(0.01, 1), "a new plan is taken if it costs less than this share of the present way")
    plan_kept: float = parameter(6.0, Number(0, 600), "time after which a new plan is taken anyway", "s")
    replan: float = parameter(1.0, Number(0.1, 10), "time from one plan to the next", "s")
    stale: float = parameter(0.5, Number(0.1, 5), "what the robot senses is too old after this time", "s")
    silent: float = parameter(1.0, Number(0.2, 10), "a transducer that has not fired for this time does not look", "s")
    unsure_turn: float = parameter(0.4, Number(0, 2), "turn rate with which it looks around when unsure", "rad/s")
    unsure_speed: float = parameter(
        0.15, Number(0, 1), "speed with which it looks from elsewhere when unsure only of where it is along a line",
        "m/s")
    unsure_drive: float = parameter(30.0, Number(0, 600), "only so long after it stopped to be sure it drives so", "s")
    unsure_beside: float = parameter(
        10.0, Number(0, 600), "it does not look around beside what is no wall and came a shorter time ago to where it"
        " had heard that nothing was", "s")
    patience: float = parameter(60.0, Number(1, 3600), "time without progress after which it gives up", "s")
    wait: float = parameter(120.0, Number(1, 3600), "time that it waits for one reason before it gives up", "s")
    slow: float = parameter(5.0, Number(0.1, 600), "time without progress that counts as having no way", "s")
    progress: float = parameter(0.3, Number(0.01, 5), "what the cost to go must fall to count as progress", "m")
    aside_after: float = parameter(
        20.0, Number(1, 3600), "time without progress after which it goes aside, so that others get by", "s")
    aside: float = parameter(0.8, Number(0.1, 5), "so far it goes aside", "m")
    most_asides: int = parameter(6, Whole(0, 100), "it gives up when it would have to go aside more often")
    aside_time: float = parameter(10.0, Number(1, 600), "time after which it is on its way to the goal again", "s")
    got_on: float = parameter(0.1, Number(0, 1), "so far it must have driven by its wheels to count as progress", "m")
    rest: float = parameter(1.0, Number(0, 10), "time it stands after a stall", "s")
    most_stalls: int = parameter(3, Whole(1, 100), "it gives up the goal when its wheels stall so often on the way")
    give_way: float = parameter(0.25, Number(0, 2), "it stands while what may walk is so near to its outline", "m")


@dataclass(frozen=True)
class MapNumbers:
    """How echoes become cells of a map (`sonar_grid`)."""

    resolution: float = parameter(0.05, Number(0.02, 0.2), "side of a cell", "m")
    half_cone: float = parameter(0.218, Number(0.05, 0.6), "from the axis of a sonar cone to its edge", "rad")
    reach: float = parameter(2.5, Number(0.5, 5.0), "echoes from farther away are not used", "m")
    reach_of_silence: float = parameter(1.2, Number(0.5, 5.0), "no echo: free as far as this", "m")
    occupied: float = parameter(1.5, Number(0.1, 3.0), "log-odds that one echo gives to all cells of its arc together")
    free: float = parameter(0.35, Number(0.05, 2.0), "log-odds that one firing takes from a cell on its axis")
    aside: float = parameter(0.9, Number(0.0, 1.0), "share of `free` that is lost at the edge of the cone")
    far: float = parameter(0.9, Number(0.0, 1.0), "share of `free` that is lost at `reach`")
    silent: float = parameter(0.05, Number(0.0, 1.0), "share of `free` when there was no echo: the wall may slant")
    short_of: float = parameter(0.12, Number(0.0, 0.3), "free only up to this before the echo", "m")
    wall: float = parameter(0.4, Number(0.05, 3.0), "log-odds from which a cell is occupied")
    floor: float = parameter(-0.8, Number(-3.0, -0.05), "log-odds up to which a cell is free")
    hides: float = parameter(0.3, Number(0.1, 5.0), "log-odds from which nothing behind a cell is freed")
    certain: float = parameter(6.0, Number(0.5, 10.0), "greatest odds, as a logarithm, that count in sharing an echo")


@dataclass(frozen=True)
class MatchNumbers:
    """How a stretch of path finds its place on the map (`scan_match`)."""

    wall: float = parameter(1.0, Number(0.05, 3.0), "log-odds from which a cell is a wall to fit to")
    reach: float = parameter(2.5, Number(0.5, 5.0), "echoes from farther away are not used", "m")
    half_cone: float = parameter(0.218, Number(0.05, 0.6), "from the axis of a sonar cone to its edge", "rad")
    points: int = parameter(24, Whole(1, 200), "points of walls that are looked at for a reading")
    blur: float = parameter(0.05, Number(0.02, 0.3), "deviation of a reading that fits", "m")
    nearer: float = parameter(0.018, Number(0.0, 0.1), "the nearest of a wall's points is so much nearer than it", "m")
    miss: float = parameter(0.15, Number(0.01, 1.0), "weight of readings that do not fit")
    neutral: float = parameter(0.8, Number(0.0, 1.0), "fit of readings where the map has no wall")
    trust: float = parameter(0.3, Number(0.01, 1.0), "share of each reading that counts: they are not independent")
    step: float = parameter(0.05, Number(0.02, 0.2), "distance of the poses that are tried first", "m")
    turn_step: float = parameter(0.026, Number(0.005, 0.1), "the same for headings", "rad")
    edge: float = parameter(1.0, Number(0.0, 10.0), "log-likelihood that the edge of the window costs")
    near: float = parameter(0.03, Number(0.005, 0.2), "readings are fitted by parabolas so far round a pose", "m")
    near_turn: float = parameter(0.02, Number(0.005, 0.1), "the same for headings", "rad")


@dataclass(frozen=True)
class WallNumbers:
    """How straight walls are found in what a stretch of path heard, and held square (`wall_directions`)."""

    reach: float = parameter(2.5, Number(0.5, 5.0), "echoes from farther away are not used", "m")
    band: float = parameter(0.04, Number(0.01, 0.2), "a reading belongs to a wall when it is so near to it", "m")
    least: int = parameter(6, Whole(3, 100), "readings that must agree on a wall")
    span: float = parameter(0.6, Number(0.2, 2.0), "way along the wall on which they must lie", "m")
    bend: float = parameter(
        0.3, Number(0.0, 10.0), "what is bent more is no wall: 0 is straight, 1 is one point, as a post or an edge")
    stretches: int = parameter(3, Whole(1, 10), "stretches of path that tell of a wall together")
    most: int = parameter(3, Whole(1, 10), "walls that are looked for in these")
    least_walls: int = parameter(5, Whole(2, 100), "walls that must be square, or none is: few may be by chance")
    square: float = parameter(0.07, Number(0.01, 0.3), "walls are taken as square when they are off by less", "rad")
    share: float = parameter(
        0.5, Number(0.3, 1.1), "share of all walls that must be square, or none is held so; above 1: none ever is")
    slack: float = parameter(0.02, Number(0.001, 0.2), "added to the deviation of a wall's direction", "rad")
    ties_alone: float = parameter(
        0.04, Number(0.001, 1.0), "weight of the places at which stretches were found, while there are walls enough but"
                                  " none is held square")


@dataclass(frozen=True)
class MapperNumbers:
    """When a map is corrected (`mapping`)."""

    stretch: float = parameter(1.0, Number(0.3, 5.0), "length of a stretch of path", "m")
    turn_counts: float = parameter(0.4, Number(0.0, 2.0), "a turn of 1 rad counts as this much path", "m")
    batch: int = parameter(20, Whole(1, 500), "firings that are drawn together")
    window: float = parameter(0.2, Number(0.05, 1.0), "how far a stretch is looked for", "m")
    window_turn: float = parameter(0.104, Number(0.01, 0.5), "the same for its heading", "rad")
    again: float = parameter(0.5, Number(0.1, 1.0), "share of this window when it is looked for again")
    least_count: int = parameter(12, Whole(3, 200), "readings that must say something")
    least_fit: float = parameter(0.7, Number(0.1, 1.0), "share of them that must fit")
    most_readings: int = parameter(80, Whole(10, 1000), "readings that are used to find a stretch")
    contributors: int = parameter(5, Whole(1, 10), "older stretches to which one is tied")
    slack: float = parameter(0.02, Number(0.001, 0.2), "added to the deviation of a found pose", "m")
    slack_turn: float = parameter(0.05, Number(0.001, 0.2), "the same for its heading", "rad")
    roll: float = parameter(0.006, Number(0.0005, 0.1), "deviation of a metre by odometry; grows with its root", "m")
    roll_turn: float = parameter(0.006, Number(0.001, 0.1), "deviation of the heading after a metre", "rad")
    turn_turn: float = parameter(0.006, Number(0.0, 0.1), "deviation of the heading after a turn of 1 rad", "rad")
    distance_bias: float = parameter(0.03, Number(0.0, 0.1), "expected error of the wheels' size, as a share")
    turning_bias: float = parameter(0.05, Number(0.0, 0.2), "expected error of turns, as a share")
    veer_bias: float = parameter(0.012, Number(0.0, 0.1), "expected error of straight lines", "rad/m")
    found_first: float = parameter(
        5.0, Number(1.0, 1000.0), "where a stretch was found first counts for ever, as if it deviated so many times as"
                                  " much")
    size_error: float = parameter(
        0.1, Number(0.0001, 1.0), "what is found later is expected to be too large or too small by this share")
    doubt: float = parameter(3.0, Number(0.5, 20.0), "a found pose that is off by so many deviations counts half")
    redrawn: float = parameter(0.01, Number(0.001, 0.2), "a stretch that moved so far is drawn anew", "m")
    redrawn_turn: float = parameter(0.006, Number(0.0005, 0.1), "the same for its heading", "rad")


@dataclass(frozen=True)
class ExploringNumbers:
    """Where a robot goes that explores (`exploring`)."""

    least_width: float = parameter(0.25, Number(0.0, 2.0), "narrower ends of the map are left alone", "m")
    view: float = parameter(1.5, Number(0.3, 5.0), "unknown floor so near to the end of the map counts as gain", "m")
    gain: float = parameter(0.8, Number(0.0, 10.0), "way that it goes for 1 m^2 of gain", "m")
    most_gain: float = parameter(3.0, Number(0.0, 50.0), "more gain does not count", "m^2")
    turn: float = parameter(0.3, Number(0.0, 5.0), "way that a turn of 1 rad at the begin counts as", "m")
    piece: float = parameter(0.8, Number(0.2, 5.0), "ends of the map that are longer are taken in such pieces", "m")
    comfort: float = parameter(0.1, Number(0.0, 1.0), "so much farther from walls it rather stands to look", "m")
    sees: float = parameter(1.0, Number(0.1, 3.0), "so near to an end of the map it turns to look at it", "m")
    still_unknown: float = parameter(0.25, Number(0.0, 1.0), "share of unknown cells from which an end is not known")
    given_up: float = parameter(0.5, Number(0.1, 5.0), "nothing so near to an end that was given up is tried", "m")
    tries: int = parameter(
        3, Whole(1, 20), "an end is left alone after so many tries near it, also where each made it known")
    near: float = parameter(
        1.2, Number(0.3, 10.0), "before it goes home it looks at walls that it was never so near to", "m")
    doubted_width: float = parameter(0.4, Number(0.0, 10.0), "the shortest wall that it looks at for that", "m")
    most_doubts: int = parameter(8, Whole(0, 1000), "it looks at so many such walls at most")
    moved: float = parameter(0.25, Number(0.05, 2.0), "it gets on while it moves so far", "m")
    away: float = parameter(
        1.0, Number(0.1, 10.0), "an end of the map is given up for good only where the robot came so far on its way, or"
                                " so near to it", "m")
    stuck: float = parameter(8.0, Number(1.0, 600.0), "time without getting on after which it gives up an end", "s")
    patience: float = parameter(20.0, Number(1.0, 600.0), "time that it takes for an end, at most", "s")
    patience_per_metre: float = parameter(6.0, Number(0.5, 60.0), "what each metre of the way there adds", "s")
    homeward: float = parameter(180.0, Number(10.0, 3600.0), "time that it takes for each of its tries to go home, at "
                                "most", "s")
    off_floor: float = parameter(0.6, Number(0.1, 3.0), "it looks so far for the floor when it stands beside it", "m")


class NavigationNumbers(NamedTuple):
    """The tuned numbers of all parts of navigation."""

    localisation: LocalisationNumbers = LocalisationNumbers()
    laser: LaserSenseNumbers = LaserSenseNumbers()
    planning: PlanningNumbers = PlanningNumbers()
    obstacles: ObstacleNumbers = ObstacleNumbers()
    suspected_walls: SuspicionNumbers = SuspicionNumbers()
    steering: SteeringNumbers = SteeringNumbers()
    navigator: NavigatorNumbers = NavigatorNumbers()
    sonar_grid: MapNumbers = MapNumbers()
    scan_match: MatchNumbers = MatchNumbers()
    wall_directions: WallNumbers = WallNumbers()
    mapper: MapperNumbers = MapperNumbers()
    exploring: ExploringNumbers = ExploringNumbers()

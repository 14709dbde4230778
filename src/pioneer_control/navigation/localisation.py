"""Where the robot is on a known map, from odometry and sonar or a laser: a cloud of poses, moved and weighed.

The cloud (a particle filter) follows the robot. A search (`PoseSearch`) looks for poses anywhere on the map that
explain the last readings better: so the robot finds out where it begins, and that somebody has carried it. Where it
is not sure, it says why.
"""

import math
from typing import Any, NamedTuple, Optional, Sequence, Set, Tuple, Union

import numpy as np

from ..floor_poses import Pose, compose, relative
from ..maps import FREE, GridMap
from ..robots import Transducer
from .certainty import NOT_TOLD, Certainty
from .expected_ranges import SONAR_BEAM, standing_room
from .laser_field import LaserField
from .looks import Looks
from .measurement import Beams, RangeModel
from .pose_cloud import PoseCloud, Spread
from .pose_search import Found, PoseSearch, same_place
from .recent_readings import FiringPoses, RecentReadings, scan_beams
from .tuned import SONAR_NUMBERS, LaserSenseNumbers, LocalisationNumbers
from .unseen_motion import SHORTEST_UNSEEN, UnseenMotion
from .values import Scan, Sensing
from .wheel_calibration import WheelCalibration

Array = Any     # of numpy

OFF_THE_FLOOR = 50.0
"""What the log-likelihood of a pose loses where no floor is free."""
LINE_STEP = 0.2
"""Distance (m) between two poses of `Where.line`, about."""
SHORTEST_WAY = 0.003
"""Readings after a shorter way (m) are not weighed: the robot stands."""
SAME_WAY = 0.5
"""A robot looks about the same way in two poses if the cosine of the turn between these is greater."""
ONE_PLACE = 0.3
"""A robot that has not driven so far (m), about, has heard all from one place."""
FOUND_POSITION, FOUND_HEADING = 0.06, 0.05
"""Standard deviation (m, rad) of a pose that a search found."""
PACKETS_WEIGHED = 2
"""The readings of so many packets are weighed at once: that costs little more than those of one."""


class Where(NamedTuple):
    """Where the robot is.

    Attributes:
        time: time (s) of the packet.
        pose: the most likely pose (map frame).
        sure: whether another program may drive by this pose.
        covariance: array (3, 3) of x, y (m^2) and heading (rad^2), of all likely poses.
        reason: why it is not sure, for people; empty if it is.
        line: poses along a line on which the robot is for certain, when it is not sure only of where on it; else empty.
        by_laser: whether the scans of a laser tell it; else it is sonar alone.
    """

    time: float
    pose: Pose
    sure: bool
    covariance: Array
    reason: str
    line: Tuple[Pose, ...] = ()
    by_laser: bool = False


class Sense:
    """A sensor in use.

    Args:
        model: how poses explain it.
        search: finds poses that explain it.
        weight: what share of its log-likelihoods counts.
        evidence: what a reading counts when those are counted that the pose explains.
        tuned: numbers of localisation.

    Attributes:
        recent: its newest readings, while it is the main sense.
        searched: how many of them had been heard at the last search.
        way: the way (m) since its last readings. Turns count as some way, too.
        new_way: the same, but turns count only where the robot looks anew from its place.
    """

    def __init__(self, model: Union[RangeModel, LaserField], search: PoseSearch, weight: float, evidence: float,
                 tuned: LocalisationNumbers):
        self.model, self.search, self.weight, self.evidence = model, search, weight, evidence
        self.recent, self.searched = RecentReadings(tuned.remembered), 0
        self._turn_as_way = tuned.turn_as_way
        self.looks = Looks(tuned.looks_anew, tuned.turns_anew)
        self.way = self.new_way = 0.0
        self._heard: Set[int] = set()

    def forget(self) -> None:
        """What was heard up to now tells nothing about where the robot is."""
        self.recent.forget()
        self.search.give_up()
        self.looks.forget()
        self._heard.clear()

    def take_first(self, beams: Beams) -> Beams:
        """Return the readings that are the first of their transducer or ray since `forget`. No later one is."""
        sensors, index = np.unique(beams.sensor, return_index=True)
        new = [each not in self._heard for each in sensors.tolist()]
        self._heard.update(sensors.tolist())
        return beams.some(index[new])

    def move(self, step: Pose, odometry: Pose) -> None:
        """The robot has made a step (m, rad; robot's frame before it), and is at `odometry` by the wheels."""
        straight = math.hypot(step.x, step.y)
        self.way += straight + self._turn_as_way * abs(step.heading)
        self.new_way += straight + self._turn_as_way * self.looks.new_part(odometry, step.heading)


class LaserSense(Sense):
    """A laser in use, from its first scan on.

    Attributes:
        scan: the newest scan, until it is weighed.
        scanned: when it came (s).
    """

    scan: Optional[Scan] = None
    scanned = -math.inf

    def forget(self) -> None:
        """As `Sense.forget`; a scan that is not weighed yet is forgotten, too."""
        super().forget()
        self.scan = None


class Localisation:
    """Localises one robot on one map. The same values with the same seed give the same poses.

    At first the start is unknown. `known_start` says where the robot is. Times never go back; after a jump of time or
    another map, make a new object.

    Args:
        grid_map: the map.
        transducers: the sonar transducers of the robot.
        tuned: numbers to use.
        seed: seed of all random choices.
        laser_tuned: numbers of the laser, for a robot that has one.

    Attributes:
        where: the last result; None before the first packet.
        unseen: what the robot may have driven while nobody heard of it.
    """

    def __init__(self, grid_map: GridMap, transducers: Sequence[Transducer],
                 tuned: LocalisationNumbers = LocalisationNumbers(), seed: int = 0,
                 laser_tuned: LaserSenseNumbers = LaserSenseNumbers()):
        self._map, self._tuned, self._laser_tuned = grid_map, tuned, laser_tuned
        self._luck = np.random.default_rng(seed)
        self._places = standing_room(grid_map, tuned.clearance)
        sonar = RangeModel(grid_map, SONAR_BEAM, SONAR_NUMBERS, tuned.map_bias)
        self._sonar = Sense(sonar, self._search_with(sonar), tuned.weight, 1.0, tuned)
        self._main = self._sonar        # the sense that searches and judges
        self._laser: Optional[LaserSense] = None    # until the first scan
        self._cloud = PoseCloud(tuned, self._luck)
        self._firing_poses = FiringPoses(transducers)
        self._certainty = Certainty(tuned)
        self._wheels, self.unseen = WheelCalibration(), UnseenMotion()
        self._pose = Pose(0.0, 0.0, 0.0)
        self._odometry: Optional[Pose] = None       # as the wheels measured it
        self._next_search = 0.0         # its time (s)
        self._packets = 0       # since readings were weighed; what somebody says counts at the next one
        self._search_odometry = Pose(0.0, 0.0, 0.0)
        self.where: Optional[Where] = None
        self.unknown_start()

    def _search_with(self, model: Union[RangeModel, LaserField]) -> PoseSearch:
        return PoseSearch(model, self._places, len(self._places) * self._map.resolution ** 2, self._tuned, self._luck)

    @property
    def particles(self) -> Array:
        """The cloud, for drawing: array (poses, 3) of x, y (m) and heading (rad)."""
        return self._cloud.poses

    def known_start(self, pose: Pose, position: float = 0.5, heading: float = 0.26) -> None:
        """Say where the robot is now, and how exactly: standard deviations in m and rad."""
        self._hear_anew()
        self._known, self._packets = True, PACKETS_WEIGHED
        self._cloud.put(np.array([pose], dtype=float), np.zeros(1), position, heading, self._tuned.particles_searching)
        self._certainty.place(trusted=True)
        self._pose = pose

    def unknown_start(self) -> None:
        """Say that the robot may be anywhere."""
        self._hear_anew()
        self._known, self._packets = False, PACKETS_WEIGHED
        self._certainty.lose(NOT_TOLD)
        count = self._tuned.particles_searching
        self._cloud.put(self._main.search.random_poses(count), np.zeros(count), 0.0, 0.0, count)

    def _hear_anew(self) -> None:
        """What was heard up to now tells nothing about where the robot is."""
        self._firing_poses.forget()
        for sense in (self._sonar, self._laser):
            if sense is not None:
                sense.forget()

    def update(self, sensing: Sensing) -> Where:
        """Take what the robot senses in one packet. Return where it is at the time of the packet.

        Between two packets with which sonar is weighed, a scan of the laser is. Without one, the pose moves with the
        odometry.
        """
        self._move(sensing.odometry, sensing.time)
        self._firing_poses.add(sensing)
        self._hear_laser(sensing)
        self._packets += 1
        if self.where is None or self._packets >= PACKETS_WEIGHED:
            self._packets = 0
            beams = self._firing_poses.beams(self._sonar.model.number_of)
            return self._take(self._sonar, beams, sensing.time)
        laser = self._laser
        if laser is not None and laser.scan is not None:
            beams = scan_beams(laser.scan, sensing.odometry, laser.model.number_of, self._laser_tuned.rays)
            laser.scan = None
            return self._take(laser, beams, sensing.time)
        self._look_everywhere(sensing.time)
        self.where = self.where._replace(time=sensing.time, pose=self._pose, sure=self._certainty.sure,
                                         reason=self._certainty.reason)
        return self.where

    def _hear_laser(self, sensing: Sensing) -> None:
        """Keep the newest scan. The laser tells more than sonar: while scans come, it searches and judges.

        A scan in which it sees next to nothing is none: it would keep sonar from noticing that the pose is wrong.
        """
        laser, numbers = self._laser, self._laser_tuned
        if sensing.scan is not None and not sensing.scan.is_blind:
            if laser is None:
                field = LaserField(self._map, numbers)
                laser = self._laser = LaserSense(field, self._search_with(field), numbers.weight, numbers.evidence,
                                                 self._tuned)
            self._change_main(laser)
            laser.scan, laser.scanned = sensing.scan, sensing.time
        elif laser is not None and sensing.time - laser.scanned > numbers.patience:
            self._change_main(self._sonar)

    def _change_main(self, sense: Sense) -> None:
        if sense is not self._main:
            self._main.forget()
            sense.forget()
            self._main = sense
            self._certainty.change_sense()

    def _move(self, odometry: Pose, time: float) -> None:
        """Move the cloud to new odometry, of a time (s)."""
        step = relative(self._odometry or odometry, odometry)
        self._odometry = odometry
        unseen = self.unseen.after(time, step)
        step = self._wheels.corrected(step)
        self._cloud.move(step)
        self._pose = compose(self._pose, step)
        if unseen is not None and self._certainty.sure:
            self._spread_along(unseen)
        for sense in (self._sonar, self._laser):
            if sense is not None:
                sense.move(step, self._wheels.odometry)

    def _spread_along(self, unseen: Pose) -> None:
        """Spread the cloud: the robot may be anywhere on a motion (m, rad) that nobody saw."""
        middle = compose(self._pose, Pose(unseen.x / 2.0, 0.0, unseen.heading / 2.0))
        self.known_start(middle, abs(unseen.x) / 2.0 + SHORTEST_UNSEEN, abs(unseen.heading) / 2.0 + SHORTEST_UNSEEN)

    def _take(self, sense: Sense, beams: Beams, time: float) -> Where:
        """Weigh the cloud by readings, the less the shorter the way since the last ones: standing tells nothing new.

        Only the first look of a robot that was told where it is counts also while it stands. While the robot is not
        sure, a turn counts only where it has not looked yet from its place. While it is sure, each turn counts:
        readings correct what the wheels measured.
        """
        tuned, way, new_way, sure = self._tuned, sense.way, sense.new_way, self._certainty.sure
        moved = way >= SHORTEST_WAY and len(beams.x) > 0
        first = sense.take_first(beams)
        if moved:
            explained = self._weigh(sense, beams, min(1.0, (way if sure else new_way) / tuned.full_way))
            sense.way = sense.new_way = 0.0
        else:
            way = new_way = 0.0
            explained = sense.model.explained(self._pose, beams)
            if self._known and len(first.x):
                self._weigh(sense, first, tuned.first_look)
        if sense is self._main:
            if len(beams.x):
                self._certainty.hear(beams, explained, way, new_way, sense.evidence)
            if moved:
                sense.recent.add(self._wheels.odometry, beams)
            if self._certainty.fits:
                sense.recent.mark()
        self._look_everywhere(time)
        spread = self._cloud.spread()
        self._pose = spread.pose
        was_sure = self._certainty.sure
        self._certainty.judge(spread)
        if was_sure and not self._certainty.sure:
            self._next_search = time
            if self._certainty.doubts:      # what was heard before may belong to another place
                self._main.recent.keep_marked(tuned.kept_in_doubt)
                self._main.search.give_up()
        self._wheels.learn(spread.pose if self._certainty.sure else None)
        line = _line(spread) if self._certainty.on_a_line else ()
        self.where = Where(time, spread.pose, self._certainty.sure, spread.covariance, self._certainty.reason, line,
                           self._main is not self._sonar)
        return self.where

    def _weigh(self, sense: Sense, beams: Beams, share: float) -> Array:
        """Weigh the cloud by a share of what readings tell. Return for each of them whether the pose explains it."""
        tuned, sure = self._tuned, self._certainty.sure
        logs, explained = sense.model.both(self._cloud.poses, self._pose, beams)
        logs[self._map.at(*self._cloud.poses[:, :2].T) != FREE] -= OFF_THE_FLOOR
        if share > 0.0:     # else only chance would choose among the poses
            self._cloud.weigh(logs * sense.weight * share, tuned.particles if sure else tuned.particles_searching,
                              roughen=not sure)
        return explained

    def _look_everywhere(self, time: float) -> None:
        """Search for better poses, a step at each packet."""
        tuned, odometry, main = self._tuned, self._wheels.odometry, self._main
        if main.search.runs:
            found = main.search.step()
            if found is not None:
                self._consider(found, odometry)
                self._next_search = time + self._certainty.search_period
            return
        if self._certainty.suspects:
            self._next_search = min(self._next_search, time)
        if (time >= self._next_search and len(main.recent) >= tuned.least_readings
                and main.recent.heard >= main.searched + tuned.new_readings):
            main.searched = main.recent.heard
            beams = self._compared(odometry)
            if np.count_nonzero(beams.measured != main.model.none) >= tuned.least_readings / 2:
                self._search_odometry = odometry
                main.search.begin(beams)

    def _compared(self, odometry: Pose) -> Beams:
        """Return the readings that poses are compared with."""
        beams = self._main.recent.seen_from(odometry)
        return beams.some(slice(-self._tuned.suspect_readings, None)) if self._certainty.suspects else beams

    def _consider(self, found: Found, odometry: Pose) -> None:
        """Compare the cloud with what a search found, and go to what is much better."""
        step = relative(self._search_odometry, odometry)
        beams = self._compared(odometry)
        spots = float(self._main.model.spot_shares(beams).sum())
        moved = np.array([compose(Pose(*pose), step) for pose in found.poses.tolist()])
        others = self._main.search.scored(moved, beams)
        if self._known:
            here = self._main.search.improved(self._cloud.poses[::10], beams)
            apart = [not same_place(pose, here.poses[0]) for pose in others.poses]
            others = Found(others.poses[apart], others.scores[apart])
            if not self._believes(others, here, beams, spots):
                elsewhere = [pose for pose in self._cloud.poses[::10] if not same_place(pose, here.poses[0])]
                if elsewhere and self._certainty.settled:
                    self._put(here.poses, np.zeros(1))
                return
            others = Found(np.vstack((others.poses, here.poses)), np.concatenate((others.scores, here.scores)))
        if self._certainty.suspects:
            self._main.recent.keep(self._tuned.kept_in_doubt)
        self._known = True
        logs = others.scores * spots * self._tuned.weight
        self._put(others.poses, logs)
        rivals = [not same_place(pose, others.poses[0]) for pose in others.poses]
        better = others.scores[0] - others.scores[rivals].max(initial=-np.inf)
        self._certainty.place(trusted=False, alone=bool(better > self._tuned.margin))
        self._main.looks.forget()       # no look has counted for this place yet

    def _put(self, poses: Array, logs: Array) -> None:
        """Put the cloud where a search says that the robot may be, with the log-likelihood of each place."""
        self._cloud.put(poses, logs, FOUND_POSITION, FOUND_HEADING, self._tuned.particles_searching)

    def _believes(self, others: Found, here: Found, beams: Beams, spots: float) -> bool:
        """Return whether other poses are believed rather than the pose that the robot has; perhaps doubt this one.

        Args:
            others: poses elsewhere.
            here: the pose that it has.
            beams: the readings that both are compared with.
            spots: how many spots these tell of.
        """
        certainty = self._certainty
        better = others.scores.max(initial=-np.inf) - here.scores[0]
        if certainty.proven and len(others.poses):      # what was heard just now must say so, too
            newest = beams.some(slice(-len(beams.x) // 4, None))
            better = min(better, self._main.search.scored(others.poses, newest).scores[0]
                         - self._main.search.improved(here.poses, newest).scores[0])
        off = others.poses - here.poses[0]
        beside = (np.hypot(off[:, 0], off[:, 1]) < self._tuned.beside) & (np.cos(off[:, 2]) > SAME_WAY)
        stood_on = np.hypot(np.ptp(beams.x), np.ptp(beams.y))       # diagonal of where the sensors were
        certainty.compare(-better, spots, here.scores[0] - others.scores[beside].max(initial=-np.inf),
                          bool(stood_on < self._firing_poses.span + ONE_PLACE))
        if better < certainty.margin or not certainty.accepts(self._main.model.explained(others.poses[0], beams)):
            return False
        if better < certainty.margin * certainty.caution(spots):
            if certainty.sure:
                certainty.doubt()
                self._main.recent.keep(self._tuned.kept_in_doubt)
            return False
        return True


def _line(spread: Spread) -> Tuple[Pose, ...]:
    """Return poses along the line on which a long and narrow cloud lies: two standard deviations to both ends."""
    (x, y, heading), reach = spread.pose, 2.0 * spread.position
    cosine, sine = np.cos(spread.direction), np.sin(spread.direction)
    steps = np.linspace(-reach, reach, 2 * int(np.ceil(reach / LINE_STEP)) + 1)
    return tuple(Pose(float(x + step * cosine), float(y + step * sine), heading) for step in steps)

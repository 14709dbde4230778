"""Whether the robot may trust the pose that it has: a judgement on the cloud and on the readings."""

import math
from typing import Any, Dict, Tuple

import numpy as np

from .measurement import Beams
from .pose_cloud import Spread
from .tuned import LocalisationNumbers

Array = Any     # of numpy

UNKNOWN = "I do not know where I am: "
"""The beginning of each reason."""
NOT_TOLD = "nobody told me, and I have not heard enough yet: drive me a little"
UNCONFIRMED = "I have heard nothing yet that tells whether I am where I should be"
"""Of a place that the robot was told, before the first echo."""
JUST_FOUND = "I have just found a place where I may be, and must move a little to be sure"
_ALIKE = "other places look like this one"
LEAST_USUAL = 0.5
"""The true pose explains at least this share of echoes, wherever the robot is."""
_LINE = 3.0     # so many times narrower is the cloud of a pose on a line than that of a sure pose may be wide
OTHER = 10
"""A range whose number differs by more from the sensor's last one is new, also while the robot stands."""


class Certainty:
    """Judges, packet by packet.

    Each world has a usual share of echoes that the true pose explains: furniture, slanting walls and people make it
    smaller. It is learnt while the pose is sure. A pose is doubted when too many echoes more than usual are unexplained
    (a CUSUM test): each echo adds what it misses to a sum, or takes from it, and the sum never falls below zero.

    Args:
        tuned: the numbers of localisation.

    Attributes:
        reason: why the pose is not sure, for people; empty if it is.
        explained: share of the last echoes that the pose explains.
        on_a_line: the pose is not sure, but only as the robot may be farther on or back along a line: in a corridor.
    """

    def __init__(self, tuned: LocalisationNumbers):
        self._tuned = tuned
        self._usual = tuned.usual_explained
        self._heard: Dict[int, Tuple[int, int]] = {}    # of each sensor: its last number, how often it may still count
        self._missed = 0.0      # so many more echoes should have been explained
        self._spots, self._one_place = 0.0, False   # heard at the last search, see `compare`
        self._outdone = False   # since it was sure last, a search has found a place that explains more
        self.lose(NOT_TOLD)

    @property
    def sure(self) -> bool:
        """Whether the pose is sure."""
        return not self.reason

    @property
    def proven(self) -> bool:
        """Whether the place has explained the readings on a long way: one that looks alike is no reason to doubt it."""
        return self._trusted_way >= self._tuned.proven_way

    @property
    def settled(self) -> bool:
        """Whether the last searches found no place like this one, though a robot that has only turned is not sure yet.

        What it hears on a way narrows the cloud, without that. False if somebody told the place, or a long way has
        proven it.
        """
        return self._one_place and not self.proven and self._upheld >= self._tuned.sure_searches

    @property
    def doubts(self) -> bool:
        """Whether the readings contradict the pose."""
        return self._missed >= self._tuned.unsure_missed

    @property
    def fits(self) -> bool:
        """Whether nothing speaks against the pose. It held last about when the robot was carried."""
        return self._missed == 0.0

    @property
    def suspects(self) -> bool:
        """Whether the readings begin to contradict a pose that is sure: somebody may have carried the robot."""
        return self.sure and self._missed >= self._tuned.suspect_missed

    @property
    def margin(self) -> float:
        """By how much another pose must explain each spot better (log-likelihood) to be believed; where few spots were
        heard, to raise a doubt (see `caution`).
        """
        tuned = self._tuned
        trusted = min(1.0, self._trusted_way / tuned.proven_way)
        grown = tuned.margin_guessed + (tuned.margin_proven - tuned.margin_guessed) * trusted
        return max(grown, tuned.margin) if self.sure else grown

    def caution(self, spots: float) -> float:
        """Return the factor by which margins grow when few spots were heard, see `RangeModel.spot_shares`.

        It is 1 to 2. More would shut out true places: in a small room there are never many spots.
        """
        return min(2.0, max(1.0, self._tuned.least_spots / max(1.0, spots)))

    def doubt(self) -> None:
        """From now on the pose is not sure: another place explains more. That ends when searches find none alike."""
        self._outdone, self.reason = True, UNKNOWN + _ALIKE

    @property
    def search_period(self) -> float:
        """Time (s) from one search for better poses to the next."""
        if not self.sure or self.suspects:
            return self._tuned.period_unsure
        return self._tuned.period_proven if self.proven else self._tuned.period_sure

    def lose(self, why: str) -> None:
        """From now on no place is likely."""
        self._placed, self._lost, self._unconfirmed = False, why, False
        self.reason, self.explained = UNKNOWN + why, self._usual
        self.on_a_line = False
        self._trusted_way = self._blind_way = 0.0
        self._unique = self._upheld = 0     # searches in a row that found no place alike; those while it was not sure

    def place(self, trusted: bool, alone: bool = False) -> None:
        """From now on some place is likely. `trusted`: somebody told it. `alone`: a search found none like it.

        What was told is not sure before readings fit it: a click may be wrong.
        """
        self._placed, self._outdone, self._missed = True, False, 0.0
        self.explained, self._unconfirmed = self._usual, trusted
        if trusted:
            self.explained *= self._tuned.told_explained
            self._heard.clear()
        self._trusted_way = self._tuned.proven_way if trusted else 0.0
        self._unique, self._upheld = self._tuned.sure_searches if trusted else int(alone), 0
        self.reason = self.reason or UNKNOWN + JUST_FOUND

    def accepts(self, explained: Array) -> bool:
        """Return whether another place explains readings as well as a true place usually does.

        What is usual may not be learnt yet: instead of a guess, one that explains as much as the guess is enough.
        """
        said = explained[~np.isnan(explained)]
        needed = self._tuned.place_explained * self._usual
        if not self.sure and not self.proven:
            needed = min(needed, self.explained)
        return len(said) > 0 and bool(said.mean() >= needed)

    def compare(self, better: float, spots: float, better_beside: float = math.inf, one_place: bool = False) -> None:
        """Take how much better (log-likelihood) the pose explains each spot than the best pose elsewhere does.

        Few echoes are explained where much stands that is on no map, and where walls slant. But if search after search
        finds no place that is anything like it, the robot is there, and so few are usual here. Beside a place that is
        sure or proven, others may look alike, but not better. A person's word, or a long way, excludes places far
        away. It does not exclude places close by: readings must tell these apart before the pose is sure.

        Args:
            better: that difference.
            spots: how many spots were heard.
            better_beside: the same for poses close by that look the same way; infinite if there are none.
            one_place: all was heard from one place.
        """
        tuned = self._tuned
        if self.sure:
            alone = better > 0.0
        elif self.proven:
            alone = better > 0.0 and better_beside > tuned.beside_margin
        else:
            margin = tuned.rival_margin_on_the_spot if one_place else tuned.rival_margin
            alone = better > margin * self.caution(spots)
        self._spots, self._one_place = spots, one_place
        self._unique = self._unique + 1 if alone else 0
        self._upheld = self._upheld + 1 if alone and not self.sure else 0
        if self._upheld >= tuned.upheld_searches:
            self._usual = max(LEAST_USUAL, min(self._usual, self.explained / tuned.sure_explained))
            self._missed = 0.0

    def change_sense(self) -> None:
        """From now on another sense judges: what is usual of the one before says nothing of it."""
        self.explained *= self._tuned.usual_explained / self._usual
        self._usual, self._missed = self._tuned.usual_explained, 0.0
        self._heard.clear()

    def hear(self, beams: Beams, explained: Array, way: float, new_way: float, evidence: float = 1.0) -> None:
        """Take what readings say about the pose.

        While the robot stands, the same readings come again and again: each sensor counts only some times, until the
        robot moves or the range becomes another one.

        Args:
            beams: the readings.
            explained: for each reading, see `RangeModel.explained`.
            way: way (m) since the last readings; 0: the robot stands.
            new_way: how much of it (m) told something new: it makes a place trusted.
            evidence: what each reading counts.
        """
        tuned = self._tuned
        for sensor, measured, said in zip(beams.sensor.tolist(), beams.measured.tolist(), explained.tolist()):
            if not self._counts(sensor, measured, way > 0.0) or math.isnan(said):
                continue
            self._unconfirmed = False
            missed = self._missed + evidence * tuned.unsure_explained * self._usual - evidence * said
            self._missed = min(max(missed, 0.0), tuned.unsure_missed)
            self.explained += evidence * (said - self.explained) / tuned.explained_readings
            if self.sure and self.explained >= tuned.unsure_explained * self._usual:
                self._usual += evidence * (said - self._usual) / tuned.explained_readings / 20.0
        self._usual = min(max(self._usual, LEAST_USUAL), 0.95)
        self._blind_way = 0.0 if (explained > 0.0).any() else self._blind_way + way
        if self.explained >= self._tuned.sure_explained * self._usual and (
                self.sure or self._trusted_way < self._tuned.sure_way):     # while it is not sure, no more than that
            self._trusted_way += new_way

    def _counts(self, sensor: int, measured: int, moved: bool) -> bool:
        """Return whether a reading counts, in which a sensor measured a range with this number."""
        before, left = self._heard.get(sensor, (measured, self._tuned.standing_readings))
        if moved or abs(measured - before) > OTHER:
            left = self._tuned.standing_readings
        self._heard[sensor] = measured, max(0, left - 1)
        return left > 0

    def judge(self, spread: Spread) -> None:
        """Decide whether the pose is sure, and if not, whether it is but for where it is along a line."""
        alone = self._unique >= self._tuned.sure_searches
        why = self._doubt(spread.position, spread, alone or self.sure and self.proven)
        self._outdone = self._outdone and bool(why)
        self.on_a_line = bool(why) and not self._outdone and spread.position < self._tuned.longest_line and not (
            self._doubt(_LINE * spread.across, spread, alone or self.proven))
        self.reason = UNKNOWN + why if why else ""
        if self.sure:
            self._upheld = 0

    def _doubt(self, off: float, spread: Spread, alone: bool) -> str:
        """Return why the pose is not sure. Empty if it is.

        Args:
            off: standard deviation of the position (m).
            spread: the spread of the cloud.
            alone: no other place is in question.
        """
        tuned, narrower = self._tuned, 1.0 if self.sure else 0.7
        if not self._placed:
            return self._lost
        if self._blind_way > tuned.blind_way:
            return "nothing that I heard in the last %.1f m told me" % self._blind_way
        if self.doubts or not self.sure and self.explained < tuned.sure_explained * self._usual:
            return UNCONFIRMED if self._unconfirmed else "what I hear does not fit the map here"
        if off > tuned.sure_position * narrower:
            return "I may be %.1f m off" % off
        if spread.heading > tuned.sure_heading * narrower:
            return "my heading may be %.0f degrees off" % np.degrees(spread.heading)
        if not alone:
            return _ALIKE
        heard_enough = self._upheld >= tuned.upheld_searches and self._spots >= tuned.enough_spots
        return "" if self.sure or heard_enough or self._trusted_way >= tuned.sure_way else JUST_FOUND

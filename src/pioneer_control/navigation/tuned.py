"""The numbers of navigation that were tuned by measurement, and what each of them does: one table for each part.

They were tuned with bench/navigation.py on its seeds 1000 to 1999. Each of them becomes a parameter of the node.
"""

from dataclasses import dataclass

from ..parameters import Number, Whole, parameter


@dataclass(frozen=True)
class SensorNumbers:
    """How measured ranges scatter about the ranges that a map lets expect. The shares are of readings with an expected
    range below the longest one; they are scaled to a sum of 1.
    """

    sigma: float = parameter(0.05, Number(0.001, 1.0), "standard deviation of a range at 0 m", "m")
    sigma_per_metre: float = parameter(0.015, Number(0.0, 0.5), "what each metre of range adds to it")
    hit: float = parameter(0.62, Number(0.0, 1.0), "share of readings near the expected range")
    long: float = parameter(0.15, Number(0.0, 1.0), "share of longer readings: a wall slants, one behind it echoes")
    none: float = parameter(0.25, Number(0.0, 1.0), "share without an echo: a wall that slants bounces the sound away")
    short: float = parameter(0.06, Number(0.0, 1.0), "share of shorter readings: people, things that are on no map")
    random: float = parameter(0.03, Number(0.0, 1.0), "share of readings with any range")


SONAR_NUMBERS = SensorNumbers()
"""Sonar of a Pioneer."""
LASER_NUMBERS = SensorNumbers(sigma=0.06, sigma_per_metre=0.02, hit=0.80, long=0.04, none=0.04, short=0.09, random=0.03)
"""A laser. Its standard deviation is mainly that of the table of expected ranges between its nodes and directions."""


@dataclass(frozen=True)
class LocalisationNumbers:
    """Where the robot is."""

    map_bias: float = parameter(
        0.02, Number(-0.2, 0.2), "how much farther walls are than the cells of the map that they cover", "m")
    clearance: float = parameter(0.12, Number(0.0, 1.0), "the middle of the robot is never nearer to a wall", "m")

    particles: int = parameter(300, Whole(50, 20000), "poses in the cloud, while one place is likely")
    particles_searching: int = parameter(1200, Whole(50, 20000), "poses in the cloud, while several places are likely")
    noise_way: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of a way of 1 m by the wheels; it grows with the root of the way",
        "m")
    noise_turn_of_way: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of the heading after a way of 1 m; it grows with the root", "rad")
    noise_turn: float = parameter(
        0.05, Number(0.0, 1.0), "standard deviation of a turn of 1 rad by the wheels; it grows with the root", "rad")

    weight: float = parameter(
        0.2, Number(0.0, 1.0), "share of a reading's log-likelihood that counts: readings of one place err alike")
    laser_weight: float = parameter(0.03, Number(0.0, 1.0), "the same for each ray of a laser")
    full_way: float = parameter(
        0.02, Number(0.001, 1.0), "way between two packets from which on the readings count so; less for less", "m")
    turn_as_way: float = parameter(0.3, Number(0.0, 5.0), "a turn of 1 rad counts as such a way", "m")

    remembered: int = parameter(500, Whole(50, 5000), "readings that a search compares poses with")
    least_readings: int = parameter(60, Whole(1, 5000), "readings in motion that a search needs, half of them echoes")
    poses_per_square_metre: float = parameter(
        150.0, Number(1.0, 10000.0), "random poses that a search begins with, for each square metre of free floor")
    least_poses: int = parameter(4000, Whole(100, 1000000), "it begins with at least so many")
    poses_per_step: int = parameter(4000, Whole(100, 1000000), "poses that a search compares in one update")
    period_sure: float = parameter(6.0, Number(0.1, 1000.0), "time between two searches while the pose is sure", "s")
    period_unsure: float = parameter(1.5, Number(0.1, 1000.0), "time between two searches while it is not", "s")
    margin: float = parameter(
        0.25, Number(0.0, 5.0), "a pose found by a search must explain each reading better than the cloud by this")
    rival_margin: float = parameter(
        0.1, Number(-5.0, 5.0), "to become sure, the pose must explain each reading better than any elsewhere by this")

    sure_position: float = parameter(0.25, Number(0.01, 5.0), "greatest spread of the cloud to be sure", "m")
    sure_heading: float = parameter(0.25, Number(0.01, 3.0), "greatest spread of the headings to be sure", "rad")
    sure_way: float = parameter(
        1.0, Number(0.0, 100.0), "way in motion with readings that the place explains, before it is sure", "m")
    unsure_explained: float = parameter(
        0.6, Number(0.0, 1.0), "unsure when a smaller share of echoes is explained than this share of the usual one")
    sure_explained: float = parameter(
        0.8, Number(0.0, 1.0), "sure again when at least this share of the usual share is explained")
    usual_explained: float = parameter(
        0.8, Number(0.0, 1.0), "the usual share of echoes that the true pose explains, before it is learnt")
    blind_way: float = parameter(2.0, Number(0.1, 100.0), "unsure after such a way without an explained echo", "m")
    explained_readings: int = parameter(60, Whole(5, 1000), "echoes over which the explained share is a mean")

"""What a laser of the kind LMS200 measures in a world (laser sheet part 5, "Model proposed").

A ray is not a line: where it ends, it makes a spot, some centimetres wide. If the spot lies on two surfaces, the laser
may measure a distance between them. And a surface returns only a part of the light, less at a slant, so that dark or
far surfaces are not seen.

Lengths are in metres, angles in radians.
"""

import functools
import random
from dataclasses import dataclass, replace
from typing import Callable, Optional, Tuple, Union

import numpy as np

from ..world import World
from ..world.crowd import Obstacle
from ..world.geometry import Array
from ..world.poses import Heading, Pose, along_arc, unit
from ..world.rays import LightRays, RayCaster
from .ray_plans import RayPlan

PoseAt = Callable[[float], Pose]
"""Returns the pose (m, rad; map frame) of the laser at a simulated time (s).

The laser asks when a scan is complete. So it asks for times in the past, up to four turns of the mirror and some
milliseconds ago.
"""


@dataclass(frozen=True)
class OpticsNumbers:
    """How a laser measures."""

    bias: float
    """Largest constant error (m), to either side. One value is drawn for each run. Sheet part 5: 15 mm for an LMS200
    in millimetres."""
    noise: float
    """Standard deviation (m) of the normal error of each value. Sheet part 5: 5 mm to 8 m."""
    spot: float
    """Diameter (m) of the spot at the laser. Sheet part 5: 12 mm."""
    spot_growth: float
    """Metres by which the diameter of the spot grows per metre. Sheet part 5: 4.4 mrad."""
    rays: int
    """Rays across the spot, odd. Sheet part 5: 3 [inv]."""
    together: float
    """Depth (m) up to which what a spot hits counts as one surface. Sheet part 5: 0.1 [inv]."""
    pulse: float
    """Depth (m) from which two surfaces are told apart: half the length of a light pulse. Sheet part 5: about 1 m."""
    stray: float
    """Share of the mixed values that lie outside of the two surfaces. Sheet part 5: 5 % [inv]."""
    stray_depth: float
    """How far (m) outside they lie at most. Sheet part 5: 0.1 m [inv]."""
    needed_reflectivity: Tuple[Tuple[float, float], ...]
    """Pairs of a distance (m) and the reflectivity (1 is all light) that a surface needs there; between, in proportion.
    Sheet part 5: read off a graph; at 5.5, 7 and 80 m by the sheet's formula."""
    wall_reflectivity: float
    """Reflectivity of all walls and posts; the world knows none. Grey PVC has 50 % (sheet part 5); for walls [inv]."""
    body_reflectivity: float
    """Reflectivity of robots and people [inv]: between black and grey card (sheet part 5: 10 and 20 %)."""
    farthest: float
    """Longest distance (m). Sheet 1.5: to 80 m."""


TYPICAL = OpticsNumbers(
    bias=0.015, noise=0.005, spot=0.012, spot_growth=0.0044, rays=3, together=0.1, pulse=1.0, stray=0.05,
    stray_depth=0.1,
    needed_reflectivity=((4.0, 0.018), (5.5, 0.0285), (7.0, 0.047), (10.0, 0.1), (14.0, 0.2), (21.0, 0.5), (27.0, 0.8),
                         (30.0, 1.0), (80.0, 7.9)),
    wall_reflectivity=0.5, body_reflectivity=0.15, farthest=80.0)
"""An LMS200."""
PERFECT = replace(TYPICAL, bias=0.0, noise=0.0, spot=0.0, spot_growth=0.0, rays=1,
                  needed_reflectivity=((0.0, 0.0),))
"""A laser without errors: each ray is a line, and sees everything up to 80 m. Only the unit of a telegram rounds."""


class Optics:
    """The mirror and the receiver of one laser.

    Args:
        world: world in which the laser stands.
        numbers: how it measures.
        seed: seed of its errors. Equal seeds give equal values in equal scenes.
        carrier: body that carries the laser. The laser does not see it.
        upside_down: whether the laser is mounted upside down. Then its first ray is the leftmost (sheet part 2).

    Attributes:
        numbers: as the argument.
        bias: constant error (m) of this laser.
    """

    def __init__(
        self, world: World, numbers: OpticsNumbers = TYPICAL, seed: Union[int, str] = 0,
        carrier: Optional[Obstacle] = None, upside_down: bool = False,
    ):
        self.numbers = numbers
        chance = random.Random("laser %s" % seed)
        self.bias = chance.uniform(-numbers.bias, numbers.bias)
        self._chance = np.random.RandomState(chance.getrandbits(32))
        self._caster = RayCaster(world, numbers.farthest)
        self._carrier = carrier
        self._side = -1.0 if upside_down else 1.0
        self._heading = Heading()
        middle = (numbers.rays - 1) / 2.0
        self._across = [(ray - middle) / max(middle, 1.0) for ray in range(numbers.rays)]   # -1 .. 1: over the spot

    def measure(self, plan: RayPlan, begin: float, pose_at: PoseAt) -> Array:
        """Return the measured distance (m) of each ray of a scan, an array. It is infinite where no echo came back.

        Each ray begins where the laser was when the ray was fired. Other bodies are where they are now.

        Args:
            plan: the rays.
            begin: simulated time (s) at which the scan's first turn began.
            pose_at: returns the pose of the laser at a time.
        """
        numbers, count = self.numbers, len(plan.angles)
        ends = self._caster.cast(self._rays(plan, begin, pose_at), self._carrier)
        reflectivity = np.where(ends.on_body, numbers.body_reflectivity, numbers.wall_reflectivity)
        shape = count, numbers.rays
        # The numbers drawn do not depend on the scene: a change in one place changes no error in another place.
        # Twelve uniform numbers make a normal one, without a logarithm, which libraries round as they like.
        noise = self._chance.random_sample((12, count)).sum(axis=0) - 6.0
        draws = self._chance.random_sample((3, count))
        distances = self._echoes(ends.distance.reshape(shape), (reflectivity * ends.cosine).reshape(shape), draws)
        distances = np.where(distances < numbers.farthest, distances, np.inf)
        return np.maximum(distances + self.bias + noise * numbers.noise, 0.0)

    def _rays(self, plan: RayPlan, begin: float, pose_at: PoseAt) -> LightRays:
        """Return all rays across all spots, those of one spot together."""
        poses = [pose_at(begin + after) for after in plan.after]
        x, y, forward_x, forward_y = np.array([(*pose[:2], *self._heading.unit(pose[2])) for pose in poses]).T
        to_x, to_y = _units(plan, self._side)
        to_x, to_y = forward_x * to_x - forward_y * to_y, forward_x * to_y + forward_y * to_x
        aside = np.array(self._across) * (self.numbers.spot / 2.0)
        turned_x, turned_y = np.array([unit(share * self.numbers.spot_growth / 2.0) for share in self._across]).T
        to_x, to_y, x, y = to_x[:, None], to_y[:, None], x[:, None], y[:, None]
        return LightRays((x - to_y * aside).ravel(), (y + to_x * aside).ravel(),
                         (to_x * turned_x - to_y * turned_y).ravel(), (to_x * turned_y + to_y * turned_x).ravel())

    def _echoes(self, distances: Array, lights: Array, draws: Array) -> Array:
        """Return the distance (m) that each spot gives, without bias and noise; infinite without an echo.

        Args:
            distances: distance of each ray of each spot, array (spots, rays).
            lights: share of its light that each ray returns, an array of the same shape.
            draws: three random numbers (0..1) for each spot.
        """
        numbers = self.numbers
        front = distances.min(axis=1)
        in_front = distances <= (front + numbers.together)[:, None]
        front_light = np.where(in_front, lights, 0.0).sum(axis=1) / numbers.rays
        back = np.where(in_front, np.inf, distances).min(axis=1)
        back_light = np.where(in_front, 0.0, lights).sum(axis=1) / numbers.rays
        all_light = front_light + back_light
        gap = np.where(np.isfinite(back), back, front) - np.where(np.isfinite(front), front, 0.0)
        share, is_stray, outside = draws
        outside = (1.0 - 2.0 * outside) * numbers.stray_depth       # negative: before the front
        stray = np.where(outside < 0.0, front, front + gap) + outside
        mixed = np.where(is_stray < numbers.stray, stray, front + share * gap)
        apart = np.where(self._seen(front_light, front), front, np.where(self._seen(back_light, back), back, np.inf))
        found: Array = np.select(
            [in_front.all(axis=1), np.isinf(back), gap < numbers.pulse],
            [np.where(self._seen(all_light, front), distances.mean(axis=1), np.inf),
             np.where(self._seen(front_light, front), front, np.inf),
             np.where(self._seen(all_light, front), mixed, np.inf)],
            apart)
        return found

    def _seen(self, light: Array, distance: Array) -> Array:
        """Return whether surfaces at some distances (m) return enough light."""
        return light >= np.interp(distance, *zip(*self.numbers.needed_reflectivity))


@functools.lru_cache(maxsize=None)
def _units(plan: RayPlan, side: float) -> Tuple[Array, Array]:
    """Return x and y of the unit vector of each ray (frame of the laser). `side` is -1 for a laser upside down."""
    x, y = np.array([unit(side * angle) for angle in plan.angles]).T
    return x, y


def standing(pose: Pose) -> PoseAt:
    """Return the function `PoseAt` of a laser that stands still at `pose` (m, rad; map frame)."""
    return lambda seconds: pose


def moving(begin: Pose, linear: float, angular: float) -> PoseAt:
    """Return the function `PoseAt` of a laser that begins at a pose at time 0, and drives an arc for ever.

    Args:
        begin: pose at time 0 (m, rad; map frame).
        linear: speed (m/s).
        angular: turn rate (rad/s), positive to the left.
    """
    return lambda seconds: along_arc(begin, linear * seconds, angular * seconds)

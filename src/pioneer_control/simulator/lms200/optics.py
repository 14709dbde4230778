"""What a laser of the kind LMS200 measures in a world (laser sheet part 5, "Model proposed").

A ray is not a line: where it ends, it makes a spot, some centimetres wide. If the spot lies on two surfaces, the laser
may measure a distance between them. And a surface returns only a part of the light, less at a slant, so that dark or
far surfaces are not seen. Through glass, and in mirrors, it sees what is behind or before them.

Lengths are in metres, angles in radians.
"""

import functools
import math
import random
from dataclasses import replace
from typing import Callable, NamedTuple, Optional, Tuple, Union

import numpy as np

from ..hardware import LaserNumbers, standard_numbers
from ..world import World
from ..world.crowd import Obstacle
from ..world.geometry import Array
from ..world.materials import Material
from ..world.poses import Pose, along_arc, unit, units
from ..world.rays import LightRays, RayCaster, RayEnds
from .ray_plans import RayPlan

PoseAt = Callable[[float], Pose]
"""Returns the pose (m, rad; map frame) of the laser at a simulated time (s).

The laser asks when a scan is complete. So it asks for times in the past, up to four turns of the mirror and some
milliseconds ago.
"""


TYPICAL = standard_numbers().laser
"""An LMS200, as ``robot.yaml`` has it."""
PERFECT = replace(TYPICAL, bias=0.0, noise=0.0, spot=0.0, spot_growth=0.0, rays=1, dazzle_share=0.0,
                  needed_reflectivity=((0.0, 0.0), (1.0, 0.0)))
"""A laser without errors: each ray is a line, and sees everything up to 80 m. Only the unit of a telegram rounds."""

MOST_LEGS = 6
"""How often a ray goes through glass, or is reflected, before it is lost."""
KNOT = 0.007
"""Longest time (s) between two poses of the laser that are asked for: half a turn of its mirror."""
LEAVE = 1e-6
"""Distance (m) that a ray goes on from a pane or a mirror, so that it does not meet the same one again."""


class Measured(NamedTuple):
    """The values of a scan, one for each ray. All are arrays.

    Attributes:
        distances: in metres; infinite where no echo came back.
        reflectors: whether the value is of a retro-reflector.
        dazzled: whether other light hid the echo. Then the distance means nothing.
    """

    distances: Array
    reflectors: Array
    dazzled: Array


class _Spots(NamedTuple):
    """What the rays of all spots have met, by spot and ray. All are arrays (spots, rays).

    Attributes:
        distances: in metres, along the whole way.
        lights: share of its light that each ray returns.
        materials: see `Material`.
    """

    distances: Array
    lights: Array
    materials: Array


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
        self, world: World, numbers: LaserNumbers = TYPICAL, seed: Union[int, str] = 0,
        carrier: Optional[Obstacle] = None, upside_down: bool = False,
    ):
        self.numbers = numbers
        chance = random.Random("laser %s" % seed)
        self.bias = chance.uniform(-numbers.bias, numbers.bias)
        self._chance = np.random.RandomState(chance.getrandbits(32))
        self._caster = RayCaster(world, numbers.farthest)
        self._carrier = carrier
        self._side = -1.0 if upside_down else 1.0
        middle = (numbers.rays - 1) / 2.0
        n = numbers
        self._reflectivity = np.array([     # by `Material`
            n.wall_reflectivity, n.dark_reflectivity, n.glass_reflectivity, 0.0, n.reflector_reflectivity,
            n.body_reflectivity, n.body_reflectivity, n.body_reflectivity])
        self._square = unit(math.radians(numbers.glass_angle_deg))[0]
        self._across = [(ray - middle) / max(middle, 1.0) for ray in range(numbers.rays)]   # -1 .. 1: over the spot

    def measure(self, plan: RayPlan, begin: float, pose_at: PoseAt) -> Measured:
        """Return what the laser measures in a scan.

        Each ray begins where the laser was when the ray was fired. Other bodies are where they are now.

        Args:
            plan: the rays.
            begin: simulated time (s) at which the scan's first turn began.
            pose_at: returns the pose of the laser at a time.
        """
        numbers, count = self.numbers, len(plan.angles)
        spots = self._seen_by(self._rays(plan, begin, pose_at), (count, numbers.rays))
        # The numbers drawn do not depend on the scene: a change in one place changes no error in another place.
        # Twelve uniform numbers make a normal one, without a logarithm, which libraries round as they like.
        noise = self._chance.random_sample((12, count)).sum(axis=0) - 6.0
        *draws, is_dazzled = self._chance.random_sample((4, count))
        distances = self._echoes(spots.distances, spots.lights, draws)
        distances = np.where(distances < numbers.farthest, distances, np.inf)
        middle = slice(numbers.rays // 2, numbers.rays // 2 + 1)
        lamps = (spots.materials[:, middle] == Material.LASER) & (spots.distances[:, middle] < numbers.dazzle_distance)
        return Measured(
            np.maximum(distances + self.bias + noise * numbers.noise, 0.0),
            (spots.materials == Material.REFLECTOR).any(axis=1) & np.isfinite(distances),
            lamps[:, 0] & (is_dazzled < numbers.dazzle_share))

    def _seen_by(self, rays: LightRays, shape: Tuple[int, int]) -> _Spots:
        """Return what rays meet at last, through glass and over mirrors. `shape` is that of the result."""
        ends = self._caster.cast(rays, self._carrier)
        distances, materials = ends.distance.copy(), ends.material.copy()
        lights = self._reflectivity[materials] * np.abs(_slants(rays, ends))
        which = np.arange(len(distances))       # the rays that are under way
        for _ in range(MOST_LEGS):
            squarely = np.abs(_slants(rays, ends)) >= self._square
            is_pane_seen = squarely & self._enough(lights[which], distances[which])
            goes_on = (ends.material == Material.MIRROR) | (ends.material == Material.GLASS) & ~is_pane_seen
            on = np.flatnonzero(goes_on)
            if not len(on):
                return _Spots(distances.reshape(shape), lights.reshape(shape), materials.reshape(shape))
            rays, which = _onward(rays.some(on), RayEnds(*(column[on] for column in ends))), which[on]
            ends = self._caster.cast(rays)
            distances[which] += LEAVE + ends.distance
            materials[which] = ends.material
            lights[which] = self._reflectivity[ends.material] * np.abs(_slants(rays, ends))
        distances[which] = np.inf
        return _Spots(distances.reshape(shape), lights.reshape(shape), materials.reshape(shape))

    def _rays(self, plan: RayPlan, begin: float, pose_at: PoseAt) -> LightRays:
        """Return all rays across all spots, those of one spot together."""
        x, y, forward_x, forward_y = self._places(plan, begin, pose_at)
        to_x, to_y = _units(plan, self._side)
        to_x, to_y = forward_x * to_x - forward_y * to_y, forward_x * to_y + forward_y * to_x
        aside = np.array(self._across) * (self.numbers.spot / 2.0)
        turned_x, turned_y = np.array([unit(share * self.numbers.spot_growth / 2.0) for share in self._across]).T
        to_x, to_y, x, y = to_x[:, None], to_y[:, None], x[:, None], y[:, None]
        return LightRays((x - to_y * aside).ravel(), (y + to_x * aside).ravel(),
                         (to_x * turned_x - to_y * turned_y).ravel(), (to_x * turned_y + to_y * turned_x).ravel())

    def _places(self, plan: RayPlan, begin: float, pose_at: PoseAt) -> Tuple[Array, Array, Array, Array]:
        """Return x and y of the laser when each ray was fired, and the unit vector of its heading.

        Few poses are asked for. Between them the laser drives straight and turns evenly: at 1 m/s and 100 deg/s that is
        wrong by less than 0.01 mm.
        """
        after = np.array(plan.after)
        first, last = float(after.min()), float(after.max())
        if not self.numbers.skew:
            first, after = last, np.full(len(after), last)
        legs = math.ceil((last - first) / KNOT) or 1
        lasts = (last - first) / legs or 1.0
        poses = np.array([pose_at(begin + first + lasts * leg) for leg in range(legs + 1)]).T
        leg = np.minimum((after - first) / lasts, legs - 1).astype(int)
        x, y, heading = poses[:, leg] + ((after - first) / lasts - leg) * (poses[:, leg + 1] - poses[:, leg])
        return (x, y, *units(heading))

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
        apart = np.where(self._enough(back_light, back), back, np.inf)
        apart = np.where(self._enough(front_light, front), front, apart)
        found: Array = np.select(
            [in_front.all(axis=1), np.isinf(back), gap < numbers.pulse],
            [np.where(self._enough(all_light, front), distances.mean(axis=1), np.inf),
             np.where(self._enough(front_light, front), front, np.inf),
             np.where(self._enough(all_light, front), mixed, np.inf)],
            apart)
        return found

    def _enough(self, light: Array, distance: Array) -> Array:
        """Return whether surfaces at some distances (m) return enough light."""
        return light >= np.interp(distance, *zip(*self.numbers.needed_reflectivity))


def _slants(rays: LightRays, ends: RayEnds) -> Array:
    """Return the cosine of the angle between each ray and the normal of the surface that it meets; of either sign."""
    slants: Array = rays.to_x * ends.normal_x + rays.to_y * ends.normal_y
    return slants


def _onward(rays: LightRays, ends: RayEnds) -> LightRays:
    """Return rays as they go on from where they end: reflected by mirrors, straight on through anything else."""
    across = np.where(ends.material == Material.MIRROR, 2.0 * _slants(rays, ends), 0.0)
    to_x, to_y = rays.to_x - across * ends.normal_x, rays.to_y - across * ends.normal_y
    return LightRays(rays.x + rays.to_x * ends.distance + to_x * LEAVE,
                     rays.y + rays.to_y * ends.distance + to_y * LEAVE, to_x, to_y)


@functools.lru_cache(maxsize=64)
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

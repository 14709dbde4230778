"""A room, a robot and what it hears, for the tests of driving: small worlds made by hand."""

import math

import numpy as np

from pioneer_control.floor_poses import Pose, compose
from pioneer_control.maps.grid_map import FREE, OCCUPIED, GridMap
from pioneer_control.navigation.chassis import Chassis
from pioneer_control.navigation.values import Firing, Sensing
from pioneer_control.robots import find_model


def room(rows=80, columns=120, resolution=0.05):
    """Return the map of an empty room of 6 x 4 m, walled in."""
    cells = np.full((rows, columns), FREE, dtype=np.int8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return GridMap(cells, resolution, (0.0, 0.0))


def chassis_of(subtype="p3dx-sh", rear=True):
    """Return a robot as navigation knows it."""
    model = find_model(subtype).with_arrays(front=True, rear=rear)
    return Chassis(model.sonar, model.outline(False), 0.4, 1.6)


def firings(chassis, pose, time, posts=(), walls=None):
    """Return what all transducers of a robot hear at a pose: posts (x, y), and the walls of a map if given."""
    eyes = [compose(pose, Pose(each.x, each.y, each.heading)) for each in chassis.transducers]
    heard = [math.inf] * len(eyes)
    if walls is not None:
        along = np.arange(0.1, 5.0, 0.025)
        x, y, heading = (column[:, np.newaxis] for column in np.array(eyes).T)
        solid = walls.at(x + along * np.cos(heading), y + along * np.sin(heading)) != FREE
        heard = [along[row.argmax()] if row.any() else math.inf for row in solid]
    for number, eye in enumerate(eyes):
        for x, y in posts:
            off = math.remainder(math.atan2(y - eye.y, x - eye.x) - eye.heading, 2 * math.pi)
            if abs(off) < math.radians(12.5):
                heard[number] = min(heard[number], math.hypot(x - eye.x, y - eye.y))
    return tuple(Firing(each.number, float(near), time) for each, near in zip(chassis.transducers, heard))


def sensing_at(chassis, pose, time, posts=(), walls=None):
    """Return what a robot senses whose odometry is right."""
    return Sensing(time, pose, firings(chassis, pose, time, posts, walls))

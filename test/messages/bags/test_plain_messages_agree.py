"""The plain messages of a computer without ROS have the values that genpy's have, for every message of this package."""

import io
import random

import genpy
import pytest
import roslib.message
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import BatteryState, LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

import pioneer_control.msg
from pioneer_control.bags.plain_messages import NUMBERS, plain_class

OWN = [each for each in vars(pioneer_control.msg).values() if isinstance(each, type)]
OTHERS = [Twist, PoseArray, OccupancyGrid, Odometry, Path, Log, BatteryState, LaserScan, PointCloud2, TFMessage]


def value_of(kind, luck, depth=0):
    """Return a random value of a type, as genpy wants it."""
    base, bracket, length = kind.partition("[")
    if bracket:
        count = int(length[:-1]) if length != "]" else luck.randrange(4)
        if base in ("uint8", "char"):
            return bytes(luck.randrange(256) for _ in range(count))
        return [value_of(base, luck, depth) for _ in range(count)]
    if base in ("float32", "float64"):
        return luck.choice([0.0, -1.5, 2.25, float("inf")])
    if base == "bool":
        return luck.random() < 0.5
    if base in NUMBERS:
        return luck.randrange(128)
    if base == "string":
        return luck.choice(["", "a", "\u00e9 b"])
    if base == "time":
        return genpy.Time(luck.randrange(1 << 31), luck.randrange(10 ** 9))
    if base == "duration":
        return genpy.Duration(luck.randrange(1 << 30), luck.randrange(10 ** 9))
    return filled(roslib.message.get_message_class("std_msgs/Header" if base == "Header" else base), luck)


def filled(kind, luck):
    return kind(*(value_of(each, luck) for each in kind._slot_types))


def same(ours, theirs):
    """Return whether a plain value is a value of genpy."""
    if hasattr(theirs, "nsecs"):
        return (ours.secs, ours.nsecs) == (theirs.secs, theirs.nsecs) and ours.to_sec() == theirs.to_sec()
    if hasattr(theirs, "_slot_types"):
        return all(same(getattr(ours, name), getattr(theirs, name)) for name in theirs.__slots__)
    if isinstance(theirs, (list, tuple)):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    return type(ours) is type(theirs) and ours == theirs


@pytest.mark.parametrize("kind", OWN + OTHERS, ids=lambda kind: kind._type)
def test_a_plain_message_is_what_genpy_makes(kind):
    plain, luck = plain_class(kind._type, kind._full_text), random.Random(kind._type)
    for _ in range(5):
        buffer = io.BytesIO()
        filled(kind, luck).serialize(buffer)
        theirs = kind()
        theirs.deserialize(buffer.getvalue())
        assert same(plain().deserialize(buffer.getvalue()), theirs)
    constants = {name: value for name, value in vars(kind).items() if name.isupper() and not name.startswith("_")}
    assert {name: getattr(plain, name) for name in constants} == constants

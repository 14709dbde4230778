"""Turns the messages of a robot's topics into what the page shows: live from a ROS graph, and from a bag.

Pure: it needs no ROS, only objects with the fields of the messages, and the time (s) at which each came. `RobotPicture`
takes the messages of one robot, `WorldPicture` those that all share. TOPICS and SHARED say which.
"""

import base64
import math
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Tuple

from ..message_values import NO_ECHO, NOT_HEARD, GripStatus, LiftStatus, heading_of
from .backend import SONAR_LIVES, Pose, robot_entry
from .frames import FrameFlags, GripperBits, RobotFrame
from .navigation_picture import NavigationPicture

USUAL_OUTLINE = ((0.22, -0.2), (0.22, 0.2), (-0.22, 0.2), (-0.22, -0.2))
"""The outline (m) of a robot whose own is not known, about that of a Pioneer 3."""
LEVELS = {0: "ok", 1: "warn", 2: "error", 3: "ok"}
"""The levels of diagnostic_msgs for the page. STALE is no fault of its own: the link has one then."""
LOG_LEVELS = {4: "warn", 8: "error", 16: "error"}
"""The levels of rosgraph_msgs/Log that the page shows."""
DECISION_LIVES = 1.5
"""Time (s) after which a decision is shown no more: the program that decides does so about ten times a second."""
MAP_FREE, MAP_OCCUPIED, MAP_UNKNOWN = 0, 1, 2
GOAL = "move_base_simple/goal"
"""The topic on which RViz, and whoever else, tells a robot where to drive."""
TRUTH = "truth"
"""The last part of the namespace, and of the frame, in which a simulator hides the truth from navigation."""
CELLS_A_SECOND = 100000
"""Of a map that is being made, so many cells a second are shown on average."""
NEW_ORIGIN = 0.005, 0.005
"""m, rad: a correction of the place in the map that moves a robot less is not told."""


class Happening(NamedTuple):
    """Something that happened, for the log of the page and the marks of a recording."""

    kind: str
    """"fault", "decision" or "event"."""
    level: str
    """"info", "warn" or "error"."""
    text: str


class Diagnosed(NamedTuple):
    """One status of a DiagnosticArray: the namespace of its node, the task, the level, and the text."""

    namespace: str
    task: str
    level: int
    text: str


class ShownTopic(NamedTuple):
    """One row of a table of topics: the last part of the message type, and the method that takes its messages."""

    type: str
    take: Callable[[Any, Any, float], None]


class Decided(NamedTuple):
    """The newest decision of a program: its time (s), which wander of the program it belongs to, and its text."""

    time: float
    wander: int
    told: Dict[str, str]


class RobotPicture:
    """What is known of one robot: from the messages of its topics to a frame, and to the texts of the page.

    Args:
        number: the number of the robot for the page.
        namespace: its namespace, without slashes at its ends.

    Attributes:
        pose_at: time of the newest pose (s); -infinity before the first.
        odom_frame: the frame of its poses.
        origin: where its odometry began in the map, by its true pose; None where nobody tells that.
        simulated: whether its true pose is told.
        happened: what has happened since somebody emptied this list.
        navigation: what its navigation tells.
    """

    def __init__(self, number: int, namespace: str) -> None:
        self.number, self.namespace = number, namespace
        self.navigation = NavigationPicture(number)
        self.pose_at = -math.inf
        self.odom_frame = ""
        self.origin: Optional[Pose] = None
        self.simulated = False
        self.happened: List[Happening] = []
        self._pose: Pose = (0.0, 0.0, 0.0)
        self._speed = (0.0, 0.0)
        self._flags: Dict[FrameFlags, bool] = {}
        self._gripper = 0
        self._sonar: Tuple[Optional[float], ...] = ()
        self._sonar_at = -math.inf
        self._info: Any = None
        self._battery: Dict[str, Any] = {}
        self._faults: Dict[str, Dict[str, str]] = {}
        self._battery_level = "ok"
        self._decision = Decided(-math.inf, -1, {})
        self._helm: Any = None

    # What it shows

    @property
    def name(self) -> str:
        """The name of the robot for people: its namespace, or what the robot calls itself."""
        return self.namespace or getattr(self._info, "name", "") or "robot"

    def entry(self, where: str) -> Dict[str, Any]:
        """Return the entry of the robot in the text ``robots``."""
        info = self._info
        entry = robot_entry(
            self.number, self.name, where, self.simulated, outline=[list(corner) for corner in USUAL_OUTLINE],
            gripper=bool(self._gripper), max_linear=0.5, max_angular=1.745)
        if info is not None:
            sonar: List[Optional[List[float]]] = [None] * (max(info.sonar_numbers, default=-1) + 1)
            for number, pose in zip(info.sonar_numbers, info.sonar_poses):
                if 0 <= number < len(sonar):
                    sonar[number] = [_short(value) for value in (pose.x, pose.y, pose.theta)]
            outline = [[_short(point.x), _short(point.y)] for point in info.footprint.points]
            entry.update(model=info.subtype, gripper=bool(info.has_gripper), sonar=sonar,
                         max_linear=_short(info.max_linear), max_angular=_short(info.max_angular),
                         outline=outline or entry["outline"])
        return entry

    def frame(self, stamp: int, now: float) -> RobotFrame:
        """Return the frame of the newest pose. ``stamp``: see frames.stamp_of(); ``now``: the present time (s)."""
        flags = FrameFlags.LINK
        for flag, is_set in self._flags.items():
            if is_set:
                flags |= flag
        has_sonar = now - self._sonar_at < SONAR_LIVES
        return RobotFrame(self.number, stamp, now - self.pose_at, *self._pose, *self._speed,
                          int(flags | FrameFlags.SONAR if has_sonar else flags), self._gripper,
                          self._sonar if has_sonar else tuple(None for _ in self._sonar))

    def status(self, now: float, link: str = "ok", lost: str = "", rate: float = 0.0) -> Dict[str, Any]:
        """Return the text ``status``.

        Args:
            now: the present time (s).
            link: "ok", or what there is instead.
            lost: why there is no link, in words.
            rate: poses in a second.
        """
        return {
            "robot": self.number, "link": link, **({"lost": lost} if lost else {}),
            "battery": dict(self._battery, level=self._battery_level) if self._battery else None,
            "faults": list(self._faults.values()),
            "decision": self._decision.told if now - self._decision.time < DECISION_LIVES else None,
            "counts": {"sips_per_second": round(rate, 1), "bad_checksums": 0, "reconnects": 0}}

    @property
    def helm(self) -> Any:
        """The newest message on the topic helm; None when the driver tells nothing."""
        return self._helm

    def placed(self, origin: Pose) -> Pose:
        """Return its pose in the map, if its odometry begins at this pose."""
        x, y, heading = self._pose
        cosine, sine = math.cos(origin[2]), math.sin(origin[2])
        return origin[0] + cosine * x - sine * y, origin[1] + sine * x + cosine * y, origin[2] + heading

    # What it takes

    def take(self, name: str, message: Any, now: float) -> None:
        """Take a message of the topic ``name`` (a key of TOPICS). Raises ValueError for numbers that make no sense."""
        TOPICS[name].take(self, message, now)

    def _take_navigation(self, message: Any, now: float) -> None:
        self.navigation.take_state(message, now)
        for text in self.navigation.news:
            self._happen("event", "info", text)
        self.navigation.news.clear()

    def take_diagnostics(self, task: str, level: int, text: str) -> None:
        """Take one task of the robot's diagnostics."""
        worth = LEVELS.get(level, "error")
        if task == "Battery":
            self._battery_level = worth
        before = self._faults.pop(task, None)
        if worth != "ok":
            self._faults[task] = {"level": worth, "task": task, "text": text}
            if before is None or before["level"] != worth:
                self._happen("fault", worth, "%s: %s" % (task, text))

    def take_log(self, level: int, text: str) -> None:
        """Take what a node of this robot logged."""
        if level in LOG_LEVELS:
            self._happen("fault", LOG_LEVELS[level], text)

    def _take_pose(self, message: Any, now: float) -> None:
        position, turn = message.pose.pose.position, message.pose.pose.orientation
        pose = position.x, position.y, heading_of(turn.x, turn.y, turn.z, turn.w)
        speed = message.twist.twist.linear.x, message.twist.twist.angular.z
        if not all(map(math.isfinite, (*pose, *speed))):
            raise ValueError("a pose of %s is not finite: %r, %r" % (self.name, pose, speed))
        self._pose, self._speed, self.pose_at = pose, speed, now
        self.odom_frame = message.header.frame_id.strip("/")

    def _take_truth(self, message: Any, now: float) -> None:
        self.simulated = True
        if self.origin is None and self.odom_frame and _last(message.header.frame_id) != TRUTH:
            place, turn = message.pose.pose.position, message.pose.pose.orientation
            x, y, heading = self._pose
            turned = heading_of(turn.x, turn.y, turn.z, turn.w) - heading
            cosine, sine = math.cos(turned), math.sin(turned)
            self.origin = place.x - cosine * x + sine * y, place.y - sine * x - cosine * y, turned

    def _take_sonar(self, message: Any, now: float) -> None:
        self._sonar_at = now
        self._sonar = tuple([None if value == NOT_HEARD or not value > 0 else math.inf if value >= NO_ECHO else value
                             for value in message.ranges])

    def _take_motors(self, message: Any, now: float) -> None:
        self._switch(FrameFlags.MOTORS, message.state == 1, "motors on", "motors off")

    def _take_stop_button(self, message: Any, now: float) -> None:
        self._switch(FrameFlags.STOP_BUTTON, message.data, "STOP button pressed", "STOP button released")

    def _take_stall(self, message: Any, now: float) -> None:
        self._switch(FrameFlags.LEFT_STALL, message.left, "the left wheel is stalled")
        self._switch(FrameFlags.RIGHT_STALL, message.right, "the right wheel is stalled")

    def _take_bumpers(self, message: Any, now: float) -> None:
        self._switch(FrameFlags.FRONT_BUMPER, any(message.front), "a front bumper is pressed")
        self._switch(FrameFlags.REAR_BUMPER, any(message.rear), "a rear bumper is pressed")

    def _take_gripper(self, message: Any, now: float) -> None:
        grip, lift, bits = message.grip, message.lift, GripperBits
        holds = (grip.inner_beam or grip.outer_beam) and grip.state in (GripStatus.CLOSED, GripStatus.BETWEEN)
        had = bool(self._gripper & bits.HOLDS)
        if self._gripper and holds != had:
            self._happen("event", "info", "picked up" if holds else "put down")
        found = bits.FITTED
        for bit, is_set in (
                (bits.PADDLES_OPEN, grip.state == GripStatus.OPEN),
                (bits.PADDLES_CLOSED, grip.state == GripStatus.CLOSED),
                (bits.PADDLES_MOVING, grip.state == GripStatus.MOVING),
                (bits.LIFT_UP, lift.position > 0.5), (bits.LIFT_DOWN, lift.position <= 0.5),
                (bits.LIFT_MOVING, lift.state == LiftStatus.MOVING), (bits.HOLDS, holds)):
            if is_set:
                found |= bit
        self._gripper = int(found)

    def _take_battery_state(self, message: Any, now: float) -> None:
        self._battery = {"volts": round(message.voltage, 1), "charge": self._battery.get("charge")}

    def _take_battery(self, message: Any, now: float) -> None:
        charge = message.percentage
        self._battery = {"volts": round(message.voltage, 1), "charge": charge if 0 <= charge <= 1 else None}
        self._switch(FrameFlags.CHARGING, message.power_supply_status == 1, "charging", "no longer charging")

    def _take_decision(self, message: Any, now: float) -> None:
        doing, _, why = message.reason.partition(":")
        told = {"doing": doing.strip(), "why": why.strip()}
        before, self._decision = self._decision, Decided(now, message.wander, told)
        if before.wander != message.wander or before.told["doing"] != told["doing"]:
            self._happen("decision", "info", message.reason)

    def _take_info(self, message: Any, now: float) -> None:
        self._info = message

    def _take_helm(self, message: Any, now: float) -> None:
        before, self._helm = self._helm, message
        self._flags[FrameFlags.LOCKED] = bool(message.locks)
        if before is not None and list(before.locks) != list(message.locks):
            self._happen("event", "warn" if message.locks else "info",
                         "locked: %s" % ", ".join(message.locks) if message.locks else "unlocked")
        if before is not None and before.programs_locked_out != message.programs_locked_out:
            self._happen("event", "info", "a person has the helm" if message.programs_locked_out else
                         "programs may command again")

    def _switch(self, flag: FrameFlags, is_set: bool, on: str, off: str = "") -> None:
        before, self._flags[flag] = self._flags.get(flag), bool(is_set)
        if before is not None and before != bool(is_set) and (is_set or off):
            self._happen("event", "info", on if is_set else off)

    def _happen(self, kind: str, level: str, text: str) -> None:
        self.happened.append(Happening(kind, level, text))


def of_navigation(take: Callable[[NavigationPicture, Any, float], None]) -> Callable[[Any, Any, float], None]:
    """Return the method of a RobotPicture that passes messages on to a method of its NavigationPicture."""
    def passed(robot: RobotPicture, message: Any, now: float) -> None:
        take(robot.navigation, message, now)

    return passed


TOPICS: Dict[str, ShownTopic] = {
    "pose": ShownTopic("Odometry", RobotPicture._take_pose),
    "ground_truth": ShownTopic("Odometry", RobotPicture._take_truth),
    "sonar": ShownTopic("SonarArray", RobotPicture._take_sonar),
    "motor_state": ShownTopic("MotorState", RobotPicture._take_motors),
    "e_stop": ShownTopic("Bool", RobotPicture._take_stop_button),
    "stall": ShownTopic("Stall", RobotPicture._take_stall),
    "bumpers": ShownTopic("Bumpers", RobotPicture._take_bumpers),
    "gripper_state": ShownTopic("GripperState", RobotPicture._take_gripper),
    "battery_state": ShownTopic("BatteryState", RobotPicture._take_battery_state),
    "battery": ShownTopic("BatteryState", RobotPicture._take_battery),
    "decision": ShownTopic("Decision", RobotPicture._take_decision),
    "robot_info": ShownTopic("RobotInfo", RobotPicture._take_info),
    "helm": ShownTopic("Helm", RobotPicture._take_helm),
    GOAL: ShownTopic("PoseStamped", of_navigation(NavigationPicture.take_goal)),
    "navigation": ShownTopic("Navigation", RobotPicture._take_navigation),
    "plan": ShownTopic("Path", of_navigation(NavigationPicture.take_plan)),
    "particlecloud": ShownTopic("PoseArray", of_navigation(NavigationPicture.take_cloud)),
    "places": ShownTopic("Places", of_navigation(NavigationPicture.take_places)),
}
"""The topics of a robot, by the name in its namespace."""
OF_ANYBODY = (GOAL, "plan", "particlecloud")
"""Topics that nodes of other kinds have, too: who has one need not be a robot."""


class WorldPicture:
    """What all robots share: the map, the cans, and where the odometry of each robot begins in the map.

    Args:
        cells_a_second: how many cells of a map that is being made are shown, on average: all of a large map seldom.
    """

    def __init__(self, cells_a_second: float = CELLS_A_SECOND) -> None:
        self.world: Optional[Dict[str, Any]] = None
        """The text ``world``."""
        self.cans: List[List[float]] = []
        """The text ``cans``."""
        self._name = ""
        self._told: Dict[str, Any] = {"world": None, "cans": [], "origins": {}, "goals": {}}
        self._origins: Dict[str, Pose] = {}     # by the odometry frame
        self._told_origins: Dict[int, Pose] = {}
        self._cells_a_second = cells_a_second
        self._map: Any = None                   # the newest map, while it waits to be shown
        self._map_due = -math.inf               # time (s) from which another map may be shown

    def take(self, name: str, message: Any, now: float) -> None:
        """Take a message of the topic ``name`` (a key of SHARED)."""
        SHARED[name].take(self, message, now)
        if self._map is not None and now >= self._map_due:
            newest, self._map = self._map, None
            self._map_due = now + len(newest.data) / self._cells_a_second
            self.world = world_of(newest, self._name)

    def changes(self, robots: Iterable[RobotPicture]) -> List[Tuple[str, Any]]:
        """Return the texts (kind and value) that are others than at the last call: world, cans, origins, goals.
        """
        robots = list(robots)
        texts = {"world": self.world, "cans": self.cans, "origins": self.origins(robots), "goals": self.goals(robots)}
        changed = [(kind, value) for kind, value in texts.items() if value != self._told[kind]]
        self._told.update(changed)
        return changed

    def origins(self, robots: Iterable[RobotPicture]) -> Dict[str, List[float]]:
        """Return the text ``origins``: as tf says it, else by the true pose."""
        told = {}
        for robot in robots:
            origin, before = self._origins.get(robot.odom_frame, robot.origin), self._told_origins.get(robot.number)
            if origin is not None:
                same = before is not None and _is_near(robot.placed(before), robot.placed(origin))
                told[robot.number] = before if before is not None and same else origin
        self._told_origins = told
        return {str(number): [_short(value) for value in origin] for number, origin in told.items()}

    def goals(self, robots: Iterable[RobotPicture]) -> Dict[str, List[float]]:
        """Return the text ``goals``. A goal that was given in the frame of a robot's odometry is turned into the map.
        """
        found: Dict[str, List[float]] = {}
        for robot in robots:
            frame, x, y = robot.navigation.goal or ("", 0.0, 0.0)
            origin = self._origins.get(frame, robot.origin) if frame == robot.odom_frame else None
            east, north, turned = origin or (0.0, 0.0, 0.0)
            cosine, sine = math.cos(turned), math.sin(turned)
            if frame:
                found[str(robot.number)] = [_short(east + cosine * x - sine * y), _short(north + sine * x + cosine * y)]
        return found

    def _take_map(self, message: Any, now: float) -> None:
        self._map = message

    def _take_name(self, message: Any, now: float) -> None:
        self._name = message.data
        if self.world is not None:
            self.world = dict(self.world, name=message.data)

    def _take_cans(self, message: Any, now: float) -> None:
        self.cans = [[round(value, 2) for value in (pose.position.x, pose.position.y, pose.position.z)]
                     for pose in message.poses]

    def _take_tf(self, message: Any, now: float) -> None:
        for each in message.transforms:
            if each.header.frame_id.strip("/").endswith("map"):
                place, turn = each.transform.translation, each.transform.rotation
                self._origins[each.child_frame_id.strip("/")] = (
                    place.x, place.y, heading_of(turn.x, turn.y, turn.z, turn.w))


SHARED: Dict[str, ShownTopic] = {
    "map": ShownTopic("OccupancyGrid", WorldPicture._take_map),
    "world": ShownTopic("String", WorldPicture._take_name),
    "cans": ShownTopic("PoseArray", WorldPicture._take_cans),
    "tf": ShownTopic("TFMessage", WorldPicture._take_tf),
    "tf_static": ShownTopic("TFMessage", WorldPicture._take_tf),
}
"""The topics that robots share, by their last name. They may be in the namespace of one robot."""


def shared_name(topic: str, kind: str) -> str:
    """Return the name in SHARED of a topic with this type; empty if it is none of them, or the hidden truth."""
    namespace, _, name = topic.strip("/").rpartition("/")
    is_shown = name in SHARED and _last(kind) == SHARED[name].type and _last(namespace) != TRUTH
    return name if is_shown else ""


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _is_near(one: Pose, other: Pose) -> bool:
    metres, radians = NEW_ORIGIN
    return (math.hypot(one[0] - other[0], one[1] - other[1]) < metres
            and abs(math.remainder(one[2] - other[2], math.tau)) < radians)


def namespace_of(node: str) -> str:
    """Return the namespace of a node, without slashes at its ends."""
    return node.strip("/").rpartition("/")[0]


def diagnosed(message: Any) -> Iterator[Diagnosed]:
    """Return what a DiagnosticArray says. The name of a status is ``NODE: TASK``."""
    for status in message.status:
        node, _, task = status.name.rpartition(": ")
        level = status.level if isinstance(status.level, int) else status.level[0]     # a byte in Python 3
        yield Diagnosed(namespace_of(node), task, level, status.message)


def world_of(grid: Any, name: str) -> Dict[str, Any]:
    """Return the text ``world`` for a nav_msgs/OccupancyGrid. Raises ValueError when its sizes do not fit."""
    info, cells = grid.info, grid.data
    if len(cells) != info.width * info.height or not info.resolution > 0:
        raise ValueError("a map has %d cells, not %d times %d, of %g m" % (
            len(cells), info.width, info.height, info.resolution))
    turn = info.origin.orientation
    x, y, heading = info.origin.position.x, info.origin.position.y, heading_of(turn.x, turn.y, turn.z, turn.w)
    cosine, sine = math.cos(heading), math.sin(heading)
    wide, high = info.width * info.resolution, info.height * info.resolution
    corners = [(x + cosine * right - sine * up, y + sine * right + cosine * up)
               for right, up in ((0, 0), (wide, 0), (0, high), (wide, high))]
    codes = bytes(MAP_UNKNOWN if cell < 0 else MAP_OCCUPIED if cell >= 50 else MAP_FREE for cell in cells)
    return {
        "name": name,
        "bounds": [_short(edge(corner[axis] for corner in corners)) for edge in (min, max) for axis in (0, 1)],
        "grid": {"resolution": round(info.resolution, 6), "origin": [_short(x), _short(y), _short(heading)],
                 "width": info.width, "height": info.height, "cells": base64.b64encode(codes).decode()}}


def helm_text(number: int, helm: Any, limit: Tuple[float, float], inputs: Mapping[str, str]) -> Dict[str, Any]:
    """Return the text ``helm`` for a message Helm. ``inputs``: "person" or "program" for each input by its name."""
    commander = inputs.get(helm.commander, "program" if helm.commander else "")
    programs = "locked out" if helm.programs_locked_out else "driving" if commander == "program" else "free"
    return {"robot": number, "commander": commander, "who": helm.node.strip("/"), "you": False, "programs": programs,
            "locks": list(helm.locks), "limit": [_short(value) for value in limit]}


def _short(value: float) -> float:
    return round(float(value), 4)

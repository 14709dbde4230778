"""One robot of the client library, as the page shows it and tells it: frames, entry in ``robots``, status, controls."""

import math
import threading
from time import monotonic
from typing import Any, Dict, List, Mapping, Optional, Tuple

from ..client import (NO_ECHO, CommandTimedOut, Event, GripperReading, LinkDown, MotionCleared, MotorsAnswered, Ready,
                      Robot, RobotIdentity, RobotState, SteeredRobot, Tuned, Unmoved)
from ..client.fault_flags import Level
from ..client.health import CHARGING, Finding, Health
from ..client.helm import VelocityInput
from ..client.ports import is_serial
from ..errors import PioneerError, RefusedError
from ..p2os import Flags, GripperCommand
from ..port_url import without_key
from .backend import REPEAT, SONAR_LIVES, VELOCITY_LIVES, Feed, Pose, Stage, StatusPace, robot_entry
from .frames import FrameFlags, GripperBits, RobotFrame, encode_frame, stamp_of
from .orders import NavigationOrder
from .program_line import INPUT as PROGRAM
from .trail import Trail

COMMAND_TIMEOUT = 0.5   # s: the client's own dead man, behind that of the helm
INPUT, LOCK = "page", "stop"
"""The names by which the page is known to the helm: as an input, and as who locks."""
INPUTS = {
    PROGRAM: VelocityInput(10, 0.6),
    INPUT: VelocityInput(100, VELOCITY_LIVES, keeps_helm=True),
}
"""Who may command a robot, for the helm."""
OBSTACLES = {LOCK: "it is locked: unlock it first", INPUT: "a person has the helm"}
COMMANDS = {
    "open": GripperCommand.OPEN, "close": GripperCommand.CLOSE, "up": GripperCommand.LIFT_UP,
    "down": GripperCommand.LIFT_DOWN, "stop": GripperCommand.HALT, "deploy": GripperCommand.DEPLOY,
    "store": GripperCommand.STORE}
"""The robot's commands for orders.GRIPPER_COMMANDS."""
LEVELS = {Level.OK: "ok", Level.WARN: "warn", Level.ERROR: "error", Level.STALE: "ok"}


def frame_of(robot: int, state: RobotState, now: float, link: bool, locked: bool) -> RobotFrame:
    """Return the frame of a state of a robot.

    Args:
        robot: the number of the robot.
        state: its newest state.
        now: the time at which the frame is sent (monotonic, s).
        link: whether the link works.
        locked: whether the helm lets nothing but zero through.
    """
    flags, bits = 0, FrameFlags
    for bit, is_set in (
            (bits.LINK, link), (bits.MOTORS, state.motors_enabled), (bits.STOP_BUTTON, state.stop_button),
            (bits.LEFT_STALL, state.left_stall), (bits.RIGHT_STALL, state.right_stall),
            (bits.FRONT_BUMPER, any(state.front_bumpers)), (bits.REAR_BUMPER, any(state.rear_bumpers)),
            (bits.SONAR, state.sonar_enabled), (bits.LOCKED, locked),
            (bits.CHARGING, state.charge_state in CHARGING or bool(state.flags & Flags.CHARGER_POWER))):
        if is_set:
            flags |= int(bit)
    oldest = now - SONAR_LIVES
    sonar = tuple([None if each is None or each.time < oldest else math.inf if each.range >= NO_ECHO else each.range
                   for each in state.sonar])
    return RobotFrame(robot, stamp_of(now), now - state.time, state.x, state.y, state.heading, state.linear,
                      state.angular, flags, gripper_bits(state.gripper), sonar)


def gripper_bits(gripper: Optional[GripperReading]) -> int:
    """Return the bits of a gripper in a frame; 0 without a gripper."""
    if gripper is None:
        return 0
    bits, found = GripperBits, int(GripperBits.FITTED)
    for bit, is_set in (
            (bits.PADDLES_OPEN, gripper.paddles_open), (bits.PADDLES_CLOSED, gripper.paddles_closed),
            (bits.PADDLES_MOVING, gripper.paddles_moving), (bits.LIFT_UP, gripper.lift_up),
            (bits.LIFT_DOWN, gripper.lift_down), (bits.LIFT_MOVING, gripper.lift_moving),
            (bits.HOLDS, gripper.inner_beam or gripper.outer_beam)):
        if is_set:
            found |= int(bit)
    return found


def entry_of(robot: int, url: str, identity: Optional[RobotIdentity], simulated: bool) -> Dict[str, Any]:
    """Return the entry of a robot in the text ``robots``. Without an identity nobody knows its shape: lists are empty.
    """
    if identity is None:
        return robot_entry(robot, url, url, simulated)
    model = identity.model
    sonar: List[Optional[List[float]]] = [None] * model.sonar_count
    for each in model.sonar:
        sonar[each.number] = [_short(value) for value in each[1:]]
    return robot_entry(
        robot, identity.name or url, url, simulated, model=model.subtype, gripper=identity.has_gripper, sonar=sonar,
        outline=[[_short(x), _short(y)] for x, y in model.outline(identity.has_gripper)],
        max_linear=_short(identity.max_linear), max_angular=_short(identity.max_angular))


def _short(value: float) -> float:
    return round(value, 4)


def status_of(robot: int, findings: Mapping[str, Finding], state: Optional[RobotState], lost: Optional[str],
              counts: Mapping[str, float]) -> Dict[str, Any]:
    """Return the text ``status`` of a robot.

    Args:
        robot: the number of the robot.
        findings: its diagnostics, by task.
        state: its newest state, also of a link that is lost; None before the first.
        lost: why there is no link; None while there is one.
        counts: what ``counts`` says.
    """
    status: Dict[str, Any] = {
        "robot": robot,
        "link": "ok" if lost is None else "looking for the robot",
        "battery": None if state is None else {
            "volts": round(state.battery_voltage, 1), "charge": state.state_of_charge,
            "level": LEVELS[findings["Battery"].level]},
        "faults": [{"level": LEVELS[finding.level], "task": task, "text": finding.message}
                   for task, finding in findings.items() if finding.level in (Level.WARN, Level.ERROR)],
        "decision": None,
        "counts": dict(counts),
    }
    if lost is not None:
        status["lost"] = lost
    return status


def sentence_of(event: Event) -> Optional[Tuple[str, str]]:
    """Return level and text with which the log of the page tells an event; None for an event that it does not tell."""
    if isinstance(event, Ready):
        return "info", "connected: %s, a %s" % (event.identity.name, event.identity.model.subtype)
    if isinstance(event, LinkDown):
        return "error", str(event.error)
    if isinstance(event, MotionCleared):
        return "warn", "the robot switched its motors off: %s" % event.reason
    if isinstance(event, Unmoved):
        return "warn", "told to drive, it has stood for %.0f s" % event.age
    if isinstance(event, CommandTimedOut):
        return "warn", "stopped: no velocity came for %.1f s" % event.age
    return None


class ClientRobot:
    """One robot: it feeds the page, and obeys the seats (it is their Controls).

    Args:
        number: its number for the page.
        url: its port, as Robot takes it.
        feed: takes frames, at once and from any thread.
        stage: told what happens.
        simulated: whether it is a simulated robot.
        options: more arguments for Robot.
    """

    def __init__(self, number: int, url: str, feed: Feed, stage: Stage, simulated: bool = False,
                 **options: Any) -> None:
        self.number, self.url, self.simulated = number, without_key(url), simulated
        self.trail = Trail()
        self.robot = Robot(url, reconnect=True, command_timeout=COMMAND_TIMEOUT, on_state=self._on_state,
                           on_event=self._on_event, **options)
        self.steered = SteeredRobot(self.robot, INPUTS, OBSTACLES, lambda: stage.changed(self))
        self.has_programs = False
        """Whether programs have a line to this robot (see `program_line`)."""
        self.asked: Optional[int] = None
        """The viewer who asked for the motors last."""
        self.base: Pose = (0.0, 0.0, 0.0)
        """The pose at which the present session of the robot began: its own odometry begins anew, the client's goes on.
        """
        self.introduced = False
        """Whether the page has been told the shape of this robot, so that frames of it make sense."""
        self._feed, self._stage = feed, stage
        self._sentence: Optional[Tuple[str, str]] = None    # the last one told
        self._health = Health(self.url, 9600 if is_serial(url) else None, "switch the motors on")
        self._lock = threading.Lock()       # the link's threads and the owner's make frames, one at a time
        self._state: Optional[RobotState] = None
        self._framed_at = -math.inf
        self._lost: Optional[str] = "looking for it at %s" % url
        self._is_new_session = True
        self._pace = StatusPace()

    def start(self) -> None:
        """Begin to look for the robot."""
        self.robot.start()

    def close(self, wait: bool = True) -> None:
        """Stop the robot, switch its motors off, and close the link. See Robot.close()."""
        self.robot.close(wait)

    # What is shown

    @property
    def limits(self) -> Tuple[float, float]:
        """The robot's own limits (m/s, rad/s); 0 before it was there."""
        identity = self.robot.identity
        return (0.0, 0.0) if identity is None else (identity.max_linear, identity.max_angular)

    @property
    def entry(self) -> Dict[str, Any]:
        """The entry of this robot in the text ``robots``."""
        return entry_of(self.number, self.url, self.robot.identity, self.simulated)

    def repeat(self, now: float) -> None:
        """Send the last frame again, with its age, if none was sent for REPEAT s."""
        if now - self._framed_at >= REPEAT:
            self._send_frame(now)

    def status(self, now: float) -> Optional[Dict[str, Any]]:
        """Return the text ``status`` if it is time to tell a new one; else None."""
        if not self._pace.is_due(now):
            return None
        counts, state, lost = self.robot.link, self._state, self._lost
        findings = self._health.report(now, counts)
        rate = findings["Link"].values.get("Packets a second", "")
        status = status_of(self.number, findings, state, lost, {
            "sips_per_second": float(rate) if rate[:1].isdigit() else 0.0,
            "bad_checksums": counts.bad_checksums, "reconnects": counts.reconnects})
        return self._pace.take(status, now, "counts")

    def _on_state(self, state: RobotState) -> None:
        self._health.state(state)
        if self._is_new_session:
            self._is_new_session, self.base = False, (state.x, state.y, state.heading)
        self._state = state
        self.trail.go(state.x, state.y)
        self._send_frame(monotonic())

    def _on_event(self, event: Event) -> None:
        self._health.event(event)
        if isinstance(event, Ready):
            self._lost = None
            self._is_new_session = True
        elif isinstance(event, LinkDown):
            self._lost = str(event.error)
        if isinstance(event, (Ready, Tuned)):
            self._stage.changed(self)
        if isinstance(event, MotorsAnswered) and event.error is not None:
            self._stage.tell(self, "error", str(event.error), None if self.asked is None else [self.asked])
        sentence = sentence_of(event)
        if sentence is not None and sentence != self._sentence:     # a link that stays down says so once
            self._sentence = sentence
            self._stage.tell(self, *sentence)

    def _send_frame(self, now: float) -> None:
        with self._lock:
            state = self._state
            if state is None or not self.introduced or now < self._framed_at:
                return
            self._framed_at = now
            try:
                frame = encode_frame(frame_of(self.number, state, now, self._lost is None, bool(self.locks)))
            except PioneerError as error:   # a pose that no robot has; a listener that raises would end the link
                self._lost = str(error)
                return
            self._feed.frame(frame)

    # Controls

    def drive(self, linear: float, angular: float) -> None:
        """Drive for a time. See Controls.drive()."""
        self.steered.set_velocity(INPUT, linear, angular)

    def stop(self) -> None:
        """End what drive() began, at once."""
        self.robot.stop()

    def lock(self) -> None:
        """Stop, and let nothing but zero through."""
        self.steered.lock(LOCK)
        self._framed_at = -math.inf     # the flag is shown at once

    def unlock(self) -> None:
        """Take the lock away."""
        self.steered.unlock(LOCK)
        self._framed_at = -math.inf

    def motors(self, on: bool) -> None:
        """Ask for motors on or off. The result comes as an event."""
        self.steered.request_motors(on)

    def gripper(self, command: str) -> None:
        """Give the gripper one of orders.GRIPPER_COMMANDS."""
        self.steered.move_gripper(INPUT, [(COMMANDS[command], None)], command == "stop")

    def take(self) -> None:
        """Stop what programs do, and lock them out."""
        self.steered.take(INPUT)

    def release(self) -> None:
        """Let programs command again."""
        self.steered.release()

    def navigate(self, order: NavigationOrder) -> None:
        """Raise RefusedError: navigation is a node of ROS."""
        raise RefusedError("this robot has no navigation here: it runs with ROS, by navigate.launch and web.launch")

    @property
    def locks(self) -> Tuple[str, ...]:
        """Why the robot stands whatever it is told."""
        return self.steered.state().locks

    @property
    def programs(self) -> str:
        """Whether programs may command."""
        if not self.has_programs:
            return "none"
        state = self.steered.state()
        return "driving" if state.commander == PROGRAM else "locked out" if state.holder == INPUT else "free"

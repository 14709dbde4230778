"""What diagnostics say of a robot, by REP 107. Pure: time (monotonic, s) is an argument; `diagnostics` publishes it.

There is one finding for each of six tasks, always the same, so that a program can see that one is missing:

===========  ======================  ==============================================  =========================
task         OK                      WARN                                            ERROR
===========  ======================  ==============================================  =========================
Link         packets come as often   fewer come than the robot sends; damaged        no link, and why
             as the robot sends      packets, stray bytes or several questions
             them                    without an answer in the last seconds
Battery      above the alarm level   below it; below the next, but charging          below the level of
                                                                                     switching itself off
Motors       on, or off              the STOP button is pressed; the robot took      a fault of the drives or
                                     them away; told to drive, it stands; a          of the safety system
                                     lasting fault that leaves them working
Stall        wheels turn freely      a wheel is stalled
Bumpers      free, or none fitted    a segment is pressed
Temperature  as it should be, or     near the level of switching itself off          beyond it, or the robot
             the robot reports none                                                  says it is too hot
===========  ======================  ==============================================  =========================

WARN is what passes when somebody helps, ERROR what keeps the robot from its work or harms it. Without a link all but
Link are STALE, the level of REP 107 for what is not heard of any more: neither an OK nor the alarm of an hour ago would
be true.
"""

from collections import deque
from operator import attrgetter
from typing import Callable, Deque, Dict, List, NamedTuple, Optional, Tuple

from ..client import (BaudFound, CommandTimedOut, Event, LineSpeed, LinkCounts, LinkDown, MotionCleared, Ready,
                      RobotIdentity, RobotState,
                      Unmoved)
from ..client.identity import DEFAULT_SIP_CYCLE
from ..p2os import ChargeState, FaultFlags, Flags
from .fault_flags import FAULTS, Level
from .notices import battery_levels, low_battery, stalled_wheels, stop_button_pressed, unmoved

NOT_YET = "still looking for the robot"
NO_HARDWARE = "none"
"""Id of the hardware as long as no robot has said its name."""
WINDOW = 4.0
"""Time (s) over which packets and damage are counted: a silence of most of a second shows, jitter does not."""
SHORTEST_WINDOW = 1.0   # s: a younger link is not judged
SAMPLING = 0.5          # s between two samples of the counts
RATE_OK = 0.9
"""Share of the packets, and of the answers, that must arrive."""
NO_LIMIT = -128
NEAR_LIMIT = 5.0
"""A temperature (deg C) this close to the limit is a warning."""
CHARGING = {ChargeState.BULK: "bulk", ChargeState.OVERCHARGE: "overcharge", ChargeState.FLOAT: "float",
            ChargeState.BALANCE: "balance"}


class Finding(NamedTuple):
    """What one task found: how bad it is, what a person reads, and named values."""

    level: Level
    message: str
    values: Tuple[Tuple[str, str], ...] = ()


class Problem(NamedTuple):
    """One thing that is wrong, in words that say what to do."""

    level: Level
    text: str


class Recent(NamedTuple):
    """What the line brought within the window."""

    seconds: float
    packets: int
    bad_checksums: int
    stray_bytes: int
    questions: int
    unanswered: int


class Facts(NamedTuple):
    """All that is known at one moment."""

    port: str
    how_to_enable: str
    """the command that switches motors on, as a user would type it"""
    baud: Optional[int] = None
    """line speed; None on TCP"""
    baud_problem: str = ""
    """why it is not the one asked for (host_baud)"""
    no_link: Optional[str] = NOT_YET
    """why there is no link; None while there is one"""
    identity: Optional[RobotIdentity] = None
    state: Optional[RobotState] = None
    """None until the first one of this link"""
    last_stop: Optional[str] = None
    """why the robot last stopped without being told to"""
    motors_gone: bool = False
    """whether the robot took its motors away, and they are not on again"""
    unmoved: float = 0.0
    """s for which it stood although it was told to drive; 0 since it has moved"""
    lost: int = 0
    """packets of this link that did not come when they should have"""
    counts: Optional[LinkCounts] = None
    recent: Optional[Recent] = None
    """None while the link is too young to tell"""


def _finding(problems: List[Problem], otherwise: str, values: List[Tuple[str, str]]) -> Finding:
    """All problems, the worst first; OK and other words where there is none."""
    if not problems:
        return Finding(Level.OK, otherwise, tuple(values))
    problems = sorted(problems, key=lambda problem: -problem.level)
    return Finding(problems[0].level, "; ".join(problem.text for problem in problems), tuple(values))


def _faults(state: RobotState, task: str) -> List[Problem]:
    """What the robot's own fault flags say about a task."""
    flags = state.fault_flags or 0
    return [Problem(fault.level, fault.text) for flag, fault in FAULTS.items() if fault.task == task
            and flags & flag] if flags else []


def _link(facts: Facts) -> Finding:
    values = [("Port", facts.port)]
    if facts.baud is not None:
        values.append(("Baud", "%d (%s)" % (facts.baud, facts.baud_problem) if facts.baud_problem else str(facts.baud)))
    identity, counts, recent = facts.identity, facts.counts, facts.recent
    cycle = DEFAULT_SIP_CYCLE if identity is None else identity.sip_cycle
    if identity is not None:
        values += [
            ("Robot", identity.name), ("Model", identity.subtype), ("Firmware", identity.firmware or "not reported"),
            ("Serial number", identity.serial or "not reported")]
    rate = None if recent is None else recent.packets / recent.seconds
    if facts.no_link is None:
        values += [
            ("Packets a second", "not known yet" if rate is None else "%.1f" % rate),
            ("Packets a second the robot sends", "%.1f" % (1 / cycle)),
            ("Packets of this link that got lost", str(max(0, facts.lost)))]
    if counts is not None:
        unanswered = "%d of %d" % (
            counts.unanswered, counts.questions) if counts.questions else "not known: none was asked, or none answered"
        values += [
            ("Packets", str(counts.sips)), ("Bad checksums", str(counts.bad_checksums)),
            ("Stray bytes", str(counts.discarded_bytes)),
            ("Packets nobody understands", str(counts.unreadable)),
            ("Readings of unknown sonar", str(counts.unknown_sonar)),
            ("Questions without an answer", unanswered), ("Missed by this computer", str(counts.missed)),
            ("Reconnects", str(counts.reconnects)), ("Last error", counts.last_error or "none")]
    problems = []
    if facts.no_link is not None:
        problems.append(Problem(Level.ERROR, "no link: %s" % facts.no_link))
    elif recent is not None:
        # One may be about to come: in a link's first second that is a tenth.
        if recent.packets + 1 < RATE_OK * recent.seconds / cycle:
            text = "only %.1f of %.1f packets a second arrive: check cable, radio and the computer's load"
            problems.append(Problem(Level.WARN, text % (rate, 1 / cycle)))
        if recent.bad_checksums or recent.stray_bytes:
            text = "%d packets with a bad checksum and %d stray bytes within %.0f s: check cable and plugs"
            problems.append(Problem(Level.WARN, text % (recent.bad_checksums, recent.stray_bytes, recent.seconds)))
        if recent.questions - recent.unanswered + 1 < RATE_OK * recent.questions:       # one may always get lost
            text = ("%d of %d questions within %.0f s were not answered in time: what is sent to the robot gets lost, "
                    "or late: check cable and radio")
            problems.append(Problem(Level.WARN, text % (recent.unanswered, recent.questions, recent.seconds)))
    return _finding(problems, "connected" if rate is None else "connected, %.1f packets a second" % rate, values)


def _battery(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    config = robot.config
    voltage, levels = state.battery_voltage, battery_levels(robot)
    charges, charger = _charger(state)
    problems = []
    values = [
        ("Voltage (V)", "%.1f" % voltage), ("Alarm level (V)", "%.1f" % levels.low),
        ("Switches itself off at (V)", "%.1f" % levels.empty),
        ("Charger", charger)]
    if state.state_of_charge is not None:
        percent = state.state_of_charge * 100
        low, empty = (0, 0) if config is None else (config.charge_low_percent or 0, config.charge_shutdown_percent or 0)
        values.append(("State of charge (%)", "%.0f" % percent))
        if percent < max(low, empty):
            problems.append(_running_out("battery low: %.0f %% of its charge is left" % percent, percent < empty,
                                         charges))
    if voltage < levels.empty:
        text = "battery nearly empty: %.1f V, the robot switches itself off at %.1f V" % (voltage, levels.empty)
        problems.append(_running_out(text, True, charges))
    elif voltage < levels.low:
        problems.append(_running_out(low_battery(voltage, levels), False, charges))
    problems += _faults(state, "Battery")
    return _finding(problems, "%.1f V, %s" % (voltage, charger) if charges else "%.1f V" % voltage, values)


def _charger(state: RobotState) -> Tuple[bool, str]:
    """Whether the battery is charged, and how to say it."""
    if state.charge_state in CHARGING:
        return True, "charging (%s)" % CHARGING[ChargeState(state.charge_state)]
    if state.flags & Flags.CHARGER_POWER:
        return True, "on its charger"
    return False, "not charging" if state.charge_state == ChargeState.NOT_CHARGING else "not reported"


def _running_out(text: str, is_empty: bool, charges: bool) -> Problem:
    """A low battery, which is half as bad on the charger."""
    if charges:
        return Problem(Level.WARN, text + "; it is on its charger")
    return Problem(Level.ERROR if is_empty else Level.WARN, text + "; charge it")


def _motors(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    values = [
        ("Motors", "on" if state.motors_enabled else "off"),
        ("STOP button", "pressed" if state.stop_button else "not pressed"),
        ("Stopped by itself last", facts.last_stop or "never")]
    problems = _faults(state, "Motors")
    if state.stop_button:
        problems.append(Problem(Level.WARN, stop_button_pressed(facts.how_to_enable)))
    elif state.flags & Flags.E_STALL:
        problems.append(Problem(Level.WARN,
                                "an emergency stop holds the wheels: release it, then %s" % facts.how_to_enable))
    elif facts.motors_gone:
        text = "the robot took its motors away (STOP or MOTORS button, a fault): see why, then %s"
        problems.append(Problem(Level.WARN, text % facts.how_to_enable))
    if facts.unmoved:
        problems.append(Problem(Level.WARN, unmoved(facts.unmoved)))
    return _finding(problems, "motors are on" if state.motors_enabled else "motors are off; to switch them on: %s"
                    % facts.how_to_enable, values)


def _stall(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    text = stalled_wheels(state)
    values = [("Left wheel", _stalled(state.left_stall)), ("Right wheel", _stalled(state.right_stall))]
    return _finding([Problem(Level.WARN, text)] if text else [], "no wheel is stalled", values)


def _stalled(stall: bool) -> str:
    return "stalled" if stall else "free"


def _bumpers(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    bumpers = (("front", state.front_bumpers), ("rear", state.rear_bumpers))
    problems, values = [], []
    for name, segments in bumpers:
        pressed = [str(number) for number, segment in enumerate(segments, 1) if segment]
        values.append((name.capitalize(),
                       ("pressed: " + ", ".join(pressed) if pressed else "free") if segments else "none fitted"))
        if pressed:
            text = "the %s bumper is pressed (segment %s of %d): drive away from what touches it"
            problems.append(Problem(Level.WARN, text % (name, " and ".join(pressed), len(segments))))
    return _finding(problems, "free" if any(segments for _, segments in bumpers) else "no bumpers are fitted", values)


def _temperature(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    config = robot.config
    problems, values, words = _faults(state, "Temperature"), [], "this robot reports none"
    if state.flags & Flags.HIGH_TEMPERATURE and not problems:
        problems.append(Problem(*FAULTS[FaultFlags.HIGH_TEMPERATURE][1:]))
    if state.temperature is not None:
        words = "%.0f deg C" % state.temperature
        values.append(("Temperature (deg C)", "%.0f" % state.temperature))
        limit = config.high_temperature_shutdown_c if config is not None else None
        if limit is not None and limit != NO_LIMIT:
            values.append(("Switches itself off at (deg C)", str(limit)))
            if state.temperature >= limit - NEAR_LIMIT:
                problems.append(Problem(
                    Level.ERROR if state.temperature >= limit else Level.WARN,
                    "%s, the robot switches itself off at %d deg C: let it cool down" % (words, limit)))
    return _finding(problems, words, values)


ABOUT_THE_ROBOT: Dict[str, Callable[[Facts, RobotIdentity, RobotState], Finding]] = {
    "Battery": _battery,
    "Motors": _motors,
    "Stall": _stall,
    "Bumpers": _bumpers,
    "Temperature": _temperature,
}
"""Name of the task -> what finds it. `config/diagnostics.yaml` names the same, and the link."""
TASKS = ("Link", *ABOUT_THE_ROBOT)


def find(task: str, facts: Facts) -> Finding:
    """What is to be said of a task. All but the link itself are STALE without one."""
    if task == "Link":
        return _link(facts)
    if facts.no_link is not None or facts.identity is None or facts.state is None:
        return Finding(Level.STALE, "not known: there is no link to the robot")
    return ABOUT_THE_ROBOT[task](facts, facts.identity, facts.state)


class LinkWindow:
    """What the line brought lately, from the counts since the start.

    A new link begins anew: the noise of connecting does not count.
    """

    def __init__(self) -> None:
        self._samples: Deque[Tuple[float, LinkCounts]] = deque()

    def recent(self, now: float, counts: LinkCounts) -> Optional[Recent]:
        """Take the counts of this moment.

        Returns what came since those of WINDOW ago; None within the first second of a link.
        """
        samples = self._samples
        # Or nobody asked.
        if samples and (samples[-1][1].reconnects != counts.reconnects or now - samples[-1][0] > 2 * WINDOW):
            samples.clear()
        if not samples or now - samples[-1][0] >= SAMPLING:
            samples.append((now, counts))
        while len(samples) > 1 and now - samples[1][0] >= WINDOW:
            samples.popleft()
        since, before = samples[0]
        if now - since < SHORTEST_WINDOW:
            return None
        return Recent(now - since, *(getattr(counts, name) - getattr(before, name) for name in (
            "sips", "bad_checksums", "discarded_bytes", "questions", "unanswered")))


JUDGED = ("flags", "motors_enabled", "stop_button", "fault_flags", "left_stall", "right_stall", "front_bumpers",
          "rear_bumpers", "battery_voltage",
          "charge_state", "temperature", "state_of_charge")
"""All of a state that findings depend on: most states differ from the one before in nothing of it."""
_judged = attrgetter(*JUDGED)


class Health:
    """Gathers what is known of the robot. It is told by one thread, and may be asked by another.

    Args:
        port: as the user gave it.
        baud: line speed; None on TCP.
        how_to_enable: the command that switches motors on, as the user would type it.
    """

    def __init__(self, port: str, baud: Optional[int], how_to_enable: str) -> None:
        self._facts = Facts(port, how_to_enable, baud)
        self._state: Optional[RobotState] = None    # these two change with every packet
        self._lost = 0
        self._window = LinkWindow()
        self._levels: List[Level] = []      # of all tasks but the link, after the last state
        self._cycle = DEFAULT_SIP_CYCLE

    @property
    def hardware_id(self) -> str:
        """The robot's name, also while it is not there."""
        identity = self._facts.identity
        return NO_HARDWARE if identity is None else identity.name

    def state(self, state: RobotState) -> bool:
        """Take a state. Whether the level of any task has changed by it."""
        facts = self._facts
        before, self._state = self._state, state
        if before is not None:  # packets that come together after a pause make up for it
            self._lost += round((state.time - before.time) / self._cycle) - 1
        if facts.motors_gone and state.motors_enabled:
            self._facts = facts._replace(motors_gone=False)
        elif facts.unmoved and state.moving:
            self._facts = facts._replace(unmoved=0.0)
        elif before is not None and _judged(before) == _judged(state):
            return False
        return self._changed()

    def _now(self) -> Facts:
        return self._facts._replace(state=self._state, lost=self._lost)

    def _changed(self) -> bool:
        facts = self._now()
        levels = [find(task, facts).level for task in ABOUT_THE_ROBOT]
        changed, self._levels = levels != self._levels, levels
        return changed

    def event(self, event: Event) -> bool:
        """Take an event.

        Whether the link has gone or the level of any task has changed by it; that the link is there shows with the
        first state.
        """
        facts, was_gone = self._facts, self._facts.no_link not in (None, NOT_YET)
        if isinstance(event, Ready):
            self._cycle = event.identity.sip_cycle
            self._facts = facts._replace(identity=event.identity, no_link=None, motors_gone=False, unmoved=0.0)
            self._state, self._lost = None, 0
        elif isinstance(event, LinkDown):
            self._facts, self._levels = facts._replace(no_link=str(event.error)), []
            return not was_gone
        elif isinstance(event, BaudFound):
            self._facts = facts._replace(baud=event.baud)
        elif isinstance(event, LineSpeed):
            self._facts = facts._replace(baud=event.baud, baud_problem=event.problem)
        elif isinstance(event, MotionCleared):
            self._facts = facts._replace(last_stop=event.reason, motors_gone=True)
            return self._changed()
        elif isinstance(event, Unmoved):
            self._facts = facts._replace(unmoved=event.age)
            return self._changed()
        elif isinstance(event, CommandTimedOut):
            self._facts = facts._replace(last_stop="no velocity came for %.1f s" % event.age)
        return False

    def report(self, now: float, counts: LinkCounts) -> Dict[str, Finding]:
        """What is to be said of all tasks now (monotonic, s); call it once a second, or more often."""
        facts = self._now()._replace(counts=counts)
        if facts.no_link is None:
            facts = facts._replace(recent=self._window.recent(now, counts))
        return {task: find(task, facts) for task in TASKS}

"""Makes the diagnostics of a robot as REP 107 says: levels and texts. The driver publishes them, the page shows them.

The functions are pure: time (monotonic, s) is an argument. There are always the same seven tasks, so that a program can
see when one is missing:

===========  ======================  ==============================================  =========================
task         OK                      WARN                                            ERROR
===========  ======================  ==============================================  =========================
Link         all packets arrive      packets are missing or damaged, stray bytes,    no link
                                     or questions without an answer (in the last
                                     seconds)
Battery      above the alarm level   below the alarm level; below the switch-off     below the switch-off
                                     level, but charging                             level
Motors       on or off               the STOP button is pressed; the robot           a fault of the drives or
                                     switched them off; it got a velocity, but       of the safety system
                                     stands; a fault with which they still work
Helm         who commands, if any    a lock is set
             input does
Stall        no wheel is stalled     a wheel is stalled
Bumpers      free, or none fitted    a segment is pressed
Temperature  normal, or the robot    near the switch-off level                       above the switch-off
             does not report it                                                      level, or the robot
                                                                                     reports too much heat
===========  ======================  ==============================================  =========================

At the switch-off level the robot switches itself off. WARN means a problem that a person can end. ERROR means that the
robot cannot work, or takes damage. Without a link all tasks but Link are STALE, the level of REP 107 for missing data,
because an old level may not be true any more.
"""

import math
from collections import deque
from operator import attrgetter
from typing import Any, Callable, Deque, Dict, Iterable, List, Mapping, NamedTuple, Optional, Tuple

from ..p2os import ChargeState, FaultFlags, Flags
from .alarms import battery_levels, low_battery, stalled_wheels, stop_button_pressed, unmoved
from .events import BaudFound, CommandTimedOut, Event, LineSpeed, LinkDown, MotionCleared, Ready, Unmoved
from .fault_flags import FAULTS, Level
from .helm import HelmState
from .identity import DEFAULT_SIP_CYCLE, RobotIdentity
from .robot import LinkCounts
from .state import RobotState

NOT_YET = "still looking for the robot"
NO_HARDWARE = "none"
"""The hardware id before the first connection, when the name of the robot is not known."""
WINDOW = 4.0
"""The time (s) over which packets and errors are counted. A gap of almost 1 s causes a warning, jitter does not."""
SHORTEST_WINDOW = 1.0   # s; there are no warnings about a link that is younger
SAMPLING = 0.5          # s between two samples of the counters
RATE_OK = 0.9
"""The fraction of the expected packets, and of the answers to questions, that must arrive."""
NO_LIMIT = -128
"""The temperature limit in the CONFIGpac of a robot that does not switch itself off when it is hot."""
NEAR_LIMIT = 5.0
"""There is a warning when the temperature is this close to the limit (deg C)."""
CHARGING: Dict[Optional[int], str] = {
    ChargeState.BULK: "charging (bulk)",
    ChargeState.OVERCHARGE: "charging (overcharge)",
    ChargeState.FLOAT: "charging (float)",
    ChargeState.BALANCE: "charging (balance)",
}
"""The text for each state of the charger in which it charges the battery."""


class Finding(NamedTuple):
    """The result of one diagnostics task: the level, the text, and values by name."""

    level: Level
    message: str
    values: Mapping[str, str]


class Problem(NamedTuple):
    """One possible problem: whether it is present (`is_so`), its level, and a text that says what to do."""

    is_so: bool
    level: Level
    text: str


class Recent(NamedTuple):
    """What was received from the robot in the last `seconds`: about WINDOW, less for a new link.

    `questions` were sent to the robot to check the link, and `unanswered` of them got no answer in time.
    """

    seconds: float
    packets: int
    bad_checksums: int
    stray_bytes: int
    questions: int
    unanswered: int


class Facts(NamedTuple):
    """All data that the diagnostics use, at one moment."""

    port: str
    how_to_enable: str
    """The shell command that switches the motors on."""
    baud: Optional[str] = None
    """The line speed, and why it is not the wanted speed (host_baud). None on TCP."""
    no_link: Optional[str] = NOT_YET
    """Why there is no link. None while there is a link."""
    identity: Optional[RobotIdentity] = None
    state: Optional[RobotState] = None
    """The newest state. None before the first state of this link."""
    last_stop: Optional[str] = None
    """Why the robot last stopped without a stop command."""
    motors_gone: bool = False
    """Whether the robot switched its motors off by itself, and they are not on again."""
    unmoved: float = 0.0
    """How long (s) the robot has stood although it got a velocity. 0 when it has moved since."""
    lost: int = 0
    """How many packets of this link are missing. It is negative while packets come early."""
    counts: LinkCounts = LinkCounts(0, 0, 0, 0, 0, 0, 0, 0, None)
    """The counters of the link since the start of the driver."""
    helm: HelmState = HelmState()
    """Who may command."""
    obstacles: Mapping[str, str] = {}
    """What to tell people about a lock, and about an input that has the helm: sentences by its name."""
    recent: Optional[Recent] = None
    """What was received recently. None without a link, and during its first second."""


def _finding(problems: Iterable[Problem], otherwise: str, values: Mapping[str, Optional[str]]) -> Finding:
    """Return the finding for a list of possible problems.

    Args:
        problems: the possible problems. Those that are present make the text, the worst first, and the level.
        otherwise: the text when no problem is present; then the level is OK.
        values: the named values. A value that is None is left out.
    """
    found = sorted((problem for problem in problems if problem.is_so), key=attrgetter("level"), reverse=True)
    return Finding(found[0].level if found else Level.OK, "; ".join(problem.text for problem in found) or otherwise,
                   {name: value for name, value in values.items() if value is not None})


def _faults(state: RobotState, task: str) -> List[Problem]:
    """Return the problems of a task that the fault flags of the robot report.

    Some robots report a high temperature in the ordinary flags instead, so this function looks there too.
    """
    flags = (state.fault_flags or 0) | (FaultFlags.HIGH_TEMPERATURE if state.flags & Flags.HIGH_TEMPERATURE else 0)
    return [Problem(True, level, text)
            for flag, (about, level, text) in FAULTS.items() if flags and about == task and flags & flag]


def _link(facts: Facts) -> Finding:
    """Return the finding of the task Link."""
    identity, counts, recent = facts.identity, facts.counts, facts.recent
    cycle = DEFAULT_SIP_CYCLE if identity is None else identity.sip_cycle
    rate = None if recent is None else "%.1f" % (recent.packets / recent.seconds)
    values = {
        "Port": facts.port,
        "Baud": facts.baud,
        **({} if identity is None else {
            "Robot": identity.name,
            "Model": identity.subtype,
            "Firmware": identity.firmware or "not reported",
            "Serial number": identity.serial or "not reported",
        }),
        **({} if facts.no_link is not None else {
            "Packets a second": rate or "not known yet",
            "Packets a second the robot sends": "%.1f" % (1 / cycle),
            "Packets of this link that got lost": str(max(0, facts.lost)),
        }),
        "Packets": str(counts.sips),
        "Bad checksums": str(counts.bad_checksums),
        "Stray bytes": str(counts.discarded_bytes),
        "Packets nobody understands": str(counts.unreadable),
        "Readings of unknown sonar": str(counts.unknown_sonar),
        "Questions without an answer": ("%d of %d" % (counts.unanswered, counts.questions) if counts.questions
                                        else "not known: none was asked, or none answered"),
        "Missed by this computer": str(counts.missed),
        "Reconnects": str(counts.reconnects),
        "Last error": counts.last_error or "none",
    }
    problems = [Problem(facts.no_link is not None, Level.ERROR, "no link: %s" % facts.no_link)]
    if recent is not None:
        problems += [
            # + 1: one packet may just be on its way, and after the first second this is a tenth of all packets.
            Problem(recent.packets + 1 < RATE_OK * recent.seconds / cycle, Level.WARN,
                    "only %s of %.1f packets a second arrive: check cable, radio and the computer's load"
                    % (rate, 1 / cycle)),
            Problem(recent.bad_checksums + recent.stray_bytes > 0, Level.WARN,
                    "%d packets with a bad checksum and %d stray bytes within %.0f s: check cable and plugs"
                    % (recent.bad_checksums, recent.stray_bytes, recent.seconds)),
            # + 1: a single lost answer is no problem.
            Problem(recent.questions - recent.unanswered + 1 < RATE_OK * recent.questions, Level.WARN,
                    "%d of %d questions within %.0f s were not answered in time: what is sent to the robot gets lost, "
                    "or late: check cable and radio" % (recent.unanswered, recent.questions, recent.seconds)),
        ]
    return _finding(problems, "connected, %s packets a second" % rate if rate else "connected", values)


def _battery(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Battery."""
    voltage, levels, config = state.battery_voltage, battery_levels(robot), robot.config
    percent = 100 * (math.nan if state.state_of_charge is None else state.state_of_charge)      # nan < x is false
    low, empty = (0, 0) if config is None else (config.charge_low_percent or 0, config.charge_shutdown_percent or 0)
    charges = CHARGING.get(state.charge_state, "on its charger" if state.flags & Flags.CHARGER_POWER else "")
    worst, advice = (Level.WARN, "it is on its charger") if charges else (Level.ERROR, "charge it")
    return _finding([
        Problem(percent < max(low, empty), worst if percent < empty else Level.WARN,
                "battery low: %.0f %% of its charge is left; %s" % (percent, advice)),
        Problem(voltage < levels.empty, worst,
                "battery nearly empty: %.1f V, the robot switches itself off at %.1f V; %s"
                % (voltage, levels.empty, advice)),
        Problem(levels.empty <= voltage < levels.low, Level.WARN, low_battery(voltage, levels) + "; " + advice),
        *_faults(state, "Battery"),
    ], "%.1f V, %s" % (voltage, charges) if charges else "%.1f V" % voltage, {
        "Voltage (V)": "%.1f" % voltage,
        "Alarm level (V)": "%.1f" % levels.low,
        "Switches itself off at (V)": "%.1f" % levels.empty,
        "Charger": charges or ("not charging" if state.charge_state == ChargeState.NOT_CHARGING else "not reported"),
        "State of charge (%)": None if state.state_of_charge is None else "%.0f" % percent,
    })


def _motors(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Motors."""
    is_pressed, is_held, enable = state.stop_button, bool(state.flags & Flags.E_STALL), facts.how_to_enable
    return _finding([
        *_faults(state, "Motors"),
        Problem(is_pressed, Level.WARN, stop_button_pressed(enable)),
        Problem(is_held and not is_pressed, Level.WARN,
                "an emergency stop holds the wheels: release it, then %s" % enable),
        Problem(facts.motors_gone and not is_held and not is_pressed, Level.WARN,
                "the robot took its motors away (STOP or MOTORS button, a fault): see why, then %s" % enable),
        Problem(facts.unmoved > 0, Level.WARN, unmoved(facts.unmoved)),
    ], "motors are on" if state.motors_enabled else "motors are off; to switch them on: %s" % enable, {
        "Motors": "on" if state.motors_enabled else "off",
        "STOP button": "pressed" if is_pressed else "not pressed",
        "Stopped by itself last": facts.last_stop or "never",
    })


def _helm(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Helm."""
    helm = facts.helm
    by_whom = " (%s)" % helm.who if helm.who else ""
    if helm.commander == helm.holder != "":
        otherwise = "a person commands on %s%s" % (helm.commander, by_whom)
    elif helm.holder:
        otherwise = facts.obstacles.get(helm.holder, "%s has the helm" % helm.holder)
    else:
        otherwise = "%s commands%s" % (helm.commander, by_whom) if helm.commander else "nobody commands"
    return _finding(
        [Problem(True, Level.WARN, facts.obstacles.get(lock, "%s is set" % lock)) for lock in helm.locks], otherwise, {
            "Commander": helm.commander + by_whom if helm.commander else "nobody",
            "Programs": "locked out" if helm.holder else "may command",
            "Locks": ", ".join(helm.locks) or "none",
        })


def _stall(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Stall."""
    text = stalled_wheels(state)
    return _finding([Problem(text != "", Level.WARN, text)], "no wheel is stalled", {
        "Left wheel": "stalled" if state.left_stall else "free",
        "Right wheel": "stalled" if state.right_stall else "free",
    })


def _bumpers(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Bumpers."""
    problems, values = [], {}
    for name, segments in (("front", state.front_bumpers), ("rear", state.rear_bumpers)):
        pressed = [str(number) for number, segment in enumerate(segments, 1) if segment]
        told = "pressed: " + ", ".join(pressed) if pressed else "free"
        values[name.capitalize()] = told if segments else "none fitted"
        problems.append(Problem(
            any(segments), Level.WARN, "the %s bumper is pressed (segment %s of %d): drive away from what touches it"
            % (name, " and ".join(pressed), len(segments))))
    return _finding(problems, "free" if state.front_bumpers or state.rear_bumpers else "no bumpers are fitted", values)


def _temperature(facts: Facts, robot: RobotIdentity, state: RobotState) -> Finding:
    """Return the finding of the task Temperature."""
    problems = _faults(state, "Temperature")
    if state.temperature is None:
        return _finding(problems, "this robot reports none", {})
    words, values = "%.0f deg C" % state.temperature, {"Temperature (deg C)": "%.0f" % state.temperature}
    limit = None if robot.config is None else robot.config.high_temperature_shutdown_c
    if limit is not None and limit != NO_LIMIT:
        values["Switches itself off at (deg C)"] = str(limit)
        problems.append(Problem(
            state.temperature >= limit - NEAR_LIMIT, Level.ERROR if state.temperature >= limit else Level.WARN,
            "%s, the robot switches itself off at %d deg C: let it cool down" % (words, limit)))
    return _finding(problems, words, values)


ABOUT_THE_ROBOT: Dict[str, Callable[[Facts, RobotIdentity, RobotState], Finding]] = {
    "Battery": _battery,
    "Motors": _motors,
    "Helm": _helm,
    "Stall": _stall,
    "Bumpers": _bumpers,
    "Temperature": _temperature,
}
"""From the name of each task but Link to its function. `config/diagnostics.yaml` has the same names, and Link."""
TASKS = ("Link", *ABOUT_THE_ROBOT)


def find(task: str, facts: Facts) -> Finding:
    """Return the finding of a task. Without a link to the robot, all tasks but "Link" are STALE."""
    if task == "Link":
        return _link(facts)
    if facts.no_link is not None or facts.identity is None or facts.state is None:
        return Finding(Level.STALE, "not known: there is no link to the robot", {})
    return ABOUT_THE_ROBOT[task](facts, facts.identity, facts.state)


class LinkWindow:
    """Computes what was received in the last seconds (WINDOW) from the counters of the link.

    After a reconnect it starts again, so that errors during the connection do not count.
    """

    def __init__(self) -> None:
        self._samples: Deque[Tuple[float, LinkCounts]] = deque()

    def recent(self, now: float, counts: LinkCounts) -> Optional[Recent]:
        """Take the current counters, and return what was received in the last seconds.

        Args:
            now: the current time (monotonic, s).
            counts: the counters of the link since the start of the driver.

        Returns:
            The increase of the counters in about WINDOW seconds. None in the first second of a link.
        """
        samples = self._samples
        # Forget samples of an earlier link, and old samples (this method was not called for a while).
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


JUDGED = (
    "flags", "motors_enabled", "stop_button", "fault_flags", "left_stall", "right_stall", "front_bumpers",
    "rear_bumpers", "battery_voltage", "charge_state", "temperature", "state_of_charge")
"""The fields of a state on which levels depend. Most states change none of them."""
_judged = attrgetter(*JUDGED)

TOLD: Dict[type, Callable[[Any], Dict[str, Any]]] = {
    Ready: lambda event: dict(identity=event.identity, no_link=None, motors_gone=False, unmoved=0.0),
    LinkDown: lambda event: dict(no_link=str(event.error)),
    BaudFound: lambda event: dict(baud=str(event.baud)),
    LineSpeed: lambda event: dict(baud="%d (%s)" % event if event.problem else str(event.baud)),
    MotionCleared: lambda event: dict(last_stop=event.reason, motors_gone=True),
    Unmoved: lambda event: dict(unmoved=event.age),
    CommandTimedOut: lambda event: dict(last_stop="no velocity came for %.1f s" % event.age),
}
"""For each type of event: a function that returns the fields of Facts that the event changes."""


class Health:
    """Collects data about the robot, and makes its diagnostics.

    One thread may call `state` and `event` while another thread calls `report`.

    Args:
        port: the serial device or URL, as the user gave it, but without a key.
        baud: the line speed. None if the port is not serial.
        how_to_enable: the shell command that switches the motors on, for the texts.
        obstacles: what to tell people about a lock, and about an input that has the helm: sentences by its name.
    """

    def __init__(self, port: str, baud: Optional[int], how_to_enable: str, obstacles: Mapping[str, str] = {}) -> None:
        # Without state, lost and helm:
        self._facts = Facts(port, how_to_enable, None if baud is None else str(baud), obstacles=obstacles)
        self._state: Optional[RobotState] = None    # the newest state of this link
        self._lost = 0
        self._window = LinkWindow()
        self._levels: List[Level] = []      # of all tasks but the link, after the last state
        self._judged: Any = None            # values of JUDGED in the last state; None to judge the next one anyway

    @property
    def hardware_id(self) -> str:
        """The name of the robot, also while there is no link. NO_HARDWARE before the first connection."""
        identity = self._facts.identity
        return NO_HARDWARE if identity is None else identity.name

    def state(self, state: RobotState) -> bool:
        """Take a new state of the robot. Return whether it changes the level of a task."""
        facts, before, self._state = self._facts, self._state, state
        if before is not None and facts.identity is not None:
            # When late packets come together after a pause, the sum is right again.
            self._lost += round((state.time - before.time) / facts.identity.sip_cycle) - 1
        if facts.motors_gone and state.motors_enabled or facts.unmoved and state.moving:
            self._facts = facts._replace(motors_gone=facts.motors_gone and not state.motors_enabled,
                                         unmoved=0.0 if state.moving else facts.unmoved)
            self._judged = None
        judged_before, self._judged = self._judged, _judged(state)
        return bool(self._judged != judged_before) and self._changed()

    def _changed(self) -> bool:
        """Compute the levels of all tasks but Link, and return whether one has changed since the last call."""
        before, self._levels = self._levels, [
            find(task, self._facts._replace(state=self._state)).level for task in ABOUT_THE_ROBOT]
        return self._levels != before

    def event(self, event: Event) -> bool:
        """Take an event of the link. Return whether to publish at once.

        True when the link broke, when the first connection failed, or when the event changes the level of a task. False
        for a new link, because the levels change only with its first state.
        """
        before = self._facts
        if type(event) in TOLD:
            self._facts = before._replace(**TOLD[type(event)](event))
        if isinstance(event, (Ready, LinkDown)):
            self._state, self._lost, self._levels, self._judged = None, 0, [], None
            return isinstance(event, LinkDown) and before.no_link in (None, NOT_YET)
        return isinstance(event, (MotionCleared, Unmoved)) and self._changed()

    def report(self, now: float, counts: LinkCounts, helm: HelmState = HelmState()) -> Dict[str, Finding]:
        """Return the findings of all tasks, by task. Call it once a second or more often.

        Args:
            now: the current time (monotonic, s).
            counts: the counters of the link.
            helm: who may command.
        """
        facts = self._facts._replace(counts=counts, state=self._state, lost=self._lost, helm=helm)
        if facts.no_link is None:
            facts = facts._replace(recent=self._window.recent(now, counts))
        return {task: find(task, facts) for task in TASKS}

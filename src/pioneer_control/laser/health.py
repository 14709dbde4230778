"""How a laser is, as REP 107 says it: a level, a text, and values. Pure: time (s) is an argument.

OK     scans arrive as fast as the line allows
WARN   a person can end it: the window is dirty, scans are damaged or missing, the laser warns, or it does otherwise
       than it was asked
ERROR  there are no scans, or the laser says that it is broken
"""

from collections import deque
from operator import attrgetter
from typing import Any, Deque, Dict, List, Optional, Tuple

from ..client.fault_flags import Level
from ..client.health import Finding, Problem
from ..lms2xx import MEASURING_MODES, WELL, Severity, Status, Unit, farthest_m, scan_time, severity
from .conversation import LaserInfo
from .line import PortDown, StillLooking
from .session import LaserCounts, LaserLost, Measuring, ScanHeard

WINDOW = 4.0
"""Time (s) over which scans and damages are counted."""
SHORTEST_WINDOW = 1.0
"""A shorter time (s) is not judged."""
RATE_OK = 0.85
"""Share of the scans that the line allows which must arrive. By the maker's own count a laser skips one scan more than
it must (laser sheet 1.8, in brackets): that is a share of 0.89."""
NOT_YET = "still looking for the laser"
TOLD = {Severity.WARNING: "a warning", Severity.ERROR: "an error", Severity.FATAL: "a fatal error"}
"""What a laser says in the status byte of each telegram. `Severity.INFORMATION` is no problem."""


class LaserHealth:
    """Collects what happens on the line of one laser.

    Args:
        port: its port, as the user gave it.
    """

    def __init__(self, port: str) -> None:
        self._port = port
        self._no_scans: Optional[str] = NOT_YET
        self._last_error = "none"
        self._status = WELL
        self._info: Optional[LaserInfo] = None
        self._samples: Deque[Tuple[float, LaserCounts]] = deque()

    @property
    def hardware_id(self) -> str:
        """What the laser calls itself; "none" before it was found."""
        return "none" if self._info is None else self._info.type

    def event(self, event: Any) -> bool:
        """Take an event of the line. Return whether it should be reported at once."""
        before = self._no_scans, self._status
        if isinstance(event, ScanHeard):
            self._no_scans, self._status, self._info = None, event.status, event.info
        elif isinstance(event, Measuring):
            self._no_scans, self._info = None, event.info
            self._samples.clear()
        elif isinstance(event, (LaserLost, PortDown)):
            self._no_scans = self._last_error = event.reason
        elif isinstance(event, StillLooking):
            self._no_scans = event.reason
        return (self._no_scans, self._status) != before

    def report(self, now: float, counts: LaserCounts) -> Finding:
        """Return how the laser is at some time (s), with its counters."""
        self._samples.append((now, counts))
        while len(self._samples) > 2 and now - self._samples[1][0] >= WINDOW:
            self._samples.popleft()
        problems = sorted(self._problems(now, counts), key=attrgetter("level"), reverse=True)
        found = [problem for problem in problems if problem.is_so]
        message = "; ".join(problem.text for problem in found) or "all scans arrive"
        return Finding(found[0].level if found else Level.OK, message, self._values(now, counts))

    def _problems(self, now: float, counts: LaserCounts) -> List[Problem]:
        """Return all problems that there may be."""
        if self._no_scans is not None or self._info is None:
            return [Problem(True, Level.ERROR, "no scans: %s" % self._no_scans)]
        told = severity(self._status)
        problems = [
            Problem(told >= Severity.WARNING, Level.ERROR if told >= Severity.ERROR else Level.WARN,
                    "the laser reports %s" % TOLD.get(Severity(min(told, Severity.FATAL)), "")),
            Problem(bool(self._status & Status.DIRTY_WINDOW), Level.WARN, "the window of the laser is dirty: wipe it"),
            Problem(bool(self._status & Status.IMPLAUSIBLE_VALUES), Level.WARN,
                    "the laser calls its values implausible"),
            *(Problem(True, Level.WARN, remark) for remark in self._info.remarks)]
        seconds, before = now - self._samples[0][0], self._samples[0][1]
        if seconds >= SHORTEST_WINDOW:
            scans, allowed = counts.scans - before.scans, seconds / scan_time(self._info.variant, self._info.baud)
            damaged = (counts.line.wrong_crcs + counts.malformed) - (before.line.wrong_crcs + before.malformed)
            problems += [
                Problem(scans + 1 < RATE_OK * allowed, Level.WARN, "only %.1f of %.1f scans a second arrive: check the"
                        " cable and the computer's load" % (scans / seconds, allowed / seconds)),
                Problem(damaged > 0, Level.WARN, "%d telegrams were damaged in the last %.0f s: check the cable"
                        % (damaged, seconds))]
        return problems

    def _values(self, now: float, counts: LaserCounts) -> Dict[str, str]:
        """Return the named values."""
        seconds = now - self._samples[0][0]
        values = {"Port": self._port}
        info = self._info
        if info is not None:
            unit = Unit(info.configuration.unit) if info.configuration.unit in list(Unit) else Unit.MILLIMETRES
            farthest = farthest_m(MEASURING_MODES[info.configuration.measuring_mode], unit)
            values.update({
                "Laser": info.type,
                "Baud": str(info.baud),
                "Looks": "%d degrees wide in steps of %.2f" % (
                    info.variant.angle_deg, info.variant.step_hundredths / 100.0),
                "Measures to": "%g m" % farthest,
                "Scans a second": "%.1f" % ((counts.scans - self._samples[0][1].scans) / seconds)
                                  if seconds >= SHORTEST_WINDOW else "not known yet",
                "Scans a second the line allows": "%.1f" % (1.0 / scan_time(info.variant, info.baud)),
            })
        values.update({
            "Scans": str(counts.scans),
            "Wrong CRCs": str(counts.line.wrong_crcs),
            "Stray bytes": str(counts.line.discarded_bytes),
            "Telegrams that make no sense": str(counts.malformed),
            "Requests that were sent again": str(counts.repeated),
            "Times the laser was lost": str(counts.lost),
            "Last error": self._last_error,
        })
        return values

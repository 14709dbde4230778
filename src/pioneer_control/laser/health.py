"""How a laser is, as REP 107 says it: a level, a text, and values. Pure: time (s) is an argument.

OK     scans arrive as fast as the line allows
WARN   a person can end it: the window is dirty, scans are damaged or missing, the laser warns, or it does otherwise
       than it was asked
ERROR  there are no scans, or the laser says that it is broken
"""

from collections import deque
from operator import attrgetter
from typing import Any, Deque, Dict, Iterable, List, Optional, Tuple

from ..client.fault_flags import Level
from ..client.health import Finding, Problem
from ..lms2xx import DAZZLED, MEASURING_MODES, WELL, DeviceError, Severity, Status, codes_in, severity
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
DAZZLED_SHARE = 0.05
"""Share of the rays of a scan from which on that many dazzled ones are a problem [inv]. Few are none: the laser tells
them, and they are NaN.
"""
NOT_YET = "still looking for the laser"
TOLD = {Severity.WARNING: "a warning", Severity.ERROR: "an error", Severity.FATAL: "a fatal error"}
"""What a laser says in the status byte of each telegram. `Severity.INFORMATION` is no problem."""


def in_words(errors: Iterable[DeviceError]) -> str:
    """Return the errors of a laser as text, such as ``warning 18, error 7 (over)``. "none" if there are none.

    The laser sheet has no words for their numbers: they are those of the maker's list for this laser.
    """
    kinds = {each.value: each.name.replace("_", " ").lower() for each in Severity}
    return ", ".join("%s %d%s" % (kinds.get(each.severity, "kind %d," % each.severity), each.number,
                                  " (over)" if each.is_old else "") for each in errors) or "none"


class LaserHealth:
    """Collects what happens on the line of one laser. One thread may call `event` while another calls `report`.

    Args:
        port: its port, as the user gave it.
    """

    def __init__(self, port: str) -> None:
        self._port = port
        self._no_scans: Optional[str] = NOT_YET
        self._last_error = "none"
        self._status = WELL
        self._info: Optional[LaserInfo] = None
        self._scan: Optional[ScanHeard] = None      # the last one of this laser
        self._samples: Deque[Tuple[float, LaserCounts]] = deque()

    @property
    def hardware_id(self) -> str:
        """What the laser calls itself; "none" before it was found."""
        return "none" if self._info is None else self._info.type

    def event(self, event: Any) -> bool:
        """Take an event of the line. Return whether it should be reported at once."""
        before = self._no_scans, self._status
        if isinstance(event, ScanHeard):
            self._no_scans, self._status, self._info, self._scan = None, event.status, event.info, event
        elif isinstance(event, Measuring):
            self._no_scans, self._info, self._scan = None, event.info, None
            self._samples = deque()
        elif isinstance(event, (LaserLost, PortDown)):
            self._no_scans = self._last_error = event.reason
        elif isinstance(event, StillLooking):
            self._no_scans = event.reason
        return (self._no_scans, self._status) != before

    def report(self, now: float, counts: LaserCounts) -> Finding:
        """Return how the laser is at some time (s), with its counters."""
        samples = self._samples
        samples.append((now, counts))
        while len(samples) > 2 and now - samples[1][0] >= WINDOW:
            samples.popleft()
        since, before = samples[0]
        problems = sorted(self._problems(now - since, before, counts), key=attrgetter("level"), reverse=True)
        found = [problem for problem in problems if problem.is_so]
        message = "; ".join(problem.text for problem in found) or "all scans arrive"
        return Finding(found[0].level if found else Level.OK, message, self._values(now - since, before, counts))

    def _problems(self, seconds: float, before: LaserCounts, counts: LaserCounts) -> List[Problem]:
        """Return all problems that there may be, with the counters now and some seconds before."""
        if self._no_scans is not None or self._info is None:
            return [Problem(True, Level.ERROR, "no scans: %s" % self._no_scans)]
        told = severity(self._status)
        present = [error for error in self._info.errors if error.severity >= Severity.WARNING and not error.is_old]
        numbers = ": %s" % in_words(present) if present else ""
        codes = self._codes()
        problems = [
            Problem(told >= Severity.WARNING, Level.ERROR if told >= Severity.ERROR else Level.WARN,
                    "the laser reports %s%s" % (TOLD.get(Severity(min(told, Severity.FATAL)), ""), numbers)),
            Problem(codes.get(DAZZLED, 0) > DAZZLED_SHARE * self._info.variant.values, Level.WARN,
                    "%d of %d rays are dazzled: the sun or another laser shines into it" % (
                        codes.get(DAZZLED, 0), self._info.variant.values)),
            Problem(bool(self._status & Status.DIRTY_WINDOW), Level.WARN, "the window of the laser is dirty: wipe it"),
            Problem(bool(self._status & Status.IMPLAUSIBLE_VALUES), Level.WARN,
                    "the laser calls its values implausible"),
            *(Problem(True, Level.WARN, remark) for remark in self._info.remarks)]
        if seconds >= SHORTEST_WINDOW:
            scans, allowed = counts.scans - before.scans, seconds / self._info.scan_time
            damaged = (counts.line.wrong_crcs + counts.malformed) - (before.line.wrong_crcs + before.malformed)
            problems += [
                Problem(scans + 1 < RATE_OK * allowed, Level.WARN, "only %.1f of %.1f scans a second arrive: check the"
                        " cable and the computer's load" % (scans / seconds, allowed / seconds)),
                Problem(damaged > 0, Level.WARN, "%d telegrams were damaged in the last %.0f s: check the cable"
                        % (damaged, seconds))]
        return problems

    def _codes(self) -> Dict[str, int]:
        """Return how many rays of the last scan have no distance, by the reason."""
        if self._scan is None:
            return {}
        return codes_in(self._scan.scan, MEASURING_MODES[self._scan.info.configuration.measuring_mode])

    def _values(self, seconds: float, before: LaserCounts, counts: LaserCounts) -> Dict[str, str]:
        """Return the named values, with the counters now and some seconds before."""
        values = {"Port": self._port}
        info = self._info
        if info is not None:
            values.update({
                "Laser": info.type,
                "Baud": str(info.baud),
                "Looks": "%d degrees wide in steps of %.2f" % (
                    info.variant.angle_deg, info.variant.step_hundredths / 100.0),
                "Measures to": "%g m" % info.farthest_m,
                "Scans a second": "%.1f" % ((counts.scans - before.scans) / seconds)
                                  if seconds >= SHORTEST_WINDOW else "not known yet",
                "Scans a second the line allows": "%.1f" % (1.0 / info.scan_time),
                "Rays without a distance": ", ".join("%s %d" % each for each in self._codes().items()) or "none",
                "Errors that it tells": in_words(info.errors),
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

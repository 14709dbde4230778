"""Find what went wrong in a run: warnings and errors, what a simulator was asked to break, and gaps in the data."""

import re
from collections import defaultdict
from typing import DefaultDict, Dict, List, NamedTuple, Sequence, Tuple

from ..recorded_run import Report, Run, Span

LISTED = 10  # the default number of incidents that get a letter
AT_ONCE = 1.0  # s: reports that follow each other so soon count as one
CONNECTING = 3.0  # s before the first pose: reports do not count, because the driver has only just begun to connect
NUMBER = re.compile(r"\d+(\.\d+)?")
# matches what the simulator says when it begins or ends a fault that it was asked for
MADE = re.compile(r"(?:simulated [\d.]+ s: )?fault (begins|ends): (.*)")
TOPICS_NAMED = 3


class Incident(NamedTuple):
    """Equal warnings or errors. Texts that differ only in their numbers are equal."""

    letter: str  # empty if the page has no room to list it
    level: int
    times: Tuple[float, ...]  # s
    words: str


def incidents(run: Run, listed: int = LISTED) -> Tuple[Incident, ...]:
    """Return the warnings and errors of a run in order of time. Equal reports are one incident.

    Args:
        run: the run.
        listed: how many incidents get a letter. Errors get one before warnings.
    """
    same: Dict[str, List[Report]] = {}
    for fault in sorted(run.faults):
        if not MADE.fullmatch(fault.what) and not 0 < run.odometry.time[0] - fault.time < CONNECTING:
            core = NUMBER.sub("#", fault.what).partition(" (")[0]
            same.setdefault(next((known for known in same if _says(known, core) or _says(core, known)), core),
                            []).append(fault)
    found = [_incident(each) for each in same.values()]
    worst = sorted(range(len(found)), key=lambda number: (-found[number].level, number))[:listed]
    letters = dict(zip(sorted(worst), "ABCDEFGHIJKLMNOPQRSTUVWXYZ"))
    return tuple(each._replace(letter=letters.get(number, "")) for number, each in enumerate(found))


def _says(longer: str, shorter: str) -> bool:
    """Return whether two texts are equal, or `longer` has more words before a colon or after a semicolon."""
    return longer == shorter or longer.endswith(": " + shorter) or longer.startswith(shorter + "; ")


def _incident(same: Sequence[Report]) -> Incident:
    """Make one incident of equal reports, which are in order of time.

    Reports at the same time count once, because a node and its diagnostics both report the same.
    """
    who = same[0].who.rsplit("/", 1)[-1]
    times = [fault.time for fault, before in zip(same, [None, *same])
             if before is None or fault.time - before.time > AT_ONCE]
    return Incident("", max(fault.level for fault in same), tuple(times), ("%s: " % who if who else "") + same[0].what)


def made(faults: Sequence[Report], end: float) -> Tuple[Span, ...]:
    """Return the spans of time of the faults that a simulator was asked for.

    Args:
        faults: the warnings and errors of the run.
        end: the end (s) of faults that did not end in the run.
    """
    spans: List[Span] = []
    begun: DefaultDict[str, List[float]] = defaultdict(list)    # since when (s) each thing is broken
    for fault in sorted(faults):
        told = MADE.fullmatch(fault.what)
        if told and told[1] == "begins":
            begun[told[2]].append(fault.time)
        elif told and begun[told[2]]:
            spans.append(Span(begun[told[2]].pop(0), fault.time, told[2]))
    return tuple(sorted(spans + [Span(time, end, what) for what, times in begun.items() for time in times]))


def silences(gaps: Sequence[Span]) -> Tuple[Span, ...]:
    """Join gaps that overlap to one gap, with the names of all topics that had no messages."""
    found: List[Tuple[float, float, List[str]]] = []
    for begin, end, topic in sorted(gaps):
        first, last, topics = found.pop() if found and begin < found[-1][1] else (begin, end, [])
        found.append((first, max(last, end), [*topics, topic]))
    return tuple(Span(begin, end, _named(topics)) for begin, end, topics in found)


def _named(topics: Sequence[str]) -> str:
    """Return the last names of the first few topics, and how many more topics there are."""
    names = list(dict.fromkeys(topic.rsplit("/", 1)[-1] for topic in topics))
    more = len(names) - TOPICS_NAMED
    return ", ".join(names[:TOPICS_NAMED]) + (" and %s more" % more if more > 0 else "")

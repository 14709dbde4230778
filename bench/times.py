"""Times that were measured, as rows of a table."""

import statistics
from typing import Sequence

HEAD = "| what | times | median, ms | 95 % | worst | limit |\n|---|---|---|---|---|---|"


def row(name: str, values: Sequence[float], limit: str) -> str:
    """Return one row: how many times (s), median, 95 % and worst in ms, and the limit."""
    ordered = sorted(1000 * value for value in values)
    return "| %s | %d | %.1f | %.1f | %.1f | %s |" % (
        name, len(ordered), statistics.median(ordered), ordered[int(0.95 * (len(ordered) - 1))], ordered[-1], limit)

#!/usr/bin/python3
"""Does a class grow? Pages that come, go, and hang, for an hour, and the memory of the processes that serve them.

    python3 bench/web_soak.py                   # an hour
    python3 bench/web_soak.py --minutes 5

Of all viewers, some read and acknowledge as a page does, some stop reading and stay, some go at once and without a
word. They join as students, whose robots the teacher frees again and again. bench/web.md has the measurements.
"""

import argparse
import contextlib
import json
import pathlib
import random
import secrets
import statistics
import sys
import tempfile
import time
from typing import Dict, List, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[1]
for folder in ("src", "test/integration", "bench"):
    sys.path.insert(0, str(ROOT / folder))

import websocket

from class_site import ClassSite
from page import Watcher

ROBOTS = 10
MOST_VIEWERS = 40
PERIOD = 0.02           # s between two looks at all viewers
COMES_EACH = 0.5        # s
FREED_EACH = 2.0        # s: the teacher frees a robot
SAMPLE_EACH = 10.0      # s
WARM_UP = 0.1           # share of the time that does not count: what is made once is made then
KINDS = ("reads",) * 6 + ("hangs",) * 2 + ("goes",) * 2


class Guest:
    """A viewer that comes and goes.

    Args:
        site: the class.
        now: the time (monotonic, s).
    """

    def __init__(self, site: ClassSite, now: float) -> None:
        self.kind = random.choice(KINDS)
        self.goes_at = now + (0.1 if self.kind == "goes" else random.uniform(5.0, 60.0))
        self.watcher = Watcher(site.base.replace("http", "ws") + "page", site.students)
        self.watcher.line.send(json.dumps({"do": "join", "name": "Guest %s" % secrets.token_hex(4)}))

    def look(self, now: float) -> bool:
        """Read, if it is one that reads. Returns whether it is still there."""
        try:
            if self.kind == "reads":
                for _ in self.watcher.read():
                    pass
                self.watcher.acknowledge()
        except BlockingIOError:
            pass
        except ConnectionError:     # the server sent it away
            return False
        return now < self.goes_at

    def go(self) -> None:
        """Leave without a word: the socket is closed, and that is all."""
        self.watcher.line.sock.close()


def memory(pid: int) -> float:
    """Return the memory (MB) that a process has for itself."""
    lines = pathlib.Path("/proc/%d/smaps_rollup" % pid).read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("Private")) / 1000.0


def slope(values: Sequence[float], seconds: float) -> float:
    """Return by how much values grow in an hour: the line of least squares through them, taken over so many seconds."""
    mean_at, mean = (len(values) - 1) / 2.0, statistics.mean(values)
    spread = sum((at - mean_at) ** 2 for at in range(len(values)))
    rise = sum((at - mean_at) * (value - mean) for at, value in enumerate(values)) / spread
    return rise * (len(values) - 1) * 3600.0 / seconds


def measure(minutes: float, folder: pathlib.Path) -> None:
    """Run a class with guests, and print how its memory went."""
    seconds = 60.0 * minutes
    with ClassSite(folder, ROBOTS, page=None) as site:
        teacher = Watcher(site.base.replace("http", "ws") + "page", site.key)
        pids = {"owner": site.process.pid, "web server": site.server_pid()}
        guests: List[Guest] = []
        taken: Dict[str, List[float]] = {name: [] for name in pids}
        came = refused = 0
        begin = now = time.monotonic()
        come_at, free_at, sample_at = begin, begin, begin + WARM_UP * seconds
        while now < begin + seconds:
            now = time.monotonic()
            if now >= come_at and len(guests) < MOST_VIEWERS:
                come_at = now + COMES_EACH
                try:
                    guests.append(Guest(site, now))
                    came += 1
                except (OSError, websocket.WebSocketException):
                    refused += 1
            if now >= free_at:
                free_at = now + FREED_EACH
                teacher.line.send(json.dumps({"do": "free", "robot": random.randint(1, ROBOTS)}))
            if now >= sample_at:
                sample_at = now + SAMPLE_EACH
                for name, pid in pids.items():
                    taken[name].append(memory(pid))
            with contextlib.suppress(BlockingIOError):
                for _ in teacher.read():
                    pass
                teacher.acknowledge()
            gone = [guest for guest in guests if not guest.look(now)]
            for guest in gone:
                guest.go()
                guests.remove(guest)
            time.sleep(PERIOD)
        assert site.server_pid() == pids["web server"], "the web server has ended in between"
        print("%d guests came in %.0f min, %d were refused" % (came, minutes, refused))
        print("| process | begin, MB | end, MB | largest, MB | grows in an hour, MB |\n|---|---|---|---|---|")
        for name, values in taken.items():
            part = max(1, len(values) // 10)
            print("| %s | %.1f | %.1f | %.1f | %+.2f |" % (
                name, statistics.median(values[:part]), statistics.median(values[-part:]), max(values),
                slope(values, seconds * (1.0 - WARM_UP))))


def main(arguments: Sequence[str]) -> None:
    """Measure what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        measure(options.minutes, pathlib.Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])

#!/usr/bin/python3
"""From the hand to the wire and from the wire to the picture, in a real browser; and until zero when something dies.

    python3 bench/web.py                    # all of it, each way to die ten times: some minutes
    python3 bench/web.py --times 3          # each way to die three times
    python3 bench/web.py --only key,picture # key, picture, deaths, start

Robot, owner, web server and Chromium (headless, software rendering) are on this machine. The page's clock and the
owner's are compared by the computer's own clock. bench/web.md has the measurements, bench/page.py what many viewers
cost.
"""

import argparse
import pathlib
import random
import subprocess
import sys
import tempfile
import time
from typing import Callable, Dict, List, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[1]
for folder in ("src", "test/integration", "test/browser", "bench"):
    sys.path.insert(0, str(ROOT / folder))

from page_driver import start_browser
from real_time import until
from screencast import HAS_PICTURE, drawn_delays, note_drawn, shown_delays
from times import HEAD, row
from ways_to_die import WAYS, DrivenPage
from web_site import Site

SAMPLES = 200       # keys pressed and released, and pictures drawn
STARTS = 5


def picture(folder: pathlib.Path) -> List[str]:
    """Measure from the arrival of a packet at the client until the page has drawn it, and until the browser shows it.

    A screencast costs more than the page, so the page's own clock is read without it, and then again beside it.
    """
    with DrivenPage(folder) as page:
        note_drawn(page.driver)
        page.drive()
        drawn_delays(page.driver)
        time.sleep(SAMPLES / 10)
        alone = drawn_delays(page.driver)
        shown = shown_delays(page.driver, SAMPLES / 10)
        beside = drawn_delays(page.driver)
    return [row("packet to drawn, 1 robot, 1 viewer", alone, "25"),
            row("the same beside a screencast", beside, ""),
            row("packet to picture of the browser, by the screencast", shown, "25")]


def keys(folder: pathlib.Path) -> List[str]:
    """Measure from a key pressed until its velocity, and from its release until zero, is on the wire."""
    pressed, released = [], []
    with DrivenPage(folder) as page:
        page.drive()
        for _ in range(SAMPLES // 2):
            at = time.monotonic()
            page.key("keyUp")
            released.append(until(lambda: page.zero_since(at), "zero on the wire") - at)
            time.sleep(random.uniform(0.1, 0.3))    # a hand does not press again in the same moment
            at = time.monotonic()
            page.key("keyDown")
            pressed.append(until(lambda: page.heard.moves(at), "a velocity on the wire")[0] - at)
    return [row("key pressed to velocity on the wire", pressed, "25"),
            row("key released to zero on the wire", released, "20")]


def deaths(folder: pathlib.Path, times: int, ways: Sequence[str], lasting: float) -> List[str]:
    """Measure each way to die: the time until zero, and count velocities that came afterwards by themselves."""
    rows = []
    for name in ways:
        found = []
        for _ in range(times):
            with DrivenPage(folder) as page:
                page.drive()
                found.append(page.dies(WAYS[name], lasting))
        moved = sum(death.moves_afterwards for death in found)
        rows.append(row(name.replace("_", " "), [death.until_zero for death in found],
                        "600; %d velocities afterwards" % moved))
    return rows


def start(folder: pathlib.Path) -> List[str]:
    """Measure from the start of the program until a browser that is open already has drawn the robot."""
    found = []
    driver = start_browser()
    try:
        for _ in range(STARTS):
            began = time.monotonic()
            program = subprocess.Popen([sys.executable, "-m", "pioneer_control.web", "--port", "0"],
                                       stdout=subprocess.PIPE, universal_newlines=True, cwd=str(ROOT / "src"))
            assert program.stdout is not None
            address = program.stdout.readline().split()[-1]
            driver.get(address)
            until(lambda: driver.execute_script(HAS_PICTURE), "a picture")
            found.append(time.monotonic() - began)
            program.terminate()
            program.wait()
    finally:
        driver.quit()
    return [row("start of the page with a simulated robot to its first picture", found, "2000")]


SEEK = """
const done = arguments[1], line = document.getElementById("line"), began = performance.now();
line.value = arguments[0];
line.dispatchEvent(new Event("input"));
requestAnimationFrame(() => setTimeout(() => done(performance.now() - began)));
"""


def replay(folder: pathlib.Path, bag: str) -> List[str]:
    """Measure what a recorded run sends, and the time from the time line moved to the picture drawn."""
    with Site(folder, bag, page=None) as site:
        driver = start_browser()
        try:
            driver.set_script_timeout(20)
            driver.get("%s#%s" % (site.base, site.key))
            until(lambda: driver.execute_script("return Number(document.getElementById('line').max)"), "a recording")
            until(lambda: driver.execute_script("return document.getElementById('clock').textContent"), "a picture")
            length = driver.execute_script("return Number(document.getElementById('line').max)")
            time.sleep(1.0)     # until all columns are unpacked
            took = [driver.execute_async_script(SEEK, random.uniform(0.0, length)) / 1000 for _ in range(SAMPLES)]
        finally:
            driver.quit()
    from pioneer_control.web.recorded import read_recording
    parts = read_recording([bag], "run").parts
    robots = len(parts) - 1
    print("%s: %.0f s of %d robots; %.1f kB for each robot, %.1f kB for what was said" % (
        pathlib.Path(bag).name, length, robots, sum(map(len, parts[1:])) / robots / 1000, len(parts[0]) / 1000),
        file=sys.stderr)
    return [row("time line moved to picture drawn", took, "50")]


PARTS: Dict[str, Callable[..., List[str]]] = {"picture": picture, "key": keys, "start": start, "deaths": deaths}


def main(arguments: Sequence[str]) -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=10, help="how often each way to die (default: %(default)s)")
    parser.add_argument("--ways", default=",".join(WAYS), help="ways to die, with commas (default: %(default)s)")
    parser.add_argument("--lasting", type=float, default=0.0,
                        help="seconds for which the dead stay dead, where they come back (default: %(default)s)")
    parser.add_argument("--only", default=",".join(PARTS), help="parts, with commas: %s" % ",".join(PARTS))
    parser.add_argument("--bag", help="also measure the replay of this recorded run")
    options = parser.parse_args(arguments)
    print(HEAD)
    with tempfile.TemporaryDirectory() as folder:
        for name in filter(None, options.only.split(",")):
            measure = PARTS[name]
            more = (options.times, options.ways.split(","), options.lasting) if measure is deaths else ()
            rows = measure(pathlib.Path(folder), *more)
            print("\n".join(rows), flush=True)
        if options.bag:
            print("\n".join(replay(pathlib.Path(folder), options.bag)))


if __name__ == "__main__":
    main(sys.argv[1:])

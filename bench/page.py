#!/usr/bin/python3
"""How old is what viewers of the page see, and what do many of them cost?

    python3 bench/page.py                       # 1 and 30 robots, 1, 10, 30 and 59 viewers
    python3 bench/page.py --robots 5 --viewers 3 --seconds 60

Robots, the owner with its web server, and the viewers are processes of this machine. A viewer is a socket that reads
and acknowledges as a page does; it draws nothing. A delay is from the arrival of a robot's packet at the client library
until the viewer has read the frame. bench/page.md has the measurements.
"""

import argparse
import contextlib
import json
import os
import pathlib
import re
import secrets
import selectors
import subprocess
import sys
import tempfile
import time
from typing import Any, Dict, Iterator, List, Sequence

import websocket

SOURCE = str(pathlib.Path(__file__).resolve().parents[1] / "src")
sys.path.insert(0, SOURCE)

from pioneer_control.web.frames import read_frames, stamp_age

WARM_UP = 4.0           # s that are not measured
ACKNOWLEDGE = 0.11      # s between two acknowledgements
REPEATED = 0.05         # s: an older frame repeats an old state
ENVIRONMENT = dict(os.environ, PYTHONPATH=SOURCE)


class Watcher:
    """A viewer: a WebSocket, read without the cost of a library for each message."""

    def __init__(self, address: str, key: str) -> None:
        self.line = websocket.create_connection(address, timeout=20)
        self.line.send('{"key": "%s", "visitor": "%s"}' % (key, secrets.token_hex(16)))
        self.line.sock.setblocking(False)
        self.bytes = 0
        self.texts: Dict[str, Any] = {}     # the newest of each kind
        self._data = bytearray()
        self._told = 0.0
        self._unacknowledged = b""

    def read(self) -> Iterator[bytes]:
        """Read what is there. Yields the messages with frames."""
        received = self.line.sock.recv(2 ** 20)
        if not received:
            raise ConnectionError("the server has closed the page of a viewer")
        self._data += received
        while len(self._data) >= 2:
            length, begin = self._data[1], 2
            if length > 125:
                begin = 4 if length == 126 else 10
                if len(self._data) < begin:
                    return
                length = int.from_bytes(self._data[2:begin], "big")
            if len(self._data) < begin + length:
                return
            kind, message = self._data[0] & 15, bytes(self._data[begin:begin + length])
            del self._data[:begin + length]
            self.bytes += length
            if kind == websocket.ABNF.OPCODE_BINARY:
                self._unacknowledged = message
                yield message
            elif kind == websocket.ABNF.OPCODE_TEXT:
                self.texts.update(json.loads(message.decode()))
            elif kind == websocket.ABNF.OPCODE_PING:    # without an answer the server takes it for gone
                self._send(websocket.ABNF.OPCODE_PONG, message)

    def acknowledge(self) -> None:
        """Tell the server the newest frame that was read, if it is time to. Call this now and then: without it the
        server sends nothing more.
        """
        now = time.monotonic()
        if self._unacknowledged and now - self._told > ACKNOWLEDGE:
            self._told = now
            text = b'{"do":"drawn","stamp":%d}' % read_frames(self._unacknowledged)[-1].stamp
            self._unacknowledged = b""
            self._send(websocket.ABNF.OPCODE_TEXT, text)

    def _send(self, kind: int, message: bytes) -> None:
        self.line.sock.send(bytes((0x80 | kind, 0x80 | len(message), 0, 0, 0, 0)) + message)    # short, masked by zeros


@contextlib.contextmanager
def program(*arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """Run a program of this package in Python."""
    with subprocess.Popen([sys.executable, "-m", *arguments], stdout=subprocess.PIPE, env=ENVIRONMENT,
                          universal_newlines=True) as process:
        try:
            yield process
        finally:
            process.terminate()


def lines_until(process: "subprocess.Popen[str]", words: str) -> List[str]:
    """Return the lines that a program prints, up to one with these words."""
    assert process.stdout is not None
    lines: List[str] = []
    for line in process.stdout:
        lines.append(line)
        if words in line:
            return lines
    raise RuntimeError("the program ended early: %s" % lines)


def processor_time(pid: int) -> float:
    """Return the processor time (s) of a process until now."""
    fields = pathlib.Path("/proc/%d/stat" % pid).read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def server_of(owner: int) -> int:
    """Return the process id of the web server."""
    for pid in pathlib.Path("/proc/%d/task/%d/children" % (owner, owner)).read_text().split():
        if "web.server" in pathlib.Path("/proc/%s/cmdline" % pid).read_text():
            return int(pid)
    raise RuntimeError("there is no web server")


def measure(robots: int, viewers: int, seconds: float) -> str:
    """Run once. Returns a row of the table."""
    with contextlib.ExitStack() as stack:
        simulator = stack.enter_context(program(
            "pioneer_control.simulator", "--tcp", "0", "--robots", str(robots), "--world", "empty"))
        urls = re.findall(r"socket://\S+", "".join(lines_until(simulator, "Ctrl-C")))
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        began = time.monotonic()
        owner = stack.enter_context(program("pioneer_control.web", *urls, "--port", "0", "--folder", folder))
        base, key = lines_until(owner, "http")[0].split()[-1].split("#")
        crowd = [Watcher(base.replace("http", "ws") + "page", key) for _ in range(viewers)]
        selector = selectors.DefaultSelector()
        for watcher in crowd:
            selector.register(watcher.line.sock, selectors.EVENT_READ, watcher)
        pids = {"owner": owner.pid, "server": server_of(owner.pid), "simulator": simulator.pid}
        begin = time.monotonic() + WARM_UP
        first, delays, used = 0.0, [], {}       # type: float, List[float], Dict[str, float]
        while time.monotonic() < begin + seconds:
            if not used and time.monotonic() >= begin:
                used = {name: processor_time(pid) for name, pid in pids.items()}
                for watcher in crowd:
                    watcher.bytes = 0
            for watcher in crowd:
                watcher.acknowledge()
            for chosen, _ in selector.select(0.1):
                for message in chosen.data.read():
                    now = time.monotonic()
                    first = first or now - began
                    if used and chosen.data is crowd[0]:
                        delays += [1000 * (stamp_age(frame.stamp, now) + frame.age) for frame in read_frames(message)
                                   if frame.age < REPEATED]
        shares = [100 * (processor_time(pid) - used[name]) / seconds for name, pid in pids.items()]
        delays.sort()
        figures = [delays[int(share * (len(delays) - 1))] for share in (0.5, 0.95, 1.0)]
        rate = sum(watcher.bytes for watcher in crowd) / seconds / viewers / 1000
        return "| %d | %d | %.2f s | %.0f / %.0f / %.0f | %.1f %% | %.1f %% | %.1f %% | %.1f |" % (
            robots, viewers, first, *figures, *shares, rate)


def main(arguments: Sequence[str]) -> None:
    """Measure what the arguments say, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="*", default=[1, 30])
    parser.add_argument("--viewers", type=int, nargs="*", default=[1, 10, 30, 59])
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args(arguments)
    print("| robots | viewers | first picture | delay, ms: median / 95 % / worst | owner | server | simulator |"
          " kB/s for a viewer |\n|---|---|---|---|---|---|---|---|")
    for robots in options.robots:
        for viewers in options.viewers:
            print(measure(robots, viewers, options.seconds), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""A class as a process, with students that are programs, and what its simulator tells."""

import contextlib
import json
import os
import re
import socket
import threading

from real_time import until
from web_site import Site, Viewer


class ClassSite(Site):
    """A class as a process. ``students``: the students' key."""

    def __init__(self, folder, count, *arguments, **options):
        super().__init__(folder, "--class", str(count), *arguments, **options)
        lines = []
        while not lines or "Ctrl-C" not in lines[-1]:
            lines.append(self.process.stdout.readline())
        self.printed = "".join(lines)
        self.students = re.search(r"http://\S+#(\S+)", self.printed).group(1)

    def student(self, number, **options):
        return Viewer(self, key=self.students, visitor="student%09d" % number, **options)

    def joined(self, stack, number, name=None):
        """Return a student who has a robot, and the robot."""
        viewer = stack.enter_context(self.student(number))
        viewer.do("join", name=name or "S%d" % number)
        mine = until(lambda: (viewer.newest("mine") or {}).get("robot"), "a robot: %s" % viewer.texts[-3:])
        return viewer, mine

    @property
    def truth(self):
        """The path of the simulator's socket of the truth."""
        command = next(command for command in self.children().values() if "pioneer_control.simulator" in command)
        return re.search(r"--truth (\S+)", command).group(1)

    def memory(self):
        """Return the memory of owner and server (bytes)."""
        total = 0
        for pid in (self.process.pid, self.server_pid()):
            with open("/proc/%d/statm" % pid) as file:
                total += int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")
        return total


class TruthWatch:
    """What a simulator tells of its world on its socket of the truth: the newest state."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path)
        self.newest = None
        threading.Thread(target=self._read, daemon=True).start()
        until(lambda: self.newest, "the truth")

    def _read(self):
        with contextlib.suppress(OSError), self.socket.makefile("rb") as lines:
            for line in lines:
                self.newest = json.loads(line.decode()).get("truth", self.newest)

    def driven(self, robot):
        return self.newest["driven"][robot - 1]

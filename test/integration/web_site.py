"""The whole of the page but the browser: a simulated robot in the test's process, the owner with its web server as
processes, and viewers that are programs.
"""

import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import websocket

from pioneer_control.p2os import FrameDecoder, decode_command
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.world import load_world
from pioneer_control.web.exchange import CONFIGURE, Unpacker, packed_json
from pioneer_control.web.frames import read_frames
from pioneer_control.web.site import listen

from real_time import LIMIT, until

PERIOD = 0.05       # s between two velocities of a hand
MOVES = ("VEL", "RVEL", "VEL2")


class HeardCommands:
    """Everything that a simulated robot is told: time (monotonic, s), name and argument of each command.

    Of commands that come together each has a later time than the one before it, so that their order is known.
    """

    def __init__(self, firmware):
        self.all = []
        self._decoder, self._receive = FrameDecoder(), firmware.receive
        firmware.receive = self._take

    def _take(self, data):
        for frame in self._decoder.feed(data):
            command = decode_command(frame)
            self.all.append((time.monotonic(), command.name, command.value))
        return self._receive(data)

    def since(self, start):
        return [each for each in list(self.all) if each[0] >= start]

    def moves(self, start):
        """Return the times of commands to move, since a time."""
        return [at for at, name, value in self.since(start) if name in MOVES and value]

    def stops(self, start):
        """Return the times of commands to stand, since a time."""
        return [at for at, name, value in self.since(start) if name == "STOP" or name == "VEL" and not value]


OWNER = ("import sys; from pioneer_control.web import __main__, owner; vars(owner).update(%r); "
         "sys.exit(__main__.main())")


class Site:
    """``python3 -m pioneer_control.web`` as a process, on any free port. ``constants``: numbers of the owner that are
    others here, by their names.

    Attributes:
        process: the owner.
        base, key: the page's address, without and with its key.
    """

    def __init__(self, folder, *arguments, port=0, page="stand-in", **constants):
        if page is not None:    # else that of the package
            page = folder / "page"
            page.mkdir(exist_ok=True)
            (page / "index.html").write_text("<!doctype html><title>page</title>")
            (page / "app.js").write_text("// the page")
            (folder / "secret.txt").write_text("secret")
            arguments += "--folder", str(page)
        self.log = folder / ("log-%d" % time.monotonic_ns())
        self.began = time.monotonic()
        with open(str(self.log), "w") as log:
            self.process = subprocess.Popen(
                [sys.executable, *(["-c", OWNER % constants] if constants else ["-m", "pioneer_control.web"]), "--port",
                 str(port), *arguments],
                stdout=subprocess.PIPE, stderr=log, universal_newlines=True)
        first = self.process.stdout.readline()
        assert "http" in first, first + self.errors
        address = re.search(r"http://\S+", first).group()
        self.base, self.key = address.split("#")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(LIMIT)
        self.process.stdout.close()

    @property
    def errors(self):
        """What it wrote to standard error."""
        return self.log.read_text()

    @property
    def port(self):
        return int(self.base.rsplit(":", 1)[1].strip("/"))

    def children(self):
        """Return the ids of its child processes, with their command lines."""
        path = pathlib.Path("/proc/%d/task/%d/children" % (self.process.pid, self.process.pid))
        found = {}
        for pid in map(int, path.read_text().split()):
            with contextlib.suppress(OSError):
                found[pid] = pathlib.Path("/proc/%d/cmdline" % pid).read_text().replace("\0", " ")
        return found

    def server_pid(self):
        """Return the id of the web server; None while there is none."""
        return next((pid for pid, command in self.children().items() if "web.server" in command), None)


def is_alive(pid):
    """Return whether a process runs (a zombie does not)."""
    try:
        return pathlib.Path("/proc/%d/stat" % pid).read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@contextlib.contextmanager
def site_with_robot(folder, *arguments, model="p3dx-sh", **constants):
    """Run a robot and a site. Yields the site, the simulator's server, and the commands that the robot hears."""
    firmware = Firmware(find_model(model), load_world("empty"))
    heard = HeardCommands(firmware)
    with Server(firmware, tcp=0) as robot, Site(folder, robot.url, *arguments, **constants) as site:
        yield site, robot, heard


ALONE = "import sys; from pioneer_control.web import server; vars(server).update(%r); server.main(sys.argv[1:])"


class Alone:
    """A web server whose owner is the test. ``constants``: numbers of the server that are others here, by their names.
    """

    def __init__(self, folder, **constants):
        self.key = "k" * 20
        self.sockets = listen(["127.0.0.1"], 0)
        self.base = "http://127.0.0.1:%d/" % self.sockets[0].getsockname()[1]
        self.end, theirs = socket.socketpair()
        self.unpacker = Unpacker()
        with theirs:
            self.process = subprocess.Popen(
                [sys.executable, "-c", ALONE % constants, str(theirs.fileno()), str(self.sockets[0].fileno()),
                 str(folder)],
                pass_fds=[theirs.fileno(), self.sockets[0].fileno()])
        self.end.sendall(packed_json(CONFIGURE, {"keys": {self.key: True}, "title": "t", "hosts": ["localhost"]}))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end.close()
        self.sockets[0].close()
        try:
            self.process.wait(LIMIT)
        finally:
            self.process.kill()

    def hear(self):
        """Return the next messages of the server."""
        return self.unpacker.take(self.end.recv(65536))

    def memory(self):
        with open("/proc/%d/statm" % self.process.pid) as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


class Viewer:
    """A page that is a program: it reads on a thread of its own, and tells what it drew.

    Attributes:
        texts: all texts that came, as pairs of kind and value.
        frames: the newest frame of each robot.
        closed: the code and reason with which the server closed the connection; None while it is open.
        obeys: whether a hand that holds a key lets go and presses anew when it is told to let go.
    """

    def __init__(self, site, key=None, visitor="visitor0123456789", draws=True, reads=True, **options):
        self.texts, self.frames, self.closed = [], {}, None
        self.messages = self.bytes = 0
        self.draws = draws
        self.hand, self.obeys = None, False
        self.socket = websocket.create_connection(
            site.base.replace("http", "ws") + "page", timeout=LIMIT, enable_multithread=True, **options)
        self.send(key=site.key if key is None else key, visitor=visitor)
        self._running = True
        self._thread = threading.Thread(target=self._read, daemon=True)
        if reads:
            self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.let_go()
        self._running = False
        with contextlib.suppress(OSError, AttributeError):      # it may be closed already
            self.socket.sock.shutdown(socket.SHUT_RDWR)         # wakes the thread, other than a close
        self.socket.shutdown()
        if self._thread.is_alive():
            self._thread.join()

    def send(self, **message):
        self.socket.send(json.dumps(message))

    def do(self, do, **fields):
        self.send(do=do, **fields)

    def of(self, kind):
        """Return the values of all texts of a kind, oldest first."""
        return [value for name, value in list(self.texts) if name == kind]

    def newest(self, kind):
        values = self.of(kind)
        return values[-1] if values else None

    def said(self, words):
        """Return whether a sentence with these words came."""
        return any(words in each["text"] for each in self.of("said"))

    def picture(self, robot=1):
        """Wait for the first frame of a robot, and return the newest."""
        until(lambda: robot in self.frames, "a frame of robot %d: %s %s" % (robot, self.texts[-5:], self.closed))
        return self.frames[robot]

    def switch_motors_on(self, robot=1):
        self.picture(robot)
        self.do("motors", robot=robot, on=True)
        until(lambda: self.frames[robot].flags & 2, "motors are on: %s" % self.texts[-5:])

    def drive(self, robot=1, forward=1.0, turn=0.0, stamp=None):
        self.do("drive", robot=robot, forward=forward, turn=turn,
                stamp=self.frames[robot].stamp if stamp is None else stamp)

    def hold(self, robot=1, forward=1.0, turn=0.0):
        """Keep a hand on the keys, on a thread of its own."""
        self.hand = threading.Event()
        thread = threading.Thread(target=self._hold, args=(self.hand, robot, forward, turn), daemon=True)
        thread.start()

    def let_go(self):
        """Send no more velocities. Sends no zero either."""
        if self.hand is not None:
            self.hand.set()
            self.hand = None

    def _hold(self, gone, robot, forward, turn):
        told = 0
        while not gone.wait(PERIOD):
            before, told = told, sum("let go" in each["text"] for each in self.of("said"))
            released = self.obeys and told > before
            try:
                self.drive(robot, 0.0 if released else forward, 0.0 if released else turn)
            except (OSError, websocket.WebSocketException):
                return

    def _read(self):
        while self._running:
            try:
                code, data = self.socket.recv_data()
            except (OSError, websocket.WebSocketException):
                return
            self.messages, self.bytes = self.messages + 1, self.bytes + len(data)
            if code == websocket.ABNF.OPCODE_TEXT:
                (kind, value), = json.loads(data.decode()).items()
                self.texts.append((kind, value))
            elif code == websocket.ABNF.OPCODE_BINARY:
                frames = read_frames(data)
                self.frames.update((frame.robot, frame) for frame in frames)
                if self.draws:
                    with contextlib.suppress(OSError, websocket.WebSocketException):
                        self.do("drawn", stamp=max(frame.stamp for frame in frames))
            elif code == websocket.ABNF.OPCODE_CLOSE:
                self.closed = (int.from_bytes(data[:2], "big"), data[2:].decode())
                return


def wait_closed(viewer):
    """Wait until the server closes the connection of a viewer. Returns code and reason."""
    return until(lambda: viewer.closed, "the server closes the connection")


def signal_server(site, number):
    """Send a signal to the web server. Returns its process id, and the time just before."""
    pid, at = site.server_pid(), time.monotonic()
    os.kill(pid, number)
    return pid, at


def freeze(site):
    return signal_server(site, signal.SIGSTOP)

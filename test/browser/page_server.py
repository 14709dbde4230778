"""A stand-in for the page's server, made from docs/page-protocol.md alone: tells the page what a test wants, and keeps
what the page says.
"""

import asyncio
import json
import pathlib
import struct
import threading
import time
import zlib

import tornado.httpserver
import tornado.ioloop
import tornado.netutil
import tornado.web
import tornado.websocket

PAGE = pathlib.Path(__file__).resolve().parents[2] / "src" / "pioneer_control" / "web" / "page"
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
          "frame-ancestors 'none'; base-uri 'none'; form-action 'none'")
LIMIT = 20.0        # s: generous; nothing waits that long
PERIOD_MS = 50
SONAR = [[0.069, 0.136, 1.571], [0.114, 0.119, 0.873], [0.148, 0.078, 0.524], [0.166, 0.027, 0.175],
         [0.166, -0.027, -0.175], [0.148, -0.078, -0.524], [0.114, -0.119, -0.873], [0.069, -0.136, -1.571]]
OUTLINE = [[-0.301, -0.2125], [0.21, -0.2125], [0.21, -0.125], [0.35, -0.125], [0.35, 0.125], [0.21, 0.125],
           [0.21, 0.2125], [-0.301, 0.2125]]
WORLD = {"name": "room", "bounds": [0, 0, 6, 4], "walls": [[0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0]],
         "boxes": [[[3, 3], [4, 3], [4, 4], [3, 4]]], "posts": [[1, 3, 0.2]], "can": {"radius": 0.03}}


def until(condition, what="what was waited for"):
    """Wait until a condition holds. Returns its value."""
    end = time.monotonic() + LIMIT
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < end, "not within %g s: %s" % (LIMIT, what)
        time.sleep(0.01)


def frame_bytes(robot, stamp, age=5, x=1000, y=1000, heading=0, linear=0, angular=0, flags=0x83, gripper=0, ranges=()):
    """Return the bytes of one frame. All numbers as on the wire."""
    return struct.pack("<HIHiiHhhHBB", robot, stamp % 2 ** 32, age, x, y, heading, linear, angular, flags, gripper,
                       len(ranges)) + bytes(ranges)


def robot_info(number, **changes):
    """Return one robot of the text `robots`."""
    return dict({"robot": number, "name": "sim_%04d" % number, "model": "p3dx-sh", "where": "socket://127.0.0.1:8101",
                 "simulated": True, "outline": OUTLINE, "sonar": SONAR, "sonar_range": 5.0, "sonar_cone": 0.26,
                 "gripper": True, "max_linear": 0.5, "max_angular": 1.75, "yours": True}, **changes)


def status(number, **changes):
    """Return the value of a text `status`."""
    return dict({"robot": number, "link": "ok", "battery": {"volts": 12.6, "charge": 0.8, "level": "ok"}, "faults": [],
                 "decision": None, "counts": {"sips_per_second": 10.0, "bad_checksums": 0, "reconnects": 0}}, **changes)


def helm(number, **changes):
    """Return the value of a text `helm`."""
    return dict({"robot": number, "commander": "", "who": "", "you": False, "programs": "none", "locks": [],
                 "teacher": False, "limit": [0.2, 0.6]}, **changes)


class PageServer:
    """Serves the page and its socket on a free port of the loopback, in a thread of its own.

    While ``states`` has robots and ``silent`` is not set, it sends a frame of each, with new stamps, as real ones do.
    """

    def __init__(self):
        self.received = []
        """All messages of the page but pings and acknowledgements, with the time of their coming: (message, s)."""
        self.drawn = []
        """The stamps that the page acknowledged."""
        self.sent = {}
        """The time (s) at which each stamp was sent."""
        self.keys = []
        """The first words of each connection."""
        self.states = {}
        """Robot number -> keyword arguments of `frame_bytes`."""
        self.silent = False
        self.refuse = None
        """(code, reason) with which a new connection is closed."""
        self.greeting = []
        """The texts that each new connection gets: [(kind, value)]."""
        self.sockets = []
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        assert self._ready.wait(LIMIT)

    def _run(self):
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = tornado.ioloop.IOLoop.current()
        application = tornado.web.Application([
            (r"/page", _Socket, {"server": self}),
            (r"/(empty.html)", _Empty),
            (r"/(.*)", _Files, {"path": str(PAGE), "default_filename": "index.html"}),
        ])
        http = tornado.httpserver.HTTPServer(application)
        listening = tornado.netutil.bind_sockets(0, "127.0.0.1")
        self.port = listening[0].getsockname()[1]
        http.add_sockets(listening)
        ticking = tornado.ioloop.PeriodicCallback(self._tick, PERIOD_MS)
        ticking.start()
        self._loop.add_callback(self._ready.set)
        self._loop.start()

        async def end():
            ticking.stop()
            http.stop()
            for socket in list(self.sockets):
                socket.close()
            await http.close_all_connections()
            while len(asyncio.all_tasks()) > 1:
                await asyncio.sleep(0.01)
        self._loop.run_sync(end, timeout=LIMIT)
        self._loop.close(all_fds=True)

    def close(self):
        """End the server and its thread."""
        self._loop.add_callback(self._loop.stop)
        self._thread.join(LIMIT)

    @property
    def url(self):
        """Return the address of the page with its key."""
        return "http://127.0.0.1:%d/#secret" % self.port

    def say(self, kind, value):
        """Send a text to all viewers, and to those that come."""
        self.greeting.append((kind, value))
        self.send(json.dumps({kind: value}))

    def say_recording(self, value):
        """Send a recording to all viewers, and to those that come, compressed."""
        data = b"\x03" + zlib.compress(json.dumps(value).encode())
        self.greeting.append((None, data))
        self.send(data)

    def send(self, data):
        """Send a text or bytes to all viewers."""
        self._loop.add_callback(lambda: [socket.write_message(data, binary=isinstance(data, bytes))
                                         for socket in self.sockets])

    def hang_up(self, code=None, reason=None):
        """Close all connections."""
        self._loop.add_callback(lambda: [socket.close(code, reason) for socket in list(self.sockets)])

    def _tick(self):
        if self.states and self.sockets and not self.silent:
            now = time.monotonic()
            stamp = int(1000 * now) % 2 ** 32
            self.sent[stamp] = now
            data = b"\x01" + b"".join(frame_bytes(number, stamp, **state) for number, state in self.states.items())
            for socket in self.sockets:
                socket.write_message(data, binary=True)

    def of(self, do):
        """Return the messages of one kind that came."""
        return [message for message, _ in list(self.received) if message["do"] == do]

    def drives(self):
        """Return the drive messages as (robot, forward, turn)."""
        return [(each["robot"], each["forward"], each["turn"]) for each in self.of("drive")]


class _Socket(tornado.websocket.WebSocketHandler):
    def initialize(self, server):
        self.server = server
        self.greeted = False

    def on_message(self, text):
        message, server = json.loads(text), self.server
        if not self.greeted:
            self.greeted = True
            server.keys.append(message)
            if server.refuse:
                self.close(*server.refuse)
                return
            server.sockets.append(self)
            for kind, value in server.greeting:
                self.write_message(*((json.dumps({kind: value}),) if kind else (value, True)))
        elif message["do"] == "ping":
            self.write_message(json.dumps({"pong": message["at"]}))
        elif message["do"] == "drawn":
            server.drawn.append(message["stamp"])
        else:
            server.received.append((message, time.monotonic()))

    def on_close(self):
        if self in self.server.sockets:
            self.server.sockets.remove(self)


class _Files(tornado.web.StaticFileHandler):
    def set_default_headers(self):
        self.set_header("Content-Security-Policy", POLICY)
        self.set_header("Cache-Control", "no-store")


class _Empty(tornado.web.RequestHandler):
    """A page without anything, on which a test imports single modules."""

    def get(self, _):
        self.set_header("Content-Security-Policy", POLICY)
        self.finish("<!DOCTYPE html><title>empty</title><canvas id=canvas></canvas>")

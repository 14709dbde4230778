"""A server of robots, as a classroom has one: WebSockets that lead to a simulated robot on TCP. It is made of tornado.

A test can make it cut frames, send garbage, and close.
"""

import asyncio
import json
import struct
import threading

import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket

from real_time import LIMIT

KEY = "s3same/öffne dich"
KEY_IN_URL = "s3same/%C3%B6ffne%20dich"
REFUSAL = 4401, "this key opens no robot"


class RobotServer:
    """Serves the robot on TCP ``port`` of this machine under ``/robot/7``, in a thread of its own.

    Attributes:
        halves: whether each message to the client comes in two halves.
        heard: the bytes of each message that clients have sent, in order.
        connections: number of clients that have got the robot.
    """

    def __init__(self, port, halves=False):
        self.port = port
        self.halves = halves
        self.heard = []
        self.connections = 0
        self._started = threading.Event()
        self._clients = []
        self._thread = threading.Thread(target=self._run, name="server of robots", daemon=True)

    @property
    def url(self):
        """The URL of the robot, without its key."""
        return "ws://127.0.0.1:%d/robot/7" % self._address[1]

    def __enter__(self):
        self._thread.start()
        assert self._started.wait(LIMIT)
        return self

    def __exit__(self, *_):
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LIMIT)

    def close(self, code, reason):
        """Close the connection of each client."""
        self._loop.call_soon_threadsafe(lambda: [client.close(code, reason) for client in self._clients])

    def spoil(self, data):
        """Send bytes that are no frame to each client."""
        self._loop.call_soon_threadsafe(lambda: [client.ws_connection.stream.write(data) for client in self._clients])

    def _run(self):
        self._loop = asyncio.new_event_loop()
        asyncio.set_event_loop(self._loop)
        sockets = tornado.netutil.bind_sockets(0, "127.0.0.1")
        self._address = sockets[0].getsockname()
        server = tornado.httpserver.HTTPServer(tornado.web.Application([("/robot/7", Door, {"server": self})]))
        server.add_sockets(sockets)
        self._loop.call_soon(self._started.set)
        self._loop.run_forever()
        for client in self._clients:
            client.robot.close()
        server.stop()
        self._loop.close()


class Door(tornado.websocket.WebSocketHandler):
    """One client: first its key, then its bytes to the robot, and the robot's bytes to it."""

    def initialize(self, server):
        self.server = server
        self.robot = None

    async def on_message(self, message):
        """Take the key, or bytes for the robot."""
        if self.robot is not None:
            self.server.heard.append(message)
            self.robot.write(message)
        elif json.loads(message) == {"key": KEY}:
            reader, self.robot = await asyncio.open_connection("127.0.0.1", self.server.port)
            self.server._clients.append(self)
            self.server.connections += 1
            await self.write_message({"robot": "rosie", "lesson": 4})
            asyncio.ensure_future(self._pass_on(reader))
        else:
            self.close(*REFUSAL)

    def on_close(self):
        """Hang up on the robot."""
        if self.robot is not None:
            self.server._clients.remove(self)
            self.robot.close()

    async def _pass_on(self, reader):
        try:
            data = await reader.read(4096)
            while data:
                if self.server.halves:
                    await self._write_halves(data)
                else:
                    await self.write_message(data, binary=True)
                data = await reader.read(4096)
            self.close(4410, "the robot is gone")
        except (tornado.websocket.WebSocketClosedError, tornado.iostream.StreamClosedError):
            pass

    async def _write_halves(self, data):
        frame = b"\x82\x7e" + struct.pack("!H", len(data)) + data
        await self.ws_connection.stream.write(frame[:len(frame) // 2])
        await asyncio.sleep(0.02)       # for the client to notice; it works without, too
        await self.ws_connection.stream.write(frame[len(frame) // 2:])

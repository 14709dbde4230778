"""Lines between client and simulator. A test can spoil, cut, splice and unplug them."""

import os
import random
import select
import socket
import threading
import tty


class SpoiltLine:
    """A TCP relay to ``port``. It spoils a share of the pieces in both directions, and drops its connections on
    request.
    """

    def __init__(self, port, spoil=0.0, seed=1):
        self.spoil = spoil
        self.spoilt = 0
        self._port = port
        self._chance = random.Random(seed)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._sockets = []
        self._accepting = threading.Thread(target=self._accept, name="spoilt line", daemon=True)

    @property
    def url(self):
        return "socket://127.0.0.1:%d" % self._listener.getsockname()[1]

    def __enter__(self):
        self._accepting.start()
        return self

    def __exit__(self, *_):
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()

    def cut(self):
        """Break every connection without a farewell, as a pulled cable does."""
        while self._sockets:
            end = self._sockets.pop()
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:     # gone already
                pass
            end.close()

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:     # closed: the test is over
                return
            robot = socket.create_connection(("127.0.0.1", self._port))
            self._sockets += [client, robot]
            for source, sink in ((client, robot), (robot, client)):
                threading.Thread(target=self._relay, args=(source, sink), daemon=True).start()

    def _relay(self, source, sink):
        try:
            while True:
                data = source.recv(4096)
                if not data:
                    break
                sink.sendall(self._spoilt(data))
            sink.shutdown(socket.SHUT_WR)
        except OSError:         # cut
            return

    def _spoilt(self, data):
        if self._chance.random() >= self.spoil:
            return data
        self.spoilt += 1
        at = self._chance.randrange(len(data))
        kind = self._chance.randrange(3)
        if kind == 0:
            return data[:at] + bytes([data[at] ^ self._chance.randrange(1, 256)]) + data[at + 1:]
        if kind == 1:
            return data[:at]
        return bytes(self._chance.randrange(256) for _ in range(9)) + data[:at] + b"\xFA\xFB" + data[at:]


class Adapter:
    """A USB-serial adapter: a terminal ``device`` that leads to the robot behind TCP ``port`` until it is unplugged."""

    def __init__(self, port):
        self._port = port
        self._master, self._slave = os.openpty()    # the client's end is kept, so that no other adapter gets its name
        tty.setraw(self._slave)
        self.device = os.ttyname(self._slave)
        self._plugged = True
        self._thread = threading.Thread(target=self._relay, name="adapter", daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.unplug()
        os.close(self._slave)

    def unplug(self):
        """Remove the terminal and close its connection to the robot."""
        self._plugged = False
        self._thread.join()

    def _relay(self):
        with socket.create_connection(("127.0.0.1", self._port)) as robot:
            while self._plugged:
                ready = select.select([self._master, robot], [], [], 0.02)[0]
                if self._master in ready:
                    robot.sendall(os.read(self._master, 4096))
                if robot in ready:
                    os.write(self._master, robot.recv(4096))
        os.close(self._master)

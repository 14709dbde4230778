"""A robot with the strictest handshake there is: the vendor's simulator,
as it was measured on the wire (protocol sheet 13).

Before a session *every* packet is a step of the handshake:

* SYNC0, SYNC1, SYNC2 in this order connect. SYNC0 may be repeated.
* CLOSE is SYNC2, byte for byte. Sent first, it opens the session: the robot tells its name and streams SIPs.
  The next CLOSE makes it hang up.
* Any other packet sent first (STOP, ENABLE 0, VEL 0, ...) gets an echo of three bytes, and the handshake is dead:
  no answer until the robot hangs up at SYNC2.
* Ten packets or 10 s without a session, and the robot hangs up.

To hang up means: close the connection on TCP, wait for SYNC0 again on a pseudo-terminal. ``StrictRobot`` is sans-I/O;
``StrictServer`` puts it on TCP or on a pseudo-terminal in real time.
Nothing in here comes from the simulator of the package; packets are those of ``p2os``.
"""

import os
import select
import socket
import threading
import time
import tty

from pioneer_control import p2os

MOST_PACKETS = 10       # of a handshake
LONGEST = 10.0          # s that a handshake may take
SIP_CYCLE = 0.1         # s
TURN = 0.005            # s between two looks of the server at the clock
CONFIG = p2os.encode_packet(p2os.Config("Pioneer", "p3dx-sh", "SIM", 0, 9999, 9999, 9999, 9999, 500, "MobileSim"))


def sip(x_mm=0.0, motors=False, speed_mm_s=0):
    """Return a SIP of a robot on the x axis, without sonar readings."""
    return p2os.Sip(
        type_id=p2os.STOPPED, x_counts=round(x_mm) % p2os.COUNT_RANGE, y_counts=0, heading_units=0,
        left_velocity_units=speed_mm_s,
        right_velocity_units=speed_mm_s, battery_dv=130, left_stall_bits=p2os.StallBits(0),
        right_stall_bits=p2os.StallBits(0), control_units=0,
        flags=p2os.Flags.SONAR_1 | (p2os.Flags.MOTORS_ENABLED if motors else p2os.Flags(0)), compass=0, sonar=())


class StrictRobot:
    """One robot, sans-I/O. ``now`` is a time in s; each time it hangs up, ``hang_ups`` goes up by one.

    Args:
        tcp: whether a client that it hangs up on is not heard any more.

    Attributes:
        heard: names and values of all packets, oldest first.
        echoes: the bytes that answered a packet which came too early.
    """

    def __init__(self, tcp=True):
        self._tcp = tcp
        self.heard = []
        self.echoes = []
        self.sessions = 0
        self.hang_ups = 0
        self.open = False
        self._sent = b""
        self._decoder = p2os.FrameDecoder()
        self.new_connection(0.0)

    def new_connection(self, now):
        """Wait for SYNC0, whatever happened before."""
        self.open, self.dead, self.motors = False, False, False
        self.speed_mm_s, self.x_mm = 0, 0.0
        self._next, self._packets, self._began = 0, 0, None
        self._sip_at = now
        if self._tcp:
            self._decoder, self._sent = p2os.FrameDecoder(), b""

    @property
    def moving(self):
        """Whether its wheels turn. No watchdog stops them: the vendor's simulator only warns."""
        return self.open and self.motors and self.speed_mm_s != 0

    def receive(self, data, now):
        """Take bytes from the client."""
        hang_ups = self.hang_ups
        for frame in self._decoder.feed(data):
            if self._tcp and self.hang_ups > hang_ups:
                return
            command = p2os.decode_command(frame)
            self.heard.append((command.name, command.value))
            if self.open:
                self._obey(frame, command, now)
            else:
                self._step(frame.id, now)

    def advance(self, now):
        """Let the robot live until `now`. Returns what it has sent since the last call."""
        if not self.open and self._began is not None and now - self._began >= LONGEST:
            self._hang_up(now)
        while self.open and now >= self._sip_at:
            self._sip_at += SIP_CYCLE
            self.x_mm += self.speed_mm_s * SIP_CYCLE * self.moving
            self._send_sip()
        sent, self._sent = self._sent, b""
        return sent

    def _step(self, number, now):
        """Take one packet of a handshake."""
        self._packets += 1
        self._began = now if self._began is None else self._began
        if number == 2 and self.dead:
            self._hang_up(now)
        elif number == 2:
            self._sent += p2os.encode_packet(p2os.SyncReply("MobileSim", "Pioneer", "p3dx-sh"))
            self.open, self._sip_at = True, now
            self.sessions += 1
        elif not self.dead:
            echo = p2os.encode_frame(number)
            self._sent += echo
            if number == 0 or number == self._next:
                self._next = number + 1
            else:
                self.dead = True
                self.echoes.append(echo)
        if not self.open and self._packets >= MOST_PACKETS:
            self._hang_up(now)

    def _obey(self, frame, command, now):
        if command.name == "CLOSE":
            self._hang_up(now)
        elif command.name in ("PULSE", "OPEN"):
            self._send_sip()
        elif command.name == "ENABLE":
            self.motors = bool(command.value)
        elif command.name == "VEL":
            self.speed_mm_s = command.value
        elif command.name == "STOP":
            self.speed_mm_s = 0
        elif command.name == "CONFIG":
            self._sent += CONFIG

    def _send_sip(self):
        self._sent += p2os.encode_packet(sip(self.x_mm, self.motors, self.speed_mm_s * self.moving))

    def _hang_up(self, now):
        self.hang_ups += 1
        self.new_connection(now)


class StrictServer:
    """A strict robot in real time: on TCP, or on a pseudo-terminal whose path is the link ``pty``.

    ``lock`` guards ``robot``.
    """

    def __init__(self, pty=None, port=0):
        self.robot = StrictRobot(tcp=not pty)
        self.lock = threading.Lock()
        self.pty = pty
        self.port = port
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve_pty if pty else self._serve_tcp, name="strict robot",
                                        daemon=True)

    @property
    def url(self):
        return self.pty or "socket://127.0.0.1:%d" % self.port

    def __enter__(self):
        if self.pty:
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            if os.path.islink(self.pty):
                os.unlink(self.pty)
            os.symlink(os.ttyname(self._slave), self.pty)
        else:
            self._listener = socket.create_server(("127.0.0.1", self.port))
            self.port = self._listener.getsockname()[1]
        self._thread.start()
        return self

    def __exit__(self, *_):
        self.switch_off()

    def switch_off(self):
        """Break all connections, and remove the port. May be called twice."""
        if self._stop.is_set():
            return
        self._stop.set()
        self._thread.join()
        if self.pty:
            os.unlink(self.pty)
            os.close(self._master)
            os.close(self._slave)
        else:
            self._listener.close()

    def _serve_tcp(self):
        while not self._stop.is_set():
            if not select.select([self._listener], [], [], TURN)[0]:
                continue
            connection = self._listener.accept()[0]
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with connection:
                self._serve(connection.fileno(), until_hang_up=True)

    def _serve_pty(self):
        self._serve(self._master, until_hang_up=False)

    def _serve(self, descriptor, until_hang_up):
        """Run the robot on a line until the client is gone, or the robot hangs up."""
        with self.lock:
            self.robot.new_connection(time.monotonic())
            hang_ups = self.robot.hang_ups
        while not self._stop.is_set() and not (until_hang_up and self.robot.hang_ups > hang_ups):
            data = None
            if select.select([descriptor], [], [], TURN)[0]:
                try:
                    data = os.read(descriptor, 4096)
                except ConnectionResetError:
                    return
                if not data:
                    return
            with self.lock:
                if data:
                    self.robot.receive(data, time.monotonic())
                sent = self.robot.advance(time.monotonic())
            try:
                if sent:
                    _write(descriptor, sent)
            except (ConnectionResetError, BrokenPipeError):
                return


def _write(descriptor, data):
    """Write what the line takes. The rest is lost, as on a serial line that nobody reads."""
    try:
        os.write(descriptor, data)
    except BlockingIOError:
        pass

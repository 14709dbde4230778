"""A simulated laser and the computer's end of its line, for tests: no thread, no clock."""

import dataclasses
import math
import re
from typing import List, Optional

from pioneer_control import lms2xx
from pioneer_control.simulator.lms200 import PERFECT, FirmwareNumbers, LaserFirmware, Optics, standing
from pioneer_control.simulator.world import World

READY = FirmwareNumbers(boot=0.0)
ROOM = World("room", walls=[(-2, -3, 4, -3), (4, -3, 4, 5), (4, 5, -2, 5), (-2, 5, -2, -3)])
"""A room of 6 m by 8 m. The origin is 4 m from the wall ahead (x), 5 m from the left one, 3 m from the right one."""


def wire(text: str) -> bytes:
    """Return the bytes of a text with words such as 02 and 00x58."""
    return b"".join(bytes.fromhex(byte) * int(count or 1) for byte, count in re.findall(r"(\w\w)(?:x(\d+))?\b", text))


def to_wall(angle: float) -> float:
    """Return the distance (m) from the origin of `ROOM` to its wall in a direction (rad), by paper and pencil."""
    c, s = math.cos(angle), math.sin(angle)
    return min((4.0 if c > 0 else 2.0) / max(abs(c), 1e-12), (5.0 if s > 0 else 3.0) / max(abs(s), 1e-12))


def laser(
    numbers: FirmwareNumbers = READY, world: World = ROOM, optics=PERFECT, pose_at=standing((0.0, 0.0, 0.0)),
    seed: int = 0, **options,
) -> LaserFirmware:
    """Return a laser in the middle of a room."""
    return LaserFirmware(Optics(world, optics, seed), pose_at, numbers, seed=seed, **options)


class LaserBench:
    """One laser on the bench. A test sends it requests, lets time pass, and looks at what comes."""

    def __init__(self, **options):
        self.laser = laser(**options)
        self.heard: List = []           # messages, ACK and NAK
        self.raw = b""
        self.decoder = lms2xx.TelegramDecoder(from_laser=True)
        self.wait(0.1)
        self.began = self.take()

    def send(self, request, baud: Optional[int] = None) -> "LaserBench":
        """Send a request, or bytes."""
        self.laser.receive(request if isinstance(request, bytes) else lms2xx.encode(request), baud)
        return self

    def wait(self, seconds: float) -> "LaserBench":
        """Let time pass, and decode what comes."""
        sent = self.laser.advance(seconds)
        self.raw += sent
        self.heard += [lms2xx.decode(each) if isinstance(each, lms2xx.Telegram) else each
                       for each in self.decoder.feed(sent)]
        return self

    def take(self) -> List:
        """Return what came, and forget it."""
        heard, self.heard, self.raw = self.heard, [], b""
        return heard

    def ask(self, request, seconds: float = 1.5) -> List:
        """Return what comes after a request."""
        self.take()
        return self.send(request).wait(seconds).take()

    def ask_bytes(self, text: str, seconds: float = 1.5) -> bytes:
        """Return the bytes that come after bytes, written as text."""
        self.take()
        raw = self.send(wire(text)).wait(seconds).raw
        self.take()
        return raw

    def install(self) -> "LaserBench":
        """Change to the installation mode."""
        assert self.ask(lms2xx.SetMode(lms2xx.Mode.INSTALLATION, b"SICK_LMS")) == acked(lms2xx.ModeSet(0))
        return self

    def configure(self, **changes) -> "LaserBench":
        """Write a configuration, and change to mode ON_REQUEST."""
        wanted = dataclasses.replace(self.laser.device.eeprom.configuration, **changes)
        assert self.install().ask(lms2xx.WriteConfiguration(wanted)) == acked(lms2xx.ConfigurationWritten(1, wanted))
        return self.mode(lms2xx.Mode.ON_REQUEST)

    def mode(self, mode, parameters: bytes = b"") -> "LaserBench":
        """Change to a mode. No time passes after the reply, so nothing of a stream has come."""
        self.take()
        self.send(lms2xx.SetMode(mode, parameters))
        for _ in range(1000):
            if self.wait(0.0005).heard == acked(lms2xx.ModeSet(0)):
                self.take()
                return self
        raise AssertionError("no reply to mode %02X, but %r" % (mode, self.heard))

    def speed(self, baud: int) -> "LaserBench":
        """Change the speed."""
        self.mode(lms2xx.SPEEDS[baud].mode)
        assert self.laser.baud == baud
        return self

    def variant(self, angle: int, step: int) -> "LaserBench":
        """Change the variant."""
        assert self.ask(lms2xx.SetVariant(angle, step)) == acked(lms2xx.VariantSet(1, angle, step))
        return self

    def scan(self) -> lms2xx.RawScan:
        """Return one scan on request."""
        [ack, reply] = self.ask(lms2xx.AskScan(lms2xx.ScanPart.ALL))
        assert ack is lms2xx.Answer.ACK
        return reply.scan


def acked(*messages) -> List:
    """Return ACK and messages."""
    return [lms2xx.Answer.ACK, *messages]

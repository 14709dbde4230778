"""A simulated robot and the computer's end of its line, for tests: no thread, no clock."""

import math
from typing import List, Optional, Tuple

from pioneer_control import p2os
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.world import World
from pioneer_control.simulator.world.poses import unit


def heard(
    world: World, x: float, y: float, heading: float, half_width: float = math.radians(12.5), maximum: float = 5.0,
) -> float:
    """Return the range that one sonar transducer measures."""
    ear = world.ear(half_width, maximum)
    return ear.echo(x, y, heading, unit(heading - half_width), unit(heading + half_width))


class Bench:
    """One robot on the bench. A test sends it commands, lets time pass, and looks at the packets that it sent."""

    def __init__(
        self, model: str = "p3dx-sh", world: Optional[World] = None,
        pose: Tuple[float, float, float] = (0.0, 0.0, 0.0), **options
    ):
        options.setdefault("noise", 0.0)
        self.model = find_model(model)
        self.robot = Firmware(self.model, World("bench") if world is None else world, pose, **options)
        self.packets: List = []
        self.raw = b""
        self._decoder = p2os.FrameDecoder()

    def send(self, name: str, *values) -> "Bench":
        """Send a command."""
        self.robot.receive(p2os.encode_command(name, *values))
        return self

    def sync(self, *numbers: int) -> "Bench":
        """Send SYNC packets and read the answers."""
        for number in numbers:
            self.robot.receive(p2os.encode_frame(number))
            self.wait(0.0)
        return self

    def open(self, motors: bool = True) -> "Bench":
        """Synchronise, open a session, and enable the motors."""
        self.sync(0, 1, 2).send("OPEN")
        return self.send("ENABLE", 1) if motors else self

    def wait(self, seconds: float, alive: bool = False) -> "Bench":
        """Let time pass and decode what the robot sends. With `alive`, also feed its watchdog."""
        for share in [1.0] * int(seconds) + [seconds % 1.0] if alive else [seconds]:
            if alive:
                self.send("PULSE")
            sent = self.robot.advance(share)
            self.raw += sent
            self.packets += [p2os.decode_packet(frame, self.model.grip_state_first)
                             for frame in self._decoder.feed(sent)]
        return self

    def of(self, kind) -> List:
        """Return the packets of a class, oldest first."""
        return [packet for packet in self.packets if isinstance(packet, kind)]

    @property
    def sips(self) -> List[p2os.Sip]:
        """All SIPs so far."""
        return self.of(p2os.Sip)

    @property
    def sip(self) -> p2os.Sip:
        """The newest SIP."""
        return self.sips[-1]

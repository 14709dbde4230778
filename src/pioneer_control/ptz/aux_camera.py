"""A camera on an auxiliary port of the robot: its bytes travel inside the robot's packets (camera sheet 7).

::

    GETAUX 0                forget what came before
    TTY2 "FF 30 30 ..."     the camera's command
    GETAUX 6                six bytes, please: an error has no more, and the robot waits until all of them are there
    SERAUX                  the six bytes
    GETAUX 8                the rest, if the answer is longer
    SERAUX                  the rest
"""

from typing import Any, Dict, List, NamedTuple, Optional, Sequence

from ..client import RobotIdentity
from ..p2os import SerialAux, encode_command
from ..vcc4 import SHORTEST_ANSWER, encode_camera_command
from .session import CameraSession

MOST_REQUESTS = 2
"""How often bytes are requested for one answer: for its first bytes, and for its rest."""
BAUD_9600 = 0
"""The code of the camera's line speed in the robot's commands."""


class AuxPortCommands(NamedTuple):
    """The robot's commands for one of its auxiliary ports."""

    send: str
    want: str
    baud: str


AUX_PORTS: Dict[int, AuxPortCommands] = {
    1: AuxPortCommands("TTY2", "GETAUX", "AUX1BAUD"),
    2: AuxPortCommands("TTY3", "GETAUX2", "AUX2BAUD"),
    3: AuxPortCommands("TTY4", "GETAUX3", "AUX3BAUD"),
}
"""The auxiliary ports by their numbers."""


def aux_port_of(port: str) -> Optional[int]:
    """Return the number of the auxiliary port that a text names (``aux1`` to ``aux3``). None if it names none."""
    return {"aux%d" % number: number for number in AUX_PORTS}.get(port)


class AuxCamera:
    """A camera as a `client.line_devices.LineDevice`.

    Args:
        session: what is said to the camera.
        port: number of the auxiliary port, 1 to 3.
    """

    def __init__(self, session: CameraSession, port: int) -> None:
        self.session = session
        self._port, self._commands = port, AUX_PORTS[port]
        self._to_send: List[bytes] = []
        self._requests = 0      # of bytes, for the present answer

    @property
    def due(self) -> float:
        """Time (s) by which `tick` must be called."""
        return self.session.due

    @property
    def stops(self) -> Sequence[bytes]:
        """The packet that stops pan and tilt."""
        return (encode_command(self._commands.send, encode_camera_command("STOP")),)

    @property
    def ended(self) -> bool:
        """Whether the camera needs the line no more, after `end`."""
        return self.session.ended

    def connected(self, identity: RobotIdentity, now: float) -> None:
        """Begin: the robot is connected, for the first time or once more."""
        self._to_send = [encode_command(self._commands.baud, BAUD_9600)]
        self.session.line_up(now)

    def disconnected(self, now: float) -> None:
        """Forget what waits for an answer: there is no link to the robot."""
        self._to_send = []
        self.session.line_down("there is no link to the robot")

    def packet(self, packet: Any, now: float) -> None:
        """Take a packet of the robot. One with bytes of this port is the camera's."""
        if not isinstance(packet, SerialAux) or packet.port != self._port:
            return
        self.session.receive(packet.data, now)
        missing = 0 if self.session.has_output else self.session.answer_missing
        if missing and self._requests < MOST_REQUESTS:
            self._want(missing)

    def tick(self, now: float) -> None:
        """Do what is due."""
        self.session.tick(now)

    def end(self, now: float) -> None:
        """Bring the camera to rest, because the connection ends soon."""
        self.session.end(now)

    def take_commands(self) -> List[bytes]:
        """Return the robot's packets to send now, and forget them."""
        for exchange in self.session.take_output():
            if exchange.is_answered:
                self._to_send.append(encode_command(self._commands.want, 0))
            self._to_send.append(encode_command(self._commands.send, exchange.data))
            if exchange.is_answered:
                self._requests = 0
                self._want(SHORTEST_ANSWER)
        commands, self._to_send = self._to_send, []
        return commands

    def _want(self, count: int) -> None:
        self._requests += 1
        self._to_send.append(encode_command(self._commands.want, count))

"""Requests for packets that a robot sends only when it is asked. They arrive as PacketReceived events.

A robot acknowledges no request. So the client repeats a request for packets a few times, until packets come. It repeats
a request to stop packets as long as packets still come. A robot never sends packets of a device that it does not have.
This is no error. CLOSE ends all requests.

Source: protocol sheet 3.2.
"""

import math
from typing import AbstractSet, Dict, NamedTuple

from .. import p2os
from .gyro import is_for_client
from .identity import RobotIdentity
from .line import Line

TRIES = 3               # requests for packets that do not come
AGAIN = 0.5             # s between two requests: five SIP cycles, because on a slow line the SIP is sent first


class DataKind(NamedTuple):
    """One kind of packet, and the command that requests it. Its value ``on`` starts the packets, ``off`` stops them."""

    command: str
    on: int
    off: int
    packet: type


DATA: Dict[str, DataKind] = {
    "io": DataKind("IOREQUEST", 2, 0, p2os.IO),
    "gyro": DataKind("GYRO", 1, 0, p2os.Gyro),
    "encoder": DataKind("ENCODER", 2, 0, p2os.Encoder),
    "battery": DataKind("BATTERYINFO", 2, 0, p2os.BatteryInfo),
    "gripper": DataKind("GRIPREQUEST", 2, 0, p2os.Gripper),
    "joystick": DataKind("JOYREQUEST", 2, 0, p2os.Joystick),
    "compass": DataKind("TCM2", 3, 1, p2os.TCM2),       # 1: only in the SIP
    "arm": DataKind("ARM_STATUS", 2, 0, p2os.Arm),
}
KINDS = {data.packet: kind for kind, data in DATA.items()}


class DataRequests:
    """Requests the wanted packets from one connected robot. ``now`` is monotonic time in s."""

    def __init__(self, line: Line, identity: RobotIdentity) -> None:
        self._line = line
        self._identity = identity
        self._wanted: Dict[str, bool] = {}
        self._asked_at: Dict[str, float] = {}
        self._tries = dict.fromkeys(DATA, 0)        # requests that are left, for packets that have not come yet

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""
        if not any(self._tries.values()):       # nearly always
            return math.inf
        return min(self._asked_at[kind] for kind, left in self._tries.items() if left) + AGAIN

    def want(self, kinds: AbstractSet[str], now: float) -> None:
        """Ask for packets of these kinds with every SIP, and stop packets of all other kinds. The kinds are in DATA.

        "gyro" has no effect unless the robot has a gyro that the client has to read.
        """
        for kind in DATA:
            on = kind in kinds
            if self._wanted.get(kind, False) != on and (kind != "gyro" or is_for_client(self._identity)):
                self._wanted[kind] = on
                self._tries[kind] = TRIES if on else 0
                self._ask(kind, now)

    def saw(self, packet: object, now: float) -> None:
        """Take a received packet. If it is wanted, end its request. If it is not wanted any more, ask to stop it."""
        kind = KINDS.get(type(packet))
        if kind is not None:
            self._tries[kind] = 0
            if self._wanted.get(kind) is False and now >= self._asked_at[kind] + AGAIN:
                self._ask(kind, now)

    def tick(self, now: float) -> None:
        """Repeat the requests for packets that have not come."""
        for kind, left in self._tries.items():
            if left and now >= self._asked_at[kind] + AGAIN:
                self._ask(kind, now)

    def _ask(self, kind: str, now: float) -> None:
        self._asked_at[kind] = now
        if not self._line.full:     # if it is full, tick() tries again after AGAIN
            self._tries[kind] = max(0, self._tries[kind] - 1)
            data = DATA[kind]
            self._line.command(now, p2os.encode_command(data.command, data.on if self._wanted[kind] else data.off))

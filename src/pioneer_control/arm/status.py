"""What a status packet of the arm (ARMpac) means. Its first two bytes come in two layouts (arm sheet 13).

Layout M is that of the manuals. Layout A is what the vendor's own client reads. No packet says which one it has: the
first packet that makes sense in only one of them tells it.
"""

from typing import NamedTuple, Optional, Tuple

from .. import p2os

SERVOS = 6
LAYOUTS = "A", "M"
M_POWERED, M_LINKED = 1, 2
A_GOOD, A_INITIALISED, A_POWERED, A_HOMING = 1, 2, 4, 8
SERVO_BITS = (1 << SERVOS) - 1
"""The bits of a byte that has one for each servo."""


class ArmStatus(NamedTuple):
    """The status of the arm, whatever the layout of its packet."""

    linked: bool
    """Whether the arm's own controller answers its server. If not, its switch may be off, or it needs ARM_INIT."""
    powered: bool
    """Whether the servos have power."""
    homing: bool
    """Whether the arm goes home with all joints. Only layout A says so."""
    moving: Tuple[bool, ...]
    """Whether each servo moves."""
    ticks: Tuple[int, ...]
    """Position to which each servo was stepped. Without power the server believes that all are at home."""


class StatusReader:
    """Reads status packets, and finds out their layout.

    Args:
        layout: "A" or "M"; None to find it out.

    Attributes:
        layout: as the argument, or as it was found out. None as long as it is not known.
        contradicted: whether the last packet makes sense only in the other layout.
    """

    def __init__(self, layout: Optional[str] = None) -> None:
        self.layout = layout
        self.contradicted = False

    def read(self, packet: p2os.Arm) -> Optional[ArmStatus]:
        """Return what a packet means; None if it can mean two things, and no packet before has told the layout."""
        seen = layout_of(packet)
        if self.layout is None:
            self.layout = seen
        self.contradicted = seen not in (None, self.layout)
        if self.layout is None and (packet.status_bits or packet.motion_bits):
            return None
        first, second = packet.status_bits, packet.motion_bits
        if self.layout == "M":
            return ArmStatus(bool(first & M_LINKED), bool(first & M_POWERED), False, _bits(second), packet.positions)
        linked = second & A_GOOD and second & A_INITIALISED
        return ArmStatus(bool(linked), bool(second & A_POWERED), bool(second & A_HOMING), _bits(first),
                         packet.positions)


def layout_of(packet: p2os.Arm) -> Optional[str]:
    """Return the only layout in which a packet makes sense: "A" or "M". None if both do, or none.

    Nothing moves without power in either layout, and there is no power without a link.
    """
    first, second = packet.status_bits, packet.motion_bits
    can_be_m = first in (0, M_LINKED, M_LINKED | M_POWERED) and second <= SERVO_BITS and (
        not second or bool(first & M_POWERED))
    can_be_a = first <= SERVO_BITS and second <= (A_GOOD | A_INITIALISED | A_POWERED | A_HOMING) and (
        bool(second & A_POWERED) or not first and not second & A_HOMING) and (
        not second & A_POWERED or bool(second & A_GOOD))
    if can_be_m == can_be_a:
        return None
    return "M" if can_be_m else "A"


def _bits(byte: int) -> Tuple[bool, ...]:
    return tuple(bool(byte >> joint & 1) for joint in range(SERVOS))

"""Gripper commands, and gripper readings from the SIP (protocol 6).

Every SIP has a state byte of the gripper, and its switches as digital inputs. Two kinds of gripper are different. The
gripper of a Pioneer 1 has one motor and other switches. A gripper on the general I/O port of a P2OS robot does not use
the digital inputs: its switches come in a GRIPPERpac, which the client has to request.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Optional, Tuple

from ..errors import UsageError
from ..p2os import GRIPPER_VALUES, DigitalIn, GripperCommand, GripperSwitches, GripState, encode_command
from .identity import RobotIdentity

ON_GENERAL_IO = 2       # value of has_gripper in CONFIGpac and in GRIPPERpac


@dataclass(frozen=True)
class GripperReading:
    """State of the paddles, the lift and the switches in one SIP. A field is True when its name describes the state.

    Paddles that are neither open nor closed are in between. A lift that is neither up nor down is in between. A beam is
    True when something breaks it. A contact is True when its paddle presses on something.
    """

    paddles_open: bool
    paddles_closed: bool
    paddles_moving: bool
    paddles_error: bool
    lift_up: bool
    lift_down: bool
    lift_moving: bool
    lift_error: bool
    inner_beam: bool
    outer_beam: bool
    left_contact: bool
    right_contact: bool


@lru_cache(maxsize=256)
def read_gripper(grip_state: int, digital_in: int) -> GripperReading:
    """Return the reading from the bytes GRIP_STATE and DIGIN of a SIP.

    In DIGIN a beam is 1 when it is broken, and a contact is 0 when it is pressed (Gripper manual).
    """
    state, inputs = GripState(grip_state), DigitalIn(digital_in)
    # Two end positions exclude each other: both at once means that the position is unknown (protocol 6.2).
    paddles, lift = state & (GripState.OPEN | GripState.CLOSED), state & (GripState.LIFT_UP | GripState.LIFT_DOWN)
    return GripperReading(
        paddles_open=paddles == GripState.OPEN,
        paddles_closed=paddles == GripState.CLOSED,
        paddles_moving=bool(state & GripState.MOVING),
        paddles_error=bool(state & GripState.ERROR),
        lift_up=lift == GripState.LIFT_UP,
        lift_down=lift == GripState.LIFT_DOWN,
        lift_moving=bool(state & GripState.LIFT_MOVING),
        lift_error=bool(state & GripState.LIFT_ERROR),
        inner_beam=bool(inputs & DigitalIn.INNER_BEAM_BROKEN),
        outer_beam=bool(inputs & DigitalIn.OUTER_BEAM_BROKEN),
        left_contact=not inputs & DigitalIn.LEFT_CONTACT_FREE,
        right_contact=not inputs & DigitalIn.RIGHT_CONTACT_FREE,
    )


def read_pioneer_1_gripper(digital_in: int) -> GripperReading:
    """Return the reading from the byte DIGIN of a Pioneer 1 (protocol 6.4).

    Its one motor opens the paddles at the bottom. It reports neither motion nor errors: these fields are False.
    """
    at_top, closed, opened, touching = (not digital_in & bit for bit in (1, 2, 4, 32))
    return GripperReading(
        paddles_open=opened,
        paddles_closed=(closed or at_top) and not opened,
        paddles_moving=False,
        paddles_error=False,
        lift_up=at_top and not opened,
        lift_down=opened,
        lift_moving=False,
        lift_error=False,
        inner_beam=bool(digital_in & 8),
        outer_beam=bool(digital_in & 16),
        left_contact=touching,
        right_contact=touching,
    )


def is_on_general_io(identity: RobotIdentity) -> bool:
    """Return whether the switches of the gripper come in GRIPPERpac instead of in the digital inputs.

    Only P2OS means this by has_gripper 2. In AROS and ARCOS the number 2 means the gripper of a PeopleBot.
    """
    config = identity.config
    return config is not None and config.has_gripper == ON_GENERAL_IO and not identity.model.grip_state_first


def with_switches(reading: GripperReading, switches: GripperSwitches) -> GripperReading:
    """Return ``reading`` with its beams and contacts taken from the GRIPPERpac of P2OS (protocol 6.3)."""
    return replace(
        reading,
        inner_beam=bool(switches & GripperSwitches.INNER_BEAM),
        outer_beam=bool(switches & GripperSwitches.OUTER_BEAM),
        left_contact=not switches & GripperSwitches.LEFT_CONTACT_FREE,
        right_contact=not switches & GripperSwitches.RIGHT_CONTACT_FREE,
    )


def gripper_packets(command: GripperCommand, value: Optional[int]) -> Tuple[bytes, ...]:
    """Return the packets of one gripper command, with its value (units of 20 ms) if the command needs a value.

    Raises UsageError for an unknown command, and for a value that is missing, out of range or not allowed.
    """
    try:
        command = GripperCommand(command)
    except ValueError:
        raise UsageError("gripper command %r means nothing; legal: %s" % (
            command, ", ".join("%d %s" % (member, member.name) for member in GripperCommand))) from None
    if command not in GRIPPER_VALUES:
        if value is not None:
            raise UsageError("gripper command %s takes no value" % command.name)
        return (encode_command("GRIPPER", int(command)),)
    low, high = GRIPPER_VALUES[command]
    if value is None or not low <= value <= high or not value:
        raise UsageError("gripper command %s needs a value in %d..%d (units of 20 ms), not 0; got %r"
                         % (command.name, low, high, value))
    return encode_command("GRIPPER", int(command)), encode_command("GRIPPERVAL", value)

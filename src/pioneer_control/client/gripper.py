"""The gripper as the robot reports it in every SIP: its own state byte and the switches on the digital inputs (protocol 6.2, 6.4)."""

from dataclasses import dataclass

from ..p2os import DigitalIn, GripState


@dataclass(frozen=True)
class GripperReading:
    """Paddles, lift and switches of one SIP; every field True when the thing named is so.

    Neither open nor closed, or neither up nor down: in between. A beam is True when something breaks it, a contact when its paddle
    presses on something.
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


def read_gripper(grip_state: int, digital_in: int) -> GripperReading:
    """Read the GRIP_STATE byte and DIGIN; beams read 1 when broken, contacts 0 when pressed (Gripper manual)."""
    state, inputs = GripState(grip_state), DigitalIn(digital_in)
    paddles = _one_of(bool(state & GripState.OPEN), bool(state & GripState.CLOSED))
    lift = _one_of(bool(state & GripState.LIFT_UP), bool(state & GripState.LIFT_DOWN))
    return GripperReading(
        paddles_open=paddles[0],
        paddles_closed=paddles[1],
        paddles_moving=bool(state & GripState.MOVING),
        paddles_error=bool(state & GripState.ERROR),
        lift_up=lift[0],
        lift_down=lift[1],
        lift_moving=bool(state & GripState.LIFT_MOVING),
        lift_error=bool(state & GripState.LIFT_ERROR),
        inner_beam=bool(inputs & DigitalIn.INNER_BEAM_BROKEN),
        outer_beam=bool(inputs & DigitalIn.OUTER_BEAM_BROKEN),
        left_contact=not inputs & DigitalIn.LEFT_CONTACT_FREE,
        right_contact=not inputs & DigitalIn.RIGHT_CONTACT_FREE,
    )


def _one_of(first: bool, second: bool):
    """Two end positions exclude each other: both at once means the position is unknown (protocol 6.2)."""
    return (first and not second, second and not first)

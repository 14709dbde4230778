"""What a Pioneer has besides wheels, sonar and gripper: a loudspeaker, outputs, a port for a joystick, a charger.

Source: protocol sheet 3.3.
"""

import math
from time import monotonic
from typing import Callable, Sequence, Tuple

from ..errors import NotConfirmedError, RefusedError, UsageError
from ..p2os import ChargeState, Flags, encode_command, knows
from .identity import RobotIdentity
from .robot import Robot
from .state import RobotState

NOTE_UNIT = 0.02            # s, of the length of a note
LONGEST_NOTE = 255 * NOTE_UNIT
MOST_NOTES = 20
SAY_BEHIND = 4
"""Number of commands that wait for the line at which notes are refused. 20 notes take 50 ms at 9600 baud."""
GRIPPER_OUTPUTS = 0x0F
"""The digital outputs that drive a gripper on the user I/O port: paddles and lift, each with its direction (protocol
sheet 6.4). They are left alone on every robot with a gripper, for firmware does not tell for sure where it is.
"""
CHARGING = frozenset(ChargeState) - {ChargeState.NOT_CHARGING, ChargeState.UNKNOWN}
ANSWER_WITHIN = 3
"""How many states after a command to wait until a state shows its effect. Then the command is sent again."""

Note = Tuple[float, int]
"""How long a note sounds (s, 0.02 to 5.1, in steps of 0.02), and its tone (0 to 255). AROS and later: 0 is a rest, 1 to
127 are the notes of MIDI (69 is 440 Hz), 128 to 255 are (tone - 127) * 32 Hz. Older firmware: half periods.
"""


def say_packet(notes: Sequence[Note]) -> bytes:
    """Return the packet that plays notes. Raises UsageError when there are none or too many, or one is not legal."""
    if not 1 <= len(notes) <= MOST_NOTES:
        raise UsageError("there are %d notes (legal: 1 to %d)" % (len(notes), MOST_NOTES))
    pairs = []
    for place, (length, tone) in enumerate(notes):
        if not (math.isfinite(length) and 0.99 * NOTE_UNIT <= length <= 1.001 * LONGEST_NOTE):
            raise UsageError("note %d lasts %s s (legal: %g to %g)" % (place, length, NOTE_UNIT, LONGEST_NOTE))
        if not (isinstance(tone, int) and 0 <= tone <= 255):
            raise UsageError("note %d has tone %r (legal: 0 to 255)" % (place, tone))
        pairs += [round(length / NOTE_UNIT), tone]
    return encode_command("SAY", bytes(pairs))


def has_power(state: RobotState) -> bool:
    """Return whether a state of the robot shows the power of a charger."""
    return bool(state.flags & Flags.CHARGER_POWER) or state.charge_state in CHARGING


def repeat_until(robot: Robot, command: Callable[[], None], shows: Callable[[RobotState], bool], timeout: float,
                 told: str) -> None:
    """Give a command, and give it again, until a state of the robot shows its effect.

    Raises NotConfirmedError, which says what the robot was ``told``, after ``timeout`` s.
    """
    give_up_at = monotonic() + timeout
    while monotonic() < give_up_at:
        command()
        if any(shows(robot.wait_for_state()) for _ in range(ANSWER_WITHIN)):
            return
    raise NotConfirmedError("%s, the robot did not show it within %g s" % (told, timeout))


class Accessories:
    """The accessories of one robot. Any thread may call any method.

    Every method raises LinkError without a link, and RefusedError when the firmware does not know the command.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    def say(self, notes: Sequence[Note]) -> None:
        """Play notes.

        Raises:
            UsageError: a note is not legal.
            RefusedError: other commands wait for the line. Notes are long, and a stop of a device waits behind them.
        """
        packet = say_packet(notes)
        self._check_known("SAY")
        with self._robot.using() as (connected, now):
            if connected.waiting >= SAY_BEHIND:
                raise RefusedError("the line is too slow for so many notes: %d commands wait already"
                                   % connected.waiting)
            connected.command(now, packet)

    def set_outputs(self, mask: int, states: int, timeout: float) -> None:
        """Set the digital outputs whose bits are 1 in ``mask`` (0 to 255) to their bits in ``states`` (0 to 255).

        The command is repeated until the robot shows it.

        Raises:
            UsageError: mask or states are not legal, or a state has no bit in the mask.
            RefusedError: an output of the mask drives the gripper.
            NotConfirmedError: the robot does not show it within ``timeout`` s.
        """
        for name, value in (("mask", mask), ("states", states)):
            if not 0 <= value <= 0xFF:
                raise UsageError("%s is %d (legal: 0 to 255)" % (name, value))
        if states & ~mask:
            raise UsageError("states 0x%02x has bits that mask 0x%02x has not" % (states, mask))
        taken = mask & GRIPPER_OUTPUTS
        if taken and self._identity.has_gripper:
            raise RefusedError("the outputs 0x%02x drive the gripper: use gripper_control" % taken)
        self._until(encode_command("DIGOUT", mask, states),
                    lambda state: ((state.digital_out or 0) ^ states) & mask == 0, timeout,
                    "told to set outputs 0x%02x to 0x%02x" % (mask, states))

    def allow_joystick(self, on: bool) -> None:
        """Let a joystick at the robot's own port drive it, or end that.

        It ends with every velocity and every stop that the robot is told, and with the connection. No packet shows
        whether the robot obeys.

        Raises:
            RefusedError: the robot moves, or its motors are off.
        """
        self._check_known("JOYDRIVE")
        with self._robot.using() as (connected, now):
            if on and not connected.drive.at_rest:
                raise RefusedError("the robot moves: ask again when it stands")
            state = self._robot.state
            if on and state is not None and not state.motors_enabled:
                raise RefusedError("the motors are off: switch them on first")
            connected.drive.allow_joystick(on, now)

    def dock(self, timeout: float) -> None:
        """Let the robot take power in the dock in which it stands. Without power after ``timeout`` s it lets go again.

        Raises:
            RefusedError: see check_dock().
            NotConfirmedError: there is no power.
        """
        self.check_dock()
        try:
            self._until(encode_command("CHARGE", 1), has_power, timeout, "told to take power from the dock")
        except NotConfirmedError as error:
            self._robot.send(encode_command("CHARGE", 0))
            raise NotConfirmedError("%s: it lets go again; does it stand in the dock?" % error) from None

    def check_dock(self) -> None:
        """Check that the robot can dock now. Raises RefusedError when it has no charger for docks, or moves."""
        self._check_charger()
        state = self._robot.state
        if state is not None and state.moving:
            raise RefusedError("the robot moves: dock when it stands in the dock")

    def undock(self, timeout: float) -> None:
        """Let the robot let go of its dock.

        Raises:
            RefusedError: the robot has no charger for docks.
            NotConfirmedError: the robot still shows power after ``timeout`` s.
        """
        self._check_charger()
        self._until(encode_command("CHARGE", 0), lambda state: not has_power(state), timeout,
                    "told to let go of the dock")

    @property
    def may_be_docked(self) -> bool:
        """Whether a robot with a charger for docks has power, as far as it has told: it is in a dock, or somebody has
        plugged a charger in. This needs no link, and raises nothing."""
        identity, state = self._robot.identity, self._robot.state
        config = None if identity is None else identity.config
        return config is not None and bool(config.charger) and state is not None and has_power(state)

    @property
    def _identity(self) -> RobotIdentity:
        with self._robot.using() as (connected, _):     # raises when there is no link
            return connected.identity

    def _check_known(self, command: str) -> None:
        family = self._identity.model.firmware_family
        if not knows(family, command):
            raise RefusedError("%s firmware does not know %s" % (family, command))

    def _check_charger(self) -> None:
        self._check_known("CHARGE")
        config = self._identity.config
        if config is None or not config.charger:
            raise RefusedError("the robot reports no charger for docks (CONFIGpac)")

    def _until(self, packet: bytes, shows: Callable[[RobotState], bool], timeout: float, told: str) -> None:
        repeat_until(self._robot, lambda: self._robot.send(packet), shows, timeout, told)

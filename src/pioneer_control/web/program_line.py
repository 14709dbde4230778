"""The robot's side of the line to a program that shares its robot with persons. Sans-I/O: bytes and time in, bytes out.

A robot has one connection, and the owner has it. A program on another computer speaks P2OS over a WebSocket with this
object, which looks to it like the robot itself: it shakes hands, gets every packet of the robot as it is, and its
commands go through the helm. So a person at the page goes before it, and it cannot do what others would feel later:

=================================================  =============================================================
command                                            what becomes of it
=================================================  =============================================================
SYNC0, SYNC1, SYNC2, OPEN, CLOSE, PULSE            the session of this program, here
VEL, RVEL, VEL2, STOP, E_STOP                      through the helm; renewed for as long as the program is heard
ENABLE                                             through the helm. A program sees the motors on only when it has
                                                   asked for them in this session
GRIPPER, GRIPPERVAL                                through the helm
SONAR                                              obeyed, and taken back at the end of the session
CONFIG                                             answered with what the robot said when the owner connected
data requests, DIGOUT, SAY, sounds                 passed on
all others (settings, MOVE, HEAD, RESET, ...)      refused, and said to the person
=================================================  =============================================================

What a real robot does after a silence of WATCHDOG s, this does, too: it stops. When the connection ends, it stops at
once.
"""

import math
from dataclasses import replace
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from .. import p2os
from ..client import Robot, SteeredRobot
from ..errors import PioneerError
from ..p2os import Flags, Frame, GripperCommand, ReceivedCommand

INPUT = "program"
"""The name of programs as an input of the helm."""
WATCHDOG = 2.0
"""Time (s) without a packet of the program after which the robot stops."""
RENEW = 0.2
"""Time (s) between two renewals of a velocity."""
PASSED_ON = frozenset((
    "JOYREQUEST", "ENCODER", "IMUREQUEST", "GRIPREQUEST", "IOREQUEST", "BATTERYINFO", "PLAYLIST", "DIGOUT", "ADSEL",
    "SAY", "SOUND", "SOUNDTOG", "GYRO"))
"""Commands that reach the robot as they are: requests for data, outputs and sounds."""


class Wanted(NamedTuple):
    """The velocities that the program set last. A robot keeps them until others come."""

    linear_mm_s: int = 0
    turn_deg_s: int = 0
    wheels: Optional[Tuple[int, int]] = None
    """Left and right in units of VEL2, when VEL2 came last."""

    @property
    def stands(self) -> bool:
        """Whether the robot is to stand."""
        return not any(self.wheels if self.wheels is not None else (self.linear_mm_s, self.turn_deg_s))


STAND = Wanted()


class ProgramLine:
    """The line to one program, from its connection to its end.

    Args:
        robot: the robot, for what moves nothing.
        steered: the same robot, for what moves it.
        who: who the program belongs to, for people.
        say: called with a sentence for people when something is refused.

    Attributes:
        is_open: whether the program has a session: it gets the robot's packets.
    """

    def __init__(self, robot: Robot, steered: SteeredRobot, who: str = "",
                 say: Callable[[str], None] = lambda sentence: None) -> None:
        self._robot, self._steered, self._who, self._say = robot, steered, who, say
        self._decoder = p2os.FrameDecoder()
        self._next_sync = p2os.SYNC0
        self._named = self.is_open = False
        self._motors = self._sonar_off = False
        self._grip_value: Optional[int] = None
        self._config = b""
        self._wanted, self._changed = STAND, False
        self._heard_at = self._renew_at = -math.inf
        self._out: List[bytes] = []
        # What each command does, by its name. The argument is its number; None without one.
        self._do: Dict[str, Callable[[Optional[int]], None]] = {
            "PULSE": lambda _: None, "OPEN": self._open, "CLOSE": self._close, "CONFIG": self._tell_config,
            "VEL": lambda mm_s: self._want(Wanted(mm_s or 0, self._wanted.turn_deg_s)),
            "RVEL": lambda deg_s: self._want(Wanted(self._wanted.linear_mm_s, deg_s or 0)),
            "VEL2": self._want_wheels, "STOP": self._stop, "E_STOP": self._stop, "ENABLE": self._enable,
            "SONAR": self._switch_sonar, "GRIPPER": self._move_gripper, "GRIPPERVAL": self._take_grip_value,
        }

    def data_to_send(self) -> bytes:
        """Return the bytes for the program, and forget them."""
        data, self._out = b"".join(self._out), []
        return data

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes of the program (monotonic time, s). It never raises for what they say."""
        for frame in self._decoder.feed(data):
            self._heard_at = now
            if self._named:
                self._obey(p2os.decode_command(frame), frame)
            else:
                self._shake_hands(frame)
        if self._changed:
            self._renew(now)

    def report(self, frame: Frame) -> None:
        """Take a packet of the robot, and pass it on to a program with a session."""
        packet = p2os.decode_packet(frame)
        if isinstance(packet, p2os.Config):
            self._config = p2os.encode_frame(frame.id, frame.data)
        if not self.is_open:
            return
        if isinstance(packet, p2os.Sip):
            if not self._motors:
                packet = replace(packet, flags=packet.flags & ~Flags.MOTORS_ENABLED)
            elif not packet.flags & Flags.MOTORS_ENABLED and packet.flags & Flags.STOP_BUTTON:
                self._motors = False        # as on the robot itself: to be asked for anew
            self._out.append(p2os.encode_packet(packet))
        else:
            self._out.append(p2os.encode_frame(frame.id, frame.data))

    def tick(self, now: float) -> None:
        """Renew the velocity of a program that is heard, and stop the robot of one that is not."""
        if self._wanted.stands:
            return
        if now >= self._heard_at + WATCHDOG:
            self._say("the program has not been heard for %.0f s: the robot stops" % WATCHDOG)
            self.halt()
        elif now >= self._renew_at:
            self._renew(now)

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""
        return math.inf if self._wanted.stands else min(self._renew_at, self._heard_at + WATCHDOG)

    def halt(self) -> None:
        """Stop what this program drives, if it drives something. It may command anew."""
        if not self._wanted.stands:
            self._wanted, self._changed = STAND, False
            try:
                self._steered.set_velocity(INPUT, 0.0, 0.0, self._who)
            except PioneerError:    # a person has the helm, or there is no link: nothing of this program's goes on
                pass

    def end(self) -> None:
        """The connection of the program is gone: stop at once what it drives, and take back what it switched."""
        self._end_session()
        self._named = False

    # Before a session

    def _shake_hands(self, frame: Frame) -> None:
        """Answer a packet of the handshake. One that is out of order begins it anew, as on a robot (protocol 2.2)."""
        identity = self._robot.identity
        if identity is None or not self._robot.ready:
            return      # the robot itself is not there: silence says so
        if frame.id != self._next_sync:
            self._next_sync = p2os.SYNC0
        if frame.id != self._next_sync:
            return
        if frame.id != p2os.SYNC2:
            self._out.append(p2os.encode_packet(p2os.SyncEcho(frame.id)))
            self._next_sync += 1
        else:
            self._out.append(p2os.encode_packet(p2os.SyncReply(identity.name, identity.type, identity.subtype)))
            self._next_sync, self._named = p2os.SYNC0, True

    # In a session

    def _obey(self, command: ReceivedCommand, frame: Frame) -> None:
        try:
            if command.name in self._do:
                self._do[command.name](command.value if isinstance(command.value, int) else None)
            elif command.name in PASSED_ON and self.is_open:
                self._robot.send(p2os.encode_frame(frame.id, frame.data))
            else:
                self._say("%s refused: a program that shares a robot may not do that" % command.name)
        except PioneerError as error:
            self._say(str(error))

    def _open(self, _: Optional[int]) -> None:
        self.is_open, self._motors, self._wanted = True, False, STAND

    def _close(self, _: Optional[int]) -> None:
        self._end_session()
        self._named = False

    def _tell_config(self, _: Optional[int]) -> None:
        if self._config:
            self._out.append(self._config)
        else:
            self._robot.send(p2os.encode_command("CONFIG", 1))

    def _want(self, wanted: Wanted) -> None:
        # A client that stands says STOP as a sign of life: that is no command of a program that drives.
        if self.is_open and not (wanted.stands and self._wanted.stands):
            self._wanted, self._changed = wanted, True

    def _want_wheels(self, value: Optional[int]) -> None:
        if value is not None:
            left, right = p2os.two_bytes(value)
            self._want(Wanted(wheels=(left, right)))

    def _stop(self, _: Optional[int]) -> None:
        self._want(STAND)

    def _enable(self, on: Optional[int]) -> None:
        if not self.is_open:
            return
        if on:
            self._steered.request_motors(True)
            self._motors = True
        else:
            self._motors_off()

    def _motors_off(self) -> None:
        """Forget that this program asked for motors. They go off, unless a person has the helm now."""
        asked, self._motors = self._motors, False
        if asked and not self._steered.state().holder:
            self._steered.request_motors(False)

    def _switch_sonar(self, on: Optional[int]) -> None:
        if self.is_open and self._robot.use_sonar != bool(on):
            self._robot.set_sonar(bool(on))
            self._sonar_off = not on

    def _take_grip_value(self, value: Optional[int]) -> None:
        self._grip_value = value

    def _move_gripper(self, number: Optional[int]) -> None:
        if not self.is_open:
            return
        value, self._grip_value = self._grip_value, None
        try:
            order = GripperCommand(number or 0)
        except ValueError:
            self._say("GRIPPER %s refused: it is no command" % number)
            return
        needs_value = order in p2os.GRIPPER_VALUES
        stops = order in (GripperCommand.STOP, GripperCommand.LIFT_STOP, GripperCommand.HALT)
        self._steered.move_gripper(INPUT, [(order, value if needs_value else None)], stops, self._who)

    def _renew(self, now: float) -> None:
        """Tell the helm what the program wants. A velocity that it refuses is forgotten: the program must set it anew.
        """
        wanted, self._changed, self._renew_at = self._wanted, False, now + RENEW
        identity = self._robot.identity
        try:
            if wanted.wheels is not None and identity is not None:
                unit = identity.model.vel2_mm_s_per_unit / 1000
                self._steered.set_wheel_velocities(INPUT, wanted.wheels[0] * unit, wanted.wheels[1] * unit, self._who)
            else:
                self._steered.set_velocity(INPUT, wanted.linear_mm_s / 1000, math.radians(wanted.turn_deg_s), self._who)
        except PioneerError as error:
            if not wanted.stands:
                self._say(str(error))
            self._wanted = STAND

    def _end_session(self) -> None:
        self.halt()
        try:
            self._motors_off()
            if self._sonar_off:
                self._robot.set_sonar(True)
        except PioneerError:        # no link: each connection begins with motors off and sonar on
            pass
        self.is_open = self._sonar_off = False

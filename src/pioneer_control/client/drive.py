"""Velocities, the dead man and the motors of a connected robot.

A robot acknowledges no command. So each command is repeated until the robot's SIPs show that it was obeyed.
"""

import math
from typing import List, Optional, Tuple

from ..errors import NotConfirmedError, PioneerError, RefusedError, UsageError
from ..p2os import encode_command
from .events import CommandTimedOut, Event, MotionCleared, MotorsAnswered, Unmoved
from .identity import RobotIdentity
from .line import Companion, Line
from .state import RobotState
from .velocities import BodyVelocity, Velocity, WheelVelocities

TAKE_BACK = 2.0             # s for the robot to show that its motors are off, after a request for them has failed
REFRESH = 0.2               # s between two repetitions of a command
MOVES_WITHIN = 2.0          # s after a velocity in which a robot moves, if nothing holds it
SURE_TO_MOVE = 0.05         # m/s or rad/s: at a lower speed friction may hold the robot
# s that a SIP travels at 9600 baud. A SIP that arrives within this time after a command left the robot before the robot
# heard the command.
UNDER_WAY = 0.1

STOP_BUTTON = "motors stay off: the STOP button is pressed; release it and ask again"
ZERO_VELOCITY = (encode_command("VEL", 0), encode_command("RVEL", 0))
STOP = (encode_command("STOP"),) + ZERO_VELOCITY
JOYDRIVE = {on: encode_command("JOYDRIVE", int(on)) for on in (False, True)}
NO_JOYSTICK = (JOYDRIVE[False],) * 3
"""Three times, because no packet shows whether the robot heard it."""
MOTORS = {on: encode_command("ENABLE", int(on)) for on in (False, True)}


class MotorsRequest:
    """A request to switch the motors on or off. It is ``done`` when a SIP shows the result, or when it has failed.

    Args:
        on: True to switch the motors on, False to switch them off.
        now: time of the request (monotonic, s).
        timeout: time (s) after which the request fails.
        changes: whether the newest SIP shows the motors in the other state; True without any SIP.
        asked: whether the user made the request; False when Drive made it.

    Attributes:
        error: why the request failed; None while it is open, and when it has succeeded.
    """

    def __init__(self, on: bool, now: float, timeout: float, changes: bool, asked: bool) -> None:
        self.on, self.changes, self.asked = on, changes, asked
        self.asked_at = now         # when ENABLE was sent last
        self.answer_from = now + UNDER_WAY
        self.give_up_at = now + timeout
        self.error: Optional[PioneerError] = None
        self.done = False


class Drive:
    """Sends velocities, stops and motor commands to one connected robot. ``now`` is monotonic time in s.

    Args:
        line: sends the packets.
        identity: has the velocity limits.
        command_timeout: the robot is stopped so many seconds after the last velocity command.
        events: the list to which Drive appends its events.
        companion: returns packets that are sent together with each velocity.

    Attributes:
        command_timeout: see Args; it may be changed.
        wanted: the newest velocity: linear (m/s) and angular (rad/s), or left and right wheel (m/s). None while the
            robot is to stand.
        joystick: whether a joystick at the robot's own port may drive it. Then a robot that moves though no velocity is
            wanted is not stopped. Every velocity and every stop ends it.
    """

    def __init__(self, line: Line, identity: RobotIdentity, command_timeout: float, events: List[Event],
                 companion: Companion) -> None:
        self._line = line
        self._companion = companion
        self.command_timeout = command_timeout
        self._events = events
        self._body = BodyVelocity(identity)
        self._wheels = WheelVelocities(identity)
        self._driven: Velocity = self._body     # _body or _wheels: the newest velocity is given for this one
        self.wanted: Optional[Tuple[float, float]] = None
        self._commanded_at = self._sent_at = 0.0
        self._good_for = math.inf   # s, of the newest velocity; command_timeout when that is shorter
        self.joystick = False
        self._stopping = False      # whether a stop was sent, and no SIP has shown yet that the robot stands
        self._motors: Optional[MotorsRequest] = None
        self._state: Optional[RobotState] = None
        self._excused_at = 0.0      # when the robot last moved, or had a reason to stand
        self._unmoved = False       # whether Unmoved was reported, and the robot has not moved since

    @property
    def at_rest(self) -> bool:
        """Whether the robot is to stand, and a SIP has shown since then that it stands."""
        return self.wanted is None and not self._stopping

    @property
    def due(self) -> float:
        """Time (monotonic, s) by which tick() must be called; infinity when nothing is due."""
        due = self._sent_at + REFRESH if self.wanted is not None or self._stopping else math.inf
        if self.wanted is not None:
            due = min(due, self._expires_at)
        if self._motors is not None:
            due = min(due, self._motors.asked_at + REFRESH, self._motors.give_up_at)
        return due

    def set_velocity(self, linear: float, angular: float, now: float, timeout: float = math.inf) -> None:
        """Drive at these velocities (m/s forward, rad/s counter-clockwise) until command_timeout, or ``timeout`` (s).

        The shorter time counts. The velocities are clamped to the limits. Raises UsageError when a velocity is not a
        finite number. Then nothing changes.
        """
        self._want(self._body, (linear, angular), now, timeout)

    def set_wheel_velocities(self, left: float, right: float, now: float, timeout: float = math.inf) -> None:
        """Drive the wheels at these velocities (m/s, forward positive) until command_timeout, or ``timeout`` (s).

        Beyond a limit both velocities are made smaller by the same factor, so that the curve stays. Raises UsageError
        when a velocity is not a finite number. Then nothing changes.
        """
        self._want(self._wheels, (left, right), now, timeout)

    def follow(self, identity: RobotIdentity) -> None:
        """Use the limits of this new identity from now on."""
        self._body.follow(identity)
        self._wheels.follow(identity)

    def stop(self, now: float, packets: Tuple[bytes, ...] = STOP) -> None:
        """Send these stop packets ahead of everything else. Repeat a stop until the SIPs show that the robot stands."""
        self._driven.rest(now)
        self.wanted, self._stopping, self._sent_at = None, True, now
        self._line.stop(now, *packets)
        self._end_joystick(now)

    def allow_joystick(self, on: bool, now: float) -> None:
        """Let a joystick at the robot's own port drive it, or end that and stop the robot. Allow it only at rest."""
        if on:
            self.joystick = True
            self._line.command(now, JOYDRIVE[True])
        else:
            self.joystick = True        # also when a joystick was allowed by somebody else
            self.stop(now)

    def request_motors(self, on: bool, now: float, timeout: float) -> MotorsRequest:
        """Ask the robot to switch its motors on or off. The request fails after ``timeout`` s.

        The robot is stopped first, unless its motors are on already and are to stay on. An open request for the
        opposite fails. An open request for the same is returned again and keeps its own time-out. Otherwise requests
        that are repeated fast would never time out.

        Returns:
            The request. Its ``done`` and ``error`` show the result.
        """
        if self._motors is not None and self._motors.on != on:
            self._answer_motors(self._motors, NotConfirmedError("overtaken by another motor command"))
        request = self._motors = self._motors or MotorsRequest(
            on, now, timeout, changes=self._state is None or self._state.motors_enabled != on, asked=True)
        request.asked = True
        if not (on and self._state is not None and self._state.motors_enabled):
            self.stop(now)
        if on and self._state is not None and self._state.stop_button:
            self._answer_motors(request, RefusedError(STOP_BUTTON))
        else:
            self._send_motors(request, now)
        return request

    def saw(self, state: RobotState) -> None:
        """Take a new state of the robot, and compare it with what was commanded."""
        now, before, self._state = state.time, self._state, state
        # Each SIP counts, also after one that showed a standing robot: a velocity may reach the robot late.
        if self.wanted is None and now > self._sent_at:
            self._stopping = state.moving and not self.joystick
        asked_off = self._motors is not None and not self._motors.on
        if before is not None and before.motors_enabled and not state.motors_enabled and not asked_off:
            self._events.append(MotionCleared(
                "the STOP button is pressed" if state.stop_button else "the robot switched its motors off"))
            self.stop(now)
        if self._motors is not None:
            self._judge_motors(self._motors, state)
        self._judge_motion(now, state)

    def tick(self, now: float) -> None:
        """Repeat commands, stop the robot after command_timeout, and let a motor request fail after its time-out."""
        if self.wanted is not None and now >= self._expires_at:
            self._events.append(CommandTimedOut(now - self._commanded_at))
            self.stop(now)
        elif self.wanted is not None and now >= self._sent_at + REFRESH:
            self._send_velocity(now)
        elif self._stopping and now >= self._sent_at + REFRESH:
            self.stop(now)
        if self._motors is not None:
            if now >= self._motors.give_up_at:
                self._give_up_motors(self._motors, now)
            elif now >= self._motors.asked_at + REFRESH:
                self._send_motors(self._motors, now)

    def abandon(self, error: PioneerError) -> None:
        """Let an open motor request fail with this error, because the link is gone."""
        if self._motors is not None:
            self._answer_motors(self._motors, error)

    @property
    def _expires_at(self) -> float:
        """Time (monotonic, s) at which the newest velocity is too old."""
        return self._commanded_at + min(self._good_for, self.command_timeout)

    def _want(self, driven: Velocity, wanted: Tuple[float, float], now: float, timeout: float) -> None:
        if not (math.isfinite(wanted[0]) and math.isfinite(wanted[1])):
            raise UsageError("velocities are %r and %r; finite numbers are needed" % wanted)
        if wanted == (0, 0):
            self.stop(now, ZERO_VELOCITY)
        else:
            self._end_joystick(now)
            if driven is not self._driven:
                self._driven.rest(now)
            self._driven, self.wanted, self._commanded_at, self._good_for = driven, wanted, now, timeout
            self._stopping = False
            self._send_velocity(now)

    def _end_joystick(self, now: float) -> None:
        if self.joystick:
            self.joystick = False
            self._line.command(now, *NO_JOYSTICK)

    def _send_velocity(self, now: float) -> None:
        assert self.wanted is not None
        self._sent_at = now
        self._line.velocity(now, *self._driven.packets(*self.wanted, now),
                            until=self._expires_at, companion=self._companion)

    def _send_motors(self, request: MotorsRequest, now: float) -> None:
        request.asked_at = now
        if not self._line.full:     # if it is full, tick() tries again after REFRESH
            self._line.command(now, MOTORS[request.on])

    def _judge_motors(self, request: MotorsRequest, state: RobotState) -> None:
        """Finish the motor request when the flags of a SIP show the result.

        The flags count only in a SIP that the robot sent after it received the request (UNDER_WAY). A pressed STOP
        button counts at once: a request for motors on fails.
        """
        if request.on and state.stop_button:
            self._answer_motors(request, RefusedError(STOP_BUTTON))
            self._take_back(state.time)
        elif state.time > request.answer_from and state.motors_enabled == request.on:
            self._answer_motors(request)

    def _judge_motion(self, now: float, state: RobotState) -> None:
        """Append the event Unmoved when the robot stands for MOVES_WITHIN s although a velocity is commanded.

        The time does not run while the motors are off, a wheel is stalled, or the velocity is below SURE_TO_MOVE. The
        event comes again only after the robot has moved.
        """
        self._unmoved = self._unmoved and not state.moving
        if (state.moving or self.wanted is None or all(abs(rate) < SURE_TO_MOVE for rate in self.wanted)
                or not state.motors_enabled or state.left_stall or state.right_stall):
            self._excused_at = now
        elif now > self._excused_at + MOVES_WITHIN and not self._unmoved:
            self._unmoved = True
            self._events.append(Unmoved(now - self._excused_at))

    def _give_up_motors(self, request: MotorsRequest, now: float) -> None:
        stalled = self._state is not None and (self._state.left_stall or self._state.right_stall)
        self._answer_motors(request, NotConfirmedError(
            "asked to switch its motors %s, the robot did not confirm it in time%s" % (
                "on" if request.on else "off", ": it is stalled, something holds its wheels" if stalled else "")))
        if request.on:
            self._take_back(now)

    def _answer_motors(self, request: MotorsRequest, error: Optional[PioneerError] = None) -> None:
        """Finish a motor request, and append MotorsAnswered if the user made it. Without ``error`` it has succeeded.

        If the request was for motors on, an ENABLE 1 that still waits for the line is not sent any more.
        """
        request.error, request.done = error, True
        if self._motors is request:
            self._motors = None
        if request.asked:
            self._events.append(MotorsAnswered(request.on, request.changes, error))
        if request.on:
            self._line.withdraw(MOTORS[True])

    def _take_back(self, now: float) -> None:
        """Switch the motors off after a request for motors on has failed: the robot may obey the ENABLE 1 late.

        ENABLE 0 may get lost, too. So this makes a new motor request, which repeats it.
        """
        self._motors = MotorsRequest(False, now, TAKE_BACK, changes=True, asked=False)
        self._send_motors(self._motors, now)

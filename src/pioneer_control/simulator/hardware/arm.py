"""The Pioneer Arm: six servos, and the arm's server in the robot that steps them (arm sheet 12 to 17).

Positions are in ticks of the servos. The servos measure nothing: the server only knows where it has stepped them, and
believes that they are at home while they have no power. This file does not depend on packets. What no source says is
our choice; the sheet marks it, too.
"""

from typing import List, Optional, Sequence

from .robot_numbers import ArmNumbers

KINDS_OF_ARMS = ("pioneer_arm",)
"""Arms that the command line and the ROS node know."""
GRIPPER = 5
"""Index of the joint that is the gripper."""
TICK_LINE_US = 2000
"""Time (microseconds) that the line to the servos needs for one tick of one servo. Sheet 14."""
INIT_US, CHECK_US = 700000, 200000
"""How long a reset takes, and a check (microseconds). Meanwhile the server obeys no command of the arm. Sheet 14."""
GRIPPER_OPEN = 10
"""A gripper no farther from its home than this (ticks) counts as open. Our choice."""
SPEEDS = range(1, 128)
"""Legal speeds: ms per tick. Sheet 14."""


class Servo:
    """One joint.

    Attributes:
        home, minimum, centre, maximum: positions (ticks) in the arm's memory.
        ticks_per_90: number of ticks of a quarter turn.
        speed_ms: time of one tick (ms).
        position: position (ticks) to which the server has stepped the servo.
        goal: position (ticks) to which the server steps it.
    """

    def __init__(self, numbers: ArmNumbers, joint: int) -> None:
        self._standard_speed_ms = numbers.speed_ms[joint]
        self.home, self.minimum = numbers.home[joint], numbers.minimum[joint]
        self.centre, self.maximum = numbers.centre[joint], numbers.maximum[joint]
        self.ticks_per_90 = numbers.ticks_per_90_deg[joint]
        self.reset()

    def reset(self) -> None:
        """Take speed and position from the arm's memory."""
        self.speed_ms = self._standard_speed_ms
        self.rest_at_home()

    def rest_at_home(self) -> None:
        """Take that the servo is at home, and let it stand there."""
        self.position = self.goal = self.home
        self._pace_us = 0
        self._waited_us = 0

    @property
    def moving(self) -> bool:
        """Whether the server steps the servo."""
        return self.position != self.goal

    def go(self, goal: int, speed_ms: Optional[int] = None) -> None:
        """Begin to move to `goal` (ticks), clipped to the range, at `speed_ms` per tick or at the servo's own speed."""
        if not self.moving:
            self._waited_us = 0
        self.goal = max(self.minimum, min(self.maximum, goal))
        self._pace_us = 1000 * (speed_ms or 0)

    def stop(self) -> None:
        """Stand still."""
        self.goal = self.position

    def step(self, passed_us: int, fastest_us: int) -> None:
        """Let time pass (microseconds). A tick takes no less than `fastest_us`."""
        if self.moving:
            pace_us = max(fastest_us, self._pace_us or 1000 * self.speed_ms)
            self._waited_us += passed_us
            ticks = min(self._waited_us // pace_us, abs(self.goal - self.position))
            self._waited_us -= ticks * pace_us
            self.position += ticks if self.goal > self.position else -ticks


class PioneerArm:
    """The arm of a robot, with its server.

    Args:
        numbers: parameters of the arm.

    Attributes:
        numbers: as the argument.
        servos: the six joints, from the base to the gripper.
        switched_on: whether the switch of the arm is on.
        linked: whether the arm's own controller answers the server.
        powered: whether the servos have power.
        homing: whether the arm goes home with all joints.
        parking: whether the arm goes home, to be switched off there.
        drops: how often the servos lost their power away from home, since the start. The arm falls down then.
        jumps: how often the servos got power after that. The arm jumps home then, as fast as it can.
    """

    device_name = "an arm"

    def __init__(self, numbers: ArmNumbers) -> None:
        self.numbers = numbers
        self.servos = [Servo(numbers, joint) for joint in range(6)]
        self.powered = self.parking = self.homing = False
        self.drops = self.jumps = 0
        self._fallen = False
        self.switched_on = True
        self._now_us = 0
        self.restart()

    def restart(self) -> None:
        """Restart the server with its robot: it takes that the arm is at home, without power."""
        self.cut_power()
        self.linked = self.numbers.linked_at_power_on and self.switched_on
        self._busy_until_us, self._initialising = 0, False
        self._autopark_us = 1000000 * self.numbers.autopark_s
        self._grippark_us = 1000000 * self.numbers.grippark_s
        self._commanded_us = self._opened_us = self._now_us
        for servo in self.servos:
            servo.reset()

    @property
    def moving(self) -> List[bool]:
        """Whether each joint moves."""
        return [servo.moving for servo in self.servos]

    # -- what happens to it

    def switch(self, on: bool) -> None:
        """Turn the switch of the arm. Off: the servos lose their power and the server its arm, until `init`."""
        self.switched_on = on
        if not on:
            self.linked = False
            self.cut_power()

    def cut_power(self) -> None:
        """Take the power from the servos where they are. The server takes that they are at home from then on."""
        if self.powered and any(servo.position != servo.home for servo in self.servos):
            self.drops += 1
            self._fallen = True
        self.powered = self.parking = self.homing = False
        for servo in self.servos:
            servo.rest_at_home()

    def step(self, now_us: int) -> None:
        """Let time pass until `now_us` (simulated time, microseconds)."""
        passed_us, self._now_us = now_us - self._now_us, now_us
        if self._initialising and now_us >= self._busy_until_us:
            self._initialising = False
            self.linked = self.switched_on
        if not self.powered:
            return
        fastest_us = TICK_LINE_US * sum(self.moving)
        for servo in self.servos:
            servo.step(passed_us, fastest_us)
        if self.homing and not any(self.moving):
            self.homing = False
            if self.parking:
                self._rest()
                return
        self._watch_timers()

    def _rest(self) -> None:
        """Switch the servos off at home."""
        self.cut_power()
        self._fallen = False

    def _watch_timers(self) -> None:
        gripper = self.servos[GRIPPER]
        if abs(gripper.position - gripper.home) <= GRIPPER_OPEN:
            self._opened_us = self._now_us
        elif self._grippark_us and self._now_us - self._opened_us >= self._grippark_us and not gripper.moving:
            gripper.go(gripper.home)
        if self._autopark_us and self._now_us - self._commanded_us >= self._autopark_us and not self.parking:
            self.go_park()

    # -- commands. None of them does anything during a reset or a check.

    def init(self) -> None:
        """Execute command ARM_INIT: drop everything, and find the arm's own controller anew."""
        if self._obeys():
            self.cut_power()
            for servo in self.servos:
                servo.reset()
            self.linked, self._initialising, self._busy_until_us = False, True, self._now_us + INIT_US

    def check(self) -> None:
        """Execute command ARM_CHECK: see whether the arm's own controller answers."""
        if self._obeys():
            self._busy_until_us = self._now_us + CHECK_US

    def power(self, on: bool) -> None:
        """Execute command ARM_POWER. On: the servos jump to where the server believes them. Off: the arm falls down."""
        if not self._obeys():
            return
        if not on:
            self.cut_power()
        elif self.linked and not self.powered:
            self.powered = True
            self.jumps += self._fallen
            self._fallen = False
            self._opened_us = self._now_us

    def go_home(self, joints: Sequence[int]) -> None:
        """Execute command ARM_HOME for joints (indices). One moves at its own speed, several at a safe one."""
        safe_ms = self.numbers.safe_speed_ms if len(joints) > 1 else None
        if self._obeys() and self.powered:
            self.parking = False
            self.homing = len(joints) > 1
            for joint in joints:
                self.servos[joint].go(self.servos[joint].home, safe_ms)

    def go_park(self) -> None:
        """Execute command ARM_PARK: go home, and switch the servos off there."""
        self.go_home(range(6))
        self.parking = self.powered and self.homing

    def move(self, joint: int, goal: int) -> None:
        """Execute command ARM_POS for a joint (index): begin to move to `goal` (ticks), within its range."""
        if self._obeys() and self.powered:
            self.parking = self.homing = False
            self.servos[joint].go(goal)

    def set_speed(self, joint: int, speed_ms: int) -> None:
        """Execute command ARM_SPEED for a joint (index): `speed_ms` for one tick, clipped to `SPEEDS`."""
        if self._obeys():
            self.servos[joint].speed_ms = max(SPEEDS[0], min(SPEEDS[-1], speed_ms))

    def stop(self, joints: Sequence[int]) -> None:
        """Execute command ARM_STOP for joints (indices): stand still, with power."""
        if self._obeys(during_check=True):
            self.parking = self.homing = False
            for joint in joints:
                self.servos[joint].stop()

    def set_autopark(self, seconds: int) -> None:
        """Execute command ARM_AUTOPARK: park after so many seconds without a command. 0: never."""
        if self._obeys():
            self._autopark_us = 1000000 * seconds

    def set_grippark(self, seconds: int) -> None:
        """Execute command ARM_GRIPPARK: open a gripper that was closed for so many seconds. 0: never."""
        if self._obeys():
            self._grippark_us = 1000000 * seconds

    def close_session(self) -> None:
        """Take that the client ends its session: park, and set the timers to their power-on values."""
        self._busy_until_us = self._now_us
        if not self._initialising:
            self.go_park()
        self._autopark_us = 1000000 * self.numbers.autopark_s
        self._grippark_us = 1000000 * self.numbers.grippark_s

    def _obeys(self, during_check: bool = False) -> bool:
        """Return whether the server obeys a command now, which also begins the time of autopark anew."""
        if self._initialising or self._now_us < self._busy_until_us and not during_check:
            return False
        self._commanded_us = self._now_us
        return True

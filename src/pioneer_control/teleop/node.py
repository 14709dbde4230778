"""The program that drives a robot by hand: ``rosrun pioneer_control drive [ROBOT] [--gamepad DEVICE] [--speed M_S]``.

It publishes on ``teleop/cmd_vel`` while the hand is on a key or on the gamepad, and one zero when the hand lets go. The
driver stops the robot when nothing comes for ``teleop_timeout``: so a terminal that is closed, stopped or cut off, or
this program killed, means that the robot stands.
"""

import argparse
import contextlib
import os
import select
import signal
import sys
import termios
import tty
from time import monotonic
from typing import Any, Dict, Iterator, List, Optional

import rospy
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from ..errors import PioneerError
from ..message_values import GripCommand, LiftCommand
from ..msg import BatteryState, GripperState, GripState, Helm, LiftState, MotorState, RobotInfo
from ..ros_node import init_node, name_for
from .gamepad import Gamepad, find
from .hand import FIRST_PRESS, SLOW, STAND, KeyHand, Limit, Wish
from .keys import ACTIONS, DRIVE, HELP, Keyboard

PERIOD = 0.1
"""Time (s) between two publications of the same velocity."""
SHOWN = 0.2
"""Time (s) between two updates of the line on the screen."""
STOPS = 3
"""How often the zero is published at the end, because the process may end before rospy has sent one."""

GRIPPER = {
    "open": (GripCommand.OPEN, 0), "close": (GripCommand.CLOSE, 0),
    "up": (0, LiftCommand.UP), "down": (0, LiftCommand.DOWN),
}
"""The actions of the gripper: the commands to paddles and lift; 0 leaves a part alone."""


class Talk:
    """The topics of one robot: what it is told, and the newest of what it tells.

    Args:
        robot: the namespace of the robot.
    """

    def __init__(self, robot: str) -> None:
        self.robot = robot
        self.news: Dict[type, Any] = {}
        self._velocity = rospy.Publisher(robot + "/teleop/cmd_vel", Twist, queue_size=1, tcp_nodelay=True)
        self._lock = rospy.Publisher(robot + "/stop_all", Bool, queue_size=1, tcp_nodelay=True)
        self._motors = rospy.Publisher(robot + "/cmd_motor_state", MotorState, queue_size=1)
        self._gripper = rospy.Publisher(robot + "/teleop/gripper_control", GripperState, queue_size=1)
        self._release = rospy.ServiceProxy(robot + "/teleop/release", Trigger)
        for topic, kind in (("helm", Helm), ("motor_state", MotorState), ("pose", Odometry), ("robot_info", RobotInfo),
                            ("battery_state", BatteryState)):
            rospy.Subscriber("%s/%s" % (robot, topic), kind, self._hear, kind, queue_size=1)

    def _hear(self, message: Any, kind: type) -> None:
        self.news[kind] = message

    @property
    def listened(self) -> bool:
        """Whether a driver listens."""
        return bool(self._velocity.get_num_connections())

    def drive(self, linear: float, angular: float) -> None:
        """Publish a velocity (m/s, rad/s)."""
        publish(self._velocity, Twist(linear=Vector3(x=linear), angular=Vector3(z=angular)))

    def act(self, action: str) -> str:
        """Do what a key or a button says, by the name of the action. Return what there is to say about it."""
        if action in ("stop", "unlock"):
            publish(self._lock, action == "stop")
        elif action in ("motors_on", "motors_off"):
            publish(self._motors, MotorState(state=int(action == "motors_on")))
        elif action in GRIPPER:
            grip, lift = GRIPPER[action]
            publish(self._gripper, GripperState(grip=GripState(state=grip), lift=LiftState(state=lift)))
        else:
            try:
                return str(self._release().message)
            except (rospy.ServiceException, rospy.ROSException) as error:
                return "the helm is not released: %s" % error
        return ""


def publish(publisher: Any, message: Any) -> None:
    """Publish a message. Do nothing when ROS, which shuts down in another thread, has just closed the topic."""
    try:
        publisher.publish(message)
    except rospy.ROSException:
        if not rospy.core.is_shutdown_requested():
            raise


class HandDrive:
    """Hands, limit and robot together. `run` loops until ROS shuts down.

    Args:
        talk: the robot.
        gamepad: the gamepad. None without one.
        speed: the limit at the start (m/s).
        screen: where to write the line with the state.

    Attributes:
        drove: whether it has published any velocity.
    """

    def __init__(self, talk: Talk, gamepad: Optional[Gamepad], speed: float, screen: Any = sys.stdout) -> None:
        self._talk = talk
        self._gamepad = gamepad
        self._limit = Limit(speed)
        self._screen = screen
        self._keyboard, self._keys = Keyboard(), KeyHand()
        self.drove = self._moving = False
        self._remark = ""
        self._publish_at = self._show_at = 0.0

    def run(self, terminal: Optional[int]) -> None:
        """Drive until ROS shuts down, or there is nothing left to drive with.

        Args:
            terminal: the file descriptor of a terminal that tells each key. None without a terminal.
        """
        while not rospy.is_shutdown() and (terminal is not None or self._gamepad is not None):
            files: List[Any] = [each for each in (terminal, self._gamepad) if each is not None]
            ready, _, _ = select.select(files, [], [], PERIOD / 2)
            now, before = monotonic(), self.wish(monotonic())
            if self._gamepad in ready:
                self._hear_gamepad(now)
            if terminal is not None and terminal in ready and not self._hear_terminal(os.read(terminal, 4096), now):
                terminal = None
            self.step(now, self.wish(now) != before)

    def wish(self, now: float) -> Wish:
        """Return what the hands want now: the keys go before the gamepad."""
        by_keys = self._keys.wish(now)
        return by_keys if by_keys != STAND or self._gamepad is None else self._gamepad.hand.wish(now)

    def step(self, now: float, at_once: bool = False) -> None:
        """Publish the velocity that the hands want, if it is time; and one zero when they let go. Update the screen."""
        wish = self.wish(now)
        if wish != STAND and (at_once or now >= self._publish_at):
            self._talk.drive(*self._limit.velocity(wish))
            self.drove = self._moving = True
            self._publish_at = now + PERIOD
        elif wish == STAND and self._moving:
            self._talk.drive(0.0, 0.0)
            self._moving = False
        if now >= self._show_at:
            self._show_at = now + SHOWN
            self._show(wish)

    def let_go(self) -> None:
        """Let go of everything: nothing that was pressed before counts."""
        self._keys.let_go()
        if self._gamepad is not None:
            self._gamepad.hand.let_go()

    def act(self, action: str) -> None:
        """Do what a key or a button says, by the name of the action. It lets go of the keys that drive."""
        self._keys.let_go()
        if action in ("faster", "slower"):
            self._limit.change(1 if action == "faster" else -1)
            return
        if action == "stop":
            self.let_go()
            self._talk.drive(0.0, 0.0)
            self._moving = False
        self._remark = self._talk.act(action)

    def press(self, key: str, now: float) -> None:
        """Take one key. A key without a meaning lets go of the keys that drive."""
        if key in DRIVE:
            self._keys.press(DRIVE[key], now)
        elif key in ACTIONS:
            self.act(ACTIONS[key].name)
        else:
            self._keys.let_go()

    def _hear_terminal(self, data: bytes, now: float) -> bool:
        """Take what was typed. Return False when the terminal is closed."""
        for key in self._keyboard.keys(data):
            self.press(key, now)
        return bool(data)

    def _hear_gamepad(self, now: float) -> None:
        assert self._gamepad is not None
        try:
            for action in self._gamepad.read(now):
                self.act(action)
        except OSError:
            rospy.logwarn("the gamepad is gone: %s", self._gamepad.name)
            self._gamepad.close()
            self._gamepad = None

    def _show(self, wish: Wish) -> None:
        """Write the state of the robot over the line of before."""
        info = self._talk.news.get(RobotInfo)
        if info is not None:
            self._limit.robot = (info.max_linear, info.max_angular)
        text = "\r\x1b[K" + state_line(self._talk, self._limit, wish, self._remark)
        if self._screen.isatty():
            self._screen.write(text)
            self._screen.flush()


def state_line(talk: Talk, limit: Limit, wish: Wish, remark: str = "") -> str:
    """Return one line about the robot: who commands, motors, speed, limit, battery."""
    if not talk.listened:
        return "nobody listens on %s: does the driver run?" % rospy.resolve_name(talk.robot + "/teleop/cmd_vel")
    helm, motors, pose, battery = (talk.news.get(kind) for kind in (Helm, MotorState, Odometry, BatteryState))
    parts = []
    if helm is not None and helm.locks:
        parts.append("LOCKED by %s (u unlocks)" % ", ".join(helm.locks))
    elif helm is not None and helm.commander:
        parts.append("%s commands" % helm.commander)
    elif helm is not None and helm.programs_locked_out:
        parts.append("you have the helm")
    if motors is not None:
        parts.append("motors on" if motors.state == 1 else "motors off (m)")
    if pose is not None:
        parts.append("%.2f m/s" % pose.twist.twist.linear.x)
    parts.append("at most %.1f m/s" % min(limit.linear, limit.robot[0]))
    if battery is not None:
        parts.append("%.1f V" % battery.voltage)
    return "  ".join(parts + [remark] * bool(remark))


@contextlib.contextmanager
def each_key(terminal: int) -> Iterator[None]:
    """Let a terminal tell each key at once, without showing it. What was typed before is forgotten, also after Ctrl-Z.
    """
    before = termios.tcgetattr(terminal)

    def set_up(*_: Any) -> None:
        tty.setcbreak(terminal, termios.TCSAFLUSH)

    set_up()
    signal.signal(signal.SIGCONT, set_up)
    try:
        yield
    finally:
        signal.signal(signal.SIGCONT, signal.SIG_DFL)
        termios.tcsetattr(terminal, termios.TCSAFLUSH, before)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog="drive", description="Drive a robot by hand, with the keys of this terminal or a gamepad.")
    made.add_argument("robot", nargs="?", default="pioneer", help="namespace of the robot (default: %(default)s)")
    made.add_argument("--gamepad", metavar="DEVICE", default="",
                      help="such as /dev/input/event5; none: no gamepad (default: the first there is)")
    made.add_argument("--speed", type=float, default=SLOW, metavar="M_S",
                      help="speed limit at the start, in m/s (default: %(default)s)")
    return made


def main() -> int:
    """Run the program. Return the exit code: 0 ended by the user, 1 nothing to drive with, 2 a wrong argument."""
    given = parser().parse_args(rospy.myargv()[1:])
    if not 0.05 <= given.speed <= 3.0:
        parser().error("--speed %g is not legal: give a number from 0.05 to 3 (m/s)" % given.speed)
    terminal = sys.stdin.fileno() if sys.stdin.isatty() else None
    try:
        gamepad = None if given.gamepad == "none" else find(given.gamepad)
    except PioneerError as error:
        print("drive: %s" % error, file=sys.stderr)
        return 2
    if terminal is None and gamepad is None:
        print("drive: there is no terminal to read keys from, and no gamepad", file=sys.stderr)
        return 1
    robot = given.robot.rstrip("/")
    init_node(name_for("drive", robot))
    talk = Talk(robot)
    drive = HandDrive(talk, gamepad, given.speed)

    def stop() -> None:
        for _ in range(STOPS if drive.drove else 0):    # a zero takes the helm, too
            talk.drive(0.0, 0.0)

    rospy.on_shutdown(stop)
    if gamepad is not None:
        print("%s drives while a shoulder button is held." % gamepad.name)
    with each_key(terminal) if terminal is not None else contextlib.nullcontext():
        if terminal is not None:
            print(HELP % FIRST_PRESS)
        try:
            drive.run(terminal)
        finally:
            if not rospy.is_shutdown():
                stop()
    if drive.drove:
        print("\nThe robot stands. Programs stay locked out until: rosservice call %s"
              % rospy.resolve_name(robot + "/teleop/release"))
    return 0

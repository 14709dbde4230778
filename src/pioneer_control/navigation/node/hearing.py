"""Subscribes to what a robot's driver tells: what the robot senses, and whether it may move."""

import threading
from time import monotonic
from typing import Any, Callable, Iterable, List, Optional

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from ...errors import PioneerError
from ...msg import Helm, MotorState, RobotInfo, SonarArray, Stall
from ..lateness import Delay
from ..navigator import SLOW_LINE, Readiness
from ..senses import SHORTEST, Senses
from ..steady_time import SteadyTime
from ..values import Sensing
from .laser_watch import LaserState, LaserWatch
from .messages import pose_of

INFO_PATIENCE = 10.0
"""Time (s) after which the log says that the driver has not told what robot this is."""
STANDS = 0.3
"""Time (s) in which messages come without newer stamps, after which time stands still."""
WAITING = 2
"""Most messages of a topic that wait to be heard: on a busy computer old ones are dropped. Each repeats all ranges."""
SLOWEST_LINE = 0.15
"""If stamps say that a packet was on the way for longer than this (s), the clocks of two computers differ. A smaller
difference is not noticed: at 0.4 m/s the robot then stops up to 6 cm off."""
JUMP_QUIET = 10.0
"""Time (s) after the log has told of a jump of time in which it tells only of one more than twice as long."""
OFF = LaserState("off: the parameter use_laser is false", False)
"""What people are told where no laser is listened to."""


class Hearing:
    """What one robot tells.

    Args:
        numbers: the fitted transducers.
        lock: held while a message is taken.
        on_sensed: called with the lock held for what was sensed, oldest first. Usually it is one.
        place_of: returns the transform of a laser's frame on the robot; None: no laser is listened to.

    Attributes:
        readiness: whether the robot may move, how late its messages are, and how long they need.
        heard_at: when something new was sensed last (monotonic, s).
    """

    def __init__(self, numbers: Iterable[int], lock: Any, on_sensed: Callable[[List[Sensing]], None],
                 place_of: Optional[Callable[[str], Any]] = None):
        self.readiness = Readiness()
        self.heard_at = self._came_at = self._ticked_at = monotonic()
        self._said_at = {"sonar": self._came_at, "pose": self._came_at}
        self._delay = Delay()
        self._time, self._newest, self._quiet_until, self._told_jump = SteadyTime(), 0.0, 0.0, 0.0
        self._senses, self._lock, self._on_sensed = Senses(numbers), lock, on_sensed
        self._laser = LaserWatch(self._senses, place_of) if place_of is not None else None

    def start(self) -> None:
        """Subscribe."""
        for name, kind, hear, queue in (
                ("pose", Odometry, self._hear_pose, WAITING), ("sonar", SonarArray, self._hear_sonar, WAITING),
                ("motor_state", MotorState, self._hear_motors, 1), ("stall", Stall, self._hear_stall, 1),
                ("helm", Helm, self._hear_helm, 1)):
            rospy.Subscriber(name, kind, self._take, hear, queue_size=queue, tcp_nodelay=True)
        if self._laser is not None:
            rospy.Subscriber("scan", LaserScan, self._take, self._hear_scan, queue_size=WAITING, tcp_nodelay=True)

    def _take(self, message: Any, hear: Callable[[Any], None]) -> None:
        try:
            with self._lock:
                hear(message)
        except rospy.ROSException:      # an answer to the last message before Ctrl-C: topics are closed by then
            if not rospy.is_shutdown():
                raise
        except PioneerError as error:
            rospy.logwarn_throttle(10.0, "a message of the robot makes no sense: %s" % error)

    @property
    def time_stands(self) -> bool:
        """Whether messages of the robot come, but none with a newer stamp."""
        return self._came_at - self._ticked_at > STANDS

    def silence(self, seconds: float) -> str:
        """Return for people why nothing new was sensed for so long (s)."""
        if self.time_stands:
            return "time stands still: no message of the robot has a newer stamp for %.1f s" % seconds
        missing = [what for what, said_at in self._said_at.items() if monotonic() - said_at > STANDS]
        if missing == ["sonar"]:
            return "no sonar of the robot for %.1f s: is it off? The service set_sonar switches it on" % seconds
        if missing == ["pose"]:
            return "no pose of the robot for %.1f s, but sonar" % seconds
        return "neither sonar nor pose of the robot for %.1f s" % seconds

    def laser(self, by_laser: bool, makes_map: bool) -> LaserState:
        """Return what to tell of the laser, see `LaserWatch.state`, and log it if it is news."""
        if self._laser is None:
            return OFF
        state = self._laser.state(by_laser, makes_map)
        self._laser.say(state)
        return state

    def stamp_of(self, time: float) -> rospy.Time:
        """Return the stamp of a time (s) of what was sensed: the robot's own clock may have jumped since the start."""
        return rospy.Time.from_sec(max(0.0, time - self._time.offset))

    def _hear_pose(self, message: Odometry) -> None:
        self._sensed(self._senses.hear_pose(self._time_of(message, "pose"), pose_of(message.pose.pose)))

    def _hear_sonar(self, message: SonarArray) -> None:
        self._sensed(self._senses.hear_sonar(self._time_of(message, "sonar"), message.ranges))

    def _hear_scan(self, message: LaserScan) -> None:
        assert self._laser is not None
        self._laser.hear(message, self._time.offset)

    def _time_of(self, message: Any, what: str) -> float:
        """Return the steady time (s) of a message, and tell people when its stamp jumps."""
        self._came_at = self._said_at[what] = monotonic()
        time = self._time.of(message.header.stamp.to_sec(), self._came_at)
        late = self._delay.of(time, rospy.get_time() + self._time.offset)
        least = self._delay.least
        on_the_way = least if 0.0 <= least <= SLOWEST_LINE else SLOW_LINE
        self.readiness = self.readiness._replace(late=late, on_the_way=on_the_way)
        if time > self._newest + SHORTEST:
            self._newest, self._ticked_at = time, self._came_at
        jump = self._time.jump
        if jump and (self._came_at >= self._quiet_until or abs(jump) > 2.0 * abs(self._told_jump)):
            self._quiet_until, self._told_jump = self._came_at + JUMP_QUIET, jump
            rospy.logwarn("time jumps by %.1f s in the robot's messages; navigation goes on as if it did not", jump)
        return time

    def _sensed(self, sensed: List[Sensing]) -> None:
        if sensed:
            self.heard_at = monotonic()
            self._on_sensed(sensed)

    def _hear_motors(self, message: MotorState) -> None:
        self.readiness = self.readiness._replace(motors=message.state == 1)

    def _hear_stall(self, message: Stall) -> None:
        self.readiness = self.readiness._replace(stalled=message.left or message.right)

    def _hear_helm(self, message: Helm) -> None:
        self.readiness = self.readiness._replace(may_command=not (message.locks or message.programs_locked_out))


def robot_info() -> RobotInfo:
    """Wait for the driver to tell what robot this is. The log says so when that takes long.

    Raises:
        ROSInterruptException: the node ends meanwhile.
    """
    heard: List[RobotInfo] = []
    subscriber = rospy.Subscriber("robot_info", RobotInfo, heard.append, queue_size=1)
    said, since = False, monotonic()
    while not heard:
        if rospy.is_shutdown():
            raise rospy.ROSInterruptException("ended while waiting for the driver")
        threading.Event().wait(0.05)
        if not said and monotonic() - since > INFO_PATIENCE:
            said = True
            rospy.logwarn("still no message on %s: does the driver run, and has it found its robot?",
                          rospy.resolve_name("robot_info"))
    subscriber.unregister()
    return heard[-1]

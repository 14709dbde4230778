"""The goals of a robot, as move_base takes them: the action ``move_base``, and the topic ``move_base_simple/goal``.

There is one goal at a time. A new one takes the place of the one before, which ends as preempted.
"""

from typing import Any, Callable, List, Optional, Tuple

import actionlib
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import (MoveBaseAction, MoveBaseActionGoal, MoveBaseFeedback, MoveBaseGoal,
                                MoveBaseResult)
from std_msgs.msg import Header

from ...errors import PioneerError

NAME = "move_base"
"""The name of the action."""


def say_refused(why_not: str) -> None:
    """Say in the log why goals of a bag player are refused. It may send ten a second: once in 10 s is enough."""
    rospy.logwarn_throttle(10.0, "a goal is refused: %s" % why_not)


class _Server(actionlib.ActionServer):
    """An action server that knows which goals come from a bag player, and whose "cancel all" also ends goals of a
    service.

    Attributes:
        why_not: why the goal that comes now must not be obeyed; empty: it may be.
    """

    def __init__(self, refuses: Callable[[Any], str], cancel_all: Callable[[], None], *arguments: Any) -> None:
        self._refuses, self._cancel_all = refuses, cancel_all
        self.why_not, self._newest = "", rospy.Time()
        super().__init__(NAME, MoveBaseAction, *arguments, auto_start=False)

    def initialize(self) -> None:
        """Begin, without a timer of rospy's for the status: it ends for good when time jumps back."""
        super().initialize()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()

    def internal_goal_callback(self, goal: MoveBaseActionGoal) -> None:
        """Take a goal that comes."""
        why_not = self._refuses(goal)       # without the lock: it may take a moment
        with self.lock:
            self.why_not = why_not
            self.look_at_time()
            super().internal_goal_callback(goal)
            if any(each.status.status == GoalStatus.RECALLED and each.status.goal_id.id == goal.goal_id.id
                   for each in self.status_list):
                rospy.logwarn("a goal is recalled: it is older than the last request to cancel, or has its id")

    def look_at_time(self) -> None:
        """Forget the time of the last request to cancel when time jumps back: each goal would be older than that."""
        now = rospy.Time.now()
        if now < self._newest:
            self.last_cancel = rospy.Time()
        self._newest = now

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Take a request to cancel. One without id and stamp means every goal (actionlib), also one of `go_to`."""
        with self.lock:
            self.look_at_time()
            super().internal_cancel_callback(goal_id)
            if not goal_id.id and not goal_id.stamp:
                self._cancel_all()


class GoalServer:
    """Takes goals, and tells what becomes of them.

    Args:
        accept: a function that sends the robot to a goal (PoseStamped). It raises PioneerError with the reason when
            it does not.
        cancel: a function that ends what the robot does, a goal of a service too. It may be called when there is none.
        refuses: a function that returns why a message must not be obeyed at all; empty: it may be.

    Attributes:
        lock: the lock under which `accept` and `cancel` are called. Hold it when you call other methods.
    """

    def __init__(self, accept: Callable[[PoseStamped], None], cancel: Callable[[], None],
                 refuses: Callable[[Any], str]) -> None:
        self._accept, self._cancel = accept, cancel
        self._handle: Optional[Any] = None
        self._refused: List[Tuple[Any, str]] = []       # goals, and why; nobody has been told yet
        self._told_next: List[Tuple[Any, str]] = []
        self._server = _Server(refuses, cancel, self._goal, self._cancelled)
        self.lock = self._server.lock
        self._current = rospy.Publisher(NAME + "/current_goal", PoseStamped, queue_size=1)
        self._own_goals = rospy.Publisher(NAME + "/goal", MoveBaseActionGoal, queue_size=1)
        rospy.Subscriber("move_base_simple/goal", PoseStamped, self._simple_goal, refuses, queue_size=1)

    def start(self) -> None:
        """Begin to take goals."""
        self._server.start()

    def look(self) -> None:
        """Tell the status of all goals, and refuse those for which it is time. Call this a few times a second.

        A goal is refused at the second look after it came. A client of actionlib that hears of the refusal while it
        still sends the goal takes it for that of another goal, and waits for ever (seen with Python's).
        """
        told, self._told_next, self._refused = self._told_next, self._refused, []
        for handle, why_not in told:
            handle.set_rejected(MoveBaseResult(), why_not)
        self._server.look_at_time()
        self._server.publish_status()

    def on_the_way(self, goal: PoseStamped) -> None:
        """Publish a goal that was accepted, of the action or of a service, in the frame of the map."""
        self._current.publish(goal)

    def feedback(self, here: PoseStamped) -> None:
        """Tell who sent the goal where the robot is."""
        if self._handle is not None:
            self._handle.publish_feedback(MoveBaseFeedback(here))

    def reached(self, text: str) -> None:
        """The robot has reached the goal."""
        self._end("set_succeeded", text)

    def failed(self, text: str) -> None:
        """The robot has given up. `text` says why."""
        self._end("set_aborted", text)

    def dropped(self, text: str) -> None:
        """The goal counts no more: somebody has chosen another, or ended it. `text` says why."""
        self._end("set_canceled", text)

    def _end(self, how: str, text: str) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            getattr(handle, how)(MoveBaseResult(), text)

    def _goal(self, handle: Any) -> None:
        goal: MoveBaseGoal = handle.get_goal()
        if self._server.why_not:
            say_refused(self._server.why_not)
            self._refused.append((handle, self._server.why_not))
            return
        try:
            self._accept(goal.target_pose)
        except Exception as error:      # whatever it is: who sent the goal waits for an answer
            expected = isinstance(error, PioneerError)
            why_not = str(error) if expected else "%s: %s" % (type(error).__name__, error)
            (rospy.logwarn if expected else rospy.logerr)("a goal is refused: %s", why_not)
            self._refused.append((handle, why_not))
            return
        self.dropped("another goal has taken its place")
        self._handle = handle
        handle.set_accepted("on the way")

    def _cancelled(self, handle: Any) -> None:
        if handle is self._handle or (self._handle is not None and handle == self._handle):
            self._cancel()
            self.dropped("it was cancelled")

    def _simple_goal(self, message: PoseStamped, refuses: Callable[[Any], str]) -> None:
        """Send a goal of the topic through the action, as move_base does, so that its status is told too."""
        why_not = refuses(message)
        if why_not:
            say_refused(why_not)
            return
        # Without an id: the server makes one, also of its own while time stands.
        self._own_goals.publish(MoveBaseActionGoal(Header(stamp=rospy.Time.now()), GoalID(), MoveBaseGoal(message)))

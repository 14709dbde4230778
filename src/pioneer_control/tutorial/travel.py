"""Sends the robot to places on the map: the client of the package's navigation, or of any other with move_base's names.
"""

import math
import time
from typing import Any, Dict, Optional, Union

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from geometry_msgs.msg import Pose as PoseMessage
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import Header
from std_srvs.srv import SetBool

from ..errors import NoAnswerError, UsageError
from ..floor_poses import Pose
from ..message_values import quaternion_of
from ..msg import Navigation, Places
from ..srv import SaveMap, SavePlace
from .goal_client import GoalClient
from .reports import Stopwatch

CONNECT_TIMEOUT = 15.0  #: s, time-out for navigation: it draws a table of a large map first
LOOK_AGAIN = 0.1  #: s between two looks whether the robot has arrived
STOP_PATIENCE = 0.5  #: s, longest wait at the end until navigation has heard that it is to stop
UNDER_WAY = "driving", "waiting"
"""The states of navigation that has something to do."""
ADVICE = ("Does navigation run, and in this namespace? End pioneer.launch, then start it with the driver: roslaunch"
          " pioneer_control navigate.launch sim:=true world:=tutorial")


class Exploration:
    """What navigation says of one exploration that began after a stamp.

    Its end is told in one message alone, so it must be noted when that comes.
    """

    def __init__(self, asked: rospy.Time):
        self._asked, self._begun = asked, False
        self.end: Optional[Navigation] = None

    def hear(self, news: Navigation) -> None:
        """Take a message of navigation."""
        if news.header.stamp <= self._asked or self.end is not None:
            return
        if news.state in UNDER_WAY:
            self._begun = True
        elif self._begun:
            self.end = news


class Travel:
    """The navigation of one robot, as a program sees it.

    Args:
        prefix: what the names of the robot's topics begin with.
    """

    def __init__(self, prefix: str):
        self._prefix = prefix
        self._news: Dict[type, Any] = {}
        self._exploration: Optional[Exploration] = None
        self._ended = False
        self._client = GoalClient(prefix + "move_base", MoveBaseAction)
        for topic, kind in (("navigation", Navigation), ("places", Places)):
            rospy.Subscriber(prefix + topic, kind, self._hear, kind, queue_size=1)

    def _hear(self, message: Any, kind: type) -> None:
        self._news[kind] = message
        exploration = self._exploration
        if exploration is not None and kind is Navigation:
            exploration.hear(message)

    def wait(self) -> Navigation:
        """Wait for navigation. Return its newest message.

        Raises:
            NoAnswerError: nothing came in time.
        """
        passed = Stopwatch()
        while Navigation not in self._news or Places not in self._news:
            if passed() > CONNECT_TIMEOUT:
                missing = [self._prefix + name for name, kind in (("navigation", Navigation), ("places", Places))
                           if kind not in self._news]
                raise NoAnswerError("after %.0f s still no %s. %s" % (CONNECT_TIMEOUT, ", ".join(missing), ADVICE))
            self._go_on()
            rospy.rostime.wallsleep(LOOK_AGAIN)
        return self._news[Navigation]

    def where(self) -> Optional[Pose]:
        """Return where the robot is (m, rad; frame of the map). None while it does not know."""
        news = self.wait()
        return Pose(news.pose.x, news.pose.y, news.pose.theta) if news.sure else None

    def places(self) -> Dict[str, Pose]:
        """Return the named places of the map: x, y (m) and heading (rad)."""
        self.wait()
        told = self._news[Places]
        return {name: Pose(pose.x, pose.y, pose.theta) for name, pose in zip(told.names, told.poses)}

    def goal_of(self, place: Union[str, float], y: Optional[float], heading: Optional[float]) -> Pose:
        """Return the pose that the arguments of `Pioneer.go_to` name.

        Raises:
            UsageError: a number is not finite, no place has the name, or a place by name has a y, too. The message says
                what is legal.
        """
        if isinstance(place, str):
            if y is not None:
                raise UsageError("y is %r: a place by name has none. Where it looks in the end is heading:"
                                 " go_to(%r, heading=%r)" % (y, place, y))
            places = self.places()
            if place not in places:
                raise UsageError("no place is named %r on the map; known: %s"
                                 % (place, ", ".join(map(repr, places)) or "none"))
            named = places[place]
            return Pose(named.x, named.y, named.heading if heading is None else heading)
        for name, value in (("x", place), ("y", y), ("heading", 0.0 if heading is None else heading)):
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise UsageError("%s is %r: go_to needs the name of a place, or x and y in metres" % (name, value))
        assert y is not None
        if heading is None:     # as it comes
            here = self.wait().pose
            heading = math.atan2(y - here.y, place - here.x)
        return Pose(place, y, heading)

    def go_to(self, goal: Pose) -> str:
        """Send the robot to a goal and wait until it is there. Return why it is not there; empty: it is.

        Raises:
            NoAnswerError: navigation does not answer, or ends meanwhile.
            ROSInterruptException: the program ends. The robot stops.
        """
        self.wait()
        self._wait_for_server()
        self._go_on()
        self._client.send_goal(MoveBaseGoal(PoseStamped(
            Header(stamp=rospy.Time.now(), frame_id=self._news[Navigation].header.frame_id),
            PoseMessage(Point(goal.x, goal.y, 0.0), Quaternion(*quaternion_of(goal.heading))))))
        try:
            while not self._client.wait_for_result(rospy.Duration(LOOK_AGAIN)):
                self._look()
        finally:
            self.stop()
        self._go_on()
        status = self._client.get_state()
        return "" if status == GoalStatus.SUCCEEDED else self._client.get_goal_status_text() or "navigation gave up"

    def _wait_for_server(self) -> None:
        if not self._client.wait_for_server(rospy.Duration(CONNECT_TIMEOUT)):
            raise NoAnswerError("%smove_base takes no goals. %s" % (self._prefix, ADVICE))

    def _look(self) -> None:
        """Raise ROSInterruptException when the program ends, and NoAnswerError when navigation does."""
        self._go_on()
        if not self._client.action_client.wait_for_server(rospy.Duration(CONNECT_TIMEOUT)):
            raise NoAnswerError("navigation has ended on the way. %s" % ADVICE)

    def _go_on(self) -> None:
        """Raise ROSInterruptException when the program ends."""
        if self._ended or rospy.is_shutdown():
            raise rospy.ROSInterruptException("this program is ending and drives the robot no more")

    def end(self) -> None:
        """End exploring, or the way to a goal, if there is one, and send the robot nowhere any more."""
        self._ended = True
        self.stop()

    def stop(self) -> None:
        """End exploring, or the way to a goal, if there is one. Wait a moment until navigation has heard it.

        It uses topics alone: while the program ends, services answer no more.
        """
        began, exploration = time.monotonic(), self._exploration
        if exploration is not None:
            # it may have been asked for just now, and begin after the first request to end
            while exploration.end is None and time.monotonic() - began < STOP_PATIENCE:
                self._client.cancel_all_goals()
                rospy.rostime.wallsleep(LOOK_AGAIN)
        elif self._client.gh is not None and self._is_under_way():
            self._client.cancel_goal()
            while self._is_under_way() and time.monotonic() - began < STOP_PATIENCE:
                rospy.rostime.wallsleep(LOOK_AGAIN)

    def _is_under_way(self) -> bool:
        return bool(self._client.simple_state != actionlib.SimpleGoalState.DONE)

    def explore(self) -> str:
        """Let the robot drive where its map ends, until all is known, and home. Return why that failed, or nothing.

        Raises:
            NoAnswerError: navigation does not answer, or ends meanwhile.
            ROSInterruptException: the program ends. The robot stops.
        """
        self.wait()
        self._wait_for_server()
        self._go_on()
        exploration = self._exploration = Exploration(rospy.Time.now())
        try:
            answer = self._call("explore", SetBool, True)
            if not answer.success:
                self._exploration = None
                return str(answer.message)
            while exploration.end is None:
                self._look()
                rospy.rostime.wallsleep(LOOK_AGAIN)
        finally:
            self.stop()
            self._exploration = None
        self._go_on()
        if exploration.end.state == "idle":
            return "somebody ended it"
        return "" if exploration.end.state == "reached" else str(exploration.end.reason)

    def save_map(self, file: str) -> None:
        """Save the map in a file (.yaml). Raises UsageError with the reason when that fails."""
        self._ask("save_map", SaveMap, file)

    def save_place(self, name: str) -> None:
        """Give the place where the robot stands a name. Raises UsageError with the reason when that fails."""
        self._ask("save_place", SavePlace, name=name, here=True)

    def _ask(self, service: str, kind: type, *values: Any, **named: Any) -> None:
        answer = self._call(service, kind, *values, **named)
        if not answer.success:
            raise UsageError("%s: %s" % (service, answer.message))

    def _call(self, service: str, kind: type, *values: Any, **named: Any) -> Any:
        try:
            rospy.wait_for_service(self._prefix + service, CONNECT_TIMEOUT)
            return rospy.ServiceProxy(self._prefix + service, kind)(*values, **named)
        except (rospy.ROSException, rospy.ServiceException) as error:
            self._go_on()
            raise NoAnswerError("the service %s%s does not answer: %s. %s"
                                % (self._prefix, service, error, ADVICE)) from None

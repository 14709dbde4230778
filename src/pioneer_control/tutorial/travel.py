"""Sends the robot to places on the map: the client of the package's navigation, or of any other with move_base's names.
"""

import math
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
from .reports import Stopwatch

CONNECT_TIMEOUT = 15.0  #: s, time-out for navigation: it draws a table of a large map first
LOOK_AGAIN = 0.1  #: s between two looks whether the robot has arrived
ADVICE = "Does navigation run (roslaunch pioneer_control navigate.launch sim:=true), and in this namespace?"


class Travel:
    """The navigation of one robot, as a program sees it.

    Args:
        prefix: what the names of the robot's topics begin with.
    """

    def __init__(self, prefix: str):
        self._prefix = prefix
        self._news: Dict[type, Any] = {}
        self._client = actionlib.SimpleActionClient(prefix + "move_base", MoveBaseAction)
        for topic, kind in (("navigation", Navigation), ("places", Places)):
            rospy.Subscriber(prefix + topic, kind, self._hear, kind, queue_size=1)

    def _hear(self, message: Any, kind: type) -> None:
        self._news[kind] = message

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
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("this program is ending")
            rospy.rostime.wallsleep(LOOK_AGAIN)
        return self._news[Navigation]

    def where(self) -> Optional[Pose]:
        """Return where the robot is (m, rad; frame of the map). None while it does not know."""
        news = self.wait()
        return Pose(news.pose.x, news.pose.y, news.pose.theta) if news.sure else None

    def goal_of(self, place: Union[str, float], y: Optional[float], heading: Optional[float]) -> Pose:
        """Return the pose that the arguments of `Pioneer.go_to` name.

        Raises:
            UsageError: a number is not finite, or no place has the name. The message lists the places.
        """
        if isinstance(place, str):
            self.wait()
            places = self._news[Places]
            if place not in places.names:
                raise UsageError("no place is named %r on the map; known: %s"
                                 % (place, ", ".join(map(repr, places.names)) or "none"))
            named = places.poses[places.names.index(place)]
            return Pose(named.x, named.y, named.theta if heading is None else heading)
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
        if not self._client.wait_for_server(rospy.Duration(CONNECT_TIMEOUT)):
            raise NoAnswerError("%smove_base takes no goals. %s" % (self._prefix, ADVICE))
        self._client.send_goal(MoveBaseGoal(PoseStamped(
            Header(stamp=rospy.Time.now(), frame_id=self._news[Navigation].header.frame_id),
            PoseMessage(Point(goal.x, goal.y, 0.0), Quaternion(*quaternion_of(goal.heading))))))
        try:
            while not self._client.wait_for_result(rospy.Duration(LOOK_AGAIN)):
                if rospy.is_shutdown():
                    raise rospy.ROSInterruptException("this program is ending")
                if not self._client.action_client.wait_for_server(rospy.Duration(CONNECT_TIMEOUT)):
                    raise NoAnswerError("navigation has ended on the way. %s" % ADVICE)
        finally:
            self.stop()
        status = self._client.get_state()
        return "" if status == GoalStatus.SUCCEEDED else self._client.get_goal_status_text() or "navigation gave up"

    def stop(self) -> None:
        """End the way to a goal, if there is one."""
        if self._client.simple_state != actionlib.SimpleGoalState.DONE and self._client.gh is not None:
            self._client.cancel_goal()

    def explore(self) -> str:
        """Let the robot drive where its map ends, until all is known, and home. Return why that failed, or nothing."""
        self.wait()
        asked = rospy.Time.now()
        answer = self._call("explore", SetBool, True)
        if not answer.success:
            return str(answer.message)
        try:
            while self._news[Navigation].header.stamp <= asked or self._news[Navigation].state not in (
                    "reached", "failed"):
                if rospy.is_shutdown():
                    raise rospy.ROSInterruptException("this program is ending")
                rospy.rostime.wallsleep(LOOK_AGAIN)
        except rospy.ROSInterruptException:
            self._call("explore", SetBool, False)
            raise
        news = self._news[Navigation]
        return "" if news.state == "reached" else str(news.reason)

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
            raise NoAnswerError("the service %s%s does not answer: %s. %s"
                                % (self._prefix, service, error, ADVICE)) from None

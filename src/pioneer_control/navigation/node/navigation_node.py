"""The node of navigation: it knows where the robot is, makes a map, and drives to goals, with sonar, and
with a laser where there is one.

The names are those of amcl, map_server and move_base, so that programs and RViz work with it unchanged. They are
relative to the namespace of the robot. docs/navigation.md has all of them.

*Subscribes* to what the driver tells (`hearing`), ``initialpose`` and ``move_base_simple/goal``.

*Publishes* ``cmd_vel`` while it drives, ``accelerations`` that it borrows meanwhile, ``places``, and what `telling`
says.

*Action* ``move_base``. *Services* ``go_to``, ``static_map``, ``global_localization``, ``save_map``, ``save_place``,
``explore``, ``move_base/make_plan``, ``move_base/clear_costmaps``, ``request_nomotion_update``.

*Parameters*: see `NavigationParameters`; the numbers of `tuned` below the names of their parts.
"""

import gc
import os
import sys
import threading
from dataclasses import replace
from time import monotonic
from typing import Any, Callable, List, Optional, Set

import rospy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist, Vector3
from nav_msgs.srv import GetMap, GetMapResponse, GetPlan
from std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse

from ...errors import PioneerError, RefusedError, UsageError
from ...floor_poses import Pose, compose
from ...maps import FloorMap, GridMap
from ...msg import Accelerations, RobotInfo
from ...ros_node import bag_player, init_node, is_player, sender_of
from ...srv import GoTo, GoToResponse, SaveMap, SaveMapResponse, SavePlace
from ..chassis import Chassis
from .map_files import load_floor_map
from ..navigator import State
from ..pilot import Pilot, PilotStep
from ..tuned import NavigationNumbers
from ..values import Sensing
from .goal_server import GoalServer
from .hearing import Hearing, robot_info
from .map_saver import MapSaver, write_map
from .messages import body_of, check_on_map, check_start, header_of, pose_message, pose_of, spread_of
from .parameters import NavigationParameters, check_parameters
from .place_keeper import PlaceKeeper
from .plan_maker import PlanMaker
from .telling import Telling
from .tf_watch import TfWatch

SILENCE = 0.5
"""Time (s) without sonar or pose after which the robot is told to stand."""
BORROW_PERIOD = 0.5
"""Time (s) between two messages that borrow accelerations."""
LENDER_PATIENCE = 3.0
"""Time (s) for the driver to subscribe to ``accelerations``."""
NICENESS = 10
"""How much later its turn comes (nice) on a busy computer than that of the driver, which has to stop the robot."""
POWER_ON = {"acceleration": 0.3, "braking": 0.3, "turn_acceleration": 1.7}
"""Accelerations that a robot has at power-on (m/s^2, rad/s^2), for a driver that lends none."""
LAST_WORDS = 0.5
"""Time (s) for which velocities of a program that drove until now may still come, when it sends a goal."""
OLD_GOAL = 5.0
"""Time (s) after which a goal in a frame that moves is too old."""


class NavigationNode:
    """Joins one `Pilot` with the topics, services and the action of one robot.

    Args:
        parameters: parameters of the node.
        floor: the map; None: the robot makes one.
        info: the robot, as its driver tells it.
        numbers: the tuned numbers.
        saver: saves the map at the end. None: nobody does.
    """

    def __init__(self, parameters: NavigationParameters, floor: Optional[FloorMap], info: RobotInfo,
                 numbers: NavigationNumbers, saver: Optional[MapSaver]):
        self._parameters, self._saver = parameters, saver
        self._frame = parameters.global_frame_id
        self._body, self._ended, self._other_robot = body_of(info), threading.Event(), ""
        chassis = Chassis(*self._body, min(parameters.max_linear, info.max_linear or parameters.max_linear),
                          min(parameters.max_angular, info.max_angular or parameters.max_angular))
        self._accelerations = rospy.Publisher("accelerations", Accelerations, queue_size=1, tcp_nodelay=True)
        self._velocity = rospy.Publisher("cmd_vel", Twist, queue_size=1, tcp_nodelay=True)
        self._pilot = Pilot(floor, chassis, self._with_own_brakes(numbers), parameters.seed)
        if parameters.initial_pose is not None:
            self._pilot.start_at(parameters.initial_pose)
        elif parameters.start == "home" and floor and floor.starts:
            self._pilot.start_at(floor.starts[0])
        self._drives, self._borrow_at, self._sent_at = False, 0.0, -LAST_WORDS
        self._written: Set[str] = set()     # files of maps
        self._goals = GoalServer(self._accept_goal, self._cancel, self._refuses)
        self._lock = self._goals.lock
        self._tf_watch, self._tf_trouble = TfWatch(parameters.odom_frame, parameters.base_frame), ""
        self._hearing = Hearing(info.sonar_numbers, self._lock, self._sense,
                                self._place_of if parameters.use_laser else None)
        self._telling = Telling(self._pilot, parameters, chassis.outline)
        self._keeper = PlaceKeeper(floor, parameters.map, self._frame, self._here)

    def _with_own_brakes(self, numbers: NavigationNumbers) -> NavigationNumbers:
        """Return the numbers to drive with: another driver lends no accelerations, then the robot has its own."""
        end = monotonic() + LENDER_PATIENCE
        while not self._accelerations.get_num_connections():
            if monotonic() > end or rospy.is_shutdown():
                rospy.logwarn("this driver lends no accelerations (nobody listens on %s): the robot brakes as at"
                              " power-on, and goes slower near obstacles", self._accelerations.resolved_name)
                return numbers._replace(steering=replace(numbers.steering, **POWER_ON))
            threading.Event().wait(0.05)
        return numbers

    def run(self) -> str:
        """Navigate until ROS shuts down, or until the driver has another robot. Return why it ended, for people; empty
        after a shutdown. The loop looks whether the robot is silent; it uses real time.
        """
        self._begin()
        while not self._ended.wait(SILENCE / 2.0):
            self._look_at_tf()
            with self._lock:
                self._goals.look()
                silence = monotonic() - self._hearing.heard_at
                if silence > SILENCE and self._pilot.step.where is not None:
                    self._follow(self._without_news(silence))
        with self._lock:
            self._stand()
            self._goals.dropped(self._other_robot or "navigation ends")
            if self._saver is not None:
                print(self._saver.save(self._finished_map, self._keeper.places), flush=True)     # rosout has ended
        return self._other_robot

    def _begin(self) -> None:
        """Begin to hear the robot, to take goals and to answer services."""
        plans = PlanMaker(self._pilot, self._frame, self._in_map, self._here)
        for name, kind, serve in (
                ("go_to", GoTo, self._go_to), ("static_map", GetMap, self._static_map),
                ("global_localization", Empty, self._anywhere), ("save_map", SaveMap, self._save_map),
                ("save_place", SavePlace, self._keeper.serve), ("explore", SetBool, self._explore),
                ("move_base/make_plan", GetPlan, plans.serve),
                ("move_base/clear_costmaps", Empty, self._forget_obstacles),
                ("request_nomotion_update", Empty, lambda request: EmptyResponse())):   # each packet is told anyway
            rospy.Service(name, kind, self._locked(serve))
        rospy.Subscriber("initialpose", PoseWithCovarianceStamped, self._hear_start, queue_size=1)
        rospy.Subscriber("cmd_vel", Twist, self._hear_velocity, queue_size=1)
        self._hearing.start()
        self._goals.start()
        rospy.Subscriber("robot_info", RobotInfo, self._hear_robot, queue_size=1)
        rospy.on_shutdown(self._ended.set)

    def _hear_robot(self, info: RobotInfo) -> None:
        """End when the driver has another robot: its outline, or where its sonar looks, is not what it was."""
        if body_of(info) != self._body:
            self._other_robot = "the driver has another robot now, %s, a %s: start navigation anew" % (
                info.name or "without a name", info.subtype)
            self._ended.set()

    def _look_at_tf(self) -> None:
        self._tf_watch.leave_a_crowd()
        trouble = self._tf_watch.trouble()
        if trouble != self._tf_trouble:
            rospy.logwarn(trouble or "each frame of this robot has one publisher again")
            self._tf_trouble = self._telling.tf_trouble = trouble

    def _locked(self, act: Callable[[Any], Any]) -> Callable[[Any], Any]:
        def locked(message: Any) -> Any:
            with self._lock:
                return act(message)
        return locked

    # What the robot senses, and what follows from it

    def _sense(self, sensed: List[Sensing]) -> None:
        for sensing in sensed:
            step = self._pilot.sense(sensing, self._hearing.readiness)
            if self._saver is not None:
                self._saver.hear(sensing.odometry)
        self._follow(step)

    def _place_of(self, frame: str) -> Any:
        """Return the transform of a frame on the robot."""
        return self._tf_watch.transform(frame, self._parameters.base_frame)

    def _without_news(self, silence: float) -> PilotStep:
        """Return what to do after so long (s) without anything new of the robot: stand."""
        step = self._pilot.silent(silence)
        return step._replace(reason=self._hearing.silence(silence)) if step.state is State.WAITING else step

    def _follow(self, step: PilotStep) -> None:
        """Drive, and tell everybody."""
        self._drive(step)
        stamp = self._hearing.stamp_of(step.time)
        self._telling.laser = self._hearing.laser(step.where is not None and step.where.by_laser, self._pilot.makes_map)
        self._telling.tell(step, stamp)
        if step.state is State.REACHED:
            self._goals.reached(step.reason)
        elif step.state is State.FAILED:
            self._goals.failed(step.reason)
        elif step.where is not None:
            self._goals.feedback(PoseStamped(header_of(self._frame, stamp), pose_message(step.where.pose)))

    def _drive(self, step: PilotStep) -> None:
        """Publish the velocity while there is a goal, and one zero when the goal ends. Borrow brakes meanwhile."""
        wants, now = step.state.has_goal, monotonic()
        if wants or self._drives:
            self._velocity.publish(Twist(linear=Vector3(x=step.twist.linear), angular=Vector3(z=step.twist.angular)))
        self._drives = wants
        if wants and now >= self._borrow_at:
            self._borrow_at = now + BORROW_PERIOD
            linear, braking, angular = self._pilot.accelerations
            self._accelerations.publish(Accelerations(linear, braking, angular, angular))

    def _stand(self) -> None:
        """Publish one zero if the robot was driven. The next packet says the rest."""
        if self._drives:
            self._velocity.publish(Twist())

    # Goals and starts

    def _refuses(self, message: Any) -> str:
        """Return why a message that moves the robot must not be obeyed; empty: it may be. This asks the master."""
        if self._parameters.accept_replay:
            return ""
        player = bag_player(message)
        if player is None:
            return "the ROS master does not say in time whether its sender plays a bag"
        return "it is played back from a bag; set the parameter accept_replay to obey it" if player else ""

    def _accept_goal(self, message: PoseStamped) -> None:
        self._send_to(self._in_map(message.header, pose_of(message.pose)))

    def _send_to(self, goal: Pose, name: str = "") -> None:
        """Send the robot to a goal. Raises RefusedError with the reason when there is no way to it."""
        why_not = self._pilot.go_to(goal)
        if why_not:
            if self._pilot.step.goal is None:
                self._telling.has_said(State.FAILED, why_not)      # the caller logs it
            raise RefusedError(why_not)
        self._sent_at = monotonic()
        self._goals.on_the_way(PoseStamped(header_of(self._frame, rospy.Time.now()), pose_message(goal)))
        rospy.loginfo("goal: %s%.2f, %.2f", name and name + ", at ", goal.x, goal.y)

    def _cancel(self) -> None:
        """End what the robot does, whoever sent it, and say so: who asks to cancel may be another one."""
        goal = self._pilot.goal
        if self._pilot.explores:
            rospy.loginfo("exploring ends: somebody cancels it")
        elif goal is not None:
            rospy.loginfo("the goal at %.2f, %.2f ends: somebody cancels it", goal.x, goal.y)
        self._pilot.cancel()
        self._stand()

    def _hear_velocity(self, message: Twist) -> None:
        """End the goal when another program drives the robot: two that drive it at once would fight.

        A stop ends nothing, and a bag that is played does not drive.
        """
        driver = sender_of(message)
        if message == Twist() or driver == rospy.get_name() or monotonic() - self._sent_at < LAST_WORDS or (
                is_player(driver) and not self._parameters.accept_replay):
            return
        with self._lock:
            if self._pilot.goal is not None or self._pilot.explores:
                why = "%s drives the robot" % (driver or "another program")
                rospy.logwarn("%s ends: %s", "exploring" if self._pilot.explores else "the goal", why)
                self._pilot.cancel()
                self._goals.dropped(why)

    def _hear_start(self, message: PoseWithCovarianceStamped) -> None:
        try:
            why_not = self._refuses(message)     # without the lock: it may take a moment
            if why_not:
                rospy.logwarn_throttle(10.0, "initialpose is refused: %s" % why_not)    # it may send ten a second
                return
            pose = self._in_map(message.header, pose_of(message.pose.pose))
            place, heading = spread_of(message.pose.covariance)
            with self._lock:
                if not self._pilot.makes_map:       # that refuses each start
                    check_start(pose, place, self._pilot.grid)
                self._pilot.start_at(pose, place, heading)
        except PioneerError as error:
            rospy.logwarn("initialpose is refused: %s", error)
            return
        rospy.loginfo("somebody says that the robot is at %.2f, %.2f", pose.x, pose.y)

    def _in_map(self, header: Any, pose: Pose) -> Pose:
        """Return a pose of any frame in the frame of the map.

        Raises:
            UsageError: nobody knows the frame, several nodes say where it is, or it moves and the message is old.
        """
        frame = header.frame_id.lstrip("/")
        if frame == self._frame:
            return pose
        if not frame:
            raise UsageError("its header has no frame; the map has %r" % self._frame)
        age = (rospy.Time.now() - header.stamp).to_sec() if header.stamp else 0.0
        if age > OLD_GOAL:
            raise UsageError("it is %.0f s old, and its frame %r moves; the map has %r" % (age, frame, self._frame))
        return compose(self._tf_watch.pose(frame, self._frame), pose)

    def _here(self) -> Pose:
        where = self._pilot.step.where
        if where is None or not where.sure:
            raise RefusedError(where.reason if where else self._pilot.step.reason)
        return where.pose

    # Services

    def _go_to(self, request: Any) -> GoToResponse:
        try:
            self._send_to(self._keeper.place(request.place), request.place)
        except PioneerError as error:
            rospy.logwarn("a goal is refused: %s", error)
            return GoToResponse(False, str(error))
        self._goals.dropped("another goal has taken its place")
        return GoToResponse(True, "on the way to %s%s" % (request.place, self._when_motors_are_on()))

    def _when_motors_are_on(self) -> str:
        """Return what an answer adds while the motors are off: the robot waits, and then drives off at once."""
        return "" if self._hearing.readiness.motors else " as soon as its motors are on (rosservice call %s true)" % (
            rospy.resolve_name("set_motors"))

    def _static_map(self, request: Any) -> GetMapResponse:
        return GetMapResponse(self._telling.map_message)

    def _anywhere(self, request: Any) -> EmptyResponse:
        rospy.loginfo("somebody asks the robot to find out where it is")
        try:
            self._pilot.start_anywhere()
        except PioneerError as error:
            raise rospy.ServiceException(str(error)) from None
        return EmptyResponse()

    def _forget_obstacles(self, request: Any) -> EmptyResponse:
        self._pilot.forget_obstacles()
        return EmptyResponse()

    def _save_map(self, request: Any) -> SaveMapResponse:
        try:
            file = os.path.abspath(request.file)    # who asks may work in another directory
            done = write_map(self._pilot.grid, self._keeper.places, file, file in self._written)
        except PioneerError as error:
            return SaveMapResponse(False, str(error))
        self._written.add(file)
        rospy.loginfo("the map is %s", done)
        return SaveMapResponse(True, done)

    def _finished_map(self) -> GridMap:
        self._pilot.finish()
        return self._pilot.grid

    def _explore(self, request: Any) -> SetBoolResponse:
        explored = self._pilot.explores
        why_not = self._pilot.explore(request.data)
        if why_not:
            return SetBoolResponse(False, why_not)
        if request.data:
            self._sent_at = monotonic()
            self._goals.dropped("the robot explores")
            if not explored:
                self._keeper.name_home(self._here())
            return SetBoolResponse(True, "exploring" + self._when_motors_are_on())
        if explored:
            self._stand()
        return SetBoolResponse(True, "exploring has ended" if explored else "the robot does not explore")


def main() -> int:
    """Run the node. Return the exit code: 0 after a shutdown, 1 when the driver has another robot, 2 for a wrong
    parameter or map.
    """
    os.nice(NICENESS)       # before there are other threads: each has its own
    init_node("navigation")
    try:
        parameters, numbers = check_parameters(rospy.get_param("~", {}))
        floor = load_floor_map(parameters.map) if parameters.map else None
        if floor is not None and parameters.initial_pose is not None:
            check_on_map(parameters.initial_pose, floor.grid, "~initial_pose")
        saver = MapSaver(parameters.save_to) if parameters.save_to else None
        if floor is None:
            rospy.loginfo("no map is given: the robot makes one while it drives")
        else:
            rows, columns = floor.grid.cells.shape
            rospy.loginfo("map %s: %.1f m by %.1f m, places: %s", floor.name, columns * floor.grid.resolution,
                          rows * floor.grid.resolution, ", ".join(floor.goals) or "none")
        node = NavigationNode(parameters, floor, robot_info(), numbers, saver)
    except PioneerError as error:
        rospy.logfatal("%s (The master keeps old parameters until you type: rosparam delete %s)", error,
                       rospy.get_name())
        return 2
    except rospy.ROSInterruptException:
        return 0
    gc.freeze()     # all that was imported need not be searched for garbage again and again, in the middle of a packet
    why_ended = node.run()
    if why_ended:
        rospy.logfatal(why_ended)
        rospy.signal_shutdown(why_ended)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""Navigation as its users have it: move_base's action and topics, services by name, faults on the way, and its end."""

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
import unittest
import unittest.mock
import xmlrpc.client

import actionlib
import rosgraph
import rospy
import rostest
import tf
from actionlib_msgs.msg import GoalID, GoalStatus
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped, Quaternion, Twist, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetMap, GetPlan
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header
from std_srvs.srv import Empty, SetBool, Trigger

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from pioneer_control.msg import Navigation, Places
from pioneer_control.srv import AddFault, GoTo
from witness import PATIENCE, Witness, heading_of, wait_until

TOPICS = {
    "pioneer/navigation": Navigation, "pioneer/ground_truth": Odometry, "pioneer/places": Places,
    "pioneer/map": OccupancyGrid, "pioneer/plan": Path, "/rosout": Log,
    "pioneer/amcl_pose": PoseWithCovarianceStamped, "pioneer/cmd_vel": Twist,
    "pioneer/move_base/current_goal": PoseStamped,
}


def goal_at(x, y, heading=0.0, frame="map", stamp=None):
    """Return a goal: m, rad."""
    return MoveBaseGoal(PoseStamped(
        Header(frame_id=frame, stamp=stamp or rospy.Time.now()),
        PoseMessage(Point(x, y, 0.0), Quaternion(0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0)))))


def process_of(node):
    """Return the process id of a node."""
    uri = rosgraph.Master(rospy.get_caller_id()).lookupNode(node)
    _, _, pid = xmlrpc.client.ServerProxy(uri).getPid(rospy.get_caller_id())
    return pid


class NavigationTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.witness = Witness(TOPICS)
        cls.client = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
        assert cls.client.wait_for_server(rospy.Duration(PATIENCE))
        cls.services = {}
        for name, kind in (
                ("set_motors", SetBool), ("go_to", GoTo), ("static_map", GetMap), ("move_base/make_plan", GetPlan),
                ("move_base/clear_costmaps", Empty), ("request_nomotion_update", Empty), ("teleop/release", Trigger),
                ("simulator/add_fault", AddFault), ("simulator/clear_faults", Trigger)):
            rospy.wait_for_service("pioneer/" + name, PATIENCE)
            cls.services[name] = rospy.ServiceProxy("pioneer/" + name, kind)
        wait_until("motors are on", lambda: cls.services["set_motors"](True).success)
        start = cls.witness.last("pioneer/ground_truth").pose.pose.position
        cls.home = start.x, start.y

    def tearDown(self):
        self.client.cancel_all_goals()
        self.services["simulator/clear_faults"]()
        self.services["teleop/release"]()
        wait_until("motors are on", lambda: self.services["set_motors"](True).success)
        self.stands()

    def truth(self):
        return self.witness.next("pioneer/ground_truth").pose.pose

    def off(self, x, y):
        """Return how far (m) the robot really is from a place."""
        place = self.truth().position
        return math.hypot(place.x - x, place.y - y)

    def stands(self):
        """Wait until the robot really stands, in five messages one after the other."""
        self.witness.next("pioneer/ground_truth")

        def still():
            newest = self.witness.seen["pioneer/ground_truth"][-5:]
            return all(abs(message.twist.twist.linear.x) + abs(message.twist.twist.angular.z) < 0.001
                       for message in newest)

        self.witness.wait("the robot stands", still)

    def drives(self):
        self.witness.next("pioneer/ground_truth")
        self.witness.wait("the robot drives", lambda: abs(
            self.witness.seen["pioneer/ground_truth"][-1].twist.twist.linear.x) > 0.1)

    def knows_where_it_is(self):
        """Tell navigation where the robot is, as RViz does, until it is sure."""
        publisher = rospy.Publisher("pioneer/initialpose", PoseWithCovarianceStamped, queue_size=1)

        def sure():
            if not self.witness.next("pioneer/navigation").sure:
                told = PoseWithCovarianceStamped()
                told.header.frame_id = "map"
                told.pose.pose = self.truth()
                told.pose.covariance = [0.01 if each in (0, 7, 35) else 0.0 for each in range(36)]
                publisher.publish(told)
                return False
            return True
        wait_until("it is sure where it is", sure)

    def says(self, state, word=""):
        self.witness.next("pioneer/navigation")
        self.witness.wait("navigation is %s: %s" % (state, word), lambda: (
            self.witness.seen["pioneer/navigation"][-1].state == state
            and word in self.witness.seen["pioneer/navigation"][-1].reason))

    def result(self):
        self.assertTrue(self.client.wait_for_result(rospy.Duration(3 * PATIENCE)), "no result")
        return self.client.get_state()

    def logged(self, text, since):
        return any(text in message.msg for message in self.witness.seen["/rosout"][since:])

    def far_goal(self):
        """Return a goal about 5 m away along the floor: the kitchen, or the sofa if the robot is near the kitchen."""
        places = self.witness.last("pioneer/places")
        poses = dict(zip(places.names, places.poses))
        return max((poses["kitchen"], poses["sofa"]), key=lambda pose: self.off(pose.x, pose.y))

    def test_01_a_goal_of_the_action_is_reached_to_the_centimetre(self):
        x, y = self.home
        feedback = []
        self.client.send_goal(goal_at(x + 1.0, y, math.pi / 2), feedback_cb=feedback.append)
        self.assertEqual(self.result(), GoalStatus.SUCCEEDED)
        self.assertLess(self.off(x + 1.0, y), 0.15)
        self.assertAlmostEqual(heading_of(self.truth()), math.pi / 2, delta=0.15)
        self.assertTrue(feedback)
        self.assertEqual(feedback[-1].base_position.header.frame_id, "map")
        current = self.witness.last("pioneer/move_base/current_goal").pose
        self.assertEqual((current.position.x, current.position.y), (x + 1.0, y))

    def test_01b_on_a_busy_computer_navigation_comes_after_the_driver(self):
        def courtesies(node):
            found = set()
            for thread in os.listdir("/proc/%d/task" % process_of(node)):
                with contextlib.suppress(ProcessLookupError):       # it has just ended
                    found.add(os.getpriority(os.PRIO_PROCESS, int(thread)))
            return found

        own = os.getpriority(os.PRIO_PROCESS, 0)
        self.assertEqual(courtesies("/pioneer/p2os"), {own})
        self.assertEqual(courtesies("/pioneer/navigation"), {min(19, own + 10)})

    def test_02_the_pose_the_tf_and_the_truth_agree(self):
        self.stands()
        truth = self.truth().position
        told = self.witness.last("pioneer/amcl_pose").pose.pose.position
        self.assertLess(math.hypot(told.x - truth.x, told.y - truth.y), 0.15)
        listener = tf.TransformListener()
        listener.waitForTransform("map", "base_link", rospy.Time(0), rospy.Duration(PATIENCE))
        (x, y, _), _ = listener.lookupTransform("map", "base_link", rospy.Time(0))
        self.assertLess(math.hypot(x - truth.x, y - truth.y), 0.15)

    def test_03_a_simple_goal_is_driven_to_and_can_be_cancelled(self):
        goals = rospy.Publisher("pioneer/move_base_simple/goal", PoseStamped, queue_size=1)
        cancel = rospy.Publisher("pioneer/move_base/cancel", GoalID, queue_size=1)
        wait_until("they listen", lambda: goals.get_num_connections() and cancel.get_num_connections())
        place = self.far_goal()
        goals.publish(goal_at(place.x, place.y).target_pose)
        self.drives()
        self.assertTrue(self.witness.last("pioneer/plan").poses)
        self.assertTrue(self.witness.seen["pioneer/navigation"][-1].goal)
        cancel.publish(GoalID())
        self.stands()
        self.says("idle")
        self.assertEqual(self.witness.last("pioneer/cmd_vel"), Twist())

    def test_03b_cancel_ends_a_goal_of_the_service_too(self):
        cancel = rospy.Publisher("pioneer/move_base/cancel", GoalID, queue_size=1)
        wait_until("it listens", cancel.get_num_connections)
        place = self.far_goal()
        places = self.witness.last("pioneer/places")
        name = places.names[places.poses.index(place)]
        self.assertTrue(self.services["go_to"](name).success)
        self.drives()
        cancel.publish(GoalID())
        self.stands()
        self.says("idle")

    def test_04_a_new_goal_preempts_the_one_before(self):
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        other = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
        other.wait_for_server(rospy.Duration(PATIENCE))
        other.send_goal(goal_at(*self.home))
        self.assertEqual(self.result(), GoalStatus.PREEMPTED)
        self.assertTrue(other.wait_for_result(rospy.Duration(3 * PATIENCE)))
        self.assertEqual(other.get_state(), GoalStatus.SUCCEEDED)

    def test_05_what_cannot_be_reached_or_makes_no_sense_is_rejected_with_its_reason(self):
        grid = self.witness.last("pioneer/map")
        wall = grid.data.index(100)
        row, column = divmod(wall, grid.info.width)
        in_a_wall = (grid.info.origin.position.x + (column + 0.5) * grid.info.resolution,
                     grid.info.origin.position.y + (row + 0.5) * grid.info.resolution)
        before = self.truth()
        huge = goal_at(0.5, 0.0)
        huge.target_pose.pose.orientation.z = 1e200
        for goal, word in (
                (huge, "length 1e.200"),
                (goal_at(*in_a_wall), "wall"), (goal_at(1e6, 0.0), "outside"), (goal_at(math.nan, 0.0), "finite"),
                (goal_at(1.0, 1.0, frame="moon"), "moon"), (goal_at(0.5, 0.0, frame=""), "frame"),
                (goal_at(0.5, 0.0, frame="base_link", stamp=rospy.Time.now() - rospy.Duration(60)), "[6-9]. s old")):
            since = len(self.witness.seen["/rosout"])
            self.client.send_goal(goal)
            self.assertEqual(self.result(), GoalStatus.REJECTED, word)
            self.assertRegex(self.client.get_goal_status_text(), word)
            self.witness.next("pioneer/navigation", 3)
            told = [each.msg for each in self.witness.seen["/rosout"][since:]
                    if each.name == "/pioneer/navigation" and "refused" in each.msg]
            self.assertEqual(len(told), 1, told)
        self.assertEqual(self.truth(), before)

    def test_05b_a_client_that_still_sends_hears_of_the_refusal(self):
        """actionlib's client drops what it hears before its own call returns: the server must not be too quick."""
        client = actionlib.SimpleActionClient("pioneer/move_base", MoveBaseAction)
        client.wait_for_server(rospy.Duration(PATIENCE))
        send = client.action_client.send_goal

        def send_slowly(*arguments):
            handle = send(*arguments)
            time.sleep(0.1)     # as a program does that the computer gives no time
            return handle

        with unittest.mock.patch.object(client.action_client, "send_goal", send_slowly):
            client.send_goal(goal_at(1e6, 0.0))
        self.assertTrue(client.wait_for_result(rospy.Duration(PATIENCE)))
        self.assertEqual(client.get_state(), GoalStatus.REJECTED)

    def test_05c_a_place_that_nobody_knows_is_refused_with_those_alike(self):
        before = self.truth()
        answer = self.services["go_to"]("kitchn")
        self.assertFalse(answer.success)
        self.assertIn("did you mean 'kitchen'?", answer.message)
        self.assertEqual(self.truth(), before)

    def test_06_a_goal_in_the_frame_of_the_robot(self):
        start = self.truth()
        ahead = heading_of(start)
        self.client.send_goal(goal_at(0.3, 0.0, frame="base_link", stamp=rospy.Time(0)))
        self.assertEqual(self.result(), GoalStatus.SUCCEEDED, self.client.get_goal_status_text())
        self.assertLess(self.off(start.position.x + 0.3 * math.cos(ahead), start.position.y + 0.3 * math.sin(ahead)),
                        0.2)

    def test_07_services_tell_the_map_and_a_plan_without_driving(self):
        before = self.truth()
        told = self.services["static_map"]().map
        self.assertEqual(told, self.witness.last("pioneer/map"))
        place = self.far_goal()
        plan = self.services["move_base/make_plan"](
            goal_at(*self.home).target_pose, goal_at(place.x, place.y).target_pose, 0.0).plan
        end = plan.poses[-1].pose.position
        self.assertLess(math.hypot(end.x - place.x, end.y - place.y), 0.2)
        self.assertEqual(self.services["move_base/make_plan"](
            goal_at(*self.home).target_pose, goal_at(1e6, 0.0).target_pose, 0.0).plan.poses, [])
        from_here = self.services["move_base/make_plan"](
            PoseStamped(), goal_at(place.x, place.y, 2.0).target_pose, 0.0).plan.poses
        here = self.witness.last("pioneer/amcl_pose").pose.pose.position
        self.assertLess(math.hypot(from_here[0].pose.position.x - here.x, from_here[0].pose.position.y - here.y), 0.1)
        self.assertAlmostEqual(heading_of(from_here[-1].pose), 2.0, places=6)
        self.services["move_base/clear_costmaps"]()
        self.services["request_nomotion_update"]()
        self.assertEqual(self.truth(), before)

    def test_08_it_waits_for_a_person_at_the_helm_and_goes_on_after_the_release(self):
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        person = rospy.Publisher("pioneer/teleop/cmd_vel", Twist, queue_size=1)
        wait_until("the driver listens", person.get_num_connections)
        person.publish(Twist())
        self.stands()
        self.says("waiting", "helm")
        self.services["teleop/release"]()
        self.drives()

    def test_08b_its_goal_ends_when_another_program_drives_the_robot(self):
        """A stop of another program ends nothing: a program that ends sends some."""
        program = rospy.Publisher("pioneer/cmd_vel", Twist, queue_size=1)
        listeners = {"/pioneer/p2os", "/pioneer/navigation"}
        wait_until("driver and navigation listen", lambda: listeners <= {
            each[1] for each in program.impl.get_stats_info()})
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        program.publish(Twist())
        self.assertTrue(self.witness.next("pioneer/navigation", 3).goal)

        def ended():
            program.publish(Twist(linear=Vector3(x=0.05)))
            return self.client.simple_state == actionlib.SimpleGoalState.DONE

        wait_until("the goal ends", ended)
        program.publish(Twist())
        self.assertEqual(self.result(), GoalStatus.PREEMPTED)
        self.assertEqual(self.client.get_goal_status_text(), "%s drives the robot" % rospy.get_name())
        self.stands()

    def test_09_it_stands_without_motors_sonar_or_news_and_goes_on(self):
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        self.services["set_motors"](False)
        self.stands()
        self.says("waiting", "motor")
        places = self.witness.last("pioneer/places")
        name = places.names[places.poses.index(place)]
        self.assertEqual(self.services["go_to"](name).message,
                         "on the way to %s as soon as its motors are on"
                         " (rosservice call /pioneer/set_motors true)" % name)
        self.services["set_motors"](True)
        self.drives()
        self.services["simulator/add_fault"]("silence")
        self.says("waiting")
        self.stands()

    def test_09b_it_stands_when_a_wheel_stalls(self):
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        self.services["simulator/add_fault"]("stall")
        self.says("waiting", "a wheel stalls")
        self.stands()

    def test_10_a_goal_from_a_bag_is_refused(self):
        """It is said once, though the player sends many."""
        before, since = self.truth(), len(self.witness.seen["/rosout"])
        player = subprocess.Popen(
            ["rostopic", "pub", "-r", "5", "pioneer/move_base_simple/goal", "geometry_msgs/PoseStamped",
             "{header: {frame_id: map}, pose: {position: {x: %g, y: %g}, orientation: {w: 1}}}" % self.home,
             "__name:=play_1234"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self.addCleanup(player.wait)
        self.addCleanup(player.kill)

        def told():
            return [each.msg for each in self.witness.seen["/rosout"][since:] if "from a bag" in each.msg]

        wait_until("the goal is refused", told)
        self.witness.next("pioneer/navigation", 20)     # meanwhile the player sends more
        self.assertEqual(self.witness.last("pioneer/navigation").goal, [])
        self.assertEqual(self.truth(), before)
        self.assertEqual(len(told()), 1)

    def test_10b_a_pose_from_a_bag_is_refused(self):
        self.knows_where_it_is()    # after the faults before it may be in doubt, beside a can that it pushed
        since, pose = len(self.witness.seen["/rosout"]), self.witness.next("pioneer/navigation").pose
        player = subprocess.Popen(
            ["rostopic", "pub", "-1", "pioneer/initialpose", "geometry_msgs/PoseWithCovarianceStamped",
             "{header: {frame_id: map}, pose: {pose: {position: {x: %g, y: %g}, orientation: {w: 1}}}}" % self.home,
             "__name:=play_1235"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self.addCleanup(player.wait)
        self.addCleanup(player.kill)
        self.witness.wait("it is refused", lambda: self.logged("initialpose is refused: it is played back", since))
        after = self.witness.next("pioneer/navigation", 3)
        self.assertTrue(after.sure)
        self.assertLess(math.hypot(after.pose.x - pose.x, after.pose.y - pose.y), 0.1)

    def test_11_killed_on_its_way_the_robot_stands_and_has_its_own_brakes_again(self):
        self.knows_where_it_is()
        place = self.far_goal()
        self.client.send_goal(goal_at(place.x, place.y))
        self.drives()
        since = len(self.witness.seen["/rosout"])
        os.kill(process_of("/pioneer/navigation"), signal.SIGKILL)
        self.stands()
        self.witness.wait("brakes are put back", lambda: self.logged(
            "no more commands from /pioneer/navigation: the accelerations are as before", since))
        self.says("idle")       # it is back


if __name__ == "__main__":
    rospy.init_node("navigation_test")
    rostest.rosrun("pioneer_control", "navigation", NavigationTest)

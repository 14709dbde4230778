#!/usr/bin/python3
"""The driver with a camera, with a master: its topics and diagnostics, its end behind the wheels, a camera that is not
there, and the launch file.
"""

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "integration")]

from driver_lines import Driver
from pioneer_control.client.fault_flags import Level
from pioneer_control.msg import PTZState
from pioneer_control.robots import find_model
from pioneer_control.simulator import load_world, simulate
from pioneer_control.simulator.line import CameraPorts, Server
from witness import PATIENCE, Witness, wait_until

JOINTS = ["ptz_pan_joint", "ptz_tilt_joint"]


class PtzCamera(unittest.TestCase):
    """Each test has a robot, a camera, a driver and a namespace of its own."""

    def setUp(self):
        self.ending = contextlib.ExitStack()
        self.addCleanup(self.ending.close)
        self.namespace = "/" + self.id().rpartition(".")[2]

    def name(self, topic):
        return topic if topic.startswith("/") else "%s/%s" % (self.namespace, topic)

    def witness(self, **topics):
        return Witness(dict({self.name(topic): kind for topic, kind in topics.items()},
                            **{"/diagnostics": DiagnosticArray}))

    def served(self, **ports):
        """Return a server of a robot with a camera, and the camera."""
        simulation = simulate(load_world("empty"), find_model("p3dx-sh"), 1, None, 0)
        server = self.ending.enter_context(Server(simulation, tcp=0, cameras=CameraPorts("vcc4", **ports)))
        return server, server.firmware.hardware.aux[0].joined

    def driver(self, port, **parameters):
        driver = Driver(self.namespace, port=port, **parameters)
        self.ending.callback(driver.end)
        return driver

    def publisher(self, topic, kind):
        publisher = rospy.Publisher(self.name(topic), kind, queue_size=10)
        wait_until("the driver hears %s" % topic, publisher.get_num_connections)
        return publisher

    def call(self, service, kind, *values):
        rospy.wait_for_service(self.name(service), PATIENCE)
        return rospy.ServiceProxy(self.name(service), kind)(*values)

    def wait_for_health(self, seen, level, text):
        def newest():
            return next((status for message in reversed(seen.seen["/diagnostics"]) for status in message.status
                         if status.name.startswith(self.namespace[1:]) and status.name.endswith(": Camera")), None)

        seen.wait("diagnostics: %s %s" % (level, text),
                  lambda: newest() is not None and newest().level == level and text in newest().message)
        return {each.key: each.value for each in newest().values}

    def wait_for_state(self, seen, pan, tilt, zoom):
        topic = self.name("ptz_state")
        seen.wait("ptz_state %s %s %s" % (pan, tilt, zoom), lambda: seen.seen[topic] and (
            seen.seen[topic][-1].pan, seen.seen[topic][-1].tilt, seen.seen[topic][-1].zoom) == (pan, tilt, zoom))

    def test_topics_and_the_end_behind_the_wheels(self):
        server, camera = self.served()
        seen = self.witness(ptz_state=PTZState, joint_states=JointState, ptz_view=Marker, pose=Odometry)
        moved_at_power_off = []

        def look():
            if not camera.is_on and not moved_at_power_off:
                moved_at_power_off.append((server.firmware.velocity, server.firmware.motors_enabled))

        driver = self.driver(server.url, ptz="vcc4", ptz_power_off_at_end=True, ptz_place="[0.1,0,0.3]")
        driver.says("camera: ready")
        values = self.wait_for_health(seen, Level.OK, "ready, says where it looks")
        self.assertEqual((values["Cabling"], values["Power"]), ("two-way: it answers", "on"))
        self.wait_for_state(seen, 0, 0, 0)
        control = self.publisher("ptz_control", PTZState)
        control.publish(PTZState(45, 20, 1000, False))
        self.wait_for_state(seen, 45, 20, 1000)
        self.assertEqual((camera.pan.position, camera.tilt.position, camera.zoom.position), (400, 178, 1000))
        control.publish(PTZState(-5, 0, 0, True))
        self.wait_for_state(seen, 40, 20, 1000)
        seen.wait("joint_states", lambda: any(
            message.name == JOINTS and abs(message.position[0] + math.radians(40.0)) < 0.002
            for message in seen.seen[self.name("joint_states")]))
        frames = Witness({"/tf": TFMessage})
        frames.wait("tf of the camera", lambda: any(
            each.child_frame_id == "camera" for message in frames.seen["/tf"] for each in message.transforms))
        self.assertEqual(seen.last(self.name("ptz_view")).header.frame_id, "camera")
        self.assertTrue(self.call("ptz/home", Trigger).success)
        self.wait_for_state(seen, 0, 0, 1000)
        self.assertTrue(self.call("ptz/stop", Trigger).success)

        self.assertTrue(self.call("set_motors", SetBool, True).success)
        drive = self.publisher("cmd_vel", Twist)
        command = Twist()
        command.linear.x = 0.3
        timer = rospy.Timer(rospy.Duration(0.05), lambda _: drive.publish(command))
        self.ending.callback(timer.shutdown)
        wait_until("it drives", lambda: server.firmware.velocity[0] > 0.25)
        with server.lock:
            step = camera.step
            camera.step = lambda now_us: (step(now_us), look())
        begun = time.monotonic()
        self.assertEqual(driver.end(signal.SIGTERM), 0, driver.printed)
        self.assertLess(time.monotonic() - begun, 15.0)
        self.assertNotIn("Traceback", driver.printed)
        self.assertEqual(moved_at_power_off, [((0.0, 0.0), False)])
        wait_until("the session is closed", lambda: server.firmware.open_session is None)

    def test_a_camera_that_is_not_there_holds_nothing_up(self):
        server, camera = self.served(cabling="one_way")
        seen = self.witness(pose=Odometry)
        driver = self.driver(server.url, ptz="vcc4", ptz_cabling="two_way", ptz_power_off_at_end=True)
        driver.says("camera: CONTROL 0: it does not answer")
        self.wait_for_health(seen, Level.ERROR, "it does not answer: its power, its cable, or the port")
        self.assertTrue(self.call("set_motors", SetBool, True).success)
        drive = self.publisher("cmd_vel", Twist)
        command = Twist()
        command.linear.x = 0.3
        timer = rospy.Timer(rospy.Duration(0.05), lambda _: drive.publish(command))
        self.ending.callback(timer.shutdown)
        wait_until("it drives", lambda: server.firmware.velocity[0] > 0.25)
        refused = self.call("ptz/home", Trigger)
        self.assertFalse(refused.success)
        self.assertIn("it does not answer", refused.message)
        self.assertEqual(driver.end(signal.SIGTERM), 0, driver.printed)
        self.assertNotIn("Traceback", driver.printed)
        wait_until("the session is closed", lambda: server.firmware.open_session is None)

    def test_on_a_port_of_its_own(self):
        server, _ = self.served(tcp=0)
        berth, = server.cameras
        seen = self.witness(ptz_state=PTZState)
        driver = self.driver(server.url, ptz="vcc4", ptz_port=berth.place, ptz_power_off_at_end=True)
        driver.says("camera: ready")
        self.publisher("ptz_control", PTZState).publish(PTZState(-30, -10, 0, False))
        self.wait_for_state(seen, -30, -10, 0)
        self.assertEqual(driver.end(), 0, driver.printed)
        self.assertFalse(berth.camera.is_on)

    def test_the_launch_file(self):
        seen = self.witness(ptz_state=PTZState)
        launch = subprocess.Popen([
            "roslaunch", "pioneer_control", "pioneer.launch", "robot:=" + self.namespace[1:], "sim:=true",
            "world:=empty", "ptz:=vcc4", "ptz_place:=[0.1, 0, 0.3]"])
        self.ending.callback(launch.kill)
        frames = Witness({"/tf": TFMessage})
        self.wait_for_state(seen, 0, 0, 0)
        frames.wait("tf of the camera", lambda: any(
            each.child_frame_id == self.namespace[1:] + "/camera"
            for message in frames.seen["/tf"] for each in message.transforms))
        launch.send_signal(signal.SIGINT)
        self.assertEqual(launch.wait(PATIENCE), 0)


if __name__ == "__main__":
    rospy.init_node("ptz_camera_witness")
    rostest.rosrun("pioneer_control", "ptz_camera", PtzCamera)

#!/usr/bin/python3
"""The driver between ROS and the wire: the effects of parameters on the wire, bad lines, bad parameters, a killed
driver, and two robots.
"""

import contextlib
import ctypes
import dataclasses
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
import unittest
from xmlrpc.client import ServerProxy

import rosbag
import rosgraph
import rosnode
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

HERE = os.path.dirname(os.path.abspath(__file__))
NODES = os.path.join(HERE, "..", "..", "nodes")
sys.path[:0] = [HERE, os.path.join(HERE, "..", "integration")]

from client_lines import Adapter, SpoiltLine
from pioneer_control.bags.wire import main as bag_to_wire
from pioneer_control.msg import GripperState, MotorState, RobotInfo, SonarArray
from pioneer_control.p2os import FrameDecoder, decode_command
from pioneer_control.p2os.recording import read_record
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.played import PlayedRobot
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.line import Server
from hanging_master import HangingMaster
from witness import PATIENCE, Witness, heading_of

SIGNALLED_AT = (
    ("p2os_driver", "registerPublisher.*/rosout", False),       # the first four: in rospy.init_node
    ("p2os_driver", "getParam.*/use_sim_time", True),
    ("p2os_simulator", "registerService.*/get_loggers", False),
    ("rosPioneer1.py", "registerService.*/set_logger", True),
    ("p2os_driver", "getParam.*/p2os/", False),
    ("p2os_driver", "registerPublisher.*/pose", True),
    ("p2os_driver", "registerSubscriber.*/cmd_vel", False),
    ("p2os_driver", "registerService.*/set_motors", True),
    ("p2os_driver", "setParam|registerPublisher.*/parameter_updates", True),
    ("p2os_driver", "registerPublisher.*/sonar_ranges", False),     # when the robot is found
)
"""A program, the question that it asks the master when the signal comes, and whether the master then answers after all.

The question is a regular expression.
"""
HANDLES_ITSELF = """
import os, signal, rospy
from pioneer_control.ros_node import init_node
signal.signal(signal.SIGUSR1, lambda *_: None)
init_node("handles_itself")
rospy.core.add_preshutdown_hook(print)
os.kill(os.getpid(), signal.SIGUSR1)
os.kill(os.getpid(), signal.SIGTERM)
rospy.spin()
"""
"""A node with a signal handler of its own. It prints why it ends."""
GLOBAL = {"/rosout", "/tf", "/tf_static", "/clock", "/diagnostics"}
"""What all nodes share: all of the names of a driver that do not begin with its namespace."""


class OverheardFirmware(Firmware):
    """A robot that keeps the commands it got, as (simulated time, name, value)."""

    def __init__(self, **options):
        super().__init__(find_model("p3dx-sh"), load_world("empty"), **options)
        self.heard = []
        self._ear = FrameDecoder()

    def receive(self, data):
        self.heard += [(self.time, command.name, command.value)
                       for command in map(decode_command, self._ear.feed(data))]
        super().receive(data)


class Driver:
    """A process of p2os_driver (or of another node) in a namespace of its own. It keeps the output."""

    def __init__(self, namespace, environment=None, program="p2os_driver", **parameters):
        self.namespace = namespace
        arguments = ["_%s:=%s" % item for item in parameters.items()]
        self.process = subprocess.Popen(
            [os.path.join(NODES, program), "__ns:=" + namespace] + arguments,
            env=dict(environment or os.environ, PYTHONFAULTHANDLER="1"),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        self.printed, self._changed = "", threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            with self._changed:
                self.printed += line
                self._changed.notify_all()

    def says(self, text, times=1):
        with self._changed:
            said = self._changed.wait_for(lambda: self.printed.count(text) >= times, PATIENCE)
            assert said, "not said: %s\n%s" % (text, self.printed)

    def end(self, how=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.exit_code()

    def exit_code(self):
        """Wait for the end, and return the exit code. A process that does not end tells where each thread hangs."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGABRT)
            self._reader.join(PATIENCE)
            raise AssertionError("not ended within %.0f s:\n%s" % (PATIENCE, self.printed)) from None
        finally:
            self._reader.join(PATIENCE)


class Master:
    """A roscore of its own that can die and come back. Programs with its ``environment`` use it."""

    def __init__(self):
        with socket.create_server(("127.0.0.1", 0)) as placeholder:
            self._port = placeholder.getsockname()[1]
        self.environment = dict(os.environ, ROS_MASTER_URI="http://127.0.0.1:%d" % self._port)
        self.start()

    def start(self):
        self._process = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(self._port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(int(PATIENCE / 0.05)):
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self._port)):
                return
            time.sleep(0.05)
        raise AssertionError("no master on port %d" % self._port)

    def end(self):
        self._process.kill()
        self._process.wait()


class DeafReader:
    """A subscriber that connects and then never reads, so that its messages pile up."""

    def __init__(self, node, topic, kind):
        _, _, (_, host, port) = ServerProxy(rosnode.get_api_uri(rosgraph.Master("/deaf"), node)).requestTopic(
            "/deaf", topic, [["TCPROS"]])
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)     # as little as there is
        self._socket.connect((host, port))
        fields = {"callerid": "/deaf", "topic": topic, "type": kind._type, "md5sum": kind._md5sum}
        header = b"".join(struct.pack("<I", len(field)) + field
                          for field in (("%s=%s" % item).encode() for item in fields.items()))
        self._socket.sendall(struct.pack("<I", len(header)) + header)

    @property
    def unread(self):
        """Return how many bytes wait in the driver's socket. When no more fit, the number stays the same."""
        mine = "%04X" % self._socket.getsockname()[1]
        with open("/proc/net/tcp") as table:
            rows = [row.split() for row in table]
        return sum(int(row[4].partition(":")[0], 16) for row in rows[1:] if row[2].rpartition(":")[2] == mine)

    def close(self):
        self._socket.close()


class DriverLines(unittest.TestCase):
    """Each test has a robot, a driver and a namespace of its own."""

    def setUp(self):
        self.ending = contextlib.ExitStack()
        self.addCleanup(self.ending.close)
        self.namespace = "/" + self.id().rpartition(".")[2]

    def robot(self, **options):
        firmware = OverheardFirmware(**options)
        server = self.ending.enter_context(Server(firmware, tcp=0))
        return firmware, server

    def driver(self, port, namespace=None, **parameters):
        driver = Driver(namespace or self.namespace, port=port, **parameters)
        self.ending.callback(driver.end)
        return driver

    def witness(self, **topics):
        return Witness({"%s/%s" % (self.namespace, topic): kind for topic, kind in topics.items()})

    def motors_on(self, driver):
        driver.says("connected to")
        service = driver.namespace + "/set_motors"
        rospy.wait_for_service(service, PATIENCE)
        answer = rospy.ServiceProxy(service, SetBool)(True)
        self.assertTrue(answer.success, answer.message)

    def until(self, what, condition):
        """Check a condition again and again until it holds. No message tells when it does."""
        deadline = threading.Event()
        for _ in range(int(PATIENCE / 0.05)):
            if condition():
                return
            deadline.wait(0.05)
        self.fail("not within %.0f s: %s" % (PATIENCE, what))

    @contextlib.contextmanager
    def commanding(self, linear, namespace=None, angular=0.0):
        """Publish a velocity at 10 Hz while the `with` block runs."""
        publisher = rospy.Publisher((namespace or self.namespace) + "/cmd_vel", Twist, queue_size=1)
        ended = threading.Event()

        def run():
            twist = Twist()
            twist.linear.x, twist.angular.z = linear, angular
            while not ended.wait(0.1):
                publisher.publish(twist)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            publisher.unregister()

    def test_use_sonar_false_switches_the_sonar_off_and_its_topic(self):
        firmware, server = self.robot()
        seen = self.witness(sonar=SonarArray, motor_state=MotorState)
        self.driver(server.url, use_sonar="false")
        seen.next(self.namespace + "/motor_state", 10)
        self.assertIn(("SONAR", 0), [(name, value) for _, name, value in firmware.heard])
        self.assertEqual(seen.seen[self.namespace + "/sonar"], [])

    def test_use_sonar_true_switches_it_on(self):
        firmware, server = self.robot()
        seen = self.witness(sonar=SonarArray)
        self.driver(server.url)
        seen.last(self.namespace + "/sonar")
        self.assertNotIn(("SONAR", 0), [(name, value) for _, name, value in firmware.heard])

    def test_pulse_is_the_time_between_signs_of_life_and_zero_sends_none(self):
        """The test counts over 3 simulated seconds of idle drivers."""
        robots = {}
        for pulse in (0.2, 1.5, 0.0):
            firmware, server = self.robot()
            namespace = "%s_%d" % (self.namespace, 10 * pulse)
            robots[pulse] = firmware, self.driver(server.url, namespace=namespace, pulse=pulse)
        for _, driver in robots.values():
            driver.says("motors are off")
        starts = {pulse: firmware.time + 0.5 for pulse, (firmware, _) in robots.items()}
        counts = {}
        for pulse, (firmware, _) in robots.items():
            start = starts[pulse]
            self.until("3 simulated seconds", lambda: firmware.time > start + 3)
            counts[pulse] = sum(1 for time, _, _ in firmware.heard if start < time < start + 3)
        self.assertGreater(counts[0.2], 8)
        self.assertLess(counts[1.5], 4)
        self.assertEqual(counts[0.0], 0)

    def test_pulse_does_not_keep_the_robot_driving(self):
        firmware, server = self.robot()
        self.motors_on(self.driver(server.url, pulse=0.2))
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
        self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))

    def test_limits_of_the_parameters_hold(self):
        firmware, server = self.robot()
        driver = self.driver(server.url, max_xspeed=0.15, max_yawspeed=0.5, cmd_vel_timeout=0.3)
        self.motors_on(driver)
        with self.commanding(2.0, angular=-2.0):
            self.until("it drives", lambda: firmware.velocity[0] > 0.14)
        self.assertEqual(max(value for _, name, value in firmware.heard if name == "VEL"), 150)
        self.assertEqual(min(value for _, name, value in firmware.heard if name == "RVEL"), -28)
        driver.says("no velocity came for 0.3 s")

    def test_frames_gripper_and_calibration_are_the_users(self):
        firmware, server = self.robot()
        seen = self.witness(pose=Odometry, robot_info=RobotInfo)
        transforms = Witness({"/tf": TFMessage})
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as models:
            models.write("models: {p3at-sh: {width_mm: 480}}")
            models.flush()
            self.driver(server.url, model="p3at-sh", models_file=models.name, gripper="false", publish_tf="false",
                        odom_frame_id="here", base_link_frame_id="me", frame_prefix="my/")
            pose, info = seen.next(self.namespace + "/pose", 5), seen.last(self.namespace + "/robot_info")
        self.assertEqual((pose.header.frame_id, pose.child_frame_id), ("my/here", "my/me"))
        self.assertEqual([message for message in transforms.seen["/tf"]
                          if message.transforms[0].child_frame_id == "my/me"], [])
        self.assertFalse(info.has_gripper)
        self.assertAlmostEqual(max(point.y for point in info.footprint.points), 0.24)

    def test_baud_is_the_speed_of_the_serial_line(self):
        with tempfile.TemporaryDirectory() as folder:
            link = os.path.join(folder, "robot")
            numbers = standard_numbers()
            numbers = dataclasses.replace(numbers, session=dataclasses.replace(numbers.session, host_baud=38400))
            self.ending.enter_context(Server(OverheardFirmware(numbers=numbers), pty=link))
            self.driver(link, baud=38400).says("connected to")
            line = os.open(link, os.O_RDWR | os.O_NOCTTY)
            self.addCleanup(os.close, line)
            self.assertEqual(termios.tcgetattr(line)[5], termios.B38400)

    def test_half_of_the_traffic_malformed(self):
        """The driver drives all the same, and its reports are never wrong."""
        firmware, server = self.robot()
        seen = self.witness(pose=Odometry)
        with SpoiltLine(int(server.url.rpartition(":")[2])) as line:
            driver = self.driver(line.url)
            self.motors_on(driver)
            line.spoil = 0.5
            with self.commanding(0.3):
                self.until("it drives", lambda: firmware.velocity[0] > 0.2)
                self.until("it goes on", lambda: firmware.internal_counts[0] > 500)
            self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
            line.spoil = 0.0
            seen.next(self.namespace + "/pose", 3)
            self.assertGreater(line.spoilt, 20)
            self.assertAlmostEqual(seen.seen[self.namespace + "/pose"][-1].pose.pose.position.x,
                                   firmware.internal_counts[0] / 1000, delta=0.002)
            driver.end()
        counted = re.search(r"closed after (\d+) packets, (\d+) with a bad checksum, (\d+) stray bytes", driver.printed)
        self.assertIsNotNone(counted, driver.printed)
        for number in counted.groups():
            self.assertGreater(int(number), 0)

    def kill(self, driver, firmware):
        """Kill a driver, and wait until the robot has read what the driver wrote last."""
        driver.end(signal.SIGKILL)
        killed_at = firmware.time
        self.until("the robot reads the last commands", lambda: firmware.time > killed_at + 0.1)

    def test_killed_while_driving_and_restarted_while_the_robot_streams(self):
        """This needs a serial line: on TCP the simulated robot ends a session when another client connects."""
        firmware = OverheardFirmware()
        port = os.path.join(self.ending.enter_context(tempfile.TemporaryDirectory()), "robot")
        self.ending.enter_context(Server(firmware, pty=port))
        first = self.driver(port, namespace="/first")
        self.motors_on(first)
        with self.commanding(0.2, "/first"):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
            self.kill(first, firmware)
        self.assertEqual(firmware.session, FirmwareState.OPEN)
        before = len(firmware.heard)
        seen = self.witness(motor_state=MotorState)
        second = self.driver(port)
        second.says("connected to sim_0001")
        self.assertEqual(firmware.heard[before][1], "CLOSE", "before anything that could revive the old set points")
        self.assertEqual(seen.last(self.namespace + "/motor_state").state, 0)
        self.assertEqual(firmware.velocity, (0.0, 0.0))

    def test_killed_while_driving_the_robots_own_watchdog_stops_it(self):
        firmware, server = self.robot()
        driver = self.driver(server.url)
        self.motors_on(driver)
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
            self.kill(driver, firmware)
            last = len(firmware.heard)
            self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
        self.assertTrue(firmware.watchdog_expired)
        self.assertEqual(len(firmware.heard), last, "nobody told it to")

    def test_simulated_time_that_stands_and_jumps_back_moves_and_stops_nothing(self):
        """As with `rosbag play --clock --loop`. ROS time is used for the stamps and for nothing else."""
        firmware, server = self.robot()
        clock = rospy.Publisher("/clock", Clock, queue_size=1, latch=True)
        self.addCleanup(clock.unregister)
        seen = self.witness(pose=Odometry)
        poses = seen.seen[self.namespace + "/pose"]
        clock.publish(Clock(rospy.Time(100)))
        rospy.set_param("/use_sim_time", True)
        try:
            driver = self.driver(server.url)
            self.motors_on(driver)
        finally:
            rospy.set_param("/use_sim_time", False)
        for times in ((200, 50), (50, 10)):
            with self.commanding(0.2):
                for second in times:
                    clock.publish(Clock(rospy.Time(second)))
                    seen.wait("it drives at %d" % second, lambda: (
                        poses and poses[-1].twist.twist.linear.x > 0.15 and
                        second - 1 <= poses[-1].header.stamp.to_sec() <= second))
            self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
        driver.says("no velocity came for 0.6 s")
        self.assertEqual(driver.end(), 0)

    def ended_while_driving(self, end):
        firmware, server = self.robot()
        driver = self.driver(server.url)
        self.motors_on(driver)
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
            end(driver)
        self.assertEqual(driver.exit_code(), 0, driver.printed)
        self.until("the session is closed", lambda: firmware.session is FirmwareState.WAITING)
        self.assertFalse(firmware.motors_enabled)
        self.assertIn("CLOSE", [name for _, name, _ in firmware.heard])

    def test_sigint_stops_the_robot(self):
        self.ended_while_driving(lambda driver: driver.process.send_signal(signal.SIGINT))

    def test_a_signal_that_the_main_thread_does_not_notice_stops_the_robot(self):
        """The test sends the signal to another thread. The main thread waits for a lock and does not notice it."""
        def signal_another_thread(driver):
            main = driver.process.pid
            another = max(thread for thread in map(int, os.listdir("/proc/%d/task" % main)) if thread != main)
            self.assertEqual(ctypes.CDLL(None).tgkill(main, another, signal.SIGINT), 0)

        self.ended_while_driving(signal_another_thread)

    def test_a_signal_that_a_program_handles_itself_does_not_end_its_node(self):
        """The node ends with the next signal, and names that one."""
        ended = subprocess.run([sys.executable, "-c", HANDLES_ITSELF], stdout=subprocess.PIPE, timeout=PATIENCE)
        self.assertEqual((ended.returncode, ended.stdout), (0, b"signal %d\n" % signal.SIGTERM))

    def test_sigterm_stops_the_robot(self):
        self.ended_while_driving(lambda driver: driver.process.send_signal(signal.SIGTERM))

    def test_a_closed_terminal_stops_the_robot(self):
        self.ended_while_driving(lambda driver: driver.process.send_signal(signal.SIGHUP))

    def test_rosnode_kill_stops_the_robot(self):
        kill = ["rosnode", "kill", self.namespace + "/p2os"]
        self.ended_while_driving(lambda driver: subprocess.run(kill, check=True, stdout=subprocess.DEVNULL))

    def test_a_robot_without_gripper_publishes_no_gripper_state(self):
        _, server = self.robot(gripper=False)
        seen = self.witness(motor_state=MotorState, gripper_state=GripperState)
        self.driver(server.url)
        seen.next(self.namespace + "/motor_state", 10)
        self.assertNotIn(self.namespace + "/gripper_state", [name for name, _ in rospy.get_published_topics()])

    def cut_and_mended(self, port, cut, mend):
        """Pull the cable while the user drives and goes on driving, and check all that must hold until somebody
        switches the motors on again.
        """
        firmware, driver = self.firmware, self.driver(port)
        self.motors_on(driver)
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
            cut()
            self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
            mend()
            driver.says("connected to", 2)
            states = Witness({self.namespace + "/motor_state": MotorState})
            states.next(self.namespace + "/motor_state", 2)
            self.assertEqual(firmware.velocity, (0.0, 0.0))
            before = firmware.true_pose
            states.next(self.namespace + "/motor_state", 8)
            self.assertEqual({message.state for message in states.seen[self.namespace + "/motor_state"]}, {0})
            self.assertEqual(firmware.true_pose, before, "commands go on, but nothing moves")
            self.assertIsNone(driver.process.poll())
            self.motors_on(driver)
            self.until("it drives again", lambda: firmware.velocity[0] > 0.15)
        self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
        self.assertEqual(driver.end(), 0)
        self.assertNotIn("Traceback", driver.printed)

    def test_a_cut_tcp_line(self):
        self.firmware, server = self.robot()
        line = self.ending.enter_context(SpoiltLine(int(server.url.rpartition(":")[2])))
        self.cut_and_mended(line.url, line.cut, lambda: None)

    def test_a_serial_adapter_pulled_and_put_back_under_another_name(self):
        self.firmware, server = self.robot()
        port = int(server.url.rpartition(":")[2])
        first = self.ending.enter_context(Adapter(port))
        with tempfile.TemporaryDirectory() as folder:
            link = os.path.join(folder, "pioneer")
            os.symlink(first.device, link)

            def unplug():
                first.unplug()
                os.unlink(link)

            def plug_in():
                os.symlink(self.ending.enter_context(Adapter(port)).device, link)

            self.cut_and_mended(link, unplug, plug_in)

    def test_the_master_dies_and_another_takes_its_place(self):
        """Nodes of this ROS do not register at a new master. Existing connections stay, the driver still stops the
        robot when no velocity comes, and the end is clean.
        """
        master = Master()
        self.ending.callback(lambda: master.end())
        firmware, server = self.robot()
        driver = self.driver(server.url, environment=master.environment)
        driver.says("connected to")
        subprocess.run(["rosservice", "call", "--wait", self.namespace + "/set_motors", "true"],
                       env=master.environment, check=True, stdout=subprocess.DEVNULL)
        drive = [
            "rostopic", "pub", "-r", "10", self.namespace + "/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.2}}"]
        commander = subprocess.Popen(
            drive, env=master.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.ending.callback(commander.kill)
        self.until("it drives", lambda: firmware.velocity[0] > 0.15)
        master.end()
        x = firmware.true_pose[0]
        self.until("it drives on without a master", lambda: firmware.true_pose[0] > x + 0.3)
        master.start()
        x = firmware.true_pose[0]
        self.until("and with another one", lambda: firmware.true_pose[0] > x + 0.3)
        commander.kill()
        self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
        driver.says("no velocity came for")
        self.assertIsNone(driver.process.poll())
        master.end()
        self.assertEqual(driver.end(), 0, driver.printed)
        self.assertIs(firmware.session, FirmwareState.WAITING)
        self.assertFalse(firmware.motors_enabled)

    def test_a_master_that_hangs_keeps_no_driver_from_its_end(self):
        master = HangingMaster()
        self.ending.callback(master.close)
        firmware, server = self.robot()
        driver = self.driver(server.url, environment=master.environment)
        self.motors_on(driver)
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
            master.hang()
            asker = subprocess.Popen(
                ["rosparam", "get", "/rosdistro"],
                env=master.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.ending.callback(asker.kill)
            master.wait_until_asked()
            with self.commanding(float("nan")):
                # a line of the log, for /rosout, waits for the master
                driver.says("cmd_vel refused: linear.x is nan")
            x = firmware.internal_counts[0]
            self.until("it drives on", lambda: firmware.internal_counts[0] > x + 100)
            before = len(firmware.heard)
            self.assertEqual(driver.end(), 0, driver.printed)
        self.assertIs(firmware.session, FirmwareState.WAITING)
        self.assertEqual((firmware.motors_enabled, firmware.velocity), (False, (0.0, 0.0)))
        told = [name for _, name, _ in firmware.heard[before:]]
        self.assertLess(told.index("STOP"), told.index("CLOSE"))
        self.assertNotIn("Traceback", driver.printed)
        self.assertIsNone(asker.poll(), "it does hang: others wait for ever")

    def test_a_signal_while_a_node_starts(self):
        """The master hangs, or answers late. In both cases the program ends, and reports no error."""
        running = []
        for number, (program, question, answers) in enumerate(SIGNALLED_AT):
            master = HangingMaster(hang_at=question)
            self.ending.callback(master.close)
            ours = {"p2os_driver": dict(port=self.robot()[1].url), "p2os_simulator": dict(tcp=0)}.get(program, {})
            node = Driver("%s_%d" % (self.namespace, number), environment=master.environment, program=program, **ours)
            self.ending.callback(node.end, signal.SIGKILL)
            running.append((answers, master, node, question))
        for number, (answers, master, node, question) in enumerate(running):
            master.wait_until_asked(node)
            node.process.send_signal((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[number % 3])
            if answers:
                master.mend()
        for answers, _, node, question in running:
            said = "at %s, answers %s:\n%s" % (question, answers, node.printed)
            self.assertEqual(node.exit_code(), 0, said)
            node.end()
            self.assertNotIn("Traceback", node.printed, said)
            # The master still knows these nodes. It would go on to ask their ports, soon perhaps of another program.
            rosnode.cleanup_master_blacklist(rosgraph.Master("/cleanup"), rosnode.get_node_names(node.namespace))

    def test_whom_a_hanging_master_did_not_introduce_is_refused_unless_he_stops(self):
        master = HangingMaster()
        self.ending.callback(master.close)
        firmware, server = self.robot()
        said = Witness({"/diagnostics": DiagnosticArray})
        driver = self.driver(server.url, environment=master.environment)
        publisher = rospy.Publisher(self.namespace + "/cmd_motor_state", MotorState, queue_size=10)
        self.addCleanup(publisher.unregister)
        rospy.wait_for_service(self.namespace + "/p2os/set_parameters", PATIENCE)
        said.wait("all is registered", lambda: any(
            self.namespace[1:] in status.name and status.level == DiagnosticStatus.OK
            for message in said.seen["/diagnostics"] for status in message.status))
        self.until("the driver listens", publisher.get_num_connections)
        master.hang()
        publisher.publish(MotorState(1))
        driver.says("cmd_motor_state refused: the ROS master does not say in time")
        before = len(firmware.heard)
        # again and again: on a busy computer the driver may have no link to the robot yet
        self.until("motors off is told", lambda: publisher.publish(MotorState(0)) or ("ENABLE", 0) in [
            (name, value) for _, name, value in firmware.heard[before:]])
        self.assertNotIn(("ENABLE", 1), [(name, value) for _, name, value in firmware.heard])
        master.mend()
        self.until("motors are on", lambda: publisher.publish(MotorState(1)) or firmware.motors_enabled)

    def test_a_subscriber_that_never_reads_holds_up_nothing(self):
        """A message with a long frame name fills the buffers of the connection at once."""
        numbers = standard_numbers()
        quick = dataclasses.replace(numbers, session=dataclasses.replace(numbers.session, sip_cycle_ms=20))
        firmware, server = self.robot(numbers=quick)
        driver = self.driver(server.url, odom_frame_id="o" * 50000, publish_tf="false")
        self.motors_on(driver)
        seen = self.witness(pose=Odometry)
        reader = DeafReader(self.namespace + "/p2os", self.namespace + "/pose", Odometry)
        self.ending.callback(reader.close)

        def stuck():
            before = reader.unread
            seen.next(self.namespace + "/pose", 20)
            return 0 < before == reader.unread

        self.until("the driver's side is full", stuck)
        with self.commanding(0.2):
            self.until("it drives", lambda: firmware.velocity[0] > 0.15)
        self.until("it stands", lambda: firmware.velocity == (0.0, 0.0))
        seen.next(self.namespace + "/pose", 50)
        self.assertEqual(driver.end(), 0, driver.printed)
        self.assertIs(firmware.session, FirmwareState.WAITING)

    def test_two_robots_in_one_graph(self):
        robots = {}
        for name in ("left", "right"):
            firmware, server = self.robot(name=name)
            namespace = "%s/%s" % (self.namespace, name)
            driver = self.driver(server.url, namespace=namespace, frame_prefix=name + "/")
            robots[namespace] = (firmware, driver, Witness({namespace + "/pose": Odometry}))
        for namespace, (_, _, seen) in robots.items():
            self.assertEqual(seen.last(namespace + "/pose").header.frame_id, namespace.rpartition("/")[2] + "/odom")
        driven, standing = robots
        self.motors_on(robots[driven][1])
        with self.commanding(0.2, driven):
            self.until("one drives", lambda: robots[driven][0].velocity[0] > 0.15)
        self.assertEqual(robots[standing][0].internal_counts, (0, 0))
        self.assertNotIn(("ENABLE", 1), [(name, value) for _, name, value in robots[standing][0].heard])
        for kind in rosgraph.Master("/test").getSystemState():      # topics published, topics subscribed, services
            for namespace in robots:
                names = {name for name, nodes in kind if namespace + "/p2os" in nodes}
                self.assertEqual({name for name in names if not name.startswith(namespace + "/")} - GLOBAL, set(),
                                 "nothing absolute")

    def test_bad_parameters_are_named_and_end_the_driver(self):
        driver = self.driver("/dev/null", pulse="often", max_xspeed=-1, use_sonr="true")
        self.assertEqual(driver.end(0), 2)
        for text in ("~pulse = 'often' is not legal", "~max_xspeed = -1 is not legal: give a number from 0.01 to 3",
                     "did you mean ~use_sonar?"):
            self.assertIn(text, driver.printed)
        self.assertNotIn("Traceback", driver.printed)

    def test_a_model_that_nobody_knows_ends_the_driver(self):
        driver = self.driver("/dev/null", model="p3dz")
        self.assertEqual(driver.end(0), 2)
        self.assertIn("p3dz", driver.printed)
        self.assertIn("p3dx", driver.printed)
        self.assertNotIn("Traceback", driver.printed)

    def test_a_port_that_does_not_exist_is_named_and_tried_again(self):
        driver = self.driver("/dev/nowhere")
        driver.says("/dev/nowhere: no such port")
        driver.says("sim:=true")
        self.assertIsNone(driver.process.poll(), "the robot may still be plugged in")

    def test_an_unknown_subtype_is_final_and_says_what_to_do(self):
        firmware, server = self.robot()
        firmware.hardware.model = type(firmware.model)(**dict(vars(firmware.model), subtype="p3dz"))
        driver = self.driver(server.url)
        self.assertEqual(driver.exit_code(), 1)
        driver.end()
        self.assertIn("unknown robot model 'p3dz' (near: p3dx", driver.printed)
        self.assertFalse(firmware.motors_enabled)

    def test_every_byte_of_the_line_is_in_the_bag_and_plays_to_another_driver_as_the_same_run(self):
        folder = self.ending.enter_context(tempfile.TemporaryDirectory())
        bag, record, wire = (os.path.join(folder, name) for name in ("run.bag", "simulator.wire", "run.wire"))
        topics = [self.namespace + "/wire", self.namespace + "/pose"]
        recorder = subprocess.Popen(["rosbag", "record", "-q", "-O", bag, *topics])
        self.ending.callback(recorder.kill)
        self.until("the recorder listens", lambda: (
            {name for name, _ in rosgraph.Master("/asks").getSystemState()[1]} >= set(topics)))
        server = self.ending.enter_context(Server(OverheardFirmware(), tcp=0, record=record))
        driver = self.driver(server.url, publish_wire="true")
        seen = self.witness(pose=Odometry)
        self.motors_on(driver)
        with self.commanding(0.3, angular=0.4):
            seen.wait("driven", lambda: seen.seen[topics[1]] and seen.seen[topics[1]][-1].pose.pose.position.x > 0.15)
        recorder.send_signal(signal.SIGINT)
        self.assertEqual(recorder.wait(PATIENCE), 0)
        driver.end()
        server.stop()

        self.assertEqual(bag_to_wire([bag]), 0)
        entries = {path: read_record(path) for path in (record, wire)}
        self.assertFalse([entry.note for entry in entries[wire] if "missing" in entry.note])
        for to_robot in (True, False):
            whole, kept = (b"".join(entry.data for entry in entries[path] if entry.to_robot == to_robot)
                           for path in (record, wire))
            self.assertEqual(kept, whole[:len(kept)])
            self.assertGreater(len(FrameDecoder().feed(kept)), 15)

        played = PlayedRobot(entries[wire])
        poses = self.namespace + "/again/pose"
        again = Witness({poses: Odometry})
        other = self.ending.enter_context(Server(played, tcp=0))
        self.driver(other.url, self.namespace + "/again")
        self.until("the record is over", lambda: played.over)
        then = [place_of(message) for _, message, _ in rosbag.Bag(bag).read_messages(topics[1:])]
        # the recorder stopped in between
        again.wait("nearly all of it", lambda: then[-5] in map(place_of, again.seen[poses]))
        now = [place_of(message) for message in again.seen[poses]]
        moves = next(place for place in then if place[0] > 0.0)
        then, now = then[then.index(moves):], now[now.index(moves):]
        self.assertEqual(then[:len(now)], now[:len(then)])
        self.assertGreater(min(len(then), len(now)), 5)


def place_of(message):
    """Return x, y and heading of an Odometry."""
    pose = message.pose.pose
    return pose.position.x, pose.position.y, heading_of(pose)


if __name__ == "__main__":
    rospy.init_node("driver_lines_commander")
    rostest.rosrun("pioneer_control", "driver_lines", DriverLines)

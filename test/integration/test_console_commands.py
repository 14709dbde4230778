"""The console commands of the wheel, installed in an environment of their own, where no ROS can be imported."""

import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys

import pytest

from pioneer_control.bags.writer import BagWriter

from real_time import LIMIT

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = ["p2os-explain", "pioneer-client", "pioneer-report", "pioneer-simulator"]
ROS = ("rospy", "genpy", "roslib", "rospkg", "rosbag", "roslz4", "rosgraph", "std_msgs", "nav_msgs", "geometry_msgs")
ODOMETRY = """Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
=====
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
=====
MSG: geometry_msgs/PoseWithCovariance
Pose pose
float64[36] covariance
=====
MSG: geometry_msgs/Pose
Point position
Quaternion orientation
=====
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
=====
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
=====
MSG: geometry_msgs/TwistWithCovariance
Twist twist
float64[36] covariance
=====
MSG: geometry_msgs/Twist
Vector3 linear
Vector3 angular
=====
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


class Installed:
    """The environment into which the package is installed."""

    def __init__(self, folder):
        source, hidden = folder / "source", folder / "hidden"
        source.mkdir()
        for name in ("setup.py", "setup.cfg", "README.md", "LICENSE", "MANIFEST.in"):
            shutil.copy(str(ROOT / name), str(source / name))
        shutil.copytree(str(ROOT / "src"), str(source / "src"), ignore=shutil.ignore_patterns("__pycache__", "*.egg-*"))
        # With Debian's libraries, for that needs no network; but not with its ROS.
        hidden.mkdir()
        for name in ROS:
            (hidden / (name + ".py")).write_text("raise ImportError('no ROS here', name=__name__)\n")
        self.environment = {name: value for name, value in os.environ.items() if name != "PIP_INDEX_URL"}
        self.environment["PYTHONPATH"] = str(hidden)
        self.bin = folder / "venv" / "bin"
        self.run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", str(self.bin.parent))
        # What pip does with a package that has a setup.py, without the seconds that pip needs for itself.
        done = self.run(str(self.bin / "python"), "setup.py", "-q", "install", "--single-version-externally-managed",
                        "--record", str(folder / "record"), cwd=str(source))
        assert done.returncode == 0, done.stdout

    def run(self, *words, cwd=None):
        """Run a program to its end, with both streams in ``stdout``."""
        return subprocess.run(words, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=2 * LIMIT, cwd=cwd)

    def command(self, name, *arguments, cwd=None):
        """Run a console command to its end."""
        return self.run(str(self.bin / name), *arguments, cwd=cwd)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    return Installed(tmp_path_factory.mktemp("wheel"))


def python(installed, module, *arguments):
    return installed.run(str(installed.bin / "python"), "-m", "pioneer_control." + module, *arguments)


def test_these_commands_are_there_and_no_ros(installed):
    assert sorted(path.name for path in installed.bin.iterdir() if "pioneer" in path.name or "p2os" in path.name) == \
        COMMANDS
    done = installed.run(str(installed.bin / "python"), "-c",
                         "import pioneer_control as p; print(p.__file__); import rospy")
    assert str(installed.bin.parent) in done.stdout and "no ROS here" in done.stdout


@pytest.mark.parametrize("command, module", [("p2os-explain", "p2os"), ("pioneer-client", "client"),
                                             ("pioneer-simulator", "simulator")])
@pytest.mark.parametrize("arguments", [["--help"], ["--no-such-option"], ["--model", "no-such-model", "socket://x:1"]])
def test_they_say_and_return_what_python_m_does(installed, command, module, arguments):
    done, other = installed.command(command, *arguments), python(installed, module, *arguments)
    assert (done.stdout, done.returncode) == (other.stdout, other.returncode)
    assert done.returncode == (0 if arguments == ["--help"] else 2)


def test_golden_bytes_are_explained(installed):
    done = installed.command("p2os-explain", "FA FB 06 0B 1B C8 00 D3 1B")
    assert done.returncode == 0 and "VEL -200" in done.stdout
    assert installed.command("p2os-explain", "FA FB 06 0B 1B C8 00 D3 1C").returncode == 1


def test_a_reader_may_close_its_end(installed):
    with subprocess.Popen([str(installed.bin / "p2os-explain"), "--from-robot", *["FA FB 06 0B 1B C8 00 D3 1B"] * 5000],
                          env=installed.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as explaining:
        explaining.stdout.readline()
        explaining.stdout.close()
        assert explaining.stderr.read() == b"" and explaining.wait(LIMIT) == 0


def test_the_client_finds_the_simulated_robot(installed):
    with subprocess.Popen([str(installed.bin / "pioneer-simulator"), "--tcp", "0"], env=installed.environment,
                          stdout=subprocess.PIPE, universal_newlines=True) as simulator:
        try:
            url = next(filter(None, (re.search(r"socket://\S+", line) for line in simulator.stdout))).group()
            done = installed.command("pioneer-client", url)
            assert done.returncode == 0 and re.search(r"^model +p3dx-sh", done.stdout, re.MULTILINE), done.stdout
        finally:
            simulator.send_signal(signal.SIGINT)
        assert simulator.wait(LIMIT) == 0


def bag(path):
    """Write a bag of a robot that drives straight on."""
    writer = BagWriter(str(path), "bz2")
    pose = writer.connect("/pioneer/pose", {"type": "nav_msgs/Odometry", "md5sum": "cd5e73d190d741a2f92e81eda573aca7",
                                            "message_definition": ODOMETRY, "topic": "/pioneer/pose"})
    for number in range(50):
        text = b"".join(struct.pack("<I", len(word)) + word for word in (b"odom", b"base"))
        data = struct.pack("<III", number, number // 10, 0) + text + struct.pack(
            "<7d36d6d36d", 0.02 * number, 0, 0, 0, 0, 0, 1, *[0] * 36, 0.2, 0, 0, 0, 0, 0, *[0] * 36)
        writer.write(pose, data, 10 ** 9 + number * 10 ** 8)
    writer.close()


def test_a_bag_becomes_a_report(installed, tmp_path):
    bag(tmp_path / "run.bag")
    done = installed.command("pioneer-report", "run.bag", cwd=str(tmp_path))
    assert done.returncode == 0 and (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG"), done.stdout
    done = installed.command("pioneer-report", "--html", "run.bag", cwd=str(tmp_path))
    assert done.returncode == 0 and "recording" in (tmp_path / "run.html").read_text(), done.stdout


def test_what_is_wrong_with_a_report_is_said_under_its_name(installed, tmp_path):
    done = installed.command("pioneer-report", "none.bag", cwd=str(tmp_path))
    assert done.returncode == 2 and done.stdout.startswith("pioneer-report: none.bag")
    assert installed.command("pioneer-report", "--help").stdout.startswith("usage: pioneer-report ")


def test_a_missing_library_is_named_as_pip_knows_it(installed, tmp_path):
    (tmp_path / "numpy.py").write_text("raise ModuleNotFoundError('none', name='numpy')\n")
    environment = dict(installed.environment, PYTHONPATH="%s:%s" % (tmp_path, installed.environment["PYTHONPATH"]))
    done = subprocess.run([str(installed.bin / "pioneer-simulator"), "--help"], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT)
    assert (done.returncode, done.stdout) == (1, "the library numpy is missing: pip install numpy\n")

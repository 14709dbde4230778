"""The house stands as designed: who may import whom, what an import drags in, the oldest Python, names that agree."""

import ast
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from typing import Iterator, List, NamedTuple, Set

import pytest

import pioneer_control

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "pioneer_control"

# Which rooms a room may import from; every room may use errors and itself. Note the two that never meet: simulator and client.
ROOMS = {
    "errors": set(),
    "interrupt": set(),
    "message_values": set(),
    "standard_messages": {"message_values", "robots", "msg"},
    "parameters": set(),
    "ros_node": set(),
    "pictures": set(),
    "p2os": set(),
    "robots": {"p2os"},
    "client": {"p2os", "robots"},
    "driver": {"message_values", "standard_messages", "parameters", "ros_node", "p2os", "robots", "client", "msg"},
    "simulator": {"message_values", "parameters", "ros_node", "pictures", "p2os", "robots"},
    "tutorial": {"message_values", "msg"},
    "bags": {"message_values", "parameters", "ros_node", "standard_messages", "pictures", "p2os", "robots", "msg"},      # robots: where the sonar of an old bag looks
}
# Files that may use ROS, by the start of their path in the package.
ROS_PLACES = ("ros_node.py", "standard_messages.py", "driver/", "tutorial/", "bags/", "simulator/node.py")
ROS_MODULES = {"rospy", "tf", "tf2_ros", "dynamic_reconfigure", "genpy", "rosbag", "rosgraph", "roslaunch", "roslib", "rospkg", "rostest", "rostopic",
               "nav_msgs", "geometry_msgs", "sensor_msgs", "std_msgs", "std_srvs", "tf2_msgs", "rosgraph_msgs", "diagnostic_msgs",
               "diagnostic_updater", "visualization_msgs"}
# Heavy or special libraries, and the only places that may use them.
LIBRARY_PLACES = {"serial": ("client/transport",), "matplotlib": ("bags/", "simulator/picture"), "PIL": ("simulator/world/ros_map",), "tqdm": ("bags/",)}

# Modules that come with packages that package.xml names: genpy with message_runtime, rosgraph and rospkg with rospy.
PART_OF_ANOTHER = {"genpy", "rosgraph", "rospkg"}


class Import(NamedTuple):
    """One imported module, dotted, and the line of the import."""

    module: str
    line: int


def imports(text: str, package: str) -> Iterator[Import]:
    """Every module a source text of ``package`` (dotted) imports, wherever in the text; relative ones made absolute."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(alias.name, node.lineno)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")
                base = ".".join(parents[:len(parents) - node.level + 1] + ([node.module] if node.module else []))
            for alias in node.names:
                yield Import("%s.%s" % (base, alias.name), node.lineno)


def trespasses(path: str, text: str) -> List[str]:
    """What a file (path in the package, with /) imports although its place in the house forbids it."""
    package = ".".join(["pioneer_control"] + path.split("/")[:-1])
    room = path.split("/")[0].replace(".py", "")
    allowed = ROOMS[room] | {room, "errors"}
    if path == "simulator/node.py":
        allowed |= {"msg", "srv"}
    found = []
    for module, line in imports(text, package):
        top, _, rest = module.partition(".")
        # "from pioneer_control import __version__" and the like touch no room
        if top == "pioneer_control" and rest.split(".")[0] in set(ROOMS) | {"msg", "srv"}:
            wrong = rest.split(".")[0] not in allowed
        elif top in ROS_MODULES:
            wrong = not path.startswith(ROS_PLACES)
        else:
            wrong = top in LIBRARY_PLACES and not path.startswith(LIBRARY_PLACES[top])
        if wrong:
            found.append("%s:%d imports %s" % (path, line, module))
    return found


def package_files() -> List[pathlib.Path]:
    return sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def all_python_files() -> List[pathlib.Path]:
    """Every Python file of the repository, programs without an ending included."""
    files = [path for folder in ("src", "test", "bench") for path in (ROOT / folder).rglob("*.py")]
    return sorted(files + [path for path in (ROOT / "nodes").glob("*") if path.is_file()]) + [ROOT / "setup.py"]


def text_files() -> List[pathlib.Path]:
    """What the repository holds, as far as it is text."""
    names = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], stdout=subprocess.PIPE).stdout.decode().split("\0")
    made = {".git", "build", "runs", "__pycache__", ".hypothesis"}     # where there is no git to ask, in a tarball
    files = [ROOT / name for name in names if name] or [path for path in ROOT.rglob("*") if not made & set(path.relative_to(ROOT).parts)]
    binary = {".png", ".jpg", ".gif", ".pdf", ".bag", ".bin"}
    return [path for path in files if path.is_file() and path.suffix not in binary]


def test_every_room_is_in_the_table():
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert rooms | {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"} <= set(ROOMS)


def test_imports_point_one_way():
    found = []
    for path in package_files():
        found += trespasses(path.relative_to(PACKAGE).as_posix(), path.read_text(encoding="utf-8"))
    assert found == []


@pytest.mark.parametrize("path, text", [
    ("simulator/world/world.py", "from pioneer_control.client import Robot"),
    ("simulator/world/world.py", "from ...client import Robot"),
    ("simulator/world/world.py", "from ... import client"),
    ("client/robot.py", "import pioneer_control.simulator.firmware"),
    ("client/robot.py", "def late():\n    from ..simulator import Firmware"),
    ("p2os/sip.py", "from ..robots import RobotModel"),
    ("p2os/sip.py", "import rospy"),
    ("client/robot.py", "import nav_msgs.msg"),
    ("client/session.py", "import serial"),
    ("simulator/line/server.py", "import rospy"),
    ("tutorial/pioneer.py", "from ..driver import node"),
    ("errors.py", "from .p2os import Frame"),
])
def test_a_trespass_is_seen(path, text):
    assert len(trespasses(path, text)) == 1


@pytest.mark.parametrize("path, text", [
    ("simulator/node.py", "import rospy\nfrom pioneer_control.robots import find_model"),
    ("client/transport.py", "import serial.tools.list_ports\nfrom ..errors import PortError"),
    ("driver/node.py", "from ..client import Robot\nfrom ..msg import SonarArray\nimport tf2_ros"),
    ("p2os/sip.py", "from .framing import Frame\nfrom .. import __version__"),
])
def test_what_is_allowed_is_no_trespass(path, text):
    assert trespasses(path, text) == []


def loaded_by(module: str) -> Set[str]:
    """The top-level modules in memory after importing one, in a Python of its own."""
    code = "import sys, %s; print(*{name.split('.')[0] for name in sys.modules})" % module
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    return set(done.stdout.decode().split())


def test_importing_the_package_loads_nearly_nothing():
    loaded = loaded_by("pioneer_control")
    assert "pioneer_control" in loaded
    assert not loaded & {"rospy", "serial", "numpy", "yaml", "matplotlib"}


@pytest.mark.parametrize("room", ["p2os", "robots", "client", "simulator"])
def test_rooms_without_ros_load_none(room):
    assert not loaded_by("pioneer_control." + room) & ROS_MODULES


def test_what_loads_is_seen():
    assert "serial" in loaded_by("serial")


@pytest.mark.parametrize("path", all_python_files(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_parses_as_python_3_8(path):
    ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 8))


def test_later_syntax_is_seen():
    with pytest.raises(SyntaxError):
        ast.parse("match x:\n    case 1: pass", feature_version=(3, 8))


@pytest.mark.parametrize("path", sorted((ROOT / "nodes").glob("*")), ids=lambda path: path.name)
def test_nodes_are_thin(path):
    """A node imports and calls; what it does lives in the package. The tutorial's two are the lesson itself, to be read in a minute."""
    if path.is_file():
        assert len(path.read_text().splitlines()) <= (80 if path.name.startswith("rosPioneer") else 20)


def test_versions_agree():
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    assert manifest.findtext("version") == pioneer_control.__version__
    released = re.findall(r"^(\d+\.\d+\.\d+) \(", (ROOT / "CHANGELOG.rst").read_text(), re.MULTILINE)
    assert not released or released[0] == pioneer_control.__version__


def test_package_xml_names_what_the_code_imports():
    """Whatever ROS package or library the sources import, package.xml says so; and it names no messages that nobody imports."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    named = {element.text for element in manifest if element.tag.endswith("depend")}
    keys = {"numpy": "python3-numpy", "serial": "python3-serial", "yaml": "python3-yaml", "matplotlib": "python3-matplotlib", "PIL": "python3-pil", "tqdm": "python3-tqdm"}
    keys.update({module: module for module in ROS_MODULES})
    used = {module.partition(".")[0] for path in package_files()
            for module, _ in imports(path.read_text(encoding="utf-8"), "pioneer_control.x")}
    assert {keys[module] for module in used if module in keys} - named - PART_OF_ANOTHER == set()
    assert {name for name in named & ROS_MODULES if name.endswith(("_msgs", "_srvs"))} <= used


def test_no_paths_of_somebodys_machine():
    """The repository reads the same wherever it lies."""
    machine = re.compile(r"/(?:home|work|Users)/[a-z]+/|/roo[t]/|/tmp/(?!pioneer)[a-z-]+/")
    assert machine.search("/home/" + "somebody/catkin_ws")
    found = ["%s: %s" % (path.relative_to(ROOT), machine.search(path.read_text(encoding="utf-8")).group())
             for path in text_files() if machine.search(path.read_text(encoding="utf-8"))]
    assert found == []

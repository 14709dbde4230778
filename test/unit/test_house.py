"""The rules of the package: which file may import which, what an import loads, the oldest Python, and names that agree.
"""

import ast
import collections
import fnmatch
import functools
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, NamedTuple, Optional, Set, Tuple

import pytest

import pioneer_control

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "pioneer_control"

# Which rooms a room may import from; every room may use errors and itself. Two never meet: simulator and client.
ROOMS = {
    "errors": set(),
    "floor_poses": set(),
    "interrupt": set(),
    "message_values": set(),
    "standard_messages": {"message_values", "robots", "msg"},
    "parameters": set(),
    "ros_node": {"interrupt"},
    "diagnostics_thread": set(),
    "prompt_connection": set(),
    "whole_file": set(),
    "pictures": {"whole_file"},
    "port_url": set(),
    "wire_fields": set(),
    "wire_words": {"wire_fields"},
    "p2os": {"wire_fields", "wire_words"},
    "lms2xx": {"wire_fields", "wire_words"},
    # robots: where the laser of a model sits; client: its ports
    "laser": {"lms2xx", "parameters", "ros_node", "diagnostics_thread", "prompt_connection", "robots",
              "client"},
    "vcc4": {"wire_fields"},
    # client: the line of the robot, and ports
    "ptz": {"p2os", "vcc4", "client"},
    # client: the levels of diagnostics
    "arm": {"p2os", "client"},
    "robots": {"p2os", "parameters"},
    "description": {"parameters", "pictures", "ros_node", "robots", "msg"},
    "client": {"port_url", "wire_fields", "p2os", "robots"},
    "maps": {"floor_poses", "parameters", "whole_file"},
    "navigation": {"floor_poses", "maps", "message_values", "parameters", "robots"},
    "driver": {"message_values", "standard_messages", "parameters", "port_url", "ros_node", "diagnostics_thread",
               "prompt_connection", "p2os", "robots", "client", "vcc4", "ptz", "arm", "msg", "srv"},
    "simulator": {"message_values", "parameters", "ros_node", "pictures", "maps", "wire_fields", "p2os", "lms2xx",
                  "vcc4", "robots"},
    # robots: the outline, where a driver does not tell it
    "tutorial": {"floor_poses", "message_values", "ros_node", "robots", "msg", "srv"},
    "teleop": {"message_values", "ros_node", "msg"},
    "service": {"interrupt", "whole_file"},
    # the commands of the wheel: each starts one of these
    "console": {"interrupt", "simulator", "client", "p2os", "web"},
    # robots: where the sonar of an old bag looks; vcc4: what a camera sees
    "bags": {"message_values", "parameters", "port_url", "ros_node", "standard_messages", "whole_file", "pictures",
             "p2os", "vcc4", "robots", "msg"},
    # client: the table of the robot's own numbers; tutorial: Pioneer, and what it sees; teleop: the key that is held
    "calibration": {"floor_poses", "message_values", "parameters", "ros_node", "whole_file", "robots", "client",
                    "tutorial", "teleop", "bags", "msg"},
    # no simulator: the page shows it as it shows any robot, and starts it as a program
    "web": {"interrupt", "message_values", "parameters", "port_url", "ros_node", "whole_file", "p2os", "robots",
            "client", "bags", "msg"},
}
# Files that may use ROS, by the start of their path in the package.
ROS_PLACES = ("ros_node.py", "diagnostics_thread.py", "prompt_connection.py", "standard_messages.py",
              "description/node.py", "driver/",
              "tutorial/", "bags/", "teleop/node.py", "laser/node.py", "calibration/node.py", "navigation/node/",
              "web/graph.py", "web/graph_navigation.py", "web/node.py", "simulator/node.py", "service/launched.py",
              "service/command_line.py")
ROS_MODULES = {"rospy", "tf", "tf2_ros", "dynamic_reconfigure", "genpy", "rosbag", "rosgraph", "roslaunch", "roslib",
               "rospkg", "rostest", "rostopic", "nav_msgs", "geometry_msgs", "sensor_msgs", "std_msgs", "std_srvs",
               "tf2_msgs", "actionlib", "actionlib_msgs", "move_base_msgs", "rosgraph_msgs", "diagnostic_msgs",
               "diagnostic_updater", "visualization_msgs", "trajectory_msgs"}
# Heavy or special libraries, and the only places that may use them.
LIBRARY_PLACES = {"serial": ("client/serial_port",), "websocket": ("client/web_socket",),
                  "matplotlib": ("bags/", "simulator/picture", "description/picture"),
                  "PIL": ("maps/ros_map",), "tqdm": ("bags/",), "evdev": ("teleop/gamepad",),
                  "scipy": ("navigation/",), "tornado": ("web/server.py",),
                  "qrcode": ("web/qr.py",), "lz4": ("bags/records",)}

# Modules that come with packages that package.xml names: genpy with message_runtime, rosgraph and rospkg with rospy.
PART_OF_ANOTHER = {"genpy", "rosgraph", "rospkg"}


class Import(NamedTuple):
    """One imported module, dotted, and the line of the import."""

    module: str
    line: int


@functools.lru_cache(maxsize=None)
def parsed(text: str) -> ast.Module:
    """Return the tree of a source text. Many rules look at it, and none changes it: it is made once."""
    return ast.parse(text)


def imports(text: str, package: str) -> Iterator[Import]:
    """Return every module that a source text of ``package`` (dotted) imports, anywhere in the text. Relative names
    become absolute.
    """
    for node in ast.walk(parsed(text)):
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
    """Return what a file (path in the package, with /) imports although the rules forbid it."""
    package = ".".join(["pioneer_control"] + path.split("/")[:-1])
    room = path.split("/")[0].replace(".py", "")
    allowed = ROOMS[room] | {room, "errors"}
    if path in ("simulator/node.py", "web/graph_navigation.py"):
        allowed |= {"msg", "srv"}
    if path == "navigation/node/map_files.py":       # one reader of maps and worlds for both
        allowed |= {"simulator"}
    if path.startswith("navigation/node/"):
        allowed |= {"msg", "srv", "ros_node"}
    if path in ("navigation/node/locate_bag.py", "navigation/node/bag_laser.py"):
        allowed |= {"bags", "standard_messages", "whole_file"}
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
    """Return every Python file of the repository, also programs without an ending."""
    files = [path for folder in ("src", "test", "bench", "docs") for path in (ROOT / folder).rglob("*.py")]
    return sorted(files + [path for path in (ROOT / "nodes").glob("*") if path.is_file()]) + [ROOT / "setup.py"]


def text_files() -> List[pathlib.Path]:
    """Return the text files of the repository."""
    listing = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], stdout=subprocess.PIPE).stdout.decode()
    files = [ROOT / name for name in listing.split("\0") if name]
    if not files:       # there is no git to ask: a tarball
        made = {".git", "build", "runs", "__pycache__", ".hypothesis"}
        files = [path for path in ROOT.rglob("*") if not made & set(path.relative_to(ROOT).parts)]
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
    ("client/tcp.py", "def late():\n    import serial"),
    ("client/ports.py", "import websocket"),
    ("simulator/line/server.py", "import rospy"),
    ("tutorial/pioneer.py", "from ..driver import node"),
    ("errors.py", "from .p2os import Frame"),
    ("web/owner.py", "from ..simulator import simulate"),
    ("web/fleet.py", "import tornado.web"),
])
def test_a_trespass_is_seen(path, text):
    assert len(trespasses(path, text)) == 1


@pytest.mark.parametrize("path, text", [
    ("simulator/node.py", "import rospy\nfrom pioneer_control.robots import find_model"),
    ("client/serial_port.py", "import serial.tools.list_ports\nfrom ..errors import PortError"),
    ("driver/node.py", "from ..client import Robot\nfrom ..msg import SonarArray\nimport tf2_ros"),
    ("p2os/sip.py", "from .framing import Frame\nfrom .. import __version__"),
])
def test_what_is_allowed_is_no_trespass(path, text):
    assert trespasses(path, text) == []


# --- Files ---

MOST_ATTRIBUTES, MOST_METHODS = 20, 30
"""Of one class, with those that it inherits from classes of this package."""

Texts = Dict[str, str]
"""Texts of files by their dotted names; the front of a folder (``__init__``) has the folder's."""


def package_texts() -> Texts:
    """Return the text of every file of the package."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text(encoding="utf-8")
    return found


def imported_files(texts: Texts) -> Dict[str, Set[str]]:
    """Return the files that each file imports, anywhere in it, also for types only. A file does not import its own
    folder.
    """
    found = {}
    for name, text in texts.items():
        is_folder = any(other.startswith(name + ".") for other in texts)
        named = [module for module, _ in imports(text, name if is_folder else name.rpartition(".")[0])]
        # "from .a import b": the file b of folder a, or something in a.
        targets = {module if module in texts else module.rpartition(".")[0] for module in named}
        found[name] = targets & set(texts) - {name}
    return found


def circle(graph: Dict[str, Set[str]]) -> List[str]:
    """Return files that import each other in a circle, in their order. Empty when there is no circle."""
    done: Set[str] = set()

    def walk(path: List[str]) -> List[str]:
        for following in sorted(graph[path[-1]]):
            if following in path:
                return path[path.index(following):] + [following]
            found = [] if following in done else walk(path + [following])
            if found:
                return found
        done.add(path[-1])
        return []

    for start in sorted(graph):
        found = [] if start in done else walk([start])
        if found:
            return found
    return []


def classes(texts: Texts) -> List[Tuple[str, ast.ClassDef]]:
    """Return every class with its file."""
    return [(name, node) for name, text in texts.items() for node in ast.walk(parsed(text))
            if isinstance(node, ast.ClassDef)]


def repeated_classes(texts: Texts) -> List[str]:
    """Return the names that more than one class has, and their files."""
    places: Dict[str, List[str]] = {}
    for file, node in classes(texts):
        places.setdefault(node.name, []).append(file)
    return ["%s in %s" % (name, ", ".join(files)) for name, files in sorted(places.items()) if len(files) > 1]


def last_name(node: ast.expr) -> str:
    """Return the last word of ``a.b.Word``, ``Word[...]`` or ``Word(...)``."""
    while isinstance(node, (ast.Call, ast.Subscript)):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def is_record(node: ast.ClassDef) -> bool:
    """Return whether a class only has values: a NamedTuple, an enumeration, a frozen dataclass."""
    frozen = any(isinstance(each, ast.Call) and last_name(each) == "dataclass" and
                 any(word.arg == "frozen" and getattr(word.value, "value", None) is True for word in each.keywords)
                 for each in node.decorator_list)
    bases = {last_name(base) for base in node.bases}
    return frozen or bool(bases & {"NamedTuple", "Enum", "IntEnum", "Flag", "IntFlag"})


def attributes_of(node: ast.ClassDef) -> Set[str]:
    """Return the names that are assigned in the body of a class, or to ``self`` in one of its methods."""
    def names(target: ast.expr) -> Iterator[str]:
        if isinstance(target, (ast.Tuple, ast.List, ast.Starred)):
            for each in getattr(target, "elts", None) or [target.value]:
                yield from names(each)
        elif isinstance(target, ast.Attribute) and getattr(target.value, "id", "") == "self":
            yield target.attr
        elif isinstance(target, ast.Name) and target in body_targets:
            yield target.id

    def targets(statement: ast.AST) -> List[ast.expr]:
        if isinstance(statement, ast.Assign):
            return statement.targets
        return [statement.target] if isinstance(statement, (ast.AnnAssign, ast.AugAssign, ast.For)) else []

    body_targets = [each for statement in node.body for target in targets(statement) for each in ast.walk(target)]
    found = {name for statement in ast.walk(node) for target in targets(statement) for name in names(target)}
    return found - {"__slots__"}


def methods_of(node: ast.ClassDef) -> Set[str]:
    """Return the names of its methods and properties."""
    return {each.name for each in node.body if isinstance(each, (ast.FunctionDef, ast.AsyncFunctionDef))}


def large_classes(texts: Texts) -> List[str]:
    """Return the classes that have too many attributes or methods, and the numbers.

    Inherited ones count, if the base class is in this package.
    """
    known = {node.name: node for _, node in classes(texts)}

    def with_bases(node: ast.ClassDef) -> List[ast.ClassDef]:
        bases = {last_name(base) for base in node.bases} & set(known) - {node.name}
        return [node] + [each for base in bases for each in with_bases(known[base])]

    found = []
    for file, node in classes(texts):
        family = with_bases(node)
        attributes = len(set().union(*map(attributes_of, family)))
        methods = len(set().union(*map(methods_of, family)))
        if not any(map(is_record, family)) and (attributes > MOST_ATTRIBUTES or methods > MOST_METHODS):
            found.append("%s.%s: %d attributes, %d methods" % (file, node.name, attributes, methods))
    return found


def undocumented(texts: Texts) -> List[str]:
    """Return what is public and has no docstring: files, classes, functions, methods. A method may have the docstring
    of a base class.
    """
    known = {node.name: node for _, node in classes(texts)}

    def told_by_a_base(owner: ast.AST, name: str) -> bool:
        bases = [known[last_name(base)] for base in getattr(owner, "bases", ()) if last_name(base) in known]
        return any(told_by_a_base(base, name) or
                   any(getattr(each, "name", "") == name and ast.get_docstring(each) for each in base.body)
                   for base in bases if base is not owner)

    def visit(node: ast.AST, name: str, owner: Optional[ast.AST] = None) -> Iterator[str]:
        if ast.get_docstring(node) is None and not told_by_a_base(owner, getattr(node, "name", "")):
            yield name
        for child in node.body if isinstance(node, (ast.Module, ast.ClassDef)) else ():
            if isinstance(child, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and child.name[0] != "_":
                # The setter of a property is told by the property; an overload by what it overloads.
                if not {"setter", "overload"} & {last_name(each) for each in child.decorator_list}:
                    yield from visit(child, "%s.%s" % (name, child.name), node)

    return [name for module, text in texts.items() for name in visit(parsed(text), module)]


def untrue_fronts(texts: Texts) -> List[str]:
    """Return the files and folders that the docstring of their folder does not name, and names in it that do not exist.
    """
    found = []
    for folder, text in texts.items():
        present = {name[len(folder) + 1:] for name in texts if name.startswith(folder + ".")}
        present = {name for name in present if "." not in name and name != "__main__"}
        if present:
            front = ast.get_docstring(parsed(text)) or ""
            named = re.findall(r"`{1,2}([a-z_0-9*]+)(?:\.py|/)?`{1,2}", front)
            found += ["%s does not name %s" % (folder, name) for name in sorted(present)
                      if not any(fnmatch.fnmatchcase(name, pattern) for pattern in named)]
            listed = re.findall(r"^``([a-z_0-9*]+)(?:\.py|/)?``", front, re.MULTILINE)
            found += ["%s lists %s, which is not there" % (folder, pattern) for pattern in listed
                      if not fnmatch.filter(present | {"__main__"}, pattern)]
    return found


FILES = package_texts()


def test_no_files_import_each_other_in_a_circle():
    assert circle(imported_files(FILES)) == []


@pytest.mark.parametrize("there, back", [
    ("from .b import f", "from .a import g"),
    ("from . import b", "import p.a"),
    ("import p.b", "def late():\n    from p import a"),
    ("from .b import f", "if TYPE_CHECKING:\n    from .a import A"),
    ("from . import c", "from .a import g"),        # c is of the front, which imports b
])
def test_a_circle_of_files_is_seen(there, back):
    texts = {"p": "from .b import c", "p.a": there, "p.b": back}
    found = circle(imported_files(texts))
    assert found[0] == found[-1] and {"p.a", "p.b"} <= set(found)


def test_files_that_import_one_way_are_no_circle():
    texts = {"p": "from .a import A\nfrom .b import B", "p.a": "from .b import B\nimport os",
             "p.b": "from p.c import d",
             "p.c": ""}
    assert circle(imported_files(texts)) == []


def test_no_class_name_is_used_twice():
    assert repeated_classes(FILES) == []


def test_a_class_name_used_twice_is_seen():
    texts = {"p.a": "class A: pass", "p.b": "def f():\n    class A: pass", "p.c": "class B: pass"}
    assert repeated_classes(texts) == ["A in p.a, p.b"]


def test_no_class_holds_too_much():
    assert large_classes(FILES) == []


def class_text(attributes=0, methods=1, head="class A:"):
    lines = ["    def m%d(self): pass" % number for number in range(methods - 1)] + ["    def __init__(self):"]
    lines += ["        self.a%d = self.b%d, self.c = 1, 2" % (number, number) for number in range(attributes - 1)]
    return "\n".join([head] + lines + ["        pass"])


@pytest.mark.parametrize("text, figures", [
    (class_text(attributes=12), "23 attributes, 1 methods"),
    (class_text(methods=31), "0 attributes, 31 methods"),
    ("class A:\n" + "".join("    a%d: int = 1\n" % number for number in range(21)), "21 attributes, 0 methods"),
    (class_text(methods=16, head="class B:") + "\n" + class_text(methods=30, head="class A(B):").replace("m", "n"),
     "0 attributes, 45 methods"),
])
def test_a_class_that_holds_too_much_is_seen(text, figures):
    assert large_classes({"p.a": text}) == ["p.a.A: " + figures]


@pytest.mark.parametrize("head", ["class A(NamedTuple):", "@dataclass(frozen=True)\nclass A:", "class A(enum.Enum):"])
def test_a_record_may_hold_much(head):
    text = head + "\n" + "".join("    a%d: int = 1\n" % number for number in range(30))
    assert large_classes({"p.a": text}) == []
    for record, other in (("True", "False"), ("NamedTuple", "Thing"), ("Enum", "Thing")):
        text = text.replace(record, other)
    assert large_classes({"p.a": text}) != []


def test_all_that_is_public_has_a_docstring():
    assert undocumented(FILES) == []


def test_what_is_public_without_a_docstring_is_seen():
    text = """
class A:
    def f(self): pass
    def _g(self): pass
    @f.setter
    def f(self, value): pass
class _B: pass
def h():
    def i(): pass
"""
    assert undocumented({"p.a": text}) == ["p.a", "p.a.A", "p.a.A.f", "p.a.h"]


def test_a_method_may_leave_its_docstring_to_a_base_class_that_has_one():
    base = '"""File."""\nclass Base:\n    """Class."""\n    def f(self):\n        """Method."""\n'
    derived = '"""File."""\nclass A(Base):\n    """Class."""\n    def f(self): pass\n    def g(self): pass\n'
    assert undocumented({"p.a": base, "p.b": derived}) == ["p.b.A.g"]
    assert undocumented({"p.a": base.replace('        """Method."""', "        pass"), "p.b": derived}) == [
        "p.a.Base.f", "p.b.A.f", "p.b.A.g"]


def test_the_front_of_each_room_names_its_files():
    assert untrue_fronts(FILES) == []


def test_a_front_that_is_not_true_is_seen():
    front = '"""A room. Open ``a`` first.\n\n``gone``  what went\n``many_*``  some\n"""'
    texts = {"p": front, "p.a": "", "p.hidden": "", "p.many_b": "", "p.__main__": "", "p.a.deeper": ""}
    assert untrue_fronts(texts) == [
        "p does not name hidden", "p lists gone, which is not there", "p.a does not name deeper"]


# --- What else holds ---

def loaded_by(module: str) -> Set[str]:
    """Return the top-level modules in memory after importing one module in a new Python process."""
    code = "import sys, %s; print(*{name.split('.')[0] for name in sys.modules})" % module
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    return set(done.stdout.decode().split())


def test_importing_the_package_loads_nearly_nothing():
    loaded = loaded_by("pioneer_control")
    assert "pioneer_control" in loaded
    assert not loaded & {"rospy", "serial", "numpy", "yaml", "matplotlib"}


@pytest.mark.parametrize("room", ["p2os", "robots", "client", "simulator", "web", "web.owner"])
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


def repeated_names(paths):
    """Return the file names that are in more than one folder. pytest cannot load both in one run."""
    counts = collections.Counter(path.name for path in paths)
    return sorted(name for name, count in counts.items() if count > 1)


def test_no_two_files_of_tests_have_one_name():
    assert repeated_names((ROOT / "test").rglob("test_*.py")) == []


def test_two_files_of_one_name_are_seen():
    assert repeated_names([pathlib.Path("a/test_x.py"), pathlib.Path("b/test_x.py"), pathlib.Path("b/test_y.py")]) == [
        "test_x.py"]


@pytest.mark.parametrize("path", sorted((ROOT / "nodes").glob("*")), ids=lambda path: path.name)
def test_nodes_are_thin(path):
    """A node imports and calls, and the package does the work. The two nodes of the tutorial are the lesson itself."""
    if path.is_file():
        assert len(path.read_text().splitlines()) <= (80 if path.name.startswith("rosPioneer") else 20)


def test_versions_agree():
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    assert manifest.findtext("version") == pioneer_control.__version__
    released = re.findall(r"^(\d+\.\d+\.\d+) \(", (ROOT / "CHANGELOG.rst").read_text(), re.MULTILINE)
    assert not released or released[0] == pioneer_control.__version__


def test_package_xml_names_what_the_code_imports():
    """package.xml names every ROS package and library that the sources import, and every message package in it is
    imported.
    """
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    named = {element.text for element in manifest if element.tag.endswith("depend")}
    keys = {"numpy": "python3-numpy", "scipy": "python3-scipy", "serial": "python3-serial",
            "websocket": "python3-websocket",
            "yaml": "python3-yaml", "PIL": "python3-pil", "matplotlib": "python3-matplotlib", "tqdm": "python3-tqdm",
            "evdev": "python3-evdev", "tornado": "python3-tornado", "qrcode": "python3-qrcode"}
    keys.update({module: module for module in ROS_MODULES})
    used = {module.partition(".")[0] for path in package_files()
            for module, _ in imports(path.read_text(encoding="utf-8"), "pioneer_control.x")}
    assert {keys[module] for module in used if module in keys} - named - PART_OF_ANOTHER == set()
    assert {name for name in named & ROS_MODULES if name.endswith(("_msgs", "_srvs"))} <= used


def test_no_paths_of_somebodys_machine():
    """No text file of the repository names a folder of one person's computer."""
    machine = re.compile(r"/(?:home|work|Users)/[a-z]+/|/roo[t]/|/tmp/(?!pioneer)[a-z-]+/")
    assert machine.search("/home/" + "somebody/catkin_ws")
    found = ["%s: %s" % (path.relative_to(ROOT), machine.search(path.read_text(encoding="utf-8")).group())
             for path in text_files() if machine.search(path.read_text(encoding="utf-8"))]
    assert found == []

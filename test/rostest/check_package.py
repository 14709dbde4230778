#!/usr/bin/python3
"""The package as ROS sees it: the messages' md5s, launch files that load, nodes that rosrun finds."""

import pathlib
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import genpy.dynamic
import roslaunch.config
import roslaunch.core
import roslib.packages
import rospkg
import rostest

import pioneer_control.msg

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("pioneer_control"))

# p2os's own: what old bags and old peers ask for.
FROZEN_MD5 = {
    "AIO": "80e4ca5770a3db29064af246946ff4fe",
    "BatteryState": "b72130f0e7ffec93b2b5f573eb2542cb",
    "DIO": "d375575ab5b2233ab16927780da5f856",
    "GripState": "370eb3507be0ed1043be50a3da3a07c6",
    "GripperState": "300b38b2a4173deb725df02fa70fc70b",
    "LiftState": "4dcc2e41838611193ef6b9f90c9be41f",
    "MotorState": "7a2f37ef2ba405f0c7a15cc72663d6f0",
    "PTZState": "1f71ce2a42b32376ea869eb051358045",
    "SonarArray": "2984921c09aef26ad253c7629937a5bb",
}
# What p2os has no message for.
NEW_MESSAGES = {"RobotInfo", "WheelVelocities", "Bumpers", "Stall", "IO", "Wire", "Decision", "Helm", "Accelerations",
                "Navigation", "Places", "Calibration", "Encoders", "Sounds", "Arm"}
# Noetic's own navigation, which Debian does not have: amcl_move_base.launch alone is for whoever has it.
NOETIC_ONLY = {"amcl_move_base.launch": {"amcl", "map_server", "move_base"}}
# Arguments whose values roslaunch looks at: names of computers.
LOOKED_AT = {"robots": "localhost"}


class MessageCheck(unittest.TestCase):
    """The frozen messages connect with p2os's, because their md5s are the same."""

    def test_frozen_messages_keep_their_md5(self):
        md5s = {name: getattr(pioneer_control.msg, name)._md5sum for name in FROZEN_MD5}
        self.assertEqual(md5s, FROZEN_MD5)

    def test_every_message_is_frozen_or_known_to_be_new(self):
        self.assertEqual({path.stem for path in (PACKAGE / "msg").glob("*.msg")}, set(FROZEN_MD5) | NEW_MESSAGES)

    def test_a_constant_would_change_the_md5(self):
        """Adding a constant changes the md5, and the check above notices it. That is why names of numbers are in Python
        files.
        """
        text = (PACKAGE / "msg" / "MotorState.msg").read_text()
        same = genpy.dynamic.generate_dynamic("pioneer_control/MotorState", text)["pioneer_control/MotorState"]
        others = genpy.dynamic.generate_dynamic("pioneer_control/MotorState", "int32 ON=1\n" + text)
        other = others["pioneer_control/MotorState"]
        self.assertEqual(same._md5sum, FROZEN_MD5["MotorState"])
        self.assertNotEqual(other._md5sum, FROZEN_MD5["MotorState"])


def complaints(path):
    """Return the errors of a launch file: it does not load, a node is missing, or package.xml does not name the package
    of a node.
    """
    required = [arg.get("name") for arg in ElementTree.parse(path).iter("arg")
                if not {"default", "value"} & set(arg.keys())]
    try:
        given = ["%s:=%s" % (name, LOOKED_AT.get(name, "/given")) for name in required]
        config = roslaunch.config.load_config_default([(str(path), given)], None, verbose=False)
    except roslaunch.core.RLException as error:
        return [str(error)]
    manifest = ElementTree.parse(PACKAGE / "package.xml").getroot()
    named = {element.text for element in manifest if element.tag.endswith("depend")} | {"pioneer_control"}
    nodes = [node for node in config.nodes if node.package not in NOETIC_ONLY.get(path.name, ())]
    return config.config_errors + [
        "no %s in %s" % (node.type, node.package) for node in nodes if not is_there(node)] + [
        "package.xml does not name %s" % node.package for node in nodes if node.package not in named]


def is_there(node):
    """Return whether a node's program exists. RViz counts as existing, because it is installed only on request."""
    return node.package == "rviz" or bool(roslib.packages.find_node(node.package, node.type))


class LaunchCheck(unittest.TestCase):
    """Launch files are well-formed, use nodes that exist, and package.xml names what they need."""

    def complaints_about(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "tried.launch"
            path.write_text(text)
            return complaints(path)

    def test_nothing_speaks_against_our_launch_files(self):
        files = sorted((PACKAGE / "launch").glob("*.launch"))
        self.assertTrue(files)
        self.assertEqual({path.name: complaints(path) for path in files}, {path.name: [] for path in files})

    def test_the_launch_file_of_2012_is_not_even_xml(self):
        """The file has a value without quotes, and elements without an end tag."""
        with self.assertRaises(ElementTree.ParseError):
            self.complaints_about(
                '<launch><group ns="pioneer"><param name="pulse" value=1.0><node name="p2os" pkg="p2os_driver" '
                'type="p2os"></group></launch>')

    def test_what_does_not_load_is_seen(self):
        self.assertEqual(len(self.complaints_about('<launch><param name="pulse" value="$(arg nobody)"/></launch>')), 1)

    def test_a_node_that_does_not_exist_is_seen(self):
        found = self.complaints_about('<launch><node name="p2os" pkg="pioneer_control" type="p2os"/></launch>')
        self.assertEqual(found, ["no p2os in pioneer_control"])

    def test_a_package_that_nobody_named_is_seen(self):
        found = self.complaints_about('<launch><node name="log" pkg="rosout" type="rosout"/></launch>')
        self.assertEqual(found, ["package.xml does not name rosout"])


class NodeCheck(unittest.TestCase):
    """rosrun can start every node."""

    def test_nodes_are_executable_and_use_the_system_python(self):
        nodes = [path for path in (PACKAGE / "nodes").iterdir() if path.is_file()]
        self.assertTrue(nodes)
        self.assertEqual([path.name for path in nodes if not path.stat().st_mode & 0o111], [])
        self.assertEqual([path.name for path in nodes if path.read_text().splitlines()[0] != "#!/usr/bin/python3"], [])


if __name__ == "__main__":
    rostest.rosrun("pioneer_control", "package", "__main__")

"""The description of a recording: a YAML text on the latched topic ``recording`` of each recorded robot.

An example:

::

    recording: {date: 2026-11-21 18:00:00+00:00, robots: [pioneer], file: /data/pioneer_2026-11-21-18-00-00.bag, topics:
        [/pioneer/pose, ...]}
    versions: {pioneer_control: 0.1.0, commit: 8d1c2e4..., rospy: 1.15.15, rosbag: 1.15.15, python: 3.11.2, system:
        Debian GNU/Linux 12 (bookworm)}
    nodes:
      /pioneer/p2os: {serves: [...], publishes: [...], hears: [...]}
    parameters:                     the whole parameter server: {pioneer: {p2os: {port: ...}}}

The attendant publishes a new description when nodes or parameters change, so a bag may have several descriptions.
"""

import os
import platform
import subprocess
import sys
from typing import Any, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

import yaml

from ... import __version__
from ...errors import UsageError
from ...port_url import without_key


class Description(NamedTuple):
    """The description of a recording, read from or to be written to a YAML text."""

    recording: Mapping[str, Any]
    """with the keys date, robots, file and topics"""
    versions: Mapping[str, str]
    nodes: Mapping[str, Mapping[str, Sequence[str]]]
    """by name of a node: its services ("serves"), publications ("publishes") and subscriptions ("hears")"""
    parameters: Mapping[str, Any]
    """the tree of the parameter server"""

    def parameters_of(self, node: str) -> Dict[str, Any]:
        """Return the private parameters of a node as a tree. Empty if the node has none.

        `node` is the full name of the node, such as /pioneer/p2os.
        """
        tree: Any = self.parameters
        for name in node.strip("/").split("/"):
            tree = tree.get(name, {}) if isinstance(tree, Mapping) else {}
        return dict(tree) if isinstance(tree, Mapping) else {}


class _Dumper(yaml.SafeDumper):
    """A YAML dumper for parameters. It writes XML-RPC values, such as dates, as text, and never writes aliases.

    It leaves out the key of a port's URL: whoever gets the bag shall not get the robot.
    """

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_representer(str, lambda dumper, value: dumper.represent_str(without_key(value)))
_Dumper.add_multi_representer(object, lambda dumper, value: dumper.represent_str(str(getattr(value, "data", value))))


class _Loader(yaml.SafeLoader):
    """A YAML loader for texts of `_Dumper`. It refuses aliases, because a few aliases can fill the memory."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):  # type: ignore[no-untyped-call]  # PyYAML's stubs have no types there
            raise yaml.YAMLError("it has an alias")
        return super().compose_node(parent, index)


def text_of(description: Description) -> str:
    """Convert a description to YAML text, which is then published."""
    return yaml.dump(description._asdict(), Dumper=_Dumper, sort_keys=False, allow_unicode=True,
                     default_flow_style=None, width=1000)


def description_of(text: str) -> Description:
    """Read the YAML text of a description.

    Raises:
        UsageError: the text is not the description of a recording.
    """
    try:
        given = yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise UsageError("no description of a recording: %s" % error) from error
    if not isinstance(given, dict) or not {"recording", "parameters"} <= set(given):
        raise UsageError("no description of a recording: %r" % text[:80])
    return Description(*(given.get(field) or {} for field in Description._fields))


def nodes_of(state: Sequence[Sequence[Tuple[str, Sequence[str]]]]) -> Dict[str, Dict[str, list]]:
    """Return the topics that each node publishes and subscribes to ("hears"), and its services, by name of the node.

    `state` is the value that the ROS master's getSystemState() returned.
    """
    nodes: Dict[str, Dict[str, list]] = {}
    for kind, entries in zip(("publishes", "hears", "serves"), state):
        for name, there in entries:
            for node in there:
                nodes.setdefault(node, {}).setdefault(kind, []).append(name)
    return {node: {kind: sorted(names) for kind, names in sorted(does.items(), reverse=True)}
            for node, does in sorted(nodes.items())}


def versions(source: str = __file__) -> Dict[str, str]:
    """Return the versions of this package, ROS, Python and the operating system. Unknown versions are left out.

    `source` is a file of this package. The key "commit" is its git commit.
    """
    known = {
        "pioneer_control": __version__,
        "commit": commit_of(source),
        "rospy": _package_version("rospy"),
        "rosbag": _package_version("rosbag"),
        "python": platform.python_version(),
        "system": _system(),
        "kernel": "%s %s %s" % (platform.system(), platform.release(), platform.machine()),
    }
    return {name: value for name, value in known.items() if value}


def commit_of(path: str) -> Optional[str]:
    """Return the git commit of the repository of a file, with " and changes" if the repository has local changes.

    None if git does not track the file, or is not installed.
    """
    folder = os.path.dirname(os.path.abspath(path))

    def git(*arguments: str) -> str:
        return subprocess.run(["git", "-C", folder, *arguments], check=True, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, timeout=10,
                              universal_newlines=True).stdout.strip()

    try:
        git("ls-files", "--error-unmatch", os.path.abspath(path))
        return git("describe", "--always", "--abbrev=40", "--exclude=*", "--dirty= and changes")
    except (OSError, subprocess.SubprocessError):
        return None


def _package_version(name: str) -> Optional[str]:
    """Return the version of a ROS package. None if the package is not installed."""
    import rospkg

    try:
        return rospkg.RosPack().get_manifest(name).version
    except (rospkg.ResourceNotFound, rospkg.InvalidManifest):
        return None


def _system() -> str:
    """Return the name of the operating system, for example "Debian GNU/Linux 12 (bookworm)"."""
    try:
        with open("/etc/os-release", encoding="utf-8") as file:
            return dict(line.rstrip().split("=", 1) for line in file if "=" in line).get("PRETTY_NAME", "").strip('"')
    except OSError:
        return sys.platform

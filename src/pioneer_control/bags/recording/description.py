"""What a recording says of itself: a text (YAML) on the latched topic ``recording`` of each robot in it.

::

    recording: {date: 2026-11-21 18:00:00+00:00, robots: [pioneer], file: /data/pioneer_2026-11-21-18-00-00.bag, topics:
        [/pioneer/pose, ...]}
    versions: {pioneer_control: 0.1.0, commit: 8d1c2e4..., rospy: 1.15.15, rosbag: 1.15.15, python: 3.11.2, system:
        Debian GNU/Linux 12 (bookworm)}
    nodes:
      /pioneer/p2os: {serves: [...], publishes: [...], hears: [...]}
    parameters:                     the whole parameter server: {pioneer: {p2os: {port: ...}}}

It is published again when nodes or parameters change, so a bag may hold several descriptions. Each node that ever ran
is in one of them.
"""

import os
import platform
import subprocess
import sys
from typing import Any, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

import yaml

from ... import __version__
from ...errors import UsageError


class Description(NamedTuple):
    """A recording's description as values."""

    recording: Mapping[str, Any]
    """date, robots, file, topics"""
    versions: Mapping[str, str]
    nodes: Mapping[str, Mapping[str, Sequence[str]]]
    """node -> serves, publishes, hears"""
    parameters: Mapping[str, Any]
    """The tree of the parameter server."""

    def parameters_of(self, node: str) -> Dict[str, Any]:
        """The private parameters of a node, as a tree; empty where it has none. `node`: its whole name."""
        tree: Any = self.parameters
        for name in node.strip("/").split("/"):
            tree = tree.get(name, {}) if isinstance(tree, Mapping) else {}
        return dict(tree) if isinstance(tree, Mapping) else {}


class _Dumper(yaml.SafeDumper):
    """Writes also values that only XML-RPC knows, and writes what is there twice two times."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_multi_representer(object, lambda dumper, value: dumper.represent_str(str(getattr(value, "data", value))))


class _Loader(yaml.SafeLoader):
    """Reads what `_Dumper` writes. It refuses aliases: a few of them can make more values than there is memory."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):  # type: ignore[no-untyped-call]  # PyYAML's stubs have no types there
            raise yaml.YAMLError("it has an alias")
        return super().compose_node(parent, index)


def text_of(description: Description) -> str:
    """The text that is published."""
    return yaml.dump(description._asdict(), Dumper=_Dumper, sort_keys=False, allow_unicode=True,
                     default_flow_style=None, width=1000)


def description_of(text: str) -> Description:
    """The values of a published text.

    Raises:
        UsageError: the text is not a description.
    """
    try:
        given = yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise UsageError("no description of a recording: %s" % error) from error
    if not isinstance(given, dict) or not {"recording", "parameters"} <= set(given):
        raise UsageError("no description of a recording: %r" % text[:80])
    return Description(*(given.get(field) or {} for field in Description._fields))


def nodes_of(state: Sequence[Sequence[Tuple[str, Sequence[str]]]]) -> Dict[str, Dict[str, list]]:
    """Who publishes, hears and serves what, by node. `state`: what a ROS master's getSystemState() returned."""
    nodes: Dict[str, Dict[str, list]] = {}
    for kind, entries in zip(("publishes", "hears", "serves"), state):
        for name, there in entries:
            for node in there:
                nodes.setdefault(node, {}).setdefault(kind, []).append(name)
    return {node: {kind: sorted(names) for kind, names in sorted(does.items(), reverse=True)}
            for node, does in sorted(nodes.items())}


def versions(source: str = __file__) -> Dict[str, str]:
    """Versions of all that the run may depend on, as far as they can be known. `source`: a file of this package."""
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
    """The git commit of a file, with a word if it has changes; None where the file is in no repository."""
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
    """The version of a ROS package; None where it is not installed."""
    import rospkg

    try:
        return rospkg.RosPack().get_manifest(name).version
    except (rospkg.ResourceNotFound, rospkg.InvalidManifest):
        return None


def _system() -> str:
    """The name that the operating system gives itself."""
    try:
        with open("/etc/os-release", encoding="utf-8") as file:
            return dict(line.rstrip().split("=", 1) for line in file if "=" in line).get("PRETTY_NAME", "").strip('"')
    except OSError:
        return sys.platform

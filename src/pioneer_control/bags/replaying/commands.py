"""The commands in a bag: what a robot was told, and how ``rosbag play`` brings a bag back without commanding anything.

There the commands come back under ``recorded/``.
"""

import contextlib
import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from geometry_msgs.msg import Twist
from std_msgs.msg import String

from ...errors import UsageError
from ...msg import GripperState, MotorState, WheelVelocities
from ..command_line import say
from ..reader import BagConnection, plural, read_bag
from ..records import BagError
from ..recording.description import description_of

TOLD = {"cmd_vel": Twist, "cmd_wheels": WheelVelocities, "cmd_motor_state": MotorState,
        "gripper_control": GripperState}
"""What a robot is told, and can be told again: message by the topic's last name."""

RECORDED, RERUN = ASIDE = "recorded", "rerun"
"""Namespaces below that of a command. The commands of the bag are played in the first one. A program that hears the bag
sends its commands to the second one."""

COMMANDS = {
    "cmd_vel": "drives",
    "cmd_wheels": "drives each side",
    "cmd_motor_state": "switches the motors on",
    "gripper_control": "moves the gripper",
    "stop_button": "presses the STOP button of a simulated robot, and lets it go",
    "ptz_control": "moves a camera",
    "joy": "a joystick: nodes that listen to it drive",
    "goal": "sends a navigation, or an arm, on its way",
    "cancel": "ends that",
    "initialpose": "tells a navigation where it is",
}
"""Last names of topics that make a node do something, and what it would do."""

COMMAND_TYPES = "Twist", "TwistStamped", "WheelVelocities"
"""Last names of message types that drive, whatever their topic is called."""

QUEUE = ["--queue=100000"]
"""Option of rosbag play: so many messages may wait on a topic. A subscriber that is busy for a moment misses none."""

REMAPPING = re.compile(r"[\w~/]+:=")
"""Begin of a word that ROS takes from a command line."""

NAME = re.compile("[A-Za-z/][A-Za-z0-9_/]*")
"""What ROS takes for the name of a topic."""

PREFIX = re.compile(r"--pr|-\w*p")
"""Begin of rosbag play's option --prefix, and -p."""


def is_command(topic: str, type_name: str) -> bool:
    """Whether messages of a topic are commands: a node that hears them may do something."""
    return topic.rpartition("/")[2] in COMMANDS or type_name.rpartition("/")[2] in COMMAND_TYPES


def absolute(topic: str) -> str:
    """A topic's whole name; a bag may have it without the slash."""
    return topic if topic.startswith("/") else "/" + topic


def aside(topic: str, folder: str = RECORDED) -> str:
    """Another name for a topic, on which no node listens for commands.

    ``/pioneer/cmd_vel`` becomes ``/pioneer/recorded/cmd_vel``. `folder`: the namespace that is put in.
    """
    namespace, _, name = absolute(topic).rpartition("/")
    return "%s/%s/%s" % (namespace, folder, name)


def player(files: Sequence[str], topics: Mapping[str, str], options: Sequence[str] = ()) -> List[str]:
    """The command that plays bags with their own clock, in order of time: one bag, or the parts of a recording.

    Args:
        files: the bags.
        topics: {topic: type} of the bags.
        options: more for rosbag play.

    Raises:
        UsageError: an option would bring commands back elsewhere than under `RECORDED`.
    """
    commands = sorted({absolute(topic) for topic, kind in topics.items() if is_command(topic, kind)})
    _check_names(options, commands)
    played = list(files)
    if "/clock" in topics:      # recorded in simulated time: two clocks would fight
        played = ["--topics", *sorted(set(topics) - {"/clock"}), "--bags", *files]
    return ["rosrun", "rosbag", "play", "--clock", *QUEUE, *options, *played,
            *("%s:=%s" % (topic, aside(topic)) for topic in commands)]


def _check_names(options: Sequence[str], commands: Sequence[str]) -> None:
    """Refuse options that give a command another name, or another topic the name of a command.

    Args:
        options: of rosbag play.
        commands: whole names of the topics of the bag that command.
    """
    for word in options:
        source, given, target = word.partition(":=")
        renamed = bool(REMAPPING.match(word)) and (absolute(source) in commands or is_command(target, ""))
        if renamed or PREFIX.match(word) or source == "__ns" and given:
            raise UsageError("%s is not legal here: what commanded comes back under %s/ in its own namespace, and "
                             "nowhere else" % (word, RECORDED))


def recorded_topics(files: Sequence[str]) -> Dict[str, str]:
    """The topics of bags, {topic: type}.

    Raises:
        BagError: rosbag play would not play one of the bags.
    """
    import rosbag

    connections = read_bag(files, lambda connection: False).connections     # says which file is no bag at all
    for path in files:
        try:
            rosbag.Bag(path, skip_index=True).close()
        except rosbag.ROSBagUnindexedException:
            raise BagError("%s has no index: its recorder is still running or was killed, or it was cut off. When it "
                           "has ended: rosbag reindex %s" % (path, path)) from None
        except (rosbag.ROSBagException, OSError, EOFError, ValueError) as error:
            raise BagError("%s is damaged: %s. This makes what is left of it a bag again: rosbag reindex %s"
                           % (path, error, path)) from None
    odd = sorted({connection.topic for connection in connections if not NAME.fullmatch(connection.topic)})
    if odd:
        raise BagError("%s: %r is no name of a topic, and rosbag play takes none of the bag: leave it out with rosbag "
                       "filter" % (" ".join(files), odd[0]))
    if not connections:
        raise BagError("%s: there is nothing in it" % " ".join(files))
    return {connection.topic: connection.type for connection in connections}


class RecordedCommands(NamedTuple):
    """What a bag has of one robot, by the last names of topics."""

    robot: str
    """namespace"""
    messages: Dict[str, List[Tuple[float, Any]]]
    """(s, message) in order of time"""
    senders: Dict[str, str]
    """the first node that published; empty where the bag does not say"""
    begin: float
    """s: first message of the bag"""

    def newest(self, name: str) -> Any:
        """The newest message on a topic; None where there is none."""
        return self.messages[name][-1][1] if name in self.messages else None

    def parameters_of(self, node: str) -> Dict[str, Any]:
        """The private parameters of a node, by the newest description of the recording that has any; else empty."""
        for _, message in reversed(self.messages.get("recording", [])):
            with contextlib.suppress(UsageError):   # a description that makes no sense
                known = description_of(message.data).parameters_of(node)
                if known:
                    return known
        return {}


def read_commands(files: Sequence[str], robot: str, commands: Mapping[str, type],
                  others: Optional[Mapping[str, type]] = None) -> RecordedCommands:
    """Read what a robot was told. A message is left out when its fields are not those of the type given for its topic.

    Args:
        files: a bag, or the parts of a recording.
        robot: its namespace; "": the only robot that was told something.
        commands: {last name of a topic: message class} of what a robot is told.
        others: likewise, of what else is read.

    Raises:
        BagError: the robot was told nothing; or no robot is named, and several were told something.
    """
    wanted = {**commands, **(others or {}), "recording": String}

    def is_wanted(connection: BagConnection) -> bool:
        kind = wanted.get(connection.topic.rpartition("/")[2])
        return kind is not None and connection.md5sum == kind._md5sum

    reader = read_bag(files, is_wanted)
    robots: Dict[str, RecordedCommands] = {}
    for connection, message, nanoseconds in reader.decoded():
        namespace, _, name = absolute(connection.topic).rpartition("/")
        found = robots.setdefault(namespace.strip("/"), RecordedCommands(namespace.strip("/"), {}, {}, 0.0))
        found.messages.setdefault(name, []).append((nanoseconds * 1e-9, message))
        found.senders.setdefault(name, connection.caller)
    if reader.damage:
        say("%s: %s" % (", ".join(files), reader.damage))
    for topic, count in reader.undecoded.items():
        say("%s on %s could not be understood, and will be missing." % (plural(count, "message"), topic))
    told = sorted(name for name, found in robots.items() if set(found.messages) & set(commands))
    chosen = [name for name in told if robot.strip("/") in ("", name)]
    if not chosen:
        who = "robot %r was told nothing" % robot.strip("/") if robot.strip("/") else "no robot was told anything"
        others_told = "; these robots were: " + ", ".join(told) if told else ""
        raise BagError("%s: %s in it (%s)%s" % (files[0], who, ", ".join(commands), others_told))
    if len(chosen) > 1:
        raise BagError("%s: %s robots were told something: %s. Choose one with robot:=NAME"
                       % (files[0], len(chosen), ", ".join(chosen)))
    return robots[chosen[0]]._replace(begin=(reader.begin or 0) * 1e-9)

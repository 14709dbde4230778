"""Read the commands in a bag, and make a ``rosbag play`` command line that plays the bag without commanding a robot.

``rosbag play`` then publishes the commands of the bag under ``recorded/``.
"""

import contextlib
import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from geometry_msgs.msg import Twist
from std_msgs.msg import Bool, String

from ...errors import UsageError
from ...msg import Accelerations, GripperState, MotorState, Sounds, WheelVelocities
from ..command_line import say
from ..reader import BagConnection, plural, read_bag
from ..records import BagError
from ..recording.description import description_of

TOLD = {"cmd_vel": Twist, "teleop/cmd_vel": Twist, "cmd_wheels": WheelVelocities, "cmd_motor_state": MotorState,
        "gripper_control": GripperState, "teleop/gripper_control": GripperState, "accelerations": Accelerations,
        "say": Sounds, "stop_all": Bool}
"""The topics on which a robot receives commands that can be sent again: message class by the topic's name."""
BY_HAND = "teleop"
"""The namespace within that of a robot for the commands of a person."""

RECORDED, RERUN = ASIDE = "recorded", "rerun"
"""Names that are inserted into the name of a command topic, as in ``/pioneer/recorded/cmd_vel``. Under the first name
``rosbag play`` publishes the commands of a bag. Under the second name a program publishes commands in a re-run.
"""

COMMANDS = {
    "cmd_vel": "drives",
    "cmd_wheels": "drives each side",
    "cmd_motor_state": "switches the motors on",
    "gripper_control": "moves the gripper",
    "teleop/cmd_vel": "drives, and takes over from programs",
    "teleop/gripper_control": "moves the gripper, and takes over from programs",
    "accelerations": "changes how the robot brakes, for a moment",
    "say": "plays notes on the loudspeaker",
    "stop_all": "locks the robot, and takes the lock away",
    "stop_button": "presses the STOP button of a simulated robot, and lets it go",
    "ptz_control": "moves a camera",
    "ptz_joint_control": "moves a camera",
    "joy": "a joystick: nodes that listen to it drive",
    "goal": "sends a navigation, or an arm, on its way",
    "cancel": "ends that",
    "initialpose": "tells a navigation where it is",
}
"""Last names of topics whose messages make a node act, each with the action in words."""

COMMAND_TYPES = "Twist", "TwistStamped", "WheelVelocities"
"""Message types (without their package) that make a robot drive, on topics of any name."""

QUEUE = ["--queue=100000"]
"""The option of ``rosbag play`` that sets the length of its queues, in messages for each topic.

With such long queues, a subscriber that is busy for a moment misses no message.
"""

REMAPPING = re.compile(r"[\w~/]+:=")
"""Matches the beginning of a word that ROS takes from a command line, such as ``cmd_vel:=`` or ``__name:=``."""

NAME = re.compile("[A-Za-z/][A-Za-z0-9_/]*")
"""Matches a legal name of a ROS topic."""

PREFIX = re.compile(r"--pr|-\w*p")
"""Matches the beginning of the ``rosbag play`` option --prefix, and of its short form -p."""


def is_command(topic: str, type_name: str) -> bool:
    """Return whether the messages of a topic are commands. A node that receives a command may act."""
    return topic.rpartition("/")[2] in COMMANDS or type_name.rpartition("/")[2] in COMMAND_TYPES


def absolute(topic: str) -> str:
    """Return the full name of a topic, with a slash at its beginning. In a bag the slash may be missing."""
    return topic if topic.startswith("/") else "/" + topic


def robot_and_name(topic: str) -> Tuple[str, str]:
    """Return the namespace of a robot and the name of its topic: ``"/pioneer", "teleop/cmd_vel"``."""
    namespace, _, name = absolute(topic).rpartition("/")
    robot, _, last = namespace.rpartition("/")
    return (robot, "%s/%s" % (last, name)) if last == BY_HAND else (namespace, name)


def aside(topic: str, folder: str = RECORDED) -> str:
    """Return the name of a topic for commands that no robot is to receive.

    ``/pioneer/cmd_vel`` becomes ``/pioneer/recorded/cmd_vel``. `folder` is the name that is inserted.
    """
    namespace, name = robot_and_name(topic)
    return "%s/%s/%s" % (namespace, folder, name)


def player(files: Sequence[str], topics: Mapping[str, str], options: Sequence[str] = ()) -> List[str]:
    """Return the command line of a ``rosbag play`` that publishes commands only under `RECORDED`.

    It plays the messages in order of time, and publishes the time of the bag as ROS time (/clock).

    Args:
        files: one bag, or all parts of one recording.
        topics: the topics of the bags, {topic: type}.
        options: more options for ``rosbag play``.

    Raises:
        UsageError: with one of the options, commands would be published under other names.
    """
    commands = sorted({absolute(topic) for topic, kind in topics.items() if is_command(topic, kind)})
    _check_names(options, commands)
    played = list(files)
    if "/clock" in topics:      # recorded in simulated time: rosbag play publishes /clock itself
        played = ["--topics", *sorted(set(topics) - {"/clock"}), "--bags", *files]
    return ["rosrun", "rosbag", "play", "--clock", *QUEUE, *options, *played,
            *("%s:=%s" % (topic, aside(topic)) for topic in commands)]


def _check_names(options: Sequence[str], commands: Sequence[str]) -> None:
    """Raise UsageError when an option gives a command topic another name, or another topic the name of a command.

    Args:
        options: the options for ``rosbag play``.
        commands: the full names of the command topics in the bag.
    """
    for word in options:
        source, given, target = word.partition(":=")
        renamed = bool(REMAPPING.match(word)) and (absolute(source) in commands or is_command(target, ""))
        if renamed or PREFIX.match(word) or source == "__ns" and given:
            raise UsageError("%s is not legal here: what commanded comes back under %s/ in its own namespace, and "
                             "nowhere else" % (word, RECORDED))


def recorded_topics(files: Sequence[str]) -> Dict[str, str]:
    """Return the topics of bags with their types, {topic: type}.

    Raises:
        BagError: ``rosbag play`` cannot play one of the bags. The error message says why.
    """
    topics: Dict[str, str] = {}
    for path in files:
        reader = read_bag(path, lambda connection: False)
        if not reader.indexed:
            raise BagError("%s has no whole index: it is damaged or cut off, or its recorder still runs or was killed. "
                           "When the recorder has ended: rosbag reindex %s" % (path, path))
        topics.update((connection.topic, connection.type) for connection in reader.connections)
    if not topics:
        raise BagError("%s: there is nothing in it" % " ".join(files))
    for topic in topics:
        if not NAME.fullmatch(topic):
            raise BagError("%s: %r is no name of a topic, and rosbag play takes none of the bag: leave it out with "
                           "rosbag filter" % (" ".join(files), topic))
    return topics


class RecordedCommands(NamedTuple):
    """What a bag contains about one robot. The keys of the dictionaries are the names of topics: see TOLD."""

    robot: str
    """The namespace of the robot, without slashes at its ends."""
    messages: Dict[str, List[Tuple[float, Any]]]
    """For each topic the messages in order of time: (time in s, message)."""
    senders: Dict[str, str]
    """For each topic the name of the first node that published on it. An empty name if the bag does not contain it."""
    begin: float
    """The time of the first message in the bag, of any topic (s)."""

    def newest(self, name: str) -> Any:
        """Return the newest message on the topic with the last name ``name``. None if the bag has no message on it."""
        return self.messages[name][-1][1] if name in self.messages else None

    def parameters_of(self, node: str) -> Dict[str, Any]:
        """Return the private parameters of ``node`` (a full name), as the recording describes them.

        When a bag has several descriptions, the newest one with parameters of the node counts. Empty if there is none.
        """
        for _, message in reversed(self.messages.get("recording", [])):
            with contextlib.suppress(UsageError):   # the description cannot be read
                known = description_of(message.data).parameters_of(node)
                if known:
                    return known
        return {}


def read_commands(files: Sequence[str], robot: str, commands: Mapping[str, type],
                  others: Optional[Mapping[str, type]] = None) -> RecordedCommands:
    """Read the commands that a robot received, and other messages of the robot, from a bag.

    A message is left out when its type does not have the fields of the given class. If the bag is damaged, a printed
    line says what is missing.

    Args:
        files: one bag, or all parts of one recording.
        robot: the namespace of the robot. Empty: the only robot in the bag that received commands.
        commands: the topics on which the robot receives commands, {last name of the topic: message class}.
        others: more topics of the robot to read, {last name of the topic: message class}.

    Raises:
        BagError: the robot received no commands. Or `robot` is empty, and several robots received commands.
    """
    wanted = {**commands, **(others or {}), "recording": String}

    def is_wanted(connection: BagConnection) -> bool:
        kind = wanted.get(robot_and_name(connection.topic)[1])
        return kind is not None and connection.md5sum == kind._md5sum

    reader = read_bag(files, is_wanted)
    robots: Dict[str, RecordedCommands] = {}
    for connection, message, nanoseconds in reader.decoded():
        namespace, name = robot_and_name(connection.topic)
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

"""What a robot of a bag was told, and by which nodes: a re-run and a re-drive begin with it."""

from typing import Any, Counter, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from std_msgs.msg import String

from ...errors import UsageError
from ..command_line import say
from ..reader import BagConnection, decode, plural, read_bag
from ..records import BagError
from ..recording.description import Description, description_of
from .playback import absolute


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

    def descriptions(self) -> Iterator[Description]:
        """The recording's descriptions that make sense, the newest first."""
        for _, message in reversed(self.messages.get("recording", [])):
            try:
                yield description_of(message.data)
            except UsageError:
                continue


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
    damaged: Counter[str] = Counter()
    robots: Dict[str, RecordedCommands] = {}
    for topic, connection, data, nanoseconds in reader:
        namespace, _, name = absolute(topic).rpartition("/")
        found = robots.setdefault(namespace.strip("/"), RecordedCommands(namespace.strip("/"), {}, {}, 0.0))
        try:
            message = decode(connection, data)
            found.messages.setdefault(name, []).append((nanoseconds * 1e-9, message))
            found.senders.setdefault(name, connection.caller)
        except BagError:
            damaged[topic] += 1
    if reader.damage:
        say("%s: %s" % (", ".join(files), reader.damage))
    for topic, count in damaged.items():
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

"""What a robot of a bag was told, and by whom: what a re-run and a re-drive begin with."""

from collections import Counter
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

from std_msgs.msg import String

from ...errors import UsageError
from ..reader import BagError, decode, plural, read_bag
from ..recording.description import Description, description_of
from .replay import absolute
from .stage import say


class Told(NamedTuple):
    """What a bag has of one robot. Topics are known by their last names."""

    robot: str  # namespace
    messages: Dict[str, List[Tuple[float, Any]]]  # s and message, by topic
    senders: Dict[str, str]  # the first node that published, by topic; empty where the bag does not say
    begin: float  # s: first message of the bag

    def descriptions(self) -> Iterator[Description]:
        """Those of the recording that make sense, the newest first."""
        for _, message in reversed(self.messages.get("recording", [])):
            try:
                yield description_of(message.data)
            except UsageError:
                continue


def read_told(files: Sequence[str], robot: str, commands: Mapping[str, type], others: Mapping[str, type] = {}) -> Told:
    """Read what a robot was told on the topics ``commands``, and what there is of it on ``others``; of "" the only one that was told something.
    What has other fields than the type that is given for its topic is somebody else's, and left out.

    Raises BagError when it was told nothing, or when there are several.
    """
    wanted = {**commands, **others, "recording": String}
    reader = read_bag(files, lambda connection: connection.md5sum == getattr(wanted.get(connection.topic.rpartition("/")[2]), "_md5sum", None))
    damaged: "Counter[str]" = Counter()
    messages: Dict[str, Dict[str, list]] = {}
    senders: Dict[str, Dict[str, str]] = {}
    for topic, connection, data, nanoseconds in reader:
        namespace, _, name = absolute(topic).rpartition("/")
        try:
            message = decode(connection, data)
        except BagError:
            damaged[topic] += 1
            continue
        messages.setdefault(namespace.strip("/"), {}).setdefault(name, []).append((nanoseconds * 1e-9, message))
        senders.setdefault(namespace.strip("/"), {}).setdefault(name, connection.caller)
    if reader.damage:
        say("%s: %s" % (", ".join(files), reader.damage))
    for topic, count in damaged.items():
        say("%s on %s could not be understood, and will be missing." % (plural(count, "message"), topic))
    told = sorted(namespace for namespace, found in messages.items() if set(found) & set(commands))
    chosen = robot.strip("/")
    if chosen and chosen not in told or not told:
        raise BagError("%s: %s in it (%s)" % (files[0], f"robot {chosen!r} was told nothing" if chosen else "nobody was told anything", ", ".join(commands))
                       + ("; who was: %s" % ", ".join(told) if told else ""))
    if not chosen and len(told) > 1:
        raise BagError("%s: %s robots were told something: %s. Choose one with robot:=NAME" % (files[0], len(told), ", ".join(told)))
    chosen = chosen or told[0]
    return Told(chosen, messages[chosen], senders[chosen], (reader.begin or 0) * 1e-9)

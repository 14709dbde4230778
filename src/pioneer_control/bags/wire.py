"""The bytes of a robot's line in a bag, as text: ``python3 -m pioneer_control.bags.wire RUN.bag``.

`p2os.recording` is the format.

Times are seconds since the first bytes, by the driver's stamps. Each topic is a robot, and has a number. Where
something is missing, a note says so.
"""

import datetime
import os
import sys
from typing import Any, Dict, Iterator, List, Optional, Sequence

from ..errors import PioneerError, UsageError
from ..msg import Wire
from ..p2os.recording import TITLE, Entry, written
from ..whole_file import writing
from .command_line import parser_of, stem
from .reader import BagReader, read_bag

HOW_TO = ("it has no bytes of a robot's line: the driver publishes them with its parameter publish_wire (roslaunch "
          "pioneer_control pioneer.launch publish_wire:=true), and the recorder keeps them when told to (roslaunch "
          "pioneer_control record.launch also:=wire)")


def wire_entries(reader: BagReader) -> Iterator[Entry]:
    """What went over the robots' lines in a bag, with notes of what is missing. A bag without lines gives nothing."""
    begin = None
    numbers: Dict[str, int] = {}
    counts: Dict[str, int] = {}     # seq of the newest message of each topic
    for connection, message, _ in reader.decoded():     # the number of a damaged one is missing
        topic = connection.topic
        if begin is None:
            begin = message.header.stamp
            day = datetime.datetime.fromtimestamp(begin.to_sec(), datetime.timezone.utc)
            yield _note(0.0, "begins at %.6f, %s UTC" % (begin.to_sec(), day.strftime("%Y-%m-%d %H:%M:%S")))
        time, count = (message.header.stamp - begin).to_sec(), message.header.seq
        if topic not in numbers:
            numbers[topic] = len(numbers) + 1
            yield _note(time, "robot %s is %s" % (numbers[topic], topic))
        missing = count - counts.get(topic, count - 1) - 1
        counts[topic] = count
        if missing:
            slow = "%s pieces are missing: the recorder was too slow" % missing
            yield _note(time, "robot %s: %s" % (numbers[topic], slow if missing > 0 else "its driver begins anew"))
        yield (Entry(time, numbers[topic], message.to_robot, bytes(message.data)) if message.data else
               _note(time, "robot %s: pieces are missing: ROS was too slow for the driver" % numbers[topic]))


def _note(time: float, text: str) -> Entry:
    return Entry(time, 0, False, b"", text)


def write_wire(bags: Sequence[str], path: str) -> str:
    """Write into a file what the parts of a recording hold of the robots' lines.

    Returns:
        What is wrong with the bag, in sentences.

    Raises:
        UsageError: the bag cannot be read, or the file cannot be written, or the bag holds nothing of a line. Then the
            error says how to record it.
    """
    if any(os.path.realpath(path) == os.path.realpath(bag) for bag in bags):
        raise UsageError("%s is the bag itself: give another file" % path)
    reader = read_bag(bags, lambda connection: connection.type.endswith("/Wire")
                      and connection.md5sum == Wire._md5sum)
    found = wire_entries(reader)
    first = next(found, None)
    if first is None:
        raise UsageError(("%s: %s. %s" % (", ".join(bags), HOW_TO, reader.damage)).rstrip())
    try:
        with writing(path) as part, open(part, "w", encoding="utf-8") as file:
            file.write("%s\n%s\n" % (TITLE, written(first)))
            file.writelines(written(entry) + "\n" for entry in found)
            if reader.damage:
                file.write("# %s\n" % reader.damage)
    except OSError as error:
        raise UsageError("cannot write %s: %s" % (path, error.strerror or error)) from error
    return reader.damage


OPTIONS: Dict[str, Dict[str, Any]] = {
    "bags": dict(metavar="BAG", nargs="+",
                 help="what rosbag record wrote; several are the parts of one recording, in order"),
    "-o --output": dict(metavar="FILE", help="the file to write (default: beside the bag, .wire)"),
}
"""Of the command line."""


def main(arguments: Optional[List[str]] = None) -> int:
    """Write the file; 0 when it is written, 2 when there is nothing to write."""
    options = parser_of(
        "python3 -m pioneer_control.bags.wire", "Write the line of a robot that a bag holds as text.", OPTIONS,
        epilog="python3 -m pioneer_control.p2os --record RUN.wire tells it packet by packet, "
               "python3 -m pioneer_control.simulator --play RUN.wire is the robot in it.").parse_args(arguments)
    output = options.output or stem(options.bags[0]) + ".wire"
    try:
        damage = write_wire(options.bags, output)
    except (PioneerError, OSError) as error:
        print("wire: %s" % error, file=sys.stderr)
        return 2
    if damage:
        print("wire: %s" % damage, file=sys.stderr)
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

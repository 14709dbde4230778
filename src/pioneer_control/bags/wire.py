"""Write the bytes of the serial line in a bag to a text file: ``python3 -m pioneer_control.bags.wire RUN.bag``.

The driver publishes these bytes on the topic ``wire``. `p2os.recording` describes the format of the text file.

Times are seconds since the first bytes, by the driver's stamps. Each topic belongs to one robot and gets a number. A
note marks each place where bytes are missing.
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
    """Yield the bytes of the Wire messages in a bag, with notes where bytes are missing.

    Yields nothing if the bag has no Wire messages. `reader` must read Wire messages only.
    """
    begin = None
    numbers: Dict[str, int] = {}
    counts: Dict[str, int] = {}     # seq of the newest message of each topic
    for connection, message, _ in reader.decoded():     # a damaged message is left out, so its seq is missing
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
    """Write the bytes of the robots' serial lines in a recording to a text file.

    Args:
        bags: the bag, or the parts of one recording in their order.
        path: the text file.

    Returns:
        What is damaged or missing in the bag, in sentences. Empty if nothing is.

    Raises:
        UsageError: the bag cannot be read, the bag has no bytes of a serial line (the error says how to record them),
            or the file cannot be written.
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
                 help="the bag, or the parts of one recording in order"),
    "-o --output": dict(metavar="FILE", help="the file to write (default: beside the bag, .wire)"),
}
"""The options of the command line."""


def main(arguments: Optional[List[str]] = None) -> int:
    """Write the text file that the command line asks for.

    Args:
        arguments: the command line. None: that of the process.

    Returns:
        The exit status: 0 when the file is written, 2 after an error.
    """
    options = parser_of(
        "python3 -m pioneer_control.bags.wire", "Write the bytes of the serial lines in a bag as text.", OPTIONS,
        epilog="python3 -m pioneer_control.p2os --record RUN.wire explains the text packet by packet. "
               "python3 -m pioneer_control.simulator --play RUN.wire plays the robot in it.").parse_args(arguments)
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

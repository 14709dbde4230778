"""The bytes of a robot's line in a bag, as text: ``python3 -m pioneer_control.bags.wire RUN.bag``.

`p2os.recording` is the format.

Times are seconds since the first bytes, by the driver's stamps; each robot, which is each topic, has its number. Where
something is missing, a note says so.
"""

import argparse
import contextlib
import datetime
import os
import sys
from typing import Dict, Iterator, List, Optional, Sequence

from ..errors import PioneerError, UsageError
from ..msg import Wire
from ..p2os.recording import TITLE, Entry, written
from .bag_names import stem
from .reader import BagReader, BagConnection, decode, read_bag
from .records import BagError

HOW_TO = ("it has no bytes of a robot's line: the driver publishes them with its parameter publish_wire (roslaunch "
          "pioneer_control pioneer.launch publish_wire:=true), and the recorder keeps them when told to (roslaunch "
          "pioneer_control record.launch also:=wire)")


def is_wire(connection: BagConnection) -> bool:
    """Whether it carries pioneer_control/Wire, with the fields of ours."""
    return connection.type.endswith("/Wire") and connection.md5sum == Wire._md5sum


def wire_entries(reader: BagReader) -> Iterator[Entry]:
    """What went over the lines, and notes of what is missing; nothing for a bag without it."""
    begin = None
    numbers: Dict[str, int] = {}
    counts: Dict[int, int] = {}     # seq of the newest message of each robot
    for topic, connection, data, _ in reader:
        try:
            message = decode(connection, data)
        except BagError:    # its number will be missing
            continue
        stamp = message.header.stamp
        if begin is None:
            begin = stamp
            day = datetime.datetime.fromtimestamp(begin.to_sec(), datetime.timezone.utc)
            yield Entry(0.0, 0, False, b"", "begins at %.6f, %s UTC"
                        % (begin.to_sec(), day.strftime("%Y-%m-%d %H:%M:%S")))
        time = (stamp - begin).to_sec()
        if topic not in numbers:
            numbers[topic] = len(numbers) + 1
            yield Entry(time, 0, False, b"", "robot %s is %s" % (numbers[topic], topic))
        robot, count = numbers[topic], message.header.seq
        missing = count - counts.get(robot, count - 1) - 1
        counts[robot] = count
        if missing:
            slow = "%s pieces are missing: the recorder was too slow" % missing
            what = slow if missing > 0 else "its driver begins anew"
            yield Entry(time, 0, False, b"", "robot %s: %s" % (robot, what))
        if message.data:
            yield Entry(time, robot, message.to_robot, bytes(message.data))
        else:
            yield Entry(time, 0, False, b"", "robot %s: pieces are missing: ROS was too slow for the driver" % robot)


def write_wire(bags: Sequence[str], path: str) -> str:
    """Write what the parts of a recording hold of the lines. Returns what is wrong with the bag, in sentences.

    Raises:
        UsageError: the bag cannot be read, or holds nothing of a line, which says how to record it, or the file cannot
            be written.
    """
    if any(os.path.realpath(path) == os.path.realpath(bag) for bag in bags):
        raise UsageError("%s is the bag itself: give another file" % path)
    reader = read_bag(bags, is_wire)
    found = wire_entries(reader)
    first = next(found, None)
    if first is None:
        raise UsageError(("%s: %s. %s" % (", ".join(bags), HOW_TO, reader.damage)).rstrip())
    part = path + ".part"
    try:
        with open(part, "w", encoding="utf-8") as file:
            file.write("%s\n%s\n" % (TITLE, written(first)))
            file.writelines(written(entry) + "\n" for entry in found)
            if reader.damage:
                file.write("# %s\n" % reader.damage)
        os.replace(part, path)
    except OSError as error:
        raise UsageError("cannot write %s: %s" % (path, error.strerror or error)) from error
    finally:    # Ctrl-C, a full disk
        with contextlib.suppress(OSError):
            os.remove(part)
    return reader.damage


def main(arguments: Optional[List[str]] = None) -> int:
    """Write the file; 0 when it is written, 2 when there is nothing to write."""
    parser = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.bags.wire", description="Write the line of a robot that a bag holds as text.",
        epilog="python3 -m pioneer_control.p2os --record RUN.wire tells it packet by packet, "
               "python3 -m pioneer_control.simulator --play RUN.wire is the robot in it.")
    parser.add_argument("bags", metavar="BAG", nargs="+",
                        help="what rosbag record wrote; several are the parts of one recording, in order")
    parser.add_argument("-o", "--output", metavar="FILE", help="the file to write (default: beside the bag, .wire)")
    options = parser.parse_args(arguments)
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

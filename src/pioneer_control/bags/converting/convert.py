"""Convert a bag of p2os, or of this package: ``rosrun pioneer_control convert_bag IN.bag OUT.bag``.

The file `messages` converts the messages. This file reads the old bag and writes the new one, and has the command line
and the report.
"""

import argparse
import os
import sys
from contextlib import closing
from typing import Any, Counter, Dict, List, Optional, Sequence, Set, Tuple

from ...errors import PioneerError, UsageError
from ...robots import Transducer, find_model
from ...whole_file import writing
from ..command_line import Progress, parser_of
from ..reader import BagReader, read_bag
from ..writer import BagWriter
from .messages import (CONVERSIONS, DEFAULT, STATIC_FRAMES, Converter, Options, Outlet, kind_of, namespace_of,
                       transducers_of)


def survey(path: str) -> Tuple[BagReader, Dict[str, Sequence[Transducer]], Set[str]]:
    """Read what must be known before the first message of a bag is converted.

    This is quick if the bag has an index.

    Returns:
        The reader, which now knows all connections of the bag; the transducers in the first robot_info of each robot,
        by the robot's namespace; and the child frames in /tf_static.
    """
    transducers: Dict[str, Sequence[Transducer]] = {}
    frames: Set[str] = set()
    with Progress("looking") as progress:
        reader = read_bag(path, lambda connection: kind_of(connection) == "RobotInfo"
                          or connection.topic == STATIC_FRAMES, progress)
        for connection, message, _ in reader.decoded():
            if connection.topic != STATIC_FRAMES:
                transducers.setdefault(namespace_of(connection.topic), transducers_of(message))
            else:
                frames.update(transform.child_frame_id for transform in getattr(message, "transforms", ()))
    return reader, transducers, frames


def convert(source: str, target: str, options: Options) -> Tuple[Converter, List[Outlet], str]:
    """Write a new bag.

    Returns:
        The converter, which has counted messages; the connections of the new bag in order of their first message; and a
        sentence that says what is missing in the old bag (empty if nothing is missing).

    Raises:
        UsageError: a file or an option makes no sense. Then nothing is written.
        OSError: the new bag cannot be written. Then nothing is left of it.
    """
    if os.path.lexists(target):
        raise UsageError("%s exists already: name another file for the new bag" % target)
    old, transducers, frames = survey(source)
    others = [word for word in options.what if CONVERSIONS[word].kind != "SonarArray"]
    unknown = sorted({each.topic for each in old.connections if kind_of(each) == "SonarArray"
                      and namespace_of(each.topic) not in transducers})
    if unknown and options.model is None and len(others) < len(options.what):
        raise UsageError("%s does not say where the transducers of %s look (it has no robot_info): name the robot's "
                         "model, --model p3dx-sh for example, or leave sonar out: convert_bag %s %s %s"
                         % (source, ", ".join(unknown), source, target, " ".join(others) or "types"))
    converter = Converter(options, {each.topic for each in old.connections}, transducers, frames)
    numbers: Dict[Outlet, int] = {}
    with writing(target) as part, closing(BagWriter(part, old.compression or "none")) as writer, \
            Progress("converting") as progress:
        reader = read_bag(source, progress=progress)
        for message in reader:
            for outlet, data in converter(message):
                if outlet not in numbers:
                    numbers[outlet] = writer.connect(outlet.topic, outlet.header)
                writer.write(numbers[outlet], data, message.time)
    return converter, list(numbers), reader.damage


def report(source: str, target: str, converter: Converter, outlets: Sequence[Outlet], damage: str, model: str) -> str:
    """Return, in plain words, what was converted into what, what was kept, and what is wrong.

    Args:
        source, target: the paths of the old bag and of the new bag.
        converter: the converter after the last message.
        outlets: the connections of the new bag.
        damage: a sentence that says what is missing in the old bag. Empty if nothing is missing.
        model: the value of --model. Empty if it was not given.
    """
    made = [outlet for outlet in outlets if outlet.made]
    renamed = [outlet for outlet in outlets if not outlet.made and outlet.header["type"] != outlet.source.type]
    kept = [outlet for outlet in outlets if not outlet.made and outlet not in renamed]
    read = Counter(converter.dropped)
    for outlet in renamed + kept:
        read[outlet.topic] += outlet.count
    topics = ", ".join(sorted({outlet.topic for outlet in kept})) or "no topic"
    return "\n".join([
        "%s -> %s" % (source, target),
        *["  renamed %s: %s of %s are %s" % (outlet.topic, outlet.count, outlet.source.type, outlet.header["type"])
          for outlet in renamed],
        *["  made    %s: %s of %s from %s of %s" % (outlet.topic, outlet.count, outlet.header["type"],
                                                    read[outlet.source.topic], outlet.source.topic) for outlet in made],
        *["  dropped %s: %s, replaced" % each for each in converter.dropped.items()],
        "  kept    %s as they were, of %s" % (sum(outlet.count for outlet in kept), topics),
        *["  %s is in the bag already: it was not made" % topic for topic in sorted(converter.already_there)],
        *["  There was nothing to convert: neither types of p2os nor what was asked for."] * (not made and not renamed),
        *["  %s readings of transducers that %s does not have were left out: is it the right model?"
          % (converter.not_fitted, model or "the robot_info of the bag")] * bool(converter.not_fitted),
        *["  %s messages of %s are damaged: nothing was made of them" % (count, topic)
          for topic, count in converter.damaged.items()],
        *["  %s: %s What could be read was converted." % (source, damage)] * bool(damage),
    ])


OPTIONS: Dict[str, Dict[str, Any]] = {
    "bag": dict(metavar="IN.bag"),
    "output": dict(metavar="OUT.bag", help="must not exist yet"),
    "what": dict(metavar="WHAT", nargs="*", default=[], help="what to convert, see below"),
    "--model": dict(default="", help="model of the robots that have no robot_info in the bag: p3dx-sh for example"),
    "--models-file": dict(default="", metavar="FILE", help="your own table of models"),
    "--gripper": dict(action="store_true", help="these robots have a gripper"),
    "--replace": dict(action="store_true", help="leave out the old topics that were converted"),
    "--frame": dict(action="append", default=[], metavar="OLD=NEW",
                    help="rename a frame in every message; may be given again"),
}


def _parser() -> argparse.ArgumentParser:
    words = ["  %-8s %s%s" % (word, conversion.meaning, "" if conversion.by_default else " (only if you name it)")
             for word, conversion in CONVERSIONS.items()]
    return parser_of(
        "convert_bag",
        "Write a new bag in which the message types of p2os have the names of pioneer_control, with standard messages "
        "beside them.",
        OPTIONS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join(["WHAT to convert, by default %s:" % ", ".join(DEFAULT), *words, "",
                          "Everything else stays as it is: bytes, order, times, publishers, latching."]))


def _renamed(texts: Sequence[str]) -> Dict[str, str]:
    """Read the values of --frame, OLD=NEW, into a dictionary {old name: new name}. Raises UsageError."""
    renamed = {}
    for text in texts:
        old, equal, new = (part.strip().lstrip("/") for part in text.partition("="))
        if not (old and equal and new) or "=" in new:
            raise UsageError("--frame %s: not of the form OLD=NEW, odom=robot_1/odom for example" % text)
        renamed[old] = new
    return renamed


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Convert the bag that the command line names.

    Args:
        arguments: the command line. None: that of the process.

    Returns:
        The exit status. 0: the new bag is written. 1: the old bag is damaged, and the new bag has what could be read.
        2: nothing is written. 130: interrupted, and nothing is written.
    """
    options = _parser().parse_intermixed_args(arguments)
    try:
        for word in options.what:
            if word not in CONVERSIONS:
                raise UsageError("%r cannot be converted (legal: %s)" % (word, ", ".join(CONVERSIONS)))
        model = find_model(options.model, options.models_file or None) if options.model else None
        if options.gripper and model is None:
            raise UsageError("--gripper says something of the robot that --model names: name it")
        if options.gripper and model is not None and not model.can_carry_gripper:
            raise UsageError("--gripper: a model %s carries no gripper" % model.subtype)
        wanted = Options(list(dict.fromkeys(options.what)) or DEFAULT, model, options.gripper, options.replace,
                         _renamed(options.frame))
        converter, outlets, damage = convert(options.bag, options.output, wanted)
    except PioneerError as error:
        print("convert_bag: %s" % error, file=sys.stderr)
        return 2
    except OSError as error:
        print("convert_bag: %s cannot be written: %s. Nothing is left of it" % (options.output, error.strerror),
              file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("convert_bag: interrupted; %s was not written" % options.output, file=sys.stderr)
        return 130
    print(report(options.bag, options.output, converter, outlets, damage, options.model))
    return 1 if damage or converter.damaged else 0


if __name__ == "__main__":
    sys.exit(main())

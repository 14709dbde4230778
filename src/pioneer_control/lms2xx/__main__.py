"""``python3 -m pioneer_control.lms2xx 02 00 02 00 20 24 34 08`` explains these bytes of a laser's line.

``--record FILE`` explains what the laser's node has written down.
"""

import argparse
import os
import sys
from typing import List, Optional

from ..errors import UsageError
from ..wire_words import parse_hex
from .explain import explain_laser_record, explain_line, line_pieces, recorded_bytes


def main(arguments: Optional[List[str]] = None) -> int:
    """Print an explanation of the bytes in the arguments or on standard input, or of a record.

    Returns:
        The exit code: 0 when all bytes belong to whole telegrams, and for every record that can be read; 1 when some
        bytes do not. Wrong arguments, and bytes that are not hexadecimal, end the program with exit code 2.
    """
    parser = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.lms2xx", description="Explain bytes on the line of a SICK LMS2xx laser.",
        epilog="Bytes may be written as 02 00 02, 020002, 0x02, 0x00 or \\x02\\x00; without any they are read from"
               " standard input. Exit code: 0 all were whole telegrams, 1 some were not, 2 some were no hex.")
    parser.add_argument("bytes", nargs="*", help="hexadecimal bytes: one telegram, several, or a noisy stream")
    parser.add_argument("--record", metavar="FILE",
                        help="explain what the laser's node wrote (its parameter record), one line for each telegram")
    parser.add_argument("--long", action="store_true", help="every telegram of a record byte by byte")
    options = parser.parse_args(arguments)
    try:
        if options.record:
            with open(options.record, encoding="utf-8", errors="replace") as lines:
                for line in explain_laser_record(recorded_bytes(lines), options.long):
                    print(line)
            return 0
        data = parse_hex(sys.stdin.read() if not options.bytes and not sys.stdin.isatty() else " ".join(options.bytes))
    except BrokenPipeError:     # a reader such as `head` has seen enough; Python must not flush to it either
        sys.stdout = open(os.devnull, "w")
        return 0
    except (OSError, UsageError) as error:
        problem = "%s: %s" % (options.record, getattr(error, "strerror", None) or error) if options.record else error
        parser.error(str(problem))
    if not data:
        parser.error("no bytes given; try: 02 00 02 00 20 24 34 08")
    print("\n".join(explain_line(data)))
    return 0 if not any(piece.wrong for piece in line_pieces(data)) else 1


if __name__ == "__main__":
    sys.exit(main())

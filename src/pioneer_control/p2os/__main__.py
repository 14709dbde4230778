"""``python3 -m pioneer_control.p2os FA FB 03 1D 00 1D`` explains these bytes. ``--record FILE`` explains a record."""

import argparse
import os
import sys
from typing import List, Optional

from ..errors import UsageError
from ..wire_words import parse_hex
from .explain import explain, pieces
from .recording import explain_record, read_record


def main(arguments: Optional[List[str]] = None) -> int:
    """Print an explanation of the bytes in the arguments or on standard input, or of a record.

    Returns:
        The exit code: 0 when all bytes belong to whole packets, and for every record that can be read; 1 when some
        bytes do not. Wrong arguments, and bytes that are not hexadecimal, end the program with exit code 2.
    """
    parser = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.p2os", description="Explain bytes of the P2OS protocol, byte by byte.",
        epilog="Bytes may be written as FA FB 03, fafb03, 0xFA, 0xFB, 0x03 or \\xfa\\xfb\\x03; without any they are "
               "read from standard input. Exit code: 0 all were whole packets, 1 some were not, 2 some were no hex.")
    parser.add_argument("bytes", nargs="*", help="hexadecimal bytes: one packet, several, or a noisy stream")
    direction = parser.add_mutually_exclusive_group()
    direction.add_argument("--to-robot", action="store_true", help="they went to the robot: read them as commands")
    direction.add_argument("--from-robot", action="store_true", help="they came from the robot")
    parser.add_argument("--port-first", action="store_true",
                        help="the robot has PSOS, P2OS or AmigOS: its SIP has the analog port before the gripper state")
    parser.add_argument("--record", metavar="FILE",
                        help="explain the record of a line that a simulated robot wrote, one line for each packet")
    parser.add_argument("--long", action="store_true", help="every packet of a record byte by byte")
    options = parser.parse_args(arguments)
    try:
        if options.record:
            for line in explain_record(read_record(options.record), options.long, not options.port_first):
                print(line)
            return 0
        data = parse_hex(sys.stdin.read() if not options.bytes and not sys.stdin.isatty() else " ".join(options.bytes))
        if not data:
            raise UsageError("no bytes given; try: FA FB 06 0B 1B C8 00 D3 1B")
        lines = explain(data, not options.from_robot, not options.to_robot, not options.port_first)
        print("\n".join(lines), flush=True)
    except UsageError as error:
        parser.error(str(error))
    except BrokenPipeError:     # a reader such as `head` has seen enough; Python must not flush to it either
        sys.stdout = open(os.devnull, "w")
        return 0
    return 0 if not any(piece.wrong for piece in pieces(data)) else 1


if __name__ == "__main__":
    sys.exit(main())

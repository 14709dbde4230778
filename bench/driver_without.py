#!/usr/bin/python3
"""The driver without a piece of driver/prompt.py, for bench/driver.py --pieces.

    python3 bench/driver_without.py PIECE _port:=PORT
"""

import sys

from pioneer_control.driver import node, publications


def plain_connection() -> None:
    """rospy's own connections: a thread for each subscriber."""
    node.send_promptly = lambda: True


def plain_messages() -> None:
    """Ordinary messages of genpy on all topics."""
    publications.converter = lambda _, plain: plain


def plain_order() -> None:
    """The pose leaves together with all other messages of its SIP."""
    publications.POSE_AHEAD = 0.0


def plain_all() -> None:
    """No piece."""
    plain_connection()
    plain_messages()
    plain_order()


PIECES = {piece.__name__: piece for piece in (plain_connection, plain_messages, plain_order, plain_all)}

if __name__ == "__main__":
    word = sys.argv.pop(1) if len(sys.argv) > 1 else ""
    if word not in PIECES:
        sys.exit("there is no piece %r; legal: %s" % (word, ", ".join(PIECES)))
    PIECES[word]()
    sys.exit(node.main())

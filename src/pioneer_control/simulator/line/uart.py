"""What a serial port makes of bytes that come at another speed than its own (8 data bits, no parity, 1 stop bit)."""

from typing import List

BITS = 8


def as_heard(data: bytes, sent_baud: int, heard_baud: int) -> bytes:
    """The bytes that a receiver at `heard_baud` gets when these come back to back at `sent_baud`: the same ones only
    if the speeds are.

    Bit by bit: the receiver waits for the edge of a start bit, then samples in the middle of what it takes for bits.
    """
    if sent_baud == heard_baud:
        return data
    levels: List[int] = []
    for byte in data:
        levels += [0, *(byte >> bit & 1 for bit in range(BITS)), 1]
    step = sent_baud / heard_baud       # of one bit of the receiver, in bits of the sender

    def level(at: float) -> int:
        return levels[int(at)] if at < len(levels) else 1

    heard, at = bytearray(), 0.0
    while True:
        while at < len(levels) and level(at):
            at = int(at) + 1
        if at >= len(levels):
            return bytes(heard)
        heard.append(sum(level(at + (bit + 1.5) * step) << bit for bit in range(BITS)))
        at += (BITS + 1.5) * step       # in the middle of the stop bit

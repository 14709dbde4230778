"""What a serial port makes of bytes that come at another speed than its own (8 data bits, no parity, 1 stop bit)."""

BITS = 8


def as_heard(data: bytes, sent_baud: int, heard_baud: int) -> bytes:
    """The bytes that a receiver at `heard_baud` gets when these come back to back at `sent_baud`: the same ones only
    if the speeds are.

    Bit by bit: the receiver waits for the edge of a start bit, then samples in the middle of what it takes for bits.
    """
    if sent_baud == heard_baud:
        return data
    step = sent_baud / heard_baud       # of one bit of the receiver, in bits of the sender
    silence = "1" * (2 + int((BITS + 1.5) * step))
    levels = "".join("0%s1" % format(byte, "08b")[::-1] for byte in data) + silence
    heard, at = bytearray(), 0.0
    start = levels.find("0")
    while start >= 0:
        at = max(at, start)
        heard.append(sum(int(levels[int(at + (bit + 1.5) * step)]) << bit for bit in range(BITS)))
        at += (BITS + 1.5) * step       # in the middle of the stop bit
        start = levels.find("0", int(at))
    return bytes(heard)

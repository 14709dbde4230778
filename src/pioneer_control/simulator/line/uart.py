"""The bytes that a serial port receives when the sender has another baud rate (8 data bits, no parity, 1 stop bit)."""

BITS = 8


def as_heard(data: bytes, sent_baud: int, heard_baud: int) -> bytes:
    """Return the bytes that a serial receiver decodes when `data` is sent without pauses at another baud rate.

    The receiver waits for the edge of a start bit. Then it samples the line where it expects the middle of each bit.

    Args:
        data: bytes that are sent.
        sent_baud: baud rate of the sender.
        heard_baud: baud rate of the receiver. If it is equal to `sent_baud`, the result is `data`.
    """
    if sent_baud == heard_baud:
        return data
    step = sent_baud / heard_baud       # duration of one bit of the receiver, in bits of the sender
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

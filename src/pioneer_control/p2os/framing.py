"""Frames: where a packet begins and ends on the line, and whether it arrived whole (protocol sheet 1).

::

    FA FB  06  0B  3B C8 00  D3 3B
    │      │   │   │         └ checksum of id and data, high byte first (all other numbers: low byte first)
    │      │   │   └ data
    │      │   └ id: a command number to the robot, a packet type from it
    │      └ count N: how many bytes follow it (id, data and checksum)
    └ header

Both directions are framed alike. Nothing is escaped (``FA FB`` may occur inside a frame), numbered, acknowledged or
repeated.
"""

from typing import List, NamedTuple, Optional

from ..errors import EncodingError

HEADER = b"\xFA\xFB"
SMALLEST_COUNT = 3
"""Byte count of a frame without data: its id and its checksum."""
LARGEST_COUNT_SENT = 200
"""What every firmware accepts (later ones take 249). Received frames may be as long as the count byte can say."""
LARGEST_DATA_SENT = LARGEST_COUNT_SENT - SMALLEST_COUNT
PARTIAL_TIMEOUT = 0.1
"""Seconds without a byte inside a frame after which the rest will not come: call `FrameDecoder.drop_partial`."""


class Frame(NamedTuple):
    """What a frame carries: its id, and the data between id and checksum."""

    id: int
    data: bytes = b""

    @property
    def length(self) -> int:
        """How many bytes it takes on the line, from header to checksum."""
        return len(HEADER) + 1 + SMALLEST_COUNT + len(self.data)


class DecoderCounts(NamedTuple):
    """What a `FrameDecoder` has made of the bytes it was fed."""

    frames: int = 0
    """Frames delivered."""
    discarded_bytes: int = 0
    """Bytes that were part of no frame."""
    bad_checksums: int = 0
    """Places that looked like a frame, but whose checksum said no."""
    bad_counts: int = 0
    """Headers followed by an impossible byte count (below 3)."""


def checksum(body: bytes) -> int:
    """16-bit checksum of `body` (id and data): the sum of its big-endian words; an odd last byte is XORed to it."""
    even = len(body) & ~1
    total = (sum(body[0:even:2]) << 8) + sum(body[1:even:2])
    return (total ^ body[-1] if even < len(body) else total) & 0xFFFF


def encode_frame(id: int, data: bytes = b"") -> bytes:
    """The bytes of one frame, to be sent with one write.

    Raises:
        EncodingError: `id` is no byte, or `data` is longer than 197 bytes.
    """
    if type(id) is bool or not isinstance(id, int) or not 0 <= id <= 0xFF:
        raise EncodingError("frame id %r is not an integer in 0..255" % (id,))
    if len(data) > LARGEST_DATA_SENT:
        raise EncodingError("frame %d: %d bytes of data are too many (0..%d are legal)"
                            % (id, len(data), LARGEST_DATA_SENT))
    body = bytes((id,)) + data
    return HEADER + bytes((len(data) + SMALLEST_COUNT,)) + body + checksum(body).to_bytes(2, "big")


class FrameDecoder:
    """Finds the frames in a stream of bytes that may come in any pieces and with any noise.

    Give what was read to `feed`. It never raises on what comes from the line, holds back at most one unfinished frame
    (257 bytes), and needs time in proportion to the bytes. When bytes looked like a frame and are not one, only the
    first of them is dropped: the search goes on right behind it, so noise never hides a good frame.
    """

    def __init__(self) -> None:
        self._held = bytearray()
        self._frames = self._bad_checksums = self._bad_counts = self._discarded = 0

    @property
    def waiting(self) -> bool:
        """Whether the bytes so far end inside what may become a frame."""
        return bool(self._held)

    @property
    def counts(self) -> DecoderCounts:
        """What was delivered and what was thrown away since the start."""
        return DecoderCounts(self._frames, self._discarded, self._bad_checksums, self._bad_counts)

    def feed(self, data: bytes) -> List[Frame]:
        """The frames that are complete with these bytes, which follow all that was fed before.

        Bytes that cannot become a frame are dropped. An unfinished frame is kept.
        """
        self._held += data
        held, frames = self._held, []   # type: bytearray, List[Frame]
        while held:
            end = self._frame_end()
            if end is None:
                break
            if end:
                frames.append(Frame(held[3], bytes(held[4:end - 2])))
            else:
                next_start = held.find(HEADER[:1], 1)
                end = next_start if next_start >= 0 else len(held)
                self._discarded += end
            del held[:end]      # it moves no bytes
        self._frames += len(frames)
        return frames

    def drop_partial(self) -> List[Frame]:
        """Give up the unfinished frame, because `PARTIAL_TIMEOUT` passed without a byte.

        Returns:
            The whole frames that begin inside it. Nothing is held afterwards.
        """
        frames: List[Frame] = []
        while self._held:
            del self._held[0]
            self._discarded += 1
            frames += self.feed(b"")
        return frames

    def _frame_end(self) -> Optional[int]:
        """Where the frame ends with which the held bytes begin; 0 when they do not; None when more bytes must tell."""
        held = self._held
        if not HEADER.startswith(held[:2]):
            return 0
        if len(held) < 3:
            return None
        count = held[2]
        if count < SMALLEST_COUNT:
            self._bad_counts += 1
            return 0
        end = 3 + count
        if end > len(held):
            return None
        if checksum(held[3:end - 2]) != held[end - 2] << 8 | held[end - 1]:
            self._bad_checksums += 1
            return 0
        return end

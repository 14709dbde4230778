"""Frames: where a packet begins and ends on the line, and whether it arrived whole (protocol sheet 1).

::

    FA FB  06  0B  3B C8 00  D3 3B
    │      │   │   │         └ checksum of id and data, high byte first (all other numbers: low byte first)
    │      │   │   └ data
    │      │   └ id: a command number to the robot, a packet type from it
    │      └ count N: how many bytes follow it (id, data and checksum)
    └ header

Both directions use the same frames. Data bytes are not escaped: ``FA FB`` may occur inside a frame. Frames are not
numbered, acknowledged or repeated.
"""

from typing import List, NamedTuple, Optional

from ..errors import EncodingError

HEADER = b"\xFA\xFB"
SMALLEST_COUNT = 3
"""The byte count of a frame without data: one byte of id and two bytes of checksum."""
LARGEST_COUNT_SENT = 200
"""The largest byte count that every firmware accepts (later firmware accepts 249). Received frames may be longer."""
LARGEST_DATA_SENT = LARGEST_COUNT_SENT - SMALLEST_COUNT
PARTIAL_TIMEOUT = 0.1
"""Time (s) without a byte inside a frame, after which the rest will not come. Then call `FrameDecoder.drop_partial`."""


class Frame(NamedTuple):
    """The content of one frame: its id, and the data between id and checksum."""

    id: int
    data: bytes = b""

    @property
    def length(self) -> int:
        """The number of bytes of the whole frame on the line, from header to checksum."""
        return len(HEADER) + 1 + SMALLEST_COUNT + len(self.data)


class DecoderCounts(NamedTuple):
    """Counters of a `FrameDecoder`, since it was made."""

    frames: int = 0
    """Number of frames that it has returned."""
    discarded_bytes: int = 0
    """Number of bytes that belonged to no frame."""
    bad_checksums: int = 0
    """How often bytes looked like a frame, but the checksum was wrong."""
    bad_counts: int = 0
    """How often an impossible byte count (below 3) followed a header."""


def checksum(body: bytes) -> int:
    """The 16-bit checksum of `body` (id and data).

    It is the sum of the big-endian words. If the number of bytes is odd, the last byte is XORed to the sum.
    """
    even = len(body) & ~1
    total = (sum(body[0:even:2]) << 8) + sum(body[1:even:2])
    return (total ^ body[-1] if even < len(body) else total) & 0xFFFF


def encode_frame(id: int, data: bytes = b"") -> bytes:
    """The bytes of one frame, to be sent with one write.

    Raises:
        EncodingError: `id` is not an integer in 0..255, or `data` is longer than 197 bytes.
    """
    if type(id) is bool or not isinstance(id, int) or not 0 <= id <= 0xFF:
        raise EncodingError("frame id %r is not an integer in 0..255" % (id,))
    if len(data) > LARGEST_DATA_SENT:
        raise EncodingError("frame %d: %d bytes of data are too many (0..%d are legal)"
                            % (id, len(data), LARGEST_DATA_SENT))
    body = bytes((id,)) + data
    return HEADER + bytes((len(data) + SMALLEST_COUNT,)) + body + checksum(body).to_bytes(2, "big")


class FrameDecoder:
    """Finds the frames in a stream of bytes that may come in pieces of any size and with any noise.

    Give all received bytes to `feed`. It never raises, whatever the bytes are. It holds at most one unfinished frame
    (257 bytes), and its time is proportional to the number of bytes. When bytes look like a frame but are not a frame,
    only the first byte is dropped, and the search goes on right behind it. So noise never hides a good frame.
    """

    def __init__(self) -> None:
        self._held = b""
        self._frames = self._bad_checksums = self._bad_counts = self._discarded = 0

    @property
    def waiting(self) -> bool:
        """Whether the decoder holds bytes that may become a frame."""
        return bool(self._held)

    @property
    def counts(self) -> DecoderCounts:
        """The numbers of frames and of discarded bytes since the decoder was made."""
        return DecoderCounts(self._frames, self._discarded, self._bad_checksums, self._bad_counts)

    def feed(self, data: bytes) -> List[Frame]:
        """The frames that are complete with these bytes. `data` follows all bytes that were fed before.

        Bytes that cannot become a frame are dropped. An unfinished frame is kept.
        """
        held, at, frames = self._held + data, 0, []     # type: bytes, int, List[Frame]
        while at < len(held):
            end = self._frame_end(held, at)
            if end is None:
                break
            if end:
                frames.append(Frame(held[at + 3], held[at + 4:end - 2]))
            else:
                next_start = held.find(HEADER[:1], at + 1)
                end = next_start if next_start >= 0 else len(held)
                self._discarded += end - at
            at = end
        self._held = held[at:]
        self._frames += len(frames)
        return frames

    def drop_partial(self) -> List[Frame]:
        """Give up the unfinished frame, because `PARTIAL_TIMEOUT` passed without a byte.

        Returns:
            The whole frames that begin inside the unfinished frame. After this call no bytes are held.
        """
        frames: List[Frame] = []
        while self._held:
            self._held = self._held[1:]
            self._discarded += 1
            frames += self.feed(b"")
        return frames

    def _frame_end(self, held: bytes, at: int) -> Optional[int]:
        """The index behind the frame at index `at`; 0 if no frame is there; None if more bytes are needed."""
        if not HEADER.startswith(held[at:at + 2]):
            return 0
        if len(held) < at + 3:
            return None
        count = held[at + 2]
        if count < SMALLEST_COUNT:
            self._bad_counts += 1
            return 0
        end = at + 3 + count
        if end > len(held):
            return None
        if checksum(held[at + 3:end - 2]) != held[end - 2] << 8 | held[end - 1]:
            self._bad_checksums += 1
            return 0
        return end

"""The columns of a recording: all frames of one robot as a binary message for the page (docs/page-protocol.md).

Pure. The numbers are those of a frame: `frames` has their table.
"""

import zlib
from typing import List, NamedTuple, Sequence, Tuple

import numpy as np

from ..errors import EncodingError, UsageError
from .frames import COLUMNS, FIELDS, NOT_HEARD, TURN, RobotFrame, frame_from, frame_steps, range_code

KEPT = ("x", "y", "heading", "linear", "angular", "flags", "gripper")
"""The fields of a frame that are columns, in order, behind the column of times."""
PLACES = [[field.name for field in FIELDS].index(name) for name in KEPT]
MOST_MS = 2 ** 31 - 1

TimedFrame = Tuple[float, RobotFrame]
"""The time since the start of the recording (s), and the frame of this time. Its stamp and age are not kept."""


class RobotColumns(NamedTuple):
    """The columns of one robot, read: its number, and its frames in order of time."""

    robot: int
    frames: List[TimedFrame]


def columns(robot: int, rows: Sequence[TimedFrame]) -> bytes:
    """Return the binary message with the frames of one robot.

    A frame with fewer sonar ranges than others gets "not heard" for those that it lacks.

    Args:
        robot: the number of the robot, 0 to 65535.
        rows: the frames, in order of time.

    Raises:
        EncodingError: a value does not fit its field, or a time is negative or later than 24 days.
    """
    if not 0 <= robot < 65536:
        raise EncodingError("robot is %r; legal: 0 to 65535" % robot)
    sonar = max((len(frame.sonar) for _, frame in rows), default=0)
    table = []
    for time, frame in rows:
        steps = frame_steps(frame._replace(stamp=0, age=0.0))
        if not 0 <= time <= MOST_MS / 1000:
            raise EncodingError("the time of a frame is %r; legal: 0 to %d s" % (time, MOST_MS // 1000))
        codes = list(map(range_code, frame.sonar))
        table.append([round(time * 1000), *(steps[place] for place in PLACES),
                      *codes, *[NOT_HEARD] * (sonar - len(codes))])
    numbers: "np.ndarray[object, object]" = np.array(table, np.int64).reshape(len(table), 1 + len(KEPT) + sonar)
    heading = numbers[:, 1 + KEPT.index("heading")]
    # The shortest way from each heading to the next.
    heading[1:] = heading[:1] + np.cumsum((np.diff(heading) + TURN // 2) % TURN - TURN // 2)
    differences = np.diff(numbers, axis=0, prepend=np.zeros((1, numbers.shape[1]), np.int64))
    packed = zlib.compress(differences.astype("<i4").T.tobytes(), 9)
    return COLUMNS + robot.to_bytes(2, "little") + packed


def read_columns(message: bytes, rows: int, sonar: int) -> RobotColumns:
    """Return what columns() has written.

    Args:
        message: the binary message.
        rows: the number of frames, as the entry in ``recording`` says.
        sonar: the number of sonar ranges in each frame.

    Raises:
        UsageError: the message is of another kind, damaged, or of another size.
    """
    if message[:1] != COLUMNS or len(message) < 3:
        raise UsageError("this message does not begin with 2, the kind of columns, but with %r" % message[:1])
    width = 1 + len(KEPT) + sonar
    try:
        data = zlib.decompress(message[3:])
    except zlib.error as error:
        raise UsageError("the columns are damaged: %s" % error) from error
    if len(data) != 4 * rows * width:
        raise UsageError("the columns have %d bytes; %d rows with %d sonar ranges need %d"
                         % (len(data), rows, sonar, 4 * rows * width))
    robot = int.from_bytes(message[1:3], "little")
    differences = np.frombuffer(data, "<i4").reshape(width, rows)
    table = np.cumsum(differences, axis=1, dtype=np.int64).astype(np.int32).T.tolist()
    frames = []
    for time_ms, *numbers in table:
        steps = [0] * len(FIELDS)
        for place, number in zip(PLACES, numbers):
            steps[place] = number
        steps[0] = robot
        frames.append((time_ms / 1000, frame_from(steps, numbers[len(KEPT):])))
    return RobotColumns(robot, frames)

"""The protocol of Canon's cameras VC-C4 and VC-C50i: turns bytes into commands and answers, and back. No I/O, no clock.

`framing` shows a command and its answer byte by byte. ::

    encode_camera_command("GO_TO", 800, -267) --> bytes                   to the camera
    bytes --CameraDecoder--> frame --decode_camera_command--> CameraOrder   in the camera
    bytes --CameraDecoder--> frame --decode_answer--> CameraAnswer          from the camera

==================  =============================================================
``framing``         where commands and answers begin and end
``commands``        the tables of all commands, their values, and their answers
``answers``         errors, the status, and how answers are read and written
``units``           angles, zoom and speeds: units and limits; the two models
==================  =============================================================

All facts are those of part 1 of the camera and arm sheet.
"""

from .answers import (AnswerKind, CameraAnswer, CameraStatus, answer_values, decode_answer, encode_answer,
                      encode_error)
from .commands import CAMERA_COMMANDS, CameraCommand, CameraOrder, decode_camera_command, encode_camera_command
from .framing import (ANSWER_BEGIN, COMMAND_BEGIN, END, LONGEST_FRAME, SHORTEST_ANSWER, CameraCounts, CameraDecoder)
from .units import (CAMERA_MODELS, COUNT_DEG, TELE_DEG, WIDE_DEG, ZOOM_MOST, CameraModel, count_of, degrees_of,
                    field_of_view)

__all__ = [
    "ANSWER_BEGIN", "COMMAND_BEGIN", "END", "LONGEST_FRAME", "SHORTEST_ANSWER", "CameraCounts", "CameraDecoder",
    "CAMERA_COMMANDS", "CameraCommand", "CameraOrder", "decode_camera_command", "encode_camera_command",
    "AnswerKind", "CameraAnswer", "CameraStatus", "answer_values", "decode_answer", "encode_answer",
    "encode_error",
    "CAMERA_MODELS", "COUNT_DEG", "TELE_DEG", "WIDE_DEG", "ZOOM_MOST", "CameraModel", "count_of", "degrees_of",
    "field_of_view",
]

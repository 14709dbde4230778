"""Records of lines, played: ``played_robot`` says what a recorded robot said, ``played_client`` what a recorded client
said.
"""

from .played_client import compare, play_client
from .played_robot import PlayedRobot

__all__ = ["PlayedRobot", "compare", "play_client"]

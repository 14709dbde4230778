"""Playback of recordings of lines: ``played_robot`` sends what a recorded robot sent, and ``played_client`` sends what
recorded clients sent.
"""

from .played_client import compare, play_client
from .played_robot import PlayedRobot

__all__ = ["PlayedRobot", "compare", "play_client"]

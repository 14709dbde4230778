"""Who sends a command: one that `rosbag play` publishes must not move a robot."""

from time import monotonic
from typing import Any, Callable, Dict, Optional, Tuple

from ..ros_node import is_offered
from .notices import Watch

MASTER_TIMEOUT = 0.3
"""Seconds, at most, in which the master must say who sent a command. If it does not, it is not asked again for as long.
"""


def is_player(node: str) -> bool:
    """Whether a node has the name of a `rosbag play` that nobody has renamed: play_<time>, in whatever namespace."""
    return node.rpartition("/")[2].startswith("play_")


class Senders:
    """Tells players of bags from other senders.

    Args:
        watch: knows how old a velocity may become.

    Attributes:
        known: of senders that are not players: by topic and name of the node, the connection over which it sends.
    """

    def __init__(self, watch: Watch) -> None:
        self.known: Dict[Tuple[str, str], Any] = {}
        self._players: Dict[Tuple[str, str], Any] = {}
        self._watch = watch
        self._ask_again_at = 0.0    # when the master may be asked again, after it did not answer

    def why_not(self, message: Any, topic: str, stops: Callable[[Any], bool]) -> Dict[str, str]:
        """The warning that a message on a topic is not obeyed, and why. Empty when the message is obeyed.

        A message from a player of bags is not obeyed. A message whose sender may be a player is obeyed only if it
        ``stops`` and does nothing else.
        """
        connection = getattr(message, "_connection_header", None)
        node = (connection or {}).get("callerid", "")
        replayed = self._plays_a_bag(topic, node, connection)
        if replayed:
            return {"replay " + topic:
                    "%s refused: it is played back from a bag; set the parameter accept_replay to obey it" % topic}
        if replayed is None and not stops(message):
            return {"unknown " + topic:
                    "%s refused: the ROS master does not say in time whether %s plays a bag" % (topic, node)}
        return {}

    def _plays_a_bag(self, topic: str, node: str, connection: Any) -> Optional[bool]:
        """Whether a node is a `rosbag play`, whatever its name: a player offers a service that no other node has. None
        when the master does not say it in time.

        No command waits longer for the master than half of cmd_vel_timeout. When it does not answer, it is not asked
        for a while, so that the commands behind do not wait either. For a new connection the master is asked again: a
        player may have the name of a program that was there before.
        """
        for senders, answer in ((self.known, False), (self._players, True)):
            if (topic, node) in senders and senders[topic, node] is connection:
                return answer
        if is_player(node):
            return True
        asked_at, timeout = monotonic(), min(MASTER_TIMEOUT, self._watch.cmd_vel_timeout / 2)
        if asked_at < self._ask_again_at:
            return None
        offered = is_offered(node + "/pause_playback", timeout)
        if offered is not None:
            (self._players if offered else self.known)[topic, node] = connection
        if offered is None or monotonic() - asked_at > timeout:
            self._ask_again_at = monotonic() + timeout
            return None
        return offered

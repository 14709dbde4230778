"""Finds out which node sent a command, because the driver refuses commands that `rosbag play` publishes."""

from time import monotonic
from typing import Any, Callable, Dict, Optional, Tuple

from ..ros_node import is_offered, is_player, sender_of
from .notices import Watch

MASTER_TIMEOUT = 0.3
"""The time-out (s) of a request to the ROS master. After a time-out, no request is sent for the same time."""


class Senders:
    """Finds out whether the sender of a message is a bag player (`rosbag play`).

    Args:
        watch: the object that holds the current cmd_vel_timeout.

    Attributes:
        known: the senders that are not bag players: from (topic, node name) to the connection of the sender.
    """

    def __init__(self, watch: Watch) -> None:
        self.known: Dict[Tuple[str, str], Any] = {}
        self._players: Dict[Tuple[str, str], Any] = {}
        self._watch = watch
        self._ask_again_at = 0.0    # when the master may be asked again, after it did not answer

    def why_not(self, message: Any, topic: str, stops: Callable[[Any], bool]) -> Dict[str, str]:
        """Return why a message must not be obeyed, as a warning by kind. Empty when the message may be obeyed.

        A message from a bag player is never obeyed. When the ROS master does not answer whether the sender is a bag
        player, a message is obeyed only if it just stops the robot.

        Args:
            message: the message that was received.
            topic: the name of its topic.
            stops: a function that returns whether a message just stops the robot.
        """
        node = sender_of(message)
        replayed = self._plays_a_bag(topic, node, getattr(message, "_connection_header", None))
        if replayed:
            return {"replay " + topic:
                    "%s refused: it is played back from a bag; set the parameter accept_replay to obey it" % topic}
        if replayed is None and not stops(message):
            return {"unknown " + topic:
                    "%s refused: the ROS master does not say in time whether %s plays a bag" % (topic, node)}
        return {}

    def _plays_a_bag(self, topic: str, node: str, connection: Any) -> Optional[bool]:
        """Return whether a node is a bag player. None when the ROS master does not answer in time.

        A bag player has the default name of `rosbag play`, or offers its service pause_playback. To find this service,
        this method sends a request to the master once for each connection, because a new connection can come from
        another program with the same name.

        A command waits for the master at most half of cmd_vel_timeout. After a time-out, no request is sent for a
        while, so that the next commands do not wait too.
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

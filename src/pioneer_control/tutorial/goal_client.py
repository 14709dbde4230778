"""A client of actionlib that misses nothing of its goal."""

import threading
from typing import Any

import actionlib


class GoalClient(actionlib.SimpleActionClient):  # type: ignore[misc]  # actionlib has no types
    """actionlib's client, but for one thing: it hears of a goal only once it has noted which goal it is.

    An action server may answer before that. actionlib then logs "a goal handle that we're not tracking" as an error,
    and drops the answer: of a goal that was refused or reached at once it never hears the end.
    """

    def __init__(self, *arguments: Any):
        self._sending = threading.Lock()
        super().__init__(*arguments)

    def send_goal(self, *arguments: Any, **more: Any) -> None:
        """Send a goal. For the arguments see actionlib."""
        with self._sending:
            super().send_goal(*arguments, **more)

    def _handle_transition(self, handle: Any) -> None:
        with self._sending:     # wait until `send_goal` has returned
            pass
        super()._handle_transition(handle)

"""The client of goals hears of its goal also when the server answers before `send_goal` has returned."""

import threading
import types

import actionlib
import pytest
from actionlib_msgs.msg import GoalStatus

from pioneer_control.tutorial.goal_client import GoalClient

PATIENCE = 20.0


class Handle:
    """A goal that has ended: it was refused."""

    def get_comm_state(self):
        return actionlib.CommState.DONE

    def get_goal_status(self):
        return GoalStatus.REJECTED

    def get_result(self):
        return None


class QuickServer:
    """An action client whose server answers while the goal is being sent."""

    ns = "move_base"

    def __init__(self, *arguments):
        self.answers = []

    def send_goal(self, goal, transition, feedback):
        handle = Handle()
        answer = threading.Thread(target=transition, args=(handle,), daemon=True)
        self.answers.append(answer)
        answer.start()
        answer.join(0.2)        # the client of this package waits here; actionlib's has answered already
        return handle


@pytest.fixture
def client_of(monkeypatch):
    def made(kind):
        monkeypatch.setattr(actionlib.simple_action_client, "ActionClient", QuickServer)
        return kind("move_base", types.SimpleNamespace)
    return made


@pytest.mark.parametrize("kind, heard", [(GoalClient, True), (actionlib.SimpleActionClient, False)])
def test_a_goal_that_ends_at_once_is_heard(client_of, kind, heard):
    client = client_of(kind)
    client.simple_state = actionlib.SimpleGoalState.PENDING
    client.send_goal("there")
    client.action_client.answers[0].join(PATIENCE)
    assert (client.simple_state == actionlib.SimpleGoalState.DONE) is heard
    assert client.gh is not None

"""A program names its goal; and it hears how an exploration ended, though one message alone tells it."""

import threading
import types

import pytest
import rospy
from geometry_msgs.msg import Pose2D
from std_msgs.msg import Header
from std_srvs.srv import SetBoolResponse

from pioneer_control.errors import UsageError
from pioneer_control.msg import Navigation, Places
from pioneer_control.tutorial import travel
from pioneer_control.tutorial.pioneer import Pioneer

BEGIN = 1000
PATIENCE = 5.0      # s


class Client:
    """A stand-in for the client of the action."""

    gh, simple_state = None, travel.actionlib.SimpleGoalState.DONE

    def __init__(self, *arguments):
        self.cancelled = 0
        self.action_client = self

    def wait_for_server(self, timeout):
        return True

    def cancel_all_goals(self):
        self.cancelled += 1


@pytest.fixture
def journey(monkeypatch):
    """Return a Travel without a master, at a time that stands, whose navigation explores when it is asked to."""
    monkeypatch.setattr(rospy, "Subscriber", lambda *arguments, **more: None)
    monkeypatch.setattr(rospy.Time, "now", lambda: rospy.Time(BEGIN))
    monkeypatch.setattr(rospy, "get_time", lambda: float(BEGIN))
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(travel, "GoalClient", Client)
    made = travel.Travel("r/")
    monkeypatch.setattr(made, "_call", lambda *arguments: SetBoolResponse(True, ""))
    made._hear(Places(), Places)
    hear(made, "idle", -1)
    return made


def hear(journey, state, second, reason=""):
    journey._hear(Navigation(header=Header(stamp=rospy.Time(BEGIN + second)), state=state, reason=reason), Navigation)


def explored(journey, *said):
    """Return what `explore` returns when navigation says this meanwhile: state and reason, one a second."""
    answers = []
    program = threading.Thread(target=lambda: answers.append(journey.explore()), daemon=True)
    program.start()
    while journey._exploration is None:
        pass
    for second, (state, reason) in enumerate(said, 1):
        hear(journey, state, second, reason)
    program.join(PATIENCE)
    assert answers, "it never returns"
    return answers[0]


@pytest.mark.parametrize("state, reason, answer", [
    ("reached", "explored, home again", ""), ("failed", "explored, not home: no way", "explored, not home: no way"),
    ("idle", "no goal", "somebody ended it"),
])
def test_an_end_that_one_message_tells_is_heard(journey, state, reason, answer):
    assert explored(journey, ("waiting", ""), ("driving", ""), (state, reason), ("idle", "no goal")) == answer
    assert journey._client.cancelled == 0


@pytest.mark.parametrize("why_not, end", [("", "explored, home again"), ("no way", "not explored: no way")])
def test_a_program_says_that_it_explores(monkeypatch, why_not, end):
    lines = []
    for name in ("loginfo", "logwarn"):
        monkeypatch.setattr(rospy, name, lambda text, *values: lines.append(text % values))
    robot = types.SimpleNamespace(navigation=types.SimpleNamespace(explore=lambda: why_not))
    assert Pioneer.explore(robot) is not bool(why_not)
    assert lines[0].startswith("explore: ") and lines[1:] == [end]


def test_what_navigation_said_before_it_explored_is_no_end(journey):
    assert explored(journey, ("idle", ""), ("failed", "of before"), ("waiting", ""), ("reached", "")) == ""


def test_the_end_of_the_program_ends_exploring_by_a_topic(journey):
    ended = []

    def program():
        with pytest.raises(rospy.ROSInterruptException):
            journey.explore()
        ended.append(True)

    thread = threading.Thread(target=program, daemon=True)
    thread.start()
    while journey._exploration is None:
        pass
    hear(journey, "driving", 1)
    journey.end()
    thread.join(PATIENCE)
    assert ended and journey._client.cancelled > 0


@pytest.mark.parametrize("goal, said", [
    (("roof", None, None), "no place is named 'roof' on the map; known: 'kitchen', 'sofa'"),
    (("sofa", 1.57, None), "y is 1.57: .* go_to\\('sofa', heading=1.57\\)"),
    ((3.0, None, None), "y is None: go_to needs the name of a place, or x and y in metres"),
])
def test_a_goal_that_makes_no_sense_is_told_with_what_does(journey, goal, said):
    journey._hear(Places(names=["kitchen", "sofa"], poses=[Pose2D(1.0, 2.0, 0.5), Pose2D()]), Places)
    with pytest.raises(UsageError, match=said):
        journey.goal_of(*goal)


def test_a_place_by_name_takes_another_heading(journey):
    journey._hear(Places(names=["kitchen"], poses=[Pose2D(1.0, 2.0, 0.5)]), Places)
    assert journey.goal_of("kitchen", None, None) == (1.0, 2.0, 0.5)
    assert journey.goal_of("kitchen", None, 1.5) == (1.0, 2.0, 1.5)

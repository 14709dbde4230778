"""What the program for driving by hand publishes, for keys and for a gamepad that is a stand-in. Without a master."""

import io

import pytest
import rospy

from pioneer_control.msg import Helm, MotorState
from pioneer_control.teleop import node as node_module
from pioneer_control.teleop.hand import FIRST_PRESS, REPEATED, STAND, Limit, Wish
from pioneer_control.teleop.node import PERIOD, HandDrive, parser, state_line


class Talk:
    """Takes note of what would be published."""

    robot = "pioneer"

    def __init__(self):
        self.told, self.news, self.listened = [], {}, True

    def drive(self, linear, angular):
        self.told.append((round(linear, 3), round(angular, 3)))

    def act(self, action):
        self.told.append(action)
        return "it is done"

    def take(self):
        told, self.told = self.told, []
        return told


class Pad:
    """A stand-in for a Gamepad: what its hand wants, and which buttons are pressed next."""

    name = "a pad"

    def __init__(self):
        self.hand, self.wanted, self.actions, self.gone, self.closed = self, STAND, [], False, False

    def wish(self, now):
        return self.wanted

    def let_go(self):
        self.wanted = STAND

    def read(self, now):
        if self.gone:
            raise OSError(19, "No such device")
        return self.actions

    def close(self):
        self.closed = True


@pytest.fixture
def talk():
    return Talk()


@pytest.fixture
def drive(talk):
    return HandDrive(talk, None, 0.2, io.StringIO())


def test_nothing_is_published_until_a_key_drives(drive, talk):
    """A zero takes the helm from programs, too."""
    for tick in range(50):
        drive.step(0.1 * tick)
    assert talk.take() == [] and not drive.drove


def test_a_press_drives_at_once_goes_on_at_its_pace_and_ends_with_one_zero(drive, talk):
    drive.press("w", 0.0)
    times = [0.01 * tick for tick in range(100)]
    published = []
    for time in times:
        drive.step(time)
        published += [(time, velocity) for velocity in talk.take()]
    moving = [time for time, velocity in published if velocity == (0.2, 0.0)]
    assert moving[0] == 0.0 and max(b - a for a, b in zip(moving, moving[1:])) <= PERIOD + 0.011
    assert [velocity for _, velocity in published][-1] == (0.0, 0.0)
    assert published[-1][0] == pytest.approx(FIRST_PRESS, abs=0.011) and len(moving) == len(published) - 1
    assert drive.drove


@pytest.mark.parametrize("key", ["x", "space", "m", "+", "\x1b[15~"])
def test_any_other_key_lets_go(drive, talk, key):
    drive.press("w", 0.0)
    drive.step(0.0)
    drive.press(key, 0.05)
    drive.step(0.05)
    assert (0.0, 0.0) in talk.take() and drive.wish(0.05) == STAND


def test_a_stop_is_said_with_a_zero_before_anything_else(drive, talk):
    drive.press("w", 0.0)
    drive.step(0.0)
    talk.take()
    drive.press("space", 0.1)
    assert talk.take() == [(0.0, 0.0), "stop"]


@pytest.mark.parametrize("key, action", [("m", "motors_on"), ("n", "motors_off"), ("u", "unlock"), ("o", "open"),
                                         ("c", "close"), ("l", "up"), ("k", "down"), ("r", "release")])
def test_each_key_does_its_one_thing(drive, talk, key, action):
    drive.press(key, 0.0)
    assert talk.take() == [action]


def test_only_m_switches_motors_on():
    assert [key for key, action in node_module.ACTIONS.items() if action.name == "motors_on"] == ["m"]


def test_the_limit_is_raised_by_a_key(drive, talk):
    drive.press("+", 0.0)
    drive.press("w", 0.1)
    drive.step(0.1)
    assert talk.take() == [(0.3, 0.0)]


def test_a_heap_of_old_keys_drives_nothing(drive, talk):
    drive._hear_terminal(b"wwwwwwwww", 0.0)
    drive.step(0.0)
    assert talk.take() == []


def test_a_gamepad_drives_while_its_hand_wants_it_and_keys_go_before(talk):
    pad = Pad()
    drive = HandDrive(talk, pad, 0.2, io.StringIO())
    pad.wanted = Wish(0.5, 0.0)
    drive.step(0.0)
    drive.press("s", 0.1)
    drive.step(0.1)
    pad.wanted = STAND
    drive.step(0.1 + FIRST_PRESS)
    assert talk.take() == [(0.1, 0.0), (-0.2, 0.0), (0.0, 0.0)]


def test_a_gamepad_that_is_pulled_out_means_stand(talk, caplog):
    pad = Pad()
    drive = HandDrive(talk, pad, 0.2, io.StringIO())
    pad.wanted = Wish(1.0, 0.0)
    drive.step(0.0)
    pad.gone = True
    drive._hear_gamepad(0.05)
    drive.step(0.05)
    assert talk.take() == [(0.2, 0.0), (0.0, 0.0)] and pad.closed


def test_a_stop_lets_go_of_the_gamepads_deadman_too(talk):
    pad = Pad()
    drive = HandDrive(talk, pad, 0.2, io.StringIO())
    pad.wanted, pad.actions = Wish(1.0, 0.0), ["stop"]
    drive.step(0.0)
    drive._hear_gamepad(0.1)
    drive.step(0.1)
    assert talk.take() == [(0.2, 0.0), (0.0, 0.0), "stop"]


@pytest.mark.parametrize("helm, said", [
    (Helm(locks=["stop_all"]), "LOCKED by stop_all (u unlocks)"), (Helm(commander="cmd_vel"), "cmd_vel commands"),
    (Helm(programs_locked_out=True), "you have the helm")])
def test_the_line_says_who_commands_and_what_to_press(talk, helm, said):
    talk.news = {Helm: helm, MotorState: MotorState(0)}
    line = state_line(talk, Limit(), STAND, "a remark")
    assert said in line and "motors off (m)" in line and "at most 0.2 m/s" in line and line.endswith("a remark")


def test_the_line_says_when_no_driver_listens(talk, monkeypatch):
    monkeypatch.setattr(node_module.rospy, "resolve_name", lambda name: "/" + name)
    talk.listened = False
    assert state_line(talk, Limit(), STAND) == "nobody listens on /pioneer/teleop/cmd_vel: does the driver run?"


@pytest.mark.parametrize("arguments", [["--speed", "fast"], ["a", "b"], ["--speeed", "1"]])
def test_a_wrong_argument_is_refused(arguments):
    with pytest.raises(SystemExit):
        parser().parse_args(arguments)


def test_a_repetition_is_shorter_than_a_press():
    assert REPEATED < FIRST_PRESS


class Closed:
    """A publisher whose topic was closed."""

    def publish(self, message):
        raise rospy.ROSException("publish() to a closed topic")


def test_a_topic_that_closes_while_ros_shuts_down_is_no_error(monkeypatch):
    with pytest.raises(rospy.ROSException):
        node_module.publish(Closed(), True)
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: True)
    node_module.publish(Closed(), True)

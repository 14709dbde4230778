"""What a SteeredRobot lets through to its robot, what it refuses, and what it sends by itself."""

import threading
from types import SimpleNamespace

import pytest

from pioneer_control.client import HelmState, SteeredRobot, VelocityInput
from pioneer_control.errors import LinkLostError, RefusedError, UsageError
from pioneer_control.p2os import GripperCommand

PROGRAM, PERSON = "cmd_vel", "teleop/cmd_vel"
INPUTS = {PROGRAM: VelocityInput(10, 0.6), PERSON: VelocityInput(100, 0.5, True)}
OBSTACLES = {"stop_all": "the lock is set", PERSON: "a person has the helm"}
OPEN = [(GripperCommand.OPEN, None)]


class FakeRobot:
    """Takes note of what it is told."""

    def __init__(self):
        self.url = "fake"
        self.told = []
        self.state = SimpleNamespace(motors_enabled=True)
        self.identity = SimpleNamespace(has_gripper=True)
        self.error = None

    def __getattr__(self, name):
        def told(*values):
            self.told.append((name, *values))
            if self.error is not None and name != "stop":
                raise self.error
        return told

    def take(self):
        """Return what it was told since the last call."""
        told, self.told = self.told, []
        return told


@pytest.fixture
def robot():
    return FakeRobot()


@pytest.fixture
def now(monkeypatch):
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr("pioneer_control.client.steered_robot.monotonic", lambda: clock.now)
    return clock


@pytest.fixture
def steered(robot, now):
    return SteeredRobot(robot, INPUTS, OBSTACLES)


def test_a_robot_in_lockstep_is_refused(robot):
    robot.url = "socket://localhost:8101?lockstep"
    with pytest.raises(UsageError, match="lockstep is for one program .*: leave out [?]lockstep"):
        SteeredRobot(robot, INPUTS, OBSTACLES)


def test_a_velocity_is_good_for_the_time_out_of_its_input(steered, robot):
    steered.set_velocity(PROGRAM, 0.2, 0.1)
    steered.set_wheel_velocities(PROGRAM, 0.2, 0.3)
    steered.set_velocity(PERSON, 0.4, 0.0)
    assert robot.take() == [("set_velocity", 0.2, 0.1, 0.6), ("set_wheel_velocities", 0.2, 0.3, 0.6),
                            ("set_velocity", 0.4, 0.0, 0.5)]
    steered.set_timeout(PERSON, 0.2)
    steered.set_velocity(PERSON, 0.4, 0.0)
    assert robot.take() == [("set_velocity", 0.4, 0.0, 0.2)]


@pytest.mark.parametrize("command", [
    lambda steered: steered.set_velocity(PROGRAM, 0.2, 0.0), lambda steered: steered.set_velocity(PROGRAM, 0.0, 0.0),
    lambda steered: steered.set_wheel_velocities(PROGRAM, 0.2, 0.2),
    lambda steered: steered.move_gripper(PROGRAM, OPEN, False)])
def test_beside_a_person_no_program_reaches_the_robot(steered, robot, now, command):
    steered.set_velocity(PERSON, 0.0, 0.0)
    now.now += 60.0
    robot.take()
    with pytest.raises(RefusedError, match="refused: a person has the helm"):
        command(steered)
    assert robot.take() == []
    steered.release()
    robot.take()
    command(steered)
    assert robot.take() != []


def test_under_a_lock_only_standing_still_reaches_the_robot(steered, robot):
    steered.lock("stop_all")
    robot.take()
    for name in INPUTS:
        for command in (lambda name: steered.set_velocity(name, 0.2, 0.0),
                        lambda name: steered.set_velocity(name, 0.0, 0.1),
                        lambda name: steered.set_wheel_velocities(name, 0.0, 0.1),
                        lambda name: steered.move_gripper(name, OPEN, False),
                        lambda name: steered.take(name),
                        lambda name: steered.request_motors(True)):
            with pytest.raises(RefusedError, match="refused: the lock is set"):
                command(name)
    assert robot.take() == []
    steered.set_velocity(PERSON, 0.0, 0.0)
    steered.move_gripper(PROGRAM, [(GripperCommand.STOP, None)], True)
    steered.request_motors(False)
    assert [each[0] for each in robot.take()] == ["set_velocity", "gripper", "request_motors"]


@pytest.mark.parametrize("motors, gripper, sent", [
    (True, True, ["stop", "gripper"]), (True, False, ["stop"]), (False, False, ["stop", "request_motors"])])
def test_a_lock_stops_all_that_moves_or_will(steered, robot, motors, gripper, sent):
    """A request for motors on may still be open while they are off: switching them off takes it back."""
    robot.state.motors_enabled, robot.identity.has_gripper = motors, gripper
    steered.lock("stop_all")
    told = robot.take()
    assert [each[0] for each in told] == sent
    assert ("request_motors", True) not in told
    steered.lock("stop_all")        # said again: it only stops again
    assert robot.take() == [("stop",)]


def test_a_lock_is_set_without_a_link_too(steered, robot):
    robot.error = LinkLostError("cable")
    steered.lock("stop_all")
    assert steered.state().locks == ("stop_all",)


def test_a_lock_is_set_before_the_robot_was_ever_there(steered, robot):
    robot.state = robot.identity = None
    steered.lock("stop_all")
    assert robot.take() == [("stop",)]


def test_unlocking_moves_nothing(steered, robot):
    steered.set_velocity(PROGRAM, 0.2, 0.0)
    steered.lock("stop_all")
    robot.take()
    steered.unlock("stop_all")
    assert robot.take() == []
    assert steered.state() == HelmState()


def test_a_person_who_moves_the_gripper_stops_what_a_program_drives(steered, robot):
    steered.set_velocity(PROGRAM, 0.2, 0.0)
    robot.take()
    steered.move_gripper(PERSON, OPEN, False)
    assert robot.take() == [("stop",), ("gripper", GripperCommand.OPEN, None)]
    assert steered.state().holder == PERSON
    steered.move_gripper(PERSON, OPEN, False)
    assert robot.take() == [("gripper", GripperCommand.OPEN, None)]


def test_a_program_that_moves_the_gripper_stops_nothing_and_commands_nothing(steered, robot):
    steered.move_gripper(PROGRAM, OPEN, False)
    assert robot.take() == [("gripper", GripperCommand.OPEN, None)]
    assert steered.state() == HelmState()


def test_taking_the_helm_stops_a_program_but_not_the_same_person(steered, robot):
    steered.set_velocity(PROGRAM, 0.2, 0.0)
    robot.take()
    steered.take(PERSON, "Ada")
    assert robot.take() == [("stop",)] and steered.state() == HelmState(PERSON, "Ada", PERSON)
    steered.set_velocity(PERSON, 0.2, 0.0, "Ada")
    robot.take()
    steered.take(PERSON, "Ada")
    assert robot.take() == []


def test_a_release_stops_the_robot_first_and_says_whose_helm_it_was(steered, robot):
    assert steered.release() == "" and robot.take() == []
    steered.set_velocity(PERSON, 0.2, 0.0)
    robot.take()
    assert steered.release() == PERSON
    assert robot.take() == [("stop",)]


def test_a_person_takes_over_even_when_there_is_no_link(steered, robot):
    robot.error = LinkLostError("cable")
    with pytest.raises(LinkLostError):
        steered.set_velocity(PERSON, 0.2, 0.0)
    assert steered.state().holder == PERSON


def test_changes_are_told_once_and_silence_when_somebody_looks(robot, now):
    told = []
    steered = SteeredRobot(robot, INPUTS, OBSTACLES, lambda: told.append(now.now))
    for _ in range(3):
        steered.set_velocity(PROGRAM, 0.2, 0.0, "/wander")
    assert len(told) == 1 and steered.changes_in() == pytest.approx(0.6)
    now.now += 0.7
    steered.look()
    steered.look()
    assert len(told) == 2 and steered.state() == HelmState()


def test_no_velocity_of_a_program_follows_that_of_a_person_who_took_over(robot):
    """Two threads command as fast as they can. From the person's first velocity on, only his arrive."""
    steered, ended = SteeredRobot(robot, INPUTS, OBSTACLES), threading.Event()

    def wander():
        while not ended.is_set():
            try:
                steered.set_velocity(PROGRAM, 0.5, 0.0)
            except RefusedError:
                pass

    threads = [threading.Thread(target=wander) for _ in range(3)]
    for thread in threads:
        thread.start()
    while not robot.told:
        pass
    for _ in range(100):
        steered.set_velocity(PERSON, 0.1, 0.0)
    ended.set()
    for thread in threads:
        thread.join()
    speeds = [each[1] for each in robot.told]
    assert 0.5 in speeds and set(speeds[speeds.index(0.1):]) == {0.1}

"""Who commands the robot, seen from topics: programs, a person, the lock, and bags. The whole driver runs, in simulated
time, and the robot is a simulated one.
"""

import pytest
from bottle import Bottle
from geometry_msgs.msg import Twist, Vector3
from std_msgs.msg import Bool

from pioneer_control.driver.requests import Requests
from pioneer_control.msg import GripperState, GripState, LiftState, MotorState, WheelVelocities

OPEN_PADDLES = GripperState(grip=GripState(state=1), lift=LiftState())


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: Bottle(monkeypatch, script, **options)


def twist(linear, angular=0.0):
    return Twist(Vector3(linear, 0, 0), Vector3(0, 0, angular))


def motors_on(bottle):
    bottle.send("cmd_motor_state", MotorState(1))
    yield 0.5


def drive(bottle, seconds, **speeds):
    """Publish velocities at 10 Hz: program=0.3, person=0.1, wheels=0.2; None publishes nothing."""
    topics = {"program": ("cmd_vel", twist), "person": ("teleop/cmd_vel", twist),
              "wheels": ("cmd_wheels", lambda speed: WheelVelocities(speed, speed))}
    for _ in range(round(seconds / 0.1)):
        for who, speed in speeds.items():
            topic, message = topics[who]
            bottle.send(topic, message(speed))
        yield 0.1


def speed(bottle):
    return round(bottle.firmware.velocity[0], 2)


def test_a_person_takes_over_and_keeps_the_helm_until_it_is_released(run):
    def script(bottle):
        bottle.speeds = []
        yield from motors_on(bottle)
        for speeds in (dict(program=0.3), dict(program=0.3, person=0.1), dict(program=0.3), dict(wheels=0.3)):
            yield from drive(bottle, 3.0, **speeds)
            bottle.speeds.append(speed(bottle))
        bottle.answer = bottle.call("teleop/release")
        yield from drive(bottle, 3.0, program=0.3)
        bottle.speeds.append(speed(bottle))

    bottle = run(script)
    assert bottle.speeds == [0.3, 0.1, 0.0, 0.0, 0.3]
    assert bottle.answer.success and bottle.says("the helm is released")
    assert "cmd_vel refused: a person has the helm (teleop/cmd_vel)" in bottle.warned
    assert "rosservice call /teleop/release" in bottle.warned


def test_a_person_takes_over_within_the_message(run):
    """The robot hears the person's velocity at once, and none of the program's after it."""
    def script(bottle):
        yield from motors_on(bottle)
        yield from drive(bottle, 1.0, program=0.3)
        bottle.send("teleop/cmd_vel", twist(-0.1))
        bottle.taken_at = bottle.now - bottle.ready_at
        yield from drive(bottle, 1.0, program=0.3)

    bottle = run(script)
    after = [(time, value) for time, value in bottle.commands("VEL") if time >= bottle.taken_at]
    assert after[0] == (bottle.taken_at, -100)
    assert {value for _, value in after} <= {-100, 0}


def test_a_zero_of_a_person_stops_a_program_for_good(run):
    def script(bottle):
        yield from motors_on(bottle)
        yield from drive(bottle, 1.0, program=0.3)
        bottle.send("teleop/cmd_vel", twist(0.0))
        yield from drive(bottle, 3.0, program=0.3)
        bottle.left = speed(bottle)

    assert run(script).left == 0.0


def test_a_velocity_of_a_person_that_makes_no_sense_takes_nothing_over(run):
    def script(bottle):
        yield from motors_on(bottle)
        bottle.send("teleop/cmd_vel", twist(float("nan")))
        yield from drive(bottle, 3.0, program=0.3)
        bottle.left = speed(bottle)

    bottle = run(script)
    assert bottle.left == 0.3
    assert "teleop/cmd_vel refused: linear.x is nan" in bottle.warned


def test_a_release_that_nobody_needed_says_so(run):
    def script(bottle):
        bottle.answer = bottle.call("teleop/release")
        yield 0.1

    assert run(script).answer.message == "nobody has the helm; programs may command"


def test_a_person_keeps_the_helm_through_a_reconnect(run):
    def script(bottle):
        yield from motors_on(bottle)
        bottle.send("teleop/cmd_vel", twist(0.1))
        bottle.unplug(for_a_moment=True)
        yield 4.0
        yield from motors_on(bottle)
        yield from drive(bottle, 2.0, program=0.3)
        bottle.left = speed(bottle)

    bottle = run(script)
    assert bottle.robot.link.reconnects == 1 and bottle.left == 0.0


def test_while_a_person_has_the_helm_the_gripper_is_theirs(run):
    def script(bottle):
        bottle.send("teleop/cmd_vel", twist(0.0))
        bottle.send("gripper_control", OPEN_PADDLES)
        yield 0.2
        bottle.refused = len(bottle.commands("GRIPPER"))
        bottle.send("teleop/gripper_control", OPEN_PADDLES)
        yield 0.2

    bottle = run(script)
    assert bottle.refused == 0 and len(bottle.commands("GRIPPER")) == 1
    assert "gripper command refused: a person has the helm" in bottle.warned


def test_under_the_lock_nothing_moves_and_motors_stay_off(run):
    def script(bottle):
        yield from motors_on(bottle)
        yield from drive(bottle, 2.0, program=0.3)
        bottle.send("stop_all", Bool(True))
        bottle.locked_at = bottle.now - bottle.ready_at
        yield from drive(bottle, 3.0, program=0.3, person=0.1, wheels=0.2)
        bottle.still = speed(bottle)
        bottle.send("cmd_motor_state", MotorState(0))
        yield 0.5
        bottle.send("cmd_motor_state", MotorState(1))
        bottle.send("gripper_control", OPEN_PADDLES)
        yield 1.0
        bottle.motors = bottle.firmware.motors_enabled
        bottle.unlocked_at = bottle.now - bottle.ready_at
        bottle.send("stop_all", Bool(False))
        yield 2.0
        bottle.still_still = speed(bottle)
        yield from motors_on(bottle)
        yield from drive(bottle, 2.0, program=0.3)
        bottle.drives = speed(bottle)

    bottle = run(script)
    assert (bottle.still, bottle.motors, bottle.still_still, bottle.drives) == (0.0, False, 0.0, 0.3)
    locked = [(name, value) for time, name, value in bottle.heard
              if bottle.locked_at <= time - bottle.ready_at < bottle.unlocked_at]
    assert locked[0][0] == "STOP"
    assert {each for each in locked if each[0] in ("VEL", "RVEL", "VEL2", "ENABLE")} <= {
        ("VEL", 0), ("RVEL", 0), ("ENABLE", 0)}
    assert [value for name, value in locked if name == "GRIPPER"] == [15]       # halt
    for what in ("cmd_vel", "cmd_wheels", "teleop/cmd_vel", "motors on", "gripper command"):
        assert what + " refused: stop_all is set" in bottle.warned
    assert "stop_all is set by /somebody" in bottle.warned and bottle.says("stop_all is taken away by /somebody")


@pytest.mark.parametrize("service", ["set_motors", "enable_motors"])
def test_a_service_for_motors_answers_with_the_lock(run, service):
    def script(bottle):
        bottle.send("stop_all", Bool(True))
        try:
            bottle.answer = bottle.call(service, *([True] if service == "set_motors" else [])).message
        except Exception as error:      # the type of this service has no text
            bottle.answer = str(error)
        yield 1.0

    bottle = run(script)
    assert "motors on refused: stop_all is set" in bottle.answer and not bottle.firmware.motors_enabled


def test_a_request_for_motors_that_is_still_open_is_taken_back_by_the_lock(run):
    def script(bottle):
        bottle.deaf_to.add("ENABLE")
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.1
        bottle.send("stop_all", Bool(True))
        bottle.deaf_to.clear()
        yield 3.0
        bottle.motors = bottle.firmware.motors_enabled

    bottle = run(script)
    assert not bottle.motors


def test_motors_at_the_start_stay_off_under_the_lock(run, monkeypatch):
    """The latched lock arrives when the driver subscribes: before the robot is found."""
    subscribe = Requests.__init__

    def subscribe_and_hear(self, *arguments):
        subscribe(self, *arguments)
        self._steered.lock("stop_all")

    def script(bottle):
        yield 1.0
        bottle.motors = bottle.firmware.motors_enabled

    assert run(script, enable_motors_on_start=True).motors
    monkeypatch.setattr(Requests, "__init__", subscribe_and_hear)
    bottle = run(script, enable_motors_on_start=True)
    assert not bottle.motors and "motors on refused: stop_all is set" in bottle.warned


# Bags

@pytest.mark.parametrize("topic, message", [("teleop/cmd_vel", twist(0.3)), ("teleop/cmd_vel", twist(0.0)),
                                            ("teleop/gripper_control", OPEN_PADDLES)])
def test_a_bag_is_no_person(run, topic, message):
    def script(bottle):
        yield from motors_on(bottle)
        bottle._caller = "/play_1795"
        bottle.send(topic, message)
        yield 1.0
        bottle._caller = "/somebody"
        bottle.connect_anew()
        yield from drive(bottle, 2.0, program=0.3)
        bottle.drives = speed(bottle)

    bottle = run(script)
    assert "%s refused: it is played back from a bag" % topic in bottle.warned
    assert bottle.drives == 0.3 and bottle.commands("GRIPPER") == []


def test_a_bag_does_not_unlock_but_its_lock_counts(run):
    def script(bottle):
        yield from motors_on(bottle)
        bottle._caller = "/play_1795"
        bottle.send("stop_all", Bool(True))
        yield 0.1
        bottle.send("stop_all", Bool(False))
        bottle._caller = "/somebody"
        yield from drive(bottle, 2.0, program=0.3)
        bottle.locked = speed(bottle)
        bottle.connect_anew()
        bottle.send("stop_all", Bool(False))
        yield from drive(bottle, 2.0, program=0.3)
        bottle.free = speed(bottle)

    bottle = run(script)
    assert (bottle.locked, bottle.free) == (0.0, 0.3)
    assert "stop_all refused: it is played back from a bag" in bottle.warned


def test_a_bag_unlocks_where_replay_is_accepted(run):
    def script(bottle):
        yield from motors_on(bottle)
        bottle.send("stop_all", Bool(True))
        bottle.send("stop_all", Bool(False))
        yield from drive(bottle, 2.0, program=0.3)
        bottle.free = speed(bottle)

    assert run(script, caller="/play_1795", accept_replay=True).free == 0.3

"""The arm's topics, services and parameters, with the whole driver and a simulated robot and arm, in simulated time."""

import dataclasses
import functools
import math

import pytest
import rospy
from bottle import Bottle
from geometry_msgs.msg import Twist, Vector3
from std_msgs.msg import Bool, Float64
from test_driver_requests import ask
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from pioneer_control.arm.joints import JOINT_NAMES
from pioneer_control.client.line_devices import LineDevices
from pioneer_control.driver import node as node_module
from pioneer_control.driver.arm_topics import ARM_SERVICES, ARM_TOPICS
from pioneer_control.driver.parameters import DriverParameters
from pioneer_control.errors import UsageError
from pioneer_control.msg import MotorState, Sounds
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.world import load_world

BASE, SHOULDER, ELBOW, ROLL, WRIST, GRIPPER = JOINT_NAMES
NAN, INF = math.nan, math.inf
MOVES = {"ARM_POWER", "ARM_POS", "ARM_HOME", "ARM_PARK"}
HOME = [130, 37, 235, 130, 183, 180]


class ArmBottle(Bottle):
    """``arm`` is the simulated arm. ``layout`` and ``linked`` are numbers of it. Its end is tested with a master."""

    def __init__(self, monkeypatch, script, fitted=True, layout="A", linked=True, **given):
        numbers = standard_numbers()
        numbers = dataclasses.replace(numbers, arm=dataclasses.replace(
            numbers.arm, layout=layout, linked_at_power_on=linked))
        firmware = Firmware(find_model("p3dx-sh"), load_world("empty"), noise=0.0, arm=fitted, numbers=numbers)
        monkeypatch.setattr(LineDevices, "start", lambda devices: None)     # wait() ticks it
        monkeypatch.setattr(node_module.DriverNode, "_rest_devices", lambda node: None)
        given.setdefault("use_arm", True)
        super().__init__(monkeypatch, script, firmware, **given)

    @property
    def arm(self):
        return self.firmware.hardware.arm

    @property
    def session(self):
        return self.node._device_topics["Arm"].session

    @property
    def ticks(self):
        return [servo.position for servo in self.arm.servos] if self.arm is not None else []

    def wait(self, seconds):
        for _ in range(round(seconds / 0.02)):
            with self.node._devices.using() as now:
                if now >= self.session.due:
                    self.session.tick(now)
            yield 0.02
        self.seen = self.ticks      # at the end the robot closes the session, and the arm parks

    def power(self):
        """Wait for the arm, and switch its servo power on."""
        yield from self.wait(1.0)
        answer = yield from self.asked("arm/power", True)
        assert answer == (True, "servo power is on"), answer

    def asked(self, service, *values):
        """Call a service that waits for the arm."""
        call = ask(self, service, *values)
        while True:
            try:
                pause = next(call)
            except StopIteration as end:
                return end.value
            yield from self.wait(pause)

    def move(self, seconds=0.0, **positions):
        """Publish a motion with one point; joints are named by the middle of their names."""
        self.send("arm_controller/command", motion(["arm_%s_joint" % name for name in positions],
                                                   (list(positions.values()), seconds)))

    @property
    def joints(self):
        """The newest joint_states of the arm, by name."""
        message = [each for each in self.messages("joint_states") if BASE in each.name][-1]
        return dict(zip(message.name, message.position))

    @property
    def state(self):
        return self.messages("arm/state")[-1]


def motion(names, *points):
    return JointTrajectory(joint_names=names, points=[
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration.from_sec(seconds))
        for positions, seconds in points])


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: ArmBottle(monkeypatch, script, **options)


def names_heard(bottle):
    return {name for _, name, _ in bottle.heard}


# -- what is there

def test_without_the_parameter_there_is_nothing_of_an_arm(run):
    def script(bottle):
        yield 1.0

    bottle = run(script, use_arm=False)
    assert not any("arm" in name for name in [*bottle.published, *bottle._topics, *bottle._services])
    assert not any(name.startswith("ARM") for name in names_heard(bottle))


@pytest.mark.parametrize("layout", ["A", "M"])
def test_it_is_found_shown_and_not_moved(run, layout):
    def script(bottle):
        yield from bottle.wait(3.0)

    bottle = run(script, layout=layout)
    assert not MOVES & names_heard(bottle) and bottle.ticks == HOME and not bottle.arm.powered
    assert list(bottle.joints) == list(JOINT_NAMES)
    assert bottle.joints[SHOULDER] == pytest.approx(math.radians(79.714), abs=1e-4)
    assert bottle.joints[GRIPPER] == pytest.approx(0.054 * 110 / 130)
    state = bottle.state
    assert (state.condition, state.powered, state.version, state.layout) == ("off", False, "1.7", layout)
    assert state.joints == list(JOINT_NAMES) and state.lower[0] == pytest.approx(-math.pi / 2)
    assert state.upper[5] == pytest.approx(0.054) and state.speed[0] == pytest.approx(0.4987, abs=1e-3)
    assert bottle.says("found an arm, version 1.7, with 6 joints")
    conditions = [message.condition for message in bottle.messages("arm/state")]
    assert conditions[-2:] == ["looking", "off"] and len(conditions) <= 3       # only changes
    told = [message.header.stamp.to_sec() for message in bottle.messages("joint_states") if BASE in message.name]
    assert told == sorted(set(told)) and len(told) > 20


def test_wheels_and_arm_share_joint_states(run):
    def script(bottle):
        yield from bottle.wait(2.0)

    names = {tuple(message.name) for message in run(script).messages("joint_states")}
    assert names == {("left_wheel_joint", "right_wheel_joint"), JOINT_NAMES}


def test_a_robot_without_an_arm_says_so(run):
    def script(bottle):
        yield from bottle.wait(1.0)
        bottle.answer = yield from bottle.asked("arm/power", True)

    bottle = run(script, fitted=False)
    assert bottle.answer == (False, "power on refused: the robot reports that it has no arm")
    assert bottle.state.condition == "none" and "there is no arm" in bottle.warned
    assert not any(BASE in message.name for message in bottle.messages("joint_states"))


# -- commands and their effects

def test_every_service_has_its_effect(run):
    def script(bottle):
        yield from bottle.power()
        bottle.on = bottle.arm.powered
        bottle.move(base=0.5, shoulder=0.5, elbow=-0.8)
        yield from bottle.wait(3.0)
        bottle.away = bottle.ticks
        bottle.answers = [(yield from bottle.asked("arm/home"))]
        bottle.at_home = bottle.ticks, bottle.arm.powered
        bottle.move(base=-1.0)
        yield from bottle.wait(1.0)
        bottle.answers.append((yield from bottle.asked("arm/stop")))
        yield from bottle.wait(0.2)
        bottle.stopped = bottle.ticks[0]
        yield from bottle.wait(1.0)
        bottle.still = bottle.ticks[0], bottle.arm.powered
        bottle.answers.append((yield from bottle.asked("arm/park")))
        bottle.parked = bottle.ticks, bottle.arm.powered
        bottle.answers.append((yield from bottle.asked("arm/init")))
        bottle.answers.append((yield from bottle.asked("arm/power", True)))
        bottle.answers.append((yield from bottle.asked("arm/power", False)))

    bottle = run(script)
    assert bottle.on and bottle.away == [163, 97, 183, 130, 183, 180] and bottle.at_home == (HOME, True)
    assert 63 < bottle.stopped < 130 and bottle.still == (bottle.stopped, True)
    assert bottle.parked == (HOME, False) and bottle.arm.drops == 0 and ("ARM_POWER", 0) not in bottle.heard
    assert bottle.answers == [
        (True, "the arm is home"), (True, "the arm was told to stop"), (True, "the arm is parked, without servo power"),
        (True, "the arm is connected"), (True, "servo power is on"), (True, "the arm is parked, without servo power")]
    assert "keep clear: the arm gets servo power and jumps to its home position" in bottle.warned
    conditions = [message.condition for message in bottle.messages("arm/state")]
    assert {"looking", "off", "powering on", "on", "moving", "homing", "parking", "resetting"} <= set(conditions)


def test_a_motion_of_all_joints_is_seen_on_joint_states(run):
    wanted = {"base": 0.6, "shoulder": 0.3, "elbow": -0.4, "roll": 0.7, "wrist": 0.2, "gripper": 0.01}

    def script(bottle):
        yield from bottle.power()
        bottle.move(3.0, **wanted)
        yield from bottle.wait(4.5)

    bottle = run(script)
    for name, value in wanted.items():
        assert bottle.joints["arm_%s_joint" % name] == pytest.approx(value, abs=0.008), name
    ways = [dict(zip(message.name, message.position))[BASE] for message in bottle.messages("joint_states")
            if BASE in message.name]
    assert ways == sorted(ways) and len(set(ways)) > 10


def test_several_points_and_the_gripper(run):
    def script(bottle):
        yield from bottle.power()
        bottle.send("arm_controller/command", motion([BASE], ([0.4], 1.5), ([-0.4], 4.0)))
        yield from bottle.wait(1.7)
        bottle.first = bottle.ticks[0]
        yield from bottle.wait(3.0)
        bottle.send("arm_gripper/command", Float64(0.0))
        yield from bottle.wait(4.0)

    bottle = run(script)
    assert bottle.first == pytest.approx(157, abs=4) and bottle.seen[0] == 103 and bottle.seen[5] == 70
    assert bottle.joints[GRIPPER] == 0.0


def test_no_points_are_a_stop(run):
    def script(bottle):
        yield from bottle.power()
        bottle.move(base=1.0)
        yield from bottle.wait(1.0)
        bottle.send("arm_controller/command", JointTrajectory())
        yield from bottle.wait(0.3)
        bottle.stopped = bottle.ticks
        yield from bottle.wait(1.0)

    bottle = run(script)
    assert bottle.seen == bottle.stopped and 130 < bottle.stopped[0] < 196


REFUSED = [
    (motion(["gripper"], ([0.1], 1.0)), "no joint 'gripper'; there are arm_base_joint, "),
    (motion([BASE], ([NAN], 1.0)), "arm_base_joint of point 0 is nan"),
    (motion([BASE], ([INF], 1.0)), "arm_base_joint of point 0 is inf"),
    (motion([BASE], ([1.7], 1.0)), "may be -1.571 to 1.571 rad"),
    (motion([BASE], ([0.1], 1.0), ([0.2], 1.0)), "not after that of the point before"),
    (motion([BASE, WRIST], ([0.1], 1.0)), "point 0 has 1 positions for 2 joints"),
    (motion([], ([], 1.0)), "no joint is named"),
    (motion([SHOULDER], ([-1.0], 9.0)), "one step is at most 1.60 rad"),
    (motion([BASE], ([0.1], -1.0)), "time_from_start of point 0 is -1.0 s"),
    (Float64(NAN), "arm_gripper_joint of point 0 is nan"),
    (Float64(0.2), "may be 0.000 to 0.054 m"),
]


def test_what_makes_no_sense_is_refused_with_the_reason(run):
    def script(bottle):
        yield from bottle.power()
        topics = bottle.node._device_topics["Arm"]
        bottle.reasons = []
        for message, _ in REFUSED:
            with pytest.raises(UsageError) as caught:
                (topics.grip if isinstance(message, Float64) else topics.follow)("topic", message, "/somebody")
            bottle.reasons.append(str(caught.value))
        bottle.send("arm_controller/command", REFUSED[0][0])
        bottle.send("arm_gripper/command", Float64(INF))
        yield from bottle.wait(0.5)

    bottle = run(script)
    assert bottle.seen == HOME and "ARM_POS" not in names_heard(bottle)
    for text, (_, reason) in zip(bottle.reasons, REFUSED):
        assert text.startswith("topic refused: ") and reason in text
    assert "arm_controller/command refused: there is no joint 'gripper'" in bottle.warned
    assert "arm_gripper/command refused: arm_gripper_joint of point 0 is inf" in bottle.warned


def test_a_service_that_fails_says_why(run):
    def script(bottle):
        yield from bottle.wait(1.0)
        bottle.deaf_to = {"ARM_POWER"}
        bottle.answer = yield from bottle.asked("arm/power", True)

    assert run(script).answer == (
        False, "arm/power failed: the arm did not confirm within 2 s that its servo power is on")


def test_nothing_moves_without_power_and_the_answer_says_how_to_get_it(run):
    def script(bottle):
        yield from bottle.wait(1.0)
        bottle.move(base=0.5)
        bottle.send("arm_gripper/command", Float64(0.0))
        bottle.home = yield from bottle.asked("arm/home")

    bottle = run(script)
    assert bottle.home == (False, "home refused: the servos have no power. Keep clear of the arm, then: arm/power true")
    assert not MOVES & names_heard(bottle) and "motion refused: the servos have no power" in bottle.warned


def test_what_a_bag_player_publishes_is_refused_but_for_a_stop(run):
    def script(bottle):
        yield from bottle.power()
        bottle.move(base=0.5)
        bottle.send("arm_gripper/command", Float64(0.0))
        yield from bottle.wait(1.0)

    bottle = run(script, caller="/play_1234567")
    assert bottle.seen == HOME and bottle.warned.count("played back from a bag") == 2
    assert [topic.stops(JointTrajectory()) for topic in ARM_TOPICS] == [True, False]


# -- emergencies and failures

def test_stop_all_stops_the_arm_and_refuses_what_would_move_it(run):
    def script(bottle):
        yield from bottle.power()
        bottle.move(base=1.5)
        yield from bottle.wait(1.0)
        bottle.send("stop_all", Bool(True))
        yield from bottle.wait(0.3)
        bottle.stopped = bottle.ticks
        bottle.move(base=-0.5)
        bottle.answers = []
        for service, *values in (["arm/home"], ["arm/park"], ["arm/power", True], ["arm/power", False], ["arm/init"]):
            bottle.answers.append((yield from bottle.asked(service, *values)))
        yield from bottle.wait(1.0)
        bottle.still = bottle.ticks, bottle.arm.powered
        bottle.stop = yield from bottle.asked("arm/stop")
        bottle.send("stop_all", Bool(False))
        yield from bottle.wait(1.0)
        bottle.after = bottle.ticks
        bottle.move(base=0.0)
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert 130 < bottle.stopped[0] < 200 and bottle.still == (bottle.stopped, True) and bottle.after == bottle.stopped
    assert all(not worked and text.endswith("refused: stop_all is set") for worked, text in bottle.answers)
    assert bottle.stop[0] and "arm_controller/command refused: stop_all is set" in bottle.warned
    assert bottle.seen[0] == 130


def test_a_lock_that_is_set_meanwhile_is_never_missed(run):
    """Locks are looked for while the arm cannot get another command: who sets one later, stops what was begun."""
    def script(bottle):
        yield from bottle.power()
        bottle.looked = []
        topics = bottle.node._device_topics["Arm"]
        topics._locks = lambda: bottle.looked.append(bottle.node._devices._turn._is_owned()) or ()
        bottle.move(base=0.1)
        bottle.send("arm_gripper/command", Float64(0.01))
        yield from bottle.asked("arm/park")

    assert run(script).looked == [True] * 3


def test_the_stop_button_of_the_robot_stops_the_arm(run):
    def script(bottle):
        yield from bottle.power()
        bottle.move(base=1.5)
        yield from bottle.wait(1.0)
        bottle.firmware.press_stop_button(True)
        yield from bottle.wait(0.5)
        bottle.stopped = bottle.ticks
        bottle.answer = yield from bottle.asked("arm/home")
        yield from bottle.wait(1.0)
        bottle.still = bottle.ticks, bottle.arm.powered
        bottle.firmware.press_stop_button(False)
        yield from bottle.wait(0.5)
        bottle.move(base=0.0)
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert 130 < bottle.stopped[0] < 200 and bottle.still == (bottle.stopped, True) and bottle.seen[0] == 130
    assert bottle.answer == (False, "home refused: the STOP button of the robot is pressed")


def test_an_arm_that_falls_silent_is_told_and_shown_no_more(run):
    def script(bottle):
        yield from bottle.power()
        bottle.firmware.request("arm", 0)       # it forgets that it was asked
        bottle.deaf_to = {"ARM_STATUS"}
        yield from bottle.wait(2.0)
        bottle.silent = bottle.state.condition
        bottle.finding = bottle.node._device_topics["Arm"].finding()
        bottle.answer = yield from bottle.asked("arm/home")
        bottle.shown = len([message for message in bottle.messages("joint_states") if BASE in message.name])
        yield from bottle.wait(1.0)
        bottle.shown_later = len([message for message in bottle.messages("joint_states") if BASE in message.name])
        bottle.deaf_to = set()
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert bottle.silent == "silent" and bottle.shown == bottle.shown_later and bottle.finding.level == 2
    assert bottle.answer == (False, "home refused: the arm has stopped sending its status")
    assert bottle.state.condition == "on" and "it is told to stop" in bottle.warned


def test_a_cut_cable_forgets_the_arm_and_the_next_link_finds_it_without_moving_it(run):
    def script(bottle):
        yield from bottle.power()
        bottle.unplug(for_a_moment=True)
        yield 0.5
        bottle.gone = bottle.state.condition
        bottle.moves = len([name for _, name, _ in bottle.heard if name in MOVES])
        yield 3.0
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert "no link" in [message.condition for message in bottle.messages("arm/state")]
    assert len([name for _, name, _ in bottle.heard if name in MOVES]) == bottle.moves
    assert bottle.state.condition in ("on", "off", "homing")


def test_how_it_is_is_a_task_of_the_diagnostics(run):
    def script(bottle):
        yield from bottle.power()
        bottle.well = bottle.node._device_topics["Arm"].finding()
        bottle.arm.switch(False)
        yield from bottle.wait(0.5)
        bottle.off = bottle.node._device_topics["Arm"].finding()

    bottle = run(script)
    assert (bottle.well.level, bottle.well.message) == (0, "servo power is on")
    assert bottle.well.values["Servo power"] == "True" and bottle.well.values["Parks by itself in"].endswith(" s")
    assert bottle.off.level == 1 and "its controller does not answer" in bottle.off.message


# -- parameters

ARM_EFFECTS = {
    "use_arm": (False, lambda bottle: any(name.startswith("ARM") for name in names_heard(bottle)), True, False),
    "arm_layout": ("M", lambda bottle: bottle.state.condition == "none", False, True),
    "arm_signs": ((-1, 1, 1, 1, 1), lambda bottle: bottle.seen[0], 163, 97),
    "arm_offsets": ((0.1, 0.0, 0.0, 0.0, 0.0), lambda bottle: bottle.seen[0], 163, 157),
    "arm_lower": ((0.3, -3.0, -3.0, -3.0, -3.0), lambda bottle: round(bottle.state.lower[0], 2), -1.57, 0.3),
    "arm_upper": ((0.3, 3.0, 3.0, 3.0, 3.0), lambda bottle: bottle.seen[0], 163, 130),
    "arm_max_speeds": ((0.2, 0.5, 0.5, 0.5, 0.5), lambda bottle: bottle.arm.servos[0].speed_ms, 30, 75),
    "arm_gripper_speed": (0.01, lambda bottle: bottle.arm.servos[5].speed_ms, 21, 42),
    "arm_max_step": (0.4, lambda bottle: bottle.seen[0], 163, 130),
    "arm_autopark": (60, lambda bottle: [value for _, value in bottle.commands("ARM_AUTOPARK")][-1], 600, 60),
    "arm_grippark": (90, lambda bottle: [value for _, value in bottle.commands("ARM_GRIPPARK")][-1], 300, 90),
}
"""A value of each parameter, how its effect is seen, and what is seen without it and with it."""


@functools.lru_cache(maxsize=None)
def run_with(*given):
    """Return a run in which the arm moves, with these parameters."""
    def script(bottle):
        if not {"use_arm", "arm_layout"}.isdisjoint(name for name, _ in given):     # then it cannot be moved
            yield 1.0
            return
        yield from bottle.power()
        bottle.move(base=0.5)
        yield from bottle.wait(1.6)

    with pytest.MonkeyPatch.context() as monkeypatch:
        return ArmBottle(monkeypatch, script, layout="A", **{name: list(value) if isinstance(value, tuple) else value
                                                             for name, value in given})


@pytest.mark.parametrize("name", ARM_EFFECTS)
def test_a_parameter_of_the_arm_has_its_effect(name):
    value, see, usual, changed = ARM_EFFECTS[name]
    assert see(run_with()) == usual
    assert see(run_with((name, value))) == changed


def test_every_parameter_of_the_arm_is_in_the_table():
    assert set(ARM_EFFECTS) == {entry.name for entry in dataclasses.fields(DriverParameters) if "arm" in entry.name}


def test_services_are_those_of_the_sheet():
    assert [service.name for service in ARM_SERVICES] == ["arm/power", "arm/home", "arm/park", "arm/stop", "arm/init"]


def test_a_stop_reaches_the_arm_also_when_many_commands_wait_for_the_line(run):
    def script(bottle):
        yield from bottle.power()
        bottle.move(base=0.5)
        yield from bottle.wait(0.3)
        for _ in range(40):
            bottle.send("say", Sounds([0.1] * 20, [60] * 20))
        assert bottle.call("arm/stop").success
        told_at = bottle.now
        yield from bottle.wait(3.0)
        bottle.stops = [time - told_at for time, name, _ in bottle.heard if name == "ARM_STOP"]

    bottle = run(script)
    assert "say refused" in bottle.warned or "too slow for so many notes" in bottle.warned
    assert len(bottle.stops) == 1 and bottle.stops[0] < 0.4


# -- the end

def test_a_device_that_fails_at_the_end_keeps_the_robot_from_no_stop(monkeypatch):
    def script(bottle):
        bottle.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for _ in range(5):
            bottle.send("cmd_vel", Twist(Vector3(0.3, 0, 0), Vector3()))
            yield 0.1

        def fail():
            raise RuntimeError("a device with a mistake")

        bottle.node._rest_devices = fail

    bottle = Bottle(monkeypatch, script)
    assert bottle.says("a device with a mistake") and bottle.commands("CLOSE") and bottle.exit_code == 0
    assert not bottle.firmware.motors_enabled and bottle.velocities[-1][1][0] == 0.0

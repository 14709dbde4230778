"""Every parameter of the driver has an effect.

The whole driver runs once with the default of a parameter and once with another value. The two runs differ in nothing
else, so a difference in what ROS or the robot sees is the effect of the parameter. A live parameter is changed in a
third run while the driver runs, and must have the same effect.
"""

import dataclasses
import functools
import pathlib
import time
from typing import Any, Callable, Mapping, NamedTuple, Optional

import pytest
from bottle import Bottle
from test_driver_ptz import PTZ_EFFECTS
from geometry_msgs.msg import Twist, Vector3
from test_driver_arm import ARM_EFFECTS

from pioneer_control.driver.parameters import LIVE, DriverParameters
from pioneer_control.driver.reconfigure import encode
from pioneer_control.msg import MotorState
from pioneer_control.p2os import FrameDecoder, decode_command

PATIENCE = 30.0                                 # s, real ones; nothing takes that long
IDLE = 2.5                                      # s before anything is commanded
DRIVES = ((5.0, 0.0), (0.0, 9.0))               # m/s, rad/s: more than is allowed, straight on and then in place
BY_HAND = 0.04                                  # m/s, that a person drives at the end: so slow that no effect sees it
DRIVE, REST = 2.0, 4.0                          # s of each drive, and of the pause behind it
GOODBYE = ["ENABLE", "CLOSE"]                   # what a driver still tells the robot when ROS has ended
WIDE_MODEL = str(pathlib.Path(__file__).resolve().parents[2] / "data" / "wide-model.yaml")


class Run(Bottle):
    """The run in which the effects are measured. The robot stands, and the motors are switched on. Then, twice, it
    drives, and after that gets no commands. At the end a person drives it, and falls silent.
    """

    def __init__(self, live: Optional[Mapping[str, Any]] = None, **options):
        self.live = live
        self.silent_from = 0.0      # s since the robot was ready, as all times here
        self.by_hand_until = 0.0
        self.bauds = None           # of the port, of the robot
        self.motors_unasked = None
        self.settings = None
        with pytest.MonkeyPatch.context() as monkeypatch:
            super().__init__(monkeypatch, Run.script, **options)

    def script(self):
        """Do what the docstring of the class says."""
        if self.live:
            self.call("~set_parameters", encode(self.live))
        yield IDLE
        self.motors_unasked = self.firmware.motors_enabled
        self.send("cmd_motor_state", MotorState(1))
        yield 0.5
        for linear, angular in DRIVES:
            for _ in range(round(DRIVE / 0.1)):
                self.silent_from = self.now - self.ready_at
                self.send("cmd_vel", Twist(Vector3(linear, 0, 0), Vector3(0, 0, angular)))
                yield 0.1
            yield REST
        for _ in range(5):
            self.by_hand_until = self.now - self.ready_at
            self.send("teleop/cmd_vel", Twist(Vector3(BY_HAND, 0, 0), Vector3()))
            yield 0.1
        yield 1.0
        hardware = self.firmware.hardware       # it forgets all that at CLOSE
        wheels, bumpers = hardware.wheels, hardware.bumpers
        self.settings = dict(
            self.firmware.settings, rev_count=wheels.rev_count, ticks_per_mm=wheels.ticks_per_mm,
            sonar_cycle=hardware.sonar.cycle_us,
            bump_stall=(bumpers.front_stalls, bumpers.rear_stalls))
        self.bauds = self.line.baud, self.firmware.baud

    # What can be seen in it

    @property
    def width(self) -> float:
        """Return the width of the robot's outline (m)."""
        return 2 * max(point.y for point in self.messages("robot_info")[-1].footprint.points)

    @property
    def sonars_heard(self):
        """Return the numbers of the sonars that were heard in the end."""
        return [number for number, distance in enumerate(self.messages("sonar")[-1].ranges) if distance]

    @property
    def frames(self):
        """Return the frames of a pose."""
        pose = self.messages("pose")[-1]
        return pose.header.frame_id, pose.child_frame_id

    def greatest(self, command: str) -> int:
        """Return the greatest value of this command that the robot got."""
        return max(value for _, value in self.commands(command))

    def reaction(self) -> float:
        """Return the time (s) from the last velocity to the stop."""
        return self._until_stop(self.silent_from)

    def reaction_by_hand(self) -> float:
        """Return the time (s) from the last velocity of the person to the stop."""
        return self._until_stop(self.by_hand_until)

    def _until_stop(self, begin: float) -> float:
        return round(next(time for time, _ in self.commands("STOP") if time > begin) - begin, 1)

    def rise(self, axis: int) -> float:
        """Return how fast the robot speeds up, in m/s^2 (axis 0) or rad/s^2 (axis 1)."""
        rates = [(time, velocity[axis]) for time, velocity in self.velocities]
        begin, end = (next((time, rate) for time, rate in rates if rate > least) for least in (0.05, 0.25))
        return round((end[1] - begin[1]) / (end[0] - begin[0]), 1)

    def fall(self, axis: int) -> float:
        """Return how fast the robot slows down, in m/s^2 (axis 0) or rad/s^2 (axis 1)."""
        rates = [(time, velocity[axis]) for time, velocity in self.velocities]
        begin, end = (max((time, rate) for time, rate in rates if rate > least) for least in (0.25, 0.05))
        return round((begin[1] - end[1]) / (end[0] - begin[0]), 1)

    def signs_of_life(self) -> int:
        """Return the number of STOP and PULSE packets that the robot gets while nothing is commanded."""
        return sum(0.5 < time < IDLE - 0.1 for time, _ in self.commands("STOP", "PULSE"))

    def tells_of_the_wire(self) -> bool:
        """Return whether `wire` has all that the robot heard, up to the end of ROS. A separate thread publishes `wire`.
        """
        heard, ends = [name for _, name, _ in self.heard], time.monotonic() + PATIENCE

        def said():
            data = b"".join(message.data for message in self.messages("wire") if message.to_robot)
            return [decode_command(frame).name for frame in FrameDecoder().feed(data)]

        while self.node._wire and len(said()) < len(heard) - len(GOODBYE) and time.monotonic() < ends:
            time.sleep(0.01)
        return heard == said() + GOODBYE

    def variances(self, part: str, moving: bool):
        """Return the first variance of pose or twist in messages of a robot that moves or stands."""
        found = {getattr(message, part).covariance[0] for message in self.messages("pose")
                 if bool(message.twist.twist.linear.x or message.twist.twist.angular.z) == moving}
        variance, = found
        return variance


class Effect(NamedTuple):
    """A row: a value other than the default, a function that finds its effect in a Run, and what this function returns
    with the default and with the other value.
    """

    value: Any
    see: Callable[[Run], Any]
    usual: Any
    changed: Any
    options: Mapping[str, Any] = {}
    """of both runs"""


def setting(name: str, usual: Any, value: int) -> Effect:
    """Return the row of a setting that the robot keeps."""
    return Effect(value, lambda run: run.settings[name], usual, value)


def variances(part: str, moving: bool, usual: float) -> Effect:
    """Return the row of a covariance parameter. The test looks at the first number of its diagonal."""
    return Effect([0.25] * 6, lambda run: run.variances(part, moving), usual, 0.25)


def nobody_hears_encoders(run: Run) -> None:
    """Leave the topic `encoders` without a subscriber: its packets are the answers to the questions of link_check."""
    run.listened = {"pose"}


WIDTH = 0.425                               # m, outline of a p3dx-sh with gripper

EFFECTS = {
    "port": Effect("socket://robot:1", lambda run: run.opened[0][0], "/dev/ttyUSB0", "socket://robot:1"),
    "baud": Effect(38400, lambda run: run.opened[0][1], 9600, 38400),
    "host_baud": Effect(57600, lambda run: run.bauds, (9600, 9600), (57600, 57600)),
    "model": Effect("p3at-sh", lambda run: round(run.width, 3), WIDTH, 0.505),
    "models_file": Effect(WIDE_MODEL, lambda run: round(run.width, 3), WIDTH, 0.48),
    "gripper": Effect("false", lambda run: "gripper_state" in run.published, True, False),
    "beam_polarity": Effect(0, lambda run: run.messages("gripper_state")[-1].grip.inner_beam, False, True),
    "pulse": Effect(0.1, lambda run: run.signs_of_life() > 10, False, True),
    "link_check": Effect(False, lambda run: len(run.commands("ENCODER")) > 3, True, False,
                         {"before": nobody_hears_encoders}),
    "use_sonar": Effect(False, lambda run: len(run.messages("sonar")) > 0, True, False),
    "laser_power": Effect(True, lambda run: [value for _, value in run.commands("TIMER", "POWER_LRF")], [], [0x0B01]),
    "max_xspeed": Effect(0.3, lambda run: run.greatest("VEL"), 500, 300),
    "max_yawspeed": Effect(0.5, lambda run: run.greatest("RVEL"), 99, 28),
    "cmd_vel_timeout": Effect(1.2, Run.reaction, 0.6, 1.2),
    "teleop_timeout": Effect(0.3, Run.reaction_by_hand, 0.5, 0.3),
    "max_xaccel": Effect(0.5, lambda run: run.rise(0), 0.3, 0.5),
    "max_xdecel": Effect(-0.5, lambda run: run.fall(0), 0.3, 0.5),
    "max_yawaccel": Effect(1.0, lambda run: run.rise(1), 1.7, 1.0),
    "max_yawdecel": Effect(-1.0, lambda run: run.fall(1), 1.7, 1.0),
    "rot_kp": setting("rotation_kp", 40, 55),
    "rot_kv": setting("rotation_kv", 20, 55),
    "rot_ki": setting("rotation_ki", 0, 55),
    "trans_kp": setting("translation_kp", 40, 55),
    "trans_kv": setting("translation_kv", 30, 55),
    "trans_ki": setting("translation_ki", 0, 55),
    "bumpstall": Effect(2, lambda run: run.settings["bump_stall"], (True, True), (False, True)),
    "ticks_mm": setting("ticks_per_mm", 128, 140),
    "drift_factor": setting("drift_factor", 0, -40),
    "rev_count": setting("rev_count", 16570, 17000),
    "sonar_cycle": Effect(0.1, lambda run: run.settings["sonar_cycle"], 40000, 100000),
    "sonar_polling": Effect([2, 5, 2, 9], lambda run: run.sonars_heard, list(range(16)), [2, 5, 9]),
    "enable_motors_on_start": Effect(True, lambda run: run.motors_unasked, False, True),
    "accept_replay": Effect(
        True, lambda run: max(velocity[0] for _, velocity in run.velocities) > 0.1, False, True,
        {"caller": "/play_1795"}),
    "odom_frame_id": Effect("here", lambda run: run.frames, ("odom", "base_link"), ("here", "base_link")),
    "base_link_frame_id": Effect("me", lambda run: run.frames, ("odom", "base_link"), ("odom", "me")),
    "frame_prefix": Effect("two/", lambda run: run.frames, ("odom", "base_link"), ("two/odom", "two/base_link")),
    "publish_tf": Effect(False, lambda run: "/tf" in run.published, True, False),
    "publish_wire": Effect(True, Run.tells_of_the_wire, False, True),
    "sonar_no_echo": Effect(
        "max", lambda run: max(message.range for message in run.messages("sonar_ranges")), float("inf"), 5.0),
    "pose_covariance_moving": variances("pose", True, 1e-3),
    "pose_covariance_still": variances("pose", False, 1e-3),
    "twist_covariance_moving": variances("twist", True, 1e-3),
    "twist_covariance_still": variances("twist", False, 1e-6),
}


@functools.lru_cache(maxsize=None)
def usual_run(*options) -> Run:
    """Return the run with default values of all parameters. All tests with the same options share it."""
    return Run(**dict(options))


def check_effect(name: str, effect: Effect) -> None:
    """Check that a parameter has its effect, and that the effect is not there without it."""
    assert effect.usual != effect.changed
    assert effect.see(usual_run(*effect.options.items())) == effect.usual
    assert effect.see(Run(**{name: effect.value}, **effect.options)) == effect.changed


@pytest.mark.parametrize("name, effect", EFFECTS.items(), ids=list(EFFECTS))
def test_a_parameter_has_its_effect(name, effect):
    check_effect(name, effect)


@pytest.mark.parametrize("name", LIVE)
def test_a_live_parameter_has_its_effect_while_the_driver_runs(name):
    run = Run(live={name: EFFECTS[name].value})
    assert EFFECTS[name].see(run) == EFFECTS[name].changed
    value = EFFECTS[name].value
    assert run.set_parameters == {"~" + name: abs(value) if name.endswith("decel") else value}


def test_every_parameter_has_an_effect():
    assert {*EFFECTS, *PTZ_EFFECTS, *ARM_EFFECTS} == {entry.name for entry in dataclasses.fields(DriverParameters)}


@pytest.mark.parametrize("effect", [
    Effect(0.3, lambda run: run.greatest("RVEL"), 99, 28),      # looks elsewhere
    Effect(0.3, lambda run: 500, 500, 300),                     # looks nowhere
    Effect(0.5, lambda run: run.greatest("VEL"), 500, 500),     # is the default
])
def test_an_effect_that_is_none_is_seen(effect):
    with pytest.raises(AssertionError):
        check_effect("max_xspeed", effect)

"""Faults: how they are written, when they begin and end, and what they change."""

import math

import pytest

from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.clock import NEVER_US
from pioneer_control.simulator.line.faults import KINDS, Fault, Faults, fault_of, load_faults
from pioneer_control.simulator.line.robot_link import WAYS, RobotLink
from pioneer_control.simulator.line import CameraPorts, LineSimulation
from pioneer_control.simulator.line.cameras import fit_camera
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World


@pytest.mark.parametrize("words, fault", [
    ("loss 0.1", Fault("loss", 0.1)),
    ("loss 0.1 from 10 to 20", Fault("loss", 0.1, start=10.0, end=20.0)),
    ("delay 1 way to-robot robot 2 from 1.5", Fault("delay", 1.0, "to-robot", 2, 1.5)),
    ("silence to 3", Fault("silence", end=3.0)),
    ("power from 5", Fault("power", start=5.0, end=6.0)),
    ("power from 5 to 9", Fault("power", start=5.0, end=9.0)),
    ("gyro -2.5", Fault("gyro", -2.5)),
    ("carry 1 -2.5 90 robot 2 from 3", Fault("carry", (1.0, -2.5, 90.0), None, 2, 3.0, 3.1)),
    ({"fault": "carry", "value": [1, 2, 3]}, Fault("carry", (1.0, 2.0, 3.0), end=0.1)),
    ({"fault": "transducer", "value": 3, "robot": 2, "from": 30}, Fault("transducer", 3, None, 2, 30.0)),
])
def test_words(words, fault):
    assert fault_of(words) == fault


def test_the_words_of_a_fault_are_read_back():
    for words in ("loss 0.1 way to-robot robot 2", "carry 1.5 -2 90 robot 2", "cable", "transducer 3", "gyro -2.5"):
        assert str(fault_of(words)) == words


@pytest.mark.parametrize("words, problem", [
    ("", "write a kind"),
    ("Los 0.1", "no kind 'Los'; did you mean 'loss'. there are loss, flips"),
    ("fog", "no kind 'fog'; there are"),
    ("loss", "loss needs a value: a number from 0 to 1 .share."),
    ("loss 2", "value 2 is not legal: give a number from 0 to 1 .share."),
    ("loss nan", "value nan is not legal"),
    ("loss x", "value 'x' is not legal"),
    ("carry 1 2", r"value \[1, 2\] is not legal: give 3 numbers from -1e.06 to 1e.06, as a list .m, m, deg."),
    ("carry 1 2 north", "value .* is not legal: give 3 numbers"),
    ("carry 1 2 3 4", "has no '4'"),
    ("cable 1", "cable takes no value, and 1 is one"),
    ("loss 0.1 form 10", "has no 'form'; there are fault, value, way, robot, from, to"),
    ("cable for 3", "has no '3'"),
    ("loss 0.1 from", "'from' needs a value"),
    ("loss 0.1 from 1 from 2", "'from' is there twice"),
    ("loss 0.1 from 5 to 5", "to 5 is not after from 5"),
    ("loss 0.1 from -1", "from -1 is not legal"),
    ("loss 0.1 way up", "way 'up' is not legal: give to-robot or from-robot"),
    ("cable way to-robot", "cable has no way"),
    ("loss 0.1 robot 0", "robot 0 is not legal: give a whole number from 1"),
    ("loss 0.1 robot 1.5", "robot 1.5 is not legal"),
    ("transducer 32", "value 32 is not legal"),
    ("transducer 1.5", "value 1.5 is not legal"),
    ({"fault": "loss", "value": True}, "value True is not legal"),
    ("gyro 1" + 400 * "0", "value 10000"),      # too large for a float
    ({}, "write a kind"),
    ([1], "write a kind"),
    (None, "write a kind"),
    ({"fault": ["loss"]}, "no kind"),
])
def test_mistakes_name_the_value_and_what_is_legal(words, problem):
    with pytest.raises(ParameterError, match=problem):
        fault_of(words)


def test_a_timeline(tmp_path):
    path = tmp_path / "faults.yaml"
    path.write_text("- loss 0.1 from 10 to 20\n- {fault: transducer, value: 3, robot: 2, from: 30}\n")
    assert load_faults(str(path)) == [Fault("loss", 0.1, start=10.0, end=20.0), Fault("transducer", 3, None, 2, 30.0)]


@pytest.mark.parametrize("text, problem", [
    ("- loss 0.1\n- loss 2\n", "faults.yaml, entry 2: fault 'loss 2': value 2"),
    ("loss: 1", "expected a list of faults"),
    ("- [", "does not parse"),
    ("", "expected a list of faults"), ("- 3", "entry 1: .*write a kind"),
])
def test_mistakes_in_a_timeline(tmp_path, text, problem):
    path = tmp_path / "faults.yaml"
    path.write_text(text)
    with pytest.raises(ParameterError, match=problem):
        load_faults(str(path))


def test_a_timeline_that_is_not_there():
    with pytest.raises(ParameterError, match="cannot read /nowhere.yaml"):
        load_faults("/nowhere.yaml")


class Scene:
    """Two robots, and the messages about their faults."""

    def __init__(self):
        self.links = [RobotLink(Firmware(find_model("p3dx-sh"), World("hall"), arm=True), str(number))
                      for number in range(2)]
        self.said = []
        self.faults = Faults(self.links, lambda time, sentence: self.said.append((time, sentence)))

    def add(self, words, now=0.0):
        self.faults.add(fault_of(words), round(now * 1e6))
        self.faults.step(round(now * 1e6))

    def wires(self, name):
        return [getattr(link.wires[way].errors, name) for link in self.links for way in WAYS]


def test_faults_that_are_on_and_those_to_come_are_told():
    scene = Scene()
    assert scene.faults.told(0) == []
    scene.add("stall robot 2 from 5 to 8", now=1.0)
    scene.add("loss 0.1", now=1.0)
    assert scene.faults.told(2500000) == ["loss 0.1", "stall robot 2, in 3.5 s"]
    assert scene.faults.told(6000000) == ["loss 0.1", "stall robot 2"], "due, with the next step"
    scene.faults.step(9000000)
    assert scene.faults.told(9000000) == ["loss 0.1"]


def test_a_fault_begins_and_ends_and_is_named_both_times():
    scene = Scene()
    scene.add("loss 0.1 from 10 to 20")
    assert scene.faults.next_us == 10000000 and scene.wires("loss") == [0.0] * 4
    scene.faults.step(10000000)
    assert scene.faults.next_us == 20000000 and scene.wires("loss") == [0.1] * 4
    assert scene.faults.on == [fault_of("loss 0.1 from 10 to 20")]
    scene.faults.step(20000000)
    assert scene.faults.next_us == NEVER_US and scene.wires("loss") == [0.0] * 4
    assert scene.said == [(10.0, "fault begins: loss 0.1"), (20.0, "fault ends: loss 0.1")]


def test_one_way_and_one_robot():
    scene = Scene()
    scene.add("silence way to-robot robot 2")
    assert scene.wires("silence") == [False, False, True, False]


def test_of_several_the_newest_holds_and_the_older_again_after_it():
    scene = Scene()
    scene.add("delay 1")
    scene.add("delay 2 robot 1 to 5")
    assert scene.wires("delay") == [2.0, 2.0, 1.0, 1.0]
    scene.faults.step(5000000)
    assert scene.wires("delay") == [1.0] * 4


def test_times_count_from_when_it_is_added():
    scene = Scene()
    scene.add("flips 0.1 from 1 to 2", 100.0)
    assert scene.faults.next_us == 101000000


@pytest.mark.parametrize("start, end", [(0.1, 0.3), (0.7, 1.1), (1e-6, 1e-5), (33.333333, 99.999999)])
def test_times_that_no_float_hits_are_hit(start, end):
    scene = Scene()
    scene.add("cable from %r to %r" % (start, end))
    for _ in range(2):
        scene.faults.step(scene.faults.next_us)
    assert scene.faults.next_us == NEVER_US and len(scene.said) == 2


def test_clear_ends_what_is_on_and_what_would_come():
    scene = Scene()
    for words in ("loss 0.1", "loss 0.2 from 50", "flips 0.1"):
        scene.add(words)
    assert scene.wires("loss") == scene.wires("flips") == [0.1] * 4
    assert scene.faults.clear(1000000) == 3 and scene.faults.next_us == NEVER_US and scene.faults.clear(1000000) == 0
    assert scene.wires("loss") == scene.wires("flips") == [0.0] * 4


def test_a_robot_that_is_not_there():
    with pytest.raises(ParameterError, match="there is no robot 3; there are 1 to 2"):
        Scene().add("cable robot 3")


# What each kind changes: how it is seen, before, while it is on, after.
EFFECTS = {
    "loss 0.1": (lambda link: link.wires["to-robot"].errors.loss, 0.0, 0.1),
    "flips 0.1": (lambda link: link.wires["to-robot"].errors.flips, 0.0, 0.1),
    "splits 0.1": (lambda link: link.wires["from-robot"].errors.splits, 0.0, 0.1),
    "delay 0.1": (lambda link: link.wires["to-robot"].errors.delay, 0.0, 0.1),
    "silence": (lambda link: link.wires["to-robot"].errors.silence, False, True),
    "cable": (lambda link: link.unplugged, False, True),
    "power": (lambda link: link.powered, True, False),
    "stop_button": (lambda link: link.hardware.motors.stop_button, False, True),
    "stall": (lambda link: link.hardware.stall.held, False, True),
    "battery 11.2": (lambda link: round(link.firmware.hardware.battery.voltage, 6), 13.0, 11.2),
    "transducer 3": (lambda link: link.hardware.sonar.dead, set(), {3}),
    "gyro 90": (lambda link: link.hardware.gyro.drift, 0.0, math.pi / 2),
    "gripper": (lambda link: link.hardware.gripper.stuck, False, True),
    "arm": (lambda link: link.hardware.arm.switched_on, True, False),
    "laser": (lambda link: link.supplies("laser"), True, False),
    "camera": (lambda link: link.supplies("camera"), True, False),
    "charger": (lambda link: link.hardware.charger.plugged_in, False, True),
}


def test_every_kind_has_a_row_here():
    assert [words.split()[0] for words in EFFECTS] + ["carry"] == list(KINDS)    # nobody carries it back


def carried(words, seconds=0.2):
    """Return a robot that two walls are near, after a fault, and what was said."""
    simulation, said = Simulation(World("hall", walls=[(3.0, -1.0, 3.0, 1.0), (-3.0, -1.0, -3.0, 1.0)])), []
    robot = simulation.add(find_model("p3dx-sh"))
    lines = LineSimulation(simulation, faults=[fault_of(words)], say=lambda time, sentence: said.append(sentence))
    lines.advance(seconds)
    return robot, said


def test_a_person_carries_the_robot_and_its_odometry_does_not_notice():
    robot, said = carried("carry 1.5 -0.5 90 robot 1")
    assert robot.true_pose == pytest.approx((1.5, -0.5, math.pi / 2))
    assert robot.hardware.odometry.pose == (0.0, 0.0, 0.0)
    assert said == ["fault begins: carry 1.5 -0.5 90 robot 1", "fault ends: carry 1.5 -0.5 90 robot 1"]
    assert carried("carry 1.5 -0.5 90 from 5")[0].true_pose == (0.0, 0.0, 0.0)


def test_nobody_carries_a_robot_into_a_wall():
    robot, said = carried("carry 3 0 0")
    assert robot.true_pose == (0.0, 0.0, 0.0)
    assert said[1] == ("fault carry 3 0 0: robot 1 cannot stand at x 3, y 0, heading 0: in its way is a wall or a post")


@pytest.mark.parametrize("words", EFFECTS)
def test_every_kind_does_what_it_says_to_the_robot_it_is_for(words):
    seen, normal, faulty = EFFECTS[words]
    scene = Scene()
    assert [seen(link) for link in scene.links] == [normal, normal]
    scene.add(words + " robot 2 to 1")
    assert [seen(link) for link in scene.links] == [normal, faulty]
    scene.faults.step(1000000)
    assert [seen(link) for link in scene.links] == [normal, normal]


def test_a_camera_at_an_auxiliary_port_has_no_power_either():
    scene = Scene()
    fit_camera(scene.links[0].firmware, CameraPorts("vcc4", aux=2))
    camera = scene.links[0].hardware.aux[1].joined
    scene.add("camera to 1")
    assert camera.faults.no_power
    scene.faults.step(1000000)
    assert not camera.faults.no_power


def test_two_dead_transducers_are_two():
    scene = Scene()
    scene.add("transducer 3")
    scene.add("transducer 5 robot 1 to 9")
    assert [link.firmware.hardware.sonar.dead for link in scene.links] == [{3, 5}, {3}]
    scene.faults.step(9000000)
    assert scene.links[0].firmware.hardware.sonar.dead == {3}


def test_power_off_ends_the_session():
    scene = Scene()
    robot = scene.links[0].firmware
    for number in (0, 1, 2, 1):
        robot.receive(bytes((0xFA, 0xFB, 3, number, 0, number)))
    assert robot.session is FirmwareState.OPEN
    scene.add("power")
    assert robot.session is FirmwareState.WAITING

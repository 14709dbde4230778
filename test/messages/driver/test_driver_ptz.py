"""The camera's topics and services, with the whole driver and a simulated robot and camera, in simulated time."""

import math

import pytest
from bottle import Bottle
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from pioneer_control.client.line_devices import LineDevices
from pioneer_control.driver.node import DOCKED
from pioneer_control.driver.ptz_topics import JOINTS, PTZ_SERVICES, PTZ_TOPICS
from pioneer_control.msg import PTZState
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.line.cameras import CameraPorts, fit_camera
from pioneer_control.simulator.world import load_world

NAN, INF = math.nan, math.inf


class PtzBottle(Bottle):
    """``camera`` is the simulated camera."""

    def __init__(self, monkeypatch, script, cabling="two_way", aux=1, **given):
        firmware = Firmware(find_model("p3dx-sh"), load_world("empty"), noise=0.0)
        fit_camera(firmware, CameraPorts("vcc4", cabling, aux))
        self.camera = firmware.hardware.aux[aux - 1].joined
        monkeypatch.setattr(LineDevices, "start", lambda devices: None)     # wait() ticks them
        given.setdefault("ptz", "vcc4")
        super().__init__(monkeypatch, script, firmware, **given)

    @property
    def session(self):
        return self.node._device_topics["Camera"]._session

    def wait(self, seconds):
        for _ in range(round(seconds / 0.02)):
            with self.node._devices.using() as now:
                if "Camera" in self.node._device_topics:
                    self.session.tick(now)
            yield 0.02

    def ready(self):
        yield from self.wait(6.5 if self.camera.answers else 13.0)

    @property
    def place(self):
        return self.camera.pan.position, self.camera.tilt.position, self.camera.zoom.position


@pytest.fixture
def run(monkeypatch):
    return lambda script, **options: PtzBottle(monkeypatch, script, **options)


def joint_message(bottle):
    return [message for message in bottle.messages("joint_states") if message.name == list(JOINTS)][-1]


def numbers(state):
    return state.pan, state.tilt, state.zoom, state.relative


def test_without_the_parameter_there_is_nothing_of_a_camera(monkeypatch):
    def script(bottle):
        yield 1.0

    bottle = Bottle(monkeypatch, script)
    assert not {"ptz_state", "ptz_view"} & set(bottle.published) and "ptz_control" not in bottle._topics
    assert "ptz/home" not in bottle._services
    assert not {name for _, name, _ in bottle.heard} & {"TTY2", "GETAUX", "AUX1BAUD"}


@pytest.mark.parametrize("options", [{}, dict(aux=2, ptz_port="aux2"), dict(ptz_cabling="two_way")])
def test_ptz_control_and_its_effect_on_the_camera_ptz_state_and_joint_states(run, options):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(45, 20, 1000, False))
        yield from bottle.wait(4.0)
        bottle.after = bottle.place
        bottle.send("ptz_control", PTZState(-55, 1, -400, True))
        yield from bottle.wait(4.0)

    bottle = run(script, **options)
    assert bottle.after == (400, 178, 1000)
    states = list(map(numbers, bottle.messages("ptz_state")))
    assert states[0] == (0, 0, 0, False) and (45, 20, 1000, False) in states
    assert bottle.place == (-89, 187, 600) and states[-1] == (-10, 21, 600, False)
    pan, tilt = joint_message(bottle).position
    assert pan == pytest.approx(math.radians(10.0), abs=0.002)      # to the left is positive, and so is downwards
    assert tilt == pytest.approx(math.radians(-21.0), abs=0.002)
    assert bottle.says("camera: ready")


def test_beyond_the_limits_it_goes_to_them_as_in_p2os(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(2 ** 31 - 1, 2 ** 31 - 1, 2 ** 31 - 1, False))
        yield from bottle.wait(4.0)
        bottle.high = bottle.place
        bottle.send("ptz_control", PTZState(-2 ** 31, -2 ** 31, -2 ** 31, True))
        yield from bottle.wait(4.0)

    bottle = run(script)
    assert bottle.high == (871, 782, 1960) and bottle.place == (-871, -267, 0)
    assert numbers(bottle.messages("ptz_state")[-1]) == (-98, -30, 0, False)


def test_while_it_moves_each_place_is_published_once_with_the_time_when_it_was_there(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.begun = bottle.now
        bottle.send("ptz_control", PTZState(90, 0, 0, False))
        yield from bottle.wait(8.0)

    bottle = run(script, ptz_pan_speed=0.3)
    told = [(message.header.stamp.to_sec(), message.position[0]) for time, message in bottle.published["joint_states"]
            if message.name == list(JOINTS) and time > bottle.begun]
    times = [time for time, _ in told]
    assert times == sorted(times) and len(set(times)) == len(times)
    moving = [(time, -pan) for time, pan in told if 0.1 < -pan < 1.5]
    assert len(moving) > 5
    for (before, start), (after, end) in zip(moving, moving[1:]):
        assert (end - start) / (after - before) == pytest.approx(0.3, abs=0.08)


def test_one_way_what_it_was_told_is_published(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(45, 20, 1000, False))
        yield from bottle.wait(4.0)

    bottle = run(script, cabling="one_way", ptz_cabling="one_way")
    assert bottle.place == (400, 178, 1000) and numbers(bottle.messages("ptz_state")[-1]) == (45, 20, 1000, False)
    assert "GETAUX" not in {name for _, name, _ in bottle.heard}


def test_angles_of_joints_are_finer_and_one_joint_keeps_the_other(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_joint_control", JointState(name=list(JOINTS), position=[0.5, -0.2]))
        yield from bottle.wait(3.0)
        bottle.send("ptz_joint_control", JointState(name=[JOINTS[1]], position=[0.1]))
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert joint_message(bottle).position == pytest.approx([0.5, 0.1], abs=0.001)
    assert bottle.place[0] == -255


@pytest.mark.parametrize("message, reason", [
    (JointState(name=list(JOINTS), position=[0.1, NAN]), "ptz_tilt_joint is nan"),
    (JointState(name=list(JOINTS), position=[INF, 0.0]), "ptz_pan_joint is inf"),
    (JointState(name=list(JOINTS), position=[0.1, 1e9]), "legal: -2 pi to 2 pi"),
    (JointState(name=["left_wheel_joint"], position=[0.1]), "no joint 'left_wheel_joint'"),
    (JointState(name=list(JOINTS), position=[0.1]), "2 names and 1 positions"),
    (JointState(), "0 names and 0 positions"),
])
def test_what_makes_no_sense_is_refused_with_the_reason(run, message, reason):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_joint_control", message)
        yield from bottle.wait(1.0)

    bottle = run(script)
    assert bottle.place == (0, 0, 0) and "ptz_joint_control refused" in bottle.warned and reason in bottle.warned


def test_services_and_their_effects(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(90, 0, 0, False))
        yield from bottle.wait(3.0)
        bottle.answers = [bottle.call("ptz/stop")]
        yield from bottle.wait(1.0)
        bottle.stopped = bottle.place
        bottle.answers.append(bottle.call("ptz/home"))
        yield from bottle.wait(3.0)
        bottle.at_home = bottle.place
        bottle.answers.append(bottle.call("ptz/power", False))
        yield from bottle.wait(2.0)
        bottle.was_on = bottle.camera.is_on
        bottle.refused = bottle.call("ptz/home")
        bottle.answers.append(bottle.call("ptz/power", True))
        yield from bottle.wait(12.0)

    bottle = run(script, ptz_pan_speed=0.2)
    assert [answer.success for answer in bottle.answers] == [True] * 4
    assert 20 < bottle.stopped[0] < 800 and bottle.at_home == (0, 0, 0)
    assert not bottle.was_on and not bottle.refused.success and "ptz/power" in bottle.refused.message
    assert bottle.camera.is_on and bottle.camera.is_initialised


def test_what_a_bag_player_publishes_is_refused(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(45, 0, 0, False))
        bottle.send("ptz_joint_control", JointState(name=[JOINTS[0]], position=[0.5]))
        yield from bottle.wait(1.0)

    bottle = run(script, caller="/play_1234567")
    assert bottle.place == (0, 0, 0) and bottle.warned.count("played back from a bag") == 2


def test_stop_all_stops_the_camera_and_refuses_what_would_turn_it(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(90, 0, 0, False))
        yield from bottle.wait(1.0)
        bottle.send("stop_all", Bool(True))
        yield from bottle.wait(1.0)
        bottle.stopped = bottle.place
        bottle.send("ptz_control", PTZState(-90, 0, 0, False))
        bottle.home, bottle.power, bottle.stop = (
            bottle.call("ptz/home"), bottle.call("ptz/power", True), bottle.call("ptz/stop"))
        yield from bottle.wait(2.0)
        bottle.still = bottle.place
        bottle.send("stop_all", Bool(False))
        bottle.send("ptz_control", PTZState(0, 0, 0, False))
        yield from bottle.wait(6.0)

    bottle = run(script, ptz_pan_speed=0.3)
    assert 0 < bottle.stopped[0] < 800 and bottle.still == bottle.stopped and bottle.place == (0, 0, 0)
    assert "ptz_control refused: stop_all is set" in bottle.warned and bottle.stop.success
    assert not bottle.home.success and not bottle.power.success


def test_under_stop_all_a_camera_that_gets_power_again_is_not_initialised(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("stop_all", Bool(True))
        bottle.camera.supply(False)
        yield from bottle.wait(6.0)
        bottle.camera.supply(True)
        yield from bottle.wait(12.0)
        bottle.while_locked = bottle.camera.is_initialised
        bottle.send("stop_all", Bool(False))
        yield from bottle.wait(8.0)

    bottle = run(script)
    assert not bottle.while_locked and bottle.camera.is_initialised
    assert bottle.says("nothing may turn it now")


def test_a_robot_in_a_dock_may_look_around(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.node._steered.lock(DOCKED)
        bottle.send("ptz_control", PTZState(45, 0, 0, False))
        yield from bottle.wait(3.0)

    assert run(script).place[0] == 400


def test_the_frames_and_the_view(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(-90, 0, 1960, False))
        yield from bottle.wait(4.0)

    bottle = run(script, ptz_place=[0.1, 0.0, 0.4], frame_prefix="robot2/")
    foot, camera = [message for message in bottle.messages("/tf") if len(message.transforms) == 2][-1].transforms
    assert (foot.header.frame_id, foot.child_frame_id) == ("robot2/base_link", "robot2/ptz_base_link")
    assert (camera.header.frame_id, camera.child_frame_id) == ("robot2/ptz_base_link", "robot2/camera")
    assert (foot.transform.translation.x, foot.transform.translation.z) == (0.1, 0.4)
    assert camera.transform.rotation.z == pytest.approx(math.sqrt(0.5), abs=1e-3)       # to the left
    wide, tele = (bottle.messages("ptz_view")[at] for at in (0, -1))
    assert wide.header.frame_id == "robot2/camera" and len(wide.points) == 16
    assert max(point.y for point in wide.points) == pytest.approx(math.tan(math.radians(22.5)))
    assert max(point.y for point in tele.points) == pytest.approx(math.tan(math.radians(1.5)))


def test_without_a_place_there_is_no_tf_of_it(run):
    def script(bottle):
        yield from bottle.ready()

    bottle = run(script)
    assert all(len(message.transforms) == 1 for message in bottle.messages("/tf"))


def test_how_it_is_is_a_task_of_the_diagnostics(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.well = bottle.node._device_topics["Camera"].finding()
        bottle.unplug()
        yield 0.5
        bottle.gone = bottle.node._device_topics["Camera"].finding()

    bottle = run(script)
    assert bottle.well.message == "ready, says where it looks" and bottle.well.values["Power"] == "on"
    assert "no link to the robot" in bottle.gone.message


def test_a_link_that_breaks_starts_it_anew_where_it_looks(run):
    def script(bottle):
        yield from bottle.ready()
        bottle.send("ptz_control", PTZState(45, 0, 0, False))
        yield from bottle.wait(3.0)
        bottle.unplug(for_a_moment=True)
        yield 0.5
        bottle.send("ptz_control", PTZState(0, 0, 0, False))
        yield from bottle.wait(8.0)
        bottle.anew = bottle.place
        bottle.send("ptz_control", PTZState(0, 0, 0, False))
        yield from bottle.wait(3.0)

    bottle = run(script)
    assert bottle.anew[0] in (400, 0) and bottle.place == (0, 0, 0)
    assert bottle.says("camera: ready") and not bottle.says("camera: there is no link")     # the driver tells of it


def everything(bottle):
    """Turn and zoom it, then end."""
    bottle.node._rest_devices = lambda: None        # it waits for other threads; the end is told below
    yield from bottle.ready()
    if "Camera" in bottle.node._device_topics:
        bottle.send("ptz_control", PTZState(45, 0, 1960, False))
        yield from bottle.wait(3.0)
        bottle.turned, bottle.speeds = bottle.place[0], (bottle.camera.pan.speed, bottle.camera.tilt.speed)
        with bottle.node._devices.using() as now:
            bottle.session.end(now)
        yield from bottle.wait(2.0)


def heard(bottle, *names):
    return bool({name for _, name, _ in bottle.heard} & set(names))


def widest(bottle, at):
    return round(max(point.y for point in bottle.messages("ptz_view")[at].points), 2)


PTZ_EFFECTS = {     # another value, what shows its effect, and that with the usual value and with the other one
    "ptz": ("none", lambda bottle: "ptz_control" in bottle._topics, True, False),
    "ptz_port": ("aux3", lambda bottle: (heard(bottle, "TTY2"), heard(bottle, "TTY4")), (True, False), (False, True)),
    "ptz_cabling": ("one_way", lambda bottle: heard(bottle, "GETAUX"), True, False),
    "ptz_inverted": (True, lambda bottle: bottle.turned, 400, -400),
    "ptz_power_off_at_end": (True, lambda bottle: bottle.camera.is_on, True, False),
    "ptz_pan_speed": (0.5, lambda bottle: bottle.speeds, (800, 613), (255, 613)),
    "ptz_tilt_speed": (0.5, lambda bottle: bottle.speeds, (800, 613), (800, 255)),
    "ptz_place": ([0.1, 0, 0.4], lambda bottle: {each.child_frame_id for message in bottle.messages("/tf")
                                                 for each in message.transforms} > {"camera"}, False, True),
    "ptz_fov_wide": (60.0, lambda bottle: (widest(bottle, 0), widest(bottle, -1)), (0.41, 0.03), (0.58, 0.03)),
    "ptz_fov_tele": (6.0, lambda bottle: (widest(bottle, 0), widest(bottle, -1)), (0.41, 0.03), (0.41, 0.05)),
}


@pytest.fixture(scope="module")
def usual():
    with pytest.MonkeyPatch.context() as monkeypatch:
        return PtzBottle(monkeypatch, everything)


@pytest.mark.parametrize("name", PTZ_EFFECTS)
def test_a_parameter_of_the_camera_has_its_effect(monkeypatch, usual, name):
    value, see, before, after = PTZ_EFFECTS[name]
    aux = 3 if name == "ptz_port" else 1
    cabling = "one_way" if name == "ptz_cabling" else "two_way"
    assert see(usual) == before != after
    assert see(PtzBottle(monkeypatch, everything, cabling, aux, **{name: value})) == after


def test_every_topic_and_service_is_tried_above():
    text = open(__file__, encoding="utf-8").read()
    for row in PTZ_TOPICS + PTZ_SERVICES:
        assert '"%s"' % row.name in text


def test_a_lock_that_is_set_just_before_the_camera_is_told_to_turn_keeps_it_still(run):
    def script(bottle):
        yield from bottle.ready()
        using = bottle.node._device_topics["Camera"]._using

        def locked_first():
            bottle.node._device_topics["Camera"]._using = using
            bottle.send("stop_all", Bool(True))
            return using()

        bottle.node._device_topics["Camera"]._using = locked_first
        bottle.send("ptz_control", PTZState(45, 20, 0, False))
        yield from bottle.wait(2.0)

    bottle = run(script)
    assert "ptz_control refused: stop_all is set" in bottle.warned and bottle.place == (0, 0, 0)

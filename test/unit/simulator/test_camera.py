"""The simulated camera by the camera sheet: modes, errors, limits, times, and what its faults do."""

import random

import pytest
from camera_on_bench import BenchCamera

from pioneer_control.errors import ParameterError
from pioneer_control.simulator.clock import NEVER_US
from pioneer_control.simulator.hardware.accessories import AuxPort
from pioneer_control.simulator.hardware.camera import ACTS, ANSWERS, SimulatedCamera
from pioneer_control.vcc4 import CAMERA_COMMANDS, CameraStatus, encode_camera_command

ACCEPTED, BUSY, UNKNOWN, WRONG_VALUE, WRONG_MODE = (), "1", "3", "5", "9"


@pytest.fixture
def ready():
    return BenchCamera().set_up()


def test_in_local_mode_everything_but_control_and_status_is_a_mode_error():
    bench = BenchCamera()
    for name, row in CAMERA_COMMANDS.items():
        answer = bench.say(name, *(value.low for value in row.values)) if name != "CONTROL" else None
        assert answer is None or (answer == WRONG_MODE) == (name not in ("ASK_STATUS", "ASK_LONG_STATUS")), name
    assert bench.say("ASK_LONG_STATUS")[0] == CameraStatus.LOCAL_MODE | CameraStatus.NEVER_INITIALISED
    assert bench.send(bytes.fromhex("FF 30 30 00 99 EF")).hex() == "fe30303930ef"     # the mode is checked first
    for wrong in ("90", "90 30 30", "90 32", "86 31"):
        assert bench.send(bytes.fromhex("FF 30 30 00 %s EF" % wrong)).hex() == "fe30303530ef", wrong


def test_a_command_to_turn_without_initialisation_is_a_mode_error_and_starts_it():
    bench = BenchCamera()
    bench.say("CONTROL", 0)
    assert bench.say("GO_TO", 100, 0) == WRONG_MODE and bench.say("GO_TO", 100, 0) == BUSY
    bench.run(3.0)
    assert bench.say("GO_TO", 100, 0) == ACCEPTED


def test_the_errors_in_their_order(ready):
    assert ready.send(bytes.fromhex("FF 30 30 00 99 EF")).hex() == "fe30303330ef"
    assert ready.send(bytes.fromhex("FF 30 30 00 63 30 EF")).hex() == "fe30303530ef"
    assert ready.send(bytes.fromhex("FF 30 30 00 B3 46 46 46 46 EF")).hex() == "fe30303530ef"
    ready.say("GO_TO", 871, 0)
    assert ready.say("GO_TO", 900, 0) == WRONG_VALUE and ready.say("GO_TO", 0, 0) == BUSY


def test_another_cameras_number_and_noise_get_no_answer(ready):
    assert ready.send(encode_camera_command("STOP", camera=1)) == b""
    assert ready.send(b"hello \xff \xef \xfe00\xef") == b""
    assert ready.say("STOP") == ACCEPTED


def test_a_command_in_pieces(ready):
    for byte in encode_camera_command("GO_TO", 80, 0):
        ready.camera.device(bytes((byte,)))
    assert ready.run(0.3).hex() == "fe30303030ef"


def test_tilt_is_limited_until_the_range_is_set():
    bench = BenchCamera()
    bench.say("CONTROL", 0)
    bench.say("INITIALISE", 0)
    bench.run(3.0)
    assert bench.say("GO_TO", 0, 268) == WRONG_VALUE and bench.say("ASK_TILT_RANGE") == (-267, 267)
    assert bench.send(bytes.fromhex("FF 30 30 00 64 31 37 45 46 35 38 33 32 31 EF")).hex() == "fe30303530ef"    # ..801
    assert bench.say("TILT_RANGE", 10, 5) == WRONG_VALUE
    assert bench.say("TILT_RANGE", -267, 782) == ACCEPTED and bench.say("GO_TO", 0, 782) == ACCEPTED
    assert bench.say("GO_TO", 0, 783) == WRONG_VALUE


@pytest.mark.parametrize("name, values, seconds", [("GO_TO", (800, 0), 1.0), ("GO_TO", (0, 622), 1.0)])
def test_it_turns_at_the_set_speed_and_tells_where_it_is(ready, name, values, seconds):
    assert ready.say(name, *values) == ACCEPTED
    ready.run(seconds - 0.34)       # it was on its way while it answered
    assert ready.camera.is_turning
    ready.run(0.04)
    assert not ready.camera.is_turning and ready.say("ASK_POSITION") == values


def test_a_slow_turn_a_stop_and_a_new_target(ready):
    assert ready.say("PAN_SPEED", 80) == ACCEPTED == ready.say("GO_TO", 400, 0)
    pan, tilt = ready.say("ASK_POSITION")
    assert 20 <= pan <= 50 and tilt == 0
    assert ready.say("GO_TO", -400, 0) == BUSY == ready.say("HOME")
    assert ready.say("STOP") == ACCEPTED
    stopped = ready.say("ASK_POSITION")
    assert ready.say("ASK_POSITION") == stopped and 0 < stopped[0] < 400
    assert ready.say("GO_TO", -400, 0) == ACCEPTED
    ready.run(10.0)
    assert ready.say("ASK_POSITION") == (-400, 0)
    assert ready.say("ASK_PAN_SPEED") == (80,)
    assert ready.say("HOME") == ACCEPTED        # at its own speed
    ready.run(0.5)
    assert ready.say("ASK_POSITION") == (0, 0)


@pytest.mark.parametrize("name, end", [
    ("RUN_RIGHT", (889, 0)), ("RUN_LEFT", (-889, 0)), ("RUN_UP", (0, 782)), ("RUN_DOWN", (0, -267))])
def test_a_run_goes_to_the_end_of_the_range_or_until_a_stop(ready, name, end):
    assert ready.say(name) == ACCEPTED
    ready.run(2.0)
    assert ready.say("ASK_POSITION") == end
    limit = CameraStatus.PAN_AT_LIMIT if end[0] else CameraStatus.TILT_AT_LIMIT
    assert CameraStatus(ready.say("ASK_STATUS")[0]) & limit


def test_both_axes_run_together(ready):
    assert ready.say("RUN_BOTH", 1, 2) == ACCEPTED
    ready.run(0.1)
    assert ready.say("RUN_BOTH", 2, 0) == ACCEPTED
    ready.run(2.0)
    pan, tilt = ready.say("ASK_POSITION")
    assert pan == -889 and -267 <= tilt < 0


def test_zoom(ready):
    assert ready.say("ZOOM_TO", 1960) == ACCEPTED and ready.say("ZOOM_TO", 0) == BUSY
    assert CameraStatus(ready.say("ASK_STATUS")[0]) & CameraStatus.ZOOMING
    assert ready.say("ZOOM_RUN", 0) == ACCEPTED
    step, = ready.say("ASK_ZOOM")
    assert 0 < step < 1960 and ready.say("ASK_ZOOM_MOST") == (1960,)
    assert ready.say("ZOOM_TO", 0) == ACCEPTED
    ready.run(2.0)
    assert ready.say("ASK_ZOOM") == (0,)
    for how, end in ((4, 1960), (1, 0), (2, 1960), (3, 0)):
        assert ready.say("ZOOM_RUN", how) == ACCEPTED
        ready.run(4.5)
        assert ready.say("ASK_ZOOM") == (end,)
    assert ready.say("COARSE_ZOOM", 64) == ACCEPTED
    ready.run(2.0)
    assert ready.say("ASK_ZOOM") == (979,)
    for step in range(0x81):
        ready.camera.zoom.jump(step * 153 // 10)
        assert ready.say("ASK_COARSE_ZOOM") == (step,), "as it was set"


def test_power_takes_its_time_and_forgets_the_settings(ready):
    assert ready.say("POWER", 0) == ACCEPTED and ready.say("POWER", 1) == BUSY
    ready.run(2.0)
    assert ready.say("ASK_POSITION") == WRONG_MODE
    assert CameraStatus(ready.say("ASK_STATUS")[0]) & CameraStatus.OFF
    assert ready.say("POWER", 1) == ACCEPTED and ready.say("POWER", 1) == BUSY and ready.say("STOP") == WRONG_MODE
    ready.run(4.0)
    assert ready.say("ASK_TILT_RANGE") == (-267, 267) and ready.say("GO_TO", 0, 0) == WRONG_MODE


def test_initialisation_goes_home_or_back_and_is_busy_meanwhile(ready):
    ready.say("GO_TO", 400, 100)
    ready.run(1.0)
    assert ready.say("INITIALISE", 1) == ACCEPTED and ready.say("STOP") == BUSY == ready.say("INITIALISE", 0)
    ready.run(3.0)
    assert ready.say("ASK_POSITION") == (400, 100)
    ready.say("INITIALISE", 0)
    ready.run(3.0)
    assert ready.say("ASK_POSITION") == (0, 0)


def test_questions_about_itself(ready):
    asked = {name: ready.say(name) for name in ANSWERS}
    assert asked["ASK_PAN_LEAST"] + asked["ASK_PAN_MOST"] == (-889, 889)
    assert asked["ASK_TILT_LEAST"] + asked["ASK_TILT_MOST"] == (-267, 800)
    assert asked["ASK_PAN_SPEED_LEAST"] + asked["ASK_PAN_SPEED_MOST"] == (8, 800)
    assert asked["ASK_TILT_SPEED_LEAST"] + asked["ASK_TILT_SPEED_MOST"] == (8, 622)
    assert asked["ASK_TILT_SPEED"] == (622,)
    assert asked["ASK_PAN_COUNT"] == asked["ASK_TILT_COUNT"] == (11250,)
    assert asked["ASK_PAN_RANGE"] == (-889, 889) and asked["ASK_VERSION"] == ("V1-01",)
    assert ready.say("PAN_RANGE", -400, 400) == ACCEPTED and ready.say("GO_TO", 401, 0) == WRONG_VALUE


def test_every_command_has_an_effect_or_is_known_to_have_none():
    without = {"STOP", "FOCUS", "FRONT_LAMP", "ELECTRONIC_ZOOM", "INFRARED_FILTER", "INFRARED_LAMP"} - set(ACTS)
    assert set(CAMERA_COMMANDS) == set(ACTS) | set(ANSWERS) | without


def test_only_a_c50i_has_its_extras(ready):
    assert ready.say("INFRARED_LAMP", 6) == UNKNOWN and ready.say("ASK_PRODUCT") == ("VCC4 ",)
    other = BenchCamera("vcc50i").set_up()
    for name, value in (("INFRARED_FILTER", 0), ("INFRARED_LAMP", 6), ("ELECTRONIC_ZOOM", 2), ("FOCUS", 0),
                        ("FRONT_LAMP", 1)):
        assert other.say(name, value) == ACCEPTED
    assert other.say("ASK_PRODUCT") == ("C50i ",)
    assert [times for times in range(1, 13) if other.say("ELECTRONIC_ZOOM", times) == ACCEPTED] == [1, 2, 4, 8, 12]


def test_answers_take_their_time(ready):
    frame = encode_camera_command("ASK_POSITION")
    ready.camera.device(frame)
    assert ready.run(0.02) == b"" and len(ready.run(0.02)) == 14    # 20 ms, and 1 ms for each of 6 + 14 bytes


def test_faults(ready):
    ready.camera.fail(silent=True)
    assert ready.send(encode_camera_command("GO_TO", 800, 0)) == b"" and ready.camera.is_turning
    ready.camera.fail(silent=False, noise=b"\x00", cut_us=100000)
    assert ready.send(encode_camera_command("STOP")) == b"\x00\xfe0000\xef"
    ready.camera.fail(noise=b"", cut_us=0, busy=True)
    assert ready.say("GO_TO", 0, 0) == BUSY == ready.say("STOP")
    ready.camera.fail(busy=False, menu_open=True)
    assert ready.say("CONTROL", 0) == WRONG_MODE
    ready.camera.fail(menu_open=False)
    ready.camera.switch(False)
    assert ready.say("STOP") == WRONG_MODE


def test_one_way_it_obeys_and_says_nothing():
    bench = BenchCamera(ready=True, answers=False)
    assert bench.send(encode_camera_command("GO_TO", 80, 0)) == b""
    bench.run(1.0)
    assert bench.camera.pan.position == 80


def test_at_an_auxiliary_port_it_answers_through_it_and_restarts_with_the_robot():
    port, camera = AuxPort(), SimulatedCamera("vcc4")
    camera.join(port, 1)
    port.write(encode_camera_command("CONTROL", 0))
    port.want(6)
    for now_us in (20000, 40000):
        port.joined.step(now_us)
    assert port.take().hex() == "fe30303030ef" and not camera.is_local
    port.joined.restart()
    assert camera.is_local
    with pytest.raises(ParameterError, match=r"AUX1 has a camera already: a camera needs another .* \(camera_aux"):
        SimulatedCamera("vcc4").join(port, 1)


def test_without_power_it_hears_and_says_nothing_and_then_it_starts_anew():
    bench = BenchCamera(ready=True)
    bench.camera.device(encode_camera_command("GO_TO", 80, 0))     # its answer is on the way
    bench.camera.supply(False)
    assert bench.camera.next_us == NEVER_US
    assert bench.send(encode_camera_command("GO_TO", 40, 0)) == b""
    assert bench.camera.next_us == NEVER_US
    bench.run(1.0)
    assert bench.camera.pan.position == 0
    bench.camera.supply(False)
    bench.camera.supply(True)
    assert bench.camera.is_on and bench.camera.is_local == (not bench.camera.numbers.starts_ready)
    assert bench.send(encode_camera_command("CONTROL", 0)).hex() == "fe30303030ef"


def test_a_share_of_the_fuzz_of_the_camera():
    """bench/fuzz_camera.py does the same a million times."""
    rng = random.Random(2)
    bench, names = BenchCamera(ready=True), sorted(CAMERA_COMMANDS)
    for _ in range(3000):
        row = CAMERA_COMMANDS[rng.choice(names)]
        data = bytearray(encode_camera_command(row.name, *(rng.randint(value.low, value.high) for value in row.values)))
        if rng.random() < 0.5:
            data[rng.randrange(len(data))] = rng.randrange(256)
        bench.camera.device(bytes(data))
        bench.now_us += 20000
        bench.camera.step(bench.now_us)
        for axis in (bench.camera.pan, bench.camera.tilt, bench.camera.zoom):
            assert abs(axis.position) <= 1960

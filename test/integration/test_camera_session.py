"""The camera's session with the simulated camera, directly and through the robot: each command's effect, and faults."""

import contextlib
import random

import pytest
from camera_rig import ONE_WAY, RIGS, AuxRig, DirectRig

from pioneer_control.errors import RefusedError
from pioneer_control.ptz import Cabling, CameraPhase
from pioneer_control.vcc4 import CAMERA_MODELS, AnswerKind, encode_error

START = ["90 30", "86 30", "58 30", "53 30", "50 33 32 30", "51 32 36 35", "64 31 37 45 46 35 38 33 30 45"]
either = pytest.mark.parametrize("rig", RIGS, ids=lambda rig: rig.__name__)


def without_questions(heard):
    return [words for words in heard if not words.startswith(("63", "b4"))]


@either
def test_it_takes_control_initialises_and_sets_speeds_and_range(rig):
    rig = rig().ready()
    said = [words for number, words in enumerate(rig.heard) if words not in rig.heard[:number]]
    assert without_questions(said) == START
    report = rig.session.report
    assert report.cabling is Cabling.TWO_WAY and report.has_power and report.is_measured
    assert (report.pan, report.tilt, report.zoom, report.problem) == (0, 0, 0, "")


def test_a_camera_that_is_off_gets_power_first_and_control_before_and_after():
    rig = DirectRig()
    rig.camera.switch(False)
    rig.ready()
    assert [words for number, words in enumerate(rig.heard) if words not in rig.heard[number - 1:number]][:5] == [
        "90 30", "86 30", "a0 31", "90 30", "58 30"]
    assert rig.camera.is_on and rig.camera.is_initialised


@either
def test_each_command_and_its_effect(rig):
    rig = rig().ready()
    rig.session.look(-400, 178, rig.now)
    assert rig.rests()[:2] == rig.true_place[:2] == (-400, 178)
    rig.session.zoom_to(1000, rig.now)
    assert rig.rests() == rig.true_place == (-400, 178, 1000)
    rig.session.home(rig.now)
    assert rig.rests() == rig.true_place == (0, 0, 1000) and rig.heard.count("57") == 1


@either
def test_at_its_limits(rig):
    rig = rig().ready()
    rig.session.look(5000, 5000, rig.now)
    rig.session.zoom_to(9999, rig.now)
    assert rig.rests() == rig.true_place == (871, 782, 1960)
    rig.session.look(-5000, -5000, rig.now)
    rig.session.zoom_to(-1, rig.now)
    assert rig.rests() == rig.true_place == (-871, -267, 0)
    assert rig.session.report.last_error in ("", "GO_TO -871 -267: it is busy")


@either
def test_a_new_target_on_the_way_stops_it_first_and_the_newest_counts(rig):
    rig = rig(pan_speed=80).ready()
    rig.session.look(800, 0, rig.now)
    rig.run(0.6)
    assert 0 < rig.camera.pan.position < 800
    before = len(rig.heard)
    for pan in (700, 600, -40):
        rig.session.look(pan, 0, rig.now)
    assert rig.rests()[0] == rig.camera.pan.position == -40
    said = without_questions(rig.heard[before:])
    assert said[1] == "53 30" and said[-1].startswith("62 37 46 44 38")


@either
def test_a_stop(rig):
    rig = rig(pan_speed=80).ready()
    rig.session.look(800, 0, rig.now)
    rig.session.zoom_to(1960, rig.now)
    rig.run(0.8)
    rig.session.stop(rig.now)
    place = rig.rests()
    assert place == rig.true_place and 0 < place[0] < 400 and 0 < place[2] < 1960
    assert rig.run(5.0).true_place == place


@either
def test_a_stop_goes_before_a_target_whose_answer_was_lost(rig):
    """The target is not sent once more after the stop: it may be what turns the camera."""
    rig = rig(pan_speed=100).ready()
    rig.camera.fail(silent=True)
    rig.session.look(800, 0, rig.now)
    rig.run(0.5)
    rig.session.stop(rig.now)
    rig.run(1.0)
    assert not rig.camera.pan.is_moving and 0 < rig.camera.pan.position < 150
    rig.camera.fail(silent=False)
    rig.until(lambda: rig.session.phase is CameraPhase.READY)
    assert [words for words in rig.heard if words.startswith("62")] == ["62 38 33 32 30 38 30 30 30"]
    assert rig.rests() == rig.true_place and rig.camera.pan.position < 150


@either
def test_a_camera_that_has_failed_is_told_to_stop_all_the_same(rig):
    """And so is one that is being started anew: the answers are lost, but it may turn."""
    for phase in CameraPhase.FAILED, CameraPhase.STARTING:
        bad = rig(pan_speed=8).ready()
        bad.session.look(800, 0, bad.now)
        bad.run(1.0)
        bad.camera.fail(silent=True)
        bad.until(lambda: bad.session.phase is phase)
        assert bad.camera.pan.is_moving
        bad.session.stop(bad.now)
        bad.run(0.3)
        assert not bad.camera.pan.is_moving and bad.session.phase is phase


@either
def test_a_camera_that_is_held_is_not_initialised(rig):
    """The initialisation would turn it."""
    rig = rig()
    rig.held = True
    rig.run(10.0)
    assert "58 30" not in rig.heard and not rig.camera.is_initialised
    assert "nothing may turn it" in rig.session.report.problem
    rig.held = False
    rig.ready()
    assert rig.camera.is_initialised and rig.session.report.problem == ""


@either
def test_a_camera_that_turns_and_is_held_is_stopped_when_its_line_is_back(rig):
    rig = rig(pan_speed=8).ready()
    rig.session.look(800, 0, rig.now)
    rig.run(1.0)
    rig.session.line_down("the cable is out")
    rig.held = True
    rig.run(1.0)
    assert rig.camera.pan.is_moving
    rig.session.line_up(rig.now)
    rig.ready()
    assert rig.rests()[0] == rig.camera.pan.position < 100


@either
def test_a_camera_that_is_held_is_switched_off_where_it_looks(rig):
    rig = rig().ready()
    rig.session.look(400, 0, rig.now)
    rig.rests()
    rig.held = True
    rig.session.power(False, rig.now)
    rig.until(lambda: not rig.camera.is_on)
    assert not [words for words in rig.heard[-6:] if words.startswith("62 38 30 30 30")]


def test_a_stop_forgets_a_target_that_the_camera_was_too_busy_for():
    rig = DirectRig().ready()
    rig.camera.fail(busy=True)
    rig.session.look(800, 0, rig.now)
    rig.run(0.5)
    rig.session.stop(rig.now)
    rig.camera.fail(busy=False)
    rig.run(3.0)        # one more try was just on its way
    assert 0 <= rig.camera.pan.position < 100 and rig.session.phase is CameraPhase.READY


def test_a_target_after_a_stop_is_not_stopped_by_it():
    rig = DirectRig(pan_speed=80).ready()
    rig.camera.fail(busy=True)
    rig.session.look(800, 0, rig.now)
    rig.run(0.5)
    rig.session.stop(rig.now)
    rig.session.look(-400, 0, rig.now)
    rig.camera.fail(busy=False)
    assert rig.rests()[0] == rig.camera.pan.position == -400


@either
def test_the_same_target_after_a_stop_is_a_new_one(rig):
    """Also when the answer to the first one comes after both."""
    rig = rig().ready()
    for _ in range(2):
        rig.session.look(400, 0, rig.now)
        rig.session.zoom_to(500, rig.now)
        rig.until(lambda: rig.heard[-1].startswith("b3"))
        rig.session.stop(rig.now)
    rig.session.look(400, 0, rig.now)
    rig.session.zoom_to(500, rig.now)
    assert rig.rests() == rig.true_place == (400, 0, 500)


@either
def test_home_after_a_stop_is_a_new_wish(rig):
    rig = rig().ready()
    rig.session.look(400, 0, rig.now)
    rig.until(lambda: rig.camera.pan.position > 100)
    rig.session.home(rig.now)
    rig.until(lambda: rig.heard[-1].startswith("57"))
    rig.session.stop(rig.now)
    rig.session.home(rig.now)
    assert rig.rests()[:2] == rig.true_place[:2] == (0, 0)


@either
def test_a_program_that_repeats_its_target_does_not_stop_the_camera_each_time(rig):
    rig = rig(pan_speed=160).ready()
    before = len(rig.heard)
    for _ in range(40):
        rig.session.look(400, 0, rig.now)
        rig.session.zoom_to(1000, rig.now)
        rig.run(0.1)
    assert rig.true_place == (400, 0, 1000)
    said = without_questions(rig.heard[before:])
    assert len([words for words in said if words.startswith("62")]) == 1 and "53 30" not in said
    rig.camera.pan.jump(0)          # somebody turns it
    rig.run(4.5)
    rig.session.look(400, 0, rig.now)
    assert rig.run(3.0).camera.pan.position == 400


def test_an_answer_to_an_earlier_command_is_no_answer_to_a_question():
    rig = DirectRig().ready()
    rig.until(lambda: rig.heard[-1] == "63")
    answers = rig.session.report.answers
    rig.until(lambda: rig.session.report.answers > answers)
    rig.session.look(400, 100, rig.now)
    rig.rests()
    rig.camera.fail(silent=True)
    count = len(rig.heard)
    rig.until(lambda: len(rig.heard) > count)               # a question is asked, and waits for its answer
    assert rig.session.answer_missing and not rig.session.has_output
    rig.session.receive(bytes.fromhex("FE 30 30 30 30 EF"), rig.now)
    assert rig.session.answer_missing == 6 and not rig.session.has_output
    rig.camera.fail(silent=False)
    rig.run(2.0)
    assert (rig.session.report.pan, rig.session.report.tilt) == (400, 100)


def test_relative_targets_count_from_the_last_target_or_from_where_it_looks():
    rig = DirectRig(pan_speed=80).ready()
    assert rig.session.target == (0, 0, 0)
    rig.session.look(800, 10, rig.now)
    rig.session.zoom_to(50, rig.now)
    rig.run(0.3)
    assert rig.session.target == (800, 10, 50)
    rig.session.stop(rig.now)
    rig.rests()
    assert rig.session.target == rig.true_place


def test_a_camera_with_another_range_of_tilt_turns_within_it():
    """A VC-C50i that hangs has -800 to 89, and refuses the usual range."""
    rig = DirectRig(kind="vcc50i")
    rig.camera._model = CAMERA_MODELS["vcc50i"]._replace(tilt_mechanics=(-800, 89), tilt_at_power_on=(-800, 89))
    rig.camera.restart()
    rig.ready()
    assert rig.session.report.last_error == "TILT_RANGE -267 782: out of its range"
    rig.session.look(100, 50, rig.now)
    assert rig.rests()[:2] == rig.true_place[:2] == (100, 50)
    rig.session.look(100, 500, rig.now)
    assert rig.rests()[:2] == (100, 50) and rig.session.report.last_error == "GO_TO 100 500: out of its range"


def test_a_camera_that_refuses_the_speeds_has_its_own():
    rig = DirectRig()
    answer = rig.camera._answer
    rig.camera._answer = lambda order: (encode_error(AnswerKind.UNKNOWN_COMMAND) if order.number in (0x50, 0x51)
                                        else answer(order))
    rig.ready()
    assert rig.session.report.last_error == "TILT_SPEED 613: it does not know this command"
    rig.session.look(100, 50, rig.now)
    assert rig.rests()[:2] == (100, 50)


@either
def test_a_fault_of_the_system_beside_an_answer_is_no_refusal(rig):
    """The second digit of the error byte. Nobody looks at it (camera sheet 3)."""
    rig = rig()
    put = rig.camera.put
    rig.camera.put = lambda data: put(data[:4] + b"1" + data[5:])
    rig.ready()
    rig.session.look(100, 50, rig.now)
    assert rig.rests()[:2] == (100, 50)


def test_upside_down_pan_and_tilt_are_the_other_way_round():
    rig = DirectRig(inverted=True).ready()
    rig.session.look(100, -500, rig.now)
    assert rig.rests()[:2] == (100, -500) and rig.true_place[:2] == (-100, 500)
    rig.session.look(0, 500, rig.now)
    assert rig.rests()[1] == 267 and rig.camera.tilt.position == -267


@either
def test_one_way_it_is_told_after_pauses_and_nothing_is_known(rig):
    rig = rig(**ONE_WAY)
    seconds = rig.until(lambda: rig.session.phase is CameraPhase.READY)
    assert 10.0 < seconds < 12.5
    assert rig.heard == ["90 30", "a0 31", "90 30", "58 30", *START[4:], "b3 30 30 30 30"]
    rig.session.look(400, 100, rig.now)
    rig.run(2.0)
    assert rig.true_place == (400, 100, 0) and rig.heard[-2] == "53 30"
    report = rig.session.report
    assert (report.pan, report.tilt) == (400, 100) and not report.is_measured and not report.is_moving
    assert report.has_power is None and report.answered_at is None
    rig.session.look(-400, 0, rig.now)
    rig.session.zoom_to(500, rig.now)
    rig.run(0.4)
    rig.session.look(-300, 0, rig.now)
    rig.run(5.0)
    assert rig.true_place == (-300, 0, 500)
    rig.session.stop(rig.now)
    assert rig.run(1.0).heard[-2:] == ["53 30", "a2 30"]


@either
def test_it_finds_out_that_a_camera_never_answers(rig):
    rig = rig(answers=False)
    rig.until(lambda: rig.session.report.cabling is Cabling.ONE_WAY)
    assert rig.heard == ["90 30"] * 4
    rig.until(lambda: rig.session.phase is CameraPhase.READY)
    rig.session.look(100, 0, rig.now)
    assert rig.run(2.0).camera.pan.position == 100


def test_an_answer_after_all_means_two_way():
    rig = DirectRig(answers=False)
    rig.until(lambda: rig.session.phase is CameraPhase.READY)
    rig.session.receive(bytes.fromhex("FE 30 30 30 30 EF"), rig.now)
    assert rig.session.report.cabling is Cabling.TWO_WAY


@either
def test_a_lost_answer_is_asked_for_again(rig):
    rig = rig().ready()
    rig.camera.fail(silent=True)
    rig.session.look(800, 0, rig.now)
    rig.run(0.5)
    rig.camera.fail(silent=False)
    assert rig.rests()[0] == rig.camera.pan.position == 800 and rig.session.report.repeated >= 1


@either
def test_answers_in_pieces_and_behind_noise(rig):
    rig = rig()
    rig.camera.fail(cut_us=60000, noise=b"\x00")
    rig.ready()
    rig.session.look(800, -100, rig.now)
    assert rig.rests()[:2] == (800, -100)
    assert rig.session.report.stray_bytes > 0 and rig.session.phase is CameraPhase.READY


def test_a_camera_that_was_there_and_is_silent_is_told_and_started_anew():
    rig = DirectRig().ready()
    rig.camera.fail(silent=True)
    rig.until(lambda: rig.session.phase is CameraPhase.FAILED)
    assert "does not answer" in rig.session.report.problem
    for command in (lambda: rig.session.look(0, 0, rig.now), lambda: rig.session.zoom_to(0, rig.now),
                    lambda: rig.session.home(rig.now)):
        with pytest.raises(RefusedError, match="does not answer"):
            command()
    rig.camera.fail(silent=False)
    rig.ready()
    assert rig.session.report.problem == "" and "does not answer" in rig.session.report.last_error


@either
def test_a_camera_that_lost_its_power_meanwhile_is_started_anew(rig):
    rig = rig().ready()
    rig.session.look(400, 0, rig.now)
    rig.rests()
    rig.camera.restart()
    rig.until(lambda: rig.session.phase is CameraPhase.FAILED)
    assert "off, has lost its power" in rig.session.report.problem
    rig.ready()
    assert rig.true_place == (0, 0, 0) and not rig.camera.is_local


def test_a_camera_that_is_busy_for_ever_is_told_with_longer_and_longer_pauses():
    rig = DirectRig().ready()
    rig.camera.fail(busy=True)
    before = len(rig.heard)
    rig.session.look(400, 0, rig.now)
    seconds = rig.until(lambda: rig.session.phase is CameraPhase.FAILED)
    assert 10.0 <= seconds < 14.0 and "busy, for 10 s" in rig.session.report.problem
    assert len([words for words in rig.heard[before:] if words.startswith("62")]) < 16
    rig.camera.fail(busy=False)
    rig.ready()
    assert rig.run(3.0).camera.pan.position == 0       # the target is forgotten


def test_a_person_with_the_menu_open_is_told():
    rig = DirectRig()
    rig.camera.fail(menu_open=True)
    rig.until(lambda: rig.session.phase is CameraPhase.FAILED)
    assert "menu open" in rig.session.report.problem
    rig.camera.fail(menu_open=False)
    rig.ready()


def test_nobody_on_a_two_way_line_is_told_and_looked_for_again():
    rig = DirectRig(answers=False, cabling=Cabling.TWO_WAY)
    rig.until(lambda: rig.session.phase is CameraPhase.FAILED)
    assert "does not answer: its power, its cable, or the port" in rig.session.report.problem
    rig.camera.answers = True
    rig.ready()


@either
def test_off_and_on_again(rig):
    rig = rig().ready()
    rig.session.look(400, 0, rig.now)
    rig.rests()
    rig.session.power(False, rig.now)
    rig.until(lambda: rig.session.phase is CameraPhase.OFF)
    assert not rig.camera.is_on and rig.session.report.has_power is False
    with pytest.raises(RefusedError, match="ptz/power"):
        rig.session.look(0, 0, rig.now)
    rig.session.power(False, rig.now)
    rig.session.power(True, rig.now)
    rig.ready()
    assert rig.camera.is_on
    rig.session.look(100, 0, rig.now)
    assert rig.rests()[0] == 100


def test_off_that_fails_does_not_switch_it_on_again():
    rig = DirectRig().ready()
    rig.camera.fail(silent=True)
    rig.session.power(False, rig.now)
    rig.until(lambda: rig.session.phase is CameraPhase.OFF)
    assert "was to be switched off, but" in rig.session.report.problem


def test_off_goes_before_a_target_that_the_camera_is_too_busy_for():
    rig = DirectRig().ready()
    rig.camera.fail(busy=True)
    rig.session.look(400, 0, rig.now)
    rig.run(1.0)
    rig.session.power(False, rig.now)
    rig.run(1.0)
    rig.camera.fail(busy=False)
    rig.until(lambda: rig.session.phase is CameraPhase.OFF)
    assert not rig.camera.is_on and rig.run(10.0).session.phase is CameraPhase.OFF


def test_off_is_wished_while_the_camera_falls_silent():
    rig = DirectRig().ready()
    rig.camera.fail(silent=True)
    rig.session.look(400, 0, rig.now)
    rig.session.power(False, rig.now)
    rig.until(lambda: rig.session.phase is CameraPhase.OFF)
    rig.camera.fail(silent=False)
    assert rig.run(10.0).session.phase is CameraPhase.OFF


@either
def test_a_camera_that_works_already_keeps_looking_where_it_looks(rig):
    rig = rig().ready()
    rig.session.look(400, 100, rig.now)
    rig.session.zoom_to(300, rig.now)
    place = rig.rests()
    rig.session.line_down("the node restarts")
    assert rig.session.phase is CameraPhase.NO_LINE
    with pytest.raises(RefusedError, match="the node restarts"):
        rig.session.power(True, rig.now)
    before = len(rig.heard)
    rig.session.line_up(rig.now)
    rig.ready()
    assert rig.true_place == place and "58 30" not in rig.heard[before:]


@either
def test_the_end_leaves_it_on_unless_it_is_to_be_off(rig):
    stays = rig().ready()
    stays.session.end(stays.now)
    assert stays.session.ended and stays.run(1.0).camera.is_on
    goes = rig(power_off_at_end=True).ready()
    goes.session.look(400, 0, goes.now)
    goes.run(0.2)
    goes.session.end(goes.now)
    assert goes.until(lambda: goes.session.ended) < 3.0 and not goes.camera.is_on
    goes.session.line_up(goes.now)
    assert goes.session.ended


@either
def test_a_camera_that_moves_at_the_end_is_stopped(rig):
    rig = rig(pan_speed=100).ready()
    rig.session.look(800, 0, rig.now)
    rig.session.zoom_to(1900, rig.now)
    rig.run(1.0)
    rig.session.end(rig.now)
    assert rig.session.ended
    place = rig.run(0.5).true_place
    assert rig.run(3.0).true_place == place and 50 < place[0] < 200


def test_the_end_of_a_silent_camera_comes_anyway():
    rig = DirectRig(power_off_at_end=True).ready()
    rig.camera.fail(silent=True)
    rig.session.end(rig.now)
    assert rig.until(lambda: rig.session.ended) < 4.0
    rig = DirectRig(power_off_at_end=True).ready()
    rig.session.end(rig.now)
    rig.session.line_down("gone")
    assert rig.session.ended


@pytest.mark.parametrize("port", [1, 2, 3])
def test_each_auxiliary_port(port):
    rig = AuxRig(port=port).ready()
    rig.session.look(100, 0, rig.now)
    assert rig.rests()[0] == 100


def test_the_packets_of_an_exchange_are_those_of_the_sheet():
    rig = AuxRig().ready()
    rig.run(3.0)
    rig.sent.clear()
    rig.session.look(-400, 178, rig.now)
    rig.run(1.5)
    golden = [bytes.fromhex(text).hex(" ") for text in (
        "FA FB 06 2B 3B 00 00 2B 3B",
        "FA FB 13 2A 2B 0E FF 30 30 00 62 37 45 37 30 38 30 42 32 EF 52 7C",
        "FA FB 06 2B 3B 06 00 31 3B",
        "FA FB 06 2B 3B 00 00 2B 3B",
        "FA FB 0B 2A 2B 06 FF 30 30 00 63 EF 61 52",
        "FA FB 06 2B 3B 06 00 31 3B",
        "FA FB 06 2B 3B 08 00 33 3B")]
    sent = [command.hex(" ") for command in rig.sent]
    begin = sent.index(golden[1]) - 1
    assert sent[begin:begin + len(golden)] == golden


def test_the_robot_drives_as_ever_while_the_camera_starts():
    rig = AuxRig()
    start, begun = rig.robot.firmware.true_pose[0], rig.now
    while rig.session.phase is not CameraPhase.READY:
        rig.robot.drive.set_velocity(0.3, 0.0, rig.now)
        rig.step()
        if rig.now > begun + 1.5:
            assert rig.robot.firmware.velocity[0] == pytest.approx(0.3, abs=0.01)
    assert rig.robot.firmware.true_pose[0] - start > 0.5


@pytest.mark.parametrize("seed", range(12))
def test_whatever_happens_it_raises_nothing_and_is_ready_when_all_is_well_again(seed):
    rng = random.Random(seed)
    rig = (DirectRig, AuxRig)[seed % 4 == 3](answers=seed % 3 != 0)
    session, camera = rig.session, rig.camera
    events = (
        lambda: session.look(rng.randint(-2000, 2000), rng.randint(-2000, 2000), rig.now),
        lambda: session.zoom_to(rng.randint(-100, 3000), rig.now),
        lambda: session.home(rig.now), lambda: session.stop(rig.now),
        lambda: session.power(rng.random() < 0.7, rig.now),
        lambda: camera.fail(silent=rng.random() < 0.5, busy=rng.random() < 0.3, menu_open=rng.random() < 0.2),
        lambda: camera.fail(noise=bytes(rng.randrange(256) for _ in range(3)), cut_us=rng.choice((0, 50000, 900000))),
        lambda: camera.switch(rng.random() < 0.5), camera.restart,
        lambda: session.receive(bytes(rng.choice((0xFE, 0x30, 0xEF, 0x31)) for _ in range(12)), rig.now),
        lambda: (session.line_down("cut"), rig.run(rng.random()), session.line_up(rig.now)))
    for _ in range(60):
        with contextlib.suppress(RefusedError):
            rng.choice(events)()
        rig.run(rng.random())
        pan, tilt, zoom = rig.true_place
        assert abs(pan) <= 889 and -267 <= tilt <= 800 and 0 <= zoom <= 1960
    camera.fail(silent=False, busy=False, menu_open=False, noise=b"", cut_us=0)
    session.power(True, rig.now)
    rig.run(20.0)
    session.look(100, 50, rig.now)
    session.zoom_to(300, rig.now)
    rig.run(10.0)
    assert session.phase is CameraPhase.READY and rig.true_place == (100, 50, 300)

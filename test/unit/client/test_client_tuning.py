"""Settings of the robot: legal values, the packets for them and their times, and the reported results."""

import math
from dataclasses import fields, replace

import pytest

from pioneer_control import p2os
from pioneer_control.client import Change, Robot, Tuned, Tuning
from pioneer_control.client.tuner import AGAIN
from pioneer_control.client.tuning import ROWS
from pioneer_control.errors import LinkLostError, ParameterError

from fake_robot import Bench, FakeRobot, config

# A value for each field, and its bytes: those of the protocol's examples where it has one, else read from its tables.
GOLDEN = {
    "max_linear_acceleration": (0.3, "FA FB 06 05 3B 2C 01 31 3C"),
    "max_linear_deceleration": (0.3, "FA FB 06 05 1B 2C 01 31 1C"),
    "max_angular_acceleration": (math.radians(100), "FA FB 06 17 3B 64 00 7B 3B"),
    "max_angular_deceleration": (math.radians(100), "FA FB 06 17 1B 64 00 7B 1B"),
    "rotation_kp": (41, "FA FB 06 52 3B 29 00 7B 3B"),
    "rotation_kv": (21, "FA FB 06 53 3B 15 00 68 3B"),
    "rotation_ki": (1, "FA FB 06 54 3B 01 00 55 3B"),
    "translation_kp": (42, "FA FB 06 55 3B 2A 00 7F 3B"),
    "translation_kv": (31, "FA FB 06 56 3B 1F 00 75 3B"),
    "translation_ki": (2, "FA FB 06 57 3B 02 00 59 3B"),
    "bump_stall": (3, "FA FB 06 2C 3B 03 00 2F 3B"),
    "ticks_mm": (132, "FA FB 06 5D 3B 84 00 E1 3B"),
    "drift_factor": (-7, "FA FB 06 59 1B 07 00 60 1B"),
    "rev_count": (16600, "FA FB 06 58 3B D8 40 30 7B"),
    "sonar_cycle": (0.04, "FA FB 06 30 3B 28 00 58 3B"),
    "sonar_polling": ((0, 1, 0, 1), "FA FB 09 03 2B 04 01 02 01 02 09 2F"),
}
ALL = Tuning(**{name: value for name, (value, _) in GOLDEN.items()})


class TunedRobot(FakeRobot):
    """Accepts settings within its limits, shows them in CONFIGpac, and forgets them at CLOSE."""

    SHOWN = {
        "SETA": ("translation_acceleration_mm_s2", "translation_deceleration_mm_s2"),
        "SETRA": ("rotation_acceleration_deg_s2", "rotation_deceleration_deg_s2"),
        "ROTKP": "rotation_kp", "ROTKV": "rotation_kv", "ROTKI": "rotation_ki",
        "TRANSKP": "translation_kp", "TRANSKV": "translation_kv", "TRANSKI": "translation_ki",
        "TICKSMM": "ticks_per_mm", "DRIFTFACTOR": "drift_factor", "REVCOUNT": "rev_count",
        "SONARCYCLE": "sonar_cycle_ms",
    }

    def _obey(self, heard, now):
        if heard.name in self.SHOWN and self.config is not None:
            name, value = self.SHOWN[heard.name], heard.value
            if isinstance(name, tuple):
                name, value = name[value < 0], min(abs(value), 2000)
            if getattr(self.config, name) is not None:
                self.config = replace(self.config, **{name: value})
        super()._obey(heard, now)


def tuned(bench):
    return [event for event in bench.events if isinstance(event, Tuned)]


def changes(bench):
    """Return the changes of the only event, by name."""
    event, = tuned(bench)
    return {change.name: change for change in event.changes}


def until_tuned(bench, times=1):
    bench.run_until(lambda: len(tuned(bench)) == times)
    return bench


def names_of_settings(robot):
    return [heard.name for heard in robot.heard if heard.name in {row.command for row in ROWS.values()}]


def tune(bench, **values):
    """Change some of the settings."""
    bench.use(tuning=replace(bench.session._link.settings.tuning, **values))
    bench.act()


# Values

def packets(tuning):
    return tuple(ROWS[name].packet(value) for name, value in tuning.values.items())


def test_every_field_has_golden_bytes():
    assert set(GOLDEN) == {field.name for field in fields(Tuning)}


@pytest.mark.parametrize("name", GOLDEN)
def test_a_value_is_its_golden_bytes(name):
    value, golden = GOLDEN[name]
    assert packets(Tuning(**{name: value})) == (bytes.fromhex(golden),)


def test_nothing_given_is_nothing_sent():
    assert packets(Tuning()) == ()


def test_all_of_it_goes_in_the_order_of_the_table():
    assert packets(ALL) == tuple(bytes.fromhex(golden) for _, golden in GOLDEN.values())


@pytest.mark.parametrize("name, value, legal", [
    ("max_linear_acceleration", 0.0, "0.001 to 32.767 m/s\\^2"),
    ("max_linear_acceleration", -0.3, "0.001 to 32.767 m/s\\^2"),
    ("max_linear_acceleration", 33.0, "m/s"), ("max_linear_acceleration", 10 ** 400, "m/s"),
    ("max_linear_deceleration", math.nan, "m/s"), ("max_linear_deceleration", math.inf, "m/s"),
    ("max_angular_acceleration", 0.001, "0.01745 to 571.892 rad/s\\^2"),
    ("max_angular_deceleration", True, "rad/s"), ("max_angular_deceleration", "1", "rad/s"),
    ("rotation_kp", -1, "a whole number from 0 to 65535"), ("rotation_kv", 1.5, "whole"),
    ("translation_ki", 65536, "0 to 65535"),
    ("bump_stall", 4, "0 to 3"), ("bump_stall", -1, "0 to 3"), ("bump_stall", False, "0 to 3"),
    ("ticks_mm", 0, "1 to 65535"), ("rev_count", 0, "1 to 65535"),
    ("drift_factor", -32768, "-32767 to 32767"), ("drift_factor", 10 ** 400, "32767"),
    ("sonar_cycle", 0.001, "0.002 to 0.12 s"), ("sonar_cycle", 0.121, "0.002 to 0.12 s"),
    ("sonar_cycle", math.nan, "0.12 s"),
    ("sonar_polling", (), "a tuple of sonar numbers from 0 to 31"), ("sonar_polling", (32,), "0 to 31"),
    ("sonar_polling", (-1,), "0 to 31"), ("sonar_polling", (1.0,), "0 to 31"), ("sonar_polling", (True,), "0 to 31"),
    ("sonar_polling", [1], "a tuple"), ("sonar_polling", 1, "a tuple"),
    ("sonar_polling", (8,) + (3,) * 17, "at most 16 of each array of 8"),
])
def test_what_is_illegal_is_named_with_what_is_legal(name, value, legal):
    with pytest.raises(ParameterError, match="%s is .*legal: .*%s" % (name, legal)):
        Tuning(**{name: value})


@pytest.mark.parametrize("name, value", [
    ("max_linear_acceleration", 0.001), ("max_linear_acceleration", 32), ("max_angular_acceleration", math.radians(1)),
    ("rotation_kp", 0), ("rotation_kp", 65535), ("bump_stall", 0), ("drift_factor", -32767), ("ticks_mm", 65535),
    ("sonar_cycle", 0.002), ("sonar_cycle", 0.12), ("sonar_polling", (31,)), ("sonar_polling", (0, 8, 16, 24) * 16)])
def test_the_ends_of_a_range_are_legal(name, value):
    packet, = packets(Tuning(**{name: value}))
    assert p2os.decode_command(p2os.FrameDecoder().feed(packet)[0]).name == ROWS[name].command


@pytest.mark.parametrize("change, said", [
    (Change("ticks_mm", "", 132, 128, 132), "ticks_mm 128 -> 132"),
    (Change("max_linear_acceleration", "m/s^2", 5.0, 0.3, 2.0, "the robot did not take it"),
     "max_linear_acceleration 0.3 m/s^2 -> 2 m/s^2, wanted 5 m/s^2: the robot did not take it"),
    (Change("bump_stall", "", 3, None, None), "bump_stall set to 3"),
    (Change("sonar_polling", "", (0, 4), None, None), "sonar_polling set to 0, 4"),
    (Change("ticks_mm", "", 132, None, None, "too old"), "ticks_mm ? -> ?, wanted 132: too old"),
])
def test_a_change_says_what_became_of_it(change, said):
    assert str(change) == said


# After connecting

def test_all_of_it_is_sent_once_the_robot_stands_and_read_back():
    bench = until_tuned(Bench(TunedRobot(), tuning=ALL).until_ready())
    assert {name: change.problem for name, change in changes(bench).items()} == dict.fromkeys(GOLDEN, "")
    for name, (value, _) in GOLDEN.items():
        change = changes(bench)[name]
        assert change.wanted == value
        assert ROWS[name].config is None or change.new == pytest.approx(value, abs=0.01)
    assert changes(bench)["ticks_mm"].old == 128 and changes(bench)["max_linear_acceleration"].old == pytest.approx(0.3)
    identity = bench.session.connected.identity
    assert identity.config.ticks_per_mm == 132 and tuned(bench)[0].identity is identity
    assert names_of_settings(bench.robot)[:len(ROWS)] == [row.command for row in ROWS.values()]


def test_nothing_to_set_says_and_sends_nothing():
    bench = Bench(TunedRobot()).until_ready()
    bench.run(3.0)
    assert names_of_settings(bench.robot) == [] and tuned(bench) == []


def test_a_robot_that_still_rolls_is_not_tuned_before_it_stands():
    robot = TunedRobot()
    robot.coasts = True
    bench = Bench(robot, tuning=Tuning(ticks_mm=132)).until_ready()
    bench.run(1.0)
    assert names_of_settings(robot) == []
    tune(bench, rev_count=9)
    bench.run(0.5)
    assert names_of_settings(robot) == []
    robot.coasts = False
    until_tuned(bench)
    assert (robot.config.ticks_per_mm, robot.config.rev_count) == (132, 9)


def test_it_comes_after_open_and_with_motors_off():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(ticks_mm=132)).until_ready())
    names = bench.robot.names()
    assert names.index("ENABLE") < names.index("TICKSMM") and not bench.robot.motors


def test_one_value_takes_two_packets_and_no_more():
    bench = until_tuned(Bench(TunedRobot()).until_ready(), times=0)
    bench.robot.heard.clear()
    tune(bench, rev_count=16600)
    until_tuned(bench)
    bench.run(2.0)
    assert [name for name in bench.robot.names() if name in ("REVCOUNT", "CONFIG")] == ["REVCOUNT", "CONFIG"]


def test_what_is_lost_is_sent_again():
    robot = TunedRobot()
    bench = Bench(robot).until_ready()
    bench.run(0.5)
    lost = bench.now
    robot.deaf = lambda heard: heard.time <= lost + 0.5 and heard.name in ("SETA", "CONFIG")
    tune(bench, max_linear_acceleration=0.5, ticks_mm=132)
    until_tuned(bench)
    assert [change.problem for change in tuned(bench)[0].changes] == ["", ""]
    assert robot.config.translation_acceleration_mm_s2 == 500


def test_what_no_robot_reports_is_said_more_than_once():
    bench = Bench(TunedRobot(), tuning=Tuning(bump_stall=2)).until_ready()
    until_tuned(bench)
    assert names_of_settings(bench.robot).count("BUMPSTALL") == 4
    assert changes(bench)["bump_stall"] == Change("bump_stall", "", 2, None, None)
    bench.robot.heard.clear()
    bench.run(3.0)
    assert names_of_settings(bench.robot) == []


def test_a_value_that_the_robot_does_not_take_is_said():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(max_linear_acceleration=5.0)).until_ready())
    change = changes(bench)["max_linear_acceleration"]
    assert (change.wanted, change.old, change.new) == (5.0, pytest.approx(0.3), 2.0)
    assert "did not take it" in change.problem


def test_a_robot_that_no_longer_answers_config_is_said():
    bench = Bench(TunedRobot()).until_ready()
    bench.robot.deaf = lambda heard: heard.name == "CONFIG"
    tune(bench, ticks_mm=132)
    until_tuned(bench)
    assert changes(bench)["ticks_mm"].new is None and "does not report it" in changes(bench)["ticks_mm"].problem


@pytest.mark.parametrize("subtype, unknown", [
    ("p3dx-sh", []), ("amigo-sh", []), ("p3dx", ["ticks_mm", "drift_factor"]),
    ("p2dx", ["ticks_mm", "drift_factor", "sonar_cycle"]), ("amigo", ["ticks_mm", "drift_factor", "sonar_cycle"]),
    ("pion1m", list(GOLDEN)[:-1])])
def test_firmware_too_old_for_a_command_is_said_and_never_hears_it(subtype, unknown):
    robot = TunedRobot()
    robot.subtype = subtype
    bench = until_tuned(Bench(robot, tuning=ALL).until_ready())
    assert [name for name, change in changes(bench).items() if "does not know" in change.problem] == unknown
    assert [name for name, change in changes(bench).items() if change.problem] == unknown
    assert not {ROWS[name].command for name in unknown} & set(names_of_settings(robot))


def test_a_robot_that_lacks_a_sonar_never_hears_of_it():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(sonar_polling=(0, 16, 31))).until_ready())
    assert changes(bench)["sonar_polling"].problem == "this robot has no sonar 16, 31"
    assert names_of_settings(bench.robot) == []


def test_a_polling_order_is_sent_a_few_times_since_no_packet_shows_it():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(sonar_polling=(3, 4))).until_ready())
    assert names_of_settings(bench.robot) == ["POLLING"] * 4
    assert changes(bench)["sonar_polling"] == Change("sonar_polling", "", (3, 4), None, None)
    tune(bench, sonar_polling=None)
    until_tuned(bench, times=2)
    assert tuned(bench)[1].changes[0].problem == (
        "what it had itself is not known: it stays 3, 4 until the next connect")


def test_a_robot_without_configpac_is_told_and_it_is_said_that_nothing_comes_back():
    robot = TunedRobot()
    robot.config = None
    bench = until_tuned(Bench(robot, tuning=Tuning(rotation_kp=50)).until_ready())
    assert names_of_settings(robot) == ["ROTKP"] * 4
    problem = "sent, but the robot does not report it"
    assert changes(bench)["rotation_kp"] == Change("rotation_kp", "", 50, None, None, problem)


# At run time

def test_only_what_differs_from_before_is_sent():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(ticks_mm=132, rev_count=9)).until_ready())
    bench.robot.heard.clear()
    tune(bench, ticks_mm=132)
    bench.run(1.0)
    assert names_of_settings(bench.robot) == [] and len(tuned(bench)) == 1
    tune(bench, ticks_mm=133)
    until_tuned(bench, times=2)
    assert names_of_settings(bench.robot) == ["TICKSMM"]
    assert tuned(bench)[1].changes == (Change("ticks_mm", "", 133, 132, 133),)


def test_what_is_left_open_again_goes_back_to_what_the_robot_had():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(ticks_mm=132, max_angular_acceleration=0.5)).until_ready())
    bench.robot.heard.clear()
    tune(bench, ticks_mm=None, max_angular_acceleration=None)
    until_tuned(bench, times=2)
    assert (bench.robot.config.ticks_per_mm, bench.robot.config.rotation_acceleration_deg_s2) == (128, 100)
    problems = {change.name: change.problem for change in tuned(bench)[1].changes}
    assert problems == {"ticks_mm": "", "max_angular_acceleration": ""}
    sent = names_of_settings(bench.robot)
    tune(bench, rev_count=9)
    until_tuned(bench, times=3)
    assert names_of_settings(bench.robot) == sent + ["REVCOUNT"]


def test_what_cannot_go_back_is_said_once():
    bench = until_tuned(Bench(TunedRobot(), tuning=Tuning(bump_stall=1)).until_ready())
    bench.robot.heard.clear()
    tune(bench, bump_stall=None)
    tune(bench, bump_stall=None)
    bench.run(3.0)
    assert names_of_settings(bench.robot) == []
    change, = tuned(bench)[1].changes
    assert len(tuned(bench)) == 2 and change.name == "bump_stall" and "stays 1 until the next connect" in str(change)
    tune(bench, bump_stall=1)
    until_tuned(bench, times=3)


@pytest.mark.parametrize("beside", [{}, {"ticks_mm": 132}])
def test_what_cannot_go_back_and_is_left_open_again_at_once_is_sent_no_more(beside):
    bench = Bench(TunedRobot()).until_ready()
    bench.run(1.0)
    tune(bench, bump_stall=1, **beside)
    tune(bench, bump_stall=None)
    bench.run(3.0)
    assert names_of_settings(bench.robot) == ["BUMPSTALL"] + ["TICKSMM"] * len(beside)
    said = [str(change) for event in tuned(bench) for change in event.changes]
    assert "stays 1 until the next connect" in said[0] and said[1:] == ["ticks_mm 128 -> 132"] * len(beside)
    assert len(tuned(bench)) == len(said)


def test_what_never_went_to_old_firmware_need_not_go_back():
    robot = TunedRobot()
    robot.subtype = "p3dx"
    robot.config = config(ticks_per_mm=None, shutdown_dv=None, firmware_version=None)
    bench = until_tuned(Bench(robot, tuning=Tuning(ticks_mm=132)).until_ready())
    tune(bench, ticks_mm=None)
    bench.run(3.0)
    assert len(tuned(bench)) == 1 and names_of_settings(robot) == []


def test_a_value_from_before_the_link_and_one_from_during_the_handshake_are_both_sent():
    bench = Bench(TunedRobot(), tuning=Tuning(ticks_mm=132))
    bench.run(0.3)
    assert not bench.session.connected
    tune(bench, rev_count=9)
    until_tuned(bench.until_ready())
    assert (bench.robot.config.ticks_per_mm, bench.robot.config.rev_count) == (132, 9)


def test_a_flood_of_values_builds_up_no_queue_and_the_last_one_counts():
    bench = Bench(TunedRobot(), rates=(9600,)).until_ready()
    bench.run(0.5)
    for ticks in range(1, 2001):
        tune(bench, ticks_mm=ticks)
        assert bench.session.line.waiting <= 3
        if not ticks % 20:
            bench.step()
    until_tuned(bench, times=len(tuned(bench)) + 1)
    assert bench.robot.config.ticks_per_mm == 2000 and tuned(bench)[-1].changes[0].problem == ""
    assert names_of_settings(bench.robot).count("TICKSMM") < 100


def test_a_full_queue_is_not_made_longer_and_what_found_no_place_follows():
    bench = Bench(TunedRobot(), rates=(9600,)).until_ready()
    bench.run(0.5)
    while not bench.session.line.full:
        bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    waiting = bench.session.line.waiting
    tune(bench, ticks_mm=132)
    assert bench.session.line.waiting == waiting
    until_tuned(bench)
    assert bench.robot.config.ticks_per_mm == 132


def test_the_session_wakes_for_the_next_round():
    bench = Bench(TunedRobot(), pulse=0).until_ready()
    bench.run(0.5)
    bench.robot.deaf = lambda heard: True
    tune(bench, ticks_mm=132)
    start = bench.now
    bench.run(0.1)
    assert bench.session.wake_at == pytest.approx(start + AGAIN)


def test_a_stop_overtakes_a_whole_tuning_on_a_slow_line():
    bench = Bench(TunedRobot(), rates=(9600,)).until_driving(0.3)
    bench.use(tuning=ALL)
    bench.session.connected.drive.stop(bench.now)
    bench.step()
    assert not bench.robot.moving and len(names_of_settings(bench.robot)) <= 1
    until_tuned(bench)


def test_a_new_configpac_brings_new_limits():
    bench = Bench(TunedRobot()).until_ready()
    bench.robot.config = config(translation_velocity_max_mm_s=400, rotation_velocity_max_deg_s=30, watchdog_ms=1000)
    tune(bench, rotation_ki=1)
    until_tuned(bench)
    identity = bench.session.connected.identity
    assert identity.max_linear == pytest.approx(0.4) and identity.watchdog == 1.0
    assert bench.session.line.watchdog < 1.0
    bench.drive(2.0, 2.0)
    assert (bench.robot.set_point["VEL"], bench.robot.set_point["RVEL"]) == (400, 30)
    bench.session.connected.drive.set_wheel_velocities(2.0, 2.0, bench.now)
    bench.step()
    assert bench.robot.set_point["VEL"] == 400


def test_a_link_that_breaks_amid_it_says_nothing_of_it():
    bench = Bench(TunedRobot()).until_ready()
    tune(bench, bump_stall=1)
    bench.session.fail(LinkLostError("pulled"))
    bench.act()
    assert bench.finished and tuned(bench) == []


def test_a_robot_takes_a_tuning_without_a_link():
    robot = Robot("/dev/nonesuch", tuning=Tuning(ticks_mm=132))
    robot.tune(replace(robot.tuning, rev_count=9))
    assert robot.tuning == Tuning(ticks_mm=132, rev_count=9)

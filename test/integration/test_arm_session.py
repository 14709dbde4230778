"""The session of an arm with the simulated arm: every command, every limit, and every way to fail (arm sheet 18)."""

import math
import random
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import fuzz_arm
from arm_rig import SPEEDS, ArmRig

from pioneer_control import p2os
from pioneer_control.arm.findings import finding
from pioneer_control.arm.joints import JOINT_NAMES, JointSettings
from pioneer_control.arm.kinematics import forward
from pioneer_control.arm.motion import Point
from pioneer_control.arm.orders import CONFIRM_TIME, HOME_TIME, Park
from pioneer_control.arm.phases import ArmSettings
from pioneer_control.client.fault_flags import Level
from pioneer_control.errors import LinkError, RefusedError, UsageError

BASE, SHOULDER, ELBOW, ROLL, WRIST, GRIPPER = JOINT_NAMES
HOME = [130, 37, 235, 130, 183, 180]
MOVES = {"ARM_POWER", "ARM_POS", "ARM_HOME", "ARM_PARK"}


def ticks(rig):
    return [servo.position for servo in rig.arm.servos]


def go(rig, seconds=0.0, **positions):
    """Move joints, given by the middle of their names, and wait until they are there."""
    names = ["arm_%s_joint" % name for name in positions]
    return rig.finish(rig.session.move(names, [Point(list(positions.values()), seconds)], rig.now))


# -- when it is found

@pytest.mark.parametrize("layout", ["A", "M"])
@pytest.mark.parametrize("told", [None, "told"])
def test_it_finds_the_arm_and_moves_nothing(layout, told):
    rig = ArmRig(layout=layout, settings=ArmSettings(SPEEDS, layout if told else None)).wait(10.0)
    assert (rig.condition, rig.session.phase.reader.layout) == ("off", layout)
    assert not MOVES & set(rig.names) and not rig.arm.powered and ticks(rig) == HOME
    assert rig.sent[:2] == [("ARM_STATUS", 2), ("ARM_INFO", None)]
    assert rig.notices == ["found an arm, version 1.7, with 6 joints"]
    assert list(rig.positions) == list(JOINT_NAMES)
    assert rig.positions[SHOULDER] == pytest.approx(math.radians(79.714), abs=1e-4)
    # asked once for a continuous status: asking again might count as a command for the autopark timer
    assert rig.names.count("ARM_STATUS") == 1


@pytest.mark.parametrize("layout, told", [("A", "M"), ("M", "A")])
def test_a_layout_that_the_user_has_wrong_is_seen_before_anything_is_sent(layout, told):
    """Taken for an arm that is not connected, it would get a reset, and fall down if it has power."""
    rig = ArmRig(layout=layout, settings=ArmSettings(SPEEDS, told)).wait(5.0)
    assert rig.condition == "none" and "ARM_INIT" not in rig.names
    assert "its status packets do not have the layout %s that the parameter arm_layout says" % told in rig.notices[0]


def test_both_timers_and_slow_speeds_are_set_before_anybody_asks_for_power():
    rig = ArmRig(settings=ArmSettings(SPEEDS, autopark=120, grippark=90))
    assert rig.sent[2:] == [("ARM_AUTOPARK", 120), ("ARM_GRIPPARK", 90)] + [
        ("ARM_SPEED", joint << 8 | speed) for joint, speed in enumerate((30, 30, 30, 30, 30, 21), 1)]


def test_a_robot_without_an_arm():
    rig = ArmRig(arm=False).wait(5.0)
    assert rig.condition == "none" and rig.notices == ["there is no arm: the robot reports that it has no arm"]
    assert rig.sent == [("ARM_STATUS", 2), ("ARM_INFO", None), ("ARM_STATUS", 0)]
    with pytest.raises(RefusedError, match="power on refused: the robot reports that it has no arm"):
        rig.session.power_on(rig.now)
    with pytest.raises(RefusedError, match="stop refused: the robot reports"):
        rig.session.stop(rig.now)


def test_a_robot_that_says_nothing_of_an_arm_is_asked_twice():
    rig = ArmRig(connect=False)
    rig.from_robot = lambda packet: False
    rig.session.connected(None, rig.now)
    rig.wait(1.9)
    assert rig.condition == "looking" and rig.names == ["ARM_STATUS", "ARM_INFO"] * 2
    rig.wait(0.5)
    assert rig.condition == "none"
    assert rig.notices == ["there is no arm: the robot did not say within 2 s that it has an arm"]


def test_information_without_status_is_no_arm():
    rig = ArmRig(connect=False)
    rig.from_robot = lambda packet: not isinstance(packet, p2os.Arm)
    rig.session.connected(None, rig.now)
    assert rig.wait(3.0).notices == ["there is no arm: the arm sent no status within 2 s"]


@pytest.mark.parametrize("lost", ["ARM_STATUS", "ARM_INFO"])
def test_one_lost_question_does_not_matter(lost):
    rig = ArmRig(connect=False)
    left = [lost]
    rig.to_robot = lambda command: not (command.name in left and left.remove(command.name) is None)
    rig.session.connected(None, rig.now)
    rig.wait(3.0)
    assert rig.condition == "off"


def test_an_unlinked_arm_is_reset_once_and_found():
    rig = ArmRig(linked_at_power_on=False).wait(2.0)
    assert rig.condition == "off" and rig.names.count("ARM_INIT") == 1 and not MOVES & set(rig.names)
    # a reset takes the speeds away: they are set after it
    assert [servo.speed_ms for servo in rig.arm.servos] == [30] * 5 + [21]


def test_an_arm_whose_switch_is_off_is_said_and_can_be_reset_later():
    rig = ArmRig(connect=False)
    rig.arm.switch(False)
    rig.session.connected(None, rig.now)
    rig.wait(10.0)
    assert rig.condition == "not connected" and rig.names.count("ARM_INIT") == 1
    assert ("arm: init failed: the arm's controller does not answer: is the arm's switch on, and its cable in?"
            in rig.notices)
    assert finding(rig.session, rig.now).level is Level.WARN
    with pytest.raises(RefusedError, match="power on refused: the arm's controller does not answer. Is its switch on"):
        rig.session.power_on(rig.now)
    rig.arm.switch(True)
    rig.finish(rig.session.init(rig.now))
    assert rig.powered().condition == "on"


def test_an_arm_that_moves_at_connect_is_found_when_its_layout_is_clear():
    rig = ArmRig(layout="M").powered()
    rig.session.move([BASE, SHOULDER, ELBOW], [Point([1.5, 0.2, 0.0], 0.0)], rig.now)
    rig.wait(0.5)
    assert [servo.moving for servo in rig.arm.servos] == [True] * 3 + [False] * 3
    rig.session.disconnected(rig.now)
    rig.session.connected(None, rig.now)
    rig.wait(1.0)
    assert rig.condition == "looking"       # as layout A this would be: joints 1 and 2 move
    rig.until(lambda: rig.condition == "on").wait(0.2)
    assert rig.session.phase.reader.layout == "M"
    assert "the arm has servo power already; nobody has asked this driver for it" in rig.notices


# -- power

@pytest.mark.parametrize("first, second", [(0x82, 0x00), (0x02, 0x3F), (0x00, 0x13), (0x03, 0x07)])
def test_status_packets_that_tell_no_layout_are_said_once(first, second):
    """Such as one with a bit that nobody has explained. With the parameter arm_layout they are read all the same."""
    for layout in (None, "M"):
        rig = ArmRig(settings=ArmSettings(SPEEDS, layout=layout), connect=False)
        rig.session.connected(None, rig.now)
        rig.session.packet(p2os.ArmInfo("1.7", (p2os.packets.ArmJoint(20, 130, 25, 130, 235, 105),) * 6), rig.now)
        notices = []
        for _ in range(60):
            rig.now += 0.1
            rig.session.packet(p2os.Arm(first, second, (130,) * 6), rig.now)
            rig.session.tick(rig.now)
            notices += [notice.text for notice in rig.session.take_notices()]
        if layout is None:
            text = ("the arm's status packets (%02X %02X) do not tell their layout: it moves, or the parameter"
                    " arm_layout must say it (A or M)" % (first, second))
            assert (rig.condition, rig.session.phase.text, notices) == ("looking", text, [text])
            assert finding(rig.session, rig.now)[:2] == (Level.WARN, text)
            rig.session.packet(p2os.Arm(2, 0, (130,) * 6), rig.now)
        assert rig.condition in ("off", "on", "moving", "not connected")


def test_power_on_sets_speeds_first_then_waits_for_the_arm():
    rig = ArmRig()
    rig.sent.clear()
    begun = rig.now
    order = rig.session.power_on(rig.now)
    rig.wait(0.5)
    assert rig.names.index("ARM_SPEED") < rig.names.index("ARM_POWER") and rig.arm.powered
    assert rig.condition == "powering on" and order.under_way
    with pytest.raises(RefusedError, match="motion refused: power on is under way"):
        rig.session.move([BASE], [Point([0.1], 1.0)], rig.now)
    rig.finish(order)
    assert 2.0 <= rig.now - begun < 2.5 and rig.condition == "on"
    assert "keep clear: the arm gets servo power and jumps to its home position" in rig.notices
    assert rig.powered().names.count("ARM_POWER") == 1


def test_power_that_is_not_confirmed_is_a_failure_and_the_arm_is_told_to_park():
    rig = ArmRig()
    rig.to_robot = lambda command: command.name != "ARM_POWER"
    rig.finish(rig.session.power_on(rig.now), "did not confirm within 2 s that its servo power is on")
    assert rig.wait(0.2).names[-1] == "ARM_PARK" and rig.condition == "off"


def test_power_that_goes_off_again_is_a_failure():
    rig = ArmRig()
    order = rig.session.power_on(rig.now)
    rig.wait(0.5)
    rig.arm.cut_power()
    rig.finish(order, "the servo power went off again")


def test_nothing_moves_without_power():
    rig = ArmRig()
    for command in (lambda: rig.session.home(rig.now), lambda: rig.session.move([BASE], [Point([0.1], 1.0)], rig.now)):
        with pytest.raises(RefusedError, match="refused: the servos have no power. Keep clear of the arm, then"):
            command()
    rig.finish(rig.session.park(rig.now))
    assert not MOVES & set(rig.wait(1.0).names)


def test_park_is_the_only_power_off_and_drops_nothing():
    rig = go(ArmRig().powered(), shoulder=0.2, elbow=0.0)
    rig.finish(rig.session.park(rig.now))
    assert not rig.arm.powered and rig.arm.drops == 0 and ("ARM_POWER", 0) not in rig.sent
    assert rig.condition == "off" and rig.positions[ELBOW] == pytest.approx(-math.pi / 2)


def test_park_begins_with_a_stop():
    rig = ArmRig().powered()
    rig.sent.clear()
    assert rig.finish(rig.session.park(rig.now)).names == ["ARM_STOP", "ARM_PARK"]


def test_park_just_after_power_on_does_not_leave_the_power_on():
    rig = ArmRig()
    power = rig.session.power_on(rig.now)
    order = rig.session.park(rig.now)
    rig.finish(order).wait(1.0)
    assert power.problem == "park took its place" and not rig.arm.powered and rig.condition == "off"


# -- motion

def test_every_joint_goes_where_it_is_told():
    rig = ArmRig().powered()
    wanted = {"base": 0.6, "shoulder": 0.3, "elbow": -0.4, "roll": 0.7, "wrist": 0.2, "gripper": 0.01}
    go(rig, 2.0, **wanted)
    for name, value in wanted.items():
        joint = rig.session.phase.joints["arm_%s_joint" % name]
        assert rig.positions[joint.name] == pytest.approx(value, abs=abs(joint.unit) / 2 + 1e-9)
        assert rig.arm.servos[joint.number - 1].position == joint.tick(value)
    assert forward([rig.positions[name] for name in JOINT_NAMES[:5]]).position == pytest.approx(
        forward([wanted[name[4:-6]] for name in JOINT_NAMES[:5]]).position, abs=0.01)


def test_a_motion_keeps_to_its_times():
    rig = ArmRig().powered()
    begun = rig.now
    order = rig.session.move([BASE, WRIST], [Point([0.3, -0.5], 1.0), Point([0.3, -0.5], 3.0), Point([0.0, -0.8], 5.0)],
                             rig.now)
    rig.wait(2.0)
    assert rig.positions[BASE] == pytest.approx(0.3, abs=0.01) and rig.condition == "moving"
    rig.finish(order)
    assert rig.now - begun == pytest.approx(5.0, abs=0.5)
    assert rig.positions[BASE] == pytest.approx(0.0, abs=0.01)


def test_speed_of_a_slow_motion():
    rig = ArmRig().powered()
    rig.session.move([BASE], [Point([math.radians(30)], 4.0)], rig.now)
    rig.wait(2.1)
    assert rig.positions[BASE] == pytest.approx(math.radians(15), abs=0.03)


def test_limits_are_refused_and_never_sent():
    rig = ArmRig(settings=ArmSettings((JointSettings(0.5, lower=-0.5, upper=0.5), *SPEEDS[1:]))).powered()
    with pytest.raises(UsageError, match="arm_base_joint of point 0 is 0.600, and may be -0.500 to 0.500 rad"):
        rig.session.move([BASE], [Point([0.6], 1.0)], rig.now)
    assert "ARM_POS" not in rig.wait(0.5).names
    go(rig, base=0.5)
    assert ticks(rig)[0] == 130 + 33


def test_a_new_motion_takes_the_place_of_the_old_one_and_its_other_joints_stop():
    rig = ArmRig().powered()
    first = rig.session.move([BASE, WRIST], [Point([1.5, 0.5], 0.0)], rig.now)
    rig.wait(0.5)
    go(rig, base=0.0)
    assert first.problem == "motion took its place"
    assert 130 < ticks(rig)[4] < 183 and ticks(rig)[0] == 130 and not any(rig.arm.moving)


def test_orders_that_come_too_fast_wait_and_only_the_newest_is_sent():
    rig = ArmRig().powered().wait(1.0)
    rig.sent.clear()
    orders = []
    for number in range(200):       # 100 a second, for 2 s
        orders.append(rig.session.move([BASE], [Point([0.002 * number], 0.0)], rig.now))
        if number % 2:
            rig.wait(0.02)
    rig.finish(orders[-1])
    assert rig.names.count("ARM_POS") <= 12 and rig.positions[BASE] == pytest.approx(0.4, abs=0.01)
    assert {order.problem for order in orders} == {"motion took its place", ""}


def test_a_stop_overtakes_an_order_that_waits():
    rig = ArmRig().powered().wait(1.0)
    rig.session.move([BASE], [Point([0.3], 0.0)], rig.now)
    waits = rig.session.move([BASE], [Point([0.5], 0.0)], rig.now)
    for _ in range(100):
        rig.session.stop(rig.now)
    rig.wait(1.0)
    assert waits.problem == "it was stopped" and not any(rig.arm.moving) and rig.names.count("ARM_STOP") == 1
    rig.session.stop(rig.now)
    assert rig.wait(0.1).names.count("ARM_STOP") == 2


def test_stop_keeps_the_power_and_the_position():
    rig = ArmRig().powered()
    order = rig.session.move([BASE], [Point([1.0], 0.0)], rig.now)
    rig.wait(1.0)
    rig.session.stop(rig.now)
    rig.wait(0.2)
    stopped = ticks(rig)
    assert order.problem == "it was stopped" and rig.arm.powered and rig.condition == "on"
    assert ticks(rig.wait(2.0)) == stopped and 130 < stopped[0] < 196
    assert go(rig, base=0.0).condition == "on"


def test_home_brings_all_joints_home_with_power_on():
    rig = go(ArmRig().powered(), base=0.5, shoulder=0.5, gripper=0.0)
    rig.finish(rig.session.home(rig.now))
    assert ticks(rig) == HOME and rig.arm.powered and rig.condition == "on"


def test_a_joint_that_does_not_arrive_is_named_and_the_arm_stops():
    rig = ArmRig().powered()
    rig.to_robot = lambda command: not (command.name == "ARM_POS" and command.value >> 8 == 5)
    order = rig.session.move([BASE, WRIST], [Point([0.2, 0.0], 0.0)], rig.now)
    rig.finish(order, "arm_wrist_joint did not arrive in time")
    assert rig.wait(0.1).names[-1] == "ARM_STOP"
    assert "last motion failed: arm_wrist_joint did not arrive in time" in finding(rig.session, rig.now).message


@pytest.mark.parametrize("name, start, problem", [
    ("ARM_HOME", "home", "the arm was not home after %.0f s" % HOME_TIME),
    ("ARM_PARK", "park", "the servo power was still on after %.0f s" % HOME_TIME)])
def test_an_order_that_is_lost_fails(name, start, problem):
    rig = go(ArmRig().powered(), base=0.5)
    rig.to_robot = lambda command: command.name != name
    rig.finish(getattr(rig.session, start)(rig.now), problem)
    assert "arm: %s failed: %s" % (start, problem) in rig.notices


# -- things that happen to it

def test_the_switch_in_mid_session():
    rig = ArmRig().powered()
    order = rig.session.move([BASE], [Point([1.0], 0.0)], rig.now)
    rig.wait(0.5)
    rig.arm.switch(False)
    rig.finish(order, "the servo power is off")
    assert rig.condition == "not connected"
    rig.arm.switch(True)
    rig.wait(2.0)
    assert rig.condition == "not connected"
    assert rig.finish(rig.session.init(rig.now)).powered().condition == "on"


def test_the_switch_while_it_stands():
    rig = ArmRig().powered()
    rig.arm.switch(False)
    assert rig.wait(0.3).notices[-1] == "the arm's controller does not answer any more: is its switch off?"


def test_a_reset_of_an_arm_with_power_is_refused():
    rig = ArmRig().powered()
    with pytest.raises(RefusedError, match="init refused: it would take the servo power, and the arm would fall down"):
        rig.session.init(rig.now)
    assert rig.arm.powered and "ARM_INIT" not in rig.wait(0.5).names


def test_nothing_is_obeyed_during_a_reset():
    rig = ArmRig()
    rig.session.init(rig.now)
    with pytest.raises(RefusedError, match="power on refused: the arm is being reset"):
        rig.session.power_on(rig.now)


def test_an_arm_that_falls_silent_is_stopped_and_asked_again():
    rig = ArmRig().powered()
    order = rig.session.move([BASE], [Point([1.0], 0.0)], rig.now)
    rig.wait(0.5)
    rig.from_robot = lambda packet: False
    rig.wait(1.5)
    assert rig.condition == "silent" and not any(rig.arm.moving) and rig.arm.powered
    assert order.problem == "the arm has stopped sending its status"
    assert finding(rig.session, rig.now).level is Level.ERROR
    for command in (rig.session.power_on, rig.session.home, rig.session.park, rig.session.init):
        with pytest.raises(RefusedError, match="the arm has stopped sending its status"):
            command(rig.now)
    rig.session.stop(rig.now)
    asked = rig.names.count("ARM_STATUS")
    rig.wait(10.0)
    assert 4 <= rig.names.count("ARM_STATUS") - asked <= 6
    rig.from_robot = lambda packet: True
    rig.wait(0.3)
    assert rig.condition == "on" and rig.notices[-1] == "the arm sends its status again"
    assert go(rig, base=0.0).condition == "on"


@pytest.mark.parametrize("loss", [0.1, 0.4])
def test_on_a_line_that_loses_packets_every_order_ends_and_the_arm_never_falls(loss):
    rng = random.Random(6)
    rig = ArmRig()
    rig.to_robot = rig.from_robot = lambda packet: rng.random() >= loss
    done = 0
    for _ in range(15):
        for begin in (rig.session.power_on, lambda now: rig.session.move([BASE], [Point([0.2], 0.0)], now),
                      rig.session.home, rig.session.park):
            try:
                order = begin(rig.now)
            except RefusedError:        # the order before has failed, or the status is too old
                rig.wait(0.5)
                continue
            rig.until(lambda: not order.under_way, 2.0 * HOME_TIME)
            done += not order.problem
    assert done > 15 and rig.arm.drops == rig.arm.jumps == 0
    rig.to_robot = rig.from_robot = lambda packet: True
    rig.until(lambda: rig.condition in ("on", "off")).finish(rig.session.park(rig.now))
    assert not rig.arm.powered


def test_a_link_that_breaks_forgets_everything():
    rig = ArmRig().powered()
    order = rig.session.move([BASE], [Point([1.0], 5.0), Point([0.0], 9.0)], rig.now)
    rig.wait(0.5)
    rig.session.disconnected(rig.now)
    assert order.problem == "the link to the robot is gone" and rig.condition == "no link"
    assert finding(rig.session, rig.now).level is Level.STALE
    with pytest.raises(LinkError, match="motion refused: there is no link to the robot"):
        rig.session.move([BASE], [Point([0.1], 1.0)], rig.now)
    rig.sent.clear()
    rig.session.connected(None, rig.now)
    rig.wait(10.0)
    assert not MOVES & set(rig.names) and rig.condition in ("on", "moving")


def test_what_was_not_sent_before_the_link_broke_is_never_sent():
    rig = ArmRig()
    rig.session.power_on(rig.now)
    rig.session.disconnected(rig.now)
    assert rig.session.take_commands() == []


def test_an_emergency_stops_it_and_keeps_it_there():
    rig = ArmRig().powered()
    order = rig.session.move([BASE], [Point([1.0], 0.0)], rig.now)
    rig.wait(0.5)
    rig.session.hold("button", "the STOP button is pressed", rig.now)
    rig.session.hold("button", "the STOP button is pressed", rig.now)
    rig.wait(0.2)
    stopped = ticks(rig)
    assert order.problem == "it was stopped: the STOP button is pressed" and rig.arm.powered
    for command in (rig.session.power_on, rig.session.home, rig.session.park, rig.session.init,
                    lambda now: rig.session.move([BASE], [Point([0.1], 1.0)], now)):
        with pytest.raises(RefusedError, match="refused: the STOP button is pressed"):
            command(rig.now)
    rig.session.stop(rig.now)
    assert ticks(rig.wait(5.0)) == stopped
    rig.session.release("other")
    with pytest.raises(RefusedError):
        rig.session.home(rig.now)
    rig.session.release("button")
    assert ticks(rig.wait(5.0)) == stopped
    assert rig.finish(rig.session.home(rig.now)).arm.drops == 0


# -- what moves it by itself

def test_the_user_is_told_half_a_minute_before_it_parks_by_itself():
    rig = go(ArmRig(settings=ArmSettings(SPEEDS, autopark=60)).powered(), base=0.5)
    rig.notices.clear()
    assert rig.wait(27.0).notices == []
    rig.wait(3.0)
    assert rig.notices == ["keep clear: the arm parks by itself in 30 s, unless it gets a command"]
    assert rig.arm.powered and not rig.arm.parking
    rig.session.stop(rig.now)       # a command: all begins anew
    rig.wait(28.0)
    assert len(rig.notices) == 1
    rig.wait(30.0)
    assert len(rig.notices) == 2 and rig.arm.powered
    rig.wait(10.0)
    assert not rig.arm.powered and rig.condition == "off" and rig.arm.drops == 0
    assert rig.notices[2] == "the servo power of the arm went off by itself: it has parked, or was switched off"


def test_the_user_is_told_before_the_gripper_opens_by_itself():
    rig = go(ArmRig(settings=ArmSettings(SPEEDS, grippark=60)).powered(), gripper=0.0)
    rig.notices.clear()
    rig.wait(45.0)
    assert len(rig.notices) == 1 and "gripper opens by itself in about 30 s and drops what it holds" in rig.notices[0]
    assert ticks(rig)[5] == 70
    rig.wait(30.0)
    assert ticks(rig)[5] == 180 and rig.session.phase.timers.opens_at == math.inf


# -- the end

def test_the_end_of_an_arm_that_was_never_powered_takes_no_time():
    for rig in (ArmRig(), ArmRig(arm=False), ArmRig(connect=False)):
        assert not rig.session.ended
        rig.session.end(rig.now)
        assert rig.session.ended and not MOVES & set(rig.wait(1.0).names)


def test_the_end_stops_parks_and_waits_for_the_power_to_go():
    rig = ArmRig().powered()
    order = rig.session.move([BASE, SHOULDER], [Point([1.5, 0.0], 0.0)], rig.now)
    rig.wait(2.0)
    rig.session.end(rig.now)
    assert not rig.session.ended
    begun = rig.now
    rig.until(lambda: rig.session.ended)
    assert order.problem == "park took its place" and rig.now - begun < 10.0
    assert not rig.arm.powered and rig.arm.drops == 0
    assert rig.names[-2:] == ["ARM_STOP", "ARM_PARK"]
    with pytest.raises(RefusedError, match="power on refused: the driver ends"):
        rig.session.power_on(rig.now)


def test_the_end_parks_also_an_arm_that_is_held():
    rig = go(ArmRig().powered(), base=0.5)
    rig.session.hold("button", "the STOP button is pressed", rig.now)
    rig.session.end(rig.now)
    assert not rig.until(lambda: rig.session.ended).arm.powered


def test_the_end_of_a_silent_arm_is_told_and_not_waited_for():
    rig = ArmRig().powered()
    rig.from_robot = lambda packet: False
    rig.wait(2.0)
    rig.session.end(rig.now)
    assert rig.session.ended
    assert not rig.wait(8.0).arm.powered and "ARM_PARK" in rig.names


def test_the_end_just_after_power_on():
    rig = ArmRig()
    rig.session.power_on(rig.now)
    rig.session.end(rig.now)
    rig.until(lambda: rig.session.ended).wait(CONFIRM_TIME)
    assert not rig.arm.powered


def test_a_link_that_breaks_at_the_end_ends_it():
    rig = go(ArmRig().powered(), base=0.5)
    rig.session.end(rig.now)
    rig.wait(0.5)
    assert not rig.session.ended
    rig.session.disconnected(rig.now)
    assert rig.session.ended


# -- a line that lies

def test_packets_calls_and_times_of_any_kind_upset_nothing():
    """bench/fuzz_arm.py does the same a million times."""
    counts = fuzz_arm.fuzz_session(random.Random(4), 20000)
    assert counts["obeyed"] > 1000 and counts["refused"] > 1000 and counts["sent"] > 1000


def test_a_session_that_would_drop_the_arm_is_seen(monkeypatch):
    monkeypatch.setattr(Park, "begin", lambda order, status, now: (p2os.encode_command("ARM_POWER", 0),))
    with pytest.raises(AssertionError, match="ARM_POWER"):
        fuzz_arm.fuzz_session(random.Random(4), 20000)

"""A ready connection: signs of life, revival, silence, nonsense on the line, and every way to end."""

import math
import random

import pytest

from pioneer_control import p2os
from pioneer_control.client.events import PacketReceived, Ready
from pioneer_control.client.line import LONGEST_QUEUE
from pioneer_control.client.link import Failed, Left, Outcome
from pioneer_control.client.phases import TRANSITIONS, Closing, Connected, Connecting, Finished, Opening, Synced
from pioneer_control.client.session import Session
from pioneer_control.client.settings import Settings
from pioneer_control.client.state import RobotState
from pioneer_control.errors import LinkLostError, PioneerError, RefusedError

from fake_robot import OPEN, WAITING, Bench, FakeRobot, config, sip


def test_pulses_keep_an_idle_robot_awake():
    bench = Bench(pulse=1.0).until_ready()
    bench.run(0.5)
    bench.robot.heard.clear()
    bench.run(10.0)
    times = [heard.time for heard in bench.robot.heard]
    assert 9 <= len(times) <= 10
    assert max(later - earlier for earlier, later in zip(times, times[1:])) < 1.02


def test_a_sign_of_life_revives_nothing_when_every_stop_was_lost():
    bench = Bench(pulse=1.0).until_driving(0.2)
    bench.robot.deaf = lambda heard: True       # the line to the robot is broken, the one back is not
    bench.drive(0.0, 0.0)
    bench.run(3.0)
    assert bench.robot.watchdog_expired and not bench.states[-1].linear, "the robot has stopped by itself"
    bench.robot.deaf = lambda heard: False
    bench.run(2.0)
    assert "STOP" in bench.robot.names()[-2:] and not bench.robot.revived and not bench.robot.moving


@pytest.mark.parametrize("through", ["first", "second", "third", "fourth"])
def test_a_sign_of_life_revives_nothing_when_only_one_packet_of_it_comes_through(through):
    bench = Bench(pulse=1.0).until_driving(0.2)
    bench.robot.deaf = lambda heard: True
    bench.drive(0.0, 0.0)
    bench.run(3.0)
    assert bench.robot.watchdog_expired
    number = ["first", "second", "third", "fourth"].index(through)
    bench.robot.deaf = lambda heard: [each.time for each in bench.robot.heard].count(heard.time) != number + 1
    bench.robot.set_point["RVEL"] = 20
    bench.run(5.0)
    assert not bench.robot.revived and not bench.robot.moving


def test_firmware_that_may_not_know_stop_is_told_in_other_words_too():
    bench = Bench(model="pion1m", pulse=1.0).until_ready()
    bench.run(0.5)
    bench.robot.heard.clear()
    bench.run(1.2)
    assert bench.robot.names() == ["STOP", "VEL", "RVEL"]


def test_no_pulse_while_other_commands_go_out():
    bench = Bench(pulse=1.0, command_timeout=30.0).until_driving()
    bench.run(3.0)
    assert "PULSE" not in bench.robot.names()


def test_pulses_go_no_faster_than_the_line():
    bench = Bench(rates=(9600,), pulse=0.0001).until_ready()
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    bench.run(5.0)
    assert 100 < bench.robot.names().count("STOP") < 1100


def test_without_pulses_an_idle_robot_hears_nothing():
    bench = Bench(pulse=0.0).until_ready()
    bench.run(0.5)
    bench.robot.heard.clear()
    bench.run(10.0)
    assert bench.robot.heard == []


@pytest.mark.parametrize("start", [0.0, 0.01, 0.52, 1.13, 86400.3])
def test_woken_exactly_when_it_wants_to_be_it_never_spins(start):
    """Sums and differences of times are rounded: 1.03 - 0.83 is less than 0.2."""
    session, now = Session("fake", (), Settings(), start), start
    reply = p2os.SyncReply("fake", "Pioneer", "p3dx-sh")
    answers = [p2os.encode_frame(0), p2os.encode_frame(1), p2os.encode_packet(reply)]
    for answer in answers:
        now = round(now + 0.35, 2)
        session.tick(now)
        session.receive(answer, now)
    while not session.finished:      # the robot never sends a SIP: it is asked again and again, then given up
        now = session.wake_at
        session.tick(now)
        assert session.wake_at > now


def test_after_a_silence_longer_than_the_watchdog_a_stop_goes_first():
    bench = Bench(pulse=0.0, command_timeout=30.0).until_ready()
    request = bench.session.connected.drive.request_motors(True, bench.now, 2.0)
    bench.run_until(lambda: request.done)
    bench.run(5.0)
    bench.robot.set_point["VEL"] = 300          # as if it remembered
    bench.robot.watchdog_expired = True
    bench.robot.heard.clear()
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    bench.run(0.1)
    assert bench.robot.names() == ["STOP", "VEL", "RVEL", "SONAR"]
    assert not bench.robot.revived and not bench.robot.moving


def test_a_hold_up_of_the_whole_process_revives_nothing():
    bench = Bench(command_timeout=0.6).until_driving(0.2)
    bench.now += 30.0                           # nobody called, the robot's packets wait in a buffer
    bench.session.receive(bench.robot.advance(bench.now), bench.now)
    assert bench.robot.watchdog_expired
    bench.session.tick(bench.now)
    bench.run(1.0)
    assert not bench.robot.revived and not bench.robot.moving and bench.session.connected


def test_the_watchdog_is_the_robots_own():
    robot = FakeRobot()
    robot.config = config(watchdog_ms=500)
    bench = Bench(robot, pulse=0.0).until_ready()
    assert bench.session.connected.identity.watchdog == 0.5
    bench.run(0.7)
    robot.heard.clear()
    bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))
    bench.run(0.1)
    assert robot.names() == ["STOP", "VEL", "RVEL", "SONAR"]


def test_silence_of_the_robot_loses_the_link_and_it_is_told_to_stop():
    bench = Bench(command_timeout=30.0).until_driving(0.2)
    bench.robot.mute = lambda packet: True
    bench.run_until(lambda: bench.finished)
    assert isinstance(bench.session.error, LinkLostError) and "silent" in str(bench.session.error)
    bench.run(0.1)
    assert bench.robot.phase == WAITING and not bench.robot.motors


def test_a_short_silence_is_borne():
    bench = Bench().until_ready()
    bench.robot.mute = lambda packet: True
    bench.run(1.5)
    bench.robot.mute = lambda packet: False
    bench.run(3.0)
    assert bench.session.connected


@pytest.mark.parametrize("notice", ["FAFB03FF00FF", "FAFB05FE0102FF00"])
def test_a_restarted_controller_loses_the_link(notice):
    bench = Bench().until_ready()
    frame = p2os.encode_frame(bytes.fromhex(notice)[3], bytes.fromhex(notice)[4:-2])
    bench.session.receive(frame, bench.now)
    assert bench.finished and "restarted" in str(bench.session.error)


def test_other_packets_reach_the_listeners_and_unknown_ones_are_counted():
    bench = Bench().until_ready()
    encoder = p2os.Encoder(123456, -1234)
    bench.robot.send(encoder)
    bench.step()
    bench.session.receive(p2os.encode_frame(0x77, b"what"), bench.now)
    bench.session.receive(p2os.encode_frame(0x32, b"short"), bench.now)
    bench.step()
    assert bench.event(PacketReceived).packet == encoder
    assert bench.session.counts.unreadable == 2


def told(bench, *packets):
    """Return what the listeners get for packets that come in one piece."""
    bench.session.events()
    bench.now += 0.1
    bench.session.receive(b"".join(map(p2os.encode_packet, packets)), bench.now)
    return bench.session.events()


def test_each_sip_is_one_state_and_they_are_told_in_the_order_in_which_they_came():
    bench = Bench().until_ready()
    events = told(bench, sip(x_counts=100), p2os.Encoder(1, 2), sip(x_counts=110))
    assert [type(event) for event in events] == [RobotState, PacketReceived, RobotState]
    assert (events[0].x, events[2].x) == pytest.approx((0.1, 0.11))


def test_a_sip_that_comes_with_what_the_robot_was_waited_for_is_told_after_that():
    bench = Bench()
    bench.robot.config = None
    bench.run_until(lambda: isinstance(bench.session.phase, Opening) and "ENABLE" in bench.robot.names())
    bench.run(0.2)
    events = told(bench, config(), sip(x_counts=100))
    assert [type(event) for event in events] == [Ready, RobotState, RobotState]
    assert [event.x for event in events[1:]] == pytest.approx([0.0, 0.1])


def test_each_packet_is_decoded_once(monkeypatch):
    bench, decoded, decode = Bench().until_ready(), [], p2os.decode_packet
    monkeypatch.setattr(p2os, "decode_packet", lambda *frame: decoded.append(frame) or decode(*frame))
    told(bench, sip(), p2os.Encoder(1, 2))
    assert len(decoded) == 2


def test_a_sip_that_nobody_believes_has_no_state_and_counts_once():
    bench = Bench().until_ready()
    told(bench, sip(x_counts=100))
    assert told(bench, sip(x_counts=9000)) == [] and bench.session.counts.unreadable == 1
    state, = told(bench, sip(x_counts=110))
    assert state.x == pytest.approx(0.11)


def test_a_packet_that_was_hidden_by_noise_is_read_when_the_rest_of_that_does_not_come():
    bench = Bench().until_ready()
    hidden = b"\xFA\xFB\xFF" + p2os.encode_packet(sip(x_counts=110))      # looks like the begin of a longer packet
    bench.session.events()
    bench.session.receive(p2os.encode_packet(sip(x_counts=100)) + hidden, bench.now)
    bench.session.tick(bench.now + p2os.PARTIAL_TIMEOUT)
    assert [event.x for event in bench.session.events()] == pytest.approx([0.1, 0.11])


# The table of transitions

def connecting(bench):
    """The session begins like this."""


def synced(bench):
    bench.run_until(lambda: isinstance(bench.session.phase, Synced))


def opening(bench):
    bench.run_until(lambda: isinstance(bench.session.phase, Opening))


def connected(bench):
    bench.until_driving()


def closing(bench):
    bench.until_driving()
    bench.close()


def goes_on(bench):
    before = type(bench.session.phase)
    bench.run_until(lambda: type(bench.session.phase) is not before)


def is_closed(bench):
    bench.session.close(bench.now)


def fails(bench):
    bench.session.fail(LinkLostError("pulled"))


HAPPENS = {Left: is_closed, Failed: fails}
REACHED = {Connecting: connecting, Synced: synced, Opening: opening, Connected: connected, Closing: closing}
SAID_AT_ONCE = {    # when it fails: nothing to a robot that was only listened to
    Connecting: "", Synced: "CLOSE", Opening: "STOP VEL RVEL ENABLE CLOSE", Connected: "STOP VEL RVEL ENABLE CLOSE",
    Closing: "STOP VEL RVEL ENABLE CLOSE"}


def commands_in(data):
    return " ".join(p2os.decode_command(frame).name for frame in p2os.FrameDecoder().feed(data))


@pytest.mark.parametrize("phase, outcome", TRANSITIONS, ids=lambda each: each.__name__)
def test_each_transition_of_the_table_leads_where_it_says(phase, outcome):
    bench = Bench()
    REACHED[phase](bench)
    assert type(bench.session.phase) is phase
    bench.session.data_to_send()
    HAPPENS.get(outcome, goes_on)(bench)
    assert type(bench.session.phase) is TRANSITIONS[phase, outcome]
    said = commands_in(b"".join(bench.session.data_to_send()))
    if outcome is Failed:
        assert said == SAID_AT_ONCE[phase]
    if bench.finished:
        assert bench.session.wake_at == math.inf
        assert str(bench.session.error) == ("pulled" if outcome is Failed and phase is not Closing else "None")


@pytest.mark.parametrize("happens", [is_closed, fails])
@pytest.mark.parametrize("phase", [Closing, Finished])
def test_what_is_not_in_the_table_changes_nothing(phase, happens):
    bench = Bench()
    closing(bench)
    bench.run_until(lambda: isinstance(bench.session.phase, phase))
    before = bench.session.phase
    bench.session.data_to_send()
    outcome = {is_closed: Left, fails: Failed}[happens]
    if (phase, outcome) not in TRANSITIONS:
        happens(bench)
        assert bench.session.phase is before and bench.session.data_to_send() == []


def test_the_table_names_every_phase_and_every_outcome():
    assert {phase for phase, _ in TRANSITIONS} | set(TRANSITIONS.values()) == set(REACHED) | {Finished}
    assert {outcome for _, outcome in TRANSITIONS} == set(Outcome.__args__)
    assert all((phase, Failed) in TRANSITIONS for phase in REACHED)


@pytest.mark.parametrize("rates, delay", [
    ((9600,), (37 + 6) * 10 / 9600), ((115200,), (37 + 6) * 10 / 115200), ((), 0.0)])
def test_states_and_packets_say_when_the_robot_sent_them(rates, delay):
    bench = Bench(rates=rates).until_ready()
    bench.run(0.5)
    data = bytes.fromhex("FAFB2833D204C8FF0002BE00D20080000200020700000203DC05049808210500F00080000020000000260D")
    bench.robot.mute = lambda packet: True
    bench.run(0.2)      # it takes a robot that long to get there
    bench.session.receive(data[:20], bench.now)
    bench.step()
    bench.session.receive(data[20:], bench.now)
    at = bench.now
    bench.robot.mute = lambda packet: False
    bench.robot.send(p2os.Encoder(1, 2))
    bench.step()
    state = next(state for state in bench.states if state.sonar[4])
    assert state.time == at and state.sent_time == pytest.approx(at - delay)
    packet = bench.event(PacketReceived)
    assert packet.time - packet.sent_time == pytest.approx(14 * 10 / rates[0] if rates else 0.0)


def test_the_first_state_is_as_old_as_its_packet():
    robot, sips = FakeRobot(), []
    robot.config = None         # so that it is waited for, after the last SIP
    robot.mute = lambda packet: isinstance(packet, p2os.Sip) and (len(sips) == 3 or sips.append(packet))
    bench = Bench(robot).until_ready()
    assert bench.states[0].time < bench.now - 0.5


def test_half_of_all_packets_malformed_still_drives_and_is_counted():
    chance = random.Random(7)

    def spoil(data):
        at = chance.randrange(len(data))
        if chance.random() < 0.5:
            return data
        return data[:at] + bytes([data[at] ^ chance.randrange(1, 256)]) + data[at + 1:]

    bench = Bench(to_client=spoil)
    bench.until_ready()
    request = bench.session.connected.drive.request_motors(True, bench.now, 2.0)
    bench.run_until(lambda: request.done)
    assert request.error is None
    states = len(bench.states)
    for _ in range(100):
        bench.drive(0.2, 0.0)
        bench.run(0.1)
        assert bench.robot.moving and bench.session.connected
    assert 30 < len(bench.states) - states < 70
    assert bench.session.counts.bad_checksums > 20 and bench.session.counts.discarded_bytes > 500
    assert all(state.battery_voltage == 12.8 for state in bench.states)


@pytest.mark.parametrize("seed", range(20))
def test_whatever_comes_from_the_line_nothing_raises(seed):
    chance = random.Random(seed)
    bench = Bench()
    packets = [p2os.encode_frame(number, bytes(chance.randrange(256) for _ in range(chance.randrange(60))))
               for number in range(256)]
    if seed % 2:
        bench.until_ready()
    while bench.now < 8.0 and not bench.finished:
        noise = bytes(chance.randrange(256) for _ in range(chance.randrange(300)))
        bench.session.receive(chance.choice((noise, chance.choice(packets))), bench.now)
        if bench.session.connected:
            bench.drive(chance.uniform(-2, 2), chance.uniform(-2, 2))
        bench.run(0.02)
    assert not bench.finished or isinstance(bench.session.error, PioneerError)


def test_a_cut_packet_does_not_hold_up_the_next():
    bench = Bench().until_ready()
    whole = p2os.encode_packet(sip(battery_x10_dv=111))
    bench.session.receive(whole[:10], bench.now)
    bench.session.receive(whole[:3], bench.now)
    bench.robot.mute = lambda packet: True
    bench.run(0.15)
    bench.session.receive(whole, bench.now)
    bench.run(0.01)
    assert bench.states[-1].battery_voltage == 11.1


def test_a_flood_of_commands_is_refused_before_it_delays_everything():
    bench = Bench().until_ready()
    with pytest.raises(RefusedError, match="wait already"):
        for _ in range(LONGEST_QUEUE + 2):
            bench.session.connected.command(bench.now, p2os.encode_command("SONAR", 1))


# Ends

def test_closing_stops_switches_off_and_closes_in_this_order():
    bench = Bench().until_driving(0.2)
    bench.robot.heard.clear()
    bench.close()
    assert bench.robot.names() == ["STOP", "VEL", "RVEL"], "the stop is out before anything is waited for"
    assert bench.run_until(lambda: bench.finished) < 0.5
    assert bench.robot.names() == ["STOP", "VEL", "RVEL", "ENABLE", "CLOSE"] and bench.robot.heard[3].value == 0
    assert bench.session.error is None and bench.robot.phase == WAITING


def test_closing_waits_a_moment_for_the_wheels_and_is_bounded():
    bench = Bench().until_driving(0.2)
    bench.robot.coasts = True
    start = bench.now
    bench.close()
    bench.run_until(lambda: "ENABLE" in bench.robot.names())
    assert 0.2 < bench.now - start < 0.5
    bench.robot.deaf = lambda heard: True
    bench.run_until(lambda: bench.finished)
    assert bench.now - start < 0.85
    assert bench.robot.names().count("CLOSE") == 3


def test_a_lost_close_is_repeated():
    bench = Bench().until_ready()
    bench.robot.deaf = lambda heard: heard.name == "CLOSE" and bench.robot.names().count("CLOSE") < 3
    bench.close()
    bench.run_until(lambda: bench.finished)
    assert bench.robot.phase == WAITING


def test_closing_drops_what_waits():
    bench = Bench().until_ready()
    for _ in range(20):
        bench.session.connected.command(bench.now, p2os.encode_command("TTY2", b"x" * 100))
    bench.robot.heard.clear()
    bench.close()
    assert bench.run_until(lambda: bench.finished) < 0.5
    assert "TTY2" not in bench.robot.names()[1:]


def test_closing_while_only_listening_says_nothing():
    robot = FakeRobot()
    robot.open()
    robot.mute = lambda packet: True
    bench = Bench(robot)
    bench.run(0.1)
    bench.close()
    bench.run(0.5)
    assert bench.finished and bench.session.error is None and robot.heard == []


def test_closing_while_opening_closes_the_robot():
    robot = FakeRobot()
    robot.config = None
    bench = Bench(robot)
    bench.run_until(lambda: isinstance(bench.session.phase, Opening))
    bench.run(0.2)
    assert robot.phase == OPEN
    bench.close()
    bench.run_until(lambda: bench.finished)
    assert robot.phase == WAITING


def test_nothing_happens_after_the_end():
    bench = Bench().until_ready()
    bench.session.fail(LinkLostError("pulled"))
    bench.session.fail(LinkLostError("again"))
    bench.step()
    bench.robot.heard.clear()
    bench.session.receive(p2os.encode_packet(sip()), bench.now)
    bench.session.close(bench.now)
    states = len(bench.states)
    bench.run(3.0)
    assert str(bench.session.error) == "pulled" and bench.robot.heard == [] and len(bench.states) == states


@pytest.mark.parametrize("ready", [False, True])
def test_a_session_that_ends_in_the_middle_of_a_packet_wants_no_time_for_the_rest(ready):
    bench = Bench()
    if ready:
        bench.until_ready()
    bench.session.receive(bytes.fromhex("FA FB 09 0F FB"), bench.now)
    bench.session.fail(LinkLostError("pulled"))
    assert bench.session.wake_at == float("inf")


def test_the_odometry_goes_on_over_a_reconnect():
    bench = Bench().until_ready()
    bench.robot.mute = lambda packet: True
    bench.run(1.0)      # it takes a robot that long to get there
    bench.session.receive(p2os.encode_packet(sip(x_counts=1500, y_counts=200, heading_units=1024)), bench.now)
    before = bench.session.phase.odometry.pose
    bench.session = Session("fake", (), Settings(), bench.now, bench.session.phase.odometry)
    bench.robot = FakeRobot()
    bench.until_ready()
    assert bench.session.phase.odometry.pose == pytest.approx(before)
    assert bench.states[-1].x == pytest.approx(1.5)
    bench.session.phase.odometry.update(100, 0, 0)
    assert bench.session.phase.odometry.pose == pytest.approx((1.5, 0.3, before[2]))


def reconnect(bench, *heard):
    """Begin a new session with the robot as it is, and wait until it is ready. The session hears these packets before
    it sends anything.
    """
    bench.session = Session("fake", (), Settings(), bench.now, bench.session.phase.odometry)
    for packet in heard:
        bench.session.receive(p2os.encode_packet(packet), bench.now)
    bench.until_ready()


def test_what_a_robot_did_unheard_is_in_its_odometry_if_it_counts_on():
    bench = Bench().until_ready()
    bench.robot.mute = lambda packet: not isinstance(packet, p2os.SyncReply) and bench.robot.phase == OPEN
    bench.run(0.5)
    bench.session.receive(p2os.encode_packet(sip(x_counts=100, heading_units=512)), bench.now)
    assert bench.session.phase.odometry.pose == pytest.approx((0.1, 0.0, math.pi / 4))
    bench.session.fail(LinkLostError("pulled"))
    bench.session.data_to_send()    # it hears nothing
    bench.robot.mute = lambda packet: False
    here, farther = (sip(x_counts=x, y_counts=300, heading_units=1024) for x in (400, 450))
    reconnect(bench, here, farther)
    pose = bench.session.phase.odometry.pose
    assert pose == pytest.approx((0.45, 0.3, math.pi / 2)), "OPEN began a new frame, which is turned by so much"
    bench.session.phase.odometry.update(10, 0, 0)
    assert bench.session.phase.odometry.pose == pytest.approx((0.45, 0.31, math.pi / 2))


def test_a_new_frame_of_the_robots_is_no_step():
    """The robot was opened and lost before it was ready. Now it counts from zero."""
    bench = Bench().until_ready()
    bench.run(1.0)
    bench.session.receive(p2os.encode_packet(sip(x_counts=300)), bench.now)
    bench.session.fail(LinkLostError("pulled"))
    bench.session.data_to_send()
    bench.session = Session("fake", (), Settings(), bench.now, bench.session.phase.odometry)
    bench.robot.phase, bench.robot.mute = WAITING, lambda packet: isinstance(packet, p2os.Sip)
    bench.run_until(lambda: isinstance(bench.session.phase, Opening))
    bench.session.fail(LinkLostError("pulled again"))
    bench.robot.mute = lambda packet: False
    reconnect(bench, sip(x_counts=0), sip(x_counts=20))
    assert bench.session.phase.odometry.pose == pytest.approx((0.32, 0.0, 0.0))


def test_no_step_is_believed_that_no_robot_goes_before_it_stands():
    bench = Bench().until_ready()
    bench.session.fail(LinkLostError("pulled"))
    bench.session.data_to_send()
    reconnect(bench, sip(x_counts=16000))
    assert bench.session.phase.odometry.pose == (0.0, 0.0, 0.0)


def test_a_robot_that_reports_more_sonar_than_before_has_a_reading_for_each():
    bench = Bench()
    bench.robot.config = config(front_sonar=1, rear_sonar=0)
    bench.until_ready()
    bench.robot.send(config(front_sonar=1, rear_sonar=1))
    bench.run(0.3)
    assert len(bench.states[0].sonar) == 8 and len(bench.states[-1].sonar) == 16
    assert bench.session.connected.identity.model.sonar_count == 16


def test_a_packet_whose_checksum_fits_by_chance_moves_nobody():
    """Two changed bytes cancel each other in the sum: the high byte of x is one more, another byte one less."""
    bench = Bench().until_ready()
    bench.run(0.5)
    before = bench.states[-1]
    spoilt = bytearray(p2os.encode_packet(sip(control_units=0x2020)))
    spoilt[5] += 0x20       # 8.192 m
    spoilt[spoilt.index(0x20, 6) if spoilt.index(0x20, 6) % 2 else spoilt.index(0x20, 6) + 1] -= 0x20
    frame, = p2os.FrameDecoder().feed(spoilt)
    assert p2os.decode_packet(frame).x_counts - sip().x_counts == 0x2000, "it passes"
    count = len(bench.states)
    bench.session.receive(bytes(spoilt), bench.now)
    assert bench.session.counts.unreadable == 1 and len(bench.states) == count
    bench.run(0.5)
    assert len(bench.states) > count and (bench.states[-1].x, bench.states[-1].y) == (before.x, before.y)

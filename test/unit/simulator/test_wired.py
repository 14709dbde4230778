"""Robots and their lines in one simulated time."""

import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.faults import fault_of
from pioneer_control.simulator.firmware import Firmware, Session
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.wired import Wired
from pioneer_control.simulator.world import World

STARTS = [(0.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 6.0, 0.0)]


def alone(*faults, **options):
    return Wired(Firmware(find_model("p3dx-sh"), World("hall")), faults=[fault_of(words) for words in faults], **options)


def several(*faults):
    simulation = Simulation(World("hall", starts=STARTS))
    for _ in STARTS:
        simulation.add(find_model("p3dx-sh"))
    return Wired(simulation, faults=[fault_of(words) for words in faults])


def open_session(wired, robot=0, baud=None):
    for number in (0, 1, 2, 1):
        wired.send(robot, p2os.encode_frame(number), baud)
    wired.advance(0.1)


def sips(arrivals, robot=0):
    """The standard packets that came to a client, each with the simulated second of its last byte."""
    decoder, found = p2os.FrameDecoder(), []
    for arrival in arrivals:
        if arrival.robot == robot:
            packets = map(p2os.decode_packet, decoder.feed(arrival.data))
            found += [(arrival.time_us * 1e-6, packet) for packet in packets if isinstance(packet, p2os.Sip)]
    return found


def test_over_tcp_an_answer_comes_in_the_moment_of_the_question():
    wired = alone()
    wired.advance(0.0133)
    wired.send(0, p2os.encode_frame(0))
    arrival, = wired.advance(0.0)
    assert arrival == (0, 13300, None, p2os.encode_frame(0))


def test_a_serial_line_takes_its_time_both_ways():
    wired = alone()
    wired.send(0, p2os.encode_frame(0), 9600)
    assert wired.advance(0.012) == []
    arrival, = wired.advance(0.001)
    assert arrival == (0, 12500, 9600, p2os.encode_frame(0))


@pytest.mark.parametrize("baud", [None, 9600, 115200])
def test_one_sip_a_cycle_comes_over_any_line(baud):
    wired = alone()
    wired.robots[0].baud = baud or 9600
    open_session(wired, baud=baud)
    times = [time for time, _ in sips(wired.advance(10.0))]
    assert len(times) in (99, 100, 101) and all(0.09 < later - time < 0.11 for time, later in zip(times, times[1:]))


def test_a_slow_line_leaves_out_what_it_has_no_time_for_but_never_a_sip():
    """Everything that can be asked for at once is more than 960 bytes a second."""
    wired = alone()
    open_session(wired, baud=9600)
    for name in ("IOREQUEST", "ENCODER", "GRIPREQUEST"):
        wired.send(0, p2os.encode_command(name, 2), 9600)
    before = len(sips(wired.advance(10.0)))
    wired.send(0, p2os.encode_command("CONFIG"), 9600)
    after = sips(wired.advance(10.0))
    assert before in (99, 100, 101) and len(after) >= 99
    assert wired.plants[0].wires["from-robot"].backlog_us(wired.time_us) < 300000


def test_the_same_however_the_time_is_split():
    def run(step_us):
        wired, out = alone("loss 0.2 from 1 to 3", "flips 0.01 from 2 to 4", "power from 5", seed=3), []
        for at in range(0, 8000000, step_us):
            if at % 500000 == 0:
                for number in (0, 1, 2, 1) if at % 6000000 == 0 else (0,):
                    wired.send(0, p2os.encode_frame(number), 9600)
            out += wired.run_to(at + step_us)
        return out
    assert run(500000) == run(20000) == run(4000)


def test_another_seed_is_another_luck():
    outs = []
    for seed in (1, 1, 2):
        wired = alone("loss 0.5", seed=seed)
        for _ in range(20):
            open_session(wired)
        outs.append(wired.advance(10.0))
    assert outs[0] == outs[1] != outs[2]


def test_each_of_several_robots_has_its_own_line():
    wired = several("silence robot 2", "loss 0.5 robot 3 way from-robot")
    for robot in range(3):
        open_session(wired, robot)
    arrivals = wired.advance(10.0)
    counts = [len(sips(arrivals, robot)) for robot in range(3)]
    assert counts[0] in (99, 100, 101) and counts[1] == 0 and 25 < counts[2] < 75
    assert wired.robots[1].session is Session.WAITING and wired.robots[2].session is Session.OPEN


def test_faults_begin_and_end_at_their_simulated_times():
    said = []
    wired = alone("silence way from-robot from 1.005 to 2.005", say=lambda time, sentence: said.append((time, sentence)))
    open_session(wired)
    times = [time for time, _ in sips(wired.advance(3.0))]
    assert [time for time in times if 1.005 < time < 2.005] == [] and len(times) in (19, 20, 21)
    assert said == [(1.005, "fault begins: silence way from-robot"), (2.005, "fault ends: silence way from-robot")]


def test_a_pulled_cable_and_no_power_carry_nothing():
    for fault in ("cable", "power"):
        wired = alone(fault + " from 1 to 2")
        open_session(wired)
        wired.advance(0.95)
        assert sips(wired.advance(0.9)) == []
        wired.send(0, p2os.encode_frame(0))
        assert wired.advance(0.04) == []


def test_a_robot_without_power_forgets_its_session_and_one_without_cable_does_not():
    sessions = []
    for fault in ("cable", "power"):
        wired = alone(fault + " from 1 to 2")
        open_session(wired)
        wired.advance(3.0)
        sessions.append(wired.robots[0].session)
    assert sessions == [Session.OPEN, Session.WAITING]


def test_the_end_of_a_session_is_told_once():
    wired = several()
    open_session(wired, 1)
    wired.send(1, p2os.encode_command("CLOSE"), 9600)
    assert wired.ended == []
    wired.advance(1.0)
    assert wired.ended == [1]


def test_the_backlog_of_a_line_that_is_written_to_too_fast():
    wired = alone()
    wired.send(0, bytes(960), 9600)
    assert wired.backlog(0) == pytest.approx(1.0)
    wired.advance(0.75)
    assert wired.backlog(0) == pytest.approx(0.25)


def test_without_a_robot_there_is_nothing_to_wire():
    with pytest.raises(ParameterError, match="no robot in the simulation"):
        Wired(Simulation(World("hall")))


def test_nothing_is_due_between_two_steps_of_the_physics():
    wired = several()
    wired.advance(0.001)
    assert wired.next_us == 20000

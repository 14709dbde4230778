"""Robots and their lines in one simulated time."""

import pytest

from pioneer_control import p2os
from pioneer_control.errors import ParameterError
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import LineSimulation, fault_of
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.simulation import Simulation
from pioneer_control.simulator.world import World

STARTS = [(0.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 6.0, 0.0)]


def alone(*faults, **options):
    firmware = Firmware(find_model("p3dx-sh"), World("hall"))
    return LineSimulation(firmware, faults=[fault_of(words) for words in faults], **options)


def several(*faults):
    simulation = Simulation(World("hall", starts=STARTS))
    for _ in STARTS:
        simulation.add(find_model("p3dx-sh"))
    return LineSimulation(simulation, faults=[fault_of(words) for words in faults])


def open_session(lines, robot=0, baud=None):
    for number in (0, 1, 2, 1):
        lines.send(robot, p2os.encode_frame(number), baud)
    lines.advance(0.1)


def sips(arrivals, robot=0):
    """Return the SIPs that came to a client, each with the simulated second of its last byte."""
    decoder, found = p2os.FrameDecoder(), []
    for arrival in arrivals:
        if arrival.robot == robot:
            packets = map(p2os.decode_packet, decoder.feed(arrival.data))
            found += [(arrival.time_us * 1e-6, packet) for packet in packets if isinstance(packet, p2os.Sip)]
    return found


def test_over_tcp_an_answer_comes_in_the_moment_of_the_question():
    lines = alone()
    lines.advance(0.0133)
    lines.send(0, p2os.encode_frame(0))
    arrival, = lines.advance(0.0)
    assert arrival == (0, 13300, None, p2os.encode_frame(0))


def test_a_serial_line_takes_its_time_both_ways():
    lines = alone()
    lines.send(0, p2os.encode_frame(0), 9600)
    assert lines.advance(0.012) == []
    arrival, = lines.advance(0.001)
    assert arrival == (0, 12500, 9600, p2os.encode_frame(0))


@pytest.mark.parametrize("baud", [None, 9600, 115200])
def test_one_sip_a_cycle_comes_over_any_line(baud):
    lines = alone()
    lines.robots[0].baud = baud or 9600
    open_session(lines, baud=baud)
    times = [time for time, _ in sips(lines.advance(10.0))]
    assert len(times) in (99, 100, 101) and all(0.09 < later - time < 0.11 for time, later in zip(times, times[1:]))


def test_a_slow_line_leaves_out_what_it_has_no_time_for_but_never_a_sip():
    """All data that one can request at once are more than 960 bytes a second."""
    lines = alone()
    open_session(lines, baud=9600)
    for name in ("IOREQUEST", "ENCODER", "GRIPREQUEST"):
        lines.send(0, p2os.encode_command(name, 2), 9600)
    before = len(sips(lines.advance(10.0)))
    lines.send(0, p2os.encode_command("CONFIG"), 9600)
    after = sips(lines.advance(10.0))
    assert before in (99, 100, 101) and len(after) >= 99
    assert lines.links[0].wires["from-robot"].backlog_us(lines.clock.now_us) < 300000


def test_the_same_however_the_time_is_split():
    def run(step_us):
        lines, out = alone("loss 0.2 from 1 to 3", "flips 0.01 from 2 to 4", "power from 5", seed=3), []
        for at in range(0, 8000000, step_us):
            if at % 500000 == 0:
                for number in (0, 1, 2, 1) if at % 6000000 == 0 else (0,):
                    lines.send(0, p2os.encode_frame(number), 9600)
            out += lines.run_to(at + step_us)
        return out
    assert run(500000) == run(20000) == run(4000)


def test_another_seed_is_another_luck():
    outs = []
    for seed in (1, 1, 2):
        lines = alone("loss 0.5", seed=seed)
        for _ in range(20):
            open_session(lines)
        outs.append(lines.advance(10.0))
    assert outs[0] == outs[1] != outs[2]


def test_each_of_several_robots_has_its_own_line():
    lines = several("silence robot 2", "loss 0.5 robot 3 way from-robot")
    for robot in range(3):
        open_session(lines, robot)
    arrivals = lines.advance(10.0)
    counts = [len(sips(arrivals, robot)) for robot in range(3)]
    assert counts[0] in (99, 100, 101) and counts[1] == 0 and 25 < counts[2] < 75
    assert lines.robots[1].session is FirmwareState.WAITING and lines.robots[2].session is FirmwareState.OPEN


def test_faults_begin_and_end_at_their_simulated_times():
    said = []
    lines = alone(
        "silence way from-robot from 1.005 to 2.005", say=lambda time, sentence: said.append((time, sentence)))
    open_session(lines)
    times = [time for time, _ in sips(lines.advance(3.0))]
    assert [time for time in times if 1.005 < time < 2.005] == [] and len(times) in (19, 20, 21)
    assert said == [(1.005, "fault begins: silence way from-robot"), (2.005, "fault ends: silence way from-robot")]


def test_a_pulled_cable_and_no_power_carry_nothing():
    for fault in ("cable", "power"):
        lines = alone(fault + " from 1 to 2")
        open_session(lines)
        lines.advance(0.95)
        assert sips(lines.advance(0.9)) == []
        lines.send(0, p2os.encode_frame(0))
        assert lines.advance(0.04) == []


def test_a_robot_without_power_forgets_its_session_and_one_without_cable_does_not():
    sessions = []
    for fault in ("cable", "power"):
        lines = alone(fault + " from 1 to 2")
        open_session(lines)
        lines.advance(3.0)
        sessions.append(lines.robots[0].session)
    assert sessions == [FirmwareState.OPEN, FirmwareState.WAITING]


def test_the_end_of_a_session_is_told_once():
    lines = several()
    open_session(lines, 1)
    lines.send(1, p2os.encode_command("CLOSE"), 9600)
    assert lines.ended == []
    lines.advance(1.0)
    assert lines.ended == [1]


def test_the_backlog_of_a_line_that_is_written_to_too_fast():
    lines = alone()
    lines.send(0, bytes(960), 9600)
    assert lines.backlog(0) == pytest.approx(1.0)
    lines.advance(0.75)
    assert lines.backlog(0) == pytest.approx(0.25)


def test_without_a_robot_there_is_nothing_to_wire():
    with pytest.raises(ParameterError, match="no robot in the simulation"):
        LineSimulation(Simulation(World("hall")))


def test_nothing_is_due_between_two_steps_of_the_physics():
    lines = several()
    lines.advance(0.001)
    assert lines.next_us == 20000

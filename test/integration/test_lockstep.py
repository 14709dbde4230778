"""A program and the simulated robot in lockstep: the same program with the same seed does exactly the same."""

import random
import signal
import subprocess
import sys
import time

import pytest

from pioneer_control.client import Robot
from pioneer_control.errors import ParameterError
from pioneer_control.p2os import GripperCommand
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import Server, fault_of
from pioneer_control.simulator.simulation import simulate
from pioneer_control.simulator.world import load_world

from real_time import LIMIT, keep_commanding, until

LOCKSTEP = "?lockstep"
PROGRAM = """
import sys

from pioneer_control.client import Robot


def decided(state):
    return (0.0, 0.5) if state.sonar[3] and state.sonar[3].range < 0.8 else (0.3, 0.0)


with Robot(sys.argv[1]) as robot:
    robot.enable_motors()
    state = robot.wait_for_state()
    while state.time < 60:                      # in lockstep: simulated seconds since the start
        robot.set_velocity(*decided(state))
        state = robot.wait_for_state()
print(state)
"""


def served(seed=1, faults=(), world="office", robots=1, **options):
    """Return a server for robots."""
    simulation = simulate(load_world(world), find_model("p3dx-sh"), robots, None, seed)
    return Server(simulation, tcp=0, faults=[fault_of(fault) for fault in faults], **options)


def wander(url, seconds, dawdle):
    """Wander like a student's program, and return all states. Call ``dawdle`` in each turn."""
    with Robot(url) as robot:
        states = [robot.state]
        robot.enable_motors()
        robot.gripper(GripperCommand.CLOSE)
        while not states[-1].gripper.paddles_closed:
            states.append(robot.wait_for_state())
        while states[-1].time < seconds:
            states.append(robot.wait_for_state())
            dawdle()
            near = min(heard.range for heard in states[-1].sonar[1:7] if heard is not None)
            robot.set_velocity(*(0.0, 0.7) if near < 0.7 else (0.35, 0.05))
            if len(states) % 50 == 0:
                robot.gripper(GripperCommand.OPEN if len(states) % 100 else GripperCommand.CLOSE)
        return states


def run(seconds=60.0, dawdle=lambda: None, **options):
    """Return all states of a program, and where its robot is in the end and at which simulated time."""
    with served(lockstep=5.0, **options) as server:
        states = wander(server.url + LOCKSTEP, seconds, dawdle)
        with server.lock:
            assert server.pace.late_answers == 0
            return states, server.firmware.true_pose, server.firmware.velocity, server.simulation.time


def test_the_same_program_does_the_same_three_times():
    chance = random.Random(3)
    began = time.monotonic()
    first, *others = run(), run(), run(dawdle=lambda: time.sleep(max(0.0, chance.uniform(-0.1, 0.01))))
    assert time.monotonic() - began < 180.0, "simulated time does not wait for real time"
    assert others == [first, first]
    states = first[0]
    assert states[0].time == 0.0 and states[1].time == 0.3, "enable_motors() takes the same cycles each time"
    assert [state.time for state in states[1:]] == [round(0.1 * number, 1) for number in range(3, 601)]
    assert states[-1].time == 60.0 and max(abs(state.x) for state in states) > 1.0
    assert run(10.0, seed=2)[0] != states[:99], "another seed is another run"


def test_a_program_with_the_simulator_beside_it(tmp_path):
    """As in docs/simulator.md."""
    source = tmp_path / "program.py"
    source.write_text(PROGRAM)

    def results():
        with subprocess.Popen([sys.executable, "-m", "pioneer_control.simulator", "--tcp=0", "--lockstep"],
                              stdout=subprocess.PIPE, universal_newlines=True) as simulator:
            try:
                url = [simulator.stdout.readline() for _ in range(3)][1].strip()
                printed = subprocess.check_output([sys.executable, str(source), url + LOCKSTEP])
                simulator.send_signal(signal.SIGINT)
                return printed, simulator.communicate(timeout=LIMIT)[0].strip()
            finally:
                simulator.kill()

    state, said = results()
    assert b"time=60.0" in state and said.endswith("answers that came too late: 0")
    assert results()[0] == state


def test_faults_of_the_line_hit_the_same_packets():
    faults = ["loss 0.2 way from-robot from 2", "loss 0.2 way to-robot from 2", "flips 0.002 from 2",
              "delay 0.15 from 3 to 6", "silence from 7 to 8"]
    first = run(15.0, faults=faults)
    assert run(15.0, faults=faults, dawdle=lambda: time.sleep(0.001)) == first
    assert first[3] > 16.0, "states were lost"


def test_a_run_ends_where_its_program_closes():
    with served(lockstep=5.0) as server:
        with Robot(server.url + LOCKSTEP) as robot:
            assert robot.wait_for_state().time == 0.1
        until(lambda: server.firmware.closed_sessions, "the end of the session")
        with Robot(server.url + LOCKSTEP) as robot:
            with server.lock:
                assert server.simulation.time == pytest.approx(0.3), "the handshake takes no simulated time"
            assert robot.wait_for_state().time == 0.1 and server.simulation.time == pytest.approx(0.4)


def test_time_does_not_wait_for_ever_for_a_program_that_does_not_answer():
    said = []
    with served(lockstep=0.2, speed=5.0, say=said.append) as server, Robot(server.url + LOCKSTEP) as robot:
        robot.enable_motors()
        assert server.pace.late_answers == 0
        robot.set_velocity(0.3, 0.0)
        before = robot.state.time
        until(lambda: robot.state.time > before + 1.0, "time that goes on")
        assert server.pace.late_answers == 1 and "does not answer in time" in said[0]
        until(lambda: server.firmware.velocity == (0.0, 0.0), "the dead man")
        robot.wait_for_state()
        until(lambda: server.pace.late_answers == 2, "it waited again, and again in vain")


def test_a_client_that_knows_nothing_of_lockstep_has_an_ordinary_robot():
    with served(lockstep=0.2, speed=5.0) as server, Robot(server.url) as robot:
        robot.enable_motors()
        keep_commanding(robot, lambda: robot.set_velocity(0.3, 0.0), lambda state: state.x > 0.2)
        assert server.pace.late_answers == 1


def test_an_ordinary_robot_does_not_mind_the_marks():
    with served(speed=5.0) as server, Robot(server.url + LOCKSTEP) as robot:
        robot.enable_motors()
        keep_commanding(robot, lambda: robot.set_velocity(0.3, 0.0), lambda state: state.x > 0.1)
        assert server.pace.late_answers is None
    until(lambda: server.firmware.closed_sessions, "the end of the session")
    assert not server.firmware.motors_enabled


@pytest.mark.parametrize("options", [{"robots": 2}, {"pty": "/nowhere/robot"}])
def test_lockstep_is_for_one_robot_on_tcp(options):
    with pytest.raises(ParameterError, match="lockstep is for one robot on a TCP port"):
        served(lockstep=1.0, **options)

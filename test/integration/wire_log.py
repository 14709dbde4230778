#!/usr/bin/python3
"""The run whose line is kept in test/data/day.wire: what a program did, and what its client told it.

As a program it makes run and files again.

    PYTHONPATH=src python3 test/integration/wire_log.py     # half a minute, in real time over TCP
"""

import pathlib
import sys
import time

from pioneer_control.client import LinkDown, MotorsAnswered, Robot, RobotState
from pioneer_control.p2os import GripperCommand
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import LineSimulation, Server, fault_of
from pioneer_control.simulator.world import load_world
from pioneer_control.simulator.simulation import Simulation

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"
RECORD, TOLD = DATA / "day.wire", DATA / "day.told"
SEED = 5
FAULTS = "loss 0.15 from 14 to 18", "flips 0.002 way from-robot from 14 to 18", "power from 20 to 21"
LIMIT = 30.0        # s: generous; nothing waits that long


def simulation():
    """Return a simulation with a PeopleBot (because it has bumpers), a gripper, and a can ahead of it."""
    made = Simulation(load_world("cans"))
    made.add(find_model("peoplebot-sh"), gripper=True, rear_sonar=False, seed=SEED)
    return made


def on_its_line(*, seed=SEED, faults=FAULTS):
    """Return the robot with its line."""
    return LineSimulation(simulation(), seed, [fault_of(words) for words in faults])


def lines_of(told):
    """Return what the client reported, as lines of text, without answers to requests of the program."""
    return [line_of(said) for said in told if not isinstance(said, MotorsAnswered)]


def line_of(said):
    """Return a state or event of the client as a line of text, without times, because they differ from run to run."""
    if not isinstance(said, RobotState):
        return type(said).__name__ + (" " + type(said.error).__name__ if isinstance(said, LinkDown) else "")
    gripper = "".join(str(int(value)) for value in vars(said.gripper).values())
    switches = said.motors_enabled, said.left_stall, said.right_stall, *said.front_bumpers, *said.rear_bumpers
    pressed = "".join(str(int(value)) for value in switches)
    ranges = " ".join("-" if each is None else "%g" % each.range for each in said.sonar)
    return "%r %r %r %r %r %r %s %s %s" % (
        said.x, said.y, said.heading, said.linear, said.angular, said.battery_voltage, pressed, gripper, ranges)


def script(life):
    """The actions of the program: a generator that yields the seconds to wait. `life` has the client's ``robot``,
    ``states`` and ``events``.
    """
    robot = life.robot

    def drive(linear, angular, condition):
        end = life.now + LIMIT
        while not condition(robot.state):
            assert life.now < end, robot.state
            robot.set_velocity(linear, angular)
            yield 0.1
        robot.stop()
        yield 0.3

    def motors_on():
        robot.request_motors(True)
        yield from life.until(lambda: robot.state.motors_enabled)

    def grip(command, done):
        robot.gripper(command)
        yield from life.until(lambda: done(robot.state.gripper))

    yield from life.until(lambda: robot.ready and robot.state is not None)
    yield 0.2
    yield from motors_on()
    yield from grip(GripperCommand.LIFT_DOWN, lambda gripper: gripper.lift_down)
    yield from drive(0.3, 0.0, lambda state: state.gripper.inner_beam)
    yield from grip(GripperCommand.CLOSE, lambda gripper: gripper.left_contact and gripper.right_contact and
                    gripper.inner_beam)
    yield from grip(GripperCommand.LIFT_UP, lambda gripper: gripper.lift_up)
    yield from drive(-0.4, 0.0, lambda state: any(state.rear_bumpers))
    while not any(type(event) is LinkDown for event in life.events):
        if robot.ready:
            robot.set_velocity(0.25, 0.3)
        yield 0.1
    yield from life.until(lambda: robot.ready and not robot.state.motors_enabled)
    yield from motors_on()
    start = robot.state.x
    yield from drive(-0.2, 0.0, lambda state: abs(state.x - start) > 0.2)
    yield from grip(GripperCommand.LIFT_DOWN, lambda gripper: gripper.lift_down)


class Live:
    """Like `simulated_client.Life`, but in real time."""

    def __init__(self, url):
        self.states, self.events, self.told = [], [], []
        self.robot = Robot(url, reconnect=True, on_state=self._tell, on_event=self._tell)
        self.robot.start()
        for wait in script(self):
            time.sleep(wait)
        self.robot.close()

    @property
    def now(self):
        """The time of the monotonic clock (s)."""
        return time.monotonic()

    def until(self, condition):
        """Wait until a condition holds. For use in a script."""
        end = self.now + LIMIT
        while not condition():
            assert self.now < end, self.events[-5:]
            yield 0.005

    def _tell(self, said):
        (self.states if isinstance(said, RobotState) else self.events).append(said)
        self.told.append(said)


def main():
    """Make the files."""
    with Server(simulation(), tcp=0, seed=SEED, faults=[fault_of(words) for words in FAULTS], record=str(RECORD),
                say=print) as server:
        told = lines_of(Live(server.url).told)
    TOLD.write_text("\n".join(told) + "\n", encoding="utf-8")
    print(len(told), "told;", RECORD.stat().st_size, "bytes;",
          [line for line in told if " " not in line or line.startswith("Link")])
    return 0


if __name__ == "__main__":
    sys.exit(main())

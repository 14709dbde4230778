"""A real client drives a simulated robot through a ProgramLine, while a person takes over and gives back."""

import selectors
import socket
import struct
import threading
import time
from contextlib import closing

import pytest

from pioneer_control.client import Robot, SteeredRobot, VelocityInput
from pioneer_control.errors import LinkError
from pioneer_control.p2os import FrameDecoder, encode_command, encode_frame
from pioneer_control.robots import find_model
from pioneer_control.simulator.line import Server
from pioneer_control.simulator.simulation import simulate
from pioneer_control.simulator.world import load_world
from pioneer_control.web.program_line import INPUT, ProgramLine

PERSON = "person"
PATIENCE = 20.0     # s


def wait_for(what, condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "not within %.0f s: %s" % (PATIENCE, what)
        time.sleep(0.01)


class Owner:
    """The owner's client, the helm, and one TCP port on which a program finds the robot's side of a ProgramLine."""

    def __init__(self, url):
        self.frames, self._decoder = [], FrameDecoder()
        self._wake, self._waker = socket.socketpair()
        self.robot = Robot(url, on_wire=self._hear)
        self.steered = SteeredRobot(self.robot, {
            INPUT: VelocityInput(10, 0.6), PERSON: VelocityInput(100, 0.5, True)}, {PERSON: "a person has the helm"})
        self.said = []
        self._port = socket.create_server(("127.0.0.1", 0))
        self.url = "socket://127.0.0.1:%d" % self._port.getsockname()[1]
        self.robot.start()
        self.robot.wait_until_ready()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _hear(self, to_robot, data):
        if not to_robot:
            self.frames += self._decoder.feed(data)
            self._waker.send(b"\0")

    def _run(self):
        while not self._ended.is_set():
            self._port.settimeout(0.1)
            try:
                program, _ = self._port.accept()
            except socket.timeout:
                continue
            with program:
                self._serve(program)

    def _serve(self, program):
        line = ProgramLine(self.robot, self.steered, "Ada", self.said.append)
        with selectors.DefaultSelector() as selector:
            selector.register(program, selectors.EVENT_READ)
            selector.register(self._wake, selectors.EVENT_READ)
            while not self._ended.is_set():
                for key, _ in selector.select(0.05):
                    try:
                        data = key.fileobj.recv(4096)
                    except ConnectionResetError:
                        data = b""
                    if key.fileobj is program:
                        if not data:
                            line.end()
                            return
                        line.receive(data, time.monotonic())
                while self.frames:
                    line.report(self.frames.pop(0))
                line.tick(time.monotonic())
                program.sendall(line.data_to_send())

    def close(self):
        self._ended.set()
        self._thread.join()
        self._port.close()
        self.robot.close()


@pytest.fixture
def server():
    with Server(simulate(load_world("empty"), find_model("p3dx-sh"), 1, None, 0), tcp=0) as server:
        yield server


@pytest.fixture
def owner(server):
    with closing(Owner(server.url)) as owner:
        yield owner


def velocity(server):
    with server.lock:
        return round(server.firmware.velocity[0], 2)


def motors(server):
    with server.lock:
        return server.firmware.motors_enabled


def drive(robot, server, wanted):
    """Set a velocity again and again until the robot has it."""
    def reached():
        robot.set_velocity(wanted, 0.0)
        return velocity(server) == wanted
    wait_for("the robot drives %g m/s" % wanted, reached)


def test_a_program_connects_drives_and_ends_as_with_the_robot_itself(server, owner):
    with Robot(owner.url) as robot:
        assert (robot.identity.name, robot.identity.subtype) == ("sim_0001", "p3dx-sh")
        assert robot.identity.firmware == owner.robot.identity.firmware
        assert not robot.state.motors_enabled
        robot.enable_motors()
        drive(robot, server, 0.2)
        wait_for("the program sees it move", lambda: robot.wait_for_state().x > 0.05)
        assert owner.steered.state().commander == INPUT
        wait_for("it stands when the program falls silent", lambda: velocity(server) == 0.0)
    wait_for("motors are off", lambda: not motors(server))
    assert owner.robot.ready      # the owner's own connection goes on


def test_a_person_takes_over_and_the_program_is_locked_out_until_the_release(server, owner):
    with Robot(owner.url) as robot:
        robot.enable_motors()
        drive(robot, server, 0.2)
        owner.steered.set_velocity(PERSON, 0.0, 0.0, "Bob")

        def stands():
            robot.set_velocity(0.2, 0.0)
            return velocity(server) == 0.0

        wait_for("the robot stands", stands)
        for _ in range(20):
            assert stands()
            robot.wait_for_state()
        assert any("a person has the helm" in text for text in owner.said)
        owner.steered.release()
        drive(robot, server, 0.2)


def test_a_program_that_connects_disturbs_no_person_who_drives(server, owner):
    """The client of a program switches motors off and stops first of all: that reaches nobody."""
    owner.robot.enable_motors()
    speeds, ended = [], threading.Event()

    def person():
        while not ended.is_set():
            owner.steered.set_velocity(PERSON, 0.1, 0.0)
            speeds.append(velocity(server))
            time.sleep(0.02)

    thread = threading.Thread(target=person)
    thread.start()
    try:
        wait_for("the person drives", lambda: 0.1 in speeds)
        began = speeds.index(0.1)
        with Robot(owner.url) as robot:
            assert not robot.state.motors_enabled
            robot.set_velocity(0.5, 0.0)
            robot.wait_for_state()
        assert len(speeds) > began
    finally:
        ended.set()
        thread.join()
    assert set(speeds[began:]) == {0.1} and motors(server)


def test_a_program_that_dies_stops_at_once(server, owner):
    """Its connection is closed without a last word, as by the system when a process is killed."""
    program = socket.create_connection(("127.0.0.1", int(owner.url.rpartition(":")[2])))
    decoder, seen = FrameDecoder(), []

    def answered(packet, frame_id):
        program.sendall(packet)
        wait_for("an answer", lambda: seen.extend(decoder.feed(program.recv(4096))) or seen[-1].id == frame_id)

    for number in (0, 1, 2):
        answered(encode_frame(number), number)
    for name, value in (("OPEN", 1), ("ENABLE", 1), ("VEL", 200)):
        program.sendall(encode_command(name, value))
        wait_for("motors", lambda: name != "ENABLE" or motors(server))
    wait_for("it drives", lambda: velocity(server) == 0.2)
    program.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    program.close()
    wait_for("the robot stands, its motors off", lambda: velocity(server) == 0.0 and not motors(server))


def test_without_the_robot_a_program_finds_nobody(server, owner):
    server.stop()
    wait_for("the owner has lost its robot", lambda: not owner.robot.ready)
    with pytest.raises(LinkError), Robot(owner.url):
        pass

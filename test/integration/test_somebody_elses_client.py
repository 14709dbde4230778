"""How to test your own client against the simulated robot. docs/simulator.md shows the tests of this file.

`TheirClient` stands for your client. It is written from the tables of the protocol alone and shares no code with this
package.
"""

import socket
import struct

from pioneer_control.robots import find_model
from pioneer_control.simulator import LineSimulation, Server, Simulation, fault_of, load_world

NEAR = 700      # mm


class TheirClient:
    """Drives ahead until its front sonar measures something near, then stands. Call talk() every 100 ms with the bytes
    that were read. It returns the bytes to write.
    """

    def __init__(self):
        self.ranges = {}
        self._got, self._sync = b"", 0

    def talk(self, data):
        for packet in self.packets(data):
            if packet[3] in (0x32, 0x33):
                for number in range(packet[22]):
                    self.ranges.__setitem__(*struct.unpack_from("<BH", packet, 23 + 3 * number))
            elif packet[3] == self._sync < 3:
                self._sync += 1
        if self._sync < 3:
            return self.packet(bytes((self._sync,)))
        if not self.ranges:
            return self.packet(b"\x01") + self.integer(4, 1)
        near = min([self.ranges.get(number, 5000) for number in (2, 3, 4, 5)])
        return self.integer(11, 0 if near < NEAR else 300)

    def packets(self, data):
        self._got += data
        while len(self._got) >= 3 and len(self._got) >= 3 + self._got[2]:
            packet, self._got = self._got[:3 + self._got[2]], self._got[3 + self._got[2]:]
            if packet[:2] == b"\xFA\xFB" and self.checksum(packet[3:-2]) == packet[-2:]:
                yield packet
            else:
                self._got = (packet + self._got)[1:]

    def packet(self, body):
        return b"\xFA\xFB" + bytes((len(body) + 2,)) + body + self.checksum(body)

    def integer(self, command, value):
        return self.packet(struct.pack("<BBH", command, 0x3B, value))

    @staticmethod
    def checksum(body):
        total = 0
        for first, second in zip(body[::2], body[1::2]):
            total += first * 256 + second
        return ((total & 0xFFFF) ^ (body[-1] if len(body) % 2 else 0)).to_bytes(2, "big")


def test_it_stops_in_time_though_a_tenth_of_all_packets_is_lost():
    simulation = Simulation(load_world("corridor"))
    robot = simulation.add(find_model("p3dx-sh"))
    lines = LineSimulation(simulation, seed=7, faults=[fault_of("loss 0.1 from 5")])
    client = TheirClient()
    for _ in range(600):                    # a simulated minute, in a part of a second
        heard = b"".join(arrival.data for arrival in lines.advance(0.1))
        lines.send(0, client.talk(heard), baud=9600)
    assert robot.true_pose[0] > 4.0, "it drove"
    assert robot.velocity == (0.0, 0.0) and robot.contacts == 0, "and stood before it touched anything"


def test_without_sonar_it_does_not_which_shows_that_the_test_can_fail():
    simulation = Simulation(load_world("corridor"))
    robot = simulation.add(find_model("p3dx-sh"))
    lines = LineSimulation(simulation, faults=[fault_of("transducer %d" % number) for number in range(8)])
    client = TheirClient()
    for _ in range(600):
        lines.send(0, client.talk(b"".join(arrival.data for arrival in lines.advance(0.1))), baud=9600)
    assert robot.contacts > 0


def test_a_program_of_its_own_over_tcp_five_times_as_fast():
    simulation = Simulation(load_world("corridor"))
    robot = simulation.add(find_model("p3dx-sh"))
    with Server(simulation, tcp=0, speed=5) as server:
        host, port = server.url[len("socket://"):].split(":")
        run_their_program(host, int(port), lambda: robot.true_pose[0] > 2.0 or server.simulation.time > 300)
        with server.lock:
            assert robot.true_pose[0] > 2.0 and robot.contacts == 0


def run_their_program(host, port, done):
    """Run a program that connects, drives, and ends."""
    client = TheirClient()
    with socket.create_connection((host, port), timeout=20) as line:
        line.settimeout(0.02)
        while not done():
            try:
                heard = line.recv(4096)
            except socket.timeout:
                heard = b""
            line.sendall(client.talk(heard))

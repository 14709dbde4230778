"""What other clients do with an arm, byte for byte, in simulated time (arm sheet 13, 14, 17).

Bytes are made and read by the tables of the sheets, without the package's own codec.
"""

import dataclasses

import pytest

from by_the_sheet import bodies, command, decode

from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.world import World

INFO, STATUS, POWER, HOME, PARK, POS, SPEED, STOP = (command(70), 71, 74, 75, command(76), 77, 78, 79)
MODEL = find_model("p3dx-sh")


def joint(number, joint, value):
    """Return ARM_POS or ARM_SPEED: the value is the low byte, the joint the high one."""
    return command(number, joint << 8 | value)


class Peer:
    """A program that talks to a robot with an arm, in an open session."""

    def __init__(self, **changes):
        numbers = standard_numbers()
        self.robot = Firmware(MODEL, World("hall"), (0.0, 0.0, 0.0), arm=True, numbers=dataclasses.replace(
            numbers, arm=dataclasses.replace(numbers.arm, **changes)))
        self.heard = []
        for number in (0, 1, 2):
            self.say(command(number))
            self.robot.advance(0.02)
        self.say(command(1, 1)).wait(0.5)

    def say(self, *packets):
        for packet in packets:
            self.robot.receive(packet)
        return self

    def wait(self, seconds):
        """Listen for so long, and keep only what comes in this time. The robot's watchdog is fed."""
        self.heard = []
        for _ in range(max(1, round(seconds / 0.5))):
            sent = self.say(command(0)).robot.advance(min(0.5, seconds))
            self.heard += [decode(body, MODEL.firmware_family) for body in bodies(sent)]
        return self

    def of(self, number):
        return [packet.values for packet in self.heard if packet.id == number]

    @property
    def arm(self):
        return self.robot.hardware.arm


class VendorsClient(Peer):
    """The vendor's client. It reads the first two bytes of a status as one word: joints that move, and flags above."""

    GOOD, INITIALISED, POWERED, HOMING = (1 << bit for bit in (8, 9, 10, 11))

    def flags(self):
        """Ask for one status, and return its word."""
        status = self.say(command(STATUS, 1)).wait(0.2).of(0xA0)[-1]
        return status["status"] | status["motion"] << 8

    def begin(self):
        """Ask for status and information. Returns whether both came in time, and the arm is fit for work."""
        self.say(command(STATUS, 1)).wait(0.1)
        statuses = self.of(0xA0)
        self.say(INFO).wait(0.3)
        statuses, infos = statuses + self.of(0xA0), self.of(0xA1)
        if not statuses or not infos or infos[0]["version"] == "No arm":
            return False
        self.joints = infos[0]["joints"]
        word = statuses[-1]["status"] | statuses[-1]["motion"] << 8
        return bool(word & self.GOOD and word & self.INITIALISED)


def test_the_vendors_client_starts_moves_and_parks():
    client = VendorsClient(layout="A")
    assert client.begin() and len(client.joints) == 6 and not client.flags() & client.POWERED
    client.say(command(POWER, 1)).wait(2.0)
    assert client.flags() & client.POWERED
    # a continuous motion: a speed, then a position out of range
    client.say(joint(SPEED, 1, 40), joint(POS, 1, 255)).wait(1.0)
    assert client.flags() & 1
    client.say(command(STOP, 1)).wait(0.2)
    assert not client.flags() & 1
    held = client.arm.servos[0].position
    assert 130 < held < 235
    client.say(joint(SPEED, 1, 10), joint(POS, 1, 0)).wait(8.0)
    assert client.arm.servos[0].position == client.joints[0][2] == 25
    client.say(INFO).wait(0.2)      # its "check"
    assert client.of(0xA1)[0]["joints"][0][0] == 10
    client.say(command(HOME, 0xFF)).wait(0.5)
    assert client.flags() & client.HOMING
    client.wait(6.0)
    client.say(joint(POS, 1, 200)).wait(1.0)
    client.say(PARK).wait(6.0)
    assert not client.flags() & (client.POWERED | client.HOMING)
    client.say(command(2, 1)).wait(0.5)
    assert client.arm.drops == client.arm.jumps == 0


@pytest.mark.parametrize("changes", [{"layout": "M"}, {"linked_at_power_on": False}])
def test_the_vendors_client_refuses_an_arm_that_is_not_fit_in_its_eyes(changes):
    assert not VendorsClient(**changes).begin()


def test_the_vendors_client_finds_no_arm_on_a_robot_without_one():
    client = VendorsClient()
    client.robot.hardware.aux[0].joined = None
    assert not client.begin()


def test_players_driver_starts_moves_and_leaves():
    client = Peer(layout="M").say(command(STATUS, 2), INFO).wait(1.0)
    assert len(client.of(0xA0)) >= 9 and client.of(0xA1)[0]["version"] == "1.7"
    assert client.of(0xA0)[-1]["status"] == 0b10 and client.of(0xA0)[-1]["servo2"] == 37
    client.say(command(POWER, 1)).wait(2.0)
    assert client.of(0xA0)[-1]["status"] == 0b11
    client.say(joint(SPEED, 2, 20), joint(POS, 2, 100)).wait(0.5)
    assert client.of(0xA0)[-1]["motion"] == 0b10
    for position in (200, 70):      # its gripper: the end positions open it and close it
        client.say(joint(POS, 6, position)).wait(3.0)
        assert client.of(0xA0)[-1]["servo6"] == position and client.of(0xA0)[-1]["motion"] == 0
    client.say(command(HOME, 7)).wait(8.0)
    assert [client.of(0xA0)[-1]["servo%d" % number] for number in range(1, 7)] == [130, 37, 235, 130, 183, 180]
    client.say(command(2, 1)).wait(1.0)
    assert not client.arm.powered and client.arm.drops == 0

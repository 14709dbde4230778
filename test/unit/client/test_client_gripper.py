"""Grippers that report in another way than most: Pioneer 1, and P2OS with the gripper on the general I/O port.

Source: protocol sheet 6.3, 6.4.
"""

import dataclasses

import pytest

from pioneer_control import p2os
from pioneer_control.client import GripperReading
from pioneer_control.client.gripper import is_on_general_io, read_pioneer_1_gripper, with_switches
from pioneer_control.client.identity import identify
from pioneer_control.robots import find_model

from fake_robot import config

AT_REST = GripperReading(*[False] * 12)
# The P2OS example of protocol 5.4: nothing in the beams or between the paddles, the paddles move.
SWITCHES = "FAFB06E002B30A930C"


def true_of(reading):
    return {name for name, value in dataclasses.asdict(reading).items() if value}


@pytest.mark.parametrize("digital_in, expected", [
    (0b100111, set()),
    (0b100011, {"paddles_open", "lift_down"}),
    (0b100101, {"paddles_closed"}),
    (0b100110, {"paddles_closed", "lift_up"}),
    (0b101111, {"inner_beam"}),
    (0b110111, {"outer_beam"}),
    (0b000111, {"left_contact", "right_contact"}),
])
def test_the_switches_of_a_pioneer_1(digital_in, expected):
    assert true_of(read_pioneer_1_gripper(digital_in)) == expected


def test_switches_of_a_gripperpac_replace_the_digital_inputs():
    frame, = p2os.FrameDecoder().feed(bytes.fromhex(SWITCHES))
    packet = p2os.decode_packet(frame, False)
    floating = dataclasses.replace(AT_REST, inner_beam=True, outer_beam=True, paddles_open=True)
    assert packet.has_gripper == 2 and true_of(with_switches(floating, packet.state)) == {"paddles_open"}


@pytest.mark.parametrize("bits, expected", [
    (0b111000, {"inner_beam"}),
    (0b110100, {"outer_beam"}),
    (0b100000, {"left_contact"}),
    (0b010000, {"right_contact"}),
])
def test_each_switch(bits, expected):
    assert true_of(with_switches(AT_REST, p2os.GripperSwitches(bits))) == expected


@pytest.mark.parametrize("subtype, number, expected", [
    ("p2dx", 2, True), ("p2dx", 1, False), ("p3dx-sh", 2, False), ("p2dx", 0, False)])
def test_only_a_p2os_robot_that_says_2_has_it_on_the_general_port(subtype, number, expected):
    identity = identify(p2os.SyncReply("fake", "Pioneer", subtype), find_model(subtype), config(has_gripper=number))
    assert is_on_general_io(identity) is expected


def test_a_robot_that_says_nothing_has_it_on_the_digital_inputs():
    identity = identify(p2os.SyncReply("fake", "Pioneer", "p2dx"), find_model("p2dx"), None, has_gripper=True)
    assert not is_on_general_io(identity)

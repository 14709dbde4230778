"""The two layouts of a status packet (arm sheet 13)."""

import itertools

import pytest

from pioneer_control import p2os
from pioneer_control.arm.status import ArmStatus, StatusReader, layout_of

TICKS = (130, 37, 235, 130, 183, 180)


def packet(first, second):
    return p2os.Arm(first, second, TICKS)


@pytest.mark.parametrize("first, second, layout", [
    (0x02, 0x00, "M"), (0x03, 0x00, "M"), (0x00, 0x03, "A"), (0x00, 0x07, "A"),     # as the sheet says
    (0x03, 0x02, "M"), (0x02, 0x07, "A"), (0x3F, 0x0F, "A"), (0x03, 0x3F, "M"), (0x00, 0x01, "A"), (0x00, 0x02, "A"),
    (0x00, 0x00, None), (0x03, 0x07, None), (0x03, 0x0F, None),                     # both make sense
    (0x01, 0x00, None), (0x80, 0x00, None), (0x00, 0x80, None), (0xFF, 0xFF, None),     # neither does
])
def test_layout(first, second, layout):
    assert layout_of(packet(first, second)) == layout


def encoded(layout, linked, powered, homing, moving):
    bits = sum(1 << joint for joint in moving)
    if layout == "M":
        return packet(powered | linked << 1, bits)
    return packet(bits, linked | linked << 1 | powered << 2 | homing << 3)


STATES = [(True, powered, homing, moving)
          for powered, homing, moving in itertools.product((False, True), (False, True),
                                                           ((), (0,), (1,), (0, 1), (0, 1, 2), (5,), tuple(range(6))))
          if powered or not homing and not moving]


@pytest.mark.parametrize("layout", ["A", "M"])
def test_whatever_comes_is_never_taken_for_the_other_layout(layout):
    other = {"A": "M", "M": "A"}[layout]
    for state in STATES:
        assert layout_of(encoded(layout, *state)) != other


@pytest.mark.parametrize("layout", ["A", "M"])
@pytest.mark.parametrize("told", [True, False])
def test_what_it_means(layout, told):
    for linked, powered, homing, moving in STATES:
        reader = StatusReader(layout if told else None)
        assert reader.read(encoded(layout, True, False, False, ())) is not None and reader.layout == layout
        assert reader.read(encoded(layout, linked, powered, homing, moving)) == ArmStatus(
            linked, powered, homing and layout == "A", tuple(joint in moving for joint in range(6)), TICKS)


def test_an_arm_that_does_not_answer_is_understood_before_its_layout_is_known():
    reader = StatusReader()
    assert reader.read(packet(0, 0)) == ArmStatus(False, False, False, (False,) * 6, TICKS) and reader.layout is None
    assert reader.read(packet(3, 7)) is None and reader.layout is None
    assert reader.read(packet(0, 7)).powered and reader.layout == "A"
    assert reader.read(packet(3, 7)).moving == (True, True, False, False, False, False)


def test_a_forced_layout_is_kept_and_a_packet_that_contradicts_it_is_seen():
    reader = StatusReader("M")
    assert reader.read(packet(2, 0)).linked and not reader.contradicted
    assert not reader.read(packet(0, 7)).powered and reader.layout == "M" and reader.contradicted
    assert reader.read(packet(0, 0)) is not None and not reader.contradicted
    assert not StatusReader("A").read(packet(3, 0)).powered

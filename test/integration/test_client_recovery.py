"""How long it takes until the next pose after a bad line is good again: a session with the real pauses between
attempts, in simulated time.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from faulty_link import Rig, Velocity, lost

LIMIT = 2.0         # s
# s that the simulated robot does not hear after it is switched on; counted, but for a line that is slow itself
BOOT = 1.0
SEEDS = range(8)
LASTED = 20.0       # s


def two_bits_flipped(rig):
    """Flip two bits of every packet, in both directions."""
    def flip(packet):
        spoilt = bytearray(packet)
        for bit in rig.chance.sample(range(8 * len(packet)), 2):
            spoilt[bit // 8] ^= 1 << bit % 8
        return (bytes(spoilt),)

    rig.to_robot.fault = rig.to_client.fault = flip


def two_bits_flipped_to_the_client(rig):
    two_bits_flipped(rig)
    rig.to_robot.fault = lambda packet: (packet,)


def cable_pulled_from_the_computer(rig):
    rig.pull()


def cable_pulled_from_the_robot(rig):
    rig.to_robot.fault = rig.to_client.fault = lost


def switched_off(rig):
    """Switch the robot off. It boots when the line is mended."""
    cable_pulled_from_the_robot(rig)
    mend = rig.mend
    rig.mend = lambda: (mend(), rig.firmware.power_cycle())


def switched_off_with_its_bridge(rig):
    switched_off(rig)
    rig.pull()


@pytest.mark.parametrize("baud", [None, 9600, 115200])
@pytest.mark.parametrize("befall", [
    two_bits_flipped, two_bits_flipped_to_the_client,
    cable_pulled_from_the_computer, cable_pulled_from_the_robot,
    switched_off, switched_off_with_its_bridge,
])
def test_the_next_pose_comes_soon_after_the_fault(befall, baud):
    times = []
    for seed in SEEDS:
        rig = Rig(seed=seed, baud=baud and (baud, baud))
        rig.run_until(lambda: rig.ready)
        rig.switch_motors_on()
        rig.commanding = Velocity(0.3, 0.0)
        rig.run(2.0)
        befall(rig)
        rig.run(LASTED + rig.chance.uniform(0.0, 3.0))
        states = rig.states
        rig.mend()
        times.append(rig.run_until(lambda: rig.states > states))
        rig.run(1.0)
        pose = rig.firmware.true_pose
        rig.run(2.0)
        assert rig.ready and not rig.firmware.motors_enabled and rig.firmware.true_pose == pose
    assert max(times) < LIMIT + (0.2 * BOOT if befall is switched_off and baud == 9600 else 0.0), sorted(times)

"""A driver is killed while the robot drives, and started again on a line that loses packets. The tests check how far
the robot moves until it is closed.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from faulty_link import Rig, Velocity, packets_in

from pioneer_control.client.handshake import CLOSES
from pioneer_control.robots import find_model, load_table
from pioneer_control.robots.table import FAMILIES
from pioneer_control.simulator.firmware import Firmware, FirmwareState
from pioneer_control.simulator.world import World

STARTS = 40
NEVER = 0.0          # m
WATCHED = 3.5       # s after which the robot's watchdog has stopped it; it is open, and remembers its set points

MODELS = sorted(load_table().models.items())
OLDEST_FIRST = [next(subtype for subtype, model in MODELS if model.firmware_family == family)
                for family in FAMILIES]


@pytest.mark.parametrize("baud", [None, 9600])
@pytest.mark.parametrize("subtype", OLDEST_FIRST)
@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_waiting_robot_of_any_age_is_connected(subtype, baud, share):
    """One model of each firmware family, from PSOS on. On a line that loses nothing, the first attempt connects."""
    rig = Rig(Firmware(find_model(subtype), World("floor"), (0.0, 0.0, 0.0)), baud=baud and (baud, baud))
    rig.to_robot.fault = rig.to_client.fault = lambda packet: (packet,) if rig.chance.random() >= share else ()
    heard = []
    rig.judge.wrote = lambda data: heard.extend(packet[3] for packet in packets_in(data))
    assert rig.run_until(lambda: rig.ready, 20.0) < (1.6 if share == 0.0 else 20.0)
    closes = [] if baud is None else [2] * CLOSES
    assert share or heard[:len(closes) + 4] == closes + [0, 1, 2, 1]
    assert rig.state is not None and not rig.state.motors_enabled


@pytest.mark.parametrize("baud", [None, 9600])
def test_a_robot_left_open_is_connected_within_two_seconds(baud):
    rig = Rig(baud=baud and (baud, baud))
    rig.run_until(lambda: rig.ready)
    rig.switch_motors_on()
    rig.kill(WATCHED)
    rig.run(WATCHED)
    assert rig.firmware.session is FirmwareState.OPEN and not rig.ready
    assert rig.run_until(lambda: rig.ready) < 2.0


def moves_after_a_restart(seed, share, baud):
    """Return how far (m) the robot moves after a new driver has started."""
    rig = Rig(seed=seed, baud=baud and (baud, baud))
    rig.run_until(lambda: rig.ready)
    rig.switch_motors_on()
    rig.commanding = Velocity(0.3, 0.2)
    rig.run(1.0 + rig.chance.uniform(0.0, 0.1))
    rig.commanding = None
    rig.to_robot.fault = rig.to_client.fault = lambda packet: (packet,) if rig.chance.random() >= share else ()
    rig.kill(WATCHED)
    rig.run(WATCHED)
    assert (rig.firmware.session is FirmwareState.OPEN and rig.firmware.motors_enabled and
            rig.firmware.velocity == (0.0, 0.0))
    before = rig.judge.distance
    rig.run_until(lambda: rig.firmware.session is FirmwareState.WAITING)
    rig.run(0.5)
    return rig.judge.distance - before


@pytest.mark.parametrize("baud, share, may_stir, farthest", [
    (9600, 0.01, 0, NEVER),
    (9600, 0.2, 0, NEVER),
    (9600, 0.5, 2, 0.01),
    (None, 0.01, 0, NEVER),
    (None, 0.2, 2, 0.02),
    (None, 0.5, 8, 0.06),
])
def test_a_robot_left_open_does_not_stir_at_a_restart(baud, share, may_stir, farthest):
    """On a serial line that loses 50 % of the packets, one start of thousands moves the robot, and nobody can prevent
    that: no packet from the robot comes through, no CLOSE reaches it, but the SYNC0 behind them does. TCP itself loses
    nothing. Behind a radio that loses packets, SYNC0 is the first packet to a robot that was not heard.
    """
    moved = [moves_after_a_restart(seed, share, baud) for seed in range(STARTS)]
    assert sum(distance > 1e-6 for distance in moved) <= may_stir and max(moved) <= farthest + 1e-6, moved

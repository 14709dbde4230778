"""A simulated robot for the benches, without ROS. It is connected, open and enabled.

A bench sees and drives it through its packets. To judge a run, a bench may also look at the true state in `firmware`.
"""

import math
import os
import sys
from typing import List, NamedTuple, Optional, Tuple

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src"))

from pioneer_control import p2os
from pioneer_control.client.gripper import GripperReading, read_gripper
from pioneer_control.client.odometry import Odometry
from pioneer_control.message_values import GripStatus, LiftStatus
from pioneer_control.floor_poses import Pose
from pioneer_control.navigation.firings import timed
from pioneer_control.navigation.values import Sensing
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware.robot_numbers import RobotNumbers
from pioneer_control.tutorial.snapshot import Grip, Lift, RobotShape, Snapshot

CYCLE = 0.1  # s from one standard packet to the next
LATENCY = 0.08  # s from a packet to the arrival of the command that answers it
NOT_HEARD = 2.0  # s after which the driver forgets a range


class Setup(NamedTuple):
    """The equipment of a robot for a bench. `numbers`: of the simulated robot; those of robot.yaml if None."""

    model: str
    gripper: bool = False
    rear_sonar: bool = True
    numbers: Optional[RobotNumbers] = None


class SimulatedRobot:
    """A robot that is connected, open and enabled. A bench sees and drives it through its packets. `firmware` has the
    true state.
    """

    def __init__(self, setup: Setup, world, seed: int):
        model = find_model(setup.model)
        self.firmware = Firmware(
            model, world, gripper=setup.gripper, rear_sonar=setup.rear_sonar, seed=seed, numbers=setup.numbers)
        fitted = model.with_arrays(front=True, rear=setup.rear_sonar)
        self.shape = RobotShape(fitted.sonar, model.outline(setup.gripper))
        self.model = model
        self._decoder = p2os.FrameDecoder()
        self._odometry = Odometry(model.dist_mm_per_unit, model.angle_units_per_rev)
        self._lift_position = 0.0
        self._heard: List[Optional[Tuple[float, float]]] = [None] * fitted.sonar_count
        for step in (p2os.SYNC0, p2os.SYNC1, p2os.SYNC2):
            self.firmware.receive(p2os.encode_frame(step))
        for command in (("OPEN",), ("ENABLE", 1), ("SONAR", 1)):
            self.firmware.receive(p2os.encode_command(*command))

    def listen(self) -> Snapshot:
        """Let time pass until a standard packet has come, and return what is known then, for a wander."""
        return self._snapshot(self._next_sip())

    def sense(self) -> Sensing:
        """Let time pass until a standard packet has come, and return what it says, for navigation."""
        return self._sensing(self._next_sip())

    def sense_both(self) -> Tuple[Sensing, Snapshot]:
        """Let time pass until a standard packet has come, and return what it says, for navigation and for a wander."""
        sip = self._next_sip()
        return self._sensing(sip), self._snapshot(sip)

    def _sensing(self, sip: p2os.Sip) -> Sensing:
        return Sensing(self.firmware.time, Pose(*self._odometry.pose),
                       timed(self._ranges(sip), self.firmware.time))

    def _next_sip(self) -> p2os.Sip:
        while True:
            frames = self._decoder.feed(self.firmware.advance(CYCLE / 5))
            for frame in frames:
                packet = p2os.decode_packet(frame)
                if isinstance(packet, p2os.Sip):
                    self._odometry.update(packet.x_counts, packet.y_counts, packet.heading_units)
                    return packet

    def _ranges(self, sip: p2os.Sip) -> List[Tuple[int, float]]:
        """Return number and range (m) of each reading in a packet, in its order."""
        return [(reading.number, reading.range_units * self.model.range_mm_per_unit / 1000.0) for reading in sip.sonar]

    def _snapshot(self, sip: p2os.Sip) -> Snapshot:
        now = self.firmware.time
        for number, heard in self._ranges(sip):
            self._heard[number] = (heard, now)
        ranges = tuple(heard[0] if heard and now - heard[1] < NOT_HEARD else 0.0 for heard in self._heard)
        grip = lift = None
        if self.firmware.gripper:
            grip, lift = self._reported(read_gripper(sip.grip_state, sip.digital_in))
        stalled = bool(sip.left_stall_bits & 1 or sip.right_stall_bits & 1)
        return Snapshot(now, 0.0, Pose(*self._odometry.pose), ranges, self.shape, grip, lift, stalled)

    def _reported(self, reading: GripperReading) -> Tuple[Grip, Lift]:
        """Return the gripper as gripper_state would report it."""
        paddles = (GripStatus.OPEN if reading.paddles_open else
                   GripStatus.CLOSED if reading.paddles_closed else GripStatus.BETWEEN)
        state = GripStatus.MOVING if reading.paddles_moving else paddles
        grip = Grip(state, 0, reading.inner_beam, reading.outer_beam, reading.left_contact, reading.right_contact)
        at_an_end = reading.lift_up or reading.lift_down
        if at_an_end and not reading.lift_moving:
            self._lift_position = float(reading.lift_up)
        lift = LiftStatus.MOVING if reading.lift_moving else LiftStatus.IDLE if at_an_end else LiftStatus.STALLED
        return grip, Lift(lift, 0, self._lift_position)

    def command(self, linear: float, angular: float) -> None:
        """Drive at m/s and rad/s, from LATENCY after the last packet on."""
        self.firmware.advance(LATENCY)
        self.firmware.receive(p2os.encode_command("VEL", round(linear * 1000)))
        self.firmware.receive(p2os.encode_command("RVEL", round(math.degrees(angular))))

    def command_gripper(self, grip: int, lift: int) -> None:
        """Give the two commands of a step, from LATENCY after the last packet on."""
        self.firmware.advance(LATENCY)
        for number in (grip, lift):
            self.firmware.receive(p2os.encode_command("GRIPPER", int(number)))

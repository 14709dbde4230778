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
from pioneer_control.floor_poses import Pose, between, relative
from pioneer_control.navigation.firings import timed
from pioneer_control.navigation.values import Scan, Sensing
from pioneer_control.lms2xx import TURN_S, Variant
from pioneer_control.robots import LaserPlace, find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware.robot_numbers import RobotNumbers
from pioneer_control.simulator.line.lasers import PoseHistory
from pioneer_control.simulator.lms200 import Optics
from pioneer_control.simulator.lms200.ray_plans import complete_scan
from pioneer_control.simulator.world.poses import compose as composed
from pioneer_control.tutorial.snapshot import Grip, Lift, RobotShape, Snapshot

CYCLE = 0.1  # s from one standard packet to the next
LATENCY_STEPS = 4  # fifths of a cycle from a packet to the arrival of the command that answers it
NOT_HEARD = 2.0  # s after which the driver forgets a range


class Setup(NamedTuple):
    """The equipment of a robot for a bench. `numbers`: of the simulated robot; those of robot.yaml if None. `laser`: an
    LMS200, where the model has its laser, or an AmigoBot with a laser.
    """

    model: str
    gripper: bool = False
    rear_sonar: bool = True
    numbers: Optional[RobotNumbers] = None
    laser: bool = False


class BenchLaser:
    """The laser of a simulated robot: an LMS200 that looks 180 degrees wide in steps of 1 degree, at 500000 baud.

    Of the 75 scans a second, navigation takes one a packet.

    Args:
        firmware: the robot.
        world: its world.
        place: where the laser sits.
        seed: of its errors.
    """

    PLAN = complete_scan(Variant(180, 100))
    ON_THE_LINE = 0.010     # s from the end of a scan to its arrival

    def __init__(self, firmware: Firmware, world, place: LaserPlace, seed: int):
        self._mount = Pose(place.x, place.y, 0.0)
        self._optics, self._firmware = Optics(world, seed=seed, carrier=firmware.hardware.body), firmware
        self._history = PoseHistory(firmware, round(firmware.time * 1e6))

    def note(self) -> None:
        """Note where the robot is. Call this after each step of it."""
        self._history.note(round(self._firmware.time * 1e6))

    def scan(self, before: Tuple[float, Pose], now: Tuple[float, Pose]) -> Scan:
        """Return the newest scan that has arrived. `before` and `now`: times (s) of two packets, and their odometry."""
        ready = now[0] - self.ON_THE_LINE
        begin = ready // TURN_S * TURN_S - TURN_S
        measured = self._optics.measure(self.PLAN, begin, lambda at: composed(self._history.pose_at(at), self._mount))
        swept = self.PLAN.after[-1]
        first, middle, last = (between(before[1], now[1], (at - before[0]) / (now[0] - before[0]))
                               for at in (begin, begin + swept / 2.0, begin + swept))
        return Scan(begin + swept / 2.0, middle, self._mount, self.PLAN.angles[0], math.radians(1.0),
                    measured.distances.round(3), relative(first, last))


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
        self._laser: Optional[BenchLaser] = None
        self._before: Optional[Tuple[float, Pose]] = None       # of the last packet: time (s), odometry
        if setup.laser:
            place = (model if model.laser is not None else find_model("amigo-sh-tim3xx")).laser
            self._laser = BenchLaser(self.firmware, world, place, seed)
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
        now, before = (self.firmware.time, Pose(*self._odometry.pose)), self._before
        self._before = now
        scan = self._laser.scan(before, now) if self._laser is not None and before is not None else None
        return Sensing(*now, timed(self._ranges(sip), self.firmware.time), scan=scan)

    def _next_sip(self) -> p2os.Sip:
        while True:
            frames = self._decoder.feed(self._pass(1))
            for frame in frames:
                packet = p2os.decode_packet(frame)
                if isinstance(packet, p2os.Sip):
                    self._odometry.update(packet.x_counts, packet.y_counts, packet.heading_units)
                    return packet

    def _pass(self, steps: int) -> bytes:
        """Let so many fifths of a cycle pass, and return what the robot sends."""
        if self._laser is None:
            return self.firmware.advance(steps * CYCLE / 5)
        sent = b""
        for _ in range(steps):
            sent += self.firmware.advance(CYCLE / 5)
            self._laser.note()
        return sent

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
        """Drive at m/s and rad/s, from LATENCY_STEPS after the last packet on."""
        self._pass(LATENCY_STEPS)
        self.firmware.receive(p2os.encode_command("VEL", round(linear * 1000)))
        self.firmware.receive(p2os.encode_command("RVEL", round(math.degrees(angular))))

    def command_gripper(self, grip: int, lift: int) -> None:
        """Give the two commands of a step, from LATENCY_STEPS after the last packet on."""
        self._pass(LATENCY_STEPS)
        for number in (grip, lift):
            self.firmware.receive(p2os.encode_command("GRIPPER", int(number)))

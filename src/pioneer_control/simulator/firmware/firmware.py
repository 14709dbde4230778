"""The robot's side of P2OS, without I/O: it receives bytes, lets simulated time pass, and returns bytes.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world import load_world
>>> robot = Firmware(find_model("p3dx-sh"), load_world("empty"))
>>> robot.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> robot.advance(0.1).hex()
'fafb03000000'

This file uses no threads, no sockets and no real time. The same bytes at the same simulated times, with the same seed,
always give the same answer. It does not matter into how many calls the time is split.
"""

from ... import p2os
from ...p2os import SYNC0, SYNC2, Frame, ReceivedCommand
from .commanded_robot import CommandedRobot
from .commands import HANDLERS
from .robot_on_line import FirmwareState

PARTIAL_TIMEOUT_US = round(p2os.PARTIAL_TIMEOUT * 1e6)


class Firmware(CommandedRobot):
    """A simulated robot with firmware, hardware and a serial line, but without I/O.

    Args:
        model: model of the robot.
        world: world in which the robot stands.
        pose: start pose (m, rad; map frame). The first start of the world if None.
        gripper: whether the robot has a gripper. If None, ``robot.yaml`` decides by the model.
        arm: whether the robot has a Pioneer Arm.
        rear_sonar: whether the rear sonar array is fitted.
        name: name of the robot, which it sends in its answer to SYNC2.
        seed: seed of the sonar noise and of the wheels' slip and noise.
        noise: largest random error of a sonar range (m). The value of ``robot.yaml`` if None.
        numbers: parameters of the simulated robot. Those of ``robot.yaml`` if None.
        clock: clock of the `Simulation` to which the robot belongs. A new clock if None.
        line_laser: whether the robot has a laser over its own line, as the vendor's simulator offers it.

    Attributes:
        world: as the argument.
        numbers: as the argument.
        hardware: the robot's devices.
        settings: numbers that a client may set without any effect on the hardware, by their names in CONFIGpac.
        decoder: decoder of the received bytes. It has the frame counts since power-on.
        line_laser: the laser over the robot's own line. None without one.
        open_session: state of the open session. None while no session is open.
        command_counts: numbers of received commands since power-on: "obeyed", "unknown", and with a value of the wrong
            type ("senseless").
        unknown_commands: names of received commands that the firmware does not know.
        baud: see `RobotOnLine`, as for `session`, `closed_sessions` and `next_step_us`.

    Raises:
        ParameterError: the model cannot carry a gripper, the arm's auxiliary port has a device already, the robot
            overlaps an obstacle, the noise is negative, or the serial number says SIM without a laser on the line.
    """

    def receive(self, data: bytes) -> None:
        """Receive bytes from the client, as in `RobotOnLine`. While the robot boots, they are lost."""
        if self.clock.now_us >= self._booted_us:
            self._last_byte_us = self.clock.now_us
            for frame in self.decoder.feed(data):
                self._take(frame)

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us` (microseconds), for a robot that is not in a `Simulation`."""
        while self.next_step_us <= end_us:
            self.clock.now_us = self.next_step_us
            self.step()
        self.clock.now_us = end_us

    def step(self) -> None:
        """Run the step of hardware and firmware that is due now: move all devices, and send a SIP if it is due."""
        now_us = self.clock.now_us
        self.next_step_us += self.numbers.physics.step_us
        if now_us - self._last_byte_us >= PARTIAL_TIMEOUT_US and self.decoder.waiting:
            for frame in self.decoder.drop_partial():
                self._take(frame)
        self.hardware.step(now_us, self.watchdog_expired)
        session = self.open_session
        if session is not None and now_us >= session.next_sip_us:
            session.next_sip_us += self.numbers.session.sip_cycle_ms * 1000
            self.send(*session.packets(self.hardware))
            if session.laser is not None and self.line_laser is not None:
                self.send(*self.line_laser.packets(session.laser))

    def _take(self, frame: Frame) -> None:
        command = p2os.decode_command(frame)
        session = self.open_session
        if session is not None:
            session.last_command_us = self.clock.now_us
            if session.laser is not None and session.laser.takes(frame, session.previous):
                self.command_counts["obeyed"] += 1
            else:
                self._obey(command)
            if self.open_session is not None:
                self.open_session.previous = command
        elif self.session is FirmwareState.WAITING:
            self._synchronise(frame.id)
        elif command.name == "OPEN":
            self.begin_session()
        elif command.name == "CLOSE":
            self.close_session()

    def _synchronise(self, number: int) -> None:
        """Answer a packet of the handshake SYNC0, SYNC1, SYNC2. A packet out of order restarts the handshake.

        `number` is the command number of the packet.
        """
        if number != self._next_sync:
            self._next_sync = SYNC0
        if number == self._next_sync == SYNC2:
            self.session = FirmwareState.SYNCED
            self.send(p2os.SyncReply(self.name, "Pioneer", self.model.subtype))
        elif number == self._next_sync:
            self._next_sync += 1
            self.send(p2os.SyncEcho(number))

    def _obey(self, command: ReceivedCommand) -> None:
        handler, counts = HANDLERS.get(command.name), self.command_counts
        if handler is None or not handler.known_to(self.model.firmware_family):
            counts["unknown"] += 1
            self.unknown_commands.add(command.name)
        elif handler.value is not None and not isinstance(command.value, handler.value):
            counts["senseless"] += 1
        else:
            counts["obeyed"] += 1
            if handler.value is not int or command.value in handler.legal:
                handler.act(self, command.value)

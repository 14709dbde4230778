"""The robot's side of P2OS, without I/O: bytes of a client go in, simulated time passes, bytes of the robot come out.

>>> from pioneer_control.robots import find_model
>>> from pioneer_control.simulator.world import load_world
>>> robot = Firmware(find_model("p3dx-sh"), load_world("empty"))
>>> robot.receive(bytes.fromhex("FAFB03000000"))    # SYNC0
>>> robot.advance(0.1).hex()
'fafb03000000'

No thread, clock of the computer or socket is in here: the same bytes at the same simulated times, with the same seed,
give the same answer however the time is split.
"""

from ... import p2os
from ...p2os import SYNC0, SYNC2, Frame, ReceivedCommand
from .commanded_robot import CommandedRobot
from .commands import HANDLERS
from .robot_on_line import FirmwareState

PARTIAL_TIMEOUT_US = round(p2os.PARTIAL_TIMEOUT * 1e6)


class Firmware(CommandedRobot):
    """A simulated robot, as its serial line shows it.

    Args:
        model: which robot.
        world: the world it stands in.
        pose: where it stands (x, y, heading: m, rad; map frame); the first start of the world if None.
        gripper: whether it has one; None: if ``robot.yaml`` fits one to this model.
        rear_sonar: whether the rear array is fitted.
        name: which it tells at SYNC2.
        seed: of the noise.
        noise: every sonar range is off by up to this much (m); None: as ``robot.yaml`` says.
        numbers: other numbers than those of ``robot.yaml``.
        clock: the time of the simulation it is in, for a robot among others (see `Simulation`).

    Attributes:
        model, world, numbers: as the arguments; the model as far as it is fitted.
        hardware: its devices.
        settings: what a client may set and CONFIGpac shows, by its name there.
        decoder: of what the line brings; it has the counts since power-on.
        open_session: what is known of a client, None while no session is open.
        command_counts: commands since power-on: obeyed, unknown, without a value that makes sense.
        unknown_commands: names of commands that came and that its firmware does not know.
        baud, session, closed_sessions, next_step_us: see `RobotOnLine`.

    Raises:
        ParameterError: a gripper on a model that cannot carry one, a place in a wall, or a negative noise.
    """

    def receive(self, data: bytes) -> None:
        """Take bytes from the client, as `RobotOnLine` says. While it boots, the robot does not hear them."""
        if self.clock.now_us >= self._booted_us:
            self._last_byte_us = self.clock.now_us
            for frame in self.decoder.feed(data):
                self._take(frame)

    def run_to(self, end_us: int) -> None:
        """Let simulated time pass until `end_us`, for a robot that is alone."""
        while self.next_step_us <= end_us:
            self.clock.now_us = self.next_step_us
            self.step()
        self.clock.now_us = end_us

    def step(self) -> None:
        """Take the step that is due now."""
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

    def _take(self, frame: Frame) -> None:
        command = p2os.decode_command(frame)
        if self.open_session is not None:
            self.open_session.last_command_us = self.clock.now_us
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
        """Take a step of the SYNC sequence. What is out of order starts it again."""
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
            self.command_counts = counts._replace(unknown=counts.unknown + 1)
            self.unknown_commands.add(command.name)
        elif handler.value is not None and not isinstance(command.value, handler.value):
            self.command_counts = counts._replace(senseless=counts.senseless + 1)
        else:
            self.command_counts = counts._replace(obeyed=counts.obeyed + 1)
            if handler.value is not int or command.value in handler.legal:
                handler.act(self, command.value)

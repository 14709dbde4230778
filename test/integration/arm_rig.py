"""An ArmSession and a simulated robot with an arm, joined in simulated time: no client, no thread, no clock."""

import dataclasses

from pioneer_control import p2os
from pioneer_control.arm.joints import JointSettings
from pioneer_control.arm.phases import ArmSettings
from pioneer_control.arm.session import ArmSession
from pioneer_control.robots import find_model
from pioneer_control.simulator.firmware import Firmware
from pioneer_control.simulator.hardware import standard_numbers
from pioneer_control.simulator.world import World

STEP = 0.02
SPEEDS = (JointSettings(0.5),) * 5 + (JointSettings(0.02),)
MODEL = find_model("p3dx-sh")


def robot_with_arm(arm=True, **changes):
    """Return a simulated robot. ``changes`` are numbers of its arm."""
    numbers = standard_numbers()
    return Firmware(MODEL, World("hall"), (0.0, 0.0, 0.0), arm=arm, noise=0.0,
                    numbers=dataclasses.replace(numbers, arm=dataclasses.replace(numbers.arm, **changes)))


class ArmRig:
    """A session that is connected to a robot.

    Attributes:
        sent: the commands that the session has sent: name, value.
        notices: the texts of its notices.
        to_robot, from_robot: functions that say whether a packet of the session arrives, and one of the robot.
    """

    def __init__(self, arm=True, settings=None, connect=True, **changes):
        self.robot = robot_with_arm(arm, **changes)
        self.session = ArmSession(settings or ArmSettings(SPEEDS))
        self.now = 1000.0
        self.sent, self.notices = [], []
        self.to_robot = self.from_robot = lambda packet: True
        self._decoder = p2os.FrameDecoder()
        for number in (0, 1, 2):
            self.robot.receive(p2os.encode_frame(number))
            self.robot.advance(STEP)
        self.robot.receive(p2os.encode_command("OPEN"))
        if connect:
            self.session.connected(None, self.now)
            self.wait(1.5)

    @property
    def arm(self):
        """The simulated arm."""
        return self.robot.hardware.arm

    @property
    def condition(self):
        return self.session.phase.condition

    @property
    def positions(self):
        """Values of the joints by name, as the session knows them."""
        arm = self.session.phase
        return {name: joint.value(arm.status.ticks[joint.number - 1]) for name, joint in arm.joints.items()}

    @property
    def names(self):
        """The names of the commands that were sent."""
        return [name for name, _ in self.sent]

    def wait(self, seconds):
        """Let time pass."""
        end = self.now + seconds - STEP / 2
        while self.now < end:
            self._exchange()
            self.now += STEP
        return self

    def until(self, holds, limit=30.0):
        """Wait until a condition holds."""
        end = self.now + limit
        while not holds():
            assert self.now < end, "not within %g s; the arm is %s: %s" % (limit, self.condition, self.notices[-3:])
            self.wait(STEP)
        return self

    def finish(self, order, problem=""):
        """Wait until an order is done, or fails for a reason that contains ``problem``."""
        self.until(lambda: order.problem is not None)
        assert problem in order.problem and bool(problem) == bool(order.problem), order.problem
        return self

    def powered(self):
        """Switch the servo power on."""
        return self.finish(self.session.power_on(self.now))

    def _exchange(self):
        for packet in self.session.take_commands():
            command = p2os.decode_command(next(iter(p2os.FrameDecoder().feed(packet))))
            self.sent.append((command.name, command.value))
            if self.to_robot(command):
                self.robot.receive(packet)
        self.robot.receive(p2os.encode_command("PULSE"))
        for frame in self._decoder.feed(self.robot.advance(STEP)):
            packet = p2os.decode_packet(frame, True)
            if not isinstance(packet, p2os.Sip) and self.from_robot(packet):
                self.session.packet(packet, self.now)
        if self.now >= self.session.due:
            self.session.tick(self.now)
            assert self.now < self.session.due, "it would be ticked for ever"
        self.notices += [notice.text for notice in self.session.take_notices()]

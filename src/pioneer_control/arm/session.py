"""One arm on the line of a robot: finds it, keeps its status, and carries out orders. Sans-I/O, a ``LineDevice``.

How it goes, with the safety order of the arm sheet, 18:

* When the robot is connected, the arm is asked for its status, continuously, and for what it is. Where there is none,
  or no answer within 2 s, the session has no arm until the robot is connected anew.
* Nothing powers the arm on unasked, and nothing moves it when it is found. An arm whose controller does not answer gets
  one ARM_INIT, which moves nothing.
* Before power, each joint gets a slow speed, and both timers of the arm are set. Then it gets power, and time to shake.
* Each motion is checked against the limits of the arm and of the user, and each of its steps against the largest one.
* Stop is ARM_STOP: power stays on, because an arm without power falls down.
* `hold` is for an emergency: the arm stops, and obeys nothing but a stop until `release`.
* At the end it stops, parks, and `ended` tells when its power is off.
* The arm's timers move it by themselves. A notice says so half a minute before.

Each phase is an object of ``phases``.
"""

from typing import Any, Dict, List, Sequence, Union

from .. import p2os
from ..errors import LinkError, RefusedError
from ..p2os import encode_command
from .motion import Point, plan
from .orders import STOP, ArmOrder, Home, Init, JointMotion, Park, ServoPowerOn
from .phases import Absent, ArmOutput, ArmSettings, Asking, Away, Fitted, Notice


class ArmSession:
    """The arm of one robot. See the docstring of this file.

    Every method that commands raises RefusedError with the reason when the arm cannot obey now, and LinkError without a
    link; then nothing is sent. Those that return an order return at once; the order tells when it is done.

    Args:
        settings: what the user says of the arm.

    Attributes:
        phase: the present phase.
        statuses: how many status packets were understood so far.
    """

    def __init__(self, settings: ArmSettings) -> None:
        self._settings = settings
        self.phase: Union[Away, Asking, Absent, Fitted] = Away()
        self.statuses = 0
        self._held: Dict[str, str] = {}
        self._ending = False
        self._output = ArmOutput()

    # -- as a LineDevice

    @property
    def due(self) -> float:
        """Time (s) by which `tick` must be called; infinity when nothing is due."""
        return self.phase.due

    @property
    def stops(self) -> Sequence[bytes]:
        """The packet that stops the arm."""
        return (STOP,)

    @property
    def ended(self) -> bool:
        """Whether the arm rests, after `end`."""
        return self._ending and not (isinstance(self.phase, Fitted) and self.phase.present_order is not None)

    def connected(self, identity: Any, now: float) -> None:
        """Begin: ask for the status, continuously, and for what the arm is."""
        self.phase = Asking(self._settings.layout, self._output, now)

    def disconnected(self, now: float) -> None:
        """Forget the arm: the link is gone. The robot's own server parks it."""
        if isinstance(self.phase, Fitted):
            self.phase.end_orders("the link to the robot is gone")
        self.phase = Away()
        self._output.packets.clear()

    def packet(self, packet: Any, now: float) -> None:
        """Take a packet of the robot that is not a SIP."""
        phase = self.phase
        if isinstance(packet, p2os.ArmInfo) and isinstance(phase, Asking):
            if packet.joints and packet.version != "No arm":
                phase.info = packet
            else:
                self.phase = Absent("the robot reports that it has no arm", self._output)
        elif isinstance(packet, p2os.Arm) and isinstance(phase, Asking):
            status = phase.read(packet, now)
            if phase.reader.contradicted:
                self.phase = Absent("its status packets do not have the layout %s that the parameter arm_layout says"
                                    % phase.reader.layout, self._output)
            elif status is not None and phase.info is not None:
                self.statuses += 1
                self._found(Fitted(phase.info, self._settings, phase.reader, status, self._output, now), now)
        elif isinstance(packet, p2os.Arm) and isinstance(phase, Fitted):
            status = phase.reader.read(packet)
            if status is not None:
                self.statuses += 1
                phase.saw(status, now)

    def tick(self, now: float) -> None:
        """Do what time makes due."""
        phase = self.phase
        if isinstance(phase, Asking) and now >= phase.due:
            why = phase.why_absent(now)
            if why is not None:
                self.phase = Absent(why, self._output)
        elif isinstance(phase, Fitted):
            phase.tick(now)

    def end(self, now: float) -> None:
        """Stop the arm and park it, if it has power, whatever holds it: its server would park it at the end anyway."""
        self._ending = True
        arm = self.phase
        if not isinstance(arm, Fitted):
            return
        if arm.silent:      # nobody would tell when it is done
            arm.send((STOP, encode_command("ARM_PARK")), now)
        elif arm.status.powered or arm.comes_on:
            self._output.say("keep clear: the arm parks, because the driver ends")
            arm.begin(Park(arm.comes_on), now)
        else:
            arm.end_orders("the driver ends")

    def take_commands(self) -> Sequence[bytes]:
        """Return the P2OS packets to send now, and forget them."""
        packets, self._output.packets = self._output.packets, []
        return packets

    def take_notices(self) -> List[Notice]:
        """Return what there is to tell the user, and forget it."""
        notices, self._output.notices = self._output.notices, []
        return notices

    # -- commands

    def power_on(self, now: float) -> ArmOrder:
        """Give the servos power. The arm jumps to its home position: somebody must have asked for it."""
        arm = self._obeying("power on")
        if not arm.status.linked:
            raise RefusedError(
                "power on refused: the arm's controller does not answer. Is its switch on? Then: arm/init")
        self._output.say("keep clear: the arm gets servo power and jumps to its home position")
        return arm.begin(ServoPowerOn(arm.preparation), now)

    def park(self, now: float) -> ArmOrder:
        """Move home and take the power from the servos: the only safe way to switch them off."""
        arm = self._obeying("park")
        return arm.begin(Park(arm.comes_on), now)

    def home(self, now: float) -> ArmOrder:
        """Move all joints home, the gripper, too. Power stays on."""
        arm = self._moving("home")
        return arm.begin(Home(arm.joints), now)

    def init(self, now: float) -> ArmOrder:
        """Make a warm reset, so that the arm's controller is found again."""
        arm = self._obeying("init")
        if arm.status.powered or arm.comes_on:
            raise RefusedError(
                "init refused: it would take the servo power, and the arm would fall down: park it first")
        return arm.begin(Init(arm.preparation), now)

    def move(self, names: Sequence[str], points: Sequence[Point], now: float) -> ArmOrder:
        """Move joints through several positions.

        Raises UsageError when a name, a number or a time is not legal: see `motion.plan`.
        """
        arm = self._moving("motion")
        segments = plan(arm.joints, arm.status.ticks, names, points, self._settings.largest_step)
        return arm.begin(JointMotion(segments, arm.joints), now)

    def stop(self, now: float) -> None:
        """Stop all joints where they are. Power stays on. Nothing is in the way of this, but a missing arm."""
        self._arm("stop").stop("it was stopped", now)

    def hold(self, name: str, reason: str, now: float) -> None:
        """Stop the arm, and refuse all commands but a stop until `release`. ``reason`` is for people."""
        if name not in self._held:
            self._held[name] = reason
            if isinstance(self.phase, Fitted):
                self.phase.stop("it was stopped: %s" % reason, now)

    def release(self, name: str) -> None:
        """Take a hold away. Nothing moves by that."""
        self._held.pop(name, None)

    # -- who may command

    def _arm(self, what: str) -> Fitted:
        """Return the arm. Raises RefusedError or LinkError when there is none."""
        if isinstance(self.phase, Fitted):
            return self.phase
        refused = "%s refused: %s" % (what, self.phase.text)
        raise LinkError(refused) if isinstance(self.phase, Away) else RefusedError(refused)

    def _obeying(self, what: str) -> Fitted:
        """Return the arm if it can obey a command that may move it."""
        arm = self._arm(what)
        if self._ending:
            raise RefusedError("%s refused: the driver ends" % what)
        for reason in self._held.values():
            raise RefusedError("%s refused: %s" % (what, reason))
        if arm.silent:
            raise RefusedError("%s refused: the arm has stopped sending its status" % what)
        if isinstance(arm.present_order, Init):
            raise RefusedError("%s refused: the arm is being reset" % what)
        return arm

    def _moving(self, what: str) -> Fitted:
        """Return the arm if it can move now."""
        arm = self._obeying(what)
        if not arm.status.powered:
            raise RefusedError(
                "%s refused: the servos have no power. Keep clear of the arm, then: arm/power true" % what)
        order = arm.present_order
        if isinstance(order, (ServoPowerOn, Park)):
            raise RefusedError("%s refused: %s is under way" % (what, order.name))
        return arm

    def _found(self, arm: Fitted, now: float) -> None:
        """Begin with an arm. If its controller does not answer, make a warm reset, once."""
        self.phase = arm
        self._output.say("found an arm, version %s, with %d joints" % (arm.version, len(arm.joints)), False)
        for problem in arm.problems:
            self._output.say(problem)
        if arm.status.powered:
            self._output.say("the arm has servo power already; nobody has asked this driver for it")
        if arm.status.linked or arm.status.powered:     # a reset would take the power, and the arm would fall down
            arm.send(arm.preparation, now)
        else:
            arm.begin(Init(arm.preparation), now)

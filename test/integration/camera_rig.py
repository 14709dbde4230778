"""A camera's session and a simulated camera in one simulated time: at a port of its own, or at a robot. No clock."""

from simulated_time import LIMIT, Rig

from pioneer_control.client.events import PacketReceived
from pioneer_control.ptz import AuxCamera, Cabling, CameraPhase, CameraSession, CameraSettings
from pioneer_control.simulator.hardware.camera import SimulatedCamera

STEP = 0.02


class CameraRig:
    """What both rigs have in common. ``camera`` is the simulated camera, ``session`` its client, ``heard`` the commands
    that the session sent, as hex without begin, number and end.
    """

    def __init__(self, kind="vcc4", answers=True, **settings):
        self.held = False
        self.session = CameraSession(CameraSettings(model=kind, **settings), lambda: self.held)
        self.camera = SimulatedCamera(kind, answers)
        self.now = 0.0
        self.heard = []
        take, self.camera.device = self.camera.device, lambda data: take(self._note(data))

    def _note(self, data):
        self.heard.append(data[4:-1].hex(" "))
        return data

    def run(self, seconds):
        end = self.now + seconds - STEP / 2
        self.until(lambda: self.now >= end)
        return self

    def until(self, condition):
        """Let time pass until a condition holds. Return the seconds."""
        start = self.now
        while not condition():
            assert self.now - start < LIMIT, "not within %g s: %s" % (LIMIT, self.session.report)
            self.step()
        return self.now - start

    def ready(self):
        self.until(lambda: self.session.phase is CameraPhase.READY and not self.session.report.is_moving)
        return self

    def rests(self):
        """Wait until the session knows that the camera rests. Return pan, tilt, zoom as it reports them."""
        self.until(lambda: not self.session.report.is_moving)
        report = self.session.report
        return report.pan, report.tilt, report.zoom

    @property
    def true_place(self):
        return self.camera.pan.position, self.camera.tilt.position, self.camera.zoom.position


class DirectRig(CameraRig):
    """A camera on a port of its own."""

    def __init__(self, **options):
        super().__init__(**options)
        self._arrived = b""
        self.camera.put = self._put
        self.session.line_up(self.now)

    def _put(self, data):
        self._arrived += data

    def step(self):
        for exchange in self.session.take_output():
            self.camera.device(exchange.data)
        self.now += STEP
        self.camera.step(round(self.now * 1e6))
        arrived, self._arrived = self._arrived, b""
        if arrived:
            self.session.receive(arrived, self.now)
        self.session.tick(self.now)


class AuxRig(CameraRig):
    """A camera at an auxiliary port of a robot, whose driver has motors on."""

    def __init__(self, port=1, **options):
        super().__init__(**options)
        self.robot = Rig()
        self.camera.join(self.robot.firmware.hardware.aux[port - 1], port)
        self.device = AuxCamera(self.session, port)
        self.now, self._events = self.robot.now, len(self.robot.events)
        self.sent = []
        self.device.connected(self.robot.session.connected.identity, self.now)

    def step(self):
        for command in self.device.take_commands():
            self.sent.append(command)
            self.robot.session.connected.command(self.now, command)
        self.robot.step()
        self.now = self.robot.now
        for event in self.robot.events[self._events:]:
            if isinstance(event, PacketReceived):
                self.device.packet(event.packet, self.now)
        self._events = len(self.robot.events)
        if self.now >= self.device.due:
            self.device.tick(self.now)


RIGS = (DirectRig, AuxRig)
ONE_WAY = dict(answers=False, cabling=Cabling.ONE_WAY)

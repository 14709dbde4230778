"""A simulated camera with its client's end of the line, in simulated time. There is no robot."""

from pioneer_control.simulator.hardware.camera import CameraNumbers, SimulatedCamera
from pioneer_control.vcc4 import ANSWER_BEGIN, CameraDecoder, answer_values, decode_answer, encode_camera_command

STEP_US = 20000


class BenchCamera:
    """A camera, and what it has said. ``camera`` is the camera."""

    def __init__(self, kind="vcc4", ready=False, **options):
        self.heard = b""
        self.camera = SimulatedCamera(kind, numbers=CameraNumbers(starts_ready=ready), put=self._put, **options)
        self.now_us = 0

    def _put(self, data):
        self.heard += data

    def run(self, seconds):
        """Let time pass. Return what the camera said meanwhile."""
        self.heard = b""
        for _ in range(round(seconds * 1e6) // STEP_US):
            self.now_us += STEP_US
            self.camera.step(self.now_us)
        return self.heard

    def send(self, data):
        """Send bytes, and return what the camera says within 0.3 s."""
        self.camera.device(data)
        return self.run(0.3)

    def say(self, name, *values):
        """Send a command. Return its error digit, and the values of its answer."""
        frame, = CameraDecoder(ANSWER_BEGIN).feed(self.send(encode_camera_command(name, *values)))
        answer = decode_answer(frame)
        return "%X" % answer.kind if answer.kind else answer_values(name, answer)

    def set_up(self):
        """Start it as the manual says, and return it."""
        assert self.say("CONTROL", 0) == self.say("POWER", 1) == self.say("INITIALISE", 0) == ()
        self.run(3.0)
        assert self.say("TILT_RANGE", -267, 782) == ()
        return self

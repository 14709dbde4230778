"""What a user asks of a camera. Checked once; each number then has its meaning."""

import enum
from dataclasses import dataclass

from ..errors import ParameterError
from ..vcc4 import CAMERA_MODELS, CameraModel


class Cabling(enum.Enum):
    """Whether the camera's answers reach us. Many robots were wired without the line that makes it answer."""

    AUTO = "auto"
    """Find out: any answer means two-way."""
    TWO_WAY = "two_way"
    ONE_WAY = "one_way"
    """It obeys and says nothing. So what it does is not known."""


@dataclass(frozen=True)
class CameraSettings:
    """The settings of a camera.

    Attributes:
        model: a key of `CAMERA_MODELS`.
        cabling: whether it answers.
        inverted: it hangs upside down. Then pan and tilt are negated for it.
        power_off_at_end: it is switched off at the end.
        pan_speed, tilt_speed: how fast it turns (counts a second).

    Raises:
        ParameterError: a value is not legal. The message names it, and what is.
    """

    model: str = "vcc4"
    cabling: Cabling = Cabling.AUTO
    inverted: bool = False
    power_off_at_end: bool = False
    pan_speed: int = 800
    tilt_speed: int = 613

    def __post_init__(self) -> None:
        if self.model not in CAMERA_MODELS:
            raise ParameterError("camera, model %r: legal is one of %s" % (self.model, ", ".join(CAMERA_MODELS)))
        for name, (low, high) in (("pan_speed", self.camera_model.pan_speed),
                                  ("tilt_speed", self.camera_model.tilt_speed)):
            if not low <= getattr(self, name) <= high:
                raise ParameterError("camera, %s %r: legal is %d to %d counts of 0.1125 degrees a second"
                                     % (name, getattr(self, name), low, high))

    @property
    def camera_model(self) -> CameraModel:
        """What its model can do."""
        return CAMERA_MODELS[self.model]

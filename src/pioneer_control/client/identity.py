"""What the robot says it is, joined with what the table of models knows about it."""

import math
from dataclasses import dataclass, replace
from typing import Optional

from .. import p2os
from ..robots import RobotModel

DEFAULT_WATCHDOG = 2.0      # s, of firmware that does not report its own (ARCOS manual)
DEFAULT_SIP_CYCLE = 0.1     # s, likewise (protocol 2.3)
CONFIG = p2os.encode_command("CONFIG", 1)
"""Asks the robot for CONFIGpac."""


@dataclass(frozen=True)
class RobotIdentity:
    """Name, model and limits of a connected robot.

    ``name``, ``type``, ``subtype`` come from the SYNC2 reply; ``firmware`` and ``serial`` from CONFIGpac (None when the
    robot never sent one). ``model`` is the table's entry with the sonar arrays and bumpers that CONFIGpac says are
    fitted. ``max_linear`` (m/s) and ``max_angular`` (rad/s) are what set_velocity() clamps to: the smallest of the
    robot's own working and hard limits (CONFIGpac, else the table) and what the user allows.
    """

    name: str
    type: str
    subtype: str
    firmware: Optional[str]
    serial: Optional[str]
    model: RobotModel
    has_gripper: bool
    max_linear: float
    max_angular: float
    watchdog: float = DEFAULT_WATCHDOG
    """s without a command after which the robot stops by itself."""
    sip_cycle: float = DEFAULT_SIP_CYCLE
    """Time (s) between two SIPs."""
    config: Optional[p2os.Config] = None
    """CONFIGpac as it came, for all that has no field of its own here."""


def identify(
    reply: p2os.SyncReply,
    model: RobotModel,
    config: Optional[p2os.Config],
    max_linear: Optional[float] = None,
    max_angular: Optional[float] = None,
    has_gripper: Optional[bool] = None,
) -> RobotIdentity:
    """Join the robot's own words with the model.

    The robot's words win over the model. The user's limits (m/s, rad/s) and ``has_gripper`` win over both.
    """
    identity = RobotIdentity(
        name=reply.name,
        type=reply.type,
        subtype=reply.subtype,
        firmware=None,
        serial=None,
        model=model,
        has_gripper=False,
        max_linear=model.max_linear,
        max_angular=model.max_angular,
    )
    if config is not None:
        identity = replace(
            identity,
            firmware=config.firmware_version or None,
            serial=config.serial or None,
            model=_fitted(model, config),
            has_gripper=bool(config.has_gripper),
            max_linear=_least(0.001, model.max_linear, config.translation_velocity_max_mm_s,
                              config.translation_velocity_top_mm_s),
            max_angular=_least(math.radians(1), model.max_angular, config.rotation_velocity_max_deg_s,
                               config.rotation_velocity_top_deg_s),
            watchdog=_least(0.001, DEFAULT_WATCHDOG, config.watchdog_ms),
            sip_cycle=_least(0.001, DEFAULT_SIP_CYCLE, config.sip_cycle_ms),
            config=config,
        )
    return replace(
        identity,
        has_gripper=identity.has_gripper if has_gripper is None else has_gripper,
        max_linear=identity.max_linear if max_linear is None else min(identity.max_linear, max_linear),
        max_angular=identity.max_angular if max_angular is None else min(identity.max_angular, max_angular),
    )


def _least(unit: float, otherwise: float, *values: Optional[int]) -> float:
    """The least of these numbers of CONFIGpac in SI; ``otherwise`` when older firmware left them out or empty."""
    return min((value * unit for value in values if value), default=otherwise)


def _fitted(model: RobotModel, config: p2os.Config) -> RobotModel:
    """The model with the bumpers and sonar arrays that the robot reports.

    A robot that reports neither array does not say which it has: then the model's arrays stay.
    """
    if config.front_bumpers is not None and config.rear_bumpers is not None:
        model = replace(model, front_bumpers=config.front_bumpers, rear_bumpers=config.rear_bumpers)
    front, rear = bool(config.front_sonar), bool(config.rear_sonar)
    return model.with_arrays(front, rear) if front or rear else model

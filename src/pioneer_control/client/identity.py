"""Joins what the robot reports about itself with its entry in the table of models."""

import math
from dataclasses import dataclass, replace
from typing import Optional

from .. import p2os
from ..robots import RobotModel

DEFAULT_WATCHDOG = 2.0      # s, of firmware that does not report its own (ARCOS manual)
DEFAULT_SIP_CYCLE = 0.1     # s, of firmware that does not report its own (protocol 2.3)
CONFIG = p2os.encode_command("CONFIG", 1)
"""The packet that asks the robot for CONFIGpac."""


@dataclass(frozen=True)
class RobotIdentity:
    """Name, model and limits of a connected robot.

    ``name``, ``type``, ``subtype`` come from the SYNC2 reply. ``firmware`` and ``serial`` come from CONFIGpac; they are
    None when CONFIGpac does not have them. ``model`` is the entry in the table of models, with the sonar arrays and
    bumpers that CONFIGpac reports. ``max_linear`` (m/s) and ``max_angular`` (rad/s) are the limits of set_velocity():
    the smallest of the robot's present and hard limits (from CONFIGpac, else from the table) and the user's limits.
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
    """Time (s) without a command after which the robot stops by itself."""
    sip_cycle: float = DEFAULT_SIP_CYCLE
    """Time (s) between two SIPs."""
    config: Optional[p2os.Config] = None
    """The whole CONFIGpac, for values that have no field here; None when the robot never sent one."""


def identify(
    reply: p2os.SyncReply,
    model: RobotModel,
    config: Optional[p2os.Config],
    max_linear: Optional[float] = None,
    max_angular: Optional[float] = None,
    has_gripper: Optional[bool] = None,
) -> RobotIdentity:
    """Return the identity of a robot, from its SYNC2 reply, its model and its CONFIGpac (None when none came).

    Values in CONFIGpac replace those of the model. The user's limits ``max_linear`` (m/s) and ``max_angular`` (rad/s)
    can only lower the robot's limits. The user's ``has_gripper`` replaces what the robot reports, unless it is None.
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
    """Return the least of ``values`` of CONFIGpac, times ``unit``; ``otherwise`` when all of them are None or 0.

    ``unit`` is one unit of CONFIGpac in SI.
    """
    return min((value * unit for value in values if value), default=otherwise)


def _fitted(model: RobotModel, config: p2os.Config) -> RobotModel:
    """Return the model with the bumpers and sonar arrays that CONFIGpac reports.

    When CONFIGpac reports no sonar array at all, the model keeps its own arrays.
    """
    if config.front_bumpers is not None and config.rear_bumpers is not None:
        model = replace(model, front_bumpers=config.front_bumpers, rear_bumpers=config.rear_bumpers)
    front, rear = bool(config.front_sonar), bool(config.rear_sonar)
    return model.with_arrays(front, rear) if front or rear else model

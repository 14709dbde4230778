"""What there is to tell of an arm in the diagnostics of a robot (REP 107)."""

import math
from typing import Dict

from ..client.fault_flags import Level
from ..client.health import Finding
from .phases import Asking, Fitted
from .session import ArmSession

LEVELS = {"silent": Level.ERROR, "none": Level.WARN, "not connected": Level.WARN, "no link": Level.STALE}
"""Level of each condition that is not OK."""


def finding(session: ArmSession, now: float) -> Finding:
    """Return the diagnostics of an arm at a time (monotonic, s)."""
    phase = session.phase
    level, text = LEVELS.get(phase.condition, Level.OK), phase.text
    if not isinstance(phase, Fitted):
        is_unclear = isinstance(phase, Asking) and phase.is_unclear
        return Finding(Level.WARN if is_unclear else level, text, {})
    order = phase.order
    if order is not None and order.problem:
        level, text = max(level, Level.WARN), "%s; last %s failed: %s" % (text, order.name, order.problem)
    if phase.problems:
        level, text = max(level, Level.WARN), "; ".join([text, *phase.problems])
    values: Dict[str, str] = {
        "Version": phase.version,
        "Layout of its status": phase.reader.layout or "not known yet",
        "Connected": str(phase.status.linked),
        "Servo power": str(phase.status.powered),
        "Moving": ", ".join(joint.name for joint in phase.joints.values()
                            if phase.status.moving[joint.number - 1]) or "none",
        "Age of its status": "%.1f s" % (now - phase.heard),
    }
    for name, at in (("Parks by itself in", phase.timers.parks_at), ("Opens its gripper in", phase.timers.opens_at)):
        values[name] = "never" if at == math.inf else "%.0f s" % max(0.0, at - now)
    return Finding(level, text, values)

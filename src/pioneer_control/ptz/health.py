"""How a camera is, as a task of the diagnostics (REP 107). Pure; the time is an argument."""

from typing import Dict

from ..client.fault_flags import Level
from ..client.health import Finding
from ..vcc4 import degrees_of
from .session import CameraPhase, CameraReport
from .settings import Cabling

OLD_ANSWER = 10.0
"""Age (s) of the last answer of a camera that answers, above which there is a warning. It is asked every 2 s."""
CABLINGS = {
    Cabling.AUTO: "not known yet",
    Cabling.TWO_WAY: "two-way: it answers",
    Cabling.ONE_WAY: "one-way: it never answers",
}
LEVELS: Dict[CameraPhase, Level] = {
    CameraPhase.NO_LINE: Level.ERROR,
    CameraPhase.STARTING: Level.OK,
    CameraPhase.READY: Level.OK,
    CameraPhase.SWITCHING_OFF: Level.OK,
    CameraPhase.OFF: Level.OK,
    CameraPhase.FAILED: Level.ERROR,
    CameraPhase.ENDED: Level.STALE,
}


def find_camera(report: CameraReport, port: str, now: float) -> Finding:
    """Return the finding of the task Camera.

    Args:
        report: what is known of the camera.
        port: where it is, as the user gave it.
        now: the present time (s, monotonic).
    """
    age = None if report.answered_at is None else now - report.answered_at
    level, text = LEVELS[report.phase], report.problem
    if report.phase is CameraPhase.READY and report.cabling is Cabling.ONE_WAY:
        level, text = Level.WARN, ("no answers: it is wired without the line for them, or it is not there; it is told"
                                   " what to do, and nobody knows whether it does")
    elif report.phase is CameraPhase.READY and age is not None and age > OLD_ANSWER:
        level, text = Level.WARN, "it has not answered for %.0f s" % age
    elif report.phase is CameraPhase.READY:
        text = "ready, says where it looks" if report.is_measured else "ready, has not said yet where it looks"
    return Finding(level, text, {
        "Port": port,
        "Cabling": CABLINGS[report.cabling],
        "Power": {None: "not known", True: "on", False: "off"}[report.has_power],
        "Pan (deg, to the right)": "not known" if report.pan is None else "%.1f" % degrees_of(report.pan),
        "Tilt (deg, upwards)": "not known" if report.tilt is None else "%.1f" % degrees_of(report.tilt),
        "Zoom (0 to 1960)": "not known" if report.zoom is None else str(report.zoom),
        "Age of the last answer (s)": "there was none" if age is None else "%.1f" % age,
        "Answers": str(report.answers),
        "Commands that were sent again": str(report.repeated),
        "Stray bytes": str(report.stray_bytes),
        "Last error": report.last_error or "none",
    })

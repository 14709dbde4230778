"""``python3 -m pioneer_control.client PORT``: print which robot is on that port, and its state. Nothing moves."""

import argparse
import math
import signal
import sys
from typing import List, Optional

from .. import p2os
from ..errors import PioneerError, UsageError
from .gripper import GripperReading
from .identity import RobotIdentity
from .robot import LinkCounts, Robot
from .state import NO_ECHO, RobotState, SonarRange

SONAR_ROUND = 0.7       # s in which every sonar has fired twice: eight per array, one every 40 ms


def main(arguments: Optional[List[str]] = None) -> int:
    """Connect to the robot, read its state, disconnect, and print a report.

    Returns the exit code: 0 when the report was printed, 1 without a robot or port, 2 for a wrong argument or an
    unknown model, 130 after Ctrl-C.
    """
    parser = argparse.ArgumentParser(prog="python3 -m pioneer_control.client",
                                     description="Say what robot is on a port. Nothing moves.")
    parser.add_argument("port", metavar="PORT", help="/dev/ttyUSB0, the path of a pty, socket://host:port, or "
                                                     "ws://host:port/path#key=KEY")
    parser.add_argument("--baud", type=int, default=9600,
                        help="line speed of a serial port (default: %(default)s); the others follow")
    parser.add_argument("--model", help="take it for this model, whatever it says it is")
    parser.add_argument("--models-file", metavar="FILE", help="a models file that overrides or adds robot models")
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        with Robot(options.port, baud=options.baud, model=options.model, models_file=options.models_file) as robot:
            state = robot.wait_for_state()
            until = state.time + SONAR_ROUND
            while state.time < until:
                state = robot.wait_for_state()
            identity, link = robot.wait_until_ready(), robot.link
    except KeyboardInterrupt:
        return 130
    except PioneerError as error:
        print("client: %s" % error, file=sys.stderr)
        return 2 if isinstance(error, UsageError) else 1
    print(report(robot.url, identity, state, link))
    return 0


def report(port: str, identity: RobotIdentity, state: RobotState, link: LinkCounts) -> str:
    """Return the report as text, one line for each property of the robot. Empty properties have no line."""
    model, config = identity.model, identity.config
    alarm = " (alarm at %.1f V)" % (config.low_battery_dv / 10) if config is not None and config.low_battery_dv else ""
    charge = "" if state.state_of_charge is None else ", %.0f %%" % (100 * state.state_of_charge)
    stalled = [side for side, holds in (("left", state.left_stall), ("right", state.right_stall)) if holds]
    faults = [str(flag.name) for flag in p2os.FaultFlags if state.fault_flags and flag & state.fault_flags]
    ranges = ["%d:%s" % (each.number, _range(state.sonar[each.number])) for each in model.sonar]
    front, rear = state.front_bumpers, state.rear_bumpers
    bumpers = "%d front, %d rear, %d pressed" % (len(front), len(rear), sum(front + rear)) if front + rear else ""
    rows = (
        ("port", port),
        ("name", identity.name or "(none)"),
        ("model", "%s (says %s %s)" % (model.subtype, identity.type, identity.subtype)),
        ("firmware", "%s %s" % (model.firmware_family, identity.firmware or "(does not report its version)")),
        ("serial", identity.serial),
        ("limits", "%.2f m/s, %.0f deg/s; stops by itself after %.1f s without a command" % (
            identity.max_linear, math.degrees(identity.max_angular), identity.watchdog)),
        ("battery", "%.1f V%s%s" % (state.battery_voltage, charge, alarm)),
        ("motors", "on" if state.motors_enabled else "off"),
        ("STOP button", "PRESSED: motors stay off until it is released" if state.stop_button else "released"),
        ("stalled", " and ".join(stalled)),
        ("faults", ", ".join(faults)),
        ("sonar", "%s; m: %s" % ("on" if state.sonar_enabled else "off", " ".join(ranges)) if ranges else "none"),
        ("gripper", _gripper(state.gripper)),
        ("bumpers", bumpers),
        ("link", "%d packets, %d bad checksums, %d bytes discarded" % (
            link.sips, link.bad_checksums, link.discarded_bytes)),
    )
    return "\n".join("%-12s %s" % row for row in rows if row[1])


def _range(heard: Optional[SonarRange]) -> str:
    return "?" if heard is None else "-" if heard.range >= NO_ECHO else "%.2f" % heard.range


def _gripper(gripper: Optional[GripperReading]) -> str:
    if gripper is None:
        return "none"
    paddles = _first_true(moving=gripper.paddles_moving, open=gripper.paddles_open, closed=gripper.paddles_closed)
    lift = _first_true(moving=gripper.lift_moving, up=gripper.lift_up, down=gripper.lift_down)
    broken = [name for name, beam in (("inner", gripper.inner_beam), ("outer", gripper.outer_beam)) if beam]
    beams = " and ".join(broken) + " broken" if broken else "clear"
    return "paddles %s, lift %s, beams %s" % (paddles, lift, beams)


def _first_true(**states: bool) -> str:
    return next((name for name, so in states.items() if so), "in between")


if __name__ == "__main__":
    sys.exit(main())

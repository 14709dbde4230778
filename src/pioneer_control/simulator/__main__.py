"""A simulated robot on the command line, without ROS: ``python3 -m pioneer_control.simulator --tcp 8101``."""

import argparse
import signal
import sys
import threading
from typing import List, Optional

from ..errors import PioneerError
from ..robots import find_model
from .firmware import Firmware
from .loading import known_worlds, load_world
from .robot_numbers import load_numbers
from .server import STANDARD_PORT, Server


def main(arguments: Optional[List[str]] = None) -> int:
    """Run until Ctrl-C or SIGTERM. Returns the exit code: 0 ended, 1 something failed, 2 something makes no sense."""
    options = parser().parse_args(arguments)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    try:
        firmware = Firmware(
            find_model(options.model, options.models),
            load_world(options.world),
            gripper=options.gripper,
            rear_sonar=options.rear_sonar,
            name=options.name,
            seed=options.seed,
            noise=options.noise,
            numbers=load_numbers(options.numbers),
        )
        server = Server(firmware, options.tcp, options.pty)
    except PioneerError as error:
        print(f"simulator: {error}", file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 1
    with server:
        print(f"A simulated {firmware.model.subtype} stands in the world {firmware.world.name!r}. Connect to it at")
        for place in (server.url, server.pty_link):
            if place is not None:
                print(f"    {place}")
        print("Ctrl-C ends it.", flush=True)
        while server.running and not stop.wait(0.2):
            pass
        return 0 if stop.is_set() else 1


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog="python3 -m pioneer_control.simulator", description="A simulated Pioneer that speaks P2OS.",
        epilog=f"Worlds: {', '.join(known_worlds())}.",
    )
    add = result.add_argument
    add("--model", default="p3dx-sh", help="robot model, by its subtype (default: %(default)s)")
    add("--world", default="tutorial", help="name of a world, or path of a world file (default: %(default)s)")
    add("--tcp", metavar="PORT", help=f"TCP port, 0 for any free one, or HOST:PORT (default: {STANDARD_PORT}, unless --pty is given)")
    add("--pty", metavar="LINK", help="make a pseudo-terminal, and this link to it")
    add("--seed", type=int, default=0, help="of the noise (default: %(default)s)")
    add("--noise", type=float, metavar="M", help="sonar ranges are off by up to this much (default: as robot.yaml says)")
    fitted = result.add_mutually_exclusive_group()
    fitted.add_argument("--gripper", action="store_true", default=None, help="fit a gripper (default: on a p3dx-sh)")
    fitted.add_argument("--no-gripper", action="store_false", dest="gripper", help="fit no gripper")
    add("--no-rear-sonar", action="store_false", dest="rear_sonar", help="fit no rear sonar array")
    add("--name", default="sim_0001", help="the robot's own name (default: %(default)s)")
    add("--models", metavar="FILE", help="a models file that overrides or adds robot models")
    add("--numbers", metavar="FILE", help="a file that overrides numbers of robot.yaml")
    return result


if __name__ == "__main__":
    sys.exit(main())

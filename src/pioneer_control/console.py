"""The console commands of the wheel. Each does what ``python3 -m`` or rosrun does, with the same options and words.

==================  ========================================  ====================================
command             without it                                under ROS
==================  ========================================  ====================================
pioneer-simulator   python3 -m pioneer_control.simulator      the same
pioneer-client      python3 -m pioneer_control.client         the same
p2os-explain        python3 -m pioneer_control.p2os           the same
pioneer-report      python3 -m pioneer_control.web.one_file   rosrun pioneer_control draw_run
==================  ========================================  ====================================

Each function returns the exit code. It imports when it is called: each command needs libraries of its own.
"""

import functools
import sys
from typing import Callable

from . import interrupt  # noqa: F401  # from here on Ctrl-C is no error

LIBRARIES = {"numpy": "numpy", "PIL": "Pillow", "matplotlib": "matplotlib", "serial": "pyserial", "yaml": "PyYAML",
             "websocket": "websocket-client"}
"""Names under which pip knows the libraries that the commands use."""


def command(function: Callable[[], int]) -> Callable[[], int]:
    """Make a command say which library is missing, in place of a traceback."""
    @functools.wraps(function)
    def run() -> int:
        try:
            return function()
        except ModuleNotFoundError as error:
            if error.name not in LIBRARIES:
                raise
            print("the library %s is missing: pip install %s" % (error.name, LIBRARIES[error.name]), file=sys.stderr)
            return 1
    return run


@command
def simulator() -> int:
    """Serve simulated robots: ``pioneer-simulator --tcp 8101``."""
    from .simulator.__main__ import main
    return main()


@command
def client() -> int:
    """Say which robot is on a port: ``pioneer-client socket://localhost:8101``."""
    from .client.__main__ import main
    return main()


@command
def explain() -> int:
    """Explain bytes of the protocol: ``p2os-explain FA FB 03 00 00 00``."""
    from .p2os.__main__ import main
    return main()


@command
def report() -> int:
    """Draw a recorded run: ``pioneer-report RUN.bag``, or ``pioneer-report --html RUN.bag``."""
    from .web.one_file import draw_run
    return draw_run(sys.argv[1:], "pioneer-report")

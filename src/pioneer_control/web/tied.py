"""Runs a program as a child that ends with its parent: ``python3 -m pioneer_control.web.tied MODULE [ARGUMENTS ...]``.

The parent gives a pipe as standard input and writes nothing to it. When the parent is gone, also by a kill, the pipe is
closed, and the program gets SIGTERM.
"""

import os
import runpy
import signal
import sys
import threading


def wait_for_the_end() -> None:
    """Wait until standard input is closed, then send SIGTERM to this process."""
    while os.read(0, 4096):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    threading.Thread(target=wait_for_the_end, daemon=True).start()
    del sys.argv[0]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)

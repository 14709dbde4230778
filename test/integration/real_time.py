"""Waiting in real time. Tests wait for a condition, never for a fixed time, so they also pass on a slow machine."""

import time

LIMIT = 30.0        # s: generous; nothing waits that long


def until(condition, what):
    """Wait until ``condition()`` is true, and return its value. Raises AssertionError that names what did not happen.
    """
    end = time.monotonic() + LIMIT
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < end, "not within %.0f s: %s" % (LIMIT, what)
        time.sleep(0.005)


def keep_commanding(robot, command, condition):
    """Give a command with every state of a client's robot until a condition of the state holds."""
    end = time.monotonic() + LIMIT
    while not condition(robot.state):
        assert time.monotonic() < end, robot.state
        command()
        robot.wait_for_state()

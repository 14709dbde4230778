"""Tests read the package from this source tree, and the generated messages from a sourced workspace, if any."""

import os
import pathlib
import sys

import hypothesis

SOURCE = str(pathlib.Path(__file__).resolve().parents[1] / "src")

sys.path.insert(0, SOURCE)

import pioneer_control

# catkin generates pioneer_control.msg next to a relay of this package: let both be one package.
pioneer_control.__path__.extend(
    folder for folder in (os.path.join(entry, "pioneer_control") for entry in sys.path[1:])
    if os.path.isfile(os.path.join(folder, "msg", "__init__.py")))

# The same examples in every run, however slow the machine: what searches for something new belongs into a bench, not
# into continuous integration.
hypothesis.settings.register_profile("fixed", derandomize=True, database=None, deadline=None, max_examples=200,
                                     suppress_health_check=list(hypothesis.HealthCheck))
hypothesis.settings.load_profile("fixed")

# Programs that tests start find the package too; a sourced workspace's relay, which has the messages, goes first.
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), SOURCE]))

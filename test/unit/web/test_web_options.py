"""What the options of the page's program ask of the simulator."""

import threading

import pytest

from pioneer_control.errors import UsageError
from pioneer_control.web import __main__ as web


class Asked(Exception):
    """The simulator would start now."""


@pytest.mark.parametrize("words", [[], ["--class", "3"]])
def test_wheels_and_sonar_err_as_real_ones_do_where_they_are_wanted(words, monkeypatch):
    def ask(truth, *options):
        raise Asked(options)

    monkeypatch.setattr(web, "simulator_process", ask)
    for more, wanted in ([], False), (["--real"], True):
        with pytest.raises(Asked) as caught:
            web.serve(web.parser().parse_args(words + more), threading.Event())
        assert ("--real" in caught.value.args[0]) is wanted


def test_real_robots_are_not_made_more_real():
    with pytest.raises(UsageError, match="--real is for simulated robots"):
        web.serve(web.parser().parse_args(["--real", "/dev/ttyUSB0"]), threading.Event())

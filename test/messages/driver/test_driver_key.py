"""A driver whose port has a key: the client gets it, and no log, no diagnostics and no bag."""

import pytest

import pioneer_control.driver.node as node_module
from pioneer_control.client import HelmState, LinkCounts
from pioneer_control.driver.diagnostics import Diagnostics

from bottle import Bottle

URL, KEY = "ws://teacher:8080/robot/7", "sesame123"


def test_a_key_in_the_port_opens_it_and_is_shown_nowhere(monkeypatch):
    told = []

    def script(bottle):
        yield 0.3
        bottle.unplug()
        yield 1.0
        bottle.plug_in()
        yield 3.0

    def before(bottle):
        quiet = node_module.Diagnostics()

        def diagnostics(*arguments):
            told.append(arguments)
            return quiet

        monkeypatch.setattr(node_module, "Diagnostics", diagnostics)

    run = Bottle(monkeypatch, script, before=before, port="%s#key=%s" % (URL, KEY))
    assert run.keys == {KEY} and {url for url, _ in run.opened} == {URL}
    said = [text for _, text in run.said]
    assert any(URL in text for text in said) and not any(KEY in text for text in said)
    assert told[0][0] == URL


@pytest.mark.parametrize("port, baud", [("/dev/ttyUSB0", "9600"), ("socket://robot:1", None), (URL, None)])
def test_diagnostics_show_the_port_and_no_speed_of_a_line_that_has_none(port, baud):
    counts = LinkCounts(0, 0, 0, 0, 0, 0, 0, 0, None)
    diagnostics = Diagnostics(port, 9600, "enable", {}, lambda: counts, HelmState)
    values = dict(diagnostics._health.report(0.0, counts)["Link"].values)
    assert values["Port"] == port and values.get("Baud") == baud

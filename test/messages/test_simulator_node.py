"""The end of the simulator's node, without a master."""

import threading
import types

import pytest

from pioneer_control.simulator import node as simulator_node


class Ending:
    """A node that ends, with one robot, on a clock that only naps move on. `closes_after`: naps until it hangs up."""

    def __init__(self, monkeypatch, closes_after):
        self.naps, self._closes_after = [], closes_after
        self._robot = types.SimpleNamespace(open_session=object() if closes_after else None)
        monkeypatch.setattr(simulator_node, "time", types.SimpleNamespace(
            sleep=self._nap, monotonic=lambda: sum(self.naps)))
        node = object.__new__(simulator_node.Node)
        node._server = types.SimpleNamespace(lock=threading.Lock())
        node._simulation = types.SimpleNamespace(robots=[self._robot])
        node._let_clients_close()

    def _nap(self, seconds):
        self.naps.append(seconds)
        if len(self.naps) == self._closes_after:
            self._robot.open_session = None


@pytest.mark.parametrize("closes_after", [0, 1, 3])
def test_it_serves_on_until_its_clients_have_closed(monkeypatch, closes_after):
    """The driver took the loss of its line at Ctrl-C for an accident, when the simulator was the first to end."""
    assert len(Ending(monkeypatch, closes_after).naps) == closes_after


def test_but_not_for_long(monkeypatch):
    served_on = sum(Ending(monkeypatch, 1000).naps)
    assert simulator_node.CLOSING <= served_on < simulator_node.CLOSING + simulator_node.PERIOD

"""The addresses under which others reach the page."""

import socket

import pytest

from pioneer_control.web import site
from pioneer_control.web.site import addresses_of, own_addresses


class NoRoute(socket.socket):
    """A socket of a computer that has no way to the internet."""

    def connect(self, address):
        raise OSError(101, "Network is unreachable")


def test_the_address_of_an_interface():
    assert addresses_of("lo") == ["127.0.0.1"]
    assert addresses_of("no-such-one") == []


@pytest.mark.parametrize("found, expected", [
    (["10.77.0.1"], ["10.77.0.1"]), ([], ["teachers-laptop"]), (["127.0.0.1"], ["teachers-laptop"])])
def test_without_a_way_to_the_internet_the_addresses_are_those_of_the_interfaces(monkeypatch, found, expected):
    monkeypatch.setattr(socket, "socket", NoRoute)
    monkeypatch.setattr(socket, "if_nameindex", lambda: [(1, "cable")])
    monkeypatch.setattr(socket, "gethostname", lambda: "teachers-laptop")
    monkeypatch.setattr(site, "addresses_of", lambda interface: found)
    assert own_addresses() == expected
